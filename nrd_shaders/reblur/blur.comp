/* Reads   accumulated colour and deviation, lengths, guides, lighting change.
   Writes  history (partly filtered), colour and deviation for the post-blurs.
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

layout(binding = 1) uniform usampler2D in_guide;
#ifdef SPECULAR
layout(binding = 2) uniform usampler2D in_track;
#endif
#define FIRST (2 + HAS_SPECULAR)
#ifdef DIFFUSE
layout(binding = FIRST) uniform sampler2D in_diff;
layout(binding = FIRST + 1) uniform sampler2D in_diff_tile;
layout(binding = FIRST + 2, rgba16f) uniform writeonly image2D out_diff_history;
layout(binding = FIRST + 3, rg32ui) uniform writeonly uimage2D out_diff;
#endif
#ifdef SPECULAR
#define SECOND (FIRST + 4 * HAS_DIFFUSE)
layout(binding = SECOND) uniform sampler2D in_spec;
layout(binding = SECOND + 1) uniform sampler2D in_spec_tile;
layout(binding = SECOND + 2, rgba16f) uniform writeonly image2D out_spec_history;
layout(binding = SECOND + 3, rg32ui) uniform writeonly uimage2D out_spec;
#endif

vec4 load_color(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(in_diff, p, 0), return texelFetch(in_spec, p, 0)) }
vec4 load_change(int s, vec2 px) { OF_SIGNAL(s, return sample_tiles(in_diff_tile, px, rect_size()), return sample_tiles(in_spec_tile, px, rect_size())) }
void store_history(int s, ivec2 p, vec4 v) { OF_SIGNAL(s, imageStore(out_diff_history, p, v), imageStore(out_spec_history, p, v)) }
void store_color(int s, ivec2 p, uvec2 v) { OF_SIGNAL(s, imageStore(out_diff, p, uvec4(v, 0u, 0u)), imageStore(out_spec, p, uvec4(v, 0u, 0u))) }

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

float changed_frames(float frames, vec4 change) { return max(mix(frames, min(frames, CHANGED_FRAMES), change.x), 1.0); }

/* Histories shorter than history_fix_frames take neighbours with looser geometry. */
float short_history_slack(float frames) { return 1.0 + g.history_fix_frames * g.history_fix_frames / (frames * frames); }

void store(ivec2 pixel, int signal, vec4 color, Sums s, float frames, vec4 change)
{
    float scale = mix(1.0, change.y, change.x), mean = s.luma / s.weight;
    float sample_variance = max(s.moment / s.weight - mean * mean, 0.0) * scale * scale;
    vec3 filtered = s.color / s.weight * scale;
    vec3 kept = mix(color.xyz * scale, filtered, min(1.0, g.feedback_frames / frames));
    store_history(signal, pixel, round_half(clamp(vec4(kept, sqrt(s.variance / s.weight) * scale), -65504.0, 65504.0)));
    float sigma = sqrt(sample_variance * s.noise) / s.weight;
    store_color(signal, pixel, pack_texel(clamp(vec4(filtered, sigma), -65504.0, 65504.0)));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel)) return;
    uvec2 guide = texelFetch(in_guide, pixel, 0).xy;
    if (guide_is_sky(guide.x)) return;
    float frames[SIGNALS];
    vec4 change[SIGNALS], color[SIGNALS];
    Sums sums[SIGNALS];
    UNROLL for (int s = 0; s < SIGNALS; s++) {
        change[s] = has_flag(NRD_FLAG_ANTILAG) ? load_change(s, vec2(pixel) + 0.5) : vec4(0.0, 1.0, 0.0, 0.0);
        frames[s] = changed_frames(guide_frames(guide, s), change[s]);
        color[s] = load_color(s, pixel);
        sums[s] = Sums(vec3(0.0), 0.0, 0.0, 0.0, 0.0, 0.0);
        add(sums[s], color[s], frames[s], frames[s]);
    }
    float slack = short_history_slack(frames[0]), normal_scale = -LOG2_E * g.normal_sensitivity / slack;
    Center c = make_center(pixel, guide, slack, TRACKED(pixel));
    UNROLL for (int i = 0; i < 9; i++) {
        if (i == 4 || !is_filtering()) continue;
        ivec2 grid = ivec2(i % 3, i / 3) - 1;
        Neighbour n = find_neighbour(c, grid, vec2(grid));
        uvec2 guide_tap = texelFetch(in_guide, n.pixel, 0).xy;
        float geometry = plane_weight(c, n, guide_tap.x) * kernel(grid), bend = normal_bend(c, guide_tap);
        UNROLL for (int s = 0; s < SIGNALS; s++) {
            vec4 tap = load_color(s, n.pixel);
            float frames_tap = max(guide_frames(guide_tap, s), 1.0);
            float w = geometry * frames_tap * lobe_factor(c, s, guide_tap) * exp2(lobe_exponent(c, s, normal_scale, bend, n.offset));
            if (w > 0.0) add(sums[s], tap, frames_tap, w);
        }
    }
    UNROLL for (int s = 0; s < SIGNALS; s++) store(pixel, s, color[s], sums[s], frames[s], change[s]);
}
