/* Functions of nrd_shaders/nrd.glsl for guides, hit distances, radiance and material against double precision, and the
   bounds, tables and vectors that its comments promise. Prints the worst error per function. */
#include "shader_math_rig.h"

/* ---- inputs ---------------------------------------------------------------------------------------------------- */

static void fill_any(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = pick_any();
}

static void fill_finite(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = pick_finite();
}

static void fill_surface(float *in) {
    pick_normal(in);
    in[3] = pick_roughness_or_bad();
    in[4] = (float)(random_u32() % 6);
    in[5] = (float)(random_u32() % 5);
    in[6] = (float)(random_u32() % 3);
}

static void fill_texel(float *in) {
    fill_surface(in);
    for (int i = 0; i < 4; ++i) in[8 + i] = pick_unit();
    /* A material ID is read from anywhere near its code. */
    if (in[5] == REF_RGB10A2_UNORM) in[11] = (float)(random_u32() % 4) / 3.0f + random_between(-0.1f, 0.1f);
}

static void fill_hit_dists(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = pick_hit_dist();
}

static void fill_trim(float *in) {
    in[0] = random_log(1e-5f, 1.0f);
    in[1] = random_u32() % 4 ? random_log(1e-5f, 1.0f) : random_u32() % 2 ? 0.0f : in[0];
}

static void fill_mix(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = pick_radiance();
}

/* Parameters over their whole range: B = 0, C = 1 and D = 0 included. */
static void fill_normalize(float *in) {
    in[0] = pick_hit_dist();
    in[4] = pick_view_z();
    in[5] = pick_unit();
    in[8] = random_log(0.1f, 100.0f);
    in[9] = random_u32() % 4 ? random_unit() : 0.0f;
    in[10] = random_u32() % 4 ? random_between(1.0f, 50.0f) : 1.0f;
    in[11] = random_u32() % 4 ? random_between(-50.0f, 0.0f) : 0.0f;
}

static void fill_pack_radiance(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = pick_any(), in[4 + i] = pick_radiance();
    if (random_u32() % 2)
        for (int i = 0; i < 4; ++i) in[i] = pick_radiance();
}

static void fill_signed_radiance(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = pick_radiance() * (random_u32() % 4 ? 1.0f : -1.0f);
}

static void fill_material(float *in) {
    random_direction(in);
    random_direction(in + 4);
    if (random_u32() % 8 == 0) memcpy(in + 4, in, 3 * sizeof *in);
    in[3] = pick_unit();
    in[7] = pick_unit();
    for (int i = 0; i < 8; ++i) in[8 + i] = pick_unit();
}

static void fill_motion(float *in) {
    for (int k = 0; k < 2; ++k) {
        float w = in[4 * k + 3] = random_u32() % 8 ? random_log(0.1f, 1000.0f) : -random_unit();
        for (int i = 0; i < 3; ++i) in[4 * k + i] = random_between(-2.0f, 2.0f) * w;
        in[8 + k] = random_between(-100.0f, 100.0f);
    }
}

/* ---- double precision ------------------------------------------------------------------------------------------ */

static void reference_is_finite(const double *in, double *out) {
    out[0] = isfinite(in[0]) ? 1.0 : 0.0;
    out[1] = ref_is_finite3(in) ? 1.0 : 0.0;
}

static void reference_sanitize(const double *in, double *out) {
    ref_sanitize_radiance(in, out);
    out[3] = ref_sanitize(in[3], REF_MISS);
    for (int i = 0; i < 3; ++i) out[4 + i] = ref_is_finite3(in) ? ref_clamp(in[i], -1.0, 1.0) : 0.0;
    out[7] = ref_sanitize(in[3], 1.0);
}

static void reference_round_to_half(const double *in, double *out) {
    for (int i = 0; i < 4; ++i) out[i] = ref_round_to_half(in[i]);
    for (int i = 0; i < 3; ++i) out[4 + i] = out[i];
}

static void reference_encode(const double *in, double *out) {
    ref_encode_normal_roughness(in, in[3], (unsigned)in[4], (int)in[5], (int)in[6], out);
}

static void reference_decode(const double *in, double *out) {
    out[4] = ref_decode_normal_roughness(in + 8, (int)in[5], (int)in[6], out);
    out[5] = out[3];
}

static void reference_pack_defaults(const double *in, double *out) {
    double surface[4];
    ref_encode_normal_roughness(in, in[3], (unsigned)in[4], REF_RGB10A2_UNORM, REF_LINEAR, out);
    out[7] = ref_decode_normal_roughness(out, REF_RGB10A2_UNORM, REF_LINEAR, surface);
    out[4] = surface[0], out[5] = surface[1], out[6] = surface[3];
}

static void reference_trim(const double *in, double *out) {
    out[0] = ref_trim_hit_dist(in[0], in[1]);
}

static void reference_specular_average(const double *in, double *out) {
    out[0] = ref_specular_average(in, 4);
    out[1] = 0.0;
}

static void reference_diffuse_average(const double *in, double *out) {
    out[0] = ref_diffuse_average(in, 4);
    out[1] = 0.0;
}

static void reference_mix_diffuse(const double *in, double *out) {
    out[0] = ref_mix_diffuse_hit_dist(in[0], in[1], in[2], in[3]);
}

static void reference_roughness_curve(const double *in, double *out) {
    out[0] = ref_roughness_curve(in[5], 0.25);
    out[1] = ref_roughness_curve(in[5], 0.5);
}

static void reference_hit_dist_scale(const double *in, double *out) {
    out[0] = out[2] = ref_hit_dist_scale(in[4], in[5], in + 8, 4);
    out[1] = ref_hit_dist_scale(in[4], in[5], in + 8, 3);
}

static void reference_normalize(const double *in, double *out) {
    out[0] = ref_normalize_hit_dist(in[0], in[4], in[5], in + 8);
    out[1] = out[0] * ref_hit_dist_scale(in[4], in[5], in + 8, 4);
}

static void reference_rgb_to_ycocg(const double *in, double *out) {
    ref_rgb_to_ycocg(in, out);
    out[3] = out[0];
}

static void reference_ycocg_to_rgb(const double *in, double *out) {
    ref_ycocg_to_rgb(in, true, out);
    ref_ycocg_to_rgb(in, false, out + 4);
    out[3] = 0.0;
}

static void reference_pack_radiance(const double *in, double *out) {
    ref_pack_radiance_hit_dist(in, in[3], true, out);
    ref_pack_radiance_hit_dist(in + 4, in[7], false, out + 4);
}

static void reference_unpack_radiance(const double *in, double *out) {
    ref_ycocg_to_rgb(in, true, out);
    out[3] = in[3];
}

static void reference_albedo_rf0(const double *in, double *out) {
    for (int i = 0; i < 3; ++i) {
        out[i] = in[8 + i] * (1.0 - in[7]);
        out[4 + i] = ref_mix(0.04, in[8 + i], in[7]);
    }
    out[3] = 0.0;
}

static void reference_environment(const double *in, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = ref_environment_term(in[12 + i], in[15], in[3]);
}

static void reference_factors(const double *in, double *out) {
    ref_material_factors(in, in + 4, in + 8, in + 12, in[3], out, out + 4);
    out[3] = 0.0;
}

static void reference_demodulate(const double *in, double *out) {
    double factor[3], specular[3];
    ref_material_factors(in, in + 4, in + 8, in + 12, in[3], factor, specular);
    for (int i = 0; i < 3; ++i) out[i] = in[8 + i] * factor[i], out[4 + i] = in[8 + i] / factor[i];
    out[3] = 0.0;
}

static void reference_clip_to_uv(const double *in, double *out) {
    ref_clip_to_uv(in, out);
}

static void reference_motion(const double *in, double *out) {
    ref_motion_2_5d(in, in[8], in + 4, in[9], out);
    memcpy(out + 4, out, 3 * sizeof *out);
    out[3] = 0.0;
}

static const comparison comparisons[] = {
    {"is_finite", SM_IS_FINITE, fill_any, reference_is_finite, 2, 1.0, 0.0},
    {"sanitize_radiance, _direction, ..", SM_SANITIZE, fill_any, reference_sanitize, 8, 1e-30, 0.0},
    {"round_to_half", SM_ROUND_TO_HALF, fill_finite, reference_round_to_half, 7, 1e-30, 0.0},
    {"encode_normal_roughness", SM_ENCODE_NORMAL_ROUGHNESS, fill_surface, reference_encode, 4, 1.0, 5e-7},
    {"decode_normal_roughness", SM_DECODE_NORMAL_ROUGHNESS, fill_texel, reference_decode, 6, 1.0, 1e-6},
    {"pack/unpack_normal_roughness", SM_PACK_DEFAULTS, fill_surface, reference_pack_defaults, 8, 1.0, 1e-6},
    {"trim_hit_dist", SM_TRIM_HIT_DIST, fill_trim, reference_trim, 1, 1e-30, 0.0},
    {"specular_hit_dist_begin/add/end", SM_SPECULAR_AVERAGE, fill_hit_dists, reference_specular_average, 2, 1e-38, 0.0},
    {"diffuse_hit_dist_begin/add/end", SM_DIFFUSE_AVERAGE, fill_hit_dists, reference_diffuse_average, 2, 1e-30, 5e-7},
    {"mix_diffuse_hit_dist", SM_MIX_DIFFUSE_HIT_DIST, fill_mix, reference_mix_diffuse, 1, 1e-30, 1e-6},
    {"roughness_curve", SM_ROUGHNESS_CURVE, fill_normalize, reference_roughness_curve, 2, 1.0, 5e-6},
    {"hit_dist_scale", SM_HIT_DIST_SCALE, fill_normalize, reference_hit_dist_scale, 3, 1e-3, 2e-5},
    {"normalize/denormalize_hit_dist", SM_NORMALIZE_HIT_DIST, fill_normalize, reference_normalize, 2, 1e-30, 2e-5},
    {"rgb_to_ycocg, luma", SM_RGB_TO_YCOCG, fill_mix, reference_rgb_to_ycocg, 4, 65504.0, 2e-7},
    {"ycocg_to_rgb", SM_YCOCG_TO_RGB, fill_signed_radiance, reference_ycocg_to_rgb, 7, 65504.0, 2e-7},
    {"pack_radiance_hit_dist", SM_PACK_RADIANCE, fill_pack_radiance, reference_pack_radiance, 8, 65504.0, 2e-7},
    {"unpack_radiance_hit_dist", SM_UNPACK_RADIANCE, fill_signed_radiance, reference_unpack_radiance, 4, 65504.0, 2e-7},
    {"base_color_to_albedo_rf0", SM_ALBEDO_RF0, fill_material, reference_albedo_rf0, 7, 1.0, 5e-7},
    {"environment_term", SM_ENVIRONMENT_TERM, fill_material, reference_environment, 3, 1.0, 2e-6},
    {"material_factors", SM_MATERIAL_FACTORS, fill_material, reference_factors, 7, 1.0, 2e-6},
    {"demodulate, modulate", SM_DEMODULATE, fill_material, reference_demodulate, 7, 1.0, 5e-5},
    {"clip_to_uv", SM_CLIP_TO_UV, fill_motion, reference_clip_to_uv, 2, 1.0, 1e-6},
    {"motion_2_5d", SM_MOTION, fill_motion, reference_motion, 7, 1.0, 2e-6},
};

static void every_function_agrees_with_double_precision(void **state) {
    (void)state;
    compare_all(comparisons, COUNT(comparisons));
}

/* ---- normal and roughness through storage ---------------------------------------------------------------------- */

typedef struct guide_format {
    const char *name;
    VkFormat format;
    int encoding;
    double angle, mean_angle, roughness; /* largest errors allowed: degrees, degrees, linear */
} guide_format;

static const guide_format guide_formats[] = {
    {"RGB10A2 unorm", VK_FORMAT_A2B10G10R10_UNORM_PACK32, REF_RGB10A2_UNORM, 0.137, 0.060, 0.00098},
    {"RGBA8 unorm", VK_FORMAT_R8G8B8A8_UNORM, REF_RGBA8_UNORM, 0.32, 0.135, 0.00197},
    {"RGBA8 snorm", VK_FORMAT_R8G8B8A8_SNORM, REF_RGBA8_SNORM, 0.32, 0.135, 0.00394},
    {"RGBA16 unorm", VK_FORMAT_R16G16B16A16_UNORM, REF_RGBA16_UNORM, 0.00125, 0.0006, 0.0000077},
    {"RGBA16 snorm", VK_FORMAT_R16G16B16A16_SNORM, REF_RGBA16_SNORM, 0.00125, 0.0006, 0.0000154},
    {"RGBA16 float", VK_FORMAT_R16G16B16A16_SFLOAT, REF_RGBA16_SNORM, 0.0160, 0.005, 0.00025},
};

/* Nearest code, as Vulkan's conversion rules have it. */
static int32_t code_of(double value, double low, double largest_code) {
    return (int32_t)nearbyint(ref_clamp(value, low, 1.0) * largest_code);
}

/* Bits of a value that ref_round_to_half returned. */
static uint16_t half_bits(double value) {
    int exponent;
    double mantissa = frexp(fabs(value), &exponent); /* [0.5,1) */
    uint16_t sign = signbit(value) ? 0x8000u : 0u;
    if (fabs(value) < ldexp(1.0, -14)) return (uint16_t)(sign | (uint16_t)ldexp(fabs(value), 24)); /* subnormal, 0 */
    return (uint16_t)(sign | ((exponent + 14) << 10) | ((uint16_t)ldexp(mantissa, 11) & 0x3ffu));
}

static void store_texel(VkFormat format, const float texel[4], void *out) {
    int32_t code[4];
    bool is_snorm = format == VK_FORMAT_R8G8B8A8_SNORM || format == VK_FORMAT_R16G16B16A16_SNORM;
    bool is_ten = format == VK_FORMAT_A2B10G10R10_UNORM_PACK32;
    uint32_t bytes = gpu_format_size(format);
    double largest = is_ten ? 1023.0 : bytes == 4 ? 255.0 : 65535.0;
    if (is_snorm) largest = bytes == 4 ? 127.0 : 32767.0;
    for (int i = 0; i < 4; ++i) {
        code[i] = code_of(texel[i], is_snorm ? -1.0 : 0.0, is_ten && i == 3 ? 3.0 : largest);
        if (format == VK_FORMAT_R16G16B16A16_SFLOAT) code[i] = half_bits(ref_round_to_half(texel[i]));
    }
    if (is_ten) {
        *(uint32_t *)out = (uint32_t)(code[0] | code[1] << 10 | code[2] << 20) | (uint32_t)code[3] << 30;
        return;
    }
    for (int i = 0; i < 4; ++i) {
        if (bytes == 4) ((uint8_t *)out)[i] = (uint8_t)code[i];
        else ((uint16_t *)out)[i] = (uint16_t)code[i];
    }
}

static double angle_between(const float a[3], const double b[3]) {
    double u[3], cross[3], dot;
    to_doubles(a, u, 3);
    dot = ref_dot(u, b);
    cross[0] = u[1] * b[2] - u[2] * b[1];
    cross[1] = u[2] * b[0] - u[0] * b[2];
    cross[2] = u[0] * b[1] - u[1] * b[0];
    return DEGREES * atan2(sqrt(ref_dot(cross, cross)), dot);
}

static void fill_round_trip(size_t count, int normal_encoding, int roughness_encoding) {
    static const float axes[][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},          {0, -1, 0},
                                    {0, 0, 1},  {0, 0, -1}, {0.6f, 0.8f, 0.0f}, {-0.28f, 0.96f, -0.0f}};
    static const float roughness[] = {0.0f, 0.003f, 0.5f, 1.0f};
    clear_cases(count);
    for (size_t i = 0; i < count; ++i) {
        float *in = case_in(i);
        random_direction(in);
        if (i < 4 * COUNT(axes)) memcpy(in, axes[i / 4], sizeof axes[0]);
        in[3] = i % 4096 < 4 * COUNT(axes) ? roughness[i % 4] : random_unit();
        in[4] = (float)(random_u32() % 4);
        in[5] = (float)normal_encoding;
        in[6] = (float)roughness_encoding;
    }
}

/* Packs on the device, stores as `format` does, reads through a sampler of that format, unpacks on the device. */
static void run_round_trip(const guide_format *f, size_t count) {
    uint32_t bytes = gpu_format_size(f->format);
    uint8_t *texels = calloc(MAX_CASES, bytes);
    gpu_image image;
    assert_non_null(texels);
    run(SM_ENCODE_NORMAL_ROUGHNESS, (uint32_t)count);
    for (size_t i = 0; i < count; ++i) store_texel(f->format, case_out(i), texels + i * bytes);
    require(gpu_image_create(&device.gpu, SM_WIDTH, MAX_CASES / SM_WIDTH, f->format, f->name, &image));
    require(gpu_upload(&device.gpu, &image, texels));
    gpu_kernel_bind_image(&device.gpu, &device.kernel, 2, &image);
    run(SM_DECODE_IMAGE, (uint32_t)count);
    gpu_kernel_bind_image(&device.gpu, &device.kernel, 2, &device.guide);
    gpu_image_destroy(&device.gpu, &image);
    free(texels);
}

static void check_round_trip(const guide_format *f, size_t count) {
    double angle = 0.0, sum = 0.0, roughness = 0.0;
    for (size_t i = 0; i < count; ++i) {
        const float *in = case_in(i), *out = case_out(i);
        double n[3];
        to_doubles(in, n, 3);
        double length = sqrt(ref_dot(n, n)), error = angle_between(out, n);
        assert_true(isfinite(out[0]) && isfinite(out[1]) && isfinite(out[2]));
        assert_true(length > 0.999 && length < 1.001);
        angle = fmax(angle, error);
        sum += error;
        if (f->encoding != REF_RGB10A2_UNORM || in[3] >= 0.006f)
            roughness = fmax(roughness, fabs((double)out[3] - in[3]));
        assert_true(out[3] == out[5]);
        assert_true(out[4] == (f->encoding == REF_RGB10A2_UNORM ? in[4] : 0.0f));
    }
    print_message("  %-14s angle %.5f (bound %.5f) mean %.5f (%.5f) degrees, roughness %.7f (%.7f)\n", f->name, angle,
                  f->angle, sum / (double)count, f->mean_angle, roughness, f->roughness);
    assert_true(angle <= f->angle);
    assert_true(sum / (double)count <= f->mean_angle);
    assert_true(roughness <= f->roughness);
}

static void normals_survive_storage_within_the_documented_angles(void **state) {
    const size_t count = 60000;
    (void)state;
    random_state = 1;
    for (size_t i = 0; i < COUNT(guide_formats); ++i) {
        fill_round_trip(count, guide_formats[i].encoding, REF_LINEAR);
        run_round_trip(&guide_formats[i], count);
        check_round_trip(&guide_formats[i], count);
    }
}

/* Step of the stored value, seen through the decoder: sqrt is steepest at 0, the square at 1. */
static void every_roughness_encoding_survives_ten_bits(void **state) {
    const size_t count = 4096;
    (void)state;
    random_state = 2;
    for (int encoding = REF_LINEAR; encoding <= REF_SQRT_LINEAR; ++encoding) {
        double at_high = 0.0, at_low = 0.0;
        fill_round_trip(count, REF_RGB10A2_UNORM, encoding);
        run_round_trip(&guide_formats[0], count);
        for (size_t i = 0; i < count; ++i) {
            double r = case_in(i)[3], error = fabs(r - case_out(i)[3]);
            if (r >= 0.1) at_high = fmax(at_high, error);
            else at_low = fmax(at_low, error);
        }
        print_message("  roughness encoding %d: error %.5f at 0.1 and above, %.5f below\n", encoding, at_high, at_low);
        assert_true(at_high <= (encoding == REF_SQ_LINEAR ? 0.0050 : encoding == REF_SQRT_LINEAR ? 0.0020 : 0.00098));
        assert_true(at_low <= (encoding == REF_SQ_LINEAR ? 0.0550 : 0.0035));
    }
}

static void roughness_zero_keeps_the_sign_of_z_in_ten_bits(void **state) {
    static const float up[] = {0, 0, 1, 0}, down[] = {0, 0, -1, 0};
    (void)state;
    clear_cases(2);
    set_case(0, 0, 4, up);
    set_case(1, 0, 4, down);
    run(SM_ENCODE_NORMAL_ROUGHNESS, 2);
    assert_int_equal(code_of(case_out(0)[2], 0.0, 1023.0), 513);
    assert_int_equal(code_of(case_out(1)[2], 0.0, 1023.0), 510);
}

static void normals_pack_to_the_documented_texels(void **state) {
    static const float surfaces[][5] = {{0, 0, 1, 0.5f, 1}, {0.6f, 0, -0.8f, 0.25f, 3}};
    static const double texels[][4] = {{0.5, 0.5, 0.75, 1.0 / 3.0}, {0.714286, 0.285714, 0.375, 1.0}};
    (void)state;
    clear_cases(COUNT(surfaces));
    for (size_t i = 0; i < COUNT(surfaces); ++i) set_case(i, 0, 5, surfaces[i]);
    run(SM_PACK_DEFAULTS, COUNT(surfaces));
    for (size_t i = 0; i < COUNT(surfaces); ++i) assert_near(case_out(i), texels[i], 4, 1e-6);
}

/* ---- hit distance ---------------------------------------------------------------------------------------------- */

static const float default_params[4] = {3.0f, 0.1f, 20.0f, -25.0f};

static void set_hit_dist_case(size_t i, float hit_dist, float view_z, float roughness) {
    case_in(i)[0] = hit_dist;
    case_in(i)[4] = view_z;
    case_in(i)[5] = roughness;
    set_case(i, 8, 4, default_params);
}

static void roughness_curve_matches_its_table(void **state) {
    static const float roughness[] = {0, 0.02f, 0.05f, 0.1f, 0.2f, 0.3f, 0.5f, 0.7f, 1};
    static const double table[][2] = {{0, 0},           {0.0203, 0.0076}, {0.1385, 0.0655},
                                      {0.4218, 0.2372}, {0.6661, 0.4455}, {0.7401, 0.5477},
                                      {0.8409, 0.7071}, {0.9147, 0.8367}, {1, 1}};
    (void)state;
    clear_cases(COUNT(table));
    for (size_t i = 0; i < COUNT(table); ++i) set_hit_dist_case(i, 0.0f, 0.0f, roughness[i]);
    run(SM_ROUGHNESS_CURVE, COUNT(table));
    for (size_t i = 0; i < COUNT(table); ++i) assert_near(case_out(i), table[i], 2, 6e-5);
}

static void hit_dist_scale_matches_its_table(void **state) {
    static const float roughness[] = {0, 0.05f, 0.1f, 0.2f, 0.3f, 0.5f, 0.7f, 1};
    static const double four[] = {20, 19.19, 16.98, 10.50, 4.99, 1.25, 1, 1};
    static const double three[] = {20, 18.76, 15.49, 11.54, 9.59, 6.57, 4.10, 1};
    (void)state;
    clear_cases(COUNT(four));
    for (size_t i = 0; i < COUNT(four); ++i) {
        set_hit_dist_case(i, 0.0f, 0.0f, roughness[i]);
        case_in(i)[8] = 1.0f; /* A, so that the scale is the roughness factor */
    }
    run(SM_HIT_DIST_SCALE, COUNT(four));
    for (size_t i = 0; i < COUNT(four); ++i) {
        assert_near(case_out(i), &four[i], 1, 0.0065);
        assert_near(case_out(i) + 1, &three[i], 1, 0.0065);
        assert_true(case_out(i)[2] == case_out(i)[0]); /* the default form */
    }
}

static void hit_distance_normalises_as_documented(void **state) {
    static const float hit_dist[] = {0, 2, 8, 65504.0f, 1e9f, INFINITY, NAN, -1};
    static const double expected[] = {0, 0.5, 1, 1, 1, 1, 0, 0};
    (void)state;
    clear_cases(COUNT(hit_dist));
    for (size_t i = 0; i < COUNT(hit_dist); ++i) set_hit_dist_case(i, hit_dist[i], i % 2 ? 10.0f : -10.0f, 1.0f);
    run(SM_NORMALIZE_HIT_DIST, COUNT(hit_dist));
    for (size_t i = 0; i < COUNT(hit_dist); ++i) assert_near(case_out(i), &expected[i], 1, 1e-6);
    assert_true(case_out(0)[0] == 0.0f && case_out(3)[0] == 1.0f && case_out(6)[0] == 0.0f);
}

static void normalised_hit_distance_is_monotone_and_invertible(void **state) {
    const uint32_t count = 4096;
    (void)state;
    clear_cases(2 * count);
    for (uint32_t i = 0; i < count; ++i) {
        float hit_dist = 10.0f * (float)i / (float)count;
        set_hit_dist_case(i, hit_dist, 7.0f, 0.4f);
        set_hit_dist_case(count + i, hit_dist, -7.0f, 0.4f);
    }
    run(SM_NORMALIZE_HIT_DIST, 2 * count);
    for (uint32_t i = 0; i < count; ++i) {
        const float *out = case_out(i);
        assert_true(out[0] == case_out(count + i)[0]); /* the sign of view_z does not matter */
        if (i > 0) assert_true(out[0] >= case_out(i - 1)[0]);
        if (i > 0) assert_true(out[0] > 0.0f);
        if (out[0] < 1.0f) assert_true(fabsf(out[1] - case_in(i)[0]) <= 1e-5f * case_in(i)[0]);
    }
    assert_true(case_out(count - 1)[0] == 1.0f);
}

static void specular_average_is_the_nearest_valid_hit(void **state) {
    static const float hits[][4] = {
        {3, 0, 5, 0}, {0, 0, 0, 0}, {65504, 65504, 0, 0}, {INFINITY, NAN, -2, 2e6f}, {NAN, 7, NAN, 1e30f}};
    static const float expected[] = {3, 0, 65504, 65504, 7};
    (void)state;
    clear_cases(COUNT(hits));
    for (size_t i = 0; i < COUNT(hits); ++i) set_case(i, 0, 4, hits[i]);
    run(SM_SPECULAR_AVERAGE, COUNT(hits));
    for (size_t i = 0; i < COUNT(hits); ++i) {
        assert_true(case_out(i)[0] == expected[i]);
        assert_true(case_out(i)[1] == 0.0f);
    }
}

/* ---- radiance -------------------------------------------------------------------------------------------------- */

static void colours_convert_to_the_documented_luma_and_chroma(void **state) {
    static const float rgb[][3] = {{1, 0, 0}, {0, 1, 0}, {0.2f, 0.5f, 0.9f}};
    static const double ycocg[][3] = {{0.25, 0.5, -0.25}, {0.5, 0, 0.5}, {0.525, -0.35, -0.025}};
    (void)state;
    clear_cases(COUNT(rgb));
    for (size_t i = 0; i < COUNT(rgb); ++i) set_case(i, 0, 3, rgb[i]);
    run(SM_RGB_TO_YCOCG, COUNT(rgb));
    for (size_t i = 0; i < COUNT(rgb); ++i) {
        assert_near(case_out(i), ycocg[i], 3, 1e-7);
        assert_near(case_out(i) + 3, ycocg[i], 1, 1e-7);
    }
}

/* Largest error of rgb -> texel -> rgb over the largest component, with `store` between. */
static double radiance_round_trip(uint32_t count, bool through_half) {
    float (*original)[4] = calloc(count, sizeof *original);
    double worst = 0.0;
    assert_non_null(original);
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) {
        float scale = random_log(0.01f, 100.0f);
        for (int k = 0; k < 3; ++k) original[i][k] = scale * (random_u32() % 4 ? random_unit() : 0.0f);
        original[i][3] = random_unit();
        set_case(i, 0, 4, original[i]);
    }
    run(SM_PACK_RADIANCE, count);
    for (uint32_t i = 0; i < count; ++i)
        for (int k = 0; k < 4; ++k)
            case_in(i)[k] = through_half ? (float)ref_round_to_half(case_out(i)[k]) : case_out(i)[k];
    run(SM_UNPACK_RADIANCE, count);
    for (uint32_t i = 0; i < count; ++i) {
        double largest = fmax(fmax(original[i][0], original[i][1]), fmax(original[i][2], 1e-30));
        for (int k = 0; k < 3; ++k) worst = fmax(worst, fabs((double)case_out(i)[k] - original[i][k]) / largest);
        assert_true(case_out(i)[0] >= 0.0f && case_out(i)[1] >= 0.0f && case_out(i)[2] >= 0.0f);
    }
    free(original);
    return worst;
}

static void radiance_survives_storage(void **state) {
    (void)state;
    random_state = 3;
    double in_floats = radiance_round_trip(16384, false), in_halves = radiance_round_trip(16384, true);
    print_message("  round trip, relative to the largest component: 32-bit %.2e (bound 1e-6), 16-bit %.2e (2e-3)\n",
                  in_floats, in_halves);
    assert_true(in_floats <= 1e-6);
    assert_true(in_halves <= 2e-3);
}

static void bad_radiance_never_reaches_a_texel(void **state) {
    static const float bad[] = {NAN, INFINITY, -INFINITY, -1.0f, 1e9f, -NAN};
    (void)state;
    clear_cases(4 * COUNT(bad));
    for (size_t i = 0; i < 4 * COUNT(bad); ++i) {
        static const float good[] = {1.0f, 2.0f, 3.0f, 0.5f};
        set_case(i, 0, 4, good);
        case_in(i)[i % 4] = bad[i / 4];
    }
    run(SM_PACK_RADIANCE, 4 * COUNT(bad));
    for (size_t i = 0; i < 4 * COUNT(bad); ++i) {
        const float *out = case_out(i);
        bool is_number = isfinite(bad[i / 4]), hit_dist_is_bad = i % 4 == 3;
        for (int k = 0; k < 4; ++k) assert_true(isfinite(out[k]) && fabsf(out[k]) <= 65504.0f);
        assert_true(out[3] >= 0.0f && out[3] <= 1.0f);
        assert_true(hit_dist_is_bad || out[3] == 0.5f);
        if (!hit_dist_is_bad && !is_number) assert_true(out[0] == 0.0f && out[1] == 0.0f && out[2] == 0.0f);
        if (hit_dist_is_bad && !is_number) assert_true(out[3] == 0.0f);
        if (hit_dist_is_bad) assert_true(out[0] == 2.0f);
    }
}

static void luma_and_chroma_are_linear(void **state) {
    static const float a[] = {1.0f, 4.0f, 0.25f}, b[] = {8.0f, 0.5f, 2.0f}, blend[] = {4.5f, 2.25f, 1.125f};
    (void)state;
    clear_cases(3);
    set_case(0, 0, 3, a);
    set_case(1, 0, 3, b);
    set_case(2, 0, 3, blend); /* half of each; exact in binary */
    run(SM_RGB_TO_YCOCG, 3);
    for (int k = 0; k < 4; ++k) assert_true(case_out(2)[k] == 0.5f * case_out(0)[k] + 0.5f * case_out(1)[k]);
}

static void rounded_values_are_stored_unchanged(void **state) {
    const uint32_t count = 16384;
    uint16_t *texels = malloc(MAX_CASES * 4 * sizeof *texels);
    (void)state;
    assert_non_null(texels);
    random_state = 4;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) fill_finite(case_in(i));
    run(SM_STORE_HALF, count);
    require(gpu_download(&device.gpu, &device.half, texels));
    for (uint32_t i = 0; i < 4 * count; ++i) {
        double value = ref_round_to_half(case_in(i / 4)[i % 4]);
        uint16_t expected = half_bits(value);
        if (value == 0.0) expected = texels[i] & 0x8000u; /* either zero may lose its sign */
        if (texels[i] != expected)
            fail_msg("%.9g is stored as 0x%04x, expected 0x%04x", case_in(i / 4)[i % 4], texels[i], expected);
    }
    free(texels);
}

/* ---- material and motion --------------------------------------------------------------------------------------- */

static void environment_term_matches_its_table(void **state) {
    static const float cosine_roughness[][2] = {{1, 0}, {1, 0.6f}, {0.5f, 0.3f}, {0.1f, 0}, {0.1f, 1}};
    static const double bias[] = {-0.0047, -0.0005, 0.0322, 0.6376, 0.0102};
    static const double scale[] = {1.0416, 0.8073, 0.9229, 0.3569, 0.5443};
    static const double dielectric[] = {0.0370, 0.0318, 0.0692, 0.6519, 0.0320};
    (void)state;
    clear_cases(COUNT(bias));
    for (size_t i = 0; i < COUNT(bias); ++i) {
        float *in = case_in(i);
        in[3] = cosine_roughness[i][1];
        in[12] = 0.04f, in[13] = 0.0f, in[14] = 0.3f, in[15] = cosine_roughness[i][0];
    }
    run(SM_ENVIRONMENT_TERM, COUNT(bias));
    for (size_t i = 0; i < COUNT(bias); ++i) {
        double m = pow(cosine_roughness[i][1], 4.0) > 0.0 ? pow(cosine_roughness[i][1], 2.0) : 0.0;
        double clamped_bias = fmax(bias[i], 0.0), metal = bias[i] + 0.3 * scale[i];
        assert_true(fabs(ref_environment_bias(cosine_roughness[i][0], m) - bias[i]) <= 6e-5);
        assert_true(fabs(ref_environment_scale(cosine_roughness[i][0], m) - scale[i]) <= 6e-5);
        assert_near(case_out(i), &dielectric[i], 1, 6e-5);
        assert_near(case_out(i) + 1, &clamped_bias, 1, 6e-5);
        assert_near(case_out(i) + 2, &metal, 1, 1e-4);
    }
}

static void material_factors_stay_in_range(void **state) {
    const uint32_t count = 16384;
    (void)state;
    random_state = 5;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) {
        fill_material(case_in(i));
        case_in(i)[8] = 0.0f; /* red albedo of a metal */
        case_in(i)[9] = 1.0f; /* green albedo of a white furnace */
    }
    run(SM_MATERIAL_FACTORS, count);
    for (uint32_t i = 0; i < count; ++i) {
        const float *out = case_out(i);
        for (int k = 0; k < 7; ++k) assert_true(k == 3 || (out[k] >= 0.02f - 1e-6f && out[k] <= 1.0f + 1e-6f));
        assert_true(fabsf(out[0] - 0.02f) <= 1e-6f);
        assert_true(out[1] + out[5] <= 1.02f + 1e-5f);
    }
}

static void modulation_undoes_demodulation(void **state) {
    const uint32_t count = 4096;
    double worst = 0.0;
    (void)state;
    random_state = 6;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) fill_material(case_in(i));
    run(SM_DEMODULATE, count);
    for (uint32_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            double colour = case_in(i)[8 + k], product = (double)case_out(i)[k] * case_out(i)[4 + k];
            worst = fmax(worst, fabs(product - colour * colour)); /* (c f) (c / f) = c c */
        }
    print_message("  error %.2e (bound 5e-7)\n", worst);
    assert_true(worst <= 5e-7);
}

static void nothing_moves_in_a_static_scene(void **state) {
    const uint32_t count = 1024;
    (void)state;
    random_state = 7;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) {
        fill_motion(case_in(i));
        set_case(i, 4, 4, case_in(i));
        case_in(i)[9] = case_in(i)[8];
    }
    run(SM_MOTION, count);
    for (uint32_t i = 0; i < count; ++i)
        for (int k = 0; k < 7; ++k) assert_true(case_out(i)[k] == 0.0f);
}

static void motion_points_to_the_previous_position(void **state) {
    static const float clips[] = {0, 0, 0.5f, 2, 1, -1, 0.5f, 2, 5, 4}; /* centre; was at ndc (0.5,-0.5); depths */
    static const double expected[] = {0.25, -0.25, -1};
    static const float behind[] = {0, 0, 0.5f, 2, 1, -1, 0.5f, -2, 5, -4};
    static const double off_screen[] = {-1.5, -1.5, -9};
    (void)state;
    clear_cases(2);
    set_case(0, 0, 10, clips);
    set_case(1, 0, 10, behind);
    run(SM_MOTION, 2);
    assert_near(case_out(0), expected, 3, 1e-6);
    assert_near(case_out(1), off_screen, 3, 1e-6);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_function_agrees_with_double_precision),
        cmocka_unit_test(normals_pack_to_the_documented_texels),
        cmocka_unit_test(normals_survive_storage_within_the_documented_angles),
        cmocka_unit_test(every_roughness_encoding_survives_ten_bits),
        cmocka_unit_test(roughness_zero_keeps_the_sign_of_z_in_ten_bits),
        cmocka_unit_test(roughness_curve_matches_its_table),
        cmocka_unit_test(hit_dist_scale_matches_its_table),
        cmocka_unit_test(hit_distance_normalises_as_documented),
        cmocka_unit_test(normalised_hit_distance_is_monotone_and_invertible),
        cmocka_unit_test(specular_average_is_the_nearest_valid_hit),
        cmocka_unit_test(colours_convert_to_the_documented_luma_and_chroma),
        cmocka_unit_test(radiance_survives_storage),
        cmocka_unit_test(bad_radiance_never_reaches_a_texel),
        cmocka_unit_test(luma_and_chroma_are_linear),
        cmocka_unit_test(rounded_values_are_stored_unchanged),
        cmocka_unit_test(environment_term_matches_its_table),
        cmocka_unit_test(material_factors_stay_in_range),
        cmocka_unit_test(modulation_undoes_demodulation),
        cmocka_unit_test(nothing_moves_in_a_static_scene),
        cmocka_unit_test(motion_points_to_the_previous_position),
        cmocka_unit_test(validation_layer_has_no_complaint),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
