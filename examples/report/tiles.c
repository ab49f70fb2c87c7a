#define _POSIX_C_SOURCE 200809L
#include "report/tiles.h"

#include "common/cli.h"
#include "report/bench.h"
#include "report/output.h"
#include "report/statistics.h"

#include <string.h>
#include <sys/stat.h>
#include <time.h>

enum { WARM_UP = 8 };        /* frames: after three, what is sky is left out */
#define WARM_UP_SECONDS 1.0 /* of a GPU's clock, which falls while the host makes a scene */

static const float sky_shares[REPORT_SKY_SHARES] = { 0, 0.25f, 0.5f, 0.75f, 1 };

static report_size size_of(const report *r)
{
    return r->options.time_size.width ? r->options.time_size : r->options.sizes[0];
}

/* ---- measuring ---- */

static bool open_runs(report *r, bench *b, bench_run *runs)
{
    const report_options *o = &r->options;
    for (uint32_t i = 0; i < o->denoiser_count; i++) {
        const nrd_denoiser_desc only = { 0, o->denoisers[i] };
        nrd_desc desc = { .width = b->scene.width, .height = b->scene.height, .denoisers = &only, .denoiser_count = 1 };
        nrd *instance;
        nrd_result result = bench_instance(&desc, &instance);
        if (result)
            return report_fail(r, "%s: %s", nrd_denoiser_name(o->denoisers[i]), nrd_result_string(result));
        if (!bench_run_open(&runs[i], b, instance))
            return report_fail(r, "%s: %s", nrd_denoiser_name(o->denoisers[i]), gpu_error(b->g));
    }
    return true;
}

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* One frame of each denoiser: in turn, so that what slows the device down for a while slows all of them. */
static bool run_round(report *r, bench_run *runs, double *ms)
{
    nrd_vk_timing passes[BENCH_MAX_PASSES];
    for (uint32_t i = 0; i < r->options.denoiser_count; i++) {
        uint32_t count;
        if (!bench_run_frame(&runs[i], passes, &count))
            return report_fail(r, "%s: %s", nrd_denoiser_name(r->options.denoisers[i]), gpu_error(&r->gpu));
        ms[i] = 0;
        for (uint32_t p = 0; p < count; p++)
            ms[i] += passes[p].nanoseconds * 1e-6;
    }
    return true;
}

static bool warm_up(report *r, bench_run *runs)
{
    double ms[NRD_DENOISER_COUNT], start = seconds_now();
    bool ok = true;
    for (int i = 0; ok && (i < WARM_UP || seconds_now() - start < WARM_UP_SECONDS); i++)
        ok = run_round(r, runs, ms);
    return ok;
}

static bool time_share(report *r, const bench_scene *scene, bench_run *runs)
{
    static double times[NRD_DENOISER_COUNT][REPORT_MAX_FRAMES];
    const report_options *o = &r->options;
    bool ok = warm_up(r, runs);
    for (int k = 0; ok && k < o->repeats; k++) {
        double ms[NRD_DENOISER_COUNT];
        ok = run_round(r, runs, ms);
        for (uint32_t i = 0; ok && i < o->denoiser_count; i++)
            times[i][k] = ms[i];
    }
    for (uint32_t i = 0; ok && i < o->denoiser_count; i++) {
        report_tiles *t = &r->tiles[r->tile_count++];
        *t = (report_tiles){ .width = (int)scene->width, .height = (int)scene->height, .sky = scene->sky, .active = bench_active_tiles(scene) };
        snprintf(t->denoiser, sizeof t->denoiser, "%s", nrd_denoiser_name(o->denoisers[i]));
        t->ms = quartiles(times[i], o->repeats, &t->low, &t->high);
    }
    return ok;
}

static bool time_shares(report *r, bench *b, bench_run *runs)
{
    bool ok = true;
    for (int s = 0; ok && s < REPORT_SKY_SHARES; s++) {
        ok = bench_set_sky(b, sky_shares[s]) ? time_share(r, &b->scene, runs) : report_fail(r, "%s", gpu_error(b->g));
        cli_progress("active tiles", s + 1, REPORT_SKY_SHARES);
    }
    return ok;
}

static bool measure(report *r)
{
    static bench_run runs[NRD_DENOISER_COUNT];
    const report_size size = size_of(r);
    const bench_scene scene = { (uint32_t)size.width, (uint32_t)size.height, 1, 0, 0 };
    bench b;
    r->tile_count = 0;
    bool ok = bench_open(&b, &r->gpu, &scene) ? open_runs(r, &b, runs) && time_shares(r, &b, runs) : report_fail(r, "%s", gpu_error(&r->gpu));
    for (uint32_t i = 0; i < r->options.denoiser_count; i++)
        bench_run_close(&runs[i]);
    bench_close(&b);
    return ok;
}

/* ---- the file of what is measured: what it depends on, a line per time, `end` ---- */

static void describe(const report *r, char *text, size_t text_size)
{
    const report_options *o = &r->options;
    report_size size = size_of(r);
    int n = snprintf(text, text_size, "options %016llx %d %d %dx%d", (unsigned long long)o->program, o->repeats, o->device, size.width, size.height);
    for (uint32_t i = 0; i < o->denoiser_count && n < (int)text_size; i++)
        n += snprintf(text + n, text_size - (size_t)n, " %s", nrd_denoiser_name(o->denoisers[i]));
}

bool tiles_load(report *r)
{
    char path[CAPTURE_PATH_SIZE], line[2048], options[2048];
    int wanted = REPORT_SKY_SHARES * (int)r->options.denoiser_count;
    snprintf(path, sizeof path, "%s/parts/tiles.txt", r->options.folder);
    describe(r, options, sizeof options);
    FILE *file = fopen(path, "r");
    bool ok = file && fgets(line, sizeof line, file) && !strncmp(line, options, strlen(options)) && line[strlen(options)] == '\n';
    for (r->tile_count = 0; ok && r->tile_count < wanted; r->tile_count++) {
        report_tiles *t = &r->tiles[r->tile_count];
        ok = fgets(line, sizeof line, file)
            && sscanf(line, "%63s %d %d %lf %lf %lf %lf %lf", t->denoiser, &t->width, &t->height, &t->sky, &t->active, &t->ms, &t->low, &t->high) == 8;
    }
    ok = ok && fgets(line, sizeof line, file) && !strcmp(line, "end\n");
    if (file)
        fclose(file);
    return ok;
}

static bool save(report *r)
{
    char path[CAPTURE_PATH_SIZE], options[2048];
    snprintf(path, sizeof path, "%s/parts", r->options.folder);
    mkdir(path, 0777);
    FILE *file = output_open(r, "parts/tiles.txt", path, sizeof path);
    if (!file)
        return false;
    describe(r, options, sizeof options);
    fprintf(file, "%s\n", options);
    for (int i = 0; i < r->tile_count; i++) {
        const report_tiles *t = &r->tiles[i];
        fprintf(file, "%s %d %d %.17g %.17g %.17g %.17g %.17g\n", t->denoiser, t->width, t->height, t->sky, t->active, t->ms, t->low, t->high);
    }
    fprintf(file, "end\n");
    return output_close(r, file, path);
}

bool tiles_measure(report *r)
{
    return measure(r) && save(r);
}

/* ---- what is shown ---- */

/* Times of a denoiser lie REPORT_SKY_SHARES times the number of denoisers apart: shares are the outer loop. */
static const report_tiles *of_share(const report *r, int denoiser, int share)
{
    return &r->tiles[share * (r->tile_count / REPORT_SKY_SHARES) + denoiser];
}

void tiles_print(const report *r)
{
    int denoisers = r->tile_count / REPORT_SKY_SHARES;
    printf("\ntime against the share of active tiles, synthetic scene under more and more sky, %dx%d\n%-44s", r->tiles[0].width, r->tiles[0].height, "tiles of 8x8 that are not all sky, %");
    for (int s = 0; s < REPORT_SKY_SHARES; s++)
        printf(" %8.1f", 100 * of_share(r, 0, s)->active);
    printf("\n");
    for (int i = 0; i < denoisers; i++) {
        double full = of_share(r, i, 0)->ms;
        printf("%-36s %6.4g ms", r->tiles[i].denoiser, full);
        for (int s = 0; s < REPORT_SKY_SHARES; s++)
            printf(" %6.1f %%", 100 * of_share(r, i, s)->ms / full);
        printf("\n");
    }
}

bool tiles_csv(report *r)
{
    char path[CAPTURE_PATH_SIZE];
    FILE *file = output_open(r, "tiles.csv", path, sizeof path);
    if (!file)
        return false;
    fprintf(file, "device,denoiser,time_width,time_height,sky,active,ms,ms_low,ms_high\n");
    for (int i = 0; i < r->tile_count; i++) {
        const report_tiles *t = &r->tiles[i];
        fprintf(file, "\"%s\",%s,%d,%d,%g,%.6g,%.9g,%.9g,%.9g\n", r->device, t->denoiser, t->width, t->height, t->sky, t->active, t->ms, t->low, t->high);
    }
    return output_close(r, file, path);
}

void tiles_json(const report *r, FILE *file)
{
    fprintf(file, "[");
    for (int i = 0; i < r->tile_count; i++) {
        const report_tiles *t = &r->tiles[i];
        fprintf(file, "%s\n{\"denoiser\":\"%s\",\"width\":%d,\"height\":%d,\"sky\":%g,\"active\":%.6g,\"ms\":%.6g,\"low\":%.6g,\"high\":%.6g}", i ? "," : "", t->denoiser,
                t->width, t->height, t->sky, t->active, t->ms, t->low, t->high);
    }
    fprintf(file, "]");
}
