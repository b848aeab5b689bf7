#!/bin/sh
# Makes files of every kind, whose decoded samples, pixels or planes CHECKSUMS states; tests/cli/test_golden.sh decodes
# them. Files that exist stay: a later version must decode them to the same bits. Add a kind here, run this, and commit
# the new files.
# usage: tests/golden/make.sh BUILD_FOLDER (needs NumPy)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
PATH=$build:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# A part of a scan with its background, a field with values of both signs, and what follows from them.
cvol compress "$here/../../samples/ch2better.nii.gz" scan.cvol --lossless >scan.log
cvol decompress scan.cvol part.npy --box 60:108,40:85,90:129 >part.log
python3 - <<'END'
import numpy
part = numpy.load('part.npy')
z, y, x = numpy.indices((39, 45, 48), dtype='float64')
wave = 100 * numpy.sin(x / 5 + y / 7) * numpy.cos(z / 6) + ((7 * x + 3 * y + 5 * z) % 11)
land = numpy.where(x + y < 30, 1e35, wave)
numpy.save('u8.npy', part)
numpy.save('i16.npy', (wave * 20).astype('int16'))
numpy.save('u16.npy', (wave * 200 + 30000).astype('uint16'))
numpy.save('i32.npy', (wave * 1e5).astype('int32'))
numpy.save('f32.npy', wave.astype('float32'))
numpy.save('f64.npy', wave)
numpy.save('land.npy', land.astype('float32'))
numpy.save('nan.npy', numpy.where(land > 1e30, numpy.nan, wave).astype('float32'))
numpy.save('small_f32.npy', wave[:20, :21, :22].astype('float32'))
numpy.save('small_f64.npy', wave[:20, :21, :22])
numpy.save('small_nan.npy', numpy.where(land > 1e30, numpy.nan, wave)[:20, :21, :33].astype('float32'))
numpy.save('small_u8.npy', part[10:22, 10:24, 10:28])
numpy.save('labels.npy', ((part > 20).astype('uint8') + (part > 60) + 2 * (x > 25) * (part > 20)).astype('uint8'))
numpy.save('mask.npy', (part > 0).astype('uint8'))
END

sum_of() { sha256sum "$1" | cut -d ' ' -f 1; }

# NAME INPUT OPTIONS...: a file, and the checksum of its samples.
add() {
    name=$1
    input=$2
    shift 2
    [ ! -e "$here/$name.cvol" ] || return 0
    cvol compress "$input.npy" "$here/$name.cvol" --force "$@" >log 2>&1 || { cat log; exit 1; }
    record "$name"
}
record() { # NAME OPTIONS...
    name=$1
    shift
    rm -f out.raw
    cvol decompress "$here/$name.cvol" out.raw "$@" >log
    echo "$(sum_of out.raw) $name $*" | sed 's/ $//' >>"$here/CHECKSUMS"
}

add default u8 --ratio 12
add background u8 --psnr 40 --background 0
add plain_blocks u8 --psnr 40 --no-lap --background none
add block_8 i16 --psnr 40 --block 8
add block_32 u16 --psnr 40 --block 32
add fast u16 --psnr 45 --effort fast
add largest_effort i16 --psnr 38 --effort max
add small_bricks f32 --psnr 50 --bricks 16,32,48
add double f64 --psnr 50
add integers i32 --psnr 55
add missing land --psnr 45 --fill 1e35
add missing_nan nan --psnr 45 --fill nan
add max_error i16 --max-error 30
add max_error_psnr f32 --max-error 1.5 --psnr 40
add lossless_u8 u8 --lossless
add lossless_i16 i16 --lossless
add lossless_f32 small_f32 --lossless
add lossless_f64 small_f64 --lossless
add lossless_nan small_nan --lossless
add labels labels --labels yes
add mask mask
add terms f32 --keep 2,3000
add hartley small_f32 --transform dht --block 16 --psnr 40
add fourier small_f32 --transform dft --block 8 --psnr 40

if [ ! -e "$here/series.cvol" ]; then
    cvol compress u8.npy labels.npy mask.npy -o "$here/series.cvol" --psnr 40 --time-step 2 --labels no --force >log
    for i in 0 1 2; do record series --time $i; done
fi
if [ ! -e "$here/channels.cvol" ]; then
    cvol compress u8.npy mask.npy -o "$here/channels.cvol" --as channels --psnr 40 --labels no --force >log
    for i in 0 1; do record channels --channel $i; done
fi
# Whole transforms. No sample of these is closer than 1e-4 to the middle between two integers.
add whole_dct small_u8 --transform dct --block 0 --keep 2,140
add whole_hartley small_u8 --transform dht --block 0 --keep 4,100
add whole_fourier small_u8 --transform dft --block 0 --keep 4,100

# NAME COMMAND...: a picture or a baked volume, and the checksum of its pixels or planes.
add_planes() {
    name=$1
    shift
    [ ! -e "$here/$name" ] || return 0
    cvol "$@" >log 2>&1 || { cat log; exit 1; }
    "$build/tests/helpers/decode_planes" "$here/$name" out.raw
    echo "$(sum_of out.raw) $name" >>"$here/CHECKSUMS"
}
cvol render scan.cvol -o look.png --size 96x80 --transfer skin-bone --azimuth 30 >log 2>&1
cvol compress u8.npy part.cvol --psnr 40 --labels no >log
add_planes picture.cvi compress look.png "$here/picture.cvi" --psnr 38
add_planes picture_hartley.cvi compress look.png "$here/picture_hartley.cvi" --psnr 33 --transform dht --block 8
add_planes rendered.cvi render part.cvol -o "$here/rendered.cvi" --engine transform --size 64x56 --azimuth 30 \
    --elevation 20 --background 0.2,0.4,0.9 --transfer skin-bone
add_planes baked.cvol bake part.cvol -o "$here/baked.cvol" --axis y --transfer skin-bone --rho 0.02
add_planes baked_grey.cvol bake part.cvol -o "$here/baked_grey.cvol" --axis z --tile 32 --transfer gray --rho 0.02 \
    --shade

if [ ! -e "$here/sum.cvol" ]; then
    cvol add "$here/background.cvol" "$here/background.cvol" -o "$here/sum.cvol" --beta -0.5 >log
    record sum
fi
