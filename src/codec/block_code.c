/* Coding of one block. Encoder and decoder are one description: each step is written once, as a
 * function that either writes the value it is given or reads and returns it. The compiler makes two
 * programs of it, since `decoding` is known wherever the steps are inlined. */
#include "codec/block_code.h"

#include <string.h>

#include "array/array.h"
#include "codec/block_contexts.h"
#include "codec/quantise.h"

/* Either end of the line. The decoder is a copy, so that it can live in registers. */
typedef struct coding {
    cvol_range_encoder *out;
    cvol_range_decoder in;
} coding;

CVOL_INLINE int code_bit(const int decoding, coding *c, cvol_probability *p, int bit)
{
    if (decoding)
        return cvol_decode_bit(&c->in, p);
    cvol_encode_bit(c->out, p, bit);
    return bit;
}

CVOL_INLINE uint32_t code_raw(const int decoding, coding *c, uint32_t value, int count)
{
    if (decoding)
        return cvol_decode_raw(&c->in, count);
    cvol_encode_raw(c->out, value, count);
    return value;
}

/* value + 1 = 1xyyyy: the number of bits behind the 1 in unary, x modelled, y raw. */
CVOL_INLINE uint32_t code_rest(const int decoding, coding *c, cvol_probability *prefix,
                               cvol_probability *second, uint32_t value)
{
    int bits = decoding ? 31 : cvol_bit_length(value + 1) - 1, n = 0;
    for (; n < bits; n++)
        if (!code_bit(decoding, c, &prefix[n < CVOL_PREFIXES ? n : CVOL_PREFIXES - 1], 1))
            break;
    if (!decoding && n < 31)
        code_bit(0, c, &prefix[n < CVOL_PREFIXES ? n : CVOL_PREFIXES - 1], 0);
    if (n == 0)
        return 0;
    uint32_t number = decoding ? 1 : value + 1;
    cvol_probability *p = &second[n < CVOL_PREFIXES ? n : CVOL_PREFIXES - 1];
    int x = code_bit(decoding, c, p, (int)(number >> (n - 1) & 1));
    uint32_t y = code_raw(decoding, c, number & ((UINT32_C(1) << (n - 1)) - 1), n - 1);
    return ((2u | (uint32_t)x) << (n - 1) | y) - 1;
}

/* The index of the last non-zero coefficient, 1 .. B^3 - 1: its bit length - 1 as a tree of four
 * bits, the two bits behind its leading 1 modelled, the others raw. */
CVOL_INLINE uint32_t code_last(const int decoding, coding *c, cvol_block_model *model, int context,
                               uint32_t last)
{
    int length = decoding ? 0 : cvol_bit_length(last), node = 1;
    for (int k = 3; k >= 0; k--)
        node = 2 * node +
               code_bit(decoding, c, &model->last_bits[context][node], (length - 1) >> k & 1);
    length = (node & 15) + 1;
    uint32_t value = 1;
    for (int k = 0; k < 2 && k < length - 1; k++) {
        cvol_probability *p = &model->last_more[length - 1][k == 0 ? 0 : 1 + (value & 1)];
        value = 2 * value + (uint32_t)code_bit(decoding, c, p, (int)(last >> (length - 2 - k) & 1));
    }
    if (length > 3) {
        int rest = length - 3;
        value = value << rest | code_raw(decoding, c, last & ((UINT32_C(1) << rest) - 1), rest);
    }
    return value;
}

/* A DC difference; at most 2^31 in magnitude. */
CVOL_INLINE int64_t code_dc(const int decoding, coding *c, cvol_block_model *model,
                            const cvol_block_context *context, int64_t difference)
{
    if (!code_bit(decoding, c, &model->dc_zero[context->any], difference != 0))
        return 0;
    uint32_t rest = decoding ? 0 : (uint32_t)(difference < 0 ? -difference : difference) - 1;
    rest = code_rest(decoding, c, model->dc_rest[context->dc], model->dc_second, rest);
    int negative = (int)code_raw(decoding, c, difference < 0, 1);
    return negative ? -(int64_t)rest - 1 : (int64_t)rest + 1;
}

/* A coefficient's magnitude; `certain`: it is known not to be zero. */
CVOL_INLINE uint32_t code_magnitude(const int decoding, coding *c, cvol_block_model *model,
                                    int band, int level, int certain, uint32_t magnitude)
{
    if (!certain && !code_bit(decoding, c, &model->zero[band][level], magnitude > 0))
        return 0;
    if (!code_bit(decoding, c, &model->one[band][level], magnitude > 1))
        return 1;
    if (!code_bit(decoding, c, &model->two[band % 3][level], magnitude > 2))
        return 2;
    return 3 + code_rest(decoding, c, model->rest[level], model->rest_second, magnitude - 3);
}

void cvol_block_coder_start(cvol_block_coder *coder, int block, const size_t count[3])
{
    coder->scan = cvol_scan_of(block);
    memcpy(coder->count, count, sizeof coder->count);
    cvol_block_model_start(&coder->model, block);
    memset(coder->scatter, 0, sizeof coder->scatter);
    memset(coder->values, 0, sizeof coder->values);
    memset(coder->found, 0, sizeof coder->found);
}

cvol_block_context cvol_block_context_of(const cvol_block_coder *coder, size_t index)
{
    const size_t place[3] = {index % coder->count[0], index / coder->count[0] % coder->count[1],
                             index / coder->count[0] / coder->count[1]};
    size_t stride = 1;
    int64_t sum = 0;
    int available = 0, with_terms = 0, length_sum = 0;
    for (int a = 0; a < 3; a++) {
        if (place[a] > 0) {
            size_t neighbour = index - stride;
            available++;
            sum += coder->dc[neighbour];
            length_sum += coder->last_length[neighbour];
            with_terms += coder->last_length[neighbour] > 0;
        }
        stride *= coder->count[a];
    }
    if (!available)
        return (cvol_block_context){0};
    return (cvol_block_context){.any = 4 * available + with_terms,
                                .dc = with_terms == 0          ? 1
                                      : with_terms < available ? 2
                                                               : 3,
                                .last = 1 + (length_sum + available / 2) / available,
                                .prediction = sum / available};
}

void cvol_block_encode(cvol_block_coder *coder, cvol_range_encoder *stream, size_t index,
                       const int32_t *values, int used)
{
    const cvol_block_context context = cvol_block_context_of(coder, index);
    const int row = coder->scan->block + 2, sheet = row * row;
    cvol_block_model *model = &coder->model;
    coding c = {.out = stream};
    while (used > 1 && values[used - 1] == 0)
        used--;
    const int last = used - 1;
    coder->dc[index] = values[0];
    coder->last_length[index] = (uint8_t)(last ? cvol_bit_length((uint32_t)last) : 0);
    code_dc(0, &c, model, &context, values[0] - context.prediction);
    if (!code_bit(0, &c, &model->any[context.any], last > 0))
        return;
    code_last(0, &c, model, context.last, (uint32_t)last);
    cvol_scatter_dc(coder->scatter, row, sheet, values[0]);
    for (int i = 1; i <= last; i++) {
        const cvol_scan_entry *entry = &coder->scan->entries[i];
        uint32_t magnitude = cvol_magnitude(values[i]);
        int level = cvol_level_of(coder->scan->level, coder->scatter[entry->scatter]);
        code_magnitude(0, &c, model, entry->band, level, i == last, magnitude);
        if (!magnitude)
            continue;
        code_raw(0, &c, values[i] < 0, 1);
        cvol_scatter(coder->scatter + entry->scatter, row, sheet, magnitude);
    }
    memset(coder->scatter, 0, sizeof(uint16_t) * (size_t)(sheet * row));
}

/* Decodes coefficients 1 .. last; 0 if one is too large. */
CVOL_INLINE int decode_coefficients(cvol_block_coder *coder, coding *c, int last)
{
    const int row = coder->scan->block + 2, sheet = row * row;
    const cvol_scan_entry *entries = coder->scan->entries;
    const uint8_t *level_table = coder->scan->level;
    for (int i = 1; i <= last; i++) {
        int level = cvol_level_of(level_table, coder->scatter[entries[i].scatter]);
        uint32_t magnitude = code_magnitude(1, c, &coder->model, entries[i].band, level, i == last,
                                            0);
        if (!magnitude)
            continue;
        if (__builtin_expect(magnitude > (uint32_t)CVOL_VALUE_LIMIT, 0))
            return 0;
        int32_t value = code_raw(1, c, 0, 1) ? -(int32_t)magnitude : (int32_t)magnitude;
        uint32_t place = entries[i].place;
        coder->values[place] = value;
        coder->found[place / 64] |= UINT64_C(1) << place % 64;
        cvol_scatter(coder->scatter + entries[i].scatter, row, sheet, magnitude);
    }
    memset(coder->scatter, 0, sizeof(uint16_t) * (size_t)(sheet * row));
    return 1;
}

/* Writes the found values as terms in order of place, and clears them. */
static cvol_decoded_block take_terms(cvol_block_coder *coder, uint32_t *words)
{
    const int place_bits = cvol_place_bits(coder->scan->block_log2);
    cvol_decoded_block out = {0};
    for (int i = 0; i < coder->scan->count / 64; i++) {
        for (uint64_t bits = coder->found[i]; bits; bits &= bits - 1) {
            uint32_t place = (uint32_t)(64 * i + __builtin_ctzll(bits));
            int32_t value = coder->values[place];
            out.words += cvol_term_pack(words + out.words, place, value, place_bits);
            out.sum += cvol_magnitude(value);
            out.terms++;
            coder->values[place] = 0;
        }
        coder->found[i] = 0;
    }
    return out;
}

int cvol_block_decode(cvol_block_coder *coder, cvol_range_decoder *stream, size_t index,
                      uint32_t *words, cvol_decoded_block *out)
{
    const cvol_block_context context = cvol_block_context_of(coder, index);
    cvol_block_model *model = &coder->model;
    coding c = {.in = *stream};
    int64_t dc = context.prediction + code_dc(1, &c, model, &context, 0);
    if (dc < -CVOL_VALUE_LIMIT || dc > CVOL_VALUE_LIMIT)
        return 0;
    coder->dc[index] = (int32_t)dc;
    coder->values[0] = (int32_t)dc;
    coder->found[0] |= dc != 0;
    uint32_t last = 0;
    if (code_bit(1, &c, &model->any[context.any], 0)) {
        last = code_last(1, &c, model, context.last, 0);
        if (last >= (uint32_t)coder->scan->count)
            return 0;
        const int row = coder->scan->block + 2;
        cvol_scatter_dc(coder->scatter, row, row * row, (int32_t)dc);
        if (!decode_coefficients(coder, &c, (int)last))
            return 0;
    }
    coder->last_length[index] = (uint8_t)(last ? cvol_bit_length(last) : 0);
    *stream = c.in;
    *out = take_terms(coder, words);
    return 1;
}
