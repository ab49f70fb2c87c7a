/* REBLUR of occlusion, diffuse, specular or both, or with moments: averages over time that no filter touches, and two discs of eight taps. */
#include "stress/model.h"

#include <math.h>
#include <string.h>

enum { ACCUMULATION, BLUR, POST_BLUR, PASSES, TAPS = 8 };

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

/* The blur hands on as many steps as the word has left: beside a specular lobe a diffuse one has 8 bits, alone 10. */
static double steps_between(const occlusion_model *m, const occlusion_lobe *l) { return l->specular ? MEAN_STEPS : m->lobe_count > 1 ? 255 : 1023; }

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

/* in: hit distances, then moments. */
static void accumulate(const occlusion_model *m, occlusion_lobe *l, double (*in)[MODEL_PIXELS], uint32_t frame_index)
{
    model_rounding r = model_rounding_of(m->passes, ACCUMULATION);
    double before = fmin(m->frames, m->settings.max_accumulated_frames), alpha = reg(r, 1 / (1 + before)), rest = reg(r, 1 - alpha);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        double random = random_of(i, frame_index);
        for (int k = 0; k < m->components; k++)
            l->history[k][i] = store_openness(r, reg(r, l->history[k][i] * rest + in[k][i] * alpha), k, MEAN_STEPS, random);
        l->radius[i] = store_radius(r, reg(r, l->radius[i] * rest + harmonic_mean(r, in[0], i) * alpha), random);
    }
}

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

/* Pixels: as wide as near occluders allow, wider while history is short; of a specular lobe within what it smears. */
static double radius_of(const occlusion_model *m, const occlusion_lobe *l, model_rounding r, int i)
{
    const double alpha = MODEL_ROUGHNESS * MODEL_ROUGHNESS;
    double hit_dist = l->radius[i] * model_hit_dist_scale(m->settings.hit_distance_a, m->settings.hit_distance_b, m->settings.hit_distance_c, m->settings.hit_distance_d, l->specular ? MODEL_ROUGHNESS : 1);
    double wide = fmax(0.17 * hit_dist / MODEL_PIXEL_UNITS, 5.7 / sqrt(fmax(m->frames, 1)));
    double smeared = alpha * hit_dist / (1 + hit_dist / model_camera_distance(i)) / MODEL_PIXEL_UNITS;
    return reg(r, fmin(l->specular ? fmin(wide, 3 * smeared) : wide, m->settings.max_blur_radius));
}

/* A specular tap's roughness has 4 bits, its centre's all. */
static double alike(const occlusion_lobe *l)
{
    return l->specular ? 1 - fabs(floor(MODEL_ROUGHNESS * 15 + 0.5) / 15 - MODEL_ROUGHNESS) / (0.1 + 0.3 * MODEL_ROUGHNESS) : 1;
}

/* own, taps: what the centre and its neighbours hold. */
static void blur_at(const occlusion_model *m, const occlusion_lobe *l, model_rounding r, int i, double (*own)[MODEL_PIXELS], double (*taps)[MODEL_PIXELS], double offsets[TAPS][2], double radius, double to[MODEL_OPENNESS])
{
    double sum[MODEL_OPENNESS], weight = 1;
    for (int c = 0; c < m->components; c++) sum[c] = to[c] = own[c][i];
    if (l->specular && radius < 0.5) return;
    for (int k = 0; k < TAPS; k++) {
        int x = i % MODEL_SIZE + (int)nearbyint(radius * offsets[k][0]), y = i / MODEL_SIZE + (int)nearbyint(radius * offsets[k][1]);
        if (!is_inside(x, y)) continue;
        double w = reg(r, alike(l) * exp2(-0.05 * (k + 0.5)));
        for (int c = 0; c < m->components; c++) sum[c] = reg(r, sum[c] + w * taps[c][y * MODEL_SIZE + x]);
        weight = reg(r, weight + w);
    }
    for (int c = 0; c < m->components; c++) to[c] = reg(r, sum[c] / weight);
}

static void find_taps(const occlusion_model *m, model_rounding before, double (*own)[MODEL_PIXELS], double (*taps)[MODEL_PIXELS])
{
    for (int c = 0; c < m->components; c++)
        for (int i = 0; i < MODEL_PIXELS; i++) taps[c][i] = c < MODEL_MOMENT ? as_tap(before, own[c][i]) : own[c][i];
}

static void blur(const occlusion_model *m, occlusion_lobe *l, double (*to)[MODEL_PIXELS], uint32_t frame_index)
{
    static double taps[MODEL_OPENNESS][MODEL_PIXELS];
    model_rounding r = model_rounding_of(m->passes, BLUR);
    double offsets[TAPS][2], v[MODEL_OPENNESS];
    place_taps(BLUR, offsets);
    find_taps(m, model_rounding_of(m->passes, ACCUMULATION), l->history, taps);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        blur_at(m, l, r, i, l->history, taps, offsets, radius_of(m, l, r, i), v);
        for (int c = 0; c < m->components; c++) to[c][i] = store_openness(r, v[c], c, steps_between(m, l), random_of(i, ~frame_index));
    }
}

static void post_blur(const occlusion_model *m, occlusion_lobe *l, double (*from)[MODEL_PIXELS])
{
    static double taps[MODEL_OPENNESS][MODEL_PIXELS];
    model_rounding r = model_rounding_of(m->passes, POST_BLUR), before = model_rounding_of(m->passes, BLUR);
    double offsets[TAPS][2], v[MODEL_OPENNESS];
    before.stored &= l->specular;   /* taps of others read all that there is */
    place_taps(POST_BLUR, offsets);
    find_taps(m, before, from, taps);
    for (int i = 0; i < MODEL_PIXELS; i++) {
        blur_at(m, l, r, i, from, taps, offsets, 0.5 * radius_of(m, l, r, i), v);
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
    static double between[MODEL_MOST_SIGNALS][MODEL_OPENNESS][MODEL_PIXELS];
    occlusion_model *m = &any->occlusion;
    for (uint32_t k = 0; k < m->lobe_count; k++) accumulate(m, &m->lobes[k], in + k * (uint32_t)m->components, frame_index);
    m->frames = fmin(fmin(m->frames, m->settings.max_accumulated_frames) + 1, 63);
    for (uint32_t k = 0; k < m->lobe_count; k++) {
        blur(m, &m->lobes[k], between[k], frame_index);
        post_blur(m, &m->lobes[k], between[k]);
    }
}

static double value(const any_model *any, uint32_t lane, uint32_t pixel)
{
    uint32_t components = (uint32_t)any->occlusion.components;
    return any->occlusion.lobes[lane / components].out[lane % components][pixel];
}

#define LANE(name, lane) { NRD_RESOURCE_IN_##name##_HITDIST, NRD_RESOURCE_OUT_##name##_HITDIST, 0, LANE_VALUE, lane }
#define MOMENT(k, role) { NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, NRD_RESOURCE_OUT_DIFF_DIRECTION_HITDIST, k, role, 0 }
#define KIND(name, parts, lane_count, ...) { NRD_DENOISER_REBLUR_##name##_OCCLUSION, parts, PASSES, { "accumulation", "blur", "post-blur" }, lane_count, { __VA_ARGS__ }, start, run_frame, value }
const model_kind occlusion_model_kinds[OCCLUSION_MODEL_KINDS] = {
    KIND(DIFFUSE, MODEL_DIFFUSE, 1, LANE(DIFF, 0)),
    KIND(SPECULAR, MODEL_SPECULAR, 1, LANE(SPEC, 0)),
    KIND(DIFFUSE_SPECULAR, MODEL_DIFFUSE | MODEL_SPECULAR, 2, LANE(DIFF, 0), LANE(SPEC, 1)),
    KIND(DIFFUSE_DIRECTIONAL, MODEL_DIFFUSE | MODEL_DIRECTIONS, 4, MOMENT(3, LANE_VALUE), MOMENT(0, LANE_DIRECTION), MOMENT(1, LANE_DIRECTION), MOMENT(2, LANE_DIRECTION)),
};
