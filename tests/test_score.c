/* What a row of nrd-report says of pictures whose errors are known, in motion, at rest and after the light step. */
#define NRD_IMPLEMENTATION
#include "nrd.h"

#include "report/score.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Frames 2 and 3 of the four in motion have a reference; of the four at rest the last two count. */
enum { WIDTH = 64, HEIGHT = 32, PIXELS = WIDTH * HEIGHT, MOVING = 4, STILL = 4, STEPPED = 3, FRAMES = MOVING + STILL + STEPPED, EDGE_WIDTH = 9 };

static const report_options options = { .moving = MOVING, .still = STILL, .stepped = STEPPED, .pairs = 1 };

/* Luminance of the references, and of the pictures: in motion near edges, elsewhere in motion they are right; then everywhere. */
static const float truths[FRAMES] = { 0, 0, 1, 1.5f, 1.5f, 1.5f, 1.5f, 1.5f, 6, 6, 6 };
static const float pictures[FRAMES] = { 9, 9, 1.1f, 1.3f, 3, 3, 1.6f, 1.7f, 3.75f, 5.1f, 6 };

static void near(double value, double expected)
{
    if (!(fabs(value - expected) <= 2e-5 * fmax(fabs(expected), 0.01)))
        fail_msg("%.9g, expected %.9g", value, expected);
}

static bool is_near_edge(int x)
{
    return abs(x - (WIDTH / 2 - 1)) <= 4; /* materials differ between this pixel and the next */
}

/* A wall that does not move, of two materials. */
static void make_frame(capture *c, int frame)
{
    static const char *const flat[] = { "normal.X", "normal.Y", "motion.X", "motion.Y", "motion.Z" }, *const colour[] = { "ref.diffuse.R", "ref.diffuse.G", "ref.diffuse.B" };
    assert_true(capture_create(c, WIDTH, HEIGHT));
    c->denoising_range = 100;
    for (int k = 0; k < 5; k++)
        capture_add_plane(c, flat[k], CAPTURE_FLOAT);
    float *z = capture_add_plane(c, "viewZ", CAPTURE_FLOAT), *nz = capture_add_plane(c, "normal.Z", CAPTURE_FLOAT), *material = capture_add_plane(c, "materialID", CAPTURE_HALF);
    for (int i = 0; i < PIXELS; i++) {
        z[i] = 5;
        nz[i] = 1;
        material[i] = i % WIDTH < WIDTH / 2 ? 1 : 2;
    }
    for (int k = 0; k < 3 && sequence_has_reference(&options, frame); k++) {
        float *plane = capture_add_plane(c, colour[k], CAPTURE_FLOAT);
        for (int i = 0; i < PIXELS; i++)
            plane[i] = truths[frame];
    }
}

static void make_picture(image *m, int frame)
{
    assert_true(image_create(m, WIDTH, HEIGHT, 3));
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < PIXELS; i++)
            m->planes[k][i] = frame >= MOVING || is_near_edge(i % WIDTH) ? pictures[frame] : truths[frame];
}

static double tone(double linear)
{
    double y = 0.25 * linear; /* the first reference is 1 everywhere */
    return pow(y / (1 + y), 1 / 2.2);
}

static double relative(int frame)
{
    double d = pictures[frame], r = truths[frame];
    return (d - r) * (d - r) / (r * r + 0.01);
}

static void score_all(report_row *row)
{
    capture then, now;
    truth t = { .signal = SIGNAL_DIFFUSE };
    score s;
    memset(&then, 0, sizeof then);
    score_start(&s);
    for (int i = 0; i < REPORT_COLUMN_COUNT; i++)
        row->values[i] = NAN;
    for (int frame = 0; frame < FRAMES; frame++) {
        image picture;
        make_frame(&now, frame);
        make_picture(&picture, frame);
        assert_true(truth_advance(&t, &options, frame, frame ? &then : NULL, &now));
        assert_true(score_add(&s, &t, &options, frame, frame ? &then : NULL, &now, &picture));
        capture_destroy(&then);
        then = now;
    }
    score_fill(&s, &t, &options, row);
    capture_destroy(&then);
    truth_free(&t);
    score_free(&s);
}

static void a_row_says_what_was_put_into_the_pictures(void **state)
{
    static report_row row;
    const double *v = row.values, share = EDGE_WIDTH / (double)WIDTH;
    const double tone_2 = tone(1.1) - tone(1), tone_3 = tone(1.3) - tone(1.5), tone_6 = tone(1.6) - tone(1.5), tone_7 = tone(1.7) - tone(1.5);
    (void)state;
    score_all(&row);
    near(v[REPORT_motion_relmse], share * (relative(2) + relative(3)) / 2);
    near(v[REPORT_edge_trimmed], (relative(2) + relative(3)) / 2);
    near(v[REPORT_motion_psnr], -10 * log10(share * (tone_2 * tone_2 + tone_3 * tone_3) / 2));
    near(v[REPORT_motion_bias], share * (1.1 + 1.3 - 2.5) / 2.5);
    near(v[REPORT_motion_flicker], share * ((tone(1.3) - tone(1.1)) - (tone(1.5) - tone(1))));
    near(v[REPORT_worst_tile], sqrt(5 / 32.0) * fabs(tone_3));
    near(v[REPORT_fireflies], 0);
    assert_true(isnan(v[REPORT_ghost])); /* nothing has come into view */
    near(v[REPORT_rest_relmse], (relative(6) + relative(7)) / 2);
    near(v[REPORT_rest_trimmed], v[REPORT_rest_relmse]);
    near(v[REPORT_rest_psnr], -10 * log10((tone_6 * tone_6 + tone_7 * tone_7) / 2));
    near(v[REPORT_rest_bias], 0.1);
    near(v[REPORT_rest_flicker], tone(1.7) - tone(1.6));
    near(v[REPORT_lag], 1.5); /* half of the way, 80 %, all of it */
    assert_true(v[REPORT_rest_flip] > 0 && v[REPORT_motion_flip] > 0 && v[REPORT_motion_ssim] < 1);
    assert_int_equal(row.curve_count, FRAMES);
    for (int frame = 0; frame < FRAMES; frame++)
        if (frame < 2)
            assert_true(isnan(row.curve[frame]));
        else if (frame >= MOVING)
            near(row.curve[frame], relative(frame));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_row_says_what_was_put_into_the_pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
