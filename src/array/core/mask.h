/* Samples of a volume that are not part of its transform: those equal to one of a few bit patterns,
 * the fills. They evaluate to their fill. Either they have no value (the fill is 1e35, for example,
 * or a NaN), or they are the volume's background: a value like any other, stored separately because
 * the edges around it would take more terms than the mask takes bytes.
 *
 * The mask is stored by blocks of 16^3. Most of them have no such sample or only such samples; the
 * others have a bit map. */
#ifndef CVOL_ARRAY_CORE_MASK_H
#define CVOL_ARRAY_CORE_MASK_H

#include <stddef.h>
#include <stdint.h>

#include "array/core/fills.h"
#include "cvol/base.h"

enum {
    CVOL_MASK_CELL = 16,
    CVOL_MASK_ROWS = CVOL_MASK_CELL * CVOL_MASK_CELL, /* of a block: y + 16 z */
    CVOL_MASK_MIXED = 255
};

/* One bit of a block's states: rows y + 16 z, x from the low bit on. */
typedef struct cvol_mask_rows {
    uint16_t of[CVOL_MASK_ROWS];
} cvol_mask_rows;

typedef struct cvol_mask cvol_mask;

/* A mask for these samples per axis; none is masked. Errors: MEMORY. */
int cvol_mask_create(cvol_context *context, cvol_mask **out, const size_t dims[3],
                     const cvol_fills *fills);
void cvol_mask_free(cvol_mask *mask); /* NULL is allowed */

const cvol_fills *cvol_mask_fills(const cvol_mask *mask);
/* For a mask or NULL: returns 1 if samples have no value, 0 if they are background. */
int cvol_mask_is_void(const cvol_mask *mask);
int cvol_mask_is_background(const cvol_mask *mask);
/* Replaces the fills by others, as many. Equal ones become one fill: *mask is another mask then.
 * Errors: MEMORY. */
int cvol_mask_set_fills(cvol_context *context, cvol_mask **mask, const cvol_fills *fills);
/* Sets a box of whole blocks (or their part within the volume); which: as in cvol_fills_match.
 * Threads may set disjoint boxes. 0 if memory is short. */
int cvol_mask_set(cvol_mask *mask, const uint8_t *which, const size_t begin[3],
                  const size_t end[3]);
/* For any box. Returns how many are not 0. */
size_t cvol_mask_get(uint8_t *which, const cvol_mask *mask, const size_t begin[3],
                     const size_t end[3]);

/* The state of the block at place (i, j, l): 0, one fill everywhere (1 ..), or MIXED, and then
 * *rows: for each bit of the samples' states (as in cvol_fills_match), the low one first, its rows.
 * 0 beyond the volume. */
uint8_t cvol_mask_cell_get(const cvol_mask *mask, const size_t cell[3],
                           const cvol_mask_rows **rows);
/* Sets a block that was not set. Threads may set different blocks. 0 if memory is short. */
int cvol_mask_cell_put(cvol_mask *mask, const size_t cell[3], uint8_t state,
                       const cvol_mask_rows *rows);
/* Writes words of `size` bytes, patterns[f], to the samples of fill f in a box of samples. */
void cvol_mask_write(void *samples, size_t size, const uint64_t patterns[CVOL_FILLS_MAX],
                     const cvol_mask *mask, const size_t begin[3], const size_t end[3]);

typedef enum cvol_mask_state { CVOL_MASK_NONE, CVOL_MASK_SOME, CVOL_MASK_ALL } cvol_mask_state;
/* For the block of 16^3 samples at place (i, j, l). */
cvol_mask_state cvol_mask_cell(const cvol_mask *mask, const size_t cell[3]);

/* Number of masked samples; bytes of memory. */
uint64_t cvol_mask_samples(const cvol_mask *mask);
uint64_t cvol_mask_bytes(const cvol_mask *mask);

#endif
