/* Inputs of which the answer is known: constants, gradients, edges, noise of known variance; and a model of the passes. */
#include "stress/stress.h"
#include "stress/model.h"

#include <stdio.h>
#include <stdlib.h>

enum { SIZE = MODEL_SIZE, MODEL_FRAMES = 12 };

static double gradient(uint32_t x, uint32_t y) { return 0.2 + 0.02 * x + 0 * y; }
static double flat(uint32_t x, uint32_t y) { return 0.1 + 0 * x + 0 * y; }
static double dot(uint32_t x, uint32_t y) { return x == SIZE / 2 && y == SIZE / 2 ? 6 : 1; }
static double edge(uint32_t x, uint32_t y) { return x < SIZE / 2 ? 0.1 + 0 * y : 1; }

static bool is_shown(const rig *r, uint32_t s)
{
    signal_kind kind = r->signals[s].kind;
    return r->signals[s].out != NRD_RESOURCE_COUNT && kind != KIND_VECTOR && kind != KIND_TRANSLUCENCY && kind != KIND_PENUMBRA;
}

static bool is_unit(const rig *r) { return r->signals[0].kind == KIND_HIT_DIST || r->signals[0].kind == KIND_DIRECTION; }

static void show(rig *r, picture *what, double scale, uint32_t frames)
{
    rig_reset(r);
    r->index = 9;
    for (uint32_t i = 0; i < frames; i++) {
        rig_put_guides(r);
        fill_picture(r, what, scale);
        rig_run(r);
    }
}

/* ---- constants; the furnace: the same light, whatever the surface is */
static surface bumpy(const rig *r, uint32_t x, uint32_t y)
{
    surface s = rig_surface(r, x, y);
    double a = 0.8 * (random_at(x, y, 1) - 0.5), b = 0.8 * (random_at(x, y, 2) - 0.5), length = sqrt(1 + a * a + b * b);
    s.normal[0] = a / length, s.normal[1] = b / length, s.normal[2] = -1 / length;
    s.roughness = random_at(x, y, 3);
    s.depth *= x / 5 % 2 ? 1 : 1.5;
    s.material = random_at(x / 4, y / 4, 4) < 0.5;
    return s;
}

static void constant(stress *s, rig *r, double level, shape *shape, const char *name)
{
    char of[64];
    double most = 0;
    rig_reset(r);
    r->index = 9;
    if (shape) r->shape = shape;
    for (uint32_t i = 0; i < 40; i++) {
        rig_put_guides(r);
        fill_noise(r, NOISE_CONSTANT, level, 0);
        rig_run(r);
    }
    for (uint32_t k = 0; k < r->signal_count; k++)
        FOR_PIXELS(r) {
            if (r->signals[k].out == NRD_RESOURCE_COUNT || r->signals[k].kind == KIND_VECTOR) continue;
            double in = rig_input_value(r, k, x, y), out = rig_output_value(r, k, x, y);
            most = fmax(most, fabs(out - in) / (is_unit(r) ? 1 : fmax(in, 1e-30)));
        }
    snprintf(of, sizeof of, "%s %g", name, level);
    check(s, is_unit(r) ? GUARANTEE_CONSTANT_8_BIT : GUARANTEE_CONSTANT, of, r->denoiser, most);
}

/* ---- shapes of light */
/* Most that a picture without noise is off in the middle columns from .. to, counted from either side. */
static void keep(stress *s, rig *r, picture *what, guarantee g, const char *name, uint32_t from, uint32_t to)
{
    double most = 0;
    show(r, what, 1, 40);
    for (uint32_t k = 0; k < r->signal_count; k++)
        for (uint32_t y = 0; is_shown(r, k) && y < SIZE; y++)
            for (uint32_t x = 0; x < SIZE; x++) if ((x >= from && x < to) || (SIZE - 1 - x >= from && SIZE - 1 - x < to)) most = fmax(most, fabs(rig_output_value(r, k, x, y) - what(x, y)) / (is_unit(r) ? 1 : what(x, y)));
    check(s, g, name, r->denoiser, most);
}

/* Standard deviation in pixels of what an edge is spread over. Call after keep() of the edge. */
static double edge_width(const rig *r)
{
    double most = 0;
    for (uint32_t k = 0; k < r->signal_count; k++) {
        double sum = 0, first = 0, second = 0;
        for (uint32_t x = 0; is_shown(r, k) && x + 1 < SIZE; x++) {
            double step = rig_output_value(r, k, x + 1, SIZE / 2) - rig_output_value(r, k, x, SIZE / 2);
            sum += step, first += step * x, second += step * x * x;
        }
        if (sum > 0) most = fmax(most, sqrt(fmax(second / sum - first * first / (sum * sum), 0)));
    }
    return most;
}

/* ---- the model */
static double noise_of(uint32_t i, uint32_t frame) { return 2 * random_at(i % SIZE, i / SIZE, 100 + frame); }

/* What is in a frame: a picture, or noise. */
static double light_of(picture *what, uint32_t i, uint32_t frame) { return what ? what(i % SIZE, i / SIZE) : noise_of(i, frame); }

static void run_model(model *m, const nrd_reblur_settings *settings, picture *what, uint32_t single, uint32_t half)
{
    static double noisy[MODEL_PIXELS];
    model_start(m, settings, single, half);
    for (uint32_t frame = 0; frame < MODEL_FRAMES; frame++) {
        for (uint32_t i = 0; i < MODEL_PIXELS; i++) noisy[i] = (double)(float)light_of(what, i, frame);
        model_frame(m, noisy, frame);
    }
}

static double most_apart(const stress *s, const model *a, const model *b)
{
    double most = 0, planted = s->fault == FAULT_DARK ? 0.95 : 1;
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) most = fmax(most, fabs(planted * a->out[i].luma / b->out[i].luma - 1));
    return most;
}

static void run_device(rig *r, const nrd_reblur_settings *settings, picture *what)
{
    rig_reset(r);
    r->index = 0;
    r->settings.REBLUR_DIFFUSE = *settings;
    for (uint32_t frame = 0; frame < MODEL_FRAMES; frame++) {
        rig_put_guides(r);
        fill_noise(r, NOISE_CONSTANT, 1, 0);
        FOR_PIXELS(r) {
            float *t = rig_texel(r, NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, x, y), v = (float)light_of(what, x + SIZE * y, frame);
            t[0] = v, t[1] = 0.2f * v, t[2] = 0.1f * v;
        }
        rig_run(r);
    }
}

static double off_model(const rig *r, const model *m)
{
    double most = 0;
    for (uint32_t i = 0; i < MODEL_PIXELS; i++)
        most = fmax(most, fabs(*rig_texel(r, NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST, i % SIZE, i / SIZE) / m->out[i].luma - 1));
    return most;
}

static void compare_pictures(stress *s, rig *r, const nrd_reblur_settings *settings, uint32_t all)
{
    static const struct { picture *what; const char *of; } pictures[] = {
        { flat, "a constant against the rounding model" }, { gradient, "a gradient against the rounding model" },
        { edge, "an edge against the rounding model" }, { dot, "an impulse against the rounding model" },
    };
    static model m;
    for (size_t i = 0; i < sizeof pictures / sizeof pictures[0]; i++) {
        run_model(&m, settings, pictures[i].what, all, all);
        run_device(r, settings, pictures[i].what);
        check(s, GUARANTEE_MODEL, pictures[i].of, r->denoiser, off_model(r, &m));
    }
}

static double variance_of(const model *m)
{
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) sum += m->out[i].luma, squares += m->out[i].luma * m->out[i].luma;
    return squares / MODEL_PIXELS - sum * sum / MODEL_PIXELS / MODEL_PIXELS;
}

static void compare_with_model(stress *s, rig *r)
{
    static model exact, rounded;
    const uint32_t all = (1u << MODEL_PASS_COUNT) - 1;
    nrd_reblur_settings settings = nrd_reblur_defaults();
    char of[64];
    settings.antilag_sensitivity = 0;
    settings.max_stabilized_frames = 0;
    run_model(&exact, &settings, NULL, 0, 0);
    for (uint32_t pass = 0; pass < MODEL_PASS_COUNT; pass++) {
        snprintf(of, sizeof of, "%s in 32 bits", model_pass_name((model_pass)pass));
        run_model(&rounded, &settings, NULL, 1u << pass, 0);
        check(s, GUARANTEE_ARITHMETIC, of, r->denoiser, most_apart(s, &rounded, &exact));
        snprintf(of, sizeof of, "%s stored in 16 bits", model_pass_name((model_pass)pass));
        run_model(&rounded, &settings, NULL, 0, 1u << pass);
        check(s, GUARANTEE_STORAGE, of, r->denoiser, most_apart(s, &rounded, &exact));
    }
    compare_pictures(s, r, &settings, all);
    run_model(&rounded, &settings, NULL, all, all);
    run_device(r, &settings, NULL);
    check(s, GUARANTEE_MODEL, "the device against the rounding model", r->denoiser, off_model(r, &rounded));
    double deviation = output_moments(r, 0).deviation;
    check(s, GUARANTEE_VARIANCE, "variance of the filtered noise", r->denoiser, fabs(deviation * deviation / variance_of(&exact) - 1));
}

static void run_denoiser(stress *s, rig *r)
{
    static const double levels[] = { 1.0 / 8192, 0.1, 1, 1000, 60000 }, units[] = { 0.05, 1, 2.5 };
    bool unit = is_unit(r), shadow = r->signals[0].kind == KIND_PENUMBRA;
    for (size_t i = 0; i < (unit ? sizeof units : sizeof levels) / sizeof levels[0]; i++) constant(s, r, unit ? units[i] : levels[i], NULL, "constant");
    constant(s, r, 1, bumpy, "furnace");
    if (shadow) return;
    keep(s, r, gradient, unit ? GUARANTEE_GRADIENT_8_BIT : GUARANTEE_GRADIENT, "gradient", 2, SIZE / 2);
    keep(s, r, edge, unit ? GUARANTEE_EDGE_8_BIT : GUARANTEE_EDGE, "edge of light", 0, SIZE / 2 - 4);
    check(s, GUARANTEE_EDGE_WIDTH, "edge of light", r->denoiser, edge_width(r));
    if (unit) return;
    if (r->denoiser == NRD_DENOISER_REBLUR_DIFFUSE) compare_with_model(s, r);
}

void stress_analytic(stress *s)
{
    for (int d = (int)s->first; d <= (int)s->last; d++) {
        rig r;
        rig_desc desc = stress_rig(s, (nrd_denoiser)d, SIZE, SIZE);
        rig_open(&r, &desc);
        run_denoiser(s, &r);
        rig_close(&r);
        stress_energy(s, (nrd_denoiser)d);
    }
}
