/* The small coder of a brick: what is known around each coefficient, both ways. */
#include "codec/small_code.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "codec/dependent.h"
#include "codec/small_internal.h"
#include "codec/small_model.h"

enum { BUCKET_BITS = 7 };

CVOL_SIMD_DECLARE(void, cvol_small_evaluate,
                  (int16_t * out, const cvol_small_pairs *network, const int16_t *x, int inputs));

/* Whoever trains looks on: kind 0, decisions `first` .. of what a magnitude is above; 1, whether a
 * sign agrees. */
#ifdef CVOL_SMALL_WATCH
#define WATCH(kind, x, first, high) CVOL_SMALL_WATCH(kind, x, first, high)
#else
#define WATCH(kind, x, first, high)
#endif

/* ---- a brick ---------------------------------------------------------------------------- */

cvol_small_brick *cvol_small_create(void)
{
    cvol_small_fill_tables();
    cvol_small_brick *brick = cvol_allocate_zero(1, sizeof *brick);
    if (brick)
        brick->evaluate = CVOL_SIMD_CHOOSE(cvol_small_evaluate);
    if (brick && !(brick->tables = cvol_token_tables_create())) {
        free(brick);
        return NULL;
    }
    return brick;
}

void cvol_small_free(cvol_small_brick *brick)
{
    if (!brick)
        return;
    cvol_range_encoder_free(&brick->encoder);
    free(brick->tables);
    free(brick);
}

void cvol_small_start(cvol_small_brick *b, const cvol_array *array, const cvol_brick_box *box)
{
    b->array = array;
    b->box = *box;
    b->parts = b->value_count = 0;
}

static int cell_number(const size_t place[3])
{
    return (int)(place[0] + CVOL_BRICK_CELLS * (place[1] + CVOL_BRICK_CELLS * place[2]));
}

void cvol_small_put_split(cvol_small_brick *b, const size_t place[3], uint16_t split)
{
    b->split[cell_number(place)] = split;
}

static cvol_small_part *add_part(cvol_small_brick *b, const int at[3], int size_class,
                                 const cvol_scan *scan)
{
    cvol_small_part *p = &b->part[b->parts++];
    const int side = 4 << size_class;
    *p = (cvol_small_part){.size_class = (uint8_t)size_class,
                           .side = (uint8_t)side,
                           .scan = scan,
                           .next = 1,
                           .used = 1,
                           .first = 4 *
                                    (at[0] + CVOL_SMALL_SIDE * at[1] + CVOL_SMALL_SHEET * at[2])};
    for (int a = 0; a < 3; a++) {
        const size_t left = b->array->grid.dims[a] - b->box.first[a] * CVOL_CELL -
                            4 * (size_t)at[a];
        p->at[a] = (uint8_t)at[a];
        p->n[a] = (uint8_t)(scan && b->array->ends && left < (size_t)side ? left : (size_t)side);
    }
    return p;
}

void cvol_small_put_part(cvol_small_brick *b, const int at[3], int size_class,
                         const cvol_scan *scan, const int32_t *values, int used)
{
    cvol_small_part *p = add_part(b, at, size_class, scan);
    if (!scan)
        return;
    p->values = b->value_count;
    p->used = used;
    p->length = (uint8_t)cvol_part_length(scan, used);
    p->dc = values[0];
    memcpy(b->values + p->values, values, (size_t)used * sizeof *values);
    b->value_count += used;
}

/* Makes everything new but the parts. */
static void start_coding(cvol_small_brick *b)
{
    const uint16_t half = 1 << 15;
    cvol_small_curve fresh;
    memset(b->known, 0, sizeof b->known);
    memset(b->blur, 0, sizeof b->blur);
    for (int k = 0; k < CVOL_SMALL_BUCKETS; k++)
        fresh.at[k] = cvol_small_likelihood[k == CVOL_SMALL_BUCKETS - 1 ? 4095 : k << BUCKET_BITS];
    for (int k = 0; k < 3; k++) {
        for (int t = 0; t < CVOL_SMALL_OUTPUTS; t++)
            b->states.above[t][k] = fresh;
        b->states.agrees[k][0] = b->states.agrees[k][1] = fresh;
    }
    for (int i = 0; i < CVOL_SMALL_ESCAPES; i++)
        b->states.escape[i] = (cvol_probability){half, half};
}

/* ---- bits both ways --------------------------------------------------------------------- */

typedef struct stream {
    cvol_range_encoder *encoder; /* NULL: decoding */
    cvol_range_decoder decoder;
} stream;

/* A bit that is 1 with likelihood p / 2^16. */
CVOL_INLINE int code_share(stream *s, uint32_t p, int bit)
{
    const uint32_t zero = 65536 - p;
    if (s->encoder)
        cvol_encode_share(s->encoder, zero, bit);
    else
        bit = cvol_decode_share(&s->decoder, zero);
    return bit;
}

CVOL_INLINE int code_bit(stream *s, cvol_probability *p, int bit)
{
    if (s->encoder)
        cvol_encode_bit(s->encoder, p, bit);
    else
        bit = cvol_decode_bit(&s->decoder, p);
    return bit;
}

CVOL_INLINE uint32_t code_raw(stream *s, uint32_t value, int count)
{
    if (s->encoder)
        cvol_encode_raw(s->encoder, value, count);
    else
        value = cvol_decode_raw(&s->decoder, count);
    return value;
}

/* The low `count` < 32 bits of a value. */
CVOL_INLINE uint32_t code_low(stream *s, uint32_t value, int count)
{
    return code_raw(s, value & ((UINT32_C(1) << count) - 1), count);
}

static uint32_t code_token(stream *s, const cvol_token_tables *tables, int row, uint32_t token)
{
    const uint16_t *bounds = tables->rows[row].bounds;
    if (s->encoder) {
        cvol_encode_part(s->encoder, bounds[7 + token], bounds[8 + token]);
        return token;
    }
    return cvol_decode_part(&s->decoder, bounds);
}

/* A bit by a logit, corrected by what such logits came to so far. */
CVOL_INLINE int code_logit(stream *s, cvol_small_curve *c, int logit, int bit)
{
    const int at = logit + 2048, bucket = at >> BUCKET_BITS, share = at & ((1 << BUCKET_BITS) - 1);
    const uint32_t own = cvol_small_likelihood[at];
    const uint32_t seen = ((uint32_t)c->at[bucket] * (uint32_t)(128 - share) +
                           (uint32_t)c->at[bucket + 1] * (uint32_t)share) >>
                          7;
    uint32_t p = (own + 3 * seen) >> 2;
    p = p < 48 ? 48 : p > 65536 - 48 ? 65536 - 48 : p;
    bit = code_share(s, p, bit);
    uint16_t *near = &c->at[bucket + (share >= 64)];
    *near = (uint16_t)(*near + (((bit ? 65535 : 0) - (int)*near) >> 7));
    return bit;
}

/* ---- what stands before the coefficients ------------------------------------------------ */

static int split_token(uint16_t split)
{
    return split == CVOL_CELL_WHOLE     ? 0
           : split == CVOL_CELL_OCTANTS ? 1
           : split == CVOL_CELL_FOURS   ? 3
                                        : 2;
}

static int code_split(cvol_small_brick *b, stream *s, cvol_brick_context *context,
                      const size_t place[3])
{
    const int cell[3] = {(int)place[0], (int)place[1], (int)place[2]};
    uint16_t *split = &b->split[cell_number(place)];
    const uint32_t token = code_token(s, b->tables, cvol_split_row(context, cell),
                                      (uint32_t)split_token(*split));
    if (token > 3)
        return 0;
    if (!s->encoder)
        *split = token == 0 ? CVOL_CELL_WHOLE : token == 3 ? CVOL_CELL_FOURS : CVOL_CELL_OCTANTS;
    if (token == 2) {
        uint16_t all = CVOL_CELL_OCTANTS;
        for (int half = 0; half < 2; half++)
            all |= (uint16_t)(code_token(s, b->tables, CVOL_ROW_OCTANTS + half,
                                         *split >> (1 + 4 * half) & 15)
                              << (1 + 4 * half));
        *split = all;
    }
    cvol_split_note(context, cell, (int)token);
    return 1;
}

/* The parts of all cells, of which only the splits are known. */
static void list_parts(cvol_small_brick *b, const cvol_brick_context *context)
{
    for (size_t i = 0; i < cvol_brick_box_blocks(&b->box); i++) {
        size_t place[3];
        cvol_cell_part parts[CVOL_CELL_PARTS_MAX];
        cvol_brick_box_place(place, &b->box, i);
        const int count = cvol_cell_list_parts(parts, b->split[cell_number(place)]);
        for (int k = 0; k < count; k++) {
            int at[3];
            const int size_class = cvol_size_class(parts[k].side);
            cvol_part_place(at, &parts[k], place, CVOL_CELL);
            add_part(b, at, size_class, cvol_brick_scan(context, at, size_class));
        }
    }
}

/* A difference' size: a token, and raw bits. */
static uint32_t code_number(const cvol_small_brick *b, stream *s, int row, uint64_t number)
{
    const uint32_t token = code_token(s, b->tables, row, cvol_number_token(number));
    if (token < 4)
        return token;
    int length = (int)token - 1;
    if (token == 15)
        length = (int)code_raw(s, (uint32_t)(64 - __builtin_clzll(number | 1)), 5);
    length = length < 1 ? 1 : length;
    return UINT32_C(1) << (length - 1) | code_low(s, (uint32_t)number, length - 1);
}

/* A part's DC and the bit length of its last index. */
static int code_head(cvol_small_brick *b, stream *s, cvol_small_part *p,
                     cvol_brick_context *context)
{
    const int at[3] = {p->at[0], p->at[1], p->at[2]};
    if (!p->scan) {
        p->dc = cvol_part_note_unseen(context, at, p->size_class);
        b->known[p->first] = 2 * p->dc;
        return 1;
    }
    const cvol_part_context around = cvol_part_context_of(context, at, p->scan);
    const int64_t difference = p->dc - around.prediction;
    const uint32_t number = code_number(b, s, around.dc_row,
                                        (uint64_t)(difference < 0 ? -difference : difference));
    int64_t value = around.prediction;
    if (number) {
        value += code_raw(s, difference < 0, 1) ? -(int64_t)number : (int64_t)number;
    }
    const int64_t limit = CVOL_VALUE_LIMIT / 2;
    if (value < -limit || value > limit)
        return 0;
    p->dc = (int32_t)value;
    p->length = (uint8_t)code_token(s, b->tables, cvol_length_row(&around, p->size_class, number),
                                    p->length);
    if (p->length && 1 << (p->length - 1) > p->scan->index[p->scan->count - 1])
        return 0;
    p->around = (uint8_t)around.around;
    p->change = (uint8_t)cvol_small_class(number);
    p->finished = !p->length;
    b->known[p->first] = 2 * p->dc;
    cvol_part_note(context, at, p->scan, p->dc, p->length);
    return 1;
}

/* ---- coefficients ----------------------------------------------------------------------- */

/* The sign of a coefficient of this magnitude; 1: negative. */
static int code_sign(cvol_small_brick *b, stream *s, const cvol_small_part *p,
                     const cvol_small_look *l, uint32_t magnitude, int negative)
{
    int16_t x[CVOL_SMALL_INPUTS] __attribute__((aligned(64))), out[CVOL_SMALL_OUTPUTS];
    const int turned = l->sum < 0, lapped = b->array->lapped != 0;
    int beside = 0;
    for (int k = 0; k < CVOL_SMALL_PLANES; k++)
        beside |= p->beside[k] != CVOL_SMALL_NONE;
    if (!beside)
        return (int)code_raw(s, (uint32_t)negative, 1);
    cvol_small_look_for_sign(x, b, p, l, magnitude);
    WATCH(1, x, 0, (uint32_t)(negative == turned));
    b->evaluate(out, &cvol_small_of_signs, x, CVOL_SMALL_SIGN_INPUTS);
    const int agrees = code_logit(s, &b->states.agrees[p->size_class][lapped], out[0],
                                  negative == turned);
    return agrees ? turned : !turned;
}

/* The magnitude of an index; `least`: it is the part's last one, and not 0. */
static uint32_t code_size(cvol_small_brick *b, stream *s, const cvol_small_part *p,
                          const cvol_small_look *l, int least, uint32_t size)
{
    int16_t out[CVOL_SMALL_OUTPUTS];
    uint32_t high = size >> l->shift, t = least && !l->shift;
    WATCH(0, l->x, (int)t, high);
    b->evaluate(out, &cvol_small_of_magnitudes, l->x, CVOL_SMALL_INPUTS);
    while (t < CVOL_SMALL_OUTPUTS &&
           code_logit(s, &b->states.above[t][p->size_class], out[t], high > t))
        t++;
    if (t == CVOL_SMALL_OUTPUTS) {
        const uint32_t rest = high - (CVOL_SMALL_OUTPUTS - 1); /* at least 1 */
        const int length = s->encoder ? cvol_bit_length(rest) - 1 : 0;
        int bits = 0;
        while (bits < CVOL_SMALL_ESCAPES - 1 && code_bit(s, &b->states.escape[bits], bits < length))
            bits++;
        t += (UINT32_C(1) << bits | code_low(s, rest, bits)) - 1;
    }
    if (!l->shift)
        return t;
    const uint64_t all = (uint64_t)t << l->shift | code_low(s, size, l->shift);
    return all > UINT32_MAX ? UINT32_MAX : (uint32_t)all;
}

/* The last index, of those of its bit length. */
static uint32_t code_last(cvol_small_brick *b, stream *s, const cvol_small_part *p, uint32_t last)
{
    const int length = p->length, row = cvol_more_row(p->size_class, length);
    if (length == 1)
        return 1;
    if (length == 2)
        return 2 | (code_token(s, b->tables, row, last & 1) & 1);
    const uint32_t top = 4 | (code_token(s, b->tables, row, last >> (length - 3) & 3) & 3);
    return top << (length - 3) | code_low(s, last, length - 3);
}

/* One coefficient, as an index; 0 if it cannot be. */
static int code_value(cvol_small_brick *b, stream *s, cvol_small_part *p, cvol_small_view *view,
                      cvol_small_question *q)
{
    cvol_small_look l;
    const int32_t given = s->encoder ? b->values[p->values + q->index] : 0;
    const int is_last = q->index == q->last;
    cvol_small_look_at(&l, b, view, p, q);
    const uint32_t size = code_size(b, s, p, &l, is_last, cvol_magnitude(given));
    if (size > CVOL_VALUE_LIMIT / 2 || (is_last && !size))
        return 0;
    const uint32_t magnitude = cvol_dependent_magnitude(q->state, size);
    const int class = cvol_small_class(magnitude);
    q->state = cvol_state_after[q->state][size & 1];
    q->run += (16 * class - q->run) / 8;
    if (!size)
        return 1;
    const int negative = code_sign(b, s, p, &l, magnitude, given < 0);
    const int32_t value = negative ? -(int32_t)magnitude : (int32_t)magnitude;
    const int *at = l.at;
    const int local = CVOL_SMALL_ORIGIN + at[0] + CVOL_SMALL_PAD * (at[1] + CVOL_SMALL_PAD * at[2]);
    b->known[p->first + at[0] + CVOL_SMALL_SIDE * at[1] + CVOL_SMALL_SHEET * at[2]] = value;
    view->sizes[local] = (uint16_t)(magnitude < CVOL_SMALL_LIMIT ? magnitude : CVOL_SMALL_LIMIT);
    view->classes[local] = (uint8_t) class;
    cvol_small_take_off(view->level, view->slope, p->n, at, value, &cvol_small_cosines);
    return 1;
}

/* A part's coefficients of one shell; 0 if the stream says what cannot be. */
static int code_part(cvol_small_brick *b, stream *s, cvol_small_part *p, int shell)
{
    const cvol_scan *scan = p->scan;
    const int cube = p->side >> (CVOL_SHELLS - 1 - shell);
    int end = scan->shell_end[shell];
    cvol_small_question q = {shell, p->next, scan->count, p->state, 0};
    if (end <= p->next)
        return 1;
    if (1 << (p->length - 1) < cvol_shell_end(p->size_class, shell)) {
        q.last = scan->compact[code_last(b, s, p, s->encoder ? scan->index[p->used - 1] : 0)];
        if (q.last == CVOL_SCAN_NONE || q.last < p->next)
            return 0;
        end = q.last + 1;
    }
    cvol_small_view view;
    cvol_small_view_part(&view, b, p, cube > 2 ? cube / 2 : 1);
    for (; q.index < end; q.index++)
        if (!code_value(b, s, p, &view, &q))
            return 0;
    p->next = end;
    p->state = q.state;
    p->finished = end == q.last + 1;
    cvol_small_show(b, p, cube);
    return 1;
}

/* ---- bricks ----------------------------------------------------------------------------- */

static int code_shell(cvol_small_brick *b, stream *s, cvol_brick_context *context, int shell)
{
    if (!shell) {
        for (size_t i = 0; i < cvol_brick_box_blocks(&b->box); i++) {
            size_t place[3];
            cvol_brick_box_place(place, &b->box, i);
            if (!code_split(b, s, context, place))
                return 0;
        }
        if (!s->encoder)
            list_parts(b, context);
        cvol_small_find_neighbours(b);
        for (int i = 0; i < b->parts; i++) {
            if (!code_head(b, s, &b->part[i], context))
                return 0;
            if (b->part[i].scan)
                cvol_small_show(b, &b->part[i], 1);
        }
    }
    for (int i = 0; i < b->parts; i++)
        if (b->part[i].scan && !b->part[i].finished && !code_part(b, s, &b->part[i], shell))
            return 0;
    return 1;
}

int cvol_small_finish(cvol_small_brick *b, cvol_bytes shells[CVOL_SHELLS],
                      cvol_brick_context *context)
{
    stream s = {.encoder = &b->encoder};
    start_coding(b);
    for (int shell = 0; shell < CVOL_SHELLS; shell++) {
        cvol_range_encoder_start(&b->encoder);
        shells[shell].size = 0;
        if (!code_shell(b, &s, context, shell))
            return 0;
        if (b->encoder.range == UINT64_MAX && !b->encoder.raw_count)
            continue; /* nothing was coded */
        if (!cvol_range_encoder_finish(&b->encoder, &shells[shell]))
            return 0;
    }
    return 1;
}

int cvol_small_decode(cvol_small_brick *b, cvol_brick_context *context,
                      const cvol_span shells[CVOL_SHELLS], int count)
{
    stream s = {.encoder = NULL};
    start_coding(b);
    for (int shell = 0; shell < count; shell++) {
        cvol_range_decoder_start(&s.decoder, shells[shell].data, shells[shell].size);
        if (!code_shell(b, &s, context, shell))
            return CVOL_ERROR_CORRUPT;
        const int nothing = s.decoder.range == UINT64_MAX && !s.decoder.raw_read;
        if (nothing ? shells[shell].size > 0 : cvol_range_decoder_overrun(&s.decoder))
            return CVOL_ERROR_CORRUPT;
    }
    return CVOL_OK;
}

uint16_t cvol_small_cell(const cvol_small_brick *b, const size_t place[3],
                         int32_t values[CVOL_CELL_SAMPLES], uint64_t found[CVOL_CELL_SAMPLES / 64])
{
    const uint16_t split = b->split[cell_number(place)];
    cvol_cell_part parts[CVOL_CELL_PARTS_MAX];
    const int count = cvol_cell_list_parts(parts, split);
    for (int k = 0; k < count; k++) {
        const int M = parts[k].side, apart = CVOL_CELL / M;
        const int32_t *known = b->known +
                               CVOL_CELL * (place[0] + CVOL_SMALL_SIDE * place[1] +
                                            CVOL_SMALL_SHEET * place[2]) +
                               parts[k].begin[0] + CVOL_SMALL_SIDE * parts[k].begin[1] +
                               CVOL_SMALL_SHEET * parts[k].begin[2];
        const int first = parts[k].first[0] +
                          CVOL_CELL * (parts[k].first[1] + CVOL_CELL * parts[k].first[2]);
        for (int w = 0; w < M; w++)
            for (int v = 0; v < M; v++)
                for (int u = 0; u < M; u++) {
                    const int32_t value = known[u + CVOL_SMALL_SIDE * v + CVOL_SMALL_SHEET * w];
                    const int to = first + apart * (u + CVOL_CELL * (v + CVOL_CELL * w));
                    values[to] = value;
                    if (value)
                        found[to / 64] |= UINT64_C(1) << to % 64;
                }
    }
    return split;
}
