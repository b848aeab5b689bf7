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
for offset in 90 100 110; do
    "$CVOL" decompress "$folder/brain-90.cvol" "$folder/run-$offset.npy" --box 100:164,$offset:$((offset + 60)),90:140 >/dev/null
done
"$CVOL" compress "$folder"/run-90.npy "$folder"/run-100.npy "$folder"/run-110.npy -o "$folder/run.cvol" --time-step 2.5 --fast >/dev/null
"$CVOL" compress "$folder"/run-90.npy "$folder"/run-110.npy -o "$folder/cell.cvol" --as channels \
    --channel-names DAPI,GFP --fast >/dev/null
export CVOL_SERIES="$folder/run.cvol" CVOL_CHANNELS="$folder/cell.cvol"
node "$tests/test_measure.mjs"
exec node "$tests/test_browser.mjs" "$folder/brain-30.cvol" "$folder/brain-90.cvol"
