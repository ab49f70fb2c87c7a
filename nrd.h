/* nrd.h - real-time ray-tracing denoisers as data: every pass, texture, constant and dispatch, for any GPU API.

   Do this in ONE C or C++ file, then include the header anywhere:
       #define NRD_IMPLEMENTATION
       #include "nrd.h"
   With Vulkan you need nothing but nrd_vk.h, which runs what this header describes; examples/minimal.c is the whole program.

   WHAT IT DOES NOT DO
   It knows no graphics API, allocates no GPU memory and records nothing: it says which textures and pipelines exist and, every
   frame, which dispatches to run with which resources and constants. It does no I/O and uses no libc but math.h and string.h
   (and malloc/free, unless you bring your own).

   STEP BY STEP
   1. Fill nrd_desc (size, denoisers) and call nrd_create. Nothing of the GPU is touched.
   2. nrd_get_info tells every texture, pipeline and byte: create them, or stop here if that is too much.
   3. Every frame: fill nrd_frame (start from nrd_frame_defaults) and call nrd_set_frame.
   4. When a setting changes: nrd_set_settings with that denoiser's settings struct (start from its ..._defaults function).
   5. Every frame: nrd_get_dispatches, and execute the dispatches in order.
   6. When the images get another size: nrd_resize. History is kept.
   7. nrd_destroy.

   DECLARED AT CREATION
   features     NRD_FEATURE_ bits, optional inputs and passes. What is not declared is not compiled, bound or allocated; settings that need it
                are refused by name.
   absent       NRD_ABSENT_ bits, promises of what will never be needed: what only that needs disappears. A kept promise changes no bit.

   LOOKING INSIDE
   nrd_explain      what is kept and left out under what is declared and set now, why, and what that costs or saves.
   nrd_check_rule   with NRD_FEATURE_CHECK: names what is wrong with the inputs, in which share of the pixels, and the likely cause.
   nrd_frame.validation   with NRD_FEATURE_VALIDATION: draws what a denoiser gets and remembers into OUT_VALIDATION.
   nrd_settings_preset, nrd_suggest   settings on the measured front of error against time; the best ones for a budget.

   CONVENTIONS
   matrices     column-major float[16], column vectors: p_clip = view_to_clip * world_to_view * p_world. Element (row r, column c) is
                m[4 * c + r]. Row-major with row vectors has the same bytes. view_to_clip is not jittered; perspective or orthographic, left- or
                right-handed, z/w in [0,1], normal or reversed, infinite far plane allowed: all of it is read off the matrix.
   uv           (pixel + 0.5) / rect, y down, row 0 is the top of the picture.
   clip y       NRD_CLIP_Y_AUTO takes view space as +y up: view_to_clip[5] > 0 is "clip y up" (D3D, GL), < 0 "clip y down" (Vulkan).
                Where y of the view points down, say NRD_CLIP_Y_UP or NRD_CLIP_Y_DOWN.
   view z       IN_VIEWZ * view_z_scale, either sign; abs() of it is used. Sky: any value with abs >= denoising_range.
   motion       previous minus current, not jittered: 2D   uv_prev = uv + motion.xy,
                2.5D  also view_z_prev = view_z + motion.z (same sign as view z; use this), world   X_prev = X + motion.xyz.
   jitter       in pixels: the ray of pixel p went through p + 0.5 + jitter.
   radiance     linear, not exposed, demodulated: divided by the material factors of nrd_material_factors() in nrd.glsl.
   hit distance from the primary hit to the next hit, world units, packed by nrd_pack_radiance_hit_dist() in nrd.glsl.
   direction    of a path's first ray, world space, unit length, from the surface, packed with radiance by nrd_pack_sh() (the denoisers named SH).
   penumbra     half width at the receiver, world units, from one ray to the light; 0: faces away; 65504: the ray arrived (nrd_pack_penumbra()).
   units        lengths in world units; defaults assume metres.

   ERRORS, MEMORY, THREADS
   Every function that can fail returns nrd_result; nrd_desc.message also gets one line with the field, its value and what is allowed.
   A call that fails changes nothing. Memory is taken in nrd_create only, in one block. No globals: instances are independent, one
   instance is used by one thread at a time.

   STABILITY
   Numbers of enumerators and bits never change; new ones come last, and _COUNT grows. Structs may change at a release: name members in
   initialisers, begin with the ..._defaults functions. Whoever compiles the implementation apart from its callers sets struct_version to
   NRD_STRUCT_VERSION: structs of another header are then refused (NRD_RESULT_WRONG_VERSION). nrd_version() is the implementation's release.
   CHANGELOG.md says of everything removed what to write instead.

   NAMES
   NVIDIA's denoiser library also has a header called NRD.h and NRD_ macros: keep the two in different include paths and files.

   MIT licence, see LICENSE. */
#ifndef NRD_H
#define NRD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef NRD_DECL
#ifdef NRD_STATIC
#define NRD_DECL static inline
#else
#define NRD_DECL extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define NRD_RELEASE "0.1.0"
#define NRD_RELEASE_NUMBER 100u /* 10000 * major + 100 * minor + patch */

/* ---------------------------------------------------------------------------------------------------------------------------
   What C and GLSL share: `make shared` cuts this block into nrd_shaders/common/nrd_shared.glsl.
   >>shared begin */
/* How IN_NORMAL_ROUGHNESS is packed (nrd.glsl packs it). SNORM16 also means float textures. */
#define NRD_NORMAL_FORMAT_RGB10A2_UNORM 0
#define NRD_NORMAL_FORMAT_RGBA8_UNORM   1
#define NRD_NORMAL_FORMAT_RGBA8_SNORM   2
#define NRD_NORMAL_FORMAT_RGBA16_UNORM  3
#define NRD_NORMAL_FORMAT_RGBA16_SNORM  4
#define NRD_ROUGHNESS_FORMAT_LINEAR      0
#define NRD_ROUGHNESS_FORMAT_SQ_LINEAR   1
#define NRD_ROUGHNESS_FORMAT_SQRT_LINEAR 2

/* nrd_frame.motion_mode, see CONVENTIONS. */
#define NRD_MOTION_2D    0
#define NRD_MOTION_2_5D  1
#define NRD_MOTION_WORLD 2

/* nrd_frame.specular_motion: what IN_SPEC_MV holds, previous minus current. A component of NaN, infinity or 60000 and more: not given.
   IMAGE: xy, where the previous picture showed the same reflected point on the mirror: uv_prev = uv + xy (times motion_scale_x, _y unless
   motion_mode is WORLD); z, w unused. Of a flat mirror it is the motion of the mirrored point (nrd_mirror_point, nrd_motion_of_points).
   HIT: xyz, how the point that the specular path hits has moved, world units (an object's X_prev - X; 0: it stands still); for mirrors of
   any shape: the denoiser finds where that point was mirrored. */
#define NRD_SPECULAR_MOTION_NONE  0
#define NRD_SPECULAR_MOTION_IMAGE 1
#define NRD_SPECULAR_MOTION_HIT   2

/* Optional inputs and passes an app may declare in nrd_desc.features; what is not declared is not compiled, bound or allocated. */
#define NRD_FEATURE_HISTORY_CONFIDENCE           1 /* IN_DIFF_CONFIDENCE, IN_SPEC_CONFIDENCE */
#define NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX   2 /* IN_DISOCCLUSION_THRESHOLD_MIX */
#define NRD_FEATURE_PREPASS                      4 /* diffuse_prepass_blur_radius, specular_prepass_blur_radius */
#define NRD_FEATURE_SPLIT_SCREEN                 8 /* nrd_frame.split_screen */
#define NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION 16 /* hit_distance_reconstruction */
#define NRD_FEATURE_CHECKERBOARD                32 /* diffuse_checkerboard, specular_checkerboard */
#define NRD_FEATURE_CHECK                       64 /* counts what is wrong with the inputs: nrd_check_rule */
#define NRD_FEATURE_VALIDATION                 128 /* nrd_frame.validation draws inputs and histories into OUT_VALIDATION */
#define NRD_FEATURE_SPECULAR_MOTION            256 /* IN_SPEC_MV, nrd_frame.specular_motion */
#define NRD_FEATURE_MATERIALS                  512 /* min_material_for_ of each signal, strand and camera-attached materials */
#define NRD_FEATURE_ROUGHNESS_LIMIT           1024 /* specular_roughness_limit; NRD_ABSENT_SKY then has no effect */
#define NRD_FEATURE_ALL                       2047

/* What an app may promise in nrd_desc.absent; passes, textures, inputs and code that only this would need disappear. NRD_ABSENCES says
   what each means. */
#define NRD_ABSENT_DIFFUSE           1
#define NRD_ABSENT_SPECULAR          2
#define NRD_ABSENT_MOTION            4
#define NRD_ABSENT_SKY               8
#define NRD_ABSENT_MATERIALS        16
#define NRD_ABSENT_MIRRORS          32
#define NRD_ABSENT_STABILIZATION    64
#define NRD_ABSENT_LIGHTING_CHANGE 128
#define NRD_ABSENT_BLUR            256
#define NRD_ABSENT_ALL             511

/* Specialization constants of the pipelines: X(name, id). */
#define NRD_SPEC_CONSTANTS(X) \
    X(NORMAL_FORMAT, 0) \
    X(ROUGHNESS_FORMAT, 1) \
    X(FEATURES, 2) \
    X(ABSENT, 3) \
    X(ITERATION, 4)   /* of the spatial filter: one module serves several passes */

/* The constant block of every pass (uniform buffer, binding 0, std140 = C layout): X(type, name).
   Only mat4, vec4 and 32-bit scalars, every vec4 on a multiple of 16 bytes. World space is relative to the current camera. */
#define NRD_CONSTANTS(X) \
    X(mat4, view_to_world)          /* rotation only */ \
    X(mat4, world_to_view_prev)     /* from the current camera-relative world */ \
    X(mat4, view_to_view_prev) \
    X(vec4, frustum)                /* view xy = frustum.xy + uv * frustum.zw, times view z unless orthographic */ \
    X(vec4, frustum_prev) \
    X(vec4, motion_scale)           /* w: anti_firefly_scale, 0 or at least 1 */ \
    X(vec4, hit_distance)           /* A, B, C, D of nrd_hit_dist_scale */ \
    X(vec4, jitter_delta)           /* xy: current - previous, px; z: what part of its diameter the light of a shadow has moved by; w: specular_roughness_limit, 2: none */ \
    X(vec4, light)                  /* view space: unit vector to a directional light (w 0), position of a local one (w 1); xyz 0: unknown */ \
    X(vec4, camera)                 /* xyz: its world position; w: world size of the rectangle's shorter side at view z 1 */ \
    X(uint, rect_width) X(uint, rect_height) X(uint, rect_width_prev) X(uint, rect_height_prev) \
    X(uint, rect_origin_x) X(uint, rect_origin_y) X(uint, frame_index) X(uint, reset) \
    X(float, orthographic) X(float, orthographic_prev) X(float, pixel_unproject) X(float, view_z_scale) \
    X(float, denoising_range) X(float, disocclusion_threshold) X(float, disocclusion_threshold_alternate) X(float, split_screen) \
    X(uint, motion_mode) X(uint, history_frames) X(float, max_accumulated_frames) X(float, max_stabilized_frames) \
    X(float, history_fix_frames) X(float, max_blur_radius) X(float, prepass_blur_radius) X(float, luminance_sigma_scale) \
    X(float, plane_distance_sensitivity) X(float, normal_sensitivity) X(float, antilag_sigma_scale) X(float, antilag_sensitivity) \
    X(float, stabilization_sigma_scale) X(float, feedback_frames) X(uint, min_material) X(uint, flags) \
    X(float, denoising_range_prev) X(float, specular_prepass_blur_radius) X(float, light_radius) X(float, penumbra_blur_scale) \
    X(uint, materials) X(float, strand_thickness) X(float, responsive_roughness) X(float, responsive_frames) /* materials: four ids of 4 bits, NRD_MATERIAL_ */ \
    X(vec4, rect_px)                /* width and height of the rectangle, zw: of the previous one */ \
    X(vec4, px_uv)                  /* what a pixel is of them */ \
    X(vec4, jitter_uv)              /* xy: current, zw: previous */ \
    X(vec4, texel_uv)               /* what a texel is of the instance's textures, zw: of those of the previous frame */ \
    X(vec4, tile_uv)                /* the same of textures of tiles */ \
    X(vec4, tile_last)              /* the middle of the last tile of the rectangle, in tiles, zw: of the previous one's */

/* Where in nrd_constants.materials */
#define NRD_MATERIAL_LEAST_DIFFUSE    0
#define NRD_MATERIAL_LEAST_SPECULAR   4
#define NRD_MATERIAL_STRAND           8
#define NRD_MATERIAL_CAMERA_ATTACHED 12

/* nrd_constants.flags */
#define NRD_FLAG_HISTORY_CONFIDENCE  1u
#define NRD_FLAG_DISOCCLUSION_MIX    2u
#define NRD_FLAG_RETURN_HISTORY      4u
#define NRD_FLAG_ANTILAG             8u
#define NRD_FLAG_PREPASS            16u
#define NRD_FLAG_SPECULAR_PREPASS   64u
#define NRD_FLAG_TILE_HISTORY       32u /* the previous frame has looked for lighting changes */
#define NRD_FLAG_RECONSTRUCTION    128u
#define NRD_FLAG_WIDE_RECONSTRUCTION 256u
#define NRD_FLAG_DIFFUSE_CHECKERBOARD 512u
#define NRD_FLAG_DIFFUSE_WHITE       1024u
#define NRD_FLAG_SPECULAR_CHECKERBOARD 2048u
#define NRD_FLAG_SPECULAR_WHITE      4096u
#define NRD_FLAG_SPECULAR_MOTION     8192u
#define NRD_FLAG_SPECULAR_MOTION_HIT 16384u
#define NRD_FLAG_PERFORMANCE        32768u

#define NRD_FLAG_MATRIX_JITTER   65536u /* the principal point has moved by less than a pixel since the last frame */
#define NRD_FLAG_FRAME_INDEX    131072u /* frame_index did not advance by 1 */

/* What the input checker counts, X(name, index of the counter). */
#define NRD_COUNTER_COUNT 80
#define NRD_COUNTERS(X) \
    /* how many pixels a rule can be asked of */ \
    X(FRAMES, 0) X(PIXELS, 1) X(SURFACES, 2) X(PLANES, 3) X(MOVED, 4) X(STILL, 5) X(DEPTH_MOVED, 6) X(JITTERED, 7) \
    X(FACING_LIGHT, 8) X(AWAY_FROM_LIGHT, 9) X(LIT_OR_FAR, 10) X(OCCLUDERS, 11) X(BLOCKED_TRIPLES, 12) X(LIT, 13) X(DIRECTIONS, 14) \
    X(DIFF_BRIGHT, 15) X(DIFF_HITS, 16) X(SPEC_BRIGHT, 17) X(SPEC_HITS, 18) \
    /* how many break it */ \
    X(MATRIX_JITTER, 20) X(FRAME_INDEX, 21) X(VIEWZ_NOT_FINITE, 22) X(VIEWZ_ZERO, 23) X(VIEWZ_NEGATIVE, 24) X(SKY_IN_RANGE, 25) \
    X(NORMAL_NOT_FINITE, 26) X(NORMAL_LENGTH, 27) X(NORMAL_AWAY, 28) X(NORMAL_PLANE, 29) X(MOTION_NOT_FINITE, 30) X(MOTION_CAMERA, 31) \
    X(MOTION_STILL, 32) X(MOTION_DEPTH, 33) X(MOTION_JITTER, 34) \
    X(DIFF_NOT_FINITE, 35) X(DIFF_NEGATIVE, 36) X(DIFF_HIT_NEGATIVE, 37) X(DIFF_HIT_RANGE, 38) X(DIFF_HIT_MISSING, 39) X(DIFF_HIT_PRIMARY, 40) \
    X(SPEC_NOT_FINITE, 41) X(SPEC_NEGATIVE, 42) X(SPEC_HIT_NEGATIVE, 43) X(SPEC_HIT_RANGE, 44) X(SPEC_HIT_MISSING, 45) X(SPEC_HIT_PRIMARY, 46) \
    X(DIRECTION_LENGTH, 47) X(DIRECTION_BELOW, 48) \
    X(PENUMBRA_INVALID, 49) X(PENUMBRA_CODE, 50) X(PENUMBRA_ZERO, 51) X(PENUMBRA_AWAY, 52) X(PENUMBRA_MISS, 53) X(PENUMBRA_FROM_LIGHT, 54) \
    X(PENUMBRA_FIRST_HIT, 55) X(TRANSLUCENCY_LIT, 56) \
    /* how many would be right if ..: likely causes */ \
    X(NORMAL_IF_NEGATED, 60) X(NORMAL_IF_X_FLIPPED, 61) X(NORMAL_IF_Y_FLIPPED, 62) X(NORMAL_IF_Z_FLIPPED, 63) X(NORMAL_IF_YZ_SWAPPED, 64) \
    X(NORMAL_IF_VIEW_SPACE, 65) X(NORMAL_IF_TRANSPOSED, 66) \
    X(MOTION_IF_NEGATED, 67) X(MOTION_IF_PIXELS, 68) X(MOTION_IF_CLIP, 69) X(MOTION_IF_CLIP_Y_DOWN, 70) X(MOTION_IF_Y_FLIPPED, 71) X(MOTION_IF_SCALED_TWICE, 72) \
    X(MOTION_IF_TRANSPOSED, 73) X(MOTION_ZERO, 74) X(DEPTH_IF_NEGATED, 75) X(DEPTH_ZERO, 76)

/* Which signals the checker looks at (the push constant `iteration`): radiance and hit distances of the diffuse lobe, the specular one or both; .. */
#define NRD_SIGNALS_RADIANCE    0u /* + 0, 1, 2 */
#define NRD_SIGNALS_HIT_DIST    3u /* + 0, 1, 2 */
#define NRD_SIGNALS_DIRECTION   6u
#define NRD_SIGNALS_SHADOW      7u
#define NRD_SIGNALS_TRANSLUCENT_SHADOW 8u

/* Push constants of every pass. */
#define NRD_PUSH_CONSTANTS(X) X(int, step_size) X(uint, iteration)
/* >>shared end */

/* ---------------------------------------------------------------------------------------------------------------------------
   Results and messages  >>results */
#define NRD_RESULTS(X) \
    X(OK, "ok") \
    X(INVALID_ARGUMENT, "an argument is missing or outside its range") \
    X(OUT_OF_MEMORY, "the allocator returned NULL") \
    X(UNKNOWN_DENOISER, "no denoiser has this identifier or name") \
    X(DUPLICATE_IDENTIFIER, "two denoisers of one instance have the same identifier") \
    X(FRAME_NOT_SET, "nrd_get_dispatches was called before nrd_set_frame") \
    X(UNSUPPORTED_DEVICE, "the device lacks something the denoisers need") \
    X(MISSING_RESOURCE, "a resource that a denoiser needs was not given") \
    X(DEVICE_ERROR, "the graphics API returned an error") \
    X(WRONG_VERSION, "a struct was filled with another version of the header") \
    X(DESTROYED, "the instance was destroyed before, or is none")
typedef enum nrd_result {
#define NRDI_X(name, text) NRD_RESULT_##name,
    NRD_RESULTS(NRDI_X)
#undef NRDI_X
    NRD_RESULT_COUNT
} nrd_result;

typedef enum nrd_severity { NRD_SEVERITY_WARNING, NRD_SEVERITY_ERROR } nrd_severity;

NRD_DECL const char *nrd_result_string(nrd_result result);
NRD_DECL uint32_t nrd_version(void); /* NRD_RELEASE_NUMBER of the implementation */

/* ---------------------------------------------------------------------------------------------------------------------------
   Denoisers and their resources  >>resources */
/* X(enum name, name on command lines, settings struct) */
#define NRD_DENOISERS(X) \
    X(REFERENCE, "reference", nrd_reference_settings) \
    X(REBLUR_DIFFUSE, "reblur_diffuse", nrd_reblur_settings) \
    X(REBLUR_SPECULAR, "reblur_specular", nrd_reblur_settings) \
    X(REBLUR_DIFFUSE_SPECULAR, "reblur_diffuse_specular", nrd_reblur_settings) \
    X(REBLUR_DIFFUSE_OCCLUSION, "reblur_diffuse_occlusion", nrd_occlusion_settings) \
    X(REBLUR_SPECULAR_OCCLUSION, "reblur_specular_occlusion", nrd_occlusion_settings) \
    X(REBLUR_DIFFUSE_SPECULAR_OCCLUSION, "reblur_diffuse_specular_occlusion", nrd_occlusion_settings) \
    X(REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, "reblur_diffuse_directional_occlusion", nrd_occlusion_settings) \
    X(SIGMA_SHADOW, "sigma_shadow", nrd_sigma_settings) \
    X(SIGMA_SHADOW_TRANSLUCENCY, "sigma_shadow_translucency", nrd_sigma_settings) \
    X(REBLUR_DIFFUSE_SH, "reblur_diffuse_sh", nrd_reblur_settings) \
    X(REBLUR_SPECULAR_SH, "reblur_specular_sh", nrd_reblur_settings) \
    X(REBLUR_DIFFUSE_SPECULAR_SH, "reblur_diffuse_specular_sh", nrd_reblur_settings)
typedef enum nrd_denoiser {
#define NRDI_X(name, text, settings) NRD_DENOISER_##name,
    NRD_DENOISERS(NRDI_X)
#undef NRDI_X
    NRD_DENOISER_COUNT
} nrd_denoiser;

/* Denoisers that a program does without. Define NRD_NO_<name> for each, or NRD_ONLY_<name> for each that it needs, empty or as 1, before
   the implementation is included (with nrd_vk.h: before both): the others' tables and SPIR-V are then not compiled, and nrd_create
   refuses them. `-DNRD_ONLY_REBLUR_DIFFUSE -DNRD_ONLY_SIGMA_SHADOW`. A name that is no denoiser's has no effect. */
#define NRDI_DEFINED_ 0,
#define NRDI_DEFINED_1 0,
#define NRDI_SECOND(a, b, ...) b
#define NRDI_TAKE_SECOND(x) NRDI_SECOND(x 1, 0, 0)
#define NRDI_IS(value) NRDI_TAKE_SECOND(NRDI_DEFINED_##value)
#define NRDI_IS_DEFINED(name) NRDI_IS(name)
#define NRDI_X(name, text, settings) + NRDI_IS_DEFINED(NRD_ONLY_##name)
#if NRD_DENOISERS(NRDI_X)
#define NRDI_ONLY 1
#else
#define NRDI_ONLY 0
#endif
#undef NRDI_X
#define NRDI_WITH(name) ((!NRDI_ONLY || NRDI_IS_DEFINED(NRD_ONLY_##name)) && !NRDI_IS_DEFINED(NRD_NO_##name))

/* Images that the app owns. X(name, storage format or 0 for any sampled float format, text)
   IN_ images are only sampled. OUT_ images are written as storage images of exactly this format.
   Inputs are nrd_desc.width x height; pixels outside the rectangle, and noisy pixels of the sky, are never read and may hold anything; so are
   specular ones of surfaces above specular_roughness_limit (but the split screen shows them).
   Guides hold no NaN or Inf inside the rectangle. */
#define NRD_RESOURCES(X) \
    X(IN_MV, 0, "surface motion, see CONVENTIONS; RGBA16F") \
    X(IN_NORMAL_ROUGHNESS, 0, "world normal, linear roughness, material id as nrd_pack_normal_roughness packs them; A2B10G10R10") \
    X(IN_VIEWZ, 0, "linear view depth of the primary hit; R32F (R16F with view_z_scale)") \
    X(IN_DIFF_RADIANCE_HITDIST, 0, "nrd_pack_radiance_hit_dist(): demodulated noisy radiance and normalised hit distance; RGBA16F") \
    X(IN_SPEC_RADIANCE_HITDIST, 0, "the same for the specular lobe: its hit distance is normalised with the pixel's roughness; RGBA16F") \
    X(IN_DIFF_HITDIST, 0, "nrd_normalize_hit_dist(): normalised hit distance of one diffuse path; R16F or R8") \
    X(IN_DIFF_DIRECTION_HITDIST, 0, "xyz: world-space unit direction of one diffuse path times w; w: nrd_normalize_hit_dist(); RGBA16F or RGBA8 snorm") \
    X(IN_SPEC_HITDIST, 0, "nrd_normalize_hit_dist() of one specular path; R16F or R8") \
    X(IN_DIFF_CONFIDENCE, 0, "trust in history, [0,1], 0 restarts; read at the previous uv; any size, covers the rectangle; R8") \
    X(IN_SPEC_CONFIDENCE, 0, "the same for the specular signal, at the previous uv of what is reflected; R8") \
    X(IN_DISOCCLUSION_THRESHOLD_MIX, 0, "[0,1] from disocclusion_threshold to disocclusion_threshold_alternate; R8") \
    X(IN_PENUMBRA, 0, "nrd_pack_penumbra() or nrd_pack_local_penumbra(): half width of the penumbra that one ray to the light tells; R16F") \
    X(IN_TRANSLUCENCY, 0, "nrd_pack_translucency(): coloured visibility that the same ray tells; RGBA8") \
    X(IN_SIGNAL, 0, "anything to be averaged (REFERENCE)") \
    X(OUT_DIFF_RADIANCE_HITDIST, NRD_FORMAT_RGBA16_FLOAT, "nrd_unpack_radiance_hit_dist(): denoised radiance and hit distance. Also scratch within the frame") \
    X(OUT_SPEC_RADIANCE_HITDIST, NRD_FORMAT_RGBA16_FLOAT, "the same for the specular lobe") \
    X(OUT_DIFF_HITDIST, NRD_FORMAT_R16_FLOAT, "denoised occlusion: mean normalised hit distance, 0 closed to 1 open") \
    X(OUT_DIFF_DIRECTION_HITDIST, NRD_FORMAT_RGBA16_FLOAT, "xyz: mean unoccluded (bent) direction times openness, no longer than w; w: denoised occlusion") \
    X(OUT_SPEC_HITDIST, NRD_FORMAT_R16_FLOAT, "denoised specular occlusion") \
    X(OUT_SHADOW, NRD_FORMAT_R8_UNORM, "nrd_unpack_shadow(): denoised visibility of the light") \
    X(OUT_SHADOW_TRANSLUCENCY, NRD_FORMAT_RGBA8_UNORM, "nrd_unpack_shadow_translucency(): denoised coloured visibility of the light") \
    X(OUT_SIGNAL, NRD_FORMAT_RGBA32_FLOAT, "mean of IN_SIGNAL") \
    X(IN_DIFF_SH0, 0, "first texel of nrd_pack_sh(): as IN_DIFF_RADIANCE_HITDIST; RGBA16F") \
    X(IN_DIFF_SH1, 0, "second texel of nrd_pack_sh(): world-space unit direction of the diffuse path times luma; w is not read; RGBA16F") \
    X(IN_SPEC_SH0, 0, "the same for the specular lobe: as IN_SPEC_RADIANCE_HITDIST; RGBA16F") \
    X(IN_SPEC_SH1, 0, "the same for the specular lobe: direction of the specular path times luma; RGBA16F") \
    X(OUT_DIFF_SH0, NRD_FORMAT_RGBA16_FLOAT, "nrd_unpack_sh(): denoised radiance and hit distance, what OUT_DIFF_RADIANCE_HITDIST is. Also scratch within the frame") \
    X(OUT_DIFF_SH1, NRD_FORMAT_RGBA16_FLOAT, "xyz: mean of direction times luma; w: luma under the pixel's own normal over luma. Also scratch within the frame") \
    X(OUT_SPEC_SH0, NRD_FORMAT_RGBA16_FLOAT, "the same for the specular lobe") \
    X(OUT_SPEC_SH1, NRD_FORMAT_RGBA16_FLOAT, "the same for the specular lobe") \
    X(OUT_VALIDATION, NRD_FORMAT_RGBA8_UNORM, "4 x 4 small pictures of what a denoiser gets and remembers (NRD_FEATURE_VALIDATION, nrd_frame.validation)") \
    X(IN_SPEC_MV, 0, "motion of what is reflected, for objects that move in mirrors: see NRD_SPECULAR_MOTION_IMAGE and _HIT; RGBA16F")
typedef enum nrd_resource {
#define NRDI_X(name, format, text) NRD_RESOURCE_##name,
    NRD_RESOURCES(NRDI_X)
#undef NRDI_X
    NRD_RESOURCE_COUNT,
    NRD_RESOURCE_INTERNAL = NRD_RESOURCE_COUNT /* nrd_binding.texture says which of nrd_info.textures */
} nrd_resource;

/* X(name, bytes per texel, is unsigned integer) */
#define NRD_FORMATS(X) \
    X(ANY, 0, 0) X(R8_UNORM, 1, 0) X(RGBA8_UNORM, 4, 0) X(R16_UINT, 2, 1) X(R16_FLOAT, 2, 0) X(R32_FLOAT, 4, 0) X(R32_UINT, 4, 1) X(RG32_UINT, 8, 1) X(RGBA16_FLOAT, 8, 0) X(RGBA32_FLOAT, 16, 0)
typedef enum nrd_format {
#define NRDI_X(name, bytes, is_uint) NRD_FORMAT_##name,
    NRD_FORMATS(NRDI_X)
#undef NRDI_X
    NRD_FORMAT_COUNT
} nrd_format;

NRD_DECL const char *nrd_denoiser_name(nrd_denoiser denoiser);              /* "reblur_diffuse"; NULL when out of range */
NRD_DECL nrd_result nrd_find_denoiser(const char *name, nrd_denoiser *out); /* by that name */
NRD_DECL const char *nrd_resource_name(nrd_resource resource);              /* "IN_MV"; NULL when out of range */
NRD_DECL const char *nrd_resource_text(nrd_resource resource);              /* what it holds, one line */
NRD_DECL nrd_format nrd_resource_format(nrd_resource resource);             /* storage format of an OUT_ image, NRD_FORMAT_ANY for inputs */
NRD_DECL uint32_t nrd_format_bytes(nrd_format format);                      /* per texel */
NRD_DECL bool nrd_format_is_uint(nrd_format format);

/* ---------------------------------------------------------------------------------------------------------------------------
   Settings  >>settings */
/* X(type, name, default, min, max, unit, text): type is float or uint; 0/1 switches are uint. Values outside [min, max] and NaN are refused. */
#define NRD_FRAME_SETTINGS(X) \
    X(float, view_z_scale, 1.0f, 1e-6f, 1e6f, "", "view z = IN_VIEWZ * this") \
    X(float, denoising_range, 500000.0f, 1e-3f, 1e9f, "units", "pixels with abs(view z) at or above it are sky: not read, not written; surfaces nearer than 5e-10 of it keep no history") \
    X(float, disocclusion_threshold, 0.01f, 0.001f, 0.5f, "of the view's extent at that depth", "plane distance at which history is refused") \
    X(float, disocclusion_threshold_alternate, 0.05f, 0.001f, 0.5f, "of the view's extent at that depth", "the same where IN_DISOCCLUSION_THRESHOLD_MIX is 1") \
    X(float, split_screen, 0.0f, 0.0f, 1.0f, "of the width", "left part that shows the noisy input; 0 off (needs NRD_FEATURE_SPLIT_SCREEN)") \
    X(uint, motion_mode, NRD_MOTION_2_5D, 0, 2, "", "NRD_MOTION_2D, NRD_MOTION_2_5D or NRD_MOTION_WORLD") \
    X(float, motion_scale_x, 1.0f, -1e6f, 1e6f, "", "multiplies IN_MV.x; 1/width for motion in pixels") \
    X(float, motion_scale_y, 1.0f, -1e6f, 1e6f, "", "multiplies IN_MV.y") \
    X(float, motion_scale_z, 1.0f, -1e6f, 1e6f, "", "multiplies IN_MV.z") \
    X(uint, validation, 0, 0, 64, "", "n: OUT_VALIDATION shows the n-th of nrd_desc.denoisers; 0: none (needs NRD_FEATURE_VALIDATION)") \
    X(uint, restart, 0, 0, 1, "", "1: forget all history (camera cut): from this frame on the output is a new instance's to the bit, so that nothing needs clearing") \
    X(uint, history_confidence_available, 0, 0, 1, "", "1: IN_DIFF_CONFIDENCE and IN_SPEC_CONFIDENCE are bound, as far as the signals exist (needs NRD_FEATURE_HISTORY_CONFIDENCE)") \
    X(uint, disocclusion_threshold_mix_available, 0, 0, 1, "", "1: IN_DISOCCLUSION_THRESHOLD_MIX is bound (needs the feature)") \
    X(uint, specular_motion, NRD_SPECULAR_MOTION_NONE, 0, 2, "", "what IN_SPEC_MV holds, NRD_SPECULAR_MOTION_IMAGE or _HIT; 0: it is not bound; the REBLUR denoisers of specular radiance read it (needs NRD_FEATURE_SPECULAR_MOTION)") \
    X(uint, strand_material_id, 4, 0, 4, "", "material id of hair and grass: the thinner a strand against a pixel, the more disocclusion_threshold_alternate counts, and nearly all history where parallax is below a pixel; 4 none (needs NRD_FEATURE_MATERIALS)") \
    X(float, strand_thickness, 80e-6f, 1e-7f, 1e3f, "units", "of one strand of that material") \
    X(uint, camera_attached_reflection_material_id, 4, 0, 4, "", "material id of mirrors that show what moves with the camera: their reflections follow the surface; 4 none (needs NRD_FEATURE_MATERIALS)")

#define NRD_REFERENCE_SETTINGS(X) \
    X(uint, max_accumulated_frames, 4095, 0, 65535, "frames", "exact mean up to here, exponential beyond; restarts when the camera or the rectangle changes")

#define NRDI_CHECKERBOARD_SETTINGS(X) \
    X(uint, diffuse_checkerboard, 0, 0, 2, "", "the noisy diffuse input holds every other pixel, in the left half: 0 off, 1 black: those with nrd_checkerboard_color() 0, 2 white: 1 (needs NRD_FEATURE_CHECKERBOARD)") \
    X(uint, specular_checkerboard, 0, 0, 2, "", "the same for the specular input; 2 with diffuse_checkerboard 1: one path per pixel for both")

#define NRD_REBLUR_SETTINGS(X) \
    X(float, hit_distance_a, 3.0f, 1e-4f, 1e6f, "units", "hit distance that normalises to 1 at view z 0 (same value as in nrd_normalize_hit_dist); a to d matter to the pre-pass and the specular signal") \
    X(float, hit_distance_b, 0.1f, 0.0f, 1e3f, "", "its growth with view z") \
    X(float, hit_distance_c, 20.0f, 1.0f, 1e3f, "", "its factor at roughness 0") \
    X(float, hit_distance_d, -25.0f, -1e3f, 0.0f, "", "how fast that factor falls with roughness") \
    X(float, max_accumulated_frames, 32.0f, 0.0f, 63.0f, "frames", "length of the history; less reacts faster, more is less noisy") \
    X(float, max_stabilized_frames, 16.0f, 0.0f, 63.0f, "frames", "length of the stabilised luminance history; 0 off; more flickers less") \
    X(float, history_fix_frames, 2.5f, 0.0f, 16.0f, "frames", "histories shorter than this take neighbours with looser geometry") \
    X(float, feedback_frames, 2.0f, 0.0f, 64.0f, "frames", "filtered colour returns to history fully up to this length, then fades as feedback_frames / length") \
    X(float, max_blur_radius, 15.0f, 0.0f, 60.0f, "px", "reach of the spatial filter; 0 off; scaled with the rectangle") \
    X(float, diffuse_prepass_blur_radius, 0.0f, 0.0f, 75.0f, "px", "blur before accumulation, for probabilistic sampling; 0 off (needs NRD_FEATURE_PREPASS)") \
    X(float, specular_prepass_blur_radius, 0.0f, 0.0f, 75.0f, "px", "the same for the specular signal, at most as wide as what the lobe sees") \
    X(float, luminance_sigma_scale, 7.0f, 0.1f, 1000.0f, "standard deviations", "neighbours that differ more are not mixed; less is sharper and noisier") \
    X(float, plane_distance_sensitivity, 0.006f, 1e-4f, 1.0f, "of the view's extent at that depth", "neighbours farther off the surface's plane are not mixed") \
    X(float, normal_sensitivity, 8.0f, 0.0f, 1000.0f, "", "neighbours weigh exp(-this * (1 - cos of the angle between normals))") \
    X(float, antilag_sigma_scale, 3.5f, 0.5f, 100.0f, "standard deviations", "change of lighting that counts as certain; less reacts sooner and flickers more") \
    X(float, antilag_sensitivity, 1.0f, 0.0f, 1.0f, "", "how much of a certain change of lighting is applied to history; 0 off") \
    X(float, stabilization_sigma_scale, 1.6f, 0.1f, 100.0f, "standard deviations", "stabilised history farther from the filtered value is pulled in") \
    X(uint, min_material_for_diffuse, 4, 0, 4, "", "material ids above it are kept apart from each other and the rest; 4 mixes all") \
    X(uint, return_history_length_instead_of_occlusion, 0, 0, 1, "", "1: w of the outputs is the history length in frames") \
    X(uint, hit_distance_reconstruction, 0, 0, 2, "", "hit distances of lobes that were not sampled (0) are taken from neighbours: 0 off, 1: of 3x3, 2: of 5x5 pixels (needs NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION); ignored with a checkerboard") \
    X(uint, min_material_for_specular, 4, 0, 4, "", "as min_material_for_diffuse; without NRD_FEATURE_MATERIALS the smaller one counts for both signals of a denoiser") \
    NRDI_CHECKERBOARD_SETTINGS(X) \
    X(float, responsive_roughness, 0.0f, 0.0f, 1.0f, "", "specular history is shorter on surfaces smoother than this, the shorter the smoother: reacts faster, is noisier; 0 off") \
    X(float, responsive_min_frames, 4.0f, 0.0f, 63.0f, "frames", "what it is shortened to at least, at roughness 0") \
    X(uint, performance_mode, 0, 0, 2, "", "1: the last two filter steps take 4 neighbours instead of 8: 6 % less time, a little noisier; 2: two filter steps instead of four: 23 to 33 % less time, noisier") \
    X(float, anti_firefly_scale, 0.0f, 0.0f, 1000.0f, "times the second brightest of 3x3 pixels", "accumulated luma above this is cut to it (below 1 counts as 1): less leaves fewer bright dots and takes more light away; 0 off; needs max_blur_radius") \
    X(float, specular_roughness_limit, 0.0f, 0.0f, 1.0f, "", "surfaces rougher than this have no specular signal, as it is not traced there: the input is not read and the output not written, as in the sky; less takes less time; 0 off: all have one (needs NRD_FEATURE_ROUGHNESS_LIMIT)")

#define NRD_OCCLUSION_SETTINGS(X) \
    X(float, hit_distance_a, 3.0f, 1e-4f, 1e6f, "units", "hit distance that normalises to 1 at view z 0 (same value as in nrd_normalize_hit_dist)") \
    X(float, hit_distance_b, 0.1f, 0.0f, 1e3f, "", "its growth with view z") \
    X(float, hit_distance_c, 20.0f, 1.0f, 1e3f, "", "its factor at roughness 0 (specular)") \
    X(float, hit_distance_d, -25.0f, -1e3f, 0.0f, "", "how fast that factor falls with roughness") \
    X(float, max_accumulated_frames, 32.0f, 0.0f, 63.0f, "frames", "length of the history; less reacts faster, more is less noisy") \
    X(float, max_blur_radius, 6.0f, 0.0f, 60.0f, "px", "most that the spatial filter reaches; 0 off; scaled with the rectangle; more is smoother and flickers more") \
    X(float, plane_distance_sensitivity, 0.006f, 1e-4f, 1.0f, "of the view's extent at that depth", "neighbours farther off the surface's plane are not mixed") \
    X(float, normal_sensitivity, 8.0f, 0.0f, 1000.0f, "", "neighbours weigh exp(-this * (1 - cos of the angle between normals))") \
    X(float, antilag_sigma_scale, 2.0f, 0.5f, 100.0f, "standard deviations", "change of the signal that counts as certain; less reacts sooner and is noisier, 100 is off") \
    X(uint, min_material, 4, 0, 4, "", "material ids above it are kept apart from each other and the rest; 4 mixes all") \
    X(uint, return_history_length_instead_of_occlusion, 0, 0, 1, "", "1: the outputs are history lengths in frames") \
    NRDI_CHECKERBOARD_SETTINGS(X) \
    X(uint, performance_mode, 0, 0, 1, "", "1: the filter takes 4 neighbours instead of 6: less time, noisier")

#define NRD_SIGMA_SETTINGS(X) \
    X(float, light_x, 0.0f, -1e9f, 1e9f, "", "directional light: world-space vector from the surface to it, of any length; local light: its world position; x = y = z = 0: unknown (as for many lights in one signal)") \
    X(float, light_y, 0.0f, -1e9f, 1e9f, "", "likewise") \
    X(float, light_z, 0.0f, -1e9f, 1e9f, "", "likewise") \
    X(uint, light_is_local, 0, 0, 1, "", "1: light_x, y, z is a position") \
    X(float, light_radius, 0.0f, 0.0f, 1e6f, "", "directional light: tangent of its angular radius; local light: half its size, world units; the value that packed IN_PENUMBRA; 0: unknown") \
    X(float, max_accumulated_frames, 15.0f, 0.0f, 15.0f, "frames", "length of the history of penumbrae; 0: none; less reacts faster, more is less noisy") \
    X(float, max_stabilized_frames, 7.0f, 0.0f, 15.0f, "frames", "length of the stabilised output of penumbrae; 0 off; more flickers less") \
    X(float, penumbra_blur_scale, 0.6f, 0.0f, 4.0f, "of the penumbra's half width", "radius of the spatial filter before history shrinks it; 0 off; more is smoother and softer") \
    X(float, plane_distance_sensitivity, 0.01f, 1e-4f, 1.0f, "of the view's extent at that depth", "neighbours farther off the surface's plane are not mixed")

/* The camera of one frame. Matrices as in CONVENTIONS; all zero is refused. */
typedef struct nrd_camera {
    float view_to_clip[16];
    float world_to_view[16];
    float jitter[2]; /* px, [-0.5, 0.5] */
} nrd_camera;

typedef enum nrd_clip_y { NRD_CLIP_Y_AUTO, NRD_CLIP_Y_UP, NRD_CLIP_Y_DOWN } nrd_clip_y;

typedef uint32_t nrdi_uint;
#define NRDI_uint nrdi_uint
#define NRDI_float float
#define NRDI_MEMBER(type, name, value, min, max, unit, text) NRDI_##type name;
/* Everything that may change from frame to frame, for all denoisers. */
typedef struct nrd_frame {
    nrd_camera camera;
    const nrd_camera *camera_prev;     /* NULL: the camera of the previous nrd_set_frame */
    nrd_clip_y clip_y;
    uint32_t frame_index;              /* +1 every frame; the same index again replaces the frame */
    uint32_t rect_width, rect_height;  /* px, the part of the images in use; 0: all of it */
    uint32_t rect_origin_x, rect_origin_y; /* px, where the rectangle begins in IN_MV, IN_NORMAL_ROUGHNESS and IN_VIEWZ only */
    NRD_FRAME_SETTINGS(NRDI_MEMBER)
} nrd_frame;
typedef struct nrd_reference_settings { NRD_REFERENCE_SETTINGS(NRDI_MEMBER) } nrd_reference_settings;
typedef struct nrd_reblur_settings { NRD_REBLUR_SETTINGS(NRDI_MEMBER) } nrd_reblur_settings;
typedef struct nrd_occlusion_settings { NRD_OCCLUSION_SETTINGS(NRDI_MEMBER) } nrd_occlusion_settings;
typedef struct nrd_sigma_settings { NRD_SIGMA_SETTINGS(NRDI_MEMBER) } nrd_sigma_settings;

NRD_DECL nrd_frame nrd_frame_defaults(void);
NRD_DECL nrd_reference_settings nrd_reference_defaults(void);
NRD_DECL nrd_reblur_settings nrd_reblur_defaults(void);
NRD_DECL nrd_occlusion_settings nrd_occlusion_defaults(void);
NRD_DECL nrd_sigma_settings nrd_sigma_defaults(void);

/* The settings as data, for user interfaces and command lines. */
typedef struct nrd_setting {
    const char *name, *unit, *text;
    double value, min, max;  /* value: the default */
    bool is_float;
    size_t offset;           /* in the settings struct */
} nrd_setting;
/* The i-th setting of a denoiser, or of nrd_frame when denoiser is NRD_DENOISER_COUNT. False: no such setting. */
NRD_DECL bool nrd_get_setting(nrd_denoiser denoiser, uint32_t i, nrd_setting *out);
NRD_DECL size_t nrd_settings_size(nrd_denoiser denoiser);                              /* bytes of its settings struct */
NRD_DECL void nrd_settings_defaults(nrd_denoiser denoiser, void *settings);            /* fills it; NULL is fine */

/* ---------------------------------------------------------------------------------------------------------------------------
   Presets  >>presets
   Settings that lie on the measured front of error against time (`make report` measures it; the figures stand at nrdi_presets below). FASTEST:
   no spatial filter, for inputs of several paths. FAST: fewest filter steps. BALANCED: the defaults. Nothing measured is better for more time,
   so GOOD and BEST are BALANCED; SIGMA and REFERENCE, where nothing is faster either, have one set of settings for all. */
#define NRD_PRESETS(X) X(FASTEST, "fastest") X(FAST, "fast") X(BALANCED, "balanced") X(GOOD, "good") X(BEST, "best") /* BALANCED: the defaults */
typedef enum nrd_preset {
#define NRDI_X(name, text) NRD_PRESET_##name,
    NRD_PRESETS(NRDI_X)
#undef NRDI_X
    NRD_PRESET_COUNT
} nrd_preset;
NRD_DECL const char *nrd_preset_name(nrd_preset preset);                                         /* "fastest"; NULL when out of range */
NRD_DECL void nrd_settings_preset(nrd_denoiser denoiser, nrd_preset preset, void *settings);     /* fills the denoiser's settings struct */
NRD_DECL nrd_reblur_settings nrd_reblur_preset(nrd_preset preset);
NRD_DECL nrd_occlusion_settings nrd_occlusion_preset(nrd_preset preset);

/* Classes of devices: X(name, what was measured) */
#define NRD_DEVICES(X) X(DATACENTER, "NVIDIA H100 or H200") X(CPU, "lavapipe, two cores")
typedef enum nrd_device {
#define NRDI_X(name, text) NRD_DEVICE_##name,
    NRD_DEVICES(NRDI_X)
#undef NRDI_X
    NRD_DEVICE_COUNT
} nrd_device;

typedef struct nrd_suggestion {
    nrd_preset preset;
    float milliseconds; /* of device time that it takes, about */
    float error;        /* trimmed relMSE in motion at one path per pixel, geometric mean over scenes and signals */
} nrd_suggestion;
/* The preset of least measured error whose time fits the budget (milliseconds, above 0) for width x height pixels; the fastest one where
   none fits: compare out->milliseconds. For a device of another class scale the budget by how much faster or slower the default preset
   runs there. NRD_RESULT_UNKNOWN_DENOISER: not measured on this class. */
NRD_DECL nrd_result nrd_suggest(nrd_denoiser denoiser, nrd_device device, uint32_t width, uint32_t height, float budget_ms, nrd_suggestion *out);

/* ---------------------------------------------------------------------------------------------------------------------------
   Instance  >>instance */
typedef struct nrd nrd;

/* X(NRD_ABSENT_ name, name on command lines, what is promised). What does not concern a denoiser changes nothing of it. */
#define NRD_ABSENCES(X) \
    X(DIFFUSE, "diffuse", "denoisers of both signals get no diffuse one: they run as the denoiser of the other") \
    X(SPECULAR, "specular", "likewise no specular signal") \
    X(MOTION, "motion", "nothing moves, not even the jitter: IN_MV is not read; another camera or rectangle needs nrd_frame.restart") \
    X(SKY, "sky", "every pixel of the rectangle shows a surface") \
    X(MATERIALS, "materials", "material ids are not read: one class") \
    X(MIRRORS, "mirrors", "no specular surface has a roughness below 0.4: reflections are taken to move with the surface") \
    X(STABILIZATION, "stabilization", "max_stabilized_frames counts as 0") \
    X(LIGHTING_CHANGE, "lighting_change", "antilag_sensitivity counts as 0 (denoisers of radiance)") \
    X(BLUR, "blur", "max_blur_radius counts as 0")
/* The i-th absence, NRD_ABSENT_ bit 1 << i: its name and text. NULL beyond the last. */
NRD_DECL const char *nrd_absence_name(uint32_t i);
NRD_DECL const char *nrd_absence_text(uint32_t i);

typedef struct nrd_denoiser_desc {
    uint32_t identifier;   /* chosen by the app, unique in the instance */
    nrd_denoiser denoiser;
} nrd_denoiser_desc;

typedef struct nrd_desc {
    uint32_t struct_version;                /* NRD_STRUCT_VERSION; 0: not checked. This and the two below keep their places in every release */
    void (*message)(void *user, nrd_severity severity, nrd_result result, const char *text); /* NULL: silent */
    void *message_user;
    uint32_t width, height;                 /* px of the images, 1 to 16384 */
    const nrd_denoiser_desc *denoisers;
    uint32_t denoiser_count;                /* 1 to 64 */
    uint32_t features;                      /* NRD_FEATURE_ bits; 0: none of the optional things */
    uint32_t absent;                        /* NRD_ABSENT_ bits: what will never be needed; 0: everything may be */
    uint32_t normal_encoding;               /* NRD_NORMAL_FORMAT_ */
    uint32_t roughness_encoding;            /* NRD_ROUGHNESS_FORMAT_ */
    void *(*allocate)(void *user, size_t bytes); /* both or neither; NULL: NRD_MALLOC, NRD_FREE */
    void (*release)(void *user, void *memory);
    void *allocate_user;
} nrd_desc;

/* Differs where the release or the size of a public struct does: tells an implementation that was compiled elsewhere (a library, a plug-in)
   that the caller's header is another one. */
#define NRDI_MIX_SIZES(sum, a, b, c) ((((sum) * 5 + sizeof(a)) * 5 + sizeof(b)) * 5 + sizeof(c))
#define NRDI_GIVEN_SIZES NRDI_MIX_SIZES(NRDI_MIX_SIZES(0, nrd_desc, nrd_denoiser_desc, nrd_frame), nrd_reblur_settings, nrd_occlusion_settings, nrd_sigma_settings)
#define NRDI_TOLD_SIZES NRDI_MIX_SIZES(NRDI_MIX_SIZES(NRDI_MIX_SIZES(0, nrd_info, nrd_texture, nrd_pipeline), nrd_pass, nrd_dispatch, nrd_binding), nrd_explanation, nrd_finding, nrd_suggestion)
#define NRD_STRUCT_VERSION (NRD_RELEASE_NUMBER << 16 | (uint32_t)(NRDI_MIX_SIZES(NRDI_GIVEN_SIZES * 5 + NRDI_TOLD_SIZES, nrd_reference_settings, nrd_setting, nrd_block) & 0xffffu))

NRD_DECL nrd_result nrd_create(const nrd_desc *desc, nrd **out);
/* NULL is fine. Whoever uses the instance after it gets NRD_RESULT_DESTROYED, for as long as its memory is not in other use. */
NRD_DECL void nrd_destroy(nrd *instance);
NRD_DECL nrd_result nrd_set_frame(nrd *instance, const nrd_frame *frame);
/* settings: the struct that NRD_DENOISERS names for this denoiser. Kept until changed. */
NRD_DECL nrd_result nrd_set_settings(nrd *instance, uint32_t identifier, const void *settings);
/* Other image sizes, 1 to 16384 px. Settings and history are kept; textures of nrd_info change size, the order of everything stays.
   Whoever owns the textures makes new ones, filled with zeros, and keeps those that were written last until the first dispatches after
   this have been executed: bindings with before_resize read from them. nrd_set_frame must be called before the next dispatches.
   REFERENCE starts anew. */
NRD_DECL nrd_result nrd_resize(nrd *instance, uint32_t width, uint32_t height);
/* Sends text to the instance's message callback (used by runtimes built on top). Returns result. */
NRD_DECL nrd_result nrd_report(const nrd *instance, nrd_severity severity, nrd_result result, const char *text);

/* ---------------------------------------------------------------------------------------------------------------------------
   What to create, known before anything is allocated  >>info */
typedef struct nrd_texture {
    const char *name;
    uint32_t denoiser;             /* index into nrd_desc.denoisers */
    nrd_format format;
    uint32_t width, height;        /* one mip, one layer; sampled and storage use */
    bool permanent;                /* contents survive the frame; zeros at first. Transient: undefined until written in a frame */
    uint32_t first_pass, last_pass; /* transient: in use from .. to, in the order of nrd_info.passes */
    uint64_t bytes, offset;        /* tightly packed; offset into the transient block when placed like that */
    bool read_back;                /* counters of the checker: the first such binding of a dispatch is for the CPU to read afterwards */
    bool buffer;                   /* no image: `bytes` bytes of a storage buffer, which nrd_dispatch.indirect names */
} nrd_texture;

/* LINEAR: with the linear-clamp sampler, else nearest-clamp. BUFFER: of nrd_texture.buffer, read and written. UNIFORM: that, as a uniform buffer. */
typedef enum nrd_access { NRD_ACCESS_READ, NRD_ACCESS_READ_LINEAR, NRD_ACCESS_WRITE, NRD_ACCESS_BUFFER, NRD_ACCESS_UNIFORM } nrd_access;

/* The uniform buffer of every pass, in C. */
#define NRDI_C_mat4(name) float name[16];
#define NRDI_C_vec4(name) float name[4];
#define NRDI_C_uint(name) uint32_t name;
#define NRDI_C_float(name) float name;
#define NRDI_X(type, name) NRDI_C_##type(name)
typedef struct nrd_constants { NRD_CONSTANTS(NRDI_X) } nrd_constants;
#undef NRDI_X

/* One compute pipeline: descriptor set 0 has the uniform buffer at binding 0, then binding i + 1 is bindings[i] of its dispatches:
   a combined image sampler for reads, a storage image for writes, a storage buffer; 8 bytes of push constants; NRD_SPEC_CONSTANTS. */
typedef struct nrd_pipeline {
    const char *shader;            /* module name, as in nrd_spirv.h */
    uint32_t binding_count;
    const nrd_access *access;      /* per binding */
    uint32_t spec_constants[5];    /* by id */
} nrd_pipeline;

typedef struct nrd_pass {
    const char *name;
    uint32_t denoiser, pipeline;
} nrd_pass;

typedef struct nrd_left_out { const char *what, *why; uint64_t bytes_saved; } nrd_left_out;

typedef struct nrd_info {
    uint32_t width, height;
    const nrd_texture *textures; uint32_t texture_count;
    const nrd_pipeline *pipelines; uint32_t pipeline_count;
    const nrd_pass *passes; uint32_t pass_count;            /* the most dispatches a frame can have, in order */
    const nrd_left_out *left_out; uint32_t left_out_count;
    const nrd_denoiser_desc *denoisers; uint32_t denoiser_count;
    uint64_t permanent_bytes, transient_bytes;              /* transient: after sharing memory between disjoint lifetimes */
    uint64_t transient_unshared_bytes;
    uint32_t constant_bytes, max_bindings;
} nrd_info;
NRD_DECL const nrd_info *nrd_get_info(const nrd *instance);
/* Does this instance use the resource? storage: as an output. */
NRD_DECL bool nrd_uses_resource(const nrd *instance, nrd_resource resource);

/* What is kept and what is left out under what is declared and set now (nrd_set_settings, nrd_set_frame), and why.  >>explain */
typedef struct nrd_explanation {
    const char *kind;      /* "signal", "pass", "texture" or "input" */
    const char *name;
    uint32_t denoiser;     /* index into nrd_desc.denoisers */
    bool kept;
    const char *why;       /* of what is left out: the declaration, or the setting of this frame; else NULL */
    uint64_t bytes;        /* device memory that it takes, or that is saved; 0: none */
    float microseconds;    /* device time that it takes, or that is saved, about, on NRD_DEVICE_DATACENTER; 0: none, or not measured */
} nrd_explanation;
/* The i-th item, denoiser by denoiser. False: there are no more. */
NRD_DECL bool nrd_explain_item(const nrd *instance, uint32_t i, nrd_explanation *out);

typedef enum nrd_explain_format { NRD_EXPLAIN_TEXT, NRD_EXPLAIN_JSON, NRD_EXPLAIN_GRAPHVIZ } nrd_explain_format;
/* All of it as text of at most size - 1 bytes and a 0; returns the bytes that the whole text has (0: an argument is missing). size may be 0. */
NRD_DECL size_t nrd_explain(const nrd *instance, nrd_explain_format format, char *text, size_t size);

/* Places blocks that are in use from first to last (inclusive) so that blocks with a common time do not overlap. Returns the total. */
typedef struct nrd_block { uint64_t bytes, alignment; uint32_t first, last; uint64_t offset; } nrd_block;
NRD_DECL uint64_t nrd_place_blocks(nrd_block *blocks, uint32_t count);

/* ---------------------------------------------------------------------------------------------------------------------------
   What to run  >>dispatches */
typedef struct nrd_binding {
    nrd_resource resource;   /* NRD_RESOURCE_INTERNAL: */
    uint32_t texture;        /* index into nrd_info.textures */
    nrd_access access;
    bool half_width;         /* checkerboarded: only the columns up to half the width, rounded up, are read; the image may end there */
    bool before_resize;      /* that texture as it was before nrd_resize; only read */
} nrd_binding;

typedef struct nrd_dispatch {
    const char *name;
    uint32_t pass;                  /* index into nrd_info.passes */
    uint32_t pipeline;              /* index into nrd_info.pipelines */
    const nrd_binding *bindings;    /* what is both read and written here is read by the thread alone that writes it */
    uint32_t binding_count;
    const void *constants;          /* nrd_info.constant_bytes bytes; equal pointers mean equal contents within one call */
    int32_t push[2];                /* NRD_PUSH_CONSTANTS */
    uint32_t groups_x, groups_y;
    uint32_t indirect;              /* 0: none; 1 + index into nrd_info.textures of a buffer: there the dispatches before leave, as three uint32_t,
                                       how many groups are enough in x, y and z. groups_x, groups_y do the same, only slower */
    uint32_t indirect_offset;       /* bytes, of the first of the three in that buffer */
} nrd_dispatch;
/* The dispatches of the given denoisers (NULL and 0: all), to be executed in this order, each after the writes of those before it.
   Call once a frame for each denoiser: it advances their history. Valid until the next call. */
NRD_DECL nrd_result nrd_get_dispatches(nrd *instance, const uint32_t *identifiers, uint32_t identifier_count, const nrd_dispatch **dispatches, uint32_t *count);
/* Those of the last nrd_get_dispatches will not be executed: history is as before that call. Nothing else may be called in between. */
NRD_DECL void nrd_cancel_dispatches(nrd *instance);

/* ---------------------------------------------------------------------------------------------------------------------------
   What is wrong with the inputs  >>check
   With NRD_FEATURE_CHECK the last pass of every denoiser but REFERENCE counts pixels that break rules, in a texture that is read back
   (nrd_texture.read_back; nrd_vk_counters does it). Add the counters of as many frames as you like and ask for the rules one by one.
   Matrices that are no camera are refused by nrd_set_frame already. X(rule = its counter, counter of the pixels it can be asked of,
   share of them that may break it, what is wrong) */
#define NRD_RULES(X) \
    X(MATRIX_JITTER, FRAMES, 0.5f, "view_to_clip's principal point moves by less than a pixel from frame to frame: give view_to_clip without jitter, and the jitter in camera.jitter") \
    X(FRAME_INDEX, FRAMES, 0.0f, "frame_index did not advance by 1: history restarted") \
    X(VIEWZ_NOT_FINITE, PIXELS, 0.0f, "IN_VIEWZ holds NaN or infinity; sky is any finite number at or beyond denoising_range") \
    X(VIEWZ_ZERO, PIXELS, 0.0f, "IN_VIEWZ is 0: not written, or sky, which must be at or beyond denoising_range") \
    X(VIEWZ_NEGATIVE, SURFACES, 0.0f, "IN_VIEWZ has both signs: surfaces behind the camera, or a distance mixed with a depth") \
    X(SKY_IN_RANGE, PIXELS, 0.01f, "view z of the sky is inside denoising_range: constant over an area whose normals or signals are no surface's") \
    X(NORMAL_NOT_FINITE, SURFACES, 0.0f, "IN_NORMAL_ROUGHNESS holds NaN or infinity") \
    X(NORMAL_LENGTH, SURFACES, 0.001f, "normals are not of unit length, or not packed by nrd_pack_normal_roughness") \
    X(NORMAL_AWAY, SURFACES, 0.25f, "normals face away from the camera") \
    X(NORMAL_PLANE, PLANES, 0.25f, "normals are more than 30 degrees off the planes that IN_VIEWZ shows") \
    X(MOTION_NOT_FINITE, SURFACES, 0.0f, "IN_MV holds NaN or infinity") \
    X(MOTION_CAMERA, MOVED, 0.5f, "motion contradicts the camera's") \
    X(MOTION_STILL, STILL, 0.5f, "motion is more than a pixel where camera and depth say there is none") \
    X(MOTION_DEPTH, DEPTH_MOVED, 0.5f, "z of the motion contradicts the camera's") \
    X(MOTION_JITTER, JITTERED, 0.3f, "motion contains the jitter: compute it with matrices that are not jittered") \
    X(DIFF_NOT_FINITE, SURFACES, 0.0f, "the diffuse signal holds NaN or infinity") \
    X(DIFF_NEGATIVE, SURFACES, 0.0f, "diffuse radiance is negative after unpacking: store it with nrd_pack_radiance_hit_dist") \
    X(DIFF_HIT_NEGATIVE, SURFACES, 0.0f, "diffuse hit distances are negative") \
    X(DIFF_HIT_RANGE, SURFACES, 0.0f, "diffuse hit distances are above 1: store nrd_normalize_hit_dist() of them") \
    X(DIFF_HIT_MISSING, DIFF_BRIGHT, 0.9f, "diffuse hit distances are 0 (not sampled) where there is radiance") \
    X(DIFF_HIT_PRIMARY, DIFF_HITS, 0.98f, "diffuse hit distances include the camera's ray: measure from the primary hit") \
    X(SPEC_NOT_FINITE, SURFACES, 0.0f, "the specular signal holds NaN or infinity") \
    X(SPEC_NEGATIVE, SURFACES, 0.0f, "specular radiance is negative after unpacking: store it with nrd_pack_radiance_hit_dist") \
    X(SPEC_HIT_NEGATIVE, SURFACES, 0.0f, "specular hit distances are negative") \
    X(SPEC_HIT_RANGE, SURFACES, 0.0f, "specular hit distances are above 1: store nrd_normalize_hit_dist() of them") \
    X(SPEC_HIT_MISSING, SPEC_BRIGHT, 0.9f, "specular hit distances are 0 (not sampled) where there is radiance") \
    X(SPEC_HIT_PRIMARY, SPEC_HITS, 0.98f, "specular hit distances include the camera's ray: measure from the primary hit") \
    X(DIRECTION_LENGTH, DIRECTIONS, 0.0f, "xyz of IN_DIFF_DIRECTION_HITDIST is longer than w: store the unit direction times w") \
    X(DIRECTION_BELOW, DIRECTIONS, 0.25f, "directions point into the surface: world space, from the surface along the ray") \
    X(PENUMBRA_INVALID, SURFACES, 0.0f, "IN_PENUMBRA holds NaN or negative numbers") \
    X(PENUMBRA_CODE, SURFACES, 0.0f, "IN_PENUMBRA is above 32768 but not 65504: store a ray that reached the light as 65504 (nrd_pack_penumbra)") \
    X(PENUMBRA_ZERO, FACING_LIGHT, 0.2f, "IN_PENUMBRA is 0 (faces away) on surfaces that face the light") \
    X(PENUMBRA_AWAY, AWAY_FROM_LIGHT, 0.1f, "IN_PENUMBRA says that the light was reached on surfaces that face away from it: store 0") \
    X(PENUMBRA_MISS, LIT_OR_FAR, 0.5f, "no occluder seems to be stored as a long ray instead of 65504 (nrd_pack_penumbra)") \
    X(PENUMBRA_FROM_LIGHT, OCCLUDERS, 0.99f, "occluder distances seem to be measured from the light: measure from the surface") \
    X(PENUMBRA_FIRST_HIT, BLOCKED_TRIPLES, 0.15f, "occluder distances jump from pixel to pixel: rays must find the nearest hit, not the first that is found") \
    X(TRANSLUCENCY_LIT, LIT, 0.01f, "IN_TRANSLUCENCY is not white where the light was reached")
typedef enum nrd_counter {
#define NRDI_X(name, index) NRD_COUNTER_##name = index,
    NRD_COUNTERS(NRDI_X)
#undef NRDI_X
    NRD_COUNTER_LAST = NRD_COUNTER_COUNT - 1
} nrd_counter;

typedef struct nrd_finding {
    const char *name;       /* of the rule, "MOTION_CAMERA" */
    const char *text;       /* what is wrong where it is broken */
    const char *cause;      /* the likely cause and what to do, "" where none is known */
    uint64_t count, of;     /* pixels (or frames) that break it, of those it can be asked of */
    double share, allowed;  /* count / of, 0 where of is 0; share that may break it */
    bool judged;            /* there was something to ask it of */
    bool broken;
} nrd_finding;
/* The i-th rule, judged on counters (NRD_COUNTER_COUNT of them). False: there is no such rule. */
NRD_DECL bool nrd_check_rule(const uint64_t *counters, uint32_t i, nrd_finding *out);

#ifdef __cplusplus
}
#endif
#endif /* NRD_H */

/* ===========================================================================================================================
   IMPLEMENTATION
   ======================================================================================================================== */
#ifdef NRD_IMPLEMENTATION
#ifndef NRD_IMPLEMENTED
#define NRD_IMPLEMENTED

#include <math.h>
#include <string.h>

#if defined(NRD_MALLOC) != defined(NRD_FREE)
#error "define both NRD_MALLOC and NRD_FREE, or neither"
#endif
#ifndef NRD_MALLOC
#include <stdlib.h>
#define NRD_MALLOC(bytes) malloc(bytes)
#define NRD_FREE(memory) free(memory)
#endif
#ifndef NRD_ASSERT
#include <assert.h>
#define NRD_ASSERT(condition) assert(condition)
#endif

/* ---------------------------------------------------------------------------------------------------------------------------
   Pass tables  >>tables
   A denoiser is a row with its textures and passes; everything below interprets these rows. */
enum { NRDI_MAX_USES = 36, NRDI_MAX_TEXTURES = 21, NRDI_MAX_PASSES = 20, NRDI_TILE_PX = 8 };
enum { NRDI_TRANSIENT, NRDI_PERMANENT, NRDI_PING_PONG, NRDI_BUFFERS }; /* BUFFERS: a pair, for numbers of groups */
enum { NRDI_MAX_SIZE = 16384 };   /* px, of either side */
enum { NRDI_GROUP_WORDS = 8, NRDI_ALL_TILES = 16 };    /* numbers of groups in x, y, z, tiles in the list; from this byte on, those of a pass with a thread
                                                          for every tile, none if nothing is in the list: common/list.glsl */

/* Why a pass runs, or a binding is not replaced by its stand-in; evaluated every frame. */
enum { NRDI_ALWAYS = 0, NRDI_IF_PREPASS = 1, NRDI_IF_BLUR = 2, NRDI_IF_ANTILAG = 4, NRDI_IF_SPLIT = 8, NRDI_IF_CONFIDENCE = 16, NRDI_IF_THRESHOLD_MIX = 32,
       NRDI_IF_SPEC_PREPASS = 64, NRDI_IF_RECONSTRUCTION = 128, NRDI_IF_SPECULAR_MOTION = 256, NRDI_IF_SKY = 512, NRDI_IF_ROUGHNESS_LIMIT = 1024, NRDI_IF_MOTION = 4096, NRDI_IF_STABILIZED = 8192, NRDI_IF_VALIDATION = 16384, NRDI_IF_CHECK = 32768 };

/* What a pass is bound to: a nrd_resource, or a texture of the denoiser: of this frame, or the previous frame's half of a ping-pong pair. */
#define NRDI_TEXTURE(i) (64 + (i))
#define NRDI_PREVIOUS(i) (96 + (i))

typedef struct nrdi_texture_row { const char *name; nrd_format format; uint8_t divisor, kind; } nrdi_texture_row; /* divisor 0: one texel per counter */
/* Condition off: stand_in is bound instead. */
typedef struct nrdi_use { uint8_t what, access; uint16_t condition; uint8_t stand_in; } nrdi_use;
typedef struct nrdi_pass_row {
    const char *name, *shader;
    uint16_t condition, feature; /* NRD_FEATURE_ bit without which the pass does not exist */
    uint8_t span;                /* pixels of a thread, in x and in y; 0: one */
    uint8_t iteration;           /* of the spatial filter; its step doubles with each */
    nrdi_use uses[NRDI_MAX_USES]; /* up to the first with what == 0 && access == NRDI_END */
} nrdi_pass_row;
typedef enum nrdi_family { NRDI_FAMILY_REFERENCE, NRDI_FAMILY_REBLUR, NRDI_FAMILY_OCCLUSION, NRDI_FAMILY_SIGMA } nrdi_family; /* which settings, and how they become constants */
typedef struct nrdi_denoiser_row {
    nrdi_family family;
    nrdi_texture_row textures[NRDI_MAX_TEXTURES];
    nrdi_pass_row passes[NRDI_MAX_PASSES];
} nrdi_denoiser_row;

#define NRDI_END 255
#define NRDI_IN(r) { (uint8_t)NRD_RESOURCE_##r, NRD_ACCESS_READ, 0, 0 }
#define NRDI_IN_IF(r, condition, other) { (uint8_t)NRD_RESOURCE_##r, NRD_ACCESS_READ, condition, (uint8_t)NRD_RESOURCE_##other }
#define NRDI_LINEAR_IF(r, condition, other) { (uint8_t)NRD_RESOURCE_##r, NRD_ACCESS_READ_LINEAR, condition, (uint8_t)NRD_RESOURCE_##other }
#define NRDI_OUT(r) { (uint8_t)NRD_RESOURCE_##r, NRD_ACCESS_WRITE, 0, 0 }
#define NRDI_READ(t) { NRDI_TEXTURE(t), NRD_ACCESS_READ, 0, 0 }
#define NRDI_WRITE(t) { NRDI_TEXTURE(t), NRD_ACCESS_WRITE, 0, 0 }
#define NRDI_READ_PREV(t) { NRDI_PREVIOUS(t), NRD_ACCESS_READ, 0, 0 }
#define NRDI_READ_IF(t, condition, other) { NRDI_TEXTURE(t), NRD_ACCESS_READ, condition, (uint8_t)NRD_RESOURCE_##other }
/* OWN: without the condition the texture itself is bound, but not looked at. */
#define NRDI_OWN_READ_IF(t, condition) { NRDI_TEXTURE(t), NRD_ACCESS_READ, condition, NRDI_TEXTURE(t) }
#define NRDI_OWN_LINEAR_IF(t, condition) { NRDI_TEXTURE(t), NRD_ACCESS_READ_LINEAR, condition, NRDI_TEXTURE(t) }
#define NRDI_OWN_WRITE_IF(t, condition) { NRDI_TEXTURE(t), NRD_ACCESS_WRITE, condition, NRDI_TEXTURE(t) }
#define NRDI_MOTION NRDI_IN_IF(IN_MV, NRDI_IF_MOTION, IN_VIEWZ)
#define NRDI_WRITE_PREV(t) { NRDI_PREVIOUS(t), NRD_ACCESS_WRITE, 0, 0 }
#define NRDI_STOP { 0, NRDI_END, 0, 0 }

enum { NRDI_REFERENCE_HISTORY };
enum { NRDI_GUIDE, NRDI_TRACK, NRDI_SPEC_TRACK, NRDI_DIFF_HISTORY, NRDI_DIFF_STABILIZED, NRDI_DIFF_TILE, NRDI_DIFF_TILE_RAW,
       NRDI_SPEC_HISTORY, NRDI_SPEC_STABILIZED, NRDI_SPEC_TILE, NRDI_SPEC_TILE_RAW, NRDI_DIFF_SH_HISTORY, NRDI_SPEC_SH_HISTORY, NRDI_DIFF_SH, NRDI_SH, NRDI_DIFF_HITDIST, NRDI_SPEC_HITDIST };
enum { NRDI_SHADOW_HISTORY, NRDI_SHADOW_TILE, NRDI_SHADOW_MEAN, NRDI_SHADOW_EXTRA, NRDI_SHADOW_KINDS }; /* EXTRA: opaque: stabilised visibility; translucent: green and blue of the history */

/* Rows that denoisers have in common: the counters of the checker; which tiles have something to do, see common/tiles.comp, sigma/tiles.comp. */
enum { NRDI_COUNTERS = NRDI_MAX_TEXTURES - 1, NRDI_TILE_GROUPS = NRDI_COUNTERS - 1, NRDI_TILE_LIST = NRDI_COUNTERS - 2, NRDI_TILE_AGE = NRDI_COUNTERS - 3 };
static const nrdi_texture_row nrdi_common_rows[] = {
    { "TILE_AGE", NRD_FORMAT_R8_UNORM, NRDI_TILE_PX, NRDI_PERMANENT },
    { "TILE_LIST", NRD_FORMAT_R32_UINT, NRDI_TILE_PX, NRDI_TRANSIENT },
    { "TILE_GROUPS", NRD_FORMAT_R32_UINT, 0, NRDI_BUFFERS },
    { "COUNTERS", NRD_FORMAT_R32_UINT, 0, NRDI_PING_PONG }
};
/* A pass that binds them runs on the listed tiles alone. */
#define NRDI_TILES NRDI_OWN_READ_IF(NRDI_TILE_LIST, NRDI_IF_SKY), { NRDI_TEXTURE(NRDI_TILE_GROUPS), NRD_ACCESS_UNIFORM, NRDI_IF_SKY, NRDI_TEXTURE(NRDI_TILE_GROUPS) }
#define NRDI_LIST_TILES NRDI_WRITE(NRDI_TILE_LIST), { NRDI_TEXTURE(NRDI_TILE_GROUPS), NRD_ACCESS_BUFFER, 0, 0 }, { NRDI_PREVIOUS(NRDI_TILE_GROUPS), NRD_ACCESS_BUFFER, 0, 0 }
#define NRDI_FIND_TILES \
    { "tiles", "tiles", NRDI_IF_SKY, 0, NRDI_TILE_PX, 0, { NRDI_IN(IN_VIEWZ), NRDI_WRITE(NRDI_TILE_AGE), NRDI_LIST_TILES, NRDI_STOP } }
/* Of denoisers of the specular signal alone: surfaces without one are left out, too. */
#define NRDI_FIND_GLOSSY_TILES \
    { "tiles", "glossy_tiles", NRDI_IF_SKY, 0, NRDI_TILE_PX, 0, \
      { NRDI_IN(IN_VIEWZ), NRDI_WRITE(NRDI_TILE_AGE), NRDI_LIST_TILES, NRDI_IN_IF(IN_NORMAL_ROUGHNESS, NRDI_IF_ROUGHNESS_LIMIT, IN_VIEWZ), NRDI_STOP } }

enum { NRDI_TAP, NRDI_STATE };
#define NRDI_LOBE_DIFF 0
#define NRDI_LOBE_SPEC 1   /* as a pass's iteration, where one shader serves both */
#define NRDI_OCCLUSION_SPLIT(lobe) { "split screen", "reblur_occlusion_split_screen", NRDI_IF_SPLIT, NRD_FEATURE_SPLIT_SCREEN, 0, NRDI_LOBE_##lobe, \
      { NRDI_IN(IN_VIEWZ), NRDI_IN(IN_##lobe##_HITDIST), NRDI_OUT(OUT_##lobe##_HITDIST), NRDI_STOP } }
#define NRDI_LINEAR_CONFIDENCE(lobe) NRDI_LINEAR_IF(IN_##lobe##_CONFIDENCE, NRDI_IF_CONFIDENCE, IN_##lobe##_HITDIST)

/* The textures of the REBLUR denoisers; those that a denoiser's passes do not use do not exist.
   Once temporal accumulation has run, the previous halves of GUIDE and TRACK are dead until the next frame overwrites them, so each holds
   one intermediate of the spatial filter; OUT holds the other. Filter steps that go the same way between the two are one module: post-blur 2
   binds what blur does, post-blur 1 what stabilization does, and neither touches what is not its own; with SH these are the plain denoisers',
   as the light stays where blur has left it until stabilization takes it out. */
#define NRDI_REBLUR_TEXTURES \
    { "GUIDE", NRD_FORMAT_RG32_UINT, 1, NRDI_PING_PONG }, \
    { "TRACK", NRD_FORMAT_RG32_UINT, 1, NRDI_PING_PONG }, \
    { "SPEC_TRACK", NRD_FORMAT_R32_UINT, 1, NRDI_PING_PONG }, \
    { "DIFF_HISTORY", NRD_FORMAT_RGBA16_FLOAT, 1, NRDI_PERMANENT }, \
    { "DIFF_STABILIZED", NRD_FORMAT_R16_FLOAT, 1, NRDI_PERMANENT }, \
    { "DIFF_TILE", NRD_FORMAT_RGBA16_FLOAT, NRDI_TILE_PX, NRDI_PERMANENT }, \
    { "DIFF_TILE_RAW", NRD_FORMAT_R32_UINT, NRDI_TILE_PX, NRDI_PERMANENT }, \
    { "SPEC_HISTORY", NRD_FORMAT_RGBA16_FLOAT, 1, NRDI_PERMANENT }, \
    { "SPEC_STABILIZED", NRD_FORMAT_R16_FLOAT, 1, NRDI_PERMANENT }, \
    { "SPEC_TILE", NRD_FORMAT_RGBA16_FLOAT, NRDI_TILE_PX, NRDI_PERMANENT }, \
    { "SPEC_TILE_RAW", NRD_FORMAT_R32_UINT, NRDI_TILE_PX, NRDI_PERMANENT }, \
    { "DIFF_SH_HISTORY", NRD_FORMAT_RGBA16_FLOAT, 1, NRDI_PERMANENT }, \
    { "SPEC_SH_HISTORY", NRD_FORMAT_RGBA16_FLOAT, 1, NRDI_PERMANENT }, \
    { "DIFF_SH", NRD_FORMAT_R32_UINT, 1, NRDI_TRANSIENT }, \
    { "SH", NRD_FORMAT_RG32_UINT, 1, NRDI_TRANSIENT }, \
    { "DIFF_HITDIST", NRD_FORMAT_R16_FLOAT, 1, NRDI_TRANSIENT }, \
    { "SPEC_HITDIST", NRD_FORMAT_R16_FLOAT, 1, NRDI_TRANSIENT }

/* What the passes bind, in the order of their shaders: the guides, then what belongs to each signal. S: DIFF or SPEC.
   `scratch`: the intermediate. */
#define NRDI_ACCUMULATION_GUIDES \
    NRDI_MOTION, NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN_IF(IN_DISOCCLUSION_THRESHOLD_MIX, NRDI_IF_THRESHOLD_MIX, IN_VIEWZ), \
    NRDI_READ_PREV(NRDI_GUIDE), NRDI_WRITE(NRDI_GUIDE)
#define NRDI_ACCUMULATION_SIGNAL(S, prepass) NRDI_ACCUMULATION_OF(S, S##_RADIANCE_HITDIST, prepass)
#define NRDI_ACCUMULATION_OF(S, image, prepass) \
    NRDI_IN_IF(OUT_##image, prepass, IN_##image), \
    NRDI_LINEAR_IF(IN_##S##_CONFIDENCE, NRDI_IF_CONFIDENCE, IN_##image), NRDI_READ(NRDI_##S##_HISTORY), \
    NRDI_OWN_READ_IF(NRDI_##S##_STABILIZED, NRDI_IF_STABILIZED), NRDI_OWN_LINEAR_IF(NRDI_##S##_TILE, NRDI_IF_ANTILAG), NRDI_OUT(OUT_##image), \
    NRDI_OWN_WRITE_IF(NRDI_##S##_TILE_RAW, NRDI_IF_ANTILAG)
#define NRDI_BLUR_SIGNAL(S, scratch) NRDI_BLUR_OF(S, S##_RADIANCE_HITDIST, scratch)
#define NRDI_BLUR_OF(S, image, scratch) \
    NRDI_IN(OUT_##image), NRDI_OWN_LINEAR_IF(NRDI_##S##_TILE, NRDI_IF_ANTILAG), NRDI_WRITE(NRDI_##S##_HISTORY), NRDI_WRITE_PREV(scratch)
#define NRDI_STABILIZATION_SIGNAL(S, scratch) NRDI_STABILIZATION_OF(S, S##_RADIANCE_HITDIST, scratch)
#define NRDI_STABILIZATION_OF(S, image, scratch) \
    NRDI_READ_PREV(scratch), NRDI_OWN_LINEAR_IF(NRDI_##S##_TILE, NRDI_IF_ANTILAG), NRDI_OWN_WRITE_IF(NRDI_##S##_STABILIZED, NRDI_IF_STABILIZED), \
    NRDI_OUT(OUT_##image)

/* Light with a direction: the first texel goes the way of radiance; these follow the bindings above. OUT_..._SH1 and a packed
   texture take turns. */
#define NRDI_ACCUMULATION_SH(S, prepass) NRDI_IN_IF(OUT_##S##_SH1, prepass, IN_##S##_SH1), NRDI_READ(NRDI_##S##_SH_HISTORY), NRDI_OUT(OUT_##S##_SH1)

#define NRDI_HITDIST(S) NRDI_HITDIST_OF(S, S##_RADIANCE_HITDIST)
#define NRDI_HITDIST_OF(S, image) NRDI_READ_IF(NRDI_##S##_HITDIST, NRDI_IF_RECONSTRUCTION, IN_##image)
#define NRDI_SPECULAR_EXTRAS NRDI_SPECULAR_EXTRAS_OF(SPEC_RADIANCE_HITDIST)
#define NRDI_SPECULAR_EXTRAS_OF(image) NRDI_IN(IN_##image), NRDI_HITDIST_OF(SPEC, image), NRDI_IN_IF(IN_SPEC_MV, NRDI_IF_SPECULAR_MOTION, IN_VIEWZ)
#define NRDI_RECONSTRUCTION(S, text) NRDI_RECONSTRUCTION_OF(S, S##_RADIANCE_HITDIST, text)
#define NRDI_RECONSTRUCTION_OF(S, image, text) \
    { "hit distance reconstruction" text, "reblur_hit_distance_reconstruction", NRDI_IF_RECONSTRUCTION, NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION, 0, NRDI_LOBE_##S, \
      { NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(IN_##image), NRDI_WRITE(NRDI_##S##_HITDIST), NRDI_TILES, NRDI_STOP } }
#define NRDI_PREPASS(S, shader, text, prepass) \
    { "pre-pass" text, shader, prepass, NRD_FEATURE_PREPASS, 0, 0, \
      { NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(IN_##S##_RADIANCE_HITDIST), NRDI_OUT(OUT_##S##_RADIANCE_HITDIST), NRDI_HITDIST(S), NRDI_TILES, NRDI_STOP } }
#define NRDI_PREPASS_SH(S, shader, text, prepass) \
    { "pre-pass" text, shader, prepass, NRD_FEATURE_PREPASS, 0, 0, \
      { NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(IN_##S##_SH0), NRDI_OUT(OUT_##S##_SH0), NRDI_HITDIST_OF(S, S##_SH0), \
        NRDI_IN(IN_##S##_SH1), NRDI_OUT(OUT_##S##_SH1), NRDI_TILES, NRDI_STOP } }
#define NRDI_LIGHTING_CHANGE(S, text) \
    { "lighting change" text, "reblur_lighting_change", NRDI_IF_ANTILAG, 0, NRDI_TILE_PX, 0, \
      { NRDI_READ(NRDI_##S##_TILE_RAW), NRDI_READ(NRDI_##S##_TILE), NRDI_WRITE(NRDI_##S##_TILE), NRDI_STOP } }
/* The input checker. Each frame clears the half of the counters that the next will write. */
#define NRDI_CHECK(signals, a, b) \
    { "input check", "check", NRDI_IF_CHECK, NRD_FEATURE_CHECK, 0, signals, \
      { NRDI_MOTION, NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(a), NRDI_IN(b), NRDI_WRITE(NRDI_COUNTERS), NRDI_WRITE_PREV(NRDI_COUNTERS), NRDI_STOP } }

/* The validation overlay. state, more: where the history lengths lie; how, tiles: those of SIGMA, as in NRDI_READ(tiles). */
#define NRDI_OVERLAY(signals, a, b, state, more, how, tiles) \
    { "validation", "validation", NRDI_IF_VALIDATION, NRD_FEATURE_VALIDATION, 0, signals, \
      { NRDI_MOTION, NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(a), NRDI_IN(b), NRDI_READ(state), NRDI_READ(more), NRDI_##how(tiles), NRDI_OUT(OUT_VALIDATION), NRDI_STOP } }
#define NRDI_DEBUG(signals, a, b, state, more, how, tiles) NRDI_OVERLAY(signals, a, b, state, more, how, tiles), NRDI_CHECK(signals, a, b)

#define NRDI_SPLIT_SCREEN(S, text) NRDI_SPLIT_SCREEN_OF(S##_RADIANCE_HITDIST, NRDI_LOBE_##S, text)
#define NRDI_SPLIT_SCREEN_OF(image, lobe, text) \
    { "split screen" text, "reblur_split_screen", NRDI_IF_SPLIT, NRD_FEATURE_SPLIT_SCREEN, 0, lobe, \
      { NRDI_IN(IN_VIEWZ), NRDI_IN(IN_##image), NRDI_OUT(OUT_##image), NRDI_STOP } }

/* In the order of NRD_DENOISERS, without those that are not compiled in. */
static const nrdi_denoiser_row nrdi_rows[] = {
#if NRDI_WITH(REFERENCE)
    { NRDI_FAMILY_REFERENCE,
      { { "HISTORY", NRD_FORMAT_RGBA32_FLOAT, 1, NRDI_PERMANENT } },
      { { "reference accumulate", "reference_accumulate", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_IN(IN_SIGNAL), NRDI_READ(NRDI_REFERENCE_HISTORY), NRDI_WRITE(NRDI_REFERENCE_HISTORY), NRDI_OUT(OUT_SIGNAL), NRDI_STOP } } } },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE)
    { NRDI_FAMILY_REBLUR,
      { NRDI_REBLUR_TEXTURES },
      { NRDI_FIND_TILES, NRDI_RECONSTRUCTION(DIFF, ""), NRDI_PREPASS(DIFF, "reblur_prepass_diffuse", "", NRDI_IF_PREPASS),
        { "temporal accumulation", "reblur_temporal_accumulation_diffuse", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_ACCUMULATION_GUIDES, NRDI_ACCUMULATION_SIGNAL(DIFF, NRDI_IF_PREPASS), NRDI_HITDIST(DIFF), NRDI_TILES, NRDI_STOP } },
        NRDI_LIGHTING_CHANGE(DIFF, ""),
        { "blur", "reblur_blur_diffuse", NRDI_ALWAYS, 0, 0, 0, { NRDI_READ(NRDI_GUIDE), NRDI_BLUR_SIGNAL(DIFF, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "post-blur 1", "reblur_stabilization_diffuse", NRDI_IF_BLUR, 0, 0, 1, { NRDI_READ(NRDI_GUIDE), NRDI_STABILIZATION_SIGNAL(DIFF, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "post-blur 2", "reblur_blur_diffuse", NRDI_IF_BLUR, 0, 0, 2, { NRDI_READ(NRDI_GUIDE), NRDI_BLUR_SIGNAL(DIFF, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "stabilization", "reblur_stabilization_diffuse", NRDI_ALWAYS, 0, 0, 3, { NRDI_READ(NRDI_GUIDE), NRDI_STABILIZATION_SIGNAL(DIFF, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        NRDI_SPLIT_SCREEN(DIFF, ""),
        NRDI_DEBUG(NRD_SIGNALS_RADIANCE + 0, IN_DIFF_RADIANCE_HITDIST, IN_DIFF_RADIANCE_HITDIST, NRDI_GUIDE, NRDI_GUIDE, IN, IN_VIEWZ) } },
#endif
#if NRDI_WITH(REBLUR_SPECULAR)
    { NRDI_FAMILY_REBLUR,
      { NRDI_REBLUR_TEXTURES },
      { NRDI_FIND_GLOSSY_TILES, NRDI_RECONSTRUCTION(SPEC, ""), NRDI_PREPASS(SPEC, "reblur_prepass_specular", "", NRDI_IF_SPEC_PREPASS),
        { "temporal accumulation", "reblur_temporal_accumulation_specular", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_ACCUMULATION_GUIDES, NRDI_READ_PREV(NRDI_SPEC_TRACK), NRDI_WRITE(NRDI_SPEC_TRACK), NRDI_ACCUMULATION_SIGNAL(SPEC, NRDI_IF_SPEC_PREPASS), NRDI_SPECULAR_EXTRAS, NRDI_TILES, NRDI_STOP } },
        NRDI_LIGHTING_CHANGE(SPEC, ""),
        { "blur", "reblur_blur_specular", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_SPEC_TRACK), NRDI_BLUR_SIGNAL(SPEC, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "post-blur 1", "reblur_stabilization_specular", NRDI_IF_BLUR, 0, 0, 1,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_SPEC_TRACK), NRDI_STABILIZATION_SIGNAL(SPEC, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "post-blur 2", "reblur_blur_specular", NRDI_IF_BLUR, 0, 0, 2,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_SPEC_TRACK), NRDI_BLUR_SIGNAL(SPEC, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "stabilization", "reblur_stabilization_specular", NRDI_ALWAYS, 0, 0, 3,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_SPEC_TRACK), NRDI_STABILIZATION_SIGNAL(SPEC, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        NRDI_SPLIT_SCREEN(SPEC, ""),
        NRDI_DEBUG(NRD_SIGNALS_RADIANCE + 1, IN_SPEC_RADIANCE_HITDIST, IN_SPEC_RADIANCE_HITDIST, NRDI_GUIDE, NRDI_SPEC_TRACK, IN, IN_VIEWZ) } },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_SPECULAR)
    { NRDI_FAMILY_REBLUR,
      { NRDI_REBLUR_TEXTURES },
      { NRDI_FIND_TILES, NRDI_RECONSTRUCTION(DIFF, " (diffuse)"), NRDI_RECONSTRUCTION(SPEC, " (specular)"),
        NRDI_PREPASS(DIFF, "reblur_prepass_diffuse", " (diffuse)", NRDI_IF_PREPASS),
        NRDI_PREPASS(SPEC, "reblur_prepass_specular", " (specular)", NRDI_IF_SPEC_PREPASS),
        { "temporal accumulation", "reblur_temporal_accumulation_diffuse_specular", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_ACCUMULATION_GUIDES, NRDI_READ_PREV(NRDI_TRACK), NRDI_WRITE(NRDI_TRACK), NRDI_ACCUMULATION_SIGNAL(DIFF, NRDI_IF_PREPASS),
            NRDI_ACCUMULATION_SIGNAL(SPEC, NRDI_IF_SPEC_PREPASS), NRDI_SPECULAR_EXTRAS, NRDI_HITDIST(DIFF), NRDI_TILES, NRDI_STOP } },
        NRDI_LIGHTING_CHANGE(DIFF, " (diffuse)"),
        NRDI_LIGHTING_CHANGE(SPEC, " (specular)"),
        { "blur", "reblur_blur_diffuse_specular", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_TRACK), NRDI_BLUR_SIGNAL(DIFF, NRDI_GUIDE), NRDI_BLUR_SIGNAL(SPEC, NRDI_TRACK), NRDI_TILES, NRDI_STOP } },
        { "post-blur 1", "reblur_stabilization_diffuse_specular", NRDI_IF_BLUR, 0, 0, 1,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_TRACK), NRDI_STABILIZATION_SIGNAL(DIFF, NRDI_GUIDE), NRDI_STABILIZATION_SIGNAL(SPEC, NRDI_TRACK), NRDI_TILES, NRDI_STOP } },
        { "post-blur 2", "reblur_blur_diffuse_specular", NRDI_IF_BLUR, 0, 0, 2,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_TRACK), NRDI_BLUR_SIGNAL(DIFF, NRDI_GUIDE), NRDI_BLUR_SIGNAL(SPEC, NRDI_TRACK), NRDI_TILES, NRDI_STOP } },
        { "stabilization", "reblur_stabilization_diffuse_specular", NRDI_ALWAYS, 0, 0, 3,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_TRACK), NRDI_STABILIZATION_SIGNAL(DIFF, NRDI_GUIDE), NRDI_STABILIZATION_SIGNAL(SPEC, NRDI_TRACK), NRDI_TILES, NRDI_STOP } },
        NRDI_SPLIT_SCREEN(DIFF, " (diffuse)"), NRDI_SPLIT_SCREEN(SPEC, " (specular)"),
        NRDI_DEBUG(NRD_SIGNALS_RADIANCE + 2, IN_DIFF_RADIANCE_HITDIST, IN_SPEC_RADIANCE_HITDIST, NRDI_GUIDE, NRDI_TRACK, IN, IN_VIEWZ) } },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_OCCLUSION)
    { NRDI_FAMILY_OCCLUSION,
      { { "TAP", NRD_FORMAT_R32_UINT, 1, NRDI_PING_PONG },
        { "STATE", NRD_FORMAT_R16_UINT, 1, NRDI_PING_PONG } },
      { NRDI_FIND_TILES, { "temporal accumulation", "reblur_diffuse_occlusion_accumulation", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_MOTION, NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(IN_DIFF_HITDIST), NRDI_LINEAR_CONFIDENCE(DIFF),
            NRDI_IN_IF(IN_DISOCCLUSION_THRESHOLD_MIX, NRDI_IF_THRESHOLD_MIX, IN_VIEWZ),
            NRDI_READ_PREV(NRDI_TAP), NRDI_READ_PREV(NRDI_STATE), NRDI_WRITE(NRDI_TAP), NRDI_WRITE(NRDI_STATE), NRDI_TILES, NRDI_STOP } },
        { "blur", "reblur_diffuse_occlusion_blur", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_READ(NRDI_TAP), NRDI_READ(NRDI_STATE), NRDI_OUT(OUT_DIFF_HITDIST), NRDI_TILES, NRDI_STOP } },
        NRDI_OCCLUSION_SPLIT(DIFF),
        NRDI_DEBUG(NRD_SIGNALS_HIT_DIST + 0, IN_DIFF_HITDIST, IN_DIFF_HITDIST, NRDI_TAP, NRDI_STATE, IN, IN_VIEWZ) } },
#endif
#if NRDI_WITH(REBLUR_SPECULAR_OCCLUSION)
    { NRDI_FAMILY_OCCLUSION,
      { { "TAP", NRD_FORMAT_RG32_UINT, 1, NRDI_PING_PONG } },
      { NRDI_FIND_TILES, { "temporal accumulation", "reblur_specular_occlusion_accumulation", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_MOTION, NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(IN_SPEC_HITDIST), NRDI_LINEAR_CONFIDENCE(SPEC),
            NRDI_IN_IF(IN_DISOCCLUSION_THRESHOLD_MIX, NRDI_IF_THRESHOLD_MIX, IN_VIEWZ), NRDI_READ_PREV(NRDI_TAP), NRDI_WRITE(NRDI_TAP), NRDI_TILES, NRDI_STOP } },
        { "blur", "reblur_specular_occlusion_blur", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_READ(NRDI_TAP), NRDI_OUT(OUT_SPEC_HITDIST), NRDI_TILES, NRDI_STOP } },
        NRDI_OCCLUSION_SPLIT(SPEC),
        NRDI_DEBUG(NRD_SIGNALS_HIT_DIST + 1, IN_SPEC_HITDIST, IN_SPEC_HITDIST, NRDI_TAP, NRDI_TAP, IN, IN_VIEWZ) } },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_SPECULAR_OCCLUSION)
    { NRDI_FAMILY_OCCLUSION,
      { { "TAP", NRD_FORMAT_RG32_UINT, 1, NRDI_PING_PONG },
        { "STATE", NRD_FORMAT_R16_UINT, 1, NRDI_PING_PONG } },
      { NRDI_FIND_TILES, { "temporal accumulation", "reblur_diffuse_specular_occlusion_accumulation", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_MOTION, NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(IN_DIFF_HITDIST), NRDI_LINEAR_CONFIDENCE(DIFF),
            NRDI_IN_IF(IN_DISOCCLUSION_THRESHOLD_MIX, NRDI_IF_THRESHOLD_MIX, IN_VIEWZ), NRDI_READ_PREV(NRDI_TAP), NRDI_READ_PREV(NRDI_STATE),
            NRDI_WRITE(NRDI_TAP), NRDI_WRITE(NRDI_STATE), NRDI_IN(IN_SPEC_HITDIST), NRDI_LINEAR_CONFIDENCE(SPEC), NRDI_TILES, NRDI_STOP } },
        { "blur", "reblur_diffuse_specular_occlusion_blur", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_READ(NRDI_TAP), NRDI_READ(NRDI_STATE), NRDI_OUT(OUT_DIFF_HITDIST),
            NRDI_OUT(OUT_SPEC_HITDIST), NRDI_TILES, NRDI_STOP } },
        NRDI_OCCLUSION_SPLIT(DIFF), NRDI_OCCLUSION_SPLIT(SPEC),
        NRDI_DEBUG(NRD_SIGNALS_HIT_DIST + 2, IN_DIFF_HITDIST, IN_SPEC_HITDIST, NRDI_TAP, NRDI_STATE, IN, IN_VIEWZ) } },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION)
    { NRDI_FAMILY_OCCLUSION,
      { { "TAP", NRD_FORMAT_RG32_UINT, 1, NRDI_PING_PONG },
        { "STATE", NRD_FORMAT_R16_UINT, 1, NRDI_PING_PONG } },
      { NRDI_FIND_TILES, { "temporal accumulation", "reblur_directional_occlusion_accumulation", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_MOTION, NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(IN_DIFF_DIRECTION_HITDIST),
            NRDI_LINEAR_IF(IN_DIFF_CONFIDENCE, NRDI_IF_CONFIDENCE, IN_DIFF_DIRECTION_HITDIST), NRDI_IN_IF(IN_DISOCCLUSION_THRESHOLD_MIX, NRDI_IF_THRESHOLD_MIX, IN_VIEWZ),
            NRDI_READ_PREV(NRDI_TAP), NRDI_READ_PREV(NRDI_STATE), NRDI_WRITE(NRDI_TAP), NRDI_WRITE(NRDI_STATE), NRDI_TILES, NRDI_STOP } },
        { "blur", "reblur_directional_occlusion_blur", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_READ(NRDI_TAP), NRDI_READ(NRDI_STATE), NRDI_OUT(OUT_DIFF_DIRECTION_HITDIST), NRDI_TILES, NRDI_STOP } },
        { "split screen", "reblur_split_screen", NRDI_IF_SPLIT, NRD_FEATURE_SPLIT_SCREEN, 0, 0,
          { NRDI_IN(IN_VIEWZ), NRDI_IN(IN_DIFF_DIRECTION_HITDIST), NRDI_OUT(OUT_DIFF_DIRECTION_HITDIST), NRDI_STOP } },
        NRDI_DEBUG(NRD_SIGNALS_DIRECTION, IN_DIFF_DIRECTION_HITDIST, IN_DIFF_DIRECTION_HITDIST, NRDI_TAP, NRDI_STATE, IN, IN_VIEWZ) } },
#endif
#if NRDI_WITH(SIGMA_SHADOW)
    { NRDI_FAMILY_SIGMA,
      { { "SHADOW_HISTORY", NRD_FORMAT_R32_UINT, 1, NRDI_PERMANENT },
        { "SHADOW_TILE", NRD_FORMAT_R8_UNORM, NRDI_TILE_PX, NRDI_PING_PONG },
        { "SHADOW_MEAN", NRD_FORMAT_R32_UINT, 1, NRDI_TRANSIENT },
        { "SHADOW_STABILIZED", NRD_FORMAT_R8_UNORM, 1, NRDI_TRANSIENT },
        { "SHADOW_KINDS", NRD_FORMAT_R16_UINT, NRDI_TILE_PX, NRDI_TRANSIENT } },
      { { "shadow rays", "sigma_rays", NRDI_ALWAYS, 0, 2, 0,
          { NRDI_IN(IN_VIEWZ), NRDI_IN(IN_PENUMBRA), NRDI_WRITE(NRDI_SHADOW_MEAN), NRDI_WRITE(NRDI_SHADOW_KINDS), NRDI_OUT(OUT_SHADOW), NRDI_WRITE(NRDI_TILE_LIST), NRDI_STOP } },
        { "shadow tiles", "sigma_tiles", NRDI_ALWAYS, 0, NRDI_TILE_PX, 0,
          { NRDI_READ(NRDI_SHADOW_KINDS), NRDI_READ_PREV(NRDI_SHADOW_TILE), NRDI_WRITE(NRDI_SHADOW_TILE), NRDI_LIST_TILES, NRDI_STOP } },
        { "shadow accumulation", "sigma_accumulation", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_MOTION, NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(IN_PENUMBRA), NRDI_READ(NRDI_SHADOW_HISTORY), NRDI_READ(NRDI_TILE_LIST),
            NRDI_WRITE(NRDI_SHADOW_MEAN), NRDI_OWN_WRITE_IF(NRDI_SHADOW_EXTRA, NRDI_IF_STABILIZED), NRDI_STOP } },
        { "shadow blur", "sigma_blur", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_READ(NRDI_TILE_LIST), NRDI_READ(NRDI_SHADOW_MEAN), NRDI_WRITE(NRDI_SHADOW_HISTORY),
            NRDI_OUT(OUT_SHADOW), NRDI_OWN_READ_IF(NRDI_SHADOW_EXTRA, NRDI_IF_STABILIZED), NRDI_STOP } },
        { "split screen", "sigma_split_screen", NRDI_IF_SPLIT, NRD_FEATURE_SPLIT_SCREEN, 0, 0,
          { NRDI_IN(IN_VIEWZ), NRDI_IN(IN_PENUMBRA), NRDI_OUT(OUT_SHADOW), NRDI_STOP } },
        NRDI_DEBUG(NRD_SIGNALS_SHADOW, IN_PENUMBRA, IN_PENUMBRA, NRDI_SHADOW_HISTORY, NRDI_SHADOW_HISTORY, READ, NRDI_SHADOW_TILE) } },
#endif
#if NRDI_WITH(SIGMA_SHADOW_TRANSLUCENCY)
    { NRDI_FAMILY_SIGMA,
      { { "SHADOW_HISTORY", NRD_FORMAT_R32_UINT, 1, NRDI_PERMANENT },
        { "SHADOW_TILE", NRD_FORMAT_R8_UNORM, NRDI_TILE_PX, NRDI_PING_PONG },
        { "SHADOW_MEAN", NRD_FORMAT_RG32_UINT, 1, NRDI_TRANSIENT },
        { "SHADOW_HISTORY_COLOR", NRD_FORMAT_R16_UINT, 1, NRDI_PERMANENT },
        { "SHADOW_KINDS", NRD_FORMAT_R16_UINT, NRDI_TILE_PX, NRDI_TRANSIENT } },
      { { "shadow rays", "sigma_rays_translucency", NRDI_ALWAYS, 0, 2, 0,
          { NRDI_IN(IN_VIEWZ), NRDI_IN(IN_PENUMBRA), NRDI_WRITE(NRDI_SHADOW_MEAN), NRDI_WRITE(NRDI_SHADOW_KINDS), NRDI_OUT(OUT_SHADOW_TRANSLUCENCY),
            NRDI_WRITE(NRDI_TILE_LIST), NRDI_IN(IN_TRANSLUCENCY), NRDI_STOP } },
        { "shadow tiles", "sigma_tiles", NRDI_ALWAYS, 0, NRDI_TILE_PX, 0,
          { NRDI_READ(NRDI_SHADOW_KINDS), NRDI_READ_PREV(NRDI_SHADOW_TILE), NRDI_WRITE(NRDI_SHADOW_TILE), NRDI_LIST_TILES, NRDI_STOP } },
        { "shadow accumulation", "sigma_accumulation_translucency", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_MOTION, NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_IN(IN_VIEWZ), NRDI_IN(IN_PENUMBRA), NRDI_READ(NRDI_SHADOW_HISTORY), NRDI_READ(NRDI_TILE_LIST),
            NRDI_WRITE(NRDI_SHADOW_MEAN), NRDI_IN(IN_TRANSLUCENCY), NRDI_READ(NRDI_SHADOW_EXTRA), NRDI_STOP } },
        { "shadow blur", "sigma_blur_translucency", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_IN(IN_NORMAL_ROUGHNESS), NRDI_READ(NRDI_TILE_LIST), NRDI_READ(NRDI_SHADOW_MEAN), NRDI_WRITE(NRDI_SHADOW_HISTORY),
            NRDI_OUT(OUT_SHADOW_TRANSLUCENCY), NRDI_WRITE(NRDI_SHADOW_EXTRA), NRDI_STOP } },
        { "split screen", "sigma_split_screen_translucency", NRDI_IF_SPLIT, NRD_FEATURE_SPLIT_SCREEN, 0, 0,
          { NRDI_IN(IN_VIEWZ), NRDI_IN(IN_PENUMBRA), NRDI_OUT(OUT_SHADOW_TRANSLUCENCY), NRDI_IN(IN_TRANSLUCENCY), NRDI_STOP } },
        NRDI_DEBUG(NRD_SIGNALS_TRANSLUCENT_SHADOW, IN_PENUMBRA, IN_TRANSLUCENCY, NRDI_SHADOW_HISTORY, NRDI_SHADOW_HISTORY, READ, NRDI_SHADOW_TILE) } },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_SH)
    { NRDI_FAMILY_REBLUR,
      { NRDI_REBLUR_TEXTURES },
      { NRDI_FIND_TILES, NRDI_RECONSTRUCTION_OF(DIFF, DIFF_SH0, ""), NRDI_PREPASS_SH(DIFF, "reblur_prepass_diffuse_sh", "", NRDI_IF_PREPASS),
        { "temporal accumulation", "reblur_temporal_accumulation_diffuse_sh", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_ACCUMULATION_GUIDES, NRDI_ACCUMULATION_OF(DIFF, DIFF_SH0, NRDI_IF_PREPASS), NRDI_HITDIST_OF(DIFF, DIFF_SH0),
            NRDI_ACCUMULATION_SH(DIFF, NRDI_IF_PREPASS), NRDI_TILES, NRDI_STOP } },
        NRDI_LIGHTING_CHANGE(DIFF, ""),
        { "blur", "reblur_blur_diffuse_sh", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_READ(NRDI_GUIDE), NRDI_BLUR_OF(DIFF, DIFF_SH0, NRDI_GUIDE), NRDI_IN(OUT_DIFF_SH1), NRDI_WRITE(NRDI_DIFF_SH), NRDI_WRITE(NRDI_DIFF_SH_HISTORY), NRDI_TILES, NRDI_STOP } },
        { "post-blur 1", "reblur_stabilization_diffuse", NRDI_IF_BLUR, 0, 0, 1,
          { NRDI_READ(NRDI_GUIDE), NRDI_STABILIZATION_OF(DIFF, DIFF_SH0, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "post-blur 2", "reblur_blur_diffuse", NRDI_IF_BLUR, 0, 0, 2,
          { NRDI_READ(NRDI_GUIDE), NRDI_BLUR_OF(DIFF, DIFF_SH0, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "stabilization", "reblur_stabilization_diffuse_sh", NRDI_ALWAYS, 0, 0, 3,
          { NRDI_READ(NRDI_GUIDE), NRDI_STABILIZATION_OF(DIFF, DIFF_SH0, NRDI_GUIDE), NRDI_READ(NRDI_DIFF_SH), NRDI_OUT(OUT_DIFF_SH1), NRDI_TILES, NRDI_STOP } },
        NRDI_SPLIT_SCREEN_OF(DIFF_SH0, NRDI_LOBE_DIFF, " (SH0)"), NRDI_SPLIT_SCREEN_OF(DIFF_SH1, NRDI_LOBE_DIFF, " (SH1)"),
        NRDI_DEBUG(NRD_SIGNALS_RADIANCE + 0, IN_DIFF_SH0, IN_DIFF_SH0, NRDI_GUIDE, NRDI_GUIDE, IN, IN_VIEWZ) } },
#endif
#if NRDI_WITH(REBLUR_SPECULAR_SH)
    { NRDI_FAMILY_REBLUR,      /* the previous half of SPEC_TRACK is dead after accumulation, too */
      { NRDI_REBLUR_TEXTURES },
      { NRDI_FIND_GLOSSY_TILES, NRDI_RECONSTRUCTION_OF(SPEC, SPEC_SH0, ""), NRDI_PREPASS_SH(SPEC, "reblur_prepass_specular_sh", "", NRDI_IF_SPEC_PREPASS),
        { "temporal accumulation", "reblur_temporal_accumulation_specular_sh", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_ACCUMULATION_GUIDES, NRDI_READ_PREV(NRDI_SPEC_TRACK), NRDI_WRITE(NRDI_SPEC_TRACK), NRDI_ACCUMULATION_OF(SPEC, SPEC_SH0, NRDI_IF_SPEC_PREPASS),
            NRDI_SPECULAR_EXTRAS_OF(SPEC_SH0), NRDI_ACCUMULATION_SH(SPEC, NRDI_IF_SPEC_PREPASS), NRDI_TILES, NRDI_STOP } },
        NRDI_LIGHTING_CHANGE(SPEC, ""),
        { "blur", "reblur_blur_specular_sh", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_SPEC_TRACK), NRDI_BLUR_OF(SPEC, SPEC_SH0, NRDI_GUIDE), NRDI_IN(OUT_SPEC_SH1), NRDI_WRITE_PREV(NRDI_SPEC_TRACK), NRDI_WRITE(NRDI_SPEC_SH_HISTORY), NRDI_TILES, NRDI_STOP } },
        { "post-blur 1", "reblur_stabilization_specular", NRDI_IF_BLUR, 0, 0, 1,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_SPEC_TRACK), NRDI_STABILIZATION_OF(SPEC, SPEC_SH0, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "post-blur 2", "reblur_blur_specular", NRDI_IF_BLUR, 0, 0, 2,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_SPEC_TRACK), NRDI_BLUR_OF(SPEC, SPEC_SH0, NRDI_GUIDE), NRDI_TILES, NRDI_STOP } },
        { "stabilization", "reblur_stabilization_specular_sh", NRDI_ALWAYS, 0, 0, 3,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_SPEC_TRACK), NRDI_STABILIZATION_OF(SPEC, SPEC_SH0, NRDI_GUIDE), NRDI_READ_PREV(NRDI_SPEC_TRACK), NRDI_OUT(OUT_SPEC_SH1), NRDI_TILES, NRDI_STOP } },
        NRDI_SPLIT_SCREEN_OF(SPEC_SH0, NRDI_LOBE_SPEC, " (SH0)"), NRDI_SPLIT_SCREEN_OF(SPEC_SH1, NRDI_LOBE_SPEC, " (SH1)"),
        NRDI_DEBUG(NRD_SIGNALS_RADIANCE + 1, IN_SPEC_SH0, IN_SPEC_SH0, NRDI_GUIDE, NRDI_SPEC_TRACK, IN, IN_VIEWZ) } },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_SPECULAR_SH)
    { NRDI_FAMILY_REBLUR,
      { NRDI_REBLUR_TEXTURES },
      { NRDI_FIND_TILES, NRDI_RECONSTRUCTION_OF(DIFF, DIFF_SH0, " (diffuse)"), NRDI_RECONSTRUCTION_OF(SPEC, SPEC_SH0, " (specular)"),
        NRDI_PREPASS_SH(DIFF, "reblur_prepass_diffuse_sh", " (diffuse)", NRDI_IF_PREPASS),
        NRDI_PREPASS_SH(SPEC, "reblur_prepass_specular_sh", " (specular)", NRDI_IF_SPEC_PREPASS),
        { "temporal accumulation", "reblur_temporal_accumulation_diffuse_specular_sh", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_ACCUMULATION_GUIDES, NRDI_READ_PREV(NRDI_TRACK), NRDI_WRITE(NRDI_TRACK), NRDI_ACCUMULATION_OF(DIFF, DIFF_SH0, NRDI_IF_PREPASS),
            NRDI_ACCUMULATION_OF(SPEC, SPEC_SH0, NRDI_IF_SPEC_PREPASS), NRDI_SPECULAR_EXTRAS_OF(SPEC_SH0), NRDI_HITDIST_OF(DIFF, DIFF_SH0),
            NRDI_ACCUMULATION_SH(DIFF, NRDI_IF_PREPASS), NRDI_ACCUMULATION_SH(SPEC, NRDI_IF_SPEC_PREPASS), NRDI_TILES, NRDI_STOP } },
        NRDI_LIGHTING_CHANGE(DIFF, " (diffuse)"),
        NRDI_LIGHTING_CHANGE(SPEC, " (specular)"),
        { "blur", "reblur_blur_diffuse_specular_sh", NRDI_ALWAYS, 0, 0, 0,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_TRACK), NRDI_BLUR_OF(DIFF, DIFF_SH0, NRDI_GUIDE), NRDI_BLUR_OF(SPEC, SPEC_SH0, NRDI_TRACK),
            NRDI_IN(OUT_DIFF_SH1), NRDI_IN(OUT_SPEC_SH1), NRDI_WRITE(NRDI_SH), NRDI_WRITE(NRDI_DIFF_SH_HISTORY), NRDI_WRITE(NRDI_SPEC_SH_HISTORY), NRDI_TILES, NRDI_STOP } },
        { "post-blur 1", "reblur_stabilization_diffuse_specular", NRDI_IF_BLUR, 0, 0, 1,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_TRACK), NRDI_STABILIZATION_OF(DIFF, DIFF_SH0, NRDI_GUIDE), NRDI_STABILIZATION_OF(SPEC, SPEC_SH0, NRDI_TRACK), NRDI_TILES, NRDI_STOP } },
        { "post-blur 2", "reblur_blur_diffuse_specular", NRDI_IF_BLUR, 0, 0, 2,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_TRACK), NRDI_BLUR_OF(DIFF, DIFF_SH0, NRDI_GUIDE), NRDI_BLUR_OF(SPEC, SPEC_SH0, NRDI_TRACK), NRDI_TILES, NRDI_STOP } },
        { "stabilization", "reblur_stabilization_diffuse_specular_sh", NRDI_ALWAYS, 0, 0, 3,
          { NRDI_READ(NRDI_GUIDE), NRDI_READ(NRDI_TRACK), NRDI_STABILIZATION_OF(DIFF, DIFF_SH0, NRDI_GUIDE), NRDI_STABILIZATION_OF(SPEC, SPEC_SH0, NRDI_TRACK),
            NRDI_READ(NRDI_SH), NRDI_OUT(OUT_DIFF_SH1), NRDI_OUT(OUT_SPEC_SH1), NRDI_TILES, NRDI_STOP } },
        NRDI_SPLIT_SCREEN_OF(DIFF_SH0, NRDI_LOBE_DIFF, " (diffuse SH0)"), NRDI_SPLIT_SCREEN_OF(DIFF_SH1, NRDI_LOBE_DIFF, " (diffuse SH1)"),
        NRDI_SPLIT_SCREEN_OF(SPEC_SH0, NRDI_LOBE_SPEC, " (specular SH0)"), NRDI_SPLIT_SCREEN_OF(SPEC_SH1, NRDI_LOBE_SPEC, " (specular SH1)"),
        NRDI_DEBUG(NRD_SIGNALS_RADIANCE + 2, IN_DIFF_SH0, IN_SPEC_SH0, NRDI_GUIDE, NRDI_TRACK, IN, IN_VIEWZ) } },
#endif
};

static const bool nrdi_compiled_in[] = {
#define NRDI_X(name, text, settings) NRDI_WITH(name),
    NRD_DENOISERS(NRDI_X)
#undef NRDI_X
};
#define NRDI_X(name, text, settings) + (NRDI_WITH(name) ? 1 : 0)
typedef char nrdi_every_denoiser_has_its_row[sizeof nrdi_rows / sizeof nrdi_rows[0] == 0 NRD_DENOISERS(NRDI_X) ? 1 : -1];
#undef NRDI_X

/* NULL: not compiled in. */
static const nrdi_denoiser_row *nrdi_row_of(nrd_denoiser denoiser)
{
    const nrdi_denoiser_row *row = nrdi_rows;
    for (uint32_t i = 0; i < (uint32_t)denoiser; i++) row += nrdi_compiled_in[i];
    return nrdi_compiled_in[denoiser] ? row : NULL;
}

static uint32_t nrdi_use_count(const nrdi_pass_row *pass)
{
    uint32_t n = 0;
    while (n < NRDI_MAX_USES && pass->uses[n].access != NRDI_END) n++;
    return n;
}

static const nrdi_texture_row *nrdi_texture_of(const nrdi_denoiser_row *row, uint32_t index)
{
    return index >= NRDI_TILE_AGE ? &nrdi_common_rows[index - NRDI_TILE_AGE] : &row->textures[index];
}

/* Textures of a row. */
static uint32_t nrdi_halves(const nrdi_texture_row *row) { return row->kind >= NRDI_PING_PONG ? 2 : 1; }

static uint32_t nrdi_pass_count(const nrdi_denoiser_row *row)
{
    uint32_t n = 0;
    while (n < NRDI_MAX_PASSES && row->passes[n].name) n++;
    return n;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Names and settings as data  >>names */
const char *nrd_result_string(nrd_result result)
{
    static const char *const texts[] = {
#define NRDI_X(name, text) text,
        NRD_RESULTS(NRDI_X)
#undef NRDI_X
    };
    return (uint32_t)result < NRD_RESULT_COUNT ? texts[result] : "unknown result";
}

uint32_t nrd_version(void) { return NRD_RELEASE_NUMBER; }

const char *nrd_denoiser_name(nrd_denoiser denoiser)
{
    static const char *const names[] = {
#define NRDI_X(name, text, settings) text,
        NRD_DENOISERS(NRDI_X)
#undef NRDI_X
    };
    return (uint32_t)denoiser < NRD_DENOISER_COUNT ? names[denoiser] : NULL;
}

typedef struct nrdi_absence { const char *name, *text; } nrdi_absence;
static const nrdi_absence nrdi_absences[] = {
#define NRDI_X(name, text, promise) { text, promise },
    NRD_ABSENCES(NRDI_X)
#undef NRDI_X
};
enum { NRDI_ABSENCE_COUNT = sizeof nrdi_absences / sizeof nrdi_absences[0] };

const char *nrd_absence_name(uint32_t i) { return i < NRDI_ABSENCE_COUNT ? nrdi_absences[i].name : NULL; }
const char *nrd_absence_text(uint32_t i) { return i < NRDI_ABSENCE_COUNT ? nrdi_absences[i].text : NULL; }

nrd_result nrd_find_denoiser(const char *name, nrd_denoiser *out)
{
    for (uint32_t i = 0; name && out && i < NRD_DENOISER_COUNT; i++) {
        if (strcmp(name, nrd_denoiser_name((nrd_denoiser)i)) != 0) continue;
        *out = (nrd_denoiser)i;
        return NRD_RESULT_OK;
    }
    return name && out ? NRD_RESULT_UNKNOWN_DENOISER : NRD_RESULT_INVALID_ARGUMENT;
}

typedef struct nrdi_resource_row { const char *name; nrd_format format; const char *text; } nrdi_resource_row;
static const nrdi_resource_row nrdi_resources[] = {
#define NRDI_X(name, format, text) { #name, (nrd_format)(format), text },
    NRD_RESOURCES(NRDI_X)
#undef NRDI_X
};

const char *nrd_resource_name(nrd_resource resource) { return (uint32_t)resource < NRD_RESOURCE_COUNT ? nrdi_resources[resource].name : NULL; }
const char *nrd_resource_text(nrd_resource resource) { return (uint32_t)resource < NRD_RESOURCE_COUNT ? nrdi_resources[resource].text : NULL; }
nrd_format nrd_resource_format(nrd_resource resource) { return (uint32_t)resource < NRD_RESOURCE_COUNT ? nrdi_resources[resource].format : NRD_FORMAT_ANY; }

typedef struct nrdi_format_row { uint32_t bytes; bool is_uint; } nrdi_format_row;
static const nrdi_format_row nrdi_formats[] = {
#define NRDI_X(name, bytes, is_uint) { bytes, is_uint },
    NRD_FORMATS(NRDI_X)
#undef NRDI_X
};

uint32_t nrd_format_bytes(nrd_format format) { return (uint32_t)format < NRD_FORMAT_COUNT ? nrdi_formats[format].bytes : 0; }
bool nrd_format_is_uint(nrd_format format) { return (uint32_t)format < NRD_FORMAT_COUNT && nrdi_formats[format].is_uint; }

#define NRDI_IS_FLOAT_float true
#define NRDI_IS_FLOAT_uint false
#define NRDI_ROW(owner, type, name, value, min, max, unit, text) { #name, unit, text, (double)(value), (double)(min), (double)(max), NRDI_IS_FLOAT_##type, offsetof(owner, name) },
#define NRDI_X(type, name, value, min, max, unit, text) NRDI_ROW(nrd_frame, type, name, value, min, max, unit, text)
static const nrd_setting nrdi_frame_settings[] = { NRD_FRAME_SETTINGS(NRDI_X) };
#undef NRDI_X
#define NRDI_X(type, name, value, min, max, unit, text) NRDI_ROW(nrd_reference_settings, type, name, value, min, max, unit, text)
static const nrd_setting nrdi_reference_list[] = { NRD_REFERENCE_SETTINGS(NRDI_X) };
#undef NRDI_X
#define NRDI_X(type, name, value, min, max, unit, text) NRDI_ROW(nrd_reblur_settings, type, name, value, min, max, unit, text)
static const nrd_setting nrdi_reblur_list[] = { NRD_REBLUR_SETTINGS(NRDI_X) };
#undef NRDI_X
#define NRDI_X(type, name, value, min, max, unit, text) NRDI_ROW(nrd_occlusion_settings, type, name, value, min, max, unit, text)
static const nrd_setting nrdi_occlusion_list[] = { NRD_OCCLUSION_SETTINGS(NRDI_X) };
#undef NRDI_X
#define NRDI_X(type, name, value, min, max, unit, text) NRDI_ROW(nrd_sigma_settings, type, name, value, min, max, unit, text)
static const nrd_setting nrdi_sigma_list[] = { NRD_SIGMA_SETTINGS(NRDI_X) };
#undef NRDI_X

typedef struct nrdi_settings_list { const nrd_setting *rows; uint32_t count; size_t bytes; } nrdi_settings_list;
#define NRDI_LIST(rows, owner) { rows, (uint32_t)(sizeof(rows) / sizeof((rows)[0])), sizeof(owner) }
#define NRDI_LIST_nrd_reference_settings NRDI_LIST(nrdi_reference_list, nrd_reference_settings)
#define NRDI_LIST_nrd_reblur_settings NRDI_LIST(nrdi_reblur_list, nrd_reblur_settings)
#define NRDI_LIST_nrd_occlusion_settings NRDI_LIST(nrdi_occlusion_list, nrd_occlusion_settings)
#define NRDI_LIST_nrd_sigma_settings NRDI_LIST(nrdi_sigma_list, nrd_sigma_settings)

static nrdi_settings_list nrdi_list_of(nrd_denoiser denoiser)
{
    static const nrdi_settings_list lists[NRD_DENOISER_COUNT + 1] = {
#define NRDI_X(name, text, settings) NRDI_LIST_##settings,
        NRD_DENOISERS(NRDI_X)
#undef NRDI_X
        NRDI_LIST(nrdi_frame_settings, nrd_frame)
    };
    static const nrdi_settings_list none = { NULL, 0, 0 };
    return (uint32_t)denoiser <= NRD_DENOISER_COUNT ? lists[denoiser] : none;
}

bool nrd_get_setting(nrd_denoiser denoiser, uint32_t i, nrd_setting *out)
{
    nrdi_settings_list list = nrdi_list_of(denoiser);
    if (!out || i >= list.count) return false;
    *out = list.rows[i];
    return true;
}

size_t nrd_settings_size(nrd_denoiser denoiser) { return nrdi_list_of(denoiser).bytes; }

void nrd_settings_defaults(nrd_denoiser denoiser, void *settings)
{
    nrdi_settings_list list = nrdi_list_of(denoiser);
    if (!settings) return;
    memset(settings, 0, list.bytes);
    for (uint32_t i = 0; i < list.count; i++) {
        char *at = (char *)settings + list.rows[i].offset;
        float f = (float)list.rows[i].value;
        uint32_t u = list.rows[i].is_float ? 0 : (uint32_t)list.rows[i].value;   /* a negative one does not convert */
        memcpy(at, list.rows[i].is_float ? (const void *)&f : (const void *)&u, 4);
    }
}

const char *nrd_preset_name(nrd_preset preset)
{
    static const char *const names[] = {
#define NRDI_X(name, text) text,
        NRD_PRESETS(NRDI_X)
#undef NRDI_X
    };
    return (uint32_t)preset < NRD_PRESET_COUNT ? names[preset] : NULL;
}

/* Where presets depart from the defaults; a row concerns every denoiser with this settings struct. Times and errors in those of BALANCED, on an
   H200 at 1920x1080 and on the scenes `interior` and `moving` (nrd-report --variant), of radiance and of occlusion:
   FASTEST  no spatial filter: 0.46 to 0.63, error 3.9 to 4.2 (independent captures: 2.3 to 160); 0.75 to 0.85, error 1.9 to 3.3
   FAST     fewest filter steps: 0.64 to 0.75, error 1.15 to 1.2 (captures: 1.1 to 4.2, worst in rare light); of occlusion 4 neighbours instead of
            6: 0.92 to 0.95, error 1.05 to 1.07
   On the front of radiance too, but close to BALANCED: performance_mode 1, 0.94, error 1.05 to 1.09. Not on it: no search for changes of
   lighting, 0.94, error 2.3 to 13.
   Nothing that takes more time is better, so GOOD and BEST are BALANCED: pre-pass of 10 px 1.3, error 1.05 to 1.13; max_blur_radius 20 error
   1.04 to 1.07; histories of 63 frames 1.00. In the same time less error means more flicker: no stabilization 0.94, flicker at rest 2.6 to
   3.6; max_blur_radius 8 0.93 to 1.00, 1.2 to 1.4. luminance_sigma_scale 8: error 0.99 to 1.05, flicker 0.98 to 1.00.
   SIGMA takes the same time whatever its settings (0.98 to 1.00), so all its presets are its defaults; so are REFERENCE's. */
typedef struct nrdi_preset_row { nrd_preset preset; const nrd_setting *list; const char *name; float value; } nrdi_preset_row;
static const nrdi_preset_row nrdi_presets[] = {
    { NRD_PRESET_FASTEST, nrdi_reblur_list, "max_blur_radius", 0.0f },
    { NRD_PRESET_FAST, nrdi_reblur_list, "performance_mode", 2.0f },
    { NRD_PRESET_FASTEST, nrdi_occlusion_list, "max_blur_radius", 0.0f },
    { NRD_PRESET_FAST, nrdi_occlusion_list, "performance_mode", 1.0f },
};

void nrd_settings_preset(nrd_denoiser denoiser, nrd_preset preset, void *settings)
{
    nrdi_settings_list list = nrdi_list_of(denoiser);
    nrd_settings_defaults(denoiser, settings);
    for (size_t i = 0; i < sizeof nrdi_presets / sizeof nrdi_presets[0] && settings; i++)
        for (uint32_t k = 0; k < list.count; k++) {
            const nrdi_preset_row *row = &nrdi_presets[i];
            uint32_t u = (uint32_t)row->value;
            if (row->preset != preset || row->list != list.rows || strcmp(row->name, list.rows[k].name) != 0) continue;
            memcpy((char *)settings + list.rows[k].offset, list.rows[k].is_float ? (const void *)&row->value : (const void *)&u, 4);
        }
}

nrd_occlusion_settings nrd_occlusion_preset(nrd_preset preset) { nrd_occlusion_settings s; nrd_settings_preset(NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, preset, &s); return s; }
nrd_reblur_settings nrd_reblur_preset(nrd_preset preset) { nrd_reblur_settings s; nrd_settings_preset(NRD_DENOISER_REBLUR_DIFFUSE, preset, &s); return s; }

/* What examples/report/publish.sh has taken from reports: denoiser, preset, device, nanoseconds per pixel, error. */
typedef struct nrdi_cost { nrd_denoiser denoiser; nrd_preset preset; nrd_device device; float ns_per_pixel, error; } nrdi_cost;
#define NRDI_COST(denoiser, preset, device, ns, error) { NRD_DENOISER_##denoiser, NRD_PRESET_##preset, NRD_DEVICE_##device, ns, error },
static const nrdi_cost nrdi_costs[] = {
    /* >>costs begin */
    NRDI_COST(REBLUR_DIFFUSE, FASTEST, DATACENTER, 0.07276f, 0.0231f)
    NRDI_COST(REBLUR_DIFFUSE, FAST, DATACENTER, 0.08908f, 0.006676f)
    NRDI_COST(REBLUR_DIFFUSE, BALANCED, DATACENTER, 0.1326f, 0.005755f)
    NRDI_COST(REBLUR_SPECULAR, FASTEST, DATACENTER, 0.106f, 0.05907f)
    NRDI_COST(REBLUR_SPECULAR, FAST, DATACENTER, 0.1281f, 0.0177f)
    NRDI_COST(REBLUR_SPECULAR, BALANCED, DATACENTER, 0.1787f, 0.01466f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR, FASTEST, DATACENTER, 0.1423f, 0.03693f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR, FAST, DATACENTER, 0.1708f, 0.01088f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR, BALANCED, DATACENTER, 0.243f, 0.009208f)
    NRDI_COST(REBLUR_DIFFUSE_OCCLUSION, FASTEST, DATACENTER, 0.05771f, 0.01288f)
    NRDI_COST(REBLUR_DIFFUSE_OCCLUSION, FAST, DATACENTER, 0.06456f, 0.003884f)
    NRDI_COST(REBLUR_DIFFUSE_OCCLUSION, BALANCED, DATACENTER, 0.06781f, 0.003608f)
    NRDI_COST(REBLUR_SPECULAR_OCCLUSION, FASTEST, DATACENTER, 0.07339f, 0.02641f)
    NRDI_COST(REBLUR_SPECULAR_OCCLUSION, FAST, DATACENTER, 0.08351f, 0.01467f)
    NRDI_COST(REBLUR_SPECULAR_OCCLUSION, BALANCED, DATACENTER, 0.08866f, 0.01402f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_OCCLUSION, FASTEST, DATACENTER, 0.09492f, 0.01831f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_OCCLUSION, FAST, DATACENTER, 0.1173f, 0.007357f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_OCCLUSION, BALANCED, DATACENTER, 0.1274f, 0.006937f)
    NRDI_COST(REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, FASTEST, DATACENTER, 0.07009f, 0.01288f)
    NRDI_COST(REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, FAST, DATACENTER, 0.08115f, 0.003884f)
    NRDI_COST(REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, BALANCED, DATACENTER, 0.08606f, 0.003608f)
    NRDI_COST(REBLUR_DIFFUSE_SH, FASTEST, DATACENTER, 0.09088f, 0.02276f)
    NRDI_COST(REBLUR_DIFFUSE_SH, FAST, DATACENTER, 0.1124f, 0.006276f)
    NRDI_COST(REBLUR_DIFFUSE_SH, BALANCED, DATACENTER, 0.1562f, 0.005406f)
    NRDI_COST(REBLUR_SPECULAR_SH, FASTEST, DATACENTER, 0.1268f, 0.05908f)
    NRDI_COST(REBLUR_SPECULAR_SH, FAST, DATACENTER, 0.1516f, 0.01757f)
    NRDI_COST(REBLUR_SPECULAR_SH, BALANCED, DATACENTER, 0.2027f, 0.01454f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_SH, FASTEST, DATACENTER, 0.2049f, 0.03667f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_SH, FAST, DATACENTER, 0.2441f, 0.01052f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_SH, BALANCED, DATACENTER, 0.3165f, 0.008892f)
    NRDI_COST(REFERENCE, BALANCED, DATACENTER, 0.01672f, 0.1304f)
    NRDI_COST(SIGMA_SHADOW, BALANCED, DATACENTER, 0.02452f, 0.001163f)
    NRDI_COST(SIGMA_SHADOW_TRANSLUCENCY, BALANCED, DATACENTER, 0.0367f, 0.00199f)
    NRDI_COST(REBLUR_DIFFUSE, FASTEST, CPU, 149.8f, 0.05523f)
    NRDI_COST(REBLUR_DIFFUSE, FAST, CPU, 160.7f, 0.01889f)
    NRDI_COST(REBLUR_DIFFUSE, BALANCED, CPU, 219.4f, 0.01878f)
    NRDI_COST(REBLUR_SPECULAR, FASTEST, CPU, 240.9f, 0.11f)
    NRDI_COST(REBLUR_SPECULAR, FAST, CPU, 248.5f, 0.04255f)
    NRDI_COST(REBLUR_SPECULAR, BALANCED, CPU, 303.4f, 0.03921f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR, FASTEST, CPU, 325.0f, 0.07788f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR, FAST, CPU, 341.1f, 0.02851f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR, BALANCED, CPU, 427.5f, 0.02736f)
    NRDI_COST(REBLUR_DIFFUSE_OCCLUSION, FASTEST, CPU, 99.83f, 0.02744f)
    NRDI_COST(REBLUR_DIFFUSE_OCCLUSION, FAST, CPU, 99.73f, 0.01074f)
    NRDI_COST(REBLUR_DIFFUSE_OCCLUSION, BALANCED, CPU, 99.67f, 0.009743f)
    NRDI_COST(REBLUR_SPECULAR_OCCLUSION, FASTEST, CPU, 120.7f, 0.05493f)
    NRDI_COST(REBLUR_SPECULAR_OCCLUSION, FAST, CPU, 120.7f, 0.03377f)
    NRDI_COST(REBLUR_SPECULAR_OCCLUSION, BALANCED, CPU, 135.1f, 0.03247f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_OCCLUSION, FASTEST, CPU, 175.6f, 0.03877f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_OCCLUSION, FAST, CPU, 176.1f, 0.01898f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_OCCLUSION, BALANCED, CPU, 175.9f, 0.01773f)
    NRDI_COST(REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, FASTEST, CPU, 123.2f, 0.02744f)
    NRDI_COST(REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, FAST, CPU, 125.4f, 0.01074f)
    NRDI_COST(REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, BALANCED, CPU, 135.2f, 0.009743f)
    NRDI_COST(REBLUR_DIFFUSE_SH, FASTEST, CPU, 191.3f, 0.05514f)
    NRDI_COST(REBLUR_DIFFUSE_SH, FAST, CPU, 210.6f, 0.01868f)
    NRDI_COST(REBLUR_DIFFUSE_SH, BALANCED, CPU, 276.9f, 0.01861f)
    NRDI_COST(REBLUR_SPECULAR_SH, FASTEST, CPU, 274.1f, 0.1096f)
    NRDI_COST(REBLUR_SPECULAR_SH, FAST, CPU, 291.8f, 0.04221f)
    NRDI_COST(REBLUR_SPECULAR_SH, BALANCED, CPU, 360.3f, 0.03892f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_SH, FASTEST, CPU, 408.7f, 0.0777f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_SH, FAST, CPU, 479.6f, 0.02824f)
    NRDI_COST(REBLUR_DIFFUSE_SPECULAR_SH, BALANCED, CPU, 511.6f, 0.02716f)
    NRDI_COST(REFERENCE, BALANCED, CPU, 13.03f, 0.09377f)
    NRDI_COST(SIGMA_SHADOW, BALANCED, CPU, 59.87f, 0.004122f)
    NRDI_COST(SIGMA_SHADOW_TRANSLUCENCY, BALANCED, CPU, 65.84f, 0.007989f)
    /* >>costs end */
};

nrd_result nrd_suggest(nrd_denoiser denoiser, nrd_device device, uint32_t width, uint32_t height, float budget_ms, nrd_suggestion *out)
{
    const nrdi_cost *best = NULL, *fastest = NULL;
    float allowed = budget_ms * 1e6f / ((float)width * (float)height);
    if (!out || !width || !height || !(budget_ms > 0) || (uint32_t)device >= NRD_DEVICE_COUNT) return NRD_RESULT_INVALID_ARGUMENT;
    for (size_t i = 0; i < sizeof nrdi_costs / sizeof nrdi_costs[0]; i++) {
        const nrdi_cost *c = &nrdi_costs[i];
        if (c->denoiser != denoiser || c->device != device) continue;
        if (!fastest || c->ns_per_pixel < fastest->ns_per_pixel) fastest = c;
        if (c->ns_per_pixel <= allowed && (!best || c->error < best->error)) best = c;
    }
    if (!best) best = fastest;
    if (!best) return NRD_RESULT_UNKNOWN_DENOISER;
    out->preset = best->preset;
    out->milliseconds = best->ns_per_pixel * (float)width * (float)height * 1e-6f;
    out->error = best->error;
    return NRD_RESULT_OK;
}

nrd_frame nrd_frame_defaults(void) { nrd_frame frame; nrd_settings_defaults(NRD_DENOISER_COUNT, &frame); return frame; }
nrd_reference_settings nrd_reference_defaults(void) { nrd_reference_settings s; nrd_settings_defaults(NRD_DENOISER_REFERENCE, &s); return s; }
nrd_reblur_settings nrd_reblur_defaults(void) { nrd_reblur_settings s; nrd_settings_defaults(NRD_DENOISER_REBLUR_DIFFUSE, &s); return s; }
nrd_occlusion_settings nrd_occlusion_defaults(void) { nrd_occlusion_settings s; nrd_settings_defaults(NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, &s); return s; }
nrd_sigma_settings nrd_sigma_defaults(void) { nrd_sigma_settings s; nrd_settings_defaults(NRD_DENOISER_SIGMA_SHADOW, &s); return s; }

/* ---------------------------------------------------------------------------------------------------------------------------
   Instance  >>state */
typedef struct nrdi_state {         /* one denoiser of an instance */
    const nrdi_denoiser_row *row;
    nrd_denoiser denoiser;
    uint32_t identifier, texture_base, pass_base, pass_count;
    uint32_t first_texture[NRDI_MAX_TEXTURES]; /* index into nrd_info.textures; a ping-pong pair has two in a row */
    uint32_t parity;
    uint32_t history_frames;        /* frames in history, REFERENCE's n */
    uint32_t last_frame_index;
    bool has_history;
    bool had_antilag;               /* in the last frame: the tiles hold its lighting changes */
    bool reads_old;                 /* this frame is the first of another size: what it has not written yet lies in the textures of the former */
    uint32_t period;                /* nrd.period of the last dispatches */
    uint64_t written;               /* in this frame: bit 2 * texture of the row + half of a ping-pong pair */
    union { nrd_reference_settings reference; nrd_reblur_settings reblur; nrd_occlusion_settings occlusion; nrd_sigma_settings sigma; } settings;
    nrd_sigma_settings light, light_before; /* of the frame with the index light_frame, and of the one before it */
    uint32_t light_frame;
    nrd_constants constants;
} nrdi_state;

typedef struct nrdi_live_pass { const nrdi_pass_row *row; uint32_t state, pipeline; } nrdi_live_pass;

/* Consecutive frames of one size. */
typedef struct nrdi_period { uint32_t number, width, height, width_before, height_before; } nrdi_period;

enum { NRDI_ALIVE = 0x6e726431, NRDI_DEAD = 0x64656164 };

struct nrd {
    uint32_t alive;                 /* NRDI_ALIVE */
    nrd_desc desc;
    nrd_info info;
    nrd_denoiser_desc *denoisers;
    nrdi_state *states;
    nrdi_state *states_before;      /* the last nrd_get_dispatches, for nrd_cancel_dispatches */
    nrd_texture *textures;
    nrd_pipeline *pipelines;
    nrd_pass *passes;
    nrdi_live_pass *live;           /* per pass of info.passes */
    nrd_left_out *left_out;
    nrd_block *blocks;
    nrd_access *accesses;           /* NRDI_MAX_USES per pipeline */
    nrd_binding *bindings;          /* NRDI_MAX_USES per pass */
    nrd_dispatch *dispatches;
    nrd_frame frame, last;          /* last: of the previous frame_index */
    nrd_camera camera_prev;
    uint32_t rect_prev[2];
    float range_prev;
    bool frame_set, frame_restart, has_last;
    uint32_t frame_size[2];         /* nrd_desc.width, height when the frame was set */
    nrdi_period period, period_before;
};

static nrd_result nrdi_check_alive(const nrd *n)
{
    if (!n) return NRD_RESULT_INVALID_ARGUMENT;
    return n->alive == NRDI_ALIVE ? NRD_RESULT_OK : NRD_RESULT_DESTROYED;
}

/* Bit in nrdi_state.written. */
static uint64_t nrdi_written_bit(const nrdi_state *s, uint32_t what)
{
    bool previous = what >= NRDI_PREVIOUS(0);
    uint32_t index = what - (previous ? NRDI_PREVIOUS(0) : NRDI_TEXTURE(0));
    return (uint64_t)1 << (2 * index + (s->parity ^ (previous ? 1u : 0u)));
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Messages  >>messages */
typedef struct nrdi_text { char s[400]; size_t n; } nrdi_text;

static void nrdi_put(nrdi_text *t, const char *s)
{
    while (*s && t->n + 1 < sizeof t->s) t->s[t->n++] = *s++;
    t->s[t->n] = 0;
}

static void nrdi_put_uint(nrdi_text *t, uint64_t v)
{
    char digits[24];
    size_t n = sizeof digits;
    digits[--n] = 0;
    do digits[--n] = (char)('0' + v % 10); while ((v /= 10) != 0);
    nrdi_put(t, digits + n);
}

/* Six significant digits, without stdio. */
static void nrdi_put_number(nrdi_text *t, double v)
{
    if (v != v) { nrdi_put(t, "NaN"); return; }
    if (v < 0) { nrdi_put(t, "-"); v = -v; }
    if (v > 1e300) { nrdi_put(t, "infinity"); return; }
    int exponent = 0;
    if (v > 0 && (v >= 1e7 || v < 1e-4)) {
        exponent = (int)floor(log10(v));
        v /= pow(10, exponent);
    }
    uint64_t scaled = (uint64_t)(v * 1e6 + 0.5);
    nrdi_put_uint(t, scaled / 1000000);
    uint32_t fraction = (uint32_t)(scaled % 1000000), place = 100000;
    if (fraction) nrdi_put(t, ".");
    for (; fraction; place /= 10) { nrdi_put_uint(t, fraction / place); fraction %= place; }
    if (!exponent) return;
    nrdi_put(t, exponent < 0 ? "e-" : "e");
    nrdi_put_uint(t, (uint64_t)(exponent < 0 ? -exponent : exponent));
}

static nrd_result nrdi_tell(const nrd_desc *desc, nrd_severity severity, nrd_result result, const char *text)
{
    if (desc->message) desc->message(desc->message_user, severity, result, text);
    return result;
}

nrd_result nrd_report(const nrd *instance, nrd_severity severity, nrd_result result, const char *text)
{
    return nrdi_check_alive(instance) ? result : nrdi_tell(&instance->desc, severity, result, text);
}

static nrd_result nrdi_invalid(const nrd_desc *desc, const char *text) { return nrdi_tell(desc, NRD_SEVERITY_ERROR, NRD_RESULT_INVALID_ARGUMENT, text); }

static nrd_result nrdi_out_of_range(const nrd_desc *desc, const char *owner, const char *name, double value, double min, double max)
{
    nrdi_text t = { { 0 }, 0 };
    nrdi_put(&t, owner); nrdi_put(&t, "."); nrdi_put(&t, name);
    nrdi_put(&t, " is "); nrdi_put_number(&t, value);
    nrdi_put(&t, ", allowed: "); nrdi_put_number(&t, min); nrdi_put(&t, " to "); nrdi_put_number(&t, max);
    return nrdi_invalid(desc, t.s);
}

static nrd_result nrdi_check_range(const nrd_desc *desc, const char *owner, const char *name, double value, double min, double max)
{
    return value >= min && value <= max ? NRD_RESULT_OK : nrdi_out_of_range(desc, owner, name, value, min, max);
}

static nrd_result nrdi_check_version(const nrd_desc *d)
{
    nrdi_text t = { { 0 }, 0 };
    if (!d->struct_version || d->struct_version == NRD_STRUCT_VERSION) return NRD_RESULT_OK;
    nrdi_put(&t, "nrd_desc.struct_version is "); nrdi_put_uint(&t, d->struct_version);
    nrdi_put(&t, " (release "); nrdi_put_uint(&t, d->struct_version >> 16);
    nrdi_put(&t, "), needed is "); nrdi_put_uint(&t, NRD_STRUCT_VERSION);
    nrdi_put(&t, " (release "); nrdi_put_uint(&t, NRD_RELEASE_NUMBER); nrdi_put(&t, ")");
    return nrdi_tell(d, NRD_SEVERITY_ERROR, NRD_RESULT_WRONG_VERSION, t.s);
}

static double nrdi_setting_value(const nrd_setting *row, const void *settings)
{
    float f;
    uint32_t u;
    memcpy(&f, (const char *)settings + row->offset, 4);
    memcpy(&u, (const char *)settings + row->offset, 4);
    return row->is_float ? (double)f : (double)u;
}

static nrd_result nrdi_check_settings(const nrd_desc *desc, const char *owner, nrdi_settings_list list, const void *settings)
{
    for (uint32_t i = 0; i < list.count; i++) {
        const nrd_setting *row = &list.rows[i];
        nrd_result r = nrdi_check_range(desc, owner, row->name, nrdi_setting_value(row, settings), row->min, row->max);
        if (r) return r;
    }
    return NRD_RESULT_OK;
}

static nrd_result nrdi_needs_feature(const nrd_desc *desc, const char *field, uint32_t feature, const char *feature_name)
{
    if (desc->features & feature) return NRD_RESULT_OK;
    nrdi_text t = { { 0 }, 0 };
    nrdi_put(&t, field); nrdi_put(&t, " is set, but nrd_desc.features lacks "); nrdi_put(&t, feature_name);
    return nrdi_invalid(desc, t.s);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Graph  >>graph */
/* What a condition needs: never: the declaration that rules it out for good; now: why it can be off in a frame, NULL: it is never off. */
typedef struct nrdi_reason { uint32_t condition, feature, absent; const char *never, *now; } nrdi_reason;
static const nrdi_reason nrdi_reasons[] = {
#define NRDI_LACKS(feature) NRD_FEATURE_##feature, 0, "nrd_desc.features lacks NRD_FEATURE_" #feature
#define NRDI_RULED_OUT(absence) 0, NRD_ABSENT_##absence, "nrd_desc.absent has NRD_ABSENT_" #absence
    { NRDI_IF_PREPASS, NRDI_LACKS(PREPASS), "diffuse_prepass_blur_radius is 0" },
    { NRDI_IF_SPEC_PREPASS, NRDI_LACKS(PREPASS), "specular_prepass_blur_radius is 0" },
    { NRDI_IF_SPLIT, NRDI_LACKS(SPLIT_SCREEN), "nrd_frame.split_screen is 0" },
    { NRDI_IF_CHECK, NRDI_LACKS(CHECK), NULL },
    { NRDI_IF_VALIDATION, NRDI_LACKS(VALIDATION), "nrd_frame.validation does not name this denoiser" },
    { NRDI_IF_CONFIDENCE, NRDI_LACKS(HISTORY_CONFIDENCE), "nrd_frame.history_confidence_available is 0" },
    { NRDI_IF_THRESHOLD_MIX, NRDI_LACKS(DISOCCLUSION_THRESHOLD_MIX), "nrd_frame.disocclusion_threshold_mix_available is 0" },
    { NRDI_IF_RECONSTRUCTION, NRDI_LACKS(HIT_DISTANCE_RECONSTRUCTION), "hit_distance_reconstruction is 0" },
    { NRDI_IF_SPECULAR_MOTION, NRDI_LACKS(SPECULAR_MOTION), "nrd_frame.specular_motion is 0" },
    { NRDI_IF_ROUGHNESS_LIMIT, NRDI_LACKS(ROUGHNESS_LIMIT), "specular_roughness_limit is 0" },
    { NRDI_IF_BLUR, NRDI_RULED_OUT(BLUR), "max_blur_radius is 0 (or performance_mode is 2)" },
    { NRDI_IF_ANTILAG, NRDI_RULED_OUT(LIGHTING_CHANGE), "antilag_sensitivity is 0" },
    { NRDI_IF_SKY, NRDI_RULED_OUT(SKY), NULL },
    { NRDI_IF_MOTION, NRDI_RULED_OUT(MOTION), NULL },
    { NRDI_IF_STABILIZED, NRDI_RULED_OUT(STABILIZATION), NULL },
#undef NRDI_LACKS
#undef NRDI_RULED_OUT
};
enum { NRDI_REASON_COUNT = sizeof nrdi_reasons / sizeof nrdi_reasons[0] };

/* The conditions that what is declared leaves open. */
static uint32_t nrdi_possible(const nrd_desc *desc)
{
    uint32_t possible = ~0u;
    for (uint32_t i = 0; i < NRDI_REASON_COUNT; i++) {
        const nrdi_reason *r = &nrdi_reasons[i];
        if ((r->feature && !(desc->features & r->feature)) || (desc->absent & r->absent)) possible &= ~r->condition;
    }
    return possible;
}

static const nrdi_reason *nrdi_reason_of(uint32_t condition)
{
    for (uint32_t i = 0; i < NRDI_REASON_COUNT; i++)
        if (nrdi_reasons[i].condition & condition) return &nrdi_reasons[i];
    return NULL;
}

static bool nrdi_holds(uint32_t condition, uint32_t on) { return !condition || (condition & on) != 0; }

/* A denoiser of both signals, one of which is absent, is the denoiser of the other. */
typedef struct nrdi_reduction { nrd_denoiser whole; uint32_t absent; nrd_denoiser rest; } nrdi_reduction;
static const nrdi_reduction nrdi_reductions[] = {
    { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_ABSENT_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE },
    { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_ABSENT_DIFFUSE, NRD_DENOISER_REBLUR_SPECULAR },
    { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, NRD_ABSENT_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION },
    { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, NRD_ABSENT_DIFFUSE, NRD_DENOISER_REBLUR_SPECULAR_OCCLUSION },
    { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_SH, NRD_ABSENT_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE_SH },
    { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_SH, NRD_ABSENT_DIFFUSE, NRD_DENOISER_REBLUR_SPECULAR_SH },
};

static nrd_denoiser nrdi_reduce(nrd_denoiser denoiser, uint32_t absent)
{
    for (size_t i = 0; i < sizeof nrdi_reductions / sizeof nrdi_reductions[0]; i++)
        if (nrdi_reductions[i].whole == denoiser && (nrdi_reductions[i].absent & absent)) return nrdi_reductions[i].rest;
    return denoiser;
}

/* Passes of a denoiser that are of use: those that write what the app gets or what survives the frame, and those that feed them. */
static uint32_t nrdi_useful_passes(const nrdi_denoiser_row *row, uint32_t enabled)
{
    uint32_t useful = 0, wanted_textures = 0, pass_count = nrdi_pass_count(row);
    for (uint32_t i = 0; i < NRDI_MAX_TEXTURES; i++)
        if (nrdi_texture_of(row, i)->kind != NRDI_TRANSIENT) wanted_textures |= 1u << i;
    for (uint32_t p = pass_count; p-- > 0;) {
        const nrdi_pass_row *pass = &row->passes[p];
        uint32_t uses = nrdi_use_count(pass);
        bool useful_pass = false;
        if (!(enabled & (1u << p))) continue;
        for (uint32_t u = 0; u < uses; u++) {
            if (pass->uses[u].access != NRD_ACCESS_WRITE) continue;
            uint32_t what = pass->uses[u].what;
            useful_pass |= what < NRD_RESOURCE_COUNT || what >= NRDI_PREVIOUS(0) || (wanted_textures >> (what - NRDI_TEXTURE(0)) & 1u);
        }
        if (!useful_pass) continue;
        useful |= 1u << p;
        for (uint32_t u = 0; u < uses; u++)
            if (pass->uses[u].access != NRD_ACCESS_WRITE && pass->uses[u].what >= NRDI_TEXTURE(0) && pass->uses[u].what < NRDI_PREVIOUS(0))
                wanted_textures |= 1u << (pass->uses[u].what - NRDI_TEXTURE(0));
    }
    return useful;
}

static uint32_t nrdi_declared_passes(const nrdi_denoiser_row *row, const nrd_desc *desc)
{
    uint32_t enabled = 0, possible = nrdi_possible(desc);
    for (uint32_t p = 0; p < nrdi_pass_count(row); p++) {
        const nrdi_pass_row *pass = &row->passes[p];
        if ((!pass->feature || (desc->features & pass->feature)) && nrdi_holds(pass->condition, possible)) enabled |= 1u << p;
    }
    return nrdi_useful_passes(row, enabled);
}

static const char *nrdi_why_never(const nrdi_pass_row *pass, uint32_t possible)
{
    const nrdi_reason *r = nrdi_holds(pass->condition, possible) ? NULL : nrdi_reason_of(pass->condition);
    return r ? r->never : "nothing that is left reads its result";
}

static bool nrdi_is_use_of(const nrdi_use *use, uint32_t texture) { return use->what == NRDI_TEXTURE(texture) || use->what == NRDI_PREVIOUS(texture); }

static bool nrdi_pass_uses(const nrdi_pass_row *pass, uint32_t texture)
{
    for (uint32_t u = 0; u < nrdi_use_count(pass); u++)
        if (nrdi_is_use_of(&pass->uses[u], texture)) return true;
    return false;
}

/* Is it bound to the pass in any frame, itself or as a stand-in? */
static bool nrdi_pass_binds(const nrdi_pass_row *pass, uint32_t texture, uint32_t possible)
{
    for (uint32_t u = 0; u < nrdi_use_count(pass); u++) {
        const nrdi_use *use = &pass->uses[u];
        uint32_t stand_in = use->condition ? use->stand_in : use->what;
        if (stand_in == NRDI_TEXTURE(texture) || stand_in == NRDI_PREVIOUS(texture)) return true;
        if (nrdi_holds(use->condition, possible) && nrdi_is_use_of(use, texture)) return true;
    }
    return false;
}

/* The condition that all uses of a texture need, if it is ruled out; else NULL. Where such a texture is its own stand-in, one texel of it
   stays for the binding. */
static const nrdi_reason *nrdi_ruled_out(const nrdi_denoiser_row *row, uint32_t passes, uint32_t texture, uint32_t possible)
{
    const nrdi_reason *why = NULL;
    for (uint32_t p = 0; p < nrdi_pass_count(row); p++)
        for (uint32_t u = 0; (passes >> p & 1u) && u < nrdi_use_count(&row->passes[p]); u++) {
            const nrdi_use *use = &row->passes[p].uses[u];
            if (!nrdi_is_use_of(use, texture)) continue;
            if (nrdi_holds(use->condition, possible)) return NULL;
            why = nrdi_reason_of(use->condition);
        }
    return why;
}

static uint64_t nrdi_texture_bytes(const nrd_desc *desc, const nrdi_texture_row *row)
{
    uint64_t texels = row->kind == NRDI_BUFFERS ? NRDI_GROUP_WORDS : NRD_COUNTER_COUNT;
    if (row->divisor) texels = (uint64_t)((desc->width + row->divisor - 1u) / row->divisor) * ((desc->height + row->divisor - 1u) / row->divisor);
    return texels * nrd_format_bytes(row->format) * nrdi_halves(row);
}

static void nrdi_leave_out(nrd *n, const char *what, const char *why, uint64_t bytes)
{
    nrd_left_out left = { what, why, bytes };
    n->left_out[n->info.left_out_count++] = left;
}

uint64_t nrd_place_blocks(nrd_block *blocks, uint32_t count)
{
    uint64_t total = 0;
    for (uint32_t i = 0; i < count; i++) blocks[i].offset = UINT64_MAX;
    for (uint32_t placed = 0; placed < count; placed++) {
        nrd_block *big = NULL;   /* largest first leaves the fewest holes */
        for (uint32_t i = 0; i < count; i++)
            if (blocks[i].offset == UINT64_MAX && (!big || blocks[i].bytes > big->bytes)) big = &blocks[i];
        uint64_t alignment = big->alignment ? big->alignment : 1, at = 0;
        for (bool moved = true; moved;) {
            moved = false;
            for (uint32_t i = 0; i < count; i++) {
                const nrd_block *b = &blocks[i];
                if (b->offset == UINT64_MAX || b->last < big->first || b->first > big->last) continue;
                if (at + big->bytes <= b->offset || at >= b->offset + b->bytes) continue;
                at = (b->offset + b->bytes + alignment - 1) / alignment * alignment;
                moved = true;
            }
        }
        big->offset = at;
        if (at + big->bytes > total) total = at + big->bytes;
    }
    return total;
}

static void nrdi_add_texture(nrd *n, nrdi_state *s, uint32_t index)
{
    const nrdi_texture_row *row = nrdi_texture_of(s->row, index);
    nrd_texture t;
    memset(&t, 0, sizeof t);
    t.first_pass = UINT32_MAX;
    for (uint32_t p = 0; p < s->pass_count; p++) {
        if (!nrdi_pass_binds(n->live[s->pass_base + p].row, index, nrdi_possible(&n->desc))) continue;
        if (t.first_pass == UINT32_MAX) t.first_pass = s->pass_base + p;
        t.last_pass = s->pass_base + p;
    }
    if (t.first_pass == UINT32_MAX) return;   /* nobody that is left needs it */
    const nrdi_reason *ruled_out = nrdi_ruled_out(s->row, nrdi_declared_passes(s->row, &n->desc), index, nrdi_possible(&n->desc));
    t.name = row->name;
    t.denoiser = (uint32_t)(s - n->states);
    t.format = row->format;
    t.width = ruled_out ? 1u : row->divisor ? (n->desc.width + row->divisor - 1u) / row->divisor : NRD_COUNTER_COUNT;
    t.height = ruled_out || !row->divisor ? 1u : (n->desc.height + row->divisor - 1u) / row->divisor;
    t.buffer = row->kind == NRDI_BUFFERS;
    if (t.buffer) t.width = NRDI_GROUP_WORDS;
    t.read_back = index == NRDI_COUNTERS;
    t.permanent = row->kind != NRDI_TRANSIENT;
    t.bytes = (uint64_t)t.width * t.height * nrd_format_bytes(row->format);
    if (ruled_out) nrdi_leave_out(n, row->name, ruled_out->never, nrdi_texture_bytes(&n->desc, row) - t.bytes);
    s->first_texture[index] = n->info.texture_count;
    for (uint32_t k = 0; k < nrdi_halves(row); k++) n->textures[n->info.texture_count++] = t;
}

static uint32_t nrdi_find_pipeline(nrd *n, const nrdi_pass_row *pass)
{
    uint32_t i = 0;
    while (i < n->info.pipeline_count && (strcmp(n->pipelines[i].shader, pass->shader) != 0 || n->pipelines[i].spec_constants[4] != pass->iteration)) i++;
    if (i < n->info.pipeline_count) return i;
    nrd_pipeline *p = &n->pipelines[n->info.pipeline_count++];
    nrd_access *access = n->accesses + (size_t)i * NRDI_MAX_USES;
    p->shader = pass->shader;
    p->binding_count = nrdi_use_count(pass);
    p->access = access;
    for (uint32_t u = 0; u < p->binding_count; u++) access[u] = (nrd_access)pass->uses[u].access;
    p->spec_constants[0] = n->desc.normal_encoding;
    p->spec_constants[1] = n->desc.roughness_encoding;
    p->spec_constants[2] = n->desc.features;
    p->spec_constants[3] = n->desc.absent;
    p->spec_constants[4] = pass->iteration;
    if (p->binding_count > n->info.max_bindings) n->info.max_bindings = p->binding_count;
    return i;
}

/* Bytes of the textures that only this pass and others that are left out would use. */
static uint64_t nrdi_saved_bytes(const nrd *n, const nrdi_denoiser_row *row, uint32_t pass, uint32_t useful)
{
    uint64_t bytes = 0;
    for (uint32_t t = 0; t < NRDI_MAX_TEXTURES; t++) {
        const nrdi_texture_row *r = nrdi_texture_of(row, t);
        bool needed = !nrdi_pass_uses(&row->passes[pass], t);
        for (uint32_t p = 0; p < nrdi_pass_count(row); p++) needed |= (useful >> p & 1u) && nrdi_pass_binds(&row->passes[p], t, nrdi_possible(&n->desc));
        bytes += needed ? 0 : nrdi_texture_bytes(&n->desc, r);
    }
    return bytes;
}

static void nrdi_add_passes(nrd *n, nrdi_state *s)
{
    uint32_t index = (uint32_t)(s - n->states), useful = nrdi_declared_passes(s->row, &n->desc);
    s->pass_base = n->info.pass_count;
    for (uint32_t p = 0; p < nrdi_pass_count(s->row); p++) {
        const nrdi_pass_row *row = &s->row->passes[p];
        if (!(useful & (1u << p))) {
            nrdi_leave_out(n, row->name, nrdi_why_never(row, nrdi_possible(&n->desc)), nrdi_saved_bytes(n, s->row, p, useful));
            continue;
        }
        nrdi_live_pass live = { row, index, nrdi_find_pipeline(n, row) };
        nrd_pass pass = { row->name, index, live.pipeline };
        n->live[n->info.pass_count] = live;
        n->passes[n->info.pass_count++] = pass;
    }
    s->pass_count = n->info.pass_count - s->pass_base;
}

static void nrdi_measure(nrd *n)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < n->info.texture_count; i++) {
        const nrd_texture *t = &n->textures[i];
        nrd_block block = { t->bytes, 256, t->first_pass, t->last_pass, 0 };
        if (t->permanent) n->info.permanent_bytes += t->bytes;
        else { n->blocks[count++] = block; n->info.transient_unshared_bytes += t->bytes; }
    }
    n->info.transient_bytes = nrd_place_blocks(n->blocks, count);
    count = 0;
    for (uint32_t i = 0; i < n->info.texture_count; i++)
        if (!n->textures[i].permanent) n->textures[i].offset = n->blocks[count++].offset;
}

static void nrdi_compile(nrd *n)
{
    memset(&n->info, 0, sizeof n->info);
    for (uint32_t i = 0; i < n->desc.denoiser_count; i++) {
        nrdi_state *s = &n->states[i];
        n->denoisers[i] = n->desc.denoisers[i];
        s->denoiser = n->denoisers[i].denoiser;
        s->identifier = n->denoisers[i].identifier;
        s->row = nrdi_row_of(nrdi_reduce(s->denoiser, n->desc.absent));
        nrd_settings_defaults(s->denoiser, &s->settings);
        nrdi_add_passes(n, s);
        for (uint32_t t = 0; t < NRDI_MAX_TEXTURES; t++) nrdi_add_texture(n, s, t);
    }
    nrdi_measure(n);
    n->info.width = n->desc.width;
    n->info.height = n->desc.height;
    n->info.textures = n->textures;
    n->info.pipelines = n->pipelines;
    n->info.passes = n->passes;
    n->info.left_out = n->left_out;
    n->info.denoisers = n->denoisers;
    n->info.denoiser_count = n->desc.denoiser_count;
    n->info.constant_bytes = (uint32_t)sizeof(nrd_constants);
    n->desc.denoisers = n->denoisers;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Create  >>create */
static nrd_result nrdi_check_compiled_in(const nrd_desc *d, nrd_denoiser denoiser)
{
    if (nrdi_row_of(denoiser)) return NRD_RESULT_OK;
    nrdi_text t = { { 0 }, 0 };
    nrdi_put(&t, "nrd_desc.denoisers[].denoiser: this build has no "); nrdi_put(&t, nrd_denoiser_name(denoiser));
    nrdi_put(&t, ", see its NRD_ONLY_ and NRD_NO_ macros");
    return nrdi_tell(d, NRD_SEVERITY_ERROR, NRD_RESULT_UNKNOWN_DENOISER, t.s);
}

static nrd_result nrdi_check_unique(const nrd_desc *d, uint32_t i)
{
    nrdi_text t = { { 0 }, 0 };
    uint32_t k = 0;
    while (d->denoisers[k].identifier != d->denoisers[i].identifier) k++;
    if (k == i) return NRD_RESULT_OK;
    nrdi_put(&t, "nrd_desc.denoisers: identifier "); nrdi_put_uint(&t, d->denoisers[i].identifier); nrdi_put(&t, " appears twice");
    return nrdi_tell(d, NRD_SEVERITY_ERROR, NRD_RESULT_DUPLICATE_IDENTIFIER, t.s);
}

static nrd_result nrdi_check_desc(const nrd_desc *d)
{
    nrd_result r = nrdi_check_version(d);
    if (r) return r;
    if ((r = nrdi_check_range(d, "nrd_desc", "width", d->width, 1, NRDI_MAX_SIZE))) return r;
    if ((r = nrdi_check_range(d, "nrd_desc", "height", d->height, 1, NRDI_MAX_SIZE))) return r;
    if ((r = nrdi_check_range(d, "nrd_desc", "denoiser_count", d->denoiser_count, 1, 64))) return r;
    if ((r = nrdi_check_range(d, "nrd_desc", "features", d->features, 0, NRD_FEATURE_ALL))) return r;
    if ((r = nrdi_check_range(d, "nrd_desc", "absent", d->absent, 0, NRD_ABSENT_ALL))) return r;
    if ((d->absent & NRD_ABSENT_DIFFUSE) && (d->absent & NRD_ABSENT_SPECULAR))
        return nrdi_invalid(d, "nrd_desc.absent has NRD_ABSENT_DIFFUSE and NRD_ABSENT_SPECULAR: one of both signals must be left");
    if ((r = nrdi_check_range(d, "nrd_desc", "normal_encoding", d->normal_encoding, 0, NRD_NORMAL_FORMAT_RGBA16_SNORM))) return r;
    if ((r = nrdi_check_range(d, "nrd_desc", "roughness_encoding", d->roughness_encoding, 0, NRD_ROUGHNESS_FORMAT_SQRT_LINEAR))) return r;
    if (!d->denoisers) return nrdi_invalid(d, "nrd_desc.denoisers is NULL");
    if (!d->allocate != !d->release) return nrdi_invalid(d, "nrd_desc.allocate and .release must both be set, or neither");
    for (uint32_t i = 0; i < d->denoiser_count; i++) {
        if ((r = nrdi_check_range(d, "nrd_desc", "denoisers[].denoiser", d->denoisers[i].denoiser, 0, NRD_DENOISER_COUNT - 1))) return r;
        if ((r = nrdi_check_compiled_in(d, nrdi_reduce(d->denoisers[i].denoiser, d->absent)))) return r;
        if ((r = nrdi_check_unique(d, i))) return r;
    }
    return NRD_RESULT_OK;
}

/* Hands out arrays of one block; with base NULL it only counts. */
static void *nrdi_carve(char *base, size_t *used, size_t count, size_t size)
{
    size_t at = (*used + 15) & ~(size_t)15;
    *used = at + count * size;
    return base ? base + at : NULL;
}

static size_t nrdi_lay_out(nrd *n, char *base, size_t denoisers)
{
    size_t used = sizeof(nrd), passes = denoisers * NRDI_MAX_PASSES;
#define NRDI_CARVE(member, type, count) n->member = (type *)nrdi_carve(base, &used, count, sizeof(type))
    NRDI_CARVE(denoisers, nrd_denoiser_desc, denoisers);
    NRDI_CARVE(states, nrdi_state, denoisers);
    NRDI_CARVE(states_before, nrdi_state, denoisers);
    NRDI_CARVE(textures, nrd_texture, denoisers * NRDI_MAX_TEXTURES * 2);
    NRDI_CARVE(blocks, nrd_block, denoisers * NRDI_MAX_TEXTURES * 2);
    NRDI_CARVE(pipelines, nrd_pipeline, passes);
    NRDI_CARVE(passes, nrd_pass, passes);
    NRDI_CARVE(live, nrdi_live_pass, passes);
    NRDI_CARVE(left_out, nrd_left_out, passes + denoisers * NRDI_MAX_TEXTURES);
    NRDI_CARVE(accesses, nrd_access, passes * NRDI_MAX_USES);
    NRDI_CARVE(bindings, nrd_binding, passes * NRDI_MAX_USES);
    NRDI_CARVE(dispatches, nrd_dispatch, passes);
#undef NRDI_CARVE
    return used;
}

nrd_result nrd_create(const nrd_desc *desc, nrd **out)
{
    nrd counting;
    if (!desc) return NRD_RESULT_INVALID_ARGUMENT;
    if (!out) return nrdi_invalid(desc, "nrd_create: out is NULL");
    nrd_result r = nrdi_check_desc(desc);
    if (r) return r;
    size_t bytes = nrdi_lay_out(&counting, NULL, desc->denoiser_count);
    char *memory = (char *)(desc->allocate ? desc->allocate(desc->allocate_user, bytes) : NRD_MALLOC(bytes));
    if (!memory) return nrdi_tell(desc, NRD_SEVERITY_ERROR, NRD_RESULT_OUT_OF_MEMORY, "nrd_create: the allocator returned NULL");
    memset(memory, 0, bytes);
    nrd *n = (nrd *)memory;
    nrdi_lay_out(n, memory, desc->denoiser_count);
    n->alive = NRDI_ALIVE;
    n->desc = *desc;
    if (desc->features & NRD_FEATURE_ROUGHNESS_LIMIT) n->desc.absent &= ~(uint32_t)NRD_ABSENT_SKY;   /* pixels without a signal are marked as those */
    nrdi_compile(n);
    *out = n;
    return NRD_RESULT_OK;
}

nrd_result nrd_resize(nrd *n, uint32_t width, uint32_t height)
{
    nrd_result r = nrdi_check_alive(n);
    if (r || (r = nrdi_check_range(&n->desc, "nrd_resize", "width", width, 1, NRDI_MAX_SIZE))) return r;
    if ((r = nrdi_check_range(&n->desc, "nrd_resize", "height", height, 1, NRDI_MAX_SIZE))) return r;
    n->desc.width = width;
    n->desc.height = height;
    memcpy(n->states_before, n->states, n->info.denoiser_count * sizeof *n->states);
    nrdi_compile(n);
    for (uint32_t i = 0; i < n->info.denoiser_count; i++) n->states[i].settings = n->states_before[i].settings;
    return NRD_RESULT_OK;
}

void nrd_destroy(nrd *instance)
{
    if (nrdi_check_alive(instance)) return;
    *(volatile uint32_t *)&instance->alive = NRDI_DEAD;   /* or the compiler drops it */
    if (instance->desc.release) instance->desc.release(instance->desc.allocate_user, instance);
    else NRD_FREE(instance);
}

const nrd_info *nrd_get_info(const nrd *instance) { return nrdi_check_alive(instance) ? NULL : &instance->info; }

bool nrd_uses_resource(const nrd *instance, nrd_resource resource)
{
    if (nrdi_check_alive(instance)) return false;
    for (uint32_t p = 0; p < instance->info.pass_count; p++) {
        const nrdi_pass_row *row = instance->live[p].row;
        for (uint32_t u = 0; u < nrdi_use_count(row); u++) {
            if (row->uses[u].what == (uint32_t)resource && nrdi_holds(row->uses[u].condition, nrdi_possible(&instance->desc))) return true;
            if (row->uses[u].condition && row->uses[u].stand_in == (uint32_t)resource) return true;
        }
    }
    return false;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Frame and settings  >>frame */
static nrd_result nrdi_check_camera(const nrd_desc *d, const nrd_camera *c, const char *owner)
{
    nrdi_text t = { { 0 }, 0 };
    const float *p = c->view_to_clip, *w = c->world_to_view;
    const char *wrong = NULL;
    for (int i = 0; i < 16; i++)
        if (!(fabsf(p[i]) <= 3e38f) || !(fabsf(w[i]) <= 3e38f)) wrong = !(fabsf(p[i]) <= 3e38f) ? ".view_to_clip holds NaN or infinity" : ".world_to_view holds NaN or infinity";
    for (int i = 0; i < 3 && !wrong; i++)
        for (int k = i; k < 3; k++) {
            float dot = w[i] * w[k] + w[4 + i] * w[4 + k] + w[8 + i] * w[8 + k];
            if (!(fabsf(dot - (i == k ? 1.0f : 0.0f)) < 0.01f)) wrong = ".world_to_view is not a rotation and a translation";
        }
    if (!wrong && (w[3] != 0 || w[7] != 0 || w[11] != 0 || w[15] != 1)) wrong = ".world_to_view has a last row other than 0 0 0 1: is it transposed? (column-major, column vectors)";
    if (!wrong && (p[0] == 0 || p[5] == 0 || !((fabsf(p[11]) == 1 && p[15] == 0) || (p[11] == 0 && p[15] == 1)))) wrong = ".view_to_clip is no projection (column-major, column vectors)";
    if (!wrong && p[11] == 0 && p[10] == 0) wrong = ".view_to_clip has no depth";
    if (!wrong) {
        nrd_result r = nrdi_check_range(d, owner, "jitter[0]", c->jitter[0], -0.5, 0.5);
        return r ? r : nrdi_check_range(d, owner, "jitter[1]", c->jitter[1], -0.5, 0.5);
    }
    nrdi_put(&t, owner);
    nrdi_put(&t, wrong);
    return nrdi_invalid(d, t.s);
}

static nrd_result nrdi_check_frame(const nrd *n, const nrd_frame *f, uint32_t width, uint32_t height)
{
    const nrd_desc *d = &n->desc;
    nrd_result r = nrdi_check_settings(d, "nrd_frame", nrdi_list_of(NRD_DENOISER_COUNT), f);
    if (r || (r = nrdi_check_camera(d, &f->camera, "nrd_frame.camera"))) return r;
    if (f->camera_prev && (r = nrdi_check_camera(d, f->camera_prev, "nrd_frame.camera_prev"))) return r;
    if ((r = nrdi_check_range(d, "nrd_frame", "clip_y", f->clip_y, 0, NRD_CLIP_Y_DOWN))) return r;
    if ((r = nrdi_check_range(d, "nrd_frame", "rect_width", width, 1, d->width))) return r;
    if ((r = nrdi_check_range(d, "nrd_frame", "rect_height", height, 1, d->height))) return r;
    if ((r = nrdi_check_range(d, "nrd_frame", "rect_origin_x", f->rect_origin_x, 0, d->width - width))) return r;
    if ((r = nrdi_check_range(d, "nrd_frame", "rect_origin_y", f->rect_origin_y, 0, d->height - height))) return r;
    if (f->split_screen > 0 && (r = nrdi_needs_feature(d, "nrd_frame.split_screen", NRD_FEATURE_SPLIT_SCREEN, "NRD_FEATURE_SPLIT_SCREEN"))) return r;
    if ((r = nrdi_check_range(d, "nrd_frame", "validation", f->validation, 0, d->denoiser_count))) return r;
    if (f->validation && (r = nrdi_needs_feature(d, "nrd_frame.validation", NRD_FEATURE_VALIDATION, "NRD_FEATURE_VALIDATION"))) return r;
    if (f->history_confidence_available && (r = nrdi_needs_feature(d, "nrd_frame.history_confidence_available", NRD_FEATURE_HISTORY_CONFIDENCE, "NRD_FEATURE_HISTORY_CONFIDENCE"))) return r;
    bool materials = f->strand_material_id < 4 || f->camera_attached_reflection_material_id < 4;
    if (materials && (r = nrdi_needs_feature(d, f->strand_material_id < 4 ? "nrd_frame.strand_material_id" : "nrd_frame.camera_attached_reflection_material_id",
                                             NRD_FEATURE_MATERIALS, "NRD_FEATURE_MATERIALS"))) return r;
    if (f->specular_motion && (r = nrdi_needs_feature(d, "nrd_frame.specular_motion", NRD_FEATURE_SPECULAR_MOTION, "NRD_FEATURE_SPECULAR_MOTION"))) return r;
    if (f->disocclusion_threshold_mix_available)
        return nrdi_needs_feature(d, "nrd_frame.disocclusion_threshold_mix_available", NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX, "NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX");
    return NRD_RESULT_OK;
}

static bool nrdi_same_view(const nrd_camera *a, const nrd_camera *b)
{
    return !memcmp(a->view_to_clip, b->view_to_clip, sizeof a->view_to_clip) && !memcmp(a->world_to_view, b->world_to_view, sizeof a->world_to_view);
}

/* With NRD_ABSENT_MOTION. last: the frame before it. */
static nrd_result nrdi_check_stillness(const nrd_desc *d, const nrd_frame *f, const nrd_frame *last, uint32_t width, uint32_t height)
{
    const char *moved = NULL;
    if (width != last->rect_width || height != last->rect_height) moved = "the rectangle";
    if (memcmp(f->camera.jitter, last->camera.jitter, sizeof f->camera.jitter)) moved = "the jitter";
    if (!nrdi_same_view(&f->camera, &last->camera) || (f->camera_prev && !nrdi_same_view(&f->camera, f->camera_prev))) moved = "the camera";
    if (!moved) return NRD_RESULT_OK;
    nrdi_text t = { { 0 }, 0 };
    nrdi_put(&t, "nrd_frame: "); nrdi_put(&t, moved);
    nrdi_put(&t, " has changed, but nrd_desc.absent has NRD_ABSENT_MOTION: allowed with nrd_frame.restart only");
    return nrdi_invalid(d, t.s);
}

nrd_result nrd_set_frame(nrd *n, const nrd_frame *frame)
{
    if (nrdi_check_alive(n)) return nrdi_check_alive(n);
    if (!frame) return nrdi_invalid(&n->desc, "nrd_set_frame: frame is NULL");
    uint32_t width = frame->rect_width ? frame->rect_width : n->desc.width, height = frame->rect_height ? frame->rect_height : n->desc.height;
    nrd_result r = nrdi_check_frame(n, frame, width, height);
    if (r) return r;
    bool first = !n->frame_set, advanced = first || frame->frame_index != n->frame.frame_index;
    const nrd_frame *before = advanced ? (first ? NULL : &n->frame) : n->has_last ? &n->last : NULL;
    if ((n->desc.absent & NRD_ABSENT_MOTION) && before && !frame->restart && (r = nrdi_check_stillness(&n->desc, frame, before, width, height))) return r;
    if (!first && advanced && frame->frame_index != n->frame.frame_index + 1 && !frame->restart)
        nrdi_tell(&n->desc, NRD_SEVERITY_WARNING, NRD_RESULT_INVALID_ARGUMENT, "nrd_frame.frame_index did not advance by 1: history restarts");
    if (advanced && !first) {   /* what a replacing frame with the same index starts from again */
        n->last = n->frame;
        n->has_last = true;
    }
    n->frame = *frame;
    n->frame.rect_width = width;
    n->frame.rect_height = height;
    n->frame.camera_prev = NULL;
    n->frame_restart = frame->restart || !n->has_last;
    const nrd_frame *last = n->frame_restart ? &n->frame : &n->last;
    n->camera_prev = frame->camera_prev && !n->frame_restart ? *frame->camera_prev : last->camera;
    n->rect_prev[0] = last->rect_width;
    n->rect_prev[1] = last->rect_height;
    n->range_prev = last->denoising_range;
    n->frame_size[0] = n->desc.width;
    n->frame_size[1] = n->desc.height;
    n->frame_set = true;
    return NRD_RESULT_OK;
}

static nrdi_state *nrdi_find_state(nrd *n, uint32_t identifier)
{
    for (uint32_t i = 0; i < n->info.denoiser_count; i++)
        if (n->states[i].identifier == identifier) return &n->states[i];
    nrdi_text t = { { 0 }, 0 };
    nrdi_put(&t, "no denoiser of this instance has the identifier ");
    nrdi_put_uint(&t, identifier);
    nrdi_tell(&n->desc, NRD_SEVERITY_ERROR, NRD_RESULT_UNKNOWN_DENOISER, t.s);
    return NULL;
}

/* Settings that do something only where a feature was declared: those must be 0 without it. */
static nrd_result nrdi_check_declared(const nrd_desc *d, nrdi_settings_list list, const void *settings)
{
    static const struct { const char *setting, *name; uint32_t feature; } needs[] = {
        { "diffuse_prepass_blur_radius", "NRD_FEATURE_PREPASS", NRD_FEATURE_PREPASS },
        { "specular_prepass_blur_radius", "NRD_FEATURE_PREPASS", NRD_FEATURE_PREPASS },
        { "hit_distance_reconstruction", "NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION", NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION },
        { "diffuse_checkerboard", "NRD_FEATURE_CHECKERBOARD", NRD_FEATURE_CHECKERBOARD },
        { "specular_checkerboard", "NRD_FEATURE_CHECKERBOARD", NRD_FEATURE_CHECKERBOARD },
        { "specular_roughness_limit", "NRD_FEATURE_ROUGHNESS_LIMIT", NRD_FEATURE_ROUGHNESS_LIMIT },
    };
    for (size_t k = 0; k < sizeof needs / sizeof needs[0]; k++)
        for (uint32_t i = 0; i < list.count; i++) {
            if (strcmp(list.rows[i].name, needs[k].setting) != 0 || nrdi_setting_value(&list.rows[i], settings) == 0) continue;
            nrd_result r = nrdi_needs_feature(d, needs[k].setting, needs[k].feature, needs[k].name);
            if (r) return r;
        }
    return NRD_RESULT_OK;
}

nrd_result nrd_set_settings(nrd *n, uint32_t identifier, const void *settings)
{
    if (nrdi_check_alive(n)) return nrdi_check_alive(n);
    if (!settings) return nrdi_invalid(&n->desc, "nrd_set_settings: settings is NULL");
    nrdi_state *s = nrdi_find_state(n, identifier);
    if (!s) return NRD_RESULT_UNKNOWN_DENOISER;
    nrdi_settings_list list = nrdi_list_of(s->denoiser);
    nrd_result r = nrdi_check_settings(&n->desc, nrd_denoiser_name(s->denoiser), list, settings);
    if (r) return r;
    if ((r = nrdi_check_declared(&n->desc, list, settings))) return r;
    memcpy(&s->settings, settings, list.bytes);
    return NRD_RESULT_OK;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Constants  >>constants
   All matrices are brought to left-handed view space with clip y up, so that shaders know one convention. */
typedef struct nrdi_view { double rotation[9], position[3]; float frustum[4]; bool orthographic; float unproject; } nrdi_view; /* rotation: row-major world to view */

static bool nrdi_is_right_handed(const float *p)
{
    if (p[11] != 0) return p[11] < 0;
    return (1 - 2 * p[14]) / p[10] < 0;   /* sum of the view depths of both clip planes: in front of the camera is the sign */
}

static nrdi_view nrdi_resolve_view(const nrd_camera *c, nrd_clip_y clip_y, uint32_t rect_height)
{
    nrdi_view v;
    const float *p = c->view_to_clip, *w = c->world_to_view;
    double flip = nrdi_is_right_handed(p) ? -1 : 1;
    bool up = clip_y == NRD_CLIP_Y_AUTO ? p[5] > 0 : clip_y == NRD_CLIP_Y_UP;
    double flips[3] = { 1, (p[5] > 0) == up ? 1.0 : -1.0, flip };   /* y of the view may point down the picture */
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) v.rotation[3 * row + k] = w[4 * k + row] * flips[row];
    double t[3] = { w[12], w[13] * flips[1], w[14] * flip };
    for (int k = 0; k < 3; k++) v.position[k] = -(v.rotation[k] * t[0] + v.rotation[3 + k] * t[1] + v.rotation[6 + k] * t[2]);
    v.orthographic = p[11] == 0;
    double cx = v.orthographic ? p[12] : p[8] * flip, cy = v.orthographic ? p[13] : p[9] * flip, sy = up ? 1 : -1;
    v.frustum[0] = (float)((-1 - cx) / p[0]);
    v.frustum[1] = (float)((sy - cy) / p[5] * flips[1]);
    v.frustum[2] = (float)(2 / (double)p[0]);
    v.frustum[3] = (float)(-2 * sy / p[5] * flips[1]);
    v.unproject = (float)(2 / (rect_height * fabs((double)p[5])));
    return v;
}

/* to * from^-1 as a column-major matrix, with the origin of "from" where the caller says */
static void nrdi_put_matrix(float *m, const double rotation[9], const double translation[3])
{
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 3; k++) m[4 * k + row] = (float)rotation[3 * row + k];
        m[12 + row] = (float)translation[row];
        m[4 * row + 3] = 0;
    }
    m[15] = 1;
}

static void nrdi_fill_matrices(nrd_constants *c, const nrdi_view *now, const nrdi_view *prev)
{
    double transposed[9], between[9], origin[3] = { 0, 0, 0 }, delta[3];
    for (int row = 0; row < 3; row++) {
        delta[row] = 0;
        for (int k = 0; k < 3; k++) {
            transposed[3 * row + k] = now->rotation[3 * k + row];
            delta[row] += prev->rotation[3 * row + k] * (now->position[k] - prev->position[k]);
            between[3 * row + k] = 0;
            for (int j = 0; j < 3; j++) between[3 * row + k] += prev->rotation[3 * row + j] * now->rotation[3 * k + j];
        }
    }
    nrdi_put_matrix(c->view_to_world, transposed, origin);
    nrdi_put_matrix(c->world_to_view_prev, prev->rotation, delta);
    nrdi_put_matrix(c->view_to_view_prev, between, delta);
}

static uint32_t nrdi_frame_flags(const nrd_frame *f)
{
    return (f->history_confidence_available ? NRD_FLAG_HISTORY_CONFIDENCE : 0) | (f->disocclusion_threshold_mix_available ? NRD_FLAG_DISOCCLUSION_MIX : 0)
         | (f->specular_motion ? NRD_FLAG_SPECULAR_MOTION : 0) | (f->specular_motion == NRD_SPECULAR_MOTION_HIT ? NRD_FLAG_SPECULAR_MOTION_HIT : 0);
}

static void nrdi_fill_frame(const nrd *n, nrd_constants *c)
{
    const nrd_frame *f = &n->frame;
    nrdi_view now = nrdi_resolve_view(&f->camera, f->clip_y, f->rect_height);
    nrdi_view prev = nrdi_resolve_view(&n->camera_prev, f->clip_y, n->rect_prev[1]);
    nrdi_fill_matrices(c, &now, &prev);
    memcpy(c->frustum, now.frustum, sizeof c->frustum);
    memcpy(c->frustum_prev, prev.frustum, sizeof c->frustum_prev);
    c->orthographic = now.orthographic;
    c->orthographic_prev = prev.orthographic;
    c->pixel_unproject = now.unproject;
    c->motion_scale[0] = f->motion_scale_x;
    c->motion_scale[1] = f->motion_scale_y;
    c->motion_scale[2] = f->motion_scale_z;
    c->jitter_delta[0] = f->camera.jitter[0] - n->camera_prev.jitter[0];
    c->jitter_delta[1] = f->camera.jitter[1] - n->camera_prev.jitter[1];
    c->jitter_delta[3] = 2;
    for (int k = 0; k < 3; k++) c->camera[k] = (float)now.position[k];
    c->camera[3] = (float)(f->rect_width < f->rect_height ? f->rect_width : f->rect_height) * now.unproject;
    c->rect_width = f->rect_width;
    c->rect_height = f->rect_height;
    c->rect_width_prev = n->rect_prev[0];
    c->rect_height_prev = n->rect_prev[1];
    for (int k = 0; k < 4; k++) {
        c->rect_px[k] = (float)(k == 0 ? f->rect_width : k == 1 ? f->rect_height : n->rect_prev[k - 2]);
        c->px_uv[k] = 1 / c->rect_px[k];
        c->tile_last[k] = (float)(((uint32_t)c->rect_px[k] + 7) / 8) - 0.5f;
        c->jitter_uv[k] = (k < 2 ? f->camera.jitter[k] : n->camera_prev.jitter[k - 2]) * c->px_uv[k];
    }
    c->rect_origin_x = f->rect_origin_x;
    c->rect_origin_y = f->rect_origin_y;
    c->frame_index = f->frame_index;
    c->view_z_scale = f->view_z_scale;
    c->denoising_range = f->denoising_range;
    c->denoising_range_prev = n->range_prev;
    float jitter = fmaxf(fabsf(c->jitter_delta[0]), fabsf(c->jitter_delta[1])) / (float)f->rect_height;
    c->disocclusion_threshold = f->disocclusion_threshold + jitter;
    c->disocclusion_threshold_alternate = f->disocclusion_threshold_alternate + jitter;
    c->split_screen = f->split_screen;
    c->motion_mode = f->motion_mode;
    c->flags = nrdi_frame_flags(f);
}

/* min_material is what history and geometry are told apart by at least; with NRD_FEATURE_MATERIALS each signal then asks for its own. */
static void nrdi_fill_materials(const nrd *n, const nrdi_state *s, nrd_constants *c)
{
    const nrd_reblur_settings *r = &s->settings.reblur;
    bool diffuse = false, specular = false, apart = (n->desc.features & NRD_FEATURE_MATERIALS) != 0;
    uint32_t least[2] = { r->min_material_for_diffuse, r->min_material_for_specular };
    c->strand_thickness = n->frame.strand_thickness;
    c->materials = n->frame.strand_material_id << NRD_MATERIAL_STRAND | n->frame.camera_attached_reflection_material_id << NRD_MATERIAL_CAMERA_ATTACHED;
    if (s->row->family != NRDI_FAMILY_REBLUR) return;
    for (uint32_t p = 0; p < nrdi_pass_count(s->row); p++) {
        diffuse |= nrdi_pass_uses(&s->row->passes[p], NRDI_DIFF_HISTORY);
        specular |= nrdi_pass_uses(&s->row->passes[p], NRDI_SPEC_HISTORY);
    }
    if (!diffuse) least[0] = least[1];
    if (!specular) least[1] = least[0];
    c->min_material = (least[0] > least[1]) == apart ? least[0] : least[1];
    c->materials |= least[0] << NRD_MATERIAL_LEAST_DIFFUSE | least[1] << NRD_MATERIAL_LEAST_SPECULAR;
}

static uint32_t nrdi_checkerboard_flags(uint32_t diffuse, uint32_t specular)
{
    return (diffuse ? NRD_FLAG_DIFFUSE_CHECKERBOARD : 0) | (diffuse == 2 ? NRD_FLAG_DIFFUSE_WHITE : 0)
         | (specular ? NRD_FLAG_SPECULAR_CHECKERBOARD : 0) | (specular == 2 ? NRD_FLAG_SPECULAR_WHITE : 0);
}

/* Sparse inputs: a checkerboard needs no reconstruction. */
static uint32_t nrdi_sparse_flags(const nrd_reblur_settings *s)
{
    if (s->diffuse_checkerboard || s->specular_checkerboard) return nrdi_checkerboard_flags(s->diffuse_checkerboard, s->specular_checkerboard);
    return (s->hit_distance_reconstruction > 0 ? NRD_FLAG_RECONSTRUCTION : 0) | (s->hit_distance_reconstruction > 1 ? NRD_FLAG_WIDE_RECONSTRUCTION : 0);
}

static void nrdi_fill_reblur(const nrdi_state *state, float resolution_scale, nrd_constants *c)
{
    const nrd_reblur_settings *s = &state->settings.reblur;
    c->hit_distance[0] = s->hit_distance_a;
    c->hit_distance[1] = s->hit_distance_b;
    c->hit_distance[2] = s->hit_distance_c;
    c->hit_distance[3] = s->hit_distance_d;
    c->max_accumulated_frames = s->max_accumulated_frames;
    c->max_stabilized_frames = s->max_stabilized_frames;
    c->history_fix_frames = s->history_fix_frames;
    c->responsive_roughness = s->responsive_roughness;
    c->responsive_frames = s->responsive_min_frames;
    if (s->specular_roughness_limit > 0) c->jitter_delta[3] = s->specular_roughness_limit;
    c->feedback_frames = s->feedback_frames;
    c->motion_scale[3] = s->anti_firefly_scale > 0 ? fmaxf(s->anti_firefly_scale, 1.0f) : 0.0f;
    c->max_blur_radius = s->max_blur_radius * resolution_scale;
    c->prepass_blur_radius = s->diffuse_prepass_blur_radius * resolution_scale;
    c->specular_prepass_blur_radius = s->specular_prepass_blur_radius * resolution_scale;
    c->luminance_sigma_scale = s->luminance_sigma_scale;
    c->plane_distance_sensitivity = s->plane_distance_sensitivity;
    c->normal_sensitivity = s->normal_sensitivity;
    c->antilag_sigma_scale = s->antilag_sigma_scale;
    c->antilag_sensitivity = s->antilag_sensitivity;
    c->stabilization_sigma_scale = s->stabilization_sigma_scale;
    c->flags |= (s->return_history_length_instead_of_occlusion ? NRD_FLAG_RETURN_HISTORY : 0)
              | (s->antilag_sensitivity > 0 ? NRD_FLAG_ANTILAG : 0) | (s->diffuse_prepass_blur_radius > 0 ? NRD_FLAG_PREPASS : 0)
              | (s->specular_prepass_blur_radius > 0 ? NRD_FLAG_SPECULAR_PREPASS : 0) | (s->performance_mode ? NRD_FLAG_PERFORMANCE : 0)
              | nrdi_sparse_flags(s);
}

static void nrdi_fill_occlusion(const nrd_occlusion_settings *s, float resolution_scale, nrd_constants *c)
{
    c->hit_distance[0] = s->hit_distance_a;
    c->hit_distance[1] = s->hit_distance_b;
    c->hit_distance[2] = s->hit_distance_c;
    c->hit_distance[3] = s->hit_distance_d;
    c->max_accumulated_frames = s->max_accumulated_frames;
    c->max_blur_radius = s->max_blur_radius * resolution_scale;
    c->plane_distance_sensitivity = s->plane_distance_sensitivity;
    c->normal_sensitivity = s->normal_sensitivity;
    c->antilag_sigma_scale = s->antilag_sigma_scale;
    c->min_material = s->min_material;
    c->flags |= (s->return_history_length_instead_of_occlusion ? NRD_FLAG_RETURN_HISTORY : 0) | (s->performance_mode ? NRD_FLAG_PERFORMANCE : 0)
              | nrdi_checkerboard_flags(s->diffuse_checkerboard, s->specular_checkerboard);
}

static bool nrdi_knows_light(const nrd_sigma_settings *s) { return s->light_x != 0 || s->light_y != 0 || s->light_z != 0 || s->light_is_local; }

/* How far the light has moved since the frame before, as a part of its diameter: so much changes in the visibility of a penumbra, at most.
   An app that moves the world's origin says so by where it puts camera_prev. */
static float nrdi_light_shift(const nrd *n, const nrd_sigma_settings *before, const nrd_sigma_settings *now)
{
    nrdi_view placed = nrdi_resolve_view(&n->camera_prev, n->frame.clip_y, 1), last = nrdi_resolve_view(&n->last.camera, n->frame.clip_y, 1);
    const float a[3] = { before->light_x, before->light_y, before->light_z }, b[3] = { now->light_x, now->light_y, now->light_z };
    double squared[2] = { 0, 0 }, moved = 0;
    if (!n->has_last || !nrdi_knows_light(before) || !nrdi_knows_light(now) || !(now->light_radius > 0)) return 0;
    if (before->light_is_local != now->light_is_local) return 1;
    for (int k = 0; k < 3; k++) squared[0] += (double)a[k] * a[k], squared[1] += (double)b[k] * b[k];
    for (int k = 0; k < 3; k++) {
        double from = now->light_is_local ? a[k] + placed.position[k] - last.position[k] : a[k] / sqrt(squared[0]), to = now->light_is_local ? b[k] : b[k] / sqrt(squared[1]);
        moved += (to - from) * (to - from);
    }
    double shift = sqrt(moved) / (2 * (double)now->light_radius);
    return shift > 1e-4 ? (float)(shift < 1 ? shift : 1) : 0;   /* less: rounding */
}

/* A frame's dispatches may be cancelled and taken again. */
static float nrdi_follow_light(const nrd *n, nrdi_state *s)
{
    if (s->light_frame != n->frame.frame_index) s->light_before = s->light;
    s->light_frame = n->frame.frame_index;
    s->light = s->settings.sigma;
    return nrdi_light_shift(n, &s->light_before, &s->light);
}

static void nrdi_fill_sigma(const nrd *n, const nrd_sigma_settings *s, nrd_constants *c)
{
    nrdi_view now = nrdi_resolve_view(&n->frame.camera, n->frame.clip_y, n->frame.rect_height);
    double from[3] = { s->light_x, s->light_y, s->light_z }, squared = 0;
    bool known = nrdi_knows_light(s);
    for (int k = 0; k < 3; k++) {
        from[k] -= s->light_is_local ? now.position[k] : 0;
        squared += from[k] * from[k];
    }
    double scale = s->light_is_local ? 1 : known ? 1 / sqrt(squared) : 0;
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) c->light[row] += (float)(now.rotation[3 * row + k] * from[k] * scale);
    c->light[3] = (float)s->light_is_local;
    c->light_radius = s->light_radius;
    c->max_accumulated_frames = s->max_accumulated_frames;
    c->max_stabilized_frames = s->max_stabilized_frames;
    c->penumbra_blur_scale = s->penumbra_blur_scale;
    c->plane_distance_sensitivity = s->plane_distance_sensitivity;
}

/* Settings that ask for what is absent count as 0. */
static void nrdi_apply_absent(uint32_t absent, nrd_constants *c)
{
    if (absent & NRD_ABSENT_STABILIZATION) c->max_stabilized_frames = 0;
    if (absent & NRD_ABSENT_BLUR) c->max_blur_radius = 0;
    if (absent & NRD_ABSENT_LIGHTING_CHANGE) {
        c->antilag_sensitivity = 0;
        c->flags &= ~NRD_FLAG_ANTILAG;
    }
}

static bool nrdi_camera_moved(const nrd *n)
{
    return !nrdi_same_view(&n->frame.camera, &n->camera_prev) || n->frame.rect_width != n->rect_prev[0] || n->frame.rect_height != n->rect_prev[1];
}

/* Sub-pixel offsets that do not come from a changed field of view. */
static bool nrdi_matrix_is_jittered(const nrd *n)
{
    const float *now = n->frame.camera.view_to_clip, *prev = n->camera_prev.view_to_clip;
    int column = now[11] == 0 ? 12 : 8;
    float x = fabsf(now[column] - prev[column]) * 0.5f * (float)n->frame.rect_width, y = fabsf(now[column + 1] - prev[column + 1]) * 0.5f * (float)n->frame.rect_height;
    bool same_view = now[0] == prev[0] && now[5] == prev[5] && now[11] == prev[11];
    return same_view && (x > 0.01f || y > 0.01f) && x < 1.01f && y < 1.01f;
}

static uint32_t nrdi_check_flags(const nrd *n, const nrdi_state *s)
{
    bool skipped = s->has_history && !n->frame_restart && s->last_frame_index + 1 != n->frame.frame_index;
    return (nrdi_matrix_is_jittered(n) ? NRD_FLAG_MATRIX_JITTER : 0) | (skipped ? NRD_FLAG_FRAME_INDEX : 0);
}

/* Asking a shader for them is as slow as a fetch. */
static void nrdi_fill_sizes(const nrd *n, const nrdi_state *s, nrd_constants *c)
{
    const uint32_t size[4] = { n->desc.width, n->desc.height, s->reads_old ? n->period.width_before : n->desc.width, s->reads_old ? n->period.height_before : n->desc.height };
    for (int k = 0; k < 4; k++) {
        c->texel_uv[k] = 1.0f / (float)size[k];
        c->tile_uv[k] = 1.0f / (float)((size[k] + 7) / 8);
    }
}

static void nrdi_fill_constants(const nrd *n, nrdi_state *s)
{
    nrd_constants *c = &s->constants;
    bool reset = n->frame_restart || !s->has_history || s->last_frame_index + 1 != n->frame.frame_index;
    memset(c, 0, sizeof *c);
    nrdi_fill_frame(n, c);
    nrdi_fill_sizes(n, s, c);
    if (s->row->family == NRDI_FAMILY_REFERENCE) {
        reset |= nrdi_camera_moved(n);
        uint32_t frames = reset ? 0 : s->history_frames + 1;
        s->history_frames = frames < s->settings.reference.max_accumulated_frames ? frames : s->settings.reference.max_accumulated_frames;
        c->history_frames = s->history_frames;
    } else {
        float x = (float)n->frame.rect_width / (float)n->desc.width, y = (float)n->frame.rect_height / (float)n->desc.height;
        if (s->row->family == NRDI_FAMILY_OCCLUSION) nrdi_fill_occlusion(&s->settings.occlusion, x < y ? x : y, c);
        else if (s->row->family == NRDI_FAMILY_SIGMA) {
            nrdi_fill_sigma(n, &s->settings.sigma, c);
            float shift = nrdi_follow_light(n, s);
            if (!reset) c->jitter_delta[2] = shift;
        }
        else nrdi_fill_reblur(s, x < y ? x : y, c);
        nrdi_fill_materials(n, s, c);
    }
    nrdi_apply_absent(n->desc.absent, c);
    if (n->desc.features & NRD_FEATURE_CHECK) c->flags |= nrdi_check_flags(n, s);
    c->flags |= !reset && s->had_antilag ? NRD_FLAG_TILE_HISTORY : 0;
    s->had_antilag = (c->flags & NRD_FLAG_ANTILAG) != 0;
    c->reset = reset;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Dispatches  >>run */
/* The performance mode without all filter steps: two instead of four. */
static bool nrdi_leaves_steps_out(const nrdi_state *s)
{
    return s->row->family == NRDI_FAMILY_REBLUR && s->settings.reblur.performance_mode == 2;
}

static uint32_t nrdi_conditions(const nrd *n, const nrdi_state *s)
{
    const nrd_constants *c = &s->constants;
    uint32_t on = NRDI_IF_SKY | NRDI_IF_MOTION | NRDI_IF_STABILIZED | NRDI_IF_CHECK;
    if (s->row->family == NRDI_FAMILY_REFERENCE) return on;
    if (c->flags & NRD_FLAG_PREPASS) on |= NRDI_IF_PREPASS;
    if (c->flags & NRD_FLAG_SPECULAR_PREPASS) on |= NRDI_IF_SPEC_PREPASS;
    if (c->flags & NRD_FLAG_RECONSTRUCTION) on |= NRDI_IF_RECONSTRUCTION;
    if (c->flags & NRD_FLAG_SPECULAR_MOTION) on |= NRDI_IF_SPECULAR_MOTION;
    if (c->jitter_delta[3] < 2) on |= NRDI_IF_ROUGHNESS_LIMIT;
    if (c->max_blur_radius > 0 && !nrdi_leaves_steps_out(s)) on |= NRDI_IF_BLUR;
    if (c->flags & NRD_FLAG_ANTILAG) on |= NRDI_IF_ANTILAG;
    if (c->flags & NRD_FLAG_HISTORY_CONFIDENCE) on |= NRDI_IF_CONFIDENCE;
    if (c->flags & NRD_FLAG_DISOCCLUSION_MIX) on |= NRDI_IF_THRESHOLD_MIX;
    if (n->frame.split_screen > 0) on |= NRDI_IF_SPLIT;
    if (n->frame.validation && n->info.denoisers[n->frame.validation - 1].identifier == s->identifier) on |= NRDI_IF_VALIDATION;
    return on & nrdi_possible(&n->desc);
}

static bool nrdi_is_checkerboarded(const nrdi_state *s, nrd_resource resource)
{
    switch (resource) {
    case NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST: case NRD_RESOURCE_IN_DIFF_HITDIST: case NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST:
    case NRD_RESOURCE_IN_DIFF_SH0: case NRD_RESOURCE_IN_DIFF_SH1:
        return (s->constants.flags & NRD_FLAG_DIFFUSE_CHECKERBOARD) != 0;
    case NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST: case NRD_RESOURCE_IN_SPEC_HITDIST: case NRD_RESOURCE_IN_SPEC_SH0: case NRD_RESOURCE_IN_SPEC_SH1:
        return (s->constants.flags & NRD_FLAG_SPECULAR_CHECKERBOARD) != 0;
    default:
        return false;
    }
}

static uint32_t nrdi_bound(const nrdi_use *use, uint32_t conditions) { return nrdi_holds(use->condition, conditions) ? use->what : use->stand_in; }

static nrd_binding nrdi_resolve(const nrd *n, const nrdi_state *s, const nrdi_use *use, uint32_t conditions)
{
    uint32_t what = nrdi_bound(use, conditions);
    nrd_binding b = { NRD_RESOURCE_INTERNAL, 0, (nrd_access)use->access, false, false };
    if (what < NRD_RESOURCE_COUNT) {
        b.resource = (nrd_resource)what;
        b.half_width = nrdi_is_checkerboarded(s, b.resource);
        return b;
    }
    bool previous = what >= NRDI_PREVIOUS(0);
    uint32_t index = what - (previous ? NRDI_PREVIOUS(0) : NRDI_TEXTURE(0));
    b.texture = s->first_texture[index];
    if (nrdi_halves(nrdi_texture_of(s->row, index)) == 2) b.texture += s->parity ^ (previous ? 1u : 0u);
    NRD_ASSERT(b.texture < n->info.texture_count);
    b.before_resize = s->reads_old && n->textures[b.texture].permanent && (b.access == NRD_ACCESS_READ || b.access == NRD_ACCESS_READ_LINEAR) && !(s->written & nrdi_written_bit(s, what));
    return b;
}

/* Distance of a filter step's taps. Steps 1, 2, 4, 8 reach 15 px. The first is 1 always: reblur/cells.glsl. Of two in all the second is 3: the 3x3
   pixels of the first then lie side by side, while 4 leaves a plaid and 2 more noise. */
static int32_t nrdi_step(const nrdi_state *s, const nrdi_pass_row *row)
{
    float radius = s->constants.max_blur_radius;
    if (!(radius > 0) || row->iteration == 0) return radius > 0;
    int32_t of_15 = row->iteration == 3 && nrdi_leaves_steps_out(s) ? 3 : 1 << row->iteration, step = (int32_t)(radius * (float)of_15 / 15.0f + 0.5f);
    return step < 1 ? 1 : step;
}

static bool nrdi_lists_tiles(const nrdi_use *use, uint32_t conditions)
{
    return use->what == NRDI_TEXTURE(NRDI_TILE_LIST) && use->access == NRD_ACCESS_READ && nrdi_holds(use->condition, conditions);
}

/* A search for lighting changes: where all is sky there is nothing to find, and what it has left before reaches no surface that appears later:
   only one that has been there for a frame asks what the search found, and in that frame it ran everywhere. */
static bool nrdi_needs_any_tile(const nrdi_pass_row *row, uint32_t conditions) { return row->condition == NRDI_IF_ANTILAG && (conditions & NRDI_IF_SKY); }

static void nrdi_add_dispatch(nrd *n, nrdi_state *s, uint32_t pass, uint32_t conditions, uint32_t *count)
{
    const nrdi_live_pass *live = &n->live[pass];
    nrd_binding *bindings = n->bindings + (size_t)pass * NRDI_MAX_USES;
    nrd_dispatch *d = &n->dispatches[(*count)++];
    uint32_t px = live->row->span ? 8u * live->row->span : 8;
    memset(d, 0, sizeof *d);
    d->name = live->row->name;
    d->pass = pass;
    d->pipeline = live->pipeline;
    d->bindings = bindings;
    d->binding_count = nrdi_use_count(live->row);
    bool listed = false, any_tile = nrdi_needs_any_tile(live->row, conditions);
    for (uint32_t u = 0; u < d->binding_count; u++) {
        bindings[u] = nrdi_resolve(n, s, &live->row->uses[u], conditions);
        listed |= nrdi_lists_tiles(&live->row->uses[u], conditions);
    }
    if (listed || any_tile) d->indirect = 1 + s->first_texture[NRDI_TILE_GROUPS] + s->parity;
    if (any_tile) d->indirect_offset = NRDI_ALL_TILES;
    for (uint32_t u = 0; u < d->binding_count; u++)
        if (bindings[u].access == NRD_ACCESS_WRITE && bindings[u].resource == NRD_RESOURCE_INTERNAL) s->written |= nrdi_written_bit(s, nrdi_bound(&live->row->uses[u], conditions));
    d->constants = &s->constants;
    d->push[0] = nrdi_step(s, live->row);
    d->push[1] = live->row->iteration;
    d->groups_x = (n->frame.rect_width + px - 1) / px;
    d->groups_y = (n->frame.rect_height + px - 1) / px;
}

/* The first dispatches of another size begin a period. Only what was written in the one before it can still be read. */
static void nrdi_follow_size(nrd *n, nrdi_state *s)
{
    if (n->period.width != n->desc.width || n->period.height != n->desc.height) {
        n->period.number++;
        n->period.width_before = n->period.width;
        n->period.height_before = n->period.height;
        n->period.width = n->desc.width;
        n->period.height = n->desc.height;
    }
    if (s->period + 1 < n->period.number) s->has_history = false;
    s->reads_old = s->has_history && s->period != n->period.number;
    s->period = n->period.number;
    s->written = 0;
}

static void nrdi_add_dispatches(nrd *n, nrdi_state *s, uint32_t *count)
{
    nrdi_follow_size(n, s);
    if (s->has_history && !n->frame.restart && s->last_frame_index == n->frame.frame_index)
        nrdi_tell(&n->desc, NRD_SEVERITY_WARNING, NRD_RESULT_INVALID_ARGUMENT, "nrd_frame.frame_index has not advanced since this denoiser's last dispatches: history restarts");
    nrdi_fill_constants(n, s);
    s->reads_old = s->reads_old && !s->constants.reset;
    uint32_t conditions = nrdi_conditions(n, s);
    if (n->frame.split_screen >= 1 && s->row->family != NRDI_FAMILY_REFERENCE) {  /* nothing but the input is shown: history stops */
        conditions = NRDI_IF_SPLIT;
        s->has_history = false;
    }
    for (uint32_t p = 0; p < s->pass_count; p++) {
        const nrdi_pass_row *row = n->live[s->pass_base + p].row;
        bool only_split = n->frame.split_screen >= 1 && s->row->family != NRDI_FAMILY_REFERENCE && row->condition != NRDI_IF_SPLIT;
        if (only_split || (row->condition && !(conditions & row->condition))) continue;
        nrdi_add_dispatch(n, s, s->pass_base + p, conditions, count);
    }
    if (n->frame.split_screen < 1 || s->row->family == NRDI_FAMILY_REFERENCE) {
        s->parity ^= 1u;
        s->has_history = true;
        s->last_frame_index = n->frame.frame_index;
    }
}

void nrd_cancel_dispatches(nrd *n)
{
    if (nrdi_check_alive(n) || !n->states_before[0].row) return;   /* there were none */
    memcpy(n->states, n->states_before, n->info.denoiser_count * sizeof *n->states);
    n->period = n->period_before;
}

nrd_result nrd_get_dispatches(nrd *n, const uint32_t *identifiers, uint32_t identifier_count, const nrd_dispatch **dispatches, uint32_t *count)
{
    if (nrdi_check_alive(n)) return nrdi_check_alive(n);
    if (!dispatches || !count) return nrdi_invalid(&n->desc, "nrd_get_dispatches: dispatches or count is NULL");
    if (!n->frame_set) return nrdi_tell(&n->desc, NRD_SEVERITY_ERROR, NRD_RESULT_FRAME_NOT_SET, "nrd_get_dispatches: call nrd_set_frame first");
    if (n->frame_size[0] != n->desc.width || n->frame_size[1] != n->desc.height)
        return nrdi_tell(&n->desc, NRD_SEVERITY_ERROR, NRD_RESULT_FRAME_NOT_SET, "nrd_get_dispatches: call nrd_set_frame after nrd_resize");
    if (!identifiers && identifier_count) return nrdi_invalid(&n->desc, "nrd_get_dispatches: identifiers is NULL");
    for (uint32_t k = 0; k < identifier_count; k++)
        if (!nrdi_find_state(n, identifiers[k])) return NRD_RESULT_UNKNOWN_DENOISER;
    uint32_t used = 0;
    memcpy(n->states_before, n->states, n->info.denoiser_count * sizeof *n->states);
    n->period_before = n->period;
    for (uint32_t i = 0; i < n->info.denoiser_count; i++) {
        bool wanted = !identifiers;
        for (uint32_t k = 0; k < identifier_count; k++) wanted |= identifiers[k] == n->states[i].identifier;
        if (wanted) nrdi_add_dispatches(n, &n->states[i], &used);
    }
    *dispatches = n->dispatches;
    *count = used;
    return NRD_RESULT_OK;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   What is left out  >>explanation */
/* Nanoseconds per pixel of the passes of nrdi_rows on NRD_DEVICE_DATACENTER; examples/report/passes.sh writes them. */
static const float nrdi_pass_ns[][NRDI_MAX_PASSES] = {
    /* >>pass times begin */
#if NRDI_WITH(REFERENCE)
    { 0.0126f },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE)
    { 0.0021f, 0.0258f, 0.0497f, 0.0299f, 0.0028f, 0.0294f, 0.0164f, 0.0222f, 0.0265f, 0.0104f, 0.0283f, 0.0306f },
#endif
#if NRDI_WITH(REBLUR_SPECULAR)
    { 0.0021f, 0.0258f, 0.0516f, 0.0603f, 0.0028f, 0.0355f, 0.0198f, 0.0257f, 0.0320f, 0.0104f, 0.0287f, 0.0366f },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_SPECULAR)
    { 0.0021f, 0.0259f, 0.0266f, 0.0490f, 0.0516f, 0.0777f, 0.0028f, 0.0022f, 0.0493f, 0.0267f, 0.0372f, 0.0449f, 0.0104f, 0.0101f, 0.0331f, 0.0375f },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_OCCLUSION)
    { 0.0021f, 0.0428f, 0.0215f, 0.0103f, 0.0257f, 0.0318f },
#endif
#if NRDI_WITH(REBLUR_SPECULAR_OCCLUSION)
    { 0.0021f, 0.0604f, 0.0280f, 0.0103f, 0.0266f, 0.0335f },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_SPECULAR_OCCLUSION)
    { 0.0021f, 0.0824f, 0.0472f, 0.0103f, 0.0100f, 0.0286f, 0.0347f },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION)
    { 0.0021f, 0.0561f, 0.0278f, 0.0104f, 0.0285f, 0.0364f },
#endif
#if NRDI_WITH(SIGMA_SHADOW)
    { 0.0051f, 0.0014f, 0.0228f, 0.0093f, 0.0101f, 0.0253f, 0.0280f },
#endif
#if NRDI_WITH(SIGMA_SHADOW_TRANSLUCENCY)
    { 0.0080f, 0.0015f, 0.1067f, 0.0310f, 0.0104f, 0.0277f, 0.0285f },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_SH)
    { 0.0022f, 0.0265f, 0.0691f, 0.0408f, 0.0028f, 0.0406f, 0.0164f, 0.0222f, 0.0282f, 0.0104f, 0.0101f, 0.0283f, 0.0307f },
#endif
#if NRDI_WITH(REBLUR_SPECULAR_SH)
    { 0.0022f, 0.0259f, 0.0741f, 0.0715f, 0.0028f, 0.0470f, 0.0199f, 0.0257f, 0.0339f, 0.0104f, 0.0101f, 0.0288f, 0.0366f },
#endif
#if NRDI_WITH(REBLUR_DIFFUSE_SPECULAR_SH)
    { 0.0022f, 0.0265f, 0.0272f, 0.0683f, 0.0741f, 0.1197f, 0.0028f, 0.0022f, 0.0815f, 0.0268f, 0.0372f, 0.0476f, 0.0104f, 0.0101f, 0.0101f, 0.0101f, 0.0332f, 0.0374f },
#endif
    /* >>pass times end */
};
typedef char nrdi_every_row_has_its_times[sizeof nrdi_pass_ns / sizeof nrdi_pass_ns[0] == sizeof nrdi_rows / sizeof nrdi_rows[0] ? 1 : -1];

static float nrdi_pass_us(const nrd_desc *desc, const nrdi_denoiser_row *row, uint32_t pass)
{
    return nrdi_pass_ns[row - nrdi_rows][pass] * 1e-3f * (float)desc->width * (float)desc->height;
}

/* Looks for the item with number `left`. */
typedef struct nrdi_search { uint32_t left; nrd_explanation *out; bool found; } nrdi_search;

static void nrdi_offer(nrdi_search *search, nrd_explanation item)
{
    if (search->found || search->left-- > 0) return;
    *search->out = item;
    search->found = true;
}

/* Of the settings and the frame as they are; no dispatches are needed. */
static uint32_t nrdi_current_conditions(const nrd *n, const nrdi_state *s)
{
    nrdi_state now = *s;
    memset(&now.constants, 0, sizeof now.constants);
    if (s->row->family == NRDI_FAMILY_REBLUR) nrdi_fill_reblur(s, 1, &now.constants);
    if (s->row->family == NRDI_FAMILY_OCCLUSION) nrdi_fill_occlusion(&s->settings.occlusion, 1, &now.constants);
    now.constants.flags |= nrdi_frame_flags(&n->frame);
    nrdi_apply_absent(n->desc.absent, &now.constants);
    return nrdi_conditions(n, &now);
}

/* Why something under this condition is not needed; NULL: it is. */
static const char *nrdi_why_not(const nrd_desc *desc, uint32_t condition, uint32_t on)
{
    if (nrdi_holds(condition, on)) return NULL;
    const nrdi_reason *r = nrdi_reason_of(condition);
    return nrdi_holds(condition, nrdi_possible(desc)) ? r->now : r->never;
}

static uint64_t nrdi_row_bytes(const nrd_desc *desc, const nrdi_denoiser_row *row)
{
    uint64_t bytes = 0;
    uint32_t passes = nrdi_declared_passes(row, desc), possible = nrdi_possible(desc);
    for (uint32_t t = 0; t < NRDI_MAX_TEXTURES; t++) {
        bool used = false;
        for (uint32_t p = 0; p < nrdi_pass_count(row); p++) used |= (passes >> p & 1u) && nrdi_pass_uses(&row->passes[p], t);
        if (used && !nrdi_ruled_out(row, passes, t, possible)) bytes += nrdi_texture_bytes(desc, nrdi_texture_of(row, t));
    }
    return bytes;
}

static float nrdi_row_us(const nrd_desc *desc, const nrdi_denoiser_row *row)
{
    float sum = 0;
    uint32_t passes = nrdi_declared_passes(row, desc);
    for (uint32_t p = 0; p < nrdi_pass_count(row); p++) sum += passes >> p & 1u ? nrdi_pass_us(desc, row, p) : 0;
    return sum;
}

/* A signal of a denoiser of both that is absent, with all that it would bring. */
static void nrdi_explain_signal(const nrd *n, const nrdi_state *s, nrdi_search *search)
{
    const nrdi_denoiser_row *whole = nrdi_row_of(s->denoiser);
    bool diffuse = (n->desc.absent & NRD_ABSENT_DIFFUSE) != 0;
    if (!whole || whole == s->row) return;
    nrd_explanation item = { "signal", diffuse ? "diffuse" : "specular", (uint32_t)(s - n->states), false,
                             diffuse ? "nrd_desc.absent has NRD_ABSENT_DIFFUSE" : "nrd_desc.absent has NRD_ABSENT_SPECULAR",
                             nrdi_row_bytes(&n->desc, whole) - nrdi_row_bytes(&n->desc, s->row), nrdi_row_us(&n->desc, whole) - nrdi_row_us(&n->desc, s->row) };
    nrdi_offer(search, item);
}

static void nrdi_explain_passes(const nrd *n, const nrdi_state *s, uint32_t on, nrdi_search *search)
{
    uint32_t declared = nrdi_declared_passes(s->row, &n->desc), possible = nrdi_possible(&n->desc);
    for (uint32_t p = 0; p < nrdi_pass_count(s->row); p++) {
        const nrdi_pass_row *pass = &s->row->passes[p];
        bool exists = (declared >> p & 1u) != 0;
        const char *why = exists ? nrdi_why_not(&n->desc, pass->condition, on) : nrdi_why_never(pass, possible);
        nrd_explanation item = { "pass", pass->name, (uint32_t)(s - n->states), why == NULL, why,
                                 exists ? 0 : nrdi_saved_bytes(n, s->row, p, declared), nrdi_pass_us(&n->desc, s->row, p) };
        nrdi_offer(search, item);
    }
}

static void nrdi_explain_textures(const nrd *n, const nrdi_state *s, nrdi_search *search)
{
    uint32_t declared = nrdi_declared_passes(s->row, &n->desc), possible = nrdi_possible(&n->desc);
    for (uint32_t t = 0; t < NRDI_MAX_TEXTURES; t++) {
        const nrdi_texture_row *row = nrdi_texture_of(s->row, t);
        const char *why = "no pass that is left uses it";
        bool used = false;
        for (uint32_t p = 0; p < nrdi_pass_count(s->row); p++) {
            if (!nrdi_pass_uses(&s->row->passes[p], t)) continue;
            used = true;
            if (declared >> p & 1u) why = NULL;
        }
        if (!used) continue;
        const nrdi_reason *ruled_out = why ? NULL : nrdi_ruled_out(s->row, declared, t, possible);
        if (ruled_out) why = ruled_out->never;
        nrd_explanation item = { "texture", row->name, (uint32_t)(s - n->states), why == NULL, why, nrdi_texture_bytes(&n->desc, row), 0 };
        nrdi_offer(search, item);
    }
}

/* Each once: kept if any pass needs it. */
static void nrdi_explain_inputs(const nrd *n, const nrdi_state *s, uint32_t on, nrdi_search *search)
{
    for (uint32_t r = 0; r < NRD_RESOURCE_COUNT; r++) {
        const char *why = NULL;
        bool used = false, needed = false;
        if (nrd_resource_format((nrd_resource)r) != NRD_FORMAT_ANY) continue;
        for (uint32_t p = 0; p < nrdi_pass_count(s->row); p++)
            for (uint32_t u = 0; u < nrdi_use_count(&s->row->passes[p]); u++) {
                const nrdi_use *use = &s->row->passes[p].uses[u];
                if (use->what != r && !(use->condition && use->stand_in == r)) continue;
                const char *why_not = nrdi_why_not(&n->desc, s->row->passes[p].condition, on);
                if (!why_not && nrdi_bound(use, on) != r) why_not = nrdi_why_not(&n->desc, use->condition, on);
                used = true;
                needed |= !why_not;
                if (!why) why = why_not;   /* of the first pass that would use it: the last ones only look */
            }
        nrd_explanation item = { "input", nrd_resource_name((nrd_resource)r), (uint32_t)(s - n->states), needed, needed ? NULL : why, 0, 0 };
        if (used) nrdi_offer(search, item);
    }
}

bool nrd_explain_item(const nrd *n, uint32_t i, nrd_explanation *out)
{
    nrdi_search search = { i, out, false };
    for (uint32_t d = 0; n && out && d < n->info.denoiser_count && !search.found; d++) {
        const nrdi_state *s = &n->states[d];
        uint32_t on = nrdi_current_conditions(n, s);
        nrdi_explain_signal(n, s, &search);
        nrdi_explain_passes(n, s, on, &search);
        nrdi_explain_textures(n, s, &search);
        nrdi_explain_inputs(n, s, on, &search);
    }
    return search.found;
}

/* Counts on where the text ends. */
typedef struct nrdi_writer { char *text; size_t size, used; } nrdi_writer;

static void nrdi_write(nrdi_writer *w, const char *s)
{
    for (; *s; s++, w->used++)
        if (w->used + 1 < w->size) w->text[w->used] = *s;
    if (w->size) w->text[w->used < w->size ? w->used : w->size - 1] = 0;
}

static void nrdi_write_number(nrdi_writer *w, double v)
{
    nrdi_text t = { { 0 }, 0 };
    nrdi_put_number(&t, v);
    nrdi_write(w, t.s);
}

static void nrdi_write_all(nrdi_writer *w, const char *a, const char *b, const char *c) { nrdi_write(w, a); nrdi_write(w, b); nrdi_write(w, c); }

static double nrdi_rounded(double v) { return floor(v * 100 + 0.5) / 100; }

typedef struct nrdi_savings { uint64_t bytes; double us; } nrdi_savings;

/* Textures and signals hold bytes, signals and passes take time: counted once. */
static nrdi_savings nrdi_savings_of(const nrd *n)
{
    nrdi_savings sum = { 0, 0 };
    nrd_explanation e;
    for (uint32_t i = 0; nrd_explain_item(n, i, &e); i++) {
        if (e.kept) continue;
        sum.bytes += strcmp(e.kind, "pass") == 0 ? 0 : e.bytes;
        sum.us += e.microseconds;
    }
    return sum;
}

static void nrdi_explain_text(const nrd *n, nrdi_writer *w)
{
    nrd_explanation e;
    for (uint32_t i = 0; nrd_absence_name(i); i++)
        if (n->desc.absent >> i & 1u) { nrdi_write_all(w, "absent    ", nrd_absence_name(i), ": "); nrdi_write_all(w, nrd_absence_text(i), "\n", ""); }
    for (uint32_t i = 0, last = UINT32_MAX; nrd_explain_item(n, i, &e); i++) {
        if (e.denoiser != last) nrdi_write_all(w, nrd_denoiser_name(n->states[e.denoiser].denoiser), "\n", "");
        last = e.denoiser;
        nrdi_write_all(w, e.kept ? "  kept      " : "  left out  ", e.kind, " ");
        nrdi_write(w, e.name);
        if (e.bytes) { nrdi_write(w, e.kept ? ", " : ", saves "); nrdi_write_number(w, nrdi_rounded((double)e.bytes / 1048576.0)); nrdi_write(w, " MiB"); }
        if (e.microseconds > 0) { nrdi_write(w, e.kept ? ", about " : ", saves about "); nrdi_write_number(w, nrdi_rounded(e.microseconds)); nrdi_write(w, " us"); }
        if (e.why) nrdi_write_all(w, " (", e.why, ")");
        nrdi_write(w, "\n");
    }
    nrdi_savings saved = nrdi_savings_of(n);
    nrdi_write(w, "saved: ");
    nrdi_write_number(w, nrdi_rounded((double)saved.bytes / 1048576.0));
    nrdi_write(w, " MiB, about ");
    nrdi_write_number(w, nrdi_rounded(saved.us));
    nrdi_write_all(w, " us on ", "a data-centre GPU", "; needed: ");
    nrdi_write_number(w, nrdi_rounded((double)(n->info.permanent_bytes + n->info.transient_bytes) / 1048576.0));
    nrdi_write(w, " MiB\n");
}

static void nrdi_explain_json(const nrd *n, nrdi_writer *w)
{
    nrd_explanation e;
    nrdi_write(w, "{\"width\": "); nrdi_write_number(w, n->desc.width);
    nrdi_write(w, ", \"height\": "); nrdi_write_number(w, n->desc.height);
    nrdi_write(w, ", \"absent\": [");
    for (uint32_t i = 0, count = 0; nrd_absence_name(i); i++)
        if (n->desc.absent >> i & 1u) nrdi_write_all(w, count++ ? ", \"" : "\"", nrd_absence_name(i), "\"");
    nrdi_write(w, "],\n \"items\": [");
    for (uint32_t i = 0; nrd_explain_item(n, i, &e); i++) {
        nrdi_write_all(w, i ? ",\n  {\"denoiser\": \"" : "\n  {\"denoiser\": \"", nrd_denoiser_name(n->states[e.denoiser].denoiser), "\", \"kind\": \"");
        nrdi_write_all(w, e.kind, "\", \"name\": \"", e.name);
        nrdi_write_all(w, "\", \"kept\": ", e.kept ? "true" : "false", ", \"bytes\": ");
        nrdi_text t = { { 0 }, 0 };
        nrdi_put_uint(&t, e.bytes);
        nrdi_write_all(w, t.s, ", \"microseconds\": ", "");
        nrdi_write_number(w, nrdi_rounded(e.microseconds));
        if (e.why) nrdi_write_all(w, ", \"why\": \"", e.why, "\"");
        nrdi_write(w, "}");
    }
    nrdi_write(w, "]}\n");
}

/* "d0 texture GUIDE": passes of one name exist once per denoiser. */
static void nrdi_write_node(nrdi_writer *w, uint32_t denoiser, const char *kind, const char *name)
{
    bool shared = strcmp(kind, "input") == 0;   /* the app's images are those of all denoisers */
    nrdi_write(w, "\"");
    if (!shared) { nrdi_write(w, "d"); nrdi_write_number(w, denoiser); nrdi_write(w, " "); }
    nrdi_write_all(w, kind, " ", name);
    nrdi_write(w, "\"");
}

static void nrdi_write_edges(const nrd *n, uint32_t denoiser, const nrdi_pass_row *pass, uint32_t on, nrdi_writer *w)
{
    const nrdi_state *s = &n->states[denoiser];
    for (uint32_t u = 0; u < nrdi_use_count(pass); u++) {
        const nrdi_use *use = &pass->uses[u];
        uint32_t what = nrdi_bound(use, on), texture = what - (what >= NRDI_PREVIOUS(0) ? NRDI_PREVIOUS(0) : NRDI_TEXTURE(0));
        bool internal = what >= NRD_RESOURCE_COUNT, written = use->access == NRD_ACCESS_WRITE;
        const char *name = internal ? nrdi_texture_of(s->row, texture)->name : nrd_resource_name((nrd_resource)what);
        bool optional = use->what < NRD_RESOURCE_COUNT && nrd_resource_format((nrd_resource)use->what) == NRD_FORMAT_ANY;
        if (!nrdi_holds(use->condition, on) && (optional || what == use->what)) continue;   /* bound, but not looked at */
        nrdi_write(w, "  ");
        if (written) nrdi_write_node(w, denoiser, "pass", pass->name);
        else nrdi_write_node(w, denoiser, internal ? "texture" : "input", name);
        nrdi_write(w, " -> ");
        if (written) nrdi_write_node(w, denoiser, internal ? "texture" : "input", name);
        else nrdi_write_node(w, denoiser, "pass", pass->name);
        nrdi_write(w, what >= NRDI_PREVIOUS(0) ? " [label=\"previous\"];\n" : ";\n");
    }
}

static void nrdi_explain_graphviz(const nrd *n, nrdi_writer *w)
{
    nrd_explanation e;
    nrdi_write(w, "digraph nrd {\n  rankdir=LR;\n");
    for (uint32_t i = 0; nrd_explain_item(n, i, &e); i++) {
        nrdi_write(w, "  ");
        nrdi_write_node(w, e.denoiser, e.kind, e.name);
        nrdi_write_all(w, " [label=\"", e.name, e.why ? "\\n" : "");
        nrdi_write_all(w, e.why ? e.why : "", "\", shape=", strcmp(e.kind, "pass") == 0 ? "box" : "ellipse");
        nrdi_write(w, e.kept ? "];\n" : ", style=dashed, color=gray, fontcolor=gray];\n");
    }
    for (uint32_t d = 0; d < n->info.denoiser_count; d++) {
        uint32_t on = nrdi_current_conditions(n, &n->states[d]), declared = nrdi_declared_passes(n->states[d].row, &n->desc);
        for (uint32_t p = 0; p < nrdi_pass_count(n->states[d].row); p++) {
            const nrdi_pass_row *pass = &n->states[d].row->passes[p];
            if ((declared >> p & 1u) && nrdi_holds(pass->condition, on)) nrdi_write_edges(n, d, pass, on, w);
        }
    }
    nrdi_write(w, "}\n");
}

size_t nrd_explain(const nrd *n, nrd_explain_format format, char *text, size_t size)
{
    nrdi_writer w = { text, text ? size : 0, 0 };
    if (!n || (size && !text)) return 0;
    if (format == NRD_EXPLAIN_JSON) nrdi_explain_json(n, &w);
    else if (format == NRD_EXPLAIN_GRAPHVIZ) nrdi_explain_graphviz(n, &w);
    else nrdi_explain_text(n, &w);
    return w.used;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Rules  >>check */
typedef struct nrdi_rule { nrd_counter counter, of; float allowed; const char *name, *text; } nrdi_rule;
static const nrdi_rule nrdi_rules[] = {
#define NRDI_X(counter, of, allowed, text) { NRD_COUNTER_##counter, NRD_COUNTER_##of, allowed, #counter, text },
    NRD_RULES(NRDI_X)
#undef NRDI_X
};

/* A rule that is broken has this cause if the counter reaches the share: of all that would then be right, the largest is named. */
typedef struct nrdi_cause { nrd_counter rule, counter, of; float share; const char *text; } nrdi_cause;
#define NRDI_CAUSE(rule, counter, of, share, text) { NRD_COUNTER_##rule, NRD_COUNTER_##counter, NRD_COUNTER_##of, share, text },
#define NRDI_NORMAL_CAUSES(rule) \
    NRDI_CAUSE(rule, NORMAL_IF_NEGATED, PLANES, 0.6f, "normals point into the surface: negate them") \
    NRDI_CAUSE(rule, NORMAL_IF_X_FLIPPED, PLANES, 0.6f, "x of the normals is flipped") \
    NRDI_CAUSE(rule, NORMAL_IF_Y_FLIPPED, PLANES, 0.6f, "y of the normals is flipped") \
    NRDI_CAUSE(rule, NORMAL_IF_Z_FLIPPED, PLANES, 0.6f, "z of the normals is flipped") \
    NRDI_CAUSE(rule, NORMAL_IF_YZ_SWAPPED, PLANES, 0.6f, "y and z of the normals are swapped") \
    NRDI_CAUSE(rule, NORMAL_IF_VIEW_SPACE, PLANES, 0.6f, "normals are in view space: store world space") \
    NRDI_CAUSE(rule, NORMAL_IF_TRANSPOSED, PLANES, 0.6f, "world_to_view is transposed (column-major, column vectors)")
static const nrdi_cause nrdi_causes[] = {
    NRDI_NORMAL_CAUSES(NORMAL_AWAY)
    NRDI_NORMAL_CAUSES(NORMAL_PLANE)
    NRDI_CAUSE(MOTION_CAMERA, MOTION_IF_NEGATED, MOVED, 0.5f, "motion is current minus previous: negate it")
    NRDI_CAUSE(MOTION_CAMERA, MOTION_IF_PIXELS, MOVED, 0.5f, "motion is in pixels: set motion_scale_x = 1/width, motion_scale_y = 1/height")
    NRDI_CAUSE(MOTION_CAMERA, MOTION_IF_CLIP, MOVED, 0.5f, "motion is in clip space, y up: set motion_scale_x = 0.5, motion_scale_y = -0.5")
    NRDI_CAUSE(MOTION_CAMERA, MOTION_IF_CLIP_Y_DOWN, MOVED, 0.5f, "motion is in clip space: set motion_scale_x = 0.5, motion_scale_y = 0.5")
    NRDI_CAUSE(MOTION_CAMERA, MOTION_IF_Y_FLIPPED, MOVED, 0.5f, "y of the motion is flipped: set motion_scale_y = -1")
    NRDI_CAUSE(MOTION_CAMERA, MOTION_IF_SCALED_TWICE, MOVED, 0.5f, "motion is in uv already: leave motion_scale_x and motion_scale_y at 1")
    NRDI_CAUSE(MOTION_CAMERA, MOTION_IF_TRANSPOSED, MOVED, 0.5f, "matrices are transposed (column-major, column vectors)")
    NRDI_CAUSE(MOTION_CAMERA, MOTION_ZERO, MOVED, 0.5f, "motion is 0 though the camera moves: not written, or computed with the current camera twice")
    NRDI_CAUSE(MOTION_DEPTH, DEPTH_IF_NEGATED, DEPTH_MOVED, 0.5f, "z of the motion is current minus previous, or view z has the other sign: negate it")
    NRDI_CAUSE(MOTION_DEPTH, DEPTH_ZERO, DEPTH_MOVED, 0.5f, "z of the motion is 0: set motion_mode = NRD_MOTION_2D")
    NRDI_CAUSE(PENUMBRA_ZERO, PENUMBRA_AWAY, AWAY_FROM_LIGHT, 0.1f, "light_x, y, z points away from the light: negate it")
    NRDI_CAUSE(PENUMBRA_AWAY, PENUMBRA_ZERO, FACING_LIGHT, 0.5f, "light_x, y, z points away from the light: negate it")
};

static double nrdi_share(uint64_t count, uint64_t of) { return of ? (double)count / (double)of : 0; }

static const char *nrdi_likely_cause(const uint64_t *counters, nrd_counter rule)
{
    const nrdi_cause *best = NULL;
    double most = 0;
    for (size_t i = 0; i < sizeof nrdi_causes / sizeof nrdi_causes[0]; i++) {
        const nrdi_cause *c = &nrdi_causes[i];
        double share = nrdi_share(counters[c->counter], counters[c->of]);
        if (c->rule != rule || share < c->share || share <= most) continue;
        most = share;
        best = c;
    }
    return best ? best->text : "";
}

bool nrd_check_rule(const uint64_t *counters, uint32_t i, nrd_finding *out)
{
    if (!counters || !out || i >= sizeof nrdi_rules / sizeof nrdi_rules[0]) return false;
    const nrdi_rule *rule = &nrdi_rules[i];
    uint64_t of = counters[rule->of], count = counters[rule->counter];
    bool of_frames = rule->of == NRD_COUNTER_FRAMES;
    if (rule->counter == NRD_COUNTER_VIEWZ_NEGATIVE && count > of - count) count = of - count;   /* either sign will do */
    out->name = rule->name;
    out->text = rule->text;
    out->count = count;
    out->of = of;
    out->share = nrdi_share(count, of);
    out->allowed = rule->allowed;
    /* a few odd pixels say nothing about most */
    out->judged = of > 0 && (of_frames || rule->allowed < 0.1f || of * 300 >= counters[NRD_COUNTER_SURFACES]);
    out->broken = out->judged && out->share > (double)rule->allowed;
    out->cause = out->broken ? nrdi_likely_cause(counters, rule->counter) : "";
    return true;
}

#endif /* NRD_IMPLEMENTED */
#endif /* NRD_IMPLEMENTATION */
