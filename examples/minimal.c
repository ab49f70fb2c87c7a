/* minimal.c - the shortest complete use of nrd.h and nrd_vk.h, to copy from.

   A floor and a wall are lit; every pixel has one random sample of its light per frame. After 32 frames the program prints how
   far the input and the denoised output are from the known answer. What an engine needs is in the functions between the two
   lines "denoiser"; the rest stands in for the engine. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "common/gpu.h"
#include "common/half.h"

#include <math.h>
#include <stdio.h>

enum { WIDTH = 320, HEIGHT = 180, PIXELS = WIDTH * HEIGHT, FRAMES = 32 };

/* ---- engine: a picture to denoise ------------------------------------------------------------------------------------------ */
static float motion[PIXELS][4];           /* nothing moves */
static float normal_roughness[PIXELS][4]; /* world normal, roughness */
static float view_z[PIXELS];
static float answer[PIXELS];
static float noisy[PIXELS][4];            /* as nrd_pack_radiance_hit_dist() of nrd.glsl packs grey light: (Y, 0, 0, hit distance) */
static uint16_t denoised[PIXELS][4];

static const float tan_half_fov = 0.5f, aspect = (float)WIDTH / HEIGHT;

/* +z forward, +y up, near plane 0.1, no far plane. */
static const float view_to_clip[16] = { 1 / (0.5f * WIDTH / HEIGHT), 0, 0, 0, 0, 1 / 0.5f, 0, 0, 0, 0, 1, 1, 0, 0, -0.1f, 0 };
static const float world_to_view[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

static float random_number(uint32_t x)
{
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return (float)((x ^ (x >> 16)) >> 8) / 16777216.0f;
}

static void trace_surfaces(void)
{
    for (int i = 0; i < PIXELS; i++) {
        float x = (2 * (i % WIDTH + 0.5f) / WIDTH - 1) * tan_half_fov * aspect, y = (1 - 2 * (i / WIDTH + 0.5f) / HEIGHT) * tan_half_fov;
        bool floor_hit = y < -1.0f / 8;   /* the floor is 1 below the camera, the wall 8 in front of it */
        float z = floor_hit ? -1 / y : 8;
        view_z[i] = z;
        normal_roughness[i][floor_hit ? 1 : 2] = floor_hit ? 1.0f : -1.0f;
        normal_roughness[i][3] = 1;
        answer[i] = (floor_hit ? 0.6f : 1.0f) * (1 + 0.7f * sinf(x * z) * cosf(z));
    }
}

static void trace_light(uint32_t frame)
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        bool lit = random_number(i + PIXELS * frame) < 0.25f; /* one ray in four finds the light */
        noisy[i][0] = lit ? 4 * answer[i] : 0;
        noisy[i][3] = 0.5f;
    }
}

/* Root of the mean squared error over the mean. */
static double relative_error(bool of_output)
{
    double error = 0, mean = 0;
    for (int i = 0; i < PIXELS; i++) {
        double value = of_output ? half_to_float(denoised[i][0]) : noisy[i][0], difference = value - answer[i];
        error += difference * difference / PIXELS;
        mean += answer[i] / PIXELS;
    }
    return sqrt(error) / mean;
}

static gpu g;
static gpu_image image_motion, image_normal_roughness, image_view_z, image_noisy, image_denoised;

static bool open_gpu(void)
{
    char error[256];
    if (!gpu_open(&g, &(gpu_desc){ 0 }, error, sizeof error)) return fprintf(stderr, "minimal: %s\n", error), false;
    printf("%s, %dx%d, %d frames\n", g.properties.deviceName, WIDTH, HEIGHT, FRAMES);
    trace_surfaces();
    return gpu_image_create(&g, WIDTH, HEIGHT, VK_FORMAT_R32G32B32A32_SFLOAT, "motion", &image_motion) && gpu_upload(&g, &image_motion, motion)
        && gpu_image_create(&g, WIDTH, HEIGHT, VK_FORMAT_R32G32B32A32_SFLOAT, "normal", &image_normal_roughness) && gpu_upload(&g, &image_normal_roughness, normal_roughness)
        && gpu_image_create(&g, WIDTH, HEIGHT, VK_FORMAT_R32_SFLOAT, "view z", &image_view_z) && gpu_upload(&g, &image_view_z, view_z)
        && gpu_image_create(&g, WIDTH, HEIGHT, VK_FORMAT_R32G32B32A32_SFLOAT, "noisy", &image_noisy)
        && gpu_image_create(&g, WIDTH, HEIGHT, VK_FORMAT_R16G16B16A16_SFLOAT, "denoised", &image_denoised);
}

static void close_gpu(void)
{
    gpu_image *images[] = { &image_motion, &image_normal_roughness, &image_view_z, &image_noisy, &image_denoised };
    for (int i = 0; i < 5; i++) gpu_image_destroy(&g, images[i]);
    gpu_close(&g);
}

/* ---- denoiser -------------------------------------------------------------------------------------------------------------- */
static nrd *denoiser;
static nrd_vk *denoiser_vk;

static void print_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    (void)user;
    fprintf(stderr, "nrd %s: %s (%s)\n", severity == NRD_SEVERITY_ERROR ? "error" : "warning", text, nrd_result_string(result));
}

static bool create_denoiser(void)
{
    nrd_denoiser_desc list[] = { { .identifier = 0, .denoiser = NRD_DENOISER_REBLUR_DIFFUSE } };
    nrd_desc desc = { .width = WIDTH, .height = HEIGHT, .denoisers = list, .denoiser_count = 1,
                      .normal_encoding = NRD_NORMAL_FORMAT_RGBA16_SNORM, .message = print_message };
    if (nrd_create(&desc, &denoiser) != NRD_RESULT_OK) return false;
    nrd_vk_desc vk = { .instance = denoiser, .vk_instance = g.instance, .physical = g.physical, .device = g.device,
                       .get_instance_proc = g.get_instance_proc };
    return nrd_vk_create(&vk, &denoiser_vk) == NRD_RESULT_OK;
}

static nrd_vk_image share(nrd_resource resource, const gpu_image *image)
{
    return (nrd_vk_image){ resource, image->image, image->view, image->format, image->width, image->height, image->layout, image->layout, 0, 0, 0 };
}

static bool record_denoiser(VkCommandBuffer cmd, uint32_t index)
{
    nrd_frame frame = nrd_frame_defaults();
    memcpy(frame.camera.view_to_clip, view_to_clip, sizeof view_to_clip);
    memcpy(frame.camera.world_to_view, world_to_view, sizeof world_to_view);
    frame.frame_index = index;
    nrd_vk_image images[] = { share(NRD_RESOURCE_IN_MV, &image_motion), share(NRD_RESOURCE_IN_NORMAL_ROUGHNESS, &image_normal_roughness),
                              share(NRD_RESOURCE_IN_VIEWZ, &image_view_z), share(NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, &image_noisy),
                              share(NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST, &image_denoised) };
    nrd_vk_frame vk = { .slot = index % 2, .images = images, .image_count = 5 };
    return nrd_set_frame(denoiser, &frame) == NRD_RESULT_OK && nrd_vk_record(denoiser_vk, cmd, &vk) == NRD_RESULT_OK;
}

static void destroy_denoiser(void)
{
    nrd_vk_destroy(denoiser_vk);
    nrd_destroy(denoiser);
}
/* ---- denoiser -------------------------------------------------------------------------------------------------------------- */

static bool run_frame(uint32_t index)
{
    trace_light(index);
    if (!gpu_upload(&g, &image_noisy, noisy)) return false;
    VkCommandBuffer cmd = gpu_begin(&g);
    return cmd && record_denoiser(cmd, index) && gpu_submit_and_wait(&g);
}

int main(void)
{
    bool ok = open_gpu() && create_denoiser();
    for (uint32_t i = 0; ok && i < FRAMES; i++) ok = run_frame(i);
    ok = ok && gpu_download(&g, &image_denoised, denoised);
    if (ok) printf("relative error: input %.3f, output %.3f\n", relative_error(false), relative_error(true));
    else if (g.device) fprintf(stderr, "minimal: failed. %s\n", gpu_error(&g));
    destroy_denoiser();
    close_gpu();
    return ok ? 0 : 1;
}
