/* Reads   view depth, penumbrae, colours.
   Writes  the output left of the split.
   Shows the rays beside the denoised picture. Last, over the finished output. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/texel.glsl"

layout(binding = 1) uniform sampler2D in_view_z;
layout(binding = 2) uniform sampler2D in_penumbra;
#ifdef TRANSLUCENCY
layout(binding = 3, rgba8) uniform writeonly image2D out_shadow;
layout(binding = 4) uniform sampler2D in_translucency;
#else
layout(binding = 3, r8) uniform writeonly image2D out_shadow;
#endif

/* What arrives of a light that is not reached. */
vec3 load_blocked(ivec2 pixel)
{
#ifdef TRANSLUCENCY
    vec3 color = texelFetch(in_translucency, pixel, 0).xyz;
    return nrd_is_finite(color) ? clamp(color, 0.0, 1.0) : vec3(0.0);
#else
    return vec3(0.0);
#endif
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!in_rect(pixel) || pixel_uv(pixel).x > g.split_screen) return;
    if (is_sky(texelFetch(in_view_z, pixel + rect_origin(), 0).x * g.view_z_scale)) return;
    float penumbra = texelFetch(in_penumbra, pixel, 0).x;
    vec3 v = penumbra >= NRD_PENUMBRA_LIT ? vec3(1.0) : penumbra > 0.0 ? load_blocked(pixel) : vec3(0.0);
    imageStore(out_shadow, pixel, round_byte(vec4(sqrt(v), 1.0)));
}
