/* Coded bricks in memory. */
#include "codec/brick/coded.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/quantize/coding.h"

int cvol_coded_make(cvol_context *context, cvol_coded **out, const cvol_token_tables *tables,
                    const cvol_array *shape)
{
    cvol_coded *coded = cvol_allocate_zero(1, sizeof *coded);
    *out = NULL;
    if (!coded)
        return cvol_fail_memory(context, sizeof *coded, "the coded volume");
    coded->tables = cvol_token_tables_create();
    if (!coded->tables) {
        cvol_coded_free(coded);
        return cvol_fail_memory(context, sizeof *tables, "the coder's tables");
    }
    memcpy(coded->tables, tables, sizeof *tables);
    const int code = cvol_brick_index_make(context, &coded->index, cvol_brick_count(shape),
                                           cvol_coding_of(shape)->brick.run);
    if (code) {
        cvol_coded_free(coded);
        return code;
    }
    *out = coded;
    return CVOL_OK;
}

void cvol_coded_free(cvol_coded *coded)
{
    if (!coded)
        return;
    free(coded->tables);
    cvol_brick_index_free(&coded->index);
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_bytes_free(&coded->subbands[s]);
    free(coded);
}

static int take(cvol_context *context, void *user, size_t brick,
                const cvol_span subbands[CVOL_SUBBANDS])
{
    cvol_coded *coded = user;
    if (!cvol_brick_index_add(&coded->index, brick, subbands))
        return cvol_fail(context, CVOL_ERROR_LIMIT, "brick %zu takes 4 GiB or more", brick);
    for (int s = 0; s < CVOL_SUBBANDS; s++) {
        cvol_bytes_append(&coded->subbands[s], subbands[s].data, subbands[s].size);
        if (coded->subbands[s].failed)
            return cvol_fail_memory(context, coded->subbands[s].size, "the coded volume");
    }
    return CVOL_OK;
}

cvol_brick_sink cvol_coded_sink(cvol_coded *coded)
{
    return (cvol_brick_sink){take, coded};
}

int cvol_coded_decode(cvol_context *context, cvol_array *array, const cvol_coded *coded,
                      const cvol_box *box)
{
    cvol_brick_source source = {.index = &coded->index, .count = CVOL_SUBBANDS};
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        source.subbands[s] = coded->subbands[s].data;
    return cvol_bricks_decode(context, array, coded->tables, &source, box, "the coded volume");
}

void cvol_coded_brick(cvol_span subbands[CVOL_SUBBANDS], const cvol_coded *coded, size_t brick)
{
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        subbands[s] = cvol_brick_index_brick(&coded->index, s, brick, coded->subbands[s].data);
}

void cvol_coded_attach(cvol_array *array, cvol_coded *coded)
{
    cvol_file_coding *own = cvol_coding_own(array);
    own->coded = coded;
    own->free_coded = cvol_coded_free;
}

const cvol_coded *cvol_coded_of(const cvol_array *array)
{
    return cvol_coding_of(array)->coded;
}

int cvol_coded_write(cvol_context *context, const cvol_coded *coded, const cvol_brick_sink *sink)
{
    int code = CVOL_OK;
    for (size_t b = 0; b < coded->index.bricks && !code; b++) {
        cvol_span subbands[CVOL_SUBBANDS];
        cvol_coded_brick(subbands, coded, b);
        code = sink->take(context, sink->user, b, subbands);
    }
    return code;
}
