#!/bin/sh
# Builds twice, with warnings as errors: once as it ships, once with the address and undefined-
# behaviour sanitizers; runs all tests on both. Then fuzzes each reader for 8 seconds, of the same numbers each time
# (CVOL_FUZZ_SEED).
# usage: scripts/check.sh FOLDER JOBS
set -eu
folder=$1
jobs=$2

# Threads that wait do so without taking processors from other tests.
export OMP_WAIT_POLICY=passive

phase_begin=$(date +%s)
say_phase() { # WHAT: how long it took, so that one sees where the time goes
    now=$(date +%s)
    echo "check: $1 took $((now - phase_begin)) s"
    phase_begin=$now
}

build_and_test() { # FOLDER CMAKE_OPTIONS...
    where=$1
    shift
    cmake -S . -B "$where" -DCVOL_WERROR=ON -DCVOL_TESTS=ON "$@" >/dev/null
    cmake --build "$where" -j "$jobs"
    say_phase "building $where"
    ctest --test-dir "$where" --output-on-failure -j "$jobs"
    say_phase "testing $where"
}

tests/check_rooms.sh
tests/check_headers.sh
tests/check_contraction.sh
build_and_test "$folder" -DCVOL_SANITIZE=OFF
# Leaks are failures too; and no test needs more memory than this unless it means trouble.
ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1
UBSAN_OPTIONS=print_stacktrace=1
export ASAN_OPTIONS UBSAN_OPTIONS
# Kernels, looked through for undefined behaviour, compile at -O1 in a third of the time that -O2 takes.
build_and_test "$folder-sanitize" -DCVOL_SANITIZE=ON -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    '-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O1 -g1'
# A third build, by clang, of the readers and what they stand on.
if command -v clang >/dev/null 2>&1; then
    JOBS=$jobs fuzz/run.sh 8
    say_phase fuzzing
else
    echo 'skipped: no clang, so that no reader is fuzzed'
fi
