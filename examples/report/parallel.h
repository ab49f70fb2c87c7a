/* parallel.h: independent pieces of work on all processors. */
#ifndef EXAMPLES_REPORT_PARALLEL_H
#define EXAMPLES_REPORT_PARALLEL_H

#include <stdbool.h>

/* How many pieces are worked on at once at most. */
int parallel_threads(void);

/* Calls work(user, i) once for each i in 0 .. count - 1, in any order, on several threads. False when one of them is. */
bool parallel_each(int count, bool (*work)(void *user, int i), void *user);

#endif
