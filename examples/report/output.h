/* output.h: the forms of a report. Files appear under their names only when they are complete. */
#ifndef EXAMPLES_REPORT_OUTPUT_H
#define EXAMPLES_REPORT_OUTPUT_H

#include "report/report.h"

#include <stdio.h>

/* All on stdout. */
void print_table(const report *r);

/* FOLDER/report.csv, report.json, report.html. */
bool print_csv(report *r);
bool print_json(report *r);
bool print_page(report *r);

/* A file of the folder, to be written under a temporary name, which goes to `path`; NULL with r->error. */
FILE *output_open(report *r, const char *name, char *path, size_t size);
bool output_close(report *r, FILE *file, const char *path);

/* Device, options, columns and rows as one JSON object. */
void output_json(const report *r, FILE *file);

#endif
