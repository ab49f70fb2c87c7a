#define NRD_IMPLEMENTATION
#include "nrd.h"

int main()
{
    nrd_denoiser_desc list[1] = {};
    list[0].denoiser = NRD_DENOISER_REFERENCE;
    nrd_desc desc = {};
    desc.width = 64;
    desc.height = 32;
    desc.denoisers = list;
    desc.denoiser_count = 1;
    nrd *instance = nullptr;
    bool created = nrd_create(&desc, &instance) == NRD_RESULT_OK;
    bool ok = created && nrd_get_info(instance) && nrd_set_frame(instance, nullptr) != NRD_RESULT_OK;
    nrd_destroy(instance);
    return ok ? 0 : 1;
}
