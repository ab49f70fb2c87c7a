/* The same frames again, bit for bit; and on other devices, through files. */
#include "stress/stress.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 48, HEIGHT = 32, FRAMES = 12, TEXELS = RIG_MAX_SIGNALS * WIDTH * HEIGHT };
#define FLIPPED 0.2

/* ---- scenes */
/* A nearer strip passes in front of the wall; a band at the top is sky. */
static surface passing(const rig *r, uint32_t x, uint32_t y)
{
    surface s = stress_wall(r, x, y);
    uint32_t left = 4 + 3 * r->variant;
    if (y < 5) s.depth = RIG_SKY;
    else if (x >= left && x < left + 12) {
        s = rig_surface(r, x, y);
        s.depth *= 0.6;
        s.material = 1;
        s.moved[0] = -3.0 / WIDTH * 2 * s.depth * r->camera.tan_half_height * r->camera.aspect;
    }
    return s;
}

typedef struct agreement_scene { const char *name; shape *shape; noise_kind noise; double walk, jump; } agreement_scene; /* units per frame; factor of light half-way */
static const agreement_scene scenes[] = {
    { "a walk past a wall", stress_wall, NOISE_UNIFORM, 0.05, 1 },
    { "sparse light", stress_wall, NOISE_SPARSE, 0, 1 },
    { "something passes", passing, NOISE_UNIFORM, 0.02, 1 },
    { "a jump of light", stress_wall, NOISE_UNIFORM, 0, 50 },
};

typedef struct texel { float v[4]; } texel;

static void run_scene(rig *r, const agreement_scene *scene, texel *out)
{
    rig_reset(r);
    r->index = 9;
    r->shape = scene->shape;
    r->tilt = 40;
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        r->variant = frame;
        r->camera.position[0] = scene->walk * frame;
        rig_put_guides(r);
        fill_noise(r, scene->noise, frame < FRAMES / 2 ? 1 : scene->jump, 1);
        rig_run(r);
    }
    memset(out, 0, TEXELS * sizeof *out);
    for (uint32_t s = 0; s < r->signal_count; s++)
        FOR_PIXELS(r) {
            bool shown = r->signals[s].out != NRD_RESOURCE_COUNT && !rig_is_sky(r, x, y);
            if (shown) memcpy(out[(s * HEIGHT + y) * WIDTH + x].v, rig_texel(r, r->signals[s].out, x, y), channels_of(&r->signals[s]) * sizeof(float));
        }
}

static uint32_t differing(const texel *a, const texel *b)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < TEXELS; i++) count += memcmp(&a[i], &b[i], sizeof a[i]) != 0;
    return count;
}

/* ---- files */
static void write_texels(const stress *s, const rig *r, const char *scene, const texel *t)
{
    fprintf(s->dump, "%s, %s\n", nrd_denoiser_name(r->denoiser), scene);
    for (uint32_t i = 0; i < r->signal_count * WIDTH * HEIGHT; i++) fprintf(s->dump, "%.9g %.9g %.9g %.9g\n", (double)t[i].v[0], (double)t[i].v[1], (double)t[i].v[2], (double)t[i].v[3]);
}

static void read_texels(const stress *s, const rig *r, const char *scene, texel *t)
{
    char line[128], name[128];
    bool found;
    rewind(s->compare);
    snprintf(name, sizeof name, "%s, %s\n", nrd_denoiser_name(r->denoiser), scene);
    do found = fgets(line, sizeof line, s->compare) != NULL; while (found && strcmp(line, name) != 0);
    for (uint32_t i = 0; found && i < r->signal_count * WIDTH * HEIGHT; i++)
        found = fscanf(s->compare, "%f %f %f %f", &t[i].v[0], &t[i].v[1], &t[i].v[2], &t[i].v[3]) == 4;
    if (!found) stress_die("the file to compare with lacks %s, %s", nrd_denoiser_name(r->denoiser), scene);
}

/* ---- differences */
static double squared(const texel *t)
{
    double sum = 0;
    for (int k = 0; k < 4; k++) sum += (double)t->v[k] * t->v[k];
    return sum;
}

/* Of an output, as vectors of its channels. rms: over that of the picture; flipped: share of the pixels that differ by more than FLIPPED of it. */
typedef struct difference { double rms, flipped; } difference;

static difference difference_of(const texel *now, const texel *other)
{
    double whole = 0, squares = 0, flipped = 0;
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) whole += squared(&other[i]);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        texel d;
        for (int k = 0; k < 4; k++) d.v[k] = now[i].v[k] - other[i].v[k];
        squares += squared(&d);
        flipped += !(squared(&d) * (WIDTH * HEIGHT) <= FLIPPED * FLIPPED * whole);
    }
    return (difference){ sqrt(squares / whole), flipped / (WIDTH * HEIGHT) };
}

static void compare(stress *s, const rig *r, const char *scene, const texel *now, const texel *other)
{
    difference worst = { 0, 0 };
    for (uint32_t k = 0; k < r->signal_count; k++) {
        if (r->signals[k].out == NRD_RESOURCE_COUNT) continue;
        difference d = difference_of(now + k * WIDTH * HEIGHT, other + k * WIDTH * HEIGHT);
        worst.rms = !(d.rms <= worst.rms) ? d.rms : worst.rms;
        worst.flipped = fmax(worst.flipped, d.flipped);
    }
    bool light = r->signals[0].kind == KIND_RADIANCE || r->signals[0].kind == KIND_PLAIN;
    check(s, light ? GUARANTEE_DEVICES : GUARANTEE_DEVICES_8_BIT, scene, r->denoiser, worst.rms);
    check(s, GUARANTEE_DEVICES_FLIPS, scene, r->denoiser, worst.flipped);
}

static void agree(stress *s, rig *r, const agreement_scene *scene, texel *now)
{
    texel *other = now + TEXELS;
    run_scene(r, scene, now);
    run_scene(r, scene, other);
    check(s, GUARANTEE_REPEAT, scene->name, r->denoiser, differing(now, other));
    if (s->dump) write_texels(s, r, scene->name, now);
    if (!s->compare) return;
    read_texels(s, r, scene->name, other);
    compare(s, r, scene->name, now, other);
}

void stress_agreement(stress *s)
{
    if (s->dump) fprintf(s->dump, "device %s\n", s->device.properties.deviceName);
    for (int d = (int)s->first; d <= (int)s->last; d++) {
        rig r;
        rig_desc desc = stress_rig(s, (nrd_denoiser)d, WIDTH, HEIGHT);
        texel *texels = (texel *)calloc(2 * TEXELS, sizeof *texels);
        if (!texels) stress_die("out of memory");
        rig_open(&r, &desc);
        for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++) agree(s, &r, &scenes[i], texels);
        rig_close(&r);
        free(texels);
    }
}
