#include "raygen/rt.h"

#include "raygen_spv.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RT_FUNCTIONS(X)                                                                                                        \
    X(vkGetBufferDeviceAddressKHR)                                                                                             \
    X(vkCreateAccelerationStructureKHR) X(vkDestroyAccelerationStructureKHR) X(vkGetAccelerationStructureBuildSizesKHR)        \
        X(vkGetAccelerationStructureDeviceAddressKHR) X(vkCmdBuildAccelerationStructuresKHR) X(vkCreateRayTracingPipelinesKHR) \
            X(vkGetRayTracingShaderGroupHandlesKHR) X(vkCmdTraceRaysKHR)

typedef struct buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceAddress address;
    void *mapped; /* NULL in device memory */
} buffer;

typedef struct structure {
    VkAccelerationStructureKHR handle;
    buffer storage, scratch;
    VkDeviceAddress scratch_address; /* aligned */
} structure;

struct rt {
    gpu *g;
#define RT_MEMBER(name) PFN_##name name;
    struct {
        RT_FUNCTIONS(RT_MEMBER)
    } fn;
#undef RT_MEMBER
    VkPhysicalDeviceRayTracingPipelinePropertiesKHR limits;
    VkPhysicalDeviceAccelerationStructurePropertiesKHR structure_limits;
    buffer cube, instances, table;
    structure bottom, top;
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkStridedDeviceAddressRegionKHR ray_generation, miss, hit;
    char *error;
    size_t error_size;
};

/* ---- device ---------------------------------------------------------------------------------------------------- */

static const char *const extensions[] = {
    VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,  VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
    VK_EXT_DESCRIPTOR_INDEXING_EXTENSION_NAME,   VK_KHR_SPIRV_1_4_EXTENSION_NAME,
    VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME,
};
enum { EXTENSION_COUNT = sizeof extensions / sizeof extensions[0] };

static bool is_listed(const VkExtensionProperties *list, uint32_t count, const char *name)
{
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(list[i].extensionName, name) == 0) return true;
    return false;
}

/* The first extension that the device lacks; NULL if it has all. */
static const char *lacking(gpu *g)
{
    PFN_vkEnumerateDeviceExtensionProperties enumerate =
        (PFN_vkEnumerateDeviceExtensionProperties)g->get_instance_proc(g->instance, "vkEnumerateDeviceExtensionProperties");
    VkExtensionProperties *list = NULL;
    const char *name = NULL;
    uint32_t count = 0;
    if (enumerate && enumerate(g->physical, NULL, &count, NULL) == VK_SUCCESS) list = malloc((count + 1) * sizeof *list);
    if (!list || enumerate(g->physical, NULL, &count, list) != VK_SUCCESS) count = 0;
    for (int i = EXTENSION_COUNT - 1; i >= 0; i--)
        if (!is_listed(list, count, extensions[i])) name = extensions[i];
    free(list);
    return name;
}

bool rt_open_device(gpu *g, const gpu_desc *desc, bool *none, char *error, size_t error_size)
{
    VkPhysicalDeviceBufferDeviceAddressFeatures address = { .sType =
                                                                VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES,
                                                            .bufferDeviceAddress = VK_TRUE };
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR,
        .pNext = &address,
        .accelerationStructure = VK_TRUE
    };
    VkPhysicalDeviceRayTracingPipelineFeaturesKHR pipelines = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR,
        .pNext = &structures,
        .rayTracingPipeline = VK_TRUE
    };
    gpu_desc plain = *desc, full = *desc;
    full.extensions = extensions;
    full.extension_count = EXTENSION_COUNT;
    full.features = &pipelines;
    *none = true;
    for (plain.device_index = 0; plain.device_index < 16; plain.device_index++) {
        char reason[256];
        if (!gpu_open(g, &plain, reason, sizeof reason)) {
            if (plain.device_index == 0) snprintf(error, error_size, "%s", reason);
            return false;
        }
        const char *name = lacking(g);
        snprintf(error, error_size, "%s has no %s", g->properties.deviceName, name ? name : "");
        gpu_close(g);
        if (name) continue;
        *none = false;
        full.device_index = plain.device_index;
        return gpu_open(g, &full, error, error_size);
    }
    return false;
}

static bool check(rt *r, VkResult result, const char *what)
{
    if (result != VK_SUCCESS) snprintf(r->error, r->error_size, "%s failed with VkResult %d", what, (int)result);
    return result == VK_SUCCESS;
}

static bool load_functions(rt *r)
{
    gpu *g = r->g;
#define RT_LOAD(name)                                              \
    r->fn.name = (PFN_##name)g->get_device_proc(g->device, #name); \
    if (!r->fn.name) return snprintf(r->error, r->error_size, "the device has no " #name), false;
    RT_FUNCTIONS(RT_LOAD)
#undef RT_LOAD
    PFN_vkGetPhysicalDeviceProperties2 get_properties =
        (PFN_vkGetPhysicalDeviceProperties2)g->get_instance_proc(g->instance, "vkGetPhysicalDeviceProperties2");
    r->structure_limits.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR;
    r->limits.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR;
    r->limits.pNext = &r->structure_limits;
    VkPhysicalDeviceProperties2 properties = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &r->limits };
    get_properties(g->physical, &properties);
    return true;
}

/* ---- buffers --------------------------------------------------------------------------------------------------- */

static VkDeviceAddress align_up(VkDeviceAddress value, VkDeviceAddress alignment)
{
    return (value + alignment - 1) / alignment * alignment;
}

static bool bind_memory(rt *r, VkMemoryPropertyFlags flags, buffer *b)
{
    gpu *g = r->g;
    VkMemoryRequirements need;
    VkMemoryAllocateFlagsInfo address = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                          .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT };
    VkMemoryAllocateInfo info = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .pNext = &address };
    uint32_t type = 0;
    g->fn.vkGetBufferMemoryRequirements(g->device, b->buffer, &need);
    while (type < g->memory.memoryTypeCount
           && (!(need.memoryTypeBits >> type & 1u) || (g->memory.memoryTypes[type].propertyFlags & flags) != flags))
        type++;
    if (type == g->memory.memoryTypeCount)
        return snprintf(r->error, r->error_size, "no memory type with property flags 0x%x", (unsigned)flags), false;
    info.allocationSize = need.size;
    info.memoryTypeIndex = type;
    return check(r, g->fn.vkAllocateMemory(g->device, &info, NULL, &b->memory), "vkAllocateMemory")
           && check(r, g->fn.vkBindBufferMemory(g->device, b->buffer, b->memory, 0), "vkBindBufferMemory");
}

/* Device memory, or memory that the host writes if is_mapped. */
static bool create_buffer(rt *r, VkDeviceSize size, VkBufferUsageFlags usage, bool is_mapped, buffer *b)
{
    gpu *g = r->g;
    VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkBufferCreateInfo info = { .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .size = size,
                                .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT };
    if (!check(r, g->fn.vkCreateBuffer(g->device, &info, NULL, &b->buffer), "vkCreateBuffer")) return false;
    if (!bind_memory(r, is_mapped ? host : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, b)) return false;
    VkBufferDeviceAddressInfo address = { .sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = b->buffer };
    b->address = r->fn.vkGetBufferDeviceAddressKHR(g->device, &address);
    return !is_mapped || check(r, g->fn.vkMapMemory(g->device, b->memory, 0, VK_WHOLE_SIZE, 0, &b->mapped), "vkMapMemory");
}

static void destroy_buffer(rt *r, buffer *b)
{
    gpu *g = r->g;
    if (b->buffer) g->fn.vkDestroyBuffer(g->device, b->buffer, NULL);
    if (b->memory) g->fn.vkFreeMemory(g->device, b->memory, NULL);
}

/* ---- acceleration structures ----------------------------------------------------------------------------------- */

static VkAccelerationStructureBuildGeometryInfoKHR build_info(VkAccelerationStructureTypeKHR type,
                                                              const VkAccelerationStructureGeometryKHR *geometry)
{
    return (VkAccelerationStructureBuildGeometryInfoKHR){ .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
                                                          .type = type,
                                                          .flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR,
                                                          .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                                                          .geometryCount = 1,
                                                          .pGeometries = geometry };
}

/* The cube's corners (three floats each), then its triangles (three 32-bit indices each). */
enum { CUBE_CORNERS = 8, CUBE_TRIANGLES = 12, CUBE_INDICES_AT = CUBE_CORNERS * 3 * sizeof(float) };

static VkAccelerationStructureGeometryKHR cube_geometry(const rt *r)
{
    VkAccelerationStructureGeometryKHR g = { .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
                                             .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
                                             .flags = VK_GEOMETRY_OPAQUE_BIT_KHR };
    g.geometry.triangles =
        (VkAccelerationStructureGeometryTrianglesDataKHR){ .sType =
                                                               VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
                                                           .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                                                           .vertexData.deviceAddress = r->cube.address,
                                                           .vertexStride = 3 * sizeof(float),
                                                           .maxVertex = CUBE_CORNERS - 1,
                                                           .indexType = VK_INDEX_TYPE_UINT32,
                                                           .indexData.deviceAddress = r->cube.address + CUBE_INDICES_AT };
    return g;
}

static VkAccelerationStructureGeometryKHR box_geometry(const rt *r)
{
    VkAccelerationStructureGeometryKHR g = { .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
                                             .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
                                             .flags = VK_GEOMETRY_OPAQUE_BIT_KHR };
    g.geometry.instances = (VkAccelerationStructureGeometryInstancesDataKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR, .data.deviceAddress = r->instances.address
    };
    return g;
}

static bool create_structure(rt *r, const VkAccelerationStructureBuildGeometryInfoKHR *info, uint32_t primitives, structure *s)
{
    gpu *g = r->g;
    VkDeviceSize alignment = r->structure_limits.minAccelerationStructureScratchOffsetAlignment;
    VkAccelerationStructureBuildSizesInfoKHR sizes = { .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR };
    r->fn.vkGetAccelerationStructureBuildSizesKHR(g->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, info, &primitives,
                                                  &sizes);
    if (!create_buffer(r, sizes.accelerationStructureSize, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, false,
                       &s->storage)
        || !create_buffer(r, sizes.buildScratchSize + alignment, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, false, &s->scratch))
        return false;
    s->scratch_address = align_up(s->scratch.address, alignment);
    VkAccelerationStructureCreateInfoKHR create = { .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
                                                    .buffer = s->storage.buffer,
                                                    .size = sizes.accelerationStructureSize,
                                                    .type = info->type };
    return check(r, r->fn.vkCreateAccelerationStructureKHR(g->device, &create, NULL, &s->handle),
                 "vkCreateAccelerationStructureKHR");
}

static void record_build(rt *r, VkCommandBuffer cmd, VkAccelerationStructureBuildGeometryInfoKHR info, uint32_t primitives,
                         const structure *s)
{
    VkAccelerationStructureBuildRangeInfoKHR range = { .primitiveCount = primitives };
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &range;
    info.dstAccelerationStructure = s->handle;
    info.scratchData.deviceAddress = s->scratch_address;
    r->fn.vkCmdBuildAccelerationStructuresKHR(cmd, 1, &info, &ranges);
    gpu_barrier(r->g);
}

static void write_cube(void *mapped)
{
    static const uint32_t indices[CUBE_TRIANGLES * 3] = { 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                          2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5 };
    float corners[CUBE_CORNERS * 3];
    for (int i = 0; i < CUBE_CORNERS; i++)
        for (int k = 0; k < 3; k++) corners[3 * i + k] = i >> k & 1 ? 1.0f : -1.0f;
    memcpy(mapped, corners, sizeof corners);
    memcpy((char *)mapped + CUBE_INDICES_AT, indices, sizeof indices);
}

static bool create_structures(rt *r)
{
    VkBufferUsageFlags input = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    VkDeviceSize instances = RAYGEN_MAX_BOXES * sizeof(VkAccelerationStructureInstanceKHR);
    if (!create_buffer(r, CUBE_INDICES_AT + CUBE_TRIANGLES * 3 * sizeof(uint32_t), input, true, &r->cube)
        || !create_buffer(r, instances, input, true, &r->instances))
        return false;
    write_cube(r->cube.mapped);
    VkAccelerationStructureGeometryKHR cube = cube_geometry(r), boxes = box_geometry(r);
    VkAccelerationStructureBuildGeometryInfoKHR bottom = build_info(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, &cube);
    VkAccelerationStructureBuildGeometryInfoKHR top = build_info(VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, &boxes);
    if (!create_structure(r, &bottom, CUBE_TRIANGLES, &r->bottom) || !create_structure(r, &top, RAYGEN_MAX_BOXES, &r->top))
        return false;
    VkCommandBuffer cmd = gpu_begin(r->g);
    if (cmd) record_build(r, cmd, bottom, CUBE_TRIANGLES, &r->bottom);
    if (cmd && gpu_submit_and_wait(r->g)) return true;
    snprintf(r->error, r->error_size, "%s", gpu_error(r->g));
    return false;
}

static void destroy_structure(rt *r, structure *s)
{
    if (s->handle) r->fn.vkDestroyAccelerationStructureKHR(r->g->device, s->handle, NULL);
    destroy_buffer(r, &s->storage);
    destroy_buffer(r, &s->scratch);
}

/* ---- descriptors ----------------------------------------------------------------------------------------------- */

static VkDescriptorType type_of(uint32_t binding)
{
    switch (binding) {
    case RAYGEN_BIND_FRAME: return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    case RAYGEN_BIND_BOXES: return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    case RAYGEN_BIND_SCENE: return VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
    default: return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    }
}

static bool create_set(rt *r)
{
    gpu *g = r->g;
    VkDescriptorSetLayoutBinding bindings[RAYGEN_BIND_COUNT];
    VkDescriptorPoolSize sizes[RAYGEN_BIND_COUNT];
    for (uint32_t i = 0; i < RAYGEN_BIND_COUNT; i++) {
        bindings[i] = (VkDescriptorSetLayoutBinding){ i, type_of(i), 1,
                                                      VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, NULL };
        sizes[i] = (VkDescriptorPoolSize){ type_of(i), 1 };
    }
    VkDescriptorSetLayoutCreateInfo set_layout = { .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                   .bindingCount = RAYGEN_BIND_COUNT,
                                                   .pBindings = bindings };
    VkDescriptorPoolCreateInfo pool = { .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                        .maxSets = 1,
                                        .poolSizeCount = RAYGEN_BIND_COUNT,
                                        .pPoolSizes = sizes };
    if (!check(r, g->fn.vkCreateDescriptorSetLayout(g->device, &set_layout, NULL, &r->set_layout), "vkCreateDescriptorSetLayout")
        || !check(r, g->fn.vkCreateDescriptorPool(g->device, &pool, NULL, &r->pool), "vkCreateDescriptorPool"))
        return false;
    VkDescriptorSetAllocateInfo set = { .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                        .descriptorPool = r->pool,
                                        .descriptorSetCount = 1,
                                        .pSetLayouts = &r->set_layout };
    VkPipelineLayoutCreateInfo layout = { .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .setLayoutCount = 1,
                                          .pSetLayouts = &r->set_layout };
    return check(r, g->fn.vkAllocateDescriptorSets(g->device, &set, &r->set), "vkAllocateDescriptorSets")
           && check(r, g->fn.vkCreatePipelineLayout(g->device, &layout, NULL, &r->layout), "vkCreatePipelineLayout");
}

static void write_set(rt *r, const gpu_buffer *frame, const gpu_buffer *boxes, const gpu_image *const images[6])
{
    VkDescriptorBufferInfo buffers[2] = { { frame->buffer, 0, VK_WHOLE_SIZE }, { boxes->buffer, 0, VK_WHOLE_SIZE } };
    VkDescriptorImageInfo infos[6];
    VkWriteDescriptorSetAccelerationStructureKHR scene = { .sType =
                                                               VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR,
                                                           .accelerationStructureCount = 1,
                                                           .pAccelerationStructures = &r->top.handle };
    VkWriteDescriptorSet writes[RAYGEN_BIND_COUNT];
    for (uint32_t i = 0; i < RAYGEN_BIND_COUNT; i++)
        writes[i] = (VkWriteDescriptorSet){ .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = r->set,
                                            .dstBinding = i,
                                            .descriptorCount = 1,
                                            .descriptorType = type_of(i) };
    for (uint32_t i = 0; i < 6; i++) {
        infos[i] = (VkDescriptorImageInfo){ VK_NULL_HANDLE, images[i]->view, images[i]->layout };
        writes[RAYGEN_BIND_MV + i].pImageInfo = &infos[i];
    }
    writes[RAYGEN_BIND_FRAME].pBufferInfo = &buffers[0];
    writes[RAYGEN_BIND_BOXES].pBufferInfo = &buffers[1];
    writes[RAYGEN_BIND_SCENE].pNext = &scene;
    r->g->fn.vkUpdateDescriptorSets(r->g->device, RAYGEN_BIND_COUNT, writes, 0, NULL);
}

/* ---- pipeline -------------------------------------------------------------------------------------------------- */

enum { STAGE_RAY_GENERATION, STAGE_MISS, STAGE_HIT, STAGE_COUNT };

static bool create_stage(rt *r, const uint32_t *words, size_t size_bytes, VkShaderStageFlagBits stage,
                         VkPipelineShaderStageCreateInfo *out)
{
    VkShaderModuleCreateInfo info = { .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                      .codeSize = size_bytes,
                                      .pCode = words };
    *out = (VkPipelineShaderStageCreateInfo){ .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                              .stage = stage,
                                              .pName = "main" };
    return check(r, r->g->fn.vkCreateShaderModule(r->g->device, &info, NULL, &out->module), "vkCreateShaderModule");
}

static VkRayTracingShaderGroupCreateInfoKHR group(VkRayTracingShaderGroupTypeKHR type, uint32_t general, uint32_t closest_hit)
{
    return (VkRayTracingShaderGroupCreateInfoKHR){ .sType = VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR,
                                                   .type = type,
                                                   .generalShader = general,
                                                   .closestHitShader = closest_hit,
                                                   .anyHitShader = VK_SHADER_UNUSED_KHR,
                                                   .intersectionShader = VK_SHADER_UNUSED_KHR };
}

static bool create_pipeline(rt *r)
{
    gpu *g = r->g;
    VkPipelineShaderStageCreateInfo stages[STAGE_COUNT];
    memset(stages, 0, sizeof stages);
    bool ok = create_stage(r, primary_rgen, sizeof primary_rgen, VK_SHADER_STAGE_RAYGEN_BIT_KHR, &stages[STAGE_RAY_GENERATION])
              && create_stage(r, sky_rmiss, sizeof sky_rmiss, VK_SHADER_STAGE_MISS_BIT_KHR, &stages[STAGE_MISS])
              && create_stage(r, surface_rchit, sizeof surface_rchit, VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, &stages[STAGE_HIT]);
    VkRayTracingShaderGroupCreateInfoKHR groups[STAGE_COUNT] = {
        group(VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR, STAGE_RAY_GENERATION, VK_SHADER_UNUSED_KHR),
        group(VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR, STAGE_MISS, VK_SHADER_UNUSED_KHR),
        group(VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR, VK_SHADER_UNUSED_KHR, STAGE_HIT)
    };
    VkRayTracingPipelineCreateInfoKHR info = { .sType = VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR,
                                               .stageCount = STAGE_COUNT,
                                               .pStages = stages,
                                               .groupCount = STAGE_COUNT,
                                               .pGroups = groups,
                                               .maxPipelineRayRecursionDepth = 1,
                                               .layout = r->layout };
    ok = ok
         && check(r, r->fn.vkCreateRayTracingPipelinesKHR(g->device, VK_NULL_HANDLE, VK_NULL_HANDLE, 1, &info, NULL, &r->pipeline),
                  "vkCreateRayTracingPipelinesKHR");
    for (int i = 0; i < STAGE_COUNT; i++)
        if (stages[i].module) g->fn.vkDestroyShaderModule(g->device, stages[i].module, NULL);
    return ok;
}

/* One record per group, each at a multiple of the base alignment, so that each may begin a region. */
static bool create_table(rt *r)
{
    VkDeviceSize size = r->limits.shaderGroupHandleSize, base = r->limits.shaderGroupBaseAlignment, stride = align_up(size, base);
    uint8_t *handles = malloc(STAGE_COUNT * size);
    bool ok =
        handles && create_buffer(r, STAGE_COUNT * stride + base, VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR, true, &r->table)
        && check(r,
                 r->fn.vkGetRayTracingShaderGroupHandlesKHR(r->g->device, r->pipeline, 0, STAGE_COUNT, STAGE_COUNT * size, handles),
                 "vkGetRayTracingShaderGroupHandlesKHR");
    VkStridedDeviceAddressRegionKHR *regions[STAGE_COUNT] = { &r->ray_generation, &r->miss, &r->hit };
    VkDeviceAddress first = align_up(r->table.address, base);
    for (uint32_t i = 0; ok && i < STAGE_COUNT; i++) {
        memcpy((char *)r->table.mapped + (first - r->table.address) + i * stride, handles + i * size, size);
        *regions[i] = (VkStridedDeviceAddressRegionKHR){ first + i * stride, stride, stride };
    }
    free(handles);
    return ok;
}

/* ---- use ------------------------------------------------------------------------------------------------------- */

rt *rt_create(gpu *g, const gpu_buffer *frame, const gpu_buffer *boxes, const gpu_image *const images[6], char *error,
              size_t error_size)
{
    rt *r = calloc(1, sizeof *r);
    if (!r) return snprintf(error, error_size, "out of memory"), NULL;
    r->g = g;
    r->error = error;
    r->error_size = error_size;
    if (load_functions(r) && create_structures(r) && create_set(r) && create_pipeline(r) && create_table(r)) {
        write_set(r, frame, boxes, images);
        return r;
    }
    rt_destroy(r);
    return NULL;
}

void rt_destroy(rt *r)
{
    if (!r) return;
    gpu *g = r->g;
    g->fn.vkDeviceWaitIdle(g->device);
    if (r->pipeline) g->fn.vkDestroyPipeline(g->device, r->pipeline, NULL);
    if (r->layout) g->fn.vkDestroyPipelineLayout(g->device, r->layout, NULL);
    if (r->pool) g->fn.vkDestroyDescriptorPool(g->device, r->pool, NULL);
    if (r->set_layout) g->fn.vkDestroyDescriptorSetLayout(g->device, r->set_layout, NULL);
    destroy_structure(r, &r->top);
    destroy_structure(r, &r->bottom);
    destroy_buffer(r, &r->table);
    destroy_buffer(r, &r->instances);
    destroy_buffer(r, &r->cube);
    free(r);
}

void rt_place(rt *r, const raygen_box *boxes, uint32_t count)
{
    VkAccelerationStructureInstanceKHR *instances = r->instances.mapped;
    VkAccelerationStructureDeviceAddressInfoKHR bottom = { .sType =
                                                               VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
                                                           .accelerationStructure = r->bottom.handle };
    VkDeviceAddress address = r->fn.vkGetAccelerationStructureDeviceAddressKHR(r->g->device, &bottom);
    for (uint32_t i = 0; i < count; i++) {
        VkAccelerationStructureInstanceKHR instance = { .instanceCustomIndex = i,
                                                        .mask = 0xff,
                                                        .accelerationStructureReference = address,
                                                        .flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR };
        const nrd_vec4 rows[3] = { boxes[i].to_world_x, boxes[i].to_world_y, boxes[i].to_world_z };
        memcpy(&instance.transform, rows, sizeof instance.transform);
        instances[i] = instance;
    }
}

void rt_record(rt *r, VkCommandBuffer cmd, uint32_t box_count, uint32_t width, uint32_t height)
{
    static const VkStridedDeviceAddressRegionKHR none;
    VkAccelerationStructureGeometryKHR boxes = box_geometry(r);
    record_build(r, cmd, build_info(VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, &boxes), box_count, &r->top);
    r->g->fn.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, r->pipeline);
    r->g->fn.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, r->layout, 0, 1, &r->set, 0, NULL);
    r->fn.vkCmdTraceRaysKHR(cmd, &r->ray_generation, &r->miss, &r->hit, &none, width, height, 1);
}
