#!/bin/sh
# Runs what the documents show: every ```sh block of README.md, doc/method.md and doc/hdf5.md, the C program, and
# the demo, in an empty folder that has the samples. The demo and the C program see all of the scan; for
# the commands it is as large, but empty above its lowest 80 slices, which takes less time.
# usage: tests/check_docs.sh SOURCE_FOLDER CVOL README_EXAMPLE
set -eu
source=$(cd "$1" && pwd)
PATH=$(cd "$(dirname "$2")" && pwd):$PATH
export PATH
example=$3

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir samples
cp "$source"/samples/* samples
slice=$((301 * 370))
{
    gzip -dc "$source/samples/ch2better.nii.gz" | head -c $((352 + slice * 80))
    head -c $((slice * 236)) /dev/zero
} | gzip -1 >samples/ch2better.nii.gz

documents='README.md doc/method.md'
HDF5_PLUGIN_PATH=$(dirname "$(command -v cvol)")/hdf5-plugins
export HDF5_PLUGIN_PATH
if [ -d "$HDF5_PLUGIN_PATH" ] && command -v h5repack >output && /usr/bin/python3 -c 'import h5py' 2>output; then
    PATH=$(dirname "$(command -v cvol)"):/usr/bin:$PATH # where h5py is
    documents="$documents doc/hdf5.md"
else
    echo 'doc/hdf5.md: skipped: there is no filter, no h5repack or no h5py'
fi

for document in $documents; do
    awk '/^```sh$/ { on = 1; next } /^```$/ { on = 0 } on' "$source/$document" >commands
    [ -s commands ] || { echo "$document shows no commands" >&2; exit 1; }
    while IFS= read -r command; do
        echo "+ $command"
        sh -c "$command" >output 2>&1 </dev/null || {
            echo "$document: '$command' failed:" >&2
            cat output >&2
            exit 1
        }
    done <commands
done

rm -f brain.png
cp "$source/samples/ch2better.nii.gz" samples
echo '+ the C program'
"$example"
[ -s brain.png ] || { echo 'the C program of README.md left no picture' >&2; exit 1; }

echo '+ the demo'
sh "$source/scripts/demo.sh" cvol
[ -s demo/brain.png ] || { echo 'the demo left no picture' >&2; exit 1; }
