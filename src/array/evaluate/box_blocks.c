/* Real values of a box of samples, block by block. */
#include <stdlib.h>
#include <string.h>

#include "array/block/lapped.h"
#include "array/evaluate/box.h"
#include "base/context.h"
#include "base/memory.h"

/* The box and the blocks that it touches. */
typedef struct box {
    const size_t *begin, *end;
    size_t first[3], count[3];
} box;

/* Evaluates block `i` of the box and writes the part of it that lies within the box. */
static void write_block(float *out, float *samples, const cvol_array *array, const box *b, size_t i)
{
    const size_t place[3] = {b->first[0] + i % b->count[0],
                             b->first[1] + i / b->count[0] % b->count[1],
                             b->first[2] + i / b->count[0] / b->count[1]};
    size_t at[3], lo[3], hi[3], side[3];
    for (int a = 0; a < 3; a++) {
        side[a] = cvol_block_side(array, a);
        at[a] = place[a] * side[a];
        lo[a] = at[a] > b->begin[a] ? at[a] : b->begin[a];
        hi[a] = at[a] + side[a] < b->end[a] ? at[a] + side[a] : b->end[a];
    }
    const size_t width = b->end[0] - b->begin[0], height = b->end[1] - b->begin[1];
    const float offset = (float)array->offset;
    cvol_block_evaluate(samples, array,
                        place[0] + array->blocks[0] * (place[1] + array->blocks[1] * place[2]));
    for (size_t z = lo[2]; z < hi[2]; z++)
        for (size_t y = lo[1]; y < hi[1]; y++) {
            float *to = out + width * (y - b->begin[1] + height * (z - b->begin[2]));
            const float *from = samples + side[0] * (y - at[1] + side[1] * (z - at[2]));
            for (size_t x = lo[0]; x < hi[0]; x++)
                to[x - b->begin[0]] = from[x - at[0]] + offset;
        }
}

/* The box of a lapped volume. */
typedef struct real_box {
    const cvol_stream *stream;
    float *out;
} real_box;

static void write_piece(void *user, const cvol_piece *piece)
{
    const real_box *to = user;
    const size_t *begin = to->stream->begin, *end = to->stream->end;
    const size_t width = end[0] - begin[0], height = end[1] - begin[1];
    const float offset = (float)to->stream->arrays[0]->offset;
    for (size_t z = piece->begin[2]; z < piece->end[2]; z++)
        for (size_t y = piece->begin[1]; y < piece->end[1]; y++) {
            float *line = to->out + width * (y - begin[1] + height * (z - begin[2]));
            const float *from = piece->samples[0] + (y - piece->begin[1]) * piece->line +
                                (z - piece->begin[2]) * piece->sheet;
            for (size_t x = 0; x < width; x++)
                line[x] = from[x] + offset;
        }
}

static int evaluate_lapped(cvol_context *context, float *out, const cvol_array *array,
                           const size_t begin[3], const size_t end[3])
{
    cvol_stream stream = {.arrays = {array}, .take = write_piece, .what = "decoding"};
    real_box to = {&stream, out};
    memcpy(stream.begin, begin, sizeof stream.begin);
    memcpy(stream.end, end, sizeof stream.end);
    stream.user = &to;
    return cvol_stream_run(context, &stream);
}

int cvol_blocks_evaluate(cvol_context *context, float *out, const cvol_array *array,
                         const size_t begin[3], const size_t end[3])
{
    enum { AT_ONCE = 1 << 24 }; /* samples between reports of progress */
    const size_t per_block = cvol_array_block_terms(array);
    box b = {.begin = begin, .end = end};
    if (array->lapped)
        return evaluate_lapped(context, out, array, begin, end);
    for (int a = 0; a < 3; a++) {
        const size_t side = cvol_block_side(array, a);
        b.first[a] = begin[a] / side;
        b.count[a] = (end[a] - 1) / side + 1 - b.first[a];
    }
    const size_t blocks = b.count[0] * b.count[1] * b.count[2], batch = AT_ONCE / per_block;
    int failed = 0;
    for (size_t from = 0; from < blocks && !failed; from += batch) {
        int code = cvol_report_progress(context, "decoding", (double)from / (double)blocks);
        if (code)
            return code;
        const size_t to = from + batch < blocks ? from + batch : blocks;
#pragma omp parallel num_threads(cvol_context_threads(context))
        {
            float *samples = cvol_allocate(per_block, sizeof *samples);
            if (!samples) {
#pragma omp atomic write
                failed = 1;
            }
#pragma omp for schedule(dynamic, 8)
            for (size_t i = from; i < to; i++)
                if (samples)
                    write_block(out, samples, array, &b, i);
            free(samples);
        }
    }
    if (failed)
        return cvol_fail_memory(context, per_block * sizeof(float), "a block");
    return cvol_report_progress(context, "decoding", 1);
}
