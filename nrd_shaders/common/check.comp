/* Reads   the guides and one or two noisy signals.
   Writes  counters of pixels that break the rules of nrd.h (NRD_RULES), and zeros to those that the next frame will use.
   Tells an application what is wrong with its inputs. After the other passes: it changes nothing that they read.
   Counts in shared memory first, so that a broken input costs one atomic per group and rule. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"

layout(binding = 1) uniform sampler2D in_mv;
layout(binding = 2) uniform sampler2D in_normal_roughness;
layout(binding = 3) uniform sampler2D in_view_z;
layout(binding = 4) uniform sampler2D in_first;    /* diffuse, or the only signal, or penumbrae */
layout(binding = 5) uniform sampler2D in_second;   /* specular, or translucency, or the first again */
layout(binding = 6, r32ui) uniform uimage2D out_counters;
layout(binding = 7, r32ui) uniform writeonly uimage2D next_counters;

#define NRDI_X(name, index) const uint COUNTER_##name = index;
NRD_COUNTERS(NRDI_X)
#undef NRDI_X

const float FACING = 0.2;             /* cosine: surely lit or unlit side */
const float MOTION_ERROR_PX = 0.5;    /* or .. */
const float MOTION_ERROR = 0.1;       /* .. of the motion: what half floats and sub-pixel samples may differ by */
const float HALF_STEP = 1e-6;         /* what half floats near 0 are rounded by, with a margin */
const int SKY_REACH_PX = 3;           /* an area of exactly one depth is at least this wide on each side */

shared uint s_counters[NRD_COUNTER_COUNT];

void count(uint counter, bool condition)
{
    if (condition) atomicAdd(s_counters[counter], 1u);
}

struct Surface {
    ivec2 pixel;
    vec2 uv;
    float z;          /* > 0 */
    float signed_z;
    vec3 position;    /* view space */
    vec3 to_camera;   /* unit */
    vec3 normal;      /* world space */
    vec3 normal_vs;
    float roughness;
};

vec3 to_view(vec3 world) { return world * mat3(g.view_to_world); }

float load_view_z(ivec2 pixel) { return texelFetch(in_view_z, clamp(pixel, ivec2(0), rect_size() - 1) + rect_origin(), 0).x * g.view_z_scale; }

uint signals() { return push.iteration | opaque_zero(); }
bool has_radiance() { return signals() < NRD_SIGNALS_HIT_DIST; }
bool has_shadow() { return signals() >= NRD_SIGNALS_SHADOW; }
bool has_direction() { return signals() == NRD_SIGNALS_DIRECTION; }
bool has_diffuse() { return has_direction() || (!has_shadow() && signals() % 3u != 1u); }
bool has_specular() { return !has_direction() && !has_shadow() && signals() % 3u != 0u; }

/* ---- guides ---- */

bool is_nothing(vec4 texel) { return texel.x == 0.0 && (!has_radiance() || (texel.y == 0.0 && texel.z == 0.0 && texel.w == 0.0)); }

bool has_no_signal(ivec2 pixel)
{
    return !has_shadow() && is_nothing(texelFetch(in_first, pixel, 0)) && is_nothing(texelFetch(in_second, pixel, 0));
}

/* One depth all around belongs to a plane that faces the camera; where normals or the signal know of none, it was cleared. */
bool is_sky_in_range(Surface s)
{
    float raw = s.signed_z;
    ivec2 r = ivec2(SKY_REACH_PX, 0);
    bool flat_area = load_view_z(s.pixel - r) == raw && load_view_z(s.pixel + r) == raw && load_view_z(s.pixel - r.yx) == raw && load_view_z(s.pixel + r.yx) == raw;
    return flat_area && (s.normal_vs.z > -0.8 || has_no_signal(s.pixel));
}

/* The packing functions scale normals to a largest component of 1 and leave no roughness code at 0. */
bool is_not_packed(vec4 texel)
{
    if (SPEC_NORMAL_FORMAT == NRD_NORMAL_FORMAT_RGB10A2_UNORM) return abs(texel.z * 2.0 - 1.0) < 0.002;
    bool biased = SPEC_NORMAL_FORMAT == NRD_NORMAL_FORMAT_RGBA8_UNORM || SPEC_NORMAL_FORMAT == NRD_NORMAL_FORMAT_RGBA16_UNORM;
    float squared = dot(biased ? texel.xyz * 2.0 - 1.0 : texel.xyz, biased ? texel.xyz * 2.0 - 1.0 : texel.xyz);
    return !(squared > 0.9 && squared < 3.1);
}

/* Normal of the plane through the four neighbours; w: 0 unless they lie on one. On a plane the inverse depth is linear in uv. */
vec4 plane_normal(Surface s)
{
    float left = load_view_z(s.pixel - ivec2(1, 0)), right = load_view_z(s.pixel + ivec2(1, 0));
    float above = load_view_z(s.pixel - ivec2(0, 1)), below = load_view_z(s.pixel + ivec2(0, 1));
    bool inside = in_rect(s.pixel - 1) && in_rect(s.pixel + 1) && !is_sky(left) && !is_sky(right) && !is_sky(above) && !is_sky(below);
    vec4 z = abs(vec4(left, right, above, below)), w = mix(1.0 / z, z, g.orthographic);
    float center = mix(1.0 / s.z, s.z, g.orthographic);
    vec2 slope = abs(w.yw - w.xz), bend = abs(w.xz + w.yw - 2.0 * center);
    bool plane = inside && all(lessThanEqual(bend, 0.1 * slope + 1e-5 * center));
    vec2 texel = 1.0 / vec2(rect_size());
    vec3 x = view_position(s.uv + vec2(texel.x, 0.0), z.y, g.frustum, g.orthographic) - view_position(s.uv - vec2(texel.x, 0.0), z.x, g.frustum, g.orthographic);
    vec3 y = view_position(s.uv + vec2(0.0, texel.y), z.w, g.frustum, g.orthographic) - view_position(s.uv - vec2(0.0, texel.y), z.z, g.frustum, g.orthographic);
    vec3 n = normalize(cross(x, y));
    return vec4(dot(n, s.to_camera) < 0.0 ? -n : n, plane ? 1.0 : 0.0);
}

bool fits(vec3 normal_vs, vec3 plane) { return dot(normal_vs, plane) > 0.866; }

void check_normal(Surface s, vec4 texel)
{
    vec3 n = s.normal;
    vec4 plane = plane_normal(s);
    count(COUNTER_NORMAL_NOT_FINITE, !nrd_is_finite(texel.xyz) || !nrd_is_finite(texel.w));
    count(COUNTER_NORMAL_LENGTH, is_not_packed(texel));
    count(COUNTER_NORMAL_AWAY, dot(s.normal_vs, s.to_camera) < -0.1);
    if (plane.w == 0.0) return;
    count(COUNTER_PLANES, true);
    count(COUNTER_NORMAL_PLANE, !fits(s.normal_vs, plane.xyz));
    count(COUNTER_NORMAL_IF_NEGATED, fits(-s.normal_vs, plane.xyz));
    count(COUNTER_NORMAL_IF_X_FLIPPED, fits(to_view(vec3(-n.x, n.yz)), plane.xyz));
    count(COUNTER_NORMAL_IF_Y_FLIPPED, fits(to_view(vec3(n.x, -n.y, n.z)), plane.xyz));
    count(COUNTER_NORMAL_IF_Z_FLIPPED, fits(to_view(vec3(n.xy, -n.z)), plane.xyz));
    count(COUNTER_NORMAL_IF_YZ_SWAPPED, fits(to_view(n.xzy), plane.xyz));
    count(COUNTER_NORMAL_IF_VIEW_SPACE, fits(n, plane.xyz) || fits(n * vec3(1.0, 1.0, -1.0), plane.xyz));
    vec3 hand = vec3(1.0, 1.0, -1.0);   /* of right-handed matrices */
    count(COUNTER_NORMAL_IF_TRANSPOSED, fits(mat3(g.view_to_world) * n, plane.xyz) || fits((mat3(g.view_to_world) * (n * hand)) * hand, plane.xyz));
}

/* ---- motion ---- */

/* Both in pixels. */
bool agrees(vec2 motion, vec2 expected) { return distance(motion, expected) <= max(MOTION_ERROR_PX, MOTION_ERROR * length(expected)); }

vec2 static_uv(Surface s) { return project_prev((g.view_to_view_prev * vec4(s.position, 1.0)).xyz); }

/* uv at which a static point was if the matrices given are the transposes of the true ones, which then know rotations alone.
   hand: (1, 1, -1) if they are right-handed. */
vec2 static_uv_if_transposed(Surface s, vec3 hand)
{
    vec3 world = ((s.position * hand) * mat3(g.view_to_world)) * hand;
    return project_prev(((world * hand) * mat3(g.world_to_view_prev)) * hand);
}

vec2 given_uv(Surface s, vec3 motion)
{
    if ((g.motion_mode | opaque_zero()) != NRD_MOTION_WORLD) return s.uv + motion.xy;
    return project_prev((g.world_to_view_prev * vec4(mat3(g.view_to_world) * s.position + motion, 1.0)).xyz);
}

void check_causes(Surface s, vec2 motion, vec2 expected, vec2 size)
{
    count(COUNTER_MOTION_IF_NEGATED, agrees(-motion, expected));
    count(COUNTER_MOTION_IF_PIXELS, agrees(motion / size, expected));
    count(COUNTER_MOTION_IF_CLIP, agrees(motion * vec2(0.5, -0.5), expected));
    count(COUNTER_MOTION_IF_CLIP_Y_DOWN, agrees(motion * 0.5, expected));
    count(COUNTER_MOTION_IF_Y_FLIPPED, agrees(motion * vec2(1.0, -1.0), expected));
    count(COUNTER_MOTION_IF_SCALED_TWICE, agrees(motion * size, expected));
    vec2 left = (static_uv_if_transposed(s, vec3(1.0)) - s.uv) * size, right = (static_uv_if_transposed(s, vec3(1.0, 1.0, -1.0)) - s.uv) * size;
    count(COUNTER_MOTION_IF_TRANSPOSED, agrees(motion, left) || agrees(motion, right));
    count(COUNTER_MOTION_ZERO, length(motion) < 0.02);
}

void check_depth_motion(Surface s, float motion_z)
{
    float expected = (g.view_to_view_prev * vec4(s.position, 1.0)).z, change = abs(expected - s.z);
    if (change < 0.01 * s.z) return;
    count(COUNTER_DEPTH_MOVED, true);
    count(COUNTER_MOTION_DEPTH, !(abs(abs(s.signed_z + motion_z) - expected) < 0.3 * change));
    count(COUNTER_DEPTH_IF_NEGATED, abs(abs(s.signed_z - motion_z) - expected) < 0.3 * change);
    count(COUNTER_DEPTH_ZERO, motion_z == 0.0);
}

void check_motion(Surface s)
{
    if ((SPEC_ABSENT & NRD_ABSENT_MOTION) != 0u) return;   /* another image is bound */
    vec3 given = texelFetch(in_mv, s.pixel + rect_origin(), 0).xyz * g.motion_scale.xyz;
    bool finite = nrd_is_finite(given);
    count(COUNTER_MOTION_NOT_FINITE, !finite);
    vec2 size = vec2(rect_size()), uv_prev = static_uv(s);
    if (is_reset() || !finite || uv_prev.x < -5.0) return;
    vec2 expected = (uv_prev - s.uv) * size, motion = (given_uv(s, given) - s.uv) * size;
    float moved = length(expected);
    count(COUNTER_MOVED, moved >= 1.0);
    count(COUNTER_MOTION_CAMERA, moved >= 1.0 && !agrees(motion, expected));
    count(COUNTER_STILL, moved < 0.25);
    count(COUNTER_MOTION_STILL, moved < 0.25 && length(motion) > 1.0);
    if (moved >= 1.0) check_causes(s, motion, expected, size);
    if ((g.motion_mode | opaque_zero()) == NRD_MOTION_2_5D && agrees(motion, expected)) check_depth_motion(s, given.z);

    float jitter = length(g.jitter_delta.xy);
    vec2 error = motion - expected;
    bool is_jitter = min(distance(error, g.jitter_delta.xy), distance(error, -g.jitter_delta.xy)) < 0.25 * jitter;
    count(COUNTER_JITTERED, jitter >= 0.25 && moved < 64.0);
    count(COUNTER_MOTION_JITTER, jitter >= 0.25 && moved < 64.0 && is_jitter);
}

/* ---- signals ---- */

/* Numbers of the counters of a lobe. */
struct Lobe { uint bright, hits, not_finite, negative, hit_negative, hit_range, hit_missing, hit_primary; };

const Lobe DIFFUSE = Lobe(COUNTER_DIFF_BRIGHT, COUNTER_DIFF_HITS, COUNTER_DIFF_NOT_FINITE, COUNTER_DIFF_NEGATIVE, COUNTER_DIFF_HIT_NEGATIVE,
                          COUNTER_DIFF_HIT_RANGE, COUNTER_DIFF_HIT_MISSING, COUNTER_DIFF_HIT_PRIMARY);
const Lobe SPECULAR = Lobe(COUNTER_SPEC_BRIGHT, COUNTER_SPEC_HITS, COUNTER_SPEC_NOT_FINITE, COUNTER_SPEC_NEGATIVE, COUNTER_SPEC_HIT_NEGATIVE,
                           COUNTER_SPEC_HIT_RANGE, COUNTER_SPEC_HIT_MISSING, COUNTER_SPEC_HIT_PRIMARY);

/* Distances just below that to the camera are as frequent as those just above, unless it is contained in them. */
void check_hit_dist(Surface s, Lobe lobe, float w, float roughness)
{
    float primary = mix(length(s.position), s.z, g.orthographic), dist = w * nrd_hit_dist_scale(s.z, roughness, g.hit_distance);
    bool measured = w > 0.0 && w < 0.999, above = measured && dist >= primary && dist < 1.5 * primary;
    count(lobe.hit_negative, w < 0.0);
    count(lobe.hit_range, w > 1.001);
    count(lobe.hits, measured && dist >= 0.5 * primary && dist < 1.5 * primary && (above || dist < 0.97 * primary));
    count(lobe.hit_primary, above);
}

void check_radiance(Surface s, Lobe lobe, vec4 texel)
{
    vec3 rgb = nrd_ycocg_to_rgb_unclamped(texel.xyz);
    bool bright = has_radiance() && texel.x > 0.0;
    count(lobe.negative, has_radiance() && min(texel.x, min(rgb.x, min(rgb.y, rgb.z))) < -0.02 * abs(texel.x) - HALF_STEP);
    count(lobe.bright, bright);
    count(lobe.hit_missing, bright && texel.w == 0.0);
}

void check_lobe(Surface s, Lobe lobe, vec4 texel, float roughness)
{
    float w = has_radiance() || has_direction() ? texel.w : texel.x;
    bool finite = nrd_is_finite(texel.xyz) && nrd_is_finite(texel.w);
    count(lobe.not_finite, !finite);
    if (!finite) return;
    check_radiance(s, lobe, texel);
    check_hit_dist(s, lobe, w, roughness);
}

void check_direction(Surface s, vec4 texel)
{
    float size = length(texel.xyz);
    if (!(size > 0.01)) return;
    count(COUNTER_DIRECTIONS, true);
    count(COUNTER_DIRECTION_LENGTH, size > 1.05 * texel.w + 0.02);
    count(COUNTER_DIRECTION_BELOW, dot(texel.xyz, s.normal) < -0.1 * size);
}

/* ---- shadows ---- */

/* Vector to the light, view space; 0: unknown. */
vec3 to_light(Surface s) { return g.light.w > 0.0 ? g.light.xyz - s.position : g.light.xyz; }

/* What nrd_pack_penumbra and nrd_pack_local_penumbra were given; 0: unknown. */
float occluder_distance(float penumbra, float light_dist)
{
    if (g.light_radius <= 0.0) return 0.0;
    return g.light.w > 0.0 ? penumbra * light_dist / (g.light_radius + penumbra) : penumbra / g.light_radius;
}

bool is_blocked(float penumbra) { return penumbra > 0.0 && penumbra < NRD_PENUMBRA_LIT; }

bool is_blocked_beside(Surface s, ivec2 pixel, float penumbra)
{
    return in_rect(pixel) && is_blocked(penumbra) && abs(abs(load_view_z(pixel)) - s.z) < 0.02 * s.z;
}

/* A distance that both neighbours contradict, who agree: more than an edge of an occluder explains. */
void check_neighbours(Surface s, float dist, float light_dist)
{
    ivec2 left = s.pixel - ivec2(1, 0), right = s.pixel + ivec2(1, 0);
    float left_penumbra = texelFetch(in_first, left, 0).x, right_penumbra = texelFetch(in_first, right, 0).x;
    if (!is_blocked_beside(s, left, left_penumbra) || !is_blocked_beside(s, right, right_penumbra)) return;
    float left_dist = occluder_distance(left_penumbra, light_dist), right_dist = occluder_distance(right_penumbra, light_dist), most = max(dist, max(left_dist, right_dist));
    count(COUNTER_BLOCKED_TRIPLES, true);
    count(COUNTER_PENUMBRA_FIRST_HIT, abs(left_dist - right_dist) < 0.1 * most && min(abs(dist - left_dist), abs(dist - right_dist)) > 0.3 * most);
}

/* Occluders that touch what they shade are the rule; without any, the distances are no surface's. Directional: a light has no place, so
   "far" is against the distance to the camera. */
void check_occluder(Surface s, float penumbra, float light_dist)
{
    float dist = occluder_distance(penumbra, light_dist), primary = length(s.position);
    bool local = g.light.w > 0.0, far = dist > (local ? 0.8 * light_dist : 20.0 * primary), near = dist < (local ? 0.2 * light_dist : 0.5 * primary);
    bool same = texelFetch(in_first, min(s.pixel + ivec2(0, 1), rect_size() - 1), 0).x == penumbra;
    count(COUNTER_OCCLUDERS, far || near);
    count(COUNTER_PENUMBRA_FROM_LIGHT, far);
    count(COUNTER_LIT_OR_FAR, !local && same && dist > 5.0 * primary);
    count(COUNTER_PENUMBRA_MISS, !local && same && dist > 5.0 * primary);
    check_neighbours(s, dist, light_dist);
}

void check_shadow(Surface s)
{
    float p = texelFetch(in_first, s.pixel, 0).x;
    vec3 light = to_light(s);
    float light_dist = length(light), facing = light_dist > 0.0 ? dot(light, s.normal_vs) / light_dist : 0.0;
    bool lit = p == NRD_PENUMBRA_LIT;
    count(COUNTER_PENUMBRA_INVALID, !(p >= 0.0));
    count(COUNTER_PENUMBRA_CODE, p > 32768.0 && !lit);
    count(COUNTER_LIT, lit);
    count(COUNTER_LIT_OR_FAR, lit);
    count(COUNTER_FACING_LIGHT, facing > FACING);
    count(COUNTER_PENUMBRA_ZERO, facing > FACING && p == 0.0);
    count(COUNTER_AWAY_FROM_LIGHT, facing < -FACING);
    count(COUNTER_PENUMBRA_AWAY, facing < -FACING && p >= NRD_PENUMBRA_LIT);
    if (facing > FACING && is_blocked(p) && g.light_radius > 0.0) check_occluder(s, p, light_dist);
    if (signals() == NRD_SIGNALS_TRANSLUCENT_SHADOW)
        count(COUNTER_TRANSLUCENCY_LIT, lit && !all(greaterThan(texelFetch(in_second, s.pixel, 0).xyz, vec3(0.98))));
}

/* ---- all ---- */

bool load_surface(ivec2 pixel, out Surface s, out vec4 texel)
{
    s.pixel = pixel;
    s.uv = pixel_uv(pixel);
    s.signed_z = load_view_z(pixel);
    s.z = abs(s.signed_z);
    s.position = view_position(s.uv, s.z, g.frustum, g.orthographic);
    s.to_camera = g.orthographic > 0.0 ? vec3(0.0, 0.0, -1.0) : -normalize(s.position);
    texel = texelFetch(in_normal_roughness, pixel + rect_origin(), 0);
    nrd_surface surface = nrd_decode_normal_roughness(texel, SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT);
    s.normal = surface.normal;
    s.normal_vs = to_view(surface.normal);
    s.roughness = surface.roughness;
    return !is_sky(s.signed_z) && s.z > 0.0;
}

void check_pixel(ivec2 pixel)
{
    Surface s;
    vec4 texel;
    bool is_surface = load_surface(pixel, s, texel), sky_in_range = is_surface && is_sky_in_range(s);
    count(COUNTER_PIXELS, true);
    count(COUNTER_VIEWZ_NOT_FINITE, !nrd_is_finite(s.signed_z));
    count(COUNTER_VIEWZ_ZERO, s.signed_z == 0.0);
    count(COUNTER_SKY_IN_RANGE, sky_in_range);
    if (!is_surface || sky_in_range) return;
    count(COUNTER_SURFACES, true);
    count(COUNTER_VIEWZ_NEGATIVE, s.signed_z < 0.0);
    check_normal(s, texel);
    check_motion(s);
    vec4 first = texelFetch(in_first, pixel, 0);
    if (has_diffuse()) check_lobe(s, DIFFUSE, first, 1.0);
    if (has_specular() && !is_too_rough(s.roughness)) check_lobe(s, SPECULAR, texelFetch(in_second, pixel, 0), s.roughness);
    if (has_direction()) check_direction(s, first);
    if (has_shadow()) check_shadow(s);
}

void main()
{
    uint thread = gl_LocalInvocationIndex;
    for (uint i = thread; i < NRD_COUNTER_COUNT; i += 64u) s_counters[i] = 0u;
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    bool first_group = gl_WorkGroupID.xy == uvec2(0u);
    if (in_rect(pixel)) check_pixel(pixel);
    if (first_group && thread == 0u) {
        count(COUNTER_FRAMES, true);
        count(COUNTER_MATRIX_JITTER, has_flag(NRD_FLAG_MATRIX_JITTER));
        count(COUNTER_FRAME_INDEX, has_flag(NRD_FLAG_FRAME_INDEX));
    }
    barrier();
    for (uint i = thread; i < NRD_COUNTER_COUNT; i += 64u) {
        if (s_counters[i] != 0u) imageAtomicAdd(out_counters, ivec2(i, 0), s_counters[i]);
        if (first_group) imageStore(next_counters, ivec2(i, 0), uvec4(0u));
    }
}
