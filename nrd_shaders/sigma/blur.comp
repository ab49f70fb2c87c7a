/* Reads   mean visibility with its length and the penumbra's width, reprojected stabilised output, normals, tiles.
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
layout(binding = 2) uniform sampler2D in_tile;
layout(binding = 3) uniform usampler2D in_mean;
layout(binding = 4, r32ui) uniform writeonly uimage2D out_history;
#ifdef TRANSLUCENCY
layout(binding = 5, rgba8) uniform writeonly image2D out_shadow;
layout(binding = 6, r16ui) uniform writeonly uimage2D out_history_color;
#else
layout(binding = 5, r8) uniform writeonly image2D out_shadow;
layout(binding = 6) uniform sampler2D in_stabilized;
#endif

const int FAR_TAPS = 6;
const float REACH = 0.045;              /* of the picture's shorter side: longest axis of the far taps' ellipse. Longer ones miss thin occluders' ends */
const float GOLDEN_ANGLE = 2.3999632;   /* rad */

struct Sum {
    Visibility mean;
    float weight;
    float squares;
};

struct Kernel {
    LightFrame frame;
    Plane plane;
    float radius;     /* units */
    float width_px;   /* of the penumbra */
};

void add_tap(ivec2 pixel, vec2 offset, float across2, Kernel k, inout Sum s)
{
    ivec2 tap = pixel + ivec2(offset);
    if (!in_rect(tap)) return;
    uvec2 word = texelFetch(in_mean, tap, 0).xy;
    if (is_nothing(word) || abs(plane_distance(k.plane, offset, unpack_depth(word, g.denoising_range))) > 1.0) return;
    float narrower = min(mean_width_px(word) / k.width_px, 1.0);   /* the umbra of an occluder that is nearer must not leak out */
    float w = narrower * exp2(-1.5 * 1.442695 * across2 / (k.radius * k.radius));
    s.mean += w * visibility_of(word);
    s.weight += w;
    s.squares += w * w;
}

void add_near(ivec2 pixel, Kernel k, inout Sum s)
{
    for (int i = 0; i < 9; i++) {
        if (i == 4) continue;
        vec2 offset = vec2(i % 3, i / 3) - 1.0;
        add_tap(pixel, offset, across_squared(k.frame, pixels_to_plane(k.frame, offset)), k, s);
    }
}

/* The disc perpendicular to the light, seen by the camera on the surface, is an ellipse: offset = inverse transpose of the Cholesky factor
   of the quadratic form, times the point on the disc. reach_px bounds its longer axis. */
void add_far(ivec2 pixel, Kernel k, float reach_px, inout Sum s)
{
    float turn = random_of(ivec2(0), 1u) * 6.2831853, r2 = k.radius * k.radius;
    vec3 q = k.frame.across / r2 + vec3(1.0, 0.0, 1.0) / (reach_px * reach_px);
    float a = sqrt(q.x), b = q.y / a, c = sqrt(max(q.z - b * b, 1e-12));
    for (int i = 0; i < FAR_TAPS; i++) {
        float angle = turn + float(i) * GOLDEN_ANGLE;
        vec2 disc = sqrt((float(i) + 0.5) / float(FAR_TAPS)) * vec2(cos(angle), sin(angle));
        float y = disc.y / c;
        vec2 offset = round(plane_to_pixels(k.frame, vec2((disc.x - b * y) / a, y)));
        add_tap(pixel, offset, across_squared(k.frame, pixels_to_plane(k.frame, offset)), k, s);
    }
}

Visibility filter_mean(ivec2 pixel, uvec2 word, float width_px, out float deviation)
{
    vec2 uv = pixel_uv(pixel);
    float z = unpack_depth(word, g.denoising_range), frames = float(max(mean_frames(word), 1u));
    vec3 position_vs = view_position(uv, z, g.frustum, g.orthographic), normal_vs = load_normal_vs(in_normal_roughness, pixel);
    float tolerance = max(g.plane_distance_sensitivity * frustum_size(z), 4.0 * DEPTH_ERROR * z);
    Kernel k;
    k.frame = make_light_frame(position_vs, normal_vs);
    k.plane = make_plane(normal_vs, position_vs, uv, 1.0 / vec2(rect_size()), g.frustum, g.orthographic, 1.0 / tolerance, 1.0);
    k.radius = max(g.penumbra_blur_scale * width_px * inversesqrt(sqrt(frames)), 1e-3) * k.frame.pixel;
    k.width_px = width_px;
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
    float frames = min(float(mean_frames(word)) - 1.0, g.max_stabilized_frames), slack = 2.0 * deviation, luma = luma_of(v);
    if (!(frames > 0.0)) return v;
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

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    uint tile = unpack_tile(texelFetch(in_tile, ivec2(gl_WorkGroupID.xy), 0).x);
    if ((tile & (TILE_ACTIVE | TILE_STALE)) == 0u || !in_rect(pixel)) return;
    if ((tile & TILE_ACTIVE) == 0u) {
        store_history(pixel, uniform_history((tile & TILE_LIT) != 0u));
        return;
    }
    uvec2 word = texelFetch(in_mean, pixel, 0).xy;
    if (mean_frames(word) == 0u) {
        store_history(pixel, is_nothing(word) ? uvec2(0u) : pack_ray_history(word));
        return;
    }
    float deviation;
    Visibility v = filter_mean(pixel, word, mean_width_px(word), deviation);
    v = stabilize(pixel, word, v, deviation);
    store_history(pixel, pack_history(word, pack_byte(luma_of(v), random_of(pixel, 2u))));
    imageStore(out_shadow, pixel, shadow_texel(v));
}
