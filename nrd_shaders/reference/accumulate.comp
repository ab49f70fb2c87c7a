/* Reads   the signal, the mean so far.
   Writes  the mean so far, the output.
   Plain mean without reprojection: what the input converges to under a still camera; the yardstick of every other denoiser. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"

layout(binding = 1) uniform sampler2D in_signal;
layout(binding = 2) uniform sampler2D in_history;
layout(binding = 3, rgba32f) uniform writeonly image2D out_history;
layout(binding = 4, rgba32f) uniform writeonly image2D out_signal;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel)) return;
    vec4 value = texelFetch(in_signal, pixel, 0);
    bool usable = nrd_is_finite(value.xyz) && nrd_is_finite(value.w);
    vec4 mean = usable ? value : vec4(0.0);
    if ((g.history_frames | opaque_zero()) > 0u) {   /* assigned, not blended, at first: 0 * NaN is NaN */
        vec4 history = texelFetch(in_history, pixel, 0);
        mean = usable ? mix(history, value, 1.0 / (1.0 + float(g.history_frames))) : history;
    }
    imageStore(out_history, pixel, mean);
    if (pixel_uv(pixel).x >= g.split_screen) imageStore(out_signal, pixel, mean);
    else imageStore(out_signal, pixel, value);
}
