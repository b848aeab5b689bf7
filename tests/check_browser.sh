#!/bin/sh
# Runs the browser tests of the viewer's page on the sample scan and keeps screenshots in FOLDER. Skipped (77)
# without Chromium, Node or npm. The first run installs the required npm packages into FOLDER.
# usage: tests/check_browser.sh SOURCE_FOLDER CVOL FOLDER
set -eu
tests=$1/tests/viewer
export CVOL="$2" OMP_WAIT_POLICY=passive
folder=$3
for program in chromium node npm; do
    command -v $program >/dev/null || {
        echo "skipped: there is no $program"
        exit 77
    }
done
. "$1/tests/browser_modules.sh"
install_browser_modules "$tests" "$folder"
export CVOL_SHOTS="$folder/screenshots"
rm -rf "$CVOL_SHOTS"
for ratio in 30 90; do
    "$CVOL" compress "$1/samples/ch2better.nii.gz" "$folder/brain-$ratio.cvol" --ratio $ratio --fast >/dev/null
done
exec node "$tests/test_browser.mjs" "$folder/brain-30.cvol" "$folder/brain-90.cvol"
