/* Reads   guides, penumbrae, the list of tiles, last frame's history.
   Writes  mean visibility, its length and the width of the penumbra, where there is one; reprojected stabilised output.
   Decides which rays lie in a penumbra, and averages those over time. A ray outside of a penumbra is exact: it stays as it has been passed
   on and forgets history, so that contact shadows and umbrae stay what they are. Everything after this pass works on means.
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
#ifdef TRANSLUCENCY
layout(binding = 7, rg32ui) uniform writeonly uimage2D out_mean;
layout(binding = 8) uniform sampler2D in_translucency;
layout(binding = 9) uniform usampler2D history_color;
#else
layout(binding = 7, r32ui) uniform writeonly uimage2D out_mean;
layout(binding = 8, r8) uniform writeonly image2D out_stabilized;
#endif
#include "rays.glsl"
#include "neighborhood.glsl"
#define TILES 6
#define EXACT_TILES
#include "../common/tiles.glsl"

/* Support is looked for around the pixel in 5 x 5 and on a ring of 8: of opposite places one each. Loops over them are not
   unrolled: 40 registers on an AMD GPU, not 64, and not slower on an H200. */
const int PAIRS = 16;
/* (-2, 0), (-1, 0), (-2, 1), (-1, 1), (0, 1), (1, 1), (2, 1), (-2, 2), (-1, 2), (0, 2), (1, 2), (2, 2), (4, 0), (3, 3), (0, 4), (-3, 3): x + 4 and y in
   4 bits each. A table takes lavapipe 8 times as long. */
uvec2 pair_code(int i) { return ((i < 8 ? uvec2(0x26543232u, 0x21111100u) : uvec2(0x14786543u, 0x34302222u)) >> (4 * i & 31)) & 15u; }
vec2 pair_offset(uvec2 code) { return uintBitsToFloat(code | 0x4b000000u) - vec2(8388612.0, 8388608.0); }   /* cheaper than a conversion */
int pair_step(uvec2 code) { return int(code.y) * SIDE + int(code.x) - 4; }   /* from ray to ray */

shared uint s_waiting[64];               /* pixels that may lie in a penumbra: their index in the tile */
shared uint s_waiting_count;

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

/* ---- support */
struct Support {
    float width;     /* half width of the penumbra, px; 0: outside of one */
    uint on_plane;   /* which rays around lie on the same surface: two bits for each of PAIR */
    Visibility mean; /* of these, near in the light's eyes */
    float count;     /* effective number of those rays */
};

/* What decides whether rays around a pixel belong to it. Lengths in pixels: perspective makes those of a ray and those on the screen the same. */
struct Around {
    int centre;          /* index of its ray */
    vec3 across;         /* as in LightFrame */
    vec3 along;          /* half width, px, that an occluder casts which is as far, along the light, as twice the way to an offset: x + |yz * offset| */
    NearnessPlane plane;
    float least;         /* half width that is believed, at least: where the horizon of the surface cuts the light in two, rays are blocked by the
                            surface itself at once, and the penumbra is that of the terminator, not of an occluder */
};

const float TERMINATOR_PX = 4.0;   /* least half width there */

Around make_around(int centre, vec3 position_vs, vec3 normal_vs, LightFrame f)
{
    float tolerance = max(g.plane_distance_sensitivity * frustum_size(position_vs.z), 4.0 * DEPTH_ERROR * position_vs.z);
    float light_angle = g.light_radius / mix(1.0, distance(g.light.xyz, position_vs), g.light.w), per_pixel = 1.0 / f.pixel;
    Around a;
    a.centre = centre;
    a.across = f.across * (per_pixel * per_pixel);
    a.along = 2.0 * light_angle * vec3(-1.0, f.along * per_pixel);   /* a pixel nearer */
    a.plane = make_nearness_plane(f, position_vs.z, tolerance);
    a.least = abs(dot(normal_vs, to_light(position_vs, normal_vs))) < light_angle ? TERMINATOR_PX : 0.0;
    return a;
}

/* Narrowness of the widest penumbra that does not reach the centre from an offset, or is cast by an occluder that is too near. */
float narrowness_needed(Around a, vec2 offset, float across2)
{
    float width = max(0.5 * sqrt(across2) - 0.25, a.along.x + abs(dot(a.along.yz, offset)));
    return 1.0 / max(width + 1.0, 1.0);
}

/* Half width of the penumbra at the centre: mean over blocked rays whose penumbra reaches it and whose occluder is far enough. Small ones count
   more, by their narrowness, because the occluder that is near makes the edge. */
void find_penumbra(Around a, float own, inout Support s)
{
    bool lit = own == LIT, supported = false;
    float count = lit ? 0.0 : 1.0, sum = lit ? 0.0 : 1.0 / (own + 1.0), own_reach2 = lit ? -1.0 : (own + 0.5) * (own + 0.5), least = 1.0 / (a.least + 1.0);
    Visibility own_visibility = ray_visibility(a.centre, lit);
    [[dont_unroll]] for (int i = 0; i < PAIRS; i++) {
        uvec2 code = pair_code(i);
        vec2 offset = pair_offset(code);
        float across2 = across_squared(a.across, offset), slope = dot(a.plane.at.yz, offset), needed = narrowness_needed(a, offset, across2);
        needed = mix(needed, 1.0, least <= needed);
        UNROLL for (int side = 0; side < 2; side++) {
            int at = a.centre + (2 * side - 1) * pair_step(code);
            vec2 ray = s_ray[at];
            bool on_plane = is_on_plane(a.plane, a.plane.at.x + float(2 * side - 1) * slope, abs(ray.x));
            bool reaches = all(bvec2(on_plane, ray.y <= needed));
            s.on_plane |= mix(0u, 1u << (2 * i + side), on_plane);
            count += float(reaches);
            sum += mix(0.0, min(ray.y, least), reaches);
#ifdef TRANSLUCENCY
            bool counts = any(bvec2(reaches, across2 <= own_reach2)), differs = differ(own_visibility, ray_visibility(at, ray.y == NARROWNESS_LIT));
            supported = any(bvec2(supported, all(bvec3(on_plane, counts, differs))));
#else
            supported = any(bvec2(supported, all(bvec3(on_plane, ray.y == NARROWNESS_LIT, across2 <= own_reach2))));
#endif
        }
    }
#ifndef TRANSLUCENCY
    supported = any(bvec2(supported, all(bvec2(lit, count > 0.0))));
#endif
    s.width = supported ? count / sum - 1.0 : 0.0;
}

void gather_mean(Around a, float own, inout Support s)
{
    float k = max(0.6 * s.width, 0.7), weight = 1.0, squares = 1.0, per_width = 1.0 / s.width, least = a.least * per_width;
    vec3 falloff = a.across * (1.5 * 1.442695 / (k * k));
    Visibility sum = ray_visibility(a.centre, own == LIT);
    [[dont_unroll]] for (int i = 0; i < PAIRS; i++) {
        uvec2 code = pair_code(i);
        float near = exp2(-across_squared(falloff, pair_offset(code)));
        UNROLL for (int side = 0; side < 2; side++) {
            int at = a.centre + (2 * side - 1) * pair_step(code);
            float width = s_width[at], w = mix(0.0, near * clamp(width * per_width + least, 0.0, 1.0), (s.on_plane & 1u << (2 * i + side)) != 0u);
            sum += w * ray_visibility(at, width == LIT);
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

/* What was no penumbra in the frame before has been exact for some time: at the ends of wide penumbrae, where a ray in dozens tells otherwise, such a
   ray would else be taken for all there is to know, and come and go with its neighbours as a blot (they were a quarter of the flicker of long
   penumbrae). Frames: more and what has jumped lags. Not of tiles without a penumbra, which keep no depth. */
const float EXACT_FRAMES = 6.0;

History no_history() { return History(NO_LIGHT, 0.0, 0.0); }

History fetch_history(ivec2 pixel, vec3 normal_vs, float signed_z, float width_px)
{
    History h = no_history();
    Reprojection r = find_previous(pixel, signed_z);
    if (!all(greaterThan(r.uv, vec2(0.0))) || !all(lessThan(r.uv, vec2(1.0)))) return h;
    vec2 size_prev = g.rect_px.zw, at = r.uv * size_prev - 0.5, corner = floor(at), part = at - corner;
    vec2 meet = (corner + 1.0) * g.texel_uv.zw;   /* of the four texels */
    uvec4 words = textureGather(history, meet, 0).wzxy, colors = uvec4(0u);
#ifdef TRANSLUCENCY
    colors = textureGather(history_color, meet, 0).wzxy;
#endif
    Plane plane = make_plane(mat3(g.view_to_view_prev) * normal_vs, r.position, (corner + 0.5) / size_prev + jitter_prev_uv(), 1.0 / size_prev,
                             g.frustum_prev, g.orthographic_prev, 1.0 / r.tolerance, 1.0);
    vec4 w = vec4((1.0 - part.x) * (1.0 - part.y), part.x * (1.0 - part.y), (1.0 - part.x) * part.y, part.x * part.y);
    float area = 0.0, sum = 0.0, least_age = EXACT_FRAMES * smoothstep(1.0, 2.0, width_px);
    UNROLL for (int i = 0; i < 4; i++) {
        ivec2 offset = ivec2(i & 1, i >> 1);
        bool inside = all(lessThan(uvec2(ivec2(corner) + offset), uvec2(g.rect_width_prev, g.rect_height_prev)));
        uvec2 word = uvec2(words[i], colors[i]);
        bool on_plane = abs(plane_distance(plane, vec2(offset), unpack_depth(word, g.denoising_range_prev))) < 1.0;
        w[i] *= float(all(bvec2(inside, any(bvec2(is_nothing(word), on_plane)))));
        area += w[i];
        w[i] *= min(history_width_px(word) / width_px, 1.0);   /* the umbra of a nearer occluder stays outside, as in the blur */
        sum += w[i];
        h.mean += w[i] * visibility_of(word);
        h.stabilized += w[i] * history_stabilized(word);
        h.age += w[i] * max(history_age(word), mix(0.0, least_age, on_plane));
    }
    if (!(sum > 0.01)) return no_history();
    h.mean /= sum;
    h.stabilized /= sum;
    h.age *= smoothstep(0.0, 0.5, area) / sum;
    return h;
}

/* Variances of the mean of the rays around that say nothing; few binary rays stray farther than that, for which the second grows as 1 / their number. */
const vec2 BIAS_NOISE = vec2(4.0, 32.0);

/* Variance of one ray; of history that says 0 or 1, not none. */
Visibility ray_variance(Visibility a, Visibility b) { return max(a * (1.0 - a), b * (1.0 - b)) + 0.09; }

/* History that the rays of this frame contradict is pulled in: as far off as the mean of so many binary rays may be by chance. */
Visibility clamp_history(Visibility mean, Support s)
{
    Visibility slack = 2.0 * sqrt(ray_variance(s.mean, mean) / s.count);
    return clamp(mean, s.mean - slack, s.mean + slack);
}

/* Part of so many frames of history that is worth keeping: its distance from the mean of the rays around, beyond what is noise of those, is taken for
   its bias, and the frames are as many as would have a variance of that bias squared and their own. So is what a light that moves has changed
   since the frame before: around narrow penumbrae there are too few rays to tell. */
float trust_in(History h, Support s, float frames)
{
    float off = luma_of(h.mean) - luma_of(s.mean), variance = luma_of(ray_variance(s.mean, h.mean));
    float bias2 = max(off * off - (BIAS_NOISE.x + BIAS_NOISE.y / s.count) * variance / s.count, 0.0) + light_shift() * light_shift();
    return 1.0 / (1.0 + frames * bias2 / variance);
}

void accumulate(ivec2 place)
{
    ivec2 pixel = 8 * tile + place;
    int centre = ray_index(place);
    float signed_z = nearness(s_ray[centre].x);
    vec3 position_vs = view_position(ray_uv(pixel), abs(signed_z), g.frustum, g.orthographic), normal_vs = load_normal_vs(in_normal_roughness, pixel);
    Around a = make_around(centre, position_vs, normal_vs, make_light_frame(position_vs, normal_vs));
    Support s = Support(0.0, 0u, NO_LIGHT, 0.0);
    float own = max(s_width[centre], a.least);
    find_penumbra(a, own, s);
    if (!(s.width > 0.0)) return;
    gather_mean(a, own, s);
    History h = no_history();
    if (!is_reset()) h = fetch_history(pixel, normal_vs, signed_z, s.width);
    float frames = history_length(h.age, s.width), trust = trust_in(h, s, frames);
    Visibility v = mix(clamp_history(h.mean, s), ray_visibility(centre, own == LIT), 1.0 / (1.0 + frames * trust));
    uint age = pack_age(mix(frames * trust, h.age, trust * trust * trust * trust) + 1.0, random_of(pixel, 3u));
    imageStore(out_mean, pixel, uvec4(pack_mean(pack_depth(abs(signed_z)), v, random_of(pixel, 0u), age, s.width, h.stabilized), 0u, 0u));
#ifndef TRANSLUCENCY
    if (!is_absent(NRD_ABSENT_STABILIZATION)) imageStore(out_stabilized, pixel, round_byte(vec4(h.stabilized)));
#endif
}

/* Few pixels of a tile may lie in a penumbra where edges are narrow: those are gathered in a list, so that no thread waits for others. */
void process(ivec2 pixel)
{
    if ((tile_marks & TILE_ACTIVE) == 0u) return;
    uint i = gl_LocalInvocationIndex;
    if (i == 0u) s_waiting_count = 0u;
    load_rays(8 * tile);
    ivec2 place = ivec2(gl_LocalInvocationID.xy);
    float width = s_width[ray_index(place)];
    if (width > 0.0 && may_be_penumbra(place, width)) s_waiting[atomicAdd(s_waiting_count, 1u)] = i;
    barrier();
    if (i < s_waiting_count) accumulate(ivec2(s_waiting[i] & 7u, s_waiting[i] >> 3));
}
