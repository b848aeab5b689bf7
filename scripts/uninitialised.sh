#!/bin/sh
# Builds by clang with the memory sanitizer, which finds uses of memory that nobody wrote, and runs all commands of
# tests/failures/commands.py that this build can: it has no libraries but zlib, zstd and jansson, which are instrumented
# too. With the kernels of AVX2 and of the base set: the sanitizer gives false alarms for AVX-512, whose minima and
# maxima it does not follow lane by lane.
# The sources of zlib come from Debian's source package, unless ZLIB_SOURCE names a folder that has them.
# usage: scripts/uninitialised.sh FOLDER JOBS --made-by CVOL [OPTIONS of tests/failures/checked.py]
#        CVOL: one that has all libraries
set -eu
mkdir -p "$1"
folder=$(cd "$1" && pwd)
jobs=$2
shift 2
cd "$(dirname "$0")/.."
. scripts/source_package.sh
for tool in clang python3; do
    command -v $tool >/dev/null || {
        echo "uninitialised: there is no $tool" >&2
        exit 1
    }
done
export OMP_WAIT_POLICY=passive
# A finding ends a command with exit 99.
export MSAN_OPTIONS="exitcode=99:${MSAN_OPTIONS-}"
flags='-fsanitize=memory -fsanitize-memory-track-origins -fno-omit-frame-pointer -g1'
source=${ZLIB_SOURCE:-$folder/zlib}
[ -e "$source/zlib.h" ] || fetch zlib
source=$(cd "$source" && pwd)
[ -e "$folder/instrumented/libz.a" ] || {
    mkdir -p "$folder/instrumented"
    cp "$source/zlib.h" "$source/zconf.h" "$folder/instrumented"
    # shellcheck disable=SC2086
    (cd "$folder/instrumented" && clang $flags -O1 -fPIC -w -DHAVE_UNISTD_H -c "$source"/*.c && ar rcs libz.a ./*.o)
}
cmake -S . -B "$folder" -DCVOL_MINIMAL=ON -DCVOL_TESTS=OFF -DCVOL_SETS=tested -DCVOL_SHARED=OFF -DCVOL_EXAMPLES=OFF \
    -DCMAKE_C_COMPILER=clang -DCMAKE_C_FLAGS="$flags" -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_C_FLAGS_RELWITHDEBINFO=-O1 -DZLIB_LIBRARY="$folder/instrumented/libz.a" \
    -DZLIB_INCLUDE_DIR="$folder/instrumented" >/dev/null
cmake --build "$folder" -j "$jobs" --target cvol_command
status=0
for set in base avx2; do
    echo "uninitialised: the kernels of $set"
    CVOL_CPU=$set python3 -B tests/failures/checked.py "$folder/cvol" "$folder/uninitialised" --uninitialised \
        --jobs "$jobs" "$@" || status=1
done
exit "$status"
