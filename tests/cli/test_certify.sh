#!/bin/sh
# cvol render --certify: the picture of the original samples lies between the bounds; files, figures and messages.
. "$(dirname "$0")/lib.sh"

dims=40x36x32
raw="--dims $dims --type uint8"
make_volume in.raw uint8 $dims
make_nrrd in.nrrd in.raw uint8 40 36 32
expect_done cvol compress in.nrrd a.cvol --max-error 2
cat >soft.json <<'END'
{"points": [[40, 0.1, 0.2, 0.9, 0], [120, 0.9, 0.5, 0.2, 0.05], [220, 1, 0.9, 0.7, 0.3]]}
END
look='--size 48x40 --azimuth 30 --elevation 20 --background 0.2,0.1,0.3'
soft='--transfer soft.json'

# expect_within PICTURE LOWER UPPER: all channels of all pixels of PNG files.
expect_within() {
    command_run="within $1 $2 $3"
    python3 - "$@" <<'END' || fail 'must lie between its bounds'
import sys, zlib, struct
def pixels(path):
    data, at, packed = open(path, "rb").read(), 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
            assert depth == 8 and colour == 2
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += 12 + size
    raw, stride = zlib.decompress(packed), 3 * width
    rows, above = [], bytearray(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a = row[i - 3] if i >= 3 else 0
            b, c = above[i], above[i - 3] if i >= 3 else 0
            nearest = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
            row[i] = (row[i] + [0, a, b, (a + b) // 2, nearest][kind]) & 255
        rows.append(row)
        above = row
    return b"".join(rows)
picture, lower, upper = map(pixels, sys.argv[1:])
assert len(picture) == len(lower) == len(upper)
sys.exit(not all(a <= p <= b for p, a, b in zip(picture, lower, upper)))
END
}

# ---- bounds --------------------------------------------------------------------------------------

for options in "$soft" "$soft --shade" "$soft --mirror --perspective 40" "$soft --clip ,50%:," '--mode mip' \
    '--mode xray' '--mode min --window 100,120'; do
    expect_done cvol render a.cvol -o p.png $look $options --certify --json
    for field in certified:object certified.max_error:number certified.pixels:integer certified.median_width:integer \
        certified.width_90:integer certified.worst_width:integer certified.worst_pixel:array \
        certified.share_above_8:number certified.ms:number; do
        expect_field "${field%:*}" "${field#*:}"
    done
    expect_equal "$(value_of engine)" ray
    expect_equal "$(value_of certified.lower)/$(value_of certified.upper)/$(value_of certified.width)" \
        p.lower.png/p.upper.png/p.width.png
    expect_number "$(value_of certified.max_error)" '>' 0
    expect_number "$(value_of certified.max_error)" '<=' 2
    expect_number "$(value_of certified.worst_width)" '>=' "$(value_of certified.width_90)"
    expect_number "$(value_of certified.width_90)" '>=' "$(value_of certified.median_width)"
    case $options in # the look of --certify when nothing is chosen
    *--shade* | *--mode*) light= ;;
    *) light='--light flat' ;;
    esac
    expect_done cvol render in.nrrd -o original.png $look $options --engine ray --fit box $light
    expect_within original.png p.lower.png p.upper.png
    expect_within p.png p.lower.png p.upper.png
    expect_other_file p.lower.png p.upper.png
done

# A line for people: the error, the median, and the worst pixel.
expect_done cvol render a.cvol -o p.png $look $soft --certify
expect_equal "$(grep -c '^certified: .* within .* median width of .* worst .* at ' "$out")" 1
expect_equal "$(grep -c 'says little' "$out")" 0

# Exact files and dense samples: the picture itself, three times.
expect_done cvol compress in.nrrd exact.cvol --lossless
for input in exact.cvol in.nrrd; do
    expect_done cvol render $input -o p.png $look $soft --certify --json
    expect_equal "$(value_of certified.worst_width)" 0
    expect_same_file p.png p.lower.png
    expect_same_file p.png p.upper.png
done
expect_done cvol render exact.cvol -o p.png --size 32 --mode iso --iso 100 --certify

# A bound that says little.
cat >steep.json <<'END'
{"points": [[100, 0, 0, 0, 0], [101, 1, 1, 1, 1], [102, 0, 0, 0, 1], [103, 1, 1, 1, 0.5], [110, 0, 1, 0, 1]]}
END
expect_done cvol compress in.nrrd bad.cvol --psnr 20 --force
expect_done cvol render bad.cvol -o p.png --size 32 --transfer steep.json --certify
expect_equal "$(grep -c '^bad.cvol: the bound of this file (max_error .*) says little about this picture; compress with --max-error' "$out")" 1

# Several volumes.
cp a.cvol b.cvol
expect_done cvol render a.cvol b.cvol -o '{name}.png' --size 32 --certify
for name in a b; do
    for file in $name.png $name.lower.png $name.upper.png $name.width.png; do
        [ -s "$file" ] || fail "must write $file"
    done
done

# ---- messages ------------------------------------------------------------------------------------

rm -f x*.png
refuse() {
    words=$1
    shift
    expect_failure 2 "$words" cvol render a.cvol --certify "$@"
}
refuse '--certify draws with engine ray: leave out --engine sheet' -o x.png --engine sheet
refuse '--certify draws with engine ray: leave out --engine splat' -o x.png --engine splat
refuse 'x.pfm: --certify writes four PNG files: the name must end in .png' -o x.pfm
refuse '--certify cannot be combined with --bits' -o x.png --bits 16
refuse '--certify cannot be combined with --level' -o x.png --level 1
refuse '--certify cannot be combined with --annotate' -o x.png --annotate
refuse '--certify cannot be combined with --background transparent' -o x.png --background transparent
refuse '--certify cannot be combined with --depth' -o x.png --depth x.pfm
refuse '--certify cannot be combined with --opacity' -o x.png --opacity x.pfm
refuse '--certify cannot be combined with --turntable' -o 'x{n}.png' --turntable 3
refuse '--certify cannot be combined with --progressive' -o x.png --progressive
expect_failure 1 'a.cvol: mode iso has no certified pictures of samples with an error' \
    cvol render a.cvol -o y.png --certify --mode iso --iso 100
expect_done cvol compress in.nrrd whole.cvol --transform dht --ratio 4
expect_failure 1 'whole.cvol: --certify needs a volume in DCT blocks' \
    cvol render whole.cvol -o y.png --certify --mode mip
expect_no_file x.png
expect_no_file x.lower.png
