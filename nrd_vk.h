/* nrd_vk.h - runs the denoisers of nrd.h on a VkDevice that the application owns.

   Do this in ONE C or C++ file, then include the header anywhere:
       #define NRD_IMPLEMENTATION
       #define NRD_VK_IMPLEMENTATION
       #include "nrd_vk.h"
   The implementation includes nrd_spirv.h, which comes with the distribution: the passes of all denoisers that are compiled in (NRD_ONLY_ and
   NRD_NO_ of nrd.h) as arrays. Vulkan is reached only through the function pointers in nrd_vk_desc: works with VK_NO_PROTOTYPES, volk or
   static linking, nothing is linked. A loader that demands VK_NO_PROTOTYPES before the first Vulkan header demands it here too.

   WHAT IT DOES NOT DO
   It creates no instance, device, queue or command buffer, submits nothing, waits for nothing, and copies no user image.

   STEP BY STEP (examples/minimal.c is a whole program)
   1. nrd_create (nrd.h); nrd_vk_requirements says what the device must have, nrd_vk_check_device whether it does, nrd_vk_memory_needs
      how many bytes of it nrd_vk_create will take.
   2. nrd_vk_create with instance, device and vkGetInstanceProcAddr. No device feature or extension needs to be enabled.
   3. Create the images that nrd_uses_resource() names: IN_ with VK_IMAGE_USAGE_SAMPLED_BIT, OUT_ with SAMPLED and STORAGE, in the
      format nrd_vk_format(nrd_resource_format(resource)).
   4. Every frame: nrd_set_frame, then nrd_vk_record into a command buffer that is in the recording state, outside of a
      render pass, for a queue with VK_QUEUE_COMPUTE_BIT.
   5. When the window gets another size: nrd_vk_resize. History is kept.
   6. When the device is done with everything recorded: nrd_vk_destroy, then nrd_destroy.
   For a slot that the device has finished: nrd_vk_timings (with NRD_VK_TIMESTAMPS) tells the time of each pass, nrd_vk_counters (with
   NRD_FEATURE_CHECK) what the input checker has counted.

   FRAMES IN FLIGHT
   nrd_vk_frame.slot counts 0 .. frames_in_flight - 1: whatever was recorded last with a slot must have finished on the device
   before the slot is recorded again (the app's fence for that frame says so). Command buffers must run in the order in which
   they were recorded, each exactly once, on one queue or on queues of one family that the app orders with semaphores.
   A slot may be recorded several times before that if the calls name different denoisers.

   SYNCHRONISATION
   nrd_vk_record begins with a dependency from everything before it in submission order (or from before_stages/before_access,
   which is cheaper) and ends with one to everything after it (or after_stages/after_access): no barrier by the app is needed
   around it. Between dispatches there is a barrier where one reads or overwrites what an earlier one wrote or read, and only
   there. User images arrive in layout_in and are left in layout_out. Images of the denoisers stay in VK_IMAGE_LAYOUT_GENERAL.

   COMMAND BUFFER
   Primary or secondary. nrd_vk_record calls vkCmdPipelineBarrier, vkCmdBindPipeline, vkCmdBindDescriptorSets, vkCmdPushConstants and
   vkCmdDispatch or vkCmdDispatchIndirect; in the first recording, and the first after a resize, vkCmdClearColorImage; with NRD_FEATURE_CHECK
   vkCmdCopyImageToBuffer into memory of its own; with NRD_VK_TIMESTAMPS vkCmdResetQueryPool and vkCmdWriteTimestamp on a pool of its own;
   with NRD_VK_DEBUG_NAMES labels that it closes again. It leaves changed: the compute pipeline, descriptor sets of the compute bind point,
   push constants, and the layouts of the images in the list. State of graphics and ray tracing stays.
   Ownership between queue families is not transferred: images that are not shared belong to the family of the command buffer before and
   after.

   MEMORY
   Host: one block, taken in nrd_vk_create, and a small one for each resize. Device: three blocks (history, scratch of one frame,
   constants), each one vkAllocateMemory or one call of the app's allocate_memory. Scratch images with disjoint lifetimes share memory;
   the app may lend that block to others between two nrd_vk_record. Recording allocates nothing. Descriptor sets come from a pool of its own,
   or from the app's nrd_vk_desc.descriptor_pool: all in one call, the last that can fail in nrd_vk_create. nrd_vk_destroy gives them back to
   the app's pool with NRD_VK_FREE_DESCRIPTOR_SETS, else they stay in it until the app resets or destroys it.

   ERRORS AND THREADS
   As in nrd.h: nrd_result, one line to nrd_desc.message, a call that fails records nothing and leaves no object behind. One
   nrd_vk is used by one thread at a time; several can share a device. Where the implementation is compiled apart from its callers, set
   nrd_vk_desc.struct_version to NRD_VK_STRUCT_VERSION.

   MIT licence, see LICENSE. */
#ifndef NRD_VK_H
#define NRD_VK_H

#include "nrd.h"
#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---------------------------------------------------------------------------------------------------------------------------
   What a device must have  >>requirements */
typedef struct nrd_vk_needs {
    uint32_t api_version;                           /* of the physical device */
    VkFormat formats[NRD_FORMAT_COUNT];             /* with optimal tiling these must have .. */
    VkFormatFeatureFlags features[NRD_FORMAT_COUNT]; /* .. these features */
    uint32_t format_count;
    uint32_t max_image_dimension_2d;                /* limits.maxImageDimension2D, and so on: */
    uint32_t max_uniform_buffer_range;
    uint32_t max_per_stage_sampled_images;          /* also samplers */
    uint32_t max_per_stage_storage_images;
    uint64_t permanent_bytes, transient_bytes;      /* device memory before the device's own alignment and padding */
    VkDescriptorPoolSize descriptors[5];            /* for each frame in flight a descriptor pool must have these left .. */
    uint32_t descriptor_type_count;                 /* .. as many of them as this tells .. */
    uint32_t descriptor_sets;                       /* .. and sets */
} nrd_vk_needs;

NRD_DECL nrd_result nrd_vk_requirements(const nrd *instance, nrd_vk_needs *out);

/* NRD_RESULT_UNSUPPORTED_DEVICE and a message that names the first thing that is lacking. */
NRD_DECL nrd_result nrd_vk_check_device(const nrd *instance, VkInstance vk_instance, VkPhysicalDevice physical, PFN_vkGetInstanceProcAddr get_instance_proc);

/* The Vulkan format of a storage format; VK_FORMAT_UNDEFINED for NRD_FORMAT_ANY. */
NRD_DECL VkFormat nrd_vk_format(nrd_format format);

/* ---------------------------------------------------------------------------------------------------------------------------
   Creation  >>create */
typedef struct nrd_vk nrd_vk;

typedef enum nrd_vk_memory_kind {
    NRD_VK_MEMORY_PERMANENT, /* device local, contents are kept from frame to frame */
    NRD_VK_MEMORY_TRANSIENT, /* device local, contents do not matter outside of nrd_vk_record */
    NRD_VK_MEMORY_CONSTANTS  /* host visible and coherent, a few kB */
} nrd_vk_memory_kind;

typedef struct nrd_vk_memory {
    VkDeviceMemory memory;
    VkDeviceSize offset; /* bytes, a multiple of the asked alignment */
    void *mapped;        /* NRD_VK_MEMORY_CONSTANTS: the host address of memory + offset */
} nrd_vk_memory;

#define NRD_VK_TIMESTAMPS  1u /* nrd_vk_timings works */
#define NRD_VK_DEBUG_NAMES 2u /* object names and command labels; needs VK_EXT_debug_utils on the instance, silently absent otherwise */
#define NRD_VK_FREE_DESCRIPTOR_SETS 4u /* descriptor_pool was created with VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT: nrd_vk_destroy frees its sets */

typedef struct nrd_vk_desc {
    uint32_t struct_version;          /* NRD_VK_STRUCT_VERSION; 0: not checked. This and the one below keep their places in every release */
    nrd *instance;                    /* must outlive the nrd_vk */
    VkInstance vk_instance;
    VkPhysicalDevice physical;
    VkDevice device;
    PFN_vkGetInstanceProcAddr get_instance_proc;
    PFN_vkGetDeviceProcAddr get_device_proc; /* NULL: asked from get_instance_proc */
    VkPipelineCache pipeline_cache;   /* of the app: all pipelines are asked from it, in nrd_vk_create only; may be VK_NULL_HANDLE */
    uint32_t frames_in_flight;        /* 1 to 16; 0: 2 */
    uint32_t queue_family;            /* of the recorded command buffers; used with NRD_VK_TIMESTAMPS only */
    uint32_t flags;                   /* NRD_VK_ bits */
    /* Both or neither; NULL: vkAllocateMemory. At most one call per kind at creation and, but for CONSTANTS, at each resize; anything
       but VK_SUCCESS fails those. */
    VkResult (*allocate_memory)(void *user, nrd_vk_memory_kind kind, const VkMemoryRequirements *needs, nrd_vk_memory *out);
    void (*free_memory)(void *user, nrd_vk_memory_kind kind, const nrd_vk_memory *memory);
    void *memory_user;
    void *(*allocate)(void *user, size_t bytes); /* host memory, both or neither; NULL: NRD_MALLOC, NRD_FREE */
    void (*release)(void *user, void *memory);
    void *allocate_user;
    const VkAllocationCallbacks *callbacks; /* for every Vulkan object; copied; may be NULL */
    /* Of the app, with nrd_vk_needs.descriptors and descriptor_sets left in it, times frames_in_flight; VK_NULL_HANDLE: one of its own. Used in
       nrd_vk_create and nrd_vk_destroy only, by no other thread meanwhile; must outlive the nrd_vk, and not be reset before. */
    VkDescriptorPool descriptor_pool;
} nrd_vk_desc;

/* Differs where NRD_STRUCT_VERSION or the size of a public struct of this header does. */
#define NRD_VK_STRUCT_VERSION (NRD_STRUCT_VERSION ^ (uint32_t)(NRDI_MIX_SIZES(NRDI_MIX_SIZES(0, nrd_vk_desc, nrd_vk_image, nrd_vk_frame), nrd_vk_memory, nrd_vk_needs, nrd_vk_timing) & 0xffffu))

NRD_DECL nrd_result nrd_vk_create(const nrd_vk_desc *desc, nrd_vk **out);
NRD_DECL void nrd_vk_destroy(nrd_vk *vk); /* NULL is fine */

/* What nrd_vk_create would ask allocate_memory for, by nrd_vk_memory_kind, as this device sees it; size 0: nothing. Nothing is kept: images
   without memory are created and destroyed. An app that lends the transient block makes room for that much in its own. */
NRD_DECL nrd_result nrd_vk_memory_needs(const nrd_vk_desc *desc, VkMemoryRequirements needs[3]);

/* Bytes taken from the device, after alignment. */
NRD_DECL uint64_t nrd_vk_memory_bytes(const nrd_vk *vk, nrd_vk_memory_kind kind);

/* ---------------------------------------------------------------------------------------------------------------------------
   Recording  >>record */
typedef struct nrd_vk_image {
    nrd_resource resource;
    VkImage image;
    VkImageView view;         /* 2D, of the mip level and layer below only */
    VkFormat format;          /* of the view. IN_: any float or normalised colour format that can be sampled. OUT_: nrd_vk_format() */
    uint32_t width, height;   /* px of that mip level: nrd_desc.width x height (any size where nrd.h says so; half the width, rounded up, for a checkerboarded input) */
    VkImageLayout layout_in;  /* UNDEFINED: for OUT_ images whose contents do not matter */
    VkImageLayout layout_out; /* 0 (UNDEFINED): as layout_in; where that is UNDEFINED too, GENERAL */
    uint32_t mip, layer;
    VkImageUsageFlags usage;  /* with which the image was created; 0: not checked */
} nrd_vk_image;

typedef struct nrd_vk_frame {
    uint32_t slot;
    const nrd_vk_image *images; /* those that nothing needs this frame only get their layout changed */
    uint32_t image_count;
    const uint32_t *identifiers; /* denoisers to run; NULL and 0: all */
    uint32_t identifier_count;
    VkPipelineStageFlags before_stages; /* where the images were written or read before; 0: everywhere, with any access */
    VkAccessFlags before_access;
    VkPipelineStageFlags after_stages;  /* where they will be used next; 0: everywhere, with any access */
    VkAccessFlags after_access;
} nrd_vk_frame;

/* Records the dispatches of the frame that nrd_set_frame has described. Calls nrd_get_dispatches, so call it once per frame and
   denoiser. NRD_RESULT_MISSING_RESOURCE: a needed image is not in the list; the message names it. A call that fails changes nothing: the
   same frame can be recorded again. */
NRD_DECL nrd_result nrd_vk_record(nrd_vk *vk, VkCommandBuffer cmd, const nrd_vk_frame *frame);

/* ---------------------------------------------------------------------------------------------------------------------------
   Another size  >>size */
/* Gives the instance and its images other sizes, 1 to 16384 px; not nrd_resize as well. Settings and history are kept: the next frame
   reprojects from the images of the former size. Creates images and memory (one call per kind but CONSTANTS), no pipeline; waits for
   nothing. Frames in flight go on: the former images are destroyed by the nrd_vk_record that finds them no longer in use, by its slot, at
   the latest by nrd_vk_destroy. Until then their memory is taken too. Call it between two frames: nrd_set_frame comes after it. */
NRD_DECL nrd_result nrd_vk_resize(nrd_vk *vk, uint32_t width, uint32_t height);

/* ---------------------------------------------------------------------------------------------------------------------------
   Timings  >>timings */
typedef struct nrd_vk_timing {
    const char *name; /* of the pass */
    uint32_t pass;    /* index into nrd_info.passes */
    double nanoseconds; /* on the device, from the end of the previous command to the end of the pass */
} nrd_vk_timing;

/* The passes that were last recorded with this slot; ask when the device has finished them, before recording the slot again.
   Fills at most `capacity` entries (nrd_info.pass_count is always enough). *count is 0 while there are no results, without
   NRD_VK_TIMESTAMPS, and on queues that have no timestamps. */
NRD_DECL nrd_result nrd_vk_timings(const nrd_vk *vk, uint32_t slot, nrd_vk_timing *timings, uint32_t capacity, uint32_t *count);

/* ---------------------------------------------------------------------------------------------------------------------------
   Input checker  >>counters */
/* Adds what NRD_FEATURE_CHECK counted for this denoiser when it was last recorded with this slot to `counters` (NRD_COUNTER_COUNT of
   them; start with zeros), for nrd_check_rule. Ask when the device has finished, before recording the slot again. Adds nothing where the
   denoiser was not recorded with the slot, or has no check. */
NRD_DECL nrd_result nrd_vk_counters(const nrd_vk *vk, uint32_t slot, uint32_t identifier, uint64_t *counters);

#ifdef __cplusplus
}
#endif
#endif /* NRD_VK_H */

/* ===========================================================================================================================
   IMPLEMENTATION
   ======================================================================================================================== */
#ifdef NRD_VK_IMPLEMENTATION
#ifndef NRD_VK_IMPLEMENTED
#define NRD_VK_IMPLEMENTED

#include "nrd_spirv.h"
#include <string.h>

#if defined(NRD_MALLOC) != defined(NRD_FREE)
#error "define both NRD_MALLOC and NRD_FREE, or neither"
#endif
#ifndef NRD_MALLOC
#include <stdlib.h>
#define NRD_MALLOC(bytes) malloc(bytes)
#define NRD_FREE(memory) free(memory)
#endif

#define NRDI_VK_FUNCTIONS(X) \
    X(vkGetDeviceProcAddr) X(vkCreateImage) X(vkDestroyImage) X(vkGetImageMemoryRequirements) X(vkBindImageMemory) X(vkCreateImageView) \
    X(vkDestroyImageView) X(vkCreateBuffer) X(vkDestroyBuffer) X(vkGetBufferMemoryRequirements) X(vkBindBufferMemory) \
    X(vkAllocateMemory) X(vkFreeMemory) X(vkMapMemory) X(vkCreateSampler) X(vkDestroySampler) X(vkCreateDescriptorSetLayout) \
    X(vkDestroyDescriptorSetLayout) X(vkCreateDescriptorPool) X(vkDestroyDescriptorPool) X(vkAllocateDescriptorSets) \
    X(vkFreeDescriptorSets) X(vkUpdateDescriptorSets) X(vkCreatePipelineLayout) X(vkDestroyPipelineLayout) X(vkCreateShaderModule) \
    X(vkDestroyShaderModule) X(vkCreateComputePipelines) X(vkDestroyPipeline) X(vkCreateQueryPool) X(vkDestroyQueryPool) \
    X(vkGetQueryPoolResults) X(vkCmdResetQueryPool) X(vkCmdWriteTimestamp) X(vkCmdPipelineBarrier) X(vkCmdClearColorImage) X(vkCmdCopyImageToBuffer) \
    X(vkCmdBindPipeline) X(vkCmdBindDescriptorSets) X(vkCmdPushConstants) X(vkCmdDispatch) X(vkCmdDispatchIndirect)
#define NRDI_VK_PHYSICAL_FUNCTIONS(X) \
    X(vkGetPhysicalDeviceProperties) X(vkGetPhysicalDeviceFormatProperties) X(vkGetPhysicalDeviceMemoryProperties) \
    X(vkGetPhysicalDeviceQueueFamilyProperties)
#define NRDI_VK_MEMBER(name) PFN_##name name;

typedef struct nrdi_vk_physical {
    const nrd *instance; /* receives messages */
    VkPhysicalDevice device;
    NRDI_VK_PHYSICAL_FUNCTIONS(NRDI_VK_MEMBER)
} nrdi_vk_physical;

typedef struct nrdi_vk_functions { NRDI_VK_FUNCTIONS(NRDI_VK_MEMBER) } nrdi_vk_functions;

/* User images come first, by nrd_resource, then nrd_info.textures. Of user images everything is rewritten by each recording. Of
   nrd_texture.buffer only the accesses. */
typedef struct nrdi_vk_image {
    VkImage image;
    VkImageView view;
    VkImageLayout layout;     /* while dispatches run */
    VkImageLayout layout_out; /* user images */
    VkFormat format;          /* user images */
    uint32_t width, height, mip, layer;
    uint64_t read_at, written_at; /* value of nrd_vk.now at the last access of a kind; 0: none */
    bool present;             /* user images: given. Transient ones: already in use in this recording */
    bool transient;
} nrdi_vk_image;

typedef struct nrdi_vk_pipeline {
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline pipeline;
} nrdi_vk_pipeline;

/* One vkCmdPipelineBarrier in the making. */
typedef struct nrdi_vk_batch {
    VkPipelineStageFlags from, to;
    VkAccessFlags from_access, to_access; /* 0 and 0: execution only */
    uint32_t image_count;                 /* of nrd_vk.barriers */
} nrdi_vk_batch;

/* The images of a former size, from nrd_vk_resize until the device is done with them. */
typedef struct nrdi_vk_former {
    struct nrdi_vk_former *next;
    nrdi_vk_image *images;    /* as many as nrd_info.textures */
    nrd_vk_memory memory[2];
    uint64_t memory_bytes[2];
    uint32_t width, height;
    uint32_t slot;            /* of the recording after which the device uses them no more .. */
    uint64_t denoisers;       /* .. and what was recorded with that slot since: a bit for each */
} nrdi_vk_former;

enum { NRDI_VK_ALIVE = 0x6e766b31, NRDI_VK_DEAD = 0x64656164 };

struct nrd_vk {
    uint32_t alive;          /* NRDI_VK_ALIVE */
    nrd_vk_desc desc;
    VkAllocationCallbacks callbacks;
    const VkAllocationCallbacks *use_callbacks;
    const nrd_info *info;
    nrdi_vk_physical physical;
    nrdi_vk_functions fn;
    PFN_vkSetDebugUtilsObjectNameEXT set_name;
    PFN_vkCmdBeginDebugUtilsLabelEXT begin_label;
    PFN_vkCmdEndDebugUtilsLabelEXT end_label;
    uint32_t slots, max_bindings;
    uint32_t texture_count, pipeline_count, set_count; /* of nrd_info, which may be gone when this is destroyed */
    uint32_t width, height;  /* for which the images were made */

    VkSampler samplers[2]; /* nearest, linear */
    VkDescriptorPool pool; /* unless the app has given one */
    VkBuffer constants;
    VkDeviceSize constant_stride;
    VkDeviceSize counters_at;  /* in the same buffer: slots x denoiser_count x NRD_COUNTER_COUNT, where there is a checker */
    VkDeviceSize groups_at;    /* in the same buffer: NRDI_VK_GROUPS_STRIDE for each nrd_texture.buffer */
    VkQueryPool queries;
    double tick_ns;
    uint64_t tick_mask;
    nrd_vk_memory memory[3];
    uint64_t memory_bytes[3];

    nrdi_vk_image *images;         /* NRD_RESOURCE_COUNT + texture_count */
    nrdi_vk_pipeline *pipelines;   /* pipeline_count */
    VkDescriptorSet *sets;         /* set_count: slots x pass_count */
    VkDescriptorSetLayout *set_layouts; /* of each */
    VkImageView *bound;            /* slots x pass_count x max_bindings: what the sets hold */
    bool *timed;                   /* slots x pass_count: has queries */
    bool *counted;                 /* slots x denoiser_count: has counters */
    VkImageMemoryBarrier *barriers; /* as many as images */
    nrd_block *blocks;             /* texture_count; placement of one memory kind */
    VkDescriptorSetLayoutBinding *layout_bindings; /* max_bindings + 1 */
    VkDescriptorImageInfo *image_infos;            /* max_bindings */
    VkWriteDescriptorSet *writes;                  /* max_bindings */

    VkFormat known_format[NRD_RESOURCE_COUNT]; /* of the user images seen last .. */
    VkFormatFeatureFlags known_features[NRD_RESOURCE_COUNT]; /* .. and what the device can do with it */
    bool cleared;            /* the first recording with these images has given the permanent ones their layout and contents */
    nrdi_vk_former *former;  /* of all former sizes: a list */
    nrdi_vk_former *last;    /* that of the last size before this one, where bindings with before_resize are; in the list, or NULL */
    uint64_t now;            /* dispatches recorded so far */
    uint64_t executed_at;    /* accesses at or before it are ordered before the next dispatch .. */
    uint64_t visible_at;     /* .. and writes at or before it are visible to it */
    nrdi_vk_batch batch;
};

#define NRDI_VK_STRUCT(type, name, s_type) type name; memset(&name, 0, sizeof name); name.sType = s_type

/* ---------------------------------------------------------------------------------------------------------------------------
   Messages  >>messages */
typedef struct nrdi_vk_text { char text[240]; uint32_t length; } nrdi_vk_text;

static nrdi_vk_text nrdi_vk_say(const char *s)
{
    nrdi_vk_text t;
    for (t.length = 0; s[t.length] && t.length < sizeof t.text - 1; t.length++) t.text[t.length] = s[t.length];
    t.text[t.length] = 0;
    return t;
}

static void nrdi_vk_add(nrdi_vk_text *t, const char *s)
{
    while (*s && t->length < sizeof t->text - 1) t->text[t->length++] = *s++;
    t->text[t->length] = 0;
}

static void nrdi_vk_add_number(nrdi_vk_text *t, int64_t value)
{
    char digits[24];
    uint32_t at = sizeof digits - 1;
    uint64_t rest = value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
    digits[at] = 0;
    do digits[--at] = (char)('0' + rest % 10); while (rest /= 10);
    if (value < 0) digits[--at] = '-';
    nrdi_vk_add(t, digits + at);
}

static nrd_result nrdi_vk_fail(const nrd *instance, nrd_result result, const char *text)
{
    return nrd_report(instance, NRD_SEVERITY_ERROR, result, text);
}

/* "<what> is <value>, <rule> <limit>" */
static nrd_result nrdi_vk_fail_value(const nrd *instance, nrd_result result, const char *what, int64_t value, const char *rule, int64_t limit)
{
    nrdi_vk_text t = nrdi_vk_say(what);
    nrdi_vk_add(&t, " is ");
    nrdi_vk_add_number(&t, value);
    nrdi_vk_add(&t, rule);
    nrdi_vk_add_number(&t, limit);
    return nrdi_vk_fail(instance, result, t.text);
}

static nrd_result nrdi_vk_fail_resource(const nrd *instance, nrd_result result, nrd_resource resource, const char *text)
{
    nrdi_vk_text t = nrdi_vk_say(nrd_resource_name(resource));
    nrdi_vk_add(&t, text);
    return nrdi_vk_fail(instance, result, t.text);
}

static nrd_result nrdi_vk_try(const nrd *instance, VkResult result, const char *call)
{
    if (result == VK_SUCCESS) return NRD_RESULT_OK;
    nrdi_vk_text t = nrdi_vk_say(call);
    nrdi_vk_add(&t, " failed with VkResult ");
    nrdi_vk_add_number(&t, result);
    return nrdi_vk_fail(instance, NRD_RESULT_DEVICE_ERROR, t.text);
}
/* Calls a vkCreate-like function of the device; returns from the caller on failure. */
#define NRDI_VK_CREATE(vk, name, info, out) do { \
        nrd_result nrdi_result = nrdi_vk_try((vk)->desc.instance, (vk)->fn.name((vk)->desc.device, info, (vk)->use_callbacks, out), #name); \
        if (nrdi_result != NRD_RESULT_OK) return nrdi_result; \
    } while (0)
#define NRDI_VK_DESTROY(vk, name, object) do { if (object) (vk)->fn.name((vk)->desc.device, object, (vk)->use_callbacks); } while (0)

/* ---------------------------------------------------------------------------------------------------------------------------
   What a device must have  >>requirements */
VkFormat nrd_vk_format(nrd_format format)
{
    switch (format) {
    case NRD_FORMAT_R8_UNORM: return VK_FORMAT_R8_UNORM;
    case NRD_FORMAT_RGBA8_UNORM: return VK_FORMAT_R8G8B8A8_UNORM;
    case NRD_FORMAT_R16_UINT: return VK_FORMAT_R16_UINT;
    case NRD_FORMAT_R16_FLOAT: return VK_FORMAT_R16_SFLOAT;
    case NRD_FORMAT_R32_FLOAT: return VK_FORMAT_R32_SFLOAT;
    case NRD_FORMAT_R32_UINT: return VK_FORMAT_R32_UINT;
    case NRD_FORMAT_RG32_UINT: return VK_FORMAT_R32G32_UINT;
    case NRD_FORMAT_RGBA16_FLOAT: return VK_FORMAT_R16G16B16A16_SFLOAT;
    case NRD_FORMAT_RGBA32_FLOAT: return VK_FORMAT_R32G32B32A32_SFLOAT;
    case NRD_FORMAT_ANY:
    case NRD_FORMAT_COUNT: break;
    }
    return VK_FORMAT_UNDEFINED;
}

static uint32_t nrdi_vk_max(uint32_t a, uint32_t b) { return a > b ? a : b; }

static uint32_t nrdi_vk_count(const nrd_pipeline *pipeline, nrd_access access)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < pipeline->binding_count; i++) count += pipeline->access[i] == access;
    return count;
}

static uint32_t nrdi_vk_count_reads(const nrd_pipeline *pipeline) { return nrdi_vk_count(pipeline, NRD_ACCESS_READ) + nrdi_vk_count(pipeline, NRD_ACCESS_READ_LINEAR); }

static void nrdi_vk_need_format(nrd_vk_needs *needs, nrd_format format)
{
    VkFormat vk_format = nrd_vk_format(format);
    for (uint32_t i = 0; i < needs->format_count; i++) if (needs->formats[i] == vk_format) return;
    if (vk_format == VK_FORMAT_UNDEFINED) return;
    needs->features[needs->format_count] = VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
    needs->formats[needs->format_count++] = vk_format;
}

static void nrdi_vk_need_descriptors(const nrd_info *info, nrd_vk_needs *out)
{
    static const VkDescriptorType types[] = { VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                                              VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                              VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER };
    for (uint32_t i = 0; i < 5; i++) out->descriptors[i].type = types[i];
    for (uint32_t i = 0; i < info->pass_count; i++) {
        const nrd_pipeline *pipeline = &info->pipelines[info->passes[i].pipeline];
        out->descriptors[0].descriptorCount++;
        out->descriptors[1].descriptorCount += nrdi_vk_count(pipeline, NRD_ACCESS_WRITE);
        out->descriptors[2].descriptorCount += nrdi_vk_count_reads(pipeline);
        out->descriptors[3].descriptorCount += nrdi_vk_count(pipeline, NRD_ACCESS_BUFFER);
        out->descriptors[4].descriptorCount += nrdi_vk_count(pipeline, NRD_ACCESS_UNIFORM);
    }
    out->descriptor_type_count = 5;
    for (uint32_t i = out->descriptor_type_count; i-- > 0;)   /* a pool must not be asked for none of a type */
        if (!out->descriptors[i].descriptorCount) out->descriptors[i] = out->descriptors[--out->descriptor_type_count];
    out->descriptor_sets = info->pass_count;
}

nrd_result nrd_vk_requirements(const nrd *instance, nrd_vk_needs *out)
{
    const nrd_info *info = instance ? nrd_get_info(instance) : NULL;
    if (!info || !out) return NRD_RESULT_INVALID_ARGUMENT;
    memset(out, 0, sizeof *out);
    out->api_version = VK_API_VERSION_1_1;
    out->max_image_dimension_2d = nrdi_vk_max(info->width, info->height);
    out->max_uniform_buffer_range = info->constant_bytes;
    out->permanent_bytes = info->permanent_bytes;
    out->transient_bytes = info->transient_bytes;
    nrdi_vk_need_descriptors(info, out);
    for (uint32_t i = 0; i < info->texture_count; i++) if (!info->textures[i].buffer) nrdi_vk_need_format(out, info->textures[i].format);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++)
        if (nrd_uses_resource(instance, (nrd_resource)i)) nrdi_vk_need_format(out, nrd_resource_format((nrd_resource)i));
    for (uint32_t i = 0; i < info->pipeline_count; i++) {
        const nrd_pipeline *pipeline = &info->pipelines[i];
        out->max_per_stage_storage_images = nrdi_vk_max(out->max_per_stage_storage_images, nrdi_vk_count(pipeline, NRD_ACCESS_WRITE));
        out->max_per_stage_sampled_images = nrdi_vk_max(out->max_per_stage_sampled_images, nrdi_vk_count_reads(pipeline));
    }
    return NRD_RESULT_OK;
}

static nrd_result nrdi_vk_load_physical(nrdi_vk_physical *p, const nrd *instance, VkInstance vk_instance, VkPhysicalDevice device, PFN_vkGetInstanceProcAddr get)
{
    p->instance = instance;
    p->device = device;
#define NRDI_VK_LOAD(name) \
    p->name = (PFN_##name)get(vk_instance, #name); \
    if (!p->name) return nrdi_vk_fail(instance, NRD_RESULT_INVALID_ARGUMENT, "get_instance_proc does not know " #name);
    NRDI_VK_PHYSICAL_FUNCTIONS(NRDI_VK_LOAD)
#undef NRDI_VK_LOAD
    return NRD_RESULT_OK;
}

static nrd_result nrdi_vk_check_formats(const nrdi_vk_physical *p, const nrd_vk_needs *needs)
{
    for (uint32_t i = 0; i < needs->format_count; i++) {
        VkFormatProperties has;
        p->vkGetPhysicalDeviceFormatProperties(p->device, needs->formats[i], &has);
        if (needs->features[i] & ~has.optimalTilingFeatures)
            return nrdi_vk_fail_value(p->instance, NRD_RESULT_UNSUPPORTED_DEVICE, "the device cannot sample and store a format: VkFormat", needs->formats[i],
                                      ", lacking feature bits ", needs->features[i] & ~has.optimalTilingFeatures);
    }
    return NRD_RESULT_OK;
}

static nrd_result nrdi_vk_check_physical(const nrdi_vk_physical *p)
{
    nrd_vk_needs needs;
    VkPhysicalDeviceProperties has;
    nrd_result result = nrd_vk_requirements(p->instance, &needs);
    if (result != NRD_RESULT_OK) return result;
    p->vkGetPhysicalDeviceProperties(p->device, &has);
    if (has.apiVersion < needs.api_version)
        return nrdi_vk_fail(p->instance, NRD_RESULT_UNSUPPORTED_DEVICE, "the device has Vulkan 1.0, needed is 1.1");
#define NRDI_VK_LIMIT(limit, need) \
    if (has.limits.limit < needs.need) \
        return nrdi_vk_fail_value(p->instance, NRD_RESULT_UNSUPPORTED_DEVICE, "the device's " #limit, has.limits.limit, ", needed is ", needs.need)
    NRDI_VK_LIMIT(maxImageDimension2D, max_image_dimension_2d);
    NRDI_VK_LIMIT(maxUniformBufferRange, max_uniform_buffer_range);
    NRDI_VK_LIMIT(maxPerStageDescriptorSampledImages, max_per_stage_sampled_images);
    NRDI_VK_LIMIT(maxPerStageDescriptorSamplers, max_per_stage_sampled_images);
    NRDI_VK_LIMIT(maxPerStageDescriptorStorageImages, max_per_stage_storage_images);
#undef NRDI_VK_LIMIT
    return nrdi_vk_check_formats(p, &needs);
}

nrd_result nrd_vk_check_device(const nrd *instance, VkInstance vk_instance, VkPhysicalDevice physical, PFN_vkGetInstanceProcAddr get_instance_proc)
{
    nrdi_vk_physical p;
    if (!instance || !vk_instance || !physical || !get_instance_proc) return NRD_RESULT_INVALID_ARGUMENT;
    nrd_result result = nrdi_vk_load_physical(&p, instance, vk_instance, physical, get_instance_proc);
    return result == NRD_RESULT_OK ? nrdi_vk_check_physical(&p) : result;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Creation  >>create */
static nrd_result nrdi_vk_check_version(const nrd_vk_desc *desc)
{
    if (desc->struct_version && desc->struct_version != NRD_VK_STRUCT_VERSION)
        return nrdi_vk_fail_value(desc->instance, NRD_RESULT_WRONG_VERSION, "nrd_vk_desc.struct_version", desc->struct_version, ", needed is ", NRD_VK_STRUCT_VERSION);
    if (nrd_version() == NRD_RELEASE_NUMBER) return NRD_RESULT_OK;
    return nrdi_vk_fail_value(desc->instance, NRD_RESULT_WRONG_VERSION, "the release of nrd.h's implementation", nrd_version(), ", that of nrd_vk.h's is ", NRD_RELEASE_NUMBER);
}

static nrd_result nrdi_vk_check_desc(const nrd_vk_desc *desc)
{
    const char *wrong = NULL;
    if (!desc || !desc->instance) return NRD_RESULT_INVALID_ARGUMENT;
    if (!nrd_get_info(desc->instance)) return NRD_RESULT_DESTROYED;
    nrd_result result = nrdi_vk_check_version(desc);
    if (result != NRD_RESULT_OK) return result;
    if (!desc->vk_instance) wrong = "nrd_vk_desc.vk_instance is NULL";
    else if (!desc->physical) wrong = "nrd_vk_desc.physical is NULL";
    else if (!desc->device) wrong = "nrd_vk_desc.device is NULL";
    else if (!desc->get_instance_proc) wrong = "nrd_vk_desc.get_instance_proc is NULL";
    else if (!desc->allocate_memory != !desc->free_memory) wrong = "nrd_vk_desc.allocate_memory and free_memory must be given together";
    else if (!desc->allocate != !desc->release) wrong = "nrd_vk_desc.allocate and release must be given together";
    if (wrong) return nrdi_vk_fail(desc->instance, NRD_RESULT_INVALID_ARGUMENT, wrong);
    if (desc->frames_in_flight > 16)
        return nrdi_vk_fail_value(desc->instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_desc.frames_in_flight", desc->frames_in_flight, ", allowed is 0 to ", 16);
    return NRD_RESULT_OK;
}

/* With base NULL only counts. */
static void *nrdi_vk_take(char *base, size_t *used, size_t count, size_t bytes)
{
    size_t at = (*used + 15) / 16 * 16;
    *used = at + count * bytes;
    return base ? base + at : NULL;
}

static size_t nrdi_vk_carve(nrd_vk *vk, char *base)
{
    size_t used = sizeof *vk, textures = vk->info->texture_count, passes = (size_t)vk->slots * vk->info->pass_count;
    size_t images = textures + NRD_RESOURCE_COUNT, bindings = vk->max_bindings;
#define NRDI_VK_TAKE(member, type, count) vk->member = (type *)nrdi_vk_take(base, &used, count, sizeof(type))
    NRDI_VK_TAKE(images, nrdi_vk_image, images);
    NRDI_VK_TAKE(pipelines, nrdi_vk_pipeline, vk->info->pipeline_count);
    NRDI_VK_TAKE(sets, VkDescriptorSet, passes);
    NRDI_VK_TAKE(set_layouts, VkDescriptorSetLayout, passes);
    NRDI_VK_TAKE(bound, VkImageView, passes * bindings);
    NRDI_VK_TAKE(timed, bool, passes);
    NRDI_VK_TAKE(counted, bool, (size_t)vk->slots * vk->info->denoiser_count);
    NRDI_VK_TAKE(barriers, VkImageMemoryBarrier, images);
    NRDI_VK_TAKE(blocks, nrd_block, textures);
    NRDI_VK_TAKE(layout_bindings, VkDescriptorSetLayoutBinding, bindings + 1);
    NRDI_VK_TAKE(image_infos, VkDescriptorImageInfo, bindings);
    NRDI_VK_TAKE(writes, VkWriteDescriptorSet, bindings);
#undef NRDI_VK_TAKE
    return used;
}

/* Zeroed. */
static void *nrdi_vk_allocate(const nrd_vk_desc *desc, size_t bytes)
{
    void *memory = desc->allocate ? desc->allocate(desc->allocate_user, bytes) : NRD_MALLOC(bytes);
    if (memory) memset(memory, 0, bytes);
    return memory;
}

static void nrdi_vk_release(const nrd_vk *vk, void *memory)
{
    if (vk->desc.release) vk->desc.release(vk->desc.allocate_user, memory);
    else NRD_FREE(memory);
}

static nrd_vk *nrdi_vk_allocate_vk(const nrd_vk_desc *desc)
{
    nrd_vk size;
    memset(&size, 0, sizeof size);
    size.desc = *desc;
    size.info = nrd_get_info(desc->instance);
    size.slots = desc->frames_in_flight ? desc->frames_in_flight : 2;
    size.alive = NRDI_VK_ALIVE;
    size.texture_count = size.info->texture_count;
    size.pipeline_count = size.info->pipeline_count;
    size.set_count = size.slots * size.info->pass_count;
    size.width = size.info->width;
    size.height = size.info->height;
    for (uint32_t i = 0; i < size.info->pipeline_count; i++) size.max_bindings = nrdi_vk_max(size.max_bindings, size.info->pipelines[i].binding_count);
    size_t bytes = nrdi_vk_carve(&size, NULL);
    nrd_vk *vk = (nrd_vk *)nrdi_vk_allocate(desc, bytes);
    if (!vk) return NULL;
    *vk = size;
    nrdi_vk_carve(vk, (char *)vk);
    if (desc->callbacks) vk->callbacks = *desc->callbacks, vk->use_callbacks = &vk->callbacks;
    return vk;
}

static nrd_result nrdi_vk_load(nrd_vk *vk)
{
    const nrd_vk_desc *d = &vk->desc;
    PFN_vkGetDeviceProcAddr get = d->get_device_proc;
    if (!get) get = (PFN_vkGetDeviceProcAddr)d->get_instance_proc(d->vk_instance, "vkGetDeviceProcAddr");
    if (!get) return nrdi_vk_fail(d->instance, NRD_RESULT_INVALID_ARGUMENT, "get_instance_proc does not know vkGetDeviceProcAddr");
#define NRDI_VK_LOAD(name) \
    vk->fn.name = (PFN_##name)get(d->device, #name); \
    if (!vk->fn.name) return nrdi_vk_fail(d->instance, NRD_RESULT_INVALID_ARGUMENT, "get_device_proc does not know " #name);
    NRDI_VK_FUNCTIONS(NRDI_VK_LOAD)
#undef NRDI_VK_LOAD
    if (!(d->flags & NRD_VK_DEBUG_NAMES)) return NRD_RESULT_OK;
    vk->set_name = (PFN_vkSetDebugUtilsObjectNameEXT)d->get_instance_proc(d->vk_instance, "vkSetDebugUtilsObjectNameEXT");
    vk->begin_label = (PFN_vkCmdBeginDebugUtilsLabelEXT)d->get_instance_proc(d->vk_instance, "vkCmdBeginDebugUtilsLabelEXT");
    vk->end_label = (PFN_vkCmdEndDebugUtilsLabelEXT)d->get_instance_proc(d->vk_instance, "vkCmdEndDebugUtilsLabelEXT");
    return NRD_RESULT_OK;
}

/* handle: the address of a 64-bit non-dispatchable handle. */
static void nrdi_vk_name(const nrd_vk *vk, VkObjectType type, const void *handle, const char *prefix, const char *name)
{
    NRDI_VK_STRUCT(VkDebugUtilsObjectNameInfoEXT, info, VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT);
    if (!vk->set_name) return;
    nrdi_vk_text text = nrdi_vk_say(prefix);
    nrdi_vk_add(&text, name);
    info.objectType = type;
    memcpy(&info.objectHandle, handle, sizeof info.objectHandle);
    info.pObjectName = text.text;
    vk->set_name(vk->desc.device, &info);
}

static nrd_result nrdi_vk_create_samplers(nrd_vk *vk)
{
    for (uint32_t i = 0; i < 2; i++) {
        NRDI_VK_STRUCT(VkSamplerCreateInfo, info, VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO);
        info.magFilter = info.minFilter = i ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
        info.addressModeU = info.addressModeV = info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
        NRDI_VK_CREATE(vk, vkCreateSampler, &info, &vk->samplers[i]);
    }
    return NRD_RESULT_OK;
}

static VkDescriptorType nrdi_vk_descriptor_type(nrd_access access)
{
    if (access == NRD_ACCESS_BUFFER) return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    if (access == NRD_ACCESS_UNIFORM) return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    return access == NRD_ACCESS_WRITE ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
}

static nrd_result nrdi_vk_create_layouts(nrd_vk *vk, const nrd_pipeline *from, nrdi_vk_pipeline *to)
{
    NRDI_VK_STRUCT(VkDescriptorSetLayoutCreateInfo, set, VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
    NRDI_VK_STRUCT(VkPipelineLayoutCreateInfo, layout, VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    VkPushConstantRange push = { VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(((nrd_dispatch *)0)->push) };
    for (uint32_t i = 0; i <= from->binding_count; i++) {
        VkDescriptorSetLayoutBinding *b = &vk->layout_bindings[i];
        b->binding = i;
        b->descriptorType = i ? nrdi_vk_descriptor_type(from->access[i - 1]) : VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;
        b->descriptorCount = 1;
        b->stageFlags = VK_SHADER_STAGE_COMPUTE_BIT;
        b->pImmutableSamplers = b->descriptorType == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER ? &vk->samplers[from->access[i - 1] == NRD_ACCESS_READ_LINEAR] : NULL;
    }
    set.bindingCount = from->binding_count + 1;
    set.pBindings = vk->layout_bindings;
    NRDI_VK_CREATE(vk, vkCreateDescriptorSetLayout, &set, &to->set_layout);
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &to->set_layout;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &push;
    NRDI_VK_CREATE(vk, vkCreatePipelineLayout, &layout, &to->layout);
    return NRD_RESULT_OK;
}

static const nrd_spirv *nrdi_vk_find_module(const char *name)
{
    for (uint32_t i = 0; i < nrd_spirv_count; i++) if (strcmp(nrd_spirv_table[i].name, name) == 0) return &nrd_spirv_table[i];
    return NULL;
}

static nrd_result nrdi_vk_compile(nrd_vk *vk, const nrd_pipeline *from, VkShaderModule module, nrdi_vk_pipeline *to)
{
    enum { CONSTANTS = sizeof(((nrd_pipeline *)0)->spec_constants) / sizeof(uint32_t) };
    VkSpecializationMapEntry entries[CONSTANTS];
    VkSpecializationInfo special = { CONSTANTS, entries, sizeof from->spec_constants, from->spec_constants };
    NRDI_VK_STRUCT(VkComputePipelineCreateInfo, info, VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
    for (uint32_t i = 0; i < CONSTANTS; i++) {
        entries[i].constantID = i;
        entries[i].offset = i * (uint32_t)sizeof(uint32_t);
        entries[i].size = sizeof(uint32_t);
    }
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    info.stage.pSpecializationInfo = &special;
    info.layout = to->layout;
    VkResult result = vk->fn.vkCreateComputePipelines(vk->desc.device, vk->desc.pipeline_cache, 1, &info, vk->use_callbacks, &to->pipeline);
    return nrdi_vk_try(vk->desc.instance, result, "vkCreateComputePipelines");
}

static nrd_result nrdi_vk_create_pipeline(nrd_vk *vk, const nrd_pipeline *from, nrdi_vk_pipeline *to)
{
    const nrd_spirv *spirv = nrdi_vk_find_module(from->shader);
    VkShaderModule module = VK_NULL_HANDLE;
    if (!spirv) {
        nrdi_vk_text t = nrdi_vk_say("nrd_spirv.h is of another version or was compiled with other NRD_ONLY_ and NRD_NO_ macros: it has no module ");
        nrdi_vk_add(&t, from->shader);
        return nrdi_vk_fail(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, t.text);
    }
    nrd_result result = nrdi_vk_create_layouts(vk, from, to);
    if (result != NRD_RESULT_OK) return result;
    NRDI_VK_STRUCT(VkShaderModuleCreateInfo, info, VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    info.codeSize = spirv->size_bytes;
    info.pCode = spirv->words;
    NRDI_VK_CREATE(vk, vkCreateShaderModule, &info, &module);
    result = nrdi_vk_compile(vk, from, module, to);
    vk->fn.vkDestroyShaderModule(vk->desc.device, module, vk->use_callbacks);
    if (result == NRD_RESULT_OK) nrdi_vk_name(vk, VK_OBJECT_TYPE_PIPELINE, &to->pipeline, "nrd ", from->shader);
    return result;
}

static nrd_result nrdi_vk_create_pipelines(nrd_vk *vk)
{
    nrd_result result = NRD_RESULT_OK;
    for (uint32_t i = 0; i < vk->info->pipeline_count && result == NRD_RESULT_OK; i++)
        result = nrdi_vk_create_pipeline(vk, &vk->info->pipelines[i], &vk->pipelines[i]);
    return result;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Memory  >>memory */
static nrd_result nrdi_vk_find_memory_type(nrd_vk *vk, uint32_t allowed, VkMemoryPropertyFlags flags, VkMemoryPropertyFlags wished, uint32_t *out)
{
    VkPhysicalDeviceMemoryProperties has;
    vk->physical.vkGetPhysicalDeviceMemoryProperties(vk->physical.device, &has);
    for (uint32_t i = 0; i < 2 * has.memoryTypeCount; i++) {
        uint32_t type = i % has.memoryTypeCount;
        VkMemoryPropertyFlags needed = i < has.memoryTypeCount ? flags | wished : flags;
        if (!(allowed >> type & 1) || (has.memoryTypes[type].propertyFlags & needed) != needed) continue;
        *out = type;
        return NRD_RESULT_OK;
    }
    return nrdi_vk_fail_value(vk->desc.instance, NRD_RESULT_UNSUPPORTED_DEVICE, "no memory type has the needed VkMemoryPropertyFlags: memoryTypeBits", allowed, ", flags ", flags);
}

static bool nrdi_vk_has_counters(const nrd_vk *vk)
{
    bool has = false;
    for (uint32_t i = 0; i < vk->info->texture_count; i++) has |= vk->info->textures[i].read_back;
    return has;
}

static nrd_result nrdi_vk_allocate_device(nrd_vk *vk, nrd_vk_memory_kind kind, const VkMemoryRequirements *needs, nrd_vk_memory *out)
{
    bool host = kind == NRD_VK_MEMORY_CONSTANTS;
    VkMemoryPropertyFlags flags = host ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    NRDI_VK_STRUCT(VkMemoryAllocateInfo, info, VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    /* beyond the bus, constants cost the first threads of each pass microseconds; so do counters, where the host reads them */
    VkMemoryPropertyFlags wished = host && !nrdi_vk_has_counters(vk) ? VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT : 0;
    nrd_result result = nrdi_vk_find_memory_type(vk, needs->memoryTypeBits, flags, wished, &info.memoryTypeIndex);
    if (result != NRD_RESULT_OK) return result;
    info.allocationSize = needs->size;
    NRDI_VK_CREATE(vk, vkAllocateMemory, &info, &out->memory);
    if (!host) return NRD_RESULT_OK;
    return nrdi_vk_try(vk->desc.instance, vk->fn.vkMapMemory(vk->desc.device, out->memory, 0, VK_WHOLE_SIZE, 0, &out->mapped), "vkMapMemory");
}

static nrd_result nrdi_vk_get_memory(nrd_vk *vk, nrd_vk_memory_kind kind, const VkMemoryRequirements *needs)
{
    nrd_vk_memory *out = &vk->memory[kind];
    vk->memory_bytes[kind] = needs->size;
    if (!vk->desc.allocate_memory) return nrdi_vk_allocate_device(vk, kind, needs, out);
    nrd_vk_memory got = { VK_NULL_HANDLE, 0, NULL };
    nrd_result result = nrdi_vk_try(vk->desc.instance, vk->desc.allocate_memory(vk->desc.memory_user, kind, needs, &got), "nrd_vk_desc.allocate_memory");
    if (result != NRD_RESULT_OK) return result;
    *out = got;
    if (!got.memory || got.offset % needs->alignment || (kind == NRD_VK_MEMORY_CONSTANTS && !got.mapped))
        return nrdi_vk_fail(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_desc.allocate_memory gave no memory, a misaligned offset, or constants that are not mapped");
    return NRD_RESULT_OK;
}

static void nrdi_vk_free_memory(nrd_vk *vk, uint32_t kind, nrd_vk_memory *memory)
{
    if (!memory->memory) return;
    if (vk->desc.free_memory) vk->desc.free_memory(vk->desc.memory_user, (nrd_vk_memory_kind)kind, memory);
    else vk->fn.vkFreeMemory(vk->desc.device, memory->memory, vk->use_callbacks);
    memset(memory, 0, sizeof *memory);
}

static void nrdi_vk_destroy_images(nrd_vk *vk, nrdi_vk_image *images, nrd_vk_memory memory[2])
{
    for (uint32_t i = 0; i < vk->texture_count; i++) {
        NRDI_VK_DESTROY(vk, vkDestroyImageView, images[i].view);
        NRDI_VK_DESTROY(vk, vkDestroyImage, images[i].image);
    }
    memset(images, 0, vk->texture_count * sizeof *images);
    for (uint32_t kind = NRD_VK_MEMORY_PERMANENT; kind <= NRD_VK_MEMORY_TRANSIENT; kind++) nrdi_vk_free_memory(vk, kind, &memory[kind]);
}

static nrd_result nrdi_vk_create_image(nrd_vk *vk, const nrd_texture *texture, nrdi_vk_image *out)
{
    NRDI_VK_STRUCT(VkImageCreateInfo, info, VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = nrd_vk_format(texture->format);
    info.extent.width = texture->width;
    info.extent.height = texture->height;
    info.extent.depth = info.mipLevels = info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | (texture->permanent ? (VkImageUsageFlags)VK_IMAGE_USAGE_TRANSFER_DST_BIT : 0)
               | (texture->read_back ? (VkImageUsageFlags)VK_IMAGE_USAGE_TRANSFER_SRC_BIT : 0);
    NRDI_VK_CREATE(vk, vkCreateImage, &info, &out->image);
    out->layout = VK_IMAGE_LAYOUT_GENERAL;
    out->transient = !texture->permanent;
    nrdi_vk_name(vk, VK_OBJECT_TYPE_IMAGE, &out->image, "nrd ", texture->name);
    return NRD_RESULT_OK;
}

static nrd_result nrdi_vk_create_view(nrd_vk *vk, const nrd_texture *texture, nrdi_vk_image *image)
{
    NRDI_VK_STRUCT(VkImageViewCreateInfo, info, VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    info.image = image->image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = nrd_vk_format(texture->format);
    info.subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
    info.subresourceRange.levelCount = info.subresourceRange.layerCount = 1;
    NRDI_VK_CREATE(vk, vkCreateImageView, &info, &image->view);
    return NRD_RESULT_OK;
}

/* All images of one kind: their place in one block, as the device sees their size. Permanent ones are in use all the time. */
static void nrdi_vk_place(nrd_vk *vk, bool permanent, VkMemoryRequirements *total)
{
    uint32_t count = 0;
    memset(total, 0, sizeof *total);
    total->memoryTypeBits = ~0u;
    total->alignment = 1;
    for (uint32_t i = 0; i < vk->info->texture_count; i++) {
        const nrd_texture *texture = &vk->info->textures[i];
        VkMemoryRequirements needs;
        if (texture->permanent != permanent || texture->buffer) continue;
        vk->fn.vkGetImageMemoryRequirements(vk->desc.device, vk->images[NRD_RESOURCE_COUNT + i].image, &needs);
        nrd_block *block = &vk->blocks[count++];
        block->bytes = needs.size;
        block->alignment = needs.alignment;
        block->first = permanent ? 0 : texture->first_pass;
        block->last = permanent ? UINT32_MAX : texture->last_pass;
        total->memoryTypeBits &= needs.memoryTypeBits;
        if (needs.alignment > total->alignment) total->alignment = needs.alignment;
    }
    total->size = nrd_place_blocks(vk->blocks, count);
}

static nrd_result nrdi_vk_bind_images(nrd_vk *vk, bool permanent)
{
    nrd_vk_memory_kind kind = permanent ? NRD_VK_MEMORY_PERMANENT : NRD_VK_MEMORY_TRANSIENT;
    VkMemoryRequirements total;
    nrdi_vk_place(vk, permanent, &total);
    if (total.size == 0) return NRD_RESULT_OK;
    nrd_result result = nrdi_vk_get_memory(vk, kind, &total);
    for (uint32_t i = 0, at = 0; i < vk->info->texture_count && result == NRD_RESULT_OK; i++) {
        nrdi_vk_image *image = &vk->images[NRD_RESOURCE_COUNT + i];
        if (vk->info->textures[i].permanent != permanent || vk->info->textures[i].buffer) continue;
        VkResult bound = vk->fn.vkBindImageMemory(vk->desc.device, image->image, vk->memory[kind].memory, vk->memory[kind].offset + vk->blocks[at++].offset);
        result = nrdi_vk_try(vk->desc.instance, bound, "vkBindImageMemory");
        if (result == NRD_RESULT_OK) result = nrdi_vk_create_view(vk, &vk->info->textures[i], image);
    }
    return result;
}

static nrd_result nrdi_vk_create_bare_images(nrd_vk *vk)
{
    nrd_result result = NRD_RESULT_OK;
    for (uint32_t i = 0; i < vk->info->texture_count && result == NRD_RESULT_OK; i++)
        if (!vk->info->textures[i].buffer) result = nrdi_vk_create_image(vk, &vk->info->textures[i], &vk->images[NRD_RESOURCE_COUNT + i]);
    return result;
}

static nrd_result nrdi_vk_create_images(nrd_vk *vk)
{
    nrd_result result = nrdi_vk_create_bare_images(vk);
    if (result == NRD_RESULT_OK) result = nrdi_vk_bind_images(vk, true);
    if (result == NRD_RESULT_OK) result = nrdi_vk_bind_images(vk, false);
    return result;
}

/* 256: no device asks for a larger minStorageBufferOffsetAlignment (Vulkan specification, required limits). */
enum { NRDI_VK_COUNTER_BYTES = NRD_COUNTER_COUNT * 4, NRDI_VK_GROUPS_STRIDE = 256 };

/* Buffers before this texture. */
static uint32_t nrdi_vk_count_buffers(const nrd_info *info, uint32_t texture)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < texture; i++) count += info->textures[i].buffer;
    return count;
}

static VkDeviceSize nrdi_vk_groups_of(const nrd_vk *vk, uint32_t texture)
{
    return vk->groups_at + (VkDeviceSize)nrdi_vk_count_buffers(vk->info, texture) * NRDI_VK_GROUPS_STRIDE;
}

static nrd_result nrdi_vk_create_bare_constants(nrd_vk *vk, VkMemoryRequirements *needs)
{
    VkPhysicalDeviceProperties has;
    NRDI_VK_STRUCT(VkBufferCreateInfo, info, VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
    vk->physical.vkGetPhysicalDeviceProperties(vk->physical.device, &has);
    VkDeviceSize align = has.limits.minUniformBufferOffsetAlignment ? has.limits.minUniformBufferOffsetAlignment : 1;
    vk->constant_stride = (vk->info->constant_bytes + align - 1) / align * align;
    info.size = vk->counters_at = vk->constant_stride * vk->slots * vk->info->pass_count;
    info.usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
    if (nrdi_vk_has_counters(vk)) {
        info.size += (VkDeviceSize)vk->slots * vk->info->denoiser_count * NRDI_VK_COUNTER_BYTES;
        info.usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    }
    vk->groups_at = (info.size + NRDI_VK_GROUPS_STRIDE - 1) / NRDI_VK_GROUPS_STRIDE * NRDI_VK_GROUPS_STRIDE;
    uint32_t buffers = nrdi_vk_count_buffers(vk->info, vk->info->texture_count);
    if (buffers) {
        info.size = vk->groups_at + (VkDeviceSize)buffers * NRDI_VK_GROUPS_STRIDE;
        info.usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    }
    NRDI_VK_CREATE(vk, vkCreateBuffer, &info, &vk->constants);
    nrdi_vk_name(vk, VK_OBJECT_TYPE_BUFFER, &vk->constants, "nrd ", "constants");
    vk->fn.vkGetBufferMemoryRequirements(vk->desc.device, vk->constants, needs);
    return NRD_RESULT_OK;
}

static nrd_result nrdi_vk_create_constants(nrd_vk *vk)
{
    VkMemoryRequirements needs;
    nrd_result result = nrdi_vk_create_bare_constants(vk, &needs);
    if (result == NRD_RESULT_OK) result = nrdi_vk_get_memory(vk, NRD_VK_MEMORY_CONSTANTS, &needs);
    if (result != NRD_RESULT_OK) return result;
    const nrd_vk_memory *memory = &vk->memory[NRD_VK_MEMORY_CONSTANTS];
    memset((char *)memory->mapped + vk->groups_at, 0, (size_t)(nrdi_vk_groups_of(vk, vk->info->texture_count) - vk->groups_at));
    return nrdi_vk_try(vk->desc.instance, vk->fn.vkBindBufferMemory(vk->desc.device, vk->constants, memory->memory, memory->offset), "vkBindBufferMemory");
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Descriptor sets and queries  >>sets */
static nrd_result nrdi_vk_create_pool(nrd_vk *vk)
{
    NRDI_VK_STRUCT(VkDescriptorPoolCreateInfo, pool, VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
    nrd_vk_needs needs;
    nrd_result result = nrd_vk_requirements(vk->desc.instance, &needs);
    if (result != NRD_RESULT_OK) return result;
    for (uint32_t i = 0; i < needs.descriptor_type_count; i++) needs.descriptors[i].descriptorCount *= vk->slots;
    pool.maxSets = vk->set_count;
    pool.poolSizeCount = needs.descriptor_type_count;
    pool.pPoolSizes = needs.descriptors;
    NRDI_VK_CREATE(vk, vkCreateDescriptorPool, &pool, &vk->pool);
    return NRD_RESULT_OK;
}

/* All or none: the app's pool may not be one from which single sets can be freed. */
static nrd_result nrdi_vk_allocate_sets(nrd_vk *vk)
{
    NRDI_VK_STRUCT(VkDescriptorSetAllocateInfo, info, VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
    for (uint32_t i = 0; i < vk->set_count; i++) vk->set_layouts[i] = vk->pipelines[vk->info->passes[i % vk->info->pass_count].pipeline].set_layout;
    info.descriptorPool = vk->pool ? vk->pool : vk->desc.descriptor_pool;
    info.descriptorSetCount = vk->set_count;
    info.pSetLayouts = vk->set_layouts;
    VkResult result = vk->fn.vkAllocateDescriptorSets(vk->desc.device, &info, vk->sets);
    if (result != VK_SUCCESS) memset(vk->sets, 0, vk->set_count * sizeof *vk->sets);
    if (vk->pool || (result != VK_ERROR_OUT_OF_POOL_MEMORY && result != VK_ERROR_FRAGMENTED_POOL)) return nrdi_vk_try(vk->desc.instance, result, "vkAllocateDescriptorSets");
    nrdi_vk_text t = nrdi_vk_say("nrd_vk_desc.descriptor_pool has too little left, or is fragmented: needed are ");
    nrdi_vk_add_number(&t, vk->set_count);
    nrdi_vk_add(&t, " sets; nrd_vk_requirements tells with how many descriptors");
    return nrdi_vk_fail(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, t.text);
}

static void nrdi_vk_free_sets(nrd_vk *vk)
{
    bool frees = vk->desc.descriptor_pool && (vk->desc.flags & NRD_VK_FREE_DESCRIPTOR_SETS);
    if (frees && vk->sets[0]) vk->fn.vkFreeDescriptorSets(vk->desc.device, vk->desc.descriptor_pool, vk->set_count, vk->sets);
}

static void nrdi_vk_write_constants_descriptor(nrd_vk *vk, VkDescriptorSet set)
{
    VkDescriptorBufferInfo buffer = { vk->constants, 0, vk->info->constant_bytes };
    NRDI_VK_STRUCT(VkWriteDescriptorSet, write, VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    write.dstSet = set;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;
    write.pBufferInfo = &buffer;
    vk->fn.vkUpdateDescriptorSets(vk->desc.device, 1, &write, 0, NULL);
}

static nrd_result nrdi_vk_create_sets(nrd_vk *vk)
{
    nrd_result result = vk->desc.descriptor_pool ? NRD_RESULT_OK : nrdi_vk_create_pool(vk);
    if (result == NRD_RESULT_OK) result = nrdi_vk_allocate_sets(vk);
    for (uint32_t i = 0; i < vk->set_count && result == NRD_RESULT_OK; i++) nrdi_vk_write_constants_descriptor(vk, vk->sets[i]);
    return result;
}

static uint32_t nrdi_vk_timestamp_bits(const nrd_vk *vk)
{
    VkQueueFamilyProperties families[32];
    uint32_t count = 32;
    vk->physical.vkGetPhysicalDeviceQueueFamilyProperties(vk->physical.device, &count, families);
    return vk->desc.queue_family < count ? families[vk->desc.queue_family].timestampValidBits : 0;
}

static nrd_result nrdi_vk_create_queries(nrd_vk *vk)
{
    VkPhysicalDeviceProperties has;
    NRDI_VK_STRUCT(VkQueryPoolCreateInfo, info, VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
    uint32_t bits = vk->desc.flags & NRD_VK_TIMESTAMPS ? nrdi_vk_timestamp_bits(vk) : 0;
    if (bits == 0) return NRD_RESULT_OK;
    vk->physical.vkGetPhysicalDeviceProperties(vk->physical.device, &has);
    vk->tick_ns = has.limits.timestampPeriod;
    vk->tick_mask = bits >= 64 ? UINT64_MAX : ((uint64_t)1 << bits) - 1;
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = vk->slots * vk->info->pass_count * 2;
    NRDI_VK_CREATE(vk, vkCreateQueryPool, &info, &vk->queries);
    return NRD_RESULT_OK;
}

static nrd_result nrdi_vk_fill(nrd_vk *vk)
{
    const nrd_vk_desc *d = &vk->desc;
    nrd_result result = nrdi_vk_load_physical(&vk->physical, d->instance, d->vk_instance, d->physical, d->get_instance_proc);
    if (result == NRD_RESULT_OK) result = nrdi_vk_check_physical(&vk->physical);
    if (result == NRD_RESULT_OK) result = nrdi_vk_load(vk);
    if (result == NRD_RESULT_OK) result = nrdi_vk_create_samplers(vk);
    if (result == NRD_RESULT_OK) result = nrdi_vk_create_pipelines(vk);
    if (result == NRD_RESULT_OK) result = nrdi_vk_create_images(vk);
    if (result == NRD_RESULT_OK) result = nrdi_vk_create_constants(vk);
    if (result == NRD_RESULT_OK) result = nrdi_vk_create_queries(vk);
    if (result == NRD_RESULT_OK) result = nrdi_vk_create_sets(vk); /* last: what an app's pool has given cannot always be given back */
    return result;
}

static nrd_result nrdi_vk_measure(nrd_vk *vk, VkMemoryRequirements needs[3])
{
    const nrd_vk_desc *d = &vk->desc;
    nrd_result result = nrdi_vk_load_physical(&vk->physical, d->instance, d->vk_instance, d->physical, d->get_instance_proc);
    if (result == NRD_RESULT_OK) result = nrdi_vk_check_physical(&vk->physical);
    if (result == NRD_RESULT_OK) result = nrdi_vk_load(vk);
    if (result == NRD_RESULT_OK) result = nrdi_vk_create_bare_images(vk);
    if (result != NRD_RESULT_OK) return result;
    nrdi_vk_place(vk, true, &needs[NRD_VK_MEMORY_PERMANENT]);
    nrdi_vk_place(vk, false, &needs[NRD_VK_MEMORY_TRANSIENT]);
    return nrdi_vk_create_bare_constants(vk, &needs[NRD_VK_MEMORY_CONSTANTS]);
}

nrd_result nrd_vk_memory_needs(const nrd_vk_desc *desc, VkMemoryRequirements needs[3])
{
    VkMemoryRequirements measured[3];
    nrd_result result = nrdi_vk_check_desc(desc);
    if (result != NRD_RESULT_OK) return result;
    if (!needs) return nrdi_vk_fail(desc->instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_memory_needs: needs is NULL");
    nrd_vk *vk = nrdi_vk_allocate_vk(desc);
    if (!vk) return nrdi_vk_fail(desc->instance, NRD_RESULT_OUT_OF_MEMORY, "nrd_vk_memory_needs: the allocator returned NULL");
    result = nrdi_vk_measure(vk, measured);
    nrd_vk_destroy(vk);
    if (result == NRD_RESULT_OK) memcpy(needs, measured, sizeof measured);
    return result;
}

nrd_result nrd_vk_create(const nrd_vk_desc *desc, nrd_vk **out)
{
    nrd_result result = nrdi_vk_check_desc(desc);
    if (result != NRD_RESULT_OK) return result;
    if (!out) return nrdi_vk_fail(desc->instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_create: out is NULL");
    nrd_vk *vk = nrdi_vk_allocate_vk(desc);
    if (!vk) return nrdi_vk_fail(desc->instance, NRD_RESULT_OUT_OF_MEMORY, "nrd_vk_create: the allocator returned NULL");
    result = nrdi_vk_fill(vk);
    if (result == NRD_RESULT_OK) *out = vk;
    else nrd_vk_destroy(vk);
    return result;
}

/* *at is an element of the list. */
static void nrdi_vk_destroy_former(nrd_vk *vk, nrdi_vk_former **at)
{
    nrdi_vk_former *former = *at;
    *at = former->next;
    if (vk->last == former) vk->last = NULL;
    nrdi_vk_destroy_images(vk, former->images, former->memory);
    nrdi_vk_release(vk, former);
}

void nrd_vk_destroy(nrd_vk *vk)
{
    if (!vk || vk->alive != NRDI_VK_ALIVE) return;
    *(volatile uint32_t *)&vk->alive = NRDI_VK_DEAD;   /* or the compiler drops it */
    NRDI_VK_DESTROY(vk, vkDestroyQueryPool, vk->queries);
    NRDI_VK_DESTROY(vk, vkDestroyDescriptorPool, vk->pool);
    nrdi_vk_free_sets(vk);
    NRDI_VK_DESTROY(vk, vkDestroyBuffer, vk->constants);
    nrdi_vk_destroy_images(vk, vk->images + NRD_RESOURCE_COUNT, vk->memory);
    while (vk->former) nrdi_vk_destroy_former(vk, &vk->former);
    nrdi_vk_free_memory(vk, NRD_VK_MEMORY_CONSTANTS, &vk->memory[NRD_VK_MEMORY_CONSTANTS]);
    for (uint32_t i = 0; i < vk->pipeline_count; i++) {
        NRDI_VK_DESTROY(vk, vkDestroyPipeline, vk->pipelines[i].pipeline);
        NRDI_VK_DESTROY(vk, vkDestroyPipelineLayout, vk->pipelines[i].layout);
        NRDI_VK_DESTROY(vk, vkDestroyDescriptorSetLayout, vk->pipelines[i].set_layout);
    }
    for (uint32_t i = 0; i < 2; i++) NRDI_VK_DESTROY(vk, vkDestroySampler, vk->samplers[i]);
    nrdi_vk_release(vk, vk);
}

/* Also that its instance is. */
static nrd_result nrdi_vk_check_alive(const nrd_vk *vk)
{
    if (!vk) return NRD_RESULT_INVALID_ARGUMENT;
    return vk->alive == NRDI_VK_ALIVE && nrd_get_info(vk->desc.instance) ? NRD_RESULT_OK : NRD_RESULT_DESTROYED;
}

uint64_t nrd_vk_memory_bytes(const nrd_vk *vk, nrd_vk_memory_kind kind) { return vk && vk->alive == NRDI_VK_ALIVE && (uint32_t)kind < 3 ? vk->memory_bytes[kind] : 0; }

/* ---------------------------------------------------------------------------------------------------------------------------
   Another size  >>resize */
static nrdi_vk_former *nrdi_vk_allocate_former(const nrd_vk *vk)
{
    size_t used = 0, bytes;
    nrdi_vk_take(NULL, &used, 1, sizeof(nrdi_vk_former));
    nrdi_vk_take(NULL, &used, vk->info->texture_count, sizeof(nrdi_vk_image));
    bytes = used;
    char *base = (char *)nrdi_vk_allocate(&vk->desc, bytes);
    if (!base) return NULL;
    used = 0;
    nrdi_vk_former *former = (nrdi_vk_former *)nrdi_vk_take(base, &used, 1, sizeof *former);
    former->images = (nrdi_vk_image *)nrdi_vk_take(base, &used, vk->info->texture_count, sizeof(nrdi_vk_image));
    return former;
}

/* The images go to the former; and back. */
static void nrdi_vk_put_aside(nrd_vk *vk, nrdi_vk_former *former)
{
    nrdi_vk_image *images = vk->images + NRD_RESOURCE_COUNT;
    memcpy(former->images, images, vk->info->texture_count * sizeof *images);
    memcpy(former->memory, vk->memory, sizeof former->memory);
    memcpy(former->memory_bytes, vk->memory_bytes, sizeof former->memory_bytes);
    former->width = vk->width;
    former->height = vk->height;
    memset(images, 0, vk->info->texture_count * sizeof *images);
    memset(vk->memory, 0, sizeof former->memory);
    memset(vk->memory_bytes, 0, sizeof former->memory_bytes);
}

static void nrdi_vk_take_back(nrd_vk *vk, const nrdi_vk_former *former)
{
    memcpy(vk->images + NRD_RESOURCE_COUNT, former->images, vk->info->texture_count * sizeof *vk->images);
    memcpy(vk->memory, former->memory, sizeof former->memory);
    memcpy(vk->memory_bytes, former->memory_bytes, sizeof former->memory_bytes);
    vk->width = former->width;
    vk->height = former->height;
}

/* Images of another size, but those before that were never recorded: these come back. */
static nrd_result nrdi_vk_return_to_last(nrd_vk *vk)
{
    nrdi_vk_former *last = vk->last, **at = &vk->former;
    nrdi_vk_destroy_images(vk, vk->images + NRD_RESOURCE_COUNT, vk->memory);
    nrdi_vk_take_back(vk, last);
    while (*at != last) at = &(*at)->next;
    *at = last->next;
    nrdi_vk_release(vk, last);
    vk->last = NULL;
    vk->cleared = true;
    return nrd_resize(vk->desc.instance, vk->width, vk->height);
}

static nrd_result nrdi_vk_make_images(nrd_vk *vk, uint32_t width, uint32_t height)
{
    nrd_result result = nrd_resize(vk->desc.instance, width, height);
    if (result == NRD_RESULT_OK) result = nrdi_vk_check_physical(&vk->physical);
    if (result == NRD_RESULT_OK) result = nrdi_vk_create_images(vk);
    return result;
}

nrd_result nrd_vk_resize(nrd_vk *vk, uint32_t width, uint32_t height)
{
    nrd_result result = nrdi_vk_check_alive(vk);
    if (result != NRD_RESULT_OK) return result;
    if (width == vk->width && height == vk->height) return NRD_RESULT_OK;
    memset(vk->bound, 0, (size_t)vk->slots * vk->info->pass_count * vk->max_bindings * sizeof *vk->bound); /* handles may come again */
    if (!vk->cleared && vk->last && vk->last->width == width && vk->last->height == height) return nrdi_vk_return_to_last(vk);
    nrdi_vk_former *former = nrdi_vk_allocate_former(vk);
    if (!former) return nrdi_vk_fail(vk->desc.instance, NRD_RESULT_OUT_OF_MEMORY, "nrd_vk_resize: the allocator returned NULL");
    nrdi_vk_put_aside(vk, former);
    result = nrdi_vk_make_images(vk, width, height);
    if (result != NRD_RESULT_OK) {
        nrdi_vk_destroy_images(vk, vk->images + NRD_RESOURCE_COUNT, vk->memory);
        nrdi_vk_take_back(vk, former);
        nrdi_vk_release(vk, former);
        nrd_resize(vk->desc.instance, vk->width, vk->height);
        return result;
    }
    vk->width = width;
    vk->height = height;
    former->next = vk->former;
    vk->former = former;
    if (vk->cleared) vk->last = former;
    else nrdi_vk_destroy_former(vk, &vk->former); /* nothing was ever recorded with these */
    vk->cleared = false;
    return NRD_RESULT_OK;
}

/* Before recording with a slot. What was recorded with it last has finished if one of the denoisers comes again. */
static void nrdi_vk_destroy_unused(nrd_vk *vk, uint32_t slot, const nrd_dispatch *dispatches, uint32_t count)
{
    uint64_t denoisers = 0;
    bool reads_last = !vk->cleared; /* the first recording after a resize is the first that needs them no longer */
    for (uint32_t i = 0; i < count; i++) {
        denoisers |= (uint64_t)1 << vk->info->passes[dispatches[i].pass].denoiser;
        for (uint32_t j = 0; j < dispatches[i].binding_count; j++) reads_last |= dispatches[i].bindings[j].before_resize;
    }
    for (nrdi_vk_former **at = &vk->former; *at;) {
        nrdi_vk_former *former = *at;
        if (former == vk->last && reads_last) {
            former->slot = slot;
            former->denoisers = denoisers;
        } else if (former->slot == slot && (former->denoisers & denoisers)) {
            nrdi_vk_destroy_former(vk, at);
            continue;
        } else if (former->slot == slot) former->denoisers |= denoisers;
        at = &former->next;
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   User images  >>user */
/* Integer formats need another sampler type, depth formats another aspect. */
static bool nrdi_vk_is_integer_or_depth(VkFormat format)
{
    switch (format) {
    case VK_FORMAT_R8_UINT: case VK_FORMAT_R8_SINT: case VK_FORMAT_R8G8_UINT: case VK_FORMAT_R8G8_SINT:
    case VK_FORMAT_R8G8B8A8_UINT: case VK_FORMAT_R8G8B8A8_SINT: case VK_FORMAT_A2B10G10R10_UINT_PACK32:
    case VK_FORMAT_R16_UINT: case VK_FORMAT_R16_SINT: case VK_FORMAT_R16G16_UINT: case VK_FORMAT_R16G16_SINT:
    case VK_FORMAT_R16G16B16A16_UINT: case VK_FORMAT_R16G16B16A16_SINT: case VK_FORMAT_R32_UINT: case VK_FORMAT_R32_SINT:
    case VK_FORMAT_R32G32_UINT: case VK_FORMAT_R32G32_SINT: case VK_FORMAT_R32G32B32A32_UINT: case VK_FORMAT_R32G32B32A32_SINT:
    case VK_FORMAT_D16_UNORM: case VK_FORMAT_X8_D24_UNORM_PACK32: case VK_FORMAT_D32_SFLOAT: case VK_FORMAT_S8_UINT:
    case VK_FORMAT_D16_UNORM_S8_UINT: case VK_FORMAT_D24_UNORM_S8_UINT: case VK_FORMAT_D32_SFLOAT_S8_UINT:
        return true;
    default:
        return false;
    }
}

static VkFormatFeatureFlags nrdi_vk_features(nrd_vk *vk, nrd_resource resource, VkFormat format)
{
    VkFormatProperties has;
    if (vk->known_format[resource] == format) return vk->known_features[resource];
    vk->physical.vkGetPhysicalDeviceFormatProperties(vk->physical.device, format, &has);
    vk->known_format[resource] = format;
    vk->known_features[resource] = has.optimalTilingFeatures;
    return has.optimalTilingFeatures;
}

static nrd_result nrdi_vk_check_format(nrd_vk *vk, const nrd_vk_image *given)
{
    VkFormat wanted = nrd_vk_format(nrd_resource_format(given->resource));
    nrdi_vk_text t = nrdi_vk_say(nrd_resource_name(given->resource));
    nrdi_vk_add(&t, ": format");
    if (wanted != VK_FORMAT_UNDEFINED && given->format != wanted)
        return nrdi_vk_fail_value(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, t.text, given->format, ", needed is VkFormat ", wanted);
    if (nrdi_vk_is_integer_or_depth(given->format) || !(nrdi_vk_features(vk, given->resource, given->format) & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT))
        return nrdi_vk_fail_value(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, t.text, given->format,
                                  ", needed is a float or normalised colour format with feature bit ", VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT);
    return NRD_RESULT_OK;
}

static nrd_result nrdi_vk_check_usage(const nrd *instance, const nrd_vk_image *given)
{
    bool output = nrd_resource_format(given->resource) != NRD_FORMAT_ANY;
    VkImageUsageFlags needed = VK_IMAGE_USAGE_SAMPLED_BIT | (output ? (VkImageUsageFlags)VK_IMAGE_USAGE_STORAGE_BIT : 0);
    if (!given->usage || !(needed & ~given->usage)) return NRD_RESULT_OK;
    nrdi_vk_text t = nrdi_vk_say(nrd_resource_name(given->resource));
    nrdi_vk_add(&t, ": usage");
    return nrdi_vk_fail_value(instance, NRD_RESULT_INVALID_ARGUMENT, t.text, given->usage,
                              output ? ", needed are SAMPLED and STORAGE, VkImageUsageFlags " : ", needed is SAMPLED, VkImageUsageFlags ", needed);
}

static bool nrdi_vk_given_twice(const nrd_vk_frame *frame, uint32_t index)
{
    const nrd_vk_image *a = &frame->images[index];
    for (uint32_t i = 0; i < index; i++) {
        const nrd_vk_image *b = &frame->images[i];
        if (a->resource == b->resource || (a->image == b->image && a->mip == b->mip && a->layer == b->layer)) return true;
    }
    return false;
}

static nrd_result nrdi_vk_check_image(nrd_vk *vk, const nrd_vk_frame *frame, uint32_t index)
{
    const nrd_vk_image *given = &frame->images[index];
    const nrd *instance = vk->desc.instance;
    const char *wrong = NULL;
    if ((uint32_t)given->resource >= NRD_RESOURCE_COUNT)
        return nrdi_vk_fail_value(instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_image.resource", given->resource, ", allowed is 0 to ", NRD_RESOURCE_COUNT - 1);
    if (!given->image) wrong = ": image is VK_NULL_HANDLE";
    else if (!given->view) wrong = ": view is VK_NULL_HANDLE";
    else if (nrdi_vk_given_twice(frame, index)) wrong = ": the resource or its image is in the list twice";
    else if (given->layout_in == VK_IMAGE_LAYOUT_UNDEFINED && nrd_resource_format(given->resource) == NRD_FORMAT_ANY)
        wrong = ": layout_in is UNDEFINED, which would discard the input";
    if (wrong) return nrdi_vk_fail_resource(instance, NRD_RESULT_INVALID_ARGUMENT, given->resource, wrong);
    nrd_result result = nrdi_vk_check_usage(instance, given);
    return result == NRD_RESULT_OK ? nrdi_vk_check_format(vk, given) : result;
}

static VkImageLayout nrdi_vk_working_layout(const nrd_vk_image *given)
{
    if (nrd_resource_format(given->resource) != NRD_FORMAT_ANY || given->layout_in == VK_IMAGE_LAYOUT_GENERAL) return VK_IMAGE_LAYOUT_GENERAL;
    return VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
}

static void nrdi_vk_take_image(nrd_vk *vk, const nrd_vk_image *given)
{
    nrdi_vk_image *image = &vk->images[given->resource];
    memset(image, 0, sizeof *image);
    image->image = given->image;
    image->view = given->view;
    image->format = given->format;
    image->width = given->width;
    image->height = given->height;
    image->mip = given->mip;
    image->layer = given->layer;
    image->layout = nrdi_vk_working_layout(given);
    image->layout_out = given->layout_out != VK_IMAGE_LAYOUT_UNDEFINED ? given->layout_out : given->layout_in;
    if (image->layout_out == VK_IMAGE_LAYOUT_UNDEFINED) image->layout_out = image->layout;
    image->present = true;
}

static nrd_result nrdi_vk_take_images(nrd_vk *vk, const nrd_vk_frame *frame)
{
    memset(vk->images, 0, NRD_RESOURCE_COUNT * sizeof *vk->images);
    if (frame->image_count && !frame->images)
        return nrdi_vk_fail_value(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_frame.images is NULL: image_count", frame->image_count, ", allowed is then ", 0);
    for (uint32_t i = 0; i < frame->image_count; i++) {
        nrd_result result = nrdi_vk_check_image(vk, frame, i);
        if (result != NRD_RESULT_OK) return result;
        nrdi_vk_take_image(vk, &frame->images[i]);
    }
    return NRD_RESULT_OK;
}

static nrdi_vk_image *nrdi_vk_image_of(nrd_vk *vk, const nrd_binding *binding)
{
    if (binding->before_resize && vk->last) return &vk->last->images[binding->texture];
    return &vk->images[binding->resource == NRD_RESOURCE_INTERNAL ? NRD_RESOURCE_COUNT + binding->texture : (uint32_t)binding->resource];
}

static nrd_result nrdi_vk_fail_missing(const nrd *instance, const nrd_dispatch *dispatch, nrd_resource resource)
{
    nrdi_vk_text t = nrdi_vk_say(nrd_resource_name(resource));
    nrdi_vk_add(&t, " is needed by pass \"");
    nrdi_vk_add(&t, dispatch->name);
    nrdi_vk_add(&t, "\" and is not in nrd_vk_frame.images");
    return nrdi_vk_fail(instance, NRD_RESULT_MISSING_RESOURCE, t.text);
}

static nrd_result nrdi_vk_check_size(const nrd *instance, nrd_resource resource, const char *side, uint32_t has, uint32_t needed)
{
    if (has == needed) return NRD_RESULT_OK;
    nrdi_vk_text t = nrdi_vk_say(nrd_resource_name(resource));
    nrdi_vk_add(&t, side);
    return nrdi_vk_fail_value(instance, NRD_RESULT_INVALID_ARGUMENT, t.text, has, ", needed is ", needed);
}

/* What is read linearly is read by uv, so it may have any size. */
static nrd_result nrdi_vk_check_binding(nrd_vk *vk, const nrd_dispatch *dispatch, const nrd_binding *binding)
{
    const nrdi_vk_image *image = nrdi_vk_image_of(vk, binding);
    const nrd *instance = vk->desc.instance;
    if (binding->resource == NRD_RESOURCE_INTERNAL) return NRD_RESULT_OK;
    if (!image->present) return nrdi_vk_fail_missing(instance, dispatch, binding->resource);
    if (binding->access == NRD_ACCESS_READ_LINEAR) {
        if (nrdi_vk_features(vk, binding->resource, image->format) & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT) return NRD_RESULT_OK;
        return nrdi_vk_fail_resource(instance, NRD_RESULT_INVALID_ARGUMENT, binding->resource, ": the device cannot filter its format linearly");
    }
    if (binding->half_width && image->width == (vk->info->width + 1) / 2) return nrdi_vk_check_size(instance, binding->resource, ": height", image->height, vk->info->height);
    nrd_result result = nrdi_vk_check_size(instance, binding->resource, ": width", image->width, vk->info->width);
    return result == NRD_RESULT_OK ? nrdi_vk_check_size(instance, binding->resource, ": height", image->height, vk->info->height) : result;
}

static nrd_result nrdi_vk_check_bindings(nrd_vk *vk, const nrd_dispatch *dispatches, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t j = 0; j < dispatches[i].binding_count; j++) {
            nrd_result result = nrdi_vk_check_binding(vk, &dispatches[i], &dispatches[i].bindings[j]);
            if (result != NRD_RESULT_OK) return result;
        }
    return NRD_RESULT_OK;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Barriers  >>barriers
   Every dispatch has a number (nrd_vk.now). An image remembers the last that read and wrote it; executed_at and visible_at are
   the numbers up to which barriers have ordered dispatches and made their writes visible. One memory barrier covers all
   images (caches are flushed as a whole anyway); image barriers serve only to change layouts. */
static void nrdi_vk_transition(nrd_vk *vk, const nrdi_vk_image *image, VkImageLayout from, VkImageLayout to)
{
    VkImageMemoryBarrier *b = &vk->barriers[vk->batch.image_count++];
    memset(b, 0, sizeof *b);
    b->sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    b->oldLayout = from;
    b->newLayout = to;
    b->srcQueueFamilyIndex = b->dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    b->image = image->image;
    b->subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
    b->subresourceRange.baseMipLevel = image->mip;
    b->subresourceRange.baseArrayLayer = image->layer;
    b->subresourceRange.levelCount = b->subresourceRange.layerCount = 1;
}

static void nrdi_vk_flush(nrd_vk *vk, VkCommandBuffer cmd)
{
    nrdi_vk_batch *batch = &vk->batch;
    NRDI_VK_STRUCT(VkMemoryBarrier, memory, VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    if (!batch->from) return;
    memory.srcAccessMask = batch->from_access;
    memory.dstAccessMask = batch->to_access;
    for (uint32_t i = 0; i < batch->image_count; i++) {
        vk->barriers[i].srcAccessMask = batch->from_access;
        vk->barriers[i].dstAccessMask = batch->to_access;
    }
    vk->fn.vkCmdPipelineBarrier(cmd, batch->from, batch->to, 0, batch->to_access ? 1 : 0, &memory, 0, NULL, batch->image_count, vk->barriers);
    vk->executed_at = vk->now;
    if (batch->to_access) vk->visible_at = vk->now;
    memset(batch, 0, sizeof *batch);
}

/* Numbers of groups are read before the shader runs. */
static void nrdi_vk_need_execution(nrdi_vk_batch *batch)
{
    batch->from |= VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
    batch->to |= VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
}

static void nrdi_vk_need_memory(nrdi_vk_batch *batch)
{
    nrdi_vk_need_execution(batch);
    batch->from_access |= VK_ACCESS_SHADER_WRITE_BIT;
    batch->to_access |= VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_UNIFORM_READ_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT;
}

static bool nrdi_vk_writes(nrd_access access) { return access == NRD_ACCESS_WRITE || access == NRD_ACCESS_BUFFER; }

static void nrdi_vk_need(nrd_vk *vk, nrdi_vk_image *image, nrd_access access)
{
    if (image->transient && !image->present) { /* its memory may hold another image until now */
        nrdi_vk_transition(vk, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
        nrdi_vk_need_memory(&vk->batch);
        image->present = true;
    }
    if (image->written_at > vk->visible_at) nrdi_vk_need_memory(&vk->batch);
    if (nrdi_vk_writes(access) && image->read_at > vk->executed_at) nrdi_vk_need_execution(&vk->batch);
}

/* The first recording ever: permanent images get zeros, so that nothing reads what the memory happened to hold. */
static void nrdi_vk_clear_permanent(nrd_vk *vk, VkCommandBuffer cmd)
{
    VkClearColorValue zero;
    VkImageSubresourceRange range = { VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1 };
    nrdi_vk_image *images = vk->images + NRD_RESOURCE_COUNT;
    memset(&zero, 0, sizeof zero);
    for (uint32_t i = 0; i < vk->info->texture_count; i++)
        if (images[i].image && !images[i].transient) nrdi_vk_transition(vk, &images[i], VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    vk->batch.from = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT; /* the app's memory may have been used by others before */
    vk->batch.from_access = VK_ACCESS_MEMORY_WRITE_BIT;
    vk->batch.to = VK_PIPELINE_STAGE_TRANSFER_BIT;
    vk->batch.to_access = VK_ACCESS_TRANSFER_WRITE_BIT;
    nrdi_vk_flush(vk, cmd);
    for (uint32_t i = 0; i < vk->info->texture_count; i++)
        if (images[i].image && !images[i].transient) vk->fn.vkCmdClearColorImage(cmd, images[i].image, VK_IMAGE_LAYOUT_GENERAL, &zero, 1, &range);
    vk->batch.from = VK_PIPELINE_STAGE_TRANSFER_BIT;
    vk->batch.from_access = VK_ACCESS_TRANSFER_WRITE_BIT;
    vk->cleared = true;
}

/* Left in the batch, so that it goes out together with what the first dispatch needs. */
static void nrdi_vk_begin(nrd_vk *vk, VkCommandBuffer cmd, const nrd_vk_frame *frame)
{
    memset(&vk->batch, 0, sizeof vk->batch);
    if (!vk->cleared) nrdi_vk_clear_permanent(vk, cmd);
    nrdi_vk_need_memory(&vk->batch);
    vk->batch.from |= frame->before_stages ? frame->before_stages : (VkPipelineStageFlags)VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    vk->batch.from_access |= frame->before_stages ? frame->before_access : (VkAccessFlags)VK_ACCESS_MEMORY_WRITE_BIT;
    for (uint32_t i = 0; i < frame->image_count; i++) {
        const nrdi_vk_image *image = &vk->images[frame->images[i].resource];
        if (frame->images[i].layout_in != image->layout) nrdi_vk_transition(vk, image, frame->images[i].layout_in, image->layout);
    }
    for (uint32_t i = 0; i < vk->info->texture_count; i++) vk->images[NRD_RESOURCE_COUNT + i].present = false;
}

static void nrdi_vk_end(nrd_vk *vk, VkCommandBuffer cmd, const nrd_vk_frame *frame)
{
    nrdi_vk_flush(vk, cmd); /* no dispatch has done so, if there was none */
    nrdi_vk_batch *batch = &vk->batch;
    batch->from = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    batch->from_access = VK_ACCESS_SHADER_WRITE_BIT;
    batch->to = frame->after_stages ? frame->after_stages : (VkPipelineStageFlags)VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    batch->to_access = frame->after_stages ? frame->after_access : (VkAccessFlags)(VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT);
    for (uint32_t i = 0; i < frame->image_count; i++) {
        const nrdi_vk_image *image = &vk->images[frame->images[i].resource];
        if (image->layout_out != image->layout) nrdi_vk_transition(vk, image, image->layout, image->layout_out);
    }
    nrdi_vk_flush(vk, cmd);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Recording  >>record */
static void nrdi_vk_update_buffer(nrd_vk *vk, uint32_t set, uint32_t binding, const nrd_binding *from)
{
    VkDescriptorBufferInfo buffer = { vk->constants, nrdi_vk_groups_of(vk, from->texture), vk->info->textures[from->texture].bytes };
    NRDI_VK_STRUCT(VkWriteDescriptorSet, write, VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    write.dstSet = vk->sets[set];
    write.dstBinding = binding;
    write.descriptorCount = 1;
    write.descriptorType = nrdi_vk_descriptor_type(from->access);
    write.pBufferInfo = &buffer;
    vk->fn.vkUpdateDescriptorSets(vk->desc.device, 1, &write, 0, NULL);
}

static void nrdi_vk_update_set(nrd_vk *vk, uint32_t set, const nrd_dispatch *dispatch)
{
    const nrd_pipeline *pipeline = &vk->info->pipelines[dispatch->pipeline];
    uint32_t count = 0;
    for (uint32_t i = 0; i < dispatch->binding_count; i++) {
        if (dispatch->bindings[i].access >= NRD_ACCESS_BUFFER) {
            nrdi_vk_update_buffer(vk, set, i + 1, &dispatch->bindings[i]);
            continue;
        }
        const nrdi_vk_image *image = nrdi_vk_image_of(vk, &dispatch->bindings[i]);
        VkImageView *bound = &vk->bound[(size_t)set * vk->max_bindings + i];
        /* a new view of the app may have the handle of a destroyed one, so only our own are compared */
        if (dispatch->bindings[i].resource == NRD_RESOURCE_INTERNAL && *bound == image->view) continue;
        *bound = image->view;
        VkDescriptorImageInfo *info = &vk->image_infos[count];
        info->sampler = VK_NULL_HANDLE;
        info->imageView = image->view;
        info->imageLayout = image->layout;
        VkWriteDescriptorSet *write = &vk->writes[count++];
        memset(write, 0, sizeof *write);
        write->sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        write->dstSet = vk->sets[set];
        write->dstBinding = i + 1;
        write->descriptorCount = 1;
        write->descriptorType = nrdi_vk_descriptor_type(pipeline->access[i]);
        write->pImageInfo = info;
    }
    if (count) vk->fn.vkUpdateDescriptorSets(vk->desc.device, count, vk->writes, 0, NULL);
}

static void nrdi_vk_synchronise(nrd_vk *vk, VkCommandBuffer cmd, const nrd_dispatch *dispatch)
{
    nrdi_vk_image *groups = dispatch->indirect ? &vk->images[NRD_RESOURCE_COUNT + dispatch->indirect - 1] : NULL;
    for (uint32_t i = 0; i < dispatch->binding_count; i++) nrdi_vk_need(vk, nrdi_vk_image_of(vk, &dispatch->bindings[i]), dispatch->bindings[i].access);
    if (groups) nrdi_vk_need(vk, groups, NRD_ACCESS_READ);
    nrdi_vk_flush(vk, cmd);
    vk->now++;
    for (uint32_t i = 0; i < dispatch->binding_count; i++) {
        nrdi_vk_image *image = nrdi_vk_image_of(vk, &dispatch->bindings[i]);
        if (nrdi_vk_writes(dispatch->bindings[i].access)) image->written_at = vk->now;
        else image->read_at = vk->now;
    }
    if (groups) groups->read_at = vk->now;
}

static void nrdi_vk_label(const nrd_vk *vk, VkCommandBuffer cmd, const char *name)
{
    NRDI_VK_STRUCT(VkDebugUtilsLabelEXT, label, VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT);
    label.pLabelName = name;
    if (vk->begin_label && vk->end_label) vk->begin_label(cmd, &label);
}

static void nrdi_vk_timestamp(nrd_vk *vk, VkCommandBuffer cmd, uint32_t query)
{
    if (vk->queries) vk->fn.vkCmdWriteTimestamp(cmd, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, vk->queries, query);
}

/* set: index of the descriptor set, slot * pass_count + pass. */
static void nrdi_vk_dispatch(nrd_vk *vk, VkCommandBuffer cmd, uint32_t set, const nrd_dispatch *dispatch, uint32_t constant_offset)
{
    const nrdi_vk_pipeline *pipeline = &vk->pipelines[dispatch->pipeline];
    nrdi_vk_label(vk, cmd, dispatch->name);
    nrdi_vk_update_set(vk, set, dispatch);
    nrdi_vk_synchronise(vk, cmd, dispatch);
    nrdi_vk_timestamp(vk, cmd, 2 * set);
    vk->fn.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->pipeline);
    vk->fn.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->layout, 0, 1, &vk->sets[set], 1, &constant_offset);
    vk->fn.vkCmdPushConstants(cmd, pipeline->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof dispatch->push, dispatch->push);
    if (dispatch->indirect) vk->fn.vkCmdDispatchIndirect(cmd, vk->constants, nrdi_vk_groups_of(vk, dispatch->indirect - 1) + dispatch->indirect_offset);
    else vk->fn.vkCmdDispatch(cmd, dispatch->groups_x, dispatch->groups_y, 1);
    nrdi_vk_timestamp(vk, cmd, 2 * set + 1);
    if (vk->begin_label && vk->end_label) vk->end_label(cmd);
}

/* Behind a dispatch that counts: its counters go to the host's memory. */
static void nrdi_vk_read_back(nrd_vk *vk, VkCommandBuffer cmd, uint32_t slot, const nrd_dispatch *dispatch)
{
    uint32_t i = 0, place = slot * vk->info->denoiser_count + vk->info->passes[dispatch->pass].denoiser;
    VkBufferImageCopy region;
    while (i < dispatch->binding_count && !(dispatch->bindings[i].resource == NRD_RESOURCE_INTERNAL && vk->info->textures[dispatch->bindings[i].texture].read_back)) i++;
    if (i == dispatch->binding_count) return;
    nrdi_vk_need_memory(&vk->batch);
    vk->batch.to |= VK_PIPELINE_STAGE_TRANSFER_BIT;
    vk->batch.to_access |= VK_ACCESS_TRANSFER_READ_BIT;
    nrdi_vk_flush(vk, cmd);
    memset(&region, 0, sizeof region);
    region.bufferOffset = vk->counters_at + (VkDeviceSize)place * NRDI_VK_COUNTER_BYTES;
    region.imageSubresource.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
    region.imageSubresource.layerCount = 1;
    region.imageExtent.width = NRD_COUNTER_COUNT;
    region.imageExtent.height = region.imageExtent.depth = 1;
    vk->fn.vkCmdCopyImageToBuffer(cmd, nrdi_vk_image_of(vk, &dispatch->bindings[i])->image, VK_IMAGE_LAYOUT_GENERAL, vk->constants, 1, &region);
    vk->batch.from = VK_PIPELINE_STAGE_TRANSFER_BIT; /* the next frame clears what was copied */
    vk->batch.from_access = VK_ACCESS_TRANSFER_WRITE_BIT;
    vk->batch.to = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_HOST_BIT;
    vk->batch.to_access = VK_ACCESS_HOST_READ_BIT;
    nrdi_vk_flush(vk, cmd);
    vk->counted[place] = true;
}

static void nrdi_vk_reset_queries(nrd_vk *vk, VkCommandBuffer cmd, uint32_t slot, const nrd_dispatch *dispatches, uint32_t count)
{
    const nrd_info *info = vk->info;
    for (uint32_t i = 0; i < count && vk->queries; i++) {
        uint32_t denoiser = info->passes[dispatches[i].pass].denoiser;
        if (i && info->passes[dispatches[i - 1].pass].denoiser == denoiser) continue;
        for (uint32_t pass = 0; pass < info->pass_count; pass++) {
            uint32_t set = slot * info->pass_count + pass;
            if (info->passes[pass].denoiser != denoiser) continue;
            vk->fn.vkCmdResetQueryPool(cmd, vk->queries, 2 * set, 2);
            vk->timed[set] = false;
        }
    }
}

static void nrdi_vk_run(nrd_vk *vk, VkCommandBuffer cmd, uint32_t slot, const nrd_dispatch *dispatches, uint32_t count)
{
    char *ring = (char *)vk->memory[NRD_VK_MEMORY_CONSTANTS].mapped;
    VkDeviceSize offset = 0;
    nrdi_vk_reset_queries(vk, cmd, slot, dispatches, count);
    for (uint32_t i = 0; i < count; i++) {
        const nrd_dispatch *dispatch = &dispatches[i];
        uint32_t set = slot * vk->info->pass_count + dispatch->pass;
        if (i == 0 || dispatch->constants != dispatches[i - 1].constants) {
            offset = set * vk->constant_stride;
            memcpy(ring + offset, dispatch->constants, vk->info->constant_bytes);
        }
        nrdi_vk_dispatch(vk, cmd, set, dispatch, (uint32_t)offset);
        nrdi_vk_read_back(vk, cmd, slot, dispatch);
        vk->timed[set] = vk->queries != VK_NULL_HANDLE;
    }
}

nrd_result nrd_vk_record(nrd_vk *vk, VkCommandBuffer cmd, const nrd_vk_frame *frame)
{
    const nrd_dispatch *dispatches = NULL;
    uint32_t count = 0;
    nrd_result result = nrdi_vk_check_alive(vk);
    if (result != NRD_RESULT_OK) return result;
    if (!cmd || !frame) return nrdi_vk_fail(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_record: cmd or frame is NULL");
    if (frame->slot >= vk->slots)
        return nrdi_vk_fail_value(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_frame.slot", frame->slot, ", allowed is 0 to ", vk->slots - 1);
    if (vk->width != vk->info->width || vk->height != vk->info->height)
        return nrdi_vk_fail(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_record: nrd_resize has changed the size; call nrd_vk_resize instead");
    result = nrdi_vk_take_images(vk, frame);
    if (result == NRD_RESULT_OK) result = nrd_get_dispatches(vk->desc.instance, frame->identifiers, frame->identifier_count, &dispatches, &count);
    if (result != NRD_RESULT_OK) return result;
    result = nrdi_vk_check_bindings(vk, dispatches, count);
    if (result != NRD_RESULT_OK) {
        nrd_cancel_dispatches(vk->desc.instance);
        return result;
    }
    nrdi_vk_destroy_unused(vk, frame->slot, dispatches, count);
    nrdi_vk_begin(vk, cmd, frame);
    nrdi_vk_run(vk, cmd, frame->slot, dispatches, count);
    nrdi_vk_end(vk, cmd, frame);
    return NRD_RESULT_OK;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Timings  >>timings */
nrd_result nrd_vk_timings(const nrd_vk *vk, uint32_t slot, nrd_vk_timing *timings, uint32_t capacity, uint32_t *count)
{
    nrd_result result = nrdi_vk_check_alive(vk);
    if (result != NRD_RESULT_OK) return result;
    if (!count || (capacity && !timings)) return nrdi_vk_fail(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_timings: timings or count is NULL");
    if (slot >= vk->slots) return nrdi_vk_fail_value(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_timings: slot", slot, ", allowed is 0 to ", vk->slots - 1);
    *count = 0;
    for (uint32_t pass = 0; pass < vk->info->pass_count; pass++) {
        uint32_t set = slot * vk->info->pass_count + pass;
        uint64_t ticks[2];
        if (!vk->timed[set] || *count == capacity) continue;
        VkResult got = vk->fn.vkGetQueryPoolResults(vk->desc.device, vk->queries, 2 * set, 2, sizeof ticks, ticks, sizeof ticks[0], VK_QUERY_RESULT_64_BIT);
        if (got == VK_NOT_READY) continue;
        if (got != VK_SUCCESS) return nrdi_vk_try(vk->desc.instance, got, "vkGetQueryPoolResults");
        nrd_vk_timing *timing = &timings[(*count)++];
        timing->name = vk->info->passes[pass].name;
        timing->pass = pass;
        timing->nanoseconds = (double)((ticks[1] - ticks[0]) & vk->tick_mask) * vk->tick_ns;
    }
    return NRD_RESULT_OK;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Input checker  >>counters */
nrd_result nrd_vk_counters(const nrd_vk *vk, uint32_t slot, uint32_t identifier, uint64_t *counters)
{
    uint32_t found = 0, place;
    if (!vk) return NRD_RESULT_INVALID_ARGUMENT;
    if (!counters) return nrdi_vk_fail(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_counters: counters is NULL");
    if (slot >= vk->slots) return nrdi_vk_fail_value(vk->desc.instance, NRD_RESULT_INVALID_ARGUMENT, "nrd_vk_counters: slot", slot, ", allowed is 0 to ", vk->slots - 1);
    while (found < vk->info->denoiser_count && vk->info->denoisers[found].identifier != identifier) found++;
    if (found == vk->info->denoiser_count)
        return nrdi_vk_fail_value(vk->desc.instance, NRD_RESULT_UNKNOWN_DENOISER, "nrd_vk_counters: no denoiser has this identifier: it", identifier, ", denoisers: ", found);
    place = slot * vk->info->denoiser_count + found;
    if (!vk->counted[place]) return NRD_RESULT_OK;
    const char *from = (const char *)vk->memory[NRD_VK_MEMORY_CONSTANTS].mapped + vk->counters_at + (size_t)place * NRDI_VK_COUNTER_BYTES;
    for (uint32_t i = 0; i < NRD_COUNTER_COUNT; i++) {
        uint32_t counter;
        memcpy(&counter, from + 4 * i, 4);
        counters[i] += counter;
    }
    return NRD_RESULT_OK;
}

#endif /* NRD_VK_IMPLEMENTED */
#endif /* NRD_VK_IMPLEMENTATION */
