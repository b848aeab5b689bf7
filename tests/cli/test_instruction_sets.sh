#!/bin/sh
# Lit pictures do not depend on the instruction set: those of AVX2 are within 4 of 255 of those of the base set.
. "$(dirname "$0")/lib.sh"

if ! "$CVOL_HELPERS/with_cpu" avx2 /bin/true >/dev/null; then
    echo 'skipped: this processor has no AVX2'
    exit 0
fi
expect_done cvol compress "$CVOL_SAMPLES/ch2better.nii.gz" scan.cvol --effort fast
expect_done cvol info scan.cvol --json
expect_equal "$(value_of background)" 0.0 # effort fast finds it, too
expect_done cvol decompress scan.cvol box.nrrd --box 100:180,150:230,100:164
expect_done cvol compress box.nrrd box.cvol
for view in '--azimuth 0 --elevation 0' '--azimuth 35 --elevation 25'; do
    for set in base avx2; do
        CVOL_CPU=$set
        export CVOL_CPU
        expect_done cvol render box.cvol -o $set.png --size 128 $view
    done
    unset CVOL_CPU
    difference=$(python3 "$CVOL_DOC/../scripts/picture_difference.py" base.png avx2.png)
    expect_number "$difference" '<=' 4
done
