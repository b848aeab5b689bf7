#!/bin/sh
# Volumes of colours (RGB and RGBA): pictures have the colours of the samples, from every format, and from the
# compressed file too; what the file says of its channels, what is not drawn, and what can be chosen.
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

# see MODE FILE COLOUR...: a picture of the file has this colour.
see() {
    mode=$1
    file=$2
    shift 2
    expect_status 0 cvol render "$file" -o seen.pfm --size 100 --view front --mode "$mode"
    run colours see seen.pfm "$@"
    [ $status -eq 0 ] || fail "$file, mode $mode: $(cat "$out")"
}

# ---- balls of one colour --------------------------------------------------------------------

for file in red.tif red16.tif red.nii red.npy red.vtk red.vti; do
    colours make $file 220 30 30
    see composite $file 220 30 30
done
see mip red.tif 220 30 30
expect_done cvol compress red16.tif red16.cvol --fast
see composite red16.cvol 220 30 30
expect_done cvol compress red.nii red.cvol --psnr 45
see composite red.cvol 220 30 30
see mip red.cvol 220 30 30

colours make green.nii 20 180 60
see composite green.nii 20 180 60
colours make two.tif 250 250 250 110 110 110
expect_done cvol compress two.tif two.cvol --psnr 45
see composite two.cvol 250 250 250 110 110 110
see mip two.cvol 250 250 250 110 110 110

# ---- what the file says ---------------------------------------------------------------------

expect_done cvol info red.cvol
grep -q 'channels  *3, the components of one colour' "$out" || fail 'must say that the channels are one colour'
grep -q '0  *red, #ff0000' "$out" || fail 'channel 0 is red'
grep -q '2  *blue, #0000ff' "$out" || fail 'channel 2 is blue'
expect_done cvol info --json red.cvol
expect_equal "$(value_of colours)" true
expect_done cvol verify red.cvol

# Channels that are given names or colours of their own are dyes as before.
expect_done cvol compress red.nii dyes.cvol --fast --channel-colors cyan,yellow,magenta
expect_done cvol info --json dyes.cvol
expect_equal "$(value_of colours)" false

# ---- alpha, one channel, a window -----------------------------------------------------------

for file in rgba.tif rgba.nii; do
    colours make $file 220 30 30
    expect_done cvol compress $file rgba.cvol --fast
    see composite rgba.cvol 220 30 30
    cvol render rgba.cvol -o seen.png --size 40 2>&1 | grep -q 'rgba.cvol: the alpha channel is not drawn' ||
        fail 'must say that alpha is not drawn'
done
expect_done cvol info --json rgba.cvol
expect_equal "$(value_of channels)" 4
expect_status 0 cvol render red.tif -o one.png --size 40 --channel 1
# The window is one for all components: 0 to 110 makes 220 and more white, and 30 brighter.
expect_status 0 cvol render red.tif -o seen.pfm --size 100 --view front --mode mip --window 55,110
run colours see seen.pfm 255 70 70
[ $status -eq 0 ] || fail "one window for all: $(cat "$out")"

# ---- the viewer shows one channel, and says so ----------------------------------------------

cvol view red.cvol --no-browser >address 2>said &
viewer=$!
for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do
    if [ -s address ] || ! kill -0 $viewer 2>/dev/null; then break; fi
    sleep 0.25
done
kill $viewer 2>/dev/null || :
wait $viewer || :
grep -q 'has no viewer' said || grep -q 'red.cvol: using channel 0 of 3; --channel chooses another' said ||
    fail "the viewer must say which channel it shows: $(cat said)"
