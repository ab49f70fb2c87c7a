/* metrics_flip.h: the LDR-FLIP difference of two pictures.

   P. Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", HPG; the numbers in brackets are its
   sections. 0: the eye sees no difference when the pictures alternate; 1: the largest difference there is. The picture is
   the tone-mapped signal, shown at 67 pixels per degree (a 0.7 m wide 4k screen seen from 0.7 m).

   colour     [4.1] opponent colours YCxCz, blurred with the eye's contrast sensitivity, Hunt-adjusted L*a*b*, HyAB distance
              to the power 0.7, mapped to [0,1]: d_c
   features   [4.2] edges and points of the luminance, first and second derivatives of a Gaussian of 0.041 degrees: d_f
   per pixel  [4.3] d_c^(1 - d_f) */
#ifndef EXAMPLES_METRICS_FLIP_H
#define EXAMPLES_METRICS_FLIP_H

#include "common/metrics.h"

/* Mean over the mask; pixels outside it are black in both. 0 when no pixel counts. False when memory is short. */
bool metrics_flip(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale, double *out);

#endif
