/* From the folds to the product's terms.
 *
 * In every column the values of a bin r at the shifts are multiplied by e(-r shift / length), so
 * that one small matrix (sparse_shifts.c) gives the terms of all bins of the column. Terms at the
 * first place of a pair are written, with their mirrors, as slots. Bins beyond the stored half are
 * conjugates of their mirrors. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/multiply/sparse.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "transform/fft.h"
#include "transform/whole.h"

#define SQRT_2 1.41421356237309504880
#define KNOWN 256 /* matrices that a thread caches */

typedef struct solver {
    const cvol_sparse_shape *shape;
    const cvol_sparse_roots *roots;
    float *const *values;
    cvol_sparse_found *found;
    float *ramps; /* e(-i shift / length) along x: shift after shift, all real parts first */
} solver;

/* Private to a thread. */
typedef struct workspace {
    cvol_sparse_nodes nodes[KNOWN]; /* of the matrices */
    float (*matrices)[2 * CVOL_SPARSE_SHIFTS * CVOL_SPARSE_SHIFTS];
    float *turned; /* per shift: real parts of a row, imaginary parts */
    float *row;    /* the same of one node's terms */
    double stray;
} workspace;

static const float *known_matrix(workspace *work, const cvol_sparse_shape *shape,
                                 const cvol_sparse_nodes *nodes)
{
    uint64_t hash = 0;
    for (int i = 0; i < nodes->count; i++)
        hash = (hash ^ nodes->at[i]) * UINT64_C(0x9E3779B97F4A7C15);
    const size_t at = (size_t)(hash >> 56);
    if (memcmp(&work->nodes[at], nodes, sizeof *nodes)) {
        double matrix[2 * CVOL_SPARSE_SHIFTS * CVOL_SPARSE_SHIFTS] = {0};
        (void)cvol_sparse_solver(shape, nodes, matrix);
        for (size_t i = 0; i < 2 * CVOL_SPARSE_SHIFTS * CVOL_SPARSE_SHIFTS; i++)
            work->matrices[at][i] = (float)matrix[i];
        work->nodes[at] = *nodes;
    }
    return work->matrices[at];
}

/* ---- one row of a column --------------------------------------------------------------------- */

/* Multiplies the row of bins at `bin` by its phases, into work->turned. */
static void turn_row(const solver *solve, workspace *work, const size_t bin[3])
{
    const cvol_sparse_shape *shape = solve->shape;
    const size_t *fold = shape->fold, width = shape->cell[0], half = fold[0] / 2 + 1;
    const size_t other[2] = {bin[1] ? fold[1] - bin[1] : 0, bin[2] ? fold[2] - bin[2] : 0};
    const size_t here = half * (bin[1] + fold[1] * bin[2]);
    const size_t there = half * (other[0] + fold[1] * other[1]);
    const size_t stored = bin[0] >= half ? 0 : bin[0] + width <= half ? width : half - bin[0];
    for (size_t s = 0; s < shape->shift_count; s++) {
        const float *from = solve->values[s];
        const float *ramp = solve->ramps + 2 * width * s;
        float *re = work->turned + 2 * width * s, *im = re + width, c, d;
        cvol_sparse_phase(solve->roots, bin, shape->shifts[s], &c, &d);
        d = -d;
        for (size_t i = 0; i < stored; i++) {
            re[i] = from[2 * (here + bin[0] + i)];
            im[i] = from[2 * (here + bin[0] + i) + 1];
        }
        for (size_t i = stored; i < width; i++) {
            re[i] = from[2 * (there + fold[0] - bin[0] - i)];
            im[i] = -from[2 * (there + fold[0] - bin[0] - i) + 1];
        }
        for (size_t i = 0; i < width; i++) {
            const float x = c * ramp[i] - d * ramp[width + i];
            const float y = c * ramp[width + i] + d * ramp[i];
            const float t = re[i] * x - im[i] * y;
            im[i] = re[i] * y + im[i] * x;
            re[i] = t;
        }
    }
}

/* The terms of one node: weights[shift_count] pairs. */
static void combine_row(workspace *work, const float *weights, size_t shifts, size_t width)
{
    float *restrict re = work->row, *restrict im = re + width;
    memset(re, 0, 2 * width * sizeof *re);
    for (size_t s = 0; s < shifts; s++) {
        const float *restrict x = work->turned + 2 * width * s, *restrict y = x + width;
        const float c = weights[2 * s], d = weights[2 * s + 1];
        for (size_t i = 0; i < width; i++) {
            re[i] += c * x[i] - d * y[i];
            im[i] += c * y[i] + d * x[i];
        }
    }
}

/* Writes a row of coefficients from the working place `at` on as slots. */
static void write_row(const solver *solve, const workspace *work, const size_t at[3])
{
    const cvol_sparse_shape *shape = solve->shape;
    const size_t *length = shape->length, *cell = shape->cell, *cells = shape->cells;
    const size_t mirror[2] = {cvol_mirror_index(at[1], length[1]),
                              cvol_mirror_index(at[2], length[2])};
    const size_t line = mirror[0] / cell[1] + cells[1] * (mirror[1] / cell[2]);
    const size_t inner = cell[0] * (mirror[0] % cell[1] + cell[1] * (mirror[1] % cell[2]));
    const size_t own = at[0] / cell[0] +
                       cells[0] * (at[1] / cell[1] + cells[1] * (at[2] / cell[2]));
    float *to = solve->found->slots + solve->found->index[own] * shape->cell_places +
                cell[0] * (at[1] % cell[1] + cell[1] * (at[2] % cell[2]));
    const float root = (float)SQRT_2;
    const int dht = solve->found->plain && shape->transform == CVOL_DHT;
    for (size_t i = 0; i < cell[0] && 2 * (at[0] + i) <= length[0]; i++) {
        const size_t place[3] = {at[0] + i, at[1], at[2]};
        const float re = work->row[i], im = work->row[cell[0] + i];
        const int order = 2 * place[0] % length[0] ? 1 : cvol_place_order(place, length);
        if (order < 0)
            continue;
        to[i] = order == 0 ? re : dht ? re - im : root * re;
        if (order == 0)
            continue;
        const size_t x = cvol_mirror_index(place[0], length[0]);
        const uint32_t index = solve->found->index[x / cell[0] + cells[0] * line];
        if (index != UINT32_MAX) /* else it is 0: the mirror of a term is a term */
            solve->found->slots[index * shape->cell_places + inner + x % cell[0]] = dht ? re + im
                                                                                        : root * im;
    }
}

static void solve_column(const solver *solve, workspace *work, size_t column)
{
    const cvol_sparse_shape *shape = solve->shape;
    const size_t *cell = shape->cell, *columns = shape->columns, width = cell[0];
    const size_t first[3] = {column % columns[0] * cell[0],
                             column / columns[0] % columns[1] * cell[1],
                             column / columns[0] / columns[1] * cell[2]};
    const cvol_sparse_nodes *nodes = &shape->present_nodes[column];
    const float *matrix = nodes->count ? known_matrix(work, shape, nodes) : NULL;
    for (size_t row = 0; row < cell[1] * cell[2]; row++) {
        const size_t bin[3] = {first[0], first[1] + row % cell[1], first[2] + row / cell[1]};
        turn_row(solve, work, bin);
        for (size_t i = 0; !nodes->count && i < 2 * width * shape->shift_count; i++)
            work->stray += (double)work->turned[i] * (double)work->turned[i];
        for (size_t l = 0; l < nodes->count; l++) {
            const size_t node = nodes->at[l];
            const float *weights = matrix + 2 * shape->shift_count * l;
            const size_t at[3] = {
                bin[0] + shape->fold[0] * (node % shape->nodes[0]),
                bin[1] + shape->fold[1] * (node / shape->nodes[0] % shape->nodes[1]),
                bin[2] + shape->fold[2] * (node / shape->nodes[0] / shape->nodes[1])};
            if (2 * at[0] <= shape->length[0]) {
                combine_row(work, weights, shape->shift_count, width);
                write_row(solve, work, at);
            }
        }
    }
}

/* ---- all of them ----------------------------------------------------------------------------- */

static int start_solver(cvol_context *context, solver *solve)
{
    const cvol_sparse_shape *shape = solve->shape;
    const size_t width = shape->cell[0], places = shape->present_count * shape->cell_places;
    solve->found->index = cvol_allocate(shape->cell_count, sizeof *solve->found->index);
    solve->found->slots = cvol_allocate_zero(places, sizeof *solve->found->slots);
    solve->ramps = cvol_allocate(2 * width * shape->shift_count, sizeof *solve->ramps);
    if (!solve->found->index || !solve->found->slots || !solve->ramps)
        return cvol_fail_memory(context, places * sizeof(float), "terms of the product");
    uint32_t count = 0;
    for (size_t i = 0; i < shape->cell_count; i++)
        solve->found->index[i] = shape->present[i] ? count++ : UINT32_MAX;
    for (size_t s = 0; s < shape->shift_count; s++)
        for (size_t i = 0; i < width; i++) {
            const size_t at[3] = {i, 0, 0};
            float *ramp = solve->ramps + 2 * width * s;
            cvol_sparse_phase(solve->roots, at, shape->shifts[s], &ramp[i], &ramp[width + i]);
            ramp[width + i] = -ramp[width + i];
        }
    return CVOL_OK;
}

static int solve_all(cvol_context *context, const solver *solve, double *stray)
{
    const cvol_sparse_shape *shape = solve->shape;
    const size_t width = shape->cell[0];
    const int threads = cvol_context_threads(context);
    int rc = CVOL_OK, failed = 0;
    /* Per column, so that the sum is the same for any number of threads. */
    double *strays = cvol_allocate_zero(shape->column_count, sizeof *strays);
    if (!strays)
        return cvol_fail_memory(context, shape->column_count * sizeof *strays, "columns");
#pragma omp parallel num_threads(threads) reduction(| : failed)
    {
        workspace work = {.nodes = {{0}}};
        work.matrices = cvol_allocate(KNOWN, sizeof *work.matrices);
        work.turned = cvol_allocate(2 * width * shape->shift_count, sizeof *work.turned);
        work.row = cvol_allocate(2 * width, sizeof *work.row);
        failed = !work.matrices || !work.turned || !work.row;
#pragma omp for schedule(static)
        for (size_t column = 0; column < shape->column_count; column++) {
            if (failed)
                continue;
            work.stray = 0;
            solve_column(solve, &work, column);
            strays[column] = work.stray;
        }
        free(work.matrices);
        free(work.turned);
        free(work.row);
    }
    if (failed)
        rc = cvol_fail_memory(context, KNOWN * sizeof(float) * 288, "small systems");
    double sum = 0;
    for (size_t i = 0; i < shape->column_count; i++)
        sum += strays[i];
    *stray = sqrt(sum);
    free(strays);
    return rc;
}

/* ---- the step -------------------------------------------------------------------------------- */

int cvol_sparse_solve(cvol_context *context, cvol_sparse_found *found, double *stray,
                      const cvol_sparse_shape *shape, const cvol_sparse_roots roots[3],
                      float *const *values)
{
    memset(found, 0, sizeof *found);
    found->plain = shape->inverse == 1;
    for (int a = 0; a < 3; a++)
        found->plain &= shape->length[a] == shape->dims[a];
    solver solve = {.shape = shape, .roots = roots, .values = values, .found = found};
    int rc = start_solver(context, &solve);
    if (!rc)
        rc = solve_all(context, &solve, stray);
    free(solve.ramps);
    if (rc)
        cvol_sparse_found_free(found);
    return rc;
}

void cvol_sparse_found_free(cvol_sparse_found *found)
{
    free(found->index);
    free(found->slots);
    memset(found, 0, sizeof *found);
}
