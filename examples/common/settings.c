#include "common/settings.h"

#include "common/cli.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Finds a setting of an owner; `length` bytes of `name`. */
static bool find(nrd_denoiser owner, const char *name, size_t length, nrd_setting *out)
{
    for (uint32_t i = 0; nrd_get_setting(owner, i, out); i++)
        if (strlen(out->name) == length && !strncmp(out->name, name, length))
            return true;
    return false;
}

static bool find_anywhere(const nrd_denoiser *denoisers, uint32_t count, const char *name, size_t length, nrd_setting *out)
{
    for (uint32_t i = 0; i < count; i++)
        if (find(denoisers[i], name, length, out))
            return true;
    return find(SETTINGS_OF_FRAME, name, length, out);
}

/* Splits DENOISER. off the front of a name. */
static const char *split_owner(const char *text, const char *end, const nrd_denoiser *denoisers, uint32_t count, setting_value *out)
{
    const char *dot = memchr(text, '.', (size_t)(end - text));
    for (uint32_t i = 0; dot && i < count; i++) {
        const char *name = nrd_denoiser_name(denoisers[i]);
        if (strlen(name) == (size_t)(dot - text) && !strncmp(name, text, (size_t)(dot - text))) {
            out->only_one = true;
            out->denoiser = denoisers[i];
            return dot + 1;
        }
    }
    return text;
}

bool setting_parse(const char *text, const nrd_denoiser *denoisers, uint32_t count, setting_value *out, char *error, size_t error_size)
{
    const char *equals = strchr(text, '=');
    setting_value value = { NULL, false, SETTINGS_OF_FRAME, 0 };
    nrd_setting row;
    if (!equals || equals == text) {
        snprintf(error, error_size, "setting %s is not of the form KEY=VALUE", text);
        return false;
    }
    const char *name = split_owner(text, equals, denoisers, count, &value);
    size_t length = (size_t)(equals - name);
    bool found = value.only_one ? find(value.denoiser, name, length, &row) : find_anywhere(denoisers, count, name, length, &row);
    if (!found) {
        snprintf(error, error_size, "unknown setting %.*s; --info lists those of a denoiser", (int)(equals - text), text);
        return false;
    }
    bool number = cli_number(equals + 1, &value.value);
    if (!number || value.value < row.min || value.value > row.max || (!row.is_float && value.value != floor(value.value))) {
        snprintf(error, error_size, "setting %s is %s, allowed is %s%g..%g%s%s", row.name, equals + 1,
                 row.is_float ? "" : "a whole number in ", row.min, row.max, row.unit[0] ? " " : "", row.unit);
        return false;
    }
    value.name = row.name;
    *out = value;
    return true;
}

static bool concerns(const setting_value *value, nrd_denoiser owner, const char *name)
{
    return !strcmp(value->name, name) && (!value->only_one || value->denoiser == owner);
}

bool setting_given(const setting_value *values, uint32_t count, nrd_denoiser owner, const char *name)
{
    for (uint32_t i = 0; i < count; i++)
        if (concerns(&values[i], owner, name))
            return true;
    return false;
}

void setting_put(const nrd_setting *row, void *settings, double value)
{
    float as_float = (float)value;
    uint32_t as_uint = (uint32_t)value;
    memcpy((char *)settings + row->offset, row->is_float ? (const void *)&as_float : (const void *)&as_uint, 4);
}

static double load(const nrd_setting *row, const void *settings)
{
    float as_float;
    uint32_t as_uint;
    memcpy(&as_float, (const char *)settings + row->offset, 4);
    memcpy(&as_uint, (const char *)settings + row->offset, 4);
    return row->is_float ? (double)as_float : (double)as_uint;
}

void settings_apply(const setting_value *values, uint32_t count, nrd_denoiser owner, double metres_per_unit, void *settings)
{
    nrd_setting row;
    for (uint32_t i = 0; nrd_get_setting(owner, i, &row); i++) {
        if (owner != SETTINGS_OF_FRAME && !strcmp(row.unit, "units"))
            setting_put(&row, settings, load(&row, settings) / metres_per_unit);
        for (uint32_t k = 0; k < count; k++)
            if (concerns(&values[k], owner, row.name))
                setting_put(&row, settings, values[k].value);
    }
}

bool settings_get(nrd_denoiser owner, const void *settings, const char *name, double *out)
{
    nrd_setting row;
    if (!find(owner, name, strlen(name), &row))
        return false;
    *out = load(&row, settings);
    return true;
}

static uint32_t find_absence(const char *name, size_t length)
{
    for (uint32_t i = 0; nrd_absence_name(i); i++)
        if (strlen(nrd_absence_name(i)) == length && !strncmp(nrd_absence_name(i), name, length))
            return 1u << i;
    return 0;
}

bool settings_parse_absences(const char *text, uint32_t *bits)
{
    for (uint32_t all = 0;;) {
        size_t length = strcspn(text, ",");
        uint32_t bit = find_absence(text, length);
        if (!bit)
            return false;
        all |= bit;
        if (!text[length]) {
            *bits = all;
            return true;
        }
        text += length + 1;
    }
}
