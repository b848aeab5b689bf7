/* Masks of volumes (mask.h). */
#include "array/core/mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/words.h"
#include "base/context.h"
#include "base/memory.h"

enum { CELL = CVOL_MASK_CELL, MIXED = CVOL_MASK_MIXED };

struct cvol_mask {
    size_t dims[3], cells[3];
    cvol_fills fills;
    int planes;                 /* bits that distinguish the fills and "none" */
    uint8_t *states;            /* of each block: 0, one fill everywhere (1 ..), or MIXED */
    cvol_mask_rows **planes_of; /* of mixed blocks: rows of each bit */
};

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
    mask->planes_of = sized ? calloc(count, sizeof *mask->planes_of) : NULL;
    if (!mask->states || !mask->planes_of) {
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
    for (size_t i = 0; mask->planes_of && i < cell_count(mask); i++)
        free(mask->planes_of[i]);
    free(mask->planes_of);
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

/* A block's part of a box. */
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

/* Allocates the rows of a block, all 0. */
static cvol_mask_rows *make_planes(cvol_mask *mask, size_t cell)
{
    if (!mask->planes_of[cell])
        mask->planes_of[cell] = malloc((size_t)mask->planes * sizeof(cvol_mask_rows));
    if (mask->planes_of[cell])
        memset(mask->planes_of[cell], 0, (size_t)mask->planes * sizeof(cvol_mask_rows));
    return mask->planes_of[cell];
}

static void set_state(cvol_mask *mask, size_t cell, uint8_t state)
{
    mask->states[cell] = state;
    if (state != MIXED) {
        free(mask->planes_of[cell]);
        mask->planes_of[cell] = NULL;
    }
}

static size_t row_of(size_t y, size_t z)
{
    return y % CELL + CELL * (z % CELL);
}

/* One plane of some samples, the first one in the low bit. */
static uint16_t pack_row(const uint8_t *from, size_t width, int plane)
{
    uint32_t row = 0;
    for (size_t x = 0; x < width; x++)
        row |= ((uint32_t)from[x] >> plane & 1) << x;
    return (uint16_t)row;
}

static int set_cell(cvol_mask *mask, const part *p, const uint8_t *which, const size_t begin[3],
                    const size_t size[3])
{
    const uint8_t *from = which + (p->lo[0] - begin[0]) +
                          size[0] * (p->lo[1] - begin[1] + size[1] * (p->lo[2] - begin[2]));
    const size_t width = p->hi[0] - p->lo[0];
    uint8_t alike[CELL];
    int same = 1;
    memset(alike, *from, sizeof alike);
    for (size_t z = 0; z < p->hi[2] - p->lo[2] && same; z++)
        for (size_t y = 0; y < p->hi[1] - p->lo[1] && same; y++)
            same = memcmp(from + size[0] * (y + size[1] * z), alike, width) == 0;
    set_state(mask, p->cell, same ? *from : MIXED);
    if (same)
        return 1;
    cvol_mask_rows *planes = make_planes(mask, p->cell);
    if (!planes) {
        set_state(mask, p->cell, 0);
        return 0;
    }
    for (size_t z = p->lo[2]; z < p->hi[2]; z++)
        for (size_t y = p->lo[1]; y < p->hi[1]; y++) {
            const uint8_t *row = from + size[0] * (y - p->lo[1] + size[1] * (z - p->lo[2]));
            for (int plane = 0; plane < mask->planes; plane++)
                planes[plane].of[row_of(y, z)] = pack_row(row, width, plane);
        }
    return 1;
}

/* Writes the lowest `width` bits (at most 16), one byte each; returns how many are 1. */
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
    const cvol_mask_rows *planes = mask->planes_of[p->cell];
    const size_t width = p->hi[0] - p->lo[0], shift = p->lo[0] % CELL;
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
                found += copy_bits(to, (uint32_t)planes[0].of[row_of(y, z)] >> shift, width);
                continue;
            }
            for (size_t x = 0; x < width; x++) {
                uint32_t value = 0;
                for (int plane = 0; plane < mask->planes; plane++)
                    value |= ((uint32_t)planes[plane].of[row_of(y, z)] >> (shift + x) & 1) << plane;
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

int cvol_mask_set_fills(cvol_context *context, cvol_mask **mask, const cvol_fills *fills)
{
    const cvol_mask *from = *mask;
    cvol_fills united = {.background = fills->background};
    uint8_t number[CVOL_FILLS_MAX + 1], which[CELL * CELL * CELL];
    cvol_fills_unite(number, &united, fills);
    if (united.count == fills->count) {
        (*mask)->fills = *fills;
        return CVOL_OK;
    }
    cvol_mask *to;
    int code = cvol_mask_create(context, &to, from->dims, &united);
    for (size_t i = 0; i < cell_count(from) && !code; i++) {
        size_t begin[3] = {i, i / from->cells[0], i / from->cells[0] / from->cells[1]}, end[3];
        for (int a = 0; a < 3; a++) {
            begin[a] = begin[a] % from->cells[a] * CELL;
            end[a] = least(begin[a] + CELL, from->dims[a]);
        }
        if (!cvol_mask_get(which, from, begin, end))
            continue;
        const size_t count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
        for (size_t s = 0; s < count; s++)
            which[s] = number[which[s]];
        if (!cvol_mask_set(to, which, begin, end))
            code = cvol_fail_memory(context, sizeof which, "a mask's cells");
    }
    cvol_mask_free(code ? to : *mask);
    *mask = code ? *mask : to;
    return code;
}

uint8_t cvol_mask_cell_get(const cvol_mask *mask, const size_t cell[3], const cvol_mask_rows **rows)
{
    const size_t i = cell[0] + mask->cells[0] * (cell[1] + mask->cells[1] * cell[2]);
    *rows = mask->planes_of[i];
    return mask->states[i];
}

int cvol_mask_cell_put(cvol_mask *mask, const size_t cell[3], uint8_t state,
                       const cvol_mask_rows *rows)
{
    const size_t i = cell[0] + mask->cells[0] * (cell[1] + mask->cells[1] * cell[2]);
    if (state == MIXED) {
        cvol_mask_rows *planes = make_planes(mask, i);
        if (!planes)
            return 0;
        memcpy(planes, rows, (size_t)mask->planes * sizeof *planes);
    }
    set_state(mask, i, state);
    return 1;
}

/* Writes the pattern to the samples of a row whose bit is set, by runs of equal bits. */
static void write_row(uint8_t *to, size_t size, uint64_t pattern, uint32_t row)
{
#define FILL(word)                    \
    for (int x = first; x < end; x++) \
    ((word *)(void *)to)[x] = (word)pattern
    if (size == 1 && row == UINT16_MAX) {
        memset(to, (int)(pattern & 255), CELL);
        return;
    }
    while (row) {
        const int first = __builtin_ctz(row), end = first + __builtin_ctz(~(row >> first));
        CVOL_FOR_BYTES(size, FILL)
        row &= UINT32_MAX << end;
    }
#undef FILL
}

static void write_cell(uint8_t *samples, size_t size, const uint64_t *patterns,
                       const cvol_mask *mask, const part *p, const size_t begin[3],
                       const size_t strides[2])
{
    const uint8_t state = mask->states[p->cell];
    const cvol_mask_rows *planes = mask->planes_of[p->cell];
    const size_t shift = p->lo[0] % CELL;
    const uint32_t inside = (1u << (p->hi[0] - p->lo[0])) - 1;
    for (size_t z = p->lo[2]; z < p->hi[2]; z++)
        for (size_t y = p->lo[1]; y < p->hi[1]; y++) {
            uint8_t *to = samples + size * ((p->lo[0] - begin[0]) + strides[0] * (y - begin[1]) +
                                            strides[1] * (z - begin[2]));
            for (int f = 0; f < mask->fills.count; f++) {
                uint32_t row = state == f + 1 ? inside : 0;
                if (state == MIXED) {
                    row = inside;
                    for (int plane = 0; plane < mask->planes; plane++) {
                        const uint32_t bits = (uint32_t)planes[plane].of[row_of(y, z)] >> shift;
                        row &= (f + 1) >> plane & 1 ? bits : ~bits;
                    }
                }
                write_row(to, size, patterns[f], row);
            }
        }
}

void cvol_mask_write(void *samples, size_t size, const uint64_t patterns[CVOL_FILLS_MAX],
                     const cvol_mask *mask, const size_t begin[3], const size_t end[3])
{
    const size_t strides[2] = {end[0] - begin[0], (end[0] - begin[0]) * (end[1] - begin[1])};
    for (size_t l = begin[2] / CELL; l * CELL < end[2]; l++)
        for (size_t j = begin[1] / CELL; j * CELL < end[1]; j++)
            for (size_t i = begin[0] / CELL; i * CELL < end[0]; i++) {
                const part p = part_of(mask, (size_t[3]){i, j, l}, begin, end);
                if (mask->states[p.cell])
                    write_cell(samples, size, patterns, mask, &p, begin, strides);
            }
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
        const part p = part_of(mask, place, (size_t[3]){0, 0, 0}, mask->dims);
        const cvol_mask_rows *planes = mask->planes_of[i];
        if (mask->states[i] != MIXED) {
            count += mask->states[i]
                         ? (p.hi[0] - p.lo[0]) * (p.hi[1] - p.lo[1]) * (p.hi[2] - p.lo[2])
                         : 0;
            continue;
        }
        for (int row = 0; row < CVOL_MASK_ROWS; row++) {
            uint32_t masked = 0;
            for (int plane = 0; plane < mask->planes; plane++)
                masked |= planes[plane].of[row];
            count += (uint64_t)__builtin_popcount(masked);
        }
    }
    return count;
}

uint64_t cvol_mask_bytes(const cvol_mask *mask)
{
    uint64_t bytes = sizeof *mask + cell_count(mask) * (1 + sizeof *mask->planes_of);
    for (size_t i = 0; i < cell_count(mask); i++)
        if (mask->planes_of[i])
            bytes += (uint64_t)mask->planes * sizeof **mask->planes_of;
    return bytes;
}
