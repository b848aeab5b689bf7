/* cvol/film.h - animations: pictures in a GIF or WebP file. */
#ifndef CVOL_FILM_H
#define CVOL_FILM_H

#include "cvol/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Options of an animation; start with cvol_film_options_defaults(). */
typedef struct cvol_film_options {
    size_t size;              /* sizeof(cvol_film_options) */
    double frames_per_second; /* above 0, at most 1000; GIF: at most 50 */
    int quality;              /* 0 to 100, for WebP; 100: lossless */
} cvol_film_options;

/* Sets *options, which has `size` bytes, to the defaults. */
CVOL_API void cvol_film_options_set_defaults(cvol_film_options *options, size_t size);
/* 25 frames a second, quality 90. */
static inline cvol_film_options cvol_film_options_defaults(void)
{
    cvol_film_options options;
    cvol_film_options_set_defaults(&options, sizeof options);
    return options;
}

/* An animation that is being written. It repeats forever. */
typedef struct cvol_film cvol_film;

/* The extensions that this build writes: ".gif .webp", or ".gif"; static storage. */
CVOL_API const char *cvol_film_formats(void);

/* Opens an animation with pictures of one size; the extension of the name chooses the format. GIF:
 * 255 colours for all pictures, ordered dithering, opaque. WebP: with opacity. The caller ends it
 * with commit or abandon. Errors: ARGUMENT (size, options, unknown extension), UNSUPPORTED (this
 * build lacks the format), IO, MEMORY. */
CVOL_API int cvol_film_open(cvol_context *context, cvol_film **out, const char *path, int width,
                            int height, const cvol_film_options *options);
/* 1 if the format chooses its colours from sample pictures, which cvol_film_sample_palette must get
 * before cvol_film_add. */
CVOL_API int cvol_film_needs_palette(const cvol_film *film);
/* Gives it a sample picture. Without any, it uses the first picture. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_film_sample_palette(cvol_context *context, cvol_film *film,
                                      const cvol_image *image);
/* Adds a picture (bytes). After an error only abandon may follow. Errors: ARGUMENT (size, or
 * opacity in GIF), IO, MEMORY. */
CVOL_API int cvol_film_add(cvol_context *context, cvol_film *film, const cvol_image *image);
/* Gives the complete file its name and frees the object, after a failure too; then a file that had
 * the name stays. Errors: ARGUMENT (no pictures), IO, MEMORY. */
CVOL_API int cvol_film_commit(cvol_context *context, cvol_film *film);
/* Removes the unfinished file and frees the object; NULL is allowed. */
CVOL_API void cvol_film_abandon(cvol_film *film);

#ifdef __cplusplus
}
#endif
#endif
