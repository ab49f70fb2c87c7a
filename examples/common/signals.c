#include "common/signals.h"

#include "common/half.h"
#include "common/pack.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Length at which an ambient-occlusion ray counts as unoccluded (ref.diffuse.ao of the capture format). */
#define AO_METRES 3.0f
/* Below this no light of the signal arrives in the picture. */
#define FACTOR_MIN 1e-4f

static const struct {
    const char *name;
    int channels;
    const char *prefix[SOURCE_COUNT];
} table[SIGNAL_COUNT] = {
#define SIGNAL_ROW(id, name, channels, noisy, denoised, reference) { name, channels, { denoised, noisy, reference } },
    SIGNAL_LIST(SIGNAL_ROW)
#undef SIGNAL_ROW
};

const char *signal_name(signal_id signal)
{
    return table[signal].name;
}

const char *signal_source_name(signal_source source)
{
    static const char *const names[SOURCE_COUNT] = { "denoised", "noisy", "ref" };
    return names[source];
}

const char *signal_prefix(signal_id signal, signal_source source)
{
    return table[signal].prefix[source];
}

bool signal_find(const char *name, signal_id *out)
{
    for (int s = 0; s < SIGNAL_COUNT; s++)
        if (!strcmp(table[s].name, name)) {
            *out = (signal_id)s;
            return true;
        }
    return false;
}

static bool copy_planes(const capture *frame, const char *prefix, int channels, image *out)
{
    float *planes[3];
    if (channels == 1)
        planes[0] = capture_find_plane(frame, prefix);
    else if (!capture_find_planes(frame, prefix, "RGB", planes))
        planes[0] = NULL;
    if (!planes[0] || !image_create(out, frame->width, frame->height, channels))
        return false;
    for (int k = 0; k < channels; k++)
        memcpy(out->planes[k], planes[k], image_pixels(out) * sizeof(float));
    return true;
}

void signal_occlusion(const capture *frame, float out[4])
{
    const float format[4] = { AO_METRES / frame->metres_per_unit, 0, 1, 0 };
    memcpy(out, frame->occlusion[0] > 0 ? frame->occlusion : format, sizeof format);
}

static void visibility_from_distance(image *m)
{
    for (size_t i = 0; i < image_pixels(m); i++)
        m->planes[0][i] = m->planes[0][i] >= HALF_MAX ? 1.0f : 0.0f;
}

static void occlusion_from_distance(image *m, const capture *frame, signal_id signal)
{
    const float *z = capture_find_plane(frame, "viewZ"), *roughness = signal == SIGNAL_SPECULAR_AO ? capture_find_plane(frame, "roughness") : NULL;
    float *v = m->planes[0], parameters[4];
    signal_occlusion(frame, parameters);
    for (size_t i = 0; i < image_pixels(m); i++)
        v[i] = pack_normalize_hit_dist(v[i], z ? z[i] : 0.0f, roughness ? roughness[i] : 1.0f, parameters);
}

static void compose_channel(const capture *frame, int k, const image *diffuse, const image *specular, const image *shadow,
                            float *out)
{
    static const char *const suffixes[] = { "R", "G", "B" };
    float *diffuse_factor, *specular_factor, *emission = NULL, *sun = NULL;
    capture_find_planes(frame, "diffuseFactor", suffixes[k], &diffuse_factor);
    capture_find_planes(frame, "specularFactor", suffixes[k], &specular_factor);
    capture_find_planes(frame, "emission", suffixes[k], &emission);
    if (shadow)
        capture_find_planes(frame, "sun", suffixes[k], &sun);
    for (size_t i = 0; i < image_pixels(diffuse); i++) {
        float sunlight = sun ? sun[i] * shadow->planes[shadow->channels == 3 ? k : 0][i] : 0.0f, emitted = emission ? emission[i] : 0.0f;
        out[i] = diffuse->planes[k][i] * diffuse_factor[i] + specular->planes[k][i] * specular_factor[i] + sunlight + emitted;
    }
}

bool signal_compose(const capture *frame, const image *diffuse, const image *specular, const image *shadow, image *out)
{
    float *planes[3];
    memset(out, 0, sizeof *out);
    if (!capture_find_planes(frame, "diffuseFactor", "RGB", planes) || !capture_find_planes(frame, "specularFactor", "RGB", planes))
        return false;
    if (!image_create(out, frame->width, frame->height, 3))
        return false;
    for (int k = 0; k < 3; k++)
        compose_channel(frame, k, diffuse, specular, shadow, out->planes[k]);
    return true;
}

bool signal_is_colored(const capture *frame)
{
    float *color[3];
    return capture_find_planes(frame, "shadow.translucency", "RGB", color);
}

bool signal_is_unit(signal_id signal)
{
    return signal != SIGNAL_DIFFUSE && signal != SIGNAL_SPECULAR && signal != SIGNAL_FINAL;
}

static bool compose_from(const capture *frame, const capture *denoised, signal_source source, image *out)
{
    image diffuse = { 0 }, specular = { 0 }, shadow = { 0 };
    float *sun[3];
    bool has_sun = capture_find_planes(frame, "sun", "RGB", sun);
    bool ok = signal_get(frame, denoised, SIGNAL_DIFFUSE, source, &diffuse)
        && signal_get(frame, denoised, SIGNAL_SPECULAR, source, &specular)
        && (!has_sun || (signal_is_colored(frame) && signal_get(frame, denoised, SIGNAL_TRANSLUCENCY, source, &shadow))
            || signal_get(frame, denoised, SIGNAL_SHADOW, source, &shadow))
        && signal_compose(frame, &diffuse, &specular, has_sun ? &shadow : NULL, out);
    image_destroy(&diffuse);
    image_destroy(&specular);
    image_destroy(&shadow);
    return ok;
}

bool signal_get(const capture *frame, const capture *denoised, signal_id signal, signal_source source, image *out)
{
    const capture *from = source == SOURCE_DENOISED ? denoised : frame;
    const char *prefix = table[signal].prefix[source];
    memset(out, 0, sizeof *out);
    if (!from)
        return false;
    if (prefix && copy_planes(from, prefix, table[signal].channels, out)) {
        if (source == SOURCE_NOISY && table[signal].channels == 1)
            signal == SIGNAL_SHADOW ? visibility_from_distance(out) : occlusion_from_distance(out, frame, signal);
        return true;
    }
    return signal == SIGNAL_FINAL && compose_from(frame, denoised, source, out);
}

void signal_mask(const capture *frame, signal_id signal, unsigned char *mask)
{
    const float *z = capture_find_plane(frame, "viewZ");
    const char *lit_by = signal == SIGNAL_DIFFUSE ? "diffuseFactor" : signal == SIGNAL_SHADOW || signal == SIGNAL_TRANSLUCENCY ? "sun" : "";
    float *lit[3];
    bool needs_light = capture_find_planes(frame, lit_by, "RGB", lit);
    for (size_t i = 0; i < (size_t)frame->width * (size_t)frame->height; i++) {
        bool lit_here = !needs_light || fmaxf(lit[0][i], fmaxf(lit[1][i], lit[2][i])) > FACTOR_MIN;
        mask[i] = lit_here && (!z || fabsf(z[i]) < frame->denoising_range);
    }
}

static bool require_planes(const capture *frame, const char *path, const char *prefix, int channels, char *error, size_t error_size)
{
    char names[3][CAPTURE_NAME_SIZE];
    const char *list[3];
    for (int k = 0; k < channels; k++) {
        snprintf(names[k], CAPTURE_NAME_SIZE, channels == 1 ? "%s" : "%s.%c", prefix, "RGB"[k]);
        list[k] = names[k];
    }
    return capture_require(frame, path, 0, list, (size_t)channels, error, error_size);
}

bool signal_require(const capture *frame, const char *path, signal_id signal, char *error, size_t error_size)
{
    float *sun[3];
    if (signal != SIGNAL_FINAL)
        return require_planes(frame, path, table[signal].prefix[SOURCE_NOISY], table[signal].channels, error, error_size);
    return require_planes(frame, path, "diffuse", 3, error, error_size)
        && require_planes(frame, path, "specular", 3, error, error_size)
        && require_planes(frame, path, "diffuseFactor", 3, error, error_size)
        && require_planes(frame, path, "specularFactor", 3, error, error_size)
        && (!capture_find_planes(frame, "sun", "RGB", sun) || require_planes(frame, path, "shadow.hitT", 1, error, error_size));
}

bool signal_has_reference(const capture *frame)
{
    float *planes[3];
    for (int s = 0; s < SIGNAL_COUNT; s++) {
        const char *prefix = table[s].prefix[SOURCE_REFERENCE];
        if (!prefix)
            continue;
        if (table[s].channels == 1 ? capture_find_plane(frame, prefix) != NULL : capture_find_planes(frame, prefix, "RGB", planes))
            return true;
    }
    return false;
}
