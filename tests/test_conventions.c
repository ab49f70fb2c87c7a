/* One scene, described to all denoisers in every convention that nrd.h allows, gives one result. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "common/gpu.h"
#include "common/half.h"
#include "frame_fixture.h"
#include "nrd_shaders/nrd_c.h"

enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT, FRAMES = 8, DENOISERS = NRD_DENOISER_COUNT - 1 };
static const float RANGE = 1000, SUN_TAN = 0.1f;
static const double SUN[3] = { 0.36, 0.8, -0.48 };

/* How an app describes the scene. All zero: left-handed, y up, depth 0 at the near plane, far plane at 100, 2.5D motion, the world as it is. */
typedef struct convention {
    const char *name;
    bool right_handed, clip_y_down, view_y_down, reversed, infinite, orthographic, still_rays;
    uint32_t motion_mode_plus_1;
    double turn[3];       /* yaw, pitch and roll of the whole world, the camera with it */
} convention;

typedef struct fixture {
    gpu device;
    spy spy;
    nrd *instance;
    nrd_vk *vk;
    gpu_image images[NRD_RESOURCE_COUNT];
    float *in[NRD_RESOURCE_COUNT];           /* RGBA of inputs */
    float *out[2][NRD_RESOURCE_COUNT];       /* RGBA of the outputs of two runs */
    uint32_t index;
} fixture;

/* ---------------------------------------------------------------------------------------------------------------------------
   Scene  >>scene */
typedef struct surface { double depth, world[3], normal[3], roughness; bool sky; } surface;

/* A room whose far end is open. */
static surface look(const pose *p, double u, double v)
{
    static const double walls[4][4] = { { 0, 1, 0, -1 }, { 0, -1, 0, -2 }, { 1, 0, 0, -3 }, { -1, 0, 0, -3 } };   /* normal, distance from the origin */
    static const double roughness[4] = { 0.05, 0.9, 0.3, 0.5 };
    double from[3], to[3];
    surface s = { 12, { 0, 0, 0 }, { 0, 0, -1 }, 1, true };
    pose_point(p, u, v, 0, from);
    pose_point(p, u, v, 1, to);
    for (int i = 0; i < 4; i++) {
        double along = 0, distance = walls[i][3];
        for (int k = 0; k < 3; k++) along += (to[k] - from[k]) * walls[i][k], distance -= from[k] * walls[i][k];
        if (!(distance / along > 0) || distance / along >= s.depth) continue;
        s.depth = distance / along;
        s.sky = false;
        s.roughness = roughness[i];
        memcpy(s.normal, walls[i], sizeof s.normal);
    }
    for (int k = 0; k < 3; k++) s.world[k] = from[k] + s.depth * (to[k] - from[k]);
    return s;
}

static pose camera_at(const convention *c, uint32_t frame)
{
    pose p = pose_at(0.04 * frame, 0.1, 0.05 * frame);
    p.yaw = 0.1 + 0.004 * frame;
    p.pitch = 0.05 - 0.002 * frame;
    p.roll = 0.003 * frame;
    p.right_handed = c->right_handed;
    p.clip_y_down = c->clip_y_down;
    p.view_y_down = c->view_y_down;
    p.reversed = c->reversed;
    p.orthographic = c->orthographic;
    p.far = c->infinite ? 0 : 100;
    if (p.orthographic) p.tan_half_height = 2.5;
    if (!c->still_rays) p.jitter[0] = 0.5 * (frame % 2) - 0.25, p.jitter[1] = 0.3 * (frame % 3) - 0.3;
    return p;
}

/* Rows of the rotation of the world. */
static void turn_of(const convention *c, double rows[3][3])
{
    pose p = pose_at(0, 0, 0);
    p.yaw = c->turn[0], p.pitch = c->turn[1], p.roll = c->turn[2];
    pose_axes(&p, rows);
}

static void rotate(double rows[3][3], const double v[3], double out[3])
{
    for (int r = 0; r < 3; r++) out[r] = rows[r][0] * v[0] + rows[r][1] * v[1] + rows[r][2] * v[2];
}

static float *texel(fixture *f, nrd_resource resource, uint32_t i) { return f->in[resource] + 4 * (size_t)i; }

static void put(fixture *f, nrd_resource resource, uint32_t i, double x, double y, double z, double w)
{
    float *t = texel(f, resource, i);
    t[0] = (float)x, t[1] = (float)y, t[2] = (float)z, t[3] = (float)w;
}

static void put_guides(fixture *f, const convention *c, uint32_t i, const surface *s, const pose *now, const pose *prev)
{
    double rows[3][3], normal[3], at[3], before[3], sign = c->right_handed ? -1 : 1;
    turn_of(c, rows);
    rotate(rows, s->normal, normal);
    pose_project(now, s->world, &at[0], &at[1], &at[2]);
    pose_project(prev, s->world, &before[0], &before[1], &before[2]);
    nrd_vec4 t = nrd_encode_normal_roughness(nrd_make_vec3((float)normal[0], (float)normal[1], (float)normal[2]), (float)s->roughness, 0, NRD_NORMAL_FORMAT_RGBA16_SNORM, 0);
    put(f, NRD_RESOURCE_IN_NORMAL_ROUGHNESS, i, t.x, t.y, t.z, t.w);
    put(f, NRD_RESOURCE_IN_VIEWZ, i, (s->sky ? 2 * RANGE : s->depth) * sign, 0, 0, 0);
    if (c->motion_mode_plus_1 == NRD_MOTION_WORLD + 1) put(f, NRD_RESOURCE_IN_MV, i, 0, 0, 0, 0);   /* nothing moves */
    else put(f, NRD_RESOURCE_IN_MV, i, before[0] - at[0], before[1] - at[1], (before[2] - at[2]) * sign, 0);
}

static float half(double v) { return half_to_float(half_from_float((float)v)); }

/* Noise of the pixel and frame; a shadow whose border is wide at the left and sharp at the right. */
static void put_signals(fixture *f, const convention *c, uint32_t i, const surface *s, uint32_t frame)
{
    double rows[3][3], along[3], turned[3], length = 0, facing = 0, a = random_at(i, frame, 1), b = random_at(i, frame, 2), place = (i % WIDTH + 0.5) / WIDTH, width = 0.3 * (1 - place);
    turn_of(c, rows);
    for (uint32_t k = 0; k < 3; k++) along[k] = random_at(i, frame, 3 + k) - 0.5 + 0.6 * s->normal[k], length += along[k] * along[k], facing += SUN[k] * s->normal[k];
    rotate(rows, along, turned);
    double row = (i / WIDTH + 0.5) / HEIGHT, w = half(b);
    bool lit = row + (random_at(i, frame, 7) - 0.5) * width > 0.75;
    float penumbra = facing <= 0 ? 0 : lit ? NRD_PENUMBRA_LIT : half(0.02 + 0.3 * width);
    put(f, NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, i, half(2 * a), half(0.2 * a), half(-0.1 * a), w);
    put(f, NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, i, half(b), half(0.1 * b), half(0.1 * b), half(0.1 + 0.1 * a));
    memcpy(texel(f, NRD_RESOURCE_IN_DIFF_SH0, i), texel(f, NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, i), 16);
    memcpy(texel(f, NRD_RESOURCE_IN_SPEC_SH0, i), texel(f, NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, i), 16);
    for (int k = 0; k < 3; k++) turned[k] /= sqrt(length);
    put(f, NRD_RESOURCE_IN_DIFF_SH1, i, turned[0] * 2 * a, turned[1] * 2 * a, turned[2] * 2 * a, 0);
    put(f, NRD_RESOURCE_IN_SPEC_SH1, i, turned[0] * b, turned[1] * b, turned[2] * b, 0);
    put(f, NRD_RESOURCE_IN_DIFF_HITDIST, i, w, 0, 0, 0);
    put(f, NRD_RESOURCE_IN_SPEC_HITDIST, i, half(0.1 + 0.1 * a), 0, 0, 0);
    put(f, NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, i, turned[0] * w, turned[1] * w, turned[2] * w, w);
    put(f, NRD_RESOURCE_IN_PENUMBRA, i, penumbra, 0, 0, 0);
    put(f, NRD_RESOURCE_IN_TRANSLUCENCY, i, lit ? 1 : 0.2, lit ? 1 : 0.4, lit ? 1 : 0.1, 0);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Running  >>run */
static int open_fixture(void **state)
{
    static fixture f;
    nrd_denoiser_desc denoisers[DENOISERS];
    char error[256];
    gpu_desc device = { 0 };
    if (!gpu_open(&f.device, &device, error, sizeof error)) { print_error("%s\n", error); return -1; }
    for (uint32_t i = 0; i < DENOISERS; i++) denoisers[i].identifier = i, denoisers[i].denoiser = (nrd_denoiser)(i + 1);   /* all but the reference */
    nrd_desc desc = spied_desc(&f.spy, denoisers, DENOISERS, WIDTH, HEIGHT, 0);
    desc.normal_encoding = NRD_NORMAL_FORMAT_RGBA16_SNORM;
    assert_int_equal(nrd_create(&desc, &f.instance), NRD_RESULT_OK);
    nrd_vk_desc vk = { .instance = f.instance, .vk_instance = f.device.instance, .physical = f.device.physical, .device = f.device.device,
                       .get_instance_proc = f.device.get_instance_proc, .frames_in_flight = 1 };
    assert_int_equal(nrd_vk_create(&vk, &f.vk), NRD_RESULT_OK);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        VkFormat format = nrd_vk_format(nrd_resource_format((nrd_resource)i));
        if (!nrd_uses_resource(f.instance, (nrd_resource)i)) continue;
        if (format == VK_FORMAT_UNDEFINED) f.in[i] = (float *)calloc(PIXELS, 16);
        else for (int k = 0; k < 2; k++) f.out[k][i] = (float *)calloc(PIXELS, 16);
        assert_true(gpu_image_create(&f.device, WIDTH, HEIGHT, f.in[i] ? VK_FORMAT_R32G32B32A32_SFLOAT : format, nrd_resource_name((nrd_resource)i), &f.images[i]));
    }
    *state = &f;
    return 0;
}

static int close_fixture(void **state)
{
    fixture *f = (fixture *)*state;
    nrd_vk_destroy(f->vk);
    nrd_destroy(f->instance);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        gpu_image_destroy(&f->device, &f->images[i]);
        free(f->in[i]);
        free(f->out[0][i]);
        free(f->out[1][i]);
    }
    gpu_close(&f->device);
    return 0;
}

static void submit(fixture *f, const nrd_frame *frame)
{
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    nrd_vk_frame record = { .images = list };
    memset(list, 0, sizeof list);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        const gpu_image *image = &f->images[i];
        nrd_vk_image given = { (nrd_resource)i, image->image, image->view, image->format, WIDTH, HEIGHT, image->layout, image->layout, 0, 0, 0 };
        if (!image->view) continue;
        if (f->in[i]) assert_true(gpu_upload(&f->device, &f->images[i], f->in[i]));
        list[record.image_count++] = given;
    }
    assert_int_equal(nrd_set_frame(f->instance, frame), NRD_RESULT_OK);
    VkCommandBuffer cmd = gpu_begin(&f->device);
    assert_int_equal(nrd_vk_record(f->vk, cmd, &record), NRD_RESULT_OK);
    assert_true(gpu_submit_and_wait(&f->device));
}

/* Texels of any output as four floats. */
static void download(fixture *f, int slot)
{
    static unsigned char raw[PIXELS * 16];
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (!f->out[slot][i]) continue;
        nrd_format format = nrd_resource_format((nrd_resource)i);
        bool bytes = format == NRD_FORMAT_R8_UNORM || format == NRD_FORMAT_RGBA8_UNORM;
        uint32_t channels = nrd_format_bytes(format) / (bytes ? 1 : 2);
        assert_true(gpu_download(&f->device, &f->images[i], raw));
        for (uint32_t k = 0; k < PIXELS * channels; k++) {
            uint16_t h;
            memcpy(&h, raw + 2 * (bytes ? 0 : k), sizeof h);
            f->out[slot][i][k / channels * 4 + k % channels] = bytes ? (float)raw[k] / 255.0f : half_to_float(h);
        }
    }
}

static nrd_frame frame_of(fixture *f, const convention *c, const pose *now, bool first)
{
    nrd_frame frame = nrd_frame_defaults();
    double rows[3][3];
    nrd_camera camera = pose_camera(now);
    turn_of(c, rows);
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++) {   /* of the turned world: world_to_view times the transposed rotation */
            double sum = 0;
            for (int j = 0; j < 3; j++) sum += (double)camera.world_to_view[4 * j + r] * rows[k][j];
            frame.camera.world_to_view[4 * k + r] = (float)sum;
        }
    memcpy(frame.camera.view_to_clip, camera.view_to_clip, sizeof camera.view_to_clip);
    memcpy(frame.camera.world_to_view + 12, camera.world_to_view + 12, 4 * sizeof(float));
    memcpy(frame.camera.jitter, camera.jitter, sizeof camera.jitter);
    for (int k = 0; k < 3; k++) frame.camera.world_to_view[4 * k + 3] = 0;
    frame.clip_y = pose_clip_y(now);
    frame.denoising_range = RANGE;
    frame.motion_mode = c->motion_mode_plus_1 ? c->motion_mode_plus_1 - 1 : NRD_MOTION_2_5D;
    frame.frame_index = ++f->index;
    frame.restart = first;
    return frame;
}

static void set_light(fixture *f, const convention *c)
{
    double rows[3][3], sun[3];
    turn_of(c, rows);
    rotate(rows, SUN, sun);
    for (uint32_t i = 0; i < DENOISERS; i++) {
        nrd_sigma_settings settings = nrd_sigma_defaults();
        if (nrd_settings_size((nrd_denoiser)(i + 1)) != sizeof settings || !strstr(nrd_denoiser_name((nrd_denoiser)(i + 1)), "sigma")) continue;
        settings.light_x = (float)sun[0], settings.light_y = (float)sun[1], settings.light_z = (float)sun[2], settings.light_radius = SUN_TAN;
        assert_int_equal(nrd_set_settings(f->instance, i, &settings), NRD_RESULT_OK);
    }
}

static void run(fixture *f, const convention *c, int slot)
{
    pose prev = camera_at(c, 0);
    set_light(f, c);
    f->index = 0;   /* patterns and rounding that change with the frame are the same in all runs */
    for (uint32_t step = 0; step < FRAMES; step++) {
        pose now = camera_at(c, step);
        for (uint32_t i = 0; i < PIXELS; i++) {
            surface s = look(&now, (i % WIDTH + 0.5 + now.jitter[0]) / WIDTH, (i / WIDTH + 0.5 + now.jitter[1]) / HEIGHT);
            put_guides(f, c, i, &s, &now, &prev);
            put_signals(f, c, i, &s, step);
        }
        nrd_frame frame = frame_of(f, c, &now, step == 0);
        submit(f, &frame);
        prev = now;
    }
    download(f, slot);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Comparing  >>compare */
/* Outputs in world space. */
static bool is_directed(nrd_resource resource)
{
    return resource == NRD_RESOURCE_OUT_DIFF_DIRECTION_HITDIST || resource == NRD_RESOURCE_OUT_DIFF_SH1 || resource == NRD_RESOURCE_OUT_SPEC_SH1;
}

static void turn_back(const convention *c, const float *from, double to[4])
{
    double rows[3][3];
    turn_of(c, rows);
    for (int k = 0; k < 3; k++) to[k] = rows[0][k] * from[0] + rows[1][k] * from[1] + rows[2][k] * from[2];
    to[3] = from[3];
}

typedef struct difference { double mean, odd; } difference;   /* of the mean of the first; share of pixels that differ by more than 2 % of it */

static difference compare(const fixture *f, const convention *c, nrd_resource resource)
{
    double sum = 0, level = 0;
    uint32_t odd = 0, count = 0;
    for (int pass = 0; pass < 2; pass++)
        for (uint32_t i = 0; i < PIXELS; i++) {
            const float *a = f->out[0][resource] + 4 * (size_t)i, *b = f->out[1][resource] + 4 * (size_t)i;
            double of_a[4] = { a[0], a[1], a[2], a[3] }, of_b[4] = { b[0], b[1], b[2], b[3] }, most = 0;
            if (fabs(f->in[NRD_RESOURCE_IN_VIEWZ][4 * (size_t)i]) >= RANGE) continue;
            if (is_directed(resource)) turn_back(c, b, of_b);
            for (int k = 0; k < 4; k++) most = fmax(most, fabs(of_a[k] - of_b[k]));
            if (pass == 0) { level += fmax(fabs(of_a[0]), fabs(of_a[3])), sum += most, count++; continue; }
            odd += most > 0.02 * level / count;
        }
    difference d = { sum / level, (double)odd / count };
    return d;
}

static void assert_alike(fixture *f, const convention *plain, const convention *varied, double mean, double odd)
{
    run(f, plain, 0);
    run(f, varied, 1);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (!f->out[0][i]) continue;
        difference d = compare(f, varied, (nrd_resource)i);
        if (!(d.mean <= mean && d.odd <= odd)) fail_msg("%s, %s: differs by %g of its mean (%g allowed), in %g of the pixels by much (%g allowed)", varied->name, nrd_resource_name((nrd_resource)i), d.mean, mean, d.odd, odd);
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Tests  >>tests */
static const convention perspective[] = {
    { .name = "again" },
    { .name = "right-handed", .right_handed = true },
    { .name = "clip y down", .clip_y_down = true },
    { .name = "view y down", .view_y_down = true },
    { .name = "reversed", .reversed = true },
    { .name = "infinite", .infinite = true },
    { .name = "reversed infinite", .reversed = true, .infinite = true },
    { .name = "all of it", .right_handed = true, .clip_y_down = true, .reversed = true, .infinite = true },
    { .name = "motion in 2D", .motion_mode_plus_1 = NRD_MOTION_2D + 1 },
    { .name = "motion in the world", .motion_mode_plus_1 = NRD_MOTION_WORLD + 1 },
    { .name = "right-handed, world", .right_handed = true, .motion_mode_plus_1 = NRD_MOTION_WORLD + 1 },
};
static const convention orthographic[] = {
    { .name = "orthographic again", .orthographic = true },
    { .name = "o right-handed", .orthographic = true, .right_handed = true },
    { .name = "o clip y down", .orthographic = true, .clip_y_down = true },
    { .name = "o view y down", .orthographic = true, .view_y_down = true },
    { .name = "o reversed", .orthographic = true, .reversed = true },
    { .name = "o all of it", .orthographic = true, .right_handed = true, .clip_y_down = true, .reversed = true },
    { .name = "o motion in 2D", .orthographic = true, .motion_mode_plus_1 = NRD_MOTION_2D + 1 },
    { .name = "o motion in the world", .orthographic = true, .motion_mode_plus_1 = NRD_MOTION_WORLD + 1 },
};
static const convention turned[] = {
    { .name = "yaw", .turn = { 1.0, 0, 0 } },
    { .name = "pitch", .turn = { 0, 0.7, 0 } },
    { .name = "roll", .turn = { 0, 0, 2.0 } },
    { .name = "yaw, pitch, roll", .turn = { -2.5, 1.1, 0.6 } },
    { .name = "quarter turns", .turn = { 1.5707963267948966, 1.5707963267948966, 0 } },
    { .name = "turned, right-handed", .right_handed = true, .clip_y_down = true, .turn = { 0.5, -0.4, 0.3 } },
    { .name = "turned orthographic", .orthographic = true, .turn = { 0.5, -0.4, 0.3 } },
};
#define COUNT(rows) (sizeof(rows) / sizeof *(rows))

static void a_perspective_is_the_same_in_every_convention(void **state)
{
    for (size_t i = 0; i < COUNT(perspective); i++) assert_alike((fixture *)*state, &perspective[0], &perspective[i], 5e-4, 0.01);
}

static void an_orthographic_view_is_the_same_in_every_convention(void **state)
{
    for (size_t i = 0; i < COUNT(orthographic); i++) assert_alike((fixture *)*state, &orthographic[0], &orthographic[i], 5e-4, 0.01);
}

/* Stored normals round differently. */
static void a_turned_world_is_the_same(void **state)
{
    for (size_t i = 0; i < COUNT(turned); i++)
        assert_alike((fixture *)*state, turned[i].orthographic ? &orthographic[0] : &perspective[0], &turned[i], 0.005, 0.06);
}

/* Other points are seen, but nothing is forgotten for it. */
static void rays_without_jitter_give_the_same(void **state)
{
    static const convention jittered[2] = { { .name = "jittered" }, { .name = "o jittered", .orthographic = true } };
    static const convention still[2] = { { .name = "not jittered", .still_rays = true }, { .name = "o not jittered", .still_rays = true, .orthographic = true } };
    for (int i = 0; i < 2; i++) assert_alike((fixture *)*state, &jittered[i], &still[i], 0.03, 0.25);
}

/* p_view = p_world * M, stored row by row, is p_view = M^T * p_world, stored column by column. */
static void rows_of_row_vectors_are_columns_of_column_vectors(void **state)
{
    pose p = pose_at(1, 2, 3);
    double axes[3][3];
    float m[4][4] = { { 0 } };
    (void)state;
    p.yaw = 0.3, p.pitch = -0.2, p.roll = 0.1;
    pose_axes(&p, axes);
    for (int r = 0; r < 3; r++) for (int c = 0; c < 3; c++) m[r][c] = (float)axes[c][r];
    for (int c = 0; c < 3; c++) m[3][c] = (float)(-axes[c][0] * p.position[0] - axes[c][1] * p.position[1] - axes[c][2] * p.position[2]);
    m[3][3] = 1;
    nrd_camera camera = pose_camera(&p);
    assert_memory_equal(m, camera.world_to_view, sizeof m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_of_row_vectors_are_columns_of_column_vectors),
        cmocka_unit_test(a_perspective_is_the_same_in_every_convention),
        cmocka_unit_test(an_orthographic_view_is_the_same_in_every_convention),
        cmocka_unit_test(a_turned_world_is_the_same),
        cmocka_unit_test(rays_without_jitter_give_the_same),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
