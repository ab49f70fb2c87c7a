#define _POSIX_C_SOURCE 200809L
#include "report/trial.h"

#include "common/cli.h"
#include "report/parallel.h"
#include "report/sequence.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Added to what logarithms are taken of. */
#define LEAST_FLICKER 1e-4
#define LEAST_ERROR 1e-4
#define LEAST_BIAS 0.01

/* ---- shots ---- */

/* The scale of a signal is that of its first reference. */
static bool find_scales(shot *s, int frames)
{
    size_t count = (size_t)s->frames[0].width * (size_t)s->frames[0].height;
    unsigned char *mask = malloc(count);
    bool found[SIGNAL_COUNT] = { false };
    for (int i = 0; mask && i < frames; i++)
        for (int k = 0; k < SIGNAL_COUNT; k++) {
            image reference;
            if (found[k] || !signal_get(&s->frames[i], NULL, (signal_id)k, SOURCE_REFERENCE, &reference))
                continue;
            signal_mask(&s->frames[i], (signal_id)k, mask);
            s->scales[k] = metrics_scale_of(&reference, mask, signal_is_unit((signal_id)k));
            found[k] = true;
            image_destroy(&reference);
        }
    free(mask);
    return mask != NULL;
}

static bool open_shot(report *r, const char *name, shot *s)
{
    const report_group group = { scene_find(name), r->options.sizes[0], r->options.paths[0] };
    int frames = sequence_length(&r->options);
    sequence seq;
    if (!group.scene)
        return report_fail(r, "'%s' is no scene", name);
    bool ok = sequence_open(&seq, r, &group, true);
    for (int i = 0; ok && i < frames; i++) {
        ok = sequence_frame(&seq, i, &s->frames[i]);
        cli_progress(name, i + 1, frames);
    }
    sequence_close(&seq);
    return ok && (find_scales(s, frames) || report_fail(r, "out of memory"));
}

bool shots_open(report *r, const char *names, shots *out)
{
    char copy[512];
    snprintf(copy, sizeof copy, "%s", names);
    memset(out, 0, sizeof *out);
    for (char *name = copy, *next; name; name = next) {
        next = strchr(name, ',');
        if (next)
            *next++ = 0;
        if (out->count == TRIAL_MAX_SHOTS)
            return report_fail(r, "at most %d scenes", TRIAL_MAX_SHOTS);
        if (!open_shot(r, name, &out->list[out->count++]))
            return false;
    }
    return true;
}

void shots_close(shots *s)
{
    for (int i = 0; i < s->count; i++)
        for (int k = 0; k < REPORT_MAX_FRAMES; k++)
            capture_destroy(&s->list[i].frames[k]);
    s->count = 0;
}

/* ---- errors of one signal ---- */

/* Sums; the members of a term are divided at the end. */
typedef struct errors {
    metrics motion, rest, step;
    metrics_flicker motion_flicker, rest_flicker;
    image before;
    int before_frame;
} errors;

/* What a frame is looked at for. */
typedef struct need { bool error, flicker; } need;

static need need_of(const report_options *o, int frame)
{
    int settled = o->moving + o->still / 2;
    switch (sequence_phase_of(o, frame)) {
    case PHASE_MOTION: return (need){ sequence_has_reference(o, frame), frame > 0 && sequence_has_reference(o, frame) && sequence_has_reference(o, frame - 1) };
    case PHASE_REST: return (need){ frame >= settled, frame > settled };
    default: return (need){ true, false };
    }
}

static bool is_read(const report_options *o, int frame)
{
    need now = need_of(o, frame);
    return now.error || now.flicker || (frame + 1 < sequence_length(o) && need_of(o, frame + 1).flicker);
}

static bool add_frame(errors *e, const report_options *o, const shot *s, signal_id signal, int frame, const image *m, unsigned char *mask)
{
    const capture *now = &s->frames[frame];
    sequence_phase phase = sequence_phase_of(o, frame);
    need wanted = need_of(o, frame);
    image reference;
    metrics errors;
    if (!wanted.error)
        return true;
    signal_mask(now, signal, mask);
    if (!signal_get(now, NULL, signal, SOURCE_REFERENCE, &reference))
        return false;
    bool ok = metrics_relative(m, &reference, mask, &errors);
    image_destroy(&reference);
    if (!ok)
        return false;
    metrics_add(phase == PHASE_MOTION ? &e->motion : phase == PHASE_REST ? &e->rest : &e->step, &errors);
    return !wanted.flicker || e->before_frame != frame - 1
        || metrics_add_flicker(&s->frames[frame - 1], &e->before, now, m, mask, &s->scales[signal], phase == PHASE_MOTION ? &e->motion_flicker : &e->rest_flicker);
}

/* Adds the logarithms of the terms. */
static void add_terms(const errors *e, double *terms)
{
    const metrics_flicker *motion = &e->motion_flicker, *rest = &e->rest_flicker;
    terms[0] += log(metrics_summarise(&e->motion).rel_mse_trimmed + LEAST_ERROR);
    terms[1] += log(metrics_summarise(&e->rest).rel_mse_trimmed + LEAST_ERROR);
    terms[2] += log(metrics_summarise(&e->step).rel_mse_trimmed + LEAST_ERROR);
    terms[3] += log((motion->pixels ? motion->sum / (double)motion->pixels : 0) + LEAST_FLICKER);
    terms[4] += log((rest->pixels ? rest->sum / (double)rest->pixels : 0) + LEAST_FLICKER);
    terms[5] += log(fabs(metrics_summarise(&e->motion).bias) + LEAST_BIAS);
}

/* ---- one denoiser on one shot ---- */

/* `final` is left out: it is made of the others. */
static bool is_scored(const method *m, int signal)
{
    return m->writes[signal] && signal != SIGNAL_FINAL;
}

static bool score_frame(const trial *t, const shot *s, method *m, int frame, errors *all, unsigned char *mask)
{
    const report_options *o = &t->r->options;
    capture out;
    bool read = is_read(o, frame);
    bool ok = method_frame(t->r, m, &s->frames[frame], read ? &out : NULL);
    for (int k = 0; ok && read && k < SIGNAL_COUNT; k++) {
        image picture;
        if (!is_scored(m, k))
            continue;
        ok = signal_get(&s->frames[frame], &out, (signal_id)k, SOURCE_DENOISED, &picture) && add_frame(&all[k], o, s, (signal_id)k, frame, &picture, mask);
        if (!ok)
            report_fail(t->r, "out of memory");
        image_destroy(&all[k].before);
        all[k].before = picture;
        all[k].before_frame = frame;
    }
    if (ok && read)
        capture_destroy(&out);
    return ok;
}

/* All frames, from frame number 0 on, so that the same values have the same result. */
static bool score_shot(const trial *t, const shot *s, method *m, double *terms, int *signals)
{
    errors all[SIGNAL_COUNT];
    unsigned char *mask = malloc((size_t)s->frames[0].width * (size_t)s->frames[0].height);
    bool ok = mask || report_fail(t->r, "out of memory");
    memset(all, 0, sizeof all);
    m->index = 0;
    for (int i = 0; ok && i < sequence_length(&t->r->options); i++)
        ok = score_frame(t, s, m, i, all, mask);
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        if (ok && is_scored(m, k)) {
            add_terms(&all[k], terms);
            (*signals)++;
        }
        image_destroy(&all[k].before);
    }
    free(mask);
    return ok;
}

/* ---- candidates ---- */

static void fill_method(const trial *t, const candidate *c, method *m)
{
    m->denoiser = t->denoiser;
    m->setting_count = 0;
    for (uint32_t i = 0; i < t->fixed_count; i++)
        m->settings[m->setting_count++] = t->fixed[i];
    for (int i = 0; i < t->knob_count; i++)
        if (!t->knobs[i].constant)
            m->settings[m->setting_count++] = (setting_value){ t->knobs[i].name, true, t->denoiser, c->values[i] };
}

static bool has_constants(const trial *t, const candidate *c, const float *has)
{
    for (int i = 0; i < t->knob_count; i++)
        if (t->knobs[i].constant && has[i] != (float)c->values[i])
            return false;
    return true;
}

/* Constants stand in the modules that all denoisers are made of. */
static pthread_mutex_t modules = PTHREAD_MUTEX_INITIALIZER;

static bool open_method(const trial *t, const candidate *c, const shot *s, method *m, float *has)
{
    bool ok = true;
    if (m->d && has_constants(t, c, has))
        return true;
    pthread_mutex_lock(&modules);
    method_close(m);
    for (int i = 0; i < t->knob_count; i++)
        if (t->knobs[i].constant) {
            has[i] = (float)c->values[i];
            constants_set(t->knobs[i].constant, has[i]);
        }
    ok = method_open(t->r, m, &s->frames[0]);
    pthread_mutex_unlock(&modules);
    return ok;
}

typedef struct batch {
    const trial *t;
    shots *s;
    candidate *candidates;
    double terms[TRIAL_MAX_LANES][TRIAL_MAX_SHOTS][TUNING_TERMS];
    int signals[TRIAL_MAX_LANES][TRIAL_MAX_SHOTS];
} batch;

static bool run_one(void *user, int i)
{
    batch *b = user;
    int which = i / b->s->count, k = i % b->s->count;
    const shot *s = &b->s->list[k];
    lane *l = &b->t->lanes[which];
    char reason[REPORT_ERROR];
    fill_method(b->t, &b->candidates[which], &l->methods[k]);
    if (!method_fits(&l->methods[k], &s->frames[0], reason, sizeof reason))
        return true;
    return open_method(b->t, &b->candidates[which], s, &l->methods[k], l->constants[k])
        && score_shot(b->t, s, &l->methods[k], b->terms[which][k], &b->signals[which][k]);
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

static bool judge(const batch *b, int which, verdict *out)
{
    int all = 0;
    memset(out, 0, sizeof *out);
    for (int k = 0; k < b->s->count; k++) {
        int signals = b->signals[which][k];
        if (signals)
            out->shots[k] = objective_of(b->terms[which][k], signals);
        for (int i = 0; i < TUNING_TERMS; i++)
            out->terms[i] += b->terms[which][k][i];
        all += signals;
    }
    if (!all)
        return report_fail(b->t->r, "%s can run on none of the scenes", nrd_denoiser_name(b->t->denoiser));
    out->objective = objective_of(out->terms, all);
    for (int i = 0; i < TUNING_TERMS; i++)
        out->terms[i] = exp(out->terms[i] / all);
    return true;
}

int trial_lanes(int shot_count)
{
    int wanted = 2 * parallel_threads() / (shot_count ? shot_count : 1);
    return wanted < 2 ? 2 : wanted > TRIAL_MAX_LANES ? TRIAL_MAX_LANES : wanted;
}

bool trial_run(const trial *t, shots *s, candidate *candidates, int count)
{
    batch b;
    memset(&b, 0, sizeof b);
    b.t = t;
    b.s = s;
    b.candidates = candidates;
    bool ok = parallel_each(count * s->count, run_one, &b);
    for (int i = 0; ok && i < count; i++)
        ok = judge(&b, i, &candidates[i].verdict);
    return ok;
}

void trial_close(const trial *t, const shots *s)
{
    for (int i = 0; i < trial_lanes(s->count); i++)
        for (int k = 0; k < s->count; k++)
            method_close(&t->lanes[i].methods[k]);
}
