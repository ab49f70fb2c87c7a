/* Two rows of columns carry a slotted roof over a marble floor: long sharp-to-soft shadows, sky light, strong parallax
   as the camera strafes. */
#include "scenes/scenes.h"

enum { PAIRS = 9 };
static const float spacing = 2.2f;

static void add_column(scene *s, vec3 base, uint32_t marble, uint32_t stone)
{
    static const float shaft[14][2] = { { 0.43f, 0.15f },  { 0.43f, 0.20f }, { 0.42f, 0.25f }, { 0.36f, 0.27f },
                                        { 0.345f, 0.34f }, { 0.345f, 1.2f }, { 0.335f, 2.0f }, { 0.315f, 2.8f },
                                        { 0.29f, 3.5f },   { 0.32f, 3.52f }, { 0.32f, 3.58f }, { 0.30f, 3.60f },
                                        { 0.42f, 3.78f },  { 0.42f, 3.82f } };
    scene_use_material(s, stone);
    scene_add_box(s, base + vec3(0.0f, 0.08f, 0.0f), vec3(0.48f, 0.08f, 0.48f));
    scene_add_box(s, base + vec3(0.0f, 3.90f, 0.0f), vec3(0.46f, 0.08f, 0.46f));
    scene_use_material(s, marble);
    scene_place(s, scene_translation(base));
    scene_add_lathe(s, shaft, 14, 28);
    scene_place(s, scene_identity());
}

static void add_ground(scene *s)
{
    const float half = 0.5f * spacing * (float)PAIRS;
    pt_material *m = scene_material(s, vec3(0.62f, 0.60f, 0.55f), 0.22f, 0.0f);
    scene_texture(m, PT_TEXTURE_TILES, 1.1f, vec3(0.30f, 0.27f, 0.24f), 0.6f, -0.003f);
    scene_add_box(s, vec3(0.0f, -0.1f, 0.0f), vec3(half + 1.0f, 0.1f, 2.8f));
    m = scene_material(s, vec3(0.30f, 0.27f, 0.20f), 0.95f, 0.0f);
    scene_texture(m, PT_TEXTURE_NOISE, 0.8f, vec3(0.16f, 0.20f, 0.09f), 1.0f, 0.05f);
    scene_add_panel(s, vec3(0.0f, -0.3f, 0.0f), vec3(0.0f, 0.0f, 60.0f), vec3(60.0f, 0.0f, 0.0f));
    m = scene_material(s, vec3(0.56f, 0.40f, 0.28f), 0.85f, 0.0f);
    scene_texture(m, PT_TEXTURE_BRICK, 1.4f, vec3(0.48f, 0.43f, 0.37f), 0.95f, -0.02f);
    scene_add_box(s, vec3(0.0f, 1.1f, 7.5f), vec3(24.0f, 1.4f, 0.25f));
}

static void add_roof(scene *s)
{
    const float half = 0.5f * spacing * (float)PAIRS;
    for (int side = -1; side <= 1; side += 2)
        scene_add_box(s, vec3(0.0f, 4.18f, 1.9f * (float)side), vec3(half, 0.2f, 0.36f));
    for (int i = 0; i < 2 * PAIRS; i++) {
        float x = -half + 0.5f * spacing * ((float)i + 0.5f);
        scene_add_box(s, vec3(x, 4.46f, 0.0f), vec3(0.14f, 0.10f, 2.5f));
    }
}

static void add_ornaments(scene *s)
{
    static const float urn[11][2] = { { 0.0f, 0.0f },   { 0.22f, 0.0f },  { 0.22f, 0.05f }, { 0.08f, 0.12f },
                                      { 0.07f, 0.20f }, { 0.24f, 0.42f }, { 0.30f, 0.62f }, { 0.25f, 0.80f },
                                      { 0.17f, 0.88f }, { 0.26f, 0.98f }, { 0.0f, 0.90f } };
    for (int i = 0; i < 4; i++) {
        vec3 at = vec3(spacing * (2.0f * (float)i - 3.0f), 0.0f, -0.3f + 0.5f * (float)(i % 2));
        scene_material(s, vec3(0.50f, 0.48f, 0.45f), 0.7f, 0.0f);
        scene_add_box(s, at + vec3(0.0f, 0.35f, 0.0f), vec3(0.28f, 0.35f, 0.28f));
        scene_place(s, scene_translation(at + vec3(0.0f, 0.7f, 0.0f)));
        if (i % 2)
            scene_material(s, vec3(0.90f, 0.62f, 0.30f), 0.25f, 1.0f);
        else
            scene_material(s, vec3(0.10f, 0.28f, 0.30f), 0.12f, 0.0f);
        scene_add_lathe(s, urn, 11, 36);
        scene_place(s, scene_identity());
    }
}

bool scene_build_colonnade(scene *s, const char *model, char *error, size_t error_size)
{
    (void)model, (void)error, (void)error_size;
    scene_begin_object(s);
    add_ground(s);
    pt_material *m = scene_material(s, vec3(0.78f, 0.74f, 0.66f), 0.45f, 0.0f);
    scene_texture(m, PT_TEXTURE_NOISE, 2.2f, vec3(0.62f, 0.57f, 0.50f), 0.6f, 0.0f);
    uint32_t marble = scene_last_material(s);
    scene_material(s, vec3(0.66f, 0.60f, 0.50f), 0.85f, 0.0f);
    uint32_t stone = scene_last_material(s);
    for (int i = 0; i < PAIRS; i++)
        for (int side = -1; side <= 1; side += 2)
            add_column(s, vec3(spacing * ((float)i - 0.5f * (float)(PAIRS - 1)), 0.0f, 1.9f * (float)side), marble,
                       stone);
    scene_use_material(s, stone);
    add_roof(s);
    add_ornaments(s);
    s->sky = (scene_sky){ vec3(0.09f, 0.20f, 0.52f), vec3(0.46f, 0.42f, 0.40f), vec3(0.12f, 0.11f, 0.09f), 0.04f };
    s->sun = (scene_sun){ vec3(0.80f, 0.62f, -0.38f), vec3(8.5f, 7.0f, 4.9f), 0.009f };
    return true;
}

void scene_animate_colonnade(scene *s, float time_s)
{
    float x = -2.1f + 1.6f * time_s;
    s->camera.eye = vec3(x, 1.65f, -5.6f);
    s->camera.target = vec3(x + 2.4f, 1.75f, 0.0f);
    s->camera.fov_y = 56.0f;
}
