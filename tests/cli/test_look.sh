#!/bin/sh
# What people type: names of outputs, pictures for the web, colours by name, views by other names, and why a picture is
# empty.
# shellcheck disable=SC1091,SC2154
. "${0%/*}/lib.sh"

make_volume in.raw uint8 40x36x30
expect_done cvol compress in.raw raw.cvol --dims 40x36x30 --type uint8 --lossless
expect_done cvol decompress raw.cvol in.nrrd
expect_done cvol compress in.nrrd a.cvol

# ---- cvol compress IN ----------------------------------------------------------------------------

mkdir sub
cp in.nrrd sub/scan.nrrd
expect_done cvol compress sub/scan.nrrd --lossless
expect_equal "$(ls sub)" 'scan.cvol
scan.nrrd'
expect_done cvol compress in.nrrd other.cvol --lossless
expect_same_file sub/scan.cvol other.cvol
expect_failure 1 'sub/scan.cvol: exists already' cvol compress sub/scan.nrrd
expect_failure 2 'is compressed already' cvol compress a.cvol
expect_failure 2 'give the name of the output' cvol compress 'sub/*.nrrd'
expect_done cvol decompress a.cvol head.nii.gz
expect_done cvol compress head.nii.gz
[ -s head.cvol ] || fail 'head.nii.gz must give head.cvol'
expect_done cvol render a.cvol -o photo.png --size 96
expect_done cvol compress photo.png --psnr 30
[ -s photo.cvi ] || fail 'photo.png must give photo.cvi'
expect_failure 2 '0 of 1 arguments given' cvol compress

# ---- cvol FILE -----------------------------------------------------------------------------------

expect_done cvol a.cvol --help
head -n 1 "$out" | grep -q '^usage: cvol view' || fail 'cvol FILE must be cvol view FILE'
expect_failure 2 'b.cvol: is no file, and no command; see cvol --help' cvol b.cvol

# ---- pictures for the web ------------------------------------------------------------------------

for kind in jpg jpeg webp; do
    expect_done cvol render a.cvol -o a.$kind --size 64 --quality 80
    expect_done cvol render a.cvol -o better.$kind --size 64 --quality 99
    [ "$(wc -c <better.$kind)" -gt "$(wc -c <a.$kind)" ] || fail "a better $kind must be larger"
done
expect_equal "$(od -An -tx1 -N3 a.jpg | tr -d ' ')" ffd8ff
expect_equal "$(od -An -c -N4 a.webp | tr -d ' ')" RIFF
expect_done cvol render a.cvol -o clear.webp --size 64 --background transparent --quality 100
expect_failure 2 'a JPEG has no opacity' cvol render a.cvol -o x.jpg --background transparent
expect_failure 2 'works only with PNG' cvol render a.cvol -o x.jpg --bits 16
expect_failure 2 '--quality is 101, must be 0 to 100' cvol render a.cvol -o x.jpg --quality 101
expect_failure 2 '--quality works only' cvol render a.cvol -o x.png --quality 50
expect_failure 2 '--fps works only' cvol render a.cvol -o x.webp --fps 50
expect_done cvol render a.cvol -o 'turn-{n}.jpg' --size 32 --turntable 2
[ -s turn-2.jpg ] || fail 'a turntable must write JPEGs'

# ---- colours and modes ---------------------------------------------------------------------------

for pair in black:0,0,0 white:1,1,1 red:1,0,0 '#ff0000:1,0,0' grey:0.22,0.23,0.25; do
    expect_done cvol render a.cvol -o named.png --size 48 --background "${pair%:*}"
    expect_done cvol render a.cvol -o numbers.png --size 48 --background "${pair#*:}"
    expect_same_file named.png numbers.png
done
expect_failure 2 '#rrggbb' cvol render a.cvol -o x.png --background reddish
# Where only faces are visible, light would show noise: none by default.
expect_done cvol render a.cvol -o faces.png --transfer dense --size 64
expect_done cvol render a.cvol -o unlit.png --transfer dense --size 64 --light flat
cmp faces.png unlit.png || fail 'an opaque transfer function must have no light by default'
expect_done cvol render a.cvol -o lit.png --transfer dense --size 64 --light studio
expect_other_file lit.png faces.png
# A gradient lies behind what is visible, and does not change opacities.
expect_done cvol render a.cvol -o gradient.png --background gradient --size 64 --opacity with.pfm
expect_done cvol render a.cvol -o black.png --size 64 --opacity without.pfm
cmp with.pfm without.pfm || fail 'a gradient must not be opaque'
expect_other_file gradient.png black.png
expect_done cvol render a.cvol -o plain.png --background gradient --size 64
cmp gradient.png plain.png || fail 'a gradient must not depend on --opacity'
expect_failure 2 'cannot be combined with --background gradient' cvol render a.cvol -o x.cvi --engine transform --background gradient
expect_failure 2 'works only with cvol render' cvol bench render a.cvol --background gradient
expect_done cvol render a.cvol -o plain.png --size 48
expect_done cvol render a.cvol -o viridis.png --size 48 --colormap viridis
expect_other_file plain.png viridis.png
expect_done cvol render a.cvol -o own.png --size 48 --transfer viridis
expect_done cvol render a.cvol -o same.png --size 48 --transfer viridis --colormap viridis
expect_done cvol compare own.png same.png --json
expect_number "$(value_of psnr_db)" '>=' 45
expect_failure 2 'no transfer function is named rainbow' cvol render a.cvol -o x.png --colormap rainbow
expect_failure 2 '--colormap works only with --mode composite' cvol render a.cvol -o x.png --colormap hot --mode mip
expect_done cvol render a.cvol -o lower.png --size 48 --mode mip
expect_done cvol render a.cvol -o upper.png --size 48 --mode MIP
expect_same_file lower.png upper.png

# ---- views ---------------------------------------------------------------------------------------

for pair in anterior:front posterior:back superior:top inferior:bottom coronal:front sagittal:left axial:bottom; do
    expect_done cvol render a.cvol -o one.png --size 48 --view "${pair%:*}"
    expect_done cvol render a.cvol -o two.png --size 48 --view "${pair#*:}"
    expect_same_file one.png two.png
done

# ---- the kind of data, and empty pictures --------------------------------------------------------

expect_done cvol render a.cvol -o kind.png --size 32
grep -q '(auto: ' "$out" || fail 'must name the kind of data'
expect_done cvol render a.cvol -o kind.png --size 32 --json
expect_field kind string
for option in '--look-at 1000,0,0' '--opacity-scale 0'; do
    expect_status 0 cvol render a.cvol -o empty.png --size 32 $option
    grep -q 'the picture is empty' "$err" || fail "$option must state that the picture is empty"
done
echo '{"points": [[1000, 1, 0, 0, 0], [2000, 1, 0, 0, 1]]}' >beyond.json
expect_status 0 cvol render a.cvol -o empty.png --size 32 --transfer beyond.json
grep -q 'shows none of the values' "$err" || fail 'must state the range of the values'
head -c 256 /dev/zero | tr '\0' '\377' >nan.raw
expect_status 0 cvol render nan.raw -o empty.png --size 32 --dims 4x4x4 --type float32
grep -q 'the picture is empty: no sample has a value' "$err" || fail 'must state that all samples are NaN'
echo 'some text' >text.nii.gz
expect_failure 1 'is not a NIfTI file' cvol render text.nii.gz -o x.png

# ---- annotations have room -----------------------------------------------------------------------

expect_done cvol render a.cvol -o plain.png --size 256 --json
zoom=$(value_of camera.zoom)
expect_done cvol render a.cvol -o noted.png --size 256 --annotate --json
expect_number "$(value_of camera.zoom)" '<' "$(awk "BEGIN { print 0.9 * $zoom }")"

# ---- options that change nothing -----------------------------------------------------------------

expect_done cvol compress in.nrrd in.nrrd -o dyes.cvol --as channels
without() { # WORDS OPTION...: the command draws, and a note has the words
    words=$1
    shift
    expect_status 0 cvol render "$@"
    grep -q -e "$words" "$err" || fail "must state: $words"
}
without '--transfer has no effect: mode mip' a.cvol -o mip.png --size 32 --mode mip --transfer hot
without '--transfer has no effect: mode iso' a.cvol -o iso.png --size 32 --mode iso --iso 99 --transfer hot
for option in '--perspective 30' '--level 1' '--oversample 2' '--footprint catmull-rom' '--mode xray'; do
    # shellcheck disable=SC2086
    without '--ray-order image has no effect' a.cvol -o order.png --size 32 --ray-order image $option
done
expect_done cvol render a.cvol -o order.png --size 32 --ray-order image
without '--samples has no effect' a.cvol -o samples.png --size 32 --shade --samples 9
expect_done cvol render a.cvol -o samples.png --size 32 --shade --samples 9 --shadows 0.5
without '--level has no effect' in.nrrd -o level.png --size 32 --engine ray --level 1
expect_done cvol render a.cvol -o level.png --size 32 --engine ray --level 1
expect_failure 2 'give only one of --shade and --light cinematic' cvol render a.cvol -o x.png --shade --light cinematic
for option in '--ambient 0.9' '--samples 9' '--shadows 0.5' --keep-brightness; do
    # shellcheck disable=SC2086
    expect_failure 2 "${option% *} needs a light" cvol render dyes.cvol -o x.png $option
done
expect_done cvol render dyes.cvol -o lit.png --size 32 --ambient 0.9 --light headlight
expect_done cvol render dyes.cvol -o one.png --size 32 --ambient 0.9 --channel 0

# ---- a clip without thickness --------------------------------------------------------------------

expect_failure 2 'leaves no part of the volume, which reaches from 0 to 29' \
    cvol render a.cvol -o x.png --clip ,,29:30
expect_done cvol render a.cvol -o last.png --size 32 --clip ,,28:29
