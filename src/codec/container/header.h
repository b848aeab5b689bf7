/* Sections HEAD, GEOM, ERRS and MODE: what an array is but for its terms.
 *
 * Each is a record of fixed length. One that is longer comes from a later writer: what stands
 * behind the fields that are known here is ignored.
 */
#ifndef CVOL_CODEC_CONTAINER_HEADER_H
#define CVOL_CODEC_CONTAINER_HEADER_H

#include "array/core/array.h"
#include "array/core/summary.h"
#include "base/bytes.h"
#include "codec/quantize/coding.h"
#include "codec/residual/residual_array.h"

typedef struct cvol_header {
    cvol_grid grid; /* GEOM: all of it but shape and type */
    /* HEAD */
    uint32_t transform, rank, block, lapped, trellis;
    uint32_t true_length; /* TRUE; 0 without */
    uint32_t neural;      /* SMAL: 1; 0 without */
    double step, offset;
    uint64_t coefficients;
    cvol_error_bound error_bound; /* HEAD: value_min and value_max; ERRS: the other two */
    /* ERRS */
    double psnr_db, max_error, threshold;
    double subband_norm[CVOL_SUBBANDS]; /* volumes: L2 norms of the coefficients of each subband */
    uint32_t measured;
    cvol_summary summary; /* SUMM, of volumes; state NONE without */
    /* MODE, of volumes that have residual or a mask */
    cvol_brick_shape brick; /* volumes; of HEAD that of files without BRKS */
    cvol_residual_kind residual;
    int fraction;
    cvol_residual_rule rule;
    cvol_fills fills;
} cvol_header;

/* What the header of an array's file says. */
cvol_header cvol_header_of(const cvol_array *array);
/* Whether an array's terms are coded in bricks; others have a section of their own. */
int cvol_header_is_volume(const cvol_header *header);
/* How many blocks it claims along each axis; how many bricks, of a volume. */
void cvol_header_blocks(uint64_t blocks[3], const cvol_header *header);
uint64_t cvol_header_bricks(const cvol_header *header);

/* The streams that the index of a volume's file has (brick_index.h). */
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
