/* Reads   view z, for how many frames each tile of 8 x 8 pixels has been all sky. With GLOSSY also roughness: what is too rough to have a specular
           signal counts as sky.
   Writes  that age, the list of the other tiles, how many groups they take.
   Filters do nothing in the sky but mark it, in textures of this frame and of the next: what has been sky for LEAST_AGE frames is marked
   everywhere, and no pass needs to go there until something appears.
   First in the chain: all that follows runs on the list, through tiles.glsl. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"

layout(binding = 1) uniform sampler2D in_view_z;
layout(binding = 2, r8) uniform image2D tile_age;
#define LIST 3
#include "list.glsl"
#ifdef GLOSSY
layout(binding = 6) uniform sampler2D in_normal_roughness;   /* without a limit another image */
#endif

const uint LEAST_AGE = 3u;        /* this frame and both halves of ping-pong textures before it */

bool is_surface(float view_z) { return !is_sky(view_z * g.view_z_scale); }

/* View z of 2 x 2 pixels from `quad` on, as textureGather orders them; infinite where a surface does not count. */
vec4 gather_view_z(ivec2 quad)
{
    vec2 uv = vec2(quad + 1) * g.texel_uv.xy;
    vec4 z = textureGather(in_view_z, uv, 0);
#ifdef GLOSSY
    if (!HAS_ROUGHNESS_LIMIT) return z;
    vec4 roughness = SPEC_NORMAL_FORMAT == NRD_NORMAL_FORMAT_RGB10A2_UNORM ? textureGather(in_normal_roughness, uv, 2) : textureGather(in_normal_roughness, uv, 3);
    UNROLL for (int i = 0; i < 4; i++)
        if (is_too_rough(nrd_decode_roughness(roughness[i], SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT))) z[i] = uintBitsToFloat(0x7f800000u);
#endif
    return z;
}

bool has_surface(ivec2 first)
{
    ivec2 last = rect_size() - 1 + rect_origin();
    for (int y = first.y; y < min(first.y + 8, last.y + 1); y += 2) {
        bvec4 found = bvec4(false);
        UNROLL for (int x = 0; x < 8; x += 2) {
            ivec2 quad = ivec2(min(first.x + x, last.x), y);
            vec4 z = gather_view_z(quad);
            found.w = found.w || is_surface(z.w);
            found.z = found.z || (quad.x < last.x && is_surface(z.z));
            found.x = found.x || (quad.y < last.y && is_surface(z.x));
            found.y = found.y || (all(lessThan(quad, last)) && is_surface(z.y));
        }
        if (any(found)) return true;
    }
    return false;
}

/* Of most tiles this tells. */
bool starts_with_surface(ivec2 first)
{
#ifdef GLOSSY
    if (HAS_ROUGHNESS_LIMIT) return is_surface(gather_view_z(first).w);
#endif
    return is_surface(texelFetch(in_view_z, first, 0).x);
}

/* A tile that the rectangle has cut is another one when the rectangle changes. */
bool was_whole(ivec2 tile)
{
    ivec2 rect_prev = ivec2(g.rect_width_prev, g.rect_height_prev);
    return !is_reset() && (is_same_rect() || all(lessThanEqual(tile * 8 + 8, rect_prev)));
}

/* Frames for which the tile has been sky, this one among them; no more than LEAST_AGE. */
uint update_age(ivec2 tile)
{
    ivec2 first = tile * 8 + rect_origin();
    uint before = uint(imageLoad(tile_age, tile).x * 255.0 + 0.5), age = 0u;
    if (!starts_with_surface(first) && !has_surface(first)) age = was_whole(tile) ? min(before + 1u, LEAST_AGE) : 1u;
    if (age != before) imageStore(tile_age, tile, vec4(float(age) / 255.0));
    return age;
}

void main()
{
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    list_tile(tile, all(lessThan(tile, (rect_size() + 7) / 8)) && update_age(tile) < LEAST_AGE, 0u);
}
