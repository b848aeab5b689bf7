#!/bin/sh
# Every public function, parameter, struct, field and constant is documented: Doxygen makes the reference and warns of
# nothing. Without Doxygen it is skipped (77).
# usage: tests/check_reference.sh SOURCE_FOLDER
set -eu
if ! command -v doxygen >/dev/null 2>&1; then
    echo 'skipped: no doxygen'
    exit 77
fi
cd "$1"
REFERENCE=$(mktemp -d)
export REFERENCE
trap 'rm -rf "$REFERENCE"' EXIT
doxygen doc/reference/Doxyfile >"$REFERENCE/said" 2>&1 || {
    grep -v '^$' "$REFERENCE/said"
    exit 1
}
if [ -s "$REFERENCE/said" ]; then
    cat "$REFERENCE/said"
    exit 1
fi
[ -s "$REFERENCE/html/index.html" ]
for page in array_8h render_8h structcvol__grid; do
    [ -s "$REFERENCE/html/$page.html" ] || { echo "the reference has no $page.html"; exit 1; }
done
