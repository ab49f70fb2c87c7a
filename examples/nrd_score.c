/* nrd-score: compares the signals of a denoised capture, and of its noisy input, with the capture's references.
   Formulas: common/metrics.h. */
#include "common/capture.h"
#include "common/cli.h"
#include "common/metrics.h"
#include "common/signals.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "usage: nrd-score CAPTURE [DENOISED] [--from F] [--to T] [--per-frame] [--json]\n"
    "Scores denoised.* of DENOISED, and the noisy input, against ref.* of CAPTURE.\n";

typedef struct options {
    const char *folder, *denoised; /* denoised: NULL to score the noisy input alone */
    long from, to;                 /* frame numbers */
    bool per_frame, json;
} options;

/* One frame that has a reference. */
typedef struct frame_score {
    int frame;
    metrics errors[SOURCE_REFERENCE]; /* .frames is 0 where the source is absent */
} frame_score;

typedef struct signal_score {
    bool scaled;                      /* some frame holds the signal: `scale` is valid */
    metrics_scale scale;
    metrics errors[SOURCE_COUNT];     /* sums; for the reference the noise of its own */
    metrics_flicker flicker[SOURCE_COUNT];
    metrics_bad bad[SOURCE_COUNT];
    frame_score *frames;
    int frame_count;
    image before[SOURCE_COUNT];       /* the frame before, for flicker */
} signal_score;

typedef struct scorer {
    options opt;
    signal_score signals[SIGNAL_COUNT];
    capture previous;                 /* no planes before the first frame */
    unsigned char *mask;
    int frames, reference_frames, missing;
    int width, height;
    char error[CLI_ERROR_SIZE];
} scorer;

static bool out_of_memory(scorer *s)
{
    snprintf(s->error, sizeof s->error, "out of memory");
    return false;
}

/* ---- exposure ---- */

/* Sets the scales of signals that have none yet from a frame; from its references they are final. */
static bool take_scales(scorer *s, const capture *frame, bool from_reference)
{
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        image m;
        signal_score *score = &s->signals[k];
        if (!from_reference && score->scaled)
            continue;
        if (!signal_get(frame, NULL, (signal_id)k, from_reference ? SOURCE_REFERENCE : SOURCE_NOISY, &m))
            continue;
        signal_mask(frame, (signal_id)k, s->mask);
        score->scale = metrics_scale_of(&m, s->mask, signal_is_unit((signal_id)k));
        score->scaled = true;
        image_destroy(&m);
    }
    return true;
}

/* Exposures come from the capture's first reference (or else its first noisy frame), so that they do not depend on the
   frames that are scored. */
static bool find_scales(scorer *s, int first, int last)
{
    bool done = false;
    for (int i = first; i <= last && !done; i++) {
        char path[CAPTURE_PATH_SIZE];
        capture frame;
        capture_frame_path(path, sizeof path, s->opt.folder, i);
        if (!capture_read(path, &frame, s->error, sizeof s->error))
            return false;
        if (i == first) {
            s->width = frame.width;
            s->height = frame.height;
            s->mask = malloc((size_t)frame.width * (size_t)frame.height);
        }
        if (!s->mask)
            snprintf(s->error, sizeof s->error, "out of memory");
        else if (frame.width != s->width || frame.height != s->height)
            snprintf(s->error, sizeof s->error, "%s: is %dx%d, the first frame is %dx%d", path, frame.width, frame.height, s->width,
                     s->height);
        else
            done = take_scales(s, &frame, signal_has_reference(&frame)) && signal_has_reference(&frame);
        capture_destroy(&frame);
        if (s->error[0])
            return false;
    }
    return true;
}

/* ---- one frame ---- */

static bool score_reference_noise(scorer *s, const capture *frame, signal_id k, const image *reference)
{
    char name[CAPTURE_NAME_SIZE];
    metrics noise;
    if (k != SIGNAL_DIFFUSE && k != SIGNAL_SPECULAR)
        return true;
    snprintf(name, sizeof name, "%s.stderr", signal_prefix(k, SOURCE_REFERENCE));
    const float *standard_error = capture_find_plane(frame, name);
    if (!standard_error)
        return true;
    if (!metrics_reference_noise(reference, standard_error, s->mask, &noise))
        return out_of_memory(s);
    metrics_add(&s->signals[k].errors[SOURCE_REFERENCE], &noise);
    return true;
}

static bool score_against_reference(scorer *s, const capture *frame, int number, signal_id k, const image *images)
{
    signal_score *score = &s->signals[k];
    frame_score *frames = realloc(score->frames, (size_t)(score->frame_count + 1) * sizeof *frames);
    if (!frames)
        return out_of_memory(s);
    score->frames = frames;
    frame_score *each = &frames[score->frame_count++];
    memset(each, 0, sizeof *each);
    each->frame = number;
    for (int source = 0; source < SOURCE_REFERENCE; source++) {
        if (!images[source].channels)
            continue;
        if (!metrics_compare(&images[source], &images[SOURCE_REFERENCE], s->mask, &score->scale, &each->errors[source]))
            return out_of_memory(s);
        metrics_add(&score->errors[source], &each->errors[source]);
    }
    return score_reference_noise(s, frame, k, &images[SOURCE_REFERENCE]);
}

/* Scores one signal; takes the images over as the frame before. */
static bool score_signal(scorer *s, const capture *frame, const capture *denoised, int number, signal_id k, bool *has_reference)
{
    signal_score *score = &s->signals[k];
    image images[SOURCE_COUNT];
    bool ok = true;
    signal_mask(frame, k, s->mask);
    for (int source = 0; source < SOURCE_COUNT; source++) {
        image *m = &images[source];
        if (!signal_get(frame, denoised, k, (signal_source)source, m))
            continue;
        metrics_count_bad(m, s->mask, &score->bad[source]);
        if (score->before[source].channels && s->previous.plane_count
            && !metrics_add_flicker(&s->previous, &score->before[source], frame, m, s->mask, &score->scale, &score->flicker[source]))
            ok = out_of_memory(s);
    }
    if (images[SOURCE_REFERENCE].channels) {
        *has_reference = true;
        ok = ok && score_against_reference(s, frame, number, k, images);
    }
    for (int source = 0; source < SOURCE_COUNT; source++) {
        image_destroy(&score->before[source]);
        score->before[source] = images[source];
    }
    return ok;
}

static bool file_exists(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file)
        fclose(file);
    return file != NULL;
}

/* Reads a frame and checks its size. */
static bool read_sized(scorer *s, const char *path, capture *out)
{
    if (!capture_read(path, out, s->error, sizeof s->error))
        return false;
    if (out->width == s->width && out->height == s->height)
        return true;
    snprintf(s->error, sizeof s->error, "%s: is %dx%d, the capture is %dx%d", path, out->width, out->height, s->width, s->height);
    capture_destroy(out);
    return false;
}

static bool read_frame(scorer *s, int number, capture *frame, capture *denoised)
{
    char path[CAPTURE_PATH_SIZE];
    capture_frame_path(path, sizeof path, s->opt.folder, number);
    memset(denoised, 0, sizeof *denoised);
    if (!read_sized(s, path, frame))
        return false;
    if (!s->opt.denoised)
        return true;
    capture_frame_path(path, sizeof path, s->opt.denoised, number);
    if (!file_exists(path)) {
        s->missing++;
        return true;
    }
    if (read_sized(s, path, denoised))
        return true;
    capture_destroy(frame);
    return false;
}

static bool score_frame(scorer *s, int number)
{
    capture frame, denoised;
    bool ok = true, has_reference = false;
    if (!read_frame(s, number, &frame, &denoised))
        return false;
    for (int k = 0; k < SIGNAL_COUNT && ok; k++)
        if (s->signals[k].scaled)
            ok = score_signal(s, &frame, denoised.plane_count ? &denoised : NULL, number, (signal_id)k, &has_reference);
    capture_destroy(&denoised);
    capture_destroy(&s->previous);
    s->previous = frame;
    s->frames++;
    s->reference_frames += has_reference;
    return ok;
}

/* ---- text ---- */

static void print_errors(const metrics *sum, bool reference)
{
    metrics_summary m = metrics_summarise(sum);
    if (!sum->frames)
        printf(" %10s %10s", "-", "-");
    else
        printf(" %10.4g %10.4g", m.rel_mse, m.rel_mse_trimmed);
    if (!sum->frames || reference)
        printf(" %8s %8s %7s %7s %8s", "-", "-", "-", "-", "-");
    else
        printf(" %8.4f %8.4f %7.2f %7.4f %+8.4f", m.log_rmse, m.tone_rmse, m.psnr, m.ssim, m.bias);
}

static void print_row(const scorer *s, int k, int source)
{
    const signal_score *score = &s->signals[k];
    const metrics_flicker *flicker = &score->flicker[source];
    const metrics_bad *bad = &score->bad[source];
    if (!score->errors[source].frames && !flicker->pixels)
        return;
    printf("%-9s %-9s", signal_name((signal_id)k), signal_source_name((signal_source)source));
    print_errors(&score->errors[source], source == SOURCE_REFERENCE);
    if (flicker->pixels)
        printf(" %9.5f", flicker->sum / (double)flicker->pixels);
    else
        printf(" %9s", "-");
    printf(" %6ld %6ld %7ld\n", bad->nan, bad->inf, bad->negative);
    for (int i = 0; s->opt.per_frame && source != SOURCE_REFERENCE && i < score->frame_count; i++) {
        if (!score->frames[i].errors[source].frames)
            continue;
        printf("  frame %6d     ", score->frames[i].frame);
        print_errors(&score->frames[i].errors[source], false);
        printf("\n");
    }
}

static void print_text(const scorer *s)
{
    printf("%s: %d frames, %d with a reference", s->opt.folder, s->frames, s->reference_frames);
    printf(s->opt.denoised ? "; denoised: %s\n" : "; noisy only\n", s->opt.denoised);
    printf("%-9s %-9s %10s %10s %8s %8s %7s %7s %8s %9s %6s %6s %7s\n", "signal", "", "relMSE", "trimmed", "logRMSE", "tmRMSE",
           "PSNR", "SSIM", "bias", "flicker", "NaN", "Inf", "neg");
    for (int k = 0; k < SIGNAL_COUNT; k++)
        for (int source = 0; source < SOURCE_COUNT; source++)
            print_row(s, k, source);
}

/* ---- JSON ---- */

static void print_json_string(const char *text)
{
    putchar('"');
    for (; *text; text++)
        if ((unsigned char)*text < 0x20)
            printf("\\u%04x", (unsigned)*text);
        else
            printf(*text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    putchar('"');
}

static void print_json_errors(const metrics *sum)
{
    metrics_summary m = metrics_summarise(sum);
    printf("\"relMSE\":%.6g,\"relMSEtrimmed\":%.6g,\"logRMSE\":%.6g,\"tmRMSE\":%.6g,\"psnr\":%.4f,\"ssim\":%.5f,\"bias\":%.6g",
           m.rel_mse, m.rel_mse_trimmed, m.log_rmse, m.tone_rmse, m.psnr, m.ssim, m.bias);
}

static void print_json_source(const signal_score *score, int source)
{
    const metrics_flicker *flicker = &score->flicker[source];
    const metrics_bad *bad = &score->bad[source];
    metrics_summary m = metrics_summarise(&score->errors[source]);
    printf("\"%s\":{\"frames\":%d,\"nan\":%ld,\"inf\":%ld,\"negative\":%ld", signal_source_name((signal_source)source),
           score->errors[source].frames, bad->nan, bad->inf, bad->negative);
    if (flicker->pixels)
        printf(",\"flicker\":%.6g", flicker->sum / (double)flicker->pixels);
    if (score->errors[source].frames && source == SOURCE_REFERENCE) {
        printf(",\"relMSEofItsNoise\":%.6g,\"trimmed\":%.6g", m.rel_mse, m.rel_mse_trimmed);
    } else if (score->errors[source].frames) {
        printf(",");
        print_json_errors(&score->errors[source]);
    }
    printf("}");
}

static void print_json_frames(const signal_score *score)
{
    const char *separator = "";
    printf("\"each\":[");
    for (int i = 0; i < score->frame_count; i++)
        for (int source = 0; source < SOURCE_REFERENCE; source++) {
            if (!score->frames[i].errors[source].frames)
                continue;
            printf("%s{\"frame\":%d,\"of\":\"%s\",", separator, score->frames[i].frame, signal_source_name((signal_source)source));
            print_json_errors(&score->frames[i].errors[source]);
            printf("}");
            separator = ",";
        }
    printf("]");
}

static void print_json(const scorer *s)
{
    const char *separator = "";
    printf("{\"capture\":");
    print_json_string(s->opt.folder);
    printf(",\"denoised\":");
    print_json_string(s->opt.denoised ? s->opt.denoised : "");
    printf(",\"frames\":%d,\"refFrames\":%d,\"missing\":%d,\"signals\":{", s->frames, s->reference_frames, s->missing);
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        if (!s->signals[k].scaled)
            continue;
        printf("%s\"%s\":{", separator, signal_name((signal_id)k));
        for (int source = 0; source < SOURCE_COUNT; source++) {
            print_json_source(&s->signals[k], source);
            printf(",");
        }
        print_json_frames(&s->signals[k]);
        printf("}");
        separator = ",";
    }
    printf("}}\n");
}

/* ---- the program ---- */

/* Finds the frames to score; false with a message when they are not there. */
static bool find_range(scorer *s, int *first, int *last)
{
    if (!capture_frame_range(s->opt.folder, first, last, s->error, sizeof s->error))
        return false;
    s->opt.from = s->opt.from < 0 ? *first : s->opt.from;
    s->opt.to = s->opt.to > *last ? *last : s->opt.to;
    if (s->opt.from >= *first && s->opt.from <= s->opt.to)
        return true;
    snprintf(s->error, sizeof s->error, "%s: holds frames %d..%d, none of those asked for", s->opt.folder, *first, *last);
    return false;
}

static bool run(scorer *s)
{
    int first, last;
    if (!find_range(s, &first, &last) || !find_scales(s, first, last))
        return false;
    for (long i = s->opt.from; i <= s->opt.to; i++) {
        if (!score_frame(s, (int)i))
            return false;
        cli_progress("scoring", (int)(i - s->opt.from + 1), (int)(s->opt.to - s->opt.from + 1));
    }
    if (s->opt.json)
        print_json(s);
    else
        print_text(s);
    if (s->missing)
        snprintf(s->error, sizeof s->error, "%s: %d of %d frames are missing", s->opt.denoised, s->missing, s->frames);
    return !s->missing;
}

static void release(scorer *s)
{
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        free(s->signals[k].frames);
        for (int source = 0; source < SOURCE_COUNT; source++)
            image_destroy(&s->signals[k].before[source]);
    }
    capture_destroy(&s->previous);
    free(s->mask);
}

/* False, with a line in `error`, on misuse. */
static bool parse(int argc, char **argv, options *opt, char *error, size_t error_size)
{
    opt->from = -1;
    opt->to = INT_MAX;
    for (int i = 1; i < argc; i++) {
        const char *name = argv[i], *value;
        if (!strcmp(name, "--json")) {
            opt->json = true;
        } else if (!strcmp(name, "--per-frame")) {
            opt->per_frame = true;
        } else if (!strcmp(name, "--from") || !strcmp(name, "--to")) {
            value = cli_value(argc, argv, &i);
            if (!value || !cli_integer(value, 0, INT_MAX, strcmp(name, "--to") ? &opt->from : &opt->to)) {
                snprintf(error, error_size, "%s needs a frame number, got %s", name, value ? value : "nothing");
                return false;
            }
        } else if (name[0] == '-' || (opt->folder && opt->denoised)) {
            snprintf(error, error_size, "%s %s; try --help", name[0] == '-' ? "unknown option" : "unexpected argument", name);
            return false;
        } else {
            *(opt->folder ? &opt->denoised : &opt->folder) = name;
        }
    }
    if (!opt->folder)
        snprintf(error, error_size, "no capture given; try --help");
    return opt->folder != NULL;
}

int main(int argc, char **argv)
{
    scorer s = { 0 };
    if (argc == 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))) {
        fputs(usage, stdout);
        return 0;
    }
    bool ok = parse(argc, argv, &s.opt, s.error, sizeof s.error) && run(&s);
    release(&s);
    return ok ? 0 : cli_fail("nrd-score", "%s", s.error);
}
