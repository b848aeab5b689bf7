/* Greedy rate-distortion optimised quantization. */
#include "codec/quantize/rd_choice.h"

#include <math.h>

#include "codec/quantize/quantize.h"
#include "codec/quantize/sub_block_code.h"

/* A magnitude below this fraction of a step never pays its bits. */
#define MIN_SHARE 0.5f
/* Coefficients after the last one that reaches this fraction of a step become zero. */
#define LAST_SHARE 0.6f

/* Bits of a number's token and of its raw bits. */
static float bits_of_number(const float *row, uint64_t number)
{
    const uint32_t token = cvol_number_token(number);
    if (token < 4)
        return row[token];
    const int length = cvol_bit_length((uint32_t)number);
    return row[token] + (float)(length - 1) + (token == 15 ? 5 : 0);
}

/* Chooses the DC: the nearest value, or the next one towards the prediction. */
int32_t cvol_sub_block_choose_dc(float *cost, float *squared, float scaled,
                                 const cvol_token_costs *costs,
                                 const cvol_sub_block_context *context, int plain)
{
    const float *row = costs->of[context->dc_row];
    const int32_t nearest = (int32_t)lrintf(scaled);
    int32_t chosen = nearest;
    *cost = INFINITY;
    *squared = 0;
    for (int i = 0; i < (plain ? 1 : 2); i++) {
        const int32_t value = i == 0                                ? nearest
                              : (float)context->prediction < scaled ? nearest - 1
                                                                    : nearest + 1;
        const int64_t difference = value - context->prediction;
        const uint64_t number = (uint64_t)(difference < 0 ? -difference : difference);
        const float error = scaled - (float)value;
        const float sum = error * error +
                          CVOL_LAMBDA * (bits_of_number(row, number) + (number ? 1 : 0));
        if (sum < *cost) {
            *cost = sum;
            *squared = error * error;
            chosen = value;
        }
    }
    return chosen;
}

/* Chooses the best magnitude; *cost is error plus lambda times bits. */
static inline uint32_t decide(float *cost, const cvol_token_costs *costs, cvol_place_code code,
                              float scaled, int plain)
{
    float best = scaled * scaled + CVOL_LAMBDA * cvol_bits_of_zero(costs, code);
    uint32_t chosen = 0;
    if (scaled >= MIN_SHARE) {
        const uint32_t high = (uint32_t)(scaled + 0.5f);
        if (plain)
            best = INFINITY;
        for (uint32_t m = high > 1 && !plain ? high - 1 : high; m <= high; m++) {
            const float error = scaled - (float)m;
            const float sum = error * error + CVOL_LAMBDA * cvol_bits_of_value(costs, code, m);
            if (sum < best) {
                best = sum;
                chosen = m;
            }
        }
    }
    *cost = best;
    return chosen;
}

/* Chooses values 1 .. extent - 1, and the end of the sub-block. */
static cvol_sub_block_choice choose_rest(int32_t *values, const float *scaled, int extent,
                                         const cvol_scan *scan, const cvol_token_costs *costs,
                                         const float *length_row, double tail, int plain,
                                         uint16_t *scatter)
{
    const int size_class = scan->size_class;
    double total = 0, squared = 0; /* single precision would lose small errors in large tails */
    cvol_sub_block_choice choice = {1, (float)tail, (float)tail + CVOL_LAMBDA * length_row[0]};
    if (plain && extent > 1)
        choice.cost = INFINITY;
    cvol_scatter_dc(scatter, scan->row, scan->sheet, values[0]);
    for (int i = 1; i < extent; i++) {
        const cvol_scan_entry *entry = &scan->entries[i];
        const float size = fabsf(scaled[i]);
        const uint32_t sum = scatter[entry->scatter];
        float cost;
        const uint32_t m = decide(&cost, costs, cvol_value_code(size_class, entry->band, sum, 0, 0),
                                  size, plain);
        values[i] = scaled[i] < 0 ? -(int32_t)m : (int32_t)m;
        tail -= (double)size * (double)size;
        total += (double)cost;
        const float error = size - (float)m;
        squared += (double)(error * error);
        if (!m)
            continue;
        cvol_scatter(scatter + entry->scatter, scan->row, scan->sheet, m);
        const cvol_place_code last_code = cvol_last_code(size_class, sum, 0, 0);
        const float last_cost = error * error +
                                CVOL_LAMBDA * cvol_bits_of_last_value(costs, last_code, m);
        const float whole = (float)(total + tail) - cost + last_cost +
                            CVOL_LAMBDA * (length_row[cvol_bit_length(scan->index[i])] +
                                           cvol_bits_of_last(costs, size_class, scan->index[i]));
        if (whole < choice.cost || plain)
            choice = (cvol_sub_block_choice){i + 1, (float)(squared + tail), whole};
    }
    int side = 1;
    while (side * side * side <= scan->index[extent - 1])
        side *= 2;
    cvol_scatter_clear(scatter, scan->row, scan->sheet, side);
    return choice;
}

/* Sums the squares of c[begin .. end) in eight independent sums, which hide the latency of
 * additions. */
double cvol_sub_block_squares(const float *c, int begin, int end)
{
    double sums[8] = {0};
    int i = begin;
    for (; i + 8 <= end; i += 8)
        for (int k = 0; k < 8; k++)
            sums[k] += (double)c[i + k] * (double)c[i + k];
    for (; i < end; i++)
        sums[0] += (double)c[i] * (double)c[i];
    return ((sums[0] + sums[1]) + (sums[2] + sums[3])) +
           ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

cvol_sub_block_choice cvol_sub_block_choose(int32_t *values, const float *scaled,
                                            const cvol_scan *scan, const cvol_token_costs *costs,
                                            const cvol_sub_block_context *context, int plain,
                                            uint16_t *scatter)
{
    const int size_class = scan->size_class;
    const int extent = cvol_quantise_extent(scaled, scan->count, plain ? 0.4999f : LAST_SHARE);
    float dc_cost, dc_error;
    values[0] = 0; /* later sub-blocks may use it as context even if this one does not fit */
    if (!cvol_quantise_fits(scaled, extent, 1))
        return (cvol_sub_block_choice){0, 0, INFINITY};
    const double tail = cvol_sub_block_squares(scaled, 1, extent) +
                        cvol_sub_block_squares(scaled, extent, scan->count);
    values[0] = cvol_sub_block_choose_dc(&dc_cost, &dc_error, scaled[0], costs, context, plain);
    const int64_t difference = values[0] - context->prediction;
    const float *length_row = costs->of[cvol_length_row(
        context, size_class, (uint64_t)(difference < 0 ? -difference : difference))];
    cvol_sub_block_choice choice = {1, (float)tail, (float)tail + CVOL_LAMBDA * length_row[0]};
    if (extent > 1)
        choice = choose_rest(values, scaled, extent, scan, costs, length_row, tail, plain, scatter);
    choice.error += dc_error;
    choice.cost += dc_cost;
    return choice;
}
