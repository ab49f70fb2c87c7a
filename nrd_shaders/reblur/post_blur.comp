/* Reads   colour and deviation, guides.
   Writes  colour and deviation.
   Sparse steps of the wavelet filter, guided by the variance that the blur pooled: where the average is already certain, or the
   neighbour is certainly different, nothing is mixed. Not fed back: history stays sharp.
   Built twice for each choice of signals: -DTO_OUT reads the packed intermediate and writes OUT, -DFROM_OUT the reverse. -DSH: with directions.
   C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017. */
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
#define SECOND (FIRST + 2 * HAS_DIFFUSE)
#ifdef TO_OUT
const bool CROSS = true;
#ifdef DIFFUSE
layout(binding = FIRST) uniform usampler2D in_diff;
layout(binding = FIRST + 1, rgba16f) uniform writeonly image2D out_diff;
#endif
#ifdef SPECULAR
layout(binding = SECOND) uniform usampler2D in_spec;
layout(binding = SECOND + 1, rgba16f) uniform writeonly image2D out_spec;
#endif
vec4 load_color(int s, ivec2 p) { OF_SIGNAL(s, return unpack_texel(texelFetch(in_diff, p, 0).xy), return unpack_texel(texelFetch(in_spec, p, 0).xy)) }
void store(int s, ivec2 p, vec4 color) { vec4 v = round_half(color); OF_SIGNAL(s, imageStore(out_diff, p, v), imageStore(out_spec, p, v)) }
#else
const bool CROSS = false;
#ifdef DIFFUSE
layout(binding = FIRST) uniform sampler2D in_diff;
layout(binding = FIRST + 1, rg32ui) uniform writeonly uimage2D out_diff;
#endif
#ifdef SPECULAR
layout(binding = SECOND) uniform sampler2D in_spec;
layout(binding = SECOND + 1, rg32ui) uniform writeonly uimage2D out_spec;
#endif
vec4 load_color(int s, ivec2 p) { OF_SIGNAL(s, return texelFetch(in_diff, p, 0), return texelFetch(in_spec, p, 0)) }
void store(int s, ivec2 p, vec4 color) { uvec4 v = uvec4(pack_texel(color), 0u, 0u); OF_SIGNAL(s, imageStore(out_diff, p, v), imageStore(out_spec, p, v)) }
#endif
#ifdef FROM_OUT
#define SH_FROM_OUT
#endif
#define SH_FIRST (FIRST + 2 * HAS_DIFFUSE + 2 * HAS_SPECULAR)
#include "light_textures.glsl"
#include "atrous.glsl"

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel)) return;
    uvec2 guide = texelFetch(in_guide, pixel, 0).xy;
    if (guide_is_sky(guide.x)) return;
    vec4 color[SIGNALS];
    UNROLL for (int s = 0; s < SIGNALS; s++) color[s] = load_color(s, pixel);
    SH_ONLY(load_lights(pixel, lights);)
    atrous(make_center(pixel, guide, 1.0, TRACKED(pixel)), color);
    UNROLL for (int s = 0; s < SIGNALS; s++) store(s, pixel, color[s]);
    SH_ONLY(store_lights(pixel);)
}
