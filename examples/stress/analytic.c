/* Inputs of which the answer is known: constants, gradients, edges. */
#include "stress/stress.h"

#include <stdio.h>
#include <stdlib.h>

enum { SIZE = 32 };

static double gradient(uint32_t x, uint32_t y) { return 0.2 + 0.02 * x + 0 * y; }
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

static void run_denoiser(stress *s, rig *r)
{
    static const double levels[] = { 1.0 / 8192, 0.1, 1, 1000, 60000 }, units[] = { 0.05, 1, 2.5 };
    bool unit = is_unit(r), shadow = r->signals[0].kind == KIND_PENUMBRA;
    for (size_t i = 0; i < (unit ? sizeof units : sizeof levels) / sizeof levels[0]; i++) constant(s, r, unit ? units[i] : levels[i], NULL, "constant");
    constant(s, r, 1, bumpy, "furnace");
    stress_models(s, r);
    if (shadow) return;
    keep(s, r, gradient, unit ? GUARANTEE_GRADIENT_8_BIT : GUARANTEE_GRADIENT, "gradient", 2, SIZE / 2);
    keep(s, r, edge, unit ? GUARANTEE_EDGE_8_BIT : GUARANTEE_EDGE, "edge of light", 0, SIZE / 2 - 4);
    check(s, GUARANTEE_EDGE_WIDTH, "edge of light", r->denoiser, edge_width(r));
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
