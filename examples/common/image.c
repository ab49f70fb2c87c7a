#include "common/image.h"

#include <stdlib.h>
#include <string.h>

bool image_create(image *out, int width, int height, int channels)
{
    memset(out, 0, sizeof *out);
    out->width = width;
    out->height = height;
    out->channels = channels;
    for (int k = 0; k < channels; k++) {
        out->planes[k] = calloc(image_pixels(out), sizeof(float));
        if (!out->planes[k]) {
            image_destroy(out);
            return false;
        }
    }
    return true;
}

void image_destroy(image *m)
{
    for (int k = 0; k < 3; k++)
        free(m->planes[k]);
    memset(m, 0, sizeof *m);
}

size_t image_pixels(const image *m)
{
    return (size_t)m->width * (size_t)m->height;
}

double image_luminance(const image *m, size_t pixel)
{
    if (m->channels == 1)
        return m->planes[0][pixel];
    return 0.2126 * m->planes[0][pixel] + 0.7152 * m->planes[1][pixel] + 0.0722 * m->planes[2][pixel];
}
