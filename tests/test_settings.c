/* What the settings of the REBLUR denoisers do, asked of all ten: each moves a measure of the picture in the direction that it is there for.
   A denoiser that has no such setting, or no signal that it is about, is not asked. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "every_reblur.h"

/* ---------------------------------------------------------------------------------------------------------------------------
   Scenes and signals  >>scenes */
enum { CHANGE = 8 };   /* frame from which on something is different */

static hit facing(const pose *p, double u, double v, double z, uint32_t region)
{
    const double point[3] = { 0, 0, z };
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, region };
    rig_ray_plane(p, u, v, point, h.normal, &h.depth);
    return h;
}

static hit wall(const pose *p, double u, double v, uint32_t frame)
{
    (void)frame;
    return facing(p, u, v, 5, u >= 0.5);
}

/* Region 1, the right half, is a little farther. */
static hit step(const pose *p, double u, double v, uint32_t frame)
{
    (void)frame;
    return facing(p, u, v, u < 0.5 ? 5 : 5.3, u >= 0.5);
}

/* Region 1, the right half, is of another material. */
static hit painted(const pose *p, double u, double v, uint32_t frame)
{
    hit h = wall(p, u, v, frame);
    h.material = h.region;
    return h;
}

/* Region 1, the right half, is shaded as if it leant back by 25 degrees. */
static hit leaning(const pose *p, double u, double v, uint32_t frame)
{
    hit h = wall(p, u, v, frame);
    if (h.region) h.normal[0] = -sin(0.436), h.normal[2] = -cos(0.436);
    return h;
}

/* Another place from CHANGE on, but not by much. */
static hit jump(const pose *p, double u, double v, uint32_t frame) { return facing(p, u, v, frame < CHANGE ? 5 : 5.15, 0); }

/* Material 1, whose depth jumps to and fro, as that of hair does. */
static hit restless(const pose *p, double u, double v, uint32_t frame)
{
    hit h = facing(p, u, v, frame & 1 ? 5.4 : 5, 0);
    h.material = 1;
    return h;
}

static path noise(const bench *b, uint32_t x, uint32_t y) { return (path){ random_at(x, y, b->r.index) < 0.5 ? 0.2 : 1, 0.5 }; }
static path by_region(const bench *b, uint32_t x, uint32_t y) { double v = bench_hit(b, x, y)->region ? 0.2 : 0.9; return (path){ v, 0.5 }; }

/* Of one region, but two lights that noise does not hide. */
static path edge_of_light(const bench *b, uint32_t x, uint32_t y)
{
    double light = bench_hit(b, x, y)->region ? 0.3 : 0.9;
    return (path){ light * (0.8 + 0.4 * random_at(x, y, b->r.index)), 0.5 };
}

static path light_goes_down(const bench *b, uint32_t x, uint32_t y)
{
    path p = noise(b, x, y);
    return (path){ b->r.index < CHANGE ? p.value : 0.3 * p.value, 0.5 };
}

/* One pixel far too bright. */
static path firefly(const bench *b, uint32_t x, uint32_t y)
{
    (void)b;
    return (path){ x == BENCH_WIDTH / 2 && y == BENCH_HEIGHT / 2 ? 90 : 0.5, 0.5 };
}

static path half_open(const bench *b, uint32_t x, uint32_t y) { (void)b; (void)x; (void)y; return (path){ 0.5, 0.5 }; }

/* One pixel of 5x5 is sampled. */
static path sparse(const bench *b, uint32_t x, uint32_t y)
{
    (void)b;
    bool sampled = x % 5 == 0 && y % 5 == 0;
    return (path){ sampled ? 0.9 : 1e-3, sampled ? 0.5 : 0 };
}

/* No distance that a reflection could be followed by. */
static path confusing(const bench *b, uint32_t x, uint32_t y)
{
    (void)b;
    return (path){ (x + y) % 2 ? 0.5 : 0.05, (x + y) % 2 ? 0.5 : 0.05 };
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Measures  >>measures */
/* Of one value lane over the rectangle, two pixels from its border on. */
typedef double measure(const bench *b, const bench_lane *lane);
#define EACH_INNER_PIXEL(b, x, y) (uint32_t y = 2; y + 2 < (b)->r.rect_height; y++) for (uint32_t x = 2; x + 2 < (b)->r.rect_width; x++)

static double mean_of(const bench *b, const bench_lane *lane)
{
    double sum = 0, count = 0;
    for EACH_INNER_PIXEL(b, x, y) sum += bench_value(b, lane, x, y), count++;
    return sum / count;
}

static double deviation(const bench *b, const bench_lane *lane)
{
    double mean = mean_of(b, lane), sum = 0, count = 0;
    for EACH_INNER_PIXEL(b, x, y) sum += pow(bench_value(b, lane, x, y) - mean, 2), count++;
    return sqrt(sum / count) / mean;
}

static double length(const bench *b, const bench_lane *lane) { return bench_length(b, lane, BENCH_WIDTH / 2, BENCH_HEIGHT / 2); }

/* Of the four columns on either side of the middle: how much of the difference between the halves has gone over. */
static double leak(const bench *b, const bench_lane *lane)
{
    double sides[4] = { 0, 0, 0, 0 };   /* left and right: far from the middle, near to it */
    for (uint32_t y = 2; y < BENCH_HEIGHT - 2; y++)
        for (uint32_t x = 0; x < 4; x++) {
            sides[0] += bench_value(b, lane, 2 + x, y), sides[1] += bench_value(b, lane, BENCH_WIDTH - 3 - x, y);
            sides[2] += bench_value(b, lane, BENCH_WIDTH / 2 - 1 - x, y), sides[3] += bench_value(b, lane, BENCH_WIDTH / 2 + x, y);
        }
    return 1 - (sides[2] - sides[3]) / (sides[0] - sides[1]);
}

/* Light beyond half_open's. */
static double excess(const bench *b, const bench_lane *lane) { return mean_of(b, lane) - 0.5; }

/* Share of the pixels whose hit distance is known. */
static double known(const bench *b, const bench_lane *lane)
{
    double sum = 0, count = 0;
    for EACH_INNER_PIXEL(b, x, y) sum += fabs(bench_channel(b, lane->out, x, y, 3) - 0.5) < 0.1, count++;
    return sum / count;
}

/* Change of the picture from the frame before the last. */
static uint16_t before[NRD_RESOURCE_COUNT][BENCH_PIXELS][4];
static double flicker(const bench *b, const bench_lane *lane)
{
    double sum = 0, count = 0;
    for EACH_INNER_PIXEL(b, x, y) sum += fabs(bench_value(b, lane, x, y) - half_to_float(before[lane->out][y * BENCH_WIDTH + x][lane->channel])), count++;
    return sum / count;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Rows  >>rows */
enum { ANY, DIFFUSE_ONLY, SPECULAR_ONLY };
typedef struct row {
    const char *setting;
    double more, less;          /* values with which the measure is larger, and smaller, .. */
    double factor;              /* .. by at least this */
    uint32_t frames;            /* whose last is measured */
    scene *where;
    bench_signal *signal;
    measure *of;
    int lobe;                   /* that it is about */
    struct { const char *setting; double value; } with[3]; /* in both runs */
    double roughness;           /* 0: 1 */
    double pan[3];              /* of the camera in a frame */
} row;

#define LENGTHS { "return_history_length_instead_of_occlusion", 1 }
#define NO_ANTILAG { "antilag_sensitivity", 0 }
#define NOTHING { NULL, 0 }
#define STILL OF_ROUGHNESS(0)
#define OF_ROUGHNESS(roughness) roughness, { 0, 0, 0 }
#define NO_BLUR { "max_blur_radius", 0 }
static const row rows[] = {
    { "max_accumulated_frames", 2, 32, 1.3, 12, wall, noise, deviation, ANY, { NO_ANTILAG, NO_BLUR, { "max_stabilized_frames", 0 } }, STILL },
    { "max_blur_radius", 0, 15, 1.5, 4, wall, noise, deviation, ANY, { NOTHING }, STILL },
    { "max_stabilized_frames", 0, 32, 1.5, 12, wall, noise, flicker, ANY, { NO_BLUR }, STILL },
    { "stabilization_sigma_scale", 0.1, 20, 1.3, 12, wall, noise, flicker, ANY, { NO_BLUR }, STILL },
    { "feedback_frames", 0, 64, 1.05, 12, wall, noise, deviation, ANY, { NO_ANTILAG }, STILL },
    { "history_fix_frames", 16, 0, 3, 1, step, by_region, leak, ANY, { { "luminance_sigma_scale", 100 } }, STILL },
    { "luminance_sigma_scale", 50, 0.5, 1.5, 12, wall, edge_of_light, leak, ANY, { { "feedback_frames", 0 } }, STILL },
    { "plane_distance_sensitivity", 1, 0.002, 3, 4, step, by_region, leak, ANY, { { "luminance_sigma_scale", 100 } }, STILL },
    { "normal_sensitivity", 0, 300, 3, 4, leaning, by_region, leak, ANY, { { "history_fix_frames", 0 }, { "luminance_sigma_scale", 100 } }, STILL },
    { "antilag_sigma_scale", 100, 1, 1.5, CHANGE + 3, wall, light_goes_down, mean_of, ANY, { NOTHING }, STILL },
    { "antilag_sensitivity", 0, 1, 1.5, CHANGE + 3, wall, light_goes_down, mean_of, ANY, { NOTHING }, STILL },
    { "min_material", 4, 0, 3, 4, painted, by_region, leak, ANY, { NOTHING }, STILL },
    { "min_material_for_diffuse", 4, 0, 3, 4, painted, by_region, leak, DIFFUSE_ONLY, { { "luminance_sigma_scale", 100 } }, STILL },
    { "min_material_for_specular", 4, 0, 3, 4, painted, by_region, leak, SPECULAR_ONLY, { { "luminance_sigma_scale", 100 } }, STILL },
    { "diffuse_prepass_blur_radius", 0, 20, 1.2, 1, wall, noise, deviation, DIFFUSE_ONLY, { NOTHING }, STILL },
    { "specular_prepass_blur_radius", 0, 20, 1.1, 1, wall, noise, deviation, SPECULAR_ONLY, { NOTHING }, STILL },
    { "hit_distance_a", 0.01, 3, 1.2, 4, wall, noise, deviation, SPECULAR_ONLY, { { "specular_prepass_blur_radius", 20 }, { "hit_distance_b", 0 } }, OF_ROUGHNESS(0.6) },
    { "hit_distance_b", 0, 1, 1.2, 4, wall, noise, deviation, SPECULAR_ONLY, { { "specular_prepass_blur_radius", 20 }, { "hit_distance_a", 0.01 } }, OF_ROUGHNESS(0.6) },
    { "hit_distance_c", 1, 100, 1.2, 4, wall, noise, deviation, SPECULAR_ONLY, { { "hit_distance_a", 0.02 }, { "hit_distance_b", 0 }, { "hit_distance_d", -1 } }, OF_ROUGHNESS(0.6) },
    { "hit_distance_d", -1000, -0.5, 1.2, 4, wall, noise, deviation, SPECULAR_ONLY, { { "hit_distance_a", 0.02 }, { "hit_distance_b", 0 }, { "hit_distance_c", 100 } }, OF_ROUGHNESS(0.6) },
    { "hit_distance_reconstruction", 2, 0, 2, 1, wall, sparse, known, ANY, { NOTHING }, STILL },
    { "hit_distance_reconstruction", 2, 1, 1.2, 1, wall, sparse, known, DIFFUSE_ONLY, { NOTHING }, STILL },
    { "responsive_roughness", 0, 0.9, 1.3, 12, wall, noise, length, SPECULAR_ONLY, { LENGTHS, NO_ANTILAG, { "max_accumulated_frames", 8 } }, OF_ROUGHNESS(0.2) },
    { "responsive_min_frames", 32, 0, 1.3, 12, wall, noise, length, SPECULAR_ONLY, { LENGTHS, NO_ANTILAG, { "responsive_roughness", 1 } }, OF_ROUGHNESS(0.05) },
    { "anti_firefly_scale", 0, 8, 3, 4, wall, firefly, excess, ANY, { NOTHING }, STILL },
    { "anti_firefly_scale", 8, 0.5, 2, 4, wall, firefly, excess, ANY, { NOTHING }, STILL },
    { "performance_mode", 1, 0, 1.02, 4, wall, noise, deviation, ANY, { NOTHING }, STILL },
    { "performance_mode", 2, 1, 1.1, 4, wall, noise, deviation, ANY, { NOTHING }, STILL },
    /* of the frame */
    { "disocclusion_threshold", 0.1, 0.01, 5, CHANGE + 1, jump, noise, length, ANY, { LENGTHS, NO_ANTILAG }, STILL },
    { "disocclusion_threshold_alternate", 0.1, 0.01, 5, CHANGE + 1, jump, noise, length, ANY, { LENGTHS, NO_ANTILAG, { "disocclusion_threshold_mix_available", 1 } }, STILL },
    { "disocclusion_threshold_mix_available", 1, 0, 5, CHANGE + 1, jump, noise, length, ANY, { LENGTHS, NO_ANTILAG, { "disocclusion_threshold_alternate", 0.1 } }, STILL },
    { "history_confidence_available", 0, 1, 5, 8, wall, noise, length, ANY, { LENGTHS, NO_ANTILAG }, STILL },
    { "strand_material_id", 1, 4, 5, 8, restless, noise, length, ANY, { LENGTHS, NO_ANTILAG }, STILL },
    { "strand_thickness", 1e-4, 1, 2, 8, restless, half_open, length, ANY, { LENGTHS, { "strand_material_id", 1 }, { "disocclusion_threshold_alternate", 0.2 } }, 0, { 0.5, 0, 0 } },
    { "camera_attached_reflection_material_id", 0, 4, 2, 8, wall, confusing, length, SPECULAR_ONLY, { LENGTHS, NO_ANTILAG }, 0.02, { 0.1, 0, 0 } },
    { "restart", 0, 1, 5, 8, wall, noise, length, ANY, { LENGTHS, NO_ANTILAG }, STILL },
    /* a wall that leaves the picture and one that comes nearer */
    { "motion_scale_x", 0, 1, 1.5, 8, wall, half_open, length, DIFFUSE_ONLY, { LENGTHS }, 0, { 1, 0, 0 } },
    { "motion_scale_y", 0, 1, 1.5, 8, wall, half_open, length, DIFFUSE_ONLY, { LENGTHS }, 0, { 0, 1, 0 } },
    { "view_z_scale", 1, 2, 3, 5, wall, half_open, length, ANY, { LENGTHS }, 0, { 0, 0, 0.3 } },
    { "motion_scale_z", 1, 0, 3, 5, wall, half_open, length, ANY, { LENGTHS }, 0, { 0, 0, 0.3 } },
};
enum { ROW_COUNT = sizeof rows / sizeof rows[0] };

static bool concerns(const bench *b, const row *r, const bench_lane *lane)
{
    return bench_has(b, lane->out) && (r->lobe == ANY || lane->specular == (r->lobe == SPECULAR_ONLY));
}

/* False: neither the denoiser nor the frame has it. */
static bool put(bench *b, const char *name, double value)
{
    return bench_set(b, name, value) || put_setting_by_name(NRD_DENOISER_COUNT, &b->r.frame, name, value);
}

/* Of every lane that the row is about. */
static void measure_row(bench *b, const row *r, double value, double measured[BENCH_VALUE_LANES])
{
    nrd_settings_defaults(b->denoiser, &b->settings);
    b->r.frame = nrd_frame_defaults();
    b->r.frame.denoising_range = RIG_RANGE;
    for (int k = 0; k < 3 && r->with[k].setting; k++) put(b, r->with[k].setting, r->with[k].value);
    b->r.scene = r->where;
    b->r.roughness = r->roughness > 0 ? (float)r->roughness : 1;
    b->signal = r->signal;
    bench_restart(b, 0);
    for (uint32_t frame = 0; frame < r->frames; frame++) {
        memcpy(before, b->out, sizeof before);
        for (int k = 0; k < 3; k++) b->r.camera.position[k] = r->pan[k] * frame;
        assert_true(put(b, r->setting, value));
        if (frame == 0) b->r.frame.restart = 1;
        bench_step(b);
    }
    for (int i = 0; i < BENCH_VALUE_LANES; i++) measured[i] = concerns(b, r, &bench_lanes[i]) ? r->of(b, &bench_lanes[i]) : 0;
}

static void fill_with_ones(bench *b, nrd_resource resource)
{
    static float ones[BENCH_PIXELS];
    for (int i = 0; i < BENCH_PIXELS; i++) ones[i] = 1;
    assert_true(gpu_upload(&device, &b->r.images[resource], ones));
}

/* Confidence is 0 everywhere, the mix of thresholds 1. */
static void every_setting_does_what_it_is_there_for(void **state)
{
    static bench b;
    nrd_setting setting;
    bench_open(&b, *(const nrd_denoiser *)*state, BENCH_WIDTH, BENCH_HEIGHT, wall, noise, NRD_FEATURE_PREPASS | NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION
               | NRD_FEATURE_MATERIALS | NRD_FEATURE_HISTORY_CONFIDENCE | NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX);
    fill_with_ones(&b, NRD_RESOURCE_IN_DISOCCLUSION_THRESHOLD_MIX);
    for (int i = 0; i < ROW_COUNT; i++) {
        double more[BENCH_VALUE_LANES], less[BENCH_VALUE_LANES];
        const row *r = &rows[i];
        if (!find_setting(b.denoiser, r->setting, &setting) && !find_setting(NRD_DENOISER_COUNT, r->setting, &setting)) continue;
        if (r->more > setting.max) continue; /* performance_mode 2 is radiance's */
        measure_row(&b, r, r->more, more);
        measure_row(&b, r, r->less, less);
        for (int k = 0; k < BENCH_VALUE_LANES; k++)
            if (concerns(&b, r, &bench_lanes[k]) && !(more[k] > r->factor * less[k]))
                fail_msg("%s: %s of %g gives %g in %s, %g gives %g: less than %g times as much\n", bench_name(&b), r->setting, r->more, more[k],
                         nrd_resource_name(bench_lanes[k].out), r->less, less[k], r->factor);
    }
    bench_close(&b);
}

/* What other tests ask of every denoiser: test_every_reblur, test_overlay, test_conventions, test_inputs, test_occlusion,
   test_tiles (roughness), and nrd-stress (the sky). */
static bool is_tested_elsewhere(const char *name)
{
    static const char *const names[] = { "split_screen", "validation", "motion_mode", "specular_motion", "diffuse_checkerboard", "specular_checkerboard",
                                         "return_history_length_instead_of_occlusion", "denoising_range", "specular_roughness_limit" };
    bool is = false;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) is |= !strcmp(name, names[i]);
    return is;
}

static void every_setting_has_a_row(void **state)
{
    (void)state;
    for (int d = 0; d <= 10; d++) {
        nrd_setting setting;
        for (uint32_t k = 0; nrd_get_setting(d < 10 ? bench_denoisers[d] : NRD_DENOISER_COUNT, k, &setting); k++) {
            bool found = is_tested_elsewhere(setting.name);
            for (int i = 0; i < ROW_COUNT; i++) found |= !strcmp(rows[i].setting, setting.name);
            if (!found) fail_msg("no row for %s", setting.name);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_setting_has_a_row),
        EVERY_REBLUR(every_setting_does_what_it_is_there_for),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
