/* Reads   colour and deviation, guides.
   Writes  colour and deviation.
   Sparse steps of the wavelet filter, guided by the variance that the blur pooled: where the average is already certain, or the
   neighbour is certainly different, nothing is mixed. Not fed back: history stays sharp.
   Built twice: -DTO_OUT reads the packed intermediate and writes OUT, -DFROM_OUT the reverse.
   C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "../common/guide.glsl"
#include "../common/texel.glsl"
#include "reblur.glsl"

#ifdef TO_OUT
const bool CROSS = true;
layout(binding = 1) uniform usampler2D in_color;
layout(binding = 2) uniform usampler2D in_guide;
layout(binding = 3, rgba16f) uniform writeonly image2D out_color;
vec4 load_color(ivec2 pixel) { return unpack_texel(texelFetch(in_color, pixel, 0).xy); }
void store(ivec2 pixel, vec4 color) { imageStore(out_color, pixel, round_half(color)); }
#else
const bool CROSS = false;
layout(binding = 1) uniform sampler2D in_color;
layout(binding = 2) uniform usampler2D in_guide;
layout(binding = 3, rg32ui) uniform writeonly uimage2D out_color;
vec4 load_color(ivec2 pixel) { return texelFetch(in_color, pixel, 0); }
void store(ivec2 pixel, vec4 color) { imageStore(out_color, pixel, uvec4(pack_texel(color), 0u, 0u)); }
#endif
#include "atrous.glsl"

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel)) return;
    uint code = texelFetch(in_guide, pixel, 0).x;
    if (guide_is_sky(code)) return;
    store(pixel, atrous(make_center(pixel, code, 1.0), load_color(pixel)));
}
