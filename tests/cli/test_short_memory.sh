#!/bin/sh
# Limited address space (ulimit -v): the command succeeds, or reports in one sentence that memory is short. It
# reports no file as damaged, and no library ends the process.
. "$(dirname "$0")/lib.sh"

make_volume in.raw uint8 90x80x70
raw='--dims 90x80x70 --type uint8'
expect_done cvol compress in.raw a.cvol $raw --psnr 40
expect_done cvol compress in.raw whole.cvol $raw --transform dct --block 0 --keep 30,2000

# limited KB COMMAND...: runs the command with a limited address space.
limited() {
    kb=$1
    shift
    command_run="$* (ulimit -v $kb)"
    status=0
    (
        ulimit -v "$kb"
        exec "$@"
    ) >"$out" 2>"$err" </dev/null || status=$?
    grep -q 'error while loading shared libraries\|cannot allocate memory in static TLS' "$err" && return 0
    case $status in
    0) ;;
    1)
        grep -q 'memory' "$err" || fail "must report that memory is short: $(head -n 3 "$err")"
        expect_equal "$(wc -l <"$err")" 1
        ;;
    *) fail "status $status with $kb kB: $(head -n 3 "$err")" ;;
    esac
}

for kb in 24000 27000 30000 34000 40000 50000 60000 80000 100000 150000 300000; do
    limited $kb "$CVOL" render a.cvol -o x.png --size 200
    limited $kb "$CVOL" decompress a.cvol x.raw
    limited $kb "$CVOL" decompress whole.cvol x.raw
done

# The largest number of threads.
expect_done cvol render a.cvol -o x.png --size 60 --threads 1024
