/* metrics_guides.h: what metrics need to know of the surfaces in a frame: where they are, and where they were. */
#ifndef EXAMPLES_METRICS_GUIDES_H
#define EXAMPLES_METRICS_GUIDES_H

#include "common/capture.h"

typedef struct guides {
    const capture *frame;
    const float *view_z, *material; /* material may be NULL */
    float *normal[3], *motion[3];   /* motion only where it was asked for */
} guides;

/* False when the frame lacks depth, normals or, where needed, motion. */
bool guides_find(const capture *frame, bool needs_motion, guides *out);

/* Whether pixel j of the frame before shows the surface that pixel i shows now: depth within 2 % of what the motion says,
   normals within 37 degrees (dot >= 0.8), same material, not the sky. */
bool guides_same_surface(const guides *then, size_t j, const guides *now, size_t i);

/* Whether two pixels may lie on one surface: same material, normals within 37 degrees, both sky or neither. */
bool guides_are_alike(const guides *a, size_t i, const guides *b, size_t j);

/* The pixel that covers the previous place of (x, y); false when that lay outside the picture. */
bool guides_previous_pixel(const guides *now, int x, int y, size_t *out);

#endif
