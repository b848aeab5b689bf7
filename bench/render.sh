#!/bin/sh
# Compares all of rendering with VTK's CPU ray caster, on seven volumes; takes about an hour on two cores.
# usage: bench/render.sh CVOL [--data DIR] [--results DIR]
set -eu

case ${1:-} in
'' | -h | --help)
    sed -n '2,3s/^# //p' "$0"
    [ $# -ge 1 ] && exit 0
    exit 2
    ;;
esac
bench=$(dirname "$0")
results=$bench/results
cvol=$1
shift
data=
while [ $# -gt 1 ]; do
    case $1 in
    --results) results=$2 ;;
    --data) data=$2 ;;
    esac
    shift 2
done
volumes=brain,vhf_head,cthead_8bit,embryo,fibsem_250,mouse_brain,inia19
set -- --volumes "$volumes" ${data:+--data "$data"}

echo '512 x 512, composite unshaded and shaded, xray, mip'
"$bench/render_speed.py" "$cvol" "$@" --looks semi,opaque,semi-lit,opaque-lit,xray,mip --rounds 1 \
    --results "$results/render/512"
echo '1024 x 1024'
"$bench/render_speed.py" "$cvol" "$@" --looks semi,opaque,semi-lit,xray,mip --rounds 1 --threads 1 \
    --views 6 --repeat 2 --size 1024 --results "$results/render/1024"
echo 'time against quality, with all settings of both'
"$bench/render_curve.py" "$cvol" "$@" --results "$results/render"
echo "Tables: $results/render; curves: $results/render/render_curve.png"
