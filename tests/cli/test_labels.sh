#!/bin/sh
# Label volumes are compressed losslessly by default. cvol detects them by the file's metadata or by the samples.
. "$(dirname "$0")/lib.sh"

# Runs of twelve samples of one label and twelve of another; line ends match neither.
line=$(printf '\\003%.0s' 1 2 3 4 5 6 7 8 9 10 11 12; printf '\\011%.0s' 1 2 3 4 5 6 7 8 9 10 11 12)
i=0
while [ $i -lt 320 ]; do
    printf "$line"
    i=$((i + 1))
done >labels.raw
raw='--dims 24x20x16 --type uint8'
expect_status 0 cvol compress labels.raw out.cvol $raw
grep -q 'samples are labels.*--labels no' "$err" || fail 'must print that samples are labels'
expect_done cvol info out.cvol --json
expect_equal "$(value_of exact)" true
expect_done cvol decompress out.cvol back.raw
expect_same_file back.raw labels.raw

# A target, or --labels no, turns the detection off.
expect_done cvol compress labels.raw lossy.cvol $raw --labels no --json
expect_done cvol compress labels.raw lossy.cvol $raw --psnr 20
expect_failure 2 '--labels is*maybe' cvol compress labels.raw no.cvol $raw --labels maybe
expect_failure 2 '--labels yes*target' cvol compress labels.raw no.cvol $raw --labels yes --ratio 30

# Options of lossy compression are ignored.
for more in --smallest '--effort max' '--background 3' --fast --no-lap; do
    expect_status 0 cvol compress labels.raw more.cvol $raw $more
    grep -q 'samples are labels' "$err" || fail "must print that samples are labels, with $more"
    expect_done cvol decompress more.cvol back.raw
    expect_same_file back.raw labels.raw
done

# --labels yes never gives a lossy file.
expect_failure 2 '--labels yes needs DCT blocks' cvol compress labels.raw no.cvol $raw --labels yes --block 0
expect_failure 2 '--labels yes needs DCT blocks' cvol compress labels.raw no.cvol $raw --labels yes --transform dht
expect_failure 2 '--stream cannot be combined with --labels yes' cvol compress labels.raw no.cvol $raw --labels yes --stream
expect_failure 2 '--background 3 cannot be combined with --labels yes' cvol compress labels.raw no.cvol $raw --labels yes --background 3
expect_done cvol compress labels.raw kept.cvol $raw --labels yes --lossless

# Smooth samples are no labels, unless an option or the file's metadata marks them as labels.
make_volume smooth.raw uint8 24x20x16
expect_done cvol compress smooth.raw smooth.cvol $raw --psnr 40
expect_done cvol info smooth.cvol --json
expect_equal "$(value_of exact)" false
expect_done cvol compress smooth.raw kept.cvol $raw --labels yes
expect_done cvol decompress kept.cvol back.raw
expect_same_file back.raw smooth.raw
expect_done cvol decompress kept.cvol mine.nrrd
cp mine.nrrd mine.seg.nrrd
run cvol compress mine.seg.nrrd seg.cvol
grep -q 'samples are labels' "$err" || fail 'must detect labels by the ending .seg.nrrd'
expect_done cvol decompress seg.cvol back.raw
expect_same_file back.raw smooth.raw
expect_done cvol decompress kept.cvol mine.nii
printf '\352\003' | dd of=mine.nii bs=1 seek=68 conv=notrunc 2>/dev/null # intent code 1002
run cvol compress mine.nii nii.cvol
grep -q 'samples are labels' "$err" || fail 'must detect labels by the intent code'
expect_done cvol decompress nii.cvol back.raw
expect_same_file back.raw smooth.raw
head -c 344 mine.nii >pair.hdr # the same as a pair of files
printf 'ni1\0' >>pair.hdr
tail -c +353 mine.nii >pair.img
printf '\0\0\0\0' | dd of=pair.hdr bs=1 seek=108 conv=notrunc 2>/dev/null # vox_offset
for ending in hdr img; do
    run cvol compress pair.$ending $ending.cvol
    grep -q 'samples are labels' "$err" || fail "must detect labels by the intent code of pair.$ending"
done

# Each of several volumes is tested; one message reports the number.
cp labels.raw labels2.raw
expect_done cvol compress labels.raw smooth.raw labels2.raw -o many.cvol $raw
grep -q '2 of 3 volumes are labels' "$out" || fail 'must count volumes of labels'
expect_done cvol decompress many.cvol back.raw --time 2
expect_same_file back.raw labels.raw
expect_done cvol compress labels.raw smooth.raw labels2.raw -o many.cvol $raw --labels no
grep -q 'are labels' "$out" && fail 'must not detect labels'
expect_done cvol compress labels.raw labels2.raw -o many.cvol $raw --labels yes
expect_done cvol decompress many.cvol back.raw --time 1
expect_same_file back.raw labels.raw

# transcode does not make labels lossy, unless it is forced to.
cp out.cvol kept.cvol
for target in '--ratio 400' '--bpv 0.01' '--psnr 30'; do
    option=${target% *}
    expect_failure 1 "out.cvol: samples are labels, which $option would change; keep the file, or give --force" \
        cvol transcode out.cvol no.cvol $target
done
run cvol transcode out.cvol kept.cvol --ratio 400
expect_same_file kept.cvol out.cvol
# Labels that a file names are labels, whatever they look like.
printf '1 Skull 255 0 0 0\n' >names.txt
expect_done cvol compress smooth.raw named.cvol $raw --labels yes --label-table names.txt
expect_failure 1 'named.cvol: samples are labels' cvol transcode named.cvol no.cvol --psnr 40
expect_done cvol transcode named.cvol forced.cvol --psnr 40 --force --json
expect_equal "$(value_of exact)" false
expect_done cvol compress smooth.raw plain.cvol $raw --lossless
expect_done cvol transcode plain.cvol smaller.cvol --psnr 40

# Labels of atlases may be far apart: 0, 997 and 614454277.
far() { # two lines of 24 samples; the last runs of the first one are of value $1
    for value in '\\000\\000\\000\\000' '\\345\\003\\000\\000' "$1" '\\345\\003\\000\\000'; do
        printf "$value%.0s" 1 2 3 4 5 6 7 8 9 10 11 12
    done
}
line=$(far '\\005\\324\\237\\044')
i=0
while [ $i -lt 160 ]; do
    printf "$line"
    i=$((i + 1))
done >far.raw
raw='--dims 24x20x16 --type uint32'
expect_done cvol info far.raw $raw --json
expect_equal "$(value_of labels.2.value) $(value_of labels.2.samples)" '614454277 1920'
expect_status 0 cvol compress far.raw far.cvol $raw
grep -q 'samples are labels' "$err" || fail 'must detect labels that are far apart'
expect_done cvol info far.cvol --json
expect_equal "$(value_of labels.0.samples) $(value_of labels.1.value)" '1920 997'
expect_done cvol render far.cvol -o far.png --size 16 --labels 614454277
# Values that do not fit into 32 bits with a sign are not listed.
line=$(far '\\377\\377\\377\\377')
i=0
while [ $i -lt 160 ]; do
    printf "$line"
    i=$((i + 1))
done >far.raw
expect_done cvol info far.raw $raw --json
expect_status 0 cvol compress far.raw far.cvol $raw
grep -q 'samples are labels' "$err" || fail 'must detect labels that are far apart'
expect_done cvol info far.cvol

# Samples without a value are no label in pictures, whatever their fill.
mask() { # LETTERS: 24 x 20 x 16 samples in runs of 6
    i=0
    while [ $i -lt 320 ]; do
        for letter in $1; do
            printf "%s%s%s%s%s%s" $letter $letter $letter $letter $letter $letter
        done
        i=$((i + 1))
    done
}
raw='--dims 24x20x16 --type uint8'
mask 'a b c d' >with.raw
tr 'abcd' '\000\001\377\002' <with.raw >marked.raw
tr 'abcd' '\000\001\000\002' <with.raw >clear.raw
expect_status 0 cvol compress marked.raw marked.cvol $raw --fill 255 --lossless
expect_status 0 cvol compress clear.raw clear.cvol $raw --lossless
for more in '' '--labels 1' '--engine ray'; do
    expect_done cvol render clear.cvol -o clear.png --size 32 $more
    expect_done cvol render marked.cvol -o marked.png --size 32 $more
    expect_same_file clear.png marked.png
done
expect_done cvol render clear.cvol -o clear.png --size 32 --overlay clear.cvol
expect_done cvol render clear.cvol -o marked.png --size 32 --overlay marked.cvol --json
expect_equal "$(value_of overlays.0.drawn.0.value)" 1
expect_same_file clear.png marked.png
