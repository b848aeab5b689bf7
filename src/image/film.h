/* Formats of films. */
#ifndef CVOL_IMAGE_FILM_H
#define CVOL_IMAGE_FILM_H

#include "base/file.h"
#include "cvol/film.h"

/* The functions of a format; `state` is its own, and NULL before open and after a failed one. */
typedef struct cvol_film_format {
    const char *ending, *name;
    const char *lacks; /* the library that it needs and this build lacks. NULL: none */
    int needs_palette, size_max;
    double rate_max;
    int (*open)(cvol_context *context, struct cvol_film *film);
    int (*sample_palette)(cvol_context *context, struct cvol_film *film, const cvol_image *image);
    int (*add)(cvol_context *context, struct cvol_film *film, const cvol_image *image);
    int (*finish)(cvol_context *context, struct cvol_film *film); /* writes the rest */
    void (*free)(void *state);
} cvol_film_format;

struct cvol_film {
    const cvol_film_format *format;
    cvol_output *output;
    const char *path; /* for messages: the output's */
    int width, height, frames;
    cvol_film_options options;
    void *state;
};

/* In a build without their library they have only the names and `lacks` (*_film_missing.c). */
extern const cvol_film_format cvol_film_gif;
extern const cvol_film_format cvol_film_webp;

#endif
