/* The taps of a dense 3x3 step, from the group's memory: each texel is fetched 1.6 times for 64 pixels instead of 9 times a pixel. On an H200 it
   takes 7 to 14 % off the first blur; steps with gaps gain nothing, as the group's surroundings grow with them.
   The includer binds in_guide, includes tiles.glsl, and defines load_color() and with SH load_light(); its taps are halves, and stay exact. */
#ifndef CELLS_GLSL
#define CELLS_GLSL

const int CELLS_SIDE = 10;         /* of a group with one pixel around it */
const int CELLS = SPEC_ITERATION == 0u ? CELLS_SIDE * CELLS_SIDE : 1;   /* other steps of the same module take no memory */

shared uvec2 s_guide[CELLS];
shared uvec2 s_color[SIGNALS][CELLS];
SH_ONLY(shared uvec2 s_light[SIGNALS][CELLS];)

/* Sky, or beyond the rectangle. No surface has that code. */
bool is_outside(uvec2 guide) { return (guide.x & 0xffffu) == GUIDE_SKY; }

/* From the cell of this thread's pixel. */
int cell_at(ivec2 offset) { return (int(gl_LocalInvocationID.y) + 1 + offset.y) * CELLS_SIDE + int(gl_LocalInvocationID.x) + 1 + offset.x; }

/* Beyond the rectangle lies sky. */
void load_cell(ivec2 place)
{
    ivec2 pixel = tile * 8 - 1 + place, inside = clamp(pixel, ivec2(0), rect_size() - 1);
    int cell = place.y * CELLS_SIDE + place.x;
    s_guide[cell] = in_rect(pixel) ? texelFetch(in_guide, inside, 0).xy : uvec2(GUIDE_SKY, 0u);
    UNROLL for (int s = 0; s < SIGNALS; s++) s_color[s][cell] = pack_halves(load_color(s, inside));
    SH_ONLY(UNROLL for (int s = 0; s < SIGNALS; s++) s_light[s][cell] = pack_halves(load_light(s, inside));)
}

/* All threads of a group enter: each loads its own pixel, 18 of each half a side and a half of those around. */
void load_cells()
{
    int i = int(gl_LocalInvocationIndex) & 31;
    ivec2 place = i < CELLS_SIDE ? ivec2(i, 0) : ivec2(0, i - CELLS_SIDE + 1);
    load_cell(ivec2(gl_LocalInvocationID.xy) + 1);
    if (i < 2 * CELLS_SIDE - 2) load_cell(gl_LocalInvocationIndex < 32u ? place : CELLS_SIDE - 1 - place);
    barrier();
}

vec4 cell_color(int signal, int cell) { return unpack_texel(s_color[signal][cell]); }
SH_ONLY(vec4 cell_light(int signal, int cell) { return unpack_texel(s_light[signal][cell]); })

#endif
