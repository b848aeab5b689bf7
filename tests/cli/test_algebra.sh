#!/bin/sh
# Arithmetic on compressed volumes: every command, its output, its errors, and pictures of results.
. "$(dirname "$0")/lib.sh"

dims=40x36x34
samples=$((40 * 36 * 34))
make_volume a.raw uint8 $dims
make_volume c.raw uint16 $dims
make_nrrd a.nrrd a.raw uint8 40 36 34
make_nrrd c.nrrd c.raw uint16 40 36 34
expect_done cvol compress a.nrrd a.cvol --psnr 50
expect_done cvol scale a.cvol -o b.cvol --factor 0.5 --offset 10

# ---- other transforms, and whole volumes ---------------------------------------------------------

for transform in dct dht dft; do
    for block in 0 8 16; do
        [ $transform$block != dct8 ] && [ $transform$block != dct16 ] || continue
        expect_done cvol compress a.nrrd t.cvol --transform $transform --block $block --psnr 35 --json
        expect_equal "$(value_of transform)" $transform
        expect_equal "$(value_of block)" $block
        expect_equal "$(value_of rank)" 3
        expect_number "$(value_of psnr_db number)" '>=' 34.5
        psnr=$(value_of psnr_db)
        most=$(value_of max_error)
        bytes=$(value_of file_bytes)
        expect_equal "$(wc -c <t.cvol)" "$bytes"
        expect_done cvol compare a.nrrd t.cvol --json
        expect_near "$(value_of psnr_db number)" "$psnr" 0.001
        expect_near "$(value_of max_abs_error number)" "$most" 1e-6
        expect_done cvol info t.cvol --json
        expect_equal "$(value_of measured boolean)" true
        for field in l2_error:number point_error:number max_abs:number value_min:number value_max:number rank:integer \
            low:array rms_bound:number transform:string; do
            expect_field "${field%:*}" "${field#*:}"
        done
        expect_near "$(value_of psnr_db)" "$psnr" 0.001
        expect_done cvol decompress t.cvol t.nrrd
        expect_done cvol compare t.cvol t.nrrd --json
        expect_equal "$(value_of max_abs_error)" 0.0
        expect_failure 1 'needs a volume in DCT blocks' cvol render t.cvol -o t.png --size 32
    done
done
expect_done cvol info a.cvol
grep -q 'error bound (L2) ' "$out" || fail 'must print the bound'

expect_done cvol compress a.nrrd w.cvol --transform dct --block 0 --keep 12,500 --json
expect_equal "$(value_of low)" '[12,12,12]'
expect_equal "$(value_of coefficients)" $((12 * 12 * 12 + 500))
expect_done cvol compress a.nrrd w2.cvol --transform dct --block 0 --ratio 20
expect_done cvol compress a.nrrd k.cvol --keep 2,4000 --json
expect_equal "$(value_of transform)$(value_of block)" dct16
expect_done cvol render k.cvol -o k.png --size 64
expect_done cvol render t.cvol -o t.png --size 32 --engine ray --mode mip
expect_failure 2 'only one of' cvol compress a.nrrd x.cvol --keep 1,1 --ratio 3
expect_failure 2 'needs DCT blocks' cvol compress a.nrrd x.cvol --block 0 --max-error 3
for wrong in '' x 3 3, ,3 -1,3 3,-1 3,4,5 3.5,1 0,0; do
    expect_failure 2 "--keep is '$wrong'" cvol compress a.nrrd x.cvol --keep "$wrong"
done
expect_failure 2 '35' cvol compress a.nrrd x.cvol --block 0 --keep 35,0
expect_failure 2 "$((samples + 1))" cvol compress a.nrrd x.cvol --block 0 --keep 1,$((samples + 1))

# Ranks 1 and 2.
make_volume line.raw float32 700x1x1
expect_done cvol compress line.raw line.cvol --dims 700x1x1 --type float32 --transform dft --block 0 \
    --keep 5,60 --json
expect_equal "$(value_of rank)" 1
make_volume plane.raw int16 60x50x1
for transform in dct dht dft; do
    expect_done cvol compress plane.raw plane.cvol --dims 60x50x1 --type int16 \
        --transform $transform --block 0 --ratio 10 --json
    expect_equal "$(value_of rank)" 2
    expect_done cvol multiply plane.cvol plane.cvol -o square.cvol --json
    expect_field l2_error number
done

# ---- results: printed fields, and the bound holds ------------------------------------------------

# check_result: after COMMAND -o r.cvol --json; checks the fields, and that the file has the same values.
check_result() {
    for field in output:string dims:array type:string rank:integer transform:string block:integer \
        terms:integer file_bytes:integer ratio:number l2_error:number rms_bound:number \
        point_error:number max_abs:number value_min:number value_max:number; do
        expect_field "${field%:*}" "${field#*:}"
    done
    expect_equal "$(value_of output)" r.cvol
    expect_equal "$(value_of dims)" '[40,36,34]'
    expect_equal "$(value_of file_bytes)" "$(wc -c <r.cvol)"
    # (max_abs of the file may be smaller: the file's blocks were evaluated for their ranges.)
    for key in l2_error rms_bound value_min value_max rank transform block type; do
        value_of $key
    done >result
    rms=$(value_of rms_bound)
    point=$(value_of point_error)
    expect_number "$point" '<=' "$(value_of l2_error)"
    expect_done cvol info r.cvol --json
    # Files round it up to 13 bits.
    expect_number "$(value_of point_error)" '<=' "$(awk "BEGIN { printf \"%.17g\", $point * (1 + 1 / 4096) }")"
    expect_number "$(value_of point_error)" '>=' "$(awk "BEGIN { printf \"%.17g\", $point * (1 - 1e-9) }")"
    for key in l2_error rms_bound value_min value_max rank transform block type; do
        value_of $key
    done >reported
    expect_same_file result reported
    expect_equal "$(value_of measured boolean)" false
}

# Exact results from the original samples, as raw floats: sum and square, from lossless files.
expect_done cvol compress a.nrrd exact.cvol --max-error 0

expect_done cvol add a.cvol b.cvol -o r.cvol --alpha 2 --beta -1.5 --json
check_result
expect_equal "$(value_of type)" float32
expect_done cvol add a.cvol b.cvol -o r.cvol
expect_equal "$(wc -l <"$out")" 1
grep -q 'error bound: RMS <= .* (L2 ' "$out" || fail 'must print the bound'

# a - a is 0, and a + 0 is a.
expect_done cvol add a.cvol a.cvol -o zero.cvol --beta -1
expect_done cvol stats zero.cvol --json
expect_near "$(value_of l2_norm)" 0 1
expect_done cvol add a.cvol a.cvol -o r.cvol --beta 0 --type uint8 --json
check_result
expect_equal "$(value_of type)" uint8
expect_done cvol compare a.nrrd r.cvol --json
expect_number "$(value_of rmse number)" '<=' "$(awk "BEGIN { print $rms + 0.5 }")"

for plan in 0 1; do
    [ $plan = 0 ] && operand=a.cvol || operand=w.cvol
    expect_done cvol multiply $operand $operand -o r.cvol --json
    check_result
    expect_number "$(value_of value_max)" '>=' 1
    expect_done cvol multiply $operand $operand -o r.cvol --explain
    grep -q '^plan ' "$out" || fail 'must print the plan'
done
expect_done cvol multiply w.cvol w2.cvol -o r.cvol --plan full --json
expect_equal "$(value_of plan string)" full
expect_field reason string
expect_field cost_ms.full number
expect_done cvol multiply w.cvol w2.cvol -o r.cvol --plan grid --keep 10,100 --json
expect_equal "$(value_of plan string)" grid
expect_equal "$(value_of terms)" 1100
for wrong in '' x blocky Auto; do
    expect_failure 2 "--plan is '$wrong'" cvol multiply a.cvol a.cvol -o x.cvol --plan "$wrong"
done
expect_failure 2 'must be auto, direct, grid, full, sparse, blocks or low' cvol multiply a.cvol a.cvol -o x.cvol --plan x
expect_failure 1 'direct' cvol multiply a.cvol a.cvol -o x.cvol --plan direct

for kernel in gaussian:1.5 box:3 laplacian unsharp:1 unsharp:1,0.5 derivative:x derivative:z; do
    expect_done cvol convolve a.cvol --kernel $kernel -o r.cvol --json
    check_result
    expect_done cvol render r.cvol -o r.png --size 48
    expect_done cvol convolve w.cvol --kernel $kernel -o r.cvol --json
    check_result
done
# Another volume as the filter: the circular convolution, against the direct sum.
awk 'BEGIN { for (i = 0; i < 128; i++) printf "\\%03o", i * 37 % 61 }' >bytes.txt
printf "$(cat bytes.txt)" >p.raw
awk 'BEGIN { for (i = 0; i < 128; i++) printf "\\%03o", i == 3 ? 1 : i == 9 ? 2 : i == 97 ? 1 : 0 }' >bytes.txt
printf "$(cat bytes.txt)" >q.raw
for transform in dft dht; do
    for name in p q; do
        expect_done cvol compress $name.raw $name.cvol --dims 8x4x4 --type uint8 --transform $transform --block 0 --keep 1,127
    done
    expect_done cvol convolve p.cvol --kernel q.cvol -o r.cvol --lossless-algebra --type uint16
    expect_done cvol decompress r.cvol r.raw
    od -An -v -tu1 -w1 p.raw >p.txt
    od -An -v -tu1 -w1 q.raw >q.txt
    od -An -v -tu2 -w2 r.raw >r.txt
    paste p.txt q.txt r.txt | awk '
        { p[NR - 1] = $1; q[NR - 1] = $2; r[NR - 1] = $3 }
        END {
            for (i = 0; i < 128; i++) {
                sum = 0
                for (j = 0; j < 128; j++)
                    if (q[j]) {
                        x = (i % 8 - j % 8 + 8) % 8
                        y = (int(i / 8) % 4 - int(j / 8) % 4 + 4) % 4
                        z = (int(i / 32) - int(j / 32) + 4) % 4
                        sum += q[j] * p[x + 8 * (y + 4 * z)]
                    }
                bad += sum != r[i]
            }
            exit NR != 128 || bad > 0
        }' || fail 'the convolution of two volumes differs from the direct sum'
done
expect_failure 1 'dft' cvol convolve w.cvol --kernel w.cvol -o x.cvol
expect_failure 1 'none.cvol: ' cvol convolve w.cvol --kernel none.cvol -o x.cvol
echo '{"taps": [0.25, 0.5, 0.25]}' >taps.json
expect_done cvol convolve a.cvol --kernel taps.json -o r.cvol --json
check_result
# A local mean changes the global mean only slightly.
expect_done cvol stats r.cvol --json
mean=$(value_of mean)
expect_done cvol stats a.cvol --json
expect_near "$mean" "$(value_of mean)" 3

expect_done cvol scale a.cvol -o r.cvol --factor -1 --offset 255 --type uint8 --json
check_result
expect_done cvol scale r.cvol -o r2.cvol --factor -1 --offset 255 --type uint8
expect_done cvol compare a.cvol r2.cvol --json
expect_number "$(value_of max_abs_error)" '<=' 1

expect_done cvol gradient a.cvol -o r.cvol --json
check_result
expect_done cvol gradient w.cvol -o r.cvol --json
check_result
expect_done cvol gradient a.cvol -o r.cvol --step 4 --json
check_result

# What results lose: by default a fifth of the bound at most; --rms says how much; --lossless-algebra nothing.
bound=$(expect_done cvol info a.cvol --json && value_of l2_error)
samples_root=$(awk "BEGIN { print sqrt($samples) }")
expect_done cvol gradient a.cvol -o r.cvol --json
expect_number "$(value_of l2_error)" '<=' "$(awk "BEGIN { print 1.2001 * sqrt(3) * $bound }")"
bytes=$(value_of file_bytes)
expect_done cvol gradient a.cvol -o r.cvol --rms 2 --json
expect_number "$(value_of l2_error)" '<=' "$(awk "BEGIN { print sqrt(3) * $bound + 2.001 * $samples_root }")"
expect_number "$(value_of file_bytes)" '<' "$bytes"
expect_done cvol gradient a.cvol -o r.cvol --lossless-algebra --json
expect_number "$(value_of l2_error)" '<=' "$(awk "BEGIN { print 1.001 * sqrt(3) * $bound }")"
# The sum of a volume and itself is not much larger.
expect_done cvol add a.cvol a.cvol -o r.cvol --json
expect_number "$(value_of file_bytes)" '<' "$(awk "BEGIN { print 1.6 * $(wc -c <a.cvol) }")"
expect_done cvol multiply w.cvol w2.cvol -o r.cvol --rms 3 --json
check_result

# Pictures of results, and operations on results.
expect_done cvol multiply a.cvol b.cvol -o ab.cvol
expect_done cvol render ab.cvol -o ab.png --size 64 --mode mip
expect_done cvol render ab.cvol -o ab2.png --size 64 --transfer gray
expect_done cvol add ab.cvol a.cvol -o abc.cvol
expect_done cvol decompress abc.cvol abc.nrrd

# The bytes do not depend on the number of threads.
for threads in 1 3; do
    expect_done cvol multiply a.cvol b.cvol -o threads$threads.cvol --threads $threads
    expect_done cvol multiply w.cvol w2.cvol -o whole$threads.cvol --threads $threads
    expect_done cvol convolve a.cvol --kernel gaussian:1 -o soft$threads.cvol --threads $threads
done
expect_same_file threads1.cvol threads3.cvol
expect_same_file whole1.cvol whole3.cvol
expect_same_file soft1.cvol soft3.cvol

# ---- statistics ----------------------------------------------------------------------------------

expect_done cvol decompress a.cvol decoded.raw
expect_done cvol decompress a.cvol decoded.nrrd
expect_done cvol info decoded.nrrd --json
mean=$(value_of mean)
expect_done cvol stats a.cvol --json
for key in sum mean variance standard_deviation l2_norm sum_error mean_error \
    standard_deviation_error l2_norm_error; do
    expect_field $key number
done
expect_near "$(value_of mean)" "$mean" 0.5
expect_near "$(value_of sum)" "$(awk "BEGIN { print $(value_of mean) * $samples }")" 10
expect_done cvol info a.nrrd --json
exact_mean=$(value_of mean)
expect_done cvol stats a.cvol --json
expect_near "$(value_of mean)" "$exact_mean" "$(value_of mean_error) + 1e-6"
expect_done cvol stats a.cvol b.cvol --json
for key in inner_product cosine_similarity distance inner_product_error distance_error a.mean \
    b.l2_norm; do
    expect_field $key number
done
expect_done cvol stats a.cvol a.cvol --json
expect_near "$(value_of cosine_similarity)" 1 1e-5
expect_done cvol stats a.cvol
expect_done cvol stats a.cvol b.cvol
grep -q 'distance ' "$out" || fail 'must print the distance'
expect_done cvol stats w.cvol w2.cvol

# ---- dense operands ------------------------------------------------------------------------------

# Dense operands are compressed first, with the other operand's parameters, and a message reports it.
expect_compressed_first() {
    expect_status 0 "$@"
    expect_sentence 'compressed in memory first'
}
expect_compressed_first cvol add a.nrrd b.cvol -o r.cvol --json
expect_equal "$(value_of block)" 16
expect_compressed_first cvol add w.cvol a.nrrd -o r.cvol --json
expect_equal "$(value_of transform)$(value_of block)" dct0
expect_compressed_first cvol gradient a.nrrd -o r.cvol
expect_compressed_first cvol stats a.nrrd
expect_compressed_first cvol add a.raw b.cvol -o r.cvol --dims $dims --raw-type uint8
expect_failure 2 'raw samples need --dims' cvol add a.raw b.cvol -o x.cvol
expect_failure 2 "--raw-type is 'x'" cvol add a.raw b.cvol -o x.cvol --dims $dims --raw-type x
expect_failure 2 'have headers' cvol add a.cvol b.cvol -o x.cvol --dims $dims
expect_failure 2 'which has a header' cvol gradient a.cvol -o x.cvol --dims $dims

# ---- incompatible operands -----------------------------------------------------------------------

make_volume small.raw uint8 20x18x17
make_nrrd small.nrrd small.raw uint8 20 18 17
expect_done cvol compress small.nrrd small.cvol --psnr 35
make_nrrd wide.nrrd a.raw uint8 40 36 34 'spacings: 1 2 1'
expect_done cvol compress wide.nrrd wide.cvol
expect_done cvol compress a.nrrd eight.cvol --block 8
expect_done cvol compress a.nrrd fourier.cvol --transform dft --block 16 --ratio 10
for words in 'add' 'multiply' 'stats'; do
    result='-o x.cvol'
    [ "$words" != stats ] || result=
    expect_failure 1 'a.cvol and small.cvol: dims are 40x36x34 in one array and 20x18x17' \
        cvol $words a.cvol small.cvol $result
    expect_failure 1 'a.nrrd and small.nrrd: dims are' cvol $words a.nrrd small.nrrd $result
    expect_failure 1 'a.cvol and wide.cvol: spacing along y is 1 in one array and 2' \
        cvol $words a.cvol wide.cvol $result
    expect_failure 1 'a.cvol and eight.cvol: block is 16 in one array and 8' \
        cvol $words a.cvol eight.cvol $result
    expect_failure 1 'fourier.cvol and a.cvol: transform is dft in one array and dct' \
        cvol $words fourier.cvol a.cvol $result
    expect_failure 1 'a.cvol and w.cvol: block is 16 in one array and 0' \
        cvol $words a.cvol w.cvol $result
done

# ---- other errors --------------------------------------------------------------------------------

for kernel in '' gauss gaussian gaussian:x gaussian:-1 gaussian:100 box:2 box:0 derivative:w \
    unsharp:1,2,3; do
    expect_failure 2 '--kernel: ' cvol convolve a.cvol --kernel "$kernel" -o x.cvol
done
expect_failure 2 '' cvol convolve a.cvol --kernel gaussian:5 -o x.cvol # radius 20, block side 16
expect_failure 2 'no filter: give --kernel' cvol convolve a.cvol -o x.cvol
expect_failure 1 'no.json: ' cvol convolve a.cvol --kernel no.json -o x.cvol
# refuse_taps SENTENCE TEXT: TEXT is an invalid kernel file.
refuse_taps() {
    printf '%s\n' "$2" >bad.json
    expect_failure 1 "bad.json: *$1" cvol convolve a.cvol --kernel bad.json -o x.cvol
}
: >bad.json
refuse_taps 'line ' '{'
refuse_taps 'has no list "taps"' '{"tap": [1]}'
refuse_taps 'has no list "taps"' '[1, 2, 1]'
refuse_taps 'odd number' '{"taps": []}'
refuse_taps 'odd number' '{"taps": [1, 1]}'
refuse_taps 'tap 1 is not a number' '{"taps": [1, "2", 1]}'
refuse_taps 'neither symmetric nor antisymmetric' '{"taps": [1, 2, 3]}'
refuse_taps 'odd number' "{\"taps\": [$(printf '1, %.0s' 1 2 3 4 5 6 7 8 9 0 1 2 3 4 5 6 7 8 9 0 \
    1 2 3 4 5 6 7 8 9 0 1 2 3 4 5 6 7 8 9 0 1 2 3 4 5 6 7 8 9 0 1 2 3 4 5 6 7 8 9 0 1 2 3 4 5)1]}"

mkdir folder.cvol
expect_failure 1 'uint8 holds 0 .. 255; use --type uint16' \
    cvol add a.cvol a.cvol -o x.cvol --type uint8
expect_failure 1 'int8 holds -128 .. 127; use --type' cvol gradient a.cvol -o x.cvol --type int8
expect_failure 1 'use --type int16' cvol scale a.cvol -o x.cvol --factor -1 --type uint8
for command in 'cvol add a.cvol b.cvol' 'cvol multiply a.cvol b.cvol' 'cvol gradient a.cvol' \
    'cvol scale a.cvol --factor 2' 'cvol convolve a.cvol --kernel box:3'; do
    expect_failure 2 'give -o' $command
    expect_failure 2 'must end in .cvol' $command -o x.nrrd
    expect_failure 2 "--type is 'uint7'" $command -o x.cvol --type uint7
    expect_failure 1 'same file' $command -o a.cvol
    expect_failure 1 'No such file' $command -o missing/x.cvol
    expect_failure 1 'is a directory' $command -o folder.cvol
    case $command in *scale*) continue ;; esac
    expect_failure 2 "--keep is 'x'" $command -o x.cvol --keep x
    expect_failure 2 'only one of --keep, --rms' $command -o x.cvol --keep 1,1 --step 2
    expect_failure 2 'only one of --keep, --rms' $command -o x.cvol --rms 1 --lossless-algebra
    expect_failure 2 '--rms is -1' $command -o x.cvol --rms -1
    expect_failure 2 '--step is 0' $command -o x.cvol --step 0
    expect_failure 2 '' $command -o x.cvol --keep 17,0
done
expect_failure 2 'nothing to do' cvol scale a.cvol -o x.cvol
expect_failure 1 'same file' cvol add a.cvol b.cvol -o b.cvol
expect_failure 2 '35' cvol add w.cvol w2.cvol -o x.cvol --keep 35,0
expect_failure 2 "$((samples + 1))" cvol add w.cvol w2.cvol -o x.cvol --keep 1,$((samples + 1))
expect_failure 2 'blocks' cvol add w.cvol w2.cvol -o x.cvol --step 2
expect_failure 2 '1 of 2 arguments' cvol add a.cvol -o x.cvol
expect_failure 2 '0 of 2 arguments' cvol stats
expect_failure 2 'too many arguments' cvol stats a.cvol b.cvol a.cvol
expect_failure 1 'missing.cvol' cvol add a.cvol missing.cvol -o x.cvol
head -c 300 b.cvol >cut.cvol
expect_failure 1 'cut.cvol: truncated' cvol multiply a.cvol cut.cvol -o x.cvol
expect_no_file x.cvol
# ---- places and values ------------------------------------------------------------------------------

# nrrd NAME ORIGIN MORE: 4 x 4 x 4 samples in a patient's space.
nrrd() {
    {
        printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspace: left-posterior-superior\n'
        printf 'space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: %s\nencoding: raw\n%s\n' "$2" "$3"
        printf 'abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefghijkl'
    } >"$1"
}
nrrd here.nrrd '(0,0,0)' ''
nrrd there.nrrd '(0,0,5)' ''
cvol add here.nrrd there.nrrd -o both.cvol >out 2>err
grep -q 'here.nrrd and there.nrrd lie at different places (origin or direction)' err || fail "add says: $(cat err)"
cvol compare here.nrrd there.nrrd >out 2>err
grep -q 'lie at different places' err || fail "compare says: $(cat err)"
expect_done cvol compare here.nrrd here.nrrd

# Samples s mean 2.5 s - 7: stats, measure and scale count values.
{
    printf 'ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\n'
    printf 'ElementToIntensityFunctionSlope = 2.5\nElementToIntensityFunctionOffset = -7\nElementDataFile = LOCAL\n'
    printf 'abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefghijkl'
} >values.mha
expect_done cvol compress values.mha values.cvol --lossless
expect_done cvol measure values.mha --json
exact=$(value_of mean)
expect_done cvol stats values.cvol --json
mean=$(value_of mean)
bound=$(value_of mean_error)
expect_near "$mean" "$exact" "$bound + 1e-9"
expect_done cvol scale values.cvol --factor 2 --offset 30 -o twice.cvol
expect_done cvol measure twice.cvol --json
mean=$(value_of mean)
bound=$(value_of mean_error)
expect_near "$mean" "$(awk "BEGIN { print 2 * $exact + 30 }")" "$bound"
expect_number "$bound" '<' 5
