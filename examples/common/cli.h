/* cli.h: what the command-line programs share: error lines, numbers in arguments, a progress bar. */
#ifndef EXAMPLES_CLI_H
#define EXAMPLES_CLI_H

#include <stdbool.h>

/* Size of the buffers that error lines are written to: a path and what is wrong with it. */
#define CLI_ERROR_SIZE 2048

/* Prints "PROGRAM: message" to stderr as one line; returns the exit status 1. */
int cli_fail(const char *program, const char *format, ...);

/* A whole number within [low, high], nothing behind it. False otherwise; `out` is then left as it was. */
bool cli_integer(const char *text, long low, long high, long *out);

/* A finite number, nothing behind it. False otherwise; `out` is then left as it was. */
bool cli_number(const char *text, double *out);

/* The value of option argv[*i], moving *i onto it. NULL when it is the last argument. */
const char *cli_value(int argc, char **argv, int *i);

/* A bar on a terminal, silence elsewhere; both on stderr. `done` of `total` steps are over; erases the bar at the end. */
void cli_progress(const char *label, int done, int total);

#endif
