/* Builds a spectrum term by term: look-up, supports, filling. */
#include "array/truncate/spectrum_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/complex.h"
#include "base/context.h"
#include "base/memory.h"

static const double SQRT_2 = 1.41421356237309504880, SQRT_HALF = 0.70710678118654752440;

/* ---- looking up ------------------------------------------------------------------------------ */

/* The index in low_values, or SIZE_MAX. */
static size_t find_low(const cvol_spectrum *spectrum, const size_t dims[3], const size_t place[3])
{
    size_t index[3];
    if (!spectrum->low_count)
        return SIZE_MAX;
    for (int a = 0; a < 3; a++) {
        index[a] = cvol_box_index(place[a], spectrum->low[a], spectrum->box[a], dims[a]);
        if (index[a] == SIZE_MAX)
            return SIZE_MAX;
    }
    return cvol_place_join(index, spectrum->box);
}

/* The index in places, or SIZE_MAX. */
static size_t find_sparse(const cvol_spectrum *spectrum, size_t place)
{
    size_t begin = 0, end = spectrum->sparse_count;
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (spectrum->places[middle] == place)
            return middle;
        if (spectrum->places[middle] < place)
            begin = middle + 1;
        else
            end = middle;
    }
    return SIZE_MAX;
}

float cvol_spectrum_value(const cvol_spectrum *spectrum, const size_t dims[3],
                          const size_t place[3])
{
    size_t at = find_low(spectrum, dims, place);
    if (at != SIZE_MAX)
        return spectrum->low_values[at];
    at = find_sparse(spectrum, cvol_place_join(place, dims));
    return at == SIZE_MAX ? 0 : spectrum->values[at];
}

int cvol_spectrum_holds(const cvol_spectrum *spectrum, const size_t dims[3], const size_t place[3])
{
    return find_low(spectrum, dims, place) != SIZE_MAX ||
           find_sparse(spectrum, cvol_place_join(place, dims)) != SIZE_MAX;
}

double complex cvol_spectrum_coefficient(const cvol_spectrum *spectrum, cvol_transform transform,
                                         const size_t dims[3], const size_t place[3])
{
    const double here = (double)cvol_spectrum_value(spectrum, dims, place);
    const int order = cvol_place_order(place, dims);
    if (!order)
        return here;
    size_t mirror[3];
    for (int a = 0; a < 3; a++)
        mirror[a] = cvol_mirror_index(place[a], dims[a]);
    const double there = (double)cvol_spectrum_value(spectrum, dims, mirror);
    if (transform == CVOL_DHT)
        return cvol_complex((here + there) / 2, (there - here) / 2);
    return order > 0 ? cvol_complex(here * SQRT_HALF, there * SQRT_HALF)
                     : cvol_complex(there * SQRT_HALF, -here * SQRT_HALF);
}

double cvol_slot_of(cvol_transform transform, const size_t dims[3], const size_t place[3],
                    double complex F)
{
    const int order = cvol_place_order(place, dims);
    if (!order)
        return creal(F);
    if (transform == CVOL_DHT)
        return creal(F) - cimag(F);
    return order > 0 ? SQRT_2 * creal(F) : -SQRT_2 * cimag(F);
}

/* ---- rows of the low box --------------------------------------------------------------------- */

/* cvol_place_order of box index i of a row. */
static int row_order(const cvol_spectrum *s, const size_t dims[3], size_t i, size_t v, size_t w)
{
    const size_t place[3] = {cvol_box_place(i, s->low[0], s->box[0], dims[0]),
                             cvol_box_place(v, s->low[1], s->box[1], dims[1]),
                             cvol_box_place(w, s->low[2], s->box[2], dims[2])};
    return cvol_place_order(place, dims);
}

/* Converts a pair of slots to the coefficient (DFT). */
static void pair_to_coefficient(double *re, double *im, double here, double there, int order)
{
    *re = order == 0 ? here : (order > 0 ? here : there) * SQRT_HALF;
    *im = order == 0 ? 0 : (order > 0 ? there : -here) * SQRT_HALF;
}

void cvol_spectrum_row(double *re, double *im, const cvol_spectrum *spectrum,
                       cvol_transform transform, const size_t dims[3], size_t v, size_t w)
{
    /* A low box contains the mirror images of all its places: box index i mirrors box[0] - i. */
    const size_t count = spectrum->box[0], middle = (count + 1) / 2;
    const size_t mirror_v = v ? spectrum->box[1] - v : 0, mirror_w = w ? spectrum->box[2] - w : 0;
    const float *here = spectrum->low_values + count * (v + spectrum->box[1] * w);
    const float *there = spectrum->low_values + count * (mirror_v + spectrum->box[1] * mirror_w);
    if (transform == CVOL_DHT) {
        for (size_t i = 0; i < count; i++) {
            const double h = (double)here[i], t = (double)there[i ? count - i : 0];
            re[i] = (h + t) / 2;
            im[i] = (t - h) / 2;
        }
        return;
    }
    for (size_t i = 1; i < middle; i++)
        pair_to_coefficient(&re[i], &im[i], (double)here[i], (double)there[count - i], 1);
    for (size_t i = middle; i < count; i++)
        pair_to_coefficient(&re[i], &im[i], (double)here[i], (double)there[count - i], -1);
    pair_to_coefficient(&re[0], &im[0], (double)here[0], (double)there[0],
                        row_order(spectrum, dims, 0, v, w));
    const size_t half = count / 2; /* the frequency n / 2, if the box is the whole axis */
    if (half && 2 * half == count)
        pair_to_coefficient(&re[half], &im[half], (double)here[half], (double)there[half],
                            row_order(spectrum, dims, half, v, w));
}

static float coefficient_to_slot(double re, double im, int order)
{
    return (float)(order == 0 ? re : order > 0 ? SQRT_2 * re : -SQRT_2 * im);
}

void cvol_spectrum_set_row(cvol_spectrum *spectrum, cvol_transform transform, const size_t dims[3],
                           size_t v, size_t w, const double *re, const double *im)
{
    const size_t count = spectrum->box[0], middle = (count + 1) / 2, half = count / 2;
    float *slots = spectrum->low_values + count * (v + spectrum->box[1] * w);
    if (transform == CVOL_DHT) {
        for (size_t i = 0; i < count; i++)
            slots[i] = (float)(re[i] - im[i]);
        return;
    }
    for (size_t i = 1; i < middle; i++)
        slots[i] = coefficient_to_slot(re[i], im[i], 1);
    for (size_t i = middle; i < count; i++)
        slots[i] = coefficient_to_slot(re[i], im[i], -1);
    slots[0] = coefficient_to_slot(re[0], im[0], row_order(spectrum, dims, 0, v, w));
    if (half && 2 * half == count)
        slots[half] = coefficient_to_slot(re[half], im[half],
                                          row_order(spectrum, dims, half, v, w));
}

/* ---- supports -------------------------------------------------------------------------------- */

static int compare_places(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

int cvol_spectrum_start_places(cvol_context *context, cvol_spectrum *out, cvol_transform transform,
                               const size_t dims[3], const size_t low[3], uint32_t *places,
                               size_t count)
{
    int code = cvol_spectrum_start(context, out, transform, dims, low);
    if (code || !count)
        return code;
    qsort(places, count, sizeof *places, compare_places);
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        size_t place[3];
        cvol_place_split(place, places[i], dims);
        if ((!kept || places[kept - 1] != places[i]) && find_low(out, dims, place) == SIZE_MAX)
            places[kept++] = places[i];
    }
    if (kept)
        code = cvol_spectrum_reserve(context, out, kept);
    if (code) {
        cvol_spectrum_free(out);
        return code;
    }
    if (kept) {
        memcpy(out->places, places, kept * sizeof *places);
        memset(out->values, 0, kept * sizeof *out->values);
    }
    out->sparse_count = kept;
    return CVOL_OK;
}

int cvol_spectrum_start_like(cvol_context *context, cvol_spectrum *out, cvol_transform transform,
                             const size_t dims[3], const cvol_spectrum *like, int pairs)
{
    memset(out, 0, sizeof *out);
    const size_t copies = pairs ? 2 : 1, count = like->sparse_count;
    uint32_t *places = cvol_allocate(count, copies * sizeof *places);
    if (!places)
        return cvol_fail_memory(context, count * copies * sizeof *places, "places");
    for (size_t i = 0; i < count; i++) {
        size_t place[3];
        cvol_place_split(place, like->places[i], dims);
        places[i] = like->places[i];
        if (pairs)
            places[count + i] = (uint32_t)cvol_place_mirror(place, dims);
    }
    int code = cvol_spectrum_start_places(context, out, transform, dims, like->low, places,
                                          copies * count);
    free(places);
    return code;
}

/* ---- filling --------------------------------------------------------------------------------- */

void cvol_spectrum_fill(cvol_context *context, cvol_spectrum *spectrum, const size_t dims[3],
                        double (*term)(const void *user, const size_t place[3]), const void *user)
{
    const size_t *low = spectrum->low, *box = spectrum->box;
    const ptrdiff_t rows = spectrum->low_count ? (ptrdiff_t)(box[1] * box[2]) : 0;
    const ptrdiff_t columns = (ptrdiff_t)box[0];
#pragma omp parallel for schedule(static) collapse(2) num_threads(cvol_context_threads(context))
    for (ptrdiff_t row = 0; row < rows; row++)
        for (ptrdiff_t i = 0; i < columns; i++) {
            const size_t v = (size_t)row % box[1], w = (size_t)row / box[1];
            const size_t place[3] = {cvol_box_place((size_t)i, low[0], box[0], dims[0]),
                                     cvol_box_place(v, low[1], box[1], dims[1]),
                                     cvol_box_place(w, low[2], box[2], dims[2])};
            spectrum->low_values[row * columns + i] = (float)term(user, place);
        }
    cvol_spectrum_fill_sparse(context, spectrum, dims, term, user);
}

void cvol_spectrum_fill_sparse(cvol_context *context, cvol_spectrum *spectrum, const size_t dims[3],
                               double (*term)(const void *user, const size_t place[3]),
                               const void *user)
{
    const ptrdiff_t others = (ptrdiff_t)spectrum->sparse_count;
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (ptrdiff_t i = 0; i < others; i++) {
        size_t place[3];
        cvol_place_split(place, spectrum->places[i], dims);
        spectrum->values[i] = (float)term(user, place);
    }
    size_t kept = 0;
    for (size_t i = 0; i < spectrum->sparse_count; i++)
        if (spectrum->values[i] != 0) {
            spectrum->places[kept] = spectrum->places[i];
            spectrum->values[kept++] = spectrum->values[i];
        }
    spectrum->sparse_count = kept;
}

int cvol_spectrum_move(cvol_context *context, cvol_array *out, cvol_build_result *result,
                       cvol_spectrum *spectrum, const cvol_keep *keep)
{
    result->dropped = 0;
    result->norm = sqrt(cvol_spectrum_energy(spectrum));
    result->max_abs = -1;
    if (keep->rule == CVOL_KEEP_LIKE_INPUTS || keep->rule == CVOL_KEEP_ALL) {
        out->whole = *spectrum;
        memset(spectrum, 0, sizeof *spectrum);
        return CVOL_OK;
    }
    cvol_candidates candidates = {.slots = spectrum->low_values,
                                  .places = spectrum->places,
                                  .values = spectrum->values,
                                  .count = spectrum->sparse_count};
    memcpy(candidates.low, spectrum->low, sizeof candidates.low);
    memcpy(candidates.box, spectrum->box, sizeof candidates.box);
    return cvol_truncate(context, out, &result->dropped, &candidates, keep);
}
