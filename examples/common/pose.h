/* pose.h: cameras described in plain double-precision terms, as nrd.h and as geometry, and random numbers by index. */
#ifndef EXAMPLES_POSE_H
#define EXAMPLES_POSE_H

#include "nrd.h"

#include <math.h>
#include <string.h>

/* ---------------------------------------------------------------------------------------------------------------------------
   Random numbers  >>random */
/* Uniform in [0,1): a finaliser of MurmurHash3 over a sum. */
static inline double random_at(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t h = a * 0x9e3779b1u + b * 0x85ebca77u + c * 0xc2b2ae3du + 1u;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return (h ^ h >> 16) / 4294967296.0;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Cameras  >>cameras */
/* A camera as its maker thinks of it. Angles in radians; at zero angles it looks along world +z, right is +x and up is +y.
   What follows is how an app may describe one and the same camera. */
typedef struct pose {
    double position[3], yaw, pitch, roll;
    double tan_half_height;     /* orthographic: half the height of the view, world units */
    double aspect, near, far;   /* far 0: infinite */
    double shift[2];            /* of the principal point, fraction of half the picture, right and up */
    bool orthographic;
    bool right_handed;          /* view z points backwards */
    bool reversed;              /* depth 1 at the near plane */
    bool clip_y_down;           /* Vulkan's flip in the projection */
    bool view_y_down;           /* view y points downwards; with clip y down too */
    double jitter[2];
} pose;

static inline pose pose_at(double x, double y, double z)
{
    pose p = { .position = { x, y, z }, .tan_half_height = 0.5, .aspect = 4.0 / 3.0, .near = 0.1, .far = 100 };
    return p;
}

/* Unit vectors of the camera in the world: rows right, up, forward. */
static inline void pose_axes(const pose *p, double axes[3][3])
{
    double cy = cos(p->yaw), sy = sin(p->yaw), cp = cos(p->pitch), sp = sin(p->pitch), cr = cos(p->roll), sr = sin(p->roll);
    double right[3] = { cy, 0, -sy }, up[3] = { sy * sp, cp, cy * sp }, forward[3] = { sy * cp, -sp, cy * cp };
    for (int k = 0; k < 3; k++) {
        axes[0][k] = cr * right[k] + sr * up[k];
        axes[1][k] = -sr * right[k] + cr * up[k];
        axes[2][k] = forward[k];
    }
}

static inline void pose_projection(const pose *p, float m[16])
{
    double z = p->right_handed ? -1 : 1, flip = p->clip_y_down ? -1 : 1, sy = 1 / p->tan_half_height, sx = sy / p->aspect;
    double n = p->near, f = p->far, a, b;   /* depth = a * distance + b, over distance unless orthographic */
    if (p->orthographic) a = 1 / (f - n), b = -n / (f - n);
    else a = f > 0 ? f / (f - n) : 1, b = f > 0 ? -n * f / (f - n) : -n;
    if (p->reversed) a = (p->orthographic ? 0 : 1) - a, b = (p->orthographic ? 1 : 0) - b;
    memset(m, 0, 16 * sizeof *m);
    m[0] = (float)sx;
    m[5] = (float)(sy * flip);
    m[10] = (float)(a * z);
    m[14] = (float)b;
    m[11] = p->orthographic ? 0 : (float)z;
    m[15] = p->orthographic;
    int column = p->orthographic ? 12 : 8;
    m[column] = (float)(-p->shift[0] * (p->orthographic ? 1 : z));
    m[column + 1] = (float)(-p->shift[1] * (p->orthographic ? 1 : z) * (p->clip_y_down || p->view_y_down ? -1 : 1));
}

static inline nrd_camera pose_camera(const pose *p)
{
    nrd_camera c;
    double axes[3][3];
    memset(&c, 0, sizeof c);
    pose_axes(p, axes);
    pose_projection(p, c.view_to_clip);
    for (int row = 0; row < 3; row++) {
        double sign = (row == 1 && p->view_y_down) || (row == 2 && p->right_handed) ? -1 : 1, t = 0;
        for (int k = 0; k < 3; k++) {
            c.world_to_view[4 * k + row] = (float)(sign * axes[row][k]);
            t -= sign * axes[row][k] * p->position[k];
        }
        c.world_to_view[12 + row] = (float)t;
    }
    c.world_to_view[15] = 1;
    c.jitter[0] = (float)p->jitter[0];
    c.jitter[1] = (float)p->jitter[1];
    return c;
}

static inline nrd_clip_y pose_clip_y(const pose *p) { return p->view_y_down ? NRD_CLIP_Y_DOWN : NRD_CLIP_Y_AUTO; }

/* World position of what is seen at a uv (y down) at a distance along the view axis. */
static inline void pose_point(const pose *p, double u, double v, double depth, double world[3])
{
    double axes[3][3], scale = p->tan_half_height * (p->orthographic ? 1 : depth);
    double x = (2 * u - 1 + p->shift[0]) * scale * p->aspect, y = (1 - 2 * v + p->shift[1]) * scale;
    pose_axes(p, axes);
    for (int k = 0; k < 3; k++) world[k] = p->position[k] + x * axes[0][k] + y * axes[1][k] + depth * axes[2][k];
}

/* The inverse: uv and distance at which the camera sees a world position. */
static inline void pose_project(const pose *p, const double world[3], double *u, double *v, double *depth)
{
    double axes[3][3], at[3] = { 0, 0, 0 };
    pose_axes(p, axes);
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) at[row] += axes[row][k] * (world[k] - p->position[k]);
    double scale = p->tan_half_height * (p->orthographic ? 1 : at[2]);
    *u = (at[0] / (scale * p->aspect) - p->shift[0] + 1) / 2;
    *v = (1 - at[1] / scale + p->shift[1]) / 2;
    *depth = at[2];
}

#endif
