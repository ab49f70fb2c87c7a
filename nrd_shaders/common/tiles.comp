/* Reads   view z, for how many frames each tile of 8 x 8 pixels has been all sky.
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

const uint LEAST_AGE = 3u;        /* this frame and both halves of ping-pong textures before it */

bool is_surface(float view_z) { return !is_sky(view_z * g.view_z_scale); }

/* Of a tile whose first pixel is sky. */
bool has_surface(ivec2 first)
{
    ivec2 last = rect_size() - 1 + rect_origin();
    vec2 scale = 1.0 / vec2(textureSize(in_view_z, 0));
    for (int y = first.y; y < min(first.y + 8, last.y + 1); y += 2) {
        bvec4 found = bvec4(false);
        UNROLL for (int x = 0; x < 8; x += 2) {
            ivec2 quad = ivec2(min(first.x + x, last.x), y);
            vec4 z = textureGather(in_view_z, vec2(quad + 1) * scale, 0);
            found.w = found.w || is_surface(z.w);
            found.z = found.z || (quad.x < last.x && is_surface(z.z));
            found.x = found.x || (quad.y < last.y && is_surface(z.x));
            found.y = found.y || (all(lessThan(quad, last)) && is_surface(z.y));
        }
        if (any(found)) return true;
    }
    return false;
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
    float view_z = texelFetch(in_view_z, first, 0).x;
    uint before = uint(imageLoad(tile_age, tile).x * 255.0 + 0.5), age = 0u;
    if (!is_surface(view_z) && !has_surface(first)) age = was_whole(tile) ? min(before + 1u, LEAST_AGE) : 1u;
    if (age != before) imageStore(tile_age, tile, vec4(float(age) / 255.0));
    return age;
}

void main()
{
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    list_tile(tile, all(lessThan(tile, (rect_size() + 7) / 8)) && update_age(tile) < LEAST_AGE, 0u);
}
