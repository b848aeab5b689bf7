#!/bin/sh
# kill -9 at any moment of compressing over a file: it is the old one, whole, or the new one, whole.
# On file systems that know files without a name nothing else is left, but for a hidden file in the
# moment between the two steps in which the new one gets its name; on others hidden files may be left,
# which later commands neither use nor mind. CVOL_KILLS in the environment: how many (default 20).
. "$(dirname "$0")/lib.sh"

kills=${CVOL_KILLS:-20}
dims=100x60x70
make_volume in.raw uint8 $dims
raw="--dims $dims --type uint8"
expect_done cvol compress in.raw old.cvol $raw --ratio 20 --threads 1
expect_done cvol compress in.raw new.cvol $raw --psnr 50 --threads 1
run cvol compress in.raw new-stream.cvol $raw --psnr 50 --stream --threads 1

# Seconds that a compression takes here, in thousandths: the moments are spread over them and some more.
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
    # The golden ratio's multiples are nowhere and everywhere.
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
    *) fail "$name must not be there" ;;
    esac
done
echo "$kills kills: $old times the old file, $new times the new one; $(wc -l <left) hidden files left"

# What was left is in nobody's way.
expect_done cvol compress in.raw out.cvol $raw --psnr 50 --threads 1
expect_same_file out.cvol new.cvol
