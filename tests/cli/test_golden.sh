#!/bin/sh
# Files of every kind that an earlier version made decode to the same bits, with every instruction set. CHECKSUMS names
# volumes without an ending, and pictures and baked volumes, whose pixels or planes it states, with theirs.
. "$(dirname "$0")/lib.sh"

golden=$(cd "$(dirname "$0")/../golden" && pwd)
check_all() { # COMMAND...: runs cvol
    while read -r sum name options; do
        rm -f out.raw
        # shellcheck disable=SC2086  # options are words
        case $name in
        *.*) expect_done decode_planes "$golden/$name" out.raw ;;
        *) expect_done "$@" decompress "$golden/$name.cvol" out.raw $options ;;
        esac
        expect_equal "$name $options $(sha256sum out.raw | cut -d ' ' -f 1)" "$name $options $sum"
    done <"$golden/CHECKSUMS"
}
check_all cvol
CVOL_CPU=base
export CVOL_CPU
check_all cvol
unset CVOL_CPU
for file in "$golden"/*.cv[io]*; do
    expect_done cvol verify "$file"
    grep -q " $(basename "$file" .cvol)" "$golden/CHECKSUMS" || fail "CHECKSUMS must name $(basename "$file")"
done
# Files that lack the bound of every sample have the L2 bound in its place.
expect_done cvol info "$golden/default.cvol" --json
expect_equal "$(value_of point_error)" "$(value_of l2_error)"
expect_number "$(wc -l <"$golden/CHECKSUMS")" '>=' 38
