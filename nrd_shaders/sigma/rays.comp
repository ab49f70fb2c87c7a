/* Reads   view depth, penumbrae, colours.
   Writes  every ray as it is: as a mean without history, and to the output; which kinds of rays there are in a tile; an empty list of tiles.
   What is no penumbra is finished after this pass. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/geometry.glsl"
#include "sigma.glsl"

layout(binding = 1) uniform sampler2D in_view_z;
layout(binding = 2) uniform sampler2D in_penumbra;
layout(binding = 4, r16ui) uniform writeonly uimage2D out_kinds;
layout(binding = 6, r32ui) uniform writeonly uimage2D out_list;
#ifdef TRANSLUCENCY
layout(binding = 3, rg32ui) uniform writeonly uimage2D out_mean;
layout(binding = 5, rgba8) uniform writeonly image2D out_shadow;
layout(binding = 7) uniform sampler2D in_translucency;
#else
layout(binding = 3, r32ui) uniform writeonly uimage2D out_mean;
layout(binding = 5, r8) uniform writeonly image2D out_shadow;
#endif
#include "rays.glsl"

shared uint s_kinds[4];   /* of the group's tiles */

/* Returns its kind. */
uint pass_on(ivec2 pixel, float z, float width)
{
    uint kind = kind_of(width);
    Visibility v = visibility_of(width);
#ifdef TRANSLUCENCY
    uint color = kind == KIND_BLOCKED ? load_color(pixel) : 0u;
    if (color != 0u) v = unpackUnorm4x8(color).xyz, kind |= KIND_COLORED;
#endif
    uint depth = width > 0.0 ? pack_depth(z) : DEPTH_NONE;   /* what faces away is no neighbour of what does not */
    imageStore(out_mean, pixel, uvec4(pack_mean(depth, v, 0.5, 0u, width, 0.0), 0u, 0u));
    if (width != NOTHING) imageStore(out_shadow, pixel, shadow_texel(v));
    return kind;
}

/* A group has 2 x 2 tiles, a thread one pixel of each: so rows of pixels are written at a time. */
void main()
{
    uint i = gl_LocalInvocationIndex, quarter = (gl_LocalInvocationID.x >> 2) + 2u * (gl_LocalInvocationID.y >> 2);
    ivec2 tile = 2 * ivec2(gl_WorkGroupID.xy), pixel[4];
    float z[4], penumbra[4];
    UNROLL for (int k = 0; k < 4; k++) {
        pixel[k] = 8 * (tile + ivec2(k & 1, k >> 1)) + ivec2(gl_LocalInvocationID.xy);
        z[k] = texelFetch(in_view_z, pixel[k] + rect_origin(), 0).x * g.view_z_scale;
        penumbra[k] = texelFetch(in_penumbra, pixel[k], 0).x;
    }
    if (i < 4u) s_kinds[i] = 0u;
    barrier();
    UNROLL for (int k = 0; k < 4; k++) {
        if (!in_rect(pixel[k])) continue;
        uint kinds = pass_on(pixel[k], abs(z[k]), width_of(penumbra[k], z[k]));
        if (kinds != 0u) atomicOr(s_kinds[k], kinds << quarter);
    }
    barrier();
    tile += ivec2(i & 1u, i >> 1);
    if (i >= 4u || !in_rect(8 * tile)) return;
    imageStore(out_kinds, tile, uvec4(s_kinds[i]));
    imageStore(out_list, tile, uvec4(0u));
}
