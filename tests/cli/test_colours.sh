#!/bin/sh
# Colour volumes (RGB and RGBA): pictures have the colours of the samples, from every input format and from the
# compressed file. Also: the stored channel information, alpha, and the choice of one channel.
tests=$(cd "$(dirname "$0")/.." && pwd)
. "$(dirname "$0")/lib.sh"

python=/usr/bin/python3
[ -x $python ] || python=python3
if ! $python -c '' 2>/dev/null; then
    echo 'skipped: no python3'
    exit 0
fi
colours() {
    $python -B "$tests/make_colours.py" "$@"
}

# expect_colours MODE FILE COLOUR...: a picture of the file, without light, has these colours.
expect_colours() {
    mode=$1
    file=$2
    shift 2
    expect_status 0 cvol render "$file" -o seen.pfm --size 100 --view front --mode "$mode" --light flat
    run colours check seen.pfm "$@"
    [ $status -eq 0 ] || fail "$file, mode $mode: $(cat "$out")"
}

# ---- balls of one colour -------------------------------------------------------------------------

for file in red.tif red16.tif red.nii red.npy red.nrrd redgz.nrrd redrgba.nrrd red.vtk red.vti blue.nrrd; do
    colours make $file 220 30 30
    expect_colours composite $file 220 30 30
done
expect_colours mip red.tif 220 30 30
expect_done cvol compress red16.tif red16.cvol --fast
expect_colours composite red16.cvol 220 30 30
expect_done cvol compress red.nii red.cvol --psnr 45
expect_colours composite red.cvol 220 30 30
expect_colours mip red.cvol 220 30 30

colours make green.nii 20 180 60
expect_colours composite green.nii 20 180 60
colours make two.tif 250 250 250 110 110 110
expect_done cvol compress two.tif two.cvol --psnr 45
expect_colours composite two.cvol 250 250 250 110 110 110
expect_colours mip two.cvol 250 250 250 110 110 110

# All channels fit into one frame, which the visible ones fill.
expect_done cvol render red.cvol -o seen.pfm --size 100
run colours height seen.pfm 0.7
[ $status -eq 0 ] || fail "the ball must fill the picture: $(cat "$out")"

# One message for the file, not one for each component.
expect_status 0 cvol render red.tif -o seen.png --size 40
expect_equal "$(grep -c 'was compressed in memory first' "$err")" 1

# A bright background, as around a section on glass, is transparent, too.
colours make white.tif 180 70 120
expect_done cvol compress white.tif white.cvol --psnr 50
expect_colours composite white.cvol 180 70 120
expect_status 0 cvol render white.cvol -o seen.pfm --size 100
run colours height seen.pfm 0.95
[ $status -ne 0 ] || fail 'the ball must be seen, not the box around it'

# A ball hides what is behind it in all components, also where one of its own is 0; by alpha too, and in all engines
# that have depths.
for file in behind.tif behindrgba.tif; do
    colours make $file 220 0 220
    expect_done cvol compress $file behind.cvol --psnr 50
    expect_colours composite behind.cvol 220 0 220
    expect_status 0 cvol render $file -o seen.pfm --size 100 --view front --light flat --engine ray
    run colours check seen.pfm 220 0 220
    [ $status -eq 0 ] || fail "$file, engine ray: $(cat "$out")"
done
# Light changes brightness, not the hue.
for file in red.cvol white.cvol two.cvol; do
    expect_status 0 cvol render $file -o seen.pfm --size 100 --view front
    case $file in
    red.cvol) set -- 220 30 30 ;;
    white.cvol) set -- 180 70 120 ;;
    *) set -- 250 250 250 110 110 110 ;;
    esac
    run colours lit seen.pfm "$@"
    [ $status -eq 0 ] || fail "$file with light: $(cat "$out")"
done
expect_status 0 cvol render behind.cvol -o seen.pfm --size 100 --view front
run colours check seen.pfm 220 0 220
[ $status -eq 0 ] || fail "with light: $(cat "$out")"
# Depths, opacities, a time budget and overlays work as for other volumes.
expect_done cvol render behind.cvol -o seen.png --size 100 --depth depth.pfm --opacity opacity.pfm
expect_done cvol render behind.cvol -o within.png --size 100 --budget-ms 2000
expect_done cvol compare seen.png within.png --json
expect_equal "$(value_of exact)" true
expect_done cvol compress behind.tif one.cvol --channel 0 --psnr 45
expect_done cvol render behind.cvol -o seen.png --size 100 --overlay one.cvol --overlay-transfer hot

# ---- channel information -------------------------------------------------------------------------

expect_done cvol info red.cvol
grep -q 'channels  *3, the components of one colour' "$out" || fail 'must print that the channels are one colour'
grep -q '0  *red, #ff0000' "$out" || fail 'channel 0 is red'
grep -q '2  *blue, #0000ff' "$out" || fail 'channel 2 is blue'
expect_done cvol info --json red.cvol
expect_equal "$(value_of colours)" true
expect_done cvol verify red.cvol

# Channels with names or colours of their own are separate dyes.
expect_done cvol compress red.nii dyes.cvol --fast --channel-colors cyan,yellow,magenta
expect_done cvol info --json dyes.cvol
expect_equal "$(value_of colours)" false

# ---- alpha, one channel, a window ----------------------------------------------------------------

for file in rgba.tif rgba.nii; do
    colours make $file 220 30 30
    expect_done cvol compress $file rgba.cvol --fast
    expect_colours composite rgba.cvol 220 30 30
    cvol render rgba.cvol -o seen.png --size 40 --mode mip 2>&1 | grep -q 'rgba.cvol: the alpha channel is not drawn' ||
        fail 'must warn that alpha is not drawn in mode mip'
    expect_colours mip rgba.cvol 220 30 30
done
expect_done cvol info --json rgba.cvol
expect_equal "$(value_of channels)" 4
expect_status 0 cvol render red.tif -o one.png --size 40 --channel 1
# All components share one window: 0 to 110 maps 220 and above to full intensity, and brightens 30.
expect_status 0 cvol render red.tif -o seen.pfm --size 100 --view front --mode mip --window 55,110
run colours check seen.pfm 255 70 70
[ $status -eq 0 ] || fail "one window for all components: $(cat "$out")"

# ---- the viewer opens all channels ---------------------------------------------------------------

"$CVOL" view red.cvol --no-browser >address 2>messages &
viewer=$!
for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do
    if [ -s address ] || ! kill -0 $viewer 2>/dev/null; then break; fi
    sleep 0.25
done
kill $viewer 2>/dev/null || :
wait $viewer || :
grep -q 'has no viewer' messages || [ -s address ] || fail "the viewer must open all channels: $(cat messages)"
