/* nrd_desc.absent: what it removes from the graph, and that a promise which is kept changes no bit of the output. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "stage.h"

enum { FRAMES = 4 };
enum { /* ids */
#define SPEC_ID(name, id) SPEC_##name = id,
    NRD_SPEC_CONSTANTS(SPEC_ID)
};

/* Runs a (which needs everything) and b side by side. */
static void compare(stage *a, stage *b, const char *what)
{
    for (uint32_t i = 0; i < FRAMES; i++) {
        stage_run(a, i, NULL);
        stage_run(b, i, NULL);
        stage_assert_same(a, b, what);
    }
    stage_close(a);
    stage_close(b);
    assert_int_equal(gpu_message_count(&device), 0);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Outputs  >>outputs */
/* without: what the instance that promises nothing sets to 0 for the same effect. */
typedef struct promise { uint32_t absent; const char *without[3], *text; } promise;
static const promise promises[] = {
    { NRD_ABSENT_MOTION | NRD_ABSENT_SKY | NRD_ABSENT_MATERIALS, { NULL, NULL, NULL }, "no motion, sky, materials" },
    { NRD_ABSENT_STABILIZATION | NRD_ABSENT_LIGHTING_CHANGE | NRD_ABSENT_BLUR, { "max_stabilized_frames", "antilag_sensitivity", "max_blur_radius" },
      "no stabilization, lighting change, blur" },
    { NRD_ABSENT_STABILIZATION | NRD_ABSENT_MOTION, { "max_stabilized_frames", NULL, NULL }, "no stabilization, motion" },
};

static const char *name_of(uint32_t absent)
{
    uint32_t i = 0;
    while (absent >> i > 1) i++;
    return nrd_absence_name(i);
}

static void promises_that_are_kept_change_no_bit_of_any_output(void **state)
{
    stage a, b;
    (void)state;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++)
        for (size_t i = 0; i < sizeof promises / sizeof promises[0]; i++) {
            stage_open(&a, (nrd_denoiser)d, 0, NULL);
            stage_open(&b, (nrd_denoiser)d, promises[i].absent, NULL);
            static const char *const materials[3] = { "min_material", "min_material_for_diffuse", NULL }, *const nothing[3] = { NULL, NULL, NULL };
            stage_set(&a, promises[i].without);
            stage_set(&b, promises[i].absent & NRD_ABSENT_MATERIALS ? materials : nothing);   /* ids differ, but nobody looks */
            compare(&a, &b, promises[i].text);
        }
}

static void a_denoiser_without_one_of_its_signals_is_the_denoiser_of_the_other(void **state)
{
    static const struct { nrd_denoiser whole, rest; uint32_t absent; } rows[] = {
        { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE, NRD_ABSENT_SPECULAR },
        { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_DENOISER_REBLUR_SPECULAR, NRD_ABSENT_DIFFUSE },
        { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, NRD_ABSENT_SPECULAR },
        { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION, NRD_DENOISER_REBLUR_SPECULAR_OCCLUSION, NRD_ABSENT_DIFFUSE },
    };
    static const char *const nothing[3] = { NULL, NULL, NULL };
    stage a, b;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        stage_open(&a, rows[i].rest, 0, NULL);
        stage_open(&b, rows[i].whole, rows[i].absent, NULL);
        const nrd_info *rest = nrd_get_info(a.instance), *whole = nrd_get_info(b.instance);
        assert_int_equal(whole->permanent_bytes + whole->transient_bytes, rest->permanent_bytes + rest->transient_bytes);
        assert_int_equal(whole->pass_count, rest->pass_count);
        for (int r = 0; r < NRD_RESOURCE_COUNT; r++) assert_int_equal(nrd_uses_resource(a.instance, (nrd_resource)r), nrd_uses_resource(b.instance, (nrd_resource)r));
        stage_set(&a, nothing);
        stage_set(&b, nothing);
        compare(&a, &b, name_of(rows[i].absent));
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Graph  >>graph */
static uint64_t bytes_of(const nrd_info *info) { return info->permanent_bytes + info->transient_bytes; }

static const nrd_left_out *find_left_out(const nrd_info *info, const char *what)
{
    for (uint32_t i = 0; i < info->left_out_count; i++) if (!strcmp(info->left_out[i].what, what)) return &info->left_out[i];
    return NULL;
}

static nrd *create(spy *s, nrd_denoiser denoiser, uint32_t absent)
{
    nrd_denoiser_desc one = { STAGE_IDENTIFIER, denoiser };
    nrd *instance = NULL;
    memset(s, 0, sizeof *s);
    nrd_desc desc = spied_desc(s, &one, 1, 1920, 1080, 0);
    desc.absent = absent;
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    return instance;
}

static void textures_that_only_absent_things_need_shrink_to_a_texel_and_are_listed_with_their_bytes(void **state)
{
    static const struct { nrd_denoiser denoiser; uint32_t absent; const char *textures[2]; uint32_t passes; } rows[] = {
        { NRD_DENOISER_REBLUR_DIFFUSE, NRD_ABSENT_STABILIZATION, { "DIFF_STABILIZED", NULL }, 0 },
        { NRD_DENOISER_REBLUR_DIFFUSE, NRD_ABSENT_LIGHTING_CHANGE, { "DIFF_TILE", "DIFF_TILE_RAW" }, 1 },
        { NRD_DENOISER_REBLUR_SPECULAR, NRD_ABSENT_STABILIZATION, { "SPEC_STABILIZED", NULL }, 0 },
        { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_ABSENT_STABILIZATION, { "DIFF_STABILIZED", "SPEC_STABILIZED" }, 0 },
        { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_ABSENT_BLUR, { NULL, NULL }, 2 },
        { NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, NRD_ABSENT_BLUR, { NULL, NULL }, 0 },   /* what copies to the output stays */
        { NRD_DENOISER_SIGMA_SHADOW, NRD_ABSENT_STABILIZATION, { "SHADOW_STABILIZED", NULL }, 0 },
    };
    spy s, t;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        nrd *full = create(&s, rows[i].denoiser, 0), *lean = create(&t, rows[i].denoiser, rows[i].absent);
        const nrd_info *all = nrd_get_info(full), *info = nrd_get_info(lean);
        uint64_t saved = 0;
        for (int k = 0; k < 2 && rows[i].textures[k]; k++) {
            const nrd_left_out *left = find_left_out(info, rows[i].textures[k]);
            assert_non_null(left);
            assert_non_null(strstr(left->why, "nrd_desc.absent has NRD_ABSENT_"));
            assert_null(find_left_out(all, rows[i].textures[k]));
            saved += left->bytes_saved;
        }
        assert_true(saved > 0 || !rows[i].textures[0]);
        assert_int_equal(all->permanent_bytes + all->transient_unshared_bytes - info->permanent_bytes - info->transient_unshared_bytes, saved);
        assert_int_equal(all->pass_count - info->pass_count, rows[i].passes);
        for (uint32_t k = 0; k < info->texture_count; k++)
            assert_int_equal(info->textures[k].width == 1 && info->textures[k].height == 1, find_left_out(info, info->textures[k].name) != NULL);
        nrd_destroy(full);
        nrd_destroy(lean);
    }
}

static void no_absence_adds_a_pass_or_a_byte(void **state)
{
    spy s, t;
    (void)state;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        nrd *full = create(&s, (nrd_denoiser)d, 0);
        for (uint32_t absent = 0; absent <= NRD_ABSENT_ALL; absent++) {
            if ((absent & NRD_ABSENT_DIFFUSE) && (absent & NRD_ABSENT_SPECULAR)) continue;
            nrd *lean = create(&t, (nrd_denoiser)d, absent);
            assert_true(bytes_of(nrd_get_info(lean)) <= bytes_of(nrd_get_info(full)));
            assert_in_range(nrd_get_info(lean)->pass_count, 1, nrd_get_info(full)->pass_count);
            for (uint32_t p = 0; p < nrd_get_info(lean)->pipeline_count; p++) assert_int_equal(nrd_get_info(lean)->pipelines[p].spec_constants[SPEC_ABSENT], absent);
            if (absent & NRD_ABSENT_MOTION) assert_false(nrd_uses_resource(lean, NRD_RESOURCE_IN_MV));
            nrd_destroy(lean);
        }
        nrd_destroy(full);
    }
}

static void both_signals_absent_and_unknown_bits_are_refused(void **state)
{
    static const uint32_t wrong[] = { NRD_ABSENT_DIFFUSE | NRD_ABSENT_SPECULAR, NRD_ABSENT_ALL + 1 };
    nrd_denoiser_desc one = { STAGE_IDENTIFIER, NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR };
    (void)state;
    for (int i = 0; i < 2; i++) {
        spy s = { 0 };
        nrd *instance = NULL;
        nrd_desc desc = spied_desc(&s, &one, 1, 64, 48, 0);
        desc.absent = wrong[i];
        assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_INVALID_ARGUMENT);
        assert_int_equal(s.errors, 1);
        assert_non_null(strstr(s.text, "nrd_desc.absent"));
        assert_null(instance);
    }
}

static void every_absence_has_a_name_and_a_text(void **state)
{
    (void)state;
    uint32_t count = 0;
    while (nrd_absence_name(count)) assert_true(nrd_absence_text(count++)[0] != 0);
    assert_int_equal((1u << count) - 1, NRD_ABSENT_ALL);
    assert_null(nrd_absence_text(count));
    assert_string_equal(name_of(NRD_ABSENT_SKY), "sky");
    assert_string_equal(name_of(NRD_ABSENT_BLUR), "blur");
}

static void without_motion_a_new_view_needs_a_restart(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create(&s, NRD_DENOISER_REBLUR_DIFFUSE, NRD_ABSENT_MOTION);
    nrd_frame frames[4] = { still_frame(1), still_frame(1), still_frame(1), still_frame(1) };
    static const char *const moved[] = { "camera", "jitter", "rectangle", "camera" };
    pose elsewhere = pose_at(1, 0, 0);
    nrd_camera other = pose_camera(&elsewhere);
    frames[0].camera = other;
    frames[1].camera.jitter[0] = 0.25f;
    frames[2].rect_width = 100;
    frames[3].camera_prev = &other;
    nrd_frame first = still_frame(0), again = still_frame(1);
    assert_int_equal(nrd_set_frame(instance, &first), NRD_RESULT_OK);
    for (int i = 0; i < 4; i++) {
        forget_messages(&s);
        assert_int_equal(nrd_set_frame(instance, &frames[i]), NRD_RESULT_INVALID_ARGUMENT);
        assert_non_null(strstr(s.text, moved[i]));
        assert_non_null(strstr(s.text, "NRD_ABSENT_MOTION"));
        frames[i].restart = 1;
        assert_int_equal(nrd_set_frame(instance, &frames[i]), NRD_RESULT_OK);
    }
    assert_int_equal(nrd_set_frame(instance, &again), NRD_RESULT_OK);   /* replaces frame 1: the one before it counts */
    nrd_destroy(instance);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(promises_that_are_kept_change_no_bit_of_any_output),
        cmocka_unit_test(a_denoiser_without_one_of_its_signals_is_the_denoiser_of_the_other),
        cmocka_unit_test(textures_that_only_absent_things_need_shrink_to_a_texel_and_are_listed_with_their_bytes),
        cmocka_unit_test(no_absence_adds_a_pass_or_a_byte),
        cmocka_unit_test(both_signals_absent_and_unknown_bits_are_refused),
        cmocka_unit_test(every_absence_has_a_name_and_a_text),
        cmocka_unit_test(without_motion_a_new_view_needs_a_restart),
    };
    return cmocka_run_group_tests(tests, open_validated_device, close_device);
}
