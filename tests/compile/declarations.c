/* The headers without their implementations, twice, from a second file: as every other file of an application includes them. */
#include "nrd_vk.h"
#include "nrd.h"
#include "nrd_vk.h"

int use_declarations(void);
int use_declarations(void)
{
    nrd_reblur_settings reblur = nrd_reblur_defaults();
    nrd_frame frame = nrd_frame_defaults();
    return reblur.max_accumulated_frames > 0 && !frame.restart && nrd_result_string(NRD_RESULT_OK) ? 0 : 1;
}
