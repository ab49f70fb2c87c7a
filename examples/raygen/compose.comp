// Composition: the denoised and, for comparison, the noisy picture. Linear, not tone-mapped.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "nrd.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D denoised_diffuse;
layout(set = 0, binding = 1) uniform sampler2D noisy_diffuse;
layout(set = 0, binding = 2) uniform sampler2D in_factor;
layout(set = 0, binding = 3) uniform sampler2D in_emission;
layout(set = 0, binding = 4, rgba16f) writeonly uniform image2D out_color;
layout(set = 0, binding = 5, rgba16f) writeonly uniform image2D out_noisy;

vec4 compose(vec4 texel, ivec2 pixel)
{
    vec3 factor = texelFetch(in_factor, pixel, 0).rgb;
    vec3 diffuse = factor == vec3(0.0) ? vec3(0.0) : nrd_unpack_radiance_hit_dist(texel).rgb; // sky: not denoised, not written
    return vec4(nrd_modulate(diffuse, factor) + texelFetch(in_emission, pixel, 0).rgb, 1.0);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(out_color))))
        return;
    imageStore(out_color, pixel, compose(texelFetch(denoised_diffuse, pixel, 0), pixel));
    imageStore(out_noisy, pixel, compose(texelFetch(noisy_diffuse, pixel, 0), pixel));
}
