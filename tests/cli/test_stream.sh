#!/bin/sh
# Compressing and decompressing slab by slab, and transcoding to coarser files.
. "$(dirname "$0")/lib.sh"

# ---- compress --stream: every input format with contiguous samples -------------------------------

dims=70x60x150
raw="--dims $dims --type int16"
make_volume in.raw int16 $dims
make_nrrd in.nrrd in.raw int16 70 60 150
expect_done cvol compress in.raw whole.cvol $raw --ratio 25
for format in mha nii nii.gz; do expect_done cvol decompress whole.cvol of_whole.$format; done
echo '{"patient": "none"}' >attributes.json

expect_status 0 cvol compress in.raw raw.cvol $raw --ratio 25 --stream
grep -q 'in.raw: .* slab by slab' "$err" || fail 'must print that it compresses slab by slab'
expect_done cvol compress in.nrrd nrrd.cvol --ratio 25 --stream --json
expect_equal "$(value_of by_slab)" true
expect_near "$(value_of ratio)" 25.25 0.25
psnr=$(value_of psnr_db)
expect_same_file raw.cvol nrrd.cvol
expect_done cvol verify raw.cvol
expect_done cvol decompress raw.cvol back.nrrd
expect_done cvol compare in.nrrd back.nrrd --json
expect_near "$(value_of psnr_db)" "$psnr" 0.01
expect_done cvol info raw.cvol --json
expect_near "$(value_of psnr_db)" "$psnr" 0.01
expect_equal "$(value_of measured)" true

for format in mha nii nii.gz; do
    expect_done cvol compress of_whole.$format f.cvol --psnr 40 --stream --json --attributes attributes.json
    expect_number "$(value_of psnr_db)" '>=' 40
    expect_done cvol verify f.cvol
    expect_done cvol info f.cvol --json
    expect_equal "$(value_of attributes.patient)" none
done
expect_done cvol compress in.nrrd bpv.cvol --bpv 0.5 --stream --json
expect_number "$(value_of bits_per_voxel)" '<=' 0.5

# Values that mark missing samples are stored like others, and compress warns.
awk 'BEGIN { for (z = 0; z < 20; z++) for (y = 0; y < 20; y++) for (x = 0; x < 20; x++)
    print z < 5 ? "1e35" : sin(x / 6) * cos(y / 9) + z / 40 }' >text.raw
{
    printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 20 20 20\nencoding: ascii\n\n'
    cat text.raw
} >marked.nrrd
expect_status 0 cvol compress marked.nrrd m.cvol --psnr 50 --stream
grep -q 'm.cvol: some samples are 1e+35, far from all others, and degrade those; only volumes' "$err" ||
    fail 'must warn of a value far from all others'

while read -r option more; do
    expect_failure 2 "--stream cannot be combined with $option: it needs DCT blocks of 16" \
        cvol compress in.nrrd x.cvol --stream $option $more
done <<END
--max-error 3
--max-error 0
--block 8
--transform dht
--keep 4,100
--lossless
--fill nan
--background auto
END
# Labels are not compressed with loss unless an option accepts that; here the file says what they are.
cp in.nrrd labels.seg.nrrd
expect_status 1 cvol compress labels.seg.nrrd x.cvol --stream
grep -q 'samples are labels, which are compressed with loss slab by slab: leave out --stream, or give --labels no' "$err" ||
    fail 'must not lose labels'
expect_status 1 cvol compress labels.seg.nrrd labels.seg.nrrd -o x.cvol --stream
for option in '--labels no' '--psnr 40'; do
    expect_status 0 cvol compress labels.seg.nrrd x.cvol --stream $option
done
rm x.cvol
# Samples below the least normal float have no step that codes them.
{
    printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 20 20 20\nencoding: ascii\n\n'
    awk 'BEGIN { for (i = 0; i < 8000; i++) printf "%de-42\n", i % 7 * 3 - 9 }'
} >small.nrrd
expect_status 1 cvol compress small.nrrd x.cvol --psnr 60 --stream
grep -q 'small.nrrd: coefficients are too large for so fine a step: ' "$err" || fail 'must print a reason'
expect_done cvol compress small.nrrd x.cvol --psnr 60
# NaN is stored as missing only in a volume that is in memory.
sed 's/^1e35$/nan/' text.raw >nan.raw
{ head -6 marked.nrrd && cat nan.raw; } >nan.nrrd
expect_done cvol compress nan.nrrd m.cvol --psnr 50
expect_status 1 cvol compress nan.nrrd x.cvol --psnr 50 --stream
grep -q 'in one slab 2000 samples are NaN .*; slab by slab they cannot be stored: use cvol compress --fill nan, without --stream' "$err" ||
    fail 'must print how to store NaN'
expect_failure 2 "--background 0 cannot be combined with --stream" cvol compress in.nrrd x.cvol --stream --background 0
expect_failure 2 'transcode' cvol compress whole.cvol x.cvol --stream
head -c 1000000 in.raw >short.raw
expect_failure 1 'short.raw: has 1000000 bytes' cvol compress short.raw x.cvol $raw --stream

# ---- decompress: more than 64 MiB takes several slabs; the whole equals its parts ----------------

dims=260x260x130
make_volume big.raw float64 $dims
expect_status 0 cvol compress big.raw big.cvol --dims $dims --type float64 --ratio 60 --stream --fast
rm big.raw
expect_done cvol decompress big.cvol big.raw
for box in 0:260,0:260,0:62 0:260,0:260,62:127 0:260,0:260,127:130; do
    expect_done cvol decompress big.cvol part.raw --box $box
    cat part.raw >>parts.raw
done
expect_same_file big.raw parts.raw
expect_done cvol decompress big.cvol coarse.raw --level 2
expect_equal "$(wc -c <coarse.raw)" "$(wc -c <big.raw)"
rm big.raw parts.raw coarse.raw part.raw

# ---- transcode -----------------------------------------------------------------------------------

expect_done cvol compress in.nrrd fine.cvol --ratio 12 --attributes attributes.json
for ratio in 20 40 100; do
    expect_done cvol transcode fine.cvol --ratio $ratio coarse.cvol --json
    expect_number "$(value_of ratio)" '>=' $ratio
    expect_equal "$(value_of measured)" false
    promised=$(value_of psnr_db)
    bound=$(value_of l2_error)
    expect_done cvol verify coarse.cvol
    expect_done cvol decompress coarse.cvol coarse.nrrd
    expect_done cvol compare in.nrrd coarse.nrrd --json
    expect_number "$(value_of psnr_db)" '>=' "$promised"
    expect_done cvol info coarse.cvol --json
    expect_near "$(value_of l2_error)" "$bound" 0.001
    expect_equal "$(value_of attributes.patient)" none
done
expect_done cvol transcode fine.cvol coarse.cvol --bpv 0.2 --json
expect_number "$(value_of bits_per_voxel)" '<=' 0.2
expect_failure 1 'finer than the array' cvol transcode fine.cvol x.cvol --ratio 5
expect_failure 1 'cannot be promised' cvol transcode fine.cvol x.cvol --psnr 90
expect_failure 2 'one of --ratio' cvol transcode fine.cvol x.cvol
expect_failure 2 'one of --ratio' cvol transcode fine.cvol x.cvol --ratio 20 --bpv 1
expect_failure 2 'must end in .cvol' cvol transcode fine.cvol x.nrrd --ratio 20
expect_failure 1 'not a .cvol' cvol transcode in.nrrd x.cvol --ratio 20
expect_failure 1 'same file' cvol transcode fine.cvol fine.cvol --ratio 20
