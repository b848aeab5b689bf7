#!/bin/sh
# The viewer in a real browser: from a drag to its picture (bench/viewer_browser.mjs), with Chromium, Node and npm.
# usage: bench/viewer_browser.sh CVOL [VOLUME...]      default: the brain at 1/30, and vhf_head of the data folder
set -eu
here=$(cd "$(dirname "$0")" && pwd)
CVOL=$(realpath "$1")
shift
folder=$(dirname "$CVOL")/viewer-browser
mkdir -p "$folder" "$here/results"
if ! [ -e "$folder/node_modules/playwright-core" ]; then
    cp "$here/../tests/viewer/package.json" "$here/../tests/viewer/package-lock.json" "$folder"
    (cd "$folder" && PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1 npm ci --no-audit --no-fund >npm.log 2>&1)
fi
if [ $# -eq 0 ]; then
    "$CVOL" compress "$here/../samples/ch2better.nii.gz" "$folder/brain.cvol" >/dev/null
    set -- "$folder/brain.cvol"
    head="$here/../../shared/data/vhf_head.mha"
    if [ -e "$head" ]; then
        "$CVOL" compress "$head" "$folder/vhf_head.cvol" >/dev/null
        set -- "$@" "$folder/vhf_head.cvol"
    fi
fi
CVOL_CHROMIUM=$(command -v chromium)
export CVOL CVOL_CHROMIUM CVOL_BROWSER_MODULES="$folder/node_modules" CVOL_SHOTS="$folder"
node "$here/viewer_browser.mjs" "$@" | tee "$here/results/viewer_browser.md"
