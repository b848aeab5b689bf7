/* What readers and writers of PNG share: messages of libpng (errors, which it ends by longjmp; not
 * warnings, which concern chunks that pictures do not need), and reading from memory. */
#ifndef CVOL_BASE_PNG_LIBRARY_H
#define CVOL_BASE_PNG_LIBRARY_H

#include <png.h>

#include "base/bytes.h"

/* The last error in libpng's words: the callback data of png_create_*_struct. */
typedef struct cvol_png_words {
    char text[200];
    int is_memory; /* it had no memory */
} cvol_png_words;

/* png_create_read_struct and png_create_write_struct with this error handler; NULL without
 * memory. */
png_structp cvol_png_reader(cvol_png_words *words);
png_structp cvol_png_writer(cvol_png_words *words);

/* Lets libpng read from a cursor, which must outlive it. */
void cvol_png_read_from(png_structp png, cvol_cursor *cursor);

/* 1 if a file of `size` bytes cannot hold the rows of its header. After png_read_info, and before
 * any transformation. */
int cvol_png_is_too_short(png_structp png, png_infop info, size_t size);

#endif
