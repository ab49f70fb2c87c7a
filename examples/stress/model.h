/* model.h: what the passes of four denoisers compute, in double precision, where geometry plays no part: on a wall that faces a still
   camera (and the light), without antilag. What 32 bits in registers and the few bits
   that are stored cost can be switched on pass by pass. */
#ifndef STRESS_MODEL_H
#define STRESS_MODEL_H

#include "nrd.h"

#include "common/settings.h"

enum { MODEL_SIZE = 32, MODEL_PIXELS = MODEL_SIZE * MODEL_SIZE, MODEL_MOST_PASSES = 5 };

/* ---- rounding */
typedef struct model_passes { uint32_t single, stored; } model_passes;    /* bits of those that compute in 32 bits; that store what the device stores */
typedef struct model_rounding { bool single, stored; } model_rounding;    /* of one pass */
model_rounding model_rounding_of(model_passes passes, uint32_t pass);

/* What a pass computes, stands in its registers. */
double reg(model_rounding r, double v);
/* Halves: the nearest; at random, random of 24 bits. */
double store_half(model_rounding r, double v);
double store_half_dithered(model_rounding r, double v, uint32_t random);
/* A number from 0 to 1 in so many steps, rounded down after random [0,1) has been added. */
double store_steps(model_rounding r, double v, double steps, double random);
/* The hash of all passes. */
uint32_t model_hash(uint32_t x, uint32_t y, uint32_t z);

/* ---- REBLUR_DIFFUSE, REBLUR_SPECULAR */
#define REBLUR_MODEL_PASSES(X) X(ACCUMULATION, "temporal accumulation") X(BLUR, "blur") X(POST_BLUR_1, "post-blur 1") X(POST_BLUR_2, "post-blur 2") X(STABILIZATION, "stabilization")
typedef enum reblur_model_pass {
#define MODEL_MEMBER(name, text) REBLUR_MODEL_##name,
    REBLUR_MODEL_PASSES(MODEL_MEMBER)
#undef MODEL_MEMBER
    REBLUR_MODEL_PASS_COUNT
} reblur_model_pass;

/* Luma, and the deviation of one sample (history) or of the value (filters). */
typedef struct model_texel { double luma, sigma; } model_texel;

typedef struct reblur_model {
    model_passes passes;
    nrd_reblur_settings settings;
    bool endless;                        /* the picture goes on with itself on the other side: no light gets lost at its border */
    bool specular;                       /* lobes of roughness 0.5 */
    double footprint[MODEL_PIXELS];      /* specular: what a lobe sees, px */
    double frames;                       /* length of history, of all pixels */
    double sum[REBLUR_MODEL_PASS_COUNT]; /* of the luma of all pixels, after each pass of the last frame */
    model_texel history[MODEL_PIXELS];
    double stabilized[MODEL_PIXELS];     /* luma of the last frame's output */
    model_texel out[MODEL_PIXELS];
} reblur_model;

/* ---- REBLUR_DIFFUSE_OCCLUSION */
typedef struct occlusion_model {
    model_passes passes;
    nrd_occlusion_settings settings;
    double frames;
    double history[MODEL_PIXELS];        /* mean of normalised hit distances */
    double radius[MODEL_PIXELS];         /* harmonic mean of those around */
    double out[MODEL_PIXELS];
} occlusion_model;

/* ---- SIGMA_SHADOW */
typedef struct shadow_word {
    double mean;                         /* visibility */
    double age;                          /* frames that there has been a penumbra; 0: a ray as it is */
    double width;                        /* half width of the penumbra, of a blocked ray where there is none, px */
    bool placed;                         /* its depth is known: not in tiles without a penumbra */
    double stabilized;                   /* visibility as shown; before the blur: in the frame before */
} shadow_word;

typedef struct shadow_model {
    model_passes passes;
    nrd_sigma_settings settings;
    bool started;
    shadow_word history[MODEL_PIXELS];
    double out[MODEL_PIXELS];
} shadow_model;
#define MODEL_LIT 1e6                    /* as a half width */

/* ---- any */
typedef union any_model { reblur_model reblur; occlusion_model occlusion; shadow_model shadow; } any_model;

/* At the distance that the rig puts walls at: units along the view axis, and of a pixel there. */
#define MODEL_DEPTH 10.0
#define MODEL_PIXEL_UNITS (MODEL_DEPTH / MODEL_SIZE)
#define MODEL_HIT_DIST 0.5               /* normalised, of samples of radiance */

typedef struct model_kind {
    nrd_denoiser denoiser;
    uint32_t pass_count;
    const char *names[MODEL_MOST_PASSES]; /* of the passes */
    void (*start)(any_model *m, const any_settings *settings, model_passes passes);
    /* in: rows from the top: luma; normalised hit distances above 0; half widths of penumbrae in px, or MODEL_LIT. */
    void (*frame)(any_model *m, const double *in, uint32_t frame_index);
    double (*value)(const any_model *m, uint32_t pixel); /* of the last frame's output */
} model_kind;
extern const model_kind reblur_model_kind, specular_model_kind, occlusion_model_kind, shadow_model_kind;

#endif
