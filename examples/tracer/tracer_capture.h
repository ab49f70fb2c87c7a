/* tracer_capture.h: what a tracer has rendered, as a frame of a capture. */
#ifndef EXAMPLES_TRACER_TRACER_CAPTURE_H
#define EXAMPLES_TRACER_TRACER_CAPTURE_H

#include "common/capture.h"
#include "scenes/scene.h"

/* Adds the attributes of a frame and those of its PT_PLANE_COUNT planes that the scene has: of the sun, of glass. False when memory is short. */
bool tracer_fill_capture(capture *c, const pt_frame *f, float fps, const scene_def *def, const float *planes);

/* Adds the PT_REF_COUNT planes of a reference, means over the samples. */
bool tracer_fill_reference(capture *c, const scene_def *def, const float *planes);

#endif
