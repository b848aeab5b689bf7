/* The product's terms, from the slots of present cells into the array. If the working group is the
 * array's own group, they are already in order; else each goes to its place, and terms at one place
 * are added. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/multiply/sparse.h"
#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "transform/whole.h"

#define SQRT_2 1.41421356237309504880
#define SQRT_HALF 0.70710678118654752440

/* Terms in rising order of their places. */
typedef struct list {
    uint32_t *places;
    float *values;
    size_t count;
} list;

static int start_list(cvol_context *context, list *out, size_t most)
{
    *out = (list){.places = cvol_allocate(most, sizeof *out->places),
                  .values = cvol_allocate(most, sizeof *out->values)};
    if (out->places && out->values)
        return CVOL_OK;
    return cvol_fail_memory(context, most * 8, "terms of the product");
}

static void list_plain(list *out, const cvol_sparse_shape *shape, const cvol_sparse_found *found)
{
    const size_t *cell = shape->cell, *cells = shape->cells, *dims = shape->dims;
    for (size_t row = 0; row < dims[1] * dims[2]; row++) {
        const size_t y = row % dims[1], z = row / dims[1];
        const uint32_t *index = found->index + cells[0] * (y / cell[1] + cells[1] * (z / cell[2]));
        const size_t inner = cell[0] * (y % cell[1] + cell[1] * (z % cell[2]));
        for (size_t x = 0; x < cells[0]; x++) {
            if (index[x] == UINT32_MAX)
                continue;
            const float *from = found->slots + index[x] * shape->cell_places + inner;
            for (size_t i = 0; i < cell[0]; i++) {
                out->places[out->count] = (uint32_t)(dims[0] * row + cell[0] * x + i);
                out->values[out->count++] = from[i];
            }
        }
    }
}

/* ---- the working group differs from the array's own group ------------------------------------ */

static void append(list *out, size_t place, float value)
{
    out->places[out->count] = (uint32_t)place;
    out->values[out->count++] = value;
}

/* Converts a slot of the working group (of the DFT) to the array's own: one, or two under DHT. */
static void append_slot(list *out, const cvol_sparse_shape *shape, const size_t at[3], float value)
{
    const size_t *dims = shape->dims, *length = shape->length;
    const int length_order = cvol_place_order(at, length), imaginary = length_order < 0;
    size_t place[3], mirror[3];
    for (int a = 0; a < 3; a++) { /* the first of the pair, as a signed frequency modulo n */
        size_t u = imaginary ? cvol_mirror_index(at[a], length[a]) : at[a];
        u = 2 * u <= length[a] ? u % dims[a] : dims[a] - 1 - (length[a] - u - 1) % dims[a];
        place[a] = a == 0 ? u * shape->inverse % dims[a] : u;
        mirror[a] = cvol_mirror_index(place[a], dims[a]);
    }
    const int order = cvol_place_order(place, dims);
    size_t own = place[0] + dims[0] * (place[1] + dims[1] * place[2]);
    size_t other = mirror[0] + dims[0] * (mirror[1] + dims[1] * mirror[2]);
    if (order == 0) { /* C and its conjugate meet */
        if (!imaginary)
            append(out, own, length_order ? (float)SQRT_2 * value : value);
        return;
    }
    if (order < 0) { /* the array stores the pair under its other place */
        const size_t swap = own;
        own = other;
        other = swap;
        value = imaginary ? -value : value;
    }
    if (shape->transform == CVOL_DFT) {
        append(out, imaginary ? other : own, value);
        return;
    }
    const float share = (float)SQRT_HALF * value;
    append(out, own, imaginary ? -share : share);
    append(out, other, share);
}

/* By radix, 11 bits at a time; equal places stay in order, so sums have the same bits. */
static void sort_list(list *from, list *spare)
{
    spare->count = from->count;
    for (int shift = 0; shift < 33; shift += 11) {
        size_t begin[2049] = {0};
        for (size_t i = 0; i < from->count; i++)
            begin[(from->places[i] >> shift & 2047) + 1]++;
        for (int i = 0; i < 2048; i++)
            begin[i + 1] += begin[i];
        for (size_t i = 0; i < from->count; i++) {
            const size_t to = begin[from->places[i] >> shift & 2047]++;
            spare->places[to] = from->places[i];
            spare->values[to] = from->values[i];
        }
        const list swap = *from;
        *from = *spare;
        *spare = swap;
    }
}

static void add_equal_places(list *of)
{
    size_t count = 0;
    for (size_t i = 0; i < of->count; i++) {
        if (count && of->places[count - 1] == of->places[i]) {
            of->values[count - 1] += of->values[i];
        } else {
            of->places[count] = of->places[i];
            of->values[count++] = of->values[i];
        }
    }
    of->count = count;
}

static int list_moved(cvol_context *context, list *out, const cvol_sparse_shape *shape,
                      const cvol_sparse_found *found)
{
    const size_t *cell = shape->cell, *cells = shape->cells;
    list spare;
    int rc = start_list(context, &spare, 2 * shape->present_count * shape->cell_places);
    for (size_t i = 0; i < shape->cell_count && !rc; i++) {
        if (found->index[i] == UINT32_MAX)
            continue;
        const size_t corner[3] = {i % cells[0] * cell[0], i / cells[0] % cells[1] * cell[1],
                                  i / cells[0] / cells[1] * cell[2]};
        const float *from = found->slots + found->index[i] * shape->cell_places;
        for (size_t j = 0; j < shape->cell_places; j++) {
            const size_t at[3] = {corner[0] + j % cell[0], corner[1] + j / cell[0] % cell[1],
                                  corner[2] + j / cell[0] / cell[1]};
            append_slot(out, shape, at, from[j]);
        }
    }
    if (!rc) {
        sort_list(out, &spare);
        add_equal_places(out);
    }
    free(spare.places);
    free(spare.values);
    return rc;
}

/* ---- the step -------------------------------------------------------------------------------- */

/* Removes terms below `cut`; the L2 norm of these, and of all. */
static double drop_below(list *of, double cut, double *norm)
{
    double small = 0, all = 0;
    size_t count = 0;
    for (size_t i = 0; i < of->count; i++) {
        const double v = (double)of->values[i];
        all += v * v;
        small += fabs(v) < cut ? v * v : 0;
        of->places[count] = of->places[i];
        of->values[count] = of->values[i];
        count += fabs(v) >= cut;
    }
    of->count = count;
    *norm = sqrt(all);
    return sqrt(small);
}

int cvol_sparse_keep(cvol_context *context, cvol_array *out, cvol_build_result *result, int *kept,
                     const cvol_sparse_shape *shape, const cvol_sparse_found *found, double noise,
                     double spent, const cvol_keep *keep)
{
    const size_t places = shape->present_count * shape->cell_places;
    const double allowed = cvol_array_allowed(out, keep);
    double rounding = shape->gain * noise / sqrt((double)shape->shift_count), dropped = 0;
    for (int a = 0; a < 3 && !found->plain; a++) /* number of working places that become one */
        rounding *= sqrt((double)((shape->length[a] - 1) / shape->dims[a] + 1));
    list terms;
    *kept = 0;
    int rc = start_list(context, &terms, (found->plain ? 1 : 2) * places);
    if (rc)
        goto done;
    if (found->plain)
        list_plain(&terms, shape, found);
    else
        rc = list_moved(context, &terms, shape, found);
    if (rc)
        goto done;
    /* Rounding at places without a term does not deserve a place. Under L2 and PSNR truncation
     * works by pairs and needs both slots of each. */
    const double cut = isfinite(allowed) ? 0 : rounding / sqrt((double)(places ? places : 1));
    const double lost = drop_below(&terms, cut, &result->norm);
    cvol_keep rest = *keep;
    if (isfinite(allowed)) {
        rest.rule = CVOL_KEEP_L2;
        rest.value = allowed - spent - 2 * rounding;
        if (rest.value <= 2 * cvol_array_rounding(out) * result->norm)
            goto done;
    }
    const cvol_candidates candidates = {
        .places = terms.places, .values = terms.values, .count = terms.count};
    rc = cvol_truncate(context, out, &dropped, &candidates, &rest);
    result->dropped = spent + rounding + cvol_hypot(dropped, lost);
    result->max_abs = -1;
    *kept = !rc;
done:
    free(terms.places);
    free(terms.values);
    return rc;
}
