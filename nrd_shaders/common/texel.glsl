/* How signals are stored: colour is (Y, Co, Cg) throughout, in halves. */
#ifndef TEXEL_GLSL
#define TEXEL_GLSL

/* The nearest half, on the bits, because image stores and packHalf2x16 truncate on some devices. For abs(v) up to 65504; leaner than
   nrd_round_to_half: ties go away from zero. Adding 0.75 leaves no more than the steps of 2^-24 that denormal halves have (below 6e-5). */
vec4 round_half(vec4 v)
{
    precise vec4 raised = v + 0.75, steps = raised - 0.75;
    return uintBitsToFloat((floatBitsToUint(steps) + 0x1000u) & 0xffffe000u);
}

uvec2 pack_texel(vec4 v)
{
    v = round_half(v);
    return uvec2(packHalf2x16(v.xy), packHalf2x16(v.zw));
}
vec4 unpack_texel(uvec2 t) { return vec4(unpackHalf2x16(t.x), unpackHalf2x16(t.y)); }

/* Rounds to a half at random, up as often as the remainder is large: an average that moves by less than half a step a frame would
   stand still under rounding to nearest. What is a half already stays. random: 24 bits; 13 decide of normal halves, 11 of the steps of denormal ones. */
vec4 dither_to_half(vec4 v, uint random)
{
    float part = float(random & 0x7ffu) * (1.0 / 2048.0) - (1023.5 / 2048.0);
    precise vec4 moved = v + part * (1.0 / 16777216.0), raised = moved + 0.75, steps = raised - 0.75;   /* as in round_half() */
    return uintBitsToFloat((floatBitsToUint(steps) + (random >> 11)) & 0xffffe000u);
}

#endif
