#!/bin/sh
# cvol measure: counts, volumes and means with proven bounds, against the same figures of the original samples.
. "$(dirname "$0")/lib.sh"

dims=40x36x34
make_volume a.raw uint8 $dims
make_nrrd a.nrrd a.raw uint8 40 36 34
expect_done cvol compress a.nrrd lossy.cvol --psnr 40
expect_done cvol compress a.nrrd exact.cvol --lossless

# The lossless file gives the figures of the original samples.
for options in '--above 120' '--above 90.5 --below 130' '--below 100 --box 3:30,0:36,10:11' ''; do
    expect_done cvol measure exact.cvol $options --json
    inside=$(value_of inside)
    mean=$(value_of mean)
    deviation=$(value_of standard_deviation) least=$(value_of least) largest=$(value_of largest)
    expect_equal "$(value_of standard_deviation_error) $(value_of least_error) $(value_of largest_error)" '0.0 0.0 0.0'
    samples=$(value_of samples)
    expect_equal "$(value_of inside_least) $(value_of inside_most) $(value_of mean_error)" "$inside $inside 0.0"
    expect_done cvol measure lossy.cvol $options --json
    expect_equal "$(value_of samples)" "$samples"
    expect_number "$(value_of inside_least)" '<=' "$inside"
    expect_number "$(value_of inside_most)" '>=' "$inside"
    expect_near "$(value_of mean)" "$mean" "$(value_of mean_error)"
    expect_near "$(value_of standard_deviation)" "$deviation" "$(value_of standard_deviation_error)"
    expect_near "$(value_of least)" "$least" "$(value_of least_error)"
    expect_near "$(value_of largest)" "$largest" "$(value_of largest_error)"
done
expect_equal "$inside" $((40 * 36 * 34))

# A box of 4 x 4 samples and its ellipse, which lacks the corners.
expect_done cvol measure exact.cvol --box 3:7,5:9,10:11 --json
expect_equal "$(value_of samples)" 16
expect_done cvol measure exact.cvol --box 3:7,5:9,10:11 --ellipsoid --json
expect_equal "$(value_of samples)" 12

# The figures of the dense volume are those of its lossless file; text names the unit.
for options in '--above 120' '--box 3:30,0:36,10:11' '--box 3:7,5:9,10:11 --ellipsoid' ''; do
    expect_done cvol measure a.nrrd $options --json
    cp "$out" dense.json
    expect_done cvol measure exact.cvol $options --json
    expect_same_file dense.json "$out"
done
run cvol measure a.nrrd --above 120
expect_equal "$status" 0
grep -q '^  volume in range .* (.* to .*)$' "$out" || fail 'must print a range'
expect_done cvol measure lossy.cvol
grep -q 'in range' "$out" && fail 'must not print a range without limits'
grep -q '^  standard deviation .* +- ' "$out" || fail 'must print the deviation'

# Samples without a value do not count, also if the first one has none.
for mark in nan 1e35; do
    {
        printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 20 20 20\nencoding: ascii\n\n'
        awk -v mark=$mark 'BEGIN { for (i = 0; i < 8000; i++) print i % 7 == 0 ? mark : 1000000 + i * 7919 % 100 }'
    } >marked.nrrd
    expect_status 0 cvol measure marked.nrrd --above 1000050 --json
    cp "$out" dense.json
    expect_equal "$(value_of samples)" 6857
    expect_number "$(value_of largest)" '==' 1000099
    expect_near "$(value_of standard_deviation)" 28.87 0.1
    expect_status 0 cvol compress marked.nrrd marked.cvol --lossless
    expect_done cvol measure marked.cvol --above 1000050 --json
    expect_same_file dense.json "$out"
    # An operand is compressed like the file.
    expect_status 0 cvol stats marked.nrrd --json
    expect_near "$(value_of mean)" 1000049.5 2
    expect_status 0 cvol scale marked.nrrd -o scaled.cvol --factor 2
    expect_done cvol info scaled.cvol --json
    expect_equal "$(value_of missing_samples)" 1143
done

# Doubles below the least float: evaluation in single precision rounds them to 0, and the error says so.
{
    printf 'NRRD0004\ntype: double\ndimension: 3\nsizes: 16 16 16\nencoding: ascii\n\n'
    awk 'BEGIN { for (i = 0; i < 4096; i++) printf "%de-50\n", i * 7919 % 1000 }'
} >small.nrrd
expect_done cvol compress small.nrrd small.cvol --lossless
expect_done cvol measure small.cvol --json
mean=$(value_of mean)
error=$(value_of mean_error)
awk -v mean="$mean" -v error="$error" 'BEGIN {
    for (i = 0; i < 4096; i++) sum += i * 7919 % 1000
    off = mean - sum / 4096 * 1e-50
    exit !((off < 0 ? -off : off) <= error)
}' || fail "mean $mean, error $error"

expect_failure 2 '--ellipsoid cannot be combined' cvol measure exact.cvol --ellipsoid --above 3
expect_failure 2 '0 of 1 arguments' cvol measure
expect_failure 2 '--above is 5, more than --below, 3' cvol measure exact.cvol --above 5 --below 3
expect_failure 1 '--box has 0:99 along x' cvol measure exact.cvol --box 0:99,0:2,0:2
expect_failure 1 '--box has 5:5 along y' cvol measure exact.cvol --box 0:9,5:5,0:2
expect_failure 2 '--box is' cvol measure exact.cvol --box 1,2,3
expect_failure 2 '--above is' cvol measure exact.cvol --above x
expect_failure 1 'No such file' cvol measure missing.cvol
