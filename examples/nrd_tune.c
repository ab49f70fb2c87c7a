/* nrd-tune: searches the settings of a denoiser, and the named constants inside its shaders, for less error and flicker on
   some scenes, and says what is gained on others. Built on shaders in which the constants are specialization constants.

   What is made small is the weighted geometric mean, over scenes and signals, of five numbers (formulas: common/metrics.h):
   trimmed relMSE in motion, weight 3; at rest, 1; over the frames after all lights become four times as bright, 1; flicker
   in motion, 1; at rest, 1. Coordinate search in factors: each value is multiplied and divided by a step, the better result
   is kept; the step shrinks to its root when a round brings nothing. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "common/cli.h"
#include "report/constants.h"
#include "report/method.h"
#include "report/score.h"
#include "report/sequence.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char usage[] =
    "usage: nrd-tune DENOISER OUT/ [options]\n"
    "References are kept in OUT/cache.\n"
    "  --train LIST       scenes to tune on, default interior,moving\n"
    "  --test LIST        scenes left out, default colonnade,roughness_ramp\n"
    "  --set KEY=VALUE    starts from this value and keeps it; may be repeated\n"
    "  --only LIST        settings and constants to search, default: all numbers that are not 0\n"
    "  --tries N          evaluations at most, default 200\n"
    "  --step F           first factor, default 1.6\n"
    "  --size WxH         default 160x90\n"
    "  --frames M,R,L     in motion, at rest, after the light step; default 10,8,8\n"
    "  --paths P          per pixel and lobe, default 1\n"
    "  --ref SPP          samples per pixel of references, default 64\n"
    "  --device N         Vulkan device, default: the first\n";

enum { MAX_SCENES = 8, MAX_KNOBS = 96, TERMS = 5 };
#define LEAST_STEP 1.08
#define LEAST_GAIN 0.002  /* of the objective: less is within the noise of the references */
#define LEAST_FLICKER 1e-4
#define LEAST_ERROR 1e-4

/* A scene whose frames are kept. */
typedef struct shot {
    const scene_def *def;
    capture frames[REPORT_MAX_FRAMES];
    truth truths[SIGNAL_COUNT];
} shot;

/* Something that can be turned. */
typedef struct knob {
    const char *name, *unit;
    const shader_constant *constant; /* NULL: a setting */
    double value, first, min, max;
} knob;

typedef struct tuner {
    report r;
    nrd_denoiser denoiser;
    const char *train, *test, *only;
    double step;
    int tries, tried;
    setting_value fixed[REPORT_MAX_SETTINGS];
    uint32_t fixed_count;
    shader_constants constants;
    knob knobs[MAX_KNOBS];
    int knob_count;
    double weights[TERMS];
} tuner;

/* ---- scenes ---- */

static bool open_shot(tuner *t, const char *name, shot *s)
{
    const report_group group = { scene_find(name), t->r.options.sizes[0], t->r.options.paths[0] };
    sequence seq;
    memset(s, 0, sizeof *s);
    s->def = group.scene;
    if (!group.scene)
        return report_fail(&t->r, "'%s' is no scene", name);
    bool ok = sequence_open(&seq, &t->r, &group, true);
    for (int i = 0; ok && i < sequence_length(&t->r.options); i++) {
        ok = sequence_frame(&seq, i, &s->frames[i]);
        cli_progress(name, i + 1, sequence_length(&t->r.options));
    }
    sequence_close(&seq);
    return ok;
}

static void close_shot(shot *s)
{
    for (int i = 0; i < REPORT_MAX_FRAMES; i++)
        capture_destroy(&s->frames[i]);
}

static bool open_shots(tuner *t, const char *list, shot *shots, int *count)
{
    char copy[512];
    snprintf(copy, sizeof copy, "%s", list);
    *count = 0;
    for (char *name = copy, *next; name; name = next) {
        next = strchr(name, ',');
        if (next)
            *next++ = 0;
        if (*count == MAX_SCENES)
            return report_fail(&t->r, "at most %d scenes", MAX_SCENES);
        if (!open_shot(t, name, &shots[(*count)++]))
            return false;
    }
    return true;
}

/* ---- evaluation ---- */

static double mean_after_step(const score *s, const report_options *o)
{
    double sum = 0;
    int used = 0;
    for (int i = o->moving + o->still; i < s->curve_count; i++)
        if (isfinite(s->curve[i])) {
            sum += s->curve[i];
            used++;
        }
    return used ? sum / used : 0;
}

/* Adds the logarithms of the terms of one signal. */
static void add_terms(const score *s, const report_options *o, double *terms)
{
    const metrics_flicker *motion = &s->motion_flicker, *rest = &s->rest_flicker;
    terms[0] += log(metrics_summarise(&s->motion).rel_mse_trimmed + LEAST_ERROR);
    terms[1] += log(metrics_summarise(&s->rest).rel_mse_trimmed + LEAST_ERROR);
    terms[2] += log(mean_after_step(s, o) + LEAST_ERROR);
    terms[3] += log((motion->pixels ? motion->sum / (double)motion->pixels : 0) + LEAST_FLICKER);
    terms[4] += log((rest->pixels ? rest->sum / (double)rest->pixels : 0) + LEAST_FLICKER);
}

static void make_method(const tuner *t, method *m)
{
    memset(m, 0, sizeof *m);
    m->denoiser = t->denoiser;
    for (uint32_t i = 0; i < t->fixed_count; i++)
        m->settings[m->setting_count++] = t->fixed[i];
    for (int i = 0; i < t->knob_count; i++)
        if (t->knobs[i].constant)
            constants_set(t->knobs[i].constant, (float)t->knobs[i].value);
        else
            m->settings[m->setting_count++] = (setting_value){ t->knobs[i].name, true, t->denoiser, t->knobs[i].value };
}

static bool score_frame(tuner *t, shot *s, method *m, score *scores, int frame)
{
    const report_options *o = &t->r.options;
    const capture *then = frame ? &s->frames[frame - 1] : NULL, *now = &s->frames[frame];
    capture out;
    bool ok = method_frame(&t->r, m, now, &out);
    for (int k = 0; k < SIGNAL_COUNT && ok; k++) {
        image picture;
        if (!m->writes[k])
            continue;
        ok = truth_advance(&s->truths[k], o, frame, then, now) && signal_get(now, &out, (signal_id)k, SOURCE_DENOISED, &picture)
            && score_add(&scores[k], &s->truths[k], o, frame, then, now, &picture);
        if (!ok)
            report_fail(&t->r, "out of memory");
    }
    capture_destroy(&out);
    return ok;
}

static bool run_shot(tuner *t, shot *s, double *terms, int *signals)
{
    static score scores[SIGNAL_COUNT];
    method m;
    make_method(t, &m);
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        score_start(&scores[k]);
        memset(&s->truths[k], 0, sizeof s->truths[k]);
        s->truths[k].signal = (signal_id)k;
    }
    bool ok = method_open(&t->r, &m, &s->frames[0]);
    for (int i = 0; ok && i < sequence_length(&t->r.options); i++)
        ok = score_frame(t, s, &m, scores, i);
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        if (ok && m.writes[k]) {
            add_terms(&scores[k], &t->r.options, terms);
            (*signals)++;
        }
        score_free(&scores[k]);
        truth_free(&s->truths[k]);
    }
    method_close(&m);
    return ok;
}

/* The weighted geometric mean, and the means of the terms. */
static bool evaluate(tuner *t, shot *shots, int count, double *terms, double *out)
{
    int signals = 0;
    double sum = 0, weight = 0;
    memset(terms, 0, TERMS * sizeof *terms);
    for (int i = 0; i < count; i++)
        if (!run_shot(t, &shots[i], terms, &signals))
            return false;
    for (int i = 0; i < TERMS; i++) {
        terms[i] /= signals ? signals : 1;
        sum += t->weights[i] * terms[i];
        weight += t->weights[i];
        terms[i] = exp(terms[i]);
    }
    *out = exp(sum / weight);
    return true;
}

/* ---- knobs ---- */

static bool is_wanted(const tuner *t, const char *name)
{
    size_t length = strlen(name);
    for (const char *at = t->only; at && (at = strstr(at, name)); at += length)
        if ((at == t->only || at[-1] == ',') && (!at[length] || at[length] == ','))
            return true;
    return !t->only;
}

static void add_knob(tuner *t, const knob *k)
{
    if (t->knob_count < MAX_KNOBS && is_wanted(t, k->name))
        t->knobs[t->knob_count++] = *k;
}

/* Numbers that are not 0: a switch or a 0 has no factor. What the application must know as well stays. */
static void add_settings(tuner *t)
{
    nrd_setting row;
    for (uint32_t i = 0; nrd_get_setting(t->denoiser, i, &row); i++) {
        bool shared = !strncmp(row.name, "hit_distance_", strlen("hit_distance_"));
        if (row.is_float && row.value != 0 && !shared && !setting_given(t->fixed, t->fixed_count, t->denoiser, row.name))
            add_knob(t, &(knob){ row.name, row.unit, NULL, row.value, row.value, row.min, row.max });
    }
}

static bool add_constants(tuner *t)
{
    const nrd_denoiser_desc one = { 0, t->denoiser };
    nrd_desc desc = { 0 };
    nrd *instance;
    desc.width = desc.height = 64;
    desc.denoisers = &one;
    desc.denoiser_count = 1;
    if (nrd_create(&desc, &instance))
        return report_fail(&t->r, "cannot create %s", nrd_denoiser_name(t->denoiser));
    const nrd_info *info = nrd_get_info(instance);
    bool ok = true;
    for (uint32_t p = 0; p < info->pipeline_count; p++)
        for (uint32_t i = 0; i < nrd_spirv_count; i++)
            if (!strcmp(nrd_spirv_table[i].name, info->pipelines[p].shader)) /* the tuning build's modules can be written to */
                ok = constants_find(&t->constants, (uint32_t *)nrd_spirv_table[i].words, nrd_spirv_table[i].size_bytes) && ok;
    nrd_destroy(instance);
    for (int i = 0; i < t->constants.count; i++) {
        const shader_constant *c = &t->constants.list[i];
        double value = constants_get(c);
        if (value != 0)
            add_knob(t, &(knob){ c->name, "in the shaders", c, value, value, value < 0 ? -1e6 : 1e-6, value < 0 ? -1e-6 : 1e6 });
    }
    return ok || report_fail(&t->r, "a shader module cannot be read");
}

/* ---- search ---- */

/* Tries one value; keeps it when that is better. */
static bool try_value(tuner *t, shot *shots, int count, knob *k, double value, double *best, bool *better)
{
    double before = k->value, terms[TERMS], now;
    value = fmin(fmax(value, k->min), k->max);
    if (value == before || t->tried >= t->tries)
        return true;
    k->value = value;
    t->tried++;
    if (!evaluate(t, shots, count, terms, &now))
        return false;
    *better = now < *best * (1 - LEAST_GAIN);
    if (!*better) {
        k->value = before;
        return true;
    }
    *best = now;
    printf("%4d  %.5f  %s %g\n", t->tried, now, k->name, value);
    fflush(stdout);
    return true;
}

static bool search(tuner *t, shot *shots, int count, double *best)
{
    for (double step = t->step; step >= LEAST_STEP && t->tried < t->tries;) {
        bool any = false;
        for (int i = 0; i < t->knob_count; i++) {
            knob *k = &t->knobs[i];
            bool better = false;
            if (!try_value(t, shots, count, k, k->value * step, best, &better))
                return false;
            if (!better && !try_value(t, shots, count, k, k->value / step, best, &better))
                return false;
            any |= better;
        }
        if (!any)
            step = sqrt(step);
    }
    return true;
}

/* ---- the program ---- */

static void print_terms(const char *what, double objective, const double *terms)
{
    printf("%-22s %9.5f %9.5f %9.5f %9.5f %9.5f %9.5f\n", what, objective, terms[0], terms[1], terms[2], terms[3], terms[4]);
}

static void swap_values(tuner *t)
{
    for (int i = 0; i < t->knob_count; i++) {
        double value = t->knobs[i].value;
        t->knobs[i].value = t->knobs[i].first;
        t->knobs[i].first = value;
    }
}

static void print_defaults(const tuner *t)
{
    printf("\nnew values\n");
    for (int i = 0; i < t->knob_count; i++)
        if (t->knobs[i].value != t->knobs[i].first)
            printf("  %-34s %10g -> %-10g %s\n", t->knobs[i].name, t->knobs[i].first, t->knobs[i].value, t->knobs[i].unit);
}

/* Before and after on scenes that the search has not seen. */
static bool compare_left_out(tuner *t, shot *shots, int count)
{
    double after[TERMS], before[TERMS], objective_after, objective_before;
    if (!evaluate(t, shots, count, after, &objective_after))
        return false;
    swap_values(t);
    bool ok = evaluate(t, shots, count, before, &objective_before);
    swap_values(t);
    if (!ok)
        return false;
    print_terms("left out, before", objective_before, before);
    print_terms("left out, after", objective_after, after);
    printf("%-22s %9.3f %9.3f %9.3f %9.3f %9.3f %9.3f\n", "ratio", objective_after / objective_before, after[0] / before[0], after[1] / before[1],
           after[2] / before[2], after[3] / before[3], after[4] / before[4]);
    return true;
}

static bool tune(tuner *t, shot *train, shot *test, int *train_count, int *test_count)
{
    double terms[TERMS], best;
    add_settings(t);
    if (!add_constants(t) || !open_shots(t, t->train, train, train_count) || !open_shots(t, t->test, test, test_count)
        || !evaluate(t, train, *train_count, terms, &best))
        return false;
    printf("%s, %d values to search\n%-22s %9s %9s %9s %9s %9s %9s\n", nrd_denoiser_name(t->denoiser), t->knob_count, "", "objective", "motion", "rest", "step",
           "flicker", "at rest");
    print_terms("trained on, before", best, terms);
    if (!search(t, train, *train_count, &best) || !evaluate(t, train, *train_count, terms, &best))
        return false;
    print_terms("trained on, after", best, terms);
    if (!compare_left_out(t, test, *test_count))
        return false;
    print_defaults(t);
    return true;
}

static bool take_option(tuner *t, const char *name, const char *value)
{
    report_options *o = &t->r.options;
    long number;
    char tail;
    if (!strcmp(name, "--train")) return t->train = value, true;
    if (!strcmp(name, "--test")) return t->test = value, true;
    if (!strcmp(name, "--only")) return t->only = value, true;
    if (!strcmp(name, "--set") && t->fixed_count < REPORT_MAX_SETTINGS)
        return setting_parse(value, &t->denoiser, 1, &t->fixed[t->fixed_count++], t->r.error, sizeof t->r.error);
    if (!strcmp(name, "--tries") && cli_integer(value, 0, 100000, &number)) return t->tries = (int)number, true;
    if (!strcmp(name, "--step") && cli_number(value, &t->step) && t->step > 1 && t->step <= 10) return true;
    if (!strcmp(name, "--ref") && cli_integer(value, 2, 1 << 20, &number)) return o->samples = (int)number / 2 * 2, true;
    if (!strcmp(name, "--device") && cli_integer(value, 0, 63, &number)) return o->device = (int)number, true;
    if (!strcmp(name, "--paths") && cli_number(value, &o->paths[0]) && o->paths[0] >= 0.05 && o->paths[0] <= 8) return true;
    if (!strcmp(name, "--size") && sscanf(value, "%dx%d%c", &o->sizes[0].width, &o->sizes[0].height, &tail) == 2 && o->sizes[0].width >= 16
        && o->sizes[0].height >= 16 && o->sizes[0].width <= 4096 && o->sizes[0].height <= 4096)
        return true;
    if (!strcmp(name, "--frames") && sscanf(value, "%d,%d,%d%c", &o->moving, &o->still, &o->stepped, &tail) == 3 && o->moving >= 2 && o->still >= 2
        && o->stepped >= 1 && o->moving + o->still + o->stepped <= REPORT_MAX_FRAMES)
        return true;
    return report_fail(&t->r, "%s %s: not an option, or out of its range; --help lists them", name, value);
}

static bool parse(tuner *t, int argc, char **argv)
{
    static const double weights[TERMS] = { 3, 1, 1, 1, 1 };
    report_options *o = &t->r.options;
    *o = (report_options){ .size_count = 1, .sizes = { { 160, 90 } }, .path_count = 1, .paths = { 1 }, .moving = 10, .still = 8, .stepped = 8, .pairs = 1, .samples = 64 };
    memcpy(t->weights, weights, sizeof weights);
    t->train = "interior,moving";
    t->test = "colonnade,roughness_ramp";
    t->tries = 200;
    t->step = 1.6;
    if (argc < 3)
        return report_fail(&t->r, "a denoiser and a folder are needed; --help lists options");
    if (nrd_find_denoiser(argv[1], &t->denoiser))
        return report_fail(&t->r, "'%s' is no denoiser", argv[1]);
    o->folder = argv[2];
    for (int i = 3; i < argc; i += 2)
        if (!take_option(t, argv[i], i + 1 < argc ? argv[i + 1] : ""))
            return false;
    mkdir(o->folder, 0777);
    return true;
}

int main(int argc, char **argv)
{
    static tuner t;
    static shot train[MAX_SCENES], test[MAX_SCENES];
    int train_count = 0, test_count = 0;
    if (argc == 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))) return fputs(usage, stdout), 0;
    if (!parse(&t, argc, argv)) return cli_fail("nrd-tune", "%s", t.r.error), 2;
    bool ok = tune(&t, train, test, &train_count, &test_count);
    for (int i = 0; i < MAX_SCENES; i++) {
        close_shot(&train[i]);
        close_shot(&test[i]);
    }
    return ok ? 0 : cli_fail("nrd-tune", "%s", t.r.error);
}
