/* Reads   colour and deviation, guides, lengths and reprojected stabilised luma, lighting change.
   Writes  the output, stabilised luma.
   Last sparse step of the wavelet filter, then the luma is pulled towards last frame's output as far as the difference can be noise:
   the filter knows its own deviation, so no neighbourhood is needed to tell. Does not enter the colour history.
   Also the second step (SPEC_ITERATION 1: post-blur 1), which goes the same way, from the packed intermediate to OUT, and is the sparsest.
   Self-stabilisation: D. Zhdan, GTC 2020; clamping history to what the new frame allows: B. Karis, "High Quality Temporal
   Supersampling", SIGGRAPH 2014. */
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
layout(binding = FIRST) uniform usampler2D in_diff;
layout(binding = FIRST + 1) uniform sampler2D in_diff_tile;
layout(binding = FIRST + 2, r16f) uniform writeonly image2D out_diff_stabilized;
layout(binding = FIRST + 3, rgba16f) uniform writeonly image2D out_diff;
#endif
#ifdef SPECULAR
#define SECOND (FIRST + 4 * HAS_DIFFUSE)
layout(binding = SECOND) uniform usampler2D in_spec;
layout(binding = SECOND + 1) uniform sampler2D in_spec_tile;
layout(binding = SECOND + 2, r16f) uniform writeonly image2D out_spec_stabilized;
layout(binding = SECOND + 3, rgba16f) uniform writeonly image2D out_spec;
#endif

vec4 load_color(int s, ivec2 p) { OF_SIGNAL(s, return unpack_texel(texelFetch(in_diff, p, 0).xy), return unpack_texel(texelFetch(in_spec, p, 0).xy)) }
vec4 load_change(int s, vec2 px) { OF_SIGNAL(s, return sample_tiles(in_diff_tile, px, g.tile_last.xy, g.tile_uv.xy), return sample_tiles(in_spec_tile, px, g.tile_last.xy, g.tile_uv.xy)) }
void store_stabilized(int s, ivec2 p, vec4 v) { OF_SIGNAL(s, imageStore(out_diff_stabilized, p, v), imageStore(out_spec_stabilized, p, v)) }
void store_color(int s, ivec2 p, vec4 v) { OF_SIGNAL(s, imageStore(out_diff, p, v), imageStore(out_spec, p, v)) }

#define SH_FIRST (FIRST + 4 * HAS_DIFFUSE + 4 * HAS_SPECULAR)
#ifdef SH
layout(binding = SH_FIRST) uniform usampler2D in_lights;
#ifdef DIFFUSE
layout(binding = SH_FIRST + 1, rgba16f) uniform writeonly image2D out_diff_light;
#endif
#ifdef SPECULAR
layout(binding = SH_FIRST + 1 + HAS_DIFFUSE, rgba16f) uniform writeonly image2D out_spec_light;
#endif

void store_light(int s, ivec2 p, vec4 light) { vec4 v = round_half(light); OF_SIGNAL(s, imageStore(out_diff_light, p, v), imageStore(out_spec_light, p, v)) }
#endif

const bool CROSS = SPEC_ITERATION == 1u;
#include "atrous.glsl"

/* Frames added to the length of the stabilised luma: first frames are noisy, and what changes between them is seen as flicker. 0 to 8
   tried: 3 takes a quarter off the flicker for a tenth of error; more keeps the first frames' errors. */
const float HEAD_START = 3.0;

/* Short histories know their own deviation badly, most of all under rare bright samples: they may differ more. */
const float EARLY_DOUBT = 1.5;

/* Share of the slack that a darker past gets: noise is skewed, first guesses are mostly too dark, and with equal slack the picture darkens
   by 3 %. 0.5 to 1 tried: 0.5 brightens sparse light by 2 %, 0.75 darkens heavy-tailed reflections by as much. */
const float DARK_SLACK = 0.58;

/* A brighter past counts in full up to this multiple of the present, and as far as noise in proportion to the light explains it: what has no
   bright sample now underestimates its deviation. 4 was tried: its error is a tenth larger. */
const float MOST_BRIGHTER = 2.0;

float stabilize(vec4 color, float history_frames, float stabilized, vec4 change)
{
    float frames = min(history_frames + HEAD_START, g.max_stabilized_frames);
    if (is_absent(NRD_ABSENT_STABILIZATION) || stabilized < 0.0) return color.x;
    float slack = g.stabilization_sigma_scale * color.w * (1.0 + EARLY_DOUBT / max(history_frames, 1.0));
    float brighter = 1.0 / max(1.0 - slack / max(color.x, 1e-12), 1.0 / MOST_BRIGHTER);
    float allowed = clamp(stabilized * mix(1.0, change.y, change.x), color.x - DARK_SLACK * slack, color.x * brighter);
    return mix(color.x, allowed, frames / (1.0 + frames));
}

/* Specular tracks are relative to the distance to the camera. */
float norm_hit_dist(ivec2 pixel, uvec2 guide, int signal, Track track)
{
#ifdef SPECULAR
    if (signal == SPECULAR_SIGNAL) {
        float z = guide_relative_depth(guide.x) * g.denoising_range, distance = distance_to_camera(pixel_uv(pixel), z);
        return clamp(track.hit_dist / max(1.0 - track.hit_dist, 1e-3) * distance / nrd_hit_dist_scale(z, guide_roughness(guide), g.hit_distance), 0.0, 1.0);
    }
#endif
    return track.hit_dist;
}

/* Returns the luma. */
float finish(ivec2 pixel, uvec2 guide, int signal, Track track, vec4 color)
{
    vec4 change = has_flag(NRD_FLAG_ANTILAG) ? load_change(signal, vec2(pixel) + 0.5) : vec4(0.0, 1.0, 0.0, 0.0);
    float frames = guide_frames(guide, signal), luma = min(stabilize(color, frames, track.stabilized, change), 65504.0);
    color.xyz *= luma / max(color.x, 1e-12);
    if (!is_absent(NRD_ABSENT_STABILIZATION)) store_stabilized(signal, pixel, dither_to_half(vec4(luma), hash(uint(pixel.x), uint(pixel.y), g.frame_index) >> 8));
    float w = has_flag(NRD_FLAG_RETURN_HISTORY) ? frames : norm_hit_dist(pixel, guide, signal, track);
    store_color(signal, pixel, round_color(vec4(clamp(color.xyz, -65504.0, 65504.0), w)));
    return luma;
}

#ifdef SH
#define TILES (SH_FIRST + 1 + HAS_DIFFUSE + HAS_SPECULAR)
#else
#define TILES SH_FIRST
#endif
#include "../common/tiles.glsl"

void process(ivec2 pixel)
{
    if (!in_rect(pixel)) return;
    uvec2 guide = texelFetch(in_guide, pixel, 0).xy;
    if (guide_is_sky(guide.x)) return;
    HEAR(guide);
    Track tracks[SIGNALS];
    vec4 color[SIGNALS];
    UNROLL for (int s = 0; s < SIGNALS; s++) {
        tracks[s] = unpack_track(TRACK_WORD(pixel, guide, s));
        color[s] = load_color(s, pixel);
    }
    if (is_filtering()) atrous(make_center(pixel, guide, 1.0, tracks[SIGNALS - 1].hit_dist), color);
    if (SPEC_ITERATION == 1u) {
        UNROLL for (int s = 0; s < SIGNALS; s++) IF_HEARD(s) store_color(s, pixel, round_color(color[s]));
        return;
    }
    SH_ONLY(uvec4 lights = texelFetch(in_lights, pixel, 0);)
    UNROLL for (int s = 0; s < SIGNALS; s++) IF_HEARD(s) {
        float luma = finish(pixel, guide, s, tracks[s], color[s]);
        SH_ONLY(vec4 light = unpack_light(lights[s]); store_light(s, pixel, vec4(light.xyz * luma, light.w));)
    }
}
