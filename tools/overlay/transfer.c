/* Transfer functions of overlays.
 *
 * Labels have a colour for each. Other overlays are read by their colours, and must not hide what
 * is hot in them: opacity rises from 0 at the low end of a window to OPACITY_MOST at its high end,
 * as t^OPACITY_POWER, and the colours of a named function are spread over the same window. Without
 * --overlay-window the window begins above the background, at LOW_SHARE of the range of the object,
 * and ends below its brightest samples. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/context.h"
#include "tools/overlay/overlay.h"

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

/* The colours of a named function over the window. */
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

int overlay_is_blank(const overlay_source *source, const overlay_look *look)
{
    return source->has_one_value && !look->given && !look->has_window &&
           !(look->transfer && cvol_transfer_is_ct(look->transfer));
}

/* 1 if the fitted function shows values on both sides of a background. */
static int is_signed(const cvol_transfer *fitted)
{
    return cvol_transfer_point_at(fitted, 0).opacity > 0;
}

/* The colours of `name`. */
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

static int make_plain(cvol_context *context, cvol_transfer **out, cvol_transfer **plain,
                      const overlay_source *source, const overlay_look *look)
{
    const cvol_histogram *h = &source->histogram;
    const cvol_grid *grid = &source->grid;
    const char *name = look->transfer;
    double rescale[2];
    if (name && cvol_transfer_is_ct(name)) {
        if (cvol_hounsfield_guess(rescale, h, grid) == CVOL_HOUNSFIELD_NO)
            return cvol_fail(context, CVOL_ERROR_DATA,
                             "values %g to %g are not Hounsfield units, which the transfer "
                             "function %s needs",
                             h->min, h->max, name);
        return cvol_transfer_create_ct(context, plain, name, rescale);
    }
    if (name ? !strcmp(name, "auto") : source->is_labels)
        return cvol_transfer_create_auto(context, plain, NULL, rescale, h, grid, 1);
    return use_colours(context, out, h, name ? name : "hot",
                       look->has_window ? look->window : NULL);
}

static int make_transfer(cvol_context *context, cvol_transfer **out, const overlay_source *source,
                         const overlay_look *look)
{
    cvol_transfer *plain = NULL;
    const double *window = look->has_window ? look->window : NULL;
    if (source->is_numbered)
        return cvol_labels_create_mask_transfer(context, out);
    if (look->given)
        return cvol_transfer_create_adjusted(context, out, look->given, window, 1);
    int code = make_plain(context, out, &plain, source, look);
    if (!code && plain)
        code = cvol_transfer_create_adjusted(context, out, plain, window, 1);
    cvol_transfer_free(plain);
    return code;
}

/* Makes the only value transparent. */
static int clear(cvol_context *context, cvol_transfer **transfer)
{
    cvol_transfer_point point = cvol_transfer_point_at(*transfer, 0);
    cvol_transfer_free(*transfer);
    *transfer = NULL;
    point.opacity = 0;
    return cvol_transfer_create(context, transfer, &point, 1);
}

/* Opacities are those over a spacing of the drawn samples. */
static int adjust_density(cvol_context *context, cvol_transfer **transfer, double density)
{
    cvol_transfer *plain = *transfer;
    *transfer = NULL;
    const int code = cvol_transfer_create_adjusted(context, transfer, plain, NULL, density);
    cvol_transfer_free(plain);
    return code;
}

int overlay_create_transfers(cvol_context *context, cvol_transfer **colours, cvol_transfer **depths,
                             const overlay_source *source, const overlay_look *look, double density)
{
    char message[400];
    *colours = *depths = NULL;
    int code = make_transfer(context, colours, source, look);
    if (!code && overlay_is_blank(source, look))
        code = clear(context, colours);
    if (!code && !source->is_numbered && (density > 1 || density < 1))
        code = adjust_density(context, colours, density);
    if (!code)
        code = cvol_transfer_create_adjusted(context, depths, *colours, NULL, DEPTH_DENSITY);
    if (!code)
        return CVOL_OK;
    cvol_transfer_free(*colours);
    *colours = NULL;
    snprintf(message, sizeof message, "%s", cvol_context_message(context));
    return cvol_fail(context, code, "%s: %s", source->path, message);
}

void overlay_get_rescale(double rescale[2], const overlay_source *source)
{
    const cvol_grid *grid = &source->grid;
    rescale[0] = grid->value_scale;
    rescale[1] = grid->value_offset;
}

int overlay_get_window(double window[2], const overlay_source *source, const double given[2])
{
    double rescale[2], ends[2];
    overlay_get_rescale(rescale, source);
    ends[0] = (given[0] - given[1] / 2 - rescale[1]) / rescale[0];
    ends[1] = (given[0] + given[1] / 2 - rescale[1]) / rescale[0];
    window[0] = fmin(ends[0], ends[1]);
    window[1] = fmax(ends[0], ends[1]);
    return window[0] < window[1] && isfinite(window[1] - window[0]);
}
