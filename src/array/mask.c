/* Masks of volumes, and the fills that make them. */
#include "array/mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

enum { CELL = CVOL_MASK_CELL, MIXED = 255, WORDS = CELL * CELL * CELL / 64 };

struct cvol_mask {
    size_t dims[3], cells[3];
    cvol_fills fills;
    int planes;         /* bits that tell the fills and none apart */
    uint8_t *states;    /* of each cell: 0, one fill everywhere (1 ..), or MIXED */
    uint64_t **bitmaps; /* of mixed cells: plane after plane of WORDS words */
};

/* Samples as words, whatever their type. */
typedef uint8_t __attribute__((may_alias)) word8;
typedef uint16_t __attribute__((may_alias)) word16;
typedef uint32_t __attribute__((may_alias)) word32;
typedef uint64_t __attribute__((may_alias)) word64;

/* ---- fills ------------------------------------------------------------------------------ */

int cvol_fills_add(cvol_fills *fills, uint64_t bits)
{
    for (int i = 0; i < fills->count; i++)
        if (fills->bits[i] == bits)
            return 1;
    if (fills->count == CVOL_FILLS_MAX)
        return 0;
    fills->bits[fills->count++] = bits;
    return 1;
}

int cvol_fills_of_value(uint64_t *bits, cvol_type type, double value)
{
    *bits = 0;
    if (type == CVOL_FLOAT64) {
        memcpy(bits, &value, sizeof value);
        return 1;
    }
    if (type == CVOL_FLOAT32) {
        const float number = (float)value;
        uint32_t word;
        memcpy(&word, &number, sizeof word);
        *bits = word;
        return 1;
    }
    const int size = (int)cvol_type_size(type);
    const int is_signed = type == CVOL_INT8 || type == CVOL_INT16 || type == CVOL_INT32;
    const double span = ldexp(1, 8 * size), lo = is_signed ? -span / 2 : 0;
    const double nearest = floor(value + 0.5);
    if (nearest != value || !(nearest >= lo && nearest < lo + span))
        return 0;
    *bits = (uint64_t)(int64_t)nearest & ((UINT64_C(1) << 8 * size) - 1);
    return 1;
}

#define FOR_SIZE(type, CASE)        \
    switch (cvol_type_size(type)) { \
    case 1:                         \
        CASE(word8);                \
        break;                      \
    case 2:                         \
        CASE(word16);               \
        break;                      \
    case 4:                         \
        CASE(word32);               \
        break;                      \
    default:                        \
        CASE(word64);               \
        break;                      \
    }

double cvol_fills_value(const cvol_fills *fills, int which, cvol_type type)
{
    const uint64_t bits = fills->bits[which];
    const int unused = 64 - 8 * (int)cvol_type_size(type);
    double value = 0;
    if (type == CVOL_FLOAT64) {
        memcpy(&value, &bits, sizeof value);
    } else if (type == CVOL_FLOAT32) {
        const uint32_t word = (uint32_t)bits;
        float number;
        memcpy(&number, &word, sizeof number);
        value = (double)number;
    } else if (type == CVOL_INT8 || type == CVOL_INT16 || type == CVOL_INT32) {
        value = (double)((int64_t)(bits << unused) >> unused);
    } else {
        value = (double)bits;
    }
    return value;
}

int cvol_fills_add_strange(cvol_fills *fills, cvol_type type, const void *samples, size_t count)
{
    if (cvol_type_is_integer(type))
        return 1;
    const int is_double = type == CVOL_FLOAT64;
    const uint64_t exponent = is_double ? UINT64_C(0x7ff) << 52 : UINT64_C(0xff) << 23;
    for (size_t i = 0; i < count; i++) {
        const uint64_t bits = is_double ? ((const word64 *)samples)[i]
                                        : ((const word32 *)samples)[i];
        if ((bits & exponent) == exponent && !cvol_fills_add(fills, bits))
            return 0;
    }
    return 1;
}

size_t cvol_fills_match(uint8_t *which, const cvol_fills *fills, cvol_type type,
                        const void *samples, size_t count)
{
    memset(which, 0, count);
    for (int f = 0; f < fills->count; f++) {
        const uint64_t bits = fills->bits[f];
        const uint8_t mark = (uint8_t)(f + 1);
#define MATCH(word)                                   \
    for (size_t i = 0; i < count; i++)                \
        if (((const word *)samples)[i] == (word)bits) \
    which[i] = mark
        FOR_SIZE(type, MATCH);
#undef MATCH
    }
    size_t found = 0;
    for (size_t i = 0; i < count; i++)
        found += which[i] != 0;
    return found;
}

void cvol_fills_apply(void *samples, const cvol_fills *fills, cvol_type type, const uint8_t *which,
                      size_t count)
{
#define APPLY(word)                    \
    for (size_t i = 0; i < count; i++) \
        if (which[i])                  \
    ((word *)samples)[i] = (word)fills->bits[which[i] - 1]
    FOR_SIZE(type, APPLY);
#undef APPLY
}

/* ---- masks ------------------------------------------------------------------------------ */

int cvol_mask_create(cvol_context *context, cvol_mask **out, const size_t dims[3],
                     const cvol_fills *fills)
{
    *out = NULL;
    cvol_mask *mask = calloc(1, sizeof *mask);
    if (!mask)
        return cvol_fail_memory(context, sizeof *mask, "a mask");
    size_t count = 1;
    int sized = 1;
    for (int a = 0; a < 3; a++) {
        mask->dims[a] = dims[a];
        mask->cells[a] = (dims[a] - 1) / CELL + 1;
        sized = sized && cvol_size_multiply(&count, count, mask->cells[a]);
    }
    mask->fills = *fills;
    while (fills->count >> mask->planes)
        mask->planes++;
    mask->states = sized ? calloc(count, sizeof *mask->states) : NULL;
    mask->bitmaps = sized ? calloc(count, sizeof *mask->bitmaps) : NULL;
    if (!mask->states || !mask->bitmaps) {
        cvol_mask_free(mask);
        return cvol_fail_memory(context, count, "a mask's cells");
    }
    *out = mask;
    return CVOL_OK;
}

static size_t cell_count(const cvol_mask *mask)
{
    return mask->cells[0] * mask->cells[1] * mask->cells[2];
}

void cvol_mask_free(cvol_mask *mask)
{
    if (!mask)
        return;
    for (size_t i = 0; mask->bitmaps && i < cell_count(mask); i++)
        free(mask->bitmaps[i]);
    free(mask->bitmaps);
    free(mask->states);
    free(mask);
}

const cvol_fills *cvol_mask_fills(const cvol_mask *mask)
{
    return &mask->fills;
}

int cvol_mask_is_void(const cvol_mask *mask)
{
    return mask && !mask->fills.background;
}

int cvol_mask_is_background(const cvol_mask *mask)
{
    return mask && mask->fills.background;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* A cell's part of a box. */
typedef struct part {
    size_t cell, lo[3], hi[3]; /* lo, hi: of the volume */
} part;

static part part_of(const cvol_mask *mask, const size_t place[3], const size_t begin[3],
                    const size_t end[3])
{
    part p = {place[0] + mask->cells[0] * (place[1] + mask->cells[1] * place[2]), {0}, {0}};
    for (int a = 0; a < 3; a++) {
        p.lo[a] = place[a] * CELL > begin[a] ? place[a] * CELL : begin[a];
        p.hi[a] = least((place[a] + 1) * CELL, end[a]);
    }
    return p;
}

static size_t bit_of(size_t x, size_t y, size_t z)
{
    return x % CELL + CELL * (y % CELL + CELL * (z % CELL));
}

static int set_cell(cvol_mask *mask, const part *p, const uint8_t *which, const size_t begin[3],
                    const size_t size[3])
{
    const uint8_t *from = which + (p->lo[0] - begin[0]) +
                          size[0] * (p->lo[1] - begin[1] + size[1] * (p->lo[2] - begin[2]));
    const uint8_t first = *from;
    int same = 1;
    free(mask->bitmaps[p->cell]);
    mask->bitmaps[p->cell] = NULL;
    for (size_t z = p->lo[2]; z < p->hi[2]; z++)
        for (size_t y = p->lo[1]; y < p->hi[1]; y++)
            for (size_t x = p->lo[0]; x < p->hi[0]; x++)
                same &= from[x - p->lo[0] + size[0] * (y - p->lo[1] + size[1] * (z - p->lo[2]))] ==
                        first;
    mask->states[p->cell] = same ? first : MIXED;
    if (same)
        return 1;
    uint64_t *bitmap = calloc((size_t)mask->planes * WORDS, sizeof *bitmap);
    if (!bitmap) {
        mask->states[p->cell] = 0;
        return 0;
    }
    for (size_t z = p->lo[2]; z < p->hi[2]; z++)
        for (size_t y = p->lo[1]; y < p->hi[1]; y++)
            for (size_t x = p->lo[0]; x < p->hi[0]; x++) {
                const uint64_t value =
                    from[x - p->lo[0] + size[0] * (y - p->lo[1] + size[1] * (z - p->lo[2]))];
                const size_t bit = bit_of(x, y, z);
                for (int plane = 0; plane < mask->planes; plane++)
                    bitmap[plane * WORDS + (int)(bit / 64)] |= (value >> plane & 1) << bit % 64;
            }
    mask->bitmaps[p->cell] = bitmap;
    return 1;
}

/* The lowest `width` bits (at most 16), each a byte; how many are 1. */
static size_t copy_bits(uint8_t *to, uint32_t bits, size_t width)
{
    static const uint8_t four[16][4] = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {1, 1, 0, 0},
                                        {0, 0, 1, 0}, {1, 0, 1, 0}, {0, 1, 1, 0}, {1, 1, 1, 0},
                                        {0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {1, 1, 0, 1},
                                        {0, 0, 1, 1}, {1, 0, 1, 1}, {0, 1, 1, 1}, {1, 1, 1, 1}};
    size_t x = 0, found = 0;
    for (; x + 4 <= width; x += 4, bits >>= 4)
        memcpy(to + x, four[bits & 15], 4);
    for (; x < width; x++, bits >>= 1)
        to[x] = bits & 1;
    for (x = 0; x < width; x++)
        found += to[x];
    return found;
}

static size_t get_cell(uint8_t *which, const cvol_mask *mask, const part *p, const size_t begin[3],
                       const size_t size[3])
{
    const uint8_t state = mask->states[p->cell];
    const uint64_t *bitmap = mask->bitmaps[p->cell];
    const size_t width = p->hi[0] - p->lo[0];
    size_t found = 0;
    for (size_t z = p->lo[2]; z < p->hi[2]; z++)
        for (size_t y = p->lo[1]; y < p->hi[1]; y++) {
            uint8_t *to = which + (p->lo[0] - begin[0]) +
                          size[0] * (y - begin[1] + size[1] * (z - begin[2]));
            if (state != MIXED) {
                memset(to, state, width);
                found += state ? width : 0;
                continue;
            }
            if (mask->planes == 1) {
                const size_t bit = bit_of(p->lo[0], y, z);
                const uint32_t line = (uint32_t)(bitmap[bit / 64] >> bit % 64);
                found += copy_bits(to, line, width);
                continue;
            }
            for (size_t x = 0; x < width; x++) {
                const size_t bit = bit_of(p->lo[0] + x, y, z);
                uint64_t value = 0;
                for (int plane = 0; plane < mask->planes; plane++)
                    value |= (bitmap[plane * WORDS + (int)(bit / 64)] >> bit % 64 & 1) << plane;
                to[x] = (uint8_t)value;
                found += value != 0;
            }
        }
    return found;
}

int cvol_mask_set(cvol_mask *mask, const uint8_t *which, const size_t begin[3], const size_t end[3])
{
    const size_t size[3] = {end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]};
    for (size_t l = begin[2] / CELL; l * CELL < end[2]; l++)
        for (size_t j = begin[1] / CELL; j * CELL < end[1]; j++)
            for (size_t i = begin[0] / CELL; i * CELL < end[0]; i++) {
                const size_t place[3] = {i, j, l};
                const part p = part_of(mask, place, begin, end);
                if (!set_cell(mask, &p, which, begin, size))
                    return 0;
            }
    return 1;
}

size_t cvol_mask_get(uint8_t *which, const cvol_mask *mask, const size_t begin[3],
                     const size_t end[3])
{
    const size_t size[3] = {end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]};
    size_t found = 0;
    for (size_t l = begin[2] / CELL; l * CELL < end[2]; l++)
        for (size_t j = begin[1] / CELL; j * CELL < end[1]; j++)
            for (size_t i = begin[0] / CELL; i * CELL < end[0]; i++) {
                const size_t place[3] = {i, j, l};
                const part p = part_of(mask, place, begin, end);
                found += get_cell(which, mask, &p, begin, size);
            }
    return found;
}

cvol_mask_state cvol_mask_cell(const cvol_mask *mask, const size_t cell[3])
{
    const uint8_t state =
        mask->states[cell[0] + mask->cells[0] * (cell[1] + mask->cells[1] * cell[2])];
    return state == 0 ? CVOL_MASK_NONE : state == MIXED ? CVOL_MASK_SOME : CVOL_MASK_ALL;
}

uint64_t cvol_mask_samples(const cvol_mask *mask)
{
    uint64_t count = 0;
    for (size_t i = 0; i < cell_count(mask); i++) {
        const size_t place[3] = {i % mask->cells[0], i / mask->cells[0] % mask->cells[1],
                                 i / mask->cells[0] / mask->cells[1]};
        const size_t zero[3] = {0, 0, 0};
        const part p = part_of(mask, place, zero, mask->dims);
        uint8_t which[CELL * CELL * CELL];
        const size_t size[3] = {p.hi[0] - p.lo[0], p.hi[1] - p.lo[1], p.hi[2] - p.lo[2]};
        if (mask->states[i])
            count += get_cell(which, mask, &p, p.lo, size);
    }
    return count;
}

uint64_t cvol_mask_bytes(const cvol_mask *mask)
{
    uint64_t bytes = sizeof *mask + cell_count(mask) * (1 + sizeof *mask->bitmaps);
    for (size_t i = 0; i < cell_count(mask); i++)
        if (mask->bitmaps[i])
            bytes += (uint64_t)mask->planes * WORDS * sizeof **mask->bitmaps;
    return bytes;
}
