/* Compression by several processes (cvol/mpi.h). */
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/rate/compress_stream.h"
#include "cvol/mpi.h"

/* Bytes of one broadcast, whose count is an int. */
#define CHUNK ((size_t)1 << 30)

typedef struct processes {
    MPI_Comm comm;
    int rank, size;
} processes;

static void broadcast(uint8_t *bytes, size_t count, int root, MPI_Comm comm)
{
    for (size_t first = 0; first < count; first += CHUNK) {
        const size_t left = count - first;
        MPI_Bcast(bytes + first, (int)(left < CHUNK ? left : CHUNK), MPI_BYTE, root, comm);
    }
}

static int gather(cvol_context *context, void *user, int code, uint8_t **all, size_t *offsets,
                  const void *own, size_t bytes)
{
    processes *p = user;
    uint64_t size = bytes, *sizes = cvol_allocate((size_t)p->size, sizeof *sizes);
    int rank;
    *all = NULL;
    if (!code && !sizes)
        code = cvol_fail_memory(context, (size_t)p->size * sizeof *sizes, "sizes of processes");
    if (!(code = cvol_mpi_agree(context, code, &rank, p->comm))) {
        MPI_Allgather(&size, 1, MPI_UINT64_T, sizes, 1, MPI_UINT64_T, p->comm);
        offsets[0] = 0;
        for (int r = 0; r < p->size; r++)
            offsets[r + 1] = offsets[r] + (size_t)sizes[r];
        *all = cvol_allocate(offsets[p->size] + 1, 1);
        if (!*all)
            code = cvol_fail_memory(context, offsets[p->size], "the results of processes");
        code = cvol_mpi_agree(context, code, &rank, p->comm);
    }
    if (!code && bytes)
        memcpy(*all + offsets[p->rank], own, bytes);
    for (int r = 0; r < p->size && !code; r++)
        broadcast(*all + offsets[r], (size_t)sizes[r], r, p->comm);
    free(sizes);
    return code;
}

int cvol_mpi_compress_stream(cvol_context *context, cvol_compress_report *report, const char *path,
                             const cvol_sample_source *source, const cvol_grid *grid,
                             const cvol_compress_options *options, MPI_Comm comm)
{
    processes p = {.comm = comm};
    MPI_Comm_rank(comm, &p.rank);
    MPI_Comm_size(comm, &p.size);
    cvol_team team = {.rank = p.rank, .size = p.size, .gather = gather, .user = &p};
    return cvol_compress_stream_by_team(context, report, path, source, grid, options, 0,
                                        p.size > 1 ? &team : NULL);
}
