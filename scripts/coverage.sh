#!/bin/sh
# Builds with counters of gcov, runs the tests with fewer cases, and reports which lines and branches of src/ they reach:
# by folder, and the lines that none reaches. Kernels are counted for the base set and for the widest set of this
# machine. Tables are left out. Not run: tests of documents and of pages, which run what other tests run, and of ITK's
# plugin, which is no part of src/.
# An hour on two processors.
# usage: scripts/coverage.sh FOLDER JOBS [TESTS]      TESTS: a regular expression of ctest (default: all)
set -eu
folder=$1
jobs=$2
tests=${3:-.}
cd "$(dirname "$0")/.."
export OMP_WAIT_POLICY=passive
# Counters of threads must not get lost.
cmake -S . -B "$folder" -DCVOL_TESTS=ON -DCVOL_TESTS_FEWER=ON -DCVOL_SETS=machine -DCMAKE_BUILD_TYPE=Debug \
    '-DCMAKE_C_FLAGS_DEBUG=-O1 -g1 --coverage -fprofile-update=atomic' >/dev/null
cmake --build "$folder" -j "$jobs"
find "$folder" -name '*.gcda' -delete
ctest --test-dir "$folder" -j "$jobs" -R "$tests" --output-on-failure \
    -E '^(documents|web|web_site|viewer_browser|viewer_.*_modules|reference|paper_map|tables|pairwise|itk)$' || echo 'coverage: some tests failed' >&2
scripts/coverage_table.py "$folder" "$folder/coverage.txt"
echo "coverage: $folder/coverage.txt lists the lines that no test reaches; CONTRIBUTING.md says why some remain"
