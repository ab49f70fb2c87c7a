#include "report/crops.h"
#include "report/output.h"
#include "report_page.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Replaced in page.html by the report's JSON and by the pictures. */
#define DATA_MARK "/*DATA*/null"
#define PICTURES_MARK "/*PICTURES*/{}"

static void put_base64(FILE *out, FILE *in)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned char b[3];
    for (size_t n; (n = fread(b, 1, 3, in)) > 0;) {
        for (size_t i = n; i < 3; i++)
            b[i] = 0;
        fputc(digits[b[0] >> 2], out);
        fputc(digits[(b[0] & 3) << 4 | b[1] >> 4], out);
        fputc(n > 1 ? digits[(b[1] & 15) << 2 | b[2] >> 6] : '=', out);
        fputc(n > 2 ? digits[b[2] & 63] : '=', out);
    }
}

/* Adds "scene-owner-signal-kind": data, where that picture has been taken. */
static bool put_picture(const report *r, const report_row *row, const char *kind, bool first, FILE *out)
{
    char path[CAPTURE_PATH_SIZE];
    crops_path(&r->options, row->scene, row->method, row->signal, kind, path, sizeof path);
    FILE *in = fopen(path, "rb");
    if (!in)
        return false;
    fprintf(out, "%s\n\"%s-%s-%s-%s\":\"data:image/png;base64,", first ? "" : ",", row->scene, crops_owner(row->method, kind), row->signal, kind);
    put_base64(out, in);
    fprintf(out, "\"");
    fclose(in);
    return true;
}

static bool is_first_of_picture(const report *r, int index, const char *kind)
{
    const report_row *row = &r->rows.rows[index];
    for (int i = 0; i < index; i++) {
        const report_row *other = &r->rows.rows[i];
        bool same_owner = !strcmp(crops_owner(other->method, kind), crops_owner(row->method, kind));
        if (!strcmp(other->kind, row->kind) && !strcmp(other->scene, row->scene) && same_owner && !strcmp(other->signal, row->signal))
            return false;
    }
    return !strcmp(row->kind, REPORT_KIND_DENOISER);
}

static void put_pictures(const report *r, FILE *out)
{
    static const char *const kinds[] = {
#define CROPS_NAME(name) #name,
        CROPS_KINDS(CROPS_NAME)
#undef CROPS_NAME
    };
    bool first = true;
    fprintf(out, "{");
    for (int i = 0; i < r->rows.count; i++)
        for (int k = 0; k < 4; k++)
            if (is_first_of_picture(r, i, kinds[k]) && put_picture(r, &r->rows.rows[i], kinds[k], first, out))
                first = false;
    fprintf(out, "}");
}

bool print_page(report *r)
{
    char path[CAPTURE_PATH_SIZE];
    const char *page = (const char *)report_page, *data = strstr(page, DATA_MARK), *pictures = strstr(page, PICTURES_MARK);
    FILE *file = output_open(r, "report.html", path, sizeof path);
    if (!file)
        return false;
    fwrite(page, 1, (size_t)(data - page), file);
    output_json(r, file);
    data += strlen(DATA_MARK);
    fwrite(data, 1, (size_t)(pictures - data), file);
    put_pictures(r, file);
    fputs(pictures + strlen(PICTURES_MARK), file);
    return output_close(r, file, path);
}
