#include "stress/model.h"

#include <math.h>
#include <string.h>

/* ---- specular lobes: a neighbour counts as far as it sees the same reflection */
/* Surfaces as the rig has them, roughness 0.5: in 9 bits and a sign, of which the passes keep 8; the light hits MODEL_HIT_DIST of the way that counts. */
static double camera_distance(int i)
{
    double x = (i % MODEL_SIZE + 0.5 - MODEL_SIZE / 2) * MODEL_PIXEL_UNITS, y = (i / MODEL_SIZE + 0.5 - MODEL_SIZE / 2) * MODEL_PIXEL_UNITS;
    return sqrt(x * x + y * y + MODEL_DEPTH * MODEL_DEPTH);
}

/* Hit distance over itself and the distance to the camera; not that of the nearest of 3x3, which one stray sample may be. */
static double tracked(const nrd_reblur_settings *s, int i)
{
    const double roughness = 511.0 / 1023;
    double whole = (s->hit_distance_a + MODEL_DEPTH * s->hit_distance_b) * (1 + (s->hit_distance_c - 1) * exp2(s->hit_distance_d * roughness * roughness));
    double hit_dist = MODEL_HIT_DIST * whole, nearest = 2, second = 2;
    for (int k = 0; k < 9; k++) {
        int x = i % MODEL_SIZE + k % 3 - 1, y = i / MODEL_SIZE + k / 3 - 1;
        if (x < 0 || y < 0 || x >= MODEL_SIZE || y >= MODEL_SIZE) continue;
        double q = hit_dist / (hit_dist + camera_distance(y * MODEL_SIZE + x));
        second = fmin(second, fmax(nearest, q));
        nearest = fmin(nearest, q);
    }
    return second;
}

/* Pixels that a lobe sees; kept in 8 bits. */
static void track(reblur_model *m, uint32_t frame_index)
{
    const double alpha = 127.0 / 255 * 127 / 255;
    model_rounding r = model_rounding_of(m->passes, REBLUR_MODEL_ACCUMULATION);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double random = ((model_hash((uint32_t)i % MODEL_SIZE, (uint32_t)i / MODEL_SIZE, frame_index) >> 24) + 0.5) / 256;
        m->footprint[i] = alpha * camera_distance(i) * store_steps(r, reg(r, tracked(&m->settings, i)), 255, random) / MODEL_PIXEL_UNITS;
    }
}

static double lobe_weight(const reblur_model *m, int i, int dx, int dy, int step)
{
    double wide = 2.4 * m->footprint[i] / step;
    return m->specular ? exp(-0.5 * (dx * dx + dy * dy) / fmax(wide * wide, 1e-4)) : 1;
}

/* ---- temporal accumulation: Welford's recurrence */
static void accumulate(const reblur_model *m, const double *noisy, uint32_t frame_index, model_texel *to)
{
    const model_rounding r = model_rounding_of(m->passes, REBLUR_MODEL_ACCUMULATION);
    double before = fmin(m->frames, m->settings.max_accumulated_frames), alpha = reg(r, 1 / (1 + before));
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) {
        uint32_t random = model_hash(i % MODEL_SIZE, i / MODEL_SIZE, frame_index) >> 8;
        double sigma = 0;
        model_texel h = before > 0 ? m->history[i] : (model_texel){ 0, 0 };
        double delta = reg(r, noisy[i] - h.luma), luma = reg(r, reg(r, h.luma * reg(r, 1 - alpha)) + reg(r, noisy[i] * alpha));
        if (before >= 0.5) {
            double variance = reg(r, delta * delta * before / (before + 1)), share = reg(r, 1 / fmax(before, 1));
            sigma = reg(r, sqrt(reg(r, h.sigma * h.sigma * (1 - share)) + reg(r, variance * share)));
        }
        to[i].luma = store_half_dithered(r, luma, random);
        to[i].sigma = store_half_dithered(r, sigma, random);
    }
}

/* Of a neighbour; NULL: outside of the picture. */
static const model_texel *texel_at(const reblur_model *m, const model_texel *from, int x, int y)
{
    if (m->endless) x = (x + MODEL_SIZE) % MODEL_SIZE, y = (y + MODEL_SIZE) % MODEL_SIZE;
    return x >= 0 && y >= 0 && x < MODEL_SIZE && y < MODEL_SIZE ? &from[y * MODEL_SIZE + x] : NULL;
}

static double binomial(int dx, int dy) { return (dx == 0 ? 1 : 0.5) * (dy == 0 ? 1 : 0.5); }

/* ---- blur: dense, without a luma weight; pools the variance, part of it returns to history */
static void blur(reblur_model *m, const model_texel *from, model_texel *to, uint32_t frame_index)
{
    const model_rounding r = model_rounding_of(m->passes, REBLUR_MODEL_BLUR);
    double frames = fmax(m->frames, 1);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double color = 0, moment = 0, variance = 0, noise = 0, weight = 0;
        for (int k = 0; k < 9; k++) {
            int dx = k % 3 - 1, dy = k / 3 - 1;
            const model_texel *t = texel_at(m, from, i % MODEL_SIZE + dx, i / MODEL_SIZE + dy);
            if (!t) continue;
            double w = reg(r, binomial(dx, dy) * lobe_weight(m, i, dx, dy, 1)) * frames;
            color = reg(r, color + w * t->luma);
            moment = reg(r, moment + w * reg(r, t->sigma * t->sigma + (t->luma - from[i].luma) * (t->luma - from[i].luma)));
            variance = reg(r, variance + w * t->sigma * t->sigma);
            noise = reg(r, noise + w * w / frames);
            weight = reg(r, weight + w);
        }
        uint32_t random = model_hash((uint32_t)(i % MODEL_SIZE), (uint32_t)(i / MODEL_SIZE), ~frame_index) >> 8;
        double mean = reg(r, color / weight), off = reg(r, mean - from[i].luma), spread = reg(r, fmax(reg(r, moment / weight) - reg(r, off * off), 0));
        double back = fmin(1, m->settings.feedback_frames / frames);
        m->history[i].luma = store_half_dithered(r, reg(r, from[i].luma * (1 - back) + mean * back), random);
        m->history[i].sigma = store_half_dithered(r, reg(r, sqrt(variance / weight)), random);
        to[i].luma = store_half(r, mean);
        to[i].sigma = store_half(r, reg(r, sqrt(spread * noise) / weight));
    }
}

/* ---- sparse steps */
static bool is_turned(const model_texel *t, int x, int y, uint32_t frame_index)
{
    return t->sigma > 0.4 * t->luma && (model_hash((uint32_t)x, (uint32_t)y, frame_index) & 1u) != 0;
}

static model_texel atrous_at(const reblur_model *m, model_rounding r, const model_texel *from, int x, int y, int step, bool cross, uint32_t frame_index)
{
    static const int axes[4][2] = { { 1, 0 }, { 0, 1 }, { -1, 0 }, { 0, -1 } }, diagonals[4][2] = { { 1, 1 }, { -1, 1 }, { -1, -1 }, { 1, -1 } };
    const model_texel *c = &from[y * MODEL_SIZE + x];
    bool turned = cross && is_turned(c, x, y, frame_index);
    double color = c->luma, weight = 1, own = c->sigma * c->sigma, noise = own, least = 1e-12 * c->luma * c->luma + 1e-24;
    for (int k = 0; k < (cross ? 4 : 9); k++) {
        const int *way = turned ? diagonals[k & 3] : axes[k & 3];
        int dx = cross ? way[0] : k % 3 - 1, dy = cross ? way[1] : k / 3 - 1;
        const model_texel *t = texel_at(m, from, x + dx * step, y + dy * step);
        if (!t || t == c) continue;
        double variance = reg(r, t->sigma * t->sigma), luma = reg(r, fabs(c->luma - t->luma) / sqrt(reg(r, own + variance + least)));
        double w = reg(r, (cross ? 0.75 : binomial(dx, dy)) * lobe_weight(m, y * MODEL_SIZE + x, dx, dy, step) * exp(-1.4142136 / m->settings.luminance_sigma_scale * luma));
        color = reg(r, color + w * t->luma);
        noise = reg(r, noise + w * w * variance);
        weight = reg(r, weight + w);
    }
    return (model_texel){ reg(r, color / weight), reg(r, sqrt(noise) / weight) };
}

/* Stores what it gives, but in the last pass. */
static void atrous(const reblur_model *m, reblur_model_pass pass, const model_texel *from, model_texel *to, uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, pass);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        to[i] = atrous_at(m, r, from, i % MODEL_SIZE, i / MODEL_SIZE, 1 << (pass - REBLUR_MODEL_BLUR), pass == REBLUR_MODEL_POST_BLUR_1, frame_index);
        if (pass != REBLUR_MODEL_STABILIZATION) to[i] = (model_texel){ store_half(r, to[i].luma), store_half(r, to[i].sigma) };
    }
}

/* ---- stabilization: the luma goes towards the last frame's as far as the difference can be noise */
static void stabilize(reblur_model *m, uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, REBLUR_MODEL_STABILIZATION);
    double frames = fmin(m->frames + 3, m->settings.max_stabilized_frames), share = reg(r, frames / (1 + frames));
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double luma = m->out[i].luma, slack = reg(r, m->settings.stabilization_sigma_scale * m->out[i].sigma * (1 + 1.5 / fmax(m->frames, 1)));
        double most = luma / fmax(1 - slack / fmax(luma, 1e-12), 0.5), allowed = fmin(fmax(m->stabilized[i], luma - 0.58 * slack), most);
        if (m->frames > 1) luma = reg(r, luma * (1 - share) + allowed * share);
        m->stabilized[i] = store_half_dithered(r, luma, model_hash((uint32_t)i % MODEL_SIZE, (uint32_t)i / MODEL_SIZE, frame_index) >> 8);
        m->out[i].luma = store_half(r, luma);
    }
}

static double sum_of(const model_texel *texels)
{
    double sum = 0;
    for (int i = 0; i < MODEL_PIXELS; i++) sum += texels[i].luma;
    return sum;
}

static void start(any_model *any, const any_settings *settings, model_passes passes)
{
    memset(&any->reblur, 0, sizeof any->reblur);
    any->reblur.settings = settings->REBLUR_DIFFUSE;   /* the same struct for both */
    any->reblur.passes = passes;
}

static void start_specular(any_model *any, const any_settings *settings, model_passes passes)
{
    start(any, settings, passes);
    any->reblur.specular = true;
}

static void run_frame(any_model *any, const double *noisy, uint32_t frame_index)
{
    static model_texel a[MODEL_PIXELS], b[MODEL_PIXELS];
    model_texel *const between[2] = { a, b };
    reblur_model *m = &any->reblur;
    if (m->specular) track(m, frame_index);
    accumulate(m, noisy, frame_index, a);
    m->frames = fmin(fmin(m->frames, m->settings.max_accumulated_frames) + 1, 63.75);
    m->sum[REBLUR_MODEL_ACCUMULATION] = sum_of(a);
    blur(m, a, b, frame_index);
    m->sum[REBLUR_MODEL_BLUR] = sum_of(b);
    for (int pass = REBLUR_MODEL_POST_BLUR_1; pass <= REBLUR_MODEL_STABILIZATION; pass++) {
        model_texel *to = pass == REBLUR_MODEL_STABILIZATION ? m->out : between[pass & 1];
        atrous(m, (reblur_model_pass)pass, between[~pass & 1], to, frame_index);
        if (pass == REBLUR_MODEL_STABILIZATION) stabilize(m, frame_index);
        m->sum[pass] = sum_of(to);
    }
}

static double value(const any_model *any, uint32_t pixel) { return any->reblur.out[pixel].luma; }

#define MODEL_NAME(name, text) text,
const model_kind reblur_model_kind = { NRD_DENOISER_REBLUR_DIFFUSE, REBLUR_MODEL_PASS_COUNT, { REBLUR_MODEL_PASSES(MODEL_NAME) }, start, run_frame, value };
const model_kind specular_model_kind = { NRD_DENOISER_REBLUR_SPECULAR, REBLUR_MODEL_PASS_COUNT, { REBLUR_MODEL_PASSES(MODEL_NAME) }, start_specular, run_frame, value };
#undef MODEL_NAME
