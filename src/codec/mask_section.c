/* Masks of arrays to bricks and back. */
#include "codec/mask_section.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/corrected.h"
#include "codec/mask_code.h"

enum { BRICK_SAMPLES = CVOL_BRICK_SIDE * CVOL_BRICK_SIDE * CVOL_BRICK_SIDE };

static int code_brick(cvol_token_writer *writer, cvol_bytes *out, const cvol_token_tables *tables,
                      const cvol_array *array, size_t brick, cvol_token_counts *counts)
{
    const cvol_box box = cvol_brick_samples_of(array, brick);
    const size_t size[3] = {box.end[0] - box.begin[0], box.end[1] - box.begin[1],
                            box.end[2] - box.begin[2]};
    uint8_t *which = cvol_allocate(BRICK_SAMPLES, 1);
    int done = which != NULL;
    if (done) {
        cvol_mask_get(which, array->mask, box.begin, box.end);
        done = cvol_mask_encode(writer, out, tables, which, size,
                                cvol_mask_fills(array->mask)->count, counts);
    }
    free(which);
    return done;
}

int cvol_mask_brick(cvol_token_writer *writer, cvol_bytes *out, const cvol_token_tables *tables,
                    const cvol_array *array, size_t brick)
{
    return code_brick(writer, out, tables, array, brick, NULL);
}

static void add_counts(cvol_token_counts *to, const cvol_token_counts *counts)
{
    for (int r = CVOL_ROW_MASK; r < CVOL_ROW_FILL + CVOL_FILLS_MAX; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            to->of[r][t] += counts->of[r][t];
}

int cvol_mask_count(cvol_context *context, cvol_token_counts *counts, const cvol_array *array)
{
    const size_t bricks = array->mask ? cvol_brick_count(array) : 0;
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_token_counts *own = cvol_allocate_zero(1, sizeof *own);
        cvol_token_writer writer = {0};
        cvol_bytes brick = {0};
#pragma omp for schedule(dynamic)
        for (size_t b = 0; b < bricks; b++) {
            if (!own || !code_brick(&writer, &brick, NULL, array, b, own)) {
#pragma omp atomic write
                failed = 1;
            }
        }
        if (own) {
#pragma omp critical
            add_counts(counts, own);
        }
        free(own);
        cvol_bytes_free(&brick);
        cvol_token_writer_free(&writer);
    }
    return failed ? cvol_fail_memory(context, BRICK_SAMPLES, "a mask") : CVOL_OK;
}

static int take_brick(const cvol_array *array, uint8_t *which, int fills,
                      const cvol_token_tables *tables, cvol_span bytes, size_t brick)
{
    const cvol_box box = cvol_brick_samples_of(array, brick);
    const size_t size[3] = {box.end[0] - box.begin[0], box.end[1] - box.begin[1],
                            box.end[2] - box.begin[2]};
    if (!bytes.size)
        return CVOL_OK;
    if (!cvol_mask_decode(which, size, fills, tables, bytes))
        return CVOL_ERROR_CORRUPT;
    return cvol_mask_set(array->mask, which, box.begin, box.end) ? CVOL_OK : CVOL_ERROR_MEMORY;
}

int cvol_mask_take(cvol_context *context, cvol_array *array, const cvol_fills *fills,
                   const cvol_token_tables *tables, const cvol_brick_index *index,
                   const cvol_section *section, const cvol_box *box, const char *name)
{
    int code = cvol_brick_stream_check(context, array, index, CVOL_STREAM_MASK, section, box, name);
    if (!code)
        code = cvol_mask_create(context, &array->mask, array->grid.dims, fills);
    if (code)
        return code;
    int failed = CVOL_OK;
    size_t where = SIZE_MAX;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        uint8_t *which = cvol_allocate(BRICK_SAMPLES, 1);
#pragma omp for schedule(dynamic)
        for (size_t b = 0; b < index->bricks; b++) {
            if (!cvol_brick_meets(array, b, box))
                continue;
            const int result = which ? take_brick(array, which, fills->count, tables,
                                                  cvol_brick_index_brick(index, CVOL_STREAM_MASK, b,
                                                                         section->content),
                                                  b)
                                     : CVOL_ERROR_MEMORY;
            if (result) {
#pragma omp critical
                if (b < where) {
                    where = b;
                    failed = result;
                }
            }
        }
        free(which);
    }
    if (failed == CVOL_ERROR_CORRUPT)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section MASK: brick %zu of %zu is damaged", name, where,
                         index->bricks);
    return failed ? cvol_fail_memory(context, BRICK_SAMPLES, "a mask") : CVOL_OK;
}
