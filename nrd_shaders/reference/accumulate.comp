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
    vec4 history = texelFetch(in_history, pixel, 0);   /* NaN: no usable sample yet */
    bool known = g.history_frames > 0u && nrd_is_finite(history.x);
    vec4 mean = known ? history : vec4(0.0);
    float share = 1.0 / (1.0 + float(g.history_frames));
    if (usable) mean = known ? history * (1.0 - share) + value * share : value;   /* mix() may overflow in the difference */
    imageStore(out_history, pixel, usable || known ? mean : vec4(uintBitsToFloat(0x7fc00000u)));
    if (pixel_uv(pixel).x >= g.split_screen) imageStore(out_signal, pixel, mean);
    else imageStore(out_signal, pixel, usable ? value : vec4(0.0));
}
