#!/bin/sh
# doc/decoder_ref.py, which is written from the format's description alone, decodes files of all kinds. Its samples
# agree with those of the command.
. "$(dirname "$0")/lib.sh"

python=/usr/bin/python3
[ -x $python ] || python=python3
if ! $python -c 'import numpy' 2>/dev/null; then
    echo 'skipped: the reference decoder (no python3 with numpy)'
    exit 0
fi
decode() { $python "$CVOL_DOC/decoder_ref.py" "$@"; }

# check FILE NUMPY_TYPE [--level L]: the decoder's samples must agree with those that the command writes now. The type
# `exact` asks for identical bytes. One process decodes all files at the end (check_list), because Python starts slowly.
checks=0
: >list
check() {
    checks=$((checks + 1))
    expect_done cvol decompress "$1" "expected$checks.raw" ${3:+$3 $4}
    cp "$1" "file$checks.cvol"
    echo "file$checks.cvol expected$checks.raw $nx $2 ${4:-0}" >>list
}

# Few integers differ, by 1 at most; floats differ by rounding errors of single precision.
check_list() {
    cat >check_list.py <<'END'
import contextlib, io, json, sys
import numpy as np
sys.path.insert(0, sys.argv[1])
import decoder_ref
for line in open("list"):
    name, expected, width, kind, level = line.split()
    sys.argv[1:] = [name, "decoded.raw", "--level", level]
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        decoder_ref.main()
    assert json.loads(printed.getvalue())["dims"][0] == int(width), line
    a, b = (np.fromfile(n, "u1" if kind == "exact" else kind) for n in (expected, "decoded.raw"))
    assert a.size == b.size and a.size > 0, (line, a.size, b.size)
    off = np.abs(a.astype(float) - b.astype(float))
    if kind == "exact":
        assert not off.any(), line
    elif a.dtype.kind == "f":
        assert off.max() <= 1e-5 * np.abs(a).max(), (line, off.max(), np.abs(a).max())
    else:
        assert off.max() <= 1 and (off > 0).mean() < 1e-3, (line, off.max(), (off > 0).mean())
END
    expect_done $python -B check_list.py "$CVOL_DOC"
    [ "$(wc -l <list)" = $checks ] || fail 'every file must be in the list'
}

nx=37
i=0
for type in uint8 int16 float32 uint16; do
    make_volume in.raw $type 37x20x70
    case $type in uint8) numpy=u1 ;; int16) numpy=i2 ;; float32) numpy=f4 ;; uint16) numpy=u2 ;; esac
    case $type in
    uint8) methods='--block|16|--ratio|6 --block|8|--ratio|4 --transform|dht|--block|8|--keep|3,20' ;;
    int16) methods='--block|32|--psnr|45 --transform|dft|--block|16|--keep|2,30' ;;
    float32) methods='--block|16|--psnr|50 --transform|dht|--block|0|--keep|5,200' ;;
    uint16) methods='--transform|dft|--block|0|--keep|4,99 --transform|dct|--block|0|--keep|0,70' ;;
    esac
    for method in $methods; do
        expect_done cvol compress in.raw out.cvol --dims 37x20x70 --type $type $(echo "$method" | tr '|' ' ')
        check out.cvol $numpy
    done
done

# Other brick shapes. Lossless files decode to identical samples.
make_volume in.raw uint8 37x20x34
for method in '--bricks 16,32,16 --ratio 6' '--block 8 --bricks 32,16,48 --ratio 6'; do
    expect_done cvol compress in.raw out.cvol --dims 37x20x34 --type uint8 $method
    check out.cvol u1
done
check out.cvol u1 --level 1
# Maximum effort, in two bricks; some blocks end early.
expect_done cvol compress in.raw out.cvol --dims 37x20x34 --type uint8 --bricks 32,32,48 --smallest --ratio 16
for level in 0 2; do check out.cvol u1 --level $level; done
expect_done cvol compress in.raw out.cvol --dims 37x20x34 --type uint8 --bricks 32,16,16 --lossless
expect_done decode out.cvol b.raw
expect_done cmp b.raw in.raw

# Lines and planes.
nx=41
make_volume line.raw int16 41x1x1
expect_done cvol compress line.raw out.cvol --dims 41x1x1 --type int16 --transform dft --block 0 --keep 3,5
check out.cvol i2
make_volume plane.raw int16 41x23x1
expect_done cvol compress plane.raw out.cvol --dims 41x23x1 --type int16 --transform dft --block 8 --keep 2,9
check out.cvol i2

# Random terms: split blocks, lapped volumes, values of any size, several bricks, all levels.
nx=70
for kind in '8 0 0 0' '16 0 0 0' '16 1 0 1' '16 1 1 1' '16 1 1 0' '32 0 0 0'; do
    i=$((i + 1))
    expect_done make_terms out.cvol 70x19x18 $kind $i
    check out.cvol f4
    for level in 1 2 3; do check out.cvol f4 --level $level; done
done

# Residuals and masks: identical samples.
nx=70
for type in uint8 int16 float32 float64; do
    make_volume in.raw $type 70x19x18
    cp in.raw holes.raw
    cp in.raw threes.raw
    case $type in
    uint8) kind=u8 ;;
    int16) kind=i16 ;;
    *) kind=f${type#float} ;;
    esac
    poke threes.raw 8000 $kind 3 9600 $kind 3
    case $type in
    float*) poke holes.raw 800 $kind nan 1600 $kind -inf ;;
    esac
    for method in '--lossless' '--lossless --block 8' '--max-error 2.5 --fill nan' '--fill 3 --psnr 40'; do
        case $method in *nan* | --lossless) from=holes.raw ;; *3*) from=threes.raw ;; *) from=in.raw ;; esac
        expect_done cvol compress $from out.cvol --dims 70x19x18 --type $type $method
        case $method in
        *psnr*) expect_done decode out.cvol b.raw ;; # lossy floats: no exact samples to compare
        *) check out.cvol exact ;;
        esac
        case $method in *lossless*) expect_same_file "expected$checks.raw" $from ;; esac
    done
done

# Labels: the regions of the nearest of 40 places, in several bricks.
cat >make_labels.py <<'END'
import sys
import numpy as np
random = np.random.default_rng(1)
at = np.stack(np.meshgrid(np.arange(20), np.arange(40), np.arange(70), indexing="ij"), -1)
places = random.integers(0, at.shape[:3], (40, 3))
labels = np.argmin([((at - place) ** 2).sum(-1) for place in places], 0) // 2
labels[random.random(labels.shape) < 0.001] = 3
scale, offset = {"u1": (1, 0), "i4": (90000001, -10 ** 9)}[sys.argv[1]]
(scale * labels + offset).astype(sys.argv[1]).tofile("in.raw")
END
for type in uint8 int32; do
    case $type in uint8) $python make_labels.py u1 ;; int32) $python make_labels.py i4 ;; esac
    for bricks in 64 32,16,48; do
        expect_done cvol compress in.raw out.cvol --dims 70x40x20 --type $type --labels yes --bricks $bricks
        check out.cvol exact
        expect_same_file "expected$checks.raw" in.raw
    done
    # Field `residual` of MODE states labels.
    mode=$(grep -abo MODE out.cvol | head -n 1 | cut -d : -f 1)
    expect_equal "$(od -An -tu4 -j$((mode + 24)) -N4 out.cvol | tr -d ' ')" 4
done

# A separately stored background.
nx=70
for type in uint8 float32; do
    make_volume in.raw $type 70x19x18
    expect_done cvol compress in.raw out.cvol --dims 70x19x18 --type $type --background 3 --psnr 40
    case $type in uint8) check out.cvol u1 ;; float32) check out.cvol f4 ;; esac
done

check_list

# Attributes.
echo '{"a": [1, "b"]}' >in.json
make_volume in.raw uint8 37x20x70
expect_done cvol compress in.raw out.cvol --dims 37x20x70 --type uint8 --spacing 1,0.5,2 --attributes in.json
expect_done decode out.cvol b.raw
expect_equal "$(value_of attributes.a.1)" b
expect_equal "$(value_of spacing.1)" 0.5
expect_equal "$(value_of type)" uint8

# Damaged and truncated files.
size=$(wc -c <out.cvol)
for at in 3 9 14 40 60 150 310 400 420 $((size / 2)) $((size - 30)) $((size - 3)); do
    cp out.cvol bad.cvol
    poke bad.cvol $at xor 32
    run decode bad.cvol b.raw
    expect_equal "$status" 1
    grep -q '^decoder_ref: bad.cvol: ' "$err" || fail 'must print what is wrong'
done
head -c $((size - 30)) out.cvol >bad.cvol
run decode bad.cvol b.raw
expect_equal "$status" 1
expect_done decode bad.cvol b.raw --level 1
