#!/bin/sh
# Files of several volumes as they are, without cvol compress: a 4-D NIfTI, and NRRD files of times and channels.
# shellcheck disable=SC1091,SC2086,SC2154
. "${0%/*}/lib.sh"

for n in 0 1 2; do
    make_field $n.nrrd head 24x22x20 8 $((30 * n)) $((10 * n)),0,0
    expect_status 0 cvol compress $n.nrrd $n.cvol --lossless
    expect_done cvol decompress $n.cvol $n.raw
done
cat 0.raw 1.raw 2.raw >all.raw
expect_done cvol decompress 0.cvol four.nii
cat 1.raw 2.raw >>four.nii
poke four.nii 40 i16 4 48 i16 3 92 f32 1.5 123 u8 10 # three times, a step of 1.5 s
write_nrrd() { # OUT LINES
    printf 'NRRD0004\ntype: uchar\ndimension: 4\nencoding: raw\n%b\n\n' "$2" | cat - all.raw >"$1"
}
write_nrrd times.nrrd 'sizes: 24 22 20 3\nspacings: 8 8 8 1.5\nkinds: domain domain domain time'
write_nrrd channels.nrrd 'sizes: 24 22 20 3\nkinds: domain domain domain vector'

# ---- cvol info -----------------------------------------------------------------------------------

for file in four.nii times.nrrd; do
    expect_done cvol info $file --json
    expect_equal "$(value_of times) $(value_of channels) $(value_of time_values.2)" '3 1 3.0'
    expect_equal "$(value_of dims)" '[24,22,20]'
    expect_done cvol info $file
    grep -q 'times  *3, 0 to 3' "$out" || fail 'must list the times'
    expect_done cvol info $file --time 1
    grep -q 'mean' "$out" || fail 'must describe one time'
done
expect_done cvol info channels.nrrd --json
expect_equal "$(value_of times) $(value_of channels)" '1 3'

# ---- cvol render ---------------------------------------------------------------------------------

expect_status 0 cvol render four.nii -o first.png --size 48
grep -q 'using time 0 of 3; --time chooses another' "$err" || fail 'must print the chosen time'
expect_status 0 cvol render four.nii -o same.png --size 48 --time 0
expect_same_file first.png same.png
expect_status 0 cvol render four.nii -o other.png --size 48 --time 2
expect_other_file first.png other.png
expect_status 0 cvol render times.nrrd -o film.gif --size 32 --over-time
expect_status 0 cvol render channels.nrrd -o colours.png --size 32

# ---- cvol compress -------------------------------------------------------------------------------

expect_done cvol compress times.nrrd -o times.cvol --lossless
expect_done cvol info times.cvol --json
expect_equal "$(value_of times) $(value_of time_values.2)" '3 3.0'
expect_done cvol decompress times.cvol back.raw --time 2
expect_same_file back.raw 2.raw
