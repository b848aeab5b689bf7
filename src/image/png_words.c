/* What libpng says (png_words.h). */
#include "image/png_words.h"

#include <setjmp.h>
#include <stdio.h>

void cvol_png_on_error(png_structp png, png_const_charp message)
{
    cvol_png_words *words = png_get_error_ptr(png);
    snprintf(words->text, sizeof words->text, "%s", message);
    png_longjmp(png, 1);
}

void cvol_png_on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}
