/* Messages of libpng (png_words.h). */
#include "base/png_words.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

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
