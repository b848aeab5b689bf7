/* Messages of libpng: errors, which it ends by longjmp, and warnings, which concern chunks that
 * pictures do not need. */
#ifndef CVOL_BASE_PNG_WORDS_H
#define CVOL_BASE_PNG_WORDS_H

#include <png.h>

/* The last error in libpng's words: the callback data of png_create_*_struct. */
typedef struct cvol_png_words {
    char text[200];
    int is_memory; /* it had no memory */
} cvol_png_words;

/* png_create_read_struct and png_create_write_struct with this error handler; NULL without
 * memory. */
png_structp cvol_png_reader(cvol_png_words *words);
png_structp cvol_png_writer(cvol_png_words *words);

#endif
