/* model.h: what the passes of all denoisers compute, in double precision, where geometry plays no part: on a wall that faces a still
   camera (and the light), without antilag. What 32 bits in registers and the few bits that are stored cost can be switched on pass by pass. */
#ifndef STRESS_MODEL_H
#define STRESS_MODEL_H

#include "nrd.h"

#include "common/settings.h"

enum { MODEL_SIZE = 32, MODEL_PIXELS = MODEL_SIZE * MODEL_SIZE, MODEL_MOST_PASSES = 5, MODEL_MOST_LANES = 12, MODEL_MOST_SIGNALS = 2 };

/* ---- rounding */
typedef struct model_passes { uint32_t single, stored; } model_passes;    /* bits of those that compute in 32 bits; that store what the device stores */
typedef struct model_rounding { bool single, stored; } model_rounding;    /* of one pass */
model_rounding model_rounding_of(model_passes passes, uint32_t pass);

/* What a pass computes, stands in its registers. */
static inline double reg(model_rounding r, double v) { return r.single ? (double)(float)v : v; }
/* Halves: the nearest; at random, random of 24 bits. */
double store_half(model_rounding r, double v);
double store_half_dithered(model_rounding r, double v, uint32_t random);
/* A number from 0 to 1 in so many steps, rounded down after random [0,1) has been added. */
double store_steps(model_rounding r, double v, double steps, double random);
/* The hash of all passes. */
uint32_t model_hash(uint32_t x, uint32_t y, uint32_t z);

/* ---- the wall */
/* At the distance that the rig puts walls at: units along the view axis, and of a pixel there; its roughness as 10 bits hold it. */
#define MODEL_DEPTH 10.0
#define MODEL_PIXEL_UNITS (MODEL_DEPTH / MODEL_SIZE)
#define MODEL_ROUGHNESS (511.0 / 1023)
#define MODEL_HIT_DIST 0.5               /* normalised, of samples of radiance */
double model_camera_distance(int pixel);
/* Units per normalised hit distance. */
double model_hit_dist_scale(double a, double b, double c, double d, double roughness);

/* ---- REBLUR of radiance, SH too */
#define REBLUR_MODEL_PASSES(X) X(ACCUMULATION, "temporal accumulation") X(BLUR, "blur") X(POST_BLUR_1, "post-blur 1") X(POST_BLUR_2, "post-blur 2") X(STABILIZATION, "stabilization")
typedef enum reblur_model_pass {
#define MODEL_MEMBER(name, text) REBLUR_MODEL_##name,
    REBLUR_MODEL_PASSES(MODEL_MEMBER)
#undef MODEL_MEMBER
    REBLUR_MODEL_PASS_COUNT
} reblur_model_pass;

/* Luma, Co, Cg, and direction relative to luma; the deviation of one sample's luma (history) or of the value's (filters). */
enum { MODEL_CHROMA = 1, MODEL_LIGHT = 3, MODEL_COMPONENTS = 6 };
typedef struct model_texel { double v[MODEL_COMPONENTS], sigma; } model_texel;

typedef struct reblur_signal {
    bool specular;                       /* lobes of MODEL_ROUGHNESS */
    double footprint[MODEL_PIXELS];      /* specular: what a lobe sees, px */
    double sum[REBLUR_MODEL_PASS_COUNT]; /* of the luma of all pixels, after each pass of the last frame */
    model_texel history[MODEL_PIXELS];
    double stabilized[MODEL_PIXELS];     /* luma of the last frame's output */
    model_texel out[MODEL_PIXELS];
} reblur_signal;

typedef struct reblur_model {
    model_passes passes;
    nrd_reblur_settings settings;
    bool endless;                        /* the picture goes on with itself on the other side: no light gets lost at its border */
    int components;                      /* of texels: luma alone, with chroma, with directions */
    double frames;                       /* length of history, of all pixels */
    uint32_t signal_count;
    reblur_signal signals[MODEL_MOST_SIGNALS];
} reblur_model;

/* ---- REBLUR of occlusion */
/* Mean of normalised hit distances, and of those times direction. */
enum { MODEL_MOMENT = 1, MODEL_OPENNESS = 4 };
typedef struct occlusion_lobe {
    bool specular;
    double history[MODEL_OPENNESS][MODEL_PIXELS];
    double radius[MODEL_PIXELS];         /* harmonic mean of those around */
    double out[MODEL_OPENNESS][MODEL_PIXELS];
} occlusion_lobe;

typedef struct occlusion_model {
    model_passes passes;
    nrd_occlusion_settings settings;
    int components;                      /* with or without moments */
    double frames;
    uint32_t lobe_count;
    occlusion_lobe lobes[MODEL_MOST_SIGNALS];
} occlusion_model;

/* ---- SIGMA */
enum { MODEL_COLORS = 3 };
typedef struct shadow_word {
    double mean[MODEL_COLORS];           /* visibility */
    double age;                          /* frames that there has been a penumbra; 0: a ray as it is */
    double width;                        /* half width of the penumbra, of a blocked ray where there is none, px */
    bool placed;                         /* its depth is known: not in tiles without a penumbra */
    double stabilized;                   /* luma as shown; before the blur: in the frame before */
} shadow_word;

typedef struct shadow_model {
    model_passes passes;
    nrd_sigma_settings settings;
    int colors;                          /* 1, or 3 */
    bool started;
    shadow_word history[MODEL_PIXELS];
    double out[MODEL_COLORS][MODEL_PIXELS];
} shadow_model;
#define MODEL_LIT 1e6                    /* as a half width */

/* ---- REFERENCE */
typedef struct reference_model {
    model_passes passes;
    double max_frames, frames;
    double mean[4][MODEL_PIXELS];
} reference_model;

/* ---- any */
typedef union any_model { reblur_model reblur; occlusion_model occlusion; shadow_model shadow; reference_model reference; } any_model;

/* A number per pixel that goes in, and where it comes out. */
typedef enum lane_role {
    LANE_VALUE,      /* luma; normalised hit distance above 0; half width of a penumbra in px, or MODEL_LIT */
    LANE_PART,       /* may have either sign and be so much of the value at most: chroma */
    LANE_DIRECTION,  /* the same, of which three are no longer than the value */
    LANE_COLOR       /* from 0 to 1, in 8 bits */
} lane_role;
typedef struct model_lane {
    nrd_resource in, out;                /* out: NRD_RESOURCE_COUNT: nowhere of its own */
    uint32_t channel;
    lane_role role;
    uint32_t of;                         /* the lane that has the value */
} model_lane;

typedef enum model_part { MODEL_DIFFUSE = 1, MODEL_SPECULAR = 2, MODEL_DIRECTIONS = 4, MODEL_COLORED = 8 } model_part;

typedef struct model_kind model_kind;
struct model_kind {
    nrd_denoiser denoiser;
    uint32_t parts;                      /* of model_part */
    uint32_t pass_count;
    const char *names[MODEL_MOST_PASSES]; /* of the passes */
    uint32_t lane_count;
    model_lane lanes[MODEL_MOST_LANES];
    void (*start)(any_model *m, const model_kind *kind, const any_settings *settings, model_passes passes);
    void (*frame)(any_model *m, double (*in)[MODEL_PIXELS], uint32_t frame_index);  /* in: lanes of rows from the top */
    double (*value)(const any_model *m, uint32_t lane, uint32_t pixel);             /* of the last frame's output */
};

enum { REBLUR_MODEL_KINDS = 6, OCCLUSION_MODEL_KINDS = 4, SHADOW_MODEL_KINDS = 2 };
extern const model_kind reblur_model_kinds[REBLUR_MODEL_KINDS];      /* the first: REBLUR_DIFFUSE */
extern const model_kind occlusion_model_kinds[OCCLUSION_MODEL_KINDS];
extern const model_kind shadow_model_kinds[SHADOW_MODEL_KINDS];
extern const model_kind reference_model_kind;

#endif
