/* Metrics: images whose scores are known, and the signals that captures hold. */
#include "common/metrics.h"
#include "common/signals.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define WIDTH 60
#define HEIGHT 50
#define PIXELS (WIDTH * HEIGHT)

static const metrics_scale plain = { 1.0, 1e-6, false };

/* Two images and a full mask, made anew for every test. */
typedef struct pair {
    image m, reference;
    unsigned char mask[PIXELS];
} pair;

static void fill(image *m, float r, float g, float b)
{
    const float rgb[3] = { r, g, b };
    for (int k = 0; k < m->channels; k++)
        for (int i = 0; i < PIXELS; i++)
            m->planes[k][i] = rgb[k];
}

static int make_pair(void **state)
{
    pair *p = calloc(1, sizeof *p);
    *state = p;
    if (!p || !image_create(&p->m, WIDTH, HEIGHT, 3) || !image_create(&p->reference, WIDTH, HEIGHT, 3))
        return -1;
    memset(p->mask, 1, sizeof p->mask);
    fill(&p->m, 2, 2, 2);
    fill(&p->reference, 2, 2, 2);
    return 0;
}

static int free_pair(void **state)
{
    pair *p = *state;
    image_destroy(&p->m);
    image_destroy(&p->reference);
    free(p);
    return 0;
}

static void near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.9g, expected %.9g within %g", value, expected, tolerance);
}

static metrics_summary compare(const pair *p)
{
    metrics m;
    assert_true(metrics_compare(&p->m, &p->reference, p->mask, &plain, &m));
    assert_int_equal(m.frames, 1);
    return metrics_summarise(&m);
}

static void identical_images_have_no_error(void **state)
{
    metrics_summary s = compare(*state);
    near(s.rel_mse, 0, 0);
    near(s.log_rmse, 0, 0);
    near(s.bias, 0, 0);
    near(s.ssim, 1, 1e-12);
    near(s.psnr, 120, 0);
}

static void a_brighter_constant_has_the_error_of_its_formulas(void **state)
{
    pair *p = *state;
    double t = pow(2.2 / 3.2, 1 / 2.2), t0 = pow(2.0 / 3.0, 1 / 2.2);
    fill(&p->m, 2.2f, 2.2f, 2.2f);
    metrics_summary s = compare(p);
    near(s.rel_mse, 0.04 / 4.01, 1e-7);
    near(s.rel_mse_trimmed, 0.04 / 4.01, 1e-7);
    near(s.bias, 0.1, 1e-7);
    near(s.tone_rmse, t - t0, 1e-7);
    near(s.psnr, -20 * log10(t - t0), 1e-5);
    near(s.log_rmse, log2(1.1), 1e-6);
    near(s.ssim, (2 * t * t0 + 1e-4) / (t * t + t0 * t0 + 1e-4), 1e-7);
}

static void channels_are_averaged_and_luminance_is_weighted(void **state)
{
    pair *p = *state;
    fill(&p->m, 1, 0, 0);
    fill(&p->reference, 0, 0, 0);
    near(compare(p).rel_mse, 100.0 / 3, 1e-9);
    fill(&p->m, 1, 4, 1);
    fill(&p->reference, 1, 2, 1);
    near(compare(p).bias, 2 * 0.7152 / (1 + 0.7152), 1e-9);
}

static void a_thousandth_of_fireflies_is_trimmed(void **state)
{
    pair *p = *state;
    for (int i = 0; i < PIXELS / 1000; i++)
        for (int k = 0; k < 3; k++)
            p->m.planes[k][i * 997] = 1002;
    metrics_summary s = compare(p);
    near(s.rel_mse, 1e6 / 4.01 / 1000, 1e-6);
    near(s.rel_mse_trimmed, 0, 0);
    p->m.planes[0][5] = 1002; /* one more than may be left out */
    assert_true(compare(p).rel_mse_trimmed > 1);
}

static void pixels_outside_the_mask_do_not_count(void **state)
{
    pair *p = *state;
    for (int i = 1; i < PIXELS; i += 2) {
        p->mask[i] = 0;
        p->m.planes[0][i] = p->m.planes[1][i] = NAN;
        p->m.planes[2][i] = -7;
    }
    metrics_bad bad = { 0, 0, 0 };
    metrics_summary s = compare(p);
    metrics_count_bad(&p->m, p->mask, &bad);
    near(s.rel_mse + s.log_rmse + s.tone_rmse + fabs(s.bias), 0, 0);
    near(s.ssim, 1, 1e-12);
    assert_true(bad.nan == 0 && bad.inf == 0 && bad.negative == 0);
}

static void bad_values_are_counted_and_poison_nothing(void **state)
{
    pair *p = *state;
    metrics_bad bad = { 0, 0, 0 };
    p->m.planes[0][3] = p->m.planes[1][3] = NAN;
    p->m.planes[1][4] = INFINITY;
    p->m.planes[2][5] = -INFINITY;
    p->m.planes[0][6] = -1;
    metrics_count_bad(&p->m, p->mask, &bad);
    assert_int_equal(bad.nan, 1);
    assert_int_equal(bad.inf, 2);
    assert_int_equal(bad.negative, 2);
    metrics_summary s = compare(p);
    assert_true(isfinite(s.rel_mse) && isfinite(s.ssim) && isfinite(s.log_rmse) && isfinite(s.tone_rmse) && isfinite(s.bias));
    /* NaN twice, Inf, Inf as 0, and -1: each channel error 4/4.01 but the last, 9/4.01 */
    near(s.rel_mse, (4 * 4 + 9) / 4.01 / 3 / PIXELS, 1e-9);
}

static void structure_decides_similarity(void **state)
{
    pair *p = *state;
    for (int i = 0; i < PIXELS; i++)
        for (int k = 0; k < 3; k++) {
            bool stripe = i / 4 % 2;
            p->m.planes[k][i] = stripe ? 3 : 1;
            p->reference.planes[k][i] = stripe ? 1 : 3;
        }
    assert_true(compare(p).ssim < 0);
    for (int k = 0; k < 3; k++)
        memcpy(p->m.planes[k], p->reference.planes[k], PIXELS * sizeof(float));
    near(compare(p).ssim, 1, 1e-12);
}

static double tone(float x)
{
    return pow(x / (1 + x), 1 / 2.2);
}

/* The sum over windows taken straight from the definition, with tone-mapped values of 0 outside the mask. */
static double similarity_by_definition(const pair *p, int cx, int cy)
{
    double weights = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (int dy = -5; dy <= 5; dy++)
        for (int dx = -5; dx <= 5; dx++) {
            int x = cx + dx < 0 ? 0 : cx + dx >= WIDTH ? WIDTH - 1 : cx + dx;
            int y = cy + dy < 0 ? 0 : cy + dy >= HEIGHT ? HEIGHT - 1 : cy + dy, i = y * WIDTH + x;
            double w = exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
            double s = p->mask[i] ? tone(p->m.planes[0][i]) : 0, t = p->mask[i] ? tone(p->reference.planes[0][i]) : 0;
            weights += w, a += w * s, b += w * t, aa += w * s * s, bb += w * t * t, ab += w * s * t;
        }
    a /= weights, b /= weights, aa /= weights, bb /= weights, ab /= weights;
    return (2 * a * b + 1e-4) * (2 * (ab - a * b) + 9e-4) / ((a * a + b * b + 1e-4) * (aa - a * a + bb - b * b + 9e-4));
}

static void similarity_agrees_with_its_definition(void **state)
{
    pair *p = *state;
    double sum = 0;
    long count = 0;
    for (int i = 0; i < PIXELS; i++) {
        p->mask[i] = i % 17 != 0;
        for (int k = 0; k < 3; k++) {
            p->m.planes[k][i] = (float)(i * 7919 % 101) / 50.0f;
            p->reference.planes[k][i] = p->m.planes[k][i] * 0.8f + (float)(i * 104729 % 97) / 400.0f;
        }
    }
    for (int i = 0; i < PIXELS; i++)
        if (p->mask[i]) {
            sum += similarity_by_definition(p, i % WIDTH, i / WIDTH);
            count++;
        }
    assert_true(sum / (double)count < 0.99 && sum / (double)count > 0.5);
    near(compare(p).ssim, sum / (double)count, 1e-7);
}

static void exposure_brings_the_geometric_mean_to_a_quarter(void **state)
{
    pair *p = *state;
    fill(&p->reference, 8, 8, 8);
    for (int i = 0; i < PIXELS; i += 2)
        for (int k = 0; k < 3; k++)
            p->reference.planes[k][i] = 2;
    metrics_scale s = metrics_scale_of(&p->reference, p->mask, false);
    near(s.exposure, 0.25 / 4, 1e-6);
    near(s.log_floor, 0.008, 1e-7);
    near(metrics_tone(4, &s), pow(0.2, 1 / 2.2), 1e-6);
    near(metrics_tone(NAN, &s) + metrics_tone(-3, &s) + metrics_tone(INFINITY, &s), 0, 0);
    s = metrics_scale_of(&p->reference, p->mask, true);
    near(metrics_tone(0.25, &s), 0.25, 0);
    near(metrics_tone(3, &s), 1, 0);
}

static void frames_weigh_the_same(void **state)
{
    metrics sum = { 0 }, a = { .rel_mse = 1, .tone_mse = 0.04, .ssim = 1, .mean = 2, .mean_reference = 1, .frames = 1 };
    metrics b = { .rel_mse = 3, .tone_mse = 0.02, .ssim = 0.5, .mean = 2, .mean_reference = 3, .frames = 1 };
    (void)state;
    near(metrics_summarise(&sum).psnr, 0, 0);
    metrics_add(&sum, &a);
    metrics_add(&sum, &b);
    metrics_summary s = metrics_summarise(&sum);
    near(s.rel_mse, 2, 0);
    near(s.tone_rmse, sqrt(0.03), 1e-12);
    near(s.ssim, 0.75, 0);
    near(s.bias, 0, 0);
}

static void the_noise_of_the_reference_is_its_standard_error(void **state)
{
    pair *p = *state;
    float error[PIXELS];
    metrics m;
    for (int i = 0; i < PIXELS; i++)
        error[i] = 0.1f;
    assert_true(metrics_reference_noise(&p->reference, error, p->mask, &m));
    near(m.rel_mse, 0.01 / 4.01, 1e-8);
    near(m.rel_mse_trimmed, 0.01 / 4.01, 1e-8);
}

/* ---- flicker ---- */

/* A wall in front of a camera: everything moves by (-3, 2) pixels from the frame before. */
static void make_frame(capture *c)
{
    assert_true(capture_create(c, WIDTH, HEIGHT));
    c->denoising_range = 100;
    float *z = capture_add_plane(c, "viewZ", CAPTURE_FLOAT), *nz = capture_add_plane(c, "normal.Z", CAPTURE_FLOAT);
    float *mx = capture_add_plane(c, "motion.X", CAPTURE_FLOAT), *my = capture_add_plane(c, "motion.Y", CAPTURE_FLOAT);
    capture_add_plane(c, "normal.X", CAPTURE_FLOAT);
    capture_add_plane(c, "normal.Y", CAPTURE_FLOAT);
    capture_add_plane(c, "motion.Z", CAPTURE_FLOAT);
    capture_add_plane(c, "materialID", CAPTURE_HALF);
    for (int i = 0; i < PIXELS; i++) {
        z[i] = 5;
        nz[i] = 1;
        mx[i] = -3.0f / WIDTH;
        my[i] = 2.0f / HEIGHT;
    }
}

static metrics_flicker flicker_of(const pair *p, const capture *then, const capture *now)
{
    metrics_flicker f = { 0, 0 };
    assert_true(metrics_add_flicker(then, &p->reference, now, &p->m, p->mask, &plain, &f));
    return f;
}

static void a_moving_pattern_does_not_flicker(void **state)
{
    pair *p = *state;
    capture then, now;
    make_frame(&then);
    make_frame(&now);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            for (int k = 0; k < 3; k++) {
                p->reference.planes[k][y * WIDTH + x] = 1 + (float)((x * 7 + y * 13) % 11);
                p->m.planes[k][y * WIDTH + x] = 1 + (float)(((x - 3) * 7 + (y + 2) * 13 + 11 * 50) % 11);
            }
    metrics_flicker f = flicker_of(p, &then, &now);
    assert_int_equal(f.pixels, (WIDTH - 3) * (HEIGHT - 2)); /* the others were not in the picture */
    near(f.sum / (double)f.pixels, 0, 1e-6);
    capture_destroy(&then);
    capture_destroy(&now);
}

static void a_change_of_brightness_flickers_where_the_surface_was_visible(void **state)
{
    pair *p = *state;
    capture then, now;
    make_frame(&then);
    make_frame(&now);
    fill(&p->reference, 1, 1, 1);
    fill(&p->m, 3, 3, 3);
    metrics_flicker f = flicker_of(p, &then, &now);
    near(f.sum / (double)f.pixels, pow(0.75, 1 / 2.2) - pow(0.5, 1 / 2.2), 1e-6);

    static const char *const broken[] = { "viewZ", "normal.Z", "materialID" };
    for (int k = 0; k < 3; k++) { /* the upper half was another surface */
        float *plane = capture_find_plane(&then, broken[k]), whole = plane[0];
        for (int i = 0; i < PIXELS / 2; i++)
            plane[i] = 0.5f;
        assert_int_equal(flicker_of(p, &then, &now).pixels, (WIDTH - 3) * (HEIGHT / 2));
        for (int i = 0; i < PIXELS / 2; i++)
            plane[i] = whole;
    }
    now.cut = 1;
    assert_int_equal(flicker_of(p, &then, &now).pixels, 0);
    capture_destroy(&then);
    capture_destroy(&now);
}

/* ---- signals ---- */

static void add_colour(capture *c, const char *prefix, float value)
{
    for (int k = 0; k < 3; k++) {
        char name[CAPTURE_NAME_SIZE];
        strcpy(name, prefix);
        strcat(name, (const char *[]){ ".R", ".G", ".B" }[k]);
        *capture_add_plane(c, name, CAPTURE_HALF) = value;
    }
}

/* A pixel: diffuse 2 x 0.5, specular 3 x 0.1, sun 7 in the light, emission 0.25; its diffuse ray hits after 1.5 m. */
static void make_pixel(capture *c)
{
    assert_true(capture_create(c, 1, 1));
    add_colour(c, "diffuse", 2);
    add_colour(c, "diffuseFactor", 0.5f);
    add_colour(c, "specular", 3);
    add_colour(c, "specularFactor", 0.1f);
    add_colour(c, "sun", 7);
    add_colour(c, "emission", 0.25f);
    *capture_add_plane(c, "shadow.hitT", CAPTURE_HALF) = 65504;
    *capture_add_plane(c, "diffuse.hitT", CAPTURE_HALF) = 1.5f;
}

static float value_of(const capture *frame, const capture *denoised, signal_id signal, signal_source source)
{
    image m;
    float value = -1;
    if (signal_get(frame, denoised, signal, source, &m))
        value = m.planes[m.channels - 1][0];
    image_destroy(&m);
    return value;
}

static void final_is_composed_from_what_is_there(void **state)
{
    capture c, denoised;
    (void)state;
    make_pixel(&c);
    near(value_of(&c, NULL, SIGNAL_FINAL, SOURCE_NOISY), 1 + 0.3 + 7 + 0.25, 1e-6);
    near(value_of(&c, NULL, SIGNAL_FINAL, SOURCE_REFERENCE), -1, 0);
    assert_false(signal_has_reference(&c));
    add_colour(&c, "ref.diffuse", 4);
    add_colour(&c, "ref.specular", 5);
    near(value_of(&c, NULL, SIGNAL_FINAL, SOURCE_REFERENCE), -1, 0);
    *capture_add_plane(&c, "ref.shadow", CAPTURE_FLOAT) = 0.5f;
    near(value_of(&c, NULL, SIGNAL_FINAL, SOURCE_REFERENCE), 2 + 0.5 + 3.5 + 0.25, 1e-6);
    assert_true(signal_has_reference(&c));

    assert_true(capture_create(&denoised, 1, 1));
    add_colour(&denoised, "denoised.diffuse", 6);
    near(value_of(&c, &denoised, SIGNAL_DIFFUSE, SOURCE_DENOISED), 6, 0);
    near(value_of(&c, &denoised, SIGNAL_FINAL, SOURCE_DENOISED), -1, 0);
    add_colour(&denoised, "denoised.final", 9);
    near(value_of(&c, &denoised, SIGNAL_FINAL, SOURCE_DENOISED), 9, 0);
    near(value_of(&c, NULL, SIGNAL_FINAL, SOURCE_DENOISED), -1, 0);
    capture_destroy(&c);
    capture_destroy(&denoised);
}

static void distances_become_occlusion(void **state)
{
    capture c;
    (void)state;
    make_pixel(&c);
    near(value_of(&c, NULL, SIGNAL_AO, SOURCE_NOISY), 0.5, 0);
    c.metres_per_unit = 0.5f;
    near(value_of(&c, NULL, SIGNAL_AO, SOURCE_NOISY), 0.25, 0);
    *capture_find_plane(&c, "diffuse.hitT") = 65504;
    near(value_of(&c, NULL, SIGNAL_AO, SOURCE_NOISY), 1, 0);
    near(value_of(&c, NULL, SIGNAL_SHADOW, SOURCE_NOISY), 1, 0);
    *capture_find_plane(&c, "shadow.hitT") = 12;
    near(value_of(&c, NULL, SIGNAL_SHADOW, SOURCE_NOISY), 0, 0);
    capture_destroy(&c);
}

static void sky_black_surfaces_and_those_that_face_away_do_not_count(void **state)
{
    capture c;
    unsigned char mask;
    (void)state;
    make_pixel(&c);
    c.denoising_range = 50;
    float *z = capture_add_plane(&c, "viewZ", CAPTURE_FLOAT);
    *z = -49;
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        signal_mask(&c, (signal_id)k, &mask);
        assert_int_equal(mask, 1);
    }
    add_colour(&c, "diffuseFactor", 0);
    add_colour(&c, "sun", 1e-5f);
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        signal_mask(&c, (signal_id)k, &mask);
        assert_int_equal(mask, k != SIGNAL_DIFFUSE && k != SIGNAL_SHADOW && k != SIGNAL_TRANSLUCENCY);
    }
    *z = 50;
    signal_mask(&c, SIGNAL_FINAL, &mask);
    assert_int_equal(mask, 0);
    capture_destroy(&c);
}

#define WITH_PAIR(test) cmocka_unit_test_setup_teardown(test, make_pair, free_pair)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_PAIR(identical_images_have_no_error),
        WITH_PAIR(a_brighter_constant_has_the_error_of_its_formulas),
        WITH_PAIR(channels_are_averaged_and_luminance_is_weighted),
        WITH_PAIR(a_thousandth_of_fireflies_is_trimmed),
        WITH_PAIR(pixels_outside_the_mask_do_not_count),
        WITH_PAIR(bad_values_are_counted_and_poison_nothing),
        WITH_PAIR(structure_decides_similarity),
        WITH_PAIR(similarity_agrees_with_its_definition),
        WITH_PAIR(exposure_brings_the_geometric_mean_to_a_quarter),
        cmocka_unit_test(frames_weigh_the_same),
        WITH_PAIR(the_noise_of_the_reference_is_its_standard_error),
        WITH_PAIR(a_moving_pattern_does_not_flicker),
        WITH_PAIR(a_change_of_brightness_flickers_where_the_surface_was_visible),
        cmocka_unit_test(final_is_composed_from_what_is_there),
        cmocka_unit_test(distances_become_occlusion),
        cmocka_unit_test(sky_black_surfaces_and_those_that_face_away_do_not_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
