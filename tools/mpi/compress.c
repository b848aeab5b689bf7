/* Compression by several processes (tools/compress/compress_stream.h). */
#include "cvol/mpi.h"
#include "tools/compress/compress_stream.h"
#include "tools/mpi/messages.h"
#include "tools/mpi/work.h"

static int compress_by_all(cvol_context *context, cvol_compress_report *report, const char *path,
                           const cvol_sample_source *source, const cvol_grid *grid,
                           const cvol_compress_options *options)
{
    note_agreement();
    return cvol_mpi_compress_stream(context, report, path, source, grid, options, MPI_COMM_WORLD);
}

void divide_compression(void)
{
    compressor_of_streams = compress_by_all;
}
