#!/bin/sh
# Compressed pictures: from PNG and back, compared, described, verified, and decoded by the reference decoder.
. "$(dirname "$0")/lib.sh"

dims=44x40x36
make_volume in.raw uint8 $dims
expect_done cvol compress in.raw a.cvol --dims $dims --type uint8 --psnr 50
expect_done cvol render a.cvol -o a.png --size 128x96 --azimuth 30 --elevation 20

# ---- round trip ----------------------------------------------------------------------------------

expect_done cvol compress a.png a.cvi --psnr 40 --json
for field in width:integer height:integer lattice:array planes:integer transform:string block:integer \
    step:number coefficients:integer rho:number ratio:number bits_per_pixel:number file_bytes:integer \
    psnr_db:decibels l2_error:number rms_bound:number kind:string; do
    expect_field "${field%:*}" "${field#*:}"
done
expect_number "$(value_of psnr_db)" '>=' 40
expect_number "$(value_of psnr_db)" '<' 41
expect_equal "$(value_of file_bytes)" "$(wc -c <a.cvi)"
expect_done cvol compress a.png b.cvi --psnr 40 --threads 3
expect_same_file a.cvi b.cvi
expect_done cvol info a.cvi --json
expect_equal "$(value_of kind)" picture
expect_equal "$(value_of width)x$(value_of height)" 128x96
expect_done cvol info a.cvi
grep -q '^  rms_bound\|^  \.\.\. RMS' "$out" || fail 'must print the bound'
expect_done cvol info a.cvi --layout
grep -q '^  PLNS .* sound ' "$out" || fail 'must list the planes'
expect_done cvol verify a.cvi a.cvol
expect_done cvol decompress a.cvi b.png --json
expect_equal "$(value_of output)" b.png
for pair in 'b.png a.cvi' 'a.cvi b.png' 'a.cvi a.cvi'; do
    expect_done cvol compare $pair --json
    expect_field psnr_db null
    expect_equal "$(value_of exact)" true
done
expect_done cvol compare a.png a.cvi --json
expect_number "$(value_of psnr_db)" '>=' 40
for method in '--ratio 20' '--ratio 20 --block 32' '--psnr 35 --transform dft --block 0' '--psnr 35 --transform dht --block 8'; do
    expect_done cvol compress a.png b.cvi $method --json
    case $method in *ratio*) expect_number "$(value_of ratio)" '>=' 20 ;; esac
    expect_done cvol compare a.png b.cvi --json
    expect_number "$(value_of psnr_db)" '>=' 35
done

# ---- the reference decoder -----------------------------------------------------------------------

python=/usr/bin/python3
[ -x $python ] || python=python3
# reference IN.cvi WIDTH HEIGHT: decodes IN.cvi with the reference decoder into ref.png. (A PNG without filters
# needs no library.)
reference() {
    expect_done $python "$CVOL_DOC/decoder_ref.py" "$1" ref.raw
    expect_equal "$(value_of width)" "$2"
    $python - "$2" "$3" <<'END' || fail 'the reference decoder must give pixels'
import struct, sys, zlib
import numpy as np
width, height = map(int, sys.argv[1:])
raw = np.fromfile("ref.raw", np.uint8).reshape(height, width, 4)
rows = b"".join(b"\0" + row[:, :3].tobytes() for row in raw)
def chunk(tag, data):
    return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))
with open("ref.png", "wb") as file:
    file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
               + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
END
}

if $python -c 'import numpy' 2>/dev/null; then
    for method in '--psnr 40' '--psnr 35 --transform dft --block 0' '--psnr 35 --transform dht --block 8'; do
        expect_done cvol compress a.png b.cvi $method
        reference b.cvi 128 96
        expect_done cvol compare b.cvi ref.png --json
        expect_number "$(value_of psnr_db)" '>=' 75 # pixels differ only by rounding
    done
    expect_done cvol render a.cvol -o b.cvi --size 96x80 --engine transform --azimuth 30 --background 0.2,0.4,0.9
    reference b.cvi 96 80
    expect_done cvol compare b.cvi ref.png --json
    expect_number "$(value_of psnr_db)" '>=' 60
else
    echo 'skipped: the reference decoder (no python3 with numpy)'
fi

# ---- engine transform, and progressive rendering -------------------------------------------------

view='--size 96 --azimuth 30 --elevation 20 --engine transform --background 0.2,0.4,0.9'
for option in '' '--psnr 38' '--ratio 40' '--schedule literal --spectrum dht' '--schedule literal' '--transfer hot'; do
    case $option in
    *psnr* | *ratio*) expect_done cvol render a.cvol -o whole.png $view ;;
    *) expect_done cvol render a.cvol -o whole.png $view $option ;;
    esac
    expect_done cvol render a.cvol -o kept.cvi $view $option --json
    expect_equal "$(value_of picture.planes)" 4
    expect_equal "$(value_of picture.file_bytes)" "$(wc -c <kept.cvi)"
    expect_field transform.lattice array
    kept=$(value_of picture.psnr_db)
    case $option in
    *ratio*) expect_number "$(value_of picture.ratio)" '>=' 40 ;;
    *psnr*) expect_number "$kept" '>=' 38 ;;
    *) expect_number "$kept" '>=' 45 ;;
    esac
    case $option in
    *dht*) expect_equal "$(value_of picture.transform)" dht ;;
    *) expect_equal "$(value_of picture.transform)" dct ;;
    esac
    expect_done cvol compare whole.png kept.cvi --json
    expect_near "$(value_of psnr_db)" "$kept" 0.001
    expect_done cvol decompress kept.cvi kept.png
    expect_done cvol compare kept.png kept.cvi --json
    expect_field psnr_db null
    expect_done cvol verify kept.cvi
done

view='--size 96 --azimuth 30 --elevation 20'
expect_done cvol render a.cvol -o fine.png $view
expect_done cvol render a.cvol -o out.png $view --progressive --json
for i in 0 1 2 3; do
    expect_equal "$(value_of pictures.$i.level)" $((3 - i))
    expect_field pictures.$i.render_ms number
done
expect_equal "$(value_of pictures.0.output)" out-1.png
expect_equal "$(value_of pictures.3.output)" out.png
expect_same_file out.png fine.png
expect_done cvol render a.cvol -o coarse.png $view --level 3
expect_same_file out-1.png coarse.png
rm out*.png
expect_done cvol render a.cvol -o out.png $view --progressive --level 2
list_names
case $names in *out-1.png*out.png*) ;; *) fail "two pictures must exist: $names" ;; esac
expect_no_file out-2.png
expect_done cvol render a.cvol -o fine.png $view --engine transform
expect_done cvol render a.cvol -o out.png $view --engine transform --progressive --json
expect_same_file out.png fine.png
expect_equal "$(value_of pictures.1.transform.bake_ms)" 0.0
before=0
for i in 0 1 2 3; do
    now=$(value_of pictures.$i.transform.coefficients)
    expect_number "$now" '>' $before
    before=$now
done
expect_done cvol compare fine.png out-3.png --json
expect_number "$(value_of psnr_db)" '>=' 30

# ---- misuse and damage ---------------------------------------------------------------------------

expect_failure 2 'must end in .cvi' cvol compress a.png b.cvol
expect_failure 2 'must end in .cvol' cvol compress in.raw c.cvi --dims $dims --type uint8
expect_failure 2 'leave out --lossless' cvol compress a.png c.cvi --lossless
expect_failure 2 'leave out --dims' cvol compress a.png c.cvi --dims 2x2x2
expect_failure 2 'leave out --background' cvol compress a.png c.cvi --background 0
expect_failure 2 'at most 100' cvol compress a.png c.cvi --psnr 120
expect_failure 1 'ratio 1e+06 cannot be reached' cvol compress a.png c.cvi --ratio 1e6
expect_failure 2 'must end in .png' cvol decompress a.cvi c.nrrd
expect_failure 2 'leave out --box and --level' cvol decompress a.cvi c.png --level 1
expect_failure 1 'is a compressed picture, not a volume' cvol render a.cvi -o c.png
expect_failure 1 'is a compressed picture, not a volume' cvol compare a.cvi a.cvol
expect_failure 2 'only engine transform draws compressed pictures' cvol render a.cvol -o c.cvi
expect_failure 2 '--psnr works only with compressed pictures' cvol render a.cvol -o c.png --psnr 40
expect_failure 2 'only one of' cvol render a.cvol -o c.cvi --engine transform --psnr 40 --ratio 3
expect_failure 2 '--psnr is 101' cvol render a.cvol -o c.cvi --engine transform --psnr 101
expect_failure 2 '--ratio is 1,' cvol render a.cvol -o c.cvi --engine transform --ratio 1
expect_failure 2 'works only with engines sheet and transform' cvol render a.cvol -o c.png --engine ray --progressive
expect_failure 2 '--progressive needs a .cvol file' cvol render in.raw --dims $dims --type uint8 -o c.png --progressive
size=$(wc -c <a.cvi)
for at in 2 9 17 30 40 150 250 $((size / 2)) $((size - 30)) $((size - 2)); do
    cp a.cvi bad.cvi
    poke bad.cvi $at xor 32
    expect_failure 1 'bad.cvi' cvol decompress bad.cvi c.png
    rm bad.cvi
done
for length in 5 20 40 200 $((size - 30)) $((size - 1)); do
    head -c "$length" a.cvi >bad.cvi
    expect_failure 1 'bad.cvi' cvol decompress bad.cvi c.png
    expect_status 1 cvol verify bad.cvi
    rm bad.cvi
done
