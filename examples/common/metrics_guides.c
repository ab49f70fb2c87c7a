#include "common/metrics_guides.h"

#include <math.h>

#define NORMAL_DOT 0.8
#define DEPTH_TOLERANCE 0.02

bool guides_find(const capture *frame, bool needs_motion, guides *out)
{
    out->frame = frame;
    out->view_z = capture_find_plane(frame, "viewZ");
    out->material = capture_find_plane(frame, "materialID");
    return out->view_z && capture_find_planes(frame, "normal", "XYZ", out->normal)
        && (!needs_motion || capture_find_planes(frame, "motion", "XYZ", out->motion));
}

static bool is_sky(const guides *g, size_t i)
{
    return fabsf(g->view_z[i]) >= g->frame->denoising_range;
}

static bool same_kind(const guides *a, size_t i, const guides *b, size_t j)
{
    double cosine = 0;
    for (int k = 0; k < 3; k++)
        cosine += (double)a->normal[k][i] * b->normal[k][j];
    return (!a->material || !b->material || a->material[i] == b->material[j]) && cosine >= NORMAL_DOT;
}

bool guides_same_surface(const guides *then, size_t j, const guides *now, size_t i)
{
    double expected_z = (double)now->view_z[i] + now->motion[2][i];
    return !is_sky(then, j) && same_kind(then, j, now, i) && fabs(then->view_z[j] - expected_z) <= DEPTH_TOLERANCE * fabs(expected_z);
}

bool guides_are_alike(const guides *a, size_t i, const guides *b, size_t j)
{
    bool sky = is_sky(a, i);
    return sky == is_sky(b, j) && (sky || same_kind(a, i, b, j));
}

bool guides_previous_pixel(const guides *now, int x, int y, size_t *out)
{
    int width = now->frame->width, height = now->frame->height;
    size_t i = (size_t)y * (size_t)width + (size_t)x;
    double px = x + 0.5 + (double)now->motion[0][i] * width, py = y + 0.5 + (double)now->motion[1][i] * height;
    if (!(px >= 0 && py >= 0 && px < width && py < height))
        return false;
    *out = (size_t)py * (size_t)width + (size_t)px;
    return true;
}
