/* SIGMA under a light that stands over the wall: where a penumbra is, means of rays over time, and a blur; of one number, or of colours. */
#include "stress/model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ACCUMULATION, BLUR, PASSES, REACH = 4, FAR_TAPS = 5 };

#define WIDEST 256.0      /* px that a word holds */
#define FALLOFF 1.5       /* exponent of weights at the radius */
#define MOST_AGE 56.25
#define SAME 0.02         /* difference of rays that is none */
#define EXACT_FRAMES 6.0  /* of what was no penumbra, where wide ones are */

static double clamp(double v, double low, double high) { return fmin(fmax(v, low), high); }
static double smoothstep(double low, double high, double v) { v = clamp((v - low) / (high - low), 0, 1); return v * v * (3 - 2 * v); }
static double mix(double a, double b, double share) { return a * (1 - share) + b * share; }
static double random_of(int i, uint32_t salt, uint32_t frame_index)
{
    return (model_hash((uint32_t)i % MODEL_SIZE + salt * 0x632be5abu, (uint32_t)i / MODEL_SIZE, frame_index) >> 8) / 16777216.0;
}

/* Of a neighbour; -1: outside of the picture. */
static int pixel_at(int i, int dx, int dy)
{
    int x = i % MODEL_SIZE + dx, y = i / MODEL_SIZE + dy;
    return x >= 0 && y >= 0 && x < MODEL_SIZE && y < MODEL_SIZE ? y * MODEL_SIZE + x : -1;
}

/* 5x5 pixels and a ring of 8, without the pixel itself. */
static bool is_looked_at(int dx, int dy)
{
    int x = abs(dx), y = abs(dy);
    return (x || y) && ((x <= 2 && y <= 2) || (x == 4 && y == 0) || (x == 0 && y == 4) || (x == 3 && y == 3));
}

/* ---- visibility */
static double luma_of(const shadow_model *m, const double v[MODEL_COLORS]) { return m->colors == 1 ? v[0] : v[1] * 0.5 + (v[0] + v[2]) * 0.25; }

/* What the rays of a frame tell: half widths, and of blocked ones colours. */
typedef double (*rays)[MODEL_PIXELS];
static double ray_visibility(const shadow_model *m, rays in, int i, int color) { return in[0][i] == MODEL_LIT ? 1 : m->colors == 1 ? 0 : in[1 + color][i]; }

static bool differ(const shadow_model *m, rays in, int a, int b)
{
    bool any = false;
    for (int c = 0; c < m->colors; c++) any |= fabs(ray_visibility(m, in, a, c) - ray_visibility(m, in, b, c)) > SAME;
    return any;
}

/* ---- words */
static double store_width(model_rounding r, double px)
{
    const double steps = 254.0 / 12;
    return r.stored ? exp2((floor(clamp((log2(px) + 4) * steps + 1.5, 1, 255)) - 1) / steps - 4) : fmin(px, WIDEST);
}

static double store_age(model_rounding r, double frames, double random)
{
    double code = fmin(r.stored ? floor(2 * sqrt(frames) + random) : 2 * sqrt(frames), 15);
    return 0.25 * code * code;
}

/* Of those that a pixel has been in penumbrae for, how many frames count. */
static double history_length(const shadow_model *m, double age, double width)
{
    double most = fmax(smoothstep(0.3, 1, width) * 2 * width, smoothstep(0.25, 0.5, width) * 0.125 * age);
    return fmin(fmin(age, most), m->settings.max_accumulated_frames);
}

static double frames_in_mean(const shadow_model *m, const shadow_word *w) { return 1 + history_length(m, fmax(w->age - 1, 0), w->width); }

/* ---- accumulation */
/* Half width of the penumbra at a pixel; 0: outside of one. */
static double find_width(const shadow_model *m, model_rounding r, rays in, int i)
{
    const double *width = in[0];
    bool lit = width[i] == MODEL_LIT, supported = false;
    double count = lit ? 0 : 1, sum = lit ? 0 : reg(r, 1 / (width[i] + 1));
    for (int dy = -REACH; dy <= REACH; dy++)
        for (int dx = -REACH; dx <= REACH; dx++) {
            int at = pixel_at(i, dx, dy);
            if (at < 0 || !is_looked_at(dx, dy)) continue;
            double squared = dx * dx + dy * dy, narrowness = reg(r, 1 / (width[at] + 1));
            bool reaches = width[at] != MODEL_LIT && narrowness <= reg(r, 1 / fmax(0.5 * sqrt(squared) - 0.25 + 1, 1));
            if (reaches) count++, sum = reg(r, sum + narrowness);
            supported |= differ(m, in, i, at) && (reaches || (!lit && squared <= (width[i] + 0.5) * (width[i] + 0.5)));
        }
    return supported ? reg(r, count / sum - 1) : 0;
}

typedef struct gathered { double mean[MODEL_COLORS], count; } gathered;

static gathered gather_mean(const shadow_model *m, model_rounding r, rays in, int i, double width)
{
    double k = fmax(0.6 * width, 0.7), weight = 1, squares = 1;
    gathered g;
    for (int c = 0; c < m->colors; c++) g.mean[c] = ray_visibility(m, in, i, c);
    for (int dy = -REACH; dy <= REACH; dy++)
        for (int dx = -REACH; dx <= REACH; dx++) {
            int at = pixel_at(i, dx, dy);
            if (at < 0 || !is_looked_at(dx, dy)) continue;
            double w = reg(r, exp(-1.5 * (dx * dx + dy * dy) / (k * k)) * clamp(in[0][at] / width, 0, 1));
            for (int c = 0; c < m->colors; c++) g.mean[c] = reg(r, g.mean[c] + w * ray_visibility(m, in, at, c));
            weight = reg(r, weight + w);
            squares = reg(r, squares + w * w);
        }
    for (int c = 0; c < m->colors; c++) g.mean[c] = reg(r, g.mean[c] / weight);
    g.count = reg(r, weight * weight / squares);
    return g;
}

static double ray_variance(double a, double b) { return fmax(a * (1 - a), b * (1 - b)) + 0.09; }

/* Part of history that is worth keeping, by how far the rays around contradict it. */
static double trust_in(const shadow_model *m, const shadow_word *history, const gathered *around, double frames)
{
    double variances[MODEL_COLORS], off = luma_of(m, history->mean) - luma_of(m, around->mean);
    for (int c = 0; c < m->colors; c++) variances[c] = ray_variance(around->mean[c], history->mean[c]);
    double variance = luma_of(m, variances), bias = fmax(off * off - (4 + 32 / around->count) * variance / around->count, 0);
    return 1 / (1 + frames * bias / variance);
}

static shadow_word fetch_history(const shadow_model *m, int i, double width)
{
    const shadow_word none = { { 0 }, 0, 0, false, 0 };
    shadow_word h = m->history[i];
    double weight = fmin((h.age > 0 ? WIDEST : h.width) / width, 1), exact = h.placed ? EXACT_FRAMES * smoothstep(1, 2, width) : 0;
    if (!m->started || !(weight > 0.01)) return none;
    if (!(h.age > 0)) h.stabilized = luma_of(m, h.mean);
    h.age = fmax(h.age, exact);
    return h;
}

static shadow_word accumulate_at(const shadow_model *m, rays in, int i, uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, ACCUMULATION);
    double width = find_width(m, r, in, i);
    shadow_word word = { { 0 }, 0, store_width(r, in[0][i]), true, 0 };
    for (int c = 0; c < m->colors; c++) word.mean[c] = ray_visibility(m, in, i, c);
    if (!(width > 0)) return word;
    gathered around = gather_mean(m, r, in, i, width);
    shadow_word h = fetch_history(m, i, width);
    double frames = history_length(m, h.age, width), trust = reg(r, trust_in(m, &h, &around, frames));
    for (int c = 0; c < m->colors; c++) {
        double slack = reg(r, 2 * sqrt(ray_variance(around.mean[c], h.mean[c]) / around.count)), kept = clamp(h.mean[c], around.mean[c] - slack, around.mean[c] + slack);
        word.mean[c] = store_steps(r, reg(r, mix(kept, word.mean[c], 1 / (1 + frames * trust))), 255, random_of(i, 0, frame_index));
    }
    double age = reg(r, mix(frames * trust, h.age, trust * trust * trust * trust) + 1);
    word.age = fmin(store_age(r, age, random_of(i, 3, frame_index)), MOST_AGE);
    word.width = store_width(r, width);
    word.stabilized = store_steps(r, h.stabilized, 255, 0.5);
    return word;
}

/* ---- blur */
typedef struct sums { double mean[MODEL_COLORS], weight, squares; } sums;

static void add_tap(const shadow_model *m, model_rounding r, const shadow_word *words, int i, int dx, int dy, double radius, sums *s)
{
    int at = pixel_at(i, dx, dy);
    if (at < 0) return;
    double w = reg(r, fmin(words[at].width / words[i].width, 1) * exp(-FALLOFF * (dx * dx + dy * dy) / (radius * radius)));
    for (int c = 0; c < m->colors; c++) s->mean[c] = reg(r, s->mean[c] + w * words[at].mean[c]);
    s->weight = reg(r, s->weight + w);
    s->squares = reg(r, s->squares + w * w);
}

/* On a disc that turns from frame to frame, within a part of the picture. */
static void add_far(const shadow_model *m, model_rounding r, const shadow_word *words, int i, double radius, uint32_t frame_index, sums *s)
{
    double reach = 0.045 * MODEL_SIZE, scale = 1 / sqrt(1 / (radius * radius) + 1 / (reach * reach)), angle = random_of(0, 1, frame_index) * 6.2831853;
    double x = cos(angle), y = sin(angle);
    for (int k = 0; k < FAR_TAPS; k++) {
        double far = scale * sqrt((k + 0.5) / FAR_TAPS), turned = x * -0.73736887 - y * 0.67549029;
        add_tap(m, r, words, i, (int)nearbyint(far * x), (int)nearbyint(far * y), radius, s);
        y = x * 0.67549029 + y * -0.73736887;
        x = turned;
    }
}

/* Returns the deviation of its luma. */
static double filter(const shadow_model *m, model_rounding r, const shadow_word *words, int i, uint32_t frame_index, double shown[MODEL_COLORS])
{
    double frames = frames_in_mean(m, &words[i]), scaled = m->settings.penumbra_blur_scale * words[i].width, radius = reg(r, fmax(scaled / sqrt(sqrt(frames)), 1e-3));
    sums s = { { words[i].mean[0], words[i].mean[1], words[i].mean[2] }, 1, 1 };
    for (int k = 0; k < 9; k++)
        if (k != 4) add_tap(m, r, words, i, k % 3 - 1, k / 3 - 1, radius, &s);
    add_far(m, r, words, i, radius, frame_index, &s);
    for (int c = 0; c < m->colors; c++) s.mean[c] = reg(r, s.mean[c] / s.weight);
    for (int c = 0; c < m->colors; c++) shown[c] = reg(r, mix(words[i].mean[c], s.mean[c], smoothstep(0.1, 0.35, scaled / 0.6)));
    double luma = luma_of(m, s.mean);
    return reg(r, sqrt((luma * (1 - luma) + 0.02) * s.squares / (s.weight * s.weight) / frames));
}

static void stabilize(const shadow_model *m, model_rounding r, const shadow_word *word, double deviation, double shown[MODEL_COLORS])
{
    double frames = fmin(frames_in_mean(m, word) - 1, m->settings.max_stabilized_frames), luma = luma_of(m, shown);
    if (!(frames > 0)) return;
    double stable = reg(r, mix(luma, clamp(word->stabilized, luma - 2 * deviation, luma + 2 * deviation), frames / (1 + frames)));
    for (int c = 0; c < m->colors; c++) shown[c] = luma > 0 ? reg(r, fmin(shown[c] * (stable / luma), 1)) : stable;
}

static void blur(shadow_model *m, const shadow_word *words, uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, BLUR);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double shown[MODEL_COLORS] = { words[i].mean[0], words[i].mean[1], words[i].mean[2] };
        if (words[i].age > 0) stabilize(m, r, &words[i], filter(m, r, words, i, frame_index, shown), shown);
        m->history[i] = words[i];
        m->history[i].stabilized = store_steps(r, luma_of(m, shown), 255, random_of(i, 2, frame_index));
        for (int c = 0; c < m->colors; c++) {
            double root = store_steps(r, sqrt(clamp(shown[c], 0, 1)), 255, 0.5);
            m->out[c][i] = root * root;
        }
    }
}

/* ---- tiles */
/* Without rays of both kinds, or coloured ones, within 4 px of a tile its history is one word: no depth, a ray of any width. */
static void forget_tile(shadow_model *m, rays in, int left, int top)
{
    bool lit = false, blocked = false, colored = false;
    for (int y = top - 4; y < top + 12; y++)
        for (int x = left - 4; x < left + 12; x++) {
            if (x < 0 || y < 0 || x >= MODEL_SIZE || y >= MODEL_SIZE) continue;
            bool is_lit = in[0][y * MODEL_SIZE + x] == MODEL_LIT;
            lit |= is_lit;
            blocked |= !is_lit;
            for (int c = 0; c < m->colors; c++) colored |= !is_lit && ray_visibility(m, in, y * MODEL_SIZE + x, c) > 0;
        }
    for (int i = 0; i < 64 && !(lit && blocked) && !colored; i++) m->history[(top + i / 8) * MODEL_SIZE + left + i % 8] = (shadow_word){ { lit, lit, lit }, 0, WIDEST, false, 0 };
}

/* ---- a model */
static void start(any_model *any, const model_kind *kind, const any_settings *settings, model_passes passes)
{
    memset(&any->shadow, 0, sizeof any->shadow);
    any->shadow.settings = settings->SIGMA_SHADOW;   /* the same struct for both */
    any->shadow.passes = passes;
    any->shadow.colors = kind->parts & MODEL_COLORED ? MODEL_COLORS : 1;
}

static void run_frame(any_model *any, rays in, uint32_t frame_index)
{
    shadow_word words[MODEL_PIXELS];
    for (int i = 0; i < MODEL_PIXELS; i++) words[i] = accumulate_at(&any->shadow, in, i, frame_index);
    blur(&any->shadow, words, frame_index);
    for (int tile = 0; tile < MODEL_PIXELS / 64; tile++) forget_tile(&any->shadow, in, tile % (MODEL_SIZE / 8) * 8, tile / (MODEL_SIZE / 8) * 8);
    any->shadow.started = true;
}

static double value(const any_model *any, uint32_t lane, uint32_t pixel) { return any->shadow.out[any->shadow.colors == 1 ? lane : lane - 1][pixel]; }

#define COLOR(k) { NRD_RESOURCE_IN_TRANSLUCENCY, NRD_RESOURCE_OUT_SHADOW_TRANSLUCENCY, k, LANE_COLOR, 0 }
#define KIND(name, parts, lane_count, ...) { NRD_DENOISER_SIGMA_SHADOW##name, parts, PASSES, { "accumulation", "blur" }, lane_count, { __VA_ARGS__ }, start, run_frame, value }
const model_kind shadow_model_kinds[SHADOW_MODEL_KINDS] = {
    KIND(, 0, 1, { NRD_RESOURCE_IN_PENUMBRA, NRD_RESOURCE_OUT_SHADOW, 0, LANE_VALUE, 0 }),
    KIND(_TRANSLUCENCY, MODEL_COLORED, 4, { NRD_RESOURCE_IN_PENUMBRA, NRD_RESOURCE_COUNT, 0, LANE_VALUE, 0 }, COLOR(0), COLOR(1), COLOR(2)),
};
