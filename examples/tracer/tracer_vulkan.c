#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/gpu.h"
#include "trace_spv.h"
#include "tracer/bvh.h"
#include "tracer/tracer.h"
#include "tracer/tracer_vulkan.h"

/* In the order of the shader's bindings; the textures follow. */
enum { NODES, CORNERS, TRIANGLES, MATERIALS, LIGHTS, FRAME, PLANES, BUFFER_COUNT };

#define TEXTURE_FORMAT(name, format) format,
#define TEXTURE_NAME(name, format) "in_" #name,
static const VkFormat texture_formats[] = { TRACER_TEXTURES(TEXTURE_FORMAT) };
static const char *const texture_names[] = { TRACER_TEXTURES(TEXTURE_NAME) };

enum { GROUP_SIZE = 8 };

/* Mesa's CPU driver ends the loops of a shader, silently, after 65535 iterations in all; a path through a large scene
   takes up to about a thousand. These keep every dispatch well below. */
enum { MAX_PATHS = 8, SAMPLES_PER_DISPATCH = 4 };

typedef struct vulkan_state {
    gpu gpu;
    gpu_kernel frame_kernel, reference_kernel;
    gpu_buffer buffers[BUFFER_COUNT];
    gpu_image textures[TRACER_TEXTURE_COUNT];
    double traced_ms;
} vulkan_state;

static bool fail(const vulkan_state *v, char *error, size_t error_size)
{
    snprintf(error, error_size, "Vulkan: %s", gpu_error(&v->gpu));
    return false;
}

/* A buffer of at least `size` bytes; a new one only where the present one is too small. In the device's memory: rays that fetch
   a scene from the host's are ten times slower. */
static bool reserve(vulkan_state *v, int index, VkDeviceSize size)
{
    const VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (v->buffers[index].size >= size) return true;
    gpu_buffer_destroy(&v->gpu, &v->buffers[index]);
    return gpu_buffer_create_local(&v->gpu, size, usage, &v->buffers[index]);
}

static bool fill(vulkan_state *v, int index, const void *bytes, size_t size)
{
    return reserve(v, index, size ? size : sizeof(vec4)) && gpu_buffer_upload(&v->gpu, &v->buffers[index], bytes, size);
}

/* Corners in the order of the hierarchy; the first one carries the triangle's number. False when memory is short. */
static bool fill_corners(vulkan_state *v, const pt_scene *scene, const bvh *b)
{
    size_t size = (size_t)scene->triangle_count * 3 * sizeof(vec4);
    vec4 *out = malloc(size);
    for (uint32_t i = 0; out && i < scene->triangle_count; i++) {
        for (int k = 0; k < 3; k++) out[3 * i + (uint32_t)k] = scene->triangles[b->order[i]].p[k];
        memcpy((float *)&out[3 * i] + 3, &b->order[i], sizeof b->order[i]);
    }
    bool ok = out && fill(v, CORNERS, out, size);
    free(out);
    return ok;
}

static bool vulkan_load(tracer *t, pt_scene *scene, char *error, size_t error_size)
{
    vulkan_state *v = t->state;
    bvh b;
    if (!bvh_build(scene, &b)) {
        snprintf(error, error_size, "out of memory for the bounding volume hierarchy");
        return false;
    }
    bool ok = fill(v, NODES, b.nodes, b.node_count * sizeof *b.nodes) && fill_corners(v, scene, &b) &&
              fill(v, TRIANGLES, scene->triangles, scene->triangle_count * sizeof *scene->triangles) &&
              fill(v, MATERIALS, scene->materials, scene->material_count * sizeof *scene->materials) &&
              fill(v, LIGHTS, scene->lights, scene->frame.light_count * sizeof *scene->lights);
    bvh_free(&b);
    return ok || fail(v, error, error_size);
}

static bool reserve_textures(vulkan_state *v, uint32_t width, uint32_t height)
{
    for (int i = 0; i < TRACER_TEXTURE_COUNT; i++) {
        gpu_image *image = &v->textures[i];
        if (image->width == width && image->height == height) continue;
        gpu_image_destroy(&v->gpu, image);
        if (!gpu_image_create(&v->gpu, width, height, texture_formats[i], texture_names[i], image)) return false;
    }
    return true;
}

/* One dispatch over the image; the result lies in the buffer PLANES. */
static bool dispatch(vulkan_state *v, gpu_kernel *kernel, const pt_frame *f, uint32_t plane_count)
{
    VkDeviceSize size = (VkDeviceSize)plane_count * f->width * f->height * sizeof(float);
    if (!fill(v, FRAME, f, sizeof *f) || !reserve(v, PLANES, size) || !reserve_textures(v, f->width, f->height))
        return false;
    for (uint32_t i = 0; i < BUFFER_COUNT; i++) gpu_kernel_bind_buffer(&v->gpu, kernel, i, &v->buffers[i]);
    for (uint32_t i = 0; i < TRACER_TEXTURE_COUNT; i++)
        gpu_kernel_bind_image(&v->gpu, kernel, BUFFER_COUNT + i, &v->textures[i]);
    if (!gpu_begin(&v->gpu)) return false;
    gpu_kernel_dispatch(&v->gpu, kernel, NULL, 0, (f->width + GROUP_SIZE - 1) / GROUP_SIZE,
                        (f->height + GROUP_SIZE - 1) / GROUP_SIZE, 1);
    return gpu_submit_and_wait(&v->gpu);
}

static bool vulkan_render(tracer *t, const pt_scene *scene, float *planes, char *error, size_t error_size)
{
    vulkan_state *v = t->state;
    if (scene->frame.paths > MAX_PATHS) {
        snprintf(error, error_size, "paths: %u is not in [1, %d] with the Vulkan tracer", scene->frame.paths,
                 MAX_PATHS);
        return false;
    }
    if (!dispatch(v, &v->frame_kernel, &scene->frame, PT_PLANE_COUNT)) return fail(v, error, error_size);
    size_t texels = (size_t)scene->frame.width * scene->frame.height;
    double traced = gpu_milliseconds(&v->gpu);
    if (!gpu_buffer_download(&v->gpu, &v->buffers[PLANES], planes, PT_PLANE_COUNT * texels * sizeof *planes)) return fail(v, error, error_size);
    v->traced_ms = traced;
    return true;
}

static bool vulkan_accumulate(tracer *t, const pt_scene *scene, double *sums, char *error, size_t error_size)
{
    vulkan_state *v = t->state;
    pt_frame f = scene->frame;
    for (uint32_t done = 0; done < scene->frame.sample_count; done += SAMPLES_PER_DISPATCH) {
        uint32_t left = scene->frame.sample_count - done;
        f.sample_first = scene->frame.sample_first + done;
        f.sample_count = left < SAMPLES_PER_DISPATCH ? left : SAMPLES_PER_DISPATCH;
        f.sample_add = done > 0;
        if (!dispatch(v, &v->reference_kernel, &f, PT_REF_COUNT)) return fail(v, error, error_size);
    }
    size_t values = PT_REF_COUNT * (size_t)scene->frame.width * scene->frame.height;
    float *added = malloc(values * sizeof *added);
    if (!added) {
        snprintf(error, error_size, "out of memory");
        return false;
    }
    bool ok = gpu_buffer_download(&v->gpu, &v->buffers[PLANES], added, values * sizeof *added) || fail(v, error, error_size);
    for (size_t i = 0; ok && i < values; i++) sums[i] += added[i];
    free(added);
    return ok;
}

static void vulkan_close(tracer *t)
{
    vulkan_state *v = t->state;
    for (int i = 0; i < BUFFER_COUNT; i++) gpu_buffer_destroy(&v->gpu, &v->buffers[i]);
    for (int i = 0; i < TRACER_TEXTURE_COUNT; i++) gpu_image_destroy(&v->gpu, &v->textures[i]);
    gpu_kernel_destroy(&v->gpu, &v->frame_kernel);
    gpu_kernel_destroy(&v->gpu, &v->reference_kernel);
    gpu_close(&v->gpu);
    free(v);
    memset(t, 0, sizeof *t);
}

static bool create_kernel(vulkan_state *v, uint32_t is_reference, gpu_kernel *out)
{
    VkDescriptorType types[BUFFER_COUNT + TRACER_TEXTURE_COUNT];
    for (int i = 0; i < BUFFER_COUNT + TRACER_TEXTURE_COUNT; i++)
        types[i] = i < BUFFER_COUNT ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    const gpu_kernel_desc desc = {
        .words = trace_spv,
        .size_bytes = sizeof trace_spv,
        .types = types,
        .type_count = BUFFER_COUNT + TRACER_TEXTURE_COUNT,
        .constants = &is_reference,
        .constant_count = 1,
    };
    return gpu_kernel_create(&v->gpu, &desc, out);
}

gpu *tracer_vulkan_gpu(tracer *t) { return &((vulkan_state *)t->state)->gpu; }

double tracer_vulkan_ms(const tracer *t) { return ((const vulkan_state *)t->state)->traced_ms; }

const uint32_t *tracer_vulkan_code(size_t *size_bytes)
{
    *size_bytes = sizeof trace_spv;
    return trace_spv;
}

const gpu_image *tracer_vulkan_texture(const tracer *t, tracer_texture which)
{
    return &((const vulkan_state *)t->state)->textures[which];
}

static bool open_on(tracer *t, const gpu_desc *device, char *error, size_t error_size)
{
    memset(t, 0, sizeof *t);
    vulkan_state *v = calloc(1, sizeof *v);
    if (!v) {
        snprintf(error, error_size, "out of memory");
        return false;
    }
    if (!gpu_open(&v->gpu, device, error, error_size)) {
        free(v);
        return false;
    }
    *t = (tracer){ "vulkan", v, vulkan_load, vulkan_render, vulkan_accumulate, vulkan_close };
    if (create_kernel(v, 0, &v->frame_kernel) && create_kernel(v, 1, &v->reference_kernel)) return true;
    fail(v, error, error_size);
    vulkan_close(t);
    return false;
}

bool tracer_open_vulkan(tracer *t, int device, char *error, size_t error_size)
{
    return open_on(t, &(gpu_desc){ .device_index = device }, error, error_size);
}

bool tracer_open_vulkan_on(tracer *t, gpu *device, char *error, size_t error_size)
{
    return open_on(t, &(gpu_desc){ .shared = device }, error, error_size);
}
