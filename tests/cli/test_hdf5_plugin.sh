#!/bin/sh
# The HDF5 filter: h5py writes datasets with it. Another process, HDF5's own programs and the command read them.
# Damaged chunks give an error.
. "$(dirname "$0")/lib.sh"
script=$(dirname "$CVOL_DOC")/tests/hdf5_plugin.py
HDF5_PLUGIN_PATH=$CVOL_BUILD/hdf5-plugins
export HDF5_PLUGIN_PATH
if [ ! -e "$HDF5_PLUGIN_PATH/libH5Zcvol.so" ]; then
    echo 'skipped: built without libhdf5'
    exit 0
fi

if ! /usr/bin/python3 -c 'import h5py' 2>"$err"; then
    echo 'skipped: there is no h5py'
    exit 0
fi
expect_done /usr/bin/python3 "$script" write
expect_done /usr/bin/python3 "$script" read
if command -v h5dump >/dev/null; then
    expect_done h5dump -d /lossless/u2 -y -o dumped plugin.h5
    expect_done /usr/bin/python3 -c '
import h5py, numpy as np
text = open("dumped").read().replace(",", " ").split()
assert [int(t) for t in text] == list(h5py.File("plugin.h5")["lossless/u2"][...].flat)'
    expect_done h5repack -f GZIP=1 plugin.h5 plain.h5
    expect_done h5repack -f ratio:UD=444,0,2,1,20 plain.h5 again.h5
    expect_done h5dump -p -H -d /ratio again.h5
    grep -q 'FILTER_ID 444' "$out" || fail 'h5repack must have used the filter'
fi

# The command's own reader uses the filter too.
expect_done "$CVOL" compress plugin.h5:/lossless/i2 by-command.cvol --lossless
expect_done "$CVOL" decompress by-command.cvol by-command.npy
expect_done /usr/bin/python3 -c '
import h5py, numpy as np
assert np.array_equal(np.load("by-command.npy"), h5py.File("plugin.h5")["lossless/i2"][...])'

expect_done /usr/bin/python3 "$script" damage
expect_failure 1 'plugin.h5:/cut: ' "$CVOL" compress plugin.h5:/cut bad.cvol
case $sentence in
*'a chunk'*) ;;
*) fail 'the message must name the damage of the chunk' ;;
esac
HDF5_PLUGIN_PATH=/nowhere
expect_failure 1 'plugin.h5:/psnr: its samples need filter 444 (cvol: *which is not found' "$CVOL" compress plugin.h5:/psnr bad.cvol
