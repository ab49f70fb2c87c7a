/* Built with -DSH: where a signal's light comes from. It goes through the averages over time, of the pre-pass and of the dense filter step with
   the weights of the colours; in the sparse steps it stays as it is. A pixel keeps it relative to its luma, so that edits of luma need not touch it:
   xyz   mean of direction times luma, over luma; length at most 1, world space
   w     gain: luma under the pixel's own normal over luma, [1/4, 4]
   An average over pixels shows light on their mean normal; right after it, the gain rises or falls by how much more or less of that light
   the pixel's own normal sees. Where all of them face the same way nothing changes, and the mean over many pixels does not either.
   First-order light: R. Ramamoorthi, P. Hanrahan, "An Efficient Representation for Irradiance Environment Maps", SIGGRAPH 2001. */
#ifndef LIGHT_GLSL
#define LIGHT_GLSL

#ifdef SH
#define SH_ONLY(code) code
#else
#define SH_ONLY(code)
#endif

#ifdef SH
struct LightSums {
    vec3 moment;       /* sum of weight * luma * xyz */
    float resolved;    /* sum of weight * luma * gain */
    vec3 normal;       /* sum of weight * normal */
};

/* What light meets. */
struct Receiver {
    vec3 normal;       /* world, as stored */
    vec3 view;         /* to the camera, world; of the specular signal */
    float roughness;
};

const float LEAST_COSINE = 0.2;      /* of light to the normal: light along the surface says little about other normals */
const float LEAST_LOBE = 0.01;       /* squared width of the specular lobe below which stored normals are too coarse */
const float NOISE = 2.0;             /* squared deviations of noise that a direction must exceed; 1 to 6 tried: less adds noise to glossy bumps */
const float FILTERED_SAMPLES = 4.0;  /* samples per frame of history, once the first filter has pooled them */
const float SAME_NORMAL = 5e-4;      /* 1 - cos of 1.8 degrees: where the mean is so near, nothing is turned */
const float LARGEST_TURN = 0.5;      /* by one average, of luma; 0.3 to 3 tried: more recovers a little more and is brighter (3: by 13 %), as turns are skewed */

LightSums no_light() { return LightSums(vec3(0.0), 0.0, vec3(0.0)); }

void add_light(inout LightSums s, vec4 light, float luma, vec3 normal, float w)
{
    s.moment += w * luma * light.xyz;
    s.resolved += w * luma * light.w;
    s.normal += w * normal;
}

/* What of a mean over `count` samples is more than their noise, of which each has `variance`: [0,1]. */
float certain_share(float squared, float variance, float count) { return clamp(1.0 - NOISE * variance / (max(count, 1.0) * squared + 1e-12), 0.0, 1.0); }

/* The gradient of a lobe's mean is the mean half vector's way from the mean normal over the variance of half vectors about their normal, if
   light varies smoothly; a single direction has that of ln D of GGX, 4 over the squared way in its tails. What goes along the mean normal
   counts as far as light comes from a single direction, as in diffuse_turn. Half vectors of GGX: B. Walter et al., "Microfacet Models
   for Refraction through Rough Surfaces", EGSR 2007, equation 35. */
float specular_turn(Receiver r, vec3 moment, vec3 mean_normal, float count)
{
    float alpha = r.roughness * r.roughness, width = clamp(alpha * alpha, LEAST_LOBE, 0.99), narrow = 1.0 - width;
    float variance = 0.5 * width * (-log(width) - narrow) / (narrow * narrow);   /* along either tangent */
    vec3 direction = moment * inversesqrt(dot(moment, moment) + 1e-30) + r.view;
    vec3 half_vector = direction * inversesqrt(dot(direction, direction) + 1e-12);
    float size = length(mean_normal), along = dot(half_vector, mean_normal) / max(size, 1e-6);
    vec3 axis = mean_normal / max(size, 1e-6), across = half_vector - axis * along;
    across *= certain_share(dot(across, across), 2.0 * variance, count);
    float aside = dot(across, across), single = aside / (aside + variance);
    return narrow / (variance + 0.25 * aside) * (dot(across, r.normal) + single * along * (dot(axis, r.normal) - size));
}

/* Takes the light for one part from everywhere, whose mean direction follows the normals (2/3 of the mean normal under a cosine lobe), and
   one from a single direction: mean direction and luma tell both, and only the second changes with the normal. Either part then has
   a change of 0 in the mean over pixels; anything else would add up in history. */
float diffuse_turn(Receiver r, vec3 moment, float luma, vec3 mean_normal, float count)
{
    float size = length(mean_normal), k = size * (2.0 / 3.0);
    vec3 axis = mean_normal / max(size, 1e-6), direction = moment / (max(luma, 1e-30) * max(size, 1e-6));
    float along = dot(direction, axis), q = along - 2.0 / 3.0;
    vec3 across = direction - axis * along;
    across *= certain_share(dot(across, across), 0.5, count);
    float p2 = dot(across, across), rest = sqrt(p2 * (1.0 - k * k) + q * q) - k * q, scale = rest / max(p2 + q * q, 1e-8);
    float cosine = k + q * scale;   /* of the single direction; its light is (across / cosine, 1 / scale) across and along the normal */
    return dot(across, r.normal) / max(cosine, LEAST_COSINE) + (cosine > LEAST_COSINE ? (dot(axis, r.normal) - size) / max(scale, 1e-3) : 0.0);
}

/* Change of luma, in parts of it, from the mean to the own normal. moment: any positive multiple of luma * xyz; luma: the same
   multiple; count: samples behind them. */
float own_normal_turn(Receiver r, int signal, vec3 moment, float luma, vec3 mean_normal, float count)
{
    if (dot(mean_normal, r.normal) > 1.0 - SAME_NORMAL) return 0.0;
    float turn = 0.0;
#ifdef SPECULAR
    if (signal == SPECULAR_SIGNAL) turn = specular_turn(r, moment, mean_normal, count);
#endif
    if (signal != SPECULAR_SIGNAL) turn = diffuse_turn(r, moment, luma, mean_normal, count);
    return clamp(turn, -LARGEST_TURN, LARGEST_TURN);
}

vec4 relative_light(vec3 moment, float resolved, float luma)
{
    if (!(luma > 1e-7)) return vec4(0.0, 0.0, 0.0, 1.0);
    vec3 direction = moment / luma;
    return vec4(direction * min(inversesqrt(dot(direction, direction) + 1e-12), 1.0), clamp(resolved / luma, 0.25, 4.0));
}

/* After an average. mean_normal: world; count: samples that went into it. */
vec4 finish_light(LightSums s, Receiver r, int signal, vec3 mean_normal, float luma_sum, float count)
{
    return relative_light(s.moment, s.resolved + luma_sum * own_normal_turn(r, signal, s.moment, luma_sum, mean_normal, count), luma_sum);
}

/* Between the filter's steps one texel holds the lights of all signals, packed. */
#if defined(DIFFUSE) && defined(SPECULAR)
#define LIGHTS_FORMAT rg32ui
#else
#define LIGHTS_FORMAT r32ui
#endif

/* In 32 bits: 8 per component, -1 to 1 as 1 to 255, the gain as a logarithm. */
uint pack_light(vec4 light) { return packSnorm4x8(vec4(light.xyz, 0.5 * log2(light.w))) ^ 0x80808080u; }

/* By bytes in the fractions of floats in [1, 2): conversions run at a quarter of the rate. */
vec4 unpack_light(uint word)
{
    uvec4 fraction = uvec4(word << 15, word << 7, word >> 1, word >> 9) & 0x7f8000u;
    vec4 light = uintBitsToFloat(fraction | 0x3f800000u) * (256.0 / 127.0) - (384.0 / 127.0);
    return vec4(light.xyz, exp2(2.0 * light.w));
}
#endif

#endif
