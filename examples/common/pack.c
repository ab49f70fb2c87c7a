#include "common/pack.h"

#include "common/half.h"

#include <math.h>
#include <stdbool.h>

/* Roughness carries the sign of the normal's z and stays this far from 0, so that the sign survives 10 bits. */
#define ROUGHNESS_MIN (1.5f / 512.0f)

static float clamp(float x, float low, float high)
{
    return x > low ? (x < high ? x : high) : low; /* NaN: low */
}

static uint32_t unorm10(float x)
{
    return (uint32_t)(clamp(x, 0, 1) * 1023.0f + 0.5f);
}

uint32_t pack_normal_roughness(const float normal[3], float roughness, uint32_t material_id)
{
    bool finite_normal = isfinite(normal[0]) && isfinite(normal[1]) && isfinite(normal[2]);
    float length = fabsf(normal[0]) + fabsf(normal[1]) + fabsf(normal[2]), r = isfinite(roughness) ? clamp(roughness, 0, 1) : 1;
    float scale = finite_normal ? 1.0f / fmaxf(length, 1e-6f) : 0.0f;
    float x = finite_normal ? normal[0] * scale : 0, y = finite_normal ? normal[1] * scale : 0;
    float signed_roughness = fmaxf(r, ROUGHNESS_MIN) * (finite_normal && normal[2] < 0 ? -1.0f : 1.0f);
    uint32_t red = unorm10((x + y) * 0.5f + 0.5f), green = unorm10((y - x) * 0.5f + 0.5f);
    uint32_t blue = unorm10(signed_roughness * 0.5f + 0.5f), alpha = material_id < 3 ? material_id : 3;
    return red | green << 10 | blue << 20 | alpha << 30;
}

float pack_normalize_hit_dist(float hit_dist, float view_z, float roughness, const float parameters[4])
{
    if (!(hit_dist > 0))
        return 0;
    if (hit_dist >= HALF_MAX)
        return 1;
    float decay = clamp(exp2f(parameters[3] * roughness * roughness), 0, 1);
    float scale = (parameters[0] + fabsf(view_z) * parameters[1]) * (1 + (parameters[2] - 1) * decay);
    return clamp(hit_dist / scale, 0, 1);
}

void pack_radiance_hit_dist(const float rgb[3], float norm_hit_dist, uint16_t texel[4])
{
    bool valid = isfinite(rgb[0]) && isfinite(rgb[1]) && isfinite(rgb[2]);
    float limit = valid ? HALF_MAX : 0, r = clamp(rgb[0], 0, limit), g = clamp(rgb[1], 0, limit), b = clamp(rgb[2], 0, limit);
    texel[0] = half_from_float(0.25f * r + 0.5f * g + 0.25f * b);
    texel[1] = half_from_float(0.5f * (r - b));
    texel[2] = half_from_float(0.5f * g - 0.25f * (r + b));
    texel[3] = half_from_float(isfinite(norm_hit_dist) ? clamp(norm_hit_dist, 0, 1) : 0);
}

void pack_unpack_radiance_hit_dist(const uint16_t texel[4], float rgbw[4])
{
    float y = half_to_float(texel[0]), co = half_to_float(texel[1]), cg = half_to_float(texel[2]), t = y - cg;
    rgbw[0] = fmaxf(t + co, 0);
    rgbw[1] = fmaxf(y + cg, 0);
    rgbw[2] = fmaxf(t - co, 0);
    rgbw[3] = half_to_float(texel[3]);
}
