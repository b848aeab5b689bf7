/* The choice of a cell's split. */
#include "codec/cell_choice.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "codec/brick_internal.h"

/* Splitting costs at least about this many bits. */
#define SPLIT_BITS_LEAST 12.0f

/* The least that a coefficient costs which is kept, and what a cell's or octant's finer parts cost
 * by being many. */
#define KEPT_COST 0.6f
#define CELL_COST 3.0f
#define OCTANT_COST 2.0f
#define PART_COST 0.7f

/* Which ways of splitting are tried: not the coarser one where the finer one's weight is below
 * `least` of its own, not the finer where it is above `most`. Measured on eleven volumes at eight
 * steps, BEST takes 0.4 % more bits by what it does not try, FAST 1.7 %. */
typedef struct split_margins {
    float cell_least, cell_most, octant_least, octant_most;
} split_margins;
static const split_margins best_margins = {0.75f, 0.93f, 0.8f, 0.97f};
static const split_margins fast_margins = {0.87f, 0.87f, 0.9f, 0.9f};

/* Three ways, whole, by eights and by fours, have room for all their parts' values. */
enum { WHOLE, EIGHTS, FOURS, WAYS };

struct cvol_cell_chooser {
    float coefficients[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float eights[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float fours[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float scaled[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    int32_t values[WAYS][CVOL_CELL_SAMPLES];
    uint16_t scatter[CVOL_SCATTER_MAX];
};

/* One cell's choice on its way. */
typedef struct choosing {
    cvol_cell_chooser *chooser;
    cvol_brick_context *brick;
    int at[3]; /* the cell's first sample, in fours of the brick */
    const cvol_token_costs *costs;
    float inverse; /* of the step */
    int plain;
    split_margins margins;
    float eights[8], fours[8]; /* weights of the octants */
} choosing;

cvol_cell_chooser *cvol_cell_chooser_create(void)
{
    cvol_cell_chooser *chooser = cvol_allocate(1, sizeof *chooser);
    if (chooser)
        memset(chooser->scatter, 0, sizeof chooser->scatter);
    return chooser;
}

void cvol_cell_chooser_free(cvol_cell_chooser *chooser)
{
    free(chooser);
}

/* About what a coefficient will add to error and lambda bits: its square if it is dropped, or some
 * bits and log2 of its square, as far as a float's bits say that: linear between powers of two. */
static inline float weight_of(float coefficient, float inverse)
{
    const float scaled = coefficient * inverse, square = scaled * scaled, power = 1 + square;
    int32_t bits;
    memcpy(&bits, &power, sizeof bits);
    const float coded = KEPT_COST + CVOL_LAMBDA * 0x1p-23f * (float)(bits - 0x3f800000);
    return square < coded ? square : coded;
}

/* About how many bits each octant's coefficients take, as far as ways of splitting differ by it:
 * the sum of the weights of all but its DCs, which are at places below `dcs` on every axis. An
 * octant's places are those of its parities. */
static void weigh(float weights[8], const float *coefficients, float inverse, int dcs)
{
    for (int parity = 0; parity < 4; parity++) {
        float lanes[CVOL_CELL] = {0};
        for (int w = parity >> 1; w < CVOL_CELL; w += 2)
            for (int v = parity & 1; v < CVOL_CELL; v += 2)
                for (int u = 0; u < CVOL_CELL; u++)
                    lanes[u] += weight_of(coefficients[u + CVOL_CELL * (v + CVOL_CELL * w)],
                                          inverse);
        weights[2 * parity] = weights[2 * parity + 1] = 0;
        for (int u = 0; u < CVOL_CELL; u++)
            weights[2 * parity + (u & 1)] += lanes[u];
    }
    for (int w = 0; w < dcs; w++)
        for (int v = 0; v < dcs; v++)
            for (int u = 0; u < dcs; u++)
                weights[(u & 1) + 2 * (v & 1) + 4 * (w & 1)] -= weight_of(
                    coefficients[u + CVOL_CELL * (v + CVOL_CELL * w)], inverse);
}

/* Chooses for one part. begin: its first sample within the cell, in fours. */
static cvol_part_choice choose_part(const choosing *c, int32_t *values, const float *coefficients,
                                    int size_class, const int begin[3], int first)
{
    const cvol_scan *scan = cvol_part_scan_of(size_class);
    const int at[3] = {c->at[0] + begin[0], c->at[1] + begin[1], c->at[2] + begin[2]};
    float *scaled = c->chooser->scaled;
    for (int i = 0; i < scan->count; i++)
        scaled[i] = coefficients[first + scan->entries[i].in_cell] * c->inverse;
    const cvol_part_context context = cvol_part_context_of(c->brick, at, size_class);
    return cvol_part_choose(values, scaled, size_class, c->costs, &context, c->plain,
                            c->chooser->scatter);
}

static void note_part(const choosing *c, const int32_t *values, int used, int size_class,
                      const int begin[3])
{
    const int at[3] = {c->at[0] + begin[0], c->at[1] + begin[1], c->at[2] + begin[2]};
    cvol_part_note(c->brick, at, size_class, values[0],
                   used > 1 ? cvol_bit_length((uint32_t)used - 1) : 0);
}

/* The eight parts of an octant that is split: cost and error of all. */
static cvol_part_choice choose_fours(const choosing *c, int used[8], int octant)
{
    const int half[3] = {octant & 1, octant >> 1 & 1, octant >> 2};
    cvol_part_choice all = {0};
    for (int i = 0; i < 8; i++) {
        const int quarter[3] = {i & 1, i >> 1 & 1, i >> 2};
        int begin[3], first = 0;
        for (int a = 2; a >= 0; a--) {
            begin[a] = 2 * half[a] + quarter[a];
            first = CVOL_CELL * first + 2 * quarter[a] + half[a];
        }
        int32_t *values = c->chooser->values[FOURS] + 512 * octant + 64 * i;
        const cvol_part_choice choice = choose_part(c, values, c->chooser->fours, 0, begin, first);
        used[i] = choice.used;
        all.cost += choice.cost;
        all.error += choice.error;
        note_part(c, values, choice.used, 0, begin);
    }
    return all;
}

static int may_choose(cvol_split_choice split)
{
    return split == CVOL_SPLIT_BEST || split == CVOL_SPLIT_FAST;
}

/* An octant, split or not; its cost. */
static float choose_octant(const choosing *c, cvol_cell_choice *out, int octant,
                           cvol_split_choice split)
{
    const int begin[3] = {2 * (octant & 1), 2 * (octant >> 1 & 1), 2 * (octant >> 2)};
    const int first = (octant & 1) + CVOL_CELL * ((octant >> 1 & 1) + CVOL_CELL * (octant >> 2));
    int32_t *values = c->chooser->values[EIGHTS] + 512 * octant;
    const split_margins *margins = &c->margins;
    const float finer = c->fours[octant] + OCTANT_COST, coarser = c->eights[octant] + PART_COST;
    cvol_part_choice choice = {.cost = INFINITY};
    if (split == CVOL_SPLIT_OCTANTS ||
        (may_choose(split) && finer >= margins->octant_least * coarser))
        choice = choose_part(c, values, c->chooser->eights, 1, begin, first);
    if (split == CVOL_SPLIT_FOURS || choice.cost == INFINITY ||
        (may_choose(split) && choice.cost > CVOL_LAMBDA * SPLIT_BITS_LEAST &&
         finer <= margins->octant_most * coarser)) {
        int used[8];
        const cvol_part_choice fours = choose_fours(c, used, octant);
        if (fours.cost < choice.cost) {
            for (int i = 0; i < 8; i++) {
                out->values[out->parts] = c->chooser->values[FOURS] + 512 * octant + 64 * i;
                out->used[out->parts++] = used[i];
            }
            out->split |= (uint16_t)(2u << octant);
            out->error += fours.error;
            return fours.cost;
        }
    }
    out->values[out->parts] = values;
    out->used[out->parts++] = choice.used;
    out->error += choice.error;
    note_part(c, values, choice.used, 1, begin);
    return choice.cost;
}

/* Bits of saying how the cell is split. */
static float bits_of_split(const choosing *c, const int cell[3], uint16_t split)
{
    const float *row = c->costs->of[cvol_split_row(c->brick, cell)];
    if (split == CVOL_CELL_WHOLE)
        return row[0];
    if (split == CVOL_CELL_OCTANTS)
        return row[1];
    if (split == CVOL_CELL_FOURS)
        return row[3];
    return row[2] + c->costs->of[CVOL_ROW_OCTANTS][split >> 1 & 15] +
           c->costs->of[CVOL_ROW_OCTANTS + 1][split >> 5 & 15];
}

/* Transforms as far as they are needed, and says which ways are. */
typedef struct ways {
    int whole, split;
} ways;

static ways ways_worth_trying(choosing *c, const float *samples, cvol_split_choice split)
{
    cvol_cell_chooser *chooser = c->chooser;
    float whole[8], coarser = PART_COST, finer = CELL_COST;
    if (split != CVOL_SPLIT_OCTANTS && split != CVOL_SPLIT_FOURS)
        cvol_cell_forward(chooser->coefficients, samples, CVOL_CELL_WHOLE);
    if (split == CVOL_SPLIT_NEVER)
        return (ways){1, 0};
    if (may_choose(split)) {
        weigh(whole, chooser->coefficients, c->inverse, 1);
        for (int i = 0; i < 8; i++)
            coarser += whole[i];
        if (coarser < PART_COST + CVOL_LAMBDA * SPLIT_BITS_LEAST)
            return (ways){1, 0};
    }
    if (split != CVOL_SPLIT_FOURS)
        cvol_cell_forward(chooser->eights, samples, CVOL_CELL_OCTANTS);
    if (split != CVOL_SPLIT_OCTANTS)
        cvol_cell_forward(chooser->fours, samples, CVOL_CELL_FOURS);
    if (!may_choose(split))
        return (ways){0, 1};
    weigh(c->eights, chooser->eights, c->inverse, 2);
    weigh(c->fours, chooser->fours, c->inverse, 4);
    for (int i = 0; i < 8; i++)
        finer += c->fours[i] < c->eights[i] ? c->fours[i] : c->eights[i];
    return (ways){finer >= c->margins.cell_least * coarser,
                  finer <= c->margins.cell_most * coarser};
}

void cvol_cell_choose(cvol_cell_chooser *chooser, cvol_cell_choice *out, const float *samples,
                      cvol_brick_context *brick, const size_t place[3],
                      const cvol_token_costs *costs, const cvol_chooser_options *options)
{
    static const int origin[3] = {0, 0, 0};
    const int cell[3] = {(int)place[0], (int)place[1], (int)place[2]};
    const cvol_split_choice split = options->split;
    choosing c = {.chooser = chooser,
                  .brick = brick,
                  .at = {4 * cell[0], 4 * cell[1], 4 * cell[2]},
                  .costs = costs,
                  .inverse = (float)(1 / options->step),
                  .plain = options->plain,
                  .margins = split == CVOL_SPLIT_FAST ? fast_margins : best_margins};
    const ways tried = ways_worth_trying(&c, samples, split);
    cvol_part_choice whole = {.cost = INFINITY};
    *out = (cvol_cell_choice){.split = CVOL_CELL_OCTANTS};
    if (tried.whole) {
        whole = choose_part(&c, chooser->values[WHOLE], chooser->coefficients, 2, origin, 0);
        whole.cost += CVOL_LAMBDA * bits_of_split(&c, cell, CVOL_CELL_WHOLE);
    }
    float cost = INFINITY;
    if (tried.split && whole.cost > CVOL_LAMBDA * SPLIT_BITS_LEAST) {
        cost = 0;
        for (int octant = 0; octant < 8; octant++)
            cost += choose_octant(&c, out, octant, split);
        cost += CVOL_LAMBDA * bits_of_split(&c, cell, out->split);
    }
    if (tried.whole && whole.cost <= cost) {
        *out = (cvol_cell_choice){.split = CVOL_CELL_WHOLE,
                                  .parts = 1,
                                  .error = whole.error,
                                  .values = {chooser->values[WHOLE]}};
        out->used[0] = whole.used;
        note_part(&c, chooser->values[WHOLE], whole.used, 2, origin);
    }
}
