/* The command-line programs, from captures to scores. Expects nrd-denoise, nrd-score and nrd-render in the folder that the
   environment variable NRD_BUILD names (build). */
#define _XOPEN_SOURCE 700
#include "common/capture.h"
#include "common/gpu.h"
#include "common/metrics.h"
#include "common/scratch.h"
#include "common/signals.h"
#include "corner_capture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#define FRAMES 12
#define PIXELS (CORNER_WIDTH * CORNER_HEIGHT)

static char folder[SCRATCH_SIZE];
static char output[16384]; /* of the last command */
static char errors[16384];

/* ---- running programs ---- */

static void load_text(const char *name, char *text, size_t size)
{
    char path[SCRATCH_SIZE + 128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, size - 1, file)] = 0;
    fclose(file);
}

/* Runs a program of the build in the test's folder; returns its exit status. Every %s of the format is a word. */
static int run(const char *program, const char *format, ...)
{
    char arguments[1024], command[2048];
    const char *build = getenv("NRD_BUILD");
    va_list list;
    va_start(list, format);
    vsnprintf(arguments, sizeof arguments, format, list);
    va_end(list);
    build = build ? build : "build";
    char *absolute = realpath(build, NULL);
    assert_non_null(absolute);
    snprintf(command, sizeof command, "cd %s && %s/%s %s >output 2>errors", folder, absolute, program, arguments);
    free(absolute);
    int status = system(command);
    load_text("output", output, sizeof output);
    load_text("errors", errors, sizeof errors);
    return status;
}

static void succeed(int status)
{
    if (status)
        fail_msg("status %d: %s", status, errors);
}

static const char *path_of(const char *in, int frame)
{
    static char paths[4][256];
    static int next;
    char *path = paths[next++ % 4], in_folder[SCRATCH_SIZE + 128];
    snprintf(in_folder, sizeof in_folder, "%s/%s", folder, in);
    capture_frame_path(path, sizeof paths[0], in_folder, frame);
    return path;
}

static bool exists(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return access(path, F_OK) == 0;
}

static capture read_frame(const char *in, int frame)
{
    capture c;
    if (!capture_read(path_of(in, frame), &c, errors, sizeof errors))
        fail_msg("%s", errors);
    return c;
}

/* ---- fixtures ---- */

static void write_frame(const capture *c, const char *in, int frame)
{
    if (!capture_write(path_of(in, frame), c, errors, sizeof errors))
        fail_msg("%s", errors);
}

static void make_shot(const char *name, float speed, int frames, int cut_at)
{
    char path[SCRATCH_SIZE + 128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_int_equal(mkdir(path, 0777), 0);
    for (int i = 0; i < frames; i++) {
        capture c;
        assert_true(corner_make(&c, (corner_view){ i, speed }));
        c.cut = i == cut_at;
        c.present |= CAPTURE_HAS_CUT;
        write_frame(&c, name, i);
        capture_destroy(&c);
    }
}

/* Copies frame 0 of the shot `moving` to NAME without a plane (NULL: all of them). */
static void make_single(const char *name, const char *without)
{
    char path[SCRATCH_SIZE + 128];
    capture c = read_frame("moving", 0);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_int_equal(mkdir(path, 0777), 0);
    for (uint32_t i = 0; i < c.plane_count && without; i++)
        if (!strcmp(c.planes[i].name, without))
            strcpy(c.planes[i].name, "nothing");
    write_frame(&c, name, 0);
    capture_destroy(&c);
}

/* The shot `from` with its motion negated. */
static void make_wrong(const char *name, const char *from, int frames)
{
    make_shot(name, 0, 0, -1);
    for (int i = 0; i < frames; i++) {
        float *motion[3];
        capture c = read_frame(from, i);
        assert_true(capture_find_planes(&c, "motion", "XYZ", motion));
        for (int k = 0; k < 3; k++)
            for (size_t p = 0; p < (size_t)c.width * (size_t)c.height; p++) motion[k][p] = -motion[k][p];
        write_frame(&c, name, i);
        capture_destroy(&c);
    }
}

static void truncate_frame(const char *in, int frame)
{
    assert_int_equal(truncate(path_of(in, frame), 9000), 0);
}

static int make_fixtures(void **state)
{
    capture small;
    (void)state;
    if (!scratch_make(folder))
        return -1;
    make_shot("moving", 0.02f, FRAMES, -1);
    make_shot("still", 0, 5, -1);
    make_shot("cut", 0.02f, FRAMES, 6);
    make_shot("broken", 0.02f, 3, -1);
    truncate_frame("broken", 2);
    make_shot("broken_first", 0.02f, 1, -1);
    truncate_frame("broken_first", 0);
    make_shot("fast", 0.2f, 3, -1);
    make_wrong("wrong", "fast", 3);
    make_shot("sizes", 0.02f, 2, -1);
    assert_true(capture_create(&small, 8, 8));
    capture_add_plane(&small, "viewZ", CAPTURE_HALF);
    write_frame(&small, "sizes", 1);
    capture_destroy(&small);
    make_single("no_normals", "normal.Y");
    make_single("no_factor", "diffuseFactor.G");
    make_single("no_specular", "specular.R");
    make_shot("empty", 0, 0, -1);
    return 0;
}

static int remove_fixtures(void **state)
{
    (void)state;
    return scratch_remove(folder) ? 0 : -1;
}

/* ---- misuse ---- */

static void expect_one_line(const char *program, const char *text)
{
    size_t length = strlen(errors);
    if (strncmp(errors, program, strlen(program)) || length < 2 || strchr(errors, '\n') != errors + length - 1 || !strstr(errors, text))
        fail_msg("expected one line of %s with \"%s\", got \"%s\"", program, text, errors);
    assert_string_equal(output, "");
}

static void misuse_gives_one_line_and_leaves_nothing(void **state)
{
    static const char *const cases[][2] = {
        { "", "no --denoiser" },
        { "--denoiser nope moving out", "unknown denoiser nope; known: reference, reblur_diffuse" },
        { "--denoiser reblur_diffuse, moving out", "unknown denoiser ; known:" },
        { "--denoiser reblur_diffuse,reblur_diffuse moving out", "both write diffuse" },
        { "--denoiser reference,reblur_diffuse moving out", "both write diffuse" },
        { "--denoiser", "--denoiser needs a value" },
        { "--denoiser reblur_diffuse", "needs an input and an output" },
        { "--denoiser reblur_diffuse moving", "needs an input and an output" },
        { "--denoiser reblur_diffuse moving out more", "more: unexpected argument" },
        { "--denoiser reblur_diffuse --quick moving out", "--quick: unknown option" },
        { "--denoiser reblur_diffuse --set blur=3 moving out", "unknown setting blur" },
        { "--denoiser reblur_diffuse --set max_blur_radius moving out", "not of the form KEY=VALUE" },
        { "--denoiser reblur_diffuse --set max_blur_radius=61 moving out", "max_blur_radius is 61, allowed is 0..60 px" },
        { "--denoiser reblur_diffuse --set max_blur_radius=3px moving out", "max_blur_radius is 3px" },
        { "--denoiser reblur_diffuse --set return_history_length_instead_of_occlusion=0.5 moving out", "a whole number in 0..1" },
        { "--denoiser reblur_diffuse --set denoising_range=-1 moving out", "denoising_range is -1" },
        { "--denoiser reference --signal light moving out", "light: unknown signal; known: diffuse" },
        { "--denoiser reference --signal shadow moving out", "channel shadow.hitT is missing" },
        { "--denoiser reblur_specular_occlusion moving out", "channel specular.hitT is missing" },
        { "--denoiser reblur_diffuse --frames 3 moving out", "--frames needs A:B" },
        { "--denoiser reblur_diffuse --frames 5:4 moving out", "--frames needs A:B" },
        { "--denoiser reblur_diffuse --frames 10:12 moving out", "holds frames 0..11, asked for 10..12" },
        { "--denoiser reblur_diffuse --device x moving out", "--device needs a number" },
        { "--denoiser reblur_diffuse --device 99 moving out", "device_index is 99" },
        { "--denoiser reblur_diffuse absent out", "absent: cannot open the folder" },
        { "--denoiser reblur_diffuse empty out", "empty: holds no frame" },
        { "--denoiser reblur_diffuse no_normals out", "no_normals/frame.0000.exr: channel normal.Y is missing" },
        { "--denoiser reblur_diffuse broken_first out", "broken_first/frame.0000.exr: corrupt or truncated" },
        { "--denoiser reblur_diffuse moving moving/../moving", "is the input folder" },
        { "--denoiser reblur_diffuse moving moving/frame.0000.exr", "is not a folder" },
        { "--denoiser reblur_diffuse moving absent/out", "cannot create the folder" },
        { "--denoiser reblur_diffuse --csv absent/times.csv moving out", "absent/times.csv: cannot write" },
        { "--check", "--check needs an input folder" },
        { "--check moving out", "--check takes one folder" },
        { "--check absent", "absent: cannot open the folder" },
        { "--check no_normals", "no_normals/frame.0000.exr: channel normal.Y is missing" },
        { "--denoiser reblur_diffuse --overlay", "--overlay needs a value" },
        { "--denoiser reblur_diffuse --overlay absent/out moving out", "absent/out: cannot create the folder" },
        { "--denoiser reblur_diffuse --set validation=2 moving out", "nrd_frame.validation is 2, allowed: 0 to 1" },
        { "--denoiser reblur_diffuse --info --size 0x9", "--size needs WIDTHxHEIGHT" },
        { "--denoiser reblur_diffuse --info moving", "--info takes no folders" },
        { "--denoiser reblur_diffuse --explain moving", "--explain takes no folders" },
        { "--denoiser reblur_diffuse --explain=xml", "--explain=xml: formats are text, json and dot" },
        { "--denoiser reblur_diffuse --absent fog --explain", "fog: --absent needs names, separated by commas, of: diffuse specular motion" },
        { "--denoiser reblur_diffuse --thin half moving out", "half: --thin knows lobes, checkerboard" },
        { "--denoiser reblur_diffuse --thin lobes moving out", "--thin lobes needs radiance and hit distance of both lobes" },
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_not_equal(run("nrd-denoise", "--csv times.csv %s", cases[i][0]), 0);
        expect_one_line("nrd-denoise: ", cases[i][1]);
        assert_false(exists("out"));
        assert_false(exists("times.csv") || exists("times.csv.part"));
    }
}

static void without_vulkan_the_line_says_so(void **state)
{
    (void)state;
    setenv("VK_ICD_FILENAMES", "/nonexistent.json", 1);
    setenv("VK_DRIVER_FILES", "/nonexistent.json", 1);
    int status = run("nrd-denoise", "--denoiser reblur_diffuse moving out");
    expect_one_line("nrd-denoise: ", "cannot open a Vulkan device");
    int explain_status = run("nrd-denoise", "--denoiser reblur_diffuse --explain=json --absent motion --set split_screen=0.5");
    bool explained = strstr(output, "\"name\": \"split screen\", \"kept\": true") && strstr(output, "\"name\": \"IN_MV\", \"kept\": false");
    int info_status = run("nrd-denoise", "--denoiser reblur_diffuse,reference --info --size 640x360");
    unsetenv("VK_ICD_FILENAMES");
    unsetenv("VK_DRIVER_FILES");
    assert_int_not_equal(status, 0);
    assert_false(exists("out"));
    assert_int_equal(explain_status, 0);
    assert_true(explained);
    succeed(info_status);
    assert_non_null(strstr(output, "temporal accumulation"));
    assert_non_null(strstr(output, "MiB"));
    assert_non_null(strstr(output, "max_blur_radius"));
}

static void a_bad_frame_keeps_the_whole_ones_before_it(void **state)
{
    (void)state;
    assert_int_not_equal(run("nrd-denoise", "--denoiser reblur_diffuse --csv times.csv broken out_broken"), 0);
    expect_one_line("nrd-denoise: ", "broken/frame.0002.exr: corrupt or truncated");
    assert_true(exists("out_broken/frame.0000.exr") && exists("out_broken/frame.0001.exr"));
    assert_false(exists("out_broken/frame.0002.exr") || exists("out_broken/frame.0002.exr.part"));
    assert_false(exists("times.csv") || exists("times.csv.part"));

    assert_int_not_equal(run("nrd-denoise", "--denoiser reblur_diffuse sizes out_sizes"), 0);
    expect_one_line("nrd-denoise: ", "sizes/frame.0001.exr: is 8x8, the first frame is 96x64");
}

static void the_other_programs_name_what_is_wrong_too(void **state)
{
    static const char *const cases[][3] = {
        { "nrd-score", "", "no capture given" },
        { "nrd-score", "absent", "absent: cannot open the folder" },
        { "nrd-score", "--from x moving", "--from needs a frame number" },
        { "nrd-score", "--from 40 moving", "holds frames 0..11" },
        { "nrd-score", "moving still more", "unexpected argument more" },
        { "nrd-score", "broken", "broken/frame.0002.exr: corrupt" },
        { "nrd-score", "moving broken", "broken/frame.0002.exr: corrupt" },
        { "nrd-score", "--frames 2 moving", "unknown option --frames" },
        { "nrd-view", "moving a.png", "needs --signal" },
        { "nrd-view", "moving a.png --signal light", "light: unknown signal" },
        { "nrd-view", "moving --signal diffuse a.jpg", "must end in .png" },
        { "nrd-view", "moving --signal shadow a.png", "shadow: the signal is not in the capture" },
        { "nrd-view", "no_factor --signal final --error a.png", "is not in the capture" },
        { "nrd-view", "moving --signal diffuse --frame 99 a.png", "frame.0099.exr: cannot open" },
        { "nrd-view", "moving --signal diffuse absent/a.png", "absent/a.png: cannot write" },
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char program[32];
        snprintf(program, sizeof program, "%s: ", cases[i][0]);
        assert_int_not_equal(run(cases[i][0], "%s", cases[i][1]), 0);
        expect_one_line(program, cases[i][2]);
        assert_false(exists("a.png") || exists("a.png.part"));
    }
}

/* ---- --check and --overlay ---- */

static void good_inputs_pass_the_check_and_wrong_ones_are_named(void **state)
{
    (void)state;
    succeed(run("nrd-denoise", "--check --validate fast"));
    assert_non_null(strstr(output, "MOTION_CAMERA"));
    assert_null(strstr(output, "BROKEN"));
    assert_int_not_equal(run("nrd-denoise", "--check --denoiser reblur_diffuse --validate wrong"), 0);
    assert_non_null(strstr(errors, "wrong: the inputs break"));
    assert_non_null(strstr(output, "BROKEN: motion contradicts the camera's"));
    assert_non_null(strstr(output, "likely: motion is current minus previous: negate it"));
}

static void the_overlay_is_written_beside_the_result_and_with_the_check(void **state)
{
    (void)state;
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse --validate --frames 0:1 --overlay look fast out_look"));
    assert_true(exists("look/validation.0000.png") && exists("look/validation.0001.png") && exists("out_look/frame.0001.exr"));
    succeed(run("nrd-denoise", "--check --frames 1:1 --overlay look_check fast"));
    assert_true(exists("look_check/validation.0001.png"));
    assert_false(exists("look_check/validation.0000.png"));
}

/* ---- results ---- */

static metrics_summary compare(const capture *frame, const capture *denoised, signal_source source)
{
    image m, reference;
    unsigned char mask[PIXELS];
    metrics result;
    assert_true(signal_get(frame, denoised, SIGNAL_DIFFUSE, source, &m));
    assert_true(signal_get(frame, denoised, SIGNAL_DIFFUSE, SOURCE_REFERENCE, &reference));
    signal_mask(frame, SIGNAL_DIFFUSE, mask);
    metrics_scale scale = metrics_scale_of(&reference, mask, false);
    assert_true(metrics_compare(&m, &reference, mask, &scale, &result));
    image_destroy(&m);
    image_destroy(&reference);
    return metrics_summarise(&result);
}

/* The number behind "key": of the part of `output` that follows `after`. */
static double json_number(const char *after, const char *key)
{
    const char *at = strstr(output, after);
    at = at ? strstr(at, key) : NULL;
    if (!at)
        fail_msg("no %s of %s in %s", key, after, output);
    return at ? strtod(at + strlen(key) + 1, NULL) : 0;
}

static void denoising_removes_the_noise_and_keeps_the_picture(void **state)
{
    (void)state;
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse moving out_moving"));
    assert_non_null(strstr(output, "12 frames"));
    capture frame = read_frame("moving", FRAMES - 1), denoised = read_frame("out_moving", FRAMES - 1);
    metrics_summary after = compare(&frame, &denoised, SOURCE_DENOISED), before = compare(&frame, NULL, SOURCE_NOISY);
    print_message("relMSE %.4f -> %.4f, bias %+.4f\n", before.rel_mse, after.rel_mse, after.bias);
    assert_true(before.rel_mse > 2.5 && before.rel_mse < 3.5); /* a sample has variance 3 r^2 */
    assert_true(after.rel_mse < 0.04);
    assert_true(fabs(after.bias) < 0.05);
    assert_int_equal(denoised.present, frame.present);
    assert_memory_equal(denoised.world_to_camera, frame.world_to_camera, sizeof frame.world_to_camera);
    assert_true(denoised.frame_index == FRAMES - 1 && denoised.denoising_range == CORNER_RANGE);
    assert_true(capture_find_plane(&denoised, "denoised.diffuse.G")[0] == CORNER_SKY);
    capture_destroy(&frame);
    capture_destroy(&denoised);
}

static void a_checkerboard_made_of_a_capture_is_denoised(void **state)
{
    (void)state;
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse --thin checkerboard moving out_checkerboard"));
    capture frame = read_frame("moving", FRAMES - 1), half = read_frame("out_checkerboard", FRAMES - 1), full = read_frame("out_moving", FRAMES - 1);
    metrics_summary is = compare(&frame, &half, SOURCE_DENOISED), was = compare(&frame, &full, SOURCE_DENOISED);
    print_message("relMSE of all pixels %.4f, of half of them %.4f\n", was.rel_mse, is.rel_mse);
    assert_true(is.rel_mse != was.rel_mse && is.rel_mse < 1.5 * was.rel_mse);   /* the picture is smooth */
    capture_destroy(&frame);
    capture_destroy(&half);
    capture_destroy(&full);
}

/* Adds a sun and a shadow with a penumbra to a frame of the corner: half as wide as the picture, of an occluder 2 m away. */
static void add_shadow(capture *c, int frame)
{
    float *hit = capture_add_plane(c, "shadow.hitT", CAPTURE_HALF), *truth = capture_add_plane(c, "ref.shadow", CAPTURE_FLOAT);
    assert_true(hit && truth);
    for (int i = 0; i < PIXELS; i++) {
        truth[i] = fminf(fmaxf(2 * (float)(i % CORNER_WIDTH) / CORNER_WIDTH - 0.5f, 0), 1);
        hit[i] = corner_random((uint32_t)i, (uint32_t)frame, 77) < truth[i] ? 65504.0f : 2.0f;
    }
    const float sun[3] = { 0.6f, 0.64f, -0.48f };
    memcpy(c->sun_direction, sun, sizeof sun);
    c->sun_tan_angular_radius = 0.5f;
    c->present |= CAPTURE_HAS_SUN_DIRECTION | CAPTURE_HAS_SUN_TAN_ANGULAR_RADIUS;
}

static void make_shadows(const char *name, uint32_t without)
{
    char path[SCRATCH_SIZE + 128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_int_equal(mkdir(path, 0777), 0);
    for (int i = 0; i < 6; i++) {
        capture c;
        assert_true(corner_make(&c, (corner_view){ i, 0 }));
        add_shadow(&c, i);
        c.present &= ~without;
        write_frame(&c, name, i);
        capture_destroy(&c);
    }
}

static void shadows_are_denoised_alone_and_beside_a_radiance(void **state)
{
    (void)state;
    make_shadows("shadow", 0);
    make_shadows("no_sun", CAPTURE_HAS_SUN_DIRECTION);
    succeed(run("nrd-denoise", "--denoiser sigma_shadow shadow out_shadow"));
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse,sigma_shadow shadow out_both"));
    capture alone = read_frame("out_shadow", 5), both = read_frame("out_both", 5), frame = read_frame("shadow", 5);
    const float *a = capture_find_plane(&alone, "denoised.shadow"), *b = capture_find_plane(&both, "denoised.shadow");
    const float *truth = capture_find_plane(&frame, "ref.shadow"), *hit = capture_find_plane(&frame, "shadow.hitT");
    assert_true(a && b && capture_find_plane(&both, "denoised.diffuse.R"));
    assert_memory_equal(a, b, PIXELS * sizeof *a);
    double error = 0, noise = 0;
    for (int i = PIXELS / 4; i < PIXELS; i++) {   /* below the sky */
        float ray = hit[i] >= 65504 ? 1.0f : 0.0f;
        error += (a[i] - truth[i]) * (a[i] - truth[i]);
        noise += (ray - truth[i]) * (ray - truth[i]);
    }
    print_message("squared error of the shadow: %.5f of the input's\n", error / noise);
    assert_true(error < 0.1 * noise);
    assert_true(run("nrd-denoise", "--denoiser sigma_shadow no_sun out_no_sun") != 0);
    assert_non_null(strstr(errors, "sunDirection"));
    assert_true(run("nrd-denoise", "--denoiser sigma_shadow_translucency shadow out_color") != 0);
    assert_non_null(strstr(errors, "shadow.translucency.R"));
    capture_destroy(&alone);
    capture_destroy(&both);
    capture_destroy(&frame);
}

static void score_prints_what_the_metrics_say(void **state)
{
    double sum[2] = { 0, 0 };
    (void)state;
    for (int i = 0; i < FRAMES; i++) {
        capture frame = read_frame("moving", i), denoised = read_frame("out_moving", i);
        sum[0] += compare(&frame, &denoised, SOURCE_DENOISED).rel_mse / FRAMES;
        sum[1] += compare(&frame, NULL, SOURCE_NOISY).rel_mse / FRAMES;
        capture_destroy(&frame);
        capture_destroy(&denoised);
    }
    succeed(run("nrd-score", "moving out_moving --json"));
    assert_true(fabs(json_number("\"denoised\":{", "\"relMSE\"") - sum[0]) < 1e-5 * sum[0]);
    assert_true(fabs(json_number("\"noisy\":{", "\"relMSE\"") - sum[1]) < 1e-5 * sum[1]);
    assert_true(json_number("\"denoised\":{", "\"frames\"") == FRAMES);
    assert_true(json_number("\"denoised\":{", "\"flicker\"") < 0.25 * json_number("\"noisy\":{", "\"flicker\""));
    assert_true(json_number("\"denoised\":{", "\"nan\"") + json_number("\"denoised\":{", "\"inf\"") == 0);
    succeed(run("nrd-score", "moving out_moving --per-frame --from 3 --to 5"));
    assert_non_null(strstr(output, "3 frames, 3 with a reference"));
    assert_non_null(strstr(output, "frame      4"));
    succeed(run("nrd-view", "moving out_moving --signal diffuse --frame 11 --side-by-side --error --label view.png"));
    assert_true(exists("view.png"));
}

static void the_reference_denoiser_averages(void **state)
{
    (void)state;
    succeed(run("nrd-denoise", "--denoiser reference still out_still"));
    capture frames[5], denoised = read_frame("out_still", 4);
    for (int f = 0; f < 5; f++)
        frames[f] = read_frame("still", f);
    for (int k = 0; k < 3; k++) {
        const char *name = (const char *[]){ "diffuse.R", "diffuse.G", "diffuse.B" }[k];
        char denoised_name[CAPTURE_NAME_SIZE];
        snprintf(denoised_name, sizeof denoised_name, "denoised.%s", name);
        const float *mean = capture_find_plane(&denoised, denoised_name);
        for (int i = 0; i < PIXELS; i++) {
            float expected = 0;
            for (int f = 0; f < 5; f++)
                expected += capture_find_plane(&frames[f], name)[i] / 5;
            if (!(fabsf(mean[i] - expected) <= 1e-3f * expected))
                fail_msg("%s, pixel %d: mean %g, expected %g", name, i, mean[i], expected);
        }
    }
    for (int f = 0; f < 5; f++)
        capture_destroy(&frames[f]);
    capture_destroy(&denoised);
}

static void final_is_composed_with_what_was_not_denoised(void **state)
{
    (void)state;
    capture frame = read_frame("moving", 3), denoised = read_frame("out_moving", 3);
    const float *diffuse = capture_find_plane(&denoised, "denoised.diffuse.R");
    const float *final = capture_find_plane(&denoised, "denoised.final.R");
    const float *diffuse_factor = capture_find_plane(&frame, "diffuseFactor.R");
    const float *specular_factor = capture_find_plane(&frame, "specularFactor.R");
    assert_true(diffuse && final);
    for (int i = 0; i < PIXELS; i++) {
        float expected = diffuse[i] * diffuse_factor[i] + CORNER_SPECULAR * specular_factor[i];
        assert_true(fabsf(final[i] - expected) <= 1e-3f * expected);
    }
    capture_destroy(&frame);
    capture_destroy(&denoised);

    static const char *const incomplete[] = { "no_factor", "no_specular" };
    for (int i = 0; i < 2; i++) {
        succeed(run("nrd-denoise", "--denoiser reblur_diffuse %s out_%s", incomplete[i], incomplete[i]));
        denoised = read_frame(i ? "out_no_specular" : "out_no_factor", 0);
        assert_non_null(capture_find_plane(&denoised, "denoised.diffuse.R"));
        assert_null(capture_find_plane(&denoised, "denoised.final.R"));
        capture_destroy(&denoised);
    }
}

static void ambient_occlusion_is_written_when_it_is_that_of_the_format(void **state)
{
    (void)state;
    capture denoised = read_frame("out_moving", 0);
    assert_null(capture_find_plane(&denoised, "denoised.diffuse.ao"));
    capture_destroy(&denoised);
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse --set hit_distance_b=0 moving out_ao"));
    denoised = read_frame("out_ao", FRAMES - 1);
    const float *ao = capture_find_plane(&denoised, "denoised.diffuse.ao");
    double sum = 0;
    int count = 0;
    assert_non_null(ao);
    for (int i = PIXELS / 2; i < PIXELS; i++, count++)
        sum += ao[i];
    /* mean of min(h / 3, 1) for h uniform in [0.1, 4.1] */
    assert_true(fabs(sum / count - (2.9 * 3.1 / 6 + 1.1) / 4) < 0.02);
    capture_destroy(&denoised);
}

static void hit_distances_of_another_scale_are_no_ambient_occlusion(void **state)
{
    (void)state;
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse_occlusion moving out_hit_dist"));
    capture denoised = read_frame("out_hit_dist", 0);
    assert_non_null(capture_find_plane(&denoised, "denoised.diffuse.hitDist"));
    assert_null(capture_find_plane(&denoised, "denoised.diffuse.ao"));
    capture_destroy(&denoised);
}

/* Error against the noisy input's, and bias, of occlusion on captures that the path tracer makes. */
static void occlusion_of_traced_captures_is_within_bounds(void **state)
{
    static const struct { const char *scene; double ratio; } rows[] = { { "interior", 0.08 }, { "colonnade", 0.05 }, { "thin", 0.17 } };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        succeed(run("nrd-render", "%s traced_%s --size 160x120 --frames 12 --ref 64", rows[i].scene, rows[i].scene));
        succeed(run("nrd-denoise", "--denoiser reblur_diffuse_occlusion --set hit_distance_b=0 traced_%s out_%s", rows[i].scene, rows[i].scene));
        succeed(run("nrd-score", "traced_%s out_%s --json", rows[i].scene, rows[i].scene));
        memmove(output, strstr(output, "\"ao\""), strlen(strstr(output, "\"ao\"")) + 1);
        double error = json_number("\"denoised\":{", "\"relMSEtrimmed\""), noisy = json_number("\"noisy\":{", "\"relMSEtrimmed\"");
        double bias = json_number("\"denoised\":{", "\"bias\"");
        print_message("%s: trimmed relMSE %.4f -> %.4f, bias %+.4f\n", rows[i].scene, noisy, error, bias);
        assert_true(error < rows[i].ratio * noisy);
        assert_true(fabs(bias) < 0.02);
    }
}

/* Captures of the path tracer, as the occlusion test has left them; light that the first bounce brings, so that its direction is known. */
static void own_normals_of_traced_captures_lower_the_error(void **state)
{
    double error[2], bias[2];
    static const char *const names[2] = { "reblur_diffuse", "reblur_diffuse_sh" };
    (void)state;
    succeed(run("nrd-render", "interior traced_sh --size 160x120 --frames 12 --ref 128 --direct bsdf --paths 4"));
    for (int i = 0; i < 2; i++) {
        succeed(run("nrd-denoise", "--denoiser %s traced_sh out_%s", names[i], names[i]));
        succeed(run("nrd-score", "traced_sh out_%s --json", names[i]));
        error[i] = json_number("\"denoised\":{", "\"relMSEtrimmed\"");
        bias[i] = json_number("\"denoised\":{", "\"bias\"");
    }
    print_message("interior: trimmed relMSE %.4f plain, %.4f under own normals; bias %+.4f, %+.4f\n", error[0], error[1], bias[0], bias[1]);
    assert_true(error[1] < error[0]);
    assert_true(fabs(bias[1] - bias[0]) < 0.02);
}

static void directions_that_are_missing_are_named(void **state)
{
    (void)state;
    assert_int_not_equal(run("nrd-denoise", "--denoiser reblur_diffuse_sh moving out_no_directions"), 0);
    assert_non_null(strstr(errors, "channel diffuse.dir.X is missing"));
    assert_false(exists("out_no_directions"));
}

static void a_cut_forgets_the_history(void **state)
{
    (void)state;
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse cut out_cut"));
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse --frames 6:11 moving out_late"));
    assert_false(exists("out_late/frame.0005.exr"));
    for (int i = 6; i < FRAMES; i++) {
        capture a = read_frame("out_cut", i), b = read_frame("out_late", i);
        const float *x = capture_find_plane(&a, "denoised.diffuse.R"), *y = capture_find_plane(&b, "denoised.diffuse.R");
        assert_memory_equal(x, y, PIXELS * sizeof(float));
        capture_destroy(&a);
        capture_destroy(&b);
    }
}

static void settings_reach_the_denoiser(void **state)
{
    (void)state;
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse --set reblur_diffuse.max_accumulated_frames=0 --set max_blur_radius=0"
                " --set antilag_sensitivity=0 --set max_stabilized_frames=0 moving out_off"));
    capture frame = read_frame("moving", FRAMES - 1), off = read_frame("out_off", FRAMES - 1), on = read_frame("out_moving", FRAMES - 1);
    assert_true(compare(&frame, &off, SOURCE_DENOISED).rel_mse > 3 * compare(&frame, &on, SOURCE_DENOISED).rel_mse);
    capture_destroy(&frame);
    capture_destroy(&off);
    capture_destroy(&on);
}

static void the_times_of_every_pass_are_written(void **state)
{
    char text[8192];
    int rows = 0, last_frame = -1;
    (void)state;
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse --frames 0:2 --csv times.csv moving out_timed"));
    load_text("times.csv", text, sizeof text);
    assert_false(exists("times.csv.part"));
    char *line = strtok(text, "\n");
    assert_string_equal(line, "frame,pass,milliseconds");
    while ((line = strtok(NULL, "\n"))) {
        int frame;
        char pass[64];
        double milliseconds;
        assert_int_equal(sscanf(line, "%d,%63[^,],%lf", &frame, pass, &milliseconds), 3);
        assert_true(frame >= last_frame && frame <= 2 && milliseconds >= 0 && milliseconds < 60000);
        last_frame = frame;
        rows++;
    }
    if (rows) { /* a queue without timestamps has none */
        assert_int_equal(last_frame, 2);
        assert_int_equal(rows % 3, 0);
    }
}

static void the_validation_layers_have_nothing_to_say(void **state)
{
    (void)state;
    if (!gpu_validation_available())
        skip();
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse,reference --signal specular --validate --frames 0:3 moving out_valid"));
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse_specular_sh --validate --frames 0:3 --set diffuse_prepass_blur_radius=8"
                " --set specular_prepass_blur_radius=8 --set split_screen=0.3 traced_sh out_valid_sh"));
    succeed(run("nrd-denoise", "--denoiser reblur_diffuse_sh,reblur_specular_sh --validate --frames 0:3 --thin checkerboard traced_sh out_valid_sh_two"));
    capture denoised = read_frame("out_valid", 3);
    assert_true(capture_find_plane(&denoised, "denoised.diffuse.R") && capture_find_plane(&denoised, "denoised.specular.R"));
    assert_true(fabsf(capture_find_plane(&denoised, "denoised.specular.R")[PIXELS - 1] - CORNER_SPECULAR) < 1e-3f);
    capture_destroy(&denoised);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(misuse_gives_one_line_and_leaves_nothing),
        cmocka_unit_test(without_vulkan_the_line_says_so),
        cmocka_unit_test(a_bad_frame_keeps_the_whole_ones_before_it),
        cmocka_unit_test(the_other_programs_name_what_is_wrong_too),
        cmocka_unit_test(good_inputs_pass_the_check_and_wrong_ones_are_named),
        cmocka_unit_test(the_overlay_is_written_beside_the_result_and_with_the_check),
        cmocka_unit_test(denoising_removes_the_noise_and_keeps_the_picture),
        cmocka_unit_test(a_checkerboard_made_of_a_capture_is_denoised),
        cmocka_unit_test(shadows_are_denoised_alone_and_beside_a_radiance),
        cmocka_unit_test(score_prints_what_the_metrics_say),
        cmocka_unit_test(the_reference_denoiser_averages),
        cmocka_unit_test(final_is_composed_with_what_was_not_denoised),
        cmocka_unit_test(ambient_occlusion_is_written_when_it_is_that_of_the_format),
        cmocka_unit_test(hit_distances_of_another_scale_are_no_ambient_occlusion),
        cmocka_unit_test(occlusion_of_traced_captures_is_within_bounds),
        cmocka_unit_test(own_normals_of_traced_captures_lower_the_error),
        cmocka_unit_test(directions_that_are_missing_are_named),
        cmocka_unit_test(a_cut_forgets_the_history),
        cmocka_unit_test(settings_reach_the_denoiser),
        cmocka_unit_test(the_times_of_every_pass_are_written),
        cmocka_unit_test(the_validation_layers_have_nothing_to_say),
    };
    return cmocka_run_group_tests(tests, make_fixtures, remove_fixtures);
}
