#include "common/png.h"

#include <errno.h>
#include <png.h>
#include <stdio.h>
#include <string.h>

bool write_png(const char *path, int width, int height, const unsigned char *rgb, char *error, size_t error_size)
{
    png_image picture;
    char part[1032];
    memset(&picture, 0, sizeof picture);
    picture.version = PNG_IMAGE_VERSION;
    picture.width = (png_uint_32)width;
    picture.height = (png_uint_32)height;
    picture.format = PNG_FORMAT_RGB;
    if (snprintf(part, sizeof part, "%s.part", path) >= (int)sizeof part) {
        snprintf(error, error_size, "%s: the path is too long", path);
        return false;
    }
    FILE *file = fopen(part, "wb");
    if (!file) {
        snprintf(error, error_size, "%s: cannot write: %s", path, strerror(errno));
        return false;
    }
    bool written = png_image_write_to_stdio(&picture, file, 0, rgb, 0, NULL) != 0;
    bool closed = fclose(file) == 0;
    if (written && closed && rename(part, path) == 0)
        return true;
    snprintf(error, error_size, "%s: cannot write: %s", path, written ? strerror(errno) : picture.message);
    remove(part);
    return false;
}
