/* nrd-stress: tries to break every denoiser, and holds each to the guarantees that README.md states.

   nrd-stress [--all] [--only SUBJECT[,...]] [--denoiser NAME] [--device N] [--validate] [--quiet] [--markdown]
              [--seed N] [--cases N] [--case NUMBER] [--frames N] [--set KEY=VALUE] [--dump FILE] [--compare FILE] [--plant FAULT]
   nrd-stress --self-test [--only SUBJECT[,...]]
   Prints one row per case, denoiser and guarantee: ok or FAIL, what was measured, and the most that is allowed; then the worst of each
   guarantee. --all: the long suite. --validate: under the validation layer. --markdown: the guarantees as a table for README.md.
   --case: one random case again, by the number that failed. --dump writes what the denoisers give on this device, --compare holds it
   against a file of another. --plant: spoils what the denoisers give, to see that the guarantees notice; --self-test does so with every
   fault. Exit status: 0 all kept, 1 one broken, 2 not run. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "common/cli.h"
#include "stress/stress.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] = "usage: nrd-stress [--all] [--quiet] [--markdown] [--validate] [--self-test] [--only SUBJECT[,...]] [--denoiser NAME] "
                            "[--set KEY=VALUE] [--device N] [--frames N] [--cases N] [--case NUMBER] [--seed N] [--plant FAULT] [--dump FILE] [--compare FILE]";

typedef struct subject { const char *name; void (*run)(stress *s); } subject;
static const subject subjects[] = {
    { "extremes", stress_extremes },
    { "analytic", stress_analytic },
    { "time", stress_time },
    { "space", stress_space },
    { "sensitivity", stress_sensitivity },
    { "agreement", stress_agreement },
    { "fuzz", stress_fuzz },
};
enum { SUBJECT_COUNT = sizeof subjects / sizeof subjects[0] };

static bool parse_fault(const char *text, fault *out)
{
    for (int i = 0; i < FAULT_COUNT; i++)
        if (strcmp(text, fault_name((fault)i)) == 0) return *out = (fault)i, true;
    return false;
}

/* Names with commas between them; a bit for each. */
static bool parse_subjects(const char *text, uint32_t *only)
{
    for (const char *end; ; text = end + 1) {
        bool known = false;
        end = text + strcspn(text, ",");
        for (int i = 0; i < SUBJECT_COUNT; i++)
            if (strlen(subjects[i].name) == (size_t)(end - text) && strncmp(text, subjects[i].name, (size_t)(end - text)) == 0) known = true, *only |= 1u << i;
        if (!known || !*end) return known;
    }
}

static bool parse_setting(const char *text, stress *s)
{
    nrd_denoiser all[NRD_DENOISER_COUNT];
    char error[256];
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) all[d] = (nrd_denoiser)d;
    return s->set_count < sizeof s->set / sizeof s->set[0] && setting_parse(text, all, NRD_DENOISER_COUNT, &s->set[s->set_count++], error, sizeof error);
}

static int parse(int argc, char **argv, stress *s, int *device, uint32_t *only, bool *self_test, bool *validate)
{
    long number;
    for (int i = 1; i < argc; i++) {
        const char *option = argv[i];
        if (!strcmp(option, "--all")) { s->everything = true; continue; }
        if (!strcmp(option, "--self-test")) { *self_test = true; continue; }
        if (!strcmp(option, "--markdown")) { s->markdown = true; continue; }
        if (!strcmp(option, "--validate")) { *validate = true; continue; }
        if (!strcmp(option, "--quiet")) { s->quiet = true; continue; }
        const char *value = cli_value(argc, argv, &i);
        if (!value) return cli_fail("nrd-stress", "%s is unknown or lacks its value; %s", option, usage);
        bool ok = false;
        if (!strcmp(option, "--only")) ok = parse_subjects(value, only);
        else if (!strcmp(option, "--set")) ok = parse_setting(value, s);
        else if (!strcmp(option, "--dump")) ok = (s->dump = fopen(value, "w")) != NULL;
        else if (!strcmp(option, "--compare")) ok = (s->compare = fopen(value, "r")) != NULL;
        else if (!strcmp(option, "--plant")) ok = parse_fault(value, &s->fault);
        else if (!strcmp(option, "--denoiser")) ok = nrd_find_denoiser(value, &s->first) == NRD_RESULT_OK, s->last = s->first;
        else if (!strcmp(option, "--device")) ok = cli_integer(value, 0, 63, &number), *device = ok ? (int)number : 0;
        else if (!strcmp(option, "--frames")) ok = cli_integer(value, 1, 100000000, &number), s->frames = ok ? (uint32_t)number : 0;
        else if (!strcmp(option, "--cases")) ok = cli_integer(value, 1, 100000000, &number), s->cases = ok ? (uint32_t)number : 0;
        else if (!strcmp(option, "--case")) ok = cli_integer(value, 1, 100000000, &number), s->one_case = ok ? (uint32_t)number : 0;
        else if (!strcmp(option, "--seed")) ok = cli_integer(value, 0, 65535, &number), s->seed = ok ? (uint32_t)number : 0;
        if (!ok) return cli_fail("nrd-stress", "%s %s is not understood", option, value);
    }
    return 0;
}

/* The worst over the denoisers looked at. */
static void print_guarantee(const stress *s, guarantee g)
{
    int worst_denoiser = -1;
    uint32_t checks = 0;
    for (int d = 0; d < NRD_DENOISER_COUNT; d++) {
        const worst *w = &s->worst[g][d];
        checks += w->checks;
        if (w->checks && (worst_denoiser < 0 || !(w->measured <= s->worst[g][worst_denoiser].measured))) worst_denoiser = d;
    }
    if (worst_denoiser < 0) return;
    const worst *w = &s->worst[g][worst_denoiser];
    if (s->markdown && w->measured == 0) printf("| %s | %.3g | 0 | all |\n", guarantee_text(g), guarantee_limit(g));
    else if (s->markdown) printf("| %s | %.3g | %.2g | %s: %s |\n", guarantee_text(g), guarantee_limit(g), w->measured, nrd_denoiser_name((nrd_denoiser)worst_denoiser), w->of);
    else printf("%-15s %10.3g of %-8.3g %5u checks; worst: %s, %s\n", guarantee_name(g), w->measured, guarantee_limit(g), checks, nrd_denoiser_name((nrd_denoiser)worst_denoiser), w->of);
}

static void run_subjects(stress *s, uint32_t only)
{
    for (int i = 0; i < SUBJECT_COUNT; i++)
        if (!only || (only >> i & 1u)) subjects[i].run(s);
}

static int report(const stress *s)
{
    uint32_t kept = 0, broken = 0;
    printf("\n%s\n", s->device.properties.deviceName);
    for (int g = 0; g < GUARANTEE_COUNT; g++) {
        print_guarantee(s, (guarantee)g);
        for (int d = 0; d < NRD_DENOISER_COUNT; d++)
            if (s->worst[g][d].checks) *(s->worst[g][d].measured <= guarantee_limit((guarantee)g) ? &kept : &broken) += 1;
    }
    printf("nrd-stress: %u guarantees of denoisers kept, %u broken; %u checks, %u failed\n", kept, broken, s->passed + s->failed, s->failed);
    return broken ? 1 : 0;
}

/* Plants every fault in turn, in one denoiser of each kind: a guarantee that no fault breaks proves nothing. */
static int test_self(stress *s, uint32_t only)
{
    static const nrd_denoiser some[] = { NRD_DENOISER_REBLUR_DIFFUSE, NRD_DENOISER_REBLUR_DIFFUSE_DIRECTIONAL_OCCLUSION, NRD_DENOISER_SIGMA_SHADOW };
    int blind = 0;
    s->silent = true;
    s->frames = 61;
    s->cases = 20;
    for (size_t d = 0; d < sizeof some / sizeof some[0]; d++) {
        FILE *own = tmpfile();
        if (!own) return cli_fail("nrd-stress", "no temporary file can be made"), 2;
        s->first = s->last = some[d];
        s->fault = FAULT_NONE;
        s->dump = own;
        stress_agreement(s);
        s->dump = NULL;
        s->compare = own;
        memset(s->seen_failing, 0, d ? 0 : sizeof s->seen_failing);
        for (int f = FAULT_NONE + 1; f < FAULT_COUNT; f++) {
            s->fault = (fault)f;
            run_subjects(s, only);
        }
        s->compare = NULL;
        fclose(own);
    }
    for (int g = 0; g < GUARANTEE_COUNT; g++) {
        if (s->seen_failing[g]) continue;
        printf("%s holds whatever fault is planted\n", guarantee_name((guarantee)g));
        blind++;
    }
    printf("nrd-stress: %d of %d guarantees notice faults\n", GUARANTEE_COUNT - blind, GUARANTEE_COUNT);
    return blind ? 1 : 0;
}

int main(int argc, char **argv)
{
    static stress s;
    int device = 0, status;
    bool self_test = false;
    gpu_desc desc = { .device_index = 0 };
    uint32_t only = 0;
    char error[256];
    s.last = (nrd_denoiser)(NRD_DENOISER_COUNT - 1);
    if (parse(argc, argv, &s, &device, &only, &self_test, &desc.validation)) return 2;
    desc.device_index = device;
    if (!gpu_open(&s.device, &desc, error, sizeof error)) return cli_fail("nrd-stress", "%s", error), 2;
    if (self_test) status = test_self(&s, only);
    else run_subjects(&s, only), status = report(&s);
    if (gpu_message_count(&s.device)) status = cli_fail("nrd-stress", "%u validation messages", gpu_message_count(&s.device));
    gpu_close(&s.device);
    if (s.compare) fclose(s.compare);
    if (s.dump && fclose(s.dump)) return cli_fail("nrd-stress", "the file of --dump cannot be written"), 2;
    return status;
}
