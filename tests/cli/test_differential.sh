#!/bin/sh
# The library and doc/decoder_ref.py decode random files, and damaged ones, to the same samples, or both refuse them
# (fuzz/differential.py). tests/disagreements has files that one of the two once read in another way.
. "$(dirname "$0")/lib.sh"

python=/usr/bin/python3
[ -x $python ] || python=python3
if ! $python -c 'import numpy' 2>/dev/null; then
    echo 'skipped: the reference decoder (no python3 with numpy)'
    exit 0
fi
root=$(cd "$CVOL_DOC/.." && pwd)
expect_done $python "$root/fuzz/differential.py" "$CVOL_BUILD" "$root"/tests/disagreements/*.cvol
expect_done $python "$root/fuzz/differential.py" "$CVOL_BUILD" 1 10 0 .
grep -q '^. all . 10 . ' "$out" || fail 'must print the number of files'
cat "$out"
