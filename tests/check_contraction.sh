#!/bin/sh
# The fuzzers' build must not contract products and sums to fused operations, as CMake's build: a contracting build
# encodes other files.
set -eu
cd "$(dirname "$0")/.."
grep -q -e '-ffp-contract=off' cmake/flags.cmake
if ! sed -n 's/^address="//p' fuzz/run.sh | grep -q -e '-ffp-contract=off'; then
    echo 'fuzz/run.sh: its compiler flags lack -ffp-contract=off, which cmake/flags.cmake has'
    exit 1
fi
echo 'contraction: the same in both builds'
