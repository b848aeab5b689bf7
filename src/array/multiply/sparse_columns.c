/* The choice of the fold: the number of bins along each axis, by estimated time.
 *
 * Fewer bins hold more terms each, and need one sampling (shift) per cell of the fullest column. n
 * = 2^m has only one subgroup of each order: the folds are nested, and u -> sigma u (sigma odd)
 * permutes the bins of each without separating two places that share one. So there is no other
 * choice. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/multiply/sparse.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"

#define PI 3.14159265358979323846

/* Nanoseconds of three real transforms of `count` points, measured: longer ones leave the
 * caches. */
static double transforms_ns(double count)
{
    const double each = count <= 1 << 19 ? 0.15 : count <= 1 << 21 ? 0.2 : 0.3;
    return 3 * each * count * cvol_log2(count + 1);
}

static double full_ns(const cvol_sparse_shape *shape)
{
    const double n = (double)shape->dims[0] * (double)shape->dims[1] * (double)shape->dims[2];
    return transforms_ns(n) + 8 * n;
}

/* Choosing shifts and solving: one system for each set of nodes, mostly several times. */
static double systems_ns(const cvol_sparse_shape *shape, size_t nodes, double shifts)
{
    const double columns = (double)(shape->cell_count / nodes);
    const double sets = fmin(columns, (double)shape->present_count / shifts);
    return shifts > 1 ? 3 * sets * shifts * shifts * (15 + 4 * shifts) : 0;
}

static double fold_ns(const cvol_sparse_shape *shape, size_t nodes, size_t shifts, size_t terms)
{
    const double bins = (double)(shape->cell_count * shape->cell_places / nodes);
    const double s = (double)shifts, solved = (double)(shape->present_count * shape->cell_places);
    const int plain = !memcmp(shape->length, shape->dims, sizeof shape->length) &&
                      shape->inverse == 1;
    /* Short rows cost more; if the working group is another group, the terms must be sorted. */
    const double each = (1.5 * s + 5) * (1 + 8 / (double)shape->cell[0]) + (plain ? 0 : 40);
    return s * (transforms_ns(bins) + 2 * bins + 6 * (double)terms) + each * solved +
           systems_ns(shape, nodes, s);
}

/* The column of a cell, and the node of the cell. */
static size_t column_of(const size_t cells[3], const size_t columns[3], const size_t nodes[3],
                        size_t cell, unsigned *node)
{
    const size_t x = cell % cells[0], y = cell / cells[0] % cells[1],
                 z = cell / cells[0] / cells[1];
    *node = (unsigned)(x / columns[0] + nodes[0] * (y / columns[1] + nodes[1] * (z / columns[2])));
    return x % columns[0] + columns[0] * (y % columns[1] + columns[1] * (z % columns[2]));
}

/* The cells that may have terms, and counters of columns. */
typedef struct present_cells {
    uint32_t (*at)[3];
    size_t count;
    uint8_t *loads;
} present_cells;

static int list_cells(cvol_context *context, present_cells *out, const cvol_sparse_shape *shape)
{
    const size_t *cells = shape->cells, count = shape->present_count;
    out->at = cvol_allocate(count, sizeof *out->at);
    out->loads = cvol_allocate(shape->cell_count, 1);
    if (!out->at || !out->loads)
        return cvol_fail_memory(context, shape->cell_count + count * sizeof *out->at,
                                "folds of the product");
    out->count = 0;
    for (size_t i = 0; i < shape->cell_count; i++)
        if (shape->present[i]) {
            uint32_t *at = out->at[out->count++];
            at[0] = (uint32_t)(i % cells[0]);
            at[1] = (uint32_t)(i / cells[0] % cells[1]);
            at[2] = (uint32_t)(i / cells[0] / cells[1]);
        }
    return CVOL_OK;
}

/* The most present cells in one column, not counted beyond `limit`. */
static size_t fullest(const cvol_sparse_shape *shape, const size_t nodes[3],
                      const present_cells *present, size_t limit)
{
    const uint32_t columns[3] = {(uint32_t)(shape->cells[0] / nodes[0]),
                                 (uint32_t)(shape->cells[1] / nodes[1]),
                                 (uint32_t)(shape->cells[2] / nodes[2])};
    size_t most = 0;
    memset(present->loads, 0, (size_t)columns[0] * columns[1] * columns[2]);
    for (size_t i = 0; i < present->count && most <= limit; i++) {
        const uint32_t *at = present->at[i];
        const size_t column = at[0] % columns[0] +
                              columns[0] *
                                  (at[1] % columns[1] + (size_t)columns[1] * (at[2] % columns[2]));
        const size_t load = ++present->loads[column];
        most = load > most ? load : most;
    }
    return most;
}

static int make_node_roots(cvol_context *context, cvol_sparse_shape *shape)
{
    for (int a = 0; a < 3; a++) {
        const size_t count = shape->nodes[a];
        shape->node_roots[a] = cvol_allocate(2 * count, sizeof *shape->node_roots[a]);
        if (!shape->node_roots[a])
            return cvol_fail_memory(context, 2 * count * sizeof(double), "roots of unity");
        for (size_t t = 0; t < count; t++) {
            const double turn = 2 * PI * (double)t / (double)count;
            cvol_sincos(shape->node_roots[a] + 2 * t, turn);
        }
    }
    return CVOL_OK;
}

int cvol_sparse_choose_fold(cvol_context *context, cvol_sparse_shape *shape, int *found,
                            size_t terms)
{
    double best = full_ns(shape) / 2; /* a smaller saving is no structure */
    size_t nodes[3], chosen[3] = {0, 0, 0};
    present_cells present = {0};
    *found = 0;
    int code = list_cells(context, &present, shape);
    for (nodes[2] = 1; !code && shape->cells[2] % nodes[2] == 0; nodes[2] *= 2)
        for (nodes[1] = 1; shape->cells[1] % nodes[1] == 0; nodes[1] *= 2)
            for (nodes[0] = 1; shape->cells[0] % nodes[0] == 0; nodes[0] *= 2) {
                const size_t count = nodes[0] * nodes[1] * nodes[2];
                const size_t mean = (shape->present_count * count + shape->cell_count - 1) /
                                    shape->cell_count;
                if (count > CVOL_SPARSE_NODES || mean > CVOL_SPARSE_SHIFTS ||
                    fold_ns(shape, count, mean ? mean : 1, terms) >= best)
                    continue;
                size_t most = fullest(shape, nodes, &present, CVOL_SPARSE_SHIFTS);
                most = most ? most : 1;
                const double cost = fold_ns(shape, count, most, terms);
                if (most > CVOL_SPARSE_SHIFTS || cost >= best)
                    continue;
                best = cost;
                memcpy(chosen, nodes, sizeof chosen);
                shape->most = most;
            }
    free(present.at);
    free(present.loads);
    if (code || !chosen[0])
        return code;
    shape->cost_ns = best;
    /* |A + B| >= |A| + |B| - 1 (without wrapping around), each in a separate bin, and this
     * planning. */
    shape->least_ns = transforms_ns((double)(2 * terms)) + transforms_ns((double)shape->cell_count);
    shape->node_count = shape->column_count = shape->bins = 1;
    for (int a = 0; a < 3; a++) {
        shape->nodes[a] = chosen[a];
        shape->fold[a] = shape->length[a] / chosen[a];
        shape->columns[a] = shape->cells[a] / chosen[a];
        shape->node_count *= chosen[a];
        shape->column_count *= shape->columns[a];
        shape->bins *= shape->fold[a];
    }
    shape->present_nodes = cvol_allocate_zero(shape->column_count, sizeof *shape->present_nodes);
    if (!shape->present_nodes)
        return cvol_fail_memory(context, shape->column_count * sizeof *shape->present_nodes,
                                "folds of the product");
    for (size_t i = 0; i < shape->cell_count; i++)
        if (shape->present[i]) {
            unsigned node;
            const size_t column = column_of(shape->cells, shape->columns, shape->nodes, i, &node);
            cvol_sparse_nodes *list = &shape->present_nodes[column];
            list->at[list->count++] = (uint16_t)node;
        }
    *found = 1;
    return make_node_roots(context, shape);
}
