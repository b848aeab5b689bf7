/* Input files read in pieces: reads stop at the end of the file, whatever size a header claims. */
#ifndef CVOL_VOLUME_IO_INPUT_H
#define CVOL_VOLUME_IO_INPUT_H

#include "cvol/base.h"

typedef struct cvol_input {
    const char *path; /* the caller's, must outlive the input */
    uint64_t size;
    int fd;
} cvol_input;

/* Opens a regular file that is not empty. The caller closes it, also after a failure. */
int cvol_input_open(cvol_context *context, cvol_input *input, const char *path);
void cvol_input_close(cvol_input *input);
/* Up to `size` bytes at `offset`; *got is less only at the end of the file. */
int cvol_input_read(cvol_context *context, const cvol_input *input, uint64_t offset, void *data,
                    size_t size, size_t *got);
/* *offset moves behind the `lines`-th line end after it. */
int cvol_input_skip_lines(cvol_context *context, const cvol_input *input, uint64_t *offset,
                          uint64_t lines);
/* FOLDER-OF-header/name, or name itself when it is absolute; NULL without memory. */
char *cvol_input_relative_path(const char *header, const char *name);
/* The part of a path behind its last slash. */
const char *cvol_input_name(const char *path);

#endif
