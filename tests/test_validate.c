/* Everything that nrd.h refuses: the code, one message that names field, value and range, and nothing changed. */
#define NRD_IMPLEMENTATION
#include "nrd.h"

#include "frame_fixture.h"

/* ---------------------------------------------------------------------------------------------------------------------------
   What a refusal must look like  >>refusal */
static void assert_one_error(const spy *s, nrd_result got, nrd_result expected, const char *names)
{
    if (got != expected || s->messages != 1 || !strstr(s->text, names))
        print_error("expected %d and one message with '%s'; got %d and %u: %s\n", expected, names, got, s->messages, s->text);
    assert_int_equal(got, expected);
    assert_int_equal(s->messages, 1);
    assert_int_equal(s->severity, NRD_SEVERITY_ERROR);
    assert_int_equal(s->result, expected);
    assert_true(strstr(s->text, names) != NULL);
    assert_null(strchr(s->text, '\n'));
}

static bool close_to(double text, double value) { return (isnan(text) && isnan(value)) || text == value || fabs(text - value) <= 1e-5 * fabs(value) + 1e-6; }

/* "<owner>.<name> is <value>, allowed: <min> to <max>" */
static void assert_range_error(const spy *s, nrd_result got, const char *field, double value, double min, double max)
{
    double shown = 0, low = 0, high = 0;
    assert_one_error(s, got, NRD_RESULT_INVALID_ARGUMENT, field);
    const char *rest = strstr(s->text, field) + strlen(field);
    if (sscanf(rest, " is %lf, allowed: %lf to %lf", &shown, &low, &high) != 3 || !close_to(shown, value) || !close_to(low, min) || !close_to(high, max))
        fail_msg("value %g or range %g to %g is missing in: %s", value, min, max, s->text);
}

typedef struct snapshot { const spy *s; unsigned char *copy; } snapshot;

/* The instance is one block that the spy gave: not a byte of it may change. */
static snapshot remember(const spy *s)
{
    snapshot r = { s, (unsigned char *)malloc(s->bytes) };
    assert_non_null(r.copy);
    memcpy(r.copy, s->block, s->bytes);
    return r;
}

static void assert_unchanged(snapshot *r)
{
    assert_memory_equal(r->copy, r->s->block, r->s->bytes);
    free(r->copy);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   nrd_create  >>create */
static const nrd_denoiser_desc two_denoisers[] = { { 1, NRD_DENOISER_REFERENCE }, { 2, NRD_DENOISER_REBLUR_DIFFUSE } };

static nrd_desc good_desc(spy *s)
{
    memset(s, 0, sizeof *s);
    return spied_desc(s, two_denoisers, 2, 64, 48, 0);
}

static nrd_result try_create(const nrd_desc *desc)
{
    nrd *const untouched = (nrd *)(void *)desc;
    nrd *out = untouched;
    nrd_result result = nrd_create(desc, &out);
    if (result != NRD_RESULT_OK) assert_ptr_equal(out, untouched);
    else nrd_destroy(out);
    return result;
}

static void numbers_of_the_desc_outside_their_range_are_refused(void **state)
{
    static const struct { const char *field; size_t offset; uint32_t value, min, max; } rows[] = {
        { "nrd_desc.width", offsetof(nrd_desc, width), 0, 1, 16384 },
        { "nrd_desc.width", offsetof(nrd_desc, width), 16385, 1, 16384 },
        { "nrd_desc.width", offsetof(nrd_desc, width), UINT32_MAX, 1, 16384 },
        { "nrd_desc.height", offsetof(nrd_desc, height), 0, 1, 16384 },
        { "nrd_desc.height", offsetof(nrd_desc, height), 16385, 1, 16384 },
        { "nrd_desc.denoiser_count", offsetof(nrd_desc, denoiser_count), 0, 1, 64 },
        { "nrd_desc.denoiser_count", offsetof(nrd_desc, denoiser_count), 65, 1, 64 },
        { "nrd_desc.features", offsetof(nrd_desc, features), NRD_FEATURE_ALL + 1, 0, NRD_FEATURE_ALL },
        { "nrd_desc.normal_encoding", offsetof(nrd_desc, normal_encoding), NRD_NORMAL_FORMAT_RGBA16_SNORM + 1, 0, NRD_NORMAL_FORMAT_RGBA16_SNORM },
        { "nrd_desc.roughness_encoding", offsetof(nrd_desc, roughness_encoding), NRD_ROUGHNESS_FORMAT_SQRT_LINEAR + 1, 0, NRD_ROUGHNESS_FORMAT_SQRT_LINEAR },
    };
    spy s;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        nrd_desc desc = good_desc(&s);
        memcpy((char *)&desc + rows[i].offset, &rows[i].value, 4);
        assert_range_error(&s, try_create(&desc), rows[i].field, rows[i].value, rows[i].min, rows[i].max);
        assert_int_equal(s.allocations, 0);
    }
}

static void the_limits_of_the_desc_are_accepted(void **state)
{
    nrd_denoiser_desc many[64];
    spy s;
    (void)state;
    for (uint32_t i = 0; i < 64; i++) many[i].identifier = UINT32_MAX - i, many[i].denoiser = (nrd_denoiser)(i % NRD_DENOISER_COUNT);
    nrd_desc desc = good_desc(&s);
    desc.denoisers = many;
    desc.denoiser_count = 64;
    desc.width = desc.height = 16384;
    desc.features = NRD_FEATURE_ALL;
    desc.normal_encoding = NRD_NORMAL_FORMAT_RGBA16_SNORM;
    desc.roughness_encoding = NRD_ROUGHNESS_FORMAT_SQRT_LINEAR;
    assert_int_equal(try_create(&desc), NRD_RESULT_OK);
    desc.width = desc.height = 1;
    assert_int_equal(try_create(&desc), NRD_RESULT_OK);
    assert_int_equal(s.messages, 0);
    assert_int_equal(s.allocations, s.releases);
}

static void unknown_and_repeated_denoisers_are_refused(void **state)
{
    const nrd_denoiser_desc unknown[] = { { 1, NRD_DENOISER_REFERENCE }, { 2, NRD_DENOISER_COUNT } };
    const nrd_denoiser_desc repeated[] = { { 4, NRD_DENOISER_REFERENCE }, { 5, NRD_DENOISER_REFERENCE }, { 4, NRD_DENOISER_REBLUR_DIFFUSE } };
    spy s;
    (void)state;
    nrd_desc desc = good_desc(&s);
    desc.denoisers = unknown;
    assert_range_error(&s, try_create(&desc), "denoisers[].denoiser", NRD_DENOISER_COUNT, 0, NRD_DENOISER_COUNT - 1);
    desc = good_desc(&s);
    desc.denoisers = repeated;
    desc.denoiser_count = 3;
    assert_one_error(&s, try_create(&desc), NRD_RESULT_DUPLICATE_IDENTIFIER, "nrd_desc.denoisers");
    assert_int_equal(s.allocations, 0);
}

static void missing_pointers_of_the_desc_are_refused(void **state)
{
    spy s;
    (void)state;
    nrd_desc desc = good_desc(&s);
    desc.denoisers = NULL;
    assert_one_error(&s, try_create(&desc), NRD_RESULT_INVALID_ARGUMENT, "nrd_desc.denoisers");
    desc = good_desc(&s);
    desc.release = NULL;
    assert_one_error(&s, try_create(&desc), NRD_RESULT_INVALID_ARGUMENT, "release");
    desc = good_desc(&s);
    desc.allocate = NULL;
    assert_one_error(&s, try_create(&desc), NRD_RESULT_INVALID_ARGUMENT, "allocate");
    assert_int_equal(s.allocations, 0);
}

static void an_allocator_that_returns_null_is_reported(void **state)
{
    spy s;
    (void)state;
    nrd_desc desc = good_desc(&s);
    s.refuse = true;
    assert_one_error(&s, try_create(&desc), NRD_RESULT_OUT_OF_MEMORY, "nrd_create");
    assert_int_equal(s.allocations, 1);
    assert_int_equal(s.releases, 0);
}

static void refusals_without_a_logger_return_the_same_code(void **state)
{
    spy s;
    (void)state;
    nrd_desc desc = good_desc(&s);
    desc.message = NULL;
    desc.width = 0;
    assert_int_equal(try_create(&desc), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(s.messages, 0);
}

static void the_desc_and_its_list_may_vanish_after_creation(void **state)
{
    spy s;
    nrd *instance = NULL;
    nrd_denoiser_desc list[2];
    (void)state;
    memcpy(list, two_denoisers, sizeof list);
    nrd_desc desc = good_desc(&s);
    desc.denoisers = list;
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    memset(list, 0xff, sizeof list);
    memset(&desc, 0xff, sizeof desc);
    assert_memory_equal(nrd_get_info(instance)->denoisers, two_denoisers, sizeof list);
    nrd_destroy(instance);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Instance with two frames behind it  >>instance */
static nrd *busy_instance(spy *s, uint32_t features)
{
    nrd *instance = NULL;
    const nrd_dispatch *dispatches;
    uint32_t count;
    nrd_desc desc = good_desc(s);
    desc.features = features;
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    for (uint32_t i = 0; i < 2; i++) {
        nrd_frame frame = still_frame(i);
        assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
        assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &dispatches, &count), NRD_RESULT_OK);
    }
    assert_int_equal(s->messages, 0);
    return instance;
}

static nrd_result try_frame(nrd *instance, spy *s, const nrd_frame *frame)
{
    snapshot before = remember(s);
    forget_messages(s);
    nrd_result result = nrd_set_frame(instance, frame);
    assert_unchanged(&before);
    return result;
}

static nrd_result try_settings(nrd *instance, spy *s, uint32_t identifier, const void *settings)
{
    snapshot before = remember(s);
    forget_messages(s);
    nrd_result result = nrd_set_settings(instance, identifier, settings);
    assert_unchanged(&before);
    return result;
}

/* Values that a setting must refuse: just outside, far outside, not a number. */
static uint32_t bad_values(const nrd_setting *row, double *values)
{
    uint32_t count = 0;
    if (row->is_float) {
        values[count++] = nextafterf((float)row->min, -INFINITY);
        values[count++] = nextafterf((float)row->max, INFINITY);
        values[count++] = row->min - fabs(row->min) - 1;
        values[count++] = row->max + fabs(row->max) + 1;
        values[count++] = NAN;
        values[count++] = -INFINITY;
        values[count++] = INFINITY;
        return count;
    }
    if (row->min > 0) values[count++] = row->min - 1;
    values[count++] = row->max + 1;
    values[count++] = UINT32_MAX;
    return count;
}

static void every_frame_setting_outside_its_range_is_refused(void **state)
{
    spy s;
    double values[8];
    nrd_setting row;
    char field[128];
    (void)state;
    nrd *instance = busy_instance(&s, NRD_FEATURE_ALL);
    for (uint32_t i = 0; nrd_get_setting(NRD_DENOISER_COUNT, i, &row); i++) {
        uint32_t count = bad_values(&row, values);
        snprintf(field, sizeof field, "nrd_frame.%s", row.name);
        for (uint32_t k = 0; k < count; k++) {
            nrd_frame frame = still_frame(2);
            setting_put(&row, &frame, values[k]);
            assert_range_error(&s, try_frame(instance, &s, &frame), field, row.is_float ? (double)(float)values[k] : values[k], row.min, row.max);
        }
    }
    nrd_destroy(instance);
}

static void every_denoiser_setting_outside_its_range_is_refused(void **state)
{
    spy s;
    double values[8];
    nrd_setting row;
    any_settings settings;
    char field[128];
    (void)state;
    nrd *instance = create_all(&s);
    const nrd_info *info = nrd_get_info(instance);
    for (uint32_t d = 0; d < info->denoiser_count; d++) {
        nrd_denoiser denoiser = info->denoisers[d].denoiser;
        for (uint32_t i = 0; nrd_get_setting(denoiser, i, &row); i++) {
            uint32_t count = bad_values(&row, values);
            snprintf(field, sizeof field, "%s.%s", nrd_denoiser_name(denoiser), row.name);
            for (uint32_t k = 0; k < count; k++) {
                nrd_settings_defaults(denoiser, &settings);
                setting_put(&row, &settings, values[k]);
                nrd_result result = try_settings(instance, &s, info->denoisers[d].identifier, &settings);
                assert_range_error(&s, result, field, row.is_float ? (double)(float)values[k] : values[k], row.min, row.max);
            }
        }
    }
    nrd_destroy(instance);
}

static void the_limits_and_defaults_of_every_setting_are_accepted(void **state)
{
    spy s;
    nrd_setting row;
    any_settings settings;
    uint32_t index = 2;
    (void)state;
    nrd *instance = create_all(&s);
    for (int d = 0; d <= NRD_DENOISER_COUNT; d++)
        for (uint32_t i = 0; nrd_get_setting((nrd_denoiser)d, i, &row); i++)
            for (int k = 0; k < 3; k++) {
                double value = k == 0 ? row.min : k == 1 ? row.max : row.value;
                if (!strcmp(row.name, "validation")) value = fmin(value, NRD_DENOISER_COUNT);   /* of an instance that has no more */
                nrd_frame frame = still_frame(index++);
                nrd_settings_defaults((nrd_denoiser)(d % NRD_DENOISER_COUNT), &settings);
                setting_put(&row, d == NRD_DENOISER_COUNT ? (void *)&frame : (void *)&settings, value);
                assert_true(row.min <= row.value && row.value <= row.max && row.min < row.max);
                assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
                if (d < NRD_DENOISER_COUNT) assert_int_equal(nrd_set_settings(instance, (uint32_t)d, &settings), NRD_RESULT_OK);
            }
    assert_int_equal(s.messages, 0);
    nrd_destroy(instance);
}

static void settings_as_data_are_complete(void **state)
{
    nrd_setting row;
    any_settings settings;
    (void)state;
    assert_false(nrd_get_setting((nrd_denoiser)(NRD_DENOISER_COUNT + 1), 0, &row));
    assert_false(nrd_get_setting(NRD_DENOISER_REFERENCE, 0, NULL));
    for (int d = 0; d <= NRD_DENOISER_COUNT; d++) {
        uint32_t i = 0;
        for (; nrd_get_setting((nrd_denoiser)d, i, &row); i++) {
            nrd_setting again;
            assert_true(row.name[0] && row.text[0] && row.unit && row.offset + 4 <= nrd_settings_size((nrd_denoiser)d));
            assert_true(find_setting((nrd_denoiser)d, row.name, &again) && again.offset == row.offset);
        }
        assert_true(i > 0);
    }
    assert_true(sizeof settings >= nrd_settings_size(NRD_DENOISER_REBLUR_DIFFUSE));
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Cameras  >>cameras */
typedef void spoil(nrd_camera *c);

static void nan_in_projection(nrd_camera *c) { c->view_to_clip[9] = NAN; }
static void infinity_in_projection(nrd_camera *c) { c->view_to_clip[0] = INFINITY; }
static void zero_projection(nrd_camera *c) { memset(c->view_to_clip, 0, sizeof c->view_to_clip); }
static void projection_without_width(nrd_camera *c) { c->view_to_clip[0] = 0; }
static void projection_without_height(nrd_camera *c) { c->view_to_clip[5] = 0; }
static void projection_without_w(nrd_camera *c) { c->view_to_clip[11] = 0; }
static void orthographic_without_depth(nrd_camera *c) { c->view_to_clip[11] = c->view_to_clip[10] = 0; c->view_to_clip[15] = 1; }
static void nan_in_view(nrd_camera *c) { c->world_to_view[13] = NAN; }
static void zero_view(nrd_camera *c) { memset(c->world_to_view, 0, sizeof c->world_to_view); }

static void transpose(float m[16])
{
    for (int r = 0; r < 4; r++)
        for (int k = 0; k < r; k++) {
            float swap = m[4 * r + k];
            m[4 * r + k] = m[4 * k + r];
            m[4 * k + r] = swap;
        }
}

static void transposed_projection(nrd_camera *c) { transpose(c->view_to_clip); }
static void transposed_view(nrd_camera *c) { transpose(c->world_to_view); }

static void scaled_view(nrd_camera *c)
{
    for (int i = 0; i < 12; i++) c->world_to_view[i] *= 1.1f;
}

static void sheared_view(nrd_camera *c) { c->world_to_view[4] += 0.2f; }
static void view_with_a_last_row(nrd_camera *c) { c->world_to_view[3] = 0.5f; }
static void view_of_other_scale(nrd_camera *c) { c->world_to_view[15] = 2; }

static const struct { spoil *spoil; const char *field; } spoils[] = {
    { nan_in_projection, "view_to_clip" }, { infinity_in_projection, "view_to_clip" }, { zero_projection, "view_to_clip" },
    { projection_without_width, "view_to_clip" }, { projection_without_height, "view_to_clip" }, { projection_without_w, "view_to_clip" },
    { orthographic_without_depth, "view_to_clip" }, { nan_in_view, "world_to_view" }, { zero_view, "world_to_view" },
    { transposed_view, "world_to_view" }, { scaled_view, "world_to_view" }, { sheared_view, "world_to_view" },
    { view_with_a_last_row, "world_to_view" }, { view_of_other_scale, "world_to_view" },
};

static nrd_camera tilted_camera(void)
{
    pose p = pose_at(1, 2, 3);
    p.yaw = 0.3;
    p.pitch = -0.2;
    p.roll = 0.1;
    return pose_camera(&p);
}

static void bad_cameras_are_refused_by_name(void **state)
{
    spy s;
    char owner[64];
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    for (size_t i = 0; i < sizeof spoils / sizeof spoils[0]; i++) {
        nrd_frame frame = still_frame(2);
        frame.camera = tilted_camera();
        spoils[i].spoil(&frame.camera);
        snprintf(owner, sizeof owner, "nrd_frame.camera.%s ", spoils[i].field);
        assert_one_error(&s, try_frame(instance, &s, &frame), NRD_RESULT_INVALID_ARGUMENT, owner);
        nrd_camera previous = frame.camera;
        frame.camera = tilted_camera();
        frame.camera_prev = &previous;
        snprintf(owner, sizeof owner, "nrd_frame.camera_prev.%s ", spoils[i].field);
        assert_one_error(&s, try_frame(instance, &s, &frame), NRD_RESULT_INVALID_ARGUMENT, owner);
    }
    nrd_destroy(instance);
}

static void a_transposed_projection_is_refused(void **state)
{
    spy s;
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    nrd_frame frame = still_frame(2);
    transposed_projection(&frame.camera);
    assert_one_error(&s, try_frame(instance, &s, &frame), NRD_RESULT_INVALID_ARGUMENT, "view_to_clip");
    nrd_destroy(instance);
}

/* k * M projects as M does. */
static void a_projection_with_another_factor_is_refused_or_understood(void **state)
{
    spy s;
    const nrd_dispatch *dispatches;
    uint32_t count;
    float expected[4];
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    for (uint32_t i = 0; i < 2; i++) {
        nrd_frame frame = still_frame(2 + i);
        for (int k = 0; k < 16 && i; k++) frame.camera.view_to_clip[k] *= 2;
        if (nrd_set_frame(instance, &frame) != NRD_RESULT_OK) continue;
        assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &dispatches, &count), NRD_RESULT_OK);
        const nrd_constants *c = (const nrd_constants *)dispatches[0].constants;
        if (i == 0) memcpy(expected, c->frustum, sizeof expected);
        for (int k = 0; k < 4; k++) assert_float_equal(c->frustum[k], expected[k], 1e-6);
    }
    nrd_destroy(instance);
}

static void jitter_beyond_half_a_pixel_is_refused(void **state)
{
    static const float bad[] = { 0.51f, -0.51f, 3e38f, NAN };
    spy s;
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    for (int axis = 0; axis < 2; axis++)
        for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
            nrd_frame frame = still_frame(2);
            frame.camera.jitter[axis] = bad[i];
            assert_range_error(&s, try_frame(instance, &s, &frame), axis ? "nrd_frame.camera.jitter[1]" : "nrd_frame.camera.jitter[0]", bad[i], -0.5, 0.5);
            nrd_camera previous = frame.camera;
            frame = still_frame(2);
            frame.camera_prev = &previous;
            assert_range_error(&s, try_frame(instance, &s, &frame), axis ? "nrd_frame.camera_prev.jitter[1]" : "nrd_frame.camera_prev.jitter[0]", bad[i], -0.5, 0.5);
        }
    nrd_destroy(instance);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   The rest of nrd_frame  >>frame */
static void rectangles_outside_the_images_are_refused(void **state)
{
    static const struct { uint32_t width, height, x, y; const char *field; double value, min, max; } rows[] = {
        { 65, 0, 0, 0, "nrd_frame.rect_width", 65, 1, 64 },
        { UINT32_MAX, 0, 0, 0, "nrd_frame.rect_width", UINT32_MAX, 1, 64 },
        { 0, 49, 0, 0, "nrd_frame.rect_height", 49, 1, 48 },
        { 0, 0, 1, 0, "nrd_frame.rect_origin_x", 1, 0, 0 },
        { 60, 0, 5, 0, "nrd_frame.rect_origin_x", 5, 0, 4 },
        { 60, 0, UINT32_MAX, 0, "nrd_frame.rect_origin_x", UINT32_MAX, 0, 4 },
        { 0, 40, 0, 9, "nrd_frame.rect_origin_y", 9, 0, 8 },
    };
    spy s;
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        nrd_frame frame = still_frame(2);
        frame.rect_width = rows[i].width;
        frame.rect_height = rows[i].height;
        frame.rect_origin_x = rows[i].x;
        frame.rect_origin_y = rows[i].y;
        assert_range_error(&s, try_frame(instance, &s, &frame), rows[i].field, rows[i].value, rows[i].min, rows[i].max);
    }
    nrd_frame frame = still_frame(2);
    frame.rect_width = 60, frame.rect_origin_x = 4, frame.rect_height = 40, frame.rect_origin_y = 8;
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
    nrd_destroy(instance);
}

static void an_unknown_clip_y_is_refused(void **state)
{
    spy s;
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    nrd_frame frame = still_frame(2);
    frame.clip_y = (nrd_clip_y)3;
    assert_range_error(&s, try_frame(instance, &s, &frame), "nrd_frame.clip_y", 3, 0, 2);
    nrd_destroy(instance);
}

static void what_needs_an_undeclared_feature_is_refused(void **state)
{
    static const struct { nrd_denoiser owner; const char *setting; double value; uint32_t feature; const char *feature_name; } rows[] = {
        { NRD_DENOISER_COUNT, "split_screen", 0.5, NRD_FEATURE_SPLIT_SCREEN, "NRD_FEATURE_SPLIT_SCREEN" },
        { NRD_DENOISER_COUNT, "history_confidence_available", 1, NRD_FEATURE_HISTORY_CONFIDENCE, "NRD_FEATURE_HISTORY_CONFIDENCE" },
        { NRD_DENOISER_COUNT, "disocclusion_threshold_mix_available", 1, NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX, "NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX" },
        { NRD_DENOISER_REBLUR_DIFFUSE, "diffuse_prepass_blur_radius", 10, NRD_FEATURE_PREPASS, "NRD_FEATURE_PREPASS" },
        { NRD_DENOISER_COUNT, "strand_material_id", 1, NRD_FEATURE_MATERIALS, "NRD_FEATURE_MATERIALS" },
        { NRD_DENOISER_COUNT, "camera_attached_reflection_material_id", 3, NRD_FEATURE_MATERIALS, "NRD_FEATURE_MATERIALS" },
        { NRD_DENOISER_COUNT, "specular_motion", 2, NRD_FEATURE_SPECULAR_MOTION, "NRD_FEATURE_SPECULAR_MOTION" },
        { NRD_DENOISER_REBLUR_DIFFUSE, "diffuse_checkerboard", 1, NRD_FEATURE_CHECKERBOARD, "NRD_FEATURE_CHECKERBOARD" },
        { NRD_DENOISER_REBLUR_DIFFUSE, "specular_checkerboard", 2, NRD_FEATURE_CHECKERBOARD, "NRD_FEATURE_CHECKERBOARD" },
        { NRD_DENOISER_REBLUR_DIFFUSE, "specular_roughness_limit", 0.5, NRD_FEATURE_ROUGHNESS_LIMIT, "NRD_FEATURE_ROUGHNESS_LIMIT" },
        { NRD_DENOISER_REBLUR_DIFFUSE, "hit_distance_reconstruction", 1, NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION, "NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION" },
    };
    spy s;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        for (int declared = 0; declared < 2; declared++) {
            nrd *instance = busy_instance(&s, declared ? rows[i].feature : NRD_FEATURE_ALL & ~rows[i].feature);
            bool of_frame = rows[i].owner == NRD_DENOISER_COUNT;
            nrd_frame frame = still_frame(2);
            any_settings settings;
            nrd_settings_defaults(NRD_DENOISER_REBLUR_DIFFUSE, &settings);
            assert_true(put_setting_by_name(rows[i].owner, of_frame ? (void *)&frame : (void *)&settings, rows[i].setting, rows[i].value));
            if (declared) assert_int_equal(of_frame ? nrd_set_frame(instance, &frame) : nrd_set_settings(instance, 2, &settings), NRD_RESULT_OK);
            else {
                nrd_result result = of_frame ? try_frame(instance, &s, &frame) : try_settings(instance, &s, 2, &settings);
                assert_one_error(&s, result, NRD_RESULT_INVALID_ARGUMENT, rows[i].setting);
                assert_true(strstr(s.text, rows[i].feature_name) != NULL);
            }
            nrd_destroy(instance);
        }
}

static void only_the_first_of_several_mistakes_is_reported(void **state)
{
    spy s;
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    nrd_frame frame = still_frame(40);   /* the jump is no news while the frame is refused */
    frame.denoising_range = -1;
    frame.split_screen = 7;
    frame.rect_width = 1000;
    zero_view(&frame.camera);
    assert_one_error(&s, try_frame(instance, &s, &frame), NRD_RESULT_INVALID_ARGUMENT, "nrd_frame.denoising_range");
    nrd_destroy(instance);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Identifiers, order, NULL  >>calls */
static void unknown_identifiers_are_refused_with_their_number(void **state)
{
    static const uint32_t identifiers[] = { 2, 99 };
    spy s;
    const nrd_dispatch *dispatches = (const nrd_dispatch *)(const void *)identifiers;
    uint32_t count = 1234;
    nrd_reblur_settings settings = nrd_reblur_defaults();
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    assert_one_error(&s, try_settings(instance, &s, 99, &settings), NRD_RESULT_UNKNOWN_DENOISER, "99");
    snapshot before = remember(&s);
    forget_messages(&s);
    assert_one_error(&s, nrd_get_dispatches(instance, identifiers, 2, &dispatches, &count), NRD_RESULT_UNKNOWN_DENOISER, "99");
    assert_unchanged(&before);
    assert_ptr_equal(dispatches, identifiers);
    assert_int_equal(count, 1234);
    nrd_destroy(instance);
}

static void dispatches_before_the_first_frame_are_refused(void **state)
{
    spy s;
    const nrd_dispatch *dispatches = NULL;
    uint32_t count = 1234;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0);
    snapshot before = remember(&s);
    assert_one_error(&s, nrd_get_dispatches(instance, NULL, 0, &dispatches, &count), NRD_RESULT_FRAME_NOT_SET, "nrd_set_frame");
    assert_unchanged(&before);
    assert_null(dispatches);
    assert_int_equal(count, 1234);
    nrd_destroy(instance);
}

static void a_refused_first_frame_does_not_count(void **state)
{
    spy s;
    const nrd_dispatch *dispatches;
    uint32_t count;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0);
    nrd_frame frame = nrd_frame_defaults();   /* has no camera */
    assert_one_error(&s, try_frame(instance, &s, &frame), NRD_RESULT_INVALID_ARGUMENT, "nrd_frame.camera");
    assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &dispatches, &count), NRD_RESULT_FRAME_NOT_SET);
    nrd_destroy(instance);
}

static void missing_arguments_are_refused_without_a_crash(void **state)
{
    spy s;
    nrd *out = NULL;
    nrd_denoiser found = NRD_DENOISER_REFERENCE;
    const nrd_dispatch *dispatches = NULL;
    uint32_t count = 0;
    nrd_frame frame = still_frame(0);
    (void)state;
    assert_int_equal(nrd_create(NULL, &out), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_set_frame(NULL, &frame), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_set_settings(NULL, 1, &frame), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_get_dispatches(NULL, NULL, 0, &dispatches, &count), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_find_denoiser(NULL, &found), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_find_denoiser("reference", NULL), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_report(NULL, NRD_SEVERITY_ERROR, NRD_RESULT_DEVICE_ERROR, "nobody listens"), NRD_RESULT_DEVICE_ERROR);
    assert_null(nrd_get_info(NULL));
    assert_false(nrd_uses_resource(NULL, NRD_RESOURCE_IN_VIEWZ));
    nrd *instance = busy_instance(&s, 0);
    assert_one_error(&s, try_settings(instance, &s, 1, NULL), NRD_RESULT_INVALID_ARGUMENT, "settings");
    forget_messages(&s);
    assert_one_error(&s, nrd_get_dispatches(instance, NULL, 3, &dispatches, &count), NRD_RESULT_INVALID_ARGUMENT, "identifiers");
    nrd_destroy(instance);
}

/* "Every function that can fail ... nrd_desc.message also gets one line": wherever there is someone to tell. */
static void missing_arguments_are_reported_where_an_instance_is_known(void **state)
{
    spy s;
    const nrd_dispatch *dispatches = NULL;
    uint32_t count = 0;
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    assert_one_error(&s, try_frame(instance, &s, NULL), NRD_RESULT_INVALID_ARGUMENT, "frame");
    forget_messages(&s);
    assert_one_error(&s, nrd_get_dispatches(instance, NULL, 0, NULL, &count), NRD_RESULT_INVALID_ARGUMENT, "dispatches");
    forget_messages(&s);
    assert_one_error(&s, nrd_get_dispatches(instance, NULL, 0, &dispatches, NULL), NRD_RESULT_INVALID_ARGUMENT, "count");
    nrd_destroy(instance);
    nrd_desc desc = good_desc(&s);
    assert_one_error(&s, nrd_create(&desc, NULL), NRD_RESULT_INVALID_ARGUMENT, "out");
}

static void names_are_found_and_unknown_ones_are_not(void **state)
{
    nrd_denoiser found = NRD_DENOISER_COUNT;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        assert_int_equal(nrd_find_denoiser(nrd_denoiser_name((nrd_denoiser)i), &found), NRD_RESULT_OK);
        assert_int_equal(found, i);
    }
    assert_int_equal(nrd_find_denoiser("reblur_specula", &found), NRD_RESULT_UNKNOWN_DENOISER);
    assert_int_equal(found, NRD_DENOISER_COUNT - 1);
    assert_null(nrd_denoiser_name(NRD_DENOISER_COUNT));
    assert_null(nrd_resource_name(NRD_RESOURCE_COUNT));
    assert_null(nrd_resource_text((nrd_resource)-1));
    for (int i = 0; i < NRD_RESULT_COUNT; i++)
        for (int k = 0; k < i; k++) assert_string_not_equal(nrd_result_string((nrd_result)i), nrd_result_string((nrd_result)k));
    assert_string_equal(nrd_result_string(NRD_RESULT_COUNT), "unknown result");
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        assert_true(nrd_resource_name((nrd_resource)i)[0] && nrd_resource_text((nrd_resource)i)[0]);
        assert_int_equal(nrd_resource_format((nrd_resource)i) == NRD_FORMAT_ANY, strncmp(nrd_resource_name((nrd_resource)i), "IN_", 3) == 0);
    }
}

static void a_runtime_can_report_through_the_instance(void **state)
{
    spy s;
    (void)state;
    nrd *instance = busy_instance(&s, 0);
    assert_one_error(&s, nrd_report(instance, NRD_SEVERITY_ERROR, NRD_RESULT_DEVICE_ERROR, "lost"), NRD_RESULT_DEVICE_ERROR, "lost");
    nrd_destroy(instance);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_of_the_desc_outside_their_range_are_refused),
        cmocka_unit_test(the_limits_of_the_desc_are_accepted),
        cmocka_unit_test(unknown_and_repeated_denoisers_are_refused),
        cmocka_unit_test(missing_pointers_of_the_desc_are_refused),
        cmocka_unit_test(an_allocator_that_returns_null_is_reported),
        cmocka_unit_test(refusals_without_a_logger_return_the_same_code),
        cmocka_unit_test(the_desc_and_its_list_may_vanish_after_creation),
        cmocka_unit_test(every_frame_setting_outside_its_range_is_refused),
        cmocka_unit_test(every_denoiser_setting_outside_its_range_is_refused),
        cmocka_unit_test(the_limits_and_defaults_of_every_setting_are_accepted),
        cmocka_unit_test(settings_as_data_are_complete),
        cmocka_unit_test(bad_cameras_are_refused_by_name),
        cmocka_unit_test(a_transposed_projection_is_refused),
        cmocka_unit_test(a_projection_with_another_factor_is_refused_or_understood),
        cmocka_unit_test(jitter_beyond_half_a_pixel_is_refused),
        cmocka_unit_test(rectangles_outside_the_images_are_refused),
        cmocka_unit_test(an_unknown_clip_y_is_refused),
        cmocka_unit_test(what_needs_an_undeclared_feature_is_refused),
        cmocka_unit_test(only_the_first_of_several_mistakes_is_reported),
        cmocka_unit_test(unknown_identifiers_are_refused_with_their_number),
        cmocka_unit_test(dispatches_before_the_first_frame_are_refused),
        cmocka_unit_test(a_refused_first_frame_does_not_count),
        cmocka_unit_test(missing_arguments_are_refused_without_a_crash),
        cmocka_unit_test(missing_arguments_are_reported_where_an_instance_is_known),
        cmocka_unit_test(names_are_found_and_unknown_ones_are_not),
        cmocka_unit_test(a_runtime_can_report_through_the_instance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
