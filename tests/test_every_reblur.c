/* What every REBLUR denoiser promises about its place: a restart is a new instance, a rectangle an instance of its size; rectangles that
   change keep history, and the split screen shows the input and touches nothing else. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "every_reblur.h"

/* ---------------------------------------------------------------------------------------------------------------------------
   Scene and signals  >>scene */
/* A floor under a wall, and a strip of sky. */
static hit room(const pose *p, double u, double v, uint32_t frame)
{
    static const double points[2][3] = { { 0, -1, 0 }, { 0, 0, 6 } }, normals[2][3] = { { 0, 1, 0 }, { 0, 0, -1 } };
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 9 };
    (void)frame;
    for (uint32_t i = 0; i < 2 && v > 0.2; i++) {
        double depth;
        if (!rig_ray_plane(p, u, v, points[i], normals[i], &depth) || depth >= h.depth) continue;
        h.depth = depth;
        h.region = i;
        memcpy(h.normal, normals[i], sizeof h.normal);
    }
    return h;
}

/* The same all over, so that rectangles of every size show the same truth. */
static double truth(void) { return 0.6; }
static path noise(const bench *b, uint32_t x, uint32_t y) { return (path){ random_at(x, y, b->r.index) < 0.5 ? 0.2 : 1, 0.5 }; }

/* What no sane renderer gives. */
static path rubbish(const bench *b, uint32_t x, uint32_t y)
{
    static const double values[] = { 65504, -65504, INFINITY, NAN, 6e-8, 3e4 };
    uint32_t which = (uint32_t)(6 * random_at(x, y, 9000 + b->r.index));
    return (path){ values[which], values[(which + 3) % 6] };
}

static void assert_below(double value, double limit, const bench *b, const char *what)
{
    if (!(value <= limit)) fail_msg("%s: %s is %g, allowed is %g", bench_name(b), what, value, limit);
}

static bool is_sky(const bench *b, uint32_t x, uint32_t y) { return bench_hit(b, x, y)->depth >= RIG_RANGE; }

/* Largest relative difference of any channel of any output, over the rectangle; a NaN differs by infinity. */
static double largest_difference(const bench *a, const bench *b)
{
    double largest = 0;
    for (int i = 0; i < BENCH_LANES; i++)
        for (uint32_t y = 0; y < a->r.rect_height && bench_has(a, bench_lanes[i].out); y++)
            for (uint32_t x = 0; x < a->r.rect_width; x++)
                for (uint32_t k = 0; k < 4; k++) {
                    double left = bench_channel(a, bench_lanes[i].out, x, y, k), right = bench_channel(b, bench_lanes[i].out, x, y, k);
                    double difference = fabs(left - right) / fmax(fabs(right), 0.1);
                    largest = fmax(largest, isfinite(difference) ? difference : INFINITY);
                }
    return largest;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Restart  >>restart */
/* Nothing of the frames before is left, whatever they held; so there is nothing to be cleared. */
static void a_restart_is_a_new_instance_to_the_bit(void **state)
{
    static bench used, fresh;
    nrd_denoiser denoiser = *(const nrd_denoiser *)*state;
    bench_open(&used, denoiser, BENCH_WIDTH, BENCH_HEIGHT, room, rubbish, NRD_FEATURE_ALL);
    bench_open(&fresh, denoiser, BENCH_WIDTH, BENCH_HEIGHT, room, noise, NRD_FEATURE_ALL);
    bench_set(&used, "diffuse_prepass_blur_radius", 20);
    used.r.roughness = fresh.r.roughness = 0.3f;
    for (uint32_t frame = 0; frame < 5; frame++) {
        used.r.camera.yaw = 0.2 * frame;
        bench_step(&used);
    }
    bench_restart(&used, 77);
    bench_restart(&fresh, 77);
    fresh.r.frame.restart = 0;
    nrd_settings_defaults(denoiser, &used.settings);
    used.signal = noise;
    for (uint32_t frame = 0; frame < 4; frame++) {
        used.r.camera.position[0] = fresh.r.camera.position[0] = 0.05 * frame;
        bench_step(&used);
        bench_step(&fresh);
        for (int i = 0; i < BENCH_LANES; i++)
            for (uint32_t p = 0; p < BENCH_PIXELS; p++)
                if (!is_sky(&used, p % BENCH_WIDTH, p / BENCH_WIDTH) && memcmp(used.out[bench_lanes[i].out][p], fresh.out[bench_lanes[i].out][p], 8))
                    fail_msg("%s: frame %u after a restart, pixel %u %u of %s differs from a new instance's", bench_name(&used), frame, p % BENCH_WIDTH,
                             p / BENCH_WIDTH, nrd_resource_name(bench_lanes[i].out));
    }
    bench_close(&used);
    bench_close(&fresh);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Rectangles  >>rectangles */
/* The blur's reach is scaled with the rectangle, so the small instance is told half of it. */
static void assert_rectangle(bench *small, bench *large, uint32_t origin_x, uint32_t origin_y, double pan, double tolerance)
{
    bench_restart(small, 0);
    bench_restart(large, 0);
    large->r.origin_x = origin_x;
    large->r.origin_y = origin_y;
    for (uint32_t frame = 0; frame < 4; frame++) {
        small->r.camera.position[0] = large->r.camera.position[0] = pan * frame;
        bench_step(small);
        bench_step(large);
        assert_below(largest_difference(small, large), tolerance, large, "difference to the small instance");
    }
}

static void a_rectangle_gives_what_an_instance_of_its_size_gives(void **state)
{
    static bench small, large;
    nrd_denoiser denoiser = *(const nrd_denoiser *)*state;
    bench_open(&small, denoiser, BENCH_WIDTH / 2, BENCH_HEIGHT / 2, room, noise, 0);
    bench_open(&large, denoiser, BENCH_WIDTH, BENCH_HEIGHT, room, noise, 0);
    bench_set(&large, "max_blur_radius", 16);
    bench_set(&small, "max_blur_radius", 8);
    small.r.roughness = large.r.roughness = 0.3f;
    large.r.rect_width = BENCH_WIDTH / 2;
    large.r.rect_height = BENCH_HEIGHT / 2;
    assert_rectangle(&small, &large, 0, 0, 0, 0);
    assert_rectangle(&small, &large, 17, 9, 0, 0);
    assert_rectangle(&small, &large, 17, 9, 0.1, 2e-3);
    bench_close(&small);
    bench_close(&large);
}

typedef struct quality { double error, length; } quality; /* root mean square, mean history length in frames */

static quality quality_of(const bench *b, bool lengths)
{
    double error = 0, length = 0;
    uint32_t count = 0;
    for (int i = 0; i < BENCH_VALUE_LANES; i++)
        for (uint32_t y = 2; y + 2 < b->r.rect_height && bench_has(b, bench_lanes[i].out); y++)
            for (uint32_t x = 2; x + 2 < b->r.rect_width; x++) {
                if (is_sky(b, x, y)) continue;
                double e = bench_value(b, &bench_lanes[i], x, y) - truth();
                if (lengths) length += bench_length(b, &bench_lanes[i], x, y);
                else error += e * e;
                count++;
            }
    return (quality){ sqrt(error / count), length / count };
}

/* The rectangle shrinks and grows in every frame, under a camera that moves. */
static quality quality_after(bench *b, bool changing, bool lengths)
{
    static const uint32_t widths[] = { 48, 42, 36, 45, 39, 48, 33, 48 };
    bench_set(b, "return_history_length_instead_of_occlusion", lengths);
    bench_restart(b, 0);
    for (uint32_t frame = 0; frame < 12; frame++) {
        b->r.rect_width = changing ? widths[frame % 8] : BENCH_WIDTH;
        b->r.rect_height = b->r.rect_width * BENCH_HEIGHT / BENCH_WIDTH;
        b->r.camera.position[0] = 0.02 * frame;
        bench_step(b);
    }
    return quality_of(b, lengths);
}

static quality quality_at_restart(bench *b)
{
    bench_set(b, "return_history_length_instead_of_occlusion", 0);
    bench_restart(b, 11);
    bench_step(b);
    return quality_of(b, false);
}

static void history_survives_rectangles_that_change(void **state)
{
    static bench b;
    bench_open(&b, *(const nrd_denoiser *)*state, BENCH_WIDTH, BENCH_HEIGHT, room, noise, 0);
    double plain = quality_after(&b, false, true).length, changing = quality_after(&b, true, true).length;
    double plain_error = quality_after(&b, false, false).error, error = quality_after(&b, true, false).error, restarted = quality_at_restart(&b).error;
    print_message("%s: history of %.1f frames where the rectangle stays, %.1f where it changes; error %.4f, %.4f, of a restart %.4f\n", bench_name(&b), plain, changing,
                  plain_error, error, restarted);
    assert_true(changing > 0.8 * plain);
    assert_below(error, fmin(1.2 * plain_error, 0.5 * restarted), &b, "error where the rectangle changes");
    bench_close(&b);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Split screen  >>split */
static void step_split(bench *b, float split, uint32_t frames)
{
    bench_restart(b, 0);
    b->r.frame.split_screen = split;
    for (uint32_t frame = 0; frame < frames; frame++) {
        b->r.camera.position[0] = 0.03 * frame;
        bench_step(b);
    }
}

/* The noisy input, as it was uploaded. */
static void assert_input(const bench *b, const bench_lane *lane, uint32_t x, uint32_t y)
{
    float texel[4];
    uint16_t expected[4];
    uint32_t channels = gpu_format_size(b->r.images[lane->out].format) / 2;
    bench earlier = { .r = { .index = b->r.index - 1 }, .signal = b->signal };
    bench_texel(&earlier, lane, x, y, texel);
    half_from_floats(expected, texel, 4);
    if (memcmp(expected, b->out[lane->out][y * b->r.width + x], 2 * channels))
        fail_msg("%s: pixel %u %u of %s is not the input", bench_name(b), x, y, nrd_resource_name(lane->out));
}

static void the_split_shows_the_input_and_leaves_the_rest_alone(void **state)
{
    static bench whole, split;
    nrd_denoiser denoiser = *(const nrd_denoiser *)*state;
    bench_open(&whole, denoiser, BENCH_WIDTH, BENCH_HEIGHT, room, noise, NRD_FEATURE_SPLIT_SCREEN);
    bench_open(&split, denoiser, BENCH_WIDTH, BENCH_HEIGHT, room, noise, NRD_FEATURE_SPLIT_SCREEN);
    step_split(&whole, 0, 4);
    step_split(&split, 0.5f, 4);
    for (int i = 0; i < BENCH_LANES; i++)
        for (uint32_t p = 0; p < BENCH_PIXELS && bench_has(&split, bench_lanes[i].out); p++) {
            uint32_t x = p % BENCH_WIDTH, y = p / BENCH_WIDTH;
            if (is_sky(&split, x, y)) continue;
            if (x < BENCH_WIDTH / 2) assert_input(&split, &bench_lanes[i], x, y);
            else assert_memory_equal(split.out[bench_lanes[i].out][p], whole.out[bench_lanes[i].out][p], 8);
        }
    step_split(&split, 1, 2);
    for (int i = 0; i < BENCH_LANES; i++)
        for (uint32_t p = 0; p < BENCH_PIXELS && bench_has(&split, bench_lanes[i].out); p++)
            if (!is_sky(&split, p % BENCH_WIDTH, p / BENCH_WIDTH)) assert_input(&split, &bench_lanes[i], p % BENCH_WIDTH, p / BENCH_WIDTH);
    bench_close(&whole);
    bench_close(&split);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        EVERY_REBLUR(a_restart_is_a_new_instance_to_the_bit),
        EVERY_REBLUR(a_rectangle_gives_what_an_instance_of_its_size_gives),
        EVERY_REBLUR(history_survives_rectangles_that_change),
        EVERY_REBLUR(the_split_shows_the_input_and_leaves_the_rest_alone),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
