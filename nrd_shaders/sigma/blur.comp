/* Reads   mean visibility with its length and the penumbra's width, reprojected stabilised output, normals, the list of tiles.
   Writes  history, the output where there is a penumbra.
   Blurs the means over a disc that is as wide as a part of the penumbra, perpendicular to the light, and pulls the result towards last
   frame's as far as the difference can be noise. Not a word of it enters the means: they stay unbiased.
   Vogel's disc: H. Vogel, "A better way to construct the sunflower head", Mathematical Biosciences 44, 1979. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "sigma.glsl"

layout(binding = 1) uniform sampler2D in_normal_roughness;
layout(binding = 3) uniform usampler2D in_mean;
layout(binding = 4, r32ui) uniform writeonly uimage2D out_history;
#ifdef TRANSLUCENCY
layout(binding = 5, rgba8) uniform writeonly image2D out_shadow;
layout(binding = 6, r16ui) uniform writeonly uimage2D out_history_color;
#else
layout(binding = 5, r8) uniform writeonly image2D out_shadow;
layout(binding = 6) uniform sampler2D in_stabilized;
#endif
#define TILES 2
#define EXACT_TILES
#include "../common/tiles.glsl"

const int FAR_TAPS = 5;
const float REACH = 0.045;              /* of the picture's shorter side: longest axis of the far taps' ellipse. Longer ones miss thin occluders' ends */
const vec2 GOLDEN_TURN = vec2(-0.73736887, 0.67549029);   /* cos and sin of the golden angle */

const float FALLOFF = 1.5 * 1.442695;   /* weight at the radius: e^-1.5 */

struct Sum {
    Visibility mean;
    float weight;
    float squares;
};

struct Kernel {
    LightFrame frame;
    NearnessPlane plane;
    vec2 nearness;     /* log2 of a word's nearness = x * depth_bits() + y */
    vec3 across;       /* exponent of a tap's weight = -(across_squared) with the offset in pixels */
    float log_width;   /* log2 of the penumbra's width in pixels */
};

/* An umbra of an occluder that is nearer must not leak out: what is narrower weighs less in proportion. exponent: by the distance. */
void add_tap(bool inside, uvec2 word, float expected, float nearness, float exponent, Kernel k, inout Sum s)
{
    bool same = all(bvec3(inside, !is_nothing(word), is_on_plane(k.plane, expected, nearness)));
    float w = mix(0.0, exp2(min(mean_log_width(word) - k.log_width, 0.0) - exponent), same);   /* not by ?:, a branch */
    s.mean += w * visibility_of(word);
    s.weight += w;
    s.squares += w * w;
}

float nearness_of(uvec2 word, Kernel k) { return exp2(depth_bits(word) * k.nearness.x + k.nearness.y); }

/* Two of the four texels of a gather each. */
void add_near(ivec2 pixel, Kernel k, inout Sum s)
{
    const int next[4] = int[4](1, 3, 0, 2);
    vec2 scale = g.texel_uv.xy;
    bvec3 columns = bvec3(pixel.x > 0, true, pixel.x + 1 < rect_size().x), rows = bvec3(pixel.y > 0, true, pixel.y + 1 < rect_size().y);
    UNROLL for (int corner = 0; corner < 4; corner++) {
        ivec2 at = ivec2(corner & 1, corner >> 1);
        uvec4 x = textureGather(in_mean, vec2(pixel + at) * scale, 0).wzxy, y = uvec4(0u);
#ifdef TRANSLUCENCY
        y = textureGather(in_mean, vec2(pixel + at) * scale, 1).wzxy;
#endif
        UNROLL for (int i = 0; i < 2; i++) {
            int texel = i == 0 ? corner : next[corner];
            ivec2 offset = at - 1 + ivec2(texel & 1, texel >> 1);
            uvec2 word = uvec2(x[texel], y[texel]);
            bool inside = all(bvec2(columns[offset.x + 1], rows[offset.y + 1]));
            add_tap(inside, word, k.plane.at.x + dot(k.plane.at.yz, vec2(offset)), nearness_of(word, k), across_squared(k.across, vec2(offset)), k, s);
        }
    }
}

/* The nearest whole numbers, for less than 2^22: cheaper than conversions. whole: the same as integers. */
vec2 round_offset(vec2 v, out ivec2 whole)
{
    precise vec2 raised = v + 12582912.0, rounded = raised - 12582912.0;
    whole = floatBitsToInt(raised) - 0x4b400000;
    return rounded;
}

/* The disc perpendicular to the light, seen by the camera on the surface, is an ellipse: offset = inverse transpose of the Cholesky factor
   of the quadratic form, times the point on the disc. reach_px bounds its longer axis. */
void add_far(ivec2 pixel, Kernel k, float reach_px, inout Sum s)
{
    float angle = random_of(ivec2(0), 1u) * 6.2831853;
    vec3 q = k.across / FALLOFF + vec3(1.0, 0.0, 1.0) / (reach_px * reach_px);
    float per_a = inversesqrt(q.x), b = q.y * per_a, per_c = inversesqrt(max(q.z - b * b, 1e-12));
    vec2 turn = vec2(cos(angle), sin(angle));
    UNROLL for (int i = 0; i < FAR_TAPS; i++) {
        vec2 disc = sqrt((float(i) + 0.5) / float(FAR_TAPS)) * turn, flat_offset = vec2((disc.x - b * per_c * disc.y) * per_a, per_c * disc.y);
        ivec2 whole;
        float deeper = relative_depth(k.frame, flat_offset);
        vec2 offset = round_offset(flat_offset / deeper, whole);
        uvec2 word = texelFetch(in_mean, clamp(pixel + whole, ivec2(0), rect_size() - 1), 0).xy;
        add_tap(all(lessThan(uvec2(pixel + whole), uvec2(rect_size()))), word, k.plane.at.x + dot(k.plane.at.yz, offset), nearness_of(word, k), across_squared(k.across, deeper * offset), k, s);
        turn = vec2(turn.x * GOLDEN_TURN.x - turn.y * GOLDEN_TURN.y, turn.x * GOLDEN_TURN.y + turn.y * GOLDEN_TURN.x);
    }
}

Visibility filter_mean(ivec2 pixel, uvec2 word, float width_px, out float deviation)
{
    float z = unpack_depth(word, g.denoising_range), frames = mean_frames(word);
    vec3 position_vs = view_position(ray_uv(pixel), z, g.frustum, g.orthographic), normal_vs = load_normal_vs(in_normal_roughness, pixel);
    float tolerance = max(g.plane_distance_sensitivity * frustum_size(z), 4.0 * DEPTH_ERROR * z);
    Kernel k;
    k.frame = make_light_frame(position_vs, normal_vs);
    k.plane = make_nearness_plane(k.frame, z, tolerance);
    k.nearness = depth_logarithm(g.denoising_range) * mix(-1.0, 1.0, g.orthographic);
    float radius = max(g.penumbra_blur_scale * width_px * inversesqrt(sqrt(frames)), 1e-3) * k.frame.pixel;
    k.across = k.frame.across * (FALLOFF / (radius * radius));
    k.log_width = log2(width_px);
    Sum s = Sum(visibility_of(word), 1.0, 1.0);
    add_near(pixel, k, s);
    add_far(pixel, k, REACH * float(min(g.rect_width, g.rect_height)), s);
    Visibility mean = s.mean / s.weight;
    deviation = sqrt((luma_of(mean) * (1.0 - luma_of(mean)) + 0.02) * s.squares / (s.weight * s.weight) / frames);
    return mix(visibility_of(word), mean, smoothstep(0.1, 0.35, width_px * g.penumbra_blur_scale / 0.6));
}

float reprojected_luma(ivec2 pixel, uvec2 word)
{
#ifdef TRANSLUCENCY
    return byte_of(word.y, 16);
#else
    return texelFetch(in_stabilized, pixel, 0).x;
#endif
}

Visibility stabilize(ivec2 pixel, uvec2 word, Visibility v, float deviation)
{
    float frames = min(mean_frames(word) - 1.0, g.max_stabilized_frames), slack = 2.0 * deviation, luma = luma_of(v);
    if (is_absent(NRD_ABSENT_STABILIZATION) || !(frames > 0.0)) return v;
    float stable = mix(luma, clamp(reprojected_luma(pixel, word), luma - slack, luma + slack), frames / (1.0 + frames));
    return luma > 0.0 ? min(v * (stable / luma), ALL_LIGHT) : Visibility(stable);
}

void store_history(ivec2 pixel, uvec2 word)
{
    imageStore(out_history, pixel, uvec4(word.x));
#ifdef TRANSLUCENCY
    imageStore(out_history_color, pixel, uvec4(word.y));
#endif
}

void process(ivec2 pixel)
{
    if (!in_rect(pixel)) return;
    if ((tile_marks & TILE_ACTIVE) == 0u) {
        store_history(pixel, uniform_history((tile_marks & TILE_LIT) != 0u));
        return;
    }
    uvec2 word = texelFetch(in_mean, pixel, 0).xy;
    if (mean_age_code(word) == 0u) {
        store_history(pixel, is_nothing(word) ? uvec2(0u) : pack_ray_history(word));
        return;
    }
    float deviation;
    Visibility v = filter_mean(pixel, word, mean_width_px(word), deviation);
    v = stabilize(pixel, word, v, deviation);
    store_history(pixel, pack_history(word, pack_byte(luma_of(v), random_of(pixel, 2u))));
    imageStore(out_shadow, pixel, shadow_texel(v));
}
