/* What SIGMA promises, on a device: what is sharp stays exact, noise goes only where there is a penumbra, and shadows that move leave no
   trail. The rays are traced here, against a floor and boxes, so that the truth is known. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "denoise_rig.h"

enum { WIDTH = 96, HEIGHT = 64, PIXELS = WIDTH * HEIGHT };

/* ---------------------------------------------------------------------------------------------------------------------------
   A world of boxes on a floor  >>world */
typedef struct box { double low[3], high[3]; } box;

static const double floor_y = -1;
static const double miss = 65504;

/* One that stands on the floor, and a plank that floats high above it. */
static const box boxes[] = { { { -2.0, -1, 3.6 }, { -0.4, 0.1, 4.8 } }, { { 0.2, 1.2, 3.2 }, { 1.6, 1.3, 5.4 } } };
enum { BOXES = sizeof boxes / sizeof boxes[0] };
static double plank_shift, plank_moved;   /* along x: where it is off its place, and since the frame before */

static double ray_box(const box *b, const double from[3], const double along[3], double normal[3])
{
    double enter = -1e30, leave = 1e30;
    int axis = 0;
    for (int k = 0; k < 3; k++) {
        double shift = k == 0 && b == &boxes[1] ? plank_shift : 0, t0 = (b->low[k] + shift - from[k]) / along[k], t1 = (b->high[k] + shift - from[k]) / along[k];
        if (fmin(t0, t1) > enter) enter = fmin(t0, t1), axis = k;
        leave = fmin(leave, fmax(t0, t1));
    }
    for (int k = 0; k < 3; k++) normal[k] = k == axis ? (along[k] > 0 ? -1 : 1) : 0;
    return enter < leave && enter > 1e-6 ? enter : miss;
}

static double trace(const double from[3], const double along[3], double normal[3])
{
    double nearest = along[1] < 0 ? (floor_y - from[1]) / along[1] : miss;
    normal[0] = normal[2] = 0, normal[1] = 1;
    if (nearest < 1e-6) nearest = miss;
    for (int i = 0; i < BOXES; i++) {
        double of_box[3], t = ray_box(&boxes[i], from, along, of_box);
        if (t < nearest) nearest = t, memcpy(normal, of_box, sizeof of_box);
    }
    return nearest;
}

static hit world(const pose *p, double u, double v, uint32_t frame)
{
    double from[3], to[3], along[3];
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 0 };
    (void)frame;
    pose_point(p, u, v, 0, from);
    pose_point(p, u, v, 1, to);
    for (int k = 0; k < 3; k++) along[k] = to[k] - from[k] + 1e-12;
    double ignored[3], depth = trace(from, along, h.normal);
    if (depth < 40) h.depth = depth;
    if (depth == ray_box(&boxes[1], from, along, ignored)) h.moved[0] = -plank_moved;
    return h;
}

static hit bare_floor(const pose *p, double u, double v, uint32_t frame)
{
    static const double point[3] = { 0, -1, 0 }, normal[3] = { 0, 1, 0 };
    hit h = { RIG_SKY, { 0, 1, 0 }, 0, { 0, 0, 0 }, 0 };
    double depth;
    (void)frame;
    if (rig_ray_plane(p, u, v, point, normal, &depth) && depth < 40) h.depth = depth;
    return h;
}

/* A wall in front of another one; region 1 is the one behind. */
static hit two_walls(const pose *p, double u, double v, uint32_t frame)
{
    bool behind = u > 0.4;
    hit h = { behind ? 8 : 5, { 0, 0, -1 }, 0, { 0, 0, 0 }, behind };
    (void)p;
    (void)v;
    (void)frame;
    return h;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Lights  >>lights */
typedef struct light { double at[3]; bool local; double radius; } light; /* as nrd_sigma_settings has it */

static const light sun = { { 0.5, 0.7, 0.35 }, false, 0.12 };
static const light sharp_sun = { { 0.5, 0.7, 0.35 }, false, 1e-4 };
static const light low_sun = { { 1, 0.06, 0.6 }, false, 0.12 };   /* its lower part is below the floor's horizon */
static const light lamp = { { 1.5, 2.5, 6.5 }, true, 0.5 };

static void make_basis(const double n[3], double t[3], double b[3])
{
    double up[3] = { fabs(n[0]) < 0.5, fabs(n[0]) >= 0.5, 0 }, length = 0;
    for (int k = 0; k < 3; k++) t[k] = up[(k + 1) % 3] * n[(k + 2) % 3] - up[(k + 2) % 3] * n[(k + 1) % 3], length += t[k] * t[k];
    for (int k = 0; k < 3; k++) t[k] /= sqrt(length);
    for (int k = 0; k < 3; k++) b[k] = n[(k + 1) % 3] * t[(k + 2) % 3] - n[(k + 2) % 3] * t[(k + 1) % 3];
}

static const double glass[3] = { 0.9, 0.5, 0.15 };

/* What the way along a ray lets through if the plank is of glass. */
static void transmission(const double from[3], const double along[3], double color[3])
{
    double ignored[3];
    for (int k = 0; k < 3; k++) color[k] = ray_box(&boxes[0], from, along, ignored) < miss ? 0 : ray_box(&boxes[1], from, along, ignored) < miss ? glass[k] : 1;
}

/* Distance to the occluder along a ray to the point (s, t) in [0,1) of the light; also the distance of the light. */
static double shadow_ray(const light *l, const double from[3], const double normal[3], double s, double t, double *light_dist, double color[3])
{
    double axis[3], tangent[3], bitangent[3], ignored[3], length = 0, facing = 0, radius = l->radius * sqrt(s), angle = 6.283185307 * t;
    for (int k = 0; k < 3; k++) axis[k] = l->at[k] - (l->local ? from[k] : 0), length += axis[k] * axis[k];
    *light_dist = l->local ? sqrt(length) : 1;
    for (int k = 0; k < 3; k++) axis[k] /= sqrt(length);
    make_basis(axis, tangent, bitangent);
    for (int k = 0; k < 3; k++) facing += axis[k] * normal[k];
    if (facing <= 0) return 0;
    double along[3], start[3], norm = 0;
    for (int k = 0; k < 3; k++) along[k] = *light_dist * axis[k] + radius * (cos(angle) * tangent[k] + sin(angle) * bitangent[k]), norm += along[k] * along[k];
    for (int k = 0; k < 3; k++) along[k] /= sqrt(norm), start[k] = from[k] + 1e-4 * normal[k];
    double distance = trace(start, along, ignored);
    transmission(start, along, color);
    return l->local && distance > sqrt(norm) ? miss : distance;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   A rig with rays  >>rig */
typedef struct shadow_rig {
    rig r;
    nrd_sigma_settings settings;
    uint16_t penumbra[PIXELS];
    uint8_t out[PIXELS];
    uint8_t color[PIXELS][4], out_color[PIXELS][4];   /* SIGMA_SHADOW_TRANSLUCENCY */
} shadow_rig;

static void open_colors(shadow_rig *s, scene *what, nrd_denoiser denoiser)
{
    memset(s, 0, sizeof *s);
    rig_open(&s->r, &device, denoiser, WIDTH, HEIGHT, what);
    s->r.camera = pose_at(0, 2, 0);
    s->r.camera.pitch = 0.55;
    s->r.camera_prev = s->r.camera;
    s->settings = nrd_sigma_defaults();
}

static void open_shadows(shadow_rig *s, scene *what) { open_colors(s, what, NRD_DENOISER_SIGMA_SHADOW); }

static void tell_light(shadow_rig *s, const light *l)
{
    s->settings.light_x = (float)l->at[0];
    s->settings.light_y = (float)l->at[1];
    s->settings.light_z = (float)l->at[2];
    s->settings.light_is_local = l->local;
    s->settings.light_radius = (float)l->radius;
}

static void run_shadows(shadow_rig *s)
{
    rig_put_guides(&s->r);
    assert_true(gpu_upload(&device, &s->r.images[NRD_RESOURCE_IN_PENUMBRA], s->penumbra));
    assert_int_equal(nrd_set_settings(s->r.instance, RIG_IDENTIFIER, &s->settings), NRD_RESULT_OK);
    bool colored = s->r.images[NRD_RESOURCE_IN_TRANSLUCENCY].view != VK_NULL_HANDLE;
    if (colored) assert_true(gpu_upload(&device, &s->r.images[NRD_RESOURCE_IN_TRANSLUCENCY], s->color));
    rig_run(&s->r, true);
    if (colored) assert_true(gpu_download(&device, &s->r.images[NRD_RESOURCE_OUT_SHADOW_TRANSLUCENCY], s->out_color));
    else assert_true(gpu_download(&device, &s->r.images[NRD_RESOURCE_OUT_SHADOW], s->out));
}

/* What a pixel's ray meets, and where. */
static hit look(const shadow_rig *s, uint32_t i, double position[3])
{
    const pose *camera = &s->r.camera;
    double u = (i % WIDTH + 0.5 + camera->jitter[0]) / WIDTH, v = (i / WIDTH + 0.5 + camera->jitter[1]) / HEIGHT;
    hit h = s->r.scene(camera, u, v, s->r.index);
    pose_point(camera, u, v, h.depth, position);
    return h;
}

/* seed: of the light, for rays of their own. */
static uint16_t trace_pixel(const shadow_rig *s, const light *l, uint32_t i, uint32_t seed, const double position[3], const double normal[3], uint8_t color[4])
{
    double light_dist, through[3] = { 0, 0, 0 };
    double distance = shadow_ray(l, position, normal, random_at(i, s->r.index, 2 * seed + 1), random_at(i, s->r.index, 2 * seed + 2), &light_dist, through);
    const float passed[3] = { (float)through[0], (float)through[1], (float)through[2] };
    pack_translucency((float)distance, passed, color);
    return l->local ? pack_local_penumbra((float)distance, (float)light_dist, (float)l->radius) : pack_penumbra((float)distance, (float)l->radius);
}

/* One ray per pixel of this frame. Sky keeps NaN. */
static void trace_rays(shadow_rig *s, const light *l)
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        double position[3];
        hit h = look(s, i, position);
        s->penumbra[i] = h.depth >= RIG_RANGE ? 0x7e00 : trace_pixel(s, l, i, 0, position, h.normal, s->color[i]);
    }
}

static void run_frames(shadow_rig *s, const light *l, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        tell_light(s, l);
        trace_rays(s, l);
        run_shadows(s);
    }
}

static float shown(const shadow_rig *s, uint32_t i) { return pack_unpack_shadow(s->out[i]); }
static float ray(const shadow_rig *s, uint32_t i) { return half_to_float(s->penumbra[i]) >= 65504 ? 1.0f : 0.0f; }

enum { SIDE = 16 };

/* Visibility from SIDE x SIDE rays; -1 where there is none: sky, or facing away. */
static void find_truth(const shadow_rig *s, const light *l, float *truth)
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        double position[3], light_dist, color[3], lit = 0;
        hit h = look(s, i, position);
        bool faces = h.depth < RIG_RANGE && shadow_ray(l, position, h.normal, 0, 0, &light_dist, color) > 0;
        for (int k = 0; faces && k < SIDE * SIDE; k++)
            lit += shadow_ray(l, position, h.normal, (k % SIDE + 0.5) / SIDE, (k / SIDE + 0.5) / SIDE, &light_dist, color) >= miss;
        truth[i] = faces ? (float)(lit / (SIDE * SIDE)) : -1;
    }
}

typedef float value_of(const shadow_rig *s, uint32_t i);

/* Mean squared error over pixels that face the light. */
static double error_of(const shadow_rig *s, value_of *value, const float *truth)
{
    double sum = 0;
    int count = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        if (truth[i] < 0) continue;
        double error = value(s, i) - truth[i];
        sum += error * error;
        count++;
    }
    return sum / count;
}

/* True where the truth is `what` at a pixel and everywhere `reach` pixels around it. */
static bool all_around(const float *truth, uint32_t i, int reach, float what)
{
    for (int y = -reach; y <= reach; y++)
        for (int x = -reach; x <= reach; x++) {
            int px = (int)(i % WIDTH) + x, py = (int)(i / WIDTH) + y;
            if (px < 0 || py < 0 || px >= WIDTH || py >= HEIGHT || truth[py * WIDTH + px] != what) return false;
        }
    return true;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   What is not noisy  >>exact */
static void assert_constant(float occluder_dist, uint8_t expected)
{
    shadow_rig s;
    open_shadows(&s, world);
    tell_light(&s, &sun);
    for (int frame = 0; frame < 3; frame++) {
        for (uint32_t i = 0; i < PIXELS; i++) s.penumbra[i] = pack_penumbra(occluder_dist, (float)sun.radius);
        run_shadows(&s);
        for (uint32_t i = 0; i < PIXELS; i++)
            if (s.r.hits[i].depth < RIG_RANGE && s.out[i] != expected) fail_msg("distance %g, pixel %u: %u, expected %u", (double)occluder_dist, i, s.out[i], expected);
    }
    rig_close(&s.r);
}

static void constant_light_and_shadow_pass_through_exactly(void **state)
{
    (void)state;
    assert_constant(65504, 255);
    assert_constant(INFINITY, 255);
    assert_constant(3, 0);
    assert_constant(1e-7f, 0);
    assert_constant(0, 0);
}

/* A light of next to no size: every ray is the truth. */
static void sharp_shadows_are_the_rays_bit_for_bit(void **state)
{
    static shadow_rig s;
    (void)state;
    open_shadows(&s, world);
    for (int frame = 0; frame < 6; frame++) {
        run_frames(&s, &sharp_sun, 1);
        for (uint32_t i = 0; i < PIXELS; i++)
            if (s.r.hits[i].depth < RIG_RANGE && s.out[i] != (uint8_t)(255 * ray(&s, i))) fail_msg("frame %d, pixel %u: %u", frame, i, s.out[i]);
    }
    rig_close(&s.r);
}

static void shadows_do_not_leak_across_edges_of_depth(void **state)
{
    static shadow_rig s;
    (void)state;
    open_shadows(&s, two_walls);
    tell_light(&s, &sun);
    for (int frame = 0; frame < 4; frame++) {
        for (uint32_t i = 0; i < PIXELS; i++) s.penumbra[i] = pack_penumbra((i % WIDTH + 0.5) / WIDTH > 0.4 ? 20 : 65504, (float)sun.radius);
        run_shadows(&s);
        for (uint32_t i = 0; i < PIXELS; i++) assert_int_equal(s.out[i], s.r.hits[i].region ? 0 : 255);
    }
    rig_close(&s.r);
}

static void umbra_stays_black_and_light_stays_white(void **state)
{
    static shadow_rig s;
    static float truth[PIXELS];
    int black = 0, white = 0;
    (void)state;
    open_shadows(&s, world);
    find_truth(&s, &sun, truth);
    for (int frame = 0; frame < 12; frame++) {
        run_frames(&s, &sun, 1);
        for (uint32_t i = 0; i < PIXELS; i++) {
            if (all_around(truth, i, 4, 0)) assert_int_equal(s.out[i], 0), black++;
            if (all_around(truth, i, 4, 1)) assert_int_equal(s.out[i], 255), white++;
        }
    }
    print_message("%d black, %d white\n", black, white);
    assert_true(black > 100 && white > 5000);
    rig_close(&s.r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   What is noisy  >>noise */
typedef struct errors { double noisy, denoised; } errors;

typedef enum camera_kind { LEFT_HANDED, RIGHT_HANDED, ORTHOGRAPHIC } camera_kind; /* a right-handed one moves forwards, others sideways */

static errors errors_after(const light *l, const light *told, uint32_t frames, double speed, camera_kind kind)
{
    static shadow_rig s;
    static float truth[PIXELS];
    open_shadows(&s, world);
    s.r.camera.orthographic = kind == ORTHOGRAPHIC;
    s.r.camera.right_handed = kind == RIGHT_HANDED;
    if (kind == ORTHOGRAPHIC) s.r.camera.tan_half_height = 2;
    s.r.camera_prev = s.r.camera;
    for (uint32_t i = 0; i < frames; i++) {
        trace_rays(&s, l);
        tell_light(&s, told);
        if (i + 1 == frames) find_truth(&s, l, truth);
        run_shadows(&s);
        if (i + 1 < frames) s.r.camera.position[kind == RIGHT_HANDED ? 2 : 0] += speed;
        s.r.frame.denoising_range = i % 2 ? RIG_RANGE : 0.7f * RIG_RANGE;
    }
    errors e = { error_of(&s, ray, truth), error_of(&s, shown, truth) };
    rig_close(&s.r);
    return e;
}

static void assert_error(const char *what, errors e, double most)
{
    print_message("%s: squared error of a ray %.5f, denoised %.5f\n", what, e.noisy, e.denoised);
    if (!(e.denoised < most * e.noisy)) fail_msg("%s: the error is %g of the input's, allowed is %g", what, e.denoised / e.noisy, most);
}

static void penumbrae_lose_their_noise(void **state)
{
    static const light unknown = { { 0, 0, 0 }, false, 0 };
    (void)state;
    assert_error("one frame", errors_after(&sun, &sun, 1, 0, LEFT_HANDED), 0.2);
    assert_error("16 frames", errors_after(&sun, &sun, 16, 0, LEFT_HANDED), 0.02);
    assert_error("moving camera", errors_after(&sun, &sun, 16, 0.03, LEFT_HANDED), 0.02);
    assert_error("camera moving forwards", errors_after(&sun, &sun, 16, 0.1, RIGHT_HANDED), 0.03);
    assert_error("orthographic", errors_after(&sun, &sun, 16, 0, ORTHOGRAPHIC), 0.03);
    assert_error("unknown light", errors_after(&sun, &unknown, 16, 0, LEFT_HANDED), 0.03);
    assert_error("sun cut by the horizon", errors_after(&low_sun, &low_sun, 16, 0, LEFT_HANDED), 0.05);
    assert_error("local light", errors_after(&lamp, &lamp, 16, 0, LEFT_HANDED), 0.02);
    assert_error("local light, moving camera", errors_after(&lamp, &lamp, 16, 0.03, LEFT_HANDED), 0.03);
}

/* A floor that the camera skims, where every other ray is blocked far away: what is left of the noise, with rays through the middle of
   the pixels or anywhere. */
static double skimming_error(double jitter)
{
    static shadow_rig s;
    static float half[PIXELS];
    open_shadows(&s, bare_floor);
    s.r.camera.position[1] = -0.85;
    s.r.camera.pitch = 0.1;
    tell_light(&s, &sun);
    for (uint32_t frame = 0; frame < 24; frame++) {
        for (uint32_t i = 0; i < PIXELS; i++) s.penumbra[i] = pack_penumbra(random_at(i, frame, 3) < 0.5 ? 65504 : 8, (float)sun.radius);
        for (int k = 0; k < 2; k++) s.r.camera.jitter[k] = jitter * (random_at((uint32_t)k, frame, 4) - 0.5);
        run_shadows(&s);
    }
    for (uint32_t i = 0; i < PIXELS; i++) half[i] = s.r.hits[i].depth < RIG_RANGE ? 0.5f : -1;
    rig_close(&s.r);
    return error_of(&s, shown, half);
}

/* Depths belong to the rays, not to the middle of the pixels. */
static void jittered_rays_keep_their_history(void **state)
{
    double jittered = skimming_error(1), still = skimming_error(0);
    (void)state;
    print_message("squared error with jitter %.6f, without %.6f\n", jittered, still);
    assert_true(jittered < 1.1 * still);
}

/* The mean over the picture is what the rays say, within noise. */
static void penumbrae_keep_their_light(void **state)
{
    static shadow_rig s;
    static float truth[PIXELS];
    double sum = 0, expected = 0;
    (void)state;
    open_shadows(&s, world);
    find_truth(&s, &sun, truth);
    run_frames(&s, &sun, 8);
    for (int frame = 0; frame < 8; frame++) {
        run_frames(&s, &sun, 1);
        for (uint32_t i = 0; i < PIXELS; i++)
            if (truth[i] >= 0) sum += shown(&s, i), expected += truth[i];
    }
    print_message("mean %.5f of the truth\n", sum / expected);
    assert_true(fabs(sum / expected - 1) < 0.005);
    rig_close(&s.r);
}

/* Within two pixels of a box: where it stands on the floor, and where it is seen before the floor. */
static bool is_near_box(const shadow_rig *s, uint32_t i)
{
    bool box = false, floor = false;
    for (int k = 0; k < 25; k++) {
        int x = (int)(i % WIDTH) + k % 5 - 2, y = (int)(i / WIDTH) + k / 5 - 2;
        const hit *h = &s->r.hits[(size_t)(y < 0 ? 0 : y >= HEIGHT ? HEIGHT - 1 : y) * WIDTH + (size_t)(x < 0 ? 0 : x >= WIDTH ? WIDTH - 1 : x)];
        floor |= h->normal[1] > 0.5;
        box |= h->normal[1] < 0.5;
    }
    return box && floor;
}

static void contact_shadows_are_no_worse_than_others(void **state)
{
    static shadow_rig s;
    static float contact[PIXELS], others[PIXELS], truth[PIXELS];
    (void)state;
    open_shadows(&s, world);
    find_truth(&s, &sun, truth);
    run_frames(&s, &sun, 12);
    for (uint32_t i = 0; i < PIXELS; i++) {
        bool near = is_near_box(&s, i);
        contact[i] = near ? truth[i] : -1;
        others[i] = !near && truth[i] > 0 && truth[i] < 1 ? truth[i] : -1;
    }
    double at_contact = sqrt(error_of(&s, shown, contact)), elsewhere = sqrt(error_of(&s, shown, others));
    print_message("error at contacts %.4f, in penumbrae elsewhere %.4f\n", at_contact, elsewhere);
    assert_true(at_contact < 1.3 * elsewhere);
    rig_close(&s.r);
}

/* Something jumps after 16 frames: the light, or the plank by `shift`. Error of each frame after that, against that of a denoiser that has seen nothing
   before, and against the rays. The same rays in both, so that the first ratio is 1 where nothing of the past is left. */
enum { AFTER = 8 };
typedef struct trail { double moved[AFTER], fresh[AFTER], rays[AFTER]; } trail;

static trail trail_after(const light *before, const light *after, double shift)
{
    static shadow_rig moved, fresh;
    static float truth[PIXELS];
    trail t;
    open_shadows(&moved, world);
    open_shadows(&fresh, world);
    run_frames(&moved, before, 16);
    fresh.r.index = moved.r.index;
    plank_shift = plank_moved = shift;
    for (int k = 0; k < AFTER; k++) {
        run_frames(&moved, after, 1);
        run_frames(&fresh, after, 1);
        plank_moved = 0;
        if (k == 0) find_truth(&fresh, after, truth);
        t.moved[k] = error_of(&moved, shown, truth);
        t.fresh[k] = error_of(&fresh, shown, truth);
        t.rays[k] = error_of(&moved, ray, truth);
    }
    plank_shift = 0;
    rig_close(&moved.r);
    rig_close(&fresh.r);
    return t;
}

static void nothing_that_moves_leaves_a_trail(void **state)
{
    static const light noon = { { -0.4, 0.8, 0.3 }, false, 0.12 }, later = { { 0.47, 0.7, 0.38 }, false, 0.12 }, narrow = { { 0.5, 0.7, 0.35 }, false, 0.02 };
    static const light narrow_later = { { 0.47, 0.7, 0.38 }, false, 0.02 }, other_lamp = { { 1.1, 2.5, 6.5 }, true, 0.5 };
    /* fourth: most that the error of the fourth frame may be, of that of a fresh start; 1.15 after it. */
    static const struct { const char *what; const light *before, *after; double shift, fourth; } rows[] = {
        { "sun jumps", &noon, &sun, 0, 1.05 }, { "sun moves by 3 degrees", &later, &sun, 0, 1 }, { "small sun moves by 3 degrees", &narrow_later, &narrow, 0, 1.05 },
        { "lamp moves", &other_lamp, &lamp, 0, 1 }, { "plank jumps", &sun, &sun, 1.0, 1.25 }, { "plank moves", &sun, &sun, 0.1, 1.1 },
        { "plank moves, small sun", &narrow, &narrow, 0.1, 1.1 } };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        trail t = trail_after(rows[i].before, rows[i].after, rows[i].shift);
        print_message("%s: error of that of a fresh start, frame by frame:", rows[i].what);
        for (int k = 0; k < AFTER; k++) print_message(" %.2f", t.moved[k] / t.fresh[k]);
        print_message("; of the rays':");
        for (int k = 0; k < AFTER; k++) print_message(" %.2f", t.moved[k] / t.rays[k]);
        print_message("\n");
        for (int k = 0; k < AFTER; k++) {
            if (k >= 3 && !(t.moved[k] <= (k == 3 ? rows[i].fourth : 1.15) * t.fresh[k])) fail_msg("%s: frame %d after it has %g of the error of a fresh start", rows[i].what, k + 1, t.moved[k] / t.fresh[k]);
            if (!(t.moved[k] <= t.rays[k])) fail_msg("%s: frame %d after it has %g of the error of the rays", rows[i].what, k + 1, t.moved[k] / t.rays[k]);
        }
    }
}

/* Mean of (d - r)^2 / (r^2 + 0.01): what is a little bright in an umbra counts much. */
static double relative_error_of(const shadow_rig *s, value_of *value, const float *truth)
{
    double sum = 0;
    int count = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        if (truth[i] < 0) continue;
        double error = value(s, i) - truth[i];
        sum += error * error / (truth[i] * truth[i] + 0.01);
        count++;
    }
    return sum / count;
}

/* A small sun that turns by degrees: edges a pixel or less wide pass over the floor, and no history may hold them back. */
static void slow_narrow_edges_are_no_worse_than_the_rays(void **state)
{
    static shadow_rig s;
    static float truth[PIXELS];
    double noisy = 0, denoised = 0;
    (void)state;
    open_shadows(&s, world);
    for (int frame = 0; frame < 24; frame++) {
        const light turning = { { 0.5 + 0.004 * frame, 0.7, 0.35 - 0.004 * frame }, false, 0.02 };
        run_frames(&s, &turning, 1);
        if (frame < 16) continue;
        find_truth(&s, &turning, truth);
        noisy += relative_error_of(&s, ray, truth) / 8;
        denoised += relative_error_of(&s, shown, truth) / 8;
    }
    print_message("relative error of a ray %.5f, denoised %.5f\n", noisy, denoised);
    assert_true(denoised < noisy);
    rig_close(&s.r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Colour and many lights  >>colour */
/* Coloured visibility from SIDE x SIDE rays; -1 where there is none. */
static void find_color(const shadow_rig *s, const light *l, float (*truth)[3])
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        double position[3], light_dist, color[3], sum[3] = { 0, 0, 0 };
        hit h = look(s, i, position);
        bool faces = h.depth < RIG_RANGE && shadow_ray(l, position, h.normal, 0, 0, &light_dist, color) > 0;
        for (int k = 0; faces && k < SIDE * SIDE; k++) {
            bool reached = shadow_ray(l, position, h.normal, (k % SIDE + 0.5) / SIDE, (k / SIDE + 0.5) / SIDE, &light_dist, color) >= miss;
            for (int c = 0; c < 3; c++) sum[c] += reached ? 1 : color[c];
        }
        for (int c = 0; c < 3; c++) truth[i][c] = faces ? (float)(sum[c] / (SIDE * SIDE)) : -1;
    }
}

/* Mean squared error of the input and of the output, over channels and pixels that some light faces. */
static errors color_errors(const shadow_rig *s, float (*truth)[3])
{
    errors e = { 0, 0 };
    int count = 0;
    for (uint32_t i = 0; i < PIXELS; i++)
        for (int c = 0; c < 3 && truth[i][0] >= 0; c++, count++) {
            double noisy = s->color[i][c] / 255.0 - truth[i][c], denoised = pack_unpack_shadow(s->out_color[i][c]) - truth[i][c];
            e.noisy += noisy * noisy;
            e.denoised += denoised * denoised;
        }
    e.noisy /= count;
    e.denoised /= count;
    return e;
}

static void shadows_of_glass_lose_their_noise_and_keep_their_colour(void **state)
{
    static shadow_rig s;
    static float truth[PIXELS][3];
    double sum[3] = { 0, 0, 0 }, expected[3] = { 0, 0, 0 };
    (void)state;
    open_colors(&s, world, NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY);
    find_color(&s, &sun, truth);
    run_frames(&s, &sun, 1);
    assert_error("glass, one frame", color_errors(&s, truth), 0.25);
    run_frames(&s, &sun, 15);
    assert_error("glass, 16 frames", color_errors(&s, truth), 0.05);
    for (uint32_t i = 0; i < PIXELS; i++)
        for (int c = 0; c < 3 && truth[i][0] >= 0; c++) sum[c] += pack_unpack_shadow(s.out_color[i][c]), expected[c] += truth[i][c];
    for (int c = 0; c < 3; c++) assert_true(fabs(sum[c] / expected[c] - 1) < 0.01);
    rig_close(&s.r);
}

static void without_glass_both_denoisers_agree(void **state)
{
    static shadow_rig plain, colored;
    (void)state;
    open_shadows(&plain, world);
    open_colors(&colored, world, NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY);
    tell_light(&plain, &sun);
    tell_light(&colored, &sun);
    for (int frame = 0; frame < 6; frame++) {
        trace_rays(&plain, &sun);
        memcpy(colored.penumbra, plain.penumbra, sizeof plain.penumbra);
        run_shadows(&plain);
        run_shadows(&colored);
        for (uint32_t i = 0; i < PIXELS; i++)
            for (int c = 0; c < 3; c++)
                if (plain.r.hits[i].depth < RIG_RANGE && colored.out_color[i][c] != plain.out[i])
                    fail_msg("frame %d, pixel %u, channel %d: %u, opaque %u", frame, i, c, colored.out_color[i][c], plain.out[i]);
    }
    rig_close(&plain.r);
    rig_close(&colored.r);
}

enum { MANY = 8 };

/* Lamps in a ring, each of its own colour. */
static light lamp_of(int i)
{
    double angle = 6.283185307 * i / MANY;
    light l = { { 3 * cos(angle), 3, 4 + 3 * sin(angle) }, true, 0.35 };
    return l;
}

/* Unshadowed light of a lamp at a point; 0 where it faces away. */
static void shine(const light *l, int i, const double position[3], const double normal[3], double color[3])
{
    double toward[3], squared = 0, facing = 0;
    for (int k = 0; k < 3; k++) toward[k] = l->at[k] - position[k], squared += toward[k] * toward[k];
    for (int k = 0; k < 3; k++) facing += toward[k] * normal[k] / sqrt(squared);
    for (int k = 0; k < 3; k++) color[k] = fmax(facing, 0) / squared * (1 + 0.8 * cos(i + 2.1 * k));
}

/* nrd_light_sum_*() of nrd.glsl. truth: NULL to trace one ray a light into the input; else SIDE * SIDE / 4. */
static void sum_lights(shadow_rig *s, int lights, float (*truth)[3])
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        double position[3], unshadowed[3] = { 0 }, shadowed[3] = { 0 }, widths = 0, weights = 0;
        hit h = look(s, i, position);
        for (int n = 0; n < lights && h.depth < RIG_RANGE; n++) {
            light l = lamp_of(n);
            double color[3], through[3], light_dist, seen = 0;
            uint8_t texel[4];
            shine(&l, n, position, h.normal, color);
            uint16_t penumbra = trace_pixel(s, &l, i, (uint32_t)n + 1, position, h.normal, texel);
            seen = half_to_float(penumbra) >= 65504;
            if (truth) seen = 0;
            for (int k = 0; truth && k < SIDE * SIDE / 4; k++)
                seen += 4.0 / (SIDE * SIDE) * (shadow_ray(&l, position, h.normal, (k % (SIDE / 2) + 0.5) * 2 / SIDE, (k / (SIDE / 2) + 0.5) * 2 / SIDE, &light_dist, through) >= miss);
            double luma = (color[0] + 2 * color[1] + color[2]) / 4 * (1 - seen);
            if (half_to_float(penumbra) > 0 && half_to_float(penumbra) < 65504) widths += luma * half_to_float(penumbra), weights += luma;
            for (int k = 0; k < 3; k++) unshadowed[k] += color[k], shadowed[k] += color[k] * seen;
        }
        bool faces = unshadowed[1] > 0;
        for (int k = 0; k < 3; k++) {
            float ratio = faces ? (float)fmin(shadowed[k] / fmax(unshadowed[k], 1e-6), 1) : 0;
            if (truth) truth[i][k] = faces ? ratio : -1;
            else s->color[i][k] = (uint8_t)(255 * ratio + 0.5f);
        }
        if (!truth) s->penumbra[i] = half_from_float(weights > 0 ? (float)(widths / weights) : faces ? 65504 : 0);
    }
}

static void many_lights_share_one_signal(void **state)
{
    static shadow_rig s;
    static float truth[PIXELS][3];
    (void)state;
    for (int lights = 1; lights <= MANY; lights *= 2) {
        char what[32];
        open_colors(&s, world, NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY);   /* of no known light */
        sum_lights(&s, lights, truth);
        for (int frame = 0; frame < 12; frame++) {
            sum_lights(&s, lights, NULL);
            run_shadows(&s);
        }
        snprintf(what, sizeof what, "%d lights", lights);
        assert_error(what, color_errors(&s, truth), 0.15);
        rig_close(&s.r);
    }
}

/* Many lights in turn through one denoiser: one that is restarted gives what a new one gives, whichever lamp it saw before. */
static void a_restarted_denoiser_knows_no_other_light(void **state)
{
    static shadow_rig used, fresh;
    (void)state;
    open_shadows(&used, world);
    open_shadows(&fresh, world);
    run_frames(&used, &lamp, 5);
    fresh.r.index = used.r.index;
    used.r.frame.restart = fresh.r.frame.restart = 1;
    run_frames(&used, &sun, 1);
    run_frames(&fresh, &sun, 1);
    assert_memory_equal(used.out, fresh.out, sizeof used.out);
    rig_close(&used.r);
    rig_close(&fresh.r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Containment  >>containment */
static void equal_inputs_give_equal_bits(void **state)
{
    static shadow_rig a, b;
    (void)state;
    open_shadows(&a, world);
    open_shadows(&b, world);
    run_frames(&a, &sun, 6);
    run_frames(&b, &sun, 6);
    assert_memory_equal(a.out, b.out, sizeof a.out);
    rig_close(&a.r);
    rig_close(&b.r);
}

/* What lies outside the rectangle, and where the rectangle lies in the guides, does not matter. */
static void only_the_rectangle_is_read(void **state)
{
    static shadow_rig part, again;
    (void)state;
    for (int poisoned = 0; poisoned < 2; poisoned++) {
        shadow_rig *s = poisoned ? &again : &part;
        open_shadows(s, world);
        s->r.rect_width = 61;
        s->r.rect_height = 43;
        s->r.origin_x = poisoned ? 20 : 0;
        s->r.origin_y = poisoned ? 13 : 0;
        tell_light(s, &sun);
        for (uint32_t i = 0; poisoned && i < PIXELS; i++) s->r.view_z[i] = 3;
        for (int frame = 0; frame < 5; frame++) {
            for (uint32_t i = 0; i < PIXELS; i++) {
                bool inside = i % WIDTH < 61 && i / WIDTH < 43;
                s->penumbra[i] = inside ? pack_penumbra(random_at(i, (uint32_t)frame, 3) < i % WIDTH / 61.0 ? 65504 : 2, (float)sun.radius) : poisoned ? 0x7e00 : 0;
            }
            run_shadows(s);
        }
    }
    for (uint32_t i = 0; i < PIXELS; i++)
        if (i % WIDTH < 61 && i / WIDTH < 43 && part.r.hits[i / WIDTH * 61 + i % WIDTH].depth < RIG_RANGE) assert_int_equal(part.out[i], again.out[i]);
    rig_close(&part.r);
    rig_close(&again.r);
}

/* A ray that is not a number is dark and hurts nobody else. */
static void rays_that_are_no_numbers_are_contained(void **state)
{
    static shadow_rig s;
    (void)state;
    open_shadows(&s, world);
    for (int frame = 0; frame < 4; frame++) {
        trace_rays(&s, &sun);
        tell_light(&s, &sun);
        for (uint32_t i = 0; i < PIXELS; i += 7) s.penumbra[i] = i % 2 ? 0x7e00 : 0xfc00;   /* NaN, -Inf */
        run_shadows(&s);
        for (uint32_t i = 0; i < PIXELS; i++) {
            if (s.r.hits[i].depth >= RIG_RANGE) continue;
            if (i % 7 == 0) assert_int_equal(s.out[i], 0);
            else if (ray(&s, i) == 1) assert_true(s.out[i] > 0);
        }
    }
    run_frames(&s, &sun, 2);
    for (uint32_t i = 0; i < PIXELS; i += 7)
        if (s.r.hits[i].depth < RIG_RANGE && ray(&s, i) == 1) assert_true(s.out[i] > 0);
    rig_close(&s.r);
}

static void settings_of_zero_show_the_rays(void **state)
{
    static shadow_rig s;
    (void)state;
    open_shadows(&s, world);
    s.settings.max_accumulated_frames = s.settings.max_stabilized_frames = s.settings.penumbra_blur_scale = 0;
    run_frames(&s, &sun, 4);
    for (uint32_t i = 0; i < PIXELS; i++)
        if (s.r.hits[i].depth < RIG_RANGE) assert_int_equal(s.out[i], (uint8_t)(255 * ray(&s, i)));
    rig_close(&s.r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constant_light_and_shadow_pass_through_exactly),
        cmocka_unit_test(sharp_shadows_are_the_rays_bit_for_bit),
        cmocka_unit_test(shadows_do_not_leak_across_edges_of_depth),
        cmocka_unit_test(umbra_stays_black_and_light_stays_white),
        cmocka_unit_test(penumbrae_lose_their_noise),
        cmocka_unit_test(jittered_rays_keep_their_history),
        cmocka_unit_test(penumbrae_keep_their_light),
        cmocka_unit_test(contact_shadows_are_no_worse_than_others),
        cmocka_unit_test(nothing_that_moves_leaves_a_trail),
        cmocka_unit_test(slow_narrow_edges_are_no_worse_than_the_rays),
        cmocka_unit_test(shadows_of_glass_lose_their_noise_and_keep_their_colour),
        cmocka_unit_test(without_glass_both_denoisers_agree),
        cmocka_unit_test(many_lights_share_one_signal),
        cmocka_unit_test(a_restarted_denoiser_knows_no_other_light),
        cmocka_unit_test(equal_inputs_give_equal_bits),
        cmocka_unit_test(only_the_rectangle_is_read),
        cmocka_unit_test(rays_that_are_no_numbers_are_contained),
        cmocka_unit_test(settings_of_zero_show_the_rays),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
