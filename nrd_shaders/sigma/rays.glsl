/* What a ray tells: lit, or blocked with the half width of its penumbra. */
#ifndef RAYS_GLSL
#define RAYS_GLSL

/* Half widths in pixels, or */
const float LIT = 1e6;
const float WIDEST = 1e5;
const float FACES_AWAY = -1.0;
const float NOTHING = -2.0;              /* sky, outside the rectangle */

/* On the bits: devices may take numbers below 1.2e-38 for 0, which says that the surface faces away. NaN: no. */
bool is_positive(float v) { return floatBitsToUint(v) - 1u < 0x7f800000u; }

/* Choices are made by mix(), which, unlike ?: and &&, makes no branches. NaN: faces away. */
float width_of(float penumbra, float z)
{
    float blocked = mix(FACES_AWAY, clamp(penumbra / max(pixel_size(abs(z)), 1e-37), 1e-20, WIDEST), is_positive(penumbra));
    return mix(mix(blocked, LIT, penumbra >= NRD_HIT_DIST_MISS), NOTHING, is_sky(z));
}

/* 1 / (half width + 1 px), the weight of a blocked ray in the mean of widths; of others more than any of these. */
const float NARROWNESS_LIT = 2.0;
float narrowness_of(float width) { return mix(NARROWNESS_LIT, 1.0 / (width + 1.0), width > 0.0 && width != LIT); }

uint kind_of(float width) { return mix(mix(0u, KIND_BLOCKED, width > 0.0), KIND_LIT, width == LIT); }

/* Of a ray that is not coloured. */
Visibility visibility_of(float width) { return Visibility(width == LIT); }

#ifdef TRANSLUCENCY
/* Of a blocked ray. NaN: 0. */
uint load_color(ivec2 pixel)
{
    vec4 texel = texelFetch(in_translucency, pixel, 0);
    return packUnorm4x8(vec4(nrd_is_finite(texel.xyz) ? texel.xyz : vec3(0.0), 0.0));
}
#endif

#endif
