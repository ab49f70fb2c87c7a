#include "report/statistics.h"

#include <math.h>
#include <stdlib.h>

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double quantile(double *values, int count, double share)
{
    if (count < 1)
        return NAN;
    qsort(values, (size_t)count, sizeof *values, ascending);
    double at = share * (count - 1);
    int low = (int)at, high = low + 1 < count ? low + 1 : low;
    return values[low] + (at - low) * (values[high] - values[low]);
}

double quartiles(double *values, int count, double *low, double *high)
{
    *low = quantile(values, count, 0.25);
    *high = quantile(values, count, 0.75);
    return quantile(values, count, 0.5);
}

uint64_t fingerprint(uint64_t hash, const void *bytes, size_t size)
{
    const unsigned char *b = bytes;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ b[i]) * 0x100000001b3u;
    return hash;
}
