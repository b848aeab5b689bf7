/* Files: whole input files in memory, or mapped, and outputs that appear only when they are
 * complete. */
#ifndef CVOL_BASE_FILE_H
#define CVOL_BASE_FILE_H

#include "base/bytes.h"
#include "cvol/base.h"

/* Reads `size` bytes at `offset` of a regular file. size SIZE_MAX: to the end. *data is freed by
 * the caller with free(); *read_size is the number of bytes read (less than `size` only at the end
 * of the file). Errors: IO ("PATH: No such file or directory", "PATH: is a directory"), LIMIT,
 * MEMORY. */
int cvol_file_read(cvol_context *context, uint8_t **data, size_t *read_size, const char *path,
                   uint64_t offset, size_t size);

/* The first bytes of a file, for recognising formats: up to `size` into `data`, the count into
 * *read_size. Errors: IO; an empty file is refused ("PATH: is empty"). */
int cvol_file_peek(cvol_context *context, uint8_t *data, size_t *read_size, size_t size,
                   const char *path);

/* open(), again after interruptions, which network file systems allow. */
int cvol_file_open(const char *path, int flags, unsigned mode);

/* 0 if the path certainly names no regular file: it names nothing, or a folder, device or pipe. */
int cvol_file_may_be_regular(const char *path);

/* All bytes of a regular file, to be read in place: pages are loaded on access. */
typedef struct cvol_map {
    const uint8_t *data; /* never NULL */
    size_t size;
    void *memory; /* memory to free: a mapping, or a copy if the file cannot be mapped */
    int is_mapping;
} cvol_map;

/* Errors: IO, LIMIT, MEMORY. A file must not be truncated while it is mapped (missing pages kill
 * the process): cvol replaces its files and never rewrites them. */
int cvol_file_map(cvol_context *context, cvol_map *map, const char *path);
/* The same bytes, read into memory, so that the file may be truncated. A file larger than a quarter
 * of the machine's memory, or than the limit, is mapped instead. */
int cvol_file_copy(cvol_context *context, cvol_map *map, const char *path);
void cvol_file_unmap(cvol_map *map);

/* An output is a file without a name in the folder of its final one, or under a temporary name if
 * the file system has no such files. A killed process leaves no file in the first case (except
 * between linking and renaming), and a hidden file in the second. An older file of the final name
 * stays unchanged until cvol_output_commit has the whole file on disk and renames it. Devices and
 * pipes are written in place; symbolic links are followed. */
typedef struct cvol_output cvol_output;

/* Errors: IO (folder does not exist, name is a directory, file is read-only, ...), MEMORY. */
int cvol_output_open(cvol_context *context, cvol_output **out, const char *path);
/* An output that appends to the caller's `bytes`; messages call it `name`. Errors: MEMORY. */
int cvol_output_open_memory(cvol_context *context, cvol_output **out, cvol_bytes *bytes,
                            const char *name);
int cvol_output_write(cvol_context *context, cvol_output *output, const void *data, size_t size);
/* Opens a file without a name for reading and writing, in the output's folder (for a device or
 * pipe: in the folder of temporary files). It is gone when *fd is closed. Errors: IO, MEMORY. */
int cvol_output_scratch(cvol_context *context, const cvol_output *output, int *fd);
/* cvol_output_count starts to count written bytes and to compute their CRC-32C; cvol_output_counted
 * returns both. */
void cvol_output_count(cvol_output *output);
void cvol_output_counted(const cvol_output *output, uint64_t *bytes, uint32_t *checksum);
/* The output's name in messages. */
const char *cvol_output_name(const cvol_output *output);
/* 0 for a pipe, whose written bytes cannot be replaced. */
int cvol_output_is_seekable(const cvol_output *output);
/* Replaces bytes that were written; later writes still go to the end. IO error if the output is a
 * pipe. */
int cvol_output_rewrite(cvol_context *context, cvol_output *output, uint64_t offset,
                        const void *data, size_t size);
/* Syncs, names and frees the output; it also frees it after a failure, which replaces nothing. If
 * the context holds outputs (cvol_context_hold_outputs), the name follows later. */
int cvol_output_commit(cvol_context *context, cvol_output *output);
/* Removes the temporary file and frees the output; NULL is allowed. */
void cvol_output_abandon(cvol_output *output);
/* Commits the output if code is CVOL_OK, abandons it otherwise; returns the outcome. */
int cvol_output_end(cvol_context *context, cvol_output *output, int code);

/* Writes a whole file: open, write, end. */
int cvol_file_write(cvol_context *context, const void *data, size_t size, const char *path);

#endif
