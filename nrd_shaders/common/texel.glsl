/* How signals are stored: colour is (Y, Co, Cg) throughout, in halves. */
#ifndef TEXEL_GLSL
#define TEXEL_GLSL

/* The nearest half, on the bits, because image stores and packHalf2x16 truncate on some devices. For abs(v) up to 65504; leaner than
   nrd_round_to_half: ties go away from zero, and denormal halves are left to the store. */
vec4 round_half(vec4 v) { return uintBitsToFloat((floatBitsToUint(v) + 0x1000u) & 0xffffe000u); }

uvec2 pack_texel(vec4 v)
{
    v = round_half(v);
    return uvec2(packHalf2x16(v.xy), packHalf2x16(v.zw));
}
vec4 unpack_texel(uvec2 t) { return vec4(unpackHalf2x16(t.x), unpackHalf2x16(t.y)); }

/* Rounds to a half at random, up as often as the remainder is large: an average that moves by less than half a step a frame would
   stand still under rounding to nearest. What is a half already stays. random: [0, 1). */
vec4 dither_to_half(vec4 v, float random)
{
    return uintBitsToFloat((floatBitsToUint(v) + uint(random * 8192.0)) & 0xffffe000u);
}

/* Second word of the guide texel: bits 0-7 history length in quarter frames, 8-15 hit distance, 16-31 stabilised luma of the previous frame, reprojected. */
struct Aux {
    float frames;      /* [0, 63.75] */
    float hit_dist;    /* normalised */
    float stabilized;
};

/* random: [0, 1), decides the rounding of the hit distance, so that its average survives 8 bits. */
uint pack_aux(Aux a, float random)
{
    uint frames = uint(clamp(a.frames, 0.0, 63.75) * 4.0 + 0.5);
    uint hit_dist = uint(clamp(a.hit_dist * 255.0 + random, 0.0, 255.0));
    return frames | (hit_dist << 8) | (packHalf2x16(round_half(vec4(0.0, a.stabilized, 0.0, 0.0)).xy) & 0xffff0000u);
}

float aux_frames(uint t) { return float(t & 255u) * 0.25; }

Aux unpack_aux(uint t) { return Aux(aux_frames(t), float((t >> 8) & 255u) / 255.0, unpackHalf2x16(t).y); }

#endif
