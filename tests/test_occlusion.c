/* What the occlusion denoisers promise, on a device: means are kept, edges are not crossed, bad pixels and the outside have no
   effect, history follows the surfaces, and every setting does what it says. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "denoise_rig.h"

enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT };

/* ---------------------------------------------------------------------------------------------------------------------------
   Bench  >>bench */
/* What most tests are run on: each of the lobes, alone and with the other. */
typedef struct kind {
    nrd_denoiser denoiser;
    nrd_resource input, output;   /* of the lobe that is looked at */
} kind;
static const kind kinds[] = {
    { NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, NRD_RESOURCE_IN_DIFF_HITDIST, NRD_RESOURCE_OUT_DIFF_HITDIST },
    { NRD_DENOISER_REBLUR_SPECULAR_OCCLUSION, NRD_RESOURCE_IN_SPEC_HITDIST, NRD_RESOURCE_OUT_SPEC_HITDIST },
    { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, NRD_RESOURCE_IN_DIFF_HITDIST, NRD_RESOURCE_OUT_DIFF_HITDIST },
    { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, NRD_RESOURCE_IN_SPEC_HITDIST, NRD_RESOURCE_OUT_SPEC_HITDIST },
    { NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, NRD_RESOURCE_OUT_DIFF_DIRECTION_HITDIST },
};

/* A rig whose signal is one half per pixel. */
typedef struct bench {
    rig r;
    nrd_occlusion_settings settings;
    kind of;
    double roughness;
    bool directional;
    uint16_t in[PIXELS], out[PIXELS];
    uint16_t in_moments[PIXELS][4], out_moments[PIXELS][4];   /* directional: what is bound */
} bench;

static void bench_open_with(bench *b, kind of, scene *what, uint32_t features)
{
    memset(b, 0, sizeof *b);
    rig_open_with(&b->r, &device, of.denoiser, WIDTH, HEIGHT, what, features);
    b->settings = nrd_occlusion_defaults();
    b->of = of;
    b->directional = of.denoiser == NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION;
    b->roughness = 1;
}

static void bench_open(bench *b, kind of, scene *what) { bench_open_with(b, of, what, 0); }
static void bench_close(bench *b) { rig_close(&b->r); }

/* Cosine-weighted about the normal of the walls, (0, 0, -1). */
static void ray_at(const bench *b, uint32_t x, uint32_t y, double direction[3])
{
    double r2 = random_at(x, y, 5000 + b->r.index), angle = 6.2831853 * random_at(y, x, 7000 + b->r.index);
    direction[0] = sqrt(r2) * cos(angle);
    direction[1] = sqrt(r2) * sin(angle);
    direction[2] = -sqrt(1 - r2);
}

static void bench_put_moments(bench *b)
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        double ray[3];
        float w = half_to_float(b->in[i]);
        ray_at(b, i % WIDTH, i / WIDTH, ray);
        for (int k = 0; k < 3; k++) b->in_moments[i][k] = half_from_float((float)ray[k] * w);
        b->in_moments[i][3] = b->in[i];
    }
}

/* One frame with whatever the arrays hold. */
static void bench_run(bench *b)
{
    if (b->directional) bench_put_moments(b);
    assert_true(gpu_upload(&device, &b->r.images[b->of.input], b->directional ? (const void *)b->in_moments : b->in));
    assert_int_equal(nrd_set_settings(b->r.instance, RIG_IDENTIFIER, &b->settings), NRD_RESULT_OK);
    rig_run(&b->r, true);
    assert_true(gpu_download(&device, &b->r.images[b->of.output], b->directional ? (void *)b->out_moments : b->out));
    for (uint32_t i = 0; i < PIXELS && b->directional; i++) b->out[i] = b->out_moments[i][3];
}

static void bench_put_guides(bench *b)
{
    rig_put_guides(&b->r);
    for (uint32_t y = 0; y < b->r.rect_height && b->roughness < 1; y++)
        for (uint32_t x = 0; x < b->r.rect_width; x++) {
            const hit *h = &b->r.hits[y * b->r.rect_width + x];
            const float normal[3] = { (float)h->normal[0], (float)h->normal[1], (float)h->normal[2] };
            b->r.normal[y * WIDTH + x] = pack_normal_roughness(normal, (float)b->roughness, h->material);
        }
}

typedef float signal(const bench *b, uint32_t x, uint32_t y);

static void bench_put(bench *b, signal *of)
{
    for (uint32_t y = 0; y < b->r.rect_height; y++)
        for (uint32_t x = 0; x < b->r.rect_width; x++) b->in[y * WIDTH + x] = half_from_float(of(b, x, y));
}

static void bench_step(bench *b, signal *of)
{
    bench_put_guides(b);
    bench_put(b, of);
    bench_run(b);
}

static double out_at(const bench *b, uint32_t x, uint32_t y) { return half_to_float(b->out[y * WIDTH + x]); }
static const hit *hit_at(const bench *b, uint32_t x, uint32_t y) { return &b->r.hits[y * b->r.rect_width + x]; }

static void assert_below(double value, double limit, const char *what)
{
    if (!(value <= limit)) fail_msg("%s is %g, allowed is %g", what, value, limit);
}

/* Over the pixels of a region. */
static double mean_of(const bench *b, uint32_t region, double *deviation)
{
    double sum = 0, squares = 0;
    uint32_t count = 0;
    for (uint32_t y = 0; y < b->r.rect_height; y++)
        for (uint32_t x = 0; x < b->r.rect_width; x++)
            if (hit_at(b, x, y)->region == region) sum += out_at(b, x, y), squares += out_at(b, x, y) * out_at(b, x, y), count++;
    assert_true(count > 0);
    if (deviation) *deviation = sqrt(fmax(squares / count - sum / count * sum / count, 0));
    return sum / count;
}

static double largest_error(const bench *b, double expected)
{
    double worst = 0;
    for (uint32_t y = 0; y < b->r.rect_height; y++)
        for (uint32_t x = 0; x < b->r.rect_width; x++)
            if (hit_at(b, x, y)->depth < RIG_RANGE) worst = fmax(worst, fabs(out_at(b, x, y) - expected));
    return worst;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Scenes and signals  >>scenes */
static hit plane_hit(const pose *p, double u, double v, const double point[3], const double normal[3])
{
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 9 };
    double depth;
    if (!rig_ray_plane(p, u, v, point, normal, &depth) || depth >= RIG_RANGE) return h;
    h.depth = depth;
    h.region = 0;
    memcpy(h.normal, normal, sizeof h.normal);
    return h;
}

static hit wall_at(const pose *p, double u, double v, double z)
{
    const double point[3] = { 0, 0, z }, normal[3] = { 0, 0, -1 };
    return plane_hit(p, u, v, point, normal);
}

static hit wall(const pose *p, double u, double v, uint32_t frame)
{
    (void)frame;
    return wall_at(p, u, v, 5);
}

static hit wall_and_sky(const pose *p, double u, double v, uint32_t frame)
{
    hit sky = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 9 };
    return v < 0.3 ? sky : wall(p, u, v, frame);
}

/* Region 1: the right half, four times as far. */
static hit two_depths(const pose *p, double u, double v, uint32_t frame)
{
    (void)frame;
    hit h = wall_at(p, u, v, u < 0.5 ? 5 : 20);
    h.region = u >= 0.5;
    return h;
}

/* Region 1: floor under a wall; they meet at a right angle in the lower half of the picture. */
static hit right_angle(const pose *p, double u, double v, uint32_t frame)
{
    const double point[3] = { 0, -1, 0 }, up[3] = { 0, 1, 0 };
    hit floor = plane_hit(p, u, v, point, up), back = wall(p, u, v, frame);
    floor.region = 1;
    return floor.depth < back.depth ? floor : back;
}

/* Region 1: the right half of a wall, of another material. */
static hit two_materials(const pose *p, double u, double v, uint32_t frame)
{
    hit h = wall(p, u, v, frame);
    h.material = h.region = u >= 0.5;
    return h;
}

/* Region 1: the right half of a wall leans back by 25 degrees. */
static hit bent(const pose *p, double u, double v, uint32_t frame)
{
    const double point[3] = { 0, 0, 5 }, leaning[3] = { -sin(0.436), 0, -cos(0.436) };
    if (u < 0.5) return wall(p, u, v, frame);
    hit h = plane_hit(p, u, v, point, leaning);
    h.region = 1;
    return h;
}

/* Region 1: the right half of a wall is a little farther. */
static hit step(const pose *p, double u, double v, uint32_t frame)
{
    (void)frame;
    hit h = wall_at(p, u, v, u < 0.5 ? 5 : 5.3);
    h.region = u >= 0.5;
    return h;
}

/* Another place from this frame on. */
enum { JUMP = 12 };
static hit jump(const pose *p, double u, double v, uint32_t frame) { return wall_at(p, u, v, frame < JUMP ? 5 : 20); }

static float half_open(const bench *b, uint32_t x, uint32_t y) { (void)b; (void)x; (void)y; return 0.5f; }
static float open_all(const bench *b, uint32_t x, uint32_t y) { (void)b; (void)x; (void)y; return 1.0f; }
static float nearly_closed(const bench *b, uint32_t x, uint32_t y) { (void)b; (void)x; (void)y; return 0.02f; }

/* Rays that meet something at a middle distance, or nothing: mean 0.7, deviation 0.32. */
static float noise(const bench *b, uint32_t x, uint32_t y)
{
    double u = random_at(x, y, b->r.index);
    return u < 0.5 ? 1.0f : (float)(0.2 + 0.8 * (u - 0.5));
}

/* Regions are fully open and nearly closed, without noise. */
static float by_region(const bench *b, uint32_t x, uint32_t y) { return hit_at(b, x, y)->region == 1 ? 0.02f : 1.0f; }
static float by_frame(const bench *b, uint32_t x, uint32_t y) { (void)x; (void)y; return b->r.index < JUMP ? 0.02f : 1.0f; }

/* ---------------------------------------------------------------------------------------------------------------------------
   Energy and edges  >>energy */
static void assert_constant(kind of, signal *put, double value)
{
    bench b;
    bench_open(&b, of, wall_and_sky);
    for (uint32_t frame = 0; frame < 80; frame++) {
        b.r.camera.position[0] = 0.01 * frame;
        bench_step(&b, put);
    }
    assert_below(largest_error(&b, value), 1.0 / 255, "difference to the constant");
    bench_close(&b);
}

static void a_constant_stays_within_a_step_of_8_bits(void **state)
{
    kind of = *(const kind *)*state;
    assert_constant(of, open_all, 1);
    assert_constant(of, half_open, 0.5);
    assert_constant(of, nearly_closed, 0.02);
}

static void noise_keeps_its_mean_and_loses_its_deviation(void **state)
{
    bench b;
    double sum = 0, deviation = 0;
    kind of = *(const kind *)*state;
    bench_open(&b, of, wall);
    for (uint32_t frame = 0; frame < 80; frame++) {
        bench_step(&b, noise);
        if (frame >= 40) sum += mean_of(&b, 0, &deviation);
    }
    print_message("mean %.4f, deviation %.4f\n", sum / 40, deviation);
    assert_below(fabs(sum / 40 - 0.7), 0.003, "error of the mean");
    assert_below(deviation, 0.025, "deviation");
    bench_close(&b);
}

/* Regions that are constants of their own: what differs from them came over the edge. */
static double leak(kind of, scene *what, const nrd_occlusion_settings *settings)
{
    bench b;
    double worst = 0;
    bench_open(&b, of, what);
    b.settings = *settings;
    for (uint32_t frame = 0; frame < 24; frame++) bench_step(&b, by_region);
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++) worst = fmax(worst, fabs(out_at(&b, x, y) - (double)by_region(&b, x, y)));
    bench_close(&b);
    return worst;
}

static void nothing_leaks_across_edges_in_depth_and_direction(void **state)
{
    nrd_occlusion_settings s = nrd_occlusion_defaults();
    kind of = *(const kind *)*state;
    assert_below(leak(of, two_depths, &s), 4e-3, "leak across depths");
    assert_below(leak(of, right_angle, &s), 4e-3, "leak across a right angle");
}

static void sensitivities_and_materials_keep_surfaces_apart(void **state)
{
    nrd_occlusion_settings s = nrd_occlusion_defaults();
    kind of = *(const kind *)*state;
    assert_true(leak(of, two_materials, &s) > 0.05);
    s.min_material = 0;
    assert_below(leak(of, two_materials, &s), 4e-3, "leak across materials");
    s = nrd_occlusion_defaults();
    s.plane_distance_sensitivity = 1;
    s.normal_sensitivity = 0;
    assert_true(leak(of, bent, &s) > 0.05 && leak(of, step, &s) > 0.05);
    s.normal_sensitivity = 200;
    assert_below(leak(of, bent, &s), 0.02, "leak across a bend under a high normal sensitivity");
    s.plane_distance_sensitivity = 0.006f;
    assert_below(leak(of, step, &s), 4e-3, "leak across a step of 6 % of the depth");
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Bad pixels  >>bad */
static void two_runs_are_identical_to_the_bit(void **state)
{
    static bench a, b;
    kind of = *(const kind *)*state;
    bench_open(&a, of, wall_and_sky);
    bench_open(&b, of, wall_and_sky);
    for (uint32_t frame = 0; frame < 10; frame++) {
        a.r.camera.position[0] = b.r.camera.position[0] = 0.03 * frame;
        bench_step(&a, noise);
        bench_step(&b, noise);
        assert_memory_equal(a.out, b.out, sizeof a.out);
    }
    bench_close(&a);
    bench_close(&b);
}

static void poison(bench *b, uint32_t x, uint32_t y)
{
    size_t at = y * WIDTH + x;
    for (int c = 0; c < 4; c++) b->r.mv[4 * at + c] = NAN;
    b->r.normal[at] = 0xffffffffu;
    b->r.view_z[at] = NAN;
    b->in[at] = half_from_float(NAN);
}

static void nothing_outside_the_rectangle_or_in_the_sky_has_an_effect(void **state)
{
    static bench bad, good;
    kind of = *(const kind *)*state;
    bench_open(&bad, of, wall_and_sky);
    bench_open(&good, of, wall_and_sky);
    bad.r.rect_width = good.r.rect_width = 43;
    bad.r.rect_height = good.r.rect_height = 30;
    for (uint32_t frame = 0; frame < 8; frame++) {
        bad.r.camera.position[0] = good.r.camera.position[0] = 0.05 * frame;
        bench_step(&good, noise);
        bench_put_guides(&bad);
        bench_put(&bad, noise);
        for (uint32_t i = 0; i < PIXELS; i++) {
            bool outside = i % WIDTH >= 43 || i / WIDTH >= 30;
            if (outside || hit_at(&bad, i % WIDTH, i / WIDTH)->depth >= RIG_RANGE) poison(&bad, i % WIDTH, i / WIDTH);
        }
        bench_run(&bad);
        assert_memory_equal(bad.out, good.out, sizeof bad.out);
    }
    bench_close(&bad);
    bench_close(&good);
}

static float bad_or_noise(const bench *b, uint32_t x, uint32_t y)
{
    static const float values[] = { NAN, INFINITY, -INFINITY, -1 };
    return random_at(x, y, 1000 + b->r.index) < 0.1 ? values[(x + y) % 4] : noise(b, x, y);
}

static float none_or_noise(const bench *b, uint32_t x, uint32_t y) { return random_at(x, y, 1000 + b->r.index) < 0.1 ? 0 : noise(b, x, y); }

static void bad_hit_distances_count_as_not_sampled(void **state)
{
    static bench bad, good;
    kind of = *(const kind *)*state;
    bench_open(&bad, of, wall);
    bench_open(&good, of, wall);
    for (uint32_t frame = 0; frame < 8; frame++) {
        bench_step(&bad, bad_or_noise);
        bench_step(&good, none_or_noise);
        assert_memory_equal(bad.out, good.out, sizeof bad.out);
    }
    bench_close(&bad);
    bench_close(&good);
}

/* Three pixels of four. */
static float sparse(const bench *b, uint32_t x, uint32_t y) { return random_at(x, y, 2000 + b->r.index) < 0.75 ? 0 : noise(b, x, y); }

static void pixels_that_were_not_sampled_do_not_darken(void **state)
{
    bench b;
    double sum = 0;
    kind of = *(const kind *)*state;
    bench_open(&b, of, wall);
    bench_step(&b, sparse);
    assert_below(fabs(mean_of(&b, 0, NULL) - 0.7), 0.03, "error of the first frame's mean");
    for (uint32_t frame = 0; frame < 64; frame++) {
        bench_step(&b, sparse);
        if (frame >= 32) sum += mean_of(&b, 0, NULL);
    }
    assert_below(fabs(sum / 32 - 0.7), 0.005, "error of the mean");
    bench_close(&b);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   History  >>history */
/* Every other pixel, once told so in place and once packed into the left half. */
static void a_checkerboard_is_an_input_of_which_every_other_pixel_was_not_sampled(void **state)
{
    bench full, half;
    kind of = *(const kind *)*state;
    bench_open_with(&full, of, wall, 0);
    bench_open_with(&half, of, wall, NRD_FEATURE_CHECKERBOARD);
    half.settings.diffuse_checkerboard = half.settings.specular_checkerboard = 2;
    for (uint32_t frame = 0; frame < 6; frame++) {
        bench_put_guides(&full);
        bench_put_guides(&half);
        for (uint32_t i = 0; i < PIXELS; i++) full.in[i] = 0, half.in[i] = half_from_float(1);
        for (uint32_t y = 0; y < HEIGHT; y++)
            for (uint32_t x = 0; x < WIDTH; x++)
                if (((x ^ y ^ frame) & 1) == 1) full.in[y * WIDTH + x] = half.in[y * WIDTH + x / 2] = half_from_float(noise(&full, x, y));
        bench_run(&full);
        bench_run(&half);
        assert_memory_equal(half.out, full.out, sizeof full.out);
    }
    bench_close(&full);
    bench_close(&half);
}

static void history_grows_by_one_every_frame_up_to_its_limit_and_restarts(void **state)
{
    bench b;
    kind of = *(const kind *)*state;
    bench_open(&b, of, wall);
    b.settings.return_history_length_instead_of_occlusion = 1;
    b.settings.max_accumulated_frames = 8;
    b.settings.antilag_sigma_scale = 100;
    for (uint32_t frame = 0; frame < 20; frame++) {
        b.r.frame.restart = frame == 12;
        bench_step(&b, noise);
        double expected = frame < 12 ? fmin(frame + 1, 9) : fmin(frame - 11, 9);
        assert_below(largest_error(&b, expected), 1e-6, "error of the history length");
    }
    bench_close(&b);
}

static void after_a_jump_nothing_is_left_of_the_old_content(void **state)
{
    bench b;
    kind of = *(const kind *)*state;
    bench_open(&b, of, jump);
    for (uint32_t frame = 0; frame <= JUMP; frame++) bench_step(&b, by_frame);
    assert_below(largest_error(&b, 1), 1e-3, "trace of the old content");
    bench_close(&b);
}

static void history_follows_a_surface_under_a_moving_camera(void **state)
{
    bench b;
    double deviation;
    kind of = *(const kind *)*state;
    bench_open(&b, of, right_angle);
    for (uint32_t frame = 0; frame < 40; frame++) {
        b.r.camera.position[0] = 0.037 * frame;
        b.r.camera.position[2] = 0.01 * frame;
        bench_step(&b, noise);
    }
    assert_below(fabs(mean_of(&b, 0, &deviation) - 0.7), 0.01, "error of the mean");
    assert_below(deviation, 0.03, "deviation");
    bench_close(&b);
}

/* 1 in the right half of an optional input, 0 in the left. */
static void upload_halves(bench *b, nrd_resource resource)
{
    static float texels[PIXELS];
    for (uint32_t i = 0; i < PIXELS; i++) texels[i] = i % WIDTH >= WIDTH / 2;
    assert_true(gpu_upload(&device, &b->r.images[resource], texels));
}

/* The farther wall is another place under disocclusion_threshold, and the same under the alternate one. */
static hit small_jump(const pose *p, double u, double v, uint32_t frame) { return wall_at(p, u, v, frame < JUMP ? 5 : 5.15); }

static void confidence_and_the_threshold_mix_decide_per_pixel_what_history_counts(void **state)
{
    kind of = *(const kind *)*state;
    bench b;
    nrd_resource confidence = of.input == NRD_RESOURCE_IN_SPEC_HITDIST ? NRD_RESOURCE_IN_SPEC_CONFIDENCE : NRD_RESOURCE_IN_DIFF_CONFIDENCE;
    bench_open_with(&b, of, small_jump, NRD_FEATURE_ALL);
    b.settings.return_history_length_instead_of_occlusion = 1;
    b.settings.antilag_sigma_scale = 100;
    upload_halves(&b, confidence);
    upload_halves(&b, NRD_RESOURCE_IN_DISOCCLUSION_THRESHOLD_MIX);
    b.r.frame.history_confidence_available = 1;
    for (uint32_t frame = 0; frame < JUMP; frame++) {
        bench_step(&b, noise);
        assert_true(fabs(out_at(&b, 10, 20) - 1) < 1e-6 && fabs(out_at(&b, 50, 20) - (frame + 1)) < 1e-6);
    }
    b.r.frame.disocclusion_threshold_mix_available = 1;
    bench_step(&b, noise);
    assert_true(fabs(out_at(&b, 50, 20) - (JUMP + 1)) < 1e-6);
    bench_close(&b);
    bench_open_with(&b, of, small_jump, NRD_FEATURE_ALL);
    b.settings.return_history_length_instead_of_occlusion = 1;
    for (uint32_t frame = 0; frame <= JUMP; frame++) bench_step(&b, noise);
    assert_float_equal(out_at(&b, 50, 20), 1, 1e-6);
    bench_close(&b);
}

/* From JUMP on the same wall is of another material, or shaded as if it faced another way. */
static hit repainted(const pose *p, double u, double v, uint32_t frame)
{
    hit h = wall(p, u, v, frame);
    h.material = frame >= JUMP;
    return h;
}

static hit turned(const pose *p, double u, double v, uint32_t frame)
{
    hit h = wall(p, u, v, frame);
    if (frame >= JUMP) h.normal[0] = sin(1.3), h.normal[2] = -cos(1.3);
    return h;
}

static double length_at_the_jump(kind of, scene *what, uint32_t min_material)
{
    bench b;
    bench_open(&b, of, what);
    b.settings.return_history_length_instead_of_occlusion = 1;
    b.settings.antilag_sigma_scale = 100;
    b.settings.min_material = min_material;
    for (uint32_t frame = 0; frame <= JUMP; frame++) bench_step(&b, noise);
    double length = out_at(&b, WIDTH / 2, HEIGHT / 2);
    bench_close(&b);
    return length;
}

static void history_is_that_of_the_same_material_and_direction(void **state)
{
    kind of = *(const kind *)*state;
    assert_float_equal(length_at_the_jump(of, repainted, 4), JUMP + 1, 1e-6);
    assert_float_equal(length_at_the_jump(of, repainted, 0), 1, 1e-6);
    assert_float_equal(length_at_the_jump(of, turned, 4), 1, 1e-6);
}

static void left_of_the_split_is_the_input(void **state)
{
    kind of = *(const kind *)*state;
    bench b;
    bench_open_with(&b, of, wall, NRD_FEATURE_ALL);
    b.r.frame.split_screen = 0.5f;
    for (uint32_t frame = 0; frame < 4; frame++) bench_step(&b, noise);
    for (uint32_t i = 0; i < PIXELS; i++)
        if (i % WIDTH < WIDTH / 2) assert_int_equal(b.out[i], b.in[i]);
    uint32_t same = 0;
    for (uint32_t i = 0; i < PIXELS; i++) same += i % WIDTH >= WIDTH / 2 && b.out[i] == b.in[i];
    assert_in_range(same, 0, PIXELS / 100);
    bench_close(&b);
}

/* Frames from a change of the signal to nine tenths of it, on average over the picture. */
static uint32_t frames_until_followed(kind of, float sigma_scale)
{
    bench b;
    uint32_t frames = 0;
    bench_open(&b, of, wall);
    b.settings.antilag_sigma_scale = sigma_scale;
    for (uint32_t frame = 0; frame < 40; frame++) bench_step(&b, noise);
    do bench_step(&b, nearly_closed); while (++frames < 64 && mean_of(&b, 0, NULL) > 0.02 + 0.1 * 0.68);
    bench_close(&b);
    return frames;
}

static void a_change_is_followed_within_3_frames_unless_told_otherwise(void **state)
{
    kind of = *(const kind *)*state;
    uint32_t fast = frames_until_followed(of, nrd_occlusion_defaults().antilag_sigma_scale), slow = frames_until_followed(of, 100);
    print_message("9/10 of a change after %u frames, by averaging alone after %u\n", fast, slow);
    assert_in_range(fast, 1, 3);
    assert_true(slow > 20);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Settings  >>settings */
static double deviation_with(kind of, const nrd_occlusion_settings *settings, double roughness)
{
    bench b;
    double deviation;
    bench_open(&b, of, wall);
    b.settings = *settings;
    b.roughness = roughness;
    for (uint32_t frame = 0; frame < 20; frame++) bench_step(&b, noise);
    mean_of(&b, 0, &deviation);
    bench_close(&b);
    return deviation;
}

/* Where occluders are so far that max_blur_radius is what limits the disc. */
static void longer_history_and_wider_blur_are_less_noisy(void **state)
{
    nrd_occlusion_settings s = nrd_occlusion_defaults();
    kind of = *(const kind *)*state;
    float frames = s.max_accumulated_frames;
    s.hit_distance_a = 30;
    double plain = deviation_with(of, &s, 1);
    s.max_accumulated_frames = 2;
    double brief = deviation_with(of, &s, 1);
    s.max_accumulated_frames = frames;
    s.max_blur_radius = 0;
    double raw = deviation_with(of, &s, 1);
    s.max_blur_radius = 2;
    double narrow = deviation_with(of, &s, 1);
    print_message("deviation %.4f, of 2 frames %.4f, without blur %.4f, within 2 px %.4f\n", plain, brief, raw, narrow);
    assert_true(brief > 1.5 * plain && raw > 1.5 * plain && narrow > 1.1 * plain && narrow < raw);
}

/* The blur's reach in the world grows with the length that counts as unoccluded. */
static void the_hit_distance_scale_sets_the_reach(void **state)
{
    nrd_occlusion_settings s = nrd_occlusion_defaults();
    kind of = *(const kind *)*state;
    s.hit_distance_a = 0.01f;
    s.hit_distance_b = 0;
    double tiny = deviation_with(of, &s, 1);
    s.hit_distance_b = 0.6f;
    double grown = deviation_with(of, &s, 1);
    print_message("deviation with A 0.01 %.4f, with B 0.6 too %.4f\n", tiny, grown);
    assert_true(tiny > 1.2 * grown);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Reflections  >>reflections */
/* What a mirror at z = 5 shows of stripes 6 m in front of it, along the camera ray through a pixel's centre. */
static float stripes(const bench *b, uint32_t x, uint32_t y)
{
    double world[3];
    pose_point(&b->r.camera, (x + 0.5) / WIDTH, (y + 0.5) / HEIGHT, 11 - b->r.camera.position[2], world);
    return fmod(world[0] + 40, 2) < 1 ? 0.9f : 0.2f;
}

static void a_mirror_under_a_moving_camera_shows_what_it_reflects_now(void **state)
{
    bench b;
    (void)state;
    bench_open(&b, kinds[1], wall);
    b.roughness = 0.02;
    b.settings.hit_distance_a = 7;
    b.settings.hit_distance_b = 0;
    b.settings.hit_distance_c = 1;
    for (uint32_t frame = 0; frame < 24; frame++) {
        b.r.camera.position[0] = 0.31 * frame;
        bench_step(&b, stripes);
        for (uint32_t i = 0; i < PIXELS; i++) assert_below(fabs(out_at(&b, i % WIDTH, i / WIDTH) - half_to_float(b.in[i])), 0.05, "trail of a mirror");
    }
    bench_close(&b);
}

static double length_after(double roughness, double pan, double yaw)
{
    bench b;
    bench_open(&b, kinds[1], wall);
    b.roughness = roughness;
    b.settings.return_history_length_instead_of_occlusion = 1;
    for (uint32_t frame = 0; frame < 20; frame++) {
        b.r.camera.position[0] = pan * frame;
        b.r.camera.yaw = yaw * frame;
        bench_step(&b, noise);
    }
    double length = out_at(&b, WIDTH / 2, HEIGHT / 2);
    bench_close(&b);
    return length;
}

static void specular_history_is_cut_by_parallax_of_smooth_surfaces_only(void **state)
{
    (void)state;
    double mirror = length_after(0.02, 0.1, 0), glossy = length_after(0.35, 0.1, 0), rough = length_after(1, 0.1, 0), turned = length_after(0.02, 0, 0.01);
    print_message("history under translation: roughness 0.02 %.1f, 0.35 %.1f, 1 %.1f; under rotation, 0.02: %.1f\n", mirror, glossy, rough, turned);
    assert_below(mirror, 2, "history of a mirror that moves");
    assert_true(glossy > 1.5 * mirror && rough > 18 && turned > 18);
}

static void the_factors_of_roughness_set_the_specular_reach(void **state)
{
    nrd_occlusion_settings s = nrd_occlusion_defaults();
    (void)state;
    s.hit_distance_a = 0.1f;
    s.hit_distance_b = 0;
    s.hit_distance_c = 1;
    double flat = deviation_with(kinds[1], &s, 0.4);
    s.hit_distance_c = 50;
    s.hit_distance_d = -1;
    double grown = deviation_with(kinds[1], &s, 0.4);
    s.hit_distance_d = -1000;
    double fallen = deviation_with(kinds[1], &s, 0.4);
    print_message("deviation with C 1 %.4f, C 50 %.4f, falling fast %.4f\n", flat, grown, fallen);
    assert_true(flat > 1.2 * grown && fallen > 1.2 * grown);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Directions  >>directions */
/* A blocker covers the half space of negative x. */
static float beside_a_blocker(const bench *b, uint32_t x, uint32_t y)
{
    double ray[3];
    ray_at(b, x, y, ray);
    return ray[0] > 0 ? 1.0f : 0.25f;
}

/* Means over the cosine-weighted half spheres: |x| 4 / (3 pi), |z| 2 / 3. */
static void the_bent_direction_points_to_where_it_is_open(void **state)
{
    const double x = (1 - 0.25) * 2 / (3 * 3.14159265), z = -0.625 * 2 / 3;
    bench b;
    double worst = 0, mean[3] = { 0, 0, 0 };
    (void)state;
    bench_open(&b, kinds[4], wall);
    for (uint32_t frame = 0; frame < 48; frame++) bench_step(&b, beside_a_blocker);
    for (uint32_t i = 0; i < PIXELS; i++) {
        double m[3], length, w = half_to_float(b.out_moments[i][3]), squared = 0;
        for (int k = 0; k < 3; k++) m[k] = half_to_float(b.out_moments[i][k]), squared += m[k] * m[k], mean[k] += m[k] / PIXELS;
        length = sqrt(squared);
        assert_below(length, w * 1.002, "length of the moment over the openness");
        worst = fmax(worst, acos(fmin((m[0] * x + m[2] * z) / (length * sqrt(x * x + z * z)), 1)));
    }
    print_message("bent directions within %.1f degrees; mean %.4f %.4f %.4f, expected %.4f 0 %.4f\n", worst * 57.29578, mean[0], mean[1], mean[2], x, z);
    assert_below(worst, 0.2, "error of the bent direction");
    assert_below(fabs(mean[0] - x) + fabs(mean[1]) + fabs(mean[2] - z), 0.01, "error of the mean moment");
    bench_close(&b);
}

/* Moments that are no numbers count as none, and longer ones than their hit distance as just as long. */
static void bad_moments_stay_within_the_openness(void **state)
{
    bench b;
    (void)state;
    bench_open(&b, kinds[4], wall);
    bench_put_guides(&b);
    for (uint32_t frame = 0; frame < 4; frame++) {
        for (uint32_t i = 0; i < PIXELS; i++) {
            const float texel[4] = { i % 3 == 0 ? NAN : 60000.0f, i % 3 == 1 ? INFINITY : -1.0f, 0, 0.5f };
            for (int k = 0; k < 4; k++) b.in_moments[i][k] = half_from_float(texel[k]);
        }
        assert_true(gpu_upload(&device, &b.r.images[b.of.input], b.in_moments));
        rig_run(&b.r, true);
        assert_true(gpu_download(&device, &b.r.images[b.of.output], b.out_moments));
        for (uint32_t i = 0; i < PIXELS; i++) {
            double squared = 0;
            for (int k = 0; k < 3; k++) squared += half_to_float(b.out_moments[i][k]) * half_to_float(b.out_moments[i][k]);
            if (!(sqrt(squared) <= 0.502 && fabs(half_to_float(b.out_moments[i][3]) - 0.5) < 4e-3)) fail_msg("pixel %u: |moment| %g", i, sqrt(squared));
        }
    }
    bench_close(&b);
}

#define EVERY_KIND(test) \
    { #test, test, NULL, NULL, (void *)&kinds[0] }, { #test "_specular", test, NULL, NULL, (void *)&kinds[1] }, \
    { #test "_diffuse_of_both", test, NULL, NULL, (void *)&kinds[2] }, { #test "_specular_of_both", test, NULL, NULL, (void *)&kinds[3] }, \
    { #test "_directional", test, NULL, NULL, (void *)&kinds[4] }

int main(void)
{
    const struct CMUnitTest tests[] = {
        EVERY_KIND(a_constant_stays_within_a_step_of_8_bits),
        EVERY_KIND(noise_keeps_its_mean_and_loses_its_deviation),
        EVERY_KIND(nothing_leaks_across_edges_in_depth_and_direction),
        EVERY_KIND(sensitivities_and_materials_keep_surfaces_apart),
        EVERY_KIND(two_runs_are_identical_to_the_bit),
        EVERY_KIND(nothing_outside_the_rectangle_or_in_the_sky_has_an_effect),
        EVERY_KIND(bad_hit_distances_count_as_not_sampled),
        EVERY_KIND(pixels_that_were_not_sampled_do_not_darken),
        EVERY_KIND(a_checkerboard_is_an_input_of_which_every_other_pixel_was_not_sampled),
        EVERY_KIND(history_grows_by_one_every_frame_up_to_its_limit_and_restarts),
        EVERY_KIND(after_a_jump_nothing_is_left_of_the_old_content),
        EVERY_KIND(history_follows_a_surface_under_a_moving_camera),
        EVERY_KIND(confidence_and_the_threshold_mix_decide_per_pixel_what_history_counts),
        EVERY_KIND(history_is_that_of_the_same_material_and_direction),
        EVERY_KIND(left_of_the_split_is_the_input),
        EVERY_KIND(a_change_is_followed_within_3_frames_unless_told_otherwise),
        EVERY_KIND(longer_history_and_wider_blur_are_less_noisy),
        EVERY_KIND(the_hit_distance_scale_sets_the_reach),
        cmocka_unit_test(a_mirror_under_a_moving_camera_shows_what_it_reflects_now),
        cmocka_unit_test(specular_history_is_cut_by_parallax_of_smooth_surfaces_only),
        cmocka_unit_test(the_factors_of_roughness_set_the_specular_reach),
        cmocka_unit_test(the_bent_direction_points_to_where_it_is_open),
        cmocka_unit_test(bad_moments_stay_within_the_openness),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
