/* Writing TIFF: a page for each slice, raw and contiguous behind the file's header, followed by the
 * pages' directories; BigTIFF beyond 4 GiB. Spacing and unit are written as ImageJ writes them
 * (stack.c), or in an OME-TIFF as OME does (ome.c); origin and directions have no place in a
 * TIFF. */
#define _GNU_SOURCE
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/context.h"
#include "volume/formats/tiff/ome.h"
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

/* A page's directory, with a description unless its size is 0. */
typedef struct page {
    uint64_t samples, bytes; /* their offset and number */
    uint64_t resolution;     /* offset of two fractions */
    uint64_t description, description_size;
    int is_one_of_several;
} page;

enum { ENTRIES = 15 }; /* with a description */

static uint64_t directory_bytes(int big, int has_description)
{
    const uint64_t entries = ENTRIES - !has_description;
    return big ? 8 + 20 * entries + 8 : 2 + 12 * entries + 4;
}

static void put_directory(plan *p, const cvol_grid *grid, const page *of, uint64_t next)
{
    const int entries = ENTRIES - !of->description_size;
    if (p->big)
        cvol_bytes_put_u64(p->bytes, (uint64_t)entries);
    else
        cvol_bytes_put_u16(p->bytes, (uint16_t)entries);
    put_entry(p, 254, LONG, 1, of->is_one_of_several ? 2 : 0);
    put_entry(p, 256, LONG, 1, grid->dims[0]);
    put_entry(p, 257, LONG, 1, grid->dims[1]);
    put_entry(p, 258, SHORT, 1, 8 * cvol_type_size(grid->type));
    put_entry(p, 259, SHORT, 1, 1); /* raw */
    put_entry(p, 262, SHORT, 1, 1); /* least is black */
    if (of->description_size)
        put_entry(p, 270, ASCII, of->description_size, of->description);
    put_entry(p, 273, p->big ? LONG8 : LONG, 1, of->samples);
    put_entry(p, 277, SHORT, 1, 1);
    put_entry(p, 278, LONG, 1, grid->dims[1]);
    put_entry(p, 279, p->big ? LONG8 : LONG, 1, of->bytes);
    put_entry(p, 282, RATIONAL, 1, of->resolution);
    put_entry(p, 283, RATIONAL, 1, of->resolution + 8);
    put_entry(p, 296, SHORT, 1, 1); /* no TIFF unit */
    put_entry(p, 339, SHORT, 1, sample_format(grid->type));
    put_wide(p, next);
}

int cvol_tiff_plan(cvol_context *context, cvol_write_plan *out, const cvol_grid *grid,
                   const char *path)
{
    const int is_ome = cvol_tiff_is_ome(path);
    const size_t pages = grid->dims[2] * (size_t)out->series->times * (size_t)out->series->channels;
    const uint64_t page_bytes = cvol_grid_bytes(grid) / grid->dims[2], bytes = page_bytes * pages;
    if (grid->dims[0] > UINT32_MAX || grid->dims[1] > UINT32_MAX)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: %zu x %zu pixels are more than a TIFF page can have", path,
                         grid->dims[0], grid->dims[1]);
    /* 240 bytes are more than a directory takes, and than the description has for a channel. */
    const int big = bytes + 2048 + 240 * ((uint64_t)pages + (uint64_t)out->series->channels) >
                    UINT32_MAX;
    plan p = {&out->trailer, big};
    const uint64_t begin = big ? 16 : 8;
    /* Behind the samples, at even offsets: resolutions, the description, the directories. */
    if (bytes & 1)
        cvol_bytes_put_u8(p.bytes, 0);
    page of = {.bytes = page_bytes,
               .resolution = begin + bytes + (bytes & 1),
               .is_one_of_several = pages > 1};
    put_rational(p.bytes, 1 / grid->spacing[0]);
    put_rational(p.bytes, 1 / grid->spacing[1]);
    of.description = of.resolution + 16;
    if (is_ome)
        cvol_tiff_put_ome(p.bytes, grid, out->series);
    else
        put_description(p.bytes, grid);
    of.description_size = begin + bytes + p.bytes->size - of.description;
    while (p.bytes->size & 7 && !p.bytes->failed)
        cvol_bytes_put_u8(p.bytes, 0);
    if ((bytes + p.bytes->size) & 1)
        cvol_bytes_put_u8(p.bytes, 0);
    const uint64_t first = begin + bytes + p.bytes->size;
    uint64_t next = first;
    for (size_t i = 0; i < pages && !p.bytes->failed; i++) {
        of.samples = begin + i * page_bytes;
        if (i && is_ome) /* only the first page has OME's */
            of.description_size = 0;
        next += directory_bytes(big, of.description_size != 0);
        put_directory(&p, grid, &of, i + 1 < pages ? next : 0);
    }
    p.bytes = &out->header;
    cvol_bytes_append(p.bytes, big ? "II+\0\10\0\0\0" : "II*\0", big ? 8 : 4);
    put_wide(&p, first);
    out->encoding = CVOL_ENCODING_RAW;
    return CVOL_OK;
}
