/* An array's residual (array/core/residual.h) as files store it. When samples of a brick are
 * requested, its base is evaluated exactly (array/block/exact.h) and its stream (residual_code.h)
 * decoded.
 *
 * Or all samples, if that takes fewer bytes: labels, brick by brick (residual_labels.h); or packed
 * by zstd, for volumes with repetitions that no transform exploits. Reading unpacks all of them at
 * once, so their number is limited. */
#ifndef CVOL_CODEC_RESIDUAL_RESIDUAL_ARRAY_H
#define CVOL_CODEC_RESIDUAL_RESIDUAL_ARRAY_H

#include "array/core/array.h"
#include "codec/brick/brick_stream.h"
#include "codec/brick/bricks.h"
#include "codec/residual/residual_code.h"
#include "codec/section/section.h"

/* The numbers are part of the format. */
typedef enum cvol_residual_kind {
    CVOL_RESIDUAL_NOT = 0,
    CVOL_RESIDUAL_BOUNDED = 1,
    CVOL_RESIDUAL_EXACT = 2,
    CVOL_RESIDUAL_PACKED = 3,
    CVOL_RESIDUAL_LABELS = 4
} cvol_residual_kind;

/* True for kinds with one stream per brick. */
static inline int cvol_residual_has_bricks(cvol_residual_kind kind)
{
    return kind != CVOL_RESIDUAL_NOT && kind != CVOL_RESIDUAL_PACKED;
}

/* The most bytes of samples that may be packed. */
#define CVOL_PACKED_MAX (UINT64_C(64) << 20)

typedef struct cvol_residual_data {
    cvol_residual as;
    cvol_residual_kind kind;
    int fraction; /* of the base */
    cvol_residual_rule rule;
    cvol_token_tables *tables;
    size_t bricks; /* number of bricks so far */
    uint64_t *ends;
    cvol_bytes data; /* of all bricks; or the packed samples */
    uint8_t *samples;
} cvol_residual_data;

/* Makes a residual without bricks; copies the tables, which may be NULL. */
int cvol_residual_create(cvol_context *context, cvol_residual_data **out,
                         const cvol_token_tables *tables, size_t bricks);
void cvol_residual_free(cvol_residual_data *residual);
/* Appends the next brick's bytes. Errors: MEMORY. */
int cvol_residual_append(cvol_context *context, cvol_residual_data *residual, cvol_span bytes);
cvol_span cvol_residual_stream(const cvol_residual_data *residual, size_t brick);
/* The residual of an array, or NULL. */
const cvol_residual_data *cvol_residual_of(const cvol_array *array);

/* True if zstd at a fast level suggests that all samples could be packed in this many bytes. */
int cvol_packed_may_fit(const void *samples, const cvol_grid *grid, double bytes);
/* Estimates the bytes that zstd takes at a fast level; for large volumes from some chunks. Errors:
 * MEMORY. */
int cvol_packed_estimate(cvol_context *context, double *bytes, const void *samples,
                         const cvol_grid *grid);
/* Packs an array's samples into a new residual. Errors: MEMORY. */
int cvol_residual_pack(cvol_context *context, cvol_residual_data **out, const void *samples,
                       const cvol_grid *grid);

/* A file's residual: the fields of MODE, and the content of CORR. */
typedef struct cvol_residual_file {
    cvol_residual_kind kind;
    int fraction;
    const cvol_residual_rule *rule;
    const cvol_token_tables *tables;
    const cvol_brick_index *index;
    const cvol_section *section;
    const cvol_box *box; /* NULL: all bricks */
} cvol_residual_file;
/* Gives the residual to the array, which has its terms. Errors: CORRUPT, LIMIT, MEMORY. */
int cvol_residual_take(cvol_context *context, cvol_array *array, const cvol_residual_file *file,
                       const char *name);

#endif
