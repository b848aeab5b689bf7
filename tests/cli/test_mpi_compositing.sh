#!/bin/sh
# Images of several processes put together equal those of one MPI_Reduce, and messages those of the theory
# (tests/mpi/compositing.c).
# shellcheck disable=SC1091,SC2154
. "${0%/*}/lib.sh"
. "${0%/*}/mpi.sh"

# 11 and 13 have no small factors; 14 has 7; 16 has two rounds.
for n in 1 2 3 4 5 7 8 11 13 14 16; do
    expect_status 0 timeout 100 mpirun -n $n "$CVOL_HELPERS/compositing"
done
