#ifdef VULKAN_BEFORE
#include <vulkan/vulkan.h>
#endif
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"
#ifdef VULKAN_AFTER
#include <vulkan/vulkan.h>
#endif

int main(void)
{
    nrd_vk *vk = NULL;
    bool refused = nrd_vk_create(&(nrd_vk_desc){ .instance = NULL }, &vk) != NRD_RESULT_OK && !vk;
    nrd_vk_destroy(vk);
    return refused && nrd_vk_format(NRD_FORMAT_RGBA16_FLOAT) == VK_FORMAT_R16G16B16A16_SFLOAT ? 0 : 1;
}
