#!/bin/sh
# Runs all measurements of bench/README.md; takes about an hour and a half on two cores.
# usage: bench/run.sh CVOL [--data DIR] [--results DIR]
set -eu

case ${1:-} in
'' | -h | --help)
    sed -n '2,3s/^# //p' "$0"
    [ $# -ge 1 ] && exit 0
    exit 2
    ;;
esac
bench=$(dirname "$0")

echo 'compression: every volume at five targets'
"$bench/codec_table.py" "$@"
echo 'the codec in memory'
"$bench/codec_speed.py" "$@"
echo 'speed of rendering, compared with VTK'
"$bench/render_speed.py" "$@"
echo 'quality of pictures'
"$bench/render_quality.py" "$@" --difference
echo 'X-rays by the Fourier slice theorem, compared with VTK and cast rays'
"$bench/fourier.py" "$@"
echo "the paper's claim: splatting on compressed transforms compared with splatting"
"$bench/paper.py" "$@"
"$bench/paper_data.py" "$@"
echo 'arithmetic on compressed arrays, compared with FFTW, zfp and dense files'
other=$(dirname "$1")-fftw/cvol # the same with -DCVOL_FFT=fftw, if it was built
if [ -x "$(dirname "$other")/bench/algebra_whole" ]; then
    "$bench/algebra.py" "$@" --other "$other"
else
    "$bench/algebra.py" "$@"
fi

results=$bench/results
while [ $# -gt 1 ]; do
    [ "$1" = --results ] && results=$2
    shift
done
echo "Tables: $results/codec_table.md, codec_speed.md, render_speed.md, render_quality.md, fourier.md, paper.md, paper_data.md, algebra.md"
echo "(and .csv); worst views: $results/difference; times against terms and samples: $results/algebra.png;"
echo "the claim, by N, footprint and rho: $results/paper.png"
