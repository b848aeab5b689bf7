/* The deferred schedule with tiles: bands of the lattice. One thread draws each band through some
 * slices, tile by tile.
 *
 * Tiles without terms are skipped, and, front to back, rows of cells of tiles whose places all have
 * a transmittance below 2^-12. A place's sums do not depend on the bands, so pictures do not depend
 * on the number of threads. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "render/spectral/axis.h"
#include "render/spectral/evaluate.h"
#include "render/spectral/tile.h"

/* Slices whose matrices are made together. */
#define GROUP 16
/* A band's sheet and picture fit into the second-level cache. */
#define BAND_BYTES (5 << 18)
#define BAND_ROWS_MIN 32
/* Cells of the lattice that are closed together, and the number of slices between two checks. */
#define CELL_WIDTH 8
#define CELL_HEIGHT 8
#define CLOSING 2
#define MIN_LIGHT 0x1p-10f

typedef struct tile_slice {
    cvol_tile_axis axes[2];
} tile_slice;

/* The common data of all slices. */
typedef struct tile_view {
    const cvol_compose_job *job;
    int B, per_tile; /* per_tile: places from tile to tile */
    int width;       /* of the rows of matrices along x */
    size_t tiles[2];
    size_t stride; /* of rows of sheet and picture */
    int band_rows, bands, threads;
    float *picture[CVOL_PLANES]; /* 3: 1 - A */
    tile_slice slices[GROUP];
    float *matrices;
    uint8_t *closed; /* of each cell */
    size_t across;   /* cells in a row of them */
} tile_view;

static int has_plane(const tile_view *view, int c)
{
    return c < view->job->baked->channels || c == CVOL_PLANE_OPACITY;
}

/* ---- one band -------------------------------------------------------------------------------- */

/* The working memory of one thread. */
typedef struct tile_sheet {
    float *planes[CVOL_PLANES];
    int (*spans)[2]; /* places of each row that are not empty */
    uint64_t multiply_adds;
} tile_sheet;

static int is_hidden(const tile_view *view, ptrdiff_t x0, ptrdiff_t x1, ptrdiff_t y0, ptrdiff_t y1)
{
    for (ptrdiff_t y = y0 / CELL_HEIGHT; y <= (y1 - 1) / CELL_HEIGHT; y++)
        for (ptrdiff_t x = x0 / CELL_WIDTH; x <= (x1 - 1) / CELL_WIDTH; x++)
            if (!view->closed[(size_t)y * view->across + (size_t)x])
                return 0;
    return 1;
}

static void close_cells(const tile_view *view, ptrdiff_t begin, ptrdiff_t end)
{
    const size_t width = view->job->image_grid->dims[0];
    for (ptrdiff_t y = begin; y < end; y += CELL_HEIGHT)
        for (size_t x = 0; x < view->across; x++) {
            uint8_t *cell = &view->closed[(size_t)(y / CELL_HEIGHT) * view->across + x];
            const size_t right = (x + 1) * CELL_WIDTH < width ? (x + 1) * CELL_WIDTH : width;
            int open = 0;
            for (ptrdiff_t row = y; row < y + CELL_HEIGHT && row < end && !*cell && !open; row++) {
                const float *transmittance = view->picture[CVOL_PLANE_OPACITY] +
                                             (size_t)row * view->stride;
                for (size_t i = x * CELL_WIDTH; i < right; i++)
                    open |= transmittance[i] >= MIN_LIGHT;
            }
            *cell |= (uint8_t)!open;
        }
}

/* The matrix of tile t: the last one may have its own. */
static const float *matrix_of(const tile_view *view, const tile_slice *slice, int a, size_t t)
{
    const int whole = t + 1 < view->tiles[a] || view->job->baked->samples[a] % (size_t)view->B == 0;
    return whole ? slice->axes[a].whole : slice->axes[a].last;
}

/* Multiply-adds of a task, without the padding of vectors. */
static uint64_t count_tile(const cvol_tile_task *task, int places)
{
    const int64_t terms = task->end - task->terms, box = (int64_t)task->rows * task->columns;
    const int64_t across = box <= CVOL_TILE_DENSE * terms ? box : terms;
    return (uint64_t)(places * (across + (int64_t)task->rows * (task->to - task->from)));
}

/* Adds rows from .. to - 1 of a tile to a band that begins at row `begin` of the lattice. filled:
 * the tile's planes. */
static void add_rows(const tile_view *view, tile_sheet *sheet, const tile_slice *slice,
                     cvol_array *const planes[CVOL_PLANES], int filled, size_t tx, size_t ty,
                     ptrdiff_t begin, int from, int to)
{
    const cvol_tile_axis *x = &slice->axes[0], *y = &slice->axes[1];
    const ptrdiff_t left = x->first + (ptrdiff_t)tx * view->per_tile, right = left + x->places;
    const ptrdiff_t top = y->first + (ptrdiff_t)ty * view->per_tile;
    const size_t index = tx + ty * view->tiles[0];
    for (int c = 0; c < CVOL_PLANES; c++) {
        if (!(filled >> c & 1))
            continue;
        const cvol_block *block = &planes[c]->block_table[index];
        const cvol_tile_task task = {.terms = block->terms,
                                     .end = cvol_block_end(block),
                                     .step = (float)planes[c]->step,
                                     .block_log2 = planes[c]->block_log2,
                                     .columns = block->low[0],
                                     .rows = block->low[1],
                                     .across = matrix_of(view, slice, 0, tx),
                                     .down = matrix_of(view, slice, 1, ty),
                                     .width = view->width,
                                     .from = from,
                                     .to = to,
                                     .out = sheet->planes[c] + (size_t)left +
                                            (top - begin) * (ptrdiff_t)view->stride,
                                     .stride = view->stride};
        CVOL_SIMD_CHOOSE(cvol_tile_add)(&task);
        sheet->multiply_adds += count_tile(&task, x->places);
    }
    for (ptrdiff_t row = top + from; row < top + to; row++) {
        int *span = sheet->spans[row - begin];
        span[0] = span[0] < (int)left ? span[0] : (int)left;
        span[1] = span[1] > (int)right ? span[1] : (int)right;
    }
}

/* Adds the part of a tile in rows begin .. end - 1 of the lattice, without the rows of cells where
 * it is hidden: each row of cells on its own, so that bands do not matter. */
static void add_tile(const tile_view *view, tile_sheet *sheet, const tile_slice *slice,
                     cvol_array *const planes[CVOL_PLANES], int filled, size_t tx, size_t ty,
                     ptrdiff_t begin, ptrdiff_t end)
{
    const cvol_tile_axis *x = &slice->axes[0], *y = &slice->axes[1];
    const ptrdiff_t left = x->first + (ptrdiff_t)tx * view->per_tile, right = left + x->places;
    const ptrdiff_t top = y->first + (ptrdiff_t)ty * view->per_tile, bottom = top + y->places;
    const ptrdiff_t limit = (ptrdiff_t)view->job->image_grid->dims[0],
                    last = bottom < end ? bottom : end;
    ptrdiff_t first = top < begin ? begin : top; /* of the rows that are not yet added */
    for (ptrdiff_t row = first, next; row < last; row = next) {
        next = (row / CELL_HEIGHT + 1) * CELL_HEIGHT;
        next = next < last ? next : last;
        const int hides = view->job->front &&
                          is_hidden(view, left, right < limit ? right : limit, row, next);
        const ptrdiff_t seen = hides ? row : next;
        if ((hides || next == last) && first < seen)
            add_rows(view, sheet, slice, planes, filled, tx, ty, begin, (int)(first - top),
                     (int)(seen - top));
        if (hides)
            first = next;
    }
}

static void composite(const tile_view *view, tile_sheet *sheet, ptrdiff_t begin, ptrdiff_t end)
{
    const cvol_compose_job *job = view->job;
    for (ptrdiff_t y = begin; y < end; y++) {
        int *span = sheet->spans[y - begin];
        if (span[0] >= span[1])
            continue;
        const size_t from = (size_t)span[0] / CVOL_TILE_LANES * CVOL_TILE_LANES;
        const size_t at = (size_t)y * view->stride + from;
        const size_t sheet_at = (size_t)(y - begin) * view->stride + from;
        cvol_tile_row row = {.channels = job->baked->channels,
                             .count = span[1] - (int)from,
                             .front = job->front,
                             .cut = job->shape->kind != CVOL_FOOTPRINT_SINC,
                             .transmittance = view->picture[CVOL_PLANE_OPACITY] + at,
                             .sheet_opacity = sheet->planes[CVOL_PLANE_OPACITY] + sheet_at};
        float *planes[CVOL_PLANES] = {NULL};
        planes[CVOL_PLANE_OPACITY] = row.sheet_opacity;
        for (int c = 0; c < row.channels; c++) {
            row.colours[c] = view->picture[c] + at;
            row.sheet[c] = planes[c] = sheet->planes[c] + sheet_at;
        }
        if (job->power != 1)
            cvol_planes_correct_opacity(planes, row.channels, (size_t)row.count, job->power);
        CVOL_SIMD_CHOOSE(cvol_tile_composite)(&row);
        sheet->multiply_adds += (uint64_t)(row.count * (row.channels + 1));
        span[0] = 1 << 30;
        span[1] = 0;
    }
}

/* Draws slices n .. n + count - 1 of a group, in rows begin .. end - 1. */
static void draw_band(const tile_view *view, tile_sheet *sheet, size_t n, size_t count,
                      ptrdiff_t begin, ptrdiff_t end)
{
    const cvol_compose_job *job = view->job;
    for (size_t i = 0; i < count; i++) {
        const size_t k = cvol_compose_slice(job, n + i);
        const tile_slice *slice = &view->slices[i];
        const uint8_t *filled = job->baked->filled + k * view->tiles[0] * view->tiles[1];
        if (!cvol_compose_has(job, k))
            continue;
        for (size_t ty = 0; ty < view->tiles[1]; ty++) {
            const ptrdiff_t top = slice->axes[1].first + (ptrdiff_t)ty * view->per_tile;
            if (top >= end || top + slice->axes[1].places <= begin)
                continue;
            const uint8_t *row = filled + ty * view->tiles[0];
            for (size_t tx = 0; tx < view->tiles[0]; tx++)
                if (row[tx])
                    add_tile(view, sheet, slice, job->baked->planes[k], row[tx], tx, ty, begin,
                             end);
        }
        composite(view, sheet, begin, end);
        if (job->front && (n + i) % CLOSING == CLOSING - 1)
            close_cells(view, begin, end);
    }
}

/* ---- all of it ------------------------------------------------------------------------------- */

static void set_matrices(tile_view *view)
{
    const size_t floats = (size_t)(view->B * view->width);
    float *at = view->matrices;
    for (int i = 0; i < GROUP; i++)
        for (int a = 0; a < 2; a++, at += 2 * floats) {
            view->slices[i].axes[a].whole = at;
            view->slices[i].axes[a].last = at + floats;
        }
}

static void free_sheets(tile_sheet *sheets, int count)
{
    for (int t = 0; sheets && t < count; t++) {
        for (int c = 0; c < CVOL_PLANES; c++)
            free(sheets[t].planes[c]);
        free(sheets[t].spans);
    }
    free(sheets);
}

static tile_sheet *make_sheets(const tile_view *view)
{
    tile_sheet *sheets = calloc((size_t)view->threads, sizeof *sheets);
    const size_t rows = (size_t)view->band_rows;
    int made = sheets != NULL;
    for (int t = 0; made && t < view->threads; t++) {
        sheets[t].spans = cvol_allocate(rows, sizeof *sheets[t].spans);
        made = sheets[t].spans != NULL;
        for (size_t y = 0; made && y < rows; y++) {
            sheets[t].spans[y][0] = 1 << 30;
            sheets[t].spans[y][1] = 0;
        }
        for (int c = 0; c < CVOL_PLANES; c++)
            if (has_plane(view, c))
                made = made && (sheets[t].planes[c] = cvol_allocate_zero(rows * view->stride,
                                                                         sizeof(float)));
    }
    if (made)
        return sheets;
    free_sheets(sheets, view->threads);
    return NULL;
}

static void choose_bands(tile_view *view)
{
    const size_t rows = view->job->image_grid->dims[1];
    const size_t row_bytes = 2 * sizeof(float) * view->stride *
                             (size_t)(view->job->baked->channels + 1);
    size_t band = BAND_BYTES / row_bytes;
    const size_t share = rows / (size_t)(2 * view->threads) + 1;
    band = view->threads > 1 && band > share ? share : band;
    band = band < BAND_ROWS_MIN ? BAND_ROWS_MIN : band;
    band = band > rows ? rows : band;
    view->band_rows = (int)((band + CELL_HEIGHT - 1) / CELL_HEIGHT * CELL_HEIGHT);
    view->bands = (int)((rows + (size_t)view->band_rows - 1) / (size_t)view->band_rows);
}

static int draw(cvol_context *context, tile_view *view, tile_sheet *sheets)
{
    const cvol_compose_job *job = view->job;
    const size_t slices = job->baked->slices;
    const ptrdiff_t rows = (ptrdiff_t)job->image_grid->dims[1];
    int code = CVOL_OK;
    for (size_t n = 0; n < slices && !code; n += GROUP) {
        const size_t left = slices - n, count = left < GROUP ? left : GROUP;
#pragma omp parallel for schedule(static) num_threads(view->threads)
        for (size_t i = 0; i < 2 * count; i++)
            cvol_tile_axis_make(&view->slices[i / 2].axes[i % 2], job, view->width, (int)(i % 2),
                                cvol_compose_slice(job, n + i / 2));
#pragma omp parallel for schedule(dynamic) num_threads(view->threads)
        for (int band = 0; band < view->bands; band++) {
            const ptrdiff_t begin = (ptrdiff_t)band * view->band_rows,
                            end = begin + view->band_rows;
            draw_band(view, &sheets[cvol_thread_index()], n, count, begin, end < rows ? end : rows);
        }
        code = cvol_report_progress(context, "compositing", (double)n / (double)slices);
    }
    return code;
}

/* The light that was ignored, and rounding of single precision. */
static double bound_of(const cvol_compose_job *job)
{
    const double places = (double)(job->image_grid->dims[0] * job->image_grid->dims[1]);
    double errors[CVOL_PLANES] = {0};
    for (size_t n = 0; n < job->baked->slices; n++) {
        const size_t k = cvol_compose_slice(job, n);
        if (!cvol_compose_has(job, k))
            continue;
        cvol_slice_bounds bounds = cvol_slice_bounds_of(job, k);
        /* An intensity clamped to L D~ has the same error or L |D - D~|. */
        for (int c = 0; c < CVOL_PLANE_OPACITY; c++)
            bounds.errors[c] = hypot(bounds.errors[c],
                                     (double)CVOL_BRIGHTEST * bounds.errors[CVOL_PLANE_OPACITY]);
        cvol_compose_visible_errors(errors, &bounds, 1); /* opacities are clamped to 0 .. 1 */
    }
    return cvol_error_norm(errors, job->baked->channels) +
           ((job->front ? sqrt(3) * (double)MIN_LIGHT : 0) + 1e-6 * (double)job->baked->slices) *
               sqrt(places);
}

int cvol_compose_tiles(cvol_context *context, cvol_composed *out, const cvol_compose_job *job)
{
    const cvol_baked *baked = job->baked;
    const size_t *dims = job->image_grid->dims;
    const int taps = (int)ceil(2 * job->shape->ux * cvol_footprint_reach(job->shape));
    const int most = (baked->tile - 1 + taps) / (int)job->image_grid->step + 1;
    tile_view view = {.job = job,
                      .B = baked->tile,
                      .per_tile = baked->tile / (int)job->image_grid->step,
                      .width = (most + CVOL_TILE_LANES - 1) / CVOL_TILE_LANES * CVOL_TILE_LANES,
                      .threads = cvol_context_threads(context),
                      .stride = (dims[0] + CVOL_TILE_PLACES + 15) / 16 * 16,
                      .across = (dims[0] + CELL_WIDTH - 1) / CELL_WIDTH};
    for (int a = 0; a < 2; a++)
        view.tiles[a] = (baked->samples[a] + (size_t)view.B - 1) / (size_t)view.B;
    choose_bands(&view);
    const size_t rows = (size_t)(view.bands * view.band_rows), floats = rows * view.stride;
    const size_t matrices = (size_t)(GROUP * 4 * view.width * view.B) + CVOL_TILE_SPARE;
    float *memory = cvol_allocate_zero((size_t)(baked->channels + 1) * floats, sizeof *memory);
    view.matrices = cvol_allocate_zero(matrices, sizeof(float));
    view.closed = cvol_allocate_zero(view.across * (rows / CELL_HEIGHT), 1);
    tile_sheet *sheets = make_sheets(&view);
    int code = CVOL_OK;
    if (!memory || !view.matrices || !view.closed || !sheets) {
        code = cvol_fail_memory(context, CVOL_PLANES * floats * sizeof *memory, "a picture");
    } else {
        set_matrices(&view);
        for (int c = 0, at = 0; c < CVOL_PLANES; c++)
            if (has_plane(&view, c))
                view.picture[c] = memory + (size_t)at++ * floats;
        for (size_t i = 0; i < floats; i++)
            view.picture[CVOL_PLANE_OPACITY][i] = 1;
        code = draw(context, &view, sheets);
    }
    for (int c = 0; c < CVOL_PLANES && !code; c++)
        for (size_t y = 0; out->planes[c] && y < dims[1]; y++)
            for (size_t x = 0; x < dims[0]; x++) {
                const float value = view.picture[c][y * view.stride + x];
                out->planes[c][y * dims[0] + x] = c == CVOL_PLANE_OPACITY ? 1 - value : value;
            }
    for (int t = 0; t < view.threads && sheets; t++)
        out->multiply_adds += sheets[t].multiply_adds;
    out->bound = bound_of(job);
    free_sheets(sheets, view.threads);
    free(view.closed);
    free(view.matrices);
    free(memory);
    return code;
}
