/* Functions of nrd_shaders/nrd.glsl for light with a direction, re-jitter, occlusion, shadows and RELAX against double precision, and
   the tables and properties that its comments promise. Prints the worst error per function. */
#include "shader_math_rig.h"

#include "nrd_reference_light.h"

/* ---- inputs ---------------------------------------------------------------------------------------------------- */

static void fill_pack(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = random_u32() % 2 ? pick_any() : pick_radiance();
    pick_normal(in + 4);
    if (random_u32() % 8 == 0) in[4 + random_u32() % 3] = pick_any();
    in[7] = 1.0f; /* sanitise */
}

static void fill_pack_legal(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = pick_radiance();
    random_direction(in + 4);
    in[7] = random_u32() % 2 ? 1.0f : 0.0f;
}

/* A pair as denoising leaves it: any colour, a moment up to its luma long. One in eight has no direction, or no light. */
static void fill_pair(float *sh0, float *sh1) {
    double rgb[3], ycocg[3];
    float length = random_u32() % 8 ? pick_unit() : 0.0f;
    for (int i = 0; i < 3; ++i) rgb[i] = random_u32() % 4 ? random_unit() : 0.0f;
    if (random_u32() % 16 == 0) rgb[0] = rgb[1] = rgb[2] = 0.0;
    ref_rgb_to_ycocg(rgb, ycocg);
    random_direction(sh1);
    for (int i = 0; i < 3; ++i) sh0[i] = (float)ycocg[i], sh1[i] *= length * (float)ycocg[0];
    sh0[3] = random_unit();
    sh1[3] = random_unit();
}

/* Unit vector within the hemisphere of n; grazing ones included. */
static void pick_view(const float n[3], float v[3]) {
    random_direction(v);
    float cosine = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
    for (int i = 0; i < 3; ++i) v[i] = cosine < 0.0f ? -v[i] : v[i];
    if (random_u32() % 8 == 0) memcpy(v, n, 3 * sizeof *v);
}

static void fill_resolve(float *in) {
    fill_pair(in, in + 4);
    random_direction(in + 8);
    in[11] = pick_unit();
    pick_view(in + 8, in + 12);
    in[15] = pick_unit();
}

static void fill_rotate(float *in) {
    fill_pair(in, in + 4);
    for (int i = 0; i < 3; ++i) random_direction(in + 8 + 4 * i);
}

/* Mean normals of any length that their conditioning allows: exactly 1, 0, or up to 0.999. */
static void fill_mean_normal(float *in) {
    static const float up[] = {0, 0, 1}, none[] = {0, 0, 0};
    float length = random_between(0.0f, 0.999f);
    random_direction(in + 8);
    for (int i = 0; i < 3; ++i) in[8 + i] *= length;
    if (random_u32() % 8 == 0) memcpy(in + 8, random_u32() % 2 ? up : none, sizeof up);
    in[11] = pick_unit();
}

/* Neighbours on the same surface, well inside the tolerance, or one of them well outside. */
static void fill_rejitter(float *in) {
    uint32_t odd = random_u32() % 16;
    fill_pair(in, in + 4);
    fill_pair(in + 16, in + 20);
    random_direction(in + 8);
    in[11] = pick_unit();
    pick_view(in + 8, in + 12);
    in[15] = random_log(0.1f, 1000.0f) * (random_u32() % 2 ? 1.0f : -1.0f);
    for (int k = 0; k < 4; ++k) {
        float *n = in + 28 + 4 * k, length = 0.0f;
        in[24 + k] = in[15] * (1.0f + random_between(-0.005f, 0.005f));
        for (int i = 0; i < 3; ++i) n[i] = in[8 + i] + random_between(-0.3f, 0.3f);
        for (int i = 0; i < 3; ++i) length += n[i] * n[i];
        for (int i = 0; i < 3; ++i) n[i] /= sqrtf(length);
    }
    if (odd < 4) in[24 + odd] = in[15] * 1.5f;
    else if (odd < 8)
        for (int i = 0; i < 3; ++i) in[28 + 4 * (odd - 4) + i] = -in[8 + i];
}

static void fill_occlusion(float *in) {
    fill_pack(in);
    in[3] = random_u32() % 2 ? pick_any() : pick_unit();
}

static void fill_occlusion_texel(float *in) {
    float open = pick_unit(), length = open * random_unit();
    random_direction(in);
    for (int i = 0; i < 3; ++i) in[i] *= length;
    in[3] = open;
    random_direction(in + 8);
}

static void fill_relax(float *in) {
    fill_pack(in);
    for (int i = 0; i < 4; ++i) in[4 + i] = pick_radiance();
}

static void fill_penumbra(float *in) {
    in[0] = pick_hit_dist();
    in[1] = random_log(1e-3f, 1e4f);
    in[2] = random_log(1e-4f, 10.0f);
    in[3] = pick_unit();
    for (int i = 0; i < 3; ++i) in[4 + i] = random_u32() % 4 ? pick_unit() : pick_any();
}

static void fill_lights(float *in) {
    static const float edges[] = {0.0f, 6.103515625e-5f, 32768.0f, 65504.0f};
    for (int light = 0; light < 2; ++light) {
        bool faces_away = random_u32() % 8 == 0;
        for (int i = 0; i < 3; ++i) in[4 * light + i] = faces_away ? 0.0f : random_log(1e-3f, 1e3f);
        in[4 * light + 3] = edge_or(random_log(1e-4f, 100.0f), edges, COUNT(edges));
    }
    for (int i = 0; i < 3; ++i) in[8 + i] = pick_unit();
}

static void fill_signed(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = pick_radiance() * (random_u32() % 4 ? 1.0f : -1.0f);
}

/* ---- double precision ------------------------------------------------------------------------------------------ */

static ref_sg pair_of(const double *sh0, const double *sh1) {
    ref_sg sg;
    memcpy(sg.ycocg, sh0, sizeof sg.ycocg);
    memcpy(sg.moment, sh1, sizeof sg.moment);
    return sg;
}

static void reference_pack_relax(const double *in, double *out) {
    ref_sanitize_radiance(in, out);
    out[3] = ref_sanitize(in[3], REF_MISS);
    memcpy(out + 4, in + 4, 4 * sizeof *out);
}

static void reference_unpack_relax(const double *in, double *out) {
    for (int i = 0; i < 4; ++i) out[i] = i < 3 ? fmax(in[i], 0.0) : in[i];
}

static void reference_pack_sh(const double *in, double *out) {
    ref_pack_sh(in, in[3], in + 4, in[7] > 0.0, 1.0, out);
}

static void reference_pack_relax_sh(const double *in, double *out) {
    ref_pack_sh(in, in[3], in + 4, in[7] > 0.0, REF_MISS, out);
}

static void reference_color(const double *in, double *out) {
    ref_ycocg_to_rgb(in, true, out);
    out[3] = in[3];
    memcpy(out + 4, in + 4, 4 * sizeof *out);
}

static void reference_direction(const double *in, double *out) {
    ref_sg sg = pair_of(in, in + 4);
    double length = fmax(ref_length(sg.moment), REF_EPSILON);
    for (int i = 0; i < 3; ++i) out[i] = sg.moment[i] / length;
    out[3] = ref_sharpness(&sg) / 2000.0;
}

static void reference_rotate(const double *in, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = in[8 + i] * in[4] + in[12 + i] * in[5] + in[16 + i] * in[6];
    out[3] = in[0];
}

static void reference_roughness_aa(const double *in, double *out) {
    out[0] = ref_roughness_aa(in[11], in + 8);
}

static void reference_resolve_diffuse(const double *in, double *out) {
    ref_sg sg = pair_of(in, in + 4);
    ref_with_luma(&sg, ref_diffuse_luma(&sg, in + 8, in + 12, in[11]), out);
    out[3] = 0.0;
}

static void reference_resolve_specular(const double *in, double *out) {
    ref_sg sg = pair_of(in, in + 4);
    ref_with_luma(&sg, ref_specular_luma(&sg, in + 8, in + 12, in[11]), out);
    out[3] = 0.0;
}

static void reference_first_order(const double *in, double *out) {
    ref_sg sg = pair_of(in, in + 4);
    double axis[3];
    ref_dominant_direction(in + 8, in + 12, in[11], axis);
    ref_with_luma(&sg, ref_first_order_luma(&sg, in + 8), out);
    ref_with_luma(&sg, ref_first_order_luma(&sg, axis), out + 4);
    out[3] = 0.0;
}

static void reference_dominant(const double *in, double *out) {
    ref_dominant_direction(in + 8, in + 12, in[11], out);
    out[3] = 0.0;
    out[4] = ref_dominant_factor(in[15], in[11]);
}

static void reference_rejitter(const double *in, double *out) {
    ref_sg diffuse = pair_of(in, in + 4), specular = pair_of(in + 16, in + 20);
    double normals[4][3];
    for (int k = 0; k < 4; ++k) memcpy(normals[k], in + 28 + 4 * k, sizeof normals[k]);
    ref_rejitter(&diffuse, &specular, in + 12, in[11], in[15], in + 8, in + 24, (const double(*)[3])normals, out);
}

static void reference_pack_occlusion(const double *in, double *out) {
    double direction[3];
    ref_sanitize_direction(in + 4, direction);
    out[3] = out[4] = ref_sanitize(in[3], 1.0);
    for (int i = 0; i < 3; ++i) out[i] = direction[i] * out[3];
}

static void reference_unpack_occlusion(const double *in, double *out) {
    double length = ref_length(in);
    for (int i = 0; i < 3; ++i) {
        out[i] = length > 5e-7 ? in[i] / fmax(length, REF_EPSILON) : in[8 + i];
        out[4 + i] = in[i];
    }
    out[3] = ref_clamp(in[3], 0.0, 1.0);
    out[7] = in[3];
}

static double penumbra_of(double width, double occluder_dist) {
    if (!(occluder_dist > 0.0)) return 0.0;
    return occluder_dist >= REF_MISS ? REF_MISS : ref_clamp(width, ldexp(1.0, -14), 32768.0);
}

static void reference_penumbra(const double *in, double *out) {
    bool reached = in[0] >= REF_MISS, blocked = in[0] > 0.0;
    out[0] = penumbra_of(in[0] * in[2], in[0]);
    out[1] = penumbra_of(in[2] * in[0] / fmax(in[1] - in[0], REF_EPSILON), in[0]);
    out[2] = out[3] = in[3] * in[3];
    for (int i = 0; i < 3; ++i) out[4 + i] = reached ? 1.0 : blocked && ref_is_finite3(in + 4) ? ref_clamp(in[4 + i], 0.0, 1.0) : 0.0;
    out[7] = reached ? 1.0 : 0.0;
}

static void reference_lights(const double *in, double *out) {
    double sum = 0.0, weights = 0.0, light[3], unshadowed = 0.0;
    for (int k = 0; k < 2; ++k) {
        double withheld = 0.0;
        for (int i = 0; i < 3; ++i) {
            double share = (k ? 1.0 : 1.0 - in[8 + i]) * (i == 1 ? 0.5 : 0.25);
            withheld += share * in[4 * k + i];
            unshadowed += in[4 * k + i];
        }
        if (in[4 * k + 3] <= 0.0 || in[4 * k + 3] >= REF_MISS) continue;
        sum += withheld * in[4 * k + 3];
        weights += withheld;
    }
    for (int i = 0; i < 3; ++i) light[i] = fmax(in[i] + in[4 + i], REF_EPSILON);
    for (int i = 0; i < 3; ++i) out[i] = ref_clamp(in[i] * in[8 + i] / light[i], 0.0, 1.0);
    out[3] = 0.0;
    out[4] = weights > 0.0 ? sum / weights : unshadowed > 0.0 ? REF_MISS : 0.0;
}

static const comparison comparisons[] = {
    {"pack_relax_radiance_hit_dist", SM_PACK_RELAX, fill_relax, reference_pack_relax, 8, 1e-30, 0.0},
    {"unpack_relax_radiance_hit_dist", SM_UNPACK_RELAX, fill_signed, reference_unpack_relax, 4, 1e-30, 0.0},
    {"pack_sh", SM_PACK_SH, fill_pack, reference_pack_sh, 8, 65504.0, 2e-7},
    {"pack_sh, legal values", SM_PACK_SH, fill_pack_legal, reference_pack_sh, 4, 65504.0, 2e-7},
    {"pack_relax_sh", SM_PACK_RELAX_SH, fill_pack, reference_pack_relax_sh, 8, 65504.0, 2e-7},
    {"unpack_sh, sg_color", SM_SG_COLOR, fill_resolve, reference_color, 8, 1.0, 5e-7},
    {"sg_rotate", SM_SG_ROTATE, fill_rotate, reference_rotate, 4, 1.0, 5e-7},
    {"roughness_aa", SM_ROUGHNESS_AA, fill_mean_normal, reference_roughness_aa, 1, 1.0, 1e-5},
    {"resolve_diffuse", SM_RESOLVE_DIFFUSE, fill_resolve, reference_resolve_diffuse, 4, 1.0, 1e-5},
    {"resolve_specular", SM_RESOLVE_SPECULAR, fill_resolve, reference_resolve_specular, 4, 1.0, 1e-4},
    {"resolve_.._first_order", SM_RESOLVE_FIRST_ORDER, fill_resolve, reference_first_order, 8, 1.0, 2e-5},
    {"specular_dominant_..", SM_DOMINANT_DIRECTION, fill_resolve, reference_dominant, 5, 1.0, 2e-5},
    {"rejitter", SM_REJITTER, fill_rejitter, reference_rejitter, 2, 1.0, 1e-3},
    {"pack_.._occlusion", SM_PACK_OCCLUSION, fill_occlusion, reference_pack_occlusion, 5, 1.0, 2e-7},
    {"pack_.._penumbra, _translucency, ..", SM_PENUMBRA, fill_penumbra, reference_penumbra, 8, 1e-5, 1e-6},
    {"light_sum_begin/add/..", SM_LIGHT_SUM, fill_lights, reference_lights, 5, 1e-4, 2e-6},
    {"unpack_directional_occlusion, .._to_sg", SM_UNPACK_OCCLUSION, fill_occlusion_texel, reference_unpack_occlusion, 8, 1.0,
     5e-7},
};

static void every_function_agrees_with_double_precision(void **state) {
    (void)state;
    compare_all(comparisons, COUNT(comparisons));
}

/* Sharpness spans 2000 and is ill-conditioned for one direction: its error counts in the mean cosine that it stands for. */
static void direction_and_sharpness_agree_with_double_precision(void **state) {
    const uint32_t count = RANDOM_CASES;
    double worst = 0.0, worst_cosine = 0.0, host_worst = 0.0;
    (void)state;
    random_state = 3;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) fill_resolve(case_in(i));
    run(SM_SG_DIRECTION, count);
    for (uint32_t i = 0; i < count; ++i) {
        double in[SM_INPUTS], expected[4];
        float host[SM_OUTPUTS];
        to_doubles(case_in(i), in, SM_INPUTS);
        reference_direction(in, expected);
        run_on_host(SM_SG_DIRECTION, case_in(i), host);
        for (int k = 0; k < 3; ++k) worst = fmax(worst, fabs(case_out(i)[k] - expected[k]));
        for (int k = 0; k < 3; ++k) host_worst = fmax(host_worst, fabs(host[k] - expected[k]));
        worst_cosine = fmax(worst_cosine, fabs(ref_mean_cosine(case_out(i)[3]) - ref_mean_cosine(2000.0 * expected[3])));
        assert_true(case_out(i)[3] >= 0.0f && case_out(i)[3] <= 2000.1f);
    }
    print_message("  direction %.2e (bound 5e-7), on the host %.2e, sharpness as mean cosine %.2e (2e-6)\n", worst, host_worst,
                  worst_cosine);
    assert_true(worst <= 5e-7 && host_worst <= 5e-7);
    assert_true(worst_cosine <= 2e-6);
}

static void set_light(size_t i, const float direction[3], float luma, const float view[3], float roughness) {
    float *in = case_in(i);
    in[0] = luma;
    for (int k = 0; k < 3; ++k) in[4 + k] = direction[k] * luma, in[12 + k] = view[k];
    in[10] = 1.0f; /* normal: +z */
    in[11] = roughness;
}

/* ---- tables and properties ------------------------------------------------------------------------------------- */

#define DIAGONAL 0.70710678f

static void resolve_matches_its_tables(void **state) {
    static const float z[] = {0, 0, 1}, x[] = {1, 0, 0}, right[] = {DIAGONAL, 0, DIAGONAL}, left[] = {-DIAGONAL, 0, DIAGONAL};
    static const float *const light[] = {z, z, right, right, x}, *const view[] = {z, left, z, left, z};
    static const float diffuse_roughness[] = {0.5f, 1}, specular_roughness[] = {0.1f, 0.5f, 1};
    static const double diffuse[][2] = {{0.9997, 0.9997}, {1.0005, 1.0014}, {0.7984, 0.7999}, {0.7979, 0.7988}, {0.4367, 0.6551}};
    static const double specular[][3] = {{1.0053, 1.0053, 0.9985}, {1.0388, 1.0327, 0.9829}, {0.9890, 0.9740, 0.8142},
                                         {0.9751, 0.9550, 0.7884}, {0.3183, 0.3183, 0.3183}};
    (void)state;
    clear_cases(15);
    for (size_t i = 0; i < 10; ++i) set_light(i, light[i / 2], 1, view[i / 2], diffuse_roughness[i % 2]);
    run(SM_RESOLVE_DIFFUSE, 10);
    for (size_t i = 0; i < 10; ++i) assert_near(case_out(i) + 1, &diffuse[i / 2][i % 2], 1, 6e-5);
    for (size_t i = 0; i < 15; ++i) set_light(i, light[i / 3], 1, view[i / 3], specular_roughness[i % 3]);
    run(SM_RESOLVE_SPECULAR, 15);
    for (size_t i = 0; i < 15; ++i) assert_near(case_out(i) + 1, &specular[i / 3][i % 3], 1, 6e-5);
}

static void dominant_factor_matches_its_table(void **state) {
    static const float cosine_roughness[][2] = {{1, 0}, {1, 0.3f}, {0.5f, 0.6f}, {1, 1}, {0.1f, 1}};
    static const double factor[] = {1, 0.9915, 0.8278, 0, 0.1362};
    static const float z[] = {0, 0, 1};
    (void)state;
    clear_cases(COUNT(factor));
    for (size_t i = 0; i < COUNT(factor); ++i) {
        set_light(i, z, 1, z, cosine_roughness[i][1]);
        case_in(i)[15] = cosine_roughness[i][0];
    }
    run(SM_DOMINANT_DIRECTION, COUNT(factor));
    for (size_t i = 0; i < COUNT(factor); ++i) assert_near(case_out(i) + 4, &factor[i], 1, 6e-5);
}

/* Light 1 from everywhere, gathered by cosine-weighted samples of a front-lit surface: resolved, it is still 1. */
static void uniform_light_keeps_its_energy(void **state) {
    static const float roughness[] = {0.1f, 0.3f, 0.5f, 0.7f, 1};
    (void)state;
    clear_cases(2 * COUNT(roughness));
    for (size_t i = 0; i < 2 * COUNT(roughness); ++i) {
        static const float mean_direction[] = {0, 0, 2.0f / 3.0f}, front[] = {0, 0, 1}, oblique[] = {DIAGONAL, 0, DIAGONAL};
        set_light(i, mean_direction, 1, i < COUNT(roughness) ? front : oblique, roughness[i % COUNT(roughness)]);
    }
    run(SM_RESOLVE_DIFFUSE, 2 * COUNT(roughness));
    for (size_t i = 0; i < 2 * COUNT(roughness); ++i) assert_true(fabsf(case_out(i)[1] - 1.0f) <= 0.05f);
    run(SM_RESOLVE_FIRST_ORDER, COUNT(roughness));
    for (size_t i = 0; i < COUNT(roughness); ++i) assert_true(fabsf(case_out(i)[1] - 1.0f) <= 0.05f);
    run(SM_RESOLVE_SPECULAR, 2 * COUNT(roughness));
    for (size_t i = 0; i < 2 * COUNT(roughness); ++i) assert_true(fabsf(case_out(i)[1] - 1.0f) <= 0.05f);
}

static void resolved_light_scales_with_the_signal(void **state) {
    static const uint32_t operations[] = {SM_RESOLVE_DIFFUSE, SM_RESOLVE_SPECULAR, SM_RESOLVE_FIRST_ORDER};
    const uint32_t count = 4096;
    (void)state;
    for (size_t o = 0; o < COUNT(operations); ++o) {
        random_state = 4;
        clear_cases(2 * count);
        for (uint32_t i = 0; i < count; ++i) {
            fill_resolve(case_in(i));
            case_in(i)[0] += 0.01f; /* luma and moment far above the guards against divisions by 0 */
            for (int k = 4; k < 7; ++k) case_in(i)[k] *= fabsf(case_in(i)[k]) > 1e-5f;
            memcpy(case_in(count + i), case_in(i), SM_INPUTS * sizeof(float));
            for (int k = 0; k < 7; ++k) case_in(count + i)[k] *= k == 3 ? 1.0f : 16384.0f;
        }
        run(operations[o], 2 * count);
        for (uint32_t i = 0; i < count; ++i)
            for (int k = 0; k < 3; ++k) {
                double small = case_out(i)[k], large = case_out(count + i)[k] / 16384.0;
                assert_true(fabs(small - large) <= 1e-3 * fmax(small, 0.01));
            }
    }
}

static void no_light_resolves_to_black(void **state) {
    static const uint32_t operations[] = {SM_RESOLVE_DIFFUSE, SM_RESOLVE_SPECULAR, SM_RESOLVE_FIRST_ORDER, SM_SG_DIRECTION};
    static const float none[] = {0, 0, 0}, views[][3] = {{0, 0, 1}, {1, 0, 0}, {0, 0, -1}};
    (void)state;
    for (size_t o = 0; o < COUNT(operations); ++o) {
        clear_cases(9);
        for (size_t i = 0; i < 9; ++i) set_light(i, none, 0, views[i % 3], (float)(i / 3) * 0.5f);
        run(operations[o], 9);
        for (size_t i = 0; i < 9; ++i)
            for (int k = 0; k < 7; ++k) assert_true(fabsf(case_out(i)[k]) <= 4e-6f);
    }
}

/* A sample's moment is as long as its luma; blends of samples stay below. The colour is that of the plain texel. */
static void blends_keep_moments_below_luma(void **state) {
    const uint32_t count = 4096;
    float (*packed)[8] = calloc(count, sizeof *packed);
    (void)state;
    assert_non_null(packed);
    random_state = 6;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) fill_pack_legal(case_in(i));
    run(SM_PACK_SH, count);
    memcpy(packed, device.out, count * sizeof *packed);
    for (uint32_t i = 0; i < count; ++i) {
        float *in = case_in(i), t = random_unit();
        double moment[3];
        to_doubles(packed[i] + 4, moment, 3);
        assert_true(fabs(ref_length(moment) - packed[i][0]) <= 1e-6 * packed[i][0]);
        for (int k = 0; k < 8; ++k) in[k] = packed[i][k] * (1.0f - t) + packed[(i + 1) % count][k] * t;
        to_doubles(in + 4, moment, 3);
        assert_true(ref_length(moment) <= in[0] * (1.0 + 1e-6));
    }
    run(SM_SG_COLOR, count);
    for (uint32_t i = 0; i < count; ++i) memcpy(packed[i], case_out(i), 3 * sizeof(float));
    run(SM_UNPACK_RADIANCE, count);
    for (uint32_t i = 0; i < count; ++i) assert_memory_equal(packed[i], case_out(i), 3 * sizeof(float));
    free(packed);
}

/* How well Banerjee's sharpness reproduces the mean cosine that it was computed from. */
static void sharpness_stands_for_the_mean_cosine(void **state) {
    const uint32_t count = 1001;
    static const float z[] = {0, 0, 1};
    double worst = 0.0;
    (void)state;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) {
        float direction[] = {0, 0, (float)i / 1000.0f};
        set_light(i, direction, 1, z, 1);
    }
    run(SM_SG_DIRECTION, count);
    for (uint32_t i = 0; i < count; ++i) worst = fmax(worst, fabs(ref_mean_cosine(case_out(i)[3]) - i / 1000.0));
    print_message("  mean cosine of the lobe against that of the signal: %.4f (bound 0.013)\n", worst);
    assert_true(worst <= 0.013);
    assert_true(case_out(0)[3] == 0.0f && fabsf(case_out(1000)[3] - 2000.0f) <= 0.5f);
}

static void rejitter_leaves_flat_surfaces_and_edges_alone(void **state) {
    const uint32_t count = 4096;
    size_t different = 0;
    (void)state;
    random_state = 8;
    clear_cases(3 * count);
    for (uint32_t i = 0; i < 3 * count; ++i) {
        float *in = case_in(i);
        fill_rejitter(in);
        for (int k = 0; k < 4; ++k) in[24 + k] = in[15];
        if (i < count) /* flat */
            for (int k = 0; k < 4; ++k) memcpy(in + 28 + 4 * k, in + 8, 3 * sizeof *in);
        else if (i < 2 * count) /* a depth edge */
            in[24 + i % 4] = in[15] * 2.0f;
    }
    run(SM_REJITTER, 3 * count);
    for (uint32_t i = 0; i < 2 * count; ++i)
        for (int k = 0; k < 2; ++k) assert_true(fabsf(case_out(i)[k] - 1.0f) <= (i < count ? 3e-7f : 0.0f));
    for (uint32_t i = 2 * count; i < 3 * count; ++i)
        for (int k = 0; k < 2; ++k) {
            different += case_out(i)[k] != 1.0f;
            assert_true(case_out(i)[k] >= 0.5f && case_out(i)[k] <= 2.0f);
        }
    assert_true(different > count);
}

static void penumbrae_pack_as_documented(void **state) {
    static const float in[][7] = {/* occluder, light, radius, stored, transmission */
        {10, 5, 0.00465f, 0.5f, 0.25f, 2, -1}, {1, 5, 0.2f, 1, 0.5f, 0.5f, 0.5f}, {0, 5, 0.2f, 0, 1, 1, 1}, {65504, 5, 0.2f, 1, 0, 0, 0},
        {INFINITY, 5, 0.2f, 1, NAN, 0, 0}, {NAN, 5, 0.2f, 1, 1, 1, 1}, {1e-9f, 5, 0.2f, 1, NAN, 1, 1}, {7, 5, 0.2f, 1, 0, 0, 1}};
    static const double out[][8] = {/* directional, local, shadow, coloured shadow, translucency */
        {0.0465, 32768, 0.25, 0.25, 0.25, 1, 0, 0}, {0.2, 0.05, 1, 1, 0.5, 0.5, 0.5, 0}, {0, 0, 0, 0, 0, 0, 0, 0}, {65504, 65504, 1, 1, 1, 1, 1, 1},
        {65504, 65504, 1, 1, 1, 1, 1, 1}, {0, 0, 1, 1, 0, 0, 0, 0}, {6.103515625e-5, 6.103515625e-5, 1, 1, 0, 0, 0, 0}, {1.4, 32768, 1, 1, 0, 0, 1, 0}};
    const uint32_t count = sizeof in / sizeof in[0];
    (void)state;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) set_case(i, 0, 7, in[i]);
    run(SM_PENUMBRA, count);
    for (uint32_t i = 0; i < count; ++i) assert_near(case_out(i), out[i], 8, 1e-5);
}

static void lights_add_up_to_their_share_and_the_mean_of_their_penumbrae(void **state) {
    static const float in[][11] = {
        {1, 1, 1, 65504, 3, 3, 3, 0.5f, 1, 1, 1},          /* one reached, three times its light withheld */
        {1, 1, 1, 0.25f, 3, 3, 3, 0.5f, 0, 0, 0},          /* both blocked */
        {1, 0, 2, 65504, 0, 0, 0, 0, 1, 1, 1},             /* the second faces away */
        {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1}};                /* both do */
    static const double out[][5] = {{0.25, 0.25, 0.25, 0, 0.5}, {0, 0, 0, 0, 0.4375}, {1, 0, 1, 0, 65504}, {0, 0, 0, 0, 0}};
    (void)state;
    clear_cases(4);
    for (uint32_t i = 0; i < 4; ++i) set_case(i, 0, 11, in[i]);
    run(SM_LIGHT_SUM, 4);
    for (uint32_t i = 0; i < 4; ++i) assert_near(case_out(i), out[i], 5, 1e-5);
}

static void closed_directions_unpack_to_the_normal(void **state) {
    static const float closed[] = {0, 0, 0, 0}, normal[] = {0, 0.6f, 0.8f};
    static const double expected[] = {0, 0.6, 0.8, 0, 0, 0, 0, 0};
    (void)state;
    clear_cases(1);
    set_case(0, 0, 4, closed);
    set_case(0, 8, 3, normal);
    run(SM_UNPACK_OCCLUSION, 1);
    assert_near(case_out(0), expected, 8, 1e-7);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_function_agrees_with_double_precision),
        cmocka_unit_test(direction_and_sharpness_agree_with_double_precision),
        cmocka_unit_test(resolve_matches_its_tables),
        cmocka_unit_test(dominant_factor_matches_its_table),
        cmocka_unit_test(uniform_light_keeps_its_energy),
        cmocka_unit_test(resolved_light_scales_with_the_signal),
        cmocka_unit_test(no_light_resolves_to_black),
        cmocka_unit_test(blends_keep_moments_below_luma),
        cmocka_unit_test(sharpness_stands_for_the_mean_cosine),
        cmocka_unit_test(rejitter_leaves_flat_surfaces_and_edges_alone),
        cmocka_unit_test(penumbrae_pack_as_documented),
        cmocka_unit_test(lights_add_up_to_their_share_and_the_mean_of_their_penumbrae),
        cmocka_unit_test(closed_directions_unpack_to_the_normal),
        cmocka_unit_test(validation_layer_has_no_complaint),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
