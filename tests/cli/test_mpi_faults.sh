#!/bin/sh
# cvol-mpi: a process that is killed ends all within ten seconds; the old file stays, or the complete new one has its
# name, and nothing half-written remains.
# shellcheck disable=SC1091,SC2154
. "${0%/*}/lib.sh"
. "${0%/*}/mpi.sh"

make_volume long.raw int16 120x120x400
raw='--dims 120x120x400 --type int16'
# shellcheck disable=SC2086
expect_done cvol compress long.raw a.cvol $raw --psnr 50 --fast

# Process 1 kills itself after some seconds.
cat >killed <<'END'
#!/bin/sh
if [ "${OMPI_COMM_WORLD_RANK:-${PMI_RANK:-0}}" = 1 ]; then
    (
        sleep "$1"
        kill -9 $$
    ) >/dev/null 2>&1 </dev/null &
fi
shift
exec "$@"
END
chmod +x killed

killed_count=0
# expect_end_of_all SECONDS OUTPUT COMMAND...: killed after so many seconds.
expect_end_of_all() {
    seconds=$1
    output=$2
    shift 2
    rm -rf folder
    mkdir folder
    echo old >"folder/$output"
    begin=$(date +%s)
    run timeout 60 mpirun -n 3 ./killed "$seconds" "$mpi" "$@"
    if [ $status -eq 0 ]; then
        echo "it ended before it was killed: $*"
        return 0
    fi
    killed_count=$((killed_count + 1))
    expect_number $(($(date +%s) - begin)) '<=' $((seconds + 10))
    cat "$out" "$err" >all.txt # MPICH prints it on standard output
    grep -q 'signal 9 (Killed)\|Killed (signal 9)' all.txt || fail 'MPI must name the cause'
    [ "$(grep -c '^cvol: .*\(process\|failed\|cannot\)' "$err")" -eq 0 ] || fail "other causes: $(cat "$err")"
    expect_equal "$(ls -A folder)" "$output"
    echo old | cmp -s - "folder/$output" && return 0
    # Killed after the complete file had its name: it must be that of a command that nothing disturbs.
    killed_count=$((killed_count - 1))
    cp "folder/$output" whole
    run timeout 60 mpirun -n 3 "$mpi" "$@"
    expect_same_file whole "folder/$output"
}
# shellcheck disable=SC2086
expect_end_of_all 1 out.cvol compress long.raw folder/out.cvol $raw --psnr 70
expect_end_of_all 1 out.png render a.cvol -o folder/out.png --size 4000 --level 0 --transfer hot
expect_end_of_all 1 out.cvol multiply a.cvol a.cvol -o folder/out.cvol
expect_end_of_all 1 out.cvol transcode a.cvol folder/out.cvol --ratio 50
[ $killed_count -gt 0 ] || fail 'at least one command must be killed before it ends'

# A process whose picture fails before the common work: all get its message, with and without a report.
for who in 0 1; do
    for with in 0 1; do
        run timeout 60 mpirun -n 3 "$CVOL_HELPERS/failing_picture" a.cvol $who $with
        [ $status -eq 0 ] || fail "process $who fails, report $with: status $status: $(cat "$err")"
        expect_equal "$(grep -c "process $who on .*: mode composite needs a transfer function" "$out")" 3
    done
done

# More processes than layers of bricks.
expect_status 0 many 12 stats a.cvol
cp "$out" many.txt
expect_done cvol stats a.cvol
cmp -s "$out" many.txt || fail '12 processes print something else'
