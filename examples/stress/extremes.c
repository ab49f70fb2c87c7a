/* Extremes of input, one at a time, everything else as usual. */
#include "stress/stress.h"

#include <stdio.h>
#include <stdlib.h>

enum { IMAGE_WIDTH = 24, IMAGE_HEIGHT = 16, FRAMES = 8, LONG_FRAMES = 24 };
enum { DENOISES = 1, NO_ANTILAG = 2, LONG = 4 };

/* ---- before the first frame */
static void set_depth(rig *r, double v) { r->depth = v; r->frame.denoising_range = (float)fmax(4 * v, 1e-3); }
static void set_depth_in_default_range(rig *r, double v) { r->depth = v; r->frame.denoising_range = 500000; }
static void set_range_over_depth(rig *r, double v) { r->frame.denoising_range = (float)(r->depth * v); }
static void set_roughness(rig *r, double v) { r->roughness = v; }
static void set_tilt(rig *r, double v) { r->tilt = v; r->camera.tan_half_height = 0.01; }
static void set_tilt_in_view(rig *r, double v) { r->tilt = v; }
static void set_field_of_view(rig *r, double degrees) { r->camera.tan_half_height = tan(degrees * 0.5 * 0.017453292519943295); }
static void set_near(rig *r, double v) { r->camera.near = v; r->camera.far = 0; }
static void set_reversed(rig *r, double near) { r->camera.near = near; r->camera.far = 1e6; r->camera.reversed = true; }
static void set_left_behind(rig *r, double v) { (void)v; r->camera.right_handed = true; }
static void set_depth_left_behind(rig *r, double v) { set_depth(r, v); r->camera.right_handed = true; }
static void set_orthographic(rig *r, double height) { r->camera.orthographic = true; r->camera.tan_half_height = height; r->camera.far = 1000; }
static void set_position(rig *r, double v) { r->camera.position[0] = v; r->camera.position[2] = -v; }
static void set_position_and_walk(rig *r, double v) { set_position(r, v); r->variant = 1; }
static void set_frame_index(rig *r, double v) { r->index = (uint32_t)(4294967296.0 - v); }
static void set_rectangle(rig *r, double v) { r->rect_width = r->rect_height = (uint32_t)v; r->origin_x = 3; r->origin_y = 5; }
static void set_anti_firefly(rig *r, double v) { rig_set(r, "anti_firefly_scale", v); rig_set(r, "antilag_sensitivity", 0); }
static void set_view_z_scale(rig *r, double v) { r->frame.view_z_scale = (float)v; }

/* World units per metre: a scene of the same look with all its lengths in other units. */
static void set_units(rig *r, double v)
{
    nrd_setting row;
    r->depth *= v;
    r->frame.denoising_range *= (float)v;
    r->camera.near *= v;
    r->camera.far *= v;
    for (uint32_t i = 0; nrd_get_setting(r->denoiser, i, &row); i++)
        if (!strcmp(row.unit, "units")) setting_put(&row, &r->settings, fmin(row.value * v, row.max));
}

/* ---- every frame, on what has been put */
typedef void change(rig *r, uint32_t frame, double v);

static void move_by(rig *r, uint32_t frame, double v)
{
    (void)frame;
    FOR_PIXELS(r) rig_texel(r, NRD_RESOURCE_IN_MV, x, y)[0] += (float)v, rig_texel(r, NRD_RESOURCE_IN_MV, x, y)[1] -= (float)v;
}

static void move_at_random(rig *r, uint32_t frame, double v)
{
    FOR_PIXELS(r) for (uint32_t k = 0; k < 3; k++) rig_texel(r, NRD_RESOURCE_IN_MV, x, y)[k] = (float)(v * (2 * random_at(x + 31 * k, y, frame) - 1));
}

static bool sky_at(uint32_t pattern, uint32_t x, uint32_t y, uint32_t frame)
{
    switch (pattern) {
    case 0: return true;
    case 1: return ((x ^ y ^ frame) & 1) != 0;
    case 2: return x != 9 || y != 7;
    case 3: return x < 12;
    default: return ((x / 8 + y / 8) & 1) != 0;
    }
}

/* What the sky holds must not matter. */
static void put_sky(rig *r, uint32_t frame, double v)
{
    FOR_PIXELS(r) {
        if (!sky_at((uint32_t)v, x, y, frame)) continue;
        *rig_texel(r, NRD_RESOURCE_IN_VIEWZ, x, y) = frame & 1 ? INFINITY : NAN;
        for (int k = 0; k < 3; k++) rig_texel(r, NRD_RESOURCE_IN_MV, x, y)[k] = NAN;
        for (uint32_t s = 0; s < r->signal_count; s++)
            for (int k = 0; k < 4; k++) rig_texel(r, r->signals[s].in, x, y)[k] = NAN;
    }
}

/* Bad samples, in more places every frame. v: 0 NaN, 1 infinity, 2 minus infinity, 3 the largest float, 4 its negative. */
static void put_bad(rig *r, uint32_t frame, double v)
{
    const float bad[] = { NAN, INFINITY, -INFINITY, 3.4e38f, -3.4e38f };
    for (uint32_t s = 0; s < r->signal_count; s++)
        FOR_PIXELS(r) {
            uint32_t channel = (x + y + frame) % 5;
            if (random_at(x, y, frame + s) < 0.3 && channel < 4) rig_texel(r, r->signals[s].in, x, y)[channel] = bad[(int)v];
        }
}

static void put_bad_everywhere(rig *r, uint32_t frame, double v)
{
    const float bad[] = { NAN, INFINITY, -INFINITY, 3.4e38f, -3.4e38f };
    (void)frame;
    for (uint32_t s = 0; s < r->signal_count; s++)
        FOR_PIXELS(r) for (int k = 0; k < 4; k++) rig_texel(r, r->signals[s].in, x, y)[k] = bad[(int)v];
}

static void put_bad_outside(rig *r, uint32_t frame, double v)
{
    (void)v;
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        if (!r->texels[i] || strncmp(nrd_resource_name((nrd_resource)i), "IN_", 3) != 0) continue;
        bool guide = rig_texel(r, (nrd_resource)i, 0, 0) != r->texels[i];
        for (uint32_t y = 0; y < r->height; y++)
            for (uint32_t x = 0; x < r->width; x++) {
                uint32_t left = x - (guide ? r->origin_x : 0), top = y - (guide ? r->origin_y : 0);
                if (left < r->rect_width && top < r->rect_height) continue;
                for (int k = 0; k < 4; k++) r->texels[i][4 * ((size_t)y * r->width + x) + (size_t)k] = (frame + x) & 1 ? NAN : INFINITY;
            }
    }
}

static void put_hit_dist(rig *r, uint32_t frame, double v)
{
    (void)frame;
    for (uint32_t s = 0; s < r->signal_count; s++) {
        signal_kind kind = r->signals[s].kind;
        if (kind != KIND_RADIANCE && kind != KIND_HIT_DIST && kind != KIND_DIRECTION) continue;
        FOR_PIXELS(r) rig_texel(r, r->signals[s].in, x, y)[kind == KIND_HIT_DIST ? 0 : 3] = (float)v;
    }
}

/* Light of one primary: what rounding adds to its chroma is no colour any more. v: 0 red, 1 green, 2 blue. */
static void put_primary(rig *r, uint32_t frame, double v)
{
    static const float per_luma[3][2] = { { 2, -1 }, { 0, 1 }, { -2, -1 } };
    (void)frame;
    for (uint32_t s = 0; s < r->signal_count; s++)
        FOR_PIXELS(r) {
            float *t = rig_texel(r, r->signals[s].in, x, y);
            if (r->signals[s].kind == KIND_RADIANCE) t[1] = per_luma[(int)v][0] * t[0], t[2] = per_luma[(int)v][1] * t[0];
        }
}

static void put_penumbra(rig *r, uint32_t frame, double v)
{
    (void)frame;
    FOR_PIXELS(r) *rig_texel(r, NRD_RESOURCE_IN_PENUMBRA, x, y) = (float)v;
}

static void turn_normals(rig *r, uint32_t frame, double degrees)
{
    double angle = degrees * 0.017453292519943295;
    (void)frame;
    FOR_PIXELS(r) {
        float *n = rig_texel(r, NRD_RESOURCE_IN_NORMAL_ROUGHNESS, x, y);
        n[0] = (float)sin(angle), n[1] = 0, n[2] = (float)-cos(angle);
    }
}

static void make_raw_normals(rig *r)
{
    if (!r->raw_normals) r->raw_normals = (uint32_t *)calloc((size_t)r->width * r->height, sizeof *r->raw_normals);
    if (!r->raw_normals) stress_die("out of memory");
}

/* Any bits: what 10-bit storage can hold, not only what packing gives. */
static void put_raw_normals(rig *r, uint32_t frame, double v)
{
    make_raw_normals(r);
    for (uint32_t i = 0; i < r->width * r->height; i++) r->raw_normals[i] = v > 0 ? (uint32_t)(random_at(i, frame, 5) * 4294967296.0) : 0;
}

static uint32_t byte_of(double v) { return (uint32_t)((0.5 * v + 0.5) * 255 + 0.5); }

/* Steps of 8 bits, with which no normal has unit length; roughness 2/3. */
static void put_8_bit_normals(rig *r, uint32_t frame, double v)
{
    (void)frame;
    (void)v;
    make_raw_normals(r);
    for (uint32_t i = 0; i < r->width * r->height; i++) {
        const float *n = &r->texels[NRD_RESOURCE_IN_NORMAL_ROUGHNESS][4 * i];
        r->raw_normals[i] = 2u << 30;
        for (int k = 0; k < 3; k++) r->raw_normals[i] |= (byte_of(n[k]) * 1023 + 127) / 255 << (10 * k);
    }
}

static void put_depth_noise(rig *r, uint32_t frame, double v)
{
    FOR_PIXELS(r) *rig_texel(r, NRD_RESOURCE_IN_VIEWZ, x, y) = (float)(r->depth * exp(v * (random_at(x, y, frame) - 0.5)));
}

/* One axis of the world position in single precision steps, as engines have it: 1 unit at 1e7. */
static void walk(rig *r, uint32_t frame, double v)
{
    (void)frame;
    r->camera.position[0] = v + (r->index & 1);
}

typedef struct extreme {
    const char *name;
    noise_kind noise;
    double level;
    void (*set)(rig *r, double v);
    change *change;
    double v;
    uint32_t flags;
    uint32_t features;
} extreme;

static const extreme extremes[] = {
    /* radiance */
    { "radiance 0", NOISE_CONSTANT, 0, NULL, NULL, 0, 0, 0 },
    { "radiance 1e-12", NOISE_UNIFORM, 1e-12, NULL, NULL, 0, 0, 0 },
    { "radiance 1e-7", NOISE_UNIFORM, 1e-7, NULL, NULL, 0, 0, 0 },
    { "radiance 1e-3", NOISE_UNIFORM, 1e-3, NULL, NULL, 0, 0, 0 },
    { "radiance 1", NOISE_UNIFORM, 1, NULL, NULL, 0, DENOISES, 0 },
    { "radiance 1, sparse", NOISE_SPARSE, 1, NULL, NULL, 0, 0, 0 },
    { "radiance 1e4", NOISE_UNIFORM, 1e4, NULL, NULL, 0, 0, 0 },
    { "radiance 65504", NOISE_CONSTANT, 65504, NULL, NULL, 0, 0, 0 },
    { "radiance up to 131008", NOISE_UNIFORM, 65504, NULL, NULL, 0, 0, 0 },
    { "radiance 1e12", NOISE_SPARSE, 1e12, NULL, NULL, 0, 0, 0 },
    { "radiance 1e38", NOISE_UNIFORM, 1e38, NULL, NULL, 0, 0, 0 },
    { "radiance negative", NOISE_UNIFORM, -1, NULL, NULL, 0, 0, 0 },
    { "firefly 1e6 times the mean", NOISE_FIREFLY, 1e-2, NULL, NULL, 0, 0, 0 },
    { "firefly without antilag", NOISE_FIREFLY, 1e-2, NULL, NULL, 0, NO_ANTILAG, 0 },
    { "steps of 1e8 between neighbours", NOISE_STEP, 1, NULL, NULL, 0, 0, 0 },
    { "steps without antilag", NOISE_STEP, 1, NULL, NULL, 0, NO_ANTILAG, 0 },
    { "red of 1", NOISE_UNIFORM, 1, NULL, put_primary, 0, DENOISES, 0 },
    { "red of 1e-6", NOISE_UNIFORM, 1e-6, NULL, put_primary, 0, LONG, 0 },
    { "green of 1e-6", NOISE_UNIFORM, 1e-6, NULL, put_primary, 1, LONG, 0 },
    { "blue of 1e-6", NOISE_UNIFORM, 1e-6, NULL, put_primary, 2, LONG, 0 },
    { "NaN in places", NOISE_UNIFORM, 1, NULL, put_bad, 0, 0, 0 },
    { "+Inf in places", NOISE_UNIFORM, 1, NULL, put_bad, 1, 0, 0 },
    { "-Inf in places", NOISE_UNIFORM, 1, NULL, put_bad, 2, 0, 0 },
    { "3.4e38 in places", NOISE_UNIFORM, 1, NULL, put_bad, 3, 0, 0 },
    { "-3.4e38 in places", NOISE_UNIFORM, 1, NULL, put_bad, 4, 0, 0 },
    { "NaN everywhere", NOISE_UNIFORM, 1, NULL, put_bad_everywhere, 0, 0, 0 },
    { "3.4e38 everywhere", NOISE_UNIFORM, 1, NULL, put_bad_everywhere, 3, 0, 0 },
    { "-3.4e38 everywhere", NOISE_UNIFORM, 1, NULL, put_bad_everywhere, 4, 0, 0 },
    /* hit distance, normalised */
    { "hit distance 0", NOISE_UNIFORM, 1, NULL, put_hit_dist, 0, 0, 0 },
    { "hit distance 1e-6", NOISE_UNIFORM, 1, NULL, put_hit_dist, 1e-6, 0, 0 },
    { "hit distance 1e-30", NOISE_UNIFORM, 1, NULL, put_hit_dist, 1e-30, 0, 0 },
    { "hit distance 1: a miss", NOISE_UNIFORM, 1, NULL, put_hit_dist, 1, 0, 0 },
    { "hit distance 1e6", NOISE_UNIFORM, 1, NULL, put_hit_dist, 1e6, 0, 0 },
    { "hit distance -1", NOISE_UNIFORM, 1, NULL, put_hit_dist, -1, 0, 0 },
    /* half width of the penumbra */
    { "penumbra 1e-40", NOISE_UNIFORM, 1, NULL, put_penumbra, 1e-40, 0, 0 },
    { "penumbra 1e-6", NOISE_UNIFORM, 1, NULL, put_penumbra, 1e-6, 0, 0 },
    { "penumbra 1e4", NOISE_UNIFORM, 1, NULL, put_penumbra, 1e4, 0, 0 },
    /* depth */
    { "depth 1e-4", NOISE_UNIFORM, 1, set_depth, NULL, 1e-4, DENOISES, 0 },
    { "depth 1e-2", NOISE_UNIFORM, 1, set_depth, NULL, 1e-2, DENOISES, 0 },
    { "depth 1e4", NOISE_UNIFORM, 1, set_depth, NULL, 1e4, DENOISES, 0 },
    { "depth 1e7", NOISE_UNIFORM, 1, set_depth, NULL, 1e7, DENOISES, 0 },
    { "depth 0.1 within a range of 5e5", NOISE_UNIFORM, 1, set_depth_in_default_range, NULL, 0.1, DENOISES, 0 },
    { "depth 1e-5 within a range of 5e5", NOISE_UNIFORM, 1, set_depth_in_default_range, NULL, 1e-5, 0, 0 },
    { "depth 2e-38", NOISE_UNIFORM, 1, set_depth_in_default_range, NULL, 2e-38, 0, 0 },
    { "range at the depth", NOISE_UNIFORM, 1, set_range_over_depth, NULL, 1, 0, 0 },
    { "range just beyond the depth", NOISE_UNIFORM, 1, set_range_over_depth, NULL, 1.000001, DENOISES, 0 },
    { "range 1e-4 beyond the depth", NOISE_UNIFORM, 1, set_range_over_depth, NULL, 1.0001, DENOISES, 0 },
    { "depth that is noise", NOISE_UNIFORM, 1, NULL, put_depth_noise, 3, 0, 0 },
    { "depth that is noise over 17 decades", NOISE_UNIFORM, 1, NULL, put_depth_noise, 40, 0, 0 },
    { "IN_VIEWZ times 1e-6", NOISE_UNIFORM, 1, set_view_z_scale, NULL, 1e-6, 0, 0 },
    { "IN_VIEWZ times 90", NOISE_UNIFORM, 1, set_view_z_scale, NULL, 90, 0, 0 },
    /* surface */
    { "roughness 0", NOISE_UNIFORM, 1, set_roughness, NULL, 0, 0, 0 },
    { "roughness 1", NOISE_UNIFORM, 1, set_roughness, NULL, 1, DENOISES, 0 },
    { "plane at 85 degrees", NOISE_UNIFORM, 1, set_tilt, NULL, 85, 0, 0 },
    { "plane at 89.9 degrees", NOISE_UNIFORM, 1, set_tilt, NULL, 89.9, 0, 0 },
    { "normals exactly grazing", NOISE_UNIFORM, 1, NULL, turn_normals, 90, 0, 0 },
    { "normals flipped", NOISE_UNIFORM, 1, NULL, turn_normals, 180, 0, 0 },
    { "normals of random bits", NOISE_UNIFORM, 1, NULL, put_raw_normals, 1, 0, 0 },
    { "normals of zero bits", NOISE_UNIFORM, 1, NULL, put_raw_normals, 0, 0, 0 },
    /* motion */
    { "motion 1e-6", NOISE_UNIFORM, 1, NULL, move_by, 1e-6, DENOISES, 0 },
    { "motion of a whole screen", NOISE_UNIFORM, 1, NULL, move_by, 1, 0, 0 },
    { "motion to 1e6", NOISE_UNIFORM, 1, NULL, move_by, 1e6, 0, 0 },
    { "motion to 1e20", NOISE_UNIFORM, 1, NULL, move_by, 1e20, 0, 0 },
    { "motion to infinity", NOISE_UNIFORM, 1, NULL, move_by, INFINITY, 0, 0 },
    { "motion NaN", NOISE_UNIFORM, 1, NULL, move_by, NAN, 0, 0 },
    { "motion at random within a pixel", NOISE_UNIFORM, 1, NULL, move_at_random, 0.03, 0, 0 },
    { "motion at random", NOISE_UNIFORM, 1, NULL, move_at_random, 3, 0, 0 },
    { "motion at random to 1e30", NOISE_UNIFORM, 1, NULL, move_at_random, 1e30, 0, 0 },
    /* camera */
    { "field of view 0.1 degrees", NOISE_UNIFORM, 1, set_field_of_view, NULL, 0.1, DENOISES, 0 },
    { "field of view 1 degree", NOISE_UNIFORM, 1, set_field_of_view, NULL, 1, DENOISES, 0 },
    { "field of view 150 degrees", NOISE_UNIFORM, 1, set_field_of_view, NULL, 150, DENOISES, 0 },
    { "field of view 179 degrees", NOISE_UNIFORM, 1, set_field_of_view, NULL, 179, DENOISES, 0 },
    { "near plane 1e-5, infinite far", NOISE_UNIFORM, 1, set_near, NULL, 1e-5, DENOISES, 0 },
    { "reversed z, near plane 1e-5", NOISE_UNIFORM, 1, set_reversed, NULL, 1e-5, DENOISES, 0 },
    { "view z negative", NOISE_UNIFORM, 1, set_left_behind, NULL, 0, DENOISES, 0 },
    { "view z -1e-4", NOISE_UNIFORM, 1, set_depth_left_behind, NULL, 1e-4, DENOISES, 0 },
    { "view z -1e7", NOISE_UNIFORM, 1, set_depth_left_behind, NULL, 1e7, DENOISES, 0 },
    { "orthographic", NOISE_UNIFORM, 1, set_orthographic, NULL, 3, DENOISES, 0 },
    { "orthographic, 1e-3 high", NOISE_UNIFORM, 1, set_orthographic, NULL, 1e-3, DENOISES, 0 },
    { "orthographic, 1e5 high", NOISE_UNIFORM, 1, set_orthographic, NULL, 1e5, DENOISES, 0 },
    { "camera 1e7 from the origin", NOISE_UNIFORM, 1, set_position, NULL, 1e7, DENOISES, 0 },
    { "camera walks 1e7 from the origin", NOISE_UNIFORM, 1, set_position_and_walk, walk, 1e7, 0, 0 },
    { "millimetres", NOISE_UNIFORM, 1, set_units, NULL, 1e3, DENOISES, 0 },
    { "kilometres", NOISE_UNIFORM, 1, set_units, NULL, 1e-3, DENOISES, 0 },
    /* sky, rectangle, time */
    { "all sky", NOISE_UNIFORM, 1, NULL, put_sky, 0, 0, 0 },
    { "checker of sky, alternating", NOISE_UNIFORM, 1, NULL, put_sky, 1, 0, 0 },
    { "one pixel in the sky", NOISE_UNIFORM, 1, NULL, put_sky, 2, 0, 0 },
    { "one pixel in the sky, fireflies cut", NOISE_CONSTANT, 1000, set_anti_firefly, put_sky, 2, 0, 0 },
    { "half of it sky", NOISE_UNIFORM, 1, NULL, put_sky, 3, 0, 0 },
    { "tiles of sky", NOISE_UNIFORM, 1, NULL, put_sky, 4, 0, 0 },
    { "rectangle of 1x1", NOISE_UNIFORM, 1, set_rectangle, put_bad_outside, 1, 0, 0 },
    { "rectangle of 5x5", NOISE_UNIFORM, 1, set_rectangle, put_bad_outside, 5, 0, 0 },
    { "rectangle of 9x9", NOISE_UNIFORM, 1, set_rectangle, put_bad_outside, 9, 0, 0 },
    { "frame_index wraps", NOISE_UNIFORM, 1, set_frame_index, NULL, 5, DENOISES, 0 },
};

/* Guides of REFERENCE are none. */
static bool concerns(const rig *r, const extreme *e)
{
    bool guided = r->texels[NRD_RESOURCE_IN_VIEWZ] != NULL;
    if (e->change == put_primary) return r->signals[0].kind == KIND_RADIANCE;
    if (e->change == put_penumbra) return r->texels[NRD_RESOURCE_IN_PENUMBRA] != NULL;
    return guided || !(e->set || e->change) || e->change == put_bad || e->change == put_bad_everywhere || e->set == set_rectangle;
}

static void run_extreme(stress *s, rig *r, const extreme *e)
{
    watch w = watch_start();
    rig_reset(r);
    r->index = 1000;
    if (e->set) e->set(r, e->v);
    if (e->flags & NO_ANTILAG) rig_set(r, "antilag_sensitivity", 0);
    for (uint32_t frame = 0; frame < (e->flags & (DENOISES | LONG) ? LONG_FRAMES : FRAMES); frame++) {
        if (e->change == walk) walk(r, frame, e->v);
        rig_put_guides(r);
        fill_noise(r, e->noise, e->level, s->seed);
        if (e->change && e->change != walk) e->change(r, frame, e->v);
        watch_inputs(&w, r);
        rig_run(r);
        watch_outputs(&w, r);
    }
    watch_check(s, &w, r, e->name);
    if (e->flags & DENOISES) check(s, GUARANTEE_DENOISES, e->name, r->denoiser, noise_left(r));
}

/* ---- normals that storage has made longer or shorter */
static void run_stored_normals(stress *s, nrd_denoiser denoiser)
{
    static const extreme stored = { "normals in 8 bits", NOISE_UNIFORM, 1, set_tilt_in_view, put_8_bit_normals, 40, DENOISES, 0 };
    rig r;
    rig_desc desc = stress_rig(s, denoiser, IMAGE_WIDTH, IMAGE_HEIGHT);
    desc.normal_encoding = NRD_NORMAL_FORMAT_RGBA8_UNORM;
    rig_open(&r, &desc);
    if (r.texels[NRD_RESOURCE_IN_NORMAL_ROUGHNESS]) run_extreme(s, &r, &stored);
    rig_close(&r);
}

/* ---- sizes */
static const uint32_t sizes[][2] = { { 1, 1 }, { 7, 5 }, { 1, 37 }, { 37, 1 }, { 8, 8 }, { 9, 17 }, { 16384, 1 }, { 1, 16384 } };

static void run_size(stress *s, nrd_denoiser denoiser, uint32_t width, uint32_t height)
{
    rig r;
    char name[64];
    rig_desc desc = stress_rig(s, denoiser, width, height);
    watch w = watch_start();
    snprintf(name, sizeof name, "size %ux%u", width, height);
    rig_open(&r, &desc);
    r.camera.aspect = (double)width / height;
    for (uint32_t frame = 0; frame < 4; frame++) {
        rig_put_guides(&r);
        fill_noise(&r, NOISE_UNIFORM, 1, s->seed);
        watch_inputs(&w, &r);
        rig_run(&r);
        watch_outputs(&w, &r);
    }
    watch_check(s, &w, &r, name);
    rig_close(&r);
}

void stress_extremes(stress *s)
{
    for (int d = (int)s->first; d <= (int)s->last; d++) {
        rig r;
        rig_desc desc = stress_rig(s, (nrd_denoiser)d, IMAGE_WIDTH, IMAGE_HEIGHT);
        rig_open(&r, &desc);
        for (size_t i = 0; i < sizeof extremes / sizeof extremes[0]; i++)
            if (concerns(&r, &extremes[i])) run_extreme(s, &r, &extremes[i]);
        rig_close(&r);
        run_stored_normals(s, (nrd_denoiser)d);
        for (size_t i = 0; i < (s->everything ? sizeof sizes / sizeof sizes[0] : 2); i++) run_size(s, (nrd_denoiser)d, sizes[i][0], sizes[i][1]);
    }
}
