#!/bin/sh
# Compresses the sample scan to a thirtieth, renders it, and prints the picture's path.
# usage: scripts/demo.sh CVOL
set -eu
cvol=$1
mkdir -p demo
echo 'Compress a brain scan of 35 million samples to a thirtieth of its size:'
"$cvol" compress samples/ch2better.nii.gz demo/brain.cvol --ratio 30
echo 'Render the compressed file:'
"$cvol" render demo/brain.cvol -o demo/brain.png
echo "The picture: $(pwd)/demo/brain.png"
echo "To rotate it in a browser: $cvol view demo/brain.cvol"
