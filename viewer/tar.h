/* TAR archives (POSIX ustar), written one file after the other. */
#ifndef CVOL_VIEWER_TAR_H
#define CVOL_VIEWER_TAR_H

#include <stddef.h>
#include <stdio.h>

/* A file of the archive, its name at most 99 bytes long. 0 if it was written. */
int tar_add(FILE *out, const char *name, const void *bytes, size_t size);
/* What ends the archive. */
int tar_end(FILE *out);

#endif
