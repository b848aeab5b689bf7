/* Animations through ffmpeg: a child process that reads raw pictures. */
#ifndef CVOL_TOOLS_FFMPEG_H
#define CVOL_TOOLS_FFMPEG_H

#include "cvol/film.h"

typedef struct ffmpeg ffmpeg;

/* 1 if ffmpeg is installed. */
int has_ffmpeg(void);
/* NULL, or from the next two functions not 0: failed, and `message` has the message. */
ffmpeg *open_ffmpeg(const char *path, int width, int height, const cvol_film_options *options,
                    char *message, size_t message_bytes);
int add_to_ffmpeg(ffmpeg *f, const cvol_image *image, char *message, size_t message_bytes);
/* Renames the finished file and frees the object, after a failure too. */
int commit_ffmpeg(ffmpeg *f, char *message, size_t message_bytes);
void abandon_ffmpeg(ffmpeg *f);

#endif
