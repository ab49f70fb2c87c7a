/* nrd-lights: shadows of many lamps, denoised in three ways; error, time and memory against the number of lamps.

   nrd-lights [--size WxH] [--lights N] [--device N]
   own history   a denoiser for each lamp: its history lives on, memory grows with the lamps
   no history    one denoiser for all of them in turn, restarted for each: memory does not depend on their number
   one signal    all lamps in one coloured signal (nrd_light_sum_*): neither memory nor time does
   One ray per pixel and lamp goes to a random point of it. Errors are those of the lit picture, root mean square over its mean. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#define NRD_NORMAL_FORMAT NRD_NORMAL_FORMAT_RGBA16_SNORM
#define NRD_ROUGHNESS_FORMAT NRD_ROUGHNESS_FORMAT_LINEAR
#include "nrd_shaders/nrd_c.h"

#include "common/gpu.h"
#include "common/half.h"
#include "report/statistics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_LIGHTS = 16, FRAMES = 12, TRUTH_SIDE = 8, MAX_PASSES = 4 * MAX_LIGHTS }; /* a lamp takes a slot of nrd_vk where none has a denoiser of its own */

typedef enum way { OWN_HISTORY, NO_HISTORY, ONE_SIGNAL, WAYS } way;
static const char *const way_names[WAYS] = { "own history", "no history", "one signal" };

typedef struct sphere { float at[3], radius; } sphere;
static const sphere spheres[] = { { { -1.2f, 0.6f, 5 }, 0.6f }, { { 0.4f, 0.35f, 4 }, 0.35f }, { { 1.5f, 0.8f, 6 }, 0.8f }, { { 0.2f, 1.7f, 5.5f }, 0.3f } };
enum { SPHERES = sizeof spheres / sizeof spheres[0] };
static const float eye[3] = { 0, 1.5f, 0 }, tan_half_fov = 0.5f, lamp_radius = 0.25f;

typedef struct surface { float position[3], normal[3], z; } surface; /* z 0: sky */
typedef struct lamp { float at[3], color[3]; } lamp;

typedef struct program {
    gpu g;
    uint32_t width, height, lights;
    surface *surfaces;
    nrd_light_sum *sums;                    /* of this frame's rays */
    float (*truth)[3], (*shown)[3];
    uint16_t *penumbra;                     /* of the lamp at hand */
    uint8_t *shadow, (*color)[4];
    gpu_image motion, normal, view_z, rays[MAX_LIGHTS], out[MAX_LIGHTS], rays_of_all, color_of_all, out_of_all;
    nrd *denoiser;
    nrd_vk *denoiser_vk;
} program;

static uint32_t pixels_of(const program *p) { return p->width * p->height; }

/* ---- the world ------------------------------------------------------------------------------------------------------------- */
/* They stand around the spheres, each of another colour. */
static lamp lamp_of(uint32_t i)
{
    float angle = 2.4f * (float)i;
    lamp l = { { 3 * cosf(angle), 2.6f + 0.15f * (float)(i % 4), 5 + 3 * sinf(angle) }, { 0, 0, 0 } };
    for (int k = 0; k < 3; k++) l.color[k] = 4 * (1 + 0.7f * cosf(1.7f * (float)i + 2.1f * (float)k));
    return l;
}

static float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Distance along a unit vector to the nearest sphere; index: which one, or -1. */
static float trace(const float from[3], const float along[3], int *index)
{
    float nearest = NRD_HIT_DIST_MISS;
    *index = -1;
    for (int i = 0; i < SPHERES; i++) {
        float d[3] = { from[0] - spheres[i].at[0], from[1] - spheres[i].at[1], from[2] - spheres[i].at[2] };
        float b = dot(d, along), root = b * b - dot(d, d) + spheres[i].radius * spheres[i].radius, t = root > 0 ? -b - sqrtf(root) : -1;
        if (t > 1e-3f && t < nearest) nearest = t, *index = i;
    }
    return nearest;
}

static surface find_surface(const program *p, uint32_t i)
{
    float x = (2 * ((float)(i % p->width) + 0.5f) / (float)p->width - 1) * tan_half_fov * (float)p->width / (float)p->height;
    float y = (1 - 2 * ((float)(i / p->width) + 0.5f) / (float)p->height) * tan_half_fov - 0.25f, length = sqrtf(x * x + y * y + 1);
    const float along[3] = { x / length, y / length, 1 / length };
    surface s = { { 0 }, { 0, 1, 0 }, 0 };
    int index;
    float t = trace(eye, along, &index), floor_t = along[1] < 0 ? -eye[1] / along[1] : NRD_HIT_DIST_MISS;
    if (floor_t < t) t = floor_t, index = -1;
    if (t > 60) return s;
    for (int k = 0; k < 3; k++) s.position[k] = eye[k] + t * along[k];
    for (int k = 0; k < 3 && index >= 0; k++) s.normal[k] = (s.position[k] - spheres[index].at[k]) / spheres[index].radius;
    s.z = s.position[2];
    return s;
}

/* Unshadowed light of a lamp, and its distance and direction. False where the surface faces away. */
static bool shine(const lamp *l, const surface *s, float to_lamp[3], float *distance, float light[3])
{
    for (int k = 0; k < 3; k++) to_lamp[k] = l->at[k] - s->position[k];
    *distance = sqrtf(dot(to_lamp, to_lamp));
    for (int k = 0; k < 3; k++) to_lamp[k] /= *distance;
    float facing = dot(to_lamp, s->normal);
    for (int k = 0; k < 3; k++) light[k] = facing > 0 ? l->color[k] * facing / (*distance * *distance) : 0;
    return facing > 0;
}

/* Distance to the occluder towards the point (u, v) in [0,1) of the lamp's disk, or NRD_HIT_DIST_MISS. */
static float shadow_ray(const surface *s, const float axis[3], float distance, float u, float v)
{
    float side = sqrtf(axis[0] * axis[0] + axis[2] * axis[2]) + 1e-6f, r = lamp_radius * sqrtf(u), a = r * cosf(6.2831853f * v), b = r * sinf(6.2831853f * v);
    const float t[3] = { axis[2] / side, 0, -axis[0] / side }, up[3] = { -axis[0] * axis[1] / side, side, -axis[1] * axis[2] / side };
    float along[3];
    int index;
    for (int k = 0; k < 3; k++) along[k] = distance * axis[k] + a * t[k] + b * up[k];
    float length = sqrtf(dot(along, along));
    for (int k = 0; k < 3; k++) along[k] /= length;
    float hit = trace(s->position, along, &index);
    return hit < length ? hit : NRD_HIT_DIST_MISS;
}

static void find_truth(program *p)
{
    for (uint32_t i = 0; i < pixels_of(p); i++) {
        const surface *s = &p->surfaces[i];
        memset(p->truth[i], 0, sizeof p->truth[i]);
        for (uint32_t n = 0; n < p->lights && s->z > 0; n++) {
            float axis[3], distance, light[3], seen = 0;
            lamp l = lamp_of(n);
            if (!shine(&l, s, axis, &distance, light)) continue;
            for (int k = 0; k < TRUTH_SIDE * TRUTH_SIDE; k++)
                seen += shadow_ray(s, axis, distance, ((float)(k % TRUTH_SIDE) + 0.5f) / TRUTH_SIDE, ((float)(k / TRUTH_SIDE) + 0.5f) / TRUTH_SIDE) >= NRD_HIT_DIST_MISS;
            for (int k = 0; k < 3; k++) p->truth[i][k] += light[k] * seen / (TRUTH_SIDE * TRUTH_SIDE);
        }
    }
}

/* Root of the mean squared error over the mean. */
static double error_of(const program *p, float (*picture)[3])
{
    double error = 0, mean = 0;
    for (uint32_t i = 0; i < pixels_of(p); i++)
        for (int k = 0; k < 3; k++) {
            double difference = picture[i][k] - p->truth[i][k];
            error += difference * difference / (3.0 * pixels_of(p));
            mean += p->truth[i][k] / (3.0 * pixels_of(p));
        }
    return sqrt(error) / mean;
}

/* ---- rays ------------------------------------------------------------------------------------------------------------------ */
static float random_number(uint32_t x)
{
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return (float)((x ^ (x >> 16)) >> 8) / 16777216.0f;
}

/* One ray of each pixel to lamp n: its penumbrae, and added to the sums. */
static void trace_lamp(program *p, uint32_t n, uint32_t frame)
{
    lamp l = lamp_of(n);
    for (uint32_t i = 0; i < pixels_of(p); i++) {
        const surface *s = &p->surfaces[i];
        float axis[3], distance, light[3], hit = 0;
        uint32_t seed = 2 * (i + pixels_of(p) * (n + MAX_LIGHTS * frame));
        if (s->z > 0 && shine(&l, s, axis, &distance, light)) {
            hit = shadow_ray(s, axis, distance, random_number(seed), random_number(seed + 1));
            float seen = hit >= NRD_HIT_DIST_MISS, penumbra = nrd_pack_local_penumbra(hit, distance, lamp_radius);
            p->sums[i] = nrd_light_sum_add(p->sums[i], nrd_make_vec3(light[0], light[1], light[2]), penumbra, nrd_make_vec3(seen, seen, seen));
            p->penumbra[i] = half_from_float(penumbra);
        } else p->penumbra[i] = 0;
    }
}

static bool trace_frame(program *p, uint32_t frame)
{
    for (uint32_t i = 0; i < pixels_of(p); i++) p->sums[i] = nrd_light_sum_begin();
    for (uint32_t n = 0; n < p->lights; n++) {
        trace_lamp(p, n, frame);
        if (!gpu_upload(&p->g, &p->rays[n], p->penumbra)) return false;
    }
    for (uint32_t i = 0; i < pixels_of(p); i++) {
        nrd_vec4 t = nrd_light_sum_translucency(p->sums[i]);
        const float rgb[3] = { t.x, t.y, t.z };
        for (int k = 0; k < 3; k++) p->color[i][k] = (uint8_t)(255 * rgb[k] + 0.5f);
        p->penumbra[i] = half_from_float(nrd_light_sum_penumbra(p->sums[i]));
    }
    return gpu_upload(&p->g, &p->rays_of_all, p->penumbra) && gpu_upload(&p->g, &p->color_of_all, p->color);
}

/* ---- denoisers ------------------------------------------------------------------------------------------------------------- */
static void print_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    (void)user;
    (void)severity;
    fprintf(stderr, "nrd-lights: %s (%s)\n", text, nrd_result_string(result));
}

static bool create_denoisers(program *p, way w)
{
    nrd_denoiser_desc list[MAX_LIGHTS];
    uint32_t count = w == OWN_HISTORY ? p->lights : 1;
    for (uint32_t i = 0; i < count; i++) list[i] = (nrd_denoiser_desc){ i, w == ONE_SIGNAL ? NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY : NRD_DENOISER_SIGMA_SHADOW };
    nrd_desc desc = { .width = p->width, .height = p->height, .denoisers = list, .denoiser_count = count,
                      .normal_encoding = NRD_NORMAL_FORMAT_RGBA16_SNORM, .message = print_message };
    if (nrd_create(&desc, &p->denoiser)) return false;
    nrd_vk_desc vk = { .instance = p->denoiser, .vk_instance = p->g.instance, .physical = p->g.physical, .device = p->g.device, .get_instance_proc = p->g.get_instance_proc,
                       .frames_in_flight = MAX_LIGHTS, .queue_family = p->g.family, .flags = NRD_VK_TIMESTAMPS };
    return nrd_vk_create(&vk, &p->denoiser_vk) == NRD_RESULT_OK;
}

static bool tell_lamp(program *p, uint32_t identifier, uint32_t n)
{
    nrd_sigma_settings s = nrd_sigma_defaults();
    lamp l = lamp_of(n);
    s.light_x = l.at[0];
    s.light_y = l.at[1];
    s.light_z = l.at[2];
    s.light_is_local = 1;
    s.light_radius = lamp_radius;
    return nrd_set_settings(p->denoiser, identifier, &s) == NRD_RESULT_OK;
}

static bool set_frame(program *p, uint32_t frame, bool restart)
{
    nrd_frame f = nrd_frame_defaults();
    const float clip[16] = { (float)p->height / (float)p->width / tan_half_fov, 0, 0, 0, 0, 1 / tan_half_fov, 0, 0, 0, 0.25f / tan_half_fov, 1, 1, 0, 0, -0.1f, 0 };
    const float view[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -eye[0], -eye[1], -eye[2], 1 };
    memcpy(f.camera.view_to_clip, clip, sizeof clip);
    memcpy(f.camera.world_to_view, view, sizeof view);
    f.frame_index = frame;
    f.denoising_range = 1000;
    f.restart = restart;
    return nrd_set_frame(p->denoiser, &f) == NRD_RESULT_OK;
}

static nrd_vk_image share(nrd_resource resource, const gpu_image *i) { return (nrd_vk_image){ resource, i->image, i->view, i->format, i->width, i->height, i->layout, i->layout, 0, 0, 0 }; }

static bool record(program *p, VkCommandBuffer cmd, uint32_t slot, uint32_t identifier, bool colored, gpu_image *rays, gpu_image *out)
{
    nrd_vk_image images[] = { share(NRD_RESOURCE_IN_MV, &p->motion), share(NRD_RESOURCE_IN_NORMAL_ROUGHNESS, &p->normal), share(NRD_RESOURCE_IN_VIEWZ, &p->view_z),
                              share(NRD_RESOURCE_IN_PENUMBRA, rays), share(colored ? NRD_RESOURCE_OUT_SHADOW_TRANSLUCENCY : NRD_RESOURCE_OUT_SHADOW, out),
                              share(NRD_RESOURCE_IN_TRANSLUCENCY, &p->color_of_all) };
    nrd_vk_frame vk = { .slot = slot, .images = images, .image_count = colored ? 6 : 5, .identifiers = &identifier, .identifier_count = 1 };
    return nrd_vk_record(p->denoiser_vk, cmd, &vk) == NRD_RESULT_OK;
}

/* One denoiser in turn: each lamp is a frame of its own for it, without a past, and has its own slot. */
static bool record_in_turn(program *p, VkCommandBuffer cmd, uint32_t frame)
{
    for (uint32_t n = 0; n < p->lights; n++)
        if (!tell_lamp(p, 0, n) || !set_frame(p, frame, true) || !record(p, cmd, n, 0, false, &p->rays[n], &p->out[n])) return false;
    return true;
}

static bool record_frame(program *p, way w, VkCommandBuffer cmd, uint32_t frame)
{
    if (w == NO_HISTORY) return record_in_turn(p, cmd, frame);
    for (uint32_t n = 0; w == OWN_HISTORY && n < p->lights; n++)
        if (!tell_lamp(p, n, n)) return false;
    if (!set_frame(p, frame, frame == 0)) return false;
    if (w == ONE_SIGNAL) return record(p, cmd, 0, 0, true, &p->rays_of_all, &p->out_of_all);
    for (uint32_t n = 0; n < p->lights; n++)
        if (!record(p, cmd, 0, n, false, &p->rays[n], &p->out[n])) return false;
    return true;
}

/* Milliseconds of the passes of the last frame. */
static double frame_ms(const program *p, way w)
{
    double sum = 0;
    for (uint32_t slot = 0; slot < (w == NO_HISTORY ? p->lights : 1); slot++) {
        nrd_vk_timing timings[MAX_PASSES];
        uint32_t count = 0;
        if (nrd_vk_timings(p->denoiser_vk, slot, timings, MAX_PASSES, &count)) return 0;
        for (uint32_t i = 0; i < count; i++) sum += timings[i].nanoseconds * 1e-6;
    }
    return sum;
}

/* ---- the picture ----------------------------------------------------------------------------------------------------------- */
static bool compose_lamps(program *p)
{
    memset(p->shown, 0, pixels_of(p) * sizeof *p->shown);
    for (uint32_t n = 0; n < p->lights; n++) {
        lamp l = lamp_of(n);
        if (!gpu_download(&p->g, &p->out[n], p->shadow)) return false;
        for (uint32_t i = 0; i < pixels_of(p); i++) {
            float axis[3], distance, light[3];
            if (p->surfaces[i].z == 0 || !shine(&l, &p->surfaces[i], axis, &distance, light)) continue;
            for (int k = 0; k < 3; k++) p->shown[i][k] += light[k] * nrd_unpack_shadow(p->shadow[i] / 255.0f);
        }
    }
    return true;
}

static bool compose_signal(program *p)
{
    if (!gpu_download(&p->g, &p->out_of_all, p->color)) return false;
    for (uint32_t i = 0; i < pixels_of(p); i++) {
        const float all[3] = { p->sums[i].unshadowed.x, p->sums[i].unshadowed.y, p->sums[i].unshadowed.z };
        for (int k = 0; k < 3; k++) p->shown[i][k] = all[k] * nrd_unpack_shadow(p->color[i][k] / 255.0f);
    }
    return true;
}

static void compose_rays(program *p)
{
    for (uint32_t i = 0; i < pixels_of(p); i++) {
        const float lit[3] = { p->sums[i].shadowed.x, p->sums[i].shadowed.y, p->sums[i].shadowed.z };
        memcpy(p->shown[i], lit, sizeof lit);
    }
}

/* ---- the program ----------------------------------------------------------------------------------------------------------- */
static bool try_way(program *p, way w)
{
    double ms[FRAMES];
    bool ok = create_denoisers(p, w);
    for (uint32_t frame = 0; ok && frame < FRAMES; frame++) {
        ok = trace_frame(p, frame);
        VkCommandBuffer cmd = ok ? gpu_begin(&p->g) : NULL;
        ok = cmd && record_frame(p, w, cmd, frame) && gpu_submit_and_wait(&p->g);
        if (ok) ms[frame] = frame_ms(p, w);
    }
    ok = ok && (w == ONE_SIGNAL ? compose_signal(p) : compose_lamps(p));
    if (ok) {
        const nrd_info *info = nrd_get_info(p->denoiser);
        printf("%6u  %-12s %8.4f %10.3f %10.2f\n", p->lights, way_names[w], error_of(p, p->shown), quantile(ms, FRAMES, 0.5), (double)(info->permanent_bytes + info->transient_bytes) * 1e-6);
    }
    nrd_vk_destroy(p->denoiser_vk);
    nrd_destroy(p->denoiser);
    p->denoiser_vk = NULL;
    p->denoiser = NULL;
    return ok;
}

static bool run(program *p, uint32_t most)
{
    printf("%s, %ux%u, 1 ray per pixel and lamp, after %d frames\n%6s  %-12s %8s %10s %10s\n", p->g.properties.deviceName, p->width, p->height, FRAMES, "lamps", "", "error", "ms", "MB");
    for (p->lights = 1; p->lights <= most; p->lights *= 2) {
        find_truth(p);
        for (int w = 0; w < WAYS; w++)
            if (!try_way(p, (way)w)) return false;
        compose_rays(p);
        printf("%6u  %-12s %8.4f\n", p->lights, "rays", error_of(p, p->shown));
    }
    return true;
}

static bool make_images(program *p)
{
    gpu *g = &p->g;
    uint32_t w = p->width, h = p->height;
    bool ok = gpu_image_create(g, w, h, VK_FORMAT_R16G16B16A16_SFLOAT, "motion", &p->motion) && gpu_image_create(g, w, h, VK_FORMAT_R32G32B32A32_SFLOAT, "normal", &p->normal)
           && gpu_image_create(g, w, h, VK_FORMAT_R32_SFLOAT, "view z", &p->view_z) && gpu_image_create(g, w, h, VK_FORMAT_R16_SFLOAT, "rays of all", &p->rays_of_all)
           && gpu_image_create(g, w, h, VK_FORMAT_R8G8B8A8_UNORM, "color", &p->color_of_all) && gpu_image_create(g, w, h, VK_FORMAT_R8G8B8A8_UNORM, "out of all", &p->out_of_all);
    for (uint32_t i = 0; i < MAX_LIGHTS && ok; i++)
        ok = gpu_image_create(g, w, h, VK_FORMAT_R16_SFLOAT, "rays", &p->rays[i]) && gpu_image_create(g, w, h, VK_FORMAT_R8_UNORM, "out", &p->out[i]);
    return ok;
}

/* Nothing moves. */
static bool upload_guides(program *p)
{
    uint16_t *motion = calloc(pixels_of(p), 8);
    float (*normal)[4] = malloc(pixels_of(p) * sizeof *normal), *z = malloc(pixels_of(p) * sizeof *z);
    bool ok = motion && normal && z;
    for (uint32_t i = 0; ok && i < pixels_of(p); i++) {
        surface s = p->surfaces[i] = find_surface(p, i);
        const float texel[4] = { s.normal[0], s.normal[1], s.normal[2], 1 };
        memcpy(normal[i], texel, sizeof texel);
        z[i] = s.z > 0 ? s.z : 2000;
    }
    ok = ok && gpu_upload(&p->g, &p->motion, motion) && gpu_upload(&p->g, &p->normal, normal) && gpu_upload(&p->g, &p->view_z, z);
    free(motion);
    free(normal);
    free(z);
    return ok;
}

static bool open_program(program *p, int device)
{
    char error[256];
    gpu_desc desc = { .device_index = device };
    if (!gpu_open(&p->g, &desc, error, sizeof error)) return fprintf(stderr, "nrd-lights: %s\n", error), false;
    size_t count = pixels_of(p);
    p->surfaces = malloc(count * sizeof *p->surfaces);
    p->sums = malloc(count * sizeof *p->sums);
    p->truth = malloc(count * sizeof *p->truth);
    p->shown = malloc(count * sizeof *p->shown);
    p->penumbra = malloc(count * sizeof *p->penumbra);
    p->shadow = malloc(count);
    p->color = calloc(count, sizeof *p->color);
    bool memory = p->surfaces && p->sums && p->truth && p->shown && p->penumbra && p->shadow && p->color;
    if (memory && make_images(p) && upload_guides(p)) return true;
    fprintf(stderr, "nrd-lights: %s\n", memory ? gpu_error(&p->g) : "out of memory");
    return false;
}

static void close_program(program *p)
{
    gpu_image *images[] = { &p->motion, &p->normal, &p->view_z, &p->rays_of_all, &p->color_of_all, &p->out_of_all };
    for (size_t i = 0; i < sizeof images / sizeof images[0]; i++) gpu_image_destroy(&p->g, images[i]);
    for (uint32_t i = 0; i < MAX_LIGHTS; i++) gpu_image_destroy(&p->g, &p->rays[i]), gpu_image_destroy(&p->g, &p->out[i]);
    gpu_close(&p->g);
    free(p->surfaces);
    free(p->sums);
    free(p->truth);
    free(p->shown);
    free(p->penumbra);
    free(p->shadow);
    free(p->color);
}

int main(int argc, char **argv)
{
    static program p = { .width = 320, .height = 180 };
    uint32_t most = 8;
    int device = 0;
    for (int i = 1; i < argc; i += 2) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        bool ok = (!strcmp(argv[i], "--size") && sscanf(value, "%ux%u", &p.width, &p.height) == 2 && p.width && p.height && p.width <= 4096 && p.height <= 4096)
               || (!strcmp(argv[i], "--lights") && sscanf(value, "%u", &most) == 1 && most >= 1 && most <= MAX_LIGHTS)
               || (!strcmp(argv[i], "--device") && sscanf(value, "%d", &device) == 1);
        if (!ok) return fprintf(stderr, "nrd-lights: %s %s: usage: nrd-lights [--size WxH] [--lights 1..%d] [--device N]\n", argv[i], value, MAX_LIGHTS), 2;
    }
    bool ok = open_program(&p, device) && run(&p, most);
    if (!ok) fprintf(stderr, "nrd-lights: failed. %s\n", gpu_error(&p.g));
    close_program(&p);
    return ok ? 0 : 1;
}
