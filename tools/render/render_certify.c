/* --certify: bounds of the picture of the original samples, and how wide they are. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_picture.h"

/* Bounds wider than this, in levels, are counted. */
#define WIDE 8
/* A median above this says that the bounds are of little use. */
#define USELESS 128

/* ---- arguments --------------------------------------------------------------------------- */

int check_certify(const scene *s, const render_arguments *a)
{
    const char *other = a->poses              ? "--poses"
                        : a->turntable_given  ? "--turntable"
                        : a->over_time        ? "--over-time"
                        : a->progressive      ? "--progressive"
                        : a->annotate         ? "--annotate"
                        : a->transparent      ? "--background transparent"
                        : a->has_gradient     ? "--background gradient"
                        : a->depth_name       ? "--depth"
                        : a->opacity_name     ? "--opacity"
                        : a->common.level > 0 ? "--level"
                        : a->bits != 8        ? "--bits"
                                              : NULL;
    if (!a->certify)
        return EXIT_DONE;
    if (s->engine != CVOL_ENGINE_RAY)
        return report_error(EXIT_MISUSED, "--certify draws with engine ray: leave out --engine %s",
                            a->engine_name);
    if (other)
        return report_error(EXIT_MISUSED, "--certify cannot be combined with %s", other);
    if (a->output && picture_kind_of(a->output) != PICTURE_PNG)
        return report_error(EXIT_MISUSED,
                            "%s: --certify writes four PNG files: the name must end in .png",
                            a->output);
    return EXIT_DONE;
}

/* OUT.lower.png for OUT.png; the caller frees it; NULL after a message. */
static char *name_with(const char *output, const char *what)
{
    const char *ending = strrchr(output, '.');
    const size_t size = strlen(output) + strlen(what) + 2;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s.%s%s", (int)(ending - output), output, what, ending);
    else
        report_error(EXIT_FAILED, "not enough memory");
    return name;
}

/* ---- widths ------------------------------------------------------------------------------ */

/* The largest width of the channels of a pixel. */
static int width_of(const uint8_t *lower, const uint8_t *upper)
{
    int width = 0;
    for (int c = 0; c < 3; c++)
        width = upper[c] - lower[c] > width ? upper[c] - lower[c] : width;
    return width;
}

/* 1 if the pixel may show more than the background. */
static int is_drawn(const uint8_t *lower, const uint8_t *upper, const uint8_t *background)
{
    return memcmp(lower, background, 3) || memcmp(upper, background, 3);
}

/* The least width that at least this share of the counted pixels does not exceed. */
static int quantile(const uint64_t counts[256], uint64_t pixels, double share)
{
    uint64_t sum = 0;
    for (int width = 0; width < 256; width++) {
        sum += counts[width];
        if (sum > 0 && (double)sum >= share * (double)pixels)
            return width;
    }
    return 0;
}

/* Fills the image of widths and the figures. */
static void measure_widths(certificate *out, cvol_image *widths, const cvol_image *lower,
                           const cvol_image *upper, const double background[3])
{
    uint64_t counts[256] = {0}, wide = 0;
    uint8_t empty[3];
    for (int c = 0; c < 3; c++)
        empty[c] = (uint8_t)(background[c] * 255 + 0.5);
    out->worst = -1;
    for (int i = 0; i < widths->width * widths->height; i++) {
        const uint8_t *a = lower->rgba + 4 * (size_t)i, *b = upper->rgba + 4 * (size_t)i;
        uint8_t *pixel = widths->rgba + 4 * (size_t)i;
        const int width = width_of(a, b);
        memset(pixel, width, 3);
        pixel[3] = 255;
        if (!is_drawn(a, b, empty))
            continue;
        counts[width]++;
        out->pixels++;
        wide += width > WIDE;
        if (width > out->worst) {
            out->worst = width;
            out->worst_at[0] = i % widths->width;
            out->worst_at[1] = i / widths->width;
        }
    }
    out->worst = out->worst > 0 ? out->worst : 0;
    out->median = quantile(counts, out->pixels, 0.5);
    out->most = quantile(counts, out->pixels, 0.9);
    out->wide_share = out->pixels ? (double)wide / (double)out->pixels : 0;
}

/* ---- pictures ---------------------------------------------------------------------------- */

/* The error and the range of the original samples. Dense samples are the original. Exit status. */
static int find_known(certificate *out, double range[2], const scene *s, const char *path)
{
    cvol_array_info info;
    if (s->other_count)
        return report_error(EXIT_MISUSED,
                            "%s: --certify draws one channel: choose it with --channel", path);
    if (s->in.cut || s->in.level)
        return report_error(
            EXIT_FAILED, "%s: the file ends early, so the error of its samples is not known", path);
    if (!s->in.array)
        return EXIT_DONE;
    cvol_array_get_info(&info, s->in.array);
    if (!info.brick[0])
        return report_error(EXIT_FAILED,
                            "%s: --certify needs a volume in DCT blocks: compress it with "
                            "--transform dct --block 16",
                            path);
    out->max_error = info.max_error;
    /* A result of operations is exact as real numbers; stored samples of it would be rounded. */
    if (!info.measured && info.max_error > 0)
        out->max_error += cvol_type_is_integer(cvol_array_grid(s->in.array)->type)
                              ? 0.5
                              : 0x1p-23 * fmax(fabs(info.value_min), fabs(info.value_max));
    range[0] = info.value_min;
    range[1] = info.value_max;
    out->has_range = 1;
    return EXIT_DONE;
}

static int write_bounds(cvol_context *context, const certificate *names,
                        cvol_image *const images[3])
{
    int code = CVOL_OK;
    for (int k = 0; k < 3 && !code; k++)
        code = cvol_image_write_png(context, images[k], names->names[k]);
    return code;
}

/* Draws lower, upper and width. */
static int draw_bounds(cvol_context *context, scene *s, certificate *out, const double range[2],
                       cvol_image *images[3])
{
    int code = CVOL_OK;
    for (int k = 0; k < 3 && !code; k++)
        code = cvol_image_create(context, &images[k], s->options.width, s->options.height);
    const double start = milliseconds();
    if (!code)
        code = cvol_renderer_certify(context, s->renderer, images[0], images[1], &s->options,
                                     out->max_error, out->has_range ? range : NULL);
    out->ms = milliseconds() - start;
    if (code)
        return code;
    if (s->mirrored)
        for (int k = 0; k < 2; k++)
            cvol_image_mirror(images[k]);
    measure_widths(out, images[2], images[0], images[1], s->options.background);
    return CVOL_OK;
}

void print_certificate(const certificate *c, const char *path)
{
    printf("certified: samples of the original are within %.4g of the decoded ones; the bounds of "
           "%llu pixels have a median width of %d of 255, 90 %% at most %d, the worst %d at %d,%d; "
           "%.1f %% are above %d (%.0f ms)\n",
           c->max_error, (unsigned long long)c->pixels, c->median, c->most, c->worst,
           c->worst_at[0], c->worst_at[1], 100 * c->wide_share, WIDE, c->ms);
    if (c->median > USELESS)
        printf("%s: the bound of this file (max_error %.4g) says little about this picture; "
               "compress with --max-error\n",
               path, c->max_error);
}

/* Draws and writes the three files of bounds. Exit status. */
static int certify(cvol_context *context, scene *s, const render_arguments *a, const char *path,
                   certificate *out)
{
    static const char *const what[] = {"lower", "upper", "width"};
    cvol_image *images[3] = {NULL, NULL, NULL};
    double range[2] = {0, 0};
    int status = find_known(out, range, s, path), code = CVOL_OK;
    for (int k = 0; k < 3 && !status; k++) {
        out->names[k] = name_with(a->output, what[k]);
        status = out->names[k] ? check_output(path, out->names[k]) : EXIT_FAILED;
    }
    if (!status)
        code = draw_bounds(context, s, out, range, images);
    if (!status && !code)
        code = write_bounds(context, out, images);
    for (int k = 0; k < 3; k++)
        cvol_image_free(images[k]);
    clear_progress();
    return code ? report_context_error(context, code, path) : status;
}

int render_certified(cvol_context *context, scene *s, const render_arguments *a, const char *path,
                     outcome *result)
{
    certificate bounds = {0};
    int status = certify(context, s, a, path, &bounds);
    if (!status)
        status = write_picture(context, s, a, a->output, result);
    result->certificate = bounds; /* write_picture clears the outcome */
    return status;
}

void describe_certificate(json_t *object, const certificate *c)
{
    if (c->names[2])
        json_object_set_new(
            object, "certified",
            json_pack("{s:f, s:I, s:i, s:i, s:i, s:[i, i], s:f, s:f, s:o, s:o, s:o}", "max_error",
                      c->max_error, "pixels", (json_int_t)c->pixels, "median_width", c->median,
                      "width_90", c->most, "worst_width", c->worst, "worst_pixel", c->worst_at[0],
                      c->worst_at[1], "share_above_8", c->wide_share, "ms", c->ms, "lower",
                      json_text(c->names[0]), "upper", json_text(c->names[1]), "width",
                      json_text(c->names[2])));
}

void free_certificate(certificate *c)
{
    for (int k = 0; k < 3; k++)
        free(c->names[k]);
}
