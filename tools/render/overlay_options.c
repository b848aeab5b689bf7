/* Reads the volumes of --overlay, and their looks. */
#include "tools/render/overlay_options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void begin_overlay_options(overlay_options *o)
{
    texts_of *const of_files[] = {&o->transfers, &o->windows, &o->opacities,
                                  &o->depths,    &o->labels,  &o->tables};
    for (size_t k = 0; k < sizeof of_files / sizeof *of_files; k++)
        *of_files[k] = (texts_of){.list = &o->files, .list_option = "--overlay"};
}

static int check_values_of(const overlay_options *o, int i)
{
    double v[2];
    const char *window = o->windows.texts[i], *opacity = o->opacities.texts[i],
               *depth = o->depths.texts[i];
    if (o->transfers.texts[i] && (o->labels.texts[i] || o->tables.texts[i]))
        return report_error(EXIT_MISUSED,
                            "--overlay-label%s cannot be combined with "
                            "--overlay-transfer",
                            o->labels.texts[i] ? "s" : "-table");
    if (window && !(parse_numbers(v, 2, window) && v[1] > 0))
        return report_error(EXIT_MISUSED,
                            "--overlay-window is '%s', must be C,W: centre and width, as in 5,8",
                            window);
    if (opacity && !(parse_numbers(v, 1, opacity) && v[0] >= 0 && v[0] <= 1))
        return report_error(EXIT_MISUSED, "--overlay-opacity is '%s', must be 0 to 1", opacity);
    if (depth && !(parse_numbers(v, 1, depth) && v[0] >= 0))
        return report_error(EXIT_MISUSED, "--overlay-depth is '%s', must be 0 or above", depth);
    return EXIT_DONE;
}

int check_overlay_values(const overlay_options *o)
{
    int status = EXIT_DONE;
    for (int i = 0; i < o->files.count && !status; i++)
        status = check_values_of(o, i);
    return status;
}

/* ---- reading ---- */

/* Reads the samples of the overlay's file. Exit status. */
static int read_samples(cvol_context *context, input *in, int threads, const char *path)
{
    common_options own = COMMON_DEFAULTS;
    int times, channels;
    own.threads = threads;
    memset(in, 0, sizeof *in);
    int status = count_volumes(context, &own, path, &times, &channels);
    if (!status && times * channels > 1)
        return report_error(EXIT_MISUSED,
                            "%s: has %d times and %d channels, but an overlay is one volume", path,
                            times, channels);
    if (!status)
        status = open_input(context, in, path, &own);
    return status ? status : need_volume(context, in);
}

/* Makes samples without a value NaN: those of a mask, or marked by a value far from all others.
 * Exit status. */
static int clear_missing(cvol_context *context, input *in, const char *path)
{
    const size_t begin[3] = {0, 0, 0}, count = cvol_grid_samples(&in->volume->grid);
    cvol_histogram histogram = {0};
    cvol_grid grid = in->volume->grid;
    cvol_volume *out = NULL;
    uint8_t *mask = calloc(count, 1);
    if (!mask)
        return report_error(EXIT_FAILED, "not enough memory");
    uint64_t missing = in->array ? cvol_array_evaluate_mask(mask, in->array, begin, grid.dims) : 0;
    int code = cvol_volume_compute_histogram(context, &histogram, in->volume);
    missing += histogram.mark_count;
    grid.type = CVOL_FLOAT32;
    if (!code && missing)
        code = cvol_volume_create(context, &out, &grid);
    for (size_t i = 0; i < count && out; i++) {
        const double value = value_at(in->volume, i);
        const int is_mark = histogram.mark_count && !(value < histogram.mark) &&
                            !(value > histogram.mark);
        ((float *)out->data)[i] = mask[i] || is_mark ? NAN : (float)value;
    }
    free(mask);
    if (out) {
        cvol_volume_free(in->volume);
        in->volume = out;
    }
    return code ? report_context_error(context, code, path) : EXIT_DONE;
}

/* Numbers the labels of the overlay, unless a transfer function is for their values. Exit status.
 */
static int number_overlay(cvol_context *context, overlay_source *source, label_set **labels,
                          input *in, const overlay_options *o, int i)
{
    const label_choice choice = {o->labels.texts[i], o->tables.texts[i], "--overlay-labels",
                                 "--overlay-label-table"};
    const int given = choice.text || choice.file;
    if (given && check_whole_samples(in, source->path))
        return EXIT_MISUSED;
    source->is_labels |= given;
    int status = source->is_labels ? clear_missing_labels(in) : EXIT_DONE;
    if (status || !source->is_labels || o->transfers.texts[i])
        return status;
    *labels = calloc(1, sizeof **labels);
    if (!*labels)
        return report_error(EXIT_FAILED, "not enough memory");
    status = number_labels(context, *labels, &in->volume, &choice, source->path);
    source->is_numbered = 1;
    source->count = (*labels)->count;
    for (size_t k = 0; k < source->count; k++)
        memcpy(source->colours + 3 * k, (*labels)->entries[k].rgb, 3 * sizeof *source->colours);
    return status;
}

int read_overlay(cvol_context *context, overlay_source *source, label_set **labels,
                 const overlay_options *o, int i, int threads)
{
    input in = {0};
    *source = (overlay_source){.path = o->files.texts[i]};
    *labels = NULL;
    int status = find_kind(source->path);
    if (!status)
        status = read_samples(context, &in, threads, source->path);
    if (!status)
        status = find_label_kind(context, &source->is_labels, in.volume, source->path);
    if (!status)
        status = number_overlay(context, source, labels, &in, o, i);
    if (!status && !source->is_labels)
        status = clear_missing(context, &in, source->path);
    source->samples = in.volume;
    in.volume = NULL;
    close_input(&in);
    if (status)
        return status;
    const int code = overlay_measure(context, source);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

/* ---- looks ---- */

void warn_of_blank_overlay(const overlay_source *source, const overlay_look *look)
{
    double rescale[2];
    if (!overlay_is_blank(source, look))
        return;
    overlay_get_rescale(rescale, source);
    clear_progress();
    fprintf(stderr, "cvol: %s: has only the value %g: nothing of it is drawn\n", source->path,
            rescale[0] * source->histogram.min + rescale[1]);
}

static int is_file(const char *name)
{
    return strchr(name, '.') || strchr(name, '/');
}

int choose_overlay_look(cvol_context *context, overlay_look *look, cvol_transfer **file,
                        const overlay_source *source, const overlay_options *o, int i)
{
    const char *name = o->transfers.texts[i], *window = o->windows.texts[i];
    double given[2];
    *file = NULL;
    *look = (overlay_look){.opacity = 1, .depth = -1};
    if (o->opacities.texts[i])
        parse_numbers(&look->opacity, 1, o->opacities.texts[i]);
    if (o->depths.texts[i])
        parse_numbers(&look->depth, 1, o->depths.texts[i]);
    if (window && source->is_labels && !name)
        return report_error(EXIT_MISUSED, "%s: --overlay-window does not work with labels",
                            source->path);
    if (window) {
        parse_numbers(given, 2, window);
        look->has_window = overlay_get_window(look->window, source, given);
        if (!look->has_window)
            return report_error(EXIT_MISUSED,
                                "%s: --overlay-window is '%s', its ends must be finite and "
                                "different",
                                source->path, window);
    }
    if (!name || !is_file(name)) {
        look->transfer = name;
        return EXIT_DONE;
    }
    cvol_transfer *values = NULL;
    double rescale[2];
    overlay_get_rescale(rescale, source);
    int code = cvol_transfer_read(context, &values, name);
    if (!code)
        code = cvol_transfer_create_rescaled(context, file, values, rescale);
    cvol_transfer_free(values);
    look->given = *file;
    return code ? report_context_error(context, code, source->path) : EXIT_DONE;
}
