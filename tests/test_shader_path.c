/* Functions of nrd_shaders/nrd.glsl for paths, motion, mirrors, the choice of lobes and pixels, and up-sampling against double
   precision, and the properties that its comments promise. Prints the worst error per function. */
#include "shader_math_rig.h"

#include "nrd_reference_light.h"

/* ---- inputs ---------------------------------------------------------------------------------------------------- */

static void fill_path(float *in) {
    for (int i = 0; i < 4; ++i) in[i] = pick_hit_dist(), in[4 + i] = random_u32() % 2 ? pick_unit() : 0.2f * random_unit();
}

static void fill_strand(float *in) {
    static const float thin[] = {0.0f, 1e-3f, 1.0f, 1e4f};
    random_direction(in);
    random_direction(in + 4);
    if (random_u32() % 8 == 0) memcpy(in + 4, in, 3 * sizeof *in); /* a strand that points at the camera */
    if (random_u32() % 16 == 0) in[random_u32() % 3] = NAN;
    in[3] = edge_or(random_log(1e-5f, 1.0f), thin, COUNT(thin));
    in[7] = random_log(1e-5f, 1.0f);
}

/* A camera near the origin: columns of world_to_view and the projection's numbers (shader_math.glsl: projection_of). */
static void fill_camera(float *columns, float *projection, float sign) {
    float x[3], y[3], z[3];
    double length;
    random_direction(z);
    do {
        random_direction(x);
        for (int i = 0; i < 3; ++i) y[i] = z[(i + 1) % 3] * x[(i + 2) % 3] - z[(i + 2) % 3] * x[(i + 1) % 3];
        length = sqrt((double)y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
    } while (length < 0.1);
    for (int i = 0; i < 3; ++i) y[i] /= (float)length;
    for (int i = 0; i < 3; ++i) x[i] = y[(i + 1) % 3] * z[(i + 2) % 3] - y[(i + 2) % 3] * z[(i + 1) % 3];
    for (int i = 0; i < 3; ++i) columns[4 * i] = x[i], columns[4 * i + 1] = y[i], columns[4 * i + 2] = z[i], columns[4 * i + 3] = 0;
    for (int i = 0; i < 3; ++i) columns[12 + i] = random_between(-10.0f, 10.0f);
    columns[15] = 1.0f;
    projection[0] = random_between(0.5f, 3.0f);
    projection[1] = random_between(0.5f, 3.0f) * (random_u32() % 2 ? 1.0f : -1.0f);
    projection[2] = 0.1f;
    projection[3] = sign;
}

/* A world position before the camera (or behind it), from one in view space; columns are those of a rotation. */
static void place_point(const float *columns, float sign, bool behind, float *position) {
    float z = random_log(1.0f, 100.0f), view[3];
    view[0] = random_between(-1.0f, 1.0f) * z - columns[12];
    view[1] = random_between(-1.0f, 1.0f) * z - columns[13];
    view[2] = (behind ? -sign : sign) * z - columns[14];
    for (int i = 0; i < 3; ++i) position[i] = columns[4 * i] * view[0] + columns[4 * i + 1] * view[1] + columns[4 * i + 2] * view[2];
}

static void fill_points(float *in) {
    float sign = random_u32() % 2 ? 1.0f : -1.0f;
    fill_camera(in + 8, in + 40, sign);
    fill_camera(in + 24, in + 44, sign);
    place_point(in + 8, sign, false, in);
    place_point(in + 24, sign, random_u32() % 8 == 0, in + 4);
}

static void fill_mirrors(float *in) {
    for (int k = 0; k < 5; ++k) {
        if (k % 2) random_direction(in + 4 * k);
        else
            for (int i = 0; i < 3; ++i) in[4 * k + i] = random_between(-10.0f, 10.0f);
    }
}

static void fill_probability(float *in) {
    static const float edges[] = {0.0f, 1.0f, -1.0f, 2.0f, 0.25f, NAN, INFINITY, 1e-40f};
    in[0] = edge_or(random_unit(), edges, COUNT(edges));
    in[1] = random_u32() % 2 ? 1.0f : 2.0f;
}

static void fill_pixel(float *in) {
    for (int i = 0; i < 3; ++i) in[i] = (float)(random_u32() % 4096);
    in[3] = random_unit() * 0.999999f;
}

/* Taps on the same surface, or so far off that their weight is 0. */
static void fill_upsample(float *in) {
    bool none = random_u32() % 8 == 0;
    in[0] = random_u32() % 2 ? 0.25f : 0.75f;
    in[1] = random_u32() % 4 ? in[0] : random_unit();
    in[2] = pick_view_z();
    in[3] = random_unit();
    for (int k = 0; k < 4; ++k) {
        bool far = none || random_u32() % 4 == 0;
        in[4 + k] = far ? in[2] * random_between(4.0f, 10.0f) + 1.0f : in[2] * (1.0f + random_between(-0.01f, 0.01f));
        if (random_u32() % 16 == 0) in[4 + k] = random_u32() % 2 ? NAN : INFINITY;
        in[8 + k] = random_u32() % 4 ? random_between(0.8f, 1.0f) : random_between(-1.0f, 1.0f);
    }
}

/* ---- double precision ------------------------------------------------------------------------------------------ */

static void reference_path(const double *in, double *out) {
    double share = 1.0;
    out[0] = out[1] = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (in[i] > 0.0) out[0] += share * fmin(in[i], REF_MISS);
        share *= exp2(-200.0 * in[4 + i] * in[4 + i]);
    }
    out[0] = fmin(out[0], REF_MISS);
}

static void reference_strand(const double *in, double *out) {
    double cosine = ref_dot(in, in + 4), across[3];
    for (int i = 0; i < 3; ++i) across[i] = in[4 + i] - cosine * in[i];
    double length = ref_length(across);
    for (int i = 0; i < 3; ++i) out[i] = length > 1e-3 ? across[i] / length : in[4 + i];
    out[3] = 0.0;
    out[4] = ref_clamp(0.5 * in[7] / (in[3] + REF_EPSILON), 0.0, 1.0);
}

static void project(const double *position, const double *columns, const double *p, double uv[2], double *view_z) {
    double view[3];
    for (int r = 0; r < 3; ++r)
        view[r] = columns[r] * position[0] + columns[4 + r] * position[1] + columns[8 + r] * position[2] + columns[12 + r];
    double clip[4] = {p[0] * view[0], p[1] * view[1], p[2], p[3] * view[2]};
    ref_clip_to_uv(clip, uv);
    *view_z = view[2];
}

static void reference_points(const double *in, double *out) {
    double uv[2], uv_prev[2], z, z_prev;
    project(in, in + 8, in + 40, uv, &z);
    project(in + 4, in + 24, in + 44, uv_prev, &z_prev);
    out[0] = uv_prev[0] - uv[0];
    out[1] = uv_prev[1] - uv[1];
    out[2] = z_prev - z;
    out[3] = 0.0;
}

static void reflect_point(const double position[3], const double normal[3], double point[3]) {
    double distance = 0.0;
    for (int i = 0; i < 3; ++i) distance += normal[i] * (point[i] - position[i]);
    for (int i = 0; i < 3; ++i) point[i] -= 2.0 * distance * normal[i];
}

/* The second mirror first: the first one shows what the second shows. */
static void reference_mirrors(const double *in, double *out) {
    static const double origin[3] = {0, 0, 0};
    memcpy(out, in + 16, 3 * sizeof *out);
    reflect_point(in + 8, in + 12, out);
    reflect_point(in, in + 4, out);
    memcpy(out + 4, in + 4, 3 * sizeof *out);
    reflect_point(origin, in + 12, out + 4);
    reflect_point(origin, in + 4, out + 4);
    out[3] = 0.0;
}

static void reference_probability(const double *in, double *out) {
    double least = in[1] == 1.0 ? 1.0 / 4.0 : 1.0 / 16.0;
    out[0] = isnan(in[0]) ? least : ref_clamp(in[0], least, 1.0 - least);
}

static void reference_threshold(const double *in, double *out) {
    static const int bayer[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    int level = bayer[(int)in[1] % 4][(int)in[0] % 4];
    out[0] = ((level + 7 * (int)in[2]) % 16 + in[3]) / 16.0;
}

static void reference_checkerboard(const double *in, double *out) {
    out[0] = fmod(in[0] + in[1] + in[2], 2.0);
    out[1] = in[0]; /* the column that stores this pixel leads back to it */
}

static void reference_half_resolution(const double *in, double *out) {
    for (int i = 0; i < 2; ++i) out[i] = (in[i] + 0.5) / 2.0 - 0.5;
}

static void reference_upsample(const double *in, double *out) {
    double tolerance = fmax(0.01 * fabs(in[2]) / (0.05 + 0.95 * in[3]), REF_EPSILON), sum = 0.0, least = INFINITY;
    int nearest = -1;
    for (int k = 0; k < 4; ++k) {
        double bilinear = (k & 1 ? in[0] : 1.0 - in[0]) * (k & 2 ? in[1] : 1.0 - in[1]);
        double difference = fabs(in[4 + k] - in[2]), depth = difference / tolerance;
        out[k] = depth < 8.0 ? bilinear * pow(ref_clamp(in[8 + k], 0.0, 1.0), 8.0) * exp2(-depth * depth) : 0.0;
        sum += out[k];
        if (isfinite(difference) && difference < least) least = difference, nearest = k;
    }
    for (int k = 0; k < 4; ++k) out[k] = sum > 1e-3 ? out[k] / sum : k == nearest ? 1.0 : 0.0;
}

static const comparison comparisons[] = {
    {"path_hit_dist_begin/add/end", SM_PATH_HIT_DIST, fill_path, reference_path, 2, 1e-3, 2e-5},
    {"strand_normal, .._thickness", SM_STRAND, fill_strand, reference_strand, 5, 1.0, 2e-4},
    {"motion_of_points", SM_MOTION_OF_POINTS, fill_points, reference_points, 4, 1.0, 2e-5},
    {"mirror_begin/add/point/direction", SM_MIRROR, fill_mirrors, reference_mirrors, 7, 10.0, 2e-6},
    {"clamp_lobe_probability", SM_LOBE_PROBABILITY, fill_probability, reference_probability, 1, 1.0, 0.0},
    {"split_threshold", SM_SPLIT_THRESHOLD, fill_pixel, reference_threshold, 1, 1.0, 1e-7},
    {"checkerboard_color, _x", SM_CHECKERBOARD, fill_pixel, reference_checkerboard, 2, 1.0, 0.0},
    {"half_resolution_position", SM_HALF_RESOLUTION, fill_pixel, reference_half_resolution, 2, 1.0, 0.0},
    {"upsample_weights", SM_UPSAMPLE, fill_upsample, reference_upsample, 4, 1.0, 1e-4},
};

static void every_function_agrees_with_double_precision(void **state) {
    (void)state;
    compare_all(comparisons, COUNT(comparisons));
}

/* ---- hit distance ---------------------------------------------------------------------------------------------- */

static void mirrors_add_up_and_rough_surfaces_end_a_path(void **state) {
    static const float segments[][8] = {
        {1, 2, 3, 0, 0, 0, 1, 1},           /* two mirrors */
        {1, 2, 3, 0, 1, 0, 0, 0},           /* a rough surface first */
        {65504, 0, 0, 0, 0, 0, 0, 0},       /* into the sky */
        {1, INFINITY, 0, 0, 0, 1, 1, 1},    /* a mirror that shows the sky */
        {1, 65504, 0, 0, 1, 1, 1, 1},       /* a rough surface under the sky */
        {0, 0, 0, 0, 1, 1, 1, 1}};          /* not sampled */
    static const double expected[] = {6, 1, 65504, 65504, 1, 0};
    (void)state;
    clear_cases(COUNT(segments));
    for (size_t i = 0; i < COUNT(segments); ++i) set_case(i, 0, 8, segments[i]);
    run(SM_PATH_HIT_DIST, COUNT(segments));
    for (size_t i = 0; i < COUNT(segments); ++i) assert_near(case_out(i), &expected[i], 1, 1e-6);
}

/* ---- motion ---------------------------------------------------------------------------------------------------- */

static void nothing_moves_before_a_camera_that_stands(void **state) {
    const uint32_t count = 1024;
    (void)state;
    random_state = 7;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) {
        float *in = case_in(i);
        fill_points(in);
        memcpy(in + 4, in, 3 * sizeof *in);
        memcpy(in + 24, in + 8, 16 * sizeof *in);
        memcpy(in + 44, in + 40, 4 * sizeof *in);
    }
    run(SM_MOTION_OF_POINTS, count);
    for (uint32_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) assert_true(case_out(i)[k] == 0.0f);
}

/* A camera ray to a mirror and on to a point has the point's image on its straight continuation, at the length of the path. */
static void images_lie_on_the_continued_camera_ray(void **state) {
    const uint32_t count = 4096;
    (void)state;
    random_state = 9;
    clear_cases(count);
    for (uint32_t i = 0; i < count; ++i) {
        float ray[3], *in = case_in(i), *mirror = in, *normal = in + 4, *point = in + 16;
        random_direction(ray);
        random_direction(normal);
        float first = random_between(1.0f, 10.0f), second = random_between(0.1f, 10.0f), cosine = 0.0f;
        for (int k = 0; k < 3; ++k) mirror[k] = first * ray[k], cosine += ray[k] * normal[k];
        for (int k = 0; k < 3; ++k) point[k] = mirror[k] + second * (ray[k] - 2.0f * cosine * normal[k]);
        memcpy(in + 8, point, 3 * sizeof *in); /* the second mirror holds the point: its image is itself */
        random_direction(in + 12);
        in[20] = first + second;
        memcpy(in + 24, ray, sizeof ray);
    }
    run(SM_MIRROR, count);
    for (uint32_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) assert_true(fabsf(case_out(i)[k] - case_in(i)[20] * case_in(i)[24 + k]) <= 4e-5f);
}

/* ---- choice of lobes and pixels -------------------------------------------------------------------------------- */

/* thresholds[frame][y][x] over 20 frames and a 4x4 tile. */
static void evaluate_thresholds(float thresholds[20][4][4], float random) {
    clear_cases(320);
    for (int i = 0; i < 320; ++i) {
        float *in = case_in(i);
        in[0] = (float)(i % 4 + 8), in[1] = (float)(i / 4 % 4 + 4), in[2] = (float)(i / 16), in[3] = random;
    }
    run(SM_SPLIT_THRESHOLD, 320);
    for (int i = 0; i < 320; ++i) thresholds[i / 16][i / 4 % 4][i % 4] = case_out(i)[0];
}

static void count_lobes(float t[4][4], int x, int y, int radius, float p, int count[2]) {
    for (int dy = -radius; dy <= radius; ++dy)
        for (int dx = -radius; dx <= radius; ++dx) count[t[(y + dy + 4) % 4][(x + dx + 4) % 4] < p]++;
}

static void every_neighbourhood_holds_both_lobes(void **state) {
    static float thresholds[20][4][4];
    static const float randoms[] = {0.0f, 0.5f, 0.999999f};
    (void)state;
    for (size_t r = 0; r < COUNT(randoms); ++r) {
        evaluate_thresholds(thresholds, randoms[r]);
        for (int i = 0; i < 20 * 16; ++i)
            for (int radius = 1; radius <= 2; ++radius)
                for (int side = 0; side < 2; ++side) {
                    int count[2] = {0, 0};
                    float least = radius == 1 ? 0.25f : 0.0625f;
                    count_lobes(thresholds[i / 16], i % 4, i / 4 % 4, radius, side ? least : 1.0f - least, count);
                    assert_true(count[0] > 0 && count[1] > 0);
                }
    }
}

static void sixteen_frames_give_every_level_once(void **state) {
    static float thresholds[20][4][4];
    (void)state;
    evaluate_thresholds(thresholds, 0.0f);
    for (int i = 0; i < 16; ++i) {
        uint32_t levels = 0;
        for (int frame = 4; frame < 20; ++frame) levels |= 1u << (int)(thresholds[frame][i / 4][i % 4] * 16.0f);
        assert_int_equal(levels, 0xffff);
    }
}

/* ---- up-sampling ----------------------------------------------------------------------------------------------- */

static void upsampling_of_a_plane_is_bilinear(void **state) {
    static const float plane[] = {0.25f, 0.75f, 5, 1, 5, 5, 5, 5, 1, 1, 1, 1};
    static const double expected[] = {0.1875, 0.0625, 0.5625, 0.1875};
    (void)state;
    clear_cases(1);
    set_case(0, 0, 12, plane);
    run(SM_UPSAMPLE, 1);
    assert_near(case_out(0), expected, 4, 1e-6);
}

static void upsampling_never_takes_from_another_surface(void **state) {
    static const float cases[][12] = {
        {0.25f, 0.75f, 5, 1, 50, 5, 50, 50, 1, 1, 1, 1},              /* one tap at this depth */
        {0.25f, 0.75f, 5, 1, 50, 20, 30, 40, 1, 1, 1, 1},             /* none: the nearest */
        {0.25f, 0.75f, 5, 1, NAN, INFINITY, 30, NAN, 1, 1, 1, 1},     /* one number */
        {0.25f, 0.75f, 5, 1, NAN, INFINITY, NAN, -INFINITY, 1, 1, 1, 1},
        {0.25f, 0.75f, 5, 1, 5, 5, 5, 5, 0, 0, 1, -1}};               /* one tap with this normal */
    static const double expected[][4] = {{0, 1, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 0}, {0, 0, 1, 0}};
    (void)state;
    clear_cases(COUNT(cases));
    for (size_t i = 0; i < COUNT(cases); ++i) set_case(i, 0, 12, cases[i]);
    run(SM_UPSAMPLE, COUNT(cases));
    for (size_t i = 0; i < COUNT(cases); ++i) assert_near(case_out(i), expected[i], 4, 1e-6);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_function_agrees_with_double_precision),
        cmocka_unit_test(mirrors_add_up_and_rough_surfaces_end_a_path),
        cmocka_unit_test(nothing_moves_before_a_camera_that_stands),
        cmocka_unit_test(images_lie_on_the_continued_camera_ray),
        cmocka_unit_test(every_neighbourhood_holds_both_lobes),
        cmocka_unit_test(sixteen_frames_give_every_level_once),
        cmocka_unit_test(upsampling_of_a_plane_is_bilinear),
        cmocka_unit_test(upsampling_never_takes_from_another_surface),
        cmocka_unit_test(validation_layer_has_no_complaint),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
