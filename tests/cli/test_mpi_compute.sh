#!/bin/sh
# cvol-mpi computes on files by several processes: it prints, and writes, what one process does.
# shellcheck disable=SC1091,SC2154
. "${0%/*}/lib.sh"
. "${0%/*}/mpi.sh"

# ---- files: four layers of bricks --------------------------------------------------------------------------------

make_volume a.raw int16 40x36x200
make_field b.nrrd head 40x36x200 1 0 3,1,0
raw='--dims 40x36x200 --type int16'
# shellcheck disable=SC2086
{
    expect_done cvol compress a.raw a.cvol $raw --psnr 50
    expect_done cvol compress a.raw small.cvol $raw --psnr 40 --bricks 32,64,48
    expect_done cvol compress a.raw plain.cvol $raw --psnr 50 --no-lap
    expect_done cvol compress a.raw other.cvol $raw --psnr 45 --no-lap --block 8
    expect_done cvol compress a.raw exact.cvol $raw --lossless
}
expect_done cvol compress b.nrrd b.cvol --psnr 40 --labels no --background none
expect_done cvol compress b.nrrd background.cvol --psnr 40 --labels no
expect_done cvol compress b.nrrd labels.cvol --labels yes
expect_done cvol compress b.nrrd whole.cvol --transform dht --block 0 --keep 4,100

# ---- what is printed -----------------------------------------------------------------------------------------------

# expect_equal_text COMMAND...: one process, and $counts, print the same.
expect_equal_text() {
    expect_done cvol "$@"
    cp "$out" one.txt
    for n in $counts; do
        run many "$n" "$@"
        [ $status -eq 0 ] || fail "$n processes: $*: $(cat "$err")"
        cmp -s one.txt "$out" || fail "$n processes print something else: $*"
    done
}
counts=5
expect_equal_text stats a.cvol small.cvol
counts=3
expect_equal_text stats plain.cvol --json
expect_equal_text stats background.cvol b.cvol
expect_equal_text stats exact.cvol
expect_equal_text verify a.cvol small.cvol plain.cvol exact.cvol background.cvol labels.cvol
counts='1 8'
expect_equal_text verify a.cvol other.cvol --json

# ---- files -----------------------------------------------------------------------------------------------------------

# expect_equal_result COMMAND...: one process, and $counts, write the same bytes, and print the same.
expect_equal_result() {
    expect_done cvol "$@" -o one.cvol --json
    sed 's/one.cvol/many.cvol/' "$out" >one.txt
    for n in $counts; do
        run many "$n" "$@" -o many.cvol --json
        [ $status -eq 0 ] || fail "$n processes: $*: $(cat "$err")"
        cmp -s one.txt "$out" || fail "$n processes print something else: $*"
        cmp -s one.cvol many.cvol || fail "$n processes write another file: $*"
    done
}
# expect_equal_transcode IN OPTIONS...: the same for cvol transcode.
expect_equal_transcode() {
    from=$1
    shift
    expect_done cvol transcode "$from" one.cvol "$@" --json
    cp "$out" one.txt
    for n in $counts; do
        run many "$n" transcode "$from" many.cvol "$@" --json
        [ $status -eq 0 ] || fail "$n processes: transcode $*: $(cat "$err")"
        cmp -s one.txt "$out" || fail "$n processes print something else: transcode $from $*"
        cmp -s one.cvol many.cvol || fail "$n processes write another file: transcode $from $*"
    done
}

counts='2 3'
expect_equal_result add a.cvol b.cvol
counts=3
expect_equal_result multiply a.cvol b.cvol --type float64
expect_equal_result add small.cvol plain.cvol --alpha 0.3
expect_equal_result multiply other.cvol other.cvol
expect_equal_result multiply background.cvol a.cvol
expect_equal_result convolve background.cvol --kernel gaussian:1.5
counts=2
expect_equal_result add small.cvol exact.cvol --step 30
expect_equal_result gradient small.cvol --lossless-algebra
expect_equal_transcode a.cvol --ratio 100
expect_equal_transcode plain.cvol --bricks 48
counts=3
expect_equal_transcode small.cvol --psnr 35 --bricks 32
expect_equal_transcode background.cvol --ratio 900 --force
expect_equal_transcode exact.cvol --ratio 20
counts=6
expect_equal_result add small.cvol a.cvol --beta -2
expect_equal_result convolve plain.cvol --kernel box:3

# ---- damage ----------------------------------------------------------------------------------------------------------

# expect_equal_damage FILE...: the first damage of each file, once.
expect_equal_damage() {
    expect_status 1 cvol verify "$@"
    cp "$out" one.txt
    cp "$err" one.err
    run many 3 verify "$@"
    expect_equal "$status" 1
    cmp -s one.txt "$out" || fail "3 processes print something else: $*"
    grep '^cvol: ' "$err" >many.err || :
    cmp -s one.err many.err || fail "3 processes find something else: $*: $(cat many.err)"
}
size=$(wc -c <small.cvol)
cp small.cvol damaged.cvol
poke damaged.cvol $((size - 100)) xor 1 $((size / 2)) xor 1 $((size / 3)) xor 1
cp a.cvol late.cvol
poke late.cvol $((size - 100)) xor 1
head -c $((size / 2)) a.cvol >cut.cvol
expect_equal_damage damaged.cvol none.cvol late.cvol a.cvol cut.cvol b.nrrd

# ---- one sentence ------------------------------------------------------------------------------------------------------

# expect_one_sentence STATUS PATTERN COMMAND...: nothing else remains.
expect_one_sentence() {
    wanted=$1
    pattern=$2
    shift 2
    list_names
    before=$names
    run timeout 20 "$@"
    [ $status -eq "$wanted" ] || fail "status $status instead of $wanted: $*"
    [ "$(grep -c '^cvol: ' "$err")" -eq 1 ] || fail "one sentence: $(cat "$err")"
    grep -q "$pattern" "$err" || fail "must say $pattern: $(cat "$err")"
    list_names
    expect_equal "$names" "$before"
}
expect_one_sentence 1 '^cvol: none.cvol: No such file' mpirun -n 3 "$mpi" stats none.cvol
expect_one_sentence 1 'process 1 on .*none.cvol: No such file' \
    mpirun -n 1 "$mpi" stats a.cvol : -n 1 "$mpi" stats none.cvol
expect_one_sentence 1 'process 1: none.cvol: No such file' \
    mpirun -n 1 "$mpi" verify a.cvol a.cvol : -n 1 "$mpi" verify none.cvol a.cvol
expect_one_sentence 2 'process 1 on .*unknown option' \
    mpirun -n 1 "$mpi" verify a.cvol a.cvol : -n 1 "$mpi" verify a.cvol --nothing
# Each process reads its own bricks: the first does not see the damage.
make_volume wide.raw int16 90x100x200
expect_done cvol compress wide.raw wide.cvol --dims 90x100x200 --type int16 --psnr 40 --bricks 32 --fast
poke wide.cvol $(($(wc -c <wide.cvol) - 100)) xor 1
expect_one_sentence 1 'process [12] on .*: wide.cvol: .*damaged' mpirun -n 3 "$mpi" stats wide.cvol
expect_one_sentence 1 'several processes keep all terms' \
    mpirun -n 2 "$mpi" add a.cvol a.cvol -o sum.cvol --keep 4,100
expect_one_sentence 1 'whole.cvol: is no volume in dct blocks' mpirun -n 2 "$mpi" stats whole.cvol
expect_one_sentence 1 'nowhere/sum.cvol: ' mpirun -n 2 "$mpi" add a.cvol a.cvol -o nowhere/sum.cvol
expect_one_sentence 1 'b.nrrd: several processes compute on .cvol files: compress it first' \
    mpirun -n 2 "$mpi" stats b.nrrd
