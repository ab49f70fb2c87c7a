#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <embree3/rtcore.h>

#include "tracer/tracer.h"

#define PT_FRAME (pt->frame)
#define PT_TRIANGLES (pt->triangles)
#define PT_MATERIALS (pt->materials)
#define PT_LIGHTS (pt->lights)
#include "tracer/primary.glsl"

enum { MAX_THREADS = 64 };

typedef struct embree_state {
    RTCDevice device;
    RTCScene scene;
    int threads;
} embree_state;

/* ---- what the shared maths asks for ---- */

static pt_hit pt_closest(const pt_scene *pt, vec3 origin, vec3 direction)
{
    struct RTCRayHit query = {
        .ray = { .org_x = origin[0],
                 .org_y = origin[1],
                 .org_z = origin[2],
                 .dir_x = direction[0],
                 .dir_y = direction[1],
                 .dir_z = direction[2],
                 .tfar = INFINITY,
                 .mask = ~0u },
        .hit = { .geomID = RTC_INVALID_GEOMETRY_ID },
    };
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(pt->accel, &context, &query);
    bool missed = query.hit.geomID == RTC_INVALID_GEOMETRY_ID;
    return (pt_hit){ missed ? PT_NO_TRIANGLE : query.hit.primID, query.ray.tfar, query.hit.u, query.hit.v };
}

static bool pt_occluded(const pt_scene *pt, vec3 origin, vec3 direction, float distance)
{
    struct RTCRay ray = { .org_x = origin[0],
                          .org_y = origin[1],
                          .org_z = origin[2],
                          .dir_x = direction[0],
                          .dir_y = direction[1],
                          .dir_z = direction[2],
                          .tfar = distance,
                          .mask = ~0u };
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(pt->accel, &context, &ray);
    return ray.tfar < 0.0f;
}

/* Split-sum GGX reflectance of one channel: the fit of Ray Tracing Gems (2019), chapter 32, which nrd.glsl uses too. */
static float environment_term(float rf0, float v, float roughness)
{
    float v2 = v * v, v3 = v2 * v, m = roughness * roughness, m3 = m * m * m;
    float bias = 0.99044f - 1.28514f * v + m * (1.29678f - 0.755907f * v);
    float bias_below = 1.0f + 2.92338f * v + 59.4188f * v3 + m * (20.3225f - 27.0302f * v + 222.592f * v3) +
                       m3 * (121.563f + 626.13f * v + 316.627f * v3);
    float scale = 0.0365463f + 3.32707f * v + m * (9.0632f - 9.04756f * v);
    float scale_below = 1.0f + 3.59685f * v2 - 1.36772f * v3 + m * (9.04401f - 16.3174f * v2 + 9.22949f * v3) +
                        m3 * (5.56589f + 19.7886f * v2 - 20.2123f * v3);
    return clamp(rf0 * scale / max(scale_below, 1e-6f) + bias / max(bias_below, 1e-6f), 0.0f, 1.0f);
}

/* nrd_material_factors() of nrd.glsl, in C; the tests hold the two tracers' factors equal. */
static pt_factors pt_material_factors(vec3 normal, vec3 view, vec3 albedo, vec3 rf0, float roughness)
{
    const float floor_factor = 0.02f, mirror_share = 0.1f;
    float v = min(fabsf(dot(normal, view)), 1.0f);
    pt_factors f = { grey(0.0f), grey(0.0f) };
    for (int c = 0; c < 3; c++) {
        float e = environment_term(rf0[c], v, roughness);
        f.diffuse[c] = lerp1(floor_factor, 1.0f, (1.0f - e) * albedo[c]);
        f.specular[c] = lerp1(floor_factor, 1.0f, e * lerp1(mirror_share, 1.0f, roughness));
    }
    return f;
}

/* ---- one pixel ---- */

typedef struct job {
    const pt_scene *scene;
    float *planes; /* a noisy frame, or */
    double *sums;  /* a reference */
    uint32_t next_row;
    pthread_mutex_t lock;
} job;

static size_t plane_size(const pt_scene *pt) { return (size_t)pt->frame.width * pt->frame.height; }

static void put3(float *planes, size_t plane_texels, uint32_t plane, vec3 v)
{
    for (uint32_t c = 0; c < 3; c++) planes[(plane + c) * plane_texels] = v[c];
}

static vec3 sanitized(vec3 v)
{
    if (!isfinite(v[0] + v[1] + v[2])) return grey(0.0f);
    for (int c = 0; c < 3; c++) v[c] = clamp(v[c], 0.0f, 65504.0f);
    return v;
}

static void put_sky(const pt_scene *pt, float *at, vec3 direction)
{
    size_t n = plane_size(pt);
    vec3 now = pt_project_sky(pt->frame.camera, direction), prev = pt_project_sky(pt->frame.camera_prev, direction);
    for (uint32_t p = 0; p < PT_PLANE_COUNT; p++) at[p * n] = 0.0f;
    at[PT_PLANE_VIEW_Z * n] = 2.0f * pt->frame.denoising_range;
    put3(at, n, PT_PLANE_NORMAL, direction * -1.0f);
    if (prev[2] > 0.0f) put3(at, n, PT_PLANE_MOTION, vec3(prev[0] - now[0], prev[1] - now[1], 0.0f));
    put3(at, n, PT_PLANE_EMISSION, sanitized(pt_sky(pt, direction)));
}

static void put_guides(const pt_scene *pt, float *at, const pt_surface *s)
{
    size_t n = plane_size(pt);
    vec3 now = pt_project(pt->frame.camera, s->position), prev = pt_project(pt->frame.camera_prev, s->position_prev);
    at[PT_PLANE_VIEW_Z * n] = now[2];
    put3(at, n, PT_PLANE_NORMAL, s->normal);
    at[PT_PLANE_ROUGHNESS * n] = s->roughness;
    put3(at, n, PT_PLANE_MOTION, prev[2] > 0.0f ? prev - now : grey(0.0f));
    at[PT_PLANE_MATERIAL * n] = (float)s->material_id;
    put3(at, n, PT_PLANE_BASE_COLOR, s->base_color);
    at[PT_PLANE_METALNESS * n] = s->metalness;
    put3(at, n, PT_PLANE_DIFFUSE_FACTOR, s->diffuse_factor);
    put3(at, n, PT_PLANE_SPECULAR_FACTOR, s->specular_factor);
    put3(at, n, PT_PLANE_EMISSION, sanitized(s->emission));
    put3(at, n, PT_PLANE_SUN, sanitized(pt_sun_light(pt, *s)));
}

/* Mean of the paths of one lobe. The hit distance is the mean of the paths (diffuse) or the nearest one (specular). */
static pt_lobe mean_lobe(const pt_scene *pt, const pt_surface *s, uint32_t x, uint32_t y, uint32_t lobe)
{
    pt_lobe sum = { grey(0.0f), lobe == PT_LOBE_DIFFUSE ? 0.0f : PT_MISS, grey(0.0f) };
    float weight = 1.0f / (float)pt->frame.paths;
    for (uint32_t i = 0; i < pt->frame.paths; i++) {
        pt_rng rng = pt_pixel_rng(pt, x, y, PT_STREAM_FRAME, i);
        pt_lobe one = pt_trace_lobe(pt, *s, lobe, rng, pt->frame.direct_mis != 0);
        if (one.hit_dist < PT_SURFACE_EPS) one.hit_dist = 0.0f;
        sum.radiance += sanitized(one.radiance) * weight;
        sum.direction += one.direction;
        if (lobe == PT_LOBE_DIFFUSE)
            sum.hit_dist += one.hit_dist * weight;
        else if (one.hit_dist > 0.0f)
            sum.hit_dist = min(sum.hit_dist, one.hit_dist);
    }
    sum.direction = normalize(sum.direction + s->normal * 1e-6f);
    return sum;
}

static void put_lobe(float *at, size_t n, uint32_t plane, const pt_lobe *lobe, vec3 factor)
{
    put3(at, n, plane, sanitized(lobe->radiance / factor));
    at[(plane + PT_PLANE_DIFFUSE_HIT - PT_PLANE_DIFFUSE) * n] = lobe->hit_dist;
    put3(at, n, plane + PT_PLANE_DIFFUSE_DIR - PT_PLANE_DIFFUSE, lobe->direction);
}

static void render_pixel(const pt_scene *pt, uint32_t x, uint32_t y, float *planes)
{
    size_t n = plane_size(pt);
    float *at = planes + (size_t)y * pt->frame.width + x;
    vec3 direction = pt_camera_direction(pt->frame.camera, pt_pixel_uv(pt, x, y, true));
    pt_hit hit = pt_closest(pt, pt->frame.camera.position, direction);
    if (hit.triangle == PT_NO_TRIANGLE) {
        put_sky(pt, at, direction);
        return;
    }
    pt_surface s = pt_primary_surface(pt, hit, direction);
    pt_lobe diffuse = mean_lobe(pt, &s, x, y, PT_LOBE_DIFFUSE), specular = mean_lobe(pt, &s, x, y, PT_LOBE_SPECULAR);
    put_guides(pt, at, &s);
    put_lobe(at, n, PT_PLANE_DIFFUSE, &diffuse, s.diffuse_factor);
    put_lobe(at, n, PT_PLANE_SPECULAR, &specular, s.specular_factor);
    pt_shadow shadow = pt_shadow_ray(pt, s, pt_pixel_rng(pt, x, y, PT_STREAM_FRAME, 0));
    at[PT_PLANE_SHADOW_HIT * n] = shadow.hit_dist;
    put3(at, n, PT_PLANE_TRANSLUCENCY, shadow.color);
}

static void accumulate_pixel(const pt_scene *pt, uint32_t x, uint32_t y, double *sums)
{
    size_t n = plane_size(pt);
    double *at = sums + (size_t)y * pt->frame.width + x;
    vec3 direction = pt_camera_direction(pt->frame.camera, pt_pixel_uv(pt, x, y, false));
    pt_hit hit = pt_closest(pt, pt->frame.camera.position, direction);
    if (hit.triangle == PT_NO_TRIANGLE) return;
    pt_surface s = pt_primary_surface(pt, hit, direction);
    for (uint32_t i = 0; i < pt->frame.sample_count; i++) {
        pt_rng rng = pt_pixel_rng(pt, x, y, PT_STREAM_REFERENCE, pt->frame.sample_first + i);
        pt_reference r = pt_reference_sample(pt, s, rng);
        for (uint32_t c = 0; c < 3; c++) {
            at[(PT_REF_DIFFUSE + c) * n] += r.diffuse[c];
            at[(PT_REF_SPECULAR + c) * n] += r.specular[c];
            at[(PT_REF_TRANSLUCENCY + c) * n] += r.translucency[c];
        }
        at[PT_REF_SHADOW * n] += r.visibility;
        at[PT_REF_AO * n] += r.openness;
        at[PT_REF_SPECULAR_AO * n] += r.specular_openness;
    }
}

/* ---- threads: rows are handed out one by one ---- */

static uint32_t take_row(job *j)
{
    pthread_mutex_lock(&j->lock);
    uint32_t row = j->next_row++;
    pthread_mutex_unlock(&j->lock);
    return row;
}

static void *work(void *argument)
{
    job *j = argument;
    for (uint32_t y = take_row(j); y < j->scene->frame.height; y = take_row(j))
        for (uint32_t x = 0; x < j->scene->frame.width; x++) {
            if (j->planes)
                render_pixel(j->scene, x, y, j->planes);
            else
                accumulate_pixel(j->scene, x, y, j->sums);
        }
    return NULL;
}

/* The calling thread works too, so a thread that cannot be started only costs time. */
static void run(const embree_state *e, job *j)
{
    pthread_t threads[MAX_THREADS];
    int started = 0;
    pthread_mutex_init(&j->lock, NULL);
    while (started < e->threads - 1 && pthread_create(&threads[started], NULL, work, j) == 0) started++;
    work(j);
    for (int i = 0; i < started; i++) pthread_join(threads[i], NULL);
    pthread_mutex_destroy(&j->lock);
}

/* ---- the tracer ---- */

static bool embree_render(tracer *t, const pt_scene *scene, float *planes, char *error, size_t error_size)
{
    (void)error, (void)error_size;
    run(t->state, &(job){ .scene = scene, .planes = planes });
    return true;
}

static bool embree_accumulate(tracer *t, const pt_scene *scene, double *sums, char *error, size_t error_size)
{
    (void)error, (void)error_size;
    run(t->state, &(job){ .scene = scene, .sums = sums });
    return true;
}

static RTCGeometry make_geometry(RTCDevice device, const pt_scene *scene)
{
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    size_t count = scene->triangle_count;
    float *vertices =
        rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count);
    uint32_t *indices =
        rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), count);
    for (size_t i = 0; vertices && indices && i < 3 * count; i++) {
        for (int c = 0; c < 3; c++) vertices[3 * i + (size_t)c] = scene->triangles[i / 3].p[i % 3][c];
        indices[i] = (uint32_t)i;
    }
    return g;
}

static bool embree_load(tracer *t, pt_scene *scene, char *error, size_t error_size)
{
    embree_state *e = t->state;
    if (e->scene) rtcReleaseScene(e->scene);
    e->scene = rtcNewScene(e->device);
    rtcSetSceneFlags(e->scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry g = make_geometry(e->device, scene);
    rtcCommitGeometry(g);
    rtcAttachGeometry(e->scene, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(e->scene);
    scene->accel = e->scene;
    enum RTCError code = rtcGetDeviceError(e->device);
    if (code != RTC_ERROR_NONE) snprintf(error, error_size, "Embree: error %d while building the scene", (int)code);
    return code == RTC_ERROR_NONE;
}

static void embree_close(tracer *t)
{
    embree_state *e = t->state;
    if (e && e->scene) rtcReleaseScene(e->scene);
    if (e) rtcReleaseDevice(e->device);
    free(e);
    memset(t, 0, sizeof *t);
}

bool tracer_open_embree(tracer *t, int threads, char *error, size_t error_size)
{
    memset(t, 0, sizeof *t);
    if (threads < 1 || threads > MAX_THREADS) {
        snprintf(error, error_size, "threads: %d is not in [1, %d]", threads, MAX_THREADS);
        return false;
    }
    char config[32];
    snprintf(config, sizeof config, "threads=%d", threads);
    embree_state *e = calloc(1, sizeof *e);
    if (e) e->device = rtcNewDevice(config);
    if (!e || !e->device) {
        snprintf(error, error_size, "Embree: no device (error %d)", (int)rtcGetDeviceError(NULL));
        free(e);
        return false;
    }
    e->threads = threads;
    *t = (tracer){ "embree", e, embree_load, embree_render, embree_accumulate, embree_close };
    return true;
}
