#include "report/copier.h"

#include "copy_buffers_spv.h"
#include "copy_images_spv.h"

#include <math.h>
#include <string.h>

enum { WORD = 16, EACH = 4, THREADS = 256, GROUP = 8, IMAGE_WIDTH = 2048 };
/* Far more than caches hold, and within the limits of every device for one dispatch. */
#define LARGEST (1u << 29)

static bool create_kernel(gpu *g, const uint32_t *code, size_t size, const VkDescriptorType *types, gpu_kernel *out)
{
    gpu_kernel_desc desc = { 0 };
    desc.words = code;
    desc.size_bytes = size;
    desc.types = types;
    desc.type_count = 2;
    desc.push_size = sizeof(uint32_t);
    return gpu_kernel_create(g, &desc, out);
}

static bool open_buffers(copier *c)
{
    static const VkDescriptorType types[] = { VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER };
    const VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    VkDeviceSize size = (VkDeviceSize)c->capacity * WORD;
    if (!gpu_buffer_create_local(c->g, size, usage, &c->from) || !gpu_buffer_create_local(c->g, size, usage, &c->to)
        || !create_kernel(c->g, copy_buffers_spv, sizeof copy_buffers_spv, types, &c->buffers))
        return false;
    gpu_kernel_bind_buffer(c->g, &c->buffers, 0, &c->from);
    gpu_kernel_bind_buffer(c->g, &c->buffers, 1, &c->to);
    return true;
}

static bool open_images(copier *c)
{
    static const VkDescriptorType types[] = { VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE };
    const VkFormat format = VK_FORMAT_R32G32B32A32_SFLOAT;
    uint32_t height = (c->capacity + IMAGE_WIDTH - 1) / IMAGE_WIDTH;
    if (!gpu_image_create(c->g, IMAGE_WIDTH, height, format, "copy from", &c->image_from)
        || !gpu_image_create(c->g, IMAGE_WIDTH, height, format, "copy to", &c->image_to)
        || !create_kernel(c->g, copy_images_spv, sizeof copy_images_spv, types, &c->images))
        return false;
    gpu_kernel_bind_image(c->g, &c->images, 0, &c->image_from);
    gpu_kernel_bind_image(c->g, &c->images, 1, &c->image_to);
    return true;
}

bool copier_open(copier *c, gpu *g, double bytes)
{
    double largest = fmin(LARGEST, fmin(g->properties.limits.maxStorageBufferRange, (double)g->properties.limits.maxImageDimension2D * IMAGE_WIDTH * WORD));
    memset(c, 0, sizeof *c);
    c->g = g;
    c->capacity = (uint32_t)(fmin(fmax(ceil(bytes / 2), WORD), largest) / WORD);
    if (open_buffers(c) && open_images(c))
        return true;
    copier_close(c);
    return false;
}

void copier_close(copier *c)
{
    if (c->g) {
        gpu_kernel_destroy(c->g, &c->buffers);
        gpu_kernel_destroy(c->g, &c->images);
        gpu_buffer_destroy(c->g, &c->from);
        gpu_buffer_destroy(c->g, &c->to);
        gpu_image_destroy(c->g, &c->image_from);
        gpu_image_destroy(c->g, &c->image_to);
    }
    memset(c, 0, sizeof *c);
}

static void record(copier *c, copier_way way, uint32_t words)
{
    const VkBufferCopy all = { 0, 0, (VkDeviceSize)words * WORD };
    uint32_t rows = (words + IMAGE_WIDTH - 1) / IMAGE_WIDTH;
    switch (way) {
    case COPIER_BUFFERS:
        gpu_kernel_dispatch(c->g, &c->buffers, &words, sizeof words, (words + THREADS * EACH - 1) / (THREADS * EACH), 1, 1);
        break;
    case COPIER_IMAGES:
        gpu_kernel_dispatch(c->g, &c->images, &words, sizeof words, IMAGE_WIDTH / GROUP, (rows + GROUP * EACH - 1) / (GROUP * EACH), 1);
        break;
    default:
        c->g->fn.vkCmdCopyBuffer(c->g->cmd, c->from.buffer, c->to.buffer, 1, &all);
        gpu_barrier(c->g);
    }
}

bool copier_run(copier *c, copier_way way, double bytes, double *ms)
{
    double left = fmax(floor(bytes / 2 / WORD), 1);
    if (!gpu_begin(c->g))
        return false;
    for (; left > 0; left -= c->capacity)
        record(c, way, (uint32_t)fmin(left, c->capacity));
    if (!gpu_submit_and_wait(c->g))
        return false;
    *ms = gpu_milliseconds(c->g);
    return true;
}

const char *copier_way_name(copier_way way)
{
    static const char *const names[] = {
#define COPIER_NAME(id, name) name,
        COPIER_WAYS(COPIER_NAME)
#undef COPIER_NAME
    };
    return (unsigned)way < COPIER_WAY_COUNT ? names[way] : NULL;
}
