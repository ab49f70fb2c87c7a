/* nrd_reference.h: the functions of nrd_shaders/nrd.glsl in double precision, written from their definitions, for
   tests. Same names with ref_ for nrd_; vectors are arrays. Units, ranges and sources stand in nrd.glsl. */
#ifndef TESTS_NRD_REFERENCE_H
#define TESTS_NRD_REFERENCE_H

#include <float.h>
#include <math.h>
#include <stdbool.h>

enum { REF_RGB10A2_UNORM, REF_RGBA8_UNORM, REF_RGBA8_SNORM, REF_RGBA16_UNORM, REF_RGBA16_SNORM };
enum { REF_LINEAR, REF_SQ_LINEAR, REF_SQRT_LINEAR };

#define REF_MISS 65504.0
#define REF_EPSILON 1e-6

static inline double ref_clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

static inline double ref_mix(double a, double b, double t) {
    return a + (b - a) * t;
}

static inline double ref_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* ---- sanitise and storage ------------------------------------------------------------------------------------- */

static inline bool ref_is_finite3(const double v[3]) {
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

static inline void ref_sanitize_radiance(const double rgb[3], double out[3]) {
    bool finite = ref_is_finite3(rgb);
    for (int i = 0; i < 3; ++i) out[i] = finite ? ref_clamp(rgb[i], 0.0, REF_MISS) : 0.0;
}

static inline double ref_sanitize(double value, double limit) {
    return isfinite(value) ? ref_clamp(value, 0.0, limit) : 0.0;
}

/* 11 significant bits, steps of 2^-24 at the least, ties to even (the default rounding of nearbyint). */
static inline double ref_round_to_half(double value) {
    int exponent;
    frexp(value, &exponent);
    double step = ldexp(1.0, exponent - 11 > -24 ? exponent - 11 : -24);
    return ref_clamp(nearbyint(value / step) * step, -REF_MISS, REF_MISS);
}

/* ---- normal, roughness, material ID --------------------------------------------------------------------------- */

static inline double ref_encode_roughness(double roughness, int encoding) {
    double r = isfinite(roughness) ? ref_clamp(roughness, 0.0, 1.0) : 1.0;
    return encoding == REF_SQ_LINEAR ? r * r : encoding == REF_SQRT_LINEAR ? sqrt(r) : r;
}

static inline double ref_decode_roughness(double channel, int normal_encoding, int encoding) {
    double r = ref_clamp(normal_encoding == REF_RGB10A2_UNORM ? fabs(2.0 * channel - 1.0) : channel, 0.0, 1.0);
    return encoding == REF_SQ_LINEAR ? sqrt(r) : encoding == REF_SQRT_LINEAR ? r * r : r;
}

static inline bool ref_is_biased(int normal_encoding) {
    return normal_encoding == REF_RGBA8_UNORM || normal_encoding == REF_RGBA16_UNORM;
}

static inline void ref_encode_octahedral(const double n[3], double roughness, double out[3]) {
    double sum = fmax(fabs(n[0]) + fabs(n[1]) + fabs(n[2]), REF_EPSILON);
    double sign = n[2] < 0.0 ? -1.0 : 1.0;
    out[0] = (n[0] / sum + n[1] / sum + 1.0) / 2.0;
    out[1] = (n[1] / sum - n[0] / sum + 1.0) / 2.0;
    out[2] = (sign * fmax(roughness, 1.5 / 512.0) + 1.0) / 2.0;
}

static inline void ref_encode_normal_roughness(const double normal[3], double roughness, unsigned material_id,
                                               int normal_encoding, int roughness_encoding, double out[4]) {
    const double zero[3] = {0.0, 0.0, 0.0};
    const double *n = ref_is_finite3(normal) ? normal : zero;
    double stored = ref_encode_roughness(roughness, roughness_encoding);
    if (normal_encoding == REF_RGB10A2_UNORM) {
        ref_encode_octahedral(n, stored, out);
        out[3] = (material_id > 3 ? 3 : material_id) / 3.0;
        return;
    }
    double largest = fmax(fmax(fabs(n[0]), fabs(n[1])), fmax(fabs(n[2]), REF_EPSILON));
    for (int i = 0; i < 3; ++i)
        out[i] = ref_is_biased(normal_encoding) ? (n[i] / largest + 1.0) / 2.0 : n[i] / largest;
    out[3] = stored;
}

/* out: normal, roughness; returns the material ID. */
static inline unsigned ref_decode_normal_roughness(const double t[4], int normal_encoding, int roughness_encoding,
                                                   double out[4]) {
    bool octahedral = normal_encoding == REF_RGB10A2_UNORM;
    double v[3] = {t[0], t[1], t[2]};
    if (octahedral) {
        v[0] = t[0] - t[1];
        v[1] = t[0] + t[1] - 1.0;
        v[2] = (1.0 - fabs(v[0]) - fabs(v[1])) * (t[2] < 0.5 ? -1.0 : 1.0);
    } else if (ref_is_biased(normal_encoding)) {
        for (int i = 0; i < 3; ++i) v[i] = 2.0 * t[i] - 1.0;
    }
    for (int i = 0; i < 3; ++i) out[i] = v[i] / sqrt(fmax(ref_dot(v, v), 1e-9));
    out[3] = ref_decode_roughness(octahedral ? t[2] : t[3], normal_encoding, roughness_encoding);
    return octahedral ? (unsigned)(3.0 * t[3] + 0.5) : 0u;
}

/* ---- hit distance --------------------------------------------------------------------------------------------- */

static inline double ref_trim_hit_dist(double hit_dist, double threshold) {
    return hit_dist < threshold ? 0.0 : hit_dist;
}

static inline double ref_specular_average(const double *hit_dist, int count) {
    double nearest = INFINITY;
    for (int i = 0; i < count; ++i)
        if (hit_dist[i] > 0.0) nearest = fmin(nearest, fmin(hit_dist[i], REF_MISS));
    return isfinite(nearest) ? nearest : 0.0;
}

static inline double ref_diffuse_average(const double *hit_dist, int count) {
    double sum = 0.0, paths = 0.0;
    for (int i = 0; i < count; ++i)
        if (!isnan(hit_dist[i])) sum += ref_clamp(hit_dist[i], 0.0, REF_MISS), paths += 1.0;
    return paths > 0.0 ? sum / paths : 0.0;
}

static inline double ref_mix_diffuse_hit_dist(double indirect, double direct, double luma_indirect,
                                              double luma_direct) {
    return ref_mix(indirect, direct, fmin(luma_direct / (luma_direct + luma_indirect + REF_EPSILON), 0.5));
}

static inline double ref_roughness_curve(double r, double power) {
    return (1.0 - exp2(-200.0 * r * r)) * pow(r, power);
}

static inline double ref_hit_dist_scale(double view_z, double r, const double params[4], int parameter_count) {
    double base = params[0] + fabs(view_z) * params[1];
    if (parameter_count == 3) return base * ref_mix(params[2], 1.0, ref_roughness_curve(r, 0.5));
    return base * ref_mix(1.0, params[2], ref_clamp(exp2(params[3] * r * r), 0.0, 1.0));
}

static inline double ref_normalize_hit_dist(double hit_dist, double view_z, double r, const double params[4]) {
    if (isnan(hit_dist)) return 0.0;
    if (hit_dist >= REF_MISS) return 1.0;
    return ref_clamp(hit_dist / ref_hit_dist_scale(view_z, r, params, 4), 0.0, 1.0);
}

/* ---- radiance ------------------------------------------------------------------------------------------------- */

static inline void ref_rgb_to_ycocg(const double rgb[3], double out[3]) {
    out[0] = rgb[0] / 4.0 + rgb[1] / 2.0 + rgb[2] / 4.0;
    out[1] = (rgb[0] - rgb[2]) / 2.0;
    out[2] = -rgb[0] / 4.0 + rgb[1] / 2.0 - rgb[2] / 4.0;
}

static inline void ref_ycocg_to_rgb(const double ycocg[3], bool clamped, double out[3]) {
    double t = ycocg[0] - ycocg[2];
    out[0] = t + ycocg[1];
    out[1] = ycocg[0] + ycocg[2];
    out[2] = t - ycocg[1];
    for (int i = 0; i < 3 && clamped; ++i) out[i] = fmax(out[i], 0.0);
}

static inline void ref_pack_radiance_hit_dist(const double rgb[3], double norm_hit_dist, bool sanitize,
                                              double out[4]) {
    double legal[3] = {rgb[0], rgb[1], rgb[2]};
    if (sanitize) ref_sanitize_radiance(rgb, legal);
    ref_rgb_to_ycocg(legal, out);
    out[3] = sanitize ? ref_sanitize(norm_hit_dist, 1.0) : norm_hit_dist;
}

/* ---- material ------------------------------------------------------------------------------------------------- */

static inline double ref_environment_bias(double v, double m) {
    double m3 = m * m * m, v3 = v * v * v;
    return ((0.99044 - 1.28514 * v) + m * (1.29678 - 0.755907 * v)) /
           ((1.0 + 2.92338 * v + 59.4188 * v3) + m * (20.3225 - 27.0302 * v + 222.592 * v3) +
            m3 * (121.563 + 626.13 * v + 316.627 * v3));
}

static inline double ref_environment_scale(double v, double m) {
    double m3 = m * m * m, v2 = v * v, v3 = v * v * v;
    return ((0.0365463 + 3.32707 * v) + m * (9.0632 - 9.04756 * v)) /
           ((1.0 + 3.59685 * v2 - 1.36772 * v3) + m * (9.04401 - 16.3174 * v2 + 9.22949 * v3) +
            m3 * (5.56589 + 19.7886 * v2 - 20.2123 * v3));
}

static inline double ref_environment_term(double rf0, double n_dot_v, double r) {
    double m = r * r;
    return ref_clamp(rf0 * ref_environment_scale(n_dot_v, m) + ref_environment_bias(n_dot_v, m), 0.0, 1.0);
}

static inline void ref_material_factors(const double normal[3], const double view[3], const double albedo[3],
                                        const double rf0[3], double r, double diffuse[3], double specular[3]) {
    double n_dot_v = fmin(fabs(ref_dot(normal, view)), 1.0);
    for (int i = 0; i < 3; ++i) {
        double f = ref_environment_term(rf0[i], n_dot_v, r);
        diffuse[i] = ref_mix(0.02, 1.0, (1.0 - f) * albedo[i]);
        specular[i] = ref_mix(0.02, 1.0, f * ref_mix(0.1, 1.0, r));
    }
}

/* ---- motion --------------------------------------------------------------------------------------------------- */

static inline void ref_clip_to_uv(const double clip[4], double uv[2]) {
    for (int i = 0; i < 2; ++i) uv[i] = clip[3] > 0.0 ? (clip[i] / clip[3] + 1.0) / 2.0 : -1.0;
}

static inline void ref_motion_2_5d(const double clip[4], double view_z, const double clip_prev[4],
                                   double view_z_prev, double out[3]) {
    double uv[2], uv_prev[2];
    ref_clip_to_uv(clip, uv);
    ref_clip_to_uv(clip_prev, uv_prev);
    out[0] = uv_prev[0] - uv[0];
    out[1] = uv_prev[1] - uv[1];
    out[2] = view_z_prev - view_z;
}

#endif
