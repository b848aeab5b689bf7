/* Reads a whole array at x - offset by the shift theorem. Along each axis F[u] is multiplied by
 * exp(-2 pi i u offset / n), u signed. The Nyquist frequency u = n / 2 of an even axis is
 * multiplied by cos(pi offset), since samples contain only its cosine. The operator is real, of
 * norm 1 at most.
 *
 * Between samples, values may leave the samples' range. The sum of |taps| of the interpolating
 * kernel (array/evaluate/dirichlet.h) bounds them. */
#include <math.h>
#include <string.h>

#include "array/algebra/operations.h"
#include "array/evaluate/dirichlet.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "array/truncate/spectrum_map.h"
#include "base/complex.h"
#include "base/context.h"
#include "base/elementary.h"

static const double PI = 3.14159265358979323846;

typedef struct ramp {
    const cvol_array *a;
    double offset[3]; /* within one period */
} ramp;

static double shifted_term(const void *user, const size_t place[3])
{
    const ramp *r = user;
    const size_t *dims = r->a->grid.dims;
    double turns = 0, scale = 1;
    for (int a = 0; a < 3; a++) {
        const double u = (double)place[a], n = (double)dims[a];
        if (2 * place[a] == dims[a])
            scale *= cvol_cos(PI * r->offset[a]);
        else
            turns += (2 * place[a] < dims[a] ? u : u - n) * r->offset[a] / n;
    }
    const double phase = -2 * PI * (turns - floor(turns));
    const double complex F = cvol_spectrum_coefficient(&r->a->whole, r->a->transform, dims, place);
    double turned[2];
    cvol_sincos(turned, phase);
    const double c = scale * turned[0], s = scale * turned[1];
    return cvol_slot_of(r->a->transform, dims, place,
                        cvol_complex(c * creal(F) - s * cimag(F), c * cimag(F) + s * creal(F)));
}

/* The sum of |taps| of the shift. */
static double sum_of_taps(const ramp *r)
{
    double sum = 1;
    for (int a = 0; a < 3; a++) {
        const size_t n = r->a->grid.dims[a];
        if (r->offset[a] == floor(r->offset[a]))
            continue;
        const int even = n % 2 == 0;
        sum *= cvol_dirichlet_sum(n, even ? n - 1 : n, r->offset[a], even, (double)n / 2);
    }
    return sum;
}

int cvol_array_shift(cvol_context *context, cvol_array **out, const cvol_array *a,
                     const double offset[3])
{
    *out = NULL;
    if (a->block || a->transform == CVOL_DCT)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "shift: works on whole arrays under dht and dft, which are periodic; this "
                         "is %s, block %d",
                         cvol_transform_name(a->transform), a->block);
    ramp r = {.a = a};
    int moves = 0;
    for (int axis = 0; axis < 3; axis++) {
        if (!isfinite(offset[axis]))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "shift: offset along %c is %g, must be finite", "xyz"[axis],
                             offset[axis]);
        if (axis >= a->rank && offset[axis] != 0)
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "shift: offset along %c is %g, but the array has rank %d", "xyz"[axis],
                             offset[axis], a -> rank);
        r.offset[axis] = fmod(offset[axis], (double)a->grid.dims[axis]);
        moves |= r.offset[axis] != 0;
    }
    cvol_array *array = NULL;
    cvol_spectrum terms;
    cvol_build_result result = {0};
    const cvol_keep all = cvol_keep_all();
    memset(&terms, 0, sizeof terms);
    int code = cvol_array_create_like(context, &array, a);
    if (!code)
        code = cvol_spectrum_start_like(context, &terms, a->transform, a->grid.dims, &a->whole,
                                        moves);
    if (code)
        goto done;
    cvol_rescale_set(array, a->grid.value_scale, a->grid.value_offset);
    cvol_spectrum_fill(context, &terms, a->grid.dims, shifted_term, &r);
    code = cvol_spectrum_move(context, array, &result, &terms, &all);
    if (code)
        goto done;
    array->error_bound = cvol_error_bound_filter(&a->error_bound, 1, sum_of_taps(&r), 1);
    cvol_array_account(array, &result, 0);
    code = cvol_array_check_error_bound(context, array, &array->error_bound, "shift");
    if (code)
        goto done;
    cvol_array_derive_figures(array);
    *out = array;
    array = NULL;
done:
    cvol_spectrum_free(&terms);
    cvol_array_free(array);
    return code;
}
