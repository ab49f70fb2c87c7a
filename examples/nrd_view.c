/* nrd-view: a PNG of a signal of a capture: noisy, denoised, reference, side by side, or where the error is.
   Tone mapping as in common/metrics.h: one exposure for all pictures, Reinhard, gamma 2.2; shadow and ao as they are. */
#define _POSIX_C_SOURCE 200809L
#include "common/capture.h"
#include "common/cli.h"
#include "common/metrics.h"
#include "common/png.h"
#include "common/signals.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char usage[] =
    "usage: nrd-view CAPTURE [DENOISED] OUT.png --signal diffuse|specular|shadow|ao|final [options]\n"
    "  CAPTURE, DENOISED   a folder of frames or one .exr file\n"
    "  --frame N           of folders (the first one)\n"
    "  --show noisy|denoised|ref   one picture (denoised if given, else noisy)\n"
    "  --side-by-side      noisy | denoised | reference, as far as they are there\n"
    "  --error             the tone-mapped error against the reference: black 0, red, yellow, white 0.25 or more\n"
    "  --label             names in the corners\n"
    "NaN and Inf are magenta.\n";

/* Tone-mapped error that is shown white. */
#define ERROR_WHITE 0.25
#define GAP 4 /* pixels between pictures */
#define LABEL_ZOOM 2

typedef struct options {
    const char *paths[3]; /* in, denoised, out, in the order given */
    int path_count;
    signal_id signal;
    bool has_signal, side_by_side, error, label;
    signal_source show;   /* SOURCE_COUNT: default */
    long frame;           /* -1: the first */
} options;

typedef struct viewer {
    options opt;
    capture frame, denoised;
    image images[SOURCE_COUNT];
    metrics_scale scale;
    unsigned char *rgb;
    int width, height;    /* of the whole picture */
    char error[CLI_ERROR_SIZE];
} viewer;

static bool fail(viewer *v, const char *text, const char *what)
{
    snprintf(v->error, sizeof v->error, "%s%s", what, text);
    return false;
}

/* ---- input ---- */

/* Reads a file, or a frame of a folder. */
static bool read_frame(viewer *v, const char *path, capture *out)
{
    struct stat info;
    char file[CAPTURE_PATH_SIZE];
    int first = (int)v->opt.frame, last;
    if (stat(path, &info) || !S_ISDIR(info.st_mode))
        return capture_read(path, out, v->error, sizeof v->error);
    if (first < 0 && !capture_frame_range(path, &first, &last, v->error, sizeof v->error))
        return false;
    capture_frame_path(file, sizeof file, path, first);
    return capture_read(file, out, v->error, sizeof v->error);
}

static bool read_input(viewer *v)
{
    bool with_denoised = v->opt.path_count == 3;
    if (!read_frame(v, v->opt.paths[0], &v->frame))
        return false;
    if (with_denoised && !read_frame(v, v->opt.paths[1], &v->denoised))
        return false;
    if (with_denoised && (v->denoised.width != v->frame.width || v->denoised.height != v->frame.height))
        return fail(v, ": its size is not that of the capture", v->opt.paths[1]);
    for (int s = 0; s < SOURCE_COUNT; s++)
        signal_get(&v->frame, with_denoised ? &v->denoised : NULL, v->opt.signal, (signal_source)s, &v->images[s]);
    return true;
}

/* From the reference where there is one: so the exposure does not depend on the denoiser. */
static bool find_scale(viewer *v)
{
    static const signal_source order[] = { SOURCE_REFERENCE, SOURCE_NOISY, SOURCE_DENOISED };
    unsigned char *mask = malloc((size_t)v->frame.width * (size_t)v->frame.height);
    const image *basis = NULL;
    if (!mask)
        return fail(v, "", "out of memory");
    signal_mask(&v->frame, v->opt.signal, mask);
    for (int i = 0; i < SOURCE_COUNT && !basis; i++)
        if (v->images[order[i]].channels)
            basis = &v->images[order[i]];
    if (basis)
        v->scale = metrics_scale_of(basis, mask, signal_is_unit(v->opt.signal));
    free(mask);
    return basis || fail(v, ": the signal is not in the capture", signal_name(v->opt.signal));
}

/* ---- drawing ---- */

static unsigned char byte_of(double unit)
{
    return (unsigned char)(255 * fmin(fmax(unit, 0), 1) + 0.5);
}

static void tone_pixel(const viewer *v, const image *m, size_t i, unsigned char *rgb)
{
    bool bad = false;
    for (int k = 0; k < 3; k++) {
        float value = m->planes[m->channels == 1 ? 0 : k][i];
        bad |= !isfinite(value);
        rgb[k] = byte_of(metrics_tone(value, &v->scale));
    }
    if (bad) {
        rgb[0] = rgb[2] = 255;
        rgb[1] = 0;
    }
}

/* Black, red, yellow, white. */
static void error_pixel(const viewer *v, const image *m, size_t i, unsigned char *rgb)
{
    const image *reference = &v->images[SOURCE_REFERENCE];
    double error = 0;
    for (int k = 0; k < m->channels; k++)
        error += fabs(metrics_tone(m->planes[k][i], &v->scale) - metrics_tone(reference->planes[k][i], &v->scale));
    for (int k = 0; k < 3; k++)
        rgb[k] = byte_of(3 * error / m->channels / ERROR_WHITE - k);
}

typedef void pixel_function(const viewer *v, const image *m, size_t i, unsigned char *rgb);

static void draw_image(viewer *v, const image *m, pixel_function *pixel, int left)
{
    for (int y = 0; y < m->height; y++)
        for (int x = 0; x < m->width; x++)
            pixel(v, m, (size_t)y * (size_t)m->width + (size_t)x, v->rgb + 3 * ((size_t)y * (size_t)v->width + (size_t)(left + x)));
}

/* Letters of 3 x 5 dots: an octal digit is a row, the top one first. */
static const unsigned letters[26] = {
    025755, 065656, 034443, 065556, 074647, 074644, 034553, 055755, 072227, 011152, 055655, 044447, 057755,
    065555, 025552, 065644, 025563, 065655, 034216, 072222, 055557, 055522, 055775, 055255, 055222, 071247,
};

static void draw_dot(viewer *v, int x, int y, unsigned char value)
{
    if (x < v->width && y < v->height)
        memset(v->rgb + 3 * ((size_t)y * (size_t)v->width + (size_t)x), value, 3);
}

/* White on black, lower-case letters; anything else is a space. */
static void draw_label(viewer *v, const char *text, int left)
{
    int length = (int)strlen(text), columns = 4 * length + 1, rows = 7;
    for (int y = 0; y < rows * LABEL_ZOOM; y++)
        for (int x = 0; x < columns * LABEL_ZOOM; x++) {
            int column = x / LABEL_ZOOM - 1, row = y / LABEL_ZOOM - 1, letter = column >= 0 ? text[column / 4] - 'a' : -1;
            bool inside = letter >= 0 && letter < 26 && row >= 0 && row < 5 && column % 4 < 3;
            bool lit = inside && letters[letter] >> (3 * (4 - row) + 2 - column % 4) & 1;
            draw_dot(v, left + x, y, lit ? 255 : 0);
        }
}

typedef struct panel {
    const image *m;
    pixel_function *pixel;
    const char *label;
} panel;

/* The pictures to draw, from left to right. */
static int choose_panels(const viewer *v, panel *panels)
{
    static const signal_source order[] = { SOURCE_NOISY, SOURCE_DENOISED, SOURCE_REFERENCE };
    static const char *const labels[] = { "noisy", "denoised", "reference" };
    signal_source show = v->opt.show;
    int count = 0;
    if (show == SOURCE_COUNT)
        show = v->images[SOURCE_DENOISED].channels ? SOURCE_DENOISED : SOURCE_NOISY;
    for (int i = 0; i < SOURCE_COUNT; i++) {
        const image *m = &v->images[order[i]];
        bool wanted = v->opt.side_by_side || (!v->opt.error && order[i] == show);
        if (m->channels && wanted)
            panels[count++] = (panel){ m, tone_pixel, labels[i] };
    }
    if (v->opt.error && v->images[show].channels && v->images[SOURCE_REFERENCE].channels)
        panels[count++] = (panel){ &v->images[show], error_pixel, "error" };
    return count;
}

static bool draw(viewer *v)
{
    panel panels[SOURCE_COUNT + 1];
    int count = choose_panels(v, panels);
    if (v->opt.error && !v->images[SOURCE_REFERENCE].channels)
        return fail(v, ": no reference to show an error against", signal_name(v->opt.signal));
    if (!count)
        return fail(v, ": the picture asked for is not in the capture", signal_name(v->opt.signal));
    v->width = count * (v->frame.width + GAP) - GAP;
    v->height = v->frame.height;
    v->rgb = calloc((size_t)v->width * (size_t)v->height, 3);
    if (!v->rgb)
        return fail(v, "", "out of memory");
    for (int i = 0; i < count; i++) {
        int left = i * (v->frame.width + GAP);
        draw_image(v, panels[i].m, panels[i].pixel, left);
        if (v->opt.label)
            draw_label(v, panels[i].label, left);
    }
    return true;
}

/* ---- the program ---- */

static bool parse_source(const char *name, signal_source *out)
{
    for (int s = 0; s < SOURCE_COUNT; s++)
        if (!strcmp(name, signal_source_name((signal_source)s))) {
            *out = (signal_source)s;
            return true;
        }
    return false;
}

/* An option with a value. */
static bool parse_value(viewer *v, const char *name, const char *value)
{
    options *opt = &v->opt;
    if (!value)
        return fail(v, " needs a value", name);
    if (!strcmp(name, "--signal")) {
        opt->has_signal = signal_find(value, &opt->signal);
        return opt->has_signal || fail(v, ": unknown signal; known: diffuse, specular, shadow, ao, final, translucency", value);
    }
    if (!strcmp(name, "--show"))
        return parse_source(value, &opt->show) || fail(v, ": unknown picture; known: noisy, denoised, ref", value);
    return cli_integer(value, 0, INT_MAX, &opt->frame) || fail(v, ": --frame needs a frame number", value);
}

static bool parse_argument(viewer *v, int argc, char **argv, int *i)
{
    options *opt = &v->opt;
    const char *name = argv[*i];
    if (!strcmp(name, "--side-by-side"))
        return opt->side_by_side = true;
    if (!strcmp(name, "--error"))
        return opt->error = true;
    if (!strcmp(name, "--label"))
        return opt->label = true;
    if (!strcmp(name, "--signal") || !strcmp(name, "--show") || !strcmp(name, "--frame"))
        return parse_value(v, name, cli_value(argc, argv, i));
    if (name[0] == '-')
        return fail(v, ": unknown option; try --help", name);
    if (opt->path_count == 3)
        return fail(v, ": unexpected argument; try --help", name);
    opt->paths[opt->path_count++] = name;
    return true;
}

static bool parse(viewer *v, int argc, char **argv)
{
    options *opt = &v->opt;
    opt->show = SOURCE_COUNT;
    opt->frame = -1;
    for (int i = 1; i < argc; i++)
        if (!parse_argument(v, argc, argv, &i))
            return false;
    if (opt->path_count < 2)
        return fail(v, "", "needs a capture and an output file; try --help");
    if (!opt->has_signal)
        return fail(v, "", "needs --signal diffuse|specular|shadow|ao|final");
    const char *out = opt->paths[opt->path_count - 1];
    size_t length = strlen(out);
    return (length > 4 && !strcmp(out + length - 4, ".png")) || fail(v, ": the output file must end in .png", out);
}

int main(int argc, char **argv)
{
    viewer v = { 0 };
    if (argc == 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))) {
        fputs(usage, stdout);
        return 0;
    }
    bool ok = parse(&v, argc, argv) && read_input(&v) && find_scale(&v) && draw(&v)
        && write_png(v.opt.paths[v.opt.path_count - 1], v.width, v.height, v.rgb, v.error, sizeof v.error);
    for (int s = 0; s < SOURCE_COUNT; s++)
        image_destroy(&v.images[s]);
    capture_destroy(&v.frame);
    capture_destroy(&v.denoised);
    free(v.rgb);
    return ok ? 0 : cli_fail("nrd-view", "%s", v.error);
}
