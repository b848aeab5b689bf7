/* Compression by several processes (cvol/mpi.h). */
#include "codec/rate/compress_stream.h"
#include "cvol/mpi.h"
#include "mpi/processes.h"

int cvol_mpi_compress_stream(cvol_context *context, cvol_compress_report *report, const char *path,
                             const cvol_sample_source *source, const cvol_grid *grid,
                             const cvol_compress_options *options, MPI_Comm comm)
{
    cvol_mpi_processes p = cvol_mpi_processes_of(comm);
    cvol_team team = cvol_mpi_team_of(&p);
    const cvol_stream_work work = {.team = p.size > 1 ? &team : NULL};
    return cvol_compress_stream_by(context, report, path, source, grid, options, &work);
}
