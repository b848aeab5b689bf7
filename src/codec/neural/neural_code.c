/* The neural coder of a brick: encodes and decodes with the contexts of each coefficient. */
#include "codec/neural/neural_code.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "codec/neural/neural_internal.h"
#include "codec/neural/neural_model.h"
#include "codec/neural/neural_stream.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/sub_block_code.h"
#include "codec/quantize/trellis_states.h"

CVOL_SIMD_DECLARE(void, cvol_neural_evaluate,
                  (int16_t * out, const cvol_neural_pairs *network, const int16_t *x, int inputs));
CVOL_SIMD_DECLARE(void, cvol_neural_evaluate_kinds,
                  (int16_t(*out)[CVOL_NEURAL_OUTPUTS], const cvol_neural_pairs *network,
                   int16_t *x));

/* ---- a brick ---------------------------------------------------------------------------- */

static cvol_token_tables *make_tables(void)
{
    cvol_token_tables *tables = cvol_token_tables_create();
    if (!tables)
        return NULL;
    memcpy(tables->codes[CVOL_NEURAL_ROWS], cvol_neural_rows, sizeof cvol_neural_rows);
    cvol_token_tables_commit(tables);
    return tables;
}

cvol_neural_brick *cvol_neural_create(void)
{
    cvol_neural_fill_tables();
    cvol_neural_brick *brick = cvol_allocate_zero(1, sizeof *brick);
    if (brick) {
        brick->evaluate = CVOL_SIMD_CHOOSE(cvol_neural_evaluate);
        brick->evaluate_kinds = CVOL_SIMD_CHOOSE(cvol_neural_evaluate_kinds);
    }
    if (brick && !(brick->tables = make_tables())) {
        free(brick);
        return NULL;
    }
    return brick;
}

void cvol_neural_free(cvol_neural_brick *brick)
{
    if (!brick)
        return;
    cvol_range_encoder_free(&brick->encoder);
    free(brick->tables);
    free(brick);
}

void cvol_neural_start(cvol_neural_brick *b, const cvol_array *array, const cvol_brick_box *box)
{
    b->array = array;
    b->box = *box;
    b->parts = b->value_count = 0;
}

static int cell_number(const size_t place[3])
{
    return (int)(place[0] + CVOL_BRICK_CELLS * (place[1] + CVOL_BRICK_CELLS * place[2]));
}

void cvol_neural_put_split(cvol_neural_brick *b, const size_t place[3], uint16_t split)
{
    b->split[cell_number(place)] = split;
}

static cvol_neural_sub_block *add_part(cvol_neural_brick *b, const int at[3], int size_class,
                                       const cvol_scan *scan)
{
    cvol_neural_sub_block *p = &b->part[b->parts++];
    const int side = 4 << size_class;
    *p = (cvol_neural_sub_block){
        .size_class = (uint8_t)size_class,
        .side = (uint8_t)side,
        .scan = scan,
        .next = 1,
        .used = 1,
        .first = 4 * (at[0] + CVOL_NEURAL_SIDE * at[1] + CVOL_NEURAL_SLICE * at[2])};
    for (int a = 0; a < 3; a++) {
        const size_t left = b->array->grid.dims[a] - b->box.first[a] * CVOL_CELL -
                            4 * (size_t)at[a];
        p->at[a] = (uint8_t)at[a];
        p->n[a] = (uint8_t)(scan && cvol_coding_of(b->array)->true_length && left < (size_t)side
                                ? left
                                : (size_t)side);
    }
    return p;
}

int cvol_neural_put_sub_block(cvol_neural_brick *b, const int at[3], int size_class,
                              const cvol_scan *scan, const int32_t *values, int used)
{
    cvol_neural_sub_block *p = add_part(b, at, size_class, scan);
    if (!scan)
        return 0;
    p->values = b->value_count;
    p->used = used;
    p->length = (uint8_t)cvol_sub_block_length(scan, used);
    p->dc = values[0];
    memcpy(b->values + p->values, values, (size_t)used * sizeof *values);
    b->value_count += scan->count; /* room for other choices */
    return p->values;
}

/* ---- before the coefficients ------------------------------------------------------------ */

static int split_token(uint16_t split)
{
    return split == CVOL_CELL_WHOLE     ? 0
           : split == CVOL_CELL_OCTANTS ? 1
           : split == CVOL_CELL_FOURS   ? 3
                                        : 2;
}

static int code_split(cvol_neural_brick *b, cvol_neural_stream *s, cvol_brick_context *context,
                      const size_t place[3])
{
    const int cell[3] = {(int)place[0], (int)place[1], (int)place[2]};
    uint16_t *split = &b->split[cell_number(place)];
    const uint32_t token = cvol_neural_code_token(s, b->tables, cvol_split_row(context, cell),
                                                  (uint32_t)split_token(*split));
    if (token > 3)
        return 0;
    if (!s->encoder)
        *split = token == 0 ? CVOL_CELL_WHOLE : token == 3 ? CVOL_CELL_FOURS : CVOL_CELL_OCTANTS;
    if (token == 2) {
        uint16_t all = CVOL_CELL_OCTANTS;
        for (int half = 0; half < 2; half++)
            all |= (uint16_t)(cvol_neural_code_token(s, b->tables, CVOL_ROW_OCTANTS + half,
                                                     *split >> (1 + 4 * half) & 15)
                              << (1 + 4 * half));
        *split = all;
    }
    cvol_split_note(context, cell, (int)token);
    return 1;
}

/* Lists the sub-blocks of all cells, of which only the splits are known. */
static void list_parts(cvol_neural_brick *b, const cvol_brick_context *context)
{
    for (size_t i = 0; i < cvol_brick_box_blocks(&b->box); i++) {
        size_t place[3];
        cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
        cvol_brick_box_place(place, &b->box, i);
        const int count = cvol_cell_list_sub_blocks(parts, b->split[cell_number(place)]);
        for (int k = 0; k < count; k++) {
            int at[3];
            const int size_class = cvol_size_class(parts[k].side);
            cvol_sub_block_place(at, &parts[k], place, CVOL_CELL);
            add_part(b, at, size_class, cvol_brick_scan(context, at, size_class));
        }
    }
}

/* Codes the magnitude of a difference: a token, and raw bits. */
static uint32_t code_number(const cvol_neural_brick *b, cvol_neural_stream *s, int row,
                            uint64_t number)
{
    const uint32_t token = cvol_neural_code_token(s, b->tables, row, cvol_number_token(number));
    if (token < 4)
        return token;
    int length = (int)token - 1;
    if (token == 15)
        length = (int)cvol_neural_code_raw(s, (uint32_t)(64 - __builtin_clzll(number | 1)), 5);
    length = length < 1 ? 1 : length;
    return UINT32_C(1) << (length - 1) | cvol_neural_code_low(s, (uint32_t)number, length - 1);
}

/* Codes a sub-block's DC and the bit length of its last index. */
static int code_head(cvol_neural_brick *b, cvol_neural_stream *s, cvol_neural_sub_block *p,
                     cvol_brick_context *context)
{
    const int at[3] = {p->at[0], p->at[1], p->at[2]};
    if (!p->scan) {
        cvol_neural_note_head(b, p, context);
        return 1;
    }
    const cvol_sub_block_context around = cvol_sub_block_context_of(context, at, p->scan);
    const int64_t difference = p->dc - around.prediction;
    const uint32_t number = code_number(b, s, around.dc_row,
                                        (uint64_t)(difference < 0 ? -difference : difference));
    int64_t value = around.prediction;
    if (number) {
        value += cvol_neural_code_raw(s, difference < 0, 1) ? -(int64_t)number : (int64_t)number;
    }
    const int64_t limit = CVOL_VALUE_LIMIT / 2;
    if (value < -limit || value > limit)
        return 0;
    p->dc = (int32_t)value;
    p->length = (uint8_t)cvol_neural_code_token(
        s, b->tables, cvol_length_row(&around, p->size_class, number), p->length);
    if (p->length && 1 << (p->length - 1) > p->scan->index[p->scan->count - 1])
        return 0;
    cvol_neural_note_head(b, p, context);
    return 1;
}

/* ---- coefficients ----------------------------------------------------------------------- */

/* Codes the sign of a coefficient of this magnitude; 1: negative. */
static int code_sign(cvol_neural_brick *b, cvol_neural_stream *s, const cvol_neural_sub_block *p,
                     const cvol_neural_context *l, uint32_t magnitude, int negative)
{
    int16_t x[CVOL_NEURAL_INPUTS] __attribute__((aligned(64))), out[CVOL_NEURAL_OUTPUTS];
    const int turned = l->sum < 0, lapped = b->array->lapped != 0;
    if (!cvol_neural_has_faces(p))
        return (int)cvol_neural_code_raw(s, (uint32_t)negative, 1);
    cvol_neural_sign_inputs(x, b, p, l, magnitude);
    b->evaluate(out, &cvol_neural_sign_pairs, x, CVOL_NEURAL_SIGN_INPUTS);
    const int agrees = cvol_neural_code_logit(s, &b->states.agrees[p->size_class][lapped], out[0],
                                              negative == turned);
    return agrees ? turned : !turned;
}

/* Codes the magnitude of an index; `least`: it is the sub-block's last one, and not 0. */
static uint32_t code_size(cvol_neural_brick *b, cvol_neural_stream *s,
                          const cvol_neural_sub_block *p, const cvol_neural_context *l, int least,
                          uint32_t size)
{
    int16_t out[CVOL_NEURAL_OUTPUTS];
    uint32_t high = size >> l->shift, t = least && !l->shift;
    b->evaluate(out, &cvol_neural_magnitude_pairs, l->x, CVOL_NEURAL_INPUTS);
    while (t < CVOL_NEURAL_OUTPUTS &&
           cvol_neural_code_logit(s, &b->states.above[t][p->size_class], out[t], high > t))
        t++;
    if (t == CVOL_NEURAL_OUTPUTS) {
        const uint32_t rest = high - (CVOL_NEURAL_OUTPUTS - 1); /* at least 1 */
        const int length = s->encoder ? cvol_bit_length(rest) - 1 : 0;
        int bits = 0;
        while (bits < CVOL_NEURAL_ESCAPES - 1 &&
               cvol_neural_code_bit(s, &b->states.escape[bits], bits < length))
            bits++;
        t += (UINT32_C(1) << bits | cvol_neural_code_low(s, rest, bits)) - 1;
    }
    if (!l->shift)
        return t;
    const uint64_t all = (uint64_t)t << l->shift | cvol_neural_code_low(s, size, l->shift);
    return all > UINT32_MAX ? UINT32_MAX : (uint32_t)all;
}

/* Codes the last index within its bit length. */
static uint32_t code_last(cvol_neural_brick *b, cvol_neural_stream *s,
                          const cvol_neural_sub_block *p, uint32_t last)
{
    const int length = p->length, row = cvol_more_row(p->size_class, length);
    if (length == 1)
        return 1;
    if (length == 2)
        return 2 | (cvol_neural_code_token(s, b->tables, row, last & 1) & 1);
    const uint32_t top = 4 |
                         (cvol_neural_code_token(s, b->tables, row, last >> (length - 3) & 3) & 3);
    return top << (length - 3) | cvol_neural_code_low(s, last, length - 3);
}

/* Codes one coefficient, as an index; returns 0 if it is invalid. */
static int code_value(cvol_neural_brick *b, cvol_neural_stream *s, cvol_neural_sub_block *p,
                      cvol_neural_view *view, cvol_neural_position *q)
{
    cvol_neural_context l;
    const int32_t given = s->encoder ? b->values[p->values + q->index] : 0;
    const int is_last = q->index == q->last;
    cvol_neural_context_at(&l, b, view, p, q);
    const uint32_t size = code_size(b, s, p, &l, is_last, cvol_magnitude(given));
    if (size > CVOL_VALUE_LIMIT / 2 || (is_last && !size))
        return 0;
    const int negative = size &&
                         code_sign(b, s, p, &l, cvol_trellis_magnitude(q->state, size), given < 0);
    cvol_neural_note_value(b, p, view, q, &l, size, negative);
    return 1;
}

/* Codes a sub-block's coefficients of one subband; returns 0 if the stream is invalid. */
static int code_part(cvol_neural_brick *b, cvol_neural_stream *s, cvol_neural_sub_block *p,
                     int subband)
{
    cvol_neural_position q;
    cvol_neural_view view;
    int end = cvol_neural_begin_sub_block(&q, p, subband);
    if (!end)
        return 1;
    if (cvol_neural_has_last(p, subband)) {
        q.last = p->scan->compact[code_last(b, s, p, s->encoder ? p->scan->index[p->used - 1] : 0)];
        if (q.last == CVOL_SCAN_NONE || q.last < p->next)
            return 0;
        end = q.last + 1;
    }
    cvol_neural_view_sub_block(&view, b, p, cvol_neural_known_cube(p, subband));
    while (q.index < end)
        if (!code_value(b, s, p, &view, &q))
            return 0;
    cvol_neural_end_sub_block(b, p, &q, subband);
    return 1;
}

/* ---- bricks ----------------------------------------------------------------------------- */

static int code_subband(cvol_neural_brick *b, cvol_neural_stream *s, cvol_brick_context *context,
                        int subband)
{
    if (!subband) {
        for (size_t i = 0; i < cvol_brick_box_blocks(&b->box); i++) {
            size_t place[3];
            cvol_brick_box_place(place, &b->box, i);
            if (!code_split(b, s, context, place))
                return 0;
        }
        if (!s->encoder)
            list_parts(b, context);
        cvol_neural_find_neighbours(b);
        for (int i = 0; i < b->parts; i++)
            if (!code_head(b, s, &b->part[i], context))
                return 0;
    }
    for (int i = 0; i < b->parts; i++)
        if (b->part[i].scan && !b->part[i].finished && !code_part(b, s, &b->part[i], subband))
            return 0;
    return 1;
}

int cvol_neural_finish(cvol_neural_brick *b, cvol_bytes subbands[CVOL_SUBBANDS],
                       cvol_brick_context *context)
{
    cvol_neural_stream s = {.encoder = &b->encoder};
    cvol_neural_start_coding(b);
    for (int subband = 0; subband < CVOL_SUBBANDS; subband++) {
        cvol_range_encoder_start(&b->encoder);
        subbands[subband].size = 0;
        if (!code_subband(b, &s, context, subband))
            return 0;
        if (b->encoder.range == UINT64_MAX && !b->encoder.raw_count)
            continue; /* an empty subband */
        if (!cvol_range_encoder_finish(&b->encoder, &subbands[subband]))
            return 0;
    }
    return 1;
}

int cvol_neural_decode(cvol_neural_brick *b, cvol_brick_context *context,
                       const cvol_span subbands[CVOL_SUBBANDS], int count)
{
    cvol_neural_stream s = {.encoder = NULL};
    cvol_neural_start_coding(b);
    for (int subband = 0; subband < count; subband++) {
        cvol_range_decoder_start(&s.decoder, subbands[subband].data, subbands[subband].size);
        if (!code_subband(b, &s, context, subband))
            return CVOL_ERROR_CORRUPT;
        const int is_empty = s.decoder.range == UINT64_MAX && !s.decoder.raw_read;
        if (is_empty ? subbands[subband].size > 0 : cvol_range_decoder_overrun(&s.decoder))
            return CVOL_ERROR_CORRUPT;
    }
    return CVOL_OK;
}

uint16_t cvol_neural_cell(const cvol_neural_brick *b, const size_t place[3],
                          int32_t values[CVOL_CELL_SAMPLES], uint64_t found[CVOL_CELL_SAMPLES / 64])
{
    const uint16_t split = b->split[cell_number(place)];
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    const int count = cvol_cell_list_sub_blocks(parts, split);
    for (int k = 0; k < count; k++) {
        const int M = parts[k].side, apart = CVOL_CELL / M;
        const int32_t *known = b->known +
                               CVOL_CELL * (place[0] + CVOL_NEURAL_SIDE * place[1] +
                                            CVOL_NEURAL_SLICE * place[2]) +
                               parts[k].begin[0] + CVOL_NEURAL_SIDE * parts[k].begin[1] +
                               CVOL_NEURAL_SLICE * parts[k].begin[2];
        const int first = parts[k].first[0] +
                          CVOL_CELL * (parts[k].first[1] + CVOL_CELL * parts[k].first[2]);
        for (int w = 0; w < M; w++)
            for (int v = 0; v < M; v++)
                for (int u = 0; u < M; u++) {
                    const int32_t value = known[u + CVOL_NEURAL_SIDE * v + CVOL_NEURAL_SLICE * w];
                    const int to = first + apart * (u + CVOL_CELL * (v + CVOL_CELL * w));
                    values[to] = value;
                    if (value)
                        found[to / 64] |= UINT64_C(1) << to % 64;
                }
    }
    return split;
}
