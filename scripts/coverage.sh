#!/bin/sh
# Builds with counters of gcov, runs the tests with fewer cases, and reports which lines and branches of src/ they reach:
# by folder, and the lines that none reaches. Kernels are counted for the base set and for the widest set of this
# machine. Tables are left out. Not run: tests of documents and of pages, which run what other tests run; of ITK's
# plugin, which is no part of src/; of the wheel and of installing, which link objects without gcov; and cli_kill, which
# may kill a process while it writes its counters.
# An hour on two processors. With CVOL_COVERAGE_KEEP=yes the counters of earlier runs stay, so that parts add up:
#     scripts/coverage.sh build-coverage 2 'test_.*' && CVOL_COVERAGE_KEEP=yes scripts/coverage.sh build-coverage 2 cli_
# Counters of a source that changed since then are lost.
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
[ -n "${CVOL_COVERAGE_KEEP:-}" ] || find "$folder" -name '*.gcda' -delete
left_out='documents|web|web_site|web_site_files|viewer_browser|viewer_.*_modules|reference|paper_map|tables|pairwise|itk'
ctest --test-dir "$folder" -j "$jobs" -R "$tests" --output-on-failure \
    -E "^($left_out|wheel|cli_install|cli_kill)\$" || echo 'coverage: some tests failed' >&2
scripts/coverage_table.py "$folder" "$folder/coverage.txt"
echo "coverage: $folder/coverage.txt lists the lines that no test reaches; CONTRIBUTING.md says why some remain"
