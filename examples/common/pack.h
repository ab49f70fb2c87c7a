/* pack.h: texels of the denoisers' inputs and outputs, packed on the CPU by the functions of nrd_shaders/nrd.glsl, in the
   formats an engine would use; what a shader would round, is rounded to nearest here. */
#ifndef EXAMPLES_PACK_H
#define EXAMPLES_PACK_H

#include <stdint.h>

/* nrd_pack_normal_roughness with the encodings RGB10A2_UNORM and LINEAR: a texel of VK_FORMAT_A2B10G10R10_UNORM_PACK32.
   The normal is in world space and has unit length; roughness is linear, [0,1]; material ids above 3 become 3. */
uint32_t pack_normal_roughness(const float normal[3], float roughness, uint32_t material_id);

/* nrd_normalize_hit_dist, 4-parameter form: hit_dist and view_z in world units, parameters A, B, C, D. 0 stays exactly 0
   ("not sampled"), 65504 and more (a miss) becomes 1, NaN and negative values become 0. */
float pack_normalize_hit_dist(float hit_dist, float view_z, float roughness, const float parameters[4]);

/* nrd_pack_radiance_hit_dist with sanitising: an RGBA16F texel (Y, Co, Cg, normalised hit distance). NaN or Inf in any
   channel make the colour black, negative values 0. */
void pack_radiance_hit_dist(const float rgb[3], float norm_hit_dist, uint16_t texel[4]);

/* nrd_pack_sh with sanitising: two RGBA16F texels. direction: unit length, world space. */
void pack_sh(const float rgb[3], float norm_hit_dist, const float direction[3], uint16_t sh0[4], uint16_t sh1[4]);

/* nrd_sg_resolved_color of a denoised pair: RGB, each >= 0, and w of the first texel. */
void pack_unpack_sh(const uint16_t sh0[4], const uint16_t sh1[4], float rgbw[4]);

/* nrd_pack_penumbra as an R16F texel: half width of the penumbra, units. occluder_dist in units: 0 (faces away) and NaN give
   0, 65504 and more (the ray reached the light) 65504. */
uint16_t pack_penumbra(float occluder_dist, float tan_angular_radius);

/* nrd_pack_local_penumbra as an R16F texel; light_dist and light_radius in units. */
uint16_t pack_local_penumbra(float occluder_dist, float light_dist, float light_radius);

/* nrd_pack_translucency as an RGBA8 texel. */
void pack_translucency(float occluder_dist, const float transmission[3], uint8_t texel[4]);

/* nrd_checkerboard_x. */
uint32_t pack_checkerboard_x(uint32_t texel_x, uint32_t y, uint32_t frame_index, uint32_t color);

/* nrd_unpack_shadow of an R8 texel: visibility, [0,1]. */
float pack_unpack_shadow(uint8_t texel);

/* nrd_unpack_radiance_hit_dist: RGB, each >= 0, and w. */
void pack_unpack_radiance_hit_dist(const uint16_t texel[4], float rgbw[4]);

#endif
