/* The chirp z-transform by Bluestein's convolution (chirp.h).
 *
 * With s = start / n, t = step / n and u counted from 0, the phase in turns is
 *     (s + j t)(first + u) = [s (first + u) + t u^2 / 2] + [t j first + t j^2 / 2] - t (j - u)^2 /
 * 2: a factor before, a factor after, and a convolution between them with exp(-pi i t m^2). The
 * adjoint exchanges the two factors and conjugates everything.
 */
#include "transform/chirp.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "transform/fft.h"
#include "transform/phase.h"

#define PI 3.14159265358979323846

struct cvol_chirp {
    size_t inputs, outputs, length;
    float *before, *after; /* pairs: inputs, outputs of them */
    float *kernel;         /* the convolution's spectrum: length pairs */
};

/* ---- phases ------------------------------------------------------------------------------- */

static cvol_phase signed_phase(cvol_phase p, int is_negative)
{
    return is_negative ? cvol_phase_negate(p) : p;
}

/* m^2 p */
static cvol_phase times_square(cvol_phase p, size_t m)
{
    return cvol_phase_multiply(cvol_phase_multiply(p, (int64_t)m), (int64_t)m);
}

static void unit(float out[2], cvol_phase phase, double scale)
{
    double at[2];
    cvol_sincos(at, 2 * PI * cvol_phase_turns(phase));
    out[0] = (float)(scale * at[0]);
    out[1] = (float)(scale * at[1]);
}

static inline void multiply(float out[2], const float a[2], const float b[2])
{
    const float re = a[0] * b[0] - a[1] * b[1];
    out[1] = a[0] * b[1] + a[1] * b[0];
    out[0] = re;
}

/* ---- plans -------------------------------------------------------------------------------- */

static void fill_factors(cvol_chirp *chirp, const cvol_chirp_shape *shape, int adjoint)
{
    const cvol_phase start = cvol_phase_of(shape->start, shape->n);
    const cvol_phase half = cvol_phase_of(shape->step, 2 * shape->n);
    const cvol_phase first = cvol_phase_multiply(cvol_phase_of(shape->step, shape->n),
                                                 shape->first);
    const double scale = 1 / (double)chirp->length; /* both transforms are unnormalised */
    float *frequencies = adjoint ? chirp->after : chirp->before;
    float *points = adjoint ? chirp->before : chirp->after;
    for (size_t u = 0; u < shape->frequencies; u++) {
        const cvol_phase along = cvol_phase_multiply(start, shape->first + (int64_t)u);
        unit(frequencies + 2 * u,
             signed_phase(cvol_phase_add(along, times_square(half, u)), adjoint),
             adjoint ? scale : 1);
    }
    for (size_t j = 0; j < shape->points; j++) {
        const cvol_phase along = cvol_phase_multiply(first, (int64_t)j);
        unit(points + 2 * j, signed_phase(cvol_phase_add(along, times_square(half, j)), adjoint),
             adjoint ? 1 : scale);
    }
    memset(chirp->kernel, 0, 2 * chirp->length * sizeof *chirp->kernel);
    for (size_t m = 0; m < chirp->outputs; m++)
        unit(chirp->kernel + 2 * m, signed_phase(times_square(half, m), !adjoint), 1);
    for (size_t m = 1; m < chirp->inputs; m++)
        unit(chirp->kernel + 2 * (chirp->length - m), signed_phase(times_square(half, m), !adjoint),
             1);
}

int cvol_chirp_create(cvol_context *context, cvol_chirp **out, const cvol_chirp_shape *shape,
                      int adjoint)
{
    *out = NULL;
    const size_t most = SIZE_MAX / 64;
    if (shape->frequencies > most || shape->points > most)
        return cvol_fail(context, CVOL_ERROR_LIMIT, "a chirp transform of %zu to %zu is too large",
                         shape->frequencies, shape->points);
    cvol_chirp *chirp = calloc(1, sizeof *chirp);
    if (!chirp)
        return cvol_fail_memory(context, sizeof *chirp, "a chirp transform");
    chirp->inputs = adjoint ? shape->points : shape->frequencies;
    chirp->outputs = adjoint ? shape->frequencies : shape->points;
    chirp->length = cvol_fft_good_length(chirp->inputs + chirp->outputs, 0);
    chirp->before = cvol_fft_allocate(2 * chirp->inputs);
    chirp->after = cvol_fft_allocate(2 * chirp->outputs);
    chirp->kernel = cvol_fft_allocate(2 * chirp->length);
    int code;
    if (!chirp->before || !chirp->after || !chirp->kernel) {
        code = cvol_fail_memory(context, 4 * chirp->length * sizeof(float), "a chirp transform");
    } else {
        fill_factors(chirp, shape, adjoint);
        const size_t dims[3] = {chirp->length, 1, 1};
        code = cvol_fft(context, CVOL_FFT_COMPLEX_FORWARD, dims, chirp->kernel, chirp->kernel);
    }
    if (code)
        cvol_chirp_free(chirp);
    else
        *out = chirp;
    return code;
}

void cvol_chirp_free(cvol_chirp *chirp)
{
    if (!chirp)
        return;
    free(chirp->before);
    free(chirp->after);
    free(chirp->kernel);
    free(chirp);
}

size_t cvol_chirp_work(const cvol_chirp *chirp)
{
    return 2 * chirp->length;
}

int cvol_chirp_apply(cvol_context *context, const cvol_chirp *chirp, float *out, size_t out_stride,
                     const float *in, size_t in_stride, float *work)
{
    const size_t dims[3] = {chirp->length, 1, 1}, inputs = chirp->inputs;
    for (size_t i = 0; i < inputs; i++)
        multiply(work + 2 * i, in + 2 * in_stride * i, chirp->before + 2 * i);
    memset(work + 2 * inputs, 0, 2 * (chirp->length - inputs) * sizeof *work);
    int code = cvol_fft(context, CVOL_FFT_COMPLEX_FORWARD, dims, work, work);
    if (code)
        return code;
    for (size_t i = 0; i < chirp->length; i++)
        multiply(work + 2 * i, work + 2 * i, chirp->kernel + 2 * i);
    code = cvol_fft(context, CVOL_FFT_COMPLEX_BACKWARD, dims, work, work);
    if (code)
        return code;
    for (size_t j = 0; j < chirp->outputs; j++)
        multiply(out + 2 * out_stride * j, work + 2 * j, chirp->after + 2 * j);
    return CVOL_OK;
}
