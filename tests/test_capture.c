/* Captures: what is written is read back, what is damaged is refused with a line that names file and cause. */
#define _XOPEN_SOURCE 700
#include "common/capture.h"
#include "common/half.h"
#include "common/scratch.h"

#include <OpenEXR/openexr.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#define WIDTH 37
#define HEIGHT 45 /* more than one PIZ chunk of 32 rows, the last one short */

static char folder[SCRATCH_SIZE];
static char error[512];

static const char *in_folder(const char *name)
{
    static char paths[4][256];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static int make_folder(void **state)
{
    (void)state;
    return scratch_make(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    return scratch_remove(folder) ? 0 : -1;
}

static void make_sample(capture *c)
{
    assert_true(capture_create(c, WIDTH, HEIGHT));
    float *z = capture_add_plane(c, "viewZ", CAPTURE_FLOAT), *red = capture_add_plane(c, "diffuse.R", CAPTURE_HALF);
    float *hit = capture_add_plane(c, "diffuse.hitT", CAPTURE_HALF);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        z[i] = 1.0f + (float)i / 7.0f;
        red[i] = (float)((i * 37) % 1024) / 64.0f;
        hit[i] = i % 3 ? 65504.0f : 0.25f;
    }
    for (int i = 0; i < 16; i++) {
        c->world_to_camera[i] = (float)i;
        c->camera_to_clip[i] = (float)-i;
    }
    c->jitter[0] = 0.25f;
    c->jitter[1] = -0.5f;
    c->frame_index = 12;
    c->time_delta_s = 0.0125f;
    c->denoising_range = 1000.0f;
    c->sun_direction[1] = 1.0f;
    c->sun_tan_angular_radius = 0.005f;
    c->metres_per_unit = 0.01f;
    c->cut = 1;
    c->present = (1u << CAPTURE_ATTRIBUTE_COUNT) - 1;
}

static void what_is_written_is_read_back(void **state)
{
    capture a, b;
    (void)state;
    make_sample(&a);
    assert_true(capture_write(in_folder("frame.0000.exr"), &a, error, sizeof error));
    assert_true(capture_read(in_folder("frame.0000.exr"), &b, error, sizeof error));
    assert_int_equal(b.width, WIDTH);
    assert_int_equal(b.height, HEIGHT);
    assert_int_equal(b.plane_count, a.plane_count);
    for (uint32_t i = 0; i < a.plane_count; i++) {
        float *texels = capture_find_plane(&b, a.planes[i].name);
        assert_non_null(texels);
        assert_memory_equal(texels, a.planes[i].texels, WIDTH * HEIGHT * sizeof(float));
    }
    assert_int_equal(b.present, a.present);
    size_t from = offsetof(capture, world_to_camera), to = offsetof(capture, cut) + sizeof a.cut;
    assert_memory_equal((char *)&a + from, (char *)&b + from, to - from);
    assert_int_not_equal(access(in_folder("frame.0000.exr.part"), F_OK), 0);
    capture_destroy(&a);
    capture_destroy(&b);
}

static void absent_attributes_have_documented_values_and_are_named(void **state)
{
    capture a, b;
    const char *planes[] = { "viewZ", "normal.X" };
    (void)state;
    make_sample(&a);
    a.present = CAPTURE_HAS_CAMERA;
    assert_true(capture_write(in_folder("bare.exr"), &a, error, sizeof error));
    assert_true(capture_read(in_folder("bare.exr"), &b, error, sizeof error));
    assert_int_equal(b.present, CAPTURE_HAS_CAMERA);
    assert_true(isinf(b.denoising_range));
    assert_true(b.metres_per_unit == 1.0f && b.cut == 0 && b.jitter[0] == 0.0f);
    assert_true(capture_require(&b, "F", CAPTURE_HAS_CAMERA, planes, 1, error, sizeof error));
    assert_false(capture_require(&b, "F", CAPTURE_HAS_DENOISING_RANGE, planes, 1, error, sizeof error));
    assert_string_equal(error, "F: attribute denoisingRange is missing");
    assert_false(capture_require(&b, "F", 0, planes, 2, error, sizeof error));
    assert_string_equal(error, "F: channel normal.X is missing");
    capture_destroy(&a);
    capture_destroy(&b);
}

static void every_half_survives_and_floats_round_to_the_nearest(void **state)
{
    (void)state;
    for (uint32_t h = 0; h < 65536; h++) {
        float f = half_to_float((uint16_t)h);
        if ((h & 0x7fff) > 0x7c00)
            assert_true(isnan(f) && isnan(half_to_float(half_from_float(f))));
        else
            assert_int_equal(half_from_float(f), h);
    }
    /* between two neighbours: below the middle, the middle (to even), above it */
    for (uint32_t h = 0; h < 0x7bff; h++) {
        float low = half_to_float((uint16_t)h), high = half_to_float((uint16_t)(h + 1)), middle = 0.5f * (low + high);
        assert_int_equal(half_from_float(nextafterf(middle, 0)), h);
        assert_int_equal(half_from_float(middle), h + (h & 1));
        assert_int_equal(half_from_float(-nextafterf(middle, INFINITY)), 0x8000 | (h + 1));
    }
    assert_int_equal(half_from_float(1e9f), 0x7bff);
    assert_int_equal(half_from_float(-65521.0f), 0xfbff);
    assert_int_equal(half_from_float(INFINITY), 0x7c00);
    assert_int_equal(half_from_float(1e-30f), 0);
}

/* A file by other hands: an offset window, unknown attributes, a uint and a sub-sampled channel, given compression. */
static void write_foreign(const char *path, exr_compression_t compression)
{
    exr_context_t file;
    int part;
    exr_attr_box2i_t window;
    exr_attr_v2f_t centre;
    memset(&centre, 0, sizeof centre);
    window.min.x = -6;
    window.min.y = 8;
    window.max.x = window.min.x + 15;
    window.max.y = window.min.y + 39;
    static const char *const names[] = { "a", "b", "extra", "n" };
    static const exr_pixel_type_t types[] = { EXR_PIXEL_HALF, EXR_PIXEL_FLOAT, EXR_PIXEL_HALF, EXR_PIXEL_UINT };
    assert_int_equal(exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, NULL), 0);
    assert_int_equal(exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part), 0);
    assert_int_equal(exr_initialize_required_attr(file, 0, &window, &window, 1, &centre, 1,
                                                  EXR_LINEORDER_INCREASING_Y, compression), 0);
    for (int i = 0; i < 4; i++) {
        int sampling = i == 2 ? 2 : 1;
        assert_int_equal(exr_add_channel(file, 0, names[i], types[i], EXR_PERCEPTUALLY_LINEAR, sampling, sampling), 0);
    }
    assert_int_equal(exr_attr_set_string(file, 0, "somebodysAttribute", "text"), 0);
    assert_int_equal(exr_write_header(file), 0);
    float rows[40][16];
    uint32_t numbers[40][16];
    for (int y = 0; y < 40; y++)
        for (int x = 0; x < 16; x++) {
            rows[y][x] = (float)(y * 16 + x);
            numbers[y][x] = (uint32_t)(y * 16 + x);
        }
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t lines;
    exr_get_scanlines_per_chunk(file, 0, &lines);
    for (int y = 0; y < 40; y += lines) {
        exr_chunk_info_t chunk;
        assert_int_equal(exr_write_scanline_chunk_info(file, 0, 8 + y, &chunk), 0);
        exr_result_t ready = y ? exr_encoding_update(file, 0, &chunk, &encode) : exr_encoding_initialize(file, 0, &chunk, &encode);
        assert_int_equal(ready, 0);
        for (int k = 0; k < 4; k++) {
            exr_coding_channel_info_t *channel = &encode.channels[k];
            channel->encode_from_ptr = k == 3 ? (const uint8_t *)numbers[y] : (const uint8_t *)rows[y];
            channel->user_data_type = k == 3 ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
            channel->user_bytes_per_element = 4;
            channel->user_pixel_stride = 4;
            channel->user_line_stride = 64;
        }
        if (y == 0)
            assert_int_equal(exr_encoding_choose_default_routines(file, 0, &encode), 0);
        assert_int_equal(exr_encoding_run(file, 0, &encode), 0);
    }
    exr_encoding_destroy(file, &encode);
    assert_int_equal(exr_finish(&file), 0);
}

static void files_of_other_programs_are_read(void **state)
{
    static const exr_compression_t compressions[] = { EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE, EXR_COMPRESSION_ZIPS,
        EXR_COMPRESSION_ZIP, EXR_COMPRESSION_PIZ };
    (void)state;
    for (size_t i = 0; i < sizeof compressions / sizeof *compressions; i++) {
        capture c;
        const char *path = in_folder("foreign.exr");
        write_foreign(path, compressions[i]);
        assert_true(capture_read(path, &c, error, sizeof error));
        assert_true(c.width == 16 && c.height == 40 && c.present == 0);
        assert_null(capture_find_plane(&c, "extra"));
        float *a = capture_find_plane(&c, "a"), *b = capture_find_plane(&c, "b"), *n = capture_find_plane(&c, "n");
        assert_true(a && b && n);
        for (int k = 0; k < 640; k++)
            assert_true(a[k] == (float)k && b[k] == (float)k && n[k] == (float)k);
        capture_destroy(&c);
    }
}

static long file_size(const char *path)
{
    struct stat info;
    return stat(path, &info) ? -1 : (long)info.st_size;
}

static unsigned char *load(const char *path, size_t size)
{
    unsigned char *bytes = malloc(size);
    FILE *file = fopen(path, "rb");
    assert_true(bytes && file && fread(bytes, 1, size, file) == size);
    fclose(file);
    return bytes;
}

static void store(const char *path, const unsigned char *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_true(file && fwrite(bytes, 1, size, file) == size);
    assert_int_equal(fclose(file), 0);
}

static void expect_refused(const char *path)
{
    capture c;
    assert_false(capture_read(path, &c, error, sizeof error));
    assert_int_equal(strncmp(error, path, strlen(path)), 0);
    assert_true(strlen(error) > strlen(path) + 2);
    assert_null(strchr(error, '\n'));
    assert_true(c.plane_count == 0 && c.planes == NULL);
}

static void a_truncated_file_is_refused_at_every_length(void **state)
{
    capture a;
    (void)state;
    make_sample(&a);
    assert_true(capture_write(in_folder("whole.exr"), &a, error, sizeof error));
    size_t size = (size_t)file_size(in_folder("whole.exr"));
    unsigned char *bytes = load(in_folder("whole.exr"), size);
    for (size_t length = 0; length < size; length += 1 + size / 200) {
        store(in_folder("short.exr"), bytes, length);
        expect_refused(in_folder("short.exr"));
    }
    free(bytes);
    capture_destroy(&a);
}

/* Damage may go unseen in the pixels (the format has no checksum), but it never crashes. */
static void damaged_bytes_are_refused_or_harmless(void **state)
{
    capture a, c;
    int refused = 0;
    (void)state;
    make_sample(&a);
    assert_true(capture_write(in_folder("whole.exr"), &a, error, sizeof error));
    size_t size = (size_t)file_size(in_folder("whole.exr"));
    unsigned char *bytes = load(in_folder("whole.exr"), size);
    for (size_t i = 0; i < size; i += 1 + i / 400) {
        bytes[i] ^= 0xff;
        store(in_folder("damaged.exr"), bytes, size);
        if (capture_read(in_folder("damaged.exr"), &c, error, sizeof error))
            capture_destroy(&c);
        else
            refused++;
        bytes[i] ^= 0xff;
    }
    assert_true(refused > 100);
    free(bytes);
    capture_destroy(&a);
}

static void what_is_no_capture_is_named(void **state)
{
    (void)state;
    expect_refused(in_folder("absent.exr"));
    assert_non_null(strstr(error, "No such file"));
    store(in_folder("text.exr"), (const unsigned char *)"not a picture, only text", 24);
    expect_refused(in_folder("text.exr"));
    expect_refused(folder);
}

static void a_failed_write_leaves_nothing(void **state)
{
    capture a;
    (void)state;
    make_sample(&a);
    assert_false(capture_write(in_folder("nowhere/frame.0000.exr"), &a, error, sizeof error));
    assert_non_null(strstr(error, "nowhere/frame.0000.exr"));

    assert_true(capture_write(in_folder("kept.exr"), &a, error, sizeof error));
    long before = file_size(in_folder("kept.exr"));
    struct rlimit old, limit;
    getrlimit(RLIMIT_FSIZE, &old);
    limit = old;
    limit.rlim_cur = 4096;
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
    bool written = capture_write(in_folder("kept.exr"), &a, error, sizeof error);
    bool fresh = capture_write(in_folder("fresh.exr"), &a, error, sizeof error);
    setrlimit(RLIMIT_FSIZE, &old);
    assert_false(written);
    assert_false(fresh);
    assert_int_equal(file_size(in_folder("kept.exr")), before);
    assert_int_equal(file_size(in_folder("kept.exr.part")), -1);
    assert_int_equal(file_size(in_folder("fresh.exr")), -1);
    assert_int_equal(file_size(in_folder("fresh.exr.part")), -1);
    capture_destroy(&a);
}

static void the_range_of_frames_is_found_and_gaps_are_named(void **state)
{
    int first, last;
    char path[256];
    (void)state;
    assert_false(capture_frame_range(in_folder("absent"), &first, &last, error, sizeof error));
    assert_non_null(strstr(error, "cannot open"));
    assert_int_equal(mkdir(in_folder("shot"), 0777), 0);
    assert_false(capture_frame_range(in_folder("shot"), &first, &last, error, sizeof error));
    assert_non_null(strstr(error, "holds no frame"));
    for (int i = 8; i < 12; i++) {
        capture_frame_path(path, sizeof path, in_folder("shot"), i);
        store(path, (const unsigned char *)"", 0);
    }
    store(in_folder("shot/frame.2.exr"), (const unsigned char *)"", 0);
    store(in_folder("shot/frame.0003.exr.part"), (const unsigned char *)"", 0);
    assert_true(capture_frame_range(in_folder("shot"), &first, &last, error, sizeof error));
    assert_true(first == 8 && last == 11);
    assert_int_equal(remove(in_folder("shot/frame.0010.exr")), 0);
    assert_false(capture_frame_range(in_folder("shot"), &first, &last, error, sizeof error));
    assert_non_null(strstr(error, "of the frames 8..11, 1 are missing"));
}

static void planes_are_added_once_and_found_by_prefix(void **state)
{
    capture c;
    float *planes[3] = { NULL, NULL, NULL };
    char longest[CAPTURE_NAME_SIZE + 1];
    (void)state;
    assert_false(capture_create(&c, 0, 5));
    assert_false(capture_create(&c, 5, 32769));
    assert_true(capture_create(&c, 4, 4));
    float *red = capture_add_plane(&c, "s.R", CAPTURE_HALF);
    assert_ptr_equal(capture_add_plane(&c, "s.R", CAPTURE_FLOAT), red);
    capture_add_plane(&c, "s.G", CAPTURE_HALF);
    assert_false(capture_find_planes(&c, "s", "RGB", planes));
    assert_null(planes[0]);
    capture_add_plane(&c, "s.B", CAPTURE_HALF);
    assert_true(capture_find_planes(&c, "s", "RGB", planes));
    assert_ptr_equal(planes[0], red);
    memset(longest, 'x', CAPTURE_NAME_SIZE);
    longest[CAPTURE_NAME_SIZE] = 0;
    assert_null(capture_add_plane(&c, longest, CAPTURE_HALF));
    assert_null(capture_add_plane(&c, "", CAPTURE_HALF));
    assert_false(capture_write(in_folder("empty.exr"), &(capture){ .width = 2, .height = 2 }, error, sizeof error));
    capture_destroy(&c);
    capture_destroy(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_read_back),
        cmocka_unit_test(absent_attributes_have_documented_values_and_are_named),
        cmocka_unit_test(every_half_survives_and_floats_round_to_the_nearest),
        cmocka_unit_test(files_of_other_programs_are_read),
        cmocka_unit_test(a_truncated_file_is_refused_at_every_length),
        cmocka_unit_test(damaged_bytes_are_refused_or_harmless),
        cmocka_unit_test(what_is_no_capture_is_named),
        cmocka_unit_test(a_failed_write_leaves_nothing),
        cmocka_unit_test(the_range_of_frames_is_found_and_gaps_are_named),
        cmocka_unit_test(planes_are_added_once_and_found_by_prefix),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
