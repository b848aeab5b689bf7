#!/bin/sh
# cvol evaluate: on the grid of the samples it gives the decoded samples; between them the same on a grid as at single
# points; places outside, and texts that are no points, get a sentence.
. "$(dirname "$0")/lib.sh"

make_volume a.raw float32 40x36x34
make_nrrd a.nrrd a.raw float 40 36 34
expect_done cvol compress a.nrrd lapped.cvol --psnr 40
expect_done cvol compress a.nrrd plain.cvol --psnr 40 --no-lap
expect_done cvol compress a.nrrd background.cvol --psnr 40 --background "$(od -An -tf4 -N4 a.raw | tr -d ' ')"
expect_done cvol compress a.nrrd fill.cvol --psnr 40 --fill "$(od -An -tf4 -j400 -N4 a.raw | tr -d ' ')"
expect_done cvol compress a.nrrd whole.cvol --psnr 40 --block 0
expect_done cvol compress a.nrrd periodic.cvol --psnr 40 --block 0 --transform dft

for file in lapped plain background fill whole periodic; do
    expect_done cvol decompress $file.cvol samples.nrrd
    expect_done cvol evaluate $file.cvol -o same.nrrd --count 40x36x34
    expect_done cvol compare samples.nrrd same.nrrd --json
    expect_number "$(value_of rmse)" '<=' 0.01 # decoded samples are within the range of the original ones

    # A part, a quarter of a sample apart: its geometry, and its values at single points.
    expect_done cvol evaluate $file.cvol -o part.nrrd --start 3.5,7,20.25 --step 0.25,0.5,1 --count 5x4x3 --json
    expect_equal "$(value_of dims)" '[5,4,3]'
    expect_done cvol info part.nrrd --json
    expect_equal "$(value_of spacing)" '[0.25,0.5,1.0]'
    expect_equal "$(value_of origin)" '[3.5,7.0,20.25]'
    expect_done cvol evaluate $file.cvol -o part.raw --start 3.5,7,20.25 --step 0.25,0.5,1 --count 5x4x3
    printf '# the first and the last place\n3.5 7 20.25\n\n4.5,8.5,22.25\n' >points.txt
    expect_done cvol evaluate $file.cvol --points points.txt
    expect_equal "$(wc -l <"$out")" 2
    od -An -v -tf4 -w4 part.raw | tr -d ' ' | sed -n '1p;$p' >expected.txt
    first=$(sed -n 's/^3.5 7 20.25 //p' "$out") last=$(sed -n 's/^4.5 8.5 22.25 //p' "$out")
    expect_near "$first" "$(sed -n 1p expected.txt)" 0.001
    expect_near "$last" "$(sed -n 2p expected.txt)" 0.001
    cvol evaluate $file.cvol --points - --json <points.txt >"$out" 2>"$err" || fail 'must read standard input'
    expect_near "$(value_of values.0)" "$first" 0.001
done

# The nearest sample decides about background and fill.
for place in background:'0 0 0' fill:'20 2 0'; do
    echo "${place#*:}" >points.txt
    expect_done cvol evaluate "${place%:*}.cvol" --points points.txt
    at=$(echo "${place#*:}" | { read -r x y z && echo $((4 * (x + 40 * (y + 36 * z)))); })
    expect_near "$(sed "s/^${place#*:} //" "$out")" "$(od -An -tf4 -j"$at" -N4 a.raw | tr -d ' ')" 0.000001
done

# Without places the grid fills the volume: cells of equal size.
expect_done cvol evaluate lapped.cvol -o half.nrrd --count 20x18x17
expect_done cvol info half.nrrd --json
expect_equal "$(value_of spacing) $(value_of origin)" '[2.0,2.0,2.0] [0.5,0.5,0.5]'
# Whole arrays of periodic functions repeat.
expect_done cvol evaluate periodic.cvol -o here.nrrd --count 4x4x4 --start 1,2,3 --step 0.5,0.5,0.5
expect_done cvol evaluate periodic.cvol -o there.nrrd --count 4x4x4 --start 41,-34,37 --step 0.5,0.5,0.5
expect_done cvol compare here.nrrd there.nrrd --json
expect_number "$(value_of max_abs_error)" '<=' 0.001

expect_failure 2 'either -o OUT or --points FILE' cvol evaluate lapped.cvol
expect_failure 2 'needs --count' cvol evaluate lapped.cvol -o x.nrrd
expect_failure 2 'are for -o OUT' cvol evaluate lapped.cvol --points points.txt --count 2x2x2
expect_failure 2 '--step is 0 along y' cvol evaluate lapped.cvol -o x.nrrd --count 2x2x2 --step 1,0,1
expect_failure 1 'the last place is at x = 40, outside of -0.5 to 39.5' \
    cvol evaluate lapped.cvol -o x.nrrd --count 41x1x1 --start 0,0,0 --step 1,1,1
expect_failure 1 'the first place is at z = -1' \
    cvol evaluate lapped.cvol -o x.nrrd --count 4x1x1 --start 0,0,-1 --step 1,1,1
printf '1 2\n' >few.txt
expect_failure 1 'few.txt: line 1 must have 3 numbers' cvol evaluate lapped.cvol --points few.txt
printf '1 2 3\n1 2 3 4\n' >many.txt
expect_failure 1 'many.txt: line 2 has more than 3 numbers' cvol evaluate lapped.cvol --points many.txt
printf '1 2 nan\n' >nan.txt
expect_failure 1 'nan.txt: line 1 must have 3 numbers' cvol evaluate lapped.cvol --points nan.txt
printf '1 99 3\n' >far.txt
expect_failure 1 'far.txt: line 1 is at y = 99, outside of -0.5 to 35.5' cvol evaluate lapped.cvol --points far.txt
expect_failure 1 'missing.txt: cannot be opened: No such file' cvol evaluate lapped.cvol --points missing.txt
expect_failure 2 "x.unknown" cvol evaluate lapped.cvol -o x.unknown --count 2x2x2
expect_missing() { [ ! -e "$1" ] || fail "$1 must not exist"; }
expect_missing x.nrrd
