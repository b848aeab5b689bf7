/* Writes arrays to files, and reads them. */
#include "codec/container/array_file.h"

#include <stdlib.h>
#include <string.h>

#include "array/core/share.h"
#include "array/core/summary.h"
#include "base/context.h"
#include "base/file.h"
#include "base/options.h"
#include "base/team.h"
#include "codec/brick/brick_shape.h"
#include "codec/brick/bricks.h"
#include "codec/brick/coded.h"
#include "codec/brick/subbands.h"
#include "codec/container/container.h"
#include "codec/container/ranges.h"
#include "codec/container/terms.h"
#include "codec/container/writer.h"
#include "codec/mask/mask_section.h"
#include "codec/quantize/coding.h"
#include "codec/residual/residual_array.h"
#include "codec/section/signature.h"
#include "cvol/codec.h"

/* ---- writing ---------------------------------------------------------------------------- */

int cvol_array_may_have_ranges(const cvol_array *array, uint64_t subbands)
{
    return !cvol_coding_of(array)->neural &&
           cvol_grid_samples(&array->grid) / 4096 / 4 < subbands / 100 + 64;
}

/* Makes the content of RNGE. An array without ranges is evaluated for it; its bounds go to
 * `header`. */
static int put_ranges(cvol_context *context, cvol_bytes *out, const cvol_array *array,
                      cvol_header *header)
{
    cvol_array *ranged = NULL;
    int code = CVOL_OK;
    if (!array->has_ranges) {
        code = cvol_array_share(context, &ranged, array);
        if (!code) {
            ranged->mask = array->mask; /* borrowed, for the bounds */
            code = cvol_ranges_find(context, ranged);
            ranged->mask = NULL;
        }
        if (!code)
            header->error_bound.max_abs = ranged->error_bound.max_abs;
        array = ranged;
    }
    if (!code)
        code = cvol_ranges_put(context, out, array);
    cvol_array_free(ranged);
    return code;
}

static int take_brick(cvol_context *context, void *user, size_t brick,
                      const cvol_span subbands[CVOL_SUBBANDS])
{
    (void)brick;
    return cvol_file_writer_add(context, user, subbands);
}

/* Makes the tables that take the fewest bytes for these terms. Counting codes the terms once more,
 * so that only the array is needed. The caller frees *out. */
static int make_tables(cvol_context *context, cvol_token_tables **out, const cvol_array *array)
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_token_counts *counts = calloc(1, sizeof *counts);
    int code = tables && counts
                   ? coding->neural ? CVOL_OK : cvol_bricks_count(context, counts, array)
                   : cvol_fail_memory(context, sizeof *counts, "the coder's tables");
    if (!code && !coding->neural)
        cvol_token_tables_fit(tables, counts);
    const cvol_residual_data *residual = cvol_residual_of(array);
    if (!code && residual && residual->tables) /* as they are coded already */
        cvol_token_tables_copy_rows(tables, residual->tables, CVOL_ROW_RESIDUAL, CVOL_ROW_INDEX);
    free(counts);
    *out = tables;
    return code;
}

/* Writes the bricks of the mask and of the residual. */
static int write_modes(cvol_context *context, cvol_file_writer *writer, cvol_file_front *front,
                       const cvol_array *array)
{
    const cvol_residual_data *residual = cvol_residual_of(array);
    const size_t bricks = cvol_brick_count(array);
    cvol_range_encoder coder = {0};
    cvol_bytes bytes = {0};
    int code = CVOL_OK;
    for (size_t b = 0; array->mask && b < bricks && !code; b++) {
        code = cvol_mask_put_brick(&coder, &bytes, array, b)
                   ? cvol_file_writer_add_one(context, writer, CVOL_STREAM_MASK, b,
                                              (cvol_span){bytes.data, bytes.size})
                   : cvol_fail_memory(context, bytes.size, "a mask");
    }
    cvol_bytes_free(&bytes);
    cvol_range_encoder_free(&coder);
    if (residual && residual->kind == CVOL_RESIDUAL_PACKED)
        front->packed = &residual->data;
    else
        for (size_t b = 0; residual && b < bricks && !code; b++)
            code = cvol_file_writer_add_one(context, writer, CVOL_STREAM_RESIDUAL, b,
                                            cvol_residual_stream(residual, b));
    return code;
}

/* Fills the front and gives the writer the bricks. */
static int write_volume(cvol_context *context, cvol_file_writer *writer, cvol_file_front *front,
                        cvol_bytes *ranges, cvol_header *header, const cvol_array *array)
{
    const cvol_brick_sink sink = {take_brick, writer};
    const cvol_coded *coded = cvol_coded_of(array);
    int code = coded ? cvol_coded_write(context, coded, &sink)
                     : cvol_bricks_encode(context, array, front->tables, &sink);
    if (!code && cvol_array_may_have_ranges(array, cvol_file_writer_subbands(writer))) {
        code = put_ranges(context, ranges, array, header);
        front->ranges = ranges;
    }
    return code;
}

static int check_array(cvol_context *context, const cvol_array *array)
{
    if (!cvol_array_is_volume(array) && (array->lapped || cvol_array_has_splits(array)))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "only volumes in dct blocks may be lapped or split in a file");
    return array->block ? cvol_terms_check(context, array) : CVOL_OK;
}

/* An array whose terms were changed after the encoder chose them is coded without trellis and true
 * length: *array becomes `plain`, with its own coding. */
static int choose_coding(cvol_context *context, const cvol_array **array, cvol_array *plain,
                         cvol_file_coding *coding)
{
    *coding = *cvol_coding_of(*array);
    if (!(coding->trellis || coding->true_length) || cvol_coded_of(*array))
        return CVOL_OK;
    int fits = cvol_bricks_fit(context, *array);
    if (fits)
        return fits < 0 ? fits : CVOL_OK;
    *plain = **array;
    plain->coding = &coding->base;
    *array = plain;
    if (coding->trellis && coding->true_length) {
        coding->trellis = coding->neural = 0;
        fits = cvol_bricks_fit(context, plain);
    }
    if (!fits)
        coding->trellis = coding->neural = coding->true_length = 0;
    return fits < 0 ? fits : CVOL_OK;
}

/* Writes a part of an output, or a file if within is NULL; only counts if path is NULL too. Of a
 * team, process 0 writes the file, which has the same bytes. */
static int write_file(cvol_context *context, const cvol_array *array, const char *path,
                      cvol_output *within, uint64_t *file_bytes)
{
    const int is_volume = cvol_array_is_volume(array);
    cvol_file_writer *writer = NULL;
    cvol_bytes content = {0}; /* of RNGE, TERM or SPEC */
    cvol_token_tables *tables = NULL;
    int code = check_array(context, array);
    cvol_array plain;
    cvol_file_coding coding;
    if (!code)
        code = choose_coding(context, &array, &plain, &coding);
    cvol_summary summary = *cvol_array_summary(array);
    if (!code && is_volume && summary.state == CVOL_SUMMARY_NONE) /* results of operations have
                                                                     no summary */
        code = cvol_summarise_array(context, &summary, array);
    if (code)
        return code;
    const size_t bricks = is_volume ? cvol_brick_count(array) : 0,
                 run = cvol_coding_of(array)->brick.run;
    code = within
               ? cvol_file_writer_open_within(context, &writer, within, bricks, run)
               : cvol_file_writer_open(context, &writer,
                                       cvol_team_writes(context->team) ? path : NULL, bricks, run);
    if (code)
        return code;
    cvol_header header = cvol_header_of(array);
    header.summary = summary;
    if (cvol_share_of(context, array).team)
        code = cvol_subband_norms_by_team(context, header.subband_norm, array);
    cvol_file_front front = {.header = &header, .attributes = array->attributes};
    if (is_volume) {
        const cvol_coded *coded = cvol_coded_of(array);
        if (!coded && !code)
            code = make_tables(context, &tables, array);
        front.tables = coded ? coded->tables : tables;
        if (!code)
            code = write_volume(context, writer, &front, &content, &header, array);
        if (!code)
            code = write_modes(context, writer, &front, array);
    } else {
        code = array->block ? cvol_terms_put(context, &content, array)
                            : cvol_spectrum_put(context, &content, array);
        front.terms = &content;
    }
    code = cvol_team_agree(context, context->team, code);
    if (code)
        cvol_file_writer_abandon(writer);
    else
        code = cvol_file_writer_finish(context, writer, &front, file_bytes);
    cvol_bytes_free(&content);
    free(tables);
    return code;
}

int cvol_array_write(cvol_context *context, const cvol_array *array, const char *path,
                     uint64_t *file_bytes)
{
    return write_file(context, array, path, NULL, file_bytes);
}

int cvol_array_write_within(cvol_context *context, const cvol_array *array, cvol_output *output,
                            uint64_t *file_bytes)
{
    return write_file(context, array, NULL, output, file_bytes);
}

int cvol_array_file_bytes(cvol_context *context, const cvol_array *array, uint64_t *file_bytes)
{
    return write_file(context, array, NULL, NULL, file_bytes);
}

int cvol_array_write_memory(cvol_context *context, const cvol_array *array, void **out,
                            size_t *size)
{
    cvol_bytes bytes = {0};
    cvol_output *output;
    int code = cvol_output_open_memory(context, &output, &bytes, "the file in memory");
    if (!code)
        code = cvol_output_end(context, output, write_file(context, array, NULL, output, NULL));
    *out = code ? NULL : bytes.data;
    *size = code ? 0 : bytes.size;
    if (code)
        cvol_bytes_free(&bytes);
    return code;
}

/* ---- bricks ----------------------------------------------------------------------------- */

int cvol_array_set_bricks(cvol_context *context, cvol_array *array, const int brick[3])
{
    const cvol_residual_data *residual = cvol_residual_of(array);
    int code = cvol_array_need_volume(context, array, "a file in bricks");
    if (!code)
        code = cvol_brick_sides_check(context, brick, array->block);
    if (!code && residual && cvol_residual_has_bricks(residual->kind))
        code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "the array has a residual (maximum error or lossless), which is coded "
                         "in its bricks: compress the volume itself");
    if (code)
        return code;
    code = cvol_coding_need(context, array);
    if (code)
        return code;
    cvol_file_coding *coding = cvol_coding_own(array);
    coding->brick = cvol_brick_shape_make(brick);
    if (coding->coded)
        coding->free_coded(coding->coded);
    coding->coded = NULL;
    return CVOL_OK;
}

/* ---- reading ---------------------------------------------------------------------------- */

/* `part` may be NULL. */
static int complete(cvol_context *context, cvol_file_part *out, const cvol_file_part *part)
{
    *out = (cvol_file_part){.size = sizeof *out};
    return part ? cvol_options_copy(context, out, sizeof *out,
                                    CVOL_SIZE_TO(cvol_file_part, channel), "cvol_file_part", part)
                : CVOL_OK;
}

int cvol_array_read_part(cvol_context *context, cvol_array **out, cvol_file_report *report,
                         const char *path, const cvol_file_part *part)
{
    cvol_file_part full;
    cvol_map file;
    *out = NULL;
    int code = complete(context, &full, part);
    if (!code)
        code = cvol_file_map(context, &file, path);
    if (code)
        return code;
    code = cvol_container_read_part(context, out, report, file.data, file.size, &full, path);
    cvol_file_unmap(&file);
    return code;
}

int cvol_file_read_grid(cvol_context *context, cvol_grid *out, const char *path,
                        const cvol_file_part *part)
{
    cvol_file_part full;
    cvol_map file;
    int code = complete(context, &full, part);
    if (!code)
        code = cvol_file_map(context, &file, path);
    if (code)
        return code;
    code = cvol_container_read_grid(context, out, file.data, file.size, &full, path);
    cvol_file_unmap(&file);
    return code;
}

int cvol_array_read(cvol_context *context, cvol_array **out, const char *path, uint64_t *file_bytes)
{
    cvol_file_report report;
    int code = cvol_array_read_part(context, out, &report, path, NULL);
    if (!code && file_bytes)
        *file_bytes = report.file_bytes;
    return code;
}

int cvol_array_read_memory(cvol_context *context, cvol_array **out, const void *data, size_t size,
                           const char *name)
{
    return cvol_container_read(context, out, data, size, name);
}

int cvol_array_read_box(cvol_context *context, cvol_array **out, const char *path,
                        const size_t begin[3], const size_t end[3], uint64_t *file_bytes)
{
    const cvol_file_part part = {.size = sizeof(cvol_file_part), .begin = begin, .end = end};
    cvol_file_report report;
    int code = cvol_array_read_part(context, out, &report, path, &part);
    if (!code && file_bytes)
        *file_bytes = report.file_bytes;
    return code;
}

int cvol_file_is_cvol(const char *path)
{
    cvol_context context = {.limit_bytes = 0}; /* for discarded messages */
    uint8_t data[CVOL_SIGNATURE_BYTES];
    size_t size;
    return !cvol_file_peek(&context, data, &size, sizeof data, path) &&
           cvol_container_is(data, size);
}
