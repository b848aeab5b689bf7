#!/bin/sh
# Compressed pictures: from PNGs and back, compared, described, verified, and decoded by the reference.
. "$(dirname "$0")/lib.sh"

dims=44x40x36
make_volume in.raw uint8 $dims
expect_done cvol compress in.raw a.cvol --dims $dims --type uint8 --psnr 50
expect_done cvol render a.cvol -o a.png --size 128x96 --azimuth 30 --elevation 20

# ---- there and back ---------------------------------------------------------------------------

expect_done cvol compress a.png a.cvi --psnr 40 --json
for field in width:integer height:integer lattice:array planes:integer transform:string block:integer \
    step:number coefficients:integer rho:number ratio:number bits_per_pixel:number file_bytes:integer \
    psnr_db:number l2_error:number rms_bound:number kind:string; do
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
grep -q '^  rms_bound\|^  \.\.\. per sample' "$out" || fail 'must show the bound'
expect_done cvol info a.cvi --layout
grep -q '^  PLNS .* sound ' "$out" || fail 'must show the planes'
expect_done cvol verify a.cvi a.cvol
expect_done cvol decompress a.cvi b.png --json
expect_equal "$(value_of output)" b.png
for pair in 'b.png a.cvi' 'a.cvi b.png' 'a.cvi a.cvi'; do
    expect_done cvol compare $pair --json
    expect_equal "$(value_of psnr_db)" 999.0
done
expect_done cvol compare a.png a.cvi --json
expect_number "$(value_of psnr_db)" '>=' 40
for method in '--ratio 20' '--ratio 20 --block 32' '--psnr 35 --transform dft --block 0' '--psnr 35 --transform dht --block 8'; do
    expect_done cvol compress a.png b.cvi $method --json
    case $method in *ratio*) expect_number "$(value_of ratio)" '>=' 20 ;; esac
    expect_done cvol compare a.png b.cvi --json
    expect_number "$(value_of psnr_db)" '>=' 35
done

# ---- the reference decoder --------------------------------------------------------------------

python=/usr/bin/python3
[ -x $python ] || python=python3
if $python -c 'import numpy' 2>/dev/null; then
    # A PNG without filters is hard to read without a library: what the decoder gives is compared as a PNG.
    for method in '--psnr 40' '--psnr 35 --transform dft --block 0' '--psnr 35 --transform dht --block 8'; do
        expect_done cvol compress a.png b.cvi $method
        expect_done cvol decompress b.cvi b.png
        expect_done $python "$CVOL_DOC/decoder_ref.py" b.cvi b.raw
        expect_equal "$(value_of width)" 128
        $python - <<'END' || fail 'the reference decoder must give the same pixels'
import struct, zlib
import numpy as np
raw = np.fromfile("b.raw", np.uint8).reshape(96, 128, 4)
rows = b"".join(b"\0" + row[:, :3].tobytes() for row in raw)
def chunk(tag, data):
    return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))
with open("ref.png", "wb") as file:
    file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", 128, 96, 8, 2, 0, 0, 0))
               + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
END
        expect_done cvol compare b.png ref.png --json
        expect_number "$(value_of psnr_db)" '>=' 75 # but for roundings that fall the other way
    done
else
    echo 'skipped: the reference decoder (no python3 with numpy)'
fi

# ---- misuse and damage ------------------------------------------------------------------------

expect_failure 2 'must end in .cvi' cvol compress a.png b.cvol
expect_failure 2 'must end in .cvol' cvol compress in.raw c.cvi --dims $dims --type uint8
expect_failure 2 'takes no --lossless' cvol compress a.png c.cvi --lossless
expect_failure 2 'takes no --dims' cvol compress a.png c.cvi --dims 2x2x2
expect_failure 2 'at most 100' cvol compress a.png c.cvi --psnr 120
expect_failure 1 'ratio 1e+06 cannot be had' cvol compress a.png c.cvi --ratio 1e6
expect_failure 2 'must end in .png' cvol decompress a.cvi c.nrrd
expect_failure 2 'box and --level are for volumes' cvol decompress a.cvi c.png --level 1
expect_failure 1 'is a compressed picture, no volume' cvol render a.cvi -o c.png
expect_failure 1 'is a compressed picture, no volume' cvol compare a.cvi a.cvol
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
