/* signals.h: the signals of a capture (noisy input, denoised, converged reference) as images, and their composition.

   final = diffuse * diffuseFactor + specular * specularFactor + sun * shadow + emission
   A noisy shadow is 1 where the ray reached the light (hitT >= 65504), else 0. Noisy ambient occlusion is
   saturate(hitT / 3 m) of the diffuse ray, specular occlusion that of the specular ray; or nrd_normalize_hit_dist() with other
   parameters where capture.occlusion holds such. Translucency is the shadow through
   coloured glass; where it is stored, it takes the place of shadow in final. */
#ifndef EXAMPLES_SIGNALS_H
#define EXAMPLES_SIGNALS_H

#include "common/capture.h"
#include "common/image.h"

/* Enumerator, name, channels, prefix of the planes: noisy, denoised, reference. NULL: not stored as it is. */
#define SIGNAL_LIST(X)                                                                       \
    X(DIFFUSE, "diffuse", 3, "diffuse", "denoised.diffuse", "ref.diffuse")                   \
    X(SPECULAR, "specular", 3, "specular", "denoised.specular", "ref.specular")              \
    X(SHADOW, "shadow", 1, "shadow.hitT", "denoised.shadow", "ref.shadow")                   \
    X(AO, "ao", 1, "diffuse.hitT", "denoised.diffuse.ao", "ref.diffuse.ao")                  \
    X(SPECULAR_AO, "specular_ao", 1, "specular.hitT", "denoised.specular.ao", "ref.specular.ao") \
    X(FINAL, "final", 3, NULL, "denoised.final", NULL)                                       \
    X(TRANSLUCENCY, "translucency", 3, "shadow.translucency", "denoised.shadow.translucency", "ref.shadow.translucency")

typedef enum signal_id {
#define SIGNAL_ENUMERATOR(id, name, channels, noisy, denoised, reference) SIGNAL_##id,
    SIGNAL_LIST(SIGNAL_ENUMERATOR)
#undef SIGNAL_ENUMERATOR
    SIGNAL_COUNT
} signal_id;

typedef enum signal_source { SOURCE_DENOISED, SOURCE_NOISY, SOURCE_REFERENCE, SOURCE_COUNT } signal_source;

const char *signal_name(signal_id signal);
const char *signal_source_name(signal_source source);

/* Prefix of the planes that store a signal, or NULL. */
const char *signal_prefix(signal_id signal, signal_source source);

/* Finds a signal by name. */
bool signal_find(const char *name, signal_id *out);

/* Copies a signal out of a frame (and of the denoised frame of the same size, NULL if none). `final` is composed, except
   that denoised.final is preferred where it is stored. False, and a zeroed image, when channels are absent or memory
   is short. */
bool signal_get(const capture *frame, const capture *denoised, signal_id signal, signal_source source, image *out);

/* Composes `final` with the factors of a frame; `shadow` may be NULL when the frame has no sun. False, and a zeroed
   image, when the factors are absent or memory is short. */
bool signal_compose(const capture *frame, const image *diffuse, const image *specular, const image *shadow, image *out);

/* Which pixels count, one byte each: those that are not sky; for diffuse those whose diffuse factor is above 1e-4 in
   some channel, for shadow those whose unshadowed sunlight is. */
void signal_mask(const capture *frame, signal_id signal, unsigned char *mask);

/* True when the frame has every channel that the noisy signal is made of; else one line in `error` names the first that is
   missing. `path` only serves the message. */
bool signal_require(const capture *frame, const char *path, signal_id signal, char *error, size_t error_size);

/* True when the frame stores what coloured glass lets through of the sun: its final picture is made of that, not of the plain shadow. */
bool signal_is_colored(const capture *frame);

/* True for signals within [0,1], which are scored as they are. */
bool signal_is_unit(signal_id signal);

/* The parameters with which hit distances of the frame become occlusion: A, B, C, D of nrd_normalize_hit_dist(), world units. */
void signal_occlusion(const capture *frame, float out[4]);

/* True when the frame stores a reference of any signal. */
bool signal_has_reference(const capture *frame);

#endif
