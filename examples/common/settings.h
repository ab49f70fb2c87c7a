/* settings.h: settings of frames and denoisers by name, as command lines give them. Names, ranges and defaults are the
   tables of nrd.h. */
#ifndef EXAMPLES_SETTINGS_H
#define EXAMPLES_SETTINGS_H

#include "nrd.h"

/* Stands for the frame settings (nrd_frame) wherever a denoiser is asked for. */
#define SETTINGS_OF_FRAME NRD_DENOISER_COUNT

/* The settings struct of any denoiser. */
typedef union any_settings {
#define SETTINGS_MEMBER(name, text, type) type name;
    NRD_DENOISERS(SETTINGS_MEMBER)
#undef SETTINGS_MEMBER
} any_settings;

/* Writes a value into its place in a settings struct. */
void setting_put(const nrd_setting *row, void *settings, double value);

/* One KEY=VALUE. It goes to every denoiser that has a setting of this name, and to the frame if that has one; with
   KEY = DENOISER.NAME to that denoiser only. */
typedef struct setting_value {
    const char *name;     /* as in the tables */
    bool only_one;        /* `denoiser` alone */
    nrd_denoiser denoiser;
    double value;
} setting_value;

/* Parses KEY=VALUE for the given denoisers. False with one line in `error` that names the setting, the value and what is
   allowed. */
bool setting_parse(const char *text, const nrd_denoiser *denoisers, uint32_t count, setting_value *out, char *error, size_t error_size);

/* Is a setting given to this owner (a denoiser or SETTINGS_OF_FRAME)? */
bool setting_given(const setting_value *values, uint32_t count, nrd_denoiser owner, const char *name);

/* Writes what is given into the owner's settings struct. Lengths ("units") of a denoiser that are not given are divided by
   metres_per_unit: their defaults are metres. */
void settings_apply(const setting_value *values, uint32_t count, nrd_denoiser owner, double metres_per_unit, void *settings);

/* A setting by name; false when the owner has none of that name. */
bool settings_get(nrd_denoiser owner, const void *settings, const char *name, double *out);

/* Names of NRD_ABSENCES, separated by commas, as NRD_ABSENT_ bits. False when one is unknown. */
bool settings_parse_absences(const char *text, uint32_t *bits);

#endif
