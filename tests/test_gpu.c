/* The Vulkan bootstrap of examples/common/gpu.h: transfers keep every bit, kernels see their bindings. */
#include "common/gpu.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define OP(words, code) ((uint32_t)(words) << 16 | (code))

/* SPIR-V of: layout(local_size_x = 1) in; layout(constant_id = 0) const uint factor = 1;
   buffer { uint data[]; }; push { uint bias; };
   void main() { uint i = gl_GlobalInvocationID.x; data[i] = data[i] * factor + bias; } */
static const uint32_t multiply_add[] = {
    0x07230203, 0x00010300, 0, 40, 0,
    OP(2, 17), 1,                                        /* Capability Shader */
    OP(3, 14), 0, 1,                                     /* MemoryModel Logical GLSL450 */
    OP(6, 15), 5, 1, 0x6e69616d, 0, 2,                   /* EntryPoint GLCompute %1 "main" %2 */
    OP(6, 16), 1, 17, 1, 1, 1,                           /* ExecutionMode LocalSize 1 1 1 */
    OP(4, 71), 2, 11, 28,                                /* Decorate %2 BuiltIn GlobalInvocationId */
    OP(4, 71), 10, 6, 4,                                 /* Decorate %10 ArrayStride 4 */
    OP(5, 72), 11, 0, 35, 0,                             /* MemberDecorate %11 0 Offset 0 */
    OP(3, 71), 11, 3,                                    /* Decorate %11 BufferBlock */
    OP(4, 71), 13, 34, 0, OP(4, 71), 13, 33, 0,          /* Decorate %13 DescriptorSet 0, Binding 0 */
    OP(5, 72), 14, 0, 35, 0,                             /* MemberDecorate %14 0 Offset 0 */
    OP(3, 71), 14, 2,                                    /* Decorate %14 Block */
    OP(4, 71), 17, 1, 0,                                 /* Decorate %17 SpecId 0 */
    OP(2, 19), 3, OP(3, 33), 4, 3,                       /* %3 void, %4 void() */
    OP(4, 21), 5, 32, 0, OP(4, 23), 6, 5, 3,             /* %5 uint, %6 uvec3 */
    OP(4, 32), 7, 1, 6, OP(4, 59), 7, 2, 1,              /* %2 the invocation id */
    OP(4, 43), 5, 8, 0,                                  /* %8 = 0u */
    OP(4, 32), 9, 1, 5,                                  /* %9 pointer to input uint */
    OP(3, 29), 10, 5, OP(3, 30), 11, 10,                 /* %10 uint[], %11 the buffer's struct */
    OP(4, 32), 12, 2, 11, OP(4, 59), 12, 13, 2,          /* %13 the buffer */
    OP(3, 30), 14, 5, OP(4, 32), 15, 9, 14, OP(4, 59), 15, 16, 9, /* %16 the push constants */
    OP(4, 50), 5, 17, 1,                                 /* %17 = specialization constant, default 1u */
    OP(4, 32), 18, 2, 5, OP(4, 32), 19, 9, 5,            /* %18 pointer into buffer, %19 into push constants */
    OP(5, 54), 3, 1, 0, 4, OP(2, 248), 20,               /* main */
    OP(5, 65), 9, 21, 2, 8, OP(4, 61), 5, 22, 21,        /* %22 = id.x */
    OP(6, 65), 18, 23, 13, 8, 22, OP(4, 61), 5, 24, 23,  /* %24 = data[id.x] */
    OP(5, 132), 5, 25, 24, 17,                           /* * factor */
    OP(5, 65), 19, 26, 16, 8, OP(4, 61), 5, 27, 26,      /* %27 = bias */
    OP(5, 128), 5, 28, 25, 27, OP(3, 62), 23, 28,        /* store the sum */
    OP(1, 253), OP(1, 56),
};

static int open_device(void **state)
{
    gpu *g = (gpu *)malloc(sizeof *g);
    bool validation = gpu_validation_available();
    char error[256];
    if (!g || !gpu_open(g, &(gpu_desc){.validation = validation, .sync_validation = validation}, error, sizeof error)) {
        print_error("%s\n", g ? error : "out of memory");
        free(g);
        return -1;
    }
    *state = g;
    return 0;
}

static int close_device(void **state)
{
    gpu *g = (gpu *)*state;
    int failed = gpu_message_count(g) != 0;
    gpu_close(g);
    free(g);
    return failed;
}

static void round_trip(gpu *g, VkFormat format, uint32_t width, uint32_t height)
{
    size_t size = (size_t)width * height * gpu_format_size(format);
    unsigned char *sent = (unsigned char *)malloc(size), *received = (unsigned char *)calloc(1, size);
    gpu_image image;
    assert_non_null(sent);
    assert_non_null(received);
    for (size_t i = 0; i < size; ++i) sent[i] = (unsigned char)(i * 37u % 59u); /* no NaN in any float format */
    assert_true(gpu_image_create(g, width, height, format, "round trip", &image));
    assert_true(gpu_upload(g, &image, sent));
    assert_true(gpu_download(g, &image, received));
    assert_memory_equal(sent, received, size);
    gpu_image_destroy(g, &image);
    assert_true(image.image == VK_NULL_HANDLE);
    free(sent);
    free(received);
}

static void an_uploaded_image_comes_back_bit_by_bit(void **state)
{
    static const VkFormat formats[] = {
        VK_FORMAT_R8_UNORM,  VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_R16_SFLOAT,
        VK_FORMAT_R32_UINT,  VK_FORMAT_R32_SFLOAT,     VK_FORMAT_R16G16B16A16_SFLOAT,      VK_FORMAT_R32G32B32A32_SFLOAT,
    };
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; ++i) round_trip((gpu *)*state, formats[i], 13, 7);
}

static void a_large_transfer_after_a_small_one_grows_the_staging_buffer(void **state)
{
    round_trip((gpu *)*state, VK_FORMAT_R8_UNORM, 1, 1);
    round_trip((gpu *)*state, VK_FORMAT_R32_SFLOAT, 300, 200);
}

static void a_kernel_sees_buffer_push_constant_and_specialization(void **state)
{
    gpu *g = (gpu *)*state;
    const VkDescriptorType types[] = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER};
    const uint32_t factor = 3, bias = 5;
    gpu_kernel kernel;
    gpu_buffer buffer;
    assert_true(gpu_kernel_create(g,
                                  &(gpu_kernel_desc){.words = multiply_add, .size_bytes = sizeof multiply_add,
                                                     .types = types, .type_count = 1, .push_size = sizeof bias,
                                                     .constants = &factor, .constant_count = 1},
                                  &kernel));
    assert_true(gpu_buffer_create(g, 16 * sizeof(uint32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, &buffer));
    uint32_t *data = (uint32_t *)buffer.mapped;
    for (uint32_t i = 0; i < 16; ++i) data[i] = i;
    gpu_kernel_bind_buffer(g, &kernel, 0, &buffer);
    assert_non_null(gpu_begin(g));
    gpu_kernel_dispatch(g, &kernel, &bias, sizeof bias, 16, 1, 1);
    gpu_kernel_dispatch(g, &kernel, &bias, sizeof bias, 8, 1, 1); /* the first half twice */
    assert_true(gpu_submit_and_wait(g));
    for (uint32_t i = 0; i < 16; ++i) assert_int_equal(data[i], i < 8 ? (i * 3 + 5) * 3 + 5 : i * 3 + 5);
    gpu_buffer_destroy(g, &buffer);
    gpu_kernel_destroy(g, &kernel);
}

typedef struct sharer {
    pthread_t thread;
    gpu *owner;
    uint32_t seed;
    bool ok;
} sharer;

static void *work_on_shared_device(void *argument)
{
    sharer *s = (sharer *)argument;
    gpu g;
    gpu_buffer buffer = {VK_NULL_HANDLE, VK_NULL_HANDLE, 0, NULL};
    uint32_t sent[64], received[64];
    const VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    for (uint32_t i = 0; i < 64; ++i) sent[i] = s->seed * 64 + i;
    if (!gpu_open(&g, &(gpu_desc){.shared = s->owner}, NULL, 0)) return NULL;
    s->ok = g.device == s->owner->device && g.cmd != s->owner->cmd && gpu_buffer_create_local(&g, sizeof sent, usage, &buffer);
    for (int i = 0; i < 20 && s->ok; ++i)
        s->ok = gpu_buffer_upload(&g, &buffer, sent, sizeof sent) && gpu_buffer_download(&g, &buffer, received, sizeof received) &&
                memcmp(sent, received, sizeof sent) == 0;
    gpu_buffer_destroy(&g, &buffer);
    gpu_close(&g);
    return NULL;
}

/* Under the validation layer, which close_device asks for complaints. */
static void several_threads_share_a_device(void **state)
{
    sharer sharers[4];
    for (uint32_t i = 0; i < 4; ++i) {
        sharers[i] = (sharer){.owner = (gpu *)*state, .seed = i, .ok = false};
        assert_int_equal(pthread_create(&sharers[i].thread, NULL, work_on_shared_device, &sharers[i]), 0);
    }
    for (uint32_t i = 0; i < 4; ++i) {
        pthread_join(sharers[i].thread, NULL);
        assert_true(sharers[i].ok);
    }
    an_uploaded_image_comes_back_bit_by_bit(state); /* still open */
}

static void a_wrong_size_is_refused_with_a_reason(void **state)
{
    gpu *g = (gpu *)*state;
    gpu_image image;
    assert_false(gpu_image_create(g, 0, 4, VK_FORMAT_R8_UNORM, "broken", &image));
    assert_non_null(strstr(gpu_error(g), "image broken: size is 0x4"));
}

static void a_device_that_is_not_there_is_named(void **state)
{
    gpu g;
    char error[256];
    (void)state;
    assert_false(gpu_open(&g, &(gpu_desc){.device_index = 12}, error, sizeof error));
    assert_non_null(strstr(error, "device_index is 12"));
    assert_null(g.instance);
    gpu_close(&g);
}

static void misuse_is_counted_when_validation_is_there(void **state)
{
    (void)state;
    gpu g;
    char error[256];
    if (!gpu_validation_available()) {
        assert_false(gpu_open(&g, &(gpu_desc){.validation = true}, error, sizeof error));
        assert_non_null(strstr(error, "VK_LAYER_KHRONOS_validation"));
        return;
    }
    assert_true(gpu_open(&g, &(gpu_desc){.validation = true}, error, sizeof error));
    print_message("one validation error is provoked here:\n");
    VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = 4}; /* usage 0 is an error */
    VkBuffer buffer = VK_NULL_HANDLE;
    if (g.fn.vkCreateBuffer(g.device, &info, NULL, &buffer) == VK_SUCCESS)
        g.fn.vkDestroyBuffer(g.device, buffer, NULL);
    assert_int_equal(gpu_message_count(&g), 1);
    gpu_close(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_uploaded_image_comes_back_bit_by_bit),
        cmocka_unit_test(a_large_transfer_after_a_small_one_grows_the_staging_buffer),
        cmocka_unit_test(a_kernel_sees_buffer_push_constant_and_specialization),
        cmocka_unit_test(several_threads_share_a_device),
        cmocka_unit_test(a_wrong_size_is_refused_with_a_reason),
        cmocka_unit_test(a_device_that_is_not_there_is_named),
        cmocka_unit_test(misuse_is_counted_when_validation_is_there),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
