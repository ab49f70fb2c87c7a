/* scene.h: the room of examples/raygen, in motion, and its camera. Metres; +y up. */
#ifndef EXAMPLES_RAYGEN_SCENE_H
#define EXAMPLES_RAYGEN_SCENE_H

#include "nrd_shaders/nrd_c.h"
#include "raygen/shared.h"

#include <stdint.h>

typedef uint32_t nrd_uint;
#define RAYGEN_X(type, name) nrd_##type name;
typedef struct raygen_frame {
    RAYGEN_FRAME(RAYGEN_X)
} raygen_frame;
typedef struct raygen_box {
    RAYGEN_BOX(RAYGEN_X)
} raygen_box;
#undef RAYGEN_X

/* The boxes at a frame, last frame's positions included. Returns how many; at most RAYGEN_MAX_BOXES. */
uint32_t raygen_scene_boxes(uint32_t frame_index, raygen_box *boxes);

/* Constants of a frame; what the scene does not know (seed, paths, box_count) is left 0. */
raygen_frame raygen_scene_frame(uint32_t frame_index, uint32_t width, uint32_t height);

#endif
