/* Reads   guides, the noisy signal.
   Writes  its normalised hit distances, with those filled in that were not sampled (0).
   For renderers that trace one of two lobes per pixel: the pixels around on the same surface did trace it. Only the hit distance is
   guessed; radiance 0 of a lobe that was not traced is a sample like any other. First, for all that is guided by hit distances.
   push.iteration: 0 the diffuse lobe, 1 the specular one. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"

layout(binding = 1) uniform sampler2D in_normal_roughness;
layout(binding = 2) uniform sampler2D in_view_z;
layout(binding = 3) uniform sampler2D in_radiance_hit_dist;
layout(binding = 4, r16f) uniform writeonly image2D out_hit_dist;

#define TILES 5
#include "../common/tiles.glsl"

const int REACH = 2;              /* pixels */
const int SIDE = 8 + 2 * REACH;
const float FALLOFF = 0.24;       /* of the weights, 2^-x per squared pixel: to a half at the rim */

shared vec4 s_surface[SIDE * SIDE];     /* world normal, view depth; 0: nothing there */
shared vec2 s_sample[SIDE * SIDE];      /* normalised hit distance, roughness of the lobe */

void load_cell(int cell)
{
    ivec2 pixel = tile * 8 - REACH + ivec2(cell % SIDE, cell / SIDE);
    s_surface[cell] = vec4(0.0);
    s_sample[cell] = vec2(0.0);
    if (!in_rect(pixel)) return;
    float signed_z = texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale;
    if (is_sky(signed_z)) return;
    nrd_surface surface = nrd_decode_normal_roughness(texelFetch(in_normal_roughness, pixel + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT);
    bool specular = (push.iteration | opaque_zero()) != 0u;
    if (specular && is_too_rough(surface.roughness)) return;
    s_surface[cell] = vec4(surface.normal, abs(signed_z));
    s_sample[cell] = vec2(nrd_sanitize_norm_hit_dist(texelFetch(in_radiance_hit_dist, pixel, 0).w), specular ? surface.roughness : 1.0);
}

/* Heavy-tailed: any sample is better than none. */
float tolerant(float distance) { return 1.0 / (1.0 + distance + distance * distance); }

float reconstruct(ivec2 pixel, int center)
{
    vec4 surface = s_surface[center];
    vec2 uv = pixel_uv(pixel), sum = vec2(0.0);
    float roughness = s_sample[center].y, lobe = atan(1.7 * roughness * roughness) + 0.01, roughness_scale = 3.0 / mix(0.01, 1.0, roughness * roughness);
    Plane plane = make_plane(surface.xyz * mat3(g.view_to_world), view_position(uv, surface.w, g.frustum, g.orthographic), uv, g.px_uv.xy, g.frustum,
                             g.orthographic, 1.0 / (g.plane_distance_sensitivity * frustum_size(surface.w)), 1.0);
    int reach = has_flag(NRD_FLAG_WIDE_RECONSTRUCTION) ? REACH : 1;
    for (int y = -reach; y <= reach; y++)
        for (int x = -reach; x <= reach; x++) {
            int cell = center + x + SIDE * y;
            vec4 tap = s_surface[cell];
            vec2 lobe_sample = s_sample[cell];
            float off_plane = abs(plane_distance(plane, vec2(x, y), tap.w));
            if (!(lobe_sample.x > 0.0) || !(off_plane < 1.0)) continue;
            float angle = sqrt(max(2.0 - 2.0 * dot(surface.xyz, tap.xyz), 0.0));
            float w = (1.0 - off_plane) * exp2(-FALLOFF * float(x * x + y * y)) * tolerant(3.0 * angle / lobe)
                    * tolerant(roughness_scale * abs(lobe_sample.y * lobe_sample.y - roughness * roughness));
            sum += w * vec2(lobe_sample.x, 1.0);
        }
    return sum.y > 0.0 ? sum.x / sum.y : 0.0;
}

void process(ivec2 pixel)
{
    for (int cell = int(gl_LocalInvocationIndex); cell < SIDE * SIDE; cell += 64) load_cell(cell);
    barrier();
    ivec2 at = ivec2(gl_LocalInvocationID.xy) + REACH;
    int center = at.x + SIDE * at.y;
    if (!in_rect(pixel) || s_surface[center].w == 0.0) return;
    float hit_dist = s_sample[center].x > 0.0 ? s_sample[center].x : reconstruct(pixel, center);
    imageStore(out_hit_dist, pixel, nrd_round_to_half(vec4(hit_dist)));
}
