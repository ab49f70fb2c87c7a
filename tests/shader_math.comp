// Reads: cases (16 floats each), a guide image. Writes: results (8 floats each), a 16-bit float image.
// Purpose: evaluates one function of nrd.glsl, chosen by a push constant, on every case, for test_shader_math.c.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../nrd_shaders/nrd.glsl"
#include "shader_math.h"

layout(local_size_x = SM_GROUP) in;

layout(push_constant) uniform push_block {
    uint operation; // SM_...
    uint count;     // cases
} push;

layout(std430, set = 0, binding = 0) readonly buffer case_block { vec4 cases[]; };
layout(std430, set = 0, binding = 1) writeonly buffer result_block { vec4 results[]; };
layout(set = 0, binding = 2) uniform sampler2D in_guide;
layout(set = 0, binding = 3, rgba16f) writeonly uniform image2D out_half;

// The four input vectors and two output vectors of a case.
struct test_case {
    vec4 a, b, c, d;
    vec4 x, y;
};

void pack_surface(nrd_surface surface, inout test_case t)
{
    t.x = vec4(surface.normal, surface.roughness);
    t.y.x = float(surface.material_id);
}

// a: normal, roughness; b: material ID, normal encoding, roughness encoding; c: texel
void evaluate_normal_roughness(uint operation, ivec2 texel_px, inout test_case t)
{
    uint normal_encoding = uint(t.b.y);
    uint roughness_encoding = uint(t.b.z);
    bool octahedral = normal_encoding == NRD_NORMAL_FORMAT_RGB10A2_UNORM;
    if (operation == SM_ENCODE_NORMAL_ROUGHNESS) {
        t.x = nrd_encode_normal_roughness(t.a.xyz, t.a.w, uint(t.b.x), normal_encoding, roughness_encoding);
    } else if (operation == SM_PACK_DEFAULTS) {
        t.x = nrd_pack_normal_roughness(t.a.xyz, t.a.w, uint(t.b.x));
        nrd_surface surface = nrd_unpack_normal_roughness(t.x);
        t.y = vec4(surface.normal.xy, surface.roughness, float(surface.material_id));
    } else {
        vec4 texel = operation == SM_DECODE_IMAGE ? texelFetch(in_guide, texel_px, 0) : t.c;
        pack_surface(nrd_decode_normal_roughness(texel, normal_encoding, roughness_encoding), t);
        t.y.y = nrd_decode_roughness(octahedral ? texel.z : texel.w, normal_encoding, roughness_encoding);
    }
}

// a: value (the first component alone for scalar functions)
void evaluate_finite(uint operation, ivec2 texel_px, inout test_case t)
{
    if (operation == SM_IS_FINITE) {
        t.x.x = float(nrd_is_finite(t.a.x));
        t.x.y = float(nrd_is_finite(t.a.xyz));
    } else if (operation == SM_SANITIZE) {
        t.x = vec4(nrd_sanitize_radiance(t.a.xyz), nrd_sanitize_hit_dist(t.a.w));
        t.y.x = nrd_sanitize_norm_hit_dist(t.a.w);
    } else {
        t.x = nrd_round_to_half(t.a);
        t.y.x = nrd_round_to_half(t.a.x);
        t.y.y = nrd_round_to_half(t.a.xy).y;
        t.y.z = nrd_round_to_half(t.a.xyz).z;
        if (operation == SM_STORE_HALF)
            imageStore(out_half, texel_px, t.x);
    }
}

// a: four hit distances or (hit distance, ...); b: view_z, roughness; c: parameters
void evaluate_hit_dist(uint operation, inout test_case t)
{
    if (operation == SM_TRIM_HIT_DIST) {
        t.x.x = nrd_trim_hit_dist(t.a.x, t.a.y);
    } else if (operation == SM_SPECULAR_AVERAGE) {
        float accumulated = nrd_specular_hit_dist_begin();
        for (int i = 0; i < 4; ++i)
            accumulated = nrd_specular_hit_dist_add(accumulated, t.a[i]);
        t.x.x = nrd_specular_hit_dist_end(accumulated);
        t.x.y = nrd_specular_hit_dist_end(nrd_specular_hit_dist_begin());
    } else if (operation == SM_DIFFUSE_AVERAGE) {
        vec2 accumulated = nrd_diffuse_hit_dist_begin();
        for (int i = 0; i < 4; ++i)
            accumulated = nrd_diffuse_hit_dist_add(accumulated, t.a[i]);
        t.x.x = nrd_diffuse_hit_dist_end(accumulated);
        t.x.y = nrd_diffuse_hit_dist_end(nrd_diffuse_hit_dist_begin());
    } else if (operation == SM_MIX_DIFFUSE_HIT_DIST) {
        t.x.x = nrd_mix_diffuse_hit_dist(t.a.x, t.a.y, t.a.z, t.a.w);
    } else if (operation == SM_ROUGHNESS_CURVE) {
        t.x.xy = vec2(nrd_roughness_curve(t.b.y, 0.25), nrd_roughness_curve(t.b.y, 0.5));
    } else if (operation == SM_HIT_DIST_SCALE) {
        t.x.x = nrd_hit_dist_scale_of_form(t.b.x, t.b.y, t.c, NRD_HIT_DIST_FORM_4_PARAMETERS);
        t.x.y = nrd_hit_dist_scale_of_form(t.b.x, t.b.y, t.c, NRD_HIT_DIST_FORM_3_PARAMETERS);
        t.x.z = nrd_hit_dist_scale(t.b.x, t.b.y, t.c);
    } else {
        t.x.x = nrd_normalize_hit_dist(t.a.x, t.b.x, t.b.y, t.c);
        t.x.y = nrd_denormalize_hit_dist(t.x.x, t.b.x, t.b.y, t.c);
    }
}

// a: colour, hit distance
void evaluate_radiance(uint operation, inout test_case t)
{
    if (operation == SM_RGB_TO_YCOCG) {
        t.x = vec4(nrd_rgb_to_ycocg(t.a.xyz), nrd_luma(t.a.xyz));
    } else if (operation == SM_YCOCG_TO_RGB) {
        t.x.xyz = nrd_ycocg_to_rgb(t.a.xyz);
        t.y.xyz = nrd_ycocg_to_rgb_unclamped(t.a.xyz);
    } else if (operation == SM_PACK_RADIANCE) {
        t.x = nrd_pack_radiance_hit_dist(t.a.xyz, t.a.w, true);
        t.y = nrd_pack_radiance_hit_dist(t.b.xyz, t.b.w, false);
    } else {
        t.x = nrd_unpack_radiance_hit_dist(t.a);
    }
}

// a: normal, roughness; b: view, metalness; c: base colour or albedo; d: reflectance at normal incidence, cosine
void evaluate_material(uint operation, inout test_case t)
{
    if (operation == SM_ALBEDO_RF0)
        nrd_base_color_to_albedo_rf0(t.c.xyz, t.b.w, t.x.xyz, t.y.xyz);
    else if (operation == SM_ENVIRONMENT_TERM)
        t.x.xyz = nrd_environment_term(t.d.xyz, t.d.w, t.a.w);
    else
        nrd_material_factors(t.a.xyz, t.b.xyz, t.c.xyz, t.d.xyz, t.a.w, t.x.xyz, t.y.xyz);
    if (operation == SM_DEMODULATE) {
        vec3 factor = t.x.xyz;
        t.x.xyz = nrd_modulate(t.c.xyz, factor);
        t.y.xyz = nrd_demodulate(t.c.xyz, factor);
    }
}

// a: clip position, b: the previous one; c: view_z, previous view_z
void evaluate_motion(uint operation, inout test_case t)
{
    vec2 uv = nrd_clip_to_uv(t.a);
    t.x.xy = uv;
    if (operation == SM_MOTION) {
        t.x.xyz = nrd_motion_2_5d(t.a, t.c.x, t.b, t.c.y);
        t.y.xyz = nrd_motion_2_5d(uv, t.c.x, nrd_clip_to_uv(t.b), t.c.y);
    }
}

void evaluate(uint operation, ivec2 texel_px, inout test_case t)
{
    if (operation <= SM_ROUND_TO_HALF || operation == SM_STORE_HALF)
        evaluate_finite(operation, texel_px, t);
    else if (operation <= SM_PACK_DEFAULTS || operation == SM_DECODE_IMAGE)
        evaluate_normal_roughness(operation, texel_px, t);
    else if (operation <= SM_NORMALIZE_HIT_DIST)
        evaluate_hit_dist(operation, t);
    else if (operation <= SM_UNPACK_RADIANCE)
        evaluate_radiance(operation, t);
    else if (operation <= SM_DEMODULATE)
        evaluate_material(operation, t);
    else
        evaluate_motion(operation, t);
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count)
        return;
    test_case t;
    t.a = cases[4 * i];
    t.b = cases[4 * i + 1];
    t.c = cases[4 * i + 2];
    t.d = cases[4 * i + 3];
    t.x = vec4(0.0);
    t.y = vec4(0.0);
    evaluate(push.operation, ivec2(i % SM_WIDTH, i / SM_WIDTH), t);
    results[2 * i] = t.x;
    results[2 * i + 1] = t.y;
}
