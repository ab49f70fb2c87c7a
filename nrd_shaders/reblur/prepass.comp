/* Reads   guides, the noisy signal.
   Writes  the blurred signal into OUT, where temporal accumulation takes it from.
   Blurs before accumulation, wider where hits are far: for inputs so sparse (probabilistic sampling) that accumulation alone would
   spread single samples over time. A pixel that was not sampled (hit distance 0) takes its neighbours' samples and hit distance.
   Off by default: with a sample in every pixel it only costs sharpness.
   Radius from the hit distance, 8 taps: D. Zhdan, "Fast Denoising with Self-Stabilizing Recurrent Blurs", GTC 2020. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"

layout(binding = 1) uniform sampler2D in_normal_roughness;
layout(binding = 2) uniform sampler2D in_view_z;
layout(binding = 3) uniform sampler2D in_radiance_hit_dist;
layout(binding = 4, rgba16f) uniform writeonly image2D out_radiance_hit_dist;

const int TAPS = 8;
const float GOLDEN_ANGLE = 2.3999632;   /* rad; Vogel's sunflower: equal area per tap */

vec4 load_noisy(ivec2 pixel)
{
    vec4 noisy = texelFetch(in_radiance_hit_dist, pixel, 0);
    return nrd_is_finite(noisy.xyz) ? vec4(noisy.xyz, nrd_sanitize_norm_hit_dist(noisy.w)) : vec4(0.0);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel)) return;
    float signed_z = texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale, z = abs(signed_z);
    if (is_sky(signed_z)) return;
    vec3 normal = nrd_decode_normal_roughness(texelFetch(in_normal_roughness, pixel + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT).normal;
    vec3 normal_vs = normal * mat3(g.view_to_world), position = view_position(pixel_uv(pixel), z, g.frustum, g.orthographic);
    vec4 center = load_noisy(pixel);
    float size = frustum_size(z), hit_dist = nrd_denormalize_hit_dist(center.w, z, 1.0, g.hit_distance);
    float radius = g.prepass_blur_radius * (center.w > 0.0 ? sqrt(clamp(hit_dist / size, 0.05, 1.0)) : 1.0);
    float turn = float(hash(0u, 0u, g.frame_index) >> 8) / 16777216.0 * 6.2831853;
    vec4 sum = center.w > 0.0 ? center : vec4(center.xyz, 0.0);
    vec2 weight = vec2(1.0, center.w > 0.0 ? 1.0 : 0.0);   /* colour, hit distance */
    for (int i = 0; i < TAPS; i++) {
        float angle = turn + float(i) * GOLDEN_ANGLE;
        ivec2 tap = pixel + ivec2(round(radius * sqrt((float(i) + 0.5) / float(TAPS)) * vec2(cos(angle), sin(angle))));
        if (!in_rect(tap)) continue;
        float signed_tap_z = texelFetch(in_view_z, tap + rect_origin(), 0).x * g.view_z_scale;
        if (is_sky(signed_tap_z)) continue;
        vec3 tap_normal = nrd_decode_normal_roughness(texelFetch(in_normal_roughness, tap + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT).normal;
        vec3 tap_position = view_position(pixel_uv(tap), abs(signed_tap_z), g.frustum, g.orthographic);
        float plane = abs(dot(normal_vs, tap_position - position)) / (g.plane_distance_sensitivity * size);
        float w = clamp(1.0 - plane, 0.0, 1.0) * exp(-g.normal_sensitivity * max(1.0 - dot(normal, tap_normal), 0.0));
        if (!(w > 0.0)) continue;
        vec4 noisy = load_noisy(tap);
        sum.xyz += w * noisy.xyz;
        weight.x += w;
        if (noisy.w <= 0.0) continue;
        sum.w += w * noisy.w;
        weight.y += w;
    }
    vec4 blurred = vec4(sum.xyz / weight.x, weight.y > 0.0 ? sum.w / weight.y : 0.0);
    imageStore(out_radiance_hit_dist, pixel, nrd_round_to_half(clamp(blurred, -65504.0, 65504.0)));
}
