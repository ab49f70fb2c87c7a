/* What breaks history: bodies that move over a glossy floor, one that appears and one that vanishes, a light that goes
   out and a lamp that swings, all before a camera that stands still. Times are in seconds. */
#include "scenes/scenes.h"

#define APPEAR_S 0.40f
#define VANISH_S 0.70f
#define LIGHT_OFF_S 0.55f

/* Objects in the order in which they are built. */
enum { STAGE, BALL, CUBE, SLIDER, SPINNER, APPEARING, VANISHING, LAMP };
/* The emitter whose light goes out is the first material. */
enum { SWITCHED_LIGHT };

static void add_stage(scene *s)
{
    scene_begin_object(s);
    scene_emitter(s, vec3(34.0f, 9.0f, 5.0f));
    scene_add_panel(s, vec3(-3.3f, 1.7f, 1.0f), vec3(0.0f, 0.0f, 0.45f), vec3(0.0f, -0.25f, 0.0f));
    scene_emitter(s, vec3(4.0f, 11.0f, 30.0f));
    scene_add_panel(s, vec3(3.3f, 1.2f, 0.6f), vec3(0.0f, 0.0f, 0.30f), vec3(0.0f, 0.20f, 0.0f));
    pt_material *m = scene_material(s, vec3(0.55f, 0.53f, 0.50f), 0.16f, 0.0f);
    scene_texture(m, PT_TEXTURE_TILES, 1.5f, vec3(0.16f, 0.16f, 0.17f), 0.55f, 0.0f);
    scene_add_panel(s, vec3(0.0f, 0.0f, 2.0f), vec3(0.0f, 0.0f, 60.0f), vec3(60.0f, 0.0f, 0.0f));
    m = scene_material(s, vec3(0.62f, 0.60f, 0.56f), 0.8f, 0.0f);
    scene_texture(m, PT_TEXTURE_NOISE, 3.0f, vec3(0.48f, 0.45f, 0.42f), 0.9f, 0.01f);
    scene_add_box(s, vec3(0.0f, 1.25f, 3.6f), vec3(3.6f, 1.25f, 0.15f));
    scene_add_box(s, vec3(-3.5f, 1.1f, 1.6f), vec3(0.15f, 1.1f, 1.9f));
    scene_add_box(s, vec3(3.5f, 0.75f, 1.6f), vec3(0.15f, 0.75f, 1.9f));
    scene_material(s, vec3(0.9f, 0.9f, 0.9f), 0.03f, 1.0f);
    scene_add_panel(s, vec3(1.6f, 1.3f, 3.44f), vec3(0.9f, 0.0f, 0.0f), vec3(0.0f, -0.9f, 0.0f));
    scene_material(s, vec3(0.20f, 0.20f, 0.22f), 0.4f, 0.0f);
    scene_add_cylinder(s, vec3(2.2f, 0.0f, 0.8f), vec3(2.2f, 1.15f, 0.8f), 0.05f, 0.04f, 16); /* carries the spinner */
}

static void add_bodies(scene *s)
{
    scene_begin_object(s); /* BALL */
    pt_material *m = scene_material(s, vec3(0.80f, 0.12f, 0.06f), 0.22f, 0.0f);
    scene_texture(m, PT_TEXTURE_STRIPES, 3.0f, vec3(0.9f, 0.85f, 0.75f), 0.3f, 0.0f);
    scene_add_sphere(s, grey(0.0f), 0.32f, 40);
    scene_begin_object(s); /* CUBE */
    m = scene_material(s, vec3(0.15f, 0.45f, 0.18f), 0.5f, 0.0f);
    scene_texture(m, PT_TEXTURE_CHECKER, 5.0f, vec3(0.75f, 0.75f, 0.30f), 0.6f, 0.0f);
    scene_add_box(s, grey(0.0f), vec3(0.36f, 0.36f, 0.36f));
    scene_begin_object(s); /* SLIDER */
    scene_material(s, vec3(0.95f, 0.78f, 0.45f), 0.15f, 1.0f);
    scene_add_box(s, vec3(0.0f, 0.5f, 0.0f), vec3(0.12f, 0.5f, 0.35f));
    scene_begin_object(s); /* SPINNER */
    scene_material(s, vec3(0.35f, 0.42f, 0.75f), 0.45f, 0.0f);
    for (int i = 0; i < 3; i++) {
        scene_place(s, scene_rotation(vec3(0.0f, 0.0f, 1.0f), 2.0944f * (float)i));
        scene_add_box(s, vec3(0.0f, 0.35f, -0.06f), vec3(0.05f, 0.35f, 0.02f));
    }
    scene_begin_object(s); /* APPEARING */
    scene_material(s, vec3(0.10f, 0.40f, 0.65f), 0.35f, 0.0f);
    scene_add_sphere(s, vec3(-0.55f, 0.38f, -0.75f), 0.38f, 40);
    scene_begin_object(s); /* VANISHING */
    scene_material(s, vec3(0.70f, 0.25f, 0.60f), 0.6f, 0.0f);
    scene_add_cylinder(s, vec3(0.75f, 0.0f, -1.1f), vec3(0.75f, 0.85f, -1.1f), 0.28f, 0.22f, 32);
}

/* Hangs from the hook along -y; the bulb is open to below. */
static void add_lamp(scene *s)
{
    static const float shade[4][2] = { { 0.26f, -1.72f }, { 0.25f, -1.70f }, { 0.07f, -1.50f }, { 0.0f, -1.48f } };
    scene_begin_object(s);
    scene_material(s, vec3(0.08f, 0.08f, 0.09f), 0.4f, 0.0f);
    scene_add_cylinder(s, grey(0.0f), vec3(0.0f, -1.5f, 0.0f), 0.008f, 0.008f, 6);
    scene_material(s, vec3(0.10f, 0.30f, 0.22f), 0.3f, 0.0f);
    scene_add_lathe(s, shade, 4, 32);
    scene_emitter(s, vec3(120.0f, 92.0f, 55.0f));
    scene_add_sphere(s, vec3(0.0f, -1.66f, 0.0f), 0.07f, 12);
}

bool scene_build_moving(scene *s, const char *model, char *error, size_t error_size)
{
    (void)model, (void)error, (void)error_size;
    add_stage(s);
    add_bodies(s);
    add_lamp(s);
    s->sky = (scene_sky){ vec3(0.03f, 0.07f, 0.24f), vec3(0.30f, 0.20f, 0.17f), grey(0.05f), 0.03f };
    s->sun = (scene_sun){ vec3(-0.55f, 0.55f, -0.75f), vec3(2.6f, 2.0f, 1.35f), 0.02f };
    s->camera = (scene_camera){ vec3(0.0f, 1.75f, -4.6f), vec3(0.0f, 0.85f, 1.0f), 50.0f };
    return true;
}

void scene_animate_moving(scene *s, float time_s)
{
    const float turn = 2.0f * 3.14159265f;
    const vec3 z = vec3(0.0f, 0.0f, 1.0f);
    float phase = fract(time_s * 1.1f), swing = 0.55f * sinf(turn * 0.55f * time_s);
    scene_object *o = s->objects;
    vec3 ball = vec3(-1.9f + 0.9f * time_s, 0.32f + 3.2f * phase * (1.0f - phase), 0.5f);
    o[BALL].pose = scene_compose(scene_translation(ball), scene_rotation(z, -3.0f * time_s));
    vec3 axis = normalize(vec3(0.5f, 1.0f, 0.3f));
    o[CUBE].pose = scene_compose(scene_translation(vec3(-1.6f, 0.75f, 1.9f)), scene_rotation(axis, 1.8f * time_s));
    o[SLIDER].pose = scene_translation(vec3(0.9f - 1.5f * cosf(turn * 0.4f * time_s), 0.0f, 2.4f));
    o[SPINNER].pose = scene_compose(scene_translation(vec3(2.2f, 1.1f, 0.8f)), scene_rotation(z, 5.0f * time_s));
    o[APPEARING].visible = time_s >= APPEAR_S;
    o[VANISHING].visible = time_s < VANISH_S;
    o[LAMP].pose = scene_compose(scene_translation(vec3(0.3f, 3.9f, 0.2f)), scene_rotation(z, swing));
    vec3 red = time_s < LIGHT_OFF_S ? vec3(34.0f, 9.0f, 5.0f) : grey(0.0f);
    s->materials[SWITCHED_LIGHT].emission = red;
}
