// Light transport: one path per lobe from the primary hit, lights and sun sampled at every later vertex.
//
// The including file supplies, besides what surface.glsl asks for,
//   pt_hit pt_closest(PT_SCENE vec3 origin, vec3 direction);
//   bool pt_occluded(PT_SCENE vec3 origin, vec3 direction, float distance);

#ifndef TRACER_PATH_GLSL
#define TRACER_PATH_GLSL

#include "bsdf.glsl"

// What a path meets after the primary hit looks at least this rough, so that no path carries a rare, huge caustic.
// Part of the ground truth: noisy frames and references share it.
#define PT_MIN_ROUGHNESS_AFTER_SPECULAR 0.2f
#define PT_MIN_ROUGHNESS_AFTER_DIFFUSE 0.5f

// Random pairs: those of the primary hit, then PT_PAIRS_PER_VERTEX for each later vertex.
#define PT_PAIR_DIFFUSE 0u
#define PT_PAIR_SPECULAR 1u
#define PT_PAIR_SUN 2u
#define PT_PAIR_DIFFUSE_VERTICES 16u
#define PT_PAIR_SPECULAR_VERTICES 64u
#define PT_PAIRS_PER_VERTEX 5u
#define PT_PAIR_LIGHT 0u
#define PT_PAIR_LIGHT_POINT 1u
#define PT_PAIR_VERTEX_SUN 2u
#define PT_PAIR_LOBE 3u
#define PT_PAIR_DIRECTION 4u

#define PT_LIGHT_CANDIDATES 4

#define PT_LOBE_DIFFUSE 0u
#define PT_LOBE_SPECULAR 1u
#define PT_LOBE_BOTH 2u

#define PT_HAS_SUN (max3(xyz_of(PT_FRAME.sun_irradiance)) > 0.0f)

PT_STRUCT(pt_lobe)
{
    vec3 radiance;  // leaving the surface towards the viewer, material included
    float hit_dist; // of the first ray, PT_MISS if it met nothing
    vec3 direction; // of the first ray
};

PT_STRUCT(pt_light_sample)
{
    vec3 direction;
    vec3 radiance;
    float distance;
    float density; // per solid angle, 0 when the sample is useless
};

PT_FN pt_hit pt_closest(PT_SCENE vec3 origin, vec3 direction);
PT_FN bool pt_occluded(PT_SCENE vec3 origin, vec3 direction, float distance);

// Density per solid angle with which light sampling finds an emitting point at a distance along a ray.
PT_FN float pt_light_density(PT_SCENE vec3 emission, float cosine, float distance)
{
    return luminance(emission) * PT_FRAME.inv_light_power * distance * distance / max(cosine, 1e-6f);
}

PT_FN uint pt_choose_light(PT_SCENE float u)
{
    uint low = 0u;
    uint high = PT_FRAME.light_count - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (u < PT_LIGHTS[middle].corner[3]) high = middle;
        else low = middle + 1u;
    }
    return low;
}

// A point on an emitter, from three numbers in [0, 1): which light, and where on it.
PT_FN pt_light_sample pt_sample_light(PT_SCENE vec3 origin, float choice, vec2 u)
{
    pt_light_sample r;
    pt_light light = PT_LIGHTS[pt_choose_light(PT_S choice)];
    float root = sqrt(u[0]);
    vec3 along = xyz_of(light.edge1) * (root * (1.0f - u[1])) + xyz_of(light.edge2) * (root * u[1]);
    vec3 point = xyz_of(light.corner) + along;
    r.distance = max(length(point - origin), 1e-6f);
    r.direction = (point - origin) * (1.0f / r.distance);
    r.radiance = xyz_of(light.radiance);
    float cosine = -dot(xyz_of(light.normal), r.direction);
    r.density = cosine > 1e-4f ? pt_light_density(PT_S r.radiance, cosine, r.distance) : 0.0f;
    return r;
}

PT_FN pt_lobe_value pt_eval(pt_surface s, uint lobe, float specular_share, vec3 light)
{
    if (lobe == PT_LOBE_DIFFUSE) return pt_eval_diffuse(s, light);
    if (lobe == PT_LOBE_SPECULAR) return pt_eval_specular(s, light);
    pt_lobe_value d = pt_eval_diffuse(s, light);
    pt_lobe_value r = pt_eval_specular(s, light);
    r.value = r.value + d.value;
    r.density = lerp1(d.density, r.density, specular_share);
    return r;
}

// Light of the emitters that leaves towards the viewer through the lobes, weighted against finding it by the lobe's own
// ray: one of PT_LIGHT_CANDIDATES points is kept in proportion to what it would contribute unshadowed, and tested for
// visibility (resampled importance sampling: Talbot et al., EGSR 2005). The candidates are shifted copies of one point,
// which is enough: the estimate needs each of them to be distributed as it should, not their independence.
PT_FN vec3 pt_direct_light(PT_SCENE pt_surface s, uint lobe, float specular_share, pt_rng rng, uint pair)
{
    if (PT_FRAME.light_count == 0u) return grey(0.0f);
    vec2 choice = pt_random2(rng, pair + PT_PAIR_LIGHT);
    vec2 point = pt_random2(rng, pair + PT_PAIR_LIGHT_POINT);
    float keep = choice[1];
    float sum = 0.0f;
    vec3 kept = grey(0.0f);
    vec3 direction = s.normal;
    float distance = 0.0f;
    for (int i = 0; i < PT_LIGHT_CANDIDATES; i++) {
        float k = TO_FLOAT(i);
        vec2 u = vec2(fract(point[0] + k * 0.7548777f), fract(point[1] + k * 0.5698403f));
        pt_light_sample l = pt_sample_light(PT_S s.origin, fract(choice[0] + k / TO_FLOAT(PT_LIGHT_CANDIDATES)), u);
        if (l.density <= 0.0f || dot(l.direction, s.face_normal) <= 0.0f) continue;
        pt_lobe_value f = pt_eval(s, lobe, specular_share, l.direction);
        vec3 light = l.radiance * f.value * pt_power_heuristic(l.density, f.density);
        float target = luminance(light);
        if (target <= 0.0f) continue;
        float weight = target / l.density;
        sum += weight;
        float share = weight / sum;
        bool take = keep < share;
        keep = take ? keep / share : (keep - share) / max(1.0f - share, 1e-6f);
        if (!take) continue;
        kept = light * (1.0f / target);
        direction = l.direction;
        distance = l.distance;
    }
    if (sum <= 0.0f || pt_occluded(PT_S s.origin, direction, distance - 2.0f * PT_SURFACE_EPS)) return grey(0.0f);
    return kept * (sum / TO_FLOAT(PT_LIGHT_CANDIDATES));
}

// The sun, or the lamp in its place, as a point sees it.
PT_STRUCT(pt_sun)
{
    vec3 axis;        // unit, to its centre
    float tan_radius; // of the angular radius
    float distance;
    vec3 irradiance;
};

PT_FN pt_sun pt_sun_from(PT_SCENE vec3 origin)
{
    pt_sun r;
    r.axis = xyz_of(PT_FRAME.sun_direction);
    r.tan_radius = PT_FRAME.sun_direction[3];
    r.distance = PT_MAX_HIT;
    r.irradiance = xyz_of(PT_FRAME.sun_irradiance);
    if (PT_FRAME.lamp[3] <= 0.0f) return r;
    vec3 to_lamp = xyz_of(PT_FRAME.lamp) - origin;
    r.distance = max(length(to_lamp), PT_SURFACE_EPS);
    r.axis = to_lamp * (1.0f / r.distance);
    r.tan_radius = PT_FRAME.lamp[3] / r.distance;
    r.irradiance = r.irradiance * (1.0f / (r.distance * r.distance));
    return r;
}

PT_FN bool pt_faces_sun(PT_SCENE pt_surface s)
{
    vec3 sun = pt_sun_from(PT_S s.origin).axis;
    return PT_HAS_SUN && dot(sun, s.face_normal) > 0.0f && dot(sun, s.normal) > 0.0f;
}

PT_STRUCT(pt_shadow)
{
    float hit_dist; // to the nearest occluder, glass too; PT_MISS if there is none, 0 where the surface faces away
    vec3 color;     // what arrives of the light
};

#define PT_PANES 8 // of glass behind each other, at most

// Along one ray to a point of the sun.
PT_FN pt_shadow pt_trace_shadow(PT_SCENE vec3 origin, vec3 direction, float distance)
{
    pt_shadow r;
    r.hit_dist = PT_MISS;
    r.color = grey(1.0f);
    float start = 0.0f;
    for (int i = 0; i < PT_PANES; i++) {
        pt_hit hit = pt_closest(PT_S origin + direction * start, direction);
        if (hit.triangle == PT_NO_TRIANGLE || start + hit.t >= distance) return r;
        r.hit_dist = min(r.hit_dist, clamp(start + hit.t, PT_SURFACE_EPS, PT_MAX_HIT));
        r.color = r.color * xyz_of(PT_MATERIALS[PT_TRIANGLES[hit.triangle].material].transmission);
        if (max3(r.color) <= 0.0f) return r;
        start += hit.t + PT_SURFACE_EPS;
    }
    r.color = grey(0.0f);
    return r;
}

// What arrives of the sun's light; cheaper where there is no glass.
PT_FN vec3 pt_sun_visibility(PT_SCENE vec3 origin, vec3 direction, float distance)
{
    if (PT_FRAME.has_glass != 0u) return pt_trace_shadow(PT_S origin, direction, distance).color;
    return grey(pt_occluded(PT_S origin, direction, distance) ? 0.0f : 1.0f);
}

PT_FN vec3 pt_direct_sun(PT_SCENE pt_surface s, pt_rng rng, uint pair)
{
    if (!pt_faces_sun(PT_S s)) return grey(0.0f);
    pt_sun sun = pt_sun_from(PT_S s.origin);
    vec3 direction = pt_disk_direction(sun.axis, sun.tan_radius, pt_random2(rng, pair));
    vec3 value = pt_eval(s, PT_LOBE_BOTH, 0.5f, direction).value;
    if (max3(value) <= 0.0f) return grey(0.0f);
    return sun.irradiance * value * pt_sun_visibility(PT_S s.origin, direction, sun.distance);
}

// Light that arrives at the primary hit along a ray that was drawn with the given density. `weigh`: emitters that the
// first ray finds were also sampled at the primary hit.
PT_FN vec3 pt_incoming(PT_SCENE pt_hit hit, vec3 direction, float density, uint lobe, pt_rng rng, bool weigh)
{
    vec3 sum = grey(0.0f);
    vec3 throughput = grey(1.0f);
    uint pair = lobe == PT_LOBE_DIFFUSE ? PT_PAIR_DIFFUSE_VERTICES : PT_PAIR_SPECULAR_VERTICES;
    float min_roughness = lobe == PT_LOBE_DIFFUSE ? PT_MIN_ROUGHNESS_AFTER_DIFFUSE : PT_MIN_ROUGHNESS_AFTER_SPECULAR;
    for (uint depth = 1u; depth <= PT_FRAME.bounces; depth++) {
        if (hit.triangle == PT_NO_TRIANGLE) return sum + throughput * pt_sky(PT_S direction);
        pt_surface s = pt_surface_at(PT_S hit, direction, depth == 1u && lobe == PT_LOBE_SPECULAR);
        float light_density = weigh ? pt_light_density(PT_S s.emission, dot(s.face_normal, s.view), hit.t) : 0.0f;
        sum = sum + throughput * s.emission * pt_power_heuristic(density, light_density);

        pair += PT_PAIRS_PER_VERTEX;
        s.roughness = max(s.roughness, min_roughness);
        float gloss = luminance(s.specular_factor);
        float share = clamp(gloss / (gloss + luminance(s.diffuse_factor)), 0.1f, 0.9f);
        vec3 direct = pt_direct_light(PT_S s, PT_LOBE_BOTH, share, rng, pair);
        sum = sum + throughput * (direct + pt_direct_sun(PT_S s, rng, pair + PT_PAIR_VERTEX_SUN));
        if (depth == PT_FRAME.bounces) return sum;

        bool specular = pt_random2(rng, pair + PT_PAIR_LOBE)[0] < share;
        vec2 u = pt_random2(rng, pair + PT_PAIR_DIRECTION);
        if (specular) direction = pt_sample_specular(s, u).direction;
        else direction = pt_sample_diffuse(s, u).direction;
        pt_lobe_value f = pt_eval(s, PT_LOBE_BOTH, share, direction);
        if (dot(direction, s.face_normal) <= 0.0f || f.density <= 0.0f) return sum;
        throughput = throughput * f.value * (1.0f / f.density);
        density = f.density;
        weigh = true;
        if (!specular) min_roughness = PT_MIN_ROUGHNESS_AFTER_DIFFUSE;
        hit = pt_closest(PT_S s.origin, direction);
    }
    return sum;
}

// One path of one lobe. A direction below the triangle carries no light; its hit distance is that of the mirrored ray,
// so that it says something about the surroundings.
PT_FN pt_lobe pt_trace_lobe(PT_SCENE pt_surface s, uint lobe, pt_rng rng, bool mis)
{
    pt_lobe_sample d;
    if (lobe == PT_LOBE_DIFFUSE) d = pt_sample_diffuse(s, pt_random2(rng, PT_PAIR_DIFFUSE));
    else d = pt_sample_specular(s, pt_random2(rng, PT_PAIR_SPECULAR));
    pt_lobe r;
    bool below = dot(d.direction, s.face_normal) <= 0.0f;
    r.direction = below ? reflect(d.direction, s.face_normal) : d.direction;
    pt_hit hit = pt_closest(PT_S s.origin, r.direction);
    r.hit_dist = hit.triangle == PT_NO_TRIANGLE ? PT_MISS : min(hit.t, PT_MAX_HIT);
    r.radiance = grey(0.0f);
    if (!below && max3(d.weight) > 0.0f)
        r.radiance = d.weight * pt_incoming(PT_S hit, r.direction, d.density, lobe, rng, mis);
    uint pair = lobe == PT_LOBE_DIFFUSE ? PT_PAIR_DIFFUSE_VERTICES : PT_PAIR_SPECULAR_VERTICES;
    if (mis) r.radiance = r.radiance + pt_direct_light(PT_S s, lobe, 0.0f, rng, pair);
    return r;
}

#endif
