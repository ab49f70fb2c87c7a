/* What every pass has: constants, push constants, specialization constants, and the pixel grid. */
#ifndef PASS_GLSL
#define PASS_GLSL

#extension GL_EXT_control_flow_attributes : require   /* of the compiler alone: a hint */
#define UNROLL [[unroll]]

/* Signals that a module is built for (modules.txt), for binding numbers: what is common comes first, then the diffuse one's, then the specular one's. */
#ifdef DIFFUSE
#define HAS_DIFFUSE 1
#else
#define HAS_DIFFUSE 0
#endif
#ifdef SPECULAR
#define HAS_SPECULAR 1
#else
#define HAS_SPECULAR 0
#endif

#include "nrd_shared.glsl"
#include "../nrd.glsl"

#define NRDI_X(type, name) type name;
layout(std140, set = 0, binding = 0) uniform constants_block { NRD_CONSTANTS(NRDI_X) } g;
layout(push_constant) uniform push_block { NRD_PUSH_CONSTANTS(NRDI_X) } push;
#undef NRDI_X

#define NRDI_X(name, id) layout(constant_id = id) const uint SPEC_##name = 0;
NRD_SPEC_CONSTANTS(NRDI_X)
#undef NRDI_X

layout(local_size_x = 8, local_size_y = 8, local_size_z = 1) in;

/* 0, which the compiler cannot know. Branches on nothing but constants of the frame take it in: lavapipe (Mesa 22) else compiles
   such a pass anew for every dispatch. */
uint opaque_zero() { return gl_WorkGroupID.z; }
bool is_reset() { return (g.reset | opaque_zero()) != 0u; }

/* NRD_ABSENT_ bits: true if the app has promised any of these. A constant: what depends on it is not in the pipeline. */
bool is_absent(int what) { return (SPEC_ABSENT & uint(what)) != 0u; }

bool is_ruled_out(uint flag) { return is_absent(NRD_ABSENT_LIGHTING_CHANGE) && (flag & (NRD_FLAG_ANTILAG | NRD_FLAG_TILE_HISTORY)) != 0u; }
bool has_flag(uint flag) { return !is_ruled_out(flag) && ((g.flags | opaque_zero()) & flag) != 0u; }
bool is_filtering() { return !is_absent(NRD_ABSENT_BLUR) && push.step_size > int(opaque_zero()); }

bool is_same_rect() { return ((g.rect_width ^ g.rect_width_prev) | (g.rect_height ^ g.rect_height_prev) | opaque_zero()) == 0u; }

/* One of the ids in nrd_constants.materials; 4: none. */
const bool HAS_MATERIALS = (SPEC_FEATURES & NRD_FEATURE_MATERIALS) != 0;
uint special_material(int which) { return ((g.materials | opaque_zero()) >> which) & 15u; }

ivec2 rect_size() { return ivec2(g.rect_width, g.rect_height); }
ivec2 rect_origin() { return ivec2(g.rect_origin_x, g.rect_origin_y); }
bool in_rect(ivec2 p) { return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, rect_size())); }
vec2 pixel_uv(ivec2 p) { return (vec2(p) + 0.5) * g.px_uv.xy; }

/* The state of the tiles around a position in pixels, interpolated; never beyond the tiles of the rectangle. tile_last, tile_uv: of the frame that
   wrote it. */
vec4 sample_tiles(sampler2D tiles, vec2 position_px, vec2 tile_last, vec2 tile_uv)
{
    return textureLod(tiles, clamp(position_px / 8.0, vec2(0.5), tile_last) * tile_uv, 0.0);
}

/* NaN counts as sky. */
bool is_sky(float view_z) { return !is_absent(NRD_ABSENT_SKY) && !(abs(view_z) < g.denoising_range); }

/* Has no specular signal: specular_roughness_limit. */
const bool HAS_ROUGHNESS_LIMIT = (SPEC_FEATURES & NRD_FEATURE_ROUGHNESS_LIMIT) != 0;
bool is_too_rough(float roughness) { return HAS_ROUGHNESS_LIMIT && roughness > g.jitter_delta.w; }

/* One 32-bit hash of three numbers: the finaliser of MurmurHash3 (A. Appleby) over a Weyl sum. */
uint hash(uint x, uint y, uint z)
{
    uint h = x * 0x9e3779b1u + y * 0x85ebca77u + z * 0xc2b2ae3du;
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return h ^ (h >> 16);
}

#endif
