/* nrd-report: what it writes, that it resumes, and that its page works in a browser. Expects nrd-report in the folder that
   the environment variable NRD_BUILD names (build). */
#define _XOPEN_SOURCE 700
#define _DEFAULT_SOURCE
#define NRD_IMPLEMENTATION
#include "nrd.h"

#include "browser.h"
#include "common/gpu.h"
#include "common/scratch.h"
#include "common/traffic.h"
#include "report/copier.h"
#include "report/front.h"
#include "report/parallel.h"
#include "report/statistics.h"
#include "report/tuning.h"

#include <png.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <sys/stat.h>

#include <cmocka.h>

#define TINY "--scenes moving --denoisers reblur_diffuse,reference --presets fastest,balanced --paths 1 --sizes 96x54 --ref 8 --frames 4,4,3 --pairs 1 --repeats 25"

static char folder[SCRATCH_SIZE];
static char text[1 << 20];

/* Runs nrd-report in the test's folder; output and errors go to files there. */
static int run(const char *arguments)
{
    char command[2048];
    const char *build = getenv("NRD_BUILD");
    snprintf(command, sizeof command, "%s/nrd-report %s >%s/output 2>%s/errors", build ? build : "build", arguments, folder, folder);
    return system(command);
}

static const char *load(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    return text;
}

static int count(const char *in, const char *what)
{
    int n = 0;
    for (; (in = strstr(in, what)); in += strlen(what))
        n++;
    return n;
}

static int run_tiny(const char *more)
{
    char arguments[1024];
    snprintf(arguments, sizeof arguments, "%s/out " TINY " %s", folder, more);
    return run(arguments);
}

static int measure_once(void **state)
{
    (void)state;
    if (!scratch_make(folder))
        return -1;
    if (run_tiny("") == 0)
        return 0;
    fprintf(stderr, "%s", load("errors"));
    return -1;
}

static int clean_up(void **state)
{
    (void)state;
    return scratch_remove(folder) ? 0 : -1;
}

/* The value of a column in the first CSV line that contains `key`; NaN when empty. */
static double cell(const char *key, const char *column)
{
    const char *header = load("out/report.csv"), *line = strstr(header, key), *at = strstr(header, column);
    int index = 0, length = 0;
    double value = NAN;
    assert_non_null(line);
    assert_non_null(at);
    for (const char *c = header; c < at; c++)
        index += *c == ',';
    while (line > header && line[-1] != '\n')
        line--;
    line = strchr(line + 1, '"'); /* behind the device's name, which may hold commas */
    for (; index > 0; line++)
        index -= *line == ',';
    return sscanf(line, "%lf%n", &value, &length) == 1 && length ? value : NAN;
}

static void every_method_and_baseline_is_a_row(void **state)
{
    (void)state;
    const char *csv = load("out/report.csv");
    /* noisy; two presets of reblur_diffuse, a filter and paths for one of them; reference */
    assert_int_equal(count(csv, "\n"), 1 + 6);
    assert_int_equal(count(csv, ",denoiser,"), 1 + 3); /* one is a column's name */
    assert_int_equal(count(csv, ",noisy,"), 1);
    assert_int_equal(count(csv, ",spatial,"), 1);
    assert_int_equal(count(csv, ",more paths,"), 1);
    assert_int_equal(count(load("out/report.json"), "\"signal\":\"diffuse\""), 6);
}

static void add_to_front(report *r, const char *scene, const char *preset, const char *signal, double ms, double error)
{
    report_row *row = rows_add(&r->rows);
    assert_non_null(row);
    strcpy(row->scene, scene);
    strcpy(row->kind, REPORT_KIND_DENOISER);
    strcpy(row->method, "reblur_diffuse");
    strcpy(row->preset, preset);
    strcpy(row->signal, signal);
    row->width = row->height = 64;
    row->paths.count = 1;
    row->values[REPORT_ms] = ms;
    row->values[REPORT_motion_trimmed] = error;
}

/* Means are geometric; a row is beaten by one that is as fast and better, or as good and faster, beyond noise. */
static void the_front_is_what_nothing_beats(void **state)
{
    static report r;
    static front_row rows[FRONT_MAX];
    (void)state;
    r.options = (report_options){ .path_count = 2, .paths = { { 4, false }, { 1, false } }, .size_count = 1, .sizes = { { 64, 64 } } };
    add_to_front(&r, "a", "balanced", "diffuse", 4, 0.1);
    add_to_front(&r, "b", "balanced", "diffuse", 9, 0.4);
    add_to_front(&r, "a", "balanced", "final", 100, 100); /* contains the others */
    add_to_front(&r, "a", "fastest", "diffuse", 1, 0.5);
    add_to_front(&r, "b", "fastest", "diffuse", 1, 0.5);
    add_to_front(&r, "a", "slow", "diffuse", 7, 0.2);
    add_to_front(&r, "b", "slow", "diffuse", 7, 0.2);
    add_to_front(&r, "a", "same", "diffuse", 6.03, 0.201);
    add_to_front(&r, "b", "same", "diffuse", 6.03, 0.201);
    add_to_front(&r, "a", "lonely", "diffuse", 0.5, 0.01); /* not measured on b */
    assert_int_equal(front_find(&r, rows), 5);
    static const char *const order[] = { "lonely", "fastest", "balanced", "same", "slow" };
    for (int i = 0; i < 5; i++)
        assert_string_equal(rows[i].preset, order[i]);
    assert_true(fabs(rows[2].ms - 6) < 1e-9 && fabs(rows[2].error - 0.2) < 1e-9);
    for (int i = 0; i < 4; i++)
        assert_int_equal(rows[i].beaten_by, -1);
    assert_int_equal(rows[4].beaten_by, 2);
    free(r.rows.rows);
}

/* Within a share of what is expected. */
static void near(double value, double expected, double share)
{
    if (!(fabs(value - expected) <= share * fabs(expected)))
        fail_msg("%g, expected %g", value, expected);
}

static void numbers_are_plausible(void **state)
{
    (void)state;
    double noisy = cell(",noisy,", "motion_trimmed"), denoised = cell("reblur_diffuse,balanced", "motion_trimmed");
    assert_true(denoised > 0 && denoised < 0.5 * noisy);
    assert_true(cell("reblur_diffuse,balanced", "rest_flicker") < cell(",noisy,", "rest_flicker"));
    assert_true(cell("reblur_diffuse,fastest", "ms,") < cell("reblur_diffuse,balanced", "ms,"));
    assert_true(cell("reblur_diffuse,fastest", "bytes_per_pixel") < cell("reblur_diffuse,balanced", "bytes_per_pixel"));
    assert_true(cell("reblur_diffuse,balanced", "bytes_per_pixel") > 100);
    assert_true(cell("reblur_diffuse,balanced", "permanent_bytes") > 96 * 54 * 10);
    double share = cell("reblur_diffuse,balanced", "copy_share"), rate = cell("reblur_diffuse,balanced", "copy_rate");
    assert_true(share > 0 && share < 1);
    near(cell("reblur_diffuse,balanced", "bytes_per_pixel") * 96 * 54 / (rate * 1e6), share * cell("reblur_diffuse,balanced", "ms,"), 1e-3);
    assert_true(cell("more paths,", "paths_traced") > 1);
    assert_true(cell(",noisy,", "lag") == 0);          /* it is as bright as the light at once */
    assert_true(fabs(cell(",noisy,", "motion_bias")) < 0.1);
    assert_true(cell("reference,balanced", "motion_flip") >= 0);
}

/* Rows of 54 pixels' 7 rows of tiles that are not all under the sky; a denoiser that leaves them out, and one that does not. */
static void time_is_measured_against_the_share_of_active_tiles(void **state)
{
    static const double active[] = { 1, 6 / 7.0, 4 / 7.0, 2 / 7.0, 0 };
    double ms[2][5];
    (void)state;
    const char *at = strchr(load("out/tiles.csv"), '\n');
    assert_int_equal(count(text, "\n"), 1 + 2 * 5);
    for (int i = 0; i < 10; i++) {
        char denoiser[64];
        double sky, share, low, high, *m = &ms[i % 2][i / 2];
        at = strstr(at, "\",") + 2;
        assert_int_equal(sscanf(at, "%63[^,],96,54,%lf,%lf,%lf,%lf,%lf", denoiser, &sky, &share, m, &low, &high), 6);
        assert_string_equal(denoiser, i % 2 ? "reference" : "reblur_diffuse");
        assert_true(sky == i / 2 / 4.0 && low <= *m && *m <= high);
        near(share, active[i / 2], 1e-5);
    }
    assert_true(ms[0][4] < 0.3 * ms[0][0]);
    assert_true(ms[1][4] > 0.3 * ms[1][0]);
    assert_int_equal(count(load("out/report.json"), "\"active\":"), 10);
    assert_non_null(strstr(load("output"), "time against the share of active tiles"));
}

static void a_second_run_measures_nothing_again(void **state)
{
    static char before[sizeof text];
    (void)state;
    strcpy(before, load("out/report.csv"));
    assert_int_equal(run_tiny(""), 0);
    assert_int_equal(count(load("errors"), "rows in"), 0);
    assert_null(strstr(text, "active tiles"));
    assert_string_equal(load("out/report.csv"), before); /* times included: nothing has been measured */
}

static void half_written_and_other_groups_are_measured_again(void **state)
{
    char path[256];
    (void)state;
    snprintf(path, sizeof path, "%s/out/parts/moving_96x54_1.txt", folder);
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(truncate(path, info.st_size / 2), 0);
    assert_int_equal(run_tiny(""), 0);
    assert_int_equal(count(load("errors"), "rows in"), 1);
    assert_int_equal(run_tiny("--variant short:max_accumulated_frames=2"), 0);
    assert_int_equal(count(load("errors"), "rows in"), 1);
    assert_int_equal(count(load("out/report.csv"), "reblur_diffuse,short"), 1);
    assert_int_equal(run_tiny("--time-size 128x72"), 0);
    assert_true(cell("reblur_diffuse,balanced", "width") == 96 && cell("reblur_diffuse,balanced", "time_width") == 128);
    assert_true(cell("reblur_diffuse,balanced", "ns_per_pixel") > 0 && cell("reblur_diffuse,balanced", "permanent_bytes") > 128 * 72 * 10);
    assert_int_equal(run_tiny(""), 0);
}

/* The value of a column in the row of a denoiser, or of the noisy input of a signal. paths: "number,is a checkerboard". */
static double cell_of(const char *scene, const char *paths, const char *row, const char *column)
{
    char key[256];
    snprintf(key, sizeof key, "%s,64,36,64,36,%s,%s", scene, paths, row);
    return cell(key, column);
}

static void check_signal(const char *scene, const char *paths, const char *denoiser, const char *signal)
{
    char noisy[128], denoised[128];
    snprintf(noisy, sizeof noisy, "noisy,,,%s,", signal);
    snprintf(denoised, sizeof denoised, "denoiser,%s,balanced,%s,", denoiser, signal);
    double before = cell_of(scene, paths, noisy, "motion_trimmed"), after = cell_of(scene, paths, denoised, "motion_trimmed");
    if (!(after > 0 && after < 0.7 * before))
        fail_msg("%s, %s paths: %s %g, noisy %g", scene, paths, denoiser, after, before);
    if (!(fabs(cell_of(scene, paths, noisy, "motion_bias")) < 0.06 && fabs(cell_of(scene, paths, denoised, "motion_bias")) < 0.06))
        fail_msg("%s, %s paths: bias of %s", scene, paths, denoiser);
}

/* Occlusion is scored as the denoisers' own settings normalise it, with and without paths left out; coloured shadows where there is
   glass, and there nothing but shadows. */
static void occlusion_and_coloured_shadows_are_scored(void **state)
{
    char arguments[512];
    (void)state;
    snprintf(arguments, sizeof arguments, "%s/out --scenes interior,glass --denoisers reblur_diffuse_occlusion,reblur_specular_occlusion,sigma_shadow_translucency"
             " --presets balanced --paths 0.5,2 --sizes 64x36 --ref 32 --frames 6,2,0 --pairs 1 --repeats 1", folder);
    assert_int_equal(run(arguments), 0);
    check_signal("interior", "0.5,0", "reblur_diffuse_occlusion", "ao");
    check_signal("interior", "0.5,0", "reblur_specular_occlusion", "specular_ao");
    check_signal("glass", "0.5,0", "sigma_shadow_translucency", "translucency");
    assert_int_equal(count(load("out/report.csv"), "\",glass,"), 5);
    assert_int_equal(count(text, "denoiser,reference,"), 2); /* a baseline, though it was not named */
    assert_int_equal(count(text, ",2,0,denoiser,reblur"), 0); /* several paths have no mean occlusion in a capture */
    assert_int_equal(run_tiny(""), 0);
}

/* Denoisers take the half-wide inputs; those with directions take none, and are left out. */
static void checkerboards_are_denoised_as_such(void **state)
{
    char arguments[512];
    (void)state;
    snprintf(arguments, sizeof arguments, "%s/out --scenes interior --denoisers reblur_diffuse,reblur_specular_occlusion,reblur_diffuse_sh,reference"
             " --presets balanced --paths 0.5c,0.25c --sizes 64x36 --ref 32 --frames 6,2,0 --pairs 1 --repeats 1", folder);
    assert_int_equal(run(arguments), 0);
    check_signal("interior", "0.5,1", "reblur_diffuse", "diffuse");
    check_signal("interior", "0.5,1", "reblur_specular_occlusion", "specular_ao");
    check_signal("interior", "0.25,1", "reblur_diffuse", "diffuse");
    assert_int_equal(count(load("out/report.csv"), "reblur_diffuse_sh"), 0);
    assert_int_equal(count(text, "denoiser,reference,"), 3); /* occlusion of half of a checkerboard cannot be averaged */
    assert_true(cell_of("interior", "0.25,1", "more paths,reblur_diffuse,", "paths_traced") > 0.25);
    assert_int_equal(run_tiny(""), 0);
}

static void misuse_is_named(void **state)
{
    static const struct { const char *arguments, *message; } cases[] = {
        { "x --scenes nowhere", "--scenes: 'nowhere' is no scene" },
        { "x --paths 1.5", "--paths: '1.5' is not in [0.05, 1]" },
        { "x --paths 1c", "--paths: '1c' is not in [0.05, 1] (with c: [0.05, 0.5])" },
        { "x --sizes 8x8", "--sizes: '8x8' is not WxH" },
        { "x --frames 1,1,1", "--frames: '1,1,1' is not M,R,L" },
        { "x --denoisers sigma_shadow,sigma_shadow", "--denoisers: 'sigma_shadow' is named twice" },
        { "x --presets fast,fast", "--presets: 'fast' is no preset, or named twice" },
        { "x --denoisers none", "--denoisers: 'none' is no denoiser" },
        { "x --pairs 9 --frames 4,2,2", "--pairs: 9 pairs do not fit into 4 frames" },
        { "x --frames", "--frames: value missing" },
        { "x y", "'y': one folder is enough" },
        { "--quick", "no output folder given" },
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_not_equal(run(cases[i].arguments), 0);
        if (!strstr(load("errors"), cases[i].message) || count(text, "\n") != 1)
            fail_msg("%s: %s", cases[i].arguments, text);
    }
}

static void the_page_needs_no_network(void **state)
{
    (void)state;
    const char *page = load("out/report.html");
    assert_non_null(strstr(page, "data:image/png;base64,iVBOR"));
    assert_int_equal(count(page, "http"), count(page, "http://www.w3.org/2000/svg"));
    assert_int_equal(count(page, "src=\""), 0);
    assert_int_equal(count(page, "@import"), 0);
}

static int distinct_colours(const unsigned char *rgb, size_t pixels)
{
    unsigned char seen[4096] = { 0 };
    int distinct = 0;
    for (size_t i = 0; i < pixels; i++) {
        unsigned char *mark = &seen[rgb[3 * i] >> 4 | (rgb[3 * i + 1] >> 4) << 4 | (rgb[3 * i + 2] >> 4) << 8];
        distinct += !*mark;
        *mark = 1;
    }
    return distinct;
}

static size_t from_base64(const char *in, unsigned char *out)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned bits = 0, held = 0;
    size_t n = 0;
    for (const char *digit; *in && (digit = strchr(digits, *in)); in++) {
        held = held << 6 | (unsigned)(digit - digits);
        bits += 6;
        if (bits >= 8)
            out[n++] = (unsigned char)(held >> (bits -= 8));
    }
    return n;
}

static void check_screenshot(browser *b)
{
    png_image picture = { .version = PNG_IMAGE_VERSION };
    assert_true(browser_call(b, "Page.captureScreenshot", "{\"format\":\"png\"}"));
    char *data = strstr(b->reply, "\"data\":\"");
    assert_non_null(data);
    unsigned char *bytes = malloc(strlen(data));
    size_t size = from_base64(data + 8, bytes);
    assert_true(png_image_begin_read_from_memory(&picture, bytes, size));
    picture.format = PNG_FORMAT_RGB;
    unsigned char *rgb = malloc(PNG_IMAGE_SIZE(picture));
    assert_true(png_image_finish_read(&picture, NULL, rgb, 0, NULL));
    assert_true(picture.width >= 1000 && picture.height >= 700);
    assert_true(distinct_colours(rgb, (size_t)picture.width * picture.height) > 12);
    free(rgb);
    free(bytes);
}

static void expect(browser *b, const char *expression, const char *expected)
{
    char value[256];
    browser_evaluate(b, expression, value, sizeof value);
    if (strcmp(value, expected))
        fail_msg("%s: '%s', expected '%s'", expression, value, expected);
}

/* In a copy of the files that it writes. */
static void what_is_measured_is_published(void **state)
{
    char command[1024], row[128];
    (void)state;
    snprintf(command, sizeof command, "mkdir -p %s/repository/examples && cp README.md nrd.h %s/repository && cp -R examples/report %s/repository/examples && cd %s/repository && "
             "sh examples/report/publish.sh take ../out > ../output 2> ../errors", folder, folder, folder, folder);
    assert_int_equal(system(command), 0);
    snprintf(row, sizeof row, "| reblur_diffuse balanced | %.4g |", cell("reblur_diffuse,balanced", "ms,"));
    assert_int_equal(count(load("repository/README.md"), row), 1);
    assert_int_equal(count(text, "\nNVIDIA H200, times at"), 1); /* other devices' rows stay */
    assert_int_equal(count(load("repository/nrd.h"), ", CPU,"), 3);
    assert_int_equal(count(text, "NRDI_COST(REBLUR_DIFFUSE, FASTEST, CPU,"), 1);
    assert_int_equal(count(load("repository/examples/report/published_tiles.txt"), "|96x54|"), 10);
    assert_true(count(load("repository/examples/report.svg"), "<circle") > 6);
}

/* A tuning whose values are kept in the report's folder is shown, before and after. */
static void what_was_tuned_is_shown(void **state)
{
    static report r;
    static tuning_result t = { "reblur_diffuse", 9, 40, { { "before", "moving", 0.5, { 1, 2, 3, 4, 5, 6 } }, { "after", "moving", 0.25, { 1, 2, 3, 4, 5, 6 } } }, 2,
                               { { "max_blur_radius", 15, 12 } }, 1 };
    char out[160];
    (void)state;
    snprintf(out, sizeof out, "%s/out", folder);
    r.options.folder = out;
    assert_true(tuning_save(&r, &t));
    assert_int_equal(run_tiny(""), 0);
    assert_int_equal(count(load("errors"), "rows in"), 0);
    assert_non_null(strstr(load("output"), "max_blur_radius: 15 -> 12"));
    assert_non_null(strstr(text, "front of error against time"));
    assert_non_null(strstr(load("out/report.json"), "\"changes\":[{\"name\":\"max_blur_radius\",\"before\":15,\"after\":12}]"));
    assert_non_null(strstr(load("out/report.html"), "\"max_blur_radius\""));
}

/* Everything is drawn; pointing at a mark shows its row, clicking it marks it, another click selects another error. */
static void the_page_works_in_a_browser(void **state)
{
    const char *program = browser_program();
    char page[256], place[64];
    double x, y;
    browser b;
    (void)state;
    if (!program) {
        print_message("Chromium is not installed (apt-get install chromium)\n");
        skip();
    }
    snprintf(page, sizeof page, "%s/out/report.html", folder);
    if (!browser_open(&b, program, folder, page))
        fail_msg("%s does not open the page", program);
    expect(&b, "String(document.querySelectorAll('#rows tbody tr').length)", "6");
    expect(&b, "String(document.querySelectorAll('#front .mark').length)", "5");
    expect(&b, "String(document.querySelector('#pareto').points.length > 0)", "true");
    expect(&b, "String(document.querySelectorAll('#passes .bar').length)", "3");
    expect(&b, "String(document.querySelectorAll('#curves polyline').length >= 5)", "true");
    expect(&b, "String([...document.images].filter(i => i.naturalWidth == 96).length)", "8");
    expect(&b, "String(document.querySelectorAll('#tunings tbody tr').length)", "2");
    expect(&b, "String(document.querySelectorAll('#memory tbody tr').length)", "3");
    expect(&b, "String(document.querySelectorAll('#tiles polyline').length)", "2");
    expect(&b, "String(document.querySelectorAll('#tiles circle').length)", "10");
    expect(&b, "String(document.querySelectorAll('#tile_times tbody td').length)", "12");
    browser_evaluate(&b, "(() => { const m = document.querySelector('circle.mark').getBoundingClientRect();"
                         " return (m.left + m.width / 2) + ' ' + (m.top + m.height / 2); })()", place, sizeof place);
    assert_int_equal(sscanf(place, "%lf %lf", &x, &y), 2);
    assert_true(browser_mouse(&b, "mouseMoved", x, y));
    expect(&b, "getComputedStyle(document.querySelector('#tip')).display + String(document.querySelector('#tip').textContent.includes(' ms '))", "blocktrue");
    assert_true(browser_click(&b, x, y));
    expect(&b, "String(document.querySelectorAll('#front .mark.chosen').length)", "1");
    expect(&b, "String(document.querySelectorAll('#rows tr.chosen').length)", "1");
    check_screenshot(&b);
    browser_evaluate(&b, "(() => { const m = document.querySelector('[data-value=rest_flicker]').getBoundingClientRect();"
                         " return (m.left + 5) + ' ' + (m.top + 5); })()", place, sizeof place);
    assert_int_equal(sscanf(place, "%lf %lf", &x, &y), 2);
    assert_true(browser_click(&b, x, y));
    expect(&b, "state.error", "rest_flicker");
    browser_close(&b);
}

/* ---- parts ---- */

static void quantiles_lie_between_sorted_values(void **state)
{
    double odd[] = { 5, 1, 3 }, even[] = { 4, 1, 3, 2 }, one[] = { 7 };
    (void)state;
    assert_true(quantile(odd, 3, 0.5) == 3 && quantile(odd, 3, 0.25) == 2 && quantile(odd, 3, 1) == 5);
    assert_true(quantile(even, 4, 0.5) == 2.5);
    assert_true(quantile(one, 1, 0.9) == 7);
    assert_true(isnan(quantile(one, 0, 0.5)));
}

/* FNV-1a as its authors give it for "foobar". */
static void fingerprints_are_fnv_1a(void **state)
{
    (void)state;
    assert_true(fingerprint(FINGERPRINT_START, "foobar", 6) == 0x85944171f73967e8u);
    assert_true(fingerprint(fingerprint(FINGERPRINT_START, "foo", 3), "bar", 3) == 0x85944171f73967e8u);
}

static bool count_visit(void *user, int i)
{
    ((int *)user)[i]++;
    return true;
}

static bool fail_at_40(void *user, int i)
{
    ((int *)user)[i]++;
    return i != 40;
}

static void every_piece_of_work_is_done_once_until_one_fails(void **state)
{
    int visits[1000] = { 0 };
    (void)state;
    assert_true(parallel_each(1000, count_visit, visits));
    for (int i = 0; i < 1000; i++)
        assert_int_equal(visits[i], 1);
    assert_true(parallel_each(0, count_visit, visits));
    memset(visits, 0, sizeof visits);
    assert_false(parallel_each(1000, fail_at_40, visits));
    assert_int_equal(visits[40], 1);
}

enum { COPY_WORDS = 5000 };

/* Copies between a buffer of the device and one that the host sees. */
static double bytes_of_test_image(const void *user, nrd_resource resource)
{
    const double *bytes = user;
    return resource == NRD_RESOURCE_IN_VIEWZ ? bytes[0] : bytes[1];
}

/* Passes of a frame: the first binds IN_VIEWZ twice and writes OUT_SIGNAL, which the second writes again, before the third reads it
   and writes it anew, for the application. */
static void bytes_are_counted_as_passes_touch_them(void **state)
{
    static const nrd_binding bound[] = {
        { NRD_RESOURCE_IN_VIEWZ, 0, NRD_ACCESS_READ, false, false }, { NRD_RESOURCE_IN_VIEWZ, 0, NRD_ACCESS_READ_LINEAR, false, false },
        { NRD_RESOURCE_OUT_SIGNAL, 0, NRD_ACCESS_WRITE, false, false }, { NRD_RESOURCE_OUT_SIGNAL, 0, NRD_ACCESS_READ, false, false },
    };
    const double bytes[2] = { 4, 100 };
    nrd_dispatch passes[3];
    (void)state;
    memset(passes, 0, sizeof passes);
    for (int i = 0; i < 3; i++) {
        passes[i].bindings = bound + (i == 0 ? 0 : 2);
        passes[i].binding_count = i == 0 ? 3 : i == 1 ? 1 : 2;
    }
    assert_true(traffic_bytes(NULL, passes, 1, bytes_of_test_image, bytes) == 104);
    assert_true(traffic_bytes(NULL, passes, 2, bytes_of_test_image, bytes) == 104);
    assert_true(traffic_bytes(NULL, passes, 3, bytes_of_test_image, bytes) == 304);
}

static void move_buffer(gpu *g, const gpu_buffer *from, const gpu_buffer *to)
{
    const VkBufferCopy all = { 0, 0, COPY_WORDS * 16 };
    assert_non_null(gpu_begin(g));
    g->fn.vkCmdCopyBuffer(g->cmd, from->buffer, to->buffer, 1, &all);
    assert_true(gpu_submit_and_wait(g));
}

/* Copies `words` of 16 bytes over zeros; true when these and no others arrive. */
static bool copies_exactly(copier *c, copier_way way, gpu_buffer *seen, uint32_t words)
{
    static float texels[2048 * ((COPY_WORDS + 2047) / 2048) * 4], zeros[sizeof texels / sizeof *texels];
    uint32_t wrong = 0;
    double ms;
    float *mapped = seen->mapped, *got = way == COPIER_IMAGES ? texels : mapped;
    for (size_t i = 0; i < sizeof texels / sizeof *texels; i++)
        texels[i] = (float)i + 1;
    memset(mapped, 0, COPY_WORDS * 16);
    move_buffer(c->g, seen, &c->to);
    memcpy(mapped, texels, COPY_WORDS * 16);
    move_buffer(c->g, seen, &c->from);
    assert_true(gpu_upload(c->g, &c->image_from, texels) && gpu_upload(c->g, &c->image_to, zeros));
    assert_true(copier_run(c, way, 32.0 * words, &ms) && ms > 0);
    move_buffer(c->g, &c->to, seen);
    assert_true(gpu_download(c->g, &c->image_to, texels));
    for (uint32_t i = 0; i < 4 * COPY_WORDS; i++)
        wrong += got[i] != (i < 4 * words ? (float)i + 1 : 0);
    return wrong == 0;
}

static void copies_move_all_bytes_in_every_way(void **state)
{
    gpu g;
    copier c;
    gpu_buffer seen;
    char reason[256];
    const gpu_desc device = { .device_index = 0 };
    (void)state;
    assert_true(gpu_open(&g, &device, reason, sizeof reason));
    assert_true(copier_open(&c, &g, 32.0 * COPY_WORDS));
    assert_true(gpu_buffer_create(&g, COPY_WORDS * 16, VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, &seen));
    for (int way = 0; way < COPIER_WAY_COUNT; way++)
        for (uint32_t words = 1; words <= COPY_WORDS; words = words < 1025 ? words + 512 : words + 3975)
            if (!copies_exactly(&c, (copier_way)way, &seen, words))
                fail_msg("%s: %u words", copier_way_name((copier_way)way), words);
    double once = 0, often = 0;
    assert_true(copier_run(&c, COPIER_BUFFERS, 32.0 * COPY_WORDS, &once) && copier_run(&c, COPIER_BUFFERS, 400 * 32.0 * COPY_WORDS, &often));
    assert_true(often > 4 * once); /* more than fits is copied in pieces */
    gpu_buffer_destroy(&g, &seen);
    copier_close(&c);
    gpu_close(&g);
}

int main(void)
{
    gpu g;
    char reason[256];
    const gpu_desc device = { .device_index = 0 };
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quantiles_lie_between_sorted_values),
        cmocka_unit_test(fingerprints_are_fnv_1a),
        cmocka_unit_test(every_piece_of_work_is_done_once_until_one_fails),
        cmocka_unit_test(the_front_is_what_nothing_beats),
        cmocka_unit_test(bytes_are_counted_as_passes_touch_them),
        cmocka_unit_test(copies_move_all_bytes_in_every_way),
        cmocka_unit_test(every_method_and_baseline_is_a_row),
        cmocka_unit_test(numbers_are_plausible),
        cmocka_unit_test(time_is_measured_against_the_share_of_active_tiles),
        cmocka_unit_test(a_second_run_measures_nothing_again),
        cmocka_unit_test(what_was_tuned_is_shown),
        cmocka_unit_test(half_written_and_other_groups_are_measured_again),
        cmocka_unit_test(occlusion_and_coloured_shadows_are_scored),
        cmocka_unit_test(checkerboards_are_denoised_as_such),
        cmocka_unit_test(misuse_is_named),
        cmocka_unit_test(what_is_measured_is_published),
        cmocka_unit_test(the_page_needs_no_network),
        cmocka_unit_test(the_page_works_in_a_browser),
    };
    if (!gpu_open(&g, &device, reason, sizeof reason)) {
        printf("test_report: 0 passed, 0 failed, %d skipped\nskip all: %s\n", (int)(sizeof tests / sizeof *tests), reason);
        return 0;
    }
    gpu_close(&g);
    return cmocka_run_group_tests(tests, measure_once, clean_up);
}
