/* denoise.h: runs denoisers of nrd.h on frames of a capture, on the Vulkan device of gpu.h: packs the inputs as an engine's
   shaders would, uploads, records, waits, reads back.

   The program that links this holds the implementations of nrd.h and nrd_vk.h. Functions that can fail return false (or
   NULL) and write one line to `error`. */
#ifndef EXAMPLES_DENOISE_H
#define EXAMPLES_DENOISE_H

#include "common/capture.h"
#include "common/settings.h"
#include "common/signals.h"

#define DENOISE_MAX_DENOISERS 8

typedef struct denoise_desc {
    nrd_denoiser denoisers[DENOISE_MAX_DENOISERS];
    uint32_t denoiser_count;
    uint32_t absent;              /* nrd_desc.absent */
    signal_id reference_signal;   /* what the denoiser "reference" averages */
    const setting_value *settings; /* kept, not copied */
    uint32_t setting_count;
    struct gpu *device;           /* an open one to work on, beside others on threads of their own; NULL: opens one */
    int device_index;             /* of the one to open: position in vkEnumeratePhysicalDevices; negative: the first */
    bool validate;                /* under the validation layer, with synchronisation checks */
    bool check;                   /* with the input checker */
    bool overlay;                 /* with the validation overlay, of the first denoiser unless the setting `validation` says otherwise */
} denoise_desc;

typedef struct denoise denoise;

typedef struct denoise_timing {
    const char *pass;
    double milliseconds; /* on the device */
} denoise_timing;

/* Checks that a frame has what the denoisers need; names the first channel or attribute that is missing. No GPU is
   touched. Also refuses denoisers that write the same signal. */
bool denoise_check(const denoise_desc *desc, const capture *frame, const char *path, char *error, size_t error_size);

/* Where the messages of an instance go; outlives it. */
typedef struct denoise_sink {
    char *text;
    size_t size;
} denoise_sink;

/* The instance of nrd.h that a capture like `frame` needs, without a GPU: for nrd_get_info. Features are declared as the
   settings and the frame's optional channels ask for. NULL on failure. */
nrd *denoise_make_instance(const denoise_desc *desc, const capture *frame, denoise_sink *sink);

/* Opens the device and creates the denoisers for frames like `frame`. NULL on failure. */
denoise *denoise_create(const denoise_desc *desc, const capture *frame, char *error, size_t error_size);

/* Denoises the next frame. `index` grows by 1 from frame to frame; history restarts at the first frame and where the
   frame's `cut` is set. `out` gets the frame's attributes and the planes of what was denoised, denoised.final where the
   composition channels are there (signals that were not denoised enter noisy), and denoised.diffuse.ao where the hit
   distance was normalised as the frame's occlusion is, in files by A = 3 metres, B = 0 (otherwise occlusion denoisers write denoised.diffuse.hitDist). In pixels of the sky the noisy values are passed on. */
bool denoise_frame(denoise *d, const capture *frame, const char *path, uint32_t index, capture *out, char *error, size_t error_size);

/* Adds what the input checker says of the last frame given to denoise_frame or denoise_look to `counters` (NRD_COUNTER_COUNT), for
   nrd_check_rule. Packing repairs what a capture's planes hold, so NaN, negative numbers and lengths of normals are counted there. */
bool denoise_count(denoise *d, const capture *frame, uint64_t *counters, char *error, size_t error_size);

/* The validation overlay of the last frame: RGB, 8 bits, top row first. */
bool denoise_overlay(denoise *d, unsigned char *rgb, char *error, size_t error_size);

/* As denoise_frame, without reading back what was denoised. */
bool denoise_look(denoise *d, const capture *frame, const char *path, uint32_t index, char *error, size_t error_size);

/* Runs the passes once more on the inputs of the last frame, as frame `index`, without transfers: for timings. */
bool denoise_again(denoise *d, const capture *frame, uint32_t index, char *error, size_t error_size);

/* Bytes that the passes of a frame in the middle of a shot move, as traffic.h counts them. 0 on failure. */
double denoise_bytes_moved(denoise *d, const capture *frame);

/* Textures, passes and memory of the denoisers. */
const nrd_info *denoise_info(const denoise *d);

/* The passes of the last frame, in order; `count` is 0 on devices without timestamps. */
const denoise_timing *denoise_timings(const denoise *d, uint32_t *count);

const char *denoise_device_name(const denoise *d);

/* Validation messages so far. */
uint32_t denoise_message_count(const denoise *d);

void denoise_destroy(denoise *d); /* NULL is fine */

#endif
