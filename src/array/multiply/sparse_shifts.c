/* The choice of shifts, and the small linear systems that they lead to.
 *
 * A bin with terms at the nodes t_1 .. t_l has at shift x the value y(x) = sum_i C_i e(t_i x /
 * nodes). With at least as many shifts as nodes, the C_i follow by least squares. Consecutive
 * shifts of one axis give a Vandermonde matrix, which is never singular, but ill-conditioned if
 * nodes are neighbours; others may be better, or singular. So several sets, drawn with fixed seeds,
 * are tried, and the one with the smallest worst case over all columns is taken; its `gain` bounds
 * the amplification of rounding. */
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/multiply/sparse.h"
#include "base/complex.h"
#include "base/context.h"
#include "base/memory.h"

#define TRIES 12
#define GOOD_GAIN 4.0 /* below this no more shifts are added */
#define MAX_GAIN 64.0 /* rounding of single precision times this is still small */
#define MAX_SETS 4096

/* (V^H V)^-1 V^H by Gauss-Jordan elimination with the diagonal as pivot (positive definite). */
double cvol_sparse_solver(const cvol_sparse_shape *shape, const cvol_sparse_nodes *nodes,
                          double *matrix)
{
    double complex v[CVOL_SPARSE_SHIFTS][CVOL_SPARSE_SHIFTS];
    double complex g[CVOL_SPARSE_SHIFTS][2 * CVOL_SPARSE_SHIFTS];
    const size_t count = shape->shift_count, l = nodes->count;
    if (l > count)
        return INFINITY;
    for (size_t i = 0; i < l; i++) {
        const size_t node = nodes->at[i];
        const size_t t[3] = {node % shape->nodes[0], node / shape->nodes[0] % shape->nodes[1],
                             node / shape->nodes[0] / shape->nodes[1]};
        for (size_t s = 0; s < count; s++) {
            v[s][i] = 1;
            for (int a = 0; a < 3; a++) {
                const size_t turn = t[a] * shape->shifts[s][a] % shape->nodes[a];
                const double *root = shape->node_roots[a] + 2 * turn;
                v[s][i] *= cvol_complex(root[0], root[1]);
            }
        }
    }
    for (size_t i = 0; i < l; i++)
        for (size_t j = 0; j < l; j++) {
            g[i][j] = 0;
            g[i][l + j] = i == j;
            for (size_t s = 0; s < count; s++)
                g[i][j] += conj(v[s][i]) * v[s][j];
        }
    for (size_t p = 0; p < l; p++) {
        if (!(creal(g[p][p]) > 1e-6 * (double)count))
            return INFINITY;
        const double complex inverse = 1 / g[p][p];
        for (size_t j = 0; j < 2 * l; j++)
            g[p][j] *= inverse;
        for (size_t i = 0; i < l; i++) {
            const double complex factor = g[i][p];
            for (size_t j = 0; j < 2 * l && i != p; j++)
                g[i][j] -= factor * g[p][j];
        }
    }
    double norm = 0;
    for (size_t i = 0; i < l; i++)
        for (size_t s = 0; s < count; s++) {
            double complex sum = 0;
            for (size_t j = 0; j < l; j++)
                sum += g[i][l + j] * conj(v[s][j]);
            matrix[2 * (count * i + s)] = creal(sum);
            matrix[2 * (count * i + s) + 1] = cimag(sum);
            norm += creal(sum) * creal(sum) + cimag(sum) * cimag(sum);
        }
    return sqrt(norm * (double)count);
}

static int compare_nodes(const void *one, const void *two)
{
    return memcmp(one, two, sizeof(cvol_sparse_nodes));
}

/* The columns' distinct sets of nodes, without the empty one. */
static size_t distinct_nodes(cvol_sparse_nodes *out, const cvol_sparse_shape *shape)
{
    memcpy(out, shape->present_nodes, shape->column_count * sizeof *out);
    qsort(out, shape->column_count, sizeof *out, compare_nodes);
    size_t count = 0;
    for (size_t i = 0; i < shape->column_count; i++)
        if (out[i].count && (!count || compare_nodes(&out[i], &out[count - 1])))
            out[count++] = out[i];
    return count;
}

static int is_drawn(const size_t *shifts, size_t count, size_t shift)
{
    for (size_t i = 0; i < count; i++)
        if (shifts[i] == shift)
            return 1;
    return 0;
}

/* The try-th set of `count` shifts: consecutive ones along x, y, z, then random ones without
 * repetition. The first is 0. */
static void draw_shifts(cvol_sparse_shape *shape, size_t count, uint64_t try)
{
    size_t drawn[CVOL_SPARSE_SHIFTS];
    uint64_t seed = UINT64_C(0x9E3779B97F4A7C15) * (try + 1);
    for (size_t s = 0; s < count; s++) {
        size_t shift = s;
        if (try && s) {
            do {
                seed ^= seed << 13;
                seed ^= seed >> 7;
                seed ^= seed << 17;
                shift = (size_t)(seed >> 32) % shape->node_count;
            } while (is_drawn(drawn, s, shift));
        }
        drawn[s] = shift;
        shape->shifts[s][0] = shift % shape->nodes[0];
        shape->shifts[s][1] = shift / shape->nodes[0] % shape->nodes[1];
        shape->shifts[s][2] = shift / shape->nodes[0] / shape->nodes[1];
    }
    shape->shift_count = count;
}

static double worst_gain(const cvol_sparse_shape *shape, const cvol_sparse_nodes *nodes,
                         size_t count, double limit)
{
    double worst = 1, matrix[2 * CVOL_SPARSE_SHIFTS * CVOL_SPARSE_SHIFTS];
    for (size_t i = 0; i < count && worst < limit; i++)
        worst = fmax(worst, cvol_sparse_solver(shape, &nodes[i], matrix));
    return worst;
}

int cvol_sparse_choose_shifts(cvol_context *context, cvol_sparse_shape *shape, int *found)
{
    cvol_sparse_nodes *nodes = cvol_allocate(shape->column_count, sizeof *nodes);
    *found = 0;
    if (!nodes)
        return cvol_fail_memory(context, shape->column_count * sizeof *nodes,
                                "folds of the product");
    const size_t distinct = distinct_nodes(nodes, shape);
    size_t limit = shape->most + 2;
    limit = limit < CVOL_SPARSE_SHIFTS ? limit : CVOL_SPARSE_SHIFTS;
    limit = limit < shape->node_count ? limit : shape->node_count;
    double best = MAX_GAIN;
    size_t best_count = 0;
    uint64_t best_try = 0;
    for (size_t count = shape->most; count <= limit && distinct <= MAX_SETS; count++) {
        for (uint64_t try = 0; try < TRIES && best > GOOD_GAIN; try++) {
            draw_shifts(shape, count, try);
            const double gain = worst_gain(shape, nodes, distinct, best);
            if (gain < best) {
                best = gain;
                best_count = count;
                best_try = try;
            }
        }
    }
    free(nodes);
    if (!best_count)
        return CVOL_OK;
    draw_shifts(shape, best_count, best_try);
    shape->gain = best;
    *found = 1;
    return CVOL_OK;
}
