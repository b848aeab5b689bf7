/* cvol/film.h - films: pictures one after the other, as an animated GIF or WebP. */
#ifndef CVOL_FILM_H
#define CVOL_FILM_H

#include "cvol/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a film is asked for. */
typedef struct cvol_film_options {
    double frames_per_second; /* above 0, at most 1000; GIF: at most 50 */
    int quality;              /* 0 to 100: of WebP, 100 being without loss */
} cvol_film_options;

/* 25 frames a second, quality 90. */
CVOL_API cvol_film_options cvol_film_options_defaults(void);

/* A film that is being made. It runs for ever, from its first picture again after its last. */
typedef struct cvol_film cvol_film;

/* The endings that this build can write: ".gif .webp", or ".gif"; static storage. */
CVOL_API const char *cvol_film_formats(void);

/* Opens a film of pictures of one size; the name's ending chooses the format. GIF: 255 colours for
 * all pictures, ordered dithering, opaque; WebP: with opacity. The caller ends it with one of
 * commit and abandon. Errors: ARGUMENT (size, options, unknown ending), UNSUPPORTED (this build
 * lacks the format), IO, MEMORY. */
CVOL_API int cvol_film_open(cvol_context *context, cvol_film **out, const char *path, int width,
                            int height, const cvol_film_options *options);
/* Whether the format chooses its colours from pictures that it is shown before the first one is
 * added. */
CVOL_API int cvol_film_needs_palette(const cvol_film *film);
/* Shows it such a picture. Without any, its first is taken. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_film_sample_palette(cvol_context *context, cvol_film *film,
                                      const cvol_image *image);
/* Adds a picture (bytes). After an error the film can only be abandoned. Errors: ARGUMENT (size, or
 * opacity in GIF), IO, MEMORY. */
CVOL_API int cvol_film_add(cvol_context *context, cvol_film *film, const cvol_image *image);
/* Gives the file its name and frees the film, also when it fails: then what had the name before
 * stays. Errors: ARGUMENT (no pictures), IO, MEMORY. */
CVOL_API int cvol_film_commit(cvol_context *context, cvol_film *film);
/* Removes what was written and frees the film; NULL is allowed. */
CVOL_API void cvol_film_abandon(cvol_film *film);

#ifdef __cplusplus
}
#endif
#endif
