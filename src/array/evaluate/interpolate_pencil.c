/* From 2 m values at x = 0, 1, ... to at most m terms at unknown places, rank 1, by the matrix
 * pencil method (Hua and Sarkar 1990).
 *
 * The values are y[x] = sum_u c_u z_u^x with z_u = exp(2 pi i u / n). The vectors (1, z_u, z_u^2,
 * ...) span the rows of the Hankel matrix Y[i][j] = y[i + j] (m rows, m + 1 columns), and also its
 * right singular vectors V, one per place. If V1 is V without its last row and V2 without its
 * first, V2 = V1 P, and the eigenvalues of P are the z_u. Their angles are rounded to places, which
 * are completed to pairs, and the terms follow by least squares.
 *
 * The solver tries numbers of singular vectors, from the number of dominant ones upwards. It takes
 * the first rank whose terms fit the values within single precision. Otherwise it takes the best
 * one, and then moves its places one after the other while that reduces the error. Terms are
 * accepted only if no neighbouring place fits equally well. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/evaluate/interpolant.h"
#include "array/evaluate/interpolated.h"
#include "array/evaluate/small_matrix.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/whole.h"

#define MAX_TERMS 64
#define MAX_PLACES (2 * MAX_TERMS + 2)
#define GOOD 2e-7     /* of the values' norm: they have single precision */
#define ACCEPTED 1e-4 /* the limit that the interface promises */
#define STANDS_OUT 1e-3
#define WORTH_MOVING 0.1 /* of the norm; a worse fit is not near any terms */
#define DISTINCT 2e-6    /* of the norm: smaller differences are rounding of the values */
enum { MOVES_MAX = 8, FARTHEST = 3 };

typedef struct terms {
    size_t count;
    uint32_t places[MAX_PLACES]; /* rising */
    double values[MAX_PLACES];
    double residual;
} terms;

typedef struct pencil {
    cvol_transform transform;
    size_t n, most, count; /* count = 2 most */
    double y[2 * MAX_TERMS], norm;
    double vectors[(MAX_TERMS + 1) * MAX_TERMS], lengths[MAX_TERMS];
    double left[MAX_TERMS * MAX_TERMS], right[MAX_TERMS * MAX_TERMS];
    double complex matrix[MAX_TERMS * MAX_TERMS], roots[MAX_TERMS];
    double equations[2 * MAX_TERMS * MAX_TERMS], solution[2 * MAX_TERMS];
} pencil;

/* The singular vectors of the Hankel matrix: the orthogonalised columns of its transpose. */
static void find_vectors(pencil *of)
{
    const size_t m = of->most, rows = m + 1;
    for (size_t i = 0; i < m; i++)
        memcpy(of->vectors + rows * i, of->y + i, rows * sizeof *of->vectors);
    cvol_dense_orthogonalise(of->vectors, of->lengths, rows, m);
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < rows && of->lengths[i] > 0; j++)
            of->vectors[rows * i + j] /= of->lengths[i];
}

/* The eigenvalues of P for the first `rank` vectors. */
static int find_roots(pencil *of, size_t rank)
{
    const size_t m = of->most;
    for (size_t k = 0; k < rank; k++) {
        memcpy(of->left + m * k, of->vectors + (m + 1) * k, m * sizeof *of->left);
        memcpy(of->right + m * k, of->vectors + (m + 1) * k + 1, m * sizeof *of->right);
    }
    cvol_dense_least_squares(of->left, of->right, m, rank, rank);
    for (size_t k = 0; k < rank; k++)
        for (size_t i = 0; i < rank; i++)
            of->matrix[rank * k + i] = of->right[m * k + i];
    return cvol_dense_eigenvalues(of->roots, of->matrix, rank);
}

static void add_place(terms *to, size_t place)
{
    size_t at = to->count;
    for (size_t i = 0; i < to->count; i++)
        if (to->places[i] == place)
            return;
    for (; at > 0 && to->places[at - 1] > place; at--)
        to->places[at] = to->places[at - 1];
    to->places[at] = (uint32_t)place;
    to->count++;
}

/* The places nearest to the roots, and their mirrors. */
static void round_roots(terms *to, const pencil *of, size_t rank)
{
    to->count = 0;
    for (size_t i = 0; i < rank; i++) {
        const double turns = carg(of->roots[i]) / (2 * CVOL_PI);
        double place = rint(turns * (double)of->n);
        place = place < 0 ? place + (double)of->n : place;
        const size_t u = (size_t)place % of->n;
        add_place(to, u);
        add_place(to, cvol_mirror_index(u, of->n));
    }
}

/* Fits the terms at these places by least squares. */
static void fit_terms(terms *to, pencil *of)
{
    for (size_t t = 0; t < to->count; t++)
        cvol_interpolated_column(of->equations + of->count * t, of->transform, of->n, to->places[t],
                                 0, 1, of->count);
    memcpy(of->solution, of->y, of->count * sizeof *of->solution);
    cvol_dense_least_squares(of->equations, of->solution, of->count, to->count, 1);
    memcpy(to->values, of->solution, to->count * sizeof *to->values);
    memcpy(of->solution, of->y, of->count * sizeof *of->solution);
    for (size_t t = 0; t < to->count; t++) {
        cvol_interpolated_column(of->equations, of->transform, of->n, to->places[t], 0, 1,
                                 of->count);
        for (size_t j = 0; j < of->count; j++)
            of->solution[j] -= to->values[t] * of->equations[j];
    }
    double sum = 0;
    for (size_t j = 0; j < of->count; j++)
        sum += of->solution[j] * of->solution[j];
    to->residual = sqrt(sum);
}

/* The best terms of all ranks; residual infinite if no rank gave terms. */
static void find_terms(terms *best, pencil *of)
{
    size_t rank = 0;
    terms found;
    memset(best, 0, sizeof *best);
    best->residual = (double)INFINITY;
    find_vectors(of);
    while (rank < of->most && of->lengths[rank] > STANDS_OUT * of->lengths[0])
        rank++;
    for (; rank <= of->most && best->residual > GOOD * of->norm; rank++) {
        if (!find_roots(of, rank))
            continue;
        round_roots(&found, of, rank);
        if (found.count > of->most)
            continue;
        fit_terms(&found, of);
        if (found.residual < best->residual)
            *best = found;
    }
}

/* Moves the pair of number `t` by `by` places; 0 if there is no such place. */
static int move_pair(terms *to, pencil *of, const terms *from, size_t t, ptrdiff_t by)
{
    const size_t u = from->places[t], mirror = cvol_mirror_index(u, of->n);
    const ptrdiff_t place = (ptrdiff_t)u + by;
    if (u > mirror || place < 0 || 2 * (size_t)place > of->n)
        return 0;
    to->count = 0;
    for (size_t i = 0; i < from->count; i++)
        if (from->places[i] != u && from->places[i] != mirror)
            add_place(to, from->places[i]);
    add_place(to, (size_t)place);
    add_place(to, cvol_mirror_index((size_t)place, of->n));
    if (to->count > of->most)
        return 0;
    fit_terms(to, of);
    return 1;
}

/* Moves the pair that gains most, until no move helps. */
static void move_places(terms *best, pencil *of)
{
    terms found, better;
    for (int move = 0; move < MOVES_MAX && best->residual > GOOD * of->norm; move++) {
        better = *best;
        for (size_t t = 0; t < best->count; t++)
            for (ptrdiff_t by = -FARTHEST; by <= FARTHEST; by++)
                if (by && move_pair(&found, of, best, t, by) && found.residual < better.residual)
                    better = found;
        if (!(better.residual < best->residual))
            return;
        *best = better;
    }
}

/* Returns 1 if a neighbouring place fits equally well for a pair that matters. */
static int is_doubtful(const terms *best, pencil *of)
{
    const double least = fmax(DISTINCT * of->norm, 4 * best->residual);
    const double scale = sqrt((double)of->count / (double)of->n);
    terms found;
    for (size_t t = 0; t < best->count; t++) {
        double size = 0;
        for (size_t m = 0; m < best->count; m++)
            if (m == t || best->places[m] == cvol_mirror_index(best->places[t], of->n))
                size += fabs(best->values[m]);
        for (ptrdiff_t by = -1; by <= 1 && size * scale > ACCEPTED * of->norm; by += 2)
            if (move_pair(&found, of, best, t, by) && found.residual <= least)
                return 1;
    }
    return 0;
}

/* Drops terms that single precision cannot distinguish from zero; pairs of a DFT together. */
static void drop_noise(terms *of, const pencil *from)
{
    double largest = 0, size[MAX_PLACES];
    for (size_t t = 0; t < of->count; t++) {
        size[t] = fabs(of->values[t]);
        for (size_t m = 0; m < of->count && from->transform == CVOL_DFT; m++)
            if (of->places[m] == cvol_mirror_index(of->places[t], from->n))
                size[t] = fmax(size[t], fabs(of->values[m]));
        largest = fmax(largest, size[t]);
    }
    size_t kept = 0;
    for (size_t t = 0; t < of->count; t++)
        if (size[t] > GOOD * largest) {
            of->places[kept] = of->places[t];
            of->values[kept++] = of->values[t];
        }
    of->count = kept;
}

static int check(cvol_context *context, const float *values, size_t most, const cvol_grid *grid,
                 cvol_transform transform)
{
    if (transform == CVOL_DCT)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "the matrix pencil finds places of a DFT or a DHT, not of a DCT");
    if (!most || most > MAX_TERMS || most > grid->dims[0])
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "at most %zu terms, must be 1 .. %d and no more than the %zu samples",
                         most, MAX_TERMS, grid->dims[0]);
    return cvol_interpolated_check_values(context, values, 2 * most);
}

int cvol_array_interpolate_pencil(cvol_context *context, cvol_array **out, double *residual,
                                  const float *values, size_t most, const cvol_grid *grid,
                                  cvol_transform transform)
{
    cvol_array *array;
    terms best = {0};
    *out = NULL;
    int code = cvol_array_create_as(context, &array, grid, 1, transform, 0);
    if (code)
        return code;
    pencil *of = cvol_allocate_zero(1, sizeof *of);
    if (!of)
        code = cvol_fail_memory(context, sizeof *of, "the matrix pencil");
    if (!code)
        code = check(context, values, most, grid, transform);
    if (code)
        goto done;
    of->transform = transform;
    of->n = grid->dims[0];
    of->most = most;
    of->count = 2 * most;
    for (size_t j = 0; j < of->count; j++) {
        of->y[j] = (double)values[j];
        of->norm += of->y[j] * of->y[j];
    }
    of->norm = sqrt(of->norm);
    if (of->norm > 0)
        find_terms(&best, of);
    if (best.residual < WORTH_MOVING * of->norm)
        move_places(&best, of);
    if (best.residual > ACCEPTED * of->norm) {
        code = cvol_fail(context, CVOL_ERROR_TARGET,
                         "no %zu terms fit the values: the best have a residual of %g of %g "
                         "(L2)",
                         most, best.residual, of->norm);
        goto done;
    }
    if (is_doubtful(&best, of)) {
        code = cvol_fail(context, CVOL_ERROR_TARGET,
                         "the %zu values do not determine the places: other terms fit them equally "
                         "well within single precision; give more values",
                         of->count);
        goto done;
    }
    drop_noise(&best, of);
    code = cvol_interpolated_set(context, array, best.places, best.values, best.count);
    if (!code)
        code = cvol_interpolated_finish(context, array, 0);
done:
    free(of);
    if (code) {
        cvol_array_free(array);
        return code;
    }
    if (residual)
        *residual = best.residual;
    *out = array;
    return CVOL_OK;
}
