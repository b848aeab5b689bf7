#!/bin/sh
# Runs what the documents show: every ```sh block of README.md and doc/method.md, the C program, and
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

for document in README.md doc/method.md; do
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
