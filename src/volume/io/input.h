/* Input files that are read in parts: reads stop at the end of the file, for any size in a header.
 */
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
/* Reads up to `size` bytes at `offset`; *got is less only at the end of the file. */
int cvol_input_read(cvol_context *context, const cvol_input *input, uint64_t offset, void *data,
                    size_t size, size_t *got);
/* Moves *offset behind the next `lines` line ends. */
int cvol_input_skip_lines(cvol_context *context, const cvol_input *input, uint64_t *offset,
                          uint64_t lines);
/* The length of FILE in FILE:INSIDE, if FILE is a file and the whole path is not; else the whole
 * length. */
size_t cvol_input_file_length(const char *path);
/* The path of `name` relative to the header's folder, or name itself if it is absolute; NULL
 * without memory. */
char *cvol_input_relative_path(const char *header, const char *name);
/* The part of a path behind its last slash. */
const char *cvol_input_name(const char *path);

#endif
