/* PNG files, read through libpng.
 *
 * Reading turns every colour type, depth and interlacing into 8-bit RGBA. The file is read into
 * memory first, so that libpng reads from memory only; the header's sizes are checked against the
 * limits and the file's size before any allocation.
 *
 * libpng reports errors by longjmp (png_library.h). All state that must survive it is in one struct
 * behind a pointer: no local variable changes between setjmp and longjmp. */
#include "cvol/image.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/png_library.h"

#define SIGNATURE_BYTES 8

typedef struct png_job {
    cvol_context *context;
    const char *path;
    png_structp png;
    png_infop info;
    cvol_png_words message;
    cvol_cursor file;
    cvol_image *image; /* once its size is known */
} png_job;

/* Refuses sizes beyond the limits, and sizes that are too large for the file's bytes. */
static int check_header(png_job *job)
{
    uint64_t width = png_get_image_width(job->png, job->info);
    uint64_t height = png_get_image_height(job->png, job->info);
    if (width > CVOL_IMAGE_SIZE_MAX || height > CVOL_IMAGE_SIZE_MAX)
        return cvol_fail(job->context, CVOL_ERROR_LIMIT,
                         "%s: %llu x %llu pixels are more than the limit of %d x %d", job->path,
                         (unsigned long long)width, (unsigned long long)height, CVOL_IMAGE_SIZE_MAX,
                         CVOL_IMAGE_SIZE_MAX);
    if (width * height * 4 > cvol_context_limit_bytes(job->context))
        return cvol_fail(job->context, CVOL_ERROR_LIMIT,
                         "%s: %llu x %llu pixels are more than the limit of %llu bytes", job->path,
                         (unsigned long long)width, (unsigned long long)height,
                         (unsigned long long)cvol_context_limit_bytes(job->context));
    if (cvol_png_is_too_short(job->png, job->info, job->file.size))
        return cvol_fail(job->context, CVOL_ERROR_FORMAT,
                         "%s: %zu bytes cannot hold the %llu x %llu pixels that its header claims",
                         job->path, job->file.size, (unsigned long long)width,
                         (unsigned long long)height);
    return CVOL_OK;
}

/* Makes libpng convert all files to RGBA of 8 bits. */
static void ask_for_rgba(png_structp png)
{
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xff, PNG_FILLER_AFTER);
}

/* Every pass of an interlaced file covers the whole picture. */
static void read_rows(png_job *job)
{
    int passes = png_set_interlace_handling(job->png);
    png_read_update_info(job->png, job->info);
    size_t stride = (size_t)job->image->width * 4;
    if (png_get_rowbytes(job->png, job->info) != stride)
        png_error(job->png, "rows are not 8-bit RGBA");
    for (int pass = 0; pass < passes; pass++)
        for (int j = 0; j < job->image->height; j++)
            png_read_row(job->png, job->image->rgba + (size_t)j * stride, NULL);
    png_read_end(job->png, NULL);
}

static int decode(png_job *job)
{
    if (setjmp(png_jmpbuf(job->png)))
        return cvol_fail(job->context,
                         job->message.is_memory ? CVOL_ERROR_MEMORY : CVOL_ERROR_FORMAT,
                         job->message.is_memory ? "%s: not enough memory: %s" : "%s: PNG: %s",
                         job->path, job->message.text);
    cvol_png_read_from(job->png, &job->file);
    /* check_header checks the limits, so that exceeding them has its own error code. */
    png_set_user_limits(job->png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_read_info(job->png, job->info);
    int code = check_header(job);
    if (code)
        return code;
    code = cvol_image_create(job->context, &job->image,
                             (int)png_get_image_width(job->png, job->info),
                             (int)png_get_image_height(job->png, job->info));
    if (code)
        return code;
    ask_for_rgba(job->png);
    read_rows(job);
    return CVOL_OK;
}

int cvol_image_read_png(cvol_context *context, cvol_image **out, const char *path)
{
    *out = NULL;
    uint8_t *data;
    size_t size;
    int code = cvol_file_read(context, &data, &size, path, 0, SIZE_MAX);
    if (code)
        return code;
    png_job job = {.context = context, .path = path, .file = cvol_cursor_make(data, size)};
    if (size < SIGNATURE_BYTES || png_sig_cmp(data, 0, SIGNATURE_BYTES))
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: %s", path,
                         size ? "is not a PNG file" : "is empty");
    else {
        job.png = cvol_png_reader(&job.message);
        job.info = job.png ? png_create_info_struct(job.png) : NULL;
        code = job.info ? decode(&job) : cvol_fail_memory(context, sizeof job, "libpng");
        png_destroy_read_struct(&job.png, &job.info, NULL);
    }
    free(data);
    if (code)
        cvol_image_free(job.image);
    else
        *out = job.image;
    return code;
}
