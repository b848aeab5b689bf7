#!/bin/sh
# kill -9 at any moment while cvol compresses over an existing file: the output is the complete old file or the
# complete new file. On file systems with unnamed files (O_TMPFILE) a hidden file remains only if the kill falls
# between the two steps that name the new file. On others hidden files may remain; later commands ignore them.
# Environment: CVOL_KILLS, the number of kills (default 20).
. "$(dirname "$0")/lib.sh"

kills=${CVOL_KILLS:-20}
dims=100x60x70
make_volume in.raw uint8 $dims
raw="--dims $dims --type uint8"
expect_done cvol compress in.raw old.cvol $raw --ratio 20 --threads 1
expect_done cvol compress in.raw new.cvol $raw --psnr 50 --threads 1
run cvol compress in.raw new-stream.cvol $raw --psnr 50 --stream --threads 1

# The duration of a compression in milliseconds; the kills are spread over a longer interval.
now() { date +%s%N | cut -c 1-13; }
begin=$(now)
run cvol compress in.raw timed.cvol $raw --psnr 50 --threads 1
took=$(($(now) - begin + 20))
rm timed.cvol

: >left
old=0
new=0
i=0
while [ "$i" -lt "$kills" ]; do
    case $((i % 2)) in
    0) how='' fresh=new.cvol ;;
    1) how=--stream fresh=new-stream.cvol ;;
    esac
    # Multiples of the golden ratio spread evenly over the interval.
    after=$(awk "BEGIN { x = ($i + 0.5) * 0.6180339887; printf \"%.3f\", (x - int(x)) * $took / 700 }")
    cp old.cvol out.cvol
    command_run="cvol compress ... $how, killed after $after s of $took ms"
    # shellcheck disable=SC2086
    "$CVOL" compress in.raw out.cvol $raw --psnr 50 --threads 1 $how >"$out" 2>"$err" </dev/null &
    child=$!
    sleep "$after"
    kill -KILL "$child" 2>/dev/null || :
    wait "$child" 2>/dev/null || :
    if cmp -s out.cvol old.cvol; then
        old=$((old + 1))
    elif cmp -s out.cvol "$fresh"; then
        new=$((new + 1))
    else
        fail 'out.cvol must be the old file or the new one'
    fi
    expect_done cvol verify out.cvol
    i=$((i + 1))
done
for name in .[!.]*; do
    case $name in
    '.[!.]*') ;;
    .cvol-*) echo "$name" >>left ;;
    *) fail "$name must not exist" ;;
    esac
done
echo "$kills kills: $old times the old file, $new times the new one; $(wc -l <left) hidden files left"

# Remaining hidden files do not disturb later commands.
expect_done cvol compress in.raw out.cvol $raw --psnr 50 --threads 1
expect_same_file out.cvol new.cvol
