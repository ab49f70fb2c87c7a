// shared.h: what the shaders of examples/raygen and their C side share. Valid C and valid GLSL: macros only. Members are vec4,
// mat4 and uint, each group of four uint filling a vec4, so that std140, std430 and C agree.

#ifndef RAYGEN_SHARED_H
#define RAYGEN_SHARED_H

#define RAYGEN_BIND_FRAME 0
#define RAYGEN_BIND_BOXES 1
#define RAYGEN_BIND_MV 2
#define RAYGEN_BIND_NORMAL_ROUGHNESS 3
#define RAYGEN_BIND_VIEWZ 4
#define RAYGEN_BIND_DIFF 5
#define RAYGEN_BIND_FACTOR 6
#define RAYGEN_BIND_EMISSION 7
#define RAYGEN_BIND_SCENE 8 // acceleration structure
#define RAYGEN_BIND_COUNT 9

#define RAYGEN_MAX_BOXES 64

// raygen_frame.options
#define RAYGEN_MIRRORS 1u // what a mirror shows replaces it as the primary surface
#define RAYGEN_STRANDS 2u // the guide normal of a strand comes from its tangent
#define RAYGEN_MIX 4u     // hit distances of indirect light are mixed with the lamp's

// Alpha of the factors: what a pixel shows, for errors of parts of the picture.
#define RAYGEN_SHOWS_SOLID 0
#define RAYGEN_SHOWS_MIRROR 1
#define RAYGEN_SHOWS_STRAND 2

// Constants of a frame. The camera looks along +z, y is up in view space, clip space is Vulkan's (y down).
#define RAYGEN_FRAME(X)                                                           \
    X(mat4, world_to_view)                                                        \
    X(mat4, view_to_clip)                                                         \
    X(mat4, world_to_view_prev)                                                   \
    X(mat4, view_to_clip_prev)                                                    \
    X(vec4, camera)          /* world position */                                 \
    X(vec4, right)           /* world, to the image's right border at depth 1 */  \
    X(vec4, up)              /* world, to its upper border */                     \
    X(vec4, forward)         /* world, unit */                                    \
    X(vec4, lamp)            /* centre of the lamp's lower side */                \
    X(vec4, lamp_half)       /* its half extents along x and z */                 \
    X(vec4, lamp_radiance)                                                        \
    X(vec4, sky)             /* radiance; w: denoising range, metres */           \
    X(vec4, hit_dist_params) /* A, B, C, D */                                     \
    X(uint, width)                                                                \
    X(uint, height)                                                               \
    X(uint, frame_index)                                                          \
    X(uint, seed)            /* of the random numbers */                          \
    X(uint, paths)           /* per pixel */                                      \
    X(uint, box_count)                                                            \
    X(uint, options)         /* RAYGEN_MIRRORS, ... */                            \
    X(uint, unused)

// A box: the cube [-1,1]^3 under an affine map, whose rows are given.
#define RAYGEN_BOX(X)                                                             \
    X(vec4, to_world_x)                                                           \
    X(vec4, to_world_y)                                                           \
    X(vec4, to_world_z)                                                           \
    X(vec4, to_world_prev_x) /* last frame */                                     \
    X(vec4, to_world_prev_y)                                                      \
    X(vec4, to_world_prev_z)                                                      \
    X(vec4, to_box_x)        /* inverse of to_world */                            \
    X(vec4, to_box_y)                                                             \
    X(vec4, to_box_z)                                                             \
    X(vec4, color)           /* albedo, or reflectance of a mirror; w: 0 matte, 1 mirror, 2 lamp, 3 strand along y */

#endif
