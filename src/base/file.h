/* Files: whole input files in memory, or mapped, and outputs that appear only when they are whole.
 */
#ifndef CVOL_BASE_FILE_H
#define CVOL_BASE_FILE_H

#include "base/bytes.h"
#include "cvol/base.h"

/* Reads `size` bytes at `offset` of a regular file. size SIZE_MAX: all that follows.
 * *data is freed by the caller with free(); *read_size is what was there (less than `size` only
 * at the end of the file). Errors: IO ("PATH: No such file or directory", "PATH: is a
 * directory"), LIMIT, MEMORY. */
int cvol_file_read(cvol_context *context, uint8_t **data, size_t *read_size, const char *path,
                   uint64_t offset, size_t size);

/* The first bytes of a file, for recognising formats: up to `size` into `data`, the count into
 * *read_size. Errors: IO; an empty file is refused ("PATH: is empty"). */
int cvol_file_peek(cvol_context *context, uint8_t *data, size_t *read_size, size_t size,
                   const char *path);

/* A regular file's bytes, all of them, to be read where they lie: pages come when they are touched.
 */
typedef struct cvol_map {
    const uint8_t *data; /* never NULL */
    size_t size;
    void *memory; /* what is freed: a mapping, or what was read where there can be none */
    int is_mapping;
} cvol_map;

/* Errors: IO, LIMIT, MEMORY. A file must not shrink while it is mapped (its size is what it was
 * here; pages that are gone kill the process): ours are replaced, never rewritten. */
int cvol_file_map(cvol_context *context, cvol_map *map, const char *path);
/* The same bytes, read into memory, so that the file may shrink. One that is larger than a quarter
 * of the machine's memory, or than what may be allocated, is mapped instead. */
int cvol_file_copy(cvol_context *context, cvol_map *map, const char *path);
void cvol_file_unmap(cvol_map *map);

/* An output without a name, in the folder of its final one, or under a temporary name where there
 * is no such thing: a process that is killed leaves nothing behind in the first case, but for one
 * in the moment between linking and renaming, and a hidden file in the other. What had the final
 * name stays untouched until cvol_output_commit has the whole file on disk and renames it. A final
 * name that is a device or a pipe is written in place; a symbolic link is followed. */
typedef struct cvol_output cvol_output;

/* Errors: IO (folder does not exist, name is a directory, file is read-only, ...), MEMORY. */
int cvol_output_open(cvol_context *context, cvol_output **out, const char *path);
/* One whose bytes are appended to `bytes`, the caller's, instead; `name` is what messages call it.
 * Errors: MEMORY. */
int cvol_output_open_memory(cvol_context *context, cvol_output **out, cvol_bytes *bytes,
                            const char *name);
int cvol_output_write(cvol_context *context, cvol_output *output, const void *data, size_t size);
/* Opens a file without a name for reading and writing, in the output's folder (of a device or pipe:
 * where temporary files lie), which is gone when *fd is closed. Errors: IO, MEMORY. */
int cvol_output_scratch(cvol_context *context, const cvol_output *output, int *fd);
/* From here on bytes that are written are counted, and their CRC-32C is taken; how many came since
 * then, and what they give. */
void cvol_output_count(cvol_output *output);
void cvol_output_counted(const cvol_output *output, uint64_t *bytes, uint32_t *checksum);
/* What messages call it. */
const char *cvol_output_name(const cvol_output *output);
/* Replaces bytes that were written; what is written next still goes to the end. IO error where the
 * output is a pipe. */
int cvol_output_rewrite(cvol_context *context, cvol_output *output, uint64_t offset,
                        const void *data, size_t size);
/* Syncs, names and frees the output (also when it fails: then nothing was replaced). */
int cvol_output_commit(cvol_context *context, cvol_output *output);
/* Removes the temporary file and frees the output; NULL is allowed. */
void cvol_output_abandon(cvol_output *output);
/* Commits an output that went well (code is CVOL_OK), abandons one that failed; what came of it. */
int cvol_output_end(cvol_context *context, cvol_output *output, int code);

/* Writes a file whole: open, write, end. */
int cvol_file_write(cvol_context *context, const void *data, size_t size, const char *path);

#endif
