/* A whole array's terms as complex coefficients. A slot (transform/whole.h) gives a share of the
 * coefficient F at the first place p of its pair:
 *
 *     DFT  slot[p] = v: v / sqrt 2      slot[-p] = v: i v / sqrt 2
 *     DHT  slot[p] = v: v (1 - i) / 2   slot[-p] = v: v (1 + i) / 2
 *
 * Both shares of a pair become one entry if the places are in order, as in rank 1; else two entries
 * at one place are equally right and cost a little more. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/multiply/sparse.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/whole.h"

#define SQRT_HALF 0.70710678118654752440

typedef struct collector {
    const cvol_array *array;
    cvol_sparse_term *first, *second;
    size_t first_count, second_count, extent[3];
    double least, tail;
} collector;

static void collect(collector *c, size_t place, float value)
{
    if (fabs((double)value) < c->least || value == 0) {
        c->tail += (double)value * (double)value;
        return;
    }
    const size_t *dims = c->array->grid.dims;
    size_t at[3] = {place % dims[0], place / dims[0] % dims[1], place / dims[0] / dims[1]};
    const int order = cvol_place_order(at, dims), dft = c->array->transform == CVOL_DFT;
    cvol_sparse_term term = {.alone = !order, .re = value};
    if (order) {
        const float share = dft ? value * (float)SQRT_HALF : value / 2;
        term.re = dft && order < 0 ? 0 : share;
        term.im = order < 0 ? share : dft ? 0 : -share;
    }
    for (int a = 0; a < 3; a++) {
        const size_t frequency = cvol_frequency(at[a], dims[a]);
        c->extent[a] = frequency > c->extent[a] ? frequency : c->extent[a];
        term.at[a] = (uint32_t)(order < 0 ? cvol_mirror_index(at[a], dims[a]) : at[a]);
    }
    if (order < 0)
        c->second[c->second_count++] = term;
    else
        c->first[c->first_count++] = term;
}

static size_t index_of(const cvol_sparse_term *term, const size_t dims[3])
{
    return term->at[0] + dims[0] * (term->at[1] + dims[1] * (size_t)term->at[2]);
}

/* Second places rise, so their mirrors fall (in rank 1): merges from the end of the list. */
static size_t merge(cvol_sparse_term *out, const collector *c)
{
    const size_t *dims = c->array->grid.dims;
    size_t count = 0, i = 0, j = c->second_count;
    while (i < c->first_count || j > 0) {
        const size_t one = i < c->first_count ? index_of(&c->first[i], dims) : SIZE_MAX;
        const size_t two = j > 0 ? index_of(&c->second[j - 1], dims) : SIZE_MAX;
        out[count] = one <= two ? c->first[i] : c->second[j - 1];
        if (one == two) {
            out[count].re += c->second[j - 1].re;
            out[count].im += c->second[j - 1].im;
        }
        i += one <= two;
        j -= two <= one;
        count++;
    }
    return count;
}

int cvol_sparse_terms_make(cvol_context *context, cvol_sparse_terms *out, double *tail,
                           const cvol_array *array, double least)
{
    const cvol_spectrum *whole = &array->whole;
    const size_t *dims = array->grid.dims, most = whole->low_count + whole->sparse_count;
    collector c = {.array = array, .least = least};
    memset(out, 0, sizeof *out);
    c.first = cvol_allocate(most, sizeof *c.first);
    c.second = cvol_allocate(most, sizeof *c.second);
    out->terms = cvol_allocate(most, sizeof *out->terms);
    if (!c.first || !c.second || !out->terms) {
        cvol_sparse_terms_free(out);
        free(c.first);
        free(c.second);
        return cvol_fail_memory(context, 3 * most * sizeof *c.first, "terms to multiply");
    }
    /* Box and sparse places, merged in rising order (rank 1: the box lies at both ends). */
    size_t s = 0;
    for (size_t i = 0; i < whole->low_count; i++) {
        const size_t u = cvol_box_place(i % whole->box[0], whole->low[0], whole->box[0], dims[0]);
        const size_t v = cvol_box_place(i / whole->box[0] % whole->box[1], whole->low[1],
                                        whole->box[1], dims[1]);
        const size_t w = cvol_box_place(i / whole->box[0] / whole->box[1], whole->low[2],
                                        whole->box[2], dims[2]);
        const size_t place = u + dims[0] * (v + dims[1] * w);
        for (; s < whole->sparse_count && whole->places[s] < place; s++)
            collect(&c, whole->places[s], whole->values[s]);
        collect(&c, place, whole->low_values[i]);
    }
    for (; s < whole->sparse_count; s++)
        collect(&c, whole->places[s], whole->values[s]);
    out->count = merge(out->terms, &c);
    memcpy(out->extent, c.extent, sizeof out->extent);
    *tail = sqrt(c.tail);
    free(c.first);
    free(c.second);
    return CVOL_OK;
}

void cvol_sparse_terms_dilate(cvol_sparse_terms *terms, size_t n, size_t multiplier)
{
    terms->extent[0] = 0;
    for (size_t i = 0; i < terms->count; i++) {
        const size_t at = terms->terms[i].at[0] * multiplier % n, u = cvol_frequency(at, n);
        terms->terms[i].at[0] = (uint32_t)at;
        terms->extent[0] = u > terms->extent[0] ? u : terms->extent[0];
    }
}

void cvol_sparse_terms_move(cvol_sparse_terms *terms, const cvol_sparse_shape *shape)
{
    const size_t *dims = shape->dims, *length = shape->length;
    for (size_t i = 0; i < terms->count; i++) {
        cvol_sparse_term *term = &terms->terms[i];
        int between =
            0; /* on a Nyquist frequency that the working group separates from its mirror */
        for (int a = 0; a < 3; a++) {
            if (length[a] == dims[a])
                continue;
            between |= 2 * (size_t)term->at[a] == dims[a];
            if (2 * (size_t)term->at[a] > dims[a])
                term->at[a] = (uint32_t)(length[a] - (dims[a] - term->at[a]));
        }
        if (term->alone && between) { /* cos(pi x) is half of each of the two */
            term->alone = 0;
            term->re /= 2;
        }
    }
}

void cvol_sparse_terms_free(cvol_sparse_terms *terms)
{
    free(terms->terms);
    memset(terms, 0, sizeof *terms);
}
