#!/bin/sh
# Engine fourier: pictures, stacks of projections, and invalid lists of poses.
. "$(dirname "$0")/lib.sh"

dims=44x40x36
raw="--dims $dims --type uint8"
make_volume in.raw uint8 $dims
expect_done cvol compress in.raw a.cvol $raw --psnr 55
expect_done cvol decompress a.cvol dense.nrrd

# ---- pictures ------------------------------------------------------------------------------------

view='--size 128 --azimuth 30 --elevation 20'
expect_done cvol render dense.nrrd -o ray.png $view --engine ray --mode xray --step 0.25
for file in a.cvol dense.nrrd; do
    expect_done cvol render $file -o fourier.png $view --engine fourier --json
    expect_equal "$(value_of engine)" fourier
    expect_equal "$(value_of mode)" xray
    expect_field fourier.padded array
    expect_number "$(value_of fourier.bytes)" '>' 100000
    expect_done cvol compare ray.png fourier.png --json
    expect_number "$(value_of psnr_db)" '>=' 40
done
for option in '--azimuth 31' '--elevation 21' '--roll 10' '--zoom 1.5' '--background 1,0.5,0' \
    '--size 128x100' '--depth-cue 0.7' '--rho 0.05'; do
    expect_done cvol render dense.nrrd -o after.png $view --engine fourier $option
    expect_other_file fourier.png after.png
done
for threads in 1 3; do
    expect_done cvol render dense.nrrd -o threads$threads.png $view --engine fourier --threads $threads
done
expect_same_file threads1.png threads3.png
expect_done cvol bench render a.cvol --views 2 --repeat 1 --size 64 --engine fourier --json
expect_equal "$(value_of mode)" xray

# ---- stacks --------------------------------------------------------------------------------------

cat >angles.csv <<'END'
azimuth, elevation, roll
# the front, the top

0, 0, 0
0;90;0      # another separator
30	20 10
END
printf 'w,x,y,z\r\n0.70710678118654757,0.70710678118654757,0,0\r\n3,0,0,0\r\n' >turns.csv
project='cvol render a.cvol --engine fourier --size 40x30'
expect_done $project --poses angles.csv -o angles.nrrd --json
expect_equal "$(value_of poses)" 3
expect_number "$(value_of pixel)" '>' 0
for field in output:string width:integer height:integer load_ms:number render_ms:number threads:integer; do
    expect_field "${field%:*}" "${field#*:}"
done
expect_done $project --poses turns.csv -o turns.raw
expect_equal "$(wc -c <turns.raw)" 9600
expect_equal "$(wc -l <"$out")" 1
expect_done cvol info angles.nrrd --json
expect_equal "$(value_of dims.0)x$(value_of dims.1)x$(value_of dims.2)" 40x30x3
expect_equal "$(value_of type)" float32
# The same two directions as angles and as quaternions.
expect_done $project --poses angles.csv -o angles.raw
dd if=angles.raw of=two.raw bs=4800 count=2 2>"$top/dd"
expect_done cvol compare two.raw turns.raw --dims 40x30x2 --type float32 --json
expect_number "$(value_of psnr_db)" '>' 80
for threads in 1 3; do
    expect_done $project --poses angles.csv -o stack$threads.mha --threads $threads
done
expect_same_file stack1.mha stack3.mha
expect_done $project --poses angles.csv -o sums.raw --integrals
expect_other_file sums.raw angles.raw
# Numbered pictures: the same pictures as single renders.
expect_done cvol render a.cvol --engine fourier --size 40x30 --poses angles.csv -o 'p-{n}.png' --json
expect_equal "$(value_of poses)" 3
expect_done cvol render a.cvol --engine fourier --size 40x30 -o one.png --fit box --azimuth 30 --elevation 20 --roll 10
expect_done cvol compare one.png p-3.png --json
expect_number "$(value_of psnr_db)" '>' 60
expect_done $project --poses angles.csv -o 'w-{n}.png' --window 0,100 --bits 16
expect_other_file p-3.png w-3.png
expect_done $project --poses angles.csv -o 'i-{n}.png' --window 0,3000 --integrals
for n in 1 2 3; do
    [ -s i-$n.png ] || fail "i-$n.png must be there"
done
expect_failure 2 'numbered pictures' $project --poses angles.csv -o p.png
expect_failure 2 'give --window C,W' $project --poses angles.csv -o 'x-{n}.png' --integrals
expect_failure 2 'window works only with pictures' $project --poses angles.csv -o x.nrrd --window 0,100
expect_failure 2 'bits works only with pictures' $project --poses angles.csv -o x.nrrd --bits 16
# Many poses are rendered in batches.
awk 'BEGIN { for (i = 0; i < 1000; i++) print i * 0.7, i % 180 - 90, i }' >many.csv
expect_done cvol render a.cvol --engine fourier --size 32 --poses many.csv -o many.raw
expect_equal "$(wc -c <many.raw)" 4096000

# ---- refused lists and options -------------------------------------------------------------------

# expect_bad_pose LINE VALUE TEXT: the message names the file, the line and the value.
expect_bad_pose() {
    printf "$3" >bad.csv
    expect_failure 1 "bad.csv: line $1*$2" $project --poses bad.csv -o bad.nrrd
}
expect_bad_pose 2 "'x'" '0,0,0\n1,x,3\n'
expect_bad_pose 3 "'nan'" '# of\n0 0 0\nnan 0 0\n'
expect_bad_pose 1 "'inf'" 'inf,0,0\n'
expect_bad_pose 1 "'1e999'" '0,1e999,0\n'
expect_bad_pose 2 2 '1,2,3\n1,2\n'
expect_bad_pose 1 5 '1,2,3,4,5\n'
expect_bad_pose 2 4 '1,2,3\n1,2,3,4\n'
expect_bad_pose 1 0,0,0,0 '0,0,0,0\n'
expect_bad_pose 2 'zero byte' '1,2,3\n1,2,\0003\n'
printf '# none\n\n' >bad.csv
expect_failure 1 'bad.csv: has no poses' $project --poses bad.csv -o bad.nrrd
expect_failure 1 'missing.csv: ' $project --poses missing.csv -o bad.nrrd
expect_failure 1 'same file' $project --poses angles.csv -o angles.csv
expect_failure 2 'x.png: --poses writes a volume' $project --poses angles.csv -o x.png
expect_failure 2 'x.doc' $project --poses angles.csv -o x.doc
expect_failure 2 'must end in .png' $project -o x.nrrd
expect_failure 2 '--integrals needs --poses' $project -o x.png --integrals
expect_failure 2 '--poses works only with engine fourier' cvol render a.cvol --poses angles.csv -o x.nrrd
