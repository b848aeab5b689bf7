/* Dilation: in rank 1, places like sigma j with small |j| (harmonics of any fundamental, aliased or
 * not) lie anywhere, but m = 1 / sigma modulo n brings them all near 0. u -> m u is an automorphism
 * of the cyclic group, so products keep their form.
 *
 * m is found by lattice reduction (Lenstra, Lenstra and Lovasz 1982). For a few of the places u_i
 * the vectors (m w, m u_1 mod n, ..., m u_d mod n) form a lattice of dimension d + 1. If all m u_i
 * mod n are well below n^(d / (d + 1)), the vector of that m is by far its shortest. Any multiplier
 * is correct; a poor one only makes the plan find no structure. */
#include <math.h>
#include <string.h>

#include "array/multiply/sparse.h"
#include "transform/whole.h"

#define PLACES 7
#define SIZE (PLACES + 1)
#define SWAPS 2000 /* ends the reduction in any case */

/* Coordinates are integers, exact in double: below n (n < 2^32) except for short combinations. */
typedef struct lattice {
    double v[SIZE][SIZE];
    double star[SIZE][SIZE], mu[SIZE][SIZE], norm[SIZE];
    double weight; /* of the first coordinate, m itself */
} lattice;

static double inner(const lattice *l, const double *a, const double *b)
{
    double sum = l->weight * l->weight * a[0] * b[0];
    for (int i = 1; i < SIZE; i++)
        sum += a[i] * b[i];
    return sum;
}

/* Gram and Schmidt, from scratch: SIZE is small. */
static void orthogonalise(lattice *l)
{
    for (int i = 0; i < SIZE; i++) {
        memcpy(l->star[i], l->v[i], sizeof l->star[i]);
        for (int j = 0; j < i; j++) {
            l->mu[i][j] = inner(l, l->v[i], l->star[j]) / l->norm[j];
            for (int k = 0; k < SIZE; k++)
                l->star[i][k] -= l->mu[i][j] * l->star[j][k];
        }
        l->norm[i] = inner(l, l->star[i], l->star[i]);
    }
}

static void reduce(lattice *l)
{
    orthogonalise(l);
    for (int i = 1, swaps = 0; i < SIZE && swaps < SWAPS;) {
        for (int j = i - 1; j >= 0; j--) {
            const double times = nearbyint(l->mu[i][j]);
            if (times == 0)
                continue;
            for (int k = 0; k < SIZE; k++)
                l->v[i][k] -= times * l->v[j][k];
            for (int k = 0; k < j; k++)
                l->mu[i][k] -= times * l->mu[j][k];
            l->mu[i][j] -= times;
        }
        if (l->norm[i] >= (0.75 - l->mu[i][i - 1] * l->mu[i][i - 1]) * l->norm[i - 1]) {
            i++;
            continue;
        }
        for (int k = 0; k < SIZE; k++) {
            const double swap = l->v[i][k];
            l->v[i][k] = l->v[i - 1][k];
            l->v[i - 1][k] = swap;
        }
        orthogonalise(l);
        swaps++;
        i = i > 1 ? i - 1 : 1;
    }
}

/* The inverse of m modulo n, or 0 if they have a common factor. */
static size_t inverse_of(size_t m, size_t n)
{
    int64_t r[2] = {(int64_t)n, (int64_t)(m % n)}, t[2] = {0, 1};
    while (r[1]) {
        const int64_t q = r[0] / r[1], next_r = r[0] - q * r[1], next_t = t[0] - q * t[1];
        r[0] = r[1];
        r[1] = next_r;
        t[0] = t[1];
        t[1] = next_t;
    }
    return r[0] != 1 ? 0 : (size_t)(t[0] < 0 ? t[0] + (int64_t)n : t[0]);
}

/* The largest |m u| modulo n; it stops when this is not less than `limit`. */
static size_t reach_of(const cvol_sparse_terms *terms, size_t n, size_t m, size_t limit)
{
    size_t reach = 0;
    for (size_t i = 0; i < terms->count && reach < limit; i++) {
        const size_t u = cvol_frequency(terms->terms[i].at[0] * m % n, n);
        reach = u > reach ? u : reach;
    }
    return reach;
}

size_t cvol_sparse_multiplier(const cvol_sparse_terms *a, const cvol_sparse_terms *b, size_t n,
                              size_t *inverse)
{
    lattice l = {.weight = 1.0 / 1024};
    size_t best = 1, limit = n / 8;
    *inverse = 1;
    if (!a->count || !b->count || n < 64)
        return best;
    l.v[0][0] = 1;
    /* Random places: evenly spaced ones of a regular support have short vectors. */
    uint64_t seed = UINT64_C(0x9E3779B97F4A7C15);
    for (int i = 1; i < SIZE; i++) {
        const cvol_sparse_terms *from = i & 1 ? a : b;
        seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        l.v[0][i] = from->terms[(size_t)(seed >> 32) % from->count].at[0];
        l.v[i][i] = (double)n;
    }
    reduce(&l);
    for (int i = 0; i < SIZE; i++)
        for (int j = 0; j <= 2 * i; j++) { /* v_i, v_i + v_j', v_i - v_j' */
            const double other = j == 0 ? 0 : l.v[(j - 1) / 2][0];
            const double sum = fmod(l.v[i][0] + (j & 1 ? other : -other), (double)n);
            const size_t m = (size_t)(sum < 0 ? sum + (double)n : sum);
            const size_t back = inverse_of(m, n);
            if (!back)
                continue;
            size_t reach = reach_of(a, n, m, limit);
            if (reach < limit)
                reach += reach_of(b, n, m, limit - reach);
            if (reach >= limit)
                continue;
            limit = reach;
            best = m;
            *inverse = back;
        }
    return best;
}
