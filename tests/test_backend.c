/* A back end in plain C, written from nrd.h alone: textures are numbers, memory is intervals, a dispatch mixes what it reads into what
   it writes. It obeys the dispatch list and finds out whether that list can be obeyed: hazards, lifetimes, aliased memory. */
#define NRD_IMPLEMENTATION
#include "nrd.h"

#include "frame_fixture.h"

enum { SEEDS = 1000, FRAMES = 6, MAX_DENOISERS = 4, MAX_TEXTURES = 256, MAX_DISPATCHES = 64 };

/* ---------------------------------------------------------------------------------------------------------------------------
   Device  >>device */
typedef struct content { bool defined; uint64_t value; } content;

typedef struct device {
    const nrd *instance;
    const nrd_info *info;
    bool pooled;    /* transient textures lie in one block, where nrd_texture.offset says */
    bool reversed;  /* dispatches between two barriers run last first */
    content textures[MAX_TEXTURES], images[NRD_RESOURCE_COUNT];
    uint32_t barriers;
} device;

static uint32_t current_seed;
#define REQUIRE(condition, ...) do { if (!(condition)) { print_error("seed %u: ", current_seed); print_error(__VA_ARGS__); print_error("\n"); } assert_true(condition); } while (0)

static uint64_t mix_bytes(uint64_t h, const void *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++) h = (h ^ ((const uint8_t *)bytes)[i]) * 0x100000001b3u;
    return h;
}

/* Histories begin as zeros. */
static void device_open(device *d, const nrd *instance, bool pooled, bool reversed)
{
    memset(d, 0, sizeof *d);
    d->instance = instance;
    d->info = nrd_get_info(instance);
    d->pooled = pooled;
    d->reversed = reversed;
    REQUIRE(d->info->texture_count <= MAX_TEXTURES, "%u textures", d->info->texture_count);
    for (uint32_t t = 0; t < d->info->texture_count; t++) d->textures[t].defined = d->info->textures[t].permanent;
}

static content *content_of(device *d, const nrd_binding *b) { return b->resource == NRD_RESOURCE_INTERNAL ? &d->textures[b->texture] : &d->images[b->resource]; }

static bool is_transient(const device *d, uint32_t texture) { return !d->info->textures[texture].permanent; }

static bool share_memory(const device *d, uint32_t a, uint32_t b)
{
    const nrd_texture *x = &d->info->textures[a], *y = &d->info->textures[b];
    return d->pooled && is_transient(d, a) && is_transient(d, b) && x->offset < y->offset + y->bytes && y->offset < x->offset + x->bytes;
}

static bool same_place(const device *d, const nrd_binding *a, const nrd_binding *b)
{
    if (a->resource != b->resource) return false;
    return a->resource != NRD_RESOURCE_INTERNAL || a->texture == b->texture || share_memory(d, a->texture, b->texture);
}

static bool is_read(const nrd_binding *b) { return b->access != NRD_ACCESS_WRITE; }
static bool is_written(const nrd_binding *b) { return b->access == NRD_ACCESS_WRITE || b->access == NRD_ACCESS_BUFFER; }

static void check_binding(const device *d, const nrd_dispatch *at, const nrd_binding *b)
{
    bool stored = is_written(b), buffer = b->access == NRD_ACCESS_BUFFER || b->access == NRD_ACCESS_UNIFORM;
    if (b->resource != NRD_RESOURCE_INTERNAL) {
        REQUIRE(b->resource < NRD_RESOURCE_COUNT && nrd_uses_resource(d->instance, b->resource), "%s: an image that was not announced", at->name);
        REQUIRE(!stored || nrd_resource_format(b->resource) != NRD_FORMAT_ANY, "%s writes the input %s", at->name, nrd_resource_name(b->resource));
        return;
    }
    REQUIRE(b->texture < d->info->texture_count, "%s: texture %u", at->name, b->texture);
    REQUIRE(d->info->textures[b->texture].buffer == buffer, "%s: %s is a buffer, or is not", at->name, d->info->textures[b->texture].name);
    const nrd_texture *t = &d->info->textures[b->texture];
    REQUIRE(t->denoiser == d->info->passes[at->pass].denoiser, "%s uses %s of another denoiser", at->name, t->name);
    REQUIRE(t->permanent || (t->first_pass <= at->pass && at->pass <= t->last_pass), "%s uses %s outside of its lifetime", at->name, t->name);
    REQUIRE(t->permanent || t->offset + t->bytes <= d->info->transient_bytes, "%s lies outside of the transient block", t->name);
    REQUIRE(b->access != NRD_ACCESS_READ_LINEAR || !nrd_format_is_uint(t->format), "%s filters the integers of %s", at->name, t->name);
}

static void check_dispatch(const device *d, const nrd_dispatch *at)
{
    REQUIRE(at->pass < d->info->pass_count && at->pipeline == d->info->passes[at->pass].pipeline, "%s: pass or pipeline", at->name);
    const nrd_pipeline *pipeline = &d->info->pipelines[at->pipeline];
    REQUIRE(at->binding_count == pipeline->binding_count && at->binding_count <= d->info->max_bindings, "%s: number of bindings", at->name);
    REQUIRE(at->groups_x > 0 && at->groups_y > 0 && at->constants, "%s: empty", at->name);
    REQUIRE(!at->indirect || d->info->textures[at->indirect - 1].buffer, "%s: the number of its groups is in no buffer", at->name);
    for (uint32_t a = 0; a < at->binding_count; a++) {
        REQUIRE(at->bindings[a].access == pipeline->access[a], "%s: binding %u is accessed in another way than its pipeline says", at->name, a);
        check_binding(d, at, &at->bindings[a]);
        for (uint32_t b = 0; b < a; b++) {
            const nrd_binding *x = &at->bindings[a], *y = &at->bindings[b];
            if (!same_place(d, x, y) || (!is_written(x) && !is_written(y))) continue;
            REQUIRE(x->access != y->access && x->access != NRD_ACCESS_READ_LINEAR && y->access != NRD_ACCESS_READ_LINEAR, "%s writes a texture twice, or filters it", at->name);
            REQUIRE(x->resource != NRD_RESOURCE_INTERNAL || x->texture == y->texture, "%s reads and writes the same memory as two textures", at->name);
        }
    }
}

static const char *name_of(const device *d, const nrd_binding *b)
{
    return b->resource == NRD_RESOURCE_INTERNAL ? d->info->textures[b->texture].name : nrd_resource_name(b->resource);
}

/* Of which a texel stays for the binding. */
static bool is_left_out(const device *d, const nrd_binding *b)
{
    bool out = false;
    for (uint32_t i = 0; i < d->info->left_out_count; i++) out |= !strcmp(d->info->left_out[i].what, name_of(d, b));
    return out && b->resource == NRD_RESOURCE_INTERNAL && d->info->textures[b->texture].width == 1;
}

static void execute(device *d, const nrd_dispatch *at)
{
    const nrd_pipeline *pipeline = &d->info->pipelines[at->pipeline];
    uint64_t h = mix_bytes(0xcbf29ce484222325u, pipeline->shader, strlen(pipeline->shader));
    h = mix_bytes(h, at->constants, d->info->constant_bytes);
    h = mix_bytes(h, at->push, sizeof at->push);
    if (at->indirect) h = mix_bytes(h, &d->textures[at->indirect - 1].value, sizeof d->textures[0].value);
    for (uint32_t b = 0; b < at->binding_count; b++) {
        if (!is_read(&at->bindings[b])) continue;
        const content *from = content_of(d, &at->bindings[b]);
        REQUIRE(from->defined || is_left_out(d, &at->bindings[b]), "%s reads %s, which nobody wrote", at->name, name_of(d, &at->bindings[b]));
        h = mix_bytes(h, &from->value, sizeof from->value);
    }
    for (uint32_t b = 0; b < at->binding_count; b++) {
        const nrd_binding *binding = &at->bindings[b];
        if (!is_written(binding)) continue;
        for (uint32_t t = 0; binding->resource == NRD_RESOURCE_INTERNAL && t < d->info->texture_count; t++)
            if (t != binding->texture && share_memory(d, t, binding->texture)) d->textures[t].defined = false;
        *content_of(d, binding) = (content){ true, mix_bytes(h, &b, sizeof b) };
    }
}

/* Are the groups of the first counted by the second? */
static bool is_counted_by(const nrd_dispatch *x, const nrd_dispatch *y)
{
    bool counted = false;
    for (uint32_t b = 0; b < y->binding_count; b++) counted |= y->bindings[b].access == NRD_ACCESS_BUFFER && x->indirect == 1 + y->bindings[b].texture;
    return counted;
}

/* Read after write, write after read, write after write. */
static bool conflict(const device *d, const nrd_dispatch *x, const nrd_dispatch *y)
{
    if (is_counted_by(x, y) || is_counted_by(y, x)) return true;
    for (uint32_t a = 0; a < x->binding_count; a++)
        for (uint32_t b = 0; b < y->binding_count; b++)
            if ((is_written(&x->bindings[a]) || is_written(&y->bindings[b])) && same_place(d, &x->bindings[a], &y->bindings[b])) return true;
    return false;
}

/* From one dispatch up to the next that needs a barrier before it. */
static uint32_t batch_end(const device *d, const nrd_dispatch *dispatches, uint32_t first, uint32_t count)
{
    for (uint32_t end = first + 1; end < count; end++)
        for (uint32_t i = first; i < end; i++)
            if (conflict(d, &dispatches[i], &dispatches[end])) return end;
    return count;
}

static void device_run(device *d, const nrd_dispatch *dispatches, uint32_t count, uint32_t frame)
{
    for (uint32_t t = 0; t < d->info->texture_count; t++) if (is_transient(d, t)) d->textures[t].defined = false;
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) d->images[i] = (content){ nrd_resource_format((nrd_resource)i) == NRD_FORMAT_ANY, 1000u * frame + (uint32_t)i };
    for (uint32_t first = 0; first < count;) {
        uint32_t end = d->reversed ? batch_end(d, dispatches, first, count) : first + 1;
        for (uint32_t i = 0; i < end - first; i++) execute(d, &dispatches[d->reversed ? end - 1 - i : first + i]);
        d->barriers++;
        first = end;
    }
}

/* What leaves the frame is the same on both. */
static void check_same(const device *a, const device *b)
{
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++)
        REQUIRE(a->images[i].defined == b->images[i].defined && a->images[i].value == b->images[i].value, "%s differs", nrd_resource_name((nrd_resource)i));
    for (uint32_t t = 0; t < a->info->texture_count; t++)
        REQUIRE(is_transient(a, t) || a->textures[t].value == b->textures[t].value, "%s differs", a->info->textures[t].name);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Random apps  >>apps */
static uint32_t below(uint32_t a, uint32_t b, uint32_t n) { return (uint32_t)(random_at(current_seed, a, b) * n); }

static nrd *create_random(spy *s, nrd_denoiser_desc *list)
{
    uint32_t count = 1 + below(1, 0, MAX_DENOISERS);
    nrd *instance = NULL;
    memset(s, 0, sizeof *s);
    for (uint32_t i = 0; i < count; i++) list[i] = (nrd_denoiser_desc){ 100 + i, (nrd_denoiser)(i ? below(2, i, NRD_DENOISER_COUNT) : current_seed % NRD_DENOISER_COUNT) };
    nrd_desc desc = spied_desc(s, list, count, 1 + below(3, 0, 300), 1 + below(4, 0, 300), below(5, 0, NRD_FEATURE_ALL + 1));
    desc.absent = below(6, 0, 2) ? below(7, 0, NRD_ABSENT_ALL + 1) : 0;
    if (desc.absent & NRD_ABSENT_DIFFUSE) desc.absent &= ~(uint32_t)NRD_ABSENT_SPECULAR;
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    return instance;
}

/* Every setting: its default, an end of its range, or anything in between. What the features do not allow is refused, and then 0. */
static void set_random_settings(nrd *instance, spy *s, uint32_t frame)
{
    const nrd_info *info = nrd_get_info(instance);
    for (uint32_t i = 0; i < info->denoiser_count; i++) {
        nrd_denoiser denoiser = info->denoisers[i].denoiser;
        any_settings settings;
        nrd_setting setting;
        nrd_settings_defaults(denoiser, &settings);
        for (uint32_t k = 0; nrd_get_setting(denoiser, k, &setting); k++) {
            uint32_t what = below(100 + frame, 32 * i + k, 4);
            double at = what == 1 ? 0 : what == 2 ? 1 : random_at(current_seed, 200 + frame, 32 * i + k);
            if (what) setting_put(&setting, &settings, setting.min + at * (setting.max - setting.min));
        }
        while (nrd_set_settings(instance, info->denoisers[i].identifier, &settings) != NRD_RESULT_OK) {
            assert_non_null(strstr(s->text, "features lacks"));
            uint32_t k = 0;
            while (nrd_get_setting(denoiser, k, &setting) && strncmp(s->text, setting.name, strlen(setting.name))) k++;
            REQUIRE(nrd_get_setting(denoiser, k, &setting), "no setting of that name: %s", s->text);
            setting_put(&setting, &settings, 0);
        }
    }
}

static void set_random_frame(nrd *instance, uint32_t index)
{
    uint32_t features = instance->desc.features, width = instance->desc.width, height = instance->desc.height;
    nrd_frame frame = still_frame(index);
    frame.restart = below(300, index, 8) == 0;
    if (!(instance->desc.absent & NRD_ABSENT_MOTION)) {
        pose p = pose_at(random_at(current_seed, 301, index), 0, 0);
        frame.camera = pose_camera(&p);
        frame.rect_width = 1 + below(302, index, width);
        frame.rect_height = 1 + below(303, index, height);
    }
    if (features & NRD_FEATURE_SPLIT_SCREEN) frame.split_screen = below(304, index, 3) / 2.0f;
    frame.history_confidence_available = (features & NRD_FEATURE_HISTORY_CONFIDENCE) && below(305, index, 2);
    frame.disocclusion_threshold_mix_available = (features & NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX) && below(306, index, 2);
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
}

/* All denoisers, or some of them. */
static uint32_t choose_denoisers(const nrd_info *info, uint32_t frame, uint32_t *identifiers)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < info->denoiser_count; i++)
        if (below(400 + frame, i, 3)) identifiers[count++] = info->denoisers[i].identifier;
    return count;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Tests  >>tests */
static void run_app(void)
{
    spy s;
    nrd_denoiser_desc list[MAX_DENOISERS];
    static device plain, pooled, reversed;
    nrd *instance = create_random(&s, list);
    device_open(&plain, instance, false, false);
    device_open(&pooled, instance, true, false);
    device_open(&reversed, instance, true, true);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        uint32_t identifiers[MAX_DENOISERS], chosen = choose_denoisers(plain.info, frame, identifiers), count;
        const nrd_dispatch *dispatches;
        set_random_settings(instance, &s, frame);
        set_random_frame(instance, frame);
        assert_int_equal(nrd_get_dispatches(instance, chosen ? identifiers : NULL, chosen, &dispatches, &count), NRD_RESULT_OK);
        REQUIRE(count > 0 && count <= plain.info->pass_count && count <= MAX_DISPATCHES, "%u dispatches", count);
        for (uint32_t d = 0; d < count; d++) {
            REQUIRE(d == 0 || dispatches[d].pass > dispatches[d - 1].pass, "%s comes too late", dispatches[d].name);
            check_dispatch(&pooled, &dispatches[d]);
        }
        device_run(&plain, dispatches, count, frame);
        device_run(&pooled, dispatches, count, frame);
        device_run(&reversed, dispatches, count, frame);
        check_same(&plain, &pooled);
        check_same(&plain, &reversed);
    }
    assert_true(reversed.barriers <= plain.barriers);
    nrd_destroy(instance);
}

static void random_apps_run_without_hazards_on_a_device_with_aliased_memory(void **state)
{
    (void)state;
    for (current_seed = 0; current_seed < SEEDS; current_seed++) run_app();
}

/* The back end does see what it looks for. */
static void the_device_tells_aliased_contents_from_those_that_are_there(void **state)
{
    static const nrd_denoiser_desc two[] = { { 1, NRD_DENOISER_SIGMA_SHADOW }, { 2, NRD_DENOISER_SIGMA_SHADOW } };
    spy s = { 0 };
    nrd *instance = NULL;
    static device d;
    const nrd_dispatch *dispatches;
    uint32_t count, one[2], found = 0;
    (void)state;
    nrd_desc desc = spied_desc(&s, two, 2, 64, 48, 0);
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    set_random_frame(instance, 0);
    assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &dispatches, &count), NRD_RESULT_OK);
    device_open(&d, instance, true, false);
    for (uint32_t t = 0; t < d.info->texture_count && found < 2; t++) if (!strcmp(d.info->textures[t].name, "SHADOW_MEAN")) one[found++] = t;
    assert_int_equal(found, 2);
    assert_true(share_memory(&d, one[0], one[1]));
    device_run(&d, dispatches, count, 0);
    assert_false(d.textures[one[0]].defined);   /* the second denoiser lives where the first did */
    assert_true(d.textures[one[1]].defined);
    assert_true(conflict(&d, &dispatches[0], &dispatches[1]));
    assert_true(conflict(&d, &dispatches[1], &dispatches[2]));   /* of two denoisers: by memory alone */
    d.pooled = false;
    assert_false(share_memory(&d, one[0], one[1]));
    nrd_destroy(instance);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_apps_run_without_hazards_on_a_device_with_aliased_memory),
        cmocka_unit_test(the_device_tells_aliased_contents_from_those_that_are_there),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
