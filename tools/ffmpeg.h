/* Films through ffmpeg: a child that is fed raw pictures. */
#ifndef CVOL_TOOLS_FFMPEG_H
#define CVOL_TOOLS_FFMPEG_H

#include "cvol/film.h"

typedef struct ffmpeg ffmpeg;

/* Whether it is installed. */
int has_ffmpeg(void);
/* NULL, and from the next two not 0: then `sentence` is why. */
ffmpeg *open_ffmpeg(const char *path, int width, int height, const cvol_film_options *options,
                    char *sentence, size_t sentence_bytes);
int add_to_ffmpeg(ffmpeg *f, const cvol_image *image, char *sentence, size_t sentence_bytes);
/* Gives the film its name and frees it, also when it fails. */
int commit_ffmpeg(ffmpeg *f, char *sentence, size_t sentence_bytes);
void abandon_ffmpeg(ffmpeg *f);

#endif
