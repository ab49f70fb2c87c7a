/* copier.h: how fast a device copies: the yardstick for what passes make of the bytes that they move.

   The fastest way of copying differs from device to device, so all are timed. A copy of few bytes stays in the device's caches
   and is faster than its memory; one of very few bytes is all start-up. */
#ifndef EXAMPLES_REPORT_COPIER_H
#define EXAMPLES_REPORT_COPIER_H

#include "common/gpu.h"

/* X(enumerator, name) */
#define COPIER_WAYS(X) X(BUFFERS, "shader, buffers") X(IMAGES, "shader, images") X(TRANSFER, "vkCmdCopyBuffer")
typedef enum copier_way {
#define COPIER_WAY(id, name) COPIER_##id,
    COPIER_WAYS(COPIER_WAY)
#undef COPIER_WAY
    COPIER_WAY_COUNT
} copier_way;

typedef struct copier {
    gpu *g;
    gpu_kernel buffers, images;
    gpu_buffer from, to;          /* of the device alone */
    gpu_image image_from, image_to;
    uint32_t capacity;            /* words of 16 bytes; larger copies go over them again */
} copier;

/* For copies that move up to about `bytes` in all, half of them read, half written. False with gpu_error. */
bool copier_open(copier *c, gpu *g, double bytes);
void copier_close(copier *c); /* a zeroed one is fine */

/* Device time of one copy. False with gpu_error. */
bool copier_run(copier *c, copier_way way, double bytes, double *ms);

const char *copier_way_name(copier_way way);

#endif
