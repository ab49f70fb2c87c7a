// shader_math.h: what test_shader_math.c and shader_math.comp share. Valid C and valid GLSL: macros only.
//
// One case of an operation is SM_INPUTS floats in and SM_OUTPUTS floats out; shader_math.comp says what they are.

#ifndef TESTS_SHADER_MATH_H
#define TESTS_SHADER_MATH_H

#define SM_INPUTS 16  // floats per case
#define SM_OUTPUTS 8  // floats per case
#define SM_GROUP 64   // cases per workgroup
#define SM_WIDTH 256  // texels per row of the images; case i is texel (i mod SM_WIDTH, i / SM_WIDTH)

#define SM_IS_FINITE 0
#define SM_SANITIZE 1
#define SM_ROUND_TO_HALF 2
#define SM_ENCODE_NORMAL_ROUGHNESS 3
#define SM_DECODE_NORMAL_ROUGHNESS 4
#define SM_PACK_DEFAULTS 5
#define SM_TRIM_HIT_DIST 6
#define SM_SPECULAR_AVERAGE 7
#define SM_DIFFUSE_AVERAGE 8
#define SM_MIX_DIFFUSE_HIT_DIST 9
#define SM_ROUGHNESS_CURVE 10
#define SM_HIT_DIST_SCALE 11
#define SM_NORMALIZE_HIT_DIST 12
#define SM_RGB_TO_YCOCG 13
#define SM_YCOCG_TO_RGB 14
#define SM_PACK_RADIANCE 15
#define SM_UNPACK_RADIANCE 16
#define SM_ALBEDO_RF0 17
#define SM_ENVIRONMENT_TERM 18
#define SM_MATERIAL_FACTORS 19
#define SM_DEMODULATE 20
#define SM_CLIP_TO_UV 21
#define SM_MOTION 22
#define SM_DECODE_IMAGE 23
#define SM_STORE_HALF 24

#endif
