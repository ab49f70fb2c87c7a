#include "stress/model.h"

#include <math.h>
#include <string.h>

/* ---- specular lobes: a neighbour counts as far as it sees the same reflection */
/* Surfaces as the rig has them; the passes keep 8 bits of their roughness. The light hits MODEL_HIT_DIST of the way that counts. */
/* Hit distance over itself and the distance to the camera; not that of the nearest of 3x3, which one stray sample may be. */
static double tracked(const nrd_reblur_settings *s, int i)
{
    double hit_dist = MODEL_HIT_DIST * model_hit_dist_scale(s->hit_distance_a, s->hit_distance_b, s->hit_distance_c, s->hit_distance_d, MODEL_ROUGHNESS), nearest = 2, second = 2;
    for (int k = 0; k < 9; k++) {
        int x = i % MODEL_SIZE + k % 3 - 1, y = i / MODEL_SIZE + k / 3 - 1;
        if (x < 0 || y < 0 || x >= MODEL_SIZE || y >= MODEL_SIZE) continue;
        double q = hit_dist / (hit_dist + model_camera_distance(y * MODEL_SIZE + x));
        second = fmin(second, fmax(nearest, q));
        nearest = fmin(nearest, q);
    }
    return second;
}

/* Pixels that a lobe sees; kept in 8 bits. */
static void track(const reblur_model *m, reblur_signal *s, uint32_t frame_index)
{
    const double alpha = 127.0 / 255 * 127 / 255;
    model_rounding r = model_rounding_of(m->passes, REBLUR_MODEL_ACCUMULATION);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double random = ((model_hash((uint32_t)i % MODEL_SIZE, (uint32_t)i / MODEL_SIZE, frame_index) >> 24) + 0.5) / 256;
        s->footprint[i] = alpha * model_camera_distance(i) * store_steps(r, reg(r, tracked(&m->settings, i)), 255, random) / MODEL_PIXEL_UNITS;
    }
}

static double lobe_weight(const reblur_signal *s, int i, int dx, int dy, int step)
{
    double wide = 2.4 * s->footprint[i] / step;
    return s->specular ? exp(-0.5 * (dx * dx + dy * dy) / fmax(wide * wide, 1e-4)) : 1;
}

/* ---- averages of texels: of directions as of luma times direction */
typedef struct mean { double v[MODEL_COMPONENTS], weight; } mean;

static double factor_of(const model_texel *t, int component) { return component < MODEL_LIGHT ? 1 : t->v[0]; }

static void add_texel(const reblur_model *m, model_rounding r, mean *sum, const model_texel *t, double w)
{
    for (int k = 0; k < m->components; k++) sum->v[k] = reg(r, sum->v[k] + w * factor_of(t, k) * t->v[k]);
    sum->weight = reg(r, sum->weight + w);
}

/* Back to directions relative to luma, none longer than that. */
static void finish_mean(const reblur_model *m, model_rounding r, const mean *sum, model_texel *to)
{
    double squared = 0;
    for (int k = 0; k < m->components; k++) to->v[k] = reg(r, sum->v[k] / (k < MODEL_LIGHT ? sum->weight : fmax(sum->v[0], 1e-30)));
    for (int k = MODEL_LIGHT; k < m->components; k++) squared += to->v[k] * to->v[k];
    for (int k = MODEL_LIGHT; k < m->components; k++) to->v[k] = sum->v[0] > 1e-7 ? reg(r, to->v[k] / fmax(sqrt(squared), 1)) : 0;
}

/* ---- what is stored between passes: halves; of directions, from blur to stabilization, 8 bits */
static double store_signed_byte(model_rounding r, double v) { return r.stored ? nearbyint(fmin(fmax(v, -1), 1) * 127) / 127 : v; }

static void store_texel(const reblur_model *m, model_rounding r, model_texel *t)
{
    for (int k = 0; k < m->components; k++) t->v[k] = k >= MODEL_LIGHT ? store_signed_byte(r, t->v[k]) : store_half(r, t->v[k]);
    t->sigma = store_half(r, t->sigma);
}

/* What averages over time is rounded at random; histories of directions are not. */
static void store_history(const reblur_model *m, model_rounding r, model_texel *t, uint32_t random, bool directions)
{
    for (int k = 0; k < m->components; k++) t->v[k] = k < MODEL_LIGHT || directions ? store_half_dithered(r, t->v[k], random) : store_half(r, t->v[k]);
    t->sigma = store_half_dithered(r, t->sigma, random);
}

/* ---- temporal accumulation: Welford's recurrence */
static void accumulate(const reblur_model *m, const reblur_signal *s, double (*noisy)[MODEL_PIXELS], uint32_t frame_index, model_texel *to)
{
    const model_rounding r = model_rounding_of(m->passes, REBLUR_MODEL_ACCUMULATION);
    double before = fmin(m->frames, m->settings.max_accumulated_frames), alpha = reg(r, 1 / (1 + before));
    for (uint32_t i = 0; i < MODEL_PIXELS; i++) {
        const model_texel *h = &s->history[i];
        double delta = reg(r, noisy[0][i] - h->v[0]);
        mean both = { { 0 }, 1 };
        for (int k = 0; k < m->components; k++) both.v[k] = reg(r, reg(r, h->v[k] * factor_of(h, k) * reg(r, 1 - alpha)) + reg(r, noisy[k][i] * alpha));
        finish_mean(m, r, &both, &to[i]);
        to[i].sigma = 0;
        if (before >= 0.5) {
            double variance = reg(r, delta * delta * before / (before + 1)), share = reg(r, 1 / fmax(before, 1));
            to[i].sigma = reg(r, sqrt(reg(r, h->sigma * h->sigma * (1 - share)) + reg(r, variance * share)));
        }
        store_history(m, r, &to[i], model_hash(i % MODEL_SIZE, i / MODEL_SIZE, frame_index) >> 8, true);
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
static void put_back(const reblur_model *m, model_rounding r, const model_texel *own, const model_texel *filtered, double sigma, uint32_t random, model_texel *history)
{
    double back = fmin(1, m->settings.feedback_frames / fmax(m->frames, 1));
    mean both = { { 0 }, 1 };
    for (int k = 0; k < m->components; k++) both.v[k] = reg(r, own->v[k] * factor_of(own, k) * (1 - back) + filtered->v[k] * factor_of(filtered, k) * back);
    finish_mean(m, r, &both, history);
    history->sigma = sigma;
    store_history(m, r, history, random, false);
}

static void blur_at(const reblur_model *m, reblur_signal *s, const model_texel *from, int i, model_texel *to, uint32_t frame_index)
{
    const model_rounding r = model_rounding_of(m->passes, REBLUR_MODEL_BLUR);
    double frames = fmax(m->frames, 1), moment = 0, variance = 0, noise = 0;
    mean sum = { { 0 }, 0 };
    for (int k = 0; k < 9; k++) {
        int dx = k % 3 - 1, dy = k / 3 - 1;
        const model_texel *t = texel_at(m, from, i % MODEL_SIZE + dx, i / MODEL_SIZE + dy);
        if (!t) continue;
        double w = reg(r, binomial(dx, dy) * lobe_weight(s, i, dx, dy, 1)) * frames, off = t->v[0] - from[i].v[0];
        add_texel(m, r, &sum, t, w);
        moment = reg(r, moment + w * reg(r, t->sigma * t->sigma + off * off));
        variance = reg(r, variance + w * t->sigma * t->sigma);
        noise = reg(r, noise + w * w / frames);
    }
    finish_mean(m, r, &sum, to);
    double off = reg(r, to->v[0] - from[i].v[0]), spread = reg(r, fmax(reg(r, moment / sum.weight) - reg(r, off * off), 0));
    uint32_t random = model_hash((uint32_t)(i % MODEL_SIZE), (uint32_t)(i / MODEL_SIZE), ~frame_index) >> 8;
    put_back(m, r, &from[i], to, reg(r, sqrt(variance / sum.weight)), random, &s->history[i]);
    to->sigma = reg(r, sqrt(spread * noise) / sum.weight);
    store_texel(m, r, to);
}

/* ---- sparse steps, which leave directions alone */
/* Of all signals, if one of them is noisy. */
static bool is_turned(const reblur_model *m, model_texel (*from)[MODEL_PIXELS], int i, uint32_t frame_index)
{
    bool noisy = false;
    for (uint32_t s = 0; s < m->signal_count; s++) noisy |= from[s][i].sigma > 0.4 * from[s][i].v[0];
    return noisy && (model_hash((uint32_t)(i % MODEL_SIZE), (uint32_t)(i / MODEL_SIZE), frame_index) & 1u) != 0;
}

static model_texel atrous_at(const reblur_model *m, const reblur_signal *s, model_rounding r, const model_texel *from, int i, int step, bool cross, bool turned)
{
    static const int axes[4][2] = { { 1, 0 }, { 0, 1 }, { -1, 0 }, { 0, -1 } }, diagonals[4][2] = { { 1, 1 }, { -1, 1 }, { -1, -1 }, { 1, -1 } };
    const model_texel *c = &from[i];
    double own = c->sigma * c->sigma, noise = 0, around = 1, least = 0.4 * own + 1e-12 * c->v[0] * c->v[0] + 1e-24;
    double squared_scale = m->settings.luminance_sigma_scale * m->settings.luminance_sigma_scale;
    mean sum = { { 0 }, 0 };
    model_texel to;
    for (int k = 0; k < (cross ? 4 : 9); k++) {
        const int *way = turned ? diagonals[k & 3] : axes[k & 3];
        int dx = cross ? way[0] : k % 3 - 1, dy = cross ? way[1] : k / 3 - 1;
        const model_texel *t = texel_at(m, from, i % MODEL_SIZE + dx * step, i / MODEL_SIZE + dy * step);
        if (!t || t == c) continue;
        double variance = reg(r, t->sigma * t->sigma), both = reg(r, own + variance + least), off = reg(r, c->v[0] - t->v[0]);
        double geometry = reg(r, (cross ? 0.75 : binomial(dx, dy)) * lobe_weight(s, i, dx, dy, step));
        double alike = reg(r, both / (both + 0.5 * 1.4142136 / squared_scale * off * off)), w = reg(r, geometry * alike * alike);
        add_texel(m, r, &sum, t, w);
        noise = reg(r, noise + w * w * variance);
        around = reg(r, around + geometry);
    }
    double kept = reg(r, around - sum.weight);   /* what luma keeps from the neighbours stays with the centre */
    add_texel(m, r, &sum, c, kept);
    noise = reg(r, noise + kept * kept * own);
    finish_mean(m, r, &sum, &to);
    for (int k = MODEL_LIGHT; k < m->components; k++) to.v[k] = c->v[k];
    to.sigma = reg(r, sqrt(noise) / sum.weight);
    return to;
}

/* Stores what it gives, but in the last pass. */
static void atrous(reblur_model *m, reblur_model_pass pass, model_texel (*from)[MODEL_PIXELS], model_texel (*to)[MODEL_PIXELS], uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, pass);
    bool cross = pass == REBLUR_MODEL_POST_BLUR_1, last = pass == REBLUR_MODEL_STABILIZATION;
    for (int i = 0; i < MODEL_PIXELS; i++) {
        bool turned = cross && is_turned(m, from, i, frame_index);
        for (uint32_t s = 0; s < m->signal_count; s++) {
            to[s][i] = atrous_at(m, &m->signals[s], r, from[s], i, 1 << (pass - REBLUR_MODEL_BLUR), cross, turned);
            if (!last) store_texel(m, r, &to[s][i]);
        }
    }
}

/* ---- stabilization: the luma goes towards the last frame's as far as the difference can be noise; directions leave with it */
static void stabilize(const reblur_model *m, reblur_signal *s, uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, REBLUR_MODEL_STABILIZATION);
    double frames = fmin(m->frames + 3, m->settings.max_stabilized_frames), share = reg(r, frames / (1 + frames));
    for (int i = 0; i < MODEL_PIXELS; i++) {
        model_texel *t = &s->out[i];
        double own = t->v[0], luma = own, slack = reg(r, m->settings.stabilization_sigma_scale * t->sigma * (1 + 1.5 / fmax(m->frames, 1)));
        double most = luma / fmax(1 - slack / fmax(luma, 1e-12), 0.5), allowed = fmin(fmax(s->stabilized[i], luma - 0.58 * slack), most);
        if (m->frames > 1) luma = reg(r, luma * (1 - share) + allowed * share);
        s->stabilized[i] = store_half_dithered(r, luma, model_hash((uint32_t)i % MODEL_SIZE, (uint32_t)i / MODEL_SIZE, frame_index) >> 8);
        for (int k = 0; k < m->components; k++) t->v[k] = store_half(r, reg(r, k < MODEL_LIGHT ? t->v[k] * (luma / fmax(own, 1e-12)) : t->v[k] * luma));
    }
}

static double sum_of(const model_texel *texels)
{
    double sum = 0;
    for (int i = 0; i < MODEL_PIXELS; i++) sum += texels[i].v[0];
    return sum;
}

/* ---- a model */
static void start(any_model *any, const model_kind *kind, const any_settings *settings, model_passes passes)
{
    reblur_model *m = &any->reblur;
    memset(m, 0, sizeof *m);
    m->settings = settings->REBLUR_DIFFUSE;   /* the same struct for all */
    m->passes = passes;
    m->components = kind->parts & MODEL_DIRECTIONS ? MODEL_COMPONENTS : MODEL_LIGHT;
    if (kind->parts & MODEL_DIFFUSE) m->signal_count++;
    if (kind->parts & MODEL_SPECULAR) m->signals[m->signal_count++].specular = true;
}

static void keep_sums(reblur_model *m, reblur_model_pass pass, model_texel (*texels)[MODEL_PIXELS])
{
    for (uint32_t s = 0; s < m->signal_count; s++) m->signals[s].sum[pass] = sum_of(texels[s]);
}

static void run_frame(any_model *any, double (*noisy)[MODEL_PIXELS], uint32_t frame_index)
{
    static model_texel a[MODEL_MOST_SIGNALS][MODEL_PIXELS], b[MODEL_MOST_SIGNALS][MODEL_PIXELS];
    model_texel (*const between[2])[MODEL_PIXELS] = { a, b };
    reblur_model *m = &any->reblur;
    for (uint32_t s = 0; s < m->signal_count; s++) {
        if (m->signals[s].specular) track(m, &m->signals[s], frame_index);
        accumulate(m, &m->signals[s], noisy + s * (uint32_t)m->components, frame_index, a[s]);
    }
    keep_sums(m, REBLUR_MODEL_ACCUMULATION, a);
    m->frames = fmin(fmin(m->frames, m->settings.max_accumulated_frames) + 1, 63.75);
    for (uint32_t s = 0; s < m->signal_count; s++)
        for (int i = 0; i < MODEL_PIXELS; i++) blur_at(m, &m->signals[s], a[s], i, &b[s][i], frame_index);
    keep_sums(m, REBLUR_MODEL_BLUR, b);
    for (int pass = REBLUR_MODEL_POST_BLUR_1; pass <= REBLUR_MODEL_STABILIZATION; pass++) {
        atrous(m, (reblur_model_pass)pass, between[~pass & 1], between[pass & 1], frame_index);
        keep_sums(m, (reblur_model_pass)pass, between[pass & 1]);
    }
    for (uint32_t s = 0; s < m->signal_count; s++) {
        memcpy(m->signals[s].out, a[s], sizeof a[s]);
        stabilize(m, &m->signals[s], frame_index);
        m->signals[s].sum[REBLUR_MODEL_STABILIZATION] = sum_of(m->signals[s].out);
    }
}

static double value(const any_model *any, uint32_t lane, uint32_t pixel)
{
    uint32_t components = (uint32_t)any->reblur.components;
    return any->reblur.signals[lane / components].out[pixel].v[lane % components];
}

#define SIGNAL(name, first, sh0) \
    { NRD_RESOURCE_IN_##name##sh0, NRD_RESOURCE_OUT_##name##sh0, 0, LANE_VALUE, first }, { NRD_RESOURCE_IN_##name##sh0, NRD_RESOURCE_OUT_##name##sh0, 1, LANE_PART, first }, \
    { NRD_RESOURCE_IN_##name##sh0, NRD_RESOURCE_OUT_##name##sh0, 2, LANE_PART, first }
#define RADIANCE(name, first) SIGNAL(name, first, _RADIANCE_HITDIST)
#define DIRECTION(name, first, k) { NRD_RESOURCE_IN_##name##_SH1, NRD_RESOURCE_OUT_##name##_SH1, k, LANE_DIRECTION, first }
#define SH(name, first) SIGNAL(name, first, _SH0), DIRECTION(name, first, 0), DIRECTION(name, first, 1), DIRECTION(name, first, 2)
#define MODEL_NAME(name, text) text,
#define KIND(name, parts, lane_count, ...) \
    { NRD_DENOISER_REBLUR_##name, parts, REBLUR_MODEL_PASS_COUNT, { REBLUR_MODEL_PASSES(MODEL_NAME) }, lane_count, { __VA_ARGS__ }, start, run_frame, value }
const model_kind reblur_model_kinds[REBLUR_MODEL_KINDS] = {
    KIND(DIFFUSE, MODEL_DIFFUSE, 3, RADIANCE(DIFF, 0)),
    KIND(SPECULAR, MODEL_SPECULAR, 3, RADIANCE(SPEC, 0)),
    KIND(DIFFUSE_SPECULAR, MODEL_DIFFUSE | MODEL_SPECULAR, 6, RADIANCE(DIFF, 0), RADIANCE(SPEC, 3)),
    KIND(DIFFUSE_SH, MODEL_DIFFUSE | MODEL_DIRECTIONS, 6, SH(DIFF, 0)),
    KIND(SPECULAR_SH, MODEL_SPECULAR | MODEL_DIRECTIONS, 6, SH(SPEC, 0)),
    KIND(DIFFUSE_SPECULAR_SH, MODEL_DIFFUSE | MODEL_SPECULAR | MODEL_DIRECTIONS, 12, SH(DIFF, 0), SH(SPEC, 6)),
};
