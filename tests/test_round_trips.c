/* What packing, storing and unpacking with nrd.glsl costs, per value and format: regenerates the table of
   nrd_shaders/precision.md and compares. `test_round_trips --write` replaces the file. */
#include "common/half.h"
#include "nrd_shaders/nrd_c.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define FILE_NAME "nrd_shaders/precision.md"
#define CASES 60000
#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* ---- storage --------------------------------------------------------------------------------------------------- */

typedef enum storage { UNORM8, UNORM10, UNORM16, SNORM8, SNORM16, HALF } storage;

static const char *const storage_names[] = { "8-bit unorm", "10-bit unorm", "16-bit unorm", "8-bit snorm", "16-bit snorm", "16-bit float" };

static float store(float value, storage s)
{
    static const float codes[] = { 255, 1023, 65535, 127, 32767, 0 };
    if (s == HALF) return half_to_float(half_from_float(value));
    float low = s == SNORM8 || s == SNORM16 ? -1.0f : 0.0f;
    return rintf(fminf(fmaxf(value, low), 1) * codes[s]) / codes[s];
}

static nrd_vec4 store4(nrd_vec4 t, storage s)
{
    return nrd_make_vec4(store(t.x, s), store(t.y, s), store(t.z, s), s == UNORM10 ? rintf(t.w * 3) / 3 : store(t.w, s));
}

/* ---- inputs ---------------------------------------------------------------------------------------------------- */

static uint32_t seed;

static float uniform(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float)(seed >> 8) / 16777216.0f;
}

/* Random, or 0 or 1 in one case of 16 each. */
static float unit(void)
{
    float edge = 16 * uniform(), value = uniform();
    return edge < 1 ? 0 : edge < 2 ? 1 : value;
}

static nrd_vec3 direction(void)
{
    float z = 2 * uniform() - 1, angle = 6.2831853f * uniform(), r = sqrtf(1 - z * z);
    int axis = (int)(64 * uniform());
    if (axis < 3) return nrd_make_vec3(axis == 0, axis == 1, axis == 2 ? -1.0f : 0.0f);
    return nrd_make_vec3(r * cosf(angle), r * sinf(angle), z);
}

static nrd_vec3 unit3(void)
{
    float c[3];
    for (int i = 0; i < 3; i++) c[i] = unit();
    return nrd_make_vec3(c[0], c[1], c[2]);
}

/* Colours whose largest component is 0.01 to 1000. */
static nrd_vec3 radiance(void)
{
    float scale = powf(10, 5 * uniform() - 2);
    nrd_vec3 c = unit3();
    float largest = fmaxf(fmaxf(c.x, c.y), fmaxf(c.z, 1e-3f));
    return nrd_make_vec3(c.x / largest * scale, c.y / largest * scale, c.z / largest * scale);
}

/* ---- errors ---------------------------------------------------------------------------------------------------- */

static double degrees(nrd_vec3 a, nrd_vec3 b)
{
    double x = (double)a.y * b.z - (double)a.z * b.y, y = (double)a.z * b.x - (double)a.x * b.z, z = (double)a.x * b.y - (double)a.y * b.x;
    double cosine = (double)a.x * b.x + (double)a.y * b.y + (double)a.z * b.z;
    return 57.295779513082321 * atan2(sqrt(x * x + y * y + z * z), cosine);
}

static double colour_error(nrd_vec3 a, nrd_vec3 b)
{
    double largest = fmax(fmax(b.x, b.y), fmax(b.z, 1e-30));
    return fmax(fmax(fabs((double)a.x - b.x), fabs((double)a.y - b.y)), fabs((double)a.z - b.z)) / largest;
}

static nrd_vec3 xyz(nrd_vec4 v)
{
    return nrd_make_vec3(v.x, v.y, v.z);
}

/* ---- round trips: the error of one random case, or a negative number if the case does not count -------------------------- */

static uint32_t normal_format(storage s)
{
    static const uint32_t formats[] = { NRD_NORMAL_FORMAT_RGBA8_UNORM,  NRD_NORMAL_FORMAT_RGB10A2_UNORM, NRD_NORMAL_FORMAT_RGBA16_UNORM,
                                        NRD_NORMAL_FORMAT_RGBA8_SNORM, NRD_NORMAL_FORMAT_RGBA16_SNORM,  NRD_NORMAL_FORMAT_RGBA16_SNORM };
    return formats[s];
}

static nrd_surface surface_trip(nrd_vec3 n, float r, uint32_t id, storage s, uint32_t roughness_format)
{
    nrd_vec4 t = nrd_encode_normal_roughness(n, r, id, normal_format(s), roughness_format);
    return nrd_decode_normal_roughness(store4(t, s), normal_format(s), roughness_format);
}

static double normal_trip(storage s)
{
    nrd_vec3 n = direction();
    return degrees(surface_trip(n, unit(), 0, s, NRD_ROUGHNESS_FORMAT_LINEAR).normal, n);
}

static double roughness_trip(storage s, uint32_t format)
{
    nrd_vec3 n = direction();
    float r = unit();
    return fabs((double)surface_trip(n, r, 0, s, format).roughness - r);
}

static double linear_trip(storage s) { return roughness_trip(s, NRD_ROUGHNESS_FORMAT_LINEAR); }
static double squared_trip(storage s) { return roughness_trip(s, NRD_ROUGHNESS_FORMAT_SQ_LINEAR); }
static double root_trip(storage s) { return roughness_trip(s, NRD_ROUGHNESS_FORMAT_SQRT_LINEAR); }

static double material_trip(storage s)
{
    nrd_vec3 n = direction();
    uint32_t id = (uint32_t)(4 * uniform());
    return fabs((double)surface_trip(n, unit(), id, s, NRD_ROUGHNESS_FORMAT_LINEAR).material_id - id);
}

static double radiance_trip(storage s)
{
    nrd_vec3 rgb = radiance();
    return colour_error(xyz(nrd_unpack_radiance_hit_dist(store4(nrd_pack_radiance_hit_dist(rgb, 0, true), s))), rgb);
}

static double hit_dist_trip(storage s)
{
    nrd_vec4 params = nrd_make_vec4(3, 0.1f, 20, -25);
    float z = 100 * uniform(), r = unit(), scale = nrd_hit_dist_scale(z, r, params), h = uniform() * scale;
    float norm = nrd_pack_occlusion(nrd_normalize_hit_dist(h, z, r, params));
    return fabs((double)nrd_denormalize_hit_dist(store(norm, s), z, r, params) - h) / scale;
}

static double relax_trip(storage s)
{
    nrd_vec3 rgb = radiance();
    return colour_error(xyz(nrd_unpack_relax_radiance_hit_dist(store4(nrd_pack_relax_radiance_hit_dist(rgb, 1, true), s))), rgb);
}

static double relax_hit_dist_trip(storage s)
{
    float h = powf(10, 6 * uniform() - 2);
    float back = nrd_unpack_relax_radiance_hit_dist(store4(nrd_pack_relax_radiance_hit_dist(radiance(), h, true), s)).w;
    return fabs((double)back - fminf(h, NRD_HIT_DIST_MISS)) / fminf(h, NRD_HIT_DIST_MISS);
}

static nrd_sg sh_trip(nrd_vec3 rgb, nrd_vec3 d, storage s)
{
    nrd_vec4 sh0, sh1;
    nrd_pack_sh(rgb, 0.5f, d, true, &sh0, &sh1);
    return nrd_unpack_sh(store4(sh0, s), store4(sh1, s));
}

static double sh_colour_trip(storage s)
{
    nrd_vec3 rgb = radiance();
    nrd_vec3 d = direction();
    return colour_error(nrd_sg_color(sh_trip(rgb, d, s)), rgb);
}

static double sh_direction_trip(storage s)
{
    nrd_vec3 rgb = radiance(), d = direction();
    return nrd_luma(rgb) > 1e-3f ? degrees(nrd_sg_direction(sh_trip(rgb, d, s)), d) : -1;
}

static double openness_trip(storage s)
{
    nrd_vec3 d = direction();
    float a = unit();
    return fabs((double)nrd_unpack_directional_occlusion(store4(nrd_pack_directional_occlusion(d, a, true), s), d).w - a);
}

static double bent_trip(storage s)
{
    nrd_vec3 d = direction();
    float a = 0.1f + 0.9f * uniform();
    nrd_vec4 bent = nrd_unpack_directional_occlusion(store4(nrd_pack_directional_occlusion(d, a, true), s), d);
    return degrees(xyz(bent), d);
}

static double material_factor_trip(storage s)
{
    nrd_vec3 n = direction(), v = direction(), rgb = radiance(), albedo = unit3(), rf0 = unit3(), diffuse, specular;
    nrd_material_factors(n, v, albedo, rf0, unit(), &diffuse, &specular);
    nrd_vec3 d = nrd_demodulate(rgb, diffuse);
    return colour_error(nrd_modulate(nrd_make_vec3(store(d.x, s), store(d.y, s), store(d.z, s)), diffuse), rgb);
}

typedef struct trip {
    const char *what, *unit;
    storage stored;
    double (*error)(storage s);
} trip;

static const trip trips[] = {
    { "normal", "degrees", UNORM10, normal_trip },
    { "normal", "degrees", UNORM8, normal_trip },
    { "normal", "degrees", SNORM8, normal_trip },
    { "normal", "degrees", UNORM16, normal_trip },
    { "normal", "degrees", SNORM16, normal_trip },
    { "normal", "degrees", HALF, normal_trip },
    { "roughness, linear", "", UNORM10, linear_trip },
    { "roughness, linear", "", UNORM8, linear_trip },
    { "roughness, linear", "", HALF, linear_trip },
    { "roughness, squared", "", UNORM10, squared_trip },
    { "roughness, squared", "", UNORM8, squared_trip },
    { "roughness, square root", "", UNORM10, root_trip },
    { "roughness, square root", "", UNORM8, root_trip },
    { "material ID", "", UNORM10, material_trip },
    { "radiance", "of the largest component", HALF, radiance_trip },
    { "hit distance, normalised", "of the scale", HALF, hit_dist_trip },
    { "hit distance, normalised", "of the scale", UNORM16, hit_dist_trip },
    { "hit distance, normalised; occlusion", "of the scale", UNORM8, hit_dist_trip },
    { "RELAX radiance", "of the largest component", HALF, relax_trip },
    { "RELAX hit distance", "of itself", HALF, relax_hit_dist_trip },
    { "SH colour", "of the largest component", HALF, sh_colour_trip },
    { "SH direction", "degrees", HALF, sh_direction_trip },
    { "directional occlusion: openness", "", SNORM8, openness_trip },
    { "directional occlusion: openness", "", SNORM16, openness_trip },
    { "directional occlusion: direction, openness >= 0.1", "degrees", SNORM8, bent_trip },
    { "directional occlusion: direction, openness >= 0.1", "degrees", SNORM16, bent_trip },
    { "radiance / diffuse factor, stored, * diffuse factor", "of the largest component", HALF, material_factor_trip },
};

/* ---- table ----------------------------------------------------------------------------------------------------- */

static const char preface[] =
    "# What packing costs\n\n"
    "Errors of a value that is packed by `nrd.glsl`, stored as the texture format stores it, and unpacked; 60000 random inputs and\n"
    "edges each. `tests/test_round_trips` regenerates this table and compares; after an intended change run it with `--write`.\n\n"
    "| value | stored as | worst error | mean error | unit |\n|---|---|---|---|---|\n";

static void write_row(FILE *out, const trip *t)
{
    double worst = 0, sum = 0;
    int count = 0;
    seed = 12345;
    for (int i = 0; i < CASES; i++) {
        double error = t->error(t->stored);
        if (error < 0) continue;
        worst = fmax(worst, error);
        sum += error;
        count++;
    }
    fprintf(out, "| %s | %s | %.2g | %.1g | %s |\n", t->what, storage_names[t->stored], worst, sum / count, t->unit);
}

static bool write_table(FILE *out)
{
    fputs(preface, out);
    for (size_t i = 0; i < COUNT(trips); i++) write_row(out, &trips[i]);
    return !ferror(out);
}

static void the_table_of_round_trips_is_true(void **state)
{
    FILE *made = tmpfile(), *kept = fopen(FILE_NAME, "r");
    char expected[256], line[256];
    (void)state;
    assert_non_null(made);
    assert_non_null(kept);
    assert_true(write_table(made));
    rewind(made);
    while (fgets(expected, sizeof expected, made)) {
        if (!fgets(line, sizeof line, kept)) line[0] = 0;
        assert_string_equal(line, expected);
    }
    assert_null(fgets(line, sizeof line, kept));
    fclose(made);
    fclose(kept);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(the_table_of_round_trips_is_true) };
    if (argc == 2 && strcmp(argv[1], "--write") == 0) {
        FILE *out = fopen(FILE_NAME, "w");
        bool ok = out && write_table(out);
        if (!out || fclose(out) || !ok) {
            fprintf(stderr, "test_round_trips: cannot write " FILE_NAME "\n");
            return 1;
        }
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
