/* Animations: a view that turns about the vertical. */
#ifndef CVOL_VIEWER_FILM_MAKE_H
#define CVOL_VIEWER_FILM_MAKE_H

#include "film_out.h"
#include "view.h"

typedef struct film_wanted {
    view view;
    int frames;
    double degrees; /* angle of the turn */
    cvol_film_options options;
    const film_format *format;
} film_wanted;

/* Draws the animation into a file. Calls `told` with the finished share. 0, or -1 and a message in
 * `sentence`. */
int film_make(cvol_context *context, const film_wanted *wanted, const viewer_movies *movies,
              const char *path, void (*told)(void *user, double fraction), void *user,
              char sentence[FILM_SENTENCE_BYTES]);

#endif
