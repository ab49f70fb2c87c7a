/* Where the energy of an isolated impulse goes. Weights that compare lumas are divided by their sum, and the sums around a bright pixel differ
   from its own; so do those of crosses that are turned in some pixels. Without either, every pass keeps it. */
#include "stress/stress.h"
#include "stress/model.h"

#include <stdio.h>

enum { SIZE = 64, FRAMED = 32, REPEATS = 8 };   /* SIZE: nothing that the impulse reaches sees the border; FRAMED: it does; REPEATS: crosses are turned at random */
#define IMPULSE 5.0
#define UNCOMPARED 1000.0          /* luminance_sigma_scale */
#define RADIUS 4.0                 /* px; over more pixels the impulse adds less than the steps of halves that store their sum with the light around */

static bool is_lit(uint32_t x, uint32_t y, uint32_t size) { return x == size / 2 && y == size / 2; }
static double in_the_dark(uint32_t x, uint32_t y) { return is_lit(x, y, SIZE) ? IMPULSE : 0; }
static double in_a_frame(uint32_t x, uint32_t y) { return is_lit(x, y, FRAMED) ? IMPULSE : 0; }
/* Nowhere noisy enough to turn crosses. */
static double in_the_light(uint32_t x, uint32_t y) { return is_lit(x, y, SIZE) ? 1 + IMPULSE : 1; }

static bool is_luma(const rig *r, uint32_t s) { return r->signals[s].kind == KIND_RADIANCE || r->signals[s].kind == KIND_PLAIN; }

/* What the picture has more than its background, of the impulse. */
static double energy_of(const rig *r, uint32_t s, picture *what)
{
    double sum = 0;
    FOR_PIXELS(r) sum += rig_output_value(r, s, x, y) - what(0, 0);
    return sum / IMPULSE;
}

/* Lobes of one width everywhere. */
static void fill_light(rig *r, picture *what)
{
    fill_picture(r, what, 1);
    for (uint32_t s = 0; s < r->signal_count; s++)
        if (r->signals[s].kind == KIND_RADIANCE) FOR_PIXELS(r) rig_texel(r, r->signals[s].in, x, y)[3] = 0.5f;
}

static void check_device(stress *s, rig *r, picture *what, uint32_t frames, guarantee g)
{
    double energy[RIG_MAX_SIGNALS] = { 0 }, most = 0;
    uint32_t repeats = what == in_the_dark ? REPEATS : 1;
    char of[64];
    for (uint32_t repeat = 0; repeat < repeats; repeat++) {
        rig_reset(r);
        if (g == GUARANTEE_ENERGY) rig_set(r, "luminance_sigma_scale", UNCOMPARED), rig_set(r, "max_blur_radius", RADIUS);
        r->index = 9 + 1000 * repeat;
        for (uint32_t i = 0; i < frames; i++) {
            rig_put_guides(r);
            fill_light(r, what);
            rig_run(r);
        }
        for (uint32_t k = 0; k < r->signal_count; k++)
            if (is_luma(r, k)) energy[k] += energy_of(r, k, what) / repeats;
    }
    for (uint32_t k = 0; k < r->signal_count; k++)
        if (is_luma(r, k)) most = fmax(most, fabs(energy[k] - 1));
    snprintf(of, sizeof of, "impulse%s for %u frame%s", what == in_the_light ? " in light" : what == in_a_frame ? " in 32 px" : "", frames, frames > 1 ? "s" : "");
    check(s, g, of, r->denoiser, most);
}

/* The energy after each pass of the model. */
static void run_model(picture *what, double scale, uint32_t frames, double energy[REBLUR_MODEL_PASS_COUNT])
{
    static double noisy[1][MODEL_PIXELS];
    static any_model any;
    reblur_model *m = &any.reblur;
    any_settings settings = { .REBLUR_DIFFUSE = nrd_reblur_defaults() };
    settings.REBLUR_DIFFUSE.luminance_sigma_scale = (float)scale;
    settings.REBLUR_DIFFUSE.max_stabilized_frames = 0;
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) noisy[0][i] = is_lit(i % MODEL_SIZE, i / MODEL_SIZE, MODEL_SIZE) ? what(SIZE / 2, SIZE / 2) : what(0, 0);
    for (uint32_t repeat = 0; repeat < REPEATS; repeat++) {
        reblur_model_kinds[0].start(&any, &reblur_model_kinds[0], &settings, (model_passes){ 0, 0 });
        m->endless = true;
        m->components = 1;
        for (uint32_t i = 0; i < frames; i++) reblur_model_kinds[0].frame(&any, noisy, 9 + 1000 * repeat + i);
        for (int pass = 0; pass < REBLUR_MODEL_PASS_COUNT; pass++) energy[pass] += (m->signals[0].sum[pass] - MODEL_PIXELS * what(0, 0)) / (IMPULSE * REPEATS);
    }
}

static void check_model(stress *s, picture *what, double scale, uint32_t frames, guarantee of_weights)
{
    double energy[REBLUR_MODEL_PASS_COUNT] = { 0 }, planted = s->fault == FAULT_DARK ? 0.95 : 1;
    char of[96];
    run_model(what, scale, frames, energy);
    for (int pass = 0; pass < REBLUR_MODEL_PASS_COUNT; pass++) {
        snprintf(of, sizeof of, "impulse%s, scale %g, %u: %s", what == in_the_light ? " in light" : "", scale, frames, reblur_model_kinds[0].names[pass]);
        check(s, pass <= REBLUR_MODEL_BLUR ? GUARANTEE_ENERGY : of_weights, of, NRD_DENOISER_REBLUR_DIFFUSE, fabs(planted * energy[pass] - 1));
    }
}

static void check_models(stress *s)
{
    const double scale = nrd_reblur_defaults().luminance_sigma_scale;
    for (uint32_t frames = 1; frames <= 40; frames += 39) {
        guarantee outlier = frames == 1 ? GUARANTEE_OUTLIER_ENERGY : GUARANTEE_STILL_ENERGY;
        check_model(s, in_the_dark, scale, frames, outlier);
        check_model(s, in_the_dark, UNCOMPARED, frames, outlier);
        check_model(s, in_the_light, UNCOMPARED, frames, GUARANTEE_ENERGY);
    }
}

void stress_energy(stress *s, nrd_denoiser denoiser)
{
    rig r;
    rig_desc desc = stress_rig(s, denoiser, SIZE, SIZE);
    rig_open(&r, &desc);
    if (is_luma(&r, 0)) {
        check_device(s, &r, in_the_dark, 1, GUARANTEE_OUTLIER_ENERGY);
        check_device(s, &r, in_the_dark, 40, GUARANTEE_STILL_ENERGY);
        check_device(s, &r, in_the_light, 1, GUARANTEE_ENERGY);
        check_device(s, &r, in_the_light, 40, GUARANTEE_ENERGY);
    }
    rig_close(&r);
    desc = stress_rig(s, denoiser, FRAMED, FRAMED);
    rig_open(&r, &desc);
    if (is_luma(&r, 0)) {
        check_device(s, &r, in_a_frame, 1, GUARANTEE_FRAMED_ENERGY);
        check_device(s, &r, in_a_frame, 40, GUARANTEE_FRAMED_STILL_ENERGY);
    }
    rig_close(&r);
    if (denoiser == NRD_DENOISER_REBLUR_DIFFUSE) check_models(s);
}
