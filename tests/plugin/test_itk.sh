#!/bin/sh
# Images of ITK: what libcvol_itk.so reads from .cvol files, and writes, against the command.
# usage: test_itk.sh ITK_COPY, with the variables of tests/cli, and ITK_AUTOLOAD_PATH.
# shellcheck disable=SC1091,SC2154
itk_copy=$1
. "${0%/*}/../cli/lib.sh"

make_field head.nii.gz spots 40x50x30 1.5 10 1,2,3
expect_done cvol compress head.nii.gz head.cvol

# The samples are those of the command; axes are in ITK's patient space (LPS).
expect_done cvol decompress head.cvol expected.raw
expect_done "$itk_copy" head.cvol head.raw again.cvol
expect_same_file head.raw expected.raw
cp "$out" geometry.json
expect_done cvol info head.cvol --json
expect_equal "$(value_of space)" RAS
cp "$out" info.json
for axis in 0 1 2; do
    case $axis in 2) sign= ;; *) sign=- ;; esac
    expect_number "$(json_get $axis.size <geometry.json)" '==' "$(json_get dims.$axis <info.json)"
    expect_near "$(json_get $axis.spacing <geometry.json)" "$(json_get spacing.$axis <info.json)" 1e-6
    expect_near "$(json_get $axis.origin <geometry.json)" "$(awk "BEGIN { print $sign($(json_get origin.$axis <info.json)) }")" 1e-4
    for other in 0 1 2; do
        case $other in 2) sign= ;; *) sign=- ;; esac
        value=$(json_get directions.$axis.$other <info.json)
        expect_near "$(json_get $axis.direction.$other <geometry.json)" "$(awk "BEGIN { print $sign($value) }")" 1e-4
    done
done
# Files that ITK writes are lossless, and have the same geometry.
expect_done cvol info again.cvol --json
expect_equal "$(value_of exact)" true
expect_equal "$(value_of space)" LPS
expect_done "$itk_copy" again.cvol again.raw
expect_same_file again.raw head.raw
expect_same_file "$out" geometry.json

# Lengths of ITK are millimetres: those of other units are converted.
{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspace dimension: 3\n'
    printf 'space directions: (250,0,0) (0,500,0) (0,0,4)\nspace origin: (1000,-2000,3)\n'
    printf 'space units: "um" "um" "um"\n\n\1\2\3\4\5\6\7\10'
} >small.nrrd
expect_done cvol compress small.nrrd small.cvol --lossless
expect_done "$itk_copy" small.cvol small.raw small-again.cvol
for pair in 0.spacing=0.25 1.spacing=0.5 2.spacing=0.004 0.origin=1 1.origin=-2 2.origin=0.003; do
    expect_near "$(value_of "${pair%=*}")" "${pair#*=}" 1e-9
done
expect_done cvol info small-again.cvol --json
expect_equal "$(value_of unit) $(value_of spacing)" 'mm [0.25,0.5,0.004]'

# A region.
expect_done "$itk_copy" head.cvol box.raw 3 20 5 31 7 9
expect_done cvol decompress head.cvol expected.raw --box 3:20,5:31,7:9
expect_same_file box.raw expected.raw

# Values that a file states are floats.
printf '%s\n' 'ObjectType = Image' 'NDims = 3' 'DimSize = 2 2 2' 'ElementType = MET_UCHAR' >eight.mha
cp eight.mha scaled.mha
printf '%s\n' 'ElementToIntensityFunctionSlope = 2' 'ElementToIntensityFunctionOffset = -10' >>scaled.mha
for name in eight scaled; do
    printf 'ElementDataFile = LOCAL\n\1\2\3\4\5\6\7\10' >>$name.mha
    expect_done cvol compress $name.mha $name.cvol --lossless
    expect_done "$itk_copy" $name.cvol $name.raw
    case $name in eight) type=unsigned_char ;; *) type=float ;; esac
    expect_equal "$(value_of type)" $type
done
expect_equal "$(od -An -tu1 eight.raw | tr -s ' ')" ' 1 2 3 4 5 6 7 8'
expect_equal "$(od -An -tf4 scaled.raw | tr -s ' \n' ' ' | sed 's/ *$//')" ' -8 -6 -4 -2 0 2 4 6'

# Times are a fourth dimension, channels components.
expect_done cvol scale head.cvol -o twice.cvol --factor 2
expect_done cvol scale head.cvol -o thrice.cvol --factor 3
expect_done cvol compress head.cvol twice.cvol thrice.cvol -o times.cvol --time-step 2
expect_done "$itk_copy" times.cvol times.raw
expect_equal "$(value_of dimensions)" 4
expect_equal "$(value_of 3.size)" 3
expect_number "$(value_of 3.spacing)" '==' 2
for time in 0 1 2; do expect_done cvol decompress times.cvol $time.raw --time $time; done
cat 0.raw 1.raw 2.raw >expected.raw
expect_same_file times.raw expected.raw
expect_other_file 0.raw 1.raw
expect_done cvol compress head.cvol twice.cvol -o channels.cvol --as channels
expect_done "$itk_copy" channels.cvol channels.raw
expect_equal "$(value_of components)" 2
expect_equal "$(value_of dimensions)" 3
for channel in 0 1; do
    expect_done cvol decompress channels.cvol $channel.raw --channel $channel
    od -An -v -tx4 -w4 $channel.raw | tr -d ' ' >$channel.txt
done
paste -d ' ' 0.txt 1.txt >expected.txt
od -An -v -tx4 -w8 channels.raw | sed 's/^ *//; s/  */ /g' >channels.txt
expect_same_file channels.txt expected.txt
expect_status 1 "$itk_copy" channels.cvol channels.raw no.cvol
grep -q 'a pixel has 2 components' "$err" || fail 'must name the components'
expect_no_file no.cvol

# Damaged files give the library's sentence.
head -c 3000 head.cvol >cut.cvol
expect_status 1 "$itk_copy" cut.cvol cut.raw
grep -q 'cut.cvol: truncated' "$err" || fail 'must say that the file is truncated'
