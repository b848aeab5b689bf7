/* Animations of the command, written by the library or by ffmpeg. */
#ifndef CVOL_TOOLS_MOVIE_H
#define CVOL_TOOLS_MOVIE_H

#include "cvol/film.h"
#include "tools/base/cli.h"

/* 1 if the extension is that of an animation: .gif .webp, or through ffmpeg .mp4 .mov .mkv .webm.
 */
int is_movie(const char *name);
/* 1 if ffmpeg writes this extension. */
int is_ffmpeg_movie(const char *name);

typedef struct movie movie;

/* NULL after a message; then *status is the exit status. */
movie *open_movie(cvol_context *context, const char *path, int width, int height,
                  const cvol_film_options *options, int *status);
/* 1 if the format chooses its colours from sample pictures, given to sample_movie_palette first. */
int movie_needs_palette(const movie *m);
int sample_movie_palette(cvol_context *context, movie *m, const cvol_image *image);
/* Exit statuses. After a failure only abandon_movie may follow. */
int add_to_movie(cvol_context *context, movie *m, const cvol_image *image);
/* Renames the finished file and frees the object, after a failure too. */
int commit_movie(cvol_context *context, movie *m);
void abandon_movie(movie *m);

#endif
