/* nrd-bench: device time of every pass on a synthetic scene.

   nrd-bench [--denoiser NAME,...] [--size WxH] [--frames N] [--device N] [--penumbra SHARE] [--sky SHARE] [--rough SHARE]
             [--absent NAME,...] [--features BITS] [--plan 1] [--costs 1] [--copy MB]
   Prints the median over the frames in microseconds per pass, their sum, the bytes that the passes read and write per second, and what
   the denoisers are made of: passes, modules, SPIR-V, memory, time of creation.
   --penumbra: share of the pixels that lie in a penumbra, for shadows; the rest is lit and dark in equal parts.
   --sky: share of the picture that is sky, from the top; 1: nothing but sky.
   --rough: share of the picture, from the left, that is too rough for a specular signal, where the features have NRD_FEATURE_ROUGHNESS_LIMIT.
   --absent, --features: nrd_desc.absent and .features.
   --plan 1: only what they are made of; needs no device.  --costs 1: nanoseconds per pixel of all passes of
   each denoiser, optional ones too, as rows for passes.sh.
   --copy: no denoiser, but plain copies that move this many megabytes in all, and a fourth and a sixteenth of them. */
#define _POSIX_C_SOURCE 200809L
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "nrd_spirv.h"

#include "common/gpu.h"
#include "common/settings.h"
#include "report/bench.h"
#include "report/copier.h"
#include "report/statistics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAX_FRAMES = 1000, MAX_DENOISERS = NRD_DENOISER_COUNT, WARM_UP = 16 };
#define WARM_UP_SECONDS 0.4

typedef struct options {
    bench_scene scene;
    uint32_t frames, features, absent, plan, costs;
    int device;
    nrd_denoiser_desc denoisers[MAX_DENOISERS];
    uint32_t denoiser_count;
    const char *names;   /* of the denoisers */
    float copy_mb;
} options;

static gpu g;
static bench inputs;
static bench_run running;
static float (*times_us)[BENCH_MAX_PASSES];

static void print_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    (void)user;
    (void)severity;
    fprintf(stderr, "nrd-bench: %s (%s)\n", text, nrd_result_string(result));
}

static bool make_instance(const options *o)
{
    nrd_desc desc = { .width = o->scene.width, .height = o->scene.height, .denoisers = o->denoisers, .denoiser_count = o->denoiser_count, .features = o->features,
                      .absent = o->absent, .message = print_message };
    return !bench_instance(&desc, &running.instance);
}

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A GPU's clock falls while the host compiles. */
static bool warm_up(void)
{
    double start = seconds_now();
    bool ok = true;
    running.frame = 1; /* frame 0 was the plan's */
    for (int i = 0; ok && (i < WARM_UP || seconds_now() - start < WARM_UP_SECONDS); i++) {
        nrd_vk_timing timings[BENCH_MAX_PASSES];
        uint32_t passes;
        ok = bench_run_frame(&running, timings, &passes);
    }
    return ok;
}

static bool measure(const options *o, nrd_vk_timing *names, uint32_t *passes)
{
    bool ok = warm_up();
    for (uint32_t i = 0; ok && i < o->frames; i++) {
        ok = bench_run_frame(&running, names, passes);
        for (uint32_t p = 0; ok && p < *passes; p++) times_us[i][p] = (float)(names[p].nanoseconds * 1e-3);
    }
    return ok;
}

static float median(const options *o, uint32_t pass)
{
    static double of_pass[MAX_FRAMES];
    for (uint32_t i = 0; i < o->frames; i++) of_pass[i] = times_us[i][pass];
    return (float)quantile(of_pass, (int)o->frames, 0.5);
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
    const nrd_info *info = nrd_get_info(running.instance);
    const nrd_dispatch *dispatches;
    uint32_t count;
    if (!bench_dispatches(running.instance, 0, &dispatches, &count)) return false;
    modules made_of = count_modules(info);
    printf("plan: %s, %ux%u: %u passes, %u modules, %.1f kB SPIR-V, %.1f MB\n", o->names, o->scene.width, o->scene.height, count, made_of.count,
           made_of.bytes * 1e-3, (double)(info->permanent_bytes + info->transient_bytes) * 1e-6);
    return true;
}

static bool bench_denoisers(const options *o)
{
    nrd_vk_timing names[BENCH_MAX_PASSES];
    uint32_t passes = 0;
    double total = 0;
    nrd *instance = running.instance;
    if (!bench_open(&inputs, &g, &o->scene) || !bench_run_open(&running, &inputs, instance) || !measure(o, names, &passes)) return false;
    printf("%s, %s, %ux%u, median of %u frames\n", g.properties.deviceName, o->names, o->scene.width, o->scene.height, o->frames);
    for (uint32_t p = 0; p < passes; p++) {
        float us = median(o, p);
        printf("%10.1f us  %s\n", us, names[p].name);
        total += us;
    }
    double bytes = bench_bytes_per_pixel(&running), pixels = (double)o->scene.width * o->scene.height;
    printf("%10.1f us  total, %.3f ns per pixel, %.1f bytes per pixel: %.2f TB/s\n", total, 1e3 * total / pixels, bytes, bytes * pixels / (total * 1e6));
    printf("%10.1f ms  creation; %.1f %% of the tiles are active\n", running.creation_ms, 100 * bench_active_tiles(&o->scene));
    return true;
}

typedef struct cost { const char *pass; float us; } cost;

static bool measure_costs(const options *o, nrd_denoiser denoiser, bool everything, cost costs[BENCH_MAX_PASSES], uint32_t *count)
{
    nrd_denoiser_desc only = { 0, denoiser };
    nrd_desc desc = { .width = o->scene.width, .height = o->scene.height, .denoisers = &only, .denoiser_count = 1, .message = print_message };
    nrd_vk_timing names[BENCH_MAX_PASSES];
    nrd *instance;
    desc.features = everything ? BENCH_OPTIONAL : 0;
    if (bench_instance(&desc, &instance)) return false;
    bool ok = bench_run_open(&running, &inputs, instance) && (!everything || bench_run_everything(&running)) && measure(o, names, count);
    for (uint32_t p = 0; ok && p < *count; p++) costs[p] = (cost){ names[p].name, median(o, p) };
    bench_run_close(&running);
    return ok;
}

/* Optional passes make the others slower, which are therefore timed without. */
static bool print_costs(const options *o, nrd_denoiser denoiser)
{
    cost usual[BENCH_MAX_PASSES], all[BENCH_MAX_PASSES];
    uint32_t usual_count = 0, count = 0;
    if (!measure_costs(o, denoiser, false, usual, &usual_count) || !measure_costs(o, denoiser, true, all, &count)) return false;
    for (uint32_t p = 0; p < count; p++) {
        float us = all[p].us;
        for (uint32_t u = 0; u < usual_count; u++) us = strcmp(usual[u].pass, all[p].pass) ? us : usual[u].us;
        printf("%s|%ux%u|%s|%s|%.4f\n", g.properties.deviceName, o->scene.width, o->scene.height, nrd_denoiser_name(denoiser), all[p].pass,
               1e3 * us / ((double)o->scene.width * o->scene.height));
    }
    return true;
}

static bool bench_costs(const options *o)
{
    bool ok = bench_open(&inputs, &g, &o->scene);
    for (uint32_t i = 0; ok && i < o->denoiser_count; i++) ok = print_costs(o, o->denoisers[i].denoiser);
    return ok;
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
        bool ok = (!strcmp(argv[i], "--size") && sscanf(value, "%ux%u", &o->scene.width, &o->scene.height) == 2 && o->scene.width && o->scene.height && o->scene.width <= 16384 && o->scene.height <= 16384)
               || (!strcmp(argv[i], "--frames") && (o->frames = (uint32_t)atoi(value)) > 0 && o->frames <= MAX_FRAMES)
               || (!strcmp(argv[i], "--penumbra") && parse_share(value, &o->scene.penumbra))
               || (!strcmp(argv[i], "--sky") && parse_share(value, &o->scene.sky))
               || (!strcmp(argv[i], "--rough") && parse_share(value, &o->scene.rough))
               || (!strcmp(argv[i], "--absent") && (!*value || settings_parse_absences(value, &o->absent)))
               || (!strcmp(argv[i], "--features") && sscanf(value, "%u", &o->features) == 1 && o->features <= NRD_FEATURE_ALL)
               || (!strcmp(argv[i], "--plan") && sscanf(value, "%u", &o->plan) == 1)
               || (!strcmp(argv[i], "--costs") && sscanf(value, "%u", &o->costs) == 1)
               || (!strcmp(argv[i], "--copy") && sscanf(value, "%f", &o->copy_mb) == 1 && o->copy_mb > 0 && o->copy_mb <= 16384)
               || (!strcmp(argv[i], "--denoiser") && parse_denoisers(value, o))
               || (!strcmp(argv[i], "--device") && sscanf(value, "%d", &o->device) == 1);
        if (!ok) return fprintf(stderr, "nrd-bench: %s %s: usage: nrd-bench [--denoiser NAME,...] [--size WxH] [--frames 1..%d] [--device N] [--penumbra 0..1] [--sky 0..1] [--rough 0..1] "
                                "[--absent NAME,...] [--features 0..%d] [--plan 0|1] [--costs 0|1] [--copy MB]\n", argv[i], value, MAX_FRAMES, NRD_FEATURE_ALL), false;
    }
    return true;
}

static void clean_up(void)
{
    bench_run_close(&running);
    bench_close(&inputs);
    gpu_close(&g);
    free(times_us);
}

int main(int argc, char **argv)
{
    options o = { .scene = { 1920, 1080, 0.2f, 0, 0 }, .frames = 60, .denoisers = { { 0, NRD_DENOISER_REBLUR_DIFFUSE } }, .denoiser_count = 1,
                  .names = "reblur_diffuse" };
    char error[256];
    if (!parse(argc, argv, &o)) return 2;
    bool ok = o.copy_mb > 0 || o.costs || (make_instance(&o) && print_plan(&o));
    gpu_desc desc = { .device_index = o.device };
    if (ok && !o.plan) {
        if (!gpu_open(&g, &desc, error, sizeof error)) return fprintf(stderr, "nrd-bench: %s\n", error), bench_run_close(&running), 1;
        times_us = malloc(o.frames * sizeof *times_us);
        ok = times_us && (o.copy_mb > 0 ? bench_copies(&o) : o.costs ? bench_costs(&o) : bench_denoisers(&o));
    }
    if (!ok) fprintf(stderr, "nrd-bench: failed. %s\n", gpu_error(&g));
    clean_up();
    return ok ? 0 : 1;
}
