/* Films: the common part of their formats. The file gets its name when it is complete. */
#include "image/film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/context.h"
#include "base/options.h"
#include "image/pixels.h"

static const cvol_film_format *const formats[] = {
    &cvol_film_gif,
    &cvol_film_webp,
};

const char *cvol_film_formats(void)
{
    if (cvol_film_gif.lacks)
        return cvol_film_webp.lacks ? "" : ".webp";
    return cvol_film_webp.lacks ? ".gif" : ".gif .webp";
}

static const cvol_film_options defaults = {
    .size = sizeof(cvol_film_options), .frames_per_second = 25, .quality = 90};

void cvol_film_options_set_defaults(cvol_film_options *options, size_t size)
{
    cvol_options_fill(options, size, &defaults, sizeof defaults);
}

static int ends(const char *path, const char *ending)
{
    const size_t length = strlen(path), tail = strlen(ending);
    return length > tail && !strcasecmp(path + length - tail, ending);
}

static const cvol_film_format *find_format(const char *path)
{
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (ends(path, formats[i]->ending))
            return formats[i];
    return NULL;
}

static int check(cvol_context *context, const cvol_film *film, const char *path)
{
    const cvol_film_options *options = &film->options;
    const cvol_film_format *format = film->format;
    if (!format)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: a film's name must end in %s", path,
                         *cvol_film_formats() ? cvol_film_formats() : ".gif .webp");
    if (format->lacks)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: this build of cvol writes no %s films (built without %s)", path,
                         format->name, format->lacks);
    if (film->width < 1 || film->height < 1 || film->width > format->size_max ||
        film->height > format->size_max)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: %d x %d pixels: width and height are 1 to %d", path, film->width,
                         film->height, format->size_max);
    if (!(options->frames_per_second > 0) || !(options->frames_per_second <= format->rate_max))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: %g frames a second: must be above 0 and at most %g", path,
                         options->frames_per_second, format->rate_max);
    if (options->quality < 0 || options->quality > 100)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: quality %d: must be 0 to 100", path,
                         options->quality);
    return CVOL_OK;
}

int cvol_film_open(cvol_context *context, cvol_film **out, const char *path, int width, int height,
                   const cvol_film_options *options)
{
    cvol_film_options full = defaults;
    *out = NULL;
    int code = cvol_options_copy(context, &full, sizeof full,
                                 CVOL_SIZE_TO(cvol_film_options, quality), "cvol_film_options",
                                 options);
    if (code)
        return code;
    cvol_film *film = calloc(1, sizeof *film);
    if (!film)
        return cvol_fail_memory(context, sizeof *film, "a film");
    film->format = find_format(path);
    film->width = width;
    film->height = height;
    film->options = full;
    code = check(context, film, path);
    if (!code)
        code = cvol_output_open(context, &film->output, path);
    if (!code) {
        film->path = cvol_output_name(film->output);
        code = film->format->open(context, film);
    }
    if (code)
        cvol_film_abandon(film);
    else
        *out = film;
    return code;
}

int cvol_film_needs_palette(const cvol_film *film)
{
    return film->format->needs_palette;
}

static int check_picture(cvol_context *context, const cvol_film *film, const cvol_image *image)
{
    const int code = cvol_image_need_bytes(context, image, film->path);
    if (code || (image->width == film->width && image->height == film->height))
        return code;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: a picture of %d x %d in a film of %d x %d",
                     film->path, image->width, image->height, film->width, film->height);
}

int cvol_film_sample_palette(cvol_context *context, cvol_film *film, const cvol_image *image)
{
    const int code = check_picture(context, film, image);
    return code || !film->format->needs_palette
               ? code
               : film->format->sample_palette(context, film, image);
}

int cvol_film_add(cvol_context *context, cvol_film *film, const cvol_image *image)
{
    int code = check_picture(context, film, image);
    if (!code && film->format->needs_palette && film->frames == 0)
        code = film->format->sample_palette(context, film, image);
    if (!code)
        code = film->format->add(context, film, image);
    film->frames += !code;
    return code;
}

int cvol_film_commit(cvol_context *context, cvol_film *film)
{
    int code = film->frames ? film->format->finish(context, film)
                            : cvol_fail(context, CVOL_ERROR_ARGUMENT,
                                        "%s: a film needs pictures, none was added", film->path);
    if (!code) {
        code = cvol_output_commit(context, film->output);
        film->output = NULL;
    }
    cvol_film_abandon(film);
    return code;
}

void cvol_film_abandon(cvol_film *film)
{
    if (!film)
        return;
    cvol_output_abandon(film->output);
    if (film->format && film->state)
        film->format->free(film->state);
    free(film);
}
