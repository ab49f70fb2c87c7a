/* The validation overlay: each of its pictures shows what it says, by numbers at probed pixels, for every denoiser that has one. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#define RIG_SPECULAR
#include "denoise_rig.h"

enum { WIDTH = 128, HEIGHT = 96, CELL_WIDTH = WIDTH / 4, CELL_HEIGHT = HEIGHT / 4, PIXELS = WIDTH * HEIGHT };
enum { NORMALS, ROUGHNESS, VIEW_Z, MOTION_ERROR, GRID, VIRTUAL_MOTION, FIRST_HISTORY, SECOND_HISTORY, FIRST_HITS, SECOND_HITS, FIRST_SIGNAL, SECOND_SIGNAL,
       MOTION, MATERIAL, RULES, JITTER };

/* ---------------------------------------------------------------------------------------------------------------------------
   Probing  >>probe */
typedef struct color { double r, g, b; } color;

/* A room's corner with sky above. */
static hit corner(const pose *p, double u, double v, uint32_t frame)
{
    static const double points[3][3] = { { 0, -1, 0 }, { 0, 0, 5 }, { 2, 0, 0 } }, normals[3][3] = { { 0, 1, 0 }, { 0, 0, -1 }, { -1, 0, 0 } };
    hit nearest = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 9 };
    double world[3];
    (void)frame;
    for (uint32_t i = 0; i < 3; i++) {
        double depth;
        if (!rig_ray_plane(p, u, v, points[i], normals[i], &depth) || depth >= nearest.depth) continue;
        nearest.depth = depth;
        memcpy(nearest.normal, normals[i], sizeof nearest.normal);
        nearest.material = nearest.region = i;
    }
    pose_point(p, u, v, nearest.depth, world);
    if (world[1] > 1.2) nearest.depth = RIG_SKY;
    return nearest;
}

typedef struct overlay { unsigned char texels[PIXELS][4]; } overlay;

static void read_overlay(rig *r, overlay *o) { assert_true(gpu_download(&device, &r->images[NRD_RESOURCE_OUT_VALIDATION], o->texels)); }

/* The pixel of a picture that shows pixel x, y of the inputs; both must be 2 modulo 4. */
static color probe(const overlay *o, int picture, uint32_t x, uint32_t y)
{
    const unsigned char *t = o->texels[(size_t)(picture / 4 * CELL_HEIGHT + y / 4) * WIDTH + (size_t)(picture % 4 * CELL_WIDTH) + x / 4];
    color c = { t[0] / 255.0, t[1] / 255.0, t[2] / 255.0 };
    return c;
}

static void assert_shows(const overlay *o, int picture, uint32_t x, uint32_t y, double r, double g, double b, double tolerance)
{
    color c = probe(o, picture, x, y);
    if (fabs(c.r - r) > tolerance || fabs(c.g - g) > tolerance || fabs(c.b - b) > tolerance)
        fail_msg("picture %d at %u %u: %.3f %.3f %.3f instead of %.3f %.3f %.3f", picture, x, y, c.r, c.g, c.b, r, g, b);
}

static void assert_grey(const overlay *o, int picture, uint32_t x, uint32_t y, double v, double tolerance) { assert_shows(o, picture, x, y, v, v, v, tolerance); }

static const hit *hit_at(const rig *r, uint32_t x, uint32_t y) { return &r->hits[(size_t)y * WIDTH + x]; }

/* Calls it for a grid of pixels; those of the sky must be blue in every picture but that of the jitter. */
typedef void probe_pixel(rig *r, const overlay *o, uint32_t x, uint32_t y);
static void probe_everywhere(rig *r, const overlay *o, probe_pixel *check)
{
    uint32_t surfaces = 0, skies = 0;
    for (uint32_t y = 2; y < HEIGHT; y += 8)
        for (uint32_t x = 2; x < WIDTH; x += 8) {
            bool sky = hit_at(r, x, y)->depth >= RIG_RANGE;
            *(sky ? &skies : &surfaces) += 1;
            for (int picture = 0; sky && picture < JITTER; picture++) assert_shows(o, picture, x, y, 0.1, 0.2, 0.5, 0.01);
            if (!sky) check(r, o, x, y);
        }
    assert_true(surfaces > 50 && skies > 5);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Inputs  >>inputs */
static void upload_all(rig *r, nrd_resource resource, const float rgba[4])
{
    gpu_image *image = &r->images[resource];
    uint16_t half[4];
    unsigned char byte[4];
    if (!image->view) return;
    size_t bytes = gpu_format_size(image->format);
    unsigned char *texels = (unsigned char *)rig_array(r, bytes);
    half_from_floats(half, rgba, 4);
    for (int k = 0; k < 4; k++) byte[k] = (unsigned char)(rgba[k] * 255 + 0.5f);
    for (size_t i = 0; i < PIXELS; i++) memcpy(texels + i * bytes, bytes == 4 ? (const void *)byte : (const void *)half, bytes);
    assert_true(gpu_upload(r->device, image, texels));
    free(texels);
}

static void open_rig(rig *r, nrd_denoiser denoiser)
{
    static const float radiance[4] = { 1, 0.5f, -0.25f, 0.5f }, specular[4] = { 0.25f, 0, 0, 0.25f }, hits[4] = { 0.5f, 0, 0, 0 }, mirrored[4] = { 0.25f, 0, 0, 0 };
    static const float direction[4] = { 0, 0.5f, 0, 0.5f }, penumbra[4] = { 0.05f, 0, 0, 0 }, glass[4] = { 0.2f, 0.4f, 0.6f, 0 };
    rig_open_with(r, &device, denoiser, WIDTH, HEIGHT, corner, NRD_FEATURE_VALIDATION);
    r->camera.jitter[0] = 0.25;
    r->camera.jitter[1] = -0.25;
    r->frame.validation = 1;
    upload_all(r, NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, radiance);
    upload_all(r, NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, specular);
    upload_all(r, NRD_RESOURCE_IN_DIFF_HITDIST, hits);
    upload_all(r, NRD_RESOURCE_IN_SPEC_HITDIST, mirrored);
    upload_all(r, NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, direction);
    upload_all(r, NRD_RESOURCE_IN_PENUMBRA, penumbra);
    upload_all(r, NRD_RESOURCE_IN_TRANSLUCENCY, glass);
}

static void put_specular(rig *r)
{
    texel t = { 0.25f, 0, 0, 0.25f };
    for (uint32_t i = 0; i < PIXELS; i++) rig_put_noisy(r, i % WIDTH, i / WIDTH, t);
}

static void run_frames(rig *r, uint32_t frames, double step)
{
    for (uint32_t i = 0; i < frames; i++) {
        rig_put_guides(r);
        put_specular(r);
        rig_run(r, true);
        r->camera.position[0] += step;
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Pictures  >>pictures */
static void world_of(const rig *r, uint32_t x, uint32_t y, double world[3])
{
    pose_point(&r->camera, (x + 0.5) / WIDTH, (y + 0.5) / HEIGHT, hit_at(r, x, y)->depth, world);
}

static void check_grid(rig *r, const overlay *o, uint32_t x, uint32_t y)
{
    double world[3];
    int parity = 0;
    world_of(r, x, y, world);
    for (int k = 0; k < 3; k++) {
        double inside = world[k] - 0.01 * hit_at(r, x, y)->normal[k];
        if (inside - floor(inside) < 0.005 || inside - floor(inside) > 0.995) return;
        parity += (int)floor(inside);
    }
    double bright = 0.15 + 0.5 * (parity & 1);
    const double *n = hit_at(r, x, y)->normal;
    assert_shows(o, GRID, x, y, bright + 0.3 * fabs(n[0]), bright + 0.3 * fabs(n[1]), bright + 0.3 * fabs(n[2]), 0.02);
}

static void check_guides(rig *r, const overlay *o, uint32_t x, uint32_t y)
{
    static const double materials[3][3] = { { 0.2, 0.2, 0.2 }, { 0.9, 0.5, 0.1 }, { 0.1, 0.6, 0.9 } };
    const hit *h = hit_at(r, x, y);
    const float *mv = &r->mv[4 * ((size_t)y * WIDTH + x)];
    assert_shows(o, NORMALS, x, y, h->normal[0] * 0.5 + 0.5, h->normal[1] * 0.5 + 0.5, h->normal[2] * 0.5 + 0.5, 0.01);
    assert_grey(o, ROUGHNESS, x, y, 1, 0.01);
    assert_grey(o, VIEW_Z, x, y, h->depth / (h->depth + 10), 0.01);
    assert_grey(o, MOTION_ERROR, x, y, 0, 0.01);
    assert_shows(o, MOTION, x, y, 0.5 + mv[0] * WIDTH / 64, 0.5 + mv[1] * HEIGHT / 64, 0.5, 0.01);
    assert_shows(o, MATERIAL, x, y, materials[h->material][0], materials[h->material][1], materials[h->material][2], 0.01);
    assert_grey(o, RULES, x, y, 0.15, 0.01);
    check_grid(r, o, x, y);
}

static void guides_are_shown_by_every_denoiser(void **state)
{
    static overlay o;
    (void)state;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        rig r;
        if (d == NRD_DENOISER_REFERENCE) continue;
        open_rig(&r, (nrd_denoiser)d);
        r.camera.position[1] = 0.1;
        run_frames(&r, 2, 0.25);
        r.camera.position[0] -= 0.25;   /* of the last frame */
        read_overlay(&r, &o);
        probe_everywhere(&r, &o, check_guides);
        rig_close(&r);
    }
}

static void the_ray_s_place_in_its_pixel_is_shown(void **state)
{
    static overlay o;
    rig r;
    (void)state;
    open_rig(&r, NRD_DENOISER_REBLUR_DIFFUSE);
    run_frames(&r, 1, 0);
    read_overlay(&r, &o);
    assert_shows(&o, JITTER, WIDTH * 3 / 4 + 2, HEIGHT / 4 + 2, 1, 0.8, 0, 0.01);
    assert_shows(&o, JITTER, WIDTH / 4 + 2, HEIGHT * 3 / 4 + 2, 0.1, 0.1, 0.1, 0.01);
    rig_close(&r);
}

static void check_error(rig *r, const overlay *o, uint32_t x, uint32_t y)
{
    (void)r;
    if (x < WIDTH / 2) assert_grey(o, MOTION_ERROR, x, y, 0.5, 0.02);
    else assert_shows(o, MOTION_ERROR, x, y, 1, 0, 0, 0.01);
    assert_shows(o, RULES, x, y, y == 66 ? 1 : 0.15, y == 66 ? 0 : 0.15, y == 66 ? 0 : 0.15, 0.01);
}

/* 2 px of 4 on the left, 5 on the right; NaN in one row of the signal. */
static void wrong_motion_and_bad_numbers_stand_out(void **state)
{
    static overlay o;
    rig r;
    (void)state;
    open_rig(&r, NRD_DENOISER_REBLUR_SPECULAR);
    run_frames(&r, 1, 0);
    rig_put_guides(&r);
    for (uint32_t i = 0; i < PIXELS; i++) r.mv[4 * i] += (i % WIDTH < WIDTH / 2 ? 2.0f : 5.0f) / WIDTH;
    texel nan = { NAN, 0, 0, 0.5f };
    for (uint32_t x = 0; x < WIDTH; x++) rig_put_noisy(&r, x, 66, nan);
    rig_run(&r, true);
    read_overlay(&r, &o);
    probe_everywhere(&r, &o, check_error);
    rig_close(&r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Signals  >>signals */
static void check_both_signals(rig *r, const overlay *o, uint32_t x, uint32_t y)
{
    double rgb[3] = { 1.25 + 0.5, 0.75, 1.25 - 0.5 };   /* of Y 1, Co 0.5, Cg -0.25 */
    (void)r;
    assert_grey(o, FIRST_HITS, x, y, 0.5, 0.01);
    assert_grey(o, SECOND_HITS, x, y, 0.25, 0.01);
    assert_shows(o, FIRST_SIGNAL, x, y, pow(rgb[0] / 2, 1 / 2.2), pow(rgb[1] / 2, 1 / 2.2), pow(rgb[2] / 2, 1 / 2.2), 0.02);
    assert_grey(o, SECOND_SIGNAL, x, y, pow(0.25 / 1.25, 1 / 2.2), 0.02);
}

static void check_both_occlusions(rig *r, const overlay *o, uint32_t x, uint32_t y)
{
    (void)r;
    assert_grey(o, FIRST_HITS, x, y, 0.5, 0.01);
    assert_grey(o, SECOND_HITS, x, y, 0.25, 0.01);
    assert_grey(o, FIRST_SIGNAL, x, y, 0.5, 0.01);
}

static void check_directions(rig *r, const overlay *o, uint32_t x, uint32_t y)
{
    (void)r;
    assert_grey(o, FIRST_HITS, x, y, 0.5, 0.01);
    assert_shows(o, FIRST_SIGNAL, x, y, 0.5, 1, 0.5, 0.01);
}

static void check_shadows(rig *r, const overlay *o, uint32_t x, uint32_t y)
{
    double pixel = hit_at(r, x, y)->depth * 2 * r->camera.tan_half_height / HEIGHT;
    assert_grey(o, FIRST_HITS, x, y, fmin(0.05 / pixel / 32, 1), 0.02);
    assert_grey(o, FIRST_SIGNAL, x, y, 0, 0.01);
    assert_shows(o, SECOND_SIGNAL, x, y, 0.2, 0.4, 0.6, 0.01);
}

static void signals_are_shown(void **state)
{
    static const struct { nrd_denoiser denoiser; probe_pixel *check; } rows[] = {
        { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, check_both_signals }, { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, check_both_occlusions },
        { NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, check_directions }, { NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY, check_shadows },
    };
    static overlay o;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        rig r;
        open_rig(&r, rows[i].denoiser);
        run_frames(&r, 1, 0);
        read_overlay(&r, &o);
        probe_everywhere(&r, &o, rows[i].check);
        rig_close(&r);
    }
}

/* Right half lit, left half blocked by something that touches. */
static void classes_of_tiles_are_shown(void **state)
{
    static overlay o;
    static uint16_t penumbra[PIXELS];
    rig r;
    (void)state;
    open_rig(&r, NRD_DENOISER_SIGMA_SHADOW);
    for (uint32_t i = 0; i < PIXELS; i++) penumbra[i] = half_from_float(i % WIDTH < WIDTH / 2 ? 0.001f : 65504.0f);
    assert_true(gpu_upload(&device, &r.images[NRD_RESOURCE_IN_PENUMBRA], penumbra));
    run_frames(&r, 2, 0);
    read_overlay(&r, &o);
    assert_shows(&o, FIRST_HITS, WIDTH - 6, HEIGHT - 6, 1, 1, 0.6, 0.01);
    assert_shows(&o, SECOND_HITS, WIDTH - 6, HEIGHT - 6, 0, 0, 1, 0.01);
    assert_shows(&o, SECOND_HITS, 6, HEIGHT - 6, 0, 0, 0, 0.01);
    rig_close(&r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Reflections and histories  >>history */
static void check_virtual_motion(rig *r, const overlay *o, uint32_t x, uint32_t y)
{
    double eye[3], world[3], behind[3], length = 0, moved[2][3], hit_dist = 0.25 * (3 + 0.1 * hit_at(r, x, y)->depth);
    pose_point(&r->camera, (x + 0.5) / WIDTH, (y + 0.5) / HEIGHT, 0, eye);
    world_of(r, x, y, world);
    for (int k = 0; k < 3; k++) length += (world[k] - eye[k]) * (world[k] - eye[k]);
    for (int k = 0; k < 3; k++) behind[k] = world[k] + (world[k] - eye[k]) * hit_dist / sqrt(length);
    pose_project(&r->camera_prev, world, &moved[0][0], &moved[0][1], &moved[0][2]);
    pose_project(&r->camera_prev, behind, &moved[1][0], &moved[1][1], &moved[1][2]);
    double px = hypot((moved[1][0] - moved[0][0]) * WIDTH, (moved[1][1] - moved[0][1]) * HEIGHT);
    assert_grey(o, VIRTUAL_MOTION, x, y, fmin(px / 16, 1), 0.02);
}

static void reflections_depart_from_their_surface_by_what_is_shown(void **state)
{
    static const nrd_denoiser denoisers[] = { NRD_DENOISER_REBLUR_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_DENOISER_REBLUR_SPECULAR_OCCLUSION };
    static overlay o;
    (void)state;
    for (size_t i = 0; i < sizeof denoisers / sizeof denoisers[0]; i++) {
        rig r;
        open_rig(&r, denoisers[i]);
        run_frames(&r, 1, 0.5);
        pose prev = r.camera_prev;
        run_frames(&r, 1, 0);
        r.camera_prev = prev;
        read_overlay(&r, &o);
        probe_everywhere(&r, &o, check_virtual_motion);
        rig_close(&r);
    }
}

/* What the denoisers write when asked for the length of their histories. */
static double asked_frames(const rig *r, const uint16_t *out, uint32_t channels, uint32_t x, uint32_t y)
{
    (void)r;
    return half_to_float(out[((size_t)y * WIDTH + x) * channels + channels - 1]);
}

static void ask_for_history(rig *r, nrd_denoiser denoiser)
{
    any_settings settings;
    nrd_settings_defaults(denoiser, &settings);
    assert_true(put_setting_by_name(denoiser, &settings, "return_history_length_instead_of_occlusion", 1));
    assert_true(put_setting_by_name(denoiser, &settings, "max_accumulated_frames", 16));
    assert_int_equal(nrd_set_settings(r->instance, RIG_IDENTIFIER, &settings), NRD_RESULT_OK);
    r->settings.return_history_length_instead_of_occlusion = 1;
    r->settings.max_accumulated_frames = 16;
}

static void assert_history_is_shown(rig *r, const overlay *o, int picture, nrd_resource out)
{
    static uint16_t texels[PIXELS * 4];
    bool longer = false, shorter = false;
    assert_true(gpu_download(&device, &r->images[out], texels));
    for (uint32_t y = 2; y < HEIGHT; y += 4)
        for (uint32_t x = 2; x < WIDTH; x += 4) {
            if (hit_at(r, x, y)->depth >= RIG_RANGE) continue;
            double frames = fmin(asked_frames(r, texels, gpu_format_size(r->images[out].format) / 2, x, y) / 16, 1);
            longer |= frames > 0.4;
            shorter |= frames < 0.1;
            assert_shows(o, picture, x, y, 1 - frames, frames, 0, 0.08);   /* rounded at random to whole frames */
        }
    if (!longer || !shorter) fail_msg("picture %d: the test sees no short or no long histories", picture);
}

static void lengths_of_histories_are_those_that_the_denoisers_tell(void **state)
{
    static const struct { nrd_denoiser denoiser; nrd_resource first, second; } rows[] = {
        { NRD_DENOISER_REBLUR_DIFFUSE, NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST, NRD_RESOURCE_COUNT },
        { NRD_DENOISER_REBLUR_SPECULAR, NRD_RESOURCE_OUT_SPEC_RADIANCE_HITDIST, NRD_RESOURCE_COUNT },
        { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST, NRD_RESOURCE_OUT_SPEC_RADIANCE_HITDIST },
        { NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, NRD_RESOURCE_OUT_DIFF_HITDIST, NRD_RESOURCE_COUNT },
        { NRD_DENOISER_REBLUR_SPECULAR_OCCLUSION, NRD_RESOURCE_OUT_SPEC_HITDIST, NRD_RESOURCE_COUNT },
        { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, NRD_RESOURCE_OUT_DIFF_HITDIST, NRD_RESOURCE_OUT_SPEC_HITDIST },
        { NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, NRD_RESOURCE_OUT_DIFF_DIRECTION_HITDIST, NRD_RESOURCE_COUNT },
    };
    static overlay o;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        rig r;
        open_rig(&r, rows[i].denoiser);
        ask_for_history(&r, rows[i].denoiser);
        r.frame.camera.jitter[0] = 0;
        run_frames(&r, 8, 0.06);
        read_overlay(&r, &o);
        assert_history_is_shown(&r, &o, FIRST_HISTORY, rows[i].first);
        if (rows[i].second != NRD_RESOURCE_COUNT) assert_history_is_shown(&r, &o, SECOND_HISTORY, rows[i].second);
        rig_close(&r);
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Choosing  >>choosing */
static uint32_t validation_passes(nrd *instance, uint32_t index, uint32_t which, uint32_t *denoiser)
{
    const nrd_dispatch *dispatches;
    uint32_t count, found = 0;
    nrd_frame frame = still_frame(index);
    frame.validation = which;
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
    assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &dispatches, &count), NRD_RESULT_OK);
    for (uint32_t d = 0; d < count; d++) {
        if (strcmp(dispatches[d].name, "validation")) continue;
        found++;
        *denoiser = nrd_get_info(instance)->passes[dispatches[d].pass].denoiser;
    }
    return found;
}

static void one_denoiser_is_shown_at_a_time(void **state)
{
    static const nrd_denoiser_desc two[2] = { { 1, NRD_DENOISER_REBLUR_DIFFUSE }, { 2, NRD_DENOISER_SIGMA_SHADOW } };
    spy s = { 0 };
    nrd *instance = NULL;
    uint32_t denoiser = 9;
    (void)state;
    nrd_desc desc = spied_desc(&s, two, 2, 64, 48, NRD_FEATURE_VALIDATION);
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    assert_int_equal(validation_passes(instance, 0, 0, &denoiser), 0);
    assert_int_equal(validation_passes(instance, 1, 1, &denoiser), 1);
    assert_int_equal(denoiser, 0);
    assert_int_equal(validation_passes(instance, 2, 2, &denoiser), 1);
    assert_int_equal(denoiser, 1);
    nrd_frame frame = still_frame(3);
    frame.validation = 3;
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_INVALID_ARGUMENT);
    assert_string_equal(s.text, "nrd_frame.validation is 3, allowed: 0 to 2");
    nrd_destroy(instance);
}

static void the_feature_must_be_declared(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0);
    nrd_frame frame = still_frame(0);
    frame.validation = 1;
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_INVALID_ARGUMENT);
    assert_string_equal(s.text, "nrd_frame.validation is set, but nrd_desc.features lacks NRD_FEATURE_VALIDATION");
    nrd_destroy(instance);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_denoiser_is_shown_at_a_time),
        cmocka_unit_test(the_feature_must_be_declared),
        cmocka_unit_test(guides_are_shown_by_every_denoiser),
        cmocka_unit_test(the_ray_s_place_in_its_pixel_is_shown),
        cmocka_unit_test(wrong_motion_and_bad_numbers_stand_out),
        cmocka_unit_test(signals_are_shown),
        cmocka_unit_test(classes_of_tiles_are_shown),
        cmocka_unit_test(reflections_depart_from_their_surface_by_what_is_shown),
        cmocka_unit_test(lengths_of_histories_are_those_that_the_denoisers_tell),
    };
    return cmocka_run_group_tests(tests, open_validated_device, close_device);
}
