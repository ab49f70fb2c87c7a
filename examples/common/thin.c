#include "common/thin.h"

#include "nrd_shaders/nrd_c.h"

typedef struct lobe_planes {
    float *color[3], *hit;
    float *factor[3]; /* NULL: unknown */
} lobe_planes;

static bool find_lobe(const capture *frame, const char *color, const char *hit, const char *factor, lobe_planes *out)
{
    out->factor[0] = NULL;
    capture_find_planes(frame, factor, "RGB", out->factor);
    out->hit = capture_find_plane(frame, hit);
    return out->hit && capture_find_planes(frame, color, "RGB", out->color);
}

static float brightness(const lobe_planes *lobe, size_t i)
{
    return lobe->factor[0] ? lobe->factor[0][i] + lobe->factor[1][i] + lobe->factor[2][i] : 1.0f;
}

static void scale_sample(const lobe_planes *lobe, size_t i, float factor)
{
    for (int k = 0; k < 3; k++)
        lobe->color[k][i] *= factor;
    if (factor == 0)
        lobe->hit[i] = 0;
}

/* [0,1); a finaliser of MurmurHash3 over a sum. */
static float random_at(uint32_t x, uint32_t y, uint32_t index)
{
    uint32_t h = x * 0x9e3779b1u + y * 0x85ebca77u + index * 0xc2b2ae3du;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return (float)((h ^ h >> 16) >> 8) / 16777216.0f;
}

bool thin_lobes(capture *frame, uint32_t index)
{
    lobe_planes diffuse, specular;
    if (!find_lobe(frame, "diffuse", "diffuse.hitT", "diffuseFactor", &diffuse)
        || !find_lobe(frame, "specular", "specular.hitT", "specularFactor", &specular))
        return false;
    for (int y = 0; y < frame->height; y++)
        for (int x = 0; x < frame->width; x++) {
            size_t i = (size_t)y * (size_t)frame->width + (size_t)x;
            float d = brightness(&diffuse, i), p = nrd_clamp_lobe_probability(d / (d + brightness(&specular, i)), 1);
            bool is_diffuse = nrd_split_threshold((uint32_t)x, (uint32_t)y, index, random_at((uint32_t)x, (uint32_t)y, index)) < p;
            scale_sample(&diffuse, i, is_diffuse ? 1 / p : 0);
            scale_sample(&specular, i, is_diffuse ? 0 : 1 / (1 - p));
        }
    return true;
}
