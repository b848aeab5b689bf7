/* Encode attempts: from samples to a measured array. */
#include "codec/rate/encode_attempt.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/summary.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "codec/brick/brick_shape.h"
#include "codec/container/section_pack.h"
#include "codec/container/summary_section.h"
#include "codec/mask/mask_make.h"
#include "codec/mask/mask_section.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/true_length.h"
#include "codec/rate/background.h"
#include "codec/rate/brick_choice.h"
#include "codec/rate/measure.h"
#include "transform/lap.h"

/* With larger values, sums of squares and transforms would overflow float; and so would the samples
 * themselves, even if they are constant. */
#define SPAN_MAX 2e35
#define MAGNITUDE_MAX ((double)FLT_MAX)
/* A mask with more than this share of the target's bytes leaves too few for the terms. */
#define MASK_SHARE_MAX 0.9
/* Bytes of a brick's mask without tokens: cell kinds, length and checksum. */
#define MASK_BRICK 16

/* Returns all samples. */
static int fetch(cvol_context *context, void *user, cvol_slab *slab)
{
    const cvol_attempt *attempt = user;
    (void)context;
    *slab = cvol_slab_of(attempt->samples, &attempt->shape->grid);
    return CVOL_OK;
}

/* Estimates the sections in front of the subbands: headers and records, two bytes per brick and
 * subband, a checksum per run and subband (half of which may be empty if a run is one brick), and
 * the tables. */
static int estimate_front(cvol_context *context, cvol_attempt *attempt, size_t table_bytes)
{
    const cvol_array *shape = attempt->shape;
    const size_t run = cvol_coding_of(shape)->brick.run;
    const uint64_t a_brick = 2 * CVOL_SUBBANDS +
                             (run > 1 ? 4 * CVOL_SUBBANDS / run : 2 * CVOL_SUBBANDS);
    const uint64_t summary = cvol_summary_section_bytes(cvol_array_summary(shape),
                                                        &shape->error_bound);
    if (summary == UINT64_MAX)
        return cvol_fail_memory(context, sizeof(cvol_summary), "a histogram");
    if (attempt->is_packed) /* the first brick's share is usual */
        attempt->front_bytes = CVOL_PACK_USUAL_BYTES +
                               a_brick * (uint64_t)(cvol_brick_count(shape) - 1) + table_bytes +
                               (summary ? summary - CVOL_SECTION_HEADER_BYTES : 0);
    else
        attempt->front_bytes = 656 + a_brick * (uint64_t)cvol_brick_count(shape) + table_bytes +
                               summary;
    return CVOL_OK;
}

/* True if the target's bytes lie within least .. most; a PSNR allows any number. */
static int allows(const cvol_compress_options *options, const cvol_grid *grid, double least,
                  double most)
{
    const double value = options->target_value;
    if (options->target == CVOL_TARGET_PSNR)
        return 1;
    const double budget = options->target == CVOL_TARGET_BITS
                              ? (double)cvol_grid_samples(grid) * value / 8
                              : (double)cvol_grid_bytes(grid) / value;
    return least <= budget && budget <= most;
}

static int make_shape(cvol_context *context, cvol_attempt *attempt, const cvol_grid *grid,
                      const cvol_compress_options *options)
{
    const int block = options->block;
    int code = cvol_array_create(context, &attempt->shape, grid, block);
    if (!code)
        code = cvol_coding_need(context, attempt->shape);
    if (code)
        return code;
    cvol_file_coding *coding = cvol_coding_own(attempt->shape);
    coding->brick = cvol_brick_shape_choose(grid, options);
    attempt->is_packed = cvol_brick_count(attempt->shape) <= coding->brick.run &&
                         allows(options, grid, 0, (double)CVOL_PACK_MAX);
    attempt->shape->lapped = attempt->may_lap = block == 16;
    coding->trellis = block == 16;
    for (int a = 0; a < 3 && block == 16; a++)
        if (grid->dims[a] % CVOL_CELL)
            attempt->may_end = 1;
    attempt->split = block == 16 ? CVOL_SPLIT_BEST : CVOL_SPLIT_NEVER;
    attempt->error_share = 1;
    attempt->tables = cvol_token_tables_create();
    attempt->counts = cvol_allocate_zero(1, sizeof *attempt->counts);
    if (!attempt->tables || !attempt->counts)
        return cvol_fail_memory(context, sizeof *attempt->tables, "the coder's tables");
    return CVOL_OK;
}

void cvol_attempt_widen_range(double *least, double *largest, cvol_type type,
                              const cvol_compress_options *options)
{
    double lowest, highest;
    if (!options->has_value_range)
        return;
    cvol_type_get_range(&lowest, &highest, type);
    const int is_integer = cvol_type_is_integer(type);
    const double low = is_integer ? floor(options->value_min) : options->value_min;
    const double high = is_integer ? ceil(options->value_max) : options->value_max;
    *least = fmin(*least, fmax(low, lowest));
    *largest = fmax(*largest, fmin(high, highest));
}

/* The range of the samples determines the offset. */
static int take_range(cvol_context *context, cvol_array *shape, double least, double most,
                      const cvol_compress_options *options)
{
    cvol_attempt_widen_range(&least, &most, shape->grid.type, options);
    shape->error_bound.value_min = least;
    shape->error_bound.value_max = most;
    shape->offset = least;
    if (!(most - least <= SPAN_MAX))
        return cvol_fail(context, CVOL_ERROR_DATA,
                         "samples reach from %g to %g, a range beyond %g cannot be compressed",
                         least, most, SPAN_MAX);
    if (!(fmax(-least, most) <= MAGNITUDE_MAX))
        return cvol_fail(context, CVOL_ERROR_DATA,
                         "samples reach from %g to %g, magnitudes beyond %g cannot be compressed",
                         least, most, MAGNITUDE_MAX);
    return CVOL_OK;
}

/* Makes the summary of the samples, for the file. */
static int summarise(cvol_context *context, cvol_attempt *attempt,
                     const cvol_compress_options *options)
{
    cvol_array *shape = attempt->shape;
    cvol_summary summary = {.state = CVOL_SUMMARY_LEFT_OUT};
    int code = CVOL_OK;
    if (!options->no_histogram)
        code = cvol_summarise_samples(context, &summary, attempt->truth, &shape->grid, NULL);
    if (!code)
        code = cvol_array_set_summary(context, shape, &summary);
    return code ? code : estimate_front(context, attempt, 0);
}

int cvol_attempt_start(cvol_context *context, cvol_attempt *attempt, const void *samples,
                       const cvol_grid *grid, const cvol_compress_options *options)
{
    double least, most;
    *attempt = (cvol_attempt){.source = {.fetch = fetch, .user = attempt, .whole = 1},
                              .samples = samples,
                              .truth = samples};
    int code = make_shape(context, attempt, grid, options);
    if (!code)
        code = cvol_scan_samples(context, &least, &most, samples, grid);
    if (!code)
        code = take_range(context, attempt->shape, least, most, options);
    return code ? code : summarise(context, attempt, options);
}

/* The bytes of a mask in a file: streams, their lengths and checksums. */
static int measure_mask(cvol_context *context, cvol_attempt *attempt)
{
    const int code = cvol_mask_measure(context, &attempt->mask_bytes, attempt->shape);
    attempt->mask_bytes += MASK_BRICK * cvol_brick_count(attempt->shape);
    attempt->front_bytes += attempt->mask_bytes;
    return code;
}

/* True if the target's bytes leave room for terms next to the mask. */
static int leaves_room_for_terms(const cvol_compress_options *options, const cvol_grid *grid,
                                 uint64_t bytes)
{
    return allows(options, grid, (double)bytes / MASK_SHARE_MAX, (double)INFINITY);
}

static int start_masked(cvol_context *context, cvol_attempt *attempt, const void *samples,
                        const cvol_grid *grid, cvol_mask *mask, void *filled,
                        const cvol_compress_options *options)
{
    const double value = cvol_fills_value(cvol_mask_fills(mask), 0, grid->type);
    int code = cvol_attempt_start(context, attempt, filled, grid, options);
    attempt->filled = filled;
    if (!attempt->shape) {
        cvol_mask_free(mask);
        return code;
    }
    attempt->truth = samples;
    attempt->shape->mask = mask;
    if (!code) /* of all samples, instead of the filled ones */
        code = summarise(context, attempt, options);
    const cvol_error_bound *error_bound = &attempt->shape->error_bound;
    if (!code)
        code = take_range(context, attempt->shape, fmin(error_bound->value_min, value),
                          fmax(error_bound->value_max, value), options);
    if (!code)
        code = measure_mask(context, attempt);
    if (code || options->background == CVOL_BACKGROUND_VALUE ||
        leaves_room_for_terms(options, grid, attempt->mask_bytes))
        return code;
    cvol_attempt_free(attempt);
    return cvol_attempt_start(context, attempt, samples, grid, options);
}

int cvol_attempt_start_with_background(cvol_context *context, cvol_attempt *attempt,
                                       const void *samples, const cvol_grid *grid,
                                       const cvol_compress_options *options)
{
    cvol_fills fills;
    double least_step, least, most;
    cvol_mask *mask = NULL;
    void *filled = NULL;
    int code = cvol_grid_check(context, grid, "array");
    if (!code)
        code = cvol_background_fills(context, &fills, &least_step, samples, grid, options);
    /* The samples that replace the background would be infinite too, and count. */
    if (!code && fills.count && !cvol_type_is_integer(grid->type))
        code = cvol_scan_samples(context, &least, &most, samples, grid);
    if (!code && fills.count)
        code = cvol_mask_make(context, &mask, &filled, samples, grid, &fills);
    if (code || !mask)
        return code ? code : cvol_attempt_start(context, attempt, samples, grid, options);
    code = start_masked(context, attempt, samples, grid, mask, filled, options);
    attempt->least_step = code || !attempt->filled ? 0 : least_step;
    return code;
}

/* Slices that are read at a time for the range: all of a layer of bricks, or as many as a strip may
 * have bytes. */
static size_t scanned_at_once(const cvol_slab_source *source, const cvol_grid *grid)
{
    const size_t slice_bytes = grid->dims[0] * grid->dims[1] * cvol_type_size(grid->type);
    const size_t most = source->strip_bytes ? source->strip_bytes / slice_bytes : CVOL_BRICK_SIDE;
    return most < 1 ? 1 : most < CVOL_BRICK_SIDE ? most : CVOL_BRICK_SIDE;
}

/* The range of the samples of all processes. */
static int share_range(cvol_context *context, double *least, double *most, cvol_team *team,
                       int code)
{
    const double own[2] = {*least, *most};
    cvol_gathered all;
    if (!team)
        return code;
    code = cvol_team_gather(context, &all, team, code, own, sizeof own);
    for (int rank = 0; rank < team->size && !code; rank++) {
        double one[2];
        memcpy(one, all.all + all.offsets[rank], sizeof one);
        *least = fmin(*least, one[0]);
        *most = fmax(*most, one[1]);
    }
    cvol_gathered_free(&all);
    return code;
}

int cvol_attempt_start_source(cvol_context *context, cvol_attempt *attempt,
                              const cvol_slab_source *source, const cvol_grid *grid,
                              const cvol_compress_options *options)
{
    const size_t at_once = scanned_at_once(source, grid);
    double least = INFINITY, most = -INFINITY;
    *attempt = (cvol_attempt){.source = *source};
    int code = make_shape(context, attempt, grid, options);
    if (!code && !options->no_histogram)
        code = cvol_tally_create(context, &attempt->tally, grid, NULL);
    for (size_t first = 0; first < grid->dims[2] && !code; first += at_once) {
        const size_t left = grid->dims[2] - first;
        cvol_grid part = *grid;
        double from, to;
        if (!cvol_team_does(source->team, first / at_once))
            continue;
        part.dims[2] = left < at_once ? left : at_once;
        cvol_slab slab = {.first_slice = first, .slices = part.dims[2], .rows = grid->dims[1]};
        code = source->fetch(context, source->user, &slab);
        if (!code)
            code = cvol_scan_slices(context, &from, &to, slab.samples, &part, first);
        if (!code && attempt->tally)
            code = cvol_tally_add(context, attempt->tally, slab.samples, cvol_grid_samples(&part));
        if (!code)
            code = cvol_report_progress(context, "scanning the samples",
                                        (double)first / (double)grid->dims[2]);
        if (!code) {
            least = fmin(least, from);
            most = fmax(most, to);
        }
    }
    code = share_range(context, &least, &most, source->team, code);
    if (!code && attempt->tally)
        code = cvol_tally_share(context, attempt->tally, source->team);
    if (!code)
        code = take_range(context, attempt->shape, least, most, options);
    if (!code && !attempt->tally)
        code = cvol_array_set_summary(context, attempt->shape,
                                      &(cvol_summary){.state = CVOL_SUMMARY_LEFT_OUT});
    else if (!code && !cvol_tally_needs_another_pass(attempt->tally))
        code = cvol_attempt_finish_tally(context, attempt);
    return code ? code : estimate_front(context, attempt, 0);
}

int cvol_attempt_finish_tally(cvol_context *context, cvol_attempt *attempt)
{
    cvol_summary summary;
    cvol_tally_finish(attempt->tally, &summary);
    cvol_tally_free(attempt->tally);
    attempt->tally = NULL;
    return cvol_array_set_summary(context, attempt->shape, &summary);
}

void cvol_attempt_set_options(cvol_attempt *attempt, const cvol_compress_options *options)
{
    cvol_file_coding *coding = cvol_coding_own(attempt->shape);
    const int is_fast = options->effort == CVOL_EFFORT_FAST;
    attempt->fast = is_fast;
    coding->neural = options->effort == CVOL_EFFORT_MAX && coding->trellis;
    attempt->split_bias = coding->neural ? (cvol_split_bias){1, 1} : (cvol_split_bias){0};
    attempt->neural_bytes = CVOL_NEURAL_BYTES;
    attempt->neural_error = 1;
    if (!options->lapped)
        attempt->shape->lapped = attempt->may_lap = 0;
    if (is_fast && attempt->split == CVOL_SPLIT_BEST)
        attempt->split = CVOL_SPLIT_FAST;
    /* The base of a residual is rounded to nearest, for small residuals. */
    if (is_fast || options->lossless || options->max_error > 0 ||
        options->target == CVOL_TARGET_MAX_ERROR)
        coding->trellis = coding->neural = attempt->may_end = 0;
}

/* Frees an array, but not a mask that belongs to the shape. */
static void drop(const cvol_attempt *attempt, cvol_array **array)
{
    if (*array && (*array)->mask == attempt->shape->mask)
        (*array)->mask = NULL;
    cvol_array_free(*array);
    *array = NULL;
}

cvol_array *cvol_attempt_take_array(cvol_attempt *attempt)
{
    cvol_array *array = attempt->array;
    if (array->mask == attempt->shape->mask)
        attempt->shape->mask = NULL;
    attempt->array = NULL;
    return array;
}

void cvol_attempt_free(cvol_attempt *attempt)
{
    drop(attempt, &attempt->array);
    drop(attempt, &attempt->kept);
    cvol_array_free(attempt->shape);
    free(attempt->filled);
    cvol_tally_free(attempt->tally);
    cvol_coded_free(attempt->coded);
    cvol_sampler_free(attempt->sampler);
    cvol_cell_sample_free(attempt->cells);
    free(attempt->tables);
    free(attempt->counts);
}

/* At the volume's ends, terms in memory are finer than the step; true length is off if they would
 * become too large. */
void cvol_attempt_set_step(cvol_attempt *attempt, double step)
{
    const cvol_array *shape = attempt->shape;
    const double span = shape->error_bound.value_max - shape->error_bound.value_min;
    const double largest = 64 * CVOL_LAP_PRE_NORM_3 * span;
    attempt->step = step;
    cvol_coding_own(attempt->shape)->true_length = attempt->may_end &&
                                                           step > ldexp(largest,
                                                                        CVOL_TRUE_LENGTH_BITS - 29)
                                                       ? CVOL_TRUE_LENGTH_BITS
                                                       : 0;
}

int cvol_attempt_pass(cvol_context *context, cvol_attempt *attempt, double step,
                      const cvol_brick_sink *sink, cvol_strip_callback *after, void *user)
{
    cvol_attempt_set_step(attempt, step);
    const double left = ldexp(1, -attempt->count++);
    const cvol_encode_pass pass = {.shape = attempt->shape,
                                   .source = &attempt->source,
                                   .tables = attempt->tables,
                                   .weight = attempt->weight,
                                   .options = {step, attempt->split, attempt->plain,
                                               cvol_coding_of(attempt->shape)->trellis,
                                               attempt->split_bias},
                                   .sink = sink,
                                   .after = after,
                                   .user = user,
                                   .counts = attempt->uncounted ? NULL : attempt->counts,
                                   .kept = attempt->kept,
                                   .progress_from = 0.9 * (1 - left),
                                   .progress_to = 0.9 * (1 - left / 2)};
    const int code = cvol_encode_pass_run(context, &attempt->result, &pass);
    attempt->bytes = attempt->front_bytes + attempt->result.bytes;
    attempt->inside = cvol_grid_samples(&attempt->shape->grid);
    return code;
}

/* Makes an array like the shape, without terms. */
static int make_array(cvol_context *context, cvol_array **out, const cvol_attempt *attempt,
                      double step)
{
    const cvol_array *shape = attempt->shape;
    int code = cvol_array_create(context, out, &shape->grid, shape->block);
    if (!code)
        code = cvol_coding_copy(context, *out, shape);
    if (code)
        return code;
    (*out)->step = ldexp(step, -cvol_coding_of(shape)->true_length);
    (*out)->offset = shape->offset;
    (*out)->lapped = shape->lapped;
    (*out)->mask = cvol_mask_is_background(shape->mask) ? shape->mask : NULL;
    (*out)->error_bound.value_min = shape->error_bound.value_min;
    (*out)->error_bound.value_max = shape->error_bound.value_max;
    return cvol_array_set_summary(context, *out, cvol_array_summary(shape));
}

int cvol_attempt_encode(cvol_context *context, cvol_attempt *attempt, double step)
{
    cvol_coded_free(attempt->coded);
    attempt->coded = NULL;
    drop(attempt, &attempt->array); /* of another step */
    drop(attempt, &attempt->kept);
    cvol_attempt_set_step(attempt, step);
    int code = cvol_coded_make(context, &attempt->coded, attempt->tables, attempt->shape);
    if (!code && attempt->split == CVOL_SPLIT_FAST)
        code = make_array(context, &attempt->kept, attempt, step);
    if (code)
        return code;
    const cvol_brick_sink sink = cvol_coded_sink(attempt->coded);
    return cvol_attempt_pass(context, attempt, step, &sink, NULL, NULL);
}

int cvol_attempt_fit(cvol_context *context, cvol_attempt *attempt)
{
    cvol_bytes section = {0};
    cvol_token_tables_fit(attempt->tables, attempt->counts);
    int code = cvol_token_tables_put(context, &section, attempt->tables);
    if (!code)
        code = estimate_front(context, attempt,
                              cvol_coding_of(attempt->shape)->neural ? 0 : section.size);
    attempt->front_bytes += attempt->mask_bytes;
    cvol_bytes_free(&section);
    return code;
}

double cvol_attempt_psnr(const cvol_attempt *attempt)
{
    const double span = attempt->shape->error_bound.value_max -
                        attempt->shape->error_bound.value_min;
    const double error = attempt->result.error * attempt->error_share / (double)attempt->inside;
    return 10 * cvol_log10(span * span / error);
}

/* Progress during decoding and measuring: stays at the fraction that encoding reached. */
typedef struct standing {
    cvol_progress_fn progress;
    void *user;
    double fraction;
} standing;

static int report_standing(void *user, const char *what, double fraction)
{
    const standing *at = user;
    (void)what;
    (void)fraction;
    return at->progress(at->user, "compressing", at->fraction);
}

static int decode(cvol_context *context, cvol_attempt *attempt)
{
    int code = CVOL_OK;
    if (attempt->kept) {
        attempt->array = attempt->kept;
        attempt->kept = NULL;
    } else {
        code = make_array(context, &attempt->array, attempt, attempt->step);
        if (!code)
            code = cvol_coded_decode(context, attempt->array, attempt->coded, NULL);
    }
    if (code)
        return code;
    cvol_array *array = attempt->array;
    cvol_distance distance;
    code = cvol_measure_distance(context, &distance, array, attempt->truth);
    if (code)
        return code;
    cvol_array_set_measured(array, &distance);
    cvol_array_set_bounds(array, &distance);
    return CVOL_OK;
}

int cvol_attempt_decode(cvol_context *context, cvol_attempt *attempt)
{
    standing at = {context->progress, context->progress_user,
                   0.9 * (1 - ldexp(1, -attempt->count))};
    drop(attempt, &attempt->array);
    if (at.progress)
        cvol_context_set_progress(context, report_standing, &at);
    const int code = decode(context, attempt);
    cvol_context_set_progress(context, at.progress, at.user);
    return code;
}
