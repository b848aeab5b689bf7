/* Animated WebP in builds without libwebp. */
#include "image/film.h"

const cvol_film_format cvol_film_webp = {.ending = ".webp", .name = "WebP", .lacks = "libwebp"};
