#!/bin/sh
# The page of cvol export --site opens a file of a slow server (bench/web_url.mjs), with Chromium, Node, npm, and the
# page that make web built.
# usage: bench/web_url.sh CVOL WEB_FOLDER [VOLUME.cvol] [MBIT_PER_SECOND]      default: the brain at 1/30, 10
set -eu
here=$(cd "$(dirname "$0")" && pwd)
cvol=$(realpath "$1")
web=$(realpath "$2")
folder=$web/bench
mkdir -p "$folder" "$here/results"
volume=${3:-$folder/brain.cvol}
[ -e "$volume" ] || "$cvol" compress "$here/../samples/ch2better.nii.gz" "$volume" >/dev/null
"$cvol" export --site "$folder/site" >/dev/null
. "$here/../tests/browser_modules.sh"
install_browser_modules "$here/../tests/viewer" "$folder"
export CVOL_SHOTS="$folder"
node "$here/web_url.mjs" "$folder/site" "$volume" "${4:-10}" | tee "$here/results/web_url.md"
