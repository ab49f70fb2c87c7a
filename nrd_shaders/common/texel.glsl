/* How signals are stored: colour is (Y, Co, Cg) throughout. Halves are rounded to nearest by
   nrd_round_to_half, because image stores and packHalf2x16 truncate on some devices. */
#ifndef TEXEL_GLSL
#define TEXEL_GLSL

uvec2 pack_texel(vec4 v)
{
    v = nrd_round_to_half(v);
    return uvec2(packHalf2x16(v.xy), packHalf2x16(v.zw));
}
vec4 unpack_texel(uvec2 t) { return vec4(unpackHalf2x16(t.x), unpackHalf2x16(t.y)); }

/* Rounds to a half at random, up as often as the remainder is large: an average that moves by less than half a step a frame would
   stand still under rounding to nearest. What is a half already stays. random: [0, 1). */
vec4 dither_to_half(vec4 v, float random)
{
    return nrd_round_to_half(uintBitsToFloat((floatBitsToUint(v) + uint(random * 8192.0)) & 0xffffe000u));   /* the rest: overflow, denormals */
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
    return frames | (hit_dist << 8) | (packHalf2x16(vec2(0.0, nrd_round_to_half(a.stabilized))) & 0xffff0000u);
}

float aux_frames(uint t) { return float(t & 255u) * 0.25; }

Aux unpack_aux(uint t) { return Aux(aux_frames(t), float((t >> 8) & 255u) / 255.0, unpackHalf2x16(t).y); }

#endif
