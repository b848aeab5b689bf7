/* Animations: a view that turns about the vertical. */
#ifndef CVOL_VIEWER_FILMS_FILM_MAKE_H
#define CVOL_VIEWER_FILMS_FILM_MAKE_H

#include "viewer/films/film_out.h"
#include "viewer/view/view.h"

typedef struct film_settings {
    view view;
    int frames;
    double degrees; /* angle of the turn */
    int over_time;  /* 1: each picture shows another time */
    cvol_film_options options;
    const film_format *format;
} film_settings;

/* Draws the animation into a file. Calls `on_progress` with the finished share. 0, or -1 and a
 * message in `message`. */
int film_make(cvol_context *context, film_settings *settings, const viewer_movies *movies,
              const char *path, void (*on_progress)(void *user, double fraction), void *user,
              char message[FILM_MESSAGE_BYTES]);

#endif
