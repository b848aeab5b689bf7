#!/bin/sh
# --overlay: a second volume over the first, resampled to its axes.
# shellcheck disable=SC1091,SC2086,SC2154
. "${0%/*}/lib.sh"

make_field head.nii.gz head 64x64x60 3 0 0,0,0
make_field turned.nii.gz spots 60x56x58 3.7 35 4,-3,2
make_field same.nii.gz spots 64x64x60 3 0 0,0,0
make_field lps.nrrd spots 64x64x60 3 20 0,0,0 LPS
make_field labels.nii.gz labels 90x90x90 2 35 0,0,0
make_field none.nrrd spots 30x30x30 6 0 0,0,0 none
make_field away.nii.gz spots 20x20x20 3 0 500,0,0
expect_done cvol compress head.nii.gz head.cvol --psnr 50
size=160
[ -z "${CVOL_FEWER-}" ] || size=80
draw() { # OUT OPTIONS...
    lib_out=$1
    shift
    expect_done cvol render head.cvol -o "$lib_out" --size $size "$@"
}
psnr_of() { # A B
    expect_done cvol compare "$1" "$2" --json
    value_of psnr_db
}

# ---- the same function of the world, on any grid, gives the same picture --------------------------

draw plain.png
draw same.png --overlay same.nii.gz
expect_number "$(psnr_of plain.png same.png)" '<' 32
for other in turned.nii.gz lps.nrrd; do
    draw other.png --overlay $other --overlay-window 6,8
    draw own.png --overlay same.nii.gz --overlay-window 6,8
    expect_number "$(psnr_of own.png other.png)" '>=' 40
done
# A coarse overlay is drawn from few samples: 0.3 MB, where the grid of the volume has 1 MB.
make_field coarse.nii.gz spots 22x22x21 9 0 0,0,0
draw coarse.png --overlay coarse.nii.gz --overlay-window 6,8 --memory-limit 0.0005
expect_status 1 cvol render head.cvol -o fine.png --size $size --overlay same.nii.gz --memory-limit 0.0005
make_field half.nii.gz spots 32x32x30 6 0 0,0,0
draw cut.png --overlay same.nii.gz --overlay-window 6,8 --clip 30%:,,
draw half.png --overlay half.nii.gz --overlay-window 6,8 --clip 30%:,,
expect_number "$(psnr_of cut.png half.png)" '>=' 40
expect_done cvol compress turned.nii.gz turned.cvol --psnr 60
draw compressed.png --overlay turned.cvol --overlay-window 6,8
expect_number "$(psnr_of compressed.png own.png)" '>=' 40
for more in '--mode mip' '--mode iso --iso 50' '--view left --clip ,:50%,' '--perspective 40' '--light flat'; do
    draw own.png --overlay same.nii.gz --overlay-window 6,8 $more
    draw other.png --overlay turned.nii.gz --overlay-window 6,8 $more
    draw plain.png $more
    expect_number "$(psnr_of own.png other.png)" '>=' 40
    expect_number "$(psnr_of own.png plain.png)" '<' 39
done
draw ray.png --overlay turned.nii.gz --engine ray --light flat
draw sheet.png --overlay turned.nii.gz --light flat
expect_number "$(psnr_of ray.png sheet.png)" '>=' 30

# Samples without a value are not drawn, if a value far from all others marks them.
make_field marked.nrrd spots 64x64x60 3 0 0,0,0
head -c $((64 * 64 * 4 * 10)) /dev/zero | tr '\000' '\172' >marks.raw # 3e35
expect_done cvol compress marked.nrrd whole.cvol --lossless
expect_done cvol decompress whole.cvol samples.raw
tail -c $((64 * 64 * 4 * 50)) samples.raw >>marks.raw
make_nrrd marked.nrrd marks.raw float 64 64 60 'space: RAS' 'space directions: (3,0,0) (0,3,0) (0,0,3)' \
    'space origin: (-94.5,-94.5,-88.5)'
draw own.png --overlay same.nii.gz --overlay-window 6,8 --view top
draw marks.png --overlay marked.nrrd --overlay-window 6,8 --view top
expect_number "$(psnr_of own.png marks.png)" '>=' 40

# No colours can be fitted to one value.
head -c $((30 * 30 * 30)) /dev/zero >zeros.raw
make_nrrd zeros.nrrd zeros.raw uchar 30 30 30 'space: RAS' 'space directions: (6,0,0) (0,6,0) (0,0,6)' \
    'space origin: (-87,-87,-87)'
draw_zeros() { # OPTIONS...
    expect_status 0 cvol render head.cvol -o zeros.png --size $size --overlay zeros.nrrd "$@"
    expect_sentence 'zeros.nrrd: has only the value 0: nothing of it is drawn'
    expect_number "$(psnr_of plain.png zeros.png)" '>=' 60
}
for more in '--engine ray --light flat' '--mode mip'; do
    draw plain.png $more
    draw_zeros $more
done
draw plain.png
for transfer in hot auto dense; do
    draw_zeros --overlay-transfer $transfer
done
draw zeros.png --overlay zeros.nrrd --overlay-window 0,2
expect_number "$(psnr_of plain.png zeros.png)" '<' 40

# ---- depth and opacity ---------------------------------------------------------------------------

draw plain.png --clip-plane 0,0,-1,-40
draw hidden.png --clip-plane 0,0,-1,-40 --overlay same.nii.gz --overlay-depth 0
draw shallow.png --clip-plane 0,0,-1,-40 --overlay same.nii.gz --overlay-depth 10
draw deep.png --clip-plane 0,0,-1,-40 --overlay same.nii.gz --overlay-depth 1e9
expect_number "$(psnr_of plain.png hidden.png)" '>' "$(psnr_of plain.png shallow.png)"
expect_number "$(psnr_of plain.png shallow.png)" '>' "$(psnr_of plain.png deep.png)"
draw plain.png
draw none.png --overlay same.nii.gz --overlay-opacity 0
expect_number "$(psnr_of plain.png none.png)" '>=' 60
draw half.png --overlay same.nii.gz --overlay-opacity 0.5
draw full.png --overlay same.nii.gz
expect_number "$(psnr_of plain.png half.png)" '>' "$(psnr_of plain.png full.png)"

# ---- labels, several overlays, films --------------------------------------------------------------

draw labels.png --overlay labels.nii.gz --json
expect_equal "$(value_of overlays.0.labels)" true
draw more.png --overlay turned.nii.gz --overlay-transfer viridis --overlay labels.nii.gz --overlay-opacity 0.5 --json
expect_equal "$(value_of overlays.0.input)" turned.nii.gz
expect_number "$(value_of overlays.0.opacity)" '==' 1
expect_number "$(value_of overlays.1.opacity)" '==' 0.5
expect_number "$(value_of overlays.1.depth)" '>' 75
expect_number "$(value_of overlays.1.overlap)" '>' 0.5
draw auto.png --overlay turned.nii.gz --overlay-transfer auto
expect_other_file auto.png same.png
draw noted.png --overlay turned.nii.gz --annotate
draw clear.png --overlay turned.nii.gz --background transparent --bits 16
draw map.png --overlay turned.nii.gz --opacity map.pfm
draw 'turn-{n}.png' --overlay turned.nii.gz --turntable 2
expect_other_file turn-1.png turn-2.png

# ---- refusals ------------------------------------------------------------------------------------

no() { # STATUS PATTERN OPTIONS...
    lib_status=$1
    lib_pattern=$2
    shift 2
    expect_failure "$lib_status" "$lib_pattern" cvol render head.cvol -o x.png "$@"
}
no 2 'none.nrrd: the two grids have no common space' --overlay none.nrrd
no 1 'away.nii.gz: lies outside of head.cvol' --overlay away.nii.gz
no 1 'missing.nii: ' --overlay missing.nii
no 2 '--overlay-window needs --overlay before it' --overlay-window 3,4 --overlay turned.nii.gz
no 2 "--overlay-opacity is '2', must be 0 to 1" --overlay turned.nii.gz --overlay-opacity 2
no 2 "--overlay-depth is '-1', must be" --overlay turned.nii.gz --overlay-depth -1
no 2 "--overlay-window is '3', must be C,W" --overlay turned.nii.gz --overlay-window 3
no 2 "--overlay-window is '1e20,1', its ends must be" --overlay turned.nii.gz --overlay-window 1e20,1
no 2 "--overlay-window is '1e308,1.7e308', its" --overlay turned.nii.gz --overlay-window 1e308,1.7e308
no 2 'does not work with labels' --overlay labels.nii.gz --overlay-window 3,4
no 2 'no transfer function is named' --overlay turned.nii.gz --overlay-transfer rainbow
no 1 'are not Hounsfield units' --overlay turned.nii.gz --overlay-transfer ct-bone
no 2 '--overlay is given more than 4 times' --overlay a --overlay b --overlay c --overlay d --overlay e
for more in '--engine splat' '--engine fourier'; do
    no 2 '--overlay works only with engines sheet and ray' --overlay turned.nii.gz $more
done
for more in --certify --progressive '--budget-ms 100' '--depth depth.pfm' --over-time; do
    no 2 "--overlay cannot be combined with ${more%% *}" --overlay turned.nii.gz $more
done
# Several channels.
cp head.nii.gz second.nii.gz
run cvol compress head.nii.gz second.nii.gz -o two.cvol --as channels
no 2 'two.cvol: has 1 times and 2 channels, but an overlay is one volume' --overlay two.cvol
expect_failure 2 'two.cvol: has several channels' cvol render two.cvol -o x.png --overlay turned.nii.gz
expect_done cvol render two.cvol -o one.png --channel 1 --overlay turned.nii.gz
