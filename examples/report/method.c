#include "report/method.h"

#include "report/statistics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- settings ---- */

static void add_setting(method *m, const nrd_setting *row, double value)
{
    if (m->setting_count < METHOD_MAX_SETTINGS)
        m->settings[m->setting_count++] = (setting_value){ row->name, true, m->denoiser, value };
}

static bool add_preset(method *m, nrd_preset preset)
{
    size_t size = nrd_settings_size(m->denoiser);
    void *chosen = malloc(size), *defaults = malloc(size);
    nrd_setting row;
    for (uint32_t i = 0; chosen && defaults && nrd_get_setting(m->denoiser, i, &row); i++) {
        double value = 0, usual = 0;
        if (i == 0) {
            nrd_settings_preset(m->denoiser, preset, chosen);
            nrd_settings_defaults(m->denoiser, defaults);
        }
        settings_get(m->denoiser, chosen, row.name, &value);
        settings_get(m->denoiser, defaults, row.name, &usual);
        if (value != usual)
            add_setting(m, &row, value);
    }
    bool ok = chosen && defaults;
    free(chosen);
    free(defaults);
    return ok;
}

/* Of the settings of a variant, those that the denoiser has. */
static bool add_variant(report *r, method *m, const report_variant *variant)
{
    for (uint32_t i = 0; i < variant->count; i++) {
        char reason[REPORT_ERROR];
        setting_value value;
        bool known = setting_parse(variant->settings[i], r->options.denoisers, r->options.denoiser_count, &value, reason, sizeof reason);
        if (!known)
            return report_fail(r, "variant %s: %s", variant->name, reason);
        double unused;
        void *defaults = malloc(nrd_settings_size(m->denoiser));
        if (!defaults)
            return report_fail(r, "out of memory");
        nrd_settings_defaults(m->denoiser, defaults);
        if (settings_get(m->denoiser, defaults, value.name, &unused) && (!value.only_one || value.denoiser == m->denoiser))
            m->settings[m->setting_count++] = value;
        free(defaults);
    }
    return true;
}

bool method_describe(report *r, nrd_denoiser denoiser, nrd_preset preset, const report_variant *variant, method *out)
{
    memset(out, 0, sizeof *out);
    out->denoiser = denoiser;
    snprintf(out->preset, sizeof out->preset, "%s", variant ? variant->name : nrd_preset_name(preset));
    if (variant ? !add_variant(r, out, variant) : !add_preset(out, preset))
        return r->error[0] ? false : report_fail(r, "out of memory");
    out->is_default = !variant && preset == NRD_PRESET_BALANCED;
    return true;
}

/* The method may have been copied since it was described. */
static void fill_desc(method *m, gpu *device)
{
    m->desc.denoisers[0] = m->denoiser;
    m->desc.denoiser_count = 1;
    m->desc.settings = m->settings;
    m->desc.setting_count = m->setting_count;
    m->desc.device = device;
}

static bool takes(const method *m, const capture *first, nrd_resource resource)
{
    method copy = *m;
    denoise_sink sink = { NULL, 0 };
    fill_desc(&copy, NULL);
    nrd *instance = denoise_make_instance(&copy.desc, first, &sink);
    bool takes = instance && nrd_uses_resource(instance, resource);
    nrd_destroy(instance);
    return takes;
}

bool method_takes_any_signal(const method *m, const capture *first)
{
    return takes(m, first, NRD_RESOURCE_IN_SIGNAL);
}

bool method_takes_shadows(const method *m, const capture *first)
{
    return takes(m, first, NRD_RESOURCE_IN_PENUMBRA);
}

bool method_takes_one_path(const method *m, const capture *first)
{
    return takes(m, first, NRD_RESOURCE_IN_DIFF_HITDIST) || takes(m, first, NRD_RESOURCE_IN_SPEC_HITDIST)
        || takes(m, first, NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST);
}

bool method_take_checkerboard(method *m, const capture *first)
{
    static const nrd_resource halved[] = { NRD_RESOURCE_IN_DIFF_RADIANCE_HITDIST, NRD_RESOURCE_IN_SPEC_RADIANCE_HITDIST, NRD_RESOURCE_IN_DIFF_HITDIST,
                                           NRD_RESOURCE_IN_SPEC_HITDIST, NRD_RESOURCE_IN_DIFF_DIRECTION_HITDIST };
    bool any = method_takes_any_signal(m, first);
    for (size_t i = 0; i < sizeof halved / sizeof *halved && !any; i++)
        any = takes(m, first, halved[i]);
    if (any && !method_takes_any_signal(m, first) && m->setting_count + 2 <= METHOD_MAX_SETTINGS) {
        m->settings[m->setting_count++] = (setting_value){ "diffuse_checkerboard", true, m->denoiser, 1 };
        m->settings[m->setting_count++] = (setting_value){ "specular_checkerboard", true, m->denoiser, 2 };
    }
    return any;
}

bool method_fits(const method *m, const capture *first, char *reason, size_t reason_size)
{
    method copy = *m;
    fill_desc(&copy, NULL);
    return denoise_check(&copy.desc, first, "first frame", reason, reason_size);
}

/* ---- times ---- */

typedef struct timings {
    double totals[REPORT_MAX_FRAMES], passes[REPORT_MAX_PASSES][REPORT_MAX_FRAMES], copies[REPORT_MAX_FRAMES];
    int count;
} timings;

static void take(method *m, timings *t, double copy_ms)
{
    uint32_t count;
    const denoise_timing *list = denoise_timings(m->clock, &count);
    double total = 0;
    m->pass_count = count < REPORT_MAX_PASSES ? (int)count : REPORT_MAX_PASSES;
    for (int i = 0; i < m->pass_count; i++) {
        snprintf(m->passes[i].name, sizeof m->passes[i].name, "%s", list[i].pass);
        t->passes[i][t->count] = list[i].milliseconds;
        total += list[i].milliseconds;
    }
    t->copies[t->count] = copy_ms;
    t->totals[t->count++] = total;
}

static bool open_denoiser(report *r, method *m, const capture *first, capture *out)
{
    char reason[REPORT_ERROR];
    fill_desc(m, &r->gpu);
    m->index = 0;
    m->d = denoise_create(&m->desc, first, reason, sizeof reason);
    return m->d ? method_frame(r, m, first, out) : report_fail(r, "%s", reason);
}

/* ---- frames ---- */

bool method_frame(report *r, method *m, const capture *frame, capture *out)
{
    char reason[REPORT_ERROR];
    const char *name = frame->cut ? "first frame" : "frame";
    uint32_t index = m->index++;
    return (out ? denoise_frame(m->d, frame, name, index, out, reason, sizeof reason) : denoise_look(m->d, frame, name, index, reason, sizeof reason))
        || report_fail(r, "%s", reason);
}

/* `final` counts as written when all that it is made of is; occlusion that comes with light is a by-product and does not count. */
static void find_outputs(method *m, const capture *first, const capture *out)
{
    float *sun[3];
    for (int s = 0; s < SIGNAL_COUNT; s++) {
        image picture;
        m->writes[s] = s != SIGNAL_FINAL && signal_get(first, out, (signal_id)s, SOURCE_DENOISED, &picture);
        if (m->writes[s])
            image_destroy(&picture);
    }
    bool has_sun = capture_find_planes(first, "sun", "RGB", sun);
    m->writes[SIGNAL_FINAL] = m->writes[SIGNAL_DIFFUSE] && m->writes[SIGNAL_SPECULAR] && (!has_sun || m->writes[SIGNAL_SHADOW]);
    m->writes[SIGNAL_AO] &= !m->writes[SIGNAL_DIFFUSE];
    m->writes[SIGNAL_SPECULAR_AO] &= !m->writes[SIGNAL_SPECULAR];
}

bool method_open(report *r, method *m, const capture *first)
{
    capture out;
    if (!open_denoiser(r, m, first, &out))
        return false;
    find_outputs(m, first, &out);
    capture_destroy(&out);
    return true;
}

/* Another denoiser, of the frame's size, for times alone. */
static bool open_clock(report *r, method *m, const capture *frame)
{
    denoise *open = m->d;
    capture out;
    bool ok = open_denoiser(r, m, frame, &out);
    if (ok)
        capture_destroy(&out);
    m->clock = m->d;
    m->d = open;
    return ok;
}

/* The open denoiser is timed where the size is its own. */
bool method_time_start(report *r, method *m, const capture *frame)
{
    const nrd_info *info = denoise_info(m->d);
    m->timings = calloc(1, sizeof *m->timings);
    if (!m->timings)
        return report_fail(r, "out of memory");
    m->clock = m->d;
    if (((int)info->width != frame->width || (int)info->height != frame->height) && !open_clock(r, m, frame))
        return false;
    m->bytes = denoise_bytes_moved(m->clock, frame);
    return true;
}

/* A warm-up looks for the fastest way of copying, in which then all are done. */
static bool copy_as_many_bytes(method *m, copier *copies, bool warm_up, double *ms)
{
    double now;
    if (!warm_up)
        return copier_run(copies, m->copy_way, m->bytes, ms);
    *ms = INFINITY;
    for (int i = 0; i < COPIER_WAY_COUNT; i++) {
        if (!copier_run(copies, (copier_way)i, m->bytes, &now))
            return false;
        if (now < *ms) {
            *ms = now;
            m->copy_way = (copier_way)i;
        }
    }
    return true;
}

bool method_time_once(report *r, method *m, const capture *frame, copier *copies, bool counts)
{
    double copy_ms;
    char reason[REPORT_ERROR];
    if (!denoise_again(m->clock, frame, m->index++, reason, sizeof reason))
        return report_fail(r, "%s", reason);
    if (!copy_as_many_bytes(m, copies, !counts, &copy_ms))
        return report_fail(r, "%s", gpu_error(copies->g));
    if (counts)
        take(m, m->timings, copy_ms);
    return true;
}

static void close_clock(method *m)
{
    if (m->clock != m->d)
        denoise_destroy(m->clock);
    m->clock = NULL;
    free(m->timings);
    m->timings = NULL;
}

void method_time_end(method *m)
{
    m->index = 0; /* the colours of a checkerboard alternate with the number of the frame */
    timings *t = m->timings;
    m->ms = quartiles(t->totals, t->count, &m->low, &m->high);
    for (int i = 0; i < m->pass_count; i++)
        m->passes[i].ms = quartiles(t->passes[i], t->count, &m->passes[i].low, &m->passes[i].high);
    m->copy_ms = quantile(t->copies, t->count, 0.5);
    m->permanent_bytes = (double)denoise_info(m->clock)->permanent_bytes;
    m->transient_bytes = (double)denoise_info(m->clock)->transient_bytes;
    close_clock(m);
}

void method_close(method *m)
{
    close_clock(m);
    denoise_destroy(m->d);
    m->d = NULL;
}
