/* The product of two whole arrays by samples on a grid: evaluate both, multiply, transform back,
 * truncate.
 *
 * Let the grid have M points per axis and the span of the samples. The product of two spectra up to
 * E_a and E_b is exact if no alias meets it (DFT, DHT: M >= 2 (E_a + E_b) + 1; DCT: M >= E_a + E_b
 * + 1), and for M = n points, where frequencies alias as in the product of the samples. With T the
 * transform of one axis, unnormalised (transform/fft.h), an axis of n samples takes DFT, DHT   a(i)
 * = n^-1/2 T^-1 F_a           F_ab = (n^1/2 / M) T (a b) DCT        a(i) = (2n)^-1/2 T^-1 c'A_a
 * A_ab = ((n/2)^1/2 / M) T (a b) / c' with c' = sqrt 2 for frequency 0, else 1.
 *
 * Transforms are pruned (Markel 1971): the operands' spectra are low boxes, and lines of the
 * product that are not kept stop early (passes.c). */
#include <math.h>
#include <string.h>

#include "array/multiply/multiply.h"
#include "array/multiply/passes.h"
#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"

/* In two dimensions y is the outer axis, the middle one has length 1. */
static void order_axes(size_t out[3], const size_t in[3], const size_t dims[3])
{
    const int flat = dims[2] == 1;
    out[0] = in[0];
    out[1] = in[flat ? 2 : 1];
    out[2] = in[flat ? 1 : 2];
}

/* Returns 1 if only a low box is kept, so that lines beyond it need not be finished. */
static int keeps_low_box_only(const cvol_keep *keep)
{
    return keep->rule == CVOL_KEEP_TERMS && !keep->sparse &&
           (keep->low[0] || keep->low[1] || keep->low[2]);
}

/* The slots of an operand's box: its own low box if it has nothing more. */
static int gather_operand(cvol_context *context, cvol_passes *work, int operand,
                          const cvol_array *a)
{
    const cvol_spectrum *whole = &a->whole;
    const size_t *dims = a->grid.dims;
    size_t extent[3], low[3];
    cvol_spectrum_extent(extent, whole, a->transform, dims);
    for (int i = 0; i < 3; i++)
        extent[i]++;
    order_axes(low, extent, dims);
    cvol_slot_box *box = &work->in[operand];
    *box = cvol_slot_box_of(a->transform, work->n, low);
    if (!whole->sparse_count && whole->low_count == cvol_slot_box_count(box)) {
        work->slots[operand] = whole->low_values;
        return CVOL_OK;
    }
    cvol_spectrum all;
    int code = cvol_spectrum_start(context, &all, a->transform, dims, extent);
    if (code)
        return code;
    work->slots[operand] = work->owned[operand] = all.low_values;
    size_t index[3];
    const float *from = whole->low_values;
    for (index[2] = 0; index[2] < whole->box[2]; index[2]++)
        for (index[1] = 0; index[1] < whole->box[1]; index[1]++)
            for (index[0] = 0; index[0] < whole->box[0]; index[0]++) {
                size_t to[3];
                for (int i = 0; i < 3; i++)
                    to[i] = cvol_box_index(
                        cvol_box_place(index[i], whole->low[i], whole->box[i], dims[i]), all.low[i],
                        all.box[i], dims[i]);
                all.low_values[to[0] + all.box[0] * (to[1] + all.box[1] * to[2])] = *from++;
            }
    for (size_t s = 0; s < whole->sparse_count; s++) {
        size_t rest = whole->places[s], to[3];
        for (int i = 0; i < 3; i++, rest /= dims[i - 1])
            to[i] = cvol_box_index(rest % dims[i], all.low[i], all.box[i], dims[i]);
        all.low_values[to[0] + all.box[0] * (to[1] + all.box[1] * to[2])] = whole->values[s];
    }
    return CVOL_OK;
}

static int set_up(cvol_context *context, cvol_passes *work, const cvol_array *a,
                  const cvol_array *b, const size_t points[3], const size_t *most,
                  const cvol_keep *keep)
{
    const size_t *dims = a->grid.dims;
    work->transform = a->transform;
    order_axes(work->n, dims, dims);
    order_axes(work->m, points, dims);
    int code = gather_operand(context, work, 0, a);
    if (!code)
        code = gather_operand(context, work, 1, b);
    if (code)
        return code;
    size_t low[3], kept_low[3], most_low[3];
    order_axes(kept_low, keep->low, dims);
    order_axes(most_low, most ? most : dims, dims);
    for (int i = 0; i < 3; i++) {
        low[i] = work->in[0].low[i] + work->in[1].low[i] - 1;
        if (keeps_low_box_only(keep) && kept_low[i] < low[i])
            low[i] = kept_low[i];
        if (most && most_low[i] < low[i])
            low[i] = most_low[i];
    }
    work->out = cvol_slot_box_of(a->transform, work->n, low);
    return cvol_passes_start(context, work);
}

/* Keeps the low box at its requested size: zeros beyond the end of the product. */
static int keep_low_box(cvol_context *context, cvol_array *out, const cvol_passes *work,
                        const cvol_keep *keep)
{
    cvol_spectrum *whole = &out->whole;
    int code = cvol_spectrum_start(context, whole, out->transform, out->grid.dims, keep->low);
    if (code)
        return code;
    size_t low[3], box[3];
    order_axes(low, whole->low, out->grid.dims);
    order_axes(box, whole->box, out->grid.dims);
    const cvol_slot_box *from = &work->out;
    for (size_t w = 0; w < from->box[2]; w++)
        for (size_t v = 0; v < from->box[1]; v++) {
            const size_t in[2] = {v, w};
            size_t to[2];
            for (int i = 0; i < 2; i++) {
                const size_t n = from->n[i + 1];
                to[i] = cvol_box_index(cvol_box_place(in[i], from->low[i + 1], from->box[i + 1], n),
                                       low[i + 1], box[i + 1], n);
            }
            const float *row = work->kept + from->box[0] * (v + from->box[1] * w);
            float *target = whole->low_values + box[0] * (to[0] + box[1] * to[1]);
            memcpy(target, row, from->low[0] * sizeof *row);
            const size_t rest = from->box[0] - from->low[0];
            memcpy(target + box[0] - rest, row + from->low[0], rest * sizeof *row);
        }
    return CVOL_OK;
}

/* most: the candidates are the product's frequencies below this one of each axis; NULL: all. */
static int multiply_within(cvol_context *context, cvol_array *out, cvol_build_result *result,
                           const cvol_array *a, const cvol_array *b, const size_t points[3],
                           const size_t *most, const cvol_keep *keep)
{
    cvol_passes work = {.transform = a->transform};
    double lost = 0, dropped = 0;
    int code = set_up(context, &work, a, b, points, most, keep);
    if (!code)
        code = cvol_passes_run(context, &work);
    if (code)
        goto done;
    for (size_t i = 0; i < work.energies; i++)
        lost += work.energy[i];
    if (keeps_low_box_only(keep)) {
        code = keep_low_box(context, out, &work, keep);
    } else {
        size_t low[3], box[3];
        order_axes(low, work.out.low, out->grid.dims);
        order_axes(box, work.out.box, out->grid.dims);
        const cvol_candidates candidates = {
            .slots = work.kept, .low = {low[0], low[1], low[2]}, .box = {box[0], box[1], box[2]}};
        code = cvol_truncate(context, out, &dropped, &candidates, keep);
    }
    if (code)
        goto done;
    result->dropped = sqrt(lost + dropped * dropped);
    result->norm = sqrt(lost + dropped * dropped + cvol_spectrum_energy(&out->whole));
    result->max_abs = work.all_points ? 0 : -1;
    for (size_t i = 0; i < work.slabs && work.all_points; i++)
        result->max_abs = fmax(result->max_abs, work.largest[i]);
done:
    cvol_passes_free(&work);
    return code;
}

int cvol_multiply_grid(cvol_context *context, cvol_array *out, cvol_build_result *result,
                       const cvol_array *a, const cvol_array *b, const size_t points[3],
                       const cvol_keep *keep)
{
    return multiply_within(context, out, result, a, b, points, NULL, keep);
}

int cvol_multiply_low(cvol_context *context, cvol_array *out, cvol_build_result *result,
                      const cvol_array *a, const cvol_array *b, const cvol_low_cut *cut,
                      const cvol_keep *keep, size_t points[3])
{
    cvol_array parts[2] = {*a, *b}; /* they share all but the terms, and are not freed */
    int code = CVOL_OK;
    memset(&parts[0].whole, 0, sizeof parts[0].whole);
    memset(&parts[1].whole, 0, sizeof parts[1].whole);
    for (int i = 0; i < 2 && !code; i++)
        code = cvol_low_spectrum(context, &parts[i].whole, i ? b : a, cut->extent[i]);
    size_t most[3];
    for (int i = 0; i < 3; i++) {
        points[i] = cvol_multiply_length(a->transform, a->grid.dims[i],
                                         cut->extent[0][i] + cut->extent[1][i]);
    }
    cvol_low_candidates(most, cut, keep);
    if (!code)
        code = multiply_within(context, out, result, &parts[0], &parts[1], points,
                               cut->kept[0] ? most : NULL, keep);
    cvol_spectrum_free(&parts[0].whole);
    cvol_spectrum_free(&parts[1].whole);
    result->dropped += cut->lost;
    return code;
}
