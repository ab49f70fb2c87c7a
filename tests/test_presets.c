/* Presets and what nrd_suggest makes of their measured costs. */
#define NRD_IMPLEMENTATION
#include "nrd.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define EACH_DENOISER(d) (int d = 0; d < NRD_DENOISER_COUNT; d++)
#define EACH_PRESET(p) (int p = 0; p < NRD_PRESET_COUNT; p++)

static void *settings_of(int denoiser, int preset)
{
    void *settings = malloc(nrd_settings_size((nrd_denoiser)denoiser));
    assert_non_null(settings);
    nrd_settings_preset((nrd_denoiser)denoiser, (nrd_preset)preset, settings);
    return settings;
}

/* Dispatches of the third frame; -1 when the settings are refused. */
static int dispatches_with(int denoiser, const void *settings)
{
    const nrd_denoiser_desc one = { 7, (nrd_denoiser)denoiser };
    const nrd_dispatch *list;
    nrd_desc desc = { 0 };
    nrd_frame frame = nrd_frame_defaults();
    uint32_t count = 0;
    nrd *instance;
    desc.width = desc.height = 64;
    desc.denoisers = &one;
    desc.denoiser_count = 1;
    desc.features = NRD_FEATURE_ALL;
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    frame.camera.view_to_clip[0] = frame.camera.view_to_clip[5] = frame.camera.view_to_clip[10] = frame.camera.view_to_clip[11] = 1;
    frame.camera.view_to_clip[14] = -0.1f;
    for (int i = 0; i < 4; i++)
        frame.camera.world_to_view[5 * i] = 1;
    bool accepted = nrd_set_settings(instance, 7, settings) == NRD_RESULT_OK;
    for (uint32_t i = 0; i < 3; i++) {
        frame.frame_index = i;
        assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
        assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &list, &count), NRD_RESULT_OK);
    }
    nrd_destroy(instance);
    return accepted ? (int)count : -1;
}

static void every_preset_is_accepted_and_costs_no_fewer_passes_than_the_one_before(void **state)
{
    (void)state;
    for EACH_DENOISER(d) {
        int before = 1;
        for EACH_PRESET(p) {
            void *settings = settings_of(d, p);
            int count = dispatches_with(d, settings);
            assert_true(count >= before);
            before = count;
            free(settings);
        }
    }
}

static bool filters_in_steps(int denoiser)
{
    nrd_setting row;
    for (uint32_t i = 0; nrd_get_setting((nrd_denoiser)denoiser, i, &row); i++)
        if (!strcmp(row.name, "performance_mode"))
            return row.max > 1;
    return false;
}

/* FAST leaves filter steps out where there are several, which is where performance_mode may be 2. */
static void faster_presets_run_fewer_passes(void **state)
{
    (void)state;
    for EACH_DENOISER(d) {
        void *fast = settings_of(d, NRD_PRESET_FAST), *balanced = settings_of(d, NRD_PRESET_BALANCED);
        assert_int_equal(dispatches_with(d, fast) < dispatches_with(d, balanced), filters_in_steps(d));
        free(fast);
        free(balanced);
    }
}

/* REBLUR's second step of two reaches 3 of 15 px, so that the 3x3 pixels of the first lie side by side. */
static void two_steps_leave_no_gap(void **state)
{
    nrdi_state s;
    const nrdi_pass_row first = { .iteration = 0 }, last = { .iteration = 3 };
    (void)state;
    memset(&s, 0, sizeof s);
    s.row = nrdi_row_of(NRD_DENOISER_REBLUR_DIFFUSE);
    s.settings.reblur = nrd_reblur_preset(NRD_PRESET_FAST);
    s.constants.max_blur_radius = s.settings.reblur.max_blur_radius;
    assert_true(nrdi_step(&s, &first) == 1 && nrdi_step(&s, &last) == 3);
    s.settings.reblur = nrd_reblur_preset(NRD_PRESET_BALANCED);
    assert_true(nrdi_step(&s, &first) == 1 && nrdi_step(&s, &last) == 8);
    s.constants.max_blur_radius = 0;
    assert_int_equal(nrdi_step(&s, &first), 0);
}

static void balanced_is_the_default(void **state)
{
    (void)state;
    for EACH_DENOISER(d) {
        size_t size = nrd_settings_size((nrd_denoiser)d);
        void *balanced = settings_of(d, NRD_PRESET_BALANCED), *defaults = malloc(size);
        nrd_settings_defaults((nrd_denoiser)d, defaults);
        assert_memory_equal(balanced, defaults, size);
        free(balanced);
        free(defaults);
    }
    nrd_reblur_settings named = nrd_reblur_preset(NRD_PRESET_FASTEST), general;
    nrd_settings_preset(NRD_DENOISER_REBLUR_DIFFUSE, NRD_PRESET_FASTEST, &general);
    assert_memory_equal(&named, &general, sizeof named);
    nrd_occlusion_settings occlusion = nrd_occlusion_preset(NRD_PRESET_FAST);
    assert_true(occlusion.performance_mode == 1 && occlusion.max_blur_radius == nrd_occlusion_defaults().max_blur_radius);
    nrd_settings_preset(NRD_DENOISER_REBLUR_DIFFUSE, NRD_PRESET_FASTEST, NULL);
}

static void presets_have_names(void **state)
{
    (void)state;
    assert_string_equal(nrd_preset_name(NRD_PRESET_FASTEST), "fastest");
    assert_string_equal(nrd_preset_name(NRD_PRESET_BEST), "best");
    assert_null(nrd_preset_name(NRD_PRESET_COUNT));
}

static void rows_of_presets_name_settings_that_exist(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof nrdi_presets / sizeof *nrdi_presets; i++) {
        bool found = false;
        for EACH_DENOISER(d) {
            nrd_setting row;
            for (uint32_t k = 0; nrd_get_setting((nrd_denoiser)d, k, &row); k++)
                found |= nrdi_list_of((nrd_denoiser)d).rows == nrdi_presets[i].list && !strcmp(row.name, nrdi_presets[i].name);
        }
        if (!found)
            fail_msg("no denoiser with presets has a setting %s", nrdi_presets[i].name);
    }
}

static void a_larger_budget_never_gives_a_larger_error(void **state)
{
    (void)state;
    for EACH_DENOISER(d)
        for (int device = 0; device < NRD_DEVICE_COUNT; device++) {
            nrd_suggestion s = { NRD_PRESET_COUNT, 0, 0 };
            float error = INFINITY, least_ms = 0;
            for (float budget = 1e-3f; budget < 1e5f; budget *= 1.3f) {
                nrd_result result = nrd_suggest((nrd_denoiser)d, (nrd_device)device, 1920, 1080, budget, &s);
                if (result == NRD_RESULT_UNKNOWN_DENOISER)
                    break;
                assert_int_equal(result, NRD_RESULT_OK);
                least_ms = least_ms > 0 ? least_ms : s.milliseconds;
                assert_true(s.milliseconds <= budget || s.milliseconds == least_ms);
                assert_true(s.error <= error || s.milliseconds == least_ms);
                assert_true(nrd_preset_name(s.preset) != NULL);
                error = s.error;
            }
        }
}

static void what_is_measured_is_suggested(void **state)
{
    nrd_suggestion small, large;
    (void)state;
    assert_int_equal(nrd_suggest(NRD_DENOISER_REBLUR_DIFFUSE, NRD_DEVICE_DATACENTER, 320, 180, 1e6f, &large), NRD_RESULT_OK);
    assert_int_equal(nrd_suggest(NRD_DENOISER_REBLUR_DIFFUSE, NRD_DEVICE_DATACENTER, 320, 180, 1e-6f, &small), NRD_RESULT_OK);
    assert_true(small.milliseconds < large.milliseconds && small.error > large.error);
    assert_int_equal(small.preset, NRD_PRESET_FASTEST);
}

static void misuse_leaves_the_suggestion_alone(void **state)
{
    nrd_suggestion s = { NRD_PRESET_GOOD, 5, 6 };
    (void)state;
    assert_int_equal(nrd_suggest(NRD_DENOISER_REBLUR_DIFFUSE, NRD_DEVICE_CPU, 0, 180, 1, &s), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_suggest(NRD_DENOISER_REBLUR_DIFFUSE, NRD_DEVICE_CPU, 320, 180, 0, &s), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_suggest(NRD_DENOISER_REBLUR_DIFFUSE, NRD_DEVICE_CPU, 320, 180, NAN, &s), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_suggest(NRD_DENOISER_REBLUR_DIFFUSE, NRD_DEVICE_COUNT, 320, 180, 1, &s), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_suggest(NRD_DENOISER_REBLUR_DIFFUSE, NRD_DEVICE_CPU, 320, 180, 1, NULL), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_suggest(NRD_DENOISER_COUNT, NRD_DEVICE_CPU, 320, 180, 1, &s), NRD_RESULT_UNKNOWN_DENOISER);
    assert_true(s.preset == NRD_PRESET_GOOD && s.milliseconds == 5 && s.error == 6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_preset_is_accepted_and_costs_no_fewer_passes_than_the_one_before),
        cmocka_unit_test(faster_presets_run_fewer_passes),
        cmocka_unit_test(two_steps_leave_no_gap),
        cmocka_unit_test(balanced_is_the_default),
        cmocka_unit_test(presets_have_names),
        cmocka_unit_test(rows_of_presets_name_settings_that_exist),
        cmocka_unit_test(a_larger_budget_never_gives_a_larger_error),
        cmocka_unit_test(what_is_measured_is_suggested),
        cmocka_unit_test(misuse_leaves_the_suggestion_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
