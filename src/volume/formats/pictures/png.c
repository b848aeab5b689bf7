/* PNG as slices of a volume, by libpng, which reports errors by longjmp (base/png_library.h): no
 * local variable changes between setjmp and longjmp. */
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include "base/byte_order.h"
#include "base/bytes.h"
#include "base/context.h"
#include "base/file.h"
#include "base/png_library.h"
#include "volume/formats/pictures/picture.h"

typedef struct png_job {
    cvol_context *context;
    const char *path;
    png_structp png;
    png_infop info;
    cvol_png_words message;
    cvol_cursor file;
    cvol_picture *out;
    png_bytep *rows;
} png_job;

static int has_grey_palette(const png_job *job)
{
    png_colorp colours;
    int count;
    if (!png_get_PLTE(job->png, job->info, &colours, &count))
        return 0;
    for (int i = 0; i < count; i++)
        if (colours[i].red != colours[i].green || colours[i].red != colours[i].blue)
            return 0;
    return 1;
}

/* Asks for grey or RGB of 8 or 16 bits. */
static void choose_pixels(png_job *job)
{
    png_structp png = job->png;
    const int is_palette = png_get_color_type(png, job->info) == PNG_COLOR_TYPE_PALETTE;
    if (is_palette)
        png_set_palette_to_rgb(png);
    if (is_palette && has_grey_palette(job))
        png_set_rgb_to_gray_fixed(png, PNG_ERROR_ACTION_NONE, -1, -1);
    if (png_get_bit_depth(png, job->info) < 8 && !is_palette)
        png_set_expand_gray_1_2_4_to_8(png);
    png_set_strip_alpha(png);
    if (!cvol_machine_is_big_endian())
        png_set_swap(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, job->info);
    job->out->width = png_get_image_width(png, job->info);
    job->out->height = png_get_image_height(png, job->info);
    job->out->channels = png_get_channels(png, job->info);
    job->out->bits = png_get_bit_depth(png, job->info);
}

static int make_room(png_job *job)
{
    const size_t bytes = png_get_rowbytes(job->png, job->info), height = job->out->height;
    job->out->pixels = malloc(bytes * height);
    job->rows = malloc(height * sizeof *job->rows);
    if (!job->out->pixels || !job->rows)
        return cvol_fail_memory(job->context, bytes * height, job->path);
    for (size_t y = 0; y < height; y++)
        job->rows[y] = job->out->pixels + y * bytes;
    return CVOL_OK;
}

/* May end by longjmp. */
static int read_all(png_job *job)
{
    cvol_png_read_from(job->png, &job->file);
    png_read_info(job->png, job->info);
    const int is_too_short = cvol_png_is_too_short(job->png, job->info, job->file.size);
    choose_pixels(job);
    int code = cvol_picture_check(job->context, job->out, job->path);
    if (!code && is_too_short)
        code = cvol_fail(job->context, CVOL_ERROR_FORMAT,
                         "%s: %zu bytes cannot hold the %zu x %zu pixels that its header claims",
                         job->path, job->file.size, job->out->width, job->out->height);
    if (!code)
        code = make_room(job);
    if (code)
        return code;
    png_read_image(job->png, job->rows);
    png_read_end(job->png, NULL);
    return CVOL_OK;
}

static int decode(png_job *job)
{
    job->png = cvol_png_reader(&job->message);
    job->info = job->png ? png_create_info_struct(job->png) : NULL;
    if (!job->info)
        return cvol_fail_memory(job->context, 0, job->path);
    if (setjmp(png_jmpbuf(job->png)))
        return job->message.is_memory ? cvol_fail_memory(job->context, 0, job->path)
                                      : cvol_fail(job->context, CVOL_ERROR_FORMAT, "%s: PNG: %s",
                                                  job->path, job->message.text);
    return read_all(job);
}

int cvol_picture_read_png(cvol_context *context, cvol_picture *out, const char *path)
{
    cvol_map file;
    *out = (cvol_picture){0};
    int code = cvol_file_map(context, &file, path);
    if (code)
        return code;
    png_job *job = calloc(1, sizeof *job);
    if (!job) {
        cvol_file_unmap(&file);
        return cvol_fail_memory(context, sizeof *job, path);
    }
    *job = (png_job){.context = context,
                     .path = path,
                     .file = cvol_cursor_make(file.data, file.size),
                     .out = out};
    code = decode(job);
    png_destroy_read_struct(&job->png, &job->info, NULL);
    free(job->rows);
    free(job);
    cvol_file_unmap(&file);
    if (code) {
        free(out->pixels);
        out->pixels = NULL;
    }
    return code;
}
