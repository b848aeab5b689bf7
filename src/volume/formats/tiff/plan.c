/* Writing TIFF: a page for each slice, raw and contiguous behind the file's header, followed by the
 * pages' directories; BigTIFF beyond 4 GiB. Spacing and unit are written as ImageJ writes them
 * (stack.c); origin and directions have no place in a TIFF. */
#define _GNU_SOURCE
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/context.h"
#include "volume/io/format.h"
#include "volume/io/text.h"

enum { SHORT = 3, LONG = 4, RATIONAL = 5, ASCII = 2, LONG8 = 16 };

typedef struct plan {
    cvol_bytes *bytes;
    int big;
} plan;

/* Writes a number or an offset, in the width of the file. */
static void put_wide(plan *p, uint64_t value)
{
    if (p->big)
        cvol_bytes_put_u64(p->bytes, value);
    else
        cvol_bytes_put_u32(p->bytes, (uint32_t)value);
}

static void put_entry(plan *p, uint16_t tag, uint16_t type, uint64_t count, uint64_t value)
{
    cvol_bytes_put_u16(p->bytes, tag);
    cvol_bytes_put_u16(p->bytes, type);
    put_wide(p, count);
    if (type == SHORT) {
        cvol_bytes_put_u16(p->bytes, (uint16_t)value);
        cvol_bytes_put_u16(p->bytes, 0);
        if (p->big)
            cvol_bytes_put_u32(p->bytes, 0);
    } else
        put_wide(p, value);
}

/* The fraction of 32-bit integers closest to value > 0, by its continued fraction. */
static void put_rational(cvol_bytes *bytes, double value)
{
    double p0 = 0, p1 = 1, q0 = 1, q1 = 0, rest = value;
    for (int i = 0; i < 40; i++) {
        double whole = floor(rest), p = whole * p1 + p0, q = whole * q1 + q0;
        if (p > UINT32_MAX || q > UINT32_MAX)
            break;
        p0 = p1, q0 = q1, p1 = p, q1 = q;
        if (rest - whole < DBL_EPSILON * value || fabs(p - value * q) <= 1e-15 * p)
            break;
        rest = 1 / (rest - whole);
    }
    const int fits = p1 > 0 && q1 > 0;
    cvol_bytes_put_u32(bytes, fits ? (uint32_t)p1 : 1);
    cvol_bytes_put_u32(bytes, fits ? (uint32_t)q1 : 1);
}

static void put_description(cvol_bytes *bytes, const cvol_grid *grid)
{
    char line[120], number[CVOL_TEXT_NUMBER_BYTES];
    snprintf(line, sizeof line, "ImageJ=1.53c\nimages=%zu\nslices=%zu\n", grid->dims[2],
             grid->dims[2]);
    cvol_bytes_put_text(bytes, line);
    if (grid->unit[0] && !strpbrk(grid->unit, "\r\n")) {
        snprintf(line, sizeof line, "unit=%.15s\n",
                 !strcmp(grid->unit, "um") ? "micron" : grid->unit);
        cvol_bytes_put_text(bytes, line);
    }
    cvol_text_format(number, grid->spacing[2]);
    snprintf(line, sizeof line, "spacing=%s\nloop=false\n", number);
    cvol_bytes_put_text(bytes, line);
    cvol_bytes_put_u8(bytes, 0);
}

/* 1: unsigned, 2: signed, 3: float. */
static uint16_t sample_format(cvol_type type)
{
    return cvol_type_is_integer(type)
               ? (type == CVOL_INT8 || type == CVOL_INT16 || type == CVOL_INT32 ? 2 : 1)
               : 3;
}

int cvol_tiff_plan(cvol_context *context, cvol_write_plan *out, const cvol_grid *grid,
                   const char *path)
{
    enum { ENTRIES = 15 };
    const uint64_t bytes = cvol_grid_bytes(grid), page = bytes / grid->dims[2];
    if (grid->dims[0] > UINT32_MAX || grid->dims[1] > UINT32_MAX)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: %zu x %zu pixels are more than a TIFF page can have", path,
                         grid->dims[0], grid->dims[1]);
    /* 240 bytes are more than a directory of 15 entries takes. */
    const int big = bytes + 1024 + 240 * (uint64_t)grid->dims[2] > UINT32_MAX;
    plan p = {&out->trailer, big};
    const uint64_t begin = big ? 16 : 8;
    const size_t directory = big ? 8 + 20 * ENTRIES + 8 : 2 + 12 * ENTRIES + 4;
    /* Behind the samples, at even offsets: resolutions, the description, the directories. */
    if (bytes & 1)
        cvol_bytes_put_u8(p.bytes, 0);
    const uint64_t resolution = begin + bytes + (bytes & 1);
    put_rational(p.bytes, 1 / grid->spacing[0]);
    put_rational(p.bytes, 1 / grid->spacing[1]);
    put_description(p.bytes, grid);
    const uint64_t description = resolution + 16,
                   text = begin + bytes + p.bytes->size - description;
    while (p.bytes->size & 7 && !p.bytes->failed)
        cvol_bytes_put_u8(p.bytes, 0);
    if ((bytes + p.bytes->size) & 1)
        cvol_bytes_put_u8(p.bytes, 0);
    const uint64_t first = begin + bytes + p.bytes->size;
    for (size_t z = 0; z < grid->dims[2]; z++) {
        if (big)
            cvol_bytes_put_u64(p.bytes, ENTRIES);
        else
            cvol_bytes_put_u16(p.bytes, ENTRIES);
        put_entry(&p, 254, LONG, 1, grid->dims[2] > 1 ? 2 : 0); /* one of several pages */
        put_entry(&p, 256, LONG, 1, grid->dims[0]);
        put_entry(&p, 257, LONG, 1, grid->dims[1]);
        put_entry(&p, 258, SHORT, 1, 8 * cvol_type_size(grid->type));
        put_entry(&p, 259, SHORT, 1, 1); /* raw */
        put_entry(&p, 262, SHORT, 1, 1); /* least is black */
        put_entry(&p, 270, ASCII, text, description);
        put_entry(&p, 273, big ? LONG8 : LONG, 1, begin + z * page);
        put_entry(&p, 277, SHORT, 1, 1);
        put_entry(&p, 278, LONG, 1, grid->dims[1]);
        put_entry(&p, 279, big ? LONG8 : LONG, 1, page);
        put_entry(&p, 282, RATIONAL, 1, resolution);
        put_entry(&p, 283, RATIONAL, 1, resolution + 8);
        put_entry(&p, 296, SHORT, 1, 1); /* no TIFF unit */
        put_entry(&p, 339, SHORT, 1, sample_format(grid->type));
        put_wide(&p, z + 1 < grid->dims[2] ? first + (z + 1) * directory : 0);
    }
    p.bytes = &out->header;
    cvol_bytes_append(p.bytes, big ? "II+\0\10\0\0\0" : "II*\0", big ? 8 : 4);
    put_wide(&p, first);
    out->encoding = CVOL_ENCODING_RAW;
    return CVOL_OK;
}
