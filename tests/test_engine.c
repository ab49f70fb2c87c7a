/* What engines do with nrd_vk.h, and do wrong: several devices, threads and frames in flight; other versions, calls in the wrong order. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "denoise_rig.h"

#include <pthread.h>

enum { WIDTH = 72, HEIGHT = 40, IN_FLIGHT = 3, FRAMES = 9 };

static gpu devices[2];

static int open_devices(void **state)
{
    char error[256];
    bool validated = gpu_validation_available();
    gpu_desc desc = { .validation = validated, .sync_validation = validated };
    (void)state;
    for (int i = 0; i < 2; i++) {
        if (gpu_open(&devices[i], &desc, error, sizeof error)) continue;
        print_error("%s\n", error);
        return -1;
    }
    return 0;
}

static int close_devices(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) gpu_close(&devices[i]);
    return 0;
}

static uint32_t message_count(void) { return gpu_message_count(&devices[0]) + gpu_message_count(&devices[1]); }

static hit wall(const pose *p, double u, double v, uint32_t frame)
{
    const double point[3] = { 0, 0, 8 };
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 0 };
    (void)frame;
    rig_ray_plane(p, u, v, point, h.normal, &h.depth);
    return h;
}

/* A rig whose images hold a noisy picture that stays as it is. */
static void open_wall(rig *r, gpu *device)
{
    rig_open(r, device, RIG_DENOISER, WIDTH, HEIGHT, wall);
    rig_put_guides(r);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        texel t = { (float)random_at(i, 1, 2), 0, 0, 0.5f };
        rig_put_noisy(r, i % WIDTH, i / WIDTH, t);
    }
    rig_upload(r);
}

static uint32_t list_images(rig *r, nrd_vk_image *list)
{
    uint32_t count = 0;
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        const gpu_image *image = &r->images[i];
        nrd_vk_image given = { (nrd_resource)i, image->image, image->view, image->format, image->width, image->height, image->layout, image->layout, 0, 0, 0 };
        if (image->view) list[count++] = given;
    }
    return count;
}

static nrd_vk_desc desc_of(const rig *r)
{
    const gpu *d = r->device;
    nrd_vk_desc desc = { .struct_version = NRD_VK_STRUCT_VERSION, .instance = r->instance, .vk_instance = d->instance, .physical = d->physical,
                         .device = d->device, .get_instance_proc = d->get_instance_proc, .frames_in_flight = IN_FLIGHT };
    return desc;
}

/* Another runtime for the rig's instance. */
static void replace_runtime(rig *r, const nrd_vk_desc *desc)
{
    nrd_vk_destroy(r->vk);
    r->vk = NULL;
    assert_int_equal(nrd_vk_create(desc, &r->vk), NRD_RESULT_OK);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Threads  >>threads */
/* One engine thread: its own instance, command pool and fences; the queue may be shared. Nothing in it asserts: cmocka leaves a test by a jump. */
typedef struct worker {
    rig r;
    pthread_mutex_t *queue;
    VkCommandPool pool;
    VkCommandBuffer cmds[IN_FLIGHT];
    VkFence fences[IN_FLIGHT];
    bool ok;
} worker;

static void open_worker(worker *w, gpu *device, pthread_mutex_t *queue)
{
    VkCommandPoolCreateInfo pool = { VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, NULL, VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT, device->family };
    VkFenceCreateInfo fence = { VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, NULL, VK_FENCE_CREATE_SIGNALED_BIT };
    memset(w, 0, sizeof *w);
    open_wall(&w->r, device);
    nrd_vk_desc desc = desc_of(&w->r);
    replace_runtime(&w->r, &desc);
    w->queue = queue;
    assert_int_equal(device->fn.vkCreateCommandPool(device->device, &pool, NULL, &w->pool), VK_SUCCESS);
    VkCommandBufferAllocateInfo cmds = { VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, NULL, w->pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, IN_FLIGHT };
    assert_int_equal(device->fn.vkAllocateCommandBuffers(device->device, &cmds, w->cmds), VK_SUCCESS);
    for (int i = 0; i < IN_FLIGHT; i++) assert_int_equal(device->fn.vkCreateFence(device->device, &fence, NULL, &w->fences[i]), VK_SUCCESS);
}

static void close_worker(worker *w)
{
    gpu *d = w->r.device;
    for (int i = 0; i < IN_FLIGHT; i++) d->fn.vkDestroyFence(d->device, w->fences[i], NULL);
    d->fn.vkDestroyCommandPool(d->device, w->pool, NULL);
    rig_close(&w->r);
}

static bool work_frame(worker *w, uint32_t index)
{
    const gpu *d = w->r.device;
    uint32_t slot = index % IN_FLIGHT;
    VkCommandBufferBeginInfo begin = { VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, NULL, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, NULL };
    VkSubmitInfo submit = { VK_STRUCTURE_TYPE_SUBMIT_INFO, NULL, 0, NULL, NULL, 1, &w->cmds[slot], 0, NULL };
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    nrd_vk_frame vk = { .slot = slot, .images = list, .image_count = list_images(&w->r, list) };
    nrd_frame frame = still_frame(index);
    frame.denoising_range = RIG_RANGE;
    bool ok = d->fn.vkWaitForFences(d->device, 1, &w->fences[slot], VK_TRUE, UINT64_MAX) == VK_SUCCESS && d->fn.vkResetFences(d->device, 1, &w->fences[slot]) == VK_SUCCESS
           && d->fn.vkBeginCommandBuffer(w->cmds[slot], &begin) == VK_SUCCESS && nrd_set_frame(w->r.instance, &frame) == NRD_RESULT_OK
           && nrd_vk_record(w->r.vk, w->cmds[slot], &vk) == NRD_RESULT_OK && d->fn.vkEndCommandBuffer(w->cmds[slot]) == VK_SUCCESS;
    pthread_mutex_lock(w->queue);
    ok = ok && d->fn.vkQueueSubmit(d->queue, 1, &submit, w->fences[slot]) == VK_SUCCESS;
    pthread_mutex_unlock(w->queue);
    return ok;
}

static void *work(void *user)
{
    worker *w = (worker *)user;
    w->ok = true;
    for (uint32_t i = 0; i < FRAMES && w->ok; i++) w->ok = work_frame(w, i);
    return NULL;
}

/* The output of both is that of one alone, bit by bit. */
static void run_workers(gpu *first, gpu *second)
{
    static worker workers[3];
    pthread_mutex_t queues[2] = { PTHREAD_MUTEX_INITIALIZER, PTHREAD_MUTEX_INITIALIZER };
    pthread_t threads[2];
    uint32_t before = message_count();
    open_worker(&workers[0], first, &queues[0]);
    open_worker(&workers[1], second, &queues[first != second]);
    open_worker(&workers[2], first, &queues[0]);
    for (int i = 0; i < 2; i++) assert_int_equal(pthread_create(&threads[i], NULL, work, &workers[i]), 0);
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    work(&workers[2]);
    for (int i = 0; i < 3; i++) {
        assert_true(workers[i].ok);
        rig_download(&workers[i].r);
        assert_memory_equal(workers[0].r.out, workers[i].r.out, WIDTH * HEIGHT * 8);
    }
    assert_true(rig_out(&workers[0].r, WIDTH / 2, HEIGHT / 2).y > 0);
    for (int i = 0; i < 3; i++) close_worker(&workers[i]);
    assert_int_equal(message_count(), before);
}

static void two_threads_record_for_one_device_with_three_frames_in_flight(void **state)
{
    (void)state;
    run_workers(&devices[0], &devices[0]);
}

static void two_devices_are_used_at_once(void **state)
{
    (void)state;
    run_workers(&devices[0], &devices[1]);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   What recording changes  >>commands */
static struct {
    char names[16][32];        /* of the vkCmd functions that were asked for */
    uint32_t name_count, binds, sets, pushes, wrong, barriers, transfers;
    VkPipelineCache cache;     /* with which all pipelines were made */
    uint32_t pipelines, other_caches;
} commands;

#define REAL(name) ((PFN_##name)devices[0].get_device_proc(devices[0].device, #name))

static VKAPI_ATTR void VKAPI_CALL watch_bind(VkCommandBuffer cmd, VkPipelineBindPoint point, VkPipeline pipeline)
{
    commands.binds++;
    commands.wrong += point != VK_PIPELINE_BIND_POINT_COMPUTE;
    REAL(vkCmdBindPipeline)(cmd, point, pipeline);
}

static VKAPI_ATTR void VKAPI_CALL watch_sets(VkCommandBuffer cmd, VkPipelineBindPoint point, VkPipelineLayout layout, uint32_t first, uint32_t count,
                                             const VkDescriptorSet *sets, uint32_t offset_count, const uint32_t *offsets)
{
    commands.sets++;
    commands.wrong += point != VK_PIPELINE_BIND_POINT_COMPUTE || first != 0 || count != 1;
    REAL(vkCmdBindDescriptorSets)(cmd, point, layout, first, count, sets, offset_count, offsets);
}

static VKAPI_ATTR void VKAPI_CALL watch_push(VkCommandBuffer cmd, VkPipelineLayout layout, VkShaderStageFlags stages, uint32_t offset, uint32_t size, const void *values)
{
    commands.pushes++;
    commands.wrong += stages != VK_SHADER_STAGE_COMPUTE_BIT || offset != 0 || size != sizeof ((nrd_dispatch *)0)->push;
    REAL(vkCmdPushConstants)(cmd, layout, stages, offset, size, values);
}

/* Images stay with the queue family that has them. */
static VKAPI_ATTR void VKAPI_CALL watch_barrier(VkCommandBuffer cmd, VkPipelineStageFlags from, VkPipelineStageFlags to, VkDependencyFlags flags, uint32_t memory_count,
                                                const VkMemoryBarrier *memory, uint32_t buffer_count, const VkBufferMemoryBarrier *buffers, uint32_t image_count,
                                                const VkImageMemoryBarrier *images)
{
    for (uint32_t i = 0; i < image_count; i++)
        commands.transfers += images[i].srcQueueFamilyIndex != VK_QUEUE_FAMILY_IGNORED || images[i].dstQueueFamilyIndex != VK_QUEUE_FAMILY_IGNORED;
    for (uint32_t i = 0; i < buffer_count; i++) commands.transfers += buffers[i].srcQueueFamilyIndex != buffers[i].dstQueueFamilyIndex;
    commands.barriers += image_count;
    REAL(vkCmdPipelineBarrier)(cmd, from, to, flags, memory_count, memory, buffer_count, buffers, image_count, images);
}

static VKAPI_ATTR VkResult VKAPI_CALL watch_pipelines(VkDevice d, VkPipelineCache cache, uint32_t count, const VkComputePipelineCreateInfo *info,
                                                      const VkAllocationCallbacks *callbacks, VkPipeline *out)
{
    commands.pipelines += count;
    commands.other_caches += cache != commands.cache;
    return REAL(vkCreateComputePipelines)(d, cache, count, info, callbacks, out);
}

static PFN_vkVoidFunction VKAPI_CALL watch_device_proc(VkDevice d, const char *name)
{
    if (strncmp(name, "vkCmd", 5) == 0 && commands.name_count < 16) snprintf(commands.names[commands.name_count++], 32, "%s", name);
    if (strcmp(name, "vkCmdBindPipeline") == 0) return (PFN_vkVoidFunction)watch_bind;
    if (strcmp(name, "vkCmdBindDescriptorSets") == 0) return (PFN_vkVoidFunction)watch_sets;
    if (strcmp(name, "vkCmdPipelineBarrier") == 0) return (PFN_vkVoidFunction)watch_barrier;
    if (strcmp(name, "vkCmdPushConstants") == 0) return (PFN_vkVoidFunction)watch_push;
    if (strcmp(name, "vkCreateComputePipelines") == 0) return (PFN_vkVoidFunction)watch_pipelines;
    return devices[0].get_device_proc(d, name);
}

/* The paragraph of nrd_vk.h that says what recording does. */
static char *documented_commands(void)
{
    static char text[200000];
    FILE *file = fopen("nrd_vk.h", "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    char *begin = strstr(text, "   COMMAND BUFFER\n"), *end = begin ? strstr(begin, "\n\n") : NULL;
    assert_non_null(end);
    *end = 0;
    return begin;
}

static void recording_uses_the_documented_commands_and_the_compute_bind_point_only(void **state)
{
    const char *documented = documented_commands();
    uint32_t named = 0;
    rig r;
    (void)state;
    memset(&commands, 0, sizeof commands);
    open_wall(&r, &devices[0]);
    nrd_vk_desc desc = desc_of(&r);
    desc.get_device_proc = watch_device_proc;
    replace_runtime(&r, &desc);
    for (int i = 0; i < 3; i++) rig_run(&r, false);
    for (uint32_t i = 0; i < commands.name_count; i++)
        if (!strstr(documented, commands.names[i])) fail_msg("%s is used, but not in nrd_vk.h under COMMAND BUFFER", commands.names[i]);
    for (const char *at = documented; (at = strstr(at, "vkCmd")) != NULL; at++) named++;
    assert_int_equal(named, commands.name_count);
    assert_true(commands.binds > 0 && commands.sets == commands.binds && commands.pushes == commands.binds);
    assert_int_equal(commands.wrong, 0);
    assert_true(commands.barriers > 0);
    assert_int_equal(commands.transfers, 0);
    rig_close(&r);
}

static void all_pipelines_are_asked_from_the_cache_of_the_app(void **state)
{
    VkPipelineCacheCreateInfo info = { .sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO };
    gpu *d = &devices[0];
    rig r;
    (void)state;
    memset(&commands, 0, sizeof commands);
    assert_int_equal(REAL(vkCreatePipelineCache)(d->device, &info, NULL, &commands.cache), VK_SUCCESS);
    open_wall(&r, d);
    nrd_vk_desc desc = desc_of(&r);
    desc.get_device_proc = watch_device_proc;
    desc.pipeline_cache = commands.cache;
    replace_runtime(&r, &desc);
    uint32_t created = commands.pipelines;
    assert_int_equal(created, nrd_get_info(r.instance)->pipeline_count);
    rig_run(&r, false);
    assert_int_equal(nrd_vk_resize(r.vk, WIDTH + 8, HEIGHT), NRD_RESULT_OK);
    assert_int_equal(commands.pipelines, created);
    assert_int_equal(commands.other_caches, 0);
    rig_close(&r);
    REAL(vkDestroyPipelineCache)(d->device, commands.cache, NULL);
}

/* Inside of a secondary command buffer, which inherits nothing. */
static void a_secondary_command_buffer_will_do(void **state)
{
    const gpu *d = &devices[0];
    VkCommandBufferAllocateInfo allocate = { VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, NULL, d->pool, VK_COMMAND_BUFFER_LEVEL_SECONDARY, 1 };
    VkCommandBufferInheritanceInfo inherit = { .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO };
    VkCommandBufferBeginInfo begin = { VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, NULL, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, &inherit };
    VkCommandBuffer secondary;
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    rig r;
    (void)state;
    uint32_t before = message_count();
    open_wall(&r, &devices[0]);
    nrd_vk_frame vk = { .images = list, .image_count = list_images(&r, list) };
    nrd_frame frame = still_frame(0);
    assert_int_equal(nrd_set_frame(r.instance, &frame), NRD_RESULT_OK);
    assert_int_equal(d->fn.vkAllocateCommandBuffers(d->device, &allocate, &secondary), VK_SUCCESS);
    assert_int_equal(d->fn.vkBeginCommandBuffer(secondary, &begin), VK_SUCCESS);
    assert_int_equal(nrd_vk_record(r.vk, secondary, &vk), NRD_RESULT_OK);
    assert_int_equal(d->fn.vkEndCommandBuffer(secondary), VK_SUCCESS);
    VkCommandBuffer cmd = gpu_begin(&devices[0]);
    REAL(vkCmdExecuteCommands)(cmd, 1, &secondary);
    assert_true(gpu_submit_and_wait(&devices[0]));
    rig_download(&r);
    assert_true(rig_out(&r, WIDTH / 2, HEIGHT / 2).y > 0);
    d->fn.vkFreeCommandBuffers(d->device, d->pool, 1, &secondary);
    rig_close(&r);
    assert_int_equal(message_count(), before);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   The descriptor pool of the app  >>pool
   Devices need not notice that a pool is used up; this one does. */
enum { POOL_TYPES = VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT + 1, POOL_LAYOUTS = 64 };
typedef struct contents { uint32_t sets, of_type[POOL_TYPES]; } contents;

static struct {
    VkDescriptorSetLayout layouts[POOL_LAYOUTS];
    contents holds[POOL_LAYOUTS];   /* by a set of that layout */
    uint32_t layout_count, own_pools;
    contents room, used;
} pool;

static VKAPI_ATTR VkResult VKAPI_CALL pool_layout(VkDevice d, const VkDescriptorSetLayoutCreateInfo *info, const VkAllocationCallbacks *callbacks, VkDescriptorSetLayout *out)
{
    VkResult result = REAL(vkCreateDescriptorSetLayout)(d, info, callbacks, out);
    contents holds = { .sets = 1 };
    for (uint32_t i = 0; i < info->bindingCount; i++) holds.of_type[info->pBindings[i].descriptorType] += info->pBindings[i].descriptorCount;
    pool.layouts[pool.layout_count % POOL_LAYOUTS] = *out;
    pool.holds[pool.layout_count++ % POOL_LAYOUTS] = holds;
    return result;
}

static contents contents_of(const VkDescriptorSetLayout *layouts, uint32_t count)
{
    contents sum = { 0 };
    for (uint32_t i = 0; i < count; i++) {
        uint32_t found = pool.layout_count - 1; /* from the last one on: handles are used again */
        while (found > 0 && pool.layouts[found % POOL_LAYOUTS] != layouts[i]) found--;
        sum.sets += pool.holds[found % POOL_LAYOUTS].sets;
        for (int t = 0; t < POOL_TYPES; t++) sum.of_type[t] += pool.holds[found % POOL_LAYOUTS].of_type[t];
    }
    return sum;
}

static VKAPI_ATTR VkResult VKAPI_CALL pool_allocate(VkDevice d, const VkDescriptorSetAllocateInfo *info, VkDescriptorSet *sets)
{
    contents more = contents_of(info->pSetLayouts, info->descriptorSetCount);
    bool fits = pool.used.sets + more.sets <= pool.room.sets;
    for (int t = 0; t < POOL_TYPES; t++) fits = fits && pool.used.of_type[t] + more.of_type[t] <= pool.room.of_type[t];
    VkResult result = fits ? REAL(vkAllocateDescriptorSets)(d, info, sets) : VK_ERROR_OUT_OF_POOL_MEMORY;
    if (result != VK_SUCCESS) return result;
    pool.used.sets += more.sets;
    for (int t = 0; t < POOL_TYPES; t++) pool.used.of_type[t] += more.of_type[t];
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL pool_free(VkDevice d, VkDescriptorPool from, uint32_t count, const VkDescriptorSet *sets)
{
    pool.used = (contents){ .sets = pool.used.sets - count };   /* of one runtime: all of them */
    return REAL(vkFreeDescriptorSets)(d, from, count, sets);
}

static VKAPI_ATTR VkResult VKAPI_CALL pool_create(VkDevice d, const VkDescriptorPoolCreateInfo *info, const VkAllocationCallbacks *callbacks, VkDescriptorPool *out)
{
    pool.own_pools++;
    return REAL(vkCreateDescriptorPool)(d, info, callbacks, out);
}

static PFN_vkVoidFunction VKAPI_CALL pool_device_proc(VkDevice d, const char *name)
{
    if (strcmp(name, "vkCreateDescriptorSetLayout") == 0) return (PFN_vkVoidFunction)pool_layout;
    if (strcmp(name, "vkAllocateDescriptorSets") == 0) return (PFN_vkVoidFunction)pool_allocate;
    if (strcmp(name, "vkFreeDescriptorSets") == 0) return (PFN_vkVoidFunction)pool_free;
    if (strcmp(name, "vkCreateDescriptorPool") == 0) return (PFN_vkVoidFunction)pool_create;
    return devices[0].get_device_proc(d, name);
}

/* With room for exactly what nrd_vk_requirements asks for. */
static VkDescriptorPool create_pool(const rig *r, VkDescriptorPoolCreateFlags flags)
{
    VkDescriptorPoolCreateInfo info = { VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, NULL, flags, 0, 0, NULL };
    VkDescriptorPool out;
    nrd_vk_needs needs;
    assert_int_equal(nrd_vk_requirements(r->instance, &needs), NRD_RESULT_OK);
    memset(&pool, 0, sizeof pool);
    info.maxSets = pool.room.sets = IN_FLIGHT * needs.descriptor_sets;
    info.poolSizeCount = needs.descriptor_type_count;
    info.pPoolSizes = needs.descriptors;
    for (uint32_t i = 0; i < needs.descriptor_type_count; i++)
        pool.room.of_type[needs.descriptors[i].type] = needs.descriptors[i].descriptorCount *= IN_FLIGHT;
    assert_int_equal(REAL(vkCreateDescriptorPool)(devices[0].device, &info, NULL, &out), VK_SUCCESS);
    return out;
}

static nrd_vk_desc desc_with_pool(const rig *r, VkDescriptorPool from, uint32_t flags)
{
    nrd_vk_desc desc = desc_of(r);
    desc.get_device_proc = pool_device_proc;
    desc.descriptor_pool = from;
    desc.flags = flags;
    return desc;
}

static void all_sets_come_from_the_pool_of_the_app_and_go_back_if_they_may(void **state)
{
    rig plain, pooled;
    (void)state;
    uint32_t before = message_count();
    for (uint32_t frees = 0; frees < 2; frees++) {
        open_wall(&plain, &devices[0]);
        open_wall(&pooled, &devices[0]);
        VkDescriptorPool from = create_pool(&pooled, frees ? VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT : 0);
        nrd_vk_desc desc = desc_with_pool(&pooled, from, frees ? NRD_VK_FREE_DESCRIPTOR_SETS | NRD_VK_TIMESTAMPS : 0);
        replace_runtime(&pooled, &desc);
        for (int i = 0; i < 3; i++) rig_run(&plain, false), rig_run(&pooled, false);
        assert_int_equal(nrd_vk_resize(pooled.vk, WIDTH + 8, HEIGHT), NRD_RESULT_OK);
        rig_download(&plain);
        rig_download(&pooled);
        assert_memory_equal(plain.out, pooled.out, WIDTH * HEIGHT * 8);
        assert_memory_equal(&pool.used, &pool.room, sizeof pool.room);
        if (frees) replace_runtime(&pooled, &desc);
        rig_close(&pooled);
        rig_close(&plain);
        assert_int_equal(pool.used.sets, frees ? 0 : pool.room.sets);
        assert_int_equal(pool.own_pools, 0);
        REAL(vkDestroyDescriptorPool)(devices[0].device, from, NULL);
    }
    assert_int_equal(message_count(), before);
}

/* By one set, and by one descriptor of each type. */
static void a_pool_that_is_too_small_is_named_and_keeps_what_it_has(void **state)
{
    const contents nothing = { 0 };
    rig r;
    (void)state;
    uint32_t before = message_count();
    open_wall(&r, &devices[0]);
    VkDescriptorPool from = create_pool(&r, 0);
    nrd_vk_desc desc = desc_with_pool(&r, from, 0);
    const contents enough = pool.room;
    uint32_t types = 0;
    nrd_vk_destroy(r.vk);
    r.vk = NULL;
    for (int t = -1; t < POOL_TYPES; t++) {
        uint32_t *room = t < 0 ? &pool.room.sets : &pool.room.of_type[t];
        if (*room == 0) continue;
        --*room;
        assert_int_equal(nrd_vk_create(&desc, &r.vk), NRD_RESULT_INVALID_ARGUMENT);
        assert_non_null(strstr(r.spy.text, "nrd_vk_desc.descriptor_pool has too little left"));
        assert_null(r.vk);
        assert_memory_equal(&pool.used, &nothing, sizeof nothing);
        pool.room = enough;
        types++;
    }
    assert_int_equal(types, 6);
    assert_int_equal(nrd_vk_create(&desc, &r.vk), NRD_RESULT_OK);
    rig_run(&r, false);
    rig_close(&r);
    REAL(vkDestroyDescriptorPool)(devices[0].device, from, NULL);
    assert_int_equal(message_count(), before);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Images inside others  >>subresources */
/* Mip 1 of layer 1 has the size of the rig; the rest of the image is the app's and stays UNDEFINED. */
typedef struct atlas { VkImage image; VkImageView view; VkDeviceMemory memory; } atlas;

static void create_atlas(gpu *d, atlas *a)
{
    VkImageCreateInfo image = { .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, .imageType = VK_IMAGE_TYPE_2D, .format = VK_FORMAT_R32_SFLOAT,
                                .extent = { 2 * WIDTH, 2 * HEIGHT, 1 }, .mipLevels = 2, .arrayLayers = 2, .samples = VK_SAMPLE_COUNT_1_BIT,
                                .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT };
    VkImageViewCreateInfo view = { .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, .viewType = VK_IMAGE_VIEW_TYPE_2D, .format = image.format,
                                   .subresourceRange = { VK_IMAGE_ASPECT_COLOR_BIT, 1, 1, 1, 1 } };
    VkMemoryRequirements needs;
    VkMemoryAllocateInfo memory = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO };
    assert_int_equal(d->fn.vkCreateImage(d->device, &image, NULL, &a->image), VK_SUCCESS);
    d->fn.vkGetImageMemoryRequirements(d->device, a->image, &needs);
    memory.allocationSize = needs.size;
    while (!(needs.memoryTypeBits >> memory.memoryTypeIndex & 1)) memory.memoryTypeIndex++;
    assert_int_equal(d->fn.vkAllocateMemory(d->device, &memory, NULL, &a->memory), VK_SUCCESS);
    assert_int_equal(d->fn.vkBindImageMemory(d->device, a->image, a->memory, 0), VK_SUCCESS);
    view.image = a->image;
    assert_int_equal(d->fn.vkCreateImageView(d->device, &view, NULL, &a->view), VK_SUCCESS);
}

static void clear_atlas(gpu *d, const atlas *a, float value)
{
    const VkClearColorValue color = { { value, 0, 0, 0 } };
    const VkImageSubresourceRange part = { VK_IMAGE_ASPECT_COLOR_BIT, 1, 1, 1, 1 };
    VkImageMemoryBarrier barrier = { VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER, NULL, 0, VK_ACCESS_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                                     VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_QUEUE_FAMILY_IGNORED, VK_QUEUE_FAMILY_IGNORED, a->image, part };
    VkCommandBuffer cmd = gpu_begin(d);
    d->fn.vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, NULL, 0, NULL, 1, &barrier);
    REAL(vkCmdClearColorImage)(cmd, a->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &color, 1, &part);
    assert_true(gpu_submit_and_wait(d));
}

/* Where IN_VIEWZ is the atlas the output is the same, and only that part of it changes its layout, there and back. */
static void an_image_may_be_a_mip_level_and_a_layer_of_another(void **state)
{
    gpu *d = &devices[0];
    rig plain, inside;
    atlas a;
    (void)state;
    uint32_t before = message_count();
    open_wall(&plain, d);
    open_wall(&inside, d);
    create_atlas(d, &a);
    clear_atlas(d, &a, plain.view_z[0]);
    for (uint32_t frame = 0; frame < 3; frame++) {
        nrd_vk_image list[NRD_RESOURCE_COUNT];
        nrd_vk_frame vk = { .images = list, .image_count = list_images(&inside, list) };
        nrd_frame still = still_frame(frame);
        still.denoising_range = RIG_RANGE;
        for (uint32_t i = 0; i < vk.image_count; i++)
            if (list[i].resource == NRD_RESOURCE_IN_VIEWZ) {
                list[i].image = a.image, list[i].view = a.view, list[i].mip = list[i].layer = 1;
                list[i].layout_in = list[i].layout_out = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
            }
        assert_int_equal(nrd_set_frame(inside.instance, &still), NRD_RESULT_OK);
        VkCommandBuffer cmd = gpu_begin(d);
        assert_int_equal(nrd_vk_record(inside.vk, cmd, &vk), NRD_RESULT_OK);
        assert_true(gpu_submit_and_wait(d));
        rig_run(&plain, false);
    }
    rig_download(&plain);
    rig_download(&inside);
    assert_memory_equal(plain.out, inside.out, WIDTH * HEIGHT * 8);
    rig_close(&plain);
    rig_close(&inside);
    d->fn.vkDestroyImageView(d->device, a.view, NULL);
    d->fn.vkDestroyImage(d->device, a.image, NULL);
    d->fn.vkFreeMemory(d->device, a.memory, NULL);
    assert_int_equal(message_count(), before);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Errors of use  >>errors */
static void assert_message(const rig *r, nrd_result got, nrd_result expected, const char *text)
{
    if (got != expected || !strstr(r->spy.text, text)) fail_msg("result %d, expected %d; message \"%s\", expected \"%s\"", got, expected, r->spy.text, text);
    assert_int_equal(r->spy.result, expected);
}

static void structs_of_another_version_are_refused(void **state)
{
    nrd_vk *none = NULL;
    nrd *instance = NULL;
    rig r;
    (void)state;
    const nrd_denoiser_desc one = { 0, NRD_DENOISER_REFERENCE };
    spy s = { 0 };
    nrd_desc desc = spied_desc(&s, &one, 1, 8, 8, 0);
    desc.struct_version = NRD_STRUCT_VERSION + (1 << 16);
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_WRONG_VERSION);
    assert_non_null(strstr(s.text, "nrd_desc.struct_version is "));
    assert_non_null(strstr(s.text, "(release 101), needed is "));
    assert_null(instance);
    desc.struct_version = NRD_STRUCT_VERSION;
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    nrd_destroy(instance);

    open_wall(&r, &devices[0]);
    nrd_vk_desc vk = desc_of(&r);
    vk.struct_version++;
    assert_message(&r, nrd_vk_create(&vk, &none), NRD_RESULT_WRONG_VERSION, "nrd_vk_desc.struct_version is ");
    assert_null(none);
    rig_run(&r, false);
    rig_close(&r);
}

static void a_frame_must_be_set_before_the_first_recording(void **state)
{
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    rig r;
    (void)state;
    open_wall(&r, &devices[0]);
    nrd_vk_frame vk = { .images = list, .image_count = list_images(&r, list) };
    VkCommandBuffer cmd = gpu_begin(&devices[0]);
    assert_message(&r, nrd_vk_record(r.vk, cmd, &vk), NRD_RESULT_FRAME_NOT_SET, "call nrd_set_frame first");
    assert_true(gpu_submit_and_wait(&devices[0]));
    rig_run(&r, false);
    rig_close(&r);
}

static void images_without_the_needed_usage_are_named(void **state)
{
    static const struct { nrd_resource resource; VkImageUsageFlags usage; const char *text; } rows[] = {
        { NRD_RESOURCE_IN_MV, VK_IMAGE_USAGE_STORAGE_BIT, "IN_MV: usage is 8, needed is SAMPLED, VkImageUsageFlags 4" },
        { RIG_OUT, VK_IMAGE_USAGE_STORAGE_BIT, "OUT_DIFF_RADIANCE_HITDIST: usage is 8, needed are SAMPLED and STORAGE, VkImageUsageFlags 12" },
        { RIG_OUT, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, "OUT_DIFF_RADIANCE_HITDIST: usage is 5" },
    };
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    rig r;
    (void)state;
    open_wall(&r, &devices[0]);
    nrd_vk_frame vk = { .images = list, .image_count = list_images(&r, list) };
    nrd_frame frame = still_frame(0);
    assert_int_equal(nrd_set_frame(r.instance, &frame), NRD_RESULT_OK);
    VkCommandBuffer cmd = gpu_begin(&devices[0]);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        list_images(&r, list);
        for (uint32_t k = 0; k < vk.image_count; k++)
            list[k].usage = list[k].resource == rows[i].resource ? rows[i].usage : (VkImageUsageFlags)(VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT);
        assert_message(&r, nrd_vk_record(r.vk, cmd, &vk), NRD_RESULT_INVALID_ARGUMENT, rows[i].text);
    }
    assert_true(gpu_submit_and_wait(&devices[0]));
    rig_run(&r, false);
    rig_close(&r);
}

/* An engine's arena: what was released is still there. */
typedef struct arena { uint64_t words[1 << 17]; size_t used; } arena; /* used: bytes */

static void *arena_allocate(void *user, size_t bytes)
{
    arena *a = (arena *)user;
    void *memory = (char *)a->words + a->used;
    a->used += (bytes + 15) / 16 * 16;
    return a->used <= sizeof a->words ? memory : NULL;
}

static void arena_release(void *user, void *memory)
{
    (void)user;
    (void)memory;
}

static void what_was_destroyed_is_refused(void **state)
{
    static arena a;
    const nrd_denoiser_desc one = { 0, NRD_DENOISER_REFERENCE };
    nrd_desc desc = { .width = 8, .height = 8, .denoisers = &one, .denoiser_count = 1, .allocate = arena_allocate, .release = arena_release, .allocate_user = &a };
    const nrd_reference_settings settings = nrd_reference_defaults();
    const nrd_dispatch *dispatches = NULL;
    nrd_vk_frame frame = { .slot = 0 };
    nrd_frame still = still_frame(0);
    nrd_vk *runtime = NULL, *none = NULL;
    uint32_t count = 0;
    rig r = { .device = &devices[0] };
    (void)state;
    a.used = 0;
    assert_int_equal(nrd_create(&desc, &r.instance), NRD_RESULT_OK);
    nrd_vk_desc vk = desc_of(&r);
    vk.allocate = arena_allocate, vk.release = arena_release, vk.allocate_user = &a;
    assert_int_equal(nrd_vk_create(&vk, &runtime), NRD_RESULT_OK);
    nrd_destroy(r.instance);
    nrd_destroy(r.instance);
    assert_int_equal(nrd_set_frame(r.instance, &still), NRD_RESULT_DESTROYED);
    assert_int_equal(nrd_set_settings(r.instance, 0, &settings), NRD_RESULT_DESTROYED);
    assert_int_equal(nrd_get_dispatches(r.instance, NULL, 0, &dispatches, &count), NRD_RESULT_DESTROYED);
    assert_int_equal(nrd_resize(r.instance, 4, 4), NRD_RESULT_DESTROYED);
    assert_null(nrd_get_info(r.instance));
    assert_false(nrd_uses_resource(r.instance, NRD_RESOURCE_IN_SIGNAL));
    assert_int_equal(nrd_vk_create(&vk, &none), NRD_RESULT_DESTROYED);
    VkCommandBuffer cmd = gpu_begin(&devices[0]);
    assert_int_equal(nrd_vk_record(runtime, cmd, &frame), NRD_RESULT_DESTROYED);
    assert_int_equal(nrd_vk_resize(runtime, 4, 4), NRD_RESULT_DESTROYED);
    nrd_vk_destroy(runtime); /* in the wrong order, but nothing leaks */
    nrd_vk_destroy(runtime);
    assert_int_equal(nrd_vk_record(runtime, cmd, &frame), NRD_RESULT_DESTROYED);
    assert_int_equal(nrd_vk_timings(runtime, 0, NULL, 0, &count), NRD_RESULT_DESTROYED);
    assert_int_equal(nrd_vk_memory_bytes(runtime, NRD_VK_MEMORY_PERMANENT), 0);
    assert_true(gpu_submit_and_wait(&devices[0]));
}

static void nothing_can_be_done_before_creation(void **state)
{
    const nrd_reblur_settings settings = nrd_reblur_defaults();
    nrd *instance = NULL;
    nrd_vk *vk = NULL;
    nrd_vk_desc desc = { .instance = instance };
    nrd_vk_frame frame = { .slot = 0 };
    (void)state;
    assert_int_equal(nrd_set_settings(instance, 0, &settings), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_vk_create(&desc, &vk), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_vk_record(vk, NULL, &frame), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_vk_memory_bytes(vk, NRD_VK_MEMORY_PERMANENT), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_threads_record_for_one_device_with_three_frames_in_flight),
        cmocka_unit_test(two_devices_are_used_at_once),
        cmocka_unit_test(recording_uses_the_documented_commands_and_the_compute_bind_point_only),
        cmocka_unit_test(all_pipelines_are_asked_from_the_cache_of_the_app),
        cmocka_unit_test(a_secondary_command_buffer_will_do),
        cmocka_unit_test(all_sets_come_from_the_pool_of_the_app_and_go_back_if_they_may),
        cmocka_unit_test(a_pool_that_is_too_small_is_named_and_keeps_what_it_has),
        cmocka_unit_test(an_image_may_be_a_mip_level_and_a_layer_of_another),
        cmocka_unit_test(structs_of_another_version_are_refused),
        cmocka_unit_test(a_frame_must_be_set_before_the_first_recording),
        cmocka_unit_test(images_without_the_needed_usage_are_named),
        cmocka_unit_test(what_was_destroyed_is_refused),
        cmocka_unit_test(nothing_can_be_done_before_creation),
    };
    return cmocka_run_group_tests(tests, open_devices, close_devices);
}
