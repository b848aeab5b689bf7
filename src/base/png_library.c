#include "base/png_library.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Deflate cannot pack more than this many bytes into one (zlib's technical notes: 1032). */
#define DEFLATE_RATIO_MAX 1040

static void on_error(png_structp png, png_const_charp message)
{
    cvol_png_words *words = png_get_error_ptr(png);
    snprintf(words->text, sizeof words->text, "%s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

/* libpng's message does not distinguish lack of memory; this flag does. */
static png_voidp allocate(png_structp png, png_alloc_size_t bytes)
{
    cvol_png_words *words = png_get_mem_ptr(png);
    void *memory = malloc(bytes);
    if (!memory && words)
        words->is_memory = 1;
    return memory;
}

static void release(png_structp png, png_voidp memory)
{
    (void)png;
    free(memory);
}

png_structp cvol_png_reader(cvol_png_words *words)
{
    return png_create_read_struct_2(PNG_LIBPNG_VER_STRING, words, on_error, on_warning, words,
                                    allocate, release);
}

png_structp cvol_png_writer(cvol_png_words *words)
{
    return png_create_write_struct_2(PNG_LIBPNG_VER_STRING, words, on_error, on_warning, words,
                                     allocate, release);
}

static void read_from_cursor(png_structp png, png_bytep out, size_t size)
{
    const uint8_t *data = cvol_cursor_take(png_get_io_ptr(png), size);
    if (!data)
        png_error(png, "the file ends too early");
    else
        memcpy(out, data, size);
}

void cvol_png_read_from(png_structp png, cvol_cursor *cursor)
{
    png_set_read_fn(png, cursor, read_from_cursor);
}

int cvol_png_is_too_short(png_structp png, png_infop info, size_t size)
{
    const uint64_t rows = (uint64_t)png_get_rowbytes(png, info) * png_get_image_height(png, info);
    return rows / DEFLATE_RATIO_MAX > size;
}
