/* Circular convolution of two whole arrays: with orthonormal transforms F{a * b} = sqrt(N) F{a}
 * F{b}, so that the result has a coefficient where both operands have one. DFT and DHT (by pairs: a
 * Hartley coefficient is the difference of the Fourier coefficient's parts; Bracewell 1983).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/operations.h"
#include "array/spectrum_map.h"
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
    const double complex C = CMPLX(creal(A) * creal(B) - cimag(A) * cimag(B),
                                   creal(A) * cimag(B) + cimag(A) * creal(B));
    return o->root * cvol_slot_of(transform, o->dims, place, C);
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

/* The smaller low box, and the pairs beyond it of which both arrays have a slot. */
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
    for (size_t i = 0; i < x->low_count; i++) {
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
    cvol_spectrum_fill(context, &terms, o.dims, product_term, &o);
    code = cvol_spectrum_hand_over(context, out, result, &terms, keep);
    cvol_spectrum_free(&terms);
    return code;
}

double cvol_whole_largest_coefficient(const cvol_array *a)
{
    const cvol_spectrum *s = &a->whole;
    const size_t *dims = a->grid.dims;
    double largest = 0;
    for (size_t i = 0; i < s->low_count + s->sparse_count; i++) {
        size_t place[3];
        if (i < s->low_count) {
            cvol_place_split(place, i, s->box);
            for (int x = 0; x < 3; x++)
                place[x] = cvol_box_place(place[x], s->low[x], s->box[x], dims[x]);
        } else {
            cvol_place_split(place, s->places[i - s->low_count], dims);
        }
        largest = fmax(largest, cabs(cvol_spectrum_coefficient(s, a->transform, dims, place)));
    }
    return largest;
}
