/* --overlay: further volumes in the picture of a volume, as PET over MRI.
 *
 * An overlay is resampled to the axes and the box of the volume, with no more samples than it has,
 * and the same renderer draws it, with the same camera and clip. Two pictures of it are needed: its
 * colours, and, from a denser transfer function, the depth at which its visible part begins.
 * render_blend.c mixes the pictures. */
#include "tools/render/render_overlay.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Default depth, as a share of the diagonal of the volume. */
#define DEPTH_SHARE 0.25
/* An overlay that is interpolated to a finer grid is smooth: it needs few bits for this PSNR, while
 * a ratio would ask for no loss, which takes longer. */
#define OVERLAY_PSNR 50

/* ---- options ---- */

static int check_values_of(const render_arguments *a, int i)
{
    double v[2];
    const char *window = a->overlay_windows.texts[i], *opacity = a->overlay_opacities.texts[i],
               *depth = a->overlay_depths.texts[i];
    if (a->overlay_transfers.texts[i] && (a->overlay_labels.texts[i] || a->overlay_tables.texts[i]))
        return report_error(EXIT_MISUSED,
                            "--overlay-label%s cannot be combined with "
                            "--overlay-transfer",
                            a->overlay_labels.texts[i] ? "s" : "-table");
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

int check_overlays(const scene *s, const render_arguments *a)
{
    const char *other = a->certify           ? "--certify"
                        : a->depth_name      ? "--depth"
                        : a->poses           ? "--poses"
                        : a->over_time       ? "--over-time"
                        : a->progressive     ? "--progressive"
                        : a->budget_given    ? "--budget-ms"
                        : a->channel_colours ? "--channel-colors"
                        : a->output && picture_kind_of(a->output) == PICTURE_CVI
                            ? "a compressed picture"
                            : NULL;
    if (!a->overlays.count)
        return EXIT_DONE;
    if (s->engine != CVOL_ENGINE_SHEET && s->engine != CVOL_ENGINE_RAY)
        return report_error(EXIT_MISUSED, "--overlay works only with engines sheet and ray");
    if (other)
        return report_error(EXIT_MISUSED, "--overlay cannot be combined with %s", other);
    int status = EXIT_DONE;
    for (int i = 0; i < a->overlays.count && !status; i++)
        status = check_values_of(a, i);
    return status;
}

/* ---- opening ---- */

/* Reads the samples of the overlay's file. Exit status. */
static int read_samples(cvol_context *context, input *in, const render_arguments *a,
                        const char *path)
{
    common_options own = COMMON_DEFAULTS;
    int times, channels;
    own.threads = a->common.threads;
    memset(in, 0, sizeof *in);
    int status = count_volumes(context, &own, path, &times, &channels);
    if (!status && times * channels > 1)
        return report_error(EXIT_MISUSED,
                            "%s: has %d times and %d channels, but an overlay is one volume", path,
                            times, channels);
    if (!status)
        status = open_input(context, in, path, &own);
    if (!status)
        status = need_volume(context, in);
    return status;
}

static int has_nan(const cvol_volume *volume)
{
    const size_t count = cvol_grid_samples(&volume->grid);
    for (size_t i = 0; i < count && volume->grid.type == CVOL_FLOAT32; i++)
        if (isnan(((const float *)volume->data)[i]))
            return 1;
    return 0;
}

/* Compresses the resampled volume for engine sheet, and frees it. A code of the library. */
static int compress_overlay(cvol_context *context, overlay *o)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.effort = CVOL_EFFORT_FAST;
    options.lossless = o->is_labels;
    options.has_fill = has_nan(o->volume);
    options.fill = NAN;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = OVERLAY_PSNR;
    const int code = cvol_compress(context, &o->array, NULL, o->volume->data, &o->volume->grid,
                                   &options);
    cvol_volume_free(o->volume);
    o->volume = NULL;
    return code;
}

/* Exit status. */
static int make_mask(overlay *o)
{
    const size_t count = cvol_grid_samples(&o->volume->grid);
    if (!has_nan(o->volume))
        return EXIT_DONE;
    o->mask = malloc(count);
    for (size_t i = 0; i < count && o->mask; i++)
        o->mask[i] = (uint8_t)(isnan(((const float *)o->volume->data)[i]) != 0);
    return o->mask ? EXIT_DONE : report_error(EXIT_FAILED, "not enough memory");
}

/* Exit status. */
static int make_renderer(cvol_context *context, const scene *s, overlay *o)
{
    cvol_source source = {.size = sizeof source};
    const int is_sheet = s->engine == CVOL_ENGINE_SHEET;
    int code = CVOL_OK;
    if (o->labels) {
        o->numbers = o->volume;
        o->volume = NULL;
        code = is_sheet ? cvol_labels_create_shape(context, &o->array, o->numbers)
                        : cvol_labels_create_mask(context, &o->volume, o->numbers);
    } else if (is_sheet)
        code = compress_overlay(context, o);
    else if (make_mask(o))
        return EXIT_FAILED;
    source.array = o->array;
    source.volume = o->array ? NULL : o->volume;
    source.mask = o->mask;
    if (!code)
        code = cvol_renderer_create(context, &o->renderer, s->engine, &source);
    return code ? report_context_error(context, code, o->path) : EXIT_DONE;
}

static double diagonal_of(const cvol_grid *grid)
{
    double sum = 0;
    for (int k = 0; k < 3; k++)
        sum = hypot(sum, (double)grid->dims[k] * grid->spacing[k]);
    return sum;
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
static int number_overlay(cvol_context *context, overlay *o, input *in, const render_arguments *a,
                          int i)
{
    const label_choice choice = {a->overlay_labels.texts[i], a->overlay_tables.texts[i],
                                 "--overlay-labels", "--overlay-label-table"};
    const int given = choice.text || choice.file;
    const int has_transfer = a->overlay_transfers.texts[i] != NULL;
    if (given && check_whole_samples(in, o->path))
        return EXIT_MISUSED;
    o->is_labels |= given;
    if (!o->is_labels || has_transfer)
        return EXIT_DONE;
    o->labels = calloc(1, sizeof *o->labels);
    return o->labels ? number_labels(context, o->labels, &in->volume, &choice, o->path)
                     : report_error(EXIT_FAILED, "not enough memory");
}

static double mean_spacing(const cvol_grid *grid)
{
    return (grid->spacing[0] + grid->spacing[1] + grid->spacing[2]) / 3;
}

static void compare_grids(overlay *o, const cvol_grid *own, const cvol_grid *grid)
{
    for (int a = 0; a < 3; a++)
        o->share[a] = grid->dims[a] > 1 ? (double)(own->dims[a] - 1) / (double)(grid->dims[a] - 1)
                                        : 1;
}

static int open_overlay(cvol_context *context, const scene *s, overlay *o,
                        const render_arguments *a, int i, const char *path)
{
    const cvol_grid *grid = input_grid(&s->in);
    cvol_grid own;
    input in;
    uint64_t inside = 0;
    o->path = a->overlays.texts[i];
    o->opacity = 1;
    o->depth = DEPTH_SHARE * diagonal_of(grid);
    if (a->overlay_opacities.texts[i])
        parse_numbers(&o->opacity, 1, a->overlay_opacities.texts[i]);
    if (a->overlay_depths.texts[i])
        parse_numbers(&o->depth, 1, a->overlay_depths.texts[i]);
    int status = find_kind(o->path);
    if (status)
        return status;
    status = read_samples(context, &in, a, o->path);
    if (!status)
        status = find_label_kind(context, &o->is_labels, in.volume, o->path);
    if (!status)
        status = number_overlay(context, o, &in, a, i);
    if (!status && !o->is_labels)
        status = clear_missing(context, &in, o->path);
    if (!status) {
        int code = cvol_grid_coarsen(context, &own, grid, &in.volume->grid);
        if (!code)
            code = cvol_volume_resample(context, &o->volume, &inside, in.volume, &own,
                                        o->is_labels);
        if (code)
            status = report_context_error(context, code, o->path);
    }
    if (!status)
        compare_grids(o, &own, grid);
    if (!status)
        o->overlap = (double)inside / (double)cvol_grid_samples(&own);
    if (!status && !inside)
        status = report_error(EXIT_FAILED, "%s: lies outside of %s: they have no place in common",
                              o->path, path);
    if (!status)
        status = choose_overlay_transfer(context, o, in.volume, a->overlay_transfers.texts[i],
                                         a->overlay_windows.texts[i],
                                         mean_spacing(&own) / mean_spacing(grid));
    close_input(&in);
    return status ? status : make_renderer(context, s, o);
}

int open_overlays(cvol_context *context, scene *s, const render_arguments *a, const char *path)
{
    const double start = milliseconds();
    int status = EXIT_DONE;
    if (!a->overlays.count)
        return EXIT_DONE;
    if (s->other_count)
        return report_error(EXIT_MISUSED,
                            "%s: has several channels: choose one with --channel to draw an "
                            "overlay",
                            path);
    s->overlays = calloc((size_t)a->overlays.count, sizeof *s->overlays);
    if (!s->overlays)
        return report_error(EXIT_FAILED, "not enough memory");
    s->overlay_count = a->overlays.count;
    for (int i = 0; i < s->overlay_count && !status; i++)
        status = open_overlay(context, s, &s->overlays[i], a, i, path);
    s->load_ms += milliseconds() - start;
    return status;
}

void close_overlays(scene *s)
{
    for (int i = 0; i < s->overlay_count; i++) {
        overlay *o = &s->overlays[i];
        cvol_renderer_free(o->renderer);
        cvol_transfer_free(o->transfer);
        cvol_transfer_free(o->dense);
        cvol_array_free(o->array);
        cvol_volume_free(o->volume);
        cvol_volume_free(o->numbers);
        free(o->mask);
        free(o->labels);
    }
    free(s->overlays);
    s->overlays = NULL;
    s->overlay_count = 0;
}

/* ---- drawing ---- */

/* Draws one overlay: its colours, with the depths of its dense picture. Labels are lit like the
 * volume, which shows their shapes. The colours of values must not depend on light. A code of the
 * library. */
static int draw_overlay(cvol_context *context, const scene *s, overlay *o, cvol_image **out)
{
    cvol_render_options options = s->options;
    cvol_image *deep = NULL;
    options.mode = CVOL_MODE_COMPOSITE;
    for (int a = 0; a < 3; a++) {
        options.clip.from[a] *= o->share[a];
        options.clip.to[a] *= o->share[a];
    }
    options.shading.on = o->is_labels && (options.shading.on || s->options.mode == CVOL_MODE_ISO);
    int code = cvol_image_create_float(context, out, options.width, options.height);
    if (!code)
        code = cvol_renderer_set_transfer(context, o->renderer, o->transfer);
    if (!code && o->numbers) { /* with depths of its own */
        if (!is_grey_mode(s->options.mode))
            code = cvol_image_add_depth(context, *out);
        return code ? code
                    : draw_labels(context, o->renderer, *out, &options, o->numbers, o->labels);
    }
    if (!code)
        code = cvol_renderer_render(context, o->renderer, *out, &options);
    if (code || is_grey_mode(s->options.mode))
        return code;
    options.shading.on = 0;
    code = cvol_image_create_float(context, &deep, options.width, options.height);
    if (!code)
        code = cvol_image_add_depth(context, deep);
    if (!code)
        code = cvol_renderer_set_transfer(context, o->renderer, o->dense);
    if (!code)
        code = cvol_renderer_render(context, o->renderer, deep, &options);
    if (!code) {
        (*out)->depth = deep->depth;
        deep->depth = NULL;
    }
    cvol_image_free(deep);
    return code;
}

int draw_overlays(cvol_context *context, scene *s, cvol_image *image)
{
    cvol_image *pictures[OVERLAYS_MAX] = {NULL};
    int code = is_grey_mode(s->options.mode) ? CVOL_OK : cvol_image_add_depth(context, image);
    if (!code)
        code = s->numbers
                   ? draw_labels(context, s->renderer, image, &s->options, s->numbers, s->labels)
                   : cvol_renderer_render(context, s->renderer, image, &s->options);
    for (int i = 0; i < s->overlay_count && !code; i++)
        code = draw_overlay(context, s, &s->overlays[i], &pictures[i]);
    if (!code)
        blend_overlays(image, s->overlays, pictures, s->overlay_count);
    for (int i = 0; i < s->overlay_count; i++)
        cvol_image_free(pictures[i]);
    return code;
}

/* ---- describing ---- */

const cvol_transfer *overlay_bar(double rescale[2], const scene *s)
{
    for (int i = 0; i < s->overlay_count; i++)
        if (!s->overlays[i].is_labels) {
            memcpy(rescale, s->overlays[i].rescale, sizeof s->overlays[i].rescale);
            return s->overlays[i].transfer;
        }
    return NULL;
}

void describe_overlays(json_t *object, const scene *s)
{
    json_t *list = s->overlay_count ? json_array() : NULL;
    for (int i = 0; i < s->overlay_count; i++) {
        const overlay *o = &s->overlays[i];
        json_t *entry = json_pack("{s:o, s:b, s:f, s:f, s:f}", "input", json_text(o->path),
                                  "labels", o->is_labels, "opacity", o->opacity, "depth", o->depth,
                                  "overlap", o->overlap);
        if (o->labels)
            json_object_set_new(entry, "drawn", describe_labels(o->labels));
        json_array_append_new(list, entry);
    }
    if (list)
        json_object_set_new(object, "overlays", list);
}
