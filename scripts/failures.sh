#!/bin/sh
# Lets every allocation and every call of the operating system fail once, for all commands of
# tests/failures/commands.py, and prints a table: runs, fault points and findings of each command. Three rounds: one
# thread; a file system without unnamed files; two threads, whose order of calls varies, so that it is a sample. The
# first round also transfers one byte at a time, interrupts calls, and fills the disk after each byte of an output.
# A night on two processors: four of 100 commands, 14,435 runs, took 33 minutes on one.
# usage: scripts/failures.sh BUILD_FOLDER JOBS [OPTIONS of tests/failures/failures.py]
set -eu
build=$1
jobs=$2
shift 2
cvol=$build/cvol
shim=$build/tests/helpers/faults.so
if [ ! -x "$cvol" ] || [ ! -e "$shim" ]; then
    echo "failures: $build has no cvol, or no tests/helpers/faults.so: build with -DCVOL_TESTS=ON on Linux" >&2
    exit 1
fi
status=0
round() { # NAME OPTIONS...
    echo "failures: $1"
    name=$1
    shift
    python3 -B tests/failures/failures.py "$cvol" "$shim" "$build/tests/failures-$name" --jobs "$jobs" --verbose "$@" || status=1
}
round one-thread --all --modes "$@"
round named-files --all --named --family name,open,sync,write "$@"
round two-threads --threads 2 "$@"
exit "$status"
