#!/bin/sh
# A page of cvol export in a real browser (bench/web.mjs), with Chromium, Node, npm, and the page that make web built.
# usage: bench/web.sh CVOL WEB_FOLDER [VOLUME.cvol] [REPEATS]      default: the brain at 1/30, 5 times
set -eu
here=$(cd "$(dirname "$0")" && pwd)
cvol=$(realpath "$1")
web=$(realpath "$2")
folder=$web/bench
mkdir -p "$folder" "$here/results"
volume=${3:-$folder/brain.cvol}
[ -e "$volume" ] || "$cvol" compress "$here/../samples/ch2better.nii.gz" "$volume" >/dev/null
"$cvol" export --html "$volume" -o "$folder/page.html" >/dev/null
. "$here/../tests/browser_modules.sh"
install_browser_modules "$here/../tests/viewer" "$folder"
export CVOL_SHOTS="$folder"
node "$here/web.mjs" "$folder/page.html" "$web/viewer.html" "$web/cvol_web.wasm" "${4:-5}" | tee "$here/results/web.md"
