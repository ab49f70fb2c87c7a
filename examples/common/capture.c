#define _POSIX_C_SOURCE 200809L
#include "common/capture.h"

#include "common/half.h"

#include <OpenEXR/openexr.h>
#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIZE_LIMIT 32768

/* ---- errors ---- */

typedef struct report {
    const char *path;
    char *text;
    size_t size;
    char library[256]; /* what OpenEXRCore said last */
} report;

/* Returns false, so that a failing function can return its value. */
static bool fail(report *r, const char *format, ...)
{
    va_list arguments;
    if (!r->text || !r->size)
        return false;
    int used = snprintf(r->text, r->size, "%s: ", r->path);
    if (used < 0 || (size_t)used >= r->size)
        return false;
    va_start(arguments, format);
    vsnprintf(r->text + used, r->size - (size_t)used, format, arguments);
    va_end(arguments);
    return false;
}

/* OpenEXRCore prints to stderr unless it is given a handler. */
static void keep_message(exr_const_context_t context, exr_result_t code, const char *message)
{
    void *user = NULL;
    (void)code;
    if (context && exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user)
        snprintf(((report *)user)->library, sizeof ((report *)user)->library, "%s", message);
}

static bool fail_library(report *r, const char *doing, exr_result_t code)
{
    char *line_end = strpbrk(r->library, "\r\n");
    if (line_end)
        *line_end = 0;
    return fail(r, "%s: %s", doing, r->library[0] ? r->library : exr_get_default_error_message(code));
}

static exr_context_initializer_t initializer(report *r)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_message;
    init.user_data = r;
    init.max_image_width = SIZE_LIMIT;
    init.max_image_height = SIZE_LIMIT;
    /* a truncated file is an error, not a picture with holes */
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return init;
}

/* ---- planes ---- */

static size_t pixel_count(const capture *c)
{
    return (size_t)c->width * (size_t)c->height;
}

bool capture_create(capture *out, int width, int height)
{
    memset(out, 0, sizeof *out);
    if (width < 1 || height < 1 || width > SIZE_LIMIT || height > SIZE_LIMIT)
        return false;
    out->width = width;
    out->height = height;
    out->denoising_range = INFINITY;
    out->metres_per_unit = 1.0f;
    return true;
}

void capture_destroy(capture *c)
{
    for (uint32_t i = 0; i < c->plane_count; i++)
        free(c->planes[i].texels);
    free(c->planes);
    memset(c, 0, sizeof *c);
}

float *capture_find_plane(const capture *c, const char *name)
{
    for (uint32_t i = 0; i < c->plane_count; i++)
        if (!strcmp(c->planes[i].name, name))
            return c->planes[i].texels;
    return NULL;
}

bool capture_find_planes(const capture *c, const char *prefix, const char *suffixes, float **planes)
{
    float *found[8];
    size_t count = strlen(suffixes);
    if (count > sizeof found / sizeof *found)
        return false;
    for (size_t i = 0; i < count; i++) {
        char name[CAPTURE_NAME_SIZE];
        snprintf(name, sizeof name, "%s.%c", prefix, suffixes[i]);
        if (!(found[i] = capture_find_plane(c, name)))
            return false;
    }
    memcpy(planes, found, count * sizeof *found);
    return true;
}

float *capture_add_plane(capture *c, const char *name, capture_type type)
{
    float *texels = capture_find_plane(c, name);
    if (texels)
        return texels;
    if (!name[0] || strlen(name) >= CAPTURE_NAME_SIZE)
        return NULL;
    capture_plane *planes = realloc(c->planes, (c->plane_count + 1) * sizeof *planes);
    if (!planes)
        return NULL;
    c->planes = planes;
    texels = calloc(pixel_count(c), sizeof *texels);
    if (!texels)
        return NULL;
    capture_plane *plane = &planes[c->plane_count++];
    strcpy(plane->name, name);
    plane->type = type;
    plane->texels = texels;
    return texels;
}

/* ---- attributes ---- */

typedef enum attribute_kind { KIND_m44f, KIND_v2f, KIND_v3f, KIND_float, KIND_int } attribute_kind;

static const struct {
    const char *name;
    attribute_kind kind;
    size_t offset;
} attributes[] = {
#define CAPTURE_ROW(bit, exr, type, member) { #exr, KIND_##type, offsetof(capture, member) },
    CAPTURE_ATTRIBUTES(CAPTURE_ROW)
#undef CAPTURE_ROW
};

void capture_copy_attributes(capture *to, const capture *from)
{
    capture copy = *from;
    copy.width = to->width;
    copy.height = to->height;
    copy.planes = to->planes;
    copy.plane_count = to->plane_count;
    *to = copy;
}

static exr_result_t get_attribute(exr_const_context_t file, int i, capture *c)
{
    const char *name = attributes[i].name;
    void *at = (char *)c + attributes[i].offset;
    switch (attributes[i].kind) {
    case KIND_m44f: return exr_attr_get_m44f(file, 0, name, at);
    case KIND_v2f: return exr_attr_get_v2f(file, 0, name, at);
    case KIND_v3f: return exr_attr_get_v3f(file, 0, name, at);
    case KIND_float: return exr_attr_get_float(file, 0, name, at);
    case KIND_int: return exr_attr_get_int(file, 0, name, at);
    }
    return EXR_ERR_INVALID_ARGUMENT;
}

static exr_result_t set_attribute(exr_context_t file, int i, const capture *c)
{
    const char *name = attributes[i].name;
    const void *at = (const char *)c + attributes[i].offset;
    switch (attributes[i].kind) {
    case KIND_m44f: return exr_attr_set_m44f(file, 0, name, at);
    case KIND_v2f: return exr_attr_set_v2f(file, 0, name, at);
    case KIND_v3f: return exr_attr_set_v3f(file, 0, name, at);
    case KIND_float: return exr_attr_set_float(file, 0, name, *(const float *)at);
    case KIND_int: return exr_attr_set_int(file, 0, name, *(const int *)at);
    }
    return EXR_ERR_INVALID_ARGUMENT;
}

static bool read_attributes(exr_const_context_t file, capture *c, report *r)
{
    for (int i = 0; i < CAPTURE_ATTRIBUTE_COUNT; i++) {
        exr_result_t code = get_attribute(file, i, c);
        if (code == EXR_ERR_SUCCESS)
            c->present |= 1u << i;
        else if (code != EXR_ERR_NO_ATTR_BY_NAME)
            return fail(r, "attribute %s is not of its type", attributes[i].name);
    }
    r->library[0] = 0;
    return true;
}

bool capture_require(const capture *c, const char *path, uint32_t required, const char *const *planes, size_t count,
                     char *error, size_t error_size)
{
    report r = { path, error, error_size, "" };
    for (int i = 0; i < CAPTURE_ATTRIBUTE_COUNT; i++)
        if (required & ~c->present & 1u << i)
            return fail(&r, "attribute %s is missing", attributes[i].name);
    for (size_t i = 0; i < count; i++)
        if (!capture_find_plane(c, planes[i]))
            return fail(&r, "channel %s is missing", planes[i]);
    return true;
}

/* ---- reading ---- */

static bool check_kind(exr_const_context_t file, report *r)
{
    int parts = 0;
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    exr_get_count(file, &parts);
    if (parts != 1)
        return fail(r, "has %d parts, expected 1", parts);
    exr_get_storage(file, 0, &storage);
    return storage == EXR_STORAGE_SCANLINE || fail(r, "is not a scanline image");
}

/* A plane for every channel that is not sub-sampled. */
static bool add_channels(exr_const_context_t file, capture *c, report *r)
{
    const exr_attr_chlist_t *list = NULL;
    exr_result_t code = exr_get_channels(file, 0, &list);
    if (code != EXR_ERR_SUCCESS)
        return fail_library(r, "cannot read the channel list", code);
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *channel = &list->entries[i];
        bool whole = channel->x_sampling == 1 && channel->y_sampling == 1;
        if (!whole || channel->name.length >= CAPTURE_NAME_SIZE)
            continue;
        capture_type type = channel->pixel_type == EXR_PIXEL_HALF ? CAPTURE_HALF : CAPTURE_FLOAT;
        if (!capture_add_plane(c, channel->name.str, type))
            return fail(r, "out of memory");
    }
    return true;
}

/* Points the channels of a chunk that starts `row` rows below the top at the planes. */
static void point_decoder(exr_decode_pipeline_t *decode, const capture *c, int row)
{
    for (int i = 0; i < decode->channel_count; i++) {
        exr_coding_channel_info_t *channel = &decode->channels[i];
        float *texels = capture_find_plane(c, channel->channel_name);
        bool whole = channel->x_samples == 1 && channel->y_samples == 1;
        channel->decode_to_ptr = texels && whole ? (uint8_t *)(texels + (size_t)row * (size_t)c->width) : NULL;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = c->width * (int)sizeof(float);
    }
}

static exr_result_t read_chunks(exr_const_context_t file, const capture *c, int top)
{
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t lines = 1;
    exr_result_t code = exr_get_scanlines_per_chunk(file, 0, &lines);
    for (int row = 0; row < c->height && code == EXR_ERR_SUCCESS; row += lines) {
        exr_chunk_info_t chunk;
        code = exr_read_scanline_chunk_info(file, 0, top + row, &chunk);
        if (code == EXR_ERR_SUCCESS)
            code = row ? exr_decoding_update(file, 0, &chunk, &decode) : exr_decoding_initialize(file, 0, &chunk, &decode);
        if (code != EXR_ERR_SUCCESS)
            break;
        point_decoder(&decode, c, row);
        if (row == 0)
            code = exr_decoding_choose_default_routines(file, 0, &decode);
        if (code == EXR_ERR_SUCCESS)
            code = exr_decoding_run(file, 0, &decode);
    }
    exr_decoding_destroy(file, &decode);
    return code;
}

static bool read_open_file(exr_const_context_t file, capture *out, report *r)
{
    exr_attr_box2i_t window;
    if (!check_kind(file, r))
        return false;
    exr_result_t code = exr_get_data_window(file, 0, &window);
    if (code != EXR_ERR_SUCCESS)
        return fail_library(r, "cannot read the size", code);
    int64_t width = (int64_t)window.max.x - window.min.x + 1, height = (int64_t)window.max.y - window.min.y + 1;
    if (width > SIZE_LIMIT || height > SIZE_LIMIT || !capture_create(out, (int)width, (int)height))
        return fail(r, "size %lldx%lld is not within 1..%d", (long long)width, (long long)height, SIZE_LIMIT);
    if (!read_attributes(file, out, r) || !add_channels(file, out, r))
        return false;
    code = read_chunks(file, out, window.min.y);
    return code == EXR_ERR_SUCCESS || fail_library(r, "corrupt or truncated", code);
}

bool capture_read(const char *path, capture *out, char *error, size_t error_size)
{
    report r = { path, error, error_size, "" };
    exr_context_initializer_t init = initializer(&r);
    exr_context_t file = NULL;
    memset(out, 0, sizeof *out);
    FILE *probe = fopen(path, "rb");
    if (!probe)
        return fail(&r, "cannot open: %s", strerror(errno));
    fclose(probe);
    exr_result_t code = exr_start_read(&file, path, &init);
    if (code != EXR_ERR_SUCCESS)
        return fail_library(&r, "not a readable OpenEXR file", code);
    bool ok = read_open_file(file, out, &r);
    exr_finish(&file);
    if (!ok)
        capture_destroy(out);
    return ok;
}

/* ---- writing ---- */

static exr_result_t write_header(exr_context_t file, const capture *c)
{
    int part = 0;
    exr_result_t code = exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part);
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr_simple(file, 0, c->width, c->height, EXR_COMPRESSION_PIZ);
    for (uint32_t i = 0; i < c->plane_count && code == EXR_ERR_SUCCESS; i++) {
        exr_pixel_type_t type = c->planes[i].type == CAPTURE_HALF ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
        code = exr_add_channel(file, 0, c->planes[i].name, type, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    }
    for (int i = 0; i < CAPTURE_ATTRIBUTE_COUNT && code == EXR_ERR_SUCCESS; i++)
        if (c->present & 1u << i)
            code = set_attribute(file, i, c);
    return code == EXR_ERR_SUCCESS ? exr_write_header(file) : code;
}

static const capture_plane *plane_named(const capture *c, const char *name)
{
    const capture_plane *plane = c->planes;
    while (strcmp(plane->name, name))
        plane++;
    return plane;
}

/* Points the encoder at the rows of a chunk; halves are converted into `halves` first, one plane after the other. */
static void point_encoder(exr_encode_pipeline_t *encode, const capture *c, int row, int lines, uint16_t *halves)
{
    size_t at = (size_t)row * (size_t)c->width, count = (size_t)lines * (size_t)c->width;
    for (int i = 0; i < encode->channel_count; i++) {
        exr_coding_channel_info_t *channel = &encode->channels[i];
        const capture_plane *plane = plane_named(c, channel->channel_name);
        bool half = plane->type == CAPTURE_HALF;
        int bytes = half ? (int)sizeof *halves : (int)sizeof *plane->texels;
        channel->encode_from_ptr = half ? (const uint8_t *)halves : (const uint8_t *)(plane->texels + at);
        channel->user_data_type = half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = (int16_t)bytes;
        channel->user_pixel_stride = bytes;
        channel->user_line_stride = c->width * bytes;
        if (half) {
            half_from_floats(halves, plane->texels + at, count);
            halves += count;
        }
    }
}

static exr_result_t write_chunks(exr_context_t file, const capture *c)
{
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t lines = 1;
    exr_result_t code = exr_get_scanlines_per_chunk(file, 0, &lines);
    uint16_t *halves = malloc((size_t)lines * (size_t)c->width * c->plane_count * sizeof *halves);
    if (!halves)
        return EXR_ERR_OUT_OF_MEMORY;
    for (int row = 0; row < c->height && code == EXR_ERR_SUCCESS; row += lines) {
        exr_chunk_info_t chunk;
        code = exr_write_scanline_chunk_info(file, 0, row, &chunk);
        if (code == EXR_ERR_SUCCESS)
            code = row ? exr_encoding_update(file, 0, &chunk, &encode) : exr_encoding_initialize(file, 0, &chunk, &encode);
        if (code != EXR_ERR_SUCCESS)
            break;
        point_encoder(&encode, c, row, chunk.height, halves);
        if (row == 0)
            code = exr_encoding_choose_default_routines(file, 0, &encode);
        if (code == EXR_ERR_SUCCESS)
            code = exr_encoding_run(file, 0, &encode);
    }
    exr_encoding_destroy(file, &encode);
    free(halves);
    return code;
}

static bool write_file(const char *path, const capture *c, report *r)
{
    exr_context_initializer_t init = initializer(r);
    exr_context_t file = NULL;
    FILE *probe = fopen(path, "wb");
    if (!probe)
        return fail(r, "cannot write: %s", strerror(errno));
    fclose(probe);
    exr_result_t code = exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (code == EXR_ERR_SUCCESS)
        code = write_header(file, c);
    if (code == EXR_ERR_SUCCESS)
        code = write_chunks(file, c);
    exr_result_t closed = file ? exr_finish(&file) : EXR_ERR_SUCCESS;
    if (code == EXR_ERR_SUCCESS)
        code = closed;
    return code == EXR_ERR_SUCCESS || fail_library(r, "cannot write", code);
}

bool capture_write(const char *path, const capture *c, char *error, size_t error_size)
{
    report r = { path, error, error_size, "" };
    char part[CAPTURE_PATH_SIZE + 8];
    if (!c->plane_count)
        return fail(&r, "a capture without planes cannot be written");
    if (snprintf(part, sizeof part, "%s.part", path) >= (int)sizeof part)
        return fail(&r, "the path is too long");
    bool ok = write_file(part, c, &r);
    if (ok && rename(part, path))
        ok = fail(&r, "cannot rename from .part: %s", strerror(errno));
    if (!ok)
        remove(part);
    return ok;
}

/* ---- folders ---- */

void capture_frame_path(char *path, size_t path_size, const char *folder, int frame)
{
    size_t length = strlen(folder);
    const char *separator = length && folder[length - 1] == '/' ? "" : "/";
    snprintf(path, path_size, "%s%sframe.%04d.exr", folder, separator, frame);
}

/* The number of a file name of the form frame.NNNN.exr, or -1. */
static int frame_number(const char *name)
{
    char expected[32];
    if (strncmp(name, "frame.", 6))
        return -1;
    long number = strtol(name + 6, NULL, 10);
    if (number < 0 || number > 99999999)
        return -1;
    snprintf(expected, sizeof expected, "frame.%04ld.exr", number);
    return strcmp(name, expected) ? -1 : (int)number;
}

bool capture_frame_range(const char *folder, int *first, int *last, char *error, size_t error_size)
{
    report r = { folder, error, error_size, "" };
    DIR *directory = opendir(folder);
    struct dirent *entry;
    int low = INT_MAX, high = -1, count = 0;
    if (!directory)
        return fail(&r, "cannot open the folder: %s", strerror(errno));
    while ((entry = readdir(directory))) {
        int number = frame_number(entry->d_name);
        if (number < 0)
            continue;
        low = number < low ? number : low;
        high = number > high ? number : high;
        count++;
    }
    closedir(directory);
    if (!count)
        return fail(&r, "holds no frame.NNNN.exr");
    if (count != high - low + 1)
        return fail(&r, "of the frames %d..%d, %d are missing", low, high, high - low + 1 - count);
    *first = low;
    *last = high;
    return true;
}
