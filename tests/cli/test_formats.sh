#!/bin/sh
# cvol reads files of the usual tools of other formats correctly: samples, spacing and choices. A format whose tool
# is not installed, or whose library this build lacks, prints 'skipped'.
. "$(dirname "$0")/lib.sh"

python=/usr/bin/python3 # the system's Python has the packages
[ -x "$python" ] || python=python3
maker=$(cd "$(dirname "$CVOL_DOC")/tests" && pwd)/make_formats.py
reads=$(cvol info --build --json | json_get reads)

# check_kind KIND ENDING: checks every file that make_formats.py KIND writes.
check_kind() {
    case " $reads " in
    *" $2 "*) ;;
    *)
        echo "$1: skipped: built without"
        return 0
        ;;
    esac
    mkdir "$1"
    made=0
    (cd "$1" && "$python" "$maker" "$1") >list 2>trouble || made=$?
    if [ "$made" -eq 77 ]; then
        echo "$1: $(cat trouble)"
        return 0
    fi
    [ "$made" -eq 0 ] || fail "$maker $1: $(tail -1 trouble)"
    (cd "$1" && read_list) <list >report || fail "$1: $(cat report)"
    echo "$1: $(tail -1 report)"
}

# check_affines FOLDER: its files have the geometry that FOLDER/affines.txt notes.
check_affines() {
    while read -r name steps; do # the steps of x, y, z in the world, and the origin
        expect_done cvol info "$1/$name" --json
        expect_equal "$(value_of space)" RAS
        { value_of directions; value_of spacing; value_of origin; } | tr -d '[]' | tr , '\n' | awk -v all="$steps" '
            BEGIN { count = split(all, wanted) }
            { got[NR] = $1 }
            END { for (k = 0; k < 9; k++) off += (got[k + 1] * got[10 + int(k / 3)] - wanted[k + 1]) ^ 2
                  for (k = 1; k <= 3; k++) off += (got[12 + k] - wanted[9 + k]) ^ 2
                  exit !(NR == 15 && count == 12 && off < 1e-12) }' ||
            fail "$name: $(value_of directions) $(value_of spacing) $(value_of origin), must be $steps"
    done <"$1/affines.txt"
}

check_kind tiff .tif
check_kind dicom .dcm
check_kind npy .npy
check_kind wide .h5
check_kind mrc .mrc
check_kind mgh .mgz
check_kind analyze .nii
case $(cvol info --build --json | json_get lacks) in
*libpng* | *libturbojpeg*) echo 'pictures: skipped: built without' ;;
*) check_kind pictures .npy ;;
esac
check_kind vtk .vtk
check_kind hdf5 .h5
check_kind minc .h5
check_kind matlab .h5
case $(cvol info --build --json | json_get lacks) in
*libblosc*) echo 'vdb: skipped: built without' ;;
*) check_kind vdb .vdb ;;
esac

# ---- TIFF ----------------------------------------------------------------------------------------

if [ -e tiff/imagej.tif ]; then
    expect_failure 2 'imagej.tif: has 3 channels; choose one with --channel 0 to 2' cvol compare tiff/imagej.tif tiff/imagej.tif
    expect_failure 2 'imagej.tif: has 2 volumes; choose one with --time 0 to 1' \
        cvol compare tiff/imagej.tif tiff/imagej.tif --channel 0
    expect_done cvol info tiff/imagej.tif --json
    expect_equal "$(value_of times) $(value_of channels)" '2 3'
    expect_done cvol info tiff/imagej.tif --channel 0 --json
    expect_equal "$(value_of times) $(value_of channels)" '2 1'
    expect_failure 2 'imagej.tif: has 3 channels, 0 to 2; number 3 was requested' \
        cvol render tiff/imagej.tif -o x.png --channel 3
    expect_done cvol info tiff/imagej.tif --channel 2 --index 1

    # Times and channels keep their metadata.
    expect_failure 2 'ome.ome.tif: has 3 channels; choose one with --channel 0 to 2 (0: DAPI, 1: a & <b>, 2: α-tubulin)' \
        cvol compare tiff/ome.ome.tif tiff/ome.ome.tif
    expect_done cvol info tiff/ome.ome.tif --json
    expect_equal "$(value_of time_values.1)$(value_of time_unit) $(value_of channel.0.name)" '250.0ms DAPI'
    expect_done cvol compress tiff/ome.ome.tif -o ome.cvol --psnr 20
    expect_done cvol info ome.cvol --json
    expect_equal "$(value_of time_values)" '[0.0,250.0]'
    expect_equal "$(value_of time_unit)" ms
    expect_equal "$(value_of channel.0.name)" DAPI
    expect_equal "$(value_of channel.0.colour)" '[0.0,0.0,1.0]'
    expect_equal "$(value_of channel.1.name)" 'a & <b>'
    expect_equal "$(value_of channel.1.colour)" '[0.0,1.0,0.0]'
    expect_equal "$(value_of channel.2.name)" 'α-tubulin'
    expect_done cvol compress ome.cvol -o same.cvol --psnr 15 --channel-names A,B,C
    expect_done cvol info same.cvol --json
    expect_equal "$(value_of time_values)" '[0.0,250.0]'
    expect_equal "$(value_of channel.2.name)" C
    expect_done cvol compress tiff/imagej.tif -o imagej.cvol --psnr 20 --channel 0 --time-step 3
    expect_done cvol compress tiff/imagej.tif -o imagej.cvol --psnr 20 --channel 0
    expect_done cvol info imagej.cvol --json
    expect_equal "$(value_of time_values)" '[0.0,0.5]'
    expect_equal "$(value_of time_unit)" s

    head -c 500 tiff/u2.tif >cut.tif
    expect_failure 1 'cut.tif:' cvol info cut.tif
    expect_done cvol compress tiff/slices out.cvol --spacing 2,3,4 --psnr 35
    cp tiff/u1.tif tiff/slices/s13.tif
    expect_failure 1 's13.tif: a page has 9 x 7 pixels of 1 uint8; the first page has 9 x 7 of 1 uint16' \
        cvol info tiff/slices
    : >tiff/slices/s13.tif
    expect_failure 1 's13.tif: is not a TIFF file, although its name' cvol info tiff/slices
fi

# ---- DICOM ---------------------------------------------------------------------------------------

if [ -e dicom/series ]; then
    expect_done cvol info dicom/series --json
    expect_equal "$(value_of space)" LPS
    expect_equal "$(value_of origin)" '[-10.0,20.0,5.0]'
    expect_near "$(value_of directions.1.1)" 0.8 1e-6
    expect_near "$(value_of directions.1.2)" -0.6 1e-6
    expect_near "$(value_of directions.2.1)" 0.6 1e-6
    expect_near "$(value_of directions.2.2)" 0.8 1e-6
    expect_failure 2 "two: has 2 series; choose one with --series: '1' (run1, 4 slices), '2' (run2, 4 slices)" \
        cvol info dicom/two
    expect_failure 2 "two: has 2 series, but '7' matches none or several; choose one" \
        cvol info dicom/two --series 7
    expect_status 0 cvol render dicom/two --series 2 -o two.png --size 32
    expect_failure 2 'times: has 2 volumes; choose one with --time 0 to 1' cvol compare dicom/times dicom/times
    expect_done cvol info dicom/times --json
    expect_equal "$(value_of times)" 2
    expect_failure 1 'gap: slices are missing, 1 as it seems: behind 1.dcm the next one is 3 mm away, others are 1.5' \
        cvol info dicom/gap
    expect_done cvol info dicom/gap --spacing 1,1,1
    head -c 900 dicom/two/b2.dcm >cut.dcm
    mv cut.dcm dicom/two/b2.dcm
    expect_failure 1 'b2.dcm: ' cvol info dicom/two --series 2
    echo 'a disk was full' >dicom/two/b2.dcm
    expect_failure 1 'b2.dcm: is not a DICOM file' cvol info dicom/two --series 2
    : >dicom/two/b2.dcm
    expect_failure 1 'b2.dcm: ' cvol info dicom/two --series 2
fi

# ---- NumPy, MRC ----------------------------------------------------------------------------------

if [ -e npy/four.npy ]; then
    expect_failure 2 'four.npy: has 3 volumes; choose one with --time 0 to 2' cvol compare npy/four.npy npy/four.npy
    expect_done cvol info npy/four.npy
    grep -q 'times  *3$' "$out" || fail 'must print the number of times'
    expect_failure 1 "dates.npy: 'descr' is '<M8?s?', which is not supported (integers, floats and '<c8' are)" \
        cvol info npy/dates.npy
    head -c 200 npy/lu2.npy >cut.npy
    expect_failure 1 'cut.npy: holds 72 bytes of samples' cvol info cut.npy
fi
if [ -e mrc/turned.map ]; then
    expect_done cvol info mrc/turned.map --json
    expect_equal "$(value_of origin)" '[-1.0,-2.0,-3.0]'
    head -c 1100 mrc/i2.mrc >cut.mrc
    expect_failure 1 'cut.mrc: has 1100 bytes' cvol info cut.mrc
fi

if [ -e wide/beyond.npy ]; then
    expect_failure 1 'beyond.npy: holds the 64-bit integer 9007199254740993, which is exact neither in 32 bits nor as a double' \
        cvol info wide/beyond.npy
    expect_failure 1 'below.npy: holds the 64-bit integer -4611686018427387904, which' cvol compress wide/below.npy
    expect_failure 1 "words_bad.nrrd: sample 1 is '-1', no uint64" cvol info wide/words_bad.nrrd
    expect_done cvol compress wide/mixed.npy mixed.cvol --lossless
    expect_done cvol info mixed.cvol --json
    expect_equal "$(value_of times) $(value_of type)" '3 float64'
    for time in 0 1 2; do
        expect_status 0 cvol decompress mixed.cvol mixed_$time.npy --time $time
    done
    "$python" -c '
import numpy as np
assert all(np.array_equal(np.load(f"mixed_{t}.npy"), volume) for t, volume in enumerate(np.load("wide/mixed.npy")))
' || fail 'mixed.cvol: other samples'
    expect_failure 2 'wide/turning.npy: has 9 x 7 x 5 samples of float32' cvol compress wide/few.npy wide/turning.npy -o types.cvol
    expect_done cvol compress wide/few.nii.gz few.cvol --lossless
    expect_done cvol compare wide/few.nii.gz few.cvol
fi

# ---- MGH -----------------------------------------------------------------------------------------

if [ -e mgh/turned.mgz ]; then
    expect_done cvol info mgh/turned.mgz --json
    expect_equal "$(value_of space) $(value_of unit) $(value_of spacing)" 'RAS mm [2.0,2.5,3.0]'
    value_of origin | tr -d '[]' | tr , '\n' | awk '
        { wanted = NR == 1 ? 10 : NR == 2 ? -20 : 30; off += ($1 - wanted) ^ 2 }
        END { exit !(NR == 3 && off < 1e-8) }' || fail "origin: $(value_of origin)"
    value_of directions | tr -d '[]' | tr , '\n' | awk '
        BEGIN { split("-0.8 0 0.6 0 1 0 0.6 0 0.8", wanted) }
        { off += ($1 - wanted[NR]) ^ 2 }
        END { exit !(NR == 9 && off < 1e-12) }' || fail "directions: $(value_of directions)"
    expect_failure 2 'four.mgz: has 3 volumes; choose one with --time 0 to 2' cvol compare mgh/four.mgz mgh/four.mgz
    expect_done cvol info mgh/four.mgz --json
    expect_equal "$(value_of times)" 3
    head -c 400 mgh/i2.mgh >cut.mgh
    expect_failure 1 'cut.mgh: has 400 bytes, but volume 0 of 9 x 7 x 5 samples of 2 bytes is announced' cvol info cut.mgh
    head -c 100 mgh/i2.mgh >cut.mgh
    expect_failure 1 'cut.mgh: holds 100 of the 284 bytes of a header' cvol info cut.mgh
    # Damage of the packed stream is found, although remarks follow the samples.
    size=$(wc -c <mgh/i2.mgz)
    { head -c $((size - 8)) mgh/i2.mgz; printf '\1\2\3\4'; tail -c 4 mgh/i2.mgz; } >sum.mgz
    expect_failure 1 'sum.mgz: its compressed bytes are damaged' cvol compare mgh/i2.mgz sum.mgz
    head -c $((size - 8)) mgh/i2.mgz >cut.mgz
    expect_failure 1 'cut.mgz: is cut off within the check sum' cvol compare mgh/i2.mgz cut.mgz
    { head -c 20 mgh/i2.mgh; printf '\0\0\0\7'; tail -c +25 mgh/i2.mgh; } >odd.mgh
    expect_failure 1 'odd.mgh: type is 7; 0, 1, 3, 4 and 10 are supported' cvol info odd.mgh
    expect_done cvol compress mgh/i2.mgz --lossless
    [ -e mgh/i2.cvol ] || fail 'compress of i2.mgz must write i2.cvol'
fi

# ---- Analyze -------------------------------------------------------------------------------------

if [ -e analyze/spm.img ]; then
    check_affines analyze
    expect_done cvol info analyze/spm.img --json
    expect_equal "$(value_of rescale)" '[0.5,0.0]'
    expect_failure 2 'four.hdr: has 3 volumes; choose one with --time 0 to 2' cvol compare analyze/four.img analyze/four.hdr
    cp analyze/i2.hdr alone.hdr
    expect_failure 1 'alone.hdr: its data file alone.img' cvol info alone.hdr
    cp analyze/i2.img short.img
    head -c 200 analyze/i2.hdr >short.hdr
    expect_failure 1 'short.hdr: is not a header of Analyze or NIfTI' cvol info short.img
    cp analyze/i2.img raw.img
    expect_done cvol info raw.img --dims 9x7x5 --type int16
    cp analyze/i2.hdr raw.hdr
    expect_failure 2 'raw.img: is an Analyze file, which has a header' cvol info raw.img --dims 9x7x5 --type int16
    expect_failure 2 'i2.hdr: has one channel, number 0; number 7 was requested' cvol info analyze/i2.img --channel 7
    cp analyze/i2.img envi.img
    printf 'ENVI\nsamples = 9\n' >envi.hdr # another program's header
    expect_done cvol info envi.img --dims 9x7x5 --type int16
    expect_done cvol compress analyze/i2.img --lossless
    for name in i2.hdr i2.img turned.mat; do cp analyze/$name matrix.${name#*.}; done
    expect_done cvol info matrix.img --json
    expect_near "$(value_of directions.0.1)" 0.6 1e-9
    head -c 100 analyze/turned.mat >matrix.mat
    expect_done cvol info matrix.img --json
    expect_equal "$(value_of directions.0)" '[-1.0,0.0,0.0]'
    printf '1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n' >matrix.mat # another program's
    expect_done cvol info matrix.img --json
    expect_equal "$(value_of directions.0)" '[-1.0,0.0,0.0]'
    printf 'MATLAB 5.0 MAT-file, Platform: GLNXA64' >matrix.mat
    expect_failure 1 'matrix.mat: states the geometry of the image in a file of MATLAB 5' cvol info matrix.img
    for value in 0 nan; do
        "$python" -c '
import struct, sys
rows = [1, 0, 0, 0, 0, float(sys.argv[1]), 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
open("matrix.mat", "wb").write(struct.pack("<5i4s16d", 0, 4, 4, 0, 4, b"mat", *rows))' $value
        expect_failure 1 "matrix.mat: its matrix 'mat' has columns that are no directions" cvol info matrix.img
    done
fi

# ---- OpenVDB -------------------------------------------------------------------------------------

if [ -e vdb/all.vdb ]; then
    expect_failure 2 'all.vdb: has 8 grids: name one behind a colon, of dense, sparse, sphere' cvol info vdb/all.vdb
    expect_failure 1 'all.vdb:none: has no such grid; it has dense, sparse' cvol info vdb/all.vdb:none
    expect_failure 1 'vectors.vdb: has no grid of numbers that can be read' cvol info vdb/vectors.vdb
    expect_failure 1 'empty.vdb: its grid has no active voxels' cvol info vdb/empty.vdb
    expect_failure 2 'dense.vdb: is an OpenVDB file, which has a header' cvol info vdb/dense.vdb --type int16
    expect_status 0 cvol compress vdb/truth.vdb truth.cvol # noise, which does not look like labels
    grep -q 'samples are labels' "$err" || fail 'must detect labels by the type of the grid'
    expect_done cvol compare vdb/truth.vdb truth.cvol --json
    expect_equal "$(value_of exact)" true
    expect_done cvol info vdb/all.vdb:shared --json
    expect_equal "$(value_of spacing) $(value_of origin)" '[2.0,3.0,4.0] [-1.0,18.0,407.0]'
fi

# ---- MATLAB --------------------------------------------------------------------------------------

if [ -e matlab/all_packed.mat ]; then
    expect_failure 2 'all_plain.mat: has 12 arrays of three axes or more: name one behind a colon, of u1, i1, u2' \
        cvol info matlab/all_plain.mat
    expect_failure 1 'all_packed.mat:text: has no such array of numbers; it has u1, i1, u2' cvol info matlab/all_packed.mat:text
    expect_failure 1 'all_packed.mat:nothing: has no such array' cvol info matlab/all_packed.mat:nothing
    expect_failure 1 'all_packed.mat:turning: its array turning has complex numbers, which are not read' \
        cvol info matlab/all_packed.mat:turning
    expect_failure 1 'small.mat: has no array of numbers of three axes or more; it has s' cvol info matlab/small.mat
    expect_failure 2 'four_packed.mat: has 3 volumes; choose one with --time 0 to 2' \
        cvol compare matlab/four_packed.mat matlab/four_packed.mat
    expect_failure 1 'lies.mat: its array a has 29 bytes of numbers, but the lengths of its axes are' cvol info matlab/lies.mat
    expect_failure 1 'huge.mat: its array a has 64 bytes of numbers, but' cvol info matlab/huge.mat
    expect_failure 1 'strange.mat: its array a has numbers of an unknown type' cvol info matlab/strange.mat
    expect_failure 2 'bytes.mat: is a MATLAB file, which has a header' cvol info matlab/bytes.mat --type int16
    expect_done cvol compress matlab/four_packed.mat -o four.cvol --lossless
    expect_done cvol info four.cvol --json
    expect_equal "$(value_of times) $(value_of dims)" '3 [9,7,5]'
    expect_done cvol compress matlab/colours_plain.mat -o colours.cvol --lossless
    expect_done cvol info colours.cvol --json
    expect_equal "$(value_of channel.1.name)" green
fi

# ---- MINC ----------------------------------------------------------------------------------------

if [ -e minc/slices.mnc ]; then
    check_affines minc
    expect_done cvol info minc/scalar.mnc --json
    expect_equal "$(value_of rescale)" '[2.0,-10.0]'
    expect_done cvol info minc/slices.mnc --json
    expect_equal "$(value_of type) $(value_of rescale)" 'float32 [1.0,0.0]'
    expect_failure 2 'four.mnc: has 3 volumes; choose one with --time 0 to 2' cvol compare minc/four.mnc minc/four.mnc
    # damage FIELD VALUE PATTERN: slices.mnc with another attribute, or without the dataset image-max.
    damage() {
        cp minc/slices.mnc bad.mnc
        "$python" -c '
import sys, h5py, numpy as np
with h5py.File("bad.mnc", "r+") as file:
    where, value = sys.argv[1].split("@"), sys.argv[2]
    if value == "gone":
        del file["minc-2.0/" + where[0]]
    else:
        file["minc-2.0/" + where[0]].attrs[where[1]] = np.bytes_(value) if value[0] > "9" else np.fromstring(value, sep=" ")
' "$1" "$2" || fail "bad.mnc"
        expect_failure 1 "bad.mnc: $3" cvol info bad.mnc
    }
    damage image/0/image-max gone 'image-min and image-max of its image in MINC do not fit the image'
    damage image/0/image@valid_range '5 5' 'valid_range of its image in MINC is 5 to 5'
    damage image/0/image@dimorder 'time,yspace,xspace' 'of its image in MINC the axis 0 is not one of space'
    damage dimensions/xspace@direction_cosines '0 0 0' 'axis 2 of its image in MINC has the step -1.5'
    damage dimensions/xspace@direction_cosines '0 0.955336489 0.295520207' 'the directions of its axes do not span'
    damage dimensions/yspace@spacing irregular 'axis 1 of its image in MINC has irregular spacing'
    damage image/0/image gone 'has no such dataset'
fi

# ---- folders of pictures -------------------------------------------------------------------------

if [ -e pictures/grey ]; then
    expect_failure 2 'colours: has 3 channels; choose one with --channel 0 to 2' \
        cvol compare pictures/colours pictures/colours
    expect_done cvol compress pictures/colours colours.cvol
    expect_done cvol info colours.cvol --json
    expect_equal "$(value_of colours)" true
    expect_done cvol compress pictures/grey --lossless
    [ -e pictures/grey.cvol ] || fail 'compress of the folder grey must write grey.cvol'
    # Blank slices take less than a byte for a row: 1-bit grey, and a palette of two colours.
    mkdir blank
    "$python" -c '
import struct, zlib
def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
for name, kind, palette in ("grey", 0, b""), ("colour", 3, chunk(b"PLTE", bytes([0, 0, 0, 255, 0, 0]))):
    header = struct.pack(">IIBBBBB", 2048, 2048, 1, kind, 0, 0, 0)
    open("blank/%s.png" % name, "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + palette
        + chunk(b"IDAT", zlib.compress(bytes(257 * 2048), 9)) + chunk(b"IEND", b""))'
    mv blank/colour.png .
    expect_done cvol info blank --json
    expect_equal "$(value_of type)" uint8
    mv colour.png blank/grey.png
    expect_done cvol info blank --json
    expect_equal "$(value_of colours)" true
    mkdir beside
    cp pictures/grey/slice0.png beside/preview.png
    cp npy/lu2.npy beside/scan.npy
    expect_failure 1 'beside: is a directory without slices' cvol info beside
    cp -r pictures/grey broken
    cp pictures/wide/003.png broken/slice3.png
    expect_failure 1 'broken/slice3.png: has 9 x 7 pixels of 1 x 16 bits, but broken/slice0.png has 9 x 7 of 1 x 8 bits' \
        cvol compress broken broken.cvol
    head -c 60 pictures/grey/slice3.png >broken/slice3.png
    expect_failure 1 'broken/slice3.png: PNG: ' cvol compress broken broken.cvol
    echo 'a disk was full' >broken/slice3.png
    expect_failure 1 'broken/slice3.png: is not a PNG or JPEG file' cvol info broken
    cp pictures/grey/slice3.png broken/slice3.png
    "$python" -c '
data = bytearray(open("pictures/jpeg/4.JPG", "rb").read())
at = data.index(b"\xff\xc0") + 5
data[at:at + 4] = b"\xff\xdc\xff\xdc"
open("broken/slice0.png", "wb").write(data)'
    expect_failure 1 'broken/slice0.png: '*' bytes cannot hold the 65500 x 65500 pixels that its header claims' cvol info broken
    cp pictures/grey/slice0.png broken/slice0.png
    head -c 300 pictures/jpeg/4.JPG >broken/slice3.png
    expect_failure 1 'broken/slice3.png: ' cvol compress broken broken.cvol
fi

# ---- VTK -----------------------------------------------------------------------------------------

if [ -e vtk/vectors.vti ]; then
    expect_failure 2 'vectors.vti: has 3 channels; choose one with --channel 0 to 2' cvol compare vtk/vectors.vti vtk/vectors.vti
    expect_done cvol info vtk/1Ascii.vti --json
    expect_equal "$(value_of origin)" '[1.0,2.0,3.0]'
fi

# ---- HDF5 ----------------------------------------------------------------------------------------

if [ -e hdf5/many.h5 ]; then
    expect_failure 1 'many.h5: has 10 datasets of three axes or more: name one behind a colon, of /group/f2' \
        cvol info hdf5/many.h5
    expect_done cvol info hdf5/many.h5:/group/f2 --json
    expect_equal "$(value_of file_bytes)" "$(wc -c <hdf5/many.h5)"
    expect_failure 1 'many.h5:/none: has no such dataset' cvol info hdf5/many.h5:/none
    expect_failure 1 "many.h5:/words: its dataset's type is not supported (integers and floats are)" \
        cvol info hdf5/many.h5:/words
    expect_failure 2 'arrays.h5:/five: has 3 channels; choose one with --channel 0 to 2' \
        cvol compare hdf5/arrays.h5:/five hdf5/arrays.h5:/five
    expect_failure 2 'arrays.h5:/five: has 2 volumes; choose one with --time 0 to 1' \
        cvol compare hdf5/arrays.h5:/five hdf5/arrays.h5:/five --channel 0
    expect_done cvol info hdf5/arrays.h5:/colours --json
    expect_equal "$(value_of colours)" true
    expect_failure 1 'arrays.h5:/seven: its array has 7 axes, and axis 0 has 2 places; five can be read' \
        cvol info hdf5/arrays.h5:/seven
    expect_failure 2 'four.h5: has 3 volumes; choose one with --time 0 to 2' cvol compare hdf5/four.h5 hdf5/four.h5
    expect_failure 1 'its dataset needs more bytes than the file has' \
        cvol info "$(dirname "$CVOL_DOC")/tests/crashers/hdf5_header_ends_early.h5"
    head -c 3000 hdf5/one.h5 >cut.h5
    expect_failure 1 'cut.h5: ' cvol info cut.h5
fi

# ---- writing -------------------------------------------------------------------------------------

make_volume in.raw int16 6x5x4
make_nrrd in.nrrd in.raw int16 6 5 4 'space dimension: 3' 'space origin: (1,2,3)' \
    'space directions: (0,-0.5,0) (0.7,0,0) (0,0,2.5)'
expect_done cvol compress in.nrrd in.cvol --lossless
for ending in npy tif vti mrc mgz mgh; do
    expect_done cvol decompress in.cvol out.$ending
    expect_status 0 cvol compare out.$ending in.nrrd --json
    expect_number "$(value_of max_abs_error)" '==' 0
done
make_volume bytes.raw uint8 6x5x4
make_nrrd bytes.nrrd bytes.raw uint8 6 5 4 'space: left-posterior-superior' 'space units: "um" "um" "um"' \
    'space origin: (10,20,-30)' 'space directions: (0,-500,0) (700,0,0) (0,0,2500)'
expect_done cvol compress bytes.nrrd bytes.cvol --lossless
for ending in mrc mgz nii; do
    expect_done cvol decompress bytes.cvol bytes.$ending
    expect_status 0 cvol compare bytes.$ending bytes.nrrd --json
    expect_number "$(value_of max_abs_error)" '==' 0
done
expect_done cvol info bytes.mrc --json
expect_equal "$(value_of type) $(value_of unit) $(value_of spacing)" 'uint16 A [5000000.0,7000000.0,25000000.0]'
expect_done cvol decompress in.cvol out.h5
expect_equal "$(cat "$out")" 'out.h5: 6 x 5 x 4 samples of int16; the format cannot store spacing, directions and origin'
for type in uint8 int8 uint16 int16 uint32 int32 float32 float64; do
    make_volume $type.raw $type 6x5x4
    expect_done cvol compress $type.raw $type.cvol --dims 6x5x4 --type $type --spacing 0.5,0.25,2 --lossless
    expect_done cvol decompress $type.cvol $type.npy
    expect_done cvol decompress $type.cvol $type.h5
done
expect_done cvol decompress bytes.cvol bytes.h5
# A named dataset, in groups.
expect_done cvol decompress bytes.cvol named.h5:/scan/left/ct --json
expect_equal "$(value_of file_bytes) $(value_of geometry_lost)" "$(wc -c <named.h5) [\"directions\",\"origin\",\"patient space\"]"
long=$(printf 'name%.0s' 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39 40)
expect_done cvol decompress bytes.cvol "long.hdf5:$long/$long/$long/µ"
cp named.h5 before.h5
expect_failure 2 'named.h5: exists, and cvol adds no volume to a file' cvol decompress bytes.cvol named.h5:/other
expect_same_file named.h5 before.h5
for name in new.h5: new.h5:/ new.h5:/a//b new.h5:a/ new.h5:/./a "new.h5:$long$long"; do
    expect_failure 2 "$name: behind the colon must be a dataset's name" cvol decompress bytes.cvol "$name"
done
[ ! -e new.h5 ] || fail 'nothing must be written'
expect_failure 2 'new.nrrd:/a: unknown extension' cvol decompress bytes.cvol new.nrrd:/a
case " $reads " in
*' .h5 '*)
    expect_done cvol compress bytes.h5 again.cvol --lossless
    expect_status 0 cvol compare bytes.h5 bytes.nrrd --json
    expect_status 0 cvol compare named.h5:/scan/left/ct bytes.h5 --json
    expect_equal "$(value_of exact)" true
    expect_number "$(value_of max_abs_error)" '==' 0
    expect_done cvol info bytes.h5 --json
    expect_equal "$(value_of spacing) $(value_of unit)" '[500.0,700.0,2500.0] um'
    ;;
esac
make_volume words.raw uint32 6x5x4
expect_status 0 cvol compress words.raw words.cvol --dims 6x5x4 --type uint32 --lossless
expect_failure 1 'words.mrc: MRC has no samples of type uint32: write NRRD, NIfTI or NumPy' cvol decompress words.cvol words.mrc
expect_failure 1 'words.mgz: MGH has no samples of type uint32: write NRRD, NIfTI or NumPy' cvol decompress words.cvol words.mgz
[ ! -e words.mrc ] || fail 'nothing must be written'
expect_done cvol decompress in.cvol one.ome.tif
expect_equal "$(cat "$out")" 'one.ome.tif: 6 x 5 x 4 samples of int16; the format cannot store directions and origin'
expect_status 0 cvol compare one.ome.tif in.nrrd --json
expect_number "$(value_of max_abs_error)" '==' 0
if [ -e tiff/ome.ome.tif ]; then # times and channels, with their names, colours and time step
    expect_done cvol compress tiff/ome.ome.tif series.cvol --lossless
    expect_done cvol decompress series.cvol series.ome.tif
    expect_equal "$(cat "$out")" 'series.ome.tif: 2 times, 3 channels, 9 x 7 x 5 samples of uint16'
    expect_done cvol compress series.ome.tif again.cvol --lossless
    expect_same_file again.cvol series.cvol
    expect_done cvol compress tiff/red.tif tiff/green.tif -o colours.cvol --lossless # two times
    expect_done cvol compress tiff/alpha.tif -o alpha.cvol --lossless
    expect_done cvol compress tiff/real.tif -o real.cvol --lossless
    for name in colours alpha real; do
        expect_done cvol decompress $name.cvol $name.ome.tif
        expect_done cvol compress $name.ome.tif -o again.cvol --lossless
        [ $name = real ] || expect_same_file again.cvol $name.cvol # with the same channels, of colours
    done
    expect_done cvol decompress series.cvol channel.ome.tiff --channel 1 --time 1
    expect_done cvol info channel.ome.tiff --json
    expect_equal "$(value_of dims) $(value_of spacing) $(value_of unit)" '[9,7,5] [0.1,0.2,0.4] um'
fi
expect_done cvol info out.vti --json
expect_equal "$(value_of origin)" '[1.0,2.0,3.0]'
expect_equal "$(value_of directions.0)" '[0.0,-1.0,0.0]'
"$python" "$maker" check >report 2>&1 || fail "written: $(tail -1 report)"
cat report

# ---- unknown formats -----------------------------------------------------------------------------

mkdir none
expect_failure 1 'none: is a directory without slices' cvol info none
expect_failure 2 'in.nrrd: has one channel, number 0; number 1 was requested' cvol info in.nrrd --channel 1
expect_done cvol decompress in.cvol in.mha
expect_failure 2 'in.mha: is a MetaImage file; cvol reads one channel from such files' cvol info in.mha --channel 0
