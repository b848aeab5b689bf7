#!/bin/sh
# Every public function, parameter, struct, field and constant is documented: Doxygen makes the reference without a
# warning. Skipped (77) without Doxygen.
# usage: tests/check_reference.sh SOURCE_FOLDER
set -eu
if ! command -v doxygen >/dev/null 2>&1; then
    echo 'skipped: no doxygen'
    exit 77
fi
cd "$1"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
(cat doc/reference/Doxyfile; echo "OUTPUT_DIRECTORY = $folder") | doxygen - >"$folder/messages" 2>&1 || {
    grep -v '^$' "$folder/messages"
    exit 1
}
if [ -s "$folder/messages" ]; then
    cat "$folder/messages"
    exit 1
fi
[ -s "$folder/html/index.html" ]
for page in array_8h render_8h structcvol__grid; do
    [ -s "$folder/html/$page.html" ] || { echo "the reference has no $page.html"; exit 1; }
done
