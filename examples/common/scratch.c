#define _XOPEN_SOURCE 700
#include "common/scratch.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>

bool scratch_make(char folder[SCRATCH_SIZE])
{
    const char *parent = getenv("TMPDIR");
    int length = snprintf(folder, SCRATCH_SIZE, "%s/nrd.XXXXXX", parent && *parent ? parent : P_tmpdir);   /* the letters are mkdtemp()'s to replace */
    return length > 0 && length < SCRATCH_SIZE && mkdtemp(folder);
}

static int remove_entry(const char *path, const struct stat *status, int type, struct FTW *place)
{
    (void)status, (void)type, (void)place;
    return remove(path);
}

bool scratch_remove(const char *folder) { return nftw(folder, remove_entry, 16, FTW_DEPTH | FTW_PHYS) == 0; }
