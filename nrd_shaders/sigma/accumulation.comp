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
#include "../common/guide.glsl"
#include "../common/motion.glsl"
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
const int PAIRS = 16;                    /* support is looked for around the pixel in 5 x 5 and on a ring of 8: as many pairs of opposite places */
/* A hexadecimal digit each: x plus 4, and y. Rows of 5 x 5, then the ring; the first eight pairs, and the others. */
const uvec2 PAIR_X = uvec2(0x26543232u, 0x14786543u);
const uvec2 PAIR_Y = uvec2(0x21111100u, 0x34302222u);
const int SIDE = 8 + 2 * REACH;
const int STRIDE = SIDE + 8;             /* the four rows that are read at a time lie in different banks */
const uint QUADS = uint(SIDE / 2);

/* Of the tile and REACH pixels around it.
   x: view z with its sign. y: closeness of the occluder, 1 / (half width of the penumbra + size of a pixel), or one of the values below */
shared vec2 s_ray[SIDE * STRIDE];
#ifdef TRANSLUCENCY
shared uint s_color[SIDE * STRIDE];      /* of blocked rays */
#endif
shared uint s_kinds[QUADS];              /* of a row of quads, a bit for each: lit in the first byte, then blocked, colored */

const float LIT = 1e-20;                 /* below that of any blocked ray, and its reciprocal is finite */
const float FACES_AWAY = -1.0;
const float NOTHING = -2.0;              /* sky, outside the rectangle */
const uint KIND_LIT = 1u;
const uint KIND_BLOCKED = 1u << 8;
const uint KIND_COLORED = 1u << 16;

/* NaN: faces away */
float closeness_of(float penumbra, float z) { return penumbra >= NRD_HIT_DIST_MISS ? LIT : penumbra > 0.0 ? 1.0 / (penumbra + pixel_size(z)) : FACES_AWAY; }

/* What a ray tells that lies at this place of the tile and is that close. */
Visibility ray_visibility(int at, float closeness)
{
    if (closeness == LIT) return ALL_LIGHT;
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
uint load_color(int at, ivec2 pixel)
{
    vec4 texel = texelFetch(in_translucency, pixel, 0);
    uint color = packUnorm4x8(vec4(nrd_is_finite(texel.xyz) ? texel.xyz : vec3(0.0), 0.0));
    s_color[at] = color;
    return color == 0u ? 0u : KIND_COLORED;
}
#endif

/* Four texels of one gather each. */
uint load_quad(ivec2 place)
{
    ivec2 base = ivec2(gl_WorkGroupID.xy) * 8 - REACH + place;
    vec4 z = textureGather(in_view_z, vec2(base + rect_origin() + 1) / vec2(textureSize(in_view_z, 0)), 0).wzxy * g.view_z_scale;
    vec4 p = textureGather(in_penumbra, vec2(base + 1) / vec2(textureSize(in_penumbra, 0)), 0).wzxy;
    bvec2 columns = lessThan(uvec2(base.x, base.x + 1), uvec2(g.rect_width)), rows = lessThan(uvec2(base.y, base.y + 1), uvec2(g.rect_height));
    uint kinds = 0u;
    UNROLL for (int i = 0; i < 4; i++) {
        bool surface = columns[i & 1] && rows[i >> 1] && !is_sky(z[i]);
        float closeness = surface ? closeness_of(p[i], abs(z[i])) : NOTHING;
        int at = (place.y + (i >> 1)) * STRIDE + place.x + (i & 1);
        s_ray[at] = vec2(z[i], closeness);
        kinds |= closeness == LIT ? KIND_LIT : closeness > 0.0 ? KIND_BLOCKED : 0u;
#ifdef TRANSLUCENCY
        if (closeness > LIT) kinds |= load_color(at, base + ivec2(i & 1, i >> 1));
        else s_color[at] = 0u;
#endif
    }
    return kinds;
}

int centre_index() { return (int(gl_LocalInvocationID.y) + REACH) * STRIDE + int(gl_LocalInvocationID.x) + REACH; }

ivec2 pair_offset(int i)
{
    int digit = 4 * (i & 7);
    return ivec2(int((i < 8 ? PAIR_X.x : PAIR_X.y) >> digit & 15u) - 4, int((i < 8 ? PAIR_Y.x : PAIR_Y.y) >> digit & 15u));
}

/* False if no ray in reach tells anything else: seen from the quads' kinds. */
bool may_be_penumbra(float closeness)
{
    uint column = gl_LocalInvocationID.x >> 1, row = gl_LocalInvocationID.y >> 1, kinds = 0u;
    UNROLL for (uint i = 0u; i <= uint(REACH); i++) kinds |= s_kinds[row + i];
    kinds >>= column;
    return (kinds & 31u * (KIND_COLORED | (closeness == LIT ? KIND_BLOCKED : KIND_LIT))) != 0u;
}

/* ---- support */
struct Support {
    float width;     /* half width of the penumbra, units; 0: outside of one */
    Visibility mean; /* of the rays around that lie on the same surface, near in the light's eyes */
    float count;     /* effective number of those rays */
};

/* What decides whether rays around a pixel belong to it. */
struct Around {
    LightFrame frame;
    Plane plane;
    vec2 depth;          /* depth relative to the centre's = z * x + y; 1 in orthographic views */
    float most;          /* closeness that is believed, at most: where the horizon of the surface cuts the light in two, rays are blocked by the
                            surface itself at once, and the penumbra is that of the terminator, not of an occluder */
    float light_distance;
};

const float TERMINATOR_PX = 4.0;   /* least half width there */

float most_closeness(LightFrame f, vec3 position_vs, vec3 normal_vs, float light_distance)
{
    float half_angle = g.light_radius / mix(1.0, light_distance, g.light.w);
    return abs(dot(normal_vs, to_light(position_vs, normal_vs))) < half_angle ? 1.0 / ((TERMINATOR_PX + 1.0) * f.pixel) : 1e30;
}

Around make_around(vec3 position_vs, vec3 normal_vs, vec2 uv)
{
    float tolerance = max(g.plane_distance_sensitivity * frustum_size(position_vs.z), 4.0 * DEPTH_ERROR * position_vs.z);
    Around a;
    a.frame = make_light_frame(position_vs, normal_vs);
    a.plane = make_plane(normal_vs, position_vs, uv, 1.0 / vec2(rect_size()), g.frustum, g.orthographic, 1.0 / tolerance, 1.0);
    a.depth = vec2((1.0 - g.orthographic) / position_vs.z, g.orthographic);
    a.light_distance = mix(1.0, distance(g.light.xyz, position_vs), g.light.w);
    a.most = most_closeness(a.frame, position_vs, normal_vs, distance(g.light.xyz, position_vs));
    return a;
}

/* The distance to the occluder is penumbra * light_distance / (light_radius + penumbra * light.w), huge where the light's size is unknown. With
   penumbra = 1 / closeness - pixel: true if half of it is farther than this, units. */
bool occluder_is_beyond(float along, float closeness, Around a)
{
    return along * (closeness * (g.light_radius - a.frame.pixel * g.light.w) + g.light.w) <= 0.5 * a.light_distance * (1.0 - a.frame.pixel * closeness);
}

/* Half width of the penumbra at the centre: mean over blocked rays whose penumbra reaches it. Small ones count more, by their closeness, because the
   occluder that is near makes the edge. usable: a bit for each ray that lies on the surface. */
float penumbra_at_centre(Around a, float closeness, out uint usable)
{
    int centre = centre_index();
    Visibility own = ray_visibility(centre, closeness);
    bool lit = closeness == LIT, supported = false;
    float count = lit ? 0.0 : 1.0, sum = lit ? 0.0 : closeness, pixel = a.frame.pixel, own_reach = lit ? 0.0 : 1.0 / closeness - 0.5 * pixel;
    usable = 0u;
    [[dont_unroll]] for (int i = 0; i < PAIRS; i++) {
        ivec2 place = pair_offset(i);
        vec2 offset = vec2(place);
        float across = sqrt(across_squared(a.frame, offset)), along = abs(dot(a.frame.along, offset));
        UNROLL for (int side = 0; side < 2; side++) {
            float sign = side == 0 ? 1.0 : -1.0;
            int at = centre + (side == 0 ? 1 : -1) * (place.y * STRIDE + place.x);
            vec2 ray = s_ray[at];
            float z = abs(ray.x), depth = z * a.depth.x + a.depth.y, near = min(ray.y, a.most), distance = across * depth;
            bool on_plane = ray.y > 0.0 && abs(plane_distance(a.plane, sign * offset, z)) <= 1.0;
            bool blocked = on_plane && ray.y != LIT;
            bool reaches = blocked && near * (distance + 1.5 * pixel) <= 2.0 && occluder_is_beyond(along * depth - pixel, near, a);
            count += reaches ? 1.0 : 0.0;
            sum += reaches ? near : 0.0;
            supported = supported || (on_plane && (reaches || distance <= own_reach) && differ(own, ray_visibility(at, ray.y)));
            usable |= on_plane ? 1u << (2 * i + side) : 0u;
        }
    }
    return supported && sum > 0.0 ? count / sum - pixel : 0.0;
}

void gather_mean(Around a, float closeness, uint usable, inout Support s)
{
    int centre = centre_index();
    float k = max(0.6 * s.width, 0.7 * a.frame.pixel), scale = -1.5 * 1.442695 / (k * k), weight = 1.0, squares = 1.0, per_width = 1.0 / s.width;
    Visibility sum = ray_visibility(centre, closeness);
    [[dont_unroll]] for (int i = 0; i < PAIRS; i++) {
        ivec2 place = pair_offset(i);
        float exponent = scale * across_squared(a.frame, vec2(place));
        UNROLL for (int side = 0; side < 2; side++) {
            int at = centre + (side == 0 ? 1 : -1) * (place.y * STRIDE + place.x);
            vec2 ray = s_ray[at];
            float depth = abs(ray.x) * a.depth.x + a.depth.y;
            float narrower = min((1.0 / min(ray.y, a.most) - a.frame.pixel) * per_width, 1.0);
            float w = (usable & 1u << (2 * i + side)) != 0u ? exp2(exponent * depth * depth) * narrower : 0.0;
            sum += w * ray_visibility(at, ray.y);
            weight += w;
            squares += w * w;
        }
    }
    s.mean = sum / weight;
    s.count = weight * weight / squares;
}

/* ---- history */
const uint NO_MATERIAL = 16u;   /* not even the one of strands */

struct History {
    Visibility mean;
    float stabilized, age;
};

Reprojection find_previous(ivec2 pixel, float signed_z)
{
    vec3 motion = is_absent(NRD_ABSENT_MOTION) ? vec3(0.0) : texelFetch(in_motion, pixel + rect_origin(), 0).xyz * g.motion_scale.xyz;
    Reprojection r = reproject(motion, pixel_uv(pixel), abs(signed_z), signed_z, g.disocclusion_threshold, NO_MATERIAL);
    r.tolerance = max(r.tolerance, 4.0 * DEPTH_ERROR * abs(signed_z));
    return r;
}

History no_history() { return History(NO_LIGHT, 0.0, 0.0); }

History fetch_history(ivec2 pixel, vec3 normal_vs, float signed_z, float width_px)
{
    History h = no_history();
    Reprojection r = find_previous(pixel, signed_z);
    if (!all(greaterThan(r.uv, vec2(0.0))) || !all(lessThan(r.uv, vec2(1.0)))) return h;
    vec2 size_prev = vec2(g.rect_width_prev, g.rect_height_prev), at = r.uv * size_prev - 0.5, corner = floor(at), part = at - corner;
    vec2 meet = (corner + 1.0) / vec2(textureSize(history, 0));   /* of the four texels */
    uvec4 words = textureGather(history, meet, 0).wzxy, colors = uvec4(0u);
#ifdef TRANSLUCENCY
    colors = textureGather(history_color, meet, 0).wzxy;
#endif
    Plane plane = make_plane(mat3(g.view_to_view_prev) * normal_vs, r.position, (corner + 0.5) / size_prev + jitter_prev_uv(), 1.0 / size_prev,
                             g.frustum_prev, g.orthographic_prev, 1.0 / r.tolerance, 1.0);
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
        h.age += w[i] * unpack_age(history_age_code(word));
    }
    if (!(sum > 0.01)) return no_history();
    h.mean /= sum;
    h.stabilized /= sum;
    h.age *= smoothstep(0.0, 0.5, area) / sum;
    return h;
}

/* History that the rays of this frame contradict is pulled in: as far off as the mean of so many binary rays may be by chance. */
Visibility clamp_history(Visibility mean, Support s)
{
    Visibility spread = max(s.mean * (1.0 - s.mean), mean * (1.0 - mean)) + 0.09;
    Visibility slack = 2.0 * sqrt(spread / s.count);
    return clamp(mean, s.mean - slack, s.mean + slack);
}

/* The ray as it is. closeness: with what the terminator allows. */
void pass_on(ivec2 pixel, float z, float closeness)
{
    Visibility v = ray_visibility(centre_index(), closeness);
    float width_px = closeness == LIT ? WIDTH_ANY : max(1.0 / (closeness * pixel_size(z)) - 1.0, 0.0);
    uint depth = closeness > 0.0 ? pack_depth(z) : DEPTH_NONE;   /* what faces away is no neighbour of what does not */
    imageStore(out_mean, pixel, uvec4(pack_mean(depth, v, 0.5, 0u, width_px, 0.0), 0u, 0u));
    if (closeness != NOTHING) imageStore(out_shadow, pixel, shadow_texel(v));
}

void accumulate(ivec2 pixel, float signed_z, float closeness)
{
    vec2 uv = ray_uv(pixel);
    float z = abs(signed_z);
    vec3 position_vs = view_position(uv, z, g.frustum, g.orthographic), normal_vs = load_normal_vs(in_normal_roughness, pixel);
    Around a = make_around(position_vs, normal_vs, uv);
    uint usable;
    Support s = Support(0.0, NO_LIGHT, 0.0);
    closeness = min(closeness, a.most);
    s.width = penumbra_at_centre(a, closeness, usable);
    if (!(s.width > 0.0)) {
        pass_on(pixel, z, closeness);
        return;
    }
    gather_mean(a, closeness, usable, s);
    History h = no_history();
    float width_px = s.width / a.frame.pixel;
    if (!is_reset()) h = fetch_history(pixel, normal_vs, signed_z, width_px);
    Visibility v = mix(clamp_history(h.mean, s), ray_visibility(centre_index(), closeness), 1.0 / (1.0 + history_length(h.age, width_px)));
    uint age = pack_age(h.age + 1.0, random_of(pixel, 3u));
    imageStore(out_mean, pixel, uvec4(pack_mean(pack_depth(z), v, random_of(pixel, 0u), age, width_px, h.stabilized), 0u, 0u));
#ifndef TRANSLUCENCY
    if (!is_absent(NRD_ABSENT_STABILIZATION)) imageStore(out_stabilized, pixel, vec4(h.stabilized));
#endif
}

/* kinds: of all rays in reach of the tile. */
void store_tile(uint kinds, bool active_tile, uint before)
{
    bool whole = !is_reset() && is_same_rect();
    uint now = (active_tile ? TILE_ACTIVE : 0u) | ((kinds & 255u * KIND_LIT) != 0u ? TILE_LIT : 0u);
    if (!whole || ((before ^ now) & (TILE_ACTIVE | TILE_LIT)) != 0u) now |= TILE_STALE;
    imageStore(out_tile, ivec2(gl_WorkGroupID.xy), vec4(float(now) / 255.0));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), place = ivec2(gl_LocalInvocationID.xy);
    uint i = gl_LocalInvocationIndex, before = 0u, kinds;
    if (i < QUADS) s_kinds[i] = 0u;
    ivec2 tile = min(ivec2(gl_WorkGroupID.xy), textureSize(prev_tile, 0) - 1);   /* smaller in the first frame of a larger size */
    if (i == 0u) before = unpack_tile(texelFetch(prev_tile, tile, 0).x);
    barrier();
    kinds = load_quad(2 * place);   /* 8 x 8 quads, one a thread */
    if (kinds != 0u) atomicOr(s_kinds[place.y], kinds << place.x);
    barrier();
    kinds = 0u;
    UNROLL for (uint row = 0u; row < QUADS; row++) kinds |= s_kinds[row];
    bool active_tile = (kinds & 255u * KIND_COLORED) != 0u || ((kinds & 255u * KIND_LIT) != 0u && (kinds & 255u * KIND_BLOCKED) != 0u);
    if (i == 0u) store_tile(kinds, active_tile, before);
    if (!in_rect(pixel)) return;
    vec2 ray = s_ray[centre_index()];
    if (active_tile && ray.y > 0.0 && may_be_penumbra(ray.y)) accumulate(pixel, ray.x, ray.y);
    else pass_on(pixel, abs(ray.x), ray.y);
}
