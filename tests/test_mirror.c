/* Flat mirrors in motion: what the denoiser shows in them against an accumulation that knows where every reflection was. */
#define RIG_SPECULAR
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "denoise_rig.h"
#include "nrd_shaders/nrd_c.h"

enum { WIDTH = 96, HEIGHT = 64, PIXELS = WIDTH * HEIGHT, FRAMES = 48, MARGIN = 4, TRUTH_SAMPLES = 256 };
static const double POINT[3] = { 0, -1, 4 }, NORMAL[3] = { 0.05, 0.98, -0.1 };   /* of the mirror; made of unit length */
static const double PI = 3.14159265358979;

static float noisy[FRAMES][PIXELS];
static pose poses[FRAMES];

typedef struct camera_path { const char *name; double move[3], turn[3], jitter; } camera_path;   /* turn: yaw, pitch, roll; each per frame */

/* ---------------------------------------------------------------------------------------------------------------------------
   The mirrored world  >>world */
static double dot3(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void normalize3(double v[3])
{
    double length = sqrt(dot3(v, v));
    for (int k = 0; k < 3; k++) v[k] /= length;
}

static void mirror_normal(double n[3])
{
    memcpy(n, NORMAL, sizeof NORMAL);
    normalize3(n);
}

static hit mirror_hit(const pose *p, double u, double v, uint32_t frame)
{
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 0 };
    double depth;
    (void)frame;
    mirror_normal(h.normal);
    if (rig_ray_plane(p, u, v, POINT, h.normal, &depth) && depth < RIG_RANGE) h.depth = depth;
    return h;
}

/* Soft blocks on a ceiling at y = 4 and a wall at z = 12. Returns the distance. */
static double trace_world(const double from[3], const double along[3], double *light)
{
    double up = along[1] > 0 ? (4 - from[1]) / along[1] : 1e9, ahead = along[2] > 0 ? (12 - from[2]) / along[2] : 1e9, t = fmin(fmin(up, ahead), 100);
    double x = from[0] + t * along[0], y = up < ahead ? from[2] + t * along[2] : from[1] + t * along[1];
    *light = 1 + 0.8 * tanh(2 * sin(2.2 * x) * sin(2.2 * y)) + (up < ahead ? 0 : 0.5);
    return t;
}

static void reflected(const double in[3], const double n[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = in[k] - 2 * dot3(in, n) * n[k];
}

/* The half vector of GGX whose tangent of the angle to the normal is alpha * sqrt(a / (1 - a)). */
static void micro_normal(double roughness, double a, double b, double m[3])
{
    double n[3], tangent[3] = { 1, 0, 0 }, bitangent[3], slope = roughness * roughness * sqrt(a / (1 - a));
    mirror_normal(n);
    for (int k = 0; k < 3; k++) tangent[k] -= n[0] * n[k];
    normalize3(tangent);
    for (int k = 0; k < 3; k++) bitangent[k] = n[(k + 1) % 3] * tangent[(k + 2) % 3] - n[(k + 2) % 3] * tangent[(k + 1) % 3];
    for (int k = 0; k < 3; k++) m[k] = n[k] + slope * (cos(2 * PI * b) * tangent[k] + sin(2 * PI * b) * bitangent[k]);
    normalize3(m);
}

/* One path. point: on the mirror. Returns the hit distance. */
static double trace(const pose *p, const double point[3], double roughness, double a, double b, double *light)
{
    double in[3], m[3], out[3];
    for (int k = 0; k < 3; k++) in[k] = point[k] - p->position[k];
    normalize3(in);
    micro_normal(roughness, a, b, m);
    reflected(in, m, out);
    return trace_world(point, out, light);
}

static void mirror_point(const pose *p, double u, double v, double point[3]) { pose_point(p, u, v, mirror_hit(p, u, v, 0).depth, point); }

/* ---------------------------------------------------------------------------------------------------------------------------
   Both accumulations  >>runs */
static void add_frame(rig *r, uint32_t frame)
{
    nrd_vec4 parameters = { r->settings.hit_distance_a, r->settings.hit_distance_b, r->settings.hit_distance_c, r->settings.hit_distance_d };
    poses[frame] = r->camera;
    rig_put_guides(r);
    for (uint32_t i = 0; i < PIXELS; i++) {
        double point[3], light;
        const pose *p = &r->camera;
        mirror_point(p, (i % WIDTH + 0.5 + p->jitter[0]) / WIDTH, (i / WIDTH + 0.5 + p->jitter[1]) / HEIGHT, point);
        double distance = trace(p, point, r->roughness, random_at(i, frame, 1), random_at(i, frame, 2), &light);
        noisy[frame][i] = (float)(light * -log(1 - random_at(i, frame, 3)));
        texel t = { noisy[frame][i], 0, 0, nrd_normalize_hit_dist((float)distance, r->view_z[i], r->roughness, parameters) };
        rig_put_noisy(r, i % WIDTH, i / WIDTH, t);
    }
    rig_run(r, true);
}

static void follow(rig *r, const camera_path *path, float roughness, bool stabilized)
{
    rig_open(r, &device, RIG_DENOISER, WIDTH, HEIGHT, mirror_hit);
    r->roughness = roughness;
    if (!stabilized) r->settings.max_stabilized_frames = 0;
    for (uint32_t i = 0; i < FRAMES; i++) {
        double t = i - 0.5 * FRAMES;
        r->camera = pose_at(t * path->move[0], t * path->move[1], t * path->move[2]);
        r->camera.aspect = (double)WIDTH / HEIGHT;
        r->camera.yaw = t * path->turn[0];
        r->camera.pitch = 0.6 + t * path->turn[1];
        r->camera.roll = t * path->turn[2];
        r->camera.jitter[0] = path->jitter * (0.5 * (i % 2) - 0.25), r->camera.jitter[1] = path->jitter * (0.3 * (i % 3) - 0.3);
        if (i == 0) r->camera_prev = r->camera;
        add_frame(r, i);
    }
    rig_download(r);
}

/* Where what a mirror shows at (u, v) seems to be. */
static void image_point(const pose *p, double u, double v, double image[3])
{
    double point[3], n[3], light;
    mirror_point(p, u, v, point);
    mirror_normal(n);
    double along[3] = { point[0] - p->position[0], point[1] - p->position[1], point[2] - p->position[2] };
    normalize3(along);
    double distance = trace(p, point, 0, 0, 0, &light);
    for (int k = 0; k < 3; k++) image[k] = point[k] + distance * along[k];
}

/* Mean of what the last frames showed of it, each interpolated once. */
static double accumulated(uint32_t x, uint32_t y, uint32_t length)
{
    double image[3], sum = 0, count = 0;
    image_point(&poses[FRAMES - 1], (x + 0.5) / WIDTH, (y + 0.5) / HEIGHT, image);
    for (uint32_t i = FRAMES - length; i < FRAMES; i++) {
        double u, v, depth;
        pose_project(&poses[i], image, &u, &v, &depth);
        double px = u * WIDTH - 0.5 - poses[i].jitter[0], py = v * HEIGHT - 0.5 - poses[i].jitter[1], fx = px - floor(px), fy = py - floor(py);
        if (!(px >= 0 && py >= 0 && px < WIDTH - 1 && py < HEIGHT - 1)) continue;
        const float *t = &noisy[i][(int)py * WIDTH + (int)px];
        sum += (1 - fy) * ((1 - fx) * t[0] + fx * t[1]) + fy * ((1 - fx) * t[WIDTH] + fx * t[WIDTH + 1]);
        count++;
    }
    return sum / fmax(count, 1);
}

static double truth(uint32_t x, uint32_t y, double roughness)
{
    double point[3], sum = 0, light;
    mirror_point(&poses[FRAMES - 1], (x + 0.5) / WIDTH, (y + 0.5) / HEIGHT, point);
    for (int i = 0; i < TRUTH_SAMPLES; i++) {
        trace(&poses[FRAMES - 1], point, roughness, (i + 0.5) / TRUTH_SAMPLES, fmod(i * 0.6180339887498949, 1), &light);
        sum += light / TRUTH_SAMPLES;
    }
    return sum;
}

/* Root mean squares of the errors. */
static void measure(const camera_path *path, float roughness, bool stabilized, double *ours, double *perfect)
{
    rig r;
    double count = (WIDTH - 2 * MARGIN) * (HEIGHT - 2 * MARGIN);
    follow(&r, path, roughness, stabilized);
    *ours = *perfect = 0;
    for (uint32_t y = MARGIN; y < HEIGHT - MARGIN; y++)
        for (uint32_t x = MARGIN; x < WIDTH - MARGIN; x++) {
            double t = truth(x, y, roughness), of_ours = rig_out(&r, x, y).y - t, of_perfect = accumulated(x, y, (uint32_t)r.settings.max_accumulated_frames) - t;
            *ours += of_ours * of_ours / count;
            *perfect += of_perfect * of_perfect / count;
        }
    *ours = sqrt(*ours);
    *perfect = sqrt(*perfect);
    rig_close(&r);
}

/* Chroma and directions are not stabilised: what is not has to be as good. */
static void mirrors_are_near_a_perfect_accumulation(void **state)
{
    static const camera_path paths[] = {
        { "sideways", { 0.05, 0, 0 }, { 0, 0, 0 }, 0 },
        { "dolly", { 0, 0, 0.05 }, { 0, 0, 0 }, 0 },
        { "yaw", { 0, 0, 0 }, { 0.006, 0, 0 }, 0 },
        { "all", { 0.02, 0.005, 0.03 }, { 0.004, 0.002, 0.002 }, 0 },
        { "sideways, jittered", { 0.05, 0, 0 }, { 0, 0, 0 }, 1 },
    };
    static const struct { float roughness; bool stabilized; } rows[] = { { 0, false }, { 0, true }, { 0.05f, true }, { 0.09f, true } };
    (void)state;
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
        for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
            double ours, perfect;
            measure(&paths[i], rows[k].roughness, rows[k].stabilized, &ours, &perfect);
            if (!(ours <= 1.5 * perfect)) fail_msg("%s, roughness %g, stabilised %d: error %g, of a perfect accumulation %g", paths[i].name, rows[k].roughness, rows[k].stabilized, ours, perfect);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(mirrors_are_near_a_perfect_accumulation) };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
