/* Writing TIFF: a page for each slice, raw and contiguous behind the file's header, followed by the
 * pages' directories; BigTIFF beyond 4 GiB. Spacing and unit are written as ImageJ writes them
 * (stack.c), or in an OME-TIFF as OME does (ome.c); origin and directions have no place in a
 * TIFF. Components of colours share pages: each is a strip of its own (planar configuration), as
 * the volumes follow each other in the file. */
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

/* `value`: a number, or the offset of several. */
static void put_entry(plan *p, uint16_t tag, uint16_t type, uint64_t count, uint64_t value)
{
    cvol_bytes_put_u16(p->bytes, tag);
    cvol_bytes_put_u16(p->bytes, type);
    put_wide(p, count);
    put_wide(p, value);
}

/* `count` equal numbers: in the entry if they fit there, or else at `offset` of the file. */
static void put_shorts(plan *p, uint16_t tag, unsigned count, uint16_t value, uint64_t offset)
{
    const unsigned room = p->big ? 4 : 2;
    cvol_bytes_put_u16(p->bytes, tag);
    cvol_bytes_put_u16(p->bytes, SHORT);
    put_wide(p, count);
    if (count > room)
        put_wide(p, offset);
    for (unsigned i = 0; i < room && count <= room; i++)
        cvol_bytes_put_u16(p->bytes, i < count ? value : 0);
}

static void put_short(plan *p, uint16_t tag, uint16_t value)
{
    put_shorts(p, tag, 1, value, 0);
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

/* The resolution: in the entry of a BigTIFF, or else at `offset` of the file. */
static void put_resolution(plan *p, uint16_t tag, double spacing, uint64_t offset)
{
    cvol_bytes_put_u16(p->bytes, tag);
    cvol_bytes_put_u16(p->bytes, RATIONAL);
    put_wide(p, 1);
    if (p->big)
        put_rational(p->bytes, 1 / spacing);
    else
        put_wide(p, offset);
}

/* The pages of a file. The samples of a page are `planes` strips, `distance` bytes apart. */
typedef struct pages {
    uint64_t count;
    unsigned planes;
    uint64_t begin, strip_bytes, distance;
    /* Offsets: two fractions; a text; for several planes their bits, their formats, the bytes of
     * their strips, and for each page the offsets of its strips. */
    uint64_t resolution, description, bits, formats, bytes, strips;
    uint64_t description_size;
} pages;

enum { ENTRIES = 14 }; /* without a description, for one plane */

static unsigned entries_of(const pages *of, int has_description)
{
    return ENTRIES + (unsigned)has_description + (of->planes > 1) + (of->planes > 3);
}

static uint64_t directory_bytes(const plan *p, const pages *of, int has_description)
{
    const uint64_t entries = entries_of(of, has_description);
    return p->big ? 8 + 20 * entries + 8 : 2 + 12 * entries + 4;
}

/* The offset of the first strip of a page. Pages of a time follow each other, and the strips of
 * the other planes are those of the next channels. */
static uint64_t first_strip(const pages *of, uint64_t page)
{
    const uint64_t slices = of->distance / of->strip_bytes, time = page / slices;
    return of->begin + time * of->planes * of->distance + page % slices * of->strip_bytes;
}

static void put_directory(plan *p, const cvol_grid *grid, const pages *of, uint64_t page,
                          int has_description, uint64_t next)
{
    const uint16_t wide = p->big ? LONG8 : LONG;
    const unsigned entries = entries_of(of, has_description), planes = of->planes;
    const uint64_t strips = of->strips + page * planes * (p->big ? 8 : 4);
    if (p->big)
        cvol_bytes_put_u64(p->bytes, entries);
    else
        cvol_bytes_put_u16(p->bytes, (uint16_t)entries);
    put_entry(p, 254, LONG, 1, of->count > 1 ? 2 : 0);
    put_entry(p, 256, LONG, 1, grid->dims[0]);
    put_entry(p, 257, LONG, 1, grid->dims[1]);
    put_shorts(p, 258, planes, (uint16_t)(8 * cvol_type_size(grid->type)), of->bits);
    put_short(p, 259, 1);                  /* raw */
    put_short(p, 262, planes > 1 ? 2 : 1); /* RGB; the least is black */
    if (has_description)
        put_entry(p, 270, ASCII, of->description_size, of->description);
    put_entry(p, 273, wide, planes, planes > 1 ? strips : first_strip(of, page));
    put_short(p, 277, (uint16_t)planes);
    put_entry(p, 278, LONG, 1, grid->dims[1]);
    put_entry(p, 279, wide, planes, planes > 1 ? of->bytes : of->strip_bytes);
    put_resolution(p, 282, grid->spacing[0], of->resolution);
    put_resolution(p, 283, grid->spacing[1], of->resolution + 8);
    if (planes > 1)
        put_short(p, 284, 2); /* each component by itself */
    put_short(p, 296, 1);     /* no TIFF unit */
    if (planes > 3)
        put_short(p, 338, 2); /* alpha, by which colours are not multiplied */
    put_shorts(p, 339, planes, sample_format(grid->type), of->formats);
    put_wide(p, next);
}

/* The offset of the next byte behind the samples, which is even. */
static uint64_t here(const plan *p, const pages *of, uint64_t bytes)
{
    if ((bytes + p->bytes->size) & 1)
        cvol_bytes_put_u8(p->bytes, 0);
    return of->begin + bytes + p->bytes->size;
}

/* Lists of numbers of several planes, behind `bytes` of samples. */
static void put_lists(plan *p, const cvol_grid *grid, pages *of, uint64_t bytes)
{
    of->bits = here(p, of, bytes);
    for (unsigned i = 0; i < of->planes; i++)
        cvol_bytes_put_u16(p->bytes, (uint16_t)(8 * cvol_type_size(grid->type)));
    of->formats = here(p, of, bytes);
    for (unsigned i = 0; i < of->planes; i++)
        cvol_bytes_put_u16(p->bytes, sample_format(grid->type));
    of->bytes = here(p, of, bytes);
    for (unsigned i = 0; i < of->planes; i++)
        put_wide(p, of->strip_bytes);
    of->strips = here(p, of, bytes);
    for (uint64_t page = 0; page < of->count && !p->bytes->failed; page++)
        for (unsigned i = 0; i < of->planes; i++)
            put_wide(p, first_strip(of, page) + i * of->distance);
}

int cvol_tiff_plan(cvol_context *context, cvol_write_plan *out, const cvol_grid *grid,
                   const char *path)
{
    const cvol_series_options *series = out->series;
    const int is_ome = cvol_tiff_is_ome(path);
    const uint64_t volumes = (uint64_t)series->times * (uint64_t)series->channels;
    const uint64_t bytes = cvol_grid_bytes(grid) * volumes;
    pages of = {.planes = is_ome ? cvol_tiff_ome_components(grid, series) : 1,
                .strip_bytes = cvol_grid_bytes(grid) / grid->dims[2],
                .distance = cvol_grid_bytes(grid)};
    of.count = grid->dims[2] * volumes / of.planes;
    if (grid->dims[0] > UINT32_MAX || grid->dims[1] > UINT32_MAX)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: %zu x %zu pixels are more than a TIFF page can have", path,
                         grid->dims[0], grid->dims[1]);
    /* 240 bytes are more than a directory and its strips' offsets take, and than the description
     * has for a channel. */
    plan p = {&out->trailer,
              bytes + 2048 + 240 * (of.count + (uint64_t)series->channels) > UINT32_MAX};
    of.begin = p.big ? 16 : 8;
    of.resolution = here(&p, &of, bytes);
    for (int a = 0; a < 2 && !p.big; a++)
        put_rational(p.bytes, 1 / grid->spacing[a]);
    of.description = here(&p, &of, bytes);
    if (is_ome)
        cvol_tiff_put_ome(p.bytes, grid, series);
    else
        put_description(p.bytes, grid);
    of.description_size = of.begin + bytes + p.bytes->size - of.description;
    if (of.planes > 1)
        put_lists(&p, grid, &of, bytes);
    while (p.bytes->size & 7 && !p.bytes->failed)
        cvol_bytes_put_u8(p.bytes, 0);
    const uint64_t first = here(&p, &of, bytes);
    uint64_t next = first;
    for (uint64_t i = 0; i < of.count && !p.bytes->failed; i++) {
        const int is_described = !(i && is_ome); /* only the first page has OME's */
        next += directory_bytes(&p, &of, is_described);
        put_directory(&p, grid, &of, i, is_described, i + 1 < of.count ? next : 0);
    }
    p.bytes = &out->header;
    cvol_bytes_append(p.bytes, p.big ? "II+\0\10\0\0\0" : "II*\0", p.big ? 8 : 4);
    put_wide(&p, first);
    out->encoding = CVOL_ENCODING_RAW;
    return CVOL_OK;
}
