/* nrd-raygen: a real-time path tracer in a ray tracing pipeline (VK_KHR_ray_tracing_pipeline: ray generation, miss, closest hit)
   that feeds the denoiser in the same command buffer, composes, and prints what each part took. Where no device has ray tracing
   pipelines it says so and exits with 0; --compute then runs the same paths in a compute shader. See examples/raygen/. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "common/cli.h"
#include "common/gpu.h"
#include "common/half.h"
#include "common/png.h"
#include "raygen/rt.h"
#include "raygen/scene.h"
#include "report/statistics.h"
#include "raygen_spv.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char usage[] =
    "usage: nrd-raygen [OUT.png] [options]\n"
    "Traces and denoises a room in motion; writes the last frame, noisy beside denoised.\n"
    "  --size WxH       pixels; default 1280x720\n"
    "  --frames N       default 64\n"
    "  --paths N        per pixel; default 1\n"
    "  --reference N    traces the last frame again with N paths per pixel and prints the errors against that\n"
    "  --without WHAT   mirrors: they stay the primary surface; strands: hair is guided by its faces; mix: hit distances of\n"
    "                   indirect light only. May be given several times\n"
    "  --prepass PX     radius of the denoiser's pre-pass, which hit distances steer; default 0\n"
    "  --compute        without ray tracing hardware: the same paths in a compute shader\n"
    "  --validate       under the Khronos validation layer; its messages are failures\n";

typedef struct options {
    const char *out;
    long width, height, frames, paths, reference, prepass;
    uint32_t without; /* RAYGEN_MIRRORS, ... */
    bool compute, validate;
} options;

enum { WARM_UP = 4, REFERENCE_PATHS = 32, STAMPS = 4, MAX_PASSES = 32 };

/* The images that the ray generation shader writes, as RAYGEN_BIND_MV and following name them; then the others. */
enum { MV, NORMAL_ROUGHNESS, VIEWZ, NOISY, FACTOR, EMISSION, DENOISED, COLOR, NOISY_COLOR, IMAGE_COUNT };

static const char *const image_names[IMAGE_COUNT] = { "motion",   "normal",   "view z", "noisy",      "factor",
                                                      "emission", "denoised", "color",  "noisy color" };

static options opt = { .out = "raygen.png", .width = 1280, .height = 720, .frames = 64, .paths = 1 };
static gpu g;
static char error[CLI_ERROR_SIZE];
static rt *tracer;
static gpu_kernel loop_kernel, compose_kernel;
static gpu_buffer frame_buffer, box_buffer;
static gpu_image images[IMAGE_COUNT];
static nrd *denoiser;
static nrd_vk *denoiser_vk;

/* ---- timestamps ------------------------------------------------------------------------------------------------ */

#define CLOCK_FUNCTIONS(X) \
    X(vkCreateQueryPool) X(vkDestroyQueryPool) X(vkCmdResetQueryPool) X(vkCmdWriteTimestamp) X(vkGetQueryPoolResults)
#define CLOCK_MEMBER(name) PFN_##name name;
static struct {
    CLOCK_FUNCTIONS(CLOCK_MEMBER)
} clock_fn;
static VkQueryPool stamps;
static double *stage_us[STAMPS - 1]; /* per frame */

static bool create_clock(void)
{
    VkQueryPoolCreateInfo info = { .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                   .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                   .queryCount = STAMPS };
#define CLOCK_LOAD(name) clock_fn.name = (PFN_##name)g.get_device_proc(g.device, #name);
    CLOCK_FUNCTIONS(CLOCK_LOAD)
    for (int i = 0; i < STAMPS - 1; i++)
        if (!(stage_us[i] = calloc((size_t)opt.frames, sizeof *stage_us[i])))
            return snprintf(error, sizeof error, "out of memory"), false;
    if (clock_fn.vkCreateQueryPool(g.device, &info, NULL, &stamps) == VK_SUCCESS) return true;
    return snprintf(error, sizeof error, "vkCreateQueryPool failed"), false;
}

static void stamp(VkCommandBuffer cmd, uint32_t index)
{
    clock_fn.vkCmdWriteTimestamp(cmd, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, stamps, index);
}

static void read_clock(long frame)
{
    uint64_t ticks[STAMPS] = { 0 };
    clock_fn.vkGetQueryPoolResults(g.device, stamps, 0, STAMPS, sizeof ticks, ticks, sizeof ticks[0],
                                   VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    for (int i = 0; i < STAMPS - 1; i++)
        stage_us[i][frame] = (double)(ticks[i + 1] - ticks[i]) * g.properties.limits.timestampPeriod * 1e-3;
}

/* ---- setup ----------------------------------------------------------------------------------------------------- */

static bool say(const char *text)
{
    return snprintf(error, sizeof error, "%s", text), false;
}

static bool create_kernel(const uint32_t *words, size_t size_bytes, const VkDescriptorType *types, uint32_t count,
                          gpu_kernel *kernel)
{
    gpu_kernel_desc desc = { .words = words, .size_bytes = size_bytes, .types = types, .type_count = count };
    return gpu_kernel_create(&g, &desc, kernel) || say(gpu_error(&g));
}

static bool create_resources(void)
{
    uint32_t w = (uint32_t)opt.width, h = (uint32_t)opt.height;
    if (!gpu_buffer_create(&g, sizeof(raygen_frame), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, &frame_buffer)
        || !gpu_buffer_create(&g, RAYGEN_MAX_BOXES * sizeof(raygen_box), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, &box_buffer))
        return say(gpu_error(&g));
    for (int i = 0; i < IMAGE_COUNT; i++) {
        VkFormat format = i == VIEWZ ? VK_FORMAT_R32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT;
        if (!gpu_image_create(&g, w, h, format, image_names[i], &images[i])) return say(gpu_error(&g));
    }
    return true;
}

static bool create_loop(void)
{
    VkDescriptorType types[RAYGEN_BIND_SCENE] = { VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER };
    for (int i = RAYGEN_BIND_MV; i < RAYGEN_BIND_SCENE; i++) types[i] = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    if (!create_kernel(loop_comp, sizeof loop_comp, types, RAYGEN_BIND_SCENE, &loop_kernel)) return false;
    gpu_kernel_bind_buffer(&g, &loop_kernel, RAYGEN_BIND_FRAME, &frame_buffer);
    gpu_kernel_bind_buffer(&g, &loop_kernel, RAYGEN_BIND_BOXES, &box_buffer);
    for (uint32_t i = RAYGEN_BIND_MV; i < RAYGEN_BIND_SCENE; i++)
        gpu_kernel_bind_image(&g, &loop_kernel, i, &images[i - RAYGEN_BIND_MV]);
    return true;
}

static bool create_compose(void)
{
    static const int bound[] = { DENOISED, NOISY, FACTOR, EMISSION, COLOR, NOISY_COLOR };
    VkDescriptorType types[6];
    for (int i = 0; i < 6; i++) types[i] = i < 4 ? VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER : VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    if (!create_kernel(compose_comp, sizeof compose_comp, types, 6, &compose_kernel)) return false;
    for (uint32_t i = 0; i < 6; i++) gpu_kernel_bind_image(&g, &compose_kernel, i, &images[bound[i]]);
    return true;
}

static bool create_tracer(void)
{
    const gpu_image *const written[6] = { &images[MV],    &images[NORMAL_ROUGHNESS], &images[VIEWZ],
                                          &images[NOISY], &images[FACTOR],           &images[EMISSION] };
    if (opt.compute) return create_loop();
    tracer = rt_create(&g, &frame_buffer, &box_buffer, written, error, sizeof error);
    return tracer != NULL;
}

static void print_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    (void)user;
    fprintf(stderr, "nrd %s: %s (%s)\n", severity == NRD_SEVERITY_ERROR ? "error" : "warning", text, nrd_result_string(result));
}

static bool create_denoiser(void)
{
    nrd_denoiser_desc list[] = { { .identifier = 0, .denoiser = NRD_DENOISER_REBLUR_DIFFUSE } };
    nrd_desc desc = { .width = (uint32_t)opt.width,
                      .height = (uint32_t)opt.height,
                      .denoisers = list,
                      .denoiser_count = 1,
                      .normal_encoding = NRD_NORMAL_FORMAT_RGBA16_SNORM,
                      .features = opt.prepass ? NRD_FEATURE_PREPASS : 0,
                      .message = print_message };
    nrd_reblur_settings settings = nrd_reblur_defaults();
    settings.diffuse_prepass_blur_radius = (float)opt.prepass;
    if (nrd_create(&desc, &denoiser) != NRD_RESULT_OK || nrd_set_settings(denoiser, 0, &settings) != NRD_RESULT_OK)
        return say("the denoiser refused its description");
    nrd_vk_desc vk = { .instance = denoiser,
                       .vk_instance = g.instance,
                       .physical = g.physical,
                       .device = g.device,
                       .frames_in_flight = 1,
                       .get_instance_proc = g.get_instance_proc,
                       .queue_family = g.family,
                       .flags = NRD_VK_TIMESTAMPS };
    return nrd_vk_create(&vk, &denoiser_vk) == NRD_RESULT_OK || say("nrd_vk_create failed");
}

/* ---- a frame --------------------------------------------------------------------------------------------------- */

static raygen_frame place_scene(uint32_t index, uint32_t seed, uint32_t paths)
{
    raygen_box boxes[RAYGEN_MAX_BOXES];
    raygen_frame frame = raygen_scene_frame(index, (uint32_t)opt.width, (uint32_t)opt.height);
    frame.box_count = raygen_scene_boxes(index, boxes);
    frame.seed = seed;
    frame.options = (RAYGEN_MIRRORS | RAYGEN_STRANDS | RAYGEN_MIX) & ~opt.without;
    frame.paths = paths;
    memcpy(frame_buffer.mapped, &frame, sizeof frame);
    memcpy(box_buffer.mapped, boxes, frame.box_count * sizeof *boxes);
    if (tracer) rt_place(tracer, boxes, frame.box_count);
    return frame;
}

static void record_trace(VkCommandBuffer cmd, uint32_t box_count)
{
    uint32_t w = (uint32_t)opt.width, h = (uint32_t)opt.height;
    if (tracer) rt_record(tracer, cmd, box_count, w, h);
    else gpu_kernel_dispatch(&g, &loop_kernel, NULL, 0, (w + 7) / 8, (h + 7) / 8, 1);
}

static nrd_vk_image share(nrd_resource resource, const gpu_image *image)
{
    return (nrd_vk_image){
        resource, image->image, image->view, image->format, image->width, image->height, image->layout, image->layout, 0, 0, 0
    };
}

/* No barrier is needed around nrd_vk_record. */
static bool record_denoiser(VkCommandBuffer cmd, const raygen_frame *scene)
{
    nrd_frame frame = nrd_frame_defaults();
    memcpy(frame.camera.view_to_clip, &scene->view_to_clip, sizeof scene->view_to_clip);
    memcpy(frame.camera.world_to_view, &scene->world_to_view, sizeof scene->world_to_view);
    frame.denoising_range = scene->sky.w;
    frame.frame_index = scene->frame_index;
    nrd_vk_image list[] = { share(NRD_RESOURCE_IN_MV, &images[MV]),
                            share(NRD_RESOURCE_IN_NORMAL_ROUGHNESS, &images[NORMAL_ROUGHNESS]),
                            share(NRD_RESOURCE_IN_VIEWZ, &images[VIEWZ]),
                            share(NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, &images[NOISY]),
                            share(NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST, &images[DENOISED]) };
    nrd_vk_frame record = { .slot = 0, .images = list, .image_count = 5 };
    return nrd_set_frame(denoiser, &frame) == NRD_RESULT_OK && nrd_vk_record(denoiser_vk, cmd, &record) == NRD_RESULT_OK;
}

static bool run_frame(long index)
{
    uint32_t w = (uint32_t)opt.width, h = (uint32_t)opt.height;
    raygen_frame scene = place_scene((uint32_t)index, 0, (uint32_t)opt.paths);
    VkCommandBuffer cmd = gpu_begin(&g);
    if (!cmd) return say(gpu_error(&g));
    clock_fn.vkCmdResetQueryPool(cmd, stamps, 0, STAMPS);
    stamp(cmd, 0);
    record_trace(cmd, scene.box_count);
    stamp(cmd, 1);
    if (!record_denoiser(cmd, &scene)) return say("the denoiser refused the frame");
    stamp(cmd, 2);
    gpu_kernel_dispatch(&g, &compose_kernel, NULL, 0, (w + 7) / 8, (h + 7) / 8, 1);
    stamp(cmd, 3);
    if (!gpu_submit_and_wait(&g)) return say(gpu_error(&g));
    read_clock(index);
    return true;
}

/* ---- results --------------------------------------------------------------------------------------------------- */

static void print_times(void)
{
    static const char *const names[STAMPS - 1] = { "trace", "denoise", "compose" };
    long first = opt.frames > 2 * WARM_UP ? WARM_UP : 0;
    for (int i = 0; i < STAMPS - 1; i++) printf("%-8s %9.1f us\n", names[i], quantile(stage_us[i] + first, (int)(opt.frames - first), 0.5));
    nrd_vk_timing passes[MAX_PASSES];
    uint32_t count = 0;
    if (nrd_vk_timings(denoiser_vk, 0, passes, MAX_PASSES, &count) != NRD_RESULT_OK) return;
    for (uint32_t i = 0; i < count; i++)
        printf("  %-28s %9.1f us in the last frame\n", passes[i].name, passes[i].nanoseconds * 1e-3);
}

static unsigned char tone_byte(float linear)
{
    float shown = powf(1 - expf(-fmaxf(linear, 0)), 1 / 2.2f);
    return (unsigned char)(fminf(shown, 1) * 255 + 0.5f);
}

static void tone_image(const uint16_t *texels, unsigned char *rgb, size_t x_offset)
{
    size_t w = (size_t)opt.width, h = (size_t)opt.height;
    for (size_t i = 0; i < w * h; i++)
        for (size_t k = 0; k < 3; k++)
            rgb[3 * (i / w * 2 * w + x_offset + i % w) + k] = tone_byte(half_to_float(texels[4 * i + k]));
}

static bool write_picture(void)
{
    size_t pixels = (size_t)opt.width * (size_t)opt.height;
    uint16_t *texels = malloc(pixels * 4 * sizeof *texels);
    unsigned char *rgb = malloc(pixels * 6);
    bool ok = (texels && rgb) || say("out of memory");
    for (int side = 0; ok && side < 2; side++) {
        ok = gpu_download(&g, &images[side ? COLOR : NOISY_COLOR], texels) || say(gpu_error(&g));
        if (ok) tone_image(texels, rgb, side ? (size_t)opt.width : 0);
    }
    ok = ok && write_png(opt.out, 2 * (int)opt.width, (int)opt.height, rgb, error, sizeof error);
    if (ok) printf("%s: noisy | denoised\n", opt.out);
    free(texels);
    free(rgb);
    return ok;
}

/* Adds the luma (Rec. 709) of an image of linear colours to `sum`, times `weight`. */
static bool add_luma(int image, double weight, double *sum, uint16_t *texels)
{
    if (!gpu_download(&g, &images[image], texels)) return say(gpu_error(&g));
    for (size_t i = 0; i < (size_t)opt.width * (size_t)opt.height; i++) {
        const uint16_t *t = texels + 4 * i;
        sum[i] += weight * (0.2126 * half_to_float(t[0]) + 0.7152 * half_to_float(t[1]) + 0.0722 * half_to_float(t[2]));
    }
    return true;
}

/* The last frame composed from many paths, without the denoiser. */
static bool trace_reference(double *luma, uint16_t *texels)
{
    uint32_t w = (uint32_t)opt.width, h = (uint32_t)opt.height;
    long rounds = (opt.reference + REFERENCE_PATHS - 1) / REFERENCE_PATHS;
    opt.without = 0;
    for (long i = 0; i < rounds; i++) {
        raygen_frame scene = place_scene((uint32_t)opt.frames - 1, 1 + (uint32_t)i, REFERENCE_PATHS);
        VkCommandBuffer cmd = gpu_begin(&g);
        if (!cmd) return say(gpu_error(&g));
        record_trace(cmd, scene.box_count);
        gpu_kernel_dispatch(&g, &compose_kernel, NULL, 0, (w + 7) / 8, (h + 7) / 8, 1);
        if (!gpu_submit_and_wait(&g)) return say(gpu_error(&g));
        if (!add_luma(NOISY_COLOR, 1.0 / (double)rounds, luma, texels)) return false;
        cli_progress("reference", (int)i + 1, (int)rounds);
    }
    return true;
}

/* Mean of the relative squared errors over the pixels that show a RAYGEN_SHOWS_..., or over all. */
static double relative_error(const double *value, const double *truth, const uint16_t *factors, int shows)
{
    double sum = 0, count = 0;
    for (size_t i = 0; i < (size_t)opt.width * (size_t)opt.height; i++) {
        if (shows != RAYGEN_SHOWS_SOLID && half_to_float(factors[4 * i + 3]) != (float)shows) continue;
        sum += (value[i] - truth[i]) * (value[i] - truth[i]) / (truth[i] * truth[i] + 0.01);
        count++;
    }
    return count > 0 ? sum / count : 0;
}

static bool print_errors(void)
{
    static const char *const names[] = { "whole picture", "mirrors", "strands" };
    size_t pixels = (size_t)opt.width * (size_t)opt.height;
    double *noisy = calloc(3 * pixels, sizeof *noisy), *denoised = noisy + pixels, *truth = denoised + pixels;
    uint16_t *texels = malloc(pixels * 4 * sizeof *texels);
    bool ok = (noisy && texels) || say("out of memory");
    ok = ok && add_luma(NOISY_COLOR, 1, noisy, texels) && add_luma(COLOR, 1, denoised, texels) && trace_reference(truth, texels);
    ok = ok && (gpu_download(&g, &images[FACTOR], texels) || say(gpu_error(&g)));
    for (int i = RAYGEN_SHOWS_SOLID; ok && i <= RAYGEN_SHOWS_STRAND; i++)
        printf("relative squared error, %s: noisy %.4f, denoised %.4f\n", names[i], relative_error(noisy, truth, texels, i),
               relative_error(denoised, truth, texels, i));
    free(noisy);
    free(texels);
    return ok;
}

/* ---- program --------------------------------------------------------------------------------------------------- */

static bool parse_size(const char *text)
{
    char *end;
    opt.width = strtol(text, &end, 10);
    opt.height = *end == 'x' ? strtol(end + 1, &end, 10) : 0;
    return *end == 0 && opt.width >= 16 && opt.width <= 8192 && opt.height >= 16 && opt.height <= 8192;
}

static bool parse_without(const char *text)
{
    static const char *const names[] = { "mirrors", "strands", "mix" };
    for (uint32_t i = 0; i < 3; i++) {
        if (strcmp(text, names[i]) != 0) continue;
        opt.without |= 1u << i;
        return true;
    }
    return false;
}

/* 0: goes on; otherwise the exit status plus 1. */
static int parse(int argc, char **argv)
{
    static const struct {
        const char *name;
        long *value, low;
    } numbers[] = { { "--frames", &opt.frames, 1 },
                    { "--paths", &opt.paths, 1 },
                    { "--reference", &opt.reference, 0 },
                    { "--prepass", &opt.prepass, 0 } };
    for (int i = 1; i < argc; i++) {
        const char *name = argv[i], *value;
        bool known = true;
        if (strcmp(name, "--help") == 0) return fputs(usage, stdout), 1;
        if (strcmp(name, "--compute") == 0) opt.compute = true;
        else if (strcmp(name, "--validate") == 0) opt.validate = true;
        else if (strncmp(name, "--", 2) != 0) opt.out = name;
        else if (strcmp(name, "--without") == 0) {
            if (!(value = cli_value(argc, argv, &i)) || !parse_without(value))
                return 1 + cli_fail("nrd-raygen", "--without is mirrors, strands or mix");
        } else if (strcmp(name, "--size") == 0) {
            if (!(value = cli_value(argc, argv, &i)) || !parse_size(value))
                return 1 + cli_fail("nrd-raygen", "--size is WxH, 16x16 to 8192x8192");
        } else {
            known = false;
            for (int k = 0; k < 4 && !known; k++) {
                if (strcmp(name, numbers[k].name) != 0) continue;
                known = true;
                if (!(value = cli_value(argc, argv, &i)) || !cli_integer(value, numbers[k].low, 1000000, numbers[k].value))
                    return 1 + cli_fail("nrd-raygen", "%s is a whole number, %ld to 1000000", name, numbers[k].low);
            }
        }
        if (!known) return 1 + cli_fail("nrd-raygen", "unknown option %s (--help lists them)", name);
    }
    return 0;
}

static bool run(void)
{
    if (!create_clock() || !create_resources() || !create_tracer() || !create_compose() || !create_denoiser()) return false;
    printf("%s, %ldx%ld, %ld frames, %ld path%s per pixel, %s\n", g.properties.deviceName, opt.width, opt.height, opt.frames,
           opt.paths, opt.paths > 1 ? "s" : "", opt.compute ? "compute shader" : "ray tracing pipeline");
    for (long i = 0; i < opt.frames; i++) {
        if (!run_frame(i)) return false;
        cli_progress("frames", (int)i + 1, (int)opt.frames);
    }
    print_times();
    if (!write_picture() || (opt.reference && !print_errors())) return false;
    return gpu_message_count(&g) == 0 || say("the validation layer complained");
}

static void close_all(void)
{
    nrd_vk_destroy(denoiser_vk);
    nrd_destroy(denoiser);
    rt_destroy(tracer);
    gpu_kernel_destroy(&g, &loop_kernel);
    gpu_kernel_destroy(&g, &compose_kernel);
    for (int i = 0; i < IMAGE_COUNT; i++) gpu_image_destroy(&g, &images[i]);
    gpu_buffer_destroy(&g, &frame_buffer);
    gpu_buffer_destroy(&g, &box_buffer);
    if (stamps) clock_fn.vkDestroyQueryPool(g.device, stamps, NULL);
    for (int i = 0; i < STAMPS - 1; i++) free(stage_us[i]);
    gpu_close(&g);
}

int main(int argc, char **argv)
{
    bool none = false;
    int stop = parse(argc, argv);
    if (stop) return stop - 1;
    gpu_desc desc = { .validation = opt.validate, .sync_validation = opt.validate };
    bool open = opt.compute ? gpu_open(&g, &desc, error, sizeof error) : rt_open_device(&g, &desc, &none, error, sizeof error);
    if (!open && none) return printf("skipped: no device with ray tracing pipelines (%s)\n", error), 0;
    bool ok = open && run();
    if (open) close_all();
    return ok ? 0 : cli_fail("nrd-raygen", "%s", error);
}
