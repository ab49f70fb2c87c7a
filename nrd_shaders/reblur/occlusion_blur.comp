/* Reads   normals, accumulated occlusion with its guide, length and radius.
   Writes  the output.
   Six taps on a disc in the surface's tangent plane, as wide as near occluders allow. Not fed back: what history takes of neighbours is
   accumulation's mean of this frame's samples, so that nothing is blurred twice for long. The taps do not turn from frame to frame: that gains
   no accuracy here and costs half again the flicker. Specular: the disc also stays within what the lobe smears, so that mirrors are not touched.
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

#ifdef DIRECTIONAL
layout(binding = 4, rgba16f) uniform writeonly image2D out_diffuse;
#elif defined(DIFFUSE)
layout(binding = 4, r16f) uniform writeonly image2D out_diffuse;
#endif
#ifdef SPECULAR
layout(binding = 3 + 2 * HAS_DIFFUSE, r16f) uniform writeonly image2D out_specular;
#endif

/* Least radius of one frame's history, px; falls as 1 / sqrt(frames). 3 to 8 tried: less leaves fresh contact shadows speckled. */
const float FRESH_RADIUS = 5.7;
/* Least that a tap weighs by its normal before there is history, none after FRESH_FRAMES: one-pixel relief that nothing else is like would
   stay speckled. 0.01 to 0.15 tried: more smears relief, less leaves bright dots in it. */
const float FRESH_WEIGHT = 0.1, FRESH_FRAMES = 4.0;
const float FRESH_BEND = 0.75;   /* 75 degrees: where blades and leaves lie side by side, any bend made their error seven times as large */
const float CURVATURE = 0.1;      /* distance off the plane, over the tap's own, that is still the same surface */
/* 8 tried: error and flicker a tenth less, 13 us more on an H200 at 2560x1440. */
const int TAPS = 6, TAPS_OF_PERFORMANCE = 4;
const vec2 DISC[TAPS] = vec2[](vec2(0.2887, 0.0000), vec2(-0.3687, 0.3377), vec2(0.0564, -0.6430), vec2(0.4647, 0.6061),
                               vec2(-0.8528, -0.1508), vec2(0.8078, -0.5139));

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
    float least;       /* weight of a tap by its normal */
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
    c.axes = mat2(to_px(t, c.position), to_px(b, c.position));
    c.reach = sqrt(max(dot(c.axes[0], c.axes[0]), dot(c.axes[1], c.axes[1])));
    c.pixel_size = g.pixel_unproject * mix(z, 1.0, g.orthographic);
    c.tolerance = plane_tolerance(g.plane_distance_sensitivity, z) + 2.0 * TAP_DEPTH_ERROR * z;
    c.plane = make_plane(normal_vs, c.position, uv, g.px_uv.xy, g.frustum, g.orthographic, 1.0, g.denoising_range);
    return c;
}

float bend_weight(float bend, float normal_scale, float least) { return max(bend < WIDEST_BEND ? exp2(normal_scale * bend) : 0.0, bend < FRESH_BEND ? least : 0.0); }

/* Weight of a tap, without its history; 0: not the same surface. Most taps have the same stored normal and material, and decoding normals would be
   a fifth of the pass. */
float surface_weight(Center c, vec2 offset, bool inside, uvec2 tap, float radius, float normal_scale, int i)
{
    float distance = abs(plane_distance(c.plane, offset, tap_relative_depth(tap))), weight = 1.0;
    bool same = inside && !tap_is_sky(tap) && distance < c.tolerance + CURVATURE * radius * length(DISC[i]);
    if (!is_alike(tap, c.texel.tap)) {
        if (!is_parallel(tap, c.texel.tap)) weight = bend_weight(tap_bend(tap, c.surface.normal), normal_scale, c.least);
        if (!same_material(tap_material(tap), tap_material(c.texel.tap))) weight = 0.0;
    }
    return same ? weight : 0.0;
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
float limit_radius(Center c, float radius) { return min(radius, g.max_blur_radius / max(c.reach, 1e-6)); }

bool is_tap_taken(int i) { return i < TAPS_OF_PERFORMANCE || !has_flag(NRD_FLAG_PERFORMANCE); }

#ifdef DIFFUSE
/* Moment and occlusion. */
vec4 filter_diffuse(Center c, Lobe lobe)
{
    float fresh = FRESH_RADIUS * c.pixel_size * inversesqrt(max(lobe.frames, 1.0)), normal_scale = diffuse_bend_scale();
    float radius = limit_radius(c, max(diffuse_reach(lobe.radius, c.position.z), fresh));
    float weight = tap_diffuse_frames(c.texel.tap);
    c.least = FRESH_WEIGHT * clamp(1.0 - lobe.frames / FRESH_FRAMES, 0.0, 1.0);
    mat2 axes = c.axes * radius;
    vec4 sum = vec4(lobe.moment, lobe.occlusion) * weight;
    UNROLL for (int i = 0; i < TAPS; i++) {
        if (!is_tap_taken(i)) break;
        Tap t = find_tap(c, axes, i);
        uvec2 tap = texelFetch(in_tap, t.pixel, 0).xy;
        float w = surface_weight(c, t.offset, t.inside, tap, radius, normal_scale, i) * tap_diffuse_frames(tap);
        sum += w * tap_diffuse(tap);
        weight += w;
    }
    return sum / weight;
}
#endif

#ifdef SPECULAR
float filter_specular(Center c, Lobe lobe)
{
    float fresh = FRESH_RADIUS * c.pixel_size * inversesqrt(max(lobe.frames, 1.0)), normal_scale = specular_bend_scale(c.surface.roughness);
    float radius = limit_radius(c, specular_reach(lobe.radius, c.position, c.surface.roughness, fresh));
    c.least = 0.0;
    float weight = tap_specular_frames(c.texel.tap), sum = lobe.occlusion * weight;
    mat2 axes = c.axes * radius;
    if (radius * c.reach < 0.5) return lobe.occlusion;
    UNROLL for (int i = 0; i < TAPS; i++) {
        if (!is_tap_taken(i)) break;
        Tap t = find_tap(c, axes, i);
        uvec2 tap = texelFetch(in_tap, t.pixel, 0).xy;
        float similar = roughness_weight(tap_roughness(tap), c.surface.roughness);
        float w = surface_weight(c, t.offset, t.inside, tap, radius, normal_scale, i) * similar * tap_specular_frames(tap);
        sum += w * tap_specular(tap);
        weight += w;
    }
    return sum / weight;
}
#endif

float shown(float occlusion, float frames) { return round_half(vec4(has_flag(NRD_FLAG_RETURN_HISTORY) ? frames : occlusion)).x; }

#define TILES (3 + 2 * HAS_DIFFUSE + HAS_SPECULAR)
#include "../common/tiles.glsl"

void process(ivec2 pixel)
{
    if (!in_rect(pixel)) return;
    Texel texel = Texel(texelFetch(in_tap, pixel, 0).xy, 0u);
    if (tap_is_sky(texel.tap)) return;
#ifdef DIFFUSE
    texel.state = texelFetch(in_state, pixel, 0).x;
#endif
    Center c = make_center(pixel, texel);
#ifdef DIFFUSE
    Lobe d = diffuse_lobe(texel);
    vec4 diffuse = is_filtering() ? filter_diffuse(c, d) : vec4(d.moment, d.occlusion);
#ifdef DIRECTIONAL
    vec3 moment = diffuse.xyz * min(1.0, diffuse.w / max(length(diffuse.xyz), 1e-6));   /* rounding made it longer */
    imageStore(out_diffuse, pixel, vec4(round_half(vec4(moment, 0.0)).xyz, shown(diffuse.w, d.frames)));
#else
    imageStore(out_diffuse, pixel, vec4(shown(diffuse.w, d.frames)));
#endif
#endif
#ifdef SPECULAR
    Lobe s = specular_lobe(texel);
    imageStore(out_specular, pixel, vec4(shown(is_filtering() ? filter_specular(c, s) : s.occlusion, s.frames)));
#endif
}
