/* The other half of an engine in two files: nothing but the implementation. */
#if defined(ENGINE_NVIDIA)
#include "nvidia_names.h"
#endif
#if defined(ENGINE_VOLK)
#include <volk.h>
#endif
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#include "nrd_vk.h"
