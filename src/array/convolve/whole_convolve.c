/* Circular convolution of two whole arrays. With orthonormal transforms F{a * b} = sqrt(N) F{a}
 * F{b}, so the result has a coefficient where both operands have one. DFT and DHT (by pairs: a
 * Hartley coefficient is the difference of the Fourier coefficient's parts; Bracewell 1983). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/convolve/convolve.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "array/truncate/spectrum_map.h"
#include "base/complex.h"
#include "base/context.h"
#include "base/memory.h"

typedef struct operands {
    const cvol_array *a, *b;
    const size_t *dims;
    double root; /* sqrt(N) */
} operands;

static double product_term(const void *user, const size_t place[3])
{
    const operands *o = user;
    const cvol_transform transform = o->a->transform;
    const double complex A = cvol_spectrum_coefficient(&o->a->whole, transform, o->dims, place);
    const double complex B = cvol_spectrum_coefficient(&o->b->whole, transform, o->dims, place);
    const double complex C = cvol_complex(creal(A) * creal(B) - cimag(A) * cimag(B),
                                          creal(A) * cimag(B) + cimag(A) * creal(B));
    return o->root * cvol_slot_of(transform, o->dims, place, C);
}

/* One row of the result's low box, which lies within the boxes of both operands. rows: room for six
 * rows of the longest length. */
static void convolve_row(cvol_spectrum *out, const operands *o, size_t v, size_t w, double *rows,
                         size_t longest)
{
    const cvol_transform transform = o->a->transform;
    const cvol_spectrum *inputs[2] = {&o->a->whole, &o->b->whole};
    double *re[2] = {rows, rows + 2 * longest}, *im[2] = {rows + longest, rows + 3 * longest};
    for (int k = 0; k < 2; k++) {
        const cvol_spectrum *s = inputs[k];
        cvol_spectrum_row(re[k], im[k], s, transform, o->dims,
                          v < out->low[1] ? v : v + s->box[1] - out->box[1],
                          w < out->low[2] ? w : w + s->box[2] - out->box[2]);
    }
    double *product_re = rows + 4 * longest, *product_im = rows + 5 * longest;
    for (size_t part = 0; part < 2; part++) { /* frequencies from 0 up, then the negative ones */
        const size_t begin = part ? out->low[0] : 0, end = part ? out->box[0] : out->low[0];
        const size_t a = part ? inputs[0]->box[0] - out->box[0] : 0;
        const size_t b = part ? inputs[1]->box[0] - out->box[0] : 0;
        for (size_t i = begin; i < end; i++) {
            const double ar = re[0][i + a], ai = im[0][i + a];
            const double br = re[1][i + b], bi = im[1][i + b];
            product_re[i] = o->root * (ar * br - ai * bi);
            product_im[i] = o->root * (ar * bi + ai * br);
        }
    }
    cvol_spectrum_set_row(out, transform, o->dims, v, w, product_re, product_im);
}

static int convolve_low_box(cvol_context *context, cvol_spectrum *out, const operands *o)
{
    const size_t x = o->a->whole.box[0], y = o->b->whole.box[0], longest = x > y ? x : y;
    const ptrdiff_t count = out->low_count ? (ptrdiff_t)(out->box[1] * out->box[2]) : 0;
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context)) if (count > 1)
    {
        double *rows = cvol_allocate(6 * longest, sizeof *rows);
        if (!rows) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(static)
        for (ptrdiff_t row = 0; row < count; row++)
            if (rows)
                convolve_row(out, o, (size_t)row % out->box[1], (size_t)row / out->box[1], rows,
                             longest);
        free(rows);
    }
    return failed ? cvol_fail_memory(context, 6 * longest * sizeof(double), "rows of coefficients")
                  : CVOL_OK;
}

/* Adds the place and its mirror if `other` has one of them. */
static void add_pair(uint32_t *places, size_t *count, const size_t place[3],
                     const cvol_spectrum *other, const size_t dims[3])
{
    const size_t at = cvol_place_mirror(place, dims);
    size_t mirror[3];
    cvol_place_split(mirror, at, dims);
    if (!cvol_spectrum_holds(other, dims, place) && !cvol_spectrum_holds(other, dims, mirror))
        return;
    places[(*count)++] = (uint32_t)cvol_place_join(place, dims);
    if (at != places[*count - 1])
        places[(*count)++] = (uint32_t)at;
}

/* Starts with the smaller low box, and the pairs beyond it that have a slot in both arrays. */
static int start_common(cvol_context *context, cvol_spectrum *out, const operands *o)
{
    const cvol_spectrum *x = &o->a->whole, *y = &o->b->whole;
    if (x->low_count + x->sparse_count > y->low_count + y->sparse_count) {
        const cvol_spectrum *swap = x;
        x = y;
        y = swap;
    }
    size_t low[3] = {0, 0, 0}, box[3], columns = x->box[0], rows = x->box[1];
    for (int a = 0; a < 3 && x->low_count && y->low_count; a++)
        low[a] = x->low[a] < y->low[a] ? x->low[a] : y->low[a];
    for (int a = 0; a < 3; a++) /* as cvol_spectrum_start sets it */
        box[a] = x->box[a] < y->box[a] ? x->box[a] : y->box[a];
    const size_t most = 2 * (x->low_count + x->sparse_count);
    uint32_t *places = cvol_allocate(most, sizeof *places);
    if (!places)
        return cvol_fail_memory(context, most * sizeof *places, "places");
    size_t count = 0;
    const int all = !memcmp(low, x->low, sizeof low);
    for (size_t i = 0; !all && i < x->low_count; i++) {
        const size_t index[3] = {i % columns, i / columns % rows, i / columns / rows};
        size_t place[3];
        int inside = low[0] != 0;
        for (int a = 0; a < 3; a++) {
            place[a] = cvol_box_place(index[a], x->low[a], x->box[a], o->dims[a]);
            inside &= inside && cvol_box_index(place[a], low[a], box[a], o->dims[a]) != SIZE_MAX;
        }
        if (!inside)
            add_pair(places, &count, place, y, o->dims);
    }
    for (size_t i = 0; i < x->sparse_count; i++) {
        size_t place[3];
        cvol_place_split(place, x->places[i], o->dims);
        add_pair(places, &count, place, y, o->dims);
    }
    int code = cvol_spectrum_start_places(context, out, o->a->transform, o->dims, low, places,
                                          count);
    free(places);
    return code;
}

int cvol_whole_convolve(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const cvol_array *b, const cvol_keep *keep)
{
    const operands o = {
        .a = a, .b = b, .dims = a->grid.dims, .root = sqrt((double)cvol_grid_samples(&a->grid))};
    cvol_spectrum terms;
    int code = start_common(context, &terms, &o);
    if (code)
        return code;
    code = convolve_low_box(context, &terms, &o);
    cvol_spectrum_fill_sparse(context, &terms, o.dims, product_term, &o);
    if (!code)
        code = cvol_spectrum_move(context, out, result, &terms, keep);
    cvol_spectrum_free(&terms);
    return code;
}

/* Returns 1 if b has both slots of the pair. */
static int has_pair(const cvol_spectrum *b, const size_t dims[3], const size_t place[3])
{
    size_t mirror[3];
    cvol_place_split(mirror, cvol_place_mirror(place, dims), dims);
    return cvol_spectrum_holds(b, dims, place) && cvol_spectrum_holds(b, dims, mirror);
}

/* Squares of magnitudes of one row of a's low box. */
static void largest_of_row(cvol_largest *most, const double *re, const double *im,
                           const cvol_array *a, const cvol_array *b, size_t v, size_t w)
{
    const cvol_spectrum *s = &a->whole;
    const size_t *dims = a->grid.dims;
    const int within = b->whole.low_count && s->low[0] <= b->whole.low[0] &&
                       s->low[1] <= b->whole.low[1] && s->low[2] <= b->whole.low[2];
    for (size_t i = 0; i < s->box[0]; i++) {
        const size_t place[3] = {cvol_box_place(i, s->low[0], s->box[0], dims[0]),
                                 cvol_box_place(v, s->low[1], s->box[1], dims[1]),
                                 cvol_box_place(w, s->low[2], s->box[2], dims[2])};
        double *at = within || has_pair(&b->whole, dims, place) ? &most->common : &most->alone;
        *at = fmax(*at, re[i] * re[i] + im[i] * im[i]);
    }
}

int cvol_whole_largest_coefficients(cvol_context *context, cvol_largest *out, const cvol_array *a,
                                    const cvol_array *b)
{
    const cvol_spectrum *s = &a->whole;
    const size_t *dims = a->grid.dims, length = s->box[0];
    cvol_largest most = {0, 0}; /* squares */
    double *rows = cvol_allocate(2 * length, sizeof *rows), *re = rows, *im = rows + length;
    if (!rows)
        return cvol_fail_memory(context, 2 * length * sizeof *rows, "a row of coefficients");
    for (size_t row = 0; s->low_count && row < s->box[1] * s->box[2]; row++) {
        const size_t v = row % s->box[1], w = row / s->box[1];
        cvol_spectrum_row(re, im, s, a->transform, dims, v, w);
        largest_of_row(&most, re, im, a, b, v, w);
    }
    free(rows);
    for (size_t i = 0; i < s->sparse_count; i++) {
        size_t place[3];
        cvol_place_split(place, s->places[i], dims);
        const double complex F = cvol_spectrum_coefficient(s, a->transform, dims, place);
        double *at = has_pair(&b->whole, dims, place) ? &most.common : &most.alone;
        *at = fmax(*at, creal(F) * creal(F) + cimag(F) * cimag(F));
    }
    *out = (cvol_largest){sqrt(most.common), sqrt(most.alone)};
    return CVOL_OK;
}
