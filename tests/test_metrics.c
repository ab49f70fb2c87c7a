/* Metrics: images whose scores are known, and the signals that captures hold. */
#include "common/metrics.h"
#include "common/metrics_faults.h"
#include "common/metrics_flip.h"
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

/* ---- FLIP ---- */

static double flip(const pair *p, const metrics_scale *scale)
{
    double value;
    assert_true(metrics_flip(&p->m, &p->reference, p->mask, scale, &value));
    return value;
}

static void equal_pictures_have_no_flip(void **state)
{
    pair *p = *state;
    for (int i = 0; i < PIXELS; i++)
        p->m.planes[i % 3][i] = p->reference.planes[i % 3][i] = (float)(i * 7919 % 101) / 50.0f;
    near(flip(p, &plain), 0, 1e-12);
}

/* Flat grey pictures have neither features nor chroma: all that is left is the difference of L*. */
static void flat_pictures_differ_by_their_lightness(void **state)
{
    pair *p = *state;
    const metrics_scale unit = { 1, 1e-3, true };
    /* L*a*b* of the sRGB primaries green and blue as colour books give them, chroma times 0.01 L* */
    double chroma = hypot(0.8774 * -86.18 - 0.3230 * 79.19, 0.8774 * 83.18 - 0.3230 * -107.86);
    double largest = pow(87.74 - 32.30 + chroma, 0.7), knee = 0.4 * largest;
    fill(&p->m, 1, 1, 1);
    fill(&p->reference, 0, 0, 0);
    near(flip(p, &unit), 0.95 + 0.05 * (pow(100, 0.7) - knee) / (largest - knee), 1e-4);
    fill(&p->reference, 0.9f, 0.9f, 0.9f);
    double lightness = 116 * cbrt(pow(0.9, 2.2)) - 16;
    near(flip(p, &unit), pow(100 - lightness, 0.7) * 0.95 / knee, 1e-4);
}

/* The weight of a kernel at (dx, dy) px; channel 0 and 1: one Gaussian, 2: two; 3: derivative across, 4: second one. */
static double kernel_by_definition(int kernel, int dx, int dy)
{
    double d2 = (dx * dx + dy * dy) / (67.0 * 67.0), pi2 = 3.14159265358979 * 3.14159265358979, s = 0.5 * 0.082 * 67;
    double g = exp(-(dx * dx + dy * dy) / (2 * s * s));
    if (kernel == 0) return exp(-pi2 * d2 / 0.0047);
    if (kernel == 1) return exp(-pi2 * d2 / 0.0053);
    if (kernel == 2) return 34.1 * sqrt(1 / 0.04) * exp(-pi2 * d2 / 0.04) + 13.5 * sqrt(1 / 0.025) * exp(-pi2 * d2 / 0.025);
    return kernel == 3 ? -dx * g : (dx * dx / (s * s) - 1) * g;
}

/* Response of a picture that is 1 in one pixel and 0 elsewhere, at (dx, dy) from that pixel: the kernel, normalised. */
static double impulse_response(int kernel, int radius, int dx, int dy, bool transposed)
{
    double positive = 0, negative = 0;
    for (int y = -radius; y <= radius; y++)
        for (int x = -radius; x <= radius; x++) {
            double w = kernel_by_definition(kernel, x, y);
            positive += fmax(w, 0);
            negative -= fmin(w, 0);
        }
    double w = transposed ? kernel_by_definition(kernel, -dy, -dx) : kernel_by_definition(kernel, -dx, -dy);
    return w / (w < 0 ? negative : positive);
}

/* One grey pixel in the dark: filtered grey, no chroma, and the features of an impulse. */
static void a_single_pixel_has_the_flip_of_its_definition(void **state)
{
    pair *p = *state;
    const metrics_scale unit = { 1, 1e-3, true };
    const float grey = 0.7f;
    double linear = pow(grey, 2.2), sum = 0;
    double chroma = hypot(0.8774 * -86.18 - 0.3230 * 79.19, 0.8774 * 83.18 - 0.3230 * -107.86);
    double knee = 0.4 * pow(87.74 - 32.30 + chroma, 0.7);
    fill(&p->m, 0, 0, 0);
    fill(&p->reference, 0, 0, 0);
    for (int k = 0; k < 3; k++)
        p->m.planes[k][25 * WIDTH + 30] = grey;
    for (int dy = -10; dy <= 10; dy++)
        for (int dx = -10; dx <= 10; dx++) {
            bool inside = abs(dx) <= 9 && abs(dy) <= 9;
            double y = linear * impulse_response(0, 10, dx, dy, false);
            double lightness = y > 216.0 / 24389 ? 116 * cbrt(y) - 16 : y * 24389.0 / 27;
            double edge = 0, point = 0;
            if (inside) {
                edge = linear * hypot(impulse_response(3, 9, dx, dy, false), impulse_response(3, 9, dx, dy, true));
                point = linear * hypot(impulse_response(4, 9, dx, dy, false), impulse_response(4, 9, dx, dy, true));
            }
            sum += pow(pow(lightness, 0.7) * 0.95 / knee, 1 - sqrt(fmax(edge, point) / sqrt(2)));
        }
    near(flip(p, &unit), sum / PIXELS, 2e-5);
}

/* ---- faults ---- */

static void only_pixels_brighter_than_all_near_are_fireflies(void **state)
{
    pair *p = *state;
    p->reference.planes[0][20 * WIDTH + 20] = p->reference.planes[1][20 * WIDTH + 20] = p->reference.planes[2][20 * WIDTH + 20] = 50;
    assert_int_equal(metrics_count_fireflies(&p->m, &p->reference, p->mask, &plain), 0);
    for (int k = 0; k < 3; k++) {
        p->m.planes[k][20 * WIDTH + 22] = 100; /* beside something bright */
        p->m.planes[k][20 * WIDTH + 23] = 100; /* 3 px from it: too far to excuse it */
        p->m.planes[k][0] = 6.04f;             /* below 3 x 2 + 0.05 */
        p->m.planes[k][9] = 6.06f;             /* above */
        p->m.planes[k][99] = 100;              /* does not count */
    }
    p->mask[99] = 0;
    assert_int_equal(metrics_count_fireflies(&p->m, &p->reference, p->mask, &plain), 2);
}

static int kept_in_row(const unsigned char *mask, int y)
{
    int count = 0;
    for (int x = 0; x < WIDTH; x++)
        count += mask[y * WIDTH + x];
    return count;
}

static void edges_are_where_the_guides_change(void **state)
{
    static const struct { const char *plane; float left, right; } broken[] = { { "normal.Z", 1, -1 }, { "materialID", 0, 1 }, { "viewZ", 5, 4 } };
    pair *p = *state;
    capture c;
    make_frame(&c);
    assert_true(metrics_keep_edges(&c, 4, p->mask));
    assert_int_equal(kept_in_row(p->mask, 10), 0);
    for (int k = 0; k < 3; k++) {
        float *plane = capture_find_plane(&c, broken[k].plane);
        memset(p->mask, 1, sizeof p->mask);
        p->mask[10 * WIDTH + 30] = 0;
        for (int i = 0; i < PIXELS; i++)
            plane[i] = i % WIDTH < 30 ? broken[k].left : broken[k].right;
        assert_true(metrics_keep_edges(&c, 4, p->mask));
        /* 25 .. 33 around pixel 29; a bent depth is seen from both of its sides */
        assert_int_equal(kept_in_row(p->mask, 11), k == 2 ? 10 : 9);
        assert_int_equal(kept_in_row(p->mask, 10), k == 2 ? 9 : 8);
        assert_int_equal(p->mask[11 * WIDTH + 24], 0);
        assert_int_equal(p->mask[11 * WIDTH + 25], 1);
        for (int i = 0; i < PIXELS; i++)
            plane[i] = broken[k].left;
    }
    capture_destroy(&c);
}

static void a_slope_is_no_edge(void **state)
{
    pair *p = *state;
    capture c;
    make_frame(&c);
    float *z = capture_find_plane(&c, "viewZ");
    for (int i = 0; i < PIXELS; i++)
        z[i] = 5 + 0.5f * (float)(i % WIDTH);
    assert_true(metrics_keep_edges(&c, 4, p->mask));
    assert_int_equal(kept_in_row(p->mask, 10), 0);
    capture_destroy(&c);
}

static void the_worst_tile_is_found_alone(void **state)
{
    pair *p = *state;
    near(metrics_worst_tile(&p->m, &p->reference, p->mask, &plain), 0, 0);
    for (int y = 0; y < 32; y++)
        for (int x = 32; x < WIDTH; x++)
            for (int k = 0; k < 3; k++)
                p->m.planes[k][y * WIDTH + x] = y < 16 ? 3 : 2;
    double wrong = pow(0.75, 1 / 2.2) - pow(2.0 / 3, 1 / 2.2);
    near(metrics_worst_tile(&p->m, &p->reference, p->mask, &plain), wrong / sqrt(2), 1e-7);
    for (int y = 0; y < 32; y++)
        for (int x = 32; x < WIDTH; x++)
            p->mask[y * WIDTH + x] = x < 36; /* too little of the tile */
    near(metrics_worst_tile(&p->m, &p->reference, p->mask, &plain), 0, 0);
}

static void lag_is_the_way_to_nine_tenths(void **state)
{
    const double at_once[] = { 0.95, 1 }, slow[] = { 0.5, 0.7, 0.8, 1.0 }, never[] = { 0.1, 0.2, 0.3 };
    (void)state;
    near(metrics_lag(at_once, 2), 0, 0);
    near(metrics_lag(slow, 4), 2.5, 1e-12);
    near(metrics_lag(never, 3), 3, 0);
}

/* The upper half was another surface, on which a brighter light shone. */
static void a_ghost_is_the_share_of_what_was_there_before(void **state)
{
    pair *p = *state;
    image before;
    capture then, now;
    make_frame(&then);
    make_frame(&now);
    assert_true(image_create(&before, WIDTH, HEIGHT, 3));
    fill(&before, 7, 7, 7);
    fill(&p->reference, 1, 1, 1);
    float *material = capture_find_plane(&then, "materialID");
    for (int i = 0; i < PIXELS / 2; i++)
        material[i] = 2;
    fill(&p->m, 1 + 0.3f * 6, 1 + 0.3f * 6, 1 + 0.3f * 6);
    metrics_ghost ghost = { 0, 0, 0 };
    metrics_add_ghost(&then, &before, &now, &p->m, &p->reference, p->mask, &ghost);
    assert_int_equal(ghost.pixels, (WIDTH - 3) * (HEIGHT / 2 - 2));
    near(ghost.along / ghost.square, 0.3, 1e-5);
    now.cut = 1;
    metrics_add_ghost(&then, &before, &now, &p->m, &p->reference, p->mask, &ghost);
    assert_int_equal(ghost.pixels, (WIDTH - 3) * (HEIGHT / 2 - 2));
    image_destroy(&before);
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
        WITH_PAIR(equal_pictures_have_no_flip),
        WITH_PAIR(flat_pictures_differ_by_their_lightness),
        WITH_PAIR(a_single_pixel_has_the_flip_of_its_definition),
        WITH_PAIR(only_pixels_brighter_than_all_near_are_fireflies),
        WITH_PAIR(edges_are_where_the_guides_change),
        WITH_PAIR(a_slope_is_no_edge),
        WITH_PAIR(the_worst_tile_is_found_alone),
        WITH_PAIR(a_ghost_is_the_share_of_what_was_there_before),
        cmocka_unit_test(lag_is_the_way_to_nine_tenths),
        cmocka_unit_test(final_is_composed_from_what_is_there),
        cmocka_unit_test(distances_become_occlusion),
        cmocka_unit_test(sky_black_surfaces_and_those_that_face_away_do_not_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
