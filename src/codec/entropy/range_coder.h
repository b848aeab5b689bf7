/* Adaptive binary range coder (Martin 1979; carry propagation as in Schindler's coder).
 *
 * The state is an interval [low, low + range) of 64-bit fractions. A bit with probability p / 2^16
 * of being 0 splits it at bound = floor(range / 2^16) p: 0 keeps the lower part, 1 the upper.
 * Whenever range falls below 2^32, the coder emits the upper 32 bits of low as four bytes, high
 * first.
 *
 * Probabilities adapt at two speeds (1/16 and 1/128 of the way per bit); p is their mean. They stay
 * at least 71 from either end, so that range / 2^16 >= 2^16 leaves room for both parts.
 *
 * Bits that are nearly random (signs, low bits) go uncoded into a second stream, which follows the
 * first in reverse: the decoder reads it from the last byte backwards. So the coder stores no
 * length. */
#ifndef CVOL_CODEC_ENTROPY_RANGE_CODER_H
#define CVOL_CODEC_ENTROPY_RANGE_CODER_H

#include <stddef.h>
#include <stdint.h>

#include "base/bytes.h"
#include "base/vector.h"

#define CVOL_RATE_FAST 4
#define CVOL_RATE_SLOW 7

/* The probability of a 0 bit in units of 2^-16, tracked at two speeds. */
typedef struct cvol_probability {
    uint16_t fast, slow;
} cvol_probability;

CVOL_INLINE uint32_t cvol_probability_of_zero(const cvol_probability *p)
{
    return ((uint32_t)p->fast + p->slow) >> 1;
}

CVOL_INLINE void cvol_probability_update(cvol_probability *p, int bit)
{
    if (bit) {
        p->fast = (uint16_t)(p->fast - (p->fast >> CVOL_RATE_FAST));
        p->slow = (uint16_t)(p->slow - (p->slow >> CVOL_RATE_SLOW));
    } else {
        p->fast = (uint16_t)(p->fast + ((65535 - p->fast) >> CVOL_RATE_FAST));
        p->slow = (uint16_t)(p->slow + ((65535 - p->slow) >> CVOL_RATE_SLOW));
    }
}

/* ---- encoder ---------------------------------------------------------------------------- */

typedef struct cvol_range_encoder {
    uint64_t low, range;
    uint64_t raw_bits;
    int raw_count;
    cvol_bytes coded, raw;
} cvol_range_encoder;

/* Starts anew; keeps the buffers of an earlier use (the first use: a zeroed struct). */
void cvol_range_encoder_start(cvol_range_encoder *coder);
/* Ends both streams and appends them to `out`. 1 on success, 0 when memory ran out. */
int cvol_range_encoder_finish(cvol_range_encoder *coder, cvol_bytes *out);
void cvol_range_encoder_free(cvol_range_encoder *coder);

/* Adds 1 to the bytes written so far, taken as one number. */
void cvol_range_carry(cvol_bytes *coded);
/* Emits the upper 32 bits of low. */
void cvol_range_emit(cvol_range_encoder *coder);

static inline void cvol_encode_bit(cvol_range_encoder *coder, cvol_probability *p, int bit)
{
    uint64_t bound = (coder->range >> 16) * cvol_probability_of_zero(p);
    if (bit) {
        uint64_t low = coder->low;
        coder->low += bound;
        coder->range -= bound;
        if (coder->low < low)
            cvol_range_carry(&coder->coded);
    } else {
        coder->range = bound;
    }
    cvol_probability_update(p, bit);
    if (coder->range < UINT64_C(1) << 32)
        cvol_range_emit(coder);
}

/* Codes a bit with probability zero / 2^16 of being 0, 0 < zero < 2^16. */
CVOL_INLINE void cvol_encode_probable(cvol_range_encoder *coder, uint32_t zero, int bit)
{
    const uint64_t bound = (coder->range >> 16) * zero, low = coder->low;
    coder->low += bit ? bound : 0;
    coder->range = bit ? coder->range - bound : bound;
    if (coder->low < low)
        cvol_range_carry(&coder->coded);
    if (coder->range < UINT64_C(1) << 32)
        cvol_range_emit(coder);
}
/* Codes a symbol with the numbers begin .. end - 1 of 0 .. 2^14 - 1. */
CVOL_INLINE void cvol_encode_part(cvol_range_encoder *coder, uint32_t begin, uint32_t end)
{
    const uint64_t unit = coder->range >> 14, low = coder->low;
    coder->low += unit * begin;
    coder->range = unit * (end - begin);
    if (coder->low < low)
        cvol_range_carry(&coder->coded);
    if (coder->range < UINT64_C(1) << 32)
        cvol_range_emit(coder);
}

/* Writes the low `count` <= 32 bits of value, uncoded. */
void cvol_encode_raw(cvol_range_encoder *coder, uint32_t value, int count);

/* ---- decoder ---------------------------------------------------------------------------- */

/* Reads data[0 .. size) from both ends; every byte beyond it is 0. */
typedef struct cvol_range_decoder {
    uint64_t code, range;
    uint64_t raw_bits;
    int raw_count;
    const uint8_t *data;
    size_t size;
    size_t coded_read, raw_read; /* bytes taken from the front and from the back */
} cvol_range_decoder;

void cvol_range_decoder_start(cvol_range_decoder *coder, const uint8_t *data, size_t size);
/* Returns 1 if more was decoded than the bytes can hold: the result is then invalid. */
int cvol_range_decoder_overrun(const cvol_range_decoder *coder);

/* Read four bytes at `at`, of the coded stream and of the raw one (from the end), if some of them
 * lie beyond the data. Arguments are values, so that a decoder can stay in registers. */
uint32_t cvol_range_take_last(const uint8_t *data, size_t size, size_t at);
uint32_t cvol_raw_take_last(const uint8_t *data, size_t size, size_t at);

CVOL_INLINE uint32_t cvol_big_endian32(const uint8_t *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/* The same as cvol_probability_update, without a branch. */
CVOL_INLINE void cvol_probability_pull(cvol_probability *p, uint32_t bit)
{
    const uint32_t flip = (bit - 1) & 65535; /* as for a bit of 1 */
    const uint32_t fast = p->fast ^ flip, slow = p->slow ^ flip;
    p->fast = (uint16_t)((fast - (fast >> CVOL_RATE_FAST)) ^ flip);
    p->slow = (uint16_t)((slow - (slow >> CVOL_RATE_SLOW)) ^ flip);
}

CVOL_INLINE void cvol_decode_more(cvol_range_decoder *coder)
{
    if (__builtin_expect(coder->range < UINT64_C(1) << 32, 0)) {
        uint32_t next;
        if (__builtin_expect(coder->coded_read + 4 <= coder->size, 1))
            next = cvol_big_endian32(coder->data + coder->coded_read);
        else
            next = cvol_range_take_last(coder->data, coder->size, coder->coded_read);
        coder->coded_read += 4;
        coder->range <<= 32;
        coder->code = coder->code << 32 | next;
    }
}

/* Decoded bits are hard to predict, so the code avoids branches on them. */
CVOL_INLINE int cvol_decode_probable(cvol_range_decoder *coder, uint32_t zero)
{
    const uint64_t bound = (coder->range >> 16) * zero;
    const int bit = coder->code >= bound;
    const uint64_t taken = bound & -(uint64_t)bit;
    coder->code -= taken;
    coder->range = (coder->range & -(uint64_t)bit) + bound - 2 * taken;
    cvol_decode_more(coder);
    return bit;
}
CVOL_INLINE int cvol_decode_bit(cvol_range_decoder *coder, cvol_probability *p)
{
    const int bit = cvol_decode_probable(coder, cvol_probability_of_zero(p));
    cvol_probability_pull(p, (uint32_t)bit);
    return bit;
}
/* Decodes one of 16 tokens; token t has the numbers bounds[7 + t] .. bounds[8 + t] - 1. */
CVOL_INLINE uint32_t cvol_decode_part(cvol_range_decoder *coder, const uint16_t bounds[24])
{
    const uint64_t unit = coder->range >> 14, n = coder->code / unit;
    uint32_t t = 0;
    while (t < 15 && n >= bounds[8 + t])
        t++;
    coder->code -= unit * bounds[7 + t];
    coder->range = unit * (uint64_t)(bounds[8 + t] - bounds[7 + t]);
    cvol_decode_more(coder);
    return t;
}

/* Reads `count` <= 32 uncoded bits. */
CVOL_INLINE uint32_t cvol_decode_raw(cvol_range_decoder *coder, int count)
{
    if (__builtin_expect(coder->raw_count < count, 0)) {
        uint32_t next;
        if (__builtin_expect(coder->raw_read + 4 <= coder->size, 1))
            next = cvol_big_endian32(coder->data + coder->size - coder->raw_read - 4);
        else
            next = cvol_raw_take_last(coder->data, coder->size, coder->raw_read);
        coder->raw_read += 4;
        coder->raw_bits |= (uint64_t)next << coder->raw_count;
        coder->raw_count += 32;
    }
    uint32_t value = (uint32_t)(coder->raw_bits & ((UINT64_C(1) << count) - 1));
    coder->raw_bits >>= count;
    coder->raw_count -= count;
    return value;
}

#endif
