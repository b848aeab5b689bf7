/* Intermediate images of several processes put together (render/sheet/combine.h). The operator
 * "over" is associative but not commutative, and MPI keeps the order of ranks: so the reduction
 * runs in a communicator whose ranks are in the order in which the eye sees the parts. */
#ifndef CVOL_MPI_EXCHANGE_H
#define CVOL_MPI_EXCHANGE_H

#include "mpi/parts.h"
#include "render/sheet/combine.h"

typedef struct cvol_mpi_exchange {
    cvol_sheet_combine combine;
    MPI_Comm comm, ordered;
    int first;      /* in `ordered`: the rank of process 0 */
    int has_failed; /* all processes know of an error */
} cvol_mpi_exchange;

/* Sets the process's place in the order from front to back: all processes call it. */
void cvol_mpi_exchange_begin(cvol_mpi_exchange *exchange, const cvol_mpi_parts *parts, int place,
                             int first, int is_idle);
void cvol_mpi_exchange_end(cvol_mpi_exchange *exchange);

#endif
