/* Makes a compressed volume coarser: requantizes its terms with the step that the search finds
 * (transcode_search.h), or compresses its decoded samples (transcode_decoded.h). */
#include <math.h>
#include <stdlib.h>

#include "array/core/array.h"
#include "array/core/mask.h"
#include "array/core/share.h"
#include "array/core/summary.h"
#include "array/truncate/account.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "codec/brick/brick_shape.h"
#include "codec/brick/coded.h"
#include "codec/container/array_file.h"
#include "codec/container/ranges.h"
#include "codec/quantize/coding.h"
#include "codec/rate/compress_options.h"
#include "codec/rate/requantize.h"
#include "codec/rate/step_search.h"
#include "codec/rate/transcode_decoded.h"
#include "codec/rate/transcode_search.h"
#include "codec/rate/volume_distance.h"
#include "cvol/codec.h"

enum { COMMITS_MAX = 5 };
#define SLACK_MAX 30

static double psnr_of(const cvol_array *array, double l2_error)
{
    const double span = array->error_bound.value_max - array->error_bound.value_min;
    return 20 * cvol_log10(span * sqrt((double)cvol_array_valued_samples(array)) / l2_error);
}

/* Tries bound the distance of coefficients. The distance of the two arrays' samples bounds more
 * tightly: the result's error is at most the source's error plus it (triangle inequality), as
 * floats for the error bound; and as stored samples, if the source's stored samples were measured,
 * without extra rounding. */
static int account_samples(const cvol_transcoding *t, cvol_array *array)
{
    const cvol_array *from = t->from;
    cvol_volume_distance apart;
    int code = cvol_volume_distance_between(t->context, &apart, from, array);
    if (code)
        return code;
    const double samples = sqrt((double)cvol_grid_samples(&array->grid));
    const double norm = (from->error_bound.max_abs + fabs(from->offset)) * samples + apart.real_l2;
    const double l2_error = from->error_bound.l2_error + apart.real_l2 + CVOL_ROUNDING * norm;
    const double point = cvol_error_bound_point(&from->error_bound) + apart.real_most +
                         cvol_array_sample_rounding(array);
    array->error_bound.point_error = fmin(cvol_error_bound_point(&array->error_bound), point);
    array->error_bound.l2_error = fmin(array->error_bound.l2_error, l2_error);
    cvol_array_derive_figures(array);
    if (!from->measured)
        return CVOL_OK;
    const double span = from->error_bound.value_max - from->error_bound.value_min;
    const double valued = sqrt((double)cvol_array_valued_samples(from));
    const double off = span * valued * cvol_pow(10, -from->psnr_db / 20) * (1 + 1e-9);
    array->max_error = fmin(array->max_error, (from->max_error + apart.most) * (1 + 1e-9));
    array->psnr_db = fmax(array->psnr_db, psnr_of(array, off + apart.stored_l2));
    return CVOL_OK;
}

/* Copies the source's mask, cell by cell. */
static int copy_mask(cvol_context *context, cvol_array *to, const cvol_array *from)
{
    uint8_t which[CVOL_MASK_CELL * CVOL_MASK_CELL * CVOL_MASK_CELL];
    const size_t *dims = from->grid.dims;
    if (!from->mask)
        return CVOL_OK;
    int code = cvol_mask_create(context, &to->mask, dims, cvol_mask_fills(from->mask));
    for (size_t z = 0; z < dims[2] && !code; z += CVOL_MASK_CELL)
        for (size_t y = 0; y < dims[1] && !code; y += CVOL_MASK_CELL)
            for (size_t x = 0; x < dims[0] && !code; x += CVOL_MASK_CELL) {
                const size_t begin[3] = {x, y, z};
                size_t end[3];
                for (int a = 0; a < 3; a++)
                    end[a] = dims[a] - begin[a] < CVOL_MASK_CELL ? dims[a]
                                                                 : begin[a] + CVOL_MASK_CELL;
                if (cvol_mask_get(which, from->mask, begin, end) &&
                    !cvol_mask_set(to->mask, which, begin, end))
                    code = cvol_fail_memory(context, sizeof which, "the mask");
            }
    return code;
}

/* A process of a team decodes the bricks of its share and around it. */
static int decode(cvol_context *context, cvol_array *array, const cvol_coded *coded)
{
    const cvol_share share = cvol_share_of(context, array);
    const size_t around = (size_t)array->block, *dims = array->grid.dims;
    if (!share.team)
        return cvol_coded_decode(context, array, coded, NULL);
    cvol_box box = {.end = {dims[0], dims[1], dims[2]}};
    if (share.slices[0] > around)
        box.begin[2] = share.slices[0] - around;
    if (share.slices[1] + around < dims[2])
        box.end[2] = share.slices[1] + around;
    const int code = cvol_coded_decode(context, array, coded, &box);
    return code ? code : cvol_share_count_terms(context, &array->coefficients, array);
}

/* Makes the array of a step, with its coded bricks. */
static int commit_step(cvol_transcoding *t, cvol_array **out, cvol_coarseness coarseness)
{
    cvol_coded *coded = NULL;
    int code = cvol_coded_make(t->context, &coded, t->tables, t->from);
    const cvol_brick_sink sink = cvol_coded_sink(coded);
    if (!code)
        code = cvol_requantise(t->context, &t->error, t->counts, t->from, coarseness, t->tables,
                               &sink);
    if (!code)
        code = cvol_transcoding_make_like(t->context, out, t->from, coarseness.step);
    if (!code)
        code = decode(t->context, *out, coded);
    if (!code)
        code = copy_mask(t->context, *out, t->from);
    if (!code) {
        cvol_transcoding_account(t, *out);
        t->tried_db = (*out)->psnr_db;
        code = account_samples(t, *out);
    }
    if (!code && cvol_array_may_have_ranges(*out, t->file_bytes))
        code = cvol_ranges_find(t->context, *out);
    if (!code) {
        cvol_coded_attach(*out, coded);
        coded = NULL;
        code = cvol_array_file_bytes(t->context, *out, &t->file_bytes);
    }
    cvol_coded_free(coded);
    return code;
}

/* The bytes of ranges and masks are known only at the end: further searches include them. */
static int run_ratio(cvol_transcoding *t, cvol_array **out, int *reached)
{
    for (int i = 0; i < COMMITS_MAX; i++) {
        cvol_coarseness best;
        int code = cvol_transcoding_search(t, &best, reached);
        if (code)
            return code;
        const uint64_t counted = t->file_bytes;
        cvol_array_free(*out);
        *out = NULL;
        code = commit_step(t, out, best);
        if (code || cvol_transcoding_ratio(t) >= t->value || !*reached)
            return code;
        t->other_bytes += t->file_bytes > counted ? t->file_bytes - counted : 0;
    }
    *reached = 0;
    return CVOL_OK;
}

/* The measured PSNR of a step is known only after it is committed; later searches may then lower
 * the target by that surplus. The result of the estimates alone is kept as a fallback. */
static int run_psnr(cvol_transcoding *t, cvol_array **out, int *reached)
{
    int code = CVOL_OK;
    if (t->from->measured && t->from->psnr_db > t->value) {
        cvol_array *finest;
        code = cvol_transcoding_make_like(t->context, &finest, t->from,
                                          cvol_transcoding_own_step(t));
        if (code)
            return code;
        t->error = 0;
        cvol_transcoding_account(t, finest);
        t->slack_db = fmin(t->from->psnr_db - finest->psnr_db, SLACK_MAX);
        cvol_array_free(finest);
    }
    for (int i = 0; i < COMMITS_MAX; i++) {
        cvol_coarseness best;
        if (i == COMMITS_MAX - 1)
            t->slack_db = 0;
        code = cvol_transcoding_search(t, &best, reached);
        if (!code) {
            cvol_array_free(*out);
            *out = NULL;
            code = commit_step(t, out, best);
        }
        if (code)
            return code;
        const double over = (*out)->psnr_db - t->value;
        if (over >= 0 && (over < 2 * CVOL_PSNR_ACCEPTED || i >= COMMITS_MAX - 2))
            break;
        t->slack_db = fmax((*out)->psnr_db - t->tried_db, 0);
    }
    return CVOL_OK;
}

static int run(cvol_transcoding *t, cvol_array **out, int *reached)
{
    return t->target == CVOL_TARGET_PSNR ? run_psnr(t, out, reached) : run_ratio(t, out, reached);
}

static int check(cvol_context *context, cvol_transcoding *t, const cvol_compress_options *options)
{
    int code = cvol_compress_options_check(context, options);
    if (!code)
        code = cvol_array_need_volume(context, t->from, "transcoding");
    if (!code && options->target == CVOL_TARGET_MAX_ERROR)
        code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "transcoding cannot keep a maximum error: it has no original samples; "
                         "compress the volume itself");
    t->target = options->target;
    t->value = options->target_value;
    if (!code && t->target == CVOL_TARGET_BITS) {
        t->target = CVOL_TARGET_RATIO;
        code = cvol_ratio_of_bits(context, &t->value, options->target_value, t->from->grid.type);
    }
    return code;
}

static int transcode(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                     const cvol_array *array, const cvol_compress_options *options)
{
    cvol_array from = *array; /* but without its bricks and its summary */
    cvol_file_coding coding = *cvol_coding_of(array);
    cvol_summary summary = *cvol_array_summary(array);
    cvol_transcoding t = {.context = context, .from = &from};
    int reached = 0;
    *out = NULL;
    int code = check(context, &t, options);
    if (!code)
        code = cvol_brick_sides_check(context, options->brick, array->block);
    if (!code && array->residual)
        return cvol_transcode_decoded(context, out, report, array, t.target, t.value, options);
    if (!code && options->brick[0])
        coding.brick = cvol_brick_shape_make(options->brick);
    from.coding = &coding.base;
    if (!code && options->no_histogram)
        summary.state = CVOL_SUMMARY_LEFT_OUT;
    else if (!code && summary.state != CVOL_SUMMARY_LEFT_OUT)
        code = cvol_summarise_array(context, &summary, array);
    from.summary = &summary;
    if (code)
        return code;
    t.tables = cvol_token_tables_create();
    t.counts = cvol_allocate_zero(1, sizeof *t.counts);
    code = t.tables && t.counts ? run(&t, out, &reached)
                                : cvol_fail_memory(context, sizeof *t.counts, "the coder's tables");
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    } else if (report) {
        *report = (cvol_compress_report){.ratio = cvol_transcoding_ratio(&t),
                                         .psnr_db = (*out)->psnr_db,
                                         .max_error = (*out)->max_error,
                                         .file_bytes = t.file_bytes,
                                         .target_met = reached,
                                         .trials = t.count,
                                         .coefficients = (*out)->coefficients};
    }
    cvol_array_free(t.shape);
    free(t.tables);
    free(t.counts);
    return code;
}

int cvol_array_transcode(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                         const cvol_array *array, const cvol_compress_options *options)
{
    cvol_compress_options full;
    *out = NULL;
    int code = cvol_compress_options_complete(context, &full, options);
    if (!code)
        code = transcode(context, out, report, array, &full);
    if (code)
        return code;
    const double psnr_db = (*out)->psnr_db;
    code = cvol_compress_check_least_psnr(context, &full, psnr_db, !(*out)->measured);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
        if (report)
            report->psnr_db = psnr_db;
    }
    return code;
}
