/* Reads   normals, accumulated occlusion with its guide, length and radius.
   Writes  blur: once filtered occlusion with its guide; post-blur (-DPOST_BLUR): the output.
   Eight taps on a disc in the surface's tangent plane, as wide as near occluders allow; then again, half as wide, on the result of
   the first. Not fed back: history stays unfiltered, so that nothing is blurred twice for long. The taps do not turn from frame to
   frame: that gains no accuracy here and costs half again the flicker. Specular: the disc also stays within what the lobe smears,
   so that mirrors are not touched.
   Tangent-plane discs with a radius from hit distances: D. Zhdan, "Fast Denoising with Self-Stabilizing Recurrent Blurs", GTC 2020.
   Sunflower points: H. Vogel, "A better way to construct the sunflower head", 1979. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/texel.glsl"
#include "occlusion.glsl"

layout(binding = 1) uniform sampler2D in_normal_roughness;
layout(binding = 2) uniform usampler2D in_tap;
#ifdef DIFFUSE
layout(binding = 3) uniform usampler2D in_state;
#endif

#if defined(POST_BLUR) && defined(DIRECTIONAL)
layout(binding = 4, rgba16f) uniform writeonly image2D out_diffuse;
#elif defined(POST_BLUR) && defined(DIFFUSE)
layout(binding = 4, r16f) uniform writeonly image2D out_diffuse;
#endif
#if defined(POST_BLUR) && defined(SPECULAR)
#ifdef DIFFUSE
layout(binding = 5, r16f) uniform writeonly image2D out_specular;
#else
layout(binding = 3, r16f) uniform writeonly image2D out_specular;
#endif
#endif
#ifndef POST_BLUR
#if !defined(SPECULAR) && !defined(DIRECTIONAL)
layout(binding = 4, r32ui) uniform writeonly uimage2D out_tap;
#elif defined(DIFFUSE)
layout(binding = 4, rg32ui) uniform writeonly uimage2D out_tap;
#else
layout(binding = 3, rg32ui) uniform writeonly uimage2D out_tap;
#endif
#endif

#ifdef POST_BLUR
const float SCALE = 0.5;
/* Whether the blur has run. */
bool is_filtered() { return !has_flag(NRD_FLAG_PERFORMANCE); }
const mat2 TURN = mat2(0.3624, 0.9320, -0.9320, 0.3624);   /* by 1.2: away from the points of the first disc */
#else
const float SCALE = 1.0;
bool is_filtered() { return false; }
const mat2 TURN = mat2(1.0);
#endif

/* Radius of the disc over the harmonic mean of hit distances. 0.13 to 0.24 tried: less is noisier, more loses contact shadows. */
const float WIDTH = 0.17;
/* Most of the disc's radius over the lobe's footprint. 0.5 to 3 tried: more is smoother. */
const float LOBE_WIDTH = 3.0;
/* Least radius of one frame's history, px; falls as 1 / sqrt(frames). 3 to 8 tried: less leaves fresh contact shadows speckled. */
const float FRESH_RADIUS = 5.7;
const float FALLOFF = 0.05;       /* of the weights, 2^-x per tap: nearly even over the disc. 0.05 to 0.54 tried: more is noisier */
const float CURVATURE = 0.1;      /* distance off the plane, over the tap's own, that is still the same surface */
const int TAPS = 8;
const vec2 DISC[TAPS] = vec2[](vec2(0.2500, 0.0000), vec2(-0.3193, 0.2925), vec2(0.0489, -0.5569), vec2(0.4024, 0.5249),
                               vec2(-0.7385, -0.1306), vec2(0.6996, -0.4450), vec2(-0.2340, 0.8705), vec2(-0.4462, -0.8592));

/* A pixel and the plane it lies in. */
struct Center {
    ivec2 pixel;
    Texel texel;
    nrd_surface surface;
    vec3 position;     /* view space */
    mat2 axes;         /* unit vectors of the plane on the screen, px per unit */
    float reach;       /* longer of them */
    float pixel_size;  /* units */
    float tolerance;   /* distance off the plane, units */
    float bend;        /* of the normal as stored to the exact one */
    Plane plane;
};

/* Displacement on the screen of one in view space, px; linear about a point. */
vec2 to_px(vec3 d, vec3 point)
{
    vec2 xy = mix((d.xy - point.xy * (d.z / point.z)) / point.z, d.xy, g.orthographic);
    return xy / g.frustum.zw * g.rect_px.xy;
}

Center make_center(ivec2 pixel, Texel texel)
{
    Center c;
    c.pixel = pixel;
    c.texel = texel;
    c.surface = nrd_decode_normal_roughness(texelFetch(in_normal_roughness, pixel + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT);
    vec3 normal_vs = c.surface.normal * mat3(g.view_to_world);
    float z = tap_relative_depth(texel.tap) * g.denoising_range;
    vec2 uv = pixel_uv(pixel);
    c.position = view_position(uv, z, g.frustum, g.orthographic);
    vec3 t = normalize(cross(normal_vs, abs(normal_vs.x) > 0.7 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0))), b = cross(normal_vs, t);
    c.axes = mat2(to_px(t, c.position), to_px(b, c.position)) * TURN;
    c.reach = sqrt(max(dot(c.axes[0], c.axes[0]), dot(c.axes[1], c.axes[1])));
    c.pixel_size = g.pixel_unproject * mix(z, 1.0, g.orthographic);
    c.tolerance = plane_tolerance(g.plane_distance_sensitivity, z) + 2.0 * TAP_DEPTH_ERROR * z;
    c.bend = tap_bend(texel.tap, c.surface.normal);
    c.plane = make_plane(normal_vs, c.position, uv, g.px_uv.xy, g.frustum, g.orthographic, 1.0, g.denoising_range);
    return c;
}

float bend_weight(float bend, float normal_scale) { return bend < WIDEST_BEND ? exp2(normal_scale * bend) : 0.0; }

/* Weight of a tap, without its history; 0: not the same surface. alike: what one of the same stored normal and material weighs by its normal;
   mostly taps are so, and decoding normals would be a fifth of the pass. */
float surface_weight(Center c, vec2 offset, bool inside, uvec2 tap, float radius, float normal_scale, float alike, int i)
{
    float distance = abs(plane_distance(c.plane, offset, tap_relative_depth(tap))), weight = alike;
    bool same = inside && !tap_is_sky(tap) && distance < c.tolerance + CURVATURE * radius * length(DISC[i]);
    if (!is_alike(tap, c.texel.tap))
        weight = same_material(tap_material(tap), tap_material(c.texel.tap)) ? bend_weight(tap_bend(tap, c.surface.normal), normal_scale) : 0.0;
    return same ? weight * exp2(-FALLOFF * (float(i) + 0.5)) : 0.0;
}

struct Tap {
    ivec2 pixel;
    vec2 offset;
    bool inside;
};

/* axes: times the radius. Adding 1.5 * 2^23 rounds: conversions run at a quarter of the rate. */
Tap find_tap(Center c, mat2 axes, int i)
{
    precise vec2 rounded = axes * DISC[i] + 12582912.0;
    precise vec2 offset = rounded - 12582912.0;
    ivec2 pixel = c.pixel + floatBitsToInt(rounded) - 0x4b400000;
    bool inside = all(lessThan(uvec2(pixel), uvec2(rect_size())));
    return Tap(inside ? pixel : c.pixel, offset, inside);
}

/* Units; never more than the setting allows on the screen. */
float limit_radius(Center c, float radius, bool filtered) { return (filtered ? SCALE : 1.0) * min(radius, g.max_blur_radius / max(c.reach, 1e-6)); }

#ifdef DIFFUSE
/* Moment and occlusion. filtered: a constant. */
vec4 filter_diffuse(Center c, Lobe lobe, bool filtered)
{
    float wide = WIDTH * lobe.radius * nrd_hit_dist_scale(c.position.z, 1.0, g.hit_distance), fresh = FRESH_RADIUS * c.pixel_size * inversesqrt(max(lobe.frames, 1.0));
    float radius = limit_radius(c, max(wide, fresh), filtered), normal_scale = -LOG2_E * g.normal_sensitivity;
    float weight = filtered ? 1.0 : tap_diffuse_frames(c.texel.tap);
    float alike = bend_weight(c.bend, normal_scale);
    mat2 axes = c.axes * radius;
    vec4 sum = vec4(lobe.moment, lobe.occlusion) * weight;
    UNROLL for (int i = 0; i < TAPS; i++) {
        Tap t = find_tap(c, axes, i);
        uvec2 tap = texelFetch(in_tap, t.pixel, 0).xy;
        float w = surface_weight(c, t.offset, t.inside, tap, radius, normal_scale, alike, i) * (filtered ? 1.0 : tap_diffuse_frames(tap));
        sum += w * (filtered ? tap_filtered_diffuse(tap) : tap_diffuse(tap));
        weight += w;
    }
    return sum / weight;
}
#endif

#ifdef SPECULAR
float filter_specular(Center c, Lobe lobe, bool filtered)
{
    float alpha = max(c.surface.roughness * c.surface.roughness, 1e-4), distance = length(c.position);
    float hit_dist = lobe.radius * nrd_hit_dist_scale(c.position.z, c.surface.roughness, g.hit_distance), footprint = alpha * hit_dist * distance / (hit_dist + distance);
    float wide = max(WIDTH * hit_dist, FRESH_RADIUS * c.pixel_size * inversesqrt(max(lobe.frames, 1.0)));
    float radius = limit_radius(c, min(wide, LOBE_WIDTH * footprint), filtered);
    float normal_scale = -LOG2_E * max(g.normal_sensitivity, 1.0 / (alpha * alpha + 2e-3)), roughness_scale = 1.0 / (0.1 + 0.3 * c.surface.roughness);
    float weight = filtered ? 1.0 : tap_specular_frames(c.texel.tap), sum = lobe.occlusion * weight;
    float alike = bend_weight(c.bend, normal_scale);
    mat2 axes = c.axes * radius;
    if (radius * c.reach < 0.5) return lobe.occlusion;
    UNROLL for (int i = 0; i < TAPS; i++) {
        Tap t = find_tap(c, axes, i);
        uvec2 tap = texelFetch(in_tap, t.pixel, 0).xy;
        float similar = clamp(1.0 - abs(tap_roughness(tap) - c.surface.roughness) * roughness_scale, 0.0, 1.0);
        float w = surface_weight(c, t.offset, t.inside, tap, radius, normal_scale, alike, i) * similar * (filtered ? 1.0 : tap_specular_frames(tap));
        sum += w * tap_specular(tap);
        weight += w;
    }
    return sum / weight;
}
#endif

float shown(float occlusion, float frames) { return round_half(vec4(has_flag(NRD_FLAG_RETURN_HISTORY) ? frames : occlusion)).x; }

#if defined(POST_BLUR) && defined(DIFFUSE) && defined(SPECULAR)
#define TILES 6
#elif defined(DIFFUSE)
#define TILES 5
#else
#define TILES 4
#endif
#include "../common/tiles.glsl"

void process(ivec2 pixel)
{
    if (!in_rect(pixel)) return;
    Texel texel = Texel(texelFetch(in_tap, pixel, 0).xy, 0u);
    if (tap_is_sky(texel.tap)) {
#ifndef POST_BLUR
        imageStore(out_tap, pixel, uvec4(TAP_SKY, 0u, 0u, 0u));
#endif
        return;
    }
    Lobe d = Lobe(0.0, 0.0, 0.0, vec3(0.0)), s = d;
    Center c = make_center(pixel, texel);
#ifdef DIFFUSE
    c.texel.state = texelFetch(in_state, pixel, 0).x;
    d = diffuse_lobe(c.texel);
    if (is_filtering()) {
        if (is_filtered()) d.occlusion = tap_filtered_diffuse(c.texel.tap).w;   /* without the blur its input is bound */
        vec4 filtered = is_filtered() ? filter_diffuse(c, d, true) : filter_diffuse(c, d, false);
        d.moment = filtered.xyz;
        d.occlusion = filtered.w;
    }
#endif
#ifdef SPECULAR
    s = specular_lobe(c.texel);
    if (is_filtering()) s.occlusion = is_filtered() ? filter_specular(c, s, true) : filter_specular(c, s, false);
#endif
#ifndef POST_BLUR
    float random = (float(hash(uint(pixel.x), uint(pixel.y), ~g.frame_index) >> 24) + 0.5) / 256.0;
    imageStore(out_tap, pixel, uvec4(pack_filtered(c.texel.tap, d, s, random), 0u, 0u));
#else
#ifdef DIRECTIONAL
    vec3 moment = d.moment * min(1.0, d.occlusion / max(length(d.moment), 1e-6));   /* rounding made it longer */
    imageStore(out_diffuse, pixel, vec4(round_half(vec4(moment, 0.0)).xyz, shown(d.occlusion, d.frames)));
#elif defined(DIFFUSE)
    imageStore(out_diffuse, pixel, vec4(shown(d.occlusion, d.frames)));
#endif
#ifdef SPECULAR
    imageStore(out_specular, pixel, vec4(shown(s.occlusion, s.frames)));
#endif
#endif
}
