/* The parts of a volume (cvol/mpi.h), as a tree of planes. */
#ifndef CVOL_MPI_PARTS_H
#define CVOL_MPI_PARTS_H

#include "cvol/mpi.h"

/* A plane that divides a box, at sample `at` of an axis, between the ranks below and above; a leaf
 * is one rank. */
typedef struct cvol_mpi_node {
    int axis; /* -1: a leaf */
    double at;
    int below, above; /* numbers of nodes; of a leaf: its rank twice */
} cvol_mpi_node;

/* Memory that is kept from picture to picture: new memory would cost page faults. */
typedef struct cvol_mpi_memory {
    void *bytes;
    size_t size;
} cvol_mpi_memory;

struct cvol_mpi_parts {
    MPI_Comm comm; /* a copy of the caller's: its messages do not meet those of the caller */
    int size, rank, count; /* processes, this one, nodes */
    cvol_grid grid;
    cvol_mpi_node *nodes; /* the root first */
    cvol_part *boxes;     /* of each rank */
    struct {
        cvol_mpi_memory runs, values, sent, received;
    } memory; /* of radix_k.h */
};

void cvol_mpi_parts_free_memory(cvol_mpi_parts *parts);

#endif
