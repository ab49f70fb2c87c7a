/* model.h: REBLUR_DIFFUSE on a wall that faces a still camera, without antilag and stabilisation, in double precision: what the passes
   compute where geometry plays no part. Rounding to 32 bits and to stored 16 bits can be switched on pass by pass, which tells what each
   costs, and the sum of light after each pass can be read. */
#ifndef STRESS_MODEL_H
#define STRESS_MODEL_H

#include "nrd.h"

/* In order. */
#define MODEL_PASSES(X) X(ACCUMULATION, "temporal accumulation") X(BLUR, "blur") X(POST_BLUR_1, "post-blur 1") X(POST_BLUR_2, "post-blur 2") X(STABILIZATION, "stabilization")
typedef enum model_pass {
#define MODEL_MEMBER(name, text) MODEL_##name,
    MODEL_PASSES(MODEL_MEMBER)
#undef MODEL_MEMBER
    MODEL_PASS_COUNT
} model_pass;
const char *model_pass_name(model_pass pass);

enum { MODEL_SIZE = 32, MODEL_PIXELS = MODEL_SIZE * MODEL_SIZE };

/* Luma, and the deviation of one sample (history) or of the value (filters). */
typedef struct model_texel { double luma, sigma; } model_texel;

typedef struct model {
    uint32_t single, half;              /* bits of the passes that round */
    nrd_reblur_settings settings;
    bool endless;                       /* the picture goes on with itself on the other side: no light gets lost at its border */
    double frames;                      /* length of history, of all pixels */
    double sum[MODEL_PASS_COUNT];       /* of the luma of all pixels, after each pass of the last frame */
    model_texel history[MODEL_PIXELS];
    model_texel out[MODEL_PIXELS];
} model;

void model_start(model *m, const nrd_reblur_settings *settings, uint32_t single, uint32_t half);
/* noisy: luma, rows from the top. */
void model_frame(model *m, const double *noisy, uint32_t frame_index);

#endif
