#define _POSIX_C_SOURCE 200809L
#include "report/tuning.h"

#include <string.h>
#include <sys/stat.h>

static const char *const terms[] = {
#define TUNING_TERM(name) name,
    TUNING_TERM_LIST(TUNING_TERM)
#undef TUNING_TERM
};

/* ---- files: a line per fact, then `end` ---- */

static void path_of(const report *r, const char *denoiser, char *path, size_t size)
{
    snprintf(path, size, "%s/tuning/%s.txt", r->options.folder, denoiser);
}

static void write_result(FILE *file, const tuning_result *t)
{
    fprintf(file, "searched %d %d\n", t->searched, t->tried);
    for (int i = 0; i < t->verdict_count; i++) {
        const tuning_verdict *v = &t->verdicts[i];
        fprintf(file, "verdict %s %s %.9g", v->when, v->scenes, v->objective);
        for (int k = 0; k < TUNING_TERMS; k++)
            fprintf(file, " %.9g", v->terms[k]);
        fprintf(file, "\n");
    }
    for (int i = 0; i < t->change_count; i++)
        fprintf(file, "change %s %.9g %.9g\n", t->changes[i].name, t->changes[i].before, t->changes[i].after);
    fprintf(file, "end\n");
}

bool tuning_save(report *r, const tuning_result *t)
{
    char path[CAPTURE_PATH_SIZE], part[CAPTURE_PATH_SIZE + 8];
    snprintf(path, sizeof path, "%s/tuning", r->options.folder);
    mkdir(path, 0777);
    path_of(r, t->denoiser, path, sizeof path);
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, "w");
    if (!file)
        return report_fail(r, "%s: cannot write", part);
    write_result(file, t);
    bool written = !ferror(file);
    if (fclose(file) == 0 && written && rename(part, path) == 0)
        return true;
    remove(part);
    return report_fail(r, "%s: cannot write", path);
}

static bool take_verdict(tuning_result *t, const char *text)
{
    tuning_verdict *v = &t->verdicts[t->verdict_count];
    double *x = v->terms;
    if (t->verdict_count == TUNING_MAX_VERDICTS
        || sscanf(text, "%15s %255s %lf %lf %lf %lf %lf %lf %lf", v->when, v->scenes, &v->objective, &x[0], &x[1], &x[2], &x[3], &x[4], &x[5]) != 3 + TUNING_TERMS)
        return false;
    t->verdict_count++;
    return true;
}

static bool take_change(tuning_result *t, const char *text)
{
    tuning_change *c = &t->changes[t->change_count];
    if (t->change_count == TUNING_MAX_CHANGES || sscanf(text, "%63s %lf %lf", c->name, &c->before, &c->after) != 3)
        return false;
    t->change_count++;
    return true;
}

static bool take_line(tuning_result *t, const char *line)
{
    if (!strncmp(line, "verdict ", 8)) return take_verdict(t, line + 8);
    if (!strncmp(line, "change ", 7)) return take_change(t, line + 7);
    return sscanf(line, "searched %d %d", &t->searched, &t->tried) == 2;
}

bool tuning_load(const report *r, const char *denoiser, tuning_result *out)
{
    char path[CAPTURE_PATH_SIZE], line[1024];
    bool ok = true, complete = false;
    memset(out, 0, sizeof *out);
    snprintf(out->denoiser, sizeof out->denoiser, "%s", denoiser);
    path_of(r, denoiser, path, sizeof path);
    FILE *file = fopen(path, "r");
    if (!file)
        return false;
    while (ok && !complete && fgets(line, sizeof line, file)) {
        complete = !strcmp(line, "end\n");
        ok = complete || take_line(out, line);
    }
    fclose(file);
    return ok && complete;
}

/* ---- forms ---- */

static void print_one(const tuning_result *t)
{
    printf("%s: %d values searched, %d tried\n", t->denoiser, t->searched, t->tried);
    for (int i = 0; i < t->verdict_count; i++) {
        const tuning_verdict *v = &t->verdicts[i];
        printf("  %-7s %-44s %11.4g", v->when, v->scenes, v->objective);
        for (int k = 0; k < TUNING_TERMS; k++)
            printf(" %18.4g", v->terms[k]);
        printf("\n");
    }
    for (int i = 0; i < t->change_count; i++)
        printf("  %s: %g -> %g\n", t->changes[i].name, t->changes[i].before, t->changes[i].after);
    if (!t->change_count)
        printf("  nothing better than the defaults\n");
}

void tuning_print(const report *r)
{
    bool any = false;
    for (uint32_t i = 0; i < r->options.denoiser_count; i++) {
        tuning_result t;
        if (!tuning_load(r, nrd_denoiser_name(r->options.denoisers[i]), &t))
            continue;
        if (!any) {
            printf("\ntuning: the first scenes were trained on, the others left out\n%-54s %11s", "", "objective");
            for (int k = 0; k < TUNING_TERMS; k++)
                printf(" %18s", terms[k]);
            printf("\n");
        }
        any = true;
        print_one(&t);
    }
}

static void put_verdict(const tuning_verdict *v, FILE *file)
{
    fprintf(file, "{\"when\":\"%s\",\"scenes\":\"%s\",\"objective\":%.6g,\"terms\":[", v->when, v->scenes, v->objective);
    for (int k = 0; k < TUNING_TERMS; k++)
        fprintf(file, "%s{\"name\":\"%s\",\"value\":%.6g}", k ? "," : "", terms[k], v->terms[k]);
    fprintf(file, "]}");
}

static void put_result(const tuning_result *t, FILE *file)
{
    fprintf(file, "{\"denoiser\":\"%s\",\"searched\":%d,\"tried\":%d,\"verdicts\":[", t->denoiser, t->searched, t->tried);
    for (int i = 0; i < t->verdict_count; i++) {
        fprintf(file, "%s", i ? "," : "");
        put_verdict(&t->verdicts[i], file);
    }
    fprintf(file, "],\"changes\":[");
    for (int i = 0; i < t->change_count; i++)
        fprintf(file, "%s{\"name\":\"%s\",\"before\":%.6g,\"after\":%.6g}", i ? "," : "", t->changes[i].name, t->changes[i].before, t->changes[i].after);
    fprintf(file, "]}");
}

void tuning_json(const report *r, FILE *file)
{
    const char *between = "";
    fprintf(file, "[");
    for (uint32_t i = 0; i < r->options.denoiser_count; i++) {
        tuning_result t;
        if (!tuning_load(r, nrd_denoiser_name(r->options.denoisers[i]), &t))
            continue;
        fprintf(file, "%s\n", between);
        put_result(&t, file);
        between = ",";
    }
    fprintf(file, "]");
}
