#include "stress/rig.h"

#include "common/half.h"
#include "common/pack.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

void stress_die(const char *format, ...)
{
    va_list arguments;
    fprintf(stderr, "nrd-stress: ");
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    exit(2);
}

static void *array(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) stress_die("out of memory");
    return memory;
}

/* ---- what the resources are */
static bool ends_with(const char *text, const char *end)
{
    size_t a = strlen(text), b = strlen(end);
    return a >= b && strcmp(text + a - b, end) == 0;
}

static signal_kind kind_of(nrd_resource resource)
{
    static const struct { const char *end; signal_kind kind; } rows[] = {
        { "_RADIANCE_HITDIST", KIND_RADIANCE }, { "_SH0", KIND_RADIANCE }, { "_SH1", KIND_VECTOR }, { "_DIRECTION_HITDIST", KIND_DIRECTION },
        { "_HITDIST", KIND_HIT_DIST }, { "_PENUMBRA", KIND_PENUMBRA }, { "_TRANSLUCENCY", KIND_TRANSLUCENCY }, { "_SIGNAL", KIND_PLAIN },
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        if (ends_with(nrd_resource_name(resource), rows[i].end)) return rows[i].kind;
    return KIND_NONE;
}

static bool is_input(nrd_resource resource) { return strncmp(nrd_resource_name(resource), "IN_", 3) == 0; }

/* The output that shows an input: of the same name; of a shadow, whichever there is. */
static nrd_resource output_of(const rig *r, nrd_resource in)
{
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        const char *name = nrd_resource_name((nrd_resource)i);
        bool same = strcmp(name + 3, nrd_resource_name(in) + 2) == 0 || (in == NRD_RESOURCE_IN_PENUMBRA && strncmp(name, "OUT_SHADOW", 10) == 0);
        if (!is_input((nrd_resource)i) && same && nrd_uses_resource(r->instance, (nrd_resource)i)) return (nrd_resource)i;
    }
    return NRD_RESOURCE_COUNT;
}

static void find_signals(rig *r)
{
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        signal_kind kind = kind_of((nrd_resource)i);
        if (!is_input((nrd_resource)i) || kind == KIND_NONE || !nrd_uses_resource(r->instance, (nrd_resource)i)) continue;
        if (r->signal_count == RIG_MAX_SIGNALS) stress_die("%s has too many signals", nrd_denoiser_name(r->denoiser));
        rig_signal signal = { (nrd_resource)i, output_of(r, (nrd_resource)i), kind };
        r->signals[r->signal_count++] = signal;
    }
}

/* Inputs as wide as they can be, so that any value gets through. */
static VkFormat format_of(nrd_resource resource)
{
    if (!is_input(resource)) return nrd_vk_format(nrd_resource_format(resource));
    if (resource == NRD_RESOURCE_IN_NORMAL_ROUGHNESS) return VK_FORMAT_A2B10G10R10_UNORM_PACK32;
    if (resource == NRD_RESOURCE_IN_TRANSLUCENCY) return VK_FORMAT_R8G8B8A8_UNORM;
    signal_kind kind = kind_of(resource);
    bool four = resource == NRD_RESOURCE_IN_MV || (kind != KIND_NONE && kind != KIND_HIT_DIST && kind != KIND_PENUMBRA);
    return four ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_R32_SFLOAT;
}

/* ---- life */
static void keep_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    rig *r = (rig *)user;
    (void)result;
    if (severity == NRD_SEVERITY_ERROR) snprintf(r->message, sizeof r->message, "%s", text);
}

static void create_images(rig *r)
{
    size_t pixels = (size_t)r->width * r->height;
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        nrd_resource resource = (nrd_resource)i;
        if (!nrd_uses_resource(r->instance, resource)) continue;
        if (!gpu_image_create(r->device, r->width, r->height, format_of(resource), nrd_resource_name(resource), &r->images[i])) stress_die("%s", gpu_error(r->device));
        r->texels[i] = (float *)array(pixels * 4, sizeof(float));
        for (size_t k = 0; k < 4 * pixels; k++) r->texels[i][k] = is_input(resource) ? 1.0f : 0.0f;
    }
    r->material = (uint8_t *)array(pixels, 1);
    r->packed = array(pixels, 16);
}

void rig_open(rig *r, const rig_desc *desc)
{
    memset(r, 0, sizeof *r);
    r->device = desc->device;
    r->fault = desc->fault;
    r->set = desc->set;
    r->set_count = desc->set_count;
    r->denoiser = desc->denoiser;
    r->width = desc->width;
    r->height = desc->height;
    r->normal_encoding = desc->normal_encoding;
    nrd_denoiser_desc one = { RIG_IDENTIFIER, desc->denoiser };
    nrd_desc core = { .width = desc->width, .height = desc->height, .denoisers = &one, .denoiser_count = 1, .features = desc->features,
                      .normal_encoding = desc->normal_encoding, .message = keep_message, .message_user = r };
    if (nrd_create(&core, &r->instance)) stress_die("nrd_create: %s", r->message);
    nrd_vk_desc vk = { .instance = r->instance, .vk_instance = r->device->instance, .physical = r->device->physical, .device = r->device->device,
                       .get_instance_proc = r->device->get_instance_proc, .frames_in_flight = desc->frames_in_flight ? desc->frames_in_flight : 1 };
    if (nrd_vk_create(&vk, &r->vk)) stress_die("nrd_vk_create: %s", r->message);
    find_signals(r);
    create_images(r);
    rig_reset(r);
}

void rig_close(rig *r)
{
    nrd_vk_destroy(r->vk);
    nrd_destroy(r->instance);
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        gpu_image_destroy(r->device, &r->images[i]);
        free(r->texels[i]);
        free(r->sent[i]);
    }
    free(r->material);
    free(r->raw_normals);
    free(r->packed);
}

static surface plane_shape(const rig *r, uint32_t x, uint32_t y) { return rig_surface(r, x, y); }

void rig_reset(rig *r)
{
    r->frame = nrd_frame_defaults();
    r->frame.denoising_range = 1000;
    r->frame.restart = 1;
    r->ran = 0;
    nrd_settings_defaults(r->denoiser, &r->settings);
    settings_apply(r->set, r->set_count, r->denoiser, 1, &r->settings);
    r->camera = r->camera_prev = pose_at(0, 0, 0);
    r->rect_width = r->width;
    r->rect_height = r->height;
    r->origin_x = r->origin_y = 0;
    r->shape = plane_shape;
    r->depth = 10;
    r->tilt = 0;
    r->roughness = 0.5;
    r->variant = 0;
    free(r->raw_normals);
    r->raw_normals = NULL;
}

bool rig_set(rig *r, const char *name, double value)
{
    nrd_setting row;
    for (uint32_t i = 0; nrd_get_setting(r->denoiser, i, &row); i++) {
        if (strcmp(row.name, name) != 0) continue;
        setting_put(&row, &r->settings, value);
        return true;
    }
    return false;
}

/* ---- guides */
/* A plane at r->depth in the middle of the picture, turned by r->tilt around the vertical; worked out in view space, so that it is exact
   wherever the camera stands. */
surface rig_surface(const rig *r, uint32_t x, uint32_t y)
{
    surface s = { .depth = r->depth, .roughness = r->roughness };
    double turn = r->tilt * 0.017453292519943295, u = (x + 0.5) / r->rect_width, axes[3][3], normal[3] = { sin(turn), 0, -cos(turn) };
    double slope = (2 * u - 1 + r->camera.shift[0]) * r->camera.tan_half_height * r->camera.aspect;
    (void)y;
    if (r->camera.orthographic) s.depth = r->depth + slope * tan(turn);
    else s.depth = r->depth / (1 - slope * tan(turn));
    if (!(s.depth > 0)) s.depth = RIG_SKY;
    pose_axes(&r->camera, axes);
    for (int k = 0; k < 3; k++)
        for (int row = 0; row < 3; row++) s.normal[k] += axes[row][k] * normal[row];
    return s;
}

float *rig_texel(const rig *r, nrd_resource resource, uint32_t x, uint32_t y)
{
    bool guide = resource == NRD_RESOURCE_IN_MV || resource == NRD_RESOURCE_IN_NORMAL_ROUGHNESS || resource == NRD_RESOURCE_IN_VIEWZ;
    size_t at = (size_t)(y + (guide ? r->origin_y : 0)) * r->width + x + (guide ? r->origin_x : 0);
    return &r->texels[resource][4 * at];
}

bool rig_is_sky(const rig *r, uint32_t x, uint32_t y)
{
    const float *z = r->texels[NRD_RESOURCE_IN_VIEWZ] ? rig_texel(r, NRD_RESOURCE_IN_VIEWZ, x, y) : NULL;
    return z && !(fabsf(*z * r->frame.view_z_scale) < r->frame.denoising_range);
}

/* As the denoiser understands it. */
static float stored_roughness(const rig *r, uint32_t x, uint32_t y)
{
    const float *t = rig_texel(r, NRD_RESOURCE_IN_NORMAL_ROUGHNESS, x, y);
    size_t i = (size_t)(t - r->texels[NRD_RESOURCE_IN_NORMAL_ROUGHNESS]) / 4;
    uint32_t packed = r->raw_normals ? r->raw_normals[i] : pack_normal_roughness(t, t[3], r->material[i]);
    return r->normal_encoding == NRD_NORMAL_FORMAT_RGB10A2_UNORM ? fabsf((float)(packed >> 20 & 1023) / 1023.0f * 2 - 1) : (float)(packed >> 30) / 3.0f;
}

bool rig_is_too_rough(const rig *r, uint32_t signal, uint32_t x, uint32_t y)
{
    nrd_resource out = r->signals[signal].out;
    bool specular = out == NRD_RESOURCE_OUT_SPEC_RADIANCE_HITDIST || out == NRD_RESOURCE_OUT_SPEC_SH0 || out == NRD_RESOURCE_OUT_SPEC_SH1;
    double limit = 0;
    return specular && settings_get(r->denoiser, &r->settings, "specular_roughness_limit", &limit) && limit > 0 && stored_roughness(r, x, y) > (float)limit;
}

static void put_motion(rig *r, const surface *s, uint32_t x, uint32_t y)
{
    double u = (x + 0.5) / r->rect_width, v = (y + 0.5) / r->rect_height, world[3], u_prev = u, v_prev = v, depth_prev = s->depth;
    float *mv = rig_texel(r, NRD_RESOURCE_IN_MV, x, y);
    bool in_world = r->frame.motion_mode == NRD_MOTION_WORLD, still = memcmp(&r->camera, &r->camera_prev, sizeof r->camera) == 0;
    if (!still || s->moved[0] != 0 || s->moved[1] != 0 || s->moved[2] != 0) {
        pose_point(&r->camera, u, v, s->depth, world);
        for (int k = 0; k < 3; k++) world[k] += s->moved[k];
        pose_project(&r->camera_prev, world, &u_prev, &v_prev, &depth_prev);
    }
    mv[0] = (float)(in_world ? s->moved[0] : u_prev - u);
    mv[1] = (float)(in_world ? s->moved[1] : v_prev - v);
    mv[2] = (float)(in_world ? s->moved[2] : (depth_prev - s->depth) * (r->camera.right_handed ? -1 : 1));
}

void rig_put_guides(rig *r)
{
    if (!r->texels[NRD_RESOURCE_IN_VIEWZ]) return;
    for (uint32_t y = 0; y < r->rect_height; y++)
        for (uint32_t x = 0; x < r->rect_width; x++) {
            surface s = r->shape(r, x, y);
            float *normal = rig_texel(r, NRD_RESOURCE_IN_NORMAL_ROUGHNESS, x, y);
            *rig_texel(r, NRD_RESOURCE_IN_VIEWZ, x, y) = (float)s.depth * (r->camera.right_handed ? -1.0f : 1.0f);
            for (int k = 0; k < 3; k++) normal[k] = (float)s.normal[k];
            normal[3] = (float)s.roughness;
            r->material[(normal - r->texels[NRD_RESOURCE_IN_NORMAL_ROUGHNESS]) / 4] = (uint8_t)s.material;
            put_motion(r, &s, x, y);
        }
}

/* ---- transfers */
static uint8_t byte_of(float v) { return (uint8_t)((v > 0 ? v < 1 ? v : 1 : 0) * 255 + 0.5f); }

static void pack_one(const rig *r, nrd_resource resource, VkFormat format, size_t i, char *to)
{
    const float *t = &r->texels[resource][4 * i];
    uint32_t normal;
    switch (format) {
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
        normal = r->raw_normals ? r->raw_normals[i] : pack_normal_roughness(t, t[3], r->material[i]);
        memcpy(to, &normal, 4);
        return;
    case VK_FORMAT_R16G16B16A16_SFLOAT: half_from_floats((uint16_t *)(void *)to, t, 4); return;
    case VK_FORMAT_R16_SFLOAT: half_from_floats((uint16_t *)(void *)to, t, 1); return;
    case VK_FORMAT_R8G8B8A8_UNORM: for (int k = 0; k < 4; k++) ((uint8_t *)to)[k] = byte_of(t[k]); return;
    case VK_FORMAT_R8_UNORM: *(uint8_t *)to = byte_of(t[0]); return;
    case VK_FORMAT_R32_SFLOAT: memcpy(to, t, 4); return;
    default: memcpy(to, t, 16); return;
    }
}

static void unpack_one(const rig *r, nrd_resource resource, VkFormat format, size_t i, const char *from)
{
    float *t = &r->texels[resource][4 * i];
    uint16_t half[4];
    switch (format) {
    case VK_FORMAT_R16G16B16A16_SFLOAT:
        memcpy(half, from, 8);
        for (int k = 0; k < 4; k++) t[k] = half_to_float(half[k]);
        return;
    case VK_FORMAT_R16_SFLOAT: memcpy(half, from, 2); t[0] = half_to_float(half[0]); return;
    case VK_FORMAT_R8G8B8A8_UNORM: for (int k = 0; k < 4; k++) t[k] = (float)((const uint8_t *)from)[k] / 255.0f; return;
    case VK_FORMAT_R8_UNORM: t[0] = (float)*(const uint8_t *)from / 255.0f; return;
    case VK_FORMAT_R32_SFLOAT: memcpy(t, from, 4); return;
    default: memcpy(t, from, 16); return;
    }
}

void rig_upload(rig *r, nrd_resource resource)
{
    size_t pixels = (size_t)r->width * r->height, size = gpu_format_size(r->images[resource].format);
    for (size_t i = 0; i < pixels; i++) pack_one(r, resource, r->images[resource].format, i, (char *)r->packed + i * size);
    bool sent = r->sent[resource] && memcmp(r->sent[resource], r->packed, pixels * size) == 0;
    if (sent && is_input(resource)) return;
    if (!r->sent[resource]) r->sent[resource] = array(pixels, size);
    memcpy(r->sent[resource], r->packed, pixels * size);
    if (!gpu_upload(r->device, &r->images[resource], r->packed)) stress_die("%s", gpu_error(r->device));
}

float rig_untouched(nrd_resource out)
{
    nrd_format format = nrd_resource_format(out);
    return format == NRD_FORMAT_R8_UNORM || format == NRD_FORMAT_RGBA8_UNORM ? 128 / 255.0f : 77.0f;
}

void rig_upload_all(rig *r)
{
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (!r->texels[i]) continue;
        size_t written = is_input((nrd_resource)i) ? 0 : (size_t)r->width * r->height * 4;
        float untouched = rig_untouched((nrd_resource)i);
        for (size_t k = 0; k < written; k++) r->texels[i][k] = untouched;
        rig_upload(r, (nrd_resource)i);
    }
}

/* ---- faults */
const char *fault_name(fault f)
{
    static const char *const names[] = {
#define FAULT_NAME(name, text) text,
        FAULTS(FAULT_NAME)
#undef FAULT_NAME
    };
    return names[f];
}

static void spoil_texel(const rig *r, uint32_t signal, uint32_t x, uint32_t y)
{
    float *out = rig_texel(r, r->signals[signal].out, x, y), scale = 1;
    switch (r->fault) {
    case FAULT_NAN: out[0] = x == r->rect_width / 2 ? NAN : out[0]; return;
    case FAULT_BRIGHT: scale = 6; break;
    case FAULT_DARK: scale = 0.95f; break;
    case FAULT_COLOUR: out[1] = 3 * out[0] + 1; out[2] = out[0] + 1; return;
    case FAULT_NOISY: scale = 2 * (float)random_at(x, y, r->index); break;
    case FAULT_UNSTEADY: scale = 2 * (float)random_at(x, y, r->downloads); break;
    case FAULT_DRIFTING: scale = expf(-1e-4f * (float)r->ran); break;
    case FAULT_SMEARED: if (x) for (int k = 0; k < 4; k++) out[k] = 0.9f * out[k - 4] + 0.1f * out[k]; return;
    case FAULT_BLACK: scale = 0; break;
    default: return;
    }
    for (int k = 0; k < 4; k++) out[k] *= scale;
}

static void plant_fault(rig *r, uint32_t signal)
{
    for (uint32_t y = 0; y < r->rect_height; y++)
        for (uint32_t x = 0; x < r->rect_width; x++)
            if (r->fault != FAULT_WRITTEN) spoil_texel(r, signal, x, y);
            else if (rig_is_sky(r, x, y)) rig_texel(r, r->signals[signal].out, x, y)[0] = 0;
    if (r->fault == FAULT_WRITTEN && r->rect_width < r->width) rig_texel(r, r->signals[signal].out, r->rect_width, 0)[0] = 0;
}

void rig_download(rig *r)
{
    r->downloads++;
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (!r->texels[i] || is_input((nrd_resource)i)) continue;
        size_t size = gpu_format_size(r->images[i].format);
        if (!gpu_download(r->device, &r->images[i], r->packed)) stress_die("%s", gpu_error(r->device));
        for (size_t k = 0; k < (size_t)r->width * r->height; k++) unpack_one(r, (nrd_resource)i, r->images[i].format, k, (char *)r->packed + k * size);
    }
    for (uint32_t s = 0; s < r->signal_count; s++)
        if (r->fault != FAULT_NONE && r->signals[s].out != NRD_RESOURCE_COUNT) plant_fault(r, s);
}

/* ---- frames */
static nrd_result set_frame(rig *r)
{
    r->frame.camera = pose_camera(&r->camera);
    r->frame.clip_y = pose_clip_y(&r->camera);
    r->frame.frame_index = r->index;
    r->frame.rect_width = r->rect_width;
    r->frame.rect_height = r->rect_height;
    r->frame.rect_origin_x = r->origin_x;
    r->frame.rect_origin_y = r->origin_y;
    nrd_result result = nrd_set_frame(r->instance, &r->frame);
    return result ? result : nrd_set_settings(r->instance, RIG_IDENTIFIER, &r->settings);
}

static nrd_result record(rig *r, VkCommandBuffer cmd, uint32_t slot, const gpu_image *noisy)
{
    nrd_vk_image list[NRD_RESOURCE_COUNT];
    nrd_vk_frame frame = { .slot = slot, .images = list };
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        const gpu_image *image = &r->images[i];
        for (uint32_t s = 0; noisy && s < r->signal_count; s++)
            if (r->signals[s].in == (nrd_resource)i) image = &noisy[s];
        nrd_vk_image given = { .resource = (nrd_resource)i, .image = image->image, .view = image->view, .format = image->format, .width = image->width,
                               .height = image->height, .layout_in = image->layout, .layout_out = image->layout };
        if (image->view) list[frame.image_count++] = given;
    }
    return nrd_vk_record(r->vk, cmd, &frame);
}

static void advance(rig *r)
{
    r->frame.restart = 0;
    r->ran++;
    r->camera_prev = r->camera;
    r->index++;
}

nrd_result rig_try(rig *r)
{
    r->message[0] = 0;
    nrd_result result = set_frame(r);
    if (result) return result;
    VkCommandBuffer cmd = gpu_begin(r->device);
    if (!cmd) stress_die("%s", gpu_error(r->device));
    result = record(r, cmd, 0, NULL);
    if (!gpu_submit_and_wait(r->device)) stress_die("%s", gpu_error(r->device));
    if (!result) advance(r);
    return result;
}

void rig_run(rig *r)
{
    rig_upload_all(r);
    if (rig_try(r)) stress_die("%s: %s", nrd_denoiser_name(r->denoiser), r->message);
    rig_download(r);
}

void rig_run_many(rig *r, uint32_t frames, gpu_image *const *inputs, uint32_t count)
{
    for (uint32_t done = 0; done < frames;) {
        VkCommandBuffer cmd = gpu_begin(r->device);
        if (!cmd) stress_die("%s", gpu_error(r->device));
        for (uint32_t slot = 0; slot < RIG_SLOTS && done < frames; slot++, done++) {
            if (set_frame(r) || record(r, cmd, slot, inputs ? inputs[r->index % count] : NULL)) stress_die("%s: %s", nrd_denoiser_name(r->denoiser), r->message);
            advance(r);
        }
        if (!gpu_submit_and_wait(r->device)) stress_die("%s", gpu_error(r->device));
    }
}

static void forget_sent(rig *r, nrd_resource resource)
{
    free(r->sent[resource]);
    r->sent[resource] = NULL;
}

gpu_image rig_make_input(rig *r, uint32_t signal)
{
    gpu_image image, kept = r->images[r->signals[signal].in];
    if (!gpu_image_create(r->device, r->width, r->height, kept.format, "input", &image)) stress_die("%s", gpu_error(r->device));
    r->images[r->signals[signal].in] = image;
    forget_sent(r, r->signals[signal].in);
    rig_upload(r, r->signals[signal].in);
    forget_sent(r, r->signals[signal].in);
    image = r->images[r->signals[signal].in];
    r->images[r->signals[signal].in] = kept;
    return image;
}

/* ---- values */
static double finite_within(double v, double low, double high) { return isfinite(v) ? v < low ? low : v > high ? high : v : 0; }

double rig_input_value(const rig *r, uint32_t signal, uint32_t x, uint32_t y)
{
    const float *t = rig_texel(r, r->signals[signal].in, x, y);
    switch (r->signals[signal].kind) {
    case KIND_RADIANCE: return isfinite(t[0]) && isfinite(t[1]) && isfinite(t[2]) ? finite_within(t[0], 0, 65504) : 0;
    case KIND_HIT_DIST: return finite_within(t[0], 0, 1);
    case KIND_DIRECTION: return finite_within(t[3], 0, 1);
    case KIND_PENUMBRA: return t[0] >= 65504 ? 1 : r->texels[NRD_RESOURCE_IN_TRANSLUCENCY] && t[0] > 0 ? byte_of(*rig_texel(r, NRD_RESOURCE_IN_TRANSLUCENCY, x, y)) / 255.0 : 0;
    default: return isfinite(t[0]) && isfinite(t[1]) && isfinite(t[2]) && isfinite(t[3]) ? t[0] : 0;
    }
}

double rig_output_value(const rig *r, uint32_t signal, uint32_t x, uint32_t y)
{
    const float *t = rig_texel(r, r->signals[signal].out, x, y);
    switch (r->signals[signal].kind) {
    case KIND_DIRECTION: return t[3];
    case KIND_PENUMBRA: case KIND_TRANSLUCENCY: return (double)t[0] * t[0];   /* stored as a root */
    default: return t[0];
    }
}
