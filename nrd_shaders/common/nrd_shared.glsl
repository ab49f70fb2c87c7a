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
