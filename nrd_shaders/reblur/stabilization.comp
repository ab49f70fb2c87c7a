/* Reads   colour and deviation, guides, lengths and reprojected stabilised luma, lighting change.
   Writes  the output, stabilised luma.
   Last sparse step of the wavelet filter, then the luma is pulled towards last frame's output as far as the difference can be noise:
   the filter knows its own deviation, so no neighbourhood is needed to tell. Does not enter the colour history.
   Self-stabilisation: D. Zhdan, GTC 2020; clamping history to what the new frame allows: B. Karis, "High Quality Temporal
   Supersampling", SIGGRAPH 2014. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/texel.glsl"
#include "reblur.glsl"

layout(binding = 1) uniform usampler2D in_color;
layout(binding = 2) uniform usampler2D in_guide;
layout(binding = 3) uniform sampler2D in_tile;
layout(binding = 4, r16f) uniform writeonly image2D out_stabilized;
layout(binding = 5, rgba16f) uniform writeonly image2D out_radiance_hit_dist;
vec4 load_color(ivec2 pixel) { return unpack_texel(texelFetch(in_color, pixel, 0).xy); }
const bool CROSS = false;
#include "atrous.glsl"

/* Frames added to the length of the stabilised luma: first frames are noisy, and what changes between them is seen as flicker. 0 to 8
   tried: 3 takes a quarter off the flicker for a tenth of error; more keeps the first frames' errors. */
const float HEAD_START = 3.0;

/* Short histories know their own deviation badly, most of all under rare bright samples: they may differ more. Without it the first
   dark guess wins, and the picture darkens by 1 to 2 %. */
const float EARLY_DOUBT = 8.0;

float stabilize(vec4 color, Aux aux, vec4 change)
{
    float frames = min(aux.frames + HEAD_START, g.max_stabilized_frames);
    if (aux.stabilized < 0.0) return color.x;
    float slack = g.stabilization_sigma_scale * color.w * (1.0 + EARLY_DOUBT / max(aux.frames, 1.0));
    float allowed = clamp(aux.stabilized * mix(1.0, change.y, change.x), color.x - slack, color.x + slack);
    return mix(color.x, allowed, frames / (1.0 + frames));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel)) return;
    uvec2 guide = texelFetch(in_guide, pixel, 0).xy;
    if (guide_is_sky(guide.x)) return;
    Aux aux = unpack_aux(guide.y);
    vec4 color = load_color(pixel);
    if (is_filtering()) color = atrous(make_center(pixel, guide.x, 1.0), color);
    vec4 change = has_flag(NRD_FLAG_ANTILAG) ? sample_tiles(in_tile, vec2(pixel) + 0.5, rect_size()) : vec4(0.0, 1.0, 0.0, 0.0);
    float luma = min(stabilize(color, aux, change), 65504.0);
    color.xyz *= luma / max(color.x, 1e-12);
    imageStore(out_stabilized, pixel, round_half(vec4(luma)));
    float w = has_flag(NRD_FLAG_RETURN_HISTORY) ? aux.frames : aux.hit_dist;
    imageStore(out_radiance_hit_dist, pixel, round_half(vec4(clamp(color.xyz, -65504.0, 65504.0), w)));
}
