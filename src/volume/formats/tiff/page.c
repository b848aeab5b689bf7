/* Pages of TIFF files, by libtiff, without its printing and memory mapping, and with a limit of
 * memory. Its errors become part of our messages. libtiff takes a page for the last one if it
 * cannot read the offset of the next; so the functions here read for it, and a page whose reading
 * failed or met the end of the file is an error. Before it allocates memory, the reader checks that
 * strips and tiles lie within the file and have enough bytes for their packed samples. */
#define _GNU_SOURCE
#include "volume/formats/tiff/page.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/io/input.h"
#include "volume/io/strided.h"

struct cvol_tiff_file {
    TIFF *tiff;
    char *path;
    cvol_input input;
    uint64_t position;
    int lacks_bytes;   /* a read failed, or found fewer bytes than requested */
    char message[200]; /* the first error of libtiff */
    int reason;        /* errno at that error; 0: an error of the file */
};

/* ---- opening ------------------------------------------------------------------------- */

static int keep_tiff_error(TIFF *tiff, void *user, const char *module, const char *format,
                           va_list values)
{
    cvol_tiff_file *file = user;
    const int reason = errno;
    (void)tiff, (void)module;
    if (file->message[0])
        return 1;
    if (!file->reason)
        file->reason = reason;
    vsnprintf(file->message, sizeof file->message, format, values);
    for (char *c = file->message; *c; c++)
        if (*c < ' ' || *c > '~')
            *c = '?';
    return 1;
}

static int ignore_warning(TIFF *tiff, void *user, const char *module, const char *format,
                          va_list values)
{
    (void)tiff, (void)user, (void)module, (void)format, (void)values;
    return 1;
}

static int fail_damaged(cvol_context *context, const cvol_tiff_file *file, const char *what)
{
    const char *detail = file->message[0]                     ? file->message
                         : file->lacks_bytes && !file->reason ? "the file ends within it"
                                                              : "";
    return cvol_fail(context,
                     !file->reason            ? CVOL_ERROR_FORMAT
                     : file->reason == ENOMEM ? CVOL_ERROR_MEMORY
                                              : CVOL_ERROR_IO,
                     "%s: %s cannot be read%s%s%s%s", file->path, what, detail[0] ? ": " : "",
                     detail, file->reason ? ": " : "", file->reason ? strerror(file->reason) : "");
}

/* Before calls of libtiff, so that keep_tiff_error finds the errno of these calls. */
static void forget_error(cvol_tiff_file *file)
{
    file->message[0] = '\0';
    file->reason = file->lacks_bytes = 0;
    errno = 0;
}

static tmsize_t read_for_tiff(thandle_t user, void *data, tmsize_t size)
{
    cvol_tiff_file *file = user;
    cvol_context unused = {.limit_bytes = 0}; /* for its message */
    size_t got = 0;
    const int code = cvol_input_read(&unused, &file->input, file->position, data, (size_t)size,
                                     &got);
    if (code && !file->reason)
        file->reason = errno;
    if (code || got < (size_t)size)
        file->lacks_bytes = 1;
    file->position += got;
    return code ? -1 : (tmsize_t)got;
}

static tmsize_t refuse_to_write(thandle_t user, void *data, tmsize_t size)
{
    (void)user, (void)data, (void)size;
    return -1;
}

static toff_t seek_for_tiff(thandle_t user, toff_t offset, int whence)
{
    cvol_tiff_file *file = user;
    file->position = offset + (whence == SEEK_CUR   ? file->position
                               : whence == SEEK_END ? file->input.size
                                                    : 0);
    return file->position;
}

static toff_t size_for_tiff(thandle_t user)
{
    return ((const cvol_tiff_file *)user)->input.size;
}

/* cvol_tiff_close closes the input: libtiff does not after a failed opening. */
static int close_nothing(thandle_t user)
{
    (void)user;
    return 0;
}

int cvol_tiff_open(cvol_context *context, cvol_tiff_file **out, const char *path)
{
    *out = NULL;
    cvol_tiff_file *file = calloc(1, sizeof *file);
    if (!file)
        return cvol_fail_memory(context, sizeof *file, path);
    file->input.fd = -1;
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    file->path = strdup(path);
    int code = options && file->path ? cvol_input_open(context, &file->input, file->path)
                                     : cvol_fail_memory(context, sizeof *file, path);
    if (!code) {
        TIFFOpenOptionsSetErrorHandlerExtR(options, keep_tiff_error, file);
        TIFFOpenOptionsSetWarningHandlerExtR(options, ignore_warning, file);
        const uint64_t most = context->limit_bytes < PTRDIFF_MAX / 2 ? context->limit_bytes
                                                                     : PTRDIFF_MAX / 2;
        TIFFOpenOptionsSetMaxSingleMemAlloc(options, (tmsize_t)(most + (1 << 20)));
        forget_error(file);
        file->tiff = TIFFClientOpenExt(path, "rm", file, read_for_tiff, refuse_to_write,
                                       seek_for_tiff, close_nothing, size_for_tiff, NULL, NULL,
                                       options); /* m: not mapped */
        if (!file->tiff || file->lacks_bytes)
            code = fail_damaged(context, file, "its first page");
    }
    TIFFOpenOptionsFree(options);
    if (code) {
        cvol_tiff_close(file);
        return code;
    }
    *out = file;
    return CVOL_OK;
}

void cvol_tiff_close(cvol_tiff_file *file)
{
    if (!file)
        return;
    if (file->tiff)
        TIFFClose(file->tiff);
    cvol_input_close(&file->input);
    free(file->path);
    free(file);
}

int cvol_tiff_next(cvol_context *context, cvol_tiff_file *file, int *more)
{
    forget_error(file);
    *more = TIFFReadDirectory(file->tiff);
    return file->lacks_bytes || (!*more && file->message[0]) ? fail_damaged(context, file, "a page")
                                                             : CVOL_OK;
}

int cvol_tiff_description(cvol_context *context, cvol_tiff_file *file, char **out)
{
    char *text = NULL;
    *out = NULL;
    if (!TIFFSetDirectory(file->tiff, 0))
        return fail_damaged(context, file, "its first page");
    if (!TIFFGetField(file->tiff, TIFFTAG_IMAGEDESCRIPTION, &text) || !text)
        return CVOL_OK;
    *out = strdup(text);
    return *out ? CVOL_OK : cvol_fail_memory(context, strlen(text), file->path);
}

/* ---- properties of a page ------------------------------------------------------------ */

static uint16_t get_16(const cvol_tiff_file *file, uint32_t tag, uint16_t otherwise)
{
    uint16_t value;
    return TIFFGetFieldDefaulted(file->tiff, tag, &value) ? value : otherwise;
}

static int read_type(cvol_context *context, const cvol_tiff_file *file, cvol_tiff_page *page)
{
    static const struct {
        uint16_t format, bits;
        cvol_type type;
    } types[] = {
        {SAMPLEFORMAT_UINT, 8, CVOL_UINT8},      {SAMPLEFORMAT_INT, 8, CVOL_INT8},
        {SAMPLEFORMAT_UINT, 16, CVOL_UINT16},    {SAMPLEFORMAT_INT, 16, CVOL_INT16},
        {SAMPLEFORMAT_UINT, 32, CVOL_UINT32},    {SAMPLEFORMAT_INT, 32, CVOL_INT32},
        {SAMPLEFORMAT_IEEEFP, 32, CVOL_FLOAT32}, {SAMPLEFORMAT_IEEEFP, 64, CVOL_FLOAT64},
        {SAMPLEFORMAT_IEEEFP, 16, CVOL_FLOAT32}, {SAMPLEFORMAT_UINT, 1, CVOL_UINT8},
    };
    uint16_t bits = get_16(file, TIFFTAG_BITSPERSAMPLE, 1);
    uint16_t format = get_16(file, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
    if (format == SAMPLEFORMAT_VOID)
        format = SAMPLEFORMAT_UINT;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (types[i].format == format && types[i].bits == bits) {
            page->type = types[i].type;
            page->form = bits == 1                                     ? CVOL_TIFF_BITS
                         : bits == 16 && format == SAMPLEFORMAT_IEEEFP ? CVOL_TIFF_HALVES
                                                                       : CVOL_TIFF_PLAIN;
            return CVOL_OK;
        }
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: BitsPerSample %d with SampleFormat %d is not supported", file->path, bits,
                     format);
}

/* ImageJ's resolutions have no unit, or one that the description names. */
static void read_resolution(const cvol_tiff_file *file, cvol_tiff_page *page)
{
    float value;
    static const uint32_t tags[] = {TIFFTAG_XRESOLUTION, TIFFTAG_YRESOLUTION};
    uint16_t unit = get_16(file, TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);
    for (int a = 0; a < 2; a++)
        if (TIFFGetField(file->tiff, tags[a], &value) && isfinite(value) && value > 0 &&
            unit != RESUNIT_INCH)
            page->resolution[a] = (double)value;
}

/* Raw strips have as many bytes as the samples. Other codings pack at most 100 to 1000 bytes into
 * one, except Zstandard, LZMA and WebP, which have no known bound. */
static double most_packed(uint16_t compression)
{
    switch (compression) {
    case COMPRESSION_NONE:
        return 1;
    case COMPRESSION_PACKBITS:
        return 64;
    case COMPRESSION_ADOBE_DEFLATE:
    case COMPRESSION_DEFLATE:
        return 1100;
    default:
        return 100000;
    }
}

/* The bytes of the samples of a page in the file, without a packing of libtiff. */
static double stored_bytes(const cvol_tiff_page *page)
{
    const double rows = (double)page->height * (double)page->samples;
    return page->form == CVOL_TIFF_HALVES ? (double)page->bytes / 2
           : page->form == CVOL_TIFF_BITS ? (double)((page->width + 7) / 8) * rows
                                          : (double)page->bytes;
}

/* Checks that strips and tiles lie within the file and hold enough bytes. */
static int check_bytes(cvol_context *context, const cvol_tiff_file *file, cvol_tiff_page *page)
{
    uint16_t compression = get_16(file, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
    const int tiled = TIFFIsTiled(file->tiff);
    const char *name = tiled ? "tile" : "strip";
    uint32_t count = tiled ? TIFFNumberOfTiles(file->tiff) : TIFFNumberOfStrips(file->tiff);
    if (count > 1 && count > file->input.size / 2) /* each has an offset and a size there */
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: %llu bytes cannot hold %u %ss",
                         file->path, (unsigned long long)file->input.size, count, name);
    double stored = 0;
    uint64_t next = 0;
    int in_one = compression == COMPRESSION_NONE && !tiled && page->samples == 1 &&
                 page->form == CVOL_TIFF_PLAIN;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t at = TIFFGetStrileOffset(file->tiff, i);
        uint64_t bytes = TIFFGetStrileByteCount(file->tiff, i);
        if (at > file->input.size || bytes > file->input.size - at)
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: %s %u begins at byte %llu and has %llu, but the file has %llu",
                             file->path, name, i, (unsigned long long)at, (unsigned long long)bytes,
                             (unsigned long long)file->input.size);
        stored += (double)bytes;
        in_one = in_one && (i == 0 || at == next);
        next = at + bytes;
    }
    page->raw_offset = in_one ? TIFFGetStrileOffset(file->tiff, 0) : 0;
    if (stored * most_packed(compression) < stored_bytes(page))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: a page of %zu x %zu pixels has %.0f bytes of samples, but its %ss "
                         "have %.0f bytes",
                         file->path, page->width, page->height, stored_bytes(page), name, stored);
    return CVOL_OK;
}

int cvol_tiff_read_page(cvol_context *context, cvol_tiff_file *file, cvol_tiff_page *page)
{
    uint32_t width = 0, height = 0, subfile = 0;
    *page = (cvol_tiff_page){.offset = TIFFCurrentDirOffset(file->tiff)};
    if (TIFFGetField(file->tiff, TIFFTAG_SUBFILETYPE, &subfile) &&
        (subfile & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK))) {
        page->is_extra = 1;
        return CVOL_OK;
    }
    TIFFGetField(file->tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(file->tiff, TIFFTAG_IMAGELENGTH, &height);
    page->width = width;
    page->height = height;
    page->samples = get_16(file, TIFFTAG_SAMPLESPERPIXEL, 1);
    const unsigned photometric = get_16(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    page->are_colours = photometric == PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_YCBCR;
    page->big_endian = TIFFIsBigEndian(file->tiff);
    int code = read_type(context, file, page);
    if (!code && page->form == CVOL_TIFF_BITS && (page->samples > 1 || TIFFIsTiled(file->tiff)))
        code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: BitsPerSample 1 in tiles, or with SamplesPerPixel %zu, is not "
                         "supported",
                         file->path, page->samples);
    if (!code && page->samples == 0)
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: SamplesPerPixel is 0", file->path);
    cvol_grid grid = cvol_grid_make(width, height, page->samples, page->type);
    if (!code)
        code = cvol_grid_check_file(context, &grid, file->path);
    if (code)
        return code;
    page->bytes = cvol_grid_bytes(&grid);
    read_resolution(file, page);
    return check_bytes(context, file, page);
}

int cvol_tiff_check_same(cvol_context *context, const cvol_tiff_page *first,
                         const cvol_tiff_page *page, const char *path)
{
    if (page->width == first->width && page->height == first->height &&
        page->samples == first->samples && page->type == first->type && page->form == first->form)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: a page has %zu x %zu pixels of %zu %s; the first page has %zu x %zu of "
                     "%zu %s",
                     path, page->width, page->height, page->samples, cvol_type_name(page->type),
                     first->width, first->height, first->samples, cvol_type_name(first->type));
}

/* ---- samples ------------------------------------------------------------------------- */

/* A rectangle of a page, of which sample `sample` is requested: in `data`, with `columns` pixels
 * per row and `each` samples per pixel. */
typedef struct piece {
    const uint8_t *data;
    size_t columns, each;
    size_t x, y, width, height; /* of the page */
} piece;

static void copy_piece(uint8_t *out, const cvol_tiff_page *page, const piece *p, size_t sample)
{
    const size_t size = cvol_type_size(page->type);
    for (size_t y = 0; y < p->height; y++) {
        const uint8_t *from = p->data + y * p->columns * p->each * size + sample * size;
        uint8_t *to = out + ((p->y + y) * page->width + p->x) * size;
        if (p->each == 1)
            memcpy(to, from, p->width * size);
        else
            for (size_t x = 0; x < p->width; x++)
                memcpy(to + x * size, from + x * p->each * size, size);
    }
}

static int decode_strips(cvol_tiff_file *file, const cvol_tiff_page *page, size_t plane,
                         size_t each, size_t sample, uint8_t *buffer, uint8_t *out)
{
    const size_t row = page->width * each * cvol_type_size(page->type);
    uint32_t rows = (uint32_t)page->height;
    TIFFGetFieldDefaulted(file->tiff, TIFFTAG_ROWSPERSTRIP, &rows);
    for (size_t y = 0; y < page->height; y += rows) {
        const size_t height = page->height - y < rows ? page->height - y : rows;
        /* Pages that need no conversion are decoded in place. */
        uint8_t *to = buffer ? buffer : out + y * row;
        uint32_t strip = TIFFComputeStrip(file->tiff, (uint32_t)y, (uint16_t)plane);
        if (TIFFReadEncodedStrip(file->tiff, strip, to, (tmsize_t)(height * row)) !=
            (tmsize_t)(height * row))
            return 0;
        if (buffer)
            copy_piece(out, page, &(piece){to, page->width, each, 0, y, page->width, height},
                       sample);
    }
    return 1;
}

static int decode_tiles(cvol_tiff_file *file, const cvol_tiff_page *page, size_t plane, size_t each,
                        size_t sample, uint32_t columns, uint32_t rows, uint8_t *buffer,
                        uint8_t *out)
{
    const size_t bytes = (size_t)columns * rows * each * cvol_type_size(page->type);
    for (size_t y = 0; y < page->height; y += rows)
        for (size_t x = 0; x < page->width; x += columns) {
            uint32_t tile = TIFFComputeTile(file->tiff, (uint32_t)x, (uint32_t)y, 0,
                                            (uint16_t)plane);
            if (TIFFReadEncodedTile(file->tiff, tile, buffer, (tmsize_t)bytes) != (tmsize_t)bytes)
                return 0;
            const size_t width = page->width - x < columns ? page->width - x : columns;
            const size_t height = page->height - y < rows ? page->height - y : rows;
            copy_piece(out, page, &(piece){buffer, columns, each, x, y, width, height}, sample);
        }
    return 1;
}

static int decode(cvol_context *context, cvol_tiff_file *file, const cvol_tiff_page *page,
                  size_t sample, void *out)
{
    const int apart = get_16(file, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) ==
                      PLANARCONFIG_SEPARATE;
    const size_t each = apart ? 1 : page->samples, plane = apart ? sample : 0;
    const size_t pixel = each * cvol_type_size(page->type);
    uint32_t columns = (uint32_t)page->width, rows = 0;
    const int tiled = TIFFIsTiled(file->tiff);
    if (tiled) {
        TIFFGetField(file->tiff, TIFFTAG_TILEWIDTH, &columns);
        TIFFGetField(file->tiff, TIFFTAG_TILELENGTH, &rows);
    } else
        TIFFGetFieldDefaulted(file->tiff, TIFFTAG_ROWSPERSTRIP, &rows);
    if (!tiled && rows > page->height)
        rows = (uint32_t)page->height;
    size_t bytes;
    if (columns == 0 || rows == 0 || !cvol_size_multiply(&bytes, (size_t)columns * pixel, rows) ||
        bytes > context->limit_bytes)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: has %ss of %u x %u pixels", file->path,
                         tiled ? "tile" : "strip", columns, rows);
    if ((tiled ? TIFFTileRowSize(file->tiff) : TIFFScanlineSize(file->tiff)) !=
        (tmsize_t)(columns * pixel))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: its pixels are packed in a way that is not supported (Photometric "
                         "%d)",
                         file->path, get_16(file, TIFFTAG_PHOTOMETRIC, 0));
    uint8_t *buffer = tiled || each > 1 ? cvol_allocate(bytes, 1) : NULL;
    if (!buffer && (tiled || each > 1))
        return cvol_fail_memory(context, bytes, file->path);
    const size_t within = apart ? 0 : sample;
    int done = tiled ? decode_tiles(file, page, plane, each, within, columns, rows, buffer, out)
                     : decode_strips(file, page, plane, each, within, buffer, out);
    free(buffer);
    return done ? CVOL_OK : fail_damaged(context, file, "a page");
}

/* Decodes samples in another form, and converts them. */
static int decode_form(cvol_context *context, cvol_tiff_file *file, const cvol_tiff_page *page,
                       size_t sample, void *out)
{
    const int are_halves = page->form == CVOL_TIFF_HALVES;
    const size_t pixels = page->width * page->height, row = (page->width + 7) / 8;
    cvol_tiff_page raw = *page;
    raw.type = are_halves ? CVOL_UINT16 : CVOL_UINT8;
    raw.width = are_halves ? page->width : row;
    uint8_t *stored = cvol_allocate(raw.width * raw.height, cvol_type_size(raw.type)), *to = out;
    if (!stored)
        return cvol_fail_memory(context, raw.width * raw.height * cvol_type_size(raw.type),
                                file->path);
    const int code = decode(context, file, &raw, sample, stored);
    if (!code && are_halves)
        cvol_strided_gather(out, stored, pixels, 2, 2, 1);
    for (size_t i = 0; i < pixels && !code && !are_halves; i++) {
        const size_t x = i % page->width;
        to[i] = stored[row * (i / page->width) + x / 8] >> (7 - x % 8) & 1;
    }
    free(stored);
    return code;
}

int cvol_tiff_decode(cvol_context *context, cvol_tiff_file *file, uint64_t offset,
                     const cvol_tiff_page *page, size_t sample, void *out)
{
    forget_error(file);
    if (TIFFCurrentDirOffset(file->tiff) != offset && !TIFFSetSubDirectory(file->tiff, offset))
        return fail_damaged(context, file, "a page");
    if (get_16(file, TIFFTAG_COMPRESSION, COMPRESSION_NONE) == COMPRESSION_JPEG)
        TIFFSetField(file->tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    cvol_tiff_page now;
    int code = cvol_tiff_read_page(context, file, &now);
    if (!code)
        code = cvol_tiff_check_same(context, page, &now, file->path);
    if (code)
        return code;
    return (page->form == CVOL_TIFF_PLAIN ? decode : decode_form)(context, file, page, sample, out);
}
