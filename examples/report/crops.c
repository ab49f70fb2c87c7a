#define _POSIX_C_SOURCE 200809L
#include "report/crops.h"

#include "common/png.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define ERROR_FULL 0.25 /* difference of the tone-mapped values that is drawn in the last colour */

bool crops_wanted(const report_options *o, const report_group *group)
{
    return report_same_paths(group->paths, report_usual_paths(o)) && group->size.width == o->sizes[0].width && group->size.height == o->sizes[0].height;
}

const char *crops_owner(const char *denoiser, const char *kind)
{
    return !strcmp(kind, "noisy") || !strcmp(kind, "reference") ? "input" : denoiser;
}

void crops_path(const report_options *o, const char *scene, const char *denoiser, const char *signal, const char *kind, char *path, size_t size)
{
    snprintf(path, size, "%s/crops/%s-%s-%s-%s.png", o->folder, scene, crops_owner(denoiser, kind), signal, kind);
}

typedef struct window { int left, top, width, height; } window;

static window middle_of(const image *m)
{
    window w;
    w.width = m->width < CROPS_MAX_WIDTH ? m->width : CROPS_MAX_WIDTH;
    w.height = m->height < CROPS_MAX_HEIGHT ? m->height : CROPS_MAX_HEIGHT;
    w.left = (m->width - w.width) / 2;
    w.top = (m->height - w.height) / 2;
    return w;
}

static unsigned char byte_of(double x)
{
    return (unsigned char)(255 * fmin(fmax(x, 0), 1) + 0.5);
}

static void draw_picture(const image *m, const truth *t, size_t i, unsigned char *rgb)
{
    for (int k = 0; k < 3; k++)
        rgb[k] = byte_of(metrics_tone(m->planes[m->channels == 1 ? 0 : k][i], &t->scale));
}

/* Black, purple, orange, pale yellow. */
static void draw_heat(double x, unsigned char *rgb)
{
    static const double ramp[4][3] = { { 0, 0, 0.02 }, { 0.45, 0.1, 0.45 }, { 0.98, 0.45, 0.2 }, { 1, 1, 0.8 } };
    double at = fmin(fmax(x, 0), 1) * 3;
    int low = at < 2 ? (int)at : 2;
    for (int k = 0; k < 3; k++)
        rgb[k] = byte_of(ramp[low][k] + (at - low) * (ramp[low + 1][k] - ramp[low][k]));
}

static void draw_error(const image *m, const truth *t, size_t i, unsigned char *rgb)
{
    double sum = 0;
    for (int k = 0; k < m->channels && t->mask[i]; k++)
        sum += fabs(metrics_tone(m->planes[k][i], &t->scale) - metrics_tone(t->reference.planes[k][i], &t->scale));
    draw_heat(sum / m->channels / ERROR_FULL, rgb);
}

static bool write_crop(report *r, const char *path, const image *m, const truth *t, bool error)
{
    static unsigned char rgb[CROPS_MAX_WIDTH * CROPS_MAX_HEIGHT * 3];
    window w = middle_of(m);
    for (int y = 0; y < w.height; y++)
        for (int x = 0; x < w.width; x++) {
            size_t i = (size_t)(w.top + y) * (size_t)m->width + (size_t)(w.left + x);
            unsigned char *out = rgb + 3 * (y * w.width + x);
            if (error)
                draw_error(m, t, i, out);
            else
                draw_picture(m, t, i, out);
        }
    return write_png(path, w.width, w.height, rgb, r->error, sizeof r->error);
}

bool crops_write(report *r, const report_group *group, const char *denoiser, const truth *t, const capture *now, const image *denoised)
{
    static const char *const kinds[] = {
#define CROPS_NAME(name) #name,
        CROPS_KINDS(CROPS_NAME)
#undef CROPS_NAME
    };
    char path[CAPTURE_PATH_SIZE];
    image noisy;
    snprintf(path, sizeof path, "%s/crops", r->options.folder);
    mkdir(path, 0777);
    if (!signal_get(now, NULL, t->signal, SOURCE_NOISY, &noisy))
        return report_fail(r, "out of memory");
    const image *pictures[] = { &noisy, denoised, &t->reference, denoised };
    bool ok = true;
    for (int k = 0; k < 4 && ok; k++) {
        crops_path(&r->options, group->scene->name, denoiser, signal_name(t->signal), kinds[k], path, sizeof path);
        ok = write_crop(r, path, pictures[k], t, k == 3);
    }
    image_destroy(&noisy);
    return ok;
}
