/* Searches the step of a picture's planes.
 *
 * Planes are transformed once; an encode attempt quantizes all coefficients, and codes them or
 * draws the picture. Size and error are nearly monotonic in the step: the search keeps the coarsest
 * tried step that meets a PSNR, or the finest that meets a ratio.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/container/plane_code.h"
#include "image/picture.h"

/* Steps for levels 0 .. 1: finer ones do not change pixels, and coarser ones drop all terms. */
#define STEP_MIN (1.0 / 16384)
#define STEP_MAX 256.0
/* The precision of the search, and its largest number of encode attempts. */
#define NEAR 1.01
enum { ATTEMPTS = 24 };

/* Opacity affects only the background: over black it may be coarser. */
#define OPACITY_OVER_BLACK 4.0

typedef struct search {
    cvol_context *context;
    const cvol_picture_options *options;
    cvol_image *truth; /* of the planes themselves */
    cvol_image *drawn;
    cvol_picture *exact; /* its planes are not quantized */
    cvol_picture *best;
} search;

/* ---- exact planes --------------------------------------------------------------------------- */

/* Mixed colour c of 3, or opacity. */
static void mix(float *out, const cvol_picture_source *from, size_t count, int c)
{
    static const double mixes[3][3] = {{1, 1, 1}, {1, 0, -1}, {1, -2, 1}};
    static const double squares[3] = {3, 2, 6};
    if (c == CVOL_PICTURE_OPACITY) {
        memcpy(out, from->planes[c], count * sizeof *out);
        return;
    }
    double w[3];
    for (int i = 0; i < 3; i++)
        w[i] = mixes[c][i] / sqrt(squares[c]);
    for (size_t i = 0; i < count; i++)
        out[i] = (float)(w[0] * (double)from->planes[0][i] + w[1] * (double)from->planes[1][i] +
                         w[2] * (double)from->planes[2][i]);
}

static int transform_planes(cvol_context *context, cvol_picture *exact,
                            const cvol_picture_source *from)
{
    const size_t count = from->lattice[0] * from->lattice[1];
    const cvol_grid grid = cvol_grid_make(from->lattice[0], from->lattice[1], 1, CVOL_FLOAT32);
    const cvol_keep all = cvol_keep_all();
    float *mixed = cvol_allocate(count, sizeof *mixed);
    int code = mixed ? CVOL_OK : cvol_fail_memory(context, count * sizeof *mixed, "a picture");
    for (int c = 0; c < exact->plane_count && !code; c++) {
        mix(mixed, from, count, c);
        code = cvol_array_compress(context, &exact->planes[c], mixed, &grid, 2, exact->transform,
                                   exact->block, &all);
    }
    free(mixed);
    return code;
}

/* A picture without planes. */
static cvol_picture *describe(const cvol_picture_source *from, const cvol_picture_options *options)
{
    cvol_picture *picture = calloc(1, sizeof *picture);
    if (!picture)
        return NULL;
    *picture = (cvol_picture){.width = from->width,
                              .height = from->height,
                              .is_over = from->is_over,
                              .lattice = {from->lattice[0], from->lattice[1]},
                              .transform = options->transform,
                              .block = options->block,
                              .plane_count = from->planes[CVOL_PICTURE_OPACITY] ? 4 : 3};
    memcpy(picture->to_intermediate, from->to_intermediate, sizeof picture->to_intermediate);
    memcpy(picture->background, from->background, sizeof picture->background);
    return picture;
}

/* ---- encode attempts ------------------------------------------------------------------------- */

static int is_black(const double background[3])
{
    return background[0] <= 0 && background[1] <= 0 && background[2] <= 0;
}

static int quantise(search *s, cvol_picture **out, double step)
{
    cvol_picture *picture = malloc(sizeof *picture);
    *out = NULL;
    if (!picture)
        return cvol_fail_memory(s->context, sizeof *picture, "a picture");
    *picture = *s->exact;
    memset(picture->planes, 0, sizeof picture->planes);
    int code = CVOL_OK;
    for (int c = 0; c < picture->plane_count && !code; c++) {
        const int coarser = c == CVOL_PICTURE_OPACITY && picture->is_over &&
                            is_black(picture->background);
        picture->steps[c] = coarser ? OPACITY_OVER_BLACK * step : step;
        code = cvol_plane_quantise(s->context, &picture->planes[c], s->exact->planes[c],
                                   picture->steps[c]);
    }
    if (code)
        cvol_picture_free(picture);
    else
        *out = picture;
    return code;
}

/* Over all channels of the pixels. */
static double psnr_of(const cvol_image *a, const cvol_image *b)
{
    const size_t bytes = 4 * (size_t)a->width * (size_t)a->height;
    uint64_t squares = 0;
    for (size_t i = 0; i < bytes; i++) {
        const int off = a->rgba[i] - b->rgba[i];
        squares += (uint64_t)(off * off);
    }
    return squares ? 10 * log10(255.0 * 255 * 0.75 * (double)bytes / (double)squares)
                   : (double)INFINITY;
}

static int measure(search *s, cvol_picture *picture)
{
    int code = cvol_picture_draw(s->context, s->drawn, picture);
    if (!code)
        picture->psnr_db = psnr_of(s->truth, s->drawn);
    return code;
}

/* 1 if a step is fine enough for a PSNR, or coarse enough for a ratio. *off: the factor by which
 * the step might be coarser. */
static int try_step(search *s, double step, int *holds, double *off)
{
    cvol_picture *picture;
    int code = quantise(s, &picture, step);
    if (code)
        return code;
    if (s->options->ratio > 0) {
        cvol_bytes bytes = {0};
        const int channels = picture->is_over ? 3 : picture->plane_count;
        const double raw = (double)picture->width * picture->height * channels;
        code = cvol_picture_put(s->context, &bytes, picture);
        const double ratio = raw / (double)bytes.size;
        *holds = ratio >= s->options->ratio;
        *off = s->options->ratio / ratio;
        cvol_bytes_free(&bytes);
    } else {
        code = measure(s, picture);
        *holds = picture->psnr_db >= s->options->psnr_db;
        *off = pow(10, fmin(picture->psnr_db - s->options->psnr_db, 60) / 20);
    }
    if (!code && *holds) {
        cvol_picture *before = s->best;
        s->best = picture;
        picture = before;
    }
    cvol_picture_free(picture);
    return code;
}

/* Between valid and invalid steps, in the logarithm; the first encode attempts use the missing
 * amount. */
static int find(search *s)
{
    const int coarse_holds = s->options->ratio > 0;
    double least = STEP_MIN, most = STEP_MAX;
    double step = coarse_holds ? 0.05 : sqrt(12) * pow(10, -s->options->psnr_db / 20);
    int code = CVOL_OK;
    for (int i = 0; i < ATTEMPTS && most / least > NEAR && !code; i++) {
        int holds = 0;
        double off = 1;
        step = fmin(fmax(step, least * 1.0001), most / 1.0001);
        code = try_step(s, step, &holds, &off);
        if (!code)
            code = cvol_report_progress(s->context, "compressing the picture",
                                        i / (double)ATTEMPTS);
        if (holds == coarse_holds)
            most = step;
        else
            least = step;
        const double guess = step * (i < 4 ? off * (off > 1 ? 1.01 : 0.99) : off);
        step = i < 4 && guess > least && guess < most ? guess : sqrt(least * most);
    }
    if (code || s->best)
        return code;
    return coarse_holds
               ? cvol_fail(s->context, CVOL_ERROR_TARGET,
                           "ratio %g cannot be reached for this picture", s->options->ratio)
               : cvol_fail(s->context, CVOL_ERROR_TARGET,
                           "%g dB cannot be reached for this picture", s->options->psnr_db);
}

/* ---- the whole ------------------------------------------------------------------------------ */

static int check_options(cvol_context *context, const cvol_picture_options *options)
{
    if (options->ratio > 0 ? !(options->ratio > 1 && options->ratio <= 1e9)
                           : !(options->psnr_db > 0 && options->psnr_db <= 100))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a picture's ratio must be above 1, or its PSNR above 0 and at most "
                         "100 dB");
    return CVOL_OK;
}

int cvol_picture_make(cvol_context *context, cvol_picture **out, const cvol_picture_source *source,
                      const cvol_picture_options *options)
{
    search s = {.context = context, .options = options};
    *out = NULL;
    int code = check_options(context, options);
    if (code)
        return code;
    code = cvol_image_create(context, &s.drawn, source->width, source->height);
    if (!code)
        code = cvol_image_create(context, &s.truth, source->width, source->height);
    if (!code)
        code = cvol_picture_draw_planes(context, s.truth, source);
    if (!code && !(s.exact = describe(source, options)))
        code = cvol_fail_memory(context, sizeof *s.exact, "a picture");
    if (!code)
        code = transform_planes(context, s.exact, source);
    if (!code)
        code = find(&s);
    if (!code && options->ratio > 0)
        code = measure(&s, s.best);
    if (code)
        cvol_picture_free(s.best);
    else
        *out = s.best;
    cvol_picture_free(s.exact);
    cvol_image_free(s.drawn);
    cvol_image_free(s.truth);
    return code;
}
