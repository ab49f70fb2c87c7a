#include "common/convolve.h"

#include <stddef.h>
#include <string.h>

static int clamped(int i, int count)
{
    return i < 0 ? 0 : i >= count ? count - 1 : i;
}

/* Both add one tap after the other to a whole run of pixels, which compilers turn into vectors. */
static void add_scaled(double *restrict out, const double *restrict in, double factor, int count)
{
    for (int x = 0; x < count; x++)
        out[x] += factor * in[x];
}

void convolve_rows(const double *in, double *out, int width, int height, const double *kernel, int radius)
{
    for (int y = 0; y < height; y++) {
        const double *from = in + (size_t)y * (size_t)width;
        double *to = out + (size_t)y * (size_t)width;
        memset(to, 0, (size_t)width * sizeof *to);
        for (int i = -radius; i <= radius; i++) {
            int first = i < 0 ? -i : 0, last = i > 0 ? width - i : width; /* pixels whose tap lies inside */
            first = clamped(first, width);
            last = last < first ? first : last;
            for (int x = 0; x < first; x++)
                to[x] += kernel[i + radius] * from[clamped(x + i, width)];
            add_scaled(to + first, from + first + i, kernel[i + radius], last - first);
            for (int x = last; x < width; x++)
                to[x] += kernel[i + radius] * from[clamped(x + i, width)];
        }
    }
}

void convolve_columns(const double *in, double *out, int width, int height, const double *kernel, int radius)
{
    memset(out, 0, (size_t)width * (size_t)height * sizeof *out);
    for (int y = 0; y < height; y++)
        for (int i = -radius; i <= radius; i++)
            add_scaled(out + (size_t)y * (size_t)width, in + (size_t)clamped(y + i, height) * (size_t)width, kernel[i + radius], width);
}
