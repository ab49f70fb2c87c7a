/* What tells shadow denoisers apart: penumbrae of every width on top of each other, a light that moves, coloured glass, a large lamp that
   is near. The camera stands still in all of them; what changes is named in each builder. */
#include "scenes/scenes.h"

static void add_floor(scene *s, uint32_t texture, float per_metre)
{
    scene_begin_object(s);
    pt_material *m = scene_material(s, vec3(0.62f, 0.60f, 0.56f), 0.7f, 0.0f);
    scene_texture(m, texture, per_metre, vec3(0.50f, 0.47f, 0.43f), 0.85f, 0.0f);
    scene_add_panel(s, vec3(0.0f, 0.0f, 20.0f), vec3(0.0f, 0.0f, 60.0f), vec3(60.0f, 0.0f, 0.0f));
}

static void set_sky(scene *s, vec3 sun_direction, vec3 sun_irradiance, float tan_radius)
{
    s->sky = (scene_sky){ vec3(0.09f, 0.20f, 0.50f), vec3(0.45f, 0.44f, 0.44f), grey(0.10f), 0.03f };
    s->sun = (scene_sun){ sun_direction, sun_irradiance, tan_radius };
}

/* A row of n bars along x. */
static void add_bars(scene *s, vec3 first, float spacing, int n, float height, float half_width)
{
    for (int i = 0; i < n; i++) {
        vec3 at = first + vec3(spacing * (float)i, 0.5f * height, 0.0f);
        scene_add_box(s, at, vec3(half_width, 0.5f * height, half_width));
    }
    scene_add_box(s, first + vec3(0.5f * spacing * (float)(n - 1), height, 0.0f), vec3(0.5f * spacing * (float)n, half_width, half_width));
}

/* ---- penumbrae: a gantry far above and behind the camera shades the ground near it, across the shadows of what stands there. The ball
   swings, the disk hovers lower and lower. */
enum { PENUMBRAE_BALL = 2, PENUMBRAE_DISK };

bool scene_build_penumbrae(scene *s, const char *model, char *error, size_t error_size)
{
    (void)model, (void)error, (void)error_size;
    add_floor(s, PT_TEXTURE_TILES, 1.0f);
    scene_begin_object(s);
    scene_material(s, vec3(0.45f, 0.42f, 0.40f), 0.8f, 0.0f);
    scene_add_box(s, vec3(-7.5f, 9.0f, -9.0f), vec3(0.9f, 0.25f, 14.0f)); /* the gantry and a mast */
    scene_add_box(s, vec3(-13.0f, 13.0f, 3.0f), vec3(0.35f, 0.35f, 10.0f));
    scene_add_box(s, vec3(-1.9f, 0.35f, 2.4f), vec3(0.35f, 0.35f, 0.35f)); /* they stand on the ground */
    scene_add_box(s, vec3(-0.4f, 0.04f, 1.1f), vec3(0.30f, 0.04f, 0.30f));
    scene_add_cylinder(s, vec3(0.9f, 0.0f, 1.6f), vec3(0.9f, 1.9f, 1.6f), 0.03f, 0.03f, 10);
    scene_material(s, vec3(0.55f, 0.35f, 0.20f), 0.6f, 0.0f);
    add_bars(s, vec3(-1.2f, 0.0f, 3.9f), 0.22f, 16, 0.8f, 0.02f);
    scene_begin_object(s); /* PENUMBRAE_BALL */
    scene_material(s, vec3(0.75f, 0.20f, 0.12f), 0.4f, 0.0f);
    scene_add_sphere(s, grey(0.0f), 0.28f, 32);
    scene_begin_object(s); /* PENUMBRAE_DISK */
    scene_material(s, vec3(0.20f, 0.35f, 0.60f), 0.5f, 0.0f);
    scene_add_cylinder(s, grey(0.0f), vec3(0.0f, 0.03f, 0.0f), 0.5f, 0.5f, 32);
    set_sky(s, vec3(-0.62f, 0.75f, -0.22f), vec3(7.0f, 6.2f, 5.0f), 0.045f);
    s->camera = (scene_camera){ vec3(0.0f, 2.3f, -3.6f), vec3(0.1f, 0.3f, 2.2f), 52.0f };
    return true;
}

void scene_animate_penumbrae(scene *s, float time_s)
{
    s->objects[PENUMBRAE_BALL].pose = scene_translation(vec3(0.2f + 1.1f * sinf(2.4f * time_s), 0.9f, 0.6f));
    s->objects[PENUMBRAE_DISK].pose = scene_translation(vec3(1.7f, 2.4f - 0.9f * time_s, 3.0f));
}

/* ---- sundial: the sun just above the horizon goes round; a fence, a gnomon and leaves thinner than a pixel throw shadows many times their
   height. */
static void add_leaves(scene *s, vec3 center, vec3 half, int n)
{
    uint32_t random = 5;
    for (int i = 0; i < n; i++) {
        vec3 at = center + scene_random3(&random, half * -1.0f, half);
        vec3 u = scene_random3(&random, grey(-0.05f), grey(0.05f)), v = scene_random3(&random, grey(-0.05f), grey(0.05f));
        scene_add_quad(s, at, at + u, at + v);
    }
}

bool scene_build_sundial(scene *s, const char *model, char *error, size_t error_size)
{
    (void)model, (void)error, (void)error_size;
    add_floor(s, PT_TEXTURE_NOISE, 1.2f);
    scene_begin_object(s);
    scene_material(s, vec3(0.70f, 0.66f, 0.58f), 0.6f, 0.0f);
    scene_add_cylinder(s, vec3(0.2f, 0.0f, 1.6f), vec3(0.2f, 0.06f, 1.6f), 0.9f, 0.85f, 48);
    scene_add_cylinder(s, vec3(0.2f, 0.06f, 1.6f), vec3(0.2f, 0.5f, 1.75f), 0.025f, 0.01f, 8);
    scene_add_sphere(s, vec3(1.6f, 0.25f, 0.8f), 0.25f, 32);
    add_bars(s, vec3(-3.6f, 0.0f, 1.8f), 0.14f, 14, 0.7f, 0.012f);
    scene_material(s, vec3(0.16f, 0.34f, 0.10f), 0.6f, 0.0f);
    add_leaves(s, vec3(2.6f, 0.7f, 2.9f), vec3(0.7f, 0.6f, 0.4f), 700);
    scene_add_cylinder(s, vec3(2.6f, 0.0f, 2.9f), vec3(2.6f, 0.8f, 2.9f), 0.04f, 0.03f, 8);
    set_sky(s, vec3(1.0f, 0.1f, 0.0f), vec3(6.0f, 4.2f, 2.2f), 0.012f);
    s->camera = (scene_camera){ vec3(0.0f, 2.4f, -3.8f), vec3(0.2f, 0.2f, 2.2f), 50.0f };
    return true;
}

void scene_animate_sundial(scene *s, float time_s)
{
    float angle = 0.3f + 0.35f * time_s;
    s->sun.direction = vec3(-cosf(angle), 0.13f + 0.03f * time_s, sinf(angle));
}

/* ---- glass: panes of many colours in a window, some behind each other, and a coloured disk that passes before it. */
enum { GLASS_DISK = 2 };

static void add_pane_material(scene *s, vec3 transmission)
{
    pt_material *m = scene_material(s, transmission * 0.3f, 0.1f, 0.0f);
    m->transmission = transmission;
}

bool scene_build_glass(scene *s, const char *model, char *error, size_t error_size)
{
    static const float colors[6][3] = { { 0.90f, 0.15f, 0.10f }, { 0.15f, 0.70f, 0.20f }, { 0.10f, 0.25f, 0.90f },
                                        { 0.95f, 0.80f, 0.15f }, { 0.60f, 0.15f, 0.75f }, { 0.20f, 0.80f, 0.85f } };
    (void)model, (void)error, (void)error_size;
    add_floor(s, PT_TEXTURE_CHECKER, 0.8f);
    scene_begin_object(s);
    scene_material(s, vec3(0.30f, 0.28f, 0.26f), 0.7f, 0.0f);
    for (int i = 0; i < 4; i++) scene_add_box(s, vec3(-1.5f + (float)i, 1.2f, 3.6f), vec3(0.06f, 1.2f, 0.06f));
    for (int i = 0; i < 3; i++) scene_add_box(s, vec3(0.0f, 0.2f + 1.1f * (float)i, 3.6f), vec3(1.56f, 0.05f, 0.06f));
    for (int i = 0; i < 6; i++) {
        add_pane_material(s, vec3(colors[i][0], colors[i][1], colors[i][2]));
        scene_add_panel(s, vec3(-1.0f + (float)(i % 3), 0.75f + 1.1f * (float)(i / 3), 3.6f), vec3(0.5f, 0.0f, 0.0f), vec3(0.0f, 0.55f, 0.0f));
    }
    scene_begin_object(s); /* GLASS_DISK */
    add_pane_material(s, vec3(0.95f, 0.55f, 0.25f));
    scene_add_cylinder(s, vec3(0.0f, 0.0f, -0.01f), vec3(0.0f, 0.0f, 0.01f), 0.45f, 0.45f, 32);
    set_sky(s, vec3(0.25f, 0.75f, 0.85f), vec3(9.0f, 8.0f, 6.5f), 0.03f);
    s->camera = (scene_camera){ vec3(0.4f, 2.2f, -3.0f), vec3(-0.2f, 0.5f, 2.2f), 55.0f };
    return true;
}

void scene_animate_glass(scene *s, float time_s) { s->objects[GLASS_DISK].pose = scene_translation(vec3(-1.2f + 0.8f * time_s, 1.1f, 3.0f)); }

/* ---- lamp: large, an arm's length above small things, and it swings: penumbrae from nothing to wider than what throws them. */
bool scene_build_lamp(scene *s, const char *model, char *error, size_t error_size)
{
    (void)model, (void)error, (void)error_size;
    add_floor(s, PT_TEXTURE_WOOD, 1.0f);
    scene_begin_object(s);
    scene_material(s, vec3(0.65f, 0.62f, 0.58f), 0.8f, 0.0f);
    scene_add_box(s, vec3(0.0f, 1.5f, 4.2f), vec3(6.0f, 1.5f, 0.1f));
    scene_material(s, vec3(0.25f, 0.45f, 0.35f), 0.4f, 0.0f);
    scene_add_box(s, vec3(-0.9f, 0.3f, 1.2f), vec3(0.3f, 0.3f, 0.3f));
    scene_add_sphere(s, vec3(0.8f, 0.35f, 0.9f), 0.35f, 40);
    scene_material(s, vec3(0.60f, 0.30f, 0.15f), 0.5f, 0.0f);
    scene_add_box(s, vec3(0.1f, 0.62f, 2.2f), vec3(0.7f, 0.02f, 0.35f)); /* a table */
    for (int i = 0; i < 4; i++) scene_add_box(s, vec3(i % 2 ? 0.75f : -0.55f, 0.3f, i / 2 ? 2.5f : 1.9f), vec3(0.025f, 0.3f, 0.025f));
    add_bars(s, vec3(1.5f, 0.0f, 2.4f), 0.15f, 8, 0.6f, 0.012f);
    s->sky = (scene_sky){ grey(0.02f), grey(0.02f), grey(0.02f), 0.0f };
    s->lamp = (scene_lamp){ .radius = 0.25f, .irradiance = vec3(26.0f, 22.0f, 16.0f) };
    s->camera = (scene_camera){ vec3(0.0f, 2.0f, -2.6f), vec3(0.2f, 0.4f, 1.6f), 55.0f };
    return true;
}

void scene_animate_lamp(scene *s, float time_s) { s->lamp.position = vec3(-0.6f + 0.9f * sinf(1.2f * time_s), 1.9f, 1.0f + 0.3f * cosf(1.2f * time_s)); }
