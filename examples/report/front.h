/* front.h: which presets and variants of a denoiser lie on the front of error against time: what presets are chosen by.

   Compared are geometric means over scenes and signals (but `final`, which contains the others) at the number of paths nearest
   to 1 and the first size: of the time, and of the trimmed relMSE in motion. */
#ifndef EXAMPLES_REPORT_FRONT_H
#define EXAMPLES_REPORT_FRONT_H

#include "report/report.h"

enum { FRONT_MAX = NRD_DENOISER_COUNT * (NRD_PRESET_COUNT + REPORT_MAX_VARIANTS) };
#define FRONT_NOISE 0.01 /* share of time or error by which two rows may differ by chance */

typedef struct front_row {
    char denoiser[REPORT_NAME], preset[REPORT_NAME];
    double ms, error;
    int places;    /* scenes x signals */
    int beaten_by; /* index of a row that is better in one and not worse in the other; -1: lies on the front */
} front_row;

/* In order of denoisers, each by rising time. Returns their number. */
int front_find(const report *r, front_row rows[FRONT_MAX]);

void front_print(const report *r);

#endif
