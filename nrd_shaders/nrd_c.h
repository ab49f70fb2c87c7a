/* nrd_c.h: the functions of nrd.glsl for C99 and C++, from the same text.

   #include "nrd_c.h" in any source file, with nrd.glsl beside it. Every function is static inline and has the name, the
   parameters and the contract that nrd.glsl gives it; options (NRD_NORMAL_FORMAT, ...) are defined before the include, as
   there. In place of GLSL's types stand nrd_vec2, nrd_vec3, nrd_vec4 (members x, y, z, w) and nrd_mat4 (four columns: the
   layout of float[16] as nrd.h takes it); nrd_make_vec3(x, y, z) and so on build them. `out` parameters are pointers.
   C has no overloads: the scalar nrd_is_finite and nrd_round_to_half and the uv form of nrd_motion_2_5d are there.
   A file of your own, written in the same common part of GLSL and C (see nrd.glsl), is compiled along if NRD_C_ALSO is defined
   as its name, quotes included. No macro with a GLSL name outlives this header. Needs the standard library's math functions. */
#ifndef NRD_C_H
#define NRD_C_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef struct nrd_vec2 { float x, y; } nrd_vec2;
typedef struct nrd_vec3 { float x, y, z; } nrd_vec3;
typedef struct nrd_vec4 { float x, y, z, w; } nrd_vec4;
typedef struct nrd_mat4 { nrd_vec4 column[4]; } nrd_mat4;

static inline nrd_vec2 nrd_make_vec2(float x, float y)
{
    nrd_vec2 v;
    v.x = x, v.y = y;
    return v;
}

static inline nrd_vec3 nrd_make_vec3(float x, float y, float z)
{
    nrd_vec3 v;
    v.x = x, v.y = y, v.z = z;
    return v;
}

static inline nrd_vec4 nrd_make_vec4(float x, float y, float z, float w)
{
    nrd_vec4 v;
    v.x = x, v.y = y, v.z = z, v.w = w;
    return v;
}

/* ---- the part of GLSL's library that nrd.glsl uses ------------------------------------------------------------- */
static inline float nrdi_c_min(float a, float b) { return b < a ? b : a; }
static inline float nrdi_c_max(float a, float b) { return b > a ? b : a; }
static inline float nrdi_c_clamp(float x, float low, float high) { return x > low ? (x < high ? x : high) : low; }
static inline float nrdi_c_mix(float a, float b, float t) { return a * (1.0f - t) + b * t; }

static inline uint32_t nrdi_c_bits(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static inline float nrdi_c_float(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

#define NRDI_C
#define NRDI_FN static inline
#define NRDI_STRUCT(name) typedef struct name name; struct name
#define NRDI_RESULT(type) type *
#define NRDI_TO(name) (*(name))
#define NRDI_UINT(x) ((uint32_t)(x))
#define NRDI_FLOAT(x) ((float)(x))

#pragma push_macro("vec2")
#pragma push_macro("vec3")
#pragma push_macro("vec4")
#pragma push_macro("mat4")
#pragma push_macro("uint")
#pragma push_macro("precise")
#pragma push_macro("min")
#pragma push_macro("max")
#pragma push_macro("clamp")
#pragma push_macro("mix")
#pragma push_macro("abs")
#pragma push_macro("sqrt")
#pragma push_macro("exp")
#pragma push_macro("exp2")
#pragma push_macro("log")
#pragma push_macro("pow")
#pragma push_macro("floor")
#pragma push_macro("inversesqrt")
#pragma push_macro("roundEven")
#pragma push_macro("floatBitsToUint")
#pragma push_macro("uintBitsToFloat")
#undef vec2
#undef vec3
#undef vec4
#undef mat4
#undef uint
#undef precise
#undef min
#undef max
#undef clamp
#undef mix
#undef abs
#undef sqrt
#undef exp
#undef exp2
#undef log
#undef pow
#undef floor
#undef inversesqrt
#undef roundEven
#undef floatBitsToUint
#undef uintBitsToFloat

/* As a type vec3 is nrd_vec3, and before a parenthesis, as a constructor, nrd_make_vec3. */
#define vec2 nrd_vec2
#define vec3 nrd_vec3
#define vec4 nrd_vec4
#define nrd_vec2(x, y) nrd_make_vec2(x, y)
#define nrd_vec3(x, y, z) nrd_make_vec3(x, y, z)
#define nrd_vec4(x, y, z, w) nrd_make_vec4(x, y, z, w)
#define mat4 nrd_mat4
#define uint uint32_t
#define precise
#define min(a, b) nrdi_c_min(a, b)
#define max(a, b) nrdi_c_max(a, b)
#define clamp(x, low, high) nrdi_c_clamp(x, low, high)
#define mix(a, b, t) nrdi_c_mix(a, b, t)
#define abs(x) fabsf(x)
#define sqrt(x) sqrtf(x)
#define exp(x) expf(x)
#define exp2(x) exp2f(x)
#define log(x) logf(x)
#define pow(x, y) powf(x, y)
#define floor(x) floorf(x)
#define inversesqrt(x) (1.0f / sqrtf(x))
#define roundEven(x) nearbyintf(x)
#define floatBitsToUint(x) nrdi_c_bits(x)
#define uintBitsToFloat(x) nrdi_c_float(x)

#include "nrd.glsl"
#ifdef NRD_C_ALSO
#include NRD_C_ALSO
#endif

#undef nrd_vec2
#undef nrd_vec3
#undef nrd_vec4
#undef NRDI_C
#undef NRDI_FN
#undef NRDI_STRUCT
#undef NRDI_RESULT
#undef NRDI_TO
#undef NRDI_UINT
#undef NRDI_FLOAT
#pragma pop_macro("vec2")
#pragma pop_macro("vec3")
#pragma pop_macro("vec4")
#pragma pop_macro("mat4")
#pragma pop_macro("uint")
#pragma pop_macro("precise")
#pragma pop_macro("min")
#pragma pop_macro("max")
#pragma pop_macro("clamp")
#pragma pop_macro("mix")
#pragma pop_macro("abs")
#pragma pop_macro("sqrt")
#pragma pop_macro("exp")
#pragma pop_macro("exp2")
#pragma pop_macro("log")
#pragma pop_macro("pow")
#pragma pop_macro("floor")
#pragma pop_macro("inversesqrt")
#pragma pop_macro("roundEven")
#pragma pop_macro("floatBitsToUint")
#pragma pop_macro("uintBitsToFloat")

#endif
