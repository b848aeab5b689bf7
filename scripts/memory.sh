#!/bin/sh
# Runs all commands of tests/failures/commands.py under memcheck of valgrind: no use of memory that is not allocated or
# was not written, no leak, and the same outputs as without valgrind. Unlike the address sanitizer it also sees memory
# that was never written, and libraries. With the kernels of AVX2 and of the base set; valgrind knows no AVX-512.
# usage: scripts/memory.sh FOLDER JOBS [OPTIONS of tests/failures/checked.py]
set -eu
folder=$1
jobs=$2
shift 2
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || {
    echo 'memory: there is no valgrind (scripts/dependencies.sh memory installs it)' >&2
    exit 1
}
export OMP_WAIT_POLICY=passive
cmake -S . -B "$folder" -DCVOL_TESTS=OFF -DCVOL_SETS=tested -DCVOL_SHARED=OFF -DCVOL_EXAMPLES=OFF \
    -DCMAKE_BUILD_TYPE=RelWithDebInfo '-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O1 -g1' >/dev/null
cmake --build "$folder" -j "$jobs" --target cvol_command
status=0
for set in base avx2; do
    echo "memory: the kernels of $set"
    CVOL_CPU=$set python3 -B tests/failures/checked.py "$folder/cvol" "$folder/memory" --valgrind --jobs "$jobs" "$@" ||
        status=1
done
exit "$status"
