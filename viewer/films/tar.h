/* TAR archives (POSIX ustar), written one file after the other. */
#ifndef CVOL_VIEWER_FILMS_TAR_H
#define CVOL_VIEWER_FILMS_TAR_H

#include <stddef.h>
#include <stdio.h>

/* Adds a file; the name has at most 99 bytes. 0 on success. */
int tar_add(FILE *out, const char *name, const void *bytes, size_t size);
/* Ends the archive. 0 on success. */
int tar_end(FILE *out);

#endif
