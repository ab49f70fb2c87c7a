/* bench.h: denoisers on a synthetic scene, for times alone: a floor, a wall with bumps on it, sparse noise, a still camera, and as
   much sky as is wanted. */
#ifndef EXAMPLES_REPORT_BENCH_H
#define EXAMPLES_REPORT_BENCH_H

#include "common/gpu.h"
#include "nrd_vk.h"

#include <stdbool.h>

enum { BENCH_NOISES = 4, BENCH_MAX_PASSES = 64 };

typedef struct bench_scene {
    uint32_t width, height;
    float penumbra;  /* share of the pixels that lie in a penumbra, for shadows; the rest is lit and dark in equal parts */
    float sky;       /* share of the picture that is sky, from the top */
    float rough;     /* share of the picture, from the left, that is too rough for a specular signal, where NRD_FEATURE_ROUGHNESS_LIMIT is declared */
} bench_scene;

/* Inputs, and outputs of all that runs on them: denoisers take turns. */
typedef struct bench {
    gpu *g;
    bench_scene scene;
    gpu_image images[NRD_RESOURCE_COUNT], noise[BENCH_NOISES], rays[BENCH_NOISES];
} bench;

/* One instance on a bench. */
typedef struct bench_run {
    bench *b;
    nrd *instance;
    nrd_vk *runtime;
    uint32_t frame;     /* index of the next one */
    bool everything;    /* the frames ask for split screen and overlay; the instance has these features */
    double creation_ms; /* of the runtime: pipelines without a cache, images, descriptors */
} bench_run;

/* False with gpu_error. */
bool bench_open(bench *b, gpu *g, const bench_scene *scene);
bool bench_set_sky(bench *b, float sky);
void bench_close(bench *b); /* after all that runs on it */

/* Share of the tiles of 8x8 pixels that are not all sky. */
double bench_active_tiles(const bench_scene *scene);

/* An instance with the normals and the sun of the scene; those of `desc` are replaced. */
nrd_result bench_instance(const nrd_desc *desc, nrd **out);

/* Settings and frames with which every pass runs that is optional, for which the instance has to have its features. */
#define BENCH_OPTIONAL (NRD_FEATURE_PREPASS | NRD_FEATURE_SPLIT_SCREEN | NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION | NRD_FEATURE_CHECK | NRD_FEATURE_VALIDATION)
bool bench_run_everything(bench_run *run);

/* The instance becomes the run's, also where it fails. */
bool bench_run_open(bench_run *run, bench *b, nrd *instance);
void bench_run_close(bench_run *run); /* a zeroed one is fine */

/* One frame, and the device times of its passes. */
bool bench_run_frame(bench_run *run, nrd_vk_timing timings[BENCH_MAX_PASSES], uint32_t *passes);

/* Dispatches of a frame, without running it. */
bool bench_dispatches(nrd *instance, uint32_t frame, const nrd_dispatch **dispatches, uint32_t *count);

double bench_bytes_per_pixel(const bench_run *run);

#endif
