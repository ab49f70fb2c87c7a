/* nrd-tune: searches the settings of denoisers, and the named constants inside their shaders, for less error and flicker on
   some scenes, and says what is gained on others. Built on shaders in which the constants are specialization constants.

   What is made small is the weighted geometric mean, over scenes and signals, of six numbers (formulas: common/metrics.h):
   trimmed relMSE in motion, weight 3; at rest, 1; over the frames after all lights become four times as bright, 1; flicker
   in motion, 1; at rest, 1; the size of the bias in motion, 1. Coordinate search in factors: each value is multiplied and
   divided by a step, several values at once on all processors; those that are better in the mean, and on no scene that they
   are trained on clearly worse (so that nothing is paid for by one scene), and do not flicker more than before the search, are
   kept, the best first, the others where they are still better on top of it. The step shrinks to its root when a round brings
   nothing. */
#define _POSIX_C_SOURCE 200809L
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"

#include "common/cli.h"
#include "report/trial.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

static const char usage[] =
    "usage: nrd-tune DENOISER,... OUT/ [options]\n"
    "References are kept in OUT/cache; nrd-report OUT/ shows what was found (OUT/tuning), before and after.\n"
    "  --train LIST       scenes to tune on, default interior,moving,colonnade\n"
    "  --test LIST        scenes left out, default roughness_ramp,thin\n"
    "  --set KEY=VALUE    starts from this value and keeps it; may be repeated\n"
    "  --only LIST        settings and constants to search, default: all numbers that are not 0\n"
    "  --tries N          evaluations at most for each denoiser, default 200\n"
    "  --seconds N        of search at most for each denoiser, default: no limit\n"
    "  --step F           first factor, default 1.6\n"
    "  --size WxH         default 240x135\n"
    "  --frames M,R,L     in motion, at rest, after the light step; default 24,12,8\n"
    "  --pairs N          pairs of frames in motion that are compared with a reference, default 2\n"
    "  --paths P          per pixel and lobe, default 1\n"
    "  --ref SPP          samples per pixel of references, default 64\n"
    "  --device N         Vulkan device, default: the first\n";

#define LEAST_STEP 1.08
#define LEAST_GAIN 0.002  /* of the objective: less is within the noise of the references */
#define MOST_LOSS 0.01    /* of a scene's own objective */
#define MOST_FLICKER 0.01 /* above that before the search, in motion and at rest: less error is not to be bought with it */

typedef struct tuner {
    report r;
    nrd_denoiser denoiser; /* at work on this one */
    const char *train, *test, *only;
    double step, seconds, start;
    int tries, tried;
    setting_value fixed[REPORT_MAX_SETTINGS];
    uint32_t fixed_count;
    shader_constants constants;
    knob knobs[TRIAL_MAX_KNOBS];
    int knob_count;
    candidate best;
    verdict first; /* before the search */
} tuner;

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
    if (t->knob_count == TRIAL_MAX_KNOBS || !is_wanted(t, k->name))
        return;
    t->best.values[t->knob_count] = k->first;
    t->knobs[t->knob_count++] = *k;
}

/* Numbers that are not 0: a switch or a 0 has no factor. What the application must know as well stays. */
static void add_settings(tuner *t)
{
    nrd_setting row;
    for (uint32_t i = 0; nrd_get_setting(t->denoiser, i, &row); i++) {
        bool shared = !strncmp(row.name, "hit_distance_", strlen("hit_distance_"));
        if (row.is_float && row.value != 0 && !shared && !setting_given(t->fixed, t->fixed_count, t->denoiser, row.name))
            add_knob(t, &(knob){ row.name, row.unit, NULL, row.value, row.min, row.max });
    }
}

/* What the bits of a texture mean, and numbers that stand for a case: no other value makes sense. */
static bool is_encoding(const char *name)
{
    static const char *const names[] = { "OCT_MAX", "DEPTH_STEPS", "WIDTH_ANY", "LIT", "FACES_AWAY", "NOTHING" };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!strcmp(name, names[i]))
            return true;
    return false;
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
        if (value != 0 && !is_encoding(c->name))
            add_knob(t, &(knob){ c->name, "in the shaders", c, value, value < 0 ? -1e6 : 1e-6, value < 0 ? -1e-6 : 1e6 });
    }
    return ok || report_fail(&t->r, "a shader module cannot be read");
}

/* ---- search ---- */

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool is_over(const tuner *t)
{
    return t->tried >= t->tries || (t->seconds > 0 && seconds_now() - t->start > t->seconds);
}

static bool is_better(const tuner *t, const verdict *now, const verdict *best)
{
    for (int i = TUNING_FLICKER; i <= TUNING_FLICKER_AT_REST; i++)
        if (now->terms[i] > t->first.terms[i] * (1 + MOST_FLICKER))
            return false;
    for (int i = 0; i < TRIAL_MAX_SHOTS; i++)
        if (now->shots[i] > best->shots[i] * (1 + MOST_LOSS))
            return false;
    return now->objective < best->objective * (1 - LEAST_GAIN);
}

/* Candidates of one batch, each the best so far but for one knob. */
typedef struct moves {
    candidate list[TRIAL_MAX_LANES];
    int knobs[TRIAL_MAX_LANES];
    int count;
} moves;

static void add_move(const tuner *t, moves *m, int knob, double factor)
{
    const struct knob *k = &t->knobs[knob];
    double before = t->best.values[knob], value = fmin(fmax(before * factor, k->min), k->max);
    if (value == before || t->tried + m->count >= t->tries)
        return;
    m->list[m->count] = t->best;
    m->list[m->count].values[knob] = value;
    m->knobs[m->count++] = knob;
}

static void print_try(tuner *t, const moves *m, int i, const char *note)
{
    int knob = m->knobs[i];
    t->tried++;
    printf("%4d  %.5f  %s %g%s\n", t->tried, m->list[i].verdict.objective, t->knobs[knob].name, m->list[i].values[knob], note);
    fflush(stdout);
}

/* The move that has gained most over `before`, of those to knobs that have not been looked at; -1: none gains. */
static int best_move(const tuner *t, const moves *m, const verdict *before, const bool *seen)
{
    int best = -1;
    for (int i = 0; i < m->count; i++)
        if (!seen[m->knobs[i]] && is_better(t, &m->list[i].verdict, before) && (best < 0 || m->list[i].verdict.objective < m->list[best].verdict.objective))
            best = i;
    return best;
}

/* Tries a move on top of the best so far. */
static bool try_on_top(tuner *t, const trial *at, shots *s, int knob, double value)
{
    static moves one;
    one.count = 1;
    one.knobs[0] = knob;
    one.list[0] = t->best;
    one.list[0].values[knob] = value;
    if (!trial_run(at, s, one.list, 1))
        return false;
    bool better = is_better(t, &one.list[0].verdict, &t->best.verdict);
    print_try(t, &one, 0, better ? "  kept too" : "");
    if (better)
        t->best = one.list[0];
    return true;
}

static bool try_moves(tuner *t, const trial *at, shots *s, moves *m, bool *any)
{
    bool seen[TRIAL_MAX_KNOBS] = { false };
    const verdict before = t->best.verdict;
    if (!trial_run(at, s, m->list, m->count))
        return false;
    int best = best_move(t, m, &before, seen);
    for (int i = 0; i < m->count; i++)
        print_try(t, m, i, i == best ? "  kept" : "");
    if (best < 0)
        return true;
    *any = true;
    t->best = m->list[best];
    seen[m->knobs[best]] = true;
    for (int i; t->tried < t->tries && (i = best_move(t, m, &before, seen)) >= 0;) {
        seen[m->knobs[i]] = true;
        if (!try_on_top(t, at, s, m->knobs[i], m->list[i].values[m->knobs[i]]))
            return false;
    }
    return true;
}

static bool search(tuner *t, const trial *at, shots *s)
{
    int lanes = trial_lanes(s->count);
    t->start = seconds_now();
    for (double step = t->step; step >= LEAST_STEP && !is_over(t);) {
        bool any = false;
        for (int i = 0; i < t->knob_count && !is_over(t);) {
            static moves m;
            m.count = 0;
            for (; i < t->knob_count && m.count + 2 <= lanes; i++) {
                add_move(t, &m, i, step);
                add_move(t, &m, i, 1 / step);
            }
            if (!try_moves(t, at, s, &m, &any))
                return false;
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

static void print_defaults(const tuner *t)
{
    printf("\nnew values\n");
    for (int i = 0; i < t->knob_count; i++)
        if (t->best.values[i] != t->knobs[i].first)
            printf("  %-34s %10g -> %-10g %s\n", t->knobs[i].name, t->knobs[i].first, t->best.values[i], t->knobs[i].unit);
}

static candidate first_values(const tuner *t)
{
    candidate c;
    memset(&c, 0, sizeof c);
    for (int i = 0; i < t->knob_count; i++)
        c.values[i] = t->knobs[i].first;
    return c;
}

/* Before and after on scenes that the search has not seen. */
static bool compare_left_out(const tuner *t, const trial *at, shots *s, verdict *before, verdict *after)
{
    candidate both[2] = { first_values(t), t->best };
    if (!trial_run(at, s, both, 2))
        return false;
    *before = both[0].verdict;
    *after = both[1].verdict;
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
        if (t->best.values[i] != t->knobs[i].first) {
            tuning_change *c = &out.changes[out.change_count++];
            snprintf(c->name, sizeof c->name, "%s", t->knobs[i].name);
            c->before = t->knobs[i].first;
            c->after = t->best.values[i];
        }
    return tuning_save(&t->r, &out);
}

static bool tune_on(tuner *t, const trial *train, shots *seen, const trial *test, shots *left_out)
{
    verdict verdicts[4]; /* trained on and left out, before and after each */
    if (!trial_run(train, seen, &t->best, 1))
        return false;
    verdicts[0] = t->first = t->best.verdict;
    printf("%s, %d values to search\n%-22s %9s %9s %9s %9s %9s %9s %9s\n", nrd_denoiser_name(t->denoiser), t->knob_count, "", "objective", "motion", "rest",
           "step", "flicker", "at rest", "bias");
    print_verdict("trained on, before", &verdicts[0]);
    fflush(stdout);
    if (!search(t, train, seen))
        return false;
    verdicts[1] = t->best.verdict;
    print_verdict("trained on, after", &verdicts[1]);
    if (!compare_left_out(t, test, left_out, &verdicts[2], &verdicts[3]) || !save(t, verdicts))
        return false;
    print_defaults(t);
    return true;
}

static bool tune(tuner *t, shots *seen, shots *left_out)
{
    t->knob_count = t->tried = 0;
    memset(&t->constants, 0, sizeof t->constants);
    add_settings(t);
    if (!add_constants(t))
        return false;
    lane *lanes = calloc(2 * TRIAL_MAX_LANES, sizeof *lanes);
    if (!lanes)
        return report_fail(&t->r, "out of memory");
    const trial train = { &t->r, t->denoiser, t->fixed, t->fixed_count, t->knobs, t->knob_count, lanes };
    const trial test = { &t->r, t->denoiser, t->fixed, t->fixed_count, t->knobs, t->knob_count, lanes + TRIAL_MAX_LANES };
    bool ok = tune_on(t, &train, seen, &test, left_out);
    trial_close(&train, seen);
    trial_close(&test, left_out);
    free(lanes);
    for (int i = 0; i < t->knob_count; i++) /* denoisers share shaders: the next one starts from what is shipped */
        if (t->knobs[i].constant)
            constants_set(t->knobs[i].constant, (float)t->knobs[i].first);
    return ok;
}

static bool tune_all(tuner *t, shots *train, shots *test)
{
    if (!shots_open(&t->r, t->train, train) || !shots_open(&t->r, t->test, test))
        return false;
    for (uint32_t i = 0; i < t->r.options.denoiser_count; i++) {
        t->denoiser = t->r.options.denoisers[i];
        if (!tune(t, train, test))
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
    if (!strcmp(name, "--seconds") && cli_number(value, &t->seconds) && t->seconds >= 0) return true;
    if (!strcmp(name, "--pairs") && cli_integer(value, 1, 64, &number)) return o->pairs = (int)number, true;
    if (!strcmp(name, "--step") && cli_number(value, &t->step) && t->step > 1 && t->step <= 10) return true;
    if (!strcmp(name, "--ref") && cli_integer(value, 2, 1 << 20, &number)) return o->samples = (int)number / 2 * 2, true;
    if (!strcmp(name, "--device") && cli_integer(value, 0, 63, &number)) return o->device = (int)number, true;
    if (!strcmp(name, "--paths") && cli_number(value, &o->paths[0].count) && o->paths[0].count >= 0.05 && o->paths[0].count <= 8) return true;
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
    *o = (report_options){ .size_count = 1, .sizes = { { 240, 135 } }, .path_count = 1, .paths = { { 1, false } }, .moving = 24, .still = 12, .stepped = 8, .samples = 64 };
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
    o->pairs = o->pairs ? o->pairs : o->moving < 4 ? 1 : 2;
    if (2 * o->pairs > o->moving)
        return report_fail(&t->r, "--pairs: %d pairs do not fit into %d frames", o->pairs, o->moving);
    mkdir(o->folder, 0777);
    return true;
}

int main(int argc, char **argv)
{
    static tuner t;
    static shots train, test;
    if (argc == 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))) return fputs(usage, stdout), 0;
    if (!parse(&t, argc, argv)) return cli_fail("nrd-tune", "%s", t.r.error), 2;
    const gpu_desc device = { .device_index = t.r.options.device };
    bool ok = gpu_open(&t.r.gpu, &device, t.r.error, sizeof t.r.error) && tune_all(&t, &train, &test);
    shots_close(&train);
    shots_close(&test);
    gpu_close(&t.r.gpu);
    return ok ? 0 : cli_fail("nrd-tune", "%s", t.r.error);
}
