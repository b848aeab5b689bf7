#!/bin/sh
# Options for publications: named views, backgrounds, 16 bits and floats, windows, presets, several volumes in one
# call.
. "$(dirname "$0")/lib.sh"

dims=40x36x32
make_volume in.raw uint8 $dims
expect_done cvol compress in.raw a.cvol --dims $dims --type uint8 --psnr 55

# ---- views ---------------------------------------------------------------------------------------

expect_done cvol decompress a.cvol a.raw
make_nrrd plain.nrrd a.raw uint8 40 36 32
make_nrrd lps.nrrd a.raw uint8 40 36 32 'space: left-posterior-superior' \
    'space directions: (1,0,0) (0,1,0) (0,0,1)'
make_nrrd mirror.nrrd a.raw uint8 40 36 32 'space: left-posterior-superior' \
    'space directions: (-1,0,0) (0,1,0) (0,0,1)'
ray='--engine ray --size 48 --fit box'

# view FILE NAME ANGLES: the named view and the angles give the same picture.
view() {
    expect_done cvol render "$1" -o named.png $ray --view "$2" --json
    expect_equal "$(value_of camera.view)" "$2"
    expect_field camera.mirrored boolean
    expect_done cvol render "$1" -o angles.png $ray $3
    expect_same_file named.png angles.png
}
view plain.nrrd front '--azimuth 0'
view plain.nrrd right '--azimuth 90'
view plain.nrrd back '--azimuth 180'
view plain.nrrd left '--azimuth 270'
view plain.nrrd top '--elevation 90'
view plain.nrrd bottom '--elevation -90'
view lps.nrrd front '--azimuth 0'
view lps.nrrd left '--azimuth 90'
view lps.nrrd right '--azimuth 270'
view lps.nrrd top '--elevation 90 --roll 180'
view lps.nrrd bottom '--elevation -90'
# A file whose first axis runs to the right is rendered without mirroring.
expect_done cvol render mirror.nrrd -o mirror.png $ray --view front --json
expect_equal "$(value_of camera.mirrored boolean)" true
expect_done cvol render mirror.nrrd -o not.png $ray --azimuth 0
expect_other_file mirror.png not.png
# --mirror flips the picture; it flips a mirrored file back.
expect_done cvol render mirror.nrrd -o turned.png $ray --azimuth 0 --mirror --json
expect_equal "$(value_of camera.mirrored boolean)" true
expect_same_file turned.png mirror.png
expect_done cvol render mirror.nrrd -o turned.png $ray --view front --mirror --json
expect_equal "$(value_of camera.mirrored boolean)" false
expect_same_file turned.png not.png
expect_done cvol render mirror.nrrd -o rolled.png $ray --view front --roll 25
expect_done cvol render mirror.nrrd -o turned.png $ray --azimuth 0 --roll -25 --mirror
expect_same_file turned.png rolled.png
expect_failure 2 'cannot mirror a compressed picture' cvol render a.cvol -o x.cvi --engine transform --size 48 --mirror
expect_failure 2 'mirror cannot be combined with --poses' cvol render a.cvol -o x.nrrd --engine fourier --poses p.csv --mirror
# The point of --look-at is in the centre. A shift along the view direction does not change the picture.
expect_done cvol render a.cvol -o moved.png $ray --azimuth 0 --look-at 3,0,-5
expect_other_file moved.png not.png
expect_done cvol render a.cvol -o deeper.png $ray --azimuth 0 --look-at 3,7,-5
expect_same_file deeper.png moved.png
expect_failure 2 '--look-at' cvol render a.cvol -o x.png $ray --look-at 3,nan,0
expect_failure 2 '--up needs --eye' cvol render a.cvol -o x.png --up 1,0,0 --look-at 0,1,0
expect_failure 2 'look_at 0,1e+09,0' cvol render a.cvol -o x.png --look-at 0,1e9,0
expect_done cvol render mirror.nrrd -o mirror.pfm $ray --view front --mode xray --window 100,300
expect_failure 2 'cannot mirror a compressed picture' cvol render mirror.nrrd -o x.cvi --engine transform --size 48 --view front
expect_failure 2 'only one of --view and --azimuth' cvol render a.cvol -o x.png --view front --azimuth 3
expect_failure 2 'only one of --view and --elevation' cvol render a.cvol -o x.png --view top --elevation 3
expect_failure 2 'front back left right top bottom' cvol render a.cvol -o x.png --view above

# ---- backgrounds ---------------------------------------------------------------------------------

for engine in sheet ray splat transform fourier; do
    some="--engine $engine --size 64 --azimuth 30"
    expect_done cvol render a.cvol -o white.png $some --background white
    expect_done cvol render a.cvol -o ones.png $some --background 1,1,1
    expect_same_file white.png ones.png
    expect_done cvol render a.cvol -o black.png $some --background black
    expect_done cvol render a.cvol -o none.png $some
    expect_same_file black.png none.png
    expect_done cvol render a.cvol -o clear.png $some --background transparent
    expect_other_file clear.png black.png
done
expect_failure 2 'cannot be combined with --background transparent' cvol render a.cvol -o x.cvi --engine transform --background transparent
expect_failure 2 'has no opacity' cvol render a.cvol -o x.pfm --background transparent

# ---- 16 bits and floats --------------------------------------------------------------------------

png_head() { od -A n -t u1 -j 24 -N 2 "$1" | tr -s ' ' | sed 's/^ //'; }
some='--size 64x48 --azimuth 30'
for case in '8 composite,8 2' '16 composite,16 2' '16 mip,16 0' '8 mip,8 2'; do
    set -- ${case%,*}
    expect_done cvol render a.cvol -o bits.png $some --bits $1 --mode $2
    expect_equal "$(png_head bits.png)" "${case#*,}"
done
expect_done cvol render a.cvol -o bits.png $some --bits 16 --background transparent
expect_equal "$(png_head bits.png)" '16 6'
expect_done cvol render a.cvol -o bits.png $some --bits 16
expect_done cvol render a.cvol -o bytes.png $some
expect_done cvol compare bits.png bytes.png --json
expect_number "$(value_of psnr_db)" '>' 50
expect_done cvol render a.cvol -o a.pfm $some
expect_equal "$(head -n 1 a.pfm)" PF
expect_equal "$(wc -c <a.pfm)" $((14 + 64 * 48 * 12 - 0))
expect_done cvol render a.cvol -o grey.pfm $some --mode xray --json
expect_equal "$(head -n 1 grey.pfm)" Pf
expect_field grey.0 number
expect_field grey.1 number
expect_failure 2 'must be 8 or 16' cvol render a.cvol -o x.png --bits 12
expect_failure 2 '--bits 16 works only with PNG' cvol render a.cvol -o x.pfm --bits 16
expect_failure 2 'must end in .png' cvol render a.cvol -o x.tiff

# ---- windows and opacities -----------------------------------------------------------------------

for mode in xray mip composite; do
    expect_done cvol render a.cvol -o plain.png $some --mode $mode
    expect_done cvol render a.cvol -o window.png $some --mode $mode --window 120,60
    expect_other_file plain.png window.png
done
expect_done cvol render a.cvol -o mip.png $some --mode mip --window 120,60 --json
expect_near "$(value_of grey.0)" 90 1e-6
expect_near "$(value_of grey.1)" 150 1e-6
expect_done cvol render a.cvol -o auto.png $some --mode mip --window auto --json
expect_number "$(value_of grey.0)" '<' "$(value_of grey.1)"
expect_failure 2 'works only in modes xray, mip and min' cvol render a.cvol -o x.png --window auto
for option in '--view front' --annotate '--background transparent'; do
    expect_failure 2 'cannot be combined with --poses' cvol render a.cvol -o x.nrrd --engine fourier --poses x $option
done
expect_failure 2 'works only with cvol render' cvol bench render a.cvol --background transparent
# A window in units of rescaled values.
expect_done cvol render a.cvol -o meant.png $some --mode mip --rescale 2,-100 --window 140,120
expect_same_file mip.png meant.png
# A file of a transfer function has rescaled values too; a negative factor reverses their order.
echo '{"points": [[90, 1, 0, 0, 0], [120, 1, 1, 0, 0.1], [150, 0, 1, 1, 0.3]]}' >own.json
echo '{"points": [[80, 1, 0, 0, 0], [140, 1, 1, 0, 0.1], [200, 0, 1, 1, 0.3]]}' >twice.json
echo '{"points": [[-150, 0, 1, 1, 0.3], [-120, 1, 1, 0, 0.1], [-90, 1, 0, 0, 0]]}' >less.json
expect_done cvol render a.cvol -o own.png $some --transfer own.json
expect_done cvol render a.cvol -o twice.png $some --transfer twice.json --rescale 2,-100
expect_same_file own.png twice.png
expect_done cvol render a.cvol -o less.png $some --transfer less.json --rescale -1,0
expect_same_file own.png less.png
expect_status 0 cvol render a.cvol -o less.png $some --mode mip --rescale -1,0 --window -120,60
expect_sentence 'mode mip follows the samples, so small values are bright'
expect_same_file mip.png less.png
# A window without samples gives a warning, not a failure.
for mode in mip composite; do
    expect_status 0 cvol render a.cvol -o empty.png $some --mode $mode --window 1e6,10
    expect_sentence 'no sample is in the window'
done
expect_status 0 cvol render a.cvol -o thin.png $some --opacity-scale 0
expect_status 0 cvol render a.cvol -o none.png $some --zoom 0.001
expect_done cvol compare thin.png none.png --json
expect_number "$(value_of psnr_db)" '>' 40
expect_done cvol render a.cvol -o one.png $some --opacity-scale 1
expect_same_file one.png bytes.png

# ---- presets in Hounsfield units -----------------------------------------------------------------

for name in ct-bone ct-skin ct-lung ct-vessels; do
    expect_failure 1 'not Hounsfield units' cvol render a.cvol -o x.png --transfer $name
    expect_done cvol render a.cvol -o $name.png $some --transfer $name --rescale 16,-1000
done
expect_other_file ct-bone.png ct-skin.png
expect_failure 2 'ct-bone' cvol render a.cvol -o x.png --transfer ct
expect_done cvol render a.cvol -o microscopy.png $some --transfer microscopy

# ---- several volumes -----------------------------------------------------------------------------

mkdir in out
cp plain.nrrd in/one.nrrd
cp a.cvol in/two.cvol
cp lps.nrrd 'in/and three.nrrd'
expect_done cvol render in/* -o 'out/{name}.png' --engine ray --size 32 --json
for name in one two 'and three'; do
    [ -s "out/$name.png" ] || fail "out/$name.png must exist"
done
expect_field pictures.2.output string
expect_field failed array
rm out/*
printf 'NRRD0004\n' >in/bad.nrrd
expect_status 1 cvol render in/* -o 'out/{name}.png' --engine ray --size 32
grep -q 'in/bad.nrrd: ' "$err" || fail 'must print its error'
tail -n 1 "$err" | grep -q '^cvol: 1 of 4 volumes failed: in/bad.nrrd$' || fail 'must list what failed'
for name in one two 'and three'; do
    [ -s "out/$name.png" ] || fail "out/$name.png must exist"
done
expect_equal "$(ls out | wc -l)" 3
expect_status 1 cvol render in/* -o 'out/{name}.png' --engine ray --size 32 --json
expect_equal "$(value_of failed.0)" in/bad.nrrd
expect_failure 2 'put {name}' cvol render in/one.nrrd in/two.cvol -o out/x.png
cp plain.nrrd one.nrrd
expect_failure 2 'would both be written' cvol render one.nrrd in/one.nrrd -o 'out/{name}.png'
expect_failure 2 'one volume' cvol render one.nrrd a.cvol -o out.nrrd --engine fourier --poses x
expect_done cvol render one.nrrd -o '{name}-x.png' --engine ray --size 32
[ -s one-x.png ] || fail 'one-x.png must exist'
expect_failure 2 'works only with --turntable' cvol render one.nrrd -o 'x-{n}.png'

# ---- marker values of missing samples ------------------------------------------------------------

# Values are between 0 and 1; 1e35 marks missing samples, which are not rendered.
awk 'BEGIN { srand(1); for (z = 0; z < 40; z++) for (y = 0; y < 40; y++) for (x = 0; x < 40; x++)
    print z < 20 ? "1e35" : sin(x / 6) * cos(y / 9) + z / 40 }' >text.raw
{
    printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 40 40 40\nencoding: ascii\n\n'
    cat text.raw
} >marked.nrrd
for engine in sheet ray; do
    expect_status 0 cvol render marked.nrrd -o mark.png --engine $engine --size 64 --background white
    grep -q 'treated as missing' "$err" || fail 'must report 1e35 as missing'
    expect_done cvol compress marked.nrrd marked.cvol --fill 1e35 --psnr 60
    expect_done cvol render marked.cvol -o filled.png --engine $engine --size 64 --background white
    expect_done cvol compare mark.png filled.png --json
    expect_number "$(value_of psnr_db)" '>' 30
done
# Without --fill the marker would ruin the quality: compress treats it as missing, too, unless --fill says otherwise.
# Lossless files keep it to the bit; their pictures leave it out.
expect_status 0 cvol compress marked.nrrd noise.cvol --psnr 60
expect_sentence 'marked.nrrd: samples of 1e+35, far from all others, are treated as missing; give --fill nan'
cmp noise.cvol marked.cvol || fail 'a marker must be a fill'
expect_done cvol compress marked.nrrd values.cvol --fill nan --psnr 60
cmp -s values.cvol marked.cvol && fail '--fill nan must keep the marker as a value'
expect_status 0 cvol compress marked.nrrd back.cvol --background 0 --psnr 60
expect_sentence 'marked.nrrd: some samples are 1e+35, far from all others; give --fill 1e+35*'
for target in --lossless '--max-error 0.001'; do
    expect_status 0 cvol compress marked.nrrd marked.cvol $target
    expect_sentence 'marked.nrrd: samples of 1e+35, far from all others, are treated as missing; give --fill nan'
    expect_done cvol render marked.cvol -o filled.png --engine ray --size 64 --background white
    expect_done cvol compare mark.png filled.png --json
    expect_number "$(value_of psnr_db)" '>' 40
done
expect_status 0 cvol compress marked.nrrd marked.cvol --lossless
expect_done cvol compress marked.nrrd values.cvol --lossless --fill nan
expect_done cvol decompress marked.cvol marked.raw
expect_done cvol decompress values.cvol values.raw
cmp marked.raw values.raw || fail 'a lossless file must keep markers'
# Next to a marker, NaN stays NaN.
{
    printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 40 40 40\nencoding: ascii\n\n'
    sed '5s/.*/nan/;1000,1020s/.*/inf/' text.raw
} >both.nrrd
expect_status 0 cvol compress both.nrrd both.cvol --psnr 60
expect_sentence 'both.nrrd: samples of 1e+35, far from all others, are treated as missing; give --fill nan'
expect_done cvol compare both.nrrd both.cvol --json
expect_number "$(value_of max_abs_error)" '<' 0.1
# An isosurface of a value outside the range is empty, and render warns.
expect_done cvol compress marked.nrrd marked.cvol --fill 1e35 --psnr 60
expect_status 0 cvol render marked.cvol -o none.png --mode iso --iso 9 --size 32
expect_sentence 'marked.cvol: no surface has the value 9; samples are'

# ---- annotations ---------------------------------------------------------------------------------

for kind in 'a.png' 'a.png --bits 16' 'a.pfm' 'a.png --background transparent' 'a.png --mode mip' \
    'a.png --background white --engine ray' 'a.png --transfer gray --size 900x300'; do
    expect_done cvol render a.cvol --size 128 -o $kind --annotate
    cp "${kind%% *}" with
    expect_done cvol render a.cvol --size 128 -o $kind
    expect_other_file "${kind%% *}" with
done
expect_done cvol render mirror.nrrd -o a.png --view front --annotate --engine ray
expect_done cvol render a.cvol -o 'turn-{n}.png' --size 64 --turntable 2 --annotate
expect_done cvol bake a.cvol -o baked.cvol --transfer hot --axis z
expect_done cvol render baked.cvol -o a.png --engine transform --elevation 90 --annotate
expect_failure 2 'cannot be combined with --annotate' cvol render a.cvol -o x.cvi --engine transform --annotate
