/* The pixels of a group and one pixel around them, 10 x 10: every thread has its own, and 18 of each half of the group one of the ring, so that all go
   that way twice at most. Counting them through took 22 us longer on an H200 at 2560x1440. */
#ifndef RING_GLSL
#define RING_GLSL

const int RING_SIDE = 10;

/* From (0, 0) at the corner of the ring. */
ivec2 own_place() { return ivec2(gl_LocalInvocationID.xy) + 1; }

int ring_thread() { return int(gl_LocalInvocationIndex) & 31; }
bool has_ring_place() { return ring_thread() < 2 * RING_SIDE - 2; }
ivec2 ring_place()
{
    int i = ring_thread();
    ivec2 place = i < RING_SIDE ? ivec2(i, 0) : ivec2(0, i - RING_SIDE + 1);
    return gl_LocalInvocationIndex < 32u ? place : RING_SIDE - 1 - place;
}

#endif
