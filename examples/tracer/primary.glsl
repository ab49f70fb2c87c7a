// The primary hit: camera ray, motion, the sun's noise-free light and its shadow ray.

#ifndef TRACER_PRIMARY_GLSL
#define TRACER_PRIMARY_GLSL

#include "path.glsl"

#define PT_STREAM_FRAME 0u
#define PT_STREAM_REFERENCE 0x5bd1e995u

PT_FN pt_rng pt_pixel_rng(PT_SCENE uint x, uint y, uint stream, uint index)
{
    pt_rng rng;
    rng.seed = pt_hash_combine(pt_hash_combine(x, y), pt_hash_combine(PT_FRAME.frame_index, PT_FRAME.seed ^ stream));
    rng.index = index;
    return rng;
}

PT_FN vec2 pt_pixel_uv(PT_SCENE uint x, uint y, bool jittered)
{
    float jx = jittered ? PT_FRAME.jitter[0] : 0.0f;
    float jy = jittered ? PT_FRAME.jitter[1] : 0.0f;
    float u = (TO_FLOAT(x) + 0.5f + jx) / TO_FLOAT(PT_FRAME.width);
    float v = (TO_FLOAT(y) + 0.5f + jy) / TO_FLOAT(PT_FRAME.height);
    return vec2(u, v);
}

PT_FN vec3 pt_camera_direction(pt_camera camera, vec2 uv)
{
    vec3 right = xyz_of(camera.right) * ((2.0f * uv[0] - 1.0f) * camera.right[3]);
    vec3 up = xyz_of(camera.up) * ((1.0f - 2.0f * uv[1]) * camera.up[3]);
    return normalize(right + up + xyz_of(camera.forward));
}

// (u, v, view z) of a world position.
PT_FN vec3 pt_project(pt_camera camera, vec3 position)
{
    vec3 d = position - xyz_of(camera.position);
    float z = dot(d, xyz_of(camera.forward));
    float x = dot(d, xyz_of(camera.right)) / (z * camera.right[3]);
    float y = dot(d, xyz_of(camera.up)) / (z * camera.up[3]);
    return vec3(0.5f + 0.5f * x, 0.5f - 0.5f * y, z);
}

// (u, v) of a direction: where the sky is.
PT_FN vec3 pt_project_sky(pt_camera camera, vec3 direction)
{
    return pt_project(camera, xyz_of(camera.position) + direction);
}

// 2.5D motion from the two projections of a point. What does not move and is seen by a camera that does not move has a
// motion of exactly zero, because both projections are then the same arithmetic on the same numbers.
PT_FN vec3 pt_motion(vec3 projected, vec3 projected_prev) { return projected_prev - projected; }

// The surface of a primary hit. Where the smooth surface dips under a neighbouring one, rays leave from the triangle:
// otherwise such pixels would be black.
PT_FN pt_surface pt_primary_surface(PT_SCENE pt_hit hit, vec3 direction)
{
    pt_surface s = pt_surface_at(PT_S hit, direction, true);
    vec3 bare = pt_lifted(s.position, s.face_normal);
    vec3 lift = s.origin - bare;
    float distance = length(lift);
    if (distance > PT_SURFACE_EPS && pt_occluded(PT_S bare, lift * (1.0f / distance), distance)) s.origin = bare;
    return s;
}

// Unshadowed light of the sun, both lobes. The disk's size keeps the highlight of a mirror as bright as the disk
// itself.
PT_FN vec3 pt_sun_light(PT_SCENE pt_surface s)
{
    if (!pt_faces_sun(PT_S s)) return grey(0.0f);
    pt_sun sun = pt_sun_from(PT_S s.origin);
    s.roughness = max(s.roughness, sqrt(min(sun.tan_radius, 1.0f)));
    return sun.irradiance * pt_eval(s, PT_LOBE_BOTH, 0.5f, sun.axis).value;
}

// Towards a random point of the sun.
PT_FN pt_shadow pt_shadow_ray(PT_SCENE pt_surface s, pt_rng rng)
{
    pt_shadow none;
    none.hit_dist = 0.0f;
    none.color = grey(0.0f);
    if (!pt_faces_sun(PT_S s)) return none;
    pt_sun sun = pt_sun_from(PT_S s.origin);
    vec3 direction = pt_disk_direction(sun.axis, sun.tan_radius, pt_random2(rng, PT_PAIR_SUN));
    return pt_trace_shadow(PT_S s.origin, direction, sun.distance);
}

PT_STRUCT(pt_reference)
{
    vec3 diffuse;  // demodulated
    vec3 specular; // demodulated
    float visibility;
    vec3 translucency; // visibility through coloured glass
    float openness; // normalised hit distance
    float specular_openness;
};

// nrd_normalize_hit_dist() of nrd.glsl.
PT_FN float pt_openness(PT_SCENE pt_surface s, float hit_dist, float roughness)
{
    float view_z = pt_project(PT_FRAME.camera, s.position)[2];
    float growth = clamp(exp2(PT_FRAME.occlusion[3] * roughness * roughness), 0.0f, 1.0f);
    float range = (PT_FRAME.occlusion[0] + view_z * PT_FRAME.occlusion[1]) * lerp1(1.0f, PT_FRAME.occlusion[2], growth);
    return hit_dist >= PT_MISS ? 1.0f : min(hit_dist / range, 1.0f);
}

// One sample of everything a reference averages.
PT_FN pt_reference pt_reference_sample(PT_SCENE pt_surface s, pt_rng rng)
{
    pt_lobe diffuse = pt_trace_lobe(PT_S s, PT_LOBE_DIFFUSE, rng, true);
    pt_lobe specular = pt_trace_lobe(PT_S s, PT_LOBE_SPECULAR, rng, true);
    pt_reference r;
    r.diffuse = diffuse.radiance / s.diffuse_factor;
    r.specular = specular.radiance / s.specular_factor;
    pt_shadow shadow = pt_shadow_ray(PT_S s, rng);
    r.visibility = shadow.hit_dist >= PT_MISS ? 1.0f : 0.0f;
    r.translucency = shadow.color;
    r.openness = pt_openness(PT_S s, diffuse.hit_dist, 1.0f);
    r.specular_openness = pt_openness(PT_S s, specular.hit_dist, s.roughness);
    return r;
}

#endif
