/* shader_math_rig.h: functions of nrd_shaders/nrd.glsl on many cases: on the device, compiled with optimisation and without,
   on the host through nrd_c.h, and in double precision. Each test program brings the inputs and the double precision. */
#ifndef TESTS_SHADER_MATH_RIG_H
#define TESTS_SHADER_MATH_RIG_H

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NRD_C_ALSO "shader_math.glsl"
#include "nrd_shaders/nrd_c.h"

#include "common/gpu.h"
#include "nrd_reference.h"
#include "shader_math.h"
#include "tests/shader_math_debug_spirv.h"
#include "tests/shader_math_spirv.h"

#define MAX_CASES 65536u
#define RANDOM_CASES 16384u
#define DEGREES 57.295779513082321
#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* ---- device ---------------------------------------------------------------------------------------------------- */

typedef struct push_constants {
    uint32_t operation, count;
} push_constants;

static struct {
    gpu gpu;
    gpu_kernel kernel, debug_kernel; /* compiled for size; compiled without any optimisation */
    gpu_buffer cases, results;
    gpu_image guide, half;
    float *in, *out; /* mapped cases and results */
} device;

static inline void require(bool ok) {
    if (!ok) fail_msg("%s", gpu_error(&device.gpu));
}

static inline void open_kernel(const uint32_t *words, size_t size_bytes, gpu_kernel *kernel) {
    static const VkDescriptorType types[] = {
        VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
        VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE};
    gpu_kernel_desc desc = {.words = words, .size_bytes = size_bytes, .types = types, .type_count = COUNT(types),
                            .push_size = sizeof(push_constants)};
    gpu *g = &device.gpu;
    require(gpu_kernel_create(g, &desc, kernel));
    gpu_kernel_bind_buffer(g, kernel, 0, &device.cases);
    gpu_kernel_bind_buffer(g, kernel, 1, &device.results);
    gpu_kernel_bind_image(g, kernel, 2, &device.guide);
    gpu_kernel_bind_image(g, kernel, 3, &device.half);
}

static inline int open_device(void **state) {
    gpu_desc desc = {.validation = gpu_validation_available()};
    VkFormat half = VK_FORMAT_R16G16B16A16_SFLOAT;
    VkBufferUsageFlags storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    uint32_t rows = MAX_CASES / SM_WIDTH;
    char error[256];
    gpu *g = &device.gpu;
    (void)state;

    if (!gpu_open(g, &desc, error, sizeof error)) {
        print_error("%s\n", error);
        return -1;
    }
    require(gpu_buffer_create(g, MAX_CASES * SM_INPUTS * sizeof(float), storage, &device.cases));
    require(gpu_buffer_create(g, MAX_CASES * SM_OUTPUTS * sizeof(float), storage, &device.results));
    require(gpu_image_create(g, SM_WIDTH, rows, half, "guide", &device.guide));
    require(gpu_image_create(g, SM_WIDTH, rows, half, "half", &device.half));
    open_kernel(shader_math_spirv, sizeof shader_math_spirv, &device.kernel);
    open_kernel(shader_math_debug_spirv, sizeof shader_math_debug_spirv, &device.debug_kernel);
    device.in = device.cases.mapped;
    device.out = device.results.mapped;
    return 0;
}

static inline int close_device(void **state) {
    gpu *g = &device.gpu;
    (void)state;
    gpu_image_destroy(g, &device.guide);
    gpu_image_destroy(g, &device.half);
    gpu_buffer_destroy(g, &device.cases);
    gpu_buffer_destroy(g, &device.results);
    gpu_kernel_destroy(g, &device.kernel);
    gpu_kernel_destroy(g, &device.debug_kernel);
    gpu_close(g);
    return 0;
}

static inline float *case_in(size_t i) {
    return device.in + i * SM_INPUTS;
}

static inline const float *case_out(size_t i) {
    return device.out + i * SM_OUTPUTS;
}

static inline void run_kernel(gpu_kernel *kernel, uint32_t operation, uint32_t count) {
    push_constants push = {operation, count};
    assert_true(count <= MAX_CASES);
    require(gpu_begin(&device.gpu) != NULL);
    gpu_kernel_dispatch(&device.gpu, kernel, &push, sizeof push, (count + SM_GROUP - 1) / SM_GROUP, 1, 1);
    require(gpu_submit_and_wait(&device.gpu));
}

/* Evaluates `operation` on the first `count` cases. */
static inline void run(uint32_t operation, uint32_t count) {
    run_kernel(&device.kernel, operation, count);
}

/* The same for one case on the host. */
static inline void run_on_host(uint32_t operation, const float *in, float *out) {
    test_case t;
    memset(&t, 0, sizeof t);
    memcpy(&t.a, in, SM_INPUTS * sizeof *in);
    t = evaluate(operation, t);
    memcpy(out, &t.x, SM_OUTPUTS * sizeof *out);
}

static inline void set_case(size_t i, size_t first, size_t count, const float *values) {
    memcpy(case_in(i) + first, values, count * sizeof *values);
}

static inline void clear_cases(size_t count) {
    memset(device.in, 0, count * SM_INPUTS * sizeof *device.in);
}

static inline void to_doubles(const float *in, double *out, size_t count) {
    for (size_t i = 0; i < count; ++i) out[i] = in[i];
}

static inline void assert_near(const float *actual, const double *expected, size_t count, double tolerance) {
    for (size_t i = 0; i < count; ++i) {
        if (fabs(actual[i] - expected[i]) <= tolerance) continue;
        fail_msg("component %zu is %.9g, expected %.9g within %g", i, actual[i], expected[i], tolerance);
    }
}

static inline void validation_layer_has_no_complaint(void **state) {
    (void)state;
    if (!gpu_validation_available()) skip();
    assert_int_equal(gpu_message_count(&device.gpu), 0);
}

/* ---- inputs ---------------------------------------------------------------------------------------------------- */

static uint32_t random_state;

/* PCG, 32 bits of output (O'Neill 2014). */
static inline uint32_t random_u32(void) {
    uint32_t s = random_state = random_state * 747796405u + 2891336453u;
    uint32_t word = ((s >> ((s >> 28) + 4)) ^ s) * 277803737u;
    return (word >> 22) ^ word;
}

static inline float random_unit(void) {
    return (float)(random_u32() >> 8) * (1.0f / 16777215.0f);
}

static inline float random_between(float low, float high) {
    return low + (high - low) * random_unit();
}

static inline float random_log(float low, float high) {
    return (float)exp(log(low) + log(high / low) * random_unit());
}

/* One of the edge values in a quarter of all cases. */
static inline float edge_or(float value, const float *edges, size_t count) {
    return random_u32() % 4 ? value : edges[random_u32() % count];
}

static inline float pick_unit(void) {
    static const float edges[] = {0.0f, 1.0f, 0.5f, 1e-3f, 1e-20f, 1e-40f, 0.999999f};
    return edge_or(random_unit(), edges, COUNT(edges));
}

static inline float pick_roughness_or_bad(void) {
    static const float edges[] = {0.0f, 1.0f, 0.003f, 1e-40f, -0.5f, 2.0f, NAN, INFINITY, -INFINITY};
    return edge_or(random_unit(), edges, COUNT(edges));
}

static inline float pick_hit_dist(void) {
    static const float edges[] = {0.0f,     -0.0f, -1.0f,   1e-30f, 65503.0f, 65504.0f,
                                  1e9f, 3.4e38f, NAN, INFINITY, -INFINITY};
    return edge_or(random_log(1e-4f, 1e5f), edges, COUNT(edges));
}

static inline float pick_any(void) {
    static const float edges[] = {0.0f,     -0.0f,    1.0f,     -1.0f, 1e-40f,  -1e-40f,  5.9e-8f, 6.1e-5f,  65504.0f,
                                  65519.9f, 65520.0f, -65520.f, 1e9f,  3.4e38f, -3.4e38f, NAN,     INFINITY, -INFINITY};
    return edge_or(random_log(1e-10f, 1e6f) * (random_u32() % 2 ? 1.0f : -1.0f), edges, COUNT(edges));
}

static inline float pick_finite(void) {
    float value;
    do value = pick_any();
    while (!isfinite(value));
    return value;
}

static inline float pick_radiance(void) {
    static const float edges[] = {0.0f, 1.0f, 1e-30f, 65504.0f};
    return edge_or(random_log(1e-4f, 1e4f), edges, COUNT(edges));
}

static inline float pick_view_z(void) {
    static const float edges[] = {0.0f, -0.0f, 0.01f, 5e5f, -5e5f};
    return edge_or(random_log(0.01f, 1e4f) * (random_u32() % 2 ? 1.0f : -1.0f), edges, COUNT(edges));
}

static inline void random_direction(float n[3]) {
    float z = random_between(-1.0f, 1.0f), angle = random_between(0.0f, 6.2831853f);
    float radius = sqrtf(fmaxf(1.0f - z * z, 0.0f));
    n[0] = radius * cosf(angle), n[1] = radius * sinf(angle), n[2] = z;
}

/* Random directions; a quarter are axes, equator directions with z = +0 and -0, and unusable vectors. */
static inline void pick_normal(float n[3]) {
    static const float edges[][3] = {{1, 0, 0},       {-1, 0, 0},           {0, 1, 0},       {0, -1, 0},     {0, 0, 1},
                                     {0, 0, -1},      {0.6f, 0.8f, 0.0f},   {0.8f, -0.6f, -0.0f}, {0, 0, 0},
                                     {NAN, 0, 1},     {0, INFINITY, 0},     {0, 0, -INFINITY}};
    random_direction(n);
    if (random_u32() % 4 == 0) memcpy(n, edges[random_u32() % COUNT(edges)], sizeof edges[0]);
}

/* ---- comparison ------------------------------------------------------------------------------------------------ */

/* Error of a component: |result - reference| / max(|reference|, floor): relative above `floor`, absolute over `floor`
   below. `floor` is the size of the terms that cancel in the function. bound 0: equal. */
typedef struct comparison {
    const char *name;
    uint32_t operation;
    void (*fill)(float *in);
    void (*reference)(const double *in, double *out);
    int outputs; /* the first so many are compared */
    double floor, bound;
} comparison;

static inline double error_of(double value, double reference_value, double floor) {
    if (value == 0 && fabs(reference_value) < FLT_MIN) return 0.0; /* a device may flush denormals */
    double error = fabs(value - reference_value) / fmax(fabs(reference_value), floor);
    return isnan(error) ? INFINITY : error;
}

static inline void print_case(const comparison *c, const float *in, const float *out, const double *expected) {
    print_error("%s\n  in    ", c->name);
    for (int k = 0; k < SM_INPUTS; ++k) print_error(" %.9g", in[k]);
    print_error("\n  result");
    for (int k = 0; k < c->outputs; ++k) print_error(" %.9g", out[k]);
    print_error("\n  double");
    for (int k = 0; k < c->outputs; ++k) print_error(" %.9g", expected[k]);
    print_error("\n");
}

static inline double error_of_case(const comparison *c, const float *in, const float *out, double *expected) {
    double wide[SM_INPUTS], worst = 0.0;
    to_doubles(in, wide, SM_INPUTS);
    memset(expected, 0, SM_OUTPUTS * sizeof *expected);
    c->reference(wide, expected);
    for (int k = 0; k < c->outputs; ++k) worst = fmax(worst, error_of(out[k], expected[k], c->floor));
    return worst;
}

/* Worst error over all cases of results that lie SM_OUTPUTS floats apart; prints the case if it is beyond the bound. */
static inline double worst_error(const comparison *c, const float *results) {
    double expected[SM_OUTPUTS], worst = 0.0;
    size_t worst_case = 0;
    for (size_t i = 0; i < RANDOM_CASES; ++i) {
        double error = error_of_case(c, case_in(i), results + i * SM_OUTPUTS, expected);
        if (error > worst) worst = error, worst_case = i;
    }
    if (!(worst <= c->bound)) {
        const float *out = results + worst_case * SM_OUTPUTS;
        error_of_case(c, case_in(worst_case), out, expected);
        print_case(c, case_in(worst_case), out, expected);
    }
    return worst;
}

/* Bits that differ between what the two modules gave; both NaN is equal. */
static inline size_t count_differences(const comparison *c, const float *a, const float *b) {
    size_t count = 0;
    for (size_t i = 0; i < RANDOM_CASES; ++i)
        for (int k = 0; k < c->outputs; ++k)
            count += memcmp(a + i * SM_OUTPUTS + k, b + i * SM_OUTPUTS + k, sizeof *a) != 0;
    return count;
}

/* On the host, and on the device as compiled with and without optimisation: all within the bound, and on a CPU device, whose
   compiler keeps the order of operations, the two modules equal bit for bit. */
static inline bool compare(const comparison *c) {
    const size_t bytes = RANDOM_CASES * SM_OUTPUTS * sizeof(float);
    float *host = malloc(bytes), *debug = malloc(bytes);
    assert_true(host && debug);
    random_state = 12345;
    clear_cases(RANDOM_CASES);
    for (size_t i = 0; i < RANDOM_CASES; ++i) c->fill(case_in(i));
    for (size_t i = 0; i < RANDOM_CASES; ++i) run_on_host(c->operation, case_in(i), host + i * SM_OUTPUTS);
    run_kernel(&device.debug_kernel, c->operation, RANDOM_CASES);
    memcpy(debug, device.out, bytes);
    run_kernel(&device.kernel, c->operation, RANDOM_CASES);

    double on_device = worst_error(c, device.out), on_host = worst_error(c, host), unoptimised = worst_error(c, debug);
    size_t differences = count_differences(c, device.out, debug);
    print_message("  %-34s %9.2e  %9.2e   %9.2e  %zu\n", c->name, on_device, on_host, c->bound, differences);
    free(host);
    free(debug);
    bool exact = device.gpu.properties.deviceType != VK_PHYSICAL_DEVICE_TYPE_CPU || differences == 0;
    return exact && on_device <= c->bound && on_host <= c->bound && unoptimised <= c->bound;
}

static inline void compare_all(const comparison *comparisons, size_t count) {
    size_t failures = 0;
    print_message("  %-34s %9s  %9s   %9s  differences with and without optimisation (%u cases each)\n", "function", "device",
                  "host", "bound", RANDOM_CASES);
    for (size_t i = 0; i < count; ++i) failures += !compare(&comparisons[i]);
    assert_int_equal(failures, 0);
}

#endif
