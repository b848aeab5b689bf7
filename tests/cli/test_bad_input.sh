#!/bin/sh
# Broken files and files whose header contradicts their data: one sentence that names the file, status 1, no new
# file, and existing outputs stay unchanged.
. "$(dirname "$0")/lib.sh"

echo old >out.cvol
cp out.cvol old.cvol
echo old >out.nrrd
cp out.nrrd old.nrrd
echo old >out.png
cp out.png old.png
make_volume in.raw uint8 6x5x4
make_nrrd in.nrrd in.raw uint8 6 5 4

# refuse PATTERN FILE [OPTION...]: compressing FILE fails with status 1.
refuse() {
    refuse_pattern=$1
    refuse_file=$2
    shift 2
    expect_failure 1 "$refuse_file:*$refuse_pattern" cvol compress "$refuse_file" out.cvol "$@"
    expect_same_file out.cvol old.cvol
}

# ---- files that are no volumes -------------------------------------------------------------------

: >empty
: >empty.nrrd
: >empty.mha
: >empty.nii
: >empty.nii.gz
: >empty.cvol
mkdir folder folder.nrrd folder.cvol
printf 'some text\n' >text
printf 'some text\n' >text.nrrd
printf 'some text\n' >text.mhd
printf 'some text\n' >text.nii
printf 'some text\n' >text.nii.gz
printf 'some text\n' >text.cvol
printf '\211PNG\r\n\032\n' >picture.png
mkfifo pipe.nrrd
for pair in 'empty:is empty' 'folder:is a directory' 'folder.nrrd:is a directory' \
    'missing.nrrd:No such file' 'missing:No such file' 'empty.nrrd:is empty' 'empty.mha:is empty' \
    'empty.nii:is empty' 'empty.nii.gz:is empty' 'empty.cvol:is empty' 'text:known by content or name' \
    'text.cvol:known by content or name' 'text.nrrd:NRRD' 'text.mhd:line 1' 'text.nii:' \
    'text.nii.gz:' 'pipe.nrrd:is not a regular file'; do
    file=${pair%%:*}
    pattern=${pair#*:}
    refuse "$pattern" "$file"
    expect_failure 1 "$file:*$pattern" cvol info "$file"
    expect_failure 1 "$file:*$pattern" cvol info "$file" --json
    expect_failure 1 "$file:*$pattern" cvol render "$file" -o out.png
    expect_failure 1 "$file:*$pattern" cvol compare in.nrrd "$file"
    expect_failure 1 "$file:" cvol decompress "$file" out.nrrd
done
expect_failure 1 'missing: No such file' cvol bench render missing
expect_failure 1 'in.raw: is not a .cvol file' cvol decompress in.raw out.nrrd
expect_failure 1 'folder.cvol: is a directory' cvol decompress folder.cvol out.nrrd
expect_same_file out.png old.png
expect_same_file out.nrrd old.nrrd

# Pictures: a broken one, and a picture compared with a volume.
expect_failure 1 'picture.png:' cvol compare picture.png picture.png
expect_failure 1 'picture.png: is a picture, not a volume' cvol compare in.nrrd picture.png
expect_done cvol render in.nrrd -o small.png --size 8 --engine ray
expect_done cvol render in.nrrd -o large.png --size 9 --engine ray
expect_failure 1 'picture.png' cvol compare small.png picture.png
expect_failure 1 '8 x 8' cvol compare small.png large.png
expect_failure 1 'picture.png: is a picture, not a volume' cvol info picture.png
expect_failure 1 'picture.png: is a picture, not a volume' cvol render picture.png -o out.png
expect_failure 2 'is a picture:*must end in .cvi' cvol compress small.png out.cvol
expect_failure 1 'picture.png' cvol compress picture.png out.cvi
expect_same_file out.cvol old.cvol
[ ! -e out.cvi ] || fail 'must not create a picture'
make_volume other.raw uint8 6x5x5
make_nrrd other.nrrd other.raw uint8 6 5 5
expect_failure 1 'in.nrrd and other.nrrd:*cannot be compared' cvol compare in.nrrd other.nrrd

# ---- NRRD: each field ----------------------------------------------------------------------------

# nrrd PATTERN FIELD VALUE: a valid header with this one field changed.
nrrd() {
    {
        echo NRRD0004
        for pair in 'type: uint8' 'dimension: 3' 'sizes: 6 5 4' 'encoding: raw' 'endian: little'; do
            case $pair in
            "$2:"*) ;;
            *) echo "$pair" ;;
            esac
        done
        [ "$3" = none ] || echo "$2: $3"
        echo
        cat in.raw
    } >lie.nrrd
    refuse "$1" lie.nrrd
}

accept_header() { # the unchanged header is valid
    expect_done cvol info "$1"
}
accept_header in.nrrd
nrrd "'0'" sizes '6 0 4'
nrrd "'-5'" sizes '6 -5 4'
nrrd '' sizes '2147483648 5 4'
nrrd 'limit' sizes '2147483648 2147483648 4'
nrrd 'limit' sizes '4294967296 4294967296 4294967296'
nrrd '99999999999999999999' sizes '99999999999999999999 1 1'
nrrd '120 of the 144 bytes' sizes '6 6 4'
nrrd 'more than the 96 bytes' sizes '6 4 4'
nrrd 'sizes has 2 values' sizes '6 20'
nrrd 'sizes' sizes 'six five four'
nrrd "kinds 'RGB-color domain domain' have an axis of colours, which is not supported: write each" kinds 'RGB-color domain domain'
nrrd "no 'sizes'" sizes none
nrrd 'type' type uint7
nrrd 'type' type block
nrrd '120 of the 960 bytes' type 'long long'
nrrd '120 of the 240 bytes' type int16
nrrd "no 'type'" type none
nrrd 'dimension' dimension 0
nrrd 'dimension' dimension -3
nrrd 'dimension' dimension 2147483648
nrrd 'sizes has 3 values, dimension is 2' dimension 2
nrrd 'encoding' encoding zip
nrrd 'encoding' encoding bzip2
nrrd '' encoding gzip
nrrd "of the 120 samples" encoding ascii
nrrd "no 'encoding'" encoding none
nrrd 'endian' endian middle
nrrd 'spacing' spacings '1 0 1'
nrrd 'spacing' spacings '1 -1 1'
nrrd 'spacing' spacings '1 inf 1'
nrrd 'space directions' 'space directions' '(1,0,0) (0,1,0)'
nrrd 'space directions' 'space directions' '(1,0,0) (0,0,0) (0,0,1)'
nrrd 'do not span' 'space directions' '(1,0,0) (1,0,0) (0,0,1)'
nrrd 'its data file*missing.raw: No such file' 'data file' missing.raw
nrrd 'its data file*folder: is a directory' 'data file' folder
nrrd '' 'byte skip' 1000
nrrd '' 'line skip' 1000
nrrd '' 'byte skip' -5

# ---- MetaImage -----------------------------------------------------------------------------------

meta() {
    {
        for pair in 'ObjectType = Image' 'NDims = 3' 'DimSize = 6 5 4' 'ElementType = MET_UCHAR' \
            'ElementDataFile = LOCAL'; do
            case $pair in
            "$2 ="*) [ "$3" = none ] || echo "$2 = $3" ;;
            ElementDataFile*)
                case $2 in DimSize | NDims | ObjectType | ElementType) ;; *) echo "$2 = $3" ;; esac
                echo "$pair"
                ;;
            *) echo "$pair" ;;
            esac
        done
        cat in.raw
    } >lie.mha
    refuse "$1" lie.mha
}

meta "'0'" DimSize '6 0 4'
meta "'-5'" DimSize '6 -5 4'
meta '' DimSize '2147483648 5 4'
meta 'limit' DimSize '2147483648 2147483648 4'
meta 'limit' DimSize '4294967296 4294967296 4294967296'
meta 'DimSize' DimSize '99999999999999999999 1 1'
meta '120 of the 144 bytes' DimSize '6 6 4'
meta 'DimSize has 2 values' DimSize '6 20'
meta 'DimSize' DimSize none
meta 'ElementType' ElementType MET_NOTHING
meta '120 of the 960 bytes' ElementType MET_LONG_LONG
meta '120 of the 240 bytes' ElementType MET_SHORT
meta 'ElementType' ElementType none
meta 'NDims' NDims 0
meta 'NDims' NDims -1
meta 'NDims' NDims 2147483648
meta '' ElementSpacing '1 0 1'
meta '' ElementSpacing '1 -1 1'
meta '' ElementSpacing '1 nan 1'
meta '' CompressedData True
meta 'CompressedData' CompressedData Maybe
meta '' HeaderSize 1000
meta "ElementNumberOfChannels '3' is not supported: write each channel" ElementNumberOfChannels 3
printf 'ObjectType = Image\nNDims = 3\nDimSize = 6 5 4\nElementType = MET_UCHAR\nElementDataFile = %s\n' \
    in.raw >good.mhd
expect_done cvol info good.mhd
# A header may name another file only if the user allows it, and the samples must fit into the memory that he allows.
expect_failure 1 'good.mhd: field ElementDataFile: *another file, in.raw*' cvol compress good.mhd d.cvol --no-external
expect_done cvol compress good.mhd d.cvol --lossless
expect_done cvol decompress d.cvol detached.nhdr
expect_failure 1 'detached.nhdr: *another file, detached.raw*' cvol compress detached.nhdr d.cvol --no-external
expect_failure 1 'good.mhd: *limit*' cvol compress good.mhd d.cvol --memory-limit 1e-8
for limit in 0 -3 much; do
    expect_failure 2 "--memory-limit is '$limit', must be a number above 0" cvol info good.mhd --memory-limit $limit
done
expect_done cvol compress good.mhd d.cvol --lossless --memory-limit 0.5
for name in missing.raw folder empty 'LIST' 'slice%d.raw 1 4 1'; do
    printf 'ObjectType = Image\nNDims = 3\nDimSize = 6 5 4\nElementType = MET_UCHAR\nElementDataFile = %s\n' \
        "$name" >lie.mhd
    refuse '' lie.mhd
done

# ---- NIfTI ---------------------------------------------------------------------------------------

expect_done cvol compress in.nrrd good.cvol --max-error 0
expect_done cvol decompress good.cvol good.nii
expect_done cvol info good.nii

# nifti PATTERN OFFSET KIND VALUE ...: overwrites bytes of a valid header.
nifti() {
    nifti_pattern=$1
    shift
    cp good.nii lie.nii
    poke lie.nii "$@"
    refuse "$nifti_pattern" lie.nii
}

nifti '' 42 i16 0                                # dim: axis x
nifti '' 42 i16 -6                               #
nifti '' 42 i16 32767 44 i16 32767 46 i16 32767  # (sizes have 16 bits)
nifti '' 42 i16 7                                # one more than the file has
nifti '' 40 i16 0                                # the number of axes
nifti '' 40 i16 -3                               #
nifti '' 40 i16 8                                #
cp good.nii lie.nii
poke lie.nii 40 i16 4 48 i16 5 # five volumes in the header, one in the file
expect_failure 2 'lie.nii: has 5 volumes; choose one with --time 0 to 4' cvol compare lie.nii lie.nii
refuse 'holds 0 of the' lie.nii --index 4
nifti 'datatype' 70 i16 0                        #
nifti 'datatype' 70 i16 77                       #
nifti 'datatype' 70 i16 1792                     # complex of doubles
nifti '120 of the 960 bytes' 70 i16 32           # complex of floats
nifti '' 70 i16 512 72 i16 16                    # twice as many bytes
nifti 'vox_offset' 108 f32 -352                  #
nifti '' 108 f32 1e9                             #
nifti 'vox_offset' 108 f32 nan                   #
nifti '' 252 i16 0 254 i16 0 80 f32 nan          # pixdim, without a matrix
nifti '' 252 i16 0 254 i16 0 84 f32 inf          #
nifti '' 280 f32 nan                             # the matrix
nifti '' 284 f32 inf                             #
nifti '' 344 u8 120                              # magic
nifti '' 0 i32 347                               # sizeof_hdr
cp good.nii pair.hdr
poke pair.hdr 345 u8 105 108 f32 0 # "ni1": the samples are in pair.img
refuse '' pair.hdr
cp in.raw pair.img
expect_done cvol info pair.hdr --json
expect_equal "$(value_of dims)" '[6,5,4]'
# NIfTI-2 stores sizes in 64 bits.
make_volume long.raw uint8 40000x1x1
make_nrrd long.nrrd long.raw uint8 40000 1 1
expect_done cvol compress long.nrrd long.cvol --max-error 0
expect_done cvol decompress long.cvol long.nii
expect_done cvol info long.nii --json
expect_equal "$(value_of dims)" '[40000,1,1]'
for size in 0 -1 2147483648 4611686018427387904; do
    cp long.nii lie.nii
    poke lie.nii 24 i64 $size
    refuse '' lie.nii
done
cp long.nii lie.nii
poke lie.nii 24 i64 4294967296 32 i64 4294967296 40 i64 4294967296
refuse '' lie.nii

# ---- truncated and damaged compressed samples ----------------------------------------------------

expect_done cvol decompress good.cvol good.nii.gz
gzip -c in.raw >in.gz
{ printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 6 5 4\nencoding: gzip\n\n'; cat in.gz; } >good.nrrd
expect_done cvol info good.nrrd
for file in good.nii.gz good.nrrd good.nii; do
    size=$(wc -c <$file)
    for share in 1 3 10 30 50 70 90 95 99; do
        head -c $((size * share / 100)) $file >cut.${file#good.}
        refuse '' cut.${file#good.}
    done
    head -c $((size - 1)) $file >cut.${file#good.}
    refuse '' cut.${file#good.}
done
cp good.nii.gz flip.nii.gz
poke flip.nii.gz $(($(wc -c <good.nii.gz) - 6)) xor 1 # its checksum
refuse '' flip.nii.gz

# ---- raw -----------------------------------------------------------------------------------------

refuse 'has 120 bytes' in.raw --dims 6x5x5 --type uint8
refuse 'has 120 bytes' in.raw --dims 6x5x3 --type uint8
refuse 'has 120 bytes' in.raw --dims 6x5x4 --type int16
refuse 'has 120 bytes' in.raw --dims 2147483648x1x1 --type uint8
refuse 'limit' in.raw --dims 4294967296x4294967296x4294967296 --type uint8
refuse 'limit' in.raw --dims 4611686018427387904x4x1 --type float64
refuse 'is empty' empty --dims 6x5x4 --type uint8
refuse 'is a directory' folder --dims 6x5x4 --type uint8
refuse 'No such file' missing --dims 6x5x4 --type uint8

# ---- NaN and infinity ----------------------------------------------------------------------------

for type in float32 float64; do
    kind=f${type#float}
    size=$((${type#float} / 8))
    make_volume nan.raw $type 6x5x4
    cp nan.raw fine.raw
    poke nan.raw $((size * 17)) $kind nan $((size * 18)) $kind inf $((size * 100)) $kind -inf
    raw="--dims 6x5x4 --type $type"
    refuse '3 samples are NaN or infinite*index 17*--fill' nan.raw $raw
    expect_failure 1 'nan.raw:*3 samples*index 17' cvol render nan.raw -o out.png $raw
    expect_failure 1 'nan.raw:*3 samples*index 17' cvol bench render nan.raw $raw
    expect_failure 2 '--fill' cvol render nan.raw -o out.png $raw --fill nan
    for way in '--lossless' '--fill nan --lossless'; do
        expect_done cvol compress nan.raw masked.cvol $raw $way
        expect_done cvol decompress masked.cvol masked.raw
        expect_same_file masked.raw nan.raw
    done
    expect_done cvol compress nan.raw masked.cvol $raw --fill nan --max-error 1
    expect_done cvol verify masked.cvol
    expect_done cvol info nan.raw $raw --json
    expect_equal "$(value_of nan_or_infinite)" 3
    expect_done cvol compress nan.raw filled.cvol $raw --fill 0.5 --psnr 100
    expect_done cvol compare fine.raw nan.raw $raw --json
    expect_equal "$(value_of max_abs_error)" null
    expect_done cvol compare nan.raw filled.cvol $raw --fill 0.5 --json
    expect_number "$(value_of psnr_db number)" '>=' 100
    expect_status 0 cvol render nan.raw -o nan.png $raw --fill 0 --size 16
done
expect_failure 2 'cannot fill samples of float32' cvol compress nan.raw out.cvol --dims 6x5x8 \
    --type float32 --fill 1e39
make_volume nan.raw float32 6x5x4
poke nan.raw 8 f32 nan
make_nrrd nan.nrrd nan.raw float 6 5 4
# NaN samples are masked, also without --fill.
expect_done cvol compress nan.nrrd masked.cvol --psnr 40
expect_done cvol decompress masked.cvol masked.nrrd
expect_done cvol info masked.nrrd --json
expect_equal "$(value_of nan_or_infinite)" 1
expect_done cvol compress nan.nrrd filled.cvol --fill -1 --psnr 40

expect_same_file out.cvol old.cvol
expect_same_file out.nrrd old.nrrd
expect_same_file out.png old.png

# ---- inputs found by fuzzing ---------------------------------------------------------------------

# Each input runs in its own folder: some formats read other files of the folder.
for crasher in "$(dirname "$CVOL_DOC")"/tests/crashers/*; do
    mkdir alone
    cp "$crasher" alone
    run cvol compress "alone/$(basename "$crasher")" crasher.cvol
    case $status in
    0 | 1 | 2) ;;
    *) fail "$crasher must be read or refused" ;;
    esac
    rm -rf alone crasher.cvol
done
