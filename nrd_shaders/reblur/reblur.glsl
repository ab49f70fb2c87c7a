/* What the spatial passes of REBLUR share: a pixel, and how much its neighbours count. */
#ifndef REBLUR_GLSL
#define REBLUR_GLSL

#include "signals.glsl"
#include "light.glsl"

const float LOG2_E = 1.442695;

struct Center {
    ivec2 pixel;
    Plane plane;        /* distance 1 is the tolerance */
    vec3 normal;        /* world */
    uint material, own_material;   /* material: those that are one class have one number */
#ifdef SH
    Receiver receiver;
    float frames[SIGNALS];
#endif
#ifdef SPECULAR
    float roughness, roughness_scale;
    float lobe_scale;       /* exponent per 1 - cos of the angle to a neighbour's normal */
    float footprint_scale;  /* exponent per squared distance, px */
#endif
};

struct Neighbour {
    ivec2 pixel;        /* where to read; the centre itself where there is nothing to read */
    vec2 offset;        /* from the centre, px */
    bool inside;        /* the rectangle */
};

#ifdef SPECULAR
vec3 guide_tap_direction(uvec2 guide) { return guide_fine_direction(guide); }
#else
vec3 guide_tap_direction(uvec2 guide) { return guide_direction(guide.x); }
#endif

/* Of unit length, world. */
vec3 guide_tap_normal(uvec2 guide)
{
    vec3 direction = guide_tap_direction(guide);
    return direction * inversesqrt(dot(direction, direction));
}

/* 1 - cos of the angle between the normals. */
float normal_bend(Center c, uvec2 guide)
{
    vec3 direction = guide_tap_direction(guide);
    return 1.0 - dot(c.normal, direction) * inversesqrt(dot(direction, direction));
}

#ifdef SPECULAR
/* Neighbours within the lobe see the same reflection: a blur as wide as the lobe's footprint loses nothing, and mirrors get none. */
const float FOOTPRINT_WIDTH = 2.4;   /* standard deviation of the kernel, footprints */

void set_lobe(inout Center c, float roughness, float tracked, float z, vec2 uv)
{
    float alpha = max(roughness * roughness, 1e-4), tolerance = atan(alpha) + 0.01;
    float footprint = lobe_footprint(alpha, tracked, z, uv);
    c.roughness = roughness;
    c.roughness_scale = 1.0 / (0.1 * roughness + 0.01);
    c.lobe_scale = -LOG2_E * max(1.0 / (tolerance * tolerance), g.normal_sensitivity);
    c.footprint_scale = -0.5 * LOG2_E / max(FOOTPRINT_WIDTH * FOOTPRINT_WIDTH * footprint * footprint, 1e-4);
}
#endif

#ifdef SH
Receiver make_receiver(uvec2 guide, vec2 uv, float z, float roughness)
{
    vec3 position = view_position(uv, z, g.frustum, g.orthographic);
    return Receiver(guide_tap_normal(guide), mat3(g.view_to_world) * -normalize(mix(position, vec3(0.0, 0.0, 1.0), g.orthographic)), roughness);
}
#endif

/* slack: 1 for long histories; larger accepts neighbours that lie farther off the plane. tracked: of the specular signal. */
Center make_center(ivec2 pixel, uvec2 guide, float slack, float tracked)
{
    Center c;
    c.pixel = pixel;
    c.normal = normalize(guide_tap_direction(guide));
    c.own_material = guide.x >> 30;
    c.material = max(c.own_material, g.min_material);
    float z = guide_relative_depth(guide.x) * g.denoising_range;
#ifdef SPECULAR
    set_lobe(c, guide_roughness(guide), tracked, z, pixel_uv(pixel));
#endif
    vec2 uv = pixel_uv(pixel);
    SH_ONLY(UNROLL for (int s = 0; s < SIGNALS; s++) c.frames[s] = guide_frames(guide, s);)
    SH_ONLY(c.receiver = make_receiver(guide, uv, z, guide_roughness(guide));)
    float scale = 1.0 / plane_tolerance(g.plane_distance_sensitivity * slack, z);
    c.plane = make_plane(c.normal * mat3(g.view_to_world), view_position(uv, z, g.frustum, g.orthographic), uv, 1.0 / vec2(rect_size()), g.frustum,
                         g.orthographic, scale, g.denoising_range);
    return c;
}

/* grid: in steps, given twice: conversions are slow. */
Neighbour find_neighbour(Center c, ivec2 grid, vec2 grid_float)
{
    Neighbour n;
    n.pixel = c.pixel + grid * push.step_size;
    n.offset = grid_float * float(push.step_size);
    n.inside = all(lessThan(uvec2(n.pixel), uvec2(rect_size())));
    if (!n.inside) n.pixel = c.pixel;
    return n;
}

/* Weight without the normals: 0 for sky, another material, off the plane, outside the rectangle. */
float plane_weight(Center c, Neighbour n, uint code)
{
    float distance = abs(plane_distance(c.plane, n.offset, guide_relative_depth(code)));
    bool usable = n.inside && !guide_is_sky(code) && (is_absent(NRD_ABSENT_MATERIALS) || max(code >> 30, g.min_material) == c.material);
    return usable ? clamp(1.0 - distance, 0.0, 1.0) : 0.0;
}

/* Exponent of 2 and factor of what a signal's lobe makes of a neighbour. normal_scale: of the diffuse lobe. */
float lobe_exponent(Center c, int signal, float normal_scale, float bend, vec2 offset)
{
#ifdef SPECULAR
    if (signal == SPECULAR_SIGNAL) return c.lobe_scale * bend + c.footprint_scale * dot(offset, offset);
#endif
    return normal_scale * bend;
}

float lobe_factor(Center c, int signal, uvec2 guide)
{
    if (!same_material_for(signal == SPECULAR_SIGNAL ? NRD_MATERIAL_LEAST_SPECULAR : NRD_MATERIAL_LEAST_DIFFUSE, guide.x >> 30, c.own_material)) return 0.0;
#ifdef SPECULAR
    if (signal == SPECULAR_SIGNAL) return clamp(1.0 - abs(guide_roughness(guide) - c.roughness) * c.roughness_scale, 0.0, 1.0);
#endif
    return 1.0;
}

/* Binomial kernel [1 2 1] x [1 2 1] / 4. */
float kernel(ivec2 offset) { return (offset.x == 0 ? 1.0 : 0.5) * (offset.y == 0 ? 1.0 : 0.5); }

/* Frames that history counts for after a certain change of lighting (3 to 8 tried: less flickers, more lags). */
const float CHANGED_FRAMES = 8.0;

#endif
