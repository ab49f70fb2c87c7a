/* REBLUR_DIFFUSE_OCCLUSION: averages over time that no filter touches, and two discs of eight taps. */
#include "stress/model.h"

#include <math.h>
#include <string.h>

enum { ACCUMULATION, BLUR, POST_BLUR, PASSES, TAPS = 8 };

#define LEAST_RADIUS (1.0 / 64)
#define MEAN_STEPS 4080.0

static double random_of(int i, uint32_t frame_index) { return ((model_hash((uint32_t)i % MODEL_SIZE, (uint32_t)i / MODEL_SIZE, frame_index) >> 24) + 0.5) / 256; }
static bool is_inside(int x, int y) { return x >= 0 && y >= 0 && x < MODEL_SIZE && y < MODEL_SIZE; }

/* ---- accumulation */
/* Over the 6x6 pixels of the quads around, and the pixel once more. */
static double harmonic_mean(model_rounding r, const double *in, int i)
{
    int left = i % MODEL_SIZE / 2 * 2 - 2, top = i / MODEL_SIZE / 2 * 2 - 2;
    double number = 1, reciprocals = 1 / fmax(in[i], LEAST_RADIUS);
    for (int y = top; y < top + 6; y++)
        for (int x = left; x < left + 6; x++) {
            if (!is_inside(x, y)) continue;
            reciprocals = reg(r, reciprocals + 1 / fmax(in[y * MODEL_SIZE + x], LEAST_RADIUS));
            number++;
        }
    return reg(r, number / reciprocals);
}

static double store_radius(model_rounding r, double radius, double random)
{
    double code = 63 + 10.5 * log2(fmin(fmax(radius, LEAST_RADIUS), 1)) + random;
    return r.stored ? exp2((floor(fmin(fmax(code, 0), 63)) - 63) / 10.5) : fmin(fmax(radius, LEAST_RADIUS), 1);
}

static void accumulate(occlusion_model *m, const double *in, uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, ACCUMULATION);
    double before = fmin(m->frames, m->settings.max_accumulated_frames), alpha = reg(r, 1 / (1 + before)), rest = reg(r, 1 - alpha);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double random = random_of(i, frame_index);
        m->history[i] = store_steps(r, reg(r, m->history[i] * rest + in[i] * alpha), MEAN_STEPS, random);
        m->radius[i] = store_radius(r, reg(r, m->radius[i] * rest + harmonic_mean(r, in, i) * alpha), random);
    }
    m->frames = fmin(before + 1, 63);
}

/* What taps read of a mean: its upper 8 bits. */
static double as_tap(model_rounding r, double mean) { return r.stored ? floor((mean * MEAN_STEPS + 8.5) / 16) / 255 : mean; }

/* ---- the blurs */
/* Offsets of the taps in px, for a radius of 1. The axes in the plane are up and left; the second disc is turned by 1.2. */
static void place_taps(uint32_t pass, double offsets[TAPS][2])
{
    static const double disc[TAPS][2] = { { 0.2500, 0.0000 }, { -0.3193, 0.2925 }, { 0.0489, -0.5569 }, { 0.4024, 0.5249 },
                                          { -0.7385, -0.1306 }, { 0.6996, -0.4450 }, { -0.2340, 0.8705 }, { -0.4462, -0.8592 } };
    for (int k = 0; k < TAPS; k++) {
        double x = disc[k][0], y = disc[k][1];
        if (pass == POST_BLUR) x = 0.3624 * disc[k][0] - 0.9320 * disc[k][1], y = 0.9320 * disc[k][0] + 0.3624 * disc[k][1];
        offsets[k][0] = -y;
        offsets[k][1] = x;
    }
}

/* Pixels: as wide as near occluders allow, wider while history is short. */
static double radius_of(const occlusion_model *m, model_rounding r, int i)
{
    double unoccluded = (m->settings.hit_distance_a + MODEL_DEPTH * m->settings.hit_distance_b) * (1 + (m->settings.hit_distance_c - 1) * exp2(m->settings.hit_distance_d));
    double wide = 0.17 * m->radius[i] * unoccluded / MODEL_PIXEL_UNITS, fresh = 5.7 / sqrt(fmax(m->frames, 1));
    return reg(r, fmin(fmax(wide, fresh), m->settings.max_blur_radius));
}

static double blur_at(model_rounding r, int i, double own, const double *taps, double offsets[TAPS][2], double radius)
{
    double sum = own, weight = 1;
    for (int k = 0; k < TAPS; k++) {
        int x = i % MODEL_SIZE + (int)nearbyint(radius * offsets[k][0]), y = i / MODEL_SIZE + (int)nearbyint(radius * offsets[k][1]);
        if (!is_inside(x, y)) continue;
        double w = reg(r, exp2(-0.05 * (k + 0.5)));
        sum = reg(r, sum + w * taps[y * MODEL_SIZE + x]);
        weight = reg(r, weight + w);
    }
    return reg(r, sum / weight);
}

static void blur(const occlusion_model *m, double *to, uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, BLUR), before = model_rounding_of(m->passes, ACCUMULATION);
    double taps[MODEL_PIXELS], offsets[TAPS][2];
    place_taps(BLUR, offsets);
    for (int i = 0; i < MODEL_PIXELS; i++) taps[i] = as_tap(before, m->history[i]);
    for (int i = 0; i < MODEL_PIXELS; i++)
        to[i] = store_steps(r, blur_at(r, i, m->history[i], taps, offsets, radius_of(m, r, i)), 1023, random_of(i, ~frame_index));
}

static void post_blur(occlusion_model *m, const double *from)
{
    model_rounding r = model_rounding_of(m->passes, POST_BLUR);
    double offsets[TAPS][2];
    place_taps(POST_BLUR, offsets);
    for (int i = 0; i < MODEL_PIXELS; i++) m->out[i] = store_half(r, blur_at(r, i, from[i], from, offsets, 0.5 * radius_of(m, r, i)));
}

/* ---- a model */
static void start(any_model *any, const any_settings *settings, model_passes passes)
{
    memset(&any->occlusion, 0, sizeof any->occlusion);
    any->occlusion.settings = settings->REBLUR_DIFFUSE_OCCLUSION;
    any->occlusion.passes = passes;
}

static void run_frame(any_model *any, const double *in, uint32_t frame_index)
{
    double between[MODEL_PIXELS];
    accumulate(&any->occlusion, in, frame_index);
    blur(&any->occlusion, between, frame_index);
    post_blur(&any->occlusion, between);
}

static double value(const any_model *any, uint32_t pixel) { return any->occlusion.out[pixel]; }

const model_kind occlusion_model_kind = { NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, PASSES, { "accumulation", "blur", "post-blur" }, start, run_frame, value };
