#include "stress/model.h"

#include <math.h>
#include <string.h>

const char *model_pass_name(model_pass pass)
{
    static const char *const names[] = {
#define MODEL_NAME(name, text) text,
        MODEL_PASSES(MODEL_NAME)
#undef MODEL_NAME
    };
    return names[pass];
}

/* ---- rounding */
static uint32_t bits_of(float f) { uint32_t u; memcpy(&u, &f, 4); return u; }
static double number_of(uint32_t u) { float f; memcpy(&f, &u, 4); return f; }

/* What a pass computes, stands in its registers. */
static double reg(const model *m, model_pass pass, double v) { return m->single >> pass & 1u ? (double)(float)v : v; }

static double store(const model *m, model_pass pass, double v)
{
    float raised = (float)v + 0.75f;
    return m->half >> pass & 1u ? number_of((bits_of(raised - 0.75f) + 0x1000u) & 0xffffe000u) : v;
}

static double store_dithered(const model *m, model_pass pass, double v, uint32_t random)
{
    return m->half >> pass & 1u ? number_of((bits_of((float)v) + (random >> 11)) & 0xffffe000u) : v;
}

static uint32_t hash(uint32_t x, uint32_t y, uint32_t z)
{
    uint32_t h = x * 0x9e3779b1u + y * 0x85ebca77u + z * 0xc2b2ae3du;
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return h ^ (h >> 16);
}

/* ---- temporal accumulation: Welford's recurrence */
static void accumulate(const model *m, const double *noisy, uint32_t frame_index, model_texel *to)
{
    const model_pass p = MODEL_ACCUMULATION;
    double before = fmin(m->frames, m->settings.max_accumulated_frames), alpha = reg(m, p, 1 / (1 + before));
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) {
        uint32_t random = hash(i % MODEL_SIZE, i / MODEL_SIZE, frame_index) >> 8;
        double sigma = 0;
        model_texel h = before > 0 ? m->history[i] : (model_texel){ 0, 0 };
        double delta = reg(m, p, noisy[i] - h.luma), luma = reg(m, p, reg(m, p, h.luma * reg(m, p, 1 - alpha)) + reg(m, p, noisy[i] * alpha));
        if (before >= 0.5) {
            double variance = reg(m, p, delta * delta * before / (before + 1)), share = reg(m, p, 1 / fmax(before, 1));
            sigma = reg(m, p, sqrt(reg(m, p, h.sigma * h.sigma * (1 - share)) + reg(m, p, variance * share)));
        }
        to[i].luma = store_dithered(m, p, luma, random);
        to[i].sigma = store_dithered(m, p, sigma, random);
    }
}

/* Of a neighbour; NULL: outside of the picture. */
static const model_texel *texel_at(const model *m, const model_texel *from, int x, int y)
{
    if (m->endless) x = (x + MODEL_SIZE) % MODEL_SIZE, y = (y + MODEL_SIZE) % MODEL_SIZE;
    return x >= 0 && y >= 0 && x < MODEL_SIZE && y < MODEL_SIZE ? &from[y * MODEL_SIZE + x] : NULL;
}

static double binomial(int dx, int dy) { return (dx == 0 ? 1 : 0.5) * (dy == 0 ? 1 : 0.5); }

/* ---- blur: dense, without a luma weight; pools the variance, part of it returns to history */
static void blur(model *m, const model_texel *from, model_texel *to, uint32_t frame_index)
{
    const model_pass p = MODEL_BLUR;
    double frames = fmax(m->frames, 1);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double color = 0, moment = 0, variance = 0, noise = 0, weight = 0;
        for (int k = 0; k < 9; k++) {
            int dx = k % 3 - 1, dy = k / 3 - 1;
            const model_texel *t = texel_at(m, from, i % MODEL_SIZE + dx, i / MODEL_SIZE + dy);
            if (!t) continue;
            double w = binomial(dx, dy) * frames;
            color = reg(m, p, color + w * t->luma);
            moment = reg(m, p, moment + w * reg(m, p, t->sigma * t->sigma + t->luma * t->luma));
            variance = reg(m, p, variance + w * t->sigma * t->sigma);
            noise = reg(m, p, noise + w * w / frames);
            weight = reg(m, p, weight + w);
        }
        uint32_t random = hash((uint32_t)(i % MODEL_SIZE), (uint32_t)(i / MODEL_SIZE), ~frame_index) >> 8;
        double mean = reg(m, p, color / weight), spread = reg(m, p, fmax(reg(m, p, moment / weight) - reg(m, p, mean * mean), 0));
        double back = fmin(1, m->settings.feedback_frames / frames);
        m->history[i].luma = store_dithered(m, p, reg(m, p, from[i].luma * (1 - back) + mean * back), random);
        m->history[i].sigma = store_dithered(m, p, reg(m, p, sqrt(variance / weight)), random);
        to[i].luma = store(m, p, mean);
        to[i].sigma = store(m, p, reg(m, p, sqrt(spread * noise) / weight));
    }
}

/* ---- sparse steps */
static bool is_turned(const model_texel *t, int x, int y, uint32_t frame_index)
{
    return t->sigma > 0.4 * t->luma && (hash((uint32_t)x, (uint32_t)y, frame_index) & 1u) != 0;
}

static model_texel atrous_at(const model *m, model_pass p, const model_texel *from, int x, int y, int step, bool cross, uint32_t frame_index)
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
        double variance = reg(m, p, t->sigma * t->sigma), luma = reg(m, p, fabs(c->luma - t->luma) / sqrt(reg(m, p, own + variance + least)));
        double w = reg(m, p, (cross ? 0.75 : binomial(dx, dy)) * exp(-1.4142136 / m->settings.luminance_sigma_scale * luma));
        color = reg(m, p, color + w * t->luma);
        noise = reg(m, p, noise + w * w * variance);
        weight = reg(m, p, weight + w);
    }
    return (model_texel){ store(m, p, reg(m, p, color / weight)), store(m, p, reg(m, p, sqrt(noise) / weight)) };
}

static void atrous(const model *m, model_pass pass, const model_texel *from, model_texel *to, uint32_t frame_index)
{
    for (int i = 0; i < MODEL_PIXELS; i++) to[i] = atrous_at(m, pass, from, i % MODEL_SIZE, i / MODEL_SIZE, 1 << (pass - MODEL_BLUR), pass == MODEL_POST_BLUR_1, frame_index);
}

static double sum_of(const model_texel *texels)
{
    double sum = 0;
    for (int i = 0; i < MODEL_PIXELS; i++) sum += texels[i].luma;
    return sum;
}

void model_start(model *m, const nrd_reblur_settings *settings, uint32_t single, uint32_t half)
{
    memset(m, 0, sizeof *m);
    m->settings = *settings;
    m->single = single;
    m->half = half;
}

void model_frame(model *m, const double *noisy, uint32_t frame_index)
{
    static model_texel a[MODEL_PIXELS], b[MODEL_PIXELS];
    model_texel *const between[2] = { a, b };
    accumulate(m, noisy, frame_index, a);
    m->frames = fmin(fmin(m->frames, m->settings.max_accumulated_frames) + 1, 63.75);
    m->sum[MODEL_ACCUMULATION] = sum_of(a);
    blur(m, a, b, frame_index);
    m->sum[MODEL_BLUR] = sum_of(b);
    for (int pass = MODEL_POST_BLUR_1; pass <= MODEL_STABILIZATION; pass++) {
        model_texel *to = pass == MODEL_STABILIZATION ? m->out : between[pass & 1];
        atrous(m, (model_pass)pass, between[~pass & 1], to, frame_index);
        m->sum[pass] = sum_of(to);
    }
}
