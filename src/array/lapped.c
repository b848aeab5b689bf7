/* The stream of post-filtered samples (lapped.h).
 *
 * A slab holds some layers of cells and, before them, the last two sheets of the layer before. It
 * is filled row of cells by row, filtered along x while a row's cells are in the cache, then along
 * y sheet by sheet, then along z, row by row; and as a face's filter reads two sheets on either
 * side, what is finished then lies two sheets further up: those are handed out, and the last two
 * sheets are kept. Every sample is computed by the same operations wherever the box begins, and by
 * whichever thread.
 */
#include "array/lapped.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/cell.h"
#include "transform/lap.h"

enum { CELL = CVOL_CELL, REACH = 2, PAD = CVOL_ALIGNMENT / sizeof(float), ROWS_AT_ONCE = 32 };

/* ---- boxes ------------------------------------------------------------------------------------
 */

/* The face that sample x stands beside; 0: none. */
static size_t face_of(size_t x, size_t length)
{
    const size_t face = (x + REACH) / CELL * CELL;
    return face && x < face + REACH && face + REACH <= length ? face : 0;
}

void cvol_lapped_widen(size_t begin[3], size_t end[3], const cvol_array *array)
{
    for (int a = 0; a < 3; a++) {
        const size_t first = face_of(begin[a], array->grid.dims[a]);
        const size_t last = face_of(end[a] - 1, array->grid.dims[a]);
        begin[a] = first ? first - REACH : begin[a];
        end[a] = last ? last + REACH : end[a];
    }
}

static void filter_axis(float *samples, const cvol_array *array, const size_t begin[3],
                        const size_t size[3], const size_t stride[3], int axis)
{
    cvol_lap_box box = {.grid = CELL};
    for (int a = 0; a < 3; a++) {
        box.shape[a] = (int64_t)array->grid.dims[a];
        box.begin[a] = (int64_t)begin[a];
        box.size[a] = (int64_t)size[a];
        box.stride[a] = (int64_t)stride[a];
    }
    cvol_lap_post(samples, &box, axis);
}

void cvol_lapped_filter(float *samples, const cvol_array *array, const size_t begin[3],
                        const size_t size[3], const size_t stride[3])
{
    for (int axis = 0; axis < 3; axis++)
        filter_axis(samples, array, begin, size, stride, axis);
}

/* ---- the slab ----------------------------------------------------------------------------------
 */

typedef struct slab {
    const cvol_stream *stream;
    size_t first[3], count[3]; /* the cells that are evaluated */
    size_t stride[3];
    size_t layers; /* held at once */
    float *samples[2];
} slab;

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

static void find_cells(slab *s)
{
    const cvol_stream *stream = s->stream;
    size_t begin[3], end[3];
    memcpy(begin, stream->begin, sizeof begin);
    memcpy(end, stream->end, sizeof end);
    if (stream->arrays[0]->lapped || (stream->arrays[1] && stream->arrays[1]->lapped))
        cvol_lapped_widen(begin, end, stream->arrays[0]);
    for (int a = 0; a < 3; a++) {
        s->first[a] = begin[a] / CELL;
        s->count[a] = (end[a] - 1) / CELL + 1 - s->first[a];
    }
    /* Work for many threads also where a layer has few rows. */
    s->layers = s->count[1] < ROWS_AT_ONCE ? ROWS_AT_ONCE / s->count[1] : 1;
    s->layers = least(s->layers, s->count[2]);
    /* Lines and sheets that are no powers of two apart do not compete for the same cache lines. */
    s->stride[0] = 1;
    s->stride[1] = s->count[0] * CELL + PAD;
    s->stride[2] = s->stride[1] * s->count[1] * CELL + PAD;
}

/* Where the cell of row j in held layer l begins. */
static float *cell_at(const slab *s, int array, size_t i, size_t j, size_t l)
{
    return s->samples[array] + CELL * i + CELL * j * s->stride[1] +
           (REACH + CELL * l) * s->stride[2];
}

static void put_cell(float *to, const float *from, const slab *s)
{
    for (size_t z = 0; z < CELL; z++)
        for (size_t y = 0; y < CELL; y++)
            memcpy(to + y * s->stride[1] + z * s->stride[2], from + CELL * (y + CELL * z),
                   CELL * sizeof *to);
}

/* Evaluates a row of cells and filters it along x. */
static void fill_row(const slab *s, int which, size_t j, size_t layer, size_t held)
{
    float cell[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    const cvol_array *array = s->stream->arrays[which];
    const size_t size[3] = {2 * REACH, CELL, CELL};
    for (size_t i = 0; i < s->count[0]; i++) {
        const size_t at[3] = {s->first[0] + i, s->first[1] + j, layer};
        float *to = cell_at(s, which, i, j, held);
        cvol_block_evaluate(cell, array,
                            at[0] + array->blocks[0] * (at[1] + array->blocks[1] * at[2]));
        put_cell(to, cell, s);
        if (array->lapped && i) {
            const size_t begin[3] = {CELL * at[0] - REACH, CELL * at[1], CELL * at[2]};
            filter_axis(to - REACH, array, begin, size, s->stride, 0);
        }
    }
}

/* Filters sheet z of the held layers, which begin with cell layer `layer`, along y. */
static void filter_sheet(const slab *s, int which, size_t layer, size_t z)
{
    const size_t begin[3] = {CELL * s->first[0], CELL * s->first[1], CELL * layer + z};
    const size_t size[3] = {CELL * s->count[0], CELL * s->count[1], 1};
    if (s->stream->arrays[which]->lapped)
        filter_axis(cell_at(s, which, 0, 0, 0) + z * s->stride[2], s->stream->arrays[which], begin,
                    size, s->stride, 1);
}

/* Filters row j along z, across the face before a held layer, and hands it out from two sheets
 * before that face on. */
static void finish_row(const slab *s, size_t j, size_t layer, size_t held)
{
    const cvol_stream *stream = s->stream;
    const int is_first = layer == s->first[2];
    const int is_last = layer + 1 == s->first[2] + s->count[2];
    const size_t begin[3] = {CELL * s->first[0], CELL * (s->first[1] + j),
                             CELL * layer - (is_first ? 0 : REACH)};
    const size_t end[3] = {CELL * (s->first[0] + s->count[0]), begin[1] + CELL,
                           CELL * (layer + 1) - (is_last ? 0 : REACH)};
    const size_t size[3] = {CELL * s->count[0], CELL, 2 * REACH};
    cvol_piece piece = {.line = s->stride[1],
                        .sheet = s->stride[2],
                        .index = j + s->count[1] * (layer - s->first[2])};
    size_t skip = 0;
    int empty = 0;
    for (int a = 0; a < 3; a++) {
        piece.begin[a] = begin[a] > stream->begin[a] ? begin[a] : stream->begin[a];
        piece.end[a] = least(end[a], stream->end[a]);
        empty = empty || piece.begin[a] >= piece.end[a];
        skip += (piece.begin[a] - begin[a]) * s->stride[a];
    }
    if (empty)
        return;
    for (int k = 0; k < 2 && stream->arrays[k]; k++) {
        float *samples = cell_at(s, k, 0, j, held) - (is_first ? 0 : REACH * s->stride[2]);
        if (stream->arrays[k]->lapped && !is_first)
            filter_axis(samples, stream->arrays[k], begin, size, s->stride, 2);
        piece.samples[k] = samples + skip;
    }
    stream->take(stream->user, &piece);
}

/* Evaluates `held` layers from `layer` on and hands out what is finished. */
static void do_layers(cvol_context *context, const slab *s, size_t layer, size_t held)
{
    const size_t rows = s->count[1], arrays = s->stream->arrays[1] ? 2 : 1;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < arrays * held * rows; i++)
            fill_row(s, (int)(i % arrays), i / arrays % rows, layer + i / arrays / rows,
                     i / arrays / rows);
#pragma omp for schedule(static)
        for (size_t i = 0; i < arrays * held * CELL; i++)
            filter_sheet(s, (int)(i % arrays), layer, i / arrays);
#pragma omp for schedule(static)
        for (size_t i = 0; i < held * rows; i++)
            finish_row(s, i % rows, layer + i / rows, i / rows);
        const size_t last = CELL * held * s->stride[2];
#pragma omp for schedule(static)
        for (size_t i = 0; i < arrays * rows * REACH; i++) {
            const size_t at = i / arrays % rows * CELL * s->stride[1] +
                              i / arrays / rows * s->stride[2];
            float *samples = s->samples[i % arrays] + at;
            memcpy(samples, samples + last, CELL * s->stride[1] * sizeof *samples);
        }
    }
}

/* ---- public ------------------------------------------------------------------------------------
 */

cvol_stream cvol_stream_of(const cvol_array *a, const cvol_array *b)
{
    const size_t *dims = a->grid.dims;
    return (cvol_stream){.arrays = {a, b}, .end = {dims[0], dims[1], dims[2]}};
}

size_t cvol_stream_pieces(const cvol_stream *stream)
{
    slab s = {.stream = stream};
    find_cells(&s);
    return s.count[1] * s.count[2];
}

int cvol_stream_run(cvol_context *context, const cvol_stream *stream)
{
    slab s = {.stream = stream};
    find_cells(&s);
    size_t floats;
    int code = CVOL_OK;
    if (!cvol_size_multiply(&floats, s.stride[2], REACH + CELL * s.layers))
        return cvol_fail_memory(context, SIZE_MAX, "layers of cells");
    for (int k = 0; k < 2 && stream->arrays[k] && !code; k++) {
        s.samples[k] = cvol_allocate(floats, sizeof **s.samples);
        if (!s.samples[k])
            code = cvol_fail_memory(context, floats * sizeof **s.samples, "layers of cells");
    }
    for (size_t done = 0; done < s.count[2] && !code; done += s.layers) {
        code = cvol_report_progress(context, stream->what, (double)done / (double)s.count[2]);
        if (!code)
            do_layers(context, &s, s.first[2] + done, least(s.layers, s.count[2] - done));
    }
    free(s.samples[0]);
    free(s.samples[1]);
    return code ? code : cvol_report_progress(context, stream->what, 1);
}
