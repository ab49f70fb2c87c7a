// nrd.glsl: packing and unpacking for the shaders of an application that feeds the denoisers and composes the result.
//
// Usage: enable an include extension (GL_GOOGLE_include_directive or GL_ARB_shading_language_include) and include this
// file in a ray generation, closest hit, miss, compute or fragment shader, GLSL 4.50 or later. It declares functions,
// structs and macros, nothing else: no bindings, no variables, no extensions, no 16-bit types. Public names start
// with nrd_ / NRD_; names that start with nrdi_ / NRDI_ are private and may change. The passes of the denoisers decode
// with these same functions, so an application and the denoisers agree bit for bit. From C and C++ include nrd_c.h,
// which compiles this text: that is why it keeps to what the languages share (members one by one instead of swizzles,
// operators on scalars only, no overloads but those at the end, no array indices).
//
// Order of use
//   ray generation   choose a lobe (nrd_split_threshold) or trace both -> nrd_trim_hit_dist -> nrd_path_hit_dist_...
//                    -> average over paths -> nrd_normalize_hit_dist -> nrd_demodulate
//                    -> nrd_pack_radiance_hit_dist, nrd_pack_sh, nrd_pack_occlusion, ...;
//                    guides: nrd_pack_normal_roughness, nrd_motion_2_5d
//   composition      nrd_unpack_radiance_hit_dist, or nrd_unpack_sh -> nrd_resolve_... -> nrd_rejitter
//                    -> nrd_modulate with the factors that ray generation used
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
//   direction        world space, unit length, from the surface along the first ray of the path. Several paths: the mean
//                    of their directions, which is shorter than 1
//   sanitize         true: NaN and Inf become 0 and values are clamped to the legal range. false: for values known to
//                    be legal, which are stored as they are
//   x, y             pixel, whole numbers, y down
//   frame_index      counts frames by 1; may wrap around
//
// Choices, to be defined before the include and told to the denoiser in its description
//   NRD_NORMAL_FORMAT     one of NRD_NORMAL_FORMAT_...;    default NRD_NORMAL_FORMAT_RGB10A2_UNORM
//   NRD_ROUGHNESS_FORMAT  one of NRD_ROUGHNESS_FORMAT_...; default NRD_ROUGHNESS_FORMAT_LINEAR
//   NRD_HIT_DIST_FORM     one of NRD_HIT_DIST_FORM_...;    default NRD_HIT_DIST_FORM_4_PARAMETERS
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
#define NRD_HIT_DIST_MISS 65504.0f

#define NRDI_HALF_MAX 65504.0f
#define NRDI_EPSILON 1e-6f
#define NRDI_PI 3.14159265f
#define NRDI_LOG2_E 1.44269504f

//----------------------------------------------------------------------------------------------------------------------
// >>language: what differs between GLSL and C; nrd_c.h defines the C side
//----------------------------------------------------------------------------------------------------------------------

// `precise` stands where compilers would reassociate constants: results are the same with and without optimisation.

#ifndef NRDI_C
#define NRDI_FN
#define NRDI_STRUCT(name) struct name
#define NRDI_RESULT(type) out type // an output parameter, ..
#define NRDI_TO(name) name         // .. and where it is assigned
#define NRDI_UINT(x) uint(x)
#define NRDI_FLOAT(x) float(x)
#endif

NRDI_FN vec3 nrdi_grey(float x)
{
    return vec3(x, x, x);
}

NRDI_FN vec3 nrdi_add(vec3 a, vec3 b)
{
    return vec3(a.x + b.x, a.y + b.y, a.z + b.z);
}

NRDI_FN vec3 nrdi_scale(vec3 v, float s)
{
    return vec3(v.x * s, v.y * s, v.z * s);
}

NRDI_FN vec3 nrdi_clamp(vec3 v, float low, float high)
{
    return vec3(clamp(v.x, low, high), clamp(v.y, low, high), clamp(v.z, low, high));
}

NRDI_FN vec3 nrdi_mix(vec3 a, vec3 b, float t)
{
    return vec3(mix(a.x, b.x, t), mix(a.y, b.y, t), mix(a.z, b.z, t));
}

NRDI_FN float nrdi_dot(vec3 a, vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// 0 for the zero vector; vectors shorter than 1e-6 come out shorter than 1.
NRDI_FN vec3 nrdi_normalize(vec3 v)
{
    return nrdi_scale(v, 1.0f / max(sqrt(nrdi_dot(v, v)), NRDI_EPSILON));
}

NRDI_FN vec3 nrdi_xyz(vec4 v)
{
    return vec3(v.x, v.y, v.z);
}

NRDI_FN vec4 nrdi_append(vec3 v, float w)
{
    return vec4(v.x, v.y, v.z, w);
}

//----------------------------------------------------------------------------------------------------------------------
// >>sanitise: containment of NaN and Inf
//----------------------------------------------------------------------------------------------------------------------

// The exponent bits decide: compilers may assume that isnan() and isinf() are false.

// True for every number, false for NaN and the infinities.
NRDI_FN bool nrd_is_finite(float value)
{
    return (floatBitsToUint(value) & 0x7f800000u) != 0x7f800000u;
}

NRDI_FN bool nrdi_is_finite(vec3 value)
{
    return nrd_is_finite(value.x) && nrd_is_finite(value.y) && nrd_is_finite(value.z);
}

NRDI_FN bool nrdi_is_nan(float value)
{
    return (floatBitsToUint(value) & 0x7fffffffu) > 0x7f800000u;
}

// (0,0,0) if any component is NaN or Inf, else clamped to [0,65504].
NRDI_FN vec3 nrd_sanitize_radiance(vec3 radiance)
{
    return nrdi_is_finite(radiance) ? nrdi_clamp(radiance, 0.0f, NRDI_HALF_MAX) : nrdi_grey(0.0f);
}

// Units. 0 if NaN or Inf, else clamped to [0,65504]. A miss that a tracer reports as +Inf has to be replaced by
// NRD_HIT_DIST_MISS (or normalised) first: here, at the door of a texture, Inf counts as a defect.
NRDI_FN float nrd_sanitize_hit_dist(float hit_dist)
{
    return nrd_is_finite(hit_dist) ? clamp(hit_dist, 0.0f, NRDI_HALF_MAX) : 0.0f;
}

// Normalised. 0 if NaN or Inf, else clamped to [0,1].
NRDI_FN float nrd_sanitize_norm_hit_dist(float norm_hit_dist)
{
    return nrd_is_finite(norm_hit_dist) ? clamp(norm_hit_dist, 0.0f, 1.0f) : 0.0f;
}

// (0,0,0) if any component is NaN or Inf, else each clamped to [-1,1].
NRDI_FN vec3 nrd_sanitize_direction(vec3 direction)
{
    return nrdi_is_finite(direction) ? nrdi_clamp(direction, -1.0f, 1.0f) : nrdi_grey(0.0f);
}

//----------------------------------------------------------------------------------------------------------------------
// >>storage: rounding for 16-bit floats
//----------------------------------------------------------------------------------------------------------------------

// Nearest value that a 16-bit float holds, ties to even, overflow to +-65504; the input must be finite. Use it on what
// is stored to a 16-bit float image: image stores may truncate toward zero, and a history that is read, blended and
// truncated every frame drifts to black (to 0.988 of the truth in 300 frames at a blend factor of 1/32). Done on the
// bits, because packHalf2x16 may truncate as well: its rounding is left to the device. Forms for vectors stand at the
// end of this file.
NRDI_FN float nrd_round_to_half(float value)
{
    uint bits = floatBitsToUint(value);
    float normal = uintBitsToFloat((bits + 0xfffu + ((bits >> 13u) & 1u)) & 0xffffe000u);
    float subnormal = roundEven(value * 16777216.0f) * (1.0f / 16777216.0f); // steps of 2^-24 below 2^-14
    return clamp(abs(value) < 1.0f / 16384.0f ? subnormal : normal, -NRDI_HALF_MAX, NRDI_HALF_MAX);
}

//----------------------------------------------------------------------------------------------------------------------
// >>normal_roughness: normal, roughness and material ID in one texel
//----------------------------------------------------------------------------------------------------------------------

// What one texel of the normal and roughness guide says.
NRDI_STRUCT(nrd_surface) {
    vec3 normal;      // world space, unit length
    float roughness;  // linear, [0,1]
    uint material_id; // [0,3]; 0 where the encoding carries none
};

NRDI_FN float nrdi_encode_roughness(float roughness, uint roughness_encoding)
{
    float r = nrd_is_finite(roughness) ? clamp(roughness, 0.0f, 1.0f) : 1.0f;
    if (roughness_encoding == NRD_ROUGHNESS_FORMAT_SQ_LINEAR)
        return r * r;
    return roughness_encoding == NRD_ROUGHNESS_FORMAT_SQRT_LINEAR ? sqrt(r) : r;
}

// Decodes the one channel that holds roughness: z of the RGB10A2 encoding, w of the others. For gathers of that channel
// alone; nrd_decode_normal_roughness gives the same value.
NRDI_FN float nrd_decode_roughness(float channel, uint normal_encoding, uint roughness_encoding)
{
    float stored = normal_encoding == NRD_NORMAL_FORMAT_RGB10A2_UNORM ? abs(channel * 2.0f - 1.0f) : channel;
    float r = clamp(stored, 0.0f, 1.0f);
    if (roughness_encoding == NRD_ROUGHNESS_FORMAT_SQ_LINEAR)
        return sqrt(r);
    return roughness_encoding == NRD_ROUGHNESS_FORMAT_SQRT_LINEAR ? r * r : r;
}

NRDI_FN bool nrdi_is_biased(uint normal_encoding)
{
    return normal_encoding == NRD_NORMAL_FORMAT_RGBA8_UNORM || normal_encoding == NRD_NORMAL_FORMAT_RGBA16_UNORM;
}

// [-1,1] to [0,1] and back.
NRDI_FN vec3 nrdi_to_unorm(vec3 v)
{
    return vec3(v.x * 0.5f + 0.5f, v.y * 0.5f + 0.5f, v.z * 0.5f + 0.5f);
}

NRDI_FN vec3 nrdi_from_unorm(vec3 v)
{
    return vec3(v.x * 2.0f - 1.0f, v.y * 2.0f - 1.0f, v.z * 2.0f - 1.0f);
}

// The octahedron's |x| + |y| <= 1 diamond, turned by 45 degrees, fills the unit square exactly (Cigolle et al. 2014,
// "A Survey of Efficient Representations for Independent Unit Vectors", hemispherical form), so nothing is folded and
// neighbouring texels may be compared. The sign of z travels as the sign of roughness; roughness is therefore kept
// 1.5 steps of 1/512 away from 0, the least that survives 10 bits.
NRDI_FN vec3 nrdi_encode_octahedral(vec3 normal, float stored_roughness)
{
    vec3 n = nrdi_scale(normal, 1.0f / max(abs(normal.x) + abs(normal.y) + abs(normal.z), NRDI_EPSILON));
    float signed_roughness = max(stored_roughness, 1.5f / 512.0f) * (normal.z < 0.0f ? -1.0f : 1.0f);
    return nrdi_to_unorm(vec3(n.x + n.y, n.y - n.x, signed_roughness));
}

NRDI_FN vec3 nrdi_decode_octahedral(vec3 encoded)
{
    float x = encoded.x - encoded.y;
    float y = encoded.x + encoded.y - 1.0f;
    float z = 1.0f - abs(x) - abs(y);
    return vec3(x, y, encoded.z < 0.5f ? -z : z);
}

// The texel for a normal and roughness guide whose encodings are arguments (values NRD_NORMAL_FORMAT_... and
// NRD_ROUGHNESS_FORMAT_...), for code where they are specialization constants.
// Angle error after storage: RGB10A2 <= 0.137 degrees, RGBA8 <= 0.32, RGBA16 <= 0.00125 (16-bit float <= 0.016);
// roughness error in RGB10A2 <= 0.00098 for roughness >= 0.006 (linear encoding). Scaling by the largest component
// instead of the length uses the whole cube of codes, which lowers the error of the encodings that store three of them.
NRDI_FN vec4 nrd_encode_normal_roughness(vec3 normal, float roughness, uint material_id, uint normal_encoding,
                                         uint roughness_encoding)
{
    vec3 n = nrdi_is_finite(normal) ? normal : nrdi_grey(0.0f);
    float stored = nrdi_encode_roughness(roughness, roughness_encoding);
    if (normal_encoding == NRD_NORMAL_FORMAT_RGB10A2_UNORM)
        return nrdi_append(nrdi_encode_octahedral(n, stored), NRDI_FLOAT(material_id < 3u ? material_id : 3u) / 3.0f);

    n = nrdi_scale(n, 1.0f / max(max(abs(n.x), abs(n.y)), max(abs(n.z), NRDI_EPSILON)));
    return nrdi_append(nrdi_is_biased(normal_encoding) ? nrdi_to_unorm(n) : n, stored);
}

// Inverse of nrd_encode_normal_roughness. A texel of zeros decodes to finite numbers under every encoding.
NRDI_FN nrd_surface nrd_decode_normal_roughness(vec4 texel, uint normal_encoding, uint roughness_encoding)
{
    bool octahedral = normal_encoding == NRD_NORMAL_FORMAT_RGB10A2_UNORM;
    vec3 n = nrdi_is_biased(normal_encoding) ? nrdi_from_unorm(nrdi_xyz(texel)) : nrdi_xyz(texel);
    if (octahedral)
        n = nrdi_decode_octahedral(nrdi_xyz(texel));

    nrd_surface surface;
    surface.normal = nrdi_scale(n, inversesqrt(max(nrdi_dot(n, n), 1e-9f))); // a sum would be reassociated
    surface.roughness = nrd_decode_roughness(octahedral ? texel.z : texel.w, normal_encoding, roughness_encoding);
    surface.material_id = octahedral ? NRDI_UINT(clamp(texel.w, 0.0f, 1.0f) * 3.0f + 0.5f) : 0u;
    return surface;
}

// The texel under the encodings chosen by NRD_NORMAL_FORMAT and NRD_ROUGHNESS_FORMAT.
NRDI_FN vec4 nrd_pack_normal_roughness(vec3 normal, float roughness, uint material_id)
{
    return nrd_encode_normal_roughness(normal, roughness, material_id, NRD_NORMAL_FORMAT, NRD_ROUGHNESS_FORMAT);
}

// Inverse of nrd_pack_normal_roughness.
NRDI_FN nrd_surface nrd_unpack_normal_roughness(vec4 texel)
{
    return nrd_decode_normal_roughness(texel, NRD_NORMAL_FORMAT, NRD_ROUGHNESS_FORMAT);
}

// The guide normal of a strand of hair or fur: the direction across the strand that faces the camera, so that
// neighbouring strands agree and one strand's facets do not differ. tangent: along the strand, unit length, either
// sign. The result has unit length; a strand that points at the camera, or a tangent that is not finite, gives `view`.
NRDI_FN vec3 nrd_strand_normal(vec3 tangent, vec3 view)
{
    vec3 across = nrdi_add(view, nrdi_scale(tangent, -nrdi_dot(tangent, view)));
    float length2 = nrdi_dot(across, across);
    return length2 > 1e-6f && nrd_is_finite(length2) ? nrdi_scale(across, inversesqrt(length2)) : view;
}

// How much thinner than a pixel a strand is, [0,1]: 0 many pixels wide, 0.5 one pixel, 1 half a pixel and less.
// thickness: of the strand, units, >= 0. pixel_size: width of a pixel at the strand, units, > 0
// (2 |view_z| tan(fov_y / 2) / height; without |view_z| if orthographic).
NRDI_FN float nrd_normalize_strand_thickness(float thickness, float pixel_size)
{
    return clamp(0.5f * pixel_size / (thickness + NRDI_EPSILON), 0.0f, 1.0f);
}

//----------------------------------------------------------------------------------------------------------------------
// >>hit_distance: trimming, averaging over paths, normalisation
//----------------------------------------------------------------------------------------------------------------------

// 0 below the threshold, else hit_dist. Offsets of ray origins turn rays that start inside a surface into hits at tiny
// distances; threshold is that offset, units. 0: nothing is trimmed.
NRDI_FN float nrd_trim_hit_dist(float hit_dist, float threshold)
{
    return hit_dist < threshold ? 0.0f : hit_dist;
}

// Hit distance of the specular lobe over several paths of one pixel: the nearest, because motion of reflections is
// tracked with it.   acc = begin(); for each specular path: acc = add(acc, hit_dist); result = end(acc);
// The start value is the largest float and so above every distance, whatever the unit.
NRDI_FN float nrd_specular_hit_dist_begin(void)
{
    return uintBitsToFloat(0x7f7fffffu);
}

// Ignores 0, negative values and NaN. A miss counts as NRD_HIT_DIST_MISS.
NRDI_FN float nrd_specular_hit_dist_add(float accumulated, float hit_dist)
{
    bool valid = !nrdi_is_nan(hit_dist) && hit_dist > 0.0f;
    return valid ? min(accumulated, min(hit_dist, NRD_HIT_DIST_MISS)) : accumulated;
}

// The nearest distance, or 0 (not sampled) if nothing valid was added.
NRDI_FN float nrd_specular_hit_dist_end(float accumulated)
{
    return accumulated <= NRD_HIT_DIST_MISS ? accumulated : 0.0f;
}

// Hit distance of the diffuse lobe, and of occlusion, over several paths of one pixel: the arithmetic mean over the
// paths of that lobe. Same order of calls as above. Average normalised distances: one miss among raw ones hides them.
NRDI_FN vec2 nrd_diffuse_hit_dist_begin(void)
{
    return vec2(0.0f, 0.0f);
}

// accumulated = (sum, number of paths). NaN is skipped and does not count. A miss counts as NRD_HIT_DIST_MISS.
NRDI_FN vec2 nrd_diffuse_hit_dist_add(vec2 accumulated, float hit_dist)
{
    if (nrdi_is_nan(hit_dist))
        return accumulated;
    return vec2(accumulated.x + clamp(hit_dist, 0.0f, NRD_HIT_DIST_MISS), accumulated.y + 1.0f);
}

// The mean, or 0 (not sampled) if nothing was added.
NRDI_FN float nrd_diffuse_hit_dist_end(vec2 accumulated)
{
    return accumulated.x / max(accumulated.y, 1.0f);
}

// Diffuse hit distance of a pixel that holds direct and indirect light, from the luminances (>= 0) of both: the distance
// to the light gets a share of at most one half, which sharpens its shadows. No light at all: the indirect distance.
// The specular lobe always uses its indirect distance.
NRDI_FN float nrd_mix_diffuse_hit_dist(float hit_dist_indirect, float hit_dist_direct, float luma_indirect,
                                       float luma_direct)
{
    float share = luma_direct / (luma_direct + luma_indirect + NRDI_EPSILON);
    return mix(hit_dist_indirect, hit_dist_direct, min(share, 0.5f));
}

// Hit distance of a path that goes on after its first hit, for the specular lobe: the distance at which the light that
// the lobe shows seems to lie.
//   acc = begin(); for each segment: acc = add(acc, length, roughness at its end); result = end(acc)
// A mirror images what lies behind it at the sum of the lengths; a rough surface scatters, so that nothing behind it
// moves with the view. A segment therefore counts by the product of 2^(-200 r^2) over the surfaces between it and the
// primary one: 1 after mirrors, 0.5 at r = 0.07, 0.004 at r = 0.2 (the complement of nrd_roughness_curve's rise).
// The first segment, from the primary surface, counts fully whatever its roughness: diffuse lobes need no more than it.
NRDI_FN vec2 nrd_path_hit_dist_begin(void)
{
    return vec2(0.0f, 1.0f);
}

// accumulated = (distance so far, share of the next segment). segment: units, > 0; NRD_HIT_DIST_MISS or more if it left
// the scene. NaN, 0 and negative lengths add nothing. roughness: of the surface that the segment ends on, 1 if the path
// leaves it through the diffuse lobe; whatever it is after a miss or at the path's end, nothing follows.
NRDI_FN vec2 nrd_path_hit_dist_add(vec2 accumulated, float segment, float roughness)
{
    bool valid = !nrdi_is_nan(segment) && segment > 0.0f;
    float so_far = accumulated.x + (valid ? accumulated.y * min(segment, NRD_HIT_DIST_MISS) : 0.0f);
    return vec2(so_far, accumulated.y * exp2(-200.0f * roughness * roughness));
}

// Units, [0,65504]; 0 (not sampled) if nothing valid was added.
NRDI_FN float nrd_path_hit_dist_end(vec2 accumulated)
{
    return min(accumulated.x, NRD_HIT_DIST_MISS);
}

// (1 - 2^(-200 r^2)) r^p: 0 for a mirror, rises fast, equals r^p above a roughness of about 0.15. Bridges "mirror" and
// "rough" behaviour without a threshold. power > 0.
NRDI_FN float nrd_roughness_curve(float roughness, float power)
{
    return (1.0f - exp2(-200.0f * roughness * roughness)) * pow(roughness, power);
}

// Distance, units, that counts as 1 after normalisation, under an explicit form (NRD_HIT_DIST_FORM_...).
//   4 parameters   (A + |view_z| B) mix(1, C, min(2^(D r^2), 1))
//   3 parameters   (A + |view_z| B) mix(C, 1, nrd_roughness_curve(r, 0.5))
// The two differ by up to a factor of 5 at medium roughness: occlusion of one is not comparable with that of the other.
NRDI_FN float nrd_hit_dist_scale_of_form(float view_z, float roughness, vec4 params, uint form)
{
    float base = params.x + abs(view_z) * params.y;
    if (form == NRD_HIT_DIST_FORM_3_PARAMETERS)
        return base * mix(params.z, 1.0f, nrd_roughness_curve(roughness, 0.5f));
    return base * mix(1.0f, params.z, clamp(exp2(params.w * roughness * roughness), 0.0f, 1.0f));
}

// The same under NRD_HIT_DIST_FORM.
NRDI_FN float nrd_hit_dist_scale(float view_z, float roughness, vec4 params)
{
    return nrd_hit_dist_scale_of_form(view_z, roughness, params, NRD_HIT_DIST_FORM);
}

// hit_dist / nrd_hit_dist_scale, clamped to [0,1]. 0 gives exactly 0, NRD_HIT_DIST_MISS and more give exactly 1, NaN
// and negative values give 0. Normalised diffuse distances are samples of ambient occlusion over that range, specular
// ones of specular occlusion.
NRDI_FN float nrd_normalize_hit_dist(float hit_dist, float view_z, float roughness, vec4 params)
{
    if (nrdi_is_nan(hit_dist) || hit_dist <= 0.0f)
        return 0.0f;
    if (hit_dist >= NRD_HIT_DIST_MISS)
        return 1.0f;
    return clamp(hit_dist / nrd_hit_dist_scale(view_z, roughness, params), 0.0f, 1.0f);
}

// Inverse of nrd_normalize_hit_dist for the same view_z, roughness and params; units. 1 gives the scale itself: what
// lay beyond is lost.
NRDI_FN float nrd_denormalize_hit_dist(float norm_hit_dist, float view_z, float roughness, vec4 params)
{
    return norm_hit_dist * nrd_hit_dist_scale(view_z, roughness, params);
}

//----------------------------------------------------------------------------------------------------------------------
// >>radiance: colour space and the radiance texel
//----------------------------------------------------------------------------------------------------------------------

// Luma and two signed chroma values (Malvar & Sullivan 2003, "YCoCg-R", the lossy form without lifting): x = Y,
// y = Co, z = Cg. Linear, so blending commutes with it; exact powers of two keep 16-bit round trips tight.
NRDI_FN vec3 nrd_rgb_to_ycocg(vec3 rgb)
{
    float half_green = rgb.y * 0.5f;
    float half_rest = (rgb.x + rgb.z) * 0.25f;
    return vec3(half_green + half_rest, (rgb.x - rgb.z) * 0.5f, half_green - half_rest);
}

// Exact inverse; components are negative where chroma exceeds luma, as after a sharpening filter.
NRDI_FN vec3 nrd_ycocg_to_rgb_unclamped(vec3 ycocg)
{
    float t = ycocg.x - ycocg.z;
    return vec3(t + ycocg.y, ycocg.x + ycocg.z, t - ycocg.y);
}

// Inverse with every component >= 0.
NRDI_FN vec3 nrd_ycocg_to_rgb(vec3 ycocg)
{
    vec3 rgb = nrd_ycocg_to_rgb_unclamped(ycocg);
    return vec3(max(rgb.x, 0.0f), max(rgb.y, 0.0f), max(rgb.z, 0.0f));
}

// Luma of linear RGB: the Y of nrd_rgb_to_ycocg, the only luma that the denoisers use.
NRDI_FN float nrd_luma(vec3 rgb)
{
    return rgb.y * 0.5f + (rgb.x + rgb.z) * 0.25f;
}

// The texel of a noisy radiance input: (Y, Co, Cg, norm_hit_dist). Chroma is signed: the format must be a signed float.
// sanitize: replace NaN and Inf by 0 and clamp to the legal range; pass false only for values known to be legal. For
// multiple paths: radiance is the sum over all paths divided by their number, norm_hit_dist as described above.
NRDI_FN vec4 nrd_pack_radiance_hit_dist(vec3 radiance, float norm_hit_dist, bool sanitize)
{
    vec3 rgb = sanitize ? nrd_sanitize_radiance(radiance) : radiance;
    return nrdi_append(nrd_rgb_to_ycocg(rgb), sanitize ? nrd_sanitize_norm_hit_dist(norm_hit_dist) : norm_hit_dist);
}

// Inverse: (R, G, B, w), colour >= 0. w of a denoised texel is occlusion in [0,1], or the length of history in frames
// when the denoiser was told to write that.
NRDI_FN vec4 nrd_unpack_radiance_hit_dist(vec4 texel)
{
    return nrdi_append(nrd_ycocg_to_rgb(nrdi_xyz(texel)), texel.w);
}

// The texel of a noisy radiance input of the a-trous family (RELAX): (R, G, B, hit_dist), the hit distance in units and
// not normalised. That family keeps second moments of luminance in 16 bits: useful radiance ends near 250. A miss that
// the tracer reports as +Inf has to be replaced by NRD_HIT_DIST_MISS first (nrd_sanitize_hit_dist).
NRDI_FN vec4 nrd_pack_relax_radiance_hit_dist(vec3 radiance, float hit_dist, bool sanitize)
{
    if (!sanitize)
        return nrdi_append(radiance, hit_dist);
    return nrdi_append(nrd_sanitize_radiance(radiance), nrd_sanitize_hit_dist(hit_dist));
}

// Inverse: (R, G, B, w), colour >= 0. w of a denoised texel is the length of history in frames.
NRDI_FN vec4 nrd_unpack_relax_radiance_hit_dist(vec4 texel)
{
    return vec4(max(texel.x, 0.0f), max(texel.y, 0.0f), max(texel.z, 0.0f), texel.w);
}

//----------------------------------------------------------------------------------------------------------------------
// >>material: demodulation
//----------------------------------------------------------------------------------------------------------------------

// A denoiser should see light without texture: ray generation divides radiance by the factors below, composition
// multiplies by the same factors. Emission, sky and noise-free direct light are not denoised; add them afterwards.

// Smallest factors. They bound how much noise a division can amplify; both sides must use the same values.
#define NRDI_MIN_FACTOR 0.02f
#define NRDI_MIN_SPECULAR_SCALE 0.1f // at roughness 0; reaches 1 at roughness 1

// Diffuse albedo and rf0 of the base colour and metalness model; dielectrics have an rf0 of 0.04. metalness [0,1].
NRDI_FN void nrd_base_color_to_albedo_rf0(vec3 base_color, float metalness, NRDI_RESULT(vec3) albedo,
                                          NRDI_RESULT(vec3) rf0)
{
    NRDI_TO(albedo) = nrdi_scale(base_color, 1.0f - metalness);
    NRDI_TO(rf0) = nrdi_mix(nrdi_grey(0.04f), base_color, metalness);
}

// Reflectance of a GGX lobe with Schlick's Fresnel term under constant lighting, [0,1] per component: the rational fit
// of the split-sum integral from Ray Tracing Gems (2019), chapter 32. n_dot_v [0,1]. Written as polynomials: the order
// of the published matrices' elements differs between shading languages.
NRDI_FN vec3 nrd_environment_term(vec3 rf0, float n_dot_v, float roughness)
{
    float v = n_dot_v;
    float v2 = v * v;
    float v3 = v2 * v;
    float m = roughness * roughness;
    float m3 = m * m * m;

    float bias = (0.99044f - 1.28514f * v) + m * (1.29678f - 0.755907f * v);
    float bias_divisor = (1.0f + 2.92338f * v + 59.4188f * v3) + m * (20.3225f - 27.0302f * v + 222.592f * v3) +
                         m3 * (121.563f + 626.13f * v + 316.627f * v3);
    float scale = (0.0365463f + 3.32707f * v) + m * (9.0632f - 9.04756f * v);
    float scale_divisor = (1.0f + 3.59685f * v2 - 1.36772f * v3) + m * (9.04401f - 16.3174f * v2 + 9.22949f * v3) +
                          m3 * (5.56589f + 19.7886f * v2 - 20.2123f * v3);
    vec3 term = nrdi_scale(rf0, scale / max(scale_divisor, NRDI_EPSILON));
    return nrdi_clamp(nrdi_add(term, nrdi_grey(bias / max(bias_divisor, NRDI_EPSILON))), 0.0f, 1.0f);
}

// Demodulation factors, each component in [0.02,1]. Black albedo (metals) gives a diffuse factor of 0.02. The specular
// factor's own dependence on roughness is no physics: it cancels, because both sides apply it.
NRDI_FN void nrd_material_factors(vec3 normal, vec3 view, vec3 albedo, vec3 rf0, float roughness,
                                  NRDI_RESULT(vec3) diffuse_factor, NRDI_RESULT(vec3) specular_factor)
{
    vec3 reflectance = nrd_environment_term(rf0, min(abs(nrdi_dot(normal, view)), 1.0f), roughness);
    vec3 diffuse = vec3((1.0f - reflectance.x) * albedo.x, (1.0f - reflectance.y) * albedo.y,
                        (1.0f - reflectance.z) * albedo.z);
    vec3 specular = nrdi_scale(reflectance, mix(NRDI_MIN_SPECULAR_SCALE, 1.0f, roughness));
    NRDI_TO(diffuse_factor) = nrdi_add(nrdi_scale(diffuse, 1.0f - NRDI_MIN_FACTOR), nrdi_grey(NRDI_MIN_FACTOR));
    NRDI_TO(specular_factor) = nrdi_add(nrdi_scale(specular, 1.0f - NRDI_MIN_FACTOR), nrdi_grey(NRDI_MIN_FACTOR));
}

// Ray generation: takes the material out of radiance. factor from nrd_material_factors; components > 0.
NRDI_FN vec3 nrd_demodulate(vec3 radiance, vec3 factor)
{
    return vec3(radiance.x / factor.x, radiance.y / factor.y, radiance.z / factor.z);
}

// Composition: puts it back.
NRDI_FN vec3 nrd_modulate(vec3 radiance, vec3 factor)
{
    return vec3(radiance.x * factor.x, radiance.y * factor.y, radiance.z * factor.z);
}

//----------------------------------------------------------------------------------------------------------------------
// >>shadow: penumbrae and translucency
//----------------------------------------------------------------------------------------------------------------------

// Ray generation traces one ray per pixel to a random point of the light and packs the distance to the NEAREST occluder
// (no early exit at the first hit that is found: its distance is random). What is stored is the half width of the
// penumbra at the receiver, units, as the geometry gives it (NVIDIA's library stores half of that for directional
// lights). 0: the surface faces away from the light. NRD_PENUMBRA_LIT: the ray reached the light.
#define NRD_PENUMBRA_LIT NRDI_HALF_MAX
#define NRDI_PENUMBRA_MAX 32768.0f
#define NRDI_PENUMBRA_MIN 6.103515625e-5f // smallest normal 16-bit float: an occluder that touches is still one

NRDI_FN float nrdi_penumbra(float width, float occluder_dist)
{
    if (nrdi_is_nan(occluder_dist) || occluder_dist <= 0.0f)
        return 0.0f;
    if (occluder_dist >= NRD_HIT_DIST_MISS)
        return NRD_PENUMBRA_LIT;
    return clamp(width, NRDI_PENUMBRA_MIN, NRDI_PENUMBRA_MAX);
}

// Directional light. occluder_dist: from the surface to the nearest occluder, units; 0 where the surface faces away
// (mandatory), NRD_HIT_DIST_MISS or more (+Inf included) where the ray reached the light; NaN counts as 0.
// tan_angular_radius: of the light as seen from the surface (the sun: 0.00465); the denoiser's light_radius.
NRDI_FN float nrd_pack_penumbra(float occluder_dist, float tan_angular_radius)
{
    return nrdi_penumbra(occluder_dist * tan_angular_radius, occluder_dist);
}

// Local light (sphere, disk, spot). light_dist: from the surface to the light, units. light_radius: half its extent
// perpendicular to the line from the surface, units; the denoiser's light_radius. An occluder at or behind the light
// gives the widest penumbra.
NRDI_FN float nrd_pack_local_penumbra(float occluder_dist, float light_dist, float light_radius)
{
    return nrdi_penumbra(light_radius * occluder_dist / max(light_dist - occluder_dist, NRDI_EPSILON), occluder_dist);
}

// Coloured visibility of the ray that gave occluder_dist, for IN_TRANSLUCENCY: the product of what the surfaces in its
// way let through, [0,1]; black where an opaque one blocks it. occluder_dist is then that to the nearest surface of any
// kind, and NRD_HIT_DIST_MISS where nothing was in the way: the light arrives in full, whatever transmission says.
NRDI_FN vec4 nrd_pack_translucency(float occluder_dist, vec3 transmission)
{
    bool reached = occluder_dist >= NRD_HIT_DIST_MISS;
    bool valid = nrdi_is_finite(transmission) && occluder_dist > 0.0f;
    vec3 color = valid ? nrdi_clamp(transmission, 0.0f, 1.0f) : nrdi_grey(0.0f);
    return reached ? vec4(1.0f, 1.0f, 1.0f, 1.0f) : nrdi_append(color, 0.0f);
}

// Many lights in one signal: what N lights send, without shadows, is known exactly; so is each one's ray. Start with
// zeros, add every light's unshadowed light (linear RGB, >= 0), its ray's penumbra (from one of the two functions above)
// and its coloured visibility (vec3(1) where the ray arrived, vec3(0) where it was blocked); the denoised result times
// the sum of the unshadowed light is the picture. The penumbra is the mean over the lights whose ray is blocked, each by
// the luma that it withholds. Lights of very different intensity (sun and lamps) are better denoised apart.
NRDI_STRUCT(nrd_light_sum) {
    vec3 unshadowed;
    vec3 shadowed;
    vec2 penumbra; // sum of width times weight, sum of weights
};

NRDI_FN nrd_light_sum nrd_light_sum_begin(void)
{
    nrd_light_sum sum;
    sum.unshadowed = nrdi_grey(0.0f);
    sum.shadowed = nrdi_grey(0.0f);
    sum.penumbra = vec2(0.0f, 0.0f);
    return sum;
}

NRDI_FN nrd_light_sum nrd_light_sum_add(nrd_light_sum sum, vec3 unshadowed, float penumbra, vec3 visibility)
{
    vec3 shadowed = nrd_modulate(unshadowed, visibility);
    vec3 withheld = vec3(unshadowed.x * (1.0f - visibility.x), unshadowed.y * (1.0f - visibility.y),
                         unshadowed.z * (1.0f - visibility.z));
    float weight = penumbra > 0.0f && penumbra < NRD_PENUMBRA_LIT ? max(nrd_luma(withheld), 0.0f) : 0.0f;
    nrd_light_sum longer;
    longer.unshadowed = nrdi_add(sum.unshadowed, unshadowed);
    longer.shadowed = nrdi_add(sum.shadowed, shadowed);
    longer.penumbra = vec2(sum.penumbra.x + penumbra * weight, sum.penumbra.y + weight);
    return longer;
}

// IN_PENUMBRA: 0 where no light shines on the surface.
NRDI_FN float nrd_light_sum_penumbra(nrd_light_sum sum)
{
    bool faces = nrd_luma(sum.unshadowed) > 0.0f;
    return sum.penumbra.y > 0.0f ? sum.penumbra.x / sum.penumbra.y : faces ? NRD_PENUMBRA_LIT : 0.0f;
}

// IN_TRANSLUCENCY.
NRDI_FN vec4 nrd_light_sum_translucency(nrd_light_sum sum)
{
    vec3 all = vec3(max(sum.unshadowed.x, NRDI_EPSILON), max(sum.unshadowed.y, NRDI_EPSILON),
                    max(sum.unshadowed.z, NRDI_EPSILON));
    return nrdi_append(nrdi_clamp(nrd_demodulate(sum.shadowed, all), 0.0f, 1.0f), 0.0f);
}

// Composition: visibility of the light, [0,1], from a texel of OUT_SHADOW. Stored as its square root, for finer steps
// in the dark.
NRDI_FN float nrd_unpack_shadow(float texel)
{
    return texel * texel;
}

// The same, coloured, from a texel of OUT_SHADOW_TRANSLUCENCY.
NRDI_FN vec3 nrd_unpack_shadow_translucency(vec4 texel)
{
    return vec3(texel.x * texel.x, texel.y * texel.y, texel.z * texel.z);
}

//----------------------------------------------------------------------------------------------------------------------
// >>motion
//----------------------------------------------------------------------------------------------------------------------

// uv of a clip space position in Vulkan's convention (y down). With a y-up projection (negative viewport height) negate
// clip.y first. A point at or behind the camera plane gives (-1,-1), which lies outside the image.
NRDI_FN vec2 nrd_clip_to_uv(vec4 clip)
{
    return clip.w > 0.0f ? vec2(clip.x / clip.w * 0.5f + 0.5f, clip.y / clip.w * 0.5f + 0.5f) : vec2(-1.0f, -1.0f);
}

// 2.5D motion of a surface point: (uv_prev - uv, view_z_prev - view_z). uv is that of the point under this frame's
// matrices, uv_prev that of where the same point of the object was, under last frame's; neither matrix jittered. A
// static scene under a static camera gives exactly (0,0,0). view_z and view_z_prev keep their sign, the same in both.
NRDI_FN vec3 nrd_motion_2_5d(vec2 uv, float view_z, vec2 uv_prev, float view_z_prev)
{
    return vec3(uv_prev.x - uv.x, uv_prev.y - uv.y, view_z_prev - view_z);
}

// matrix * vector, column vectors.
NRDI_FN vec4 nrdi_transform(mat4 m, vec4 v)
{
#ifdef NRDI_C
    const vec4 *c = m.column;
    return vec4(c[0].x * v.x + c[1].x * v.y + c[2].x * v.z + c[3].x * v.w,
                c[0].y * v.x + c[1].y * v.y + c[2].y * v.z + c[3].y * v.w,
                c[0].z * v.x + c[1].z * v.y + c[2].z * v.z + c[3].z * v.w,
                c[0].w * v.x + c[1].w * v.y + c[2].w * v.z + c[3].w * v.w);
#else
    return m * v;
#endif
}

// 2.5D motion of a surface point from where it is and was, world space, units: position under this frame's matrices,
// position_prev (of the same point of the object) under last frame's. Column-major matrices without jitter, Vulkan clip
// space (y down). Equal positions and equal matrices give exactly (0,0,0). A point that was behind last frame's camera
// gets a uv_prev of (-1,-1): outside the image, which the denoisers take as "no history".
NRDI_FN vec3 nrd_motion_of_points(vec3 position, vec3 position_prev, mat4 world_to_view, mat4 view_to_clip,
                                  mat4 world_to_view_prev, mat4 view_to_clip_prev)
{
    vec4 view = nrdi_transform(world_to_view, nrdi_append(position, 1.0f));
    vec4 view_prev = nrdi_transform(world_to_view_prev, nrdi_append(position_prev, 1.0f));
    vec2 uv = nrd_clip_to_uv(nrdi_transform(view_to_clip, view));
    vec2 uv_prev = nrd_clip_to_uv(nrdi_transform(view_to_clip_prev, view_prev));
    return nrd_motion_2_5d(uv, view.z, uv_prev, view_prev.z);
}

//----------------------------------------------------------------------------------------------------------------------
// >>mirror: primary surface replacement
//----------------------------------------------------------------------------------------------------------------------

// Behind flat mirrors the denoiser may be given, instead of the mirror, the image of what is seen in it: all guides
// (normal, roughness, view_z, motion, material) and both lobes are then those of the surface at the end of the mirror
// path, moved to where the mirrors show it, and the product of the mirrors' reflectances joins the factors that
// composition multiplies by.
//   ray generation   chain = chain_prev = nrd_mirror_begin(); at each mirror along the path (position, normal; prev:
//                    where that point of the mirror was last frame, with its normal then):
//                      chain = nrd_mirror_add(chain, position, normal);
//                      chain_prev = nrd_mirror_add(chain_prev, position_prev, normal_prev);
//                    at the surface that is seen at last:
//                      virtual_position = nrd_mirror_point(chain, position);       view_z is that point's
//                      virtual_position_prev = nrd_mirror_point(chain_prev, position_prev);
//                      virtual_normal = nrd_mirror_direction(chain, normal);
//                      motion = nrd_motion_of_points(virtual_position, virtual_position_prev, ...)
//                    and hit distances start anew from that surface.
// Exact for plane mirrors, moving or not. A curved one is taken for its tangent plane: right where the hit is close to
// the mirror against its radius of curvature; else keep the mirror as the primary surface. World positions far from the
// origin lose digits: give positions relative to a point near the camera, the same one in both frames.

// The affine map from a point to its image behind the mirrors so far.
NRDI_STRUCT(nrd_mirror) {
    vec3 column_x, column_y, column_z; // of the linear part: a reflection or a rotation
    vec3 offset;                       // units
};

// Without mirrors: every point is its own image.
NRDI_FN nrd_mirror nrd_mirror_begin(void)
{
    nrd_mirror chain;
    chain.column_x = vec3(1.0f, 0.0f, 0.0f);
    chain.column_y = vec3(0.0f, 1.0f, 0.0f);
    chain.column_z = vec3(0.0f, 0.0f, 1.0f);
    chain.offset = nrdi_grey(0.0f);
    return chain;
}

// The image of a direction: reflected as often as there are mirrors. Same length.
NRDI_FN vec3 nrd_mirror_direction(nrd_mirror chain, vec3 direction)
{
    return nrdi_add(nrdi_scale(chain.column_x, direction.x),
                    nrdi_add(nrdi_scale(chain.column_y, direction.y), nrdi_scale(chain.column_z, direction.z)));
}

// The image of a point, units.
NRDI_FN vec3 nrd_mirror_point(nrd_mirror chain, vec3 position)
{
    return nrdi_add(nrd_mirror_direction(chain, position), chain.offset);
}

// One more mirror, met after the others: a plane through `position` (units) with `normal` (unit length, either side),
// both as they are in the world, not as earlier mirrors show them.
NRDI_FN nrd_mirror nrd_mirror_add(nrd_mirror chain, vec3 position, vec3 normal)
{
    vec3 image = nrdi_scale(nrd_mirror_direction(chain, normal), -2.0f); // x -> x - 2 n (n x - n p), seen through chain
    nrd_mirror longer;
    longer.column_x = nrdi_add(chain.column_x, nrdi_scale(image, normal.x));
    longer.column_y = nrdi_add(chain.column_y, nrdi_scale(image, normal.y));
    longer.column_z = nrdi_add(chain.column_z, nrdi_scale(image, normal.z));
    longer.offset = nrdi_add(chain.offset, nrdi_scale(image, -nrdi_dot(normal, position)));
    return longer;
}

//----------------------------------------------------------------------------------------------------------------------
// >>sh: light with a direction
//----------------------------------------------------------------------------------------------------------------------

// A signal with direction is a pair of texels: a colour and the first moment of its luma over directions. Denoisers
// blend both alike, so texture detail of normals can be put back afterwards: the resolve functions light the pixel's own
// normal and roughness with a lobe around the mean direction (spherical Gaussians: Tsai & Shih 2006, "All-Frequency
// Precomputed Radiance Transfer Using Spherical Radial Basis Functions and Clustered Tensor Approximation").
//   texture   REBLUR                          RELAX                       output of both
//   SH0       (Y, Co, Cg, norm_hit_dist)      (Y, Co, Cg, hit_dist)       (Y, Co, Cg, w)
//   SH1       (direction Y, 0)                (direction Y, 0)            (direction Y, gain or 0)

NRDI_STRUCT(nrd_sg) {
    vec3 ycocg;      // colour: luma Y >= 0 and chroma
    vec3 moment;     // mean of direction times luma; its length is at most Y
    float hit_dist;  // w of SH0: as packed, or what the denoiser writes there
    float gain;      // w of SH1: luma under the normal of IN_NORMAL_ROUGHNESS over Y, which is of blended normals; 0: a
                     // noisy pair, not blended
};

NRDI_FN vec4 nrdi_pack_sh1(vec3 direction, float luma, bool sanitize)
{
    return nrdi_append(nrdi_scale(sanitize ? nrd_sanitize_direction(direction) : direction, luma), 0.0f);
}

// The pair for REBLUR. Reading the pair back with the plain functions is legal: sh0 is the texel of
// nrd_pack_radiance_hit_dist. A direction of zero length: light from everywhere.
NRDI_FN void nrd_pack_sh(vec3 radiance, float norm_hit_dist, vec3 direction, bool sanitize, NRDI_RESULT(vec4) sh0,
                         NRDI_RESULT(vec4) sh1)
{
    vec4 texel = nrd_pack_radiance_hit_dist(radiance, norm_hit_dist, sanitize);
    NRDI_TO(sh0) = texel;
    NRDI_TO(sh1) = nrdi_pack_sh1(direction, texel.x, sanitize);
}

// The pair for RELAX: the same with hit_dist in units, [0,65504], not normalised. Luma and chroma, unlike RELAX's plain
// signal, so that input and output read alike.
NRDI_FN void nrd_pack_relax_sh(vec3 radiance, float hit_dist, vec3 direction, bool sanitize, NRDI_RESULT(vec4) sh0,
                               NRDI_RESULT(vec4) sh1)
{
    vec4 rgb = nrd_pack_relax_radiance_hit_dist(radiance, hit_dist, sanitize);
    vec3 ycocg = nrd_rgb_to_ycocg(nrdi_xyz(rgb));
    NRDI_TO(sh0) = nrdi_append(ycocg, rgb.w);
    NRDI_TO(sh1) = nrdi_pack_sh1(direction, ycocg.x, sanitize);
}

// The pair of either family, noisy or denoised.
NRDI_FN nrd_sg nrd_unpack_sh(vec4 sh0, vec4 sh1)
{
    nrd_sg sg;
    sg.ycocg = nrdi_xyz(sh0);
    sg.moment = nrdi_xyz(sh1);
    sg.hit_dist = sh0.w;
    sg.gain = sh1.w;
    return sg;
}

// Colour without direction: what the plain variant of the denoiser gives. Components >= 0.
NRDI_FN vec3 nrd_sg_color(nrd_sg sg)
{
    return nrd_ycocg_to_rgb(sg.ycocg);
}

// Colour under the pixel's own normal, components >= 0: with the detail of the normals in IN_NORMAL_ROUGHNESS that
// blending them has taken out of nrd_sg_color(). The denoiser turns the light of every blend towards the pixel's normal
// as it blends, so flat surfaces keep exactly nrd_sg_color(), and on average nothing is gained or lost. For other normals
// than those: the resolve functions below. A noisy pair: nrd_sg_color().
NRDI_FN vec3 nrd_sg_resolved_color(nrd_sg sg)
{
    return nrd_ycocg_to_rgb(nrdi_scale(sg.ycocg, sg.gain > 0.0f ? sg.gain : 1.0f));
}

// Mean direction of the light: unit length, world space; (0,0,0) if there is none (no light, or light from everywhere).
NRDI_FN vec3 nrd_sg_direction(nrd_sg sg)
{
    return nrdi_normalize(sg.moment);
}

// Sharpness of the lobe exp(sharpness (cos - 1)) whose mean direction is as long as the signal's, |moment| / Y = l:
// l (3 - l^2) / (1 - l^2) (Banerjee et al. 2005, "Clustering on the Unit Hypersphere using von Mises-Fisher
// Distributions", section 4). [0,2000]: 0 light from everywhere (or no light), 2000 one direction, as far as 16-bit
// texels can tell. Fed back into the lobe's mean cosine it gives l within 0.013.
NRDI_FN float nrd_sg_sharpness(nrd_sg sg)
{
    float l = min(sqrt(nrdi_dot(sg.moment, sg.moment)) / max(sg.ycocg.x, NRDI_EPSILON), 1.0f);
    return l * (3.0f - l * l) / max(1.0f - l * l, 1e-3f);
}

// Into another space: the columns of a rotation (world to view, world to object, ...).
NRDI_FN nrd_sg nrd_sg_rotate(nrd_sg sg, vec3 column_x, vec3 column_y, vec3 column_z)
{
    nrd_sg rotated = sg;
    rotated.moment = nrdi_add(nrdi_scale(column_x, sg.moment.x),
                              nrdi_add(nrdi_scale(column_y, sg.moment.y), nrdi_scale(column_z, sg.moment.z)));
    return rotated;
}

// Roughness, [0,1], of a surface whose normals differ inside a pixel's footprint: sqrt(r^2 + k) with the variance
// k = (1 - l^2) / (l (3 - l^2)) of a von Mises-Fisher lobe, l the length of the mean normal (Toksvig 2005, "Mipmapping
// Normal Maps"; the estimate of Banerjee et al. as above). mean_normal: mean of unit normals, e.g. over 2x2 pixels, not
// renormalised. l = 1 gives r, l = 0 gives 1. For the specular resolve alone: demodulation and modulation must not
// see it, or they disagree.
NRDI_FN float nrd_roughness_aa(float roughness, vec3 mean_normal)
{
    float l2 = min(nrdi_dot(mean_normal, mean_normal), 1.0f);
    float variance = (1.0f - l2) / max(sqrt(l2) * (3.0f - l2), NRDI_EPSILON);
    return sqrt(clamp(roughness * roughness + variance, 0.0f, 1.0f));
}

// Schlick's (1 - cos)^5.
NRDI_FN float nrdi_pow5(float one_minus_cosine)
{
    float x = clamp(one_minus_cosine, 0.0f, 1.0f);
    float x2 = x * x;
    return x2 * x2 * x;
}

// Integral over the sphere of the product of two lobes amplitude exp(sharpness (axis direction - 1)): amplitudes
// multiplied into one, reach = |sharpness_1 axis_1 + sharpness_2 axis_2|, sum = sharpness_1 + sharpness_2.
NRDI_FN float nrdi_sg_product_integral(float amplitude, float reach, float sum)
{
    float l = max(reach, NRDI_EPSILON);
    precise float front = (reach - sum) * NRDI_LOG2_E;
    precise float back = l * (-2.0f * NRDI_LOG2_E);
    precise float integral = 2.0f * NRDI_PI * amplitude * exp2(front) * (1.0f - exp2(back)) / l;
    return integral;
}

// Burley 2012, "Physically Based Shading at Disney": the diffuse lobe without albedo, 1 / pi at normal incidence.
NRDI_FN float nrdi_burley(float n_dot_v, float n_dot_l, float v_dot_h, float roughness)
{
    precise float f = 2.0f * v_dot_h * v_dot_h * roughness - 0.5f;
    precise float lobe = (1.0f + f * nrdi_pow5(1.0f - n_dot_v)) * (1.0f + f * nrdi_pow5(1.0f - n_dot_l)) / NRDI_PI;
    return lobe;
}

// Height-correlated Smith shadowing over 4 NoL NoV for GGX with alpha = m (Heitz 2014, "Understanding the
// Masking-Shadowing Function in Microfacet-Based BRDFs"; Lagarde & de Rousiers 2014, listing 2).
NRDI_FN float nrdi_smith(float n_dot_v, float n_dot_l, float m)
{
    float m2 = m * m;
    precise float v = n_dot_l * sqrt((n_dot_v - m2 * n_dot_v) * n_dot_v + m2);
    precise float l = n_dot_v * sqrt((n_dot_l - m2 * n_dot_l) * n_dot_l + m2);
    return 0.5f / max(v + l, NRDI_EPSILON);
}

// Direction of the light, `fallback` where the signal has none.
NRDI_FN vec3 nrdi_light_direction(nrd_sg sg, vec3 fallback)
{
    vec3 light = nrd_sg_direction(sg);
    return nrdi_dot(light, light) > 0.25f ? light : fallback;
}

// The signal's hue and saturation under another luma, >= 0.
NRDI_FN vec3 nrdi_scale_luma(nrd_sg sg, float luma)
{
    precise float chroma = (luma + NRDI_EPSILON) / (max(sg.ycocg.x, 0.0f) + NRDI_EPSILON);
    precise float co = sg.ycocg.y * chroma;
    precise float cg = sg.ycocg.z * chroma;
    return nrd_ycocg_to_rgb(vec3(luma, co, cg));
}

// The same, never darker than light from everywhere, Y / pi.
NRDI_FN vec3 nrdi_with_luma(nrd_sg sg, float luma)
{
    precise float least = max(sg.ycocg.x, 0.0f) / NRDI_PI;
    return nrdi_scale_luma(sg, max(luma, least));
}

// Diffuse light on a normal that the denoiser has not seen: demodulated radiance, RGB >= 0; multiply by the diffuse
// factor. normal: of the pixel, with its detail. The light is a lobe of sharpness 2 around its direction; the last factor
// is a fit that makes light from the front keep its energy. No light: 0. The floor of nrdi_with_luma bounds the result
// below; from the front it is the denoised colour, light along the surface comes out at about half.
NRDI_FN vec3 nrd_resolve_diffuse(nrd_sg sg, vec3 normal, vec3 view, float roughness)
{
    vec3 light = nrdi_light_direction(sg, normal);
    float n_dot_l = clamp(nrdi_dot(normal, light), 0.0f, 1.0f);
    float n_dot_v = min(abs(nrdi_dot(normal, view)), 1.0f);
    vec3 half_vector = nrdi_normalize(nrdi_add(light, view));
    float v_dot_h = min(abs(nrdi_dot(view, half_vector)), 1.0f);

    vec3 sum = nrdi_add(light, normal);
    float integral = nrdi_sg_product_integral(2.0f * sg.ycocg.x, 2.0f * sqrt(nrdi_dot(sum, sum)), 4.0f);
    float lobe = nrdi_burley(n_dot_v, n_dot_l, v_dot_h, roughness);
    precise float fit = 1.0f + (0.5f - 0.9f * roughness) * nrdi_pow5(1.0f - n_dot_v);
    precise float luma = integral * lobe * fit;
    return nrdi_with_luma(sg, luma);
}

// Specular light on a normal and roughness that the denoiser has not seen: demodulated radiance, RGB >= 0; multiply by
// the specular factor (it holds the Fresnel term). roughness: of the pixel, or nrd_roughness_aa of it; below 0.05 it
// counts as 0.05. Light of sharpness 2 / alpha^2 meets the lobe of normals, warped to the light's
// directions (Wang et al. 2009, "All-Frequency Rendering of Dynamic, Spatially-Varying Reflectance"); the last factor is
// a fit that makes light from the front keep its energy. No light: 0. Light along or behind the surface: Y / pi.
NRDI_FN vec3 nrd_resolve_specular(nrd_sg sg, vec3 normal, vec3 view, float roughness)
{
    float r = max(roughness, 0.05f);
    float m = r * r;
    float m2 = m * m;
    vec3 light = nrdi_light_direction(sg, normal);
    float n_dot_l = clamp(nrdi_dot(normal, light), 0.0f, 1.0f);
    precise float n_dot_v = 0.02f + 0.98f * min(abs(nrdi_dot(normal, view)), 1.0f);
    vec3 half_vector = nrdi_normalize(nrdi_add(light, view));
    float v_dot_h = min(abs(nrdi_dot(view, half_vector)), 1.0f);

    float sharpness = 2.0f / m2;
    float sum = sharpness + 0.5f / max(m2 * v_dot_h, 1e-8f); // both lobes have the light's axis
    float integral = nrdi_sg_product_integral(sg.ycocg.x * sharpness, sum, sum);
    precise float rim = 0.1f + 0.3f * m2;
    precise float fit = rim + (0.8f - rim) * n_dot_v;
    precise float luma = integral * nrdi_smith(n_dot_v, n_dot_l, m) * n_dot_l * fit;
    return nrdi_with_luma(sg, luma);
}

// Share of the mirror direction in the mean direction of a GGX lobe, [0,1]: 1 mirror, 0 rough surface seen from the
// front (fit of Lagarde & de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section 4.9.3). n_dot_v
// and roughness [0,1].
NRDI_FN float nrd_specular_dominant_factor(float n_dot_v, float roughness)
{
    float q = 0.298475f * log(39.4115f - 39.0029f * roughness);
    return clamp(q + (1.0f - q) * pow(max(1.0f - n_dot_v, 0.0f), 10.8649f), 0.0f, 1.0f);
}

// Mean direction of a GGX lobe, unit length; view on the side of the normal.
NRDI_FN vec3 nrd_specular_dominant_direction(vec3 normal, vec3 view, float roughness)
{
    float n_dot_v = nrdi_dot(normal, view);
    vec3 mirrored = nrdi_add(nrdi_scale(normal, 2.0f * n_dot_v), nrdi_scale(view, -1.0f));
    float factor = nrd_specular_dominant_factor(min(abs(n_dot_v), 1.0f), roughness);
    return nrdi_normalize(nrdi_mix(normal, mirrored, factor));
}

NRDI_FN vec3 nrdi_resolve_first_order(nrd_sg sg, vec3 axis)
{
    precise float luma = (sg.ycocg.x + 3.0f * nrdi_dot(sg.moment, axis)) / NRDI_PI;
    return nrdi_scale_luma(sg, max(luma, 0.0f));
}

// Cheaper than nrd_resolve_diffuse, with less contrast: the pair as spherical harmonics of first order,
// Y / pi + 3 / pi (moment normal), >= 0. Same use.
NRDI_FN vec3 nrd_resolve_diffuse_first_order(nrd_sg sg, vec3 normal)
{
    return nrdi_resolve_first_order(sg, normal);
}

// The same for the specular lobe, along its mean direction.
NRDI_FN vec3 nrd_resolve_specular_first_order(nrd_sg sg, vec3 normal, vec3 view, float roughness)
{
    return nrdi_resolve_first_order(sg, nrd_specular_dominant_direction(normal, view, roughness));
}

//----------------------------------------------------------------------------------------------------------------------
// >>rejitter: sub-pixel detail for an upscaler
//----------------------------------------------------------------------------------------------------------------------

// Denoising averages over pixels whose normals differ with the jitter, which an upscaler needs to see. The ratio of the
// lobes' values under the pixel's own normal and under its neighbours' puts that difference back.

// The lobes' values, times the cosine, for one normal: x diffuse, y specular (GGX, without Fresnel term).
NRDI_FN vec2 nrdi_rejitter_lobes(vec3 normal, vec3 view, vec3 light_diffuse, vec3 light_specular, float roughness)
{
    vec3 half_diffuse = nrdi_normalize(nrdi_add(light_diffuse, view));
    float n_dot_v = min(abs(nrdi_dot(normal, view)), 1.0f);
    float n_dot_l = clamp(nrdi_dot(normal, light_diffuse), 0.0f, 1.0f);
    float v_dot_h = min(abs(nrdi_dot(view, half_diffuse)), 1.0f);
    precise float diffuse = nrdi_burley(n_dot_v, n_dot_l, v_dot_h, roughness) * n_dot_l;

    float m = roughness * roughness;
    vec3 h = nrdi_normalize(nrdi_add(light_specular, view));
    vec3 across = vec3(normal.y * h.z - normal.z * h.y, normal.z * h.x - normal.x * h.z,
                       normal.x * h.y - normal.y * h.x); // its square is 1 - NoH^2, without cancellation
    float n_dot_h = nrdi_dot(normal, h);
    precise float d = m / (n_dot_h * n_dot_h * m * m + nrdi_dot(across, across));
    n_dot_l = clamp(nrdi_dot(normal, light_specular), 0.0f, 1.0f);
    precise float specular = d * d / NRDI_PI * nrdi_smith(n_dot_v, n_dot_l, m) * n_dot_l;
    return vec2(diffuse, specular);
}

NRDI_FN bool nrdi_is_same_surface(float view_z, float neighbour_view_z, vec3 normal, vec3 neighbour_normal,
                                  float tolerance)
{
    return abs(neighbour_view_z - view_z) <= tolerance && nrdi_dot(normal, neighbour_normal) >= 0.01f;
}

// Multipliers of the resolved (x) diffuse and (y) specular light, each in [1/2,2]; exactly (1,1) where the normals are
// equal or a neighbour belongs to another surface (depths further apart than 1 % of view_z over the slope, or normals
// that face away from each other). diffuse, specular: the denoised pairs of the pixel. view_z and normal: of the pixel;
// view_z_4: of its neighbours (east, west, south, north), normal_e and so on theirs; all from this frame's jittered
// guides. Outside the image give the pixel's own.
NRDI_FN vec2 nrd_rejitter(nrd_sg diffuse, nrd_sg specular, vec3 view, float roughness, float view_z, vec3 normal,
                          vec4 view_z_4, vec3 normal_e, vec3 normal_w, vec3 normal_s, vec3 normal_n)
{
    float n_dot_v = min(abs(nrdi_dot(normal, view)), 1.0f);
    float tolerance = 0.01f * abs(view_z) / (0.05f + 0.95f * n_dot_v);
    bool same = nrdi_is_same_surface(view_z, view_z_4.x, normal, normal_e, tolerance) &&
                nrdi_is_same_surface(view_z, view_z_4.y, normal, normal_w, tolerance) &&
                nrdi_is_same_surface(view_z, view_z_4.z, normal, normal_s, tolerance) &&
                nrdi_is_same_surface(view_z, view_z_4.w, normal, normal_n, tolerance);
    if (!same)
        return vec2(1.0f, 1.0f);

    float r = max(roughness, 0.05f);
    vec3 light_d = nrdi_light_direction(diffuse, normal);
    vec3 light_s = nrdi_light_direction(specular, normal);
    light_s = nrdi_normalize(nrdi_mix(view, light_s, nrd_roughness_curve(r, 0.5f))); // steadier for sharp lobes
    vec2 own = nrdi_rejitter_lobes(normal, view, light_d, light_s, r);
    vec2 e = nrdi_rejitter_lobes(normal_e, view, light_d, light_s, r);
    vec2 w = nrdi_rejitter_lobes(normal_w, view, light_d, light_s, r);
    vec2 s = nrdi_rejitter_lobes(normal_s, view, light_d, light_s, r);
    vec2 n = nrdi_rejitter_lobes(normal_n, view, light_d, light_s, r);
    precise float mean_diffuse = (e.x + w.x + s.x + n.x) * 0.25f;
    precise float mean_specular = (e.y + w.y + s.y + n.y) * 0.25f;
    return vec2(clamp((own.x + NRDI_EPSILON) / (mean_diffuse + NRDI_EPSILON), 0.5f, 2.0f),
                clamp((own.y + NRDI_EPSILON) / (mean_specular + NRDI_EPSILON), 0.5f, 2.0f));
}

//----------------------------------------------------------------------------------------------------------------------
// >>occlusion
//----------------------------------------------------------------------------------------------------------------------

// The texel of an occlusion input: the normalised hit distance, [0,1], 1 open. NaN and Inf become 0 (not sampled). The
// denoised texel has the same scale. An occlusion ray of limited length reports a miss as NRD_HIT_DIST_MISS, which
// nrd_normalize_hit_dist takes to 1.
NRDI_FN float nrd_pack_occlusion(float norm_hit_dist)
{
    return nrd_sanitize_norm_hit_dist(norm_hit_dist);
}

// The texel of a directional occlusion input: (direction a, a) with a = norm_hit_dist, the zeroth and first moment of
// openness; components in [-1,1], for signed formats of 8 or 16 bits. a = 0 gives four zeros (not sampled).
NRDI_FN vec4 nrd_pack_directional_occlusion(vec3 direction, float norm_hit_dist, bool sanitize)
{
    float a = sanitize ? nrd_sanitize_norm_hit_dist(norm_hit_dist) : norm_hit_dist;
    return nrdi_append(nrdi_scale(sanitize ? nrd_sanitize_direction(direction) : direction, a), a);
}

// Inverse, noisy or denoised: xyz the bent direction, unit length, `normal` where nothing is open; w the openness, [0,1].
NRDI_FN vec4 nrd_unpack_directional_occlusion(vec4 texel, vec3 normal)
{
    vec3 bent = nrdi_normalize(nrdi_xyz(texel));
    return nrdi_append(nrdi_dot(bent, bent) > 0.25f ? bent : normal, clamp(texel.w, 0.0f, 1.0f));
}

// The same texel as white light of luma w, for nrd_resolve_diffuse and nrd_sg_sharpness.
NRDI_FN nrd_sg nrd_directional_occlusion_to_sg(vec4 texel)
{
    return nrd_unpack_sh(vec4(texel.w, 0.0f, 0.0f, texel.w), nrdi_append(nrdi_xyz(texel), 0.0f));
}

//----------------------------------------------------------------------------------------------------------------------
// >>sampling: which lobe or pixel is traced
//----------------------------------------------------------------------------------------------------------------------

// With one path per pixel for both lobes, a lobe is chosen by chance and its light divided by the probability; the other
// lobe's hit distance is 0 (not sampled), and the denoiser reconstructs it from neighbours:
//   p = nrd_clamp_lobe_probability(p_diffuse, 1.0);
//   is_diffuse = nrd_split_threshold(x, y, frame_index, random) < p;
//   radiance /= is_diffuse ? p : 1.0 - p;

// Probability of the diffuse lobe, [0,1], kept in [1/4,3/4] (radius 1: reconstruction from 3x3 pixels) or [1/16,15/16]
// (radius 2: 5x5), so that every neighbourhood of that radius holds both lobes under nrd_split_threshold. NaN: the lower
// limit. A surface that has one lobe only needs no choice: trace it and leave the other's hit distance 0.
NRDI_FN float nrd_clamp_lobe_probability(float probability, float radius)
{
    float least = exp2(-2.0f * radius);
    return clamp(nrdi_is_nan(probability) ? 0.0f : probability, least, 1.0f - least);
}

// A number in [0,1) to compare probabilities with: 16 ordered levels over 4x4 pixels (Bayer 1973), which move on by 7/16
// each frame, so that 16 frames give a pixel every level, plus `random` / 16. random: uniform, [0,1); with it the
// threshold is uniform too and estimates that divide by the probability stay unbiased.
NRDI_FN float nrd_split_threshold(uint x, uint y, uint frame_index, float random)
{
    uint a = x ^ y;
    uint level = ((a & 1u) << 3u) | ((y & 1u) << 2u) | (a & 2u) | ((y >> 1u) & 1u);
    return (NRDI_FLOAT((level + 7u * frame_index) & 15u) + random) * (1.0f / 16.0f);
}

// Checkerboard: the colour, 0 or 1, of pixel (x,y) in this frame; it alternates. The signal is traced where its colour
// comes up and stored at half width, at texel (x / 2, y), rounded down.
NRDI_FN uint nrd_checkerboard_color(uint x, uint y, uint frame_index)
{
    return (x ^ y ^ frame_index) & 1u;
}

// The x of the pixel whose signal of that colour is stored in column `texel_x` of the half-width texture: where a ray
// generation shader launched at half width traces.
NRDI_FN uint nrd_checkerboard_x(uint texel_x, uint y, uint frame_index, uint color)
{
    return texel_x * 2u + ((y ^ frame_index ^ color) & 1u);
}

//----------------------------------------------------------------------------------------------------------------------
// >>upsampling: signals at half resolution
//----------------------------------------------------------------------------------------------------------------------

// A full-resolution pixel's position in the half-resolution texture, in its texels; texel i has its centre at i. The
// four taps are floor(position) + (0 or 1), clamped to the texture, and fract(position) goes to nrd_upsample_weights.
// pixel: (x, y) or (y, x), whole numbers. A half-resolution texel stands for the 2x2 pixels that it covers.
NRDI_FN vec2 nrd_half_resolution_position(vec2 pixel)
{
    return vec2(pixel.x * 0.5f - 0.25f, pixel.y * 0.5f - 0.25f);
}

// NaN and Inf: as far as can be.
NRDI_FN float nrdi_depth_difference(float view_z, float tap_view_z)
{
    float difference = abs(tap_view_z - view_z);
    return nrd_is_finite(difference) ? difference : uintBitsToFloat(0x7f7fffffu);
}

NRDI_FN float nrdi_upsample_weight(float bilinear, float depth_difference, float tolerance, float cosine)
{
    float c2 = clamp(cosine, 0.0f, 1.0f) * clamp(cosine, 0.0f, 1.0f);
    float c4 = c2 * c2;
    float depth = depth_difference / tolerance;
    return depth < 8.0f ? bilinear * c4 * c4 * exp2(-depth * depth) : 0.0f;
}

// Weights, sum 1, of four half-resolution taps (0,0), (1,0), (0,1), (1,1) at a full-resolution pixel (joint bilateral
// up-sampling: Kopf et al. 2007): bilinear, times 2^-(depth difference / tolerance)^2 with a tolerance of 1 % of view_z
// over the slope, times the 8th power of the cosine between the normals. Where all taps differ, the nearest in depth.
// fraction: fract of nrd_half_resolution_position. n_dot_v: [0,1], normal against view. view_z_4 and cosines: of the
// taps, the latter dot(normal, normal of the tap). A tap whose view_z is not finite gets 0; four of those: four zeros.
NRDI_FN vec4 nrd_upsample_weights(vec2 fraction, float view_z, float n_dot_v, vec4 view_z_4, vec4 cosines)
{
    float tolerance = max(0.01f * abs(view_z) / (0.05f + 0.95f * n_dot_v), NRDI_EPSILON);
    vec4 difference = vec4(nrdi_depth_difference(view_z, view_z_4.x), nrdi_depth_difference(view_z, view_z_4.y),
                           nrdi_depth_difference(view_z, view_z_4.z), nrdi_depth_difference(view_z, view_z_4.w));
    float left = 1.0f - fraction.x;
    float top = 1.0f - fraction.y;
    vec4 w = vec4(nrdi_upsample_weight(left * top, difference.x, tolerance, cosines.x),
                  nrdi_upsample_weight(fraction.x * top, difference.y, tolerance, cosines.y),
                  nrdi_upsample_weight(left * fraction.y, difference.z, tolerance, cosines.z),
                  nrdi_upsample_weight(fraction.x * fraction.y, difference.w, tolerance, cosines.w));
    float sum = w.x + w.y + w.z + w.w;
    if (sum > 1e-3f)
        return vec4(w.x / sum, w.y / sum, w.z / sum, w.w / sum);

    float least = min(min(difference.x, difference.y), min(difference.z, difference.w));
    if (!(least < uintBitsToFloat(0x7f7fffffu)))
        return vec4(0.0f, 0.0f, 0.0f, 0.0f);
    bool x = difference.x <= least;
    bool y = !x && difference.y <= least;
    bool z = !x && !y && difference.z <= least;
    return vec4(x ? 1.0f : 0.0f, y ? 1.0f : 0.0f, z ? 1.0f : 0.0f, x || y || z ? 0.0f : 1.0f);
}

//----------------------------------------------------------------------------------------------------------------------
// >>overloads: for GLSL alone
//----------------------------------------------------------------------------------------------------------------------

#ifndef NRDI_C

// True if all three components are finite. Loops over many paths use it to skip a bad sample before it enters a sum.
bool nrd_is_finite(vec3 value)
{
    return nrdi_is_finite(value);
}

vec2 nrd_round_to_half(vec2 value)
{
    return vec2(nrd_round_to_half(value.x), nrd_round_to_half(value.y));
}

vec3 nrd_round_to_half(vec3 value)
{
    return vec3(nrd_round_to_half(value.xy), nrd_round_to_half(value.z));
}

vec4 nrd_round_to_half(vec4 value)
{
    return vec4(nrd_round_to_half(value.xy), nrd_round_to_half(value.zw));
}

// From clip space positions: projection * view * position, without jitter.
vec3 nrd_motion_2_5d(vec4 clip, float view_z, vec4 clip_prev, float view_z_prev)
{
    return nrd_motion_2_5d(nrd_clip_to_uv(clip), view_z, nrd_clip_to_uv(clip_prev), view_z_prev);
}

#endif

#endif
