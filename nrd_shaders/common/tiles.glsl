/* What a pass has that runs on the tiles that list.glsl has listed: it defines TILES, the binding of the list, includes this, and defines process(),
   which all threads of a group enter.
   Groups come in rows as long as those of tiles: the ones behind the last listed tile find what the list happens to hold. So a pass writes the
   same however often it goes to a tile, and reads nothing that it writes. EXACT_TILES, if defined: the list was cleared before, and no group goes
   to a tile that is not in it. */
#ifndef TILES_GLSL
#define TILES_GLSL

layout(binding = TILES) uniform usampler2D in_tiles;
#ifndef EXACT_TILES
layout(std140, binding = TILES + 1) uniform groups_block { uint x, y; } groups;   /* as list.glsl left them */
#endif

ivec2 tile;        /* of 8 x 8 pixels */
uint tile_marks;   /* as listed; without EXACT_TILES: none */

/* pixel: of this thread, maybe outside the rectangle. */
void process(ivec2 pixel);

ivec2 tile_pixel() { return tile * 8 + ivec2(gl_LocalInvocationID.xy); }

#ifndef EXACT_TILES
/* Where as many rows of groups are listed as there are of tiles, each group has its own. Looking for that in a uniform buffer takes nothing that could
   be measured; in gl_NumWorkGroups as long as a fetch, which makes filter steps wait 3 to 6 %. */
bool has_own_tile() { return groups.y + opaque_zero() >= (g.rect_height + 7u) >> 3; }
#endif

/* Of the group; false: nothing was ever listed there. */
bool find_tile()
{
    tile = ivec2(gl_WorkGroupID.xy);
#ifndef EXACT_TILES
    if (is_absent(NRD_ABSENT_SKY) || has_own_tile()) return true;
#endif
    uint entry = texelFetch(in_tiles, tile, 0).x;
    tile = ivec2(entry & 0xffffu, (entry >> 16) & 0xfffu);
    tile_marks = (entry >> 28) & 7u;
    return entry != 0u;
}

void main()
{
    if (find_tile()) process(tile_pixel());
}

#endif
