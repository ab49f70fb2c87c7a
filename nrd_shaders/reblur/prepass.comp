/* Reads   guides, the noisy signal.
   Writes  the blurred signal into OUT, where temporal accumulation takes it from.
   Blurs before accumulation, wider where hits are far: for inputs so sparse (probabilistic sampling) that accumulation alone would
   spread single samples over time. A pixel that was not sampled (hit distance 0) takes its neighbours' samples and hit distance.
   Off by default: with a sample in every pixel it only costs sharpness. Built with -DDIFFUSE or -DSPECULAR, and -DSH; a specular lobe is blurred no
   wider than what it sees.
   Radius from the hit distance, 8 taps: D. Zhdan, "Fast Denoising with Self-Stabilizing Recurrent Blurs", GTC 2020. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/texel.glsl"
#include "../common/checkerboard.glsl"
#include "signals.glsl"
#include "light.glsl"

layout(binding = 1) uniform sampler2D in_normal_roughness;
layout(binding = 2) uniform sampler2D in_view_z;
layout(binding = 3) uniform sampler2D in_radiance_hit_dist;
layout(binding = 4, rgba16f) uniform writeonly image2D out_radiance_hit_dist;
layout(binding = 5) uniform sampler2D in_hit_dist;

#ifdef SH
layout(binding = 6) uniform sampler2D in_sh1;
layout(binding = 7, rgba16f) uniform writeonly image2D out_sh1;

/* sums: over the taps; weight and luma: their sums. */
void store_light(ivec2 pixel, LightSums sums, vec3 normal, vec3 position, float roughness, float weight, float luma)
{
    vec3 view = mat3(g.view_to_world) * -normalize(mix(position, vec3(0.0, 0.0, 1.0), g.orthographic));
    int signal = SPECULAR_SIGNAL >= 0 ? SPECULAR_SIGNAL : 0;
    vec4 light = finish_light(sums, Receiver(normal, view, roughness), signal, sums.normal / weight, luma, weight);
    imageStore(out_sh1, pixel, round_half(vec4(light.xyz * (luma / weight), light.w)));
}
#endif

#ifdef SPECULAR
#define PREPASS_RADIUS g.specular_prepass_blur_radius
const int LOBE = SPECULAR_LOBE;
#else
#define PREPASS_RADIUS g.prepass_blur_radius
const int LOBE = DIFFUSE_LOBE;
#endif

const int TAPS = 8;
const float GOLDEN_ANGLE = 2.3999632;   /* rad; Vogel's sunflower: equal area per tap */

vec4 load_noisy(ivec2 pixel)
{
    vec4 noisy = texelFetch(in_radiance_hit_dist, noisy_texel(pixel, LOBE), 0);
    if ((SPEC_FEATURES & NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION) != 0 && has_flag(NRD_FLAG_RECONSTRUCTION)) noisy.w = texelFetch(in_hit_dist, pixel, 0).x;
    return nrd_is_finite(noisy.xyz) ? vec4(noisy.xyz, nrd_sanitize_norm_hit_dist(noisy.w)) : vec4(0.0);
}

/* Of a checkerboard, the traced one of a pixel's pair. */
ivec2 traced_pixel(ivec2 pixel) { return is_traced(pixel, LOBE) ? pixel : ivec2(pixel.x ^ 1, pixel.y); }

/* The mean of the traced pixels beside one that is not. */
vec4 load_center(ivec2 pixel, float z)
{
    if (is_traced(pixel, LOBE)) return load_noisy(pixel);
    vec2 w = side_weights(pixel, z, in_view_z);
    ivec2 last = rect_size() - 1;
    return w.x * load_noisy(max(pixel - ivec2(1, 0), ivec2(0))) + w.y * load_noisy(min(pixel + ivec2(1, 0), last));
}

#ifdef SH
vec3 load_moment(ivec2 texel)
{
    vec3 noisy = texelFetch(in_sh1, texel, 0).xyz;
    return nrd_is_finite(noisy) ? noisy : vec3(0.0);
}

/* luma: of the noisy colour there. */
vec4 load_light(ivec2 pixel, float luma) { return relative_light(load_moment(noisy_texel(pixel, LOBE)), luma, luma); }

vec4 load_center_light(ivec2 pixel, float z, float luma)
{
    if (is_traced(pixel, LOBE)) return load_light(pixel, luma);
    vec2 w = side_weights(pixel, z, in_view_z);
    return relative_light(w.x * load_moment(side_texel(pixel, -1, LOBE)) + w.y * load_moment(side_texel(pixel, 1, LOBE)), luma, luma);
}
#endif

struct Pixel {
    nrd_surface surface;
    vec3 position;   /* view space */
    float z;
};

/* False: there is no signal. */
bool load_pixel(ivec2 pixel, out Pixel p)
{
    float signed_z = texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale;
    p.z = abs(signed_z);
    p.position = view_position(pixel_uv(pixel), p.z, g.frustum, g.orthographic);
    p.surface = nrd_decode_normal_roughness(texelFetch(in_normal_roughness, pixel + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT);
#ifndef SPECULAR
    p.surface.roughness = 1.0;
#endif
#ifdef SPECULAR
    if (is_too_rough(p.surface.roughness)) return false;
#endif
    return !is_sky(signed_z);
}

/* px */
float blur_radius(Pixel p, vec2 uv, float norm_hit_dist)
{
    float hit_dist = nrd_denormalize_hit_dist(norm_hit_dist, p.z, p.surface.roughness, g.hit_distance);
    float radius = PREPASS_RADIUS * (norm_hit_dist > 0.0 ? sqrt(clamp(hit_dist / frustum_size(p.z), 0.05, 1.0)) : 1.0);
#ifdef SPECULAR
    float tracked = norm_hit_dist > 0.0 ? hit_dist / (hit_dist + distance_to_camera(uv, p.z)) : 1.0;
    radius = min(radius, lobe_footprint(max(p.surface.roughness * p.surface.roughness, 1e-4), tracked, p.z, uv));
#endif
    return radius;
}

float tap_weight(Pixel p, Pixel tap)
{
    int least = LOBE == SPECULAR_LOBE ? NRD_MATERIAL_LEAST_SPECULAR : NRD_MATERIAL_LEAST_DIFFUSE;
    uint a = p.surface.material_id, b = tap.surface.material_id;
    if (!same_material(a, b) || !same_material_for(least, a, b)) return 0.0;
    float plane = abs(dot(p.surface.normal * mat3(g.view_to_world), tap.position - p.position)) / (g.plane_distance_sensitivity * frustum_size(p.z));
    float bend = max(1.0 - dot(p.surface.normal, tap.surface.normal), 0.0), lobe = g.normal_sensitivity;
#ifdef SPECULAR
    float alpha = p.surface.roughness * p.surface.roughness, tolerance = atan(alpha) + 0.01;
    lobe = 1.0 / (tolerance * tolerance);
#endif
    float rough = abs(tap.surface.roughness - p.surface.roughness) / (0.1 * p.surface.roughness + 0.01);
    return clamp(1.0 - plane, 0.0, 1.0) * clamp(1.0 - rough, 0.0, 1.0) * exp(-lobe * bend);
}

#ifdef SH
#define TILES 8
#else
#define TILES 6
#endif
#include "../common/tiles.glsl"

void process(ivec2 pixel)
{
    Pixel p, tap;
    if (!in_rect(pixel) || !load_pixel(pixel, p)) return;
    vec4 center = load_center(pixel, p.z);
    float radius = blur_radius(p, pixel_uv(pixel), center.w);
    float turn = float(hash(0u, 0u, g.frame_index) >> 8) / 16777216.0 * 6.2831853;
    vec4 sum = center.w > 0.0 ? center : vec4(center.xyz, 0.0);
    vec2 weight = vec2(1.0, center.w > 0.0 ? 1.0 : 0.0);   /* colour, hit distance */
    SH_ONLY(LightSums light = no_light(); add_light(light, load_center_light(pixel, p.z, center.x), center.x, p.surface.normal, 1.0);)
    for (int i = 0; i < TAPS; i++) {
        float angle = turn + float(i) * GOLDEN_ANGLE;
        ivec2 at = traced_pixel(pixel + ivec2(round(radius * sqrt((float(i) + 0.5) / float(TAPS)) * vec2(cos(angle), sin(angle)))));
        if (!in_rect(at) || !load_pixel(at, tap)) continue;
        float w = tap_weight(p, tap);
        if (!(w > 0.0)) continue;
        vec4 noisy = load_noisy(at);
        sum.xyz += w * noisy.xyz;
        weight.x += w;
        SH_ONLY(add_light(light, load_light(at, noisy.x), noisy.x, tap.surface.normal, w);)
        if (noisy.w <= 0.0) continue;
        sum.w += w * noisy.w;
        weight.y += w;
    }
    vec4 blurred = vec4(sum.xyz / weight.x, weight.y > 0.0 ? sum.w / weight.y : 0.0);
    SH_ONLY(store_light(pixel, light, p.surface.normal, p.position, p.surface.roughness, weight.x, sum.x);)
    imageStore(out_radiance_hit_dist, pixel, nrd_round_to_half(clamp(blurred, -65504.0, 65504.0)));
}
