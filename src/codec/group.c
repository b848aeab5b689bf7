/* Encoding and decoding of groups of blocks, in parallel. */
#include "codec/group.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* Groups that are worked on between two calls of the progress function. */
enum { GROUPS_PER_CHUNK = 64 };

/* ---- the group grid --------------------------------------------------------------------- */

typedef struct group_box {
    size_t first[3], count[3]; /* in blocks */
} group_box;

static void group_grid(size_t groups[3], const cvol_array *array)
{
    size_t side = (size_t)(CVOL_GROUP_SIDE / array->block);
    for (int a = 0; a < 3; a++)
        groups[a] = (array->blocks[a] - 1) / side + 1;
}

size_t cvol_group_count(const cvol_array *array)
{
    size_t groups[3];
    group_grid(groups, array);
    return groups[0] * groups[1] * groups[2];
}

static group_box group_box_of(const cvol_array *array, size_t group)
{
    size_t side = (size_t)(CVOL_GROUP_SIDE / array->block), groups[3];
    group_grid(groups, array);
    const size_t place[3] = {group % groups[0], group / groups[0] % groups[1],
                             group / groups[0] / groups[1]};
    group_box box;
    for (int a = 0; a < 3; a++) {
        box.first[a] = place[a] * side;
        box.count[a] = array->blocks[a] - box.first[a] < side ? array->blocks[a] - box.first[a]
                                                              : side;
    }
    return box;
}

int cvol_group_touches(const cvol_array *array, size_t group, const size_t begin[3],
                       const size_t end[3])
{
    const group_box box = group_box_of(array, group);
    const size_t side = (size_t)array->block;
    for (int a = 0; a < 3; a++)
        if (box.first[a] * side >= end[a] || (box.first[a] + box.count[a]) * side <= begin[a])
            return 0;
    return 1;
}

/* The array's number of block `place` of a group. */
static size_t block_index(const cvol_array *array, const group_box *box, size_t place)
{
    size_t i = box->first[0] + place % box->count[0];
    size_t j = box->first[1] + place / box->count[0] % box->count[1];
    size_t l = box->first[2] + place / box->count[0] / box->count[1];
    return i + array->blocks[0] * (j + array->blocks[1] * l);
}

static size_t box_blocks(const group_box *box)
{
    return box->count[0] * box->count[1] * box->count[2];
}

void cvol_groups_free(cvol_groups *groups)
{
    for (size_t i = 0; i < groups->count; i++)
        cvol_bytes_free(&groups->bytes[i]);
    free(groups->bytes);
    memset(groups, 0, sizeof *groups);
}

uint64_t cvol_groups_size(const cvol_groups *groups)
{
    uint64_t size = 0;
    for (size_t i = 0; i < groups->count; i++)
        size += groups->bytes[i].size;
    return size;
}

/* ---- encoding --------------------------------------------------------------------------- */

/* What a thread needs; freed by scratch_free. */
typedef struct scratch {
    cvol_block_coder *coder;
    cvol_range_encoder stream;
    int32_t *values;
    uint32_t *words; /* decoder's terms of one group, growing */
    size_t word_capacity;
} scratch;

static int scratch_allocate(scratch *work)
{
    memset(work, 0, sizeof *work);
    work->coder = cvol_allocate(1, sizeof *work->coder);
    work->values = cvol_allocate(CVOL_BLOCK_SAMPLES_MAX, sizeof *work->values);
    return work->coder && work->values;
}

static void scratch_free(scratch *work)
{
    free(work->coder);
    free(work->values);
    free(work->words);
    cvol_range_encoder_free(&work->stream);
}

static int encode_group(cvol_bytes *out, const cvol_array *shape, const cvol_block_source *source,
                        size_t group, scratch *work)
{
    const group_box box = group_box_of(shape, group);
    cvol_block_coder_start(work->coder, shape->block, box.count);
    cvol_range_encoder_start(&work->stream);
    for (size_t i = 0; i < box_blocks(&box); i++) {
        int used = source->fetch(source->user, work->values, work->coder, i,
                                 block_index(shape, &box, i));
        if (!used)
            return CVOL_ERROR_TARGET;
        cvol_block_encode(work->coder, &work->stream, i, work->values, used);
    }
    out->size = 0;
    return cvol_range_encoder_finish(&work->stream, out) ? CVOL_OK : CVOL_ERROR_MEMORY;
}

/* Encodes chunk groups first, first + stride ... (count of them); the first failure's code. */
static int encode_chunk(int threads, cvol_groups *groups, const cvol_array *shape,
                        const cvol_block_source *source, size_t first, size_t stride, size_t count)
{
    int failure = CVOL_OK;
#pragma omp parallel num_threads(threads)
    {
        scratch work;
        int code = scratch_allocate(&work) ? CVOL_OK : CVOL_ERROR_MEMORY;
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count; i++)
            if (!code)
                code = encode_group(&groups->bytes[first + i * stride], shape, source,
                                    first + i * stride, &work);
        scratch_free(&work);
        if (code) {
#pragma omp atomic write
            failure = code;
        }
    }
    return failure;
}

static int make_groups(cvol_context *context, cvol_groups *groups, size_t count)
{
    if (groups->count == count)
        return CVOL_OK;
    cvol_groups_free(groups);
    groups->bytes = cvol_allocate_zero(count, sizeof *groups->bytes);
    if (!groups->bytes)
        return cvol_fail_memory(context, count * sizeof *groups->bytes, "the groups");
    groups->count = count;
    return CVOL_OK;
}

int cvol_groups_encode(cvol_context *context, cvol_groups *groups, const cvol_array *shape,
                       const cvol_block_source *source, size_t first, size_t stride,
                       double fraction)
{
    int code = make_groups(context, groups, cvol_group_count(shape));
    if (code)
        return code;
    const size_t chunk = GROUPS_PER_CHUNK * stride;
    for (size_t from = first; from < groups->count; from += chunk) {
        size_t left = (groups->count - from - 1) / stride + 1;
        code = encode_chunk(cvol_context_threads(context), groups, shape, source, from, stride,
                            left < GROUPS_PER_CHUNK ? left : GROUPS_PER_CHUNK);
        if (code == CVOL_ERROR_MEMORY)
            return cvol_fail_memory(context, sizeof(cvol_block_coder), "a group");
        if (code)
            return code;
        code = cvol_report_progress(context, "compressing", fraction);
        if (code)
            return code;
    }
    return CVOL_OK;
}

/* A block's terms in scan order. */
static int fetch_terms(const void *user, int32_t *values, cvol_block_coder *coder,
                       size_t place_in_group, size_t index)
{
    (void)place_in_group;
    const cvol_array *array = user;
    const cvol_block *block = &array->block_table[index];
    const uint32_t *words = block->terms, *end = words + block->words;
    int used = 1;
    memset(values, 0, sizeof *values * (size_t)coder->scan->count);
    while (words < end) {
        uint32_t place;
        int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(array->block_log2));
        int i = coder->scan->index_of_place[place];
        values[i] = value;
        used = i >= used ? i + 1 : used;
    }
    return used;
}

int cvol_array_encode(cvol_context *context, cvol_groups *groups, const cvol_array *array)
{
    cvol_block_source source = {fetch_terms, array};
    return cvol_groups_encode(context, groups, array, &source, 0, 1, 1);
}

/* ---- decoding --------------------------------------------------------------------------- */

static int reserve_words(scratch *work, size_t needed)
{
    if (needed <= work->word_capacity)
        return 1;
    size_t capacity = needed + needed / 2;
    uint32_t *words = realloc(work->words, capacity * sizeof *words);
    if (!words)
        return 0;
    work->words = words;
    work->word_capacity = capacity;
    return 1;
}

/* A decoded group: its terms in memory of exactly their size. */
typedef struct decoded {
    uint32_t *words;
    size_t count;
    uint64_t terms;
    int code;
} decoded;

static int decode_blocks(decoded *out, cvol_array *array, const group_box *box, cvol_span bytes,
                         scratch *work)
{
    const size_t per_block = 2 * (size_t)work->coder->scan->count;
    cvol_range_decoder stream;
    cvol_range_decoder_start(&stream, bytes.data, bytes.size);
    for (size_t i = 0; i < box_blocks(box); i++) {
        if (!reserve_words(work, out->count + per_block))
            return CVOL_ERROR_MEMORY;
        cvol_decoded_block block;
        if (!cvol_block_decode(work->coder, &stream, i, work->words + out->count, &block) ||
            cvol_range_decoder_overrun(&stream))
            return CVOL_ERROR_CORRUPT;
        /* No sample, and nothing on the way to it, is larger than this sum: floats must hold it. */
        if (!((double)block.sum * array->step < (double)FLT_MAX))
            return CVOL_ERROR_CORRUPT;
        array->block_table[block_index(array, box, i)].words = block.words;
        out->count += block.words;
        out->terms += block.terms;
    }
    return CVOL_OK;
}

static int decode_group(decoded *out, cvol_array *array, size_t group, cvol_span bytes,
                        scratch *work)
{
    const group_box box = group_box_of(array, group);
    cvol_block_coder_start(work->coder, array->block, box.count);
    int code = decode_blocks(out, array, &box, bytes, work);
    if (code)
        return code;
    out->words = malloc((out->count ? out->count : 1) * sizeof *out->words);
    if (!out->words)
        return CVOL_ERROR_MEMORY;
    memcpy(out->words, work->words, out->count * sizeof *out->words);
    const uint32_t *terms = out->words;
    for (size_t i = 0; i < box_blocks(&box); i++) {
        cvol_block *block = &array->block_table[block_index(array, &box, i)];
        block->terms = terms;
        terms += block->words;
        cvol_block_find_low(block, array->block_log2);
    }
    return CVOL_OK;
}

static void decode_all(int threads, decoded *out, cvol_array *array, const cvol_span *groups,
                       const uint32_t *checksums, size_t first, size_t end)
{
#pragma omp parallel num_threads(threads)
    {
        scratch work;
        int ready = scratch_allocate(&work);
#pragma omp for schedule(dynamic)
        for (size_t g = first; g < end; g++) {
            if (!groups[g].data)
                continue;
            if (!ready)
                out[g].code = CVOL_ERROR_MEMORY;
            else if (checksums && checksums[g] != cvol_crc32c(groups[g].data, groups[g].size))
                out[g].code = CVOL_ERROR_CORRUPT;
            else
                out[g].code = decode_group(&out[g], array, g, groups[g], &work);
        }
        scratch_free(&work);
    }
}

/* Hands the terms of all groups to the array; a failure of one is the failure of all. */
static int adopt_all(cvol_context *context, cvol_array *array, decoded *groups, size_t count,
                     const char *name)
{
    int code = CVOL_OK;
    for (size_t g = 0; g < count && !code; g++) {
        if (groups[g].code == CVOL_ERROR_CORRUPT)
            code = cvol_fail(context, CVOL_ERROR_CORRUPT,
                             "%s: section DATA: group %zu of %zu is damaged", name, g, count);
        else if (groups[g].code)
            code = cvol_fail_memory(context, sizeof(cvol_block_coder), "a group");
        else if (groups[g].words)
            code = cvol_array_adopt_pool(context, array, groups[g].words, groups[g].count);
        if (!code) {
            groups[g].words = NULL;
            array->coefficients += groups[g].terms;
        }
    }
    for (size_t g = 0; g < count; g++)
        free(groups[g].words);
    return code;
}

int cvol_array_decode(cvol_context *context, cvol_array *array, const cvol_span *groups,
                      const uint32_t *checksums, const char *name)
{
    const size_t count = cvol_group_count(array);
    decoded *out = cvol_allocate_zero(count, sizeof *out);
    if (!out)
        return cvol_fail_memory(context, count * sizeof *out, "the groups");
    int code = CVOL_OK, cancelled = CVOL_OK;
    for (size_t first = 0; first < count && !cancelled; first += GROUPS_PER_CHUNK) {
        size_t end = count - first < GROUPS_PER_CHUNK ? count : first + GROUPS_PER_CHUNK;
        decode_all(cvol_context_threads(context), out, array, groups, checksums, first, end);
        cancelled = cvol_report_progress(context, "loading", (double)end / (double)count);
    }
    if (cancelled) {
        for (size_t g = 0; g < count; g++)
            free(out[g].words);
        code = cancelled;
    } else {
        code = adopt_all(context, array, out, count, name);
    }
    free(out);
    return code;
}
