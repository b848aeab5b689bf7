/* Measures layer by layer. */
#include "codec/rate/layer_measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/brick/subbands.h"
#include "codec/quantize/coding.h"

enum { LAP_REACH = 2, SLOTS = 3 };

/* A brick's bytes, and later its terms. */
typedef struct kept_brick {
    cvol_bytes subbands[CVOL_SUBBANDS];
    uint32_t *words;
    uint64_t terms;
    double squares[CVOL_SUBBANDS]; /* of its values */
    int code;
} kept_brick;

struct cvol_layer_measure {
    cvol_array *array; /* with the terms of this layer and the one before */
    const cvol_token_tables *tables;
    cvol_brick_sink next;
    cvol_team *team;
    kept_brick *bricks[SLOTS]; /* see slot_of */
    size_t per_layer;
    cvol_distance sum;             /* of squares */
    double squares[CVOL_SUBBANDS]; /* of all values */
};

static void free_bricks(kept_brick *bricks, size_t count)
{
    for (size_t i = 0; bricks && i < count; i++) {
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            cvol_bytes_free(&bricks[i].subbands[s]);
        free(bricks[i].words);
    }
    free(bricks);
}

void cvol_layer_measure_free(cvol_layer_measure *measure)
{
    if (!measure)
        return;
    cvol_array_free(measure->array);
    for (int i = 0; i < SLOTS; i++)
        free_bricks(measure->bricks[i], measure->per_layer);
    free(measure);
}

int cvol_layer_measure_make(cvol_context *context, cvol_layer_measure **out,
                            const cvol_array *shape, double step, const cvol_token_tables *tables,
                            const cvol_brick_sink *sink, cvol_team *team)
{
    cvol_layer_measure *measure = cvol_allocate_zero(1, sizeof *measure);
    *out = measure;
    if (!measure)
        return cvol_fail_memory(context, sizeof *measure, "the measure");
    size_t grid[3];
    cvol_brick_grid(grid, shape);
    measure->per_layer = grid[0] * grid[1];
    measure->tables = tables;
    measure->next = *sink;
    measure->team = team;
    int code = cvol_array_create(context, &measure->array, &shape->grid, shape->block);
    if (!code)
        code = cvol_coding_copy(context, measure->array, shape);
    if (!code) {
        cvol_array *array = measure->array;
        array->step = ldexp(step, -cvol_coding_of(shape)->true_length);
        array->offset = shape->offset;
        array->lapped = shape->lapped;
        array->error_bound.value_min = shape->error_bound.value_min;
        array->error_bound.value_max = shape->error_bound.value_max;
        for (int i = 0; i < (team ? SLOTS : 2) && !code; i++) {
            measure->bricks[i] = cvol_allocate_zero(measure->per_layer, sizeof(kept_brick));
            if (!measure->bricks[i])
                code = cvol_fail_memory(context, measure->per_layer * sizeof(kept_brick),
                                        "a layer");
        }
    }
    if (code) {
        cvol_layer_measure_free(measure);
        *out = NULL;
    }
    return code;
}

/* Where a layer's bricks are kept; -1: they are not. A process of a team keeps its own layers, and
 * those before them: the next one of these arrives before it has measured its own. */
static int slot_of(const cvol_layer_measure *measure, size_t layer)
{
    if (!measure->team)
        return (int)(layer % 2);
    if (cvol_team_does(measure->team, layer))
        return 0;
    return cvol_team_does(measure->team, layer + 1)
               ? 1 + (int)((layer + 1) / (size_t)measure->team->size % 2)
               : -1;
}

static int take(cvol_context *context, void *user, size_t brick,
                const cvol_span subbands[CVOL_SUBBANDS])
{
    cvol_layer_measure *measure = user;
    const size_t layer = brick / measure->per_layer;
    const int slot = slot_of(measure, layer);
    kept_brick *to = slot < 0 ? NULL : &measure->bricks[slot][brick % measure->per_layer];
    for (int s = 0; s < CVOL_SUBBANDS && to; s++) {
        to->subbands[s].size = 0;
        cvol_bytes_append(&to->subbands[s], subbands[s].data, subbands[s].size);
        if (to->subbands[s].failed)
            return cvol_fail_memory(context, subbands[s].size, "a brick");
    }
    return measure->next.take(context, measure->next.user, brick, subbands);
}

cvol_brick_sink cvol_layer_measure_sink(cvol_layer_measure *measure)
{
    return (cvol_brick_sink){take, measure};
}

/* Decodes a brick, and gives its terms to its blocks. */
static int decode_brick(cvol_layer_measure *measure, cvol_brick_coder *coder, kept_brick *kept,
                        size_t brick)
{
    cvol_array *array = measure->array;
    cvol_span spans[CVOL_SUBBANDS];
    cvol_brick_terms terms;
    free(kept->words);
    kept->words = NULL;
    if (!coder)
        return CVOL_ERROR_MEMORY;
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        spans[s] = (cvol_span){kept->subbands[s].data, kept->subbands[s].size};
    const int code = cvol_brick_decode(coder, &terms, array, brick, spans, CVOL_SUBBANDS);
    if (code)
        return code;
    kept->words = malloc((terms.word_count + 1) * sizeof *kept->words);
    if (!kept->words)
        return CVOL_ERROR_MEMORY;
    memcpy(kept->words, terms.words, terms.word_count * sizeof *kept->words);
    kept->terms = terms.terms;
    const cvol_brick_box box = cvol_brick_box_of(array, brick);
    const uint32_t *words = kept->words;
    memset(kept->squares, 0, sizeof kept->squares);
    for (size_t i = 0; i < cvol_brick_box_blocks(&box); i++) {
        cvol_block *block = &array->block_table[cvol_brick_block_index(array, &box, i)];
        block->terms = words;
        words += block->words;
        cvol_block_find_low(block, array->block_log2);
        cvol_subband_squares(kept->squares, array, cvol_brick_block_index(array, &box, i));
    }
    return CVOL_OK;
}

static int decode_layer(cvol_context *context, cvol_layer_measure *measure, size_t layer)
{
    kept_brick *bricks = measure->bricks[slot_of(measure, layer)];
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_brick_coder *coder = cvol_brick_coder_create(measure->tables);
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < measure->per_layer; i++)
            bricks[i].code = decode_brick(measure, coder, &bricks[i],
                                          layer * measure->per_layer + i);
        cvol_brick_coder_free(coder);
    }
    for (size_t i = 0; i < measure->per_layer; i++) {
        if (bricks[i].code == CVOL_ERROR_MEMORY)
            return cvol_fail_memory(context, (size_t)1 << 20, "a brick");
        if (bricks[i].code)
            return cvol_fail(context, CVOL_ERROR_CORRUPT, "brick %zu does not decode again",
                             layer * measure->per_layer + i);
    }
    return CVOL_OK;
}

static void add_brick(cvol_layer_measure *measure, uint64_t terms,
                      const double squares[CVOL_SUBBANDS])
{
    measure->array->coefficients += terms;
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        measure->squares[s] += squares[s];
}

/* The slices that can be compared after a layer. */
static void find_slices(size_t *begin, size_t *end, const cvol_layer_measure *measure, size_t layer)
{
    const size_t slices = measure->array->grid.dims[2],
                 side = cvol_coding_of(measure->array)->brick.side[2],
                 reach = measure->array->lapped ? LAP_REACH : 0, after = (layer + 1) * side;
    *begin = layer ? layer * side - reach : 0;
    *end = after < slices ? after - reach : slices;
}

/* ---- teams ------------------------------------------------------------------------------ */

/* What one process tells the others about a layer: this for each brick, then distances. */
typedef struct packed_brick {
    uint64_t terms;
    double squares[CVOL_SUBBANDS];
} packed_brick;

/* Decodes a layer of its own, and the one before, on which its first slices depend. */
static int pack_layer(cvol_context *context, cvol_bytes *out, cvol_layer_measure *measure,
                      const cvol_slab *slab, size_t layer)
{
    const kept_brick *bricks = measure->bricks[slot_of(measure, layer)];
    cvol_piece_distances pieces = {NULL, 0};
    size_t begin, end;
    int code = layer ? decode_layer(context, measure, layer - 1) : CVOL_OK;
    if (!code)
        code = decode_layer(context, measure, layer);
    find_slices(&begin, &end, measure, layer);
    if (!code && begin < end)
        code = cvol_measure_pieces(context, &pieces, measure->array, slab, begin, end, NULL);
    for (size_t i = 0; i < measure->per_layer && !code; i++) {
        packed_brick one = {.terms = bricks[i].terms};
        memcpy(one.squares, bricks[i].squares, sizeof one.squares);
        cvol_bytes_append(out, &one, sizeof one);
    }
    if (!code)
        cvol_bytes_append(out, pieces.of, pieces.count * sizeof *pieces.of);
    free(pieces.of);
    return !code && out->failed ? cvol_fail_memory(context, out->size, "a layer") : code;
}

/* Adds what the processes have measured, layer after layer. */
static void add_layers(cvol_layer_measure *measure, const cvol_gathered *from)
{
    for (int rank = 0; rank < measure->team->size; rank++) {
        const uint8_t *at = from->all + from->offsets[rank],
                      *end = from->all + from->offsets[rank + 1];
        for (size_t i = 0; i < measure->per_layer && at < end; i++) {
            packed_brick one;
            memcpy(&one, at, sizeof one);
            at += sizeof one;
            add_brick(measure, one.terms, one.squares);
        }
        for (; at < end; at += sizeof(cvol_distance)) {
            cvol_distance one;
            memcpy(&one, at, sizeof one);
            cvol_distances_add(&measure->sum, &one, 1);
        }
    }
}

static int measure_by_team(cvol_context *context, cvol_layer_measure *measure,
                           const cvol_slab *slab, size_t layer, size_t end)
{
    cvol_bytes own = {0};
    cvol_gathered all;
    int code = layer < end ? pack_layer(context, &own, measure, slab, layer) : CVOL_OK;
    code = cvol_team_gather(context, &all, measure->team, code, own.data, own.size);
    if (!code)
        add_layers(measure, &all);
    cvol_gathered_free(&all);
    cvol_bytes_free(&own);
    return code;
}

int cvol_layer_measure_after(cvol_context *context, void *user, const cvol_slab *slab, size_t layer,
                             size_t end)
{
    cvol_layer_measure *measure = user;
    int code = CVOL_OK;
    if (measure->team)
        return measure_by_team(context, measure, slab, layer, end);
    for (; layer < end && !code; layer++) {
        const kept_brick *bricks = measure->bricks[slot_of(measure, layer)];
        size_t z, last;
        find_slices(&z, &last, measure, layer);
        code = decode_layer(context, measure, layer);
        for (size_t i = 0; i < measure->per_layer && !code; i++)
            add_brick(measure, bricks[i].terms, bricks[i].squares);
        if (!code && z < last)
            code = cvol_measure_slices(context, &measure->sum, measure->array, slab, z, last, NULL);
    }
    return code;
}

void cvol_layer_measure_report(const cvol_layer_measure *measure, cvol_array *array,
                               double subband_norm[CVOL_SUBBANDS])
{
    cvol_subband_norms_of(subband_norm, measure->squares, measure->array->step);
    cvol_distance distance = measure->sum;
    cvol_distance_finish(&distance);
    cvol_array_set_measured(array, &distance);
    const double rounding = cvol_distance_rounding(array, &distance);
    array->error_bound.l2_error = distance.real_l2_error + rounding;
    array->error_bound.max_abs = distance.real_max_abs + rounding;
    array->coefficients = measure->array->coefficients;
}
