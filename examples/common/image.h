/* image.h: a small planar float image, one channel (shadow, ambient occlusion) or three (RGB). */
#ifndef EXAMPLES_IMAGE_H
#define EXAMPLES_IMAGE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct image {
    int width, height;
    int channels;     /* 1 or 3; 0: no image */
    float *planes[3]; /* width * height each, row 0 on top; NULL beyond `channels` */
} image;

/* Black. False, and a zeroed image, when memory is short. */
bool image_create(image *out, int width, int height, int channels);

/* A zeroed image is allowed; the image is zeroed. */
void image_destroy(image *m);

size_t image_pixels(const image *m);

/* Luminance of a linear pixel: Rec. 709 weights (0.2126, 0.7152, 0.0722), or the channel itself where there is one. */
double image_luminance(const image *m, size_t pixel);

#endif
