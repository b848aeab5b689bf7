/* Pictures of cvol render: from a scene to files. */
#ifndef CVOL_TOOLS_RENDER_PICTURE_H
#define CVOL_TOOLS_RENDER_PICTURE_H

#include "picture.h"
#include "render_options.h"

/* What a picture's name says that it is. */
typedef enum picture_kind {
    PICTURE_NONE, /* nothing that is known */
    PICTURE_PNG,
    PICTURE_PFM,
    PICTURE_CVI
} picture_kind;
picture_kind picture_kind_of(const char *name);

/* What became of one picture. */
typedef struct outcome {
    double render_ms;
    int is_compressed;
    cvol_picture_info info; /* if it is */
} outcome;

/* What the picture's name and the options beside it ask for. Exit status. */
int check_picture(const scene *s, const render_arguments *a);
/* The same of the kind of file alone. */
int check_kind(const scene *s, const render_arguments *a);
/* Renders what the camera sees: floats, if the picture is to be kept so, else bytes. Exit status.
 */
int take_picture(cvol_context *context, scene *s, const render_arguments *a, int floats,
                 cvol_image **out, double *render_ms);
/* Takes a picture and writes it as PNG or PFM, silently. Exit status. */
int write_pixels(cvol_context *context, scene *s, const render_arguments *a, const char *output,
                 outcome *result);
/* Takes a picture, writes it and says so. Exit status. */
int write_picture(cvol_context *context, scene *s, const render_arguments *a, const char *output,
                  outcome *result);
/* Adds what is told of one picture only. */
void describe_outcome(json_t *object, cvol_context *context, const scene *s, const outcome *result);
/* Camera and grey levels, for people and --json. */
void describe_view(json_t *object, cvol_context *context, const scene *s,
                   const render_arguments *a);

/* render_maps.c: --depth and --opacity, pictures of other things beside it: whether there are any;
 * whether they can be had, of so many volumes; written, of a picture of floats. Exit status. */
static inline int has_maps(const render_arguments *a)
{
    return a->depth_name || a->opacity_name;
}
int check_maps(const scene *s, const render_arguments *a, int volumes);
int write_maps(cvol_context *context, const render_arguments *a, const cvol_image *image);
/* Their names for this input, and, when all is done, free. Exit status. */
int name_maps(render_arguments *a, const char *path);
void free_maps(render_arguments *a);
void describe_maps(json_t *object, const render_arguments *a);

/* render_channels.c: open_scene, or, of an input of several channels of which none was chosen, all
 * of them, each in its colour. Exit status. */
int open_channels(cvol_context *context, scene *s, render_arguments *a, const char *path);
/* How many times there are of which none was chosen, and channels that are drawn together. Exit
 * status. */
int count_drawn(cvol_context *context, const scene *s, render_arguments *a, const char *path,
                int *times, int *channels);
/* All of them into a picture of floats, which is black before. A library's code. */
int draw_channels(cvol_context *context, scene *s, cvol_image *image);
/* render_stages.c: --progressive. Exit status. */
int render_stages(cvol_context *context, render_arguments *arguments, scene *s, const char *path,
                  json_t *pictures, outcome *result);
/* render_turn.c: --turntable; *report is what --json tells of it. Exit status. */
int check_turntable(const scene *s, const render_arguments *a);
int render_turntable(cvol_context *context, scene *s, render_arguments *a, const char *path,
                     json_t **report);
/* render_times.c: --over-time, which is a turntable of as many pictures as there are times: what it
 * asks for; the scene at a time, after another one; and, before all, what values mean at all times,
 * which the caller frees. Exit status. */
int check_over_time(render_arguments *a);
int open_time(cvol_context *context, scene *s, render_arguments *a, const char *path, int time);
int fit_times(cvol_context *context, cvol_histogram **out, const scene *fresh, render_arguments *a,
              const char *path);
/* render_volume.c: all that was asked for of one volume; *report is what --json tells of it (NULL
 * without). Exit status. */
int render_volume(cvol_context *context, const render_arguments *arguments, const scene *fresh,
                  const char *path, json_t **report);
/* render_many.c: the same of each, and a list of what failed. Exit status. */
int check_many(const render_arguments *a, const char **paths, int count);
int render_many(cvol_context *context, const render_arguments *arguments, const scene *fresh,
                const char **paths, int count);

/* output_name.c: `pattern` with {name} (the input's, without folder and ending) and {n} (a number,
 * `digits` long) put in; NULL: these stay. The caller frees it; NULL after a sentence. */
char *output_name(const char *pattern, const char *path, int number, int digits);

#endif
