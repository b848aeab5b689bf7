/* Kernels of tiles (transform_tile.h). */
#include "base/vector.h"
#include "render/transform_tile.h"

#include "array/array.h"

/* Rows that are added up side by side. */
#define SIDE 4

/* lines[v][x] = sum_u A[u, v] across[u][x], v < rows. */
CVOL_INLINE void add_across(float *lines, const cvol_tile_task *task, int vectors)
{
    const int width = vectors * CVOL_LANES, bits = cvol_place_bits(task->block_log2);
    const uint32_t mask = (UINT32_C(1) << task->block_log2) - 1;
    const uint32_t *at = task->terms;
    uint32_t place = 0;
    int32_t value = 0;
    int left = at < task->end;
    if (left)
        value = cvol_term_unpack(&at, &place, bits);
    for (int v = 0; v < task->rows; v++) {
        cvol_vf sum[CVOL_TILE_PLACES / CVOL_LANES];
        for (int i = 0; i < vectors; i++)
            sum[i] = cvol_splat(0);
        while (left && (int)(place >> task->block_log2) == v) {
            const float *row = task->across + (place & mask) * (uint32_t)task->width;
            const float factor = task->step * (float)value;
            for (int i = 0; i < vectors; i++)
                sum[i] += factor * cvol_load(row + i * CVOL_LANES);
            left = at < task->end;
            if (left)
                value = cvol_term_unpack(&at, &place, bits);
        }
        for (int i = 0; i < vectors; i++)
            cvol_store(lines + v * width + i * CVOL_LANES, sum[i]);
    }
}

/* out[y][x] += sum_v down[y][v] lines[v][x] */
CVOL_INLINE void add_down(const cvol_tile_task *task, const float *lines, int vectors)
{
    const int width = vectors * CVOL_LANES, B = 1 << task->block_log2;
    int y = task->from;
    for (; y + SIDE <= task->to; y += SIDE) {
        const float *down = task->down + y * B;
        for (int i = 0; i < vectors; i++) {
            float *out = task->out + (size_t)y * task->stride + i * CVOL_LANES;
            cvol_vf sum[SIDE];
            for (int s = 0; s < SIDE; s++)
                sum[s] = cvol_load(out + (size_t)s * task->stride);
            for (int v = 0; v < task->rows; v++) {
                const cvol_vf line = cvol_load(lines + v * width + i * CVOL_LANES);
                for (int s = 0; s < SIDE; s++)
                    sum[s] += down[s * B + v] * line;
            }
            for (int s = 0; s < SIDE; s++)
                cvol_store(out + (size_t)s * task->stride, sum[s]);
        }
    }
    for (; y < task->to; y++)
        for (int i = 0; i < vectors; i++) {
            float *out = task->out + (size_t)y * task->stride + i * CVOL_LANES;
            cvol_vf sum = cvol_load(out);
            for (int v = 0; v < task->rows; v++)
                sum += task->down[y * B + v] * cvol_load(lines + v * width + i * CVOL_LANES);
            cvol_store(out, sum);
        }
}

CVOL_INLINE void add_tile(const cvol_tile_task *task, int vectors)
{
    float lines[32 * CVOL_TILE_PLACES] __attribute__((aligned(64)));
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
    for (int x = 0; x < row->count; x += CVOL_LANES) {
        const cvol_vf D = cvol_max(cvol_min(cvol_load(row->sheet_opacity + x), one), zero);
        const cvol_vf T = cvol_load(row->through + x);
        for (int c = 0; c < channels; c++) {
            const cvol_vf C = cvol_load(row->sheet[c] + x), I = cvol_load(row->colours[c] + x);
            cvol_store(row->colours[c] + x, front ? I + T * C : I - D * I + C);
            cvol_store(row->sheet[c] + x, zero);
        }
        cvol_store(row->through + x, T - T * D);
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
