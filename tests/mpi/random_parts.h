/* Random intermediate images of several processes, and the oracle that puts them together: one
 * MPI_Reduce of whole images by an operator that does not commute. */
#ifndef CVOL_TESTS_MPI_RANDOM_PARTS_H
#define CVOL_TESTS_MPI_RANDOM_PARTS_H

#include <mpi.h>

#include "render/sheet/combine.h"
#include "support/random.h"

/* Floats that follow the four lines of a group. */
#define PARTS_BEHIND 2

/* Makes all pixels of an image show nothing. */
void parts_clear(const cvol_sheet_lines *lines, cvol_mode mode);
/* Lets pixel i of group g show something random. */
void parts_set(const cvol_sheet_lines *lines, size_t g, size_t i, cvol_mode mode, random_state *r);
/* A rectangle in which a share of the pixels show something. */
void parts_fill(const cvol_sheet_lines *lines, const size_t begin[2], const size_t end[2],
                double share, cvol_mode mode, random_state *r);

/* The oracle. In `root`, the lines become the whole image. `ordered`: ranks from front to back. */
void parts_reduce(const cvol_sheet_lines *lines, cvol_mode mode, int root, MPI_Comm ordered);

#endif
