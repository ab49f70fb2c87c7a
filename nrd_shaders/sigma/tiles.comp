/* Reads   the kinds of rays in every tile, last frame's tiles.
   Writes  tiles: which have something to do; their list, how many groups they take.
   A thread a tile. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "sigma.glsl"

layout(binding = 1) uniform usampler2D in_kinds;
layout(binding = 2) uniform sampler2D prev_tile;
layout(binding = 3, r8) uniform writeonly image2D out_tile;
#define LIST 4
#include "../common/list.glsl"

/* Of a neighbour only the quarters that touch the tile: within 4 pixels of it. */
uint kinds_around(ivec2 tile, ivec2 tiles)
{
    uint kinds = 0u;
    UNROLL for (int y = -1; y <= 1; y++)
        UNROLL for (int x = -1; x <= 1; x++) {
            ivec2 at = tile + ivec2(x, y);
            uint touching = (x < 0 ? 10u : x > 0 ? 5u : 15u) & (y < 0 ? 12u : y > 0 ? 3u : 15u);
            bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, tiles));
            kinds |= inside ? texelFetch(in_kinds, clamp(at, ivec2(0), tiles - 1), 0).x & touching * (KIND_LIT | KIND_BLOCKED | KIND_COLORED) : 0u;
        }
    return kinds;
}

uint find_marks(ivec2 tile, ivec2 tiles)
{
    uint kinds = kinds_around(tile, tiles);
    bool lit = (kinds & 15u * KIND_LIT) != 0u, blocked = (kinds & 15u * KIND_BLOCKED) != 0u, colored = (kinds & 15u * KIND_COLORED) != 0u;
    uint before = unpack_tile(texelFetch(prev_tile, min(tile, textureSize(prev_tile, 0) - 1), 0).x);   /* smaller in the first frame of a larger size */
    uint now = ((lit && blocked) || colored ? TILE_ACTIVE : 0u) | (lit ? TILE_LIT : 0u);
    bool whole = !is_reset() && is_same_rect();
    if (!whole || ((before ^ now) & (TILE_ACTIVE | TILE_LIT)) != 0u) now |= TILE_STALE;
    return now;
}

void main()
{
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy), tiles = (rect_size() + 7) / 8;
    bool inside = all(lessThan(tile, tiles));
    uint marks = inside ? find_marks(tile, tiles) : 0u;
    if (inside) imageStore(out_tile, tile, vec4(float(marks) / 255.0));
    list_tile(tile, (marks & (TILE_ACTIVE | TILE_STALE)) != 0u, marks);
}
