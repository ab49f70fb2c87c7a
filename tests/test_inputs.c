/* What optional inputs and settings promise, on a device: built for the diffuse signal here, for the specular one and for both with directions (SH)
   beside. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "denoise_rig.h"

enum { WIDTH = 64, HEIGHT = 48 };

/* Faces the camera; region 1: the right half, twice as far. */
static hit two_walls(const pose *p, double u, double v, uint32_t frame)
{
    double normal[3] = { 0, 0, -1 }, point[3] = { 0, 0, u < 0.5 ? 8 : 16 };
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, u >= 0.5 };
    (void)v;
    (void)frame;
    rig_ray_plane(p, u, v, point, normal, &h.depth);
    return h;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Hit-distance reconstruction  >>reconstruction */
static const float region_hit_dist[2] = { 0.25f, 0.75f };

/* One pixel in `period` x `period` is sampled, another one every frame. */
static bool is_sampled(uint32_t x, uint32_t y, uint32_t frame, uint32_t period)
{
    return (x + frame) % period == 0 && (y + frame / period) % period == 0;
}

static void put_sampled(rig *r, uint32_t period)
{
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++) {
            bool sampled = is_sampled(x, y, r->index, period);
            uint32_t region = r->hits[(size_t)y * WIDTH + x].region;
            rig_put_noisy(r, x, y, (texel){ sampled ? (float)(period * period) : 0, 0, 0, sampled ? region_hit_dist[region] : 0 });
        }
}

/* The share of the pixels, two from the border on, whose output has the hit distance of their wall after `frames` frames. */
static double known_hit_distances(uint32_t reconstruction, uint32_t period, uint32_t frames)
{
    uint32_t known = 0, all = 0;
    rig r;
    rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, two_walls, NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION);
    r.settings.hit_distance_reconstruction = reconstruction;
    rig_put_guides(&r);
    for (uint32_t frame = 0; frame < frames; frame++) {
        put_sampled(&r, period);
        rig_run(&r, true);
    }
    rig_download(&r);
    for (uint32_t y = 2; y < HEIGHT - 2; y++)
        for (uint32_t x = 2; x < WIDTH - 2; x++, all++) known += fabs(rig_out(&r, x, y).hit_dist - region_hit_dist[r.hits[y * WIDTH + x].region]) < 0.04;
    rig_close(&r);
    return (double)known / all;
}

static void assert_share(double share, double least, double most, const char *what)
{
    if (!(share >= least && share <= most)) fail_msg("%s: %g, allowed %g to %g", what, share, least, most);
}

static void hit_distances_that_were_not_sampled_are_taken_from_the_surface_around(void **state)
{
    (void)state;
    assert_share(known_hit_distances(1, 2, 1), 1, 1, "one pixel of 2x2, 3x3");
    assert_share(known_hit_distances(2, 4, 1), 0.98, 1, "one pixel of 4x4, 5x5");   /* along the edge a column has none of its own wall within reach */
    double narrow = known_hit_distances(1, 8, 1);
    assert_share(known_hit_distances(2, 8, 1), narrow + 0.1, 0.9, "one pixel of 8x8, 5x5");
}

static void what_was_once_sampled_is_remembered_without_reconstruction(void **state)
{
    (void)state;
    assert_share(known_hit_distances(0, 2, 8), 0.98, 1, "one pixel of 2x2, off, after 8 frames");
}

/* Colour is not guessed: what was not traced counts as black, so that an estimate divided by its probability stays right. */
static void reconstruction_leaves_the_light_as_it_is(void **state)
{
    double mean = 0;
    rig r;
    (void)state;
    rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, two_walls, NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION);
    r.settings.hit_distance_reconstruction = 1;
    rig_put_guides(&r);
    for (uint32_t frame = 0; frame < 32; frame++) {
        put_sampled(&r, 2);
        rig_run(&r, true);
    }
    rig_download(&r);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) mean += rig_out(&r, i % WIDTH, i / WIDTH).y / (double)(WIDTH * HEIGHT);
    assert_share(mean, 0.98, 1.02, "mean of the light");
    rig_close(&r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Checkerboard  >>checkerboard */
#ifdef RIG_SPECULAR
#define RIG_CHECKERBOARD(r) (r)->settings.specular_checkerboard
#else
#define RIG_CHECKERBOARD(r) (r)->settings.diffuse_checkerboard
#endif

typedef texel emission(const rig *r, uint32_t x, uint32_t y);

static texel by_region(const rig *r, uint32_t x, uint32_t y)
{
    uint32_t region = r->hits[(size_t)y * r->rect_width + x].region;
    return (texel){ region ? 1.25f : 0.25f, 0, 0, region_hit_dist[region] };
}

static texel noise(const rig *r, uint32_t x, uint32_t y) { return (texel){ (float)(2 * random_at(x, y, r->index)), 0.1f, 0, 0.5f }; }

/* The traced pixels in the left half, what must not be read in the right one. */
static void put_checkerboard(rig *r, uint32_t mode, emission *of)
{
    for (uint32_t i = 0; i < r->width * r->height; i++) rig_put_noisy(r, i % r->width, i / r->width, (texel){ 60000, 0, 0, 1 });
    for (uint32_t y = 0; y < r->rect_height; y++)
        for (uint32_t x = 0; x < r->rect_width; x++)
            if (((x ^ y ^ r->index) & 1) == mode - 1) rig_put_noisy(r, x / 2, y, of(r, x, y));
}

/* One frame; restart: the first of a mode. */
static void run_checkerboard(rig *r, uint32_t mode, bool restart, emission *of)
{
    RIG_CHECKERBOARD(r) = mode;
    r->frame.restart = restart;
    rig_put_guides(r);
    put_checkerboard(r, mode, of);
    rig_run(r, true);
    rig_download(r);
}

static void assert_walls_keep_their_light(uint32_t features, uint32_t width)
{
    rig r;
    rig_open_with(&r, &device, RIG_DENOISER, width, HEIGHT, two_walls, NRD_FEATURE_CHECKERBOARD | features);
    if (features & NRD_FEATURE_PREPASS) r.settings.diffuse_prepass_blur_radius = r.settings.specular_prepass_blur_radius = 6;
    for (uint32_t mode = 1; mode <= 2; mode++)
        for (uint32_t frame = 0; frame < 4; frame++) {
            run_checkerboard(&r, mode, frame == 0, by_region);
            for (uint32_t i = 0; i < width * HEIGHT; i++) {
                uint32_t x = i % width, y = i / width;
                float is = rig_out(&r, x, y).y, should = by_region(&r, x, y).y;
                if (!(fabs(is - should) < 2e-3)) fail_msg("mode %u, frame %u, pixel %u %u: %g instead of %g", mode, frame, x, y, is, should);
            }
        }
    rig_close(&r);
}

/* Odd widths too: the last pair has one pixel. */
static void a_checkerboard_gives_the_picture_that_all_pixels_give(void **state)
{
    (void)state;
    assert_walls_keep_their_light(0, WIDTH + 1);
    assert_walls_keep_their_light(NRD_FEATURE_PREPASS, WIDTH);
}

static void both_colours_of_the_checkerboard_keep_the_mean(void **state)
{
    rig r;
    (void)state;
    rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, two_walls, NRD_FEATURE_CHECKERBOARD);
    for (uint32_t mode = 1; mode <= 2; mode++) {
        double mean = 0;
        for (uint32_t frame = 0; frame < 40; frame++) run_checkerboard(&r, mode, frame == 0, noise);
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) mean += rig_out(&r, i % WIDTH, i / WIDTH).y / (double)(WIDTH * HEIGHT);
        assert_share(mean, 0.98, 1.02, "mean of the light");
    }
    rig_close(&r);
}

/* The split shows the texel of a pixel's pair. */
static void left_of_the_split_the_checkerboard_is_shown_as_it_is(void **state)
{
    rig r;
    (void)state;
    rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, two_walls, NRD_FEATURE_CHECKERBOARD | NRD_FEATURE_SPLIT_SCREEN);
    RIG_CHECKERBOARD(&r) = 1;
    r.frame.split_screen = 0.5f;
    rig_put_guides(&r);
    put_checkerboard(&r, 1, noise);
    rig_run(&r, true);
    rig_download(&r);
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH / 2; x++) assert_memory_equal(&r.out[4 * (y * WIDTH + x)], &r.noisy[4 * (y * WIDTH + x / 2)], 8);
    rig_close(&r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Materials  >>materials */
/* Region 1: the right half of a wall, of another material. */
static hit two_materials(const pose *p, double u, double v, uint32_t frame)
{
    double normal[3] = { 0, 0, -1 }, point[3] = { 0, 0, 8 };
    hit h = { RIG_SKY, { 0, 0, -1 }, u >= 0.5, { 0, 0, 0 }, u >= 0.5 };
    (void)v;
    (void)frame;
    rig_ray_plane(p, u, v, point, normal, &h.depth);
    return h;
}

/* Largest difference of a pixel to its own half's light, in a denoiser of both signals. */
static double leak_between_materials(uint32_t of_rig, uint32_t of_other, uint32_t features)
{
    double largest = 0;
    rig r;
    rig_open_with(&r, &device, RIG_BOTH, WIDTH, HEIGHT, two_materials, features);
#ifdef RIG_SPECULAR
    r.settings.min_material_for_specular = of_rig, r.settings.min_material_for_diffuse = of_other;
#else
    r.settings.min_material_for_specular = of_other, r.settings.min_material_for_diffuse = of_rig;
#endif
    rig_put_guides(&r);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) rig_put_noisy(&r, i % WIDTH, i / WIDTH, by_region(&r, i % WIDTH, i / WIDTH));
    for (uint32_t frame = 0; frame < 3; frame++) rig_run(&r, frame == 0);
    rig_download(&r);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
        largest = fmax(largest, fabs(rig_out(&r, i % WIDTH, i / WIDTH).y - by_region(&r, i % WIDTH, i / WIDTH).y));
    rig_close(&r);
    return largest;
}

static void each_signal_of_a_denoiser_has_its_own_least_material(void **state)
{
    (void)state;
    assert_share(leak_between_materials(0, 4, NRD_FEATURE_MATERIALS), 0, 1e-3, "leak where the signal tells materials apart");
    assert_share(leak_between_materials(4, 0, NRD_FEATURE_MATERIALS), 0.01, 1, "leak where only the other does");
    assert_share(leak_between_materials(4, 0, 0), 0, 1e-3, "leak without the feature");
}

/* A wall of material 1 whose depth jumps to and fro, as that of hair does. */
static hit restless(const pose *p, double u, double v, uint32_t frame)
{
    double normal[3] = { 0, 0, -1 }, point[3] = { 0, 0, frame & 1 ? 8.6 : 8 };
    hit h = { RIG_SKY, { 0, 0, -1 }, 1, { 0, 0, 0 }, 0 };
    (void)u;
    (void)v;
    rig_ray_plane(p, u, v, point, normal, &h.depth);
    return h;
}

/* Mean history length after 8 frames. */
static double history_of_strands(uint32_t id, double pan)
{
    double mean = 0;
    rig r;
    rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, restless, NRD_FEATURE_MATERIALS);
    r.settings.return_history_length_instead_of_occlusion = 1;
    r.frame.strand_material_id = id;
    for (uint32_t frame = 0; frame < 8; frame++) {
        r.camera.position[0] = pan * frame;
        rig_put_guides(&r);
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) rig_put_noisy(&r, i % WIDTH, i / WIDTH, (texel){ 1, 0, 0, 0.5f });
        rig_run(&r, true);
    }
    rig_download(&r);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) mean += rig_out(&r, i % WIDTH, i / WIDTH).hit_dist / (double)(WIDTH * HEIGHT);
    rig_close(&r);
    return mean;
}

static void strands_keep_their_history_while_parallax_is_small(void **state)
{
    (void)state;
    assert_share(history_of_strands(4, 0), 1, 1.01, "history without a strand material");
    assert_share(history_of_strands(2, 0), 1, 1.01, "history of another material");
    assert_share(history_of_strands(1, 0), 7.9, 8.01, "history of strands");
    assert_share(history_of_strands(1, 0.5), 1, 1.5, "history of strands with 4 pixels of parallax");
}

#ifdef RIG_SPECULAR
/* ---------------------------------------------------------------------------------------------------------------------------
   Motion of what is reflected  >>motion */
enum { SPEED = 2 };   /* pixels of the picture that a pattern moves by in a mirror, every frame */
#define MIRROR_DEPTH 8.0
#define MIRROR_HIT_DIST 6.0

static hit mirror(const pose *p, double u, double v, uint32_t frame)
{
    double normal[3] = { 0, 0, -1 }, point[3] = { 0, 0, MIRROR_DEPTH };
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 0 };
    (void)frame;
    rig_ray_plane(p, u, v, point, normal, &h.depth);
    return h;
}

/* Stripes 8 pixels wide, from 0.5 to 1.5. */
static float stripes(uint32_t x, uint32_t frame) { return (x + 1024 - SPEED * frame) / 8 % 2 ? 1.5f : 0.5f; }

static void put_mirror(rig *r)
{
    const float normal[3] = { 0, 0, -1 };
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        uint32_t x = i % WIDTH, y = i / WIDTH;
        float q[4] = { r->settings.hit_distance_a, r->settings.hit_distance_b, r->settings.hit_distance_c, r->settings.hit_distance_d };
        float luma = stripes(x, r->index) * (float)(2 * random_at(x, y, r->index));
        r->normal[i] = pack_normal_roughness(normal, 0.02f, 0);
        rig_put_noisy(r, x, y, (texel){ luma, 0, 0, pack_normalize_hit_dist((float)MIRROR_HIT_DIST, (float)MIRROR_DEPTH, 0.02f, q) });
    }
}

/* The same motion everywhere: of the image, or of the point that a path hits, MIRROR_HIT_DIST behind the mirror. */
static void put_motion(rig *r, uint32_t mode, bool given)
{
    float *motion = (float *)rig_array(r, 16);
    double across = 2 * r->camera.tan_half_height * r->camera.aspect * (MIRROR_DEPTH + MIRROR_HIT_DIST);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        double x = -(double)SPEED / WIDTH * (mode == NRD_SPECULAR_MOTION_HIT ? across : 1);
        motion[4 * i] = given ? (float)x : i % 3 == 0 ? NAN : 65504;
    }
    assert_true(gpu_upload(r->device, &r->images[NRD_RESOURCE_IN_SPEC_MV], motion));
    free(motion);
}

/* Mean squared error in the middle of a mirror in which stripes move. */
static double mirror_error(uint32_t mode, bool given)
{
    double sum = 0;
    uint32_t count = 0;
    rig r;
    rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, mirror, NRD_FEATURE_SPECULAR_MOTION);
    r.frame.specular_motion = mode;
    for (uint32_t frame = 0; frame < 24; frame++) {
        rig_put_guides(&r);
        put_mirror(&r);
        put_motion(&r, mode, given);
        rig_run(&r, true);
    }
    rig_download(&r);
    for (uint32_t y = 4; y < HEIGHT - 4; y++)
        for (uint32_t x = 26; x < WIDTH - 4; x++, count++) {
            double e = rig_out(&r, x, y).y - stripes(x, r.index - 1);
            sum += e * e;
        }
    rig_close(&r);
    return sum / count;
}

static void an_object_that_moves_in_a_mirror_is_followed_where_its_motion_is_given(void **state)
{
    (void)state;
    double none = mirror_error(NRD_SPECULAR_MOTION_NONE, true), image = mirror_error(NRD_SPECULAR_MOTION_IMAGE, true);
    double of_hit = mirror_error(NRD_SPECULAR_MOTION_HIT, true), not_given = mirror_error(NRD_SPECULAR_MOTION_HIT, false);
    print_message("squared error: no motion %.4f, of the image %.4f, of the hit %.4f, not given %.4f\n", none, image, of_hit, not_given);
    assert_share(image, 0, 0.3 * none, "error with the motion of the image");
    assert_share(of_hit, 0, 0.3 * none, "error with the motion of the hit");
    assert_share(not_given, none, none, "error where it is not given");
}

/* A bright bar, 12 pixels wide, that slides to the right in the mirror, close to it, before something dark and far. */
static bool is_bar(uint32_t x, uint32_t frame) { return x >= 1 + SPEED * frame && x < 13 + SPEED * frame; }

/* Largest excess over the dark background right behind the bar. */
static double trail_of_bar(uint32_t mode)
{
    float motion[WIDTH * HEIGHT * 4] = { 0 };
    double largest = 0;
    rig r;
    rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, mirror, NRD_FEATURE_SPECULAR_MOTION);
    r.frame.specular_motion = mode;
    r.settings.antilag_sensitivity = 0;
    double across = 2 * r.camera.tan_half_height * r.camera.aspect * (MIRROR_DEPTH + 1);
    for (uint32_t frame = 0; frame < 20; frame++) {
        rig_put_guides(&r);
        put_mirror(&r);
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
            bool bar = is_bar(i % WIDTH, frame);
            rig_put_noisy(&r, i % WIDTH, i / WIDTH, (texel){ bar ? 4.0f : 0.25f, 0, 0, bar ? 0.02f : 0.5f });
            motion[4 * i] = bar ? (float)(-(double)SPEED / WIDTH * across) : 0;
        }
        assert_true(gpu_upload(&device, &r.images[NRD_RESOURCE_IN_SPEC_MV], motion));
        rig_run(&r, true);
    }
    rig_download(&r);
    for (uint32_t x = 24; x < 1 + SPEED * 19 - 1; x++) largest = fmax(largest, rig_out(&r, x, HEIGHT / 2).y - 0.25);
    rig_close(&r);
    return largest;
}

/* History length after 20 frames of a wall of a roughness. */
static double history_of_roughness(float roughness, float responsive)
{
    const float normal[3] = { 0, 0, -1 };
    rig r;
    rig_open(&r, &device, RIG_DENOISER, 32, 16, mirror);
    r.settings.return_history_length_instead_of_occlusion = 1;
    r.settings.max_accumulated_frames = 16;
    r.settings.responsive_roughness = responsive;
    for (uint32_t frame = 0; frame < 20; frame++) {
        rig_put_guides(&r);
        for (uint32_t i = 0; i < 32 * 16; i++) {
            r.normal[i] = pack_normal_roughness(normal, roughness, 0);
            rig_put_noisy(&r, i % 32, i / 32, (texel){ 1, 0, 0, 0.5f });
        }
        rig_run(&r, true);
    }
    rig_download(&r);
    double frames = rig_out(&r, 16, 8).hit_dist;
    rig_close(&r);
    return frames;
}

/* One frame more than the limit, which is that before the new one. */
static void responsive_roughness_shortens_the_history_of_smooth_surfaces(void **state)
{
    (void)state;
    assert_share(history_of_roughness(0.05f, 0), 17, 17, "history, off");
    assert_share(history_of_roughness(0.05f, 0.4f), 4.9, 5.6, "history of a smooth surface");
    double between = history_of_roughness(0.2f, 0.4f);
    assert_share(between, 10, 16, "history halfway");
    assert_share(history_of_roughness(0.5f, 0.4f), 17, 17, "history of a rougher surface");
}

/* Mean history length of a mirror of material 0 in front of a camera that moves sideways. */
static double history_of_mirror(uint32_t attached_id)
{
    double mean = 0;
    rig r;
    rig_open_with(&r, &device, RIG_DENOISER, WIDTH, HEIGHT, mirror, NRD_FEATURE_MATERIALS);
    r.settings.return_history_length_instead_of_occlusion = 1;
    r.frame.camera_attached_reflection_material_id = attached_id;
    for (uint32_t frame = 0; frame < 12; frame++) {
        r.camera.position[0] = 0.25 * frame;
        rig_put_guides(&r);
        put_mirror(&r);
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) r.noisy[4 * i + 3] = half_from_float(i % 2 ? 0.5f : 0.05f);   /* no distance to be followed */
        rig_run(&r, true);
    }
    rig_download(&r);
    for (uint32_t y = 4; y < HEIGHT - 4; y++)
        for (uint32_t x = 4; x < WIDTH - 30; x++) mean += rig_out(&r, x, y).hit_dist / (double)((HEIGHT - 8) * (WIDTH - 34));
    rig_close(&r);
    return mean;
}

static void reflections_of_what_moves_with_the_camera_follow_the_surface(void **state)
{
    (void)state;
    double plain = history_of_mirror(4), other = history_of_mirror(1), attached = history_of_mirror(0);
    print_message("history %.2f frames, of another material %.2f, attached to the camera %.2f\n", plain, other, attached);
    assert_share(other, plain, plain, "history of another material");
    assert_share(plain, 0, 4, "history of a mirror that cannot be followed");
    assert_share(attached, 11, 12.01, "history of a mirror attached to the camera");
}

static void what_moves_in_a_mirror_leaves_no_trail_where_motion_is_given(void **state)
{
    (void)state;
    double without = trail_of_bar(NRD_SPECULAR_MOTION_NONE), with = trail_of_bar(NRD_SPECULAR_MOTION_HIT);
    print_message("trail without motion %.4f, with %.4f\n", without, with);
    assert_share(with, 0, 0.1 * without, "trail");
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hit_distances_that_were_not_sampled_are_taken_from_the_surface_around),
        cmocka_unit_test(what_was_once_sampled_is_remembered_without_reconstruction),
        cmocka_unit_test(reconstruction_leaves_the_light_as_it_is),
        cmocka_unit_test(a_checkerboard_gives_the_picture_that_all_pixels_give),
        cmocka_unit_test(both_colours_of_the_checkerboard_keep_the_mean),
        cmocka_unit_test(left_of_the_split_the_checkerboard_is_shown_as_it_is),
        cmocka_unit_test(each_signal_of_a_denoiser_has_its_own_least_material),
        cmocka_unit_test(strands_keep_their_history_while_parallax_is_small),
#ifdef RIG_SPECULAR
        cmocka_unit_test(an_object_that_moves_in_a_mirror_is_followed_where_its_motion_is_given),
        cmocka_unit_test(responsive_roughness_shortens_the_history_of_smooth_surfaces),
        cmocka_unit_test(reflections_of_what_moves_with_the_camera_follow_the_surface),
        cmocka_unit_test(what_moves_in_a_mirror_leaves_no_trail_where_motion_is_given),
#endif
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
