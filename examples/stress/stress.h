/* stress.h: what the subjects of nrd-stress share: options, the guarantees with their limits, the table, noise, and what is measured of
   an output. */
#ifndef STRESS_H
#define STRESS_H

#include "stress/rig.h"

/* X(name, most that may be measured, text). A guarantee has one limit, whatever the case; where the denoisers need different ones there are
   as many guarantees. */
#define GUARANTEES(X) \
    X(FINITE, 0, "pixels that are not finite") \
    X(RANGE, 0.002, "output beyond the range of all inputs since the restart, relative, without antilag") \
    X(ANTILAG_RANGE, 3, "the same with antilag, which may scale history by up to 4") \
    X(COLOUR, 0.01, "negative colour, hit distance beyond [0,1], direction longer than its length; of the luma") \
    X(UNTOUCHED, 0, "pixels of the sky or outside of the rectangle that were written") \
    X(REFUSALS, 0, "wrong calls that were accepted, or refused without naming what is wrong; right ones that were refused") \
    X(DENOISES, 0.5, "deviation that is left of the noise after 24 still frames")
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
    bool quiet;          /* only what fails is printed */
    uint32_t seed, frames, cases;
    fault fault;
    nrd_denoiser first, last; /* to be looked at, inclusive */
    uint32_t passed, failed;
    bool seen_failing[GUARANTEE_COUNT];
    worst worst[GUARANTEE_COUNT][NRD_DENOISER_COUNT];
} stress;

/* A row of the table: passes if measured is a number and at most the guarantee's limit. */
void check(stress *s, guarantee g, const char *of, nrd_denoiser denoiser, double measured);

/* The subjects. */
void stress_extremes(stress *s);
void stress_fuzz(stress *s);

#define FOR_PIXELS(r) for (uint32_t y = 0; y < (r)->rect_height; y++) for (uint32_t x = 0; x < (r)->rect_width; x++)

/* ---- noise */
typedef enum noise_kind {
    NOISE_CONSTANT,
    NOISE_UNIFORM,   /* 0 to 2 */
    NOISE_SPARSE,    /* 8 in one pixel of 8 */
    NOISE_FIREFLY,   /* 1e6 times the rest in a single pixel of the picture */
    NOISE_STEP,      /* columns of 1e-4 and 1e4 in turn */
    NOISE_BLOCK,     /* uniform, equal over 8 x 8 pixels */
    NOISE_BLUE       /* uniform, what one pixel has too much its neighbour lacks */
} noise_kind;
/* Of mean 1 (but fireflies and steps). */
double noise_at(noise_kind kind, uint32_t x, uint32_t y, uint32_t frame, uint32_t seed);
/* Fills all noisy inputs. level: radiance, or whatever the signal's unit is. */
void fill_noise(rig *r, noise_kind kind, double level, uint32_t seed);

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
void watch_check(stress *s, const watch *w, const rig *r, const char *of);

typedef struct moments { double mean, deviation; } moments;
moments input_moments(const rig *r, uint32_t signal);   /* over the visible pixels */
moments output_moments(const rig *r, uint32_t signal);

#endif
