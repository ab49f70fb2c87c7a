// What an engine's ray generation shader does for the denoiser, with the helpers of nrd.glsl: traces the primary surface
// through mirrors, one path of diffuse light from there, and writes the denoiser's inputs. Included by primary.rgen and
// by loop.comp, which define trace() and is_visible().
#ifndef RAYGEN_PATH_GLSL
#define RAYGEN_PATH_GLSL

#include "nrd.glsl"
#include "scene.glsl"

layout(set = 0, binding = RAYGEN_BIND_MV, rgba16f) writeonly uniform image2D in_mv;
layout(set = 0, binding = RAYGEN_BIND_NORMAL_ROUGHNESS, rgba16f) writeonly uniform image2D in_normal_roughness;
layout(set = 0, binding = RAYGEN_BIND_VIEWZ, r32f) writeonly uniform image2D in_viewz;
layout(set = 0, binding = RAYGEN_BIND_DIFF, rgba16f) writeonly uniform image2D in_diff_radiance_hitdist;
layout(set = 0, binding = RAYGEN_BIND_FACTOR, rgba16f) writeonly uniform image2D out_factor;
layout(set = 0, binding = RAYGEN_BIND_EMISSION, rgba16f) writeonly uniform image2D out_emission;

hit_info trace(vec3 origin, vec3 direction);
bool is_visible(vec3 origin, vec3 direction, float t_max);

#define SURFACE_OFFSET 1e-3 // metres; rays start this far above a surface
#define MAX_MIRRORS 4
#define MAX_BOUNCES 4
#define MIRROR 1.0
#define LAMP 2.0

// ---- random numbers: PCG (O'Neill 2014)
uint random_state;

void seed_random(uvec2 pixel, uint path)
{
    random_state = (pixel.y * frame.width + pixel.x) * 9781u + frame.frame_index * 6271u + frame.seed * 26699u + path * 7919u;
}

float random()
{
    random_state = random_state * 747796405u + 2891336453u;
    uint word = ((random_state >> ((random_state >> 28u) + 4u)) ^ random_state) * 277803737u;
    return float(((word >> 22u) ^ word) >> 8u) / 16777216.0;
}

// Cosine-weighted direction about n.
vec3 random_diffuse(vec3 n)
{
    float z = 2.0 * random() - 1.0;
    float angle = 6.2831853 * random();
    vec3 on_sphere = vec3(sqrt(max(1.0 - z * z, 0.0)) * vec2(cos(angle), sin(angle)), z);
    return normalize(n * 1.0001 + on_sphere);
}

// ---- light
// Light of the lamp that a white matte surface sends back: one random point of it. distance: to that point, metres.
vec3 lamp_light(vec3 position, vec3 normal, out float distance)
{
    vec3 to_lamp = frame.lamp.xyz - position;
    to_lamp.xz += frame.lamp_half.xz * (2.0 * vec2(random(), random()) - 1.0);
    distance = length(to_lamp);
    vec3 direction = to_lamp / distance;
    float cosines = max(dot(normal, direction), 0.0) * max(direction.y, 0.0);
    if (cosines == 0.0 || !is_visible(position + normal * SURFACE_OFFSET, direction, distance - 2.0 * SURFACE_OFFSET))
        return vec3(0.0);
    float area = 4.0 * frame.lamp_half.x * frame.lamp_half.z;
    return frame.lamp_radiance.rgb * (cosines * area / (distance * distance * 3.14159265));
}

// Indirect light of one path from a matte surface, and the distance at which it seems to come from. The lamp, met by a
// ray, counts only behind mirrors: lamp_light() has the rest.
vec3 indirect_light(vec3 position, vec3 normal, out float hit_dist)
{
    vec3 light = vec3(0.0);
    vec3 weight = vec3(1.0);
    vec3 direction = random_diffuse(normal);
    vec2 path = nrd_path_hit_dist_begin();
    bool behind_mirror = false;
    position += normal * SURFACE_OFFSET;
    for (int bounce = 0; bounce < MAX_BOUNCES; bounce++) {
        hit_info hit = trace(position, direction);
        if (hit.t < 0.0) {
            light += weight * frame.sky.rgb;
            path = nrd_path_hit_dist_add(path, NRD_HIT_DIST_MISS, 1.0);
            break;
        }
        vec4 color = boxes[hit.box_index].color;
        path = nrd_path_hit_dist_add(path, nrd_trim_hit_dist(hit.t, SURFACE_OFFSET), color.w == MIRROR ? 0.0 : 1.0);
        position += direction * hit.t + hit.normal * SURFACE_OFFSET;
        if (color.w == LAMP) {
            light += behind_mirror ? weight * frame.lamp_radiance.rgb : vec3(0.0);
            break;
        }
        weight *= color.rgb;
        behind_mirror = color.w == MIRROR;
        if (behind_mirror) {
            direction = reflect(direction, hit.normal);
        } else {
            float distance;
            light += weight * lamp_light(position, hit.normal, distance);
            direction = random_diffuse(hit.normal);
        }
    }
    hit_dist = nrd_path_hit_dist_end(path);
    return light;
}

// ---- outputs
void store_guides(ivec2 pixel, vec3 motion, vec3 normal, float view_z)
{
    vec4 normal_roughness = nrd_encode_normal_roughness(normal, 1.0, 0u, NRD_NORMAL_FORMAT_RGBA16_SNORM,
                                                        NRD_ROUGHNESS_FORMAT_LINEAR);
    imageStore(in_mv, pixel, nrd_round_to_half(vec4(motion, 0.0)));
    imageStore(in_normal_roughness, pixel, nrd_round_to_half(normal_roughness));
    imageStore(in_viewz, pixel, vec4(view_z));
}

void store_light(ivec2 pixel, vec4 radiance_hit_dist, vec3 factor, vec3 emission)
{
    imageStore(in_diff_radiance_hitdist, pixel, nrd_round_to_half(radiance_hit_dist));
    imageStore(out_factor, pixel, vec4(factor, 0.0));
    imageStore(out_emission, pixel, vec4(emission, 0.0));
}

// The mean of all paths: the texel that the denoiser reads.
vec4 diffuse_texel(uvec2 pixel, vec3 position, vec3 normal, vec3 albedo, float view_z, vec3 factor)
{
    vec3 radiance = vec3(0.0);
    vec2 mean = nrd_diffuse_hit_dist_begin();
    for (uint path = 0u; path < frame.paths; path++) {
        seed_random(pixel, path);
        float lamp_distance, hit_dist;
        vec3 direct = lamp_light(position, normal, lamp_distance);
        vec3 indirect = indirect_light(position, normal, hit_dist);
        if (!nrd_is_finite(direct + indirect))
            continue;
        radiance += (direct + indirect) / float(frame.paths);
        hit_dist = nrd_mix_diffuse_hit_dist(hit_dist, lamp_distance, nrd_luma(indirect), nrd_luma(direct));
        mean = nrd_diffuse_hit_dist_add(mean, nrd_normalize_hit_dist(hit_dist, view_z, 1.0, frame.hit_dist_params));
    }
    return nrd_pack_radiance_hit_dist(nrd_demodulate(radiance * albedo, factor), nrd_diffuse_hit_dist_end(mean), true);
}

void trace_pixel(uvec2 pixel)
{
    vec2 uv = (vec2(pixel) + 0.5) / vec2(frame.width, frame.height);
    vec3 direction = normalize(frame.forward.xyz + (2.0 * uv.x - 1.0) * frame.right.xyz + (1.0 - 2.0 * uv.y) * frame.up.xyz);
    vec3 position = frame.camera.xyz;
    vec3 reflectance = vec3(1.0);
    nrd_mirror chain = nrd_mirror_begin();
    nrd_mirror chain_prev = chain;

    hit_info hit = trace(position, direction);
    for (int i = 0; i < MAX_MIRRORS && hit.t >= 0.0 && boxes[hit.box_index].color.w == MIRROR; i++) {
        box b = boxes[hit.box_index];
        position += direction * hit.t;
        vec3 in_box = transform(b.to_box_x, b.to_box_y, b.to_box_z, vec4(position, 1.0));
        vec3 position_prev = transform(b.to_world_prev_x, b.to_world_prev_y, b.to_world_prev_z, vec4(in_box, 1.0));
        vec3 normal_prev = normalize(transform(b.to_world_prev_x, b.to_world_prev_y, b.to_world_prev_z,
                                               vec4(cube_normal(in_box), 0.0)));
        chain = nrd_mirror_add(chain, position, hit.normal);
        chain_prev = nrd_mirror_add(chain_prev, position_prev, normal_prev);
        reflectance *= b.color.rgb;
        direction = reflect(direction, hit.normal);
        position += hit.normal * SURFACE_OFFSET;
        hit = trace(position, direction);
    }
    if (hit.t < 0.0) {
        store_guides(ivec2(pixel), vec3(0.0), -direction, 2.0 * frame.sky.w);
        store_light(ivec2(pixel), vec4(0.0), vec3(0.0), reflectance * frame.sky.rgb);
        return;
    }

    box b = boxes[hit.box_index];
    position += direction * hit.t;
    vec3 in_box = transform(b.to_box_x, b.to_box_y, b.to_box_z, vec4(position, 1.0));
    vec3 position_prev = transform(b.to_world_prev_x, b.to_world_prev_y, b.to_world_prev_z, vec4(in_box, 1.0));
    vec3 image = nrd_mirror_point(chain, position);
    vec3 motion = nrd_motion_of_points(image, nrd_mirror_point(chain_prev, position_prev), frame.world_to_view,
                                       frame.view_to_clip, frame.world_to_view_prev, frame.view_to_clip_prev);
    float view_z = (frame.world_to_view * vec4(image, 1.0)).z;
    store_guides(ivec2(pixel), motion, nrd_mirror_direction(chain, hit.normal), view_z);

    vec3 albedo = b.color.w == 0.0 ? b.color.rgb : vec3(0.0);
    vec3 factor, specular_factor;
    nrd_material_factors(hit.normal, -direction, albedo, vec3(0.0), 1.0, factor, specular_factor);
    vec3 emission = b.color.w == LAMP ? reflectance * frame.lamp_radiance.rgb : vec3(0.0);
    store_light(ivec2(pixel), diffuse_texel(pixel, position, hit.normal, albedo, view_z, factor), reflectance * factor, emission);
}

#endif
