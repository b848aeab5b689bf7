/* The transforms of whole arrays by definition: inner products with N orthonormal vectors, in
 * double precision, one term after the other. The reference for fast transforms. */
#include <math.h>

#include "transform/whole.h"

#define PI 3.14159265358979323846

/* D_u(x) of cvol/array.h. */
static double cosine(size_t u, size_t x, size_t n)
{
    if (!u)
        return sqrt(1 / (double)n);
    const size_t turns = u * (2 * x + 1) % (4 * n); /* of pi / 2n */
    return sqrt(2 / (double)n) * cos(PI * (double)turns / (2 * (double)n));
}

/* Sample x of a slot's vector. */
static double basis(cvol_transform transform, const size_t place[3], const size_t x[3],
                    const size_t dims[3])
{
    if (transform == CVOL_DCT)
        return cosine(place[0], x[0], dims[0]) * cosine(place[1], x[1], dims[1]) *
               cosine(place[2], x[2], dims[2]);
    double t = 0, samples = 1;
    for (int a = 0; a < 3; a++) {
        t += 2 * PI * (double)(place[a] * x[a] % dims[a]) / (double)dims[a];
        samples *= (double)dims[a];
    }
    if (transform == CVOL_DHT)
        return (cos(t) + sin(t)) / sqrt(samples);
    const int order = cvol_place_order(place, dims);
    if (!order)
        return cos(t) / sqrt(samples);
    /* Im F[p] = -sum a sin t(p), and t(-p) = -t(p) */
    return sqrt(2 / samples) * (order > 0 ? cos(t) : sin(t));
}

static void next(size_t place[3], const size_t dims[3])
{
    for (int a = 0; a < 3; a++) {
        if (++place[a] < dims[a])
            return;
        place[a] = 0;
    }
}

void cvol_whole_forward_reference(cvol_transform transform, double *slots, const double *samples,
                                  const size_t dims[3])
{
    const size_t count = dims[0] * dims[1] * dims[2];
    size_t place[3] = {0}, x[3] = {0};
    for (size_t i = 0; i < count; i++, next(place, dims)) {
        slots[i] = 0;
        for (size_t j = 0; j < count; j++, next(x, dims))
            slots[i] += samples[j] * basis(transform, place, x, dims);
    }
}

void cvol_whole_inverse_reference(cvol_transform transform, double *samples, const double *slots,
                                  const size_t dims[3])
{
    const size_t count = dims[0] * dims[1] * dims[2];
    size_t place[3] = {0}, x[3] = {0};
    for (size_t i = 0; i < count; i++, next(x, dims)) {
        samples[i] = 0;
        for (size_t j = 0; j < count; j++, next(place, dims))
            samples[i] += slots[j] * basis(transform, place, x, dims);
    }
}
