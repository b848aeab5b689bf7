/* Orthogonal columns, least squares and eigenvalues of small matrices (small_matrix.h). */
#include "array/evaluate/small_matrix.h"

#include <float.h>
#include <math.h>
#include <string.h>

static double dot(const double *a, const double *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += a[i] * b[i];
    return sum;
}

/* ---- orthogonal columns ---------------------------------------------------------------------- */

/* Makes two columns orthogonal; 0 if they already were. */
static int rotate_columns(double *a, double *b, size_t rows)
{
    const double aa = dot(a, a, rows), bb = dot(b, b, rows), ab = dot(a, b, rows);
    if (fabs(ab) <= 1e-15 * sqrt(aa * bb) || ab == 0)
        return 0;
    const double zeta = (bb - aa) / (2 * ab);
    const double t = (zeta < 0 ? -1 : 1) / (fabs(zeta) + sqrt(1 + zeta * zeta));
    const double c = 1 / sqrt(1 + t * t), s = c * t;
    for (size_t i = 0; i < rows; i++) {
        const double x = a[i], y = b[i];
        a[i] = c * x - s * y;
        b[i] = s * x + c * y;
    }
    return 1;
}

static void swap_columns(double *a, double *b, size_t rows)
{
    for (size_t i = 0; i < rows; i++) {
        const double x = a[i];
        a[i] = b[i];
        b[i] = x;
    }
}

void cvol_dense_orthogonalise(double *a, double *lengths, size_t rows, size_t cols)
{
    int rotated = 1;
    for (int sweep = 0; sweep < 60 && rotated; sweep++) {
        rotated = 0;
        for (size_t i = 0; i < cols; i++)
            for (size_t j = i + 1; j < cols; j++)
                rotated |= rotate_columns(a + rows * i, a + rows * j, rows);
    }
    for (size_t i = 0; i < cols; i++)
        lengths[i] = sqrt(dot(a + rows * i, a + rows * i, rows));
    for (size_t i = 0; i < cols; i++) {
        size_t longest = i;
        for (size_t j = i + 1; j < cols; j++)
            if (lengths[j] > lengths[longest])
                longest = j;
        if (longest == i)
            continue;
        swap_columns(a + rows * i, a + rows * longest, rows);
        const double length = lengths[i];
        lengths[i] = lengths[longest];
        lengths[longest] = length;
    }
}

/* ---- least squares --------------------------------------------------------------------------- */

/* column -= 2 v (v . column), |v| = 1 */
static void reflect(double *column, const double *v, size_t count)
{
    const double twice = 2 * dot(v, column, count);
    for (size_t i = 0; i < count; i++)
        column[i] -= twice * v[i];
}

void cvol_dense_least_squares(double *a, double *b, size_t rows, size_t cols, size_t count)
{
    double largest = 0;
    for (size_t k = 0; k < cols; k++) {
        double *v = a + rows * k + k; /* becomes the reflection's vector below R's diagonal */
        const size_t rest = rows - k;
        const double length = sqrt(dot(v, v, rest));
        largest = fmax(largest, length);
        if (length <= 1e-14 * largest) {
            memset(v, 0, rest * sizeof *v);
            continue;
        }
        const double diagonal = v[0] > 0 ? -length : length;
        const double norm = sqrt(2 * length * (length + fabs(v[0])));
        v[0] -= diagonal;
        for (size_t i = 0; i < rest; i++)
            v[i] /= norm;
        for (size_t j = k + 1; j < cols; j++)
            reflect(a + rows * j + k, v, rest);
        for (size_t j = 0; j < count; j++)
            reflect(b + rows * j + k, v, rest);
        v[0] = diagonal; /* of R; v is no longer needed */
    }
    for (size_t j = 0; j < count; j++) {
        double *x = b + rows * j;
        for (size_t k = cols; k-- > 0;) {
            const double diagonal = a[rows * k + k];
            for (size_t i = k + 1; i < cols; i++)
                x[k] -= a[rows * i + k] * x[i];
            x[k] = diagonal != 0 ? x[k] / diagonal : 0;
        }
    }
}

/* ---- eigenvalues ----------------------------------------------------------------------------- */

/* Eliminates below the first subdiagonal by reflections from both sides. */
static void make_hessenberg(double complex *a, size_t n)
{
    for (size_t k = 0; k + 2 < n; k++) {
        double complex *v = a + n * k; /* rows k + 1 .. n - 1 of column k */
        double length = 0;
        for (size_t i = k + 1; i < n; i++)
            length += creal(v[i] * conj(v[i]));
        length = sqrt(length);
        if (length <= 0)
            continue;
        const double size = cabs(v[k + 1]);
        const double complex diagonal = size > 0 ? -length * (v[k + 1] / size) : -length;
        const double norm = sqrt(2 * length * (length + size));
        v[k + 1] -= diagonal;
        for (size_t i = k + 1; i < n; i++)
            v[i] /= norm;
        for (size_t j = k + 1; j < n; j++) { /* H A */
            double complex sum = 0;
            for (size_t i = k + 1; i < n; i++)
                sum += conj(v[i]) * a[n * j + i];
            for (size_t i = k + 1; i < n; i++)
                a[n * j + i] -= 2 * sum * v[i];
        }
        for (size_t i = 0; i < n; i++) { /* A H */
            double complex sum = 0;
            for (size_t j = k + 1; j < n; j++)
                sum += a[n * j + i] * v[j];
            for (size_t j = k + 1; j < n; j++)
                a[n * j + i] -= 2 * sum * conj(v[j]);
        }
        v[k + 1] = diagonal;
        for (size_t i = k + 2; i < n; i++)
            v[i] = 0;
    }
}

/* The eigenvalue of the last 2 x 2 of the leading m x m matrix that is nearer to its corner. */
static double complex find_shift(const double complex *a, size_t n, size_t m)
{
    const double complex p = a[n * (m - 2) + m - 2], q = a[n * (m - 1) + m - 2];
    const double complex r = a[n * (m - 2) + m - 1], s = a[n * (m - 1) + m - 1];
    const double complex half = (p + s) / 2, root = csqrt((p - s) * (p - s) / 4 + q * r);
    return cabs(half + root - s) < cabs(half - root - s) ? half + root : half - root;
}

/* A - shift = Q R, A = R Q + shift on rows and columns [begin, m), by Givens rotations. */
static void step(double complex *a, size_t n, size_t begin, size_t m, double complex shift,
                 double *cosines, double complex *sines)
{
    for (size_t i = begin; i < m; i++)
        a[n * i + i] -= shift;
    for (size_t k = begin; k + 1 < m; k++) {
        const double complex f = a[n * k + k], g = a[n * k + k + 1];
        const double length = hypot(cabs(f), cabs(g));
        double c = 1;
        double complex s = 0;
        if (length > 0) {
            c = cabs(f) / length;
            s = c > 0 ? f / cabs(f) * conj(g) / length : conj(g) / length;
        }
        cosines[k] = c;
        sines[k] = s;
        for (size_t j = k; j < m; j++) {
            const double complex x = a[n * j + k], y = a[n * j + k + 1];
            a[n * j + k] = c * x + s * y;
            a[n * j + k + 1] = c * y - conj(s) * x;
        }
    }
    for (size_t k = begin; k + 1 < m; k++)
        for (size_t i = begin; i < m && i <= k + 1; i++) {
            const double complex x = a[n * k + i], y = a[n * (k + 1) + i];
            a[n * k + i] = cosines[k] * x + conj(sines[k]) * y;
            a[n * (k + 1) + i] = cosines[k] * y - sines[k] * x;
        }
    for (size_t i = begin; i < m; i++)
        a[n * i + i] += shift;
}

int cvol_dense_eigenvalues(double complex *values, double complex *a, size_t n)
{
    double cosines[CVOL_DENSE_MAX];
    double complex sines[CVOL_DENSE_MAX];
    if (n > CVOL_DENSE_MAX)
        return 0;
    make_hessenberg(a, n);
    size_t m = n;
    for (int rounds = 0; m > 1;) {
        size_t begin = m - 1; /* the irreducible block */
        while (begin > 0 && cabs(a[n * (begin - 1) + begin]) >
                                DBL_EPSILON * (cabs(a[n * (begin - 1) + begin - 1]) +
                                               cabs(a[n * begin + begin])))
            begin--;
        if (begin == m - 1) {
            m--;
            rounds = 0;
            continue;
        }
        if (++rounds > 300)
            return 0;
        double complex shift = find_shift(a, n, m);
        if (rounds % 10 == 0) /* leave a cycle */
            shift += cabs(a[n * (m - 2) + m - 1]);
        step(a, n, begin, m, shift, cosines, sines);
    }
    for (size_t i = 0; i < n; i++)
        values[i] = a[n * i + i];
    return 1;
}
