/* convolve.h: separable filters of planes, edges extended. */
#ifndef EXAMPLES_CONVOLVE_H
#define EXAMPLES_CONVOLVE_H

enum { CONVOLVE_MAX_RADIUS = 16 };

/* out(x, y) = sum over i in -radius .. radius of kernel[i + radius] * in(x + i, y), or in(x, y + i). out is not in. */
void convolve_rows(const double *in, double *out, int width, int height, const double *kernel, int radius);
void convolve_columns(const double *in, double *out, int width, int height, const double *kernel, int radius);

#endif
