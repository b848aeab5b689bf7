#!/bin/sh
# Images of several processes put together equal those of one MPI_Reduce, and messages those of the theory
# (tests/mpi/compositing.c).
# shellcheck disable=SC1091,SC2154
. "${0%/*}/lib.sh"
. "${0%/*}/mpi.sh"

# 11 and 13 are not products of small factors; 14 has 7; 16 has two rounds.
counts='1 2 3 4 5 7 8 11 13 14 16'
# Waiting processes of Debian's MPICH do not give up their processor: 8 on 2 processors take minutes.
if mpirun --version 2>/dev/null | grep -q HYDRA; then counts='1 2 3 4'; fi
for n in $counts; do
    expect_status 0 timeout 100 mpirun -n $n "$CVOL_HELPERS/compositing"
done
