#!/bin/sh
# Invalid command lines: one sentence, status 2, and no output.
. "$(dirname "$0")/lib.sh"

make_volume in.raw uint8 9x8x7
raw='--dims 9x8x7 --type uint8'
make_nrrd in.nrrd in.raw uint8 9 8 7
expect_done cvol compress in.nrrd in.cvol --max-error 0
expect_done cvol render in.cvol -o old.png --size 16

# ---- bricks --------------------------------------------------------------------------------------

for bricks in 0 17 8 80 -16 16,16 16,16,16,16 16, ,16 16,16,24 16x16x16 '' 99999999999; do
    expect_failure 2 "--bricks is '$bricks'" cvol compress in.nrrd out.cvol --bricks "$bricks"
    expect_failure 2 "--bricks is '$bricks'" cvol transcode in.cvol out.cvol --bricks "$bricks"
done
expect_failure 2 "a brick's side along x is 16" cvol compress in.nrrd out.cvol --block 32 --bricks 16
expect_failure 2 '--bricks needs DCT blocks' cvol compress in.nrrd out.cvol --transform dht --bricks 16
expect_failure 2 'or only --bricks' cvol transcode in.cvol out.cvol
expect_failure 2 'give only one of --ratio, --bpv and --psnr' cvol transcode in.cvol out.cvol --ratio 40 --psnr 30

# ---- commands and arguments ----------------------------------------------------------------------

expect_failure 2 'no command given' cvol
expect_failure 2 "unknown command 'frobnicate'" cvol frobnicate
expect_failure 2 "unknown command ''" cvol ''
expect_failure 2 "unknown command '--json'" cvol --json info in.cvol
expect_failure 2 "unknown command 'Info'" cvol Info in.cvol
expect_failure 2 "unknown command '--version'" cvol --version now
for command in compress decompress info verify compare render bench; do
    expect_failure 2 'arguments given; usage: cvol' cvol $command
    expect_failure 2 'unknown option --frobnicate' cvol $command --frobnicate in.cvol
    expect_failure 2 'unknown option -x' cvol $command -x
    expect_failure 2 'unknown option --jso (did you mean --json?)' cvol $command --jso
    expect_failure 2 '--json takes no value' cvol $command --json=yes
    expect_failure 2 '--threads needs a value' cvol $command in.cvol --threads
    for threads in 0 -1 1.5 many '' 1025 1000000 99999999999999999999; do
        expect_failure 2 "--threads is '$threads'" cvol $command in.cvol --threads "$threads"
    done
done
for command in compress decompress; do
    [ $command = compress ] || expect_failure 2 "1 of 2 arguments given" cvol $command in.cvol
    expect_failure 2 "too many arguments: 'c'" cvol $command in.cvol out.cvol c
done
expect_failure 2 "too many arguments: 'b'" cvol info in.cvol b
expect_failure 2 "too many arguments: 'in.cvol'" cvol info --build in.cvol
expect_failure 2 '1 of 2 arguments given' cvol compare in.cvol
expect_failure 2 "too many arguments: 'c'" cvol compare in.cvol in.nrrd c
expect_failure 2 "this is one name for 2 volumes" cvol render in.cvol b -o out.png
expect_failure 2 '1 of 2 arguments given' cvol bench in.cvol
expect_failure 2 "cvol bench compress is unknown" cvol bench compress in.cvol
expect_failure 1 '-x: No such file' cvol info -- -x
expect_failure 2 '-o OUT.png' cvol render in.cvol
expect_failure 2 '-o needs a value' cvol render in.cvol -o
# Suggestions for misspelt names.
expect_failure 2 'no output: give -o out.png' cvol render in.cvol out.png
expect_failure 2 'unknown option --azimut=30 (did you mean --azimuth?); see' cvol render in.cvol --azimut=30
expect_failure 2 'unknown option --elveation (did you mean --elevation?)' cvol render in.cvol --elveation 3
expect_failure 2 'unknown option --turn (did you mean --turntable?)' cvol render in.cvol --turn
expect_failure 2 'unknown option --frames; see' cvol render in.cvol --frames 3
expect_failure 2 "unknown command 'rendr' (did you mean render?); see" cvol rendr
expect_failure 2 "unknown command 'xyz'; see" cvol xyz
expect_failure 2 '--times-mb is -1' cvol view in.nrrd --times-mb -1
expect_failure 2 '--keep-mb is -1' cvol view in.nrrd --keep-mb -1

# ---- names of outputs ----------------------------------------------------------------------------

for name in out out.nrrd .cvol out.cvol.gz ''; do
    expect_failure 2 "must end in .cvol" cvol compress in.nrrd "$name"
    expect_failure 2 "must end in .png" cvol render in.cvol -o "$name"
done
for name in out out.txt out.png out.cvol .nrrd nrrd out.nrrd.gz out.gz ''; do
    expect_failure 2 "$name: unknown extension" cvol decompress in.cvol "$name"
done

# ---- values of each option -----------------------------------------------------------------------

# refuse COMMAND... -- VALUE...: runs the command with each VALUE as last argument; the message quotes the option.
refuse() {
    refused=
    while [ "$1" != -- ]; do
        refused="$refused $1"
        shift
    done
    shift
    for value; do
        expect_failure 2 "${refused##* }" $refused "$value"
    done
}
number="x 1x 1,5 nan inf -inf 1e999"
compress='cvol compress in.nrrd out.cvol'
refuse $compress --ratio -- '' ' 30' $number 0 -3 1 0.5
refuse $compress --bpv -- '' $number 0 -0.5
for bits in 8 8.5 1e9 1e-320; do
    expect_failure 2 "in.nrrd: bits a sample are*below the 8 of uint8" $compress --bpv $bits
done
expect_failure 2 '--bpv needs DCT blocks' $compress --bpv 1 --transform dft
expect_failure 2 '--bpv needs DCT blocks' $compress --bpv 1 --block 0
refuse cvol decompress in.cvol out.nrrd --box -- '' x 1 0:1 0:1,0:1 0:1,0:1,0: 0:1,0:1,0:1, 0:1,0:1,-1:1 \
    '0:1, 0:1,0:1' 0:1,0:1,0:1,0:1 0-1,0-1,0-1 0:1,0:1,0:1.5 0:1,0:1,0:99999999999999999999
box_is="the volume 0:"
expect_failure 2 "in.cvol: the box is empty along x: it is 4:4 there, ${box_is}9" \
    cvol decompress in.cvol out.nrrd --box 4:4,0:8,0:7
expect_failure 2 "in.cvol: the box is reversed along y: it is 5:2 there, ${box_is}8" \
    cvol decompress in.cvol out.nrrd --box 0:9,5:2,0:7
expect_failure 2 "in.cvol: the box reaches beyond the volume along z: it is 0:8 there, ${box_is}7" \
    cvol decompress in.cvol out.nrrd --box 0:9,0:8,0:8
expect_failure 2 'in.cvol: the box reaches beyond the volume along x: it is 9:12' \
    cvol decompress in.cvol out.nrrd --box 9:12,0:8,0:7
expect_failure 2 '--box needs a value' cvol decompress in.cvol out.nrrd --box
refuse $compress --psnr -- '' $number 0 -40 201
refuse $compress --max-error -- '' $number -1 -1e-9
refuse $compress --block -- '' x -8 7 15 17 33 64 16.0 2147483648 99999999999999999999
refuse $compress --transform -- '' x fft DCT
refuse $compress --effort -- '' x Fast 1 high
expect_failure 2 "--effort is 'x', must be fast, default or max" $compress --effort x
expect_failure 2 '--fast cannot be combined with --smallest' $compress --fast --smallest
expect_failure 2 '--effort default cannot be combined with --smallest' $compress --effort default --smallest
expect_failure 2 '--effort max cannot be combined with --fast' $compress --effort max --fast
for effort in '--effort max' --smallest '--effort max --smallest'; do
    for more in '--max-error 1' --lossless '--labels yes' '--psnr 40 --max-error 2'; do
        expect_failure 2 '--effort max cannot be combined with --max-error or --lossless' $compress $effort $more
    done
    expect_failure 2 'maximum effort needs blocks of 16' $compress $effort --block 8
done
expect_failure 2 'only one of' $compress --ratio 30 --psnr 40
expect_failure 2 'only one of' $compress --ratio 30 --bpv 1
expect_failure 2 'only one of' $compress --bpv 1 --psnr 40
expect_failure 2 'only one of' $compress --bpv 1 --max-error 1
expect_failure 2 'only one of' $compress --bpv 1 --keep 1,2
expect_failure 2 'only one of' $compress --psnr 30 --lossless
expect_failure 2 'only one of' $compress --max-error 3 --lossless
expect_failure 2 'only one of' $compress --ratio 30 --max-error 0
for option in --ratio --bpv --psnr --max-error --block --transform --dims --type --spacing --fill; do
    expect_failure 2 "$option needs a value" $compress $option
done

for command in 'cvol info in.raw' 'cvol compress in.raw out.cvol' 'cvol compare in.raw in.nrrd' \
    'cvol render in.raw -o out.png' 'cvol bench render in.raw'; do
    refuse $command --type uint8 --dims -- '' x 9 9x8 9x8x 9x8x0 0x8x7 -9x8x7 9x-8x7 9x8x7x1 9,8,7 \
        9x8x7.0 '9x8x 7' 99999999999999999999x1x1
    refuse $command --dims 9x8x7 --type -- '' x uint7 int64 UINT8 float
    refuse $command $raw --spacing -- '' x 1 1,1 1,1, 1,1,1,1 1,1,x 1,nan,1 1,1,inf '1, 1,1'
    case $command in
    *compress*) refuse $command $raw --fill -- '' x 1x 1,5 inf -inf 1e999 ;;
    *) refuse $command $raw --fill -- '' $number ;;
    esac
    expect_failure 2 'spacing of axis y' $command $raw --spacing 1,-1,1
    expect_failure 2 "--spacing is '0,2,3': spacing of axis x" $command $raw --spacing 0,2,3
    expect_failure 2 'in.raw: raw samples need --dims' $command --type uint8
    expect_failure 2 'in.raw: raw samples need --type' $command --dims 9x8x7
    expect_failure 2 '--big-endian takes no value' $command $raw --big-endian=1
done
# Files with a header accept none of the options for raw samples.
for option in '--dims 9x8x7' '--type uint8' '--big-endian' '--spacing 1,1,2'; do
    for file in in.nrrd in.cvol; do
        expect_failure 2 "$file: is a*which has a header" cvol info $file $option
        expect_failure 2 "$file: is a*which has a header" cvol compress $file out.cvol $option
        expect_failure 2 "$file: is a*which has a header" cvol render $file -o out.png $option
    done
    expect_failure 2 'in.cvol and in.nrrd have headers' cvol compare in.cvol in.nrrd $option
    expect_failure 2 'unknown option' cvol decompress in.cvol out.nrrd $option
done
# NumPy, for example, has no spacing, so that the option is for such files too.
expect_done cvol decompress in.cvol in.npy
for option in '--dims 9x8x7' '--type uint8' '--big-endian'; do
    expect_failure 2 'dims, type and byte order are for raw samples' cvol info in.npy $option
    case $sentence in *spacing*) fail 'must not name an option that it takes' ;; esac
done
expect_done cvol info in.npy --spacing 1,1,2
expect_failure 2 'in.raw: raw samples need --dims' cvol info in.raw
expect_failure 2 'in.raw: raw samples need --dims' cvol compare in.nrrd in.raw
cp in.raw t2_9x8x7_uint8.raw
expect_failure 2 '.raw: raw samples need --dims NXxNYxNZ and --type; its name and size fit --dims 9x8x7 --type uint8' \
    cvol info t2_9x8x7_uint8.raw
cp in.raw t_9x8x8_uint8.raw
expect_status 2 cvol info t_9x8x8_uint8.raw
expect_sentence '.raw: raw samples need --dims NXxNYxNZ and --type'
case $sentence in *fit*) fail 'the size must not match' ;; esac

for command in 'cvol render in.cvol -o out.png' 'cvol bench render in.cvol'; do
    refuse $command --mode -- '' x compositi mipp
    refuse $command --engine -- '' x transforms Ray
    refuse $command --size -- '' x 0 -5 0x5 5x0 5x 5x5x5 x5 5,5 5.5 32769 5x32769 2147483648
    refuse $command --zoom -- '' $number 0 -1
    refuse $command --background -- '' x 1 1,1 1,1,1,1 2,0,0 0,-0.1,0 0,0,nan
    refuse $command --window -- '' x 1 1,0 1,-2 1,2,3 1,nan
    refuse $command --rescale -- '' x 1 0,1 1,2,3 1,inf
    refuse $command --opacity-scale -- '' x -1 nan
    expect_failure 2 '--opacity-scale works only with --mode composite' $command --mode mip --opacity-scale 2
    refuse $command --engine ray --step -- '' $number -1
    expect_failure 2 'step 1e-09' $command --engine ray --step 1e-9
    expect_failure 2 '--step works only with engines sheet and ray' $command --engine splat --step 0.5
    expect_failure 2 'modes composite and iso, not in mip' $command --mode mip --step 0.5
    expect_failure 2 "--mode is 'mipp', must be composite, xray, mean, mip, min or iso" $command --mode mipp
    expect_failure 2 "--engine is 'x', must be sheet, ray, splat, transform or fourier" $command --engine x
    expect_failure 2 "--ray-order is 'many', must be image, object or auto" $command --ray-order many
    expect_failure 2 '--ray-order works only with engine sheet' $command --engine ray --ray-order object
    expect_failure 2 '--oversample is 5' $command --oversample 5
    expect_failure 2 '--oversample works only with engine sheet' $command --engine ray --oversample 2
    expect_failure 2 '--keep-mb is -1' $command --keep-mb -1
    expect_failure 2 '--keep-mb works only with engine sheet' $command --engine ray --keep-mb 100
    for option in '--footprint-size 5' '--footprint-plane view' '--order back'; do
        expect_failure 2 "${option%% *} works only with engines splat and transform" $command $option
    done
    for option in '--footprint box' '--sigma 1'; do
        expect_failure 2 "${option%% *} works only with engines sheet, splat and transform" $command --engine ray $option
    done
    expect_failure 2 "--footprint of engine sheet is 'box', must be linear, catmull-rom, b-spline or gaussian" $command --footprint box
    expect_failure 2 '--sigma works only with --footprint gaussian, not linear' $command --sigma 1
    refuse $command --footprint gaussian --sigma -- '' $number 0.4 1.1
    refuse $command --engine splat --footprint -- '' x Box gauss
    refuse $command --engine splat --footprint-size -- '' x 2 32 0 -5 3.5 5x5
    refuse $command --engine splat --sigma -- '' $number 0 -1 0.1 32
    refuse $command --engine splat --order -- '' x fronts
    refuse $command --engine splat --shade --light -- '' x 1 1,1 0,0,0 1,1,1,1 nan,0,0
    for option in '--ambient 1' '--diffuse 1' '--specular 1' '--shininess 5' '--gradient-opacity 3' '--shadows 1' \
        '--occlusion 1' '--fill-light 1' '--samples 8' --keep-brightness; do
        expect_failure 2 "${option%% *} needs a light" $command --light flat $option
    done
    for option in '--light studio' '--shade --shadows 1' '--shade --occlusion 1' '--shade --fill-light 1' \
        '--shade --keep-brightness'; do
        expect_failure 2 'only with engines sheet and ray' $command --engine splat $option
    done
    refuse $command --shade --occlusion -- '' $number -0.1 1.1
    refuse $command --shade --shadows -- '' $number -0.1 1.1
    refuse $command --shade --fill-light -- '' $number -0.1 11
    refuse $command --light cinematic --samples -- '' x 0 1 2.5 65537
    expect_failure 2 '--shade needs a light: leave out --light flat' $command --shade --light flat
    expect_failure 2 '--light flat works only in mode composite' $command --mode iso --iso 5 --light flat
    for option in --ambient --diffuse --specular --gradient-opacity; do
        refuse $command --shade $option -- '' $number -1 1e31
    done
    refuse $command --shade --shininess -- '' x 0 257 2.5
    expect_failure 2 '--shade works only in modes composite and iso, not in mip' $command --shade --mode mip
    expect_failure 2 'give --iso VALUE' $command --mode iso
    refuse $command --mode iso --iso -- '' $number
    refuse $command --mode iso --iso 5 --iso-colour -- '' x 1 1,1,2 -1,0,0
    expect_failure 2 '--iso works only with --mode iso' $command --iso 5
    expect_failure 2 '--window has width 0, must be above 0' $command --mode iso --iso 5 --window 4,0
    expect_failure 2 '--gradient-opacity works only in mode composite' $command --mode iso --iso 5 --gradient-opacity 1
    expect_failure 2 '--shade does not work with engine fourier' $command --shade --engine fourier
    expect_failure 2 '--sigma works only with --footprint gaussian' $command --engine splat --footprint cone --sigma 1
    expect_failure 2 'which has mode composite only' $command --engine splat --mode xray
    expect_failure 2 '--rho works only with engines transform and fourier' $command --engine splat --rho 0.1
    for option in '--spectrum dft' '--schedule literal' '--tile 8'; do
        expect_failure 2 "${option%% *} works only with engine transform" $command --engine splat $option
    done
    refuse $command --engine transform --rho -- '' $number 0 -1
    refuse $command --engine transform --spectrum -- '' x DFT
    refuse $command --engine transform --schedule -- '' x lazy
    refuse $command --engine transform --tile -- '' x 4 12 -1
    expect_failure 2 'works only with --spectrum dct' $command --engine transform --spectrum dft --tile 16
    expect_failure 2 'view works only with engine splat' $command --engine transform --footprint-plane view
    expect_failure 2 'must be view or slices' $command --engine splat --footprint-plane x
    expect_failure 2 'cone works only with engine splat' $command --engine transform --footprint cone
    expect_failure 2 'which has mode composite only' $command --engine transform --mode mip
    expect_failure 2 'which has mode xray only' $command --engine fourier --mode mip
    refuse $command --engine fourier --rho -- '' $number 0 -1
    refuse $command --engine fourier --depth-cue -- '' $number -0.1 1.1
    expect_failure 2 '--depth-cue works only with engine fourier' $command --depth-cue 0.5
    expect_failure 2 'named nonsense' $command --transfer nonsense
    expect_failure 2 "auto gray bone" $command --transfer ''
done
for option in --azimuth --elevation --roll; do
    refuse cvol render in.cvol -o out.png $option -- '' $number
done
for option in --views --repeat; do
    refuse cvol bench render in.cvol $option -- '' x 0 -1 1.5 100001 99999999999999999999
done

# ---- invalid files of transfer functions: status 1, not misuse -----------------------------------

# refuse_transfer PATTERN TEXT: TEXT is an invalid file.
refuse_transfer() {
    printf '%s' "$2" >tf.json
    expect_failure 1 "tf.json:*$1" cvol render in.cvol -o old.png --transfer tf.json
    expect_failure 1 "tf.json:*$1" cvol bench render in.cvol --transfer tf.json
}
cp old.png before.png
echo >tf.json # expect_failure compares the names in the folder
refuse_transfer '' ''
refuse_transfer '' 'points'
refuse_transfer '' '{'
refuse_transfer '' '[]'
refuse_transfer '' '{}'
refuse_transfer '' '5'
refuse_transfer '' '{"points": 5}'
refuse_transfer '' '{"points": []}'
refuse_transfer '' '{"points": {}}'
refuse_transfer '' '{"points": [1, 2, 3, 4, 5]}'
refuse_transfer '' '{"points": [[1, 2, 3]]}'
refuse_transfer '' '{"points": [[1, 0, 0, 0, 0, 0]]}'
refuse_transfer '' '{"points": [[1, 0, 0, 0, "x"]]}'
refuse_transfer '' '{"points": [[1, 0, 0, 0, 2]]}'
refuse_transfer '' '{"points": [[1, 0, -1, 0, 1]]}'
refuse_transfer '' '{"points": [[1, 0, 0, 0, NaN]]}'
refuse_transfer '' '{"points": [[1e999, 0, 0, 0, 0]]}'
refuse_transfer '' '{"points": [[1, 0, 0, 0, 1]]} more'
mkdir folder.json
: >empty.json
for name in missing.json folder.json empty.json ./missing; do
    expect_failure 1 "$name:" cvol render in.cvol -o old.png --transfer $name
done
expect_failure 1 'in.cvol:' cvol render in.nrrd -o old.png --engine ray --transfer in.cvol
expect_same_file before.png old.png

expect_no_file out.png
expect_no_file out.cvol
