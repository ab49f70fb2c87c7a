#define _POSIX_C_SOURCE 200809L
#include "report/sequence.h"

#include "common/cli.h"
#include "common/pack.h"
#include "report/statistics.h"
#include "scenes/scenes.h"
#include "tracer/tracer_capture.h"
#include "tracer/tracer_vulkan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { CHUNK = 8, EXTRA_SEED = 1000, PROBES = 3 };
#define FRAMES_PER_SECOND 30.0f

/* In place of the mesh importer, so that the programs run where none is installed. */
bool scene_build_model(scene *s, const char *model, char *error, size_t error_size)
{
    (void)s;
    (void)model;
    snprintf(error, error_size, "the scene 'model' needs a mesh, which only nrd-render reads");
    return false;
}

void scene_animate_model(scene *s, float time_s)
{
    (void)s;
    (void)time_s;
}

static size_t texels_of(const sequence *s)
{
    return (size_t)s->group.size.width * (size_t)s->group.size.height;
}

int sequence_length(const report_options *o)
{
    return o->moving + o->still + o->stepped;
}

sequence_phase sequence_phase_of(const report_options *o, int frame)
{
    return frame < o->moving ? PHASE_MOTION : frame < o->moving + o->still ? PHASE_REST : PHASE_STEP;
}

/* Frames at rest share the reference of the last one in motion. */
static int reference_of(const report_options *o, int frame)
{
    return frame < o->moving ? frame : o->moving - 1;
}

bool sequence_has_reference(const report_options *o, int frame)
{
    if (frame >= o->moving)
        return true;
    for (int k = 1; k <= o->pairs; k++) {
        int last = o->moving * k / o->pairs - 1;
        if (frame == last || frame == last - 1)
            return true;
    }
    return false;
}

/* ---- posing ---- */

static void hold_still(pt_scene *p)
{
    p->frame.camera_prev = p->frame.camera;
    for (uint32_t i = 0; i < p->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            float v = p->triangles[i].prev[k][3]; /* a texture coordinate */
            p->triangles[i].prev[k] = p->triangles[i].p[k];
            p->triangles[i].prev[k][3] = v;
        }
}

static bool pose(sequence *s, int frame)
{
    const report_options *o = &s->r->options;
    bool still = frame >= o->moving;
    int pose_frame = still ? o->moving : frame; /* o->moving stands for the pose of the last frame, held still */
    if (pose_frame != s->loaded_pose) {
        s->loaded_pose = -1;
        if (!scene_pose(&s->scene, reference_of(o, frame), FRAMES_PER_SECOND, (uint32_t)s->group.size.width, (uint32_t)s->group.size.height, &s->posed))
            return report_fail(s->r, "out of memory");
        if (still)
            hold_still(&s->posed);
        if (!s->tracer.load(&s->tracer, &s->posed, s->r->error, sizeof s->r->error))
            return false;
        s->loaded_pose = pose_frame;
    }
    s->posed.frame.occlusion = s->posed.frame.hit_dist_params; /* the denoisers' defaults */
    s->posed.frame.jitter = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    s->posed.frame.frame_index = (uint32_t)frame;
    s->posed.frame.seed = 0;
    s->posed.frame.bounces = 3;
    s->posed.frame.paths = s->group.paths.count < 1 ? 1 : (uint32_t)s->group.paths.count;
    s->posed.frame.direct_mis = s->scene.def->small_lights;
    return true;
}

/* ---- references ---- */

/* Of everything that the tracer is given for the pose, and of the tracer. */
static uint64_t fingerprint_of_pose(const sequence *s)
{
    const pt_scene *p = &s->posed;
    size_t code_bytes;
    const uint32_t *code = tracer_vulkan_code(&code_bytes);
    uint64_t hash = fingerprint(FINGERPRINT_START, code, code_bytes);
    hash = fingerprint(hash, p->triangles, p->triangle_count * sizeof *p->triangles);
    hash = fingerprint(hash, p->materials, p->material_count * sizeof *p->materials);
    hash = fingerprint(hash, p->lights, p->frame.light_count * sizeof *p->lights);
    hash = fingerprint(hash, &p->frame.camera, sizeof p->frame.camera);
    hash = fingerprint(hash, &p->frame.sun_direction, offsetof(pt_frame, jitter) - offsetof(pt_frame, sun_direction));
    return fingerprint(hash, &p->frame.bounces, sizeof p->frame.bounces);
}

/* Needs the frame's pose. */
static void cache_path(const sequence *s, int frame, char *path, size_t size)
{
    snprintf(path, size, "%s/cache/%s_%dx%d_%d_%d_%016llx.ref", s->r->options.folder, s->group.scene->name, s->group.size.width, s->group.size.height,
             s->r->options.samples, frame, (unsigned long long)fingerprint_of_pose(s));
}

static bool read_cache(const sequence *s, int frame, float *planes, size_t count)
{
    char path[CAPTURE_PATH_SIZE], extra;
    cache_path(s, frame, path, sizeof path);
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    bool ok = fread(planes, sizeof *planes, count, file) == count && fread(&extra, 1, 1, file) == 0;
    fclose(file);
    return ok;
}

static bool write_cache(const sequence *s, int frame, const float *planes, size_t count)
{
    char path[CAPTURE_PATH_SIZE], part[CAPTURE_PATH_SIZE + 8];
    cache_path(s, frame, path, sizeof path);
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, "wb");
    if (!file)
        return report_fail(s->r, "%s: cannot write", part);
    bool written = fwrite(planes, sizeof *planes, count, file) == count;
    if (fclose(file) == 0 && written && rename(part, path) == 0)
        return true;
    remove(part);
    return report_fail(s->r, "%s: cannot write", path);
}

/* Adds samples first .. first + count - 1 to the sums. */
static bool accumulate(sequence *s, int first, int count)
{
    for (int done = 0; done < count; done += CHUNK) {
        s->posed.frame.sample_first = (uint32_t)(first + done);
        s->posed.frame.sample_count = (uint32_t)(count - done < CHUNK ? count - done : CHUNK);
        if (!s->tracer.accumulate(&s->tracer, &s->posed, s->sums, s->r->error, sizeof s->r->error))
            return false;
    }
    return true;
}

/* The mean of all samples of the pose, and that of the first half of them. */
static bool render_reference(sequence *s, float *planes)
{
    size_t values = PT_REF_COUNT * texels_of(s);
    int half = s->r->options.samples / 2;
    memset(s->sums, 0, values * sizeof *s->sums);
    if (!accumulate(s, 0, half))
        return false;
    for (size_t i = 0; i < values; i++)
        planes[values + i] = (float)(s->sums[i] / half);
    if (!accumulate(s, half, half))
        return false;
    for (size_t i = 0; i < values; i++)
        planes[i] = (float)(s->sums[i] / (2 * half));
    return true;
}

static bool load_references(sequence *s)
{
    const report_options *o = &s->r->options;
    size_t count = 2 * PT_REF_COUNT * texels_of(s);
    for (int frame = 0; frame < o->moving; frame++) {
        if (!sequence_has_reference(o, frame))
            continue;
        s->references[frame] = malloc(count * sizeof(float));
        if (!s->references[frame])
            return report_fail(s->r, "out of memory");
        if (!pose(s, frame))
            return false;
        if (read_cache(s, frame, s->references[frame], count))
            continue;
        if (!render_reference(s, s->references[frame]) || !write_cache(s, frame, s->references[frame], count))
            return false;
        cli_progress("references", frame + 1, o->moving);
    }
    return true;
}

bool sequence_open(sequence *s, report *r, const report_group *group, bool with_references)
{
    char folder[CAPTURE_PATH_SIZE];
    memset(s, 0, sizeof *s);
    s->r = r;
    s->group = *group;
    s->loaded_pose = -1;
    snprintf(folder, sizeof folder, "%s/cache", r->options.folder);
    mkdir(folder, 0777);
    s->planes = malloc(PT_PLANE_COUNT * texels_of(s) * sizeof *s->planes);
    s->sums = malloc(PT_REF_COUNT * texels_of(s) * sizeof *s->sums);
    if (!s->planes || !s->sums)
        return report_fail(r, "out of memory");
    return scene_open(&s->scene, group->scene, NULL, r->error, sizeof r->error)
        && tracer_open_vulkan_on(&s->tracer, &r->gpu, r->error, sizeof r->error)
        && (!with_references || load_references(s));
}

void sequence_close(sequence *s)
{
    if (s->tracer.close)
        s->tracer.close(&s->tracer);
    for (int i = 0; i < REPORT_MAX_FRAMES; i++)
        free(s->references[i]);
    free(s->planes);
    free(s->sums);
    scene_free_pose(&s->posed);
    scene_close(&s->scene);
    memset(s, 0, sizeof *s);
}

/* ---- frames ---- */

static uint32_t hash(uint32_t x)
{
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

double sequence_share(const report_group *group)
{
    double share = group->paths.checkerboard ? 2 * group->paths.count : group->paths.count;
    return share < 1 ? share : 1;
}

/* Keeps a share of the samples of one lobe, brighter by what is left out: those left out have no light and hit distance 0,
   which says that the lobe was not sampled. */
static void leave_out(sequence *s, uint32_t radiance, uint32_t hit, int frame)
{
    size_t texels = texels_of(s);
    double share = sequence_share(&s->group);
    uint32_t limit = (uint32_t)(share * 4294967295.0);
    for (size_t i = 0; i < texels; i++) {
        bool kept = hash((uint32_t)i + hash((uint32_t)frame * 2 + (hit & 1u))) < limit;
        for (uint32_t k = 0; k < 3; k++)
            s->planes[(radiance + k) * texels + i] *= kept ? (float)(1 / share) : 0.0f;
        if (!kept)
            s->planes[hit * texels + i] = 0;
    }
}

/* Pixels of the other colour show what their neighbour in the same pair has: what a picture without a denoiser would. */
static void fill_checkerboard(sequence *s, uint32_t first, uint32_t count, uint32_t color, int frame)
{
    size_t texels = texels_of(s);
    uint32_t width = (uint32_t)s->group.size.width;
    for (size_t i = 0; i < texels; i++) {
        uint32_t x = (uint32_t)(i % width), y = (uint32_t)(i / width), traced = pack_checkerboard_x(x / 2, y, (uint32_t)frame, color);
        for (uint32_t k = first; k < first + count && traced < width; k++)
            s->planes[k * texels + i] = s->planes[k * texels + i - x + traced];
    }
}

/* The diffuse lobe on the black pixels, the specular one on the white: see method_take_checkerboard. */
static void thin_out(sequence *s, int frame)
{
    if (sequence_share(&s->group) < 1) {
        leave_out(s, PT_PLANE_DIFFUSE, PT_PLANE_DIFFUSE_HIT, frame);
        leave_out(s, PT_PLANE_SPECULAR, PT_PLANE_SPECULAR_HIT, frame);
    }
    if (!s->group.paths.checkerboard)
        return;
    for (uint32_t k = 0; k < 2; k++) {
        fill_checkerboard(s, k ? PT_PLANE_SPECULAR : PT_PLANE_DIFFUSE, 3, k, frame);
        fill_checkerboard(s, k ? PT_PLANE_SPECULAR_HIT : PT_PLANE_DIFFUSE_HIT, 1, k, frame);
        fill_checkerboard(s, k ? PT_PLANE_SPECULAR_DIR : PT_PLANE_DIFFUSE_DIR, 3, k, frame);
    }
}

static void brighten(float *planes, uint32_t first, uint32_t count, size_t texels)
{
    for (size_t i = first * texels; i < (first + count) * texels; i++)
        planes[i] *= SEQUENCE_STEP;
}

static void brighten_frame(sequence *s)
{
    size_t texels = texels_of(s);
    brighten(s->planes, PT_PLANE_DIFFUSE, 3, texels);
    brighten(s->planes, PT_PLANE_SPECULAR, 3, texels);
    brighten(s->planes, PT_PLANE_EMISSION, 3, texels);
    brighten(s->planes, PT_PLANE_SUN, 3, texels);
}

static bool trace(sequence *s)
{
    return s->tracer.render(&s->tracer, &s->posed, s->planes, s->r->error, sizeof s->r->error);
}

/* Takes the traced planes into a capture. */
static bool take_frame(sequence *s, int frame, capture *out)
{
    if (sequence_phase_of(&s->r->options, frame) == PHASE_STEP)
        brighten_frame(s);
    if (!capture_create(out, s->group.size.width, s->group.size.height)
        || !tracer_fill_capture(out, &s->posed.frame, FRAMES_PER_SECOND, s->scene.def, s->planes))
        return report_fail(s->r, "out of memory");
    for (int k = 0; k < 4; k++)
        out->occlusion[k] = s->posed.frame.occlusion[k];
    return true;
}

static bool add_reference(sequence *s, int frame, capture *out)
{
    size_t texels = texels_of(s), values = PT_REF_COUNT * texels;
    memcpy(s->planes, s->references[reference_of(&s->r->options, frame)], values * sizeof *s->planes);
    if (sequence_phase_of(&s->r->options, frame) == PHASE_STEP) {
        brighten(s->planes, PT_REF_DIFFUSE, 3, texels);
        brighten(s->planes, PT_REF_SPECULAR, 3, texels);
    }
    return tracer_fill_reference(out, s->scene.def, s->planes) || report_fail(s->r, "out of memory");
}

bool sequence_frame(sequence *s, int frame, capture *out)
{
    memset(out, 0, sizeof *out);
    if (!pose(s, frame) || !trace(s))
        return false;
    thin_out(s, frame);
    if (!take_frame(s, frame, out))
        return false;
    out->cut = frame == 0;
    return !s->references[reference_of(&s->r->options, frame)] || add_reference(s, frame, out);
}

bool sequence_extra(sequence *s, int frame, int number, capture *out)
{
    memset(out, 0, sizeof *out);
    if (!pose(s, frame))
        return false;
    s->posed.frame.seed = (uint32_t)(EXTRA_SEED + number);
    s->posed.frame.paths = 1;
    return trace(s) && take_frame(s, frame, out);
}

bool sequence_noise(sequence *s, capture *half, capture *whole)
{
    size_t values = PT_REF_COUNT * texels_of(s);
    const float *planes = s->references[s->r->options.moving - 1];
    capture *both[2] = { whole, half };
    memset(half, 0, sizeof *half);
    memset(whole, 0, sizeof *whole);
    for (int k = 0; k < 2; k++)
        if (!capture_create(both[k], s->group.size.width, s->group.size.height)
            || !tracer_fill_reference(both[k], s->scene.def, planes + (size_t)k * values))
            return report_fail(s->r, "out of memory");
    return true;
}

bool sequence_trace_ms(sequence *s, int paths, double *out)
{
    double times[PROBES];
    if (!pose(s, 0))
        return false;
    s->posed.frame.paths = (uint32_t)paths;
    for (int i = 0; i < PROBES; i++) {
        if (!trace(s))
            return false;
        times[i] = tracer_vulkan_ms(&s->tracer);
    }
    *out = quantile(times, PROBES, 0.5);
    return true;
}
