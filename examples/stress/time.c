/* Stiff in time: very long runs, jumps of light, surfaces that come and go, histories of any length. */
#include "stress/stress.h"

#include <stdio.h>
#include <stdlib.h>

enum { SIZE = 16, RING = 61, QUICK_FRAMES = 500, LONG_FRAMES = 100000, SETTLE = 250, SCATTERED_SIZE = 32 };

/* ---- inputs that repeat, kept on the device */
typedef struct ring {
    gpu_image *frames[RING];            /* an image per signal */
    double truth[RIG_MAX_SIGNALS];      /* mean of the inputs over the picture and the ring */
    double chroma[RIG_MAX_SIGNALS][2];  /* likewise; 0 where there is no colour */
} ring;

/* Adds the part-th part of the mean Co and Cg of a picture. */
static void add_chroma(double sum[2], const rig *r, uint32_t signal, nrd_resource picture, double part)
{
    if (r->signals[signal].kind != KIND_RADIANCE) return;
    FOR_PIXELS(r) for (int k = 0; k < 2; k++) sum[k] += part / (r->rect_width * r->rect_height) * rig_texel(r, picture, x, y)[1 + k];
}

static void ring_make(ring *g, rig *r, noise_kind noise, double level, uint32_t seed)
{
    memset(g, 0, sizeof *g);
    uint32_t index = r->index;
    for (uint32_t i = 0; i < RING; i++) {
        g->frames[i] = (gpu_image *)calloc(RIG_MAX_SIGNALS, sizeof(gpu_image));
        if (!g->frames[i]) stress_die("out of memory");
        r->index = i;
        fill_noise(r, noise, level, seed);
        for (uint32_t s = 0; s < r->signal_count; s++) {
            g->frames[i][s] = rig_make_input(r, s);
            g->truth[s] += input_moments(r, s).mean / RING;
            add_chroma(g->chroma[s], r, s, r->signals[s].in, 1.0 / RING);
        }
    }
    r->index = index;
}

static void ring_free(ring *g, rig *r)
{
    for (uint32_t i = 0; i < RING; i++) {
        for (uint32_t s = 0; s < r->signal_count; s++) gpu_image_destroy(r->device, &g->frames[i][s]);
        free(g->frames[i]);
    }
}

static void run_ring(rig *r, const ring *g, uint32_t frames) { rig_run_many(r, frames, g->frames, RING); }

static bool is_shown(const rig *r, uint32_t signal)
{
    signal_kind kind = r->signals[signal].kind;
    return r->signals[signal].out != NRD_RESOURCE_COUNT && kind != KIND_VECTOR && kind != KIND_TRANSLUCENCY;
}

/* What errors are relative to: the truth, or the whole range of signals that have one. */
static double scale_of(const rig *r, uint32_t signal, double truth)
{
    signal_kind kind = r->signals[signal].kind;
    return kind == KIND_RADIANCE || kind == KIND_PLAIN ? fmax(truth, 1e-30) : 1;
}

static bool is_unit(const rig *r) { return r->signals[0].kind == KIND_HIT_DIST || r->signals[0].kind == KIND_DIRECTION; }

/* Guides once, then the first frame's inputs. */
static void begin(rig *r, uint32_t index)
{
    rig_reset(r);
    r->index = index;
    rig_put_guides(r);
    fill_noise(r, NOISE_CONSTANT, 1, 0);
    rig_upload_all(r);
}

/* ---- long runs */
/* What the output is rounded to leaves of a mean that stands still, at least: half of a step of the smallest halves. */
#define HALF_STEP 3.0e-8

/* Error of the mean over the picture and as many frames as the inputs take to repeat; of chroma, beyond its rounding, relative to luma. */
static double error_of_mean(rig *r, const ring *g)
{
    double sum[RIG_MAX_SIGNALS] = { 0 }, chroma[RIG_MAX_SIGNALS][2] = { { 0 } }, most = 0;
    for (uint32_t i = 0; i < RING; i++) {
        run_ring(r, g, 1);
        rig_download(r);
        for (uint32_t s = 0; s < r->signal_count; s++)
            if (is_shown(r, s)) sum[s] += output_moments(r, s).mean / RING, add_chroma(chroma[s], r, s, r->signals[s].out, 1.0 / RING);
    }
    for (uint32_t s = 0; s < r->signal_count; s++) {
        if (!is_shown(r, s)) continue;
        double off = fmax(fabs(sum[s] - g->truth[s]), fmax(fabs(chroma[s][0] - g->chroma[s][0]), fabs(chroma[s][1] - g->chroma[s][1])) - HALF_STEP);
        most = fmax(most, off / scale_of(r, s, g->truth[s]));
    }
    return most;
}

static bool is_shadow(const rig *r) { return r->texels[NRD_RESOURCE_IN_PENUMBRA] != NULL; }

static void long_run(stress *s, rig *r, noise_kind noise, double level, const char *name)
{
    ring g;
    char of[64];
    bool sparse = noise == NOISE_SPARSE, dim = level < 5e-6;
    uint32_t frames = s->frames ? s->frames : s->everything && noise == NOISE_UNIFORM && level == 1 ? LONG_FRAMES : QUICK_FRAMES;
    begin(r, (uint32_t)(0 - frames / 2));   /* frame_index wraps on the way */
    ring_make(&g, r, noise, level, s->seed);
    run_ring(r, &g, SETTLE);
    double early = error_of_mean(r, &g);
    run_ring(r, &g, frames);
    double late = error_of_mean(r, &g);
    snprintf(of, sizeof of, "%s, %u frames", name, frames);
    check(s, is_shadow(r) ? GUARANTEE_SHADOW_MEAN : sparse || dim ? GUARANTEE_ROUGH_MEAN : GUARANTEE_MEAN, of, r->denoiser, late);
    if (!sparse && !dim) check(s, GUARANTEE_DRIFT, of, r->denoiser, fabs(late - early));
    ring_free(&g, r);
}

/* Impulses that come and go at random: what one loses at once, others have given. More frames than the ring has make no difference. */
static void scattered(stress *s, nrd_denoiser denoiser)
{
    ring g;
    rig r;
    rig_desc desc = stress_rig(s, denoiser, SCATTERED_SIZE, SCATTERED_SIZE);
    rig_open(&r, &desc);
    begin(&r, 3);
    if (rig_set(&r, "antilag_sensitivity", 0)) {
        ring_make(&g, &r, NOISE_SCATTERED, 1, s->seed);
        run_ring(&r, &g, SETTLE);
        check(s, GUARANTEE_SCATTERED_ENERGY, "impulses at random", denoiser, error_of_mean(&r, &g));
        ring_free(&g, &r);
    }
    rig_close(&r);
}

/* ---- a constant picture stands still */
static double most_change(rig *r, uint32_t frames, const ring *g)
{
    double most = 0;
    float *before = (float *)calloc((size_t)4 * SIZE * SIZE * NRD_RESOURCE_COUNT, sizeof *before);
    if (!before) stress_die("out of memory");
    for (uint32_t i = 0; i <= frames; i++) {
        run_ring(r, g, 1);
        rig_download(r);
        for (uint32_t s = 0; s < r->signal_count; s++) {
            nrd_resource out = r->signals[s].out;
            if (!is_shown(r, s)) continue;
            float *last = before + (size_t)out * 4 * SIZE * SIZE;
            for (uint32_t k = 0; k < 4 * SIZE * SIZE; k += 4) {
                if (i) most = fmax(most, fabs((double)r->texels[out][k] - last[k]) / scale_of(r, s, fabs(last[k])));
                last[k] = r->texels[out][k];
            }
        }
    }
    free(before);
    return most;
}

static void limit_cycles(stress *s, rig *r, double level)
{
    ring g, noise;
    char of[64];
    begin(r, 3);
    ring_make(&noise, r, NOISE_UNIFORM, level, s->seed);
    ring_make(&g, r, NOISE_CONSTANT, level, s->seed);
    run_ring(r, &noise, 40);
    run_ring(r, &g, 2000);
    snprintf(of, sizeof of, "constant %g after noise", level);
    check(s, is_unit(r) ? GUARANTEE_STEADY_8_BIT : GUARANTEE_STEADY, of, r->denoiser, most_change(r, 40, &g));
    ring_free(&g, r);
    ring_free(&noise, r);
}

/* ---- jumps */
/* Error of the mean some frames after the light has gone from one level to another at once. */
static void jump(stress *s, rig *r, double from, double to, noise_kind noise, uint32_t frames)
{
    ring a, b;
    char of[64];
    double most = 0;
    begin(r, 3);
    ring_make(&a, r, noise, from, s->seed);
    ring_make(&b, r, noise, to, s->seed + 1);
    run_ring(r, &a, 100);
    run_ring(r, &b, frames);
    rig_download(r);
    for (uint32_t i = 0; i < r->signal_count; i++)
        if (is_shown(r, i)) most = fmax(most, fabs(output_moments(r, i).mean - b.truth[i]) / scale_of(r, i, to > 0 ? b.truth[i] : a.truth[i]));
    snprintf(of, sizeof of, "%s %g to %g, after %u frames", noise == NOISE_CONSTANT ? "constant" : "noise", from, to, frames);
    check(s, to > 0 ? GUARANTEE_JUMP : GUARANTEE_RESIDUE, of, r->denoiser, most);
    ring_free(&a, r);
    ring_free(&b, r);
}

/* Light that is twice as bright in every other frame: the mean holds. */
static void flicker(stress *s, rig *r)
{
    ring a, b;
    double sum[RIG_MAX_SIGNALS] = { 0 }, most = 0;
    begin(r, 3);
    ring_make(&a, r, NOISE_UNIFORM, 1, s->seed);
    ring_make(&b, r, NOISE_UNIFORM, 2, s->seed + 1);
    for (uint32_t i = 0; i < 200; i++) {
        run_ring(r, i & 1 ? &b : &a, 1);
        if (i < 100) continue;
        rig_download(r);
        for (uint32_t k = 0; k < r->signal_count; k++)
            if (is_shown(r, k)) sum[k] += output_moments(r, k).mean / 100;
    }
    for (uint32_t k = 0; k < r->signal_count; k++)
        if (is_shown(r, k)) most = fmax(most, fabs(sum[k] - 0.5 * (a.truth[k] + b.truth[k])) / scale_of(r, k, 0.5 * (a.truth[k] + b.truth[k])));
    check(s, GUARANTEE_FLICKER_MEAN, "light that doubles every other frame", r->denoiser, most);
    ring_free(&a, r);
    ring_free(&b, r);
}

/* ---- surfaces that come and go: another one, in another light, in every other frame */
static void alternate(stress *s, rig *r)
{
    double most = 0;
    rig_reset(r);
    r->index = 3;
    r->frame.motion_mode = NRD_MOTION_2D;
    for (uint32_t i = 0; i < 40; i++) {
        r->depth = i & 1 ? 5 : 10;
        rig_put_guides(r);
        fill_noise(r, NOISE_CONSTANT, i & 1 ? 1 : 0.01, s->seed);
        rig_run(r);
        for (uint32_t k = 0; k < r->signal_count; k++)
            if (is_shown(r, k)) most = fmax(most, fabs(output_moments(r, k).mean - input_moments(r, k).mean) / scale_of(r, k, input_moments(r, k).mean));
    }
    check(s, GUARANTEE_LEAK, "another surface every other frame", r->denoiser, most);
}

/* ---- history */
static float shown_length(const rig *r, uint32_t signal, uint32_t x, uint32_t y)
{
    const float *t = rig_texel(r, r->signals[signal].out, x, y);
    return r->signals[signal].kind == KIND_HIT_DIST ? t[0] : t[3];
}

/* Counters saturate at max_accumulated_frames + 1, but 63. */
static void lengths(stress *s, rig *r, double most_frames)
{
    ring g;
    char of[64];
    double worst = 0, expected = fmin(most_frames + 1, is_unit(r) ? 63 : 63.75);
    begin(r, 3);
    if (!rig_set(r, "return_history_length_instead_of_occlusion", 1) || !rig_set(r, "max_accumulated_frames", most_frames)) return;
    ring_make(&g, r, NOISE_CONSTANT, 1, s->seed);
    run_ring(r, &g, 400);
    rig_download(r);
    for (uint32_t k = 0; k < r->signal_count; k++)
        FOR_PIXELS(r) if (is_shown(r, k)) worst = fmax(worst, fabs(shown_length(r, k, x, y) - expected));
    snprintf(of, sizeof of, "length after 400 frames of at most %g", most_frames);
    check(s, GUARANTEE_LENGTH, of, r->denoiser, worst);
    ring_free(&g, r);
}

/* A still view without spatial filter is the plain mean: its deviation falls with the root of the length. */
static void averaging(stress *s, rig *r, uint32_t frames)
{
    ring g;
    char of[64];
    double worst = 0;
    begin(r, 3);
    rig_set(r, "max_accumulated_frames", 63);
    rig_set(r, "max_blur_radius", 0);
    rig_set(r, "max_stabilized_frames", 0);
    rig_set(r, "antilag_sensitivity", 0);
    rig_set(r, "antilag_sigma_scale", 100);
    ring_make(&g, r, NOISE_UNIFORM, 1, s->seed);
    double deviation[RIG_MAX_SIGNALS] = { 0 };
    for (uint32_t k = 0; k < r->signal_count; k++) deviation[k] = input_moments(r, k).deviation;
    run_ring(r, &g, frames);
    rig_download(r);
    for (uint32_t k = 0; k < r->signal_count; k++)
        if (is_shown(r, k)) worst = fmax(worst, fabs(output_moments(r, k).deviation / deviation[k] * sqrt(frames) - 1));
    snprintf(of, sizeof of, "deviation after %u frames", frames);
    check(s, GUARANTEE_AVERAGING, of, r->denoiser, worst);
    ring_free(&g, r);
}

static bool is_guided(const rig *r) { return r->texels[NRD_RESOURCE_IN_VIEWZ] != NULL; }

static const struct { noise_kind noise; double level; const char *name; } runs[] = {
    { NOISE_UNIFORM, 1, "noise" }, { NOISE_UNIFORM, 1e-5, "noise of 1e-5" }, { NOISE_SPARSE, 1, "sparse noise" },
    { NOISE_UNIFORM, 1e-6, "noise of 1e-6" }, { NOISE_UNIFORM, 1e-3, "noise of 1e-3" }, { NOISE_UNIFORM, 3e4, "noise of 3e4" },   /* the long suite alone */
};

static void run_denoiser(stress *s, rig *r)
{
    static const double counts[] = { 0, 1, 31, 62, 63 };
    for (size_t i = 0; i < (is_unit(r) || is_shadow(r) ? 1 : s->everything ? sizeof runs / sizeof runs[0] : 3); i++) long_run(s, r, runs[i].noise, runs[i].level, runs[i].name);
    if (!is_shadow(r)) limit_cycles(s, r, 0.7);
    if (!is_guided(r)) return;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) lengths(s, r, counts[i]);
    for (uint32_t frames = 4; frames <= 60 && !is_shadow(r); frames = frames * 15 / 4) averaging(s, r, frames);
    flicker(s, r);
    if (!is_shadow(r)) alternate(s, r);
    bool unit = is_unit(r) || is_shadow(r);
    if (!is_unit(r)) jump(s, r, 1, 0, NOISE_CONSTANT, 64);   /* a hit distance of 0 is none */
    jump(s, r, unit ? 0.01 : 1e-3, unit ? 1 : 1e3, NOISE_UNIFORM, 64);
    jump(s, r, unit ? 1 : 1e3, unit ? 0.01 : 1e-3, NOISE_UNIFORM, 64);
    if (!unit) jump(s, r, 6e4, 0, NOISE_SPARSE, 64);
}

void stress_time(stress *s)
{
    for (int d = (int)s->first; d <= (int)s->last; d++) {
        rig r;
        rig_desc desc = stress_rig(s, (nrd_denoiser)d, SIZE, SIZE);
        rig_open(&r, &desc);
        run_denoiser(s, &r);
        rig_close(&r);
        scattered(s, (nrd_denoiser)d);
    }
}
