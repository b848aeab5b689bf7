#!/bin/sh
# cvol reads and writes Zarr folders correctly, and refuses damaged ones with one sentence. Without python3-zarr
# it prints 'skipped'.
. "$(dirname "$0")/lib.sh"

python=/usr/bin/python3 # the system's Python has the packages
[ -x "$python" ] || python=python3
maker=$(cd "$(dirname "$CVOL_DOC")/tests" && pwd)/make_zarr.py

has_blosc=yes
cvol info --build | grep -q libblosc && has_blosc=no

# ---- correct folders -----------------------------------------------------------------------------

made=0
"$python" "$maker" >list 2>trouble || made=$?
if [ "$made" -eq 77 ]; then
    cat trouble
    exit 0
fi
[ "$made" -eq 0 ] || fail "$maker: $(tail -1 trouble)"
[ $has_blosc = yes ] || {
    echo 'blosc: skipped: built without'
    grep -v '^[^ ]*blosc\|^little_\|^v3_turned\|^image\|^fortran' list >less && mv less list
}
read_list <list >report || fail "$(cat report)"
tail -1 report

expect_failure 2 'image.ome.zarr: has 3 channels; choose one with --channel 0 to 2' \
    cvol compare image.ome.zarr image.ome.zarr
expect_failure 2 'image.ome.zarr: has 2 volumes; choose one with --time 0 to 1' \
    cvol compare image.ome.zarr image.ome.zarr --channel 0
expect_failure 2 'image.ome.zarr: has 3 channels, 0 to 2; number 3 was requested' \
    cvol render image.ome.zarr -o x.png --channel 3
expect_failure 2 'v3.ome.zarr: has 3 channels; choose one with --channel 0 to 2 (0: α, 1: α, 2: α)' \
    cvol compare v3.ome.zarr v3.ome.zarr
expect_done cvol info image.ome.zarr --channel 0 --time 1 --json
expect_equal "$(value_of origin)" '[30.0,20.0,10.0]'
expect_equal "$(value_of unit)" um
expect_done cvol info image.ome.zarr/1 --channel 0 --time 1 --json
expect_equal "$(value_of origin)" '[30.125,20.25,10.0]'
expect_done cvol info plane.zarr --spacing 1,2,3 --json
expect_equal "$(value_of spacing)" '[1.0,2.0,3.0]'
expect_failure 1 'labels: is a Zarr group without multiscales: give the folder of an image or an array in it' \
    cvol info image.ome.zarr/labels
mkdir listed
printf '{"zarr_format": 2}' >listed/.zgroup
printf '{"labels": ["cells", 7, "nuclei"]}' >listed/.zattrs
expect_failure 1 'listed: is a Zarr group without multiscales: give the folder of an image or an array in it, one of cells, nuclei' \
    cvol info listed
(cd image.ome.zarr/1 && cvol info . --channel 0 --time 0) >text
grep -q um text || fail 'the current folder must have the geometry of its image'

# A series keeps times, names and colours.
expect_done cvol compress image.ome.zarr series.cvol --lossless
expect_done cvol info series.cvol --json
expect_equal "$(value_of times) $(value_of channels) $(value_of time_unit)" '2 3 s'
expect_equal "$(value_of time_values)" '[0.0,1.5]'
expect_equal "$(value_of channel.0.name) $(value_of channel.1.name)" 'DAPI GFP'
expect_equal "$(value_of channel.0.colour)" '[0.0,0.0,1.0]'
expect_done cvol compress little_f4.zarr f4.cvol --lossless
expect_status 0 cvol compare f4.cvol little_f4.zarr --json
expect_number "$(value_of max_abs_error)" '==' 0

# ---- written folders -----------------------------------------------------------------------------

# volume TYPE SHAPE NAME EXPRESSION: NAME.npy of an expression of NumPy in z, y, x.
volume() {
    "$python" -c "
import numpy as np
z, y, x = np.indices(($2))[-3:]
np.save('$3.npy', ($4).astype('$1'))" || fail "$3.npy"
}

# written FOLDER NAME [labels]: checks a folder against NAME.npy.
written() {
    command_run="make_zarr.py check $*"
    status=0
    "$python" "$maker" check "$@" >"$out" 2>"$err" || status=$?
    [ "$status" -eq 0 ] || fail "must be the samples"
}

volume '<u2' '70, 133, 65' wave '1000 + 900 * np.sin(z / 5) * np.cos(x * y / 300)'
expect_done cvol compress wave.npy wave.cvol --lossless --spacing 0.5,0.25,2
expect_done cvol decompress wave.cvol wave.ome.zarr
expect_equal "$(cat "$out")" 'wave.ome.zarr: 65 x 133 x 70 samples of uint16'
written wave.ome.zarr wave.npy
expect_equal "$(cat "$out")" '3 None 2 0.25 0.5 0 0 0'
expect_done cvol compress wave.ome.zarr again.cvol --lossless
expect_same_file again.cvol wave.cvol
expect_done cvol info wave.ome.zarr/1 --json
expect_equal "$(value_of spacing)$(value_of origin)" '[1.0,0.5,4.0][0.25,0.125,1.0]'

# The same name again replaces the image; other folders stay.
expect_done cvol compress wave.npy float.cvol --psnr 60
expect_done cvol decompress float.cvol wave.ome.zarr/ --box 0:10,3:70,5:9
expect_done cvol info wave.ome.zarr --json
expect_equal "$(value_of dims)$(value_of origin)" '[10,67,4][0.0,3.0,5.0]'
mkdir -p wave.ome.zarr/labels other.zarr file
expect_failure 1 "wave.ome.zarr: exists and has 'labels', which cvol does not write: remove it first" \
    cvol decompress wave.cvol wave.ome.zarr
expect_failure 1 'other.zarr: is a directory that is not an image of OME-Zarr, so it is not replaced' \
    cvol decompress wave.cvol other.zarr
echo text >file.zarr
expect_failure 1 'file.zarr: is a file, not a folder: remove it first' cvol decompress wave.cvol file.zarr
expect_failure 1 'none/x.zarr: ' cvol decompress wave.cvol none/x.zarr
head -c 4000 wave.cvol >cut.cvol
expect_failure 1 'cut.cvol' cvol decompress cut.cvol cut.zarr

# Every type, and missing values.
for type in uint8 int8 uint16 int16 uint32 int32 float32 float64; do
    volume $type '9, 70, 8' kind 'z * 3 + x * y % 31 - (0 if "'$type'"[0] == "u" else 40)'
    expect_done cvol compress kind.npy kind.cvol --lossless
    expect_done cvol decompress kind.cvol kind.zarr
    written kind.zarr kind.npy
done
volume float32 '66, 3, 3' nan 'np.where(z % 2 < 1, np.nan, z)'
expect_done cvol compress nan.npy nan.cvol --lossless
expect_done cvol decompress nan.cvol nan2.zarr
"$python" -c "
import numpy as np, zarr
group = zarr.open('nan2.zarr', 'r')
assert np.array_equal(group['0'][:], np.load('nan.npy'), equal_nan=True), 'level 0'
assert (group['1'][:, 0, 0] == 2 * np.arange(33) + 1).all(), 'means must be those of the finite samples'
" || fail 'missing values'

# Labels, and a series.
volume uint8 '70, 70, 70' cells '(z // 20 + y // 20 * 4 + x // 20 * 16) * ((z - 35) ** 2 + (y - 35) ** 2 < 900)'
expect_done cvol compress cells.npy cells.cvol --labels yes
expect_done cvol decompress cells.cvol cells.ome.zarr
written cells.ome.zarr cells.npy labels
"$python" -c "
import zarr
zarr.open('cells.ome.zarr', 'r+').attrs['image-label'] = {
    'colors': [{'label-value': 1, 'rgba': [255, 0, 0, 255]}, {'label-value': 2, 'rgba': [0, 51]}],
    'properties': [{'label-value': 1, 'name': 'nerve cell'}, {'label-value': 3, 'class': 'glia'}, 7]}
"
expect_status 0 cvol compress cells.ome.zarr again.cvol
expect_sentence 'cells.ome.zarr: samples are labels: compressed without loss'
expect_done cvol info again.cvol --json
expect_equal "$(value_of attributes.labels.0.name) $(value_of attributes.labels.2.name)" 'nerve cell glia'
expect_equal "$(value_of attributes.labels.0.colour)" '[1.0,0.0,0.0]'
for format in 2 3; do # names and colours are written; others read them, and cvol has the same again
    expect_done cvol decompress again.cvol named.ome.zarr --zarr-format $format
    "$python" -c '
import json, os
name = "named.ome.zarr/zarr.json" if os.path.exists("named.ome.zarr/zarr.json") else "named.ome.zarr/.zattrs"
group = json.load(open(name))
mark = group["attributes"]["ome"]["image-label"] if "attributes" in group else group["image-label"]
assert mark.get("version") == (None if "attributes" in group else "0.4"), mark
assert mark["colors"] == [{"label-value": 1, "rgba": [255, 0, 0, 255]}], mark
assert mark["properties"] == [{"label-value": 1, "name": "nerve cell"}, {"label-value": 3, "name": "glia"}], mark
' || fail "names and colours, format $format"
    expect_status 0 cvol compress named.ome.zarr named.cvol
    expect_sentence 'named.ome.zarr: samples are labels: compressed without loss'
    expect_done cvol info named.cvol --json
    expect_equal "$(value_of attributes.labels.0.name) $(value_of attributes.labels.1.name)" 'nerve cell glia'
    expect_equal "$(value_of attributes.labels.0.colour) $(value_of attributes.labels.1.value)" '[1.0,0.0,0.0] 3'
done
cat >two.txt <<'END'
0 0 0 0 0 0 0 "Clear"
1 10 20 30 1 1 1 "a \ \"b\" <c>"
END
volume uint8 '30, 30, 30' noise 'z * 7 + y * 3 + x * 5' # which do not look like labels
expect_done cvol compress noise.npy noise.cvol --lossless --label-table two.txt
expect_done cvol decompress noise.cvol noise.ome.zarr
expect_done cvol info noise.ome.zarr --json
expect_equal "$(value_of labels.1.value)" 1
expect_done cvol compress noise.ome.zarr noisy.cvol --labels yes
expect_done cvol info noisy.cvol --json
value_of attributes.labels >named
expect_done cvol info noise.cvol --json
value_of attributes.labels | cmp - named || fail 'the same names and colours'
expect_done cvol info cells.ome.zarr/1 --json
expect_equal "$(value_of labels.1.name)" 'nerve cell'
expect_equal "$(value_of labels.1.value)" 1
cp -R cells.ome.zarr many.ome.zarr
"$python" -c "
import json
marks = json.load(open('many.ome.zarr/.zattrs'))
marks['image-label'] = {'colors': [{'label-value': 65536 - i, 'rgba': [i % 256, 0, 0]} for i in range(65536)],
                        'properties': [{'label-value': 1, 'name': 'first'}]}
json.dump(marks, open('many.ome.zarr/.zattrs', 'w'))
marks['image-label']['properties'] += [{'label-value': 70000, 'name': 'one too many'}]
json.dump(marks, open('more', 'w'))
"
expect_done cvol info many.ome.zarr --json
expect_equal "$(value_of labels.1.value) $(value_of labels.1.name)" '1 first'
mv more many.ome.zarr/.zattrs
expect_failure 1 'many.ome.zarr: has more than 65536 labels' cvol info many.ome.zarr
volume uint8 '70, 70, 70' noise 'z * 7 + y * 3 + x * 5'
expect_done cvol compress noise.npy noise.cvol --lossless
expect_done cvol decompress noise.cvol noise.ome.zarr
expect_done cvol info noise.ome.zarr --json
if grep -q '"labels"' "$out"; then fail 'samples without a mark must be no labels'; fi
"$python" -c "
import zarr
zarr.open('noise.ome.zarr', 'r+').attrs['image-label'] = {}
"
expect_done cvol compress noise.ome.zarr marked.cvol --json
expect_equal "$(value_of lossless)" true
"$python" -c "
import numpy as np, zarr
np.save('series.npy', zarr.open('image.ome.zarr', 'r')['0'][:])
"
expect_done cvol decompress series.cvol series.ome.zarr
expect_equal "$(cat "$out")" 'series.ome.zarr: 2 times, 3 channels, 9 x 7 x 5 samples of uint16'
written series.ome.zarr series.npy
expect_equal "$(head -2 "$out" | cut -d ' ' -f 1-12)" '1 micrometer 1.5 1 2 0.5 0.25 0 0 10 20 30
DAPI 0000FF 33 65420'
expect_done cvol compress series.ome.zarr again.cvol --lossless
expect_same_file again.cvol series.cvol
# OME-Zarr 0.5.
expect_done cvol decompress series.cvol series3.ome.zarr --zarr-format 3
written series3.ome.zarr series.npy
expect_equal "$(head -2 "$out" | cut -d ' ' -f 1-12)" '1 micrometer 1.5 1 2 0.5 0.25 0 0 10 20 30
DAPI 0000FF 33 65420'
expect_done cvol compress series3.ome.zarr again.cvol --lossless
expect_same_file again.cvol series.cvol
expect_done cvol decompress cells.cvol series3.ome.zarr --zarr-format 3
written series3.ome.zarr cells.npy labels
expect_done cvol decompress wave.cvol series3.ome.zarr
written series3.ome.zarr wave.npy
for type in uint8 int8 uint16 int16 uint32 int32 float32 float64; do
    volume $type '9, 70, 8' kind 'z * 3 + x * y % 31 - (0 if "'$type'"[0] == "u" else 40)'
    expect_done cvol compress kind.npy kind.cvol --lossless
    expect_done cvol decompress kind.cvol kind.zarr --zarr-format 3
    written kind.zarr kind.npy
done
cp -R v3_plain.zarr other3.zarr
expect_failure 1 'other3.zarr: is a directory that is not an image of OME-Zarr, so it is not replaced' \
    cvol decompress wave.cvol other3.zarr
expect_failure 2 '--zarr-format is 4, must be 2 or 3' cvol decompress wave.cvol x.zarr --zarr-format 4
expect_failure 2 'x.nrrd: is no folder of Zarr (.zarr): leave out --zarr-format' \
    cvol decompress wave.cvol x.nrrd --zarr-format 3
expect_done cvol decompress series.cvol one.ome.zarr --time 1 --channel 1
expect_done cvol info one.ome.zarr --channel 0 --json
expect_equal "$(value_of dims)" '[9,7,5]'
list_names
case $names in
*.cvol-*) fail 'no temporary folder must remain' ;;
esac

# ---- damaged folders -----------------------------------------------------------------------------

# change FOLDER FIELD VALUE: a copy `bad` of a folder of format 2, or 3, with another value in its metadata.
change() {
    rm -rf bad
    cp -R "$1" bad
    "$python" - "$2" "$3" <<'END'
import json, os, sys
name = "bad/zarr.json" if os.path.exists("bad/zarr.json") else "bad/.zarray"
data = json.load(open(name))
at = data
*keys, last = sys.argv[1].split(".")
for key in keys:
    at = at[int(key) if key.isdigit() else key]
if sys.argv[2] == "":
    del at[last]
else:
    at[int(last) if last.isdigit() else last] = json.loads(sys.argv[2])
json.dump(data, open(name, "w"))
END
}

# A text as a shell pattern.
plain() {
    printf %s "$1" | tr '[]' '??'
}

# refuse FOLDER FIELD VALUE PATTERN
refuse() {
    change "$1" "$2" "$3"
    expect_failure 1 "$(plain "$4")" cvol info bad
}

refuse zlib.zarr shape '[4611686018427387904,7,9]' ".zarray: 'shape' is [4611686018427387904, 7, 9], must be 1 to 8"
refuse zlib.zarr shape '[9007199254740992,9007199254740992,9]' 'bad: '
refuse zlib.zarr shape '[5,0,9]' "'shape' is [5, 0, 9], must be 1 to 8 integers from 1 to 2^53"
refuse zlib.zarr shape '[5,7]' "'chunks' is [2, 3, 4], must be 2 integers from 1 to 2^53"
expect_failure 1 'holds the 64-bit integer 9223372036854775807, which is exact neither' cvol compare \
    v3_beyond.zarr v3_beyond.zarr
expect_failure 1 'holds the 64-bit integer 18446744073709551615, which is exact neither' cvol compare \
    v3_last.zarr v3_last.zarr
refuse zlib.zarr shape '[18446744073709551615,7,9]' "'shape' is [\"18446744073709551615\", 7, 9], must be"
refuse v3_filled.zarr fill_value '"12x"' "'fill_value' is \"12x\", must be a value of the array's type"
refuse zlib.zarr shape '"5,7,9"' "'shape' is \"5,7,9\", must be"
refuse zlib.zarr shape '' "'shape' is missing, must be"
refuse zlib.zarr chunks '[0,3,4]' "'chunks' is [0, 3, 4], must be 3 integers from 1 to 2^53"
refuse zlib.zarr chunks '[1152921504606846976,3,4]' "'chunks' is [1152921504606846976, 3, 4], must be"
refuse zlib.zarr chunks '[1048576,1048576,1048576]' \
    "'chunks' is [1048576, 1048576, 1048576], a chunk of more bytes than the"
refuse zlib.zarr chunks '[3,3,4]' 'a chunk holds 48 bytes of samples, must hold 72'
refuse zlib.zarr chunks '[1,3,4]' 'a chunk holds more than 24 bytes of samples, must hold 24'
refuse zlib.zarr dtype '"<M8"' "'dtype' is \"<M8\", which is not supported (integers and floats are)"
refuse zlib.zarr dtype '"<i8"' 'a chunk holds 48 bytes of samples, must hold 192'
refuse zlib.zarr dtype '"<c8"' "'dtype' is \"<c8\", which is not supported"
refuse zlib.zarr dtype '[["a","<i2"]]' "'dtype' is [[\"a\", \"<i2\"]], must be a type"
refuse zlib.zarr order '"A"' "'order' is \"A\", must be \"C\" or \"F\""
refuse zlib.zarr fill_value '70000' "'fill_value' is 70000, must be a value of the array's type"
refuse zlib.zarr fill_value '"abc"' "'fill_value' is \"abc\", must be a value"
refuse zlib.zarr compressor '{"id":"lzma"}' \
    "'compressor' is {\"id\": \"lzma\"}, must be one of zlib, gzip, zstd, blosc, cvol, or null"
refuse zlib.zarr filters '[{"id":"delta"}]' "'filters' is [{\"id\": \"delta\"}], which are not supported"
refuse zlib.zarr zarr_format '5' "'zarr_format' is 5, must be 2 in .zarray"
refuse zlib.zarr dimension_separator '"-"' "'dimension_separator' is \"-\", must be"
refuse none.zarr dtype '"|u1"' 'a chunk holds 48 bytes of samples, must hold 24'
refuse zstd.zarr dtype '"|u1"' 'a chunk holds 48 bytes of samples, must hold 24'
refuse v3_little.zarr chunk_key_encoding.name '"x"' "'chunk_key_encoding' is {\"name\": \"x\"}, must be default or v2"
refuse v3_little.zarr data_type '"complex64"' "'data_type' is \"complex64\", which is not supported"
refuse v3_little.zarr codecs.1.name '"lzma"' "'codecs' is [{\"name\": \"bytes\""
refuse v3_little.zarr codecs '[]' "'codecs' is [], must be transpose, then bytes or cvol"
refuse v3_little.zarr chunk_grid.name '"odd"' "'chunk_grid' is {\"name\": \"odd\""
refuse v3_little.zarr zarr_format '4' "'zarr_format' is 4, must be 3 in zarr.json"
"$python" -c "
import json
data = json.load(open('v3_little.zarr/zarr.json'))
for axes in 'tc', 't', 'zy':
    changed = {**data, 'shape': [1] * len(axes), 'dimension_names': list(axes)}
    changed['chunk_grid'] = {'name': 'regular', 'configuration': {'chunk_shape': [1] * len(axes)}}
    json.dump(changed, open('axes_' + axes + '.json', 'w'))
"
for axes in tc t zy; do
    rm -rf bad
    mkdir bad
    cp axes_$axes.json bad/zarr.json
    expect_failure 1 "bad: its axes are '$axes'; a volume has the axes y and x" cvol info bad
done
refuse v3_turned.zarr codecs.0.configuration.order '[0,0,1]' "'codecs' is [{\"name\": \"transpose\""
refuse v3_shards_end.zarr codecs.0.configuration.chunk_shape '[3,2,2]' "'chunk_shape' is [3, 2, 2], must divide"
refuse v3_shards_end.zarr codecs.0.configuration.index_codecs '[]' "'index_codecs' is [], must be bytes"
refuse v3_shards_end.zarr chunk_grid.configuration.chunk_shape '[4,64,4]' 'has '

# Damaged chunks.
for name in zlib gzip zstd none; do
    rm -rf bad
    cp -R $name.zarr bad
    head -c 20 $name.zarr/1.1.1 >bad/1.1.1
    expect_failure 1 'bad/1.1.1: ' cvol info bad
    : >bad/1.1.1
    expect_failure 1 'bad/1.1.1: is empty' cvol info bad
done
head -c 3000000 /dev/zero >bad/1.1.1
expect_failure 1 'bad/1.1.1: a chunk has 3000000 bytes, more than its 48 bytes of samples can take' cvol info bad
cp -R v3_big.zarr cut
printf x | dd of=cut/c/0/0/0 bs=1 seek=6 conv=notrunc 2>/dev/null
expect_failure 1 'c/0/0/0: the check sum of a chunk is wrong' cvol info cut
rm -rf bad cut
mkdir bad
head -c 100 v3_shards_end.zarr/c/0/0/0 >part
cp -R v3_shards_end.zarr/. bad
cp part bad/c/0/0/0
expect_failure 1 "bad/c/0/0/0: has 100 bytes, but the index of its 16 chunks needs 260" cvol info bad
head -c 240 v3_shards_end.zarr/c/0/0/0 >bad/c/0/0/0
cat part part >>bad/c/0/0/0
expect_failure 1 "bad/c/0/0/0: the check sum of the shard's index is wrong" cvol info bad
for at in start end; do # of a shard's index only the sum tells that a place is another chunk's
    rm -rf bad
    cp -R v3_shards_$at.zarr bad
    "$python" - $at <<'END'
import sys
data = bytearray(open("bad/c/1/1/0", "rb").read())
index = 0 if sys.argv[1] == "start" else len(data) - 260
data[index:index + 16] = data[index + 16:index + 32]
open("bad/c/1/1/0", "wb").write(data)
END
    expect_failure 1 "bad/c/1/1/0: the check sum of the shard's index is wrong" cvol info bad
done
change v3_shards_end.zarr codecs.0.configuration.index_codecs '[{"name":"bytes","configuration":{"endian":"little"}}]'
"$python" - <<'END'
import glob
for name in glob.glob("bad/c/*/*/*"):
    data = open(name, "rb").read()[:-4]
    open(name, "wb").write(data[:-8] + b"\xff\xff\xff\x7f\0\0\0\0" if name == "bad/c/0/0/0" else data)
END
expect_failure 1 'bad/c/0/0/0: chunk 15 has 2147483647 bytes from byte ' cvol info bad
if [ $has_blosc = yes ]; then
    rm -rf bad
    cp -R blosc_lz4.zarr bad
    head -c 30 blosc_lz4.zarr/0.0.0 >bad/0.0.0
    expect_failure 1 'bad/0.0.0: its compressed samples (blosc) are damaged or cut off' cvol info bad
    cp blosc_lz4.zarr/0.0.0 bad/0.0.0
    printf '\377\377\377\077' | dd of=bad/0.0.0 bs=1 seek=4 conv=notrunc 2>/dev/null
    expect_failure 1 'bad/0.0.0: a chunk holds 1073741823 bytes of samples, must hold 48' cvol info bad
    change blosc_lz4.zarr chunks '[2,3,5]'
    expect_failure 1 'a chunk holds 48 bytes of samples, must hold 60' cvol info bad
fi

# Damaged groups.
# group VALUE PATTERN [FIELD]: the attribute `multiscales` has one entry with this value of its field.
group() {
    rm -rf bad
    cp -R units.ome.zarr bad
    "$python" - "${3:-datasets}" "$1" <<'END'
import json, sys
data = json.load(open("bad/.zattrs"))
data["multiscales"][0][sys.argv[1]] = json.loads(sys.argv[2])
json.dump(data, open("bad/.zattrs", "w"))
END
    expect_failure 1 "$(plain "$2")" cvol info bad
}
for path in ../zlib.zarr /etc .. . a/../../x a//b ''; do
    group "[{\"path\":\"$path\"}]" "bad/.zattrs: 'path' is \"$path\", must name an array inside of the folder"
done
group '[{"path":3}]' "'path' is 3, must name"
group '[{"path":"c"}]' 'bad/c: has neither .zarray nor zarr.json of an array, but the group names it as its first level'
group '[]' 'bad: is a Zarr group without multiscales'
group '[{"path":"a/b","coordinateTransformations":[{"type":"scale","scale":[1,0,1]}]}]' \
    "'coordinateTransformations' is {\"type\": \"scale\", \"scale\": [1, 0, 1]}, must be a scale (positive)"
group '[{"path":"a/b","coordinateTransformations":[{"type":"affine"}]}]' "'coordinateTransformations' is {"
group '[{"name":"y"},{"name":"x"}]' "'coordinateTransformations' is {\"scale\": [0.002, 0.5, 0.25]" axes
group '[{"name":"q"},{"name":"y"},{"name":"x"}]' "'axes' is [{\"name\": \"q\"}" axes
group '["x","y","x"]' "'axes' is [\"x\", \"y\", \"x\"], must be of t, c, z, y, x in this order, with y and x" axes
echo '{' >bad/.zattrs
expect_failure 1 'bad/.zattrs: is not JSON: line ' cvol info bad
echo '[1]' >bad/.zattrs
expect_failure 1 'bad/.zattrs: is JSON, but not an object' cvol info bad

# Missing samples are no part of the means of coarser levels.
{
    printf 'NRRD0004\ntype: short\ndimension: 3\nsizes: 70 20 10\nencoding: ascii\n\n'
    awk 'BEGIN { for (i = 0; i < 14000; i++) print (i % 3 == 0 || i % 70 > 60 ? -9999 : 100 + i % 70) }'
} >lacking.nrrd
expect_done cvol compress lacking.nrrd lacking.cvol --lossless --fill -9999
expect_done cvol decompress lacking.cvol lacking.zarr
expect_done cvol measure lacking.zarr/1 --above -9000 --json
expect_number "$(value_of inside)" '>=' 1500
expect_number "$(value_of inside)" '<' "$(value_of samples)"
expect_equal "$(value_of least)" -9999.0
expect_done cvol measure lacking.zarr/1 --above -9000 --below 99 --json
expect_equal "$(value_of inside)" 0

rm -rf bad
mkdir bad
echo '{"zarr_format": 2}' >bad/.zgroup
expect_failure 1 'bad: is a Zarr group without multiscales' cvol info bad
