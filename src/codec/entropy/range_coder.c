/* Range coder: starts, ends, carries and the last bytes. */
#include "codec/entropy/range_coder.h"

#include <stdlib.h>
#include <string.h>

/* ---- encoder ---------------------------------------------------------------------------- */

void cvol_range_encoder_start(cvol_range_encoder *coder)
{
    coder->low = 0;
    coder->range = UINT64_MAX;
    coder->raw_bits = 0;
    coder->raw_count = 0;
    coder->coded.size = 0;
    coder->raw.size = 0;
}

void cvol_range_encoder_free(cvol_range_encoder *coder)
{
    cvol_bytes_free(&coder->coded);
    cvol_bytes_free(&coder->raw);
}

void cvol_range_carry(cvol_bytes *coded)
{
    /* low + range never exceeds 1 before a carry, so some byte is below 255. */
    for (size_t i = coded->size; i > 0; i--)
        if (++coded->data[i - 1] != 0)
            return;
}

static void put_top_bytes(cvol_bytes *coded, uint64_t value, int count)
{
    uint8_t bytes[8];
    for (int i = 0; i < count; i++)
        bytes[i] = (uint8_t)(value >> (56 - 8 * i));
    cvol_bytes_append(coded, bytes, (size_t)count);
}

void cvol_range_emit(cvol_range_encoder *coder)
{
    put_top_bytes(&coder->coded, coder->low, 4);
    coder->low <<= 32;
    coder->range <<= 32;
}

/* Writes the fewest bytes that denote a value within low .. low + range - 1 for any
 * continuation. */
static void flush(cvol_range_encoder *coder)
{
    for (int count = 1; count <= 8; count++) {
        uint64_t rest = count == 8 ? 0 : UINT64_MAX >> 8 * count;
        uint64_t value = coder->low + rest;
        int carry = value < coder->low;
        value &= ~rest;
        /* value >= low because it is rounded up; the largest continuation is value + rest. */
        if (value - coder->low + rest > coder->range - 1)
            continue;
        if (carry)
            cvol_range_carry(&coder->coded);
        put_top_bytes(&coder->coded, value, count);
        return;
    }
}

int cvol_range_encoder_finish(cvol_range_encoder *coder, cvol_bytes *out)
{
    flush(coder);
    while (coder->raw_count > 0) {
        cvol_bytes_put_u8(&coder->raw, (uint8_t)coder->raw_bits);
        coder->raw_bits >>= 8;
        coder->raw_count -= 8;
    }
    cvol_bytes_append(out, coder->coded.data, coder->coded.size);
    if (cvol_bytes_reserve(out, coder->raw.size))
        for (size_t i = coder->raw.size; i > 0; i--)
            out->data[out->size++] = coder->raw.data[i - 1];
    return !(out->failed || coder->coded.failed || coder->raw.failed);
}

void cvol_encode_raw(cvol_range_encoder *coder, uint32_t value, int count)
{
    coder->raw_bits |= (value & ((UINT64_C(1) << count) - 1)) << coder->raw_count;
    coder->raw_count += count;
    if (coder->raw_count >= 32) {
        uint8_t bytes[4];
        for (int i = 0; i < 4; i++)
            bytes[i] = (uint8_t)(coder->raw_bits >> 8 * i);
        cvol_bytes_append(&coder->raw, bytes, 4);
        coder->raw_bits >>= 32;
        coder->raw_count -= 32;
    }
}

/* ---- decoder ---------------------------------------------------------------------------- */

uint32_t cvol_range_take_last(const uint8_t *data, size_t size, size_t at)
{
    uint32_t next = 0;
    for (size_t i = at; i < at + 4; i++)
        next = next << 8 | (i < size ? data[i] : 0u);
    return next;
}

uint32_t cvol_raw_take_last(const uint8_t *data, size_t size, size_t at)
{
    uint32_t next = 0;
    for (size_t i = 0; i < 4; i++)
        if (at + i < size)
            next |= (uint32_t)data[size - 1 - at - i] << 8 * i;
    return next;
}

void cvol_range_decoder_start(cvol_range_decoder *coder, const uint8_t *data, size_t size)
{
    memset(coder, 0, sizeof *coder);
    coder->data = data;
    coder->size = size;
    coder->range = UINT64_MAX;
    coder->code = (uint64_t)cvol_range_take_last(data, size, 0) << 32;
    coder->code |= cvol_range_take_last(data, size, 4);
    coder->coded_read = 8;
}

int cvol_range_decoder_overrun(const cvol_range_decoder *coder)
{
    /* The encoder has written at least one of the last eight bytes that were read ahead. */
    size_t coded = coder->coded_read - 7;
    size_t raw = coder->raw_read - (size_t)coder->raw_count / 8;
    return coded + raw > coder->size;
}
