#include "report/score.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { EDGE_RADIUS = 4 };

/* ---- truth ---- */

static double mean_luminance(const image *m, const unsigned char *mask)
{
    double sum = 0;
    size_t used = 0;
    for (size_t i = 0; i < image_pixels(m); i++) {
        double l = image_luminance(m, i);
        if (!mask[i] || !isfinite(l))
            continue;
        sum += l;
        used++;
    }
    return used ? sum / (double)used : 0;
}

static bool update_masks(truth *t, const capture *now)
{
    size_t count = (size_t)now->width * (size_t)now->height;
    if (!t->mask) {
        t->mask = malloc(count);
        t->edges = malloc(count);
    }
    if (!t->mask || !t->edges)
        return false;
    signal_mask(now, t->signal, t->mask);
    memcpy(t->edges, t->mask, count);
    return metrics_keep_edges(now, EDGE_RADIUS, t->edges);
}

static bool is_light(signal_id signal)
{
    return !signal_is_unit(signal);
}

bool truth_advance(truth *t, const report_options *o, int frame, const capture *then, const capture *now)
{
    sequence_phase phase = sequence_phase_of(o, frame);
    image_destroy(&t->before);
    t->before = t->reference;
    memset(&t->reference, 0, sizeof t->reference);
    if (!update_masks(t, now))
        return false;
    if (!signal_get(now, NULL, t->signal, SOURCE_REFERENCE, &t->reference))
        return !sequence_has_reference(o, frame);
    if (!t->scaled) {
        t->scale = metrics_scale_of(&t->reference, t->mask, !is_light(t->signal));
        t->scaled = true;
    }
    if (phase == PHASE_STEP)
        t->mean_new = mean_luminance(&t->reference, t->mask);
    else
        t->mean_old = mean_luminance(&t->reference, t->mask);
    return phase != PHASE_MOTION || !then || !t->before.channels
        || metrics_add_flicker(then, &t->before, now, &t->reference, t->mask, &t->scale, &t->flicker);
}

void truth_free(truth *t)
{
    free(t->mask);
    free(t->edges);
    image_destroy(&t->reference);
    image_destroy(&t->before);
    memset(t, 0, sizeof *t);
}

/* ---- scores ---- */

void score_start(score *s)
{
    memset(s, 0, sizeof *s);
    s->before_frame = -1;
    for (int i = 0; i < REPORT_MAX_FRAMES; i++)
        s->curve[i] = NAN;
}

void score_free(score *s)
{
    image_destroy(&s->before);
}

static bool add_motion(score *s, const truth *t, const capture *then, const capture *now, const image *m, const metrics *errors)
{
    metrics edge;
    double flip;
    if (!metrics_flip(m, &t->reference, t->mask, &t->scale, &flip) || !metrics_compare(m, &t->reference, t->edges, &t->scale, &edge))
        return false;
    metrics_add(&s->motion, errors);
    metrics_add(&s->edge, &edge);
    s->motion_flip += flip;
    s->motion_flips++;
    s->fireflies += metrics_count_fireflies(m, &t->reference, t->mask, &t->scale);
    for (size_t i = 0; i < image_pixels(m); i++)
        s->firefly_pixels += t->mask[i];
    s->worst_tile = fmax(s->worst_tile, metrics_worst_tile(m, &t->reference, t->mask, &t->scale));
    if (then && t->before.channels)
        metrics_add_ghost(then, &t->before, now, m, &t->reference, t->mask, &s->ghost);
    return true;
}

static bool is_settled(const report_options *o, int frame)
{
    return frame >= o->moving + o->still / 2;
}

static bool add_rest(score *s, const truth *t, const report_options *o, int frame, const image *m, const metrics *errors)
{
    if (!is_settled(o, frame))
        return true;
    metrics_add(&s->rest, errors);
    return frame < o->moving + o->still - 1 || metrics_flip(m, &t->reference, t->mask, &t->scale, &s->rest_flip);
}

/* Flicker is measured where the reference's is known: between frames that both have one. */
static bool add_flicker(score *s, const truth *t, const report_options *o, int frame, const capture *then, const capture *now, const image *m)
{
    sequence_phase phase = sequence_phase_of(o, frame);
    bool wanted = phase == PHASE_MOTION ? t->reference.channels && t->before.channels : phase == PHASE_REST && frame > o->moving + o->still / 2;
    if (!wanted || !then || s->before_frame != frame - 1)
        return true;
    return metrics_add_flicker(then, &s->before, now, m, t->mask, &t->scale, phase == PHASE_MOTION ? &s->motion_flicker : &s->rest_flicker);
}

static bool add_errors(score *s, const truth *t, const report_options *o, int frame, const capture *then, const capture *now, const image *m)
{
    sequence_phase phase = sequence_phase_of(o, frame);
    metrics errors;
    if (!t->reference.channels)
        return true;
    bool only_curve = phase == PHASE_STEP || (phase == PHASE_REST && !is_settled(o, frame));
    if (only_curve ? !metrics_relative(m, &t->reference, t->mask, &errors) : !metrics_compare(m, &t->reference, t->mask, &t->scale, &errors))
        return false;
    s->curve[frame] = errors.rel_mse_trimmed;
    if (phase == PHASE_STEP) {
        s->response[s->responses++] = (mean_luminance(m, t->mask) - t->mean_old) / (t->mean_new - t->mean_old);
        return true;
    }
    return phase == PHASE_MOTION ? add_motion(s, t, then, now, m, &errors) : add_rest(s, t, o, frame, m, &errors);
}

bool score_add(score *s, const truth *t, const report_options *o, int frame, const capture *then, const capture *now, image *picture)
{
    s->curve_count = frame + 1;
    bool ok = add_errors(s, t, o, frame, then, now, picture) && add_flicker(s, t, o, frame, then, now, picture);
    image_destroy(&s->before);
    s->before = *picture;
    s->before_frame = frame;
    memset(picture, 0, sizeof *picture);
    return ok;
}

/* ---- rows ---- */

static double mean_flicker(const metrics_flicker *f)
{
    return f->pixels ? f->sum / (double)f->pixels : NAN;
}

static void fill_motion(const score *s, const truth *t, double *v)
{
    metrics_summary m = metrics_summarise(&s->motion);
    v[REPORT_motion_relmse] = m.rel_mse;
    v[REPORT_motion_trimmed] = m.rel_mse_trimmed;
    v[REPORT_motion_psnr] = m.psnr;
    v[REPORT_motion_ssim] = m.ssim;
    v[REPORT_motion_bias] = m.bias;
    v[REPORT_motion_flip] = s->motion_flip / s->motion_flips;
    v[REPORT_motion_flicker] = mean_flicker(&s->motion_flicker) - mean_flicker(&t->flicker);
    v[REPORT_edge_trimmed] = metrics_summarise(&s->edge).rel_mse_trimmed;
    v[REPORT_worst_tile] = s->worst_tile;
    v[REPORT_fireflies] = s->firefly_pixels ? 1e6 * (double)s->fireflies / (double)s->firefly_pixels : NAN;
    v[REPORT_ghost] = s->ghost.square > 0 ? s->ghost.along / s->ghost.square : NAN;
}

static void fill_rest(const score *s, double *v)
{
    metrics_summary m = metrics_summarise(&s->rest);
    v[REPORT_rest_relmse] = m.rel_mse;
    v[REPORT_rest_trimmed] = m.rel_mse_trimmed;
    v[REPORT_rest_psnr] = m.psnr;
    v[REPORT_rest_ssim] = m.ssim;
    v[REPORT_rest_bias] = m.bias;
    v[REPORT_rest_flip] = s->rest_flip;
    v[REPORT_rest_flicker] = mean_flicker(&s->rest_flicker);
}

void score_fill(const score *s, const truth *t, const report_options *o, report_row *row)
{
    if (s->motion.frames)
        fill_motion(s, t, row->values);
    if (s->rest.frames)
        fill_rest(s, row->values);
    if (s->responses == o->stepped && o->stepped && is_light(t->signal))
        row->values[REPORT_lag] = metrics_lag(s->response, s->responses);
    row->curve_count = s->curve_count;
    memcpy(row->curve, s->curve, sizeof row->curve);
}
