/* The neural coder's bits, for encoder and decoder. */
#ifndef CVOL_CODEC_NEURAL_NEURAL_STREAM_H
#define CVOL_CODEC_NEURAL_NEURAL_STREAM_H

#include "codec/neural/neural_internal.h"

typedef struct cvol_neural_stream {
    cvol_range_encoder *encoder; /* NULL: decoding */
    cvol_range_decoder decoder;
} cvol_neural_stream;

/* Codes a bit that is 1 with probability p / 2^16. */
CVOL_INLINE int cvol_neural_code_probable(cvol_neural_stream *s, uint32_t p, int bit)
{
    const uint32_t zero = 65536 - p;
    if (s->encoder)
        cvol_encode_probable(s->encoder, zero, bit);
    else
        bit = cvol_decode_probable(&s->decoder, zero);
    return bit;
}

CVOL_INLINE int cvol_neural_code_bit(cvol_neural_stream *s, cvol_probability *p, int bit)
{
    if (s->encoder)
        cvol_encode_bit(s->encoder, p, bit);
    else
        bit = cvol_decode_bit(&s->decoder, p);
    return bit;
}

CVOL_INLINE uint32_t cvol_neural_code_raw(cvol_neural_stream *s, uint32_t value, int count)
{
    if (s->encoder)
        cvol_encode_raw(s->encoder, value, count);
    else
        value = cvol_decode_raw(&s->decoder, count);
    return value;
}

/* Codes the low `count` < 32 bits of a value. */
CVOL_INLINE uint32_t cvol_neural_code_low(cvol_neural_stream *s, uint32_t value, int count)
{
    return cvol_neural_code_raw(s, value & ((UINT32_C(1) << count) - 1), count);
}

static inline uint32_t cvol_neural_code_token(cvol_neural_stream *s,
                                              const cvol_token_tables *tables, int row,
                                              uint32_t token)
{
    const uint16_t *bounds = tables->rows[row].bounds;
    if (s->encoder) {
        cvol_encode_part(s->encoder, bounds[7 + token], bounds[8 + token]);
        return token;
    }
    return cvol_decode_part(&s->decoder, bounds);
}

/* Codes a bit by a logit, corrected by the observed bits at similar logits. */
CVOL_INLINE int cvol_neural_code_logit(cvol_neural_stream *s, cvol_neural_curve *c, int logit,
                                       int bit)
{
    const int at = logit + 2048, bucket = at >> CVOL_NEURAL_BUCKET_BITS,
              share = at & ((1 << CVOL_NEURAL_BUCKET_BITS) - 1);
    const uint32_t own = cvol_logistic_probability[at];
    const uint32_t seen = ((uint32_t)c->at[bucket] * (uint32_t)(128 - share) +
                           (uint32_t)c->at[bucket + 1] * (uint32_t)share) >>
                          7;
    uint32_t p = (own + 3 * seen) >> 2;
    p = p < 48 ? 48 : p > 65536 - 48 ? 65536 - 48 : p;
    bit = cvol_neural_code_probable(s, p, bit);
    uint16_t *near = &c->at[bucket + (share >= 64)];
    *near = (uint16_t)(*near + (((bit ? 65535 : 0) - (int)*near) >> 7));
    return bit;
}

#endif
