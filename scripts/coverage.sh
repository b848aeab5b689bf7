#!/bin/sh
# Builds with counters of gcov, runs the tests, and reports which lines and branches of src/ they reach: by folder, and
# the lines that none reaches. Kernels are counted for the widest instruction set of this machine. Tables are left out.
# usage: scripts/coverage.sh FOLDER JOBS [TESTS]      TESTS: a regular expression of ctest (default: all)
set -eu
folder=$1
jobs=$2
tests=${3:-.}
cd "$(dirname "$0")/.."
command -v gcovr >/dev/null || {
    echo 'coverage: there is no gcovr (scripts/dependencies.sh coverage installs it)' >&2
    exit 1
}
export OMP_WAIT_POLICY=passive
# Counters of threads must not get lost.
cmake -S . -B "$folder" -DCVOL_TESTS=ON -DCVOL_SETS=machine -DCMAKE_BUILD_TYPE=Debug \
    '-DCMAKE_C_FLAGS_DEBUG=-O1 -g1 --coverage -fprofile-update=atomic' >/dev/null
cmake --build "$folder" -j "$jobs"
find "$folder" -name '*.gcda' -delete
ctest --test-dir "$folder" -j "$jobs" -R "$tests" --output-on-failure || echo 'coverage: some tests failed' >&2
gcovr --root . --object-directory "$folder" --filter src/ --exclude-throw-branches \
    --exclude '.*\.inc$' --json-summary "$folder/coverage.json" --txt "$folder/coverage.txt" "$folder" -j "$jobs"
python3 - "$folder/coverage.json" <<'END'
import json
import os
import sys

folders = {}
for file in json.load(open(sys.argv[1]))['files']:
    sums = folders.setdefault(os.path.dirname(file['filename']), [0, 0, 0, 0])
    for i, key in enumerate(('line_covered', 'line_total', 'branch_covered', 'branch_total')):
        sums[i] += file[key]
total = [sum(column) for column in zip(*folders.values())]
share = lambda part, of: '%5.1f' % (100 * part / of) if of else '    -'
print('| folder | lines | reached, % | branches | reached, % |\n|---|---:|---:|---:|---:|')
for name, sums in sorted(folders.items()) + [('all', total)]:
    print('| %s | %d | %s | %d | %s |' % (name, sums[1], share(*sums[:2]), sums[3], share(*sums[2:])))
END
echo "coverage: $folder/coverage.txt lists the lines of each file that no test reaches"
