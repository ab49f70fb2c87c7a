/* capture.h: one frame of a capture (what a renderer hands the denoiser) as named float planes and attributes, read from
   and written to OpenEXR files.

   A capture is a folder of files frame.0000.exr, frame.0001.exr, ..., one per frame: single part, scanlines, channels of
   type half, float or uint, any compression that OpenEXRCore decodes. In memory every plane is 32-bit float, row 0 on top,
   tightly packed. Channels and attributes that are not known here are ignored on reading (channels are all kept as planes;
   sub-sampled channels are not).

   Functions that can fail return false and write one line, "FILE: cause", to `error` (at most `error_size` bytes; NULL
   and 0 are allowed). Nothing is printed. Link with OpenEXRCore. */
#ifndef EXAMPLES_CAPTURE_H
#define EXAMPLES_CAPTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The longest plane name, and a path that is long enough, with their terminators. */
#define CAPTURE_NAME_SIZE 64
#define CAPTURE_PATH_SIZE 1024

/* Header attributes: bit name, OpenEXR name, OpenEXR type, member of `capture`. */
#define CAPTURE_ATTRIBUTES(X)                                               \
    X(WORLD_TO_CAMERA, worldToCamera, m44f, world_to_camera)                \
    X(CAMERA_TO_CLIP, cameraToClip, m44f, camera_to_clip)                   \
    X(JITTER, jitter, v2f, jitter)                                          \
    X(FRAME_INDEX, frameIndex, int, frame_index)                            \
    X(TIME_DELTA, timeDelta, float, time_delta_s)                           \
    X(DENOISING_RANGE, denoisingRange, float, denoising_range)              \
    X(SUN_DIRECTION, sunDirection, v3f, sun_direction)                      \
    X(SUN_TAN_ANGULAR_RADIUS, sunTanAngularRadius, float, sun_tan_angular_radius) \
    X(LAMP_POSITION, lampPosition, v3f, lamp_position)                      \
    X(LAMP_RADIUS, lampRadius, float, lamp_radius)                          \
    X(METRES_PER_UNIT, metresPerUnit, float, metres_per_unit)               \
    X(CUT, cut, int, cut)

enum {
#define CAPTURE_ORDINAL(bit, exr, type, member) CAPTURE_ORDINAL_##bit,
    CAPTURE_ATTRIBUTES(CAPTURE_ORDINAL)
#undef CAPTURE_ORDINAL
    CAPTURE_ATTRIBUTE_COUNT
};

/* Bits of `capture.present`. */
enum {
#define CAPTURE_BIT(bit, exr, type, member) CAPTURE_HAS_##bit = 1 << CAPTURE_ORDINAL_##bit,
    CAPTURE_ATTRIBUTES(CAPTURE_BIT)
#undef CAPTURE_BIT
    CAPTURE_HAS_CAMERA = CAPTURE_HAS_WORLD_TO_CAMERA | CAPTURE_HAS_CAMERA_TO_CLIP
};

/* How a plane is stored in a file. Half: rounded to nearest, finite values beyond 65504 saturate. */
typedef enum capture_type { CAPTURE_HALF, CAPTURE_FLOAT } capture_type;

typedef struct capture_plane {
    char name[CAPTURE_NAME_SIZE]; /* for instance "diffuse.R" */
    capture_type type;
    float *texels;                /* width * height values */
} capture_plane;

typedef struct capture {
    int width, height;            /* pixels */
    uint32_t present;             /* CAPTURE_HAS_*: attributes that were read; those to write */
    float world_to_camera[16];    /* row vectors, rows one after the other: camera = world * M; left-handed, +y up, +z forward */
    float camera_to_clip[16];     /* same convention, not jittered, z/w in [0,1] or reversed */
    float jitter[2];              /* [-0.5, 0.5] pixels, y down: offset of the primary rays; 0 when absent */
    int frame_index;              /* 0 when absent */
    float time_delta_s;           /* seconds since the previous frame; 0: unknown */
    float denoising_range;        /* world units: pixels with |viewZ| at or above it are sky; infinite when absent */
    float sun_direction[3];       /* unit, from the surface to the light; 0 when absent */
    float sun_tan_angular_radius; /* 0 when absent */
    float lamp_position[3];       /* world space: shadow.* is that of a round lamp, not of a sun */
    float lamp_radius;            /* world units; 0 when absent */
    float metres_per_unit;        /* 1 when absent */
    float occlusion[4];           /* A, B, C, D of nrd_normalize_hit_dist(), world units: what makes occlusion of hit distances; all 0: 3
                                     metres everywhere, as in files, which do not hold it */
    int cut;                      /* 1: the frame starts a new shot; 0 when absent */
    capture_plane *planes;
    uint32_t plane_count;
} capture;

/* An empty frame of 1..32768 pixels a side, attributes at the values that stand for "absent". False when a size is out
   of range. */
bool capture_create(capture *out, int width, int height);

/* Everything but the planes and the size. */
void capture_copy_attributes(capture *to, const capture *from);

/* Frees the planes. A zeroed capture is allowed; the capture is zeroed. */
void capture_destroy(capture *c);

/* A plane of zeros, owned by the capture; the existing one, unchanged, when the name is taken. NULL when the name is
   empty or too long, or memory is short. */
float *capture_add_plane(capture *c, const char *name, capture_type type);

/* NULL when there is none of that name. */
float *capture_find_plane(const capture *c, const char *name);

/* Finds the planes PREFIX.S for every letter S of `suffixes` ("RGB", "XYZ"). False when one is missing: `planes` is then
   left as it was. */
bool capture_find_planes(const capture *c, const char *prefix, const char *suffixes, float **planes);

/* True when every attribute of `attributes` (CAPTURE_HAS_* bits) and every one of the `count` planes is there; otherwise
   the first that is missing is named. `path` only serves the message. */
bool capture_require(const capture *c, const char *path, uint32_t attributes, const char *const *planes, size_t count,
                     char *error, size_t error_size);

/* Reads a file. `out` needs no initialisation and is zeroed on failure. */
bool capture_read(const char *path, capture *out, char *error, size_t error_size);

/* Writes PATH.part, PIZ compressed, then renames it to PATH: a failure leaves neither the partial file nor a changed
   PATH. */
bool capture_write(const char *path, const capture *c, char *error, size_t error_size);

/* FOLDER/frame.NNNN.exr; `path` is best CAPTURE_PATH_SIZE bytes. */
void capture_frame_path(char *path, size_t path_size, const char *folder, int frame);

/* First and last frame number in a folder. False when it cannot be opened, holds no frame or lacks one in between. */
bool capture_frame_range(const char *folder, int *first, int *last, char *error, size_t error_size);

#endif
