// From a ray's hit to what the light transport needs to know about the point.
//
// The including file supplies the scene: PT_FRAME, PT_TRIANGLES, PT_MATERIALS and PT_LIGHTS, and
//   pt_factors pt_material_factors(vec3 normal, vec3 view, vec3 albedo, vec3 rf0, float roughness);

#ifndef TRACER_SURFACE_GLSL
#define TRACER_SURFACE_GLSL

#include "data.glsl"
#include "texture.glsl"

PT_STRUCT(pt_hit)
{
    uint triangle; // PT_NO_TRIANGLE: nothing was met
    float t;
    float b1; // barycentric coordinates of vertices 1 and 2
    float b2;
};

PT_STRUCT(pt_factors)
{
    vec3 diffuse;
    vec3 specular;
};

PT_STRUCT(pt_surface)
{
    vec3 position;
    vec3 position_prev; // of the same point of the object, in the previous frame
    vec3 origin;        // where rays leave: lifted off the triangle, and onto the smooth surface it stands for
    vec3 view;          // unit, towards where the ray came from
    vec3 face_normal;   // of the triangle, on the side of `view`
    vec3 normal;        // shading normal, at an angle below 90 degrees to `view`
    vec3 base_color;
    float roughness;
    float metalness;
    vec3 rf0;           // specular reflectance at normal incidence
    vec3 emission;
    vec3 diffuse_factor; // also the reflectance of the diffuse lobe, so that demodulation leaves irradiance / pi
    vec3 specular_factor;
    uint material_id;
};

PT_FN pt_factors pt_material_factors(vec3 normal, vec3 view, vec3 albedo, vec3 rf0, float roughness);

PT_FN vec3 pt_sky(PT_SCENE vec3 direction)
{
    float height = direction[1];
    vec3 horizon = xyz_of(PT_FRAME.sky_horizon);
    if (height < 0.0f) return lerp3(horizon, xyz_of(PT_FRAME.sky_ground), smoothstep(0.0f, 0.12f, -height));
    vec3 color = lerp3(horizon, xyz_of(PT_FRAME.sky_zenith), pow(height, 0.55f));
    float toward_sun = max(dot(direction, xyz_of(PT_FRAME.sun_direction)), 0.0f);
    return color + xyz_of(PT_FRAME.sun_irradiance) * (PT_FRAME.sky_horizon[3] * pow(toward_sun, 24.0f));
}

PT_FN vec3 pt_interpolate(vec4 a, vec4 b, vec4 c, float wb, float wc)
{
    return xyz_of(a) * (1.0f - wb - wc) + xyz_of(b) * wb + xyz_of(c) * wc;
}

// Point that the smooth surface has above a flat triangle (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems
// II, ch. 4): the mean of the projections onto the tangent planes of the vertices, where those lie on the side of
// `face`.
PT_FN vec3 pt_smooth_point(pt_triangle tri, vec3 p, vec3 face, float wb, float wc)
{
    vec3 sum = vec3(0.0f, 0.0f, 0.0f);
    for (int k = 0; k < 3; k++) {
        float weight = k == 0 ? 1.0f - wb - wc : (k == 1 ? wb : wc);
        vec3 n = xyz_of(tri.n[k]);
        if (dot(n, face) < 0.0f) n = n * -1.0f;
        sum = sum + n * (weight * -min(dot(p - xyz_of(tri.p[k]), n), 0.0f));
    }
    return p + sum;
}

// A ray origin off the surface, by enough to be above rounding errors.
PT_FN vec3 pt_lifted(vec3 point, vec3 face)
{
    float size = max(max(abs1(point[0]), abs1(point[1])), abs1(point[2]));
    return point + face * (PT_SURFACE_EPS * max(0.1f * size, 1.0f));
}

// Shading normal tilted by the slope of the texture, whose height in metres is bump x pattern.
PT_FN vec3 pt_bumped_normal(pt_triangle tri, pt_material m, vec3 n, float u, float v, float pattern)
{
    const float delta = 0.01f;
    vec3 e1 = xyz_of(tri.p[1]) - xyz_of(tri.p[0]);
    vec3 e2 = xyz_of(tri.p[2]) - xyz_of(tri.p[0]);
    float u1 = tri.p[1][3] - tri.p[0][3], v1 = tri.prev[1][3] - tri.prev[0][3];
    float u2 = tri.p[2][3] - tri.p[0][3], v2 = tri.prev[2][3] - tri.prev[0][3];
    float det = u1 * v2 - u2 * v1;
    if (abs1(det) < 1e-12f) return n;
    vec3 du = (e1 * v2 - e2 * v1) * (1.0f / det);
    vec3 dv = (e2 * u1 - e1 * u2) * (1.0f / det);
    float slope = m.roughness[2] * m.color2[3] / delta;
    float hu = (pt_pattern(m.texture_kind, u + delta, v) - pattern) * slope;
    float hv = (pt_pattern(m.texture_kind, u, v + delta) - pattern) * slope;
    return normalize(n - du * (hu / max(dot(du, du), 1e-12f)) - dv * (hv / max(dot(dv, dv), 1e-12f)));
}

// The shading normal turned to the side of the viewer, at an angle that leaves n.v >= 0.02.
PT_FN vec3 pt_visible_normal(vec3 n, vec3 face, vec3 view)
{
    if (dot(n, face) < 0.0f) n = n * -1.0f;
    float excess = 0.02f - dot(n, view);
    return excess > 0.0f ? normalize(n + view * excess) : n;
}

// Fills in what depends on the material alone.
PT_FN pt_surface pt_apply_material(pt_surface s, pt_material m, float pattern, bool front)
{
    s.base_color = lerp3(xyz_of(m.color), xyz_of(m.color2), pattern);
    s.roughness = lerp1(m.roughness[0], m.roughness[1], pattern);
    s.metalness = m.color[3];
    s.rf0 = lerp3(grey(0.04f), s.base_color, s.metalness);
    s.emission = front ? xyz_of(m.emission) : grey(0.0f);
    s.material_id = m.id;
    return s;
}

PT_FN pt_surface pt_with_factors(pt_surface s)
{
    vec3 albedo = s.base_color * (1.0f - s.metalness);
    pt_factors f = pt_material_factors(s.normal, s.view, albedo, s.rf0, s.roughness);
    s.diffuse_factor = f.diffuse;
    s.specular_factor = f.specular;
    return s;
}

// bumpy: the texture's slope tilts the shading normal; left out where nobody would see it.
PT_FN pt_surface pt_surface_at(PT_SCENE pt_hit hit, vec3 direction, bool bumpy)
{
    pt_triangle tri = PT_TRIANGLES[hit.triangle];
    pt_material m = PT_MATERIALS[tri.material];
    pt_surface s;
    s.view = direction * -1.0f;
    s.position = pt_interpolate(tri.p[0], tri.p[1], tri.p[2], hit.b1, hit.b2);
    s.position_prev = pt_interpolate(tri.prev[0], tri.prev[1], tri.prev[2], hit.b1, hit.b2);
    vec3 face = normalize(cross(xyz_of(tri.p[1]) - xyz_of(tri.p[0]), xyz_of(tri.p[2]) - xyz_of(tri.p[0])));
    bool front = dot(face, direction) < 0.0f;
    s.face_normal = front ? face : face * -1.0f;
    s.origin = pt_lifted(pt_smooth_point(tri, s.position, s.face_normal, hit.b1, hit.b2), s.face_normal);

    float scale = m.color2[3];
    float u = (tri.p[0][3] * (1.0f - hit.b1 - hit.b2) + tri.p[1][3] * hit.b1 + tri.p[2][3] * hit.b2) * scale;
    float v = (tri.prev[0][3] * (1.0f - hit.b1 - hit.b2) + tri.prev[1][3] * hit.b1 + tri.prev[2][3] * hit.b2) * scale;
    float pattern = pt_pattern(m.texture_kind, u, v);
    s.normal = normalize(pt_interpolate(tri.n[0], tri.n[1], tri.n[2], hit.b1, hit.b2));
    if (bumpy && m.roughness[2] != 0.0f) s.normal = pt_bumped_normal(tri, m, s.normal, u, v, pattern);
    s.normal = pt_visible_normal(s.normal, s.face_normal, s.view);
    return pt_with_factors(pt_apply_material(s, m, pattern, front));
}

#endif
