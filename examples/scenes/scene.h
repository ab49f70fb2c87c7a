/* scene.h: the one description of a scene that both tracers render: triangles with materials, emitters, sun, sky, a
   camera and the motion of objects, all functions of time alone.

   Conventions: metres, +y up, left-handed (a camera has +x right, +y up, +z forward). The front of a triangle is the
   side that cross(p1 - p0, p2 - p0) points to; only the front of an emitter emits. Both sides of everything else
   reflect. Texture coordinates are in metres on flat shapes.

   A scene is built once (`scene_open`), then posed for a frame (`scene_pose`), which gives the arrays that tracers
   read. */
#ifndef EXAMPLES_SCENES_SCENE_H
#define EXAMPLES_SCENES_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "tracer/data.glsl"

/* Columns of an affine map: point -> x p.x + y p.y + z p.z + t. Rigid, or with one scale for all axes. */
typedef struct scene_transform {
    vec3 x, y, z, t;
} scene_transform;

/* A vertex carries the object-space position, normal and texture coordinates. */
typedef struct scene_triangle {
    vec3 p[3], n[3];
    float uv[3][2];
    uint32_t material;
} scene_triangle;

/* Triangles that move together. `pose` and `visible` are written by the scene's animate function. */
typedef struct scene_object {
    uint32_t first, count;
    scene_transform pose, pose_prev;
    bool visible;
} scene_object;

typedef struct scene_camera {
    vec3 eye, target;
    float fov_y; /* vertical field of view, degrees */
} scene_camera;

typedef struct scene_sky {
    vec3 zenith, horizon, ground; /* radiance */
    float glow;                   /* radiance around the sun, as a share of its irradiance */
} scene_sky;

typedef struct scene_sun {
    vec3 direction;  /* towards the sun, any length; 0: no sun */
    vec3 irradiance; /* on a surface that faces it */
    float tan_angular_radius;
} scene_sun;

/* Round, unseen, shines in place of the sun. */
typedef struct scene_lamp {
    vec3 position;
    float radius; /* metres; 0: no lamp */
    vec3 irradiance; /* at 1 metre, on a surface that faces it */
} scene_lamp;

typedef struct scene scene;

/* A row of the table of scenes. */
typedef struct scene_def {
    const char *name;
    const char *about;
    int frames;         /* default length of a capture */
    bool has_sky;       /* some primary rays leave the scene */
    bool has_sun;
    bool has_glass;     /* the sun shines through something coloured */
    bool for_shadows;   /* made to study shadows; says little about other signals */
    bool small_lights;  /* emitters that chance rarely finds: sample them at the primary hit by default */
    bool (*build)(scene *s, const char *model, char *error, size_t error_size); /* false: `error` says why */
    void (*animate)(scene *s, float time_s);
} scene_def;

struct scene {
    const scene_def *def;
    scene_triangle *triangles;
    uint32_t triangle_count, triangle_capacity;
    scene_object *objects;
    uint32_t object_count, object_capacity;
    pt_material *materials;
    uint32_t material_count, material_capacity;
    scene_camera camera;
    scene_sky sky;
    scene_sun sun;
    scene_lamp lamp;
    float denoising_range;     /* metres; the sky lies at twice that */
    scene_transform placement; /* applied to what shapes add; identity at the start of an object */
    uint32_t current_material;
    bool out_of_memory;
};

/* What tracers read: one frame of a scene. `accel` belongs to the tracer that works on it. */
typedef struct pt_scene {
    pt_frame frame;
    pt_triangle *triangles;
    uint32_t triangle_count;
    pt_material *materials;
    uint32_t material_count;
    pt_light *lights; /* frame.light_count of them */
    void *accel;
} pt_scene;

extern const scene_def scene_table[];
extern const int scene_table_count;

/* NULL when the name is unknown. */
const scene_def *scene_find(const char *name);

/* Builds a scene. `model` is the mesh of the scene "model", NULL for its default. On failure `error` holds one line and
   the scene is closed. */
bool scene_open(scene *s, const scene_def *def, const char *model, char *error, size_t error_size);
void scene_close(scene *s); /* a zeroed scene is allowed */

/* Fills in everything of *out that follows from the scene: geometry of the frame and of the one before it (itself for
   frame 0), lights, cameras, sun and sky, frame_index. *out must be zeroed before its first pose; arrays are reused.
   False when memory is short. */
bool scene_pose(scene *s, int frame, float fps, uint32_t width, uint32_t height, pt_scene *out);
void scene_free_pose(pt_scene *p);

/* The matrices of a capture: row vectors, camera = world * M; clip z/w runs from 0 at `near` to 1 at `far` metres. */
void scene_camera_matrices(const pt_camera *camera, float near, float far, float world_to_camera[16],
                           float camera_to_clip[16]);

/* ---- building: materials ---- */

/* A material of one colour, which becomes the current one. Change the returned one to add a texture or emission; the
   pointer holds until the next material is added. Never NULL. */
pt_material *scene_material(scene *s, vec3 color, float roughness, float metalness);
void scene_texture(pt_material *m, uint32_t kind, float per_metre, vec3 color2, float roughness2, float bump_m);
pt_material *scene_emitter(scene *s, vec3 radiance);
uint32_t scene_last_material(const scene *s);
void scene_use_material(scene *s, uint32_t material);

/* ---- building: objects and shapes ---- */

/* What follows belongs to a new object, whose number is returned. */
uint32_t scene_begin_object(scene *s);
void scene_place(scene *s, scene_transform placement);

void scene_add_triangle(scene *s, const scene_triangle *t);
/* Parallelogram with corner a and edges to b and d; its front is the side of cross(b - a, d - a). */
void scene_add_quad(scene *s, vec3 a, vec3 b, vec3 d);
void scene_add_box(scene *s, vec3 center, vec3 half);
/* Surface of revolution about +y through the placement's origin; profile points are (radius, height), from the bottom
   up. Edges sharper than 40 degrees stay sharp. */
void scene_add_lathe(scene *s, const float (*profile)[2], int points, int sides);
void scene_add_sphere(scene *s, vec3 center, float radius, int sides);
void scene_add_cylinder(scene *s, vec3 a, vec3 b, float radius_a, float radius_b, int sides);
/* A rectangle with half edges u and v that faces cross(u, v). */
void scene_add_panel(scene *s, vec3 center, vec3 u, vec3 v);

/* ---- transforms ---- */
scene_transform scene_identity(void);
scene_transform scene_translation(vec3 t);
scene_transform scene_rotation(vec3 axis, float radians); /* axis of unit length; left-handed screw */
scene_transform scene_scaling(float factor);
scene_transform scene_compose(scene_transform outer, scene_transform inner); /* first inner, then outer */
vec3 scene_point(const scene_transform *x, vec3 p);
vec3 scene_vector(const scene_transform *x, vec3 v);

/* Random number in [0, 1) for the layout of scenes; advances *state. */
float scene_random(uint32_t *state);
/* Three of them, each scaled to [low, high). */
vec3 scene_random3(uint32_t *state, vec3 low, vec3 high);

#endif
