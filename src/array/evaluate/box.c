/* Samples from a compressed array: one block, or any box. */
#include <stdlib.h>
#include <string.h>

#include "array/block/block_inverse.h"
#include "array/block/block_transform.h"
#include "array/block/lapped.h"
#include "array/core/array.h"
#include "array/core/samples.h"
#include "array/evaluate/box.h"
#include "base/context.h"
#include "base/cpu.h"
#include "base/memory.h"
#include "transform/block.h"
#include "transform/cell_points.h"

CVOL_SIMD_DECLARE(void, cvol_block_decode,
                  (float *out, const cvol_block *block, const cvol_block_axes *axes, int block_log2,
                   float step, cvol_block_work *work));

/* The basis with rows padded to the lane width; only B = 8 needs it. */
static const float *lane_basis(float *padded, const float *basis, int block)
{
    if (block >= 16)
        return basis;
    memset(padded, 0, sizeof(float) * 8 * 16);
    for (int u = 0; u < block; u++)
        memcpy(padded + u * 16, basis + u * block, sizeof(float) * (size_t)block);
    return padded;
}

static void decode(float *out, const cvol_array *array, const cvol_block *block,
                   cvol_block_work *work)
{
    const int B = array->block;
    float padded[8 * 16] __attribute__((aligned(64)));
    const float *basis = cvol_block_basis(B);
    cvol_block_axes axes = {.lane = 0,
                            .row = 1,
                            .sheet = 2,
                            .lane_points = B,
                            .row_points = B,
                            .sheet_points = B,
                            .lane_basis = lane_basis(padded, basis, B),
                            .row_basis = basis,
                            .sheet_basis = basis};
    if (block->split)
        for (int i = 0; i < 2; i++)
            axes.lane_parts[i] = axes.row_parts[i] = axes.sheet_parts[i] = cvol_cell_samples_basis(
                i ? 4 : 8);
    CVOL_SIMD_CHOOSE(cvol_block_decode)
    (out, block, &axes, array->block_log2, (float)array->step, work);
}

/* Without working memory: dense matrices, in place. */
static void evaluate_slots(float *out, const cvol_array *array, size_t index)
{
    cvol_block_unpack(out, array, index);
    cvol_block_from_slots(out, array);
}

/* Larger blocks need more memory than a thread's stack has. Without that memory the slower method
 * is used, whose rounding differs. */
static void evaluate_large(float *out, const cvol_array *array, size_t index)
{
    cvol_block_work *work = cvol_allocate(1, sizeof *work);
    if (work)
        decode(out, array, &array->block_table[index], work);
    else
        evaluate_slots(out, array, index);
    free(work);
}

void cvol_block_evaluate(float *out, const cvol_array *array, size_t index)
{
    const cvol_block *block = &array->block_table[index];
    cvol_cell_work work;
    if (block->words == 0)
        memset(out, 0, sizeof *out * cvol_array_block_terms(array));
    else if (array->rank != 3 || array->transform != CVOL_DCT)
        evaluate_slots(out, array, index);
    else if (array->block > 16)
        evaluate_large(out, array, index);
    else
        decode(out, array, block, (cvol_block_work *)(void *)&work);
}

/* Copies the part of a block (x fastest, origin `at`; samples in the stored type) that lies within
 * the box to the box's samples. */
static void store_block(uint8_t *out, const uint8_t *stored, const cvol_array *array,
                        const size_t at[3], const size_t begin[3], const size_t end[3])
{
    const size_t size = cvol_type_size(array->grid.type);
    const size_t side[3] = {cvol_block_side(array, 0), cvol_block_side(array, 1),
                            cvol_block_side(array, 2)};
    size_t lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        lo[a] = at[a] > begin[a] ? at[a] : begin[a];
        hi[a] = at[a] + side[a] < end[a] ? at[a] + side[a] : end[a];
    }
    const size_t width = end[0] - begin[0], height = end[1] - begin[1];
    for (size_t z = lo[2]; z < hi[2]; z++)
        for (size_t y = lo[1]; y < hi[1]; y++) {
            const size_t to = lo[0] - begin[0] + width * (y - begin[1] + height * (z - begin[2]));
            const size_t from = lo[0] - at[0] + side[0] * (y - at[1] + side[1] * (z - at[2]));
            if (size * (hi[0] - lo[0]) == 16) /* the most frequent row */
                memcpy(out + to * size, stored + from * size, 16);
            else
                memcpy(out + to * size, stored + from * size, size * (hi[0] - lo[0]));
        }
}

/* The box of a lapped volume. */
typedef struct stored_box {
    const cvol_stream *stream;
    cvol_sample_format as;
    uint8_t *out;
} stored_box;

static void store_piece(void *user, const cvol_piece *piece)
{
    const stored_box *to = user;
    const size_t *begin = to->stream->begin, *end = to->stream->end;
    const size_t size = cvol_type_size(to->as.type);
    const size_t width = end[0] - begin[0], height = end[1] - begin[1];
    for (size_t z = piece->begin[2]; z < piece->end[2]; z++)
        for (size_t y = piece->begin[1]; y < piece->end[1]; y++)
            cvol_samples_convert(to->out + size * width * (y - begin[1] + height * (z - begin[2])),
                                 piece->samples[0] + (y - piece->begin[1]) * piece->line +
                                     (z - piece->begin[2]) * piece->sheet,
                                 width, &to->as);
}

static int evaluate_lapped(cvol_context *context, void *out, const cvol_array *array,
                           const size_t begin[3], const size_t end[3])
{
    cvol_stream stream = {.arrays = {array}, .take = store_piece, .what = "decoding"};
    stored_box to = {&stream, cvol_sample_format_of(array), out};
    memcpy(stream.begin, begin, sizeof stream.begin);
    memcpy(stream.end, end, sizeof stream.end);
    stream.user = &to;
    return cvol_stream_run(context, &stream);
}

/* Returns 1 if all of a block's samples are masked: their values will be replaced. */
static int is_all_masked(const cvol_array *array, const size_t place[3])
{
    return array->mask && array->block == CVOL_MASK_CELL &&
           cvol_mask_cell(array->mask, place) == CVOL_MASK_ALL;
}

/* Evaluates the terms in the array's type; masked samples may remain unset. */
static int evaluate_terms(cvol_context *context, void *out, const cvol_array *array,
                          const size_t begin[3], const size_t end[3])
{
    int code = CVOL_OK;
    if (!array->block)
        return cvol_whole_evaluate_stored(context, out, array, begin, end);
    if (array->lapped)
        return evaluate_lapped(context, out, array, begin, end);
    const size_t per_block = cvol_array_block_terms(array);
    const size_t side[3] = {cvol_block_side(array, 0), cvol_block_side(array, 1),
                            cvol_block_side(array, 2)};
    const cvol_sample_format as = cvol_sample_format_of(array);
    size_t first[3], count[3];
    for (int a = 0; a < 3; a++) {
        first[a] = begin[a] / side[a];
        count[a] = (end[a] - 1) / side[a] + 1 - first[a];
    }
    int failed = 0;
    for (size_t layer = 0; layer < count[2] && !failed; layer++) {
        code = cvol_report_progress(context, "decoding", (double)layer / (double)count[2]);
        if (code)
            return code;
        size_t blocks = count[0] * count[1];
#pragma omp parallel num_threads(cvol_context_threads(context))
        {
            float *samples = cvol_allocate(per_block, sizeof *samples);
            uint8_t *stored = cvol_allocate(per_block, cvol_type_size(as.type));
            if (!samples || !stored) {
#pragma omp atomic write
                failed = 1;
            }
#pragma omp for schedule(dynamic)
            for (size_t i = 0; i < blocks; i++) {
                size_t place[3] = {first[0] + i % count[0], first[1] + i / count[0],
                                   first[2] + layer};
                if (!samples || !stored || is_all_masked(array, place))
                    continue;
                size_t at[3] = {place[0] * side[0], place[1] * side[1], place[2] * side[2]};
                cvol_block_evaluate(samples, array,
                                    place[0] + array->blocks[0] *
                                                   (place[1] + array->blocks[1] * place[2]));
                cvol_samples_convert(stored, samples, per_block, &as);
                store_block(out, stored, array, at, begin, end);
            }
            free(samples);
            free(stored);
        }
    }
    if (failed)
        return cvol_fail_memory(context, per_block * sizeof(float), "a block");
    return cvol_report_progress(context, "decoding", 1);
}

/* Sets masked samples to their fills. */
static void apply_mask(cvol_context *context, void *out, const cvol_array *array,
                       const size_t begin[3], const size_t end[3])
{
    const size_t size = cvol_type_size(array->grid.type);
    const size_t sheet = (end[0] - begin[0]) * (end[1] - begin[1]);
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t z = begin[2] / CVOL_MASK_CELL; z < (end[2] - 1) / CVOL_MASK_CELL + 1; z++) {
        size_t first[3] = {begin[0], begin[1], z * CVOL_MASK_CELL};
        size_t last[3] = {end[0], end[1], (z + 1) * CVOL_MASK_CELL};
        first[2] = first[2] > begin[2] ? first[2] : begin[2];
        last[2] = last[2] < end[2] ? last[2] : end[2];
        cvol_mask_write((uint8_t *)out + size * sheet * (first[2] - begin[2]), size,
                        cvol_mask_fills(array->mask)->bits, array->mask, first, last);
    }
}

int cvol_array_evaluate_box(cvol_context *context, void *out, const cvol_array *array,
                            const size_t begin[3], const size_t end[3])
{
    int code = cvol_array_check_box(context, array, begin, end);
    if (!code)
        code = array->residual ? array->residual->evaluate(context, out, array, begin, end)
                               : evaluate_terms(context, out, array, begin, end);
    if (!code && array->mask)
        apply_mask(context, out, array, begin, end);
    return code;
}

uint64_t cvol_array_evaluate_mask(uint8_t *out, const cvol_array *array, const size_t begin[3],
                                  const size_t end[3])
{
    if (cvol_mask_is_void(array->mask))
        return cvol_mask_get(out, array->mask, begin, end);
    memset(out, 0, (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]));
    return 0;
}
