/* nrd_reference_light.h: the functions of nrd.glsl for light with a direction and for occlusion in double precision,
   written from their definitions, for tests. As nrd_reference.h. */
#ifndef TESTS_NRD_REFERENCE_LIGHT_H
#define TESTS_NRD_REFERENCE_LIGHT_H

#include "nrd_reference.h"

#define REF_PI 3.14159265358979323846

typedef struct ref_sg {
    double ycocg[3], moment[3];
} ref_sg;

static inline double ref_length(const double v[3]) {
    return sqrt(ref_dot(v, v));
}

static inline void ref_normalize(double v[3]) {
    double length = fmax(ref_length(v), REF_EPSILON);
    for (int i = 0; i < 3; ++i) v[i] /= length;
}

static inline void ref_cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Normalised a + b. */
static inline void ref_half_vector(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = a[i] + b[i];
    ref_normalize(out);
}

static inline double ref_cosine(const double a[3], const double b[3]) {
    return fmin(fabs(ref_dot(a, b)), 1.0);
}

/* ---- pairs ---------------------------------------------------------------------------------------------------- */

static inline void ref_sanitize_direction(const double d[3], double out[3]) {
    bool finite = ref_is_finite3(d);
    for (int i = 0; i < 3; ++i) out[i] = finite ? ref_clamp(d[i], -1.0, 1.0) : 0.0;
}

/* hit_dist_limit: 1 or 65504. out: SH0, SH1 */
static inline void ref_pack_sh(const double rgb[3], double hit_dist, const double direction[3], bool sanitize,
                               double hit_dist_limit, double out[8]) {
    double legal[3] = {rgb[0], rgb[1], rgb[2]}, d[3] = {direction[0], direction[1], direction[2]};
    if (sanitize) ref_sanitize_radiance(rgb, legal);
    if (sanitize) ref_sanitize_direction(direction, d);
    ref_rgb_to_ycocg(legal, out);
    out[3] = sanitize ? ref_sanitize(hit_dist, hit_dist_limit) : hit_dist;
    for (int i = 0; i < 3; ++i) out[4 + i] = d[i] * out[0];
    out[7] = 0.0;
}

/* The lobe's mean cosine from its sharpness, and back by Banerjee's formula. */
static inline double ref_mean_cosine(double sharpness) {
    return sharpness < 1e-4 ? sharpness / 3.0 : 1.0 / tanh(sharpness) - 1.0 / sharpness;
}

static inline double ref_sharpness(const ref_sg *sg) {
    double l = fmin(ref_length(sg->moment) / fmax(sg->ycocg[0], REF_EPSILON), 1.0);
    return l * (3.0 - l * l) / fmax(1.0 - l * l, 1e-3);
}

static inline double ref_roughness_aa(double r, const double mean_normal[3]) {
    double l = fmin(ref_length(mean_normal), 1.0);
    return sqrt(ref_clamp(r * r + (1.0 - l * l) / fmax(l * (3.0 - l * l), REF_EPSILON), 0.0, 1.0));
}

/* ---- resolve -------------------------------------------------------------------------------------------------- */

static inline double ref_pow5(double x) {
    return pow(ref_clamp(x, 0.0, 1.0), 5.0);
}

static inline double ref_sg_integral(double amplitude, double sharpness_1, const double axis_1[3], double sharpness_2,
                                     const double axis_2[3]) {
    double sum[3], d;
    for (int i = 0; i < 3; ++i) sum[i] = sharpness_1 * axis_1[i] + sharpness_2 * axis_2[i];
    d = fmax(ref_length(sum), REF_EPSILON);
    return 2.0 * REF_PI * amplitude * exp(d - sharpness_1 - sharpness_2) * (1.0 - exp(-2.0 * d)) / d;
}

static inline double ref_burley(double n_dot_v, double n_dot_l, double v_dot_h, double r) {
    double f = 2.0 * v_dot_h * v_dot_h * r - 0.5;
    return (1.0 + f * ref_pow5(1.0 - n_dot_v)) * (1.0 + f * ref_pow5(1.0 - n_dot_l)) / REF_PI;
}

static inline double ref_smith(double v, double l, double m) {
    double a = l * sqrt((v - m * m * v) * v + m * m), b = v * sqrt((l - m * m * l) * l + m * m);
    return 0.5 / fmax(a + b, REF_EPSILON);
}

/* Unit direction of the light; fallback if the moment is shorter than 5e-7. */
static inline void ref_light_direction(const ref_sg *sg, const double fallback[3], double out[3]) {
    double length = ref_length(sg->moment);
    for (int i = 0; i < 3; ++i) out[i] = length > 5e-7 ? sg->moment[i] / fmax(length, REF_EPSILON) : fallback[i];
}

static inline void ref_with_luma(const ref_sg *sg, double luma, double out[3]) {
    double y = sg->ycocg[0], factor = (luma + REF_EPSILON) / (fmax(y, 0.0) + REF_EPSILON);
    double scaled[3] = {luma, sg->ycocg[1] * factor, sg->ycocg[2] * factor};
    ref_ycocg_to_rgb(scaled, true, out);
}

static inline double ref_diffuse_luma(const ref_sg *sg, const double n[3], const double v[3], double r) {
    double l[3], h[3];
    ref_light_direction(sg, n, l);
    ref_half_vector(l, v, h);
    double n_dot_v = ref_cosine(n, v), n_dot_l = ref_clamp(ref_dot(n, l), 0.0, 1.0);
    double integral = ref_sg_integral(2.0 * sg->ycocg[0], 2.0, l, 2.0, n);
    double fit = ref_mix(1.0, ref_mix(1.5, 0.6, r), ref_pow5(1.0 - n_dot_v));
    return fmax(integral * ref_burley(n_dot_v, n_dot_l, ref_cosine(v, h), r) * fit, fmax(sg->ycocg[0], 0.0) / REF_PI);
}

static inline double ref_specular_luma(const ref_sg *sg, const double n[3], const double v[3], double roughness) {
    double l[3], h[3], r = fmax(roughness, 0.05), m = r * r;
    ref_light_direction(sg, n, l);
    ref_half_vector(l, v, h);
    double n_dot_l = ref_clamp(ref_dot(n, l), 0.0, 1.0), n_dot_v = ref_mix(0.02, 1.0, ref_cosine(n, v));
    double sharpness = 2.0 / (m * m), warped = 0.5 / fmax(m * m * ref_cosine(v, h), 1e-8), sum = sharpness + warped;
    double integral = 2.0 * REF_PI * sg->ycocg[0] * sharpness * (1.0 - exp(-2.0 * sum)) / sum; /* one axis for both */
    double fit = ref_mix(ref_mix(0.1, 0.4, m * m), 0.8, n_dot_v);
    return fmax(integral * ref_smith(n_dot_v, n_dot_l, m) * n_dot_l * fit, fmax(sg->ycocg[0], 0.0) / REF_PI);
}

static inline double ref_dominant_factor(double n_dot_v, double r) {
    double q = 0.298475 * log(39.4115 - 39.0029 * r);
    return ref_clamp(q + (1.0 - q) * pow(fmax(1.0 - n_dot_v, 0.0), 10.8649), 0.0, 1.0);
}

static inline void ref_dominant_direction(const double n[3], const double v[3], double r, double out[3]) {
    double g = ref_dominant_factor(ref_cosine(n, v), r), n_dot_v = ref_dot(n, v);
    for (int i = 0; i < 3; ++i) out[i] = ref_mix(n[i], 2.0 * n_dot_v * n[i] - v[i], g);
    ref_normalize(out);
}

static inline double ref_first_order_luma(const ref_sg *sg, const double axis[3]) {
    return fmax((sg->ycocg[0] + 3.0 * ref_dot(sg->moment, axis)) / REF_PI, 0.0);
}

/* ---- re-jitter ------------------------------------------------------------------------------------------------ */

static inline void ref_rejitter_lobes(const double n[3], const double v[3], const double light_d[3],
                                      const double light_s[3], double r, double out[2]) {
    double h[3], m = r * r, n_dot_v = ref_cosine(n, v);
    ref_half_vector(light_d, v, h);
    double n_dot_l = ref_clamp(ref_dot(n, light_d), 0.0, 1.0);
    out[0] = ref_burley(n_dot_v, n_dot_l, ref_cosine(v, h), r) * n_dot_l;
    ref_half_vector(light_s, v, h);
    double across[3], n_dot_h = ref_dot(n, h);
    ref_cross(n, h, across);
    double d = m / (n_dot_h * n_dot_h * m * m + ref_dot(across, across));
    n_dot_l = ref_clamp(ref_dot(n, light_s), 0.0, 1.0);
    out[1] = d * d / REF_PI * ref_smith(n_dot_v, n_dot_l, m) * n_dot_l;
}

static inline void ref_rejitter(const ref_sg *diffuse, const ref_sg *specular, const double v[3], double roughness,
                                double view_z, const double n[3], const double view_z_4[4], const double n_4[4][3],
                                double out[2]) {
    double tolerance = 0.01 * fabs(view_z) / (0.05 + 0.95 * ref_cosine(n, v)), r = fmax(roughness, 0.05);
    double light_d[3], light_s[3], own[2], mean[2] = {0.0, 0.0}, t = ref_roughness_curve(r, 0.5);
    out[0] = out[1] = 1.0;
    for (int k = 0; k < 4; ++k)
        if (fabs(view_z_4[k] - view_z) > tolerance || ref_dot(n, n_4[k]) < 0.01) return;
    ref_light_direction(diffuse, n, light_d);
    ref_light_direction(specular, n, light_s);
    for (int i = 0; i < 3; ++i) light_s[i] = ref_mix(v[i], light_s[i], t);
    ref_normalize(light_s);
    ref_rejitter_lobes(n, v, light_d, light_s, r, own);
    for (int k = 0; k < 4; ++k) {
        double lobes[2];
        ref_rejitter_lobes(n_4[k], v, light_d, light_s, r, lobes);
        for (int i = 0; i < 2; ++i) mean[i] += lobes[i] / 4.0;
    }
    for (int i = 0; i < 2; ++i) out[i] = ref_clamp((own[i] + REF_EPSILON) / (mean[i] + REF_EPSILON), 0.5, 2.0);
}

#endif
