/* Stiff in space: correlated noise, surfaces that change from pixel to pixel, planes seen edge-on. */
#include "stress/stress.h"

#include <stdio.h>

enum { SIZE = 32, FRAMES = 24 };

static surface bumps(const rig *r, uint32_t x, uint32_t y)
{
    surface s = rig_surface(r, x, y);
    double a = random_at(x, y, 1) - 0.5, b = random_at(x, y, 2) - 0.5, length = sqrt(1 + a * a + b * b);
    s.normal[0] = a / length, s.normal[1] = b / length, s.normal[2] = -1 / length;
    return s;
}

static surface teeth(const rig *r, uint32_t x, uint32_t y)
{
    surface s = rig_surface(r, x, y);
    s.depth *= (x + y) & 1 ? 1.5 : 1;
    return s;
}

static surface roughness_noise(const rig *r, uint32_t x, uint32_t y)
{
    surface s = rig_surface(r, x, y);
    s.roughness = 0.3 + 0.7 * random_at(x, y, 1);
    return s;
}

static surface materials(const rig *r, uint32_t x, uint32_t y)
{
    surface s = rig_surface(r, x, y);
    s.material = (uint32_t)(random_at(x, y, 1) * 4);
    return s;
}

typedef struct space_case { const char *name; noise_kind noise; shape *shape; double tilt; } space_case;
static const space_case cases[] = {
    { "white noise", NOISE_UNIFORM, NULL, 0 },
    { "blue noise", NOISE_BLUE, NULL, 0 },
    { "noise equal over 8x8 pixels", NOISE_BLOCK, NULL, 0 },
    { "normals that change in every pixel", NOISE_UNIFORM, bumps, 0 },
    { "depth edges in every pixel", NOISE_UNIFORM, teeth, 0 },
    { "roughness that changes in every pixel", NOISE_UNIFORM, roughness_noise, 0 },
    { "materials that change in every pixel", NOISE_UNIFORM, materials, 0 },
    { "plane at 80 degrees", NOISE_UNIFORM, NULL, 80 },
    { "plane at 89.9 degrees", NOISE_UNIFORM, NULL, 89.9 },
};

static void set_up(rig *r, const space_case *c)
{
    rig_reset(r);
    r->index = 9;
    if (c->shape) r->shape = c->shape;
    r->tilt = c->tilt;
    if (c->tilt > 0) r->camera.tan_half_height = 0.2 / tan(c->tilt * 0.017453292519943295);   /* all of it visible */
    if (c->shape == materials) rig_set(r, "min_material_for_diffuse", 0), rig_set(r, "min_material_for_specular", 0), rig_set(r, "min_material", 0);
}

static void run_case(stress *s, rig *r, const space_case *c)
{
    watch w = watch_start();
    set_up(r, c);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        rig_put_guides(r);
        fill_noise(r, c->noise, 1, s->seed);
        watch_inputs(&w, r);
        rig_run(r);
        watch_outputs(&w, r);
    }
    watch_check(s, &w, r, c->name);
    check(s, c->noise == NOISE_BLOCK ? GUARANTEE_CORRELATED : GUARANTEE_DENOISES, c->name, r->denoiser, noise_left(r));
}

/* Light that sits on the nearer of two surfaces that alternate from pixel to pixel stays there. */
static void leak(stress *s, rig *r)
{
    double most = 0;
    rig_reset(r);
    r->index = 9;
    r->shape = teeth;
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        rig_put_guides(r);
        fill_noise(r, NOISE_CONSTANT, 1, 0);
        for (uint32_t k = 0; k < r->signal_count; k++)
            FOR_PIXELS(r) {
                float *t = rig_texel(r, r->signals[k].in, x, y), w = t[3];
                for (int i = 0; i < 4; i++) t[i] *= (x + y) & 1 ? 1 : 0.1f;
                if (r->signals[k].kind == KIND_RADIANCE) t[3] = w;
            }
        rig_run(r);
    }
    for (uint32_t k = 0; k < r->signal_count; k++)
        FOR_PIXELS(r) {
            if (r->signals[k].out == NRD_RESOURCE_COUNT || r->signals[k].kind == KIND_VECTOR || r->signals[k].kind == KIND_PENUMBRA) continue;
            double in = rig_input_value(r, k, x, y);
            most = fmax(most, fabs(rig_output_value(r, k, x, y) - in) / (r->signals[k].kind == KIND_RADIANCE || r->signals[k].kind == KIND_PLAIN ? in : 1));
        }
    check(s, GUARANTEE_LEAK, "depth edges in every pixel", r->denoiser, most);
}

void stress_space(stress *s)
{
    for (int d = (int)s->first; d <= (int)s->last; d++) {
        rig r;
        rig_desc desc = stress_rig(s, (nrd_denoiser)d, SIZE, SIZE);
        rig_open(&r, &desc);
        for (size_t i = 0; r.texels[NRD_RESOURCE_IN_VIEWZ] && i < sizeof cases / sizeof cases[0]; i++) run_case(s, &r, &cases[i]);
        if (r.texels[NRD_RESOURCE_IN_VIEWZ] && !r.texels[NRD_RESOURCE_IN_PENUMBRA]) leak(s, &r);
        rig_close(&r);
    }
}
