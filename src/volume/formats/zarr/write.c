/* Writing images of OME-Zarr: levels of Zarr format 2 (0.4) or 3 (0.5), in chunks of 64 samples
 * along each axis, compressed by zstd. Chunks of zeros are not written. A level keeps one layer of
 * chunks in memory. */
#define _GNU_SOURCE
#include "volume/formats/zarr/write.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include "base/byte_order.h"
#include "base/c_locale.h"
#include "base/context.h"
#include "base/doubles.h"
#include "base/memory.h"
#include "base/thread.h"
#include "volume/formats/zarr/describe.h"
#include "volume/formats/zarr/folder.h"
#include "volume/formats/zarr/pyramid.h"

enum { CHUNK_SIDE = 64, LEAST_DEPTH = 8, ZSTD_LEVEL = 3 };
/* Above it, chunks are less deep. */
#define LAYER_BYTES_MAX ((size_t)256 << 20)

/* The slices of a level that wait for a full layer of chunks. */
typedef struct waiting {
    size_t dims[3], chunk[3], slice; /* bytes of a slice */
    uint8_t *layer;
    size_t filled, first; /* slices in it, and the volume's slice that is its first */
} waiting;

/* A thread's buffers and failure. */
typedef struct worker {
    cvol_context context;
    uint8_t *chunk, *packed;
    int code;
} worker;

typedef struct image {
    char *path;
    cvol_zarr_folder folder;
    cvol_zarr_written written;
    cvol_series_options series;
    cvol_zarr_pyramid pyramid;
    waiting level[CVOL_ZARR_LEVELS];
    worker *workers;
    int threads;
    size_t part; /* bytes of level 0's next slice */
    int volume;  /* the next one */
    double *least, *most;
} image;

/* ---- chunks ---------------------------------------------------------------------------- */

static size_t least_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Copies a chunk out of the layer; samples beyond the volume are 0. */
static void cut_chunk(uint8_t *out, const waiting *l, size_t sample, size_t column, size_t row)
{
    const size_t x = column * l->chunk[0], y = row * l->chunk[1];
    const size_t width = least_of(l->chunk[0], l->dims[0] - x) * sample;
    const size_t height = least_of(l->chunk[1], l->dims[1] - y), line = l->chunk[0] * sample;
    memset(out, 0, line * l->chunk[1] * l->chunk[2]);
    for (size_t j = 0; j < l->filled; j++)
        for (size_t i = 0; i < height; i++)
            memcpy(out + (j * l->chunk[1] + i) * line,
                   l->layer + j * l->slice + ((y + i) * l->dims[0] + x) * sample, width);
}

static int is_zero(const uint8_t *data, size_t size)
{
    return !data[0] && !memcmp(data, data + 1, size - 1);
}

static int write_chunk(const image *m, worker *w, int level, size_t number)
{
    const waiting *l = &m->level[level];
    const cvol_zarr_written *of = &m->written;
    const size_t sample = cvol_type_size(of->grid.type);
    const size_t columns = (l->dims[0] - 1) / l->chunk[0] + 1;
    const size_t bytes = l->chunk[0] * l->chunk[1] * l->chunk[2] * sample;
    char name[160];
    cut_chunk(w->chunk, l, sample, number % columns, number / columns);
    if (is_zero(w->chunk, bytes))
        return CVOL_OK;
    if (cvol_machine_is_big_endian() && sample > 1)
        cvol_swap_bytes(w->chunk, bytes / sample, sample);
    const size_t size = ZSTD_compress(w->packed, ZSTD_compressBound(bytes), w->chunk, bytes,
                                      ZSTD_LEVEL);
    if (ZSTD_isError(size))
        return cvol_fail_memory(&w->context, bytes, m->path);
    int length = snprintf(name, sizeof name, of->format == 3 ? "%d/c/" : "%d/", level);
    if (of->has_times)
        length += snprintf(name + length, sizeof name - (size_t)length, "%d/",
                           m->volume / of->channels);
    if (of->has_channels)
        length += snprintf(name + length, sizeof name - (size_t)length, "%d/",
                           m->volume % of->channels);
    snprintf(name + length, sizeof name - (size_t)length, "%zu/%zu/%zu", l->first / l->chunk[2],
             number / columns, number % columns);
    return cvol_zarr_folder_write(&w->context, &m->folder, name, w->packed, size);
}

static int write_layer(cvol_context *context, image *m, int level)
{
    waiting *l = &m->level[level];
    const size_t chunks = ((l->dims[0] - 1) / l->chunk[0] + 1) *
                          ((l->dims[1] - 1) / l->chunk[1] + 1);
    for (int i = 0; i < m->threads; i++)
        m->workers[i].code = CVOL_OK;
#pragma omp parallel for schedule(dynamic) num_threads(m->threads)
    for (size_t i = 0; i < chunks; i++) {
        worker *w = &m->workers[cvol_thread_index()];
        if (!w->code)
            w->code = write_chunk(m, w, level, i);
    }
    for (int i = 0; i < m->threads; i++)
        if (m->workers[i].code)
            return cvol_fail(context, m->workers[i].code, "%s", m->workers[i].context.message);
    l->first += l->filled;
    l->filled = 0;
    if (l->first == l->dims[2])
        l->first = 0; /* of the next volume */
    return CVOL_OK;
}

/* ---- slices ---------------------------------------------------------------------------- */

static void find_range(image *m, const uint8_t *slice)
{
    enum { STEP = 512 };
    double values[STEP];
    const cvol_grid *grid = &m->written.grid;
    const size_t count = grid->dims[0] * grid->dims[1];
    double *least = &m->least[m->volume % m->written.channels];
    double *most = &m->most[m->volume % m->written.channels];
    for (size_t at = 0; at < count; at += STEP) {
        const size_t n = least_of(STEP, count - at);
        cvol_doubles_load(values, grid->type, slice, at, n);
        for (size_t i = 0; i < n; i++)
            if (cvol_zarr_has_value(&m->pyramid.missing, values[i])) {
                *least = values[i] < *least ? values[i] : *least;
                *most = values[i] > *most ? values[i] : *most;
            }
    }
}

/* Counts a slice that is in the layer, and writes the layer if it is full. */
static int count_slice(cvol_context *context, image *m, int level)
{
    waiting *l = &m->level[level];
    l->filled++;
    return l->filled == l->chunk[2] || l->first + l->filled == l->dims[2]
               ? write_layer(context, m, level)
               : CVOL_OK;
}

static int put_coarse(cvol_context *context, void *user, int level, const void *slice)
{
    image *m = user;
    waiting *l = &m->level[level];
    memcpy(l->layer + l->filled * l->slice, slice, l->slice);
    return count_slice(context, m, level);
}

static int write_bytes(cvol_context *context, void *state, const void *data, size_t size)
{
    image *m = state;
    waiting *l = &m->level[0];
    const uint8_t *at = data;
    const cvol_zarr_level_sink sink = {.put = put_coarse, .user = m};
    int code = CVOL_OK;
    while (size && !code) {
        uint8_t *slice = l->layer + l->filled * l->slice;
        const size_t step = least_of(size, l->slice - m->part);
        memcpy(slice + m->part, at, step);
        at += step;
        size -= step;
        m->part += step;
        if (m->part < l->slice)
            break;
        m->part = 0;
        if (m->written.has_channels)
            find_range(m, slice);
        const int is_last = l->first + l->filled + 1 == l->dims[2];
        code = cvol_zarr_pyramid_add(context, &m->pyramid, slice, &sink);
        if (!code)
            code = count_slice(context, m, 0);
        m->volume += is_last;
    }
    return code;
}

static int add_missing(cvol_context *context, void *state, double value)
{
    image *m = state;
    return cvol_zarr_missing_add(context, &m->pyramid.missing, value);
}

/* ---- the image ------------------------------------------------------------------------- */

static void close_image(void *state)
{
    image *m = state;
    if (!m)
        return;
    cvol_zarr_folder_abandon(&m->folder);
    cvol_zarr_pyramid_close(&m->pyramid);
    for (int k = 0; k < CVOL_ZARR_LEVELS; k++)
        free(m->level[k].layer);
    for (int i = 0; m->workers && i < m->threads; i++) {
        free(m->workers[i].chunk);
        free(m->workers[i].packed);
    }
    free(m->workers);
    cvol_bytes_free(&m->written.label_list);
    free(m->least);
    free(m->most);
    free(m->path);
    free(m);
}

static int put_text(cvol_context *context, const image *m, const char *name, cvol_bytes *text)
{
    int code = text->failed
                   ? cvol_fail_memory(context, text->size, m->path)
                   : cvol_zarr_folder_write(context, &m->folder, name, text->data, text->size);
    cvol_bytes_free(text);
    return code;
}

static int put_metadata(cvol_context *context, const image *m)
{
    static const char mark[] = "{\n  \"zarr_format\": 2\n}\n";
    const int is_3 = m->written.format == 3;
    cvol_bytes text = {0};
    cvol_zarr_describe_group(&text, &m->written);
    int code = put_text(context, m, is_3 ? "zarr.json" : ".zattrs", &text);
    for (int k = 0; k < m->written.levels && !code; k++) {
        char name[32];
        text = (cvol_bytes){0};
        snprintf(name, sizeof name, is_3 ? "%d/zarr.json" : "%d/.zarray", k);
        cvol_zarr_describe_array(&text, &m->written, m->level[k].dims, m->level[k].chunk);
        code = put_text(context, m, name, &text);
    }
    if (!code && !is_3)
        code = cvol_zarr_folder_write(context, &m->folder, ".zgroup", mark, sizeof mark - 1);
    return code;
}

/* Numbers in JSON have decimal points in every locale. */
static int commit_image(cvol_context *context, void *state)
{
    image *m = state;
    cvol_c_locale locale;
    int code = cvol_c_locale_enter(context, &locale);
    if (code)
        return code;
    code = put_metadata(context, m);
    cvol_c_locale_leave(&locale);
    return code ? code : cvol_zarr_folder_commit(context, &m->folder);
}

static int make_levels(cvol_context *context, image *m)
{
    const size_t sample = cvol_type_size(m->written.grid.type);
    for (int k = 0; k < m->pyramid.levels; k++) {
        waiting *l = &m->level[k];
        size_t layer;
        memcpy(l->dims, m->pyramid.dims[k], sizeof l->dims);
        for (int a = 0; a < 3; a++)
            l->chunk[a] = least_of(CHUNK_SIDE, l->dims[a]);
        l->slice = l->dims[0] * l->dims[1] * sample;
        while (l->chunk[2] > LEAST_DEPTH && l->slice > LAYER_BYTES_MAX / l->chunk[2])
            l->chunk[2] /= 2;
        if (!cvol_size_multiply(&layer, l->slice, l->chunk[2]) ||
            !(l->layer = cvol_allocate(layer, 1)))
            return cvol_fail_memory(context, l->slice, m->path);
    }
    return CVOL_OK;
}

static int make_workers(cvol_context *context, image *m)
{
    const size_t bytes = (size_t)CHUNK_SIDE * CHUNK_SIDE * CHUNK_SIDE *
                         cvol_type_size(m->written.grid.type);
    m->threads = cvol_context_threads(context);
    m->workers = calloc((size_t)m->threads, sizeof *m->workers);
    int enough = m->workers != NULL;
    for (int i = 0; i < m->threads && enough; i++) {
        worker *w = &m->workers[i];
        w->context = *context;
        w->context.progress = NULL;
        w->chunk = cvol_allocate(bytes, 1);
        w->packed = cvol_allocate(ZSTD_compressBound(bytes), 1);
        enough = w->chunk && w->packed;
    }
    return enough ? CVOL_OK : cvol_fail_memory(context, bytes, m->path);
}

/* 1 if a channel has a name. */
static int has_names(const cvol_series_options *series)
{
    for (int c = 0; series->channel_names && c < series->channels; c++)
        if (series->channel_names[c] && series->channel_names[c][0])
            return 1;
    return 0;
}

static int make_channels(cvol_context *context, image *m)
{
    const size_t count = (size_t)m->written.channels;
    m->least = malloc(count * sizeof *m->least);
    m->most = malloc(count * sizeof *m->most);
    if (!m->least || !m->most)
        return cvol_fail_memory(context, count * sizeof *m->least, m->path);
    for (size_t c = 0; c < count; c++) {
        m->least[c] = DBL_MAX;
        m->most[c] = -DBL_MAX;
    }
    m->written.least = m->least;
    m->written.most = m->most;
    return CVOL_OK;
}

int cvol_zarr_write_open(cvol_context *context, cvol_write_sink *sink, const cvol_grid *grid,
                         const char *path, const cvol_series_options *series, int labels)
{
    image *m = calloc(1, sizeof *m);
    if (!m)
        return cvol_fail_memory(context, sizeof *m, path);
    *sink = (cvol_write_sink){.state = m,
                              .write = write_bytes,
                              .add_missing = add_missing,
                              .commit = commit_image,
                              .close = close_image};
    m->series = *series;
    m->path = strdup(path);
    m->written = (cvol_zarr_written){.path = m->path,
                                     .format = series->zarr_format ? series->zarr_format : 2,
                                     .grid = *grid,
                                     .labels = labels,
                                     .times = series->times,
                                     .channels = series->channels,
                                     .has_times = series->times > 1,
                                     .series = &m->series};
    m->written.has_channels = series->channels > 1 || has_names(series);
    int code = m->path ? CVOL_OK : cvol_fail_memory(context, strlen(path), path);
    if (!code)
        code = cvol_zarr_pyramid_open(context, &m->pyramid, grid, labels);
    m->written.levels = m->pyramid.levels;
    if (!code)
        code = make_levels(context, m);
    if (!code)
        code = make_workers(context, m);
    if (!code)
        code = make_channels(context, m);
    if (!code && labels) { /* they may be gone when the group is written */
        cvol_zarr_describe_labels(&m->written.label_list, series);
        if (m->written.label_list.failed)
            code = cvol_fail_memory(context, series->label_count, path);
    }
    return code ? code : cvol_zarr_folder_open(context, &m->folder, path);
}
