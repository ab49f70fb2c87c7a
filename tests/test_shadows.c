/* Shadows of every scene with a sun or a lamp, rendered and denoised: never worse than the rays, contacts sharp, no halo across edges of
   depth, umbrae black. */
#define NRD_IMPLEMENTATION
#define NRD_VK_IMPLEMENTATION
#define VK_NO_PROTOTYPES
#include "nrd_vk.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "common/denoise.h"
#include "common/metrics.h"
#include "common/signals.h"
#include "scenes/scene.h"
#include "tracer/tracer.h"
#include "tracer/tracer_capture.h"

enum { WIDTH = 160, HEIGHT = 90, PIXELS = WIDTH * HEIGHT, FRAMES = 10, SCORED = 2, SAMPLES = 48 };

typedef struct study {
    scene scene;
    pt_scene posed;
    tracer tracer;
    denoise *denoiser;
    float *planes;
    double *sums;
    signal_id signal;
    metrics noisy, denoised;               /* of the last SCORED frames */
    double contact, contact_rays, elsewhere, halo, umbra; /* squared errors */
    int contacts, elsewheres, edges, umbrae;
} study;

static void open_study(study *s, const scene_def *def)
{
    char error[512] = "";
    memset(s, 0, sizeof *s);
    s->signal = def->has_glass ? SIGNAL_TRANSLUCENCY : SIGNAL_SHADOW;
    if (!scene_open(&s->scene, def, NULL, error, sizeof error) || !tracer_open_embree(&s->tracer, 2, error, sizeof error)) fail_msg("%s", error);
    s->planes = malloc(PT_PLANE_COUNT * PIXELS * sizeof *s->planes);
    s->sums = malloc(PT_REF_COUNT * PIXELS * sizeof *s->sums);
    assert_true(s->planes && s->sums);
}

static void close_study(study *s)
{
    denoise_destroy(s->denoiser);
    s->tracer.close(&s->tracer);
    scene_free_pose(&s->posed);
    scene_close(&s->scene);
    free(s->planes);
    free(s->sums);
}

static void render(study *s, int frame, capture *out)
{
    char error[512] = "";
    assert_true(scene_pose(&s->scene, frame, 30.0f, WIDTH, HEIGHT, &s->posed) && capture_create(out, WIDTH, HEIGHT));
    s->posed.frame.bounces = s->posed.frame.paths = 1;
    assert_true(s->tracer.load(&s->tracer, &s->posed, error, sizeof error) && s->tracer.render(&s->tracer, &s->posed, s->planes, error, sizeof error));
    assert_true(tracer_fill_capture(out, &s->posed.frame, 30.0f, s->scene.def, s->planes));
    if (frame < FRAMES - SCORED) return;
    memset(s->sums, 0, PT_REF_COUNT * PIXELS * sizeof *s->sums);
    s->posed.frame.sample_count = SAMPLES;
    assert_true(s->tracer.accumulate(&s->tracer, &s->posed, s->sums, error, sizeof error));
    for (int i = 0; i < (int)PT_REF_COUNT * PIXELS; i++) s->planes[i] = (float)(s->sums[i] / SAMPLES);
    assert_true(tracer_fill_reference(out, s->scene.def, s->planes));
}

static void denoise_one(study *s, const capture *frame, int index, capture *out)
{
    char error[512] = "";
    static denoise_desc desc;
    desc = (denoise_desc){ .denoiser_count = 1, .device_index = -1 };
    desc.denoisers[0] = s->signal == SIGNAL_SHADOW ? NRD_DENOISER_SIGMA_SHADOW : NRD_DENOISER_SIGMA_SHADOW_TRANSLUCENCY;
    if (!s->denoiser) s->denoiser = denoise_create(&desc, frame, error, sizeof error);
    if (!s->denoiser || !denoise_frame(s->denoiser, frame, "frame", (uint32_t)index, out, error, sizeof error)) fail_msg("%s", error);
}

/* What lies within `reach` of a pixel. */
typedef struct neighbours { bool crease, edge; /* of depth */ bool uniform; /* the shadow, on this surface */ } neighbours;

static neighbours look_around(const capture *frame, const float *truth, const unsigned char *mask, int i, int reach)
{
    const float *z = capture_find_plane(frame, "viewZ");
    float *n[3];
    neighbours r = { false, false, true };
    capture_find_planes(frame, "normal", "XYZ", n);
    for (int y = i / WIDTH - reach; y <= i / WIDTH + reach; y++)
        for (int x = i % WIDTH - reach; x <= i % WIDTH + reach; x++) {
            int j = y * WIDTH + x;
            if (x < 0 || y < 0 || x >= WIDTH || y >= HEIGHT) continue;
            bool near = fabsf(z[j] - z[i]) < 0.05f * z[i], turned = n[0][i] * n[0][j] + n[1][i] * n[1][j] + n[2][i] * n[2][j] < 0.7f;
            r.crease |= near && turned;
            r.edge |= !near;
            r.uniform &= !near || turned || (mask[j] && truth[j] == truth[i]);
        }
    return r;
}

/* Sums up the errors of one frame by what is near. */
static void sort_errors(study *s, const capture *frame, const image *shown, const image *noisy, const image *truth, const unsigned char *mask)
{
    for (int i = 0; i < PIXELS; i++) {
        double error = 0, noise = 0, t = truth->planes[0][i];
        if (!mask[i]) continue;
        for (int k = 0; k < shown->channels; k++) {
            error += pow(shown->planes[k][i] - truth->planes[k][i], 2) / shown->channels;
            noise += pow(noisy->planes[k][i] - truth->planes[k][i], 2) / shown->channels;
        }
        neighbours by = look_around(frame, truth->planes[0], mask, i, 2), far = look_around(frame, truth->planes[0], mask, i, 4);
        if (by.crease) s->contact += error, s->contact_rays += noise, s->contacts++;
        else if (!by.uniform) s->elsewhere += error, s->elsewheres++;
        if (by.edge && far.uniform) s->halo += error, s->edges++;
        if (t == 0 && far.uniform) s->umbra += error, s->umbrae++;
    }
}

static void score(study *s, const capture *frame, const capture *out)
{
    image truth, noisy, shown;
    metrics m;
    metrics_scale unit = { 1, 1e-3, true };
    static unsigned char mask[PIXELS];
    signal_mask(frame, s->signal, mask);
    assert_true(signal_get(frame, NULL, s->signal, SOURCE_REFERENCE, &truth) && signal_get(frame, NULL, s->signal, SOURCE_NOISY, &noisy)
                && signal_get(frame, out, s->signal, SOURCE_DENOISED, &shown));
    assert_true(metrics_compare(&noisy, &truth, mask, &unit, &m));
    metrics_add(&s->noisy, &m);
    assert_true(metrics_compare(&shown, &truth, mask, &unit, &m));
    metrics_add(&s->denoised, &m);
    sort_errors(s, frame, &shown, &noisy, &truth, mask);
    image_destroy(&truth);
    image_destroy(&noisy);
    image_destroy(&shown);
}

static void run_study(study *s, const scene_def *def)
{
    open_study(s, def);
    for (int i = 0; i < FRAMES; i++) {
        capture frame, out;
        render(s, i, &frame);
        denoise_one(s, &frame, i, &out);
        if (i >= FRAMES - SCORED) score(s, &frame, &out);
        capture_destroy(&frame);
        capture_destroy(&out);
    }
    close_study(s);
}

static double root_mean(double sum, int count) { return count ? sqrt(sum / count) : 0; }

static void shadows_of_every_scene_are_better_than_their_rays(void **state)
{
    (void)state;
    for (int n = 0; n < scene_table_count; n++) {
        const scene_def *def = &scene_table[n];
        study s;
        if (!def->has_sun) continue;
        run_study(&s, def);
        double noisy = metrics_summarise(&s.noisy).rel_mse_trimmed, denoised = metrics_summarise(&s.denoised).rel_mse_trimmed;
        double contact = root_mean(s.contact, s.contacts), elsewhere = root_mean(s.elsewhere, s.elsewheres), halo = root_mean(s.halo, s.edges), umbra = root_mean(s.umbra, s.umbrae);
        print_message("%-16s trimmed relMSE: rays %.5f, denoised %.5f; error within 2 px of %d contacts %.4f, at edges of shadows elsewhere %.4f, at %d edges of depth %.4f; in %d pixels of umbra %.4f\n",
                      def->name, noisy, denoised, s.contacts, contact, elsewhere, s.edges, halo, s.umbrae, umbra);
        if (!(denoised <= noisy)) fail_msg("%s: error %g, of the rays %g", def->name, denoised, noisy);
        if (!(contact <= 1.3 * elsewhere)) fail_msg("%s: error at contacts %g, elsewhere %g", def->name, contact, elsewhere);
        if (!(s.contact <= 1.02 * s.contact_rays)) fail_msg("%s: error at contacts %g, of the rays %g", def->name, contact, root_mean(s.contact_rays, s.contacts));
        if (!(halo <= 0.02)) fail_msg("%s: error along edges of depth %g", def->name, halo);
        if (!(umbra <= 0.01)) fail_msg("%s: umbrae are lit by %g", def->name, umbra);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(shadows_of_every_scene_are_better_than_their_rays) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
