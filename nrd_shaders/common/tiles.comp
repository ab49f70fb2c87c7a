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
layout(binding = 3, r32ui) uniform writeonly uimage2D out_list;
layout(std430, binding = 4) buffer groups_block { uint x, y, z, count; } groups;
layout(std430, binding = 5) buffer next_block { uint x, y, z, count; } next;   /* of the next frame: ends as none */

const uint LEAST_AGE = 3u;        /* this frame and both halves of ping-pong textures before it */

shared uint s_listed[2];          /* a bit for each tile of the group */
shared uint s_first;              /* place of the group's first tile in the list */

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

/* Claims places for the tiles of the group. Rows of the list are as long as those of the picture. */
void claim(uint count, uint columns)
{
    if (count == 0u) return;
    s_first = atomicAdd(groups.count, count);
    atomicMax(groups.y, (s_first + count + columns - 1u) / columns);
}

void main()
{
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy), tiles = (rect_size() + 7) / 8;
    uint i = gl_LocalInvocationIndex, bit = 1u << (i & 31u), columns = uint(tiles.x);
    if (i < 2u) s_listed[i] = 0u;
    barrier();
    bool listed = all(lessThan(tile, tiles)) && update_age(tile) < LEAST_AGE;
    if (listed) atomicOr(s_listed[i >> 5], bit);
    barrier();
    uint low = bitCount(s_listed[0]), before = bitCount(s_listed[i >> 5] & (bit - 1u)) + (i < 32u ? 0u : low);
    if (i == 0u) claim(low + bitCount(s_listed[1]), columns);
    if (tile == ivec2(0)) {
        groups.x = columns;
        groups.z = 1u;
        next.y = next.count = 0u;
    }
    barrier();
    uint place = s_first + before;
    if (listed) imageStore(out_list, ivec2(place % columns, place / columns), uvec4(1u << 31 | uint(tile.y) << 16 | uint(tile.x)));
}
