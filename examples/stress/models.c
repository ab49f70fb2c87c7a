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

/* What all models of a family have in common. */
typedef struct family {
    const model_kind *kinds;
    uint32_t kind_count;
    guarantee stored, device;
    bool relative;                                                       /* errors; of radiance */
    bool rms_stored, rms_device;                                         /* not the largest of all pixels */
    bool linear;                                                         /* in noise that is small */
    bool varies_as_stored;                                               /* what is rounded at random changes the variance */
    struct { scene *what; const char *name; } scenes[MOST_SCENES];       /* the first: noise */
} family;
#define OF_LIGHT { { noise, "noise" }, { flat, "a constant" }, { gradient, "a gradient" }, { edge, "an edge" }, { impulse, "an impulse" } }
static const family families[] = {
    { &reference_model_kind, 1, GUARANTEE_ARITHMETIC, GUARANTEE_ARITHMETIC, true, false, false, true, false, OF_LIGHT },
    { reblur_model_kinds, REBLUR_MODEL_KINDS, GUARANTEE_STORAGE, GUARANTEE_MODEL, true, false, false, true, false, OF_LIGHT },
    { occlusion_model_kinds, OCCLUSION_MODEL_KINDS, GUARANTEE_STORAGE_8_BIT, GUARANTEE_MODEL, false, true, false, true, false,
      { { unit_noise, "noise" }, { flat, "a constant" }, { gradient, "a gradient" }, { edge, "an edge" }, { hole, "an impulse" } } },
    { shadow_model_kinds, SHADOW_MODEL_KINDS, GUARANTEE_STORAGE_SHADOW, GUARANTEE_MODEL_SHADOW, false, true, true, false, true,
      { { half_blocked, "noise" }, { all_lit, "a constant" }, { shadow_ramp, "a gradient" }, { shadow_edge, "an edge" }, { one_blocked, "an impulse" } } },
};

/* ---- runs */
typedef double numbers[MODEL_MOST_LANES][MODEL_PIXELS];

/* Of a lane beside the value: noise in scenes of noise, the same everywhere in others. Such that no colour is darker than black, and no direction
   longer than what it belongs to. */
static double part_of(const model_lane *lane, uint32_t index, uint32_t x, uint32_t y, uint32_t frame, bool noisy)
{
    double random = noisy ? random_at(x + 64 * index, y, 2000 + frame) : 0.3 + 0.05 * index;
    switch (lane->role) {
    case LANE_PART: return 0.6 * random - 0.3;
    case LANE_DIRECTION: return 0.7 * random - 0.15;
    default: return floor(160 * random) / 255;
    }
}

/* As 32-bit floats hold them. */
static void make_input(const model_kind *kind, scene *what, uint32_t frame, bool noisy, numbers in)
{
    for (uint32_t lane = 0; lane < kind->lane_count; lane++)
        for (uint32_t i = 0; i < MODEL_PIXELS; i++) {
            const model_lane *l = &kind->lanes[lane];
            double v = l->role == LANE_VALUE ? what(i % SIZE, i / SIZE, frame + 4000 * lane) : part_of(l, lane, i % SIZE, i / SIZE, frame, noisy);
            in[lane][i] = (double)(float)(l->role == LANE_PART || l->role == LANE_DIRECTION ? v * in[l->of][i] : v);
        }
}

/* stabilized: the luma over time, of denoisers of radiance. */
static any_settings settings_of(const family *of, nrd_denoiser denoiser, bool stabilized)
{
    any_settings settings;
    nrd_settings_defaults(denoiser, &settings);
    if (of->kinds == reblur_model_kinds) settings.REBLUR_DIFFUSE.antilag_sensitivity = 0, settings.REBLUR_DIFFUSE.max_stabilized_frames *= stabilized;
    if (of->kinds == occlusion_model_kinds) settings.REBLUR_DIFFUSE_OCCLUSION.antilag_sigma_scale = 100;
    return settings;
}

static void run_model(const family *of, const model_kind *kind, uint32_t scene_index, model_passes passes, bool stabilized, numbers out)
{
    static numbers in;
    static any_model m;
    any_settings settings = settings_of(of, kind->denoiser, stabilized);
    kind->start(&m, kind, &settings, passes);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        make_input(kind, of->scenes[scene_index].what, frame, scene_index == 0, in);
        kind->frame(&m, in, frame);
    }
    for (uint32_t lane = 0; lane < kind->lane_count; lane++)
        for (uint32_t i = 0; i < MODEL_PIXELS && kind->lanes[lane].out != NRD_RESOURCE_COUNT; i++) out[lane][i] = kind->value(&m, lane, i);
}

static bool has_hit_dist(const model_lane *l) { return l->role == LANE_VALUE && l->channel == 0 && l->in != NRD_RESOURCE_IN_SIGNAL; }

static void put_input(rig *r, const model_kind *kind, numbers in)
{
    for (uint32_t lane = 0; lane < kind->lane_count; lane++)
        FOR_PIXELS(r) {
            const model_lane *l = &kind->lanes[lane];
            double v = in[lane][y * SIZE + x];
            if (l->in == NRD_RESOURCE_IN_PENUMBRA) v = v == MODEL_LIT ? 65504 : v * MODEL_PIXEL_UNITS;
            rig_texel(r, l->in, x, y)[l->channel] = (float)v;
            if (has_hit_dist(l)) rig_texel(r, l->in, x, y)[3] = (float)MODEL_HIT_DIST;
        }
}

/* Shadows are stored as roots. */
static double output_of(double texel, nrd_resource out) { return out == NRD_RESOURCE_OUT_SHADOW || out == NRD_RESOURCE_OUT_SHADOW_TRANSLUCENCY ? texel * texel : texel; }

static void run_device(rig *r, const family *of, const model_kind *kind, uint32_t scene_index, numbers out)
{
    static numbers in;
    rig_reset(r);
    r->index = 0;
    r->camera.aspect = 1;
    r->settings = settings_of(of, r->denoiser, true);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        rig_put_guides(r);
        fill_noise(r, NOISE_CONSTANT, 1, 0);
        make_input(kind, of->scenes[scene_index].what, frame, scene_index == 0, in);
        put_input(r, kind, in);
        rig_run(r);
    }
    for (uint32_t lane = 0; lane < kind->lane_count; lane++) {
        const model_lane *l = &kind->lanes[lane];
        if (l->out != NRD_RESOURCE_COUNT) FOR_PIXELS(r) out[lane][y * SIZE + x] = output_of(rig_texel(r, l->out, x, y)[l->channel], l->out);
    }
}

/* ---- errors */
/* Of values and their parts, or of directions. */
static double error_of(const family *of, const model_kind *kind, bool directions, numbers values, numbers truth, bool rms)
{
    double most = 0, squares = 0, count = 0;
    for (uint32_t lane = 0; lane < kind->lane_count; lane++) {
        const model_lane *l = &kind->lanes[lane];
        if (l->out == NRD_RESOURCE_COUNT || (l->role == LANE_DIRECTION) != directions) continue;
        for (uint32_t i = 0; i < MODEL_PIXELS; i++) {
            double off = fabs(values[lane][i] - truth[lane][i]) / (of->relative ? truth[l->of][i] : 1);
            most = fmax(most, off);
            squares += off * off;
            count++;
        }
    }
    return rms ? sqrt(squares / fmax(count, 1)) : most;
}

static double variance_of(const double *values)
{
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) sum += values[i], squares += values[i] * values[i];
    return squares / MODEL_PIXELS - sum * sum / MODEL_PIXELS / MODEL_PIXELS;
}

static bool has_directions(const model_kind *kind) { return (kind->parts & MODEL_DIRECTIONS) != 0; }

/* What the rounding of some passes costs. */
static void check_cost(stress *s, const family *of, const model_kind *kind, const char *name, model_passes passes, bool stabilized, numbers exact, guarantee g)
{
    static numbers values;
    double planted = s->fault == FAULT_DARK ? 0.95 : 1;
    run_model(of, kind, 0, passes, stabilized, values);
    for (uint32_t lane = 0; lane < kind->lane_count; lane++)
        for (uint32_t i = 0; i < MODEL_PIXELS; i++) values[lane][i] *= planted;
    check(s, g, name, kind->denoiser, error_of(of, kind, false, values, exact, passes.stored && of->rms_stored));
    if (!has_directions(kind)) return;
    char of_directions[96];
    snprintf(of_directions, sizeof of_directions, "directions: %s", name);
    check(s, passes.stored ? GUARANTEE_STORAGE_DIRECTIONS : GUARANTEE_ARITHMETIC, of_directions, kind->denoiser, error_of(of, kind, true, values, exact, passes.stored != 0));
}

static void check_pass(stress *s, const family *of, const model_kind *kind, const char *what, uint32_t pass, bool stabilized, numbers exact, guarantee stored)
{
    char name[64];
    snprintf(name, sizeof name, "%s in 32 bits", what);
    check_cost(s, of, kind, name, (model_passes){ 1u << pass, 0 }, stabilized, exact, GUARANTEE_ARITHMETIC);
    snprintf(name, sizeof name, "%s stored as on the device", what);
    check_cost(s, of, kind, name, (model_passes){ 0, 1u << pass }, stabilized, exact, stored);
}

/* exact: of noise, stabilized. */
static void check_passes(stress *s, const family *of, const model_kind *kind, numbers exact)
{
    static numbers fresh;
    bool stabilizes = kind->pass_count == REBLUR_MODEL_PASS_COUNT;
    if (stabilizes) run_model(of, kind, 0, (model_passes){ 0, 0 }, false, fresh);
    for (uint32_t pass = 0; pass < kind->pass_count; pass++) check_pass(s, of, kind, kind->names[pass], pass, false, stabilizes ? fresh : exact, of->stored);
    if (stabilizes) check_pass(s, of, kind, "stabilization over time", REBLUR_MODEL_STABILIZATION, true, exact, GUARANTEE_STORAGE_STABILIZED);
}

/* ---- the number of samples in a value */
enum { NOISE_RUNS = 240, NOISE_FRAMES = 4, MARGIN = 5 };   /* so many runs tell a variance to 6 %; MARGIN: px that a border may change */
#define POKE 1e-3
#define GENTLE 0.2                        /* noise of so much of the mean: filters are linear in it, and no cross turns */

/* Values of a run with noise of its own; poked: a sample in the middle of that frame is larger. */
static void run_gently(const family *of, const model_kind *kind, any_model *m, uint32_t run, uint32_t poked, double values[MODEL_PIXELS])
{
    double in[1][MODEL_PIXELS];
    any_settings settings = settings_of(of, kind->denoiser, false);
    bool reblur = of->kinds == reblur_model_kinds;
    if (reblur) settings.REBLUR_DIFFUSE.luminance_sigma_scale = 1000;
    kind->start(m, kind, &settings, (model_passes){ 0, 0 });
    if (reblur) m->reblur.endless = true, m->reblur.components = 1;
    for (uint32_t frame = 0; frame < NOISE_FRAMES; frame++) {
        for (uint32_t i = 0; i < MODEL_PIXELS; i++) in[0][i] = 0.5 + GENTLE * (random_at(i % SIZE, i / SIZE, 1000 + NOISE_FRAMES * run + frame) - 0.5);
        if (frame == poked) in[0][SIZE / 2 * SIZE + SIZE / 2] += POKE;
        kind->frame(m, in, frame);
    }
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) values[i] = kind->value(m, 0, i);
}

/* Variance of the output over that of the input, by what one sample of each frame changes: the inverse of the effective number of samples. */
static double predicted_variance(const family *of, const model_kind *kind, any_model *m)
{
    double values[MODEL_PIXELS], poked[MODEL_PIXELS], sum = 0;
    run_gently(of, kind, m, 0, NOISE_FRAMES, values);
    for (uint32_t frame = 0; frame < NOISE_FRAMES; frame++) {
        run_gently(of, kind, m, 0, frame, poked);
        for (uint32_t i = 0; i < MODEL_PIXELS; i++) sum += (poked[i] - values[i]) * (poked[i] - values[i]) / (POKE * POKE);
    }
    return sum;
}

static double measured_variance(const family *of, const model_kind *kind, any_model *m)
{
    double values[MODEL_PIXELS], squares = 0, count = 0;
    for (uint32_t run = 0; run < NOISE_RUNS; run++) {
        run_gently(of, kind, m, run, NOISE_FRAMES, values);
        for (uint32_t y = MARGIN; y < SIZE - MARGIN; y++)
            for (uint32_t x = MARGIN; x < SIZE - MARGIN; x++) squares += (values[y * SIZE + x] - 0.5) * (values[y * SIZE + x] - 0.5), count++;
    }
    return squares / count * 12 / (GENTLE * GENTLE);
}

/* Of denoisers of one number a pixel, or of light: others have the same weights. */
static void check_samples(stress *s, const family *of, const model_kind *kind)
{
    static any_model m;
    char name[64];
    double predicted = predicted_variance(of, kind, &m), planted = s->fault == FAULT_NOISY ? 4 : 1;
    snprintf(name, sizeof name, "%.0f effective samples in %d frames", 1 / predicted, NOISE_FRAMES);
    check(s, GUARANTEE_SAMPLES, name, kind->denoiser, fabs(planted * measured_variance(of, kind, &m) / predicted - 1));
}

/* ---- devices */
static void check_scene(stress *s, rig *r, const family *of, const model_kind *kind, uint32_t scene_index, numbers device, numbers rounded)
{
    char name[64];
    uint32_t passes = (1u << kind->pass_count) - 1;
    run_model(of, kind, scene_index, (model_passes){ passes, passes }, true, rounded);
    run_device(r, of, kind, scene_index, device);
    snprintf(name, sizeof name, "%s against the rounding model", of->scenes[scene_index].name);
    check(s, of->device, name, r->denoiser, error_of(of, kind, false, device, rounded, of->rms_device));
    snprintf(name, sizeof name, "directions of %s", of->scenes[scene_index].name);
    if (has_directions(kind)) check(s, GUARANTEE_MODEL_DIRECTIONS, name, r->denoiser, error_of(of, kind, true, device, rounded, true));
}

static void check_variances(stress *s, const model_kind *kind, numbers device, numbers model)
{
    double most = 0;
    for (uint32_t lane = 0; lane < kind->lane_count; lane++)
        if (kind->lanes[lane].role == LANE_VALUE && kind->lanes[lane].out != NRD_RESOURCE_COUNT) most = fmax(most, fabs(variance_of(device[lane]) / variance_of(model[lane]) - 1));
    check(s, GUARANTEE_VARIANCE, "variance of the filtered noise", kind->denoiser, most);
}

static void check_kind(stress *s, rig *r, const family *of, const model_kind *kind)
{
    static numbers exact, rounded, device;
    run_model(of, kind, 0, (model_passes){ 0, 0 }, true, exact);
    for (uint32_t i = 0; i < MOST_SCENES; i++) {
        check_scene(s, r, of, kind, i, device, rounded);
        if (i == 0) check_variances(s, kind, device, of->varies_as_stored ? rounded : exact);
    }
    check_passes(s, of, kind, exact);
    if (of->linear && kind->parts && !(kind->parts & (kind->parts - 1))) check_samples(s, of, kind);
}

void stress_models(stress *s, rig *r)
{
    for (size_t i = 0; i < sizeof families / sizeof families[0]; i++)
        for (uint32_t k = 0; k < families[i].kind_count; k++)
            if (families[i].kinds[k].denoiser == r->denoiser) check_kind(s, r, &families[i], &families[i].kinds[k]);
}
