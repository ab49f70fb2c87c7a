/* What the spatial passes of REBLUR share: a pixel, and how much its neighbours count. */
#ifndef REBLUR_GLSL
#define REBLUR_GLSL

#include "signals.glsl"
#include "light.glsl"

const float LOG2_E = 1.442695;

struct Center {
    ivec2 pixel;
    Plane plane;        /* distance 1 is the tolerance; in steps */
    vec2 normal;        /* guide_point() */
    uint material;      /* guide_material_word() */
#ifdef SPECULAR
    float roughness_point, roughness_scale;
    float lobe_scale;       /* exponent per 1 - cos of the angle to a neighbour's normal */
    float footprint_scale;  /* exponent per squared distance, steps */
#endif
};

struct Neighbour {
    ivec2 pixel;        /* where to read; the centre itself where there is nothing to read */
    vec2 slope;         /* what the plane's terms change by */
    float squared;      /* distance from the centre, steps */
    bool inside;        /* the rectangle */
};

/* Of unit length, in the view space of the guide's frame. */
vec3 guide_tap_normal(uvec2 guide) { return guide_normal(guide_point(guide)); }

#ifdef SPECULAR
/* Neighbours within the lobe see the same reflection: a blur as wide as the lobe's footprint loses nothing, and mirrors get none. */
const float FOOTPRINT_WIDTH = 2.4;   /* standard deviation of the kernel, footprints */

void set_lobe(inout Center c, float roughness, float tracked, float z, vec2 uv)
{
    float alpha = max(roughness * roughness, 1e-4), tolerance = alpha / (1.0 + 0.28 * alpha * alpha) + 0.01;   /* atan(alpha) */
    float footprint = lobe_footprint(alpha, tracked, z, uv) / float(max(push.step_size, 1));
    c.roughness_scale = (256.0 / 255.0) / (0.1 * roughness + 0.01);
    c.lobe_scale = -LOG2_E * max(1.0 / (tolerance * tolerance), g.normal_sensitivity);
    c.footprint_scale = -0.5 * LOG2_E / max(FOOTPRINT_WIDTH * FOOTPRINT_WIDTH * footprint * footprint, 1e-4);
}
#endif

#ifdef SH
Receiver make_receiver(uvec2 guide, vec2 uv, float z, float roughness)
{
    vec3 position = view_position(uv, z, g.frustum, g.orthographic);
    return Receiver(mat3(g.view_to_world) * guide_tap_normal(guide), mat3(g.view_to_world) * -normalize(mix(position, vec3(0.0, 0.0, 1.0), g.orthographic)), roughness);
}
#endif

/* slack: 1 for long histories; larger accepts neighbours that lie farther off the plane. tracked: of the specular signal. */
Center make_center(ivec2 pixel, uvec2 guide, float slack, float tracked)
{
    Center c;
    c.pixel = pixel;
    c.normal = guide_point(guide);
    c.material = guide_material_word(guide);
    float z = guide_relative_depth(guide.x) * g.denoising_range;
#ifdef SPECULAR
    c.roughness_point = guide_roughness_point(guide);
    set_lobe(c, guide_roughness(guide), tracked, z, pixel_uv(pixel));
#endif
    vec2 uv = pixel_uv(pixel);
    float scale = 1.0 / plane_tolerance(g.plane_distance_sensitivity * slack, z);
    c.plane = make_plane(guide_normal(c.normal), view_position(uv, z, g.frustum, g.orthographic), uv, float(push.step_size) * g.px_uv.xy, g.frustum,
                         g.orthographic, scale, g.denoising_range);
    return c;
}

/* grid: in steps. */
Neighbour find_neighbour(Center c, ivec2 grid)
{
    Neighbour n;
    n.pixel = c.pixel + grid * push.step_size;
    n.inside = all(lessThan(uvec2(n.pixel), uvec2(rect_size())));
    if (!n.inside) n.pixel = c.pixel;   /* on NVIDIA clamping takes 8 registers and 1 % of the time more */
    vec2 x = vec2(c.plane.along_z.y, c.plane.across.y), y = vec2(c.plane.along_z.z, c.plane.across.z);
    n.slope = (grid.x > 0 ? x : grid.x < 0 ? -x : vec2(0.0)) + (grid.y > 0 ? y : grid.y < 0 ? -y : vec2(0.0));
    n.squared = grid.x != 0 && grid.y != 0 ? 2.0 : 1.0;
    return n;
}

/* Weight without the normals: 0 for sky, another material, off the plane, outside the rectangle. */
float plane_weight(Center c, Neighbour n, uvec2 guide)
{
    float distance = abs(guide_relative_depth(guide.x) * (c.plane.along_z.x + n.slope.x) + (c.plane.across.x + n.slope.y));
    bool usable = n.inside && !guide_is_sky(guide.x) && guide_same_material(guide_material_word(guide), c.material);
    return usable ? clamp(1.0 - distance, 0.0, 1.0) : 0.0;
}

/* Exponent of 2 and factor of what a signal's lobe makes of a neighbour. normal_scale: of the diffuse lobe. */
float lobe_exponent(Center c, int signal, float normal_scale, float bend, float squared)
{
#ifdef SPECULAR
    if (signal == SPECULAR_SIGNAL) return c.lobe_scale * bend + c.footprint_scale * squared;
#endif
    return normal_scale * bend;
}

float lobe_factor(Center c, int signal, uvec2 guide)
{
    if (!same_material_for(signal == SPECULAR_SIGNAL ? NRD_MATERIAL_LEAST_SPECULAR : NRD_MATERIAL_LEAST_DIFFUSE, guide_material_word(guide) >> 30, c.material >> 30)) return 0.0;
#ifdef SPECULAR
    IF_SILENT(guide, signal) return 0.0;
    if (signal == SPECULAR_SIGNAL) return clamp(1.0 - abs(guide_roughness_point(guide) - c.roughness_point) * c.roughness_scale, 0.0, 1.0);
#endif
    return 1.0;
}

/* Binomial kernel [1 2 1] x [1 2 1] / 4. */
float kernel(ivec2 offset) { return (offset.x == 0 ? 1.0 : 0.5) * (offset.y == 0 ? 1.0 : 0.5); }

/* Frames that history counts for after a certain change of lighting (3 to 8 tried: less flickers, more lags). */
const float CHANGED_FRAMES = 8.0;

#endif
