/* The taps of a dense 3x3 step, from the group's memory: each texel is fetched 1.6 times for 64 pixels instead of 9 times a pixel. On an H200 it
   takes 7 to 14 % off the first blur; steps with gaps gain nothing, as the group's surroundings grow with them.
   The includer binds in_guide, includes tiles.glsl, and defines load_color() and with SH load_light(); its taps are halves, and stay exact. */
#ifndef CELLS_GLSL
#define CELLS_GLSL

#include "../common/ring.glsl"

const int CELLS = SPEC_ITERATION == 0u ? RING_SIDE * RING_SIDE : 1;   /* other steps of the same module take no memory */

shared uvec2 s_guide[CELLS];
shared uvec2 s_color[SIGNALS][CELLS];
SH_ONLY(shared uvec2 s_light[SIGNALS][CELLS];)

/* Sky, or beyond the rectangle. No surface has that code. */
bool is_outside(uvec2 guide) { return (guide.x & 0xffffu) == GUIDE_SKY; }

/* From the cell of this thread's pixel. */
int cell_at(ivec2 offset) { return (own_place().y + offset.y) * RING_SIDE + own_place().x + offset.x; }

/* Beyond the rectangle lies sky. */
void load_cell(ivec2 place)
{
    ivec2 pixel = tile * 8 - 1 + place, inside = clamp(pixel, ivec2(0), rect_size() - 1);
    int cell = place.y * RING_SIDE + place.x;
    s_guide[cell] = in_rect(pixel) ? texelFetch(in_guide, inside, 0).xy : uvec2(GUIDE_SKY, 0u);
    UNROLL for (int s = 0; s < SIGNALS; s++) s_color[s][cell] = pack_halves(load_color(s, inside));
    SH_ONLY(UNROLL for (int s = 0; s < SIGNALS; s++) s_light[s][cell] = pack_halves(load_light(s, inside));)
}

/* All threads of a group enter. */
void load_cells()
{
    load_cell(own_place());
    if (has_ring_place()) load_cell(ring_place());
    barrier();
}

vec4 cell_color(int signal, int cell) { return unpack_texel(s_color[signal][cell]); }
SH_ONLY(vec4 cell_light(int signal, int cell) { return unpack_texel(s_light[signal][cell]); })

#endif
