/* Reads   tile statistics of this frame, the tile's state.
   Writes  the tile's state: x amount of change [0,1], y factor for history, z smoothed luma change, w smoothed luma.
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
const float MEMORY = 0.33;        /* weight of the new frame */
const float FULL_CHANGE = 0.03;   /* change beyond the noise, relative to the luma, that is applied in full */
const float MAX_FACTOR = 4.0;

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
    float change = mix(state.z, sum.x / sum.z, MEMORY), luma = sum.y / sum.z;
    float error = sqrt(variance) / sum.z * sqrt(MEMORY / (2.0 - MEMORY));
    float certain = clamp((abs(change) - g.antilag_sigma_scale * error) / (FULL_CHANGE * max(luma, abs(change)) + 1e-12), 0.0, 1.0) * g.antilag_sensitivity;
    float factor = clamp((luma + change) / max(luma, 1e-12), 1.0 / MAX_FACTOR, MAX_FACTOR);
    state = vec4(certain, factor, change * (1.0 - certain), luma);
    imageStore(out_tile, tile, unpack_texel(pack_texel(clamp(state, -65504.0, 65504.0))));
}
