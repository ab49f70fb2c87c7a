#include "raygen/scene.h"

#include <string.h>

enum { MATTE, MIRROR, LAMP, STRAND };

#define ROOM_HALF 4.0f
#define ROOM_HEIGHT 3.5f
#define LAMP_BOTTOM 3.3f
#define LAMP_HALF_X 0.9f
#define LAMP_HALF_Z 0.6f
#define LAMP_THICKNESS 0.05f
#define TAN_HALF_FOV_Y 0.5f
#define STRANDS 28

typedef struct part {
    float center[3], half[3]; /* metres */
    float color[3];
    int kind;
    float turn, turn_speed; /* radians about y, radians per frame */
    float swing;            /* metres to and fro along x */
} part;

static const part parts[] = {
    { { 0, -0.1f, 0 }, { ROOM_HALF, 0.1f, ROOM_HALF }, { 0.6f, 0.6f, 0.55f }, MATTE, 0, 0, 0 },              /* floor */
    { { 0, ROOM_HEIGHT + 0.1f, 0 }, { ROOM_HALF, 0.1f, ROOM_HALF }, { 0.8f, 0.8f, 0.8f }, MATTE, 0, 0, 0 },  /* ceiling */
    { { -ROOM_HALF - 0.1f, 1.75f, 0 }, { 0.1f, 1.75f, ROOM_HALF }, { 0.7f, 0.15f, 0.1f }, MATTE, 0, 0, 0 },  /* left, red */
    { { ROOM_HALF + 0.1f, 1.75f, 0 }, { 0.1f, 1.75f, ROOM_HALF }, { 0.15f, 0.5f, 0.2f }, MATTE, 0, 0, 0 },   /* right, green */
    { { 0, 1.75f, ROOM_HALF + 0.1f }, { ROOM_HALF, 1.75f, 0.1f }, { 0.75f, 0.75f, 0.75f }, MATTE, 0, 0, 0 }, /* back */
    { { 0, LAMP_BOTTOM + LAMP_THICKNESS, 0.5f }, { LAMP_HALF_X, LAMP_THICKNESS, LAMP_HALF_Z }, { 1, 1, 1 }, LAMP, 0, 0, 0 },
    { { -1.2f, 1.4f, ROOM_HALF - 0.05f }, { 1.5f, 1.1f, 0.05f }, { 0.9f, 0.9f, 0.92f }, MIRROR, 0, 0, 0 }, /* on the back wall */
    { { 2.6f, 1.1f, 2.2f }, { 0.9f, 1.1f, 0.05f }, { 0.85f, 0.9f, 0.85f }, MIRROR, -0.7f, 0.004f, 0 },     /* one that turns */
    { { -2.9f, 1.75f, 2.9f }, { 0.25f, 1.75f, 0.25f }, { 0.7f, 0.7f, 0.7f }, MATTE, 0, 0, 0 },             /* column */
    { { 1.4f, 0.45f, 0.3f }, { 0.45f, 0.45f, 0.45f }, { 0.8f, 0.6f, 0.2f }, MATTE, 0.3f, 0.03f, 0 },       /* one that turns */
    { { -0.8f, 0.7f, 1.2f }, { 0.35f, 0.7f, 0.35f }, { 0.2f, 0.35f, 0.8f }, MATTE, 0.5f, 0, 0.9f },        /* one that slides */
    { { -2.3f, 0.3f, -0.2f }, { 0.3f, 0.3f, 0.5f }, { 0.8f, 0.8f, 0.8f }, MATTE, -0.4f, 0, 0 },
};

/* Rows of the map from the cube to the world at a frame. */
static void place(const part *p, uint32_t frame_index, nrd_vec4 row[3])
{
    float angle = p->turn + p->turn_speed * (float)frame_index, c = cosf(angle), s = sinf(angle);
    float x = p->center[0] + p->swing * sinf(0.05f * (float)frame_index);
    row[0] = nrd_make_vec4(c * p->half[0], 0, s * p->half[2], x);
    row[1] = nrd_make_vec4(0, p->half[1], 0, p->center[1]);
    row[2] = nrd_make_vec4(-s * p->half[0], 0, c * p->half[2], p->center[2]);
}

/* A row of the inverse: an orthogonal column over its squared length, and minus that times the translation. */
static nrd_vec4 inverse_row(float x, float y, float z, const nrd_vec4 to_world[3])
{
    float scale = 1 / (x * x + y * y + z * z);
    float offset = x * to_world[0].w + y * to_world[1].w + z * to_world[2].w;
    return nrd_make_vec4(x * scale, y * scale, z * scale, -offset * scale);
}

/* A tuft of upright strands, each turned its own way, that sways. */
static part strand(uint32_t index)
{
    float golden = 0.618034f * (float)index, u = golden - floorf(golden), v = ((float)index + 0.5f) / STRANDS;
    float height = 0.45f + 0.1f * u;
    return (part){ .center = { 2.1f + 0.35f * u, height, -0.6f - 0.35f * v },
                   .half = { 0.012f, height, 0.012f },
                   .color = { 0.75f, 0.6f, 0.35f },
                   .kind = STRAND,
                   .turn = 6.2831853f * golden,
                   .swing = 0.03f };
}

uint32_t raygen_scene_boxes(uint32_t frame_index, raygen_box *boxes)
{
    uint32_t solid = sizeof parts / sizeof parts[0], count = solid + STRANDS;
    for (uint32_t i = 0; i < count; i++) {
        part one = i < solid ? parts[i] : strand(i - solid);
        const part *p = &one;
        nrd_vec4 now[3], prev[3];
        place(p, frame_index, now);
        place(p, frame_index ? frame_index - 1 : 0, prev);
        boxes[i] = (raygen_box){ .to_world_x = now[0],
                                 .to_world_y = now[1],
                                 .to_world_z = now[2],
                                 .to_world_prev_x = prev[0],
                                 .to_world_prev_y = prev[1],
                                 .to_world_prev_z = prev[2],
                                 .to_box_x = inverse_row(now[0].x, now[1].x, now[2].x, now),
                                 .to_box_y = inverse_row(now[0].y, now[1].y, now[2].y, now),
                                 .to_box_z = inverse_row(now[0].z, now[1].z, now[2].z, now),
                                 .color = nrd_make_vec4(p->color[0], p->color[1], p->color[2], (float)p->kind) };
    }
    return count;
}

/* ---- camera ---------------------------------------------------------------------------------------------------- */

typedef struct camera {
    nrd_vec3 position, right, up, forward;
} camera;

/* Walks to and fro before the room and looks at its middle. */
static camera camera_at(uint32_t frame_index)
{
    float t = 0.02f * (float)frame_index, yaw = -0.12f * sinf(t), pitch = -0.06f;
    camera c = { { 0.9f * sinf(t), 1.8f + 0.1f * sinf(2 * t), -6.2f }, { cosf(yaw), 0, -sinf(yaw) }, { 0, 0, 0 }, { 0, 0, 0 } };
    c.forward = nrd_make_vec3(sinf(yaw) * cosf(pitch), sinf(pitch), cosf(yaw) * cosf(pitch));
    c.up = nrd_make_vec3(-sinf(yaw) * sinf(pitch), cosf(pitch), -cosf(yaw) * sinf(pitch));
    return c;
}

static nrd_mat4 view_of(const camera *c)
{
    const nrd_vec3 *p = &c->position, *r = &c->right, *u = &c->up, *f = &c->forward;
    nrd_mat4 m = { { { r->x, u->x, f->x, 0 }, { r->y, u->y, f->y, 0 }, { r->z, u->z, f->z, 0 }, { 0, 0, 0, 1 } } };
    m.column[3].x = -(r->x * p->x + r->y * p->y + r->z * p->z);
    m.column[3].y = -(u->x * p->x + u->y * p->y + u->z * p->z);
    m.column[3].z = -(f->x * p->x + f->y * p->y + f->z * p->z);
    return m;
}

static nrd_vec4 scaled(nrd_vec3 v, float s)
{
    return nrd_make_vec4(v.x * s, v.y * s, v.z * s, 0);
}

raygen_frame raygen_scene_frame(uint32_t frame_index, uint32_t width, uint32_t height)
{
    camera now = camera_at(frame_index), prev = camera_at(frame_index ? frame_index - 1 : 0);
    float tan_x = TAN_HALF_FOV_Y * (float)width / (float)height;
    raygen_frame f;
    memset(&f, 0, sizeof f);
    f.world_to_view = view_of(&now);
    f.world_to_view_prev = view_of(&prev);
    f.view_to_clip.column[0].x = 1 / tan_x;
    f.view_to_clip.column[1].y = -1 / TAN_HALF_FOV_Y; /* clip y down */
    f.view_to_clip.column[2] = nrd_make_vec4(0, 0, 1, 1);
    f.view_to_clip.column[3].z = -0.1f; /* near plane; no far plane */
    f.view_to_clip_prev = f.view_to_clip;
    f.camera = scaled(now.position, 1);
    f.right = scaled(now.right, tan_x);
    f.up = scaled(now.up, TAN_HALF_FOV_Y);
    f.forward = scaled(now.forward, 1);
    f.lamp = nrd_make_vec4(0, LAMP_BOTTOM, 0.5f, 0);
    f.lamp_half = nrd_make_vec4(LAMP_HALF_X, 0, LAMP_HALF_Z, 0);
    f.lamp_radiance = nrd_make_vec4(14, 12, 9, 0);
    f.sky = nrd_make_vec4(0.25f, 0.35f, 0.5f, 1000);
    f.hit_dist_params = nrd_make_vec4(3, 0.1f, 20, -25);
    f.width = width;
    f.height = height;
    f.frame_index = frame_index;
    return f;
}
