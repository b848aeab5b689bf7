/* From values to colours and grey levels: transfer functions, windows, and the scale of values. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_options.h"

/* The name of a file has a dot or a slash; the name of a transfer function has neither. */
int is_file_name(const char *name)
{
    return strchr(name, '.') || strchr(name, '/');
}

int check_values(render_arguments *a, cvol_mode mode)
{
    a->window_auto = a->window_text && !strcmp(a->window_text, "auto");
    if (a->window_auto && mode == CVOL_MODE_COMPOSITE)
        return report_error(
            EXIT_MISUSED, "--window auto works only in modes xray, mip and min; in mode composite "
                          "--transfer auto fits the values");
    if (a->window_auto)
        a->window[1] = 1;
    if (a->window_text && !a->window_auto && !parse_numbers(a->window, 2, a->window_text))
        return report_error(
            EXIT_MISUSED, "--window is '%s', must be C,W: centre and width, as in 40,400, or auto",
            a->window_text);
    if (a->window_text && !(a->window[1] > 0))
        return report_error(EXIT_MISUSED, "--window has width %g, must be above 0", a->window[1]);
    if (a->rescale_text && !parse_numbers(a->rescale, 2, a->rescale_text))
        return report_error(
            EXIT_MISUSED, "--rescale is '%s', must be S,I: a sample s means S s + I, as in 1,-1024",
            a->rescale_text);
    if (a->rescale_text && !(fabs(a->rescale[0]) > 0))
        return report_error(EXIT_MISUSED, "--rescale has slope 0, must not be 0");
    if (a->opacity_scale_given && !(a->opacity_scale >= 0))
        return report_error(EXIT_MISUSED, "--opacity-scale is %g, must be 0 or above",
                            a->opacity_scale);
    if (a->colormap && mode != CVOL_MODE_COMPOSITE)
        return report_error(EXIT_MISUSED, "--colormap works only with --mode composite");
    if (a->opacity_scale_given && mode != CVOL_MODE_COMPOSITE)
        return report_error(EXIT_MISUSED, "--opacity-scale works only with --mode composite");
    return EXIT_DONE;
}

/* Sets the rescale to Hounsfield units, by --rescale or by a guess from the values. Exit status. */
static int find_hounsfield(scene *s, const render_arguments *a, const cvol_histogram *histogram,
                           const char *path)
{
    s->value_unit = "HU";
    if (a->rescale_text)
        return EXIT_DONE;
    switch (cvol_hounsfield_guess(s->rescale, histogram, input_grid(&s->in))) {
    case CVOL_HOUNSFIELD_YES:
        return EXIT_DONE;
    case CVOL_HOUNSFIELD_SHIFTED:
        clear_progress();
        fprintf(stderr,
                "cvol: %s: values %g to %g are read as Hounsfield units plus 1024; give --rescale "
                "if that "
                "is wrong\n",
                path, histogram->min, histogram->max);
        return EXIT_DONE;
    case CVOL_HOUNSFIELD_NO:
        break;
    }
    return report_error(EXIT_FAILED,
                        "%s: values %g to %g are not Hounsfield units (air -1000, water 0), which "
                        "--transfer %s needs: give --rescale S,I, or another transfer function",
                        path, histogram->min, histogram->max, a->transfer_name);
}

int find_histogram(cvol_context *context, cvol_histogram *out, const scene *s)
{
    if (s->shared) {
        *out = *s->shared;
        return EXIT_DONE;
    }
    const int code = s->in.array ? cvol_array_compute_histogram(context, out, s->in.array)
                                 : cvol_volume_compute_histogram(context, out, s->in.volume);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

/* 1 if the samples are the original ones. */
static int has_original_samples(const scene *s)
{
    cvol_array_info info;
    if (!s->in.array)
        return 1;
    cvol_array_get_info(&info, s->in.array);
    return isinf(info.psnr_db) && info.psnr_db > 0 && !s->in.level;
}

int read_transfer(cvol_context *context, cvol_transfer **out, const char *name,
                  const double rescale[2])
{
    cvol_transfer *values = NULL;
    *out = NULL;
    int code = cvol_transfer_read(context, &values, name);
    if (!code)
        code = cvol_transfer_create_rescaled(context, out, values, rescale);
    cvol_transfer_free(values);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

/* Makes the transfer function, before window and opacity scale apply. Exit status. */
static int make_transfer(cvol_context *context, cvol_transfer **out, scene *s,
                         const render_arguments *a, const char *path)
{
    const char *name = a->transfer_name;
    cvol_histogram histogram;
    int code, status;
    if (s->labels) {
        s->has_kind = 1;
        s->kind = CVOL_KIND_LABELS;
        code = s->numbers ? cvol_labels_create_mask_transfer(context, out)
                          : create_label_transfer(context, out, s->labels);
        return code ? report_context_error(context, code, NULL) : EXIT_DONE;
    }
    if (s->colours) {
        code = make_colour_transfer(context, out, s);
        return code ? report_context_error(context, code, NULL) : EXIT_DONE;
    }
    if (is_file_name(name))
        return read_transfer(context, out, name, s->rescale);
    if ((status = find_histogram(context, &histogram, s)))
        return status;
    if (!strcmp(name, "auto")) {
        double rescale[2];
        code = cvol_transfer_create_auto(context, out, &s->kind, rescale, &histogram,
                                         input_grid(&s->in), has_original_samples(s));
        s->has_kind = !code;
        if (!code && s->kind == CVOL_KIND_CT && !a->rescale_text && !a->window_text) {
            memcpy(s->rescale, rescale, sizeof rescale);
            s->value_unit = "HU";
        }
    } else if (cvol_transfer_is_ct(name)) {
        if ((status = find_hounsfield(s, a, &histogram, path)))
            return status;
        code = cvol_transfer_create_ct(context, out, name, s->rescale);
    } else {
        code = cvol_transfer_create_named(context, out, name, &histogram);
    }
    if (code == CVOL_ERROR_ARGUMENT)
        return report_error(EXIT_MISUSED, "%s %s", cvol_context_message(context),
                            cvol_transfer_ct_names());
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

/* The ends of the window, as sample values. */
static const double *window_of(double window[2], const scene *s, const render_arguments *a)
{
    if (!a->window_text)
        return NULL;
    for (int k = 0; k < 2; k++) {
        const double value = a->window[0] + (k ? 0.5 : -0.5) * a->window[1];
        window[s->rescale[0] < 0 ? 1 - k : k] = (value - s->rescale[1]) / s->rescale[0];
    }
    return window;
}

/* Warns of a window without any sample: the picture would be empty or one grey. */
static void print_empty_window_note(cvol_context *context, const scene *s, const double window[2],
                                    const char *path)
{
    cvol_histogram h;
    if (find_histogram(context, &h, s) || (window[1] >= h.min && window[0] <= h.max))
        return;
    clear_progress();
    fprintf(stderr, "cvol: %s: no sample is in the window, %g to %g; samples are %g to %g\n", path,
            s->rescale[0] * window[0] + s->rescale[1], s->rescale[0] * window[1] + s->rescale[1],
            s->rescale[0] * h.min + s->rescale[1], s->rescale[0] * h.max + s->rescale[1]);
}

/* Warns of a surface value below or above all samples. */
static void print_no_surface_note(cvol_context *context, const scene *s, const char *path)
{
    cvol_histogram h;
    const double value = s->options.surface.value;
    if (find_histogram(context, &h, s) || (value >= h.min && value <= h.max))
        return;
    clear_progress();
    fprintf(stderr, "cvol: %s: no surface has the value %g; samples are %g to %g\n", path,
            s->rescale[0] * value + s->rescale[1], s->rescale[0] * h.min + s->rescale[1],
            s->rescale[0] * h.max + s->rescale[1]);
}

/* Warns of grey levels that go against the values. */
static void print_reversed_note(const scene *s, const render_arguments *a, const char *path)
{
    if (s->rescale[0] > 0)
        return;
    clear_progress();
    fprintf(
        stderr,
        "cvol: %s: values fall as samples rise (slope %g): mode %s follows the samples, so small "
        "values are bright\n",
        path, s->rescale[0], a->mode_name);
}

/* Replaces the colours by those of --colormap. Exit status. */
static int recolour(cvol_context *context, cvol_transfer **transfer, const scene *s,
                    const render_arguments *a)
{
    cvol_histogram histogram;
    cvol_transfer *colours = NULL, *out = NULL;
    int status = find_histogram(context, &histogram, s);
    if (status)
        return status;
    int code = cvol_transfer_create_named(context, &colours, a->colormap, &histogram);
    if (!code)
        code = cvol_transfer_create_recoloured(context, &out, *transfer, colours);
    cvol_transfer_free(colours);
    if (code)
        return report_context_error(context, code, NULL);
    cvol_transfer_free(*transfer);
    *transfer = out;
    return EXIT_DONE;
}

/* Mode composite. Exit status. */
static int set_transfer(cvol_context *context, scene *s, const render_arguments *a,
                        const char *path)
{
    cvol_transfer *named = NULL;
    double ends[2];
    int status = make_transfer(context, &named, s, a, path);
    if (!status && a->colormap)
        status = recolour(context, &named, s, a);
    if (status) {
        cvol_transfer_free(named);
        return status;
    }
    const double *window = s->colours ? NULL : window_of(ends, s, a); /* of components: used */
    if (window)
        print_empty_window_note(context, s, window, path);
    int code = cvol_transfer_create_adjusted(context, &s->transfer, named, window,
                                             a->opacity_scale);
    cvol_transfer_free(named);
    if (!code)
        code = cvol_renderer_set_transfer(context, s->renderer, s->transfer);
    if (!code)
        drop_default_light(s, a);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

/* Sets the window to the range without the 0.1 % lowest and highest samples. Exit status. */
static int fit_window(cvol_context *context, scene *s)
{
    cvol_histogram h;
    const int status = find_histogram(context, &h, s);
    if (status)
        return status;
    cvol_histogram_get_window(s->options.window, &h);
    return EXIT_DONE;
}

int choose_values(cvol_context *context, scene *s, const render_arguments *a, const char *path)
{
    const cvol_grid *grid = input_grid(&s->in);
    s->value_unit = "";
    s->rescale[0] = a->rescale_text ? a->rescale[0] : grid->value_scale;
    s->rescale[1] = a->rescale_text ? a->rescale[1] : grid->value_offset;
    if (!(fabs(s->rescale[0]) > 0))
        s->rescale[0] = 1;
    if (s->options.mode == CVOL_MODE_COMPOSITE)
        return set_transfer(context, s, a, path);
    const int is_surface = s->options.mode == CVOL_MODE_ISO;
    if (is_surface) {
        s->options.surface.value = (a->iso - s->rescale[1]) / s->rescale[0];
        print_no_surface_note(context, s, path);
    } else
        print_reversed_note(s, a, path);
    if (a->window_auto || (is_surface && !a->window_text && !s->shared))
        return fit_window(context, s);
    if (a->window_text)
        print_empty_window_note(context, s, window_of(s->options.window, s, a), path);
    else if (s->shared && (is_surface || is_grey_mode(s->options.mode))) {
        s->options.window[0] = s->shared->min;
        s->options.window[1] = s->shared->max;
    }
    return EXIT_DONE;
}
