/* Reads   accumulated colour and deviation, lengths, guides, lighting change.
   Writes  history (partly filtered), colour and variance for the post-blurs.
   First, dense step of the edge-avoiding wavelet filter. It has no luma weight: it pools the variance that later steps need, and
   rescues short histories with looser geometry. Part of the result returns to history (recurrent blur): fully while history is
   short, then less and less, so that nothing is blurred twice for long.
   A-trous: H. Dammertz et al., HPG 2010; pooled moments and feedback of the first step: C. Schied et al., HPG 2017. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/texel.glsl"
#include "reblur.glsl"

layout(binding = 1) uniform sampler2D in_color;
layout(binding = 2) uniform usampler2D in_guide;
layout(binding = 3) uniform sampler2D in_tile;
layout(binding = 4, rgba16f) uniform writeonly image2D out_history;
layout(binding = 5, rg32ui) uniform writeonly uimage2D out_color;

struct Sums {
    vec3 color;
    float weight;
    float moment;      /* of single samples: sum of weight * (sigma^2 + luma^2) */
    float luma;
    float variance;
    float noise;       /* sum of weight^2 / frames: what is left of the variance */
};

void add(inout Sums s, vec4 color, float frames, float w)
{
    s.color += w * color.xyz;
    s.luma += w * color.x;
    s.moment += w * (color.w * color.w + color.x * color.x);
    s.variance += w * color.w * color.w;
    s.noise += w * w / frames;
    s.weight += w;
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel)) return;
    uvec2 guide = texelFetch(in_guide, pixel, 0).xy;
    if (guide_is_sky(guide.x)) return;
    vec4 change = has_flag(NRD_FLAG_ANTILAG) ? sample_tiles(in_tile, vec2(pixel) + 0.5, rect_size()) : vec4(0.0, 1.0, 0.0, 0.0);
    float frames = aux_frames(guide.y);
    frames = max(mix(frames, min(frames, CHANGED_FRAMES), change.x), 1.0);
    float slack = 1.0 + g.history_fix_frames * g.history_fix_frames / (frames * frames), normal_scale = -LOG2_E * g.normal_sensitivity / slack;
    Center c = make_center(pixel, guide.x, slack);
    vec4 color = texelFetch(in_color, pixel, 0);
    Sums s = Sums(vec3(0.0), 0.0, 0.0, 0.0, 0.0, 0.0);
    add(s, color, frames, frames);
    for (int i = 0; i < 9 && is_filtering(); i++) {
        if (i == 4) continue;
        ivec2 grid = ivec2(i % 3, i / 3) - 1;
        Neighbour n = find_neighbour(c, grid);
        uvec2 guide_tap = texelFetch(in_guide, n.pixel, 0).xy;
        vec4 color_tap = texelFetch(in_color, n.pixel, 0);
        float frames_tap = max(aux_frames(guide_tap.y), 1.0);
        float w = plane_weight(c, n, guide_tap.x) * frames_tap * kernel(grid) * exp2(normal_scale * guide_bend(guide_tap.x, c.normal));
        if (w > 0.0) add(s, color_tap, frames_tap, w);
    }
    float scale = mix(1.0, change.y, change.x), mean = s.luma / s.weight;
    float sample_variance = max(s.moment / s.weight - mean * mean, 0.0) * scale * scale;
    vec3 filtered = s.color / s.weight * scale;
    vec3 kept = mix(color.xyz * scale, filtered, min(1.0, g.feedback_frames / frames));
    imageStore(out_history, pixel, round_half(clamp(vec4(kept, sqrt(s.variance / s.weight) * scale), -65504.0, 65504.0)));
    float sigma = sqrt(sample_variance * s.noise) / s.weight;
    imageStore(out_color, pixel, uvec4(pack_texel(clamp(vec4(filtered, sigma), -65504.0, 65504.0)), 0u, 0u));
}
