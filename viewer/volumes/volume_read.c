/* Reads and compresses volumes for the viewer. */
#include "viewer/volumes/volume_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "viewer/volumes/labels.h"
#include "viewer/volumes/overlays.h"
#include "viewer/volumes/times.h"
#include "viewer/volumes/volume_renderers.h"

static const double poor_psnr_db = 30; /* of copies */
static const double least_psnr_db = 25, psnr_instead_db = 35;

/* Stores the results of compression, as a file would have them. */
static void store_report(shown_volume *v, const cvol_compress_report *report)
{
    v->compressed_bytes = report->file_bytes;
    v->psnr_db = report->psnr_db;
    v->max_error = report->max_error;
    v->measured = !v->parent || v->parent->dense;
}

/* The transfer function of a new view. */
static int create_usual_transfer(cvol_context *context, cvol_transfer **out, const shown_volume *v)
{
    return v->labels ? cvol_labels_create_mask_transfer(context, out)
                     : cvol_transfer_create_auto(context, out, NULL, NULL, &v->histogram, &v->grid,
                                                 volume_is_exact(v));
}

/* The transfer function of what the default view shows. Thin parts of the shape of labels are a
 * small part of the mean of a cell, by which the camera finds what is visible. */
static int create_visible(cvol_context *context, cvol_transfer **out, const shown_volume *v)
{
    static const cvol_transfer_point shape[] = {{0.5, 1, 1, 1, 0}, {1.5, 1, 1, 1, 1}};
    return v->labels ? cvol_transfer_create(context, out, shape, sizeof shape / sizeof *shape)
                     : create_usual_transfer(context, out, v);
}

/* Finds the default view. A picture that is very wide fits the height of what is visible, and one
 * that is very high its width. */
static int find_home(cvol_context *context, shown_volume *v)
{
    const cvol_source source = {.size = sizeof source,
                                .array = v->labels ? v->labels->shape : v->array};
    cvol_render_options options = cvol_render_options_defaults();
    cvol_transfer *transfer = NULL;
    int mirrored;
    cvol_camera_set_default(&options.camera, &mirrored, &v->grid, 0);
    int code = create_visible(context, &transfer, v);
    options.width = CVOL_IMAGE_SIZE_MAX;
    options.height = 1;
    if (!code)
        code = cvol_camera_fit_extent(context, &options, v->home_size, &source, transfer);
    v->home = options.camera;
    v->home_lit = !code && !cvol_transfer_is_opaque(transfer);
    cvol_transfer_free(transfer);
    return code;
}

/* Gives a time what all times of its series share. */
static void join_series(shown_volume *v)
{
    const shown_volume *series = v->series;
    v->histogram = series->histogram;
    v->home = series->home;
    memcpy(v->home_size, series->home_size, sizeof v->home_size);
    memcpy(v->rescale, series->rescale, sizeof v->rescale);
    v->home_lit = series->home_lit;
    cvol_volume_free(v->dense);
    v->dense = NULL;
}

static int finish(cvol_context *context, shown_volume *v, const viewer_options *options)
{
    v->grid = *cvol_array_grid(v->array);
    v->raw_bytes = cvol_grid_bytes(&v->grid);
    int code = cvol_array_compute_histogram(context, &v->histogram, v->array);
    if (!code)
        code = labels_find(context, &v->labels, v);
    if (!code && v->series) {
        join_series(v);
        return code;
    }
    if (!code && v->times > 1)
        code = volume_fit_values(context, v, options);
    if (code)
        return code;
    if (cvol_hounsfield_guess(v->rescale, &v->histogram, &v->grid) == CVOL_HOUNSFIELD_NO)
        v->rescale[0] = v->rescale[1] = 0;
    code = find_home(context, v);
    return code || v->parent ? code : overlays_fit(context, v, options);
}

static int read_compressed(cvol_context *context, shown_volume *v)
{
    const cvol_file_part part = volume_part(v);
    cvol_file_report report;
    cvol_array_info info;
    const int code = cvol_array_read_part(context, &v->array, &report, v->path, &part);
    if (code)
        return code;
    cvol_array_get_info(&info, v->array);
    v->level = report.level;
    v->cut = report.cut;
    v->residual_missing = report.residual_missing;
    v->compressed_bytes = report.file_bytes;
    v->psnr_db = info.psnr_db;
    v->max_error = info.max_error;
    v->measured = info.measured;
    return CVOL_OK;
}

/* Compresses like cvol render: effort fast, ratio 30 or, if that gives less than 25 dB, a PSNR of
 * 35 dB, a separate background; samples of a value far from all others count as missing. */
static int compress(cvol_context *context, shown_volume *v)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_compress_report report;
    cvol_histogram histogram;
    int code = cvol_volume_compute_histogram(context, &histogram, v->dense);
    if (code)
        return code;
    options.background = CVOL_BACKGROUND_FIND;
    options.effort = CVOL_EFFORT_FAST;
    options.has_fill = histogram.mark_count > 0;
    options.fill = histogram.mark;
    if (!options.has_fill)
        code = cvol_volume_compute_is_labels(context, &options.lossless, v->dense, v->path);
    if (code)
        return code;
    options.least_psnr = least_psnr_db;
    code = cvol_compress(context, &v->array, &report, v->dense->data, &v->dense->grid, &options);
    if (code == CVOL_ERROR_TARGET) {
        options.target = CVOL_TARGET_PSNR;
        options.target_value = psnr_instead_db;
        code = cvol_compress(context, &v->array, &report, v->dense->data, &v->dense->grid,
                             &options);
    }
    if (!code)
        store_report(v, &report);
    return code;
}

/* Reads the samples of a file that is not compressed, at a later time of the volume. */
static int read_samples(cvol_context *context, cvol_volume **out, const shown_volume *v, int time,
                        const viewer_options *options)
{
    cvol_read_options read = v->read;
    read.index += time;
    const int code = cvol_volume_read(context, out, v->path, &read);
    return code || !options->has_fill ? code : cvol_volume_fill(context, *out, options->fill);
}

int volume_read(cvol_context *context, shown_volume *v, const viewer_options *options)
{
    if (cvol_file_is_cvol(v->path)) {
        const int code = read_compressed(context, v);
        return code ? code : finish(context, v, options);
    }
    int code = read_samples(context, &v->dense, v, 0, options);
    if (code)
        return code;
    volume_set_state(v, VOLUME_COMPRESSING);
    code = compress(context, v);
    return code ? code : finish(context, v, options);
}

/* Makes a copy from the compressed volume. The copy keeps the mask of a separate background
 * unchanged; if the mask takes most of the bytes or more, a copy without a separate background
 * looks better. */
static int transcode(cvol_context *context, shown_volume *v, cvol_compress_report *report,
                     const cvol_array *from)
{
    cvol_array *flat = NULL, *smaller = NULL;
    cvol_compress_report without;
    cvol_array_info info;
    int code = cvol_array_transcode(context, &v->array, report, from, &v->copy_options);
    cvol_array_get_info(&info, from);
    if (code || !info.background_samples || v->copy_options.target != CVOL_TARGET_RATIO ||
        (report->target_met && report->psnr_db >= poor_psnr_db))
        return code;
    code = cvol_array_flatten(context, &flat, from);
    if (!code)
        code = cvol_array_transcode(context, &smaller, &without, flat, &v->copy_options);
    if (!code &&
        (without.target_met > report->target_met ||
         (without.target_met == report->target_met && without.psnr_db > report->psnr_db))) {
        cvol_array_free(v->array);
        v->array = smaller;
        smaller = NULL;
        v->flattened = 1;
        *report = without;
        report->max_error = NAN; /* the bound is too wide to be useful */
    }
    cvol_array_free(smaller);
    cvol_array_free(flat);
    return code;
}

/* Makes a copy from samples. */
static int compress_copy(cvol_context *context, shown_volume *v, cvol_compress_report *report,
                         const cvol_volume *samples)
{
    cvol_histogram histogram; /* the array does not have the marked samples */
    const int code = cvol_volume_compute_histogram(context, &histogram, samples);
    if (code)
        return code;
    v->copy_options.effort = CVOL_EFFORT_FAST;
    v->copy_options.background = CVOL_BACKGROUND_FIND;
    v->copy_options.has_fill = histogram.mark_count > 0;
    v->copy_options.fill = histogram.mark;
    return cvol_compress(context, &v->array, report, samples->data, &samples->grid,
                         &v->copy_options);
}

/* Only the first time of a volume that is not compressed keeps its samples. */
static int make_copy(cvol_context *context, shown_volume *v, cvol_compress_report *report,
                     const viewer_options *options)
{
    shown_volume *parent = v->parent, *from = NULL;
    cvol_volume *samples = NULL;
    int code;
    if (!parent->dense) {
        code = times_hold(context, &from, parent, v->copied_time);
        if (!code)
            code = transcode(context, v, report, from->array);
        volume_release(from);
        return code;
    }
    if (!v->copied_time)
        return compress_copy(context, v, report, parent->dense);
    code = read_samples(context, &samples, parent, v->copied_time, options);
    if (!code)
        code = compress_copy(context, v, report, samples);
    cvol_volume_free(samples);
    return code;
}

int volume_make_copy(cvol_context *context, shown_volume *v, const viewer_options *options)
{
    const shown_volume *parent = v->parent;
    cvol_compress_report report;
    const int code = make_copy(context, v, &report, options);
    if (code)
        return code;
    v->level = parent->level;
    v->cut = parent->cut;
    v->residual_missing = parent->residual_missing;
    store_report(v, &report);
    return finish(context, v, options);
}

void volume_warm(cvol_context *context, shown_volume *v)
{
    cvol_render_options options = cvol_render_options_defaults();
    cvol_image *image = NULL;
    cvol_transfer *transfer = NULL;
    idle_renderer *r = volume_take_renderer(context, v, v->labels != NULL);
    options.width = options.height = 16;
    int code = !r || cvol_image_create(context, &image, options.width, options.height) ||
               create_usual_transfer(context, &transfer, v) ||
               cvol_renderer_set_transfer(context, r->renderer, transfer);
    for (options.level = 3; !code && options.level >= 0; options.level--) {
        code = cvol_renderer_render(context, r->renderer, image, &options);
        if (!code)
            r->drawn |= 1u << options.level;
    }
    cvol_transfer_free(transfer);
    cvol_image_free(image);
    volume_return_renderer(v, r);
}
