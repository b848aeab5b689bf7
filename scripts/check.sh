#!/bin/sh
# Builds twice, with warnings as errors: a release build, and a build with the address and undefined-behaviour
# sanitizers. The sanitized build runs the tests in C with fewer cases, and the tests of the command that
# tests/CMakeLists.txt selects. First it checks the sources with clang-format and
# clang-tidy (scripts/lint.sh); last it fuzzes the readers for 8 seconds each, with fixed random numbers
# (CVOL_FUZZ_SEED).
#
# Short tests run at each check. Tests of more than five seconds (tests/long.txt), sanitized tests and fuzzers run in
# turns, to keep a check short: an eighth of the long tests, and one of PARTS parts of the others. The hash
# of the commit chooses them. PARTS=1 runs all.
# usage: scripts/check.sh FOLDER JOBS [PARTS]
set -eu
folder=$1
jobs=$2
parts=${3:-12}
case $parts in
'' | 0 | *[!0-9]*)
    echo "check: PARTS is '$parts': give a whole number from 1" >&2
    exit 2
    ;;
esac
commit=$(git rev-parse HEAD 2>/dev/null || echo none)
# Also chooses the calls that fail in tests/failures.
CVOL_TURN=$(printf '%s' "$commit" | cksum | cut -d' ' -f1)
export CVOL_TURN
part=$((CVOL_TURN % parts + 1))

# Waiting threads sleep, so that they do not take processors from other tests.
export OMP_WAIT_POLICY=passive
# Ninja builds 16 s sooner than make.
command -v ninja >/dev/null 2>&1 && export CMAKE_GENERATOR="${CMAKE_GENERATOR:-Ninja}"

phase_begin=$(date +%s)
print_duration() { # PHASE: prints the seconds since the end of the last phase
    now=$(date +%s)
    echo "check: $1 took $((now - phase_begin)) s"
    phase_begin=$now
}

configure() { # FOLDER CMAKE_OPTIONS...
    where=$1
    shift
    cmake -S . -B "$where" -DCVOL_WERROR=ON -DCVOL_TESTS=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON "$@" >/dev/null
}

# The programs of the selected tests: test_sheet for test_sheet_avx2.
list_programs() { # FOLDER CTEST_OPTIONS
    # shellcheck disable=SC2086 # the options are several words
    ctest --test-dir "$1" -N $2 | sed -n 's/^ *Test *#[0-9]*: \(test_[a-z0-9_]*\)$/\1/p' |
        sed 's/_\(base\|avx2\|avx512\|neon\)$//' | sort -u
}

build_and_test() { # FOLDER CTEST_OPTIONS CMAKE_OPTIONS...
    where=$1
    selection=$2
    shift 2
    configure "$where" "$@"
    # shellcheck disable=SC2046 # the names are several words
    cmake --build "$where" -j "$jobs" --target all $(list_programs "$where" "$selection")
    print_duration "building $where"
    if [ "$(uname -m)" = x86_64 ] && ! "$where/tests/helpers/with_cpu" avx512 /bin/true; then
        echo "check: the tests *_avx512 are skipped, and other tests do not run the kernels of AVX-512"
    fi
    # shellcheck disable=SC2086 # the options are several words
    ctest --test-dir "$where" --output-on-failure -j "$jobs" $selection
    print_duration "testing $where"
    print_skipped "$where/Testing/Temporary/LastTest.log"
}

# Prints what tests skipped, which ctest does not show of tests that pass: a missing package must not go unseen.
print_skipped() { # LOG
    grep -hE '(^|[ :(])skipped: |^SKIPPED ' "$1" | sed 's/^ *//' | sort | uniq -c | sed 's/^ *\([0-9]*\) /check: \1 x /' || true
}

tests/check_rooms.sh
tests/check_headers.sh
tests/check_contraction.sh
configure "$folder" -DCVOL_SANITIZE=OFF -DCVOL_SETS=tested
scripts/lint.sh "$folder" "$jobs"
print_duration 'clang-format and clang-tidy'
turn=$((CVOL_TURN % 8 + 1))
others=
if [ "$parts" -gt 1 ]; then
    echo "check: part $turn of 8 of the long tests (PARTS=1: all)"
    others="-LE ^turn_[$(echo 12345678 | tr -d $turn)]\$"
fi
build_and_test "$folder" "$others" -DCVOL_SANITIZE=OFF -DCVOL_SETS=tested
# Leaks are errors. The memory limit is above the needs of all tests.
ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1
UBSAN_OPTIONS=print_stacktrace=1
export ASAN_OPTIONS UBSAN_OPTIONS
if [ "$parts" -gt 1 ]; then
    echo "check: part $part of $parts of the sanitized tests and of the fuzzers (PARTS=1: all)"
fi
# With -O1 the checked kernels compile in a third of the time of -O2.
build_and_test "$folder-sanitize" "-I $part,,$parts" -DCVOL_SANITIZE=ON -DCVOL_TESTS_IN_ALL=OFF -DCVOL_SETS=machine -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    '-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O1 -g1'
# A third build, by clang, of the readers and their dependencies.
if command -v clang >/dev/null 2>&1; then
    JOBS=$jobs PART=$part/$parts fuzz/run.sh 8
    print_duration fuzzing
else
    echo 'skipped: no clang, so no reader is fuzzed'
fi
