/* nrd_vk.h on a real device: every denoiser under core and synchronisation validation, failing allocations, misuse. */
#define _POSIX_C_SOURCE 200809L
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "common/gpu.h"
#include "common/half.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

/* ---------------------------------------------------------------------------------------------------------------------------
   The device, with calls counted and made to fail  >>spy */
static gpu device;
static bool validated;

static struct {
    uint32_t calls;    /* that may fail, since reset */
    uint32_t fail_at;  /* the call with this number fails; UINT32_MAX: none */
    uint32_t unknown, asked; /* the function asked for with this number, from 1 on, is none of the device's; 0: all are */
    VkResult code;     /* with this; 0: what is usual of the call */
    int32_t live;      /* objects created and not destroyed */
    char log[256];     /* B barrier, D dispatch, in the order of recording */
    uint32_t logged;
    bool no_storage;   /* no format can be stored to */
    bool fake;         /* no shader is compiled: modules and pipelines are numbers */
    uint32_t api_version; /* 0: the real one */
} spy;

static void reset_spy(void) { memset(&spy, 0, sizeof spy); spy.fail_at = UINT32_MAX; }
static bool spy_fails(void) { return spy.calls++ == spy.fail_at; }
static VkResult spy_code(VkResult usual) { return spy.code ? spy.code : usual; }
static void spy_log(char what) { if (spy.logged < sizeof spy.log) spy.log[spy.logged++] = what; }

#define SPY_OBJECTS(X) \
    X(Image, VkImage, VkImageCreateInfo) X(ImageView, VkImageView, VkImageViewCreateInfo) X(Buffer, VkBuffer, VkBufferCreateInfo) \
    X(Sampler, VkSampler, VkSamplerCreateInfo) X(DescriptorSetLayout, VkDescriptorSetLayout, VkDescriptorSetLayoutCreateInfo) \
    X(DescriptorPool, VkDescriptorPool, VkDescriptorPoolCreateInfo) X(PipelineLayout, VkPipelineLayout, VkPipelineLayoutCreateInfo) \
    X(QueryPool, VkQueryPool, VkQueryPoolCreateInfo)

#define REAL(name) ((PFN_##name)device.get_device_proc(device.device, #name))

#define SPY_OBJECT(name, type, info_type) \
    static VKAPI_ATTR VkResult VKAPI_CALL spy_vkCreate##name(VkDevice d, const info_type *info, const VkAllocationCallbacks *c, type *out) \
    { \
        if (spy_fails()) return spy_code(VK_ERROR_OUT_OF_HOST_MEMORY); \
        spy.live++; \
        return REAL(vkCreate##name)(d, info, c, out); \
    } \
    static VKAPI_ATTR void VKAPI_CALL spy_vkDestroy##name(VkDevice d, type object, const VkAllocationCallbacks *c) \
    { \
        spy.live--; \
        REAL(vkDestroy##name)(d, object, c); \
    }
SPY_OBJECTS(SPY_OBJECT)

static VKAPI_ATTR VkResult VKAPI_CALL spy_vkAllocateMemory(VkDevice d, const VkMemoryAllocateInfo *info, const VkAllocationCallbacks *c, VkDeviceMemory *out)
{
    if (spy_fails()) return spy_code(VK_ERROR_OUT_OF_DEVICE_MEMORY);
    spy.live++;
    return REAL(vkAllocateMemory)(d, info, c, out);
}

static VKAPI_ATTR void VKAPI_CALL spy_vkFreeMemory(VkDevice d, VkDeviceMemory memory, const VkAllocationCallbacks *c)
{
    spy.live--;
    REAL(vkFreeMemory)(d, memory, c);
}

static VKAPI_ATTR VkResult VKAPI_CALL spy_vkMapMemory(VkDevice d, VkDeviceMemory m, VkDeviceSize at, VkDeviceSize size, VkMemoryMapFlags flags, void **out)
{
    return spy_fails() ? spy_code(VK_ERROR_MEMORY_MAP_FAILED) : REAL(vkMapMemory)(d, m, at, size, flags, out);
}

static VKAPI_ATTR VkResult VKAPI_CALL spy_vkBindImageMemory(VkDevice d, VkImage image, VkDeviceMemory memory, VkDeviceSize at)
{
    return spy_fails() ? spy_code(VK_ERROR_OUT_OF_DEVICE_MEMORY) : REAL(vkBindImageMemory)(d, image, memory, at);
}

static VKAPI_ATTR VkResult VKAPI_CALL spy_vkBindBufferMemory(VkDevice d, VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize at)
{
    return spy_fails() ? spy_code(VK_ERROR_OUT_OF_DEVICE_MEMORY) : REAL(vkBindBufferMemory)(d, buffer, memory, at);
}

static VKAPI_ATTR VkResult VKAPI_CALL spy_vkAllocateDescriptorSets(VkDevice d, const VkDescriptorSetAllocateInfo *info, VkDescriptorSet *sets)
{
    return spy_fails() ? spy_code(VK_ERROR_OUT_OF_POOL_MEMORY) : REAL(vkAllocateDescriptorSets)(d, info, sets);
}

static VKAPI_ATTR VkResult VKAPI_CALL spy_vkCreateComputePipelines(VkDevice d, VkPipelineCache cache, uint32_t n, const VkComputePipelineCreateInfo *info,
                                                                   const VkAllocationCallbacks *c, VkPipeline *out)
{
    if (spy_fails()) return spy_code(VK_ERROR_OUT_OF_DEVICE_MEMORY);
    spy.live += (int32_t)n;
    if (!spy.fake) return REAL(vkCreateComputePipelines)(d, cache, n, info, c, out);
    for (uint32_t i = 0; i < n; i++) out[i] = (VkPipeline)(uintptr_t)1;
    return VK_SUCCESS;
}

static VKAPI_ATTR void VKAPI_CALL spy_vkDestroyPipeline(VkDevice d, VkPipeline pipeline, const VkAllocationCallbacks *c)
{
    spy.live--;
    if (!spy.fake) REAL(vkDestroyPipeline)(d, pipeline, c);
}

static VKAPI_ATTR void VKAPI_CALL spy_vkCmdDispatch(VkCommandBuffer cmd, uint32_t x, uint32_t y, uint32_t z)
{
    spy_log('D');
    REAL(vkCmdDispatch)(cmd, x, y, z);
}

static VKAPI_ATTR void VKAPI_CALL spy_vkCmdDispatchIndirect(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset)
{
    spy_log('D');
    REAL(vkCmdDispatchIndirect)(cmd, buffer, offset);
}

static VKAPI_ATTR void VKAPI_CALL spy_vkCmdPipelineBarrier(VkCommandBuffer cmd, VkPipelineStageFlags from, VkPipelineStageFlags to, VkDependencyFlags flags, uint32_t mn,
                                                           const VkMemoryBarrier *m, uint32_t bn, const VkBufferMemoryBarrier *b, uint32_t in, const VkImageMemoryBarrier *i)
{
    spy_log('B');
    REAL(vkCmdPipelineBarrier)(cmd, from, to, flags, mn, m, bn, b, in, i);
}

static VKAPI_ATTR VkResult VKAPI_CALL spy_vkGetQueryPoolResults(VkDevice d, VkQueryPool pool, uint32_t first, uint32_t count, size_t size, void *data,
                                                                VkDeviceSize stride, VkQueryResultFlags flags)
{
    return spy_fails() ? spy_code(VK_ERROR_DEVICE_LOST) : REAL(vkGetQueryPoolResults)(d, pool, first, count, size, data, stride, flags);
}

static VKAPI_ATTR VkResult VKAPI_CALL spy_vkCreateShaderModule(VkDevice d, const VkShaderModuleCreateInfo *info, const VkAllocationCallbacks *c, VkShaderModule *out)
{
    if (spy_fails()) return spy_code(VK_ERROR_OUT_OF_HOST_MEMORY);
    spy.live++;
    if (!spy.fake) return REAL(vkCreateShaderModule)(d, info, c, out);
    *out = (VkShaderModule)(uintptr_t)1;
    return VK_SUCCESS;
}

static VKAPI_ATTR void VKAPI_CALL spy_vkDestroyShaderModule(VkDevice d, VkShaderModule module, const VkAllocationCallbacks *c)
{
    spy.live--;
    if (!spy.fake) REAL(vkDestroyShaderModule)(d, module, c);
}

static PFN_vkVoidFunction VKAPI_CALL spy_get_device_proc(VkDevice d, const char *name)
{
    if (++spy.asked == spy.unknown) return NULL;
#define SPY_ENTRY(function) if (strcmp(name, #function) == 0) return (PFN_vkVoidFunction)spy_##function;
#define SPY_ENTRIES(object, type, info) SPY_ENTRY(vkCreate##object) SPY_ENTRY(vkDestroy##object)
    SPY_OBJECTS(SPY_ENTRIES)
    SPY_ENTRY(vkCreateShaderModule) SPY_ENTRY(vkDestroyShaderModule)
    SPY_ENTRY(vkAllocateMemory) SPY_ENTRY(vkFreeMemory) SPY_ENTRY(vkMapMemory) SPY_ENTRY(vkBindImageMemory) SPY_ENTRY(vkBindBufferMemory)
    SPY_ENTRY(vkAllocateDescriptorSets) SPY_ENTRY(vkCreateComputePipelines) SPY_ENTRY(vkDestroyPipeline) SPY_ENTRY(vkGetQueryPoolResults)
    SPY_ENTRY(vkCmdDispatch) SPY_ENTRY(vkCmdDispatchIndirect) SPY_ENTRY(vkCmdPipelineBarrier)
    return device.get_device_proc(d, name);
}

static VKAPI_ATTR void VKAPI_CALL spy_vkGetPhysicalDeviceFormatProperties(VkPhysicalDevice p, VkFormat format, VkFormatProperties *out)
{
    device.fn.vkGetPhysicalDeviceFormatProperties(p, format, out);
    if (spy.no_storage) out->optimalTilingFeatures &= ~(VkFormatFeatureFlags)VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
}

static VKAPI_ATTR void VKAPI_CALL spy_vkGetPhysicalDeviceProperties(VkPhysicalDevice p, VkPhysicalDeviceProperties *out)
{
    device.fn.vkGetPhysicalDeviceProperties(p, out);
    if (spy.api_version) out->apiVersion = spy.api_version;
}

static PFN_vkVoidFunction VKAPI_CALL spy_get_instance_proc(VkInstance instance, const char *name)
{
    SPY_ENTRY(vkGetPhysicalDeviceFormatProperties)
    SPY_ENTRY(vkGetPhysicalDeviceProperties)
    return device.get_instance_proc(instance, name);
}

static int open_device(void **state)
{
    char error[256];
    (void)state;
    reset_spy();
    validated = gpu_validation_available();
    if (!validated) print_message("VK_LAYER_KHRONOS_validation is not installed: running without it\n");
    gpu_desc desc = { .validation = validated, .sync_validation = validated };
    if (gpu_open(&device, &desc, error, sizeof error)) return 0;
    print_error("%s\n", error);
    return -1;
}

static int close_device(void **state)
{
    (void)state;
    gpu_close(&device);
    return 0;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   A denoiser with its images  >>rig */
enum { MAX_OUTPUT = 1 << 20 };

typedef struct rig {
    nrd *instance;
    nrd_vk *vk;
    gpu_image images[NRD_RESOURCE_COUNT]; /* those without a view are not used */
    uint32_t width, height, frame;
    uint32_t rect_width, rect_height;     /* 0: all */
    VkCommandBuffer cmds[2];
    VkFence fences[2];
    nrd_result last_result;
    char last_text[512];
} rig;

static void on_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    rig *r = (rig *)user;
    (void)severity;
    r->last_result = result;
    snprintf(r->last_text, sizeof r->last_text, "%s", text);
}

static nrd_result create_instance(rig *r, const nrd_denoiser *list, uint32_t count, uint32_t width, uint32_t height, uint32_t features)
{
    nrd_denoiser_desc denoisers[8];
    for (uint32_t i = 0; i < count; i++) denoisers[i].identifier = i, denoisers[i].denoiser = list[i];
    nrd_desc desc = { .width = width, .height = height, .denoisers = denoisers, .denoiser_count = count, .features = features,
                      .normal_encoding = NRD_NORMAL_FORMAT_RGBA16_SNORM, .message = on_message, .message_user = r };
    r->width = width;
    r->height = height;
    return nrd_create(&desc, &r->instance);
}

static nrd_vk_desc vk_desc(const rig *r)
{
    nrd_vk_desc desc = { .instance = r->instance, .vk_instance = device.instance, .physical = device.physical, .device = device.device,
                         .get_instance_proc = spy_get_instance_proc, .get_device_proc = spy_get_device_proc,
                         .queue_family = device.family, .flags = NRD_VK_TIMESTAMPS | NRD_VK_DEBUG_NAMES };
    return desc;
}

static VkFormat image_format(nrd_resource resource)
{
    VkFormat format = nrd_vk_format(nrd_resource_format(resource));
    if (format != VK_FORMAT_UNDEFINED) return format;
    return resource == NRD_RESOURCE_IN_VIEWZ || resource == NRD_RESOURCE_IN_DIFF_CONFIDENCE || resource == NRD_RESOURCE_IN_DISOCCLUSION_THRESHOLD_MIX
        ? VK_FORMAT_R32_SFLOAT : VK_FORMAT_R32G32B32A32_SFLOAT;
}

static float noise(uint32_t x)
{
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return (float)((x ^ (x >> 16)) >> 8) / 16777216.0f;
}

static const float sky_z = 1e6f;
static bool is_sky(const rig *r, uint32_t x, uint32_t y) { return x + 2 * y < r->width / 3; }

/* A tilted plane in front of the camera with a corner of sky. */
static void fill_texel(const rig *r, nrd_resource resource, uint32_t x, uint32_t y, float *texel)
{
    uint32_t seed = (y * r->width + x) * 8 + (uint32_t)resource * 1000003u;
    switch (resource) {
    case NRD_RESOURCE_IN_MV: texel[0] = 0.25f / (float)r->width; texel[1] = texel[2] = texel[3] = 0; break;
    case NRD_RESOURCE_IN_NORMAL_ROUGHNESS: texel[0] = texel[1] = 0; texel[2] = -1; texel[3] = 1; break;
    case NRD_RESOURCE_IN_VIEWZ: texel[0] = is_sky(r, x, y) ? sky_z : 5 + 0.01f * (float)y; break;
    case NRD_RESOURCE_IN_DIFF_CONFIDENCE:
    case NRD_RESOURCE_IN_DISOCCLUSION_THRESHOLD_MIX: texel[0] = noise(seed); break;
    case NRD_RESOURCE_IN_PENUMBRA: texel[0] = noise(seed) * (float)r->width < (float)x ? 65504.0f : 0.5f; texel[1] = texel[2] = texel[3] = 0; break;
    default:
        for (uint32_t c = 0; c < 4; c++) texel[c] = noise(seed + c) * (c == 1 || c == 2 ? 0.1f : 1.0f);
    }
}

/* poison: NaN where nothing may be read: outside the rectangle, and in noisy signals of the sky. */
static void upload_input(rig *r, nrd_resource resource, bool poison)
{
    uint32_t channels = r->images[resource].format == VK_FORMAT_R32_SFLOAT ? 1 : 4;
    bool guide = resource == NRD_RESOURCE_IN_MV || resource == NRD_RESOURCE_IN_NORMAL_ROUGHNESS || resource == NRD_RESOURCE_IN_VIEWZ || channels == 1;
    float *texels = (float *)malloc((size_t)r->width * r->height * channels * sizeof *texels);
    assert_non_null(texels);
    for (uint32_t i = 0; i < r->width * r->height; i++) {
        uint32_t x = i % r->width, y = i / r->width;
        bool outside = (r->rect_width && x >= r->rect_width) || (r->rect_height && y >= r->rect_height);
        float *texel = texels + (size_t)i * channels;
        fill_texel(r, resource, x, y, texel);
        for (uint32_t c = 0; c < channels && poison && (outside || (is_sky(r, x, y) && !guide)); c++) texel[c] = NAN;
    }
    assert_true(gpu_upload(&device, &r->images[resource], texels));
    free(texels);
}

static void create_images(rig *r)
{
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        nrd_resource resource = (nrd_resource)i;
        if (!nrd_uses_resource(r->instance, resource)) continue;
        assert_true(gpu_image_create(&device, r->width, r->height, image_format(resource), nrd_resource_name(resource), &r->images[i]));
        if (nrd_resource_format(resource) == NRD_FORMAT_ANY) upload_input(r, resource, false);
        else {
            void *zeros = calloc((size_t)r->width * r->height, gpu_format_size(r->images[i].format));
            assert_non_null(zeros);
            assert_true(gpu_upload(&device, &r->images[i], zeros));
            free(zeros);
        }
    }
}

static void create_commands(rig *r)
{
    VkCommandBufferAllocateInfo cmds = { VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, NULL, device.pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 2 };
    VkFenceCreateInfo fence = { VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, NULL, VK_FENCE_CREATE_SIGNALED_BIT };
    assert_int_equal(device.fn.vkAllocateCommandBuffers(device.device, &cmds, r->cmds), VK_SUCCESS);
    for (int i = 0; i < 2; i++) assert_int_equal(device.fn.vkCreateFence(device.device, &fence, NULL, &r->fences[i]), VK_SUCCESS);
}

static void open_rig(rig *r, const nrd_denoiser *list, uint32_t count, uint32_t width, uint32_t height, uint32_t features)
{
    memset(r, 0, sizeof *r);
    assert_int_equal(create_instance(r, list, count, width, height, features), NRD_RESULT_OK);
    nrd_vk_desc desc = vk_desc(r);
    assert_int_equal(nrd_vk_create(&desc, &r->vk), NRD_RESULT_OK);
    create_images(r);
    create_commands(r);
}

static void close_rig(rig *r)
{
    device.fn.vkDeviceWaitIdle(device.device);
    nrd_vk_destroy(r->vk);
    nrd_destroy(r->instance);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) gpu_image_destroy(&device, &r->images[i]);
    if (r->cmds[0]) device.fn.vkFreeCommandBuffers(device.device, device.pool, 2, r->cmds);
    for (int i = 0; i < 2; i++) if (r->fences[i]) device.fn.vkDestroyFence(device.device, r->fences[i], NULL);
}

static void set_frame(rig *r)
{
    nrd_frame frame = nrd_frame_defaults();
    const float clip[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, -0.1f, 0 };
    memcpy(frame.camera.view_to_clip, clip, sizeof clip);
    for (int i = 0; i < 4; i++) frame.camera.world_to_view[5 * i] = 1;
    frame.frame_index = r->frame;
    frame.rect_width = r->rect_width;
    frame.rect_height = r->rect_height;
    assert_int_equal(nrd_set_frame(r->instance, &frame), NRD_RESULT_OK);
}

/* Every image, changing layout on the way where the parity says so. */
static uint32_t list_images(rig *r, nrd_vk_image *list, bool last)
{
    uint32_t count = 0;
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        gpu_image *image = &r->images[i];
        if (!image->view) continue;
        nrd_vk_image given = { (nrd_resource)i, image->image, image->view, image->format, image->width, image->height, image->layout, VK_IMAGE_LAYOUT_GENERAL, 0, 0, 0 };
        if (!last && (r->frame + (uint32_t)i) % 3 == 1) given.layout_out = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
        if (!last && (r->frame + (uint32_t)i) % 3 == 2) given.layout_out = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        image->layout = given.layout_out;
        list[count++] = given;
    }
    return count;
}

static void begin_slot(rig *r, uint32_t slot)
{
    VkCommandBufferBeginInfo begin = { VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, NULL, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, NULL };
    assert_int_equal(device.fn.vkWaitForFences(device.device, 1, &r->fences[slot], VK_TRUE, UINT64_MAX), VK_SUCCESS);
    assert_int_equal(device.fn.vkResetFences(device.device, 1, &r->fences[slot]), VK_SUCCESS);
    assert_int_equal(device.fn.vkResetCommandBuffer(r->cmds[slot], 0), VK_SUCCESS);
    assert_int_equal(device.fn.vkBeginCommandBuffer(r->cmds[slot], &begin), VK_SUCCESS);
}

static void submit_slot(rig *r, uint32_t slot)
{
    VkSubmitInfo submit = { VK_STRUCTURE_TYPE_SUBMIT_INFO, NULL, 0, NULL, NULL, 1, &r->cmds[slot], 0, NULL };
    assert_int_equal(device.fn.vkEndCommandBuffer(r->cmds[slot]), VK_SUCCESS);
    assert_int_equal(device.fn.vkQueueSubmit(device.queue, 1, &submit, r->fences[slot]), VK_SUCCESS);
}

/* Leaves up to two frames in flight. */
static void run_frame(rig *r, bool last)
{
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    uint32_t slot = r->frame % 2;
    nrd_vk_frame frame = { .slot = slot, .images = list, .image_count = list_images(r, list, last) };
    set_frame(r);
    begin_slot(r, slot);
    nrd_result result = nrd_vk_record(r->vk, r->cmds[slot], &frame);
    if (result != NRD_RESULT_OK) print_error("%s\n", r->last_text);
    submit_slot(r, slot);
    assert_int_equal(result, NRD_RESULT_OK);
    r->frame++;
}

static void run_frames(rig *r, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) run_frame(r, i + 1 == count);
    assert_int_equal(device.fn.vkDeviceWaitIdle(device.device), VK_SUCCESS);
}

/* The first output image; free it. */
static void *read_output(rig *r, nrd_resource resource, size_t *bytes)
{
    const gpu_image *image = &r->images[resource];
    *bytes = (size_t)image->width * image->height * gpu_format_size(image->format);
    void *texels = malloc(*bytes);
    assert_non_null(texels);
    assert_true(gpu_download(&device, image, texels));
    return texels;
}

static size_t component_size(VkFormat format)
{
    if (format == VK_FORMAT_R8_UNORM || format == VK_FORMAT_R8G8B8A8_UNORM) return 1;
    return format == VK_FORMAT_R16G16B16A16_SFLOAT || format == VK_FORMAT_R16_SFLOAT ? 2 : 4;
}

static float texel_value(const void *texels, VkFormat format, size_t index)
{
    if (component_size(format) == 1) return (float)((const uint8_t *)texels)[index] / 255.0f;
    if (component_size(format) == 2) return half_to_float(((const uint16_t *)texels)[index]);
    return ((const float *)texels)[index];
}

static nrd_resource output_of(const rig *r)
{
    int i = 0;
    while (i < NRD_RESOURCE_COUNT - 1 && (!r->images[i].view || nrd_resource_format((nrd_resource)i) == NRD_FORMAT_ANY)) i++;
    return (nrd_resource)i;
}

static void assert_no_messages(uint32_t before) { assert_int_equal(gpu_message_count(&device) - before, 0); }

/* ---------------------------------------------------------------------------------------------------------------------------
   Frames  >>frames */
static void run_denoiser(nrd_denoiser denoiser, uint32_t features)
{
    rig r;
    size_t bytes;
    uint32_t before = gpu_message_count(&device);
    open_rig(&r, &denoiser, 1, 72, 40, features);
    run_frames(&r, 7);
    nrd_resource output = output_of(&r);
    void *texels = read_output(&r, output, &bytes);
    VkFormat format = r.images[output].format;
    double sum = 0;
    for (size_t i = 0; i < bytes / component_size(format); i++) {
        float value = texel_value(texels, format, i);
        assert_true(isfinite(value));
        sum += value;
    }
    assert_true(sum > 1);
    free(texels);
    close_rig(&r);
    assert_no_messages(before);
}

static void every_denoiser_runs_two_frames_in_flight_without_a_validation_message(void **state)
{
    (void)state;
    reset_spy();
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        run_denoiser((nrd_denoiser)i, 0);
        run_denoiser((nrd_denoiser)i, NRD_FEATURE_ALL);
    }
    assert_int_equal(spy.live, 0);
}

static void optional_inputs_and_passes_run_without_a_validation_message(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    nrd_reblur_settings settings = nrd_reblur_defaults();
    rig r;
    (void)state;
    uint32_t before = gpu_message_count(&device);
    open_rig(&r, &denoiser, 1, 72, 40, NRD_FEATURE_ALL);
    settings.diffuse_prepass_blur_radius = 20;
    assert_int_equal(nrd_set_settings(r.instance, 0, &settings), NRD_RESULT_OK);
    run_frames(&r, 3);
    settings.max_blur_radius = 0;
    settings.antilag_sensitivity = 0;
    assert_int_equal(nrd_set_settings(r.instance, 0, &settings), NRD_RESULT_OK);
    run_frames(&r, 3);
    close_rig(&r);
    assert_no_messages(before);
}

static void record_denoisers(rig *r, const uint32_t *identifiers, uint32_t count)
{
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    nrd_vk_frame frame = { .slot = r->frame % 2, .images = list, .identifiers = identifiers, .identifier_count = count };
    frame.image_count = list_images(r, list, true);
    assert_int_equal(nrd_vk_record(r->vk, r->cmds[frame.slot], &frame), NRD_RESULT_OK);
}

static void denoisers_of_one_instance_can_be_recorded_together_or_one_by_one(void **state)
{
    static const nrd_denoiser both[] = { NRD_DENOISER_REFERENCE, NRD_DENOISER_REBLUR_DIFFUSE };
    static const uint32_t identifiers[] = { 1, 0 };
    rig together, apart;
    size_t bytes;
    (void)state;
    uint32_t before = gpu_message_count(&device);
    open_rig(&together, both, 2, 40, 40, 0);
    open_rig(&apart, both, 2, 40, 40, 0);
    run_frames(&together, 4);
    for (; apart.frame < 4; apart.frame++) {
        set_frame(&apart);
        begin_slot(&apart, apart.frame % 2);
        record_denoisers(&apart, &identifiers[0], 1);
        record_denoisers(&apart, &identifiers[1], 1);
        submit_slot(&apart, apart.frame % 2);
    }
    device.fn.vkDeviceWaitIdle(device.device);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (!together.images[i].view || nrd_resource_format((nrd_resource)i) == NRD_FORMAT_ANY) continue;
        void *a = read_output(&together, (nrd_resource)i, &bytes), *b = read_output(&apart, (nrd_resource)i, &bytes);
        assert_memory_equal(a, b, bytes);
        free(a);
        free(b);
    }
    close_rig(&together);
    close_rig(&apart);
    assert_no_messages(before);
}

static void two_instances_on_one_device_do_not_disturb_each_other_and_repeat_bit_by_bit(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    rig alone, a, b;
    size_t bytes;
    (void)state;
    uint32_t before = gpu_message_count(&device);
    open_rig(&alone, &denoiser, 1, 64, 48, 0);
    run_frames(&alone, 6);
    void *expected = read_output(&alone, output_of(&alone), &bytes);
    close_rig(&alone);
    open_rig(&a, &denoiser, 1, 64, 48, 0);
    open_rig(&b, &denoiser, 1, 48, 64, 0);
    for (uint32_t i = 0; i < 6; i++) {
        run_frame(&a, i == 5);
        run_frame(&b, i == 5);
    }
    device.fn.vkDeviceWaitIdle(device.device);
    void *got = read_output(&a, output_of(&a), &bytes);
    assert_memory_equal(expected, got, bytes);
    free(expected);
    free(got);
    close_rig(&a);
    close_rig(&b);
    assert_no_messages(before);
}

static void the_denoiser_can_be_created_again_at_other_sizes(void **state)
{
    static const uint32_t sizes[][2] = { { 1, 1 }, { 17, 9 }, { 128, 8 }, { 33, 65 } };
    (void)state;
    reset_spy();
    uint32_t before = gpu_message_count(&device);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
        rig r;
        open_rig(&r, &denoiser, 1, sizes[i][0], sizes[i][1], 0);
        run_frames(&r, 3);
        close_rig(&r);
    }
    assert_int_equal(spy.live, 0);
    assert_no_messages(before);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Other sizes while frames are in flight  >>resize */
/* Images of a size, made before anything is recorded, so that nothing waits between two frames of different sizes. */
static void prepare_size(rig *r, uint32_t width, uint32_t height, gpu_image *images)
{
    rig other = *r;
    other.width = width;
    other.height = height;
    memset(other.images, 0, sizeof other.images);
    create_images(&other);
    memcpy(images, other.images, sizeof other.images);
}

static void change_size(rig *r, const gpu_image *images)
{
    uint32_t i = 0;
    while (!images[i].view) i++;
    assert_int_equal(nrd_vk_resize(r->vk, images[i].width, images[i].height), NRD_RESULT_OK);
    memcpy(r->images, images, sizeof r->images);
    r->width = images[i].width;
    r->height = images[i].height;
}

enum { SIZES = 4 };
static const uint32_t some_sizes[SIZES][2] = { { 72, 40 }, { 96, 56 }, { 17, 9 }, { 33, 65 } };

/* Leaves the rig without images of its own. */
static void close_sizes(rig *r, gpu_image images[SIZES][NRD_RESOURCE_COUNT])
{
    device.fn.vkDeviceWaitIdle(device.device);
    for (int i = 0; i < SIZES; i++)
        for (int k = 0; k < NRD_RESOURCE_COUNT; k++) gpu_image_destroy(&device, &images[i][k]);
    memset(r->images, 0, sizeof r->images);
    close_rig(r);
}

static void open_sizes(rig *r, nrd_denoiser denoiser, gpu_image images[SIZES][NRD_RESOURCE_COUNT])
{
    open_rig(r, &denoiser, 1, some_sizes[0][0], some_sizes[0][1], 0);
    memcpy(images[0], r->images, sizeof r->images);
    for (int i = 1; i < SIZES; i++) prepare_size(r, some_sizes[i][0], some_sizes[i][1], images[i]);
}

static void every_denoiser_changes_size_with_frames_in_flight_and_frees_the_former_images(void **state)
{
    static gpu_image images[SIZES][NRD_RESOURCE_COUNT];
    (void)state;
    uint32_t before = gpu_message_count(&device);
    reset_spy();
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        rig r;
        open_sizes(&r, (nrd_denoiser)i, images);
        int32_t live = spy.live;
        for (int size = 0; size <= SIZES; size++) {
            if (size) change_size(&r, images[size % SIZES]);
            assert_true(size == 0 || spy.live > live);
            for (int frame = 0; frame < 3; frame++) run_frame(&r, frame == 2);
            assert_int_equal(spy.live, live);
        }
        close_sizes(&r, images);
    }
    assert_int_equal(spy.live, 0);
    assert_no_messages(before);
}

/* As while a window is dragged. */
static void a_resize_in_every_frame_keeps_no_more_than_the_frames_in_flight_need(void **state)
{
    static gpu_image images[SIZES][NRD_RESOURCE_COUNT];
    rig r;
    (void)state;
    uint32_t before = gpu_message_count(&device);
    reset_spy();
    open_sizes(&r, NRD_DENOISER_REBLUR_DIFFUSE, images);
    int32_t without_images = spy.live - 2 * (int32_t)nrd_get_info(r.instance)->texture_count - 2, each = spy.live - without_images;
    for (int frame = 0; frame < 12; frame++) {
        run_frame(&r, true);
        change_size(&r, images[(frame + 2) % SIZES]);
        change_size(&r, images[(frame + 1) % SIZES]);
        assert_true(spy.live <= without_images + 4 * each);   /* this size, the last, two in flight */
    }
    close_sizes(&r, images);
    assert_int_equal(spy.live, 0);
    assert_no_messages(before);
}

static void denoisers_recorded_one_by_one_in_one_slot_all_read_the_former_images(void **state)
{
    static const nrd_denoiser both[] = { NRD_DENOISER_REBLUR_DIFFUSE, NRD_DENOISER_SIGMA_SHADOW };
    static const uint32_t identifiers[] = { 0, 1 };
    static gpu_image large[NRD_RESOURCE_COUNT];
    rig r;
    (void)state;
    uint32_t before = gpu_message_count(&device);
    reset_spy();
    open_rig(&r, both, 2, 40, 24, 0);
    prepare_size(&r, 56, 40, large);
    int32_t live = spy.live;
    gpu_image small[NRD_RESOURCE_COUNT];
    memcpy(small, r.images, sizeof small);
    for (; r.frame < 8; r.frame++) {
        if (r.frame == 4) change_size(&r, large);
        set_frame(&r);
        begin_slot(&r, r.frame % 2);
        for (int i = 0; i < 2; i++) record_denoisers(&r, &identifiers[i], 1);
        submit_slot(&r, r.frame % 2);
        assert_true(r.frame < 4 || r.frame > 5 || spy.live > live);
    }
    assert_int_equal(spy.live, live);
    device.fn.vkDeviceWaitIdle(device.device);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) gpu_image_destroy(&device, &small[i]);
    close_rig(&r);
    assert_int_equal(spy.live, 0);
    assert_no_messages(before);
}

static void *undisturbed_output(nrd_denoiser denoiser, uint32_t frames, size_t *bytes)
{
    rig r;
    open_rig(&r, &denoiser, 1, 40, 24, 0);
    run_frames(&r, frames);
    void *texels = read_output(&r, output_of(&r), bytes);
    close_rig(&r);
    return texels;
}

static void assert_undisturbed(rig *r, nrd_denoiser denoiser)
{
    size_t bytes;
    void *expected = undisturbed_output(denoiser, r->frame, &bytes), *got = read_output(r, output_of(r), &bytes);
    assert_memory_equal(expected, got, bytes);
    free(expected);
    free(got);
}

/* Out of memory, or the device is gone. */
static void fail_next(uint32_t call, uint32_t way, rig *r)
{
    static const VkResult ways[] = { VK_ERROR_DEVICE_LOST, VK_ERROR_OUT_OF_DEVICE_MEMORY, VK_ERROR_OUT_OF_HOST_MEMORY };
    reset_spy();
    spy.fail_at = call;
    spy.code = ways[way % 3];
    r->last_text[0] = 0;
}

static void assert_device_error(nrd_result result, const rig *r)
{
    char expected[64];
    snprintf(expected, sizeof expected, " failed with VkResult %d", (int)spy.code);
    assert_int_equal(result, NRD_RESULT_DEVICE_ERROR);
    assert_non_null(strstr(r->last_text, expected));
}

static void a_resize_that_fails_or_is_taken_back_changes_nothing(void **state)
{
    nrd_result result = NRD_RESULT_DEVICE_ERROR;
    uint32_t calls = 0;
    rig r;
    (void)state;
    uint32_t before = gpu_message_count(&device);
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    open_rig(&r, &denoiser, 1, 40, 24, 0);
    run_frames(&r, 3);
    assert_int_equal(nrd_vk_resize(r.vk, 0, 24), NRD_RESULT_INVALID_ARGUMENT);
    assert_non_null(strstr(r.last_text, "nrd_resize.width is 0, allowed: 1 to 16384"));
    assert_int_equal(nrd_vk_resize(NULL, 40, 24), NRD_RESULT_INVALID_ARGUMENT);
    for (; result != NRD_RESULT_OK; calls++) {
        fail_next(calls, calls, &r);
        result = nrd_vk_resize(r.vk, 100, 50);
        if (result == NRD_RESULT_OK) break;
        assert_device_error(result, &r);
        assert_int_equal(spy.live, 0);
        assert_int_equal(nrd_get_info(r.instance)->width, 40);
    }
    spy.fail_at = UINT32_MAX;
    assert_true(calls > 10);
    assert_int_equal(nrd_vk_resize(r.vk, 7, 9), NRD_RESULT_OK);
    assert_int_equal(nrd_vk_resize(r.vk, 40, 24), NRD_RESULT_OK);
    assert_int_equal(spy.live, 0);
    run_frames(&r, 3);
    assert_undisturbed(&r, denoiser);
    close_rig(&r);
    assert_no_messages(before);
}

static void the_core_alone_must_not_be_resized_under_a_runtime(void **state)
{
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    nrd_vk_frame frame = { .images = list };
    rig r;
    (void)state;
    open_rig(&r, &denoiser, 1, 40, 24, 0);
    assert_int_equal(nrd_resize(r.instance, 48, 24), NRD_RESULT_OK);
    set_frame(&r);
    frame.image_count = list_images(&r, list, true);
    assert_int_equal(nrd_vk_record(r.vk, r.cmds[0], &frame), NRD_RESULT_INVALID_ARGUMENT);
    assert_non_null(strstr(r.last_text, "nrd_vk_resize"));
    assert_int_equal(nrd_resize(r.instance, 40, 24), NRD_RESULT_OK);
    run_frames(&r, 2);
    assert_undisturbed(&r, denoiser);
    close_rig(&r);
}

static void *run_poisoned(bool poison, size_t *bytes)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    rig r;
    open_rig(&r, &denoiser, 1, 72, 56, 0);
    r.rect_width = 61;
    r.rect_height = 43;
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++)
        if (r.images[i].view && nrd_resource_format((nrd_resource)i) == NRD_FORMAT_ANY) upload_input(&r, (nrd_resource)i, poison);
    run_frames(&r, 6);
    void *texels = read_output(&r, output_of(&r), bytes);
    close_rig(&r);
    return texels;
}

static void nan_outside_the_rectangle_and_in_the_sky_has_no_effect(void **state)
{
    size_t bytes;
    (void)state;
    void *clean = run_poisoned(false, &bytes), *poisoned = run_poisoned(true, &bytes);
    assert_memory_equal(clean, poisoned, bytes);
    free(clean);
    free(poisoned);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Barriers  >>barriers */
static bool same_image(const nrd_binding *a, const nrd_binding *b)
{
    return a->resource == b->resource && (a->resource != NRD_RESOURCE_INTERNAL || a->texture == b->texture);
}

static bool is_written(const nrd_binding *b) { return b->access == NRD_ACCESS_WRITE || b->access == NRD_ACCESS_BUFFER; }

static bool conflict(const nrd_dispatch *a, const nrd_dispatch *b)
{
    for (uint32_t i = 0; i < a->binding_count; i++)
        for (uint32_t j = 0; j < b->binding_count; j++)
            if (same_image(&a->bindings[i], &b->bindings[j]) && (is_written(&a->bindings[i]) || is_written(&b->bindings[j]))) return true;
    return false;
}

static bool starts_transient(const nrd_info *info, const nrd_dispatch *dispatches, uint32_t at)
{
    for (uint32_t i = 0; i < dispatches[at].binding_count; i++) {
        const nrd_binding *binding = &dispatches[at].bindings[i];
        bool first = binding->resource == NRD_RESOURCE_INTERNAL && !info->textures[binding->texture].permanent;
        for (uint32_t d = 0; d < at && first; d++)
            for (uint32_t j = 0; j < dispatches[d].binding_count; j++) first = first && !same_image(&dispatches[d].bindings[j], binding);
        if (first) return true;
    }
    return false;
}

/* From the bindings alone: a barrier before the first dispatch, after the last, and where a dispatch conflicts with one since
   the last barrier or begins to use memory that others share. */
static void expected_log(const nrd_info *info, const nrd_dispatch *dispatches, uint32_t count, char *log)
{
    uint32_t since = 0;
    for (uint32_t i = 0; i < count; i++) {
        bool barrier = i == 0 || starts_transient(info, dispatches, i);
        for (uint32_t j = since; j < i; j++) barrier = barrier || conflict(&dispatches[j], &dispatches[i]);
        if (barrier) *log++ = 'B', since = i;
        *log++ = 'D';
    }
    *log++ = 'B';
    *log = 0;
}

static void barriers_are_where_accesses_conflict_and_nowhere_else(void **state)
{
    static const nrd_denoiser list[] = { NRD_DENOISER_REFERENCE, NRD_DENOISER_REBLUR_DIFFUSE, NRD_DENOISER_REFERENCE };
    const nrd_dispatch *dispatches;
    uint32_t count;
    char expected[256];
    rig r, twin;
    (void)state;
    open_rig(&r, list, 2, 32, 32, 0);
    memset(&twin, 0, sizeof twin);
    assert_int_equal(create_instance(&twin, list, 2, 32, 32, 0), NRD_RESULT_OK);
    for (uint32_t i = 0; i < 3; i++) {
        reset_spy();
        twin.frame = i;
        set_frame(&twin);
        run_frame(&r, i == 2);
        assert_int_equal(nrd_get_dispatches(twin.instance, NULL, 0, &dispatches, &count), NRD_RESULT_OK);
        assert_true(count > 1);
        expected_log(nrd_get_info(twin.instance), dispatches, count, expected);
        spy.log[spy.logged] = 0;
        assert_string_equal(i == 0 ? spy.log + 1 : spy.log, expected); /* the first frame also clears history */
    }
    nrd_destroy(twin.instance);
    close_rig(&r);
}

static void recording_creates_and_allocates_nothing(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    rig r;
    (void)state;
    open_rig(&r, &denoiser, 1, 32, 32, 0);
    reset_spy();
    run_frames(&r, 4);
    assert_int_equal(spy.calls, 0);
    close_rig(&r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Memory  >>memory */
/* Every call of creation in turn; returns how many there are. way: of the first call, see fail_next(); each fails in another way than the one before. */
static uint32_t fail_creation(const nrd_denoiser *list, uint32_t count, uint32_t features, uint32_t way, bool fake)
{
    nrd_result result = NRD_RESULT_DEVICE_ERROR;
    uint32_t calls = 0;
    rig r;
    memset(&r, 0, sizeof r);
    assert_int_equal(create_instance(&r, list, count, 16, 16, features), NRD_RESULT_OK);
    nrd_vk_desc desc = vk_desc(&r);
    desc.flags = fake ? NRD_VK_TIMESTAMPS : desc.flags;
    for (; result != NRD_RESULT_OK; calls++) {
        fail_next(calls, way + calls, &r);
        spy.fake = fake;
        result = nrd_vk_create(&desc, &r.vk);
        if (result == NRD_RESULT_OK) break;
        assert_device_error(result, &r);
        assert_null(r.vk);
        assert_int_equal(spy.live, 0);
    }
    nrd_vk_destroy(r.vk);
    assert_int_equal(spy.live, 0);
    nrd_destroy(r.instance);
    return calls;
}

static void every_failing_vulkan_call_of_creation_is_reported_and_leaks_nothing(void **state)
{
    static const nrd_denoiser list[] = { NRD_DENOISER_REFERENCE, NRD_DENOISER_REBLUR_DIFFUSE };
    (void)state;
    assert_true(fail_creation(list, 2, 0, 0, false) > 30);
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        nrd_denoiser one = (nrd_denoiser)d;
        for (uint32_t way = 0; way < 3; way++) assert_true(fail_creation(&one, 1, d % 2 ? NRD_FEATURE_ALL : 0, way, true) > 15);
    }
    reset_spy();
}

static void every_failing_vulkan_call_of_measuring_memory_is_reported_and_leaks_nothing(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    nrd_result result = NRD_RESULT_DEVICE_ERROR;
    VkMemoryRequirements needs[3];
    uint32_t calls = 0;
    rig r;
    (void)state;
    memset(&r, 0, sizeof r);
    assert_int_equal(create_instance(&r, &denoiser, 1, 16, 16, 0), NRD_RESULT_OK);
    nrd_vk_desc desc = vk_desc(&r);
    for (; result != NRD_RESULT_OK; calls++) {
        fail_next(calls, calls, &r);
        result = nrd_vk_memory_needs(&desc, needs);
        if (result != NRD_RESULT_OK) assert_device_error(result, &r);
        assert_int_equal(spy.live, 0);
    }
    assert_true(calls > 5);
    reset_spy();
    nrd_destroy(r.instance);
}

static void a_function_that_the_device_does_not_know_is_named(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REFERENCE;
    rig r;
    (void)state;
    memset(&r, 0, sizeof r);
    assert_int_equal(create_instance(&r, &denoiser, 1, 16, 16, 0), NRD_RESULT_OK);
    nrd_vk_desc desc = vk_desc(&r);
    desc.flags = NRD_VK_TIMESTAMPS;
    reset_spy();
    spy.fake = true;
    uint32_t known = 0;
    for (spy.unknown = 1; nrd_vk_create(&desc, &r.vk) != NRD_RESULT_OK; spy.unknown++, spy.asked = 0) {
        assert_int_equal(r.last_result, NRD_RESULT_INVALID_ARGUMENT);
        assert_non_null(strstr(r.last_text, "get_device_proc does not know vk"));
        assert_null(r.vk);
        assert_int_equal(spy.live, 0);
        known++;
    }
    assert_true(known > 30);
    nrd_vk_destroy(r.vk);
    reset_spy();
    nrd_destroy(r.instance);
}

/* What a device that is lost while frames are in flight says of them; history and the next frames are the application's to give up. */
static void a_lost_device_shows_in_the_timings(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    nrd_vk_timing timings[32];
    uint32_t count;
    rig r;
    (void)state;
    open_rig(&r, &denoiser, 1, 16, 16, 0);
    run_frames(&r, 2);
    for (uint32_t way = 0; way < 3; way++) {
        fail_next(2, way, &r);
        assert_device_error(nrd_vk_timings(r.vk, 0, timings, 32, &count), &r);
        assert_int_equal(count, 2);
    }
    reset_spy();
    assert_int_equal(nrd_vk_timings(r.vk, 0, timings, 32, &count), NRD_RESULT_OK);
    close_rig(&r);
}

/* An allocator for host and device memory that fails at a given call. */
typedef struct budget { uint32_t calls, fail_at, kinds; int32_t live; } budget;

static void *budget_allocate(void *user, size_t bytes)
{
    budget *b = (budget *)user;
    if (b->calls++ == b->fail_at) return NULL;
    b->live++;
    return malloc(bytes);
}

static void budget_release(void *user, void *memory)
{
    ((budget *)user)->live--;
    free(memory);
}

static VkResult budget_allocate_memory(void *user, nrd_vk_memory_kind kind, const VkMemoryRequirements *needs, nrd_vk_memory *out)
{
    budget *b = (budget *)user;
    if (b->calls++ == b->fail_at) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    VkMemoryAllocateInfo info = { VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, NULL, needs->size + 2 * needs->alignment, 0 };
    const VkMemoryPropertyFlags wanted = kind == NRD_VK_MEMORY_CONSTANTS ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT : 0;
    while (!(needs->memoryTypeBits >> info.memoryTypeIndex & 1) || (device.memory.memoryTypes[info.memoryTypeIndex].propertyFlags & wanted) != wanted) info.memoryTypeIndex++;
    VkResult result = device.fn.vkAllocateMemory(device.device, &info, NULL, &out->memory);
    if (result != VK_SUCCESS) return result;
    b->kinds |= 1u << kind;
    b->live++;
    out->offset = 2 * needs->alignment;
    if (wanted && device.fn.vkMapMemory(device.device, out->memory, out->offset, VK_WHOLE_SIZE, 0, &out->mapped) != VK_SUCCESS) abort();
    return VK_SUCCESS;
}

static void budget_free_memory(void *user, nrd_vk_memory_kind kind, const nrd_vk_memory *memory)
{
    (void)kind;
    ((budget *)user)->live--;
    device.fn.vkFreeMemory(device.device, memory->memory, NULL);
}

static void every_failing_callback_of_the_app_is_reported_and_leaks_nothing(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    budget b = { 0, 0, 0, 0 };
    nrd_result result;
    rig r;
    (void)state;
    uint32_t before = gpu_message_count(&device);
    reset_spy();
    memset(&r, 0, sizeof r);
    assert_int_equal(create_instance(&r, &denoiser, 1, 32, 32, 0), NRD_RESULT_OK);
    nrd_vk_desc desc = vk_desc(&r);
    desc.allocate = budget_allocate, desc.release = budget_release, desc.allocate_user = &b;
    desc.allocate_memory = budget_allocate_memory, desc.free_memory = budget_free_memory, desc.memory_user = &b;
    while ((result = nrd_vk_create(&desc, &r.vk)) != NRD_RESULT_OK) {
        assert_int_equal(result, b.fail_at == 0 ? NRD_RESULT_OUT_OF_MEMORY : NRD_RESULT_DEVICE_ERROR);
        assert_null(r.vk);
        assert_int_equal(b.live, 0);
        assert_int_equal(spy.live, 0);
        b.calls = b.kinds = 0;
        b.fail_at++;
    }
    assert_int_equal(b.calls, 4); /* one host block, one of each kind of device memory */
    assert_int_equal(b.kinds, 7);
    create_images(&r);
    create_commands(&r);
    run_frames(&r, 4);
    assert_int_equal(b.calls, 4);
    for (b.fail_at = 4; (result = nrd_vk_resize(r.vk, 64, 48)) != NRD_RESULT_OK; b.fail_at++) {
        assert_int_equal(result, b.fail_at == 4 ? NRD_RESULT_OUT_OF_MEMORY : NRD_RESULT_DEVICE_ERROR);
        assert_int_equal(b.live, 4);
        b.calls = 4;
    }
    assert_int_equal(b.calls, 7);
    assert_int_equal(b.live, 7);
    close_rig(&r);
    assert_int_equal(b.live, 0);
    assert_no_messages(before);
}

/* Vulkan's own host allocations; the size is kept in front of each block for reallocation. */
static void *VKAPI_CALL count_allocation(void *user, size_t size, size_t alignment, VkSystemAllocationScope scope)
{
    (void)scope;
    assert_true(alignment <= 64);
    void *block = NULL;
    if (posix_memalign(&block, 64, size + 64) != 0) return NULL;
    memcpy(block, &size, sizeof size);
    ((budget *)user)->live++;
    ((budget *)user)->calls++;
    return (char *)block + 64;
}

static void VKAPI_CALL count_free(void *user, void *memory)
{
    if (!memory) return;
    ((budget *)user)->live--;
    free((char *)memory - 64);
}

static void *VKAPI_CALL count_reallocation(void *user, void *old, size_t size, size_t alignment, VkSystemAllocationScope scope)
{
    size_t old_size = 0;
    void *block = size ? count_allocation(user, size, alignment, scope) : NULL;
    if (old) memcpy(&old_size, (char *)old - 64, sizeof old_size);
    if (old && block) memcpy(block, old, old_size < size ? old_size : size);
    if (block || !size) count_free(user, old);
    return block;
}

static void allocation_callbacks_of_the_app_get_everything_back(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    budget b = { 0, UINT32_MAX, 0, 0 };
    VkAllocationCallbacks callbacks = { &b, count_allocation, count_reallocation, count_free, NULL, NULL };
    rig r;
    (void)state;
    memset(&r, 0, sizeof r);
    assert_int_equal(create_instance(&r, &denoiser, 1, 16, 16, 0), NRD_RESULT_OK);
    nrd_vk_desc desc = vk_desc(&r);
    desc.callbacks = &callbacks;
    desc.frames_in_flight = 3;
    assert_int_equal(nrd_vk_create(&desc, &r.vk), NRD_RESULT_OK);
    create_images(&r);
    create_commands(&r);
    run_frames(&r, 3);
    close_rig(&r);
    assert_int_equal(b.live, 0);
}

static void memory_is_what_nrd_h_announced_up_to_alignment(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    nrd_vk_needs needs;
    rig r;
    (void)state;
    open_rig(&r, &denoiser, 1, 256, 256, 0);
    assert_int_equal(nrd_vk_requirements(r.instance, &needs), NRD_RESULT_OK);
    uint64_t permanent = nrd_vk_memory_bytes(r.vk, NRD_VK_MEMORY_PERMANENT), transient = nrd_vk_memory_bytes(r.vk, NRD_VK_MEMORY_TRANSIENT);
    assert_true(permanent >= needs.permanent_bytes && permanent < needs.permanent_bytes * 5 / 4);
    assert_true(transient >= needs.transient_bytes && transient <= needs.transient_bytes * 5 / 4 + 65536);
    close_rig(&r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Misuse  >>misuse */
static void a_device_without_storage_formats_or_vulkan_1_1_is_refused(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    rig r;
    (void)state;
    memset(&r, 0, sizeof r);
    assert_int_equal(create_instance(&r, &denoiser, 1, 16, 16, 0), NRD_RESULT_OK);
    nrd_vk_desc desc = vk_desc(&r);
    reset_spy();
    spy.no_storage = true;
    assert_int_equal(nrd_vk_create(&desc, &r.vk), NRD_RESULT_UNSUPPORTED_DEVICE);
    assert_non_null(strstr(r.last_text, "VkFormat is "));
    assert_int_equal(nrd_vk_check_device(r.instance, device.instance, device.physical, spy_get_instance_proc), NRD_RESULT_UNSUPPORTED_DEVICE);
    reset_spy();
    spy.api_version = VK_API_VERSION_1_0;
    assert_int_equal(nrd_vk_create(&desc, &r.vk), NRD_RESULT_UNSUPPORTED_DEVICE);
    assert_non_null(strstr(r.last_text, "needed is 1.1"));
    assert_null(r.vk);
    assert_int_equal(spy.calls, 0);
    reset_spy();
    assert_int_equal(nrd_vk_check_device(r.instance, device.instance, device.physical, spy_get_instance_proc), NRD_RESULT_OK);
    nrd_destroy(r.instance);
}

static void a_wrong_creation_desc_is_refused_by_field(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REFERENCE;
    nrd_vk_desc good, bad;
    rig r;
    (void)state;
    memset(&r, 0, sizeof r);
    nrd_vk_destroy(NULL);
    assert_int_equal(nrd_vk_create(NULL, &r.vk), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(create_instance(&r, &denoiser, 1, 16, 16, 0), NRD_RESULT_OK);
    good = vk_desc(&r);
#define REFUSED(change, text) do { \
        bad = good; \
        bad.change; \
        r.last_text[0] = 0; \
        assert_int_equal(nrd_vk_create(&bad, &r.vk), NRD_RESULT_INVALID_ARGUMENT); \
        assert_non_null(strstr(r.last_text, text)); \
    } while (0)
    REFUSED(vk_instance = NULL, "vk_instance is NULL");
    REFUSED(physical = NULL, "physical is NULL");
    REFUSED(device = NULL, "device is NULL");
    REFUSED(get_instance_proc = NULL, "get_instance_proc is NULL");
    REFUSED(frames_in_flight = 17, "frames_in_flight is 17, allowed is 0 to 16");
    REFUSED(allocate = budget_allocate, "allocate and release");
    REFUSED(free_memory = budget_free_memory, "allocate_memory and free_memory");
    assert_int_equal(nrd_vk_create(&good, NULL), NRD_RESULT_INVALID_ARGUMENT);
    nrd_destroy(r.instance);
}

/* Records into a command buffer that is thrown away; the list of images may be changed before. */
typedef struct attempt { nrd_vk_image list[NRD_RESOURCE_COUNT]; nrd_vk_frame frame; } attempt;

static void prepare(rig *r, attempt *a)
{
    memset(a, 0, sizeof *a);
    r->frame++;
    r->last_text[0] = 0;
    set_frame(r);
    a->frame.images = a->list;
    a->frame.image_count = list_images(r, a->list, true);
}

static nrd_vk_image *find(attempt *a, nrd_resource resource)
{
    uint32_t i = 0;
    while (a->list[i].resource != resource) i++;
    return &a->list[i];
}

static void refuse(rig *r, attempt *a, nrd_result result, const char *text)
{
    reset_spy();
    assert_int_equal(nrd_vk_record(r->vk, r->cmds[0], &a->frame), result);
    if (!strstr(r->last_text, text)) fail_msg("message is \"%s\", expected \"%s\"", r->last_text, text);
    assert_int_equal(spy.logged, 0);
}

static void a_missing_or_mismatched_image_is_named_and_nothing_is_recorded(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    attempt a;
    rig r;
    (void)state;
    uint32_t before = gpu_message_count(&device);
    open_rig(&r, &denoiser, 1, 24, 16, 0);
    begin_slot(&r, 0);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (!r.images[i].view) continue;
        prepare(&r, &a);
        *find(&a, (nrd_resource)i) = a.list[--a.frame.image_count];
        char text[64];
        snprintf(text, sizeof text, "%s is needed by pass", nrd_resource_name((nrd_resource)i));
        refuse(&r, &a, NRD_RESULT_MISSING_RESOURCE, text);
    }
#define WRONG(target, change, text) do { \
        prepare(&r, &a); \
        find(&a, NRD_RESOURCE_##target)->change; \
        refuse(&r, &a, NRD_RESULT_INVALID_ARGUMENT, text); \
    } while (0)
    WRONG(IN_VIEWZ, width = 25, "IN_VIEWZ: width is 25, needed is 24");
    WRONG(IN_MV, height = 8, "IN_MV: height is 8, needed is 16");
    WRONG(IN_VIEWZ, format = VK_FORMAT_R32_UINT, "IN_VIEWZ: format is 98, needed is a float");
    WRONG(IN_VIEWZ, format = VK_FORMAT_D32_SFLOAT, "IN_VIEWZ: format is 126, needed is a float");
    WRONG(OUT_DIFF_RADIANCE_HITDIST, format = VK_FORMAT_R8G8B8A8_UNORM, "OUT_DIFF_RADIANCE_HITDIST: format is 37, needed is VkFormat 97");
    WRONG(IN_MV, image = VK_NULL_HANDLE, "IN_MV: image is VK_NULL_HANDLE");
    WRONG(IN_MV, view = VK_NULL_HANDLE, "IN_MV: view is VK_NULL_HANDLE");
    WRONG(IN_MV, layout_in = VK_IMAGE_LAYOUT_UNDEFINED, "IN_MV: layout_in is UNDEFINED");
    WRONG(IN_MV, image = r.images[NRD_RESOURCE_IN_VIEWZ].image, "twice");
    WRONG(IN_MV, resource = NRD_RESOURCE_COUNT, "nrd_vk_image.resource is ");
    prepare(&r, &a);
    a.frame.slot = 2;
    refuse(&r, &a, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_frame.slot is 2, allowed is 0 to 1");
    prepare(&r, &a);
    a.frame.images = NULL;
    refuse(&r, &a, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_frame.images is NULL");
    assert_int_equal(nrd_vk_record(r.vk, NULL, &a.frame), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_vk_record(r.vk, r.cmds[0], NULL), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_vk_record(NULL, r.cmds[0], &a.frame), NRD_RESULT_INVALID_ARGUMENT);
    submit_slot(&r, 0);
    r.frame = 1;
    run_frames(&r, 3);
    close_rig(&r);
    assert_no_messages(before);
}

static void a_frame_that_was_refused_can_be_recorded_again(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    attempt a;
    rig r;
    (void)state;
    open_rig(&r, &denoiser, 1, 40, 24, 0);
    run_frames(&r, 3);
    prepare(&r, &a);
    r.frame--;
    find(&a, NRD_RESOURCE_IN_MV)->width = 7;
    set_frame(&r);
    refuse(&r, &a, NRD_RESULT_INVALID_ARGUMENT, "IN_MV: width is 7");
    run_frames(&r, 3);
    assert_undisturbed(&r, denoiser);
    close_rig(&r);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Timings  >>timings */
static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void timings_name_every_pass_and_add_up_to_less_than_the_time_on_the_clock(void **state)
{
    nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    nrd_vk_timing timings[32];
    uint32_t count = 99, dispatches;
    double sum = 0;
    rig r;
    (void)state;
    open_rig(&r, &denoiser, 1, 160, 120, 0);
    assert_int_equal(nrd_vk_timings(r.vk, 0, timings, 32, &count), NRD_RESULT_OK);
    assert_int_equal(count, 0);
    run_frames(&r, 2);
    reset_spy();
    double begin = seconds();
    run_frames(&r, 1);
    double wall = (seconds() - begin) * 1e9;
    dispatches = 0;
    for (uint32_t i = 0; i < spy.logged; i++) dispatches += spy.log[i] == 'D';
    assert_int_equal(nrd_vk_timings(r.vk, 0, timings, 32, &count), NRD_RESULT_OK);
    assert_int_equal(count, dispatches);
    for (uint32_t i = 0; i < count; i++) {
        assert_true(timings[i].nanoseconds > 0);
        assert_string_equal(timings[i].name, nrd_get_info(r.instance)->passes[timings[i].pass].name);
        sum += timings[i].nanoseconds;
    }
    assert_true(sum < wall);
    assert_int_equal(nrd_vk_timings(r.vk, 0, timings, 1, &count), NRD_RESULT_OK);
    assert_int_equal(count, 1);
    assert_int_equal(nrd_vk_timings(r.vk, 2, timings, 1, &count), NRD_RESULT_INVALID_ARGUMENT);
    close_rig(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_denoiser_runs_two_frames_in_flight_without_a_validation_message),
        cmocka_unit_test(optional_inputs_and_passes_run_without_a_validation_message),
        cmocka_unit_test(denoisers_of_one_instance_can_be_recorded_together_or_one_by_one),
        cmocka_unit_test(two_instances_on_one_device_do_not_disturb_each_other_and_repeat_bit_by_bit),
        cmocka_unit_test(the_denoiser_can_be_created_again_at_other_sizes),
        cmocka_unit_test(every_denoiser_changes_size_with_frames_in_flight_and_frees_the_former_images),
        cmocka_unit_test(a_resize_in_every_frame_keeps_no_more_than_the_frames_in_flight_need),
        cmocka_unit_test(denoisers_recorded_one_by_one_in_one_slot_all_read_the_former_images),
        cmocka_unit_test(a_resize_that_fails_or_is_taken_back_changes_nothing),
        cmocka_unit_test(the_core_alone_must_not_be_resized_under_a_runtime),
        cmocka_unit_test(nan_outside_the_rectangle_and_in_the_sky_has_no_effect),
        cmocka_unit_test(barriers_are_where_accesses_conflict_and_nowhere_else),
        cmocka_unit_test(recording_creates_and_allocates_nothing),
        cmocka_unit_test(every_failing_vulkan_call_of_creation_is_reported_and_leaks_nothing),
        cmocka_unit_test(every_failing_vulkan_call_of_measuring_memory_is_reported_and_leaks_nothing),
        cmocka_unit_test(a_function_that_the_device_does_not_know_is_named),
        cmocka_unit_test(a_lost_device_shows_in_the_timings),
        cmocka_unit_test(every_failing_callback_of_the_app_is_reported_and_leaks_nothing),
        cmocka_unit_test(allocation_callbacks_of_the_app_get_everything_back),
        cmocka_unit_test(memory_is_what_nrd_h_announced_up_to_alignment),
        cmocka_unit_test(a_device_without_storage_formats_or_vulkan_1_1_is_refused),
        cmocka_unit_test(a_wrong_creation_desc_is_refused_by_field),
        cmocka_unit_test(a_missing_or_mismatched_image_is_named_and_nothing_is_recorded),
        cmocka_unit_test(a_frame_that_was_refused_can_be_recorded_again),
        cmocka_unit_test(timings_name_every_pass_and_add_up_to_less_than_the_time_on_the_clock),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
