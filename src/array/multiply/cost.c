/* The cost model of products of whole arrays.
 *
 * Its constants are nanoseconds, measured on one core of an x86-64 server processor of 2023 with 1
 * MiB of second level cache. To measure them again, time each plan alone (cvol_array_multiply with
 * that plan) on the shapes named next to the constants, on one thread, and scale the constant by
 * measured over predicted (cvol_multiply_report.cost_ms). Only ratios decide the choice of plan. */
#include "array/multiply/cost.h"

#include <math.h>

#include "base/elementary.h"

/* n log2 n of a line, by kind; 256^3 and 1024^2, low boxes of 1/30 */
#define NS_ROW 0.12    /* real to half complex, contiguous */
#define NS_COLUMN 0.29 /* complex, adjacent */
#define NS_DCT 0.44    /* contiguous or adjacent */
#define NS_POINT 1.2   /* multiplying, clearing, summing dropped terms */
#define NS_LOAD 1.5    /* a coefficient between slots and lines, either way */
#define NS_SELECT 11.0 /* a candidate, if terms outside of a low box may be kept */
#define LARGE 2.0      /* factor of transforms whose line or plane exceeds the cache */
#define LARGE_FLOATS 100000
#define NS_CALL 3000 /* of a transform: plan look-up, clearing of buffers; 16 samples */

/* direct: a product of two terms; rank 1, 500 terms each, dense and scattered over 2^20 */
#define NS_DENSE 1.0
#define NS_DENSE_SCATTERED 20.0 /* into an array beyond the cache */
#define NS_HASHED 20.0
#define NS_HASHED_LARGE 45.0 /* if the table exceeds the cache */
#define HASHED_LARGE 30000   /* sums */
#define NS_SUM 40.0          /* a sum: reading, folding, sorting */
#define NS_HULL 1.5          /* a place of the dense array */
#define MAX_SUMS 1e8         /* limit of `direct` */

/* sparse: per term of the operands and of the kept ones, and log2. 2^16 to 2^22, rho 1/30,
 * harmonics with side bands and bands: 3.5 to 6. The constant is larger, since supports may have
 * less structure. An attempt that finds no structure costs 3 to 6 % of `full`. */
#define NS_SPARSE 8.0
#define NS_SPARSE_CALL 3e5

/* ---- lengths --------------------------------------------------------------------------------- */

/* The slowdown of a length against 16 m: single precision vectors need many factors of 2. Measured
 * over all good lengths below 2048. */
static double length_factor(size_t n, cvol_transform transform)
{
    static const double by_two[5] = {3.0, 1.5, 1.3, 1.2, 1.0};
    int twos = 0, threes = 0, fives = 0, sevens = 0;
    for (; n % 2 == 0; n /= 2)
        twos++;
    for (; n % 3 == 0; n /= 3)
        threes++;
    for (; n % 5 == 0; n /= 5)
        fives++;
    for (; n % 7 == 0; n /= 7)
        sevens++;
    const double rest = n == 1 ? 1 : n < 14 ? 2 : 6; /* other primes; Rader and Bluestein */
    if (transform == CVOL_DCT)
        return rest;
    return by_two[twos < 4 ? twos : 4] * (sevens ? 1.4 : 1) * (threes && fives ? 1.35 : 1) *
           (threes > 2 ? 1.4 : 1) * rest;
}

static double line_cost(size_t n, cvol_transform transform)
{
    return n == 1 ? 0 : (double)n * cvol_log2((double)n) * length_factor(n, transform);
}

/* The cheapest length >= n among all products of a power of 2 and up to 3^8, 5^4 and 7. */
static size_t cheapest_length(size_t n, cvol_transform transform)
{
    size_t best = 0;
    double least = (double)INFINITY;
    for (size_t seven = 1; seven <= 7; seven += 6)
        for (size_t five = 1; five <= 625; five *= 5)
            for (size_t three = 1; three <= 6561; three *= 3) {
                size_t m = seven * five * three;
                while (m < n)
                    m *= 2;
                const double cost = line_cost(m, transform);
                if (cost < least || (cost <= least && m < best)) {
                    least = cost;
                    best = m;
                }
            }
    return best;
}

size_t cvol_multiply_length(cvol_transform transform, size_t n, size_t extent)
{
    const size_t need = transform == CVOL_DCT ? extent + 1 : 2 * extent + 1;
    const size_t length = need < n ? cheapest_length(need, transform) : n;
    return length < n ? length : n;
}

void cvol_multiply_points(size_t points[3], const cvol_multiply_task *task)
{
    for (int a = 0; a < 3; a++)
        points[a] = cvol_multiply_length(task->transform, task->dims[a],
                                         task->extent[0][a] + task->extent[1][a]);
}

/* ---- the task -------------------------------------------------------------------------------- */

cvol_multiply_task cvol_multiply_task_of(const cvol_array *a, const cvol_array *b,
                                         const cvol_keep *keep)
{
    const cvol_array *operands[2] = {a, b};
    cvol_multiply_task task = {.transform = a->transform, .rank = a->rank, .kept_terms = -1};
    for (int i = 0; i < 2; i++) {
        const cvol_spectrum *whole = &operands[i]->whole;
        cvol_spectrum_extent(task.extent[i], whole, a->transform, a->grid.dims);
        task.terms[i] = (double)(whole->low_count + whole->sparse_count);
    }
    double low = 1;
    for (int i = 0; i < 3; i++) {
        task.dims[i] = a->grid.dims[i];
        task.kept[i] = keep->low[i] > 1 ? keep->low[i] : 1;
        const double k = (double)task.kept[i];
        low *= fmin(a->transform == CVOL_DCT ? k : 2 * k - 1, (double)task.dims[i]);
    }
    const int has_low = keep->low[0] || keep->low[1] || keep->low[2];
    task.low_only = keep->rule == CVOL_KEEP_TERMS && !keep->sparse && has_low;
    if (keep->rule == CVOL_KEEP_TERMS)
        task.kept_terms = (has_low ? low : 0) + (double)keep->sparse;
    return task;
}

/* ---- direct ---------------------------------------------------------------------------------- */

int cvol_multiply_is_dense(double hull, double products)
{
    return hull <= 65536 || (hull <= 2 * products && hull <= 67108864);
}

/* Frequencies of a low box of k on an axis of n. */
static double side(const cvol_multiply_task *task, size_t k, size_t n)
{
    const double both = 2 * (double)k - 1;
    return task->transform == CVOL_DCT ? (double)k : fmin(both, (double)n);
}

/* Returns 1 if neither operand fills half of its box. */
static int is_scattered(const cvol_multiply_task *task)
{
    int scattered = 1;
    for (int i = 0; i < 2; i++) {
        double box = 1;
        for (int a = 0; a < 3; a++)
            box *= side(task, task->extent[i][a] + 1, task->dims[a]);
        scattered &= task->terms[i] < 0.5 * box;
    }
    return scattered;
}

double cvol_multiply_cost_direct(const cvol_multiply_task *task)
{
    double hull = 1, products = task->terms[0] * task->terms[1];
    for (int a = 0; a < 3; a++)
        hull *= 2 * (double)(task->extent[0][a] + task->extent[1][a]) + 1;
    products *= task->transform == CVOL_DCT ? ldexp(1, task->rank) : 0.5;
    if (cvol_multiply_is_dense(hull, products)) {
        const double each = hull > HASHED_LARGE && is_scattered(task) ? NS_DENSE_SCATTERED
                                                                      : NS_DENSE;
        return 1e-6 * (NS_CALL + each * products + NS_SUM * fmin(hull, products) + NS_HULL * hull);
    }
    const double sums = fmin(hull, products);
    if (sums > MAX_SUMS)
        return (double)INFINITY;
    return 1e-6 * (NS_CALL + (sums > HASHED_LARGE ? NS_HASHED_LARGE : NS_HASHED) * products +
                   NS_SUM * sums);
}

/* ---- grid and full --------------------------------------------------------------------------- */

/* One operand, or the product, with a low box of k: all its lines, pruned. */
static double transform_cost(const cvol_multiply_task *task, const size_t points[3],
                             const size_t k[3])
{
    const int dct = task->transform == CVOL_DCT;
    const double column = dct ? NS_DCT : NS_COLUMN, row = dct ? NS_DCT : NS_ROW;
    const double inner = (double)k[0], middle = side(task, k[1], task->dims[1]);
    const double plane = (double)points[0] * (double)points[1];
    double outer = inner * middle * line_cost(points[2], task->transform) * column;
    double mid = inner * (double)points[2] * line_cost(points[1], task->transform) * column;
    double rows = (double)points[1] * (double)points[2] * line_cost(points[0], task->transform) *
                  row;
    const double large = points[2] > 1 && plane > LARGE_FLOATS ? LARGE : 1;
    if (points[1] == 1 && points[0] > LARGE_FLOATS)
        rows *= LARGE;
    const double coefficients = inner * middle * side(task, k[2], task->dims[2]);
    return outer + large * (mid + rows) + NS_LOAD * coefficients;
}

double cvol_multiply_cost_grid(const cvol_multiply_task *task, const size_t points[3])
{
    const double all = (double)points[0] * (double)points[1] * (double)points[2];
    size_t k[3][3];
    for (int a = 0; a < 3; a++) {
        const size_t most = task->transform == CVOL_DCT ? points[a] : points[a] / 2 + 1;
        k[0][a] = task->extent[0][a] + 1;
        k[1][a] = task->extent[1][a] + 1;
        k[2][a] = k[0][a] + k[1][a] - 1;
        if (task->low_only)
            k[2][a] = task->kept[a] < k[2][a] ? task->kept[a] : k[2][a];
        if (task->most[a])
            k[2][a] = task->most[a] < k[2][a] ? task->most[a] : k[2][a];
        k[2][a] = k[2][a] < most ? k[2][a] : most;
    }
    double sum = NS_CALL + NS_POINT * all;
    for (int i = 0; i < 3; i++)
        sum += transform_cost(task, points, k[i]);
    if (!task->low_only) {
        double candidates = NS_SELECT;
        for (int a = 0; a < 3; a++)
            candidates *= side(task, k[2][a], task->dims[a]);
        sum += candidates;
    }
    return 1e-6 * sum;
}

/* ---- sparse ---------------------------------------------------------------------------------- */

double cvol_multiply_cost_sparse(const cvol_multiply_task *task)
{
    if (task->transform == CVOL_DCT)
        return (double)INFINITY;
    const double terms = task->terms[0] + task->terms[1] +
                         (task->kept_terms >= 0 ? task->kept_terms
                                                : task->terms[0] * task->terms[1]);
    return 1e-6 * (NS_SPARSE_CALL + NS_SPARSE * terms * cvol_log2(terms + 2));
}
