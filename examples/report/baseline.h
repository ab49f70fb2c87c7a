/* baseline.h: what denoisers compete with on the device: a plain spatial filter. */
#ifndef EXAMPLES_REPORT_BASELINE_H
#define EXAMPLES_REPORT_BASELINE_H

#include "common/gpu.h"
#include "common/image.h"
#include "tracer/tracer.h"

#define BASELINE_MAX_RADIUS 32

typedef struct baseline {
    tracer *t; /* holds the guides of the last frame */
    gpu *g;
    gpu_kernel spatial;
    gpu_image in, out;
    uint16_t *texels;
    float sky;
} baseline;

bool baseline_open(baseline *b, tracer *t, int width, int height, float denoising_range, char *error, size_t error_size);
void baseline_close(baseline *b); /* a zeroed one is fine */

/* Filters `m` with the guides of the tracer's last frame, in place. False with gpu_error. */
bool baseline_filter(baseline *b, int radius, image *m);

/* The radius whose median device time comes nearest to `ms`, and that time. */
bool baseline_radius_for(baseline *b, double ms, int *radius, double *filter_ms);

#endif
