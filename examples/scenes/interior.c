/* A furnished room lit by small panels, a shaded bulb and nothing else: sharp and soft shadows at once, textured walls,
   a mirror, and colour that bleeds. The camera dollies in and pans a little. */
#include "scenes/scenes.h"

enum { ROOM_X = 3, ROOM_Z = 4 };
static const float room_height = 2.8f;

static void add_shell(scene *s)
{
    const float x = ROOM_X, z = ROOM_Z, h = room_height;
    pt_material *m = scene_material(s, vec3(0.42f, 0.25f, 0.13f), 0.28f, 0.0f);
    scene_texture(m, PT_TEXTURE_WOOD, 1.2f, vec3(0.22f, 0.11f, 0.05f), 0.45f, 0.002f);
    scene_add_panel(s, vec3(0.0f, 0.0f, 0.0f), vec3(0.0f, 0.0f, z), vec3(x, 0.0f, 0.0f));
    scene_material(s, vec3(0.80f, 0.79f, 0.76f), 0.9f, 0.0f);
    scene_add_panel(s, vec3(0.0f, h, 0.0f), vec3(x, 0.0f, 0.0f), vec3(0.0f, 0.0f, z));
    m = scene_material(s, vec3(0.55f, 0.23f, 0.15f), 0.75f, 0.0f);
    scene_texture(m, PT_TEXTURE_BRICK, 4.0f, vec3(0.62f, 0.57f, 0.50f), 0.95f, -0.006f);
    scene_add_panel(s, vec3(0.0f, 0.5f * h, z), vec3(-x, 0.0f, 0.0f), vec3(0.0f, 0.5f * h, 0.0f));
    m = scene_material(s, vec3(0.70f, 0.66f, 0.55f), 0.85f, 0.0f);
    scene_texture(m, PT_TEXTURE_NOISE, 6.0f, vec3(0.76f, 0.73f, 0.62f), 0.9f, 0.004f);
    scene_add_panel(s, vec3(-x, 0.5f * h, 0.0f), vec3(0.0f, 0.0f, -z), vec3(0.0f, 0.5f * h, 0.0f));
    scene_add_panel(s, vec3(0.0f, 0.5f * h, -z), vec3(x, 0.0f, 0.0f), vec3(0.0f, 0.5f * h, 0.0f));
    m = scene_material(s, vec3(0.18f, 0.33f, 0.36f), 0.7f, 0.0f);
    scene_texture(m, PT_TEXTURE_STRIPES, 2.5f, vec3(0.22f, 0.40f, 0.42f), 0.55f, 0.0f);
    scene_add_panel(s, vec3(x, 0.5f * h, 0.0f), vec3(0.0f, 0.0f, z), vec3(0.0f, 0.5f * h, 0.0f));
    scene_material(s, vec3(0.85f, 0.83f, 0.78f), 0.4f, 0.0f);
    scene_add_box(s, vec3(0.0f, 0.06f, z - 0.015f), vec3(x, 0.06f, 0.015f));
    scene_add_box(s, vec3(-x + 0.015f, 0.06f, 0.0f), vec3(0.015f, 0.06f, z));
    scene_add_box(s, vec3(x - 0.015f, 0.06f, 0.0f), vec3(0.015f, 0.06f, z));
}

static void add_lights(scene *s)
{
    scene_emitter(s, vec3(62.0f, 52.0f, 40.0f));
    for (int i = 0; i < 3; i++) {
        vec3 c = vec3(-1.5f + 1.6f * (float)(i % 2), room_height - 0.03f, -1.4f + 2.0f * (float)i);
        scene_add_panel(s, c, vec3(0.12f, 0.0f, 0.0f), vec3(0.0f, 0.0f, 0.12f));
    }
    scene_emitter(s, vec3(15.0f, 9.5f, 4.6f));
    scene_add_sphere(s, vec3(-2.45f, 1.50f, 3.35f), 0.09f, 10);
    static const float shade[3][2] = { { 0.24f, 1.30f }, { 0.235f, 1.31f }, { 0.13f, 1.68f } };
    static const float stand[6][2] = { { 0.16f, 0.0f },  { 0.16f, 0.02f }, { 0.015f, 0.05f },
                                       { 0.012f, 1.4f }, { 0.01f, 1.44f }, { 0.0f, 1.44f } };
    scene_place(s, scene_translation(vec3(-2.45f, 0.0f, 3.35f)));
    scene_material(s, vec3(0.70f, 0.58f, 0.42f), 0.9f, 0.0f);
    scene_add_lathe(s, shade, 3, 32);
    scene_material(s, vec3(0.85f, 0.62f, 0.30f), 0.22f, 1.0f);
    scene_add_lathe(s, stand, 6, 24);
    scene_place(s, scene_identity());
    scene_emitter(s, vec3(6.0f, 12.0f, 26.0f));
    scene_add_panel(s, vec3(ROOM_X - 0.04f, 1.75f, -0.4f), vec3(0.0f, 0.0f, 0.30f), vec3(0.0f, 0.04f, 0.0f));
}

static void add_legs(scene *s, vec3 center, float half_x, float half_z, float height, float half_width)
{
    for (int i = 0; i < 4; i++) {
        float x = i & 1 ? half_x : -half_x, z = i & 2 ? half_z : -half_z;
        scene_add_box(s, center + vec3(x, 0.5f * height, z), vec3(half_width, 0.5f * height, half_width));
    }
}

static void add_table(scene *s, vec3 c)
{
    pt_material *m = scene_material(s, vec3(0.36f, 0.20f, 0.10f), 0.18f, 0.0f);
    scene_texture(m, PT_TEXTURE_WOOD, 2.0f, vec3(0.20f, 0.10f, 0.05f), 0.30f, 0.0f);
    scene_add_box(s, c + vec3(0.0f, 0.74f, 0.0f), vec3(0.80f, 0.02f, 0.50f));
    add_legs(s, c, 0.72f, 0.42f, 0.72f, 0.03f);
    for (int i = 0; i < 2; i++) {
        vec3 chair = c + vec3(i ? 0.4f : -0.4f, 0.0f, i ? -0.85f : 0.85f);
        float back = i ? -0.19f : 0.19f;
        scene_material(s, i ? vec3(0.55f, 0.12f, 0.08f) : vec3(0.10f, 0.24f, 0.40f), 0.5f, 0.0f);
        scene_add_box(s, chair + vec3(0.0f, 0.45f, 0.0f), vec3(0.21f, 0.025f, 0.21f));
        add_legs(s, chair, 0.18f, 0.18f, 0.43f, 0.018f);
        for (int k = 0; k < 4; k++)
            scene_add_box(s, chair + vec3(-0.165f + 0.11f * (float)k, 0.70f, back), vec3(0.014f, 0.24f, 0.014f));
        scene_add_box(s, chair + vec3(0.0f, 0.95f, back), vec3(0.20f, 0.03f, 0.018f));
    }
}

static void add_tableware(scene *s, vec3 top)
{
    static const float vase[9][2] = { { 0.0f, 0.0f },    { 0.06f, 0.0f },   { 0.09f, 0.06f },
                                      { 0.10f, 0.12f },  { 0.07f, 0.20f },  { 0.035f, 0.27f },
                                      { 0.035f, 0.30f }, { 0.055f, 0.34f }, { 0.045f, 0.34f } };
    static const float bowl[6][2] = { { 0.0f, 0.0f },   { 0.05f, 0.0f },  { 0.12f, 0.04f },
                                      { 0.16f, 0.09f }, { 0.15f, 0.09f }, { 0.0f, 0.015f } };
    scene_place(s, scene_translation(top + vec3(-0.30f, 0.0f, 0.10f)));
    scene_material(s, vec3(0.08f, 0.20f, 0.42f), 0.08f, 0.0f);
    scene_add_lathe(s, vase, 9, 40);
    scene_place(s, scene_translation(top + vec3(0.25f, 0.0f, -0.05f)));
    scene_material(s, vec3(0.90f, 0.87f, 0.80f), 0.25f, 0.0f);
    scene_add_lathe(s, bowl, 6, 40);
    scene_place(s, scene_identity());
    scene_material(s, vec3(0.75f, 0.22f, 0.05f), 0.35f, 0.0f);
    scene_add_sphere(s, top + vec3(0.22f, 0.07f, -0.04f), 0.045f, 20);
    scene_add_sphere(s, top + vec3(0.29f, 0.07f, -0.09f), 0.045f, 20);
    scene_material(s, vec3(0.95f, 0.93f, 0.88f), 0.04f, 1.0f);
    scene_add_sphere(s, top + vec3(0.0f, 0.09f, 0.22f), 0.09f, 40);
}

static void add_sofa(scene *s, vec3 c)
{
    pt_material *m = scene_material(s, vec3(0.16f, 0.28f, 0.20f), 0.95f, 0.0f);
    scene_texture(m, PT_TEXTURE_NOISE, 30.0f, vec3(0.20f, 0.36f, 0.25f), 0.95f, 0.003f);
    scene_add_box(s, c + vec3(0.0f, 0.22f, 0.0f), vec3(0.42f, 0.14f, 0.95f));
    scene_add_box(s, c + vec3(-0.36f, 0.52f, 0.0f), vec3(0.10f, 0.26f, 0.95f));
    scene_add_box(s, c + vec3(0.0f, 0.40f, 0.95f), vec3(0.42f, 0.22f, 0.10f));
    scene_add_box(s, c + vec3(0.0f, 0.40f, -0.95f), vec3(0.42f, 0.22f, 0.10f));
    scene_material(s, vec3(0.72f, 0.45f, 0.12f), 0.9f, 0.0f);
    scene_place(s, scene_compose(scene_translation(c + vec3(-0.14f, 0.55f, 0.6f)),
                                 scene_rotation(vec3(0.0f, 0.0f, 1.0f), 0.35f)));
    scene_add_box(s, grey(0.0f), vec3(0.06f, 0.19f, 0.19f));
    scene_place(s, scene_identity());
}

static void add_shelf(scene *s, vec3 c)
{
    uint32_t random = 7;
    scene_material(s, vec3(0.80f, 0.78f, 0.72f), 0.35f, 0.0f);
    uint32_t board = scene_last_material(s);
    for (int row = 0; row < 4; row++) {
        scene_use_material(s, board);
        float y = 0.35f + 0.42f * (float)row;
        scene_add_box(s, c + vec3(0.0f, y, 0.0f), vec3(0.75f, 0.015f, 0.15f));
        for (float x = -0.70f; x < 0.66f && row < 3;) {
            float w = 0.012f + 0.02f * scene_random(&random), h = 0.10f + 0.06f * scene_random(&random);
            vec3 color = scene_random3(&random, vec3(0.08f, 0.08f, 0.06f), vec3(0.68f, 0.48f, 0.46f));
            if (scene_random(&random) < 0.82f) {
                scene_material(s, color, 0.4f + 0.4f * scene_random(&random), 0.0f);
                scene_add_box(s, c + vec3(x + w, y + 0.015f + h, 0.02f * scene_random(&random)), vec3(w, h, 0.10f));
            }
            x += 2.0f * w + 0.004f;
        }
    }
    scene_use_material(s, board);
    scene_add_box(s, c + vec3(-0.765f, 0.82f, 0.0f), vec3(0.015f, 0.82f, 0.15f));
    scene_add_box(s, c + vec3(0.765f, 0.82f, 0.0f), vec3(0.015f, 0.82f, 0.15f));
}

static void add_mirror_and_rug(scene *s)
{
    scene_material(s, vec3(0.80f, 0.58f, 0.25f), 0.3f, 1.0f);
    scene_add_box(s, vec3(-ROOM_X + 0.02f, 1.55f, 1.0f), vec3(0.02f, 0.65f, 0.48f));
    scene_material(s, vec3(0.95f, 0.95f, 0.95f), 0.0f, 1.0f);
    scene_add_panel(s, vec3(-ROOM_X + 0.045f, 1.55f, 1.0f), vec3(0.0f, 0.0f, -0.43f), vec3(0.0f, 0.60f, 0.0f));
    pt_material *m = scene_material(s, vec3(0.48f, 0.08f, 0.07f), 1.0f, 0.0f);
    scene_texture(m, PT_TEXTURE_CHECKER, 4.0f, vec3(0.65f, 0.52f, 0.36f), 1.0f, 0.0f);
    scene_add_box(s, vec3(0.2f, 0.008f, 1.3f), vec3(1.4f, 0.008f, 1.1f));
}

bool scene_build_interior(scene *s, const char *model, char *error, size_t error_size)
{
    (void)model, (void)error, (void)error_size;
    scene_begin_object(s);
    add_shell(s);
    add_lights(s);
    add_table(s, vec3(0.3f, 0.0f, 1.3f));
    add_tableware(s, vec3(0.3f, 0.76f, 1.3f));
    add_sofa(s, vec3(-2.5f, 0.0f, 1.0f));
    add_shelf(s, vec3(1.3f, 0.0f, ROOM_Z - 0.18f));
    add_mirror_and_rug(s);
    return true;
}

void scene_animate_interior(scene *s, float time_s)
{
    s->camera.eye = vec3(1.55f - 0.30f * time_s, 1.60f, -2.1f + 0.85f * time_s);
    s->camera.target = vec3(-0.55f + 0.10f * time_s, 0.85f, 1.9f);
    s->camera.fov_y = 58.0f;
}
