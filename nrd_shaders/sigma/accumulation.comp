/* Reads   guides, penumbrae, last frame's history, its tiles.
   Writes  mean visibility, its length and the width of the penumbra; reprojected stabilised output; tiles; the output where nothing is
           to be filtered.
   Decides which rays lie in a penumbra, and averages those over time. A ray outside of a penumbra is exact: it is passed on and forgets
   history, so that contact shadows and umbrae stay what they are. Tiles without a penumbra stop after the test of their rays.
   The only pass that reads rays: everything after it works on means.
   Penumbra width from the distance to the occluder: R. Fernando, "Percentage-Closer Soft Shadows", SIGGRAPH 2005. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "sigma.glsl"

layout(binding = 1) uniform sampler2D in_motion;
layout(binding = 2) uniform sampler2D in_normal_roughness;
layout(binding = 3) uniform sampler2D in_view_z;
layout(binding = 4) uniform sampler2D in_penumbra;
layout(binding = 5) uniform usampler2D history;
layout(binding = 6) uniform sampler2D prev_tile;
#ifdef TRANSLUCENCY
layout(binding = 7, rg32ui) uniform writeonly uimage2D out_mean;
layout(binding = 8, r8) uniform writeonly image2D out_tile;
layout(binding = 9, rgba8) uniform writeonly image2D out_shadow;
layout(binding = 10) uniform sampler2D in_translucency;
layout(binding = 11) uniform usampler2D history_color;
#else
layout(binding = 7, r32ui) uniform writeonly uimage2D out_mean;
layout(binding = 8, r8) uniform writeonly image2D out_tile;
layout(binding = 9, r8) uniform writeonly image2D out_shadow;
layout(binding = 10, r8) uniform writeonly image2D out_stabilized;
#endif

const int REACH = 4;                     /* px */
const int TAPS = 32;                     /* support is looked for around the pixel in 5 x 5 and on a ring of 8 */
const uint RING_X = 0x74101478u;         /* a hexadecimal digit each, plus 4: (4 0) (3 3) (0 4) (-3 3) (-4 0) (-3 -3) (0 -4) (3 -3) */
const uint RING_Y = 0x10147874u;
const int SIDE = 8 + 2 * REACH;
const uint QUADS = uint(SIDE / 2);

/* Of the tile and REACH pixels around it. */
shared float s_penumbra[SIDE * SIDE];    /* half width, units; 0 faces away, LIT, or NOTHING */
shared float s_view_z[SIDE * SIDE];      /* with its sign */
#ifdef TRANSLUCENCY
shared uint s_color[SIDE * SIDE];        /* of blocked rays */
#endif
shared uint s_kinds;

const float LIT = NRD_HIT_DIST_MISS;
const float NOTHING = -1.0;              /* sky, outside the rectangle */
const uint KIND_LIT = 1u;
const uint KIND_BLOCKED = 2u;
const uint KIND_COLORED = 4u;

float sanitize_penumbra(float p) { return p >= LIT ? LIT : p > 0.0 ? p : 0.0; }   /* NaN: 0 */

/* What the ray at this place of the tile tells. */
Visibility ray_visibility(int at)
{
    if (s_penumbra[at] == LIT) return ALL_LIGHT;
#ifdef TRANSLUCENCY
    return unpackUnorm4x8(s_color[at]).xyz;
#else
    return NO_LIGHT;
#endif
}

/* Rays that differ by less than this are no sign of a penumbra; what many lights send varies over a surface. */
const float SAME = 0.02;

bool differ(Visibility a, Visibility b)
{
#ifdef TRANSLUCENCY
    return any(greaterThan(abs(a - b), vec3(SAME)));
#else
    return a != b;
#endif
}

#ifdef TRANSLUCENCY
/* NaN: 0 */
uint load_color(ivec2 place, ivec2 pixel)
{
    vec4 texel = texelFetch(in_translucency, pixel, 0);
    uint color = packUnorm4x8(vec4(nrd_is_finite(texel.xyz) ? texel.xyz : vec3(0.0), 0.0));
    s_color[place.y * SIDE + place.x] = color;
    return color == 0u ? 0u : KIND_COLORED;
}
#endif

/* Four texels of one gather each. */
uint load_quad(uint quad)
{
    ivec2 place = ivec2(quad % QUADS, quad / QUADS) * 2, base = ivec2(gl_WorkGroupID.xy) * 8 - REACH + place;
    vec4 z = textureGather(in_view_z, vec2(base + rect_origin() + 1) / vec2(textureSize(in_view_z, 0)), 0).wzxy * g.view_z_scale;
    vec4 p = textureGather(in_penumbra, vec2(base + 1) / vec2(textureSize(in_penumbra, 0)), 0).wzxy;
    uint kinds = 0u;
    for (int i = 0; i < 4; i++) {
        ivec2 offset = ivec2(i & 1, i >> 1);
        bool surface = in_rect(base + offset) && !is_sky(z[i]);
        float penumbra = surface ? sanitize_penumbra(p[i]) : NOTHING;
        int at = (place.y + offset.y) * SIDE + place.x + offset.x;
        s_penumbra[at] = penumbra;
        s_view_z[at] = z[i];
        kinds |= penumbra == LIT ? KIND_LIT : penumbra > 0.0 ? KIND_BLOCKED : 0u;
#ifdef TRANSLUCENCY
        if (penumbra > 0.0 && penumbra != LIT) kinds |= load_color(place + offset, base + offset);
        else s_color[at] = 0u;
#endif
    }
    return kinds;
}

ivec2 tap_offset(int i)
{
    int dense = i < 12 ? i : i + 1, ring = 4 * (i - 24);
    return i < 24 ? ivec2(dense % 5, dense / 5) - 2 : ivec2((RING_X >> ring) & 15u, (RING_Y >> ring) & 15u) - 4;
}

int shared_index(ivec2 offset) { ivec2 p = ivec2(gl_LocalInvocationID.xy) + REACH + offset; return p.y * SIDE + p.x; }

/* ---- support */
struct Support {
    float width;     /* half width of the penumbra, units; 0: outside of one */
    Visibility mean; /* of the rays around that lie on the same surface, near in the light's eyes */
    float count;     /* effective number of those rays */
};

Plane centre_plane(vec3 position_vs, vec3 normal_vs, vec2 uv)
{
    float tolerance = max(g.plane_distance_sensitivity * frustum_size(position_vs.z), 4.0 * DEPTH_ERROR * position_vs.z);
    return make_plane(normal_vs, position_vs, uv, 1.0 / vec2(rect_size()), g.frustum, g.orthographic, 1.0 / tolerance, 1.0);
}

/* Distance to the occluder from the half width of its penumbra, units; huge where the light's size is unknown. */
float occluder_distance(float penumbra, float light_distance)
{
    return penumbra * mix(1.0, light_distance, g.light.w) / max(g.light_radius + penumbra * g.light.w, 1e-20);
}

/* Least half width of what a blocked ray tells, units. Where the horizon of the surface cuts the light in two, rays are blocked by the surface
   itself at once: the penumbra is that of the terminator, not of an occluder. */
const float TERMINATOR_PX = 4.0;

float least_penumbra(LightFrame f, vec3 position_vs, vec3 normal_vs, float light_distance)
{
    float half_angle = g.light_radius / mix(1.0, light_distance, g.light.w);
    return abs(dot(normal_vs, to_light(position_vs, normal_vs))) < half_angle ? TERMINATOR_PX * f.pixel : 0.0;
}

/* Half width of the penumbra at the centre: mean over blocked rays whose penumbra reaches it. Small ones count more, because the
   occluder that is near makes the edge. */
float penumbra_at_centre(LightFrame f, Plane plane, float centre, float least, float light_distance, out uint usable)
{
    Visibility own = ray_visibility(shared_index(ivec2(0)));
    vec2 sum = centre == LIT ? vec2(0.0) : vec2(centre, 1.0) / (centre + f.pixel);
    bool supported = false;
    float own_reach = centre == LIT ? 0.0 : centre + 0.5 * f.pixel;
    usable = 0u;
    for (int i = 0; i < TAPS; i++) {
        ivec2 offset = tap_offset(i);
        int at = shared_index(offset);
        float p = s_penumbra[at];
        if (!(p > 0.0) || abs(plane_distance(plane, vec2(offset), abs(s_view_z[at]))) > 1.0) continue;
        usable |= 1u << i;
        vec2 on_plane = pixels_to_plane(f, vec2(offset));
        float across = across_squared(f, on_plane);
        bool other = differ(own, ray_visibility(at));
        supported = supported || (other && across <= own_reach * own_reach);
        if (p == LIT) continue;
        p = max(p, least);
        float reach = 2.0 * p + 0.5 * f.pixel;
        bool reaches = across <= reach * reach && abs(dot(f.along, on_plane)) <= 0.5 * occluder_distance(p, light_distance) + f.pixel;
        float w = reaches ? 1.0 / (p + f.pixel) : 0.0;
        supported = supported || (other && reaches);
        sum += vec2(p, 1.0) * w;
    }
    return supported && sum.y > 0.0 ? sum.x / sum.y : 0.0;
}

void gather_mean(LightFrame f, uint usable, float least, inout Support s)
{
    float k = max(0.6 * s.width, 0.7 * f.pixel), scale = -1.5 * 1.442695 / (k * k), weight = 1.0, squares = 1.0;
    Visibility sum = ray_visibility(shared_index(ivec2(0)));
    for (int i = 0; i < TAPS; i++) {
        if ((usable >> i & 1u) == 0u) continue;
        ivec2 offset = tap_offset(i);
        int at = shared_index(offset);
        float narrower = min(max(s_penumbra[at], least) / s.width, 1.0);   /* LIT is wider than any */
        float w = exp2(scale * across_squared(f, pixels_to_plane(f, vec2(offset)))) * narrower;
        sum += w * ray_visibility(at);
        weight += w;
        squares += w * w;
    }
    s.mean = sum / weight;
    s.count = weight * weight / squares;
}

/* ---- history */
struct History {
    Visibility mean;
    float stabilized, frames;
};

bool find_previous(ivec2 pixel, vec2 uv, vec3 position_vs, float signed_z, out vec2 uv_prev, out vec3 position_prev)
{
    vec3 motion = texelFetch(in_motion, pixel + rect_origin(), 0).xyz * g.motion_scale.xyz;
    if ((g.motion_mode | opaque_zero()) == NRD_MOTION_WORLD) {
        position_prev = (g.world_to_view_prev * vec4(mat3(g.view_to_world) * position_vs + motion, 1.0)).xyz;
        uv_prev = project_prev(position_prev);
    } else {
        uv_prev = uv + motion.xy;
        float still_z = (g.view_to_view_prev * vec4(position_vs, 1.0)).z;
        float z_prev = (g.motion_mode | opaque_zero()) == NRD_MOTION_2_5D ? abs(signed_z + motion.z) : still_z;
        position_prev = view_position(uv_prev, z_prev, g.frustum_prev, g.orthographic_prev);
    }
    return all(greaterThan(uv_prev, vec2(0.0))) && all(lessThan(uv_prev, vec2(1.0)));
}

History no_history() { return History(NO_LIGHT, 0.0, 0.0); }

History fetch_history(ivec2 pixel, vec2 uv, vec3 position_vs, vec3 normal_vs, float signed_z, float width_px)
{
    History h = no_history();
    vec2 uv_prev, size_prev = vec2(g.rect_width_prev, g.rect_height_prev);
    vec3 position_prev;
    if (!find_previous(pixel, uv, position_vs, signed_z, uv_prev, position_prev)) return h;
    vec2 at = uv_prev * size_prev - 0.5, corner = floor(at), part = at - corner;
    vec2 meet = (corner + 1.0) / vec2(textureSize(history, 0));   /* of the four texels */
    uvec4 words = textureGather(history, meet, 0).wzxy, colors = uvec4(0u);
#ifdef TRANSLUCENCY
    colors = textureGather(history_color, meet, 0).wzxy;
#endif
    float tolerance = max(g.disocclusion_threshold * frustum_size(position_vs.z), 4.0 * DEPTH_ERROR * position_vs.z);
    vec3 normal_prev = mat3(g.view_to_view_prev) * normal_vs;
    Plane plane = make_plane(normal_prev, position_prev, (corner + 0.5) / size_prev, 1.0 / size_prev, g.frustum_prev, g.orthographic_prev, 1.0 / tolerance, 1.0);
    vec4 w = vec4((1.0 - part.x) * (1.0 - part.y), part.x * (1.0 - part.y), (1.0 - part.x) * part.y, part.x * part.y);
    float area = 0.0, sum = 0.0;
    for (int i = 0; i < 4; i++) {
        ivec2 offset = ivec2(i & 1, i >> 1), place = ivec2(corner) + offset;
        bool inside = all(lessThan(uvec2(place), uvec2(g.rect_width_prev, g.rect_height_prev)));
        uvec2 word = uvec2(words[i], colors[i]);
        bool same = inside && (is_nothing(word) || abs(plane_distance(plane, vec2(offset), unpack_depth(word, g.denoising_range_prev))) < 1.0);
        if (!same) continue;
        area += w[i];
        w[i] *= min(history_width_px(word) / width_px, 1.0);   /* the umbra of a nearer occluder stays outside, as in the blur */
        sum += w[i];
        h.mean += w[i] * visibility_of(word);
        h.stabilized += w[i] * history_stabilized(word);
        h.frames += w[i] * float(history_frames(word));
    }
    if (!(sum > 0.01)) return no_history();
    h.mean /= sum;
    h.stabilized /= sum;
    h.frames *= smoothstep(0.0, 0.5, area) / sum;
    return h;
}

/* History that the rays of this frame contradict is pulled in: as far off as the mean of so many binary rays may be by chance. */
Visibility clamp_history(Visibility mean, Support s)
{
    Visibility spread = max(s.mean * (1.0 - s.mean), mean * (1.0 - mean)) + 0.09;
    Visibility slack = 2.0 * sqrt(spread / s.count);
    return clamp(mean, s.mean - slack, s.mean + slack);
}

void pass_on(ivec2 pixel, float z, float penumbra)
{
    Visibility v = ray_visibility(shared_index(ivec2(0)));
    float width_px = penumbra == LIT ? WIDTH_ANY : penumbra / (g.pixel_unproject * mix(z, 1.0, g.orthographic));
    uint depth = penumbra > 0.0 ? pack_depth(z) : DEPTH_NONE;   /* what faces away is no neighbour of what does not */
    imageStore(out_mean, pixel, uvec4(pack_mean(depth, v, 0.5, 0u, width_px, 0.0), 0u, 0u));
    if (penumbra != NOTHING) imageStore(out_shadow, pixel, shadow_texel(v));
}

void accumulate(ivec2 pixel, float signed_z, float penumbra)
{
    vec2 uv = pixel_uv(pixel);
    float z = abs(signed_z);
    vec3 position_vs = view_position(uv, z, g.frustum, g.orthographic), normal_vs = load_normal_vs(in_normal_roughness, pixel);
    LightFrame f = make_light_frame(position_vs, normal_vs);
    float light_distance = distance(g.light.xyz, position_vs);
    uint usable;
    Support s = Support(0.0, NO_LIGHT, 0.0);
    float least = least_penumbra(f, position_vs, normal_vs, light_distance);
    penumbra = max(penumbra, least);
    s.width = penumbra_at_centre(f, centre_plane(position_vs, normal_vs, uv), penumbra, least, light_distance, usable);
    if (!(s.width > 0.0)) {
        pass_on(pixel, z, penumbra);
        return;
    }
    gather_mean(f, usable, least, s);
    History h = no_history();
    float width_px = s.width / f.pixel;
    if (!is_reset()) h = fetch_history(pixel, uv, position_vs, normal_vs, signed_z, width_px);
    float frames = min(h.frames * smoothstep(0.25, 0.5, width_px), g.max_accumulated_frames);
    Visibility v = mix(clamp_history(h.mean, s), ray_visibility(shared_index(ivec2(0))), 1.0 / (1.0 + frames));
    uint length = uint(min(frames + 1.0, 15.0) + 0.5);
    imageStore(out_mean, pixel, uvec4(pack_mean(pack_depth(z), v, random_of(pixel, 0u), length, width_px, h.stabilized), 0u, 0u));
#ifndef TRANSLUCENCY
    imageStore(out_stabilized, pixel, vec4(h.stabilized));
#endif
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    uint i = gl_LocalInvocationIndex;
    if (i == 0u) s_kinds = 0u;
    barrier();
    uint kinds = load_quad(i);   /* 8 x 8 quads, one a thread */
    if (kinds != 0u) atomicOr(s_kinds, kinds);
    barrier();
    bool active_tile = (s_kinds & KIND_COLORED) != 0u || (s_kinds & (KIND_LIT | KIND_BLOCKED)) == (KIND_LIT | KIND_BLOCKED);
    if (i == 0u) {
        bool whole = !is_reset() && ((g.rect_width ^ g.rect_width_prev) | (g.rect_height ^ g.rect_height_prev) | opaque_zero()) == 0u;
        uint before = unpack_tile(texelFetch(prev_tile, ivec2(gl_WorkGroupID.xy), 0).x), now = active_tile ? TILE_ACTIVE : 0u;
        now |= (s_kinds & KIND_LIT) != 0u ? TILE_LIT : 0u;
        if (!whole || ((before ^ now) & (TILE_ACTIVE | TILE_LIT)) != 0u) now |= TILE_STALE;
        imageStore(out_tile, ivec2(gl_WorkGroupID.xy), vec4(float(now) / 255.0));
    }
    if (!in_rect(pixel)) return;
    int at = shared_index(ivec2(0));
    float penumbra = s_penumbra[at];
    if (active_tile && penumbra > 0.0) accumulate(pixel, s_view_z[at], penumbra);
    else pass_on(pixel, abs(s_view_z[at]), penumbra);
}
