/* tracer.h: what the two path tracers have in common. Both run the maths of primary.glsl and path.glsl; they differ in
   how a ray meets the triangles: Embree on the CPU, or a bounding volume hierarchy in a Vulkan compute shader. */
#ifndef EXAMPLES_TRACER_TRACER_H
#define EXAMPLES_TRACER_TRACER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "scenes/scene.h"

typedef struct tracer tracer;

/* Functions that return false write one line to `error`. */
struct tracer {
    const char *name;
    void *state;
    /* Takes over the geometry of a posed scene; needed before the other calls and after every pose. */
    bool (*load)(tracer *t, pt_scene *scene, char *error, size_t error_size);
    /* One noisy frame: PT_PLANE_COUNT planes of width x height floats. */
    bool (*render)(tracer *t, const pt_scene *scene, float *planes, char *error, size_t error_size);
    /* Adds the samples frame.sample_first ... + frame.sample_count - 1 of the reference to PT_REF_COUNT planes of sums.
       Samples are those of a sequence: all from 0 on are needed for a converged mean. */
    bool (*accumulate)(tracer *t, const pt_scene *scene, double *sums, char *error, size_t error_size);
    void (*close)(tracer *t);
};

/* threads: 1 to 64. */
bool tracer_open_embree(tracer *t, int threads, char *error, size_t error_size);

/* device: position in the order in which Vulkan lists devices; -1: the first. */
bool tracer_open_vulkan(tracer *t, int device, char *error, size_t error_size);

#endif
