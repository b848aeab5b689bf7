#!/bin/sh
# Pictures depend on the instruction set within the limits of doc/portability.md: each set that this processor has
# against the base set, by all engines. Prints each picture's largest and mean difference, of 255, and the percentage of
# pixels that differ by more than 2.
. "$(dirname "$0")/lib.sh"

sets=
for set in avx2 avx512; do
    if "$CVOL_HELPERS/with_cpu" $set /bin/true >/dev/null; then
        sets="$sets $set"
    fi
done
if [ -z "$sets" ]; then
    echo 'skipped: this processor has no AVX2'
    exit 0
fi

# compare_sets OPTION... : the picture with these options.
compare_sets() {
    for set in base $sets; do
        CVOL_CPU=$set
        export CVOL_CPU
        expect_done cvol render box.cvol -o $set.png --size 128 "$@"
    done
    unset CVOL_CPU
    for set in $sets; do
        python3 "$CVOL_DOC/../scripts/picture_difference.py" --details base.png $set.png >difference.txt
        read -r largest mean share <difference.txt
        printf '%-6s largest %s, mean %s, above 2: %s %%: %s\n' $set "$largest" "$mean" "$share" "$*"
        case $set in
        avx2) expect_number "$largest" '<=' 2 ;;
        avx512)
            expect_number "$largest" '<=' 8
            expect_number "$mean" '<=' 1
            expect_number "$share" '<=' 0.05
            ;;
        esac
    done
}

expect_done cvol compress "$CVOL_SAMPLES/ch2better.nii.gz" scan.cvol --effort fast
expect_done cvol info scan.cvol --json
expect_equal "$(value_of background)" 0.0 # effort fast finds it, too
expect_done cvol decompress scan.cvol box.nrrd --box 100:180,150:230,100:164
expect_done cvol compress box.nrrd box.cvol
side='--azimuth 35 --elevation 25'
compare_sets --azimuth 0 --elevation 0
compare_sets $side
compare_sets $side --zoom 2
compare_sets $side --light headlight --step 0.5
compare_sets $side --light cinematic
compare_sets $side --ray-order object --clip 30%:,,
compare_sets $side --clip 30%:,,
compare_sets $side --light flat
compare_sets $side --light flat --ray-order object
compare_sets $side --light flat --perspective 40
compare_sets $side --mode mip
compare_sets $side --mode xray
compare_sets $side --mode iso --iso 60
compare_sets $side --engine splat
compare_sets $side --engine transform
compare_sets $side --engine fourier
compare_sets $side --engine ray --step 1
