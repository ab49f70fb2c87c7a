#include "report/front.h"
#include "report/output.h"
#include "report/tiles.h"
#include "report/tuning.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- terminal ---- */

static void print_number(double value, int width, int digits)
{
    if (isnan(value))
        printf(" %*s", width, "-");
    else
        printf(" %*.*g", width, digits, value);
}

static void label_of(const report_row *row, char *text, size_t size)
{
    if (!strcmp(row->kind, REPORT_KIND_DENOISER))
        snprintf(text, size, "%s %s", row->method, row->preset);
    else
        snprintf(text, size, "%s%s%s", row->kind, row->method[0] ? " for " : "", row->method);
}

static bool same_heading(const report_row *a, const report_row *b)
{
    return !strcmp(a->scene, b->scene) && a->width == b->width && a->height == b->height && report_same_paths(a->paths, b->paths);
}

void print_table(const report *r)
{
    static const report_column shown[] = { REPORT_ms, REPORT_ms_low, REPORT_ms_high, REPORT_ns_per_pixel, REPORT_copy_share, REPORT_motion_trimmed, REPORT_motion_psnr, REPORT_motion_ssim,
                                           REPORT_motion_flip, REPORT_motion_bias, REPORT_motion_flicker, REPORT_rest_trimmed, REPORT_rest_flicker,
                                           REPORT_lag, REPORT_ghost, REPORT_fireflies, REPORT_edge_trimmed, REPORT_worst_tile };
    static const char *const names[] = { "ms", "ms from", "ms to", "ns/px", "copy", "relMSE", "PSNR", "SSIM", "FLIP", "bias", "flicker", "rest", "flicker", "lag", "ghost",
                                         "fireflies", "edges", "tile" };
    printf("%s; times: median and quartiles; relMSE trimmed, in motion unless said otherwise\n", r->device);
    for (int i = 0; i < r->rows.count; i++) {
        const report_row *row = &r->rows.rows[i];
        char label[3 * REPORT_NAME];
        if (i == 0 || !same_heading(row, row - 1)) {
            printf("\n%s %dx%d, %g paths per pixel%s, times at %dx%d, traced in %.3g ms\n%-52s %-12s", row->scene, row->width, row->height, row->paths.count,
                   row->paths.checkerboard ? " (checkerboard)" : "", row->time_width, row->time_height, row->values[REPORT_trace_ms], "", "signal");
            for (size_t k = 0; k < sizeof names / sizeof *names; k++)
                printf(" %9s", names[k]);
            printf("\n");
        }
        label_of(row, label, sizeof label);
        printf("%-52s %-12s", label, row->signal);
        for (size_t k = 0; k < sizeof shown / sizeof *shown; k++)
            print_number(row->values[shown[k]], 9, 3);
        printf("\n");
    }
    front_print(r);
    tiles_print(r);
    tuning_print(r);
}

/* ---- files ---- */

FILE *output_open(report *r, const char *name, char *path, size_t size)
{
    snprintf(path, size, "%s/%s.part", r->options.folder, name);
    FILE *file = fopen(path, "w");
    if (!file)
        report_fail(r, "%s: cannot write", path);
    return file;
}

bool output_close(report *r, FILE *file, const char *path)
{
    char name[CAPTURE_PATH_SIZE];
    bool written = !ferror(file);
    snprintf(name, sizeof name, "%.*s", (int)(strlen(path) - strlen(".part")), path);
    if (fclose(file) == 0 && written && rename(path, name) == 0)
        return true;
    remove(path);
    return report_fail(r, "%s: cannot write", name);
}

bool print_csv(report *r)
{
    char path[CAPTURE_PATH_SIZE];
    FILE *file = output_open(r, "report.csv", path, sizeof path);
    if (!file)
        return false;
    fprintf(file, "device,scene,width,height,time_width,time_height,paths,checkerboard,kind,denoiser,preset,signal");
    for (int k = 0; k < REPORT_COLUMN_COUNT; k++)
        fprintf(file, ",%s", report_columns[k].name);
    fprintf(file, "\n");
    for (int i = 0; i < r->rows.count; i++) {
        const report_row *row = &r->rows.rows[i];
        fprintf(file, "\"%s\",%s,%d,%d,%d,%d,%g,%d,", r->device, row->scene, row->width, row->height, row->time_width, row->time_height, row->paths.count,
                row->paths.checkerboard);
        fprintf(file, "%s,%s,%s,%s", row->kind, row->method, row->preset, row->signal);
        for (int k = 0; k < REPORT_COLUMN_COUNT; k++)
            if (isnan(row->values[k]))
                fprintf(file, ",");
            else
                fprintf(file, ",%.9g", row->values[k]);
        fprintf(file, "\n");
    }
    return output_close(r, file, path);
}

/* ---- JSON ---- */

static void put_string(FILE *file, const char *text)
{
    fputc('"', file);
    for (; *text; text++)
        if ((unsigned char)*text < 0x20 || *text == '<')
            fprintf(file, "\\u%04x", (unsigned)*text); /* '<': no end tag within a page */
        else
            fprintf(file, *text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    fputc('"', file);
}

static void put_number(FILE *file, double value)
{
    if (isfinite(value))
        fprintf(file, "%.7g", value);
    else
        fprintf(file, "null");
}

static void put_columns(FILE *file)
{
    fprintf(file, "\"columns\":[");
    for (int k = 0; k < REPORT_COLUMN_COUNT; k++) {
        fprintf(file, "%s{\"name\":", k ? "," : "");
        put_string(file, report_columns[k].name);
        fprintf(file, ",\"unit\":");
        put_string(file, report_columns[k].unit);
        fprintf(file, ",\"text\":");
        put_string(file, report_columns[k].text);
        fprintf(file, "}");
    }
    fprintf(file, "]");
}

static void put_row(FILE *file, const report_row *row)
{
    const struct { const char *name, *value; } names[] = {
        { "scene", row->scene }, { "kind", row->kind }, { "denoiser", row->method }, { "preset", row->preset }, { "signal", row->signal },
    };
    fprintf(file, "{\"width\":%d,\"height\":%d,\"time_width\":%d,\"time_height\":%d,\"paths\":%g,\"checkerboard\":%s", row->width, row->height, row->time_width,
            row->time_height, row->paths.count, row->paths.checkerboard ? "true" : "false");
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        fprintf(file, ",\"%s\":", names[i].name);
        put_string(file, names[i].value);
    }
    for (int k = 0; k < REPORT_COLUMN_COUNT; k++) {
        fprintf(file, ",\"%s\":", report_columns[k].name);
        put_number(file, row->values[k]);
    }
    fprintf(file, ",\"passes\":[");
    for (int i = 0; i < row->pass_count; i++) {
        fprintf(file, "%s{\"name\":", i ? "," : "");
        put_string(file, row->passes[i].name);
        fprintf(file, ",\"ms\":%.6g,\"low\":%.6g,\"high\":%.6g}", row->passes[i].ms, row->passes[i].low, row->passes[i].high);
    }
    fprintf(file, "],\"curve\":[");
    for (int i = 0; i < row->curve_count; i++) {
        fprintf(file, "%s", i ? "," : "");
        put_number(file, row->curve[i]);
    }
    fprintf(file, "]}");
}

void output_json(const report *r, FILE *file)
{
    const report_options *o = &r->options;
    fprintf(file, "{\"device\":");
    put_string(file, r->device);
    fprintf(file, ",\"moving\":%d,\"still\":%d,\"stepped\":%d,\"samples\":%d,\"timed\":%d,", o->moving, o->still, o->stepped, o->samples, o->repeats);
    put_columns(file);
    fprintf(file, ",\"rows\":[");
    for (int i = 0; i < r->rows.count; i++) {
        fprintf(file, i ? ",\n" : "\n");
        put_row(file, &r->rows.rows[i]);
    }
    fprintf(file, "],\"tiles\":");
    tiles_json(r, file);
    fprintf(file, ",\"tunings\":");
    tuning_json(r, file);
    fprintf(file, "}\n");
}

bool print_json(report *r)
{
    char path[CAPTURE_PATH_SIZE];
    FILE *file = output_open(r, "report.json", path, sizeof path);
    if (!file)
        return false;
    output_json(r, file);
    return output_close(r, file, path);
}
