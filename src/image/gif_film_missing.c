/* Animated GIF in builds without giflib. */
#include "image/film.h"

const cvol_film_format cvol_film_gif = {.ending = ".gif", .name = "GIF", .lacks = "giflib"};
