#!/bin/sh
# The device of ANARI: see anari_client.c.
# usage: test_anari.sh ANARI_CLIENT LIBRARIES [PICTURE.ppm], with the variables of tests/cli. LIBRARIES: folders of
#        the device and of libanari. ANARI_CLIENT '': there is no SDK.
# shellcheck disable=SC1091,SC2154
client=$1
libraries=$2
picture=${3-}
if [ -z "$client" ]; then
    echo 'skipped: no ANARI-SDK, so the device of ANARI is not built'
    exit 77
fi
. "${0%/*}/../cli/lib.sh"

expect_done cvol compress "$CVOL_SAMPLES/ch2better.nii.gz" brain.cvol
expect_done cvol decompress brain.cvol brain.raw
expect_done env ANARI_LIBRARY=cvol LD_LIBRARY_PATH="$libraries" \
    "$client" brain.cvol brain.raw 301 370 316 ${picture:+"$picture"}
cat "$out"
