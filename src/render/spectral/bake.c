/* From samples to compressed planes. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "render/spectral/frame.h"

/* ---- classified slices ----------------------------------------------------------------------- */

/* One slice's planes; 0 if the slice is transparent. */
static int classify(float *planes[CVOL_PLANES], const cvol_splat_slab *slab, size_t place,
                    const cvol_bake_source *source, const size_t dims[2], size_t margin,
                    cvol_splat_list *list)
{
    const cvol_splat_plan *plan = source->plan;
    const size_t stride = slab->row_stride, slice = slab->slice_stride, last = plan->slices - 1;
    int any = 0;
    for (int c = 0; c < CVOL_PLANES; c++)
        memset(planes[c], 0, dims[0] * dims[1] * sizeof *planes[c]);
    for (size_t j = 0; j < plan->rows; j++) {
        const float *samples = cvol_splat_slab_at(slab, place) + j * stride;
        const cvol_splat_row row = {samples, j > 0 ? samples - stride : samples,
                                    j + 1 < plan->rows ? samples + stride : samples,
                                    place > 0 ? samples - slice : samples,
                                    place < last ? samples + slice : samples};
        CVOL_SIMD_CHOOSE(cvol_splat_list_make)
        (list, &row, 0, (int)plan->lanes, source->table, source->light);
        for (int n = 0; n < list->count; n++)
            for (int c = 0; c < CVOL_PLANES; c++)
                planes[c][(size_t)list->numbers[n] + margin + dims[0] * (j + margin)] =
                    list->from[CVOL_PLANES * list->entries[n] + c];
        any |= list->count > 0;
    }
    return any;
}

/* The working memory of one thread. */
typedef struct baker {
    cvol_context context; /* for one thread, and without progress */
    float *planes[CVOL_PLANES];
    cvol_splat_list list;
    float *scratch;         /* of a tile */
    uint64_t *bins, filled; /* terms by magnitude; slices with content */
    int code;
} baker;

static void free_bakers(baker *bakers, int count)
{
    for (int t = 0; bakers && t < count; t++) {
        for (int c = 0; c < CVOL_PLANES; c++)
            free(bakers[t].planes[c]);
        free(bakers[t].scratch);
        free(bakers[t].bins);
        free(bakers[t].list.numbers);
        free(bakers[t].list.entries);
        free(bakers[t].list.channels);
    }
    free(bakers);
}

static baker *make_bakers(const cvol_context *context, int count, const cvol_splat_plan *plan,
                          size_t places)
{
    baker *bakers = calloc((size_t)count, sizeof *bakers);
    int made = bakers != NULL;
    for (int t = 0; made && t < count; t++) {
        baker *b = &bakers[t];
        b->context = *context;
        b->context.threads = 1;
        b->context.progress = NULL;
        const size_t room = plan->lanes + CVOL_SPLAT_MARGIN;
        b->list.numbers = cvol_allocate_zero(room, sizeof *b->list.numbers);
        b->list.entries = cvol_allocate_zero(room, sizeof *b->list.entries);
        b->list.channels = cvol_allocate(CVOL_SPLAT_CHANNELS * plan->lanes, sizeof(float));
        b->scratch = cvol_allocate(2 * 32 * 32, sizeof *b->scratch);
        b->bins = cvol_allocate_zero(CVOL_TILE_BINS, sizeof *b->bins);
        made = b->list.numbers && b->list.entries && b->list.channels && b->scratch && b->bins;
        for (int c = 0; c < CVOL_PLANES; c++)
            made = made && (b->planes[c] = cvol_allocate(places, sizeof(float)));
    }
    if (made)
        return bakers;
    free_bakers(bakers, count);
    return NULL;
}

/* The common data of a pass over all slices. */
typedef struct bake_job {
    const cvol_bake_source *source;
    const cvol_transform_options *options;
    cvol_baked *out;
    size_t dims[2]; /* of a plane */
    cvol_tile_weights weights;
    const cvol_array *like; /* counting: a plane without terms; else NULL */
    float least;
    baker *bakers;
    int threads;
} bake_job;

static int has_plane(const bake_job *job, int c)
{
    return c < job->out->channels || c == CVOL_PLANE_OPACITY;
}

static void count(baker *b, const bake_job *job)
{
    b->filled++;
    for (int c = 0; c < CVOL_PLANES; c++)
        if (has_plane(job, c))
            cvol_tiles_count(b->bins, b->planes[c], job->like, job->weights.of[c], b->scratch);
}

static void compress(baker *b, const bake_job *job, size_t k)
{
    const size_t *dims = job->dims;
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], 1, CVOL_FLOAT32);
    const size_t *samples = job->out->samples;
    const double share = (double)(samples[0] * samples[1]) / (double)(dims[0] * dims[1]);
    const cvol_keep keep = job->options->rho < 1 ? cvol_keep_rho(job->options->rho * share)
                                                 : cvol_keep_all();
    for (int c = 0; c < CVOL_PLANES && !b->code; c++)
        if (has_plane(job, c) && job->options->tile)
            b->code = cvol_tiles_compress(&b->context, &job->out->planes[k][c], b->planes[c], dims,
                                          job->options->tile, job->weights.of[c], job->least);
        else if (has_plane(job, c))
            b->code = cvol_array_compress(&b->context, &job->out->planes[k][c], b->planes[c], &grid,
                                          2, job->options->transform, 0, &keep);
}

/* One pass over all slices: counts terms, or keeps them. Progress from `from` to `to`. */
static int pass(cvol_context *context, const bake_job *job, double from, double to)
{
    const cvol_bake_source *source = job->source;
    const cvol_splat_plan *plan = source->plan;
    cvol_splat_slab slab = {0};
    int code = cvol_splat_slab_prepare(context, &slab, source->samples, plan);
    for (size_t done = 0; done < plan->slices && !code;) {
        code = cvol_splat_slab_next(context, &slab, source->samples, plan, source->ascending);
        if (code)
            break;
        /* The last slice of a slab waits for its neighbour. */
        const size_t loaded = slab.first + slab.filled;
        const size_t end = loaded < plan->slices ? loaded - 1 : plan->slices;
#pragma omp parallel for schedule(dynamic) num_threads(job->threads)
        for (size_t place = done; place < end; place++) {
            baker *b = &job->bakers[cvol_thread_index()];
            const size_t k = source->ascending ? place : plan->slices - 1 - place;
            if (b->code ||
                !classify(b->planes, &slab, place, source, job->dims, job->out->margin, &b->list))
                continue;
            if (job->like)
                count(b, job);
            else
                compress(b, job, k);
        }
        done = end;
        for (int t = 0; t < job->threads && !code; t++)
            if (job->bakers[t].code)
                code = cvol_fail(context, job->bakers[t].code, "%s",
                                 job->bakers[t].context.message);
        if (!code)
            code = cvol_report_progress(context, "transforming slices",
                                        from + (to - from) * (double)done / (double)plan->slices);
    }
    cvol_splat_slab_free(&slab);
    return code;
}

/* The threshold with which all planes together have rho. */
static int find_threshold(cvol_context *context, bake_job *job)
{
    const cvol_grid grid = cvol_grid_make(job->dims[0], job->dims[1], 1, CVOL_FLOAT32);
    cvol_array *like;
    int code = cvol_array_create_as(context, &like, &grid, 2, CVOL_DCT, job->options->tile);
    if (code)
        return code;
    job->like = like;
    code = pass(context, job, 0, 0.4);
    job->like = NULL;
    cvol_array_free(like);
    uint64_t *bins = job->bakers[0].bins, filled = job->bakers[0].filled;
    for (int t = 1; t < job->threads; t++) {
        filled += job->bakers[t].filled;
        for (int i = 0; i < CVOL_TILE_BINS; i++)
            bins[i] += job->bakers[t].bins[i];
    }
    const double places = (double)(job->dims[0] * job->dims[1]) * (double)filled;
    job->least = cvol_tile_threshold(
        bins, (uint64_t)(job->options->rho * places * (job->out->channels + 1)));
    return code;
}

static int is_grey(const cvol_splat_table *table)
{
    for (int t = 0; t < CVOL_SPLAT_ENTRIES; t++)
        if (table->entries[t][0] < table->entries[t][1] ||
            table->entries[t][0] > table->entries[t][1] ||
            table->entries[t][0] < table->entries[t][2] ||
            table->entries[t][0] > table->entries[t][2])
            return 0;
    return 1;
}

/* ---- all of it ------------------------------------------------------------------------------- */

size_t cvol_baked_planes(const cvol_baked *baked)
{
    size_t planes = 0;
    for (size_t k = 0; k < baked->slices; k++)
        for (int c = 0; c < CVOL_PLANES; c++)
            planes += baked->planes[k][c] != NULL;
    return planes;
}

/* Marks tiles of plane c that have terms. */
static void mark_filled(uint8_t *filled, const cvol_array *plane, int c)
{
    for (size_t t = 0; t < plane->block_count; t++)
        filled[t] |= (uint8_t)((plane->block_table[t].words > 0) << c);
}

int cvol_baked_count(cvol_context *context, cvol_baked *baked)
{
    size_t tiles = 1;
    for (int a = 0; a < 2 && baked->tile; a++)
        tiles *= (baked->samples[a] + (size_t)baked->tile - 1) / (size_t)baked->tile;
    baked->filled = cvol_allocate_zero(baked->slices * tiles, 1);
    if (!baked->filled)
        return cvol_fail_memory(context, baked->slices * tiles, "slices");
    baked->terms = baked->bytes = 0;
    for (size_t k = 0; k < baked->slices; k++)
        for (int c = 0; c < CVOL_PLANES; c++) {
            cvol_array_info info;
            if (!baked->planes[k][c])
                continue;
            cvol_array_get_info(&info, baked->planes[k][c]);
            baked->terms += info.coefficients;
            baked->bytes += info.resident_bytes;
            if (baked->tile)
                mark_filled(baked->filled + k * tiles, baked->planes[k][c], c);
        }
    return CVOL_OK;
}

int cvol_bake(cvol_context *context, cvol_baked *out, const cvol_bake_source *source,
              const cvol_intermediate_grid *image_grid, const cvol_footprint_shape *shape,
              const cvol_transform_options *options)
{
    const cvol_splat_plan *plan = source->plan;
    const int periodic = cvol_transform_is_periodic(options);
    *out = (cvol_baked){.samples = {plan->lanes, plan->rows},
                        .slices = plan->slices,
                        .axis_slice = plan->axis_slice,
                        .transform = options->transform,
                        .tile = options->tile,
                        .margin = periodic ? image_grid->reach : 0,
                        .channels = is_grey(source->table) ? 1 : 3,
                        .distance = plan->distance};
    bake_job job = {.source = source,
                    .options = options,
                    .out = out,
                    .dims = {periodic ? image_grid->dims[0] : plan->lanes,
                             periodic ? image_grid->dims[1] : plan->rows},
                    .threads = cvol_context_threads(context)};
    if (periodic)
        out->image_grid = *image_grid;
    if (options->tile)
        cvol_tile_weights_make(&job.weights, shape, options->tile);
    const size_t places = job.dims[0] * job.dims[1];
    out->planes = cvol_allocate_zero(plan->slices, sizeof *out->planes);
    job.bakers = make_bakers(context, job.threads, plan, places);
    int code = CVOL_OK;
    if (!out->planes || !job.bakers)
        code = cvol_fail_memory(context, CVOL_PLANES * places * sizeof(float), "planes of a slice");
    const int counted = options->tile && options->rho < 1;
    if (!code && counted)
        code = find_threshold(context, &job);
    if (!code)
        code = pass(context, &job, counted ? 0.4 : 0, 1);
    if (!code)
        code = cvol_baked_count(context, out);
    free_bakers(job.bakers, job.threads);
    return code;
}

void cvol_baked_free(cvol_baked *baked)
{
    for (size_t k = 0; baked->planes && k < baked->slices; k++)
        for (int c = 0; c < CVOL_PLANES; c++)
            cvol_array_free(baked->planes[k][c]);
    free(baked->planes);
    free(baked->filled);
    *baked = (cvol_baked){0};
}
