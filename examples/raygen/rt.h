/* rt.h: the ray tracing pipeline of examples/raygen on the device of a `gpu`: acceleration structures of boxes, pipeline, shader
   binding table. Functions that return bool leave a one-line reason in rt_error() on failure. */
#ifndef EXAMPLES_RAYGEN_RT_H
#define EXAMPLES_RAYGEN_RT_H

#include "common/gpu.h"
#include "raygen/scene.h"

/* The first device with ray tracing pipelines, opened with what they need. *none: no device has them, and `error` says what the last
   one lacks; if it is false and so is the result, opening failed. */
bool rt_open_device(gpu *g, const gpu_desc *desc, bool *none, char *error, size_t error_size);

typedef struct rt rt;

/* images: what RAYGEN_BIND_MV to RAYGEN_BIND_EMISSION name, in that order. NULL on failure, with the reason in gpu's `error`. */
rt *rt_create(gpu *g, const gpu_buffer *frame, const gpu_buffer *boxes, const gpu_image *const images[6], char *error,
              size_t error_size);
void rt_destroy(rt *r); /* NULL is fine */

/* Moves the boxes; not while the device works. */
void rt_place(rt *r, const raygen_box *boxes, uint32_t count);

/* Records the build of the structure over the boxes that rt_place has moved, then one ray generation per pixel. */
void rt_record(rt *r, VkCommandBuffer cmd, uint32_t box_count, uint32_t width, uint32_t height);

#endif
