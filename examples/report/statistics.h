/* statistics.h: medians and quartiles; fingerprints of bytes. */
#ifndef EXAMPLES_REPORT_STATISTICS_H
#define EXAMPLES_REPORT_STATISTICS_H

#include <stddef.h>
#include <stdint.h>

/* The value below which `share` (0..1) of the values lie, linear between neighbours. Sorts the values. NaN for none. */
double quantile(double *values, int count, double share);

/* The median; the quartiles go to low and high. Sorts the values. */
double quartiles(double *values, int count, double *low, double *high);

/* Continues a 64-bit FNV-1a hash (G. Fowler, L. C. Noll, P. Vo); start with FINGERPRINT_START. */
#define FINGERPRINT_START 0xcbf29ce484222325u
uint64_t fingerprint(uint64_t hash, const void *bytes, size_t size);

#endif
