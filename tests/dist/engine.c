/* The smallest engine: a device, images of one colour, four denoised frames. Valid C99, C11 and C++17. How it reaches Vulkan is chosen
   by one of ENGINE_VOLK, ENGINE_PROTOTYPES (linked with the loader) or neither (VK_NO_PROTOTYPES, the loader opened at run time).
   Prints what it saw; exits 0 if the output is the input, as it must be for a constant. */
#if defined(ENGINE_NVIDIA)
#include "nvidia_names.h"
#endif

#if defined(ENGINE_VOLK)
#define VOLK_IMPLEMENTATION
#include <volk.h>
#elif defined(ENGINE_PROTOTYPES)
#include <vulkan/vulkan.h>
#else
#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>
#include <dlfcn.h>
#endif

#if !defined(ENGINE_TWO_FILES) /* implementation.c has it then */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#endif
#include "nrd_vk.h"
#include "nrd_shaders/nrd_c.h"

#include <stdio.h>
#include <string.h>

#if !defined(ENGINE_VOLK) && !defined(ENGINE_PROTOTYPES)
#define ENGINE_FUNCTIONS(X) \
    X(vkCreateInstance) X(vkDestroyInstance) X(vkEnumeratePhysicalDevices) X(vkGetPhysicalDeviceMemoryProperties) X(vkCreateDevice) X(vkDestroyDevice) \
    X(vkGetDeviceQueue) X(vkDeviceWaitIdle) X(vkQueueSubmit) X(vkQueueWaitIdle) X(vkCreateCommandPool) X(vkDestroyCommandPool) X(vkAllocateCommandBuffers) \
    X(vkBeginCommandBuffer) X(vkEndCommandBuffer) X(vkCreateImage) X(vkDestroyImage) X(vkGetImageMemoryRequirements) X(vkBindImageMemory) \
    X(vkCreateImageView) X(vkDestroyImageView) X(vkCreateBuffer) X(vkDestroyBuffer) X(vkGetBufferMemoryRequirements) X(vkBindBufferMemory) \
    X(vkAllocateMemory) X(vkFreeMemory) X(vkMapMemory) X(vkCmdPipelineBarrier) X(vkCmdClearColorImage) X(vkCmdCopyImageToBuffer)
#define ENGINE_POINTER(name) static PFN_##name name;
ENGINE_FUNCTIONS(ENGINE_POINTER)
static PFN_vkGetInstanceProcAddr vkGetInstanceProcAddr;
#endif

enum { WIDTH = 64, HEIGHT = 48, IMAGES = 5, FRAMES = 4 };
static const float light = 0.5f;

static VkInstance vulkan;
static VkPhysicalDevice physical;
static VkDevice device;
static VkQueue queue;
static VkCommandPool pool;
static VkCommandBuffer cmd;

static int failed(const char *what)
{
    printf("engine: %s failed\n", what);
    return 0;
}

/* ---- Vulkan -------------------------------------------------------------------------------------------------------------------- */
static int load_before_instance(void)
{
#if defined(ENGINE_VOLK)
    return volkInitialize() == VK_SUCCESS;
#elif defined(ENGINE_PROTOTYPES)
    return 1;
#else
    void *loader = dlopen("libvulkan.so.1", RTLD_NOW), *symbol = loader ? dlsym(loader, "vkGetInstanceProcAddr") : NULL;
    memcpy(&vkGetInstanceProcAddr, &symbol, sizeof symbol);
    if (!symbol) return 0;
    vkCreateInstance = (PFN_vkCreateInstance)vkGetInstanceProcAddr(NULL, "vkCreateInstance");
    return vkCreateInstance != NULL;
#endif
}

static int load_after_instance(void)
{
#if defined(ENGINE_VOLK)
    volkLoadInstance(vulkan);
#elif !defined(ENGINE_PROTOTYPES)
#define ENGINE_LOAD(name) name = (PFN_##name)vkGetInstanceProcAddr(vulkan, #name); if (!name) return 0;
    ENGINE_FUNCTIONS(ENGINE_LOAD)
#endif
    return 1;
}

#define VK_STRUCT(type, name, s_type) type name; memset(&name, 0, sizeof name); name.sType = s_type

static int open_vulkan(void)
{
    VK_STRUCT(VkApplicationInfo, app, VK_STRUCTURE_TYPE_APPLICATION_INFO);
    VK_STRUCT(VkInstanceCreateInfo, instance_info, VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
    VK_STRUCT(VkDeviceQueueCreateInfo, queue_info, VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
    VK_STRUCT(VkDeviceCreateInfo, device_info, VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
    VK_STRUCT(VkCommandPoolCreateInfo, pool_info, VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    VK_STRUCT(VkCommandBufferAllocateInfo, cmd_info, VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    const float priority = 1;
    uint32_t one = 1;
    pool_info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    app.apiVersion = VK_API_VERSION_1_1;
    instance_info.pApplicationInfo = &app;
    if (!load_before_instance() || vkCreateInstance(&instance_info, NULL, &vulkan) != VK_SUCCESS || !load_after_instance()) return failed("vkCreateInstance");
    if (vkEnumeratePhysicalDevices(vulkan, &one, &physical) < VK_SUCCESS || !physical) return failed("vkEnumeratePhysicalDevices");
    queue_info.queueCount = 1;
    queue_info.pQueuePriorities = &priority;
    device_info.queueCreateInfoCount = 1;
    device_info.pQueueCreateInfos = &queue_info;
    if (vkCreateDevice(physical, &device_info, NULL, &device) != VK_SUCCESS) return failed("vkCreateDevice");
    vkGetDeviceQueue(device, 0, 0, &queue);
    if (vkCreateCommandPool(device, &pool_info, NULL, &pool) != VK_SUCCESS) return failed("vkCreateCommandPool");
    cmd_info.commandPool = pool;
    cmd_info.commandBufferCount = 1;
    return vkAllocateCommandBuffers(device, &cmd_info, &cmd) == VK_SUCCESS || failed("vkAllocateCommandBuffers");
}

static VkDeviceMemory allocate(VkMemoryRequirements needs, VkMemoryPropertyFlags flags)
{
    VkPhysicalDeviceMemoryProperties has;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VK_STRUCT(VkMemoryAllocateInfo, info, VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    vkGetPhysicalDeviceMemoryProperties(physical, &has);
    info.allocationSize = needs.size;
    while (!(needs.memoryTypeBits >> info.memoryTypeIndex & 1) || (has.memoryTypes[info.memoryTypeIndex].propertyFlags & flags) != flags) info.memoryTypeIndex++;
    return vkAllocateMemory(device, &info, NULL, &memory) == VK_SUCCESS ? memory : VK_NULL_HANDLE;
}

static int begin(void)
{
    VK_STRUCT(VkCommandBufferBeginInfo, info, VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
    return vkBeginCommandBuffer(cmd, &info) == VK_SUCCESS;
}

static int submit(void)
{
    VK_STRUCT(VkSubmitInfo, info, VK_STRUCTURE_TYPE_SUBMIT_INFO);
    info.commandBufferCount = 1;
    info.pCommandBuffers = &cmd;
    return vkEndCommandBuffer(cmd) == VK_SUCCESS && vkQueueSubmit(queue, 1, &info, VK_NULL_HANDLE) == VK_SUCCESS && vkQueueWaitIdle(queue) == VK_SUCCESS;
}

/* ---- images -------------------------------------------------------------------------------------------------------------------- */
typedef struct picture { nrd_resource resource; VkFormat format; nrd_vec4 color; VkImage image; VkImageView view; VkDeviceMemory memory; } picture;

static picture pictures[IMAGES];

static picture make_picture(nrd_resource resource, VkFormat format, nrd_vec4 color)
{
    picture p;
    memset(&p, 0, sizeof p);
    p.resource = resource;
    p.format = format;
    p.color = color;
    return p;
}

static void describe_pictures(void)
{
    nrd_vec3 towards_camera = nrd_make_vec3(0, 0, -1);
    pictures[0] = make_picture(NRD_RESOURCE_IN_MV, VK_FORMAT_R16G16B16A16_SFLOAT, nrd_make_vec4(0, 0, 0, 0));
    pictures[1] = make_picture(NRD_RESOURCE_IN_NORMAL_ROUGHNESS, VK_FORMAT_A2B10G10R10_UNORM_PACK32, nrd_pack_normal_roughness(towards_camera, 1, 0));
    pictures[2] = make_picture(NRD_RESOURCE_IN_VIEWZ, VK_FORMAT_R32_SFLOAT, nrd_make_vec4(5, 0, 0, 0));
    pictures[3] = make_picture(NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, VK_FORMAT_R16G16B16A16_SFLOAT,
                               nrd_pack_radiance_hit_dist(nrd_make_vec3(light, light, light), 0.5f, true));
    pictures[4] = make_picture(NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST, VK_FORMAT_R16G16B16A16_SFLOAT, nrd_make_vec4(0, 0, 0, 0));
}

static int create_picture(picture *p)
{
    VkMemoryRequirements needs;
    VK_STRUCT(VkImageCreateInfo, image, VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
    VK_STRUCT(VkImageViewCreateInfo, view, VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    image.imageType = VK_IMAGE_TYPE_2D;
    image.format = p->format;
    image.extent.width = WIDTH;
    image.extent.height = HEIGHT;
    image.extent.depth = image.mipLevels = image.arrayLayers = 1;
    image.samples = VK_SAMPLE_COUNT_1_BIT;
    image.usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    if (nrd_resource_format(p->resource) != NRD_FORMAT_ANY) image.usage |= VK_IMAGE_USAGE_STORAGE_BIT;
    if (vkCreateImage(device, &image, NULL, &p->image) != VK_SUCCESS) return failed("vkCreateImage");
    vkGetImageMemoryRequirements(device, p->image, &needs);
    p->memory = allocate(needs, 0);
    if (!p->memory || vkBindImageMemory(device, p->image, p->memory, 0) != VK_SUCCESS) return failed("image memory");
    view.image = p->image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = p->format;
    view.subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
    view.subresourceRange.levelCount = view.subresourceRange.layerCount = 1;
    return vkCreateImageView(device, &view, NULL, &p->view) == VK_SUCCESS || failed("vkCreateImageView");
}

static void to_general(VkImage image)
{
    VK_STRUCT(VkImageMemoryBarrier, barrier, VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER);
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
    barrier.subresourceRange.levelCount = barrier.subresourceRange.layerCount = 1;
    vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, NULL, 0, NULL, 1, &barrier);
}

static int paint_pictures(void)
{
    describe_pictures();
    for (int i = 0; i < IMAGES; i++) if (!create_picture(&pictures[i])) return 0;
    if (!begin()) return failed("vkBeginCommandBuffer");
    for (int i = 0; i < IMAGES; i++) {
        VkImageSubresourceRange range = { VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1 };
        VkClearColorValue color;
        memcpy(color.float32, &pictures[i].color, sizeof color.float32);
        to_general(pictures[i].image);
        vkCmdClearColorImage(cmd, pictures[i].image, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
    }
    return submit() || failed("clearing");
}

/* ---- denoiser ------------------------------------------------------------------------------------------------------------------ */
static nrd *denoiser;
static nrd_vk *denoiser_vk;

static void print_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    (void)user;
    printf("nrd %s: %s (%s)\n", severity == NRD_SEVERITY_ERROR ? "error" : "warning", text, nrd_result_string(result));
}

static int create_denoiser(void)
{
    nrd_denoiser_desc list[1];
    nrd_desc desc;
    nrd_vk_desc vk;
    memset(list, 0, sizeof list);
    memset(&desc, 0, sizeof desc);
    memset(&vk, 0, sizeof vk);
    list[0].denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    desc.struct_version = NRD_STRUCT_VERSION;
    desc.width = WIDTH;
    desc.height = HEIGHT;
    desc.denoisers = list;
    desc.denoiser_count = 1;
    desc.message = print_message;
    if (nrd_create(&desc, &denoiser) != NRD_RESULT_OK) return failed("nrd_create");
    vk.struct_version = NRD_VK_STRUCT_VERSION;
    vk.instance = denoiser;
    vk.vk_instance = vulkan;
    vk.physical = physical;
    vk.device = device;
    vk.get_instance_proc = vkGetInstanceProcAddr;
    return nrd_vk_create(&vk, &denoiser_vk) == NRD_RESULT_OK || failed("nrd_vk_create");
}

static int denoise(uint32_t index)
{
    static const float projection[16] = { 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 1, 0, 0, -0.1f, 0 };
    nrd_frame frame = nrd_frame_defaults();
    nrd_vk_image images[IMAGES];
    nrd_vk_frame vk;
    memset(images, 0, sizeof images);
    memset(&vk, 0, sizeof vk);
    memcpy(frame.camera.view_to_clip, projection, sizeof projection);
    for (int i = 0; i < 4; i++) frame.camera.world_to_view[5 * i] = 1;
    frame.frame_index = index;
    for (int i = 0; i < IMAGES; i++) {
        images[i].resource = pictures[i].resource;
        images[i].image = pictures[i].image;
        images[i].view = pictures[i].view;
        images[i].format = pictures[i].format;
        images[i].width = WIDTH;
        images[i].height = HEIGHT;
        images[i].layout_in = VK_IMAGE_LAYOUT_GENERAL;
    }
    vk.slot = index % 2;
    vk.images = images;
    vk.image_count = IMAGES;
    if (!begin() || nrd_set_frame(denoiser, &frame) != NRD_RESULT_OK || nrd_vk_record(denoiser_vk, cmd, &vk) != NRD_RESULT_OK) return failed("recording");
    return submit() || failed("submitting");
}

/* ---- the output ---------------------------------------------------------------------------------------------------------------- */
static float half_to_float(uint16_t half)
{
    uint32_t bits = ((uint32_t)(half & 0x8000) << 16) | (((uint32_t)(half & 0x7fff) << 13) + (half & 0x7c00 ? 112u << 23 : 0));
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static int check_output(void)
{
    VkBuffer buffer;
    VkMemoryRequirements needs;
    void *mapped = NULL;
    int wrong = 0;
    VkBufferImageCopy copy;
    VK_STRUCT(VkBufferCreateInfo, info, VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
    info.size = WIDTH * HEIGHT * 8;
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (vkCreateBuffer(device, &info, NULL, &buffer) != VK_SUCCESS) return failed("vkCreateBuffer");
    vkGetBufferMemoryRequirements(device, buffer, &needs);
    VkDeviceMemory memory = allocate(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    memset(&copy, 0, sizeof copy);
    copy.imageSubresource.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
    copy.imageSubresource.layerCount = 1;
    copy.imageExtent.width = WIDTH;
    copy.imageExtent.height = HEIGHT;
    copy.imageExtent.depth = 1;
    if (!memory || vkBindBufferMemory(device, buffer, memory, 0) != VK_SUCCESS || vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, &mapped) != VK_SUCCESS || !begin())
        return failed("the buffer's memory");
    vkCmdCopyImageToBuffer(cmd, pictures[IMAGES - 1].image, VK_IMAGE_LAYOUT_GENERAL, buffer, 1, &copy);
    if (!submit()) return failed("reading back");
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        uint16_t texel[4];
        memcpy(texel, (const char *)mapped + 8 * i, sizeof texel);
        nrd_vec4 radiance = nrd_unpack_radiance_hit_dist(nrd_make_vec4(half_to_float(texel[0]), half_to_float(texel[1]), half_to_float(texel[2]), half_to_float(texel[3])));
        wrong += !(radiance.x > light - 0.01f && radiance.x < light + 0.01f);
    }
    printf("engine: %d of %d pixels differ from the constant input\n", wrong, WIDTH * HEIGHT);
    vkDestroyBuffer(device, buffer, NULL);
    vkFreeMemory(device, memory, NULL);
    return wrong == 0;
}

static void close_vulkan(void)
{
    if (device) vkDeviceWaitIdle(device);
    nrd_vk_destroy(denoiser_vk);
    nrd_destroy(denoiser);
    for (int i = 0; i < IMAGES && device; i++) {
        vkDestroyImageView(device, pictures[i].view, NULL);
        vkDestroyImage(device, pictures[i].image, NULL);
        vkFreeMemory(device, pictures[i].memory, NULL);
    }
    if (pool) vkDestroyCommandPool(device, pool, NULL);
    if (device) vkDestroyDevice(device, NULL);
    if (vulkan) vkDestroyInstance(vulkan, NULL);
}

int main(void)
{
    int good = open_vulkan() && paint_pictures() && create_denoiser();
    for (uint32_t i = 0; good && i < FRAMES; i++) good = denoise(i);
    good = good && check_output();
    close_vulkan();
    return good ? 0 : 1;
}
