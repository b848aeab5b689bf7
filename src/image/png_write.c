/* PNG files, written through libpng: in memory, and on disk when they are complete.
 *
 * Fast files store the difference to the row above in Huffman codes and runs: for pictures of
 * volumes they have at most a fifth more bytes, in an eighth of the time. Other files leave the
 * choice of filters to libpng, row by row.
 *
 * libpng reports errors by longjmp (png_words.h). All state that must survive it is in one struct
 * behind a pointer: no local variable changes between setjmp and longjmp. */
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/file.h"
#include "base/memory.h"
#include "image/pixels.h"
#include "image/png_words.h"

/* zlib's levels, which cvol_image_write_png lists. */
#define LEVEL_OF_FILES 6

typedef struct png_job {
    cvol_context *context;
    const char *name; /* for messages: the file's path, or the kind of data */
    int level;
    png_structp png;
    png_infop info;
    cvol_png_words message;
    cvol_bytes bytes; /* the encoded file */
    uint8_t *row;
} png_job;

static void append_to_bytes(png_structp png, png_bytep data, size_t size)
{
    png_job *job = png_get_io_ptr(png);
    cvol_bytes_append(&job->bytes, data, size);
    if (job->bytes.failed)
        png_error(png, "not enough memory");
}

static void ignore_flush(png_structp png)
{
    (void)png;
}

static int encode(png_job *job, const cvol_png_rows *rows)
{
    static const int colours[] = {
        [1] = PNG_COLOR_TYPE_GRAY, [3] = PNG_COLOR_TYPE_RGB, [4] = PNG_COLOR_TYPE_RGB_ALPHA};
    if (setjmp(png_jmpbuf(job->png)))
        return cvol_fail(job->context, CVOL_ERROR_MEMORY, "%s: PNG: %s", job->name,
                         job->message.text);
    png_set_write_fn(job->png, job, append_to_bytes, ignore_flush);
    png_set_IHDR(job->png, job->info, (png_uint_32)rows->width, (png_uint_32)rows->height,
                 rows->bits, colours[rows->channels], PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (job->level < 0) {
        png_set_filter(job->png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
        png_set_compression_strategy(job->png, Z_RLE);
    } else {
        png_set_compression_level(job->png, job->level);
    }
    png_write_info(job->png, job->info);
    for (int y = 0; y < rows->height; y++) {
        rows->fetch(rows, job->row, y);
        png_write_row(job->png, job->row);
    }
    png_write_end(job->png, NULL);
    return CVOL_OK;
}

/* The file's bytes, which the caller frees, also after an error. */
static int make_file(cvol_context *context, cvol_bytes *out, const cvol_png_rows *rows, int level,
                     const char *name)
{
    png_job job = {.context = context, .name = name, .level = level};
    int code;
    job.row = cvol_allocate((size_t)rows->width, (size_t)(rows->channels * rows->bits / 8));
    if (job.row)
        job.png = cvol_png_writer(&job.message);
    if (job.png)
        job.info = png_create_info_struct(job.png);
    code = job.info ? encode(&job, rows) : cvol_fail_memory(context, sizeof job, "libpng");
    png_destroy_write_struct(&job.png, &job.info);
    free(job.row);
    *out = job.bytes;
    return code;
}

int cvol_png_write(cvol_context *context, const cvol_png_rows *rows, const char *path)
{
    cvol_bytes bytes;
    int code = make_file(context, &bytes, rows, LEVEL_OF_FILES, path);
    if (!code)
        code = cvol_file_write(context, bytes.data, bytes.size, path);
    cvol_bytes_free(&bytes);
    return code;
}

/* ---- 8 bits ----------------------------------------------------------------------------- */

static int is_opaque(const cvol_image *image)
{
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++)
        if (image->rgba[4 * i + 3] != 255)
            return 0;
    return 1;
}

static void fetch_bytes(const cvol_png_rows *rows, uint8_t *out, int y)
{
    const size_t width = (size_t)rows->width, channels = (size_t)rows->channels;
    const uint8_t *rgba = rows->image->rgba + 4 * width * (size_t)y;
    for (size_t x = 0; x < width; x++)
        memcpy(out + channels * x, rgba + 4 * x, channels);
}

static cvol_png_rows rows_of(const cvol_image *image)
{
    return (cvol_png_rows){.width = image->width,
                           .height = image->height,
                           .channels = is_opaque(image) ? 3 : 4,
                           .bits = 8,
                           .fetch = fetch_bytes,
                           .image = image};
}

int cvol_image_write_png(cvol_context *context, const cvol_image *image, const char *path)
{
    const int code = cvol_image_need_bytes(context, image, path);
    if (code)
        return code;
    const cvol_png_rows rows = rows_of(image);
    return cvol_png_write(context, &rows, path);
}

int cvol_image_encode_png(cvol_context *context, const cvol_image *image, int level, void **out,
                          size_t *size)
{
    cvol_bytes bytes = {0};
    *out = NULL;
    *size = 0;
    int code = cvol_image_need_bytes(context, image, "PNG");
    if (!code && (level < CVOL_PNG_QUICK || level > 9))
        code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "PNG level %d: must be 0 to 9, or %d (quick)", level, CVOL_PNG_QUICK);
    if (code)
        return code;
    const cvol_png_rows rows = rows_of(image);
    code = make_file(context, &bytes, &rows, level, "PNG in memory");
    if (code) {
        cvol_bytes_free(&bytes);
        return code;
    }
    *out = bytes.data;
    *size = bytes.size;
    return CVOL_OK;
}
