/* tiles.h: time against the share of active tiles: of each denoiser on the synthetic scene of bench.h, of which more and more is sky. */
#ifndef EXAMPLES_REPORT_TILES_H
#define EXAMPLES_REPORT_TILES_H

#include "report/report.h"

#include <stdio.h>

/* Fill r->tiles, at the size at which times are taken. */
bool tiles_load(report *r);    /* from their file; false: not there, or measured with other options */
bool tiles_measure(report *r); /* and writes that file */

/* A line per denoiser: time of a frame without sky, and the others in percent of it. */
void tiles_print(const report *r);

/* FOLDER/tiles.csv; a JSON array. */
bool tiles_csv(report *r);
void tiles_json(const report *r, FILE *file);

#endif
