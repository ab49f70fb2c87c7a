/* report.h: what nrd-report measures: rows of numbers, one per scene, size, paths per pixel, method and signal.

   The files beside this one: sequence.c renders, method.c denoises and times, baseline.c is what denoisers compete with,
   score.c compares, tiles.c times what is left out, rows.c keeps what is done, print.c and page.c show it (output.h),
   tuning.c what nrd-tune has found. None of them knows a denoiser by name. */
#ifndef EXAMPLES_REPORT_REPORT_H
#define EXAMPLES_REPORT_REPORT_H

#include "common/capture.h"
#include "common/denoise.h"
#include "common/gpu.h"
#include "scenes/scene.h"

enum {
    REPORT_MAX_SCENES = 16, REPORT_MAX_SIZES = 8, REPORT_MAX_PATHS = 8, REPORT_MAX_VARIANTS = 24, REPORT_MAX_SETTINGS = 16,
    REPORT_MAX_PASSES = 24, REPORT_MAX_FRAMES = 256, REPORT_SKY_SHARES = 5, REPORT_NAME = 64, REPORT_ERROR = 512
};

/* ---- what is asked for ---- */

/* Settings measured beside the presets: a name and KEY=VALUE pairs. */
typedef struct report_variant {
    char name[REPORT_NAME];
    const char *settings[REPORT_MAX_SETTINGS];
    uint32_t count;
} report_variant;

typedef struct report_size { int width, height; } report_size;

/* Paths per pixel and lobe; below 1: in that share of the pixels, chosen by chance in every frame; or, as a checkerboard, in every
   other pixel of a lobe, which turns every frame, and of those in as many as make up the share. */
typedef struct report_paths { double count; bool checkerboard; } report_paths;

typedef struct report_options {
    const scene_def *scenes[REPORT_MAX_SCENES];
    int scene_count;
    nrd_denoiser denoisers[NRD_DENOISER_COUNT];
    uint32_t denoiser_count;
    nrd_preset presets[NRD_PRESET_COUNT];
    uint32_t preset_count;
    report_variant variants[REPORT_MAX_VARIANTS];
    uint32_t variant_count;
    report_size sizes[REPORT_MAX_SIZES]; /* at which errors are measured */
    int size_count;
    report_size time_size;          /* at which times are measured; 0: at that of the errors */
    report_paths paths[REPORT_MAX_PATHS];
    int path_count;
    int moving, still, stepped;     /* frames in motion, at rest, and after the light step */
    int pairs;                      /* of frames in motion that have a reference */
    int samples;                    /* per pixel of a reference */
    int repeats;                    /* timed frames */
    int device;
    const char *folder;
    uint64_t program;               /* fingerprint of the program that measures */
} report_options;

/* ---- rows ---- */

/* X(name, unit, what it is): numbers of a row; NaN: not measured. */
#define REPORT_COLUMNS(X) \
    X(ms, "ms", "median device time of a frame, all passes; timestamps, after a warm-up") \
    X(ms_low, "ms", "first quartile of that") \
    X(ms_high, "ms", "third quartile of that") \
    X(ns_per_pixel, "ns", "ms / pixels of the size at which times are taken") \
    X(bytes_per_pixel, "B", "of every image that the passes read and of every one that they write, each counted once per pass, from the graph") \
    X(copy_share, "", "time in which a plain copy moves as many bytes on this device, in the same run and in the fastest of three ways, / ms") \
    X(copy_rate, "GB/s", "at which that copy moves them, half of them read, half written") \
    X(permanent_bytes, "B", "textures that keep their contents from frame to frame") \
    X(transient_bytes, "B", "textures of one frame, after sharing memory") \
    X(trace_ms, "ms", "median device time of tracing the input, at least one path per pixel") \
    X(paths_traced, "", "paths per pixel and lobe that went into the picture of a frame") \
    X(motion_relmse, "", "frames in motion: mean of (d - r)^2 / (r^2 + 0.01) over channels and pixels (Rousselle et al. 2011, section 3)") \
    X(motion_trimmed, "", "frames in motion: relMSE without the worst 0.1 % of the pixels") \
    X(motion_psnr, "dB", "frames in motion: -20 log10 of the root mean square of tm(d) - tm(r); tm(x) = (y / (1 + y))^(1/2.2), y = exposure x (Reinhard et al. 2002, equation 3); exposure brings the geometric mean of r to 0.25") \
    X(motion_ssim, "", "frames in motion: mean structural similarity of tm of the luminance: (2 m_d m_r + c1) (2 s_dr + c2) / ((m_d^2 + m_r^2 + c1) (s_d^2 + s_r^2 + c2)), m, s^2, s_dr means, variances and covariance under an 11 x 11 Gaussian of sigma 1.5, c1 = 0.01^2, c2 = 0.03^2 (Wang et al. 2004, equation 13)") \
    X(motion_flip, "", "frames in motion: mean LDR-FLIP of tm at 67 pixels per degree: d_c^(1 - d_f), d_c the difference of colours as the eye blurs them, d_f of edges and points (Andersson et al. 2020, section 4)") \
    X(motion_bias, "", "frames in motion: (mean L(d) - mean L(r)) / mean L(r), L Rec. 709 luminance") \
    X(motion_flicker, "", "mean |tm(L(d)) - tm(L(d of the frame before)) at the previous place| where the surface was visible (depth within 2 %, normals within 37 degrees, same material), minus the same of the reference (own definition)") \
    X(rest_relmse, "", "at rest, last half of those frames: relMSE") \
    X(rest_trimmed, "", "at rest: trimmed relMSE") \
    X(rest_psnr, "dB", "at rest: PSNR of tm") \
    X(rest_ssim, "", "at rest: SSIM") \
    X(rest_flip, "", "at rest: FLIP, last frame") \
    X(rest_bias, "", "at rest: bias") \
    X(rest_flicker, "", "at rest: flicker; the reference's is 0") \
    X(lag, "frames", "frames until mean L(d) has gone 90 % of the way after all lights become 4 times as bright; radiance only; the number of frames watched when it does not get there (own definition)") \
    X(ghost, "", "where a surface has just come into view: sum of w (L(d) - L(r)) (L(g) - L(r)) / sum of w (L(g) - L(r))^2, g what the reference showed there one frame before, w = 1 / (L(r)^2 + L(g)^2 + 0.01): 0 nothing of it shines through, 1 all (own definition)") \
    X(fireflies, "per megapixel", "pixels with L(d) > 3 max L(r) within 2 px + 0.05 / exposure, in motion (own definition)") \
    X(edge_trimmed, "", "trimmed relMSE within 4 px of edges, in motion: between neighbours the material differs, normals turn by more than 37 degrees, or depth leaves the line through both neighbours by 2 % (own definition)") \
    X(worst_tile, "", "largest root mean square of tm(d) - tm(r) of all 32 x 32 tiles of which half counts, in motion (own definition)") \
    X(reference_noise, "", "trimmed relMSE that the reference's own noise adds, from the difference of its two halves")

typedef enum report_column {
#define REPORT_COLUMN(name, unit, text) REPORT_##name,
    REPORT_COLUMNS(REPORT_COLUMN)
#undef REPORT_COLUMN
    REPORT_COLUMN_COUNT
} report_column;

typedef struct report_column_info { const char *name, *unit, *text; } report_column_info;
extern const report_column_info report_columns[REPORT_COLUMN_COUNT];

/* Kinds of rows. */
#define REPORT_KIND_DENOISER "denoiser"
#define REPORT_KIND_NOISY "noisy"
#define REPORT_KIND_SPATIAL "spatial"
#define REPORT_KIND_PATHS "more paths"

typedef struct report_pass { char name[REPORT_NAME]; double ms, low, high; } report_pass; /* median and quartiles */

typedef struct report_row {
    char scene[REPORT_NAME], kind[REPORT_NAME], method[REPORT_NAME], preset[REPORT_NAME], signal[REPORT_NAME];
    int width, height, time_width, time_height;
    report_paths paths;
    double values[REPORT_COLUMN_COUNT];
    report_pass passes[REPORT_MAX_PASSES];
    int pass_count;
    double curve[REPORT_MAX_FRAMES]; /* trimmed relMSE by frame, NaN where there is no reference */
    int curve_count;
} report_row;

typedef struct report_rows {
    report_row *rows;
    int count, capacity;
} report_rows;

/* Time of a frame of a synthetic scene, a share of which is sky: median and quartiles. */
typedef struct report_tiles {
    char denoiser[REPORT_NAME];
    int width, height;
    double sky, active; /* shares: of the picture; of the tiles of 8x8 pixels, those that are not all sky */
    double ms, low, high;
} report_tiles;

typedef struct report {
    report_options options;
    report_rows rows;
    report_tiles tiles[REPORT_SKY_SHARES * NRD_DENOISER_COUNT]; /* of each share all denoisers, from no sky to nothing else */
    int tile_count;
    gpu gpu; /* the device of all that is measured */
    char device[256];
    char error[REPORT_ERROR];
} report;

/* Writes the reason to r->error; returns false. Any thread may call it. */
bool report_fail(report *r, const char *format, ...);

/* Of the paths per pixel that are asked for, the number nearest to 1. */
report_paths report_usual_paths(const report_options *o);
bool report_same_paths(report_paths a, report_paths b);

/* A row of NaNs at the end; NULL when memory is short. Pointers to other rows become invalid. */
report_row *rows_add(report_rows *rows);

/* A group of rows (scene, size, paths) that is measured as one. Its file exists only when it is complete. */
typedef struct report_group { const scene_def *scene; report_size size; report_paths paths; } report_group;
bool rows_load(report *r, const report_group *group); /* false: not there, or measured with other options */
bool rows_save(report *r, const report_group *group, int first);

/* Measures a group, adding its rows. */
bool report_measure(report *r, const report_group *group, int done, int total);

#endif
