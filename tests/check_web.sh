#!/bin/sh
# Builds the page of cvol export in FOLDER/web, where the command finds it, and tests it: the WebAssembly in Node
# against the command, the package of npm, and the page of one file in Chromium and in Firefox; or the page for a web
# server in Chromium: with `site` the files it reads and what it shows, with `site_files` a file that it reads in parts,
# and several files. Skipped (77) without emscripten or Node, and a site without Chromium; without it, the page of one
# file is only made. Several of them may run at the same time.
# usage: tests/check_web.sh SOURCE_FOLDER CVOL BUILD_FOLDER [site|site_files]
set -eu
source=$1 cvol=$2 build=$3 part=${4-}
export OMP_WAIT_POLICY=passive
for program in emcc node; do
    command -v $program >/dev/null || {
        echo "skipped: there is no $program (scripts/dependencies.sh web installs it)"
        exit 77
    }
done
. "$source/tests/browser_modules.sh"
one_by_one "$build/web.lock" "$source/scripts/web.sh" "$build/web" 2 >"$build/web$part.log" 2>&1 || {
    cat "$build/web$part.log"
    exit 1
}
export CVOL_SHOTS="$build/web/test/screenshots"
if [ -n "$part" ]; then
    command -v chromium >/dev/null || {
        echo 'skipped: there is no Chromium'
        exit 77
    }
    folder=$build/web/$part-test
    mkdir -p "$folder"
    "$cvol" export --site "$folder/site"
    install_browser_modules "$source/tests/viewer" "$build/tests/viewer"
fi
if [ "$part" = site_files ]; then
    node "$source/tests/web/test_site_parts.mjs" "$folder/site" "$folder/parts" "$cvol"
    exec node "$source/tests/web/test_site_several.mjs" "$folder/site" "$folder/several" "$cvol"
fi
if [ "$part" = site ]; then
    "$cvol" compress "$source/samples/ch2better.nii.gz" "$folder/whole.cvol" --fast
    "$cvol" decompress "$folder/whole.cvol" "$folder/box.nrrd" --box 60:140,80:150,60:130
    for ending in nii.gz tif mha npy; do
        "$cvol" decompress "$folder/whole.cvol" "$folder/box.$ending" --box 60:140,80:150,60:130
    done
    gzip -dc "$source/tests/volume/vdb/zip.vdb.gz" >"$folder/nine.vdb"
    cp "$source/fuzz/corpus/volume/matlab_bytes.mat" "$folder"
    exec node "$source/tests/web/test_site.mjs" "$folder/site" "$folder" "$cvol"
fi
grep 'viewer.html' "$build/web$part.log" | tail -n 1
folder=$build/web/test
mkdir -p "$folder"
node "$source/tests/web/test_instance.mjs" "$build/web" "$cvol" "$source/samples/ch2better.nii.gz" "$folder"

python=/usr/bin/python3
[ -x $python ] || python=python3
rm -rf "$folder/damaged"
if "$python" -c 'import numpy' 2>/dev/null; then
    "$python" "$source/tests/web/damaged_files.py" "$folder/damaged" 1 8 "$source"/fuzz/corpus/cvol/*.cvol \
        "$source"/tests/golden/*.cvol
    node "$source/tests/web/test_damaged.mjs" "$build/web" "$folder/damaged"
else
    echo 'there is no NumPy: damaged files were not opened'
fi

package=$build/web/npm-test
if command -v npm >/dev/null; then
    node "$source/tests/web/test_npm.mjs" "$build/web" "$cvol" "$source/samples/ch2better.nii.gz" "$package"
    if command -v tsc >/dev/null; then
        cp "$source/tests/web/npm_types.ts" "$package"
        (cd "$package" && tsc --strict --noEmit --target es2022 --module nodenext --moduleResolution nodenext \
            --lib es2022,dom npm_types.ts)
        echo 'the types of the package are right'
    else
        echo 'there is no tsc: the types of the package were not checked'
    fi
else
    echo 'there is no npm: the package was not tested'
fi

"$cvol" export --html "$folder/whole.cvol" -o "$folder/good.html" --title 'A <title>' --caption 'A caption'
cp "$folder/default.cvol" "$folder/broken.cvol"
dd if=/dev/zero of="$folder/broken.cvol" bs=1 seek=6000 count=16 conv=notrunc 2>/dev/null
"$cvol" export --html "$folder/broken.cvol" -o "$folder/broken.html"
command -v chromium >/dev/null || {
    echo 'there is no Chromium: the page was not opened'
    exit 0
}
install_browser_modules "$source/tests/viewer" "$build/tests/viewer"
[ ! -e "$package/node_modules" ] || node "$source/tests/web/test_npm_page.mjs" "$package"
node "$source/tests/web/test_page.mjs" "$folder/good.html" "$folder/broken.html"
firefox=$(command -v firefox-esr || command -v firefox || true)
if [ -n "$firefox" ]; then
    node "$source/tests/web/test_firefox.mjs" "$firefox" "$folder/good.html"
else
    echo 'there is no Firefox: it did not open the page'
fi
