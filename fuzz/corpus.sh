#!/bin/sh
# Writes the seed volumes of the fuzzers: in the current format of cvol, and small files of other formats, written
# by their own tools. Run it when the format changes.
# usage: fuzz/corpus.sh BUILD       from the project's root; a build with tests (make_volume, make_terms, poke, unpack)
set -eu
tools=$(cd "$1" && pwd)
out=$(pwd)/fuzz/corpus/cvol
maker=$(pwd)/tests/make_formats.py
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# seed NAME TYPE DIMS OPTION ...: compresses smooth samples with a little noise.
seed() {
    name=$1 type=$2 dims=$3
    shift 3
    [ -f "$type-$dims.raw" ] || "$tools/tests/helpers/make_volume" "$type-$dims.raw" "$type" "$dims"
    "$tools/cvol" compress "$type-$dims.raw" "$out/$name.cvol" --dims "$dims" --type "$type" "$@" >/dev/null
}

seed uint8 uint8 20x18x17 --psnr 35
seed int16 int16 20x18x17 --psnr 45 --no-lap
seed block32 float32 40x33x20 --block 32 --psnr 40
seed dependent int16 20x18x17 --psnr 50
seed lapped float32 40x18x17 --psnr 45
seed true_length uint8 27x21x18 --psnr 40
seed smallest uint8 27x21x18 --smallest --psnr 40
seed edge uint8 27x21x18 --fast --psnr 40
seed ranges uint8 40x40x40 --psnr 45 --no-lap
seed two_bricks uint8 70x6x6 --psnr 40
seed runs uint8 80x80x80 --psnr 42
seed bricks uint8 40x33x20 --psnr 40 --bricks 16,32,16
seed bricks_exact int16 20x18x17 --lossless --bricks 16
seed background uint8 40x33x20 --background 40 --psnr 40
seed lossless_uint8 uint8 20x18x17 --lossless
seed lossless_uint32 uint32 12x11x10 --lossless
seed lossless_float float32 12x11x10 --lossless
seed lossless_double float64 12x11x10 --lossless
seed max_error uint8 20x18x17 --max-error 3
seed max_error_int16 int16 20x18x17 --max-error 40
seed max_error_float float32 20x18x17 --max-error 0.05
seed max_error_double float64 20x18x17 --max-error 1e-5
seed mask_int16 int16 20x18x17 --fill 800 --psnr 40
LC_ALL=C tr '\000-\077\100-\177\200-\277\300-\377' '[\001*64][\005*64][\002*64][\007*64]' \
    <uint8-20x18x17.raw >labels.raw
"$tools/cvol" compress labels.raw "$out/labels.cvol" --dims 20x18x17 --type uint8 --labels yes >/dev/null
cp float32-20x18x17.raw holes.raw
"$tools/tests/helpers/poke" holes.raw 800 f32 nan 804 f32 nan 1600 f32 -inf
for method in 'mask_float --fill nan --psnr 40' 'mask_max_error --fill nan --max-error 0.1' \
    'mask_lossless --lossless'; do
    # shellcheck disable=SC2086
    set -- $method
    name=$1
    shift
    "$tools/cvol" compress holes.raw "$out/$name.cvol" --dims 20x18x17 --type float32 "$@" >/dev/null
done
"$tools/tests/helpers/make_terms" "$out/split.cvol" 20x18x17 16 1 0 1 7
"$tools/cvol" transcode "$out/lapped.cvol" --ratio 30 --force "$out/transcoded.cvol" >/dev/null

# Several volumes: two times, two channels.
"$tools/tests/helpers/make_volume" many.raw uint8 12x11x10
for i in 0 1; do
    "$tools/cvol" compress many.raw "many_$i.cvol" --dims 12x11x10 --type uint8 --psnr $((20 + 9 * i)) >/dev/null
done
"$tools/cvol" compress many_0.cvol many_1.cvol -o "$out/series.cvol" --psnr 30 --time-step 2 >/dev/null
"$tools/cvol" compress many_0.cvol many_1.cvol -o "$out/channels.cvol" --as channels --psnr 25 \
    --channel-names A,B >/dev/null

# Mutations reach more code if sections are stored separately; these two files stay packed.
for file in "$out"/*.cvol; do
    "$tools/tests/helpers/unpack" "$file" plain
    cp plain "$file"
done
seed packed uint8 12x11x10 --psnr 30
seed packed_lossless uint8 6x5x4 --lossless

for kind in tiff dicom npy mrc mgh analyze minc vdb vtk matlab; do
    mkdir "$kind"
    (cd "$kind" && /usr/bin/python3 "$maker" "$kind" >/dev/null)
done
for file in tiff/rows.tif tiff/deflate.tif tiff/tiles.tif tiff/big.tif tiff/stack.tif tiff/planes.tif \
    dicom/series/0_0.dcm dicom/implicit/0_0.dcm dicom/big/0_0.dcm dicom/frames.dcm dicom/rle/0.dcm \
    dicom/jpeg/0.dcm dicom/jpegls/0.dcm dicom/j2k/0.dcm npy/fortran4.npy npy/half.npy npy/v2.npy \
    mrc/turned.map mrc/f2.mrc mgh/u1.mgh mgh/turned.mgz analyze/turned.mat analyze/only_m.mat minc/slices.mnc \
    vdb/dense.vdb vdb/half.vdb vdb/background_true.vdb vdb/empty.vdb matlab/four_plain.mat matlab/four_packed.mat \
    matlab/colours_packed.mat matlab/big_packed.mat matlab/bytes.mat matlab/small.mat vtk/i2.vtk vtk/u4a.vtk vtk/4Binary.vti \
    vtk/8Appended.vti vtk/12Appended.vti vtk/1Ascii.vti; do
    cp "$file" "$out/../volume/$(echo "$file" | tr / _)"
done

/usr/bin/python3 - "$out/../volume" <<'END'
import sys

import h5py
import numpy as np

def samples(kind, shape=(4, 5, 6)):
    return (np.arange(np.prod(shape)).reshape(shape) * 7 % 251).astype(kind)

def write(name, volume, libver="earliest", **options):
    with h5py.File(f"{sys.argv[1]}/hdf5_{name}.h5", "w", libver=libver) as file:
        file.create_dataset("d", data=volume, **options)

write("contiguous", samples(">i2"))
write("chunks", samples("u2", (5, 6, 7)), chunks=(2, 3, 4))
write("latest", samples("f4"), "latest", chunks=(2, 5, 6), compression="gzip", fletcher32=True)
with h5py.File(f"{sys.argv[1]}/hdf5_group.h5", "w", userblock_size=512) as file:
    data = file.create_dataset("g/d", data=samples("u1", (2, 3, 4, 5, 3)), chunks=(1, 2, 4, 5, 3),
                               compression="gzip", shuffle=True)
    data.attrs["element_size_um"] = [3.0, 2.0, 1.0]
    file["g/line"] = np.zeros(3, "f8")
END

# Folders of Zarr, as fuzz_zarr.c unpacks them: metadata, and the first chunks.
mkdir zarr
(cd zarr && CVOL=$tools/cvol /usr/bin/python3 "$(dirname "$maker")/make_zarr.py" >/dev/null)
/usr/bin/python3 - zarr "$out/../zarr" <<'END'
import os
import sys

for name in ("zlib", "zstd", "blosc_lz4", "fortran", "half_60", "nan", "cvol_C", "cvol_5", "image.ome", "units.ome", "v3_turned",
             "v3_big", "v3_shards_start", "v3_shards_end", "v3.ome"):  # fmt: skip
    files = [os.path.relpath(os.path.join(at, file), f"{sys.argv[1]}/{name}.zarr")
             for at, _, inside in os.walk(f"{sys.argv[1]}/{name}.zarr") for file in inside]  # fmt: skip
    chunks = sorted(f for f in files if os.path.basename(f)[0].isdigit() and not f.startswith(("1", "labels")))[:2]
    metadata = sorted(f for f in files if not os.path.basename(f)[0].isdigit() and not f.startswith(("1", "labels")))
    with open(f"{sys.argv[2]}/{name}", "wb") as out:
        for file in metadata + chunks:
            out.write(b"%%" + file.encode() + b"\n" + open(f"{sys.argv[1]}/{name}.zarr/{file}", "rb").read())
END

for file in "$out"/*.cvol; do "$tools/cvol" verify "$file"; done
