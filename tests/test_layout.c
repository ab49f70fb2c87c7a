/* The SPIR-V of every pass against what nrd.h tells an app to create: constants, bindings, formats, group sizes. */
#define NRD_IMPLEMENTATION
#include "nrd.h"
#include "nrd_spirv.h"

#include "frame_fixture.h"
#include "spirv_reflect.h"

enum { MODULE_BUDGET = 64, REBLUR_BUDGET = 40, GROUP = 8 };

static spirv_module reflected;

static const spirv_module *module_of(uint32_t i)
{
    spirv_read(nrd_spirv_table[i].words, nrd_spirv_table[i].size_bytes, &reflected);
    return &reflected;
}

static uint32_t find_module(const char *name)
{
    uint32_t i = 0;
    while (i < nrd_spirv_count && strcmp(nrd_spirv_table[i].name, name) != 0) i++;
    return i;
}

/* All denoisers with all features: every pipeline there is. */
/* ---------------------------------------------------------------------------------------------------------------------------
   Modules  >>modules */
static void the_number_of_modules_stays_within_the_budget(void **state)
{
    uint32_t reblur = 0;
    (void)state;
    for (uint32_t i = 0; i < nrd_spirv_count; i++) reblur += strncmp(nrd_spirv_table[i].name, "reblur_", 7) == 0;
    print_message("%u SPIR-V modules, %d allowed; REBLUR: %u, %d allowed\n", nrd_spirv_count, MODULE_BUDGET, reblur, REBLUR_BUDGET);
    assert_in_range(reblur, 1, REBLUR_BUDGET);
    assert_in_range(nrd_spirv_count, 1, MODULE_BUDGET);
    assert_int_equal(nrd_spirv_count, sizeof nrd_spirv_table / sizeof nrd_spirv_table[0]);
    for (uint32_t i = 0; i < nrd_spirv_count; i++) assert_int_equal(find_module(nrd_spirv_table[i].name), i);   /* no name twice */
}

static void every_pipeline_has_its_module_and_every_module_a_pipeline(void **state)
{
    spy s;
    bool used[MODULE_BUDGET] = { false };
    (void)state;
    nrd *instance = create_all(&s);
    const nrd_info *info = nrd_get_info(instance);
    for (uint32_t i = 0; i < info->pipeline_count; i++) {
        uint32_t module = find_module(info->pipelines[i].shader);
        if (module == nrd_spirv_count) fail_msg("no SPIR-V for %s", info->pipelines[i].shader);
        used[module] = true;
    }
    for (uint32_t i = 0; i < nrd_spirv_count; i++) if (!used[i]) fail_msg("no pipeline uses %s", nrd_spirv_table[i].name);
    nrd_destroy(instance);
}

/* All that Vulkan 1.1 offers without enabling a feature (StorageImageExtendedFormats since 1.0; that a format can be stored to is
   asked from the device). */
static bool is_core_capability(uint32_t capability)
{
    return capability == SPV_CAPABILITY_SHADER || capability == SPV_CAPABILITY_IMAGE_QUERY || capability == SPV_CAPABILITY_STORAGE_IMAGE_EXTENDED_FORMATS;
}

static void modules_run_on_vulkan_1_1_without_any_feature(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < nrd_spirv_count; i++) {
        const spirv_module *m = module_of(i);
        assert_in_range(m->version, 0x00010000, 0x00010300);
        for (uint32_t k = 0; k < m->capability_count; k++)
            if (!is_core_capability(m->capabilities[k])) fail_msg("%s needs SPIR-V capability %u", nrd_spirv_table[i].name, m->capabilities[k]);
    }
}

static void modules_have_one_compute_entry_point_with_8_x_8_threads(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < nrd_spirv_count; i++) {
        const spirv_module *m = module_of(i);
        assert_int_equal(m->entry_points, 1);
        assert_int_equal(m->execution_model, SPV_EXECUTION_MODEL_GL_COMPUTE);
        assert_string_equal(m->entry_name, "main");
        assert_int_equal(m->local_size[0], GROUP);
        assert_int_equal(m->local_size[1], GROUP);
        assert_int_equal(m->local_size[2], 1);
    }
}

static void specialization_constants_have_the_documented_ids(void **state)
{
    enum { KNOWN = 0
#define COUNT_SPEC(name, id) + 1
        NRD_SPEC_CONSTANTS(COUNT_SPEC)
    };
    static const uint32_t known[KNOWN] = {
#define LIST_SPEC(name, id) id,
        NRD_SPEC_CONSTANTS(LIST_SPEC)
    };
    const nrd_pipeline *pipeline = NULL;
    (void)state;
    assert_int_equal(sizeof pipeline->spec_constants / sizeof pipeline->spec_constants[0], KNOWN);
    for (uint32_t i = 0; i < KNOWN; i++) assert_int_equal(known[i], i);
    for (uint32_t i = 0; i < nrd_spirv_count; i++) {
        const spirv_module *m = module_of(i);
        for (uint32_t k = 0; k < m->spec_count; k++) {
            assert_true(m->spec_ids[k] < KNOWN);
            for (uint32_t j = 0; j < k; j++) assert_int_not_equal(m->spec_ids[j], m->spec_ids[k]);
        }
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Constants  >>constants */
typedef struct c_member { const char *type, *name; size_t offset; } c_member;

static const c_member c_constants[] = {
#define LIST_MEMBER(type, name) { #type, #name, offsetof(nrd_constants, name) },
    NRD_CONSTANTS(LIST_MEMBER)
};

/* "uint", "float", "vec4", "mat4", as GLSL calls it. */
static const char *type_name(const spirv_module *m, uint32_t type)
{
    const uint32_t *t = m->definition[type];
    switch (t ? spirv_opcode(t) : 0) {
    case SPV_OP_TYPE_INT: return t[2] != 32 ? "?" : t[3] ? "int" : "uint";
    case SPV_OP_TYPE_FLOAT: return t[2] == 32 ? "float" : "?";
    case SPV_OP_TYPE_VECTOR: return t[3] == 4 && strcmp(type_name(m, t[2]), "float") == 0 ? "vec4" : "?";
    case SPV_OP_TYPE_MATRIX: return t[3] == 4 && strcmp(type_name(m, t[2]), "vec4") == 0 ? "mat4" : "?";
    }
    return "?";
}

static void every_module_lays_out_the_constants_as_c_does(void **state)
{
    const uint32_t count = sizeof c_constants / sizeof c_constants[0];
    (void)state;
    for (uint32_t i = 0; i < nrd_spirv_count; i++) {
        const spirv_module *m = module_of(i);
        assert_int_equal(m->bindings[0].kind, SPIRV_UNIFORM_BLOCK);
        assert_int_equal(m->uniform.member_count, count);
        for (uint32_t k = 0; k < count; k++) {
            const spirv_member *member = &m->uniform.members[k];
            if (member->offset != c_constants[k].offset || strcmp(type_name(m, member->type), c_constants[k].type) != 0)
                fail_msg("%s: %s is %s at %u, in C %s at %zu", nrd_spirv_table[i].name, c_constants[k].name, type_name(m, member->type), member->offset,
                         c_constants[k].type, c_constants[k].offset);
            bool matrix = strcmp(c_constants[k].type, "mat4") == 0;
            assert_int_equal(member->col_major, matrix);
            assert_int_equal(member->matrix_stride, matrix ? 16 : 0);
        }
    }
}

static void the_constant_block_ends_on_a_multiple_of_16_bytes(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create_all(&s);
    assert_int_equal(nrd_get_info(instance)->constant_bytes, sizeof(nrd_constants));
    assert_int_equal(sizeof(nrd_constants) % 16, 0);
    for (size_t k = 0; k < sizeof c_constants / sizeof c_constants[0]; k++) {
        bool scalar = strcmp(c_constants[k].type, "uint") == 0 || strcmp(c_constants[k].type, "float") == 0;
        assert_int_equal(c_constants[k].offset % (scalar ? 4 : 16), 0);
    }
    nrd_destroy(instance);
}

static void push_constants_are_those_of_nrd_dispatch(void **state)
{
    static const char *const types[] = {
#define LIST_PUSH(type, name) #type,
        NRD_PUSH_CONSTANTS(LIST_PUSH)
    };
    const uint32_t count = sizeof types / sizeof types[0];
    const nrd_dispatch *dispatch = NULL;
    (void)state;
    assert_int_equal(sizeof dispatch->push, 4 * count);
    for (uint32_t i = 0; i < nrd_spirv_count; i++) {
        const spirv_module *m = module_of(i);
        if (m->push.member_count == 0) continue;   /* not used by this pass */
        assert_int_equal(m->push.member_count, count);
        for (uint32_t k = 0; k < count; k++) {
            assert_int_equal(m->push.members[k].offset, 4 * k);
            assert_string_equal(type_name(m, m->push.members[k].type), types[k]);
        }
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Bindings  >>bindings */
static spirv_kind kind_of(nrd_access access)
{
    if (access == NRD_ACCESS_BUFFER) return SPIRV_STORAGE_BUFFER;
    if (access == NRD_ACCESS_UNIFORM) return SPIRV_UNIFORM_BLOCK;
    return access == NRD_ACCESS_WRITE ? SPIRV_STORAGE_IMAGE : SPIRV_COMBINED_SAMPLER;
}

static void bindings_have_the_kinds_that_the_pipelines_promise(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create_all(&s);
    const nrd_info *info = nrd_get_info(instance);
    uint32_t most = 0;
    for (uint32_t i = 0; i < info->pipeline_count; i++) {
        const nrd_pipeline *p = &info->pipelines[i];
        const spirv_module *m = module_of(find_module(p->shader));
        assert_false(m->other_set);
        for (uint32_t b = 1; b < SPIRV_MAX_BINDINGS; b++) {
            spirv_kind expected = b > p->binding_count ? SPIRV_ABSENT : kind_of(p->access[b - 1]);
            if (m->bindings[b].kind != expected) fail_msg("%s: binding %u is of kind %d, promised %d", p->shader, b, m->bindings[b].kind, expected);
        }
        if (p->binding_count > most) most = p->binding_count;
    }
    assert_int_equal(info->max_bindings, most);
    nrd_destroy(instance);
}

/* README: what a device must be able to bind to one pass. */
static void passes_bind_at_most_25_sampled_and_8_storage_images(void **state)
{
    spy s;
    uint32_t most[2] = { 0, 0 };
    (void)state;
    nrd *instance = create_all(&s);
    const nrd_info *info = nrd_get_info(instance);
    for (uint32_t i = 0; i < info->pipeline_count; i++) {
        uint32_t count[2] = { 0, 0 };
        for (uint32_t b = 0; b < info->pipelines[i].binding_count; b++)
            if (info->pipelines[i].access[b] < NRD_ACCESS_BUFFER) count[info->pipelines[i].access[b] == NRD_ACCESS_WRITE]++;
        for (int k = 0; k < 2; k++)
            if (count[k] > most[k]) most[k] = count[k];
    }
    assert_int_equal(most[0], 25);
    assert_int_equal(most[1], 8);
    nrd_destroy(instance);
}

static uint32_t spirv_format(nrd_format format)
{
    switch (format) {
    case NRD_FORMAT_R8_UNORM: return SPV_FORMAT_R8;
    case NRD_FORMAT_RGBA8_UNORM: return SPV_FORMAT_RGBA8;
    case NRD_FORMAT_R16_UINT: return SPV_FORMAT_R16UI;
    case NRD_FORMAT_R16_FLOAT: return SPV_FORMAT_R16F;
    case NRD_FORMAT_R32_FLOAT: return SPV_FORMAT_R32F;
    case NRD_FORMAT_R32_UINT: return SPV_FORMAT_R32UI;
    case NRD_FORMAT_RG32_UINT: return SPV_FORMAT_RG32UI;
    case NRD_FORMAT_RGBA16_FLOAT: return SPV_FORMAT_RGBA16F;
    case NRD_FORMAT_RGBA32_FLOAT: return SPV_FORMAT_RGBA32F;
    case NRD_FORMAT_ANY:
    case NRD_FORMAT_COUNT: break;
    }
    return 0;
}

static void check_formats(const nrd_info *info, const nrd_dispatch *d)
{
    const char *shader = info->pipelines[d->pipeline].shader;
    const spirv_module *m = module_of(find_module(shader));
    for (uint32_t b = 0; b < d->binding_count; b++) {
        const nrd_binding *bound = &d->bindings[b];
        const spirv_binding *declared = &m->bindings[b + 1];
        if (bound->access >= NRD_ACCESS_BUFFER) continue;
        nrd_format format = bound->resource == NRD_RESOURCE_INTERNAL ? info->textures[bound->texture].format : nrd_resource_format(bound->resource);
        if (declared->is_uint != nrd_format_is_uint(format)) fail_msg("%s: binding %u: integer or not differs from format %d", shader, b + 1, format);
        if (bound->access != NRD_ACCESS_WRITE) continue;
        if (declared->format != spirv_format(format) || !format) fail_msg("%s: binding %u has SPIR-V format %u, bound is format %d", shader, b + 1, declared->format, format);
    }
}

/* In every denoiser that has them. */
static void set_optional_passes(nrd *instance, bool on)
{
    float radius = on ? 10.0f : 0.0f;
    uint32_t reconstruction = on;
    for (uint32_t d = 0; d < NRD_DENOISER_COUNT; d++) {
        nrd_setting row;
        double settings[128];   /* aligned bytes */
        assert_true(nrd_settings_size((nrd_denoiser)d) <= sizeof settings);
        nrd_settings_defaults((nrd_denoiser)d, settings);
        for (uint32_t i = 0; nrd_get_setting((nrd_denoiser)d, i, &row); i++) {
            if (strstr(row.name, "prepass_blur_radius")) memcpy((char *)settings + row.offset, &radius, sizeof radius);
            else if (strcmp(row.name, "hit_distance_reconstruction") == 0) memcpy((char *)settings + row.offset, &reconstruction, sizeof reconstruction);
        }
        assert_int_equal(nrd_set_settings(instance, d, settings), NRD_RESULT_OK);
    }
}

/* In frames with and without everything optional, because bindings have stand-ins. */
static void storage_formats_and_integer_samplers_fit_what_is_bound(void **state)
{
    spy s;
    const nrd_dispatch *dispatches;
    uint32_t count;
    bool seen[256] = { false };
    (void)state;
    nrd *instance = create_all(&s);
    const nrd_info *info = nrd_get_info(instance);
    assert_true(info->pass_count <= 256);
    for (uint32_t i = 0; i < 4 + NRD_DENOISER_COUNT; i++) {
        nrd_frame frame = still_frame(i);
        bool full = i >= 2;
        frame.validation = i < 4 ? 0 : i - 3;
        frame.split_screen = full ? 0.5f : 0;
        frame.history_confidence_available = frame.disocclusion_threshold_mix_available = full;
        frame.specular_motion = full ? NRD_SPECULAR_MOTION_HIT : NRD_SPECULAR_MOTION_NONE;
        set_optional_passes(instance, full);
        assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
        assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &dispatches, &count), NRD_RESULT_OK);
        for (uint32_t d = 0; d < count; d++) {
            check_formats(info, &dispatches[d]);
            seen[dispatches[d].pass] = true;
        }
    }
    for (uint32_t i = 0; i < info->pass_count; i++) assert_true(seen[i]);
    nrd_destroy(instance);
}

static void linear_sampling_is_asked_of_float_textures_only(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create_all(&s);
    const nrd_info *info = nrd_get_info(instance);
    for (uint32_t i = 0; i < info->pipeline_count; i++) {
        const spirv_module *m = module_of(find_module(info->pipelines[i].shader));
        for (uint32_t b = 0; b < info->pipelines[i].binding_count; b++)
            if (info->pipelines[i].access[b] == NRD_ACCESS_READ_LINEAR) assert_false(m->bindings[b + 1].is_uint);
    }
    nrd_destroy(instance);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_number_of_modules_stays_within_the_budget),
        cmocka_unit_test(every_pipeline_has_its_module_and_every_module_a_pipeline),
        cmocka_unit_test(modules_run_on_vulkan_1_1_without_any_feature),
        cmocka_unit_test(modules_have_one_compute_entry_point_with_8_x_8_threads),
        cmocka_unit_test(specialization_constants_have_the_documented_ids),
        cmocka_unit_test(every_module_lays_out_the_constants_as_c_does),
        cmocka_unit_test(the_constant_block_ends_on_a_multiple_of_16_bytes),
        cmocka_unit_test(push_constants_are_those_of_nrd_dispatch),
        cmocka_unit_test(bindings_have_the_kinds_that_the_pipelines_promise),
        cmocka_unit_test(passes_bind_at_most_25_sampled_and_8_storage_images),
        cmocka_unit_test(storage_formats_and_integer_samplers_fit_what_is_bound),
        cmocka_unit_test(linear_sampling_is_asked_of_float_textures_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
