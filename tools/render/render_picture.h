/* Pictures of cvol render: from a scene to files. */
#ifndef CVOL_TOOLS_RENDER_PICTURE_H
#define CVOL_TOOLS_RENDER_PICTURE_H

#include "tools/base/picture.h"
#include "tools/render/render_options.h"

/* The format of a picture, by its extension. */
typedef enum picture_kind {
    PICTURE_NONE, /* unknown */
    PICTURE_PNG,
    PICTURE_JPEG,
    PICTURE_WEBP,
    PICTURE_PFM,
    PICTURE_CVI
} picture_kind;
picture_kind picture_kind_of(const char *name);

/* Results of --certify; widths of the bounds are in levels of 255. */
typedef struct certificate {
    double max_error; /* of the samples */
    int has_range;    /* the range of the original samples is known */
    uint64_t pixels;  /* number of pixels that may show more than the background; of these: */
    int median, most, worst, worst_at[2]; /* most: nine of ten widths are not above it */
    double wide_share;                    /* share of the widths above 8 */
    double ms;
    char *names[3]; /* files: lower, upper, width; NULL without --certify */
} certificate;

/* Results of drawing one picture. */
typedef struct outcome {
    double render_ms;
    int is_compressed;
    cvol_picture_info info; /* if is_compressed */
    certificate certificate;
} outcome;

/* Milliseconds of a turntable: each picture to render, and all in all. */
typedef struct turn_times {
    double frame_ms, total_ms;
} turn_times;

/* Checks the name of the picture and related options. Exit status. */
int check_picture(const scene *s, const render_arguments *a);
/* Checks only the format of the file. */
int check_kind(const scene *s, const render_arguments *a);
/* Renders the picture, as floats or as bytes. Exit status. */
int take_picture(cvol_context *context, scene *s, const render_arguments *a, int floats,
                 cvol_image **out, double *render_ms);
/* Renders a picture and writes it as PNG or PFM. Exit status. */
int write_pixels(cvol_context *context, scene *s, const render_arguments *a, const char *output,
                 outcome *result);
/* Renders a picture and writes it. Exit status. */
int write_picture(cvol_context *context, scene *s, const render_arguments *a, const char *output,
                  outcome *result);
/* Prints a line about a picture that has its name. */
void print_picture(const scene *s, const char *output, const outcome *result);
/* Adds the results of one picture to a JSON object. */
void describe_outcome(json_t *object, cvol_context *context, const scene *s, const outcome *result);
/* Adds camera and grey levels to a JSON object. */
void describe_view(json_t *object, cvol_context *context, const scene *s,
                   const render_arguments *a);

/* render_maps.c: --depth and --opacity. has_maps: one was given. check_maps checks them, for this
 * number of volumes; write_maps writes them from a picture of floats. Exit status. */
static inline int has_maps(const render_arguments *a)
{
    return a->depth_name || a->opacity_name;
}
int check_maps(const scene *s, const render_arguments *a, int volumes);
int write_maps(cvol_context *context, const render_arguments *a, const cvol_image *image);
/* Makes the names of these files for this input; free_maps frees them. Exit status. */
int name_maps(render_arguments *a, const char *path);
void free_maps(render_arguments *a);
void describe_maps(json_t *object, const render_arguments *a);

/* render_certify.c: --certify. check_certify checks the options; render_certified draws and writes
 * the bounds and the picture; free_certificate frees the names. Exit status. */
int check_certify(const scene *s, const render_arguments *a);
int render_certified(cvol_context *context, scene *s, const render_arguments *a, const char *path,
                     outcome *result);
void print_certificate(const certificate *certificate, const char *path);
void describe_certificate(json_t *object, const certificate *certificate);
void free_certificate(certificate *certificate);

/* render_channels.c: like open_scene, but opens all channels, each in its colour, if the input has
 * several and the options choose none. Exit status. */
int open_channels(cvol_context *context, scene *s, render_arguments *a, const char *path);
/* The number of times, if none was chosen, and of channels that are drawn together. Exit status. */
int count_drawn(cvol_context *context, const scene *s, render_arguments *a, const char *path,
                int *times, int *channels);
/* render_colours.c: 1 if RGB samples are drawn as one shape with colours; open_colours is like
 * open_scene for these: channels red, green, blue, and alpha if there are four. Exit status. */
int can_draw_colours(const scene *s, const render_arguments *a);
int open_colours(cvol_context *context, scene *s, const render_arguments *a, const double *rgb,
                 int channels, const char *path);
/* Draws a shape with its colours, of labels or of RGB samples, into a picture of floats; budget_ms:
 * above 0: at the finest level that this time allows. A code of the library. */
int draw_coloured(cvol_context *context, scene *s, double budget_ms, cvol_image *image);
/* Draws all channels into a picture of floats, which must be black. A code of the library. */
int draw_channels(cvol_context *context, scene *s, cvol_image *image);
/* render_overlay.c: draws the volume and its overlays into a picture of floats, which must be
 * black. A code of the library. overlay_bar: transfer function and rescale of the first overlay
 * that is no labels, for the bar of colours; NULL: none. */
int draw_overlays(cvol_context *context, scene *s, cvol_image *image);
const cvol_transfer *overlay_bar(double rescale[2], const scene *s);
void describe_overlays(json_t *object, const scene *s);
/* render_stages.c: --progressive. Exit status. */
int render_stages(cvol_context *context, render_arguments *arguments, scene *s, const char *path,
                  json_t *pictures, outcome *result);
/* render_turn.c: --turntable. Exit status. */
int check_turntable(const scene *s, const render_arguments *a);
int render_turntable(cvol_context *context, scene *s, render_arguments *a, const char *path,
                     turn_times *times);
void print_turn(const scene *s, const render_arguments *a, const turn_times *times);
void describe_turn(json_t *object, const render_arguments *a, const turn_times *times);
/* render_times.c: --over-time, a turntable with one picture for each time. check_over_time checks
 * the options; open_time opens the scene of a time; fit_times, called first, fits value ranges to
 * all times (the caller frees *out). Exit status. */
int check_over_time(render_arguments *a);
int open_time(cvol_context *context, scene *s, render_arguments *a, const char *path, int time);
int fit_times(cvol_context *context, cvol_histogram **out, const scene *fresh, render_arguments *a,
              const char *path);
/* render_volume.c: draws all pictures of one volume; *report: their JSON, or NULL without --json.
 * Exit status. */
int render_volume(cvol_context *context, const render_arguments *arguments, const scene *fresh,
                  const char *path, json_t **report);
/* render_many.c: the same for each volume; lists the failures. Exit status. */
int check_many(const render_arguments *a, const char **paths, int count);
int render_many(cvol_context *context, const render_arguments *arguments, const scene *fresh,
                const char **paths, int count);

/* output_name.c: replaces {name} in `pattern` by the input's name without folder and extension
 * (path NULL: not), and {n} by the number with `digits` digits (0: not). The caller frees it; NULL
 * without memory. */
char *output_name(const char *pattern, const char *path, int number, int digits);

#endif
