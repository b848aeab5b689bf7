/* Encodes and decodes residuals. */
#include "codec/residual/residual_code.h"

#include <limits.h>
#include <stdlib.h>

#include "base/doubles.h"
#include "base/for_type.h"
#include "base/memory.h"
#include "codec/residual/residual_intervals.h"

enum {
    SIDE = CVOL_BRICK_SIDE,
    LINE = SIDE + 2,
    SLICE = LINE * LINE,
    SMALL_SUMS = 161,
    LENGTH_MAX = 50 /* bits of a magnitude */
};
#define ENTERING_MAX ((UINT32_C(1) << 28) - 1)
#define NUMBER_MAX 0x1p50

struct cvol_residual_coder {
    cvol_token_writer writer;
    uint32_t slices[2][SLICE]; /* magnitudes, with a border of zeros */
    uint32_t sums[LINE];       /* of a line's neighbours, without the previous sample */
    uint8_t levels[SMALL_SUMS];
    double values[SIDE]; /* of a line */
    int64_t numbers[SIDE];
    uint8_t widening[SIDE];
};

cvol_residual_coder *cvol_residual_coder_create(void)
{
    static const int bounds[] = {0, 1, 2, 3, 4, 6, 8, 11, 15, 20, 28, 40, 56, 80, 112, INT_MAX};
    cvol_residual_coder *coder = cvol_allocate_zero(1, sizeof *coder);
    for (int sum = 0, level = 0; coder && sum < SMALL_SUMS; sum++) {
        while (sum > bounds[level])
            level++;
        coder->levels[sum] = (uint8_t)level;
    }
    return coder;
}

void cvol_residual_coder_free(cvol_residual_coder *coder)
{
    if (!coder)
        return;
    cvol_token_writer_free(&coder->writer);
    free(coder);
}

/* ---- magnitudes ------------------------------------------------------------------------- */

CVOL_INLINE int level_of(const cvol_residual_coder *coder, uint32_t sum)
{
    if (__builtin_expect(sum < SMALL_SUMS, 1))
        return coder->levels[sum];
    const int e = cvol_bit_length(sum) - 1;
    return 2 + 2 * e + (int)(sum >> (e - 1) & 1);
}

CVOL_INLINE int shift_of(int level)
{
    return level < 14 ? 0 : level < 16 ? 1 : (level - 2) / 2 - 5;
}

CVOL_INLINE int row_of(int level)
{
    return level < CVOL_RESIDUAL_LEVELS ? level : CVOL_RESIDUAL_LEVELS - 2 + (level & 1);
}

static void put_low_bits(cvol_token_writer *out, uint64_t value, int count)
{
    for (; count > 32; count -= 32, value >>= 32)
        cvol_raw_put(out, (uint32_t)value, 32);
    cvol_raw_put(out, (uint32_t)(value & ((UINT64_C(1) << count) - 1)), count);
}

static uint64_t take_low_bits(cvol_token_reader *in, int count)
{
    if (count <= 32)
        return cvol_raw_take(in, count);
    const uint64_t low = cvol_raw_take(in, 32);
    return low | (uint64_t)cvol_raw_take(in, count - 32) << 32;
}

static void put_magnitude(cvol_token_writer *out, int level, uint64_t magnitude)
{
    const int shift = shift_of(level), row = row_of(level);
    const uint64_t high = magnitude >> shift;
    cvol_token_put(out, CVOL_ROW_RESIDUAL + row, high < 15 ? (uint32_t)high : 15);
    if (high >= 15) {
        const uint64_t rest = high - 14;
        const int bits = 63 - __builtin_clzll(rest);
        cvol_token_put(out, CVOL_ROW_RESIDUAL_MORE + row, bits < 15 ? (uint32_t)bits : 15);
        if (bits >= 15)
            cvol_raw_put(out, (uint32_t)bits - 15, 6);
        put_low_bits(out, rest, bits);
    }
    if (shift)
        cvol_raw_put(out, (uint32_t)magnitude, shift);
}

/* UINT64_MAX: beyond the largest magnitude. */
static uint64_t take_more(cvol_token_reader *in, int row)
{
    int bits = (int)cvol_token_take(in, CVOL_ROW_RESIDUAL_MORE + row);
    if (bits == 15)
        bits += (int)cvol_raw_take(in, 6);
    if (bits > LENGTH_MAX)
        return UINT64_MAX;
    return (UINT64_C(1) << bits) + take_low_bits(in, bits) + 14;
}

CVOL_INLINE uint64_t take_magnitude(cvol_token_reader *in, int level)
{
    const int shift = shift_of(level), row = row_of(level);
    uint64_t high = cvol_token_take(in, CVOL_ROW_RESIDUAL + row);
    if (__builtin_expect(high == 15, 0)) {
        high = take_more(in, row);
        if (high >> (LENGTH_MAX - shift))
            return UINT64_MAX;
    }
    return shift ? high << shift | cvol_raw_take(in, shift) : high;
}

/* ---- neighbours ------------------------------------------------------------------------- */

static void start_brick(cvol_residual_coder *coder)
{
    memset(coder->slices, 0, sizeof coder->slices);
}

static uint32_t *line_of(cvol_residual_coder *coder, size_t y, size_t z)
{
    return coder->slices[z & 1] + LINE * (y + 1) + 1;
}

/* Sums the neighbours in earlier lines; the coder later adds twice the magnitude at x - 1 to
 * sums[x]. */
static void sum_neighbours(cvol_residual_coder *coder, size_t y, size_t z, size_t width)
{
    const uint32_t *up = line_of(coder, y, z) - LINE;
    const uint32_t *front = line_of(coder, y, z + 1);
    uint32_t *sums = coder->sums;
    for (size_t x = 0; x < width; x++) {
        const uint32_t *u = up + x, *f = front + x;
        sums[x] = 2 * (u[0] + f[0]) + u[-1] + u[1] + f[-1] + f[1] + f[-LINE] + f[LINE];
    }
}

/* The value of a magnitude in later sums. */
CVOL_INLINE uint32_t entering(uint64_t magnitude, int widening)
{
    return magnitude > ENTERING_MAX >> widening ? ENTERING_MAX : (uint32_t)(magnitude << widening);
}

CVOL_INLINE uint32_t sum_at(const cvol_residual_coder *coder, const uint32_t *line, size_t x,
                            int first_slice)
{
    const uint32_t sum = coder->sums[x] + 2 * line[(ptrdiff_t)x - 1];
    return first_slice ? (sum < UINT32_C(1) << 31 ? 2 * sum : UINT32_MAX) : sum;
}

/* ---- from values to numbers and back ---------------------------------------------------- */

static void store_line(void *samples, cvol_type type, size_t at, const double *from,
                       const uint8_t *which, size_t count)
{
#define STORE(t)                       \
    for (size_t x = 0; x < count; x++) \
        if (!which || !which[x])       \
    ((t *)samples)[at + x] = (t)from[x]
    CVOL_FOR_TYPE(type, STORE);
#undef STORE
}

CVOL_INLINE double add_residual(const cvol_residual_rule *rule, double base, double number)
{
    const double value = base + rule->quantum * number;
    return value < rule->value_min   ? rule->value_min
           : value > rule->value_max ? rule->value_max
                                     : value;
}

/* Finds a line's numbers for a quantum; returns 0 if a sample's error exceeds the bound. */
static int find_numbers(cvol_residual_coder *coder, const cvol_residual_rule *rule, double bound,
                        const double *base, const uint8_t *which, size_t count)
{
    int held = 1;
    for (size_t x = 0; x < count; x++) {
        coder->widening[x] = 0;
        if (which && which[x])
            continue;
        const double number = floor((coder->values[x] - base[x]) / rule->quantum + 0.5);
        double value = add_residual(rule, base[x], number);
        if (rule->type == CVOL_FLOAT32)
            value = (double)(float)value;
        held &= fabs(number) < NUMBER_MAX && fabs(coder->values[x] - value) <= bound;
        coder->numbers[x] = (int64_t)(held ? number : 0);
    }
    return held;
}

static int find_cells(cvol_residual_coder *coder, const cvol_residual_rule *rule,
                      const double *base, const uint8_t *which, size_t count)
{
    const cvol_float_kind kind = cvol_float_kind_of(rule->type);
    for (size_t x = 0; x < count; x++) {
        if (which && which[x])
            continue;
        const int widening = cvol_cell_widening(rule, kind, base[x]);
        const double per_cell = cvol_power_of_two(-(rule->unit + widening));
        if (!(fabs(coder->values[x]) * per_cell < NUMBER_MAX / 2))
            return 0;
        coder->widening[x] = (uint8_t)widening;
        coder->numbers[x] = cvol_cell_of(coder->values[x], per_cell) -
                            cvol_cell_of(base[x], per_cell);
    }
    return 1;
}

/* ---- encoding --------------------------------------------------------------------------- */

/* Returns 1 if the line has content other than zeros. */
static int put_line(cvol_residual_coder *coder, const cvol_residual_rule *rule, size_t y, size_t z,
                    const uint8_t *which, size_t count)
{
    cvol_token_writer *out = &coder->writer;
    uint32_t *line = line_of(coder, y, z);
    const int cells = cvol_residual_rule_needs_base(rule);
    int any = 0;
    sum_neighbours(coder, y, z, count);
    for (size_t x = 0; x < count; x++) {
        const uint32_t sum = sum_at(coder, line, x, z == 0);
        if (which && which[x]) {
            const uint32_t expected = sum / 12;
            line[x] = expected < ENTERING_MAX ? expected : ENTERING_MAX;
            continue;
        }
        const int64_t number = coder->numbers[x];
        const uint64_t magnitude = (uint64_t)(number < 0 ? -number : number);
        const int widening = coder->widening[x];
        put_magnitude(out, level_of(coder, sum >> widening), magnitude);
        if (magnitude)
            cvol_raw_put(out, number < 0, 1);
        line[x] = entering(magnitude, widening);
        any |= number != 0;
        if (cells) {
            const int t = rule->unit + widening;
            const double value = coder->values[x];
            cvol_interval_put_offset(out, rule, value,
                                     (uint64_t)(fabs(value) * cvol_power_of_two(-t)), t);
            any = 1;
        }
    }
    return any;
}

int cvol_residual_encode(cvol_residual_coder *coder, cvol_bytes *out,
                         const cvol_residual_rule *rule, double bound,
                         const cvol_token_tables *tables, const void *samples,
                         const cvol_residual_brick *brick, cvol_token_counts *counts)
{
    const size_t width = brick->size[0], height = brick->size[1];
    int any = 0;
    out->size = 0;
    start_brick(coder);
    cvol_token_writer_start(&coder->writer);
    for (size_t z = 0; z < brick->size[2]; z++)
        for (size_t y = 0; y < height; y++) {
            const size_t at = width * (y + height * z);
            const double *base = brick->base + at;
            const uint8_t *which = brick->which ? brick->which + at : NULL;
            cvol_doubles_load(coder->values, rule->type, samples, at, width);
            if (!(cvol_residual_rule_needs_base(rule)
                      ? find_cells(coder, rule, base, which, width)
                      : find_numbers(coder, rule, bound, base, which, width)))
                return CVOL_ERROR_TARGET;
            any |= put_line(coder, rule, y, z, which, width);
        }
    if (!any)
        return CVOL_OK;
    if (counts)
        cvol_token_writer_count(&coder->writer, counts);
    return cvol_token_writer_finish(&coder->writer, tables, out) ? CVOL_OK : CVOL_ERROR_MEMORY;
}

/* ---- decoding --------------------------------------------------------------------------- */

/* Reads the value in interval `cell` of width 2^t; returns 0 if the bits are invalid. */
static int take_value(cvol_token_reader *in, const cvol_residual_rule *rule, int64_t cell, int t,
                      double *value)
{
    const uint64_t a = (uint64_t)(cell < 0 ? -1 - cell : cell);
    const double magnitude = cvol_interval_take_offset(in, rule, a, t);
    *value = cell < 0 ? -magnitude : magnitude;
    return magnitude >= 0 && *value >= rule->value_min && *value <= rule->value_max;
}

CVOL_INLINE int take_line(cvol_residual_coder *coder, const cvol_residual_rule *rule,
                          cvol_token_reader *stream, size_t y, size_t z, const double *base,
                          const uint8_t *which, size_t count, int cells)
{
    const cvol_float_kind kind = cvol_float_kind_of(rule->type);
    cvol_token_reader in = *stream;
    uint32_t *line = line_of(coder, y, z);
    sum_neighbours(coder, y, z, count);
    for (size_t x = 0; x < count; x++) {
        const uint32_t sum = sum_at(coder, line, x, z == 0);
        if (which && which[x]) {
            const uint32_t expected = sum / 12;
            line[x] = expected < ENTERING_MAX ? expected : ENTERING_MAX;
            continue;
        }
        const int widening = cells ? cvol_cell_widening(rule, kind, base[x]) : 0;
        const uint64_t magnitude = take_magnitude(&in, level_of(coder, sum >> widening));
        if (__builtin_expect(magnitude >> LENGTH_MAX != 0, 0))
            return 0;
        int64_t number = (int64_t)magnitude;
        if (magnitude && cvol_raw_take(&in, 1))
            number = -number;
        line[x] = entering(magnitude, widening);
        if (cells) {
            const int t = rule->unit + widening;
            const int64_t cell = cvol_cell_of(base[x], cvol_power_of_two(-t)) + number;
            if (!take_value(&in, rule, cell, t, &coder->values[x]))
                return 0;
        } else {
            coder->values[x] = add_residual(rule, base[x], (double)number);
        }
    }
    *stream = in;
    return 1;
}

int cvol_residual_decode(cvol_residual_coder *coder, void *samples, const cvol_residual_rule *rule,
                         const cvol_token_tables *tables, const cvol_residual_brick *brick,
                         cvol_span data)
{
    const size_t width = brick->size[0], height = brick->size[1];
    const int cells = cvol_residual_rule_needs_base(rule);
    cvol_token_reader in;
    start_brick(coder);
    cvol_token_reader_start(&in, tables, data.data, data.size);
    for (size_t z = 0; z < brick->size[2]; z++)
        for (size_t y = 0; y < height; y++) {
            const size_t at = width * (y + height * z);
            const double *base = brick->base + at;
            const uint8_t *which = brick->which ? brick->which + at : NULL;
            int sound = 1;
            if (cells)
                sound = take_line(coder, rule, &in, y, z, base, which, width, 1);
            else if (data.size)
                sound = take_line(coder, rule, &in, y, z, base, which, width, 0);
            else
                for (size_t x = 0; x < width; x++)
                    coder->values[x] = add_residual(rule, base[x], 0);
            if (!sound)
                return CVOL_ERROR_CORRUPT;
            store_line(samples, rule->type, at, coder->values, which, width);
        }
    return cvol_token_reader_ended(&in) ? CVOL_OK : CVOL_ERROR_CORRUPT;
}
