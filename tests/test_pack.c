/* Texels packed on the CPU are those of nrd.glsl, whose functions nrd_reference.h holds in double precision. */
#include "common/half.h"
#include "common/pack.h"
#include "nrd_reference.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint32_t seed;

static int reset_random(void **state)
{
    (void)state;
    seed = 12345;
    return 0;
}

/* Uniform in [0,1). */
static float uniform(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float)(seed >> 8) / 16777216.0f;
}

static void near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.9g, expected %.9g within %g", value, expected, tolerance);
}

static void random_normal(float n[3])
{
    float z = 2 * uniform() - 1, angle = 6.2831853f * uniform(), r = sqrtf(1 - z * z);
    n[0] = r * cosf(angle);
    n[1] = r * sinf(angle);
    n[2] = z;
}

static void guides_are_the_reference_rounded_to_ten_bits(void **state)
{
    (void)state;
    for (int i = 0; i < 20000; i++) {
        float n[3], roughness = i % 10 ? uniform() : (float)(i / 10 % 2);
        double texel[4], normal[3] = { 0 };
        random_normal(n);
        for (int k = 0; k < 3; k++)
            normal[k] = n[k];
        uint32_t id = (uint32_t)(i % 5), packed = pack_normal_roughness(n, roughness, id);
        ref_encode_normal_roughness(normal, roughness, id, REF_RGB10A2_UNORM, REF_LINEAR, texel);
        for (int k = 0; k < 3; k++)
            near((packed >> 10 * k & 1023) / 1023.0, texel[k], 0.5005 / 1023);
        assert_int_equal(packed >> 30, id < 3 ? id : 3);
    }
}

static void guides_that_are_not_finite_give_the_documented_texel(void **state)
{
    const float bad[3] = { NAN, 0, 1 }, up[3] = { 0, 1, 0 };
    (void)state;
    uint32_t packed = pack_normal_roughness(bad, INFINITY, 0);
    assert_int_equal(packed & 1023, 512);
    assert_int_equal(packed >> 10 & 1023, 512);
    assert_int_equal(packed >> 20 & 1023, 1023);
    assert_int_equal(pack_normal_roughness(up, 7, 0), pack_normal_roughness(up, 1, 0));
}

static void hit_distances_are_normalised_as_documented(void **state)
{
    const float parameters[4] = { 3, 0.1f, 20, -25 };
    const double exact[4] = { 3, 0.1f, 20, -25 };
    (void)state;
    assert_true(pack_normalize_hit_dist(0, 10, 1, parameters) == 0);
    assert_true(pack_normalize_hit_dist(-2, 10, 1, parameters) == 0);
    assert_true(pack_normalize_hit_dist(NAN, 10, 1, parameters) == 0);
    assert_true(pack_normalize_hit_dist(65504, 1e6f, 0, parameters) == 1);
    near(pack_normalize_hit_dist(2, 10, 1, parameters), 0.5, 1e-6);
    near(pack_normalize_hit_dist(2, -10, 1, parameters), 0.5, 1e-6);
    near(pack_normalize_hit_dist(80, 10, 0, parameters), 1, 0);
    near(pack_normalize_hit_dist(40, 10, 0, parameters), 0.5, 1e-6);
    for (int i = 0; i < 1000; i++) {
        float hit = 10 * uniform(), z = 100 * uniform(), roughness = uniform();
        near(pack_normalize_hit_dist(hit, z, roughness, parameters), ref_normalize_hit_dist(hit, z, roughness, exact), 1e-5);
    }
}

static void penumbrae_are_packed_as_documented(void **state)
{
    const float red[3] = { 1, 0.2f, -3 }, bad[3] = { 1, NAN, 1 };
    uint8_t texel[4];
    (void)state;
    near(half_to_float(pack_penumbra(10, 0.00465f)), 0.0465, 0.0465 / 2048);
    near(half_to_float(pack_local_penumbra(1, 5, 0.2f)), 0.05, 0.05 / 2048);
    assert_true(half_to_float(pack_local_penumbra(6, 5, 0.2f)) == 32768);
    assert_true(half_to_float(pack_penumbra(60000, 10)) == 32768);
    const float faces_away[] = { 0, -1, NAN }, reached[] = { 65504, 1e9f, INFINITY };
    for (int i = 0; i < 3; i++) {
        assert_int_equal(pack_penumbra(faces_away[i], 0.5f), 0);
        assert_int_equal(pack_local_penumbra(faces_away[i], 5, 0.5f), 0);
        assert_true(half_to_float(pack_penumbra(reached[i], 0.5f)) == HALF_MAX && half_to_float(pack_local_penumbra(reached[i], 5, 0.5f)) == HALF_MAX);
    }
    assert_true(pack_penumbra(1e-9f, 0) > 0);   /* blocked, however near */
    assert_true(pack_unpack_shadow(255) == 1 && pack_unpack_shadow(0) == 0);
    pack_translucency(3, red, texel);
    assert_true(texel[0] == 255 && texel[1] == 51 && texel[2] == 0 && texel[3] == 0);
    pack_translucency(65504, red, texel);
    assert_true(texel[0] == 255 && texel[1] == 255 && texel[2] == 255 && texel[3] == 255);
    pack_translucency(3, bad, texel);
    assert_true(texel[0] == 0 && texel[1] == 0 && texel[2] == 0);
    pack_translucency(0, red, texel);
    assert_true(texel[0] == 0 && texel[3] == 0);
}

static void radiance_survives_the_texel(void **state)
{
    (void)state;
    for (int i = 0; i < 20000; i++) {
        float scale = powf(10, 6 * uniform() - 3), rgb[3] = { scale * uniform(), scale * uniform(), scale * uniform() }, back[4];
        double exact[4], colour[3] = { rgb[0], rgb[1], rgb[2] };
        uint16_t texel[4];
        pack_radiance_hit_dist(rgb, 0.3f, texel);
        ref_pack_radiance_hit_dist(colour, 0.3f, true, exact);
        for (int k = 0; k < 4; k++)
            near(half_to_float(texel[k]), exact[k], fabs(exact[k]) / 2048 * 1.01 + 1e-7);
        pack_unpack_radiance_hit_dist(texel, back);
        for (int k = 0; k < 3; k++)
            near(back[k], rgb[k], 0.002 * scale);
        near(back[3], 0.3, 0.0002);
    }
}

static void radiance_that_is_not_finite_is_black(void **state)
{
    const float nan[3] = { 1, NAN, 1 }, inf[3] = { INFINITY, 1, 1 }, negative[3] = { -1, -2, -3 }, bright[3] = { 1e9f, 1e9f, 1e9f };
    uint16_t texel[4];
    float back[4];
    (void)state;
    const float *const black[] = { nan, inf, negative };
    for (int i = 0; i < 3; i++) {
        pack_radiance_hit_dist(black[i], NAN, texel);
        for (int k = 0; k < 4; k++)
            assert_int_equal(texel[k] & 0x7fff, 0);
    }
    pack_radiance_hit_dist(bright, 7, texel);
    pack_unpack_radiance_hit_dist(texel, back);
    assert_true(back[0] == HALF_MAX && back[1] == HALF_MAX && back[2] == HALF_MAX && back[3] == 1);
    for (int k = 0; k < 3; k++) /* chroma beyond luma, as sharpening makes it */
        texel[k] = half_from_float(k == 1 ? 2.0f : 1.0f);
    pack_unpack_radiance_hit_dist(texel, back);
    assert_true(back[0] == 2 && back[1] == 2 && back[2] == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(guides_are_the_reference_rounded_to_ten_bits, reset_random),
        cmocka_unit_test(guides_that_are_not_finite_give_the_documented_texel),
        cmocka_unit_test_setup(hit_distances_are_normalised_as_documented, reset_random),
        cmocka_unit_test_setup(radiance_survives_the_texel, reset_random),
        cmocka_unit_test(penumbrae_are_packed_as_documented),
        cmocka_unit_test(radiance_that_is_not_finite_is_black),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
