/* What the passes of SIGMA share: the words they hand each other, and distances as the light sees them. */
#ifndef SIGMA_GLSL
#define SIGMA_GLSL

#include "../common/texel.glsl"

/* ---- visibility: a number, or three */
#ifdef TRANSLUCENCY
#define Visibility vec3
float luma_of(Visibility v) { return nrd_luma(v); }
#else
#define Visibility float
float luma_of(Visibility v) { return v; }
#endif
/* Roots, for finer steps in the dark. */
vec4 shadow_texel(Visibility v) { return round_byte(vec4(sqrt(clamp(vec3(v), 0.0, 1.0)), 1.0)); }
const Visibility NO_LIGHT = Visibility(0.0);
const Visibility ALL_LIGHT = Visibility(1.0);

/* ---- words. x: 12 bits depth, 8 bits mean visibility (its red), then
   of this frame   4 bits age: for how many frames a penumbra has been here (0: none, the ray as it is), 8 bits half width of the penumbra in pixels: of a blocked
                   ray without a penumbra its own, of a lit one any
   history         8 bits stabilised visibility (its luma; age 0: width as above instead), 4 bits age
   y, translucent only: 8 bits green, 8 bits blue, and of this frame 8 bits reprojected stabilised luma. */
const float DEPTH_STEPS = 170.625;      /* per octave; 24 octaves below the denoising range */
const float DEPTH_ERROR = 2.1e-3;       /* of the depth, at most */
const uint DEPTH_NONE = 4095u;          /* sky, or faces away from the light */

/* Bits of a word that a shift has brought to the top of a float's fraction, as a number in [0, 1): cheaper than a conversion. */
float raised_fraction(uint word, uint mask) { return uintBitsToFloat((word & mask) | 0x3f800000u); }   /* plus 1 */
float fraction_of(uint word, uint mask) { return raised_fraction(word, mask) - 1.0; }

uint pack_depth(float z)
{
    return uint(clamp(log2(z / g.denoising_range) * DEPTH_STEPS + (24.0 * DEPTH_STEPS + 0.5), 0.0, 4094.0));
}
/* The base-2 logarithm is this, times x, plus y. */
float depth_bits(uvec2 word) { return raised_fraction(word.x << 11, 0x7ff800u); }
vec2 depth_logarithm(float range) { return vec2(4096.0 / DEPTH_STEPS, log2(range) - 24.0 - 4096.0 / DEPTH_STEPS); }
/* range: the denoising range of the frame that packed it. */
float unpack_depth(uvec2 word, float range) { return exp2((fraction_of(word.x << 11, 0x7ff800u) * (4096.0 / DEPTH_STEPS)) - 24.0) * range; }
bool is_nothing(uvec2 word) { return (word.x & 4095u) == DEPTH_NONE; }

const float WIDTH_ANY = 256.0;           /* px */
const float WIDTH_STEPS = 254.0 / 12.0;  /* per octave, from 1/16 px on */
uint pack_width(float px) { return px > 0.0 ? uint(clamp((log2(px) + 4.0) * WIDTH_STEPS + 1.5, 1.0, 255.0)) : 0u; }
float unpack_width(uint code) { return code == 0u ? 0.0 : exp2((float(code) - 1.0) / WIDTH_STEPS - 4.0); }

/* random: [0, 1), decides the rounding, so that averages survive 8 bits. 0 and 1 stay what they are. */
uint pack_byte(float v, float random) { return uint(clamp(v, 0.0, 1.0) * 255.0 + random); }
float byte_of(uint word, int shift) { return fraction_of(shift < 15 ? word << (15 - shift) : word >> (shift - 15), 0x7f8000u) * (256.0 / 255.0); }   /* 0 and 255: exact */

/* random: [0, 1), decides the rounding, so that high ages are reached. Codes are twice the root: 1/4 to 56 frames. */
uint pack_age(float frames, float random) { return min(uint(2.0 * sqrt(frames) + random), 15u); }
float unpack_age(uint code) { return 0.25 * float(code * code); }

/* Of a pixel that has been in penumbrae for `age` frames, how many count. An edge that moves by its penumbra's width every few frames has no
   noise that a longer history would average, and so few rays around it that clamp_history() cannot tell the lag: a narrow penumbra gets a
   short history, none below 0.3 px; unlimited, edges of thin things that move have half as much error again. What has stayed for long moves
   slowly: its length grows by FRAMES_PER_AGE; less of it and what stands still flickers, more and what starts to move lags. */
const float FRAMES_PER_PX = 2.0;
const float FRAMES_PER_AGE = 0.125;
float history_length(float age, float width_px)
{
    float most = max(smoothstep(0.3, 1.0, width_px) * FRAMES_PER_PX * width_px, smoothstep(0.25, 0.5, width_px) * FRAMES_PER_AGE * age);
    return min(min(age, most), g.max_accumulated_frames);
}

uvec2 pack_mean(uint depth, Visibility v, float random, uint age, float width_px, float stabilized)
{
    uint rest = depth | (age << 20) | (pack_width(width_px) << 24);
#ifdef TRANSLUCENCY
    return uvec2(rest | (pack_byte(v.x, random) << 12), pack_byte(v.y, random) | (pack_byte(v.z, random) << 8) | (pack_byte(stabilized, 0.5) << 16));
#else
    return uvec2(rest | (pack_byte(v, random) << 12), 0u);
#endif
}

Visibility visibility_of(uvec2 word)
{
#ifdef TRANSLUCENCY
    return vec3(byte_of(word.x, 12), byte_of(word.y, 0), byte_of(word.y, 8));
#else
    return byte_of(word.x, 12);
#endif
}
uint mean_age_code(uvec2 word) { return (word.x >> 20) & 15u; }
float mean_width_px(uvec2 word) { return unpack_width(word.x >> 24); }
/* Of any width but 0. */
float mean_log_width(uvec2 word) { return raised_fraction(word.x >> 9, 0x7f8000u) * (256.0 / WIDTH_STEPS) - (257.0 / WIDTH_STEPS + 4.0); }

uvec2 pack_history(uvec2 mean, uint stabilized) { return uvec2((mean.x & 0xfffffu) | (stabilized << 20) | (mean_age_code(mean) << 28), mean.y & 0xffffu); }
uvec2 pack_ray_history(uvec2 mean) { return pack_history(mean, mean.x >> 24); }
uint history_age_code(uvec2 word) { return word.x >> 28; }
/* Frames in the mean, at least 1. */
float mean_frames(uvec2 word) { return 1.0 + history_length(max(unpack_age(mean_age_code(word)) - 1.0, 0.0), mean_width_px(word)); }
float history_stabilized(uvec2 word) { return mix(byte_of(word.x, 20), luma_of(visibility_of(word)), history_age_code(word) == 0u); }
float history_width_px(uvec2 word)
{
    float width = exp2(raised_fraction(word.x >> 5, 0x7f8000u) * (256.0 / WIDTH_STEPS) - (257.0 / WIDTH_STEPS + 4.0));
    return mix(mix(0.0, width, (word.x & 0xff00000u) != 0u), WIDTH_ANY, history_age_code(word) != 0u);
}
float history_age(uvec2 word)   /* unpack_age() of its code */
{
    float sixteenth = fraction_of(word.x >> 9, 0x780000u);
    return 64.0 * sixteenth * sixteenth;
}
/* Where no penumbra was near: of any depth, no frames. */
uvec2 uniform_history(bool lit) { return uvec2(DEPTH_NONE | 0xff00000u | (lit ? 0xff000u : 0u), lit ? 0xffffu : 0u); }

/* ---- tiles, bits: penumbra in this frame; its history has to be written; its rays reach the light */
const uint TILE_ACTIVE = 1u;
const uint TILE_STALE = 2u;
const uint TILE_LIT = 4u;
/* Kinds of rays in a tile, a bit for each quarter of it, row by row: of lit rays; blocked; blocked and coloured. */
const uint KIND_LIT = 1u;
const uint KIND_BLOCKED = 1u << 4;
const uint KIND_COLORED = 1u << 8;
uint unpack_tile(float texel) { return uint(texel * 255.0 + 0.5); }

/* ---- the light's view of a surface. The surface around a pixel is taken as the plane through it. For offsets in pixels from there:
   the distance along the light and the square of the distance perpendicular to it, which is what a penumbra's width is measured in. */
struct LightFrame {
    vec3 across;    /* perpendicular^2 = across.x x^2 + 2 across.y x y + across.z y^2 */
    vec2 along;     /* distance towards the light */
    vec2 deeper;    /* growth of the depth */
    vec2 deepening; /* likewise, relative; 0 in orthographic views */
    float facing;   /* cos of the angle between normal and line of sight, times the length of the latter for a depth of 1 */
    float pixel;    /* size of a pixel, facing the camera */
};

const float LEAST_FACING = 0.05;   /* cos of the steepest angle to the line of sight that is believed */

/* Unit vector to the light; the normal where the light is unknown, so that distances are those in the surface. */
vec3 to_light(vec3 position_vs, vec3 normal_vs)
{
    vec3 l = g.light.xyz - position_vs * g.light.w;
    float squared = dot(l, l);
    return squared > 0.0 ? l * inversesqrt(squared) : normal_vs;
}

/* What part of its diameter it has moved by since the frame before. */
float light_shift() { return g.jitter_delta.z; }

LightFrame make_light_frame(vec3 position_vs, vec3 normal_vs)
{
    LightFrame f;
    vec3 ray = vec3(position_vs.xy / position_vs.z * (1.0 - g.orthographic), 1.0), l = to_light(position_vs, normal_vs);
    float facing = dot(normal_vs, ray), least = LEAST_FACING * length(ray);
    facing = abs(facing) < least ? (facing < 0.0 ? -least : least) : facing;
    vec2 step = g.frustum.zw / g.rect_px.xy * mix(position_vs.z, 1.0, g.orthographic);
    f.facing = facing;
    f.deeper = -step * normal_vs.xy / facing;
    vec3 x = vec3(step.x, 0.0, 0.0) + ray * f.deeper.x, y = vec3(0.0, step.y, 0.0) + ray * f.deeper.y;
    f.along = vec2(dot(x, l), dot(y, l));
    f.across = vec3(dot(x, x), dot(x, y), dot(y, y)) - vec3(f.along.x * f.along.x, f.along.x * f.along.y, f.along.y * f.along.y);
    f.deepening = f.deeper / position_vs.z * (1.0 - g.orthographic);
    f.pixel = abs(step.y);
    return f;
}

/* Depth of a point of the plane, relative to the centre's; offset: its distance in pixels at the centre's depth. It is seen at offset / this. */
float relative_depth(LightFrame f, vec2 offset) { return max(1.0 + dot(f.deepening, offset), 0.1); }

/* across: as in LightFrame. */
float across_squared(vec3 across, vec2 offset)
{
    return max(across.x * offset.x * offset.x + (2.0 * across.y * offset.x + across.z * offset.y) * offset.y, 0.0);
}

/* A number of the depth that is linear over the picture on every plane: its reciprocal, or itself in orthographic views. Its own inverse. */
float nearness(float z) { return mix(1.0 / z, z, g.orthographic); }

/* The plane through a surface, of whose points a pixel knows the nearness. */
struct NearnessPlane {
    vec3 at;          /* nearness at an offset in pixels = x + y * offset.x + z * offset.y */
    vec2 tolerance;   /* of one that is off by the tolerated distance = x * nearness + y */
};

NearnessPlane make_nearness_plane(LightFrame f, float z, float distance)
{
    float near = nearness(z), flat_distance = distance / abs(f.facing);
    NearnessPlane p;
    p.at = vec3(near, f.deeper * mix(-near * near, 1.0, g.orthographic));
    p.tolerance = vec2(min(flat_distance * near, 0.9) * (1.0 - g.orthographic), flat_distance * g.orthographic);
    return p;
}

bool is_on_plane(NearnessPlane p, float expected, float nearness) { return abs(nearness - expected) <= p.tolerance.x * nearness + p.tolerance.y; }

vec3 load_normal_vs(sampler2D normal_roughness, ivec2 pixel)
{
    vec4 texel = texelFetch(normal_roughness, pixel + rect_origin(), 0);
    return nrd_decode_normal_roughness(texel, SPEC_NORMAL_FORMAT, SPEC_ROUGHNESS_FORMAT).normal * mat3(g.view_to_world);
}

float random_of(ivec2 pixel, uint salt) { return float(hash(uint(pixel.x) + salt * 0x632be5abu, uint(pixel.y), g.frame_index) >> 8) / 16777216.0; }

#endif
