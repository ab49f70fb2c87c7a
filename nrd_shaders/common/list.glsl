/* What a pass has that lists tiles for those behind it, which run on these alone, through tiles.glsl: a thread a tile. It defines LIST, the first
   of three bindings, and includes this. */
#ifndef LIST_GLSL
#define LIST_GLSL

layout(binding = LIST, r32ui) uniform writeonly uimage2D out_list;
layout(std430, binding = LIST + 1) buffer groups_block { uint x, y, z, count, all_x, all_y, all_z; } groups;   /* all_: a thread for every tile */
layout(std430, binding = LIST + 2) buffer next_block { uint x, y, z, count, all_x, all_y, all_z; } next;       /* of the next frame: ends as none */

shared uint s_listed[2];          /* a bit for each tile of the group */
shared uint s_first;              /* place of the group's first tile in the list */

/* Claims places for the tiles of the group. Rows of the list are as long as those of the picture; whoever begins some says so: the fewer do, the
   less they wait for each other. */
void claim(uint count, uint columns)
{
    if (count == 0u) return;
    uint first = atomicAdd(groups.count, count), rows = (first + count + columns - 1u) / columns;
    if (rows * columns >= first + columns) atomicMax(groups.y, rows);
    if (first == 0u) groups.all_y = (g.rect_height + 63u) >> 6;
    s_first = first;
}

/* All threads of a group enter. marks: 0 to 7, for the passes behind. */
void list_tile(ivec2 tile, bool listed, uint marks)
{
    uint i = gl_LocalInvocationIndex, bit = 1u << (i & 31u), columns = (g.rect_width + 7u) >> 3;
    if (i < 2u) s_listed[i] = 0u;
    barrier();
    if (listed) atomicOr(s_listed[i >> 5], bit);
    barrier();
    uint low = bitCount(s_listed[0]), before = bitCount(s_listed[i >> 5] & (bit - 1u)) + (i < 32u ? 0u : low);
    if (i == 0u) claim(low + bitCount(s_listed[1]), columns);
    if (tile == ivec2(0)) {
        groups.x = columns;
        groups.all_x = (columns + 7u) >> 3;
        groups.z = groups.all_z = 1u;
        next.y = next.all_y = next.count = 0u;
    }
    barrier();
    uint place = s_first + before;
    if (listed) imageStore(out_list, ivec2(place % columns, place / columns), uvec4(1u << 31 | marks << 28 | uint(tile.y) << 16 | uint(tile.x)));
}

#endif
