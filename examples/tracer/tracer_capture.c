#include "tracer/tracer_capture.h"

#include <stdio.h>
#include <string.h>

typedef struct plane_group {
    const char *name, *suffixes; /* suffixes NULL: a single plane */
    uint32_t plane;
    capture_type type;
    bool sun; /* only in scenes with a sun */
} plane_group;

static const plane_group frame_groups[] = {
    { "viewZ", NULL, PT_PLANE_VIEW_Z, CAPTURE_FLOAT, false },
    { "normal", "XYZ", PT_PLANE_NORMAL, CAPTURE_FLOAT, false },
    { "roughness", NULL, PT_PLANE_ROUGHNESS, CAPTURE_HALF, false },
    { "motion", "XYZ", PT_PLANE_MOTION, CAPTURE_FLOAT, false },
    { "materialID", NULL, PT_PLANE_MATERIAL, CAPTURE_HALF, false },
    { "baseColor", "RGB", PT_PLANE_BASE_COLOR, CAPTURE_HALF, false },
    { "metalness", NULL, PT_PLANE_METALNESS, CAPTURE_HALF, false },
    { "diffuse", "RGB", PT_PLANE_DIFFUSE, CAPTURE_HALF, false },
    { "diffuse.hitT", NULL, PT_PLANE_DIFFUSE_HIT, CAPTURE_HALF, false },
    { "diffuse.dir", "XYZ", PT_PLANE_DIFFUSE_DIR, CAPTURE_HALF, false },
    { "specular", "RGB", PT_PLANE_SPECULAR, CAPTURE_HALF, false },
    { "specular.hitT", NULL, PT_PLANE_SPECULAR_HIT, CAPTURE_HALF, false },
    { "specular.dir", "XYZ", PT_PLANE_SPECULAR_DIR, CAPTURE_HALF, false },
    { "diffuseFactor", "RGB", PT_PLANE_DIFFUSE_FACTOR, CAPTURE_HALF, false },
    { "specularFactor", "RGB", PT_PLANE_SPECULAR_FACTOR, CAPTURE_HALF, false },
    { "emission", "RGB", PT_PLANE_EMISSION, CAPTURE_HALF, false },
    { "shadow.hitT", NULL, PT_PLANE_SHADOW_HIT, CAPTURE_HALF, true },
    { "sun", "RGB", PT_PLANE_SUN, CAPTURE_HALF, true },
};

static const plane_group reference_groups[] = {
    { "ref.diffuse", "RGB", PT_REF_DIFFUSE, CAPTURE_FLOAT, false },
    { "ref.specular", "RGB", PT_REF_SPECULAR, CAPTURE_FLOAT, false },
    { "ref.diffuse.ao", NULL, PT_REF_AO, CAPTURE_FLOAT, false },
    { "ref.shadow", NULL, PT_REF_SHADOW, CAPTURE_FLOAT, true },
};

/* Adds the planes of a table to a capture, copied from `planes`. */
static bool add_groups(capture *c, const plane_group *groups, size_t count, const float *planes, bool sun)
{
    size_t texels = (size_t)c->width * (size_t)c->height;
    for (size_t i = 0; i < count; i++) {
        const plane_group *g = &groups[i];
        size_t members = g->suffixes ? strlen(g->suffixes) : 1;
        for (size_t k = 0; k < members && (sun || !g->sun); k++) {
            char name[CAPTURE_NAME_SIZE];
            snprintf(name, sizeof name, g->suffixes ? "%s.%c" : "%s", g->name, g->suffixes ? g->suffixes[k] : ' ');
            float *out = capture_add_plane(c, name, g->type);
            if (!out) return false;
            memcpy(out, planes + (g->plane + k) * texels, texels * sizeof *out);
        }
    }
    return true;
}

static void set_attributes(capture *c, const pt_frame *f, float fps, bool sun)
{
    const float near = 0.05f, far = 2000.0f;
    scene_camera_matrices(&f->camera, near, far, c->world_to_camera, c->camera_to_clip);
    c->jitter[0] = f->jitter[0];
    c->jitter[1] = f->jitter[1];
    c->frame_index = (int)f->frame_index;
    c->time_delta_s = 1.0f / fps;
    c->denoising_range = f->denoising_range;
    for (int k = 0; k < 3; k++) c->sun_direction[k] = f->sun_direction[k];
    c->sun_tan_angular_radius = f->sun_direction[3];
    c->present = CAPTURE_HAS_CAMERA | CAPTURE_HAS_JITTER | CAPTURE_HAS_FRAME_INDEX | CAPTURE_HAS_TIME_DELTA |
                 CAPTURE_HAS_DENOISING_RANGE;
    if (sun) c->present |= CAPTURE_HAS_SUN_DIRECTION | CAPTURE_HAS_SUN_TAN_ANGULAR_RADIUS;
}

bool tracer_fill_capture(capture *c, const pt_frame *f, float fps, bool sun, const float *planes)
{
    set_attributes(c, f, fps, sun);
    return add_groups(c, frame_groups, sizeof frame_groups / sizeof frame_groups[0], planes, sun);
}

bool tracer_fill_reference(capture *c, bool sun, const float *planes)
{
    return add_groups(c, reference_groups, sizeof reference_groups / sizeof reference_groups[0], planes, sun);
}
