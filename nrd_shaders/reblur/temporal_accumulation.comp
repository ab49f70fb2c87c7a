/* Reads   guides, noisy signal, last frame's history, lengths, guides, stabilised luma and lighting change.
   Writes  accumulated colour and deviation, length, hit distance, reprojected stabilised luma, this frame's guide, tile statistics.
   Finds every pixel in the previous frame, keeps what is on the same surface, and averages the new sample into it.
   First in the chain: everything after it works on an average with a known number of frames and a known deviation.
   Recurrent accumulation: D. Zhdan, "Fast Denoising with Self-Stabilizing Recurrent Blurs", GTC 2020;
   per-pixel moments: C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/texel.glsl"
#include "reblur.glsl"

layout(binding = 1) uniform sampler2D in_motion;
layout(binding = 2) uniform sampler2D in_normal_roughness;
layout(binding = 3) uniform sampler2D in_view_z;
layout(binding = 4) uniform sampler2D in_radiance_hit_dist;
layout(binding = 5) uniform sampler2D in_confidence;
layout(binding = 6) uniform sampler2D in_threshold_mix;
layout(binding = 7) uniform usampler2D prev_guide;
layout(binding = 8) uniform sampler2D history;
layout(binding = 9) uniform sampler2D prev_stabilized;
layout(binding = 10) uniform sampler2D prev_tile;
layout(binding = 11, rgba16f) uniform writeonly image2D out_color;
layout(binding = 12, rg32ui) uniform writeonly uimage2D out_guide;
layout(binding = 13, rgba16f) uniform writeonly image2D out_tile_raw;

/* Tried 0.1 to 1: more blurs normal-mapped walls under a moving camera, less makes heavy-tailed inputs noisier. */
const float BEND_TOLERANCE = 0.3;
const float LEAST_BEND = 1e-3;   /* 2.6 degrees: twice what the guide's normals resolve */

/* Frames of history from which on a pixel has a say in whether lighting changed. 2 to 6 tried; below CHANGED_FRAMES, or a change silences its tile. */
const float SETTLED_FRAMES = 4.0;

shared vec4 s_sums[64];

struct Reprojection {
    vec2 uv;
    vec3 position;   /* previous view space */
    float tolerance; /* plane distance, units */
};

struct History {
    vec4 color;      /* Y, Co, Cg, deviation of one sample's luma */
    float frames;
    float hit_dist;
    float stabilized;
    float bend;      /* 1 - cos of the mean angle to the normals of that history */
};

Reprojection reproject(ivec2 pixel, vec2 uv, float z, float signed_z)
{
    Reprojection r;
    vec3 motion = texelFetch(in_motion, pixel + rect_origin(), 0).xyz * g.motion_scale.xyz;
    vec3 position = view_position(uv, z, g.frustum, g.orthographic);
    if ((g.motion_mode | opaque_zero()) == NRD_MOTION_WORLD) {
        vec3 world = mat3(g.view_to_world) * position + motion;
        r.position = (g.world_to_view_prev * vec4(world, 1.0)).xyz;
        r.uv = project_prev(r.position);
    } else {
        r.uv = uv + motion.xy;
        float still_z = (g.view_to_view_prev * vec4(position, 1.0)).z;   /* a static point's */
        float z_prev = (g.motion_mode | opaque_zero()) == NRD_MOTION_2_5D ? abs(signed_z + motion.z) : still_z;
        r.position = view_position(r.uv, z_prev, g.frustum_prev, g.orthographic_prev);
    }
    float threshold = g.disocclusion_threshold;
    if ((SPEC_FEATURES & NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX) != 0 && has_flag(NRD_FLAG_DISOCCLUSION_MIX))
        threshold = mix(threshold, g.disocclusion_threshold_alternate, texelFetch(in_threshold_mix, pixel, 0).x);
    r.tolerance = plane_tolerance(threshold, z);
    return r;
}

History no_history() { return History(vec4(0.0), 0.0, 0.0, 0.0, 0.0); }

/* Bilinear weights of the 2 x 2 texels from base on, 0 where a texel is not the same surface: on its plane, same material. */
vec4 footprint(Reprojection r, ivec2 base, vec2 f, uvec4 guides, vec3 normal_ws, uint material)
{
    vec2 size_prev = vec2(g.rect_width_prev, g.rect_height_prev);
    Plane plane = make_plane(mat3(g.world_to_view_prev) * normal_ws, r.position, (vec2(base) + 0.5) / size_prev, 1.0 / size_prev, g.frustum_prev,
                             g.orthographic_prev, 1.0 / r.tolerance, g.denoising_range_prev);
    vec4 w = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    for (int i = 0; i < 4; i++) {
        ivec2 offset = ivec2(i & 1, i >> 1);
        bool inside = all(lessThan(uvec2(base + offset), uvec2(g.rect_width_prev, g.rect_height_prev)));
        bool on_plane = abs(plane_distance(plane, vec2(offset), guide_relative_depth(guides[i]))) < 1.0;
        if (!inside || !on_plane || guide_is_sky(guides[i]) || !same_material(guides[i] >> 30, material)) w[i] = 0.0;
    }
    return w;
}

/* What the previous frame knows of this surface. Custom bilinear: the texels of the footprint that are the same surface, renormalised. */
History fetch_history(Reprojection r, vec3 normal_ws, uint material)
{
    vec2 position_px = r.uv * vec2(g.rect_width_prev, g.rect_height_prev), corner = floor(position_px - 0.5), f = position_px - 0.5 - corner;
    vec2 uv = (corner + 1.0) / vec2(textureSize(prev_guide, 0));   /* where the four meet */
    ivec2 base = ivec2(corner);
    uvec4 guides = textureGather(prev_guide, uv, 0).wzxy, aux_texels = textureGather(prev_guide, uv, 1).wzxy;
    vec4 stabilized = textureGather(prev_stabilized, uv, 0).wzxy;
    vec4 w = footprint(r, base, f, guides, normal_ws, material);
    float sum = w.x + w.y + w.z + w.w;
    History h = no_history();
    if (!(sum > 0.01)) return h;
    w /= sum;
    for (int i = 0; i < 4; i++) {
        if (!(w[i] > 0.0)) continue;
        Aux aux = unpack_aux(aux_texels[i]);
        h.bend += w[i] * max(guide_bend(guides[i], normal_ws), 0.0);
        h.frames += w[i] * aux.frames;
        h.hit_dist += w[i] * aux.hit_dist;
        h.stabilized += w[i] * stabilized[i];
        h.color += w[i] * texelFetch(history, base + ivec2(i & 1, i >> 1), 0);
    }
    h.frames *= sqrt(sum);   /* part of the footprint is gone: the rest is stretched */
    return h;
}

/* Where lighting changed last frame, history was rescaled then and counts as short now. */
float shorten(float frames, vec2 uv_prev)
{
    ivec2 rect_prev = ivec2(g.rect_width_prev, g.rect_height_prev);
    float change = has_flag(NRD_FLAG_TILE_HISTORY) ? sample_tiles(prev_tile, uv_prev * vec2(rect_prev), rect_prev).x : 0.0;
    if ((SPEC_FEATURES & NRD_FEATURE_HISTORY_CONFIDENCE) != 0 && has_flag(NRD_FLAG_HISTORY_CONFIDENCE))
        frames *= clamp(textureLod(in_confidence, uv_prev, 0.0).x, 0.0, 1.0);
    return mix(frames, min(frames, CHANGED_FRAMES), change);
}

/* History of a surface that faced another way (normal maps under motion) is biased; accept it only as long as its bias is below what
   noise it removes: with relative variance V of a sample, V / frames of noise are left, against a relative bias that grows as the
   square root of bend. Noisy inputs keep their history, clean ones keep their detail. */
float bend_limit(History h)
{
    float relative_variance = (h.color.w * h.color.w + 1e-12) / (h.color.x * h.color.x + 1e-12);
    return h.bend < LEAST_BEND ? 64.0 : max(BEND_TOLERANCE * relative_variance / h.bend, 1.0);
}

/* Welford's recurrence with the length as an effective one; sigma is the unbiased deviation of single samples. */
float update_sigma(float sigma, float delta, float frames)
{
    if (frames < 0.5) return 0.0;
    float variance = delta * delta * frames / (frames + 1.0);
    return sqrt(mix(sigma * sigma, variance, 1.0 / max(frames, 1.0)));
}

/* Returns what the pixel adds to its tile: (luma change, its expected square, luma, 1). The square is mostly the new sample's own, which
   follows a change at once; the history's part keeps skewed noise (rare bright samples) from looking like darkening. */
vec4 accumulate(ivec2 pixel)
{
    float signed_z = in_rect(pixel) ? texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale : 0.0, z = abs(signed_z);
    if (!in_rect(pixel)) return vec4(0.0);
    if (is_sky(signed_z)) {
        imageStore(out_guide, pixel, uvec4(GUIDE_SKY, 0u, 0u, 0u));
        return vec4(0.0);
    }
    nrd_surface surface = nrd_decode_normal_roughness(texelFetch(in_normal_roughness, pixel + rect_origin(), 0), SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT);
    vec4 noisy = texelFetch(in_radiance_hit_dist, pixel, 0);
    noisy = nrd_is_finite(noisy.xyz) ? vec4(clamp(noisy.x, 0.0, 65504.0), clamp(noisy.yz, -65504.0, 65504.0), nrd_sanitize_norm_hit_dist(noisy.w)) : vec4(0.0);
    History h = no_history();
    Reprojection r = reproject(pixel, pixel_uv(pixel), z, signed_z);
    if (!is_reset()) h = fetch_history(r, surface.normal, surface.material_id);
    if (h.frames > 0.0) h.frames = min(min(shorten(h.frames, r.uv), bend_limit(h)), g.max_accumulated_frames);

    float alpha = 1.0 / (1.0 + h.frames), delta = noisy.x - h.color.x;
    vec4 color = vec4(mix(h.color.xyz, noisy.xyz, alpha), update_sigma(h.color.w, delta, h.frames));
    Aux aux = Aux(min(h.frames + 1.0, 63.75), mix(h.hit_dist, noisy.w, alpha), h.frames > 0.0 ? h.stabilized : -1.0);
    float random = (float(hash(uint(pixel.x), uint(pixel.y), g.frame_index) >> 24) + 0.5) / 256.0;
    imageStore(out_color, pixel, dither_to_half(color, random));
    imageStore(out_guide, pixel, uvec4(guide_pack(z, surface.normal, surface.material_id), pack_aux(aux, random), 0u, 0u));
        return h.frames > SETTLED_FRAMES ? vec4(delta, mix(delta * delta, h.color.w * h.color.w, 0.25), h.color.x, 1.0) : vec4(0.0);
}

/* Mean of the 8 x 8 pixels; the square as a root, so that it fits 16 bits. */
void write_tile(vec4 mine)
{
    uint i = gl_LocalInvocationIndex;
    s_sums[i] = mine;
    barrier();
    if (i < 8u) {
        vec4 row = vec4(0.0);
        for (uint k = 0u; k < 8u; k++) row += s_sums[i + 8u * k];
        s_sums[i] = row;
    }
    barrier();
    if (i != 0u) return;
    vec4 sum = vec4(0.0);
    for (uint k = 0u; k < 8u; k++) sum += s_sums[k];
    float n = max(sum.w, 1.0);
    vec4 mean = vec4(clamp(sum.x / n, -65504.0, 65504.0), min(sqrt(sum.y / n), 65504.0), min(sum.z / n, 65504.0), sum.w);
    imageStore(out_tile_raw, ivec2(gl_WorkGroupID.xy), nrd_round_to_half(mean));
}

void main() { write_tile(accumulate(ivec2(gl_GlobalInvocationID.xy))); }
