// The reflection model: a Lambert lobe of reflectance diffuse_factor, and a GGX lobe with height-correlated Smith
// masking and Schlick's Fresnel term. Values include the cosine at the surface.

#ifndef TRACER_BSDF_GLSL
#define TRACER_BSDF_GLSL

#include "surface.glsl"

// GGX alpha of a perfect mirror: small enough to look like one, large enough for 32-bit arithmetic.
#define PT_MIN_ALPHA 1e-4f

PT_STRUCT(pt_lobe_sample)
{
    vec3 direction;
    vec3 weight;   // value / density
    float density; // per solid angle
};

PT_STRUCT(pt_lobe_value)
{
    vec3 value;
    float density; // with which sampling this lobe would have drawn the direction
};

PT_FN float pt_alpha(float roughness) { return max(roughness * roughness, PT_MIN_ALPHA); }

PT_FN vec3 pt_fresnel(vec3 rf0, float v_dot_h)
{
    float x = clamp(1.0f - v_dot_h, 0.0f, 1.0f);
    float x2 = x * x;
    return rf0 + (grey(1.0f) - rf0) * (x2 * x2 * x);
}

PT_FN float pt_smith_root(float cosine, float alpha)
{
    return sqrt(alpha * alpha + (1.0f - alpha * alpha) * cosine * cosine);
}

// Share of the microfacets seen from one side that are also seen from the other: G2 / G1(view).
PT_FN float pt_masking_ratio(float n_dot_v, float n_dot_l, float alpha)
{
    float root_v = pt_smith_root(n_dot_v, alpha);
    float root_l = pt_smith_root(n_dot_l, alpha);
    return n_dot_l * (n_dot_v + root_v) / max(n_dot_v * root_l + n_dot_l * root_v, 1e-12f);
}

// Density per solid angle of the directions that pt_sample_specular draws: D G1(view) / (4 n.v).
PT_FN float pt_specular_density(float n_dot_h, float n_dot_v, float alpha)
{
    float a2 = alpha * alpha;
    float t = (1.0f - n_dot_h * n_dot_h) + n_dot_h * n_dot_h * a2;
    float d = a2 / max(PT_PI * t * t, 1e-30f);
    return d * 0.5f / (n_dot_v + pt_smith_root(n_dot_v, alpha));
}

PT_FN pt_lobe_value pt_eval_diffuse(pt_surface s, vec3 light)
{
    float cosine = max(dot(s.normal, light), 0.0f);
    pt_lobe_value r;
    r.value = s.diffuse_factor * (cosine / PT_PI);
    r.density = cosine / PT_PI;
    return r;
}

PT_FN pt_lobe_value pt_eval_specular(pt_surface s, vec3 light)
{
    float alpha = pt_alpha(s.roughness);
    float n_dot_l = dot(s.normal, light);
    float n_dot_v = dot(s.normal, s.view);
    pt_lobe_value r;
    r.value = grey(0.0f);
    r.density = 0.0f;
    if (n_dot_l <= 0.0f) return r;
    vec3 h = normalize(light + s.view);
    r.density = pt_specular_density(min(dot(s.normal, h), 1.0f), n_dot_v, alpha);
    float ratio = pt_masking_ratio(n_dot_v, n_dot_l, alpha);
    r.value = pt_fresnel(s.rf0, dot(s.view, h)) * (ratio * r.density);
    return r;
}

PT_FN pt_lobe_sample pt_sample_diffuse(pt_surface s, vec2 u)
{
    pt_lobe_sample r;
    r.direction = pt_cosine_direction(s.normal, u);
    r.weight = s.diffuse_factor;
    r.density = max(dot(s.normal, r.direction), 0.0f) / PT_PI;
    return r;
}

// Visible normals by spherical caps (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023).
PT_FN pt_lobe_sample pt_sample_specular(pt_surface s, vec2 u)
{
    float alpha = pt_alpha(s.roughness);
    vec3 t = pt_tangent(s.normal);
    vec3 b = cross(s.normal, t);
    vec3 v = normalize(vec3(alpha * dot(s.view, t), alpha * dot(s.view, b), dot(s.view, s.normal)));
    float phi = 2.0f * PT_PI * u[0];
    float z = (1.0f - u[1]) * (1.0f + v[2]) - v[2];
    float sine = sqrt(clamp(1.0f - z * z, 0.0f, 1.0f));
    vec3 cap = vec3(sine * cos(phi), sine * sin(phi), z) + v;
    vec3 h = normalize(t * (alpha * cap[0]) + b * (alpha * cap[1]) + s.normal * max(cap[2], 1e-7f));

    pt_lobe_sample r;
    float v_dot_h = dot(s.view, h);
    r.direction = normalize(h * (2.0f * v_dot_h) - s.view);
    float n_dot_l = dot(s.normal, r.direction);
    float n_dot_v = dot(s.normal, s.view);
    r.density = pt_specular_density(min(dot(s.normal, h), 1.0f), n_dot_v, alpha);
    r.weight = pt_fresnel(s.rf0, v_dot_h) * (n_dot_l > 0.0f ? pt_masking_ratio(n_dot_v, n_dot_l, alpha) : 0.0f);
    return r;
}

#endif
