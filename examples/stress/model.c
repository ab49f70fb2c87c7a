#include "stress/model.h"

#include <math.h>
#include <string.h>

static uint32_t bits_of(float f) { uint32_t u; memcpy(&u, &f, 4); return u; }
static double number_of(uint32_t u) { float f; memcpy(&f, &u, 4); return f; }

model_rounding model_rounding_of(model_passes passes, uint32_t pass)
{
    model_rounding r = { (passes.single >> pass & 1u) != 0, (passes.stored >> pass & 1u) != 0 };
    return r;
}

double store_half(model_rounding r, double v)
{
    float raised = (float)v + 0.75f;
    return r.stored ? number_of((bits_of(raised - 0.75f) + 0x1000u) & 0xffffe000u) : v;
}

double store_half_dithered(model_rounding r, double v, uint32_t random)
{
    return r.stored ? number_of((bits_of((float)v) + (random >> 11)) & 0xffffe000u) : v;
}

double store_steps(model_rounding r, double v, double steps, double random)
{
    return r.stored ? floor(fmin(fmax(v, 0), 1) * steps + random) / steps : v;
}

uint32_t model_hash(uint32_t x, uint32_t y, uint32_t z)
{
    uint32_t h = x * 0x9e3779b1u + y * 0x85ebca77u + z * 0xc2b2ae3du;
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return h ^ (h >> 16);
}

/* ---- the wall */
double model_camera_distance(int pixel)
{
    double x = (pixel % MODEL_SIZE + 0.5 - MODEL_SIZE / 2) * MODEL_PIXEL_UNITS, y = (pixel / MODEL_SIZE + 0.5 - MODEL_SIZE / 2) * MODEL_PIXEL_UNITS;
    return sqrt(x * x + y * y + MODEL_DEPTH * MODEL_DEPTH);
}

double model_hit_dist_scale(double a, double b, double c, double d, double roughness)
{
    return (a + MODEL_DEPTH * b) * (1 + (c - 1) * exp2(d * roughness * roughness));
}
