#define _POSIX_C_SOURCE 200809L
#include "report/bench.h"

#include "common/half.h"
#include "common/traffic.h"
#include "report/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { TILE = 8 };
static const float roughness = 0.5f, too_rough = 0.9f, roughness_limit = 0.7f;

/* Inputs that get noise; of one denoiser each another image. */
static const nrd_resource noisy[] = { NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, NRD_RESOURCE_IN_SIGNAL,
                                      NRD_RESOURCE_IN_TRANSLUCENCY, NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST,
                                      NRD_RESOURCE_IN_DIFF_SH0, NRD_RESOURCE_IN_DIFF_SH1, NRD_RESOURCE_IN_SPEC_SH0, NRD_RESOURCE_IN_SPEC_SH1 };
#define NOISY_COUNT (sizeof noisy / sizeof noisy[0])

static const float view_to_clip[16] = { 1.125f, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 1, 0, 0, -0.1f, 0 };
static const float world_to_view[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* ---- inputs ---- */

static uint32_t hash(uint32_t x)
{
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

static size_t pixels_of(const bench *b)
{
    return (size_t)b->scene.width * b->scene.height;
}

static bool is_sky(const bench_scene *s, uint32_t y)
{
    return (float)y < s->sky * (float)s->height;
}

/* A floor, a wall and a grid of bumps on it: depth, and a normal that varies. */
static void surface(const bench_scene *s, uint32_t x, uint32_t y, float *z, float normal[4])
{
    float u = (2 * (x + 0.5f) / s->width - 1) / 1.125f, v = (1 - 2 * (y + 0.5f) / s->height) / 2;
    bool is_floor = v < -1.0f / 8;
    *z = is_sky(s, y) ? 1e6f : is_floor ? -1 / v : 8;
    float bump = is_floor ? 0 : 0.5f * sinf(4 * u * *z) * sinf(4 * v * *z), length = sqrtf(1 + bump * bump);
    normal[0] = bump / length;
    normal[1] = is_floor ? 1.0f : 0.0f;
    normal[2] = is_floor ? 0.0f : -1 / length;
    normal[3] = (float)x < s->rough * (float)s->width ? too_rough : roughness;
}

/* Creates the image where it is new. */
static bool fill(bench *b, gpu_image *i, VkFormat format, const char *name, const void *texels)
{
    return (i->image || gpu_image_create(b->g, b->scene.width, b->scene.height, format, name, i)) && gpu_upload(b->g, i, texels);
}

/* Texels of an input on the host, made row by row on all processors. */
typedef struct sheet {
    const bench_scene *scene;
    uint32_t index;            /* of the noise */
    float *z;
    uint16_t *halves;
} sheet;

static bool make_sheet(const bench *b, uint32_t index, uint32_t halves, bool (*row)(void *sheet, int y), sheet *out)
{
    *out = (sheet){ &b->scene, index, malloc(pixels_of(b) * sizeof(float)), malloc(pixels_of(b) * halves * sizeof(uint16_t)) };
    return out->z && out->halves && parallel_each((int)b->scene.height, row, out);
}

static void free_sheet(sheet *s)
{
    free(s->z);
    free(s->halves);
}

static bool guides_row(void *user, int y)
{
    const sheet *s = user;
    for (uint32_t x = 0; x < s->scene->width; x++) {
        size_t i = (size_t)y * s->scene->width + x;
        float normal[4];
        surface(s->scene, x, (uint32_t)y, &s->z[i], normal);
        half_from_floats(s->halves + 4 * i, normal, 4);
    }
    return true;
}

static bool make_guides(bench *b)
{
    sheet s;
    bool ok = make_sheet(b, 0, 4, guides_row, &s)
           && fill(b, &b->images[NRD_RESOURCE_IN_VIEWZ], VK_FORMAT_R32_SFLOAT, "view z", s.z)
           && fill(b, &b->images[NRD_RESOURCE_IN_NORMAL_ROUGHNESS], VK_FORMAT_R16G16B16A16_SFLOAT, "normal", s.halves);
    if (ok) memset(s.halves, 0, pixels_of(b) * 8);
    ok = ok && fill(b, &b->images[NRD_RESOURCE_IN_MV], VK_FORMAT_R16G16B16A16_SFLOAT, "motion", s.halves);
    free_sheet(&s);
    return ok;
}

static bool noise_row(void *user, int y)
{
    const sheet *s = user;
    for (size_t i = (size_t)y * s->scene->width, end = i + s->scene->width; i < end; i++) {
        float sample = hash((uint32_t)i * BENCH_NOISES + s->index) % 8 == 0 ? 4.0f : 0.0f;
        float texel[4] = { sample, 0.1f * sample, 0.05f * sample, 0.5f };
        half_from_floats(s->halves + 4 * i, texel, 4);
    }
    return true;
}

/* Slanting bands of light and shadow, a fifth of the picture wide, with penumbrae between them. */
static bool rays_row(void *user, int row)
{
    const sheet *sheet = user;
    const bench_scene *s = sheet->scene;
    for (uint32_t x = 0; x < s->width; x++) {
        size_t i = (size_t)row * s->width + x;
        float z, normal[4], band = ((float)x + 0.3f * (float)row) / (0.2f * s->width);
        surface(s, x, (uint32_t)row, &z, normal);
        float lit = 0.5f + (fabsf(fmodf(band, 2) - 1) - 0.5f) / fmaxf(s->penumbra, 1e-3f), half_width = 0.1f * s->width * s->penumbra * z / s->height;
        bool reached = (hash((uint32_t)i * BENCH_NOISES + sheet->index) >> 8) / 16777216.0f < lit;
        sheet->halves[i] = half_from_float(reached ? 65504 : half_width);
    }
    return true;
}

/* Normalised hit distances: a third of the rays ends nowhere near. */
static bool hit_distances_row(void *user, int y)
{
    const sheet *s = user;
    for (size_t i = (size_t)y * s->scene->width, end = i + s->scene->width; i < end; i++)
        s->halves[i] = half_from_float(fminf((float)(hash((uint32_t)i) % 1000 + 1) / 700.0f, 1.0f));
    return true;
}

static bool make_noise(bench *b, uint32_t index)
{
    sheet s;
    bool ok = make_sheet(b, index, 4, noise_row, &s) && fill(b, &b->noise[index], VK_FORMAT_R16G16B16A16_SFLOAT, "noise", s.halves);
    free_sheet(&s);
    return ok;
}

static bool make_rays(bench *b, uint32_t index)
{
    sheet s;
    bool ok = make_sheet(b, index, 1, rays_row, &s) && fill(b, &b->rays[index], VK_FORMAT_R16_SFLOAT, "rays", s.halves);
    free_sheet(&s);
    return ok;
}

static bool make_hit_distances(bench *b)
{
    sheet s;
    bool ok = make_sheet(b, 0, 1, hit_distances_row, &s)
           && fill(b, &b->images[NRD_RESOURCE_IN_DIFF_HITDIST], VK_FORMAT_R16_SFLOAT, "hit distances", s.halves)
           && fill(b, &b->images[NRD_RESOURCE_IN_SPEC_HITDIST], VK_FORMAT_R16_SFLOAT, "hit distances", s.halves);
    free_sheet(&s);
    return ok;
}

bool bench_set_sky(bench *b, float sky)
{
    b->scene.sky = sky;
    bool ok = make_guides(b);
    for (uint32_t i = 0; ok && i < BENCH_NOISES; i++) ok = make_rays(b, i);
    return ok;
}

bool bench_open(bench *b, gpu *g, const bench_scene *scene)
{
    memset(b, 0, sizeof *b);
    b->g = g;
    b->scene = *scene;
    bool ok = make_hit_distances(b);
    for (uint32_t i = 0; ok && i < BENCH_NOISES; i++) ok = make_noise(b, i);
    return ok && bench_set_sky(b, scene->sky);
}

void bench_close(bench *b)
{
    if (!b->g) return;
    for (uint32_t i = 0; i < NOISY_COUNT; i++) b->images[noisy[i]] = (gpu_image){ 0 };
    b->images[NRD_RESOURCE_IN_PENUMBRA] = (gpu_image){ 0 };
    for (uint32_t r = 0; r < NRD_RESOURCE_COUNT; r++) gpu_image_destroy(b->g, &b->images[r]);
    for (uint32_t i = 0; i < BENCH_NOISES; i++) gpu_image_destroy(b->g, &b->noise[i]), gpu_image_destroy(b->g, &b->rays[i]);
}

double bench_active_tiles(const bench_scene *s)
{
    uint32_t rows = (s->height + TILE - 1) / TILE, active = 0;
    for (uint32_t row = 0; row < rows; row++) {
        uint32_t last = row * TILE + TILE - 1;
        active += !is_sky(s, last < s->height ? last : s->height - 1); /* sky comes from the top */
    }
    return (double)active / rows;
}

/* ---- runs ---- */

nrd_result bench_instance(const nrd_desc *desc, nrd **out)
{
    nrd_desc with_normals = *desc;
    nrd_sigma_settings sun = nrd_sigma_defaults();
    nrd_reblur_settings limited = nrd_reblur_defaults();
    sun.light_x = 0.5f;
    sun.light_y = 0.7f;
    sun.light_z = -0.5f;
    limited.specular_roughness_limit = desc->features & NRD_FEATURE_ROUGHNESS_LIMIT ? roughness_limit : 0;
    with_normals.normal_encoding = NRD_NORMAL_FORMAT_RGBA16_SNORM;
    nrd_result result = nrd_create(&with_normals, out);
    for (uint32_t i = 0; !result && i < desc->denoiser_count; i++) {
        nrd_denoiser d = desc->denoisers[i].denoiser;
        if (d == NRD_DENOISER_SIGMA_SHADOW || d == NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY) result = nrd_set_settings(*out, desc->denoisers[i].identifier, &sun);
        else if (nrd_settings_size(d) == sizeof limited) result = nrd_set_settings(*out, desc->denoisers[i].identifier, &limited);
    }
    return result;
}

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static bool make_outputs(bench *b, const nrd *instance)
{
    bool ok = true;
    for (uint32_t r = 0; r < NRD_RESOURCE_COUNT && ok; r++) {
        VkFormat format = nrd_vk_format(nrd_resource_format((nrd_resource)r));
        bool missing = format && nrd_uses_resource(instance, (nrd_resource)r) && !b->images[r].image;
        ok = !missing || gpu_image_create(b->g, b->scene.width, b->scene.height, format, nrd_resource_name((nrd_resource)r), &b->images[r]);
    }
    return ok;
}

bool bench_run_open(bench_run *run, bench *b, nrd *instance)
{
    nrd_vk_desc vk = { .instance = instance, .vk_instance = b->g->instance, .physical = b->g->physical, .device = b->g->device,
                       .get_instance_proc = b->g->get_instance_proc, .frames_in_flight = 1, .queue_family = b->g->family, .flags = NRD_VK_TIMESTAMPS };
    *run = (bench_run){ .b = b, .instance = instance };
    if (!make_outputs(b, instance)) return false;
    double before = now_ms();
    bool ok = nrd_vk_create(&vk, &run->runtime) == NRD_RESULT_OK;
    run->creation_ms = now_ms() - before;
    return ok;
}

void bench_run_close(bench_run *run)
{
    nrd_vk_destroy(run->runtime);
    nrd_destroy(run->instance);
    memset(run, 0, sizeof *run);
}

bool bench_run_everything(bench_run *run)
{
    const nrd_info *info = nrd_get_info(run->instance);
    nrd_reblur_settings all = nrd_reblur_defaults();
    bool ok = true;
    all.diffuse_prepass_blur_radius = 30;
    all.specular_prepass_blur_radius = 50;
    all.hit_distance_reconstruction = 1;
    for (uint32_t i = 0; i < info->denoiser_count; i++)
        if (nrd_settings_size(info->denoisers[i].denoiser) == sizeof all) ok = !nrd_set_settings(run->instance, info->denoisers[i].identifier, &all) && ok;
    run->everything = true;
    return ok;
}

static bool set_frame(nrd *instance, uint32_t index, bool everything)
{
    nrd_frame frame = nrd_frame_defaults();
    frame.split_screen = everything ? 0.5f : 0;
    frame.validation = everything;
    memcpy(frame.camera.view_to_clip, view_to_clip, sizeof view_to_clip);
    memcpy(frame.camera.world_to_view, world_to_view, sizeof world_to_view);
    frame.frame_index = index;
    return nrd_set_frame(instance, &frame) == NRD_RESULT_OK;
}

bool bench_run_frame(bench_run *run, nrd_vk_timing timings[BENCH_MAX_PASSES], uint32_t *passes)
{
    bench *b = run->b;
    nrd_vk_image shared[NRD_RESOURCE_COUNT];
    uint32_t count = 0, index = run->frame++;
    for (uint32_t i = 0; i < NOISY_COUNT; i++) b->images[noisy[i]] = b->noise[(index + i) % BENCH_NOISES];
    b->images[NRD_RESOURCE_IN_PENUMBRA] = b->rays[index % BENCH_NOISES];
    for (uint32_t r = 0; r < NRD_RESOURCE_COUNT; r++) {
        gpu_image *i = &b->images[r];
        if (i->image && nrd_uses_resource(run->instance, (nrd_resource)r)) shared[count++] = (nrd_vk_image){ (nrd_resource)r, i->image, i->view, i->format, i->width, i->height, i->layout, i->layout, 0, 0, 0 };
    }
    nrd_vk_frame vk = { .images = shared, .image_count = count };
    VkCommandBuffer cmd = gpu_begin(b->g);
    return cmd && set_frame(run->instance, index, run->everything) && !nrd_vk_record(run->runtime, cmd, &vk) && gpu_submit_and_wait(b->g)
        && !nrd_vk_timings(run->runtime, 0, timings, BENCH_MAX_PASSES, passes);
}

bool bench_dispatches(nrd *instance, uint32_t frame, const nrd_dispatch **dispatches, uint32_t *count)
{
    return set_frame(instance, frame, false) && !nrd_get_dispatches(instance, NULL, 0, dispatches, count);
}

static double image_bytes(const void *user, nrd_resource resource)
{
    const gpu_image *i = &((const bench *)user)->images[resource];
    return (double)gpu_format_size(i->format) * i->width * i->height;
}

double bench_bytes_per_pixel(const bench_run *run)
{
    const nrd_dispatch *dispatches;
    uint32_t count;
    if (!bench_dispatches(run->instance, run->frame, &dispatches, &count)) return 0;
    return traffic_bytes(nrd_get_info(run->instance), dispatches, count, image_bytes, run->b) / (double)pixels_of(run->b);
}
