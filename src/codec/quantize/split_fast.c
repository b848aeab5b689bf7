/* The fast choice for a cell. */
#include "codec/quantize/split_fast.h"
#include "array/block/cell_weight.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "base/cpu.h"
#include "base/memory.h"
#include "codec/quantize/quantize.h"
#include "codec/quantize/split_extension.h"
#include "codec/quantize/split_kernels.h"

CVOL_SIMD_DECLARE(void, cvol_cell_quantise,
                  (cvol_cell_quantised *, const float *, const cvol_cell_rounding *));

/* A split is chosen if its weight is below this share of the weight of the coarser split. */
#define CELL_SHARE 0.87f
#define OCTANT_SHARE 0.9f

/* Dead zones. A magnitude above 0 rounds up from fraction 1 - UP on. It becomes 1 from LOW on, or
 * from LOW + ALONE if its neighbours of lower frequency, which set its context, are 0. */
#define UP 0.48f
#define LOW 0.52f
#define ALONE 0.4f

enum { WHOLE, EIGHTS, FOURS, WAYS };

struct cvol_split_fast {
    uint16_t order[WAYS][CVOL_CELL_SAMPLES]; /* by place: scan position among 8 octants of 8
                                                sub-blocks */
    float coefficients[WAYS][CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float mixed[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    cvol_cell_edge edge;
    cvol_cell_quantised quantised;
    int32_t values[CVOL_CELL_SAMPLES]; /* in scan order, sub-block after sub-block */
};

/* ---- tables ----------------------------------------------------------------------------- */

static void fill_place(cvol_split_fast *fast, int which, int u, int v, int w)
{
    const int x[3] = {u, v, w}, side = CVOL_CELL >> which;
    int octant = 0, quarter = 0, in_part = 0;
    for (int a = 2; a >= 0; a--) {
        const int f = x[a] >> which;
        octant |= which > 0 ? (x[a] & 1) << a : 0;
        quarter |= which > 1 ? (x[a] >> 1 & 1) << a : 0;
        in_part = side * in_part + f;
    }
    const cvol_scan *scan = cvol_sub_block_scan_of(CVOL_SUB_BLOCK_SIZES - 2 - which);
    const int place = u + CVOL_CELL * (v + CVOL_CELL * w);
    fast->order[which][place] = (uint16_t)(512 * octant + 64 * quarter +
                                           scan->index_of_place[in_part]);
}

static void fill_tables(cvol_split_fast *fast)
{
    for (int which = 0; which < WAYS; which++)
        for (int w = 0; w < CVOL_CELL; w++)
            for (int v = 0; v < CVOL_CELL; v++)
                for (int u = 0; u < CVOL_CELL; u++)
                    fill_place(fast, which, u, v, w);
}

cvol_split_fast *cvol_split_fast_create(void)
{
    cvol_split_fast *fast = cvol_allocate_zero(1, sizeof *fast);
    if (fast)
        fill_tables(fast);
    return fast;
}

void cvol_split_fast_free(cvol_split_fast *fast)
{
    free(fast);
}

/* ---- the split -------------------------------------------------------------------------- */

static void transform(cvol_split_fast *fast, int which, const float *samples, const int inside[3],
                      float inverse)
{
    static const int origin[3] = {0, 0, 0};
    static const uint16_t splits[WAYS] = {CVOL_CELL_WHOLE, CVOL_CELL_OCTANTS, CVOL_CELL_FOURS};
    if (cvol_cell_reaches_beyond(inside, origin, CVOL_CELL))
        cvol_cell_forward_edge(fast->coefficients[which], &fast->edge, samples, inside,
                               splits[which], 1 / inverse);
    else
        cvol_cell_forward(fast->coefficients[which], samples, splits[which]);
}

/* Computes the necessary transforms, and returns the cell's split. */
static uint16_t choose_split(cvol_split_fast *fast, const float *samples, const int inside[3],
                             float inverse)
{
    float whole[8], eights[8], fours[8];
    float coarser = CVOL_SUB_BLOCK_COST, finer = CVOL_CELL_COST;
    uint16_t split = CVOL_CELL_OCTANTS;
    transform(fast, WHOLE, samples, inside, inverse);
    cvol_cell_weigh(whole, fast->coefficients[WHOLE], inverse, 1);
    for (int i = 0; i < 8; i++)
        coarser += whole[i];
    if (coarser < CVOL_SUB_BLOCK_COST + CVOL_LAMBDA * CVOL_SPLIT_BITS_MIN)
        return CVOL_CELL_WHOLE;
    transform(fast, EIGHTS, samples, inside, inverse);
    transform(fast, FOURS, samples, inside, inverse);
    cvol_cell_weigh(eights, fast->coefficients[EIGHTS], inverse, 2);
    cvol_cell_weigh(fours, fast->coefficients[FOURS], inverse, 4);
    for (int i = 0; i < 8; i++) {
        finer += fours[i] < eights[i] ? fours[i] : eights[i];
        if (fours[i] + CVOL_OCTANT_COST <= OCTANT_SHARE * (eights[i] + CVOL_SUB_BLOCK_COST))
            split |= (uint16_t)(2u << i);
    }
    return finer <= CELL_SHARE * coarser ? split : CVOL_CELL_WHOLE;
}

/* Takes split octants from the fours, others from the eights. */
static void mix(float *out, const float *eights, const float *fours, uint16_t split)
{
    for (int w = 0; w < CVOL_CELL; w++)
        for (int v = 0; v < CVOL_CELL; v++) {
            const int octants = split >> (1 + 2 * (v & 1) + 4 * (w & 1)) & 3;
            const int row = CVOL_CELL * (v + CVOL_CELL * w);
            const float *even = octants & 1 ? fours : eights, *odd = octants & 2 ? fours : eights;
            for (int u = row; u < row + CVOL_CELL; u += 2) {
                out[u] = even[u];
                out[u + 1] = odd[u + 1];
            }
        }
}

/* ---- the values ------------------------------------------------------------------------- */

static void quantise(cvol_split_fast *fast, uint16_t split, float inverse, int plain)
{
    const int which = split == CVOL_CELL_WHOLE ? WHOLE : split == CVOL_CELL_FOURS ? FOURS : EIGHTS;
    const cvol_cell_rounding how = {inverse, plain ? 0.5f : UP, plain ? 0.5f : LOW,
                                    plain ? 0 : ALONE, 1 << which};
    const float *coefficients = fast->coefficients[which];
    if (split > CVOL_CELL_OCTANTS && split < CVOL_CELL_FOURS) {
        mix(fast->mixed, fast->coefficients[EIGHTS], fast->coefficients[FOURS], split);
        coefficients = fast->mixed;
    }
    CVOL_SIMD_CHOOSE(cvol_cell_quantise)(&fast->quantised, coefficients, &how);
}

/* Lists the sub-blocks and the places of their values. */
static void list_parts(cvol_split_fast *fast, cvol_cell_choice *out)
{
    if (out->split == CVOL_CELL_WHOLE) {
        out->values[out->parts++] = fast->values;
        return;
    }
    for (int octant = 0; octant < 8; octant++) {
        const int count = out->split >> (1 + octant) & 1 ? 8 : 1;
        for (int i = 0; i < count; i++)
            out->values[out->parts++] = fast->values + 512 * octant + 64 * i;
    }
}

/* Copies the values into scan order; used: the number of values of each unit of 64. */
static void put_in_order(cvol_split_fast *fast, int used[64], uint16_t split)
{
    const cvol_cell_quantised *from = &fast->quantised;
    memset(fast->values, 0, sizeof fast->values);
    memset(used, 0, 64 * sizeof *used);
    for (int i = 0; i < 64; i++)
        for (uint64_t bits = from->found[i]; bits; bits &= bits - 1) {
            const int place = 64 * i + __builtin_ctzll(bits);
            const int octant = (place & 1) | (place >> 3 & 2) | (place >> 6 & 4);
            const int which = split == CVOL_CELL_WHOLE    ? WHOLE
                              : split >> (1 + octant) & 1 ? FOURS
                                                          : EIGHTS;
            const int at = fast->order[which][place];
            const int part = which == WHOLE ? 0 : which == EIGHTS ? 8 * octant : at / 64;
            const int index = at - 64 * part;
            fast->values[at] = from->values[place];
            used[part] = index >= used[part] ? index + 1 : used[part];
        }
}

/* Infinity must fail. */
static int fits(const cvol_cell_quantised *quantised)
{
    return quantised->most < (float)(CVOL_VALUE_LIMIT - 256);
}

void cvol_split_fast_choose(cvol_split_fast *fast, cvol_cell_choice *out, const float *samples,
                            const int inside[3], double step, int plain)
{
    const float inverse = (float)(1 / step);
    int used[64];
    *out = (cvol_cell_choice){.split = choose_split(fast, samples, inside, inverse)};
    quantise(fast, out->split, inverse, plain);
    out->error = (float)fast->quantised.error;
    list_parts(fast, out);
    put_in_order(fast, used, out->split);
    for (int p = 0; p < out->parts; p++) {
        const int part = (int)(out->values[p] - fast->values) / 64;
        out->used[p] = !fits(&fast->quantised) ? 0 : used[part] > 1 ? used[part] : 1;
    }
}

double cvol_split_fast_error(cvol_split_fast *fast, const float *samples, const int inside[3],
                             double step, int plain)
{
    const float inverse = (float)(1 / step);
    quantise(fast, choose_split(fast, samples, inside, inverse), inverse, plain);
    return fits(&fast->quantised) ? fast->quantised.error : (double)INFINITY;
}

uint32_t cvol_split_fast_terms(const cvol_split_fast *fast, uint32_t *words, size_t *terms)
{
    const cvol_cell_quantised *from = &fast->quantised;
    uint32_t *to = words;
    for (int i = 0; i < 64; i++)
        for (uint64_t bits = from->found[i]; bits; bits &= bits - 1) {
            const uint32_t place = (uint32_t)(64 * i + __builtin_ctzll(bits));
            to += cvol_term_pack(to, place, from->values[place], cvol_place_bits(4));
            (*terms)++;
        }
    return (uint32_t)(to - words);
}
