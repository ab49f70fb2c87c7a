#include "common/denoise.h"

#include "common/gpu.h"
#include "common/half.h"
#include "common/image.h"
#include "common/pack.h"
#include "common/traffic.h"
#include "nrd_vk.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TEXEL_BYTES_MAX 16

/* What the packing and unpacking functions see of a frame. */
typedef struct frame_view {
    const capture *frame;
    signal_id reference_signal;
    float hit_distance[4];    /* A, B, C, D of the denoiser that reads hit distances */
} frame_view;

/* ---- inputs ---- */

static size_t pixels_of(const capture *frame)
{
    return (size_t)frame->width * (size_t)frame->height;
}

static bool pack_motion(const frame_view *view, void *texels)
{
    float *motion[3];
    uint16_t *out = texels;
    capture_find_planes(view->frame, "motion", "XYZ", motion);
    for (size_t i = 0; i < pixels_of(view->frame); i++, out += 4) {
        for (int k = 0; k < 3; k++)
            out[k] = half_from_float(motion[k][i]);
        out[3] = 0;
    }
    return true;
}

static bool pack_guide(const frame_view *view, void *texels)
{
    float *normal[3];
    uint32_t *out = texels;
    const float *roughness = capture_find_plane(view->frame, "roughness"), *material = capture_find_plane(view->frame, "materialID");
    capture_find_planes(view->frame, "normal", "XYZ", normal);
    for (size_t i = 0; i < pixels_of(view->frame); i++) {
        const float n[3] = { normal[0][i], normal[1][i], normal[2][i] };
        float id = material && material[i] > 0 ? fminf(material[i], 3.0f) : 0.0f;
        out[i] = pack_normal_roughness(n, roughness[i], (uint32_t)(id + 0.5f));
    }
    return true;
}

static bool pack_plane(const capture *frame, const char *name, void *texels)
{
    memcpy(texels, capture_find_plane(frame, name), pixels_of(frame) * sizeof(float));
    return true;
}

static bool pack_view_z(const frame_view *view, void *texels)
{
    return pack_plane(view->frame, "viewZ", texels);
}

/* A capture may have the confidence of one signal alone: the other is trusted. */
static bool pack_confidence(const frame_view *view, const char *name, float *texels)
{
    const float *confidence = capture_find_plane(view->frame, name);
    for (size_t i = 0; i < pixels_of(view->frame); i++)
        texels[i] = confidence ? confidence[i] : 1.0f;
    return true;
}

static bool pack_diffuse_confidence(const frame_view *view, void *texels)
{
    return pack_confidence(view, "diffuse.confidence", texels);
}

static bool pack_specular_confidence(const frame_view *view, void *texels)
{
    return pack_confidence(view, "specular.confidence", texels);
}

/* roughness: NULL for the diffuse lobe, whose hit distances are normalised as at roughness 1. */
static bool pack_radiance(const frame_view *view, const char *signal, const float *roughness, void *texels)
{
    float *colour[3];
    uint16_t *out = texels;
    char name[CAPTURE_NAME_SIZE];
    snprintf(name, sizeof name, "%s.hitT", signal);
    const float *hit = capture_find_plane(view->frame, name), *z = capture_find_plane(view->frame, "viewZ");
    capture_find_planes(view->frame, signal, "RGB", colour);
    for (size_t i = 0; i < pixels_of(view->frame); i++, out += 4) {
        const float rgb[3] = { colour[0][i], colour[1][i], colour[2][i] };
        pack_radiance_hit_dist(rgb, pack_normalize_hit_dist(hit[i], z[i], roughness ? roughness[i] : 1.0f, view->hit_distance), out);
    }
    return true;
}

static bool pack_diffuse(const frame_view *view, void *texels)
{
    return pack_radiance(view, "diffuse", NULL, texels);
}

static bool pack_specular(const frame_view *view, void *texels)
{
    return pack_radiance(view, "specular", capture_find_plane(view->frame, "roughness"), texels);
}

/* The second texel of a pair; the first is as in pack_radiance. */
static bool pack_direction(const frame_view *view, const char *signal, void *texels)
{
    float *colour[3], *direction[3];
    uint16_t *out = texels, first[4];
    char name[CAPTURE_NAME_SIZE];
    snprintf(name, sizeof name, "%s.dir", signal);
    capture_find_planes(view->frame, signal, "RGB", colour);
    capture_find_planes(view->frame, name, "XYZ", direction);
    for (size_t i = 0; i < pixels_of(view->frame); i++, out += 4) {
        const float rgb[3] = { colour[0][i], colour[1][i], colour[2][i] };
        const float towards[3] = { direction[0][i], direction[1][i], direction[2][i] };
        pack_sh(rgb, 0, towards, first, out);
    }
    return true;
}

static bool pack_diffuse_direction(const frame_view *view, void *texels)
{
    return pack_direction(view, "diffuse", texels);
}

static bool pack_specular_direction(const frame_view *view, void *texels)
{
    return pack_direction(view, "specular", texels);
}

/* From what pixel i sees at depth z, in world units. */
static float distance_to_lamp(const capture *frame, size_t i, float z)
{
    const float *clip = frame->camera_to_clip, *view = frame->world_to_camera;
    float x = 2 * ((float)(i % (size_t)frame->width) + 0.5f) / (float)frame->width - 1, y = 1 - 2 * ((float)(i / (size_t)frame->width) + 0.5f) / (float)frame->height;
    float w = z * clip[11] + clip[15], squared = 0;
    const float position[3] = { (x * w - z * clip[8] - clip[12]) / clip[0], (y * w - z * clip[9] - clip[13]) / clip[5], z };
    for (int k = 0; k < 3; k++) {
        float lamp = view[12 + k];
        for (int j = 0; j < 3; j++)
            lamp += frame->lamp_position[j] * view[4 * j + k];
        squared += (position[k] - lamp) * (position[k] - lamp);
    }
    return sqrtf(squared);
}

static bool has_lamp(const capture *frame)
{
    return (frame->present & CAPTURE_HAS_LAMP_POSITION) != 0;
}

static bool pack_shadow(const frame_view *view, void *texels)
{
    uint16_t *out = texels;
    const capture *frame = view->frame;
    const float *hit = capture_find_plane(frame, "shadow.hitT"), *z = capture_find_plane(frame, "viewZ");
    for (size_t i = 0; i < pixels_of(frame); i++)
        out[i] = has_lamp(frame) ? pack_local_penumbra(hit[i], distance_to_lamp(frame, i, z[i]), frame->lamp_radius)
                                 : pack_penumbra(hit[i], frame->sun_tan_angular_radius);
    return true;
}

static bool pack_shadow_color(const frame_view *view, void *texels)
{
    float *color[3];
    uint8_t *out = texels;
    const float *hit = capture_find_plane(view->frame, "shadow.hitT");
    capture_find_planes(view->frame, "shadow.translucency", "RGB", color);
    for (size_t i = 0; i < pixels_of(view->frame); i++, out += 4) {
        const float transmission[3] = { color[0][i], color[1][i], color[2][i] };
        pack_translucency(hit[i], transmission, out);
    }
    return true;
}

static bool pack_diffuse_hit_dist(const frame_view *view, void *texels)
{
    uint16_t *out = texels;
    const float *hit = capture_find_plane(view->frame, "diffuse.hitT"), *z = capture_find_plane(view->frame, "viewZ");
    for (size_t i = 0; i < pixels_of(view->frame); i++)
        out[i] = half_from_float(pack_normalize_hit_dist(hit[i], z[i], 1.0f, view->hit_distance));
    return true;
}

static bool pack_direction_hit_dist(const frame_view *view, void *texels)
{
    uint16_t *out = texels;
    float *direction[3];
    const float *hit = capture_find_plane(view->frame, "diffuse.hitT"), *z = capture_find_plane(view->frame, "viewZ");
    capture_find_planes(view->frame, "diffuse.dir", "XYZ", direction);
    for (size_t i = 0; i < pixels_of(view->frame); i++, out += 4) {
        float w = pack_normalize_hit_dist(hit[i], z[i], 1.0f, view->hit_distance);
        const float texel[4] = { direction[0][i] * w, direction[1][i] * w, direction[2][i] * w, w };
        half_from_floats(out, texel, 4);
    }
    return true;
}

static bool pack_specular_hit_dist(const frame_view *view, void *texels)
{
    uint16_t *out = texels;
    const float *hit = capture_find_plane(view->frame, "specular.hitT"), *z = capture_find_plane(view->frame, "viewZ");
    const float *roughness = capture_find_plane(view->frame, "roughness");
    for (size_t i = 0; i < pixels_of(view->frame); i++)
        out[i] = half_from_float(pack_normalize_hit_dist(hit[i], z[i], roughness[i], view->hit_distance));
    return true;
}

static bool pack_signal(const frame_view *view, void *texels)
{
    image m;
    float *out = texels;
    if (!signal_get(view->frame, NULL, view->reference_signal, SOURCE_NOISY, &m))
        return false;
    for (size_t i = 0; i < image_pixels(&m); i++, out += 4) {
        for (int k = 0; k < 3; k++)
            out[k] = m.planes[m.channels == 1 ? 0 : k][i];
        out[3] = 1;
    }
    image_destroy(&m);
    return true;
}

typedef struct input_row {
    nrd_resource resource;
    VkFormat format;
    bool (*pack)(const frame_view *view, void *texels); /* false: out of memory */
    const char *planes[5]; /* what it is packed from */
} input_row;

static const input_row inputs[] = {
    { NRD_RESOURCE_IN_MV, VK_FORMAT_R16G16B16A16_SFLOAT, pack_motion, { "motion.X", "motion.Y", "motion.Z" } },
    { NRD_RESOURCE_IN_NORMAL_ROUGHNESS, VK_FORMAT_A2B10G10R10_UNORM_PACK32, pack_guide,
      { "normal.X", "normal.Y", "normal.Z", "roughness" } },
    { NRD_RESOURCE_IN_VIEWZ, VK_FORMAT_R32_SFLOAT, pack_view_z, { "viewZ" } },
    { NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, VK_FORMAT_R16G16B16A16_SFLOAT, pack_diffuse,
      { "diffuse.R", "diffuse.G", "diffuse.B", "diffuse.hitT", "viewZ" } },
    { NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, VK_FORMAT_R16G16B16A16_SFLOAT, pack_specular,
      { "specular.R", "specular.G", "specular.B", "specular.hitT", "viewZ" } },
    { NRD_RESOURCE_IN_DIFF_SH0, VK_FORMAT_R16G16B16A16_SFLOAT, pack_diffuse, { "diffuse.R", "diffuse.G", "diffuse.B", "diffuse.hitT", "viewZ" } },
    { NRD_RESOURCE_IN_DIFF_SH1, VK_FORMAT_R16G16B16A16_SFLOAT, pack_diffuse_direction, { "diffuse.dir.X", "diffuse.dir.Y", "diffuse.dir.Z" } },
    { NRD_RESOURCE_IN_SPEC_SH0, VK_FORMAT_R16G16B16A16_SFLOAT, pack_specular,
      { "specular.R", "specular.G", "specular.B", "specular.hitT", "viewZ" } },
    { NRD_RESOURCE_IN_SPEC_SH1, VK_FORMAT_R16G16B16A16_SFLOAT, pack_specular_direction, { "specular.dir.X", "specular.dir.Y", "specular.dir.Z" } },
    { NRD_RESOURCE_IN_DIFF_HITDIST, VK_FORMAT_R16_SFLOAT, pack_diffuse_hit_dist, { "diffuse.hitT", "viewZ" } },
    { NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, VK_FORMAT_R16G16B16A16_SFLOAT, pack_direction_hit_dist,
      { "diffuse.dir.X", "diffuse.dir.Y", "diffuse.dir.Z", "diffuse.hitT", "viewZ" } },
    { NRD_RESOURCE_IN_SPEC_HITDIST, VK_FORMAT_R16_SFLOAT, pack_specular_hit_dist, { "specular.hitT", "roughness", "viewZ" } },
    { NRD_RESOURCE_IN_DIFF_CONFIDENCE, VK_FORMAT_R32_SFLOAT, pack_diffuse_confidence, { NULL } },
    { NRD_RESOURCE_IN_SPEC_CONFIDENCE, VK_FORMAT_R32_SFLOAT, pack_specular_confidence, { NULL } },
    { NRD_RESOURCE_IN_PENUMBRA, VK_FORMAT_R16_SFLOAT, pack_shadow, { "shadow.hitT" } },
    { NRD_RESOURCE_IN_TRANSLUCENCY, VK_FORMAT_R8G8B8A8_UNORM, pack_shadow_color,
      { "shadow.translucency.R", "shadow.translucency.G", "shadow.translucency.B", "shadow.hitT" } },
    { NRD_RESOURCE_IN_SIGNAL, VK_FORMAT_R32G32B32A32_SFLOAT, pack_signal, { NULL } },
};

/* ---- outputs ---- */

static void unpack_radiance(const void *texels, size_t i, float rgbw[4])
{
    pack_unpack_radiance_hit_dist((const uint16_t *)texels + 4 * i, rgbw);
}

/* The pair of a pixel lies together: see interleave_pair. */
static void unpack_sh(const void *texels, size_t i, float rgbw[4])
{
    pack_unpack_sh((const uint16_t *)texels + 8 * i, (const uint16_t *)texels + 8 * i + 4, rgbw);
}

static void unpack_shadow(const void *texels, size_t i, float rgbw[4])
{
    rgbw[0] = pack_unpack_shadow(((const uint8_t *)texels)[i]);
}

static void unpack_shadow_color(const void *texels, size_t i, float rgbw[4])
{
    for (int k = 0; k < 3; k++)
        rgbw[k] = pack_unpack_shadow(((const uint8_t *)texels)[4 * i + (size_t)k]);
}

static void unpack_hit_dist(const void *texels, size_t i, float rgbw[4])
{
    rgbw[0] = half_to_float(((const uint16_t *)texels)[i]);
}

static void unpack_direction_hit_dist(const void *texels, size_t i, float rgbw[4])
{
    rgbw[0] = half_to_float(((const uint16_t *)texels)[4 * i + 3]);
}

static void unpack_signal(const void *texels, size_t i, float rgbw[4])
{
    memcpy(rgbw, (const float *)texels + 4 * i, 4 * sizeof *rgbw);
}

typedef struct output_row {
    nrd_resource resource;   /* of a pair the first; the second has the next number */
    signal_id signal;        /* SIGNAL_COUNT: the reference's */
    signal_id occlusion;     /* what w is, SIGNAL_COUNT: nothing of the capture format */
    bool keeps_sky;          /* pixels of the sky are not written */
    const char *other;       /* plane for hit distances that are not normalised as the capture format's occlusion; NULL: not such an output */
    void (*unpack)(const void *texels, size_t pixel, float rgbw[4]);
} output_row;

static const output_row outputs[] = {
    { NRD_RESOURCE_OUT_DIFF_RADIANCE_HITDIST, SIGNAL_DIFFUSE, SIGNAL_AO, true, NULL, unpack_radiance },
    { NRD_RESOURCE_OUT_SPEC_RADIANCE_HITDIST, SIGNAL_SPECULAR, SIGNAL_COUNT, true, NULL, unpack_radiance },
    { NRD_RESOURCE_OUT_DIFF_SH0, SIGNAL_DIFFUSE, SIGNAL_AO, true, NULL, unpack_sh },
    { NRD_RESOURCE_OUT_SPEC_SH0, SIGNAL_SPECULAR, SIGNAL_COUNT, true, NULL, unpack_sh },
    { NRD_RESOURCE_OUT_DIFF_HITDIST, SIGNAL_AO, SIGNAL_COUNT, true, "denoised.diffuse.hitDist", unpack_hit_dist },
    { NRD_RESOURCE_OUT_DIFF_DIRECTION_HITDIST, SIGNAL_AO, SIGNAL_COUNT, true, "denoised.diffuse.hitDist", unpack_direction_hit_dist },
    { NRD_RESOURCE_OUT_SPEC_HITDIST, SIGNAL_SPECULAR_AO, SIGNAL_COUNT, true, "denoised.specular.hitDist", unpack_hit_dist },
    { NRD_RESOURCE_OUT_SHADOW, SIGNAL_SHADOW, SIGNAL_COUNT, true, NULL, unpack_shadow },
    { NRD_RESOURCE_OUT_SHADOW_TRANSLUCENCY, SIGNAL_TRANSLUCENCY, SIGNAL_COUNT, true, NULL, unpack_shadow_color },
    { NRD_RESOURCE_OUT_SIGNAL, SIGNAL_COUNT, SIGNAL_COUNT, false, NULL, unpack_signal },
};

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* ---- instances ---- */

struct denoise {
    denoise_desc desc;
    gpu g;
    nrd *instance;
    nrd_vk *vk;
    bool first;
    gpu_image images[NRD_RESOURCE_COUNT]; /* those in use have a view */
    nrd_vk_timing *raw_timings;
    denoise_timing *timings;
    uint32_t timing_count;
    void *texels;
    int width, height;
    denoise_sink sink;
};

static void keep_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    denoise_sink *sink = user;
    (void)result;
    if (severity == NRD_SEVERITY_ERROR && sink->text && sink->size)
        snprintf(sink->text, sink->size, "%s", text);
}

static bool say(char *error, size_t error_size, const char *text)
{
    if (error && error_size)
        snprintf(error, error_size, "%s", text);
    return false;
}

/* Keeps a message that nrd.h has given; otherwise says what the result means. */
static bool check(nrd_result result, const denoise_sink *sink)
{
    if (result == NRD_RESULT_OK)
        return true;
    return sink->text && sink->size && sink->text[0] ? false : say(sink->text, sink->size, nrd_result_string(result));
}

/* Defaults, the frame's sun or lamp, and what is given by hand. */
static void resolve_settings(const denoise_desc *desc, nrd_denoiser owner, const capture *frame, any_settings *out)
{
    const float *at = has_lamp(frame) ? frame->lamp_position : frame->sun_direction;
    const setting_value light[5] = { { "light_x", false, owner, at[0] }, { "light_y", false, owner, at[1] }, { "light_z", false, owner, at[2] },
                                     { "light_is_local", false, owner, has_lamp(frame) },
                                     { "light_radius", false, owner, has_lamp(frame) ? frame->lamp_radius : frame->sun_tan_angular_radius } };
    const setting_value wide[2] = { { "hit_distance_a", false, owner, 1000.0 }, { "hit_distance_b", false, owner, 0.0 } };
    nrd_settings_defaults(owner, out);
    settings_apply(light, COUNT(light), owner, 1.0, out);
    if (desc->check)
        settings_apply(wide, COUNT(wide), owner, 1.0, out); /* metres: the checker is to see distances, not that they are long */
    settings_apply(desc->settings, desc->setting_count, owner, frame->metres_per_unit, out);
}

static bool has_confidence(const capture *frame)
{
    return capture_find_plane(frame, "diffuse.confidence") != NULL || capture_find_plane(frame, "specular.confidence") != NULL;
}

/* Only what is asked for: what is not declared costs nothing. */
static uint32_t features_for(const denoise_desc *desc, const capture *frame)
{
    static const struct { const char *name; uint32_t feature; } by_setting[] = {
        { "split_screen", NRD_FEATURE_SPLIT_SCREEN },
        { "validation", NRD_FEATURE_VALIDATION },
        { "diffuse_prepass_blur_radius", NRD_FEATURE_PREPASS },
        { "specular_prepass_blur_radius", NRD_FEATURE_PREPASS },
        { "hit_distance_reconstruction", NRD_FEATURE_HIT_DISTANCE_RECONSTRUCTION },
        { "diffuse_checkerboard", NRD_FEATURE_CHECKERBOARD },
        { "specular_checkerboard", NRD_FEATURE_CHECKERBOARD },
        { "specular_roughness_limit", NRD_FEATURE_ROUGHNESS_LIMIT },
    };
    uint32_t features = (has_confidence(frame) ? NRD_FEATURE_HISTORY_CONFIDENCE : 0) | (desc->check ? NRD_FEATURE_CHECK : 0)
                      | (desc->overlay ? NRD_FEATURE_VALIDATION : 0);
    for (uint32_t i = 0; i < desc->setting_count; i++)
        for (size_t k = 0; k < COUNT(by_setting); k++)
            if (!strcmp(desc->settings[i].name, by_setting[k].name) && desc->settings[i].value > 0)
                features |= by_setting[k].feature;
    return features;
}

nrd *denoise_make_instance(const denoise_desc *desc, const capture *frame, denoise_sink *sink)
{
    nrd_denoiser_desc denoisers[DENOISE_MAX_DENOISERS];
    nrd_desc nd = { 0 };
    nrd *instance = NULL;
    for (uint32_t i = 0; i < desc->denoiser_count; i++) {
        denoisers[i].identifier = i;
        denoisers[i].denoiser = desc->denoisers[i];
    }
    nd.width = (uint32_t)frame->width;
    nd.height = (uint32_t)frame->height;
    nd.denoisers = denoisers;
    nd.denoiser_count = desc->denoiser_count;
    nd.features = features_for(desc, frame);
    nd.absent = desc->absent;
    nd.normal_encoding = NRD_NORMAL_FORMAT_RGB10A2_UNORM;
    nd.roughness_encoding = NRD_ROUGHNESS_FORMAT_LINEAR;
    nd.message = keep_message;
    nd.message_user = sink;
    bool ok = check(nrd_create(&nd, &instance), sink);
    for (uint32_t i = 0; i < desc->denoiser_count && ok; i++) {
        any_settings settings;
        resolve_settings(desc, desc->denoisers[i], frame, &settings);
        ok = check(nrd_set_settings(instance, i, &settings), sink);
    }
    if (!ok) {
        nrd_destroy(instance);
        instance = NULL;
    }
    return instance;
}

/* ---- checks ---- */

static signal_id signal_of(const denoise_desc *desc, const output_row *row)
{
    return row->signal == SIGNAL_COUNT ? desc->reference_signal : row->signal;
}

static bool check_inputs(const denoise_desc *desc, const nrd *instance, const capture *frame, const char *path, denoise_sink *sink)
{
    for (size_t i = 0; i < COUNT(inputs); i++) {
        size_t count = 0;
        uint32_t light = has_lamp(frame) ? CAPTURE_HAS_LAMP_RADIUS : CAPTURE_HAS_SUN_DIRECTION | CAPTURE_HAS_SUN_TAN_ANGULAR_RADIUS;
        uint32_t attributes = inputs[i].resource == NRD_RESOURCE_IN_PENUMBRA ? light : 0;
        if (!nrd_uses_resource(instance, inputs[i].resource))
            continue;
        while (count < COUNT(inputs[i].planes) && inputs[i].planes[count])
            count++;
        if (!capture_require(frame, path, attributes, inputs[i].planes, count, sink->text, sink->size))
            return false;
        if (inputs[i].resource == NRD_RESOURCE_IN_SIGNAL
            && !signal_require(frame, path, desc->reference_signal, sink->text, sink->size))
            return false;
    }
    return true;
}

/* Adds what the outputs of one instance are to `written`; refuses what is there already. */
static bool claim_outputs(const denoise_desc *desc, const nrd *instance, bool *written, denoise_sink *sink)
{
    for (size_t i = 0; i < COUNT(outputs); i++) {
        signal_id signal = signal_of(desc, &outputs[i]);
        if (!nrd_uses_resource(instance, outputs[i].resource))
            continue;
        if (written[signal]) {
            snprintf(sink->text, sink->size, "two denoisers would both write %s", signal_name(signal));
            return false;
        }
        written[signal] = true;
    }
    return true;
}

static bool check_outputs(const denoise_desc *desc, const capture *frame, denoise_sink *sink)
{
    bool written[SIGNAL_COUNT] = { false }, ok = true;
    for (uint32_t i = 0; i < desc->denoiser_count && ok; i++) {
        denoise_desc one = *desc;
        one.denoisers[0] = desc->denoisers[i];
        one.denoiser_count = 1;
        nrd *instance = denoise_make_instance(&one, frame, sink);
        ok = instance && claim_outputs(desc, instance, written, sink);
        nrd_destroy(instance);
    }
    return ok;
}

static bool check_frame(const denoise_desc *desc, const nrd *instance, const capture *frame, const char *path, denoise_sink *sink)
{
    return capture_require(frame, path, CAPTURE_HAS_CAMERA | CAPTURE_HAS_DENOISING_RANGE, NULL, 0, sink->text, sink->size)
        && check_inputs(desc, instance, frame, path, sink);
}

bool denoise_check(const denoise_desc *desc, const capture *frame, const char *path, char *error, size_t error_size)
{
    denoise_sink sink = { error, error_size };
    say(error, error_size, "");
    nrd *instance = denoise_make_instance(desc, frame, &sink);
    bool ok = instance && check_frame(desc, instance, frame, path, &sink) && check_outputs(desc, frame, &sink);
    nrd_destroy(instance);
    return ok;
}

/* ---- creation ---- */

static VkFormat format_of(nrd_resource resource)
{
    for (size_t i = 0; i < COUNT(inputs); i++)
        if (inputs[i].resource == resource)
            return inputs[i].format;
    return nrd_vk_format(nrd_resource_format(resource));
}

/* 0: every pixel of the input is there; else its colour in the checkerboard, from 1. */
static uint32_t checkerboard_of(const denoise_desc *desc, nrd_resource resource)
{
    static const struct { nrd_resource resource; const char *setting; } rows[] = {
        { NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, "diffuse_checkerboard" }, { NRD_RESOURCE_IN_DIFF_HITDIST, "diffuse_checkerboard" },
        { NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST, "diffuse_checkerboard" }, { NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, "specular_checkerboard" },
        { NRD_RESOURCE_IN_SPEC_HITDIST, "specular_checkerboard" }, { NRD_RESOURCE_IN_DIFF_SH0, "diffuse_checkerboard" },
        { NRD_RESOURCE_IN_DIFF_SH1, "diffuse_checkerboard" }, { NRD_RESOURCE_IN_SPEC_SH0, "specular_checkerboard" },
        { NRD_RESOURCE_IN_SPEC_SH1, "specular_checkerboard" },
    };
    uint32_t color = 0;
    for (size_t k = 0; k < COUNT(rows); k++)
        for (uint32_t i = 0; i < desc->setting_count && rows[k].resource == resource; i++)
            if (!strcmp(desc->settings[i].name, rows[k].setting))
                color = (uint32_t)desc->settings[i].value;
    return color;
}

static uint32_t input_width(const denoise *d, nrd_resource resource)
{
    return checkerboard_of(&d->desc, resource) ? (uint32_t)(d->width + 1) / 2 : (uint32_t)d->width;
}

static bool create_images(denoise *d)
{
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        nrd_resource resource = (nrd_resource)i;
        const char *name = nrd_resource_name(resource);
        if (!nrd_uses_resource(d->instance, resource))
            continue;
        if (!gpu_image_create(&d->g, input_width(d, resource), (uint32_t)d->height, format_of(resource), name, &d->images[i]))
            return say(d->sink.text, d->sink.size, gpu_error(&d->g));
    }
    return true;
}

static bool create_runtime(denoise *d)
{
    nrd_vk_desc desc = { 0 };
    desc.instance = d->instance;
    desc.vk_instance = d->g.instance;
    desc.physical = d->g.physical;
    desc.device = d->g.device;
    desc.get_instance_proc = d->g.get_instance_proc;
    desc.pipeline_cache = d->g.pipeline_cache;
    desc.frames_in_flight = 1;
    desc.queue_family = d->g.family;
    desc.flags = NRD_VK_TIMESTAMPS | (d->desc.validate ? NRD_VK_DEBUG_NAMES : 0);
    return check(nrd_vk_check_device(d->instance, d->g.instance, d->g.physical, d->g.get_instance_proc), &d->sink)
        && check(nrd_vk_create(&desc, &d->vk), &d->sink);
}

static bool create_parts(denoise *d, const capture *frame)
{
    gpu_desc device = { .device_index = d->desc.device_index, .validation = d->desc.validate, .sync_validation = d->desc.validate, .shared = d->desc.device };
    char reason[256];
    if (!gpu_open(&d->g, &device, reason, sizeof reason)) {
        snprintf(d->sink.text, d->sink.size, "cannot open a Vulkan device: %s", reason);
        return false;
    }
    d->instance = denoise_make_instance(&d->desc, frame, &d->sink);
    if (!d->instance || !create_runtime(d) || !create_images(d))
        return false;
    uint32_t passes = nrd_get_info(d->instance)->pass_count;
    d->raw_timings = calloc(passes, sizeof *d->raw_timings);
    d->timings = calloc(passes, sizeof *d->timings);
    d->texels = malloc(pixels_of(frame) * TEXEL_BYTES_MAX);
    return (d->raw_timings && d->timings && d->texels) || say(d->sink.text, d->sink.size, "out of memory");
}

denoise *denoise_create(const denoise_desc *desc, const capture *frame, char *error, size_t error_size)
{
    denoise *d = calloc(1, sizeof *d);
    if (!d) {
        say(error, error_size, "out of memory");
        return NULL;
    }
    d->desc = *desc;
    d->first = true;
    d->width = frame->width;
    d->height = frame->height;
    d->sink = (denoise_sink){ error, error_size };
    say(error, error_size, "");
    if (!create_parts(d, frame)) {
        denoise_destroy(d);
        return NULL;
    }
    d->sink = (denoise_sink){ NULL, 0 };
    return d;
}

void denoise_destroy(denoise *d)
{
    if (!d)
        return;
    nrd_vk_destroy(d->vk);
    nrd_destroy(d->instance);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++)
        gpu_image_destroy(&d->g, &d->images[i]);
    gpu_close(&d->g);
    free(d->raw_timings);
    free(d->timings);
    free(d->texels);
    free(d);
}

/* ---- one frame ---- */

static frame_view view_of(const denoise *d, const capture *frame)
{
    static const char *const names[4] = { "hit_distance_a", "hit_distance_b", "hit_distance_c", "hit_distance_d" };
    frame_view view = { frame, d->desc.reference_signal, { 0, 0, 1, 0 } };   /* no growth with roughness unless set */
    for (uint32_t i = 0; i < d->desc.denoiser_count; i++) {
        any_settings settings;
        resolve_settings(&d->desc, d->desc.denoisers[i], frame, &settings);
        for (int k = 0; k < 4; k++) {
            double value;
            if (settings_get(d->desc.denoisers[i], &settings, names[k], &value))
                view.hit_distance[k] = (float)value;
        }
    }
    return view;
}

/* Keeps the traced pixels of a frame, packed to the left. */
static void thin_checkerboard(const denoise *d, uint32_t color, uint32_t index, size_t texel_bytes)
{
    uint32_t width = (uint32_t)d->width, half = (width + 1) / 2;
    unsigned char *texels = d->texels;
    for (uint32_t y = 0; y < (uint32_t)d->height; y++)
        for (uint32_t i = 0; i < half; i++) {
            uint32_t x = pack_checkerboard_x(i, y, index, color);
            memmove(texels + ((size_t)y * half + i) * texel_bytes, texels + ((size_t)y * width + (x < width ? x : width - 1)) * texel_bytes, texel_bytes);
        }
}

static bool upload_inputs(denoise *d, const frame_view *view, uint32_t index)
{
    for (size_t i = 0; i < COUNT(inputs); i++) {
        gpu_image *target = &d->images[inputs[i].resource];
        if (!target->view)
            continue;
        if (!inputs[i].pack(view, d->texels))
            return say(d->sink.text, d->sink.size, "out of memory");
        uint32_t checkerboard = checkerboard_of(&d->desc, inputs[i].resource);
        if (checkerboard)
            thin_checkerboard(d, checkerboard - 1, index, gpu_format_size(target->format));
        if (!gpu_upload(&d->g, target, d->texels))
            return say(d->sink.text, d->sink.size, gpu_error(&d->g));
    }
    return true;
}

/* The sun may move from frame to frame. */
static bool set_settings(denoise *d, const capture *frame)
{
    bool ok = true;
    for (uint32_t i = 0; i < d->desc.denoiser_count && ok; i++) {
        any_settings settings;
        resolve_settings(&d->desc, d->desc.denoisers[i], frame, &settings);
        ok = check(nrd_set_settings(d->instance, i, &settings), &d->sink);
    }
    return ok;
}

/* OpenEXR matrices are row-major for row vectors: the same bytes as nrd.h's column-major for column vectors. */
static nrd_frame frame_of(const denoise *d, const capture *frame, uint32_t index)
{
    nrd_frame f = nrd_frame_defaults();
    memcpy(f.camera.view_to_clip, frame->camera_to_clip, sizeof f.camera.view_to_clip);
    memcpy(f.camera.world_to_view, frame->world_to_camera, sizeof f.camera.world_to_view);
    memcpy(f.camera.jitter, frame->jitter, sizeof f.camera.jitter);
    f.frame_index = index;
    f.denoising_range = frame->denoising_range;
    f.motion_mode = NRD_MOTION_2_5D;
    f.history_confidence_available = d->images[NRD_RESOURCE_IN_DIFF_CONFIDENCE].view != VK_NULL_HANDLE;
    f.validation = d->desc.overlay;
    settings_apply(d->desc.settings, d->desc.setting_count, SETTINGS_OF_FRAME, 1.0, &f);
    return f;
}

static bool set_frame(denoise *d, const capture *frame, uint32_t index)
{
    nrd_frame f = frame_of(d, frame, index);
    if (d->first || frame->cut)
        f.restart = 1;
    d->first = false;
    return check(nrd_set_frame(d->instance, &f), &d->sink);
}

static bool run_passes(denoise *d)
{
    nrd_vk_image images[NRD_RESOURCE_COUNT];
    nrd_vk_frame frame = { 0 };
    memset(images, 0, sizeof images);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        const gpu_image *from = &d->images[i];
        nrd_vk_image *to = &images[frame.image_count];
        if (!from->view)
            continue;
        frame.image_count++;
        to->resource = (nrd_resource)i;
        to->image = from->image;
        to->view = from->view;
        to->format = from->format;
        to->width = from->width;
        to->height = from->height;
        to->layout_in = from->layout;
    }
    frame.images = images;
    VkCommandBuffer commands = gpu_begin(&d->g);
    if (!commands)
        return say(d->sink.text, d->sink.size, gpu_error(&d->g));
    if (!check(nrd_vk_record(d->vk, commands, &frame), &d->sink))
        return false;
    return gpu_submit_and_wait(&d->g) || say(d->sink.text, d->sink.size, gpu_error(&d->g));
}

static bool take_timings(denoise *d)
{
    uint32_t passes = nrd_get_info(d->instance)->pass_count;
    if (!check(nrd_vk_timings(d->vk, 0, d->raw_timings, passes, &d->timing_count), &d->sink))
        return false;
    for (uint32_t i = 0; i < d->timing_count; i++) {
        d->timings[i].pass = d->raw_timings[i].name;
        d->timings[i].milliseconds = d->raw_timings[i].nanoseconds * 1e-6;
    }
    return true;
}

/* ---- results ---- */

static bool is_sky(const capture *frame, const float *view_z, size_t i)
{
    return view_z && fabsf(view_z[i]) >= frame->denoising_range;
}

/* Roughness from which on the output may not have been written: what is stored differs from the capture's by up to 0.001. Infinite: all is. */
static float unwritten_roughness(const denoise_desc *desc, const output_row *row)
{
    float limit = 0;
    for (uint32_t i = 0; row->signal == SIGNAL_SPECULAR && i < desc->setting_count; i++)
        if (!strcmp(desc->settings[i].name, "specular_roughness_limit"))
            limit = (float)desc->settings[i].value;
    return limit > 0 ? limit - 0.001f : INFINITY;
}

/* Where nothing is written, the noisy input stays. Texels to an image of the signal, and w to `occlusion` (NULL: not wanted). */
static bool unpack_output(const denoise *d, const output_row *row, const capture *frame, image *out, image *occlusion)
{
    const float *view_z = row->keeps_sky ? capture_find_plane(frame, "viewZ") : NULL;
    const float *roughness = capture_find_plane(frame, "roughness"), least = unwritten_roughness(&d->desc, row);
    signal_id signal = signal_of(&d->desc, row);
    if (!signal_get(frame, NULL, signal, SOURCE_NOISY, out))
        return false;
    if (occlusion && !signal_get(frame, NULL, row->occlusion, SOURCE_NOISY, occlusion))
        return false;
    for (size_t i = 0; i < image_pixels(out); i++) {
        float rgbw[4];
        if (is_sky(frame, view_z, i) || (roughness && roughness[i] > least))
            continue;
        row->unpack(d->texels, i, rgbw);
        for (int k = 0; k < out->channels; k++)
            out->planes[k][i] = rgbw[k];
        if (occlusion)
            occlusion->planes[0][i] = rgbw[3];
    }
    return true;
}

static bool add_planes(capture *out, const char *prefix, const image *m)
{
    for (int k = 0; k < m->channels; k++) {
        char name[CAPTURE_NAME_SIZE];
        snprintf(name, sizeof name, m->channels == 1 ? "%s" : "%s.%c", prefix, "RGB"[k]);
        float *texels = capture_add_plane(out, name, CAPTURE_HALF);
        if (!texels)
            return false;
        memcpy(texels, m->planes[k], image_pixels(m) * sizeof *texels);
    }
    return true;
}

/* Whether the denoiser's normalised hit distances are the frame's occlusion: have the same parameters, as far as these matter. */
static bool is_ambient_occlusion(const denoise *d, const output_row *row, const frame_view *view)
{
    any_settings settings;
    double history_length = 0;
    for (uint32_t i = 0; i < d->desc.denoiser_count; i++) {
        resolve_settings(&d->desc, d->desc.denoisers[i], view->frame, &settings);
        settings_get(d->desc.denoisers[i], &settings, "return_history_length_instead_of_occlusion", &history_length);
    }
    float wanted[4];
    const float *has = view->hit_distance;
    signal_occlusion(view->frame, wanted);
    bool by_roughness = row->signal == SIGNAL_SPECULAR_AO && (has[2] != 1 || wanted[2] != 1);
    bool same_growth = !by_roughness || (has[2] == wanted[2] && has[3] == wanted[3]);
    return fabsf(has[0] - wanted[0]) < 1e-4f * wanted[0] && has[1] == wanted[1] && same_growth && history_length == 0;
}

/* Puts the second texel of every pixel, downloaded behind the first ones, beside its first. */
static bool interleave_pair(denoise *d, size_t pixels)
{
    uint64_t *texels = d->texels, *pairs = malloc(pixels * TEXEL_BYTES_MAX);
    for (size_t i = 0; i < pixels && pairs; i++) {
        pairs[2 * i] = texels[i];
        pairs[2 * i + 1] = texels[pixels + i];
    }
    if (pairs)
        memcpy(texels, pairs, pixels * TEXEL_BYTES_MAX);
    free(pairs);
    return pairs || say(d->sink.text, d->sink.size, "out of memory");
}

static bool download_output(denoise *d, const output_row *row, size_t pixels)
{
    bool pair = row->unpack == unpack_sh;
    if (!gpu_download(&d->g, &d->images[row->resource], d->texels)
        || (pair && !gpu_download(&d->g, &d->images[row->resource + 1], (uint64_t *)d->texels + pixels)))
        return say(d->sink.text, d->sink.size, gpu_error(&d->g));
    return !pair || interleave_pair(d, pixels);
}

static bool read_output(denoise *d, const output_row *row, const frame_view *view, capture *out, image *signals)
{
    image occlusion = { 0 };
    bool of_format = is_ambient_occlusion(d, row, view), wants_occlusion = row->occlusion != SIGNAL_COUNT && of_format;
    signal_id signal = signal_of(&d->desc, row);
    const char *prefix = row->other && !of_format ? row->other : signal_prefix(signal, SOURCE_DENOISED);
    if (!download_output(d, row, pixels_of(view->frame)))
        return false;
    bool ok = unpack_output(d, row, view->frame, &signals[signal], wants_occlusion ? &occlusion : NULL)
        && add_planes(out, prefix, &signals[signal])
        && (!wants_occlusion || add_planes(out, signal_prefix(row->occlusion, SOURCE_DENOISED), &occlusion));
    image_destroy(&occlusion);
    return ok || say(d->sink.text, d->sink.size, "out of memory");
}

/* Adds denoised.final, unless it was denoised itself or the frame lacks what it is composed of. */
static bool add_final(denoise *d, const capture *frame, const char *path, capture *out, image *signals)
{
    float *sun[3];
    bool has_sun = capture_find_planes(frame, "sun", "RGB", sun), ok = true;
    image *diffuse = &signals[SIGNAL_DIFFUSE], *specular = &signals[SIGNAL_SPECULAR], *final = &signals[SIGNAL_FINAL];
    signal_id visibility = signals[SIGNAL_TRANSLUCENCY].channels || (!signals[SIGNAL_SHADOW].channels && signal_is_colored(frame)) ? SIGNAL_TRANSLUCENCY : SIGNAL_SHADOW;
    const signal_id parts[3] = { SIGNAL_DIFFUSE, SIGNAL_SPECULAR, visibility };
    const image *shadow = has_sun ? &signals[visibility] : NULL;
    if (final->channels || !signal_require(frame, path, SIGNAL_FINAL, NULL, 0))
        return true;
    for (int i = 0; i < (has_sun ? 3 : 2) && ok; i++)
        if (!signals[parts[i]].channels)
            ok = signal_get(frame, NULL, parts[i], SOURCE_NOISY, &signals[parts[i]]);
    ok = ok && signal_compose(frame, diffuse, specular, shadow, final) && add_planes(out, signal_prefix(SIGNAL_FINAL, SOURCE_DENOISED), final);
    return ok || say(d->sink.text, d->sink.size, "out of memory");
}

static bool read_outputs(denoise *d, const frame_view *view, const char *path, capture *out)
{
    image signals[SIGNAL_COUNT] = { { 0 } };
    const capture *frame = view->frame;
    bool ok = capture_create(out, frame->width, frame->height);
    capture_copy_attributes(out, frame);
    for (size_t i = 0; i < COUNT(outputs) && ok; i++)
        if (d->images[outputs[i].resource].view)
            ok = read_output(d, &outputs[i], view, out, signals);
    ok = ok && add_final(d, frame, path, out, signals);
    for (int s = 0; s < SIGNAL_COUNT; s++)
        image_destroy(&signals[s]);
    if (!ok)
        capture_destroy(out);
    return ok;
}

/* All but reading back; d->sink is set for the caller to go on with. */
static bool run_frame(denoise *d, const frame_view *view, const char *path, uint32_t index, char *error, size_t error_size)
{
    const capture *frame = view->frame;
    if (frame->width != d->width || frame->height != d->height) {
        snprintf(error, error_size, "%s: is %dx%d, the first frame is %dx%d", path, frame->width, frame->height, d->width, d->height);
        return false;
    }
    say(error, error_size, "");
    d->sink = (denoise_sink){ error, error_size };
    return check_frame(&d->desc, d->instance, frame, path, &d->sink) && upload_inputs(d, view, index)
        && set_settings(d, frame) && set_frame(d, frame, index) && run_passes(d) && take_timings(d);
}

bool denoise_frame(denoise *d, const capture *frame, const char *path, uint32_t index, capture *out, char *error, size_t error_size)
{
    frame_view view = view_of(d, frame);
    memset(out, 0, sizeof *out);
    bool ok = run_frame(d, &view, path, index, error, error_size) && read_outputs(d, &view, path, out);
    d->sink = (denoise_sink){ NULL, 0 };
    return ok;
}

bool denoise_look(denoise *d, const capture *frame, const char *path, uint32_t index, char *error, size_t error_size)
{
    frame_view view = view_of(d, frame);
    bool ok = run_frame(d, &view, path, index, error, error_size);
    d->sink = (denoise_sink){ NULL, 0 };
    return ok;
}

bool denoise_overlay(denoise *d, unsigned char *rgb, char *error, size_t error_size)
{
    const unsigned char *texels = d->texels;
    if (!gpu_download(&d->g, &d->images[NRD_RESOURCE_OUT_VALIDATION], d->texels))
        return say(error, error_size, gpu_error(&d->g));
    for (size_t i = 0; i < (size_t)d->width * (size_t)d->height; i++)
        memcpy(rgb + 3 * i, texels + 4 * i, 3);
    return true;
}

/* Planes whose faults packing repairs. hit: the plane may be negative nowhere, though infinite. */
typedef struct plane_row {
    nrd_resource resource;
    const char *planes[4];
    nrd_counter not_finite, negative;
    bool hit;
} plane_row;

static const plane_row repaired[] = {
    { NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, { "diffuse.R", "diffuse.G", "diffuse.B" }, NRD_COUNTER_DIFF_NOT_FINITE, NRD_COUNTER_DIFF_NEGATIVE, false },
    { NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, { "specular.R", "specular.G", "specular.B" }, NRD_COUNTER_SPEC_NOT_FINITE, NRD_COUNTER_SPEC_NEGATIVE, false },
    { NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, { "diffuse.hitT" }, NRD_COUNTER_DIFF_NOT_FINITE, NRD_COUNTER_DIFF_HIT_NEGATIVE, true },
    { NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, { "specular.hitT" }, NRD_COUNTER_SPEC_NOT_FINITE, NRD_COUNTER_SPEC_HIT_NEGATIVE, true },
    { NRD_RESOURCE_IN_PENUMBRA, { "shadow.hitT" }, NRD_COUNTER_PENUMBRA_INVALID, NRD_COUNTER_PENUMBRA_INVALID, true },
};

static void count_plane_row(const capture *frame, const plane_row *row, uint64_t *counters)
{
    const float *z = capture_find_plane(frame, "viewZ"), *planes[3];
    int n = 0;
    for (; n < 3 && row->planes[n]; n++)
        planes[n] = capture_find_plane(frame, row->planes[n]);
    for (size_t i = 0; i < pixels_of(frame); i++) {
        bool finite = true, negative = false;
        if (is_sky(frame, z, i))
            continue;
        for (int k = 0; k < n; k++) {
            finite = finite && (isfinite(planes[k][i]) || (row->hit && isinf(planes[k][i])));
            negative = negative || planes[k][i] < 0;
        }
        counters[row->not_finite] += !finite;
        counters[row->negative] += finite && negative;
    }
}

static void count_normals(const capture *frame, uint64_t *counters)
{
    float *n[3];
    const float *z = capture_find_plane(frame, "viewZ");
    if (!capture_find_planes(frame, "normal", "XYZ", n))
        return;
    for (size_t i = 0; i < pixels_of(frame); i++) {
        float squared = n[0][i] * n[0][i] + n[1][i] * n[1][i] + n[2][i] * n[2][i];
        if (is_sky(frame, z, i))
            continue;
        counters[NRD_COUNTER_NORMAL_NOT_FINITE] += !isfinite(squared);
        counters[NRD_COUNTER_NORMAL_LENGTH] += isfinite(squared) && fabsf(squared - 1.0f) > 0.02f;
    }
}

bool denoise_count(denoise *d, const capture *frame, uint64_t *counters, char *error, size_t error_size)
{
    bool ok = true;
    d->sink = (denoise_sink){ error, error_size };
    for (uint32_t i = 0; i < d->desc.denoiser_count && ok; i++)
        ok = check(nrd_vk_counters(d->vk, 0, i, counters), &d->sink);
    d->sink = (denoise_sink){ NULL, 0 };
    for (size_t i = 0; i < COUNT(repaired) && ok; i++)
        if (nrd_uses_resource(d->instance, repaired[i].resource))
            count_plane_row(frame, &repaired[i], counters);
    if (ok)
        count_normals(frame, counters);
    return ok;
}

bool denoise_again(denoise *d, const capture *frame, uint32_t index, char *error, size_t error_size)
{
    say(error, error_size, "");
    d->sink = (denoise_sink){ error, error_size };
    bool ok = set_frame(d, frame, index) && run_passes(d) && take_timings(d);
    d->sink = (denoise_sink){ NULL, 0 };
    return ok;
}

static double image_bytes(const void *user, nrd_resource resource)
{
    const gpu_image *m = &((const denoise *)user)->images[resource];
    return (double)gpu_format_size(m->format) * m->width * m->height;
}

/* An instance of its own, so that counting moves no history. */
double denoise_bytes_moved(denoise *d, const capture *frame)
{
    const nrd_dispatch *dispatches = NULL;
    uint32_t count = 0;
    double bytes = 0;
    nrd *instance = denoise_make_instance(&d->desc, frame, &d->sink);
    for (uint32_t i = 0; i < 3 && instance; i++) {
        nrd_frame f = frame_of(d, frame, i);
        if (nrd_set_frame(instance, &f) || nrd_get_dispatches(instance, NULL, 0, &dispatches, &count))
            count = 0;
    }
    if (count)
        bytes = traffic_bytes(nrd_get_info(instance), dispatches, count, image_bytes, d);
    nrd_destroy(instance);
    return bytes;
}

const nrd_info *denoise_info(const denoise *d)
{
    return nrd_get_info(d->instance);
}

const denoise_timing *denoise_timings(const denoise *d, uint32_t *count)
{
    *count = d->timing_count;
    return d->timings;
}

const char *denoise_device_name(const denoise *d)
{
    return d->g.properties.deviceName;
}

uint32_t denoise_message_count(const denoise *d)
{
    return gpu_message_count(&d->g);
}
