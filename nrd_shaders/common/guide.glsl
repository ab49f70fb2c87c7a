/* The guide: what a tap must know of a pixel, in two words that cost one load.
   x  bits 0-15   depth / denoising range as a float with 5 exponent and 11 fraction bits (error 1.2e-4 of the depth); 0xffff: sky
   without SPECULAR
      bits 16-29  view-space normal, 7 + 7 bits (error at most 1.5 degrees where it faces the camera)
      bits 30-31  material id: guide_material()
   y  bits 0-7    history length, 8-31 the track: signals.glsl
   with SPECULAR, as reflections need finer normals
   x  bits 16-23  history length of the first signal, 24-31 of the second
   y  bits 0-19   normal, 10 + 10 bits (error at most 0.19 degrees, likewise)
      bits 22-29  roughness
      bits 30-31  material id
   Normals are points of Lambert's equal-area map around the direction to the camera: half the squared distance of two is about
   1 - cos of their angle, so that taps are compared without decoding theirs. Exact for small angles there; 60 degrees off, 0.75 to 1.33 times that.
   J. Snyder, "Map Projections: A Working Manual", USGS Professional Paper 1395, 1987, ch. 24.
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

/* Largest coordinate of a normal's point: 113 degrees from the direction to the camera. Beyond, normals are one. */
const float GUIDE_REACH = 1.664;

vec2 guide_project(vec3 normal_vs) { return clamp(normal_vs.xy * inversesqrt(max(0.5 - 0.5 * normal_vs.z, 1e-6)), -GUIDE_REACH, GUIDE_REACH); }

/* As the guide has it: what is one class has one number (with min_material 4 all have 0), unless some materials have a class of their own. */
uint guide_material(uint material) { return HAS_MATERIALS ? material : max(material, g.min_material) & 3u; }

#ifdef SPECULAR
const float GUIDE_STEPS = 511.0;    /* from the middle to the edge of the map */
const uint GUIDE_NORMAL_BITS = 10u;
#else
const float GUIDE_STEPS = 63.0;
const uint GUIDE_NORMAL_BITS = 7u;
#endif

/* Without history lengths and track. roughness: [0,1]; with SPECULAR. */
uvec2 guide_pack(float z, vec3 normal_vs, float roughness, uint material)
{
    uvec2 p = uvec2(guide_project(normal_vs) * (GUIDE_STEPS / GUIDE_REACH) + (GUIDE_STEPS + 0.5));
    uint depth = guide_pack_depth(z / g.denoising_range), normal = p.x | p.y << GUIDE_NORMAL_BITS;
    uint top = is_absent(NRD_ABSENT_MATERIALS) ? 0u : guide_material(material) << 30;
#ifdef SPECULAR
    return uvec2(depth, normal | uint(roughness * 255.0 + 0.5) << 22 | top);
#else
    return uvec2(depth | normal << 16 | top, 0u);
#endif
}

bool guide_is_sky(uint code) { return !is_absent(NRD_ABSENT_SKY) && (code & 0xffffu) == GUIDE_SKY; }

/* The point of a normal. The fields are shifted so that a mask puts them into the fraction of a float in [1, 2). */
const float GUIDE_UNIT = GUIDE_REACH * float(1 << GUIDE_NORMAL_BITS) / GUIDE_STEPS;

vec2 guide_point(uvec2 guide)
{
#ifdef SPECULAR
    uvec2 bits = uvec2(guide.y << 13, guide.y << 3) & 0x7fe000u;
#else
    uvec2 bits = uvec2(guide.x, guide.x >> 7) & 0x7f0000u;
#endif
    return uintBitsToFloat(bits | 0x3f800000u) * GUIDE_UNIT - (GUIDE_UNIT + GUIDE_REACH);
}

/* Of unit length, view space. */
vec3 guide_normal(vec2 p)
{
    float squared = dot(p, p);
    return vec3(p * sqrt(max(1.0 - 0.25 * squared, 0.0)), 0.5 * squared - 1.0);
}

/* 1 - cos of the angle between normals. */
float guide_bend(vec2 p, vec2 q) { return 0.5 * dot(p - q, p - q); }

/* The word that has the material id in its top bits. */
uint guide_material_word(uvec2 guide)
{
#ifdef SPECULAR
    return guide.y;
#else
    return guide.x;
#endif
}

/* Units. relative: of the view's extent. Never so tight that the rounding of two stored depths costs half the weight: it would where the
   extent is small against the depth (orthographic and telephoto views). */
float plane_tolerance(float relative, float z) { return max(relative * frustum_size(z), 4.0 * GUIDE_DEPTH_ERROR * z); }

/* Depth relative to the denoising range. */
float guide_relative_depth(uint code) { return uintBitsToFloat(((code & 0xffffu) << 12) + (95u << 23)); }

/* Ids at or below min_material are one class (min_material 4: all of them). */
bool same_material(uint a, uint b) { return is_absent(NRD_ABSENT_MATERIALS) || max(a, g.min_material) == max(b, g.min_material); }

/* The same of what guides have: guide_material_word(). */
bool guide_same_material(uint a, uint b) { return is_absent(NRD_ABSENT_MATERIALS) || (HAS_MATERIALS ? same_material(a >> 30, b >> 30) : (a ^ b) < 0x40000000u); }

/* The same for one signal where two have their own: which is NRD_MATERIAL_LEAST_DIFFUSE or _SPECULAR. */
bool same_material_for(int which, uint a, uint b) { return !HAS_MATERIALS || max(a, special_material(which)) == max(b, special_material(which)); }

#endif
