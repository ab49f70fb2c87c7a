/* Tiles that are all sky, those without a penumbra, and those whose surfaces are too rough for a specular signal: leaving them out changes no bit, of the outputs of this frame or of any after it, and
   nothing runs on them. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "stage.h"

static const char *const nothing[3] = { NULL, NULL, NULL };
static stage listed, whole;

/* ---------------------------------------------------------------------------------------------------------------------------
   Two ways to run a pass  >>ways */
static uint32_t width_of(const stage *s) { return s->rect_width ? s->rect_width : STAGE_WIDTH; }
static uint32_t height_of(const stage *s) { return s->rect_height ? s->rect_height : STAGE_HEIGHT; }

/* As nrd.h allows: with a group for every tile. */
static VKAPI_ATTR void VKAPI_CALL dispatch_all(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset)
{
    PFN_vkCmdDispatch dispatch = (PFN_vkCmdDispatch)device.get_device_proc(device.device, "vkCmdDispatch");
    (void)buffer;
    (void)offset;
    dispatch(cmd, (width_of(&whole) + 7) / 8, (height_of(&whole) + 7) / 8, 1);
}

static PFN_vkVoidFunction VKAPI_CALL find_function(VkDevice d, const char *name)
{
    return strcmp(name, "vkCmdDispatchIndirect") == 0 ? (PFN_vkVoidFunction)dispatch_all : device.get_device_proc(d, name);
}

/* What nobody writes stays. */
static void fill_outputs(stage *s)
{
    static uint8_t pattern[STAGE_PIXELS * 16];
    for (size_t i = 0; i < sizeof pattern; i++) pattern[i] = (uint8_t)(i % 61);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++)
        if (s->images[i].view && nrd_resource_format((nrd_resource)i) != NRD_FORMAT_ANY) assert_true(gpu_upload(&device, &s->images[i], pattern));
}

typedef bool sky_of(uint32_t x, uint32_t y, uint32_t frame);
typedef int light_of(uint32_t x, uint32_t y, uint32_t frame);

/* What stands on a stage. */
typedef struct scenery { sky_of *is_sky; light_of *light; sky_of *is_rough; uint32_t features; } scenery;

static void dress(stage *s, const scenery *with)
{
    s->is_sky = with->is_sky;
    s->light = with->light;
    s->is_rough = with->is_rough;
    stage_set(s, nothing);
    fill_outputs(s);
}

static void open_both_with(nrd_denoiser denoiser, const scenery *with)
{
    nrd_vk_desc callbacks = { .get_device_proc = find_function };
    stage_open_with(&listed, denoiser, with->features, 0, NULL);
    stage_open_with(&whole, denoiser, with->features, 0, &callbacks);
    dress(&listed, with);
    dress(&whole, with);
}

static void open_both_lit(nrd_denoiser denoiser, sky_of *is_sky, light_of *light) { open_both_with(denoiser, &(scenery){ is_sky, light, NULL, 0 }); }

static void open_both(nrd_denoiser denoiser, sky_of *is_sky) { open_both_lit(denoiser, is_sky, NULL); }

static void run_both(uint32_t frame, uint32_t rect_width, uint32_t rect_height, const char *what)
{
    listed.rect_width = whole.rect_width = rect_width;
    listed.rect_height = whole.rect_height = rect_height;
    stage_run(&listed, frame, NULL);
    stage_run(&whole, frame, NULL);
    stage_assert_same(&listed, &whole, what);
}

static void close_both(void)
{
    stage_close(&listed);
    stage_close(&whole);
    assert_int_equal(gpu_message_count(&device), 0);
}

static bool is_on_tiles(nrd_denoiser d) { return d != NRD_DENOISER_REFERENCE; }
static bool is_of_reflections(nrd_denoiser d) { return d == NRD_DENOISER_REBLUR_SPECULAR || d == NRD_DENOISER_REBLUR_SPECULAR_SH; }
static bool is_of_both(nrd_denoiser d) { return d == NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR || d == NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_SH; }
static bool is_shadow(nrd_denoiser d) { return d == NRD_DENOISER_SIGMA_SHADOW || d == NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY; }

/* ---------------------------------------------------------------------------------------------------------------------------
   Skies  >>skies */
static bool everywhere(uint32_t x, uint32_t y, uint32_t frame) { (void)x; (void)y; (void)frame; return true; }

/* The upper half, which ends within a row of tiles. */
static bool above(uint32_t x, uint32_t y, uint32_t frame) { (void)x; (void)frame; return y < STAGE_HEIGHT / 2 - 1; }

/* To the right, from the fifth frame on; before, there were surfaces. */
static bool right(uint32_t x, uint32_t y, uint32_t frame) { (void)y; return frame >= 5 && x >= 8; }

/* Nothing but sky, in which a pixel, a tile and at last a half of the picture appear; they go as they came. */
static bool comes_and_goes(uint32_t x, uint32_t y, uint32_t frame)
{
    uint32_t step = frame % 16;
    if (step < 4 || step >= 12) return true;
    if (step < 6) return !(x == 21 && y == 13);
    if (step < 8) return !(x / 8 == 2 && y / 8 == 1);
    return x < STAGE_WIDTH / 2;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Lights  >>lights */
static int half(uint32_t x, uint32_t y, uint32_t frame) { (void)y; (void)frame; return x < 16 ? 1 : -1; }

/* A band of penumbra that passes over light and shadow, every other time wide, and stops. */
static int passing(uint32_t x, uint32_t y, uint32_t frame)
{
    int step = (int)(frame < 20 ? frame % 10 : 5), at = 5 * step + (int)y / 3 - 8, width = frame / 10 % 2 ? 9 : 1;
    return (int)x < at ? 1 : (int)x < at + width ? 0 : -1;
}

/* Lit, but for a ray that wanders. */
static int wandering(uint32_t x, uint32_t y, uint32_t frame) { return x == 7 * frame % STAGE_WIDTH && y == 5 * frame % STAGE_HEIGHT ? -1 : 1; }

/* ---------------------------------------------------------------------------------------------------------------------------
   Tests  >>tests */
static void leaving_out_tiles_of_sky_changes_no_bit_of_any_frame(void **state)
{
    (void)state;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        if (!is_on_tiles((nrd_denoiser)d)) continue;
        open_both((nrd_denoiser)d, comes_and_goes);
        for (uint32_t frame = 0; frame < 24; frame++) run_both(frame, 0, 0, "sky that comes and goes");
        close_both();
    }
}

static void tiles_cut_by_the_rectangle_are_others_when_it_changes(void **state)
{
    static const uint32_t rects[][2] = { { 0, 0 }, { 27, 19 }, { 28, 19 }, { 9, 8 }, { 0, 0 } };
    (void)state;
    open_both(NRD_DENOISER_REBLUR_DIFFUSE, right);
    for (uint32_t frame = 0; frame < 13; frame++) run_both(frame, frame < 5 ? 0 : frame < 10 ? 9 : 20, 0, "a rectangle that grows over surfaces that have gone");
    close_both();
    open_both(NRD_DENOISER_REBLUR_DIFFUSE, above);
    for (uint32_t frame = 0; frame < 25; frame++) run_both(frame, rects[frame / 5][0], rects[frame / 5][1], "a rectangle that changes over a half sky");
    for (uint32_t frame = 25; frame < 35; frame++) run_both(frame, 20 + frame % 7, 15 + frame % 5, "a rectangle that changes in every frame");
    close_both();
    open_both(NRD_DENOISER_REBLUR_DIFFUSE_OCCLUSION, comes_and_goes);
    for (uint32_t frame = 0; frame < 32; frame++) run_both(frame, frame % 3 ? 33 : 0, frame % 5 ? 17 : 0, "a rectangle that changes");
    close_both();
}

static void frames_left_out_and_restarts_change_nothing(void **state)
{
    (void)state;
    open_both(NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, comes_and_goes);
    for (uint32_t frame = 0; frame < 40; frame += 1 + frame % 3) run_both(frame, 0, 0, "a frame that was left out");
    close_both();
}

/* To the left, where a pixel appears while the rectangle ends there. */
static bool left(uint32_t x, uint32_t y, uint32_t frame) { return x < 16 && !(frame >= 14 && x == 3 && y == 5); }

/* After ten frames of surfaces, in which a pixel appears. */
static bool until_ten(uint32_t x, uint32_t y, uint32_t frame) { return frame >= 10 && !(frame >= 18 && x == 3 && y == 5); }

/* A lamp that goes on in the last frame with surfaces. */
static float flaring(uint32_t frame) { return frame >= 9 ? 20.0f : 1.0f; }

static void set_antilag(float sensitivity)
{
    nrd_reblur_settings settings = nrd_reblur_defaults();
    settings.antilag_sensitivity = sensitivity;
    assert_int_equal(nrd_set_settings(listed.instance, STAGE_IDENTIFIER, &settings), NRD_RESULT_OK);
    assert_int_equal(nrd_set_settings(whole.instance, STAGE_IDENTIFIER, &settings), NRD_RESULT_OK);
}

static void search_both(sky_of *is_sky, uint32_t rect_from_ten, bool pauses, const char *what)
{
    open_both(NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, is_sky);
    listed.brightness = whole.brightness = flaring;
    for (uint32_t frame = 4; frame < 22; frame++) {
        set_antilag(pauses && frame >= 10 && frame < 14 ? 0.0f : 0.6f);
        run_both(frame, frame >= 10 ? rect_from_ten : 0, 0, what);
    }
    close_both();
}

/* Whatever the last search left behind before the sky. */
static void leaving_out_the_search_for_lighting_changes_changes_no_bit_of_any_frame(void **state)
{
    (void)state;
    search_both(until_ten, 0, true, "a search that begins in the sky");
    search_both(left, 16, false, "a rectangle that leaves nothing but sky");
}

/* Numbers of groups of the last frame. */
static const uint32_t *groups_of(const stage *s)
{
    const nrd_info *info = nrd_get_info(s->instance);
    uint32_t t = 0;
    while (!info->textures[t].buffer) t++;
    const char *mapped = (const char *)s->vk->memory[NRD_VK_MEMORY_CONSTANTS].mapped;
    const uint32_t *first = (const uint32_t *)(mapped + nrdi_vk_groups_of(s->vk, t)), *second = (const uint32_t *)(mapped + nrdi_vk_groups_of(s->vk, t + 1));
    assert_true((first[1] == 0 && first[5] == 0) || (second[1] == 0 && second[5] == 0));   /* one is the next frame's */
    return second[1] ? second : first;
}

static void a_sky_takes_no_groups_from_its_third_frame_on(void **state)
{
    (void)state;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        if (!is_on_tiles((nrd_denoiser)d)) continue;
        open_both((nrd_denoiser)d, everywhere);
        for (uint32_t frame = 0; frame < 5; frame++) {
            run_both(frame, 0, 0, "nothing but sky");
            bool listing = frame < (is_shadow((nrd_denoiser)d) ? 1 : 2);
            assert_int_equal(groups_of(&listed)[1], listing ? STAGE_HEIGHT / 8 : 0);
            assert_int_equal(groups_of(&listed)[5], listing ? (STAGE_HEIGHT + 63) / 64 : 0);   /* of a thread for every tile */
        }
        close_both();
    }
}

static void leaving_out_tiles_without_penumbra_changes_no_bit_of_any_frame(void **state)
{
    static light_of *const lights[] = { half, passing, wandering };
    (void)state;
    for (int k = 0; k < 6; k++) {
        open_both_lit(k % 2 ? NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY : NRD_DENOISER_SIGMA_SHADOW, comes_and_goes, lights[k / 2]);
        for (uint32_t frame = 0; frame < 24; frame++) run_both(frame, frame < 16 ? 0 : 19 + frame % 9, 0, "light that changes");
        close_both();
    }
}

static void an_edge_of_shadow_takes_the_groups_of_the_tiles_beside_it(void **state)
{
    (void)state;
    open_both_lit(NRD_DENOISER_SIGMA_SHADOW, NULL, half);
    for (uint32_t frame = 0; frame < 3; frame++) {
        run_both(frame, 0, 0, "half light");
        const uint32_t *groups = groups_of(&listed);
        assert_int_equal(groups[0], STAGE_WIDTH / 8);
        assert_int_equal(groups[1], frame ? 2 : 3);   /* rows; the first frame has all tiles */
        assert_int_equal(groups[3], (frame ? 2 : STAGE_WIDTH / 8) * (STAGE_HEIGHT / 8));
    }
    close_both();
}

/* A ray that is blocked alone, on a floor or a wall that is lit. */
static uint32_t lone_x, lone_y;
static int lone(uint32_t x, uint32_t y, uint32_t frame) { (void)frame; return x == lone_x && y == lone_y ? -2 : 1; }

/* A texel of grey, or of colour: what a blocked ray lets through is of any. */
static bool is_white(const uint8_t *texel, uint32_t channels) { return texel[0] == 255 && (channels == 1 || (texel[1] == 255 && texel[2] == 255)); }

static void assert_spread(const uint8_t *shown, uint32_t channels)
{
    for (uint32_t y = lone_y ? lone_y - 1 : 0; y <= lone_y + 1 && y < STAGE_HEIGHT; y++)
        for (uint32_t x = lone_x ? lone_x - 1 : 0; x <= lone_x + 1 && x < STAGE_WIDTH; x++)
            if (stage_is_floor(y) == stage_is_floor(lone_y) && is_white(&shown[(y * STAGE_WIDTH + x) * channels], channels))
                fail_msg("pixel %u, %u is as if the ray at %u, %u had reached the light: its tile was left out", x, y, lone_x, lone_y);
}

/* Wherever the ray lies in its tile, the tiles that it borders on are in the list, and what is in the list is run. That another way to run a pass gives
   the same would not tell: what is missing there is missing in all of them. */
static void a_blocked_ray_darkens_the_pixels_around_it_whatever_their_tiles(void **state)
{
    static const char *const no_history[3] = { "max_accumulated_frames", NULL, NULL };
    static uint8_t shown[STAGE_PIXELS * 4];
    (void)state;
    for (int colored = 0; colored < 2; colored++) {
        nrd_resource out = colored ? NRD_RESOURCE_OUT_SHADOW_TRANSLUCENCY : NRD_RESOURCE_OUT_SHADOW;
        uint32_t frame = 0;
        open_both_lit(colored ? NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY : NRD_DENOISER_SIGMA_SHADOW, NULL, lone);
        stage_set(&listed, no_history);
        for (uint32_t i = 0; i < STAGE_PIXELS; i++) {
            lone_x = i % STAGE_WIDTH, lone_y = i / STAGE_WIDTH;
            if ((lone_x + 1) % 8 > 1 || ((lone_y + 1) % 8 > 1 && lone_y % 8 != 4)) continue;   /* beside edges and corners of tiles */
            stage_run(&listed, frame++, NULL);
            assert_true(gpu_download(&device, &listed.images[out], shown));
            assert_spread(shown, colored ? 4 : 1);
        }
        close_both();
    }
}

static void a_half_sky_takes_the_groups_of_the_other_half(void **state)
{
    (void)state;
    open_both(NRD_DENOISER_REBLUR_SPECULAR, above);
    for (uint32_t frame = 0; frame < 5; frame++) run_both(frame, 0, 0, "a half sky");
    const uint32_t *groups = groups_of(&listed);
    assert_int_equal(groups[0], STAGE_WIDTH / 8);
    assert_int_equal(groups[1], 2);   /* rows, of three */
    assert_int_equal(groups[2], 1);
    assert_int_equal(groups[3], 2 * (STAGE_WIDTH / 8));
    close_both();
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Surfaces too rough for a specular signal  >>rough */
static bool nowhere(uint32_t x, uint32_t y, uint32_t frame) { (void)x; (void)y; (void)frame; return false; }

/* Roughness that moves over the surfaces, a tile and more a frame. */
static bool wanders(uint32_t x, uint32_t y, uint32_t frame) { return (x + 11 * frame) / 16 % 2 == (y / 12 + frame / 7) % 2; }

/* A wall of which the tiles in the middle have one smooth pixel each. */
static bool almost_everywhere(uint32_t x, uint32_t y, uint32_t frame) { (void)frame; return !(x == 23 && y == 8) && !(x == 31 && y == 15); }

static const scenery rough_sceneries[] = {
    { NULL, NULL, wanders, NRD_FEATURE_ROUGHNESS_LIMIT },
    { comes_and_goes, NULL, wanders, NRD_FEATURE_ALL & ~(NRD_FEATURE_HISTORY_CONFIDENCE | NRD_FEATURE_DISOCCLUSION_THRESHOLD_MIX) },
};

/* Nor does what the specular inputs hold there. */
static void leaving_out_tiles_that_are_too_rough_changes_no_bit_of_any_frame(void **state)
{
    (void)state;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        if (!is_of_reflections((nrd_denoiser)d) && !is_of_both((nrd_denoiser)d)) continue;
        for (size_t k = 0; k < sizeof rough_sceneries / sizeof rough_sceneries[0]; k++) {
            open_both_with((nrd_denoiser)d, &rough_sceneries[k]);
            whole.rubbish = true;
            for (uint32_t frame = 0; frame < 20; frame++) run_both(frame, frame < 16 ? 0 : 19 + frame % 9, 0, "roughness that wanders over rubbish");
            close_both();
        }
    }
}

/* Bytes of an output that differ where `where` holds. */
static size_t count_changes(nrd_resource output, const uint8_t *before, sky_of *where)
{
    static uint8_t now[STAGE_PIXELS * 16];
    uint32_t size = gpu_format_size(listed.images[output].format);
    size_t changes = 0;
    assert_true(gpu_download(&device, &listed.images[output], now));
    for (uint32_t i = 0; i < STAGE_PIXELS; i++)
        for (uint32_t k = 0; k < size && where(i % STAGE_WIDTH, i / STAGE_WIDTH, 0); k++) changes += now[i * size + k] != before[i * size + k];
    return changes;
}

static void outputs_stay_as_they_are_where_it_is_too_rough(void **state)
{
    static uint8_t before[STAGE_PIXELS * 16];
    static const nrd_resource outputs[] = { NRD_RESOURCE_OUT_SPEC_RADIANCE_HITDIST, NRD_RESOURCE_OUT_SPEC_SH0, NRD_RESOURCE_OUT_SPEC_SH1 };
    (void)state;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        if (!is_of_reflections((nrd_denoiser)d) && !is_of_both((nrd_denoiser)d)) continue;
        open_both_with((nrd_denoiser)d, &(scenery){ NULL, NULL, almost_everywhere, NRD_FEATURE_ROUGHNESS_LIMIT });
        for (int k = 0; k < 3; k++) {
            if (!listed.images[outputs[k]].view) continue;
            fill_outputs(&listed);
            assert_true(gpu_download(&device, &listed.images[outputs[k]], before));
            for (uint32_t frame = 0; frame < 6; frame++) stage_run(&listed, frame, NULL);
            assert_int_equal(count_changes(outputs[k], before, almost_everywhere), 0);
            assert_true(count_changes(outputs[k], before, everywhere) > 0);
        }
        close_both();
    }
}

/* NaN in the outputs, half of them. */
static void spoil_outputs(stage *s)
{
    static uint16_t halves[STAGE_PIXELS * 8];
    for (size_t i = 0; i < sizeof halves / sizeof halves[0]; i++) halves[i] = i / 4 % 2 ? 0x7e00 : 0x7000;
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++)
        if (s->images[i].view && nrd_resource_format((nrd_resource)i) == NRD_FORMAT_RGBA16_FLOAT) assert_true(gpu_upload(&device, &s->images[i], halves));
}

/* Neighbours do not see what is left in the images where a surface is too rough. */
static void what_lies_where_it_is_too_rough_does_not_reach_others(void **state)
{
    static const nrd_denoiser some[] = { NRD_DENOISER_REBLUR_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_SH };
    static uint64_t left[STAGE_PIXELS], right[STAGE_PIXELS];
    (void)state;
    for (int k = 0; k < 3; k++) {
        open_both_with(some[k], &(scenery){ NULL, NULL, wanders, NRD_FEATURE_ROUGHNESS_LIMIT });
        for (uint32_t frame = 0; frame < 10; frame++) {
            fill_outputs(&listed);
            spoil_outputs(&whole);
            stage_run(&listed, frame, NULL);
            stage_run(&whole, frame, NULL);
            for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
                if (!listed.images[i].view || nrd_resource_format((nrd_resource)i) != NRD_FORMAT_RGBA16_FLOAT) continue;
                assert_true(gpu_download(&device, &listed.images[i], left) && gpu_download(&device, &whole.images[i], right));
                for (uint32_t p = 0; p < STAGE_PIXELS; p++)
                    if (left[p] != right[p] && !wanders(p % STAGE_WIDTH, p / STAGE_WIDTH, frame))
                        fail_msg("%s, frame %u, pixel %u of %s", nrd_denoiser_name(some[k]), frame, p, nrd_resource_name((nrd_resource)i));
            }
        }
        close_both();
    }
}

static void a_limit_changes_nothing_where_all_is_smoother(void **state)
{
    static const nrd_denoiser some[] = { NRD_DENOISER_REBLUR_SPECULAR, NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR_SH };
    (void)state;
    for (int k = 0; k < 2; k++) {
        const scenery with = { above, NULL, nowhere, 0 };
        stage_open(&whole, some[k], 0, NULL);
        stage_open_with(&listed, some[k], NRD_FEATURE_ROUGHNESS_LIMIT, 0, NULL);
        dress(&whole, &with);
        dress(&listed, &with);
        for (uint32_t frame = 0; frame < 8; frame++) run_both(frame, 0, 0, "a limit");
        close_both();
    }
}

static void tiles_that_are_too_rough_take_no_groups_from_their_third_frame_on(void **state)
{
    (void)state;
    open_both_with(NRD_DENOISER_REBLUR_SPECULAR, &(scenery){ NULL, NULL, almost_everywhere, NRD_FEATURE_ROUGHNESS_LIMIT });
    for (uint32_t frame = 0; frame < 5; frame++) {
        run_both(frame, 0, 0, "almost everything too rough");
        assert_int_equal(groups_of(&listed)[3], frame < 2 ? STAGE_PIXELS / 64 : 2);
    }
    close_both();
    open_both_with(NRD_DENOISER_REBLUR_DIFFUSE_SPECULAR, &(scenery){ NULL, NULL, everywhere, NRD_FEATURE_ROUGHNESS_LIMIT });
    for (uint32_t frame = 0; frame < 5; frame++) run_both(frame, 0, 0, "all too rough, but the diffuse signal is there");
    assert_int_equal(groups_of(&listed)[3], STAGE_PIXELS / 64);
    close_both();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(leaving_out_tiles_of_sky_changes_no_bit_of_any_frame),
        cmocka_unit_test(tiles_cut_by_the_rectangle_are_others_when_it_changes),
        cmocka_unit_test(frames_left_out_and_restarts_change_nothing),
        cmocka_unit_test(leaving_out_the_search_for_lighting_changes_changes_no_bit_of_any_frame),
        cmocka_unit_test(a_sky_takes_no_groups_from_its_third_frame_on),
        cmocka_unit_test(leaving_out_tiles_without_penumbra_changes_no_bit_of_any_frame),
        cmocka_unit_test(an_edge_of_shadow_takes_the_groups_of_the_tiles_beside_it),
        cmocka_unit_test(a_blocked_ray_darkens_the_pixels_around_it_whatever_their_tiles),
        cmocka_unit_test(a_half_sky_takes_the_groups_of_the_other_half),
        cmocka_unit_test(leaving_out_tiles_that_are_too_rough_changes_no_bit_of_any_frame),
        cmocka_unit_test(outputs_stay_as_they_are_where_it_is_too_rough),
        cmocka_unit_test(what_lies_where_it_is_too_rough_does_not_reach_others),
        cmocka_unit_test(a_limit_changes_nothing_where_all_is_smoother),
        cmocka_unit_test(tiles_that_are_too_rough_take_no_groups_from_their_third_frame_on),
    };
    return cmocka_run_group_tests(tests, open_validated_device, close_device);
}
