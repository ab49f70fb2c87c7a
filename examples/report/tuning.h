/* tuning.h: what nrd-tune has found for a denoiser, kept in the folder of a report: FOLDER/tuning/DENOISER.txt. */
#ifndef EXAMPLES_REPORT_TUNING_H
#define EXAMPLES_REPORT_TUNING_H

#include "report/report.h"

#include <stdio.h>

/* What is made small, each as a geometric mean over scenes and signals. */
#define TUNING_TERM_LIST(X) X("relMSE in motion") X("at rest") X("after a light step") X("flicker in motion") X("flicker at rest") X("bias")
enum { TUNING_TERMS = 6, TUNING_FLICKER = 3, TUNING_FLICKER_AT_REST = 4, TUNING_MAX_CHANGES = 64, TUNING_MAX_VERDICTS = 4 };

typedef struct tuning_verdict {
    char when[16], scenes[256]; /* before or after; names between commas */
    double objective, terms[TUNING_TERMS];
} tuning_verdict;

typedef struct tuning_change { char name[REPORT_NAME]; double before, after; } tuning_change;

typedef struct tuning_result {
    char denoiser[REPORT_NAME];
    int searched, tried; /* values; evaluations */
    tuning_verdict verdicts[TUNING_MAX_VERDICTS];
    int verdict_count;   /* those of the scenes trained on come first */
    tuning_change changes[TUNING_MAX_CHANGES];
    int change_count;    /* 0: nothing better than the values before was found */
} tuning_result;

/* Replaces what was found earlier. False with r->error. */
bool tuning_save(report *r, const tuning_result *t);

/* False where nothing, or not all of it, has been kept. */
bool tuning_load(const report *r, const char *denoiser, tuning_result *out);

/* Of all denoisers of the report, as a table, and as a JSON list. */
void tuning_print(const report *r);
void tuning_json(const report *r, FILE *file);

#endif
