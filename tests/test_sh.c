/* What the denoisers with directions (SH) promise, on a device: the colour is the plain denoiser's, the direction goes the same way, and
   luma under the pixel's own normal shows the detail of normals that blending takes out. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#define RIG_SH
#include "denoise_rig.h"

#ifdef RIG_SPECULAR
#define PLAIN NRD_DENOISER_REBLUR_SPECULAR
#define PLAIN_IN NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST
#define PLAIN_OUT NRD_RESOURCE_OUT_SPEC_RADIANCE_HITDIST
#else
#define PLAIN NRD_DENOISER_REBLUR_DIFFUSE
#define PLAIN_IN NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST
#define PLAIN_OUT NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST
#endif
#define ROUGHNESS 0.5f /* of the specular surfaces whose detail is measured */
enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT, SECOND_IN = RIG_RADIANCE + 1, SECOND_OUT = RIG_OUT + 1 };

static uint16_t directions[4 * PIXELS], moments[4 * PIXELS]; /* the second texels, in and out */

/* ---------------------------------------------------------------------------------------------------------------------------
   Scenes  >>scenes */
static hit wall(const pose *p, double u, double v, double depth)
{
    double point[3] = { 0, 0, depth };
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 0 };
    rig_ray_plane(p, u, v, point, h.normal, &h.depth);
    return h;
}

static hit flat_wall(const pose *p, double u, double v, uint32_t frame)
{
    (void)frame;
    return wall(p, u, v, 8);
}

static hit two_walls(const pose *p, double u, double v, uint32_t frame)
{
    (void)frame;
    hit h = wall(p, u, v, u < 0.5 ? 5 : 20);
    h.region = u >= 0.5;
    return h;
}

static hit wall_and_sky(const pose *p, double u, double v, uint32_t frame)
{
    (void)frame;
    hit h = wall(p, u, v, 8);
    if (v < 0.3) h.depth = RIG_SKY;
    return h;
}

#ifdef RIG_SPECULAR
#define AMPLITUDE 0.3
#else
#define AMPLITUDE 0.5
#endif
/* A wall whose normals wave, every 7 pixels, by up to 0.5 radians. */
static hit bumpy_wall(const pose *p, double u, double v, uint32_t frame)
{
    hit h = flat_wall(p, u, v, frame);
    double world[3], slope[2], length;
    pose_point(p, u, v, h.depth, world);
    for (int k = 0; k < 2; k++) slope[k] = AMPLITUDE * sin(5.2 * world[k] + k);
    length = sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
    h.normal[0] = slope[0] / length, h.normal[1] = slope[1] / length, h.normal[2] = -1 / length;
    return h;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Light  >>light */
/* Towards a point in the tangent frame of a normal. */
static void from_tangents(const double n[3], const double local[3], double out[3])
{
    double side[3] = { n[2], 0, -n[0] }, length = sqrt(n[0] * n[0] + n[2] * n[2]);
    for (int k = 0; k < 3; k++) side[k] /= length;
    double up[3] = { n[1] * side[2] - n[2] * side[1], n[2] * side[0] - n[0] * side[2], n[0] * side[1] - n[1] * side[0] };
    for (int k = 0; k < 3; k++) out[k] = local[0] * side[k] + local[1] * up[k] + local[2] * n[k];
}

/* One path: diffuse by cosine; specular by the normals of GGX (B. Walter et al., "Microfacet Models for Refraction through Rough Surfaces",
   EGSR 2007, equation 35), seen from the front. */
static void sample_lobe(const double n[3], double a, double b, double out[3])
{
#ifdef RIG_SPECULAR
    const double width = pow(ROUGHNESS, 4), squared = (1 - a) / (1 + (width - 1) * a);
#else
    const double squared = 1 - a;
#endif
    const double local[3] = { sqrt(1 - squared) * cos(2 * acos(-1) * b), sqrt(1 - squared) * sin(2 * acos(-1) * b), sqrt(squared) };
    from_tangents(n, local, out);
#ifdef RIG_SPECULAR
    double cosine = -out[2], half[3] = { out[0], out[1], out[2] };
    for (int k = 0; k < 3; k++) out[k] = 2 * cosine * half[k] - (k == 2 ? -1 : 0);
#endif
}

/* Some light from everywhere in front of the wall, more from the upper left. */
static double light_from(const double d[3])
{
    static const double lamp[3] = { -0.64, 0.48, -0.6 };
    double cosine = d[0] * lamp[0] + d[1] * lamp[1] + d[2] * lamp[2];
    return d[2] > 0 ? 0 : 0.3 + 3 * fmax(cosine - 0.4, 0);
}

static void put_sample(rig *r, uint32_t i, double luma, const double d[3])
{
    const float rgb[3] = { (float)luma, (float)luma, (float)luma }, towards[3] = { (float)d[0], (float)d[1], (float)d[2] };
    pack_sh(rgb, 0.5f, towards, &r->noisy[4 * i], &directions[4 * i]);
}

static void put_light(rig *r)
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        double d[3];
        sample_lobe(r->hits[i].normal, random_at(i, r->index, 1), random_at(i, r->index, 2), d);
        put_sample(r, i, light_from(d), d);
    }
}

static double converged_light(const double n[3])
{
    double sum = 0, d[3];
    for (uint32_t i = 0; i < 1024; i++) {
        sample_lobe(n, (i / 32 + 0.5) / 32, (i % 32 + 0.5) / 32, d);
        sum += light_from(d) / 1024;
    }
    return sum;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Frames  >>frames */
static void run_frame(rig *r)
{
    assert_true(gpu_upload(r->device, &r->images[SECOND_IN], directions));
    rig_run(r, true);
    rig_download(r);
    assert_true(gpu_download(r->device, &r->images[SECOND_OUT], moments));
}

static double moment_of(uint32_t i, int k) { return half_to_float(moments[4 * i + (uint32_t)k]); }
static double luma_of(const rig *r, uint32_t i) { return half_to_float(r->out[4 * i]); }

static void assert_below(double value, double limit, const char *what)
{
    if (!(value <= limit)) fail_msg("%s: %g, allowed %g", what, value, limit);
}

/* Directions are finite and never longer than luma, gains are within their range. */
static void assert_sound(const rig *r)
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        if (r->hits[i].depth >= RIG_RANGE) continue;
        double x = moment_of(i, 0), y = moment_of(i, 1), z = moment_of(i, 2);
        assert_true(isfinite(luma_of(r, i)));
        assert_below(sqrt(x * x + y * y + z * z), 1.01 * luma_of(r, i) + 1e-6, "length of the mean direction");
        assert_true(moment_of(i, 3) >= 0.25 && moment_of(i, 3) <= 4);
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Tests  >>tests */
static void a_constant_picture_keeps_its_direction(void **state)
{
    static const double d[3] = { 0.48, -0.6, -0.64 };
    rig r;
    (void)state;
    rig_open(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, flat_wall);
    rig_put_guides(&r);
    for (uint32_t i = 0; i < PIXELS; i++) put_sample(&r, i, 0.75, d);
    for (uint32_t frame = 0; frame < 60; frame++) {
        run_frame(&r);
        for (uint32_t i = 0; i < PIXELS; i++) {
            for (int k = 0; k < 3; k++) assert_below(fabs(moment_of(i, k) - 0.75 * d[k]), 0.75 / 127, "error of the direction");
            assert_below(fabs(moment_of(i, 3) - 1), 1e-3, "gain on a flat wall");
        }
    }
    rig_close(&r);
}

/* On the CPU to the bit; GPUs' compilers fuse multiplications and additions as they like: one step of a half, in one number of a thousand. */
static void assert_same_halves(const uint16_t *a, const uint16_t *b, uint32_t count)
{
    uint32_t differ = 0;
    for (uint32_t i = 0; i < count; i++) {
        differ += a[i] != b[i];
        assert_true(abs((int)a[i] - (int)b[i]) <= 1);
    }
    assert_true(differ <= (device.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU ? 0 : count / 1000));
}

static void the_colour_is_that_of_the_plain_denoiser(void **state)
{
    rig r, plain;
    static uint16_t out[4 * PIXELS];
    (void)state;
    rig_open(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, bumpy_wall);
    rig_open(&plain, &device, PLAIN, WIDTH, HEIGHT, bumpy_wall);
    for (uint32_t frame = 0; frame < 12; frame++) {
        r.camera.position[0] = plain.camera.position[0] = 0.05 * frame;
        rig_put_guides(&r);
        rig_put_guides(&plain);
        put_light(&r);
        assert_true(gpu_upload(&device, &plain.images[PLAIN_IN], r.noisy));
        run_frame(&r);
        rig_run(&plain, true);
        assert_true(gpu_download(&device, &plain.images[PLAIN_OUT], out));
        assert_same_halves(out, r.out, sizeof out / sizeof *out);
    }
    rig_close(&r);
    rig_close(&plain);
}

/* Root mean square errors over the inner pixels. */
typedef struct errors { double plain, resolved, bias; } errors; /* bias: of luma under own normals against luma */

static errors measure(const rig *r)
{
    errors e = { 0, 0, 0 };
    double plain_sum = 0, resolved_sum = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        if (i % WIDTH < 8 || i % WIDTH >= WIDTH - 8 || i / WIDTH < 8 || i / WIDTH >= HEIGHT - 8) continue;
        double truth = converged_light(r->hits[i].normal), plain = luma_of(r, i), resolved = plain * moment_of(i, 3);
        e.plain += (plain - truth) * (plain - truth);
        e.resolved += (resolved - truth) * (resolved - truth);
        plain_sum += plain;
        resolved_sum += resolved;
        count++;
    }
    e.plain = sqrt(e.plain / count), e.resolved = sqrt(e.resolved / count), e.bias = resolved_sum / plain_sum - 1;
    return e;
}

static void assert_detail(double speed, double ratio, double bias)
{
    enum { FRAMES = 40, FROM = 24 };
    errors sum = { 0, 0, 0 };
    rig r;
    rig_open(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, bumpy_wall);
    r.roughness = ROUGHNESS;
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        r.camera.position[0] = speed * frame;
        rig_put_guides(&r);
        put_light(&r);
        run_frame(&r);
        assert_sound(&r);
        if (frame < FROM) continue;
        errors e = measure(&r);
        sum.plain += e.plain / (FRAMES - FROM), sum.resolved += e.resolved / (FRAMES - FROM), sum.bias += e.bias / (FRAMES - FROM);
    }
    rig_close(&r);
    print_message("speed %g: error %.4f plain, %.4f under own normals, bias %+.4f\n", speed, sum.plain, sum.resolved, sum.bias);
    assert_below(sum.resolved, ratio * sum.plain, "error under own normals");
    assert_below(fabs(sum.bias), bias, "bias");
}

static void own_normals_bring_back_detail(void **state)
{
    (void)state;
#ifdef RIG_SPECULAR
    assert_detail(0, 1, 0.04);
    assert_detail(0.07, 1, 0.04);
    assert_detail(0.15, 1, 0.04);
#else
    assert_detail(0, 1, 0.02);
    assert_detail(0.07, 1, 0.02);
    assert_detail(0.15, 1, 0.02);
#endif
}

static void directions_do_not_leak_across_an_edge(void **state)
{
    static const double d[2][3] = { { 0.6, 0, -0.8 }, { -0.6, 0, -0.8 } };
    rig r;
    (void)state;
    rig_open(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, two_walls);
    rig_put_guides(&r);
    for (uint32_t i = 0; i < PIXELS; i++) put_sample(&r, i, 1, d[r.hits[i].region]);
    for (uint32_t frame = 0; frame < 10; frame++) {
        run_frame(&r);
        for (uint32_t i = 0; i < PIXELS; i++) assert_below(fabs(moment_of(i, 0) - d[r.hits[i].region][0]), 1.0 / 127, "leak");
    }
    rig_close(&r);
}

static void two_runs_are_identical_to_the_bit(void **state)
{
    static uint16_t first[4 * PIXELS], color[4 * PIXELS];
    (void)state;
    for (int run = 0; run < 2; run++) {
        rig r;
        rig_open(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, bumpy_wall);
        for (uint32_t frame = 0; frame < 8; frame++) {
            r.camera.position[0] = 0.03 * frame, r.camera.yaw = 0.01 * frame;
            rig_put_guides(&r);
            put_light(&r);
            run_frame(&r);
        }
        if (run) assert_memory_equal(first, moments, sizeof first), assert_memory_equal(color, r.out, sizeof color);
        memcpy(first, moments, sizeof first);
        memcpy(color, r.out, sizeof color);
        rig_close(&r);
    }
}

/* NaN and infinity in any channel of the second texel, and whatever the sky holds; w is not read. */
static void bad_directions_leave_no_trace(void **state)
{
    static const float values[] = { NAN, INFINITY, -INFINITY };
    static uint16_t good[4 * PIXELS];
    for (int spoilt = 0; spoilt < 2; spoilt++) {
        rig r;
        (void)state;
        rig_open(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, wall_and_sky);
        for (uint32_t frame = 0; frame < 8; frame++) {
            rig_put_guides(&r);
            put_light(&r);
            for (uint32_t i = 0; i < PIXELS; i++) {
                bool sky = r.hits[i].depth >= RIG_RANGE, bad = random_at(i, frame, 3) < 0.1;
                if (bad) memset(&directions[4 * i], 0, 6);
                for (uint32_t k = 0; k < 4 && spoilt; k++)
                    if (sky || k == 3 || (bad && i % 3 == k)) directions[4 * i + k] = half_from_float(values[(i + frame) % 3]);
            }
            run_frame(&r);
            assert_sound(&r);
        }
        for (uint32_t i = 0; i < PIXELS && spoilt; i++)
            if (r.hits[i].depth < RIG_RANGE) assert_memory_equal(&good[4 * i], &moments[4 * i], 8);
        memcpy(good, moments, sizeof good);
        rig_close(&r);
    }
}

static void extreme_light_stays_sound(void **state)
{
    static const double lumas[] = { 65000, 1e-7, 0, 1 };
    rig r;
    (void)state;
    rig_open(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, bumpy_wall);
    rig_put_guides(&r);
    for (uint32_t frame = 0; frame < 30; frame++) {
        for (uint32_t i = 0; i < PIXELS; i++) {
            double d[3];
            sample_lobe(r.hits[i].normal, random_at(i, frame, 1), random_at(i, frame, 2), d);
            put_sample(&r, i, lumas[(uint32_t)(random_at(i, frame, 5) * 4)], d);
        }
        run_frame(&r);
        assert_sound(&r);
    }
    rig_close(&r);
}

/* With the pre-pass, and without any filter. */
static void the_mean_is_kept_with_every_pass(void **state)
{
    (void)state;
    for (int way = 0; way < 2; way++) {
        rig r;
        rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, bumpy_wall, NRD_FEATURE_PREPASS);
        if (way) r.settings.max_blur_radius = 0;
        else r.settings.diffuse_prepass_blur_radius = r.settings.specular_prepass_blur_radius = 12;
        r.roughness = ROUGHNESS;
        rig_put_guides(&r);
        for (uint32_t frame = 0; frame < 40; frame++) {
            put_light(&r);
            run_frame(&r);
            assert_sound(&r);
        }
        errors e = measure(&r);
        print_message("%s: error %.4f plain, %.4f under own normals, bias %+.4f\n", way ? "no filter" : "pre-pass", e.plain, e.resolved, e.bias);
        assert_below(fabs(e.bias), 0.03, "bias");
        assert_below(e.resolved, 1.02 * e.plain, "error under own normals");
        rig_close(&r);
    }
}

#ifdef RIG_SPECULAR
#define RIG_CHECKERBOARD(r) (r)->settings.specular_checkerboard
#else
#define RIG_CHECKERBOARD(r) (r)->settings.diffuse_checkerboard
#endif

/* What must not be read everywhere; then the traced pixels of each wall's own light, packed to the left. */
static void put_checkerboard(rig *r, const double d[2][3])
{
    static const double wrong[3] = { 0, 0.8, -0.6 };
    for (uint32_t i = 0; i < PIXELS; i++) put_sample(r, i, 60000, wrong);
    for (uint32_t i = 0; i < PIXELS; i++) {
        uint32_t x = i % WIDTH, y = i / WIDTH, region = r->hits[i].region;
        if (((x ^ y ^ r->index) & 1) == 0) put_sample(r, y * WIDTH + x / 2, region ? 2 : 0.5, d[region]);
    }
}

static void a_checkerboard_gives_the_directions_that_all_pixels_give(void **state)
{
    static const double d[2][3] = { { 0.6, 0, -0.8 }, { -0.6, 0, -0.8 } };
    (void)state;
    for (int prepass = 0; prepass < 2; prepass++) {
        rig r;
        rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, two_walls, NRD_FEATURE_CHECKERBOARD | NRD_FEATURE_PREPASS);
        RIG_CHECKERBOARD(&r) = 1;
        r.settings.diffuse_prepass_blur_radius = r.settings.specular_prepass_blur_radius = prepass ? 8 : 0;
        rig_put_guides(&r);
        for (uint32_t frame = 0; frame < 6; frame++) {
            put_checkerboard(&r, d);
            run_frame(&r);
            for (uint32_t i = 0; i < PIXELS; i++) {
                double luma = r.hits[i].region ? 2 : 0.5;
                assert_below(fabs(luma_of(&r, i) - luma), 2e-3 * luma, "error of the luma");
                for (int k = 0; k < 3; k++) assert_below(fabs(moment_of(i, k) - luma * d[r.hits[i].region][k]), luma / 100, "error of the direction");
            }
        }
        rig_close(&r);
    }
}

static void the_split_shows_both_noisy_texels(void **state)
{
    rig r;
    (void)state;
    rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, flat_wall, NRD_FEATURE_SPLIT_SCREEN);
    r.frame.split_screen = 0.5f;
    rig_put_guides(&r);
    put_light(&r);
    run_frame(&r);
    for (uint32_t i = 0; i < PIXELS; i++) {
        if (i % WIDTH >= WIDTH / 2) continue;
        assert_memory_equal(&r.out[4 * i], &r.noisy[4 * i], 8);
        assert_memory_equal(&moments[4 * i], &directions[4 * i], 8);
    }
    rig_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_constant_picture_keeps_its_direction),
        cmocka_unit_test(the_colour_is_that_of_the_plain_denoiser),
        cmocka_unit_test(own_normals_bring_back_detail),
        cmocka_unit_test(directions_do_not_leak_across_an_edge),
        cmocka_unit_test(two_runs_are_identical_to_the_bit),
        cmocka_unit_test(bad_directions_leave_no_trace),
        cmocka_unit_test(extreme_light_stays_sound),
        cmocka_unit_test(the_mean_is_kept_with_every_pass),
        cmocka_unit_test(a_checkerboard_gives_the_directions_that_all_pixels_give),
        cmocka_unit_test(the_split_shows_both_noisy_texels),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
