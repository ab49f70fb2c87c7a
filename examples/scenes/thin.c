/* Geometry thinner than a pixel or nearly so: pickets, wire fence, overhead wires, grass that sways. Every edge
   uncovers something as the camera strafes. */
#include "scenes/scenes.h"

enum { TUFT_GROUPS = 12, BLADES_PER_GROUP = 220 };

/* A blade is a tapering strip of three segments, bent away from the vertical. */
static void add_blade(scene *s, vec3 root, float height, float lean, float angle, float width)
{
    vec3 side = vec3(cosf(angle), 0.0f, sinf(angle)), out = vec3(-sinf(angle), 0.0f, cosf(angle));
    for (int i = 0; i < 3; i++) {
        float t0 = (float)i / 3.0f, t1 = (float)(i + 1) / 3.0f;
        vec3 a = root + vec3(0.0f, height * t0, 0.0f) + out * (lean * t0 * t0);
        vec3 b = root + vec3(0.0f, height * t1, 0.0f) + out * (lean * t1 * t1);
        vec3 wa = side * (width * (1.0f - t0)), wb = side * (width * (1.0f - t1));
        vec3 n = normalize(cross(side, b - a) * -1.0f + vec3(0.0f, 0.3f, 0.0f));
        scene_triangle t = { .p = { a - wa, a + wa, b + wb }, .n = { n, n, n } };
        scene_add_triangle(s, &t);
        t.p[1] = b + wb;
        t.p[2] = b - wb;
        if (i < 2) scene_add_triangle(s, &t);
    }
}

/* One object for each group, so that groups sway in turn. Their origin lies on the ground. */
static void add_grass(scene *s)
{
    uint32_t random = 11;
    for (int g = 0; g < TUFT_GROUPS; g++) {
        scene_begin_object(s);
        scene_material(s, scene_random3(&random, vec3(0.10f, 0.26f, 0.05f), vec3(0.15f, 0.36f, 0.05f)), 0.55f, 0.0f);
        for (int i = 0; i < BLADES_PER_GROUP; i++) {
            float r = 0.75f * sqrtf(scene_random(&random)), a = 6.2832f * scene_random(&random);
            float height = 0.12f + 0.30f * scene_random(&random) * (1.2f - r);
            float lean = 0.05f + 0.15f * scene_random(&random), angle = 6.2832f * scene_random(&random);
            float width = 0.004f + 0.005f * scene_random(&random);
            add_blade(s, vec3(1.4f * r * cosf(a), 0.0f, r * sinf(a)), height, lean, angle, width);
        }
    }
}

static void add_picket_fence(scene *s)
{
    pt_material *m = scene_material(s, vec3(0.82f, 0.80f, 0.75f), 0.6f, 0.0f);
    scene_texture(m, PT_TEXTURE_WOOD, 1.5f, vec3(0.70f, 0.66f, 0.58f), 0.7f, 0.0f);
    for (int i = 0; i < 46; i++) {
        float x = -5.2f + 0.16f * (float)i;
        scene_add_box(s, vec3(x, 0.50f, 2.6f), vec3(0.035f, 0.46f, 0.010f));
        scene_add_cylinder(s, vec3(x, 0.96f, 2.6f), vec3(x, 1.06f, 2.6f), 0.035f, 0.0f, 4);
    }
    scene_add_box(s, vec3(-1.6f, 0.30f, 2.63f), vec3(3.7f, 0.03f, 0.015f));
    scene_add_box(s, vec3(-1.6f, 0.78f, 2.63f), vec3(3.7f, 0.03f, 0.015f));
}

static void add_wire_fence(scene *s)
{
    scene_material(s, vec3(0.60f, 0.61f, 0.63f), 0.35f, 1.0f);
    for (int i = 0; i < 30; i++) {
        float x = 0.1f + 0.10f * (float)i;
        scene_add_cylinder(s, vec3(x, 0.05f, 1.4f), vec3(x + 1.35f, 1.40f, 1.4f), 0.004f, 0.004f, 5);
        scene_add_cylinder(s, vec3(x + 1.35f, 0.05f, 1.41f), vec3(x, 1.40f, 1.41f), 0.004f, 0.004f, 5);
    }
    for (int i = 0; i < 5; i++) {
        float x = 0.1f + 1.1f * (float)i;
        scene_add_cylinder(s, vec3(x, 0.0f, 1.43f), vec3(x, 1.5f, 1.43f), 0.025f, 0.025f, 10);
    }
    scene_add_cylinder(s, vec3(0.1f, 1.41f, 1.42f), vec3(4.5f, 1.41f, 1.42f), 0.012f, 0.012f, 8);
}

static void add_pole(scene *s, float x, float z)
{
    scene_add_cylinder(s, vec3(x, -0.1f, z), vec3(x, 4.6f, z), 0.08f, 0.06f, 12);
    scene_add_box(s, vec3(x, 4.25f, z), vec3(0.03f, 0.04f, 0.75f));
}

static void add_wires(scene *s)
{
    scene_material(s, vec3(0.20f, 0.15f, 0.11f), 0.9f, 0.0f);
    for (int i = 0; i < 4; i++) add_pole(s, -9.0f + 6.0f * (float)i, 7.0f);
    scene_material(s, vec3(0.06f, 0.06f, 0.07f), 0.4f, 0.0f);
    for (int wire = 0; wire < 4; wire++)
        for (int i = 0; i < 24; i++) { /* parabolas between the poles, eight pieces a span */
            float a = (float)(i % 8) / 8.0f, b = (float)(i % 8 + 1) / 8.0f, x = -9.0f + 6.0f * (float)(i / 8),
                  z = 6.4f + 0.4f * (float)wire;
            vec3 p = vec3(x + 6.0f * a, 4.3f - 2.4f * a * (1.0f - a), z),
                 q = vec3(x + 6.0f * b, 4.3f - 2.4f * b * (1.0f - b), z);
            scene_add_cylinder(s, p, q, 0.012f, 0.012f, 5);
        }
}

static void add_surroundings(scene *s)
{
    pt_material *m = scene_material(s, vec3(0.20f, 0.17f, 0.10f), 0.95f, 0.0f);
    scene_texture(m, PT_TEXTURE_NOISE, 1.6f, vec3(0.13f, 0.19f, 0.07f), 1.0f, 0.03f);
    scene_add_panel(s, vec3(0.0f, 0.0f, 20.0f), vec3(0.0f, 0.0f, 60.0f), vec3(60.0f, 0.0f, 0.0f));
    m = scene_material(s, vec3(0.62f, 0.36f, 0.26f), 0.85f, 0.0f);
    scene_texture(m, PT_TEXTURE_BRICK, 2.2f, vec3(0.60f, 0.56f, 0.50f), 0.95f, -0.01f);
    scene_add_box(s, vec3(-3.6f, 1.4f, 10.0f), vec3(2.6f, 1.4f, 1.5f));
    scene_material(s, vec3(0.30f, 0.12f, 0.09f), 0.8f, 0.0f);
    scene_add_cylinder(s, vec3(-3.6f, 2.8f, 10.0f), vec3(-3.6f, 4.6f, 10.0f), 3.4f, 0.0f, 4);
    scene_material(s, vec3(0.75f, 0.77f, 0.80f), 0.12f, 1.0f);
    scene_add_sphere(s, vec3(0.9f, 0.55f, 3.4f), 0.55f, 40);
}

bool scene_build_thin(scene *s, const char *model, char *error, size_t error_size)
{
    (void)model, (void)error, (void)error_size;
    add_grass(s); /* objects 0 to TUFT_GROUPS - 1 */
    scene_begin_object(s);
    add_surroundings(s);
    add_picket_fence(s);
    add_wire_fence(s);
    add_wires(s);
    s->sky = (scene_sky){ vec3(0.10f, 0.22f, 0.58f), vec3(0.50f, 0.54f, 0.60f), vec3(0.10f, 0.10f, 0.07f), 0.04f };
    s->sun = (scene_sun){ vec3(-0.65f, 0.50f, -0.20f), vec3(7.5f, 6.4f, 4.8f), 0.00465f };
    return true;
}

void scene_animate_thin(scene *s, float time_s)
{
    for (int g = 0; g < TUFT_GROUPS; g++) {
        float x = -4.4f + 2.2f * (float)(g % 6) + 0.7f * (float)(g / 6), z = g < 6 ? 0.5f : 1.9f;
        float sway = 0.10f * sinf(2.6f * time_s + 1.3f * (float)g);
        s->objects[g].pose =
            scene_compose(scene_translation(vec3(x, 0.0f, z)), scene_rotation(vec3(0.0f, 0.0f, 1.0f), sway));
    }
    float x = -1.4f + 1.1f * time_s;
    s->camera.eye = vec3(x, 1.15f, -2.6f);
    s->camera.target = vec3(x + 0.5f, 1.05f, 3.0f);
    s->camera.fov_y = 50.0f;
}
