/* How much the picture changes when inputs do by as little as storage or interpolation would. */
#include "stress/stress.h"

#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 48, HEIGHT = 32, FRAMES = 12 };

/* ---- one scene: noise on a tilted, slightly bumpy wall with a step, under a camera that walks */
surface stress_wall(const rig *r, uint32_t x, uint32_t y)
{
    surface s = rig_surface(r, x, y);
    double a = 0.1 * (random_at(x / 3, y / 3, 1) - 0.5), length;
    s.normal[1] += a;
    length = sqrt(s.normal[0] * s.normal[0] + s.normal[1] * s.normal[1] + s.normal[2] * s.normal[2]);
    for (int k = 0; k < 3; k++) s.normal[k] /= length;
    s.depth *= x < r->rect_width / 3 ? 1.4 : 1;
    s.roughness = 0.2 + 0.6 * (y / 8 % 4) / 3.0;
    return s;
}

typedef void change(rig *r, uint32_t frame, uint32_t x, uint32_t y, float *mv, float *z, float *normal);

static double sign_at(uint32_t x, uint32_t y, uint32_t frame) { return random_at(x, y, frame + 900) < 0.5 ? -1 : 1; }

#define STEP (1.0 / 2048)   /* of a half, relative */

static void change_samples(rig *r, uint32_t frame, uint32_t x, uint32_t y, float *mv, float *z, float *normal)
{
    (void)mv, (void)z, (void)normal;
    for (uint32_t s = 0; s < r->signal_count; s++) {
        float *t = rig_texel(r, r->signals[s].in, x, y), scale = 1 + (float)sign_at(x, y, frame) * (float)STEP;
        if (r->signals[s].kind == KIND_PENUMBRA) t[0] *= t[0] < 65504 ? scale : 1;
        else if (r->signals[s].kind != KIND_TRANSLUCENCY) for (int k = 0; k < 4; k++) t[k] *= scale;
    }
}

static void change_motion(rig *r, uint32_t frame, uint32_t x, uint32_t y, float *mv, float *z, float *normal)
{
    (void)z, (void)normal;
    mv[0] += (float)(0.01 * sign_at(x, y, frame) / r->rect_width);
    mv[1] += (float)(0.01 * sign_at(x, y, frame + 50) / r->rect_height);
}

static void change_depth(rig *r, uint32_t frame, uint32_t x, uint32_t y, float *mv, float *z, float *normal)
{
    (void)r, (void)mv, (void)normal;
    *z *= 1 + 0.001f * (float)sign_at(x, y, frame);
}

/* A step of the 10-bit octahedral map. */
static void change_normal(rig *r, uint32_t frame, uint32_t x, uint32_t y, float *mv, float *z, float *normal)
{
    (void)r, (void)mv, (void)z;
    normal[0] += (float)sign_at(x, y, frame) / 512.0f;
}

static void run_scene(rig *r, change *what, uint32_t seed)
{
    rig_reset(r);
    r->index = 9;
    r->shape = stress_wall;
    r->tilt = 40;
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        r->camera.position[0] = 0.05 * frame;
        rig_put_guides(r);
        fill_noise(r, NOISE_UNIFORM, 1, seed);
        for (uint32_t y = 0; what && y < HEIGHT; y++)
            for (uint32_t x = 0; x < WIDTH; x++)
                what(r, frame, x, y, rig_texel(r, NRD_RESOURCE_IN_MV, x, y), rig_texel(r, NRD_RESOURCE_IN_VIEWZ, x, y), rig_texel(r, NRD_RESOURCE_IN_NORMAL_ROUGHNESS, x, y));
        rig_run(r);
    }
}

static bool is_shown(const rig *r, uint32_t s)
{
    signal_kind kind = r->signals[s].kind;
    return r->signals[s].out != NRD_RESOURCE_COUNT && kind != KIND_VECTOR && kind != KIND_TRANSLUCENCY;
}

static void keep_values(const rig *r, double *values)
{
    for (uint32_t s = 0; s < r->signal_count; s++)
        FOR_PIXELS(r) values[s * WIDTH * HEIGHT + y * WIDTH + x] = is_shown(r, s) ? rig_output_value(r, s, x, y) : 0;
}

/* rms: over the mean of the picture. flipped: share of the pixels that differ by more than FLIPPED of it. */
#define FLIPPED 0.2
typedef struct difference { double rms, flipped; } difference;

static difference compare_values(const rig *r, const double *before, const double *now)
{
    difference worst = { 0, 0 };
    for (uint32_t s = 0; s < r->signal_count; s++) {
        double squares = 0, flipped = 0, mean = 0;
        for (uint32_t i = s * WIDTH * HEIGHT; i < (s + 1) * WIDTH * HEIGHT; i++) {
            double d = now[i] - before[i];
            squares += d * d, mean += before[i] / (WIDTH * HEIGHT);
        }
        if (!is_shown(r, s)) continue;
        for (uint32_t i = s * WIDTH * HEIGHT; i < (s + 1) * WIDTH * HEIGHT; i++) flipped += !(fabs(now[i] - before[i]) <= FLIPPED * mean);
        worst.rms = fmax(worst.rms, sqrt(squares / (WIDTH * HEIGHT)) / mean);
        worst.flipped = fmax(worst.flipped, flipped / (WIDTH * HEIGHT));
    }
    return worst;
}

typedef struct sensitivity_row { const char *name; change *change; guarantee rms; bool light, shadow; } sensitivity_row; /* light, shadow: of which denoisers */
static const sensitivity_row rows[] = {
    { "samples by one step of a half", change_samples, GUARANTEE_SENSE_SAMPLES, true, false },
    { "widths of penumbrae by one step of a half", change_samples, GUARANTEE_SENSE_WIDTHS, false, true },
    { "motion by 0.01 px", change_motion, GUARANTEE_SENSE_MOTION, true, true },
    { "depth by 0.1 %", change_depth, GUARANTEE_SENSE_DEPTH, true, true },
    { "normals by one step of 10 bits", change_normal, GUARANTEE_SENSE_NORMALS, true, true },
};

static void run_denoiser(stress *s, rig *r)
{
    double *before = (double *)calloc(2 * RIG_MAX_SIGNALS * WIDTH * HEIGHT, sizeof *before), *now = before + RIG_MAX_SIGNALS * WIDTH * HEIGHT;
    if (!before) stress_die("out of memory");
    run_scene(r, NULL, s->seed);
    keep_values(r, before);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (!(r->signals[0].kind == KIND_PENUMBRA ? rows[i].shadow : rows[i].light)) continue;
        run_scene(r, rows[i].change, s->seed);
        keep_values(r, now);
        difference d = compare_values(r, before, now);
        check(s, rows[i].rms, rows[i].name, r->denoiser, d.rms);
        check(s, GUARANTEE_FLIPS, rows[i].name, r->denoiser, d.flipped);
        if (rows[i].change == change_samples) check(s, rows[i].shadow ? GUARANTEE_SHADOW_CONDITION : GUARANTEE_CONDITION, rows[i].name, r->denoiser, d.rms / STEP);
    }
    free(before);
}

void stress_sensitivity(stress *s)
{
    for (int d = (int)s->first; d <= (int)s->last; d++) {
        rig r;
        rig_desc desc = stress_rig(s, (nrd_denoiser)d, WIDTH, HEIGHT);
        rig_open(&r, &desc);
        if (r.texels[NRD_RESOURCE_IN_VIEWZ]) run_denoiser(s, &r);
        rig_close(&r);
    }
}
