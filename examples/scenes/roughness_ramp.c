/* Spheres of roughness 0 to 1, metal in front and varnish behind, between two mirrors over a checker floor: every width
   of the specular lobe, reflections of reflections, and curved reflectors under an orbiting camera. */
#include "scenes/scenes.h"

enum { SPHERES = 8 };

static void add_spheres(scene *s)
{
    for (int i = 0; i < SPHERES; i++) {
        float t = (float)i / (float)(SPHERES - 1), x = -3.15f + 0.9f * (float)i;
        scene_material(s, lerp3(vec3(0.95f, 0.82f, 0.58f), vec3(0.93f, 0.90f, 0.88f), t), t, 1.0f);
        scene_add_sphere(s, vec3(x, 0.40f, -0.2f), 0.40f, 36);
        scene_material(s, lerp3(vec3(0.55f, 0.05f, 0.06f), vec3(0.06f, 0.12f, 0.50f), t), t, 0.0f);
        scene_add_sphere(s, vec3(x + 0.45f, 0.32f, 0.95f), 0.32f, 28);
    }
}

static void add_stage(scene *s)
{
    pt_material *m = scene_material(s, vec3(0.70f, 0.68f, 0.64f), 0.12f, 0.0f);
    scene_texture(m, PT_TEXTURE_CHECKER, 2.0f, vec3(0.07f, 0.07f, 0.08f), 0.42f, 0.0f);
    scene_add_panel(s, vec3(0.0f, 0.0f, 0.0f), vec3(0.0f, 0.0f, 6.0f), vec3(7.0f, 0.0f, 0.0f));
    m = scene_material(s, vec3(0.26f, 0.24f, 0.22f), 0.95f, 0.0f);
    scene_texture(m, PT_TEXTURE_NOISE, 1.0f, vec3(0.36f, 0.32f, 0.26f), 0.95f, 0.0f);
    scene_add_panel(s, vec3(0.0f, -0.02f, 0.0f), vec3(0.0f, 0.0f, 80.0f), vec3(80.0f, 0.0f, 0.0f));
    scene_material(s, vec3(0.10f, 0.10f, 0.11f), 0.5f, 0.0f);
    scene_add_box(s, vec3(-2.1f, 1.05f, 2.65f), vec3(1.75f, 1.05f, 0.05f));
    scene_add_box(s, vec3(2.1f, 1.05f, 2.65f), vec3(1.75f, 1.05f, 0.05f));
    scene_material(s, vec3(0.96f, 0.96f, 0.97f), 0.0f, 1.0f);
    scene_add_panel(s, vec3(-2.1f, 1.05f, 2.59f), vec3(1.68f, 0.0f, 0.0f), vec3(0.0f, -0.98f, 0.0f));
    scene_material(s, vec3(0.96f, 0.96f, 0.97f), 0.22f, 1.0f);
    scene_add_panel(s, vec3(2.1f, 1.05f, 2.59f), vec3(1.68f, 0.0f, 0.0f), vec3(0.0f, -0.98f, 0.0f));
}

static void add_lights(scene *s)
{
    static const float colors[4][3] = {
        { 1.0f, 0.25f, 0.12f }, { 1.0f, 0.72f, 0.30f }, { 0.20f, 0.85f, 0.50f }, { 0.25f, 0.40f, 1.0f }
    };
    for (int i = 0; i < 4; i++) {
        float x = -2.7f + 1.8f * (float)i;
        scene_emitter(s, vec3(colors[i][0], colors[i][1], colors[i][2]) * 60.0f);
        scene_add_panel(s, vec3(x, 2.5f, 0.4f), vec3(0.13f, 0.0f, 0.0f), vec3(0.0f, 0.0f, 0.13f));
        scene_material(s, grey(0.05f), 0.5f, 0.0f);
        scene_add_cylinder(s, vec3(x, 2.51f, 0.4f), vec3(x, 2.51f, 2.7f), 0.02f, 0.02f, 8);
        scene_add_cylinder(s, vec3(x, 2.52f, 2.7f), vec3(x, 0.0f, 2.75f), 0.03f, 0.03f, 8);
    }
}

bool scene_build_roughness_ramp(scene *s, const char *model, char *error, size_t error_size)
{
    (void)model, (void)error, (void)error_size;
    scene_begin_object(s);
    add_stage(s);
    add_spheres(s);
    add_lights(s);
    s->sky = (scene_sky){ vec3(0.10f, 0.17f, 0.42f), vec3(0.62f, 0.40f, 0.28f), vec3(0.10f, 0.08f, 0.07f), 0.10f };
    s->sun = (scene_sun){ vec3(-0.80f, 0.42f, -0.45f), vec3(2.4f, 1.7f, 1.0f), 0.012f };
    return true;
}

void scene_animate_roughness_ramp(scene *s, float time_s)
{
    float angle = -0.35f + 0.42f * time_s;
    s->camera.target = vec3(0.0f, 0.55f, 0.5f);
    s->camera.eye = s->camera.target + vec3(6.2f * sinf(angle), 1.55f, -6.2f * cosf(angle));
    s->camera.fov_y = 40.0f;
}
