/* The slices of a volume in a Zarr array.
 *
 * A layer holds the slices of one row of chunks along z. Slabs of whole layers are decoded in
 * place; for a part of a layer, the whole layer is decoded and kept, as the next slab needs the
 * rest. The chunks of a layer are decoded in parallel. */
#include "volume/formats/zarr/layer.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "volume/formats/zarr/chunk.h"
#include "volume/io/strided.h"

/* Memory for the unpacked chunks of all threads. */
#define CHUNKS_BYTES ((size_t)1 << 30)

/* A thread's chunk, and its failure. */
typedef struct worker {
    cvol_context context;
    uint8_t *chunk;
    int code;
} worker;

/* One row of chunks along z. */
typedef struct layer {
    const cvol_zarr_layers *of;
    uint8_t *out;
    size_t first, slices; /* along z */
    size_t columns, rows; /* of chunks, along x and y */
    size_t stride[3];     /* between neighbours in a chunk, in bytes */
    size_t start;         /* of the chosen volume in a chunk, in bytes */
    uint64_t place[CVOL_ZARR_AXES];
} layer;

static size_t side(const cvol_zarr_layers *l, int a)
{
    return l->of[a] >= 0 ? (size_t)l->array.chunk[l->of[a]] : 1;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* ---- samples ------------------------------------------------------------------------- */

static void fill(uint8_t *out, size_t count, const cvol_zarr_array *array)
{
    const size_t sample = cvol_type_size(array->type);
    for (size_t i = 0; i < count; i++)
        memcpy(out + i * sample, array->fill, sample);
}

/* Copies the part of a chunk within the volume; chunk NULL: all samples are missing. */
static void place_chunk(const layer *y, const uint8_t *chunk, size_t column, size_t row)
{
    const cvol_zarr_layers *l = y->of;
    const size_t sample = cvol_type_size(l->array.type);
    const size_t x0 = column * side(l, 0), y0 = row * side(l, 1);
    const size_t width = least(side(l, 0), l->dims[0] - x0);
    const size_t height = least(side(l, 1), l->dims[1] - y0);
    for (size_t j = 0; j < y->slices; j++)
        for (size_t i = 0; i < height; i++) {
            uint8_t *to = y->out + ((j * l->dims[1] + y0 + i) * l->dims[0] + x0) * sample;
            if (chunk)
                cvol_strided_gather(to, chunk + y->start + j * y->stride[2] + i * y->stride[1],
                                    width, y->stride[0], l->array.element, l->array.is_half);
            else
                fill(to, width, &l->array);
        }
}

static int read_chunk(const layer *y, worker *w, size_t number)
{
    const cvol_zarr_layers *l = y->of;
    const size_t column = number % y->columns, row = number / y->columns;
    uint64_t place[CVOL_ZARR_AXES];
    int is_missing;
    memcpy(place, y->place, sizeof place);
    if (l->of[0] >= 0)
        place[l->of[0]] = column;
    if (l->of[1] >= 0)
        place[l->of[1]] = row;
    int code = cvol_zarr_chunk_read(&w->context, w->chunk, &is_missing, &l->array, place);
    if (!code)
        place_chunk(y, is_missing ? NULL : w->chunk, column, row);
    return code;
}

/* ---- layers -------------------------------------------------------------------------- */

static int make_workers(cvol_context *context, worker **out, int *count,
                        const cvol_zarr_array *array)
{
    const size_t most = CHUNKS_BYTES / array->chunk_bytes;
    const int threads = (int)least((size_t)cvol_context_threads(context), most ? most : 1);
    worker *w = calloc((size_t)threads, sizeof *w);
    int code = w ? CVOL_OK : cvol_fail_memory(context, (size_t)threads * sizeof *w, array->path);
    *count = 0;
    for (int i = 0; i < threads && !code; i++) {
        w[i].context = *context;
        w[i].context.progress = NULL;
        w[i].context.threads = 1;
        if ((w[i].chunk = cvol_allocate(array->chunk_bytes, 1)))
            ++*count;
        else if (i == 0)
            code = cvol_fail_memory(context, array->chunk_bytes, array->path);
        else
            break; /* fewer threads */
    }
    *out = w;
    return code;
}

static void free_workers(worker *workers, int count)
{
    for (int i = 0; i < count; i++)
        free(workers[i].chunk);
    free(workers);
}

static layer make_layer(const cvol_zarr_layers *l, uint8_t *out, size_t number)
{
    const cvol_zarr_array *array = &l->array;
    layer y = {.of = l, .out = out, .first = number * side(l, 2)};
    y.slices = least(side(l, 2), l->dims[2] - y.first);
    y.columns = (l->dims[0] - 1) / side(l, 0) + 1;
    y.rows = (l->dims[1] - 1) / side(l, 1) + 1;
    size_t step = array->element;
    for (int k = array->rank - 1; k >= 0; k--) {
        const int axis = array->order[k];
        int spatial = 0;
        for (int a = 0; a < 3; a++)
            if (l->of[a] == axis) {
                y.stride[a] = step;
                spatial = 1;
            }
        if (!spatial) {
            y.place[axis] = l->begin[axis] / array->chunk[axis];
            y.start += (size_t)(l->begin[axis] % array->chunk[axis]) * step;
        }
        step *= (size_t)array->chunk[axis];
    }
    if (l->of[2] >= 0)
        y.place[l->of[2]] = number;
    return y;
}

static int decode_layer(cvol_context *context, const cvol_zarr_layers *l, uint8_t *out,
                        size_t number)
{
    const layer y = make_layer(l, out, number);
    worker *workers;
    int count, has_failed = 0;
    int code = make_workers(context, &workers, &count, &l->array);
    if (!code) {
#pragma omp parallel for schedule(dynamic) num_threads(count)
        for (size_t i = 0; i < y.columns * y.rows; i++) {
            worker *w = &workers[cvol_thread_index()];
            int stop;
#pragma omp atomic read
            stop = has_failed;
            if (stop)
                continue;
            w->code = read_chunk(&y, w, i);
            if (w->code) {
#pragma omp atomic write
                has_failed = 1;
            }
        }
    }
    for (int i = 0; i < count && !code; i++)
        if (workers[i].code)
            code = cvol_fail(context, workers[i].code, "%s", workers[i].context.message);
    free_workers(workers, count);
    return code;
}

/* Makes `number` the kept layer. */
static int keep_layer(cvol_context *context, cvol_zarr_layers *l, size_t number)
{
    if (l->kept && l->kept_number == number)
        return CVOL_OK;
    size_t bytes = cvol_type_size(l->array.type);
    const size_t slices = least(side(l, 2), l->dims[2]);
    if (!cvol_size_multiply(&bytes, bytes, l->dims[0]) ||
        !cvol_size_multiply(&bytes, bytes, l->dims[1]) ||
        !cvol_size_multiply(&bytes, bytes, slices) || bytes > context->limit_bytes)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "%s: a layer of chunks has %zu slices, more than the limit of %llu bytes",
                         l->array.path, slices, (unsigned long long)context->limit_bytes);
    if (!l->kept && !(l->kept = cvol_allocate(bytes, 1)))
        return cvol_fail_memory(context, bytes, l->array.path);
    l->kept_number = SIZE_MAX; /* until it is complete */
    int code = decode_layer(context, l, l->kept, number);
    if (!code)
        l->kept_number = number;
    return code;
}

int cvol_zarr_layers_read(cvol_context *context, cvol_zarr_layers *l, void *out, size_t first,
                          size_t count)
{
    const size_t slice = l->dims[0] * l->dims[1] * cvol_type_size(l->array.type);
    const size_t depth = side(l, 2), last = first + count;
    uint8_t *to = out;
    int code = CVOL_OK;
    for (size_t z = first, next; z < last && !code; z = next) {
        const size_t number = z / depth, begin = number * depth;
        const size_t end = least(depth, l->dims[2] - begin) + begin;
        next = least(end, last);
        if (z == begin && next == end)
            code = decode_layer(context, l, to, number);
        else if (!(code = keep_layer(context, l, number)))
            memcpy(to, l->kept + (z - begin) * slice, (next - z) * slice);
        to += (next - z) * slice;
    }
    return code;
}

void cvol_zarr_layers_close(cvol_zarr_layers *layers)
{
    free(layers->array.path);
    free(layers->array.checked);
    free(layers->kept);
    *layers = (cvol_zarr_layers){0};
}
