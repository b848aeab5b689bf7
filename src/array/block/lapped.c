/* Streams post-filtered samples (lapped.h).
 *
 * Blocks are evaluated row by row, layer after layer. Each row goes into a slot that fits into the
 * cache, and is filtered along x there. The row leaves its last two lines in the next row's slot,
 * and its last two slices for the next layer. So a slot contains all samples that the filters
 * across the row's first faces along y and z read. These filters also write two samples on either
 * side, so the finished samples are the row moved by two lines and two slices towards the origin: a
 * piece. Threads take rows in order, and wait only for rows next to theirs. (Tasks of OpenMP with
 * dependences do the same, but libomp crashes in programs whose threads come and go.) Every
 * sample is computed by the same operations for any start of the box and any number of threads. */
#include "array/block/lapped.h"

#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/cell.h"
#include "transform/lap.h"

enum { CELL = CVOL_CELL, REACH = 2, PAD = CVOL_ALIGNMENT / sizeof(float) };

/* ---- boxes ----------------------------------------------------------------------------------- */

/* The face next to sample x; 0: none. */
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

/* ---- slots ----------------------------------------------------------------------------------- */

enum { SIDE = REACH + CELL };

/* States of a row: nothing is done; it is in its slot, and later rows have their part; its piece is
 * passed on, and its slot is free. */
enum { ROW_MISSING, ROW_FILLED, ROW_FINISHED };

typedef struct ring {
    const cvol_stream *stream;
    size_t first[3], count[3]; /* the blocks that are evaluated */
    size_t stride[3];          /* of samples in a slot: SIDE slices of SIDE lines */
    size_t slots, slot;        /* floats from slot to slot */
    size_t tail;               /* floats from one layer's last slices to the next layer's */
    float *samples[2], *tails[2];
    atomic_uchar *states; /* of all rows */
    int threads;
} ring;

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

static void find_cells(ring *r)
{
    const cvol_stream *stream = r->stream;
    size_t begin[3], end[3];
    memcpy(begin, stream->begin, sizeof begin);
    memcpy(end, stream->end, sizeof end);
    if (stream->arrays[0]->lapped || (stream->arrays[1] && stream->arrays[1]->lapped))
        cvol_lapped_widen(begin, end, stream->arrays[0]);
    for (int a = 0; a < 3; a++) {
        r->first[a] = begin[a] / CELL;
        r->count[a] = (end[a] - 1) / CELL + 1 - r->first[a];
    }
    r->slots = 2 * (size_t)r->threads;
    /* Strides that are not powers of two avoid conflicts of cache lines. */
    r->stride[0] = 1;
    r->stride[1] = r->count[0] * CELL + PAD;
    r->stride[2] = r->stride[1] * SIDE + PAD;
    r->slot = r->stride[2] * SIDE;
    r->tail = r->stride[1] * CELL * r->count[1] * REACH;
}

/* Rows are numbered through all layers. */
static float *slot_of(const ring *r, int array, size_t j, size_t layer)
{
    return r->samples[array] + (j + r->count[1] * (layer - r->first[2])) % r->slots * r->slot;
}

/* The first line of row j of slice z of the last two before a layer. */
static float *tail_of(const ring *r, int array, size_t j, size_t z, size_t layer)
{
    return r->tails[array] + layer % 2 * r->tail + CELL * r->stride[1] * (j + r->count[1] * z);
}

static void put_cell(float *to, const float *from, const ring *r)
{
    for (size_t z = 0; z < CELL; z++)
        for (size_t y = 0; y < CELL; y++)
            memcpy(to + y * r->stride[1] + z * r->stride[2], from + CELL * (y + CELL * z),
                   CELL * sizeof *to);
}

/* Copies the row's last lines and slices to where later rows read them. */
static void hand_on(const ring *r, int which, const float *row, size_t j, size_t layer)
{
    const size_t line = r->stride[1], sheet = r->stride[2];
    if (j + 1 < r->count[1]) {
        float *next = slot_of(r, which, j + 1, layer) + REACH * sheet;
        for (size_t z = 0; z < CELL; z++)
            memcpy(next + z * sheet, row + z * sheet + (CELL - REACH) * line,
                   REACH * line * sizeof *row);
    }
    if (layer + 1 < r->first[2] + r->count[2])
        for (size_t z = 0; z < REACH; z++)
            memcpy(tail_of(r, which, j, z, layer + 1), row + (CELL - REACH + z) * sheet,
                   CELL * line * sizeof *row);
}

/* Evaluates row j of a layer and filters it along x. */
static void fill_row(const ring *r, int which, size_t j, size_t layer)
{
    float cell[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    const cvol_array *array = r->stream->arrays[which];
    const size_t size[3] = {2 * REACH, CELL, CELL};
    float *row = slot_of(r, which, j, layer) + REACH * (r->stride[1] + r->stride[2]);
    for (size_t i = 0; i < r->count[0]; i++) {
        const size_t at[3] = {r->first[0] + i, r->first[1] + j, layer};
        float *to = row + CELL * i;
        cvol_block_evaluate(cell, array,
                            at[0] + array->blocks[0] * (at[1] + array->blocks[1] * at[2]));
        put_cell(to, cell, r);
        if (array->lapped && i) {
            const size_t begin[3] = {CELL * at[0] - REACH, CELL * at[1], CELL * at[2]};
            filter_axis(to - REACH, array, begin, size, r->stride, 0);
        }
    }
    hand_on(r, which, row, j, layer);
}

/* Filters, along y and z, the piece that ends two lines and two slices before row j of a layer
 * ends, and passes on its part of the box. */
static void finish_piece(const ring *r, size_t j, size_t layer)
{
    const cvol_stream *stream = r->stream;
    const size_t back_y = j ? REACH : 0, back_z = layer > r->first[2] ? REACH : 0;
    const size_t less_y = j + 1 < r->count[1] ? REACH : 0;
    const size_t less_z = layer + 1 < r->first[2] + r->count[2] ? REACH : 0;
    const size_t row = CELL * (r->first[1] + j);
    const size_t begin[3] = {CELL * r->first[0], row - back_y, CELL * layer - back_z};
    const size_t end[3] = {CELL * (r->first[0] + r->count[0]), row + CELL - less_y,
                           CELL * (layer + 1) - less_z};
    const size_t along_y[3] = {end[0] - begin[0], 2 * REACH, end[2] - begin[2]};
    const size_t along_z[3] = {end[0] - begin[0], end[1] - begin[1], 2 * REACH};
    cvol_piece piece = {.line = r->stride[1],
                        .sheet = r->stride[2],
                        .index = j + r->count[1] * (layer - r->first[2])};
    size_t skip = 0;
    for (int a = 0; a < 3; a++) {
        piece.begin[a] = begin[a] > stream->begin[a] ? begin[a] : stream->begin[a];
        piece.end[a] = least(end[a], stream->end[a]);
        if (piece.begin[a] >= piece.end[a])
            return;
        skip += (piece.begin[a] - begin[a]) * r->stride[a];
    }
    for (int k = 0; k < 2 && stream->arrays[k]; k++) {
        const cvol_array *array = stream->arrays[k];
        float *samples = slot_of(r, k, j, layer) + (REACH - back_y) * r->stride[1] +
                         (REACH - back_z) * r->stride[2];
        for (size_t z = 0; z < back_z; z++)
            memcpy(samples + z * r->stride[2], tail_of(r, k, j, z, layer) - back_y * r->stride[1],
                   (end[1] - begin[1]) * r->stride[1] * sizeof *samples);
        if (array->lapped && back_y)
            filter_axis(samples, array, begin, along_y, r->stride, 1);
        if (array->lapped && back_z)
            filter_axis(samples, array, begin, along_z, r->stride, 2);
        piece.samples[k] = samples + skip;
    }
    stream->take(stream->user, &piece);
}

static void set_state(const ring *r, size_t n, int state)
{
    atomic_store_explicit(&r->states[n], (unsigned char)state, memory_order_release);
}

static void wait_for(const ring *r, size_t n, int state)
{
    while (atomic_load_explicit(&r->states[n], memory_order_acquire) < state)
        sched_yield();
}

/* Row n of all layers. It waits only for rows before it, which other threads have begun. */
static void do_row(const ring *r, size_t n)
{
    const size_t rows = r->count[1], j = n % rows, layer = r->first[2] + n / rows;
    /* What it writes must be free: its slot, the first lines of the next one, and its part of the
     * last slices, which two rows of the layer before read. */
    if (n >= r->slots)
        wait_for(r, n - r->slots, ROW_FINISHED);
    if (n + 1 >= r->slots)
        wait_for(r, n + 1 - r->slots, ROW_FINISHED);
    if (n >= rows)
        wait_for(r, n - rows, ROW_FINISHED);
    if (n >= rows && j + 1 < rows)
        wait_for(r, n - rows + 1, ROW_FINISHED);
    for (int k = 0; k < 2 && r->stream->arrays[k]; k++)
        fill_row(r, k, j, layer);
    set_state(r, n, ROW_FILLED);
    /* What it reads must be there; that of the row below it is. */
    if (j)
        wait_for(r, n - 1, ROW_FILLED);
    if (j && n >= rows)
        wait_for(r, n - rows - 1, ROW_FILLED);
    finish_piece(r, j, layer);
    set_state(r, n, ROW_FINISHED);
}

static void do_layers(const ring *r, size_t begin, size_t end)
{
    const size_t rows = r->count[1], last = rows * (end - r->first[2]);
    atomic_size_t next = rows * (begin - r->first[2]);
#pragma omp parallel num_threads(r->threads)
    for (size_t n = atomic_fetch_add(&next, 1); n < last; n = atomic_fetch_add(&next, 1))
        do_row(r, n);
}

/* ---- public ---------------------------------------------------------------------------------- */

cvol_stream cvol_stream_of(const cvol_array *a, const cvol_array *b)
{
    const size_t *dims = a->grid.dims;
    return (cvol_stream){.arrays = {a, b}, .end = {dims[0], dims[1], dims[2]}};
}

size_t cvol_stream_pieces(const cvol_stream *stream)
{
    ring r = {.stream = stream};
    find_cells(&r);
    return r.count[1] * r.count[2];
}

static int make_slots(cvol_context *context, ring *r)
{
    size_t floats;
    r->threads = cvol_context_threads(context);
    find_cells(r);
    int fits = cvol_size_multiply(&floats, r->slot, r->slots) &&
               cvol_size_add(&floats, floats, 2 * r->tail);
    r->states = cvol_allocate_zero(r->count[1] * r->count[2], sizeof *r->states);
    for (int k = 0; k < 2 && r->stream->arrays[k]; k++) {
        r->samples[k] = fits ? cvol_allocate(floats, sizeof **r->samples) : NULL;
        fits = fits && r->samples[k];
        r->tails[k] = fits ? r->samples[k] + r->slots * r->slot : NULL;
    }
    return fits && r->states
               ? CVOL_OK
               : cvol_fail_memory(context, floats * sizeof **r->samples, "rows of cells");
}

int cvol_stream_run(cvol_context *context, const cvol_stream *stream)
{
    enum { AT_ONCE = 1 << 25 }; /* samples between reports of progress */
    ring r = {.stream = stream};
    int code = make_slots(context, &r);
    const size_t step = AT_ONCE / (r.slot * r.count[1]) + 1;
    for (size_t done = 0; done < r.count[2] && !code; done += step) {
        const size_t from = r.first[2] + done;
        if (stream->what)
            code = cvol_report_progress(context, stream->what, (double)done / (double)r.count[2]);
        if (!code)
            do_layers(&r, from, from + least(step, r.count[2] - done));
    }
    free(r.samples[0]);
    free(r.samples[1]);
    free((void *)r.states);
    return code || !stream->what ? code : cvol_report_progress(context, stream->what, 1);
}
