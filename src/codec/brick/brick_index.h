/* Section INDX: where each brick's bytes lie in the streams of a file, and their checksums. Streams
 * are the four subbands, and in files that have them the masks and the residual.
 *
 * A checksum is that of a run: of a subband's bytes of `run` bricks in order (fewer in the last
 * run). So a few bricks are read and checked without their subband; in runs of 16 checksums cost a
 * byte a brick. In runs of one, bricks without bytes have none: it counts as 0. The checksum in a
 * subband's own header is that of its runs' checksums.
 */
#ifndef CVOL_CODEC_BRICK_BRICK_INDEX_H
#define CVOL_CODEC_BRICK_BRICK_INDEX_H

#include "codec/brick/brick_code.h"
#include "codec/section/section.h"

enum {
    CVOL_STREAM_MASK = CVOL_SUBBANDS,
    CVOL_STREAM_RESIDUAL,
    CVOL_STREAMS,
    CVOL_STREAMS_SUBBANDS = (1 << CVOL_SUBBANDS) - 1 /* bits of the subbands */
};

/* The streams in a file's order, and the sections that hold them. */
typedef struct cvol_stream_section {
    cvol_section_kind kind;
    int stream;
} cvol_stream_section;
extern const cvol_stream_section cvol_stream_sections[CVOL_STREAMS];

typedef struct cvol_brick_index {
    size_t bricks, run, runs; /* run: bricks of one */
    unsigned present;         /* bit `stream`: it is part of the file; the subbands always are */
    uint64_t *ends;           /* [stream bricks + brick]: where its bytes end */
    uint32_t *checksums;      /* [stream runs + run] */
} cvol_brick_index;

/* One for so many bricks in runs of `run`, all empty. Errors: MEMORY. */
int cvol_brick_index_make(cvol_context *context, cvol_brick_index *index, size_t bricks,
                          size_t run);
void cvol_brick_index_free(cvol_brick_index *index);

/* Notes the bytes of brick `brick`; bricks come in order. 0 if a subband has 2^32 or more. */
int cvol_brick_index_add(cvol_brick_index *index, size_t brick,
                         const cvol_span subbands[CVOL_SUBBANDS]);

/* The same of one stream, which is then part of the file. */
int cvol_brick_index_add_one(cvol_brick_index *index, int stream, size_t brick, cvol_span bytes);

/* Appends the section's content. */
void cvol_brick_index_put(cvol_bytes *out, const cvol_brick_index *index);
/* Reads it; what `bricks` would take is held against the content's length before memory is spent on
 * it. The caller frees the index, also after an error. Errors: CORRUPT, MEMORY. */
int cvol_brick_index_take(cvol_context *context, cvol_brick_index *index,
                          const cvol_section *section, uint64_t bricks, size_t run,
                          const char *name);

/* The same of a file with these streams. */
int cvol_brick_index_take_streams(cvol_context *context, cvol_brick_index *index,
                                  const cvol_section *section, uint64_t bricks, size_t run,
                                  unsigned present, const char *name);

/* A subband's (here and below: or another stream's) bytes in all, and the checksum of its section's
 * header. */
uint64_t cvol_brick_index_size(const cvol_brick_index *index, int subband);
uint32_t cvol_brick_index_checksum(const cvol_brick_index *index, int subband);
/* Whether a subband's section agrees with the index. Errors: CORRUPT. */
int cvol_brick_index_check(cvol_context *context, const cvol_brick_index *index, int subband,
                           const cvol_section *section, const char *name);

/* Whether the checksum of a run of bricks holds. */
int cvol_brick_index_sound(const cvol_brick_index *index, int subband, size_t run,
                           const uint8_t *data);
/* A brick's bytes, or a run's, within its subband. */
cvol_span cvol_brick_index_brick(const cvol_brick_index *index, int subband, size_t brick,
                                 const uint8_t *data);
cvol_span cvol_brick_index_run(const cvol_brick_index *index, int subband, size_t run,
                               const uint8_t *data);

#endif
