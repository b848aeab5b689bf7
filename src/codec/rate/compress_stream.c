/* Compresses samples that are read slab by slab, straight into a file.
 *
 * Passes over the samples: one for their range; a few strips of bricks, to find the step; for large
 * volumes, passes over more bricks in all parts of the volume (estimates); then one that encodes,
 * writes and measures. If it misses the target, the encoder repeats this pass with another step. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/summary.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "codec/container/writer.h"
#include "codec/quantize/coding.h"
#include "codec/rate/compress_options.h"
#include "codec/rate/compress_residual.h"
#include "codec/rate/compress_stream.h"
#include "codec/rate/step_search.h"
#include "codec/rate/strip_measure.h"
#include "codec/rate/target.h"
#include "cvol/codec.h"

enum { PASSES_MAX = 8, ESTIMATES_MAX = 6, ESTIMATED_BRICKS = 2048 };
/* An estimate with a smaller miss is good enough. */
#define ESTIMATE_MISS 0.004

/* Bytes of samples of a strip (codec/brick/slab_source.h), which a process has in memory. */
#define STRIP_BYTES ((size_t)1 << 27)

/* The samples in memory. */
typedef struct slabs {
    const cvol_sample_source *source;
    size_t row_bytes, rows; /* rows: of a whole slice */
    uint8_t *samples;
    size_t capacity; /* bytes */
    cvol_slab now;
} slabs;

static int make_room(cvol_context *context, slabs *s, size_t bytes)
{
    if (bytes <= s->capacity)
        return CVOL_OK;
    free(s->samples);
    s->capacity = 0;
    s->now = (cvol_slab){0};
    s->samples = cvol_allocate(bytes, 1);
    if (!s->samples)
        return cvol_fail_memory(context, bytes, "a slab of samples");
    s->capacity = bytes;
    return CVOL_OK;
}

static int fetch(cvol_context *context, void *user, cvol_slab *wanted)
{
    slabs *s = user;
    const cvol_sample_source *source = s->source;
    cvol_slab next = *wanted;
    if (!source->read_rows) {
        next.first_row = 0;
        next.rows = s->rows;
    }
    const size_t slice_bytes = next.rows * s->row_bytes, end = next.first_slice + next.slices;
    int code = make_room(context, s, next.slices * slice_bytes);
    if (code)
        return code;
    /* Slices already in memory are not read again. */
    const cvol_slab now = s->now;
    size_t kept = 0;
    if (now.first_row == next.first_row && now.rows == next.rows &&
        next.first_slice >= now.first_slice && next.first_slice < now.first_slice + now.slices) {
        const size_t old_end = now.first_slice + now.slices;
        kept = (old_end < end ? old_end : end) - next.first_slice;
        memmove(s->samples, s->samples + (next.first_slice - now.first_slice) * slice_bytes,
                kept * slice_bytes);
    }
    s->now = next;
    s->now.slices = kept;
    uint8_t *to = s->samples + kept * slice_bytes;
    const size_t first = next.first_slice + kept, count = next.slices - kept;
    if (count && source->read_rows)
        code = source->read_rows(context, source->user, to, first, count, next.first_row,
                                 next.rows);
    else if (count)
        code = source->read(context, source->user, to, first, count);
    if (code)
        return code;
    s->now.slices = next.slices;
    s->now.samples = s->samples;
    *wanted = s->now;
    return CVOL_OK;
}

/* One pass with a step: the writer holds the file's content, and the decoded result is measured. */
typedef struct stream_attempt {
    cvol_file_writer *writer;
    cvol_array *found;                  /* without terms: the header of the file, */
    double subband_norm[CVOL_SUBBANDS]; /* except for these norms */
} stream_attempt;

static void attempt_drop(stream_attempt *a)
{
    cvol_file_writer_abandon(a->writer);
    cvol_array_free(a->found);
    *a = (stream_attempt){0};
}

static int add_to_writer(cvol_context *context, void *user, size_t brick,
                         const cvol_span subbands[CVOL_SUBBANDS])
{
    (void)brick;
    return cvol_file_writer_add(context, user, subbands);
}

/* The start of the file, before the bricks. */
typedef struct file_start {
    cvol_token_tables *tables;
    const char *attributes;
    cvol_output *within; /* the file that contains this one, or NULL */
} file_start;

static cvol_header header_of(const stream_attempt *a)
{
    cvol_header header = cvol_header_of(a->found);
    memcpy(header.subband_norm, a->subband_norm, sizeof header.subband_norm);
    return header;
}

/* The exact size of the attempt's file. */
static int attempt_size(cvol_compression *c, const stream_attempt *a, const file_start *start)
{
    const cvol_header header = header_of(a);
    const cvol_file_front front = {
        .header = &header, .attributes = start->attributes, .tables = start->tables};
    return cvol_file_writer_bytes(c->context, a->writer, &front, &c->file_bytes);
}

/* The work on a strip's samples after they are encoded. */
typedef struct strip_work {
    cvol_strip_measure *measure;
    cvol_attempt *attempt;
} strip_work;

static int tally_strip(cvol_context *context, cvol_attempt *attempt, const cvol_slab *slab,
                       const cvol_strip *strip)
{
    const cvol_grid *grid = &attempt->shape->grid;
    const cvol_box box = cvol_strip_samples(attempt->shape, strip);
    const size_t line = grid->dims[0], count = line * (box.end[1] - box.begin[1]);
    int code = CVOL_OK;
    for (size_t z = box.begin[2]; z < box.end[2] && !code; z++)
        code = cvol_tally_add(context, attempt->tally,
                              (const uint8_t *)slab->samples +
                                  cvol_slab_row(slab, line, box.begin[1], z) *
                                      cvol_type_size(grid->type),
                              count);
    return code;
}

static int after_strip(cvol_context *context, void *user, const cvol_slab *slab,
                       const cvol_strip *strip)
{
    const strip_work *work = user;
    int code = CVOL_OK;
    if (work->attempt->tally && strip)
        code = tally_strip(context, work->attempt, slab, strip);
    code = cvol_team_agree(context, work->attempt->source.team, code);
    return code ? code : cvol_strip_measure_after(context, work->measure, slab, strip);
}

static int attempt_run(cvol_compression *c, stream_attempt *a, const char *path, double step,
                       const file_start *start)
{
    cvol_attempt *attempt = &c->attempt;
    cvol_strip_measure *measure = NULL;
    const cvol_array *shape = attempt->shape;
    const cvol_file_coding *coding = cvol_coding_of(shape);
    cvol_team *team = attempt->source.team;
    const size_t bricks = cvol_brick_count(shape), run = coding->brick.run;
    int code = start->within
                   ? cvol_file_writer_open_within(c->context, &a->writer, start->within, bricks,
                                                  run)
                   : cvol_file_writer_open(c->context, &a->writer,
                                           cvol_team_writes(team) ? path : NULL, bricks, run);
    const cvol_brick_sink sink = {add_to_writer, a->writer};
    if (!code)
        code = cvol_array_create(c->context, &a->found, &shape->grid, shape->block);
    cvol_attempt_set_step(attempt, step);
    if (!code)
        code = cvol_strip_measure_make(c->context, &measure, shape, step, attempt->tables, &sink,
                                       &attempt->source);
    code = cvol_team_agree(c->context, team, code);
    if (!code) {
        const cvol_brick_sink through = cvol_strip_measure_sink(measure);
        strip_work work = {measure, attempt};
        code = cvol_attempt_pass(c->context, attempt, step, &through, after_strip, &work);
    }
    if (!code && attempt->tally)
        code = cvol_tally_share(c->context, attempt->tally, team);
    if (!code && attempt->tally)
        code = cvol_attempt_finish_tally(c->context, attempt);
    if (!code)
        code = cvol_coding_copy(c->context, a->found, shape);
    if (!code) {
        cvol_array *found = a->found;
        found->step = ldexp(step, -coding->true_length);
        found->offset = shape->offset;
        found->lapped = shape->lapped;
        found->error_bound.value_min = shape->error_bound.value_min;
        found->error_bound.value_max = shape->error_bound.value_max;
        cvol_strip_measure_report(measure, found, a->subband_norm);
        code = cvol_array_set_summary(c->context, found, cvol_array_summary(shape));
    }
    cvol_strip_measure_free(measure);
    return code ? code : attempt_size(c, a, start);
}

/* The miss of the attempt; *kept: the target holds, *good: and by no more than necessary. */
static double miss_of(const cvol_compression *c, const cvol_array *found, int *kept, int *good)
{
    if (c->target == CVOL_TARGET_PSNR) {
        const double over = found->psnr_db - c->value;
        *kept = over >= 0;
        *good = over >= 0 && over < 2 * CVOL_PSNR_ACCEPTED;
        return (CVOL_PSNR_AIM - (over > 30 ? 30 : over)) / CVOL_DB_PER_E;
    }
    const double ratio = (double)c->raw_bytes / (double)c->file_bytes;
    *kept = ratio >= c->value;
    *good = ratio >= c->value && ratio <= c->value * CVOL_RATIO_MAX * 0.998;
    return cvol_log(ratio / c->value / CVOL_RATIO_AIM);
}

static int write_file(cvol_compression *c, stream_attempt *a, const file_start *start)
{
    const cvol_header header = header_of(a);
    const cvol_file_front front = {
        .header = &header, .attributes = start->attributes, .tables = start->tables};
    cvol_file_writer *writer = a->writer;
    a->writer = NULL; /* freed in any case */
    return cvol_file_writer_finish(c->context, writer, &front, &c->file_bytes);
}

static void fill_report(cvol_compress_report *report, const cvol_compression *c,
                        const cvol_array *found, int kept, int reached)
{
    *report = (cvol_compress_report){.ratio = (double)c->raw_bytes / (double)c->file_bytes,
                                     .psnr_db = found->psnr_db,
                                     .max_error = found->max_error,
                                     .file_bytes = c->file_bytes,
                                     .lossless = found->max_error <= 0,
                                     .target_met = reached || (kept && found->max_error <= 0),
                                     .trials = c->attempt.count,
                                     .coefficients = found->coefficients};
}

/* A search over a few thousand bricks. */
typedef struct estimates {
    cvol_compression *c;
    size_t every;
    double step, least_miss; /* the step that missed by least */
} estimates;

static int try_estimate(void *user, int number, double step, double *miss,
                        cvol_search_verdict *verdict)
{
    estimates *e = user;
    cvol_compression *c = e->c;
    int code = number == 1 ? cvol_attempt_fit(c->context, &c->attempt) : CVOL_OK;
    if (!code)
        code = cvol_attempt_estimate(c->context, &c->attempt, step, e->every);
    if (code)
        return code;
    *miss = cvol_compression_sample_miss(c);
    if (number == 0) {
        *verdict = CVOL_SEARCH_RESTART;
        return CVOL_OK;
    }
    if (fabs(*miss) < e->least_miss) {
        e->least_miss = fabs(*miss);
        e->step = step;
    }
    if (e->least_miss < ESTIMATE_MISS)
        *verdict = CVOL_SEARCH_ENOUGH;
    return CVOL_OK;
}

/* A full pass over a large volume takes long, so passes over a few thousand bricks estimate its
 * result first. The tables are fitted to the first of these passes. Its miss gives the second step,
 * but does not enter the search, because slopes between different tables mean nothing. Takes the
 * step with the smallest miss. */
static int estimate_step(cvol_compression *c, double *step, size_t every)
{
    static const cvol_search_plan plan = {.attempts_max = ESTIMATES_MAX};
    estimates e = {c, every, *step, (double)INFINITY};
    cvol_search search = cvol_search_make(c->least_step, c->most_step, c->slope);
    const int code = cvol_search_run(&search, step, &plan, try_estimate, &e);
    if (code)
        return code;
    *step = e.step;
    if (isfinite(cvol_search_width(&search)))
        c->slope = fmin(fmax(cvol_search_slope(&search), 0.5 * c->slope), 2 * c->slope);
    return CVOL_OK;
}

/* The search over passes. After the first pass, tables that were fitted to samples are fitted to
 * its tokens. Its miss then says little about later passes. Tables from estimates stay. */
typedef struct passes {
    cvol_compression *c;
    stream_attempt *now;
    const char *path;
    const file_start *start;
    double best; /* the best step that kept the target, 0: none yet */
    int refits;  /* 1: the first pass is not part of the search */
    int kept, good;
} passes;

static int try_pass(void *user, int number, double step, double *miss, cvol_search_verdict *verdict)
{
    passes *p = user;
    cvol_compression *c = p->c;
    int code = CVOL_OK;
    if (number > 0) {
        if (number == p->refits)
            code = cvol_attempt_fit(c->context, &c->attempt);
        attempt_drop(p->now);
    }
    /* The last pass uses a step that keeps the target, if there is one. */
    if (number + 1 == PASSES_MAX && p->best > 0)
        step = p->best;
    if (!code) {
        memcpy(p->start->tables, c->attempt.tables, sizeof *p->start->tables);
        code = attempt_run(c, p->now, p->path, step, p->start);
    }
    if (code)
        return code;
    *miss = miss_of(c, p->now->found, &p->kept, &p->good);
    /* The coarsest step is best for a PSNR, the finest for a size. */
    const int is_coarse = c->target == CVOL_TARGET_PSNR;
    if (p->kept && number >= p->refits && (p->best <= 0 || is_coarse == (step > p->best)))
        p->best = step;
    if (p->good)
        *verdict = CVOL_SEARCH_ENOUGH;
    else if (number + 1 == p->refits)
        *verdict = CVOL_SEARCH_RESTART;
    return CVOL_OK;
}

/* Runs passes until one meets the target. */
static int search_step(cvol_compression *c, stream_attempt *now, const char *path,
                       const file_start *start, size_t estimated, int *kept, int *good)
{
    static const cvol_search_plan plan = {.attempts_max = PASSES_MAX};
    /* The unit is a number of samples, so the shape of bricks does not matter. */
    const size_t more = CVOL_BRICK_SAMPLES / cvol_brick_volume(c->attempt.shape);
    const size_t every = cvol_brick_count(c->attempt.shape) / more / estimated;
    passes p = {.c = c, .now = now, .path = path, .start = start, .refits = every <= 1};
    double step;
    int code = cvol_compression_prepare(c, &step);
    cvol_sampler_free(c->attempt.sampler); /* passes need its memory */
    c->attempt.sampler = NULL;
    if (!code && every > 1)
        code = estimate_step(c, &step, every);
    if (code)
        return code;
    cvol_search search = cvol_search_make(c->least_step, c->most_step, c->slope);
    code = cvol_search_run(&search, &step, &plan, try_pass, &p);
    *kept = p.kept;
    *good = p.good;
    return code;
}

static int run(cvol_compression *c, const char *path, cvol_output *within, const char *attributes,
               size_t estimated, cvol_compress_report *report)
{
    const file_start start = {malloc(sizeof *start.tables), attributes, within};
    const int constant = !(c->attempt.shape->error_bound.value_max >
                           c->attempt.shape->error_bound.value_min);
    stream_attempt now = {0};
    int kept = 0, good = 0;
    int code = start.tables ? CVOL_OK
                            : cvol_fail_memory(c->context, sizeof *start.tables, "tables");
    if (!code && constant) {
        memcpy(start.tables, c->attempt.tables, sizeof *start.tables);
        code = attempt_run(c, &now, path, 1, &start);
        if (!code)
            (void)miss_of(c, now.found, &kept, &good);
        good = c->target == CVOL_TARGET_PSNR || good;
    } else if (!code) {
        code = search_step(c, &now, path, &start, estimated, &kept, &good);
    }
    if (!code && !kept && c->target == CVOL_TARGET_PSNR)
        code = cvol_fail(c->context, CVOL_ERROR_TARGET,
                         "a PSNR of %g dB cannot be reached for these %s samples, %.2f dB can",
                         c->value, cvol_type_name(c->attempt.shape->grid.type), now.found->psnr_db);
    if (!code && report)
        fill_report(report, c, now.found, kept, good);
    if (!code)
        code = cvol_compress_check_least_psnr(c->context, c->options, now.found->psnr_db, 0);
    if (!code) /* the last moment to cancel */
        code = cvol_report_progress(c->context, "compressing", 1);
    code = cvol_team_agree(c->context, c->attempt.source.team, code);
    if (!code)
        code = write_file(c, &now, &start);
    code = cvol_team_agree(c->context, c->attempt.source.team, code);
    if (!code && report)
        fill_report(report, c, now.found, kept, good);
    attempt_drop(&now);
    free(start.tables);
    return code;
}

static int compress_into(cvol_context *context, cvol_compress_report *report, const char *path,
                         cvol_output *within, const cvol_sample_source *source,
                         const cvol_grid *grid, const cvol_compress_options *options,
                         const cvol_stream_work *work)
{
    const size_t estimated = work->estimated ? work->estimated : ESTIMATED_BRICKS;
    cvol_compression c = {.context = context,
                          .options = options,
                          .target = options->target,
                          .value = options->target_value};
    slabs memory = {.source = source};
    const cvol_slab_source from = {.fetch = fetch,
                                   .user = &memory,
                                   .strip_bytes = work->strip_bytes ? work->strip_bytes
                                                                    : STRIP_BYTES,
                                   .team = work->team};
    int code = cvol_compress_options_check(context, options);
    if (!code)
        code = cvol_grid_check(context, grid, "the volume");
    if (!code && (options->block != 16 || cvol_compress_needs_residual(options)))
        code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "samples that are read by slab are compressed in cells of 16, to a ratio, "
                         "bits a sample or a PSNR");
    if (!code && c.target == CVOL_TARGET_BITS) {
        code = cvol_ratio_of_bits(context, &c.value, options->target_value, grid->type);
        c.target = CVOL_TARGET_RATIO;
    }
    if (code)
        return code;
    c.raw_bytes = cvol_grid_bytes(grid);
    memory.row_bytes = grid->dims[0] * cvol_type_size(grid->type);
    memory.rows = grid->dims[1];
    code = cvol_attempt_start_source(context, &c.attempt, &from, grid, options);
    if (!code) /* checked, and kept */
        code = cvol_array_set_attributes(context, c.attempt.shape, options->attributes);
    if (!code) {
        cvol_attempt_set_options(&c.attempt, options);
        cvol_compression_limits(&c);
        code = run(&c, path, within, cvol_array_attributes(c.attempt.shape), estimated, report);
    }
    cvol_attempt_free(&c.attempt);
    free(memory.samples);
    return code;
}

int cvol_compress_stream_within(cvol_context *context, cvol_compress_report *report,
                                cvol_output *output, const cvol_sample_source *source,
                                const cvol_grid *grid, const cvol_compress_options *options)
{
    return compress_into(context, report, NULL, output, source, grid, options,
                         &(cvol_stream_work){0});
}

int cvol_compress_stream_by(cvol_context *context, cvol_compress_report *report, const char *path,
                            const cvol_sample_source *source, const cvol_grid *grid,
                            const cvol_compress_options *options, const cvol_stream_work *work)
{
    cvol_compress_options full;
    int code = cvol_compress_options_complete(context, &full, options);
    if (!code)
        code = compress_into(context, report, path, NULL, source, grid, &full, work);
    return code ? cvol_team_agree(context, work->team, code) : CVOL_OK;
}

int cvol_compress_stream(cvol_context *context, cvol_compress_report *report, const char *path,
                         const cvol_sample_source *source, const cvol_grid *grid,
                         const cvol_compress_options *options)
{
    return cvol_compress_stream_by(context, report, path, source, grid, options,
                                   &(cvol_stream_work){0});
}
