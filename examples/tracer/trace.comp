// Path tracer, one invocation per pixel: what an engine's ray generation shader does for the denoisers.
// Reads: the scene (hierarchy, triangles, materials, lights), the frame's camera and settings.
// Writes: the denoisers' input textures, packed as an engine would, and the planes of a capture (guides, noisy
// demodulated signals, composition factors); or, as a reference, the sums of many samples.
#version 450
#extension GL_GOOGLE_include_directive : require

#include "data.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const bool is_reference = false;

layout(std430, set = 0, binding = 0) readonly buffer node_buffer { pt_node scene_nodes[]; };
layout(std430, set = 0, binding = 1) readonly buffer corner_buffer { vec4 scene_corners[]; };
layout(std430, set = 0, binding = 2) readonly buffer triangle_buffer { pt_triangle scene_triangles[]; };
layout(std430, set = 0, binding = 3) readonly buffer material_buffer { pt_material scene_materials[]; };
layout(std430, set = 0, binding = 4) readonly buffer light_buffer { pt_light scene_lights[]; };
layout(std430, set = 0, binding = 5) readonly buffer frame_buffer { pt_frame scene_frame; };
layout(std430, set = 0, binding = 6) buffer plane_buffer { float out_planes[]; };
layout(set = 0, binding = 7, rgba16f) writeonly uniform image2D in_mv;
layout(set = 0, binding = 8, rgba16f) writeonly uniform image2D in_normal_roughness;
layout(set = 0, binding = 9, r32f) writeonly uniform image2D in_viewz;
layout(set = 0, binding = 10, rgba16f) writeonly uniform image2D in_diff_radiance_hitdist;
layout(set = 0, binding = 11, rgba16f) writeonly uniform image2D in_spec_radiance_hitdist;

#define PT_FRAME scene_frame
#define PT_TRIANGLES scene_triangles
#define PT_MATERIALS scene_materials
#define PT_LIGHTS scene_lights

#include "nrd.glsl"
#include "primary.glsl"

#define STACK_SIZE 40 // BVH_MAX_DEPTH

//----------------------------------------------------------------------------------------------------------------------
// >>rays
//----------------------------------------------------------------------------------------------------------------------

// Distance at which a ray enters a box, or a negative number if it misses it or the box lies beyond t_max.
float enter_box(pt_node node, vec3 origin, vec3 inverse, float t_max)
{
    vec3 a = (vec3(node.low[0], node.low[1], node.low[2]) - origin) * inverse;
    vec3 b = (vec3(node.high[0], node.high[1], node.high[2]) - origin) * inverse;
    vec3 near = min(a, b);
    vec3 far = max(a, b) * 1.0000004; // conservative: Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013
    float enter = max(max(near.x, near.y), max(near.z, 0.0));
    float leave = min(min(far.x, far.y), min(far.z, t_max));
    return enter <= leave ? enter : -1.0;
}

// `index` is the triangle's place in the hierarchy's order; its number comes with its first corner.
// Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
void intersect_triangle(uint index, vec3 origin, vec3 direction, inout pt_hit hit)
{
    vec4 corner = scene_corners[3u * index];
    vec3 e1 = scene_corners[3u * index + 1u].xyz - corner.xyz;
    vec3 e2 = scene_corners[3u * index + 2u].xyz - corner.xyz;
    vec3 p = cross(direction, e2);
    float det = dot(e1, p);
    if (det == 0.0) return;
    vec3 s = origin - corner.xyz;
    vec3 q = cross(s, e1);
    float b1 = dot(s, p) / det;
    float b2 = dot(direction, q) / det;
    float t = dot(e2, q) / det;
    if (b1 < 0.0 || b2 < 0.0 || b1 + b2 > 1.0 || t <= 0.0 || t >= hit.t) return;
    hit.triangle = floatBitsToUint(corner.w);
    hit.t = t;
    hit.b1 = b1;
    hit.b2 = b2;
}

// Nearest hit before t_max, or any one if `any_hit`.
pt_hit traverse(vec3 origin, vec3 direction, float t_max, bool any_hit)
{
    pt_hit hit = pt_hit(PT_NO_TRIANGLE, t_max, 0.0, 0.0);
    vec3 inverse = 1.0 / mix(direction, vec3(1e-20), equal(direction, vec3(0.0)));
    uint stack[STACK_SIZE];
    int depth = 0;
    uint index = 0u;
    while (true) {
        pt_node node = scene_nodes[index];
        if (node.count > 0u) {
            for (uint i = 0u; i < node.count; i++) intersect_triangle(node.first + i, origin, direction, hit);
            if (any_hit && hit.triangle != PT_NO_TRIANGLE) return hit;
        } else {
            float left = enter_box(scene_nodes[node.first], origin, inverse, hit.t);
            float right = enter_box(scene_nodes[node.first + 1u], origin, inverse, hit.t);
            bool left_first = right < 0.0 || (left >= 0.0 && left <= right);
            if (left >= 0.0 && right >= 0.0) stack[depth++] = left_first ? node.first + 1u : node.first;
            if (left >= 0.0 || right >= 0.0) {
                index = left_first ? node.first : node.first + 1u;
                continue;
            }
        }
        if (depth == 0) return hit;
        index = stack[--depth];
    }
    return hit;
}

pt_hit pt_closest(vec3 origin, vec3 direction) { return traverse(origin, direction, 1e30, false); }

bool pt_occluded(vec3 origin, vec3 direction, float distance)
{
    return traverse(origin, direction, distance, true).triangle != PT_NO_TRIANGLE;
}

pt_factors pt_material_factors(vec3 normal, vec3 view, vec3 albedo, vec3 rf0, float roughness)
{
    pt_factors f;
    nrd_material_factors(normal, view, albedo, rf0, roughness, f.diffuse, f.specular);
    return f;
}

//----------------------------------------------------------------------------------------------------------------------
// >>output
//----------------------------------------------------------------------------------------------------------------------

void put(uint plane, float value)
{
    uint texels = scene_frame.width * scene_frame.height;
    out_planes[plane * texels + gl_GlobalInvocationID.y * scene_frame.width + gl_GlobalInvocationID.x] = value;
}

void put3(uint plane, vec3 value)
{
    for (uint c = 0u; c < 3u; c++) put(plane + c, value[c]);
}

// The guides that every denoiser reads. Storing to 16 bits truncates on many devices, so values are rounded first.
void put_geometry(float view_z, vec3 normal, float roughness, uint material_id, vec3 motion)
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    vec4 packed_normal = nrd_encode_normal_roughness(normal, roughness, material_id, NRD_NORMAL_FORMAT_RGBA16_SNORM,
                                                     NRD_ROUGHNESS_FORMAT_LINEAR);
    imageStore(in_viewz, pixel, vec4(view_z, 0.0, 0.0, 0.0));
    imageStore(in_normal_roughness, pixel, nrd_round_to_half(packed_normal));
    imageStore(in_mv, pixel, nrd_round_to_half(vec4(motion, 0.0)));
    put(PT_PLANE_VIEW_Z, view_z);
    put3(PT_PLANE_NORMAL, normal);
    put(PT_PLANE_ROUGHNESS, roughness);
    put(PT_PLANE_MATERIAL, float(material_id));
    put3(PT_PLANE_MOTION, motion);
}

void put_sky(vec3 direction)
{
    vec3 now = pt_project_sky(scene_frame.camera, direction);
    vec3 prev = pt_project_sky(scene_frame.camera_prev, direction);
    for (uint plane = 0u; plane < PT_PLANE_COUNT; plane++) put(plane, 0.0);
    vec3 motion = prev.z > 0.0 ? nrd_motion_2_5d(now.xy, now.z, prev.xy, now.z) : vec3(0.0);
    put_geometry(2.0 * scene_frame.denoising_range, -direction, 0.0, 0u, motion);
    put3(PT_PLANE_EMISSION, nrd_sanitize_radiance(pt_sky(direction)));
}

void put_guides(pt_surface s)
{
    vec3 now = pt_project(scene_frame.camera, s.position);
    vec3 prev = pt_project(scene_frame.camera_prev, s.position_prev);
    vec3 motion = prev.z > 0.0 ? nrd_motion_2_5d(now.xy, now.z, prev.xy, prev.z) : vec3(0.0);
    put_geometry(now.z, s.normal, s.roughness, s.material_id, motion);
    put3(PT_PLANE_BASE_COLOR, s.base_color);
    put(PT_PLANE_METALNESS, s.metalness);
    put3(PT_PLANE_DIFFUSE_FACTOR, s.diffuse_factor);
    put3(PT_PLANE_SPECULAR_FACTOR, s.specular_factor);
    put3(PT_PLANE_EMISSION, nrd_sanitize_radiance(s.emission));
    put3(PT_PLANE_SUN, nrd_sanitize_radiance(pt_sun_light(s)));
}

pt_lobe trace_path(pt_surface s, uint lobe, uint path)
{
    pt_rng rng = pt_pixel_rng(gl_GlobalInvocationID.x, gl_GlobalInvocationID.y, PT_STREAM_FRAME, path);
    pt_lobe r = pt_trace_lobe(s, lobe, rng, scene_frame.direct_mis != 0u);
    r.radiance = nrd_sanitize_radiance(r.radiance);
    r.hit_dist = nrd_trim_hit_dist(r.hit_dist, PT_SURFACE_EPS);
    return r;
}

// The average of the paths of a lobe, demodulated: means for the diffuse one, the nearest hit distance for the specular
// one. Returns the texel that the denoiser reads.
vec4 put_lobe(uint plane, pt_surface s, uint lobe, vec3 factor)
{
    vec3 radiance = vec3(0.0);
    vec3 direction = vec3(0.0);
    vec2 mean = nrd_diffuse_hit_dist_begin();
    float nearest = nrd_specular_hit_dist_begin();
    for (uint path = 0u; path < scene_frame.paths; path++) {
        pt_lobe one = trace_path(s, lobe, path);
        radiance += one.radiance / float(scene_frame.paths);
        direction += one.direction;
        mean = nrd_diffuse_hit_dist_add(mean, one.hit_dist);
        nearest = nrd_specular_hit_dist_add(nearest, one.hit_dist);
    }
    float hit_dist = lobe == PT_LOBE_DIFFUSE ? nrd_diffuse_hit_dist_end(mean) : nrd_specular_hit_dist_end(nearest);
    radiance = nrd_sanitize_radiance(nrd_demodulate(radiance, factor));
    put3(plane, radiance);
    put(plane + PT_PLANE_DIFFUSE_HIT - PT_PLANE_DIFFUSE, nrd_sanitize_hit_dist(hit_dist));
    put3(plane + PT_PLANE_DIFFUSE_DIR - PT_PLANE_DIFFUSE, normalize(direction + s.normal * 1e-6));

    float view_z = pt_project(scene_frame.camera, s.position).z;
    float roughness = lobe == PT_LOBE_DIFFUSE ? 1.0 : s.roughness;
    float norm_hit_dist = nrd_normalize_hit_dist(hit_dist, view_z, roughness, scene_frame.hit_dist_params);
    return nrd_round_to_half(nrd_pack_radiance_hit_dist(radiance, norm_hit_dist, true));
}

void add_reference(uint plane, float value)
{
    uint texels = scene_frame.width * scene_frame.height;
    uint index = plane * texels + gl_GlobalInvocationID.y * scene_frame.width + gl_GlobalInvocationID.x;
    out_planes[index] = (scene_frame.sample_add != 0u ? out_planes[index] : 0.0) + value;
}

void put_reference(pt_surface s)
{
    pt_reference sum = pt_reference(vec3(0.0), vec3(0.0), 0.0, vec3(0.0), 0.0, 0.0);
    for (uint i = 0u; i < scene_frame.sample_count; i++) {
        uint index = scene_frame.sample_first + i;
        pt_rng rng = pt_pixel_rng(gl_GlobalInvocationID.x, gl_GlobalInvocationID.y, PT_STREAM_REFERENCE, index);
        pt_reference one = pt_reference_sample(s, rng);
        sum.diffuse += one.diffuse;
        sum.specular += one.specular;
        sum.visibility += one.visibility;
        sum.translucency += one.translucency;
        sum.openness += one.openness;
        sum.specular_openness += one.specular_openness;
    }
    for (uint c = 0u; c < 3u; c++) {
        add_reference(PT_REF_DIFFUSE + c, sum.diffuse[c]);
        add_reference(PT_REF_SPECULAR + c, sum.specular[c]);
        add_reference(PT_REF_TRANSLUCENCY + c, sum.translucency[c]);
    }
    add_reference(PT_REF_SHADOW, sum.visibility);
    add_reference(PT_REF_AO, sum.openness);
    add_reference(PT_REF_SPECULAR_AO, sum.specular_openness);
}

void main()
{
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= scene_frame.width || pixel.y >= scene_frame.height) return;
    vec3 direction = pt_camera_direction(scene_frame.camera, pt_pixel_uv(pixel.x, pixel.y, !is_reference));
    pt_hit hit = pt_closest(scene_frame.camera.position.xyz, direction);
    if (hit.triangle == PT_NO_TRIANGLE) {
        if (is_reference) {
            for (uint plane = 0u; plane < PT_REF_COUNT; plane++) put(plane, 0.0);
        } else {
            put_sky(direction);
        }
        return;
    }
    pt_surface s = pt_primary_surface(hit, direction);
    if (is_reference) {
        put_reference(s);
        return;
    }
    put_guides(s);
    vec4 diffuse = put_lobe(PT_PLANE_DIFFUSE, s, PT_LOBE_DIFFUSE, s.diffuse_factor);
    vec4 specular = put_lobe(PT_PLANE_SPECULAR, s, PT_LOBE_SPECULAR, s.specular_factor);
    imageStore(in_diff_radiance_hitdist, ivec2(pixel), diffuse);
    imageStore(in_spec_radiance_hitdist, ivec2(pixel), specular);
    pt_shadow shadow = pt_shadow_ray(s, pt_pixel_rng(pixel.x, pixel.y, PT_STREAM_FRAME, 0u));
    put(PT_PLANE_SHADOW_HIT, shadow.hit_dist);
    put3(PT_PLANE_TRANSLUCENCY, shadow.color);
}
