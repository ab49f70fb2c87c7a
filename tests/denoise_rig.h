/* denoise_rig.h: one denoiser on a device with its images, fed from arrays. Scenes are functions of a camera ray, so that depth,
   normals and motion are exact. Link examples/common/gpu.c, half.c and pack.c; define the nrd.h and nrd_vk.h implementations first. */
#ifndef TESTS_DENOISE_RIG_H
#define TESTS_DENOISE_RIG_H

#include "nrd_vk.h"

#include "common/half.h"
#include "common/pack.h"
#include "device.h"
#include "frame_fixture.h"

/* Which signal of a REBLUR denoiser the rig feeds and looks at. */
#ifdef RIG_SH
#define RIG_BOTH NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_SH
#else
#define RIG_BOTH NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR
#endif
#if defined(RIG_SH) && defined(RIG_SPECULAR)
#define RIG_DENOISER NRD_DENOISER_REBLUR_SPECULAR_SH
#define RIG_RADIANCE NRD_RESOURCE_IN_SPEC_SH0
#define RIG_OUT NRD_RESOURCE_OUT_SPEC_SH0
#elif defined(RIG_SH)
#define RIG_DENOISER NRD_DENOISER_REBLUR_DIFFUSE_SH
#define RIG_RADIANCE NRD_RESOURCE_IN_DIFF_SH0
#define RIG_OUT NRD_RESOURCE_OUT_DIFF_SH0
#elif defined(RIG_SPECULAR)
#define RIG_DENOISER NRD_DENOISER_REBLUR_SPECULAR
#define RIG_RADIANCE NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST
#define RIG_OUT NRD_RESOURCE_OUT_SPEC_RADIANCE_HITDIST
#else
#define RIG_DENOISER NRD_DENOISER_REBLUR_DIFFUSE
#define RIG_RADIANCE NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST
#define RIG_OUT NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST
#endif

enum { RIG_IDENTIFIER = 7 };
#define RIG_RANGE 1000.0f /* denoising range */
#define RIG_SKY 5000.0f

/* What a camera ray meets. */
typedef struct hit {
    double depth;           /* along the view axis; sky: any beyond RIG_RANGE */
    double normal[3];
    uint32_t material;
    double moved[3];        /* where the point was in the previous frame, minus where it is */
    uint32_t region;        /* for the test's own use */
} hit;

typedef hit scene(const pose *p, double u, double v, uint32_t frame);

typedef struct texel { float y, co, cg, hit_dist; } texel;

typedef struct rig {
    gpu *device;
    spy spy;
    nrd *instance;
    nrd_vk *vk;
    gpu_image images[NRD_RESOURCE_COUNT];
    uint32_t width, height;     /* of the images */
    uint32_t rect_width, rect_height, origin_x, origin_y; /* the pixels in use; of the whole image unless changed */
    nrd_frame frame;            /* everything but camera and frame_index may be changed between frames */
    nrd_reblur_settings settings;
    uint32_t index;
    pose camera, camera_prev;
    float roughness;            /* of every surface; 1 unless changed */
    scene *scene;
    hit *hits;                  /* rect_width x rect_height, of the last frame */
    float *mv, *view_z;
    uint32_t *normal;
    uint16_t *noisy, *out;      /* RGBA16F, width x height */
    float *signal, *mean;       /* RGBA32F, REFERENCE */
} rig;

static inline bool rig_ray_plane(const pose *p, double u, double v, const double point[3], const double normal[3], double *depth)
{
    double near[3], far[3], along = 0, distance = 0;
    pose_point(p, u, v, 0, near);
    pose_point(p, u, v, 1, far);
    for (int k = 0; k < 3; k++) along += (far[k] - near[k]) * normal[k], distance += (point[k] - near[k]) * normal[k];
    if (along == 0 || distance / along <= 0) return false;
    *depth = distance / along;
    return true;
}

static inline VkFormat rig_format(nrd_resource resource)
{
    switch (resource) {
    case NRD_RESOURCE_IN_MV: case NRD_RESOURCE_IN_SPEC_MV: return VK_FORMAT_R32G32B32A32_SFLOAT;
    case NRD_RESOURCE_IN_NORMAL_ROUGHNESS: return VK_FORMAT_A2B10G10R10_UNORM_PACK32;
    case NRD_RESOURCE_IN_DIFF_CONFIDENCE: case NRD_RESOURCE_IN_SPEC_CONFIDENCE: case NRD_RESOURCE_IN_DISOCCLUSION_THRESHOLD_MIX:
    case NRD_RESOURCE_IN_VIEWZ: return VK_FORMAT_R32_SFLOAT;
    case NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST: case NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST: case NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST:
    case NRD_RESOURCE_IN_DIFF_SH0: case NRD_RESOURCE_IN_DIFF_SH1: case NRD_RESOURCE_IN_SPEC_SH0: case NRD_RESOURCE_IN_SPEC_SH1: return VK_FORMAT_R16G16B16A16_SFLOAT;
    case NRD_RESOURCE_IN_DIFF_HITDIST: case NRD_RESOURCE_IN_SPEC_HITDIST: case NRD_RESOURCE_IN_PENUMBRA: return VK_FORMAT_R16_SFLOAT;
    case NRD_RESOURCE_IN_TRANSLUCENCY: return VK_FORMAT_R8G8B8A8_UNORM;
    case NRD_RESOURCE_IN_SIGNAL: return VK_FORMAT_R32G32B32A32_SFLOAT;
    default: return nrd_vk_format(nrd_resource_format(resource));
    }
}

static inline void *rig_array(const rig *r, size_t bytes)
{
    void *memory = calloc((size_t)r->width * r->height, bytes);
    assert_non_null(memory);
    return memory;
}

static inline void rig_create_images(rig *r)
{
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (!nrd_uses_resource(r->instance, (nrd_resource)i)) continue;
        VkFormat format = rig_format((nrd_resource)i);
        assert_true(gpu_image_create(r->device, r->width, r->height, format, nrd_resource_name((nrd_resource)i), &r->images[i]));
        void *zeros = rig_array(r, gpu_format_size(format));
        assert_true(gpu_upload(r->device, &r->images[i], zeros));
        free(zeros);
    }
}

static inline void rig_create_arrays(rig *r)
{
    r->hits = (hit *)rig_array(r, sizeof *r->hits);
    r->mv = (float *)rig_array(r, 16);
    r->view_z = (float *)rig_array(r, 4);
    r->normal = (uint32_t *)rig_array(r, 4);
    r->noisy = (uint16_t *)rig_array(r, 8);
    r->out = (uint16_t *)rig_array(r, 8);
    r->signal = (float *)rig_array(r, 16);
    r->mean = (float *)rig_array(r, 16);
}

/* The app's images and the arrays. */
static inline void rig_destroy_images(rig *r)
{
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) gpu_image_destroy(r->device, &r->images[i]);
    free(r->hits); free(r->mv); free(r->view_z); free(r->normal); free(r->noisy); free(r->out); free(r->signal); free(r->mean);
}

static inline void rig_open_with(rig *r, gpu *device, nrd_denoiser denoiser, uint32_t width, uint32_t height, scene *what, uint32_t features)
{
    memset(r, 0, sizeof *r);
    r->device = device;
    r->scene = what;
    r->width = r->rect_width = width;
    r->height = r->rect_height = height;
    r->instance = create_one(&r->spy, denoiser, width, height, features);
    nrd_vk_desc desc = { .instance = r->instance, .vk_instance = device->instance, .physical = device->physical, .device = device->device,
                         .get_instance_proc = device->get_instance_proc, .frames_in_flight = 1 };
    assert_int_equal(nrd_vk_create(&desc, &r->vk), NRD_RESULT_OK);
    rig_create_images(r);
    r->frame = nrd_frame_defaults();
    r->frame.denoising_range = RIG_RANGE;
    r->settings = nrd_reblur_defaults();
    r->roughness = 1;
    r->camera = r->camera_prev = pose_at(0, 0, 0);
    rig_create_arrays(r);
}

static inline void rig_open(rig *r, gpu *device, nrd_denoiser denoiser, uint32_t width, uint32_t height, scene *what)
{
    rig_open_with(r, device, denoiser, width, height, what, 0);
}

static inline void rig_close(rig *r)
{
    nrd_vk_destroy(r->vk);
    nrd_destroy(r->instance);
    rig_destroy_images(r);
}

/* Other sizes of everything; history is kept. */
static inline void rig_resize(rig *r, uint32_t width, uint32_t height)
{
    assert_int_equal(nrd_vk_resize(r->vk, width, height), NRD_RESULT_OK);
    rig_destroy_images(r);
    r->width = r->rect_width = width;
    r->height = r->rect_height = height;
    rig_create_images(r);
    rig_create_arrays(r);
}

static inline void rig_put_motion(rig *r, const hit *h, double u, double v, float *mv)
{
    double world[3], u_prev, v_prev, depth_prev;
    pose_point(&r->camera, u, v, h->depth, world);
    for (int k = 0; k < 3; k++) world[k] += h->moved[k];
    pose_project(&r->camera_prev, world, &u_prev, &v_prev, &depth_prev);
    bool in_world = r->frame.motion_mode == NRD_MOTION_WORLD;
    mv[0] = (float)(in_world ? h->moved[0] : u_prev - u);
    mv[1] = (float)(in_world ? h->moved[1] : v_prev - v);
    mv[2] = (float)(in_world ? h->moved[2] : (depth_prev - h->depth) * (r->camera.right_handed ? -1 : 1));
}

/* Guides of the current camera and frame, at the rectangle's place in the images. */
static inline void rig_put_guides(rig *r)
{
    for (uint32_t y = 0; y < r->rect_height; y++)
        for (uint32_t x = 0; x < r->rect_width; x++) {
            double u = (x + 0.5 + r->camera.jitter[0]) / r->rect_width, v = (y + 0.5 + r->camera.jitter[1]) / r->rect_height;
            size_t at = (size_t)(y + r->origin_y) * r->width + x + r->origin_x;
            hit *h = &r->hits[(size_t)y * r->rect_width + x];
            *h = r->scene(&r->camera, u, v, r->index);
            float normal[3] = { (float)h->normal[0], (float)h->normal[1], (float)h->normal[2] };
            r->view_z[at] = (float)h->depth * (r->camera.right_handed ? -1 : 1);
            r->normal[at] = pack_normal_roughness(normal, r->roughness, h->material);
            rig_put_motion(r, h, u, v, &r->mv[4 * at]);
        }
}

static inline void rig_put_noisy(rig *r, uint32_t x, uint32_t y, texel t)
{
    float from[4] = { t.y, t.co, t.cg, t.hit_dist };
    half_from_floats(&r->noisy[4 * ((size_t)y * r->width + x)], from, 4);
}

static inline texel rig_out(const rig *r, uint32_t x, uint32_t y)
{
    const uint16_t *h = &r->out[4 * ((size_t)y * r->width + x)];
    texel t = { half_to_float(h[0]), half_to_float(h[1]), half_to_float(h[2]), half_to_float(h[3]) };
    return t;
}

static inline void rig_upload(rig *r)
{
    const struct { nrd_resource resource; const void *texels; } rows[] = {
        { NRD_RESOURCE_IN_MV, r->mv }, { NRD_RESOURCE_IN_VIEWZ, r->view_z }, { NRD_RESOURCE_IN_NORMAL_ROUGHNESS, r->normal },
        { RIG_RADIANCE, r->noisy }, { NRD_RESOURCE_IN_SIGNAL, r->signal },
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        if (r->images[rows[i].resource].view) assert_true(gpu_upload(r->device, &r->images[rows[i].resource], rows[i].texels));
}

/* One frame with whatever the arrays hold; inputs that did not change need no upload. */
static inline void rig_run(rig *r, bool upload)
{
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    nrd_vk_frame frame = { .images = list };
    if (upload) rig_upload(r);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        const gpu_image *image = &r->images[i];
        nrd_vk_image given = { (nrd_resource)i, image->image, image->view, image->format, image->width, image->height, image->layout, image->layout, 0, 0, 0 };
        if (image->view) list[frame.image_count++] = given;
    }
    r->frame.camera = pose_camera(&r->camera);
    r->frame.clip_y = pose_clip_y(&r->camera);
    r->frame.frame_index = r->index;
    r->frame.rect_width = r->rect_width;
    r->frame.rect_height = r->rect_height;
    r->frame.rect_origin_x = r->origin_x;
    r->frame.rect_origin_y = r->origin_y;
    if (r->images[RIG_OUT].view) assert_int_equal(nrd_set_settings(r->instance, RIG_IDENTIFIER, &r->settings), NRD_RESULT_OK);
    assert_int_equal(nrd_set_frame(r->instance, &r->frame), NRD_RESULT_OK);
    VkCommandBuffer cmd = gpu_begin(r->device);
    assert_int_equal(nrd_vk_record(r->vk, cmd, &frame), NRD_RESULT_OK);
    assert_true(gpu_submit_and_wait(r->device));
    r->camera_prev = r->camera;
    r->index++;
}

static inline void rig_download(rig *r)
{
    if (r->images[RIG_OUT].view) assert_true(gpu_download(r->device, &r->images[RIG_OUT], r->out));
    if (r->images[NRD_RESOURCE_OUT_SIGNAL].view) assert_true(gpu_download(r->device, &r->images[NRD_RESOURCE_OUT_SIGNAL], r->mean));
}

#endif
