/* The guide: depth, normal and material of a pixel in 32 bits, so that a tap costs one load.
   bits 0-15   depth / denoising range as a float with 5 exponent and 11 fraction bits (error 1.2e-4 of the depth); 0xffff: sky
   bits 16-29  view-space normal, stereographic, 7 + 7 bits (error at most 2 degrees)
   bits 30-31  material id: guide_material()
   Stereographic, p = n.xy / (1 - n.z), so that taps are compared without decoding their normals:
   1 - cos = 2 |p - q|^2 / ((1 + |p|^2) (1 + |q|^2)), the chordal distance.
   Octahedral map (of the occlusion denoisers' texels): Meyer et al., "On Floating-Point Normal Vectors", EGSR 2010. */
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

/* Largest coordinate of a stereographic normal: 112 degrees from the direction to the camera. Beyond, normals are one. */
const float GUIDE_REACH = 1.5;

vec2 guide_stereographic(vec3 normal_vs) { return clamp(normal_vs.xy / max(1.0 - normal_vs.z, 1e-6), -GUIDE_REACH, GUIDE_REACH); }

/* As the guide has it: what is one class has one number (with min_material 4 all have 0), unless some materials have a class of their own. */
uint guide_material(uint material) { return HAS_MATERIALS ? material : max(material, g.min_material) & 3u; }

uint guide_pack(float z, vec3 normal_vs, uint material)
{
    uvec2 p = uvec2(guide_stereographic(normal_vs) * (63.0 / GUIDE_REACH) + 63.5);
    return guide_pack_depth(z / g.denoising_range) | (p.x << 16) | (p.y << 23) | (is_absent(NRD_ABSENT_MATERIALS) ? 0u : guide_material(material) << 30);
}

bool guide_is_sky(uint code) { return !is_absent(NRD_ABSENT_SKY) && (code & 0xffffu) == GUIDE_SKY; }

/* With SPECULAR, 4 + 4 more bits of the normal lie in the top byte of the guide's second word (error at most 0.12 degrees): reflections
   need them. */
uint guide_pack_fine(vec3 normal_vs)
{
    vec2 p = guide_stereographic(normal_vs) * (63.0 / GUIDE_REACH) + 63.5;
    uvec2 fine = uvec2(clamp(fract(p) * 16.0 + 0.5, 0.0, 15.0));
    return (fine.x << 24) | (fine.y << 28);
}

/* Stereographic normals. The fields lie so that a mask puts them into the fraction of a float in [1, 2). */
const float GUIDE_UNIT = GUIDE_REACH * 128.0 / 63.0;

vec2 guide_point(uint code)
{
    vec2 fraction = vec2(uintBitsToFloat((code & 0x7f0000u) | 0x3f800000u), uintBitsToFloat(((code >> 7) & 0x7f0000u) | 0x3f800000u));
    return fraction * GUIDE_UNIT - (GUIDE_UNIT + GUIDE_REACH);
}

/* The same with the fine bits, which continue those of the coarse ones in the fraction. */
vec2 guide_fine_point(uvec2 guide)
{
    uvec2 bits = uvec2(guide.x & 0x7f0000u, (guide.x >> 7) & 0x7f0000u) | ((uvec2(guide.y >> 12, guide.y >> 16) & 0xf000u));
    return uintBitsToFloat(bits | 0x3f800000u) * GUIDE_UNIT - (GUIDE_UNIT + GUIDE_REACH * 63.5 / 63.0);
}

/* Of unit length, view space. */
vec3 guide_normal(vec2 p)
{
    float inverse = 1.0 / (1.0 + dot(p, p));
    return vec3(2.0 * inverse * p, 1.0 - 2.0 * inverse);
}

/* 1 - cos of the angle between stereographic normals. */
float guide_bend(vec2 p, vec2 q)
{
    vec2 d = p - q;
    return 2.0 * dot(d, d) / ((1.0 + dot(p, p)) * (1.0 + dot(q, q)));
}

/* Units. relative: of the view's extent. Never so tight that the rounding of two stored depths costs half the weight: it would where the
   extent is small against the depth (orthographic and telephoto views). */
float plane_tolerance(float relative, float z) { return max(relative * frustum_size(z), 4.0 * GUIDE_DEPTH_ERROR * z); }

/* Depth relative to the denoising range. */
float guide_relative_depth(uint code) { return uintBitsToFloat(((code & 0xffffu) << 12) + (95u << 23)); }

/* Ids at or below min_material are one class (min_material 4: all of them). */
bool same_material(uint a, uint b) { return is_absent(NRD_ABSENT_MATERIALS) || max(a, g.min_material) == max(b, g.min_material); }

/* The same of what guides have. */
bool guide_same_material(uint a, uint b) { return is_absent(NRD_ABSENT_MATERIALS) || (HAS_MATERIALS ? same_material(a >> 30, b >> 30) : (a ^ b) < 0x40000000u); }

/* The same for one signal where two have their own: which is NRD_MATERIAL_LEAST_DIFFUSE or _SPECULAR. */
bool same_material_for(int which, uint a, uint b) { return !HAS_MATERIALS || max(a, special_material(which)) == max(b, special_material(which)); }

#endif
