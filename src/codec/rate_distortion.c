/* Greedy rate-distortion optimised quantisation. */
#include "codec/rate_distortion.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "codec/block_contexts.h"
#include "codec/quantise.h"

/* Below this share of a step a magnitude is never worth coding. */
#define LEAST_SHARE 0.5f
/* Coefficients after the last one of this share are taken as zero. */
#define LAST_SHARE 0.62f

/* bits[p >> 4]: -log2 of a probability p / 2^16. Filled once, read-only after. */
static float bits_table[4097];
static pthread_once_t bits_once = PTHREAD_ONCE_INIT;

static void fill_bits(void)
{
    for (int i = 0; i <= 4096; i++)
        bits_table[i] = (float)-log2(((i < 4096 ? i : 4095) + 0.5) / 4096);
}

static inline float bits_of(const cvol_probability *p, int bit)
{
    uint32_t zero = cvol_probability_of_zero(p);
    return bits_table[(bit ? 65536 - zero : zero) >> 4];
}

static float bits_of_rest(const cvol_probability *prefix, uint32_t value)
{
    int length = cvol_bit_length(value + 1) - 1;
    float bits = 0;
    for (int n = 0; n < length; n++)
        bits += bits_of(&prefix[n < CVOL_PREFIXES ? n : CVOL_PREFIXES - 1], 1);
    bits += bits_of(&prefix[length < CVOL_PREFIXES ? length : CVOL_PREFIXES - 1], 0);
    return bits + (float)length;
}

/* Bits of a magnitude >= 1 and its sign, beyond those of "not zero". */
static float bits_beyond_zero(const cvol_block_model *model, int band, int level,
                              uint32_t magnitude)
{
    if (magnitude == 1)
        return 1 + bits_of(&model->one[band][level], 0);
    float bits = 1 + bits_of(&model->one[band][level], 1);
    if (magnitude == 2)
        return bits + bits_of(&model->two[band % 3][level], 0);
    bits += bits_of(&model->two[band % 3][level], 1);
    return bits + bits_of_rest(model->rest[level], magnitude - 3);
}

/* Bits of a last index of each bit length. */
static void bits_of_last(float bits[17], const cvol_block_model *model, int context)
{
    for (int length = 1; length <= 15; length++) {
        int node = 1;
        bits[length] = length > 1 ? (float)(length - 1) : 0;
        for (int k = 3; k >= 0; k--) {
            int bit = (length - 1) >> k & 1;
            bits[length] += bits_of(&model->last_bits[context][node], bit);
            node = 2 * node + bit;
        }
    }
}

/* The better of two neighbouring magnitudes; *cost is its sum of both kinds, and *saved what of it
 * is saved where the coefficient is known not to be zero. */
static uint32_t decide(float *cost, float *saved, const cvol_block_model *model, int band,
                       int level, float scaled)
{
    const cvol_probability *zero = &model->zero[band][level];
    float best = scaled * scaled + CVOL_LAMBDA * bits_of(zero, 0);
    uint32_t chosen = 0;
    *saved = 0;
    if (scaled >= LEAST_SHARE) {
        const uint32_t high = (uint32_t)(scaled + 0.5f);
        const float not_zero = CVOL_LAMBDA * bits_of(zero, 1);
        for (uint32_t m = high > 1 ? high - 1 : 1; m <= high; m++) {
            float error = scaled - (float)m;
            float sum = error * error + not_zero +
                        CVOL_LAMBDA * bits_beyond_zero(model, band, level, m);
            if (sum < best) {
                best = sum;
                chosen = m;
                *saved = not_zero;
            }
        }
    }
    *cost = best;
    return chosen;
}

/* Chooses values 1 .. used - 1; the result is where the block had best end. */
static int choose(int32_t *values, const float *c, int used, cvol_block_coder *coder,
                  const cvol_block_context *context, float inverse)
{
    const cvol_scan *scan = coder->scan;
    const int row = scan->block + 2, sheet = row * row;
    float last_bits[17], tail = 0, sum = 0;
    bits_of_last(last_bits, &coder->model, context->last);
    for (int i = 1; i < used; i++)
        tail += c[i] * inverse * (c[i] * inverse);
    const float some = CVOL_LAMBDA * bits_of(&coder->model.any[context->any], 1);
    float best = tail + CVOL_LAMBDA * bits_of(&coder->model.any[context->any], 0);
    int end = 1;
    cvol_scatter_dc(coder->scatter, row, sheet, values[0]);
    for (int i = 1; i < used; i++) {
        const cvol_scan_entry *entry = &scan->entries[i];
        const float scaled = fabsf(c[i]) * inverse;
        int level = cvol_level_of(scan->level, coder->scatter[entry->scatter]);
        float cost, saved;
        uint32_t m = decide(&cost, &saved, &coder->model, entry->band, level, scaled);
        values[i] = c[i] < 0 ? -(int32_t)m : (int32_t)m;
        tail -= scaled * scaled;
        sum += cost;
        if (!m)
            continue;
        cvol_scatter(coder->scatter + entry->scatter, row, sheet, m);
        float whole = sum - saved + tail + some +
                      CVOL_LAMBDA * last_bits[cvol_bit_length((uint32_t)i)];
        if (whole < best) {
            best = whole;
            end = i + 1;
        }
    }
    memset(coder->scatter, 0, sizeof(uint16_t) * (size_t)(sheet * row));
    return end;
}

int cvol_quantise_optimally(int32_t *values, const float *coefficients, cvol_block_coder *coder,
                            size_t place, double step)
{
    pthread_once(&bits_once, fill_bits);
    const cvol_block_context context = cvol_block_context_of(coder, place);
    const float inverse = (float)(1 / step);
    int used = cvol_quantise_extent(coefficients, coder->scan->count, (float)(LAST_SHARE * step));
    if (!cvol_quantise_fits(coefficients, used, step))
        return 0;
    float dc = fabsf(coefficients[0]) * inverse + 0.5f;
    values[0] = coefficients[0] < 0 ? -(int32_t)dc : (int32_t)dc;
    return used > 1 ? choose(values, coefficients, used, coder, &context, inverse) : 1;
}
