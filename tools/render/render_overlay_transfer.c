/* Transfer functions of overlays.
 *
 * Labels have a colour for each. Other overlays are read by their colours, and must not hide what
 * is hot in them: opacity rises from 0 at the low end of a window to OPACITY_MOST at its high end,
 * as t^OPACITY_POWER, and the colours of a named function are spread over the same window. Without
 * --overlay-window the window begins above the background, at LOW_SHARE of the range of the object,
 * and ends below its brightest samples. */
#include <math.h>
#include <string.h>

#include "tools/render/render_overlay.h"

#define LOW_SHARE 0.2
#define BRIGHTEST 5e-4 /* share of the samples beyond the background */
#define OPACITY_MOST 0.3
#define OPACITY_POWER 2
#define POINTS 33
/* The density of the picture of depths. */
#define DEPTH_DENSITY 8

/* ---- values ---- */

/* The value that this share of the samples above `edge` exceed. */
static double high_value(const cvol_histogram *h, double edge)
{
    const double width = (h->max - h->min) / CVOL_HISTOGRAM_BINS;
    double all = 0, sum = 0;
    int i = CVOL_HISTOGRAM_BINS;
    for (int k = 0; k < CVOL_HISTOGRAM_BINS; k++)
        all += h->min + (k + 1) * width > edge ? (double)h->bins[k] : 0;
    while (i > 0 && sum + (double)h->bins[i - 1] <= BRIGHTEST * all)
        sum += (double)h->bins[--i];
    return h->min + i * width;
}

/* The window without --overlay-window: `fitted` begins at the end of the background. */
static void find_window(double window[2], const cvol_transfer *fitted, const cvol_histogram *h)
{
    const double edge = cvol_transfer_point_at(fitted, 0).value, top = high_value(h, edge);
    window[0] = edge + LOW_SHARE * (top - edge);
    window[1] = top > window[0] ? top : edge + 1;
}

/* The colours of a named function over the window. A code of the library. */
static int spread(cvol_context *context, cvol_transfer **out, const cvol_transfer *named,
                  const double window[2])
{
    cvol_transfer_point points[POINTS];
    const size_t count = cvol_transfer_count(named);
    size_t at = 0;
    const double first = cvol_transfer_point_at(named, 0).value,
                 span = cvol_transfer_point_at(named, count - 1).value - first;
    for (int i = 0; i < POINTS; i++) {
        const double t = (double)i / (POINTS - 1);
        while (at + 1 < count && cvol_transfer_point_at(named, at + 1).value <= first + t * span)
            at++;
        points[i] = cvol_transfer_point_at(named, at);
        points[i].value = window[0] + t * (window[1] - window[0]);
        points[i].opacity = OPACITY_MOST * pow(t, OPACITY_POWER);
    }
    return cvol_transfer_create(context, out, points, POINTS);
}

/* 1 if the fitted function shows values on both sides of a background. */
static int is_signed(const cvol_transfer *fitted)
{
    return cvol_transfer_point_at(fitted, 0).opacity > 0;
}

/* The colours of `name`. Exit status. */
static int use_colours(cvol_context *context, cvol_transfer **out, const cvol_histogram *histogram,
                       const char *name, const double *window)
{
    cvol_transfer *named = NULL;
    double own[2];
    int code = cvol_transfer_create_named(context, &named, name, histogram);
    if (!code && !window && is_signed(named)) {
        *out = named;
        return CVOL_OK;
    }
    if (!code && !window)
        find_window(own, named, histogram);
    if (!code)
        code = spread(context, out, named, window ? window : own);
    cvol_transfer_free(named);
    return code;
}

static int is_file(const char *name)
{
    return strchr(name, '.') || strchr(name, '/');
}

/* Exit status. */
static int make_transfer(cvol_context *context, cvol_transfer **out, const overlay *o,
                         const cvol_volume *volume, const char *name, const double *window)
{
    cvol_histogram histogram;
    cvol_transfer *plain = NULL;
    double rescale[2];
    if (o->labels) {
        const int failure = cvol_labels_create_mask_transfer(context, out);
        return failure ? report_context_error(context, failure, o->path) : EXIT_DONE;
    }
    int code = cvol_volume_compute_histogram(context, &histogram, volume);
    if (!code && name && is_file(name))
        code = cvol_transfer_read(context, &plain, name);
    else if (!code && name && cvol_transfer_is_ct(name)) {
        if (cvol_hounsfield_guess(rescale, &histogram, &volume->grid) == CVOL_HOUNSFIELD_NO)
            return report_error(EXIT_FAILED,
                                "%s: values %g to %g are not Hounsfield units, which "
                                "--overlay-transfer %s needs",
                                o->path, histogram.min, histogram.max, name);
        code = cvol_transfer_create_ct(context, &plain, name, rescale);
    } else if (!code && (name ? !strcmp(name, "auto") : o->is_labels))
        code = cvol_transfer_create_auto(context, &plain, NULL, rescale, &histogram, &volume->grid,
                                         1);
    else if (!code)
        code = use_colours(context, out, &histogram, name ? name : "hot", window);
    if (!code && plain)
        code = cvol_transfer_create_adjusted(context, out, plain, window, 1);
    cvol_transfer_free(plain);
    return code ? report_context_error(context, code, o->path) : EXIT_DONE;
}

/* Opacities are those over a spacing of the drawn samples. A code of the library. */
static int adjust_density(cvol_context *context, overlay *o, double density)
{
    cvol_transfer *plain = o->transfer;
    o->transfer = NULL;
    const int code = cvol_transfer_create_adjusted(context, &o->transfer, plain, NULL, density);
    cvol_transfer_free(plain);
    return code;
}

int choose_overlay_transfer(cvol_context *context, overlay *o, const cvol_volume *volume,
                            const char *name, const char *window_text, double density)
{
    const cvol_grid *grid = &volume->grid;
    double window[2], ends[2];
    o->rescale[0] = fabs(grid->value_scale) > 0 ? grid->value_scale : 1;
    o->rescale[1] = grid->value_offset;
    if (window_text && o->is_labels && !name)
        return report_error(EXIT_MISUSED, "%s: --overlay-window does not work with labels",
                            o->path);
    if (window_text) {
        parse_numbers(window, 2, window_text);
        ends[0] = (window[0] - window[1] / 2 - o->rescale[1]) / o->rescale[0];
        ends[1] = (window[0] + window[1] / 2 - o->rescale[1]) / o->rescale[0];
        window[0] = fmin(ends[0], ends[1]);
        window[1] = fmax(ends[0], ends[1]);
    }
    const int status = make_transfer(context, &o->transfer, o, volume, name,
                                     window_text ? window : NULL);
    if (status)
        return status;
    int code = !o->labels && (density > 1 || density < 1) ? adjust_density(context, o, density)
                                                          : CVOL_OK;
    if (!code)
        code = cvol_transfer_create_adjusted(context, &o->dense, o->transfer, NULL, DEPTH_DENSITY);
    return code ? report_context_error(context, code, o->path) : EXIT_DONE;
}
