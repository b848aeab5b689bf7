#!/bin/sh
# Baked volumes: creating, describing, rendering from all directions of their axis, and invalid uses.
. "$(dirname "$0")/lib.sh"

dims=44x40x36
make_volume in.raw uint8 $dims
expect_done cvol compress in.raw a.cvol --dims $dims --type uint8 --psnr 50
cat >own.json <<'END'
{"points": [[0, 0, 0, 0, 0], [100, 1, 0.5, 0.2, 0.05], [255, 1, 1, 1, 1]]}
END
cat >other.json <<'END'
{"points": [[0, 0, 0, 0, 0], [100, 1, 0.5, 0.2, 0.06], [255, 1, 1, 1, 1]]}
END

# ---- pictures ------------------------------------------------------------------------------------

size='--size 96 --engine transform'
for axis in x y z; do
    case $axis in
    x) views='90,0 250,20' ;;
    y) views='0,0 160,-30' ;;
    z) views='0,90 40,-60' ;;
    esac
    expect_done cvol bake a.cvol -o baked.cvol --axis $axis --transfer own.json --rho 1 --json
    expect_equal "$(value_of axis)" $axis
    expect_equal "$(value_of file_bytes)" "$(wc -c <baked.cvol)"
    for field in slices:integer transform:string tile:integer rho:number kept:number step:number \
        coefficients:integer ratio:number bake_ms:number; do
        expect_field "${field%:*}" "${field#*:}"
    done
    for view in $views; do
        view="--azimuth ${view%,*} --elevation ${view#*,}"
        expect_done cvol render a.cvol -o whole.png $size $view --fit box --transfer own.json --rho 1
        expect_done cvol render baked.cvol -o baked.png $size $view --json
        expect_equal "$(value_of transform.bake_ms)" 0.0
        expect_done cvol compare whole.png baked.png --json
        expect_number "$(value_of psnr_db)" '>=' 38
    done
done
expect_done cvol verify baked.cvol
expect_done cvol info baked.cvol
for field in kind axis transfer rho file_bytes coefficients tile lit; do
    grep -q "^  $field " "$out" || fail "must print $field"
done

expect_done cvol bake a.cvol -o baked.cvol --axis y --transfer bone --rho 0.3 --footprint sinc
expect_done cvol bake a.cvol -o again.cvol --axis y --transfer bone --rho 0.3 --footprint sinc --threads 3
expect_same_file baked.cvol again.cvol
expect_done cvol info baked.cvol --json
expect_equal "$(value_of kind)" baked
expect_equal "$(value_of transfer)" bone
expect_equal "$(value_of axis)" y
expect_equal "$(value_of rho)" 0.3
expect_equal "$(value_of footprint)" sinc
expect_field transfer_points.0.4 number
expect_done cvol info baked.cvol --layout
grep -q '^  BAKE .* sound ' "$out" || fail 'must list the section BAKE'
expect_done cvol render baked.cvol -o all.png $size
expect_done cvol render baked.cvol -o same.png $size --transfer bone --rho 0.3 --footprint sinc
expect_same_file all.png same.png
expect_done cvol render baked.cvol -o fewer.png $size --rho 0.1 --json
expect_number "$(value_of transform.rho)" '<=' 0.1
expect_other_file all.png fewer.png
for option in '--order back' '--schedule literal' '--footprint box' '--footprint-size 9' '--background 1,0,0' '--zoom 2'; do
    expect_done cvol render baked.cvol -o after.png $size $option
done
expect_done cvol render baked.cvol -o out.png $size --progressive
expect_same_file out.png all.png
expect_done cvol render baked.cvol -o out.cvi $size
expect_done cvol compare all.png out.cvi --json
expect_number "$(value_of psnr_db)" '>=' 45
expect_done cvol bench render baked.cvol --views 1 --repeat 2 $size
expect_done cvol bake a.cvol -o lit.cvol --axis y --shade --light 1,-2,3
expect_done cvol render lit.cvol -o lit.png $size
expect_done cvol render lit.cvol -o same.png $size --shade --light 1,-2,3
expect_same_file lit.png same.png

# The reference decoder reads the planes that the command renders from.
python=/usr/bin/python3
[ -x $python ] || python=python3
if $python -c 'import numpy' 2>/dev/null; then
    expect_done $python "$CVOL_DOC/decoder_ref.py" baked.cvol planes.raw
    expect_equal "$(value_of slices)" 40
    expect_equal "$(wc -c <planes.raw)" $((40 * 4 * 44 * 36 * 4))
    coefficients=$(value_of coefficients)
    expect_done cvol info baked.cvol --json
    expect_equal "$(value_of coefficients)" "$coefficients"
fi

# The number of multiply-adds grows with the footprint's size.
for f in 5 15; do
    expect_done cvol render a.cvol -o out.png --size 96 --engine splat --footprint-size $f --json
    eval "splat_$f=$(value_of splat.multiply_adds)"
done
expect_number $((splat_15 / splat_5)) '>=' 3
expect_number $((splat_15 / splat_5)) '<=' 12
for how in '' '--tile 0' '--schedule literal --tile 0'; do
    expect_done cvol render a.cvol -o out.png --size 48 --level 1 --engine transform $how --json
    expect_number "$(value_of transform.multiply_adds)" '>' 10000
done

# A coarse level has other slices than the full resolution.
expect_done cvol bake a.cvol -o fine.cvol --axis y --level 0
expect_done cvol bake a.cvol -o coarse.cvol --axis y --level 2
expect_other_file fine.cvol coarse.cvol

# ---- misuse and damage ---------------------------------------------------------------------------

expect_failure 2 'another transfer function' cvol render baked.cvol -o c.png $size --transfer other.json
expect_failure 2 'transfer function bone, not hot' cvol render baked.cvol -o c.png $size --transfer hot
expect_failure 2 'they lie along x' cvol render baked.cvol -o c.png $size --azimuth 90
expect_failure 2 'keeps rho 0.3, 0.5 is requested' cvol render baked.cvol -o c.png $size --rho 0.5
expect_failure 2 'was baked unlit' cvol render baked.cvol -o c.png $size --shade
expect_failure 2 'light at 1,-2,3' cvol render lit.cvol -o c.png $size --shade --light 3,2,1
expect_failure 2 'under dct with tiles of 16' cvol render baked.cvol -o c.png $size --spectrum dft
expect_failure 2 'engine sheet cannot draw' cvol render baked.cvol -o c.png --engine sheet
expect_done cvol render baked.cvol -o alone.png --size 40x30
expect_done cvol render baked.cvol -o named_engine.png --size 40x30 --engine transform
expect_same_file alone.png named_engine.png
expect_failure 2 'engine ray cannot draw' cvol render baked.cvol -o c.png --engine ray
expect_failure 2 'leave out --level' cvol render baked.cvol -o c.png $size --level 1
expect_failure 1 'is a baked volume' cvol decompress baked.cvol c.nrrd
expect_failure 1 'is a baked volume' cvol stats baked.cvol
expect_failure 2 'is already a baked volume' cvol bake baked.cvol -o c.cvol --axis y
expect_failure 2 'give -o' cvol bake a.cvol --axis y
expect_failure 2 'no axis: give --axis' cvol bake a.cvol -o c.cvol
expect_failure 2 "is 'q', must be x, y or z" cvol bake a.cvol -o c.cvol --axis q
expect_failure 2 'must end in .cvol' cvol bake a.cvol -o c.nrrd --axis y
expect_failure 2 'rho is 1.5' cvol bake a.cvol -o c.cvol --axis y --rho 1.5
expect_failure 2 'rho is 0' cvol bake a.cvol -o c.cvol --axis y --rho 0
expect_failure 1 'serve one direction' cvol bake a.cvol -o c.cvol --axis y --spectrum dft
expect_failure 2 'cone' cvol bake a.cvol -o c.cvol --axis y --footprint cone
make_volume thin.raw uint8 44x40x6
expect_failure 2 'larger than the slices, 44 x 6' cvol bake thin.raw --dims 44x40x6 --type uint8 -o c.cvol --axis y --footprint-size 7
# The same for pictures.
for engine in transform splat; do
    expect_failure 2 'larger than the slices, 44 x 6' cvol render thin.raw --dims 44x40x6 --type uint8 -o c.png --azimuth 0 --engine $engine --footprint-size 7
    expect_done cvol render thin.raw --dims 44x40x6 --type uint8 -o thin.png --size 40 --engine $engine
done
for engine in transform fourier; do
    for rho in 0 1.5 -1; do
        expect_failure 2 "rho is $rho, must be above 0 and at most 1" cvol render a.cvol -o c.png --engine $engine --rho $rho
    done
done
# Slices of one constant value: all terms but one are rounding errors.
head -c 8000 /dev/zero >zero.raw
expect_done cvol render zero.raw --dims 20x20x20 --type uint8 --transfer hot -o zero.png --size 40 --engine transform
expect_done cvol render zero.raw --dims 20x20x20 --type uint8 --transfer hot -o truth.png --size 40 --engine splat --footprint-plane slices
expect_done cvol compare truth.png zero.png --json
expect_number "$(value_of psnr_db)" '>=' 60
total=$(wc -c <baked.cvol)
for at in 2 9 17 30 40 150 250 $((total / 2)) $((total - 30)) $((total - 2)); do
    cp baked.cvol bad.cvol
    poke bad.cvol "$at" xor 32
    expect_failure 1 'bad.cvol' cvol render bad.cvol -o c.png $size
    expect_status 1 cvol verify bad.cvol
    rm bad.cvol
done
for length in 20 40 300 $((total / 2)) $((total - 1)); do
    head -c "$length" baked.cvol >bad.cvol
    expect_failure 1 'bad.cvol' cvol render bad.cvol -o c.png $size
    rm bad.cvol
done
