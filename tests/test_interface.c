/* What programs, files and other languages rely on: numbers of enumerators never change, structs tell their version, and what is removed has
   a note in CHANGELOG.md. Rows are added to these tables at a release and never changed. */
#define NRD_IMPLEMENTATION
#include "nrd_vk.h"

#include "frame_fixture.h"

typedef struct frozen { const char *name; int64_t now, was; } frozen;
#define FROZEN(name, number) { #name, NRD_##name, number },

static const frozen numbers[] = {
    FROZEN(RESULT_OK, 0) FROZEN(RESULT_INVALID_ARGUMENT, 1) FROZEN(RESULT_OUT_OF_MEMORY, 2) FROZEN(RESULT_UNKNOWN_DENOISER, 3)
    FROZEN(RESULT_DUPLICATE_IDENTIFIER, 4) FROZEN(RESULT_FRAME_NOT_SET, 5) FROZEN(RESULT_UNSUPPORTED_DEVICE, 6) FROZEN(RESULT_MISSING_RESOURCE, 7)
    FROZEN(RESULT_DEVICE_ERROR, 8) FROZEN(RESULT_WRONG_VERSION, 9) FROZEN(RESULT_DESTROYED, 10)
    FROZEN(SEVERITY_WARNING, 0) FROZEN(SEVERITY_ERROR, 1)
    FROZEN(DENOISER_REFERENCE, 0) FROZEN(DENOISER_REBLUR_DIFFUSE, 1) FROZEN(DENOISER_REBLUR_SPECULAR, 2) FROZEN(DENOISER_REBLUR_DIFFUSE_SPECULAR, 3)
    FROZEN(DENOISER_REBLUR_DIFFUSE_OCCLUSION, 4) FROZEN(DENOISER_REBLUR_SPECULAR_OCCLUSION, 5) FROZEN(DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, 6)
    FROZEN(DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, 7) FROZEN(DENOISER_SIGMA_SHADOW, 8) FROZEN(DENOISER_SIGMA_SHADOW_TRANSLUCENCY, 9)
    FROZEN(DENOISER_REBLUR_DIFFUSE_SH, 10) FROZEN(DENOISER_REBLUR_SPECULAR_SH, 11) FROZEN(DENOISER_REBLUR_DIFFUSE_SPECULAR_SH, 12)
    FROZEN(RESOURCE_IN_MV, 0) FROZEN(RESOURCE_IN_NORMAL_ROUGHNESS, 1) FROZEN(RESOURCE_IN_VIEWZ, 2) FROZEN(RESOURCE_IN_DIFF_RADIANCE_HITDIST, 3)
    FROZEN(RESOURCE_IN_SPEC_RADIANCE_HITDIST, 4) FROZEN(RESOURCE_IN_DIFF_HITDIST, 5) FROZEN(RESOURCE_IN_DIFF_DIRECTION_HITDIST, 6)
    FROZEN(RESOURCE_IN_SPEC_HITDIST, 7) FROZEN(RESOURCE_IN_DIFF_CONFIDENCE, 8) FROZEN(RESOURCE_IN_SPEC_CONFIDENCE, 9)
    FROZEN(RESOURCE_IN_DISOCCLUSION_THRESHOLD_MIX, 10) FROZEN(RESOURCE_IN_PENUMBRA, 11) FROZEN(RESOURCE_IN_TRANSLUCENCY, 12) FROZEN(RESOURCE_IN_SIGNAL, 13)
    FROZEN(RESOURCE_OUT_DIFF_RADIANCE_HITDIST, 14) FROZEN(RESOURCE_OUT_SPEC_RADIANCE_HITDIST, 15) FROZEN(RESOURCE_OUT_DIFF_HITDIST, 16)
    FROZEN(RESOURCE_OUT_DIFF_DIRECTION_HITDIST, 17) FROZEN(RESOURCE_OUT_SPEC_HITDIST, 18) FROZEN(RESOURCE_OUT_SHADOW, 19)
    FROZEN(RESOURCE_OUT_SHADOW_TRANSLUCENCY, 20) FROZEN(RESOURCE_OUT_SIGNAL, 21)
    FROZEN(RESOURCE_IN_DIFF_SH0, 22) FROZEN(RESOURCE_IN_DIFF_SH1, 23) FROZEN(RESOURCE_IN_SPEC_SH0, 24) FROZEN(RESOURCE_IN_SPEC_SH1, 25)
    FROZEN(RESOURCE_OUT_DIFF_SH0, 26) FROZEN(RESOURCE_OUT_DIFF_SH1, 27) FROZEN(RESOURCE_OUT_SPEC_SH0, 28) FROZEN(RESOURCE_OUT_SPEC_SH1, 29)
    FROZEN(RESOURCE_OUT_VALIDATION, 30) FROZEN(RESOURCE_IN_SPEC_MV, 31)
    FROZEN(FORMAT_ANY, 0) FROZEN(FORMAT_R8_UNORM, 1) FROZEN(FORMAT_RGBA8_UNORM, 2) FROZEN(FORMAT_R16_UINT, 3) FROZEN(FORMAT_R16_FLOAT, 4)
    FROZEN(FORMAT_R32_FLOAT, 5) FROZEN(FORMAT_R32_UINT, 6) FROZEN(FORMAT_RG32_UINT, 7) FROZEN(FORMAT_RGBA16_FLOAT, 8) FROZEN(FORMAT_RGBA32_FLOAT, 9)
    FROZEN(PRESET_FASTEST, 0) FROZEN(PRESET_FAST, 1) FROZEN(PRESET_BALANCED, 2) FROZEN(PRESET_GOOD, 3) FROZEN(PRESET_BEST, 4)
    FROZEN(DEVICE_DATACENTER, 0) FROZEN(DEVICE_CPU, 1)
    FROZEN(ACCESS_READ, 0) FROZEN(ACCESS_READ_LINEAR, 1) FROZEN(ACCESS_WRITE, 2) FROZEN(ACCESS_BUFFER, 3) FROZEN(ACCESS_UNIFORM, 4)
    FROZEN(CLIP_Y_AUTO, 0) FROZEN(CLIP_Y_UP, 1) FROZEN(CLIP_Y_DOWN, 2)
    FROZEN(NORMAL_FORMAT_RGB10A2_UNORM, 0) FROZEN(NORMAL_FORMAT_RGBA8_UNORM, 1) FROZEN(NORMAL_FORMAT_RGBA8_SNORM, 2) FROZEN(NORMAL_FORMAT_RGBA16_UNORM, 3)
    FROZEN(NORMAL_FORMAT_RGBA16_SNORM, 4) FROZEN(ROUGHNESS_FORMAT_LINEAR, 0) FROZEN(ROUGHNESS_FORMAT_SQ_LINEAR, 1) FROZEN(ROUGHNESS_FORMAT_SQRT_LINEAR, 2)
    FROZEN(MOTION_2D, 0) FROZEN(MOTION_2_5D, 1) FROZEN(MOTION_WORLD, 2)
    FROZEN(FEATURE_HISTORY_CONFIDENCE, 1) FROZEN(FEATURE_DISOCCLUSION_THRESHOLD_MIX, 2) FROZEN(FEATURE_PREPASS, 4) FROZEN(FEATURE_SPLIT_SCREEN, 8)
    FROZEN(FEATURE_HIT_DISTANCE_RECONSTRUCTION, 16) FROZEN(FEATURE_CHECKERBOARD, 32) FROZEN(FEATURE_CHECK, 64) FROZEN(FEATURE_VALIDATION, 128)
    FROZEN(FEATURE_SPECULAR_MOTION, 256) FROZEN(FEATURE_MATERIALS, 512) FROZEN(FEATURE_ROUGHNESS_LIMIT, 1024)
    FROZEN(ABSENT_DIFFUSE, 1) FROZEN(ABSENT_SPECULAR, 2) FROZEN(ABSENT_MOTION, 4) FROZEN(ABSENT_SKY, 8) FROZEN(ABSENT_MATERIALS, 16) FROZEN(ABSENT_MIRRORS, 32)
    FROZEN(ABSENT_STABILIZATION, 64) FROZEN(ABSENT_LIGHTING_CHANGE, 128) FROZEN(ABSENT_BLUR, 256)
    FROZEN(SPECULAR_MOTION_NONE, 0) FROZEN(SPECULAR_MOTION_IMAGE, 1) FROZEN(SPECULAR_MOTION_HIT, 2)
    FROZEN(EXPLAIN_TEXT, 0) FROZEN(EXPLAIN_JSON, 1) FROZEN(EXPLAIN_GRAPHVIZ, 2)
    FROZEN(VK_MEMORY_PERMANENT, 0) FROZEN(VK_MEMORY_TRANSIENT, 1) FROZEN(VK_MEMORY_CONSTANTS, 2) FROZEN(VK_TIMESTAMPS, 1) FROZEN(VK_DEBUG_NAMES, 2)
    FROZEN(VK_FREE_DESCRIPTOR_SETS, 4)
};

static void numbers_of_enumerators_never_change(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        if (numbers[i].now != numbers[i].was) fail_msg("NRD_%s is %d and was %d: add new rows at the end", numbers[i].name, (int)numbers[i].now, (int)numbers[i].was);
}

/* Rows of a kind, by the beginning of their names, and their numbers put together. */
static uint32_t frozen_rows(const char *kind, int64_t *bits)
{
    uint32_t count = 0;
    *bits = 0;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        if (strncmp(numbers[i].name, kind, strlen(kind)) == 0) *bits |= numbers[i].was, count++;
    return count;
}

static void every_enumerator_has_a_row(void **state)
{
    static const struct { const char *kind; uint32_t count; } enums[] = {
        { "RESULT_", NRD_RESULT_COUNT }, { "DENOISER_", NRD_DENOISER_COUNT }, { "RESOURCE_", NRD_RESOURCE_COUNT }, { "FORMAT_", NRD_FORMAT_COUNT },
        { "PRESET_", NRD_PRESET_COUNT }, { "DEVICE_", NRD_DEVICE_COUNT } };
    int64_t bits;
    (void)state;
    for (size_t i = 0; i < sizeof enums / sizeof enums[0]; i++)
        if (frozen_rows(enums[i].kind, &bits) != enums[i].count) fail_msg("NRD_%s..: %u of %u have a row", enums[i].kind, frozen_rows(enums[i].kind, &bits), enums[i].count);
    frozen_rows("FEATURE_", &bits);
    assert_int_equal(bits, NRD_FEATURE_ALL);
    frozen_rows("ABSENT_", &bits);
    assert_int_equal(bits, NRD_ABSENT_ALL);
}

/* Names that settings files and command lines hold. */
static const struct { nrd_denoiser owner; const char *names; } settings[] = {
    { NRD_DENOISER_COUNT, "view_z_scale denoising_range disocclusion_threshold disocclusion_threshold_alternate split_screen motion_mode motion_scale_x "
                          "motion_scale_y motion_scale_z restart history_confidence_available disocclusion_threshold_mix_available validation specular_motion "
                          "strand_material_id strand_thickness camera_attached_reflection_material_id" },
    { NRD_DENOISER_REFERENCE, "max_accumulated_frames" },
    { NRD_DENOISER_REBLUR_DIFFUSE, "hit_distance_a hit_distance_b hit_distance_c hit_distance_d max_accumulated_frames max_stabilized_frames history_fix_frames "
                                   "feedback_frames max_blur_radius diffuse_prepass_blur_radius specular_prepass_blur_radius luminance_sigma_scale "
                                   "plane_distance_sensitivity normal_sensitivity antilag_sigma_scale antilag_sensitivity stabilization_sigma_scale "
                                   "min_material_for_diffuse return_history_length_instead_of_occlusion hit_distance_reconstruction min_material_for_specular "
                                   "diffuse_checkerboard specular_checkerboard responsive_roughness responsive_min_frames performance_mode anti_firefly_scale "
                                   "specular_roughness_limit" },
    { NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, "hit_distance_a hit_distance_b hit_distance_c hit_distance_d max_accumulated_frames max_blur_radius "
                                             "plane_distance_sensitivity normal_sensitivity antilag_sigma_scale min_material return_history_length_instead_of_occlusion "
                                             "diffuse_checkerboard specular_checkerboard performance_mode" },
    { NRD_DENOISER_SIGMA_SHADOW, "light_x light_y light_z light_is_local light_radius max_accumulated_frames max_stabilized_frames penumbra_blur_scale "
                                 "plane_distance_sensitivity" },
};

static void every_setting_is_listed(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++) {
        char names[1200], quoted[80];
        nrd_setting s;
        snprintf(names, sizeof names, " %s ", settings[i].names);
        for (uint32_t k = 0; nrd_get_setting(settings[i].owner, k, &s); k++) {
            snprintf(quoted, sizeof quoted, " %s ", s.name);
            if (!strstr(names, quoted)) fail_msg("no row for the setting %s", s.name);
        }
    }
}

static char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = (char *)calloc(1, 1 << 20);
    assert_non_null(file);
    assert_non_null(text);
    assert_true(fread(text, 1, (1 << 20) - 1, file) > 0);
    fclose(file);
    return text;
}

static void a_setting_that_is_gone_has_a_note_about_what_to_write_instead(void **state)
{
    char *changes = read_text("CHANGELOG.md");
    const char *removed = strstr(changes, "\nRemoved");
    (void)state;
    for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++) {
        char names[1200], quoted[80];
        nrd_setting found;
        snprintf(names, sizeof names, "%s", settings[i].names);
        for (char *name = strtok(names, " "); name; name = strtok(NULL, " ")) {
            if (find_setting(settings[i].owner, name, &found)) continue;
            snprintf(quoted, sizeof quoted, "`%s`", name);
            if (!removed || !strstr(removed, quoted)) fail_msg("setting %s is gone; say in CHANGELOG.md under \"Removed\" what to write instead", name);
        }
    }
    free(changes);
}

static void structs_begin_with_their_version_and_whom_to_tell(void **state)
{
    uint32_t major = 0, minor = 0, patch = 0;
    (void)state;
    assert_int_equal(offsetof(nrd_desc, struct_version), 0);
    assert_int_equal(offsetof(nrd_desc, message), sizeof(void *));
    assert_int_equal(offsetof(nrd_desc, message_user), 2 * sizeof(void *));
    assert_int_equal(offsetof(nrd_vk_desc, struct_version), 0);
    assert_int_equal(offsetof(nrd_vk_desc, instance), sizeof(void *));
    assert_int_equal(sscanf(NRD_RELEASE, "%u.%u.%u", &major, &minor, &patch), 3);
    assert_int_equal(NRD_RELEASE_NUMBER, 10000 * major + 100 * minor + patch);
    assert_int_equal(nrd_version(), NRD_RELEASE_NUMBER);
    assert_int_equal(NRD_STRUCT_VERSION >> 16, NRD_RELEASE_NUMBER);
    assert_true(NRD_VK_STRUCT_VERSION != NRD_STRUCT_VERSION);
    char *changes = read_text("CHANGELOG.md");
    assert_non_null(strstr(changes, "\n## " NRD_RELEASE));
    free(changes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_of_enumerators_never_change),
        cmocka_unit_test(every_enumerator_has_a_row),
        cmocka_unit_test(every_setting_is_listed),
        cmocka_unit_test(a_setting_that_is_gone_has_a_note_about_what_to_write_instead),
        cmocka_unit_test(structs_begin_with_their_version_and_whom_to_tell),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
