/* metrics.h: how far a denoised image is from its reference, and how much it flickers.

   d is the image, r the reference, both linear; means are over the pixels of a mask and, where said so, over channels.
   NaN and Inf of d count as 0 everywhere but in metrics_count_bad.

   relMSE     mean of (d - r)^2 / (r^2 + 0.01) over channels and pixels (Rousselle et al. 2011, "Adaptive sampling and
              reconstruction using greedy error minimization", section 3, epsilon 0.01)
   trimmed    the same without the 0.1 % of the pixels that are worst: single fireflies do not decide
   log RMSE   root mean square of log2((L(d) + e) / (L(r) + e)), in stops; L is Rec. 709 luminance, negative counts as 0
   tm(x)      tone mapping: y = exposure * max(x, 0), (y / (1 + y))^(1/2.2) (Reinhard et al. 2002, equation 3, without the
              white point); shadow and ambient occlusion are clamped to [0,1] instead
   tm RMSE    root mean square of tm(d) - tm(r) per channel; PSNR = -20 log10 of it, at most 120 dB
   SSIM       mean structural similarity of tm(L) (Wang et al. 2004, "Image quality assessment", equation 13): 11 x 11
              Gaussian window, sigma 1.5, edges extended, C1 = 0.01^2, C2 = 0.03^2; pixels outside the mask are 0
   bias       (mean L(d) - mean L(r)) / mean L(r)
   flicker    mean |tm(L(d_t)) at the pixel - tm(L(d_{t-1})) at its previous place|, bilinear along the motion vectors,
              over pixels whose previous place was visible: depth within 2 %, normals within 37 degrees (dot >= 0.8),
              same material, nothing outside the picture or in the sky

   Over several frames relMSE, the squares under a root, SSIM and the two means of bias are averaged over the frames,
   and flicker over all its pixels. */
#ifndef EXAMPLES_METRICS_H
#define EXAMPLES_METRICS_H

#include "common/capture.h"
#include "common/image.h"

/* How values are brought to what an eye sees. */
typedef struct metrics_scale {
    double exposure;  /* multiplies radiance before tone mapping: brings the geometric mean to 0.25 */
    double log_floor; /* e of log RMSE: 0.002 of the geometric mean; 0.001 for unit signals */
    bool unit;        /* a quantity within [0,1]: not tone-mapped */
} metrics_scale;

/* Errors of one frame, or sums over frames. */
typedef struct metrics {
    double rel_mse, rel_mse_trimmed;
    double log_mse, tone_mse;      /* squares */
    double ssim;                   /* 1 when no pixel counts */
    double mean, mean_reference;   /* linear luminance */
    int frames;
} metrics;

/* What is printed. */
typedef struct metrics_summary {
    double rel_mse, rel_mse_trimmed, log_rmse, tone_rmse, psnr, ssim, bias;
} metrics_summary;

/* Pixels with such a value in some channel. */
typedef struct metrics_bad {
    long nan, inf, negative;
} metrics_bad;

typedef struct metrics_flicker {
    double sum;
    long pixels;
} metrics_flicker;

/* Exposure and floor from the geometric mean of a reference (of max(L, 0) + 1e-6). `unit` signals are left as they are. */
metrics_scale metrics_scale_of(const image *reference, const unsigned char *mask, bool unit);

/* NaN, Inf and negative values count as 0. Unit signals are clamped to [0,1]. */
double metrics_tone(double linear, const metrics_scale *scale);

/* Compares two images of the same size and channels. False when memory is short. */
bool metrics_compare(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale, metrics *out);

/* relMSE, trimmed, and the means of bias alone, many times faster; the other members are 0. */
bool metrics_relative(const image *m, const image *reference, const unsigned char *mask, metrics *out);

/* The relMSE that the reference's own noise makes, an upper bound from its standard error of the luminance s:
   mean of s^2 / (L(r)^2 + 0.01), and trimmed. The other members are 0. False when memory is short. */
bool metrics_reference_noise(const image *reference, const float *standard_error, const unsigned char *mask, metrics *out);

/* Adds one frame to a sum. */
void metrics_add(metrics *sum, const metrics *frame);

/* Averages; zeros for a sum of no frames. */
metrics_summary metrics_summarise(const metrics *sum);

/* Adds the pixels of one frame. */
void metrics_count_bad(const image *m, const unsigned char *mask, metrics_bad *bad);

/* Adds the change from image `before` of frame `then` to image `m` of frame `now`. Adds nothing when `now` starts a shot, lacks
   guides, or the sizes differ. False when memory is short. */
bool metrics_add_flicker(const capture *then, const image *before, const capture *now, const image *m,
                         const unsigned char *mask, const metrics_scale *scale, metrics_flicker *flicker);

#endif
