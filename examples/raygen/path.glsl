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

#define SURFACE_OFFSET 1e-3 // metres; rays start this far above a surface ..
#define STRAND_OFFSET 0.04  // .. and this far from a strand, outside of it
#define MAX_MIRRORS 4
#define MAX_BOUNCES 4
#define MIRROR 1.0
#define LAMP 2.0
#define STRAND 3.0

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
// Light of the lamp that a white matte surface sends back: one random point of it. position: off the surface. distance:
// to that point, metres.
vec3 lamp_light(vec3 position, vec3 normal, out float distance)
{
    vec3 to_lamp = frame.lamp.xyz - position;
    to_lamp.xz += frame.lamp_half.xz * (2.0 * vec2(random(), random()) - 1.0);
    distance = length(to_lamp);
    vec3 direction = to_lamp / distance;
    float cosines = max(dot(normal, direction), 0.0) * max(direction.y, 0.0);
    if (cosines == 0.0 || !is_visible(position, direction, max(distance - 2.0 * SURFACE_OFFSET, 0.0)))
        return vec3(0.0);
    float area = 4.0 * frame.lamp_half.x * frame.lamp_half.z;
    return frame.lamp_radiance.rgb * (cosines * area / (distance * distance * 3.14159265));
}

// Light that a ray finds, one path, and the distance at which it seems to come from. The lamp, met by a ray, counts only
// behind mirrors: lamp_light() has the rest.
vec3 path_light(vec3 position, vec3 direction, bool behind_mirror, out float hit_dist)
{
    vec3 light = vec3(0.0);
    vec3 weight = vec3(1.0);
    vec2 path = nrd_path_hit_dist_begin();
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

// shows: RAYGEN_SHOWS_...
void store_light(ivec2 pixel, vec4 radiance_hit_dist, vec3 factor, vec3 emission, float shows)
{
    imageStore(in_diff_radiance_hitdist, pixel, nrd_round_to_half(radiance_hit_dist));
    imageStore(out_factor, pixel, vec4(factor, shows));
    imageStore(out_emission, pixel, vec4(emission, 0.0));
}

vec3 albedo_of(box b)
{
    return b.color.w == MIRROR || b.color.w == LAMP ? vec3(0.0) : b.color.rgb;
}

vec3 tangent_of(box strand)
{
    return normalize(transform(strand.to_world_x, strand.to_world_y, strand.to_world_z, vec4(0.0, 1.0, 0.0, 0.0)));
}

// A matte cylinder thinner than a pixel, seen across its width: a random normal of the side that faces the camera.
vec3 random_strand_normal(vec3 tangent, vec3 to_camera)
{
    vec3 front = nrd_strand_normal(tangent, to_camera);
    float across = 2.0 * random() - 1.0;
    return front * sqrt(max(1.0 - across * across, 0.0)) + cross(tangent, front) * across;
}

// The mean of all paths: the texel that the denoiser reads.
vec4 diffuse_texel(uvec2 pixel, box b, vec3 position, vec3 face_normal, vec3 to_camera, float view_z, vec3 factor)
{
    bool is_mixed = (frame.options & RAYGEN_MIX) != 0u;
    vec3 radiance = vec3(0.0);
    vec2 mean = nrd_diffuse_hit_dist_begin();
    for (uint path = 0u; path < frame.paths; path++) {
        seed_random(pixel, path);
        float lamp_distance, hit_dist;
        vec3 normal = b.color.w == STRAND ? random_strand_normal(tangent_of(b), to_camera) : face_normal;
        vec3 start = position + normal * (b.color.w == STRAND ? STRAND_OFFSET : SURFACE_OFFSET);
        vec3 direct = lamp_light(start, normal, lamp_distance);
        vec3 indirect = path_light(start, random_diffuse(normal), false, hit_dist);
        if (!nrd_is_finite(direct + indirect))
            continue;
        radiance += (direct + indirect) / float(frame.paths);
        if (is_mixed)
            hit_dist = nrd_mix_diffuse_hit_dist(hit_dist, lamp_distance, nrd_luma(indirect), nrd_luma(direct));
        mean = nrd_diffuse_hit_dist_add(mean, nrd_normalize_hit_dist(hit_dist, view_z, 1.0, frame.hit_dist_params));
    }
    return nrd_pack_radiance_hit_dist(nrd_demodulate(radiance * albedo_of(b), factor), nrd_diffuse_hit_dist_end(mean), true);
}

// The same for a mirror that stays the primary surface: what it shows is the signal, its reflectance the factor.
vec4 mirror_texel(uvec2 pixel, vec3 position, vec3 direction, float view_z)
{
    vec3 radiance = vec3(0.0);
    vec2 mean = nrd_diffuse_hit_dist_begin();
    for (uint path = 0u; path < frame.paths; path++) {
        seed_random(pixel, path);
        float hit_dist;
        radiance += path_light(position, direction, true, hit_dist) / float(frame.paths);
        mean = nrd_diffuse_hit_dist_add(mean, nrd_normalize_hit_dist(hit_dist, view_z, 1.0, frame.hit_dist_params));
    }
    return nrd_pack_radiance_hit_dist(radiance, nrd_diffuse_hit_dist_end(mean), true);
}

vec3 previous_position(box b, vec3 position)
{
    vec3 in_box = transform(b.to_box_x, b.to_box_y, b.to_box_z, vec4(position, 1.0));
    return transform(b.to_world_prev_x, b.to_world_prev_y, b.to_world_prev_z, vec4(in_box, 1.0));
}

vec3 motion_of(vec3 position, vec3 position_prev)
{
    return nrd_motion_of_points(position, position_prev, frame.world_to_view, frame.view_to_clip, frame.world_to_view_prev,
                                frame.view_to_clip_prev);
}

float view_z_of(vec3 position)
{
    return (frame.world_to_view * vec4(position, 1.0)).z;
}

void trace_mirror(uvec2 pixel, box b, vec3 position, vec3 normal, vec3 direction)
{
    float view_z = view_z_of(position);
    store_guides(ivec2(pixel), motion_of(position, previous_position(b, position)), normal, view_z);
    vec4 texel = mirror_texel(pixel, position + normal * SURFACE_OFFSET, reflect(direction, normal), view_z);
    store_light(ivec2(pixel), texel, b.color.rgb, vec3(0.0), RAYGEN_SHOWS_MIRROR);
}

// Moves the ray to the first surface that is no mirror and the chains of images with it. Returns the mirrors' reflectance.
vec3 pass_mirrors(inout vec3 position, inout vec3 direction, inout hit_info hit, inout nrd_mirror chain, inout nrd_mirror chain_prev)
{
    vec3 reflectance = vec3(1.0);
    for (int i = 0; i < MAX_MIRRORS && hit.t >= 0.0 && boxes[hit.box_index].color.w == MIRROR; i++) {
        box b = boxes[hit.box_index];
        position += direction * hit.t;
        vec4 in_box = vec4(transform(b.to_box_x, b.to_box_y, b.to_box_z, vec4(position, 1.0)), 1.0);
        vec4 side = vec4(cube_normal(in_box.xyz), 0.0);
        vec3 normal_prev = normalize(transform(b.to_world_prev_x, b.to_world_prev_y, b.to_world_prev_z, side));
        chain = nrd_mirror_add(chain, position, hit.normal);
        chain_prev = nrd_mirror_add(chain_prev, previous_position(b, position), normal_prev);
        reflectance *= b.color.rgb;
        direction = reflect(direction, hit.normal);
        position += hit.normal * SURFACE_OFFSET;
        hit = trace(position, direction);
    }
    return reflectance;
}

void trace_pixel(uvec2 pixel)
{
    vec2 uv = (vec2(pixel) + 0.5) / vec2(frame.width, frame.height);
    vec3 direction = normalize(frame.forward.xyz + (2.0 * uv.x - 1.0) * frame.right.xyz + (1.0 - 2.0 * uv.y) * frame.up.xyz);
    vec3 position = frame.camera.xyz;
    nrd_mirror chain = nrd_mirror_begin();
    nrd_mirror chain_prev = chain;

    hit_info hit = trace(position, direction);
    bool is_mirrored = hit.t >= 0.0 && boxes[hit.box_index].color.w == MIRROR;
    if (is_mirrored && (frame.options & RAYGEN_MIRRORS) == 0u) {
        trace_mirror(pixel, boxes[hit.box_index], position + direction * hit.t, hit.normal, direction);
        return;
    }
    vec3 reflectance = pass_mirrors(position, direction, hit, chain, chain_prev);
    if (hit.t < 0.0) {
        store_guides(ivec2(pixel), vec3(0.0), -direction, 2.0 * frame.sky.w);
        store_light(ivec2(pixel), vec4(0.0), vec3(0.0), reflectance * frame.sky.rgb, is_mirrored ? RAYGEN_SHOWS_MIRROR : RAYGEN_SHOWS_SOLID);
        return;
    }

    box b = boxes[hit.box_index];
    position += direction * hit.t;
    vec3 image = nrd_mirror_point(chain, position);
    vec3 image_prev = nrd_mirror_point(chain_prev, previous_position(b, position));
    bool is_strand = b.color.w == STRAND && (frame.options & RAYGEN_STRANDS) != 0u;
    vec3 guide_normal = is_strand ? nrd_strand_normal(tangent_of(b), -direction) : hit.normal;
    float view_z = view_z_of(image);
    store_guides(ivec2(pixel), motion_of(image, image_prev), nrd_mirror_direction(chain, guide_normal), view_z);

    vec3 factor, specular_factor;
    nrd_material_factors(guide_normal, -direction, albedo_of(b), vec3(0.0), 1.0, factor, specular_factor);
    vec3 emission = b.color.w == LAMP ? reflectance * frame.lamp_radiance.rgb : vec3(0.0);
    vec4 texel = diffuse_texel(pixel, b, position, hit.normal, -direction, view_z, factor);
    float shows = is_mirrored ? RAYGEN_SHOWS_MIRROR : b.color.w == STRAND ? RAYGEN_SHOWS_STRAND : RAYGEN_SHOWS_SOLID;
    store_light(ivec2(pixel), texel, reflectance * factor, emission, shows);
}

#endif
