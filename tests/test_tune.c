/* nrd-tune: the constants inside shaders, and a search. Expects nrd-tune in the folder that the environment variable
   NRD_BUILD names (build). */
#define _XOPEN_SOURCE 700
#define _DEFAULT_SOURCE
#define NRD_IMPLEMENTATION
#include "nrd.h"

#include "common/gpu.h"
#include "common/scratch.h"
#include "report/constants.h"
#include "report/tuning.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#define INSTRUCTION(opcode, words) ((uint32_t)(words) << 16 | (opcode))
#define NAMED(id, four) INSTRUCTION(5, 4), (id), four, 0
#define SPEC_ID(id, number) INSTRUCTION(71, 4), (id), 1, (number)
#define CONSTANT(id, bits) INSTRUCTION(50, 4), 1, (id), (bits)
#define TEXT(a, b, c, d) ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)

/* Constants ABCD = 0.5 (id 100) and EFGH = 2 (id 101); WXYZ = 1 is one of the runtime's own (id 2). */
#define MODULE { 0x07230203, 0x10300, 0, 20, 0, NAMED(7, TEXT('A', 'B', 'C', 'D')), NAMED(8, TEXT('E', 'F', 'G', 'H')), NAMED(9, TEXT('W', 'X', 'Y', 'Z')), \
                 SPEC_ID(7, 100), SPEC_ID(8, 101), SPEC_ID(9, 2), CONSTANT(7, 0x3f000000), CONSTANT(8, 0x40000000), CONSTANT(9, 0x3f800000) }

static void constants_are_found_and_changed_in_every_module(void **state)
{
    uint32_t first[] = MODULE, second[] = MODULE;
    static shader_constants c;
    (void)state;
    assert_true(constants_find(&c, first, sizeof first));
    assert_true(constants_find(&c, second, sizeof second));
    assert_int_equal(c.count, 2);
    assert_string_equal(c.list[0].name, "ABCD");
    assert_string_equal(c.list[1].name, "EFGH");
    assert_int_equal(c.list[1].place_count, 2);
    assert_true(constants_get(&c.list[0]) == 0.5f);
    constants_set(&c.list[1], 3.0f);
    assert_int_equal(first[sizeof first / 4 - 5], 0x40400000);
    assert_int_equal(second[sizeof second / 4 - 5], 0x40400000);
    assert_int_equal(second[sizeof second / 4 - 1], 0x3f800000);
}

static void what_is_no_module_is_refused(void **state)
{
    uint32_t words[] = MODULE;
    shader_constants c;
    (void)state;
    c.count = 0;
    assert_false(constants_find(&c, words, 16));
    assert_false(constants_find(&c, words, sizeof words - 4)); /* the last instruction is cut off */
    words[0] = 1;
    assert_false(constants_find(&c, words, sizeof words));
    words[0] = 0x07230203;
    words[5] = 0; /* an instruction without length */
    assert_false(constants_find(&c, words, sizeof words));
}

static char output[16384];

static int tune(const char *arguments)
{
    char command[1024];
    const char *build = getenv("NRD_BUILD");
    snprintf(command, sizeof command, "%s/nrd-tune %s 2>&1", build ? build : "build", arguments);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    output[fread(output, 1, sizeof output - 1, pipe)] = 0;
    return pclose(pipe);
}

static float number_after(const char *words)
{
    float number;
    const char *at = strstr(output, words);
    assert_non_null(at);
    assert_int_equal(sscanf(at + strlen(words), " %f", &number), 1);
    return number;
}

/* What the report shows is what was printed, and nothing when the file is cut off. */
static void found_is_kept(const char *folder)
{
    static report r;
    char path[256];
    tuning_result t;
    r.options.folder = folder;
    assert_true(tuning_load(&r, "reblur_diffuse", &t));
    assert_true(t.searched == 2 && t.tried == 3 && t.verdict_count == 4 && t.change_count <= 2);
    assert_true(fabs(t.verdicts[0].objective - number_after("trained on, before")) < 1e-5);
    assert_true(fabs(t.verdicts[3].objective - number_after("left out, after")) < 1e-5);
    assert_string_equal(t.verdicts[2].scenes, "interior");
    assert_true(t.verdicts[1].terms[0] > 0 && t.verdicts[1].terms[5] >= 0.01);
    for (int i = 0; i < t.change_count; i++)
        assert_true(t.changes[i].before != t.changes[i].after);
    assert_false(tuning_load(&r, "sigma_shadow", &t));
    snprintf(path, sizeof path, "%s/tuning/reblur_diffuse.txt", folder);
    FILE *file = fopen(path, "r+");
    assert_non_null(file);
    assert_int_equal(ftruncate(fileno(file), 200), 0);
    fclose(file);
    assert_false(tuning_load(&r, "reblur_diffuse", &t));
}

static void a_search_never_ends_worse_on_what_it_trains_on(void **state)
{
    char folder[SCRATCH_SIZE], arguments[512];
    float before, after, ratio;
    gpu g;
    char reason[256];
    const gpu_desc device = { .device_index = 0 };
    (void)state;
    if (!gpu_open(&g, &device, reason, sizeof reason)) {
        print_message("%s\n", reason);
        skip();
    }
    gpu_close(&g);
    assert_true(scratch_make(folder));
    const char *common = "--train moving --test interior --size 64x36 --frames 4,4,3 --ref 8";
    snprintf(arguments, sizeof arguments, "reblur_diffuse %s %s --only max_accumulated_frames,HEAD_START --step 4 --tries 3", folder, common);
    assert_int_equal(tune(arguments), 0);
    assert_non_null(strstr(output, "2 values to search"));
    found_is_kept(folder);
    before = number_after("trained on, before");
    after = number_after("trained on, after");
    ratio = number_after("left out, after") / number_after("left out, before");
    assert_true(after > 0 && after <= before);
    assert_true(fabsf(number_after("\nratio") / ratio - 1) < 0.01f);
    snprintf(arguments, sizeof arguments, "reference %s %s --tries 1 --size 32x18", folder, common);
    assert_int_equal(tune(arguments), 0);
    assert_non_null(strstr(output, "0 values to search"));
    assert_true(scratch_remove(folder));
}

static void misuse_is_named(void **state)
{
    char folder[SCRATCH_SIZE], arguments[512];
    (void)state;
    assert_true(scratch_make(folder));
    assert_int_not_equal(tune("nothing out"), 0);
    assert_non_null(strstr(output, "'nothing' is no denoiser"));
    snprintf(arguments, sizeof arguments, "sigma_shadow %s --train interior --test interior --size 16x16 --ref 2 --frames 2,2,1", folder);
    assert_int_not_equal(tune(arguments), 0);
    assert_non_null(strstr(output, "sigma_shadow can run on none of the scenes"));
    assert_true(scratch_remove(folder));
    assert_int_not_equal(tune("reblur_diffuse out --step 0.5"), 0);
    assert_non_null(strstr(output, "--step 0.5: not an option, or out of its range"));
    assert_int_not_equal(tune("reblur_diffuse out --set max_blur_radius=99"), 0);
    assert_non_null(strstr(output, "setting max_blur_radius is 99"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constants_are_found_and_changed_in_every_module),
        cmocka_unit_test(what_is_no_module_is_refused),
        cmocka_unit_test(a_search_never_ends_worse_on_what_it_trains_on),
        cmocka_unit_test(misuse_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
