/* Reads   guides, penumbrae, the list of tiles, last frame's history.
   Writes  mean visibility, its length and the width of the penumbra, where there is one; reprojected stabilised output.
   Decides which rays lie in a penumbra, and averages those over time. A ray outside of a penumbra is exact: it stays as it has been passed
   on and forgets history, so that contact shadows and umbrae stay what they are. Everything after this pass works on means.
   Penumbra width from the distance to the occluder: R. Fernando, "Percentage-Closer Soft Shadows", SIGGRAPH 2005. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/motion.glsl"
#include "sigma.glsl"

layout(binding = 1) uniform sampler2D in_motion;
layout(binding = 2) uniform sampler2D in_normal_roughness;
layout(binding = 3) uniform sampler2D in_view_z;
layout(binding = 4) uniform sampler2D in_penumbra;
layout(binding = 5) uniform usampler2D history;
#ifdef TRANSLUCENCY
layout(binding = 7, rg32ui) uniform writeonly uimage2D out_mean;
layout(binding = 8) uniform sampler2D in_translucency;
layout(binding = 9) uniform usampler2D history_color;
#else
layout(binding = 7, r32ui) uniform writeonly uimage2D out_mean;
layout(binding = 8, r8) uniform writeonly image2D out_stabilized;
#endif
#include "rays.glsl"
#include "neighborhood.glsl"
#define TILES 6
#define EXACT_TILES
#include "../common/tiles.glsl"

/* Support is looked for around the pixel in 5 x 5 and on a ring of 8: of opposite places one each. */
const int PAIRS = 16;
const ivec2 PAIR[PAIRS] = ivec2[PAIRS](ivec2(-2, 0), ivec2(-1, 0), ivec2(-2, 1), ivec2(-1, 1), ivec2(0, 1), ivec2(1, 1), ivec2(2, 1), ivec2(-2, 2),
                                       ivec2(-1, 2), ivec2(0, 2), ivec2(1, 2), ivec2(2, 2), ivec2(4, 0), ivec2(3, 3), ivec2(0, 4), ivec2(-3, 3));

shared uint s_waiting[64];               /* pixels that may lie in a penumbra: their index in the tile */
shared uint s_waiting_count;

/* Rays that differ by less than this are no sign of a penumbra; what many lights send varies over a surface. */
const float SAME = 0.02;

bool differ(Visibility a, Visibility b)
{
#ifdef TRANSLUCENCY
    return any(greaterThan(abs(a - b), vec3(SAME)));
#else
    return a != b;
#endif
}

/* ---- support */
struct Support {
    float width;     /* half width of the penumbra, px; 0: outside of one */
    Visibility mean; /* of the rays around that lie on the same surface, near in the light's eyes */
    float count;     /* effective number of those rays */
};

/* What decides whether rays around a pixel belong to it. Lengths in pixels: perspective makes those of a ray and those on the screen the same. */
struct Around {
    int centre;          /* index of its ray */
    vec3 across;         /* as in LightFrame */
    vec2 along;
    NearnessPlane plane;
    vec3 occluder;       /* half the distance, along the light, to an occluder that casts half width w = w * x / (y + w * z) */
    float least;         /* half width that is believed, at least: where the horizon of the surface cuts the light in two, rays are blocked by the
                            surface itself at once, and the penumbra is that of the terminator, not of an occluder */
};

const float TERMINATOR_PX = 4.0;   /* least half width there */

Around make_around(int centre, vec3 position_vs, vec3 normal_vs, LightFrame f)
{
    float tolerance = max(g.plane_distance_sensitivity * frustum_size(position_vs.z), 4.0 * DEPTH_ERROR * position_vs.z);
    float light_distance = mix(1.0, distance(g.light.xyz, position_vs), g.light.w), per_pixel = 1.0 / f.pixel;
    Around a;
    a.centre = centre;
    a.across = f.across * (per_pixel * per_pixel);
    a.along = f.along * per_pixel;
    a.plane = make_nearness_plane(f, position_vs.z, tolerance);
    a.occluder = vec3(0.5 * light_distance, g.light_radius, g.light.w * f.pixel);
    a.least = abs(dot(normal_vs, to_light(position_vs, normal_vs))) < g.light_radius / light_distance ? TERMINATOR_PX : 0.0;
    return a;
}

/* Half width of the penumbra at the centre: mean over blocked rays whose penumbra reaches it and whose occluder is not nearer, along the light,
   than twice the way to the centre. Small ones count more, by 1 / (half width + 1 px), because the occluder that is near makes the edge. */
float penumbra_at_centre(Around a, float own)
{
    Visibility own_visibility = ray_visibility(a.centre, own);
    bool lit = own == LIT, supported = false;
    float count = lit ? 0.0 : 1.0, sum = lit ? 0.0 : 1.0 / (own + 1.0), own_reach2 = lit ? -1.0 : (own + 0.5) * (own + 0.5);
    UNROLL for (int i = 0; i < PAIRS; i++) {
        vec2 offset = vec2(PAIR[i]);
        float across2 = across_squared(a.across, offset), along = abs(dot(a.along, offset)) - 1.0, slope = dot(a.plane.at.yz, offset);
        float nearest = along * a.occluder.y, per_width = a.occluder.x - along * a.occluder.z;
        UNROLL for (int side = -1; side <= 1; side += 2) {
            int at = a.centre + side * (PAIR[i].y * SIDE + PAIR[i].x);
            vec2 ray = s_ray[at];
            float width = max(ray.y, a.least), reach = 2.0 * width + 0.5;
            bool on_plane = is_on_plane(a.plane, a.plane.at.x + float(side) * slope, abs(ray.x));
            bool reaches = all(bvec4(on_plane, ray.y != LIT, reach * reach >= across2, width * per_width >= nearest));
            float one = float(reaches);
            count += one;
            sum += one / (width + 1.0);
            bool counts = any(bvec2(reaches, across2 <= own_reach2)), differs = differ(own_visibility, ray_visibility(at, ray.y));
            supported = any(bvec2(supported, all(bvec3(on_plane, counts, differs))));
        }
    }
    return supported ? count / sum - 1.0 : 0.0;
}

void gather_mean(Around a, float own, inout Support s)
{
    float k = max(0.6 * s.width, 0.7), scale = -1.5 * 1.442695 / (k * k), weight = 1.0, squares = 1.0, per_width = 1.0 / s.width;
    Visibility sum = ray_visibility(a.centre, own);
    UNROLL for (int i = 0; i < PAIRS; i++) {
        vec2 offset = vec2(PAIR[i]);
        float near = exp2(scale * across_squared(a.across, offset)), slope = dot(a.plane.at.yz, offset);
        UNROLL for (int side = -1; side <= 1; side += 2) {
            int at = a.centre + side * (PAIR[i].y * SIDE + PAIR[i].x);
            vec2 ray = s_ray[at];
            bool on_plane = is_on_plane(a.plane, a.plane.at.x + float(side) * slope, abs(ray.x));
            float w = float(on_plane) * near * min(max(ray.y, a.least) * per_width, 1.0);
            sum += w * ray_visibility(at, ray.y);
            weight += w;
            squares += w * w;
        }
    }
    s.mean = sum / weight;
    s.count = weight * weight / squares;
}

/* ---- history */
const uint NO_MATERIAL = 16u;   /* not even the one of strands */

struct History {
    Visibility mean;
    float stabilized, age;
};

Reprojection find_previous(ivec2 pixel, float signed_z)
{
    vec3 motion = is_absent(NRD_ABSENT_MOTION) ? vec3(0.0) : texelFetch(in_motion, pixel + rect_origin(), 0).xyz * g.motion_scale.xyz;
    Reprojection r = reproject(motion, pixel_uv(pixel), abs(signed_z), signed_z, g.disocclusion_threshold, NO_MATERIAL);
    r.tolerance = max(r.tolerance, 4.0 * DEPTH_ERROR * abs(signed_z));
    return r;
}

History no_history() { return History(NO_LIGHT, 0.0, 0.0); }

History fetch_history(ivec2 pixel, vec3 normal_vs, float signed_z, float width_px)
{
    History h = no_history();
    Reprojection r = find_previous(pixel, signed_z);
    if (!all(greaterThan(r.uv, vec2(0.0))) || !all(lessThan(r.uv, vec2(1.0)))) return h;
    vec2 size_prev = vec2(g.rect_width_prev, g.rect_height_prev), at = r.uv * size_prev - 0.5, corner = floor(at), part = at - corner;
    vec2 meet = (corner + 1.0) / vec2(textureSize(history, 0));   /* of the four texels */
    uvec4 words = textureGather(history, meet, 0).wzxy, colors = uvec4(0u);
#ifdef TRANSLUCENCY
    colors = textureGather(history_color, meet, 0).wzxy;
#endif
    Plane plane = make_plane(mat3(g.view_to_view_prev) * normal_vs, r.position, (corner + 0.5) / size_prev + jitter_prev_uv(), 1.0 / size_prev,
                             g.frustum_prev, g.orthographic_prev, 1.0 / r.tolerance, 1.0);
    vec4 w = vec4((1.0 - part.x) * (1.0 - part.y), part.x * (1.0 - part.y), (1.0 - part.x) * part.y, part.x * part.y);
    float area = 0.0, sum = 0.0;
    UNROLL for (int i = 0; i < 4; i++) {
        ivec2 offset = ivec2(i & 1, i >> 1);
        bool inside = all(lessThan(uvec2(ivec2(corner) + offset), uvec2(g.rect_width_prev, g.rect_height_prev)));
        uvec2 word = uvec2(words[i], colors[i]);
        bool on_plane = abs(plane_distance(plane, vec2(offset), unpack_depth(word, g.denoising_range_prev))) < 1.0;
        w[i] *= float(all(bvec2(inside, any(bvec2(is_nothing(word), on_plane)))));
        area += w[i];
        w[i] *= min(history_width_px(word) / width_px, 1.0);   /* the umbra of a nearer occluder stays outside, as in the blur */
        sum += w[i];
        h.mean += w[i] * visibility_of(word);
        h.stabilized += w[i] * history_stabilized(word);
        h.age += w[i] * history_age(word);
    }
    if (!(sum > 0.01)) return no_history();
    h.mean /= sum;
    h.stabilized /= sum;
    h.age *= smoothstep(0.0, 0.5, area) / sum;
    return h;
}

/* Variances of the mean of the rays around that say nothing; few binary rays stray farther than that, for which the second grows as 1 / their number. */
const vec2 BIAS_NOISE = vec2(4.0, 32.0);

/* Variance of one ray; of history that says 0 or 1, not none. */
Visibility ray_variance(Visibility a, Visibility b) { return max(a * (1.0 - a), b * (1.0 - b)) + 0.09; }

/* History that the rays of this frame contradict is pulled in: as far off as the mean of so many binary rays may be by chance. */
Visibility clamp_history(Visibility mean, Support s)
{
    Visibility slack = 2.0 * sqrt(ray_variance(s.mean, mean) / s.count);
    return clamp(mean, s.mean - slack, s.mean + slack);
}

/* Part of so many frames of history that is worth keeping: its distance from the mean of the rays around, beyond what is noise of those, is taken for
   its bias, and the frames are as many as would have a variance of that bias squared and their own. */
float trust_in(History h, Support s, float frames)
{
    float off = luma_of(h.mean) - luma_of(s.mean), variance = luma_of(ray_variance(s.mean, h.mean));
    float bias2 = max(off * off - (BIAS_NOISE.x + BIAS_NOISE.y / s.count) * variance / s.count, 0.0);
    return 1.0 / (1.0 + frames * bias2 / variance);
}

void accumulate(ivec2 place)
{
    ivec2 pixel = 8 * tile + place;
    int centre = ray_index(place);
    float signed_z = nearness(s_ray[centre].x);
    vec3 position_vs = view_position(ray_uv(pixel), abs(signed_z), g.frustum, g.orthographic), normal_vs = load_normal_vs(in_normal_roughness, pixel);
    Around a = make_around(centre, position_vs, normal_vs, make_light_frame(position_vs, normal_vs));
    Support s = Support(0.0, NO_LIGHT, 0.0);
    float own = max(s_ray[centre].y, a.least);
    s.width = penumbra_at_centre(a, own);
    if (!(s.width > 0.0)) return;
    gather_mean(a, own, s);
    History h = no_history();
    if (!is_reset()) h = fetch_history(pixel, normal_vs, signed_z, s.width);
    float frames = history_length(h.age, s.width), trust = trust_in(h, s, frames);
    Visibility v = mix(clamp_history(h.mean, s), ray_visibility(centre, own), 1.0 / (1.0 + frames * trust));
    uint age = pack_age(mix(frames * trust, h.age, trust * trust * trust * trust) + 1.0, random_of(pixel, 3u));
    imageStore(out_mean, pixel, uvec4(pack_mean(pack_depth(abs(signed_z)), v, random_of(pixel, 0u), age, s.width, h.stabilized), 0u, 0u));
#ifndef TRANSLUCENCY
    if (!is_absent(NRD_ABSENT_STABILIZATION)) imageStore(out_stabilized, pixel, vec4(h.stabilized));
#endif
}

/* Few pixels of a tile may lie in a penumbra where edges are narrow: those are gathered in a list, so that no thread waits for others. */
void process(ivec2 pixel)
{
    if ((tile_marks & TILE_ACTIVE) == 0u) return;
    uint i = gl_LocalInvocationIndex;
    if (i == 0u) s_waiting_count = 0u;
    load_rays(8 * tile);
    ivec2 place = ivec2(gl_LocalInvocationID.xy);
    float width = s_ray[ray_index(place)].y;
    if (width > 0.0 && may_be_penumbra(place, width)) s_waiting[atomicAdd(s_waiting_count, 1u)] = i;
    barrier();
    if (i < s_waiting_count) accumulate(ivec2(s_waiting[i] & 7u, s_waiting[i] >> 3));
}
