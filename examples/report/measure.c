#include "common/cli.h"
#include "common/gpu.h"
#include "report/baseline.h"
#include "report/crops.h"
#include "report/method.h"
#include "report/parallel.h"
#include "report/score.h"
#include "report/sequence.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_TRACKS = 1024, MAX_EXTRA = 64, WARM_UP = 6 };

typedef enum track_kind { TRACK_DENOISER, TRACK_NOISY, TRACK_SPATIAL, TRACK_PATHS } track_kind;

/* One signal from one source: what becomes a row. */
typedef struct track {
    track_kind kind;
    int method;      /* whose picture it is, or whose time is spent otherwise; -1: none */
    signal_id signal;
    int radius;      /* TRACK_SPATIAL */
    double ms;
    double paths;    /* traced per pixel */
    image picture;   /* of this frame, until it is scored */
    score score;
} track;

typedef struct measurement {
    report *r;
    sequence seq, large;   /* large: of another size, where times are not taken at that of the errors */
    sequence *clock;       /* that on which times are taken */
    baseline base, rival;  /* on seq and on clock */
    method methods[REPORT_MAX_METHODS];
    int method_count, open_count;
    track *tracks;
    int track_count;
    truth truths[SIGNAL_COUNT];
    bool wanted[SIGNAL_COUNT];
    capture first, timed, then, now;
    capture steady; /* the planes of `timed` */
    int frame;
    double trace_ms, path_ms;
} measurement;

/* ---- methods ---- */

static bool add_method(measurement *m, const method *described, signal_id signal)
{
    if (m->method_count == REPORT_MAX_METHODS)
        return report_fail(m->r, "more than %d denoisers with presets", REPORT_MAX_METHODS);
    m->methods[m->method_count] = *described;
    m->methods[m->method_count++].desc.reference_signal = signal;
    return true;
}

/* What the scene, and the number of paths, say something about: shadows have one ray, whatever the number of paths. */
static bool is_wanted(const measurement *m, const method *described)
{
    const report_group *group = &m->seq.group;
    bool shadows = method_takes_shadows(described, &m->first), usual = report_same_paths(group->paths, report_usual_paths(&m->r->options));
    if (group->scene->for_shadows && !method_takes_any_signal(described, &m->first))
        return shadows;
    return (usual || !shadows) && (group->paths.count <= 1 || !method_takes_one_path(described, &m->first));
}

/* An average counts pixels that were not sampled as closed. */
static bool can_be_averaged(const measurement *m, int signal)
{
    bool occlusion = signal == SIGNAL_AO || signal == SIGNAL_SPECULAR_AO;
    return m->wanted[signal] && signal != SIGNAL_FINAL && (!occlusion || sequence_share(&m->seq.group) == 1);
}

/* Those that average any signal do so for all that others write, once these are known. */
static bool add_described(measurement *m, method *described, bool any_signal_round)
{
    bool any = method_takes_any_signal(described, &m->first), nothing_wanted = true;
    char reason[REPORT_ERROR];
    if (any != any_signal_round || !is_wanted(m, described))
        return true;
    if (m->seq.group.paths.checkerboard && !method_take_checkerboard(described, &m->first))
        return true;
    if (!method_fits(described, &m->first, reason, sizeof reason)) {
        if (described->is_default)
            fprintf(stderr, "%s: without %s: %s\n", m->seq.group.scene->name, nrd_denoiser_name(described->denoiser), reason);
        return true;
    }
    if (!any)
        return add_method(m, described, SIGNAL_DIFFUSE);
    for (int s = 0; s < SIGNAL_COUNT; s++)
        nothing_wanted &= !m->wanted[s];
    m->wanted[SIGNAL_DIFFUSE] |= nothing_wanted;
    for (int s = 0; s < SIGNAL_COUNT; s++)
        if (can_be_averaged(m, s) && !add_method(m, described, (signal_id)s))
            return false;
    return true;
}

static bool add_methods(measurement *m, bool any_signal_round)
{
    const report_options *o = &m->r->options;
    for (uint32_t d = 0; d < o->denoiser_count; d++)
        for (uint32_t p = 0; p < o->preset_count + o->variant_count; p++) {
            method described;
            const report_variant *variant = p < o->preset_count ? NULL : &o->variants[p - o->preset_count];
            if (!method_describe(m->r, o->denoisers[d], variant ? NRD_PRESET_BALANCED : o->presets[p], variant, &described))
                return false;
            /* a preset that changes nothing is the balanced one */
            if ((described.setting_count || described.is_default) && !add_described(m, &described, any_signal_round))
                return false;
        }
    return true;
}

static bool open_one(void *user, int i)
{
    measurement *m = user;
    return m->methods[m->open_count + i].d || method_open(m->r, &m->methods[m->open_count + i], &m->first);
}

static bool open_added(measurement *m)
{
    bool ok = parallel_each(m->method_count - m->open_count, open_one, m);
    for (; ok && m->open_count < m->method_count; m->open_count++)
        for (int s = 0; s < SIGNAL_COUNT; s++)
            m->wanted[s] |= m->methods[m->open_count].writes[s];
    return ok;
}

static bool open_methods(measurement *m)
{
    return add_methods(m, false) && open_added(m) && add_methods(m, true) && open_added(m);
}

static bool open_copier(measurement *m, copier *c)
{
    double most = 0;
    for (int i = 0; i < m->method_count; i++)
        most = fmax(most, m->methods[i].bytes);
    return copier_open(c, m->rival.g, most) || report_fail(m->r, "%s", gpu_error(m->rival.g));
}

static bool start_clock(void *user, int i)
{
    measurement *m = user;
    return method_time_start(m->r, &m->methods[i], &m->steady);
}

/* In turn, so that what slows the device down for a while slows all of them, and the copies that they are compared with. */
static bool time_methods(measurement *m)
{
    copier copies = { 0 };
    m->steady = m->timed;
    m->steady.cut = 0; /* in the middle of a shot: a cut would empty the history */
    bool ok = parallel_each(m->method_count, start_clock, m) && open_copier(m, &copies);
    for (int round = 0; round < WARM_UP + m->r->options.repeats && ok; round++)
        for (int i = 0; i < m->method_count && ok; i++)
            ok = method_time_once(m->r, &m->methods[i], &m->steady, &copies, round >= WARM_UP);
    for (int i = 0; i < m->method_count && ok; i++)
        method_time_end(&m->methods[i]);
    copier_close(&copies);
    return ok;
}

/* ---- tracks ---- */

static track *add_track(measurement *m, track_kind kind, int method, signal_id signal)
{
    if (m->track_count == MAX_TRACKS) {
        report_fail(m->r, "more than %d rows for one scene", MAX_TRACKS);
        return NULL;
    }
    track *t = &m->tracks[m->track_count++];
    memset(t, 0, sizeof *t);
    t->kind = kind;
    t->method = method;
    t->signal = signal;
    t->paths = signal == SIGNAL_SHADOW || signal == SIGNAL_TRANSLUCENCY ? 1 : m->seq.group.paths.count; /* shadows: one ray per pixel */
    score_start(&t->score);
    return t;
}

/* What the time of a denoiser would buy without it. */
static bool add_rivals(measurement *m, int method, signal_id signal, int radius, double filter_ms)
{
    double ms = m->methods[method].ms;
    track *spatial = add_track(m, TRACK_SPATIAL, method, signal), *paths = spatial ? add_track(m, TRACK_PATHS, method, signal) : NULL;
    if (!paths)
        return false;
    spatial->radius = radius;
    spatial->ms = filter_ms;
    paths->ms = ms;
    paths->paths = fmin(paths->paths + ms / m->path_ms, MAX_EXTRA);
    return true;
}

static bool add_method_tracks(measurement *m, int index)
{
    const method *method = &m->methods[index];
    bool rivals = method->is_default && !method_takes_any_signal(method, &m->first);
    int radius = 1, signals = 0;
    double filter_ms = 0;
    for (int s = 0; s < SIGNAL_COUNT; s++)
        signals += s != SIGNAL_FINAL && method->writes[s];
    /* the time of a denoiser of several signals is for all of them */
    if (rivals && !baseline_radius_for(&m->rival, method->ms / (signals ? signals : 1), &radius, &filter_ms))
        return report_fail(m->r, "%s", gpu_error(m->rival.g));
    for (int s = 0; s < SIGNAL_COUNT; s++) {
        if (!method->writes[s])
            continue;
        track *t = add_track(m, TRACK_DENOISER, index, (signal_id)s);
        if (!t || (rivals && !add_rivals(m, index, (signal_id)s, radius, signals * filter_ms)))
            return false;
        t->ms = method->ms;
    }
    return true;
}

static bool add_tracks(measurement *m)
{
    for (int s = 0; s < SIGNAL_COUNT; s++)
        if (m->wanted[s] && !add_track(m, TRACK_NOISY, -1, (signal_id)s))
            return false;
    for (int i = 0; i < m->method_count; i++)
        if (!add_method_tracks(m, i))
            return false;
    return true;
}

/* ---- pictures of one frame ---- */

/* The pictures of a method, where the frame has a reference; elsewhere it only goes on. */
static bool take_denoised(void *user, int index)
{
    measurement *m = user;
    bool wanted = sequence_has_reference(&m->r->options, m->frame);
    capture out;
    bool ok = method_frame(m->r, &m->methods[index], &m->now, wanted ? &out : NULL);
    for (int i = 0; i < m->track_count && ok && wanted; i++) {
        track *t = &m->tracks[i];
        if (t->kind == TRACK_DENOISER && t->method == index && !signal_get(&m->now, &out, t->signal, SOURCE_DENOISED, &t->picture))
            ok = report_fail(m->r, "out of memory");
    }
    if (wanted)
        capture_destroy(&out);
    return ok;
}

static bool write_crops(measurement *m)
{
    bool ok = true;
    for (int i = 0; i < m->track_count && ok; i++) {
        const track *t = &m->tracks[i];
        const method *method = t->method >= 0 ? &m->methods[t->method] : NULL;
        if (t->kind == TRACK_DENOISER && method->is_default)
            ok = crops_write(m->r, &m->seq.group, nrd_denoiser_name(method->denoiser), &m->truths[t->signal], &m->now, &t->picture);
    }
    return ok;
}

/* Where not all pixels are sampled the others hold no occlusion, and those that hold some count for them, as in radiance. */
static bool take_noisy(measurement *m, signal_id signal, image *out)
{
    if (!signal_get(&m->now, NULL, signal, SOURCE_NOISY, out))
        return report_fail(m->r, "out of memory");
    double share = sequence_share(&m->seq.group);
    bool thin = share < 1 && (signal == SIGNAL_AO || signal == SIGNAL_SPECULAR_AO);
    for (size_t i = 0; thin && i < image_pixels(out); i++)
        out->planes[0][i] /= (float)share;
    return true;
}

static bool take_filtered(measurement *m, signal_id signal, int radius, image *out)
{
    return take_noisy(m, signal, out) && (baseline_filter(&m->base, radius, out) || report_fail(m->r, "%s", gpu_error(m->base.g)));
}

/* As a denoiser would: the light is filtered, not the textures that it falls on. */
static bool compose_filtered(measurement *m, int radius, image *out)
{
    image diffuse = { 0 }, specular = { 0 }, shadow = { 0 };
    bool sun = m->seq.scene.def->has_sun;
    bool ok = take_filtered(m, SIGNAL_DIFFUSE, radius, &diffuse) && take_filtered(m, SIGNAL_SPECULAR, radius, &specular)
        && (!sun || take_filtered(m, SIGNAL_SHADOW, radius, &shadow))
        && (signal_compose(&m->now, &diffuse, &specular, sun ? &shadow : NULL, out) || report_fail(m->r, "out of memory"));
    image_destroy(&diffuse);
    image_destroy(&specular);
    image_destroy(&shadow);
    return ok;
}

static bool take_input(measurement *m, track *t)
{
    if (t->kind == TRACK_NOISY)
        return take_noisy(m, t->signal, &t->picture);
    return t->signal == SIGNAL_FINAL ? compose_filtered(m, t->radius, &t->picture) : take_filtered(m, t->signal, t->radius, &t->picture);
}

/* ---- more paths instead ---- */

static double random_of(size_t pixel, int frame)
{
    uint32_t x = (uint32_t)pixel * 0x9e3779b1u + (uint32_t)frame * 0x85ebca77u;
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return (double)(x ^ (x >> 16)) / 4294967296.0;
}

/* Adds path `number` to the mean of a track. A fraction of a path is one in that share of the pixels; below one path per
   pixel, samples count for the pixels that get none. */
static void add_path(track *t, const image *one, int number, int frame)
{
    int whole = (int)t->paths;
    for (size_t i = 0; i < image_pixels(one); i++) {
        int count = whole + (random_of(i, frame) < t->paths - whole);
        for (int k = 0; k < one->channels && number < count; k++)
            t->picture.planes[k][i] += one->planes[k][i] / (float)(whole ? count : t->paths);
    }
}

static bool add_extra(measurement *m, int frame, int number)
{
    capture extra;
    bool ok = sequence_extra(&m->seq, frame, number, &extra);
    for (int i = 0; i < m->track_count && ok; i++) {
        track *t = &m->tracks[i];
        image one;
        if (t->kind != TRACK_PATHS || number >= ceil(t->paths))
            continue;
        if (!signal_get(&extra, NULL, t->signal, SOURCE_NOISY, &one))
            ok = report_fail(m->r, "out of memory");
        else if (!t->picture.channels && !image_create(&t->picture, one.width, one.height, one.channels))
            ok = report_fail(m->r, "out of memory");
        else
            add_path(t, &one, number, frame);
        image_destroy(&one);
    }
    capture_destroy(&extra);
    return ok;
}

static bool take_paths(measurement *m, int frame)
{
    double most = 0;
    bool ok = true;
    for (int i = 0; i < m->track_count; i++)
        if (m->tracks[i].kind == TRACK_PATHS)
            most = fmax(most, m->tracks[i].paths);
    for (int number = 0; number < ceil(most) && ok; number++)
        ok = add_extra(m, frame, number);
    return ok;
}

/* ---- one frame ---- */

/* A filter has no history: after the light step there is nothing to see of it. */
static bool is_input_wanted(const measurement *m, const track *t, int frame)
{
    return t->kind == TRACK_NOISY || (t->kind == TRACK_SPATIAL && sequence_phase_of(&m->r->options, frame) != PHASE_STEP);
}

static bool take_pictures(measurement *m, int frame)
{
    const report_options *o = &m->r->options;
    bool ok = parallel_each(m->method_count, take_denoised, m);
    if (!ok || !sequence_has_reference(o, frame))
        return ok;
    if (frame == o->moving - 1 && crops_wanted(o, &m->seq.group))
        ok = write_crops(m);
    for (int i = 0; i < m->track_count && ok; i++)
        if (is_input_wanted(m, &m->tracks[i], frame))
            ok = take_input(m, &m->tracks[i]);
    return ok && (frame >= o->moving || take_paths(m, frame));
}

static bool score_track(void *user, int i)
{
    measurement *m = user;
    track *t = &m->tracks[i];
    return !t->picture.channels
        || score_add(&t->score, &m->truths[t->signal], &m->r->options, m->frame, m->then.plane_count ? &m->then : NULL, &m->now, &t->picture);
}

static bool score_frame(measurement *m, int frame)
{
    const capture *then = m->then.plane_count ? &m->then : NULL;
    bool ok = true;
    m->frame = frame;
    for (int s = 0; s < SIGNAL_COUNT && ok; s++)
        if (m->wanted[s])
            ok = truth_advance(&m->truths[s], &m->r->options, frame, then, &m->now) || report_fail(m->r, "out of memory");
    return ok && take_pictures(m, frame) && (parallel_each(m->track_count, score_track, m) || report_fail(m->r, "out of memory"));
}

static bool run_frames(measurement *m, int done, int total)
{
    int frames = sequence_length(&m->r->options);
    for (int frame = 0; frame < frames; frame++) {
        if (!sequence_frame(&m->seq, frame, &m->now) || !score_frame(m, frame))
            return false;
        capture_destroy(&m->then);
        m->then = m->now;
        memset(&m->now, 0, sizeof m->now);
        cli_progress("measuring", done * frames + frame + 1, total * frames);
    }
    return true;
}

/* ---- rows ---- */

static void fill_times(const method *method, report_row *row)
{
    double pixels = (double)row->time_width * row->time_height, *v = row->values;
    v[REPORT_ms_low] = method->low;
    v[REPORT_ms_high] = method->high;
    v[REPORT_bytes_per_pixel] = method->bytes / pixels;
    v[REPORT_copy_share] = method->copy_ms / method->ms;
    v[REPORT_copy_rate] = method->bytes / method->copy_ms * 1e-6;
    v[REPORT_permanent_bytes] = method->permanent_bytes;
    v[REPORT_transient_bytes] = method->transient_bytes;
    row->pass_count = method->pass_count;
    memcpy(row->passes, method->passes, sizeof row->passes);
}

/* Relative to the reference under the first light. */
static bool reference_noise(measurement *m, signal_id signal, double *out)
{
    capture halves, plain;
    image noise, reference = { 0 };
    metrics errors;
    bool ok = true;
    *out = NAN;
    ok = sequence_noise(&m->seq, &halves, &plain);
    memset(&noise, 0, sizeof noise);
    if (ok && signal_get(&halves, NULL, signal, SOURCE_REFERENCE, &noise)) {
        ok = signal_get(&plain, NULL, signal, SOURCE_REFERENCE, &reference)
            && metrics_compare(&noise, &reference, m->truths[signal].mask, &m->truths[signal].scale, &errors);
        *out = ok ? errors.rel_mse_trimmed : NAN;
    }
    capture_destroy(&halves);
    capture_destroy(&plain);
    image_destroy(&noise);
    image_destroy(&reference);
    return ok || report_fail(m->r, "out of memory");
}

static bool fill_row(measurement *m, const track *t, double noise)
{
    static const char *const kinds[] = { REPORT_KIND_DENOISER, REPORT_KIND_NOISY, REPORT_KIND_SPATIAL, REPORT_KIND_PATHS };
    const report_group *g = &m->seq.group;
    const method *method = t->method >= 0 ? &m->methods[t->method] : NULL;
    report_row *row = rows_add(&m->r->rows);
    if (!row)
        return report_fail(m->r, "out of memory");
    snprintf(row->scene, sizeof row->scene, "%s", g->scene->name);
    snprintf(row->kind, sizeof row->kind, "%s", kinds[t->kind]);
    snprintf(row->method, sizeof row->method, "%s", method ? nrd_denoiser_name(method->denoiser) : "");
    snprintf(row->preset, sizeof row->preset, "%s", method ? method->preset : "");
    snprintf(row->signal, sizeof row->signal, "%s", signal_name(t->signal));
    row->width = g->size.width;
    row->height = g->size.height;
    row->paths = g->paths;
    row->time_width = m->clock->group.size.width;
    row->time_height = m->clock->group.size.height;
    row->values[REPORT_ms] = t->ms;
    row->values[REPORT_ns_per_pixel] = t->ms * 1e6 / ((double)row->time_width * row->time_height);
    row->values[REPORT_trace_ms] = m->trace_ms;
    row->values[REPORT_paths_traced] = t->paths;
    row->values[REPORT_reference_noise] = noise;
    score_fill(&t->score, &m->truths[t->signal], &m->r->options, row);
    if (t->kind == TRACK_DENOISER)
        fill_times(method, row);
    return true;
}

static bool fill_rows(measurement *m)
{
    double noise[SIGNAL_COUNT];
    for (int s = 0; s < SIGNAL_COUNT; s++)
        if (m->wanted[s] && !reference_noise(m, (signal_id)s, &noise[s]))
            return false;
    for (int i = 0; i < m->track_count; i++)
        if (!fill_row(m, &m->tracks[i], noise[m->tracks[i].signal]))
            return false;
    return true;
}

/* ---- the whole ---- */

static bool open_baseline(measurement *m, baseline *b, sequence *seq, const capture *frame)
{
    return baseline_open(b, &seq->tracer, frame->width, frame->height, frame->denoising_range, m->r->error, sizeof m->r->error);
}

/* Tracer, frame and rivals at the size at which times are taken. */
static bool open_clock(measurement *m, const report_group *group)
{
    report_group timed = *group;
    double one, three;
    timed.size = m->r->options.time_size;
    m->clock = timed.size.width ? &m->large : &m->seq;
    if (m->clock == &m->large && !sequence_open(&m->large, m->r, &timed, false))
        return false;
    if (!sequence_trace_ms(m->clock, 1, &one) || !sequence_trace_ms(m->clock, 3, &three)
        || !sequence_trace_ms(m->clock, group->paths.count < 1 ? 1 : (int)group->paths.count, &m->trace_ms))
        return false;
    if (!(one > 0))
        return report_fail(m->r, "the device has no timestamps");
    m->path_ms = fmax((three - one) / 2, 1e-3 * one); /* noise must not make paths free */
    return sequence_frame(m->clock, 0, &m->timed) && open_baseline(m, &m->rival, m->clock, &m->timed);
}

static bool prepare(measurement *m, report *r, const report_group *group)
{
    m->tracks = calloc(MAX_TRACKS, sizeof *m->tracks);
    for (int s = 0; s < SIGNAL_COUNT; s++)
        m->truths[s].signal = (signal_id)s;
    if (!m->tracks)
        return report_fail(r, "out of memory");
    return sequence_open(&m->seq, r, group, true) && open_clock(m, group) && sequence_frame(&m->seq, 0, &m->first)
        && open_baseline(m, &m->base, &m->seq, &m->first) && open_methods(m) && time_methods(m)
        && add_tracks(m);
}

static void release(measurement *m)
{
    for (int i = 0; i < m->track_count; i++) {
        score_free(&m->tracks[i].score);
        image_destroy(&m->tracks[i].picture);
    }
    for (int i = 0; i < m->method_count; i++)
        method_close(&m->methods[i]);
    for (int s = 0; s < SIGNAL_COUNT; s++)
        truth_free(&m->truths[s]);
    baseline_close(&m->base);
    baseline_close(&m->rival);
    sequence_close(&m->seq);
    sequence_close(&m->large);
    capture_destroy(&m->first);
    capture_destroy(&m->timed);
    capture_destroy(&m->then);
    capture_destroy(&m->now);
    free(m->tracks);
    free(m);
}

bool report_measure(report *r, const report_group *group, int done, int total)
{
    measurement *m = calloc(1, sizeof *m);
    if (!m)
        return report_fail(r, "out of memory");
    m->r = r;
    bool ok = prepare(m, r, group) && run_frames(m, done, total) && fill_rows(m);
    release(m);
    return ok;
}
