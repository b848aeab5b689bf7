/* Lebesgue constants of band-limited interpolation: the sums of |taps| of Dirichlet kernels,
 *     D_m(t) = sum_{|u| <= (m - 1) / 2} exp(2 pi i u t / n) = sin(pi m t / n) / sin(pi t / n).
 */
#include "array/evaluate/dirichlet.h"

#include <math.h>

#include "base/elementary.h"

static const double PI = 3.14159265358979323846;

/* Beyond this number of samples the sum is bounded, not computed. */
#define MAX_SAMPLES ((size_t)1 << 20)

double cvol_dirichlet_sum(size_t n, size_t count, double offset, double weight, double edge)
{
    const double length = (double)n, m = (double)count;
    const double turn = offset - floor(offset / length) * length;
    if (n > MAX_SAMPLES) /* |sin(pi t / n)| >= 2 |t| / n for |t| <= n / 2, and |D_m| <= m <= n for
                          * the two nearest samples: 2 + 2 sum_{k <= n / 2} 1 / (2 k) */
        return 3 + cvol_log(length) + fabs(weight);
    double sum = 0;
    for (size_t j = 0; j < n; j++) {
        const double t = (double)j + turn;
        double below[2], above[2], last[2]; /* cosine and sine */
        cvol_sincos(below, PI * t / length);
        cvol_sincos(above, PI * m * t / length);
        cvol_sincos(last, 2 * PI * edge * t / length);
        double h = fabs(below[1]) < 1e-12 ? m : above[1] / below[1];
        h += weight * last[0];
        sum += fabs(h);
    }
    return sum / length * (1 + 1e-9);
}
