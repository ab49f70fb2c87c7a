/* metrics_faults.h: faults that an average hides: fireflies, edges, the worst place, lag, ghosts. d, r, L, tm as in
   metrics.h; the definitions are this project's own.

   fireflies  pixels with L(d) > 3 * (largest L(r) within 2 pixels) + 0.05 / exposure: brighter than anything near
   edges      pixels within some distance of a geometric edge: two neighbours of different material, sky beside surface,
              normals more than 37 degrees apart (dot < 0.8), or a view depth that leaves the line through the neighbours
              on both sides by more than 2 %
   worst tile the largest tm RMSE of all 32 x 32 tiles at least half of which counts
   lag        frames until mean L(d) has gone 90 % of the way from the mean before a light step to the mean after it,
              linear between frames; 0: in the first frame of the new light
   ghosts     over pixels whose surface was hidden one frame before (other depth, normal or material at the previous
              place): sum of w (L(d) - L(r)) (L(g) - L(r)) / sum of w (L(g) - L(r))^2, g the reference of the frame before at
              the previous place, w = 1 / (L(r)^2 + L(g)^2 + 0.01): 0 nothing of what was there before shines through, 1 all
              of it. Linear in d: noise does not pass for a ghost */
#ifndef EXAMPLES_METRICS_FAULTS_H
#define EXAMPLES_METRICS_FAULTS_H

#include "common/metrics.h"

#define METRICS_TILE 32
#define METRICS_LAG_SHARE 0.9

/* Sums over frames. */
typedef struct metrics_ghost {
    double along, square; /* the residual is along / square */
    long pixels;
} metrics_ghost;

long metrics_count_fireflies(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale);

/* Clears the pixels of `mask` that are farther than `radius` (0..64, largest of dx and dy) from every edge of the frame's
   guides. A frame without guides has no edges. False when memory is short. */
bool metrics_keep_edges(const capture *frame, int radius, unsigned char *mask);

/* 0 when no tile counts. */
double metrics_worst_tile(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale);

/* response[i]: how far frame i after the step is from the old light (0) to the new one (1). `count` when it stays below. */
double metrics_lag(const double *response, int count);

/* Adds the pixels of frame `now`; nothing when it starts a shot, lacks guides, or the sizes differ. */
void metrics_add_ghost(const capture *then, const image *reference_then, const capture *now, const image *m, const image *reference,
                       const unsigned char *mask, metrics_ghost *ghost);

#endif
