/* Settings, inputs, cameras, calls and files at random, within and beyond what is allowed: either an error that names what is wrong, or a
   finite picture in the range of its inputs. A case is found again by its number (--case) and --seed. */
#define _POSIX_C_SOURCE 200809L
#include "stress/stress.h"

#include "common/capture.h"
#include "common/scratch.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { CASES_PER_INSTANCE = 100, QUICK_CASES = 40, LONG_CASES = 20000, CASES_OF_DENOISER = 100000, MAX_WRONG = 64 };

/* ---- random numbers of one case */
typedef struct dice { uint32_t seed, of, thrown; } dice;

static double throw_one(dice *d) { return random_at(d->of, d->thrown++, d->seed + 0x5eed); }
static uint32_t throw_of(dice *d, uint32_t count) { return (uint32_t)(throw_one(d) * count); }
static bool throw_chance(dice *d, double chance) { return throw_one(d) < chance; }
static double throw_within(dice *d, double low, double high) { return low + (high - low) * throw_one(d); }
/* Evenly over the decades. */
static double throw_decades(dice *d, double low, double high) { return low * pow(high / low, throw_one(d)); }

/* ---- what is wrong with a case */
typedef struct wrong { const char *names[MAX_WRONG]; uint32_t count; } wrong;

static void add_wrong(wrong *w, const char *name)
{
    if (w->count < MAX_WRONG) w->names[w->count++] = name;
}

/* 0: as it must be. */
static uint32_t judge_answer(const wrong *w, nrd_result result, const char *message)
{
    bool lacks_feature = strstr(message, "nrd_desc.features") != NULL;
    if (w->count == 0) return result != NRD_RESULT_OK && !lacks_feature;
    if (result == NRD_RESULT_OK) return 1;
    for (uint32_t i = 0; i < w->count; i++)
        if (strstr(message, w->names[i])) return 0;
    return !lacks_feature;
}

/* ---- settings */
static double value_beyond(dice *d, const nrd_setting *row)
{
    double value = throw_chance(d, 0.5) || !row->is_float ? row->max + throw_decades(d, row->is_float ? 0.01 * (fabs(row->max) + 1e-3) : 1, 1e9) : row->min - throw_decades(d, 1e-3 * (fabs(row->min) + 1e-3), 1e9);
    if (row->is_float && throw_chance(d, 0.3)) value = throw_chance(d, 0.5) ? NAN : value > 0 ? INFINITY : -INFINITY;
    return value;
}

static void throw_setting(dice *d, const nrd_setting *row, void *settings, double beyond, wrong *w)
{
    double p = throw_one(d), value = row->value;
    if (p < beyond) {
        value = value_beyond(d, row);
        add_wrong(w, row->name);
    } else if (p < 0.35) value = throw_within(d, row->min, row->max);
    else if (p < 0.45 && row->max > 0) value = fmax(row->min, throw_decades(d, fmax(row->min, 1e-6 * row->max), row->max));
    else if (p < 0.5) value = row->min;
    else if (p < 0.55) value = row->max;
    if (!row->is_float) value = floor(value);
    if (row->is_float && value == value && p >= beyond) value = fmin(fmax((float)value, row->min), row->max);
    setting_put(row, settings, value);
}

static void throw_settings(dice *d, rig *r, double beyond, wrong *w)
{
    nrd_setting row;
    for (uint32_t i = 0; nrd_get_setting(r->denoiser, i, &row); i++) throw_setting(d, &row, &r->settings, beyond, w);
    for (uint32_t i = 0; nrd_get_setting(NRD_DENOISER_COUNT, i, &row); i++) {
        bool rarely = strcmp(row.name, "split_screen") == 0 || strstr(row.name, "_available") || strcmp(row.name, "restart") == 0 || strcmp(row.name, "validation") == 0;
        if (strcmp(row.name, "denoising_range") == 0 && throw_chance(d, 0.9)) r->frame.denoising_range = (float)throw_decades(d, 1e-3, 1e9);   /* else it is mostly all sky or none */
        else if (!rarely || throw_chance(d, 0.3)) throw_setting(d, &row, &r->frame, beyond, w);
    }
    if (r->frame.validation > 1) add_wrong(w, "validation");   /* there is one denoiser */
}

/* ---- camera and rectangle */
static void throw_camera(dice *d, rig *r)
{
    pose *p = &r->camera;
    for (int k = 0; k < 3; k++) p->position[k] = throw_chance(d, 0.2) ? throw_within(d, -1e7, 1e7) : throw_within(d, -3, 3);
    p->yaw = throw_within(d, -3, 3);
    p->pitch = throw_within(d, -1.5, 1.5);
    p->roll = throw_chance(d, 0.2) ? throw_within(d, -3, 3) : 0;
    p->tan_half_height = throw_decades(d, 1e-3, 100);
    p->aspect = throw_decades(d, 0.1, 10);
    p->near = throw_decades(d, 1e-5, 1);
    p->far = throw_chance(d, 0.3) ? 0 : throw_decades(d, 10, 1e6);
    p->orthographic = throw_chance(d, 0.15);
    if (p->orthographic && p->far <= 0) p->far = 100;
    p->right_handed = throw_chance(d, 0.3);
    p->reversed = throw_chance(d, 0.3);
    p->clip_y_down = throw_chance(d, 0.3);
    for (int k = 0; k < 2; k++) p->jitter[k] = throw_chance(d, 0.5) ? throw_within(d, -0.5, 0.5) : 0;
}

static void throw_rectangle(dice *d, rig *r, double beyond, wrong *w)
{
    if (throw_chance(d, 0.5)) return;
    r->rect_width = 1 + throw_of(d, r->width);
    r->rect_height = 1 + throw_of(d, r->height);
    r->origin_x = throw_of(d, r->width - r->rect_width + 1);
    r->origin_y = throw_of(d, r->height - r->rect_height + 1);
    if (!throw_chance(d, beyond)) return;
    add_wrong(w, "rect_");
    if (throw_chance(d, 0.5)) r->origin_x = r->width - r->rect_width + 1 + throw_of(d, 0x7fffffffu);
    else r->origin_y = r->height - r->rect_height + 1 + throw_of(d, 0x7fffffffu);
}

/* ---- pictures */
static surface fuzz_shape(const rig *r, uint32_t x, uint32_t y)
{
    surface s = rig_surface(r, x, y);
    dice d = { r->variant, x + 4096 * y, 0 };
    uint32_t style = r->variant % 5;
    if (style == 1) s.depth = throw_decades(&d, 1e-5, 1e7);
    if (style == 2 && throw_chance(&d, 0.3)) s.depth *= throw_within(&d, 0.9, 1.1);
    if (style == 3) for (int k = 0; k < 3; k++) s.normal[k] = throw_within(&d, -1, 1);
    if (throw_chance(&d, 0.1)) s.depth = RIG_SKY;
    s.roughness = style == 4 ? throw_one(&d) : r->roughness;
    s.material = throw_chance(&d, 0.2) ? throw_of(&d, 4) : 0;
    for (int k = 0; k < 3; k++) s.moved[k] = throw_chance(&d, 0.05) ? throw_within(&d, -1, 1) : 0;
    return s;
}

/* Bad texels anywhere in the noisy inputs, in the sky and outside of the rectangle; optional inputs of any number. */
static void throw_bad_texels(dice *d, rig *r)
{
    static const float bad[] = { NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, -1, 0, 1e-38f, 65504, 65536 };
    for (int i = 0; i < NRD_RESOURCE_COUNT; i++) {
        const char *name = nrd_resource_name((nrd_resource)i);
        if (!r->texels[i] || strncmp(name, "IN_", 3) != 0) continue;
        bool guide = i == NRD_RESOURCE_IN_MV || i == NRD_RESOURCE_IN_NORMAL_ROUGHNESS || i == NRD_RESOURCE_IN_VIEWZ;
        uint32_t count = throw_chance(d, 0.5) ? 0 : throw_of(d, 1 + r->width * r->height);
        if (guide && !throw_chance(d, 0.2)) count = 0;
        for (uint32_t k = 0; k < count; k++) r->texels[i][throw_of(d, 4 * r->width * r->height)] = bad[throw_of(d, 10)];
    }
}

static void throw_raw_normals(dice *d, rig *r)
{
    if (!r->raw_normals) r->raw_normals = (uint32_t *)calloc((size_t)r->width * r->height, sizeof *r->raw_normals);
    if (!r->raw_normals) stress_die("out of memory");
    for (uint32_t i = 0; i < r->width * r->height; i++) r->raw_normals[i] = throw_of(d, 0xffffffffu);
}

/* ---- cases */
typedef struct batch {
    watch w;              /* the worst of all cases */
    double beyond[GUARANTEE_COUNT];
    uint32_t refusals;
    char of[96], refused[96];
} batch;

/* History lengths are no light, and the split screen shows the input as it is. */
static bool shows_light(const rig *r)
{
    double lengths = 0;
    return (!settings_get(r->denoiser, &r->settings, "return_history_length_instead_of_occlusion", &lengths) || lengths == 0) && r->frame.split_screen == 0;
}

/* range: the guarantee that holds of it. */
static void judge_frame(batch *b, const watch *seen, const rig *r, guarantee range, uint32_t number)
{
    watch w = *seen;
    watch_outputs(&w, r);
    if (!shows_light(r)) w.beyond = w.colour = 0;
    b->beyond[range] = fmax(b->beyond[range], w.beyond);
    b->w.colour = fmax(b->w.colour, w.colour);
    b->w.not_finite += w.not_finite;
    b->w.touched += w.touched;
    if (w.not_finite || w.touched || w.beyond > guarantee_limit(range) || w.colour > guarantee_limit(GUARANTEE_COLOUR)) snprintf(b->of, sizeof b->of, "fuzz case %u", number);
}

static void judge_result(batch *b, const wrong *w, nrd_result result, const char *message, uint32_t number)
{
    if (!judge_answer(w, result, message)) return;
    b->refusals++;
    snprintf(b->refused, sizeof b->refused, "fuzz case %u (%.16s): %.50s", number, w->count ? w->names[0] : "", message);
}

/* Some frames of one case; what is refused must say why. */
static void run_case(rig *r, dice *d, batch *b, double beyond)
{
    watch w = watch_start();
    uint32_t frames = 1 + throw_of(d, 4);
    rig_reset(r);
    r->index = throw_of(d, 0xffffffffu);
    r->depth = throw_chance(d, 0.5) ? throw_decades(d, 1e-4, 1e6) : 10;
    r->tilt = throw_within(d, -89.9, 89.9);
    r->roughness = throw_one(d);
    r->shape = fuzz_shape;
    noise_kind noise = (noise_kind)throw_of(d, NOISE_BLUE + 1);
    double level = throw_decades(d, 1e-12, 1e12);
    guarantee range = GUARANTEE_COUNT;
    bool raw = throw_chance(d, 0.2), bad = throw_chance(d, 0.4);
    for (uint32_t frame = 0; frame < frames; frame++) {
        wrong wrongs = { { NULL }, 0 };
        if (frame == 0 || throw_chance(d, 0.3)) {
            throw_settings(d, r, beyond, &wrongs);
            if (frame == 0 && wrongs.count == 0) r->frame.restart = 1;
        }
        if (frame == 0) throw_rectangle(d, r, beyond, &wrongs);
        if (throw_chance(d, 0.5)) throw_camera(d, r);
        r->variant = throw_of(d, 1000000);
        if (wrongs.count == 0) {
            rig_put_guides(r);
            fill_noise(r, noise, level, d->of);
            if (raw && r->texels[NRD_RESOURCE_IN_NORMAL_ROUGHNESS]) throw_raw_normals(d, r);
            if (bad) throw_bad_texels(d, r);
            watch_inputs(&w, r);
            rig_upload_all(r);
        }
        nrd_result result = rig_try(r);
        judge_result(b, &wrongs, r->fault == FAULT_ACCEPTED ? NRD_RESULT_OK : result, r->message, d->of);
        if (result) return;
        rig_download(r);
        if (range != GUARANTEE_ANTILAG_RANGE) range = range_guarantee(r);   /* history that was scaled is still there when antilag is off */
        judge_frame(b, &w, r, range, d->of);
    }
}

/* Cases first .. last - 1; first: of an instance. */
static void fuzz_denoiser(stress *s, nrd_denoiser denoiser, uint32_t first, uint32_t last)
{
    batch b = { .w = watch_start() };
    snprintf(b.of, sizeof b.of, "%u fuzz cases", last - first);
    snprintf(b.refused, sizeof b.refused, "%u fuzz cases", last - first);
    for (uint32_t i = first; i < last;) {
        rig r;
        dice d = { s->seed, 1000003u * (uint32_t)denoiser + i / CASES_PER_INSTANCE, 1u << 20 };
        rig_desc desc = stress_rig(s, denoiser, 1 + throw_of(&d, 40), 1 + throw_of(&d, 30));
        desc.features = throw_chance(&d, 0.5) ? NRD_FEATURE_ALL : throw_of(&d, NRD_FEATURE_ALL + 1);
        desc.normal_encoding = throw_chance(&d, 0.5) ? 0 : throw_of(&d, 5);
        if (i == 0) desc.width = 19, desc.height = 13, desc.features = NRD_FEATURE_ALL, desc.normal_encoding = 0;
        rig_open(&r, &desc);
        for (uint32_t k = 0; k < CASES_PER_INSTANCE && i < last; k++, i++) {
            dice of_case = { s->seed, CASES_OF_DENOISER * (uint32_t)denoiser + i, 0 };
            run_case(&r, &of_case, &b, i % 3 == 0 ? 0.03 : 0);
        }
        rig_close(&r);
    }
    check(s, GUARANTEE_FINITE, b.of, denoiser, b.w.not_finite);
    for (int g = 0; g < GUARANTEE_COUNT; g++)
        if (b.beyond[g] > 0) check(s, (guarantee)g, b.of, denoiser, b.beyond[g]);
    check(s, GUARANTEE_COLOUR, b.of, denoiser, b.w.colour);
    check(s, GUARANTEE_UNTOUCHED, b.of, denoiser, b.w.touched);
    check(s, GUARANTEE_REFUSALS, b.refused, denoiser, b.refusals);
}

/* ---- calls in any order */
typedef struct caller {
    nrd_desc desc;
    nrd_denoiser_desc list[3];
    nrd *instance;
    nrd_frame frame;
    uint32_t errors, silent;   /* answers other than OK; those of them without a message */
    bool told, deaf;
} caller;

static void hear(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    (void)severity;
    (void)result;
    ((caller *)user)->told = text[0] != 0 && !((caller *)user)->deaf;
}

static void judge_call(caller *c, nrd_result result)
{
    c->errors += result != NRD_RESULT_OK;
    c->silent += (result != NRD_RESULT_OK && c->instance && !c->told) || (uint32_t)result >= NRD_RESULT_COUNT;
}

static void call_create(caller *c, dice *d)
{
    nrd *made = NULL;
    nrd_desc desc = c->desc;
    desc.width = throw_chance(d, 0.9) ? 1 + throw_of(d, 64) : throw_of(d, 0xffffffffu);
    desc.height = throw_chance(d, 0.9) ? 1 + throw_of(d, 64) : 0;
    desc.denoiser_count = throw_chance(d, 0.9) ? 1 + throw_of(d, 3) : throw_of(d, 2) * 65;
    desc.features = throw_chance(d, 0.9) ? throw_of(d, NRD_FEATURE_ALL + 1) : throw_of(d, 0xffffffffu);
    desc.normal_encoding = throw_of(d, 6);
    desc.absent = throw_chance(d, 0.7) ? 0 : throw_of(d, NRD_ABSENT_ALL + 2);
    if (throw_chance(d, 0.05)) desc.denoisers = NULL;
    for (uint32_t i = 0; i < 3; i++) {
        c->list[i].identifier = throw_of(d, 5);
        c->list[i].denoiser = (nrd_denoiser)throw_of(d, NRD_DENOISER_COUNT + (throw_chance(d, 0.05) ? 5 : 0));
    }
    nrd_result result = nrd_create(&desc, throw_chance(d, 0.05) ? NULL : &made);
    c->silent += (result == NRD_RESULT_OK) != (made != NULL);
    judge_call(c, result);
    if (!made) return;
    nrd_destroy(c->instance);
    c->instance = made;
}

static void call_resize(caller *c, dice *d)
{
    judge_call(c, nrd_resize(c->instance, throw_chance(d, 0.8) ? 1 + throw_of(d, 64) : throw_of(d, 0xffffffffu), 1 + throw_of(d, 64)));
}

static void call_cancel(caller *c, dice *d)
{
    if (throw_chance(d, 0.5)) nrd_cancel_dispatches(c->instance);
}

static void call_destroy(caller *c, dice *d)
{
    if (throw_chance(d, 0.8)) return;
    nrd_destroy(c->instance);
    c->instance = NULL;
}

static void call_set_frame(caller *c, dice *d)
{
    pose p = pose_at(throw_one(d), 0, 0);
    c->frame.camera = pose_camera(&p);
    c->frame.frame_index += throw_of(d, 3);
    c->frame.rect_width = throw_chance(d, 0.5) ? 0 : throw_of(d, 80);
    c->frame.split_screen = throw_chance(d, 0.2) ? (float)throw_within(d, -0.5, 1.5) : 0;
    if (throw_chance(d, 0.1)) c->frame.camera.world_to_view[throw_of(d, 16)] = throw_chance(d, 0.5) ? NAN : 3;
    judge_call(c, nrd_set_frame(c->instance, throw_chance(d, 0.05) ? NULL : &c->frame));
}

static void call_set_settings(caller *c, dice *d)
{
    any_settings settings;
    wrong ignored = { { NULL }, 0 };
    nrd_setting row;
    uint32_t identifier = throw_of(d, 6);
    nrd_denoiser of = NRD_DENOISER_COUNT;
    for (uint32_t i = 0; c->instance && i < nrd_get_info(c->instance)->denoiser_count; i++)
        if (nrd_get_info(c->instance)->denoisers[i].identifier == identifier) of = nrd_get_info(c->instance)->denoisers[i].denoiser;
    memset(&settings, 0, sizeof settings);
    if (of != NRD_DENOISER_COUNT) nrd_settings_defaults(of, &settings);
    for (uint32_t i = 0; of != NRD_DENOISER_COUNT && nrd_get_setting(of, i, &row); i++) throw_setting(d, &row, &settings, 0.02, &ignored);
    judge_call(c, nrd_set_settings(c->instance, identifier, throw_chance(d, 0.05) ? NULL : &settings));
}

static void call_get_dispatches(caller *c, dice *d)
{
    const nrd_dispatch *dispatches = NULL;
    uint32_t count = 0, identifiers[3];
    for (int i = 0; i < 3; i++) identifiers[i] = throw_of(d, 6);
    const uint32_t *given = throw_chance(d, 0.5) ? NULL : identifiers;
    nrd_result result = nrd_get_dispatches(c->instance, given, given || throw_chance(d, 0.05) ? throw_of(d, 4) : 0, throw_chance(d, 0.02) ? NULL : &dispatches, &count);
    judge_call(c, result);
    const nrd_info *info = nrd_get_info(c->instance);
    for (uint32_t i = 0; result == NRD_RESULT_OK && i < count; i++)
        for (uint32_t b = 0; b < dispatches[i].binding_count; b++)
            c->silent += dispatches[i].bindings[b].resource == NRD_RESOURCE_INTERNAL && dispatches[i].bindings[b].texture >= info->texture_count;
}

/* Any call after any other, with an instance or without: an answer out of the list, and a message wherever there is an instance. */
static void fuzz_calls(stress *s, uint32_t calls)
{
    static void (*const any[])(caller *, dice *) = { call_create, call_destroy, call_set_frame, call_set_settings, call_resize, call_get_dispatches, call_cancel, call_get_dispatches };
    dice d = { s->seed, 0xca11, 0 };
    caller c;
    memset(&c, 0, sizeof c);
    c.desc.denoisers = c.list;
    c.desc.message = hear;
    c.desc.message_user = &c;
    c.frame = nrd_frame_defaults();
    c.deaf = s->fault == FAULT_ACCEPTED;
    for (uint32_t i = 0; i < calls; i++) {
        c.told = false;
        any[throw_of(&d, sizeof any / sizeof any[0])](&c, &d);
    }
    nrd_destroy(c.instance);
    if (c.errors < calls / 20) stress_die("the calls at random provoke too few errors to tell anything: %u of %u", c.errors, calls);
    check(s, GUARANTEE_REFUSALS, "calls in any order", s->first, c.silent);
}

/* ---- damaged captures */
static void write_bytes(const char *path, const unsigned char *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    bool ok = file && fwrite(bytes, 1, size, file) == size;
    if (file) ok = fclose(file) == 0 && ok;
    if (!ok) stress_die("%s cannot be written", path);
}

static unsigned char *read_bytes(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    unsigned char *bytes = (unsigned char *)malloc(1 << 20);
    if (!file || !bytes) stress_die("%s cannot be read", path);
    *size = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    return bytes;
}

static void write_sample(const char *path)
{
    capture c;
    char error[256] = "";
    bool ok = capture_create(&c, 19, 7);
    const char *const names[] = { "diffuse.R", "diffuse.G", "diffuse.B", "diffuse.hitT", "viewZ", "motion.X" };
    for (size_t i = 0; ok && i < sizeof names / sizeof names[0]; i++) {
        float *plane = capture_add_plane(&c, names[i], i % 2 ? CAPTURE_HALF : CAPTURE_FLOAT);
        for (uint32_t k = 0; plane && k < 19 * 7; k++) plane[k] = (float)random_at(k, (uint32_t)i, 3);
        ok = plane != NULL;
    }
    c.present = (1 << CAPTURE_ATTRIBUTE_COUNT) - 1;
    if (!ok || !capture_write(path, &c, error, sizeof error)) stress_die("a capture could not be made: %s", error);
    capture_destroy(&c);
}

/* Cut off, some bytes other ones, a block twice or gone: refused with one line that names the file, or read. */
static size_t damage(dice *d, unsigned char *bytes, size_t size)
{
    uint32_t flips = throw_of(d, 3) ? throw_of(d, 12) : 0;
    for (uint32_t i = 0; i < flips; i++) bytes[throw_of(d, (uint32_t)(throw_chance(d, 0.5) ? size : size < 800 ? size : 800))] = (unsigned char)throw_of(d, 256);
    if (throw_chance(d, 0.3)) {
        size_t from = throw_of(d, (uint32_t)size), to = throw_of(d, (uint32_t)size), count = throw_of(d, 64);
        if (from + count < size && to + count < size) memmove(bytes + to, bytes + from, count);
    }
    return flips && throw_chance(d, 0.7) ? size : throw_of(d, (uint32_t)size);
}

static void fuzz_files(stress *s, uint32_t files)
{
    char folder[SCRATCH_SIZE], path[SCRATCH_SIZE + 16], error[512];
    size_t size;
    uint32_t nameless = 0, refused = 0;
    if (!scratch_make(folder)) stress_die("a folder for captures cannot be made");
    snprintf(path, sizeof path, "%s/frame.exr", folder);
    write_sample(path);
    unsigned char *whole = read_bytes(path, &size), *bytes = (unsigned char *)malloc(size);
    for (uint32_t i = 0; bytes && i < files; i++) {
        capture c;
        dice d = { s->seed, i, 0xf11e };
        memcpy(bytes, whole, size);
        write_bytes(path, bytes, damage(&d, bytes, size));
        error[0] = 0;
        if (capture_read(path, &c, error, sizeof error)) { capture_destroy(&c); continue; }
        refused++;
        nameless += !strstr(error, "frame.exr") || strchr(error, '\n') || s->fault == FAULT_ACCEPTED;
    }
    scratch_remove(folder);
    free(whole);
    free(bytes);
    if (refused < files / 4) stress_die("only %u of %u damaged files were refused: the damage tells nothing", refused, files);
    check(s, GUARANTEE_REFUSALS, "damaged captures", s->first, nameless);
}

/* One case by its number, and those before it on the same instance, whose images it inherits. */
static void fuzz_one(stress *s)
{
    uint32_t denoiser = s->one_case / CASES_OF_DENOISER, i = s->one_case % CASES_OF_DENOISER;
    if (denoiser >= NRD_DENOISER_COUNT) stress_die("there is no case %u: %u denoisers of %u cases", s->one_case, (uint32_t)NRD_DENOISER_COUNT, (uint32_t)CASES_OF_DENOISER);
    fuzz_denoiser(s, (nrd_denoiser)denoiser, i - i % CASES_PER_INSTANCE, i + 1);
}

void stress_fuzz(stress *s)
{
    if (s->one_case) {
        fuzz_one(s);
        return;
    }
    uint32_t count = (uint32_t)s->last - (uint32_t)s->first + 1, cases = s->cases ? s->cases : s->everything ? LONG_CASES : QUICK_CASES * count;
    fuzz_calls(s, 10 * cases);
    fuzz_files(s, cases / 4 + 20);
    for (int d = (int)s->first; d <= (int)s->last; d++) fuzz_denoiser(s, (nrd_denoiser)d, 0, (cases + count - 1) / count);
}
