/* nrd-render: path-traces a procedural scene, or an imported mesh, into a capture: noisy signals at one path per pixel
   and lobe, guides, composition channels, and converged references for chosen frames. */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/capture.h"
#include "scenes/scene.h"
#include "tracer/tracer.h"
#include "tracer/tracer_capture.h"

enum { ERROR_SIZE = 512, MAX_REF_FRAMES = 256, REF_CHUNK = 16, MAX_FRAMES = 10000 };
enum ref_choice { REF_LAST, REF_ALL, REF_NONE, REF_LIST };

typedef struct options {
    const scene_def *scene;
    const char *folder, *model;
    bool vulkan, halton;
    int direct; /* 1: sample lights at the primary hit, 0: do not, -1: as the scene prefers */
    int width, height, frames, paths, bounces, ref_spp, device, threads, seed;
    float fps;
    enum ref_choice ref_choice;
    int ref_frames[MAX_REF_FRAMES], ref_frame_count;
} options;

static const char usage[] =
    "usage: nrd-render SCENE OUT/ [options]\n"
    "       nrd-render --list\n"
    "  --size WxH          pixels, default 640x360\n"
    "  --frames N          default: the scene's own length\n"
    "  --fps F             frames per second of the animation, default 30\n"
    "  --paths N           paths per pixel and lobe in noisy frames, default 1\n"
    "  --bounces N         rays of a path after the primary one, default 3\n"
    "  --direct MODE       auto (default), mis: lights are sampled at the primary hit too, bsdf: found by chance only\n"
    "  --jitter MODE       none (default) or halton: sub-pixel offset of the primary rays\n"
    "  --ref SPP           samples per pixel of references, default 512; 0: none\n"
    "  --ref-frames LIST   frames that get a reference: last (default), all, none, or numbers such as 7,15,31\n"
    "  --tracer NAME       embree (default, CPU) or vulkan (compute shader)\n"
    "  --device N          Vulkan device, default: the first\n"
    "  --threads N         CPU threads, default: one per processor\n"
    "  --seed S            another seed gives other noise, default 0\n"
    "  --model FILE        mesh for the scene 'model': OBJ, glTF, PLY, ...\n";

/* ---- options ---- */

static bool fail(char *error, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error, ERROR_SIZE, format, arguments);
    va_end(arguments);
    return false;
}

static bool parse_int(const char *name, const char *text, int low, int high, int *out, char *error)
{
    char *end;
    long value = strtol(text, &end, 10);
    if (end == text || *end || value < low || value > high)
        return fail(error, "%s: '%s' is not a whole number in [%d, %d]", name, text, low, high);
    *out = (int)value;
    return true;
}

static bool parse_choice(const char *name, const char *text, const char *const *choices, int count, int *out,
                         char *error)
{
    for (int i = 0; i < count; i++)
        if (strcmp(text, choices[i]) == 0) {
            *out = i;
            return true;
        }
    return fail(error, "%s: '%s' is none of %s, %s%s%s", name, text, choices[0], choices[1], count > 2 ? ", " : "",
                count > 2 ? choices[2] : "");
}

static bool parse_size(const char *text, options *o, char *error)
{
    char tail;
    if (sscanf(text, "%dx%d%c", &o->width, &o->height, &tail) == 2 && o->width >= 1 && o->height >= 1 &&
        o->width <= 8192 && o->height <= 8192)
        return true;
    return fail(error, "--size: '%s' is not WxH with both in [1, 8192]", text);
}

static bool parse_fps(const char *text, options *o, char *error)
{
    char *end;
    o->fps = strtof(text, &end);
    if (end != text && !*end && o->fps >= 1.0f && o->fps <= 1000.0f) return true;
    return fail(error, "--fps: '%s' is not a number in [1, 1000]", text);
}

static bool parse_ref_frames(const char *text, options *o, char *error)
{
    static const char *const words[] = { "last", "all", "none" };
    for (int i = 0; i < 3; i++)
        if (strcmp(text, words[i]) == 0) {
            o->ref_choice = (enum ref_choice)i;
            return true;
        }
    o->ref_choice = REF_LIST;
    for (const char *at = text;;) {
        char *end;
        long frame = strtol(at, &end, 10);
        if (end == at || frame < 0 || frame >= MAX_FRAMES || (*end && *end != ',') ||
            o->ref_frame_count == MAX_REF_FRAMES)
            return fail(error, "--ref-frames: '%s' is neither last, all, none nor up to %d frame numbers", text,
                        MAX_REF_FRAMES);
        o->ref_frames[o->ref_frame_count++] = (int)frame;
        if (!*end) return true;
        at = end + 1;
    }
}

static bool parse_option(options *o, const char *name, const char *value, char *error)
{
    static const char *const tracers[] = { "embree", "vulkan" }, *const jitters[] = { "none", "halton" };
    static const char *const directs[] = { "bsdf", "mis", "auto" };
    int choice = 0;
    if (!strcmp(name, "--size")) return parse_size(value, o, error);
    if (!strcmp(name, "--frames")) return parse_int(name, value, 1, MAX_FRAMES, &o->frames, error);
    if (!strcmp(name, "--fps")) return parse_fps(value, o, error);
    if (!strcmp(name, "--paths")) return parse_int(name, value, 1, 4096, &o->paths, error);
    if (!strcmp(name, "--bounces")) return parse_int(name, value, 1, 8, &o->bounces, error);
    if (!strcmp(name, "--ref")) return parse_int(name, value, 0, 1 << 20, &o->ref_spp, error);
    if (!strcmp(name, "--ref-frames")) return parse_ref_frames(value, o, error);
    if (!strcmp(name, "--device")) return parse_int(name, value, 0, 63, &o->device, error);
    if (!strcmp(name, "--threads")) return parse_int(name, value, 1, 64, &o->threads, error);
    if (!strcmp(name, "--seed")) return parse_int(name, value, 0, 0x7fffffff, &o->seed, error);
    if (!strcmp(name, "--model")) return o->model = value, true;
    if (!strcmp(name, "--tracer")) {
        if (!parse_choice(name, value, tracers, 2, &choice, error)) return false;
        return o->vulkan = choice == 1, true;
    }
    if (!strcmp(name, "--jitter")) {
        if (!parse_choice(name, value, jitters, 2, &choice, error)) return false;
        return o->halton = choice == 1, true;
    }
    if (!strcmp(name, "--direct")) {
        if (!parse_choice(name, value, directs, 3, &choice, error)) return false;
        return o->direct = choice == 2 ? -1 : choice, true;
    }
    return fail(error, "%s: unknown option", name);
}

static bool set_defaults(options *o, char *error)
{
    if (!o->folder) return fail(error, "no output folder given");
    if (o->model && strcmp(o->scene->name, "model") != 0)
        return fail(error, "--model: the scene '%s' takes no mesh, only 'model' does", o->scene->name);
    if (!o->frames) o->frames = o->scene->frames;
    if (o->direct < 0) o->direct = o->scene->small_lights;
    for (int i = 0; i < o->ref_frame_count; i++)
        if (o->ref_frames[i] >= o->frames)
            return fail(error, "--ref-frames: %d is not in [0, %d]", o->ref_frames[i], o->frames - 1);
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    if (!o->threads) o->threads = processors < 1 ? 1 : processors > 64 ? 64 : (int)processors;
    return true;
}

static bool parse_arguments(int argc, char **argv, options *o, char *error)
{
    *o = (options){
        .direct = -1, .width = 640, .height = 360, .paths = 1, .bounces = 3, .ref_spp = 512, .device = -1, .fps = 30.0f
    };
    for (int i = 1; i < argc; i++) {
        if (strncmp(argv[i], "--", 2) == 0) {
            if (i + 1 == argc) return fail(error, "%s: value missing, or unknown option", argv[i]);
            if (!parse_option(o, argv[i], argv[i + 1], error)) return false;
            i++;
        } else if (!o->scene) {
            o->scene = scene_find(argv[i]);
            if (!o->scene) return fail(error, "'%s' is no scene; --list names them", argv[i]);
        } else if (!o->folder) {
            o->folder = argv[i];
        } else {
            return fail(error, "'%s': one scene and one folder are enough", argv[i]);
        }
    }
    return o->scene ? set_defaults(o, error) : fail(error, "no scene given; --list names them");
}

/* ---- progress ---- */

static void show_progress(const options *o, int frame, double part)
{
    double done = ((double)frame + part) / o->frames;
    if (isatty(STDERR_FILENO)) {
        char bar[31];
        int full = (int)(done * 30.0 + 0.5);
        for (int i = 0; i < 30; i++) bar[i] = i < full ? '#' : '.';
        bar[30] = '\0';
        fprintf(stderr, "\r%s [%s] %3.0f %% ", o->scene->name, bar, done * 100.0);
        if (frame + 1 == o->frames && part >= 1.0) fprintf(stderr, "\n");
        fflush(stderr);
    } else if (part >= 1.0) {
        fprintf(stderr, "%s: frame %d of %d\n", o->scene->name, frame + 1, o->frames);
    }
}

/* ---- frames ---- */

static float radical_inverse(uint32_t index, uint32_t base)
{
    float result = 0.0f, digit = 1.0f / (float)base;
    for (; index; index /= base, digit /= (float)base) result += digit * (float)(index % base);
    return result;
}

static void set_frame_options(pt_frame *f, const options *o, int frame)
{
    uint32_t index = (uint32_t)(frame % 32) + 1;
    f->jitter = o->halton ? vec4(radical_inverse(index, 2) - 0.5f, radical_inverse(index, 3) - 0.5f, 0.0f, 0.0f)
                          : vec4(0.0f, 0.0f, 0.0f, 0.0f);
    f->seed = (uint32_t)o->seed;
    f->bounces = (uint32_t)o->bounces;
    f->paths = (uint32_t)o->paths;
    f->direct_mis = o->direct == 1;
}

static bool wants_reference(const options *o, int frame)
{
    if (o->ref_spp == 0 || o->ref_choice == REF_NONE) return false;
    if (o->ref_choice == REF_ALL) return true;
    if (o->ref_choice == REF_LAST) return frame == o->frames - 1;
    for (int i = 0; i < o->ref_frame_count; i++)
        if (o->ref_frames[i] == frame) return true;
    return false;
}

typedef struct renderer {
    const options *o;
    scene scene;
    pt_scene posed;
    tracer tracer;
    float *planes;
    double *sums;
} renderer;

static bool add_reference(renderer *r, int frame, capture *c, char *error)
{
    size_t values = PT_REF_COUNT * (size_t)c->width * (size_t)c->height;
    memset(r->sums, 0, values * sizeof *r->sums);
    for (int first = 0; first < r->o->ref_spp; first += REF_CHUNK) {
        int left = r->o->ref_spp - first;
        r->posed.frame.sample_first = (uint32_t)first;
        r->posed.frame.sample_count = (uint32_t)(left < REF_CHUNK ? left : REF_CHUNK);
        if (!r->tracer.accumulate(&r->tracer, &r->posed, r->sums, error, ERROR_SIZE)) return false;
        if (left > REF_CHUNK) show_progress(r->o, frame, (double)(first + REF_CHUNK) / r->o->ref_spp);
    }
    for (size_t i = 0; i < values; i++) r->planes[i] = (float)(r->sums[i] / r->o->ref_spp);
    if (tracer_fill_reference(c, r->o->scene, r->planes)) return true;
    return fail(error, "out of memory");
}

static bool fill_frame(renderer *r, int frame, capture *c, char *error)
{
    const options *o = r->o;
    if (!scene_pose(&r->scene, frame, o->fps, (uint32_t)o->width, (uint32_t)o->height, &r->posed))
        return fail(error, "out of memory");
    set_frame_options(&r->posed.frame, o, frame);
    if (!r->tracer.load(&r->tracer, &r->posed, error, ERROR_SIZE)) return false;
    if (!r->tracer.render(&r->tracer, &r->posed, r->planes, error, ERROR_SIZE)) return false;
    if (!tracer_fill_capture(c, &r->posed.frame, o->fps, o->scene, r->planes)) return fail(error, "out of memory");
    return !wants_reference(o, frame) || add_reference(r, frame, c, error);
}

static bool render_frame(renderer *r, int frame, char *error)
{
    capture c;
    char path[4096];
    if (!capture_create(&c, r->o->width, r->o->height)) return fail(error, "out of memory");
    capture_frame_path(path, sizeof path, r->o->folder, frame);
    bool ok = fill_frame(r, frame, &c, error) && capture_write(path, &c, error, ERROR_SIZE);
    capture_destroy(&c);
    if (ok) show_progress(r->o, frame, 1.0);
    return ok;
}

/* The folder must exist or be creatable, and must not hold a longer capture: its tail would be taken for ours. */
static bool prepare_folder(const options *o, char *error)
{
    char path[4096];
    struct stat info;
    if (mkdir(o->folder, 0777) != 0 && errno != EEXIST) return fail(error, "%s: %s", o->folder, strerror(errno));
    if (stat(o->folder, &info) != 0 || !S_ISDIR(info.st_mode)) return fail(error, "%s: not a folder", o->folder);
    capture_frame_path(path, sizeof path, o->folder, o->frames);
    if (access(path, F_OK) == 0) return fail(error, "%s: belongs to a longer capture; choose another folder", path);
    return true;
}

static bool open_renderer(renderer *r, const options *o, char *error)
{
    size_t texels = (size_t)o->width * (size_t)o->height;
    memset(r, 0, sizeof *r);
    r->o = o;
    if (!scene_open(&r->scene, o->scene, o->model, error, ERROR_SIZE)) return false;
    r->planes = malloc(PT_PLANE_COUNT * texels * sizeof *r->planes);
    r->sums = malloc(PT_REF_COUNT * texels * sizeof *r->sums);
    if (!r->planes || !r->sums) return fail(error, "out of memory");
    return o->vulkan ? tracer_open_vulkan(&r->tracer, o->device, error, ERROR_SIZE)
                     : tracer_open_embree(&r->tracer, o->threads, error, ERROR_SIZE);
}

static void close_renderer(renderer *r)
{
    if (r->tracer.close) r->tracer.close(&r->tracer);
    free(r->planes);
    free(r->sums);
    scene_free_pose(&r->posed);
    scene_close(&r->scene);
}

static bool render(const options *o, char *error)
{
    renderer r;
    bool ok = open_renderer(&r, o, error) && prepare_folder(o, error);
    for (int frame = 0; ok && frame < o->frames; frame++) ok = render_frame(&r, frame, error);
    close_renderer(&r);
    return ok;
}

int main(int argc, char **argv)
{
    options o;
    char error[ERROR_SIZE] = "";
    if (argc == 1) return fputs(usage, stderr), 2;
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h")) return fputs(usage, stdout), 0;
    if (!strcmp(argv[1], "--list")) {
        for (int i = 0; i < scene_table_count; i++)
            printf("%-16s %3d frames  %s\n", scene_table[i].name, scene_table[i].frames, scene_table[i].about);
        return 0;
    }
    if (!parse_arguments(argc, argv, &o, error)) return fprintf(stderr, "nrd-render: %s\n", error), 2;
    if (!render(&o, error)) return fprintf(stderr, "nrd-render: %s\n", error), 1;
    return 0;
}
