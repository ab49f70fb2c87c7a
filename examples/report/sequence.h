/* sequence.h: the frames of one group: a scene in motion, then at rest, then with four times the light.

   At rest the scene stands as in the last frame of motion, so both share a reference; with four times the light all
   radiance is that of the tracer times 4, which is exact, because light is linear. */
#ifndef EXAMPLES_REPORT_SEQUENCE_H
#define EXAMPLES_REPORT_SEQUENCE_H

#include "report/report.h"
#include "tracer/tracer.h"

#define SEQUENCE_STEP 4.0f

typedef enum sequence_phase { PHASE_MOTION, PHASE_REST, PHASE_STEP } sequence_phase;

typedef struct sequence {
    report *r;
    report_group group;
    scene scene;
    pt_scene posed;
    tracer tracer;
    float *planes;
    double *sums;
    float *references[REPORT_MAX_FRAMES]; /* 2 x PT_REF_COUNT planes: the mean, and that of half the samples */
    int loaded_pose;                      /* frame whose geometry the tracer holds; -1: none */
} sequence;

/* Renders the references, or reads them from the folder's cache; `with_references`: false when only times matter. */
bool sequence_open(sequence *s, report *r, const report_group *group, bool with_references);
void sequence_close(sequence *s); /* a zeroed one is fine */

int sequence_length(const report_options *o);
sequence_phase sequence_phase_of(const report_options *o, int frame);
bool sequence_has_reference(const report_options *o, int frame);

/* Noisy signals and guides; with a reference where there is one. */
bool sequence_frame(sequence *s, int frame, capture *out);

/* The share of the pixels that are traced, of a checkerboard of its pixels. */
double sequence_share(const report_group *group);

/* One path per pixel and lobe of the same frame with other random numbers. */
bool sequence_extra(sequence *s, int frame, int number, capture *out);

/* The last reference as it would be with half of its samples, and with all of them: the two differ by as much noise as is
   left in the latter. */
bool sequence_noise(sequence *s, capture *half, capture *whole);

/* Median device time of tracing the first frame with 1 to 8 paths per pixel and lobe. */
bool sequence_trace_ms(sequence *s, int paths, double *out);

#endif
