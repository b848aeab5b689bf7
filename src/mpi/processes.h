/* The processes of a communicator as a team (base/team.h). */
#ifndef CVOL_MPI_PROCESSES_H
#define CVOL_MPI_PROCESSES_H

#include "base/team.h"
#include "cvol/mpi.h"

typedef struct cvol_mpi_processes {
    MPI_Comm comm;
    int rank, size;
} cvol_mpi_processes;

cvol_mpi_processes cvol_mpi_processes_of(MPI_Comm comm);
/* The team, which refers to *processes. */
cvol_team cvol_mpi_team_of(cvol_mpi_processes *processes);

#endif
