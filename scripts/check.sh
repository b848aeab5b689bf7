#!/bin/sh
# Builds twice, with warnings as errors: as it ships, and with the address and undefined-behaviour sanitizers. The first
# build runs all tests; the sanitized one runs the tests in C, with fewer cases, and those of the command that
# tests/CMakeLists.txt leaves in. Before that clang-format and clang-tidy look at the sources (scripts/lint.sh), at the
# end every reader is fuzzed for 8 seconds, with the same random numbers each time (CVOL_FUZZ_SEED).
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

configure() { # FOLDER CMAKE_OPTIONS...
    where=$1
    shift
    cmake -S . -B "$where" -DCVOL_WERROR=ON -DCVOL_TESTS=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON "$@" >/dev/null
}

build_and_test() { # FOLDER CMAKE_OPTIONS...
    where=$1
    shift
    configure "$where" "$@"
    cmake --build "$where" -j "$jobs"
    say_phase "building $where"
    if [ "$(uname -m)" = x86_64 ] && ! "$where/tests/helpers/with_cpu" avx512 /bin/true; then
        echo "check: the tests *_avx512 are skipped, and other tests leave the kernels of AVX-512 out"
    fi
    ctest --test-dir "$where" --output-on-failure -j "$jobs"
    say_phase "testing $where"
}

tests/check_rooms.sh
tests/check_headers.sh
tests/check_contraction.sh
configure "$folder" -DCVOL_SANITIZE=OFF
scripts/lint.sh "$folder" "$jobs"
say_phase 'clang-format and clang-tidy'
build_and_test "$folder" -DCVOL_SANITIZE=OFF
# Leaks are failures too; and no test needs more memory than this unless it means trouble.
ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1
UBSAN_OPTIONS=print_stacktrace=1
export ASAN_OPTIONS UBSAN_OPTIONS
# At -O1 kernels with checks compile in a third of the time that -O2 takes.
build_and_test "$folder-sanitize" -DCVOL_SANITIZE=ON -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    '-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O1 -g1'
# A third build, by clang, of the readers and what they stand on.
if command -v clang >/dev/null 2>&1; then
    JOBS=$jobs fuzz/run.sh 8
    say_phase fuzzing
else
    echo 'skipped: no clang, so that no reader is fuzzed'
fi
