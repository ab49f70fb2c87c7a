#include "report/front.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool counts(const report *r, const report_row *row)
{
    const report_size *first = &r->options.sizes[0];
    return !strcmp(row->kind, REPORT_KIND_DENOISER) && strcmp(row->signal, "final") != 0 && report_same_paths(row->paths, report_usual_paths(&r->options))
        && row->width == first->width && row->height == first->height && row->values[REPORT_ms] > 0 && row->values[REPORT_motion_trimmed] > 0;
}

/* The one of that name, made when it is new; NULL when there are too many. */
static front_row *row_of(front_row *rows, int *count, const report_row *from)
{
    for (int i = 0; i < *count; i++)
        if (!strcmp(rows[i].denoiser, from->method) && !strcmp(rows[i].preset, from->preset))
            return &rows[i];
    if (*count == FRONT_MAX)
        return NULL;
    front_row *added = &rows[(*count)++];
    memset(added, 0, sizeof *added);
    memcpy(added->denoiser, from->method, sizeof added->denoiser);
    memcpy(added->preset, from->preset, sizeof added->preset);
    added->beaten_by = -1;
    return added;
}

static int by_denoiser_and_time(const void *a, const void *b)
{
    const front_row *x = a, *y = b;
    int order = strcmp(x->denoiser, y->denoiser);
    return order ? order : (x->ms > y->ms) - (x->ms < y->ms);
}

/* Better in one by more than noise, in the other not worse by more. */
static bool beats(const front_row *a, const front_row *b)
{
    bool comparable = !strcmp(a->denoiser, b->denoiser) && a->places == b->places;
    bool no_worse = a->ms <= b->ms * (1 + FRONT_NOISE) && a->error <= b->error * (1 + FRONT_NOISE);
    return comparable && no_worse && (a->ms < b->ms * (1 - FRONT_NOISE) || a->error < b->error * (1 - FRONT_NOISE));
}

int front_find(const report *r, front_row rows[FRONT_MAX])
{
    int count = 0;
    for (int i = 0; i < r->rows.count; i++) {
        const report_row *from = &r->rows.rows[i];
        front_row *to = counts(r, from) ? row_of(rows, &count, from) : NULL;
        if (!to)
            continue;
        to->ms += log(from->values[REPORT_ms]);
        to->error += log(from->values[REPORT_motion_trimmed]);
        to->places++;
    }
    for (int i = 0; i < count; i++) {
        rows[i].ms = exp(rows[i].ms / rows[i].places);
        rows[i].error = exp(rows[i].error / rows[i].places);
    }
    qsort(rows, (size_t)count, sizeof *rows, by_denoiser_and_time);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < count && rows[i].beaten_by < 0; k++)
            if (beats(&rows[k], &rows[i]))
                rows[i].beaten_by = k;
    return count;
}

void front_print(const report *r)
{
    static front_row rows[FRONT_MAX];
    int count = front_find(r, rows);
    printf("\nfront of error against time, means over scenes and signals, %g paths per pixel\n%-52s %9s %9s\n", report_usual_paths(&r->options).count, "", "ms", "relMSE");
    for (int i = 0; i < count; i++) {
        char label[2 * REPORT_NAME + 2];
        snprintf(label, sizeof label, "%.63s %.63s", rows[i].denoiser, rows[i].preset);
        printf("%-52s %9.4g %9.4g  %s%s\n", label, rows[i].ms, rows[i].error, rows[i].beaten_by < 0 ? "on the front" : "beaten by ",
               rows[i].beaten_by < 0 ? "" : rows[rows[i].beaten_by].preset);
    }
}
