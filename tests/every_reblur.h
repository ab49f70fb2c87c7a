/* every_reblur.h: any of the ten REBLUR denoisers with all its inputs, on denoise_rig.h. Whatever lies outside of the rectangle is NaN.
   Define the nrd.h and nrd_vk.h implementations first. */
#ifndef TESTS_EVERY_REBLUR_H
#define TESTS_EVERY_REBLUR_H

#include "denoise_rig.h"

enum { BENCH_WIDTH = 48, BENCH_HEIGHT = 32, BENCH_PIXELS = BENCH_WIDTH * BENCH_HEIGHT };

typedef struct bench bench;
/* The luma or occlusion of one path, (0, 1], and its normalised hit distance where that is not the same. */
typedef struct path { double value, hit_dist; } path;
typedef path bench_signal(const bench *b, uint32_t x, uint32_t y);

struct bench {
    rig r;                  /* its frame, camera, rectangle and index are for the test to change */
    nrd_denoiser denoiser;
    any_settings settings;
    bench_signal *signal;
    uint16_t out[NRD_RESOURCE_COUNT][BENCH_PIXELS][4];   /* of the last frame; one channel: in [0] */
};

static const nrd_denoiser bench_denoisers[10] = {
    NRD_DENOISER_REBLUR_DIFFUSE, NRD_DENOISER_REBLUR_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE_SH,
    NRD_DENOISER_REBLUR_SPECULAR_SH, NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_SH, NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION,
    NRD_DENOISER_REBLUR_SPECULAR_OCCLUSION, NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION,
};

/* One test for all ten: state is the denoiser. */
#define BENCH_TEST(test, i) { #test " " #i, test, NULL, NULL, (void *)&bench_denoisers[i] }
#define EVERY_REBLUR(test) \
    BENCH_TEST(test, 0), BENCH_TEST(test, 1), BENCH_TEST(test, 2), BENCH_TEST(test, 3), BENCH_TEST(test, 4), \
    BENCH_TEST(test, 5), BENCH_TEST(test, 6), BENCH_TEST(test, 7), BENCH_TEST(test, 8), BENCH_TEST(test, 9)

/* Noisy inputs and what comes of them. */
typedef struct bench_lane { nrd_resource in, out; uint32_t channel; bool specular; } bench_lane; /* channel: of the value in `out` */
static const bench_lane bench_lanes[] = {
    { NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST, 0, false }, { NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, NRD_RESOURCE_OUT_SPEC_RADIANCE_HITDIST, 0, true },
    { NRD_RESOURCE_IN_DIFF_SH0, NRD_RESOURCE_OUT_DIFF_SH0, 0, false }, { NRD_RESOURCE_IN_SPEC_SH0, NRD_RESOURCE_OUT_SPEC_SH0, 0, true },
    { NRD_RESOURCE_IN_DIFF_HITDIST, NRD_RESOURCE_OUT_DIFF_HITDIST, 0, false }, { NRD_RESOURCE_IN_SPEC_HITDIST, NRD_RESOURCE_OUT_SPEC_HITDIST, 0, true },
    { NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, NRD_RESOURCE_OUT_DIFF_DIRECTION_HITDIST, 3, false },
    { NRD_RESOURCE_IN_DIFF_SH1, NRD_RESOURCE_OUT_DIFF_SH1, 3, false }, { NRD_RESOURCE_IN_SPEC_SH1, NRD_RESOURCE_OUT_SPEC_SH1, 3, true },
};
enum { BENCH_LANES = sizeof bench_lanes / sizeof bench_lanes[0], BENCH_VALUE_LANES = 7 }; /* the last two tell no value of their own */

static inline bool bench_has(const bench *b, nrd_resource resource) { return b->r.images[resource].view != VK_NULL_HANDLE; }
static inline const char *bench_name(const bench *b) { return nrd_denoiser_name(b->denoiser); }
static inline bool bench_is_occlusion(const bench *b) { return nrd_settings_size(b->denoiser) == sizeof(nrd_occlusion_settings); }

/* False: the denoiser has no setting of this name. */
static inline bool bench_set(bench *b, const char *name, double value) { return put_setting_by_name(b->denoiser, &b->settings, name, value); }

static inline void bench_open(bench *b, nrd_denoiser denoiser, uint32_t width, uint32_t height, scene *what, bench_signal *signal, uint32_t features)
{
    memset(b, 0, sizeof *b);
    rig_open_with(&b->r, &device, denoiser, width, height, what, features);
    b->denoiser = denoiser;
    b->signal = signal;
    nrd_settings_defaults(denoiser, &b->settings);
}

static inline void bench_close(bench *b) { rig_close(&b->r); }

/* The next frame is the first of a shot. */
static inline void bench_restart(bench *b, uint32_t index)
{
    b->r.index = index;
    b->r.frame.restart = 1;
    b->r.camera = b->r.camera_prev = pose_at(0, 0, 0);
}

/* Directions: cosine-weighted about (0, 0, -1). */
static inline void bench_texel(const bench *b, const bench_lane *lane, uint32_t x, uint32_t y, float texel[4])
{
    path p = b->signal(b, x, y);
    double squared = random_at(x, y, 5000 + b->r.index), angle = 6.2831853 * random_at(y, x, 7000 + b->r.index);
    double direction[3] = { sqrt(squared) * cos(angle), sqrt(squared) * sin(angle), -sqrt(1 - squared) };
    bool moment = lane->channel == 3;
    for (int k = 0; k < 3 && moment; k++) texel[k] = (float)(direction[k] * p.value);
    if (!moment) texel[0] = (float)p.value, texel[1] = (float)(0.1 * p.value), texel[2] = (float)(-0.05 * p.value);
    texel[3] = (float)(lane->in == NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST ? p.value : p.hit_dist);
}

static inline void bench_upload_lane(bench *b, const bench_lane *lane)
{
    uint32_t channels = gpu_format_size(rig_format(lane->in)) / 2;
    uint16_t *texels = (uint16_t *)rig_array(&b->r, 2 * channels);
    memset(texels, 0xff, (size_t)b->r.width * b->r.height * 2 * channels);
    for (uint32_t y = 0; y < b->r.rect_height; y++)
        for (uint32_t x = 0; x < b->r.rect_width; x++) {
            float texel[4];
            bench_texel(b, lane, x, y, texel);
            half_from_floats(&texels[((size_t)y * b->r.width + x) * channels], texel, channels);
        }
    assert_true(gpu_upload(&device, &b->r.images[lane->in], texels));
    free(texels);
}

static inline void bench_upload(bench *b)
{
    size_t pixels = (size_t)b->r.width * b->r.height;
    memset(b->r.mv, 0xff, pixels * 16);
    memset(b->r.view_z, 0xff, pixels * 4);
    memset(b->r.normal, 0xff, pixels * 4);
    rig_put_guides(&b->r);
    if (bench_has(b, NRD_RESOURCE_IN_MV)) assert_true(gpu_upload(&device, &b->r.images[NRD_RESOURCE_IN_MV], b->r.mv));
    assert_true(gpu_upload(&device, &b->r.images[NRD_RESOURCE_IN_VIEWZ], b->r.view_z));
    assert_true(gpu_upload(&device, &b->r.images[NRD_RESOURCE_IN_NORMAL_ROUGHNESS], b->r.normal));
    for (int i = 0; i < BENCH_LANES; i++)
        if (bench_has(b, bench_lanes[i].in)) bench_upload_lane(b, &bench_lanes[i]);
}

static inline void bench_download(bench *b)
{
    static uint16_t texels[BENCH_PIXELS * 4];
    for (int i = 0; i < BENCH_LANES; i++) {
        nrd_resource out = bench_lanes[i].out;
        if (!bench_has(b, out)) continue;
        uint32_t channels = gpu_format_size(b->r.images[out].format) / 2;
        assert_true(gpu_download(&device, &b->r.images[out], texels));
        for (uint32_t p = 0; p < b->r.width * b->r.height; p++) memcpy(b->out[out][p], &texels[p * channels], 2 * channels);
    }
}

static inline void bench_step(bench *b)
{
    bench_upload(b);
    if (b->r.images[RIG_OUT].view) b->r.settings = b->settings.REBLUR_DIFFUSE;   /* what the rig sets itself */
    else assert_int_equal(nrd_set_settings(b->r.instance, RIG_IDENTIFIER, &b->settings), NRD_RESULT_OK);
    rig_run(&b->r, false);
    b->r.frame.restart = 0;
    bench_download(b);
}

static inline const hit *bench_hit(const bench *b, uint32_t x, uint32_t y) { return &b->r.hits[y * b->r.rect_width + x]; }
static inline double bench_channel(const bench *b, nrd_resource out, uint32_t x, uint32_t y, uint32_t channel) { return half_to_float(b->out[out][y * b->r.width + x][channel]); }
static inline double bench_value(const bench *b, const bench_lane *lane, uint32_t x, uint32_t y) { return bench_channel(b, lane->out, x, y, lane->channel); }

/* Frames, with return_history_length_instead_of_occlusion. */
static inline double bench_length(const bench *b, const bench_lane *lane, uint32_t x, uint32_t y)
{
    return bench_channel(b, lane->out, x, y, b->r.images[lane->out].format == VK_FORMAT_R16_SFLOAT ? 0 : 3);
}

#endif
