/* Folds a spectrum onto another grid (fold.h), axis by axis.
 *
 * DCT: at the points of m samples, cos(pi u (i + 1/2) / m) equals that of some u' < m with a sign:
 * u has the period 4 m, 2 m - u gives the negative, and u = m vanishes.
 * DFT, DHT: exp(2 pi i u i / m) has the period m. A signed frequency u lands on u mod m. The
 * frequency u = n / 2, whose function is cos(pi x), lands on n / 2 and -n / 2 with a half each.
 * Under the DFT a slot is a cosine or a sine and stays one; a sine vanishes on a place that is its
 * own mirror. */
#include "array/evaluate/fold.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/whole.h"

#define SQRT_2 1.41421356237309504880

/* The target of a frequency of one axis: a box index and that of its mirror (SIZE_MAX: not
 * stored). */
typedef struct fold_target {
    size_t index, mirror;
    float weight; /* 0: nowhere */
    int order;    /* of the target place, as cvol_place_order on this axis alone */
} fold_target;

typedef struct fold_axis {
    size_t from, to, low, box, stride; /* stride: of the stored box */
    size_t from_low, from_box;
    fold_target *table; /* two for each box index of the spectrum; NULL if it has no box */
} fold_axis;

static fold_target fold_place(const fold_axis *axis, size_t place, float weight)
{
    const size_t mirror = cvol_mirror_index(place, axis->to), n = axis->to;
    fold_target out = {.index = cvol_box_index(place, axis->low, axis->box, n),
                       .mirror = cvol_box_index(mirror, axis->low, axis->box, n),
                       .weight = weight,
                       .order = place == mirror ? 0
                                : 2 * place < n ? 1
                                                : -1};
    if (out.index != SIZE_MAX)
        out.index *= axis->stride;
    if (out.mirror != SIZE_MAX)
        out.mirror *= axis->stride;
    return out;
}

/* Finds both landings of a place; the second has weight 0 except for u = n / 2. */
static void find_fold_targets(fold_target out[2], const fold_axis *axis, cvol_transform transform,
                              size_t u)
{
    const size_t n = axis->from, m = axis->to;
    const double scale = sqrt((double)m / (double)n);
    out[1] = fold_place(axis, 0, 0);
    if (transform == CVOL_DCT) {
        size_t r = u % (4 * m);
        float sign = r > m && r < 3 * m ? -1 : 1;
        r = r > 2 * m ? 4 * m - r : r;
        r = r > m ? 2 * m - r : r;
        if (r == m) {
            out[0] = out[1];
            return;
        }
        /* c(u) of the one over c(r) of the other */
        const double c = (u ? SQRT_2 : 1) / (r ? SQRT_2 : 1);
        out[0] = fold_place(axis, r, sign * (float)(c * scale));
        return;
    }
    const size_t size = cvol_frequency(u, n) % m;
    const size_t plus = size, minus = cvol_mirror_index(size, m);
    if (2 * u == n) {
        out[0] = fold_place(axis, plus, (float)(scale / 2));
        out[1] = fold_place(axis, minus, (float)(scale / 2));
    } else {
        out[0] = fold_place(axis, 2 * u < n ? plus : minus, (float)scale);
    }
}

static int prepare_axis(cvol_context *context, fold_axis *axis, cvol_transform transform)
{
    if (!axis->from_box)
        return CVOL_OK;
    axis->table = cvol_allocate(2 * axis->from_box, sizeof *axis->table);
    if (!axis->table)
        return cvol_fail_memory(context, 2 * axis->from_box * sizeof *axis->table, "folding");
    for (size_t i = 0; i < axis->from_box; i++)
        find_fold_targets(axis->table + 2 * i, axis, transform,
                          cvol_box_place(i, axis->from_low, axis->from_box, axis->from));
    return CVOL_OK;
}

/* Adds the amplitude of a term's function, a cosine or a sine (DFT), in units of (1/N)^1/2. */
static void add_wave(float *slots, float value, int order, const fold_target *at[3])
{
    int folded = 0;
    for (int a = 0; a < 3 && !folded; a++)
        folded = at[a]->order;
    /* order, folded: +1 is a cosine, -1 a sine; a sine changes sign with its place */
    int to_mirror = 0;
    double factor = 1;
    if (order >= 0) { /* a cosine */
        factor = (order ? SQRT_2 : 1) / (folded ? SQRT_2 : 1);
        to_mirror = folded < 0;
    } else if (folded == 0) {
        return;
    } else if (folded > 0) {
        factor = -1;
        to_mirror = 1;
    }
    size_t index = 0;
    for (int a = 0; a < 3; a++) {
        const size_t part = to_mirror ? at[a]->mirror : at[a]->index;
        if (part == SIZE_MAX)
            return;
        index += part;
    }
    slots[index] += (float)(factor * (double)value);
}

/* Adds a term to all of its targets: up to two places per axis. */
static void add_term(float *slots, float value, cvol_transform transform, int order,
                     const fold_target *const axis[3])
{
    for (int k = 0; k < 8; k++) {
        const fold_target *at[3] = {axis[0] + (k & 1), axis[1] + (k >> 1 & 1), axis[2] + (k >> 2)};
        const float weighted = value * at[0]->weight * at[1]->weight * at[2]->weight;
        if (weighted == 0)
            continue;
        if (transform == CVOL_DFT)
            add_wave(slots, weighted, order, at);
        else if (at[0]->index != SIZE_MAX && at[1]->index != SIZE_MAX && at[2]->index != SIZE_MAX)
            slots[at[0]->index + at[1]->index + at[2]->index] += weighted;
    }
}

static void fold_box(float *slots, const cvol_spectrum *spectrum, cvol_transform transform,
                     const size_t from[3], const fold_axis axes[3])
{
    const size_t *low = spectrum->low, *box = spectrum->box;
    const float *values = spectrum->low_values;
    for (size_t k = 0; k < box[2]; k++)
        for (size_t j = 0; j < box[1]; j++)
            for (size_t i = 0; i < box[0]; i++, values++) {
                if (*values == 0)
                    continue;
                const size_t place[3] = {cvol_box_place(i, low[0], box[0], from[0]),
                                         cvol_box_place(j, low[1], box[1], from[1]),
                                         cvol_box_place(k, low[2], box[2], from[2])};
                const fold_target *at[3] = {axes[0].table + 2 * i, axes[1].table + 2 * j,
                                            axes[2].table + 2 * k};
                const int order = transform == CVOL_DFT ? cvol_place_order(place, from) : 0;
                add_term(slots, *values, transform, order, at);
            }
}

static void fold_sparse(float *slots, const cvol_spectrum *spectrum, cvol_transform transform,
                        const size_t from[3], const fold_axis axes[3])
{
    for (size_t i = 0; i < spectrum->sparse_count; i++) {
        fold_target table[3][2];
        const size_t index = spectrum->places[i];
        const size_t place[3] = {index % from[0], index / from[0] % from[1],
                                 index / from[0] / from[1]};
        for (int a = 0; a < 3; a++)
            find_fold_targets(table[a], &axes[a], transform, place[a]);
        const fold_target *at[3] = {table[0], table[1], table[2]};
        const int order = transform == CVOL_DFT ? cvol_place_order(place, from) : 0;
        add_term(slots, spectrum->values[i], transform, order, at);
    }
}

int cvol_fold_into_box(cvol_context *context, float *slots, const size_t low[3],
                       const size_t box[3], const size_t to[3], const cvol_spectrum *spectrum,
                       cvol_transform transform, const size_t from[3])
{
    fold_axis axes[3];
    size_t stride = 1;
    int code = CVOL_OK;
    memset(axes, 0, sizeof axes);
    for (int a = 0; a < 3; a++) {
        axes[a].from = from[a];
        axes[a].to = to[a];
        axes[a].low = low[a];
        axes[a].box = box[a];
        axes[a].from_low = spectrum->low[a];
        axes[a].from_box = spectrum->box[a];
        axes[a].stride = stride;
        stride *= box[a];
        if (!code)
            code = prepare_axis(context, &axes[a], transform);
    }
    if (!code) {
        fold_box(slots, spectrum, transform, from, axes);
        fold_sparse(slots, spectrum, transform, from, axes);
    }
    for (int a = 0; a < 3; a++)
        free(axes[a].table);
    return code;
}

int cvol_fold(cvol_context *context, float *slots, const size_t to[3],
              const cvol_spectrum *spectrum, cvol_transform transform, const size_t from[3])
{
    return cvol_fold_into_box(context, slots, to, to, to, spectrum, transform, from);
}
