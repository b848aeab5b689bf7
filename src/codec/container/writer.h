/* Writes a .cvol file brick by brick, in bounded memory.
 *
 * A file stores subband after subband, but a coder emits brick after brick. So the writer collects
 * subbands in spools until all bricks and the sections in front of them are known. Spools are in
 * memory while all are small, else in unnamed files in the folder of the output. */
#ifndef CVOL_CODEC_CONTAINER_WRITER_H
#define CVOL_CODEC_CONTAINER_WRITER_H

#include "base/file.h"
#include "codec/brick/brick_code.h"
#include "codec/container/header.h"

/* The most bytes of spools in memory. */
#define CVOL_SPOOLED_MAX (UINT64_C(64) << 20)

typedef struct cvol_file_writer cvol_file_writer;

/* Opens a file of `bricks` bricks in runs of `run`; 0 bricks: an array that is no volume. path
 * NULL: writes and keeps nothing, only counts. Errors: as cvol_output_open. */
int cvol_file_writer_open(cvol_context *context, cvol_file_writer **out, const char *path,
                          size_t bricks, size_t run);

/* Opens a part of an output, from the output's current position: finishing does not commit the
 * output, and abandoning leaves the written bytes in it. Errors: MEMORY. */
int cvol_file_writer_open_within(cvol_context *context, cvol_file_writer **out, cvol_output *output,
                                 size_t bricks, size_t run);

/* Adds the next brick's bytes. Errors: IO, LIMIT (a subband of 4 GiB in one brick), MEMORY. */
int cvol_file_writer_add(cvol_context *context, cvol_file_writer *writer,
                         const cvol_span subbands[CVOL_SUBBANDS]);
/* Adds a brick's bytes to another stream (brick_index.h), which then is part of the file. */
int cvol_file_writer_add_one(cvol_context *context, cvol_file_writer *writer, int stream,
                             size_t brick, cvol_span bytes);
/* The number of bytes of all subbands so far. */
uint64_t cvol_file_writer_subbands(const cvol_file_writer *writer);

/* The sections in front of the subbands, or instead of them. */
typedef struct cvol_file_front {
    const cvol_header *header;
    const char *attributes;          /* or NULL */
    const cvol_bytes *ranges;        /* content of RNGE (ranges.h), or NULL; left out if it takes
                                        more than a hundredth of the file */
    const cvol_token_tables *tables; /* volumes */
    const cvol_bytes *packed;        /* content of CORR if it is not in bricks, or NULL */
    const cvol_bytes *terms;         /* other arrays: content of TERM or SPEC */
} cvol_file_front;

/* The size of the file with this front, after all bricks were added. Errors: MEMORY. */
int cvol_file_writer_bytes(cvol_context *context, const cvol_file_writer *writer,
                           const cvol_file_front *front, uint64_t *file_bytes);
/* Writes the file and gives it its name. Frees the writer in any case; after a failure no file
 * remains. file_bytes may be NULL. Errors: IO, MEMORY. */
int cvol_file_writer_finish(cvol_context *context, cvol_file_writer *writer,
                            const cvol_file_front *front, uint64_t *file_bytes);
/* Frees the writer; no file remains. NULL is allowed. */
void cvol_file_writer_abandon(cvol_file_writer *writer);

#endif
