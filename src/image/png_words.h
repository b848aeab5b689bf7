/* What libpng says: errors, which end its work by longjmp, and warnings, which are about chunks
 * that pictures do without. */
#ifndef CVOL_IMAGE_PNG_WORDS_H
#define CVOL_IMAGE_PNG_WORDS_H

#include <png.h>

/* The last error, in libpng's own words: what png_create_*_struct is given to call back with. */
typedef struct cvol_png_words {
    char text[200];
} cvol_png_words;

void cvol_png_on_error(png_structp png, png_const_charp message);
void cvol_png_on_warning(png_structp png, png_const_charp message);

#endif
