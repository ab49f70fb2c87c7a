/* thin.h: makes from a frame that has a diffuse and a specular path in every pixel what a renderer with one path for both has. */
#ifndef EXAMPLES_THIN_H
#define EXAMPLES_THIN_H

#include "common/capture.h"

/* In every pixel one lobe stays, drawn with the share that its demodulation factor has of both (one half where the frame has no factors),
   in the ordered pattern of nrd.glsl, radius 1: its light is divided by that probability, the other's light and hit distance become 0.
   `index` is the frame's. False where the frame lacks radiance or hit distance of a lobe. */
bool thin_lobes(capture *frame, uint32_t index);

#endif
