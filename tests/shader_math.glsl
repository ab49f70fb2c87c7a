// Evaluates one function of nrd.glsl, chosen by a number, on one case. Valid GLSL, and valid C after nrd_c.h: the test
// programs run the same text on the device and on the host.

#include "shader_math.h"

#ifdef NRDI_C
#define SM_REF(name) &name
#else
#define SM_REF(name) name
#endif

NRDI_STRUCT(test_case) {
    vec4 a, b, c, d, e, f, g, h, i, j, k, l; // in
    vec4 x, y;                               // out
};

NRDI_FN float as_float(bool b)
{
    return b ? 1.0f : 0.0f;
}

NRDI_FN mat4 matrix_of(vec4 x, vec4 y, vec4 z, vec4 w)
{
#ifdef NRDI_C
    mat4 m;
    m.column[0] = x, m.column[1] = y, m.column[2] = z, m.column[3] = w;
    return m;
#else
    return mat4(x, y, z, w);
#endif
}

// a: value (the first component alone for scalar functions)
NRDI_FN test_case evaluate_finite(uint operation, test_case t)
{
    if (operation == SM_IS_FINITE) {
        t.x.x = as_float(nrd_is_finite(t.a.x));
        t.x.y = as_float(nrd_is_finite(t.a.x) && nrd_is_finite(t.a.y) && nrd_is_finite(t.a.z));
    } else if (operation == SM_SANITIZE) {
        t.x = nrdi_append(nrd_sanitize_radiance(nrdi_xyz(t.a)), nrd_sanitize_hit_dist(t.a.w));
        t.y = nrdi_append(nrd_sanitize_direction(nrdi_xyz(t.a)), nrd_sanitize_norm_hit_dist(t.a.w));
    } else {
        t.x = vec4(nrd_round_to_half(t.a.x), nrd_round_to_half(t.a.y), nrd_round_to_half(t.a.z),
                   nrd_round_to_half(t.a.w));
        t.y = t.x;
    }
    return t;
}

// a: normal, roughness; b: material ID, normal encoding, roughness encoding; c: texel.
// Strands: a: tangent, thickness; b: view, pixel size.
NRDI_FN test_case evaluate_normal_roughness(uint operation, test_case t)
{
    uint normal_encoding = NRDI_UINT(t.b.y);
    uint roughness_encoding = NRDI_UINT(t.b.z);
    if (operation == SM_ENCODE_NORMAL_ROUGHNESS) {
        t.x = nrd_encode_normal_roughness(nrdi_xyz(t.a), t.a.w, NRDI_UINT(t.b.x), normal_encoding, roughness_encoding);
    } else if (operation == SM_PACK_DEFAULTS) {
        t.x = nrd_pack_normal_roughness(nrdi_xyz(t.a), t.a.w, NRDI_UINT(t.b.x));
        nrd_surface s = nrd_unpack_normal_roughness(t.x);
        t.y = vec4(s.normal.x, s.normal.y, s.roughness, NRDI_FLOAT(s.material_id));
    } else if (operation == SM_STRAND) {
        t.x = nrdi_append(nrd_strand_normal(nrdi_xyz(t.a), nrdi_xyz(t.b)), 0.0f);
        t.y.x = nrd_normalize_strand_thickness(t.a.w, t.b.w);
    } else {
        nrd_surface s = nrd_decode_normal_roughness(t.c, normal_encoding, roughness_encoding);
        float channel = normal_encoding == NRD_NORMAL_FORMAT_RGB10A2_UNORM ? t.c.z : t.c.w;
        t.x = nrdi_append(s.normal, s.roughness);
        t.y.x = NRDI_FLOAT(s.material_id);
        t.y.y = nrd_decode_roughness(channel, normal_encoding, roughness_encoding);
    }
    return t;
}

NRDI_FN test_case evaluate_average(uint operation, test_case t)
{
    if (operation == SM_SPECULAR_AVERAGE) {
        float s = nrd_specular_hit_dist_begin();
        t.x.y = nrd_specular_hit_dist_end(s);
        s = nrd_specular_hit_dist_add(nrd_specular_hit_dist_add(s, t.a.x), t.a.y);
        s = nrd_specular_hit_dist_add(nrd_specular_hit_dist_add(s, t.a.z), t.a.w);
        t.x.x = nrd_specular_hit_dist_end(s);
    } else if (operation == SM_DIFFUSE_AVERAGE) {
        vec2 s = nrd_diffuse_hit_dist_begin();
        t.x.y = nrd_diffuse_hit_dist_end(s);
        s = nrd_diffuse_hit_dist_add(nrd_diffuse_hit_dist_add(s, t.a.x), t.a.y);
        s = nrd_diffuse_hit_dist_add(nrd_diffuse_hit_dist_add(s, t.a.z), t.a.w);
        t.x.x = nrd_diffuse_hit_dist_end(s);
    } else {
        vec2 s = nrd_path_hit_dist_begin();
        t.x.y = nrd_path_hit_dist_end(s);
        s = nrd_path_hit_dist_add(nrd_path_hit_dist_add(s, t.a.x, t.b.x), t.a.y, t.b.y);
        s = nrd_path_hit_dist_add(nrd_path_hit_dist_add(s, t.a.z, t.b.z), t.a.w, t.b.w);
        t.x.x = nrd_path_hit_dist_end(s);
    }
    return t;
}

// a: four hit distances or (hit distance, ...); b: view_z, roughness, or four roughnesses; c: parameters
NRDI_FN test_case evaluate_hit_dist(uint operation, test_case t)
{
    if (operation == SM_TRIM_HIT_DIST) {
        t.x.x = nrd_trim_hit_dist(t.a.x, t.a.y);
    } else if (operation == SM_MIX_DIFFUSE_HIT_DIST) {
        t.x.x = nrd_mix_diffuse_hit_dist(t.a.x, t.a.y, t.a.z, t.a.w);
    } else if (operation == SM_ROUGHNESS_CURVE) {
        t.x.x = nrd_roughness_curve(t.b.y, 0.25f);
        t.x.y = nrd_roughness_curve(t.b.y, 0.5f);
    } else if (operation == SM_HIT_DIST_SCALE) {
        t.x.x = nrd_hit_dist_scale_of_form(t.b.x, t.b.y, t.c, NRD_HIT_DIST_FORM_4_PARAMETERS);
        t.x.y = nrd_hit_dist_scale_of_form(t.b.x, t.b.y, t.c, NRD_HIT_DIST_FORM_3_PARAMETERS);
        t.x.z = nrd_hit_dist_scale(t.b.x, t.b.y, t.c);
    } else if (operation == SM_NORMALIZE_HIT_DIST) {
        t.x.x = nrd_normalize_hit_dist(t.a.x, t.b.x, t.b.y, t.c);
        t.x.y = nrd_denormalize_hit_dist(t.x.x, t.b.x, t.b.y, t.c);
    } else {
        t = evaluate_average(operation, t);
    }
    return t;
}

// a: colour, hit distance; b: the same, to be packed unsanitised
NRDI_FN test_case evaluate_radiance(uint operation, test_case t)
{
    if (operation == SM_RGB_TO_YCOCG) {
        t.x = nrdi_append(nrd_rgb_to_ycocg(nrdi_xyz(t.a)), nrd_luma(nrdi_xyz(t.a)));
    } else if (operation == SM_YCOCG_TO_RGB) {
        t.x = nrdi_append(nrd_ycocg_to_rgb(nrdi_xyz(t.a)), 0.0f);
        t.y = nrdi_append(nrd_ycocg_to_rgb_unclamped(nrdi_xyz(t.a)), 0.0f);
    } else if (operation == SM_PACK_RADIANCE) {
        t.x = nrd_pack_radiance_hit_dist(nrdi_xyz(t.a), t.a.w, true);
        t.y = nrd_pack_radiance_hit_dist(nrdi_xyz(t.b), t.b.w, false);
    } else if (operation == SM_PACK_RELAX) {
        t.x = nrd_pack_relax_radiance_hit_dist(nrdi_xyz(t.a), t.a.w, true);
        t.y = nrd_pack_relax_radiance_hit_dist(nrdi_xyz(t.b), t.b.w, false);
    } else if (operation == SM_UNPACK_RELAX) {
        t.x = nrd_unpack_relax_radiance_hit_dist(t.a);
    } else {
        t.x = nrd_unpack_radiance_hit_dist(t.a);
    }
    return t;
}

// a: normal, roughness; b: view, metalness; c: base colour or albedo; d: reflectance at normal incidence, cosine
NRDI_FN test_case evaluate_material(uint operation, test_case t)
{
    vec3 first = nrdi_grey(0.0f);
    vec3 second = nrdi_grey(0.0f);
    if (operation == SM_ALBEDO_RF0)
        nrd_base_color_to_albedo_rf0(nrdi_xyz(t.c), t.b.w, SM_REF(first), SM_REF(second));
    else if (operation == SM_ENVIRONMENT_TERM)
        first = nrd_environment_term(nrdi_xyz(t.d), t.d.w, t.a.w);
    else
        nrd_material_factors(nrdi_xyz(t.a), nrdi_xyz(t.b), nrdi_xyz(t.c), nrdi_xyz(t.d), t.a.w, SM_REF(first),
                             SM_REF(second));
    if (operation == SM_DEMODULATE) {
        second = nrd_demodulate(nrdi_xyz(t.c), first);
        first = nrd_modulate(nrdi_xyz(t.c), first);
    }
    t.x = nrdi_append(first, 0.0f);
    t.y = nrdi_append(second, 0.0f);
    return t;
}

// A projection with scales p.x and p.y, near plane p.z, looking along p.w (1 or -1) z.
NRDI_FN mat4 projection_of(vec4 p)
{
    return matrix_of(vec4(p.x, 0.0f, 0.0f, 0.0f), vec4(0.0f, p.y, 0.0f, 0.0f), vec4(0.0f, 0.0f, 0.0f, p.w),
                     vec4(0.0f, 0.0f, p.z, 0.0f));
}

// a: clip position, b: the previous one; c: view_z, previous view_z.
// Points: a, b: positions; c to f, g to j: columns of world_to_view; k, l: projections.
// Mirrors: a, b: position and normal of the first; c, d: of the second; e: a point
NRDI_FN test_case evaluate_motion(uint operation, test_case t)
{
    if (operation == SM_CLIP_TO_UV) {
        t.x.x = nrd_clip_to_uv(t.a).x;
        t.x.y = nrd_clip_to_uv(t.a).y;
    } else if (operation == SM_MOTION) {
        t.x = nrdi_append(nrd_motion_2_5d(nrd_clip_to_uv(t.a), t.c.x, nrd_clip_to_uv(t.b), t.c.y), 0.0f);
        t.y = t.x;
    } else if (operation == SM_MOTION_OF_POINTS) {
        mat4 view = matrix_of(t.c, t.d, t.e, t.f);
        mat4 view_prev = matrix_of(t.g, t.h, t.i, t.j);
        t.x = nrdi_append(nrd_motion_of_points(nrdi_xyz(t.a), nrdi_xyz(t.b), view, projection_of(t.k), view_prev,
                                               projection_of(t.l)), 0.0f);
    } else {
        nrd_mirror chain = nrd_mirror_add(nrd_mirror_begin(), nrdi_xyz(t.a), nrdi_xyz(t.b));
        chain = nrd_mirror_add(chain, nrdi_xyz(t.c), nrdi_xyz(t.d));
        t.x = nrdi_append(nrd_mirror_point(chain, nrdi_xyz(t.e)), 0.0f);
        t.y = nrdi_append(nrd_mirror_direction(chain, nrdi_xyz(t.b)), 0.0f);
    }
    return t;
}

NRDI_FN test_case evaluate_resolve(uint operation, test_case t)
{
    nrd_sg sg = nrd_unpack_sh(t.a, t.b);
    vec3 normal = nrdi_xyz(t.c);
    vec3 view = nrdi_xyz(t.d);
    float roughness = t.c.w;
    if (operation == SM_RESOLVE_DIFFUSE)
        t.x = nrdi_append(nrd_resolve_diffuse(sg, normal, view, roughness), 0.0f);
    else if (operation == SM_RESOLVE_SPECULAR)
        t.x = nrdi_append(nrd_resolve_specular(sg, normal, view, roughness), 0.0f);
    if (operation == SM_RESOLVE_FIRST_ORDER) {
        t.x = nrdi_append(nrd_resolve_diffuse_first_order(sg, normal), 0.0f);
        t.y = nrdi_append(nrd_resolve_specular_first_order(sg, normal, view, roughness), 0.0f);
    } else if (operation == SM_DOMINANT_DIRECTION) {
        t.x = nrdi_append(nrd_specular_dominant_direction(normal, view, roughness), 0.0f);
        t.y.x = nrd_specular_dominant_factor(t.d.w, roughness);
    } else if (operation == SM_REJITTER) {
        vec2 scale = nrd_rejitter(sg, nrd_unpack_sh(t.e, t.f), view, roughness, t.d.w, normal, t.g, nrdi_xyz(t.h),
                                  nrdi_xyz(t.i), nrdi_xyz(t.j), nrdi_xyz(t.k));
        t.x.x = scale.x;
        t.x.y = scale.y;
    }
    return t;
}

// a: SH0, b: SH1 (packing: colour and hit distance, direction); c: normal, roughness; d: view, cosine or view_z.
// Re-jitter: e, f: the specular pair; g: depths of the neighbours; h to k: their normals
NRDI_FN test_case evaluate_sh(uint operation, test_case t)
{
    nrd_sg sg = nrd_unpack_sh(t.a, t.b);
    if (operation == SM_PACK_SH) {
        nrd_pack_sh(nrdi_xyz(t.a), t.a.w, nrdi_xyz(t.b), t.b.w > 0.0f, SM_REF(t.x), SM_REF(t.y));
    } else if (operation == SM_PACK_RELAX_SH) {
        nrd_pack_relax_sh(nrdi_xyz(t.a), t.a.w, nrdi_xyz(t.b), t.b.w > 0.0f, SM_REF(t.x), SM_REF(t.y));
    } else if (operation == SM_SG_COLOR) {
        t.x = nrdi_append(nrd_sg_color(sg), sg.hit_dist);
        t.y = nrdi_append(sg.moment, sg.gain);
    } else if (operation == SM_SG_DIRECTION) {
        t.x = nrdi_append(nrd_sg_direction(sg), nrd_sg_sharpness(sg));
    } else if (operation == SM_SG_ROTATE) {
        nrd_sg rotated = nrd_sg_rotate(sg, nrdi_xyz(t.c), nrdi_xyz(t.d), nrdi_xyz(t.e));
        t.x = nrdi_append(rotated.moment, rotated.ycocg.x);
    } else if (operation == SM_ROUGHNESS_AA) {
        t.x.x = nrd_roughness_aa(t.c.w, nrdi_xyz(t.c));
    } else if (operation == SM_PACK_OCCLUSION) {
        t.x = nrd_pack_directional_occlusion(nrdi_xyz(t.b), t.a.w, t.b.w > 0.0f);
        t.y.x = nrd_pack_occlusion(t.a.w);
    } else if (operation == SM_UNPACK_OCCLUSION) {
        nrd_sg light = nrd_directional_occlusion_to_sg(t.a);
        t.x = nrd_unpack_directional_occlusion(t.a, nrdi_xyz(t.c));
        t.y = nrdi_append(light.moment, light.ycocg.x + light.ycocg.y + light.ycocg.z);
    } else {
        t = evaluate_resolve(operation, t);
    }
    return t;
}

// Penumbra: a: distance to the occluder, to the light, radius, stored shadow; b: transmission.
// Lights: a, b: unshadowed light and penumbra of two lights; c: visibility of the first; the second is blocked
NRDI_FN test_case evaluate_shadow(uint operation, test_case t)
{
    if (operation == SM_PENUMBRA) {
        t.x.x = nrd_pack_penumbra(t.a.x, t.a.z);
        t.x.y = nrd_pack_local_penumbra(t.a.x, t.a.y, t.a.z);
        t.x.z = nrd_unpack_shadow(t.a.w);
        t.x.w = nrd_unpack_shadow_translucency(vec4(0.0f, t.a.w, 0.0f, 0.0f)).y;
        t.y = nrd_pack_translucency(t.a.x, nrdi_xyz(t.b));
    } else {
        nrd_light_sum sum = nrd_light_sum_begin();
        sum = nrd_light_sum_add(sum, nrdi_xyz(t.a), t.a.w, nrdi_xyz(t.c));
        sum = nrd_light_sum_add(sum, nrdi_xyz(t.b), t.b.w, nrdi_grey(0.0f));
        t.x = nrd_light_sum_translucency(sum);
        t.y.x = nrd_light_sum_penumbra(sum);
    }
    return t;
}

// a: whole numbers x, y, frame and a random number, or probability and radius; upsampling: a: fraction, view_z, cosine
// of the view; b: depths; c: cosines of the normals
NRDI_FN test_case evaluate_sampling(uint operation, test_case t)
{
    uint x = NRDI_UINT(clamp(t.a.x, 0.0f, 65535.0f));
    uint y = NRDI_UINT(clamp(t.a.y, 0.0f, 65535.0f));
    uint frame = NRDI_UINT(clamp(t.a.z, 0.0f, 65535.0f));
    if (operation == SM_LOBE_PROBABILITY) {
        t.x.x = nrd_clamp_lobe_probability(t.a.x, t.a.y);
    } else if (operation == SM_SPLIT_THRESHOLD) {
        t.x.x = nrd_split_threshold(x, y, frame, t.a.w);
    } else if (operation == SM_CHECKERBOARD) {
        t.x.x = NRDI_FLOAT(nrd_checkerboard_color(x, y, frame));
        t.x.y = NRDI_FLOAT(nrd_checkerboard_x(x / 2u, y, frame, nrd_checkerboard_color(x, y, frame)));
    } else if (operation == SM_HALF_RESOLUTION) {
        vec2 position = nrd_half_resolution_position(vec2(t.a.x, t.a.y));
        t.x.x = position.x;
        t.x.y = position.y;
    } else {
        t.x = nrd_upsample_weights(vec2(t.a.x, t.a.y), t.a.z, t.a.w, t.b, t.c);
    }
    return t;
}

NRDI_FN test_case evaluate(uint operation, test_case t)
{
    if (operation < 10u)
        return evaluate_finite(operation, t);
    if (operation < 20u)
        return evaluate_normal_roughness(operation, t);
    if (operation < 30u)
        return evaluate_hit_dist(operation, t);
    if (operation < 40u)
        return evaluate_radiance(operation, t);
    if (operation < 50u)
        return evaluate_material(operation, t);
    if (operation < 60u)
        return evaluate_motion(operation, t);
    if (operation < 75u)
        return evaluate_sh(operation, t);
    return operation < 80u ? evaluate_shadow(operation, t) : evaluate_sampling(operation, t);
}
