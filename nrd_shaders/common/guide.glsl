/* The guide: depth, normal and material of a pixel in 32 bits, so that a tap costs one load.
   bits 0-15   depth / denoising range as a float with 5 exponent and 11 fraction bits (error 1.2e-4 of the depth); 0xffff: sky
   bits 16-29  world normal, octahedral, 7 + 7 bits (error at most 1.2 degrees)
   bits 30-31  material id
   Octahedral map: Meyer et al., "On Floating-Point Normal Vectors", EGSR 2010. */
#ifndef GUIDE_GLSL
#define GUIDE_GLSL

const uint GUIDE_SKY = 0xffffu;
const float GUIDE_DEPTH_ERROR = 1.25e-4;   /* of the depth */

uint guide_pack_depth(float relative_z)
{
    uint bits = floatBitsToUint(clamp(relative_z, 3.0e-10, 0.9998)) - (95u << 23);  /* 2^-32 is exponent 0 */
    return min((bits + 0x800u) >> 12, GUIDE_SKY - 1u);
}

vec2 guide_octahedral(vec3 n)
{
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    vec2 folded = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    return n.z >= 0.0 ? n.xy : folded;
}

uint guide_pack(float z, vec3 normal, uint material)
{
    uvec2 oct = uvec2(guide_octahedral(normal) * 63.0 + 63.5);
    return guide_pack_depth(z / g.denoising_range) | (oct.x << 16) | (oct.y << 23) | (is_absent(NRD_ABSENT_MATERIALS) ? 0u : material << 30);
}

bool guide_is_sky(uint code) { return !is_absent(NRD_ABSENT_SKY) && (code & 0xffffu) == GUIDE_SKY; }

/* With SPECULAR, 4 + 4 more bits of the normal lie in the top byte of the guide's second word (error at most 0.06 degrees): reflections
   need them. */
uint guide_pack_fine(vec3 normal)
{
    vec2 oct = guide_octahedral(normal) * 63.0 + 63.5;
    uvec2 fine = uvec2(clamp(fract(oct) * 16.0 + 0.5, 0.0, 15.0));
    return (fine.x << 24) | (fine.y << 28);
}

/* Not of unit length. The fields lie so that a mask puts them into the fraction of a float in [1, 2). */
vec3 guide_direction(uint code)
{
    vec2 fraction = vec2(uintBitsToFloat((code & 0x7f0000u) | 0x3f800000u), uintBitsToFloat(((code >> 7) & 0x7f0000u) | 0x3f800000u));
    vec2 oct = fraction * (128.0 / 63.0) - (128.0 / 63.0 + 1.0);
    float z = 1.0 - abs(oct.x) - abs(oct.y), fold = max(-z, 0.0);
    return vec3(oct.x + (oct.x >= 0.0 ? -fold : fold), oct.y + (oct.y >= 0.0 ? -fold : fold), z);
}

/* The same with the fine bits, which continue those of the coarse ones in the fraction. */
vec3 guide_fine_direction(uvec2 guide)
{
    uvec2 bits = uvec2(guide.x & 0x7f0000u, (guide.x >> 7) & 0x7f0000u) | ((uvec2(guide.y >> 12, guide.y >> 16) & 0xf000u));
    vec2 oct = uintBitsToFloat(bits | 0x3f800000u) * (128.0 / 63.0) - (128.0 / 63.0 + 63.5 / 63.0);
    float z = 1.0 - abs(oct.x) - abs(oct.y), fold = max(-z, 0.0);
    return vec3(oct.x + (oct.x >= 0.0 ? -fold : fold), oct.y + (oct.y >= 0.0 ? -fold : fold), z);
}

/* 1 - cos of the angle to a unit normal; slightly negative by rounding at most. */
float guide_bend(uint code, vec3 normal)
{
    vec3 direction = guide_direction(code);
    return 1.0 - dot(normal, direction) * inversesqrt(dot(direction, direction));
}

/* Units. relative: of the view's extent. Never so tight that the rounding of two stored depths costs half the weight: it would where the
   extent is small against the depth (orthographic and telephoto views). */
float plane_tolerance(float relative, float z) { return max(relative * frustum_size(z), 4.0 * GUIDE_DEPTH_ERROR * z); }

/* Depth relative to the denoising range. */
float guide_relative_depth(uint code) { return uintBitsToFloat(((code & 0xffffu) << 12) + (95u << 23)); }

/* Ids at or below min_material are one class (min_material 4: all of them). */
bool same_material(uint a, uint b) { return is_absent(NRD_ABSENT_MATERIALS) || max(a, g.min_material) == max(b, g.min_material); }

/* The same for one signal where two have their own: which is NRD_MATERIAL_LEAST_DIFFUSE or _SPECULAR. */
bool same_material_for(int which, uint a, uint b) { return !HAS_MATERIALS || max(a, special_material(which)) == max(b, special_material(which)); }

#endif
