#!/bin/sh
# Ctrl-C: the command stops, prints one sentence, and leaves no file.
. "$(dirname "$0")/lib.sh"

scan=$CVOL_SAMPLES/ch2better.nii.gz

# interrupt SIGNAL SECONDS COMMAND...: sends the signal after SECONDS, and repeats it until the command ends. A
# signal that arrives before the command installs its handler is ignored.
interrupt() {
    signal=$1
    after=$2
    shift 2
    command_run="$* (with SIG$signal after $after s)"
    status=0
    (
        trap '' "$signal"
        exec "$@" >"$out" 2>"$err" </dev/null
    ) &
    child=$!
    sleep "$after"
    left=100
    while [ $left -gt 0 ] && kill -s "$signal" "$child" 2>/dev/null; do
        sleep 0.1
        left=$((left - 1))
    done
    wait "$child" || status=$?
}

: >names
echo old >out.cvol
cp out.cvol old.cvol
ls -A >names
cp names before
for signal in INT TERM; do
    for after in 0.1 0.5; do
        interrupt $signal $after "$CVOL" compress "$scan" out.cvol --psnr 50 --threads 1
        expect_equal "$status" 1
        expect_sentence 'cancelled'
        expect_no_output
        expect_same_file out.cvol old.cvol
        expect_equal "$(ls -A | tr '\n' ' ')" 'before names old.cvol out.cvol '
    done
done

# SIGBUS: a page of a mapped file is gone. The command prints one sentence.
interrupt BUS 0.5 "$CVOL" compress "$scan" out.cvol --psnr 50 --threads 1
expect_equal "$status" 1
expect_sentence 'a file became shorter, or unreadable, while cvol was reading it'
expect_no_output
expect_same_file out.cvol old.cvol

awk 'BEGIN { for (i = 0; i < 20000; i++) print i % 360, 20, 0 }' >poses.csv
for after in 0.2 3; do
    interrupt INT $after "$CVOL" render "$scan" --threads 1 --engine fourier --poses poses.csv -o out.nrrd
    expect_equal "$status" 1
    expect_sentence 'cancelled'
    expect_no_output
    expect_no_file out.nrrd
done
interrupt INT 0.3 "$CVOL" render "$scan" --threads 1 -o out.png --json
expect_equal "$status" 1
expect_sentence 'cancelled'
expect_no_output
expect_no_file out.png
