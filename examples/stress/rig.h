/* rig.h: one denoiser on a device with its images, fed with whatever a case wants. Which inputs there are, what they hold and which
   settings exist comes from the tables of nrd.h, so that a new denoiser needs nothing here.

   Inputs are given as four floats per pixel, whatever the image's format. What cannot go wrong unless the device is lost or the code is
   broken ends the program with one line. */
#ifndef STRESS_RIG_H
#define STRESS_RIG_H

#include "nrd_vk.h"

#include "common/gpu.h"
#include "common/pose.h"
#include "common/settings.h"

enum { RIG_IDENTIFIER = 7, RIG_MAX_SIGNALS = 6, RIG_SLOTS = 16 };
#define RIG_SKY 1e30

typedef enum signal_kind {
    KIND_NONE,
    KIND_RADIANCE,     /* Y, Co, Cg, normalised hit distance */
    KIND_VECTOR,       /* Y times a direction */
    KIND_HIT_DIST,     /* normalised */
    KIND_DIRECTION,    /* hit distance times a direction, hit distance */
    KIND_PENUMBRA,     /* in: half width; out: visibility */
    KIND_TRANSLUCENCY, /* in: coloured visibility, out: too */
    KIND_PLAIN         /* any number */
} signal_kind;

/* A noisy input, and where it comes out. */
typedef struct rig_signal {
    nrd_resource in, out; /* out: NRD_RESOURCE_COUNT: nowhere of its own */
    signal_kind kind;
} rig_signal;

/* What a pixel sees. */
typedef struct surface {
    double depth;         /* units along the view axis; RIG_SKY: nothing */
    double normal[3];     /* world */
    double roughness;
    uint32_t material;
    double moved[3];      /* where the point was in the previous frame, minus where it is */
} surface;

/* Faults to be planted into what is downloaded, as if the denoiser had them: what has never failed proves nothing. X(name, text) */
#define FAULTS(X) \
    X(NONE, "none") X(NAN, "nan") X(BRIGHT, "bright") X(DARK, "dark") X(COLOUR, "colour") X(NOISY, "noisy") X(WRITTEN, "written") \
    X(UNSTEADY, "unsteady") X(BLACK, "black") X(DRIFTING, "drifting") X(SMEARED, "smeared") X(ACCEPTED, "accepted")
typedef enum fault {
#define FAULT_MEMBER(name, text) FAULT_##name,
    FAULTS(FAULT_MEMBER)
#undef FAULT_MEMBER
    FAULT_COUNT
} fault;
const char *fault_name(fault f);

typedef struct rig rig;
typedef surface shape(const rig *r, uint32_t x, uint32_t y);

struct rig {
    gpu *device;
    nrd_denoiser denoiser;
    nrd *instance;
    nrd_vk *vk;
    uint32_t width, height;                    /* of the images */
    uint32_t rect_width, rect_height, origin_x, origin_y;
    nrd_frame frame;                           /* all but camera, frame_index and the rectangle */
    any_settings settings;
    uint32_t index;                            /* of the next frame */
    pose camera, camera_prev;
    shape *shape;
    double depth, tilt, roughness;             /* of the shapes: units, degrees */
    uint32_t variant;                          /* for the shape's own use */
    rig_signal signals[RIG_MAX_SIGNALS];
    uint32_t signal_count;
    gpu_image images[NRD_RESOURCE_COUNT];
    float *texels[NRD_RESOURCE_COUNT];         /* four per pixel: inputs to be uploaded, outputs as downloaded */
    uint8_t *material;
    uint32_t normal_encoding;                  /* the image is RGB10A2 under all of them */
    uint32_t *raw_normals;                     /* instead of the packed normals where not NULL */
    void *packed, *sent[NRD_RESOURCE_COUNT];   /* sent: what the images of inputs hold */
    char message[256];                         /* the last error */
    fault fault;
    uint32_t ran, downloads;                   /* frames since the reset; since the rig was opened */
    const setting_value *set;                  /* on top of the defaults */
    uint32_t set_count;
};

/* Ends the program. */
void stress_die(const char *format, ...);

typedef struct rig_desc {
    gpu *device;
    nrd_denoiser denoiser;
    uint32_t width, height, features, normal_encoding, frames_in_flight; /* 0: 1 */
    fault fault;
    const setting_value *set;
    uint32_t set_count;
} rig_desc;

void rig_open(rig *r, const rig_desc *desc);
void rig_close(rig *r);
/* Defaults of frame, settings, camera, shape and rectangle; history restarts. */
void rig_reset(rig *r);

/* Guides of the current camera, shape and frame. */
void rig_put_guides(rig *r);
float *rig_texel(const rig *r, nrd_resource resource, uint32_t x, uint32_t y); /* within the rectangle, wherever it lies in that image */
surface rig_surface(const rig *r, uint32_t x, uint32_t y);
bool rig_is_sky(const rig *r, uint32_t x, uint32_t y);
bool rig_is_too_rough(const rig *r, uint32_t signal, uint32_t x, uint32_t y); /* for that signal, by specular_roughness_limit */

void rig_upload(rig *r, nrd_resource resource);
void rig_upload_all(rig *r); /* inputs, and rig_untouched() into the outputs */
float rig_untouched(nrd_resource out);
void rig_download(rig *r);

/* What nrd_set_settings and nrd_set_frame said; on success the frame has run. */
nrd_result rig_try(rig *r);
/* rig_upload_all, a frame that must succeed, rig_download. */
void rig_run(rig *r);
/* Frames without transfers, `inputs[i % count]` in place of the noisy inputs: images per signal. */
void rig_run_many(rig *r, uint32_t frames, gpu_image *const *inputs, uint32_t count);
gpu_image rig_make_input(rig *r, uint32_t signal);

/* Setting by name; false: this denoiser has none of that name. */
bool rig_set(rig *r, const char *name, double value);

/* The value of a pixel as one number that averages linearly: luma, hit distance, visibility. input: of the noisy signal, as the denoiser
   must understand it. */
double rig_input_value(const rig *r, uint32_t signal, uint32_t x, uint32_t y);
double rig_output_value(const rig *r, uint32_t signal, uint32_t x, uint32_t y);

#endif
