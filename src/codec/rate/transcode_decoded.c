/* Transcoding of arrays with a residual (transcode_decoded.h). */
#include "codec/rate/transcode_decoded.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "array/core/mask.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "codec/container/array_file.h"

/* The root mean square error that a PSNR means. */
static double rms_of(double span, double psnr_db)
{
    return isfinite(psnr_db) ? span * cvol_pow(10, -psnr_db / 20) : 0;
}

static double span_of(const cvol_array *array)
{
    return array->error_bound.value_max - array->error_bound.value_min;
}

/* A PSNR of the decoded samples that leaves room for the source's own error; both over the range of
 * the original samples. */
static int choose_psnr(cvol_context *context, cvol_compress_options *how, const cvol_array *array)
{
    const double span = span_of(array), own = rms_of(span, array->psnr_db);
    const double room = rms_of(span, how->target_value) - own;
    if (how->target != CVOL_TARGET_PSNR || !(own > 0))
        return CVOL_OK;
    if (!(room > 0))
        return cvol_fail(context, CVOL_ERROR_TARGET,
                         "a PSNR of %g dB cannot be promised: the array guarantees only %.2f dB; "
                         "compress the volume itself",
                         how->target_value, array->psnr_db);
    how->target_value = 20 * cvol_log10(span / room);
    return CVOL_OK;
}

/* Adds the source's own errors to the bounds of an array of its decoded samples. */
static void add_errors(cvol_array *out, const cvol_array *array)
{
    const double each = array->max_error,
                 all = each * sqrt((double)cvol_grid_samples(&array->grid)),
                 rms = rms_of(span_of(array), array->psnr_db) + rms_of(span_of(out), out->psnr_db);
    cvol_error_bound_widen(&out->error_bound, all, each);
    out->max_error += each;
    out->measured = 0;
    out->psnr_db = rms > 0 ? 20 * cvol_log10(span_of(array) / rms)
                           : fmin(out->psnr_db, array->psnr_db);
}

static int compress_samples(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                            const cvol_array *array, const void *samples,
                            const cvol_compress_options *how)
{
    int code = cvol_compress(context, out, report, samples, &array->grid, how);
    if (!code && array->attributes)
        code = cvol_array_keep_attributes(context, *out, array->attributes,
                                          strlen(array->attributes));
    if (!code && array->max_error > 0)
        add_errors(*out, array);
    return code;
}

/* For the source's own errors, and for attributes, the file has more bytes than the compression
 * counts: a second one includes these. */
int cvol_transcode_decoded(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                           const cvol_array *array, cvol_target target, double value,
                           const cvol_compress_options *options)
{
    const size_t zero[3] = {0, 0, 0};
    const cvol_fills *fills = cvol_mask_is_void(array->mask) ? cvol_mask_fills(array->mask) : NULL;
    const double raw = (double)cvol_grid_bytes(&array->grid);
    cvol_compress_options how = *options;
    cvol_compress_report found = {0};
    uint64_t bytes = 0;
    void *samples = cvol_allocate(cvol_grid_samples(&array->grid),
                                  cvol_type_size(array->grid.type));
    if (!samples)
        return cvol_fail_memory(context, cvol_grid_bytes(&array->grid), "the decoded samples");
    how.block = array->block;
    how.lapped = array->lapped;
    how.target = target;
    how.target_value = value;
    how.least_psnr = 0;
    how.has_value_range = 1;
    how.value_min = array->error_bound.value_min;
    how.value_max = array->error_bound.value_max;
    how.has_fill = fills != NULL; /* one finite value at most; all NaN and infinite ones */
    for (int i = 0; fills && i < fills->count; i++) {
        const double fill = cvol_fills_value(fills, i, array->grid.type);
        how.fill = i == 0 || isfinite(fill) ? fill : how.fill;
    }
    int code = cvol_array_evaluate_box(context, samples, array, zero, array->grid.dims);
    if (!code)
        code = choose_psnr(context, &how, array);
    for (int i = 0; i < 2 && !code; i++) {
        cvol_array_free(*out);
        *out = NULL;
        code = compress_samples(context, out, &found, array, samples, &how);
        if (!code)
            code = cvol_array_file_bytes(context, *out, &bytes);
        const double most = raw / value - ((double)bytes - (double)found.file_bytes);
        if (target != CVOL_TARGET_RATIO || (double)bytes * value <= raw || !(most > 0))
            break;
        how.target_value = raw / most;
    }
    free(samples);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    } else if (report) {
        *report = found;
        report->file_bytes = bytes;
        report->ratio = raw / (double)bytes;
        report->psnr_db = (*out)->psnr_db;
        report->max_error = (*out)->max_error;
        report->lossless = found.lossless && !(array->max_error > 0);
        report->target_met = found.target_met &&
                             (target != CVOL_TARGET_RATIO || report->ratio >= value);
    }
    return code;
}
