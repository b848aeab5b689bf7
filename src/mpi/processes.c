/* Teams of processes (processes.h, cvol/mpi.h). */
#include "mpi/processes.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* Bytes of one broadcast, whose count is an int. */
#define CHUNK ((size_t)1 << 30)

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
    cvol_mpi_processes *p = user;
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

cvol_mpi_processes cvol_mpi_processes_of(MPI_Comm comm)
{
    cvol_mpi_processes p = {.comm = comm};
    MPI_Comm_rank(comm, &p.rank);
    MPI_Comm_size(comm, &p.size);
    return p;
}

cvol_team cvol_mpi_team_of(cvol_mpi_processes *processes)
{
    return (cvol_team){
        .rank = processes->rank, .size = processes->size, .gather = gather, .user = processes};
}

/* ---- contexts --------------------------------------------------------------------------- */

struct cvol_mpi_team {
    cvol_mpi_processes processes;
    cvol_team team;
};

int cvol_mpi_team_create(cvol_context *context, cvol_mpi_team **out, MPI_Comm comm)
{
    cvol_mpi_team *team = *out = cvol_allocate_zero(1, sizeof *team);
    if (!team)
        return cvol_fail_memory(context, sizeof *team, "a team of processes");
    team->processes = cvol_mpi_processes_of(comm);
    team->team = cvol_mpi_team_of(&team->processes);
    context->team = team->processes.size > 1 ? &team->team : NULL;
    return CVOL_OK;
}

int cvol_mpi_team_has_failed(const cvol_mpi_team *team)
{
    return team->team.has_failed;
}

void cvol_mpi_team_free(cvol_context *context, cvol_mpi_team *team)
{
    if (team)
        context->team = NULL;
    free(team);
}
