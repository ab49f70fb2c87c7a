/* trial.h: how good a denoiser with some values of its settings, and of the constants inside its shaders, is on scenes whose
   frames are kept: several values at once, on all processors. */
#ifndef EXAMPLES_REPORT_TRIAL_H
#define EXAMPLES_REPORT_TRIAL_H

#include "common/metrics.h"
#include "report/constants.h"
#include "report/method.h"
#include "report/tuning.h"

enum { TRIAL_MAX_SHOTS = 8, TRIAL_MAX_KNOBS = 96, TRIAL_MAX_LANES = 12 };

/* A scene whose frames are kept. */
typedef struct shot {
    capture frames[REPORT_MAX_FRAMES];
    metrics_scale scales[SIGNAL_COUNT]; /* of the first reference */
} shot;

typedef struct shots {
    shot list[TRIAL_MAX_SHOTS];
    int count;
} shots;

/* Renders the scenes of a list of names between commas, at the options' first size and paths per pixel. */
bool shots_open(report *r, const char *names, shots *out);
void shots_close(shots *s);

/* Something that can be turned. */
typedef struct knob {
    const char *name, *unit;
    const shader_constant *constant; /* NULL: a setting */
    double first, min, max;          /* first: before the search */
} knob;

/* How good some values are. */
typedef struct verdict {
    double objective;               /* the weighted geometric mean of the terms */
    double terms[TUNING_TERMS];
    double shots[TRIAL_MAX_SHOTS];  /* the objective of each; 0: the denoiser cannot run there */
} verdict;

typedef struct candidate {
    double values[TRIAL_MAX_KNOBS];
    verdict verdict;
} candidate;

/* A place to try candidates in: denoisers stay open from one to the next, and are opened again only where constants change. */
typedef struct lane {
    method methods[TRIAL_MAX_SHOTS];
    float constants[TRIAL_MAX_SHOTS][TRIAL_MAX_KNOBS]; /* that the open one of a shot has */
} lane;

typedef struct trial {
    report *r;
    nrd_denoiser denoiser;
    const setting_value *fixed;     /* settings that no knob turns */
    uint32_t fixed_count;
    const knob *knobs;
    int knob_count;
    lane *lanes;                    /* trial_lanes() zeroed ones for each list of shots, closed by trial_close */
} trial;

/* How many candidates are tried at once on so many shots. */
int trial_lanes(int shot_count);

/* Fills the verdicts of up to trial_lanes() candidates. The same values get the same verdict. */
bool trial_run(const trial *t, shots *s, candidate *candidates, int count);
void trial_close(const trial *t, const shots *s);

#endif
