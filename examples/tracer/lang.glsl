// One text, two languages: what lets the path tracer's maths compile as C99 and as GLSL.
//
// Rules of the common subset: vectors are indexed (v[0]), never swizzled; literals carry the suffix f or u; structs are
// declared with PT_STRUCT and filled member by member; conversions go through TO_FLOAT and TO_UINT; functions open with
// PT_FN and, when they read the scene, take PT_SCENE as first parameter and pass PT_S on.

#ifndef TRACER_LANG_GLSL
#define TRACER_LANG_GLSL

#ifdef VULKAN // GLSL

#define PT_STRUCT(name) struct name
#define PT_FN
#define PT_SCENE
#define PT_S
#define TO_FLOAT(x) float(x)
#define TO_UINT(x) uint(x)

float max3(vec3 v) { return max(v[0], max(v[1], v[2])); }

#else // C

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <tgmath.h>

typedef float vec2 __attribute__((vector_size(8)));
typedef float vec4 __attribute__((vector_size(16)));
typedef vec4 vec3; // the fourth lane is unused

#define vec2(x, y) ((vec2){ (x), (y) })
#define vec3(x, y, z) ((vec3){ (x), (y), (z), 0.0f })
#define vec4(x, y, z, w) ((vec4){ (x), (y), (z), (w) })
#define uint uint32_t

#define PT_STRUCT(name)       \
    typedef struct name name; \
    struct name
#define PT_FN static inline
#define PT_SCENE const struct pt_scene *pt,
#define PT_S pt,
#define TO_FLOAT(x) ((float)(x))
#define TO_UINT(x) ((uint)(x))

static inline float min(float a, float b) { return a < b ? a : b; }
static inline float max(float a, float b) { return a > b ? a : b; }
static inline float clamp(float x, float low, float high) { return min(max(x, low), high); }
static inline float fract(float x) { return x - floorf(x); }
static inline float max3(vec3 v) { return max(v[0], max(v[1], v[2])); }
static inline float dot(vec3 a, vec3 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static inline float length(vec3 v) { return sqrtf(dot(v, v)); }
static inline vec3 normalize(vec3 v) { return v * (1.0f / length(v)); }
static inline vec3 reflect(vec3 v, vec3 n) { return v - n * (2.0f * dot(n, v)); }

static inline vec3 cross(vec3 a, vec3 b)
{
    return vec3(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

static inline float smoothstep(float low, float high, float x)
{
    float t = clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

static inline uint bitfieldReverse(uint x)
{
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    return x >> 16 | x << 16;
}

#endif

// GLSL's mix() takes vectors too; C has no overloads, so both languages use these.
PT_FN float abs1(float x) { return x < 0.0f ? -x : x; }
PT_FN float lerp1(float a, float b, float t) { return a + (b - a) * t; }
PT_FN vec3 lerp3(vec3 a, vec3 b, float t) { return a + (b - a) * t; }
PT_FN vec3 grey(float x) { return vec3(x, x, x); }
PT_FN vec3 xyz_of(vec4 v) { return vec3(v[0], v[1], v[2]); }
PT_FN float luminance(vec3 c) { return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2]; }

#endif
