/* method.h: one denoiser with one preset or variant of its settings, on the frames of a sequence. */
#ifndef EXAMPLES_REPORT_METHOD_H
#define EXAMPLES_REPORT_METHOD_H

#include "report/copier.h"
#include "report/report.h"

enum { METHOD_MAX_SETTINGS = 128, REPORT_MAX_METHODS = 256 };

typedef struct method {
    nrd_denoiser denoiser;
    char preset[REPORT_NAME];
    bool is_default;                 /* the preset whose settings are the defaults */
    setting_value settings[METHOD_MAX_SETTINGS];
    uint32_t setting_count;
    denoise_desc desc;
    denoise *d, *clock;              /* clock: that on which times are taken; d where the size is the same */
    uint32_t index;                  /* of the next frame */
    struct timings *timings;
    bool writes[SIGNAL_COUNT];
    double ms, low, high;            /* of a frame, 0 without timestamps */
    double bytes;                    /* moved by a frame of the size at which times are taken */
    double copy_ms;                  /* of a plain copy of as many bytes */
    copier_way copy_way;             /* the fastest in the last warm-up */
    double permanent_bytes, transient_bytes;
    report_pass passes[REPORT_MAX_PASSES];
    int pass_count;
} method;

/* Fills settings: those of a preset, or of a variant (`preset` is then ignored), as far as they differ from the defaults and
   the denoiser has them. False with r->error. */
bool method_describe(report *r, nrd_denoiser denoiser, nrd_preset preset, const report_variant *variant, method *out);

/* Does the denoiser average whatever it is given? Then it runs once for each signal. */
bool method_takes_any_signal(const method *m, const capture *first);

/* Sets the denoiser to inputs that are checkerboards, the diffuse lobe on the black pixels, the specular one on the white. False where
   it takes none; one that averages any signal takes the filled-up picture as it is. */
bool method_take_checkerboard(method *m, const capture *first);

/* Does the scene have what the denoiser needs, a sun for instance? If not, `reason` says what is missing. */
bool method_fits(const method *m, const capture *first, char *reason, size_t reason_size);

/* Does the denoiser read shadow rays? Scenes made for shadows are for those alone. */
bool method_takes_shadows(const method *m, const capture *first);

/* Does it read hit distances alone, of one path? A capture has one hit distance for several paths, which is not their mean occlusion. */
bool method_takes_one_path(const method *m, const capture *first);

/* Opens the denoiser on the report's device and finds out what it writes. */
bool method_open(report *r, method *m, const capture *first);

/* Time and memory on a frame in the middle of a shot, of any size: started (`bytes` is known then), run as often as wanted, in
   turn with other methods and each time followed by a copy, and ended. `counts`: not a warm-up. Frames denoised afterwards must
   begin with a cut. */
bool method_time_start(report *r, method *m, const capture *frame);
bool method_time_once(report *r, method *m, const capture *frame, copier *copies, bool counts);
void method_time_end(method *m);

void method_close(method *m);

/* Denoises the next frame; out: NULL where the picture is not wanted. Methods may run on a thread each. */
bool method_frame(report *r, method *m, const capture *frame, capture *out);

#endif
