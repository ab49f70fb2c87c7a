/* png.h: writes pictures. Link with libpng. */
#ifndef EXAMPLES_PNG_H
#define EXAMPLES_PNG_H

#include <stdbool.h>
#include <stddef.h>

/* Writes width * height RGB triples, row 0 on top, values as shown (sRGB). First to PATH.part, then renamed: a failure
   leaves no partial file. False with one line, "FILE: cause", in `error`. */
bool write_png(const char *path, int width, int height, const unsigned char *rgb, char *error, size_t error_size);

#endif
