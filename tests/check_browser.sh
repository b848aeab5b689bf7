#!/bin/sh
# Runs the browser tests of the viewer's page on the sample scan and keeps screenshots in FOLDER. Skipped (77)
# without Chromium, Node or npm. The first run installs the required npm packages into FOLDER.
# usage: tests/check_browser.sh SOURCE_FOLDER CVOL FOLDER
set -eu
tests=$1/tests/viewer
export CVOL="$2" OMP_WAIT_POLICY=passive PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1
folder=$3
for program in chromium node npm; do
    command -v $program >/dev/null || {
        echo "skipped: there is no $program"
        exit 77
    }
done
CVOL_CHROMIUM=$(command -v chromium)
export CVOL_CHROMIUM CVOL_BROWSER_MODULES="$folder/node_modules" CVOL_SHOTS="$folder/screenshots"

mkdir -p "$folder"
if ! cmp -s "$tests/package-lock.json" "$folder/package-lock.json" || [ ! -e "$folder/complete" ]; then
    rm -rf "$folder/complete" "$CVOL_BROWSER_MODULES"
    cp "$tests/package.json" "$tests/package-lock.json" "$folder"
    (cd "$folder" && npm ci --no-audit --no-fund >npm.log 2>&1) || {
        cat "$folder/npm.log"
        [ -n "${CI-}" ] && exit 1
        echo 'skipped: npm could not install what the tests need'
        exit 77
    }
    : >"$folder/complete"
fi
rm -rf "$CVOL_SHOTS"
for ratio in 30 90; do
    "$CVOL" compress "$1/samples/ch2better.nii.gz" "$folder/brain-$ratio.cvol" --ratio $ratio --fast >/dev/null
done
exec node "$tests/test_browser.mjs" "$folder/brain-30.cvol" "$folder/brain-90.cvol"
