#include "scenes/scene.h"
#include "tracer/sampling.glsl"

/* ---- transforms ---- */

scene_transform scene_identity(void)
{
    return (scene_transform){ vec3(1.0f, 0.0f, 0.0f), vec3(0.0f, 1.0f, 0.0f), vec3(0.0f, 0.0f, 1.0f),
                              vec3(0.0f, 0.0f, 0.0f) };
}

scene_transform scene_translation(vec3 t)
{
    scene_transform r = scene_identity();
    r.t = t;
    return r;
}

scene_transform scene_scaling(float factor)
{
    return (scene_transform){ vec3(factor, 0.0f, 0.0f), vec3(0.0f, factor, 0.0f), vec3(0.0f, 0.0f, factor),
                              grey(0.0f) };
}

/* Rodrigues' formula. */
static vec3 rotated(vec3 v, vec3 axis, float radians)
{
    float c = cosf(radians), s = sinf(radians);
    return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1.0f - c));
}

scene_transform scene_rotation(vec3 axis, float radians)
{
    scene_transform r = scene_identity();
    r.x = rotated(r.x, axis, radians);
    r.y = rotated(r.y, axis, radians);
    r.z = rotated(r.z, axis, radians);
    return r;
}

vec3 scene_vector(const scene_transform *x, vec3 v) { return x->x * v[0] + x->y * v[1] + x->z * v[2]; }

vec3 scene_point(const scene_transform *x, vec3 p) { return scene_vector(x, p) + x->t; }

scene_transform scene_compose(scene_transform outer, scene_transform inner)
{
    return (scene_transform){ scene_vector(&outer, inner.x), scene_vector(&outer, inner.y),
                              scene_vector(&outer, inner.z), scene_point(&outer, inner.t) };
}

float scene_random(uint32_t *state)
{
    *state = pt_hash(*state + 0x9e3779b9u);
    return pt_unit(*state);
}

vec3 scene_random3(uint32_t *state, vec3 low, vec3 high)
{
    vec3 r = low;
    for (int c = 0; c < 3; c++) r[c] += (high[c] - low[c]) * scene_random(state);
    return r;
}

/* ---- flat shapes ---- */

static void add_corner(scene_triangle *t, int k, vec3 p, vec3 n, float u, float v)
{
    t->p[k] = p;
    t->n[k] = n;
    t->uv[k][0] = u;
    t->uv[k][1] = v;
}

void scene_add_quad(scene *s, vec3 a, vec3 b, vec3 d)
{
    vec3 e = b - a, f = d - a, n = normalize(cross(e, f));
    float u = length(e), v = length(f);
    scene_triangle t = { 0 };
    add_corner(&t, 0, a, n, 0.0f, 0.0f);
    add_corner(&t, 1, b, n, u, 0.0f);
    add_corner(&t, 2, b + f, n, u, v);
    scene_add_triangle(s, &t);
    add_corner(&t, 1, b + f, n, u, v);
    add_corner(&t, 2, d, n, 0.0f, v);
    scene_add_triangle(s, &t);
}

void scene_add_panel(scene *s, vec3 center, vec3 u, vec3 v)
{
    vec3 corner = center - u - v;
    scene_add_quad(s, corner, corner + u * 2.0f, corner + v * 2.0f);
}

void scene_add_box(scene *s, vec3 center, vec3 half)
{
    for (int axis = 0; axis < 3; axis++) {
        vec3 n = grey(0.0f), u = grey(0.0f), v = grey(0.0f);
        n[axis] = half[axis];
        u[(axis + 1) % 3] = half[(axis + 1) % 3];
        v[(axis + 2) % 3] = half[(axis + 2) % 3];
        if (axis == 0) { /* keeps textures of upright sides upright */
            scene_add_panel(s, center + n, v * -1.0f, u);
            scene_add_panel(s, center - n, v, u);
        } else {
            scene_add_panel(s, center + n, u, v);
            scene_add_panel(s, center - n, u * -1.0f, v);
        }
    }
}

/* ---- surfaces of revolution ---- */

/* Normal in the plane of the profile, (radial, height), of segment i. */
static vec2 segment_normal(const float (*profile)[2], int i)
{
    float dr = profile[i + 1][0] - profile[i][0], dy = profile[i + 1][1] - profile[i][1];
    float len = sqrtf(dr * dr + dy * dy);
    return len > 0.0f ? vec2(dy / len, -dr / len) : vec2(1.0f, 0.0f);
}

/* The same at one end of segment i, smoothed with the neighbour there unless the edge is sharp. */
static vec2 profile_normal(const float (*profile)[2], int points, int i, int end)
{
    vec2 own = segment_normal(profile, i);
    int neighbour = end ? i + 1 : i - 1;
    if (neighbour < 0 || neighbour > points - 2) return own;
    vec2 other = segment_normal(profile, neighbour);
    if (own[0] * other[0] + own[1] * other[1] < 0.766f) return own;
    vec2 sum = own + other;
    return sum * (1.0f / sqrtf(sum[0] * sum[0] + sum[1] * sum[1]));
}

static void lathe_corner(scene_triangle *t, int k, const float point[2], vec2 normal, float angle, float u, float v)
{
    float c = cosf(angle), s = sinf(angle);
    add_corner(t, k, vec3(point[0] * c, point[1], point[0] * s), vec3(normal[0] * c, normal[1], normal[0] * s), u, v);
}

void scene_add_lathe(scene *s, const float (*profile)[2], int points, int sides)
{
    float widest = 0.0f, v = 0.0f;
    for (int i = 0; i < points; i++) widest = max(widest, profile[i][0]);
    for (int i = 0; i + 1 < points; i++) {
        const float *a = profile[i], *b = profile[i + 1];
        vec2 na = profile_normal(profile, points, i, 0), nb = profile_normal(profile, points, i, 1);
        float v2 = v + hypotf(b[0] - a[0], b[1] - a[1]);
        for (int k = 0; k < sides; k++) {
            float t0 = 2.0f * PT_PI * (float)k / (float)sides, t1 = 2.0f * PT_PI * (float)(k + 1) / (float)sides;
            float u0 = t0 * widest, u1 = t1 * widest;
            scene_triangle t = { 0 };
            lathe_corner(&t, 0, a, na, t0, u0, v);
            lathe_corner(&t, 1, b, nb, t1, u1, v2);
            lathe_corner(&t, 2, a, na, t1, u1, v);
            if (a[0] > 0.0f) scene_add_triangle(s, &t);
            lathe_corner(&t, 1, b, nb, t0, u0, v2);
            lathe_corner(&t, 2, b, nb, t1, u1, v2);
            if (b[0] > 0.0f) scene_add_triangle(s, &t);
        }
        v = v2;
    }
}

void scene_add_sphere(scene *s, vec3 center, float radius, int sides)
{
    enum { MAX_RINGS = 64 };
    float profile[MAX_RINGS + 1][2];
    int rings = sides / 2 < MAX_RINGS ? sides / 2 : MAX_RINGS;
    for (int i = 0; i <= rings; i++) {
        float angle = PT_PI * (float)i / (float)rings;
        profile[i][0] = i == 0 || i == rings ? 0.0f : radius * sinf(angle);
        profile[i][1] = -radius * cosf(angle);
    }
    scene_transform saved = s->placement;
    s->placement = scene_compose(saved, scene_translation(center));
    scene_add_lathe(s, (const float(*)[2])profile, rings + 1, sides);
    s->placement = saved;
}

void scene_add_cylinder(scene *s, vec3 a, vec3 b, float radius_a, float radius_b, int sides)
{
    float len = length(b - a);
    vec3 axis = (b - a) * (1.0f / len), side = pt_tangent(axis);
    const float profile[4][2] = { { 0.0f, 0.0f }, { radius_a, 0.0f }, { radius_b, len }, { 0.0f, len } };
    scene_transform saved = s->placement, along = { side, axis, cross(side, axis), a };
    s->placement = scene_compose(saved, along);
    scene_add_lathe(s, profile, 4, sides);
    s->placement = saved;
}
