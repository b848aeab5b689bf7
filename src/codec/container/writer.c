/* The writer: spools, the index, and the sections in order. */
#include "codec/container/writer.h"

#include <stdlib.h>
#include <string.h>

#include "array/core/summary.h"
#include "base/context.h"
#include "base/file.h"
#include "base/spool.h"
#include "codec/brick/brick_index.h"
#include "codec/brick/brick_shape.h"
#include "codec/container/container.h"
#include "codec/container/section_pack.h"
#include "codec/container/summary_section.h"
#include "codec/section/section.h"
#include "codec/section/signature.h"

struct cvol_file_writer {
    cvol_output *output; /* NULL: only counting */
    int is_within;       /* the output is the caller's */
    cvol_spool spools[CVOL_STREAMS];
    cvol_brick_index index;
    size_t next;       /* next brick */
    uint64_t subbands; /* bytes of all subbands */
};

/* Opens a writer on the output and owns it, also after an error; NULL: only counting. */
static int open_on(cvol_context *context, cvol_file_writer **out, cvol_output *output,
                   size_t bricks, size_t run)
{
    cvol_file_writer *writer = calloc(1, sizeof *writer);
    if (!writer) {
        cvol_output_abandon(output);
        return cvol_fail_memory(context, sizeof *writer, "the file");
    }
    writer->output = output;
    const int code = cvol_brick_index_make(context, &writer->index, bricks, run);
    if (code)
        cvol_file_writer_abandon(writer);
    else
        *out = writer;
    return code;
}

int cvol_file_writer_open(cvol_context *context, cvol_file_writer **out, const char *path,
                          size_t bricks, size_t run)
{
    cvol_output *output = NULL;
    *out = NULL;
    const int code = path ? cvol_output_open(context, &output, path) : CVOL_OK;
    return code ? code : open_on(context, out, output, bricks, run);
}

int cvol_file_writer_open_within(cvol_context *context, cvol_file_writer **out, cvol_output *output,
                                 size_t bricks, size_t run)
{
    *out = NULL;
    const int code = open_on(context, out, NULL, bricks, run);
    if (!code) {
        (*out)->output = output;
        (*out)->is_within = 1;
    }
    return code;
}

static void writer_free(cvol_file_writer *writer)
{
    for (int s = 0; s < CVOL_STREAMS; s++)
        cvol_spool_free(&writer->spools[s]);
    cvol_brick_index_free(&writer->index);
    free(writer);
}

void cvol_file_writer_abandon(cvol_file_writer *writer)
{
    if (!writer)
        return;
    if (!writer->is_within)
        cvol_output_abandon(writer->output);
    writer_free(writer);
}

/* ---- bricks ----------------------------------------------------------------------------- */

static int spill_if_many(cvol_context *context, cvol_file_writer *writer)
{
    uint64_t held = 0;
    for (int s = 0; s < CVOL_STREAMS; s++)
        held += writer->spools[s].held.capacity;
    int code = CVOL_OK;
    for (int s = 0; held > CVOL_SPOOLED_MAX && s < CVOL_STREAMS && !code; s++)
        code = cvol_spool_spill(context, &writer->spools[s], writer->output);
    return code;
}

int cvol_file_writer_add(cvol_context *context, cvol_file_writer *writer,
                         const cvol_span subbands[CVOL_SUBBANDS])
{
    if (writer->next == writer->index.bricks ||
        !cvol_brick_index_add(&writer->index, writer->next, subbands))
        return cvol_fail(context, CVOL_ERROR_LIMIT, "brick %zu of %zu cannot be in a file",
                         writer->next, writer->index.bricks);
    writer->next++;
    for (int s = 0; s < CVOL_SUBBANDS; s++) {
        writer->subbands += subbands[s].size;
        int code = writer->output ? cvol_spool_append(context, &writer->spools[s], subbands[s].data,
                                                      subbands[s].size)
                                  : CVOL_OK;
        if (code)
            return code;
    }
    return writer->output ? spill_if_many(context, writer) : CVOL_OK;
}

int cvol_file_writer_add_one(cvol_context *context, cvol_file_writer *writer, int stream,
                             size_t brick, cvol_span bytes)
{
    if (brick >= writer->index.bricks ||
        !cvol_brick_index_add_one(&writer->index, stream, brick, bytes))
        return cvol_fail(context, CVOL_ERROR_LIMIT, "brick %zu of %zu cannot be in a file", brick,
                         writer->index.bricks);
    if (!writer->output)
        return CVOL_OK;
    const int code = cvol_spool_append(context, &writer->spools[stream], bytes.data, bytes.size);
    return code ? code : spill_if_many(context, writer);
}

uint64_t cvol_file_writer_subbands(const cvol_file_writer *writer)
{
    return writer->subbands;
}

/* ---- sections --------------------------------------------------------------------------- */

static void put_record(cvol_bytes *out, cvol_section_kind kind, const cvol_header *header,
                       void (*put)(cvol_bytes *, const cvol_header *))
{
    cvol_bytes content = {0};
    put(&content, header);
    cvol_section_put(out, kind, &content);
    cvol_bytes_free(&content);
}

static void put_start(cvol_bytes *out, const cvol_file_front *front)
{
    for (size_t i = 0; i < CVOL_SIGNATURE_BYTES; i++)
        cvol_bytes_put_u8(out, cvol_container_signature(i));
    cvol_bytes_put_u32(out, CVOL_FORMAT_VERSION);
    put_record(out, CVOL_HEAD, front->header, cvol_head_put);
    put_record(out, CVOL_GEOM, front->header, cvol_geometry_put);
    if (front->attributes) {
        cvol_bytes text = {0};
        cvol_bytes_put_text(&text, front->attributes);
        cvol_section_put(out, CVOL_ATTR, &text);
        cvol_bytes_free(&text);
    }
    put_record(out, CVOL_ERRS, front->header, cvol_errors_put);
    if (front->header->residual || front->header->fills.count)
        put_record(out, CVOL_MODE, front->header, cvol_modes_put);
    if (cvol_header_is_volume(front->header) && !cvol_brick_shape_is_usual(&front->header->brick))
        put_record(out, CVOL_BRKS, front->header, cvol_bricks_put);
    if (front->header->true_length)
        put_record(out, CVOL_TRUE, front->header, cvol_true_length_section_put);
    if (front->header->neural)
        put_record(out, CVOL_SMAL, front->header, cvol_neural_put);
    if (front->header->summary.state == CVOL_SUMMARY_KNOWN)
        put_record(out, CVOL_SUMM, front->header, cvol_summary_put);
}

/* Appends TABL and INDX. */
static int put_coder(cvol_context *context, cvol_bytes *out, const cvol_file_writer *writer,
                     const cvol_file_front *front)
{
    cvol_bytes tables = {0}, index = {0};
    /* The neural coder uses the built-in tables. */
    cvol_token_tables *own = front->header->neural ? cvol_token_tables_create() : NULL;
    int code = front->header->neural && !own
                   ? cvol_fail_memory(context, sizeof *own, "the coder's tables")
                   : cvol_token_tables_put(context, &tables, own ? own : front->tables);
    cvol_section_put(out, CVOL_TABL, &tables);
    cvol_brick_index_put(&index, &writer->index);
    cvol_section_put(out, CVOL_INDX, &index);
    cvol_bytes_free(&tables);
    cvol_bytes_free(&index);
    free(own);
    return code;
}

/* True if the ranges take at most a hundredth of the file. */
static int are_cheap(const cvol_bytes *ranges, uint64_t others)
{
    const uint64_t size = ranges->size + CVOL_SECTION_HEADER_BYTES;
    return size <= (others + size) / 100;
}

/* Appends all sections in front of the subbands' sections. */
static int put_front(cvol_context *context, cvol_bytes *out, const cvol_file_writer *writer,
                     const cvol_file_front *front)
{
    cvol_bytes coder = {0};
    int code = CVOL_OK;
    put_start(out, front);
    if (front->terms) {
        cvol_section_put(out, front->header->block ? CVOL_TERM : CVOL_SPEC, front->terms);
    } else {
        code = put_coder(context, &coder, writer, front);
        const uint64_t others = out->size + coder.size + writer->subbands +
                                (CVOL_SUBBANDS + 1) * (uint64_t)CVOL_SECTION_HEADER_BYTES;
        if (front->ranges && are_cheap(front->ranges, others))
            cvol_section_put(out, CVOL_RNGE, front->ranges);
        cvol_bytes_append(out, coder.data, coder.size);
        out->failed |= coder.failed;
        cvol_bytes_free(&coder);
    }
    if (!code && out->failed)
        code = cvol_fail_memory(context, out->size, "the file's header");
    return code;
}

/* ---- the file --------------------------------------------------------------------------- */

/* Writes bytes and empties them. */
static int flush(cvol_context *context, cvol_file_writer *writer, cvol_bytes *bytes,
                 uint64_t *written)
{
    *written += bytes->size;
    int code = bytes->failed ? cvol_fail_memory(context, bytes->size, "the file's header")
               : writer->output
                   ? cvol_output_write(context, writer->output, bytes->data, bytes->size)
                   : CVOL_OK;
    bytes->size = 0;
    return code;
}

static int has_stream(const cvol_file_writer *writer, int stream)
{
    return (int)(writer->index.present >> stream & 1);
}

/* The bytes of all streams, and of CORR if it is no stream. */
static uint64_t stream_bytes(const cvol_file_writer *writer, const cvol_file_front *front)
{
    uint64_t bytes = front->packed ? front->packed->size : 0;
    for (int s = 0; s < CVOL_STREAMS; s++)
        bytes += has_stream(writer, s) ? cvol_brick_index_size(&writer->index, s) : 0;
    return bytes;
}

/* True if a file with this many bytes in front of its streams is written as one section PACK. */
static int is_packed(const cvol_file_writer *writer, const cvol_file_front *front, uint64_t bytes)
{
    return !front->terms && writer->index.runs == 1 &&
           bytes + stream_bytes(writer, front) <= CVOL_PACK_MAX;
}

/* Converts the front of a file to the packed front. */
static int pack_front(cvol_context *context, const cvol_file_writer *writer,
                      const cvol_file_front *front, cvol_bytes *bytes)
{
    cvol_bytes packed = {0};
    const int code = cvol_pack_put(context, &packed, bytes, stream_bytes(writer, front),
                                   front->packed);
    cvol_bytes_free(bytes);
    *bytes = packed;
    return code;
}

/* Writes a stream's bytes, if the file has it. */
static int write_stream(cvol_context *context, cvol_file_writer *writer, int stream,
                        uint64_t *written)
{
    if (!has_stream(writer, stream))
        return CVOL_OK;
    *written += cvol_brick_index_size(&writer->index, stream);
    return writer->output ? cvol_spool_copy(context, &writer->spools[stream], writer->output)
                          : CVOL_OK;
}

/* Writes all streams; with_headers: each as a section. */
static int write_bricks(cvol_context *context, cvol_file_writer *writer,
                        const cvol_file_front *front, int with_headers, cvol_bytes *bytes,
                        uint64_t *written)
{
    int code = CVOL_OK;
    for (int i = 0; i < CVOL_STREAMS && !code; i++) {
        const cvol_stream_section *row = &cvol_stream_sections[i];
        if (with_headers && has_stream(writer, row->stream))
            cvol_section_put_header(bytes, row->kind,
                                    cvol_brick_index_size(&writer->index, row->stream),
                                    cvol_brick_index_checksum(&writer->index, row->stream));
        code = flush(context, writer, bytes, written);
        if (!code)
            code = write_stream(context, writer, row->stream, written);
    }
    if (front->packed && with_headers)
        cvol_section_put(bytes, CVOL_CORR, front->packed);
    else if (front->packed)
        cvol_bytes_append(bytes, front->packed->data, front->packed->size);
    return code;
}

static int write_all(cvol_context *context, cvol_file_writer *writer, const cvol_file_front *front,
                     uint64_t *written)
{
    cvol_bytes bytes = {0};
    int code = put_front(context, &bytes, writer, front);
    const int packs = !code && is_packed(writer, front, bytes.size);
    if (packs)
        code = pack_front(context, writer, front, &bytes);
    if (!front->terms && !code)
        code = write_bricks(context, writer, front, !packs, &bytes, written);
    if (!code) {
        if (!packs)
            cvol_section_put(&bytes, CVOL_ENDS, &(cvol_bytes){0});
        code = flush(context, writer, &bytes, written);
    }
    cvol_bytes_free(&bytes);
    return code;
}

int cvol_file_writer_bytes(cvol_context *context, const cvol_file_writer *writer,
                           const cvol_file_front *front, uint64_t *file_bytes)
{
    cvol_bytes bytes = {0};
    int code = put_front(context, &bytes, writer, front);
    const int packs = !code && is_packed(writer, front, bytes.size);
    const int headers = packs ? 0 : front->terms ? 1 : CVOL_SUBBANDS + 1;
    if (packs)
        code = pack_front(context, writer, front, &bytes);
    *file_bytes = bytes.size + writer->subbands + (uint64_t)headers * CVOL_SECTION_HEADER_BYTES;
    cvol_bytes_free(&bytes);
    return code;
}

int cvol_file_writer_finish(cvol_context *context, cvol_file_writer *writer,
                            const cvol_file_front *front, uint64_t *file_bytes)
{
    uint64_t written = 0;
    int code = writer->next == writer->index.bricks
                   ? write_all(context, writer, front, &written)
                   : cvol_fail(context, CVOL_ERROR_ARGUMENT, "%zu of %zu bricks were written",
                               writer->next, writer->index.bricks);
    if (code) {
        cvol_file_writer_abandon(writer);
        return code;
    }
    if (writer->output && !writer->is_within)
        code = cvol_output_commit(context, writer->output);
    writer_free(writer);
    if (!code && file_bytes)
        *file_bytes = written;
    return code;
}
