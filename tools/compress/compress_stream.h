/* Compresses volumes that are larger than memory. */
#ifndef CVOL_TOOLS_COMPRESS_STREAM_H
#define CVOL_TOOLS_COMPRESS_STREAM_H

#include "tools/base/cli.h"

/* The file of a volume that is read slab by slab. */
typedef struct slab_input {
    cvol_volume_stream *stream; /* NULL: read it whole */
    const char *path;
    const common_options *common;
} slab_input;

/* Opens the file for reading slab by slab if `always`, or if its samples take more than a quarter
 * of the memory that the process can use; prints that on standard error, except with --json. Exit
 * status, after a message. */
int open_slab_input(cvol_context *context, slab_input *in, const char *path, common_options *common,
                    int always);
void close_slab_input(slab_input *in);
const cvol_grid *slab_input_grid(const slab_input *in);

/* cvol_compress_stream, or the same by several processes (tools/mpi). */
typedef int stream_compressor(cvol_context *context, cvol_compress_report *report, const char *path,
                              const cvol_sample_source *source, const cvol_grid *grid,
                              const cvol_compress_options *options);
extern stream_compressor *compressor_of_streams;

/* Compresses all slabs to the file. A code of the library; the context has the message. */
int compress_slabs(cvol_context *context, slab_input *in, const char *out_path,
                   const cvol_compress_options *options, cvol_compress_report *report);
/* The same, as the next volume of a series. */
int add_slabs_to(cvol_context *context, cvol_series_writer *writer, slab_input *in,
                 cvol_compress_report *report, const cvol_compress_options *options);

/* The properties of the file that compress_slabs() wrote. Exit status, after a message. */
int read_streamed_info(cvol_context *context, cvol_array_info *info, const char *path,
                       const cvol_grid *grid, const cvol_compress_report *report);

#endif
