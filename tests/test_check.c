/* The input checker: good inputs break no rule, and each rule is broken by the mistake that it is there for, which is named. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "common/gpu.h"
#include "frame_fixture.h"
#include "nrd_shaders/nrd_c.h"

enum { WIDTH = 96, HEIGHT = 64, PIXELS = WIDTH * HEIGHT, SIGMA = 2, DENOISERS = 3 };
static const float RANGE = 1000.0f, SUN_TAN = 0.05f, LAMP_RADIUS = 0.1f;
static const double SUN[3] = { 0.36, 0.8, -0.48 }, LAMP[3] = { 0.5, 0.9, -1 };

/* A room that the camera moves through, with two shelves at the back wall, one above the other, under a sun or a lamp. */
static const double ROOM_MIN[3] = { -3, -1, -2 }, ROOM_MAX[3] = { 3, 2, 6 };
typedef struct shelf { double height, near, half_width; } shelf;
static const shelf shelves[2] = { { 0.2, 3.4, 2.3 }, { 1.6, 1.5, 2.9 } };

typedef struct fixture {
    gpu device;
    spy spy;
    nrd *instance;
    nrd_vk *vk;
    gpu_image images[NRD_RESOURCE_COUNT];
    float *in[NRD_RESOURCE_COUNT];   /* RGBA, WIDTH x HEIGHT, of every input */
    float (*world)[3], (*normal)[3]; /* of the primary hits */
    pose camera, camera_prev;
    nrd_frame frame;
    nrd_sigma_settings sigma;
    uint32_t index;
    bool still;                      /* the camera stands still */
    bool turning;                    /* or turns about the origin of the world */
    pose convention;                 /* what the camera has of right_handed, orthographic, .. */
    uint64_t counters[NRD_COUNTER_COUNT];
} fixture;

typedef void tweak(fixture *f);

/* ---------------------------------------------------------------------------------------------------------------------------
   Room  >>room */
/* Distance to what a ray from inside the room meets, and its normal. */
static double room_hit(const double from[3], const double along[3], double normal[3])
{
    double nearest = 1e9;
    for (int k = 0; k < 3; k++) {
        double wall = along[k] > 0 ? ROOM_MAX[k] : ROOM_MIN[k], t = along[k] != 0 ? (wall - from[k]) / along[k] : 1e9;
        if (t >= nearest) continue;
        nearest = t;
        for (int j = 0; j < 3; j++) normal[j] = j != k ? 0 : along[k] > 0 ? -1 : 1;
    }
    return nearest;
}

/* Distance to the nearest shelf within a reach; 0: none. */
static double shelf_hit(const double from[3], const double along[3], double reach)
{
    double found = 0;
    for (int i = 0; i < 2; i++) {
        double t = (shelves[i].height - from[1]) / along[1], x = from[0] + t * along[0], z = from[2] + t * along[2];
        if (!(t > 1e-6 && t < reach) || fabs(x) > shelves[i].half_width || z < shelves[i].near || z > ROOM_MAX[2] + 1e-9) continue;
        if (found == 0 || t < found) found = t;
    }
    return found;
}

static float *texel(fixture *f, nrd_resource resource, uint32_t i) { return f->in[resource] + 4 * (size_t)i; }
static float *motion(fixture *f, uint32_t i) { return texel(f, NRD_RESOURCE_IN_MV, i); }
static float *view_z(fixture *f, uint32_t i) { return texel(f, NRD_RESOURCE_IN_VIEWZ, i); }
static float *normal(fixture *f, uint32_t i) { return texel(f, NRD_RESOURCE_IN_NORMAL_ROUGHNESS, i); }
static float *diffuse(fixture *f, uint32_t i) { return texel(f, NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, i); }
static float *specular(fixture *f, uint32_t i) { return texel(f, NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, i); }
static float *direction(fixture *f, uint32_t i) { return texel(f, NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, i); }
static float *penumbra(fixture *f, uint32_t i) { return texel(f, NRD_RESOURCE_IN_PENUMBRA, i); }
static float *translucency(fixture *f, uint32_t i) { return texel(f, NRD_RESOURCE_IN_TRANSLUCENCY, i); }

/* The upper quarter of the first columns shows sky, as if through a window. */
static bool is_sky_pixel(uint32_t i) { return i % WIDTH < WIDTH / 4 && i / WIDTH < HEIGHT / 3; }

static void put_guides(fixture *f, uint32_t i)
{
    double u = (i % WIDTH + 0.5) / WIDTH, v = (i / WIDTH + 0.5) / HEIGHT, eye[3], ahead[3], along[3], length = 0, n[3] = { 0, 0, 0 };
    double world[3], u_prev, v_prev, depth, depth_prev;
    pose_point(&f->camera, u, v, 0, eye);
    pose_point(&f->camera, u, v, 1, ahead);
    for (int k = 0; k < 3; k++) along[k] = ahead[k] - eye[k], length += along[k] * along[k];
    double t = room_hit(eye, along, n);
    for (int k = 0; k < 3; k++) world[k] = eye[k] + t * along[k];
    depth = t;
    pose_project(&f->camera_prev, world, &u_prev, &v_prev, &depth_prev);
    double sign = f->camera.right_handed ? -1 : 1;
    float mv[4] = { (float)(u_prev - u), (float)(v_prev - v), (float)((depth_prev - depth) * sign), 0 };
    float guide[4] = { (float)n[0], (float)n[1], (float)n[2], 0.5f };
    memcpy(motion(f, i), mv, sizeof mv);
    memcpy(normal(f, i), guide, sizeof guide);
    view_z(f, i)[0] = (float)((is_sky_pixel(i) ? 2 * RANGE : depth) * sign);
    for (int k = 0; k < 3; k++) f->world[i][k] = (float)world[k], f->normal[i][k] = (float)n[k];
}

/* One diffuse and one specular path, both of uniform direction: their distances are what counts. */
static void put_light(fixture *f, uint32_t i)
{
    double from[3] = { f->world[i][0], f->world[i][1], f->world[i][2] }, along[3], ignored[3], length = 0, side = 0;
    for (uint32_t k = 0; k < 3; k++) along[k] = random_at(i, f->index, k) * 2 - 1, length += along[k] * along[k];
    for (int k = 0; k < 3; k++) along[k] /= sqrt(length), side += along[k] * f->normal[i][k];
    for (int k = 0; k < 3; k++) along[k] -= side < 0 ? 2 * side * f->normal[i][k] : 0, from[k] += 1e-6 * f->normal[i][k];
    float dist = (float)room_hit(from, along, ignored), z = view_z(f, i)[0];
    nrd_vec3 radiance = nrd_make_vec3((float)random_at(i, f->index, 4), 0.5f, 1.0f);
    nrd_vec4 params = nrd_make_vec4(20, 0.1f, 1, -25);
    float w = nrd_normalize_hit_dist(dist, z, 1, params);
    nrd_vec4 t = nrd_pack_radiance_hit_dist(radiance, w, true);
    float packed[4] = { t.x, t.y, t.z, t.w }, directed[4] = { (float)along[0] * w, (float)along[1] * w, (float)along[2] * w, w };
    memcpy(diffuse(f, i), packed, sizeof packed);
    memcpy(specular(f, i), packed, sizeof packed);
    memcpy(direction(f, i), directed, sizeof directed);
}

/* Distance to the nearest occluder, as nrd_pack_penumbra wants it. */
static double occluder_dist(fixture *f, uint32_t i)
{
    double from[3], along[3], facing = 0, dist = 0;
    for (int k = 0; k < 3; k++) from[k] = f->world[i][k], along[k] = f->sigma.light_is_local ? LAMP[k] - from[k] : SUN[k], dist += along[k] * along[k];
    for (int k = 0; k < 3; k++) along[k] /= sqrt(dist), facing += along[k] * f->normal[i][k];
    if (facing <= 0) return 0;
    double t = shelf_hit(from, along, f->sigma.light_is_local ? sqrt(dist) : 1e9);
    return t > 0 ? t : NRD_HIT_DIST_MISS;
}

static float lamp_dist(const fixture *f, uint32_t i)
{
    double squared = 0;
    for (int k = 0; k < 3; k++) squared += (LAMP[k] - f->world[i][k]) * (LAMP[k] - f->world[i][k]);
    return (float)sqrt(squared);
}

static float pack_shadow(const fixture *f, uint32_t i, double dist)
{
    return f->sigma.light_is_local ? nrd_pack_local_penumbra((float)dist, lamp_dist(f, i), LAMP_RADIUS) : nrd_pack_penumbra((float)dist, SUN_TAN);
}

static void put_shadow(fixture *f, uint32_t i)
{
    double dist = occluder_dist(f, i);
    nrd_vec4 t = nrd_pack_translucency((float)dist, nrd_make_vec3(0.2f, 0.1f, 0));
    float color[4] = { t.x, t.y, t.z, t.w };
    penumbra(f, i)[0] = pack_shadow(f, i, dist);
    memcpy(translucency(f, i), color, sizeof color);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Running  >>run */
static int open_fixture(void **state)
{
    static const nrd_denoiser_desc denoisers[DENOISERS] = { { 0, NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR }, { 1, NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION },
                                                            { SIGMA, NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY } };
    static fixture f;
    char error[256];
    gpu_desc device = { .sync_validation = gpu_validation_available() };
    if (!gpu_open(&f.device, &device, error, sizeof error)) { print_error("%s\n", error); return -1; }
    nrd_desc desc = spied_desc(&f.spy, denoisers, DENOISERS, WIDTH, HEIGHT, NRD_FEATURE_CHECK);
    desc.normal_encoding = NRD_NORMAL_FORMAT_RGBA16_SNORM;
    assert_int_equal(nrd_create(&desc, &f.instance), NRD_RESULT_OK);
    nrd_vk_desc vk = { .instance = f.instance, .vk_instance = f.device.instance, .physical = f.device.physical, .device = f.device.device,
                       .get_instance_proc = f.device.get_instance_proc };
    assert_int_equal(nrd_vk_create(&vk, &f.vk), NRD_RESULT_OK);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        VkFormat format = nrd_vk_format(nrd_resource_format((nrd_resource)i));
        if (!nrd_uses_resource(f.instance, (nrd_resource)i)) continue;
        if (format == VK_FORMAT_UNDEFINED) f.in[i] = (float *)calloc(PIXELS, 16);
        assert_true(gpu_image_create(&f.device, WIDTH, HEIGHT, f.in[i] ? VK_FORMAT_R32G32B32A32_SFLOAT : format, nrd_resource_name((nrd_resource)i), &f.images[i]));
    }
    f.world = (float (*)[3])calloc(PIXELS, sizeof *f.world);
    f.normal = (float (*)[3])calloc(PIXELS, sizeof *f.normal);
    *state = &f;
    return 0;
}

static int close_fixture(void **state)
{
    fixture *f = (fixture *)*state;
    uint32_t messages = gpu_message_count(&f->device);
    nrd_vk_destroy(f->vk);
    nrd_destroy(f->instance);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        gpu_image_destroy(&f->device, &f->images[i]);
        free(f->in[i]);
    }
    free(f->world);
    free(f->normal);
    gpu_close(&f->device);
    return messages ? -1 : 0;
}

static void submit(fixture *f)
{
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    nrd_vk_frame record = { .slot = f->index % 2, .images = list };
    memset(list, 0, sizeof list);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        const gpu_image *image = &f->images[i];
        nrd_vk_image given = { (nrd_resource)i, image->image, image->view, image->format, WIDTH, HEIGHT, image->layout, image->layout, 0, 0, 0 };
        if (!image->view) continue;
        if (f->in[i]) assert_true(gpu_upload(&f->device, &f->images[i], f->in[i]));
        list[record.image_count++] = given;
    }
    assert_int_equal(nrd_set_frame(f->instance, &f->frame), NRD_RESULT_OK);
    VkCommandBuffer cmd = gpu_begin(&f->device);
    assert_int_equal(nrd_vk_record(f->vk, cmd, &record), NRD_RESULT_OK);
    assert_true(gpu_submit_and_wait(&f->device));
    memset(f->counters, 0, sizeof f->counters);
    for (uint32_t i = 0; i < DENOISERS; i++) assert_int_equal(nrd_vk_counters(f->vk, record.slot, i, f->counters), NRD_RESULT_OK);
}

static void move_camera(fixture *f, uint32_t step)
{
    f->camera_prev = f->camera;
    f->camera = f->convention;
    f->camera.aspect = (double)WIDTH / HEIGHT;
    f->camera.jitter[0] = step % 2 ? 0.3 : -0.2;
    f->camera.jitter[1] = step % 2 ? -0.4 : 0.1;
    if (f->still) return;
    f->camera.yaw = f->turning ? 0.5 + 0.1 * step : 0.1 + 0.06 * step;
    f->camera.pitch = f->turning ? 0.4 - 0.05 * step : 0.15;
    f->camera.roll = f->turning ? 0.5 : 0;
    for (int k = 0; k < 3 && !f->turning; k++) f->camera.position[k] = (k == 2 ? 0.35 : 0.08) * step;
    if (step == 0) f->camera_prev = f->camera;
}

/* Three frames from a cut on, all with the mistake; f->counters are those of the last. before: changes what the frames are made of. */
static void run(fixture *f, tweak *before, tweak *after)
{
    f->still = f->turning = false;
    f->convention = pose_at(0, 0, 0);
    f->sigma = nrd_sigma_defaults();
    f->sigma.light_x = (float)SUN[0], f->sigma.light_y = (float)SUN[1], f->sigma.light_z = (float)SUN[2], f->sigma.light_radius = SUN_TAN;
    if (before) before(f);
    for (uint32_t step = 0; step < 3; step++) {
        move_camera(f, step);
        if (step == 0) f->camera_prev = f->camera;
        for (uint32_t i = 0; i < PIXELS; i++) put_guides(f, i), put_light(f, i), put_shadow(f, i);
        f->frame = nrd_frame_defaults();
        f->frame.camera = pose_camera(&f->camera);
        f->frame.clip_y = pose_clip_y(&f->camera);
        f->frame.frame_index = ++f->index;
        f->frame.denoising_range = RANGE;
        f->frame.restart = step == 0;
        if (after) after(f);
        nrd_reblur_settings reblur = nrd_reblur_defaults();
        nrd_occlusion_settings occlusion = nrd_occlusion_defaults();
        reblur.hit_distance_a = occlusion.hit_distance_a = 20;
        reblur.hit_distance_c = occlusion.hit_distance_c = 1;
        assert_int_equal(nrd_set_settings(f->instance, 0, &reblur), NRD_RESULT_OK);
        assert_int_equal(nrd_set_settings(f->instance, 1, &occlusion), NRD_RESULT_OK);
        assert_int_equal(nrd_set_settings(f->instance, SIGMA, &f->sigma), NRD_RESULT_OK);
        submit(f);
    }
}

static nrd_finding finding(const fixture *f, const char *name)
{
    nrd_finding found;
    for (uint32_t i = 0; nrd_check_rule(f->counters, i, &found); i++)
        if (strcmp(found.name, name) == 0) return found;
    fail_msg("there is no rule %s", name);
    return found;
}

static void assert_nothing_is_broken(const fixture *f)
{
    nrd_finding found;
    for (uint32_t i = 0; nrd_check_rule(f->counters, i, &found); i++)
        if (found.broken) fail_msg("good inputs break %s: %g of %g allowed", found.name, found.share, found.allowed);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Mistakes  >>mistakes */
#define MISTAKE(name, ...) static void name(fixture *f) { for (uint32_t i = 0; i < PIXELS; i++) { __VA_ARGS__; } }
#define ONCE(name, ...) static void name(fixture *f) { __VA_ARGS__; }

static void flip(float *v) { *v = -*v; }
static void transpose_rotation(float *m)
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < r; c++) { float kept = m[4 * c + r]; m[4 * c + r] = m[4 * r + c]; m[4 * r + c] = kept; }
}

/* The world's normals in the view space of the camera. */
static void to_view_space(fixture *f, float *n)
{
    double axes[3][3];
    float turned[3] = { 0, 0, 0 };
    pose_axes(&f->camera, axes);
    for (int r = 0; r < 3; r++) for (int k = 0; k < 3; k++) turned[r] += (float)axes[r][k] * n[k];
    memcpy(n, turned, sizeof turned);
}

ONCE(use_lamp, f->sigma.light_is_local = 1; f->sigma.light_x = (float)LAMP[0]; f->sigma.light_y = (float)LAMP[1]; f->sigma.light_z = (float)LAMP[2]; f->sigma.light_radius = LAMP_RADIUS)
ONCE(stand_still, f->still = true)
ONCE(turn, f->turning = true)
ONCE(use_right_hand, f->convention.right_handed = f->convention.reversed = f->convention.clip_y_down = true)
ONCE(use_view_y_down, f->convention.view_y_down = true)
ONCE(look_in_parallel, f->convention.orthographic = true; f->convention.tan_half_height = 1)
ONCE(turn_right_handed, f->convention.right_handed = f->turning = true)
ONCE(jitter_matrix, f->frame.camera.view_to_clip[8] += (float)f->camera.jitter[0] * 2 / WIDTH)
ONCE(skip_frame, if (!f->frame.restart) f->frame.frame_index = f->index += 2)
ONCE(nan_view_z, view_z(f, PIXELS - 1)[0] = NAN)
ONCE(zero_view_z, view_z(f, PIXELS - 1)[0] = 0)
MISTAKE(mixed_view_z, if (i % 10 == 0) flip(view_z(f, i)))
MISTAKE(near_sky, if (is_sky_pixel(i)) { view_z(f, i)[0] = 0.1f * RANGE; memset(normal(f, i), 0, 12); })
MISTAKE(dark_near_sky, if (is_sky_pixel(i)) { view_z(f, i)[0] = 0.1f * RANGE; memset(diffuse(f, i), 0, 16); memset(specular(f, i), 0, 16); memset(direction(f, i), 0, 16); })
ONCE(infinite_normal, normal(f, PIXELS - 1)[1] = INFINITY)
MISTAKE(short_normals, normal(f, i)[0] *= 0.5f; normal(f, i)[1] *= 0.5f; normal(f, i)[2] *= 0.5f)
MISTAKE(negated_normals, flip(normal(f, i)); flip(normal(f, i) + 1); flip(normal(f, i) + 2))
MISTAKE(y_flipped_normals, flip(normal(f, i) + 1))
MISTAKE(z_flipped_normals, flip(normal(f, i) + 2))
MISTAKE(swapped_normals, float y = normal(f, i)[1]; normal(f, i)[1] = normal(f, i)[2]; normal(f, i)[2] = y)
MISTAKE(view_space_normals, to_view_space(f, normal(f, i)))
ONCE(nan_motion, motion(f, PIXELS - 1)[0] = NAN)
MISTAKE(negated_motion, flip(motion(f, i)); flip(motion(f, i) + 1))
MISTAKE(pixel_motion, motion(f, i)[0] *= WIDTH; motion(f, i)[1] *= HEIGHT)
MISTAKE(clip_motion, motion(f, i)[0] *= 2; motion(f, i)[1] *= -2)
MISTAKE(vulkan_clip_motion, motion(f, i)[0] *= 2; motion(f, i)[1] *= 2)
MISTAKE(y_flipped_motion, flip(motion(f, i) + 1))
ONCE(motion_scaled_twice, f->frame.motion_scale_x = 1.0f / WIDTH; f->frame.motion_scale_y = 1.0f / HEIGHT)
MISTAKE(no_motion, memset(motion(f, i), 0, 16))
MISTAKE(some_motion, motion(f, i)[0] += 5.0f / WIDTH)
MISTAKE(negated_depth_motion, flip(motion(f, i) + 2))
MISTAKE(flat_motion, motion(f, i)[2] = 0)
MISTAKE(jittered_motion, motion(f, i)[0] += (float)(f->camera.jitter[0] - f->camera_prev.jitter[0]) / WIDTH; motion(f, i)[1] += (float)(f->camera.jitter[1] - f->camera_prev.jitter[1]) / HEIGHT)
ONCE(transposed_matrices, transpose_rotation(f->frame.camera.world_to_view))
ONCE(nan_diffuse, diffuse(f, PIXELS - 1)[3] = NAN)
ONCE(infinite_specular, specular(f, PIXELS - 1)[0] = INFINITY)
MISTAKE(raw_diffuse, diffuse(f, i)[0] = 1; diffuse(f, i)[1] = 1; diffuse(f, i)[2] = 1)
ONCE(negative_specular, specular(f, PIXELS - 1)[0] = -1)
ONCE(negative_diffuse_hits, diffuse(f, PIXELS - 1)[3] = -0.1f)
ONCE(negative_specular_hits, specular(f, PIXELS - 1)[3] = -0.1f)
MISTAKE(raw_diffuse_hits, diffuse(f, i)[3] *= 20)
MISTAKE(raw_specular_hits, specular(f, i)[3] *= 20)
MISTAKE(no_diffuse_hits, diffuse(f, i)[3] = 0)
MISTAKE(no_specular_hits, specular(f, i)[3] = 0)
static float primary_dist(fixture *f, uint32_t i)
{
    double squared = 0;
    for (int k = 0; k < 3; k++) squared += (f->world[i][k] - f->camera.position[k]) * (f->world[i][k] - f->camera.position[k]);
    return (float)sqrt(squared) / (20 + 0.1f * view_z(f, i)[0]);
}
MISTAKE(long_diffuse_hits, diffuse(f, i)[3] += primary_dist(f, i); direction(f, i)[3] += primary_dist(f, i))
MISTAKE(long_specular_hits, specular(f, i)[3] += primary_dist(f, i))
MISTAKE(unit_directions, for (int k = 0; k < 3; k++) direction(f, i)[k] /= fmaxf(direction(f, i)[3], 1e-6f))
MISTAKE(negated_directions, for (int k = 0; k < 3; k++) flip(direction(f, i) + k))
ONCE(nan_penumbra, penumbra(f, PIXELS - 1)[0] = NAN)
ONCE(negative_penumbra, penumbra(f, PIXELS - 1)[0] = -1)
MISTAKE(infinite_miss, if (penumbra(f, i)[0] == NRD_PENUMBRA_LIT) penumbra(f, i)[0] = INFINITY)
MISTAKE(zero_miss, if (penumbra(f, i)[0] == NRD_PENUMBRA_LIT) penumbra(f, i)[0] = 0)
MISTAKE(long_miss, if (penumbra(f, i)[0] == NRD_PENUMBRA_LIT) penumbra(f, i)[0] = 1000 * SUN_TAN)
MISTAKE(lit_backs, if (penumbra(f, i)[0] == 0) penumbra(f, i)[0] = NRD_PENUMBRA_LIT)
ONCE(negated_sun, flip(&f->sigma.light_x); flip(&f->sigma.light_y); flip(&f->sigma.light_z))
static bool is_blocked(fixture *f, uint32_t i) { return penumbra(f, i)[0] > 0 && penumbra(f, i)[0] < NRD_PENUMBRA_LIT; }
MISTAKE(from_sun, if (is_blocked(f, i)) penumbra(f, i)[0] = pack_shadow(f, i, 500 - occluder_dist(f, i)))
MISTAKE(from_lamp, if (is_blocked(f, i)) penumbra(f, i)[0] = pack_shadow(f, i, lamp_dist(f, i) - occluder_dist(f, i)))
/* As if behind every occluder there were another. */
MISTAKE(first_hits, if (is_blocked(f, i)) penumbra(f, i)[0] = pack_shadow(f, i, occluder_dist(f, i) * (random_at(i, f->index, 9) < 0.5 ? 1 : 3)))
MISTAKE(grey_light, translucency(f, i)[1] = 0.5f)

typedef struct mistake { const char *rule; tweak *before, *after; const char *cause; } mistake;
static const mistake mistakes[] = {
    { "MATRIX_JITTER", stand_still, jitter_matrix, "" },
    { "FRAME_INDEX", NULL, skip_frame, "" },
    { "VIEWZ_NOT_FINITE", NULL, nan_view_z, "" },
    { "VIEWZ_ZERO", NULL, zero_view_z, "" },
    { "VIEWZ_NEGATIVE", NULL, mixed_view_z, "" },
    { "SKY_IN_RANGE", NULL, near_sky, "" },
    { "SKY_IN_RANGE", NULL, dark_near_sky, "" },
    { "NORMAL_NOT_FINITE", NULL, infinite_normal, "" },
    { "NORMAL_LENGTH", NULL, short_normals, "" },
    { "NORMAL_AWAY", NULL, negated_normals, "negate them" },
    { "NORMAL_PLANE", NULL, negated_normals, "negate them" },
    { "NORMAL_PLANE", NULL, y_flipped_normals, "y of the normals is flipped" },
    { "NORMAL_PLANE", NULL, z_flipped_normals, "z of the normals is flipped" },
    { "NORMAL_PLANE", NULL, swapped_normals, "y and z of the normals are swapped" },
    { "NORMAL_PLANE", turn, view_space_normals, "view space" },
    { "NORMAL_PLANE", turn, transposed_matrices, "transposed" },
    { "MOTION_NOT_FINITE", NULL, nan_motion, "" },
    { "MOTION_CAMERA", NULL, negated_motion, "current minus previous" },
    { "MOTION_CAMERA", NULL, pixel_motion, "in pixels" },
    { "MOTION_CAMERA", NULL, clip_motion, "clip space, y up" },
    { "MOTION_CAMERA", NULL, vulkan_clip_motion, "clip space: " },
    { "MOTION_CAMERA", turn, y_flipped_motion, "y of the motion is flipped" },
    { "MOTION_CAMERA", NULL, motion_scaled_twice, "in uv already" },
    { "MOTION_CAMERA", NULL, no_motion, "motion is 0" },
    { "MOTION_CAMERA", turn, transposed_matrices, "matrices are transposed" },
    { "MOTION_CAMERA", use_right_hand, negated_motion, "current minus previous" },
    { "MOTION_CAMERA", use_view_y_down, negated_motion, "current minus previous" },
    { "MOTION_CAMERA", look_in_parallel, negated_motion, "current minus previous" },
    { "MOTION_CAMERA", turn_right_handed, transposed_matrices, "matrices are transposed" },
    { "NORMAL_PLANE", turn_right_handed, transposed_matrices, "transposed" },
    { "NORMAL_PLANE", look_in_parallel, negated_normals, "negate them" },
    { "MOTION_DEPTH", use_right_hand, negated_depth_motion, "negate it" },
    { "MOTION_STILL", stand_still, some_motion, "" },
    { "MOTION_DEPTH", NULL, negated_depth_motion, "negate it" },
    { "MOTION_DEPTH", NULL, flat_motion, "NRD_MOTION_2D" },
    { "MOTION_JITTER", stand_still, jittered_motion, "" },
    { "MOTION_JITTER", NULL, jittered_motion, "" },
    { "DIFF_NOT_FINITE", NULL, nan_diffuse, "" },
    { "DIFF_NEGATIVE", NULL, raw_diffuse, "" },
    { "DIFF_HIT_NEGATIVE", NULL, negative_diffuse_hits, "" },
    { "DIFF_HIT_RANGE", NULL, raw_diffuse_hits, "" },
    { "DIFF_HIT_MISSING", NULL, no_diffuse_hits, "" },
    { "DIFF_HIT_PRIMARY", NULL, long_diffuse_hits, "" },
    { "SPEC_NOT_FINITE", NULL, infinite_specular, "" },
    { "SPEC_NEGATIVE", NULL, negative_specular, "" },
    { "SPEC_HIT_NEGATIVE", NULL, negative_specular_hits, "" },
    { "SPEC_HIT_RANGE", NULL, raw_specular_hits, "" },
    { "SPEC_HIT_MISSING", NULL, no_specular_hits, "" },
    { "SPEC_HIT_PRIMARY", NULL, long_specular_hits, "" },
    { "DIRECTION_LENGTH", NULL, unit_directions, "" },
    { "DIRECTION_BELOW", NULL, negated_directions, "" },
    { "PENUMBRA_INVALID", NULL, nan_penumbra, "" },
    { "PENUMBRA_INVALID", NULL, negative_penumbra, "" },
    { "PENUMBRA_CODE", NULL, infinite_miss, "" },
    { "PENUMBRA_ZERO", NULL, zero_miss, "" },
    { "PENUMBRA_ZERO", NULL, negated_sun, "light_x, y, z points away" },
    { "PENUMBRA_AWAY", NULL, lit_backs, "" },
    { "PENUMBRA_AWAY", NULL, negated_sun, "light_x, y, z points away" },
    { "PENUMBRA_MISS", NULL, long_miss, "" },
    { "PENUMBRA_FROM_LIGHT", NULL, from_sun, "" },
    { "PENUMBRA_FROM_LIGHT", use_lamp, from_lamp, "" },
    { "PENUMBRA_FIRST_HIT", NULL, first_hits, "" },
    { "TRANSLUCENCY_LIT", NULL, grey_light, "" },
};

/* ---------------------------------------------------------------------------------------------------------------------------
   Tests  >>tests */
static void good_inputs_break_no_rule(void **state)
{
    fixture *f = (fixture *)*state;
    tweak *const ways[] = { NULL, stand_still, turn, use_lamp, use_right_hand, use_view_y_down, look_in_parallel, turn_right_handed };
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        run(f, ways[i], NULL);
        assert_nothing_is_broken(f);
    }
}

/* So that "not broken" means something. */
static void every_rule_has_something_to_judge(void **state)
{
    fixture *f = (fixture *)*state;
    nrd_finding found;
    uint64_t sum[NRD_COUNTER_COUNT] = { 0 };
    tweak *const ways[] = { NULL, stand_still };
    for (size_t w = 0; w < 2; w++) {
        run(f, ways[w], NULL);
        for (uint32_t i = 0; i < NRD_COUNTER_COUNT; i++) sum[i] += f->counters[i];
    }
    for (uint32_t i = 0; nrd_check_rule(sum, i, &found); i++)
        if (!found.judged) fail_msg("%s has nothing to judge in the test's room", found.name);
}

static void every_mistake_breaks_its_rule_and_is_named(void **state)
{
    fixture *f = (fixture *)*state;
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; i++) {
        const mistake *m = &mistakes[i];
        run(f, m->before, m->after);
        nrd_finding found = finding(f, m->rule);
        if (!found.broken) fail_msg("mistake %zu does not break %s: share %g of %g, judged %d", i, m->rule, found.share, found.allowed, found.judged);
        if (m->cause[0] && !strstr(found.cause, m->cause)) fail_msg("mistake %zu: cause of %s is \"%s\", not \"%s\"", i, m->rule, found.cause, m->cause);
    }
}

static void every_rule_has_its_mistake(void **state)
{
    uint64_t counters[NRD_COUNTER_COUNT] = { 0 };
    nrd_finding found;
    (void)state;
    for (uint32_t i = 0; nrd_check_rule(counters, i, &found); i++) {
        bool seen = false;
        for (size_t k = 0; k < sizeof mistakes / sizeof mistakes[0]; k++) seen |= strcmp(mistakes[k].rule, found.name) == 0;
        if (!seen) fail_msg("no mistake breaks %s", found.name);
    }
}

static void counters_have_places_of_their_own(void **state)
{
    const uint32_t places[] = {
#define PLACE(name, index) index,
        NRD_COUNTERS(PLACE)
#undef PLACE
    };
    (void)state;
    for (size_t i = 1; i < sizeof places / sizeof places[0]; i++) assert_true(places[i] > places[i - 1]);
    assert_true(places[sizeof places / sizeof places[0] - 1] < NRD_COUNTER_COUNT);
}

static void refused_calls_count_nothing(void **state)
{
    fixture *f = (fixture *)*state;
    uint64_t counters[NRD_COUNTER_COUNT] = { 0 };
    nrd_finding found;
    assert_int_equal(nrd_vk_counters(NULL, 0, 0, counters), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_vk_counters(f->vk, 0, 0, NULL), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_vk_counters(f->vk, 2, 0, counters), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_vk_counters(f->vk, 0, 99, counters), NRD_RESULT_UNKNOWN_DENOISER);
    assert_false(nrd_check_rule(NULL, 0, &found));
    assert_false(nrd_check_rule(counters, 0, NULL));
    assert_false(nrd_check_rule(counters, 1000, &found));
    for (uint32_t i = 0; i < NRD_COUNTER_COUNT; i++) assert_true(counters[i] == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counters_have_places_of_their_own),
        cmocka_unit_test(every_rule_has_its_mistake),
        cmocka_unit_test(refused_calls_count_nothing),
        cmocka_unit_test(good_inputs_break_no_rule),
        cmocka_unit_test(every_rule_has_something_to_judge),
        cmocka_unit_test(every_mistake_breaks_its_rule_and_is_named),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
