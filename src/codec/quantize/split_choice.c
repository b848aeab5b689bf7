/* Chooses a cell's split. */
#include "codec/quantize/split_choice.h"
#include "array/block/cell_weight.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "codec/quantize/brick_box.h"
#include "codec/quantize/split_extension.h"
#include "codec/quantize/trellis.h"
#include "codec/quantize/true_length.h"

/* Limits of weights for trying splits: skips the coarser way if the finer one's weight is below
 * `least` times its own, and the finer way if its weight is above `most` times. Measured on eleven
 * volumes at eight steps, the ways that BEST skips would save 0.4 % of the bits. */
typedef struct split_margins {
    float cell_least, cell_most, octant_least, octant_most;
} split_margins;
static const split_margins best_margins = {0.75f, 0.93f, 0.8f, 0.97f};
static const split_margins neural_margins = {0.5f, 1.1f, 0.5f, 1.1f};

/* Each of three ways, whole, eights and fours, has room for the values of all its sub-blocks. */
enum { WHOLE, EIGHTS, FOURS, WAYS };

struct cvol_cell_chooser {
    float coefficients[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float eights[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float fours[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float scaled[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    int32_t values[WAYS][CVOL_CELL_SAMPLES];
    uint16_t scatter[CVOL_SCATTER_MAX];
    cvol_cell_edge edge;
    cvol_trellis *trellis; /* allocated on first use */
};

/* The state of one cell's choice. */
typedef struct choosing {
    cvol_cell_chooser *chooser;
    cvol_brick_context *brick;
    int at[3];         /* the cell's first sample, in units of four samples of the brick */
    const int *inside; /* samples of the cell within the volume, along each axis */
    const cvol_token_costs *costs;
    float inverse; /* of the step */
    int plain;
    int by_weight; /* the choice by weights is final: costs are not compared, and values are
                      chosen later */
    split_margins margins;
    cvol_split_bias split_bias;
    float eights[8], fours[8]; /* weights of the octants */
} choosing;

cvol_cell_chooser *cvol_cell_chooser_create(void)
{
    cvol_cell_chooser *chooser = cvol_allocate(1, sizeof *chooser);
    if (!chooser)
        return NULL;
    memset(chooser->scatter, 0, sizeof chooser->scatter);
    chooser->trellis = cvol_trellis_create();
    if (chooser->trellis)
        return chooser;
    free(chooser);
    return NULL;
}

void cvol_cell_chooser_free(cvol_cell_chooser *chooser)
{
    if (chooser)
        cvol_trellis_free(chooser->trellis);
    free(chooser);
}

/* The scan of a sub-block, and its place within the brick. begin: its first sample within the cell,
 * in units of four. */
static const cvol_scan *scan_of(const choosing *c, int at[3], const int begin[3], int size_class)
{
    for (int a = 0; a < 3; a++)
        at[a] = c->at[a] + begin[a];
    int seen;
    return cvol_brick_scan_of(c->brick, at, size_class, &seen);
}

/* True if a sub-block lies in padding. */
static int is_beyond(const choosing *c, const int begin[3], int size_class)
{
    const int first[3] = {4 * begin[0], 4 * begin[1], 4 * begin[2]};
    return cvol_cell_reaches_beyond(c->inside, first, 4 << size_class) == 2;
}

/* A sub-block in padding takes the neighbours' prediction. */
static cvol_sub_block_choice choose_unseen(int32_t *values, const cvol_scan *scan,
                                           const cvol_sub_block_context *context)
{
    memset(values, 0, sizeof *values * (size_t)scan->count);
    values[0] = (int32_t)context->prediction;
    return (cvol_sub_block_choice){.used = 1};
}

/* Chooses for one sub-block. begin: its first sample within the cell, in units of four. */
static cvol_sub_block_choice choose_part(const choosing *c, int32_t *values,
                                         const float *coefficients, int size_class,
                                         const int begin[3], int first)
{
    int at[3];
    const cvol_scan *scan = scan_of(c, at, begin, size_class);
    float *scaled = c->chooser->scaled;
    const cvol_sub_block_context context = cvol_sub_block_context_of(c->brick, at, scan);
    if (is_beyond(c, begin, size_class))
        return choose_unseen(values, scan, &context);
    for (int i = 0; i < scan->count; i++)
        scaled[i] = coefficients[first + scan->entries[i].in_cell] * c->inverse;
    return cvol_sub_block_choose(values, scaled, scan, c->costs, &context, c->plain,
                                 c->chooser->scatter);
}

static void note_part(const choosing *c, const int32_t *values, int used, int size_class,
                      const int begin[3])
{
    int at[3];
    const cvol_scan *scan = scan_of(c, at, begin, size_class);
    cvol_sub_block_note(c->brick, at, scan, values[0],
                        cvol_sub_block_length(scan, used < scan->count ? used : scan->count));
}

/* For a sub-block whose values are chosen later: records an approximate context for its
 * neighbours. */
static void note_unchosen(const choosing *c, const float *coefficients, int size_class,
                          const int begin[3], int first)
{
    const float dc = coefficients[first] * c->inverse;
    const int32_t value = fabsf(dc) < 0x1p29f ? (int32_t)lrintf(dc) : 0;
    note_part(c, &value, 1 << 3 * (size_class + 1), size_class, begin);
}

/* The begin of sub-block i of a split octant: within the cell, in units of four, and among the
 * coefficients (returned). */
static int place_four(int begin[3], int octant, int i)
{
    const int half[3] = {octant & 1, octant >> 1 & 1, octant >> 2};
    const int quarter[3] = {i & 1, i >> 1 & 1, i >> 2};
    int first = 0;
    for (int a = 2; a >= 0; a--) {
        begin[a] = 2 * half[a] + quarter[a];
        first = CVOL_CELL * first + 2 * quarter[a] + half[a];
    }
    return first;
}

/* Chooses the eight sub-blocks of a split octant; returns their total cost and error. */
static cvol_sub_block_choice choose_fours(const choosing *c, int used[8], int octant)
{
    cvol_sub_block_choice all = {0};
    for (int i = 0; i < 8; i++) {
        int begin[3];
        const int first = place_four(begin, octant, i);
        int32_t *values = c->chooser->values[FOURS] + 512 * octant + 64 * i;
        const cvol_sub_block_choice choice = choose_part(c, values, c->chooser->fours, 0, begin,
                                                         first);
        used[i] = choice.used;
        all.cost += choice.cost;
        all.error += choice.error;
        note_part(c, values, choice.used, 0, begin);
    }
    return all;
}

static int may_choose(cvol_split_choice split)
{
    return split == CVOL_SPLIT_BEST;
}

/* Codes an octant as eight sub-blocks; used is NULL if their values are chosen later. */
static void take_fours(const choosing *c, cvol_cell_choice *out, const int *used, int octant)
{
    for (int i = 0; i < 8; i++) {
        int begin[3];
        const int first = place_four(begin, octant, i);
        if (!used)
            note_unchosen(c, c->chooser->fours, 0, begin, first);
        out->values[out->parts] = c->chooser->values[FOURS] + 512 * octant + 64 * i;
        out->used[out->parts++] = used ? used[i] : 1;
    }
    out->split |= (uint16_t)(2u << octant);
}

/* Chooses an octant, split or not; returns its cost. */
static float choose_octant(const choosing *c, cvol_cell_choice *out, int octant,
                           cvol_split_choice split)
{
    const int begin[3] = {2 * (octant & 1), 2 * (octant >> 1 & 1), 2 * (octant >> 2)};
    const int first = (octant & 1) + CVOL_CELL * ((octant >> 1 & 1) + CVOL_CELL * (octant >> 2));
    int32_t *values = c->chooser->values[EIGHTS] + 512 * octant;
    const split_margins *margins = &c->margins;
    const float finer = c->fours[octant] + CVOL_OCTANT_COST,
                coarser = c->eights[octant] + CVOL_SUB_BLOCK_COST;
    const int may_eights = split == CVOL_SPLIT_OCTANTS ||
                           (may_choose(split) && finer >= margins->octant_least * coarser),
              may_fours = split == CVOL_SPLIT_FOURS ||
                          (may_choose(split) && finer <= margins->octant_most * coarser);
    cvol_sub_block_choice choice = {.cost = INFINITY};
    values[0] = 0; /* the value if neither way fits */
    if (c->by_weight && may_eights != may_fours) {
        if (may_fours) {
            take_fours(c, out, NULL, octant);
            return 0;
        }
        note_unchosen(c, c->chooser->eights, 1, begin, first);
        choice = (cvol_sub_block_choice){.used = 1};
    } else {
        if (may_eights)
            choice = choose_part(c, values, c->chooser->eights, 1, begin, first);
        if (choice.cost == INFINITY ||
            (may_fours && choice.cost > CVOL_LAMBDA * CVOL_SPLIT_BITS_MIN)) {
            int used[8];
            const cvol_sub_block_choice fours = choose_fours(c, used, octant);
            if (c->split_bias.octant * fours.cost < choice.cost) {
                take_fours(c, out, used, octant);
                out->error += fours.error;
                return fours.cost;
            }
        }
        note_part(c, values, choice.used, 1, begin);
    }
    out->values[out->parts] = values;
    out->used[out->parts++] = choice.used;
    out->error += choice.error;
    return choice.cost;
}

/* Chooses the values of all sub-blocks again, by the best path through the trellis states. */
static void choose_paths(const choosing *c, cvol_cell_choice *out)
{
    cvol_cell_chooser *chooser = c->chooser;
    const float *coefficients[CVOL_SUB_BLOCK_SIZES] = {chooser->fours, chooser->eights,
                                                       chooser->coefficients};
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    int begin_of = 0;
    cvol_cell_list_sub_blocks(parts, out->split);
    out->error = 0;
    for (int p = 0; p < out->parts; p++) {
        const int size_class = cvol_size_class(parts[p].side);
        const int *first = parts[p].first;
        const float *from = coefficients[size_class] + first[0] +
                            CVOL_CELL * (first[1] + CVOL_CELL * first[2]);
        const int begin[3] = {parts[p].begin[0] / 4, parts[p].begin[1] / 4, parts[p].begin[2] / 4};
        int at[3];
        const cvol_scan *scan = scan_of(c, at, begin, size_class);
        float *scaled = chooser->scaled + begin_of;
        for (int i = 0; i < scan->count; i++)
            scaled[i] = from[scan->entries[i].in_cell] * c->inverse;
        out->scaled[p] = scaled;
        begin_of += scan->count;
        const cvol_sub_block_context context = cvol_sub_block_context_of(c->brick, at, scan);
        const cvol_sub_block_choice choice = is_beyond(c, begin, size_class)
                                                 ? choose_unseen(out->values[p], scan, &context)
                                                 : cvol_trellis_choose(
                                                       chooser->trellis, out->values[p], scaled,
                                                       scan, c->costs, &context, chooser->scatter);
        out->used[p] = choice.used;
        out->error += 4 * choice.error;
        cvol_sub_block_note(c->brick, at, scan, out->values[p][0],
                            cvol_sub_block_length(scan, choice.used));
    }
}

/* Bits of the cell's split tokens. */
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

static void transform(const choosing *c, float *coefficients, const float *samples, uint16_t split)
{
    static const int origin[3] = {0, 0, 0};
    if (!cvol_cell_reaches_beyond(c->inside, origin, CVOL_CELL))
        cvol_cell_forward(coefficients, samples, split);
    else if (c->brick->true_length)
        cvol_true_length_forward(coefficients, samples, c->inside, split);
    else
        cvol_cell_forward_edge(coefficients, &c->chooser->edge, samples, c->inside, split,
                               1 / c->inverse);
}

/* Computes the necessary transforms, and returns the ways to try. */
typedef struct ways {
    int whole, split;
} ways;

static ways choose_attempts(choosing *c, const float *samples, cvol_split_choice split)
{
    cvol_cell_chooser *chooser = c->chooser;
    float whole[8], coarser = CVOL_SUB_BLOCK_COST, finer = CVOL_CELL_COST;
    if (split != CVOL_SPLIT_OCTANTS && split != CVOL_SPLIT_FOURS)
        transform(c, chooser->coefficients, samples, CVOL_CELL_WHOLE);
    if (split == CVOL_SPLIT_NEVER)
        return (ways){1, 0};
    if (may_choose(split)) {
        cvol_cell_weigh(whole, chooser->coefficients, c->inverse, 1);
        for (int i = 0; i < 8; i++)
            coarser += whole[i];
        if (coarser < CVOL_SUB_BLOCK_COST + CVOL_LAMBDA * CVOL_SPLIT_BITS_MIN)
            return (ways){1, 0};
    }
    if (split != CVOL_SPLIT_FOURS)
        transform(c, chooser->eights, samples, CVOL_CELL_OCTANTS);
    if (split != CVOL_SPLIT_OCTANTS)
        transform(c, chooser->fours, samples, CVOL_CELL_FOURS);
    if (!may_choose(split))
        return (ways){0, 1};
    cvol_cell_weigh(c->eights, chooser->eights, c->inverse, 2);
    cvol_cell_weigh(c->fours, chooser->fours, c->inverse, 4);
    for (int i = 0; i < 8; i++)
        finer += c->fours[i] < c->eights[i] ? c->fours[i] : c->eights[i];
    return (ways){finer >= c->margins.cell_least * coarser,
                  finer <= c->margins.cell_most * coarser};
}

void cvol_cell_choose(cvol_cell_chooser *chooser, cvol_cell_choice *out, const float *samples,
                      const int inside[3], cvol_brick_context *brick, const size_t place[3],
                      const cvol_token_costs *costs, const cvol_chooser_options *options)
{
    static const int origin[3] = {0, 0, 0};
    const int cell[3] = {(int)place[0], (int)place[1], (int)place[2]};
    const cvol_split_choice split = options->split;
    choosing c = {.chooser = chooser,
                  .brick = brick,
                  .at = {4 * cell[0], 4 * cell[1], 4 * cell[2]},
                  .inside = inside,
                  .costs = costs,
                  .inverse = (float)((options->trellis ? 0.5 : 1) / options->step),
                  .plain = options->plain,
                  .margins = options->split_bias.cell > 0 ? neural_margins : best_margins,
                  .split_bias = options->split_bias.cell > 0 ? options->split_bias
                                                             : (cvol_split_bias){1, 1}};
    const ways tried = choose_attempts(&c, samples, split);
    cvol_sub_block_choice whole = {.cost = INFINITY};
    *out = (cvol_cell_choice){.split = CVOL_CELL_OCTANTS};
    c.by_weight = options->trellis && !tried.whole;
    if (options->trellis && !tried.split) {
        whole.used = 1;
        whole.cost = 0;
    } else if (tried.whole) {
        whole = choose_part(&c, chooser->values[WHOLE], chooser->coefficients, 2, origin, 0);
        whole.cost += CVOL_LAMBDA * bits_of_split(&c, cell, CVOL_CELL_WHOLE);
    }
    float cost = INFINITY;
    if (tried.split && whole.cost > CVOL_LAMBDA * CVOL_SPLIT_BITS_MIN) {
        cost = 0;
        for (int octant = 0; octant < 8; octant++)
            cost += choose_octant(&c, out, octant, split);
        cost += CVOL_LAMBDA * bits_of_split(&c, cell, out->split);
    }
    if (tried.whole && whole.cost <= c.split_bias.cell * cost) {
        *out = (cvol_cell_choice){.split = CVOL_CELL_WHOLE,
                                  .parts = 1,
                                  .error = whole.error,
                                  .values = {chooser->values[WHOLE]}};
        out->used[0] = whole.used;
        note_part(&c, chooser->values[WHOLE], whole.used, 2, origin);
    }
    if (options->trellis)
        choose_paths(&c, out);
}
