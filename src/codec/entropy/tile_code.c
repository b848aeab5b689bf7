/* Tiles: an empty one is one bit; otherwise each coefficient is a bit for zero, its magnitude in
 * unary (large ones by their bit length), and a sign. */
#include "codec/entropy/tile_code.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static int count_below(const uint32_t *thresholds, int count, uint32_t value)
{
    int n = 0;
    while (n < count && thresholds[n] < value)
        n++;
    return n;
}

void cvol_tile_contexts_start(cvol_tile_contexts *contexts)
{
    static const uint32_t levels[CVOL_TILE_LEVELS - 1] = {0,  1,  2,  3,  4,  6,   8,  11,
                                                          15, 20, 28, 40, 60, 100, 200};
    static const uint32_t bands[CVOL_TILE_BANDS - 1] = {0, 1, 2, 4, 8, 14, 22, 32, 48};
    cvol_probability *all = &contexts->empty[0];
    const size_t count = (sizeof *contexts - offsetof(cvol_tile_contexts, empty)) / sizeof *all;
    for (size_t i = 0; i < count; i++)
        all[i] = (cvol_probability){1 << 15, 1 << 15};
    for (uint32_t sum = 0; sum < CVOL_TILE_SUMS; sum++)
        contexts->levels[sum] = (uint8_t)count_below(levels, CVOL_TILE_LEVELS - 1, sum);
    for (uint32_t f = 0; f < CVOL_TILE_FREQUENCIES; f++)
        contexts->bands[f] = (uint8_t)count_below(bands, CVOL_TILE_BANDS - 1, f);
}

static inline int code_bit(const cvol_tile_coder *coder, cvol_probability *p, int bit)
{
    if (coder->decoder)
        return cvol_decode_bit(coder->decoder, p);
    cvol_encode_bit(coder->encoder, p, bit);
    return bit;
}

static inline uint32_t code_raw(const cvol_tile_coder *coder, uint32_t value, int bits)
{
    if (coder->decoder)
        return cvol_decode_raw(coder->decoder, bits);
    cvol_encode_raw(coder->encoder, value, bits);
    return value & ((UINT32_C(1) << bits) - 1);
}

/* Codes a magnitude of CVOL_TILE_UNARY or more, minus that: the bit length of the rest plus one, in
 * unary, and the bits after the first. */
static uint32_t code_rest(const cvol_tile_coder *coder, uint32_t rest)
{
    int bits = 0;
    for (uint32_t left = (rest + 1) >> 1; left; left >>= 1)
        bits++;
    const int most = CVOL_TILE_LENGTHS + 6;
    int length = 0;
    while (
        length < most &&
        code_bit(
            coder,
            &coder->contexts->length[length < CVOL_TILE_LENGTHS ? length : CVOL_TILE_LENGTHS - 1],
            length < bits))
        length++;
    return (UINT32_C(1) << length) - 1 + code_raw(coder, rest + 1, length);
}

static int32_t code_value(const cvol_tile_coder *coder, int band, int level, int32_t value)
{
    cvol_tile_contexts *contexts = coder->contexts;
    const uint32_t size = (uint32_t)abs(value);
    if (!code_bit(coder, &contexts->zero[band][level], size > 0))
        return 0;
    uint32_t m = 1;
    while (m <= CVOL_TILE_UNARY && code_bit(coder, &contexts->more[level][m - 1], size > m))
        m++;
    if (m > CVOL_TILE_UNARY)
        m += code_rest(coder, size - m);
    if (m > 2 * (uint32_t)CVOL_TILE_LIMIT)
        m = 2 * (uint32_t)CVOL_TILE_LIMIT + 1; /* the caller rejects it */
    return code_raw(coder, value < 0, 1) ? -(int32_t)m : (int32_t)m;
}

/* ---- contexts ------------------------------------------------------------------------------- */

/* Clamped, so that sums stay within 32 bits. */
static inline uint32_t magnitude(int32_t value)
{
    const uint32_t size = (uint32_t)abs(value);
    return size < 4095 ? size : 4095;
}

/* Twice the frequency over the axis length, in 64ths. */
static uint32_t frequency(const cvol_tile *tile, int axis, size_t i)
{
    const size_t n = tile->size[axis];
    const size_t f = tile->transform == CVOL_DCT ? i : 2 * (i <= n - i ? i : n - i);
    return (uint32_t)(64 * f / n);
}

/* Sums magnitudes at place (i, j) of other tiles or planes, or at the mirrored frequency. */
static uint32_t partners(const int32_t *values, const cvol_tile *tile, size_t i, size_t j)
{
    const size_t w = tile->size[0], h = tile->size[1], place = i + w * j;
    if (tile->is_whole) {
        if (tile->transform == CVOL_DCT)
            return 0;
        const size_t mirror = (i ? w - i : 0) + w * (j ? h - j : 0);
        return mirror < place ? 2 * magnitude(values[mirror]) : 0;
    }
    if (!place)
        return 0;
    return (tile->left ? magnitude(tile->left[place]) : 0) +
           (tile->above ? magnitude(tile->above[place]) : 0);
}

static uint32_t around(const int32_t *values, const cvol_tile *tile, size_t i, size_t j)
{
    const size_t w = tile->size[0];
    const int32_t *at = values + i + w * j;
    uint32_t sum = partners(values, tile, i, j);
    if (tile->before)
        sum += 2 * magnitude(tile->before[i + w * j]);
    if (i)
        sum += 2 * magnitude(at[-1]);
    if (i > 1)
        sum += magnitude(at[-2]);
    if (j) {
        const int32_t *up = at - w;
        sum += 2 * magnitude(up[0]);
        sum += i ? magnitude(up[-1]) : 0;
        sum += i + 1 < w ? magnitude(up[1]) : 0;
    }
    if (j > 1)
        sum += magnitude(*(at - 2 * w));
    return sum;
}

/* ---- tiles ---------------------------------------------------------------------------------- */

/* Predicts the first coefficient, the mean. */
static int32_t predict(const cvol_tile *tile)
{
    if (tile->left && tile->above)
        return (int32_t)(((int64_t)tile->left[0] + tile->above[0]) >> 1);
    return tile->left ? tile->left[0] : tile->above ? tile->above[0] : 0;
}

/* True if a tile exists and has a nonzero coefficient after its first. */
static int is_busy(const cvol_tile *tile, const int32_t *values)
{
    const size_t count = tile->size[0] * tile->size[1];
    for (size_t i = 1; values && i < count; i++)
        if (values[i])
            return 1;
    return 0;
}

/* Codes the reach of a tile along an axis, 1 .. count: minus 1, bit by bit from the highest on,
 * each in the context of the bits before. */
static size_t code_reach(const cvol_tile_coder *coder, cvol_probability *contexts, size_t count,
                         size_t reach)
{
    size_t node = 1;
    for (size_t bit = count / 2; bit; bit /= 2)
        node = 2 * node + (size_t)code_bit(coder, &contexts[node], ((reach - 1) & bit) != 0);
    return node - count + 1;
}

/* Finds one past the last row and column of a tile with a nonzero coefficient. */
static void find_reach(size_t out[2], const int32_t *values, const size_t size[2])
{
    out[0] = out[1] = 1;
    for (size_t j = 0; j < size[1]; j++)
        for (size_t i = 0; i < size[0]; i++)
            if (values[i + size[0] * j]) {
                out[0] = i + 1 > out[0] ? i + 1 : out[0];
                out[1] = j + 1;
            }
}

int cvol_tile_code(const cvol_tile_coder *coder, int32_t *values, const cvol_tile *tile)
{
    const size_t w = tile->size[0], h = tile->size[1], count = w * h;
    const int32_t prediction = predict(tile);
    int busy = 0, holds = 1;
    if (coder->decoder)
        memset(values, 0, count * sizeof *values);
    else
        values[0] -= prediction;
    for (size_t i = 0; i < count && !busy; i++)
        busy = values[i] != 0;
    const int context = is_busy(tile, tile->left) + 2 * is_busy(tile, tile->above);
    busy = code_bit(coder, &coder->contexts->empty[context], busy);
    size_t reach[2] = {w, h};
    if (busy && !tile->is_whole) {
        find_reach(reach, values, tile->size);
        reach[0] = code_reach(coder, coder->contexts->columns, w, reach[0]);
        reach[1] = code_reach(coder, coder->contexts->rows, h, reach[1]);
    }
    uint32_t across[CVOL_TILE_SIDE];
    for (size_t i = 0; i < reach[0] && i < CVOL_TILE_SIDE; i++)
        across[i] = frequency(tile, 0, i);
    for (size_t j = 0; j < reach[1] && busy; j++) {
        const uint32_t row = frequency(tile, 1, j);
        for (size_t i = 0; i < reach[0]; i++) {
            int32_t *at = &values[i + w * j];
            const uint32_t column = i < CVOL_TILE_SIDE ? across[i] : frequency(tile, 0, i);
            const uint32_t sum = around(values, tile, i, j);
            *at = code_value(
                coder, coder->contexts->bands[row + column],
                coder->contexts->levels[sum < CVOL_TILE_SUMS ? sum : CVOL_TILE_SUMS - 1], *at);
            const int32_t most = i + j ? CVOL_TILE_LIMIT : 2 * CVOL_TILE_LIMIT;
            holds &= *at <= most && *at >= -most;
        }
    }
    const int64_t first = (int64_t)values[0] + prediction;
    if (!holds || first > CVOL_TILE_LIMIT || first < -CVOL_TILE_LIMIT)
        return 0;
    values[0] = (int32_t)first;
    return 1;
}
