/* corner_capture.h: a small capture with a known answer, for tests: a floor that meets a wall, sky above it, seen by a
   camera that stands still or moves sideways. Every pixel of `diffuse` is one sample: four times the true radiance or nothing. */
#ifndef TESTS_CORNER_CAPTURE_H
#define TESTS_CORNER_CAPTURE_H

#include "common/capture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define CORNER_WIDTH 96
#define CORNER_HEIGHT 64
#define CORNER_RANGE 100.0f  /* denoising range */
#define CORNER_SKY 0.75f     /* diffuse stored in the sky, where it means nothing */
#define CORNER_SPECULAR 0.5f /* free of noise */

/* One frame; `speed` in metres per frame along +x. */
typedef struct corner_view {
    int frame;
    float speed;
} corner_view;

typedef struct corner_hit {
    bool sky;
    float position[3], normal[3];
} corner_hit;

static inline float corner_camera_x(corner_view v)
{
    return v.speed * (float)v.frame;
}

/* Uniform in [0,1): a finaliser of MurmurHash3 over a sum. */
static inline float corner_random(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t h = a * 0x9e3779b1u + b * 0x85ebca77u + c * 0xc2b2ae3du + 1u;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return (float)((h ^ h >> 16) >> 8) / 16777216.0f;
}

/* The camera is 1 m above the floor and looks along +z; the wall is 6 m away and 2.5 m high. */
static inline corner_hit corner_trace(corner_view v, int x, int y)
{
    float dx = (((float)x + 0.5f) / CORNER_WIDTH * 2 - 1) * CORNER_WIDTH / CORNER_HEIGHT * 0.6f;
    float dy = (1 - ((float)y + 0.5f) / CORNER_HEIGHT * 2) * 0.6f;
    float to_floor = dy < 0 ? -1 / dy : 1e9f, z = to_floor < 6 ? to_floor : 6;
    corner_hit hit = { false, { corner_camera_x(v) + dx * z, 1 + dy * z, z }, { 0, 0, 0 } };
    hit.sky = hit.position[1] > 2.5f;
    hit.normal[to_floor < 6 ? 1 : 2] = to_floor < 6 ? 1 : -1;
    return hit;
}

/* True diffuse radiance: darker towards the edge, smooth along it. */
static inline float corner_truth(const corner_hit *hit, int channel)
{
    float edge = hit->normal[1] > 0 ? 6 - hit->position[2] : hit->position[1];
    float along = 1 + 0.3f * sinf(hit->position[0] * 1.5f + (float)channel);
    return along * (0.3f + 0.7f * (1 - expf(-edge)));
}

static inline void corner_set_camera(capture *c, corner_view v)
{
    float tangent = 0.6f, near = 0.05f, far = 1000;
    for (int i = 0; i < 4; i++)
        c->world_to_camera[5 * i] = 1;
    c->world_to_camera[12] = -corner_camera_x(v);
    c->world_to_camera[13] = -1;
    c->camera_to_clip[0] = CORNER_HEIGHT / (tangent * CORNER_WIDTH);
    c->camera_to_clip[5] = 1 / tangent;
    c->camera_to_clip[10] = far / (far - near);
    c->camera_to_clip[11] = 1;
    c->camera_to_clip[14] = -near * far / (far - near);
    c->frame_index = v.frame;
    c->time_delta_s = 1.0f / 60;
    c->denoising_range = CORNER_RANGE;
    c->present = CAPTURE_HAS_CAMERA | CAPTURE_HAS_FRAME_INDEX | CAPTURE_HAS_TIME_DELTA | CAPTURE_HAS_DENOISING_RANGE;
}

enum { CORNER_R, CORNER_G, CORNER_B, CORNER_HIT, CORNER_X, CORNER_Y, CORNER_Z, CORNER_ROUGHNESS, CORNER_VIEW_Z, CORNER_MOTION_X,
    CORNER_MOTION_Y, CORNER_MOTION_Z, CORNER_REF_R, CORNER_REF_G, CORNER_REF_B, CORNER_DF_R, CORNER_DF_G, CORNER_DF_B, CORNER_S_R,
    CORNER_S_G, CORNER_S_B, CORNER_SF_R, CORNER_SF_G, CORNER_SF_B, CORNER_PLANES };

static inline void corner_fill_pixel(float **planes, corner_view v, int x, int y)
{
    size_t i = (size_t)(y * CORNER_WIDTH + x);
    corner_hit hit = corner_trace(v, x, y);
    bool lit = corner_random((uint32_t)x, (uint32_t)y, (uint32_t)v.frame) < 0.25f;
    for (int k = 0; k < 3; k++) {
        planes[CORNER_X + k][i] = hit.normal[k];
        planes[CORNER_REF_R + k][i] = hit.sky ? 0 : corner_truth(&hit, k);
        planes[CORNER_R + k][i] = hit.sky ? CORNER_SKY : lit ? 4 * corner_truth(&hit, k) : 0;
        planes[CORNER_DF_R + k][i] = hit.sky ? 0 : 0.5f;
        planes[CORNER_S_R + k][i] = CORNER_SPECULAR;
        planes[CORNER_SF_R + k][i] = hit.sky ? 0 : 0.0625f;
    }
    planes[CORNER_HIT][i] = 0.1f + 4 * corner_random((uint32_t)x + 7777, (uint32_t)y, (uint32_t)v.frame);
    planes[CORNER_ROUGHNESS][i] = 0.5f;
    planes[CORNER_VIEW_Z][i] = hit.sky ? 2 * CORNER_RANGE : hit.position[2];
    planes[CORNER_MOTION_X][i] = hit.sky || v.frame == 0 ? 0 : 0.5f * v.speed * CORNER_HEIGHT / (0.6f * CORNER_WIDTH) / hit.position[2];
}

/* False when memory is short. */
static inline bool corner_make(capture *c, corner_view v)
{
    static const char *const names[CORNER_PLANES] = { "diffuse.R", "diffuse.G", "diffuse.B", "diffuse.hitT", "normal.X", "normal.Y",
        "normal.Z", "roughness", "viewZ", "motion.X", "motion.Y", "motion.Z", "ref.diffuse.R", "ref.diffuse.G", "ref.diffuse.B",
        "diffuseFactor.R", "diffuseFactor.G", "diffuseFactor.B", "specular.R", "specular.G", "specular.B", "specularFactor.R",
        "specularFactor.G", "specularFactor.B" };
    float *planes[CORNER_PLANES];
    if (!capture_create(c, CORNER_WIDTH, CORNER_HEIGHT))
        return false;
    corner_set_camera(c, v);
    for (int i = 0; i < CORNER_PLANES; i++)
        if (!(planes[i] = capture_add_plane(c, names[i], i <= CORNER_HIT ? CAPTURE_HALF : CAPTURE_FLOAT)))
            return false;
    for (int y = 0; y < CORNER_HEIGHT; y++)
        for (int x = 0; x < CORNER_WIDTH; x++)
            corner_fill_pixel(planes, v, x, y);
    return true;
}

#endif
