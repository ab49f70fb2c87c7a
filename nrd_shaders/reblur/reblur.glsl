/* What the spatial passes of REBLUR share: a pixel, and how much its neighbours count. */
#ifndef REBLUR_GLSL
#define REBLUR_GLSL

struct Center {
    ivec2 pixel;
    Plane plane;        /* distance 1 is the tolerance */
    vec3 normal;        /* world */
    uint material;
};

struct Neighbour {
    ivec2 pixel;        /* where to read; the centre itself where there is nothing to read */
    vec2 offset;        /* from the centre, px */
    bool inside;        /* the rectangle */
};

/* slack: 1 for long histories; larger accepts neighbours that lie farther off the plane. */
Center make_center(ivec2 pixel, uint code, float slack)
{
    Center c;
    c.pixel = pixel;
    c.normal = guide_normal(code);
    c.material = max(code >> 30, g.min_material);
    float z = guide_relative_depth(code) * g.denoising_range;
    vec2 uv = pixel_uv(pixel);
    float scale = 1.0 / plane_tolerance(g.plane_distance_sensitivity * slack, z);
    c.plane = make_plane(c.normal * mat3(g.view_to_world), view_position(uv, z, g.frustum, g.orthographic), uv, 1.0 / vec2(rect_size()), g.frustum,
                         g.orthographic, scale, g.denoising_range);
    return c;
}

/* grid: in steps. The offset is not converted from the pixel: conversions are slow. */
Neighbour find_neighbour(Center c, ivec2 grid)
{
    Neighbour n;
    n.pixel = c.pixel + grid * push.step_size;
    n.offset = vec2(grid) * float(push.step_size);
    n.inside = all(lessThan(uvec2(n.pixel), uvec2(rect_size())));
    if (!n.inside) n.pixel = c.pixel;
    return n;
}

/* Weight without the normals: 0 for sky, another material, off the plane, outside the rectangle. */
float plane_weight(Center c, Neighbour n, uint code)
{
    float distance = abs(plane_distance(c.plane, n.offset, guide_relative_depth(code)));
    bool usable = n.inside && !guide_is_sky(code) && max(code >> 30, g.min_material) == c.material;
    return usable ? clamp(1.0 - distance, 0.0, 1.0) : 0.0;
}

/* Binomial kernel [1 2 1] x [1 2 1] / 4. */
float kernel(ivec2 offset) { return (offset.x == 0 ? 1.0 : 0.5) * (offset.y == 0 ? 1.0 : 0.5); }

const float LOG2_E = 1.442695;

/* Frames that history counts for after a certain change of lighting (3 to 8 tried: less flickers, more lags). */
const float CHANGED_FRAMES = 8.0;

#endif
