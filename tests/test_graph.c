/* The pass graph as data: no GPU. */
#define NRD_IMPLEMENTATION
#include "nrd.h"

#include "frame_fixture.h"

/* ---------------------------------------------------------------------------------------------------------------------------
   All that an app may switch from frame to frame  >>modes */
enum { MAX_TEXTURES = 256 };
enum { MODE_NO_BLUR = 1, MODE_NO_ANTILAG = 2, MODE_PREPASS = 4, MODE_SPLIT = 8, MODE_CONFIDENCE = 16, MODE_THRESHOLD_MIX = 32, MODE_RECONSTRUCTION = 64, MODE_COUNT = 128 };

/* What the features do not allow is left off. */
static uint32_t allowed_modes(uint32_t features)
{
    return MODE_NO_BLUR | MODE_NO_ANTILAG | (features & NRD_FEATURE_PREPASS ? MODE_PREPASS : 0) | (features & NRD_FEATURE_SPLIT_SCREEN ? MODE_SPLIT : 0)
         | (features & NRD_FEATURE_HISTORY_CONFIDENCE ? MODE_CONFIDENCE : 0) | (features & NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX ? MODE_THRESHOLD_MIX : 0)
         | (features & NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION ? MODE_RECONSTRUCTION : 0);
}

static void apply_settings(nrd *instance, uint32_t mode)
{
    const nrd_info *info = nrd_get_info(instance);
    for (uint32_t i = 0; i < info->denoiser_count; i++) {
        nrd_denoiser denoiser = info->denoisers[i].denoiser;
        any_settings settings;
        nrd_settings_defaults(denoiser, &settings);
        if (mode & MODE_NO_BLUR) put_setting_by_name(denoiser, &settings, "max_blur_radius", 0);
        if (mode & MODE_NO_ANTILAG) put_setting_by_name(denoiser, &settings, "antilag_sensitivity", 0);
        if (mode & MODE_PREPASS) put_setting_by_name(denoiser, &settings, "diffuse_prepass_blur_radius", 20);
        if (mode & MODE_RECONSTRUCTION) put_setting_by_name(denoiser, &settings, "hit_distance_reconstruction", 1);
        assert_int_equal(nrd_set_settings(instance, info->denoisers[i].identifier, &settings), NRD_RESULT_OK);
    }
}

typedef struct run { const nrd_dispatch *dispatches; uint32_t count; } run;

static run run_frame(nrd *instance, const nrd_frame *frame)
{
    run r = { NULL, 0 };
    assert_int_equal(nrd_set_frame(instance, frame), NRD_RESULT_OK);
    assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &r.dispatches, &r.count), NRD_RESULT_OK);
    return r;
}

static run run_mode(nrd *instance, uint32_t frame_index, uint32_t mode)
{
    nrd_frame frame = still_frame(frame_index);
    frame.split_screen = mode & MODE_SPLIT ? 0.5f : 0;
    if (instance->desc.features & NRD_FEATURE_VALIDATION) frame.validation = instance->info.denoiser_count > 1 ? 2 : 1;   /* the reference has no overlay */
    frame.history_confidence_available = (mode & MODE_CONFIDENCE) != 0;
    frame.disocclusion_threshold_mix_available = (mode & MODE_THRESHOLD_MIX) != 0;
    if (mode & MODE_NO_BLUR && instance->desc.features & NRD_FEATURE_SPECULAR_MOTION) frame.specular_motion = NRD_SPECULAR_MOTION_HIT;
    apply_settings(instance, mode);
    return run_frame(instance, &frame);
}

typedef void property(nrd *instance, uint32_t features, uint32_t mode);

/* Those that change nothing but what is compiled. */
enum { FEATURES_OF_CODE = NRD_FEATURE_CHECKERBOARD | NRD_FEATURE_MATERIALS | NRD_FEATURE_ROUGHNESS_LIMIT };

/* The checker and the overlay only add a pass at the end: with nothing else and with everything else will do. */
static bool is_tedious(uint32_t features)
{
    uint32_t looking = NRD_FEATURE_CHECK | NRD_FEATURE_VALIDATION, others = features & ~looking;
    return (features & looking) && others && others != (NRD_FEATURE_ALL & ~looking & ~(uint32_t)FEATURES_OF_CODE);
}

/* Calls it for every denoiser alone and for all together, with every feature combination and everything those allow. */
static void for_every_instance(property *check, bool every_mode)
{
    nrd_denoiser_desc all[NRD_DENOISER_COUNT + 1];
    for (uint32_t i = 0; i <= NRD_DENOISER_COUNT; i++) all[i].identifier = 10 + i, all[i].denoiser = (nrd_denoiser)(i % NRD_DENOISER_COUNT);
    for (uint32_t which = 0; which <= NRD_DENOISER_COUNT; which++)
        for (uint32_t features = 0; features <= NRD_FEATURE_ALL; features++)
            for (uint32_t mode = 0; mode < (every_mode ? MODE_COUNT : 1); mode++) {
                bool together = which == NRD_DENOISER_COUNT;
                if (mode & ~allowed_modes(features) || features & FEATURES_OF_CODE || is_tedious(features)) continue;
                spy s = { 0 };
                nrd *instance = NULL;
                nrd_desc desc = spied_desc(&s, together ? all : all + which, together ? NRD_DENOISER_COUNT + 1 : 1, 100, 52, features);
                assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
                check(instance, features, mode);
                nrd_destroy(instance);
                assert_int_equal(s.messages, 0);
                assert_int_equal(s.allocations, 1);
                assert_int_equal(s.releases, 1);
            }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Resources  >>resources */
static bool same_resource(const nrd_binding *a, const nrd_binding *b)
{
    return a->resource == b->resource && (a->resource != NRD_RESOURCE_INTERNAL || a->texture == b->texture);
}

static bool is_output(nrd_resource resource) { return resource != NRD_RESOURCE_INTERNAL && nrd_resource_format(resource) != NRD_FORMAT_ANY; }

static void check_no_read_before_write(nrd *instance, uint32_t features, uint32_t mode)
{
    const nrd_info *info = nrd_get_info(instance);
    (void)features;
    for (uint32_t frame = 0; frame < 3; frame++) {
        run r = run_mode(instance, frame, mode);
        bool written[MAX_TEXTURES] = { false }, out_written[NRD_RESOURCE_COUNT] = { false };
        assert_true(info->texture_count <= MAX_TEXTURES);
        for (uint32_t d = 0; d < r.count; d++) {
            for (uint32_t b = 0; b < r.dispatches[d].binding_count; b++) {
                const nrd_binding *use = &r.dispatches[d].bindings[b];
                if (use->access == NRD_ACCESS_WRITE) continue;
                if (is_output(use->resource)) assert_true(out_written[use->resource]);
                if (use->resource == NRD_RESOURCE_INTERNAL && !info->textures[use->texture].permanent) assert_true(written[use->texture]);
            }
            for (uint32_t b = 0; b < r.dispatches[d].binding_count; b++) {
                const nrd_binding *use = &r.dispatches[d].bindings[b];
                if (use->access != NRD_ACCESS_WRITE) continue;
                if (use->resource == NRD_RESOURCE_INTERNAL) written[use->texture] = true;
                else out_written[use->resource] = true;
            }
        }
    }
}

static void nothing_is_read_before_it_is_written(void **state)
{
    (void)state;
    for_every_instance(check_no_read_before_write, true);
}

static void check_outputs_and_inputs(nrd *instance, uint32_t features, uint32_t mode)
{
    run r = run_mode(instance, 0, mode);
    bool written[NRD_RESOURCE_COUNT] = { false };
    (void)features;
    for (uint32_t d = 0; d < r.count; d++)
        for (uint32_t b = 0; b < r.dispatches[d].binding_count; b++) {
            const nrd_binding *use = &r.dispatches[d].bindings[b];
            if (use->resource == NRD_RESOURCE_INTERNAL) continue;
            assert_true(nrd_uses_resource(instance, use->resource));
            if (use->access != NRD_ACCESS_WRITE) continue;
            assert_true(is_output(use->resource));
            written[use->resource] = true;
        }
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++)
        assert_int_equal(written[i], is_output((nrd_resource)i) && nrd_uses_resource(instance, (nrd_resource)i));
}

static void every_output_is_written_and_no_input_is(void **state)
{
    (void)state;
    for_every_instance(check_outputs_and_inputs, true);
}

static void check_every_used_resource_is_bound(nrd *instance, uint32_t features, uint32_t mode)
{
    bool bound[NRD_RESOURCE_COUNT] = { false };
    (void)mode;
    for (uint32_t m = 0, frame = 0; m < MODE_COUNT; m++) {
        if (m & ~allowed_modes(features)) continue;
        run r = run_mode(instance, frame++, m);
        for (uint32_t d = 0; d < r.count; d++)
            for (uint32_t b = 0; b < r.dispatches[d].binding_count; b++)
                if (r.dispatches[d].bindings[b].resource != NRD_RESOURCE_INTERNAL) bound[r.dispatches[d].bindings[b].resource] = true;
    }
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) assert_int_equal(bound[i], nrd_uses_resource(instance, (nrd_resource)i));
}

static void nrd_uses_resource_names_what_is_bound_in_some_frame(void **state)
{
    (void)state;
    for_every_instance(check_every_used_resource_is_bound, false);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Ping-pong  >>pingpong */
/* Of the frame before, nothing but zeros is left in them. */
static bool is_cleared_ahead(const nrd_texture *t) { return t->read_back || t->buffer; }

/* Two textures of one denoiser with the same name are the halves of a pair. */
static bool is_pair(const nrd_info *info, uint32_t texture)
{
    return !is_cleared_ahead(&info->textures[texture]) && texture + 1 < info->texture_count && info->textures[texture].denoiser == info->textures[texture + 1].denoiser
        && strcmp(info->textures[texture].name, info->textures[texture + 1].name) == 0;
}

typedef struct half_use { bool used, read_first; uint32_t writes; } half_use;

static half_use uses_of(const run *r, uint32_t texture)
{
    half_use use = { false, false, 0 };
    nrd_binding wanted = { NRD_RESOURCE_INTERNAL, texture, NRD_ACCESS_READ, false, false };
    for (uint32_t d = 0; d < r->count; d++)
        for (uint32_t b = 0; b < r->dispatches[d].binding_count; b++) {
            const nrd_binding *binding = &r->dispatches[d].bindings[b];
            if (!same_resource(binding, &wanted)) continue;
            if (!use.used) use.read_first = binding->access != NRD_ACCESS_WRITE;
            use.used = true;
            use.writes += binding->access == NRD_ACCESS_WRITE;
        }
    return use;
}

/* One half is last frame's: read before anything overwrites it. The other is this frame's: written once, first, and kept for the
   next frame, in which the two change places. */
static void check_ping_pong(nrd *instance, uint32_t features, uint32_t mode)
{
    const nrd_info *info = nrd_get_info(instance);
    (void)features;
    for (uint32_t t = 0; t < info->texture_count; t++) {
        if (!is_pair(info, t)) continue;
        for (uint32_t frame = 0, history = 0; frame < 4; frame++, history ^= 1) {
            run r = run_mode(instance, frame, mode);
            half_use halves[2] = { uses_of(&r, t), uses_of(&r, t + 1) };
            assert_true(halves[0].used && halves[1].used);
            assert_true(halves[0].read_first != halves[1].read_first);
            if (frame == 0) history = halves[1].read_first;
            assert_true(halves[history].read_first);
            assert_int_equal(halves[history ^ 1].writes, 1);
        }
        run_mode(instance, 9, mode);
    }
}

static void check_ping_pong_silently(nrd *instance, uint32_t features, uint32_t mode)
{
    spy *s = (spy *)instance->desc.message_user;
    check_ping_pong(instance, features, mode);
    assert_int_equal(s->errors, 0);
    forget_messages(s);   /* frame_index starts again for every pair, which is worth a warning */
}

static void ping_pong_halves_alternate_and_are_overwritten_only_after_they_were_read(void **state)
{
    (void)state;
    for_every_instance(check_ping_pong_silently, true);
}

/* Each frame counts in a half that the one before has cleared: bound second there, first here. */
static void counters_are_cleared_one_frame_ahead(void **state)
{
    spy s;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        nrd *instance = create_one(&s, (nrd_denoiser)i, 64, 48, NRD_FEATURE_CHECK);
        const nrd_info *info = nrd_get_info(instance);
        uint32_t cleared = UINT32_MAX;
        for (uint32_t frame = 0; frame < 4; frame++) {
            run r = run_mode(instance, frame, 0);
            const nrd_dispatch *last = &r.dispatches[r.count - 1];
            if (i == NRD_DENOISER_REFERENCE) { assert_string_not_equal(last->name, "input check"); continue; }
            const nrd_binding *counted = &last->bindings[last->binding_count - 2], *next = counted + 1;
            assert_string_equal(last->name, "input check");
            assert_true(info->textures[counted->texture].read_back && info->textures[next->texture].read_back);
            assert_int_equal(info->textures[counted->texture].width * info->textures[counted->texture].height, NRD_COUNTER_COUNT);
            if (frame > 0) assert_int_equal(counted->texture, cleared);
            assert_true(next->texture != counted->texture);
            cleared = next->texture;
        }
        nrd_destroy(instance);
    }
}

/* Passes that bind the list of tiles have as many groups as this frame has counted, where the one before has cleared. */
static void passes_on_listed_tiles_have_the_number_of_groups_of_their_frame(void **state)
{
    spy s;
    (void)state;
    for (int i = NRD_DENOISER_REBLUR_DIFFUSE; i <= NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION; i++) {
        nrd *instance = create_one(&s, (nrd_denoiser)i, 64, 48, NRD_FEATURE_ALL);
        const nrd_info *info = nrd_get_info(instance);
        uint32_t cleared = UINT32_MAX;
        for (uint32_t frame = 0; frame < 4; frame++) {
            run r = run_mode(instance, frame, MODE_PREPASS);
            const nrd_binding *list = &r.dispatches[0].bindings[2], *groups = list + 1;
            uint32_t listed = 0;
            assert_string_equal(r.dispatches[0].name, "tiles");
            assert_true(info->textures[groups->texture].buffer && info->textures[groups->texture].bytes >= 12 && !r.dispatches[0].indirect);
            if (frame > 0) assert_int_equal(groups->texture, cleared);
            for (uint32_t d = 1; d < r.count; d++) {
                const nrd_dispatch *at = &r.dispatches[d];
                bool lists = same_resource(&at->bindings[at->binding_count - 2], list), any_tile = strncmp(at->name, "lighting change", 15) == 0;
                if (lists) assert_true(same_resource(&at->bindings[at->binding_count - 1], groups) && at->bindings[at->binding_count - 1].access == NRD_ACCESS_UNIFORM);
                assert_int_equal(at->indirect, lists || any_tile ? 1 + groups->texture : 0);
                assert_int_equal(at->indirect_offset, any_tile ? 16 : 0);
                assert_true(at->indirect_offset + 12 <= info->textures[groups->texture].bytes);
                listed += lists;
            }
            assert_true(listed >= (nrdi_row_of((nrd_denoiser)i)->family == NRDI_FAMILY_OCCLUSION ? 2u : 3u));
            cleared = groups[1].texture;
        }
        nrd_destroy(instance);
    }
}

/* In the steady state every read finds what the same pass wrote the same number of frames ago. */
typedef struct origin { uint32_t pass, frame; } origin;

static uint32_t origins_of_frame(nrd *instance, uint32_t frame, uint32_t mode, origin *last_write, origin *found)
{
    run r = run_mode(instance, frame, mode);
    uint32_t count = 0;
    for (uint32_t d = 0; d < r.count; d++) {
        for (uint32_t b = 0; b < r.dispatches[d].binding_count; b++) {
            const nrd_binding *use = &r.dispatches[d].bindings[b];
            if (use->resource != NRD_RESOURCE_INTERNAL || use->access == NRD_ACCESS_WRITE) continue;
            found[count].pass = last_write[use->texture].pass;
            found[count++].frame = frame - last_write[use->texture].frame;
        }
        for (uint32_t b = 0; b < r.dispatches[d].binding_count; b++) {
            const nrd_binding *use = &r.dispatches[d].bindings[b];
            origin now = { r.dispatches[d].pass, frame };
            if (use->resource == NRD_RESOURCE_INTERNAL && use->access == NRD_ACCESS_WRITE) last_write[use->texture] = now;
        }
    }
    return count;
}

static void check_steady_flow(nrd *instance, uint32_t features, uint32_t mode)
{
    origin last_write[MAX_TEXTURES], found[2][512];
    uint32_t counts[2] = { 0, 0 };
    (void)features;
    memset(last_write, 0xff, sizeof last_write);
    memset(found, 0, sizeof found);
    for (uint32_t frame = 0; frame < 6; frame++) {
        counts[frame & 1] = origins_of_frame(instance, frame, mode, last_write, found[frame & 1]);
        if (frame < 3) continue;
        assert_int_equal(counts[0], counts[1]);
        for (uint32_t i = 0; i < counts[0]; i++) {
            bool never_written = found[0][i].pass == UINT32_MAX && found[1][i].pass == UINT32_MAX;
            assert_int_equal(found[0][i].pass, found[1][i].pass);
            if (never_written) continue;
            assert_int_equal(found[0][i].frame, found[1][i].frame);
            assert_true(found[0][i].frame <= 1);
        }
    }
}

static void every_read_finds_what_the_same_pass_wrote_in_this_frame_or_the_last(void **state)
{
    (void)state;
    for_every_instance(check_steady_flow, true);
}

static void check_no_filtered_read_of_what_is_written(nrd *instance, uint32_t features, uint32_t mode)
{
    run r = run_mode(instance, 0, mode);
    (void)features;
    for (uint32_t d = 0; d < r.count; d++)
        for (uint32_t a = 0; a < r.dispatches[d].binding_count; a++)
            for (uint32_t b = 0; b < r.dispatches[d].binding_count; b++) {
                const nrd_binding *one = &r.dispatches[d].bindings[a], *other = &r.dispatches[d].bindings[b];
                if (a == b || one->access != NRD_ACCESS_WRITE || !same_resource(one, other)) continue;
                assert_int_equal(other->access, NRD_ACCESS_READ);   /* its own texel, at most */
            }
}

static void no_dispatch_filters_or_writes_twice_what_it_writes(void **state)
{
    (void)state;
    for_every_instance(check_no_filtered_read_of_what_is_written, true);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Memory  >>memory */
static void check_lifetimes(nrd *instance, uint32_t features, uint32_t mode)
{
    const nrd_info *info = nrd_get_info(instance);
    uint32_t first[MAX_TEXTURES], last[MAX_TEXTURES];
    (void)mode;
    for (uint32_t t = 0; t < info->texture_count; t++) first[t] = UINT32_MAX, last[t] = 0;
    for (uint32_t m = 0, frame = 0; m < MODE_COUNT; m++) {
        if (m & ~allowed_modes(features)) continue;
        run r = run_mode(instance, frame++, m);
        for (uint32_t d = 0; d < r.count; d++)
            for (uint32_t b = 0; b < r.dispatches[d].binding_count; b++) {
                const nrd_binding *use = &r.dispatches[d].bindings[b];
                if (use->resource != NRD_RESOURCE_INTERNAL) continue;
                if (r.dispatches[d].pass < first[use->texture]) first[use->texture] = r.dispatches[d].pass;
                if (r.dispatches[d].pass > last[use->texture]) last[use->texture] = r.dispatches[d].pass;
            }
    }
    for (uint32_t t = 0; t < info->texture_count; t++) {
        if (info->textures[t].permanent) { assert_true(first[t] != UINT32_MAX); continue; }
        assert_int_equal(first[t], info->textures[t].first_pass);
        assert_int_equal(last[t], info->textures[t].last_pass);
    }
}

static void transient_lifetimes_match_the_dispatches_and_no_texture_is_unused(void **state)
{
    (void)state;
    for_every_instance(check_lifetimes, false);
}

static void check_memory(nrd *instance, uint32_t features, uint32_t mode)
{
    const nrd_info *info = nrd_get_info(instance);
    uint64_t permanent = 0, unshared = 0, end = 0;
    (void)features;
    (void)mode;
    for (uint32_t i = 0; i < info->texture_count; i++) {
        const nrd_texture *t = &info->textures[i];
        assert_int_equal(t->bytes, (uint64_t)t->width * t->height * nrd_format_bytes(t->format));
        assert_true(t->bytes > 0 && t->denoiser < info->denoiser_count);
        if (t->permanent) { permanent += t->bytes; continue; }
        unshared += t->bytes;
        if (t->offset + t->bytes > end) end = t->offset + t->bytes;
        for (uint32_t k = 0; k < i; k++) {
            const nrd_texture *other = &info->textures[k];
            bool meet = !other->permanent && t->first_pass <= other->last_pass && other->first_pass <= t->last_pass;
            assert_false(meet && t->offset < other->offset + other->bytes && other->offset < t->offset + t->bytes);
        }
    }
    assert_int_equal(info->permanent_bytes, permanent);
    assert_int_equal(info->transient_unshared_bytes, unshared);
    assert_int_equal(info->transient_bytes, end);
    assert_true(end <= unshared + 256 * (uint64_t)info->texture_count);
}

static void memory_totals_are_the_sums_of_the_textures(void **state)
{
    (void)state;
    for_every_instance(check_memory, false);
}

/* Bytes of permanent and transient textures at 1920 x 1080. REBLUR: three quarters of what comparable denoisers take.
   REFERENCE: one RGBA32F image. SIGMA: 60 % of what comparable denoisers take. */
static const uint64_t budgets[NRD_DENOISER_COUNT] = {
    [NRD_DENOISER_REFERENCE] = 33177600,
    [NRD_DENOISER_REBLUR_DIFFUSE] = 55993320,
    [NRD_DENOISER_REBLUR_SPECULAR] = 71475000,
    [NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR] = 108870120,
    [NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION] = 26444520,
    [NRD_DENOISER_REBLUR_SPECULAR_OCCLUSION] = 35074867,
    [NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_OCCLUSION] = 46713651,
    [NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION] = 56544461,
    [NRD_DENOISER_REBLUR_DIFFUSE_SH] = 80876520,
    [NRD_DENOISER_REBLUR_SPECULAR_SH] = 94873320,
    [NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_SH] = 171078120,
    [NRD_DENOISER_SIGMA_SHADOW] = 19140000,
    [NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY] = 30480000,
};

static void memory_at_1080p_stays_within_the_budget_of_each_denoiser(void **state)
{
    spy s;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++)
        for (uint32_t features = 0; features <= NRD_FEATURE_ALL; features++) {
            nrd *instance = create_one(&s, (nrd_denoiser)i, 1920, 1080, features);
            const nrd_info *info = nrd_get_info(instance);
            assert_true(budgets[i] > 0);
            uint64_t hit_distances = features & NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION ? 2 * 2 * 1920 * 1080 : 0;   /* two bytes a pixel and signal */
            assert_in_range(info->permanent_bytes + info->transient_bytes, 1, budgets[i] + hit_distances);
            nrd_destroy(instance);
        }
}

static void two_denoisers_share_their_transient_memory(void **state)
{
    spy s = { 0 };
    nrd *one = NULL, *two = NULL;
    nrd_denoiser_desc list[] = { { 0, NRD_DENOISER_REBLUR_DIFFUSE }, { 1, NRD_DENOISER_REBLUR_DIFFUSE } };
    nrd_desc desc = spied_desc(&s, list, 1, 640, 480, NRD_FEATURE_ALL);
    (void)state;
    assert_int_equal(nrd_create(&desc, &one), NRD_RESULT_OK);
    desc.denoiser_count = 2;
    assert_int_equal(nrd_create(&desc, &two), NRD_RESULT_OK);
    assert_int_equal(nrd_get_info(two)->transient_bytes, nrd_get_info(one)->transient_bytes);
    assert_int_equal(nrd_get_info(two)->permanent_bytes, 2 * nrd_get_info(one)->permanent_bytes);
    assert_int_equal(nrd_get_info(two)->pipeline_count, nrd_get_info(one)->pipeline_count);
    nrd_destroy(one);
    nrd_destroy(two);
}

static void memory_is_taken_once_at_creation_and_given_back_at_the_end(void **state)
{
    spy s;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        nrd *instance = create_one(&s, (nrd_denoiser)i, 64, 48, NRD_FEATURE_ALL);
        for (uint32_t frame = 0; frame < 8; frame++) run_mode(instance, frame, frame % 2 ? MODE_COUNT - 1 : 0);
        assert_int_equal(s.allocations, 1);
        assert_int_equal(s.releases, 0);
        nrd_destroy(instance);
        assert_int_equal(s.releases, 1);
    }
    nrd_destroy(NULL);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   nrd_place_blocks  >>placement */
enum { MAX_BLOCKS = 24, INSTANTS = 12 };

static uint32_t random_blocks(uint32_t seed, nrd_block *blocks)
{
    uint32_t count = (uint32_t)(random_at(seed, 0, 0) * (MAX_BLOCKS + 1));
    for (uint32_t i = 0; i < count; i++) {
        uint32_t from = (uint32_t)(random_at(seed, i, 1) * INSTANTS), length = (uint32_t)(random_at(seed, i, 2) * (INSTANTS - from));
        blocks[i].bytes = (uint64_t)(pow(2, random_at(seed, i, 3) * 34));   /* beyond 4 GiB too */
        blocks[i].alignment = (uint64_t)1 << (uint32_t)(random_at(seed, i, 4) * 17);
        if (random_at(seed, i, 5) < 0.1) blocks[i].alignment = 0;           /* 0: any */
        if (random_at(seed, i, 6) < 0.05) blocks[i].bytes = 0;
        blocks[i].first = from;
        blocks[i].last = from + length;
        blocks[i].offset = 12345;
    }
    return count;
}

static bool holds(const nrd_block *b, uint32_t instant) { return b->first <= instant && instant <= b->last; }

static void blocks_with_a_common_time_never_overlap(void **state)
{
    nrd_block blocks[MAX_BLOCKS];
    (void)state;
    for (uint32_t seed = 0; seed < 3000; seed++) {
        uint32_t count = random_blocks(seed, blocks);
        uint64_t total = nrd_place_blocks(blocks, count), end = 0, most = 0, sum = 0;
        for (uint32_t instant = 0; instant < INSTANTS; instant++) {
            uint64_t live = 0;
            for (uint32_t a = 0; a < count; a++) {
                if (!holds(&blocks[a], instant)) continue;
                live += blocks[a].bytes;
                for (uint32_t b = 0; b < a; b++)
                    if (holds(&blocks[b], instant))
                        assert_true(blocks[a].offset + blocks[a].bytes <= blocks[b].offset || blocks[b].offset + blocks[b].bytes <= blocks[a].offset);
            }
            if (live > most) most = live;
        }
        for (uint32_t i = 0; i < count; i++) {
            uint64_t alignment = blocks[i].alignment ? blocks[i].alignment : 1;
            assert_int_equal(blocks[i].offset % alignment, 0);
            sum += blocks[i].bytes + alignment;
            if (blocks[i].offset + blocks[i].bytes > end) end = blocks[i].offset + blocks[i].bytes;
        }
        assert_int_equal(total, end);
        assert_true(total >= most && total <= sum);
    }
}

static void blocks_that_never_meet_lie_on_top_of_each_other(void **state)
{
    nrd_block blocks[] = { { 100, 16, 0, 1, 0 }, { 300, 16, 2, 3, 0 }, { 200, 16, 4, 9, 0 }, { 50, 64, 3, 4, 0 } };
    (void)state;
    assert_int_equal(nrd_place_blocks(blocks, 3), 300);
    for (int i = 0; i < 3; i++) assert_int_equal(blocks[i].offset, 0);
    assert_int_equal(nrd_place_blocks(blocks, 4), 370);
    assert_int_equal(blocks[3].offset, 320);
    assert_int_equal(nrd_place_blocks(NULL, 0), 0);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   What is left out  >>leftout */
static bool has_pass(const nrd_info *info, const char *name)
{
    for (uint32_t i = 0; i < info->pass_count; i++) if (strcmp(info->passes[i].name, name) == 0) return true;
    return false;
}

static const nrd_left_out *left_out(const nrd_info *info, const char *name)
{
    for (uint32_t i = 0; i < info->left_out_count; i++) if (strcmp(info->left_out[i].what, name) == 0) return &info->left_out[i];
    return NULL;
}

static void features_that_are_not_declared_leave_their_passes_out_and_say_so(void **state)
{
    spy s, t;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        nrd *full = create_one(&s, (nrd_denoiser)i, 64, 48, NRD_FEATURE_ALL);
        const nrd_info *all = nrd_get_info(full);
        for (uint32_t features = 0; features <= NRD_FEATURE_ALL; features++) {
            nrd *instance = create_one(&t, (nrd_denoiser)i, 64, 48, features);
            const nrd_info *info = nrd_get_info(instance);
            assert_int_equal(info->pass_count + info->left_out_count, all->pass_count + all->left_out_count);
            for (uint32_t p = 0; p < all->pass_count; p++) {
                const nrd_left_out *out = left_out(info, all->passes[p].name);
                assert_true(has_pass(info, all->passes[p].name) == (out == NULL));
                if (out) assert_true(strstr(out->why, "nrd_desc.features") != NULL);
            }
            assert_true(info->permanent_bytes + info->transient_unshared_bytes <= all->permanent_bytes + all->transient_unshared_bytes);
            nrd_destroy(instance);
        }
        nrd_destroy(full);
    }
}

static void the_prepass_and_the_split_screen_exist_only_when_declared(void **state)
{
    static const struct { uint32_t feature; const char *pass; } rows[] = { { NRD_FEATURE_PREPASS, "pre-pass" }, { NRD_FEATURE_SPLIT_SCREEN, "split screen" } };
    spy s;
    (void)state;
    for (uint32_t features = 0; features <= NRD_FEATURE_ALL; features++) {
        nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, features);
        for (int i = 0; i < 2; i++) assert_int_equal(has_pass(nrd_get_info(instance), rows[i].pass), (features & rows[i].feature) != 0);
        nrd_destroy(instance);
    }
}

static bool runs_pass(const run *r, uint32_t pass)
{
    for (uint32_t d = 0; d < r->count; d++) if (r->dispatches[d].pass == pass) return true;
    return false;
}

/* Passes of the defaults that a mode leaves out; asserts that it adds none. */
static uint32_t dropped_by(nrd *instance, uint32_t frame_index, uint32_t mode)
{
    bool before[128];
    uint32_t dropped = 0, passes = nrd_get_info(instance)->pass_count;
    run r = run_mode(instance, frame_index, 0);
    for (uint32_t p = 0; p < passes; p++) before[p] = runs_pass(&r, p);
    r = run_mode(instance, frame_index + 1, mode);
    for (uint32_t p = 0; p < passes; p++) {
        assert_true(before[p] || !runs_pass(&r, p));
        dropped += before[p] && !runs_pass(&r, p);
    }
    return dropped;
}

static void settings_of_zero_drop_their_passes(void **state)
{
    static const struct { const char *setting; uint32_t mode; } rows[] = { { "max_blur_radius", MODE_NO_BLUR }, { "antilag_sensitivity", MODE_NO_ANTILAG } };
    spy s;
    nrd_setting setting;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        nrd *instance = create_one(&s, (nrd_denoiser)i, 64, 48, NRD_FEATURE_ALL);
        for (uint32_t k = 0; k < 2; k++) {
            bool has = find_setting((nrd_denoiser)i, rows[k].setting, &setting);
            bool kept = rows[k].mode == MODE_NO_BLUR && nrdi_row_of((nrd_denoiser)i)->family == NRDI_FAMILY_OCCLUSION;   /* its blur writes the output */
            assert_int_equal(dropped_by(instance, 2 * k, rows[k].mode) > 0, has && !kept);
        }
        run r = run_mode(instance, 4, MODE_NO_BLUR);
        for (uint32_t d = 0; d < r.count; d++) assert_int_equal(r.dispatches[d].push[0], 0);
        nrd_destroy(instance);
    }
}

static void dispatches_come_in_the_order_of_the_passes_and_never_exceed_them(void **state)
{
    spy s;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        nrd *instance = create_one(&s, (nrd_denoiser)i, 64, 48, NRD_FEATURE_ALL);
        const nrd_info *info = nrd_get_info(instance);
        for (uint32_t mode = 0; mode < MODE_COUNT; mode++) {
            run r = run_mode(instance, mode, mode);
            for (uint32_t d = 0; d < r.count; d++) {
                const nrd_dispatch *at = &r.dispatches[d];
                assert_true(at->pass < info->pass_count && (d == 0 || at->pass > at[-1].pass));
                assert_int_equal(at->pipeline, info->passes[at->pass].pipeline);
                assert_string_equal(at->name, info->passes[at->pass].name);
                assert_int_equal(at->binding_count, info->pipelines[at->pipeline].binding_count);
                for (uint32_t b = 0; b < at->binding_count; b++) assert_int_equal(at->bindings[b].access, info->pipelines[at->pipeline].access[b]);
            }
        }
        nrd_destroy(instance);
    }
}

static void a_full_split_screen_runs_nothing_but_the_split(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, NRD_FEATURE_ALL);
    run_mode(instance, 0, 0);
    nrd_frame frame = still_frame(1);
    frame.split_screen = 1;
    run r = run_frame(instance, &frame);
    assert_int_equal(r.count, 1);
    assert_string_equal(r.dispatches[0].name, "split screen");
    r = run_mode(instance, 2, 0);   /* what was not accumulated cannot be used */
    assert_int_equal(((const nrd_constants *)r.dispatches[0].constants)->reset, 1);
    nrd_destroy(instance);
}

static void dispatches_of_one_denoiser_leave_the_others_alone(void **state)
{
    static const nrd_denoiser_desc list[] = { { 5, NRD_DENOISER_REBLUR_DIFFUSE }, { 3, NRD_DENOISER_REFERENCE } };
    spy s = { 0 };
    nrd *instance = NULL;
    nrd_desc desc = spied_desc(&s, list, 2, 64, 48, 0);
    const nrd_dispatch *dispatches = NULL;
    const uint32_t only = 3, wrong[] = { 5, 4 };
    uint32_t count = 99;
    (void)state;
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    nrd_frame frame = still_frame(0);
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
    assert_int_equal(nrd_get_dispatches(instance, &only, 1, &dispatches, &count), NRD_RESULT_OK);
    assert_true(count > 0);
    for (uint32_t d = 0; d < count; d++) assert_int_equal(nrd_get_info(instance)->passes[dispatches[d].pass].denoiser, 1);
    assert_int_equal(nrd_get_dispatches(instance, wrong, 2, &dispatches, &count), NRD_RESULT_UNKNOWN_DENOISER);
    frame = still_frame(1);
    run r = run_frame(instance, &frame);
    for (uint32_t d = 0; d < r.count; d++) {
        const nrd_constants *c = (const nrd_constants *)r.dispatches[d].constants;
        assert_int_equal(c->reset, nrd_get_info(instance)->passes[r.dispatches[d].pass].denoiser == 0);   /* the one that missed a frame */
    }
    nrd_destroy(instance);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Grids  >>grids */
/* A pass that writes nothing finer than every n-th pixel has one thread for n x n of them. */
static uint32_t pixels_per_thread(const nrd_info *info, const nrd_dispatch *d)
{
    uint32_t least = UINT32_MAX;
    if (!strcmp(d->name, "shadow rays")) return 2;   /* a group has 2 x 2 tiles */
    for (uint32_t b = 0; b < d->binding_count; b++) {
        if (d->bindings[b].access != NRD_ACCESS_WRITE) continue;
        bool internal = d->bindings[b].resource == NRD_RESOURCE_INTERNAL;
        if (internal && info->textures[d->bindings[b].texture].read_back) return 1;   /* counts every pixel */
        uint32_t width = internal ? info->textures[d->bindings[b].texture].width : info->width, n = (info->width + width - 1) / width;
        if (n < least) least = n;
    }
    return least;
}

static void grids_cover_the_rectangle_and_not_a_group_more(void **state)
{
    static const uint32_t rects[][2] = { { 1, 1 }, { 8, 8 }, { 9, 7 }, { 64, 64 }, { 65, 63 }, { 200, 150 }, { 256, 256 }, { 0, 0 } };
    spy s;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        nrd *instance = create_one(&s, (nrd_denoiser)i, 256, 256, NRD_FEATURE_ALL);
        for (uint32_t k = 0; k < sizeof rects / sizeof rects[0]; k++) {
            nrd_frame frame = still_frame(k);
            frame.rect_width = rects[k][0];
            frame.rect_height = rects[k][1];
            frame.split_screen = 0.5f;
            run r = run_frame(instance, &frame);
            uint32_t width = rects[k][0] ? rects[k][0] : 256, height = rects[k][1] ? rects[k][1] : 256;
            for (uint32_t d = 0; d < r.count; d++) {
                uint32_t px = 8 * pixels_per_thread(nrd_get_info(instance), &r.dispatches[d]);
                assert_int_equal(r.dispatches[d].groups_x, (width + px - 1) / px);
                assert_int_equal(r.dispatches[d].groups_y, (height + px - 1) / px);
            }
        }
        nrd_destroy(instance);
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Frames  >>frames */
static nrd_frame moved_frame(uint32_t frame_index, double x)
{
    nrd_frame frame = nrd_frame_defaults();
    pose p = pose_at(x, 0.5 * x, -x);
    p.yaw = 0.1 * x;
    frame.camera = pose_camera(&p);
    frame.frame_index = frame_index;
    return frame;
}

static nrd_constants constants_of(nrd *instance)
{
    nrd_constants c;
    run r = { NULL, 0 };
    assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &r.dispatches, &r.count), NRD_RESULT_OK);
    assert_true(r.count > 0);
    memcpy(&c, r.dispatches[0].constants, sizeof c);
    return c;
}

static void set_frame(nrd *instance, const nrd_frame *frame) { assert_int_equal(nrd_set_frame(instance, frame), NRD_RESULT_OK); }

/* What the denoiser would see if the first of the frames with index 1 had never been set. */
static void assert_replaced(const nrd_frame *wrong)
{
    spy s, t;
    nrd *replaced = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, NRD_FEATURE_ALL), *direct = create_one(&t, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, NRD_FEATURE_ALL);
    nrd_frame frame = moved_frame(0, 1);
    set_frame(replaced, &frame);
    set_frame(direct, &frame);
    constants_of(replaced);
    constants_of(direct);
    frame = moved_frame(1, 3);
    set_frame(replaced, wrong);
    set_frame(replaced, &frame);
    set_frame(direct, &frame);
    nrd_constants a = constants_of(replaced), b = constants_of(direct);
    assert_memory_equal(&a, &b, sizeof a);
    nrd_destroy(replaced);
    nrd_destroy(direct);
}

static void the_same_frame_index_twice_replaces_the_frame(void **state)
{
    nrd_frame wrong = moved_frame(1, 2);
    (void)state;
    assert_replaced(&wrong);
    wrong.rect_width = 32;
    wrong.denoising_range = 50;
    wrong.motion_mode = NRD_MOTION_2D;
    assert_replaced(&wrong);
}

static void a_replaced_frame_takes_its_previous_camera_with_it(void **state)
{
    nrd_frame wrong = moved_frame(1, 2), elsewhere = moved_frame(0, 9);
    (void)state;
    wrong.camera_prev = &elsewhere.camera;
    assert_replaced(&wrong);
}

static void a_replaced_frame_takes_its_restart_with_it(void **state)
{
    nrd_frame wrong = moved_frame(1, 2);
    (void)state;
    wrong.restart = 1;
    assert_replaced(&wrong);
}

static void a_skipped_frame_index_warns_once_and_restarts_history(void **state)
{
    spy s;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        nrd *instance = create_one(&s, (nrd_denoiser)i, 64, 48, 0);
        static const struct { uint32_t index; bool restarts; } frames[] = { { 5, true }, { 6, false }, { 8, true }, { 9, false }, { 3, true }, { 4, false } };
        for (uint32_t k = 0; k < sizeof frames / sizeof frames[0]; k++) {
            nrd_frame frame = still_frame(frames[k].index);
            forget_messages(&s);
            set_frame(instance, &frame);
            assert_int_equal(constants_of(instance).reset, frames[k].restarts);
            assert_int_equal(s.messages, k > 0 && frames[k].restarts);
            assert_int_equal(s.errors, 0);
            if (s.messages) assert_true(strstr(s.text, "frame_index") != NULL);
        }
        nrd_destroy(instance);
    }
}

static void the_frame_index_may_wrap_around(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0);
    for (uint32_t k = 0, index = UINT32_MAX - 1; k < 4; k++, index++) {
        nrd_frame frame = still_frame(index);
        set_frame(instance, &frame);
        assert_int_equal(constants_of(instance).reset, k == 0);
    }
    assert_int_equal(s.messages, 0);
    nrd_destroy(instance);
}

static void restart_forgets_the_history_and_the_previous_camera_without_a_message(void **state)
{
    spy s, t;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0), *fresh = create_one(&t, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0);
    nrd_frame frame = moved_frame(0, 1);
    set_frame(instance, &frame);
    assert_int_equal(constants_of(instance).reset, 1);
    frame = moved_frame(7, 2);
    frame.restart = 1;
    set_frame(instance, &frame);
    set_frame(fresh, &frame);
    nrd_constants a = constants_of(instance), b = constants_of(fresh);
    assert_int_equal(a.reset, 1);
    assert_memory_equal(&a, &b, sizeof a);
    assert_int_equal(s.messages, 0);
    nrd_destroy(instance);
    nrd_destroy(fresh);
}

static void the_previous_camera_and_rectangle_are_remembered_or_overridden(void **state)
{
    spy s, t, u;
    (void)state;
    nrd *remembers = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0), *told = create_one(&t, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0);
    nrd *other = create_one(&u, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0);
    nrd_frame first = moved_frame(0, 1), unrelated = moved_frame(0, 5), second = moved_frame(1, 2);
    first.rect_width = unrelated.rect_width = 40;
    first.denoising_range = unrelated.denoising_range = 77;
    set_frame(remembers, &first);
    set_frame(told, &unrelated);
    set_frame(other, &unrelated);
    constants_of(remembers);
    constants_of(told);
    constants_of(other);
    set_frame(remembers, &second);
    set_frame(other, &second);
    nrd_camera camera = first.camera;
    second.camera_prev = &camera;
    set_frame(told, &second);
    memset(&camera, 0xff, sizeof camera);   /* was copied */
    nrd_constants a = constants_of(remembers), b = constants_of(told), c = constants_of(other);
    assert_memory_equal(&a, &b, sizeof a);
    assert_memory_not_equal(&a, &c, sizeof a);
    assert_int_equal(a.rect_width_prev, 40);
    assert_int_equal(a.rect_width, 64);
    assert_float_equal(a.denoising_range_prev, 77, 0);
    nrd_destroy(remembers);
    nrd_destroy(told);
    nrd_destroy(other);
}

static void reference_counts_its_frames_and_restarts_when_the_camera_moves(void **state)
{
    spy s;
    nrd_reference_settings settings = nrd_reference_defaults();
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REFERENCE, 64, 48, 0);
    settings.max_accumulated_frames = 3;
    assert_int_equal(nrd_set_settings(instance, 7, &settings), NRD_RESULT_OK);
    static const struct { double x; uint32_t frames; } rows[] = { { 0, 0 }, { 0, 1 }, { 0, 2 }, { 0, 3 }, { 0, 3 }, { 1, 0 }, { 1, 1 }, { 1.001, 0 } };
    for (uint32_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        nrd_frame frame = moved_frame(k, rows[k].x);
        set_frame(instance, &frame);
        assert_int_equal(constants_of(instance).history_frames, rows[k].frames);
    }
    nrd_destroy(instance);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Matrices  >>matrices */
enum { POSES = 400 };

static pose random_pose(uint32_t seed, uint32_t which)
{
    pose p = pose_at(20 * random_at(seed, which, 0) - 10, 20 * random_at(seed, which, 1) - 10, 20 * random_at(seed, which, 2) - 10);
    p.yaw = 6.28 * random_at(seed, which, 3);
    p.pitch = 3 * random_at(seed, which, 4) - 1.5;
    p.roll = 6.28 * random_at(seed, which, 5);
    p.tan_half_height = 0.2 + random_at(seed, which, 6);
    p.aspect = 0.5 + 2 * random_at(seed, which, 7);
    p.shift[0] = 0.4 * random_at(seed, which, 8) - 0.2;
    p.shift[1] = 0.4 * random_at(seed, which, 9) - 0.2;
    p.jitter[0] = random_at(seed, which, 10) - 0.5;
    p.jitter[1] = random_at(seed, which, 11) - 0.5;
    p.orthographic = seed & 1;       /* shared by this frame and the last: */
    p.right_handed = seed & 2;
    p.reversed = seed & 4;
    p.clip_y_down = seed & 8;
    p.view_y_down = (seed & 16) && !p.clip_y_down;
    p.far = (seed & 32) && !p.orthographic ? 0 : 100;
    if (p.orthographic) p.tan_half_height *= 10;
    return p;
}

static void multiply(const float m[16], const double v[4], double out[3])
{
    for (int row = 0; row < 3; row++) {
        out[row] = 0;
        for (int k = 0; k < 4; k++) out[row] += (double)m[4 * k + row] * v[k];
    }
}

static void assert_near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance)) print_error("%.9g is not %.9g within %g\n", a, b, tolerance);
    assert_true(fabs(a - b) <= tolerance);
}

/* As geometry.glsl does it. */
static void view_position(const float frustum[4], bool orthographic, double u, double v, double depth, double out[4])
{
    out[0] = (frustum[0] + u * frustum[2]) * (orthographic ? 1 : depth);
    out[1] = (frustum[1] + v * frustum[3]) * (orthographic ? 1 : depth);
    out[2] = depth;
    out[3] = 1;
}

static void assert_point(const nrd_constants *c, const pose *now, const pose *prev, uint32_t seed)
{
    double u = random_at(seed, 50, 0), v = random_at(seed, 51, 0), depth = 0.5 + 30 * random_at(seed, 52, 0);
    double world[3], view[4], got[3], prev_u, prev_v, prev_depth, expected[4];
    double tolerance = 1e-5 * (30 + depth);
    pose_point(now, u, v, depth, world);
    view_position(c->frustum, now->orthographic, u, v, depth, view);
    double direction[4] = { view[0], view[1], view[2], 0 };
    multiply(c->view_to_world, direction, got);
    for (int k = 0; k < 3; k++) assert_near(got[k] + now->position[k], world[k], tolerance);

    pose_project(prev, world, &prev_u, &prev_v, &prev_depth);
    view_position(c->frustum_prev, prev->orthographic, prev_u, prev_v, prev_depth, expected);
    double relative[4] = { world[0] - now->position[0], world[1] - now->position[1], world[2] - now->position[2], 1 };
    multiply(c->world_to_view_prev, relative, got);
    for (int k = 0; k < 3; k++) assert_near(got[k], expected[k], tolerance);
    multiply(c->view_to_view_prev, view, got);
    for (int k = 0; k < 3; k++) assert_near(got[k], expected[k], tolerance);
}

static void constants_reconstruct_world_points_for_every_kind_of_camera(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 64, 48, 0);
    for (uint32_t seed = 0; seed < POSES; seed++) {
        pose prev = random_pose(seed, 100), now = random_pose(seed, 200);
        nrd_frame frame = nrd_frame_defaults();
        frame.frame_index = 2 * seed;
        frame.restart = 1;
        frame.camera = pose_camera(&prev);
        frame.clip_y = pose_clip_y(&prev);
        set_frame(instance, &frame);
        frame.frame_index++;
        frame.restart = 0;
        frame.camera = pose_camera(&now);
        set_frame(instance, &frame);
        nrd_constants c = constants_of(instance);
        assert_int_equal(c.orthographic > 0.5f, now.orthographic);
        assert_int_equal(c.orthographic_prev > 0.5f, prev.orthographic);
        assert_near(c.pixel_unproject, 2 * now.tan_half_height / 48, 1e-6 * now.tan_half_height);
        for (int k = 0; k < 2; k++) assert_near(c.jitter_delta[k], now.jitter[k] - prev.jitter[k], 1e-6);
        for (uint32_t point = 0; point < 8; point++) assert_point(&c, &now, &prev, 8 * seed + point);
    }
    assert_int_equal(s.messages, 0);
    nrd_destroy(instance);
}

static nrd_camera camera_at(float x)
{
    pose p = random_pose(1, 1);
    p.position[0] = x;
    return pose_camera(&p);
}

/* What a frame says of how far a lamp of radius 0.5 has moved, of its diameter. */
static float lamp_shift(nrd *instance, uint32_t index, float camera_x, float lamp_x, const nrd_camera *before)
{
    nrd_sigma_settings lamp = nrd_sigma_defaults();
    nrd_frame frame = nrd_frame_defaults();
    lamp.light_x = lamp_x;
    lamp.light_y = 2;
    lamp.light_is_local = 1;
    lamp.light_radius = 0.5f;
    assert_int_equal(nrd_set_settings(instance, nrd_get_info(instance)->denoisers[0].identifier, &lamp), NRD_RESULT_OK);
    frame.frame_index = index;
    frame.camera = camera_at(camera_x);
    frame.camera_prev = before;
    set_frame(instance, &frame);
    return constants_of(instance).jitter_delta[2];
}

static void a_light_moves_in_the_world_not_with_its_origin(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_SIGMA_SHADOW, 64, 48, 0);
    nrd_camera rebased = camera_at(-1);
    assert_true(lamp_shift(instance, 0, 0, 3, NULL) == 0);
    assert_true(lamp_shift(instance, 1, 0.2f, 3, NULL) == 0);
    assert_near(lamp_shift(instance, 2, 0.2f, 3.25, NULL), 0.25, 1e-6);
    nrd_cancel_dispatches(instance);
    assert_near(lamp_shift(instance, 2, 0.2f, 3.5, NULL), 0.5, 1e-6);
    assert_true(lamp_shift(instance, 3, 0.4f, 9, NULL) == 1);
    assert_near(lamp_shift(instance, 4, -1, 7.6, &rebased), 0, 1e-5);    /* the origin has moved to x = 1.4, the camera not at all */
    assert_near(lamp_shift(instance, 5, -1, 7.6, NULL), 0, 1e-6);
    assert_int_equal(s.messages, 0);
    nrd_destroy(instance);
}

static void constants_hold_neither_nan_nor_infinity(void **state)
{
    spy s;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        nrd *instance = create_one(&s, (nrd_denoiser)i, 1, 1, NRD_FEATURE_ALL);
        for (uint32_t seed = 0; seed < 64; seed++) {
            pose p = random_pose(seed, 3);
            nrd_frame frame = nrd_frame_defaults();
            frame.frame_index = seed;
            frame.camera = pose_camera(&p);
            frame.clip_y = pose_clip_y(&p);
            set_frame(instance, &frame);
            nrd_constants c = constants_of(instance);
#define CHECK_mat4(name) for (int k = 0; k < 16; k++) assert_true(isfinite(c.name[k]));
#define CHECK_vec4(name) for (int k = 0; k < 4; k++) assert_true(isfinite(c.name[k]));
#define CHECK_float(name) assert_true(isfinite(c.name));
#define CHECK_uint(name)
#define CHECK(type, name) CHECK_##type(name)
            NRD_CONSTANTS(CHECK)
        }
        nrd_destroy(instance);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_read_before_it_is_written),
        cmocka_unit_test(every_output_is_written_and_no_input_is),
        cmocka_unit_test(nrd_uses_resource_names_what_is_bound_in_some_frame),
        cmocka_unit_test(ping_pong_halves_alternate_and_are_overwritten_only_after_they_were_read),
        cmocka_unit_test(counters_are_cleared_one_frame_ahead),
        cmocka_unit_test(passes_on_listed_tiles_have_the_number_of_groups_of_their_frame),
        cmocka_unit_test(every_read_finds_what_the_same_pass_wrote_in_this_frame_or_the_last),
        cmocka_unit_test(no_dispatch_filters_or_writes_twice_what_it_writes),
        cmocka_unit_test(transient_lifetimes_match_the_dispatches_and_no_texture_is_unused),
        cmocka_unit_test(memory_totals_are_the_sums_of_the_textures),
        cmocka_unit_test(memory_at_1080p_stays_within_the_budget_of_each_denoiser),
        cmocka_unit_test(two_denoisers_share_their_transient_memory),
        cmocka_unit_test(memory_is_taken_once_at_creation_and_given_back_at_the_end),
        cmocka_unit_test(blocks_with_a_common_time_never_overlap),
        cmocka_unit_test(blocks_that_never_meet_lie_on_top_of_each_other),
        cmocka_unit_test(features_that_are_not_declared_leave_their_passes_out_and_say_so),
        cmocka_unit_test(the_prepass_and_the_split_screen_exist_only_when_declared),
        cmocka_unit_test(settings_of_zero_drop_their_passes),
        cmocka_unit_test(dispatches_come_in_the_order_of_the_passes_and_never_exceed_them),
        cmocka_unit_test(a_full_split_screen_runs_nothing_but_the_split),
        cmocka_unit_test(dispatches_of_one_denoiser_leave_the_others_alone),
        cmocka_unit_test(grids_cover_the_rectangle_and_not_a_group_more),
        cmocka_unit_test(the_same_frame_index_twice_replaces_the_frame),
        cmocka_unit_test(a_replaced_frame_takes_its_previous_camera_with_it),
        cmocka_unit_test(a_replaced_frame_takes_its_restart_with_it),
        cmocka_unit_test(a_skipped_frame_index_warns_once_and_restarts_history),
        cmocka_unit_test(the_frame_index_may_wrap_around),
        cmocka_unit_test(restart_forgets_the_history_and_the_previous_camera_without_a_message),
        cmocka_unit_test(the_previous_camera_and_rectangle_are_remembered_or_overridden),
        cmocka_unit_test(reference_counts_its_frames_and_restarts_when_the_camera_moves),
        cmocka_unit_test(constants_reconstruct_world_points_for_every_kind_of_camera),
        cmocka_unit_test(a_light_moves_in_the_world_not_with_its_origin),
        cmocka_unit_test(constants_hold_neither_nan_nor_infinity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
