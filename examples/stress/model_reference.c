/* REFERENCE: the plain mean of all frames, in 32 bits. */
#include "stress/model.h"

#include <math.h>
#include <string.h>

enum { ACCUMULATION, PASSES, LANES = 4 };

static void start(any_model *any, const model_kind *kind, const any_settings *settings, model_passes passes)
{
    (void)kind;
    memset(&any->reference, 0, sizeof any->reference);
    any->reference.max_frames = settings->REFERENCE.max_accumulated_frames;
    any->reference.passes = passes;
}

static void run_frame(any_model *any, double (*in)[MODEL_PIXELS], uint32_t frame_index)
{
    reference_model *m = &any->reference;
    model_rounding r = model_rounding_of(m->passes, ACCUMULATION), stored = { r.stored, false };
    double share = reg(r, 1 / (1 + m->frames));
    (void)frame_index;
    for (int k = 0; k < LANES; k++)
        for (int i = 0; i < MODEL_PIXELS; i++) m->mean[k][i] = reg(stored, reg(r, reg(r, m->mean[k][i] * reg(r, 1 - share)) + reg(r, in[k][i] * share)));
    m->frames = fmin(m->frames + 1, m->max_frames);
}

static double value(const any_model *any, uint32_t lane, uint32_t pixel) { return any->reference.mean[lane][pixel]; }

#define LANE(k, role) { NRD_RESOURCE_IN_SIGNAL, NRD_RESOURCE_OUT_SIGNAL, k, role, 0 }
const model_kind reference_model_kind = { NRD_DENOISER_REFERENCE, 0, PASSES, { "accumulation" }, LANES, { LANE(0, LANE_VALUE), LANE(1, LANE_PART), LANE(2, LANE_PART), LANE(3, LANE_PART) }, start, run_frame, value };
