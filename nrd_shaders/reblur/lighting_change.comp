/* Reads   tile statistics of this frame, the tile's state.
   Writes  the tile's state: x amount of change [0,1], y factor for history, z smoothed luma change.
   Decides per tile whether light has changed: the mean difference of new samples to history, over about 70 x 70 px and 3 frames,
   against its standard error. On linear luma of many pixels, because single pixels, roots and logarithms of noise fire falsely (Jensen).
   After accumulation, before the blur that rescales what has changed. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "../common/pass.glsl"
#include "../common/texel.glsl"

layout(binding = 1) uniform sampler2D in_tile_raw;
layout(binding = 2) uniform sampler2D prev_tile;
layout(binding = 3, rgba16f) uniform writeonly image2D out_tile;

const int REACH = 4;              /* tiles; less misses weak changes, more smears local ones */
const float MEMORY = 0.5;         /* weight of the new frame; 0.33 lags a frame more, 1 sees only sudden changes */
const float FULL_CHANGE = 0.06;   /* change beyond the noise, relative to the luma, that is applied in full */
const float MAX_FACTOR = 4.0;

const float SUDDEN = 1.5;         /* a change seen in one frame alone must be this much clearer */

/* How certain it is that a change is none of noise, and worth acting on: [0, 1]. */
float certainty(float change, float error, float luma)
{
    return clamp((abs(change) - g.antilag_sigma_scale * error) / (FULL_CHANGE * max(luma, abs(change)) + 1e-12), 0.0, 1.0);
}

void main()
{
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy), tiles = (rect_size() + 7) / 8;
    if (any(greaterThanEqual(tile, tiles))) return;
    vec3 sum = vec3(0.0);   /* luma change, luma, weight */
    float variance = 0.0;
    for (int y = -REACH; y <= REACH; y++)
        for (int x = -REACH; x <= REACH; x++) {
            ivec2 at = tile + ivec2(x, y);
            if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, tiles))) continue;
            vec4 raw = texelFetch(in_tile_raw, at, 0);
            float w = float((REACH + 1 - abs(x)) * (REACH + 1 - abs(y)));
            sum += w * raw.w * vec3(raw.x, raw.z, 1.0);
            variance += w * w * raw.w * raw.y * raw.y;
        }
    vec4 state = !is_reset() ? texelFetch(prev_tile, tile, 0) : vec4(0.0);
    if (sum.z < 1.0) {
        imageStore(out_tile, tile, vec4(0.0, 1.0, 0.0, 0.0));
        return;
    }
    float luma = sum.y / sum.z, now = sum.x / sum.z, error = sqrt(variance) / sum.z;
    float smooth_change = mix(state.z, now, MEMORY), smooth_error = error * sqrt(MEMORY / (2.0 - MEMORY));
    float sudden = certainty(now, SUDDEN * error, luma), certain = certainty(smooth_change, smooth_error, luma);
    float change = sudden > certain ? now : smooth_change;
    certain = max(sudden, certain) * g.antilag_sensitivity;
    float factor = clamp((luma + change) / max(luma, 1e-12), 1.0 / MAX_FACTOR, MAX_FACTOR);
    state = vec4(certain, factor, smooth_change * (1.0 - certain), 0.0);
    imageStore(out_tile, tile, nrd_round_to_half(state));
}
