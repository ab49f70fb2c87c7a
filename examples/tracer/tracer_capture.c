#include "tracer/tracer_capture.h"

#include <stdio.h>
#include <string.h>

typedef struct plane_group {
    const char *name, *suffixes; /* suffixes NULL: a single plane */
    uint32_t plane;
    capture_type type;
    enum { ALWAYS, WITH_SUN, WITH_GLASS } when;
} plane_group;

static const plane_group frame_groups[] = {
    { "viewZ", NULL, PT_PLANE_VIEW_Z, CAPTURE_FLOAT, ALWAYS },
    { "normal", "XYZ", PT_PLANE_NORMAL, CAPTURE_FLOAT, ALWAYS },
    { "roughness", NULL, PT_PLANE_ROUGHNESS, CAPTURE_HALF, ALWAYS },
    { "motion", "XYZ", PT_PLANE_MOTION, CAPTURE_FLOAT, ALWAYS },
    { "materialID", NULL, PT_PLANE_MATERIAL, CAPTURE_HALF, ALWAYS },
    { "baseColor", "RGB", PT_PLANE_BASE_COLOR, CAPTURE_HALF, ALWAYS },
    { "metalness", NULL, PT_PLANE_METALNESS, CAPTURE_HALF, ALWAYS },
    { "diffuse", "RGB", PT_PLANE_DIFFUSE, CAPTURE_HALF, ALWAYS },
    { "diffuse.hitT", NULL, PT_PLANE_DIFFUSE_HIT, CAPTURE_HALF, ALWAYS },
    { "diffuse.dir", "XYZ", PT_PLANE_DIFFUSE_DIR, CAPTURE_HALF, ALWAYS },
    { "specular", "RGB", PT_PLANE_SPECULAR, CAPTURE_HALF, ALWAYS },
    { "specular.hitT", NULL, PT_PLANE_SPECULAR_HIT, CAPTURE_HALF, ALWAYS },
    { "specular.dir", "XYZ", PT_PLANE_SPECULAR_DIR, CAPTURE_HALF, ALWAYS },
    { "diffuseFactor", "RGB", PT_PLANE_DIFFUSE_FACTOR, CAPTURE_HALF, ALWAYS },
    { "specularFactor", "RGB", PT_PLANE_SPECULAR_FACTOR, CAPTURE_HALF, ALWAYS },
    { "emission", "RGB", PT_PLANE_EMISSION, CAPTURE_HALF, ALWAYS },
    { "shadow.hitT", NULL, PT_PLANE_SHADOW_HIT, CAPTURE_HALF, WITH_SUN },
    { "sun", "RGB", PT_PLANE_SUN, CAPTURE_HALF, WITH_SUN },
    { "shadow.translucency", "RGB", PT_PLANE_TRANSLUCENCY, CAPTURE_HALF, WITH_GLASS },
};

static const plane_group reference_groups[] = {
    { "ref.diffuse", "RGB", PT_REF_DIFFUSE, CAPTURE_FLOAT, ALWAYS },
    { "ref.specular", "RGB", PT_REF_SPECULAR, CAPTURE_FLOAT, ALWAYS },
    { "ref.diffuse.ao", NULL, PT_REF_AO, CAPTURE_FLOAT, ALWAYS },
    { "ref.specular.ao", NULL, PT_REF_SPECULAR_AO, CAPTURE_FLOAT, ALWAYS },
    { "ref.shadow", NULL, PT_REF_SHADOW, CAPTURE_FLOAT, WITH_SUN },
    { "ref.shadow.translucency", "RGB", PT_REF_TRANSLUCENCY, CAPTURE_FLOAT, WITH_GLASS },
};

/* Adds the planes of a table to a capture, copied from `planes`. */
static bool add_groups(capture *c, const plane_group *groups, size_t count, const float *planes, const scene_def *def)
{
    size_t texels = (size_t)c->width * (size_t)c->height;
    for (size_t i = 0; i < count; i++) {
        const plane_group *g = &groups[i];
        bool wanted = g->when == ALWAYS || (g->when == WITH_SUN ? def->has_sun : def->has_glass);
        size_t members = g->suffixes ? strlen(g->suffixes) : 1;
        for (size_t k = 0; k < members && wanted; k++) {
            char name[CAPTURE_NAME_SIZE];
            snprintf(name, sizeof name, g->suffixes ? "%s.%c" : "%s", g->name, g->suffixes ? g->suffixes[k] : ' ');
            float *out = capture_add_plane(c, name, g->type);
            if (!out) return false;
            memcpy(out, planes + (g->plane + k) * texels, texels * sizeof *out);
        }
    }
    return true;
}

static void set_attributes(capture *c, const pt_frame *f, float fps, const scene_def *def)
{
    const float near = 0.05f, far = 2000.0f;
    scene_camera_matrices(&f->camera, near, far, c->world_to_camera, c->camera_to_clip);
    c->jitter[0] = f->jitter[0];
    c->jitter[1] = f->jitter[1];
    c->frame_index = (int)f->frame_index;
    c->time_delta_s = 1.0f / fps;
    c->denoising_range = f->denoising_range;
    for (int k = 0; k < 3; k++) c->sun_direction[k] = f->sun_direction[k], c->lamp_position[k] = f->lamp[k];
    c->sun_tan_angular_radius = f->sun_direction[3];
    c->lamp_radius = f->lamp[3];
    c->present = CAPTURE_HAS_CAMERA | CAPTURE_HAS_JITTER | CAPTURE_HAS_FRAME_INDEX | CAPTURE_HAS_TIME_DELTA |
                 CAPTURE_HAS_DENOISING_RANGE;
    if (def->has_sun)
        c->present |= f->lamp[3] > 0.0f ? CAPTURE_HAS_LAMP_POSITION | CAPTURE_HAS_LAMP_RADIUS : CAPTURE_HAS_SUN_DIRECTION | CAPTURE_HAS_SUN_TAN_ANGULAR_RADIUS;
}

bool tracer_fill_capture(capture *c, const pt_frame *f, float fps, const scene_def *def, const float *planes)
{
    set_attributes(c, f, fps, def);
    return add_groups(c, frame_groups, sizeof frame_groups / sizeof frame_groups[0], planes, def);
}

bool tracer_fill_reference(capture *c, const scene_def *def, const float *planes)
{
    return add_groups(c, reference_groups, sizeof reference_groups / sizeof reference_groups[0], planes, def);
}
