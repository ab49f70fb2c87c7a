/* nrd_explain: what is kept and left out, why, and what that saves; as items and as text, JSON and Graphviz. */
#define NRD_IMPLEMENTATION
#include "nrd.h"

#include "frame_fixture.h"

enum { IDENTIFIER = 7 };

static nrd *create(spy *s, const nrd_denoiser *denoisers, uint32_t count, uint32_t features, uint32_t absent)
{
    nrd_denoiser_desc list[4];
    nrd *instance = NULL;
    memset(s, 0, sizeof *s);
    for (uint32_t i = 0; i < count; i++) list[i] = (nrd_denoiser_desc){ IDENTIFIER + i, denoisers[i] };
    nrd_desc desc = spied_desc(s, list, count, 1920, 1080, features);
    desc.absent = absent;
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    nrd_frame frame = still_frame(0);
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
    return instance;
}

static bool find_item(const nrd *instance, const char *kind, const char *name, nrd_explanation *out)
{
    for (uint32_t i = 0; nrd_explain_item(instance, i, out); i++)
        if (!strcmp(out->kind, kind) && !strcmp(out->name, name)) return true;
    return false;
}

static void assert_item(const nrd *instance, const char *kind, const char *name, const char *why)
{
    nrd_explanation e;
    if (!find_item(instance, kind, name, &e)) fail_msg("no %s %s", kind, name);
    assert_int_equal(e.kept, why == NULL);
    if (why && (!e.why || !strstr(e.why, why))) fail_msg("%s %s: %s, not %s", kind, name, e.why ? e.why : "no reason", why);
    if (!why) assert_null(e.why);
}

static void put(nrd *instance, nrd_denoiser denoiser, const char *name, double value)
{
    any_settings settings;
    nrd_settings_defaults(denoiser, &settings);
    assert_true(put_setting_by_name(denoiser, &settings, name, value));
    assert_int_equal(nrd_set_settings(instance, IDENTIFIER, &settings), NRD_RESULT_OK);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Items  >>items */
static void passes_textures_and_inputs_are_left_out_for_the_declaration_or_setting_that_does_not_need_them(void **state)
{
    const nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    spy s;
    (void)state;
    nrd *instance = create(&s, &denoiser, 1, 0, NRD_ABSENT_STABILIZATION | NRD_ABSENT_MOTION);
    assert_item(instance, "pass", "pre-pass", "NRD_FEATURE_PREPASS");
    assert_item(instance, "pass", "split screen", "NRD_FEATURE_SPLIT_SCREEN");
    assert_item(instance, "pass", "lighting change", NULL);
    assert_item(instance, "texture", "DIFF_STABILIZED", "NRD_ABSENT_STABILIZATION");
    assert_item(instance, "texture", "DIFF_HISTORY", NULL);
    assert_item(instance, "input", "IN_MV", "NRD_ABSENT_MOTION");
    assert_item(instance, "input", "IN_VIEWZ", NULL);
    assert_item(instance, "input", "IN_DIFF_RADIANCE_HITDIST", NULL);
    assert_item(instance, "input", "IN_DIFF_CONFIDENCE", "NRD_FEATURE_HISTORY_CONFIDENCE");
    put(instance, denoiser, "antilag_sensitivity", 0);
    assert_item(instance, "pass", "lighting change", "antilag_sensitivity is 0");
    assert_item(instance, "texture", "DIFF_TILE", NULL);   /* the setting may come back */
    put(instance, denoiser, "max_blur_radius", 0);
    assert_item(instance, "pass", "lighting change", NULL);
    assert_item(instance, "pass", "post-blur 1", "max_blur_radius is 0 (or performance_mode is 2)");
    nrd_destroy(instance);
}

static void declared_features_wait_for_their_frame_settings(void **state)
{
    const nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    spy s;
    (void)state;
    nrd *instance = create(&s, &denoiser, 1, NRD_FEATURE_ALL, 0);
    assert_item(instance, "pass", "split screen", "split_screen is 0");
    assert_item(instance, "pass", "pre-pass", "diffuse_prepass_blur_radius is 0");
    assert_item(instance, "input", "IN_DIFF_CONFIDENCE", "history_confidence_available is 0");
    nrd_frame frame = still_frame(1);
    frame.split_screen = 0.5f;
    frame.history_confidence_available = 1;
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
    put(instance, denoiser, "diffuse_prepass_blur_radius", 20);
    assert_item(instance, "pass", "split screen", NULL);
    assert_item(instance, "pass", "pre-pass", NULL);
    assert_item(instance, "input", "IN_DIFF_CONFIDENCE", NULL);
    nrd_destroy(instance);
}

static void motion_of_reflections_is_an_input_while_the_frame_says_so(void **state)
{
    const nrd_denoiser denoiser = NRD_DENOISER_REBLUR_SPECULAR;
    spy s;
    (void)state;
    nrd *instance = create(&s, &denoiser, 1, NRD_FEATURE_SPECULAR_MOTION, 0);
    assert_item(instance, "input", "IN_SPEC_MV", "specular_motion is 0");
    nrd_frame frame = still_frame(1);
    frame.specular_motion = NRD_SPECULAR_MOTION_HIT;
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
    assert_item(instance, "input", "IN_SPEC_MV", NULL);
    nrd_destroy(instance);
}

/* What the explanation says is what happens: the same passes are dispatched, the same inputs bound, and the bytes add up. */
static void assert_true_of(nrd *instance)
{
    const nrd_info *info = nrd_get_info(instance);
    const nrd_dispatch *dispatches;
    uint32_t count, kept_passes = 0;
    uint64_t bytes = 0;
    nrd_explanation e;
    bool bound[NRD_RESOURCE_COUNT] = { false };
    assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &dispatches, &count), NRD_RESULT_OK);
    for (uint32_t d = 0; d < count; d++)
        for (uint32_t b = 0; b < dispatches[d].binding_count; b++)
            if (dispatches[d].bindings[b].resource != NRD_RESOURCE_INTERNAL) bound[dispatches[d].bindings[b].resource] = true;
    for (uint32_t i = 0; nrd_explain_item(instance, i, &e); i++) {
        if (!e.kept) { assert_non_null(e.why); continue; }
        if (!strcmp(e.kind, "pass")) kept_passes++;
        if (!strcmp(e.kind, "texture")) bytes += e.bytes;
        if (strcmp(e.kind, "input")) continue;
        int r = 0;
        while (strcmp(nrd_resource_name((nrd_resource)r), e.name)) r++;
        assert_true(bound[r]);
        bound[r] = false;
    }
    for (int r = 0; r < NRD_RESOURCE_COUNT; r++) assert_false(bound[r] && nrd_resource_format((nrd_resource)r) == NRD_FORMAT_ANY);
    assert_int_equal(kept_passes, count);
    assert_true(bytes <= info->permanent_bytes + info->transient_unshared_bytes);
    assert_true(info->permanent_bytes + info->transient_unshared_bytes - bytes <= 16 * (uint64_t)info->texture_count);   /* single texels */
}

static void the_explanation_agrees_with_the_dispatches_of_every_denoiser(void **state)
{
    spy s;
    (void)state;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++)
        for (uint32_t k = 0; k < 200; k++) {
            nrd_denoiser denoiser = (nrd_denoiser)d;
            uint32_t features = (uint32_t)(random_at(k, 1, 0) * (NRD_FEATURE_ALL + 1)), absent = (uint32_t)(random_at(k, 2, 0) * (NRD_ABSENT_ALL + 1));
            if ((absent & NRD_ABSENT_DIFFUSE) && (absent & NRD_ABSENT_SPECULAR)) continue;
            nrd *instance = create(&s, &denoiser, 1, features, absent);
            nrd_setting setting;
            if (k % 3 == 0 && find_setting(denoiser, "antilag_sensitivity", &setting)) put(instance, denoiser, "antilag_sensitivity", 0);
            if (k % 3 == 1 && find_setting(denoiser, "max_blur_radius", &setting)) put(instance, denoiser, "max_blur_radius", 0);
            if (k % 3 == 2 && features & NRD_FEATURE_PREPASS && find_setting(denoiser, "specular_prepass_blur_radius", &setting))
                put(instance, denoiser, "specular_prepass_blur_radius", 10);
            assert_true_of(instance);
            nrd_destroy(instance);
        }
}

static void an_absent_signal_saves_the_difference_between_the_denoisers(void **state)
{
    const nrd_denoiser both = NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR;
    spy s, t;
    nrd_explanation e;
    (void)state;
    nrd *full = create(&s, &both, 1, 0, 0), *lean = create(&t, &both, 1, 0, NRD_ABSENT_SPECULAR);
    const nrd_info *all = nrd_get_info(full), *info = nrd_get_info(lean);
    assert_true(find_item(lean, "signal", "specular", &e));
    assert_false(e.kept);
    assert_int_equal(e.bytes, all->permanent_bytes + all->transient_unshared_bytes - info->permanent_bytes - info->transient_unshared_bytes);
    assert_true(e.microseconds > 0);
    assert_false(find_item(full, "signal", "specular", &e));
    nrd_destroy(full);
    nrd_destroy(lean);
}

/* The next row of published_passes.txt: denoiser, pass, nanoseconds per pixel. */
static bool next_row(FILE *file, char denoiser[64], char pass[64], float *ns)
{
    char line[256];
    return fgets(line, sizeof line, file) && sscanf(line, "%*[^|]|%*[^|]|%63[^|]|%63[^|]|%f", denoiser, pass, ns) == 3;
}

static void every_pass_of_every_denoiser_has_the_time_that_was_published(void **state)
{
    FILE *file = fopen("examples/report/published_passes.txt", "r");
    char denoiser[64], pass[64];
    float ns;
    (void)state;
    assert_non_null(file);
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        nrd_denoiser one = (nrd_denoiser)d;
        nrd_explanation e;
        spy s;
        nrd *instance = create(&s, &one, 1, 0, 0);
        for (uint32_t i = 0; nrd_explain_item(instance, i, &e); i++) {
            if (strcmp(e.kind, "pass")) continue;
            assert_true(next_row(file, denoiser, pass, &ns));
            assert_string_equal(denoiser, nrd_denoiser_name(one));
            assert_string_equal(pass, e.name);
            assert_true(ns > 0 && fabs(e.microseconds - ns * 1e-3 * 1920 * 1080) < 1e-3 * e.microseconds);
        }
        nrd_destroy(instance);
    }
    assert_false(next_row(file, denoiser, pass, &ns));
    fclose(file);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Texts  >>texts */
static char *explain(const nrd *instance, nrd_explain_format format)
{
    size_t size = nrd_explain(instance, format, NULL, 0);
    char *text = malloc(size + 1);
    assert_non_null(text);
    assert_int_equal(nrd_explain(instance, format, text, size + 1), size);
    assert_int_equal(strlen(text), size);
    return text;
}

static uint32_t occurrences(const char *text, const char *what)
{
    uint32_t n = 0;
    for (const char *at = text; (at = strstr(at, what)); at++) n++;
    return n;
}

/* Outside of strings every bracket is closed by its own kind, and nothing is left open. */
static void assert_balanced(const char *text)
{
    char open[64];
    int depth = 0;
    bool in_string = false;
    for (const char *c = text; *c; c++) {
        if (*c == '"') in_string = !in_string;
        if (in_string) continue;
        if (*c == '{' || *c == '[') { assert_true(depth < 64); open[depth++] = *c; }
        if (*c == '}' || *c == ']') { assert_true(depth > 0); depth--; assert_int_equal(open[depth], *c == '}' ? '{' : '['); }
    }
    assert_int_equal(depth, 0);
    assert_false(in_string);
}

static void every_format_has_every_item(void **state)
{
    static const nrd_denoiser list[] = { NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_DENOISER_SIGMA_SHADOW, NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION };
    spy s;
    nrd_explanation e;
    uint32_t items = 0, left_out = 0;
    (void)state;
    nrd *instance = create(&s, list, 3, NRD_FEATURE_SPLIT_SCREEN, NRD_ABSENT_SPECULAR | NRD_ABSENT_STABILIZATION);
    for (; nrd_explain_item(instance, items, &e); items++) left_out += !e.kept;
    char *text = explain(instance, NRD_EXPLAIN_TEXT), *json = explain(instance, NRD_EXPLAIN_JSON), *dot = explain(instance, NRD_EXPLAIN_GRAPHVIZ);
    assert_int_equal(occurrences(text, "  kept      ") + occurrences(text, "  left out  "), items);
    assert_int_equal(occurrences(text, "  left out  "), left_out);
    assert_non_null(strstr(text, "\nsaved: "));
    assert_int_equal(occurrences(json, "\"kind\": "), items);
    assert_int_equal(occurrences(json, "\"kept\": false"), left_out);
    assert_int_equal(occurrences(json, "\"why\": "), left_out);
    assert_balanced(json);
    assert_int_equal(occurrences(dot, "style=dashed"), left_out);
    assert_int_equal(occurrences(dot, "shape="), items);
    assert_true(occurrences(dot, " -> ") > 20);
    assert_balanced(dot);
    free(text);
    free(json);
    free(dot);
    nrd_destroy(instance);
}

static void a_short_buffer_gets_the_beginning_and_wrong_arguments_nothing(void **state)
{
    const nrd_denoiser denoiser = NRD_DENOISER_REBLUR_DIFFUSE;
    spy s;
    char small[32];
    (void)state;
    nrd *instance = create(&s, &denoiser, 1, 0, 0);
    char *whole = explain(instance, NRD_EXPLAIN_TEXT);
    memset(small, 'x', sizeof small);
    assert_int_equal(nrd_explain(instance, NRD_EXPLAIN_TEXT, small, 20), strlen(whole));
    assert_int_equal(strlen(small), 19);
    assert_memory_equal(small, whole, 19);
    assert_int_equal(small[20], 'x');
    assert_int_equal(nrd_explain(NULL, NRD_EXPLAIN_TEXT, small, 20), 0);
    assert_int_equal(nrd_explain(instance, NRD_EXPLAIN_TEXT, NULL, 20), 0);
    assert_false(nrd_explain_item(NULL, 0, NULL));
    assert_false(nrd_explain_item(instance, 0, NULL));
    free(whole);
    nrd_destroy(instance);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(passes_textures_and_inputs_are_left_out_for_the_declaration_or_setting_that_does_not_need_them),
        cmocka_unit_test(declared_features_wait_for_their_frame_settings),
        cmocka_unit_test(motion_of_reflections_is_an_input_while_the_frame_says_so),
        cmocka_unit_test(the_explanation_agrees_with_the_dispatches_of_every_denoiser),
        cmocka_unit_test(an_absent_signal_saves_the_difference_between_the_denoisers),
        cmocka_unit_test(every_pass_of_every_denoiser_has_the_time_that_was_published),
        cmocka_unit_test(every_format_has_every_item),
        cmocka_unit_test(a_short_buffer_gets_the_beginning_and_wrong_arguments_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
