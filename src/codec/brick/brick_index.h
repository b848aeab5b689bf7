/* Section INDX: the place of each brick's bytes in the streams of a file, and their checksums.
 * Streams are the four subbands and, in files that have them, masks and residual.
 *
 * A checksum covers one run: a stream's bytes of `run` bricks in order (fewer in the last run). So
 * a reader checks a few bricks without reading the whole stream; in runs of 16, the subbands'
 * checksums cost a byte per brick. In runs of one, an empty brick has no checksum, which counts as
 * 0. The checksum in a stream's section header is computed over its runs' checksums. */
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
    size_t bricks, run, runs; /* run: bricks per run */
    unsigned present;         /* bit `stream`: the stream is part of the file; the subbands
                                 always are */
    uint64_t *ends;           /* [stream bricks + brick]: end of its bytes */
    uint32_t *checksums;      /* [stream runs + run] */
} cvol_brick_index;

/* Makes an index for this many bricks in runs of `run`, all empty. Errors: MEMORY. */
int cvol_brick_index_make(cvol_context *context, cvol_brick_index *index, size_t bricks,
                          size_t run);
void cvol_brick_index_free(cvol_brick_index *index);

/* Records the bytes of brick `brick`; bricks come in order. Returns 0 if a subband has 2^32 bytes
 * or more. */
int cvol_brick_index_add(cvol_brick_index *index, size_t brick,
                         const cvol_span subbands[CVOL_SUBBANDS]);

/* Does the same for one stream, which is then part of the file. */
int cvol_brick_index_add_one(cvol_brick_index *index, int stream, size_t brick, cvol_span bytes);

/* Appends the section's content. */
void cvol_brick_index_put(cvol_bytes *out, const cvol_brick_index *index);
/* Reads the content; checks `bricks` against the content's length before it allocates memory. The
 * caller frees the index, also after an error. Errors: CORRUPT, MEMORY. */
int cvol_brick_index_take(cvol_context *context, cvol_brick_index *index,
                          const cvol_section *section, uint64_t bricks, size_t run,
                          const char *name);

/* Does the same for a file with these streams. */
int cvol_brick_index_take_streams(cvol_context *context, cvol_brick_index *index,
                                  const cvol_section *section, uint64_t bricks, size_t run,
                                  unsigned present, const char *name);

/* The size of a subband (here and below: or of another stream), and the checksum of its section's
 * header. */
uint64_t cvol_brick_index_size(const cvol_brick_index *index, int subband);
uint32_t cvol_brick_index_checksum(const cvol_brick_index *index, int subband);
/* Compares a subband's section with the index. Errors: CORRUPT. */
int cvol_brick_index_check(cvol_context *context, const cvol_brick_index *index, int subband,
                           const cvol_section *section, const char *name);

/* True if the checksum of a run of bricks holds. */
int cvol_brick_index_verify(const cvol_brick_index *index, int subband, size_t run,
                            const uint8_t *data);
/* The bytes of a brick, or of a run, within its subband. */
cvol_span cvol_brick_index_brick(const cvol_brick_index *index, int subband, size_t brick,
                                 const uint8_t *data);
cvol_span cvol_brick_index_run(const cvol_brick_index *index, int subband, size_t run,
                               const uint8_t *data);

#endif
