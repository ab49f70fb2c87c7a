// shader_math.h: what the test_shader_*.c programs and shader_math.comp share. Valid C and valid GLSL: macros only.
//
// One case of an operation is SM_INPUTS floats in and SM_OUTPUTS floats out; shader_math.glsl says what they are.

#ifndef TESTS_SHADER_MATH_H
#define TESTS_SHADER_MATH_H

#define SM_INPUTS 48  // floats per case
#define SM_OUTPUTS 8  // floats per case
#define SM_GROUP 64   // cases per workgroup
#define SM_WIDTH 256  // texels per row of the images; case i is texel (i mod SM_WIDTH, i / SM_WIDTH)

#define SM_IS_FINITE 0
#define SM_SANITIZE 1
#define SM_ROUND_TO_HALF 2

#define SM_ENCODE_NORMAL_ROUGHNESS 10
#define SM_DECODE_NORMAL_ROUGHNESS 11
#define SM_PACK_DEFAULTS 12
#define SM_STRAND 13

#define SM_TRIM_HIT_DIST 20
#define SM_SPECULAR_AVERAGE 21
#define SM_DIFFUSE_AVERAGE 22
#define SM_MIX_DIFFUSE_HIT_DIST 23
#define SM_PATH_HIT_DIST 24
#define SM_ROUGHNESS_CURVE 25
#define SM_HIT_DIST_SCALE 26
#define SM_NORMALIZE_HIT_DIST 27

#define SM_RGB_TO_YCOCG 30
#define SM_YCOCG_TO_RGB 31
#define SM_PACK_RADIANCE 32
#define SM_UNPACK_RADIANCE 33
#define SM_PACK_RELAX 34
#define SM_UNPACK_RELAX 35

#define SM_ALBEDO_RF0 40
#define SM_ENVIRONMENT_TERM 41
#define SM_MATERIAL_FACTORS 42
#define SM_DEMODULATE 43

#define SM_CLIP_TO_UV 50
#define SM_MOTION 51
#define SM_MOTION_OF_POINTS 52
#define SM_MIRROR 53

#define SM_PACK_SH 60
#define SM_PACK_RELAX_SH 61
#define SM_SG_COLOR 62
#define SM_SG_DIRECTION 63
#define SM_SG_ROTATE 64
#define SM_ROUGHNESS_AA 65
#define SM_RESOLVE_DIFFUSE 66
#define SM_RESOLVE_SPECULAR 67
#define SM_RESOLVE_FIRST_ORDER 68
#define SM_DOMINANT_DIRECTION 69
#define SM_REJITTER 70
#define SM_PACK_OCCLUSION 71
#define SM_UNPACK_OCCLUSION 72

#define SM_PENUMBRA 75
#define SM_LIGHT_SUM 76

#define SM_LOBE_PROBABILITY 80
#define SM_SPLIT_THRESHOLD 81
#define SM_CHECKERBOARD 82
#define SM_HALF_RESOLUTION 83
#define SM_UPSAMPLE 84

// On the device only: with images.
#define SM_DECODE_IMAGE 90
#define SM_STORE_HALF 91

#endif
