/* cvol_compress: compresses as the options ask, or losslessly if that takes no more bytes.
 *
 * Samples that repeat (labels, masks, vessels on zeros) often take fewer bytes without loss than
 * terms need for their edges. The lossless attempt takes about as long as the lossy one, so it runs
 * only if it may be smaller:
 *   - The lossy samples are nearly exact: their mean squared error is below EXACT_ERROR squares of
 *     the samples' grain, so terms spend bits on digits that samples do not have.
 *   - zstd at a fast level takes at most REPEATED times the lossy bytes: for 16 volumes (CT, MRI,
 *     electron microscopy, labels, vessels, noise) it takes 1.17 to 2.01 times the bytes of a
 *     file with a residual. For five segmentations it takes 4.5 to 11 times the bytes of the
 *     labels. So up to LABELS_REPEATED times the lossy bytes, labels alone may be smaller: some
 *     bricks are coded first, to see. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/elementary.h"
#include "codec/container/array_file.h"
#include "codec/rate/compress_options.h"
#include "codec/rate/compress_residual.h"
#include "codec/rate/compress_terms.h"
#include "codec/rate/outliers.h"
#include "codec/rate/step_search.h"
#include "codec/rate/target.h"
#include "codec/residual/make_labels.h"
#include "codec/residual/residual_array.h"
#include "codec/residual/residual_code.h"
#include "codec/section/section.h"

#define EXACT_ERROR 0.04
#define EXACT_PSNR 40 /* nearly exact floats have more */
#define REPEATED 2.2
#define LABELS_REPEATED 16
/* zstd takes at least about this factor more bytes than labels that suit well. */
#define LABELS_FIRST 4

/* One thread codes each brick. More threads only wait for these, and OpenMP waits by spinning,
 * which took two thirds of the processors' time. */
#define SAMPLES_PER_THREAD (1 << 17)
#define REPEATED_MORE 4096 /* bytes: tables count in small files */

enum { ATTRIBUTE_TRIES = 3 };

/* ---- progress --------------------------------------------------------------------------- */

typedef struct second_attempt {
    cvol_progress_fn progress;
    void *user;
} second_attempt;

static int report_second_attempt(void *user, const char *stage, double fraction)
{
    const second_attempt *at = user;
    return at->progress(at->user, stage, 0.9 + 0.1 * fraction);
}

/* ---- the test --------------------------------------------------------------------------- */

/* The spacing of the samples' values; for floats, at the largest magnitude. */
static double grain_of(const void *samples, const cvol_grid *grid)
{
    int grain = INT_MAX;
    double largest = 0;
    if (cvol_type_is_integer(grid->type))
        return 1;
    cvol_residual_scan(&grain, &largest, grid->type, samples, NULL, cvol_grid_samples(grid));
    const double place = largest * (grid->type == CVOL_FLOAT32 ? (double)FLT_EPSILON : DBL_EPSILON);
    return grain == INT_MAX ? 0 : fmax(ldexp(1, grain), place);
}

/* *out: 1 if a lossless file may take no more than `bytes`, those of the lossy array or more. For
 * equal samples it may if the options bound each error: the step that the bound gives can take more
 * bytes in the header. */
static int judge_lossless(cvol_context *context, int *out, const cvol_array *array, double bytes,
                          const void *samples, const cvol_compress_options *options)
{
    const cvol_residual_data *residual = cvol_residual_of(array);
    const double span = array->error_bound.value_max - array->error_bound.value_min;
    const double error = span * span * cvol_pow(10, -array->psnr_db / 10);
    *out = 0;
    if (residual && residual->kind != CVOL_RESIDUAL_BOUNDED)
        return CVOL_OK;
    if (!(span > 0)) {
        *out = cvol_compress_needs_residual(options);
        return CVOL_OK;
    }
    double packed;
    const int code = cvol_packed_estimate(context, &packed, samples, &array->grid);
    if (code)
        return code;
    *out = packed <= REPEATED * bytes + REPEATED_MORE ||
           ((cvol_type_is_integer(array->grid.type) || array->psnr_db > EXACT_PSNR) &&
            error < EXACT_ERROR * cvol_pow(grain_of(samples, &array->grid), 2));
    if (*out || packed > LABELS_REPEATED * bytes || options->has_fill ||
        cvol_labels_judge(samples, &array->grid) == CVOL_LABELS_NOT)
        return CVOL_OK;
    return cvol_labels_may_fit(context, out, array, samples, bytes);
}

static int are_finite(const void *samples, const cvol_grid *grid)
{
    const size_t count = cvol_grid_samples(grid);
    int finite = 1;
    for (size_t i = 0; i < count; i++)
        finite &= isfinite(grid->type == CVOL_FLOAT32 ? (double)((const float *)samples)[i]
                                                      : ((const double *)samples)[i]);
    return finite;
}

/* ---- the choice ------------------------------------------------------------------------- */

static cvol_compress_options without_loss(const cvol_compress_options *options)
{
    cvol_compress_options exact = *options;
    exact.lossless = 1;
    exact.target = CVOL_TARGET_MAX_ERROR;
    exact.target_value = exact.max_error = 0;
    if (exact.effort == CVOL_EFFORT_MAX)
        exact.effort = CVOL_EFFORT_DEFAULT;
    exact.background = CVOL_BACKGROUND_NONE;
    return exact;
}

/* The bytes that the target allows, independent of the lossy file's size. */
static double allowed_bytes(const cvol_compress_options *options, const cvol_grid *grid)
{
    const double value = options->target_value;
    return options->target == CVOL_TARGET_RATIO  ? (double)cvol_grid_bytes(grid) / value
           : options->target == CVOL_TARGET_BITS ? (double)cvol_grid_samples(grid) * value / 8
                                                 : 0;
}

/* Takes the lossless array if it is no larger than the lossy one (NULL: there is none), or than the
 * target allows. */
static int try_lossless(cvol_context *context, cvol_array **array, cvol_compress_report *report,
                        const void *samples, const cvol_grid *grid,
                        const cvol_compress_options *options)
{
    const cvol_compress_options exact = without_loss(options);
    const double allowed = allowed_bytes(options, grid);
    second_attempt at = {context->progress, context->progress_user};
    cvol_compress_report of_it;
    cvol_array *lossless;
    if (*array && at.progress)
        cvol_context_set_progress(context, report_second_attempt, &at);
    const int code = cvol_compress_residual(context, &lossless, &of_it, samples, grid, &exact);
    cvol_context_set_progress(context, at.progress, at.user);
    if (code) /* some floats allow only lossy compression */
        return *array && (code == CVOL_ERROR_DATA || code == CVOL_ERROR_TARGET) ? CVOL_OK : code;
    const double bytes = (double)of_it.file_bytes;
    if (*array && bytes > (double)report->file_bytes && bytes > allowed) {
        cvol_array_free(lossless);
        report->trials += of_it.trials;
        return CVOL_OK;
    }
    of_it.trials += *array ? report->trials : 0;
    of_it.target_met = allowed <= 0 || bytes <= allowed;
    cvol_array_free(*array);
    *array = lossless;
    *report = of_it;
    return CVOL_OK;
}

/* Makes the lossless array if it surely takes no more bytes than the target allows, because zstd at
 * a fast level takes no more, or if it probably does, because samples suit labels. Then no terms
 * need to be tried. Otherwise *array stays NULL. In small volumes terms take little time, so it
 * does nothing. */
static int try_lossless_first(cvol_context *context, cvol_array **array,
                              cvol_compress_report *report, const void *samples,
                              const cvol_grid *grid, const cvol_compress_options *options)
{
    const double allowed = options->lossless ? 0 : allowed_bytes(options, grid);
    if (cvol_grid_samples(grid) < SAMPLES_PER_THREAD || allowed <= 0)
        return CVOL_OK;
    double packed;
    int code = cvol_packed_estimate(context, &packed, samples, grid);
    if (code)
        return code;
    if (packed > allowed &&
        (packed > LABELS_FIRST * allowed || cvol_labels_judge(samples, grid) != CVOL_LABELS_WELL))
        return CVOL_OK;
    code = try_lossless(context, array, report, samples, grid, options);
    if (code)
        return code == CVOL_ERROR_DATA || code == CVOL_ERROR_TARGET ? CVOL_OK : code;
    if ((double)report->file_bytes > allowed) {
        cvol_array_free(*array);
        *array = NULL;
    }
    return CVOL_OK;
}

static int compress(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                    const void *samples, const cvol_grid *grid,
                    const cvol_compress_options *options)
{
    cvol_array *array = NULL;
    cvol_compress_report of_it = {0};
    *out = NULL;
    cvol_compress_options with_nan;
    int code = cvol_compress_options_check(context, options);
    if (!code)
        code = cvol_grid_check(context, grid, "the volume");
    if (code)
        return code;
    if (!options->has_fill && cvol_samples_nan_alone(samples, grid)) { /* NaN samples have no
                                                                          value */
        with_nan = *options;
        with_nan.has_fill = 1;
        with_nan.fill = NAN;
        with_nan.background = CVOL_BACKGROUND_NONE;
        options = &with_nan;
    }
    code = try_lossless_first(context, &array, &of_it, samples, grid, options);
    int may_be_smaller = 0;
    const int is_chosen = array != NULL;
    if (!code && !is_chosen)
        code = cvol_compress_needs_residual(options)
                   ? cvol_compress_residual(context, &array, &of_it, samples, grid, options)
                   : cvol_compress_terms(context, &array, &of_it, samples, grid, options);
    if (!cvol_type_is_integer(grid->type) &&
        (code == CVOL_ERROR_TARGET || code == CVOL_ERROR_CORRUPT ||
         (code == CVOL_ERROR_DATA && are_finite(samples, grid))))
        code = CVOL_OK; /* no step of terms is near enough, or single precision cannot hold them */
    if (!code && !is_chosen && array)
        code = judge_lossless(context, &may_be_smaller, array,
                              fmax((double)of_it.file_bytes, allowed_bytes(options, grid)), samples,
                              options);
    if (!code && !is_chosen && (!array || may_be_smaller))
        code = try_lossless(context, &array, &of_it, samples, grid, options);
    if (!code && report)
        *report = of_it;
    if (!code)
        code = cvol_compress_check_least_psnr(context, options, of_it.psnr_db, 0);
    if (!code)
        code = cvol_report_progress(context, "compressing", 1);
    if (code) {
        cvol_array_free(array);
        return code;
    }
    *out = array;
    return CVOL_OK;
}

/* ---- with attributes -------------------------------------------------------------------- */

/* Sets the array's attributes. *extra: the bytes that they add to the file. */
static int add_attributes(cvol_context *context, cvol_array *array, cvol_compress_report *report,
                          double *extra, const char *attributes)
{
    uint64_t bytes = 0;
    int code = cvol_array_set_attributes(context, array, attributes);
    if (!code)
        code = cvol_array_file_bytes(context, array, &bytes);
    *extra = (double)bytes - (double)report->file_bytes;
    report->file_bytes = bytes;
    report->ratio = (double)cvol_grid_bytes(&array->grid) / (double)bytes;
    return code;
}

/* Leaves room for the attributes in the bytes that the target allows. Small files compress them, so
 * if the first estimate of their size misses the target, it tries again with their real size. */
static int compress_with_attributes(cvol_context *context, cvol_array **out,
                                    cvol_compress_report *report, const void *samples,
                                    const cvol_grid *grid, const cvol_compress_options *options)
{
    double extra = (double)(strlen(options->attributes) + CVOL_SECTION_HEADER_BYTES), ratio;
    cvol_compress_options rest = *options;
    cvol_compress_report of_it = {0};
    int done = 0, code = cvol_compress_options_check(context, options);
    if (!code)
        code = cvol_grid_check(context, grid, "the volume");
    if (!code && options->target == CVOL_TARGET_BITS && !options->lossless)
        code = cvol_ratio_of_bits(context, &ratio, options->target_value, grid->type);
    if (code)
        return code;
    const double allowed = options->lossless ? 0 : allowed_bytes(options, grid);
    rest.least_psnr = 0;
    for (int i = 0; i < ATTRIBUTE_TRIES && !done && !code; i++) {
        if (allowed > 0) {
            rest.target = CVOL_TARGET_RATIO;
            rest.target_value = (double)cvol_grid_bytes(grid) / fmax(allowed - extra, 1);
        }
        const double estimate = extra;
        cvol_array_free(*out);
        code = compress(context, out, &of_it, samples, grid, &rest);
        if (!code)
            code = add_attributes(context, *out, &of_it, &extra, options->attributes);
        const double bytes = (double)of_it.file_bytes;
        done = allowed <= 0 || (!of_it.target_met && extra >= estimate) ||
               (bytes <= allowed && (of_it.lossless || bytes * CVOL_RATIO_MAX >= allowed));
        of_it.target_met = of_it.target_met && (allowed <= 0 || bytes <= allowed);
    }
    if (!code && report)
        *report = of_it;
    if (!code)
        code = cvol_compress_check_least_psnr(context, options, of_it.psnr_db, 0);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    }
    return code;
}

int cvol_compress(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                  const void *samples, const cvol_grid *grid, const cvol_compress_options *options)
{
    cvol_compress_options full;
    *out = NULL;
    int code = cvol_compress_options_complete(context, &full, options);
    if (code)
        return code;
    const int asked = context->threads, threads = cvol_context_threads(context);
    const size_t useful = cvol_grid_samples(grid) / SAMPLES_PER_THREAD + 1;
    context->threads = useful < (size_t)threads ? (int)useful : threads;
    code = (full.attributes ? compress_with_attributes : compress)(context, out, report, samples,
                                                                   grid, &full);
    context->threads = asked;
    return code;
}
