#!/bin/sh
# Widths of certified pictures (cvol render --certify) of real volumes: a Markdown table. Each volume is compressed with
# a largest error of 0.5 % of its range (integers: at least 1), then drawn at 256 x 256. Takes four minutes.
# usage: bench/certify.sh CVOL [DATA]
set -eu

case ${1:-} in
'' | -h | --help)
    sed -n '2,4s/^# //p' "$0"
    [ $# -ge 1 ] && exit 0
    exit 2
    ;;
esac
cvol=$1
data=${2:-$(dirname "$0")/../../shared/data}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# field NAME: the first number of this name in the last JSON output
field() {
    sed -n "s/.*\"$1\": *\([-0-9.e+]*\).*/\1/p" "$work/json" | head -n 1
}

# error_of PATH: 0.5 % of the range of the volume's samples
error_of() {
    "$cvol" compress "$1" "$work/v.cvol" --force --json >"$work/json"
    "$cvol" info "$work/v.cvol" --json >"$work/json"
    integer=$(grep -c '"type": "u\?int' "$work/json" || :)
    awk "BEGIN { error = 0.005 * ($(field value_max) - $(field value_min)); print $integer && error < 1 ? 1 : error }"
}

# row VOLUME LOOK OPTIONS...: one line of the table
row() {
    volume=$1 look=$2
    shift 2
    "$cvol" render "$work/v.cvol" -o "$work/p.png" --size 256 --certify --json "$@" >"$work/json"
    printf '| %s | %s | %.3g | %s | %s | %s | %.0f %% | %.1f s | %.2f s |\n' "$volume" "$look" \
        "$(field max_error)" "$(field median_width)" "$(field width_90)" "$(field worst_width)" \
        "$(awk "BEGIN { print 100 * $(field share_above_8) }")" "$(awk "BEGIN { print $(field ms) / 1000 }")" \
        "$(awk "BEGIN { print $(field render_ms) / 1000 }")"
}

echo '| volume | look | error | median | 90 % | worst | above 8 | bounds | picture |'
echo '|---|---|---:|---:|---:|---:|---:|---:|---:|'
for volume in cthead_8bit.nrrd ch2better.nii.gz seg3d_mr.nii.gz tooth.nrrd vhf_head.mha inia19.nii.gz embryo.nrrd \
    fibsem_250.nrrd betagal_em.nrrd; do
    [ -e "$data/$volume" ] || continue
    "$cvol" compress "$data/$volume" "$work/v.cvol" --max-error "$(error_of "$data/$volume")" --force --json \
        >"$work/json"
    row "${volume%%.*}" unlit --transfer auto
    row "${volume%%.*}" lit --shade
    row "${volume%%.*}" mip --mode mip
done
