/* Sections HEAD, GEOM, ERRS and MODE: the properties of an array, without its terms.
 *
 * Each section is a record of fixed length. A longer record comes from a later writer: the reader
 * ignores bytes after the fields that it knows. */
#ifndef CVOL_CODEC_CONTAINER_HEADER_H
#define CVOL_CODEC_CONTAINER_HEADER_H

#include "array/core/array.h"
#include "array/core/summary.h"
#include "base/bytes.h"
#include "codec/quantize/coding.h"
#include "codec/residual/residual_array.h"

typedef struct cvol_header {
    cvol_grid grid; /* GEOM: all members except shape and type */
    /* HEAD */
    uint32_t transform, rank, block, lapped, trellis;
    uint32_t true_length; /* TRUE; 0 without it */
    uint32_t neural;      /* SMAL: 1; 0 without it */
    double step, offset;
    uint64_t coefficients;
    cvol_error_bound error_bound; /* HEAD: value_min and value_max; ERRS: the other members */
    /* ERRS */
    double psnr_db, max_error, threshold;
    double subband_norm[CVOL_SUBBANDS]; /* volumes: L2 norms of the coefficients of each subband */
    uint32_t measured;
    cvol_summary summary; /* SUMM, for volumes; state NONE without it */
    /* MODE, for volumes that have a residual or a mask */
    cvol_brick_shape brick; /* volumes; files without BRKS have the shape from HEAD */
    cvol_residual_kind residual;
    int fraction;
    cvol_residual_rule rule;
    cvol_fills fills;
} cvol_header;

/* Makes the header of an array's file. */
cvol_header cvol_header_of(const cvol_array *array);
/* True if the array's terms are coded in bricks; other arrays have a separate section for them. */
int cvol_header_is_volume(const cvol_header *header);
/* The number of bricks of a volume. */
uint64_t cvol_header_bricks(const cvol_header *header);

/* The streams in the index of a volume's file (brick_index.h). */
unsigned cvol_header_streams(const cvol_header *header);

/* Append a section's content. */
void cvol_head_put(cvol_bytes *out, const cvol_header *header);
void cvol_geometry_put(cvol_bytes *out, const cvol_header *header);
void cvol_errors_put(cvol_bytes *out, const cvol_header *header);
void cvol_modes_put(cvol_bytes *out, const cvol_header *header);
void cvol_bricks_put(cvol_bytes *out, const cvol_header *header);
void cvol_true_length_section_put(cvol_bytes *out, const cvol_header *header);
void cvol_neural_put(cvol_bytes *out, const cvol_header *header);

/* Read and check every field, HEAD first. Errors: CORRUPT, FORMAT, LIMIT, UNSUPPORTED. */
int cvol_head_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                   const char *name);
int cvol_geometry_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                       const char *name);
int cvol_errors_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                     const char *name);
int cvol_modes_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                    const char *name);
int cvol_bricks_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                     const char *name);
int cvol_true_length_section_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                                  const char *name);
int cvol_neural_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                     const char *name);

#endif
