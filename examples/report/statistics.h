/* statistics.h: medians and quartiles. */
#ifndef EXAMPLES_REPORT_STATISTICS_H
#define EXAMPLES_REPORT_STATISTICS_H

/* The value below which `share` (0..1) of the values lie, linear between neighbours. Sorts the values. NaN for none. */
double quantile(double *values, int count, double share);

#endif
