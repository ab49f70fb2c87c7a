/* What 8 x 8 pixels tell of a change of light, in 32 bits:
   bits 0-7    luma, logarithmic, 12 % a step; 0: none
   bits 8-15   deviation, likewise
   bits 16-23  change over the deviation, [-1.25, 1.25]
   bits 24-31  change of hit distances, [-16, 16] standard errors
   All are rounded at random: many tiles are averaged. The signed ones are stored so that 0 is 0. */
#ifndef TILE_CHANGE_GLSL
#define TILE_CHANGE_GLSL

struct TileChange {
    float luma_change, luma;   /* means over the pixels */
    float deviation;           /* of a pixel's change by noise; at least 0.86 of the mean change */
    float farther;             /* mean change of hit distances, standard errors */
};

const float STEPS = 6.0;       /* per octave, from LEAST_OCTAVE on */
const float LEAST_OCTAVE = -26.0;
const float MOST_CHANGE = 1.25, MOST_FARTHER = 16.0;

uint pack_log(float v, float random) { return uint(clamp((log2(max(v, 1e-30)) - LEAST_OCTAVE) * STEPS + 1.0, 0.0, 254.0) + random); }
float unpack_log(uint code) { return code == 0u ? 0.0 : exp2((float(code) - 1.0) / STEPS + LEAST_OCTAVE); }

uint pack_signed(float v, float most, float random) { return uint(clamp(v / most, -1.0, 1.0) * 127.0 + 127.0 + random) ^ 127u; }
float unpack_signed(uint code, float most) { return (float(code ^ 127u) - 127.0) / 127.0 * most; }

/* random: 32 bits. */
uint pack_change(TileChange t, uint random)
{
    vec4 r = unpackUnorm4x8(random) * (255.0 / 256.0);
    return pack_log(t.luma, r.x) | (pack_log(t.deviation, r.y) << 8) | (pack_signed(t.luma_change / max(t.deviation, 1e-30), MOST_CHANGE, r.z) << 16) |
           (pack_signed(t.farther, MOST_FARTHER, r.w) << 24);
}

TileChange unpack_change(uint code)
{
    float deviation = unpack_log((code >> 8) & 255u);
    return TileChange(unpack_signed((code >> 16) & 255u, MOST_CHANGE) * deviation, unpack_log(code & 255u), deviation, unpack_signed(code >> 24, MOST_FARTHER));
}

#endif
