#!/bin/sh
# Builds the page of `cvol export --html` in FOLDER: libcvol as WebAssembly, by emscripten, and the viewer's page.
# usage: scripts/web.sh FOLDER JOBS
# The sources of zlib and libtiff come from Debian's source packages, unless ZLIB_SOURCE and TIFF_SOURCE name folders
# that have them.
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1"
folder=$(cd "$1" && pwd)
jobs=$2
for program in emcc emcmake node; do
    command -v $program >/dev/null || {
        echo "web.sh: there is no $program: install emscripten and Node.js (scripts/dependencies.sh web)" >&2
        exit 1
    }
done
# Debian's emscripten needs Debian's packages for Node, also if another Node is installed.
export NODE_PATH="${NODE_PATH:+$NODE_PATH:}/usr/share/nodejs"

. "$here/scripts/source_package.sh"

zlib=${ZLIB_SOURCE:-$folder/zlib}
tiff=${TIFF_SOURCE:-$folder/tiff}
[ -e "$zlib/zlib.h" ] || fetch zlib
[ -e "$tiff/libtiff/tiffio.h" ] || fetch tiff

emcmake cmake -S "$here/web" -B "$folder" -DCVOL_ZLIB="$zlib" -DCVOL_TIFF="$tiff" \
    ${EMCC_LAUNCHER:+-DCMAKE_C_COMPILER_LAUNCHER="$EMCC_LAUNCHER"} >"$folder/configure.log" 2>&1 || {
    cat "$folder/configure.log" >&2
    exit 1
}
cmake --build "$folder" -j "$jobs"
