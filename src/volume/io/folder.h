/* Files of a folder in natural order, as slices of one volume. */
#ifndef CVOL_VOLUME_IO_FOLDER_H
#define CVOL_VOLUME_IO_FOLDER_H

#include "cvol/base.h"

typedef struct cvol_folder {
    char **paths; /* FOLDER/NAME of regular files that are not hidden */
    size_t count;
} cvol_folder;

/* *is: 1 if `path` is a folder; 0 if it is a file, or nothing that can be found. Errors: IO. */
int cvol_folder_check(cvol_context *context, int *is, const char *path);
/* The caller closes it, also after a failure. */
int cvol_folder_open(cvol_context *context, cvol_folder *folder, const char *path);
void cvol_folder_close(cvol_folder *folder);
/* The order of names that compares numbers as numbers: a2 before a10. */
int cvol_folder_compare(const char *a, const char *b);
/* 1 if the name has this ending, in lower or upper case, and something before it. */
int cvol_folder_name_ends(const char *path, const char *ending);

#endif
