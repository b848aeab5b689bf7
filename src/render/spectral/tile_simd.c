/* Kernels of tiles (tile.h). */
#include <float.h>

#include "array/core/array.h"
#include "base/vector.h"
#include "render/spectral/tile.h"

/* Rows that are summed together. */
#define SIDE 8

/* Tiles are multiplied as matrices if there are at most this many numbers per term. */

/* Terms that are unpacked together. */
#define BATCH 16

typedef struct term_batch {
    float value[BATCH] __attribute__((aligned(64)));
    int32_t column[BATCH] __attribute__((aligned(64))); /* start of rows of `across` and of lines */
    int32_t line[BATCH] __attribute__((aligned(64)));
    int32_t keep[BATCH] __attribute__((aligned(64))); /* -1: on the line of the term before */
} term_batch;

/* Unpacks BATCH words; 0 if one of them is an escape. *last: the line of the term before. */
CVOL_INLINE int unpack(term_batch *out, const uint32_t *words, const cvol_tile_task *task,
                       int width, cvol_vi *last)
{
    const int log2 = task->block_log2, bits = cvol_place_bits(log2);
    const int32_t mask = (1 << bits) - 1, side = (1 << log2) - 1, escape = cvol_term_escape(bits);
    cvol_vi escapes = {0}, before = *last, index;
    for (int i = 0; i < CVOL_LANES; i++)
        index[i] = CVOL_LANES - 1 + i;
    for (int i = 0; i < BATCH; i += CVOL_LANES) {
        cvol_vi word;
        memcpy(&word, words + i, sizeof word);
        const cvol_vi value = word >> bits, place = word & mask, line = place >> log2;
        const cvol_vi keep = line == (cvol_vi)cvol_shuffle((cvol_vf)before, (cvol_vf)line, index);
        const cvol_vi column = (place & side) * width, start = line * width;
        escapes |= value == escape;
        before = line;
        cvol_store(out->value + i, cvol_to_float(value) * task->step);
        memcpy(out->column + i, &column, sizeof column);
        memcpy(out->line + i, &start, sizeof start);
        memcpy(out->keep + i, &keep, sizeof keep);
    }
    if (cvol_any(escapes))
        return 0;
    *last = before;
    return 1;
}

/* The same for fewer terms, or with escapes; *count: the number of terms. */
static const uint32_t *unpack_slowly(term_batch *out, int *count, const uint32_t *words,
                                     const cvol_tile_task *task, int width, cvol_vi *last)
{
    int i = 0, before = (*last)[CVOL_LANES - 1];
    for (; i < BATCH && words < task->end; i++) {
        uint32_t place;
        out->value[i] = task->step *
                        (float)cvol_term_unpack(&words, &place, cvol_place_bits(task->block_log2));
        const int line = (int)(place >> task->block_log2);
        out->column[i] = (int)(place & ((UINT32_C(1) << task->block_log2) - 1)) * width;
        out->line[i] = line * width;
        out->keep[i] = line == before ? -1 : 0;
        before = line;
    }
    (*last)[CVOL_LANES - 1] = before;
    *count = i;
    return words;
}

/* lines[v][x] = sum_u A[u, v] across[u][x], v < rows. */
CVOL_INLINE void add_across(float *lines, const cvol_tile_task *task, int vectors)
{
    const int width = vectors * CVOL_LANES;
    const uint32_t *at = task->terms;
    term_batch batch;
    cvol_vi last = (cvol_vi){0} - 1;
    cvol_vf sum[CVOL_TILE_PLACES / CVOL_LANES];
    for (int i = 0; i < vectors; i++)
        sum[i] = cvol_splat(0);
    for (int i = 0; i < task->rows * vectors; i++)
        cvol_store(lines + i * CVOL_LANES, sum[0]);
    while (at < task->end) {
        int count = BATCH;
        if (task->end - at >= BATCH && unpack(&batch, at, task, width, &last))
            at += BATCH;
        else
            at = unpack_slowly(&batch, &count, at, task, width, &last);
        /* from memory, one by one: extracting them from vectors would cost more */
        __asm__ volatile("" ::: "memory");
        for (int t = 0; t < count; t++) {
            const float *row = task->across + batch.column[t];
            float *line = lines + batch.line[t];
            const cvol_vi keep = batch.keep[t] - (cvol_vi){0};
            for (int i = 0; i < vectors; i++) {
                sum[i] = (cvol_vf)((cvol_vi)sum[i] & keep) +
                         batch.value[t] * cvol_load(row + i * CVOL_LANES);
                cvol_store(line + i * CVOL_LANES, sum[i]);
            }
        }
    }
}

/* Terms as a matrix, [v][u] with rows of B; rows are zero up to a multiple of SIDE. */
CVOL_INLINE void make_dense(float *dense, const cvol_tile_task *task)
{
    const int bits = cvol_place_bits(task->block_log2);
    const int32_t mask = (1 << bits) - 1, escape = cvol_term_escape(bits);
    const uint32_t *at = task->terms;
    const int floats = (task->rows + SIDE - 1) / SIDE * SIDE << task->block_log2;
    for (int i = 0; i < floats; i += CVOL_LANES)
        cvol_store(dense + i, (cvol_vf){0});
    while (task->end - at >= BATCH) {
        float value[BATCH] __attribute__((aligned(64)));
        int32_t place[BATCH] __attribute__((aligned(64)));
        cvol_vi escapes = {0};
        for (int i = 0; i < BATCH; i += CVOL_LANES) {
            cvol_vi word;
            memcpy(&word, at + i, sizeof word);
            const cvol_vi number = word >> bits, where = word & mask;
            escapes |= number == escape;
            cvol_store(value + i, cvol_to_float(number) * task->step);
            memcpy(place + i, &where, sizeof where);
        }
        if (cvol_any(escapes))
            break;
        /* from memory, one by one: extracting them from vectors would cost more */
        __asm__ volatile("" ::: "memory");
        for (int i = 0; i < BATCH; i++)
            dense[place[i]] = value[i];
        at += BATCH;
    }
    while (at < task->end) {
        uint32_t place;
        const int32_t number = cvol_term_unpack(&at, &place, bits);
        dense[place] = task->step * (float)number;
    }
}

/* lines[v][x] = sum_u dense[v][u] across[u][x] */
CVOL_INLINE void multiply_across(float *lines, const cvol_tile_task *task, int vectors)
{
    const int width = vectors * CVOL_LANES, log2 = task->block_log2;
    float dense[(32 + SIDE) * 32] __attribute__((aligned(64)));
    make_dense(dense, task);
    for (int v = 0; v < task->rows; v += SIDE)
        for (int i = 0; i < vectors; i++) {
            const float *across = task->across + i * CVOL_LANES, *row = dense + (v << log2);
            cvol_vf sum[SIDE];
            for (int s = 0; s < SIDE; s++)
                sum[s] = cvol_splat(0);
            for (int u = 0; u < task->columns; u++) {
                const cvol_vf weights = cvol_load(across + u * width);
                for (int s = 0; s < SIDE; s++)
                    sum[s] += row[(s << log2) + u] * weights;
            }
            for (int s = 0; s < SIDE; s++)
                cvol_store(lines + (v + s) * width + i * CVOL_LANES, sum[s]);
        }
}

/* out[y][x] += sum_v down[v][y] lines[v][x]. Rows beyond `to` are computed, and not stored. */
CVOL_INLINE void add_down(const cvol_tile_task *task, const float *lines, int vectors)
{
    const int width = vectors * CVOL_LANES;
    for (int y = task->from; y < task->to; y += SIDE)
        for (int i = 0; i < vectors; i++) {
            const float *line = lines + i * CVOL_LANES, *down = task->down + y;
            float *out = task->out + (size_t)y * task->stride + i * CVOL_LANES;
            cvol_vf sum[SIDE];
            for (int s = 0; s < SIDE; s++)
                sum[s] = cvol_splat(0);
            for (int v = 0; v < task->rows; v++, line += width, down += width) {
                const cvol_vf values = cvol_load(line);
                for (int s = 0; s < SIDE; s++)
                    sum[s] += down[s] * values;
            }
            for (int s = 0; s < SIDE && y + s < task->to; s++, out += task->stride)
                cvol_store(out, cvol_load(out) + sum[s]);
        }
}

CVOL_INLINE void add_tile(const cvol_tile_task *task, int vectors)
{
    float lines[(32 + SIDE) * CVOL_TILE_PLACES] __attribute__((aligned(64)));
    const int64_t terms = task->end - task->terms;
    if (task->rows * task->columns <= CVOL_TILE_DENSE * terms)
        multiply_across(lines, task, vectors);
    else
        add_across(lines, task, vectors);
    add_down(task, lines, vectors);
}

void CVOL_SIMD(cvol_tile_add)(const cvol_tile_task *task)
{
    switch (task->width / CVOL_LANES) {
    case 1:
        add_tile(task, 1);
        break;
    case 2:
        add_tile(task, 2);
        break;
    case 3:
        add_tile(task, 3);
        break;
    case 4:
        add_tile(task, 4);
        break;
    default:
        add_tile(task, task->width / CVOL_LANES);
    }
}

CVOL_INLINE void composite(const cvol_tile_row *row, int channels, int front)
{
    const cvol_vf zero = {0}, one = cvol_splat(1);
    const cvol_vf darkest = cvol_splat(row->cut ? 0 : -FLT_MAX);
    for (int x = 0; x < row->count; x += CVOL_LANES) {
        const cvol_vf D = cvol_max(cvol_min(cvol_load(row->sheet_opacity + x), one), zero);
        const cvol_vf T = cvol_load(row->transmittance + x);
        const cvol_vf brightest = row->cut ? CVOL_BRIGHTEST * D : cvol_splat(FLT_MAX);
        for (int c = 0; c < channels; c++) {
            const cvol_vf C = cvol_max(cvol_min(cvol_load(row->sheet[c] + x), brightest), darkest);
            const cvol_vf I = cvol_load(row->colours[c] + x);
            cvol_store(row->colours[c] + x, front ? I + T * C : I - D * I + C);
            cvol_store(row->sheet[c] + x, zero);
        }
        cvol_store(row->transmittance + x, T - T * D);
        cvol_store(row->sheet_opacity + x, zero);
    }
}

void CVOL_SIMD(cvol_tile_composite)(const cvol_tile_row *row)
{
    if (row->front && row->channels == 1)
        composite(row, 1, 1);
    else if (row->front)
        composite(row, 3, 1);
    else if (row->channels == 1)
        composite(row, 1, 0);
    else
        composite(row, 3, 0);
}
