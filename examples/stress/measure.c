#include "stress/stress.h"

#include <stdio.h>

/* ---- the table */
typedef struct guarantee_row { const char *name; double limit; const char *text; } guarantee_row;
static const guarantee_row guarantees[] = {
#define GUARANTEE_ROW(name, limit, text) { #name, limit, text },
    GUARANTEES(GUARANTEE_ROW)
#undef GUARANTEE_ROW
};
const char *guarantee_name(guarantee g) { return guarantees[g].name; }
const char *guarantee_text(guarantee g) { return guarantees[g].text; }
double guarantee_limit(guarantee g) { return guarantees[g].limit; }

void check(stress *s, guarantee g, const char *of, nrd_denoiser denoiser, double measured)
{
    bool ok = measured <= guarantees[g].limit;
    worst *w = &s->worst[g][denoiser];
    s->passed += ok;
    s->failed += !ok;
    s->seen_failing[g] |= !ok;
    if (!w->checks++ || !(measured <= w->measured)) {
        w->measured = measured;
        snprintf(w->of, sizeof w->of, "%s", of);
    }
    if (!s->silent && (!ok || !s->quiet))
        printf("%-4s %-38s %-44s %-15s %10.3g of %.3g\n", ok ? "ok" : "FAIL", nrd_denoiser_name(denoiser), of, guarantees[g].name, measured, guarantees[g].limit);
}

rig_desc stress_rig(stress *s, nrd_denoiser denoiser, uint32_t width, uint32_t height)
{
    rig_desc desc = { .device = &s->device, .denoiser = denoiser, .width = width, .height = height, .frames_in_flight = RIG_SLOTS, .fault = s->fault,
                      .set = s->set, .set_count = s->set_count };
    return desc;
}

/* ---- noise */
double noise_at(noise_kind kind, uint32_t x, uint32_t y, uint32_t frame, uint32_t seed)
{
    double even = random_at(x & ~1u, y, frame ^ seed << 16), one = random_at(x, y, frame ^ seed << 16);
    switch (kind) {
    case NOISE_UNIFORM: return 2 * one;
    case NOISE_SPARSE: return one < 0.125 ? 8 : 0;
    case NOISE_FIREFLY: return x == 5 && y == 3 ? 1e6 : 2 * one;
    case NOISE_STEP: return x & 1 ? 1e-4 : 1e4;
    case NOISE_BLOCK: return 2 * random_at(x / 8, y / 8, frame ^ seed << 16);
    case NOISE_SCATTERED: return one < 1.0 / 128 ? 128 : 0;
    case NOISE_BLUE: return x & 1 ? 2 - 2 * even : 2 * even;
    default: return 1;
    }
}

static void put_sample(const rig *r, const rig_signal *signal, float *t, double sample, double hit_dist, double penumbra)
{
    const float direction[3] = { 0.36f, 0.48f, -0.8f };
    float v = (float)sample, unit = (float)(0.4 * sample);
    switch (signal->kind) {
    case KIND_RADIANCE: t[0] = v, t[1] = 0.2f * v, t[2] = 0.1f * v, t[3] = (float)hit_dist; return;
    case KIND_VECTOR: for (int k = 0; k < 3; k++) t[k] = direction[k] * v; t[3] = 0; return;
    case KIND_HIT_DIST: t[0] = unit; return;
    case KIND_DIRECTION: for (int k = 0; k < 3; k++) t[k] = direction[k] * unit; t[3] = unit; return;
    case KIND_PENUMBRA: t[0] = sample < 0.9999 * penumbra ? 2 * (float)(2 * r->camera.tan_half_height * (r->camera.orthographic ? 1 : r->depth) / r->rect_height) : 65504; return;
    case KIND_TRANSLUCENCY: t[0] = 0.25f, t[1] = 0.5f, t[2] = 0.125f, t[3] = 1; return;
    default: for (int k = 0; k < 4; k++) t[k] = v; return;
    }
}

void fill_noise(rig *r, noise_kind kind, double level, uint32_t seed)
{
    for (uint32_t s = 0; s < r->signal_count; s++)
        for (uint32_t y = 0; y < r->rect_height; y++)
            for (uint32_t x = 0; x < r->rect_width; x++) {
                double sample = level * noise_at(kind, x, y, r->index, seed), hit_dist = 0.05 + 0.95 * random_at(x, y, r->index + 77);
                put_sample(r, &r->signals[s], rig_texel(r, r->signals[s].in, x, y), sample, hit_dist, level);
            }
}

void fill_picture(rig *r, picture *what, double scale)
{
    fill_noise(r, NOISE_CONSTANT, 1, 0);
    for (uint32_t s = 0; s < r->signal_count; s++)
        FOR_PIXELS(r) {
            float *t = rig_texel(r, r->signals[s].in, x, y), v = (float)(scale * what(x, y)) / 1.0f, w = t[3];
            if (r->signals[s].kind == KIND_HIT_DIST) t[0] = v;
            else for (int k = 0; k < 4; k++) t[k] *= r->signals[s].kind == KIND_DIRECTION ? v / 0.4f : v;
            if (r->signals[s].kind == KIND_RADIANCE || r->signals[s].kind == KIND_VECTOR) t[3] = w;
        }
}

/* ---- what is measured */
watch watch_start(void)
{
    watch w;
    memset(&w, 0, sizeof w);
    for (int i = 0; i < RIG_MAX_SIGNALS; i++) w.seen[i].low = INFINITY, w.seen[i].high = -INFINITY;
    return w;
}

/* Texels of a checkerboarded input belong to other pixels than those they lie at; a pixel without one on its surface shows nothing. */
static bool is_checkerboarded(const rig *r)
{
    double diffuse = 0, specular = 0;
    settings_get(r->denoiser, &r->settings, "diffuse_checkerboard", &diffuse);
    settings_get(r->denoiser, &r->settings, "specular_checkerboard", &specular);
    return diffuse > 0 || specular > 0;
}

void watch_inputs(watch *w, const rig *r)
{
    bool moved = is_checkerboarded(r);
    for (uint32_t s = 0; s < r->signal_count; s++) {
        bool occlusion = r->signals[s].kind == KIND_HIT_DIST || r->signals[s].kind == KIND_DIRECTION;
        for (uint32_t y = 0; y < r->rect_height; y++)
            for (uint32_t x = 0; x < r->rect_width; x++) {
                if (!moved && rig_is_sky(r, x, y)) continue;
                double v = rig_input_value(r, s, x, y);
                w->seen[s].low = fmin(w->seen[s].low, moved ? 0 : v);
                w->seen[s].high = fmax(w->seen[s].high, occlusion && (moved || v == 0) ? 1 : v);   /* open where nothing was sampled */
            }
    }
}

/* How far a texel of radiance or direction is from any that light can have, relative to the brightest input. */
static double impossible(const rig_signal *signal, const float *t, double high)
{
    double scale = fmax(fmax(fabs(t[0]), 1e-3 * high), 1e-6), base = (double)t[0] - t[2], worst = 0;
    if (signal->kind == KIND_DIRECTION) return fmax(fmax(sqrt((double)t[0] * t[0] + (double)t[1] * t[1] + (double)t[2] * t[2]) - t[3], -t[3]), t[3] - 1);
    if (signal->kind != KIND_RADIANCE) return 0;
    double step = 1.2e-7;   /* of two of the smallest halves */
    worst = fmax(worst, -(base + t[1] + step) / scale);
    worst = fmax(worst, -((double)t[0] + t[2] + step) / scale);
    worst = fmax(worst, -(base - t[1] + step) / scale);
    return fmax(worst, fmax(-t[3], t[3] - 1));
}

uint32_t channels_of(const rig_signal *signal) { return signal->kind == KIND_HIT_DIST || (signal->kind == KIND_PENUMBRA && signal->out == NRD_RESOURCE_OUT_SHADOW) ? 1 : 4; }

static void watch_pixel(watch *w, const rig *r, uint32_t s, uint32_t x, uint32_t y)
{
    const rig_signal *signal = &r->signals[s];
    const float *t = rig_texel(r, signal->out, x, y);
    double v = rig_output_value(r, s, x, y), least = signal->kind == KIND_PLAIN ? 0 : 6e-8, high = w->seen[s].high, low = w->seen[s].low;
    if (signal->kind == KIND_HIT_DIST || signal->kind == KIND_DIRECTION) least = 1 / 255.0;
    if (signal->kind == KIND_PENUMBRA) least = 2 / 255.0;   /* a root in 8 bits */
    for (uint32_t k = 0; k < channels_of(signal); k++)
        if (!isfinite(t[k])) w->not_finite++;
    if (signal->kind == KIND_VECTOR || signal->kind == KIND_TRANSLUCENCY) return;
    double whole = signal->kind == KIND_RADIANCE || signal->kind == KIND_PLAIN ? fmax(fmax(fabs(high), fabs(low)), 1e-30) : 1;
    w->beyond = fmax(w->beyond, fmax(v - high - least, low - least - v) / whole);
    w->colour = fmax(w->colour, impossible(signal, t, high));
}

void watch_outputs(watch *w, const rig *r)
{
    for (uint32_t s = 0; s < r->signal_count; s++) {
        nrd_resource out = r->signals[s].out;
        if (out == NRD_RESOURCE_COUNT) continue;
        for (uint32_t y = 0; y < r->height; y++)
            for (uint32_t x = 0; x < r->width; x++) {
                bool inside = x < r->rect_width && y < r->rect_height;
                if (inside && r->frame.split_screen > 0 && rig_is_too_rough(r, s, x, y)) continue;   /* shows the input to the left */
                if (inside && !rig_is_sky(r, x, y) && !rig_is_too_rough(r, s, x, y)) watch_pixel(w, r, s, x, y);
                else w->touched += r->texels[out][4 * ((size_t)y * r->width + x)] != rig_untouched(out);
            }
    }
}

guarantee range_guarantee(const rig *r)
{
    double antilag = 0;
    bool may_scale = settings_get(r->denoiser, &r->settings, "antilag_sensitivity", &antilag) && antilag > 0, unit = r->signals[0].kind == KIND_HIT_DIST || r->signals[0].kind == KIND_DIRECTION;
    return may_scale ? GUARANTEE_ANTILAG_RANGE : unit ? GUARANTEE_OCCLUSION_RANGE : GUARANTEE_RANGE;
}

void watch_check(stress *s, const watch *w, const rig *r, const char *of)
{
    check(s, GUARANTEE_FINITE, of, r->denoiser, w->not_finite);
    check(s, range_guarantee(r), of, r->denoiser, w->beyond);
    check(s, GUARANTEE_COLOUR, of, r->denoiser, w->colour);
    check(s, GUARANTEE_UNTOUCHED, of, r->denoiser, w->touched);
}

static moments moments_of(const rig *r, uint32_t signal, double (*value)(const rig *, uint32_t, uint32_t, uint32_t))
{
    double sum = 0, squares = 0, n = 0;
    for (uint32_t y = 0; y < r->rect_height; y++)
        for (uint32_t x = 0; x < r->rect_width; x++) {
            if (rig_is_sky(r, x, y) || rig_is_too_rough(r, signal, x, y)) continue;
            double v = value(r, signal, x, y);
            sum += v, squares += v * v, n++;
        }
    moments m = { sum / fmax(n, 1), 0 };
    m.deviation = sqrt(fmax(squares / fmax(n, 1) - m.mean * m.mean, 0));
    return m;
}

moments input_moments(const rig *r, uint32_t signal) { return moments_of(r, signal, rig_input_value); }
moments output_moments(const rig *r, uint32_t signal) { return moments_of(r, signal, rig_output_value); }

double noise_left(const rig *r)
{
    double most = 0;
    for (uint32_t s = 0; s < r->signal_count; s++) {
        if (r->signals[s].out == NRD_RESOURCE_COUNT || r->signals[s].kind == KIND_VECTOR || r->signals[s].kind == KIND_TRANSLUCENCY) continue;
        most = fmax(most, output_moments(r, s).deviation / input_moments(r, s).deviation);
    }
    return most;
}
