/* crops.h: pictures of one signal: noisy, denoised, reference, and where the error is. */
#ifndef EXAMPLES_REPORT_CROPS_H
#define EXAMPLES_REPORT_CROPS_H

#include "report/report.h"
#include "report/score.h"

#define CROPS_KINDS(X) X(noisy) X(denoised) X(reference) X(error)
enum { CROPS_MAX_WIDTH = 320, CROPS_MAX_HEIGHT = 180 };

/* Pictures are taken of one group for each scene: the first size, and the paths per pixel nearest to 1. */
bool crops_wanted(const report_options *o, const report_group *group);

/* What stands for the denoiser in the names of pictures that all of them share, noisy and reference; else its own name. */
const char *crops_owner(const char *denoiser, const char *kind);

/* FOLDER/crops/SCENE-OWNER-SIGNAL-KIND.png */
void crops_path(const report_options *o, const char *scene, const char *denoiser, const char *signal, const char *kind, char *path, size_t size);

/* Writes the four pictures, of the middle of the frame where it is larger than a crop. */
bool crops_write(report *r, const report_group *group, const char *denoiser, const truth *t, const capture *now, const image *denoised);

#endif
