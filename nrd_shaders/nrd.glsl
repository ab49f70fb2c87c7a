// nrd.glsl: packing and unpacking for the shaders of an application that feeds the denoisers and composes the result.
//
// Usage: enable an include extension (GL_GOOGLE_include_directive or GL_ARB_shading_language_include) and include this
// file in a ray generation, closest hit, miss, compute or fragment shader, GLSL 4.50 or later. It declares functions,
// one struct and macros, nothing else: no bindings, no variables, no extensions, no 16-bit types. Public names start
// with nrd_ / NRD_; names that start with nrdi_ / NRDI_ are private and may change. The passes of the denoisers decode
// with these same functions, so an application and the denoisers agree bit for bit.
//
// Order of use
//   ray generation   nrd_trim_hit_dist -> average over paths -> nrd_normalize_hit_dist -> nrd_demodulate
//                    -> nrd_pack_radiance_hit_dist; guides: nrd_pack_normal_roughness, nrd_motion_2_5d
//   composition      nrd_unpack_radiance_hit_dist -> nrd_modulate with the factors that ray generation used
//
// Contract of every input (a "unit" is the world unit of the application; the same one everywhere)
//   normal           world space, unit length. Not finite or (0,0,0): stored as a finite texel, direction undefined
//   roughness        linear (perceptual), [0,1]; GGX alpha is its square. 0 is a mirror. Diffuse signals use 1 wherever
//                    a roughness is asked for. Not finite: 1
//   material_id      [0,3], integer, carried by the RGB10A2 encoding only; every other encoding reads back 0
//   view_z           depth of the surface along the view axis, units. The sign is ignored
//   hit_dist         distance from the surface to the first hit of the path, units, >= 0; never divided by a
//                    probability. Exactly 0: the lobe was not sampled in this pixel. NRD_HIT_DIST_MISS or more
//                    (+Inf included): the ray left the scene
//   norm_hit_dist    hit_dist divided by nrd_hit_dist_scale, [0,1]. Exactly 0: not sampled. 1: far away or a miss
//   params           hit distance parameters (A,B,C,D); the denoiser's settings must hold the same four numbers
//                      A  constant part, units, > 0, default 3 metres          (x)
//                      B  growth with depth, >= 0, default 0.1; 0: none        (y)
//                      C  factor at roughness 0, >= 1, default 20; 1: none     (z)
//                      D  decay of that factor with roughness, <= 0, default -25; ignored by the 3-parameter form (w)
//   radiance         linear RGB, not multiplied by exposure, demodulated, >= 0, useful up to 65504
//   albedo, rf0      diffuse reflectance and specular reflectance at normal incidence, linear RGB, [0,1]
//   view             world space, unit length, from the surface to the camera
//   uv               [0,1] over the image, y down; pixel centres at (pixel + 0.5) / size; never jittered
//
// Choices, to be defined before the include and told to the denoiser in its description
//   NRD_NORMAL_FORMAT     one of NRD_NORMAL_FORMAT_...;    default NRD_NORMAL_FORMAT_RGB10A2_UNORM
//   NRD_ROUGHNESS_FORMAT  one of NRD_ROUGHNESS_FORMAT_...; default NRD_ROUGHNESS_FORMAT_LINEAR
//   NRD_HIT_DIST_FORM       one of NRD_HIT_DIST_FORM_...;      default NRD_HIT_DIST_FORM_4_PARAMETERS
//
// Licence: MIT, see LICENSE.

#ifndef NRD_SHADERS_NRD_GLSL
#define NRD_SHADERS_NRD_GLSL

//----------------------------------------------------------------------------------------------------------------------
// >>encodings: values shared with nrd.h
//----------------------------------------------------------------------------------------------------------------------

#ifndef NRD_NORMAL_FORMAT_RGB10A2_UNORM
#define NRD_NORMAL_FORMAT_RGB10A2_UNORM 0 // octahedral normal in xy, signed roughness in z, material ID in w
#endif
#ifndef NRD_NORMAL_FORMAT_RGBA8_UNORM
#define NRD_NORMAL_FORMAT_RGBA8_UNORM 1 // normal scaled to unit maximum component, biased to [0,1]; roughness in w
#endif
#ifndef NRD_NORMAL_FORMAT_RGBA8_SNORM
#define NRD_NORMAL_FORMAT_RGBA8_SNORM 2 // normal scaled to unit maximum component; roughness in w
#endif
#ifndef NRD_NORMAL_FORMAT_RGBA16_UNORM
#define NRD_NORMAL_FORMAT_RGBA16_UNORM 3 // as RGBA8_UNORM
#endif
#ifndef NRD_NORMAL_FORMAT_RGBA16_SNORM
#define NRD_NORMAL_FORMAT_RGBA16_SNORM 4 // as RGBA8_SNORM; textures of 16- and 32-bit floats use this one too
#endif

#ifndef NRD_ROUGHNESS_FORMAT_LINEAR
#define NRD_ROUGHNESS_FORMAT_LINEAR 0 // stores r
#endif
#ifndef NRD_ROUGHNESS_FORMAT_SQ_LINEAR
#define NRD_ROUGHNESS_FORMAT_SQ_LINEAR 1 // stores r * r
#endif
#ifndef NRD_ROUGHNESS_FORMAT_SQRT_LINEAR
#define NRD_ROUGHNESS_FORMAT_SQRT_LINEAR 2 // stores sqrt(r)
#endif

#ifndef NRD_HIT_DIST_FORM_4_PARAMETERS
#define NRD_HIT_DIST_FORM_4_PARAMETERS 0 // roughness factor from C and D
#endif
#ifndef NRD_HIT_DIST_FORM_3_PARAMETERS
#define NRD_HIT_DIST_FORM_3_PARAMETERS 1 // roughness factor from C alone
#endif

#ifndef NRD_NORMAL_FORMAT
#define NRD_NORMAL_FORMAT NRD_NORMAL_FORMAT_RGB10A2_UNORM
#endif
#ifndef NRD_ROUGHNESS_FORMAT
#define NRD_ROUGHNESS_FORMAT NRD_ROUGHNESS_FORMAT_LINEAR
#endif
#ifndef NRD_HIT_DIST_FORM
#define NRD_HIT_DIST_FORM NRD_HIT_DIST_FORM_4_PARAMETERS
#endif

// Hit distance to write for a ray that left the scene: the largest 16-bit float.
#define NRD_HIT_DIST_MISS 65504.0

#define NRDI_HALF_MAX 65504.0
#define NRDI_EPSILON 1e-6

//----------------------------------------------------------------------------------------------------------------------
// >>sanitise: containment of NaN and Inf
//----------------------------------------------------------------------------------------------------------------------

// The exponent bits decide: compilers may assume that isnan() and isinf() are false.

// True for every number, false for NaN and the infinities.
bool nrd_is_finite(float value)
{
    return (floatBitsToUint(value) & 0x7f800000u) != 0x7f800000u;
}

// True if all three components are finite. Loops over many paths use it to skip a bad sample before it enters a sum.
bool nrd_is_finite(vec3 value)
{
    return nrd_is_finite(value.x) && nrd_is_finite(value.y) && nrd_is_finite(value.z);
}

bool nrdi_is_nan(float value)
{
    return (floatBitsToUint(value) & 0x7fffffffu) > 0x7f800000u;
}

// (0,0,0) if any component is NaN or Inf, else clamped to [0,65504].
vec3 nrd_sanitize_radiance(vec3 radiance)
{
    return nrd_is_finite(radiance) ? clamp(radiance, vec3(0.0), vec3(NRDI_HALF_MAX)) : vec3(0.0);
}

// Units. 0 if NaN or Inf, else clamped to [0,65504]. A miss that a tracer reports as +Inf has to be replaced by
// NRD_HIT_DIST_MISS (or normalised) first: here, at the door of a texture, Inf counts as a defect.
float nrd_sanitize_hit_dist(float hit_dist)
{
    return nrd_is_finite(hit_dist) ? clamp(hit_dist, 0.0, NRDI_HALF_MAX) : 0.0;
}

// Normalised. 0 if NaN or Inf, else clamped to [0,1].
float nrd_sanitize_norm_hit_dist(float norm_hit_dist)
{
    return nrd_is_finite(norm_hit_dist) ? clamp(norm_hit_dist, 0.0, 1.0) : 0.0;
}

//----------------------------------------------------------------------------------------------------------------------
// >>storage: rounding for 16-bit floats
//----------------------------------------------------------------------------------------------------------------------

// Nearest value that a 16-bit float holds, ties to even, overflow to +-65504; the input must be finite. Use it on what
// is stored to a 16-bit float image: image stores may truncate toward zero, and a history that is read, blended and
// truncated every frame drifts to black (to 0.988 of the truth in 300 frames at a blend factor of 1/32). Done on the
// bits, because packHalf2x16 may truncate as well: its rounding is left to the device.
vec4 nrd_round_to_half(vec4 value)
{
    uvec4 bits = floatBitsToUint(value);
    vec4 normal = uintBitsToFloat((bits + 0xfffu + ((bits >> 13u) & 1u)) & 0xffffe000u);
    vec4 subnormal = roundEven(value * 16777216.0) * (1.0 / 16777216.0); // steps of 2^-24 below 2^-14
    vec4 rounded = mix(normal, subnormal, lessThan(abs(value), vec4(1.0 / 16384.0)));
    return clamp(rounded, vec4(-NRDI_HALF_MAX), vec4(NRDI_HALF_MAX));
}

vec3 nrd_round_to_half(vec3 value)
{
    return nrd_round_to_half(vec4(value, 0.0)).xyz;
}

vec2 nrd_round_to_half(vec2 value)
{
    return nrd_round_to_half(vec4(value, 0.0, 0.0)).xy;
}

float nrd_round_to_half(float value)
{
    return nrd_round_to_half(vec4(value)).x;
}

//----------------------------------------------------------------------------------------------------------------------
// >>normal_roughness: normal, roughness and material ID in one texel
//----------------------------------------------------------------------------------------------------------------------

// What one texel of the normal and roughness guide says.
struct nrd_surface {
    vec3 normal;      // world space, unit length
    float roughness;  // linear, [0,1]
    uint material_id; // [0,3]; 0 where the encoding carries none
};

float nrdi_encode_roughness(float roughness, uint roughness_encoding)
{
    float r = nrd_is_finite(roughness) ? clamp(roughness, 0.0, 1.0) : 1.0;
    if (roughness_encoding == NRD_ROUGHNESS_FORMAT_SQ_LINEAR)
        return r * r;
    return roughness_encoding == NRD_ROUGHNESS_FORMAT_SQRT_LINEAR ? sqrt(r) : r;
}

// Decodes the one channel that holds roughness: z of the RGB10A2 encoding, w of the others. For gathers of that channel
// alone; nrd_decode_normal_roughness gives the same value.
float nrd_decode_roughness(float channel, uint normal_encoding, uint roughness_encoding)
{
    float stored = normal_encoding == NRD_NORMAL_FORMAT_RGB10A2_UNORM ? abs(channel * 2.0 - 1.0) : channel;
    float r = clamp(stored, 0.0, 1.0);
    if (roughness_encoding == NRD_ROUGHNESS_FORMAT_SQ_LINEAR)
        return sqrt(r);
    return roughness_encoding == NRD_ROUGHNESS_FORMAT_SQRT_LINEAR ? r * r : r;
}

bool nrdi_is_biased(uint normal_encoding)
{
    return normal_encoding == NRD_NORMAL_FORMAT_RGBA8_UNORM || normal_encoding == NRD_NORMAL_FORMAT_RGBA16_UNORM;
}

// The octahedron's |x| + |y| <= 1 diamond, turned by 45 degrees, fills the unit square exactly (Cigolle et al. 2014,
// "A Survey of Efficient Representations for Independent Unit Vectors", hemispherical form), so nothing is folded and
// neighbouring texels may be compared. The sign of z travels as the sign of roughness; roughness is therefore kept
// 1.5 steps of 1/512 away from 0, the least that survives 10 bits.
vec3 nrdi_encode_octahedral(vec3 normal, float stored_roughness)
{
    vec3 n = normal / max(abs(normal.x) + abs(normal.y) + abs(normal.z), NRDI_EPSILON);
    float signed_roughness = max(stored_roughness, 1.5 / 512.0) * (normal.z < 0.0 ? -1.0 : 1.0);
    return vec3(n.x + n.y, n.y - n.x, signed_roughness) * 0.5 + 0.5;
}

vec3 nrdi_decode_octahedral(vec3 encoded)
{
    vec2 xy = vec2(encoded.x - encoded.y, encoded.x + encoded.y - 1.0);
    float z = 1.0 - abs(xy.x) - abs(xy.y);
    return vec3(xy, encoded.z < 0.5 ? -z : z);
}

// The texel for a normal and roughness guide whose encodings are arguments (values NRD_NORMAL_FORMAT_... and
// NRD_ROUGHNESS_FORMAT_...), for code where they are specialization constants.
// Angle error after storage: RGB10A2 <= 0.137 degrees, RGBA8 <= 0.32, RGBA16 <= 0.00125 (16-bit float <= 0.016);
// roughness error in RGB10A2 <= 0.00098 for roughness >= 0.006 (linear encoding). Scaling by the largest component
// instead of the length uses the whole cube of codes, which lowers the error of the encodings that store three of them.
vec4 nrd_encode_normal_roughness(vec3 normal, float roughness, uint material_id, uint normal_encoding,
                                 uint roughness_encoding)
{
    vec3 n = nrd_is_finite(normal) ? normal : vec3(0.0);
    float stored = nrdi_encode_roughness(roughness, roughness_encoding);
    if (normal_encoding == NRD_NORMAL_FORMAT_RGB10A2_UNORM)
        return vec4(nrdi_encode_octahedral(n, stored), float(min(material_id, 3u)) / 3.0);

    n /= max(max(abs(n.x), abs(n.y)), max(abs(n.z), NRDI_EPSILON));
    return vec4(nrdi_is_biased(normal_encoding) ? n * 0.5 + 0.5 : n, stored);
}

// Inverse of nrd_encode_normal_roughness. A texel of zeros decodes to finite numbers under every encoding.
nrd_surface nrd_decode_normal_roughness(vec4 texel, uint normal_encoding, uint roughness_encoding)
{
    bool octahedral = normal_encoding == NRD_NORMAL_FORMAT_RGB10A2_UNORM;
    vec3 n = nrdi_is_biased(normal_encoding) ? texel.xyz * 2.0 - 1.0 : texel.xyz;
    if (octahedral)
        n = nrdi_decode_octahedral(texel.xyz);

    nrd_surface surface;
    surface.normal = n * inversesqrt(dot(n, n) + 1e-9);
    surface.roughness = nrd_decode_roughness(octahedral ? texel.z : texel.w, normal_encoding, roughness_encoding);
    surface.material_id = octahedral ? uint(texel.w * 3.0 + 0.5) : 0u;
    return surface;
}

// The texel under the encodings chosen by NRD_NORMAL_FORMAT and NRD_ROUGHNESS_FORMAT.
vec4 nrd_pack_normal_roughness(vec3 normal, float roughness, uint material_id)
{
    return nrd_encode_normal_roughness(normal, roughness, material_id, NRD_NORMAL_FORMAT, NRD_ROUGHNESS_FORMAT);
}

// Inverse of nrd_pack_normal_roughness.
nrd_surface nrd_unpack_normal_roughness(vec4 texel)
{
    return nrd_decode_normal_roughness(texel, NRD_NORMAL_FORMAT, NRD_ROUGHNESS_FORMAT);
}

//----------------------------------------------------------------------------------------------------------------------
// >>hit_distance: trimming, averaging over paths, normalisation
//----------------------------------------------------------------------------------------------------------------------

// 0 below the threshold, else hit_dist. Offsets of ray origins turn rays that start inside a surface into hits at tiny
// distances; threshold is that offset, units. 0: nothing is trimmed.
float nrd_trim_hit_dist(float hit_dist, float threshold)
{
    return hit_dist < threshold ? 0.0 : hit_dist;
}

// Hit distance of the specular lobe over several paths of one pixel: the nearest, because motion of reflections is
// tracked with it.   acc = begin(); for each specular path: acc = add(acc, hit_dist); result = end(acc);
// The start value is the largest float and so above every distance, whatever the unit.
float nrd_specular_hit_dist_begin()
{
    return uintBitsToFloat(0x7f7fffffu);
}

// Ignores 0, negative values and NaN. A miss counts as NRD_HIT_DIST_MISS.
float nrd_specular_hit_dist_add(float accumulated, float hit_dist)
{
    bool valid = !nrdi_is_nan(hit_dist) && hit_dist > 0.0;
    return valid ? min(accumulated, min(hit_dist, NRD_HIT_DIST_MISS)) : accumulated;
}

// The nearest distance, or 0 (not sampled) if nothing valid was added.
float nrd_specular_hit_dist_end(float accumulated)
{
    return accumulated <= NRD_HIT_DIST_MISS ? accumulated : 0.0;
}

// Hit distance of the diffuse lobe, and of occlusion, over several paths of one pixel: the arithmetic mean over the
// paths of that lobe. Same order of calls as above. Average normalised distances: one miss among raw ones hides them.
vec2 nrd_diffuse_hit_dist_begin()
{
    return vec2(0.0);
}

// accumulated = (sum, number of paths). NaN is skipped and does not count. A miss counts as NRD_HIT_DIST_MISS.
vec2 nrd_diffuse_hit_dist_add(vec2 accumulated, float hit_dist)
{
    return nrdi_is_nan(hit_dist) ? accumulated : accumulated + vec2(clamp(hit_dist, 0.0, NRD_HIT_DIST_MISS), 1.0);
}

// The mean, or 0 (not sampled) if nothing was added.
float nrd_diffuse_hit_dist_end(vec2 accumulated)
{
    return accumulated.x / max(accumulated.y, 1.0);
}

// Diffuse hit distance of a pixel that holds direct and indirect light, from the luminances of both: the distance to
// the light gets a share of at most one half, which sharpens its shadows.
float nrd_mix_diffuse_hit_dist(float hit_dist_indirect, float hit_dist_direct, float luma_indirect, float luma_direct)
{
    float share = luma_direct / (luma_direct + luma_indirect + NRDI_EPSILON);
    return mix(hit_dist_indirect, hit_dist_direct, min(share, 0.5));
}

// (1 - 2^(-200 r^2)) r^p: 0 for a mirror, rises fast, equals r^p above a roughness of about 0.15. Bridges "mirror" and
// "rough" behaviour without a threshold. power > 0.
float nrd_roughness_curve(float roughness, float power)
{
    return (1.0 - exp2(-200.0 * roughness * roughness)) * pow(roughness, power);
}

// Distance, units, that counts as 1 after normalisation, under an explicit form (NRD_HIT_DIST_FORM_...).
//   4 parameters   (A + |view_z| B) mix(1, C, min(2^(D r^2), 1))
//   3 parameters   (A + |view_z| B) mix(C, 1, nrd_roughness_curve(r, 0.5))
// The two differ by up to a factor of 5 at medium roughness: occlusion of one is not comparable with that of the other.
float nrd_hit_dist_scale_of_form(float view_z, float roughness, vec4 params, uint form)
{
    float base = params.x + abs(view_z) * params.y;
    if (form == NRD_HIT_DIST_FORM_3_PARAMETERS)
        return base * mix(params.z, 1.0, nrd_roughness_curve(roughness, 0.5));
    return base * mix(1.0, params.z, clamp(exp2(params.w * roughness * roughness), 0.0, 1.0));
}

// The same under NRD_HIT_DIST_FORM.
float nrd_hit_dist_scale(float view_z, float roughness, vec4 params)
{
    return nrd_hit_dist_scale_of_form(view_z, roughness, params, NRD_HIT_DIST_FORM);
}

// hit_dist / nrd_hit_dist_scale, clamped to [0,1]. 0 gives exactly 0, NRD_HIT_DIST_MISS and more give exactly 1, NaN
// and negative values give 0. Normalised diffuse distances are samples of ambient occlusion over that range, specular
// ones of specular occlusion.
float nrd_normalize_hit_dist(float hit_dist, float view_z, float roughness, vec4 params)
{
    if (nrdi_is_nan(hit_dist) || hit_dist <= 0.0)
        return 0.0;
    if (hit_dist >= NRD_HIT_DIST_MISS)
        return 1.0;
    return clamp(hit_dist / nrd_hit_dist_scale(view_z, roughness, params), 0.0, 1.0);
}

// Inverse of nrd_normalize_hit_dist for the same view_z, roughness and params; units. 1 gives the scale itself: what
// lay beyond is lost.
float nrd_denormalize_hit_dist(float norm_hit_dist, float view_z, float roughness, vec4 params)
{
    return norm_hit_dist * nrd_hit_dist_scale(view_z, roughness, params);
}

//----------------------------------------------------------------------------------------------------------------------
// >>radiance: colour space and the radiance texel
//----------------------------------------------------------------------------------------------------------------------

// Luma and two signed chroma values (Malvar & Sullivan 2003, "YCoCg-R", the lossy form without lifting): x = Y,
// y = Co, z = Cg. Linear, so blending commutes with it; exact powers of two keep 16-bit round trips tight.
vec3 nrd_rgb_to_ycocg(vec3 rgb)
{
    return vec3(dot(rgb, vec3(0.25, 0.5, 0.25)), (rgb.x - rgb.z) * 0.5, dot(rgb, vec3(-0.25, 0.5, -0.25)));
}

// Exact inverse; components are negative where chroma exceeds luma, as after a sharpening filter.
vec3 nrd_ycocg_to_rgb_unclamped(vec3 ycocg)
{
    float t = ycocg.x - ycocg.z;
    return vec3(t + ycocg.y, ycocg.x + ycocg.z, t - ycocg.y);
}

// Inverse with every component >= 0.
vec3 nrd_ycocg_to_rgb(vec3 ycocg)
{
    return max(nrd_ycocg_to_rgb_unclamped(ycocg), vec3(0.0));
}

// Luma of linear RGB: the Y of nrd_rgb_to_ycocg, the only luma that the denoisers use.
float nrd_luma(vec3 rgb)
{
    return dot(rgb, vec3(0.25, 0.5, 0.25));
}

// The texel of a noisy radiance input: (Y, Co, Cg, norm_hit_dist). Chroma is signed: the format must be a signed float.
// sanitize: replace NaN and Inf by 0 and clamp to the legal range; pass false only for values known to be legal. For
// multiple paths: radiance is the sum over all paths divided by their number, norm_hit_dist as described above.
vec4 nrd_pack_radiance_hit_dist(vec3 radiance, float norm_hit_dist, bool sanitize)
{
    vec3 rgb = sanitize ? nrd_sanitize_radiance(radiance) : radiance;
    return vec4(nrd_rgb_to_ycocg(rgb), sanitize ? nrd_sanitize_norm_hit_dist(norm_hit_dist) : norm_hit_dist);
}

// Inverse: (R, G, B, w), colour >= 0. w of a denoised texel is occlusion in [0,1], or the length of history in frames
// when the denoiser was told to write that.
vec4 nrd_unpack_radiance_hit_dist(vec4 texel)
{
    return vec4(nrd_ycocg_to_rgb(texel.xyz), texel.w);
}

//----------------------------------------------------------------------------------------------------------------------
// >>material: demodulation
//----------------------------------------------------------------------------------------------------------------------

// A denoiser should see light without texture: ray generation divides radiance by the factors below, composition
// multiplies by the same factors. Emission, sky and noise-free direct light are not denoised; add them afterwards.

// Smallest factors. They bound how much noise a division can amplify; both sides must use the same values.
#define NRDI_MIN_FACTOR 0.02
#define NRDI_MIN_SPECULAR_SCALE 0.1 // at roughness 0; reaches 1 at roughness 1

// Diffuse albedo and rf0 of the base colour and metalness model; dielectrics have an rf0 of 0.04. metalness [0,1].
void nrd_base_color_to_albedo_rf0(vec3 base_color, float metalness, out vec3 albedo, out vec3 rf0)
{
    albedo = base_color * (1.0 - metalness);
    rf0 = mix(vec3(0.04), base_color, metalness);
}

// Reflectance of a GGX lobe with Schlick's Fresnel term under constant lighting, [0,1] per component: the rational fit
// of the split-sum integral from Ray Tracing Gems (2019), chapter 32. n_dot_v [0,1]. Written as polynomials: the order
// of the published matrices' elements differs between shading languages.
vec3 nrd_environment_term(vec3 rf0, float n_dot_v, float roughness)
{
    float v = n_dot_v;
    float v2 = v * v;
    float v3 = v2 * v;
    float m = roughness * roughness;
    float m3 = m * m * m;

    float bias = (0.99044 - 1.28514 * v) + m * (1.29678 - 0.755907 * v);
    float bias_divisor = (1.0 + 2.92338 * v + 59.4188 * v3) + m * (20.3225 - 27.0302 * v + 222.592 * v3) +
                         m3 * (121.563 + 626.13 * v + 316.627 * v3);
    float scale = (0.0365463 + 3.32707 * v) + m * (9.0632 - 9.04756 * v);
    float scale_divisor = (1.0 + 3.59685 * v2 - 1.36772 * v3) + m * (9.04401 - 16.3174 * v2 + 9.22949 * v3) +
                          m3 * (5.56589 + 19.7886 * v2 - 20.2123 * v3);
    return clamp(rf0 * (scale / max(scale_divisor, NRDI_EPSILON)) + bias / max(bias_divisor, NRDI_EPSILON), 0.0, 1.0);
}

// Demodulation factors, each component in [0.02,1]. Black albedo (metals) gives a diffuse factor of 0.02. The specular
// factor's own dependence on roughness is no physics: it cancels, because both sides apply it.
void nrd_material_factors(vec3 normal, vec3 view, vec3 albedo, vec3 rf0, float roughness, out vec3 diffuse_factor,
                          out vec3 specular_factor)
{
    float n_dot_v = min(abs(dot(normal, view)), 1.0);
    vec3 reflectance = nrd_environment_term(rf0, n_dot_v, roughness);
    diffuse_factor = mix(vec3(NRDI_MIN_FACTOR), vec3(1.0), (1.0 - reflectance) * albedo);
    specular_factor = mix(vec3(NRDI_MIN_FACTOR), vec3(1.0), reflectance * mix(NRDI_MIN_SPECULAR_SCALE, 1.0, roughness));
}

// Ray generation: takes the material out of radiance. factor from nrd_material_factors.
vec3 nrd_demodulate(vec3 radiance, vec3 factor)
{
    return radiance / factor;
}

// Composition: puts it back.
vec3 nrd_modulate(vec3 radiance, vec3 factor)
{
    return radiance * factor;
}

//----------------------------------------------------------------------------------------------------------------------
// >>motion
//----------------------------------------------------------------------------------------------------------------------

// uv of a clip space position in Vulkan's convention (y down). With a y-up projection (negative viewport height) negate
// clip.y first. A point at or behind the camera plane gives (-1,-1), which lies outside the image.
vec2 nrd_clip_to_uv(vec4 clip)
{
    return clip.w > 0.0 ? clip.xy / clip.w * 0.5 + 0.5 : vec2(-1.0);
}

// 2.5D motion of a surface point: (uv_prev - uv, view_z_prev - view_z). uv is that of the point under this frame's
// matrices, uv_prev that of where the same point of the object was, under last frame's; neither matrix jittered. A
// static scene under a static camera gives exactly (0,0,0). view_z and view_z_prev keep their sign, the same in both.
vec3 nrd_motion_2_5d(vec2 uv, float view_z, vec2 uv_prev, float view_z_prev)
{
    return vec3(uv_prev - uv, view_z_prev - view_z);
}

// The same from clip space positions: projection * view * position, without jitter.
vec3 nrd_motion_2_5d(vec4 clip, float view_z, vec4 clip_prev, float view_z_prev)
{
    return nrd_motion_2_5d(nrd_clip_to_uv(clip), view_z, nrd_clip_to_uv(clip_prev), view_z_prev);
}

#endif
