#!/bin/sh
# Compressed files truncated at any length, with flipped bits, or with bytes after their end: cvol refuses each with
# one sentence and writes nothing.
. "$(dirname "$0")/lib.sh"

make_volume in.raw uint8 21x18x9
expect_done cvol compress in.raw packed.cvol --dims 21x18x9 --type uint8 --psnr 32
unpack packed.cvol good.cvol || fail 'must unpack' # its sections are stored separately
size=$(wc -c <good.cvol)
expect_number "$size" '<' 1800
echo old >out.nrrd
cp out.nrrd old.nrrd
cp good.cvol bad.cvol # expect_failure compares the names in the folder

refuse() {
    expect_failure 1 "bad.cvol:*$1" cvol decompress bad.cvol out.nrrd
}

# offset_of TAG: prints the offset of the section with that tag. The section's length follows its tag.
offset_of() {
    LC_ALL=C grep -abo "$1" good.cvol | head -n 1 | cut -d : -f 1
}

# ---- truncated files -----------------------------------------------------------------------------

# Cut near the ends of the signature, the version, and each section's header and content; and at regular steps.
ends='8 12'
for tag in HEAD GEOM ERRS SUMM TABL INDX SHL0 SHL1 SHL2 SHL3 ENDS; do
    at=$(offset_of $tag)
    expect_number "$at" '>=' 12
    ends="$ends $at $((at + 24))"
done
lengths=$(
    for end in $ends $size; do
        for near in -2 -1 0 1 2; do
            [ $((end + near)) -ge "$size" ] || echo $((end + near))
        done
    done
    length=1
    while [ $length -lt "$size" ]; do
        echo $length
        length=$((length + 7))
    done
)
for length in $(echo "$lengths" | sort -nu); do
    head -c "$length" good.cvol >bad.cvol
    refuse ''
done
# No level is complete.
for length in 20 300 $(($(offset_of SHL0) + 30)); do
    head -c $length good.cvol >bad.cvol
    echo old >out.png
    expect_failure 1 'bad.cvol:*truncated' cvol info bad.cvol
    expect_failure 1 'bad.cvol:*truncated' cvol info bad.cvol --json
    expect_failure 1 'bad.cvol:*truncated' cvol render bad.cvol -o out.png
    expect_failure 1 'bad.cvol:*truncated' cvol bench render bad.cvol
    expect_failure 1 'bad.cvol:*truncated' cvol compare good.cvol bad.cvol
    expect_equal "$(cat out.png)" old
    rm out.png
done
# One level is complete: cvol renders that level.
expect_done cvol render good.cvol -o good.png
for length in $(offset_of SHL1) $(($(offset_of SHL3) + 30)) $((size - 1)); do
    head -c $length good.cvol >bad.cvol
    level=$([ $length -eq $((size - 1)) ] && echo 0 || { [ $length -eq $(offset_of SHL1) ] && echo 3 || echo 1; })
    refuse "*truncated*it is whole up to level $level"
    expect_failure 1 "bad.cvol:*it is whole up to level $level" cvol compare good.cvol bad.cvol
    expect_failure 1 "bad.cvol:*it is whole up to level $level" cvol bench render bad.cvol
    expect_status 0 cvol render bad.cvol -o bad.png
    expect_sentence "bad.cvol: the file ends early; drawn at level $level, which is complete"
    expect_done cvol render good.cvol -o level.png --level $level
    expect_same_file bad.png level.png
    expect_done cvol info bad.cvol --json
    expect_equal "$(value_of level) $(value_of whole)" "$level false"
    expect_done cvol info bad.cvol
    rm bad.png level.png
done
expect_done cvol info good.cvol --json
expect_equal "$(value_of level) $(value_of whole)" '0 true'
# A lossless file that ends within its residual is no longer exact, and info reports it.
expect_done cvol compress in.raw exact.cvol --dims 21x18x9 --type uint8 --lossless
cp exact.cvol packed_exact.cvol
unpack packed_exact.cvol exact.cvol || fail 'must unpack'
expect_done cvol info exact.cvol --json
expect_equal "$(value_of max_error) $(value_of residual_missing)" '0.0 false'
head -c $(($(wc -c <exact.cvol) - 30)) exact.cvol >bad.cvol
expect_done cvol info bad.cvol --json
expect_equal "$(value_of level) $(value_of whole) $(value_of residual_missing) $(value_of measured)" '0 false true false'
[ "$(value_of max_error)" != 0 ] || fail 'must not report an exact file'
expect_failure 1 'bad.cvol:*it is whole up to level 0, without the residual that makes it exact' cvol decompress bad.cvol out.raw
expect_status 0 cvol render bad.cvol -o bad.png
expect_sentence 'bad.cvol: the file ends early; drawn without its residual, so samples are not exact'
rm bad.png exact.cvol packed_exact.cvol
expect_failure 2 '--level is 4, must be 0 to 3' cvol render good.cvol -o out.png --level 4
{ cat good.cvol; echo; } >bad.cvol
refuse 'follow the end'

# ---- flipped bits --------------------------------------------------------------------------------

# Flip one bit in bytes at regular steps, each time a different bit. Checksums cover every byte but the version, so
# cvol detects every flip.
bit=1
at=0
flips=0
least=200
stride=1
[ -z "${CVOL_FEWER-}" ] || { least=60 stride=3; }
while [ $at -lt "$size" ]; do
    cp good.cvol bad.cvol
    poke bad.cvol $at xor $bit
    refuse ''
    flips=$((flips + 1))
    bit=$((bit < 128 ? 2 * bit : 1))
    at=$((at + stride * (1 + flips % 4)))
done
expect_number $flips '>=' $least
for at in 8 9 10 11; do
    cp good.cvol bad.cvol
    poke bad.cvol $at u8 200
    refuse 'version'
done

# A section's checksum does not cover its header: lengths beyond the file are detected separately.
for tag in HEAD GEOM ERRS SUMM TABL INDX SHL0 SHL1 SHL2 SHL3 ENDS; do
    for length in 1 -1 2147483648 4611686018427387904; do
        cp good.cvol bad.cvol
        poke bad.cvol $(($(offset_of $tag) + 8)) i64 $length
        refuse "section $tag"
    done
done

expect_same_file out.nrrd old.nrrd
cp good.cvol bad.cvol
expect_done cvol decompress bad.cvol out.nrrd

# ---- packed files --------------------------------------------------------------------------------

# The same for a packed file, which has one section: truncated, flipped, and with bytes after its end.
whole=$size
size=$(wc -c <packed.cvol)
expect_number $((size + 400)) '<' "$whole"
expect_done cvol decompress packed.cvol packed.nrrd
expect_same_file packed.nrrd out.nrrd
rm packed.nrrd
echo old >out.nrrd
length=0
while [ $length -lt "$size" ]; do
    head -c $length packed.cvol >bad.cvol
    refuse ''
    length=$((length + 5))
done
at=0
while [ $at -lt "$size" ]; do
    cp packed.cvol bad.cvol
    poke bad.cvol $at xor 4
    refuse ''
    at=$((at + 3))
done
head -c $((size - 1)) packed.cvol >bad.cvol
refuse '*truncated: section SHL3 at byte *; it is whole up to level 1'
expect_status 0 cvol render bad.cvol -o bad.png
expect_sentence 'bad.cvol: the file ends early; drawn at level 1, which is complete'
rm bad.png
{ cat packed.cvol; echo; } >bad.cvol
refuse "1 bytes follow the end, at byte $size"
expect_same_file out.nrrd old.nrrd
