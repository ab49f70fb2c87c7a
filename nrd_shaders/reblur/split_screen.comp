/* Reads   view depth, the noisy signal.
   Writes  the output left of the split.
   Shows the noisy input beside the denoised picture. Last, over the finished output. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/checkerboard.glsl"

layout(binding = 1) uniform sampler2D in_view_z;
layout(binding = 2) uniform sampler2D in_radiance_hit_dist;
#ifndef OUT_FORMAT
#define OUT_FORMAT rgba16f
#endif
layout(binding = 3, OUT_FORMAT) uniform writeonly image2D out_radiance_hit_dist;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel) || pixel_uv(pixel).x > g.split_screen) return;
    if (is_sky(texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale)) return;
    vec4 noisy = texelFetch(in_radiance_hit_dist, noisy_texel(pixel, int(push.iteration)), 0);
    bool usable = nrd_is_finite(noisy.xyz) && nrd_is_finite(noisy.w);
    imageStore(out_radiance_hit_dist, pixel, usable ? noisy : vec4(0.0));
}
