/* tracer_vulkan.h: the textures that the Vulkan tracer leaves for the denoisers, for programs that denoise on the same
   device without a capture in between. */
#ifndef EXAMPLES_TRACER_TRACER_VULKAN_H
#define EXAMPLES_TRACER_TRACER_VULKAN_H

#include "common/gpu.h"
#include "tracer/tracer.h"

/* Named after the denoisers' inputs, in the order of the shader's bindings. normal_roughness has the encodings
   RGBA16_SNORM and LINEAR; the hit distances are normalised with frame.hit_dist_params. Pixels of the sky hold guides
   only. */
#define TRACER_TEXTURES(X)                              \
    X(mv, VK_FORMAT_R16G16B16A16_SFLOAT)                \
    X(normal_roughness, VK_FORMAT_R16G16B16A16_SFLOAT)  \
    X(viewz, VK_FORMAT_R32_SFLOAT)                      \
    X(diff_radiance_hitdist, VK_FORMAT_R16G16B16A16_SFLOAT) \
    X(spec_radiance_hitdist, VK_FORMAT_R16G16B16A16_SFLOAT)

typedef enum tracer_texture {
#define TRACER_TEXTURE_ENUM(name, format) TRACER_TEXTURE_##name,
    TRACER_TEXTURES(TRACER_TEXTURE_ENUM)
#undef TRACER_TEXTURE_ENUM
    TRACER_TEXTURE_COUNT
} tracer_texture;

/* As tracer_open_vulkan, on a device that is open, beside others. */
bool tracer_open_vulkan_on(tracer *t, gpu *device, char *error, size_t error_size);

/* The device on which a tracer from tracer_open_vulkan works. */
gpu *tracer_vulkan_gpu(tracer *t);

/* Device time of the last render. */
double tracer_vulkan_ms(const tracer *t);

/* Written by every render; valid until the next render of another size, or close. */
const gpu_image *tracer_vulkan_texture(const tracer *t, tracer_texture which);

/* The shader that renders, for programs that keep its results. */
const uint32_t *tracer_vulkan_code(size_t *size_bytes);

#endif
