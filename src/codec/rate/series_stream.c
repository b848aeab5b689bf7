/* Compresses volumes of a series slab by slab. */
#include "codec/container/series.h"
#include "codec/rate/compress_options.h"
#include "codec/rate/compress_stream.h"

typedef struct stream {
    cvol_compress_report *report;
    const cvol_sample_source *source;
    const cvol_grid *grid;
    const cvol_compress_options *options;
} stream;

static int write_volume(cvol_context *context, cvol_output *output, void *user)
{
    const stream *s = user;
    return cvol_compress_stream_within(context, s->report, output, s->source, s->grid, s->options);
}

int cvol_series_add_stream(cvol_context *context, cvol_series_writer *writer,
                           cvol_compress_report *report, const cvol_sample_source *source,
                           const cvol_grid *grid, const cvol_compress_options *options)
{
    cvol_compress_options full;
    stream s = {report, source, grid, &full};
    const int code = cvol_compress_options_complete(context, &full, options);
    return code ? code : cvol_series_add_written(context, writer, grid, write_volume, &s);
}
