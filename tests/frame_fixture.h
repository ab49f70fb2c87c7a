/* frame_fixture.h: what the tests of nrd.h share: an allocator and a logger that remember, and cameras described in plain
   double-precision terms. */
#ifndef TESTS_FRAME_FIXTURE_H
#define TESTS_FRAME_FIXTURE_H

#include "nrd.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---------------------------------------------------------------------------------------------------------------------------
   Spy  >>spy */
typedef struct spy {
    uint32_t messages, errors;     /* since forget_messages */
    nrd_severity severity;         /* of the last one */
    nrd_result result;
    char text[512];
    uint32_t allocations, releases;
    bool refuse;                   /* the allocator returns NULL */
    void *block;                   /* what it gave last */
    size_t bytes;
} spy;

static inline void *spy_allocate(void *user, size_t bytes)
{
    spy *s = (spy *)user;
    s->allocations++;
    s->bytes = bytes;
    s->block = s->refuse ? NULL : malloc(bytes);
    return s->block;
}

static inline void spy_release(void *user, void *memory)
{
    ((spy *)user)->releases++;
    free(memory);
}

static inline void spy_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    spy *s = (spy *)user;
    s->messages++;
    s->errors += severity == NRD_SEVERITY_ERROR;
    s->severity = severity;
    s->result = result;
    snprintf(s->text, sizeof s->text, "%s", text);
}

static inline void forget_messages(spy *s)
{
    s->messages = s->errors = 0;
    s->text[0] = 0;
}

static inline nrd_desc spied_desc(spy *s, const nrd_denoiser_desc *denoisers, uint32_t count, uint32_t width, uint32_t height, uint32_t features)
{
    nrd_desc desc = { .width = width, .height = height, .denoisers = denoisers, .denoiser_count = count, .features = features,
                      .allocate = spy_allocate, .release = spy_release, .allocate_user = s, .message = spy_message, .message_user = s };
    return desc;
}

static inline nrd *create_one(spy *s, nrd_denoiser denoiser, uint32_t width, uint32_t height, uint32_t features)
{
    nrd_denoiser_desc one = { 7, denoiser };
    nrd_desc desc = spied_desc(s, &one, 1, width, height, features);
    nrd *instance = NULL;
    memset(s, 0, sizeof *s);
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    return instance;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Settings by name  >>settings */
/* denoiser NRD_DENOISER_COUNT: nrd_frame. False: there is no such setting. */
static inline bool find_setting(nrd_denoiser denoiser, const char *name, nrd_setting *out)
{
    for (uint32_t i = 0; nrd_get_setting(denoiser, i, out); i++)
        if (strcmp(out->name, name) == 0) return true;
    return false;
}

static inline void put_setting(void *settings, const nrd_setting *setting, double value)
{
    float f = (float)value;
    uint32_t u = setting->is_float ? 0 : (uint32_t)value;
    memcpy((char *)settings + setting->offset, setting->is_float ? (const void *)&f : (const void *)&u, 4);
}

static inline bool put_setting_by_name(nrd_denoiser denoiser, void *settings, const char *name, double value)
{
    nrd_setting setting;
    if (!find_setting(denoiser, name, &setting)) return false;
    put_setting(settings, &setting, value);
    return true;
}

typedef union any_settings {
#define FIXTURE_MEMBER(name, text, type) type name;
    NRD_DENOISERS(FIXTURE_MEMBER)
#undef FIXTURE_MEMBER
} any_settings;

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

/* A frame seen by a camera that stands at the origin. */
static inline nrd_frame still_frame(uint32_t frame_index)
{
    nrd_frame frame = nrd_frame_defaults();
    pose p = pose_at(0, 0, 0);
    frame.camera = pose_camera(&p);
    frame.frame_index = frame_index;
    return frame;
}

/* An instance with every denoiser, identified by its number, and every feature. */
static inline nrd *create_all(spy *s)
{
    nrd_denoiser_desc all[NRD_DENOISER_COUNT];
    nrd *instance = NULL;
    memset(s, 0, sizeof *s);
    for (uint32_t i = 0; i < NRD_DENOISER_COUNT; i++) all[i].identifier = i, all[i].denoiser = (nrd_denoiser)i;
    nrd_desc desc = spied_desc(s, all, NRD_DENOISER_COUNT, 64, 48, NRD_FEATURE_ALL);
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    return instance;
}

#endif
