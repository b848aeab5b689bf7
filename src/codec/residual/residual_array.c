/* Residuals of arrays: storage, evaluation, reading. */
#include "codec/residual/residual_array.h"

#include <stdlib.h>
#include <string.h>
#include <zstd.h>
#include <zstd_errors.h>

#include "array/block/exact.h"
#include "base/byte_order.h"
#include "base/context.h"
#include "base/memory.h"
#include "codec/quantize/coding.h"
#include "codec/residual/residual_labels.h"
#include "codec/section/packed.h"

enum {
    BRICK_SAMPLES = CVOL_BRICK_SIDE * CVOL_BRICK_SIDE * CVOL_BRICK_SIDE,
    PACK_LEVEL = 19,
    PACK_FAST = 3,
    /* Chunks of large volumes that are packed to estimate the bytes for all. */
    ESTIMATED_CHUNKS = 8,
    ESTIMATED_CHUNK = 2 << 20
};

/* ---- evaluating ------------------------------------------------------------------------- */

/* One thread's memory for a brick. */
typedef struct work {
    cvol_residual_coder *coder;
    cvol_label_coder *labels;
    uint32_t *numbers;
    double *base, *scratch;
    size_t scratch_count;
    void *samples;
    uint8_t *which;
} work;

static void work_free(work *w)
{
    cvol_residual_coder_free(w->coder);
    cvol_label_coder_free(w->labels);
    free(w->numbers);
    free(w->base);
    free(w->scratch);
    free(w->samples);
    free(w->which);
}

static int work_make(work *w, cvol_residual_kind kind)
{
    *w = (work){.samples = cvol_allocate(BRICK_SAMPLES, sizeof(double))};
    if (kind == CVOL_RESIDUAL_LABELS) {
        w->labels = cvol_label_coder_create();
        w->numbers = cvol_allocate(BRICK_SAMPLES, sizeof *w->numbers);
        return w->samples && w->labels && w->numbers;
    }
    w->coder = cvol_residual_coder_create();
    w->base = cvol_allocate(BRICK_SAMPLES, sizeof *w->base);
    w->which = cvol_allocate(BRICK_SAMPLES, 1);
    return w->samples && w->coder && w->base && w->which;
}

static int reserve_scratch(work *w, size_t count)
{
    if (count <= w->scratch_count)
        return count > 0;
    free(w->scratch);
    w->scratch = cvol_allocate(count, sizeof *w->scratch);
    w->scratch_count = w->scratch ? count : 0;
    return w->scratch != NULL;
}

/* Copies the intersection of two boxes from one box of samples to the other. */
static void copy_box(uint8_t *to, const cvol_box *to_box, const uint8_t *from,
                     const cvol_box *from_box, size_t size)
{
    size_t lo[3], hi[3], to_size[3], from_size[3];
    for (int a = 0; a < 3; a++) {
        lo[a] = to_box->begin[a] > from_box->begin[a] ? to_box->begin[a] : from_box->begin[a];
        hi[a] = to_box->end[a] < from_box->end[a] ? to_box->end[a] : from_box->end[a];
        to_size[a] = to_box->end[a] - to_box->begin[a];
        from_size[a] = from_box->end[a] - from_box->begin[a];
    }
    for (size_t z = lo[2]; z < hi[2]; z++)
        for (size_t y = lo[1]; y < hi[1]; y++) {
            const size_t there = lo[0] - to_box->begin[0] +
                                 to_size[0] *
                                     (y - to_box->begin[1] + to_size[1] * (z - to_box->begin[2]));
            const size_t here = lo[0] - from_box->begin[0] +
                                from_size[0] * (y - from_box->begin[1] +
                                                from_size[1] * (z - from_box->begin[2]));
            memcpy(to + size * there, from + size * here, size * (hi[0] - lo[0]));
        }
}

static int decode_residual(work *w, const cvol_array *array, size_t brick, const cvol_box *own,
                           const size_t size[3])
{
    const cvol_residual_data *c = (const cvol_residual_data *)array->residual;
    cvol_residual_brick job = {.size = {size[0], size[1], size[2]}, .base = w->base};
    if (!reserve_scratch(w, cvol_exact_scratch(array, own->begin, own->end)))
        return CVOL_ERROR_MEMORY;
    if (array->mask && cvol_mask_get(w->which, array->mask, own->begin, own->end))
        job.which = w->which;
    cvol_exact_box(w->base, w->scratch, array, c->fraction, own->begin, own->end);
    return cvol_residual_decode(w->coder, w->samples, &c->rule, c->tables, &job,
                                cvol_residual_stream(c, brick));
}

static int evaluate_brick(work *w, const cvol_array *array, size_t brick, uint8_t *out,
                          const cvol_box *box)
{
    const cvol_residual_data *c = (const cvol_residual_data *)array->residual;
    const cvol_box own = cvol_brick_samples_of(array, brick);
    size_t size[3];
    for (int a = 0; a < 3; a++)
        size[a] = own.end[a] - own.begin[a];
    const int code = c->kind == CVOL_RESIDUAL_LABELS
                         ? cvol_labels_decode(w->labels, w->samples, w->numbers, &c->rule, size,
                                              cvol_residual_stream(c, brick))
                         : decode_residual(w, array, brick, &own, size);
    if (!code)
        copy_box(out, box, w->samples, &own, cvol_type_size(array->grid.type));
    return code;
}

static int evaluate_bricks(cvol_context *context, void *out, const cvol_array *array,
                           const cvol_box *box)
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    const cvol_residual_data *c = (const cvol_residual_data *)array->residual;
    size_t bricks[3], first[3], count[3];
    cvol_brick_grid(bricks, array);
    for (int a = 0; a < 3; a++) {
        first[a] = box->begin[a] / coding->brick.side[a];
        count[a] = (box->end[a] - 1) / coding->brick.side[a] + 1 - first[a];
    }
    int failed = CVOL_OK;
    size_t where = SIZE_MAX;
    for (size_t l = first[2]; l < first[2] + count[2] && !failed; l++) {
        int code = cvol_report_progress(context, "decoding",
                                        (double)(l - first[2]) / (double)count[2]);
        if (code)
            return code;
#pragma omp parallel num_threads(cvol_context_threads(context))
        {
            work w;
            const int made = work_make(&w, c->kind);
#pragma omp for schedule(dynamic)
            for (size_t i = 0; i < count[0] * count[1]; i++) {
                const size_t brick = first[0] + i % count[0] +
                                     bricks[0] * (first[1] + i / count[0] + bricks[1] * l);
                const int result = made ? evaluate_brick(&w, array, brick, out, box)
                                        : CVOL_ERROR_MEMORY;
                if (result) {
#pragma omp critical
                    if (brick < where) {
                        where = brick;
                        failed = result;
                    }
                }
            }
            work_free(&w);
        }
    }
    if (failed == CVOL_ERROR_CORRUPT)
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "the %s of brick %zu of %zu %s damaged",
                         c->kind == CVOL_RESIDUAL_LABELS ? "labels" : "residual", where,
                         bricks[0] * bricks[1] * bricks[2],
                         c->kind == CVOL_RESIDUAL_LABELS ? "are" : "is");
    if (failed)
        return cvol_fail_memory(context, BRICK_SAMPLES * sizeof(double), "a brick");
    return cvol_report_progress(context, "decoding", 1);
}

static int evaluate(cvol_context *context, void *out, const cvol_array *array,
                    const size_t begin[3], const size_t end[3])
{
    const cvol_residual_data *c = (const cvol_residual_data *)array->residual;
    cvol_box box, all = {.begin = {0, 0, 0}};
    memcpy(box.begin, begin, sizeof box.begin);
    memcpy(box.end, end, sizeof box.end);
    memcpy(all.end, array->grid.dims, sizeof all.end);
    if (c->kind != CVOL_RESIDUAL_PACKED)
        return evaluate_bricks(context, out, array, &box);
    copy_box(out, &box, c->samples, &all, cvol_type_size(array->grid.type));
    return CVOL_OK;
}

/* ---- keeping ---------------------------------------------------------------------------- */

static void free_as(cvol_residual *residual)
{
    cvol_residual_free((cvol_residual_data *)residual);
}

static uint64_t bytes_as(const cvol_residual *residual)
{
    const cvol_residual_data *c = (const cvol_residual_data *)residual;
    return sizeof *c + c->data.capacity + c->bricks * sizeof *c->ends +
           (c->tables ? sizeof *c->tables : 0);
}

void cvol_residual_free(cvol_residual_data *residual)
{
    if (!residual)
        return;
    free(residual->tables);
    free(residual->ends);
    cvol_bytes_free(&residual->data);
    free(residual->samples);
    free(residual);
}

int cvol_residual_create(cvol_context *context, cvol_residual_data **out,
                         const cvol_token_tables *tables, size_t bricks)
{
    cvol_residual_data *c = calloc(1, sizeof *c);
    *out = NULL;
    if (!c)
        return cvol_fail_memory(context, sizeof *c, "the residual");
    c->as = (cvol_residual){.evaluate = evaluate, .free = free_as, .bytes = bytes_as};
    c->ends = calloc(bricks ? bricks : 1, sizeof *c->ends);
    c->tables = tables ? cvol_token_tables_create() : NULL;
    if (!c->ends || (tables && !c->tables)) {
        cvol_residual_free(c);
        return cvol_fail_memory(context, bricks * sizeof *c->ends, "the residual");
    }
    if (tables)
        memcpy(c->tables, tables, sizeof *tables);
    *out = c;
    return CVOL_OK;
}

int cvol_residual_append(cvol_context *context, cvol_residual_data *residual, cvol_span bytes)
{
    if (bytes.size)
        cvol_bytes_append(&residual->data, bytes.data, bytes.size);
    if (residual->data.failed)
        return cvol_fail_memory(context, residual->data.size, "the residual");
    residual->ends[residual->bricks++] = residual->data.size;
    return CVOL_OK;
}

cvol_span cvol_residual_stream(const cvol_residual_data *residual, size_t brick)
{
    const uint64_t begin = brick ? residual->ends[brick - 1] : 0;
    const size_t size = (size_t)(residual->ends[brick] - begin);
    return (cvol_span){size ? residual->data.data + begin : NULL, size};
}

const cvol_residual_data *cvol_residual_of(const cvol_array *array)
{
    const cvol_residual *residual = array->residual;
    return residual && residual->free == free_as ? (const cvol_residual_data *)residual : NULL;
}

/* ---- packed ----------------------------------------------------------------------------- */

/* Files have little-endian samples. Returns bytes at .. at + bytes - 1 of samples of `size` bytes
 * in that order: in place, or in a copy, which the caller frees by *copy. NULL without memory. */
static const uint8_t *in_file_order(void **copy, const void *samples, size_t at, size_t bytes,
                                    size_t size)
{
    *copy = NULL;
    if (!cvol_machine_is_big_endian() || size == 1)
        return (const uint8_t *)samples + at;
    const size_t first = at / size, count = (at + bytes - 1) / size + 1 - first;
    *copy = cvol_allocate(count, size);
    if (!*copy)
        return NULL;
    memcpy(*copy, (const uint8_t *)samples + first * size, count * size);
    cvol_swap_bytes(*copy, count, size);
    return (const uint8_t *)*copy + at % size;
}

/* cvol_zstd_put of these bytes. */
static size_t pack(void *out, size_t most, const void *samples, size_t at, size_t bytes,
                   size_t size, int level)
{
    void *copy;
    const uint8_t *from = in_file_order(&copy, samples, at, bytes, size);
    const size_t packed = from ? cvol_zstd_put(out, most, from, bytes, level)
                               : (size_t)-ZSTD_error_memory_allocation;
    free(copy);
    return packed;
}

int cvol_packed_may_fit(const void *samples, const cvol_grid *grid, double bytes)
{
    const size_t raw = cvol_grid_bytes(grid), most = ZSTD_compressBound(raw);
    if (raw > CVOL_PACKED_MAX)
        return 0;
    void *buffer = malloc(most);
    if (!buffer)
        return CVOL_ERROR_MEMORY;
    const size_t packed_size = pack(buffer, most, samples, 0, raw, cvol_type_size(grid->type),
                                    PACK_FAST);
    free(buffer);
    if (ZSTD_isError(packed_size)) /* the buffer suffices */
        return CVOL_ERROR_MEMORY;
    return (double)packed_size <= 1.5 * bytes;
}

int cvol_packed_estimate(cvol_context *context, double *bytes, const void *samples,
                         const cvol_grid *grid)
{
    const size_t raw = cvol_grid_bytes(grid);
    const size_t chunks = raw > ESTIMATED_CHUNKS * (size_t)ESTIMATED_CHUNK ? ESTIMATED_CHUNKS : 1;
    const size_t chunk = chunks > 1 ? ESTIMATED_CHUNK : raw, most = ZSTD_compressBound(chunk);
    void *buffer = malloc(most);
    size_t sum = 0;
    int failed = !buffer;
    for (size_t i = 0; i < chunks && !failed; i++) {
        const size_t at = chunks > 1 ? (raw - chunk) / (chunks - 1) * i : 0;
        const size_t packed = pack(buffer, most, samples, at, chunk, cvol_type_size(grid->type),
                                   PACK_FAST);
        failed = ZSTD_isError(packed) != 0; /* the buffer suffices: memory is short */
        sum += failed ? 0 : packed;
    }
    free(buffer);
    *bytes = (double)sum * (double)raw / (double)(chunks * chunk);
    return failed ? cvol_fail_memory(context, most, "packed samples") : CVOL_OK;
}

int cvol_residual_pack(cvol_context *context, cvol_residual_data **out, const void *samples,
                       const cvol_grid *grid)
{
    const size_t size = cvol_grid_bytes(grid), most = ZSTD_compressBound(size);
    int code = cvol_residual_create(context, out, NULL, 0);
    if (code)
        return code;
    cvol_residual_data *c = *out;
    c->kind = CVOL_RESIDUAL_PACKED;
    c->samples = malloc(size);
    if (!c->samples || !cvol_bytes_reserve(&c->data, most)) {
        cvol_residual_free(c);
        *out = NULL;
        return cvol_fail_memory(context, most, "the packed samples");
    }
    memcpy(c->samples, samples, size);
    const size_t packed = pack(c->data.data, most, samples, 0, size, cvol_type_size(grid->type),
                               PACK_LEVEL);
    if (ZSTD_isError(packed)) {
        cvol_residual_free(c);
        *out = NULL;
        return cvol_fail(context, CVOL_ERROR_MEMORY, "the samples cannot be packed: %s",
                         ZSTD_getErrorName(packed));
    }
    c->data.size = packed;
    return CVOL_OK;
}

static int take_packed(cvol_context *context, cvol_residual_data *c, const cvol_array *array,
                       const cvol_section *section, const char *name)
{
    const size_t size = cvol_grid_bytes(&array->grid);
    int code = cvol_section_check(context, section, name);
    if (code)
        return code;
    if (size > CVOL_PACKED_MAX)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "%s: section CORR packs %zu bytes of samples, it may be %llu", name, size,
                         (unsigned long long)CVOL_PACKED_MAX);
    cvol_bytes_append(&c->data, section->content, (size_t)section->length);
    c->samples = malloc(size);
    if (!c->samples || c->data.failed)
        return cvol_fail_memory(context, size, "the packed samples");
    code = cvol_zstd_take(c->samples, size, section->content, (size_t)section->length);
    if (code == CVOL_ERROR_MEMORY)
        return cvol_fail_memory(context, size, "unpacking the samples");
    if (code)
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section CORR does not unpack", name);
    if (cvol_machine_is_big_endian())
        cvol_swap_bytes(c->samples, cvol_grid_samples(&array->grid),
                        cvol_type_size(array->grid.type));
    return CVOL_OK;
}

/* ---- reading ---------------------------------------------------------------------------- */

static int take_bricks(cvol_context *context, cvol_residual_data *c, const cvol_array *array,
                       const cvol_residual_file *file, const char *name)
{
    int code = cvol_brick_stream_check(context, array, file->index, CVOL_STREAM_RESIDUAL,
                                       file->section, file->box, name);
    if (!code && file->kind != CVOL_RESIDUAL_LABELS &&
        cvol_exact_fraction(cvol_exact_largest_sum(array)) < file->fraction)
        code = cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section MODE: %d fraction bits are too many for the coefficients",
                         name, file->fraction);
    for (size_t b = 0; b < file->index->bricks && !code; b++) {
        cvol_span bytes = cvol_brick_index_brick(file->index, CVOL_STREAM_RESIDUAL, b,
                                                 file->section->content);
        if (!cvol_brick_intersects(array, b, file->box))
            bytes.size = 0;
        code = cvol_residual_append(context, c, bytes);
    }
    return code;
}

int cvol_residual_take(cvol_context *context, cvol_array *array, const cvol_residual_file *file,
                       const char *name)
{
    const int is_packed = file->kind == CVOL_RESIDUAL_PACKED;
    const int has_tables = !is_packed && file->kind != CVOL_RESIDUAL_LABELS;
    cvol_residual_data *c;
    int code = cvol_residual_create(context, &c, has_tables ? file->tables : NULL,
                                    is_packed ? 0 : file->index->bricks);
    if (code)
        return code;
    c->kind = file->kind;
    c->fraction = file->fraction;
    c->rule = *file->rule;
    code = is_packed ? take_packed(context, c, array, file->section, name)
                     : take_bricks(context, c, array, file, name);
    if (code) {
        cvol_residual_free(c);
        return code;
    }
    array->residual = &c->as;
    return CVOL_OK;
}
