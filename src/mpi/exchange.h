/* Intermediate images of several processes put together (render/sheet/combine.h), by radix-k
 * compositing (radix_k.h). */
#ifndef CVOL_MPI_EXCHANGE_H
#define CVOL_MPI_EXCHANGE_H

#include <time.h>

#include "mpi/parts.h"
#include "mpi/radix_k.h"
#include "render/sheet/combine.h"

/* Each second of a picture belongs to one stage. */
typedef enum cvol_mpi_stage {
    CVOL_MPI_DRAW, /* and the warp of all tiles but the last */
    CVOL_MPI_WAIT, /* for the other processes */
    CVOL_MPI_COMPOSITE,
    CVOL_MPI_GATHER,
    CVOL_MPI_WARP,
    CVOL_MPI_STAGES
} cvol_mpi_stage;

typedef struct cvol_mpi_exchange {
    cvol_sheet_combine combine;
    cvol_mpi_parts *parts;
    const int *order; /* ranks from front to back */
    int has_failed;   /* all processes know of an error */
    double mark;      /* the time at which the present stage began */
    double seconds[CVOL_MPI_STAGES];
    clock_t cpu_mark; /* the processor time at which it began */
    double draw_cpu;  /* seconds of processor time in CVOL_MPI_DRAW */
    cvol_mpi_traffic traffic;
} cvol_mpi_exchange;

/* order: the ranks of the parts from front to back, as the eye sees them; it is not copied. */
void cvol_mpi_exchange_begin(cvol_mpi_exchange *exchange, cvol_mpi_parts *parts, const int *order,
                             int is_idle);
/* Ends the last stage. */
void cvol_mpi_exchange_end(cvol_mpi_exchange *exchange);
/* The report of the picture: collective, so only when all processes know that none has failed. */
void cvol_mpi_exchange_report(cvol_mpi_render_report *report, const cvol_mpi_exchange *exchange);

#endif
