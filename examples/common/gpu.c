#define _DEFAULT_SOURCE
#include "common/gpu.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define VALIDATION_LAYER "VK_LAYER_KHRONOS_validation"

static bool fail(gpu *g, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(g->error, sizeof g->error, format, args);
    va_end(args);
    return false;
}

static bool check(gpu *g, VkResult result, const char *what)
{
    return result == VK_SUCCESS || fail(g, "%s failed with VkResult %d", what, (int)result);
}

const char *gpu_error(const gpu *g) { return g->error; }

uint32_t gpu_message_count(const gpu *g) { return g->owner ? g->owner->message_count : g->message_count; }

/* ---- opening -------------------------------------------------------------------------------------------------- */

static uint32_t hash_text(const char *text)
{
    uint32_t hash = 2166136261u; /* FNV-1a */
    for (; *text; ++text) hash = (hash ^ (unsigned char)*text) * 16777619u;
    return hash;
}

static bool message_is_new(gpu *g, const char *text)
{
    uint32_t hash = hash_text(text);
    for (uint32_t i = 0; i < g->message_seen_count; ++i)
        if (g->message_seen[i] == hash) return false;
    if (g->message_seen_count < sizeof g->message_seen / sizeof g->message_seen[0])
        g->message_seen[g->message_seen_count++] = hash;
    return true;
}

static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                 VkDebugUtilsMessageTypeFlagsEXT types,
                                                 const VkDebugUtilsMessengerCallbackDataEXT *data, void *user)
{
    gpu *g = (gpu *)user;
    (void)types;
    g->message_count++;
    if (message_is_new(g, data->pMessage))
        fprintf(stderr, "%s: %s\n",
                severity & VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT ? "validation error" : "validation warning",
                data->pMessage);
    return VK_FALSE;
}

static void *open_loader(PFN_vkGetInstanceProcAddr *get_proc)
{
    void *loader = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!loader) return NULL;
    void *symbol = dlsym(loader, "vkGetInstanceProcAddr");
    memcpy(get_proc, &symbol, sizeof symbol); /* ISO C has no cast from object to function pointer */
    if (symbol) return loader;
    dlclose(loader);
    return NULL;
}

/* The software driver stays mapped after the instance is gone, so that leak checkers can tell its memory from ours. */
static void keep_driver_mapped(void)
{
    void *driver = dlopen("libvulkan_lvp.so", RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
    if (driver) dlclose(driver);
}

static bool layer_is_listed(PFN_vkGetInstanceProcAddr get_proc)
{
    PFN_vkEnumerateInstanceLayerProperties enumerate =
        (PFN_vkEnumerateInstanceLayerProperties)get_proc(NULL, "vkEnumerateInstanceLayerProperties");
    uint32_t count = 0;
    if (!enumerate || enumerate(&count, NULL) != VK_SUCCESS || count == 0) return false;
    VkLayerProperties *layers = (VkLayerProperties *)malloc(count * sizeof *layers);
    bool found = false;
    if (layers && enumerate(&count, layers) >= VK_SUCCESS)
        for (uint32_t i = 0; i < count; ++i) found = found || strcmp(layers[i].layerName, VALIDATION_LAYER) == 0;
    free(layers);
    return found;
}

bool gpu_validation_available(void)
{
    PFN_vkGetInstanceProcAddr get_proc = NULL;
    void *loader = open_loader(&get_proc);
    bool found = loader && layer_is_listed(get_proc);
    if (loader) dlclose(loader);
    return found;
}

static bool create_messenger(gpu *g, const VkDebugUtilsMessengerCreateInfoEXT *info)
{
    PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)g->get_instance_proc(g->instance, "vkCreateDebugUtilsMessengerEXT");
    if (!create) return fail(g, "the validation layer has no VK_EXT_debug_utils");
    return check(g, create(g->instance, info, NULL, &g->messenger), "vkCreateDebugUtilsMessengerEXT");
}

static bool create_instance(gpu *g, bool validation, bool sync)
{
    static const char *const layers[] = {VALIDATION_LAYER};
    static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_1};
    VkValidationFeatureEnableEXT enable = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features = {VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, NULL, sync, &enable, 0, NULL};
    VkDebugUtilsMessengerCreateInfoEXT messenger = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity =
            VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = g,
    };
    VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = validation ? &features : NULL,
        .pApplicationInfo = &app,
        .enabledLayerCount = validation,
        .ppEnabledLayerNames = layers,
        .enabledExtensionCount = validation,
        .ppEnabledExtensionNames = extensions,
    };
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)g->get_instance_proc(NULL, "vkCreateInstance");
    if (!create) return fail(g, "libvulkan.so.1 has no vkCreateInstance");
    /* Hazards between submits are checked only when the layer finds this in the environment. */
    if (sync) setenv("VK_LAYER_ENABLES", "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT", 0);
    return check(g, create(&info, NULL, &g->instance), "vkCreateInstance") &&
           (!validation || create_messenger(g, &messenger));
}

static bool load_instance_functions(gpu *g)
{
#define GPU_LOAD(name)                                                                                                 \
    g->fn.name = (PFN_##name)g->get_instance_proc(g->instance, #name);                                                 \
    if (!g->fn.name) return fail(g, "the Vulkan loader has no " #name);
    GPU_INSTANCE_FUNCTIONS(GPU_LOAD)
#undef GPU_LOAD
    g->get_device_proc = g->fn.vkGetDeviceProcAddr;
    return true;
}

static bool load_device_functions(gpu *g)
{
#define GPU_LOAD(name)                                                                                                 \
    g->fn.name = (PFN_##name)g->get_device_proc(g->device, #name);                                                     \
    if (!g->fn.name) return fail(g, "the device has no " #name);
    GPU_DEVICE_FUNCTIONS(GPU_LOAD)
#undef GPU_LOAD
    return true;
}

static bool choose_device(gpu *g, int index)
{
    VkPhysicalDevice devices[16];
    uint32_t count = 16, wanted = index < 0 ? 0u : (uint32_t)index;
    VkResult result = g->fn.vkEnumeratePhysicalDevices(g->instance, &count, devices);
    if (result != VK_INCOMPLETE && !check(g, result, "vkEnumeratePhysicalDevices")) return false;
    if (count == 0) return fail(g, "no Vulkan device on this machine");
    if (wanted >= count) return fail(g, "device_index is %u, there are devices 0..%u", wanted, count - 1);
    g->physical = devices[wanted];
    g->fn.vkGetPhysicalDeviceProperties(g->physical, &g->properties);
    g->fn.vkGetPhysicalDeviceMemoryProperties(g->physical, &g->memory);
    return g->properties.apiVersion >= VK_API_VERSION_1_1 ||
           fail(g, "device %s has no Vulkan 1.1", g->properties.deviceName);
}

static bool choose_family(gpu *g)
{
    VkQueueFamilyProperties families[32];
    uint32_t count = 32;
    g->fn.vkGetPhysicalDeviceQueueFamilyProperties(g->physical, &count, families);
    for (g->family = 0; g->family < count; ++g->family)
        if (families[g->family].queueFlags & VK_QUEUE_COMPUTE_BIT) return true;
    return fail(g, "device %s has no compute queue", g->properties.deviceName);
}

static bool create_device(gpu *g, const gpu_desc *desc)
{
    float priority = 1.0f;
    VkDeviceQueueCreateInfo queue = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, NULL, 0, g->family, 1, &priority};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = desc->features,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue,
                               .enabledExtensionCount = desc->extension_count,
                               .ppEnabledExtensionNames = desc->extensions};
    if (!check(g, g->fn.vkCreateDevice(g->physical, &info, NULL, &g->device), "vkCreateDevice")) return false;
    keep_driver_mapped();
    if (!load_device_functions(g)) return false;
    g->fn.vkGetDeviceQueue(g->device, g->family, 0, &g->queue);
    if (g->messenger)
        g->set_object_name =
            (PFN_vkSetDebugUtilsObjectNameEXT)g->get_instance_proc(g->instance, "vkSetDebugUtilsObjectNameEXT");
    return true;
}

static bool create_common_objects(gpu *g)
{
    VkCommandPoolCreateInfo pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, NULL,
                                    VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT, g->family};
    VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, NULL, 0};
    VkSamplerCreateInfo sampler = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampler.addressModeU = sampler.addressModeV = sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    if (!check(g, g->fn.vkCreateCommandPool(g->device, &pool, NULL, &g->pool), "vkCreateCommandPool")) return false;
    VkCommandBufferAllocateInfo cmd = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, NULL, g->pool,
                                       VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    return check(g, g->fn.vkAllocateCommandBuffers(g->device, &cmd, &g->cmd), "vkAllocateCommandBuffers") &&
           check(g, g->fn.vkCreateFence(g->device, &fence, NULL, &g->fence), "vkCreateFence") &&
           check(g, g->fn.vkCreateSampler(g->device, &sampler, NULL, &g->nearest), "vkCreateSampler");
}

static bool create_pipeline_cache(gpu *g)
{
    VkPipelineCacheCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    VkResult result = g->fn.vkCreatePipelineCache(g->device, &info, NULL, &g->pipeline_cache);
    return check(g, result, "vkCreatePipelineCache");
}

static bool create_queries(gpu *g)
{
    VkQueueFamilyProperties families[32];
    uint32_t count = 32;
    VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    g->fn.vkGetPhysicalDeviceQueueFamilyProperties(g->physical, &count, families);
    uint32_t bits = g->family < count ? families[g->family].timestampValidBits : 0;
    if (bits == 0) return true;
    g->tick_mask = bits >= 64 ? UINT64_MAX : ((uint64_t)1 << bits) - 1;
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = 2;
    return check(g, g->fn.vkCreateQueryPool(g->device, &info, NULL, &g->queries), "vkCreateQueryPool");
}

static bool open_all(gpu *g, const gpu_desc *desc)
{
    bool validation = desc->validation || desc->sync_validation;
    g->loader = open_loader(&g->get_instance_proc);
    if (!g->loader) return fail(g, "cannot open the Vulkan loader libvulkan.so.1");
    if (validation && !layer_is_listed(g->get_instance_proc))
        return fail(g, "validation was asked for, but " VALIDATION_LAYER " is not installed");
    return create_instance(g, validation, desc->sync_validation) && load_instance_functions(g) &&
           choose_device(g, desc->device_index) && choose_family(g) && create_device(g, desc) && create_pipeline_cache(g) &&
           create_common_objects(g) && create_queries(g);
}

static bool open_shared(gpu *g, gpu *owner)
{
    while (owner->owner) owner = owner->owner;
    g->owner = owner;
    g->instance = owner->instance;
    g->physical = owner->physical;
    g->device = owner->device;
    g->queue = owner->queue;
    g->family = owner->family;
    g->properties = owner->properties;
    g->memory = owner->memory;
    g->get_instance_proc = owner->get_instance_proc;
    g->get_device_proc = owner->get_device_proc;
    g->fn = owner->fn;
    g->pipeline_cache = owner->pipeline_cache;
    g->set_object_name = owner->set_object_name;
    return create_common_objects(g) && create_queries(g);
}

bool gpu_open(gpu *g, const gpu_desc *desc, char *error, size_t error_size)
{
    memset(g, 0, sizeof *g);
    pthread_mutex_init(&g->submission, NULL);
    if (desc->shared ? open_shared(g, desc->shared) : open_all(g, desc)) return true;
    if (error && error_size) snprintf(error, error_size, "%s", g->error);
    gpu_close(g);
    return false;
}

static void destroy_common_objects(gpu *g)
{
    gpu_buffer_destroy(g, &g->staging);
    if (g->queries) g->fn.vkDestroyQueryPool(g->device, g->queries, NULL);
    if (g->nearest) g->fn.vkDestroySampler(g->device, g->nearest, NULL);
    if (g->fence) g->fn.vkDestroyFence(g->device, g->fence, NULL);
    if (g->pool) g->fn.vkDestroyCommandPool(g->device, g->pool, NULL);
}

static void close_device(gpu *g)
{
    if (!g->fn.vkDestroyDevice) /* the device's table was not complete */
        g->fn.vkDestroyDevice = (PFN_vkDestroyDevice)g->get_device_proc(g->device, "vkDestroyDevice");
    if (g->fn.vkDeviceWaitIdle) g->fn.vkDeviceWaitIdle(g->device);
    destroy_common_objects(g);
    if (g->pipeline_cache) g->fn.vkDestroyPipelineCache(g->device, g->pipeline_cache, NULL);
    if (g->fn.vkDestroyDevice) g->fn.vkDestroyDevice(g->device, NULL);
}

static void close_instance(gpu *g)
{
    PFN_vkDestroyInstance destroy = (PFN_vkDestroyInstance)g->get_instance_proc(g->instance, "vkDestroyInstance");
    if (g->messenger) {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy_messenger =
            (PFN_vkDestroyDebugUtilsMessengerEXT)g->get_instance_proc(g->instance, "vkDestroyDebugUtilsMessengerEXT");
        destroy_messenger(g->instance, g->messenger, NULL);
    }
    destroy(g->instance, NULL);
}

void gpu_close(gpu *g)
{
    if (g->owner) {
        destroy_common_objects(g); /* every submission has been waited for */
    } else {
        if (g->device) close_device(g);
        if (g->instance) close_instance(g);
        if (g->loader) dlclose(g->loader);
    }
    if (g->loader || g->owner) pthread_mutex_destroy(&g->submission);
    memset(g, 0, sizeof *g);
}

/* ---- command buffer ------------------------------------------------------------------------------------------- */

static void memory_barrier(gpu *g, VkPipelineStageFlags to, VkAccessFlags access)
{
    VkMemoryBarrier barrier = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, NULL, VK_ACCESS_MEMORY_WRITE_BIT, access};
    g->fn.vkCmdPipelineBarrier(g->cmd, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, to, 0, 1, &barrier, 0, NULL, 0, NULL);
}

void gpu_barrier(gpu *g)
{
    memory_barrier(g, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT);
}

static void write_timestamp(gpu *g, uint32_t query)
{
    if (g->queries) g->fn.vkCmdWriteTimestamp(g->cmd, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, g->queries, query);
}

static bool read_timestamps(gpu *g)
{
    uint64_t ticks[2];
    if (!g->queries) return true;
    VkResult result = g->fn.vkGetQueryPoolResults(g->device, g->queries, 0, 2, sizeof ticks, ticks, sizeof ticks[0],
                                                  VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    g->ticks = (ticks[1] - ticks[0]) & g->tick_mask;
    return check(g, result, "vkGetQueryPoolResults");
}

double gpu_milliseconds(const gpu *g)
{
    return (double)g->ticks * g->properties.limits.timestampPeriod * 1e-6;
}

VkCommandBuffer gpu_begin(gpu *g)
{
    VkCommandBufferBeginInfo info = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, NULL,
                                     VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, NULL};
    if (!check(g, g->fn.vkResetCommandBuffer(g->cmd, 0), "vkResetCommandBuffer")) return NULL;
    if (!check(g, g->fn.vkBeginCommandBuffer(g->cmd, &info), "vkBeginCommandBuffer")) return NULL;
    if (g->queries) g->fn.vkCmdResetQueryPool(g->cmd, g->queries, 0, 2);
    gpu_barrier(g);
    write_timestamp(g, 0);
    return g->cmd;
}

static VkResult submit_alone(gpu *g)
{
    VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO, NULL, 0, NULL, NULL, 1, &g->cmd, 0, NULL};
    pthread_mutex_t *submission = g->owner ? &g->owner->submission : &g->submission;
    pthread_mutex_lock(submission);
    VkResult result = g->fn.vkQueueSubmit(g->queue, 1, &submit, g->fence);
    pthread_mutex_unlock(submission);
    return result;
}

bool gpu_submit_and_wait(gpu *g)
{
    write_timestamp(g, 1);
    memory_barrier(g, VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
    return check(g, g->fn.vkEndCommandBuffer(g->cmd), "vkEndCommandBuffer") &&
           check(g, g->fn.vkResetFences(g->device, 1, &g->fence), "vkResetFences") &&
           check(g, submit_alone(g), "vkQueueSubmit") &&
           check(g, g->fn.vkWaitForFences(g->device, 1, &g->fence, VK_TRUE, UINT64_MAX), "vkWaitForFences") &&
           read_timestamps(g);
}

/* ---- buffers and images --------------------------------------------------------------------------------------- */

/* The first memory type that the resource may have and that has all of the flags; -1: none. */
static int find_memory_type(const gpu *g, uint32_t allowed, VkMemoryPropertyFlags flags)
{
    for (uint32_t i = 0; i < g->memory.memoryTypeCount; ++i)
        if ((allowed >> i & 1u) && (g->memory.memoryTypes[i].propertyFlags & flags) == flags) return (int)i;
    return -1;
}

static bool allocate(gpu *g, const VkMemoryRequirements *need, VkMemoryPropertyFlags flags, VkDeviceMemory *out)
{
    /* what the host reads without a cache, it reads a hundred times more slowly */
    VkMemoryPropertyFlags better = flags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT ? flags | VK_MEMORY_PROPERTY_HOST_CACHED_BIT : flags;
    int type = find_memory_type(g, need->memoryTypeBits, better);
    if (type < 0) type = find_memory_type(g, need->memoryTypeBits, flags);
    if (type < 0) return fail(g, "no memory type with property flags 0x%x", (unsigned)flags);
    VkMemoryAllocateInfo info = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, NULL, need->size, (uint32_t)type};
    VkResult result = g->fn.vkAllocateMemory(g->device, &info, NULL, out);
    return result == VK_SUCCESS ||
           fail(g, "vkAllocateMemory of %llu bytes failed with VkResult %d", (unsigned long long)need->size, (int)result);
}

static bool fill_buffer_object(gpu *g, VkBufferUsageFlags usage, VkMemoryPropertyFlags memory, gpu_buffer *b)
{
    VkBufferCreateInfo info = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, NULL, 0, b->size, usage,
                               VK_SHARING_MODE_EXCLUSIVE, 0, NULL};
    VkMemoryRequirements need;
    if (!check(g, g->fn.vkCreateBuffer(g->device, &info, NULL, &b->buffer), "vkCreateBuffer")) return false;
    g->fn.vkGetBufferMemoryRequirements(g->device, b->buffer, &need);
    if (!allocate(g, &need, memory, &b->memory) ||
        !check(g, g->fn.vkBindBufferMemory(g->device, b->buffer, b->memory, 0), "vkBindBufferMemory"))
        return false;
    return !(memory & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) ||
           check(g, g->fn.vkMapMemory(g->device, b->memory, 0, VK_WHOLE_SIZE, 0, &b->mapped), "vkMapMemory");
}

static bool create_buffer(gpu *g, VkDeviceSize size, VkBufferUsageFlags usage, VkMemoryPropertyFlags memory,
                          gpu_buffer *out)
{
    gpu_buffer b = {VK_NULL_HANDLE, VK_NULL_HANDLE, size, NULL};
    if (size == 0) return fail(g, "buffer size is 0");
    if (!fill_buffer_object(g, usage, memory, &b)) {
        gpu_buffer_destroy(g, &b);
        return false;
    }
    *out = b;
    return true;
}

bool gpu_buffer_create(gpu *g, VkDeviceSize size, VkBufferUsageFlags usage, gpu_buffer *out)
{
    return create_buffer(g, size, usage, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, out);
}

bool gpu_buffer_create_local(gpu *g, VkDeviceSize size, VkBufferUsageFlags usage, gpu_buffer *out)
{
    return create_buffer(g, size, usage, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, out);
}

void gpu_buffer_destroy(gpu *g, gpu_buffer *buffer)
{
    if (buffer->buffer) g->fn.vkDestroyBuffer(g->device, buffer->buffer, NULL);
    if (buffer->memory) g->fn.vkFreeMemory(g->device, buffer->memory, NULL);
    memset(buffer, 0, sizeof *buffer);
}

uint32_t gpu_format_size(VkFormat format)
{
    switch (format) {
    case VK_FORMAT_R8_UNORM: case VK_FORMAT_R8_SNORM: case VK_FORMAT_R8_UINT: case VK_FORMAT_R8_SINT:
        return 1;
    case VK_FORMAT_R8G8_UNORM: case VK_FORMAT_R8G8_SNORM: case VK_FORMAT_R8G8_UINT: case VK_FORMAT_R8G8_SINT:
    case VK_FORMAT_R16_UNORM: case VK_FORMAT_R16_SNORM: case VK_FORMAT_R16_UINT: case VK_FORMAT_R16_SINT:
    case VK_FORMAT_R16_SFLOAT:
        return 2;
    case VK_FORMAT_R8G8B8A8_UNORM: case VK_FORMAT_R8G8B8A8_SNORM: case VK_FORMAT_R8G8B8A8_UINT:
    case VK_FORMAT_R8G8B8A8_SINT: case VK_FORMAT_R8G8B8A8_SRGB: case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
    case VK_FORMAT_A2B10G10R10_UINT_PACK32: case VK_FORMAT_A2R10G10B10_UNORM_PACK32:
    case VK_FORMAT_B10G11R11_UFLOAT_PACK32: case VK_FORMAT_E5B9G9R9_UFLOAT_PACK32:
    case VK_FORMAT_R16G16_UNORM: case VK_FORMAT_R16G16_SNORM: case VK_FORMAT_R16G16_UINT:
    case VK_FORMAT_R16G16_SINT: case VK_FORMAT_R16G16_SFLOAT:
    case VK_FORMAT_R32_UINT: case VK_FORMAT_R32_SINT: case VK_FORMAT_R32_SFLOAT:
        return 4;
    case VK_FORMAT_R16G16B16A16_UNORM: case VK_FORMAT_R16G16B16A16_SNORM: case VK_FORMAT_R16G16B16A16_UINT:
    case VK_FORMAT_R16G16B16A16_SINT: case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R32G32_UINT: case VK_FORMAT_R32G32_SINT: case VK_FORMAT_R32G32_SFLOAT:
        return 8;
    case VK_FORMAT_R32G32B32A32_UINT: case VK_FORMAT_R32G32B32A32_SINT: case VK_FORMAT_R32G32B32A32_SFLOAT:
        return 16;
    default:
        return 0;
    }
}

static VkImageUsageFlags usage_of_format(gpu *g, VkFormat format)
{
    VkFormatProperties properties;
    VkImageUsageFlags usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    g->fn.vkGetPhysicalDeviceFormatProperties(g->physical, format, &properties);
    if (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT) usage |= VK_IMAGE_USAGE_SAMPLED_BIT;
    if (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT) usage |= VK_IMAGE_USAGE_STORAGE_BIT;
    return usage;
}

static bool create_image_object(gpu *g, gpu_image *i, VkImageUsageFlags usage)
{
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    VkMemoryRequirements need;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = i->format;
    info.extent.width = i->width, info.extent.height = i->height, info.extent.depth = 1;
    info.mipLevels = info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = usage;
    if (!check(g, g->fn.vkCreateImage(g->device, &info, NULL, &i->image), "vkCreateImage")) return false;
    g->fn.vkGetImageMemoryRequirements(g->device, i->image, &need);
    return allocate(g, &need, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, &i->memory) &&
           check(g, g->fn.vkBindImageMemory(g->device, i->image, i->memory, 0), "vkBindImageMemory");
}

static bool create_image_view(gpu *g, gpu_image *i)
{
    VkImageViewCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    info.image = i->image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = i->format;
    info.subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
    info.subresourceRange.levelCount = info.subresourceRange.layerCount = 1;
    return check(g, g->fn.vkCreateImageView(g->device, &info, NULL, &i->view), "vkCreateImageView");
}

static bool make_general(gpu *g, const gpu_image *i)
{
    VkImageMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    if (!gpu_begin(g)) return false;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = i->image;
    barrier.subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
    barrier.subresourceRange.levelCount = barrier.subresourceRange.layerCount = 1;
    g->fn.vkCmdPipelineBarrier(g->cmd, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0,
                               NULL, 0, NULL, 1, &barrier);
    return gpu_submit_and_wait(g);
}

static void name_image(gpu *g, const gpu_image *i, const char *name)
{
    VkDebugUtilsObjectNameInfoEXT info = {VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, NULL,
                                          VK_OBJECT_TYPE_IMAGE, 0, name};
    if (!name || !g->set_object_name) return;
    memcpy(&info.objectHandle, &i->image, sizeof i->image); /* a pointer or a 64-bit number, by platform */
    g->set_object_name(g->device, &info);
}

bool gpu_image_create(gpu *g, uint32_t width, uint32_t height, VkFormat format, const char *name, gpu_image *out)
{
    gpu_image i = {VK_NULL_HANDLE, VK_NULL_HANDLE, VK_NULL_HANDLE, format, width, height, VK_IMAGE_LAYOUT_GENERAL};
    uint32_t limit = g->properties.limits.maxImageDimension2D;
    VkImageUsageFlags usage = usage_of_format(g, format);
    if (width == 0 || height == 0 || width > limit || height > limit)
        return fail(g, "image %s: size is %ux%u, allowed is 1..%u", name ? name : "", width, height, limit);
    if (!(usage & VK_IMAGE_USAGE_SAMPLED_BIT) || gpu_format_size(format) == 0)
        return fail(g, "image %s: VkFormat %d is not supported", name ? name : "", (int)format);
    if (!create_image_object(g, &i, usage) || !create_image_view(g, &i) || !make_general(g, &i)) {
        gpu_image_destroy(g, &i);
        return false;
    }
    name_image(g, &i, name);
    *out = i;
    return true;
}

void gpu_image_destroy(gpu *g, gpu_image *image)
{
    if (image->view) g->fn.vkDestroyImageView(g->device, image->view, NULL);
    if (image->image) g->fn.vkDestroyImage(g->device, image->image, NULL);
    if (image->memory) g->fn.vkFreeMemory(g->device, image->memory, NULL);
    memset(image, 0, sizeof *image);
}

/* ---- transfers ------------------------------------------------------------------------------------------------ */

static bool grow_staging(gpu *g, VkDeviceSize size)
{
    if (g->staging.size >= size) return true;
    gpu_buffer_destroy(g, &g->staging);
    return gpu_buffer_create(g, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                             &g->staging);
}

static size_t image_bytes(const gpu_image *image)
{
    return (size_t)image->width * image->height * gpu_format_size(image->format);
}

static VkBufferImageCopy whole_image(const gpu_image *image)
{
    VkBufferImageCopy copy = {0};
    copy.imageSubresource.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
    copy.imageSubresource.layerCount = 1;
    copy.imageExtent.width = image->width, copy.imageExtent.height = image->height, copy.imageExtent.depth = 1;
    return copy;
}

bool gpu_upload(gpu *g, gpu_image *image, const void *texels)
{
    VkBufferImageCopy copy = whole_image(image);
    if (!grow_staging(g, image_bytes(image))) return false;
    memcpy(g->staging.mapped, texels, image_bytes(image));
    if (!gpu_begin(g)) return false;
    g->fn.vkCmdCopyBufferToImage(g->cmd, g->staging.buffer, image->image, image->layout, 1, &copy);
    return gpu_submit_and_wait(g);
}

bool gpu_download(gpu *g, const gpu_image *image, void *texels)
{
    VkBufferImageCopy copy = whole_image(image);
    if (!grow_staging(g, image_bytes(image)) || !gpu_begin(g)) return false;
    g->fn.vkCmdCopyImageToBuffer(g->cmd, image->image, image->layout, g->staging.buffer, 1, &copy);
    if (!gpu_submit_and_wait(g)) return false;
    memcpy(texels, g->staging.mapped, image_bytes(image));
    return true;
}

bool gpu_buffer_upload(gpu *g, gpu_buffer *buffer, const void *bytes, VkDeviceSize size)
{
    const VkBufferCopy all = {0, 0, size};
    if (size == 0) return true;
    if (!grow_staging(g, size)) return false;
    memcpy(g->staging.mapped, bytes, (size_t)size);
    if (!gpu_begin(g)) return false;
    g->fn.vkCmdCopyBuffer(g->cmd, g->staging.buffer, buffer->buffer, 1, &all);
    return gpu_submit_and_wait(g);
}

bool gpu_buffer_download(gpu *g, const gpu_buffer *buffer, void *bytes, VkDeviceSize size)
{
    const VkBufferCopy all = {0, 0, size};
    if (size == 0) return true;
    if (!grow_staging(g, size) || !gpu_begin(g)) return false;
    g->fn.vkCmdCopyBuffer(g->cmd, buffer->buffer, g->staging.buffer, 1, &all);
    if (!gpu_submit_and_wait(g)) return false;
    memcpy(bytes, g->staging.mapped, (size_t)size);
    return true;
}

/* ---- kernels -------------------------------------------------------------------------------------------------- */

static bool create_set_layout(gpu *g, gpu_kernel *k)
{
    VkDescriptorSetLayoutBinding bindings[GPU_MAX_BINDINGS];
    VkDescriptorSetLayoutCreateInfo info = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, NULL, 0,
                                            k->type_count, bindings};
    memset(bindings, 0, sizeof bindings);
    for (uint32_t i = 0; i < k->type_count; ++i) {
        bindings[i].binding = i;
        bindings[i].descriptorType = k->types[i];
        bindings[i].descriptorCount = 1;
        bindings[i].stageFlags = VK_SHADER_STAGE_COMPUTE_BIT;
    }
    return check(g, g->fn.vkCreateDescriptorSetLayout(g->device, &info, NULL, &k->set_layout),
                 "vkCreateDescriptorSetLayout");
}

static bool create_set(gpu *g, gpu_kernel *k)
{
    VkDescriptorPoolSize sizes[GPU_MAX_BINDINGS];
    VkDescriptorPoolCreateInfo info = {VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, NULL, 0, 1, k->type_count, sizes};
    if (k->type_count == 0) return true;
    for (uint32_t i = 0; i < k->type_count; ++i) sizes[i].type = k->types[i], sizes[i].descriptorCount = 1;
    if (!check(g, g->fn.vkCreateDescriptorPool(g->device, &info, NULL, &k->pool), "vkCreateDescriptorPool"))
        return false;
    VkDescriptorSetAllocateInfo set = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, NULL, k->pool, 1,
                                       &k->set_layout};
    return check(g, g->fn.vkAllocateDescriptorSets(g->device, &set, &k->set), "vkAllocateDescriptorSets");
}

static bool create_pipeline_layout(gpu *g, gpu_kernel *k)
{
    VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, k->push_size};
    VkPipelineLayoutCreateInfo info = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, NULL, 0, 1, &k->set_layout,
                                       k->push_size ? 1u : 0u, &range};
    return check(g, g->fn.vkCreatePipelineLayout(g->device, &info, NULL, &k->layout), "vkCreatePipelineLayout");
}

static bool create_pipeline(gpu *g, const gpu_kernel_desc *desc, gpu_kernel *k)
{
    VkShaderModuleCreateInfo module_info = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, NULL, 0, desc->size_bytes,
                                            desc->words};
    VkSpecializationMapEntry entries[GPU_MAX_SPECIALIZATION];
    VkSpecializationInfo special = {desc->constant_count, entries, desc->constant_count * sizeof(uint32_t),
                                    desc->constants};
    VkComputePipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    for (uint32_t i = 0; i < desc->constant_count; ++i) {
        entries[i].constantID = i;
        entries[i].offset = i * (uint32_t)sizeof(uint32_t);
        entries[i].size = sizeof(uint32_t);
    }
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.pName = "main";
    info.stage.pSpecializationInfo = desc->constant_count ? &special : NULL;
    info.layout = k->layout;
    if (!check(g, g->fn.vkCreateShaderModule(g->device, &module_info, NULL, &info.stage.module),
               "vkCreateShaderModule"))
        return false;
    VkResult result = g->fn.vkCreateComputePipelines(g->device, g->pipeline_cache, 1, &info, NULL, &k->pipeline);
    g->fn.vkDestroyShaderModule(g->device, info.stage.module, NULL);
    return check(g, result, "vkCreateComputePipelines");
}

bool gpu_kernel_create(gpu *g, const gpu_kernel_desc *desc, gpu_kernel *out)
{
    gpu_kernel k;
    memset(&k, 0, sizeof k);
    if (desc->type_count > GPU_MAX_BINDINGS)
        return fail(g, "type_count is %u, allowed is 0..%u", desc->type_count, GPU_MAX_BINDINGS);
    if (desc->constant_count > GPU_MAX_SPECIALIZATION)
        return fail(g, "constant_count is %u, allowed is 0..%u", desc->constant_count, GPU_MAX_SPECIALIZATION);
    k.type_count = desc->type_count;
    k.push_size = desc->push_size;
    for (uint32_t i = 0; i < k.type_count; ++i) k.types[i] = desc->types[i];
    if (!create_set_layout(g, &k) || !create_set(g, &k) || !create_pipeline_layout(g, &k) ||
        !create_pipeline(g, desc, &k)) {
        gpu_kernel_destroy(g, &k);
        return false;
    }
    *out = k;
    return true;
}

void gpu_kernel_destroy(gpu *g, gpu_kernel *kernel)
{
    if (kernel->pipeline) g->fn.vkDestroyPipeline(g->device, kernel->pipeline, NULL);
    if (kernel->layout) g->fn.vkDestroyPipelineLayout(g->device, kernel->layout, NULL);
    if (kernel->pool) g->fn.vkDestroyDescriptorPool(g->device, kernel->pool, NULL);
    if (kernel->set_layout) g->fn.vkDestroyDescriptorSetLayout(g->device, kernel->set_layout, NULL);
    memset(kernel, 0, sizeof *kernel);
}

static VkWriteDescriptorSet write_of_binding(const gpu_kernel *kernel, uint32_t binding)
{
    VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = kernel->set;
    write.dstBinding = binding;
    write.descriptorCount = 1;
    write.descriptorType = kernel->types[binding];
    return write;
}

void gpu_kernel_bind_image(gpu *g, gpu_kernel *kernel, uint32_t binding, const gpu_image *image)
{
    VkDescriptorImageInfo info = {g->nearest, image->view, image->layout};
    VkWriteDescriptorSet write = write_of_binding(kernel, binding);
    write.pImageInfo = &info;
    g->fn.vkUpdateDescriptorSets(g->device, 1, &write, 0, NULL);
}

void gpu_kernel_bind_buffer(gpu *g, gpu_kernel *kernel, uint32_t binding, const gpu_buffer *buffer)
{
    VkDescriptorBufferInfo info = {buffer->buffer, 0, VK_WHOLE_SIZE};
    VkWriteDescriptorSet write = write_of_binding(kernel, binding);
    write.pBufferInfo = &info;
    g->fn.vkUpdateDescriptorSets(g->device, 1, &write, 0, NULL);
}

void gpu_kernel_dispatch(gpu *g, gpu_kernel *kernel, const void *push, uint32_t push_size, uint32_t gx, uint32_t gy,
                         uint32_t gz)
{
    g->fn.vkCmdBindPipeline(g->cmd, VK_PIPELINE_BIND_POINT_COMPUTE, kernel->pipeline);
    if (kernel->set)
        g->fn.vkCmdBindDescriptorSets(g->cmd, VK_PIPELINE_BIND_POINT_COMPUTE, kernel->layout, 0, 1, &kernel->set, 0,
                                      NULL);
    if (push_size)
        g->fn.vkCmdPushConstants(g->cmd, kernel->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, push_size, push);
    g->fn.vkCmdDispatch(g->cmd, gx, gy, gz);
    gpu_barrier(g);
}
