/* Agreement of processes on success (cvol/mpi.h). */
#include <stdio.h>
#include <string.h>

#include "base/context.h"
#include "cvol/mpi.h"

#define TEXT 1000

int cvol_mpi_agree(cvol_context *context, int code, int *rank, MPI_Comm comm)
{
    int own[2] = {code ? 0 : 1, 0}, first[2], best, length;
    char text[TEXT + MPI_MAX_PROCESSOR_NAME + 40] = "", host[MPI_MAX_PROCESSOR_NAME] = "";
    MPI_Comm_rank(comm, &own[1]);
    MPI_Allreduce(own, first, 1, MPI_2INT, MPI_MINLOC, comm);
    *rank = first[1];
    if (first[0])
        return CVOL_OK;
    MPI_Allreduce(own, &best, 1, MPI_INT, MPI_MAX, comm);
    if (own[1] == first[1] && !best) {
        snprintf(text, sizeof text, "%.*s", TEXT, cvol_context_message(context));
    } else if (own[1] == first[1]) {
        MPI_Get_processor_name(host, &length);
        snprintf(text, sizeof text, "process %d on %s: %.*s", own[1], host, TEXT,
                 cvol_context_message(context));
    }
    MPI_Bcast(text, sizeof text, MPI_CHAR, first[1], comm);
    MPI_Bcast(&code, 1, MPI_INT, first[1], comm);
    return cvol_fail(context, code, "%s", text);
}
