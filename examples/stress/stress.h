/* stress.h: what the subjects of nrd-stress share: options, the guarantees with their limits, the table, noise, and what is measured of
   an output. */
#ifndef STRESS_H
#define STRESS_H

#include "stress/rig.h"

#include <stdio.h>

/* X(name, most that may be measured, text). A guarantee has one limit, whatever the case; where the denoisers need different ones there are
   as many guarantees. */
#define GUARANTEES(X) \
    X(FINITE, 0, "pixels that are not finite") \
    X(RANGE, 0.002, "output beyond the range of all inputs since the restart, relative, without antilag") \
    X(ANTILAG_RANGE, 3, "output beyond that range with antilag, which may scale history by up to 4") \
    X(OCCLUSION_RANGE, 0.05, "occlusion beyond that range: its antilag shifts history by what the mean of samples changes") \
    X(COLOUR, 0.01, "negative colour, hit distance beyond [0,1], direction longer than its length; of the luma") \
    X(UNTOUCHED, 0, "pixels of the sky, too rough for a signal or outside of the rectangle that were written") \
    X(REFUSALS, 0, "wrong calls that were accepted, or refused without naming what is wrong; right ones that were refused") \
    X(MEAN, 0.002, "error of the mean over the picture and 61 frames of noise that repeat, relative; here and below occlusion and shadows: of 1") \
    X(SHADOW_MEAN, 0.004, "error of that mean of shadows") \
    X(DRIFT, 0.002, "change of that mean in the course of a very long run") \
    X(STEADY, 0.001, "change from frame to frame of a constant picture after 2000 frames, relative") \
    X(STEADY_8_BIT, 0.008, "change from frame to frame of constant occlusion, which is rounded at random to 8 bits") \
    X(LENGTH, 0, "frames by which the length of history is off its maximum") \
    X(AVERAGING, 0.15, "deviation over that of the plain mean, minus 1: still view, no spatial filter") \
    X(FLICKER_MEAN, 0.05, "error of the mean in light that doubles every other frame, relative") \
    X(LEAK, 0.01, "light of another surface that was there in the frame before, relative") \
    X(JUMP, 0.05, "error of the mean 64 frames after the light has jumped up or down by 1e6, relative") \
    X(RESIDUE, 0.001, "what is left of the light 64 frames after it went out") \
    X(ROUGH_MEAN, 0.01, "error of the mean of noise that is 8 in one pixel of 8, and of noise of 1e-6, 17 steps of the smallest halves; relative") \
    X(CONSTANT, 0.001, "error of a constant picture, relative: one step of 16-bit floats") \
    X(CONSTANT_8_BIT, 0.004, "error of constant occlusion: one step of 8 bits") \
    X(GRADIENT, 0.02, "error of a linear gradient without noise, 2 px from the picture's border on, relative") \
    X(GRADIENT_8_BIT, 0.02, "error of such a gradient of occlusion") \
    X(EDGE, 0.08, "error 4 pixels from a step from 0.1 to 1 on a plane without noise, relative") \
    X(EDGE_WIDTH, 1.4, "standard deviation of what such a step is spread over, px") \
    X(EDGE_8_BIT, 0.03, "error of occlusion 4 pixels from such a step") \
    X(ENERGY, 0.01, "energy that a pixel 5 times brighter than the rest loses or gains at luminance_sigma_scale 1000; and in the first two passes at any") \
    X(SCATTERED_ENERGY, 0.03, "energy lost or gained of single pixels lit 128 times the mean that come and go at random, one in 128, without antilag") \
    X(OUTLIER_ENERGY, 0.1, "energy that a single pixel lit in the dark loses or gains in the first frame, at defaults") \
    X(STILL_ENERGY, 0.16, "energy that such a pixel loses or gains that stays lit for 40 frames") \
    X(FRAMED_ENERGY, 0.1, "the same in the first frame in the middle of 32x32 px, whose border gives part of it back") \
    X(FRAMED_STILL_ENERGY, 0.17, "the same after 40 frames there") \
    X(ARITHMETIC, 1e-5, "error of the picture when one pass computes in 32 bits, relative, by a double-precision model; here and below occlusion and shadows: of 1") \
    X(STORAGE, 0.002, "error of the picture when one pass stores 16 bits, relative, by that model") \
    X(STORAGE_STABILIZED, 0.004, "that of stabilization with what it keeps over time, which is rounded at random to 16 bits") \
    X(STORAGE_8_BIT, 0.001, "rms error of occlusion when one pass stores 12, 10 and 8 bits") \
    X(STORAGE_DIRECTIONS, 0.004, "rms error of directions, of the luma or of 1, when one pass stores 16, 10 or 8 bits") \
    X(STORAGE_SHADOW, 0.015, "rms error of shadows when one pass stores 8 bits, and lengths of history in 4, rounded at random") \
    X(MODEL, 0.002, "device against the model with all rounding, relative, after 12 frames of noise or of a picture") \
    X(MODEL_SHADOW, 0.002, "the same of shadows, rms: a step of their root in 8 bits is 0.008") \
    X(MODEL_DIRECTIONS, 0.001, "the same of directions, rms, of the luma or of 1") \
    X(VARIANCE, 0.02, "variance of filtered noise against that of the double-precision model (of shadows: of the rounding one), relative") \
    X(SAMPLES, 0.1, "variance of noise of known variance against what the effective number of samples in a value predicts, relative; of the model") \
    X(SENSE_SAMPLES, 0.002, "rms change of the picture when samples change by one step of a half (5e-4), of its mean") \
    X(CONDITION, 4, "condition number: that change over the one of the samples, both relative") \
    X(SENSE_WIDTHS, 0.006, "rms change of shadows when the widths of penumbrae change by one step of a half; a step of their root in 8 bits is 0.008") \
    X(SHADOW_CONDITION, 10, "condition number of shadows, most of it from rounding at random to 8 bits") \
    X(SENSE_MOTION, 0.02, "rms change when motion changes by 0.01 px") \
    X(SENSE_DEPTH, 0.02, "rms change when depth changes by 0.1 %") \
    X(SENSE_NORMALS, 0.04, "rms change when normals change by a step of 10 bits") \
    X(FLIPS, 0.01, "share of the pixels that change by more than 20 % of the picture's mean then") \
    X(REPEAT, 0, "values that differ when the same frames run again") \
    X(DEVICES, 0.001, "difference to another device, all channels, rms over that of the picture") \
    X(DEVICES_8_BIT, 0.0002, "the same of occlusion and shadows") \
    X(DEVICES_FLIPS, 0.001, "share of the pixels that differ from another device's by more than 20 % of that") \
    X(DENOISES, 0.5, "deviation that is left of the noise after 24 still frames") \
    X(CORRELATED, 0.95, "deviation that is left of noise that is equal over 8x8 pixels, which looks like a change of light")
typedef enum guarantee {
#define GUARANTEE_MEMBER(name, limit, text) GUARANTEE_##name,
    GUARANTEES(GUARANTEE_MEMBER)
#undef GUARANTEE_MEMBER
    GUARANTEE_COUNT
} guarantee;
const char *guarantee_name(guarantee g); /* "finite" */
const char *guarantee_text(guarantee g);
double guarantee_limit(guarantee g);

/* The worst of a guarantee for a denoiser. */
typedef struct worst {
    double measured;
    char of[96];         /* the case */
    uint32_t checks;
} worst;

typedef struct stress {
    gpu device;
    bool everything;     /* test-long */
    bool quiet, silent;  /* only what fails is printed; nothing is */
    bool markdown;
    uint32_t seed, frames, cases, one_case; /* one_case: of the random ones, by the number it failed under; 0: all */
    fault fault;
    setting_value set[16];    /* on top of the defaults */
    uint32_t set_count;
    nrd_denoiser first, last; /* to be looked at, inclusive */
    FILE *dump, *compare;     /* outputs of this device, of another; may be NULL */
    uint32_t passed, failed;
    bool seen_failing[GUARANTEE_COUNT];
    worst worst[GUARANTEE_COUNT][NRD_DENOISER_COUNT];
} stress;

/* What rig_open needs, with the options. */
rig_desc stress_rig(stress *s, nrd_denoiser denoiser, uint32_t width, uint32_t height);

/* A row of the table: passes if measured is a number and at most the guarantee's limit. */
void check(stress *s, guarantee g, const char *of, nrd_denoiser denoiser, double measured);

/* The subjects. */
void stress_extremes(stress *s);
void stress_analytic(stress *s);
void stress_energy(stress *s, nrd_denoiser denoiser); /* parts of stress_analytic; r: of MODEL_SIZE */
void stress_models(stress *s, rig *r);
void stress_space(stress *s);
void stress_sensitivity(stress *s);
void stress_agreement(stress *s);
void stress_time(stress *s);
void stress_fuzz(stress *s);

surface stress_wall(const rig *r, uint32_t x, uint32_t y);   /* slightly bumpy, with a step in depth and four roughnesses */

#define FOR_PIXELS(r) for (uint32_t y = 0; y < (r)->rect_height; y++) for (uint32_t x = 0; x < (r)->rect_width; x++)

/* ---- noise */
typedef enum noise_kind {
    NOISE_CONSTANT,
    NOISE_UNIFORM,   /* 0 to 2 */
    NOISE_SPARSE,    /* 8 in one pixel of 8 */
    NOISE_FIREFLY,   /* 1e6 times the rest in a single pixel of the picture */
    NOISE_STEP,      /* columns of 1e-4 and 1e4 in turn */
    NOISE_BLOCK,     /* uniform, equal over 8 x 8 pixels */
    NOISE_BLUE,      /* uniform, what one pixel has too much its neighbour lacks */
    NOISE_SCATTERED  /* 128 in one pixel of 128 */
} noise_kind;
/* Of mean 1 (but fireflies and steps). */
double noise_at(noise_kind kind, uint32_t x, uint32_t y, uint32_t frame, uint32_t seed);
/* Fills all noisy inputs. level: radiance, or whatever the signal's unit is. */
void fill_noise(rig *r, noise_kind kind, double level, uint32_t seed);

typedef double picture(uint32_t x, uint32_t y);
/* Fills all noisy inputs with a picture, scaled into what the signal can hold; visibility cannot be anything between. */
void fill_picture(rig *r, picture *what, double scale);

/* ---- what is measured */
typedef struct range { double low, high; } range;
typedef struct watch {
    range seen[RIG_MAX_SIGNALS];   /* of the inputs since the restart */
    double beyond, colour;         /* of the outputs */
    uint32_t not_finite, touched;
} watch;
watch watch_start(void);
void watch_inputs(watch *w, const rig *r);
void watch_outputs(watch *w, const rig *r);
guarantee range_guarantee(const rig *r); /* which one holds with its settings */
void watch_check(stress *s, const watch *w, const rig *r, const char *of);

typedef struct moments { double mean, deviation; } moments;
moments input_moments(const rig *r, uint32_t signal);   /* over the visible pixels */
moments output_moments(const rig *r, uint32_t signal);
uint32_t channels_of(const rig_signal *signal);         /* that its output has */
double noise_left(const rig *r);                        /* deviation of the output over that of the input, of the worst signal */

#endif
