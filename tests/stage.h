/* stage.h: any denoiser on a device with all its images, fed with noise over a floor and a wall under a still camera. Define the nrd.h
   and nrd_vk.h implementations first. */
#ifndef TESTS_STAGE_H
#define TESTS_STAGE_H

#include "nrd_vk.h"

#include "common/half.h"
#include "common/pack.h"
#include "device.h"
#include "frame_fixture.h"

enum { STAGE_WIDTH = 40, STAGE_HEIGHT = 24, STAGE_PIXELS = STAGE_WIDTH * STAGE_HEIGHT, STAGE_IDENTIFIER = 7 };

typedef struct stage {
    spy spy;
    nrd *instance;
    nrd_vk *vk;
    gpu_image images[NRD_RESOURCE_COUNT];
    bool (*is_sky)(uint32_t x, uint32_t y, uint32_t frame);   /* NULL: nowhere */
    int (*light)(uint32_t x, uint32_t y, uint32_t frame);     /* 1: all rays arrive, -1: none, -2: none, by far, 0: half of them. NULL: 0 */
    bool (*is_rough)(uint32_t x, uint32_t y, uint32_t frame); /* roughness 0.52 instead of 0.48, which are mixed; NULL: on the right, 0.8 instead of 0.3 */
    bool rubbish;                                             /* what is rough has NaN and whatever as specular inputs */
    float (*brightness)(uint32_t frame);                      /* of radiance; NULL: 1 */
    uint32_t rect_width, rect_height;                         /* px; 0: all */
} stage;

static inline VkFormat stage_format(nrd_resource resource)
{
    VkFormat stored = nrd_vk_format(nrd_resource_format(resource));
    if (resource == NRD_RESOURCE_IN_NORMAL_ROUGHNESS) return VK_FORMAT_A2B10G10R10_UNORM_PACK32;
    if (resource == NRD_RESOURCE_IN_VIEWZ) return VK_FORMAT_R32_SFLOAT;
    return stored ? stored : VK_FORMAT_R16G16B16A16_SFLOAT;
}

/* callbacks: NULL, or a desc with those for device memory, or to find the functions of the device. */
static inline void stage_open_with(stage *s, nrd_denoiser denoiser, uint32_t features, uint32_t absent, const nrd_vk_desc *callbacks)
{
    nrd_denoiser_desc one = { STAGE_IDENTIFIER, denoiser };
    memset(s, 0, sizeof *s);
    nrd_desc desc = spied_desc(&s->spy, &one, 1, STAGE_WIDTH, STAGE_HEIGHT, features);
    desc.absent = absent;
    assert_int_equal(nrd_create(&desc, &s->instance), NRD_RESULT_OK);
    nrd_vk_desc vk = { .instance = s->instance, .vk_instance = device.instance, .physical = device.physical, .device = device.device,
                       .get_instance_proc = device.get_instance_proc, .frames_in_flight = 1 };
    if (callbacks) {
        vk.allocate_memory = callbacks->allocate_memory, vk.free_memory = callbacks->free_memory, vk.memory_user = callbacks->memory_user;
        vk.get_device_proc = callbacks->get_device_proc;
    }
    assert_int_equal(nrd_vk_create(&vk, &s->vk), NRD_RESULT_OK);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++)
        if (nrd_uses_resource(s->instance, (nrd_resource)i))
            assert_true(gpu_image_create(&device, STAGE_WIDTH, STAGE_HEIGHT, stage_format((nrd_resource)i), nrd_resource_name((nrd_resource)i), &s->images[i]));
}

static inline void stage_open(stage *s, nrd_denoiser denoiser, uint32_t absent, const nrd_vk_desc *callbacks) { stage_open_with(s, denoiser, 0, absent, callbacks); }

static inline void stage_close(stage *s)
{
    nrd_vk_destroy(s->vk);
    nrd_destroy(s->instance);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) gpu_image_destroy(&device, &s->images[i]);
}

/* Default settings but for those that are to be 0, where the denoiser has them; shadows get a sun. Surfaces that are rough have no specular signal
   where NRD_FEATURE_ROUGHNESS_LIMIT is declared. */
static inline void stage_set(stage *s, const char *const zeros[3])
{
    nrd_denoiser denoiser = nrd_get_info(s->instance)->denoisers[0].denoiser;
    any_settings settings;
    nrd_settings_defaults(denoiser, &settings);
    put_setting_by_name(denoiser, &settings, "light_x", 0.5);
    put_setting_by_name(denoiser, &settings, "light_y", 0.7);
    put_setting_by_name(denoiser, &settings, "light_z", -0.5);
    put_setting_by_name(denoiser, &settings, "light_radius", 0.05);
    if (s->instance->desc.features & NRD_FEATURE_ROUGHNESS_LIMIT) put_setting_by_name(denoiser, &settings, "specular_roughness_limit", 0.5);
    for (int i = 0; i < 3 && zeros[i]; i++) put_setting_by_name(denoiser, &settings, zeros[i], 0);
    assert_int_equal(nrd_set_settings(s->instance, STAGE_IDENTIFIER, &settings), NRD_RESULT_OK);
}

static inline bool stage_is_floor(uint32_t y) { return y > STAGE_HEIGHT / 2; }

static inline bool stage_is_rough(const stage *s, uint32_t x, uint32_t y, uint32_t frame) { return s->is_rough ? s->is_rough(x, y, frame) : x >= STAGE_WIDTH / 2; }

static inline void stage_fill_guides(const stage *s, uint32_t frame, float *z, uint32_t *normals)
{
    static const float up[3] = { 0, 1, 0 }, back[3] = { 0, 0, -1 };
    for (uint32_t i = 0; i < STAGE_PIXELS; i++) {
        uint32_t x = i % STAGE_WIDTH, y = i / STAGE_WIDTH;
        z[i] = stage_is_floor(y) ? 8.0f / (float)(2 * y + 1 - STAGE_HEIGHT) : 8.0f;
        float rough = s->is_rough ? 0.52f : 0.8f, smooth = s->is_rough ? 0.48f : 0.3f;
        normals[i] = pack_normal_roughness(stage_is_floor(y) ? up : back, stage_is_rough(s, x, y, frame) ? rough : smooth, x / 8 % 4);
    }
}

/* Light, hit distances, directions; for shadows half of the rays arrive, and the other half tells a penumbra. */
static inline void stage_fill_noise(nrd_resource resource, uint32_t frame, uint16_t (*texels)[4])
{
    for (uint32_t i = 0; i < STAGE_PIXELS; i++)
        for (uint32_t k = 0; k < 4; k++) {
            double v = random_at(i, frame, 16u * (uint32_t)resource + k);
            if (resource == NRD_RESOURCE_IN_MV) v = 0;
            if (resource == NRD_RESOURCE_IN_PENUMBRA) v = v < 0.5 ? 65504 : 0.2 * v;
            texels[i][k] = half_from_float((float)v);
        }
}

static inline void stage_set_light(const stage *s, uint32_t frame, uint16_t (*texels)[4])
{
    for (uint32_t i = 0; s->light && i < STAGE_PIXELS; i++) {
        int light = s->light(i % STAGE_WIDTH, i / STAGE_WIDTH, frame);
        if (light) texels[i][0] = half_from_float(light > 0 ? 65504 : light == -1 ? 0.1f : 2);
    }
}

static inline void stage_set_rubbish(const stage *s, uint32_t frame, uint16_t (*texels)[4])
{
    for (uint32_t i = 0; s->rubbish && i < STAGE_PIXELS; i++)
        for (uint32_t k = 0; k < 4 && stage_is_rough(s, i % STAGE_WIDTH, i / STAGE_WIDTH, frame); k++) texels[i][k] = i % 3 ? 0x7e00 : (uint16_t)(40503u * (i + k));
}

static inline bool stage_is_specular(int resource)
{
    return resource == NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST || resource == NRD_RESOURCE_IN_SPEC_SH0 || resource == NRD_RESOURCE_IN_SPEC_SH1;
}

static inline void stage_set_brightness(const stage *s, uint32_t frame, uint16_t (*texels)[4])
{
    for (uint32_t i = 0; s->brightness && i < STAGE_PIXELS; i++)
        for (uint32_t k = 0; k < 3; k++) texels[i][k] = half_from_float(s->brightness(frame) * half_to_float(texels[i][k]));
}

static inline void stage_upload(stage *s, uint32_t frame)
{
    static float z[STAGE_PIXELS];
    static uint32_t normals[STAGE_PIXELS];
    static uint16_t texels[STAGE_PIXELS][4];
    stage_fill_guides(s, frame, z, normals);
    for (uint32_t i = 0; i < STAGE_PIXELS; i++) if (s->is_sky && s->is_sky(i % STAGE_WIDTH, i / STAGE_WIDTH, frame)) z[i] = 1e6f;
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (!s->images[i].view || nrd_resource_format((nrd_resource)i) != NRD_FORMAT_ANY) continue;
        stage_fill_noise((nrd_resource)i, frame, texels);
        if (i == NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST || i == NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST) stage_set_brightness(s, frame, texels);
        if (i == NRD_RESOURCE_IN_PENUMBRA) stage_set_light(s, frame, texels);
        if (stage_is_specular(i)) stage_set_rubbish(s, frame, texels);
        const void *from = i == NRD_RESOURCE_IN_VIEWZ ? (const void *)z : i == NRD_RESOURCE_IN_NORMAL_ROUGHNESS ? (const void *)normals : (const void *)texels;
        assert_true(gpu_upload(&device, &s->images[i], from));
    }
}

/* before: NULL, or what is recorded before the denoiser. */
static inline void stage_run(stage *s, uint32_t index, void (*before)(VkCommandBuffer cmd))
{
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    nrd_vk_frame record = { .images = list };
    nrd_frame frame = still_frame(index);
    frame.rect_width = s->rect_width;
    frame.rect_height = s->rect_height;
    stage_upload(s, index);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        const gpu_image *image = &s->images[i];
        nrd_vk_image given = { (nrd_resource)i, image->image, image->view, image->format, image->width, image->height, image->layout, image->layout, 0, 0, 0 };
        if (image->view) list[record.image_count++] = given;
    }
    assert_int_equal(nrd_set_frame(s->instance, &frame), NRD_RESULT_OK);
    VkCommandBuffer cmd = gpu_begin(&device);
    if (before) before(cmd);
    assert_int_equal(nrd_vk_record(s->vk, cmd, &record), NRD_RESULT_OK);
    assert_true(gpu_submit_and_wait(&device));
}

static inline void stage_assert_same(const stage *a, const stage *b, const char *what)
{
    static uint8_t left[STAGE_PIXELS * 16], right[STAGE_PIXELS * 16];
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (nrd_resource_format((nrd_resource)i) == NRD_FORMAT_ANY || !b->images[i].view) continue;
        size_t bytes = (size_t)STAGE_PIXELS * gpu_format_size(a->images[i].format);
        assert_true(gpu_download(&device, &a->images[i], left) && gpu_download(&device, &b->images[i], right));
        if (memcmp(left, right, bytes)) fail_msg("%s changes %s of %s", what, nrd_resource_name((nrd_resource)i),
                                                 nrd_denoiser_name(nrd_get_info(b->instance)->denoisers[0].denoiser));
    }
}

#endif
