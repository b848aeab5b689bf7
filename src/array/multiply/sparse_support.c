/* The cells in which the product can have terms: the sumset of the operands' supports, coarse but
 * certain.
 *
 * Places are grouped in cells of g. If u lies in cell i and v in cell j, u + v lies in cell i + j
 * or i + j + 1, per axis. The number of pairs (i, j) of occupied cells with i + j = s is a
 * convolution of two vectors of 0 and 1. These are integers without cancellation, unlike the
 * product's own coefficients, so a term that happens to be 0 does no harm. Rounding: the transform
 * loses at most CVOL_ROUNDING of the L2 norm of its result, which is at most |1_a|_1 |1_b|_2. If
 * that is below 1/4, the counts that are not 0 are exactly those of at least 3/4.
 *
 * Cost: three transforms of at most MAX_CELLS cells. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/multiply/sparse.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/fft.h"

#define MAX_CELLS ((size_t)1 << 17)
#define CELLS_PER_TERM 8
#define ENOUGH_CELLS ((size_t)1 << 14) /* cheap enough */
#define MIN_POWER 32 /* the working group's lengths are multiples of this power of two */

/* ---- working group and cells ----------------------------------------------------------------- */

/* The shortest length of at least `least` that folds well. */
static size_t good_fold_length(size_t least)
{
    static const size_t odd[] = {1, 3, 5, 9};
    size_t best = SIZE_MAX;
    for (int i = 0; i < 4; i++) {
        size_t n = odd[i] * MIN_POWER;
        while (n < least)
            n *= 2;
        best = n < best ? n : best;
    }
    return best;
}

/* 0 if places do not fit into 32 bits. */
static int choose_fold_length(cvol_sparse_shape *shape, const cvol_sparse_terms *a,
                              const cvol_sparse_terms *b)
{
    for (int axis = 0; axis < 3; axis++) {
        const size_t n = shape->dims[axis], reach = a->extent[axis] + b->extent[axis];
        size_t length = good_fold_length(2 * reach + 1);
        const int folds = n <= MIN_POWER || (n % MIN_POWER == 0 && cvol_fft_good_length(n, 0) == n);
        if (reach == 0)
            length = 1;
        if (folds && n <= length)
            length = n;
        if (length > UINT32_MAX / 2)
            return 0;
        shape->length[axis] = length;
    }
    return 1;
}

/* Cells as fine as MAX_CELLS allows; no finer than a column of the finest useful fold, nor finer
 * than is useful for this number of terms. */
static int choose_cells(cvol_sparse_shape *shape, size_t terms)
{
    size_t places = 1;
    for (int axis = 0; axis < 3; axis++) {
        shape->cell[axis] = 1;
        shape->cells[axis] = shape->length[axis];
        if (!cvol_size_multiply(&places, places, shape->length[axis]))
            return 0;
    }
    const size_t of_use = CELLS_PER_TERM * terms > ENOUGH_CELLS ? CELLS_PER_TERM * terms
                                                                : ENOUGH_CELLS;
    size_t aim = places / 32 < MAX_CELLS ? places / 32 : MAX_CELLS;
    aim = aim < of_use ? aim : of_use;
    aim = aim > 64 ? aim : 64;
    shape->cell_count = places;
    shape->cell_places = 1;
    while (shape->cell_count > aim) {
        int axis = -1;
        for (int k = 0; k < 3; k++)
            if (shape->cells[k] % 2 == 0 && (axis < 0 || shape->cells[k] > shape->cells[axis]))
                axis = k;
        if (axis < 0)
            break;
        shape->cells[axis] /= 2;
        shape->cell[axis] *= 2;
        shape->cell_count /= 2;
        shape->cell_places *= 2;
    }
    return shape->cell_count <= 4 * MAX_CELLS;
}

/* ---- the sumset ------------------------------------------------------------------------------ */

/* Marks the cells of the terms and of their mirrors; returns their number. */
static size_t mark_cells(float *marks, const cvol_sparse_shape *shape,
                         const cvol_sparse_terms *terms)
{
    size_t count = 0;
    memset(marks, 0, shape->cell_count * sizeof *marks);
    for (size_t i = 0; i < terms->count; i++) {
        size_t one[3], two[3];
        for (int a = 0; a < 3; a++) {
            const size_t at = terms->terms[i].at[a];
            one[a] = at / shape->cell[a];
            two[a] = (at ? shape->length[a] - at : 0) / shape->cell[a];
        }
        const size_t *cells = shape->cells;
        float *first = &marks[one[0] + cells[0] * (one[1] + cells[1] * one[2])];
        float *second = &marks[two[0] + cells[0] * (two[1] + cells[1] * two[2])];
        count += *first == 0;
        *first = 1;
        count += *second == 0;
        *second = 1;
    }
    return count;
}

/* counts: sums of occupied cells. A cell and the next cell of each axis can hold the sum of two
 * cells. */
static void spread(cvol_sparse_shape *shape, const float *counts)
{
    const size_t *cells = shape->cells;
    const float least = 0.5f * (float)shape->cell_count;
    memset(shape->present, 0, shape->cell_count);
    for (size_t i = 0; i < shape->cell_count; i++) {
        if (counts[i] < least)
            continue;
        const size_t at[3] = {i % cells[0], i / cells[0] % cells[1], i / cells[0] / cells[1]};
        for (int corner = 0; corner < 8; corner++) {
            size_t to[3];
            int real = 1;
            for (int a = 0; a < 3; a++) {
                const size_t step = (size_t)(corner >> a & 1);
                real &= !step || shape->cell[a] > 1;
                to[a] = (at[a] + step) % cells[a];
            }
            if (real)
                shape->present[to[0] + cells[0] * (to[1] + cells[1] * to[2])] = 1;
        }
    }
    shape->present_count = 0;
    for (size_t i = 0; i < shape->cell_count; i++)
        shape->present_count += shape->present[i];
}

static int find_sumset(cvol_context *context, cvol_sparse_shape *shape, const cvol_sparse_terms *a,
                       const cvol_sparse_terms *b)
{
    const size_t half = 2 * (shape->cells[0] / 2 + 1) * shape->cells[1] * shape->cells[2];
    float *marks = cvol_fft_allocate(shape->cell_count);
    float *one = cvol_fft_allocate(half), *two = cvol_fft_allocate(half);
    int rc = CVOL_OK;
    if (!marks || !one || !two) {
        rc = cvol_fail_memory(context, 2 * half * sizeof(float), "cells of the product");
        goto done;
    }
    const double count_a = (double)mark_cells(marks, shape, a);
    rc = cvol_fft(context, CVOL_FFT_FORWARD, shape->cells, one, marks);
    if (rc)
        goto done;
    const double count_b = (double)mark_cells(marks, shape, b);
    rc = cvol_fft(context, CVOL_FFT_FORWARD, shape->cells, two, marks);
    if (rc)
        goto done;
    if (CVOL_ROUNDING * fmin(count_a * sqrt(count_b), count_b * sqrt(count_a)) >= 0.5) {
        memset(shape->present, 1, shape->cell_count);
        shape->present_count = shape->cell_count;
        goto done;
    }
    for (size_t i = 0; i < half; i += 2) {
        const float re = one[i] * two[i] - one[i + 1] * two[i + 1];
        one[i + 1] = one[i] * two[i + 1] + one[i + 1] * two[i];
        one[i] = re;
    }
    rc = cvol_fft(context, CVOL_FFT_INVERSE, shape->cells, marks, one);
    if (rc)
        goto done;
    spread(shape, marks);
done:
    free(marks);
    free(one);
    free(two);
    return rc;
}

int cvol_sparse_support(cvol_context *context, cvol_sparse_shape *shape, int *found,
                        cvol_sparse_terms *a, cvol_sparse_terms *b)
{
    *found = 0;
    if (!choose_fold_length(shape, a, b) || !choose_cells(shape, a->count + b->count))
        return CVOL_OK;
    shape->present = cvol_allocate(shape->cell_count, 1);
    if (!shape->present)
        return cvol_fail_memory(context, shape->cell_count, "cells of the product");
    cvol_sparse_terms_move(a, shape);
    if (b != a)
        cvol_sparse_terms_move(b, shape);
    *found = 1;
    return find_sumset(context, shape, a, b);
}

void cvol_sparse_shape_free(cvol_sparse_shape *shape)
{
    free(shape->present);
    free(shape->present_nodes);
    for (int a = 0; a < 3; a++)
        free(shape->node_roots[a]);
    memset(shape, 0, sizeof *shape);
}
