/* nrd-report: what a millisecond buys: error against run time of every denoiser of nrd.h, on scenes rendered on the device
   that denoises them. See report/report.h. */
#define _POSIX_C_SOURCE 200809L
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "nrd_spirv.h"

#include "common/cli.h"
#include "report/output.h"
#include "report/report.h"
#include "report/statistics.h"
#include "report/tiles.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

static const char usage[] =
    "usage: nrd-report OUT/ [options]\n"
    "Writes report.html, report.csv, tiles.csv and report.json to OUT/, a table to stdout. Groups that are measured already are kept:\n"
    "an interrupted run goes on where it stopped.\n"
    "  --quick            three scenes, one path per pixel, few frames, small pictures: minutes\n"
    "  --scenes LIST      default: all but the one that needs a mesh; on those made for shadows shadows alone\n"
    "  --denoisers LIST   default: all; reference, a baseline, is always one of them\n"
    "  --presets LIST     default: all; balanced, to which baselines are compared, is always one of them\n"
    "  --variant NAME:KEY=VALUE,...  settings to measure beside the presets; up to 24\n"
    "  --paths LIST       per pixel and lobe, 0.05 to 1 or a whole number up to 8; 0.5c and less: as a checkerboard;\n"
    "                     default 0.25,0.25c,0.5,0.5c,1,2,4\n"
    "  --sizes LIST       WxH of the pictures, default 160x90 on a CPU, 640x360 on a GPU\n"
    "  --time-size WxH    at which times are taken, default: that of the pictures on a CPU, 1920x1080 on a GPU\n"
    "  --frames M,R,L     frames in motion, at rest, after the light step; default 12,8,10 on a CPU, 24,16,16 on a GPU\n"
    "  --pairs N          pairs of frames in motion that are compared with a reference, default 2\n"
    "  --ref SPP          samples per pixel of references, default 64 on a CPU, 1024 on a GPU\n"
    "  --repeats N        timed frames, default 24\n"
    "  --device N         Vulkan device, default: the first\n";

/* ---- options ---- */

/* Calls `take` for each word between commas. */
static bool each_word(report *r, const char *list, bool (*take)(report *r, const char *word))
{
    char copy[2048];
    snprintf(copy, sizeof copy, "%s", list);
    for (char *word = copy, *next; word; word = next) {
        next = strchr(word, ',');
        if (next)
            *next++ = 0;
        if (!take(r, word))
            return false;
    }
    return true;
}

static bool take_scene(report *r, const char *word)
{
    report_options *o = &r->options;
    const scene_def *found = scene_find(word);
    if (!found || !strcmp(word, "model"))
        return report_fail(r, "--scenes: '%s' is no scene that can be rendered here", word);
    if (o->scene_count == REPORT_MAX_SCENES)
        return report_fail(r, "--scenes: at most %d", REPORT_MAX_SCENES);
    o->scenes[o->scene_count++] = found;
    return true;
}

static bool has_denoiser(const report_options *o, nrd_denoiser denoiser)
{
    bool has = false;
    for (uint32_t i = 0; i < o->denoiser_count; i++)
        has |= o->denoisers[i] == denoiser;
    return has;
}

static bool has_preset(const report_options *o, nrd_preset preset)
{
    bool has = false;
    for (uint32_t i = 0; i < o->preset_count; i++)
        has |= o->presets[i] == preset;
    return has;
}

static bool take_denoiser(report *r, const char *word)
{
    report_options *o = &r->options;
    nrd_denoiser found;
    if (nrd_find_denoiser(word, &found))
        return report_fail(r, "--denoisers: '%s' is no denoiser", word);
    if (has_denoiser(o, found))
        return report_fail(r, "--denoisers: '%s' is named twice", word);
    o->denoisers[o->denoiser_count++] = found;
    return true;
}

static bool take_preset(report *r, const char *word)
{
    report_options *o = &r->options;
    for (int i = 0; i < NRD_PRESET_COUNT; i++)
        if (!strcmp(word, nrd_preset_name((nrd_preset)i)) && !has_preset(o, (nrd_preset)i)) {
            o->presets[o->preset_count++] = (nrd_preset)i;
            return true;
        }
    return report_fail(r, "--presets: '%s' is no preset, or named twice", word);
}

static bool take_paths(report *r, const char *word)
{
    report_options *o = &r->options;
    char number[32];
    double value;
    size_t length = strlen(word);
    bool checkerboard = length > 1 && word[length - 1] == 'c';
    snprintf(number, sizeof number, "%.*s", (int)(length - checkerboard), word);
    if (!cli_number(number, &value) || value < 0.05 || value > 8 || (value > 1 && value != floor(value)) || (checkerboard && value > 0.5))
        return report_fail(r, "--paths: '%s' is not in [0.05, 1] (with c: [0.05, 0.5]) and no whole number up to 8", word);
    if (o->path_count == REPORT_MAX_PATHS)
        return report_fail(r, "--paths: at most %d", REPORT_MAX_PATHS);
    o->paths[o->path_count++] = (report_paths){ value, checkerboard };
    return true;
}

static bool parse_size(report *r, const char *name, const char *word, report_size *out)
{
    char tail;
    if (sscanf(word, "%dx%d%c", &out->width, &out->height, &tail) == 2 && out->width >= 16 && out->height >= 16 && out->width <= 4096 && out->height <= 4096)
        return true;
    return report_fail(r, "%s: '%s' is not WxH with both in [16, 4096]", name, word);
}

static bool take_size(report *r, const char *word)
{
    report_options *o = &r->options;
    if (o->size_count == REPORT_MAX_SIZES)
        return report_fail(r, "--sizes: at most %d", REPORT_MAX_SIZES);
    return parse_size(r, "--sizes", word, &o->sizes[o->size_count++]);
}

/* NAME:KEY=VALUE,KEY=VALUE; keeps pointers into `text`. */
static bool take_variant(report *r, char *text)
{
    report_options *o = &r->options;
    char *at = strchr(text, ':');
    if (!at || at == text || at - text >= REPORT_NAME || strpbrk(text, " \"<>") || o->variant_count == REPORT_MAX_VARIANTS)
        return report_fail(r, "--variant: '%s' is not NAME:KEY=VALUE,..., or one of more than %d", text, REPORT_MAX_VARIANTS);
    report_variant *v = &o->variants[o->variant_count++];
    snprintf(v->name, sizeof v->name, "%.*s", (int)(at - text), text);
    for (char *word = at + 1; word && v->count < REPORT_MAX_SETTINGS;) {
        v->settings[v->count++] = word;
        word = strchr(word, ',');
        if (word)
            *word++ = 0;
    }
    return true;
}

static bool take_integer(report *r, const char *name, const char *value, long low, long high, int *out)
{
    long number;
    if (!cli_integer(value, low, high, &number))
        return report_fail(r, "%s: '%s' is not a whole number in [%ld, %ld]", name, value, low, high);
    *out = (int)number;
    return true;
}

static bool take_frames(report *r, const char *value)
{
    report_options *o = &r->options;
    char tail;
    if (sscanf(value, "%d,%d,%d%c", &o->moving, &o->still, &o->stepped, &tail) == 3 && o->moving >= 2 && o->still >= 2 && o->stepped >= 0
        && o->moving <= REPORT_MAX_FRAMES && o->still <= REPORT_MAX_FRAMES && o->stepped <= REPORT_MAX_FRAMES
        && o->moving + o->still + o->stepped <= REPORT_MAX_FRAMES)
        return true;
    return report_fail(r, "--frames: '%s' is not M,R,L with M and R at least 2 and a sum of at most %d", value, REPORT_MAX_FRAMES);
}

static bool take_option(report *r, const char *name, char *value)
{
    report_options *o = &r->options;
    if (!strcmp(name, "--scenes")) return each_word(r, value, take_scene);
    if (!strcmp(name, "--denoisers")) return each_word(r, value, take_denoiser);
    if (!strcmp(name, "--presets")) return each_word(r, value, take_preset);
    if (!strcmp(name, "--paths")) return each_word(r, value, take_paths);
    if (!strcmp(name, "--sizes")) return each_word(r, value, take_size);
    if (!strcmp(name, "--time-size")) return parse_size(r, name, value, &o->time_size);
    if (!strcmp(name, "--variant")) return take_variant(r, value);
    if (!strcmp(name, "--frames")) return take_frames(r, value);
    if (!strcmp(name, "--pairs")) return take_integer(r, name, value, 1, 64, &o->pairs);
    if (!strcmp(name, "--ref")) return take_integer(r, name, value, 2, 1 << 20, &o->samples);
    if (!strcmp(name, "--repeats")) return take_integer(r, name, value, 1, REPORT_MAX_FRAMES, &o->repeats);
    if (!strcmp(name, "--device")) return take_integer(r, name, value, 0, 63, &o->device);
    return report_fail(r, "%s: unknown option", name);
}

static void add_baselines(report_options *o)
{
    if (!has_denoiser(o, NRD_DENOISER_REFERENCE))
        o->denoisers[o->denoiser_count++] = NRD_DENOISER_REFERENCE;
    if (!has_preset(o, NRD_PRESET_BALANCED))
        o->presets[o->preset_count++] = NRD_PRESET_BALANCED;
}

/* What was not said. */
static bool set_defaults(report *r, bool quick)
{
    report_options *o = &r->options;
    bool cpu = r->gpu.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU, ok = true;
    bool all_scenes = !o->scene_count && !quick;
    if (ok && !o->scene_count && quick)
        ok = each_word(r, "interior,moving,glass", take_scene);
    for (int i = 0; i < scene_table_count && ok && all_scenes; i++)
        if (strcmp(scene_table[i].name, "model") != 0)
            ok = take_scene(r, scene_table[i].name);
    for (int i = 0; ok && !o->denoiser_count && i < NRD_DENOISER_COUNT; i++)
        o->denoisers[i] = (nrd_denoiser)i;
    o->denoiser_count = o->denoiser_count ? o->denoiser_count : NRD_DENOISER_COUNT;
    for (int i = 0; ok && !o->preset_count && i < NRD_PRESET_COUNT; i++)
        o->presets[i] = (nrd_preset)i;
    o->preset_count = o->preset_count ? o->preset_count : NRD_PRESET_COUNT;
    add_baselines(o);
    if (ok && !o->path_count)
        ok = each_word(r, quick ? "1" : "0.25,0.25c,0.5,0.5c,1,2,4", take_paths);
    if (ok && !o->size_count)
        ok = each_word(r, !cpu ? "640x360" : quick ? "128x72" : "160x90", take_size);
    if (!o->time_size.width && !cpu)
        o->time_size = (report_size){ 1920, 1080 };
    if (!o->moving)
        ok = ok && take_frames(r, quick ? "10,8,8" : cpu ? "12,8,10" : "24,16,16");
    o->pairs = o->pairs ? o->pairs : quick ? 1 : 2;
    o->samples = (o->samples ? o->samples : cpu ? 64 : 1024) / 2 * 2;
    o->repeats = o->repeats ? o->repeats : quick ? 8 : 24;
    if (ok && 2 * o->pairs > o->moving)
        ok = report_fail(r, "--pairs: %d pairs do not fit into %d frames", o->pairs, o->moving);
    return ok;
}

/* Rows of another build are not mixed with those of this one. */
static bool fingerprint_program(report *r)
{
    static unsigned char bytes[65536];
    FILE *file = fopen("/proc/self/exe", "rb");
    if (!file)
        return report_fail(r, "/proc/self/exe: cannot read");
    r->options.program = FINGERPRINT_START;
    for (size_t n; (n = fread(bytes, 1, sizeof bytes, file)) > 0;)
        r->options.program = fingerprint(r->options.program, bytes, n);
    fclose(file);
    return true;
}

static bool parse(int argc, char **argv, report *r)
{
    bool quick = false;
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--quick")) {
            quick = true;
        } else if (argv[i][0] == '-') {
            if (i + 1 == argc)
                return report_fail(r, "%s: value missing, or unknown option", argv[i]);
            if (!take_option(r, argv[i], argv[i + 1]))
                return false;
            i++;
        } else if (r->options.folder) {
            return report_fail(r, "'%s': one folder is enough", argv[i]);
        } else {
            r->options.folder = argv[i];
        }
    }
    if (!r->options.folder)
        return report_fail(r, "no output folder given");
    const gpu_desc device = { .device_index = r->options.device };
    if (!gpu_open(&r->gpu, &device, r->error, sizeof r->error))
        return false;
    snprintf(r->device, sizeof r->device, "%s", r->gpu.properties.deviceName);
    return set_defaults(r, quick);
}

/* ---- the program ---- */

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool measure_group(report *r, const report_group *group, int done, int total)
{
    double start = seconds_now();
    int first = r->rows.count;
    if (rows_load(r, group))
        return true;
    if (!report_measure(r, group, done, total) || !rows_save(r, group, first))
        return false;
    fprintf(stderr, "%d of %d: %s %dx%d, %g%s paths per pixel: %d rows in %.1f s\n", done + 1, total, group->scene->name, group->size.width, group->size.height,
            group->paths.count, group->paths.checkerboard ? "c" : "", r->rows.count - first, seconds_now() - start);
    return true;
}

/* Shadows have one ray per pixel, whatever the number of paths. */
static bool paths_matter(const report_options *o, int scene, int paths)
{
    return !o->scenes[scene]->for_shadows || report_same_paths(o->paths[paths], report_usual_paths(o));
}

static bool measure_all(report *r)
{
    const report_options *o = &r->options;
    int done = 0, total = 0;
    for (int s = 0; s < o->scene_count; s++)
        for (int p = 0; p < o->path_count; p++)
            total += paths_matter(o, s, p) ? o->size_count : 0;
    for (int s = 0; s < o->scene_count; s++)
        for (int z = 0; z < o->size_count; z++)
            for (int p = 0; p < o->path_count; p++) {
                const report_group group = { o->scenes[s], o->sizes[z], o->paths[p] };
                if (paths_matter(o, s, p) && !measure_group(r, &group, done++, total))
                    return false;
            }
    return true;
}

static bool measure_tiles(report *r)
{
    double start = seconds_now();
    if (tiles_load(r))
        return true;
    if (!tiles_measure(r))
        return false;
    fprintf(stderr, "time against active tiles: %d times, %.1f s\n", r->tile_count, seconds_now() - start);
    return true;
}

static bool run(report *r)
{
    if (mkdir(r->options.folder, 0777) != 0 && errno != EEXIST)
        return report_fail(r, "%s: %s", r->options.folder, strerror(errno));
    if (!fingerprint_program(r) || !measure_all(r) || !measure_tiles(r) || !print_csv(r) || !tiles_csv(r) || !print_json(r) || !print_page(r))
        return false;
    print_table(r);
    printf("\n%s/report.html\n", r->options.folder);
    return true;
}

int main(int argc, char **argv)
{
    static report r;
    if (argc == 1) return fputs(usage, stderr), 2;
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h")) return fputs(usage, stdout), 0;
    if (!parse(argc, argv, &r)) return cli_fail("nrd-report", "%s", r.error), gpu_close(&r.gpu), 2;
    bool ok = run(&r);
    free(r.rows.rows);
    gpu_close(&r.gpu);
    return ok ? 0 : cli_fail("nrd-report", "%s", r.error);
}
