/* nrd-tune: searches the settings of denoisers, and the named constants inside their shaders, for less error and flicker on
   some scenes, and says what is gained on others. Built on shaders in which the constants are specialization constants.

   What is made small is the weighted geometric mean, over scenes and signals, of six numbers (formulas: common/metrics.h):
   trimmed relMSE in motion, weight 3; at rest, 1; over the frames after all lights become four times as bright, 1; flicker
   in motion, 1; at rest, 1; the size of the bias in motion, 1. Coordinate search in factors: each value is multiplied and
   divided by a step; the result is kept when it is better in the mean, and on no scene that it is trained on clearly worse,
   so that nothing is paid for by one scene. The step shrinks to its root when a round brings nothing. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "common/cli.h"
#include "report/constants.h"
#include "report/method.h"
#include "report/score.h"
#include "report/sequence.h"
#include "report/tuning.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char usage[] =
    "usage: nrd-tune DENOISER,... OUT/ [options]\n"
    "References are kept in OUT/cache; nrd-report OUT/ shows what was found (OUT/tuning), before and after.\n"
    "  --train LIST       scenes to tune on, default interior,moving,colonnade\n"
    "  --test LIST        scenes left out, default roughness_ramp,thin\n"
    "  --set KEY=VALUE    starts from this value and keeps it; may be repeated\n"
    "  --only LIST        settings and constants to search, default: all numbers that are not 0\n"
    "  --tries N          evaluations at most for each denoiser, default 200\n"
    "  --step F           first factor, default 1.6\n"
    "  --size WxH         default 240x135\n"
    "  --frames M,R,L     in motion, at rest, after the light step; default 24,12,8\n"
    "  --paths P          per pixel and lobe, default 1\n"
    "  --ref SPP          samples per pixel of references, default 64\n"
    "  --device N         Vulkan device, default: the first\n";

enum { MAX_SCENES = 8, MAX_KNOBS = 96 };
#define LEAST_STEP 1.08
#define LEAST_GAIN 0.002  /* of the objective: less is within the noise of the references */
#define MOST_LOSS 0.01    /* of a scene's own objective */
#define LEAST_FLICKER 1e-4
#define LEAST_ERROR 1e-4
#define LEAST_BIAS 0.01

/* A scene whose frames are kept. */
typedef struct shot {
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
    nrd_denoiser denoiser; /* at work on this one */
    const char *train, *test, *only;
    double step;
    int tries, tried;
    setting_value fixed[REPORT_MAX_SETTINGS];
    uint32_t fixed_count;
    shader_constants constants;
    knob knobs[MAX_KNOBS];
    int knob_count;
} tuner;

/* How good some values are on a list of scenes. */
typedef struct verdict {
    double objective, terms[TUNING_TERMS], scenes[MAX_SCENES]; /* scenes: the objective of each; 0: the denoiser cannot run there */
} verdict;

/* ---- scenes ---- */

static bool open_shot(tuner *t, const char *name, shot *s)
{
    const report_group group = { scene_find(name), t->r.options.sizes[0], t->r.options.paths[0] };
    sequence seq;
    memset(s, 0, sizeof *s);
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
    terms[5] += log(fabs(metrics_summarise(&s->motion).bias) + LEAST_BIAS);
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
    char reason[REPORT_ERROR];
    method m;
    make_method(t, &m);
    if (!method_fits(&m, &s->frames[0], reason, sizeof reason))
        return true;
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

/* The weighted mean of logarithms. */
static double objective_of(const double *terms, int signals)
{
    static const double weights[TUNING_TERMS] = { 3, 1, 1, 1, 1, 1 };
    double sum = 0, weight = 0;
    for (int i = 0; i < TUNING_TERMS; i++) {
        sum += weights[i] * terms[i];
        weight += weights[i];
    }
    return exp(sum / weight / signals);
}

static bool evaluate(tuner *t, shot *shots, int count, verdict *out)
{
    int all = 0;
    memset(out, 0, sizeof *out);
    for (int i = 0; i < count; i++) {
        double terms[TUNING_TERMS] = { 0 };
        int signals = 0;
        if (!run_shot(t, &shots[i], terms, &signals))
            return false;
        if (signals)
            out->scenes[i] = objective_of(terms, signals);
        for (int k = 0; k < TUNING_TERMS; k++)
            out->terms[k] += terms[k];
        all += signals;
    }
    if (!all)
        return report_fail(&t->r, "%s can run on none of the scenes", nrd_denoiser_name(t->denoiser));
    out->objective = objective_of(out->terms, all);
    for (int k = 0; k < TUNING_TERMS; k++)
        out->terms[k] = exp(out->terms[k] / all);
    return true;
}

static bool is_better(const verdict *now, const verdict *best)
{
    for (int i = 0; i < MAX_SCENES; i++)
        if (now->scenes[i] > best->scenes[i] * (1 + MOST_LOSS))
            return false;
    return now->objective < best->objective * (1 - LEAST_GAIN);
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
static bool try_value(tuner *t, shot *shots, int count, knob *k, double value, verdict *best, bool *better)
{
    double before = k->value;
    verdict now;
    value = fmin(fmax(value, k->min), k->max);
    if (value == before || t->tried >= t->tries)
        return true;
    k->value = value;
    t->tried++;
    if (!evaluate(t, shots, count, &now))
        return false;
    *better = is_better(&now, best);
    printf("%4d  %.5f  %s %g%s\n", t->tried, now.objective, k->name, value, *better ? "  kept" : "");
    fflush(stdout);
    if (*better)
        *best = now;
    else
        k->value = before;
    return true;
}

static bool search(tuner *t, shot *shots, int count, verdict *best)
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

static void print_verdict(const char *what, const verdict *v)
{
    printf("%-22s %9.5f", what, v->objective);
    for (int i = 0; i < TUNING_TERMS; i++)
        printf(" %9.5f", v->terms[i]);
    printf("\n");
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
static bool compare_left_out(tuner *t, shot *shots, int count, verdict *before, verdict *after)
{
    if (!evaluate(t, shots, count, after))
        return false;
    swap_values(t);
    bool ok = evaluate(t, shots, count, before);
    swap_values(t);
    if (!ok)
        return false;
    print_verdict("left out, before", before);
    print_verdict("left out, after", after);
    printf("%-22s %9.3f", "ratio", after->objective / before->objective);
    for (int i = 0; i < TUNING_TERMS; i++)
        printf(" %9.3f", after->terms[i] / before->terms[i]);
    printf("\n");
    return true;
}

static void keep_values(tuning_result *out, const char *when, const char *where, const verdict *v)
{
    tuning_verdict *row = &out->verdicts[out->verdict_count++];
    snprintf(row->when, sizeof row->when, "%s", when);
    snprintf(row->scenes, sizeof row->scenes, "%s", where);
    row->objective = v->objective;
    memcpy(row->terms, v->terms, sizeof row->terms);
}

/* For the report. */
static bool save(tuner *t, const verdict *verdicts)
{
    tuning_result out = { 0 };
    snprintf(out.denoiser, sizeof out.denoiser, "%s", nrd_denoiser_name(t->denoiser));
    out.searched = t->knob_count;
    out.tried = t->tried;
    keep_values(&out, "before", t->train, &verdicts[0]);
    keep_values(&out, "after", t->train, &verdicts[1]);
    keep_values(&out, "before", t->test, &verdicts[2]);
    keep_values(&out, "after", t->test, &verdicts[3]);
    for (int i = 0; i < t->knob_count && out.change_count < TUNING_MAX_CHANGES; i++)
        if (t->knobs[i].value != t->knobs[i].first) {
            tuning_change *c = &out.changes[out.change_count++];
            snprintf(c->name, sizeof c->name, "%s", t->knobs[i].name);
            c->before = t->knobs[i].first;
            c->after = t->knobs[i].value;
        }
    return tuning_save(&t->r, &out);
}

static bool tune(tuner *t, shot *train, int train_count, shot *test, int test_count)
{
    verdict verdicts[4], best; /* trained on and left out, before and after each */
    t->knob_count = t->tried = 0;
    memset(&t->constants, 0, sizeof t->constants);
    add_settings(t);
    if (!add_constants(t) || !evaluate(t, train, train_count, &best))
        return false;
    verdicts[0] = best;
    printf("%s, %d values to search\n%-22s %9s %9s %9s %9s %9s %9s %9s\n", nrd_denoiser_name(t->denoiser), t->knob_count, "", "objective", "motion", "rest",
           "step", "flicker", "at rest", "bias");
    print_verdict("trained on, before", &best);
    fflush(stdout);
    if (!search(t, train, train_count, &best) || !evaluate(t, train, train_count, &verdicts[1]))
        return false;
    print_verdict("trained on, after", &verdicts[1]);
    if (!compare_left_out(t, test, test_count, &verdicts[2], &verdicts[3]) || !save(t, verdicts))
        return false;
    print_defaults(t);
    swap_values(t); /* denoisers share shaders: the next one starts from what is shipped */
    for (int i = 0; i < t->knob_count; i++)
        if (t->knobs[i].constant)
            constants_set(t->knobs[i].constant, (float)t->knobs[i].value);
    return true;
}

static bool tune_all(tuner *t, shot *train, shot *test)
{
    int train_count, test_count;
    if (!open_shots(t, t->train, train, &train_count) || !open_shots(t, t->test, test, &test_count))
        return false;
    for (uint32_t i = 0; i < t->r.options.denoiser_count; i++) {
        t->denoiser = t->r.options.denoisers[i];
        if (!tune(t, train, train_count, test, test_count))
            return false;
    }
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
        return setting_parse(value, o->denoisers, o->denoiser_count, &t->fixed[t->fixed_count++], t->r.error, sizeof t->r.error);
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

static bool take_denoisers(tuner *t, const char *list)
{
    report_options *o = &t->r.options;
    char copy[512];
    snprintf(copy, sizeof copy, "%s", list);
    for (char *name = copy, *next; name; name = next) {
        next = strchr(name, ',');
        if (next)
            *next++ = 0;
        if (o->denoiser_count == NRD_DENOISER_COUNT || nrd_find_denoiser(name, &o->denoisers[o->denoiser_count]))
            return report_fail(&t->r, "'%s' is no denoiser, or one is named twice", name);
        o->denoiser_count++;
    }
    return true;
}

static bool parse(tuner *t, int argc, char **argv)
{
    report_options *o = &t->r.options;
    *o = (report_options){ .size_count = 1, .sizes = { { 240, 135 } }, .path_count = 1, .paths = { 1 }, .moving = 24, .still = 12, .stepped = 8, .pairs = 2, .samples = 64 };
    t->train = "interior,moving,colonnade";
    t->test = "roughness_ramp,thin";
    t->tries = 200;
    t->step = 1.6;
    if (argc < 3)
        return report_fail(&t->r, "a denoiser and a folder are needed; --help lists options");
    if (!take_denoisers(t, argv[1]))
        return false;
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
    if (argc == 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))) return fputs(usage, stdout), 0;
    if (!parse(&t, argc, argv)) return cli_fail("nrd-tune", "%s", t.r.error), 2;
    const gpu_desc device = { .device_index = t.r.options.device };
    bool ok = gpu_open(&t.r.gpu, &device, t.r.error, sizeof t.r.error) && tune_all(&t, train, test);
    for (int i = 0; i < MAX_SCENES; i++) {
        close_shot(&train[i]);
        close_shot(&test[i]);
    }
    gpu_close(&t.r.gpu);
    return ok ? 0 : cli_fail("nrd-tune", "%s", t.r.error);
}
