/* REBLUR of occlusion, diffuse, specular or both, or with moments: averages over time of means of few pixels, which no filter touches, and a
   disc of six taps. */
#include "stress/model.h"

#include <math.h>
#include <string.h>

enum { ACCUMULATION, BLUR, PASSES, TAPS = 6 };

#define LEAST_RADIUS (1.0 / 64)
#define MEAN_STEPS 4080.0

static double random_of(int i, uint32_t frame_index) { return ((model_hash((uint32_t)i % MODEL_SIZE, (uint32_t)i / MODEL_SIZE, frame_index) >> 24) + 0.5) / 256; }
static bool is_inside(int x, int y) { return x >= 0 && y >= 0 && x < MODEL_SIZE && y < MODEL_SIZE; }

/* ---- words */
static double store_radius(model_rounding r, double radius, double random)
{
    double code = 63 + 10.5 * log2(fmin(fmax(radius, LEAST_RADIUS), 1)) + random;
    return r.stored ? exp2((floor(fmin(fmax(code, 0), 63)) - 63) / 10.5) : fmin(fmax(radius, LEAST_RADIUS), 1);
}

/* Three fields of 10 bits, with randoms that are turned against each other. */
static double store_moment(model_rounding r, double v, int component, double random)
{
    static const double turns[MODEL_OPENNESS] = { 0, 0, 0.618, 0.236 };
    double part = random + turns[component];
    return r.stored ? floor(fmin(fmax(v, -1), 1) * 511 + 511 + part - floor(part)) / 511 - 1 : v;
}

static double store_openness(model_rounding r, double v, int component, double steps, double random)
{
    return component < MODEL_MOMENT ? store_steps(r, v, steps, random) : store_moment(r, v, component, random);
}

/* What taps read of a mean: its upper 8 bits. */
static double as_tap(model_rounding r, double mean) { return r.stored ? floor((mean * MEAN_STEPS + 8.5) / 16) / 255 : mean; }

/* ---- the disc */
/* Units: as wide as near occluders allow, at least `least`; of a specular lobe within what it smears. */
static double reach_of(const occlusion_model *m, const occlusion_lobe *l, double radius, double least, int i)
{
    double hit_dist = radius * model_hit_dist_scale(m->settings.hit_distance_a, m->settings.hit_distance_b, m->settings.hit_distance_c, m->settings.hit_distance_d, l->specular ? MODEL_ROUGHNESS : 1);
    double wide = fmax(0.17 * hit_dist, least), smeared = MODEL_ROUGHNESS * MODEL_ROUGHNESS * hit_dist / (1 + hit_dist / model_camera_distance(i));
    return l->specular ? fmin(wide, 3 * smeared) : wide;
}

/* ---- accumulation */
typedef struct around_sums {
    double number, reciprocals;
    double own[MODEL_OPENNESS], all[MODEL_OPENNESS];   /* of the own quad and the pixel once more; of these and the quads beside */
    double own_number;
} around_sums;

static void add_quad(model_rounding r, around_sums *s, double (*in)[MODEL_PIXELS], int components, int left, int top)
{
    for (int k = 0; k < 4; k++) {
        int x = left + (k & 1), y = top + (k >> 1), i = y * MODEL_SIZE + x;
        if (!is_inside(x, y)) continue;
        s->number++;
        s->reciprocals = reg(r, s->reciprocals + 1 / fmax(in[0][i], LEAST_RADIUS));
        for (int c = 0; c < components; c++) s->all[c] = reg(r, s->all[c] + in[c][i]);
    }
}

/* Beside a specular lobe the quads at the corners count, too. */
static around_sums look_around(const occlusion_model *m, model_rounding r, double (*in)[MODEL_PIXELS], int i)
{
    static const int quads[9][2] = { { 0, 0 }, { 2, 0 }, { 0, 2 }, { -2, 0 }, { 0, -2 }, { 2, 2 }, { -2, 2 }, { -2, -2 }, { 2, -2 } };
    int components = m->components, count = m->lobes[m->lobe_count - 1].specular ? 9 : 5;
    around_sums s = { .number = 1, .reciprocals = 1 / fmax(in[0][i], LEAST_RADIUS) };
    for (int c = 0; c < components; c++) s.all[c] = in[c][i];
    for (int q = 0; q < count; q++) {
        add_quad(r, &s, in, components, i % MODEL_SIZE / 2 * 2 + quads[q][0], i / MODEL_SIZE / 2 * 2 + quads[q][1]);
        if (q > 0) continue;
        memcpy(s.own, s.all, sizeof s.own);
        s.own_number = s.number;
    }
    return s;
}

static double share(double reach, double from, double to) { return fmin(fmax((reach - from) / (to - from), 0), 1); }

/* A sample, mixed with those of its quad from 0.7 to 1.5 px of the disc on, with those around from 3 to 6. */
static double mean_of(model_rounding r, const around_sums *s, int component, double own, double reach)
{
    double of_around = share(reach, 3, 6), number = s->own_number + (s->number - s->own_number) * of_around;
    double mean = reg(r, reg(r, s->own[component] + (s->all[component] - s->own[component]) * of_around) / number);
    return reg(r, own + (mean - own) * share(reach, 0.7, 1.5));
}

/* in: hit distances, then moments. */
static void accumulate(const occlusion_model *m, occlusion_lobe *l, double (*in)[MODEL_PIXELS], uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, ACCUMULATION);
    double before = fmin(m->frames, m->settings.max_accumulated_frames), alpha = reg(r, 1 / (1 + before)), rest = reg(r, 1 - alpha);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double random = random_of(i, frame_index);
        around_sums around = look_around(m, r, in, i);
        double radius = reg(r, l->radius[i] * rest + reg(r, around.number / around.reciprocals) * alpha);
        double px = MODEL_DEPTH / model_camera_distance(i) / MODEL_PIXEL_UNITS, reach = reg(r, fmin(reach_of(m, l, radius, 0, i) * px, m->settings.max_blur_radius) * (l->specular ? 0.25 : 1));
        for (int k = 0; k < m->components; k++)
            l->history[k][i] = store_openness(r, reg(r, l->history[k][i] * rest + mean_of(r, &around, k, in[k][i], reach) * alpha), k, MEAN_STEPS, random);
        l->radius[i] = store_radius(r, radius, random);
    }
}

/* ---- the blur */
/* Offsets of the taps in px, for a radius of 1. The axes in the plane are up and left. */
static const double disc[TAPS][2] = { { 0.2887, 0.0000 }, { -0.3687, 0.3378 }, { 0.0564, -0.6430 }, { 0.4647, 0.6061 }, { -0.8528, -0.1508 }, { 0.8078, -0.5139 } };

/* Pixels: wider while history is short. */
static double radius_of(const occlusion_model *m, const occlusion_lobe *l, model_rounding r, int i)
{
    return reg(r, fmin(reach_of(m, l, l->radius[i], 5.7 * MODEL_PIXEL_UNITS / sqrt(fmax(m->frames, 1)), i) / MODEL_PIXEL_UNITS, m->settings.max_blur_radius));
}

/* A specular tap's roughness has 4 bits, its centre's all. */
static double alike(const occlusion_lobe *l)
{
    return l->specular ? 1 - fabs(floor(MODEL_ROUGHNESS * 15 + 0.5) / 15 - MODEL_ROUGHNESS) / (0.1 + 0.3 * MODEL_ROUGHNESS) : 1;
}

/* taps: what the centre's neighbours hold. */
static void blur_at(const occlusion_model *m, const occlusion_lobe *l, model_rounding r, int i, double (*taps)[MODEL_PIXELS], double to[MODEL_OPENNESS])
{
    double sum[MODEL_OPENNESS], weight = 1, radius = radius_of(m, l, r, i);
    for (int c = 0; c < m->components; c++) sum[c] = to[c] = l->history[c][i];
    if (l->specular && radius < 0.5) return;
    for (int k = 0; k < TAPS; k++) {
        int x = i % MODEL_SIZE - (int)nearbyint(radius * disc[k][1]), y = i / MODEL_SIZE + (int)nearbyint(radius * disc[k][0]);
        if (!is_inside(x, y)) continue;
        for (int c = 0; c < m->components; c++) sum[c] = reg(r, sum[c] + alike(l) * taps[c][y * MODEL_SIZE + x]);
        weight = reg(r, weight + alike(l));
    }
    for (int c = 0; c < m->components; c++) to[c] = reg(r, sum[c] / weight);
}

static void find_taps(const occlusion_model *m, double (*own)[MODEL_PIXELS], double (*taps)[MODEL_PIXELS])
{
    model_rounding before = model_rounding_of(m->passes, ACCUMULATION);
    for (int c = 0; c < m->components; c++)
        for (int i = 0; i < MODEL_PIXELS; i++) taps[c][i] = c < MODEL_MOMENT ? as_tap(before, own[c][i]) : own[c][i];
}

static void blur(const occlusion_model *m, occlusion_lobe *l)
{
    static double taps[MODEL_OPENNESS][MODEL_PIXELS];
    model_rounding r = model_rounding_of(m->passes, BLUR);
    find_taps(m, l->history, taps);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double v[MODEL_OPENNESS];
        blur_at(m, l, r, i, taps, v);
        double length = m->components > MODEL_MOMENT ? sqrt(v[1] * v[1] + v[2] * v[2] + v[3] * v[3]) : 0, most = fmin(1, v[0] / fmax(length, 1e-6));
        for (int c = 0; c < m->components; c++) l->out[c][i] = store_half(r, c < MODEL_MOMENT ? v[c] : reg(r, v[c] * most));
    }
}

/* ---- a model */
static void start(any_model *any, const model_kind *kind, const any_settings *settings, model_passes passes)
{
    occlusion_model *m = &any->occlusion;
    memset(m, 0, sizeof *m);
    m->settings = settings->REBLUR_DIFFUSE_OCCLUSION;   /* the same struct for all */
    m->passes = passes;
    m->components = kind->parts & MODEL_DIRECTIONS ? MODEL_OPENNESS : MODEL_MOMENT;
    if (kind->parts & MODEL_DIFFUSE) m->lobe_count++;
    if (kind->parts & MODEL_SPECULAR) m->lobes[m->lobe_count++].specular = true;
}

static void run_frame(any_model *any, double (*in)[MODEL_PIXELS], uint32_t frame_index)
{
    occlusion_model *m = &any->occlusion;
    for (uint32_t k = 0; k < m->lobe_count; k++) accumulate(m, &m->lobes[k], in + k * (uint32_t)m->components, frame_index);
    m->frames = fmin(fmin(m->frames, m->settings.max_accumulated_frames) + 1, 63);
    for (uint32_t k = 0; k < m->lobe_count; k++) blur(m, &m->lobes[k]);
}

static double value(const any_model *any, uint32_t lane, uint32_t pixel)
{
    uint32_t components = (uint32_t)any->occlusion.components;
    return any->occlusion.lobes[lane / components].out[lane % components][pixel];
}

#define LANE(name, lane) { NRD_RESOURCE_IN_##name##_HITDIST, NRD_RESOURCE_OUT_##name##_HITDIST, 0, LANE_VALUE, lane }
#define MOMENT(k, role) { NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, NRD_RESOURCE_OUT_DIFF_DIRECTION_HITDIST, k, role, 0 }
#define KIND(name, parts, lane_count, ...) { NRD_DENOISER_REBLUR_##name##_OCCLUSION, parts, PASSES, { "accumulation", "blur" }, lane_count, { __VA_ARGS__ }, start, run_frame, value }
const model_kind occlusion_model_kinds[OCCLUSION_MODEL_KINDS] = {
    KIND(DIFFUSE, MODEL_DIFFUSE, 1, LANE(DIFF, 0)),
    KIND(SPECULAR, MODEL_SPECULAR, 1, LANE(SPEC, 0)),
    KIND(DIFFUSE_SPECULAR, MODEL_DIFFUSE | MODEL_SPECULAR, 2, LANE(DIFF, 0), LANE(SPEC, 1)),
    KIND(DIFFUSE_DIRECTIONAL, MODEL_DIFFUSE | MODEL_DIRECTIONS, 4, MOMENT(3, LANE_VALUE), MOMENT(0, LANE_DIRECTION), MOMENT(1, LANE_DIRECTION), MOMENT(2, LANE_DIRECTION)),
};
