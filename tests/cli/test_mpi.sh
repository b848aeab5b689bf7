#!/bin/sh
# cvol-mpi: pictures and files by several processes equal those of one; failures of one process end all, with one
# sentence.
# shellcheck disable=SC1091,SC2154
. "${0%/*}/lib.sh"
. "${0%/*}/mpi.sh"

make_field in.nrrd head 64x64x60 3 0 0,0,0
expect_done cvol compress in.nrrd a.cvol --psnr 70

# expect_equal_pictures MOST LEAST OPTIONS...: of one process, and of 2, 3 and 5, no pixel differs by more than MOST of
# 255, and they are at least LEAST dB apart. A whole picture divides intervals of rays into fewer parts where
# matter before them hides them; a process does not know what other processes' parts hide, so there its steps are finer,
# and in volumes with sharp edges or noise a few pixels differ by more than 1.
expect_equal_pictures() {
    most=$1
    least=$2
    shift 2
    expect_done cvol render a.cvol -o one.png --size 96 "$@"
    for n in 2 3 5; do
        run timeout 100 mpirun -n $n "$mpi" render a.cvol -o many.png --size 96 "$@"
        [ $status -eq 0 ] || fail "$n processes: $*: $(cat "$err")"
        expect_done cvol compare one.png many.png --json
        if [ "$(value_of exact)" != true ]; then
            expect_number "$(value_of psnr_db)" '>' "$least"
            expect_number "$(value_of max_abs_error)" '<=' "$most"
        fi
    done
}
expect_equal_pictures 1 58 --transfer hot --light flat --azimuth 33 --elevation 12
expect_equal_pictures 1 58 --transfer hot --light flat --azimuth 0 --elevation 0
expect_equal_pictures 3 58 --transfer hot --light flat --azimuth 40 --ray-order object
expect_equal_pictures 12 58 --transfer hot --azimuth 33 --elevation 12
expect_equal_pictures 12 58 --transfer hot --azimuth 210 --elevation -40 --perspective 60
expect_equal_pictures 1 60 --transfer hot --light flat --clip 10:40,, --azimuth 120
expect_equal_pictures 0 90 --mode mip --azimuth 120 --elevation 20
expect_equal_pictures 0 90 --mode min --azimuth 120 --elevation 20
expect_equal_pictures 1 60 --mode xray --azimuth 75 --elevation 20
expect_equal_pictures 1 58 --mode iso --iso 100 --azimuth 75 --elevation 20
run mpirun -n 1 "$mpi" render a.cvol -o many.png --size 96 --transfer hot
expect_done cvol render a.cvol -o one.png --size 96 --transfer hot
expect_done cvol compare one.png many.png --json
if [ "$(value_of exact)" != true ]; then expect_number "$(value_of psnr_db)" '>' 58; fi

# Labels keep their shapes and colours, in films too.
make_field labels.nii.gz labels 70x70x70 2.5 0 0,0,0
expect_done cvol compress labels.nii.gz labels.cvol --labels yes
expect_done cvol render labels.cvol -o one.png --size 96
expect_status 0 timeout 100 mpirun -n 3 "$mpi" render labels.cvol -o many.png --size 96
expect_same_file one.png many.png
expect_done cvol render labels.cvol -o 'one-{n}.png' --turntable 2 --size 96
expect_status 0 timeout 100 mpirun -n 3 "$mpi" render labels.cvol -o 'many-{n}.png' --turntable 2 --size 96
expect_same_file one-1.png many-1.png
expect_same_file one-2.png many-2.png

# One sentence of cvol, whatever number of processes failed; the old picture stays.
# expect_one_sentence STATUS PATTERN COMMAND...
expect_one_sentence() {
    wanted=$1
    pattern=$2
    shift 2
    cp many.png old.png
    run timeout 20 "$@"
    [ $status -eq "$wanted" ] || fail "status $status instead of $wanted: $*"
    [ "$(grep -c '^cvol: ' "$err")" -eq 1 ] || fail "one sentence: $(cat "$err")"
    grep -q "$pattern" "$err" || fail "must say $pattern: $(cat "$err")"
    cmp -s old.png many.png || fail 'the old picture must stay'
}
expect_one_sentence 1 'none.cvol: No such file' mpirun -n 3 "$mpi" render none.cvol -o many.png
expect_one_sentence 2 'does not work with --progressive' mpirun -n 3 "$mpi" render a.cvol -o many.png --progressive
expect_one_sentence 2 'by engine sheet only' mpirun -n 2 "$mpi" render a.cvol -o many.png --engine ray
expect_one_sentence 2 "the commands render, compress, .*, not 'info'" mpirun -n 2 "$mpi" info a.cvol
cat >other <<'END'
#!/bin/sh
if [ "${OMPI_COMM_WORLD_RANK:-${PMI_RANK:-0}}" = 1 ]; then exec "$1" render none.cvol -o many.png; fi
exec "$1" render a.cvol -o many.png --size 64
END
chmod +x other
expect_one_sentence 1 'process 1 on .*none.cvol: No such file' mpirun -n 3 ./other "$mpi"
# ---- compression --------------------------------------------------------------------------------------------------

make_field long.nrrd head 40x44x300 3 0 0,0,0

# expect_equal_files OPTIONS...: of one process, and of 2, 3 and 8.
expect_equal_files() {
    expect_status 0 cvol compress long.nrrd one.cvol --stream "$@"
    for n in 2 3 8; do
        run timeout 100 mpirun -n $n "$mpi" compress long.nrrd many.cvol "$@"
        [ $status -eq 0 ] || fail "$n processes: $*: $(cat "$err")"
        cmp -s one.cvol many.cvol || fail "$n processes: another file: $*"
    done
}
expect_equal_files
expect_equal_files --psnr 50 --fast --no-lap
expect_done cvol verify many.cvol

# ---- boxes: each process reads its own, and a coarse level of the whole ------------------------------------------

make_volume long.raw int16 60x66x300
expect_done cvol compress long.raw a.cvol --dims 60x66x300 --type int16 --psnr 50
expect_equal_pictures 12 58 --level 0 --transfer hot --light flat --azimuth 33 --elevation 12
expect_equal_pictures 40 53 --level 0 --transfer hot --azimuth 210 --elevation -40
expect_equal_pictures 0 90 --level 0 --mode mip --azimuth 120 --elevation 20
# A streamed file has no ranges of its blocks. Here half of the volume is empty, so the ranges of the parts differ, but
# all processes must choose the same number format.
make_volume half.raw int16 60x66x150
head -c 1188000 /dev/zero | cat - half.raw >long.raw
expect_status 0 cvol compress long.raw a.cvol --dims 60x66x300 --type int16 --psnr 50 --stream
expect_equal_pictures 12 58 --level 0 --transfer hot --light flat --azimuth 33 --elevation 12
expect_equal_pictures 1 80 --level 0 --mode mip --azimuth 120 --elevation 20
# ---- films --------------------------------------------------------------------------------------------------------

expect_done cvol render a.cvol -o 'one-{n}.png' --size 96 --level 0 --turntable 2
run timeout 100 mpirun -n 3 "$mpi" render a.cvol -o 'many-{n}.png' --size 96 --level 0 --turntable 2
[ $status -eq 0 ] || fail "a turntable: $(cat "$err")"
expect_done cvol compare one-2.png many-2.png --json
if [ "$(value_of exact)" != true ]; then expect_number "$(value_of psnr_db)" '>' 45; fi
run timeout 100 mpirun -n 3 "$mpi" render a.cvol -o turn.gif --size 96 --turntable 3
[ $status -eq 0 ] || fail "a film: $(cat "$err")"
[ "$(head -c 3 turn.gif)" = GIF ] || fail 'must write a GIF'
expect_one_sentence 1 'nowhere/turn.gif: cannot be written' \
    mpirun -n 3 "$mpi" render a.cvol -o nowhere/turn.gif --turntable 3
run mpirun -n 2 "$mpi" render a.cvol -o many.png --size 96 --level 0 --json
expect_equal "$(json_get file_level <"$out")" 1
# One tile: a message of each process in the only round, and one in the gather.
expect_equal "$(json_get stages.0.messages <"$out")" 3
for stage in read_s total_s draw_s draw_cpu_s wait_s composite_s gather_s warp_s; do
    expect_number "$(json_get stages.0.$stage <"$out")" '>' 0
done
expect_number "$(json_get stages.0.draw_cpu_s <"$out")" '<' "$(json_get stages.0.all_cpu_s <"$out")"
expect_number "$(json_get stages.0.bytes <"$out")" '>' 1000
expect_number "$(json_get stages.0.most_bytes <"$out")" '<=' "$(json_get stages.0.bytes <"$out")"

# One sentence; the old file stays, and nothing else remains.
# expect_no_file STATUS PATTERN COMMAND...
expect_no_file() {
    wanted=$1
    pattern=$2
    shift 2
    rm -rf folder
    mkdir folder
    cp one.cvol folder/out.cvol
    run timeout 30 "$@"
    [ $status -eq "$wanted" ] || fail "status $status instead of $wanted: $*"
    [ "$(grep -c '^cvol: .*\(none\|lossless\|channels\|stream\|No such\)' "$err")" -eq 1 ] ||
        fail "one sentence: $(cat "$err")"
    grep -q "$pattern" "$err" || fail "must say $pattern: $(cat "$err")"
    cmp -s one.cvol folder/out.cvol || fail 'the old file must stay'
    [ "$(ls -A folder)" = out.cvol ] || fail "remains: $(ls -A folder)"
}
expect_no_file 1 'none.nrrd: No such file' mpirun -n 3 "$mpi" compress none.nrrd folder/out.cvol
expect_no_file 2 'cvol-mpi cannot be combined with --lossless: use cvol compress' mpirun -n 2 "$mpi" compress long.nrrd folder/out.cvol --lossless
expect_no_file 1 'process 1 on .*none.nrrd: No such file' \
    mpirun -n 1 "$mpi" compress long.nrrd folder/out.cvol : -n 1 "$mpi" compress none.nrrd folder/out.cvol
expect_no_file 1 'process 2 on .*none.nrrd: No such file' \
    mpirun -n 2 "$mpi" compress long.nrrd folder/out.cvol : -n 1 "$mpi" compress none.nrrd folder/out.cvol

run mpirun -n 2 "$mpi" --help
[ $status -eq 0 ] || fail 'help must work'
