/* gpu.h - the Vulkan that the examples and tests stand on: one device, one compute queue, blocking transfers.

   The loader is opened with dlopen("libvulkan.so.1"), nothing is linked; only Vulkan 1.1 core is used and no
   device feature or extension is enabled but those that gpu_desc names. A `gpu` must not be moved in memory between gpu_open and gpu_close,
   and is used by one thread at a time.

   Functions that return bool return false on failure, write nothing to their out-parameters then, and leave a
   one-line reason in gpu_error(). Destroy functions accept zeroed objects and zero what they destroyed. */
#ifndef EXAMPLES_COMMON_GPU_H
#define EXAMPLES_COMMON_GPU_H

#ifndef VK_NO_PROTOTYPES
#define VK_NO_PROTOTYPES
#endif
#include <vulkan/vulkan.h>

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GPU_MAX_BINDINGS 32u
#define GPU_MAX_SPECIALIZATION 32u

#define GPU_INSTANCE_FUNCTIONS(X)                                                                                      \
    X(vkDestroyInstance)                                                                                               \
    X(vkEnumeratePhysicalDevices)                                                                                      \
    X(vkGetPhysicalDeviceProperties)                                                                                   \
    X(vkGetPhysicalDeviceMemoryProperties)                                                                             \
    X(vkGetPhysicalDeviceQueueFamilyProperties)                                                                        \
    X(vkGetPhysicalDeviceFormatProperties)                                                                             \
    X(vkCreateDevice)                                                                                                  \
    X(vkGetDeviceProcAddr)

#define GPU_DEVICE_FUNCTIONS(X)                                                                                        \
    X(vkDestroyDevice)                                                                                                 \
    X(vkGetDeviceQueue)                                                                                                \
    X(vkDeviceWaitIdle)                                                                                                \
    X(vkQueueSubmit)                                                                                                   \
    X(vkCreateFence)                                                                                                   \
    X(vkDestroyFence)                                                                                                  \
    X(vkResetFences)                                                                                                   \
    X(vkWaitForFences)                                                                                                 \
    X(vkCreateCommandPool)                                                                                             \
    X(vkDestroyCommandPool)                                                                                            \
    X(vkAllocateCommandBuffers)                                                                                        \
    X(vkFreeCommandBuffers)                                                                                            \
    X(vkResetCommandBuffer)                                                                                            \
    X(vkBeginCommandBuffer)                                                                                            \
    X(vkEndCommandBuffer)                                                                                              \
    X(vkCreateImage)                                                                                                   \
    X(vkDestroyImage)                                                                                                  \
    X(vkGetImageMemoryRequirements)                                                                                    \
    X(vkBindImageMemory)                                                                                               \
    X(vkCreateImageView)                                                                                               \
    X(vkDestroyImageView)                                                                                              \
    X(vkCreateSampler)                                                                                                 \
    X(vkDestroySampler)                                                                                                \
    X(vkCreateBuffer)                                                                                                  \
    X(vkDestroyBuffer)                                                                                                 \
    X(vkGetBufferMemoryRequirements)                                                                                   \
    X(vkBindBufferMemory)                                                                                              \
    X(vkAllocateMemory)                                                                                                \
    X(vkFreeMemory)                                                                                                    \
    X(vkMapMemory)                                                                                                     \
    X(vkCreateShaderModule)                                                                                            \
    X(vkDestroyShaderModule)                                                                                           \
    X(vkCreateDescriptorSetLayout)                                                                                     \
    X(vkDestroyDescriptorSetLayout)                                                                                    \
    X(vkCreateDescriptorPool)                                                                                          \
    X(vkDestroyDescriptorPool)                                                                                         \
    X(vkAllocateDescriptorSets)                                                                                        \
    X(vkUpdateDescriptorSets)                                                                                          \
    X(vkCreatePipelineLayout)                                                                                          \
    X(vkDestroyPipelineLayout)                                                                                         \
    X(vkCreatePipelineCache)                                                                                           \
    X(vkDestroyPipelineCache)                                                                                          \
    X(vkCreateComputePipelines)                                                                                        \
    X(vkDestroyPipeline)                                                                                               \
    X(vkCmdPipelineBarrier)                                                                                            \
    X(vkCmdCopyBuffer)                                                                                                 \
    X(vkCmdCopyBufferToImage)                                                                                          \
    X(vkCmdCopyImageToBuffer)                                                                                          \
    X(vkCmdBindPipeline)                                                                                               \
    X(vkCmdBindDescriptorSets)                                                                                         \
    X(vkCmdPushConstants)                                                                                              \
    X(vkCmdDispatch)                                                                                                   \
    X(vkCreateQueryPool)                                                                                               \
    X(vkDestroyQueryPool)                                                                                              \
    X(vkGetQueryPoolResults)                                                                                           \
    X(vkCmdResetQueryPool)                                                                                             \
    X(vkCmdWriteTimestamp)

/* Entry points of the opened instance and device, by their Vulkan names. */
typedef struct gpu_fn {
#define GPU_MEMBER(name) PFN_##name name;
    GPU_INSTANCE_FUNCTIONS(GPU_MEMBER)
    GPU_DEVICE_FUNCTIONS(GPU_MEMBER)
#undef GPU_MEMBER
} gpu_fn;

/* Zero is the first device without validation. */
typedef struct gpu_desc {
    int device_index;     /* position in vkEnumeratePhysicalDevices; 0 or negative: the first */
    bool validation;      /* Khronos validation layer; gpu_open fails where the layer is absent */
    bool sync_validation; /* implies validation; also checks hazards within and between submits */
    const char *const *extensions; /* of the device; gpu_open fails where one is absent */
    uint32_t extension_count;
    const void *features; /* becomes VkDeviceCreateInfo.pNext */
    struct gpu *shared;   /* an open one: its device and queue are used, and the members above ignored. It must outlive this one.
                             Each of those that share may be used by a thread of its own. Drivers keep some memory for every
                             device that was ever opened, so programs that work on many things open one */
} gpu_desc;

/* Host-visible, coherent, persistently mapped; or, with `mapped` NULL, of the device alone. */
typedef struct gpu_buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceSize size; /* bytes */
    void *mapped;
} gpu_buffer;

/* One mip level, one layer, always in VK_IMAGE_LAYOUT_GENERAL between calls. Usage is TRANSFER plus SAMPLED and
   STORAGE where the device supports the format for them. */
typedef struct gpu_image {
    VkImage image;
    VkImageView view;
    VkDeviceMemory memory;
    VkFormat format;
    uint32_t width, height; /* pixels */
    VkImageLayout layout;
} gpu_image;

typedef struct gpu {
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    uint32_t family; /* queue family of `queue`; has VK_QUEUE_COMPUTE_BIT */
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceMemoryProperties memory;
    PFN_vkGetInstanceProcAddr get_instance_proc;
    PFN_vkGetDeviceProcAddr get_device_proc;
    gpu_fn fn;
    VkCommandPool pool;
    VkCommandBuffer cmd; /* what gpu_begin returns */
    VkFence fence;
    VkQueryPool queries; /* begin and end of g->cmd; none on queues without timestamps */
    VkSampler nearest; /* clamp to edge, nearest, unnormalized = no */
    VkPipelineCache pipeline_cache; /* of the device, for all who share it */

    /* private */
    void *loader;
    struct gpu *owner;        /* whose device it is; NULL: its own */
    pthread_mutex_t submission; /* of the owner: a queue takes one submission at a time */
    VkDebugUtilsMessengerEXT messenger;
    PFN_vkSetDebugUtilsObjectNameEXT set_object_name;
    gpu_buffer staging;
    uint64_t tick_mask;
    uint64_t ticks; /* of the last submission */
    uint32_t message_count;
    uint32_t message_seen_count;
    uint32_t message_seen[64];
    char error[256];
} gpu;

/* True if a loader and the Khronos validation layer are installed. */
bool gpu_validation_available(void);

/* On failure writes the reason to `error` (at most error_size bytes, terminated) and leaves *g zeroed. */
bool gpu_open(gpu *g, const gpu_desc *desc, char *error, size_t error_size);

/* Waits for its device, unless it shares one. Everything created from g must have been destroyed before. Accepts a zeroed gpu. */
void gpu_close(gpu *g);

/* Why the last function that returned false did so; "" if none did. */
const char *gpu_error(const gpu *g);

/* Validation messages (warnings and errors) so far; each distinct text was printed to stderr once. */
uint32_t gpu_message_count(const gpu *g);

/* Bytes per texel of an uncompressed color format; 0 if unknown to this file. */
uint32_t gpu_format_size(VkFormat format);

/* Contents are undefined. `name` (may be NULL) is shown in validation messages. */
bool gpu_image_create(gpu *g, uint32_t width, uint32_t height, VkFormat format, const char *name, gpu_image *out);
void gpu_image_destroy(gpu *g, gpu_image *image);

/* Whole image, rows tightly packed, top row first; blocks until the copy is done. Not between gpu_begin and
   gpu_submit_and_wait. */
bool gpu_upload(gpu *g, gpu_image *image, const void *texels);
bool gpu_download(gpu *g, const gpu_image *image, void *texels);

bool gpu_buffer_create(gpu *g, VkDeviceSize size, VkBufferUsageFlags usage, gpu_buffer *out);
/* In the device's own memory, which the host does not see. */
bool gpu_buffer_create_local(gpu *g, VkDeviceSize size, VkBufferUsageFlags usage, gpu_buffer *out);
/* The first `size` bytes of such a buffer, whose usage must have TRANSFER_DST and TRANSFER_SRC; blocks as gpu_upload does. */
bool gpu_buffer_upload(gpu *g, gpu_buffer *buffer, const void *bytes, VkDeviceSize size);
bool gpu_buffer_download(gpu *g, const gpu_buffer *buffer, void *bytes, VkDeviceSize size);
void gpu_buffer_destroy(gpu *g, gpu_buffer *buffer);

/* Starts g->cmd afresh and makes all earlier submissions' writes visible to it. NULL on failure. */
VkCommandBuffer gpu_begin(gpu *g);

/* Ends g->cmd, makes its writes visible to the host, submits it and waits until the device has finished. */
bool gpu_submit_and_wait(gpu *g);

/* Device time of the last gpu_submit_and_wait, from the end of earlier work to the end of its own; 0 on queues without
   timestamps. */
double gpu_milliseconds(const gpu *g);

/* Full execution and memory dependency between what is recorded before and after. */
void gpu_barrier(gpu *g);

/* A compute pipeline with one descriptor set (set 0). Binding i has type types[i], one of STORAGE_IMAGE,
   COMBINED_IMAGE_SAMPLER (nearest, clamped), STORAGE_BUFFER, UNIFORM_BUFFER. */
typedef struct gpu_kernel_desc {
    const uint32_t *words; /* SPIR-V, entry point "main" */
    size_t size_bytes;     /* of words */
    const VkDescriptorType *types;
    uint32_t type_count;       /* 0..GPU_MAX_BINDINGS */
    uint32_t push_size;        /* bytes of push constants, multiple of 4; 0: none */
    const uint32_t *constants; /* specialization constants with ids 0, 1, ...; 32-bit patterns */
    uint32_t constant_count;   /* 0..GPU_MAX_SPECIALIZATION */
} gpu_kernel_desc;

typedef struct gpu_kernel {
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkDescriptorType types[GPU_MAX_BINDINGS];
    uint32_t type_count;
    uint32_t push_size;
} gpu_kernel;

bool gpu_kernel_create(gpu *g, const gpu_kernel_desc *desc, gpu_kernel *out);
void gpu_kernel_destroy(gpu *g, gpu_kernel *kernel);

/* A kernel has one set of bindings: all dispatches recorded between gpu_begin and gpu_submit_and_wait use the same
   ones, so bind only outside of that. Every binding the shader uses must be bound before the first dispatch. */
void gpu_kernel_bind_image(gpu *g, gpu_kernel *kernel, uint32_t binding, const gpu_image *image);
void gpu_kernel_bind_buffer(gpu *g, gpu_kernel *kernel, uint32_t binding, const gpu_buffer *buffer);

/* Records gx*gy*gz groups into g->cmd followed by a gpu_barrier. push_size must be the kernel's (push may be NULL
   if that is 0). */
void gpu_kernel_dispatch(gpu *g, gpu_kernel *kernel, const void *push, uint32_t push_size, uint32_t gx, uint32_t gy,
                         uint32_t gz);

#ifdef __cplusplus
}
#endif
#endif
