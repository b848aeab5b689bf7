/* Radix-k compositing (Peterka, Goodell, Ross, Shen and Thakur, "A configurable algorithm for
 * parallel image-compositing applications", SC09). The number of processes is a product of factors
 * k, with a round for each. In a round, groups of k processes divide their piece of the image into
 * k pieces; each sends k - 1 of them to the others (direct-send) and merges the k fragments of the
 * piece that it keeps. In the first round a group has consecutive processes in the order from front
 * to back, in the second one of each group of the first, and so on: so all fragments that a process
 * merges are consecutive. In the end each process has one piece of the image.
 *
 * If the number of processes has a factor above CVOL_MPI_MOST_K, some of them first give what they
 * have to their neighbour and take no part. */
#ifndef CVOL_MPI_RADIX_K_H
#define CVOL_MPI_RADIX_K_H

#include "mpi/fragment.h"
#include "mpi/parts.h"

/* The largest factor, and more rounds than an int can need. Peterka et al. found 8 and 16 best on
 * two networks; a larger k means fewer rounds, more messages and no less bytes. */
#define CVOL_MPI_MOST_K 8
#define CVOL_MPI_MOST_ROUNDS 32

typedef struct cvol_mpi_rounds {
    int members; /* the number of processes that take part: the product of the factors */
    int count, factors[CVOL_MPI_MOST_ROUNDS];
} cvol_mpi_rounds;

/* The largest number of members up to `processes` with small factors. */
cvol_mpi_rounds cvol_mpi_rounds_of(int processes);

/* What this process sent, without collective operations. */
typedef struct cvol_mpi_traffic {
    uint64_t messages, bytes;
} cvol_mpi_traffic;

typedef struct cvol_mpi_radix_k {
    cvol_mpi_parts *parts; /* has the communicator and the memory */
    const int *order;      /* the ranks from front to back */
    int place, root;       /* the places in this order of this process, and of rank 0 */
    int member;            /* its number among the members; -1: none */
    cvol_mpi_rounds rounds;
    cvol_mpi_blend blend;
    const cvol_sheet_lines *lines;
    cvol_mpi_span *spans; /* [groups]: what this process shows */
    uint64_t *shown;      /* [groups]: pixels that show something, of all processes */
    size_t *bounds;       /* [members + 1]: piece i has the pixels bounds[i] .. bounds[i + 1] - 1 */
    int piece[2];         /* the fragment is of these pieces: begin, end */
    cvol_mpi_fragment fragment;
    cvol_mpi_run *sent, *received; /* room for the messages of a round */
    cvol_mpi_traffic traffic;
} cvol_mpi_radix_k;

/* Begins; *order and *lines must exist until the end. Errors (MEMORY, LIMIT) are this process's
 * own. */
int cvol_mpi_radix_k_begin(cvol_context *context, cvol_mpi_radix_k *radix_k, cvol_mpi_parts *parts,
                           const int *order, const cvol_sheet_lines *lines, cvol_mode mode);
/* Collective, after all have begun with equal sizes: divides the image into pieces in which
 * processes show about the same number of pixels, and gets the memory for everything that follows,
 * so that nothing that follows can fail. Errors (MEMORY) are this process's own. */
int cvol_mpi_radix_k_divide(cvol_context *context, cvol_mpi_radix_k *radix_k);
/* Collective: all rounds. */
void cvol_mpi_radix_k_composite(cvol_mpi_radix_k *radix_k);
/* Collective: the pieces go into the lines of rank 0. */
void cvol_mpi_radix_k_gather(cvol_mpi_radix_k *radix_k);
/* Frees, after success and failure. */
void cvol_mpi_radix_k_end(cvol_mpi_radix_k *radix_k);

#endif
