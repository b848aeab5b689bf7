/* Slots to signed exponentials and back.
 *
 *     DFT, DHT   a = N^-1/2 sum_p F[p] e_p over all p; with only one p of each pair in one factor,
 *                P[r] = N^-1/2 (sums[r] + conj sums[-r])
 *     DCT        a = sum A c(u) cos_u; cos_u times (cos_v, half at v and half at -v) is one half at
 *                u + v and one half at u - v, which is cos_u cos_v; signs are then dropped
 */
#include "array/multiply/terms.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/whole.h"

cvol_hull cvol_hull_of(const cvol_array *a, const cvol_array *b)
{
    size_t x[3], y[3];
    cvol_spectrum_extent(x, &a->whole, a->transform, a->grid.dims);
    cvol_spectrum_extent(y, &b->whole, b->transform, b->grid.dims);
    cvol_hull hull = {.count = 1};
    for (int i = 0; i < 3; i++) {
        hull.extent[i] = (int64_t)(x[i] + y[i]);
        hull.width[i] = 2 * hull.extent[i] + 1;
        hull.count *= hull.width[i];
    }
    return hull;
}

/* ---- operands ------------------------------------------------------------------------------ */

typedef struct slot_term {
    uint32_t place;
    float value;
} slot_term;

/* Lists all terms that are not 0, places rising; room for low_count + sparse_count. */
static size_t list_slots(slot_term *out, const cvol_spectrum *whole, const size_t dims[3])
{
    const size_t *low = whole->low, *box = whole->box;
    size_t count = 0, s = 0;
    for (size_t i = 0; i < whole->low_count; i++) {
        if (whole->low_values[i] == 0)
            continue;
        const size_t at[3] = {i % box[0], i / box[0] % box[1], i / box[0] / box[1]};
        size_t place = 0;
        for (int a = 2; a >= 0; a--)
            place = place * dims[a] + cvol_box_place(at[a], low[a], box[a], dims[a]);
        for (; s < whole->sparse_count && whole->places[s] < place; s++)
            out[count++] = (slot_term){whole->places[s], whole->values[s]};
        out[count++] = (slot_term){(uint32_t)place, whole->low_values[i]};
    }
    for (; s < whole->sparse_count; s++)
        out[count++] = (slot_term){whole->places[s], whole->values[s]};
    return count;
}

static float find_slot(const slot_term *slots, size_t count, uint32_t place, int *found)
{
    size_t begin = 0, end = count;
    while (begin < end) {
        size_t middle = begin + (end - begin) / 2;
        if (slots[middle].place < place)
            begin = middle + 1;
        else
            end = middle;
    }
    *found = begin < count && slots[begin].place == place;
    return *found ? slots[begin].value : 0;
}

static void split_place(size_t at[3], size_t place, const size_t dims[3])
{
    at[0] = place % dims[0];
    at[1] = place / dims[0] % dims[1];
    at[2] = place / dims[0] / dims[1];
}

static uint32_t mirror_of(const size_t at[3], const size_t dims[3])
{
    return (uint32_t)(cvol_mirror_index(at[0], dims[0]) +
                      dims[0] * (cvol_mirror_index(at[1], dims[1]) +
                                 dims[1] * cvol_mirror_index(at[2], dims[2])));
}

/* The hull index of a place's signed frequency. */
static int64_t signed_index(const size_t at[3], const size_t dims[3], const cvol_hull *hull)
{
    int64_t index = 0;
    for (int a = 2; a >= 0; a--) {
        int64_t u = (int64_t)at[a];
        index = index * hull->width[a] + (2 * at[a] <= dims[a] ? u : u - (int64_t)dims[a]);
    }
    return index;
}

static void add_pairs(cvol_exponentials *out, const cvol_array *a, const cvol_hull *hull, int all,
                      const slot_term *slots, size_t count)
{
    const size_t *dims = a->grid.dims;
    const double half = sqrt(0.5);
    for (size_t i = 0; i < count; i++) {
        size_t at[3], other[3];
        split_place(at, slots[i].place, dims);
        const int order = cvol_place_order(at, dims);
        const double value = (double)slots[i].value;
        if (order == 0) {
            out->list[out->count++] = (cvol_exponential){.index = signed_index(at, dims, hull),
                                                         .re = all ? value : 0.5 * value};
            continue;
        }
        int found;
        const uint32_t mirror = mirror_of(at, dims);
        const double partner = (double)find_slot(slots, count, mirror, &found);
        if (order < 0 && found)
            continue; /* the first of the pair did it */
        split_place(other, mirror, dims);
        const size_t *first = order > 0 ? at : other, *second = order > 0 ? other : at;
        const double here = order > 0 ? value : partner, there = order > 0 ? partner : value;
        cvol_exponential f = {signed_index(first, dims, hull), half * here, half * there};
        if (a->transform == CVOL_DHT) {
            f.re = 0.5 * (here + there);
            f.im = 0.5 * (there - here);
        }
        out->list[out->count++] = f;
        if (all)
            out->list[out->count++] = (cvol_exponential){signed_index(second, dims, hull), f.re,
                                                         -f.im};
    }
}

static void add_cosines(cvol_exponentials *out, const cvol_array *a, const cvol_hull *hull, int all,
                        const slot_term *slots, size_t count)
{
    const size_t *dims = a->grid.dims;
    for (size_t i = 0; i < count; i++) {
        size_t at[3];
        split_place(at, slots[i].place, dims);
        double value = (double)slots[i].value;
        for (int b = 0; b < 3; b++)
            value *= sqrt((at[b] ? (all ? 0.5 : 2.0) : 1.0) / (double)dims[b]);
        for (int signs = 0; signs < 8; signs++) {
            int64_t index = 0;
            int wanted = 1;
            for (int b = 2; b >= 0; b--) {
                const int negative = signs >> b & 1;
                wanted &= !negative || (all && at[b]);
                index = index * hull->width[b] + (negative ? -(int64_t)at[b] : (int64_t)at[b]);
            }
            if (wanted)
                out->list[out->count++] = (cvol_exponential){.index = index, .re = value};
        }
    }
}

static int compare_index(const void *a, const void *b)
{
    const int64_t x = ((const cvol_exponential *)a)->index,
                  y = ((const cvol_exponential *)b)->index;
    return (x > y) - (x < y);
}

int cvol_exponentials_list(cvol_context *context, cvol_exponentials *out, const cvol_array *a,
                           const cvol_hull *hull, int all)
{
    const cvol_spectrum *whole = &a->whole;
    const size_t most = whole->low_count + whole->sparse_count;
    const size_t copies = a->transform == CVOL_DCT ? (all ? (size_t)1 << a->rank : 1) : 2;
    memset(out, 0, sizeof *out);
    slot_term *slots = cvol_allocate(most, sizeof *slots);
    out->list = cvol_allocate(copies * most, sizeof *out->list);
    if (!slots || !out->list) {
        free(slots);
        free(out->list);
        out->list = NULL;
        return cvol_fail_memory(context, copies * most * sizeof *out->list, "a list of terms");
    }
    const size_t count = list_slots(slots, whole, a->grid.dims);
    if (a->transform == CVOL_DCT)
        add_cosines(out, a, hull, all, slots, count);
    else
        add_pairs(out, a, hull, all, slots, count);
    free(slots);
    if (out->count > 1)
        qsort(out->list, out->count, sizeof *out->list, compare_index);
    return CVOL_OK;
}

/* ---- products -------------------------------------------------------------------------------- */

typedef struct place_value {
    uint32_t place;
    double value;
} place_value;

/* Sorts by place, stably; `spare` is equally large. (The order of equal places decides the rounding
 * of sums.) */
static void sort_places(place_value *list, place_value *spare, size_t count)
{
    size_t start[256];
    for (int shift = 0; shift < 32; shift += 8) { /* four passes: the result is in `list` again */
        memset(start, 0, sizeof start);
        for (size_t i = 0; i < count; i++)
            start[list[i].place >> shift & 255]++;
        size_t sum = 0;
        for (int d = 0; d < 256; d++) {
            size_t here = start[d];
            start[d] = sum;
            sum += here;
        }
        for (size_t i = 0; i < count; i++)
            spare[start[list[i].place >> shift & 255]++] = list[i];
        place_value *swap = list;
        list = spare;
        spare = swap;
    }
}

static size_t fold_pair(place_value *out, const cvol_exponential *sum, const int64_t frequency[3],
                        const size_t dims[3], cvol_transform transform, double scale)
{
    size_t at[3];
    for (int a = 0; a < 3; a++) {
        const int64_t n = (int64_t)dims[a], u = frequency[a] % n;
        at[a] = (size_t)(u < 0 ? u + n : u);
    }
    const uint32_t place = (uint32_t)(at[0] + dims[0] * (at[1] + dims[1] * at[2]));
    const uint32_t mirror = mirror_of(at, dims);
    const int order = cvol_place_order(at, dims);
    const double re = scale * sum->re, im = scale * sum->im;
    if (order == 0) {
        out[0] = (place_value){place, 2 * re};
        return 1;
    }
    if (transform == CVOL_DHT) { /* the same from either place of the pair */
        out[0] = (place_value){place, re - im};
        out[1] = (place_value){mirror, re + im};
    } else {
        out[0] = (place_value){order > 0 ? place : mirror, sqrt(2.0) * re};
        out[1] = (place_value){order > 0 ? mirror : place, sqrt(2.0) * (order > 0 ? im : -im)};
    }
    return 2;
}

static size_t fold_cosine(place_value *out, const cvol_exponential *sum, const int64_t frequency[3],
                          const size_t dims[3])
{
    double value = sum->re;
    size_t place = 0;
    for (int a = 2; a >= 0; a--) {
        const int64_t n = (int64_t)dims[a];
        int64_t u = frequency[a] < 0 ? -frequency[a] : frequency[a];
        if (u == n)
            return 0;
        if (u > n) {
            u = 2 * n - u;
            value = -value;
        }
        value /= sqrt((u ? 2.0 : 1.0) / (double)n);
        place = place * dims[a] + (size_t)u;
    }
    *out = (place_value){(uint32_t)place, value};
    return 1;
}

int cvol_listed_slots_fold(cvol_context *context, cvol_listed_slots *out, const cvol_array *like,
                           const cvol_hull *hull, const cvol_exponential *sums, size_t count)
{
    const size_t *dims = like->grid.dims, most = like->transform == CVOL_DCT ? count : 2 * count;
    const double scale = 1 / sqrt((double)cvol_grid_samples(&like->grid));
    memset(out, 0, sizeof *out);
    place_value *list = cvol_allocate(most, sizeof *list);
    place_value *spare = cvol_allocate(most, sizeof *spare);
    out->places = cvol_allocate(most, sizeof *out->places);
    out->values = cvol_allocate(most, sizeof *out->values);
    int code = CVOL_OK;
    if (!list || !spare || !out->places || !out->values) {
        code = cvol_fail_memory(context, 2 * most * sizeof *list, "the terms of a product");
        cvol_listed_slots_free(out);
        goto done;
    }
    size_t folded = 0;
    for (size_t i = 0; i < count; i++) {
        int64_t frequency[3], rest = sums[i].index;
        for (int a = 0; a < 3; a++) {
            frequency[a] = rest % hull->width[a] - hull->extent[a];
            rest /= hull->width[a];
        }
        folded += like->transform == CVOL_DCT
                      ? fold_cosine(list + folded, &sums[i], frequency, dims)
                      : fold_pair(list + folded, &sums[i], frequency, dims, like->transform, scale);
    }
    sort_places(list, spare, folded);
    for (size_t i = 0; i < folded;) {
        const uint32_t place = list[i].place;
        double value = 0;
        for (; i < folded && list[i].place == place; i++)
            value += list[i].value;
        if ((float)value == 0)
            continue;
        out->places[out->count] = place;
        out->values[out->count++] = (float)value;
        out->energy += value * value;
    }
done:
    free(list);
    free(spare);
    return code;
}

void cvol_listed_slots_free(cvol_listed_slots *slots)
{
    free(slots->places);
    free(slots->values);
    memset(slots, 0, sizeof *slots);
}
