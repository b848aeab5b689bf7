#!/bin/sh
# A ratio that gives less than 25 dB would lose most of the signal. cvol refuses it unless --force is given; without
# a target it compresses to 35 dB instead.
. "$(dirname "$0")/lib.sh"

# The bytes of a gzip file are noise.
make_volume smooth.raw uint8 24x20x16
cvol compress smooth.raw smooth.cvol --dims 24x20x16 --type uint8 --lossless >/dev/null
head -c 100000 "$CVOL_SAMPLES/ch2better.nii.gz" | tail -c 96000 >noise.raw
raw='--dims 300x20x16 --type uint8'

# The default target gives way, and a message reports it.
expect_status 0 cvol compress noise.raw default.cvol $raw --labels no
grep -q 'noise.raw: ratio 30 leaves a PSNR of .* less than 25 dB; compressed to 35 dB instead' "$err" ||
    fail 'must report the PSNR used instead'
expect_done cvol compare noise.raw default.cvol $raw --json
[ "$(value_of psnr_db | cut -d. -f1)" -ge 35 ] || fail 'must have 35 dB'
expect_done cvol compress noise.raw default.cvol $raw --labels no --json
expect_equal "$(value_of yielded_to_psnr)" true
expect_equal "$(value_of target_met)" true

# An explicit target is refused without --force, and the existing file stays.
cp smooth.cvol old.cvol
for target in '--ratio 30' '--bpv 0.2'; do
    expect_failure 1 'noise.raw: *leave* a PSNR of * less than 25 dB; give --psnr 35*--force' \
        cvol compress noise.raw no.cvol $raw --labels no $target
    run cvol compress noise.raw old.cvol $raw --labels no $target
    expect_same_file old.cvol smooth.cvol
    expect_done cvol compress noise.raw forced.cvol $raw --labels no $target --force --json
    expect_equal "$(value_of yielded_to_psnr)" false
    [ "$(wc -c <forced.cvol)" -le 3300 ] || fail 'must reach the ratio'
done
expect_done cvol compress noise.raw forced.cvol $raw --labels no --force --json
[ "$(wc -c <forced.cvol)" -le 3300 ] || fail 'must reach the default ratio'
# A PSNR or a number of terms defines the quality explicitly.
expect_done cvol compress noise.raw asked.cvol $raw --psnr 12
expect_done cvol compress noise.raw asked.cvol $raw --block 0 --keep 2,10

# Slab by slab (--stream).
expect_failure 1 'noise.raw: ratio 30 leaves*--force' \
    cvol compress noise.raw no.cvol $raw --stream --ratio 30 --json
run cvol compress noise.raw old.cvol $raw --stream --ratio 30
expect_same_file old.cvol smooth.cvol
expect_status 0 cvol compress noise.raw slabs.cvol $raw --stream
grep -q 'compressed to 35 dB instead' "$err" || fail 'must report the PSNR used instead'
expect_done cvol compare noise.raw slabs.cvol $raw --json
[ "$(value_of psnr_db | cut -d. -f1)" -ge 35 ] || fail 'must have 35 dB'
expect_status 0 cvol compress noise.raw slabs.cvol $raw --stream --force

# Other transforms.
expect_failure 1 'noise.raw: ratio 30 leaves*--force' \
    cvol compress noise.raw no.cvol $raw --transform dht --ratio 30
expect_status 0 cvol compress noise.raw dht.cvol $raw --transform dht
grep -q 'compressed to 35 dB instead' "$err" || fail 'must report the PSNR used instead'
expect_done cvol compress noise.raw dht.cvol $raw --transform dht --force

head -c 2000 noise.raw >few.raw
expect_status 0 cvol compress few.raw few.cvol --dims 50x40x1 --type uint8 --block 0
grep -q 'compressed to 35 dB instead' "$err" || fail 'must report the PSNR used instead'
expect_failure 1 'few.raw: ' cvol compress few.raw no.cvol --dims 50x40x1 --type uint8 --block 0 --ratio 30

# Several volumes in one file.
cp noise.raw noise2.raw
expect_failure 1 'noise.raw: ratio 30 leaves*--force' \
    cvol compress noise.raw noise2.raw -o no.cvol $raw --ratio 30
expect_done cvol compress noise.raw noise2.raw -o many.cvol $raw
grep -q '2 of 2 volumes: ratio 30 would give.*35 dB' "$out" || fail 'must report the PSNR used instead'
expect_done cvol compress noise.raw noise2.raw -o many.cvol $raw --force

# Rendering compresses dense samples in memory.
expect_status 0 cvol render noise.raw -o noise.png $raw --size 40

# ---- cvol transcode -------------------------------------------------------------------------------

# The same limit holds for a smaller file made from a file; its PSNR is a certified one.
expect_done cvol compress noise.raw fine.cvol $raw --labels no --psnr 50
expect_done cvol compress noise.raw exact.cvol $raw --labels no --lossless
for from in fine exact; do
    for target in '--ratio 30' '--bpv 0.2'; do
        expect_failure 1 "$from.cvol: *leave*PSNR of * less than 25 dB; give --psnr 35*--force" \
            cvol transcode $from.cvol no.cvol $target
        expect_done cvol transcode $from.cvol forced.cvol $target --force --json
        expect_number "$(value_of ratio)" '>=' 30
    done
    expect_done cvol transcode $from.cvol asked.cvol --psnr 12
done
expect_failure 1 'fine.cvol: *certified PSNR' cvol transcode fine.cvol no.cvol --ratio 30 --json
cp smooth.cvol old.cvol
run cvol transcode fine.cvol old.cvol --ratio 30
expect_same_file old.cvol smooth.cvol
