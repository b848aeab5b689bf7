/* Encodes and decodes one sub-block. */
#include "codec/quantize/sub_block_code.h"

#include <stdlib.h>

#include "codec/quantize/quantize.h"
#include "codec/quantize/trellis_states.h"

const uint8_t cvol_level_shift[CVOL_LEVELS] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                               0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8};
const uint8_t cvol_fine_level_shift[CVOL_FINE_LEVELS] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                                         0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 8};

/* Scattered sums reach two places beyond a subband's cube. */
static int cube_side(int index)
{
    int side = 1;
    while (side * side * side < index)
        side *= 2;
    return side;
}

/* ---- encoding --------------------------------------------------------------------------- */

static void put_number(cvol_token_writer *out, int row, uint64_t number)
{
    const uint32_t token = cvol_number_token(number);
    cvol_token_put(out, row, token);
    if (token < 4)
        return;
    const int length = cvol_bit_length((uint32_t)number);
    if (token == 15)
        cvol_raw_put(out, (uint32_t)length, 5);
    cvol_raw_put(out, (uint32_t)number & ((UINT32_C(1) << (length - 1)) - 1), length - 1);
}

static void put_magnitude(cvol_token_writer *out, cvol_place_code code, uint32_t magnitude)
{
    const uint32_t high = magnitude >> code.shift;
    cvol_token_put(out, code.row, high < 15 ? high : 15);
    if (high >= 15) {
        const uint32_t rest = high - 14;
        const int bits = cvol_bit_length(rest) - 1;
        cvol_token_put(out, code.escape_row, bits < 15 ? (uint32_t)bits : 15);
        if (bits >= 15)
            cvol_raw_put(out, (uint32_t)bits - 15, 4);
        cvol_raw_put(out, rest & ((UINT32_C(1) << bits) - 1), bits);
    }
    cvol_raw_put(out, magnitude & ((UINT32_C(1) << code.shift) - 1), code.shift);
}

static void put_last(cvol_token_writer *out, int size_class, uint32_t last)
{
    const int length = cvol_bit_length(last);
    const int row = cvol_more_row(size_class, length);
    if (length == 2) {
        cvol_token_put(out, row, last & 1);
    } else if (length > 2) {
        cvol_token_put(out, row, last >> (length - 3) & 3);
        cvol_raw_put(out, last & ((UINT32_C(1) << (length - 3)) - 1), length - 3);
    }
}

/* Codes coefficients begin .. end - 1; `last` is the sub-block's last index. Returns the state
 * after them. */
static int put_values(cvol_token_writer *out, const cvol_scan *scan, const int32_t *indices,
                      int begin, int end, int last, int trellis, int state, uint16_t *scatter)
{
    for (int i = begin; i < end; i++) {
        const cvol_scan_entry *entry = &scan->entries[i];
        const uint32_t magnitude = cvol_magnitude(indices[i]), sum = scatter[entry->scatter];
        const int odd = cvol_state_is_odd(state), size_class = scan->size_class;
        if (i == last)
            put_magnitude(out, cvol_last_code(size_class, sum, trellis, odd), magnitude - 1);
        else
            put_magnitude(out, cvol_value_code(size_class, entry->band, sum, trellis, odd),
                          magnitude);
        const uint32_t value = trellis ? cvol_trellis_magnitude(state, magnitude) : magnitude;
        state = trellis ? cvol_state_after[state][magnitude & 1] : 0;
        if (!magnitude)
            continue;
        cvol_raw_put(out, indices[i] < 0, 1);
        cvol_scatter(scatter + entry->scatter, scan->row, scan->sheet, value);
    }
    return state;
}

void cvol_sub_block_encode(cvol_token_writer streams[CVOL_SUBBANDS], const cvol_scan *scan,
                           const cvol_sub_block_context *context, const int32_t *indices, int used,
                           int trellis, uint16_t *scatter)
{
    const int size_class = scan->size_class;
    const int64_t difference = indices[0] - context->prediction;
    const uint64_t number = (uint64_t)(difference < 0 ? -difference : difference);
    const int last = used - 1, last_index = scan->index[last];
    put_number(&streams[0], context->dc_row, number);
    if (number)
        cvol_raw_put(&streams[0], difference < 0, 1);
    cvol_token_put(&streams[0], cvol_length_row(context, size_class, number),
                   last ? (uint32_t)cvol_bit_length((uint32_t)last_index) : 0);
    if (!last)
        return;
    cvol_scatter_dc(scatter, scan->row, scan->sheet, indices[0]);
    int begin = 1, state = 0;
    for (int s = 0; s < CVOL_SUBBANDS && begin <= last; s++) {
        const int subband_end = scan->subband_end[s];
        if (subband_end <= begin)
            continue;
        const int end = last < subband_end ? last + 1 : subband_end;
        if (last < subband_end)
            put_last(&streams[s], size_class, (uint32_t)last_index);
        state = put_values(&streams[s], scan, indices, begin, end, last, trellis, state, scatter);
        begin = end;
    }
    cvol_scatter_clear(scatter, scan->row, scan->sheet, cube_side(last_index + 1));
}

/* ---- decoding --------------------------------------------------------------------------- */

/* Reads a number of at most 31 bits. */
CVOL_INLINE uint32_t take_number(cvol_token_reader *in, int row)
{
    const uint32_t token = cvol_token_take(in, row);
    if (token < 4)
        return token;
    int length = (int)token - 1;
    if (token == 15) {
        length = (int)cvol_raw_take(in, 5);
        length = length < 1 ? 1 : length;
    }
    return UINT32_C(1) << (length - 1) | cvol_raw_take(in, length - 1);
}

static uint32_t take_escape(cvol_token_reader *in, int row)
{
    int bits = (int)cvol_token_take(in, row);
    if (bits == 15)
        bits += (int)cvol_raw_take(in, 4);
    return (UINT32_C(1) << bits) + cvol_raw_take(in, bits) + 14;
}

CVOL_INLINE uint32_t take_magnitude(cvol_token_reader *in, cvol_place_code code)
{
    uint32_t high = cvol_token_take(in, code.row);
    if (__builtin_expect(high == 15, 0))
        high = take_escape(in, code.escape_row);
    if (__builtin_expect(!code.shift, 1))
        return high;
    const uint64_t magnitude = (uint64_t)high << code.shift | cvol_raw_take(in, code.shift);
    return magnitude > UINT32_MAX ? UINT32_MAX : (uint32_t)magnitude;
}

static uint32_t take_last(cvol_token_reader *in, int size_class, int length)
{
    const int row = cvol_more_row(size_class, length);
    if (length == 1)
        return 1;
    if (length == 2)
        return 2 | (cvol_token_take(in, row) & 1);
    const uint32_t top = 4 | (cvol_token_take(in, row) & 3);
    return top << (length - 3) | cvol_raw_take(in, length - 3);
}

/* Reads coefficients begin .. end - 1; returns 0 if one is too large. */
CVOL_INLINE int take_values(cvol_token_reader *stream, const cvol_scan *scan, int begin, int end,
                            int last, const cvol_sub_block_target *target, int trellis, int *state,
                            uint16_t *scatter)
{
    cvol_token_reader in = *stream;
    int now = *state;
    for (int i = begin; i < end; i++) {
        const cvol_scan_entry entry = scan->entries[i];
        const uint32_t sum = scatter[entry.scatter];
        const int odd = trellis ? cvol_state_is_odd(now) : 0, size_class = scan->size_class;
        uint32_t magnitude;
        if (__builtin_expect(i == last, 0))
            magnitude = 1 + take_magnitude(&in, cvol_last_code(size_class, sum, trellis, odd));
        else
            magnitude = take_magnitude(&in,
                                       cvol_value_code(size_class, entry.band, sum, trellis, odd));
        if (trellis)
            now = cvol_state_after[now][magnitude & 1];
        if (!magnitude)
            continue;
        if (__builtin_expect(magnitude > (uint32_t)CVOL_VALUE_LIMIT >> trellis, 0))
            return 0;
        if (trellis)
            magnitude = 2 * magnitude - (uint32_t)odd;
        cvol_scatter(scatter + entry.scatter, scan->row, scan->sheet, magnitude);
        const int32_t value = cvol_raw_take(&in, 1) ? -(int32_t)magnitude : (int32_t)magnitude;
        const int place = target->first + (target->in_cell ? entry.in_cell : entry.place);
        target->values[place] = value;
        target->found[place / 64] |= UINT64_C(1) << place % 64;
    }
    *stream = in;
    *state = now;
    return 1;
}

/* Reads the coefficients after the DC of the available subbands. */
static int take_subbands(cvol_token_reader streams[CVOL_SUBBANDS], int subbands,
                         const cvol_scan *scan, int length, const cvol_sub_block_target *target,
                         uint16_t *scatter)
{
    int begin = 1, state = 0;
    for (int s = 0; s < subbands; s++) {
        int end = scan->subband_end[s], last = scan->count;
        if (end <= begin)
            continue;
        if (1 << (length - 1) < cvol_subband_end(scan->size_class, s)) {
            last = scan->compact[take_last(&streams[s], scan->size_class, length)];
            if (last == CVOL_SCAN_NONE)
                return 0;
            end = last + 1;
        }
        if (!(target->trellis
                  ? take_values(&streams[s], scan, begin, end, last, target, 1, &state, scatter)
                  : take_values(&streams[s], scan, begin, end, last, target, 0, &state, scatter)))
            return 0;
        begin = end;
        if (last < scan->count)
            break;
    }
    cvol_scatter_clear(scatter, scan->row, scan->sheet, cube_side(scan->index[begin - 1] + 1));
    return 1;
}

int cvol_sub_block_decode(cvol_token_reader streams[CVOL_SUBBANDS], int subbands,
                          const cvol_scan *scan, const cvol_sub_block_context *context,
                          const cvol_sub_block_target *target, int32_t *dc, int *length,
                          uint16_t *scatter)
{
    const int size_class = scan->size_class;
    const uint32_t number = take_number(&streams[0], context->dc_row);
    int64_t value = context->prediction;
    if (number)
        value += cvol_raw_take(&streams[0], 1) ? -(int64_t)number : (int64_t)number;
    const int64_t limit = CVOL_VALUE_LIMIT >> target->trellis;
    if (value < -limit || value > limit)
        return 0;
    *dc = (int32_t)value;
    target->values[target->first] = *dc * (1 + target->trellis);
    if (*dc)
        target->found[target->first / 64] |= UINT64_C(1) << target->first % 64;
    *length = (int)cvol_token_take(&streams[0], cvol_length_row(context, size_class, number));
    if (!*length)
        return 1;
    if (1 << (*length - 1) > scan->index[scan->count - 1])
        return 0;
    cvol_scatter_dc(scatter, scan->row, scan->sheet, *dc);
    return take_subbands(streams, subbands, scan, *length, target, scatter);
}
