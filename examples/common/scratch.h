/* scratch.h: a folder for files that nobody keeps. */
#ifndef EXAMPLES_SCRATCH_H
#define EXAMPLES_SCRATCH_H

#include <stdbool.h>

enum { SCRATCH_SIZE = 128 };

/* Makes a new, empty folder in $TMPDIR, or in the system's place for such where that is not set. False when it cannot be made, or its path
   would be longer than SCRATCH_SIZE. */
bool scratch_make(char folder[SCRATCH_SIZE]);

/* Removes the folder and all that is in it. */
bool scratch_remove(const char *folder);

#endif
