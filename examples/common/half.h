/* half.h: conversion between 32-bit and 16-bit IEEE 754 floating point (binary16), for textures and files. */
#ifndef EXAMPLES_HALF_H
#define EXAMPLES_HALF_H

#include <stddef.h>
#include <stdint.h>

/* Largest finite half. Captures use it as "the ray hit nothing". */
#define HALF_MAX 65504.0f

/* Nearest half, ties to even. Finite values beyond +-65504 become +-65504, so that a bright pixel never turns into Inf;
   Inf and NaN are kept. */
uint16_t half_from_float(float value);

/* Exact. */
float half_to_float(uint16_t half);

/* `count` values; `out` and `in` do not overlap. */
void half_from_floats(uint16_t *out, const float *in, size_t count);

#endif
