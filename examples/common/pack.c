#include "common/pack.h"

#include "common/half.h"

#define NRD_NORMAL_FORMAT NRD_NORMAL_FORMAT_RGB10A2_UNORM
#define NRD_ROUGHNESS_FORMAT NRD_ROUGHNESS_FORMAT_LINEAR
#define NRD_HIT_DIST_FORM NRD_HIT_DIST_FORM_4_PARAMETERS
#include "nrd_shaders/nrd_c.h"

static nrd_vec3 vec3_of(const float v[3])
{
    return nrd_make_vec3(v[0], v[1], v[2]);
}

static void put_vec4(nrd_vec4 t, uint16_t texel[4])
{
    const float packed[4] = { t.x, t.y, t.z, t.w };
    half_from_floats(texel, packed, 4);
}

static nrd_vec4 vec4_of(const uint16_t texel[4])
{
    return nrd_make_vec4(half_to_float(texel[0]), half_to_float(texel[1]), half_to_float(texel[2]), half_to_float(texel[3]));
}

/* x in [0,1] as a code of that many steps, to nearest. */
static uint32_t unorm(float x, float steps)
{
    return (uint32_t)(x * steps + 0.5f);
}

uint32_t pack_normal_roughness(const float normal[3], float roughness, uint32_t material_id)
{
    nrd_vec4 t = nrd_pack_normal_roughness(vec3_of(normal), roughness, material_id);
    return unorm(t.x, 1023) | unorm(t.y, 1023) << 10 | unorm(t.z, 1023) << 20 | unorm(t.w, 3) << 30;
}

float pack_normalize_hit_dist(float hit_dist, float view_z, float roughness, const float parameters[4])
{
    nrd_vec4 p = nrd_make_vec4(parameters[0], parameters[1], parameters[2], parameters[3]);
    return nrd_normalize_hit_dist(hit_dist, view_z, roughness, p);
}

void pack_radiance_hit_dist(const float rgb[3], float norm_hit_dist, uint16_t texel[4])
{
    put_vec4(nrd_pack_radiance_hit_dist(vec3_of(rgb), norm_hit_dist, true), texel);
}

void pack_sh(const float rgb[3], float norm_hit_dist, const float direction[3], uint16_t sh0[4], uint16_t sh1[4])
{
    nrd_vec4 first, second;
    nrd_pack_sh(vec3_of(rgb), norm_hit_dist, vec3_of(direction), true, &first, &second);
    put_vec4(first, sh0);
    put_vec4(second, sh1);
}

void pack_unpack_sh(const uint16_t sh0[4], const uint16_t sh1[4], float rgbw[4])
{
    nrd_sg sg = nrd_unpack_sh(vec4_of(sh0), vec4_of(sh1));
    nrd_vec3 rgb = nrd_sg_resolved_color(sg);
    rgbw[0] = rgb.x, rgbw[1] = rgb.y, rgbw[2] = rgb.z, rgbw[3] = sg.hit_dist;
}

uint16_t pack_penumbra(float occluder_dist, float tan_angular_radius)
{
    return half_from_float(nrd_pack_penumbra(occluder_dist, tan_angular_radius));
}

uint16_t pack_local_penumbra(float occluder_dist, float light_dist, float light_radius)
{
    return half_from_float(nrd_pack_local_penumbra(occluder_dist, light_dist, light_radius));
}

void pack_translucency(float occluder_dist, const float transmission[3], uint8_t texel[4])
{
    nrd_vec4 t = nrd_pack_translucency(occluder_dist, vec3_of(transmission));
    texel[0] = (uint8_t)unorm(t.x, 255), texel[1] = (uint8_t)unorm(t.y, 255);
    texel[2] = (uint8_t)unorm(t.z, 255), texel[3] = (uint8_t)unorm(t.w, 255);
}

uint32_t pack_checkerboard_x(uint32_t texel_x, uint32_t y, uint32_t frame_index, uint32_t color)
{
    return nrd_checkerboard_x(texel_x, y, frame_index, color);
}

float pack_unpack_shadow(uint8_t texel)
{
    return nrd_unpack_shadow((float)texel / 255.0f);
}

void pack_unpack_radiance_hit_dist(const uint16_t texel[4], float rgbw[4])
{
    nrd_vec4 t = nrd_unpack_radiance_hit_dist(vec4_of(texel));
    rgbw[0] = t.x, rgbw[1] = t.y, rgbw[2] = t.z, rgbw[3] = t.w;
}
