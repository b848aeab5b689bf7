#!/bin/sh
# cvol verify and cvol info --layout: whole files, and damaged ones told with section and byte.
. "$(dirname "$0")/lib.sh"

make_volume in.raw uint8 21x18x9
raw='--dims 21x18x9 --type uint8'
expect_done cvol compress in.raw good.cvol $raw --ratio 6
expect_done cvol compress in.raw whole.cvol $raw --transform dft --block 0 --keep 3,20
expect_done cvol compress in.raw cells.cvol $raw --transform dht --block 8 --keep 3,20
size=$(wc -c <good.cvol)

# ---- verify ---------------------------------------------------------------------------------

expect_done cvol verify good.cvol
expect_equal "$(cat "$out")" "good.cvol: whole, 4 sections, $size bytes"
expect_done cvol verify good.cvol whole.cvol cells.cvol
expect_equal "$(wc -l <"$out")" 3
grep -q '^whole.cvol: whole, 2 sections, ' "$out" || fail 'must tell of each file'
expect_done cvol verify good.cvol whole.cvol --json
expect_equal "$(value_of whole boolean)" true
expect_equal "$(value_of damaged_files)" 0
expect_equal "$(value_of files.1.file)" whole.cvol
expect_equal "$(value_of files.0.sections)" 4
expect_equal "$(value_of files.0.file_bytes)" "$size"
expect_equal "$(value_of files.0.damage)" null

# More files than there are places for arguments of other commands.
set --
for i in 1 2 3 4 5 6 7 8 9 10 11 12; do set -- "$@" good.cvol; done
expect_done cvol verify "$@"
expect_equal "$(wc -l <"$out")" 12

# Damage in the middle of others: all are looked at.
cp good.cvol bad.cvol
poke bad.cvol $((size - 5)) xor 16
expect_status 1 cvol verify good.cvol bad.cvol whole.cvol
expect_sentence 'bad.cvol: section DATA at byte '*'group 0 of 1, '*' bytes from byte '*'checksum is '
expect_equal "$(wc -l <"$out")" 2
expect_status 1 cvol verify bad.cvol good.cvol missing.cvol --json
expect_equal "$(wc -l <"$err")" 2
expect_equal "$(value_of whole)" false
expect_equal "$(value_of damaged_files)" 2
expect_equal "$(value_of files.0.whole)" false
expect_field files.0.damage string
expect_equal "$(value_of files.1.whole)" true
expect_equal "$(value_of files.2.whole)" false

for at in 0 5 8 11 12 17 25 30 40 200 330 350 370 400; do
    cp good.cvol bad.cvol
    poke bad.cvol $at xor 1
    expect_failure 1 'bad.cvol: '*'byte ' cvol verify bad.cvol
done
for length in 1 7 8 11 12 31 32 100 327 328 340 $((size - 1)); do
    head -c $length good.cvol >bad.cvol
    expect_failure 1 'bad.cvol: truncated: ' cvol verify bad.cvol
done
{ cat good.cvol; echo; } >bad.cvol
expect_failure 1 "bad.cvol: 1 bytes follow the end, at byte $size" cvol verify bad.cvol
expect_failure 1 'in.raw: is not a .cvol file: byte 0 is ' cvol verify in.raw
expect_failure 1 'missing.cvol: No such file' cvol verify missing.cvol
expect_failure 2 '0 of 1 arguments given; usage: cvol verify' cvol verify

# ---- info --layout --------------------------------------------------------------------------

expect_done cvol info good.cvol --layout
expect_equal "$(wc -l <"$out")" 6
expect_equal "$(awk 'NR > 2 { printf "%s ", $1 }' "$out")" 'HEAD RNGE INDX DATA '
expect_equal "$(awk 'NR > 2 { printf "%s ", $4 }' "$out")" 'sound sound sound sound '
expect_equal "$(awk 'NR == 3 { print $2, $3 }' "$out")" '12 296'
expect_done cvol info whole.cvol --layout
expect_equal "$(awk 'NR > 2 { printf "%s ", $1 }' "$out")" 'HEAD SPEC '
expect_done cvol info good.cvol --layout --json
expect_equal "$(value_of version)" 0
expect_equal "$(value_of file_bytes)" "$size"
expect_equal "$(value_of sections.3.tag)" DATA
expect_equal "$(value_of sections.3.checksum)" sound
expect_field sections.3.content string
expect_equal $(($(value_of sections.3.offset) + 20 + $(value_of sections.3.length))) "$size"

# Of a damaged file: what is there, and what is wrong.
cp good.cvol bad.cvol
poke bad.cvol $(($(value_of sections.2.offset) + 21)) xor 4
expect_status 1 cvol info bad.cvol --layout
expect_sentence 'bad.cvol: section INDX at byte '
expect_equal "$(awk 'NR > 2 { printf "%s ", $4 }' "$out")" 'sound sound damaged not '
expect_status 1 cvol info bad.cvol --layout --json
expect_equal "$(value_of sections.2.checksum)" damaged
expect_equal "$(value_of sections.3.checksum)" 'not checked'
head -c $((size - 1)) good.cvol >bad.cvol
expect_status 1 cvol info bad.cvol --layout
expect_sentence 'bad.cvol: truncated: section DATA at byte '
expect_equal "$(awk 'NR == 6 { print $4 }' "$out")" truncated
expect_failure 1 'in.raw: is not a .cvol file' cvol info in.raw --layout
expect_failure 2 '--layout is for .cvol files' cvol info in.raw $raw --layout
