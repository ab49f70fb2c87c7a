/* What the passes of the occlusion denoisers share: texels so small that a tap costs one load of 4 bytes (diffuse), or 8.
   Built with -DDIFFUSE, -DSPECULAR or both, or -DDIFFUSE -DDIRECTIONAL.

   tap.x  bits 0-11 depth / denoising range as a float with 5 exponent and 7 fraction bits (error 2e-3 of the depth; 0xfff: sky)
     diffuse alone   12-19 world normal (octahedral, 4 + 4 bits, error 9 degrees), 20-21 material id,
                     22-23 class of history length, 24-31 occlusion
     with specular   12-25 world normal (7 + 7 bits, error 1.2 degrees), 26-27 material id, 28-31 low bits of specular occlusion
   tap.y  directional: 0-29 moment of the openness, three fields of 10 bits
          with specular: 0-7 specular occlusion, 8-13 its history length, 14-17 roughness,
     specular alone  18-23 radius
     both            18-25 diffuse occlusion, 26-31 its history length
   state  diffuse alone   0-3 low bits of occlusion, 4-9 history length in frames, 10-15 radius
          both            0-3 low bits of diffuse occlusion, 4-9 diffuse radius, 10-15 specular radius
   Finer depths and diffuse normals gain nothing; they were compared with exact ones. */
#ifndef OCCLUSION_GLSL
#define OCCLUSION_GLSL


const uint TAP_SKY = 0xfffu;
const float TAP_DEPTH_ERROR = 2.0e-3;   /* of the depth */
const float LEAST_RADIUS = 1.0 / 64.0;  /* of the length that counts as unoccluded; steps of 7 % up to 1 */
const float WIDEST_BEND = 0.5;          /* 60 degrees: beyond it is another surface, whatever normal_sensitivity says */
const float LOG2_E = 1.442695;

/* One lobe of a pixel. */
struct Lobe {
    float occlusion;   /* mean normalised hit distance */
    float frames;      /* history length */
    float radius;      /* harmonic mean of single normalised hit distances around */
    vec3 moment;       /* directional: mean of ray direction times normalised hit distance, world space */
};

struct Texel {
    uvec2 tap;
    uint state;
};

/* A field of `bits` bits from bit `first` on, read by putting it into the fraction of a float in [1, 2): conversions run at a quarter of the
   rate. Constants as arguments cost nothing. */
float field(uint code, int first, int bits)
{
    uint mask = ((1u << bits) - 1u) << (23 - bits);
    uint shifted = first > 23 - bits ? code >> (first - 23 + bits) : code << (23 - bits - first);
    return (uintBitsToFloat((shifted & mask) | 0x3f800000u) - 1.0) * float(1u << bits);
}

/* ---- the disc of the blur ---- */
/* Its radius over the harmonic mean of hit distances. 0.13 to 0.24 tried: less is noisier, more loses contact shadows. */
const float WIDTH = 0.17;
/* Most of its radius over the lobe's footprint. 0.5 to 3 tried: more is smoother. */
const float LOBE_WIDTH = 3.0;

/* Units; radius: of the lobe. */
float diffuse_reach(float radius, float z) { return WIDTH * radius * nrd_hit_dist_scale(z, 1.0, g.hit_distance); }

/* least: but never more than the lobe's footprint allows. */
float specular_reach(float radius, vec3 position, float roughness, float least)
{
    float hit_dist = radius * nrd_hit_dist_scale(position.z, roughness, g.hit_distance), distance = length(position), alpha = max(roughness * roughness, 1e-4);
    return min(max(WIDTH * hit_dist, least), LOBE_WIDTH * alpha * hit_dist * distance / (hit_dist + distance));
}

/* Exponents of 2 per 1 - cos of the angle between normals, and what a tap of another roughness weighs. */
float diffuse_bend_scale() { return -LOG2_E * g.normal_sensitivity; }
float specular_bend_scale(float roughness) { return -LOG2_E * max(g.normal_sensitivity, 1.0 / (roughness * roughness * roughness * roughness + 2e-3)); }
float roughness_weight(float tap, float roughness) { return clamp(1.0 - abs(tap - roughness) / (0.1 + 0.3 * roughness), 0.0, 1.0); }

/* ---- the surface ---- */
#ifdef SPECULAR
const float OCT_MAX = 63.0;
const uint OCT_BITS = 7u, OCT_MASK = 0x7f0000u;
uvec2 oct_fields(uvec2 tap) { return uvec2(tap.x << 4, tap.x >> 3); }
#else
const float OCT_MAX = 7.0;
const uint OCT_BITS = 4u, OCT_MASK = 0x780000u;
uvec2 oct_fields(uvec2 tap) { return uvec2(tap.x << 7, tap.x << 3); }
#endif

uvec2 pack_surface(float z, nrd_surface surface)
{
    uint bits = floatBitsToUint(clamp(z / g.denoising_range, 5.0e-10, 1.0)) - (96u << 23);   /* 2^-31 is exponent 0: 1 is well below sky */
    uvec2 oct = uvec2(guide_octahedral(surface.normal) * OCT_MAX + (OCT_MAX + 0.5));
    uint x = ((bits + 0x8000u) >> 16) | (oct.x << 12) | (oct.y << (12u + OCT_BITS)) | (is_absent(NRD_ABSENT_MATERIALS) ? 0u : surface.material_id << (12u + 2u * OCT_BITS));
    return uvec2(x, uint(surface.roughness * 15.0 + 0.5) << 14);
}

bool tap_is_sky(uvec2 tap) { return !is_absent(NRD_ABSENT_SKY) && (tap.x & 0xfffu) == TAP_SKY; }
uint tap_material(uvec2 tap) { return (tap.x >> (12u + 2u * OCT_BITS)) & 3u; }
float tap_relative_depth(uvec2 tap) { return uintBitsToFloat(((tap.x & 0xfffu) << 16) + (96u << 23)); }
float tap_roughness(uvec2 tap) { return field(tap.y, 14, 4) / 15.0; }

/* 1 - cos of the angle to a unit normal. Masks put the fields into the fraction of a float in [1, 2). */
float tap_bend(uvec2 tap, vec3 normal)
{
    const float scale = float(1u << OCT_BITS) / OCT_MAX;
    vec2 oct = uintBitsToFloat((oct_fields(tap) & OCT_MASK) | 0x3f800000u) * scale - (scale + 1.0);
    float z = 1.0 - abs(oct.x) - abs(oct.y), fold = max(-z, 0.0);
    vec3 direction = vec3(oct.x + (oct.x >= 0.0 ? -fold : fold), oct.y + (oct.y >= 0.0 ? -fold : fold), z);
    return max(1.0 - dot(normal, direction) * inversesqrt(dot(direction, direction)), 0.0);
}

/* Whether the normal, or that and the material, are stored as the same bits. */
bool is_parallel(uvec2 a, uvec2 b) { return ((a.x ^ b.x) & (((1u << (2u * OCT_BITS)) - 1u) << 12)) == 0u; }
bool is_alike(uvec2 a, uvec2 b) { return ((a.x ^ b.x) & (((4u << (2u * OCT_BITS)) - 1u) << 12)) == 0u; }

/* ---- its lobes ---- */
/* Rounded at random, so that averages survive few bits. random: [0, 1). */
uint pack_occlusion(float occlusion, float random) { return uint(clamp(occlusion, 0.0, 1.0) * 4080.0 + random) + 8u; }
uint pack_frames(float frames, float random) { return uint(clamp(frames + random, 0.0, 63.0)); }
uint pack_radius(float radius, float random) { return uint(clamp(63.0 + 10.5 * log2(clamp(radius, LEAST_RADIUS, 1.0)) + random, 0.0, 63.0)); }
float unpack_occlusion(float high, float low) { return (high * 16.0 + low - 8.0) / 4080.0; }
float unpack_radius(float code) { return exp2((code - 63.0) / 10.5); }

#ifdef DIRECTIONAL
/* random: one for all fields; they are turned against each other. */
uint pack_moment(vec3 moment, float random)
{
    uvec3 fields = uvec3(clamp(moment, -1.0, 1.0) * 511.0 + 511.0 + fract(random + vec3(0.0, 0.618, 0.236)));
    return fields.x | (fields.y << 10) | (fields.z << 20);
}

vec3 unpack_moment(uint code) { return vec3(field(code, 0, 10), field(code, 10, 10), field(code, 20, 10)) / 511.0 - 1.0; }
#else
uint pack_moment(vec3 moment, float random) { return 0u; }
vec3 unpack_moment(uint code) { return vec3(0.0); }
#endif

#if defined(DIFFUSE) && !defined(SPECULAR)
Texel pack_lobes(uvec2 surface, Lobe d, Lobe s, float random)
{
    uint v = pack_occlusion(d.occlusion, random), level = d.frames < 2.5 ? 0u : d.frames < 6.0 ? 1u : d.frames < 14.0 ? 2u : 3u;
    return Texel(uvec2(surface.x | (level << 22) | (v >> 4 << 24), pack_moment(d.moment, random)), (v & 15u) | (pack_frames(d.frames, random) << 4) | (pack_radius(d.radius, random) << 10));
}

Lobe diffuse_lobe(Texel t) { return Lobe(unpack_occlusion(field(t.tap.x, 24, 8), field(t.state, 0, 4)), field(t.state, 4, 6), unpack_radius(field(t.state, 10, 6)), unpack_moment(t.tap.y)); }
vec4 tap_diffuse(uvec2 tap) { return vec4(unpack_moment(tap.y), field(tap.x, 24, 8) / 255.0); }

/* What a tap's history counts for, about the mean length of its class: 1.5, 3.75, 10 or 26. */
float tap_diffuse_frames(uvec2 tap) { return uintBitsToFloat(0x3fc00000u + ((tap.x >> 22) & 3u) * 0xb00000u); }

#endif

#ifdef SPECULAR
float tap_specular(uvec2 tap) { return field(tap.y, 0, 8) / 255.0; }
float tap_specular_frames(uvec2 tap) { return max(field(tap.y, 8, 6), 1.0); }
uvec2 put_specular(uvec2 tap, float s, float random)
{
    uint v = pack_occlusion(s, random);
    return uvec2((tap.x & 0xfffffffu) | (v << 28), (tap.y & ~255u) | (v >> 4));
}
#endif

#if defined(SPECULAR) && !defined(DIFFUSE)
Texel pack_lobes(uvec2 surface, Lobe d, Lobe s, float random)
{
    uvec2 tap = put_specular(surface, s.occlusion, random);
    return Texel(uvec2(tap.x, tap.y | (pack_frames(s.frames, random) << 8) | (pack_radius(s.radius, random) << 18)), 0u);
}

Lobe specular_lobe(Texel t) { return Lobe(unpack_occlusion(field(t.tap.y, 0, 8), field(t.tap.x, 28, 4)), field(t.tap.y, 8, 6), unpack_radius(field(t.tap.y, 18, 6)), vec3(0.0)); }
#endif

#if defined(SPECULAR) && defined(DIFFUSE)
Texel pack_lobes(uvec2 surface, Lobe d, Lobe s, float random)
{
    uvec2 tap = put_specular(surface, s.occlusion, random);
    uint v = pack_occlusion(d.occlusion, random);
    tap.y |= (pack_frames(s.frames, random) << 8) | (v >> 4 << 18) | (pack_frames(d.frames, random) << 26);
    return Texel(tap, (v & 15u) | (pack_radius(d.radius, random) << 4) | (pack_radius(s.radius, random) << 10));
}

Lobe diffuse_lobe(Texel t) { return Lobe(unpack_occlusion(field(t.tap.y, 18, 8), field(t.state, 0, 4)), field(t.tap.y, 26, 6), unpack_radius(field(t.state, 4, 6)), vec3(0.0)); }
Lobe specular_lobe(Texel t) { return Lobe(unpack_occlusion(field(t.tap.y, 0, 8), field(t.tap.x, 28, 4)), field(t.tap.y, 8, 6), unpack_radius(field(t.state, 10, 6)), vec3(0.0)); }
vec4 tap_diffuse(uvec2 tap) { return vec4(vec3(0.0), field(tap.y, 18, 8) / 255.0); }
float tap_diffuse_frames(uvec2 tap) { return max(field(tap.y, 26, 6), 1.0); }

#endif

#endif
