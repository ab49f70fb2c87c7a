/* nrd-bench: device time of every pass on a synthetic scene.

   nrd-bench [--denoiser NAME,...] [--size WxH] [--frames N] [--device N] [--penumbra SHARE] [--sky SHARE] [--absent NAME,...]
             [--features 0..15] [--plan 1] [--costs 1] [--copy MB]
   Prints the median over the frames in microseconds per pass, their sum, the bytes that the passes read and write per second, and what
   the denoisers are made of: passes, modules, SPIR-V, memory, time of creation.
   --penumbra: share of the pixels that lie in a penumbra, for shadows; the rest is lit and dark in equal parts.
   --sky: share of the picture that is sky, from the top; 1: nothing but sky.
   --absent, --features: nrd_desc.absent and .features.
   --plan 1: only what they are made of; needs no device.  --costs 1: the rows of nrd.h's table of passes.
   --copy: no denoiser, but plain copies that move this many megabytes in all, and a fourth and a sixteenth of them. */
#define _POSIX_C_SOURCE 200809L
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "nrd_spirv.h"

#include "common/gpu.h"
#include "common/half.h"
#include "common/settings.h"
#include "common/traffic.h"
#include "report/copier.h"
#include "report/statistics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { NOISES = 4, MAX_FRAMES = 1000, MAX_PASSES = 64, MAX_DENOISERS = 8, WARM_UP = 16 };

typedef struct options {
    uint32_t width, height, frames, features, absent, plan, costs;
    int device;
    nrd_denoiser_desc denoisers[MAX_DENOISERS];
    uint32_t denoiser_count;
    const char *names;   /* of the denoisers */
    float penumbra, sky, copy_mb;
} options;

static gpu g;
static gpu_image images[NRD_RESOURCE_COUNT], noise[NOISES], rays[NOISES];
/* Inputs that get noise; of one denoiser each another image. */
static const nrd_resource noisy[] = { NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, NRD_RESOURCE_IN_SIGNAL,
                                      NRD_RESOURCE_IN_TRANSLUCENCY, NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST,
                                      NRD_RESOURCE_IN_DIFF_SH0, NRD_RESOURCE_IN_DIFF_SH1, NRD_RESOURCE_IN_SPEC_SH0, NRD_RESOURCE_IN_SPEC_SH1 };
#define NOISY_COUNT (sizeof noisy / sizeof noisy[0])
static nrd *denoiser;
static nrd_vk *denoiser_vk;
static float (*times_us)[MAX_PASSES];
static double creation_ms;   /* of nrd_vk_create: pipelines without a cache, images, descriptors */

static const float view_to_clip[16] = { 1.125f, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 1, 0, 0, -0.1f, 0 };
static const float world_to_view[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

static uint32_t hash(uint32_t x)
{
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

/* A floor, a wall and a grid of bumps on it: depth, and a normal that varies. */
static void surface(const options *o, uint32_t x, uint32_t y, float *z, float normal[4])
{
    float u = (2 * (x + 0.5f) / o->width - 1) / 1.125f, v = (1 - 2 * (y + 0.5f) / o->height) / 2;
    bool is_floor = v < -1.0f / 8;
    *z = (float)y < o->sky * (float)o->height ? 1e6f : is_floor ? -1 / v : 8;
    float bump = is_floor ? 0 : 0.5f * sinf(4 * u * *z) * sinf(4 * v * *z), length = sqrtf(1 + bump * bump);
    normal[0] = bump / length;
    normal[1] = is_floor ? 1.0f : 0.0f;
    normal[2] = is_floor ? 0.0f : -1 / length;
    normal[3] = 0.5f;
}

static bool make_guides(const options *o)
{
    size_t pixels = (size_t)o->width * o->height;
    float *z = malloc(pixels * 4), (*normal)[4] = malloc(pixels * 16);
    bool ok = z && normal;
    for (size_t i = 0; ok && i < pixels; i++) surface(o, (uint32_t)(i % o->width), (uint32_t)(i / o->width), &z[i], normal[i]);
    uint16_t *half = calloc(pixels, 8);
    for (size_t i = 0; ok && half && i < pixels; i++) half_from_floats(half + 4 * i, normal[i], 4);
    ok = ok && half && gpu_image_create(&g, o->width, o->height, VK_FORMAT_R32_SFLOAT, "view z", &images[NRD_RESOURCE_IN_VIEWZ]) && gpu_upload(&g, &images[NRD_RESOURCE_IN_VIEWZ], z)
      && gpu_image_create(&g, o->width, o->height, VK_FORMAT_R16G16B16A16_SFLOAT, "normal", &images[NRD_RESOURCE_IN_NORMAL_ROUGHNESS]) && gpu_upload(&g, &images[NRD_RESOURCE_IN_NORMAL_ROUGHNESS], half);
    if (ok) memset(half, 0, pixels * 8);
    ok = ok && gpu_image_create(&g, o->width, o->height, VK_FORMAT_R16G16B16A16_SFLOAT, "motion", &images[NRD_RESOURCE_IN_MV]) && gpu_upload(&g, &images[NRD_RESOURCE_IN_MV], half);
    free(z);
    free(normal);
    free(half);
    return ok;
}

static bool make_noise(const options *o, uint32_t index)
{
    size_t pixels = (size_t)o->width * o->height;
    uint16_t (*texels)[4] = malloc(pixels * 8);
    for (size_t i = 0; texels && i < pixels; i++) {
        float sample = hash((uint32_t)i * NOISES + index) % 8 == 0 ? 4.0f : 0.0f;
        float texel[4] = { sample, 0.1f * sample, 0.05f * sample, 0.5f };
        half_from_floats(texels[i], texel, 4);
    }
    bool ok = texels && gpu_image_create(&g, o->width, o->height, VK_FORMAT_R16G16B16A16_SFLOAT, "noise", &noise[index]) && gpu_upload(&g, &noise[index], texels);
    free(texels);
    return ok;
}

/* Slanting bands of light and shadow, a fifth of the picture wide, with penumbrae between them. */
static bool make_rays(const options *o, uint32_t index)
{
    size_t pixels = (size_t)o->width * o->height;
    uint16_t *texels = malloc(pixels * 2);
    for (size_t i = 0; texels && i < pixels; i++) {
        float z, normal[4], x = (float)(i % o->width), y = (float)(i / o->width), band = (x + 0.3f * y) / (0.2f * o->width);
        surface(o, (uint32_t)(i % o->width), (uint32_t)(i / o->width), &z, normal);
        float lit = 0.5f + (fabsf(fmodf(band, 2) - 1) - 0.5f) / fmaxf(o->penumbra, 1e-3f), half_width = 0.1f * o->width * o->penumbra * z / o->height;
        bool reached = (hash((uint32_t)i * NOISES + index) >> 8) / 16777216.0f < lit;
        texels[i] = half_from_float(reached ? 65504 : half_width);
    }
    bool ok = texels && gpu_image_create(&g, o->width, o->height, VK_FORMAT_R16_SFLOAT, "rays", &rays[index]) && gpu_upload(&g, &rays[index], texels);
    free(texels);
    return ok;
}

/* Normalised hit distances: a third of the rays ends nowhere near. */
static bool make_hit_distances(const options *o)
{
    static const nrd_resource inputs[] = { NRD_RESOURCE_IN_DIFF_HITDIST, NRD_RESOURCE_IN_SPEC_HITDIST };
    size_t pixels = (size_t)o->width * o->height;
    uint16_t *texels = malloc(pixels * sizeof *texels);
    bool ok = texels != NULL;
    for (size_t i = 0; ok && i < pixels; i++) texels[i] = half_from_float(fminf((float)(hash((uint32_t)i) % 1000 + 1) / 700.0f, 1.0f));
    for (size_t k = 0; ok && k < sizeof inputs / sizeof inputs[0]; k++)
        ok = gpu_image_create(&g, o->width, o->height, VK_FORMAT_R16_SFLOAT, "hit distances", &images[inputs[k]]) && gpu_upload(&g, &images[inputs[k]], texels);
    free(texels);
    return ok;
}

static void print_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    (void)user;
    (void)severity;
    fprintf(stderr, "nrd-bench: %s (%s)\n", text, nrd_result_string(result));
}

static bool make_instance(const options *o)
{
    nrd_sigma_settings sun = nrd_sigma_defaults();
    sun.light_x = 0.5f;
    sun.light_y = 0.7f;
    sun.light_z = -0.5f;
    nrd_desc desc = { .width = o->width, .height = o->height, .denoisers = o->denoisers, .denoiser_count = o->denoiser_count, .features = o->features,
                      .absent = o->absent, .normal_encoding = NRD_NORMAL_FORMAT_RGBA16_SNORM, .message = print_message };
    if (nrd_create(&desc, &denoiser)) return false;
    for (uint32_t i = 0; i < o->denoiser_count; i++) {
        nrd_denoiser d = o->denoisers[i].denoiser;
        if ((d == NRD_DENOISER_SIGMA_SHADOW || d == NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY) && nrd_set_settings(denoiser, o->denoisers[i].identifier, &sun)) return false;
    }
    return true;
}

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static bool make_denoiser(const options *o)
{
    nrd_vk_desc vk = { .instance = denoiser, .vk_instance = g.instance, .physical = g.physical, .device = g.device, .get_instance_proc = g.get_instance_proc,
                       .frames_in_flight = 1, .queue_family = g.family, .flags = NRD_VK_TIMESTAMPS };
    for (uint32_t r = 0; r < NRD_RESOURCE_COUNT; r++) {
        VkFormat format = nrd_vk_format(nrd_resource_format((nrd_resource)r));
        if (format && nrd_uses_resource(denoiser, (nrd_resource)r) && !gpu_image_create(&g, o->width, o->height, format, nrd_resource_name((nrd_resource)r), &images[r])) return false;
    }
    double before = now_ms();
    bool ok = nrd_vk_create(&vk, &denoiser_vk) == NRD_RESULT_OK;
    creation_ms = now_ms() - before;
    return ok;
}

static bool set_frame(uint32_t index)
{
    nrd_frame frame = nrd_frame_defaults();
    memcpy(frame.camera.view_to_clip, view_to_clip, sizeof view_to_clip);
    memcpy(frame.camera.world_to_view, world_to_view, sizeof world_to_view);
    frame.frame_index = index;
    return nrd_set_frame(denoiser, &frame) == NRD_RESULT_OK;
}

static bool run_frame(uint32_t index)
{
    nrd_vk_image shared[NRD_RESOURCE_COUNT];
    uint32_t count = 0;
    for (uint32_t i = 0; i < NOISY_COUNT; i++) images[noisy[i]] = noise[(index + i) % NOISES];
    images[NRD_RESOURCE_IN_PENUMBRA] = rays[index % NOISES];
    for (uint32_t r = 0; r < NRD_RESOURCE_COUNT; r++) {
        gpu_image *i = &images[r];
        if (i->image && nrd_uses_resource(denoiser, (nrd_resource)r)) shared[count++] = (nrd_vk_image){ (nrd_resource)r, i->image, i->view, i->format, i->width, i->height, i->layout, i->layout, 0, 0, 0 };
    }
    nrd_vk_frame vk = { .images = shared, .image_count = count };
    VkCommandBuffer cmd = gpu_begin(&g);
    return cmd && set_frame(index) && !nrd_vk_record(denoiser_vk, cmd, &vk) && gpu_submit_and_wait(&g);
}

static bool measure(const options *o, nrd_vk_timing *names, uint32_t *passes)
{
    for (uint32_t i = 0; i < WARM_UP + o->frames; i++) {   /* frame 0 was the plan's */
        nrd_vk_timing timings[MAX_PASSES];
        if (!run_frame(i + 1) || nrd_vk_timings(denoiser_vk, 0, timings, MAX_PASSES, passes)) return false;
        if (i < WARM_UP) continue;
        for (uint32_t p = 0; p < *passes; p++) {
            names[p] = timings[p];
            times_us[i - WARM_UP][p] = (float)(timings[p].nanoseconds * 1e-3);
        }
    }
    return true;
}

static float median(const options *o, uint32_t pass)
{
    static double of_pass[MAX_FRAMES];
    for (uint32_t i = 0; i < o->frames; i++) of_pass[i] = times_us[i][pass];
    return (float)quantile(of_pass, (int)o->frames, 0.5);
}

static double image_bytes(const void *user, nrd_resource resource)
{
    const gpu_image *i = &images[resource];
    (void)user;
    return (double)gpu_format_size(i->format) * i->width * i->height;
}

static double bytes_per_pixel(const options *o)
{
    const nrd_dispatch *dispatches;
    uint32_t count;
    if (!set_frame(WARM_UP + o->frames + 1) || nrd_get_dispatches(denoiser, NULL, 0, &dispatches, &count)) return 0;
    return traffic_bytes(nrd_get_info(denoiser), dispatches, count, image_bytes, NULL) / ((double)o->width * o->height);
}

typedef struct modules { uint32_t count, bytes; } modules;

/* Each once, however many pipelines it makes. */
static modules count_modules(const nrd_info *info)
{
    modules sum = { 0, 0 };
    for (uint32_t i = 0; i < nrd_spirv_count; i++) {
        bool used = false;
        for (uint32_t p = 0; p < info->pipeline_count; p++) used |= !strcmp(nrd_spirv_table[i].name, info->pipelines[p].shader);
        sum.count += used;
        sum.bytes += used ? nrd_spirv_table[i].size_bytes : 0;
    }
    return sum;
}

/* Passes and pipelines that a frame of these settings runs, out of those that there are. */
static bool print_plan(const options *o)
{
    const nrd_info *info = nrd_get_info(denoiser);
    const nrd_dispatch *dispatches;
    uint32_t count;
    if (!set_frame(0) || nrd_get_dispatches(denoiser, NULL, 0, &dispatches, &count)) return false;
    modules made_of = count_modules(info);
    printf("plan: %s, %ux%u: %u passes, %u modules, %.1f kB SPIR-V, %.1f MB\n", o->names, o->width, o->height, count, made_of.count,
           made_of.bytes * 1e-3, (double)(info->permanent_bytes + info->transient_bytes) * 1e-6);
    return true;
}

static void print_cost(const options *o, const nrd_vk_timing *timing, float us)
{
    static const char *const names[] = {
#define LIST_NAME(name, text, settings) #name,
        NRD_DENOISERS(LIST_NAME)
#undef LIST_NAME
    };
    const nrd_info *info = nrd_get_info(denoiser);
    nrd_denoiser of = info->denoisers[info->passes[timing->pass].denoiser].denoiser;
    printf("    NRDI_PASS_COST(%s, \"%s\", %.4ff)\n", names[of], timing->name, 1e3 * us / ((double)o->width * o->height));
}

static bool bench(const options *o)
{
    nrd_vk_timing names[MAX_PASSES];
    uint32_t passes = 0;
    double total = 0;
    bool ok = make_guides(o) && make_hit_distances(o);
    for (uint32_t i = 0; ok && i < NOISES; i++) ok = make_noise(o, i) && make_rays(o, i);
    if (!ok || !make_denoiser(o) || !measure(o, names, &passes)) return false;
    printf("%s, %s, %ux%u, median of %u frames\n", g.properties.deviceName, o->names, o->width, o->height, o->frames);
    for (uint32_t p = 0; p < passes; p++) {
        float us = median(o, p);
        if (o->costs) print_cost(o, &names[p], us);
        else printf("%10.1f us  %s\n", us, names[p].name);
        total += us;
    }
    double bytes = bytes_per_pixel(o), pixels = (double)o->width * o->height;
    printf("%10.1f us  total, %.3f ns per pixel, %.1f bytes per pixel: %.2f TB/s\n", total, 1e3 * total / pixels, bytes, bytes * pixels / (total * 1e6));
    printf("%10.1f ms  creation; %.1f %% of the tiles are active\n", creation_ms, 100.0 * (1.0 - o->sky));
    return true;
}

static bool parse_denoisers(const char *text, options *o)
{
    o->names = text;
    for (o->denoiser_count = 0;;) {
        char name[64];
        size_t length = strcspn(text, ",");
        snprintf(name, sizeof name, "%.*s", (int)length, text);
        if (o->denoiser_count == MAX_DENOISERS || nrd_find_denoiser(name, &o->denoisers[o->denoiser_count].denoiser)) return false;
        o->denoisers[o->denoiser_count].identifier = o->denoiser_count;
        o->denoiser_count++;
        if (!text[length]) return true;
        text += length + 1;
    }
}

/* Median device time in milliseconds; the copies before it bring the device's clock up. */
static bool time_copies(const options *o, copier *c, copier_way way, double bytes, double *ms)
{
    static double times[MAX_FRAMES];
    for (uint32_t i = 0; i < WARM_UP + o->frames; i++)
        if (!copier_run(c, way, bytes, &times[i < WARM_UP ? 0 : i - WARM_UP])) return false;
    *ms = quantile(times, (int)o->frames, 0.5);
    return true;
}

static bool bench_copies(const options *o)
{
    copier c;
    bool ok = copier_open(&c, &g, o->copy_mb * 1e6);
    printf("%s, plain copies, half of the bytes read, half written, median of %u\n", g.properties.deviceName, o->frames);
    for (double mb = o->copy_mb; ok && mb > o->copy_mb / 20; mb /= 4)
        for (int way = 0; ok && way < COPIER_WAY_COUNT; way++) {
            double ms = 0;
            ok = time_copies(o, &c, (copier_way)way, mb * 1e6, &ms);
            if (ok) printf("%10.1f us  %8.1f MB  %6.3f TB/s  %s\n", ms * 1e3, mb, mb * 1e-3 / ms, copier_way_name((copier_way)way));
        }
    copier_close(&c);
    return ok;
}

static bool parse_share(const char *text, float *out) { return sscanf(text, "%f", out) == 1 && *out >= 0 && *out <= 1; }

static bool parse(int argc, char **argv, options *o)
{
    for (int i = 1; i < argc; i += 2) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        bool ok = (!strcmp(argv[i], "--size") && sscanf(value, "%ux%u", &o->width, &o->height) == 2 && o->width && o->height && o->width <= 16384 && o->height <= 16384)
               || (!strcmp(argv[i], "--frames") && (o->frames = (uint32_t)atoi(value)) > 0 && o->frames <= MAX_FRAMES)
               || (!strcmp(argv[i], "--penumbra") && parse_share(value, &o->penumbra))
               || (!strcmp(argv[i], "--sky") && parse_share(value, &o->sky))
               || (!strcmp(argv[i], "--absent") && (!*value || settings_parse_absences(value, &o->absent)))
               || (!strcmp(argv[i], "--features") && sscanf(value, "%u", &o->features) == 1 && o->features <= NRD_FEATURE_ALL)
               || (!strcmp(argv[i], "--plan") && sscanf(value, "%u", &o->plan) == 1)
               || (!strcmp(argv[i], "--costs") && sscanf(value, "%u", &o->costs) == 1)
               || (!strcmp(argv[i], "--copy") && sscanf(value, "%f", &o->copy_mb) == 1 && o->copy_mb > 0 && o->copy_mb <= 16384)
               || (!strcmp(argv[i], "--denoiser") && parse_denoisers(value, o))
               || (!strcmp(argv[i], "--device") && sscanf(value, "%d", &o->device) == 1);
        if (!ok) return fprintf(stderr, "nrd-bench: %s %s: usage: nrd-bench [--denoiser NAME,...] [--size WxH] [--frames 1..%d] [--device N] [--penumbra 0..1] [--sky 0..1] "
                                "[--absent NAME,...] [--features 0..%d] [--plan 0|1] [--costs 0|1] [--copy MB]\n", argv[i], value, MAX_FRAMES, NRD_FEATURE_ALL), false;
    }
    return true;
}

static void clean_up(void)
{
    nrd_vk_destroy(denoiser_vk);
    nrd_destroy(denoiser);
    for (uint32_t i = 0; i < NOISY_COUNT; i++) images[noisy[i]] = (gpu_image){ 0 };
    images[NRD_RESOURCE_IN_PENUMBRA] = (gpu_image){ 0 };
    for (uint32_t r = 0; r < NRD_RESOURCE_COUNT; r++) gpu_image_destroy(&g, &images[r]);
    for (uint32_t i = 0; i < NOISES; i++) gpu_image_destroy(&g, &noise[i]), gpu_image_destroy(&g, &rays[i]);
    gpu_close(&g);
    free(times_us);
}

int main(int argc, char **argv)
{
    options o = { .width = 1920, .height = 1080, .frames = 60, .denoisers = { { 0, NRD_DENOISER_REBLUR_DIFFUSE } }, .denoiser_count = 1,
                  .names = "reblur_diffuse", .penumbra = 0.2f };
    char error[256];
    if (!parse(argc, argv, &o)) return 2;
    bool ok = o.copy_mb > 0 || (make_instance(&o) && print_plan(&o));
    gpu_desc desc = { .device_index = o.device };
    if (ok && !o.plan) {
        if (!gpu_open(&g, &desc, error, sizeof error)) return fprintf(stderr, "nrd-bench: %s\n", error), nrd_destroy(denoiser), 1;
        times_us = malloc(o.frames * sizeof *times_us);
        ok = times_us && (o.copy_mb > 0 ? bench_copies(&o) : bench(&o));
    }
    if (!ok) fprintf(stderr, "nrd-bench: failed. %s\n", gpu_error(&g));
    clean_up();
    return ok ? 0 : 1;
}
