/* nrd-denoise: denoises a capture folder into a denoised capture. */
#define _POSIX_C_SOURCE 200809L
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#define VK_NO_PROTOTYPES
#include "nrd_vk.h"

#include "common/capture.h"
#include "common/cli.h"
#include "common/denoise.h"
#include "common/png.h"
#include "common/settings.h"
#include "common/signals.h"
#include "common/thin.h"
#include "report/statistics.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAX_SETTINGS 64

static const char usage[] =
    "usage: nrd-denoise --denoiser NAME[,NAME...] [options] IN OUT\n"
    "       nrd-denoise --denoiser NAME[,NAME...] --info|--explain[=text|json|dot] [--size WxH] [options]\n"
    "       nrd-denoise --check [--denoiser NAME[,NAME...]] IN\n"
    "Denoises the frames of capture folder IN into folder OUT.\n"
    "  --set KEY=VALUE     a setting of the denoisers or of the frame; DENOISER.KEY=VALUE for one of several\n"
    "  --signal NAME       what `reference` averages: diffuse (default), specular, shadow, ao, final\n"
    "  --absent NAME,...   what the frames do not need (nrd_desc.absent): motion, sky, materials, ...\n"
    "  --thin MODE         makes what a renderer with half the paths has: `lobes` keeps one lobe per pixel, at random;\n"
    "                      `checkerboard` keeps alternating ones (sets diffuse_checkerboard=1, specular_checkerboard=2)\n"
    "  --frames A:B        only these frames\n"
    "  --csv FILE          writes frame,pass,milliseconds\n"
    "  --device N          the N-th Vulkan device, from 0\n"
    "  --validate          under the Vulkan validation layer, with synchronisation checks; fails on any message\n"
    "  --explain[=FORMAT]  lists what these settings keep and leave out, why, and what that saves: text, json, dot (Graphviz)\n"
    "  --check             says which rules the inputs break and in what share of pixels; exit status 1 if any. Without --denoiser\n"
    "                      the inputs of all that IN has\n"
    "  --overlay DIR       also writes DIR/validation.0000.png, ...: what the first denoiser gets and remembers (README: When the picture\n"
    "                      is wrong); --set validation=2 for the second\n"
    "  --info              lists passes, textures, bytes and settings (for 1920x1080), touches no GPU\n";

typedef struct options {
    denoise_desc desc;
    setting_value settings[MAX_SETTINGS];
    const char *set_texts[MAX_SETTINGS]; /* parsed when the denoisers are known */
    uint32_t set_count;
    const char *denoisers, *in, *out, *csv, *overlay;
    long first, last;      /* frames; -1: as in IN */
    bool info, explain, thin_lobes;
    nrd_explain_format explain_format;
    long width, height;    /* of --info and --explain */
} options;

typedef struct program {
    options opt;
    char error[CLI_ERROR_SIZE];
    denoise *d;
    FILE *csv;
    char csv_part[CAPTURE_PATH_SIZE];
    uint64_t counters[NRD_COUNTER_COUNT]; /* of --check */
    bool made_folder, made_overlay;
    unsigned char *rgb;    /* of the overlay */
    int written;
    double *frame_ms;      /* sum of the passes, per written frame */
} program;

static bool fail(program *p, const char *what, const char *text)
{
    snprintf(p->error, sizeof p->error, "%s%s", what, text);
    return false;
}

/* ---- arguments ---- */

static bool parse_frames(program *p, const char *text)
{
    const char *colon = strchr(text, ':');
    char first[16] = "";
    if (colon && colon - text < (int)sizeof first)
        memcpy(first, text, (size_t)(colon - text));
    if (!cli_integer(first, 0, INT_MAX, &p->opt.first) || !cli_integer(colon + 1, p->opt.first, INT_MAX, &p->opt.last))
        return fail(p, text, ": --frames needs A:B with 0 <= A <= B");
    return true;
}

static bool parse_size(program *p, const char *text)
{
    const char *cross = strchr(text, 'x');
    char width[16] = "";
    if (cross && cross - text < (int)sizeof width)
        memcpy(width, text, (size_t)(cross - text));
    if (!cli_integer(width, 1, 16384, &p->opt.width) || !cli_integer(cross + 1, 1, 16384, &p->opt.height))
        return fail(p, text, ": --size needs WIDTHxHEIGHT, each 1..16384");
    return true;
}

static bool parse_set(program *p, const char *text)
{
    if (p->opt.set_count == MAX_SETTINGS)
        return fail(p, text, ": too many --set");
    p->opt.set_texts[p->opt.set_count++] = text;
    return true;
}

static bool parse_device(program *p, const char *text)
{
    long device;
    if (!cli_integer(text, 0, 255, &device))
        return fail(p, text, ": --device needs a number in 0..255");
    p->opt.desc.device_index = (int)device;
    return true;
}

static bool parse_signal(program *p, const char *text)
{
    return signal_find(text, &p->opt.desc.reference_signal)
        || fail(p, text, ": unknown signal; known: diffuse, specular, shadow, ao, final, translucency");
}

static bool parse_absent(program *p, const char *text)
{
    if (settings_parse_absences(text, &p->opt.desc.absent))
        return true;
    int used = snprintf(p->error, sizeof p->error, "%s: --absent needs names, separated by commas, of:", text);
    for (uint32_t i = 0; nrd_absence_name(i); i++)
        used += snprintf(p->error + used, sizeof p->error - (size_t)used, " %s", nrd_absence_name(i));
    return false;
}

static bool parse_thin(program *p, const char *text)
{
    if (!strcmp(text, "checkerboard"))
        return parse_set(p, "diffuse_checkerboard=1") && parse_set(p, "specular_checkerboard=2");
    p->opt.thin_lobes = !strcmp(text, "lobes");
    return p->opt.thin_lobes || fail(p, text, ": --thin knows lobes, checkerboard");
}

static bool parse_csv(program *p, const char *text)
{
    p->opt.csv = text;
    return true;
}

static bool parse_overlay(program *p, const char *text)
{
    p->opt.overlay = text;
    return p->opt.desc.overlay = true;
}

static bool parse_denoisers(program *p, const char *text)
{
    p->opt.denoisers = text;
    return true;
}

/* --explain or --explain=FORMAT */
static bool parse_explain(program *p, const char *name)
{
    static const struct { const char *name; nrd_explain_format format; } rows[] = {
        { "", NRD_EXPLAIN_TEXT }, { "=text", NRD_EXPLAIN_TEXT }, { "=json", NRD_EXPLAIN_JSON }, { "=dot", NRD_EXPLAIN_GRAPHVIZ },
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (strcmp(name + strlen("--explain"), rows[i].name))
            continue;
        p->opt.explain_format = rows[i].format;
        return p->opt.explain = true;
    }
    return fail(p, name, ": formats are text, json and dot");
}

static bool set_flag(program *p, const char *name)
{
    if (!strncmp(name, "--explain", strlen("--explain")))
        return parse_explain(p, name);
    if (!strcmp(name, "--info"))
        return p->opt.info = true;
    if (!strcmp(name, "--check"))
        return p->opt.desc.check = true;
    if (!strcmp(name, "--validate"))
        return p->opt.desc.validate = true;
    return fail(p, name, ": unknown option; try --help");
}

static bool parse_argument(program *p, int argc, char **argv, int *i)
{
    static const struct { const char *name; bool (*parse)(program *, const char *); } with_value[] = {
        { "--denoiser", parse_denoisers }, { "--set", parse_set }, { "--signal", parse_signal }, { "--frames", parse_frames },
        { "--csv", parse_csv }, { "--overlay", parse_overlay }, { "--device", parse_device }, { "--absent", parse_absent }, { "--size", parse_size },
        { "--thin", parse_thin },
    };
    const char *name = argv[*i];
    for (size_t k = 0; k < sizeof with_value / sizeof *with_value; k++) {
        if (strcmp(name, with_value[k].name))
            continue;
        const char *value = cli_value(argc, argv, i);
        return value ? with_value[k].parse(p, value) : fail(p, name, " needs a value");
    }
    if (name[0] == '-')
        return set_flag(p, name);
    if (p->opt.in && p->opt.out)
        return fail(p, name, ": unexpected argument; try --help");
    *(p->opt.in ? &p->opt.out : &p->opt.in) = name;
    return true;
}

static bool fail_unknown_denoiser(program *p, const char *name)
{
    int used = snprintf(p->error, sizeof p->error, "unknown denoiser %s; known:", name);
    for (int i = 0; i < NRD_DENOISER_COUNT; i++)
        used += snprintf(p->error + used, sizeof p->error - (size_t)used, "%s %s", i ? "," : "", nrd_denoiser_name((nrd_denoiser)i));
    return false;
}

/* Splits NAME,NAME,... */
static bool find_denoisers(program *p)
{
    denoise_desc *desc = &p->opt.desc;
    const char *at = p->opt.denoisers;
    if (!at)
        return fail(p, "", "no --denoiser given; try --help");
    for (;;) {
        char name[64];
        size_t length = strcspn(at, ",");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        if (desc->denoiser_count == DENOISE_MAX_DENOISERS)
            return fail(p, p->opt.denoisers, ": too many denoisers");
        if (nrd_find_denoiser(name, &desc->denoisers[desc->denoiser_count++]) != NRD_RESULT_OK)
            return fail_unknown_denoiser(p, name);
        if (!at[length])
            return true;
        at += length + 1;
    }
}

/* Those that between them read every input that the first frame has. */
static bool choose_denoisers(program *p)
{
    static const struct { const char *plane, *distance; nrd_denoiser denoiser; } rows[] = {
        { "diffuse.R", "diffuse.hitT", NRD_DENOISER_REBLUR_DIFFUSE }, { "specular.R", "specular.hitT", NRD_DENOISER_REBLUR_SPECULAR },
        { "diffuse.dir.X", "diffuse.hitT", NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION },
        { "shadow.translucency.R", "shadow.hitT", NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY },
        { "shadow.hitT", "shadow.hitT", NRD_DENOISER_SIGMA_SHADOW },
    };
    capture frame;
    int first, last;
    char path[CAPTURE_PATH_SIZE];
    denoise_desc *desc = &p->opt.desc;
    if (!capture_frame_range(p->opt.in, &first, &last, p->error, sizeof p->error))
        return false;
    capture_frame_path(path, sizeof path, p->opt.in, first);
    if (!capture_read(path, &frame, p->error, sizeof p->error))
        return false;
    bool shadow = false;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (!capture_find_plane(&frame, rows[i].plane) || !capture_find_plane(&frame, rows[i].distance) || (shadow && rows[i].denoiser == NRD_DENOISER_SIGMA_SHADOW))
            continue;
        shadow = shadow || rows[i].denoiser == NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY;
        desc->denoisers[desc->denoiser_count++] = rows[i].denoiser;
    }
    capture_destroy(&frame);
    return desc->denoiser_count || fail(p, p->opt.in, ": has nothing to denoise");
}

static bool parse(program *p, int argc, char **argv)
{
    options *opt = &p->opt;
    opt->first = opt->last = opt->desc.device_index = -1;
    opt->width = 1920;
    opt->height = 1080;
    for (int i = 1; i < argc; i++)
        if (!parse_argument(p, argc, argv, &i))
            return false;
    if (opt->desc.check && !opt->denoisers && !(opt->in && choose_denoisers(p)))
        return opt->in ? false : fail(p, "", "--check needs an input folder; try --help");
    if (!opt->desc.denoiser_count && !find_denoisers(p))
        return false;
    for (uint32_t i = 0; i < opt->set_count; i++)
        if (!setting_parse(opt->set_texts[i], opt->desc.denoisers, opt->desc.denoiser_count, &opt->settings[i], p->error, sizeof p->error))
            return false;
    opt->desc.settings = opt->settings;
    opt->desc.setting_count = opt->set_count;
    if (opt->info || opt->explain)
        return !opt->in || fail(p, opt->info ? "--info" : "--explain", " takes no folders");
    if (opt->desc.check)
        return (opt->in && !opt->out) || fail(p, "", "--check takes one folder");
    return (opt->in && opt->out) || fail(p, "", "needs an input and an output folder; try --help");
}

/* ---- --info ---- */

static const char *format_name(nrd_format format)
{
    static const char *const names[] = {
#define FORMAT_NAME(name, bytes, is_uint) #name,
        NRD_FORMATS(FORMAT_NAME)
#undef FORMAT_NAME
    };
    return names[format];
}

static double mib(uint64_t bytes)
{
    return (double)bytes / 1048576.0;
}

static void print_passes(const nrd_info *info)
{
    printf("%u passes\n", info->pass_count);
    for (uint32_t i = 0; i < info->pass_count; i++)
        printf("  %2u  %-32s %s\n", i, info->passes[i].name, info->pipelines[info->passes[i].pipeline].shader);
}

static void print_textures(const nrd_info *info)
{
    printf("%u textures\n", info->texture_count);
    for (uint32_t i = 0; i < info->texture_count; i++) {
        const nrd_texture *t = &info->textures[i];
        printf("  %-32s %-13s %5ux%-5u %9.2f MiB  ", t->name, format_name(t->format), t->width, t->height, mib(t->bytes));
        if (t->permanent)
            printf("permanent\n");
        else
            printf("transient, passes %u..%u\n", t->first_pass, t->last_pass);
    }
    for (uint32_t i = 0; i < info->left_out_count; i++)
        printf("  left out: %s (%s), saves %.2f MiB\n", info->left_out[i].what, info->left_out[i].why, mib(info->left_out[i].bytes_saved));
    printf("permanent %.2f MiB, transient %.2f MiB (%.2f MiB without sharing), together %.2f MiB\n", mib(info->permanent_bytes),
           mib(info->transient_bytes), mib(info->transient_unshared_bytes), mib(info->permanent_bytes + info->transient_bytes));
}

static void print_settings(const char *owner_name, nrd_denoiser owner)
{
    nrd_setting s;
    printf("settings of %s: name, default, range, unit, meaning\n", owner_name);
    for (uint32_t i = 0; nrd_get_setting(owner, i, &s); i++)
        printf("  %-44s %8g  %g..%g %s: %s\n", s.name, s.value, s.min, s.max, s.unit, s.text);
}

static bool print_info(program *p)
{
    capture frame;
    denoise_sink sink = { p->error, sizeof p->error };
    capture_create(&frame, (int)p->opt.width, (int)p->opt.height);
    nrd *instance = denoise_make_instance(&p->opt.desc, &frame, &sink);
    if (!instance)
        return false;
    printf("%s at %ldx%ld\n", p->opt.denoisers, p->opt.width, p->opt.height);
    print_passes(nrd_get_info(instance));
    print_textures(nrd_get_info(instance));
    for (uint32_t i = 0; i < p->opt.desc.denoiser_count; i++)
        print_settings(nrd_denoiser_name(p->opt.desc.denoisers[i]), p->opt.desc.denoisers[i]);
    print_settings("the frame", SETTINGS_OF_FRAME);
    nrd_destroy(instance);
    return true;
}

/* A frame of any camera, with the frame settings that are given. */
static bool set_any_frame(program *p, nrd *instance)
{
    static const float projection[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, -0.1f, 0 }, identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    nrd_frame frame = nrd_frame_defaults();
    memcpy(frame.camera.view_to_clip, projection, sizeof projection);
    memcpy(frame.camera.world_to_view, identity, sizeof identity);
    settings_apply(p->opt.settings, p->opt.set_count, SETTINGS_OF_FRAME, 1, &frame);
    return nrd_set_frame(instance, &frame) == NRD_RESULT_OK;
}

static bool print_explanation(program *p)
{
    capture frame;
    denoise_sink sink = { p->error, sizeof p->error };
    capture_create(&frame, (int)p->opt.width, (int)p->opt.height);
    nrd *instance = denoise_make_instance(&p->opt.desc, &frame, &sink);
    if (!instance || !set_any_frame(p, instance)) {
        nrd_destroy(instance);
        return false;
    }
    size_t size = nrd_explain(instance, p->opt.explain_format, NULL, 0) + 1;
    char *text = malloc(size);
    if (text) {
        nrd_explain(instance, p->opt.explain_format, text, size);
        fputs(text, stdout);
    }
    free(text);
    nrd_destroy(instance);
    return text || fail(p, "", "out of memory");
}

/* ---- files ---- */

/* Fills in --frames and checks it. */
static bool find_frames(program *p)
{
    int first, last;
    options *opt = &p->opt;
    if (!capture_frame_range(opt->in, &first, &last, p->error, sizeof p->error))
        return false;
    if (opt->first < 0) {
        opt->first = first;
        opt->last = last;
    }
    if (opt->first < first || opt->last > last) {
        snprintf(p->error, sizeof p->error, "%s: holds frames %d..%d, asked for %ld..%ld", opt->in, first, last, opt->first, opt->last);
        return false;
    }
    return true;
}

/* Creates a folder where it is not there; refuses to write over IN. */
static bool open_folder(program *p, const char *path, bool *made)
{
    struct stat in, out;
    if (stat(path, &out) == 0) {
        if (!S_ISDIR(out.st_mode))
            return fail(p, path, ": is not a folder");
        if (stat(p->opt.in, &in) == 0 && in.st_dev == out.st_dev && in.st_ino == out.st_ino)
            return fail(p, path, ": is the input folder; its frames would be overwritten");
        return access(path, W_OK) == 0 || fail(p, path, ": the folder cannot be written to");
    }
    if (mkdir(path, 0777)) {
        snprintf(p->error, sizeof p->error, "%s: cannot create the folder: %s", path, strerror(errno));
        return false;
    }
    return *made = true;
}

static bool open_csv(program *p)
{
    if (!p->opt.csv)
        return true;
    if (snprintf(p->csv_part, sizeof p->csv_part, "%s.part", p->opt.csv) >= (int)sizeof p->csv_part)
        return fail(p, p->opt.csv, ": the path is too long");
    p->csv = fopen(p->csv_part, "w");
    if (!p->csv) {
        snprintf(p->error, sizeof p->error, "%s: cannot write: %s", p->opt.csv, strerror(errno));
        return false;
    }
    fprintf(p->csv, "frame,pass,milliseconds\n");
    return true;
}

/* Renames the finished file, or removes an unfinished one. */
static bool close_csv(program *p, bool finished)
{
    if (!p->csv)
        return true;
    bool ok = !ferror(p->csv);
    ok = fclose(p->csv) == 0 && ok;
    p->csv = NULL;
    if (finished && ok && rename(p->csv_part, p->opt.csv) == 0)
        return true;
    remove(p->csv_part);
    return !finished || fail(p, p->opt.csv, ": cannot write");
}

/* ---- --check ---- */

static bool print_findings(program *p)
{
    nrd_finding f;
    uint32_t broken = 0;
    printf("%-20s %9s %9s\n", "rule", "share", "allowed");
    for (uint32_t i = 0; nrd_check_rule(p->counters, i, &f); i++) {
        broken += f.broken;
        printf("%-20s ", f.name);
        if (!f.judged)
            printf("%9s %8.1f%%  nothing to judge it by\n", "-", 100 * f.allowed);
        else
            printf("%8.3f%% %8.1f%%  %s%s\n", 100 * f.share, 100 * f.allowed, f.broken ? "BROKEN: " : "ok", f.broken ? f.text : "");
        if (f.cause[0])
            printf("%40s  likely: %s\n", "", f.cause);
    }
    if (broken)
        snprintf(p->error, sizeof p->error, "%s: the inputs break %u rule%s, see above", p->opt.in, broken, broken > 1 ? "s" : "");
    return broken == 0;
}

/* ---- denoising ---- */

static void note_timings(program *p, int frame)
{
    uint32_t count;
    double sum = 0;
    const denoise_timing *timings = denoise_timings(p->d, &count);
    for (uint32_t i = 0; i < count; i++) {
        sum += timings[i].milliseconds;
        if (p->csv)
            fprintf(p->csv, "%d,%s,%.6f\n", frame, timings[i].pass, timings[i].milliseconds);
    }
    p->frame_ms[p->written++] = sum;
}

static bool write_overlay(program *p, int number, const capture *frame)
{
    char path[CAPTURE_PATH_SIZE];
    if (!p->opt.overlay)
        return true;
    if (snprintf(path, sizeof path, "%s/validation.%04d.png", p->opt.overlay, number) >= (int)sizeof path)
        return fail(p, p->opt.overlay, ": the path is too long");
    return denoise_overlay(p->d, p->rgb, p->error, sizeof p->error)
        && write_png(path, frame->width, frame->height, p->rgb, p->error, sizeof p->error);
}

static bool check_frame(program *p, int number, const capture *frame, const char *path)
{
    bool ok = denoise_look(p->d, frame, path, (uint32_t)number, p->error, sizeof p->error)
        && denoise_count(p->d, frame, p->counters, p->error, sizeof p->error) && write_overlay(p, number, frame);
    if (ok)
        note_timings(p, number);
    return ok;
}

/* Denoises and writes one frame. */
static bool process(program *p, int number, const capture *frame, const char *path)
{
    capture result;
    if (p->opt.desc.check)
        return check_frame(p, number, frame, path);
    char out[CAPTURE_PATH_SIZE];
    capture_frame_path(out, sizeof out, p->opt.out, number);
    if (!denoise_frame(p->d, frame, path, (uint32_t)number, &result, p->error, sizeof p->error))
        return false;
    bool ok = capture_write(out, &result, p->error, sizeof p->error) && write_overlay(p, number, frame);
    capture_destroy(&result);
    if (ok)
        note_timings(p, number);
    return ok;
}

/* Everything that can be refused is refused before anything is written. */
static bool open_all(program *p, const capture *first, const char *path)
{
    const denoise_desc *desc = &p->opt.desc;
    if (!denoise_check(desc, first, path, p->error, sizeof p->error))
        return false;
    p->d = denoise_create(desc, first, p->error, sizeof p->error);
    p->frame_ms = calloc((size_t)(p->opt.last - p->opt.first + 1), sizeof *p->frame_ms);
    if (!p->d)
        return false;
    p->rgb = malloc((size_t)first->width * (size_t)first->height * 3);
    return ((p->frame_ms && p->rgb) || fail(p, "", "out of memory")) && (desc->check || open_folder(p, p->opt.out, &p->made_folder))
        && (!p->opt.overlay || open_folder(p, p->opt.overlay, &p->made_overlay)) && open_csv(p);
}

static bool denoise_all(program *p)
{
    int total = (int)(p->opt.last - p->opt.first + 1);
    bool ok = true;
    for (int i = 0; i < total && ok; i++) {
        char path[CAPTURE_PATH_SIZE];
        capture frame;
        int number = (int)p->opt.first + i;
        capture_frame_path(path, sizeof path, p->opt.in, number);
        if (!capture_read(path, &frame, p->error, sizeof p->error))
            return false;
        ok = !p->opt.thin_lobes || thin_lobes(&frame, (uint32_t)number) || fail(p, path, ": --thin lobes needs radiance and hit distance of both lobes");
        ok = ok && (i > 0 || open_all(p, &frame, path)) && process(p, number, &frame, path);
        capture_destroy(&frame);
        cli_progress(p->opt.desc.check ? "checking" : "denoising", ok ? i + 1 : total, total);
    }
    if (ok && p->opt.desc.validate && denoise_message_count(p->d)) {
        snprintf(p->error, sizeof p->error, "%u validation messages, see above", denoise_message_count(p->d));
        return false;
    }
    return ok;
}

static void print_summary(program *p)
{
    uint32_t passes;
    denoise_timings(p->d, &passes);
    printf("%s: %d frames, %s", p->opt.out, p->written, p->opt.denoisers);
    if (passes)
        printf(", %u passes, median %.3f ms per frame", passes, quantile(p->frame_ms, p->written, 0.5));
    printf(" on %s\n", denoise_device_name(p->d));
}

/* A folder that this run made and left empty goes again. */
static void release(program *p)
{
    denoise_destroy(p->d);
    free(p->frame_ms);
    free(p->rgb);
    if (p->made_folder && !p->written)
        rmdir(p->opt.out);
    if (p->made_overlay && !p->written)
        rmdir(p->opt.overlay);
}

int main(int argc, char **argv)
{
    static program p;
    if (argc == 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))) {
        fputs(usage, stdout);
        return 0;
    }
    bool ok = parse(&p, argc, argv);
    if (ok && (p.opt.info || p.opt.explain)) {
        ok = p.opt.explain ? print_explanation(&p) : print_info(&p);
    } else if (ok) {
        ok = find_frames(&p) && denoise_all(&p);
        ok = close_csv(&p, ok) && ok;
        if (ok && p.opt.desc.check)
            ok = print_findings(&p);
        else if (ok)
            print_summary(&p);
    }
    release(&p);
    return ok ? 0 : cli_fail("nrd-denoise", "%s", p.error);
}
