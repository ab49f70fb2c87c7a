#define _POSIX_C_SOURCE 200809L
#include "report/report.h"

#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

const report_column_info report_columns[REPORT_COLUMN_COUNT] = {
#define REPORT_COLUMN(name, unit, text) { #name, unit, text },
    REPORT_COLUMNS(REPORT_COLUMN)
#undef REPORT_COLUMN
};

bool report_fail(report *r, const char *format, ...)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    va_list arguments;
    va_start(arguments, format);
    pthread_mutex_lock(&lock);
    vsnprintf(r->error, sizeof r->error, format, arguments);
    pthread_mutex_unlock(&lock);
    va_end(arguments);
    return false;
}

report_paths report_usual_paths(const report_options *o)
{
    report_paths nearest = o->paths[0];
    for (int i = 1; i < o->path_count; i++)
        if (fabs(log(o->paths[i].count)) < fabs(log(nearest.count)))
            nearest = o->paths[i];
    return nearest;
}

bool report_same_paths(report_paths a, report_paths b)
{
    return a.count == b.count && a.checkerboard == b.checkerboard;
}

report_row *rows_add(report_rows *rows)
{
    if (rows->count == rows->capacity) {
        int capacity = rows->capacity ? 2 * rows->capacity : 64;
        report_row *bigger = realloc(rows->rows, (size_t)capacity * sizeof *bigger);
        if (!bigger)
            return NULL;
        rows->rows = bigger;
        rows->capacity = capacity;
    }
    report_row *row = &rows->rows[rows->count++];
    memset(row, 0, sizeof *row);
    for (int i = 0; i < REPORT_COLUMN_COUNT; i++)
        row->values[i] = NAN;
    return row;
}

/* ---- files of finished groups ----
   A line per fact, "word rest": the options, then for every row `row`, its names, numbers, passes and curve, then `end`. */

static void group_path(const report *r, const report_group *group, char *path, size_t size)
{
    snprintf(path, size, "%s/parts/%s_%dx%d_%g%s.txt", r->options.folder, group->scene->name, group->size.width, group->size.height, group->paths.count,
             group->paths.checkerboard ? "c" : "");
}

/* What rows depend on beside the group: a file with another line is not ours. */
static void describe_options(const report_options *o, char *text, size_t size)
{
    int n = snprintf(text, size, "options %016llx %d %d %d %d %d %d %d %dx%d", (unsigned long long)o->program, o->moving, o->still, o->stepped, o->pairs, o->samples, o->repeats, o->device,
                     o->time_size.width, o->time_size.height);
    for (uint32_t i = 0; i < o->denoiser_count && n < (int)size; i++)
        n += snprintf(text + n, size - (size_t)n, " %s", nrd_denoiser_name(o->denoisers[i]));
    for (uint32_t i = 0; i < o->preset_count && n < (int)size; i++)
        n += snprintf(text + n, size - (size_t)n, " %s", nrd_preset_name(o->presets[i]));
    for (uint32_t i = 0; i < o->variant_count && n < (int)size; i++) {
        n += snprintf(text + n, size - (size_t)n, " %s", o->variants[i].name);
        for (uint32_t k = 0; k < o->variants[i].count && n < (int)size; k++)
            n += snprintf(text + n, size - (size_t)n, ":%s", o->variants[i].settings[k]);
    }
}

static void write_row(FILE *file, const report_row *row)
{
    fprintf(file, "row %s\nkind %s\nmethod %s\npreset %s\nsignal %s\n", row->scene, row->kind, row->method, row->preset, row->signal);
    fprintf(file, "size %d %d %d %d %.17g %d\n", row->width, row->height, row->time_width, row->time_height, row->paths.count, row->paths.checkerboard);
    for (int i = 0; i < REPORT_COLUMN_COUNT; i++)
        if (!isnan(row->values[i]))
            fprintf(file, "%s %.17g\n", report_columns[i].name, row->values[i]);
    for (int i = 0; i < row->pass_count; i++)
        fprintf(file, "pass %.17g %.17g %.17g %s\n", row->passes[i].ms, row->passes[i].low, row->passes[i].high, row->passes[i].name);
    for (int i = 0; i < row->curve_count; i++)
        fprintf(file, "curve %.17g\n", row->curve[i]);
}

bool rows_save(report *r, const report_group *group, int first)
{
    char path[CAPTURE_PATH_SIZE], part[CAPTURE_PATH_SIZE + 8], options[2048];
    snprintf(path, sizeof path, "%s/parts", r->options.folder);
    mkdir(path, 0777);
    group_path(r, group, path, sizeof path);
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, "w");
    if (!file)
        return report_fail(r, "%s: cannot write", part);
    describe_options(&r->options, options, sizeof options);
    fprintf(file, "%s\ndevice %s\n", options, r->device);
    for (int i = first; i < r->rows.count; i++)
        write_row(file, &r->rows.rows[i]);
    fprintf(file, "end\n");
    bool written = !ferror(file);
    if (fclose(file) == 0 && written && rename(part, path) == 0)
        return true;
    remove(part);
    return report_fail(r, "%s: cannot write", path);
}

static bool take_name(char *out, const char *value)
{
    return snprintf(out, REPORT_NAME, "%s", value) < REPORT_NAME;
}

static bool take_pass(report_row *row, const char *value)
{
    report_pass *pass = &row->passes[row->pass_count];
    int at = 0;
    if (row->pass_count == REPORT_MAX_PASSES || sscanf(value, "%lf %lf %lf %n", &pass->ms, &pass->low, &pass->high, &at) < 3 || !at)
        return false;
    row->pass_count++;
    return take_name(pass->name, value + at);
}

static bool take_size(report_row *row, const char *value)
{
    int checkerboard;
    bool ok = sscanf(value, "%d %d %d %d %lf %d", &row->width, &row->height, &row->time_width, &row->time_height, &row->paths.count, &checkerboard) == 6;
    row->paths.checkerboard = ok && checkerboard;
    return ok;
}

static bool take_value(report_row *row, const char *word, const char *value)
{
    for (int i = 0; i < REPORT_COLUMN_COUNT; i++)
        if (!strcmp(report_columns[i].name, word))
            return sscanf(value, "%lf", &row->values[i]) == 1;
    return false;
}

static bool take_line(report *r, report_row **row, const char *word, const char *value)
{
    if (!strcmp(word, "row"))
        return (*row = rows_add(&r->rows)) && take_name((*row)->scene, value);
    if (!*row)
        return !strcmp(word, "device") && snprintf(r->device, sizeof r->device, "%s", value) >= 0;
    if (!strcmp(word, "kind")) return take_name((*row)->kind, value);
    if (!strcmp(word, "method")) return take_name((*row)->method, value);
    if (!strcmp(word, "preset")) return take_name((*row)->preset, value);
    if (!strcmp(word, "signal")) return take_name((*row)->signal, value);
    if (!strcmp(word, "size")) return take_size(*row, value);
    if (!strcmp(word, "pass")) return take_pass(*row, value);
    if (!strcmp(word, "curve"))
        return (*row)->curve_count < REPORT_MAX_FRAMES && sscanf(value, "%lf", &(*row)->curve[(*row)->curve_count++]) == 1;
    return take_value(*row, word, value);
}

bool rows_load(report *r, const report_group *group)
{
    char path[CAPTURE_PATH_SIZE], line[2048], options[2048];
    int first = r->rows.count;
    bool ok, complete = false;
    report_row *row = NULL;
    group_path(r, group, path, sizeof path);
    FILE *file = fopen(path, "r");
    if (!file)
        return false;
    describe_options(&r->options, options, sizeof options);
    ok = fgets(line, sizeof line, file) && !strncmp(line, options, strlen(options)) && line[strlen(options)] == '\n';
    while (ok && !complete && fgets(line, sizeof line, file)) {
        line[strcspn(line, "\n")] = 0;
        char *value = strchr(line, ' ');
        complete = !strcmp(line, "end");
        if (value)
            *value++ = 0;
        ok = complete || take_line(r, &row, line, value ? value : "");
    }
    fclose(file);
    if (ok && complete)
        return true;
    r->rows.count = first;
    return false;
}
