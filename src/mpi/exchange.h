/* Intermediate images of several processes put together (render/sheet/combine.h): by radix-k
 * compositing (radix_k.h) in a communicator whose ranks are in the order in which the eye sees the
 * parts, because the operator "over" is associative but not commutative. */
#ifndef CVOL_MPI_EXCHANGE_H
#define CVOL_MPI_EXCHANGE_H

#include "mpi/parts.h"
#include "mpi/radix_k.h"
#include "render/sheet/combine.h"

/* Each second of a picture belongs to one stage. */
typedef enum cvol_mpi_stage {
    CVOL_MPI_DRAW, /* also the warp, in the first process */
    CVOL_MPI_WAIT, /* for the other processes */
    CVOL_MPI_COMPOSITE,
    CVOL_MPI_GATHER,
    CVOL_MPI_STAGES
} cvol_mpi_stage;

typedef struct cvol_mpi_exchange {
    cvol_sheet_combine combine;
    MPI_Comm comm, ordered;
    int first;      /* in `ordered`: the rank of process 0 */
    int has_failed; /* all processes know of an error */
    double mark;    /* the time at which the present stage began */
    double seconds[CVOL_MPI_STAGES];
    cvol_mpi_traffic traffic;
} cvol_mpi_exchange;

/* Sets the process's place in the order from front to back: all processes call it. */
void cvol_mpi_exchange_begin(cvol_mpi_exchange *exchange, const cvol_mpi_parts *parts, int place,
                             int first, int is_idle);
void cvol_mpi_exchange_end(cvol_mpi_exchange *exchange);

#endif
