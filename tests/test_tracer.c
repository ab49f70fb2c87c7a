/* The path tracers: the two of them agree, energy is kept, motion vectors are exact, frames repeat, guides are
   sound. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "common/half.h"
#include "common/pack.h"
#include "scenes/scene.h"
#include "tracer/bvh.h"
#include "tracer/tracer.h"
#include "tracer/tracer_vulkan.h"

enum { WIDTH = 64, HEIGHT = 36, TEXELS = WIDTH * HEIGHT };
static const float fps = 30.0f;

/* ---- helpers ---- */

typedef struct shot {
    scene scene;
    pt_scene posed;
    float *planes;
} shot;

static void open_shot(shot *s, const scene_def *def)
{
    char error[512] = "";
    memset(s, 0, sizeof *s);
    if (!scene_open(&s->scene, def, NULL, error, sizeof error)) fail_msg("%s", error);
    s->planes = calloc(PT_PLANE_COUNT * TEXELS, sizeof *s->planes);
    assert_non_null(s->planes);
}

static void close_shot(shot *s)
{
    free(s->planes);
    scene_free_pose(&s->posed);
    scene_close(&s->scene);
}

static void pose(shot *s, int frame)
{
    assert_true(scene_pose(&s->scene, frame, fps, WIDTH, HEIGHT, &s->posed));
    s->posed.frame.bounces = 3;
    s->posed.frame.paths = 1;
    s->posed.frame.direct_mis = s->scene.def->small_lights;
}

static void load_and_render(shot *s, tracer *t)
{
    char error[512] = "";
    if (!t->load(t, &s->posed, error, sizeof error)) fail_msg("%s", error);
    if (!t->render(t, &s->posed, s->planes, error, sizeof error)) fail_msg("%s", error);
}

static void open_embree(tracer *t, int threads)
{
    char error[512] = "";
    if (!tracer_open_embree(t, threads, error, sizeof error)) fail_msg("%s", error);
}

static const float *plane(const shot *s, uint32_t index) { return s->planes + (size_t)index * TEXELS; }

static vec3 texel3(const shot *s, uint32_t index, int i)
{
    return vec3(plane(s, index)[i], plane(s, index + 1)[i], plane(s, index + 2)[i]);
}

static bool is_sky(const shot *s, int i) { return plane(s, PT_PLANE_VIEW_Z)[i] >= s->posed.frame.denoising_range; }

static double mean_of(const float *values, const shot *s)
{
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < TEXELS; i++)
        if (!is_sky(s, i)) sum += values[i], count++;
    return count ? sum / count : 0.0;
}

/* World position of a uv and depth. */
static vec3 unproject(const pt_camera *c, float u, float v, float z)
{
    return c->position + xyz_of(c->right) * ((2.0f * u - 1.0f) * c->right[3] * z) +
           xyz_of(c->up) * ((1.0f - 2.0f * v) * c->up[3] * z) + xyz_of(c->forward) * z;
}

/* ---- agreement ---- */

/* Share of the pixels where a plane of the two shots agrees within a tolerance, relative above 1. */
static double agreement(const shot *a, const shot *b, uint32_t index, float tolerance)
{
    int same = 0;
    for (int i = 0; i < TEXELS; i++) {
        float x = plane(a, index)[i], y = plane(b, index)[i];
        same += fabsf(x - y) <= tolerance * fmaxf(1.0f, fabsf(x));
    }
    return (double)same / TEXELS;
}

static bool open_vulkan_or_skip(tracer *t)
{
    char error[512] = "";
    if (tracer_open_vulkan(t, -1, error, sizeof error)) return true;
    print_message("skipped: %s\n", error);
    return false;
}

static void compare_signals(const shot *a, const shot *b, const char *name)
{
    static const uint32_t signals[] = { PT_PLANE_DIFFUSE + 1, PT_PLANE_SPECULAR + 1, PT_PLANE_DIFFUSE_HIT,
                                        PT_PLANE_SPECULAR_HIT, PT_PLANE_SHADOW_HIT, PT_PLANE_TRANSLUCENCY };
    for (size_t k = 0; k < sizeof signals / sizeof signals[0]; k++) {
        double share = agreement(a, b, signals[k], 0.01f);
        double ma = mean_of(plane(a, signals[k]), a), mb = mean_of(plane(b, signals[k]), b);
        /* Same random numbers: only paths that graze an edge differ. */
        if (share < 0.97) fail_msg("%s: plane %u agrees on %.1f %% of the pixels", name, signals[k], 100.0 * share);
        if (fabs(ma - mb) > 0.05 * (fabs(ma) + 1e-3))
            fail_msg("%s: plane %u has means %g and %g", name, signals[k], ma, mb);
    }
}

static void both_tracers_give_the_same_frames(void **state)
{
    (void)state;
    static const char *const names[] = { "interior", "moving", "thin", "glass", "lamp" };
    tracer embree, vulkan;
    if (!open_vulkan_or_skip(&vulkan)) skip();
    open_embree(&embree, 2);
    for (size_t n = 0; n < sizeof names / sizeof names[0]; n++) {
        shot a, b;
        open_shot(&a, scene_find(names[n]));
        open_shot(&b, scene_find(names[n]));
        pose(&a, 6);
        pose(&b, 6);
        load_and_render(&a, &embree);
        load_and_render(&b, &vulkan);
        for (uint32_t p = 0; p < PT_PLANE_DIFFUSE; p++)
            if (agreement(&a, &b, p, 1e-4f) < 0.99) fail_msg("%s: guide plane %u differs", names[n], p);
        for (uint32_t p = PT_PLANE_DIFFUSE_FACTOR; p < PT_PLANE_SHADOW_HIT; p++)
            if (agreement(&a, &b, p, 1e-4f) < 0.99) fail_msg("%s: factor plane %u differs", names[n], p);
        compare_signals(&a, &b, names[n]);
        close_shot(&a);
        close_shot(&b);
    }
    embree.close(&embree);
    vulkan.close(&vulkan);
}

static void accumulate_mean(tracer *t, shot *s, uint32_t samples, double *means)
{
    char error[512] = "";
    double *sums = calloc(PT_REF_COUNT * TEXELS, sizeof *sums);
    assert_non_null(sums);
    s->posed.frame.sample_first = 0;
    s->posed.frame.sample_count = samples;
    if (!t->load(t, &s->posed, error, sizeof error)) fail_msg("%s", error);
    if (!t->accumulate(t, &s->posed, sums, error, sizeof error)) fail_msg("%s", error);
    for (uint32_t p = 0; p < PT_REF_COUNT; p++) {
        means[p] = 0.0;
        for (int i = 0; i < TEXELS; i++) means[p] += sums[p * TEXELS + (uint32_t)i] / samples / TEXELS;
    }
    free(sums);
}

static void both_tracers_converge_to_the_same_reference(void **state)
{
    (void)state;
    tracer embree, vulkan;
    double a[PT_REF_COUNT], b[PT_REF_COUNT];
    if (!open_vulkan_or_skip(&vulkan)) skip();
    open_embree(&embree, 2);
    shot s;
    open_shot(&s, scene_find("glass"));
    pose(&s, 3);
    accumulate_mean(&embree, &s, 30, a);
    accumulate_mean(&vulkan, &s, 30, b);
    for (uint32_t p = 0; p < PT_REF_COUNT; p++)
        if (fabs(a[p] - b[p]) > 0.005 * a[p]) fail_msg("reference plane %u: means %g and %g", p, a[p], b[p]);
    close_shot(&s);
    embree.close(&embree);
    vulkan.close(&vulkan);
}

static void download(tracer *t, tracer_texture which, void *texels)
{
    if (!gpu_download(tracer_vulkan_gpu(t), tracer_vulkan_texture(t, which), texels))
        fail_msg("%s", gpu_error(tracer_vulkan_gpu(t)));
}

/* The texel that nrd.glsl packed in the shader against the one packed in C from the planes. */
static void check_radiance_texel(const shot *s, int i, const uint16_t got[4], uint32_t plane_index, float roughness)
{
    vec3 c = texel3(s, plane_index, i);
    const float rgb[3] = { c[0], c[1], c[2] };
    float params[4], hit = plane(s, plane_index + 3)[i];
    for (int k = 0; k < 4; k++) params[k] = s->posed.frame.hit_dist_params[k];
    uint16_t want[4];
    pack_radiance_hit_dist(rgb, pack_normalize_hit_dist(hit, plane(s, PT_PLANE_VIEW_Z)[i], roughness, params), want);
    for (int k = 0; k < 4; k++) {
        float a = half_to_float(got[k]), b = half_to_float(want[k]);
        if (fabsf(a - b) > 2e-3f * (1e-3f + fabsf(b) + max3(c) * (k < 3 ? 1.0f : 0.0f)))
            fail_msg("pixel %d, plane %u, channel %d: %g in the texture, %g in the planes", i, plane_index, k,
                     (double)a, (double)b);
    }
}

static void the_textures_for_the_denoisers_hold_the_frame(void **state)
{
    (void)state;
    static uint16_t diffuse[TEXELS][4], specular[TEXELS][4], normal[TEXELS][4], mv[TEXELS][4];
    static float view_z[TEXELS];
    tracer t;
    shot s;
    if (!open_vulkan_or_skip(&t)) skip();
    open_shot(&s, scene_find("moving"));
    pose(&s, 6);
    load_and_render(&s, &t);
    download(&t, TRACER_TEXTURE_diff_radiance_hitdist, diffuse);
    download(&t, TRACER_TEXTURE_spec_radiance_hitdist, specular);
    download(&t, TRACER_TEXTURE_normal_roughness, normal);
    download(&t, TRACER_TEXTURE_mv, mv);
    download(&t, TRACER_TEXTURE_viewz, view_z);
    for (int i = 0; i < TEXELS; i++) {
        vec3 n = normalize(vec3(half_to_float(normal[i][0]), half_to_float(normal[i][1]), half_to_float(normal[i][2])));
        assert_true(view_z[i] == plane(&s, PT_PLANE_VIEW_Z)[i]);
        assert_true(length(n - texel3(&s, PT_PLANE_NORMAL, i)) < 2e-3f);
        assert_true(fabsf(half_to_float(normal[i][3]) - plane(&s, PT_PLANE_ROUGHNESS)[i]) < 1e-3f);
        for (int k = 0; k < 3; k++) {
            float motion = plane(&s, PT_PLANE_MOTION + (uint32_t)k)[i];
            assert_true(fabsf(half_to_float(mv[i][k]) - motion) <= 1e-3f * fabsf(motion) + 1e-6f);
        }
        if (is_sky(&s, i)) continue;
        check_radiance_texel(&s, i, diffuse[i], PT_PLANE_DIFFUSE, 1.0f);
        check_radiance_texel(&s, i, specular[i], PT_PLANE_SPECULAR, plane(&s, PT_PLANE_ROUGHNESS)[i]);
    }
    close_shot(&s);
    t.close(&t);
}

/* ---- estimators ---- */

enum { MEANS = 5 };

/* Normalised as the references of the frame are. */
static float openness(const shot *s, uint32_t plane_index, float roughness, int i)
{
    const float *p = (const float *)&s->posed.frame.occlusion;
    return pack_normalize_hit_dist(plane(s, plane_index)[i], plane(s, PT_PLANE_VIEW_Z)[i], roughness, p);
}

/* What a noisy frame says, on average over the image, of the signals that references hold. */
static void frame_means(const shot *s, double means[MEANS])
{
    memset(means, 0, MEANS * sizeof *means);
    for (int i = 0; i < TEXELS; i++) {
        means[0] += plane(s, PT_PLANE_DIFFUSE)[i] / TEXELS;
        means[1] += plane(s, PT_PLANE_SPECULAR)[i] / TEXELS;
        means[2] += plane(s, PT_PLANE_SHADOW_HIT)[i] >= 65504.0f ? 1.0 / TEXELS : 0.0;
        means[3] += openness(s, PT_PLANE_DIFFUSE_HIT, 1.0f, i) / TEXELS;
        means[4] += openness(s, PT_PLANE_SPECULAR_HIT, plane(s, PT_PLANE_ROUGHNESS)[i], i) / TEXELS;
    }
}

static void noisy_frames_average_to_the_reference(void **state)
{
    (void)state;
    static const uint32_t planes[MEANS] = { PT_REF_DIFFUSE, PT_REF_SPECULAR, PT_REF_SHADOW, PT_REF_AO, PT_REF_SPECULAR_AO };
    enum { FRAMES = 48 };
    tracer t;
    shot s;
    double reference[PT_REF_COUNT];
    open_embree(&t, 2);
    open_shot(&s, scene_find("model"));
    pose(&s, 0);
    s.posed.frame.occlusion = s.posed.frame.hit_dist_params;
    accumulate_mean(&t, &s, 256, reference);
    for (uint32_t mis = 0; mis < 2; mis++) {
        double sum[MEANS] = { 0 }, square[MEANS] = { 0 }, means[MEANS];
        for (uint32_t f = 0; f < FRAMES; f++) {
            s.posed.frame.direct_mis = mis;
            s.posed.frame.seed = f;
            load_and_render(&s, &t);
            frame_means(&s, means);
            for (int k = 0; k < MEANS; k++) sum[k] += means[k] / FRAMES, square[k] += means[k] * means[k] / FRAMES;
        }
        for (int k = 0; k < MEANS; k++) {
            double deviation = sqrt(fmax(square[k] - sum[k] * sum[k], 0.0) / FRAMES), want = reference[planes[k]];
            if (fabs(sum[k] - want) > 4.5 * deviation + 0.004 * want)
                fail_msg("signal %d, mis %u: mean %g +- %g, reference %g", k, mis, sum[k], deviation, want);
        }
    }
    close_shot(&s);
    t.close(&t);
}

static bool build_furnace(scene *s, const char *model, char *error, size_t error_size)
{
    (void)model, (void)error, (void)error_size;
    scene_begin_object(s);
    scene_material(s, grey(1.0f), 1.0f, 0.0f);
    scene_add_sphere(s, grey(0.0f), 1.0f, 64);
    s->sky = (scene_sky){ grey(1.0f), grey(1.0f), grey(1.0f), 0.0f };
    return true;
}

static void animate_furnace(scene *s, float time_s)
{
    (void)time_s;
    s->camera = (scene_camera){ vec3(0.0f, 0.3f, -2.2f), grey(0.0f), 60.0f };
}

/* A convex body under a sky of radiance 1: the diffuse signal is 1 wherever it is sampled, and a white rough surface
   sends back no more light than it gets. */
static void a_white_furnace_gives_one(void **state)
{
    (void)state;
    static const scene_def def = { .name = "furnace", .frames = 1, .has_sky = true, .build = build_furnace, .animate = animate_furnace };
    tracer t;
    shot s;
    open_embree(&t, 2);
    open_shot(&s, &def);
    pose(&s, 0);
    s.posed.frame.paths = 64;
    load_and_render(&s, &t);
    double diffuse = mean_of(plane(&s, PT_PLANE_DIFFUSE), &s), total = 0.0;
    int count = 0;
    for (int i = 0; i < TEXELS; i++) {
        if (is_sky(&s, i)) continue;
        total += plane(&s, PT_PLANE_DIFFUSE)[i] * plane(&s, PT_PLANE_DIFFUSE_FACTOR)[i] +
                 plane(&s, PT_PLANE_SPECULAR)[i] * plane(&s, PT_PLANE_SPECULAR_FACTOR)[i];
        count++;
        assert_true(plane(&s, PT_PLANE_DIFFUSE_HIT)[i] >= 1024.0f); /* nearly every path leaves */
    }
    assert_true(count > 300);
    if (fabs(diffuse - 1.0) > 0.01) fail_msg("diffuse is %g, expected 1", diffuse);
    if (total / count < 0.9 || total / count > 1.02) fail_msg("a white surface reflects %g", total / count);
    close_shot(&s);
    t.close(&t);
}

/* ---- motion ---- */

/* Does a point lie on a triangle, within a distance? */
static bool lies_on(const pt_triangle *t, vec3 point, float distance)
{
    vec3 e = xyz_of(t->p[1]) - xyz_of(t->p[0]), f = xyz_of(t->p[2]) - xyz_of(t->p[0]), d = point - xyz_of(t->p[0]);
    vec3 n = cross(e, f);
    float area = dot(n, n), slack = distance / sqrtf(area) * fmaxf(length(e), length(f));
    if (fabsf(dot(d, n)) > distance * sqrtf(area)) return false;
    float b1 = dot(cross(d, f), n) / area, b2 = dot(cross(e, d), n) / area;
    return b1 >= -slack && b2 >= -slack && b1 + b2 <= 1.0f + slack;
}

/* Was there a surface, in the previous frame, where the motion vector of pixel i says? */
static bool previous_surface_found(const shot *now, const shot *before, int i)
{
    vec3 m = texel3(now, PT_PLANE_MOTION, i);
    float u = ((float)(i % WIDTH) + 0.5f) / WIDTH + m[0], v = ((float)(i / WIDTH) + 0.5f) / HEIGHT + m[1];
    vec3 p = unproject(&before->posed.frame.camera, u, v, plane(now, PT_PLANE_VIEW_Z)[i] + m[2]);
    for (uint32_t t = 0; t < before->posed.triangle_count; t++)
        if (lies_on(&before->posed.triangles[t], p, 2e-4f)) return true;
    return false;
}

static void render_pair(const char *name, int frame, shot *before, shot *now)
{
    tracer t;
    open_embree(&t, 2);
    open_shot(before, scene_find(name));
    open_shot(now, scene_find(name));
    pose(before, frame - 1);
    load_and_render(before, &t);
    pose(now, frame);
    load_and_render(now, &t);
    t.close(&t);
}

static void motion_of_static_geometry_is_exact(void **state)
{
    (void)state;
    static const char *const names[] = { "interior", "colonnade", "roughness_ramp", "model" };
    for (size_t n = 0; n < sizeof names / sizeof names[0]; n++) {
        shot before, now;
        render_pair(names[n], 5, &before, &now);
        for (int i = 0; i < TEXELS; i++) {
            if (is_sky(&now, i)) continue;
            float u = ((float)(i % WIDTH) + 0.5f) / WIDTH, v = ((float)(i / WIDTH) + 0.5f) / HEIGHT;
            float z = plane(&now, PT_PLANE_VIEW_Z)[i];
            vec3 m = texel3(&now, PT_PLANE_MOTION, i);
            vec3 p = unproject(&now.posed.frame.camera, u, v, z);
            vec3 q = unproject(&before.posed.frame.camera, u + m[0], v + m[1], z + m[2]);
            if (length(p - q) > 2e-5f * z) fail_msg("%s: pixel %d is off by %g m", names[n], i, (double)length(p - q));
        }
        close_shot(&before);
        close_shot(&now);
    }
}

static void motion_of_moving_bodies_finds_them_in_the_previous_frame(void **state)
{
    (void)state;
    shot before, now;
    int moving = 0, found = 0;
    render_pair("moving", 8, &before, &now);
    for (int i = 0; i < TEXELS; i++) {
        vec3 m = texel3(&now, PT_PLANE_MOTION, i);
        if (is_sky(&now, i) || dot(m, m) == 0.0f) continue; /* the camera stands still */
        moving++;
        found += previous_surface_found(&now, &before, i);
    }
    if (moving < 40) fail_msg("only %d pixels move", moving);
    if (found != moving) fail_msg("%d of %d moving pixels found", found, moving);
    close_shot(&before);
    close_shot(&now);
}

static void the_first_frame_does_not_move(void **state)
{
    (void)state;
    for (int n = 0; n < scene_table_count; n++) {
        shot s;
        tracer t;
        open_embree(&t, 2);
        open_shot(&s, &scene_table[n]);
        pose(&s, 0);
        load_and_render(&s, &t);
        for (int i = 0; i < TEXELS; i++) assert_true(length(texel3(&s, PT_PLANE_MOTION, i)) == 0.0f);
        close_shot(&s);
        t.close(&t);
    }
}

static void the_moving_scene_changes_as_it_says(void **state)
{
    (void)state;
    shot s;
    uint32_t triangles[3], lights[3];
    static const int frames[3] = { 2, 18, 30 }; /* nothing yet; a body has come and a light is out; a body has gone */
    open_shot(&s, scene_find("moving"));
    for (int i = 0; i < 3; i++) {
        pose(&s, frames[i]);
        triangles[i] = s.posed.triangle_count;
        lights[i] = s.posed.frame.light_count;
    }
    assert_true(triangles[1] > triangles[0] && triangles[2] < triangles[1]);
    assert_true(lights[1] < lights[0] && lights[1] > 0);
    close_shot(&s);
}

/* ---- soundness ---- */

static void the_same_seed_repeats_bit_for_bit(void **state)
{
    (void)state;
    static const int threads[3] = { 1, 2, 2 };
    float *first = malloc(PT_PLANE_COUNT * TEXELS * sizeof *first);
    assert_non_null(first);
    for (int run = 0; run < 3; run++) {
        tracer t;
        shot s;
        open_embree(&t, threads[run]);
        open_shot(&s, scene_find("thin"));
        pose(&s, 4);
        s.posed.frame.seed = run == 2;
        load_and_render(&s, &t);
        if (run == 0) memcpy(first, s.planes, PT_PLANE_COUNT * TEXELS * sizeof *first);
        bool same = memcmp(first, s.planes, PT_PLANE_COUNT * TEXELS * sizeof *first) == 0;
        assert_true(same == (run < 2));
        close_shot(&s);
        t.close(&t);
    }
    free(first);
}

static void check_pixel(const shot *s, int i, const char *name)
{
    for (uint32_t p = 0; p < PT_PLANE_COUNT; p++)
        if (!isfinite(plane(s, p)[i])) fail_msg("%s: plane %u is not finite at pixel %d", name, p, i);
    float normal = length(texel3(s, PT_PLANE_NORMAL, i));
    if (fabsf(normal - 1.0f) > 1e-4f) fail_msg("%s: normal of length %g at pixel %d", name, (double)normal, i);
    assert_true(plane(s, PT_PLANE_DIFFUSE_HIT)[i] >= 0.0f && plane(s, PT_PLANE_SPECULAR_HIT)[i] >= 0.0f);
    assert_true(plane(s, PT_PLANE_SHADOW_HIT)[i] >= 0.0f && plane(s, PT_PLANE_SHADOW_HIT)[i] <= 65504.0f);
    if (is_sky(s, i)) return;
    float z = plane(s, PT_PLANE_VIEW_Z)[i], roughness = plane(s, PT_PLANE_ROUGHNESS)[i];
    assert_true(z > 0.0f && roughness >= 0.0f && roughness <= 1.0f);
    for (uint32_t p = PT_PLANE_DIFFUSE_FACTOR; p < PT_PLANE_DIFFUSE_FACTOR + 6; p++)
        assert_true(plane(s, p)[i] >= 0.0199f && plane(s, p)[i] <= 1.0f);
    assert_true(fabsf(length(texel3(s, PT_PLANE_DIFFUSE_DIR, i)) - 1.0f) < 1e-3f);
    assert_true(fabsf(length(texel3(s, PT_PLANE_SPECULAR_DIR, i)) - 1.0f) < 1e-3f);
}

static void every_scene_gives_sound_frames(void **state)
{
    (void)state;
    tracer t;
    open_embree(&t, 2);
    for (int n = 0; n < scene_table_count; n++) {
        const scene_def *def = &scene_table[n];
        shot s;
        int sky = 0;
        float sun = 0.0f;
        open_shot(&s, def);
        for (int frame = 0; frame < def->frames; frame += def->frames / 2) {
            pose(&s, frame);
            load_and_render(&s, &t);
            for (int i = 0; i < TEXELS; i++) {
                check_pixel(&s, i, def->name);
                sky += is_sky(&s, i);
                sun = fmaxf(sun, plane(&s, PT_PLANE_SUN)[i]);
            }
        }
        if ((sky > 0) != def->has_sky) fail_msg("%s: %d sky pixels", def->name, sky);
        if ((sun > 0.0f) != def->has_sun) fail_msg("%s: sun up to %g", def->name, (double)sun);
        if (s.scene.triangle_count >= 20000 && strcmp(def->name, "model"))
            fail_msg("%s: %u triangles", def->name, s.scene.triangle_count);
        close_shot(&s);
    }
    t.close(&t);
}

static void the_hierarchy_holds_every_triangle_once(void **state)
{
    (void)state;
    shot s;
    bvh b;
    open_shot(&s, scene_find("thin"));
    pose(&s, 0);
    assert_true(bvh_build(&s.posed, &b));
    uint32_t total = 0;
    unsigned char *seen = calloc(s.posed.triangle_count, 1);
    assert_non_null(seen);
    for (uint32_t n = 0; n < b.node_count; n++)
        for (uint32_t i = 0; i < b.nodes[n].count; i++) {
            uint32_t id = b.order[b.nodes[n].first + i];
            assert_true(id < s.posed.triangle_count && !seen[id]);
            seen[id] = 1;
            total++;
            for (int k = 0; k < 3; k++)
                for (int c = 0; c < 3; c++) {
                    float x = s.posed.triangles[id].p[k][c];
                    assert_true(x >= b.nodes[n].low[c] && x <= b.nodes[n].high[c]);
                }
        }
    assert_int_equal(total, s.posed.triangle_count);
    free(seen);
    bvh_free(&b);
    close_shot(&s);
}

static void an_unreadable_model_is_reported(void **state)
{
    (void)state;
    scene s;
    char error[256] = "";
    assert_false(scene_open(&s, scene_find("model"), "no-such-file.obj", error, sizeof error));
    assert_non_null(strstr(error, "no-such-file.obj"));
    assert_null(strchr(error, '\n'));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_tracers_give_the_same_frames),
        cmocka_unit_test(both_tracers_converge_to_the_same_reference),
        cmocka_unit_test(the_textures_for_the_denoisers_hold_the_frame),
        cmocka_unit_test(noisy_frames_average_to_the_reference),
        cmocka_unit_test(a_white_furnace_gives_one),
        cmocka_unit_test(motion_of_static_geometry_is_exact),
        cmocka_unit_test(motion_of_moving_bodies_finds_them_in_the_previous_frame),
        cmocka_unit_test(the_first_frame_does_not_move),
        cmocka_unit_test(the_moving_scene_changes_as_it_says),
        cmocka_unit_test(the_same_seed_repeats_bit_for_bit),
        cmocka_unit_test(every_scene_gives_sound_frames),
        cmocka_unit_test(the_hierarchy_holds_every_triangle_once),
        cmocka_unit_test(an_unreadable_model_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
