/* Films of the command: what the library writes, and what ffmpeg does. */
#ifndef CVOL_TOOLS_MOVIE_H
#define CVOL_TOOLS_MOVIE_H

#include "cli.h"
#include "cvol/film.h"

/* Whether the name is a film's: .gif .webp, or .mp4 .mov .mkv .webm through ffmpeg. */
int is_movie(const char *name);
/* The same for those through ffmpeg. */
int is_ffmpeg_movie(const char *name);

typedef struct movie movie;

/* NULL after a sentence, and then *status is the exit status. */
movie *open_movie(cvol_context *context, const char *path, int width, int height,
                  const cvol_film_options *options, int *status);
/* Whether its colours are chosen from pictures that it is shown first. */
int movie_learns(const movie *m);
int show_movie(cvol_context *context, movie *m, const cvol_image *image);
/* Exit statuses. After a failure the film can only be abandoned. */
int add_to_movie(cvol_context *context, movie *m, const cvol_image *image);
/* Gives the film its name and frees it, also when it fails. */
int commit_movie(cvol_context *context, movie *m);
void abandon_movie(movie *m);

#endif
