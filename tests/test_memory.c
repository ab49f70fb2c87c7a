/* Memory: as little as can be, known before it is taken, and the app's to lend. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "stage.h"

/* ---------------------------------------------------------------------------------------------------------------------------
   The lower bound  >>bound */
/* No placement takes less than what is live during one pass. */
static uint64_t lower_bound(const nrd_info *info)
{
    uint64_t most = 0;
    for (uint32_t p = 0; p < info->pass_count; p++) {
        uint64_t live = 0;
        for (uint32_t t = 0; t < info->texture_count; t++) {
            const nrd_texture *texture = &info->textures[t];
            live += !texture->permanent && texture->first_pass <= p && p <= texture->last_pass ? texture->bytes : 0;
        }
        if (live > most) most = live;
    }
    return most;
}

static void check_bound(const nrd_denoiser_desc *list, uint32_t count, uint32_t features, uint32_t absent)
{
    spy s = { 0 };
    nrd *instance = NULL;
    nrd_desc desc = spied_desc(&s, list, count, 1920, 1080, features);
    desc.absent = absent;
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    const nrd_info *info = nrd_get_info(instance);
    uint64_t least = lower_bound(info);
    if (!(info->transient_bytes >= least && info->transient_bytes <= least + least / 20 + 256 * (uint64_t)info->texture_count))
        fail_msg("%s and %u more: %llu bytes, at least %llu", nrd_denoiser_name(list[0].denoiser), count - 1, (unsigned long long)info->transient_bytes, (unsigned long long)least);
    nrd_destroy(instance);
}

static void transient_memory_of_every_pair_is_within_5_percent_of_the_lower_bound(void **state)
{
    (void)state;
    for (uint32_t a = 0; a < NRD_DENOISER_COUNT; a++)
        for (uint32_t b = 0; b <= NRD_DENOISER_COUNT; b++)
            for (uint32_t k = 0; k < 4; k++) {
                nrd_denoiser_desc list[] = { { 1, (nrd_denoiser)a }, { 2, (nrd_denoiser)(b % NRD_DENOISER_COUNT) } };
                check_bound(list, b < NRD_DENOISER_COUNT ? 2 : 1, k & 1 ? NRD_FEATURE_ALL : 0, k & 2 ? NRD_ABSENT_STABILIZATION | NRD_ABSENT_MOTION : 0);
            }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   The app's memory  >>lent */
/* One block of the app; the transient block of the denoiser lies in it, behind something else, and the app writes over all of it. */
typedef struct lender {
    VkMemoryRequirements needs[3]; /* as told before */
    uint32_t asked;                /* a bit for each kind */
    VkDeviceMemory memory[3];
    VkBuffer whole;                /* all of the transient block */
} lender;

static lender app;
enum { GAP = 1 << 16 };

static VkDeviceMemory take(VkDeviceSize bytes, uint32_t types)
{
    VkDeviceMemory memory = VK_NULL_HANDLE;
    for (uint32_t i = 0; i < device.memory.memoryTypeCount && !memory; i++) {
        VkMemoryPropertyFlags wanted = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
        VkMemoryAllocateInfo info = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = bytes, .memoryTypeIndex = i };
        if ((types >> i & 1) && (device.memory.memoryTypes[i].propertyFlags & wanted) == wanted)
            assert_int_equal(device.fn.vkAllocateMemory(device.device, &info, NULL, &memory), VK_SUCCESS);
    }
    assert_true(memory != VK_NULL_HANDLE);
    return memory;
}

static void create_whole(VkDeviceSize bytes, uint32_t types)
{
    VkBufferCreateInfo info = { .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT };
    VkMemoryRequirements needs;
    assert_int_equal(device.fn.vkCreateBuffer(device.device, &info, NULL, &app.whole), VK_SUCCESS);
    device.fn.vkGetBufferMemoryRequirements(device.device, app.whole, &needs);
    app.memory[NRD_VK_MEMORY_TRANSIENT] = take(needs.size, types & needs.memoryTypeBits);
    assert_int_equal(device.fn.vkBindBufferMemory(device.device, app.whole, app.memory[NRD_VK_MEMORY_TRANSIENT], 0), VK_SUCCESS);
}

static VkResult lend(void *user, nrd_vk_memory_kind kind, const VkMemoryRequirements *needs, nrd_vk_memory *out)
{
    lender *l = (lender *)user;
    l->asked |= 1u << kind;
    assert_int_equal(needs->size, l->needs[kind].size);
    assert_int_equal(needs->alignment, l->needs[kind].alignment);
    assert_int_equal(needs->memoryTypeBits, l->needs[kind].memoryTypeBits);
    if (kind == NRD_VK_MEMORY_TRANSIENT) {
        out->offset = (GAP + needs->alignment - 1) / needs->alignment * needs->alignment;
        create_whole(out->offset + needs->size + GAP, needs->memoryTypeBits);
    } else {
        l->memory[kind] = take(needs->size, needs->memoryTypeBits);
    }
    out->memory = l->memory[kind];
    return kind == NRD_VK_MEMORY_CONSTANTS ? device.fn.vkMapMemory(device.device, out->memory, 0, VK_WHOLE_SIZE, 0, &out->mapped) : VK_SUCCESS;
}

static void take_back(void *user, nrd_vk_memory_kind kind, const nrd_vk_memory *memory)
{
    lender *l = (lender *)user;
    assert_true(memory->memory == l->memory[kind]);
    if (kind == NRD_VK_MEMORY_TRANSIENT) device.fn.vkDestroyBuffer(device.device, l->whole, NULL);
    device.fn.vkFreeMemory(device.device, l->memory[kind], NULL);
    l->asked &= ~(1u << kind);
}

/* The app's own use of the block between two frames; all ones are NaN in most formats. */
static void scribble(VkCommandBuffer cmd)
{
    PFN_vkCmdFillBuffer fill = (PFN_vkCmdFillBuffer)device.get_device_proc(device.device, "vkCmdFillBuffer");
    assert_non_null(fill);
    if (app.whole) fill(cmd, app.whole, 0, VK_WHOLE_SIZE, 0xffffffffu);
}

static void ask_needs(nrd_denoiser denoiser, VkMemoryRequirements needs[3])
{
    spy s;
    nrd *instance = create_one(&s, denoiser, STAGE_WIDTH, STAGE_HEIGHT, 0);
    nrd_vk_desc desc = { .instance = instance, .vk_instance = device.instance, .physical = device.physical, .device = device.device,
                         .get_instance_proc = device.get_instance_proc, .frames_in_flight = 1 };
    assert_int_equal(nrd_vk_memory_needs(&desc, needs), NRD_RESULT_OK);
    assert_true(needs[NRD_VK_MEMORY_PERMANENT].size >= nrd_get_info(instance)->permanent_bytes);
    assert_int_equal(nrd_vk_memory_needs(&desc, NULL), NRD_RESULT_INVALID_ARGUMENT);
    assert_non_null(strstr(s.text, "needs is NULL"));
    assert_int_equal(nrd_vk_memory_needs(NULL, needs), NRD_RESULT_INVALID_ARGUMENT);
    nrd_destroy(instance);
}

static void sizes_are_told_before_creation_and_the_app_may_write_over_the_transient_block_between_frames(void **state)
{
    const nrd_vk_desc callbacks = { .allocate_memory = lend, .free_memory = take_back, .memory_user = &app };
    stage own, lent;
    (void)state;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        memset(&app, 0, sizeof app);
        ask_needs((nrd_denoiser)d, app.needs);
        stage_open(&own, (nrd_denoiser)d, 0, NULL);
        stage_open(&lent, (nrd_denoiser)d, 0, &callbacks);
        static const char *const nothing[3] = { NULL, NULL, NULL };
        stage_set(&own, nothing);
        stage_set(&lent, nothing);
        for (uint32_t k = 0; k < 3; k++) assert_int_equal(app.asked >> k & 1, app.needs[k].size > 0);
        for (uint32_t i = 0; i < 3; i++) {
            stage_run(&own, i, NULL);
            stage_run(&lent, i, scribble);
            stage_assert_same(&own, &lent, "lent memory");
        }
        stage_close(&own);
        stage_close(&lent);
        assert_int_equal(app.asked, 0);
    }
    assert_int_equal(gpu_message_count(&device), 0);
}

/* In shares of what the best-known denoiser of shadows takes: 31.9 and 50.8 MB. */
static void shadows_take_three_fifths_of_what_others_do(void **state)
{
    static const struct { nrd_denoiser denoiser; double others_mb; } rows[] = { { NRD_DENOISER_SIGMA_SHADOW, 31.9 }, { NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY, 50.8 } };
    (void)state;
    for (int i = 0; i < 2; i++) {
        spy s = { 0 };
        nrd_denoiser_desc one = { 1, rows[i].denoiser };
        nrd_desc desc = spied_desc(&s, &one, 1, 1920, 1080, 0);
        nrd *instance;
        assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
        double mb = (double)(nrd_get_info(instance)->permanent_bytes + nrd_get_info(instance)->transient_bytes) * 1e-6;
        if (!(mb <= 0.6 * rows[i].others_mb)) fail_msg("%s: %g MB", nrd_denoiser_name(rows[i].denoiser), mb);
        nrd_destroy(instance);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transient_memory_of_every_pair_is_within_5_percent_of_the_lower_bound),
        cmocka_unit_test(shadows_take_three_fifths_of_what_others_do),
        cmocka_unit_test(sizes_are_told_before_creation_and_the_app_may_write_over_the_transient_block_between_frames),
    };
    return cmocka_run_group_tests(tests, open_validated_device, close_device);
}
