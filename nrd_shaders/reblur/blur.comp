/* Reads   accumulated colour and deviation, lengths, guides, lighting change.
   Writes  history (partly filtered), colour and deviation for the post-blurs.
   First, dense step of the edge-avoiding wavelet filter. It has no luma weight: it pools the variance that later steps need, and
   rescues short histories with looser geometry. Part of the result returns to history (recurrent blur): fully while history is
   short, then less and less, so that nothing is blurred twice for long.
   Also the third step (SPEC_ITERATION 2: post-blur 2), which goes the same way, from OUT to the packed intermediate: a sparse one, guided by
   the variance that the first has pooled: where the average is already certain, or the neighbour is certainly different, nothing is
   mixed. Not fed back: history stays sharp. SH has no sparse step of its own: the plain denoiser's leave its light alone.
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

#define SH_FIRST (FIRST + 4 * HAS_DIFFUSE + 4 * HAS_SPECULAR)
#ifdef SH
#ifdef DIFFUSE
layout(binding = SH_FIRST) uniform sampler2D in_diff_light;
#endif
#ifdef SPECULAR
layout(binding = SH_FIRST + HAS_DIFFUSE) uniform sampler2D in_spec_light;
#endif
layout(binding = SH_FIRST + HAS_DIFFUSE + HAS_SPECULAR, LIGHTS_FORMAT) uniform writeonly uimage2D out_lights;
#define SH_HISTORY (SH_FIRST + 1 + HAS_DIFFUSE + HAS_SPECULAR)
#ifdef DIFFUSE
layout(binding = SH_HISTORY, rgba16f) uniform writeonly image2D out_diff_light_history;
#endif
#ifdef SPECULAR
layout(binding = SH_HISTORY + HAS_DIFFUSE, rgba16f) uniform writeonly image2D out_spec_light_history;
#endif

vec4 load_light(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(in_diff_light, p, 0), return texelFetch(in_spec_light, p, 0)) }

void store_lights(ivec2 p, vec4 lights[SIGNALS])
{
    uvec4 words = uvec4(0u);
    UNROLL for (int s = 0; s < SIGNALS; s++) words[s] = pack_light(lights[s]);
    imageStore(out_lights, p, words);
}

void store_light_history(int s, ivec2 p, vec4 v) { OF_SIGNAL(s, imageStore(out_diff_light_history, p, v), imageStore(out_spec_light_history, p, v)) }
#endif

vec4 load_color(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(in_diff, p, 0), return texelFetch(in_spec, p, 0)) }
vec4 load_change(int s, vec2 px) { OF_SIGNAL(s, return sample_tiles(in_diff_tile, px, g.tile_last.xy, g.tile_uv.xy), return sample_tiles(in_spec_tile, px, g.tile_last.xy, g.tile_uv.xy)) }
void store_history(int s, ivec2 p, vec4 v) { OF_SIGNAL(s, imageStore(out_diff_history, p, v), imageStore(out_spec_history, p, v)) }
void store_color(int s, ivec2 p, uvec2 v) { OF_SIGNAL(s, imageStore(out_diff, p, uvec4(v, 0u, 0u)), imageStore(out_spec, p, uvec4(v, 0u, 0u))) }

#ifdef SH
#define TILES (SH_HISTORY + HAS_DIFFUSE + HAS_SPECULAR)
#else
#define TILES SH_FIRST
#endif
#include "../common/tiles.glsl"
#include "cells.glsl"

struct Sums {
    vec3 color;
    float weight;
    float luma;        /* of the centre */
    float moment;      /* of single samples about that: sum of weight * (sigma^2 + (luma - centre)^2). About 0, rounding would be noise of 2e-4 */
    float variance;
    float noise;       /* sum of weight^2 / frames: what is left of the variance */
#ifdef SH
    LightSums light;
#endif
};

Sums no_sums(float luma)
{
    Sums s;
    s.luma = luma;
    s.color = vec3(0.0);
    s.weight = s.moment = s.variance = s.noise = 0.0;
    SH_ONLY(s.light = no_light();)
    return s;
}

/* w: weight per frame of history. */
void add(inout Sums s, vec4 color, float frames, float weight)
{
    float w = weight * frames, variance = color.w * color.w, off = color.x - s.luma;
    s.color += w * color.xyz;
    s.moment += w * (variance + off * off);
    s.variance += w * variance;
    s.noise += w * weight;
    s.weight += w;
}

float changed_frames(float frames, vec4 change) { return max(mix(frames, min(frames, CHANGED_FRAMES), change.x), 1.0); }

/* Histories shorter than history_fix_frames take neighbours with looser geometry. */
float short_history_slack(float frames) { return 1.0 + g.history_fix_frames * g.history_fix_frames / (frames * frames); }

#ifdef SH
/* History gets the same mix of the pixel's own and the filtered light as it gets of colours. Returns the filtered one. */
vec4 mix_light(ivec2 pixel, int signal, vec4 own, float luma, Sums s, Receiver receiver, float frames)
{
    vec4 filtered = finish_light(s.light, receiver, signal, mat3(g.view_to_world) * s.light.normal / s.weight, s.color.x, s.weight * s.weight / s.noise);
    float share = min(1.0, g.feedback_frames / frames), filtered_luma = s.color.x / s.weight;
    vec4 kept = mix(own * luma, filtered * filtered_luma, share);
    store_light_history(signal, pixel, round_half(relative_light(kept.xyz, kept.w, mix(luma, filtered_luma, share))));
    return filtered;
}

void store_light(ivec2 pixel, uvec2 guide, vec4 color[SIGNALS], Sums sums[SIGNALS], float frames[SIGNALS])
{
    Receiver receiver = make_receiver(guide, pixel_uv(pixel), guide_relative_depth(guide.x) * g.denoising_range, guide_roughness(guide));
    vec4 lights[SIGNALS];
    UNROLL for (int s = 0; s < SIGNALS; s++) {
        lights[s] = cell_light(s, cell_at(ivec2(0)));
        IF_HEARD(s) lights[s] = mix_light(pixel, s, lights[s], color[s].x, sums[s], receiver, frames[s]);
    }
    store_lights(pixel, lights);
}
#endif

void store(ivec2 pixel, int signal, vec4 color, Sums s, float frames, vec4 change)
{
    float scale = mix(1.0, change.y, change.x), off = s.color.x / s.weight - s.luma;
    float sample_variance = max(s.moment / s.weight - off * off, 0.0) * scale * scale;
    vec3 filtered = s.color / s.weight * scale;
    vec3 kept = mix(color.xyz * scale, filtered, min(1.0, g.feedback_frames / frames));
    uint random = hash(uint(pixel.x), uint(pixel.y), ~g.frame_index) >> 8;
    store_history(signal, pixel, dither_color(clamp(vec4(kept, sqrt(s.variance / s.weight) * scale), -65504.0, 65504.0), random));
    float sigma = sqrt(sample_variance * s.noise) / s.weight;
    store_color(signal, pixel, pack_texel(clamp(vec4(filtered, sigma), -65504.0, 65504.0)));
}

/* The luma above which a pixel of 3x3 is cut, by the second brightest of them; what is cut does not return to history. Where at most one is not
   black nothing is: light that is found by chance begins like that. */
float firefly_ceiling(int signal, float luma)
{
    float brightest = luma, second = 0.0;
    for (int i = 0; i < 9; i++) {
        int cell = cell_at(ivec2(i % 3, i / 3) - 1);
        if (i == 4 || is_outside(s_guide[cell])) continue;   /* holds anything */
        IF_SILENT(s_guide[cell], signal) continue;
        float tap = cell_color(signal, cell).x;
        second = max(second, min(tap, brightest));
        brightest = max(brightest, tap);
    }
    return second > 0.0 ? g.motion_scale.w * second : 65504.0;
}

vec4 cut(vec4 color, float ceiling) { return color * min(1.0, ceiling / max(color.x, 1e-12)); }

/* Frames of history that a pixel and its neighbours have together below which it is alone. 1.5 to 8 tried: less leaves noise, more leaks light
   onto thin things that have a little history. */
const float ALONE = 2.0;

/* What neighbours on other surfaces count for beside it (0.06 to 1 tried), of how many frames at most, and what of the angle to them counts: more
   leaves thin reflections noisy, none lets highlights leak. */
const float STRANGER = 0.25, STRANGER_FRAMES = 16.0, STRANGER_BEND = 0.03;

/* Pixels of thin geometry that have neither a history nor neighbours on their plane would stay as noisy as their one sample is: they take what their
   neighbours at about their depth (0.7 to 1.45 times it) see. Mirrors keep theirs, which have no noise: the lobe's footprint counts in full. */
void take_strangers(inout Sums sums[SIGNALS], bool alone[SIGNALS], uvec2 guide, Center c, float ceiling[SIGNALS])
{
    float z = guide_relative_depth(guide.x), normal_scale = -LOG2_E * g.normal_sensitivity;
    for (int i = 0; i < 9; i++) {
        ivec2 grid = ivec2(i % 3, i / 3) - 1;
        int cell = cell_at(grid);
        uvec2 guide_tap = s_guide[cell];
        if (i == 4 || is_outside(guide_tap) || !guide_same_material(guide_material_word(guide_tap), c.material)) continue;
        float z_tap = guide_relative_depth(guide_tap.x), close = clamp(3.2 * min(z, z_tap) / max(z, z_tap) - 2.2, 0.0, 1.0), bend = STRANGER_BEND * guide_bend(guide_point(guide_tap), c.normal);
        UNROLL for (int s = 0; s < SIGNALS; s++) {
            float exponent = lobe_exponent(c, s, normal_scale, bend, float(abs(grid.x) + abs(grid.y)));
            float weight = STRANGER * close * lobe_factor(c, s, guide_tap) * exp2(exponent), frames = clamp(guide_frames(guide_tap, s), 1.0, STRANGER_FRAMES);
            if (!alone[s] || !(weight > 0.0)) continue;
            vec4 tap = cut(cell_color(s, cell), ceiling[s]);
            add(sums[s], tap, frames, weight);
            SH_ONLY(add_light(sums[s].light, cell_light(s, cell), tap.x, guide_tap_normal(guide_tap), weight * frames);)
        }
    }
}

/* The first step, whose neighbours lie side by side: nrdi_step(). */
void blur(ivec2 pixel, uvec2 guide)
{
    float frames[SIGNALS];
    vec4 change[SIGNALS], color[SIGNALS];
    float ceiling[SIGNALS];
    bool limited = g.motion_scale.w > float(opaque_zero());
    Sums sums[SIGNALS];
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_WORTH_IT(s) {
        change[s] = has_flag(NRD_FLAG_ANTILAG) ? load_change(s, vec2(pixel) + 0.5) : vec4(0.0, 1.0, 0.0, 0.0);
        change[s].y /= 1.0 + (change[s].y - 1.0) / max(guide_frames(guide, s), 1.0);   /* the newest sample has followed already */
        frames[s] = changed_frames(guide_frames(guide, s), change[s]);
        color[s] = cell_color(s, cell_at(ivec2(0)));
        ceiling[s] = limited ? firefly_ceiling(s, color[s].x) : 65504.0;
        if (limited) color[s] = cut(color[s], ceiling[s]);
        sums[s] = no_sums(color[s].x);
        add(sums[s], color[s], frames[s], 1.0);
        SH_ONLY(add_light(sums[s].light, cell_light(s, cell_at(ivec2(0))), color[s].x, guide_tap_normal(guide), frames[s]);)
    }
    float slack = short_history_slack(frames[0]), normal_scale = -LOG2_E * g.normal_sensitivity / slack;
    Center c = make_center(pixel, guide, slack, TRACKED(pixel));
    UNROLL for (int i = 0; i < 9; i++) {
        if (i == 4 || !is_filtering()) continue;
        ivec2 grid = ivec2(i % 3, i / 3) - 1;
        int cell = cell_at(grid);
        uvec2 guide_tap = s_guide[cell];
        Neighbour n = find_neighbour(c, grid);
        n.inside = !is_outside(guide_tap);
        float geometry = plane_weight(c, n, guide_tap) * kernel(grid), bend = guide_bend(guide_point(guide_tap), c.normal);
        UNROLL for (int s = 0; s < SIGNALS; s++) IF_WORTH_IT(s) {
            vec4 tap = cell_color(s, cell);
            if (limited) tap = cut(tap, ceiling[s]);
            float frames_tap = max(guide_frames(guide_tap, s), 1.0);
            float weight = geometry * lobe_factor(c, s, guide_tap) * exp2(lobe_exponent(c, s, normal_scale, bend, n.squared));
            if (weight > 0.0) add(sums[s], tap, frames_tap, weight);
            SH_ONLY(if (weight > 0.0) add_light(sums[s].light, cell_light(s, cell), tap.x, guide_tap_normal(guide_tap), weight * frames_tap);)
        }
    }
    bool alone[SIGNALS];
    UNROLL for (int s = 0; s < SIGNALS; s++) alone[s] = is_filtering() && sums[s].weight < ALONE;
    if (alone[0] || alone[SIGNALS - 1]) take_strangers(sums, alone, guide, c, ceiling);
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_HEARD(s) store(pixel, s, color[s], sums[s], frames[s], change[s]);
    SH_ONLY(store_light(pixel, guide, color, sums, frames);)
}

#ifndef SH   /* whose third step is that of the plain denoiser */
const bool CROSS = false;
#include "atrous.glsl"

/* The third step. */
void post_blur(ivec2 pixel, uvec2 guide)
{
    vec4 color[SIGNALS];
    UNROLL for (int s = 0; s < SIGNALS; s++) color[s] = load_color(s, pixel);
    atrous(make_center(pixel, guide, 1.0, TRACKED(pixel)), color);
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_HEARD(s) store_color(s, pixel, pack_texel(color[s]));
}
#endif

void process(ivec2 pixel)
{
    if (SPEC_ITERATION == 0u) load_cells();
    if (!in_rect(pixel)) return;
    uvec2 guide = SPEC_ITERATION == 0u ? s_guide[cell_at(ivec2(0))] : texelFetch(in_guide, pixel, 0).xy;
    if (guide_is_sky(guide.x)) return;
    HEAR(guide);
    if (SPEC_ITERATION == 0u) blur(pixel, guide);
#ifndef SH
    else post_blur(pixel, guide);
#endif
}
