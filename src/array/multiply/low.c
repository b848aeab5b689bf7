/* Which terms the plan `low` leaves out (low.h).
 *
 * With a' and b' the parts within the box, a" = a - a', b" = b - b',
 *
 *     a b - a' b' = a b" + b' a"
 *     |a b"|_2 <= |a|_max |b"|_2,   and   <= |x|_max |b"|_2 + |a - x|_2 |b"|_max
 *
 * where x is the exact array that a approximates: its range is known, and |a - x|_2 is at most the
 * l2_error of a. |b"|_max is at most the sum of the magnitudes of its terms, times the largest
 * value of a function of the transform. |b'|_max <= |b|_max + |b"|_max.
 *
 * The energy, and that sum, of the terms in each cell of a coarse histogram of frequencies are
 * summed first, then those beyond each of the boxes; boxes end at cells. */
#include "array/multiply/low.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/truncate/account.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/whole.h"

/* Of the bound that the operands carry, as much as results in blocks lose, less twice what such
 * losses have added to it: the bound of a chain at most doubles, as in truncate/blocks_keep.c. */
#define SHARE_OF_BOUND 0.2
#define SHARE_OF_NOISE 0.5 /* of the operand's error: about 1 dB of noise */
#define SHARE_OF_KEEP 0.5  /* of the loss that `keep` allows; the rest is for truncation */
#define TYPICAL 0.25
enum { BINS = 24 };

/* Relative costs of a point of the grid and of a candidate. */
#define POINT 16.0
#define CANDIDATE 11.0

/* ---- limits ---------------------------------------------------------------------------------- */

/* About the operand's error. The bound of a result of operations may be far above it, but
 * truncation dropped at most sqrt(N) times the threshold, and of spectra that fall off about a
 * quarter of it. */
static double noise_of(const cvol_array *a)
{
    const double dropped = a->threshold * sqrt((double)cvol_grid_samples(&a->grid));
    return fmin(a->error_bound.l2_error, TYPICAL * dropped);
}

int cvol_low_limits_of(cvol_low_limits *out, const cvol_array *product, double allowed,
                       const cvol_array *a, const cvol_array *b)
{
    const cvol_error_bound *bound = &product->error_bound;
    const double most = (double)INFINITY;
    *out = (cvol_low_limits){.beyond = {most, most}};
    if (allowed < 0) {
        out->lost = fmax(SHARE_OF_BOUND * (bound->l2_error - 2 * bound->default_loss), 0);
        out->beyond[0] = SHARE_OF_NOISE * noise_of(a);
        out->beyond[1] = SHARE_OF_NOISE * noise_of(b);
        return 1;
    }
    const double rounding = cvol_array_rounding(product) * sqrt(cvol_spectrum_energy(&b->whole)) *
                            cvol_error_bound_tighten(&a->error_bound);
    if (!isfinite(allowed))
        return 0;
    out->lost = fmax(SHARE_OF_KEEP * (allowed - 4 * rounding), 0);
    return 1;
}

/* ---- histograms ------------------------------------------------------------------------------ */

typedef struct histogram {
    size_t edges[3]
                [BINS + 1]; /* cell i of an axis has the frequencies edges[i] .. edges[i + 1] - 1 */
    size_t cells[3];
    uint8_t *bin[3];   /* of each place of an axis */
    double *energy[2]; /* of the operand's terms in each cell; then: within boxes that end there */
    double *sum[2];    /* of the magnitudes; the same */
    size_t extent[2][3];
} histogram;

static size_t cell_count(const histogram *h)
{
    return h->cells[0] * h->cells[1] * h->cells[2];
}

static void free_histogram(histogram *h)
{
    for (int i = 0; i < 3; i++)
        free(h->bin[i]);
    for (int i = 0; i < 2; i++) {
        free(h->energy[i]);
        free(h->sum[i]);
    }
}

static int start_histogram(cvol_context *context, histogram *h, const cvol_array *a,
                           size_t extent[2][3])
{
    const size_t *dims = a->grid.dims;
    memcpy(h->extent, extent, sizeof h->extent);
    int complete = 1;
    for (int i = 0; i < 3; i++) {
        const size_t x = h->extent[0][i], y = h->extent[1][i], all = 1 + (x > y ? x : y);
        h->cells[i] = all < BINS ? all : BINS;
        for (size_t c = 0; c <= h->cells[i]; c++)
            h->edges[i][c] = all * c / h->cells[i];
        h->bin[i] = cvol_allocate_zero(dims[i], 1);
        complete &= h->bin[i] != NULL;
        for (size_t u = 0; u < dims[i] && complete; u++) {
            const size_t f = a->transform == CVOL_DCT ? u : cvol_frequency(u, dims[i]);
            size_t c = f * h->cells[i] / all;
            c = c < h->cells[i] ? c : h->cells[i] - 1;
            c += c + 1 < h->cells[i] && f >= h->edges[i][c + 1];
            c -= f < h->edges[i][c];
            h->bin[i][u] = (uint8_t)c;
        }
    }
    for (int i = 0; i < 2; i++) {
        h->energy[i] = cvol_allocate_zero(cell_count(h), sizeof *h->energy[i]);
        h->sum[i] = cvol_allocate_zero(cell_count(h), sizeof *h->sum[i]);
        complete &= h->energy[i] && h->sum[i];
    }
    return complete ? CVOL_OK
                    : cvol_fail_memory(context, 4 * cell_count(h) * sizeof(double), "a histogram");
}

static void add_term(histogram *h, int operand, size_t cell, float value)
{
    const double v = (double)value;
    h->energy[operand][cell] += v * v;
    h->sum[operand][cell] += fabs(v);
}

static void fill_histogram(histogram *h, int operand, const cvol_array *array)
{
    const cvol_spectrum *whole = &array->whole;
    const size_t *dims = array->grid.dims, *low = whole->low, *box = whole->box;
    const float *from = whole->low_values;
    for (size_t w = 0; w < box[2]; w++)
        for (size_t v = 0; v < box[1]; v++) {
            const size_t cz = h->bin[2][cvol_box_place(w, low[2], box[2], dims[2])];
            const size_t cy = h->bin[1][cvol_box_place(v, low[1], box[1], dims[1])];
            const size_t row = h->cells[0] * (cy + h->cells[1] * cz);
            for (size_t u = 0; u < box[0]; u++)
                add_term(h, operand, row + h->bin[0][cvol_box_place(u, low[0], box[0], dims[0])],
                         *from++);
        }
    for (size_t s = 0; s < whole->sparse_count; s++) {
        const size_t place = whole->places[s], row = place / dims[0], z = row / dims[1];
        const size_t cell = h->bin[0][place - row * dims[0]] +
                            h->cells[0] *
                                (h->bin[1][row - z * dims[1]] + h->cells[1] * h->bin[2][z]);
        add_term(h, operand, cell, whole->values[s]);
    }
}

/* Sums over all cells that are not beyond the cell on any axis. */
static void accumulate(const histogram *h, double *of)
{
    size_t stride = 1;
    for (int axis = 0; axis < 3; axis++) {
        for (size_t i = 0; i < cell_count(h); i++)
            if (i / stride % h->cells[axis])
                of[i] += of[i - stride];
        stride *= h->cells[axis];
    }
}

/* ---- the choice ------------------------------------------------------------------------------ */

/* The largest value of a function of the transform. */
static double peak_of(const cvol_array *a)
{
    const double functions = a->transform == CVOL_DCT ? ldexp(1, a->rank) : 2;
    return sqrt(functions / (double)cvol_grid_samples(&a->grid));
}

/* Bounds |a b"|_2 with the sum of the magnitudes of all terms of a. */
static double product_bound(const cvol_array *a, double a_sum, double energy, double sum)
{
    const double peak = peak_of(a), norm = sqrt(energy),
                 exact = cvol_error_bound_largest(&a->error_bound);
    const double most = fmin(cvol_error_bound_tighten(&a->error_bound), peak * a_sum);
    return fmin(most * norm, exact * norm + a->error_bound.l2_error * peak * sum);
}

/* Bounds |a b - a' b'|_2. */
static double lost_bound(const cvol_array *a, const cvol_array *b, const double sums[2],
                         const double energy[2], const double sum[2])
{
    const double peak = peak_of(a);
    return (product_bound(a, sums[0], energy[1], sum[1]) +
            product_bound(b, sums[1], energy[0], sum[0]) + peak * sum[1] * sqrt(energy[0])) *
           (1 + 1e-9);
}

typedef struct beyond {
    double energy[2], sum[2];
} beyond;

static int is_within(const cvol_low_limits *limits, const cvol_array *a, const cvol_array *b,
                     const double sums[2], const beyond *out)
{
    for (int i = 0; i < 2; i++)
        if (out->energy[i] > limits->beyond[i] * limits->beyond[i])
            return 0;
    return lost_bound(a, b, sums, out->energy, out->sum) <= limits->lost;
}

static double box_cost(const histogram *h, const size_t *points[3], const size_t at[3],
                       cvol_transform transform, const size_t dims[3])
{
    double all = POINT, candidates = CANDIDATE;
    for (int i = 0; i < 3; i++) {
        const double edge = (double)h->edges[i][at[i] + 1];
        all *= (double)points[i][at[i]];
        candidates *= fmin(transform == CVOL_DCT ? edge : 2 * edge - 1, (double)dims[i]);
    }
    return all + candidates;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

static void choose_box(const histogram *h, size_t best[3], const cvol_array *a, const cvol_array *b,
                       const cvol_low_limits *limits)
{
    const size_t *dims = a->grid.dims, last = cell_count(h) - 1;
    const double sums[2] = {h->sum[0][last], h->sum[1][last]};
    size_t table[3][BINS];
    const size_t *points[3] = {table[0], table[1], table[2]};
    for (int i = 0; i < 3; i++)
        for (size_t c = 0; c < h->cells[i]; c++)
            table[i][c] = cvol_multiply_length(a->transform, dims[i],
                                               least(h->edges[i][c + 1] - 1, h->extent[0][i]) +
                                                   least(h->edges[i][c + 1] - 1, h->extent[1][i]));
    for (int i = 0; i < 3; i++)
        best[i] = h->cells[i] - 1;
    double cheapest = box_cost(h, points, best, a->transform, dims);
    for (size_t i = 0; i <= last; i++) {
        const size_t at[3] = {i % h->cells[0], i / h->cells[0] % h->cells[1],
                              i / h->cells[0] / h->cells[1]};
        const double cost = box_cost(h, points, at, a->transform, dims);
        if (cost >= cheapest)
            continue;
        beyond out;
        for (int j = 0; j < 2; j++) {
            out.energy[j] = fmax(h->energy[j][last] - h->energy[j][i], 0);
            out.sum[j] = fmax(h->sum[j][last] - h->sum[j][i], 0);
        }
        if (is_within(limits, a, b, sums, &out)) {
            cheapest = cost;
            memcpy(best, at, sizeof at);
        }
    }
}

/* The sums beyond the box, cell by cell: not as differences of larger ones. */
static beyond sum_beyond(const histogram *h, double *const energy[2], double *const sum[2],
                         const size_t at[3])
{
    beyond out = {{0, 0}, {0, 0}};
    for (size_t i = 0; i < cell_count(h); i++) {
        const int inside = i % h->cells[0] <= at[0] && i / h->cells[0] % h->cells[1] <= at[1] &&
                           i / h->cells[0] / h->cells[1] <= at[2];
        for (int j = 0; j < 2 && !inside; j++) {
            out.energy[j] += energy[j][i];
            out.sum[j] += sum[j][i];
        }
    }
    return out;
}

int cvol_low_choose(cvol_context *context, cvol_low_cut *out, const cvol_array *a,
                    const cvol_array *b, size_t extent[2][3], const cvol_low_limits *limits)
{
    histogram h;
    double *energy[2] = {NULL, NULL}, *sum[2] = {NULL, NULL};
    memset(&h, 0, sizeof h);
    memset(out, 0, sizeof *out);
    int code = start_histogram(context, &h, a, extent);
    for (int i = 0; i < 2 && !code; i++) {
        const size_t bytes = cell_count(&h) * sizeof(double);
        if (i && a == b) {
            memcpy(h.energy[1], energy[0], bytes);
            memcpy(h.sum[1], sum[0], bytes);
        } else {
            fill_histogram(&h, i, i ? b : a);
        }
        energy[i] = cvol_allocate(cell_count(&h), sizeof(double));
        sum[i] = cvol_allocate(cell_count(&h), sizeof(double));
        if (!energy[i] || !sum[i]) {
            code = cvol_fail_memory(context, 2 * bytes, "a histogram");
            break;
        }
        memcpy(energy[i], h.energy[i], bytes);
        memcpy(sum[i], h.sum[i], bytes);
        accumulate(&h, h.energy[i]);
        accumulate(&h, h.sum[i]);
    }
    if (!code) {
        size_t best[3];
        choose_box(&h, best, a, b, limits);
        const beyond rest = sum_beyond(&h, energy, sum, best);
        const size_t last = cell_count(&h) - 1;
        const double sums[2] = {h.sum[0][last], h.sum[1][last]};
        out->lost = lost_bound(a, b, sums, rest.energy, rest.sum);
        for (int i = 0; i < 2; i++) {
            out->beyond[i] = sqrt(rest.energy[i]);
            for (int axis = 0; axis < 3; axis++)
                out->extent[i][axis] = least(h.edges[axis][best[axis] + 1] - 1, h.extent[i][axis]);
        }
        for (int axis = 0; axis < 3; axis++)
            out->kept[axis] = h.edges[axis][best[axis] + 1];
    }
    for (int i = 0; i < 2; i++) {
        free(energy[i]);
        free(sum[i]);
    }
    free_histogram(&h);
    return code;
}

void cvol_low_candidates(size_t most[3], const cvol_low_cut *cut, const cvol_keep *keep)
{
    for (int i = 0; i < 3; i++)
        most[i] = cut->kept[i] && keep->low[i] > cut->kept[i] ? keep->low[i] : cut->kept[i];
}

/* ---- the operands ---------------------------------------------------------------------------- */

int cvol_low_spectrum(cvol_context *context, cvol_spectrum *out, const cvol_array *array,
                      const size_t extent[3])
{
    const cvol_spectrum *whole = &array->whole;
    const size_t *dims = array->grid.dims, *low = whole->low, *box = whole->box;
    const size_t k[3] = {extent[0] + 1, extent[1] + 1, extent[2] + 1};
    int code = cvol_spectrum_start(context, out, array->transform, dims, k);
    if (code)
        return code;
    const float *from = whole->low_values;
    for (size_t w = 0; w < box[2]; w++)
        for (size_t v = 0; v < box[1]; v++, from += box[0]) {
            const size_t z = cvol_box_index(cvol_box_place(w, low[2], box[2], dims[2]), out->low[2],
                                            out->box[2], dims[2]);
            const size_t y = cvol_box_index(cvol_box_place(v, low[1], box[1], dims[1]), out->low[1],
                                            out->box[1], dims[1]);
            if (y == SIZE_MAX || z == SIZE_MAX)
                continue;
            float *row = out->low_values + out->box[0] * (y + out->box[1] * z);
            const size_t first = least(low[0], out->low[0]);
            memcpy(row, from, first * sizeof *row);
            const size_t rest = least(box[0] - low[0], out->box[0] - out->low[0]);
            memcpy(row + out->box[0] - rest, from + box[0] - rest, rest * sizeof *row);
        }
    for (size_t s = 0; s < whole->sparse_count; s++) {
        const size_t place = whole->places[s], line = place / dims[0], plane = line / dims[1];
        const size_t x = cvol_box_index(place - line * dims[0], out->low[0], out->box[0], dims[0]);
        const size_t y = cvol_box_index(line - plane * dims[1], out->low[1], out->box[1], dims[1]);
        const size_t z = cvol_box_index(plane, out->low[2], out->box[2], dims[2]);
        if (x != SIZE_MAX && y != SIZE_MAX && z != SIZE_MAX)
            out->low_values[x + out->box[0] * (y + out->box[1] * z)] = whole->values[s];
    }
    return CVOL_OK;
}
