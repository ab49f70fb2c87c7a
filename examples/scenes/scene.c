#include "scenes/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenes/scenes.h"
#include "tracer/sampling.glsl"

#define NAMED(scene) .name = #scene, .build = scene_build_##scene, .animate = scene_animate_##scene, .frames = 32

const scene_def scene_table[] = {
    { NAMED(interior), .about = "room with small lights, textured walls and furniture; the camera dollies in", .small_lights = true },
    { NAMED(colonnade), .about = "columns and arches under sun and sky; the camera strafes", .has_sky = true, .has_sun = true },
    { NAMED(roughness_ramp), .about = "mirrors and spheres of rising roughness over a checker floor; the camera orbits", .has_sky = true,
      .has_sun = true, .small_lights = true },
    { .name = "moving", .build = scene_build_moving, .animate = scene_animate_moving, .frames = 48, .has_sky = true, .has_sun = true,
      .small_lights = true, .about = "things move, appear and vanish, a light goes out and one swings; the camera stands still" },
    { NAMED(thin), .about = "fences, wires and grass; the camera strafes", .has_sky = true, .has_sun = true },
    { NAMED(penumbrae), .about = "shadows from near and very far across each other, some of them move; the camera stands still", .has_sky = true,
      .has_sun = true, .for_shadows = true },
    { NAMED(sundial), .about = "a sun just above the horizon goes round a fence, a gnomon and leaves; the camera stands still", .has_sky = true,
      .has_sun = true, .for_shadows = true },
    { NAMED(glass), .about = "sunlight through coloured panes; the camera stands still", .has_sky = true, .has_sun = true, .has_glass = true,
      .for_shadows = true },
    { NAMED(lamp), .about = "a large lamp swings over small things; the camera stands still", .has_sky = true, .has_sun = true,
      .for_shadows = true },
    { NAMED(model), .about = "an imported mesh on a lit stage (--model FILE); the camera orbits", .has_sky = true, .has_sun = true,
      .small_lights = true },
};
const int scene_table_count = (int)(sizeof scene_table / sizeof scene_table[0]);

const scene_def *scene_find(const char *name)
{
    for (int i = 0; i < scene_table_count; i++)
        if (strcmp(scene_table[i].name, name) == 0) return &scene_table[i];
    return NULL;
}

/* Makes room for one more element; returns the array, or NULL and leaves it as it was. */
static void *grown(void *array, uint32_t count, uint32_t *capacity, size_t size)
{
    if (count < *capacity) return array;
    uint32_t wanted = *capacity ? *capacity * 2 : 64;
    void *bigger = realloc(array, wanted * size);
    if (bigger) *capacity = wanted;
    return bigger;
}

bool scene_open(scene *s, const scene_def *def, const char *model, char *error, size_t error_size)
{
    memset(s, 0, sizeof *s);
    s->def = def;
    s->denoising_range = 1000.0f;
    s->placement = scene_identity();
    bool ok = def->build(s, model, error, error_size);
    if (ok && s->out_of_memory) {
        snprintf(error, error_size, "scene %s: out of memory", def->name);
        ok = false;
    }
    if (!ok) scene_close(s);
    return ok;
}

void scene_close(scene *s)
{
    free(s->triangles);
    free(s->objects);
    free(s->materials);
    memset(s, 0, sizeof *s);
}

/* ---- building ---- */

pt_material *scene_material(scene *s, vec3 color, float roughness, float metalness)
{
    static pt_material overflow; /* written to and never read when memory is short */
    void *array = grown(s->materials, s->material_count, &s->material_capacity, sizeof *s->materials);
    if (!array) {
        s->out_of_memory = true;
        return &overflow;
    }
    s->materials = array;
    pt_material *m = &s->materials[s->material_count];
    memset(m, 0, sizeof *m);
    m->color = vec4(color[0], color[1], color[2], metalness);
    m->color2 = vec4(color[0], color[1], color[2], 1.0f);
    m->roughness = vec4(roughness, roughness, 0.0f, 0.0f);
    m->id = s->material_count % 4; /* what two bits of an encoded normal can carry */
    s->current_material = s->material_count++;
    return m;
}

void scene_texture(pt_material *m, uint32_t kind, float per_metre, vec3 color2, float roughness2, float bump_m)
{
    m->texture_kind = kind;
    m->color2 = vec4(color2[0], color2[1], color2[2], per_metre);
    m->roughness[1] = roughness2;
    m->roughness[2] = bump_m;
}

pt_material *scene_emitter(scene *s, vec3 radiance)
{
    pt_material *m = scene_material(s, grey(0.05f), 0.6f, 0.0f);
    m->emission = vec4(radiance[0], radiance[1], radiance[2], 0.0f);
    return m;
}

uint32_t scene_last_material(const scene *s) { return s->material_count - 1; }

void scene_use_material(scene *s, uint32_t material) { s->current_material = material; }

uint32_t scene_begin_object(scene *s)
{
    void *array = grown(s->objects, s->object_count, &s->object_capacity, sizeof *s->objects);
    if (!array) {
        s->out_of_memory = true;
        return 0;
    }
    s->objects = array;
    s->objects[s->object_count] = (scene_object){
        .first = s->triangle_count, .pose = scene_identity(), .pose_prev = scene_identity(), .visible = true
    };
    s->placement = scene_identity();
    return s->object_count++;
}

void scene_place(scene *s, scene_transform placement) { s->placement = placement; }

void scene_add_triangle(scene *s, const scene_triangle *t)
{
    if (s->object_count == 0) scene_begin_object(s);
    void *array = grown(s->triangles, s->triangle_count, &s->triangle_capacity, sizeof *s->triangles);
    if (!array || s->object_count == 0) {
        s->out_of_memory = true;
        return;
    }
    s->triangles = array;
    scene_triangle *out = &s->triangles[s->triangle_count++];
    *out = *t;
    out->material = s->current_material;
    for (int k = 0; k < 3; k++) {
        out->p[k] = scene_point(&s->placement, t->p[k]);
        out->n[k] = normalize(scene_vector(&s->placement, t->n[k]));
    }
    s->objects[s->object_count - 1].count++;
}

/* ---- posing ---- */

static pt_camera posed_camera(const scene_camera *c, float aspect)
{
    float half = tanf(c->fov_y * (PT_PI / 360.0f));
    vec3 forward = normalize(c->target - c->eye);
    vec3 right = normalize(cross(vec3(0.0f, 1.0f, 0.0f), forward));
    vec3 up = cross(forward, right);
    return (pt_camera){
        .position = c->eye,
        .right = vec4(right[0], right[1], right[2], half * aspect),
        .up = vec4(up[0], up[1], up[2], half),
        .forward = vec4(forward[0], forward[1], forward[2], 0.0f),
    };
}

static void pose_triangle(const scene_triangle *t, const scene_object *o, pt_triangle *out)
{
    *out = (pt_triangle){ .material = t->material };
    for (int k = 0; k < 3; k++) {
        out->p[k] = scene_point(&o->pose, t->p[k]);
        out->prev[k] = scene_point(&o->pose_prev, t->p[k]);
        out->n[k] = normalize(scene_vector(&o->pose, t->n[k]));
        out->p[k][3] = t->uv[k][0];
        out->prev[k][3] = t->uv[k][1];
        out->n[k][3] = 0.0f;
    }
}

static void pose_geometry(const scene *s, pt_scene *out)
{
    out->triangle_count = 0;
    for (uint32_t i = 0; i < s->object_count; i++) {
        const scene_object *o = &s->objects[i];
        for (uint32_t k = 0; o->visible && k < o->count; k++)
            pose_triangle(&s->triangles[o->first + k], o, &out->triangles[out->triangle_count++]);
    }
    memcpy(out->materials, s->materials, s->material_count * sizeof *s->materials);
    out->material_count = s->material_count;
}

static pt_light light_of(const pt_triangle *t, vec3 radiance)
{
    pt_light l = { .corner = xyz_of(t->p[0]), .radiance = radiance };
    l.edge1 = xyz_of(t->p[1]) - l.corner;
    l.edge2 = xyz_of(t->p[2]) - l.corner;
    l.normal = cross(l.edge1, l.edge2);
    float area2 = length(l.normal);
    l.normal *= area2 > 0.0f ? 1.0f / area2 : 0.0f;
    l.corner[3] = 0.5f * area2 * luminance(radiance);
    return l;
}

static void pose_lights(pt_scene *p)
{
    uint32_t count = 0;
    double power = 0.0;
    for (uint32_t i = 0; i < p->triangle_count; i++) {
        vec3 radiance = xyz_of(p->materials[p->triangles[i].material].emission);
        if (luminance(radiance) <= 0.0f) continue;
        pt_light l = light_of(&p->triangles[i], radiance);
        if (l.corner[3] <= 0.0f) continue;
        power += (double)l.corner[3];
        l.corner[3] = (float)power;
        p->lights[count++] = l;
    }
    for (uint32_t i = 0; i < count; i++) p->lights[i].corner[3] = (float)(p->lights[i].corner[3] / power);
    if (count) p->lights[count - 1].corner[3] = 1.0f;
    p->frame.light_count = count;
    p->frame.inv_light_power = count ? (float)(1.0 / power) : 0.0f;
}

static void pose_environment(const scene *s, pt_frame *f)
{
    vec3 zero = grey(0.0f);
    bool sun = dot(s->sun.direction, s->sun.direction) > 0.0f;
    vec3 d = sun ? normalize(s->sun.direction) : zero;
    f->sun_direction = vec4(d[0], d[1], d[2], s->sun.tan_angular_radius);
    f->sun_irradiance = s->lamp.radius > 0.0f ? s->lamp.irradiance : sun ? s->sun.irradiance : zero;
    f->lamp = vec4(s->lamp.position[0], s->lamp.position[1], s->lamp.position[2], s->lamp.radius);
    f->has_glass = s->def->has_glass;
    f->sky_zenith = s->sky.zenith;
    f->sky_horizon = vec4(s->sky.horizon[0], s->sky.horizon[1], s->sky.horizon[2], s->sky.glow);
    f->sky_ground = s->sky.ground;
    f->denoising_range = s->denoising_range;
    f->hit_dist_params = vec4(3.0f, 0.1f, 20.0f, -25.0f); /* the denoisers' defaults */
    f->occlusion = vec4(3.0f, 0.0f, 1.0f, 0.0f);
}

/* Arrays for all triangles of the scene, hidden ones included. */
static bool reserve_pose(const scene *s, pt_scene *out)
{
    if (out->triangles) return true;
    out->triangles = malloc((s->triangle_count + 1) * sizeof *out->triangles);
    out->lights = calloc(s->triangle_count + 1, sizeof *out->lights);
    out->materials = malloc((s->material_count + 1) * sizeof *out->materials);
    if (out->triangles && out->lights && out->materials) return true;
    scene_free_pose(out);
    return false;
}

bool scene_pose(scene *s, int frame, float fps, uint32_t width, uint32_t height, pt_scene *out)
{
    if (!reserve_pose(s, out)) return false;
    float aspect = (float)width / (float)height;
    s->def->animate(s, (float)(frame > 0 ? frame - 1 : 0) / fps);
    out->frame.camera_prev = posed_camera(&s->camera, aspect);
    for (uint32_t i = 0; i < s->object_count; i++) s->objects[i].pose_prev = s->objects[i].pose;
    s->def->animate(s, (float)frame / fps);
    out->frame.camera = posed_camera(&s->camera, aspect);
    out->frame.width = width;
    out->frame.height = height;
    out->frame.frame_index = (uint32_t)frame;
    pose_geometry(s, out);
    pose_lights(out);
    pose_environment(s, &out->frame);
    return true;
}

void scene_free_pose(pt_scene *p)
{
    free(p->triangles);
    free(p->lights);
    free(p->materials);
    memset(p, 0, sizeof *p);
}

void scene_camera_matrices(const pt_camera *camera, float near, float far, float world_to_camera[16],
                           float camera_to_clip[16])
{
    const vec4 axes[3] = { camera->right, camera->up, camera->forward };
    memset(world_to_camera, 0, 16 * sizeof(float));
    memset(camera_to_clip, 0, 16 * sizeof(float));
    for (int column = 0; column < 3; column++) {
        for (int row = 0; row < 3; row++) world_to_camera[row * 4 + column] = axes[column][row];
        world_to_camera[12 + column] = -dot(axes[column], camera->position);
    }
    world_to_camera[15] = 1.0f;
    camera_to_clip[0] = 1.0f / camera->right[3];
    camera_to_clip[5] = 1.0f / camera->up[3];
    camera_to_clip[10] = far / (far - near);
    camera_to_clip[11] = 1.0f;
    camera_to_clip[14] = -near * far / (far - near);
}
