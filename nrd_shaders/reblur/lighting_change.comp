/* Reads   tile statistics of this frame, the tile's state.
   Writes  the tile's state: x amount of change [0,1], y factor for history, z smoothed luma change, w how certain it is that something
           moves near by [0,1].
   Decides per tile whether light has changed: the mean difference of new samples to history, over about 70 x 70 px and 3 frames,
   against its standard error; less evidence will do in a frame in which tiles all over the picture change together (a lamp goes off).
   On linear luma of many pixels, because single pixels, roots and logarithms of noise fire falsely (Jensen).
   What moves changes light in its surroundings, over fewer pixels and sooner than light can tell: there the mean hit distances change, over
   about 24 x 24 px in one frame. By how much light changes they do not say, so that history only becomes short.
   After accumulation, before the blur that rescales what has changed. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/texel.glsl"
#include "tile_change.glsl"

layout(binding = 1) uniform usampler2D in_tile_raw;
layout(binding = 2) uniform sampler2D prev_tile;
layout(binding = 3, rgba16f) uniform writeonly image2D out_tile;

const int REACH = 4;              /* tiles; less misses weak changes, more smears local ones */
const int SIDE = 8, FRAMED = SIDE + 2 * REACH;   /* tiles of a work group, and with those around it */
const int THREADS = SIDE * SIDE;  /* numbers of rounds are constants: what a thread fetches in each is then on its way at once */
const int SURVEY = 16;            /* SURVEY x SURVEY tiles all over the picture tell whether there is a change at all */
const float MEMORY = 0.5;         /* weight of the new frame; 0.33 lags a frame more, 1 sees only sudden changes */
const float FULL_CHANGE = 0.06;   /* change beyond the noise, relative to the luma, that is applied in full */
const float MAX_FACTOR = 4.0;
const float SUDDEN = 1.5;         /* a change seen in one frame alone must be this much clearer .. */
const float EXPECTED = 0.4;       /* .. and this much less clear when the whole picture changes in the same frame */
const float WEIGHT = 64.0 * (REACH + 1.0) * (REACH + 1.0) * (REACH + 1.0) * (REACH + 1.0);   /* of all pixels around a tile */

shared vec4 s_tiles[FRAMED * FRAMED];   /* sums over a tile: luma change, luma, change of hit distances in standard errors, variance of the first */
shared vec4 s_rows[SIDE * FRAMED];       /* of those, weighted sums along x */
shared vec4 s_survey[SIDE * SIDE];

vec4 load_tile(ivec2 tile)
{
    TileChange t = unpack_change(texelFetch(in_tile_raw, tile, 0).x);
    return vec4(64.0 * t.luma_change, 64.0 * t.luma, t.farther, 64.0 * t.deviation * t.deviation);
}

/* How certain it is that a change is none of noise, and worth acting on: [0, 1]. */
float certainty(float change, float error, float luma)
{
    return clamp((abs(change) - g.antilag_sigma_scale * error) / (FULL_CHANGE * max(luma, abs(change)) + 1e-12), 0.0, 1.0);
}

void load_surroundings(ivec2 tiles)
{
    ivec2 first = ivec2(gl_WorkGroupID.xy) * SIDE - REACH;
    UNROLL for (int round = 0; round < FRAMED * FRAMED / THREADS; round++) {
        int i = round * THREADS + int(gl_LocalInvocationIndex);
        ivec2 at = first + ivec2(i % FRAMED, i / FRAMED);
        vec4 sums = load_tile(clamp(at, ivec2(0), tiles - 1));
        s_tiles[i] = all(lessThan(uvec2(at), uvec2(tiles))) ? sums : vec4(0.0);
    }
}

/* This thread's part of the survey. */
vec4 load_survey(ivec2 tiles)
{
    vec4 sum = vec4(0.0);
    vec2 count = vec2(min(tiles, ivec2(SURVEY))), spacing = vec2(tiles) / count;   /* a tile that counted twice would look certain */
    UNROLL for (int round = 0; round < SURVEY * SURVEY / THREADS; round++) {
        int i = round * THREADS + int(gl_LocalInvocationIndex);
        vec2 place = vec2(i % SURVEY, i / SURVEY) + 0.5;
        vec4 sums = load_tile(min(ivec2(place * spacing), tiles - 1));
        if (all(lessThan(place, count))) sum += sums;
    }
    return sum;
}

vec4 tent(int distance)
{
    float w = float(REACH + 1 - abs(distance));
    return vec4(w, w, w, w * w);
}

void sum_rows()
{
    UNROLL for (int round = 0; round < SIDE * FRAMED / THREADS; round++) {
        int i = round * THREADS + int(gl_LocalInvocationIndex), center = (i / SIDE) * FRAMED + i % SIDE + REACH;
        vec4 sum = vec4(0.0);
        UNROLL for (int x = -REACH; x <= REACH; x++) sum += tent(x) * s_tiles[center + x];
        s_rows[i] = sum;
    }
}

/* After it, the first of s_survey is the sum of all, and s_rows is there. */
void sum_survey()
{
    uint own = gl_LocalInvocationIndex;
    for (uint count = SIDE * SIDE / 2; count > 0u; count /= 2u) {
        if (own < count) s_survey[own] += s_survey[own + count];
        barrier();
    }
}

float survey()
{
    vec4 sum = s_survey[0];
    return certainty(sum.x, sqrt(sum.w), sum.y);
}

vec4 sum_around()
{
    vec4 sum = vec4(0.0);
    UNROLL for (int y = -REACH; y <= REACH; y++) sum += tent(y) * s_rows[int(gl_LocalInvocationIndex) + SIDE * (REACH + y)];
    return sum;
}

float find_motion()
{
    float sum = 0.0;
    int center = (int(gl_LocalInvocationID.y) + REACH) * FRAMED + int(gl_LocalInvocationID.x) + REACH;
    UNROLL for (int i = 0; i < 9; i++) {
        ivec2 at = ivec2(i % 3, i / 3) - 1;
        sum += float((2 - abs(at.x)) * (2 - abs(at.y))) * s_tiles[center + at.y * FRAMED + at.x].z;
    }
    float errors = abs(sum) / 6.0;   /* root of the weights' squares */
    return smoothstep(1.0, 1.5, errors / g.antilag_sigma_scale) * g.antilag_sensitivity;
}

void main()
{
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy), tiles = (rect_size() + 7) / 8;
    load_surroundings(tiles);
    s_survey[gl_LocalInvocationIndex] = load_survey(tiles);
    barrier();
    sum_rows();
    sum_survey();
    if (any(greaterThanEqual(tile, tiles))) return;
    vec4 sum = sum_around();
    /* What changed where nothing is any more is forgotten: this pass does not run while all is sky. */
    bool remembers = sum.y + sum.w > 0.0 && has_flag(NRD_FLAG_TILE_HISTORY) && is_same_rect();
    float before = remembers ? texelFetch(prev_tile, tile, 0).z : 0.0;
    float luma = sum.y / WEIGHT, now = sum.x / WEIGHT, error = sqrt(sum.w) / WEIGHT;
    float smoothed = mix(before, now, MEMORY), smooth_error = error * sqrt(MEMORY / (2.0 - MEMORY));
    float sudden = certainty(now, error * mix(SUDDEN, EXPECTED, survey()), luma), slow = certainty(smoothed, smooth_error, luma);
    /* What has just begun is in the mean of the frames by half: taken from it, the rest of a step would stay below the noise for frames. */
    float step = certainty(now - before, error * sqrt(2.0 / (2.0 - MEMORY)), luma);
    float change = sudden > slow ? now : mix(smoothed, now, step), certain = max(sudden, slow) * g.antilag_sensitivity;
    float factor = luma > 0.0 ? clamp((luma + change) / luma, 1.0 / MAX_FACTOR, MAX_FACTOR) : 1.0;
    imageStore(out_tile, tile, nrd_round_to_half(vec4(certain, factor, smoothed * (1.0 - certain), find_motion())));
}
