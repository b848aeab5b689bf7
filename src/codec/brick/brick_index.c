/* The index: lengths as variable-length integers, checksums of runs. */
#include "codec/brick/brick_index.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"

const cvol_stream_section cvol_stream_sections[CVOL_STREAMS] = {{CVOL_MASK, CVOL_STREAM_MASK},
                                                                {CVOL_SHL0, 0},
                                                                {CVOL_SHL1, 1},
                                                                {CVOL_SHL2, 2},
                                                                {CVOL_SHL3, 3},
                                                                {CVOL_CORR, CVOL_STREAM_RESIDUAL}};

int cvol_brick_index_make(cvol_context *context, cvol_brick_index *index, size_t bricks, size_t run)
{
    const size_t runs = bricks / run + (bricks % run != 0);
    *index = (cvol_brick_index){
        .bricks = bricks, .run = run, .runs = runs, .present = CVOL_STREAMS_SUBBANDS};
    index->ends = calloc(bricks, CVOL_STREAMS * sizeof *index->ends);
    index->checksums = calloc(runs, CVOL_STREAMS * sizeof *index->checksums);
    if ((index->ends && index->checksums) || !bricks)
        return CVOL_OK;
    cvol_brick_index_free(index);
    return cvol_fail_memory(context, bricks * CVOL_STREAMS * sizeof *index->ends, "the index");
}

void cvol_brick_index_free(cvol_brick_index *index)
{
    free(index->ends);
    free(index->checksums);
    *index = (cvol_brick_index){0};
}

static uint64_t *end_of(const cvol_brick_index *index, int subband, size_t brick)
{
    return index->ends + (size_t)subband * index->bricks + brick;
}

static uint64_t begin_of(const cvol_brick_index *index, int subband, size_t brick)
{
    return brick ? *end_of(index, subband, brick - 1) : 0;
}

static uint32_t *checksum_of(const cvol_brick_index *index, int subband, size_t run)
{
    return index->checksums + (size_t)subband * index->runs + run;
}

int cvol_brick_index_add_one(cvol_brick_index *index, int stream, size_t brick, cvol_span bytes)
{
    uint32_t *checksum = checksum_of(index, stream, brick / index->run);
    if (bytes.size > UINT32_MAX)
        return 0;
    index->present |= 1u << stream;
    *end_of(index, stream, brick) = begin_of(index, stream, brick) + bytes.size;
    *checksum = cvol_crc32c_more(*checksum, bytes.data, bytes.size);
    return 1;
}

int cvol_brick_index_add(cvol_brick_index *index, size_t brick,
                         const cvol_span subbands[CVOL_SUBBANDS])
{
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        if (!cvol_brick_index_add_one(index, s, brick, subbands[s]))
            return 0;
    return 1;
}

/* True if the section has a checksum for the run; a run of one brick has none if it is empty. */
static int has_checksum(const cvol_brick_index *index, int subband, size_t run)
{
    return index->run > 1 || *end_of(index, subband, run) > begin_of(index, subband, run);
}

/* Appends lengths, then checksums, of the streams first .. end - 1 that the file has. */
static void put_streams(cvol_bytes *out, const cvol_brick_index *index, int first, int end)
{
    for (int s = first; s < end; s++)
        for (size_t b = 0; index->present >> s & 1 && b < index->bricks; b++)
            cvol_bytes_put_varint(out, *end_of(index, s, b) - begin_of(index, s, b));
    for (int s = first; s < end; s++)
        for (size_t r = 0; index->present >> s & 1 && r < index->runs; r++)
            if (has_checksum(index, s, r))
                cvol_bytes_put_u32(out, *checksum_of(index, s, r));
}

void cvol_brick_index_put(cvol_bytes *out, const cvol_brick_index *index)
{
    put_streams(out, index, 0, CVOL_SUBBANDS);
    for (int s = CVOL_SUBBANDS; s < CVOL_STREAMS; s++)
        put_streams(out, index, s, s + 1);
}

static int take_streams(cvol_context *context, cvol_brick_index *index, cvol_cursor *content,
                        int first, int end, const char *name)
{
    for (int s = first; s < end; s++)
        for (size_t b = 0; index->present >> s & 1 && b < index->bricks; b++) {
            const uint64_t size = cvol_cursor_varint(content);
            if (content->failed || size > UINT32_MAX)
                return cvol_fail(context, CVOL_ERROR_CORRUPT,
                                 "%s: section INDX: subband %d of brick %zu of %zu has no length "
                                 "below 2^32",
                                 name, s, b, index->bricks);
            *end_of(index, s, b) = begin_of(index, s, b) + size;
        }
    for (int s = first; s < end; s++)
        for (size_t r = 0; index->present >> s & 1 && r < index->runs; r++)
            if (has_checksum(index, s, r))
                *checksum_of(index, s, r) = cvol_cursor_u32(content);
    return CVOL_OK;
}

int cvol_brick_index_take(cvol_context *context, cvol_brick_index *index,
                          const cvol_section *section, uint64_t bricks, size_t run,
                          const char *name)
{
    return cvol_brick_index_take_streams(context, index, section, bricks, run,
                                         CVOL_STREAMS_SUBBANDS, name);
}

int cvol_brick_index_take_streams(cvol_context *context, cvol_brick_index *index,
                                  const cvol_section *section, uint64_t bricks, size_t run,
                                  unsigned present, const char *name)
{
    cvol_cursor content = cvol_section_cursor(section);
    *index = (cvol_brick_index){0};
    /* A length takes at least one byte. */
    if (bricks > section->length / CVOL_SUBBANDS)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section INDX has %llu bytes, %llu bricks are more than it can hold",
                         name, (unsigned long long)section->length, (unsigned long long)bricks);
    int code = cvol_brick_index_make(context, index, (size_t)bricks, run);
    index->present |= present;
    if (!code)
        code = take_streams(context, index, &content, 0, CVOL_SUBBANDS, name);
    for (int s = CVOL_SUBBANDS; s < CVOL_STREAMS && !code; s++)
        code = take_streams(context, index, &content, s, s + 1, name);
    if (!code && (content.failed || cvol_cursor_left(&content)))
        code = cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section INDX has %s bytes for %zu bricks and their checksums", name,
                         content.failed ? "too few" : "too many", index->bricks);
    return code;
}

int cvol_brick_index_verify(const cvol_brick_index *index, int subband, size_t run,
                            const uint8_t *data)
{
    const cvol_span bytes = cvol_brick_index_run(index, subband, run, data);
    return cvol_crc32c(bytes.data, bytes.size) == *checksum_of(index, subband, run);
}

uint64_t cvol_brick_index_size(const cvol_brick_index *index, int subband)
{
    return begin_of(index, subband, index->bricks);
}

uint32_t cvol_brick_index_checksum(const cvol_brick_index *index, int subband)
{
    uint32_t checksum = 0;
    for (size_t r = 0; r < index->runs; r++) {
        const uint32_t run = *checksum_of(index, subband, r);
        const uint8_t bytes[4] = {(uint8_t)run, (uint8_t)(run >> 8), (uint8_t)(run >> 16),
                                  (uint8_t)(run >> 24)};
        checksum = cvol_crc32c_more(checksum, bytes, 4);
    }
    return checksum;
}

int cvol_brick_index_check(cvol_context *context, const cvol_brick_index *index, int subband,
                           const cvol_section *section, const char *name)
{
    const uint64_t size = cvol_brick_index_size(index, subband);
    const uint32_t found = cvol_brick_index_checksum(index, subband);
    if (size != section->length)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section %s at byte %llu has %llu bytes, its bricks have %llu", name,
                         section->tag, (unsigned long long)section->offset,
                         (unsigned long long)section->length, (unsigned long long)size);
    if (found == section->checksum)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_CORRUPT,
                     "%s: section %s at byte %llu: checksum is %08x, section INDX gives %08x", name,
                     section->tag, (unsigned long long)section->offset, section->checksum, found);
}

/* data may be NULL if the stream is empty. */
static cvol_span span_of(const uint8_t *data, uint64_t begin, uint64_t end)
{
    return (cvol_span){data ? data + begin : NULL, (size_t)(end - begin)};
}

cvol_span cvol_brick_index_brick(const cvol_brick_index *index, int subband, size_t brick,
                                 const uint8_t *data)
{
    const uint64_t begin = begin_of(index, subband, brick);
    return span_of(data, begin, *end_of(index, subband, brick));
}

cvol_span cvol_brick_index_run(const cvol_brick_index *index, int subband, size_t run,
                               const uint8_t *data)
{
    const size_t first = run * index->run, left = index->bricks - first;
    const size_t last = first + (left < index->run ? left : index->run) - 1;
    const uint64_t begin = begin_of(index, subband, first);
    return span_of(data, begin, *end_of(index, subband, last));
}
