#!/bin/sh
# Builds by clang with the thread sanitizer, and looks for races: in tests of parallel parts of the library (each set of
# kernels once, fewer cases), in all commands of tests/failures/commands.py with three threads, and in the viewer's
# requests. libomp tells the sanitizer about its synchronization through libarcher, which it finds next to itself;
# libgomp cannot, so gcc is no choice. 40 minutes on two processors.
# usage: scripts/races.sh FOLDER JOBS [TESTS]     TESTS: a regular expression of ctest
set -eu
folder=$1
jobs=$2
tests=${3:-'^(test_(bricks|series|picture|blocks|convolve_whole|multiply_whole|multiply_low|evaluate_whole|volume_stream|neural|fft|compress|team|jobs|lapped|fourier|spectral|refine|render_exact|renderer|light_bound|certify)|test_(sheet|splat|ray|shade).*|viewer_api_.*)$'}
cd "$(dirname "$0")/.."
for tool in clang python3; do
    command -v $tool >/dev/null || {
        echo "races: there is no $tool" >&2
        exit 1
    }
done
export OMP_WAIT_POLICY=passive
# Calls within libomp and other libraries are not instrumented. A race ends a command with exit 66.
export TSAN_OPTIONS="ignore_noninstrumented_modules=1:${TSAN_OPTIONS-}"
CC=clang CXX=clang++ cmake -S . -B "$folder" -DCVOL_SANITIZE=thread -DCVOL_TESTS=ON -DCVOL_SETS=machine \
    -DCVOL_SHARED=OFF -DCVOL_EXAMPLES=OFF -DCMAKE_BUILD_TYPE=RelWithDebInfo '-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O1 -g1' \
    >/dev/null
cmake --build "$folder" -j "$jobs"
status=0
ctest --test-dir "$folder" -j "$jobs" -R "$tests" --output-on-failure || status=1
python3 -B tests/failures/checked.py "$folder/cvol" "$folder/races" --races --jobs "$jobs" || status=1
exit "$status"
