#define NRD_IMPLEMENTATION
#include "nrd.h"

#ifdef NRD_VK_H
#error "nrd.h must not need nrd_vk.h"
#endif

int main(void)
{
    nrd_denoiser_desc list[] = { { .identifier = 7, .denoiser = NRD_DENOISER_REFERENCE } };
    nrd *instance = NULL;
    bool created = nrd_create(&(nrd_desc){ .width = 64, .height = 32, .denoisers = list, .denoiser_count = 1 }, &instance) == NRD_RESULT_OK;
    bool ok = created && nrd_get_info(instance) && nrd_set_frame(instance, NULL) != NRD_RESULT_OK;
    nrd_destroy(instance);
    return ok ? 0 : 1;
}
