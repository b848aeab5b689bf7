/* Animations that are made in the background, each by its own thread. */
#ifndef CVOL_VIEWER_FILMS_FILMS_H
#define CVOL_VIEWER_FILMS_FILMS_H

#include "viewer/service/request.h"

enum { FILMS_MAX = 4, FILM_FRAMES_MAX = 3600 };

/* NULL: no memory. */
films *films_open(const viewer_options *options, int threads);
/* Cancels animations in progress and removes all files. NULL is allowed. */
void films_close(films *all);

/* POST api/1/films */
answer film_post(request *r);
/* GET api/1/films/ID, GET api/1/films/ID/file, DELETE api/1/films/ID */
answer film_get(request *r);
answer film_file_get(request *r);
answer film_delete(request *r);

#endif
