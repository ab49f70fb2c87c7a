/* Cut out of nrd.h by `make shared`; edit it there. */
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

/* Optional inputs and passes an app may declare in nrd_desc.features; what is not declared is not compiled, bound or allocated. */
#define NRD_FEATURE_HISTORY_CONFIDENCE         1
#define NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX 2
#define NRD_FEATURE_PREPASS                    4
#define NRD_FEATURE_SPLIT_SCREEN               8
#define NRD_FEATURE_ALL                        15

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
    X(vec4, motion_scale) \
    X(vec4, hit_distance)           /* A, B, C, D of nrd_hit_dist_scale */ \
    X(vec4, jitter_delta)           /* xy: current - previous, px */ \
    X(vec4, light)                  /* view space: unit vector to a directional light (w 0), position of a local one (w 1); xyz 0: unknown */ \
    X(uint, rect_width) X(uint, rect_height) X(uint, rect_width_prev) X(uint, rect_height_prev) \
    X(uint, rect_origin_x) X(uint, rect_origin_y) X(uint, frame_index) X(uint, reset) \
    X(float, orthographic) X(float, orthographic_prev) X(float, pixel_unproject) X(float, view_z_scale) \
    X(float, denoising_range) X(float, disocclusion_threshold) X(float, disocclusion_threshold_alternate) X(float, split_screen) \
    X(uint, motion_mode) X(uint, history_frames) X(float, max_accumulated_frames) X(float, max_stabilized_frames) \
    X(float, history_fix_frames) X(float, max_blur_radius) X(float, prepass_blur_radius) X(float, luminance_sigma_scale) \
    X(float, plane_distance_sensitivity) X(float, normal_sensitivity) X(float, antilag_sigma_scale) X(float, antilag_sensitivity) \
    X(float, stabilization_sigma_scale) X(float, feedback_frames) X(uint, min_material) X(uint, flags) \
    X(float, denoising_range_prev) X(float, specular_prepass_blur_radius) X(float, light_radius) X(float, penumbra_blur_scale)

/* nrd_constants.flags */
#define NRD_FLAG_HISTORY_CONFIDENCE  1u
#define NRD_FLAG_DISOCCLUSION_MIX    2u
#define NRD_FLAG_RETURN_HISTORY      4u
#define NRD_FLAG_ANTILAG             8u
#define NRD_FLAG_PREPASS            16u
#define NRD_FLAG_SPECULAR_PREPASS   64u
#define NRD_FLAG_TILE_HISTORY       32u /* the previous frame has looked for lighting changes */

/* Push constants of every pass: 16 bytes. */
#define NRD_PUSH_CONSTANTS(X) X(int, step_size) X(uint, iteration) X(uint, last) X(uint, unused)
