/* Magnitudes and order of the candidates of a truncation. */
#include "array/truncate/candidates.h"

#include <math.h>

#include "array/core/level.h"
#include "array/core/spectrum.h"
#include "base/context.h"
#include "transform/whole.h"

/* The first list index whose place is not below `place`. */
static size_t find_place(const cvol_candidates *c, size_t begin, size_t end, size_t place)
{
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (c->places[middle] < place)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin;
}

/* ---- magnitudes ----------------------------------------------------------------------------- */

/* In double precision squares of floats neither overflow nor vanish. */
static float pair_magnitude(float a, float b)
{
    return (float)sqrt(0.5 * ((double)a * (double)a + (double)b * (double)b));
}

/* One row of a dense box of a DFT. Box indices mirror as places do: the box is symmetric. */
static void pair_row(float *keys, const cvol_candidates *c, size_t row)
{
    const size_t *box = c->box, v = row % box[1], w = row / box[1];
    const size_t mirror = cvol_mirror_index(v, box[1]) + box[1] * cvol_mirror_index(w, box[2]);
    const float *from = c->slots + row * box[0], *other = c->slots + mirror * box[0];
    keys += row * box[0];
    keys[0] = row == mirror ? fabsf(from[0]) : pair_magnitude(from[0], other[0]);
    for (size_t i = 1; i < box[0]; i++)
        keys[i] = pair_magnitude(from[i], other[box[0] - i]);
}

/* Listed places first .. end - 1 lie in one row; rising in it is falling in its mirror row. */
static void pair_listed_row(float *keys, const cvol_candidates *c, size_t first, size_t end,
                            const size_t dims[3])
{
    const size_t row = c->places[first] / dims[0], v = row % dims[1], w = row / dims[1];
    const size_t base = dims[0] *
                        (cvol_mirror_index(v, dims[1]) + dims[1] * cvol_mirror_index(w, dims[2]));
    const size_t least = find_place(c, 0, c->count, base);
    size_t j = find_place(c, least, c->count, base + dims[0]);
    for (size_t i = first; i < end; i++) {
        const size_t place = c->places[i], u = place - row * dims[0];
        const size_t mirror = base + cvol_mirror_index(u, dims[0]);
        size_t at = least;
        if (u) {
            while (j > least && c->places[j - 1] > mirror)
                j--;
            at = j > least ? j - 1 : j;
        }
        const int found = at < c->count && c->places[at] == mirror;
        keys[i] = mirror == place ? fabsf(c->values[i])
                                  : pair_magnitude(c->values[i], found ? c->values[at] : 0);
    }
}

void cvol_candidates_keys(cvol_context *context, float *keys, const cvol_candidates *c,
                          cvol_transform transform, const size_t dims[3])
{
    const size_t dense = cvol_candidates_dense(c);
    if (transform != CVOL_DFT) {
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
        for (size_t i = 0; i < dense; i++)
            keys[i] = fabsf(c->slots[i]);
        for (size_t i = 0; i < c->count; i++)
            keys[dense + i] = fabsf(c->values[i]);
        return;
    }
    const size_t rows = dense ? c->box[1] * c->box[2] : 0;
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t row = 0; row < rows; row++)
        pair_row(keys, c, row);
    for (size_t i = 0; i < c->count;) {
        const size_t row_end = (c->places[i] / dims[0] + 1) * dims[0];
        size_t end = i;
        while (end < c->count && c->places[end] < row_end)
            end++;
        pair_listed_row(keys + dense, c, i, end, dims);
        i = end;
    }
}

size_t cvol_mirror_place(cvol_transform transform, size_t place, const size_t dims[3])
{
    if (transform != CVOL_DFT)
        return place;
    const size_t u = place % dims[0], v = place / dims[0] % dims[1], w = place / dims[0] / dims[1];
    return cvol_mirror_index(u, dims[0]) +
           dims[0] * (cvol_mirror_index(v, dims[1]) + dims[1] * cvol_mirror_index(w, dims[2]));
}

/* ---- runs ------------------------------------------------------------------------------------ */

static size_t place_of_dense(const cvol_candidates *c, const size_t dims[3], size_t index)
{
    const size_t *low = c->low, *box = c->box;
    const size_t i = index % box[0], v = index / box[0] % box[1], w = index / box[0] / box[1];
    return cvol_box_place(i, low[0], box[0], dims[0]) +
           dims[0] * (cvol_box_place(v, low[1], box[1], dims[1]) +
                      dims[1] * cvol_box_place(w, low[2], box[2], dims[2]));
}

cvol_run_cursor cvol_runs_start(const cvol_candidates *c, const size_t dims[3], size_t part,
                                size_t parts)
{
    const size_t dense = cvol_candidates_dense(c);
    cvol_run_cursor cursor = {.dense = cvol_part_begin(dense, part, parts),
                              .dense_end = cvol_part_begin(dense, part + 1, parts),
                              .list_end = c->count};
    if (!dense) {
        cursor.list = cvol_part_begin(c->count, part, parts);
        cursor.list_end = cvol_part_begin(c->count, part + 1, parts);
        return cursor;
    }
    if (part > 0)
        cursor.list = find_place(c, 0, c->count, place_of_dense(c, dims, cursor.dense));
    if (part + 1 < parts)
        cursor.list_end = find_place(c, 0, c->count, place_of_dense(c, dims, cursor.dense_end));
    return cursor;
}

int cvol_runs_next(cvol_run_cursor *cursor, cvol_run *run, const cvol_candidates *c,
                   const size_t dims[3])
{
    size_t place = SIZE_MAX;
    if (cursor->dense < cursor->dense_end)
        place = place_of_dense(c, dims, cursor->dense);
    if (cursor->list < cursor->list_end && c->places[cursor->list] < place) {
        size_t end = cursor->list + 1;
        while (end < cursor->list_end && c->places[end] < place)
            end++;
        *run = (cvol_run){.listed = 1, .first = cursor->list, .count = end - cursor->list};
        cursor->list = end;
        return 1;
    }
    if (place == SIZE_MAX)
        return 0;
    const size_t i = cursor->dense % c->box[0];
    size_t count = (i < c->low[0] ? c->low[0] : c->box[0]) - i;
    if (count > cursor->dense_end - cursor->dense)
        count = cursor->dense_end - cursor->dense;
    *run = (cvol_run){.first = cursor->dense, .count = count, .place = place};
    cursor->dense += count;
    return 1;
}
