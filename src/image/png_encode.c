/* PNG files in memory, by libpng.
 *
 * libpng reports errors by longjmp (png_library.h). All state that must survive it is in one struct
 * behind a pointer: no local variable changes between setjmp and longjmp. */
#include "image/png_encode.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <zlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/png_library.h"

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

int cvol_png_encode(cvol_context *context, cvol_bytes *out, const cvol_png_rows *rows, int level,
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
