/* Another size without losing history: the error after a resize is that of a run that always had this size, not that of a restart; and
   whatever becomes of the call, nothing leaks, nothing is used too long, and the validation layer is silent. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "denoise_rig.h"

/* ---------------------------------------------------------------------------------------------------------------------------
   Scene and signals  >>scene */
/* A floor under a wall, and a pillar in front of them that hides and uncovers while the camera moves sideways. */
static hit pillar(const pose *p, double u, double v, uint32_t frame)
{
    static const struct { double point[3], normal[3]; } planes[] = { { { 0, -1, 0 }, { 0, 1, 0 } }, { { 0, 0, 8 }, { 0, 0, -1 } }, { { 0, 0, 4 }, { 0, 0, -1 } } };
    hit h = { RIG_SKY, { 0, 0, -1 }, 0, { 0, 0, 0 }, 0 };
    (void)frame;
    for (uint32_t i = 0; i < 3; i++) {
        double depth, world[3];
        if (!rig_ray_plane(p, u, v, planes[i].point, planes[i].normal, &depth) || depth >= h.depth) continue;
        pose_point(p, u, v, depth, world);
        if (i == 2 && fabs(world[0] - 0.5) > 0.4) continue;
        h.depth = depth;
        h.region = i;
        memcpy(h.normal, planes[i].normal, sizeof h.normal);
    }
    return h;
}

static void world_of(const rig *r, uint32_t x, uint32_t y, double world[3])
{
    pose_point(&r->camera, (x + 0.5) / r->rect_width, (y + 0.5) / r->rect_height, r->hits[y * r->rect_width + x].depth, world);
}

/* What a pixel would show without noise: smooth over the surfaces, in [0.2, 0.8]. */
static double truth_at(const rig *r, uint32_t x, uint32_t y)
{
    double w[3];
    world_of(r, x, y, w);
    return 0.5 + 0.3 * sin(1.5 * w[0] + r->hits[y * r->rect_width + x].region) * cos(1.2 * w[1] + 0.7 * w[2]);
}

typedef struct kind {
    nrd_denoiser denoiser;
    nrd_resource input, output;
    uint32_t channels, channel; /* of the input; of the output: which one is compared */
} kind;

static const kind kinds[] = {
    { NRD_DENOISER_REBLUR_DIFFUSE, NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST, 4, 0 },
    { NRD_DENOISER_REBLUR_SPECULAR, NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, NRD_RESOURCE_OUT_SPEC_RADIANCE_HITDIST, 4, 0 },
    { NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, NRD_RESOURCE_IN_DIFF_HITDIST, NRD_RESOURCE_OUT_DIFF_HITDIST, 1, 0 },
    { NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, NRD_RESOURCE_OUT_DIFF_DIRECTION_HITDIST, 4, 3 },
    { NRD_DENOISER_SIGMA_SHADOW, NRD_RESOURCE_IN_PENUMBRA, NRD_RESOURCE_OUT_SHADOW, 1, 0 },
    { NRD_DENOISER_REBLUR_DIFFUSE_SH, NRD_RESOURCE_IN_DIFF_SH0, NRD_RESOURCE_OUT_DIFF_SH0, 4, 0 },
};

/* One sample whose mean is the truth. */
static void put_sample(const rig *r, const kind *k, uint32_t x, uint32_t y, float texel[4])
{
    double truth = truth_at(r, x, y), random = random_at(x, y, r->index);
    memset(texel, 0, 4 * sizeof *texel);
    switch (k->input) {
    case NRD_RESOURCE_IN_PENUMBRA: texel[0] = random < truth ? 65504.0f : 1.0f; break;
    case NRD_RESOURCE_IN_DIFF_HITDIST: texel[0] = random < (truth - 0.1) / 0.9 ? 1.0f : 0.1f; break;
    case NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST: texel[3] = random < (truth - 0.1) / 0.9 ? 1.0f : 0.1f; texel[2] = -texel[3]; break;
    default: texel[0] = (float)(random < 0.25 ? 4 * truth : 0); texel[3] = 0.5f;
    }
}

/* The rig itself uploads what is in its array. */
static void put_samples(rig *r, const kind *k)
{
    bool of_rig = k->input == RIG_RADIANCE;
    uint16_t *texels = of_rig ? r->noisy : (uint16_t *)rig_array(r, 2 * k->channels);
    for (uint32_t i = 0; i < r->width * r->height; i++) {
        float texel[4];
        put_sample(r, k, i % r->width, i / r->width, texel);
        half_from_floats(&texels[i * k->channels], texel, k->channels);
    }
    if (of_rig) return;
    assert_true(gpu_upload(r->device, &r->images[k->input], texels));
    free(texels);
}

static double value_of(const kind *k, const void *texels, size_t i)
{
    if (k->output == NRD_RESOURCE_OUT_SHADOW) return pack_unpack_shadow(((const uint8_t *)texels)[i]);
    return half_to_float(((const uint16_t *)texels)[i * k->channels + k->channel]);
}

/* Root of the mean squared error of the output. */
static double error_of(const rig *r, const kind *k)
{
    void *texels = rig_array(r, gpu_format_size(r->images[k->output].format));
    double sum = 0;
    assert_true(gpu_download(r->device, &r->images[k->output], texels));
    for (uint32_t i = 0; i < r->width * r->height; i++) {
        double difference = value_of(k, texels, i) - truth_at(r, i % r->width, i / r->width);
        sum += difference * difference;
    }
    free(texels);
    return sqrt(sum / (r->width * r->height));
}

static void open_bench(rig *r, const kind *k, uint32_t width, uint32_t height)
{
    rig_open(r, &device, k->denoiser, width, height, pillar);
    r->camera.aspect = 16.0 / 9.0;
    r->camera_prev = r->camera;
}

/* The camera moves sideways. */
static void run_bench(rig *r, const kind *k, uint32_t frames)
{
    for (uint32_t i = 0; i < frames; i++) {
        r->camera.position[0] = 0.02 * r->index;
        rig_put_guides(r);
        put_samples(r, k);
        rig_run(r, true);
    }
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Error  >>error */
static const uint32_t sizes[][2] = { { 96, 54 }, { 144, 82 }, { 72, 41 } };
enum { FRAMES = 16 };

/* In the first frame of a size: of a run that always had it, and of one that starts with it. */
static double error_without_resize(const kind *k, uint32_t size, bool restart)
{
    rig r;
    open_bench(&r, k, sizes[size][0], sizes[size][1]);
    if (restart) r.index = FRAMES * size;
    run_bench(&r, k, restart ? 1 : FRAMES * size + 1);
    double error = error_of(&r, k);
    rig_close(&r);
    return error;
}

/* Of the first frame of another size. History of a smaller picture holds fewer samples of the same surface (after growing from 96x54 to 144x82:
   4/9), which is what then lies between it and the run that always had that size; it must not be worse than either of the two. */
static void the_error_after_a_resize_is_that_of_an_uninterrupted_run(void **state)
{
    (void)state;
    double worst = 0;
    uint32_t before = gpu_message_count(&device);
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        rig r;
        open_bench(&r, &kinds[i], sizes[0][0], sizes[0][1]);
        run_bench(&r, &kinds[i], FRAMES);
        for (uint32_t size = 1; size < 3; size++) {
            double before_resize = error_of(&r, &kinds[i]);
            rig_resize(&r, sizes[size][0], sizes[size][1]);
            run_bench(&r, &kinds[i], 1);
            double resized = error_of(&r, &kinds[i]), always = error_without_resize(&kinds[i], size, false), restart = error_without_resize(&kinds[i], size, true);
            print_message("%s to %ux%u: error %.4f, before %.4f, uninterrupted %.4f, restarted %.4f\n", nrd_denoiser_name(kinds[i].denoiser), sizes[size][0],
                          sizes[size][1], resized, before_resize, always, restart);
            assert_true(resized < 1.02 * fmax(always, before_resize));
            worst = fmax(worst, (resized - always) / (restart - always));
            run_bench(&r, &kinds[i], FRAMES - 1);
        }
        rig_close(&r);
    }
    assert_true(worst < 0.4);
    assert_int_equal(gpu_message_count(&device), before);
}

/* ---------------------------------------------------------------------------------------------------------------------------
   The core alone  >>core */
typedef struct run { const nrd_dispatch *dispatches; uint32_t count; } run;

static run dispatches_of(nrd *instance, uint32_t frame_index, const uint32_t *identifier)
{
    run r = { NULL, 0 };
    nrd_frame frame = still_frame(frame_index);
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
    assert_int_equal(nrd_get_dispatches(instance, identifier, identifier != NULL, &r.dispatches, &r.count), NRD_RESULT_OK);
    return r;
}

static void after_a_resize_the_instance_describes_what_a_new_one_would(void **state)
{
    nrd_denoiser_desc all[NRD_DENOISER_COUNT];
    nrd *fresh = NULL;
    spy s, t = { 0 };
    (void)state;
    for (uint32_t i = 0; i < NRD_DENOISER_COUNT; i++) all[i].identifier = i, all[i].denoiser = (nrd_denoiser)i;
    nrd_desc desc = spied_desc(&t, all, NRD_DENOISER_COUNT, 101, 33, NRD_FEATURE_ALL);
    nrd *resized = create_all(&s);
    assert_int_equal(nrd_create(&desc, &fresh), NRD_RESULT_OK);
    dispatches_of(resized, 0, NULL);
    assert_int_equal(nrd_resize(resized, 101, 33), NRD_RESULT_OK);
    const nrd_info *a = nrd_get_info(resized), *b = nrd_get_info(fresh);
    assert_int_equal(a->texture_count, b->texture_count);
    assert_memory_equal(a->textures, b->textures, a->texture_count * sizeof *a->textures);
    assert_int_equal(a->pass_count, b->pass_count);
    assert_memory_equal(a->passes, b->passes, a->pass_count * sizeof *a->passes);
    assert_int_equal(a->pipeline_count, b->pipeline_count);
    assert_int_equal(a->left_out_count, b->left_out_count);
    for (uint32_t i = 0; i < b->left_out_count; i++) assert_int_equal(a->left_out[i].bytes_saved, b->left_out[i].bytes_saved);
    assert_true(a->width == 101 && a->height == 33);
    assert_true(a->permanent_bytes == b->permanent_bytes && a->transient_bytes == b->transient_bytes);
    assert_true(a->transient_unshared_bytes == b->transient_unshared_bytes && a->max_bindings == b->max_bindings);
    nrd_destroy(resized);
    nrd_destroy(fresh);
}

/* Of all bindings: whether a permanent texture that this frame has not written yet is read from where it was before the resize. */
static void assert_reads_former(const nrd_info *info, run r, bool first)
{
    bool written[128] = { false };
    uint32_t former = 0, reads = 0;
    assert_true(info->texture_count <= 128);
    for (uint32_t d = 0; d < r.count; d++) {
        for (uint32_t i = 0; i < r.dispatches[d].binding_count; i++) {
            const nrd_binding *b = &r.dispatches[d].bindings[i];
            bool history = b->resource == NRD_RESOURCE_INTERNAL && info->textures[b->texture].permanent && !written[b->texture] && (b->access == NRD_ACCESS_READ || b->access == NRD_ACCESS_READ_LINEAR);
            assert_int_equal(b->before_resize, first && history);
            former += b->before_resize;
            reads += history;
        }
        for (uint32_t i = 0; i < r.dispatches[d].binding_count; i++)
            if (r.dispatches[d].bindings[i].resource == NRD_RESOURCE_INTERNAL && r.dispatches[d].bindings[i].access == NRD_ACCESS_WRITE)
                written[r.dispatches[d].bindings[i].texture] = true;
    }
    assert_true(reads > 0 && (former > 0) == first);
}

static void only_the_first_frame_of_another_size_reads_the_former_textures(void **state)
{
    spy s;
    (void)state;
    for (int i = 0; i < NRD_DENOISER_COUNT; i++) {
        nrd *instance = create_one(&s, (nrd_denoiser)i, 100, 60, NRD_FEATURE_ALL);
        bool restarts = i == NRD_DENOISER_REFERENCE;
        for (uint32_t frame = 0; frame < 8; frame++) {
            if (frame == 4) assert_int_equal(nrd_resize(instance, 77, 80), NRD_RESULT_OK);
            run r = dispatches_of(instance, frame, NULL);
            const nrd_constants *c = (const nrd_constants *)r.dispatches[0].constants;
            assert_reads_former(nrd_get_info(instance), r, frame == 4 && !restarts);
            assert_int_equal(c->reset, frame == 0 || (restarts && frame == 4));
            assert_int_equal(c->rect_width_prev, frame <= 4 ? 100 : 77);
        }
        assert_int_equal(s.messages, 0);
        nrd_destroy(instance);
    }
}

static void a_cut_in_the_first_frame_of_another_size_needs_no_former_textures(void **state)
{
    spy s;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 100, 60, 0);
    nrd_frame frame = still_frame(1);
    run r = dispatches_of(instance, 0, NULL);
    assert_int_equal(nrd_resize(instance, 50, 60), NRD_RESULT_OK);
    frame.restart = 1;
    assert_int_equal(nrd_set_frame(instance, &frame), NRD_RESULT_OK);
    assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &r.dispatches, &r.count), NRD_RESULT_OK);
    assert_reads_former(nrd_get_info(instance), r, false);
    nrd_destroy(instance);
}

/* Two resizes with only the other denoiser in between: what this one left is two sizes old. */
static void history_that_missed_a_size_starts_anew(void **state)
{
    static const nrd_denoiser_desc both[] = { { 0, NRD_DENOISER_REBLUR_DIFFUSE }, { 1, NRD_DENOISER_SIGMA_SHADOW } };
    static const uint32_t identifiers[] = { 0, 1 };
    spy s = { 0 };
    nrd *instance = NULL;
    (void)state;
    nrd_desc desc = spied_desc(&s, both, 2, 100, 60, 0);
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    dispatches_of(instance, 0, NULL);
    assert_int_equal(nrd_resize(instance, 50, 60), NRD_RESULT_OK);
    run r = dispatches_of(instance, 1, &identifiers[0]);
    assert_int_equal(((const nrd_constants *)r.dispatches[0].constants)->reset, 0);
    assert_int_equal(nrd_resize(instance, 70, 60), NRD_RESULT_OK);
    r = dispatches_of(instance, 1, &identifiers[1]);
    assert_int_equal(((const nrd_constants *)r.dispatches[0].constants)->reset, 1);
    nrd_destroy(instance);
}

static void cancelled_dispatches_come_again_as_they_were(void **state)
{
    spy s;
    nrd_constants before;
    nrd_binding bindings[8];
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 100, 60, 0);
    nrd_cancel_dispatches(NULL);
    nrd_cancel_dispatches(instance);
    for (uint32_t frame = 0; frame < 6; frame++) {
        if (frame == 3) assert_int_equal(nrd_resize(instance, 50, 60), NRD_RESULT_OK);
        run r = dispatches_of(instance, frame, NULL);
        memcpy(&before, r.dispatches[0].constants, sizeof before);
        memcpy(bindings, r.dispatches[0].bindings, sizeof bindings);
        nrd_cancel_dispatches(instance);
        r = dispatches_of(instance, frame, NULL);
        assert_memory_equal(&before, r.dispatches[0].constants, sizeof before);
        assert_memory_equal(bindings, r.dispatches[0].bindings, sizeof bindings);
    }
    assert_int_equal(s.messages, 0);
    nrd_destroy(instance);
}

static void wrong_sizes_and_a_missing_frame_are_refused(void **state)
{
    static const struct { uint32_t width, height; const char *text; } rows[] = {
        { 0, 60, "nrd_resize.width is 0, allowed: 1 to 16384" }, { 16385, 60, "nrd_resize.width is 16385, allowed: 1 to 16384" },
        { 100, 0, "nrd_resize.height is 0, allowed: 1 to 16384" }, { 100, UINT32_MAX, "nrd_resize.height is 4.294967e9, allowed: 1 to 16384" },
    };
    spy s;
    run r;
    (void)state;
    nrd *instance = create_one(&s, NRD_DENOISER_REBLUR_DIFFUSE, 100, 60, 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(nrd_resize(instance, rows[i].width, rows[i].height), NRD_RESULT_INVALID_ARGUMENT);
        assert_string_equal(s.text, rows[i].text);
    }
    assert_int_equal(nrd_resize(NULL, 1, 1), NRD_RESULT_INVALID_ARGUMENT);
    assert_int_equal(nrd_get_info(instance)->width, 100);
    dispatches_of(instance, 0, NULL);
    assert_int_equal(nrd_resize(instance, 16384, 1), NRD_RESULT_OK);
    assert_int_equal(nrd_get_dispatches(instance, NULL, 0, &r.dispatches, &r.count), NRD_RESULT_FRAME_NOT_SET);
    assert_non_null(strstr(s.text, "nrd_set_frame after nrd_resize"));
    dispatches_of(instance, 1, NULL);
    nrd_destroy(instance);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(after_a_resize_the_instance_describes_what_a_new_one_would),
        cmocka_unit_test(only_the_first_frame_of_another_size_reads_the_former_textures),
        cmocka_unit_test(a_cut_in_the_first_frame_of_another_size_needs_no_former_textures),
        cmocka_unit_test(history_that_missed_a_size_starts_anew),
        cmocka_unit_test(cancelled_dispatches_come_again_as_they_were),
        cmocka_unit_test(wrong_sizes_and_a_missing_frame_are_refused),
        cmocka_unit_test(the_error_after_a_resize_is_that_of_an_uninterrupted_run),
    };
    return cmocka_run_group_tests(tests, open_validated_device, close_device);
}
