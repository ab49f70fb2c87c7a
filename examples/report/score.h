/* score.h: compares the pictures of one signal with the references, frame after frame. */
#ifndef EXAMPLES_REPORT_SCORE_H
#define EXAMPLES_REPORT_SCORE_H

#include "common/metrics_faults.h"
#include "common/metrics_flip.h"
#include "report/report.h"
#include "report/sequence.h"

/* What is known of a signal in a frame, whoever denoises it. */
typedef struct truth {
    signal_id signal;
    bool scaled;
    metrics_scale scale;              /* of the first reference */
    unsigned char *mask, *edges;      /* which pixels count; which of them lie near edges */
    image reference, before;          /* of this frame and of the one before; without channels where there is none */
    metrics_flicker flicker;          /* of the references in motion */
    double mean_old, mean_new;        /* luminance before and after the light step */
} truth;

typedef struct score {
    metrics motion, rest, edge;       /* sums */
    double motion_flip, rest_flip;
    int motion_flips;
    metrics_flicker motion_flicker, rest_flicker;
    metrics_ghost ghost;
    long fireflies, firefly_pixels;
    double worst_tile;
    double response[REPORT_MAX_FRAMES], curve[REPORT_MAX_FRAMES];
    int responses, curve_count;
    image before;
    int before_frame;                 /* -1: none */
} score;

/* Moves on to a frame; `then` is the frame before (NULL: none). False when memory is short. */
bool truth_advance(truth *t, const report_options *o, int frame, const capture *then, const capture *now);
void truth_free(truth *t);

void score_start(score *s);
void score_free(score *s);

/* Takes the picture over. False when memory is short. */
bool score_add(score *s, const truth *t, const report_options *o, int frame, const capture *then, const capture *now, image *picture);

/* Fills the columns of errors. */
void score_fill(const score *s, const truth *t, const report_options *o, report_row *row);

#endif
