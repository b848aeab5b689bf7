/* A film that is being written, in any of its formats. */
#ifndef CVOL_VIEWER_FILM_OUT_H
#define CVOL_VIEWER_FILM_OUT_H

#include "options.h"

enum { FILM_SENTENCE_BYTES = 512 };

/* One format. */
typedef struct film_format {
    const char *name, *type; /* "webp", "image/webp" */
    const char *ending;      /* of the file: ".webp", ".tar" */
} film_format;

/* The one of this name, if this program can write it; NULL: it cannot. */
const film_format *film_format_find(const char *name, const viewer_movies *movies);
/* "gif webp png", as many as there are: 0, 1, 2, ...; NULL: no more. */
const film_format *film_format_at(int i, const viewer_movies *movies);

typedef struct film_out film_out;

/* Functions below return 0, or -1 after a sentence. `path` ends as the format does. */
int film_out_open(cvol_context *context, film_out **out, const film_format *format,
                  const viewer_movies *movies, const char *path, const int size[2],
                  const cvol_film_options *options, char sentence[FILM_SENTENCE_BYTES]);
/* Whether it chooses its colours from pictures that it is shown before. */
int film_out_learns(const film_out *f);
int film_out_learn(cvol_context *context, film_out *f, const cvol_image *image,
                   char sentence[FILM_SENTENCE_BYTES]);
int film_out_add(cvol_context *context, film_out *f, const cvol_image *image,
                 char sentence[FILM_SENTENCE_BYTES]);
/* The file is whole, and has its name; frees it, also when it fails. */
int film_out_commit(cvol_context *context, film_out *f, char sentence[FILM_SENTENCE_BYTES]);
/* Removes what was written; NULL is allowed. */
void film_out_abandon(film_out *f);

#endif
