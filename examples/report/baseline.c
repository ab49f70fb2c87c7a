#include "report/baseline.h"

#include "common/half.h"
#include "report/statistics.h"
#include "spatial_spv.h"
#include "tracer/tracer_vulkan.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PROBES = 7, GROUP = 8 };

typedef struct spatial_push { int32_t radius; float sky; } spatial_push;

static bool create_kernel(baseline *b)
{
    static const VkDescriptorType types[] = { VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                              VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE };
    gpu_kernel_desc desc = { 0 };
    desc.words = spatial_spv;
    desc.size_bytes = sizeof spatial_spv;
    desc.types = types;
    desc.type_count = sizeof types / sizeof *types;
    desc.push_size = sizeof(spatial_push);
    return gpu_kernel_create(b->g, &desc, &b->spatial);
}

static bool open_parts(baseline *b, int width, int height)
{
    const VkFormat format = VK_FORMAT_R16G16B16A16_SFLOAT;
    return create_kernel(b)
        && gpu_image_create(b->g, (uint32_t)width, (uint32_t)height, format, "spatial in", &b->in)
        && gpu_image_create(b->g, (uint32_t)width, (uint32_t)height, format, "spatial out", &b->out);
}

bool baseline_open(baseline *b, tracer *t, int width, int height, float denoising_range, char *error, size_t error_size)
{
    memset(b, 0, sizeof *b);
    b->t = t;
    b->g = tracer_vulkan_gpu(t);
    b->sky = denoising_range;
    b->texels = calloc((size_t)width * (size_t)height, 8);
    if (b->texels && open_parts(b, width, height) && gpu_upload(b->g, &b->in, b->texels))
        return true;
    snprintf(error, error_size, "%s", b->texels ? gpu_error(b->g) : "out of memory");
    baseline_close(b);
    return false;
}

void baseline_close(baseline *b)
{
    if (b->g) {
        gpu_kernel_destroy(b->g, &b->spatial);
        gpu_image_destroy(b->g, &b->in);
        gpu_image_destroy(b->g, &b->out);
    }
    free(b->texels);
    memset(b, 0, sizeof *b);
}

static uint32_t groups_of(uint32_t pixels)
{
    return (pixels + GROUP - 1) / GROUP;
}

static bool run_filter(baseline *b, int radius)
{
    const spatial_push push = { radius, b->sky };
    gpu_kernel_bind_image(b->g, &b->spatial, 0, tracer_vulkan_texture(b->t, TRACER_TEXTURE_viewz));
    gpu_kernel_bind_image(b->g, &b->spatial, 1, tracer_vulkan_texture(b->t, TRACER_TEXTURE_normal_roughness));
    gpu_kernel_bind_image(b->g, &b->spatial, 2, &b->in);
    gpu_kernel_bind_image(b->g, &b->spatial, 3, &b->out);
    if (!gpu_begin(b->g))
        return false;
    gpu_kernel_dispatch(b->g, &b->spatial, &push, sizeof push, groups_of(b->in.width), groups_of(b->in.height), 1);
    return gpu_submit_and_wait(b->g);
}

bool baseline_filter(baseline *b, int radius, image *m)
{
    for (size_t i = 0; i < image_pixels(m); i++) {
        float rgba[4] = { 0, 0, 0, 0 };
        for (int k = 0; k < m->channels; k++)
            rgba[k] = m->planes[k][i];
        half_from_floats(b->texels + 4 * i, rgba, 4);
    }
    if (!gpu_upload(b->g, &b->in, b->texels) || !run_filter(b, radius) || !gpu_download(b->g, &b->out, b->texels))
        return false;
    for (size_t i = 0; i < image_pixels(m); i++)
        for (int k = 0; k < m->channels; k++)
            m->planes[k][i] = half_to_float(b->texels[4 * i + (size_t)k]);
    return true;
}

static bool filter_ms(baseline *b, int radius, double *ms)
{
    double times[PROBES];
    for (int i = -2; i < PROBES; i++) {
        if (!run_filter(b, radius))
            return false;
        if (i >= 0)
            times[i] = gpu_milliseconds(b->g);
    }
    *ms = quantile(times, PROBES, 0.5);
    return true;
}

bool baseline_radius_for(baseline *b, double ms, int *radius, double *found_ms)
{
    double best = INFINITY;
    for (int r = 1; r <= BASELINE_MAX_RADIUS; r++) {
        double now;
        if (!filter_ms(b, r, &now))
            return false;
        if (fabs(now - ms) < best) {
            best = fabs(now - ms);
            *radius = r;
            *found_ms = now;
        }
        if (now > 1.5 * ms) /* one slow measurement must not end the search */
            break;
    }
    return true;
}
