/* bvh.h: bounding volume hierarchy over the triangles of a posed scene, for the compute shader. */
#ifndef EXAMPLES_TRACER_BVH_H
#define EXAMPLES_TRACER_BVH_H

#include "scenes/scene.h"

enum { BVH_MAX_DEPTH = 40 }; /* depth that the shader's stack allows for */

typedef struct bvh {
    pt_node *nodes; /* the root is node 0 */
    uint32_t node_count;
    uint32_t *order; /* leaves name runs of this permutation of the triangles */
} bvh;

/* Binned surface area heuristic (Wald, "On Fast Construction of SAH-based Bounding Volume Hierarchies", 2007). False
   when memory is short or there is no triangle. */
bool bvh_build(const pt_scene *scene, bvh *out);
void bvh_free(bvh *b);

#endif
