/* Writes a .cvol file brick by brick, in bounded memory.
 *
 * A file has subband after subband, a coder gives brick after brick. So subbands are kept in
 * spools, in memory while all are small and in files without a name beside the output when they are
 * not, until all bricks are there and the sections in front of them are known.
 */
#ifndef CVOL_CODEC_CONTAINER_WRITER_H
#define CVOL_CODEC_CONTAINER_WRITER_H

#include "base/file.h"
#include "codec/brick/brick_code.h"
#include "codec/container/header.h"

/* Bytes of spools in memory, at most. */
#define CVOL_SPOOLED_MOST (UINT64_C(64) << 20)

typedef struct cvol_file_writer cvol_file_writer;

/* A file of so many bricks in runs of `run`; 0: of an array that is no volume. path NULL: nothing
 * is written or kept, only counted. Errors: those of cvol_output_open. */
int cvol_file_writer_open(cvol_context *context, cvol_file_writer **out, const char *path,
                          size_t bricks, size_t run);

/* The same as a part of an output, from where that is: finishing does not commit it, and abandoning
 * leaves in it what was written. Errors: MEMORY. */
int cvol_file_writer_open_within(cvol_context *context, cvol_file_writer **out, cvol_output *output,
                                 size_t bricks, size_t run);

/* The next brick's bytes. Errors: IO, LIMIT (a subband of 4 GiB in one brick), MEMORY. */
int cvol_file_writer_add(cvol_context *context, cvol_file_writer *writer,
                         const cvol_span subbands[CVOL_SUBBANDS]);
/* The same of one of the other streams (brick_index.h), which then is part of the file. */
int cvol_file_writer_add_one(cvol_context *context, cvol_file_writer *writer, int stream,
                             size_t brick, cvol_span bytes);
/* The bytes of all subbands so far. */
uint64_t cvol_file_writer_subbands(const cvol_file_writer *writer);

/* What stands in front of the subbands, or instead of them. */
typedef struct cvol_file_front {
    const cvol_header *header;
    const char *attributes;          /* or NULL */
    const cvol_bytes *ranges;        /* content of RNGE (ranges.h), or NULL; left out where it takes
                                        more than a hundredth of the file */
    const cvol_token_tables *tables; /* volumes */
    const cvol_bytes *packed;        /* content of CORR where it is not in bricks, or NULL */
    const cvol_bytes *terms;         /* other arrays: content of TERM or SPEC */
} cvol_file_front;

/* How many bytes the file has with this front, when all bricks were added. Errors: MEMORY. */
int cvol_file_writer_bytes(cvol_context *context, const cvol_file_writer *writer,
                           const cvol_file_front *front, uint64_t *file_bytes);
/* Writes the file and gives it its name; frees the writer whatever happens, and without success
 * leaves nothing behind. file_bytes may be NULL. Errors: IO, MEMORY. */
int cvol_file_writer_finish(cvol_context *context, cvol_file_writer *writer,
                            const cvol_file_front *front, uint64_t *file_bytes);
/* Leaves nothing behind; NULL is allowed. */
void cvol_file_writer_abandon(cvol_file_writer *writer);

#endif
