#include "common/metrics.h"

#include "common/convolve.h"
#include "common/metrics_guides.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define REL_EPSILON 0.01
#define TRIM_DIVISOR 1000 /* 0.1 % */
#define KEY 0.25          /* where exposure brings the geometric mean */
#define PSNR_MAX 120.0
#define SSIM_C1 1e-4
#define SSIM_C2 9e-4
#define SSIM_RADIUS 5
#define SSIM_SIGMA 1.5

/* ---- tone ---- */

metrics_scale metrics_scale_of(const image *reference, const unsigned char *mask, bool unit)
{
    metrics_scale scale = { 1.0, 1e-3, unit };
    double sum = 0;
    long count = 0;
    if (unit)
        return scale;
    for (size_t i = 0; i < image_pixels(reference); i++) {
        double luminance = image_luminance(reference, i);
        if (!mask[i] || !isfinite(luminance))
            continue;
        sum += log(fmax(luminance, 0) + 1e-6);
        count++;
    }
    double key = count ? exp(sum / (double)count) : 1.0;
    scale.exposure = KEY / key;
    scale.log_floor = 2e-3 * key;
    return scale;
}

double metrics_tone(double linear, const metrics_scale *scale)
{
    double x = isfinite(linear) && linear > 0 ? linear : 0;
    if (scale->unit)
        return fmin(x, 1);
    x *= scale->exposure;
    return pow(x / (1 + x), 1 / 2.2);
}

/* ---- structural similarity ---- */

/* The windowed mean of a * b. */
static void windowed_mean(const double *a, const double *b, int width, int height, double *scratch, double *out)
{
    size_t count = (size_t)width * (size_t)height;
    double window[2 * SSIM_RADIUS + 1], sum = 0;
    for (int i = -SSIM_RADIUS; i <= SSIM_RADIUS; i++)
        sum += window[i + SSIM_RADIUS] = exp(-i * i / (2 * SSIM_SIGMA * SSIM_SIGMA));
    for (int i = 0; i <= 2 * SSIM_RADIUS; i++)
        window[i] /= sum;
    for (size_t i = 0; i < count; i++)
        out[i] = b ? a[i] * b[i] : a[i];
    convolve_rows(out, scratch, width, height, window, SSIM_RADIUS);
    convolve_columns(scratch, out, width, height, window, SSIM_RADIUS);
}

static double similarity(double mean_a, double mean_b, double aa, double bb, double ab)
{
    double variance_a = fmax(aa - mean_a * mean_a, 0), variance_b = fmax(bb - mean_b * mean_b, 0);
    double luminance = (2 * mean_a * mean_b + SSIM_C1) / (mean_a * mean_a + mean_b * mean_b + SSIM_C1);
    double structure = (2 * (ab - mean_a * mean_b) + SSIM_C2) / (variance_a + variance_b + SSIM_C2);
    return luminance * structure;
}

/* Mean over the mask; false when memory is short. */
static bool structural_similarity(const double *a, const double *b, const unsigned char *mask, int width, int height, double *out)
{
    size_t count = (size_t)width * (size_t)height, used = 0;
    double *memory = malloc(count * 6 * sizeof *memory), sum = 0;
    if (!memory)
        return false;
    double *mean_a = memory, *mean_b = mean_a + count, *aa = mean_b + count, *bb = aa + count, *ab = bb + count, *scratch = ab + count;
    windowed_mean(a, NULL, width, height, scratch, mean_a);
    windowed_mean(b, NULL, width, height, scratch, mean_b);
    windowed_mean(a, a, width, height, scratch, aa);
    windowed_mean(b, b, width, height, scratch, bb);
    windowed_mean(a, b, width, height, scratch, ab);
    for (size_t i = 0; i < count; i++)
        if (mask[i]) {
            sum += similarity(mean_a[i], mean_b[i], aa[i], bb[i], ab[i]);
            used++;
        }
    free(memory);
    *out = used ? sum / (double)used : 1.0;
    return true;
}

/* ---- errors ---- */

static double mean_of(const double *values, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += values[i];
    return count ? sum / (double)count : 0;
}

/* Moves the `least` smallest values to the front (C. A. R. Hoare, Algorithm 65: Find, CACM 4(7), 1961). */
static void select_least(double *values, size_t count, size_t least)
{
    for (size_t low = 0, high = count; high - low > 1;) {
        double pivot = values[low + (high - low - 1) / 2]; /* never the last: both parts are smaller than the whole */
        size_t i = low, j = high - 1;
        for (;; i++, j--) {
            while (values[i] < pivot)
                i++;
            while (values[j] > pivot)
                j--;
            if (i >= j)
                break;
            double swap = values[i];
            values[i] = values[j];
            values[j] = swap;
        }
        if (least <= j + 1)
            high = j + 1;
        else
            low = j + 1;
    }
}

/* Moves the errors. */
static double trimmed_mean(double *errors, size_t count)
{
    size_t kept = count - count / TRIM_DIVISOR;
    select_least(errors, count, kept);
    return mean_of(errors, kept);
}

static double finite_or_zero(double value)
{
    return isfinite(value) ? value : 0;
}

static double finite_luminance(const image *m, size_t i)
{
    if (m->channels == 1)
        return finite_or_zero(m->planes[0][i]);
    return 0.2126 * finite_or_zero(m->planes[0][i]) + 0.7152 * finite_or_zero(m->planes[1][i]) + 0.0722 * finite_or_zero(m->planes[2][i]);
}

static double square(double x)
{
    return x * x;
}

static double relative_error(const image *m, const image *reference, size_t i)
{
    double sum = 0;
    for (int k = 0; k < m->channels; k++) {
        double r = reference->planes[k][i];
        sum += square(finite_or_zero(m->planes[k][i]) - r) / (r * r + REL_EPSILON);
    }
    return sum / m->channels;
}

static double tone_error(const image *m, const image *reference, size_t i, const metrics_scale *scale)
{
    double sum = 0;
    for (int k = 0; k < m->channels; k++)
        sum += square(metrics_tone(m->planes[k][i], scale) - metrics_tone(reference->planes[k][i], scale));
    return sum / m->channels;
}

/* Fills the tone-mapped luminances for SSIM and the relative errors; returns how many pixels count. Sums, not means. */
static size_t add_pixels(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale,
                         metrics *sum, double *tones, double *reference_tones, double *errors)
{
    size_t used = 0;
    for (size_t i = 0; i < image_pixels(m); i++) {
        tones[i] = reference_tones[i] = 0;
        if (!mask[i])
            continue;
        double luminance = finite_luminance(m, i), expected = image_luminance(reference, i);
        errors[used++] = relative_error(m, reference, i);
        sum->tone_mse += tone_error(m, reference, i, scale);
        sum->log_mse += square(log2((fmax(luminance, 0) + scale->log_floor) / (fmax(expected, 0) + scale->log_floor)));
        sum->mean += luminance;
        sum->mean_reference += expected;
        tones[i] = metrics_tone(luminance, scale);
        reference_tones[i] = metrics_tone(expected, scale);
    }
    return used;
}

bool metrics_compare(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale, metrics *out)
{
    size_t count = image_pixels(m);
    double *memory = malloc(count * 3 * sizeof *memory);
    memset(out, 0, sizeof *out);
    if (!memory)
        return false;
    double *tones = memory, *reference_tones = memory + count, *errors = memory + 2 * count;
    size_t used = add_pixels(m, reference, mask, scale, out, tones, reference_tones, errors);
    double share = used ? 1.0 / (double)used : 0;
    out->tone_mse *= share;
    out->log_mse *= share;
    out->mean *= share;
    out->mean_reference *= share;
    out->rel_mse = mean_of(errors, used);
    out->rel_mse_trimmed = trimmed_mean(errors, used);
    out->frames = 1;
    bool ok = structural_similarity(tones, reference_tones, mask, m->width, m->height, &out->ssim);
    free(memory);
    return ok;
}

bool metrics_relative(const image *m, const image *reference, const unsigned char *mask, metrics *out)
{
    size_t count = image_pixels(m), used = 0;
    double *errors = malloc(count * sizeof *errors);
    memset(out, 0, sizeof *out);
    if (!errors)
        return false;
    for (size_t i = 0; i < count; i++)
        if (mask[i]) {
            errors[used++] = relative_error(m, reference, i);
            out->mean += finite_luminance(m, i);
            out->mean_reference += image_luminance(reference, i);
        }
    double share = used ? 1.0 / (double)used : 0;
    out->mean *= share;
    out->mean_reference *= share;
    out->rel_mse = mean_of(errors, used);
    out->rel_mse_trimmed = trimmed_mean(errors, used);
    out->frames = 1;
    free(errors);
    return true;
}

bool metrics_reference_noise(const image *reference, const float *standard_error, const unsigned char *mask, metrics *out)
{
    size_t used = 0;
    double *errors = malloc(image_pixels(reference) * sizeof *errors);
    memset(out, 0, sizeof *out);
    if (!errors)
        return false;
    for (size_t i = 0; i < image_pixels(reference); i++)
        if (mask[i])
            errors[used++] = square(standard_error[i]) / (square(image_luminance(reference, i)) + REL_EPSILON);
    out->rel_mse = mean_of(errors, used);
    out->rel_mse_trimmed = trimmed_mean(errors, used);
    out->frames = 1;
    free(errors);
    return true;
}

void metrics_add(metrics *sum, const metrics *frame)
{
    sum->rel_mse += frame->rel_mse;
    sum->rel_mse_trimmed += frame->rel_mse_trimmed;
    sum->log_mse += frame->log_mse;
    sum->tone_mse += frame->tone_mse;
    sum->ssim += frame->ssim;
    sum->mean += frame->mean;
    sum->mean_reference += frame->mean_reference;
    sum->frames += frame->frames;
}

metrics_summary metrics_summarise(const metrics *sum)
{
    metrics_summary s = { 0, 0, 0, 0, 0, 0, 0 };
    if (!sum->frames)
        return s;
    double tone_mse = sum->tone_mse / sum->frames;
    s.rel_mse = sum->rel_mse / sum->frames;
    s.rel_mse_trimmed = sum->rel_mse_trimmed / sum->frames;
    s.log_rmse = sqrt(sum->log_mse / sum->frames);
    s.tone_rmse = sqrt(tone_mse);
    s.psnr = tone_mse > 0 ? fmin(-10 * log10(tone_mse), PSNR_MAX) : PSNR_MAX;
    s.ssim = sum->ssim / sum->frames;
    s.bias = sum->mean_reference != 0 ? (sum->mean - sum->mean_reference) / sum->mean_reference : 0;
    return s;
}

void metrics_count_bad(const image *m, const unsigned char *mask, metrics_bad *bad)
{
    for (size_t i = 0; i < image_pixels(m); i++) {
        bool nan = false, inf = false, negative = false;
        for (int k = 0; k < m->channels && mask[i]; k++) {
            float value = m->planes[k][i];
            nan |= isnan(value);
            inf |= isinf(value);
            negative |= value < 0;
        }
        bad->nan += nan;
        bad->inf += inf;
        bad->negative += negative;
    }
}

/* ---- flicker ---- */

/* Bilinear value of `tones` at the previous place of pixel (x, y). False when part of it was not visible. */
static bool previous_tone(const guides *then, const guides *now, const float *tones, int x, int y, double *out)
{
    int width = now->frame->width, height = now->frame->height;
    size_t i = (size_t)y * (size_t)width + (size_t)x;
    double px = x + (double)now->motion[0][i] * width, py = y + (double)now->motion[1][i] * height, value = 0, total = 0;
    if (!(fabs(px) < 1e6 && fabs(py) < 1e6))
        return false;
    int left = (int)floor(px + 1e-4), top = (int)floor(py + 1e-4);
    for (int tap = 0; tap < 4; tap++) {
        int tx = left + (tap & 1), ty = top + (tap >> 1);
        double weight = fmax(0, 1 - fabs(px - tx)) * fmax(0, 1 - fabs(py - ty));
        if (weight < 1e-3)
            continue;
        if (tx < 0 || ty < 0 || tx >= width || ty >= height)
            return false;
        size_t j = (size_t)ty * (size_t)width + (size_t)tx;
        if (!guides_same_surface(then, j, now, i))
            return false;
        value += weight * tones[j];
        total += weight;
    }
    *out = total > 0 ? value / total : 0;
    return total >= 0.5;
}

bool metrics_add_flicker(const capture *then, const image *before, const capture *now, const image *m,
                         const unsigned char *mask, const metrics_scale *scale, metrics_flicker *flicker)
{
    guides g_then, g_now;
    if (now->cut || then->width != now->width || then->height != now->height || !guides_find(then, false, &g_then)
        || !guides_find(now, true, &g_now))
        return true;
    float *tones = malloc(image_pixels(before) * sizeof *tones);
    if (!tones)
        return false;
    for (size_t i = 0; i < image_pixels(before); i++)
        tones[i] = (float)metrics_tone(image_luminance(before, i), scale);
    for (int y = 0; y < now->height; y++)
        for (int x = 0; x < now->width; x++) {
            size_t i = (size_t)y * (size_t)now->width + (size_t)x;
            double previous;
            if (!mask[i] || !previous_tone(&g_then, &g_now, tones, x, y, &previous))
                continue;
            flicker->sum += fabs(metrics_tone(image_luminance(m, i), scale) - previous);
            flicker->pixels++;
        }
    free(tones);
    return true;
}
