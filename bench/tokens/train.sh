#!/bin/sh
# Trains the codec's tables (see src/codec/tables/README.md) and writes them to a folder.
#
# usage: train.sh BUILD OUT [SHARE]
#
# BUILD: a build with -DCVOL_BENCH=ON. SHARE: does one SHARE-th of the work, to test the script.
set -eu

[ $# -ge 2 ] || { sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2; }
build=$(cd "$1" && pwd)
mkdir -p "$2"
out=$(cd "$2" && pwd)
share=${3:-1}
cd "$(dirname "$0")/../.."
tables=$PWD/src/codec/tables
data=${CVOL_DATA:-../shared/data}
[ -d "$data" ] || { echo "train.sh: no folder $data; CVOL_DATA names another" >&2; exit 1; }

# The volumes that README.md names.
sed -n 's/^    \([0-9a-f]\{64\}  .*\)/\1/p' "$tables/README.md" >"$out/volumes.txt"
while read -r sum name; do
    case $name in
    */) found=$(cd "$data/$name" && LC_ALL=C sha256sum ./* | sed 's: \./: :' | sha256sum) ;;
    *) found=$(sha256sum <"$data/$name") ;;
    esac
    [ "${found%% *}" = "$sum" ] || { echo "train.sh: $data/$name is not the volume of $tables/README.md" >&2; exit 1; }
done <"$out/volumes.txt"

# Prints a volume as an argument of the trainers: raw files with size and type from their names.
volume() { # NAME
    case $1 in
    *.raw) echo "$data/$1" | sed 's/\(.*\)_\([0-9x]*\)_\(float32\)\.raw$/&:\2:\3/' ;;
    *) echo "$data/${1%/}" ;;
    esac
}
volumes=$(while read -r sum name; do volume "$name"; done <"$out/volumes.txt")

stride=$((4 * (share > 16 ? 16 : share)))
# shellcheck disable=SC2086
STRIDE=$stride "$build/bench/train_tokens" "$tables/token_codes.inc" "$out/tokens.inc" 3 $volumes
# shellcheck disable=SC2086
STRIDE=$stride "$build/bench/train_residual" "$out/tokens.inc" "$out/token_codes.inc" $volumes
rm "$out/tokens.inc"

"$build/bench/train_masks" "$out/mask_network.inc" $((150000 / share)) "$data/ch2better.nii.gz=0" \
    "$data/inia19.nii.gz=0" "$data/ocean_v.nrrd=1e35" "$data/vhf_head.mha/500" "$data/cthead_8bit.nrrd/40" \
    "$data/seg3d_mr.nii.gz/20"

files=
for ratio in 14 29 58; do
    [ "$share" = 1 ] || [ "$ratio" = 58 ] || continue
    for file in $volumes; do
        raw=
        case $file in
        */ocean_v.nrrd) continue ;;
        *:*) raw="--dims $(echo "$file" | cut -d: -f2) --type ${file##*:}" ;;
        esac
        name=$out/$(basename "${file%%:*}")_$ratio.cvol
        # shellcheck disable=SC2086
        [ -e "$name" ] || "$build/cvol" compress "${file%%:*}" "$name" --smallest --bricks 64 --ratio $ratio --force $raw
        files="$files $name"
    done
done
# shellcheck disable=SC2086
"$build/bench/train_neural" "$tables/token_codes.inc" "$out" $((1450000 / share)) $((250000 / share)) $files

for table in token_codes mask_network neural_magnitudes neural_signs neural_rows; do
    cmp -s "$out/$table.inc" "$tables/$table.inc" && echo "$table: as in $tables" || echo "$table: differs from $tables"
done
