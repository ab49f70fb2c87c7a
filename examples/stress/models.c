/* Devices against double-precision models of the passes, and what rounding costs by those. */
#include "stress/model.h"
#include "stress/stress.h"

#include <stdio.h>

enum { SIZE = MODEL_SIZE, FRAMES = 12, MOST_SCENES = 5 };

/* ---- inputs, in the units of model_kind */
typedef double scene(uint32_t x, uint32_t y, uint32_t frame);

static double noise(uint32_t x, uint32_t y, uint32_t frame) { return 2 * random_at(x, y, 100 + frame); }
static double flat(uint32_t x, uint32_t y, uint32_t frame) { return 0.1 + 0 * (x + y + frame); }
static double gradient(uint32_t x, uint32_t y, uint32_t frame) { return 0.2 + 0.02 * x + 0 * (y + frame); }
static double edge(uint32_t x, uint32_t y, uint32_t frame) { return x < SIZE / 2 ? 0.1 + 0 * (y + frame) : 1; }
static double impulse(uint32_t x, uint32_t y, uint32_t frame) { return x == SIZE / 2 && y == SIZE / 2 ? 6 : 1 + 0 * frame; }
static double hole(uint32_t x, uint32_t y, uint32_t frame) { return x == SIZE / 2 && y == SIZE / 2 ? 0.1 + 0 * frame : 1; }
static double unit_noise(uint32_t x, uint32_t y, uint32_t frame) { return 0.05 + 0.9 * random_at(x, y, 100 + frame); }

/* A ray: blocked with that chance, by occluders at all distances. */
static double ray(uint32_t x, uint32_t y, uint32_t frame, double blocked)
{
    return random_at(x, y, 100 + frame) < blocked ? 1 + 5 * random_at(x, y, 500 + frame) : MODEL_LIT;
}
static double half_blocked(uint32_t x, uint32_t y, uint32_t frame) { return ray(x, y, frame, 0.5); }
static double shadow_ramp(uint32_t x, uint32_t y, uint32_t frame) { return ray(x, y, frame, x / (SIZE - 1.0)); }
static double shadow_edge(uint32_t x, uint32_t y, uint32_t frame) { return ray(x, y, frame, fmin(fmax((x - 10.0) / 12, 0), 1)); }
static double all_lit(uint32_t x, uint32_t y, uint32_t frame) { return ray(x, y, frame, 0); }
static double one_blocked(uint32_t x, uint32_t y, uint32_t frame) { return ray(x, y, frame, x == SIZE / 2 && y == SIZE / 2); }

typedef struct modelled {
    const model_kind *kind;
    guarantee stored, device;
    bool relative;                                                       /* errors; of radiance */
    bool rms_stored, rms_device;                                         /* not the largest of all pixels */
    bool linear;                                                         /* in noise that is small */
    bool varies_as_stored;                                               /* what is rounded at random changes the variance */
    struct { scene *what; const char *name; } scenes[MOST_SCENES];       /* the first: noise */
} modelled;
static const modelled all[] = {
    { &reblur_model_kind, GUARANTEE_STORAGE, GUARANTEE_MODEL, true, false, false, true, false,
      { { noise, "noise" }, { flat, "a constant" }, { gradient, "a gradient" }, { edge, "an edge" }, { impulse, "an impulse" } } },
    { &specular_model_kind, GUARANTEE_STORAGE, GUARANTEE_MODEL, true, false, false, true, false,
      { { noise, "noise" }, { flat, "a constant" }, { gradient, "a gradient" }, { edge, "an edge" }, { impulse, "an impulse" } } },
    { &occlusion_model_kind, GUARANTEE_STORAGE_8_BIT, GUARANTEE_MODEL, false, true, false, true, false,
      { { unit_noise, "noise" }, { flat, "a constant" }, { gradient, "a gradient" }, { edge, "an edge" }, { hole, "an impulse" } } },
    { &shadow_model_kind, GUARANTEE_STORAGE_SHADOW, GUARANTEE_MODEL_SHADOW, false, true, true, false, true,
      { { half_blocked, "noise" }, { all_lit, "a constant" }, { shadow_ramp, "a gradient" }, { shadow_edge, "an edge" }, { one_blocked, "an impulse" } } },
};

/* ---- runs */
/* stabilized: the luma over time, of denoisers of radiance. */
static any_settings settings_of(nrd_denoiser denoiser, bool stabilized)
{
    any_settings settings;
    nrd_settings_defaults(denoiser, &settings);
    if (denoiser == NRD_DENOISER_REBLUR_DIFFUSE || denoiser == NRD_DENOISER_REBLUR_SPECULAR) settings.REBLUR_DIFFUSE.antilag_sensitivity = 0, settings.REBLUR_DIFFUSE.max_stabilized_frames *= stabilized;
    if (denoiser == NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION) settings.REBLUR_DIFFUSE_OCCLUSION.antilag_sigma_scale = 100;
    return settings;
}

static void run_model(const model_kind *kind, any_model *m, scene *what, model_passes passes, bool stabilized)
{
    double in[MODEL_PIXELS];
    any_settings settings = settings_of(kind->denoiser, stabilized);
    kind->start(m, &settings, passes);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        for (uint32_t i = 0; i < MODEL_PIXELS; i++) in[i] = (double)(float)what(i % SIZE, i / SIZE, frame);
        kind->frame(m, in, frame);
    }
}

static void put_input(const rig *r, uint32_t x, uint32_t y, double v)
{
    float *t = rig_texel(r, r->signals[0].in, x, y);
    if (r->signals[0].kind == KIND_PENUMBRA) t[0] = v == MODEL_LIT ? 65504 : (float)(v * MODEL_PIXEL_UNITS);
    else t[0] = (float)v, t[1] = (float)(0.2 * v), t[2] = (float)(0.1 * v), t[3] = (float)MODEL_HIT_DIST;
}

static void run_device(rig *r, scene *what)
{
    rig_reset(r);
    r->index = 0;
    r->camera.aspect = 1;
    r->settings = settings_of(r->denoiser, true);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        rig_put_guides(r);
        fill_noise(r, NOISE_CONSTANT, 1, 0);
        FOR_PIXELS(r) put_input(r, x, y, what(x, y, frame));
        rig_run(r);
    }
}

/* ---- errors */
static void read_device(const rig *r, double values[MODEL_PIXELS]) { FOR_PIXELS(r) values[y * SIZE + x] = rig_output_value(r, 0, x, y); }
static void read_model(const modelled *of, const any_model *m, double values[MODEL_PIXELS])
{
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) values[i] = of->kind->value(m, i);
}

static double error_of(const modelled *of, const double *values, const double *truth, bool rms)
{
    double most = 0, squares = 0;
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) {
        double off = fabs(values[i] - truth[i]) / (of->relative ? truth[i] : 1);
        most = fmax(most, off);
        squares += off * off;
    }
    return rms ? sqrt(squares / MODEL_PIXELS) : most;
}

static double variance_of(const double *values)
{
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) sum += values[i], squares += values[i] * values[i];
    return squares / MODEL_PIXELS - sum * sum / MODEL_PIXELS / MODEL_PIXELS;
}

/* What the rounding of some passes costs. */
static double cost_of(const stress *s, const modelled *of, model_passes passes, bool stabilized)
{
    static any_model m;
    double values[MODEL_PIXELS], exact[MODEL_PIXELS], planted = s->fault == FAULT_DARK ? 0.95 : 1;
    run_model(of->kind, &m, of->scenes[0].what, (model_passes){ 0, 0 }, stabilized);
    read_model(of, &m, exact);
    run_model(of->kind, &m, of->scenes[0].what, passes, stabilized);
    read_model(of, &m, values);
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) values[i] *= planted;
    return error_of(of, values, exact, passes.stored && of->rms_stored);
}

static void check_passes(stress *s, const modelled *of)
{
    char name[64];
    for (uint32_t pass = 0; pass < of->kind->pass_count; pass++) {
        snprintf(name, sizeof name, "%s in 32 bits", of->kind->names[pass]);
        check(s, GUARANTEE_ARITHMETIC, name, of->kind->denoiser, cost_of(s, of, (model_passes){ 1u << pass, 0 }, false));
        snprintf(name, sizeof name, "%s stored as on the device", of->kind->names[pass]);
        check(s, of->stored, name, of->kind->denoiser, cost_of(s, of, (model_passes){ 0, 1u << pass }, false));
    }
    if (!of->relative) return;
    check(s, GUARANTEE_ARITHMETIC, "stabilization over time in 32 bits", of->kind->denoiser, cost_of(s, of, (model_passes){ 1u << REBLUR_MODEL_STABILIZATION, 0 }, true));
    check(s, GUARANTEE_STORAGE_STABILIZED, "stabilization over time stored as on the device", of->kind->denoiser, cost_of(s, of, (model_passes){ 0, 1u << REBLUR_MODEL_STABILIZATION }, true));
}

/* ---- the number of samples in a value */
enum { NOISE_RUNS = 240, NOISE_FRAMES = 4, MARGIN = 5 };   /* so many runs tell a variance to 6 %; MARGIN: px that a border may change */
#define POKE 1e-3
#define GENTLE 0.2                        /* noise of so much of the mean: filters are linear in it, and no cross turns */

/* Values of a run with noise of its own; poked: a sample in the middle of that frame is larger. */
static void run_gently(const modelled *of, any_model *m, uint32_t run, uint32_t poked, double values[MODEL_PIXELS])
{
    double in[MODEL_PIXELS];
    any_settings settings = settings_of(of->kind->denoiser, false);
    if (of->relative) settings.REBLUR_DIFFUSE.luminance_sigma_scale = 1000;
    of->kind->start(m, &settings, (model_passes){ 0, 0 });
    if (of->relative) m->reblur.endless = true;
    for (uint32_t frame = 0; frame < NOISE_FRAMES; frame++) {
        for (uint32_t i = 0; i < MODEL_PIXELS; i++) in[i] = 0.5 + GENTLE * (random_at(i % SIZE, i / SIZE, 1000 + NOISE_FRAMES * run + frame) - 0.5);
        if (frame == poked) in[SIZE / 2 * SIZE + SIZE / 2] += POKE;
        of->kind->frame(m, in, frame);
    }
    read_model(of, m, values);
}

/* Variance of the output over that of the input, by what one sample of each frame changes: the inverse of the effective number of samples. */
static double predicted_variance(const modelled *of, any_model *m)
{
    double values[MODEL_PIXELS], poked[MODEL_PIXELS], sum = 0;
    run_gently(of, m, 0, NOISE_FRAMES, values);
    for (uint32_t frame = 0; frame < NOISE_FRAMES; frame++) {
        run_gently(of, m, 0, frame, poked);
        for (uint32_t i = 0; i < MODEL_PIXELS; i++) sum += (poked[i] - values[i]) * (poked[i] - values[i]) / (POKE * POKE);
    }
    return sum;
}

static double measured_variance(const modelled *of, any_model *m)
{
    double values[MODEL_PIXELS], squares = 0, count = 0;
    for (uint32_t run = 0; run < NOISE_RUNS; run++) {
        run_gently(of, m, run, NOISE_FRAMES, values);
        for (uint32_t y = MARGIN; y < SIZE - MARGIN; y++)
            for (uint32_t x = MARGIN; x < SIZE - MARGIN; x++) squares += (values[y * SIZE + x] - 0.5) * (values[y * SIZE + x] - 0.5), count++;
    }
    return squares / count * 12 / (GENTLE * GENTLE);
}

static void check_samples(stress *s, const modelled *of)
{
    static any_model m;
    char name[64];
    double predicted = predicted_variance(of, &m), planted = s->fault == FAULT_NOISY ? 4 : 1;
    snprintf(name, sizeof name, "%.0f effective samples in %d frames", 1 / predicted, NOISE_FRAMES);
    check(s, GUARANTEE_SAMPLES, name, of->kind->denoiser, fabs(planted * measured_variance(of, &m) / predicted - 1));
}

static void check_all(stress *s, rig *r, const modelled *of)
{
    static any_model m;
    char name[64];
    double exact[MODEL_PIXELS], rounded[MODEL_PIXELS], device[MODEL_PIXELS];
    uint32_t passes = (1u << of->kind->pass_count) - 1;
    for (int i = 0; i < MOST_SCENES; i++) {
        run_model(of->kind, &m, of->scenes[i].what, (model_passes){ passes, passes }, true);
        read_model(of, &m, rounded);
        run_device(r, of->scenes[i].what);
        read_device(r, device);
        snprintf(name, sizeof name, "%s against the rounding model", of->scenes[i].name);
        check(s, of->device, name, r->denoiser, error_of(of, device, rounded, of->rms_device));
        if (i) continue;
        run_model(of->kind, &m, of->scenes[0].what, (model_passes){ 0, 0 }, true);
        read_model(of, &m, exact);
        check(s, GUARANTEE_VARIANCE, "variance of the filtered noise", r->denoiser, fabs(variance_of(device) / variance_of(of->varies_as_stored ? rounded : exact) - 1));
    }
    check_passes(s, of);
    if (of->linear) check_samples(s, of);
}

void stress_models(stress *s, rig *r)
{
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        if (all[i].kind->denoiser == r->denoiser) check_all(s, r, &all[i]);
}
