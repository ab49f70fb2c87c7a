/* How signals are stored: colour is (Y, Co, Cg) throughout, in halves. */
#ifndef TEXEL_GLSL
#define TEXEL_GLSL

/* To the 10 bits of fraction that halves have, towards zero. addend: to the bits, before. */
vec4 cut_fraction(vec4 v, uint addend) { return uintBitsToFloat((floatBitsToUint(v) + addend) & 0xffffe000u); }

/* The nearest half, on the bits, because image stores and packHalf2x16 truncate on some devices. For abs(v) up to 65504; leaner than
   nrd_round_to_half: ties go away from zero. Adding 0.75 leaves no more than the steps of 2^-24 that denormal halves have (below 6e-5). */
vec4 round_half(vec4 v)
{
    precise vec4 raised = v + 0.75, steps = raised - 0.75;
    return cut_fraction(steps, 0x1000u);
}

/* The nearest of 256 steps from 0 to 1: stores to images of 8 bits truncate to a half first on some devices, and one pixel in twenty would be
   a step too dark there. For [0, 1]. */
vec4 round_byte(vec4 v) { return floor(v * 255.0 + 0.5) * (1.0 / 255.0); }

/* Rounds to a half at random, up as often as the remainder is large: an average that moves by less than half a step a frame would
   stand still under rounding to nearest. What is a half already stays. Numbers of one random keep their order, and opposite ones stay so.
   random: 24 bits; 13 decide of normal halves, 11 of the steps of denormal ones. */
vec4 dither_to_half(vec4 v, uint random)
{
    float part = (float(random & 0x7ffu) - 1023.5) * (1.0 / 2048.0 / 16777216.0);
    vec4 outwards = uintBitsToFloat((floatBitsToUint(v) & 0x80000000u) ^ floatBitsToUint(part));
    precise vec4 moved = v + outwards, raised = moved + 0.75, steps = raised - 0.75;   /* as in round_half() */
    return cut_fraction(steps, random >> 11);
}

/* Colours. Rounded one by one, Y, Co and Cg can become what RGB of at least 0 cannot give, in dim light by a good part of Y. Of Y, Cg and
   abs(Co) + Cg none is larger than Y, and rounding that keeps the order of numbers and their opposites leaves it so. Below 2^-14, where all
   halves have the same steps, Co is therefore what is left between the last two; above, that would not always be a half. */
bool is_dim(vec4 color) { return color.x < 6.1035156e-5; }
vec4 fold_chroma(vec4 color) { return vec4(color.x, abs(color.y) + color.z, color.zw); }
vec4 unfold_chroma(vec4 folded, vec4 color)
{
    float orange = folded.y - folded.z;
    return vec4(folded.x, color.y < 0.0 ? -orange : orange, folded.zw);
}

/* Most colours are so bright that what denormal halves lose of the other numbers, 2^-24, is nothing beside their luma: 2^-20 of it at most. */
bool is_bright(vec4 color) { return color.x > 0.0625; }

vec4 round_color(vec4 color)
{
    if (is_bright(color)) return cut_fraction(color, 0x1000u);
    if (is_dim(color)) return unfold_chroma(round_half(fold_chroma(color)), color);
    return round_half(color);
}

vec4 dither_color(vec4 color, uint random)
{
    if (is_bright(color)) return cut_fraction(color, random >> 11);
    if (is_dim(color)) return unfold_chroma(dither_to_half(fold_chroma(color), random), color);
    return dither_to_half(color, random);
}

uvec2 pack_halves(vec4 v) { return uvec2(packHalf2x16(v.xy), packHalf2x16(v.zw)); }   /* of what are halves already */
uvec2 pack_texel(vec4 color) { return pack_halves(round_color(color)); }
vec4 unpack_texel(uvec2 t) { return vec4(unpackHalf2x16(t.x), unpackHalf2x16(t.y)); }

#endif
