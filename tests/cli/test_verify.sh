#!/bin/sh
# cvol verify and cvol info --layout: sound files, and damaged files with section and byte of the damage.
. "$(dirname "$0")/lib.sh"

make_volume in.raw uint8 21x18x9
raw='--dims 21x18x9 --type uint8'
expect_done cvol compress in.raw packed.cvol $raw --psnr 40
unpack packed.cvol good.cvol || fail 'must unpack' # its sections are stored separately
expect_done cvol compress in.raw whole.cvol $raw --transform dft --block 0 --keep 3,20
expect_done cvol compress in.raw cells.cvol $raw --transform dht --block 8 --keep 3,20
size=$(wc -c <good.cvol)

# ---- verify --------------------------------------------------------------------------------------

expect_done cvol verify good.cvol
expect_equal "$(cat "$out")" "good.cvol: whole, 12 sections, $size bytes"
expect_done cvol verify good.cvol whole.cvol cells.cvol
expect_equal "$(wc -l <"$out")" 3
grep -q '^whole.cvol: whole, 5 sections, ' "$out" || fail 'must print each file'
expect_done cvol verify good.cvol whole.cvol --json
expect_equal "$(value_of whole boolean)" true
expect_equal "$(value_of damaged_files)" 0
expect_equal "$(value_of files.1.file)" whole.cvol
expect_equal "$(value_of files.0.sections)" 12
expect_equal "$(value_of files.0.file_bytes)" "$size"
expect_equal "$(value_of files.0.damage)" null

# More files than other commands accept as arguments.
set --
for i in 1 2 3 4 5 6 7 8 9 10 11 12; do set -- "$@" good.cvol; done
expect_done cvol verify "$@"
expect_equal "$(wc -l <"$out")" 12

# One damaged file between sound ones: all files are checked.
cp good.cvol bad.cvol
poke bad.cvol $((size - 29)) xor 16
expect_status 1 cvol verify good.cvol bad.cvol whole.cvol
expect_sentence 'bad.cvol: section SHL3 at byte '*'run 0 of 1, '*' bytes from byte '*'checksum is '
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

# ---- info --layout -------------------------------------------------------------------------------

expect_done cvol info good.cvol --layout
expect_equal "$(wc -l <"$out")" 14
expect_equal "$(awk 'NR > 2 { printf "%s ", $1 }' "$out")" 'HEAD GEOM ERRS TRUE SUMM TABL INDX SHL0 SHL1 SHL2 SHL3 ENDS '
expect_equal "$(awk 'NR > 2 { printf "%s ", $4 }' "$out")" 'sound sound sound sound sound sound sound sound sound sound sound sound '
expect_equal "$(awk 'NR == 3 { print $2, $3 }' "$out")" '12 88'
expect_done cvol info whole.cvol --layout
expect_equal "$(awk 'NR > 2 { printf "%s ", $1 }' "$out")" 'HEAD GEOM ERRS SPEC ENDS '
expect_done cvol info good.cvol --layout --json
expect_equal "$(value_of version)" 1
expect_equal "$(value_of level)" 0
expect_equal "$(value_of file_bytes)" "$size"
expect_equal "$(value_of sections.11.tag)" ENDS
expect_equal "$(value_of sections.11.checksum)" sound
expect_field sections.11.content string
expect_field sections.11.required boolean
expect_equal $(($(value_of sections.11.offset) + 24 + $(value_of sections.11.length))) "$size"

# A damaged file: the list of its sections, and the damage.
cp good.cvol bad.cvol
poke bad.cvol $(($(value_of sections.6.offset) + 25)) xor 4
expect_status 1 cvol info bad.cvol --layout
expect_sentence 'bad.cvol: section INDX at byte '
expect_equal "$(awk 'NR > 2 { printf "%s ", $4 }' "$out")" 'sound sound sound sound sound sound damaged not not not not sound '
expect_status 1 cvol info bad.cvol --layout --json
expect_equal "$(value_of sections.6.checksum)" damaged
expect_equal "$(value_of sections.7.checksum)" 'not checked'
expect_equal "$(value_of level)" null
head -c $((size - 30)) good.cvol >bad.cvol
expect_status 1 cvol info bad.cvol --layout
expect_sentence 'bad.cvol: truncated: section SHL3 at byte '
expect_equal "$(awk 'NR == 13 { print $1, $4 }' "$out")" 'SHL3 truncated'
expect_failure 1 'in.raw: is not a .cvol file' cvol info in.raw --layout
expect_failure 2 '--layout reads .cvol files' cvol info in.raw $raw --layout

# ---- packed files --------------------------------------------------------------------------------

# A small file has one packed section; the list shows the sections inside it.
size=$(wc -c <packed.cvol)
expect_done cvol verify packed.cvol
expect_equal "$(cat "$out")" "packed.cvol: whole, 12 sections, $size bytes"
expect_done cvol info packed.cvol --layout
expect_equal "$(awk 'NR > 2 { printf "%s ", $1 }' "$out")" 'PACK HEAD GEOM ERRS TRUE SUMM TABL INDX SHL0 SHL1 SHL2 SHL3 '
expect_equal "$(awk 'NR > 2 { printf "%s ", $4 }' "$out")" 'sound sound sound sound sound sound sound sound sound sound sound sound '
expect_equal "$(awk 'NR == 3 { print $2, $3 }' "$out")" "12 $((size - 36))"
expect_equal "$(awk 'NR == 4 { print $2, $3 }' "$out")" '12 88'
expect_equal "$(awk 'NR == 14 { print $2 + $3 }' "$out")" "$size"
for at in 0 5 8 11 12 17 25 30 36 40 60 90; do
    cp packed.cvol bad.cvol
    poke bad.cvol $at xor 1
    expect_failure 1 'bad.cvol: '*'byte ' cvol verify bad.cvol
done
cp packed.cvol bad.cvol
poke bad.cvol 50 xor 1
expect_failure 1 'bad.cvol: section PACK at byte 12: checksum is ' cvol verify bad.cvol
cp packed.cvol bad.cvol
poke bad.cvol $((size - 5)) xor 16
expect_failure 1 'bad.cvol: section SHL3 at byte '*'run 0 of 1, '*' bytes from byte '*'checksum is ' cvol verify bad.cvol
for length in 1 7 8 11 12 31 32 100 $((size - 1)); do
    head -c $length packed.cvol >bad.cvol
    expect_failure 1 'bad.cvol: truncated: ' cvol verify bad.cvol
done
head -c $((size - 3)) packed.cvol >bad.cvol
expect_status 1 cvol info bad.cvol --layout
expect_sentence 'bad.cvol: truncated: section SHL3 at byte '
expect_equal "$(awk 'NR == 3 || NR == 14 { print $1, $4 }' "$out" | tr '\n' ' ')" 'PACK truncated SHL3 truncated '
