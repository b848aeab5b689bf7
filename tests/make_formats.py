#!/usr/bin/env python3
"""Writes volumes with the formats' own usual tools, and beside each the same samples as a NRRD.

usage: make_formats.py KIND     in an empty folder; status 77 where the tool is missing

Lines on standard output are for tests/read_list.c: how FILE must be read.
"""
import importlib
import os
import sys

import numpy as np

SHAPE = (5, 7, 9)  # z, y, x


def samples(kind, shape=SHAPE, seed=1):
    """Random samples that use all of an integer type."""
    random = np.random.default_rng(seed)
    kind = np.dtype(kind)
    if kind.kind == "f":
        return random.normal(size=shape).astype(kind)
    info = np.iinfo(kind)
    return random.integers(info.min, info.max, size=shape, dtype=kind.newbyteorder("="), endpoint=True)


def reference(name, volume):
    """A NRRD of these samples."""
    volume = np.ascontiguousarray(volume)
    kind = volume.dtype
    name = name.replace("/", "_").replace(":", "_") + ".ref.nrrd"
    word = {"f4": "float", "f8": "double"}.get(kind.str[1:], kind.newbyteorder("=").name)
    with open(name, "wb") as file:
        sizes = " ".join(str(n) for n in volume.shape[::-1])
        file.write(f"NRRD0004\ntype: {word}\ndimension: 3\nsizes: {sizes}\nencoding: raw\nendian: little\n\n".encode())
        file.write(volume.astype(kind.newbyteorder("<")).tobytes())
    return name


def announce(name, volume, spacing=(1, 1, 1), *options):
    words = ",".join(s if isinstance(s, str) else f"{s:.9g}" for s in spacing)
    print(name, reference("_".join((name, *options)), volume), words, *options)


def need(*modules):
    try:
        return [importlib.import_module(module) for module in modules]
    except ImportError as error:
        print(f"skipped: {error}", file=sys.stderr)
        sys.exit(77)


def make_tiff():
    (tifffile,) = need("tifffile")
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        volume = samples(kind)
        tifffile.imwrite(f"{kind}.tif", volume, photometric="minisblack")
        announce(f"{kind}.tif", volume)
    volume = samples("u2")
    tifffile.imwrite("big.tif", volume, photometric="minisblack", bigtiff=True, byteorder=">")
    announce("big.tif", volume)
    for name, options in {
        "deflate": dict(compression="zlib", predictor=True),
        "rows": dict(rowsperstrip=2),
        "tiles": dict(tile=(16, 16)),
    }.items():
        tifffile.imwrite(f"{name}.tif", volume, photometric="minisblack", **options)
        announce(f"{name}.tif", volume)
    # ImageJ: times, slices, channels, y, x
    many = samples("u2", (2, 5, 3, 7, 9))
    tifffile.imwrite("imagej.tif", many, imagej=True, resolution=(1 / 0.25, 1 / 0.25),
                     metadata={"axes": "TZCYX", "spacing": 1.5, "unit": "um"})
    announce("imagej.tif", many[1, :, 2], (0.25, 0.25, 1.5, "um"), "index=1", "channel=2")
    one = samples("u1")
    tifffile.imwrite("stack.tif", one, imagej=True, resolution=(2, 4), metadata={"axes": "ZYX", "spacing": 3, "unit": "um"})
    announce("stack.tif", one, (0.5, 0.25, 3))
    tifffile.imwrite("ome.ome.tif", many, photometric="minisblack",
                     metadata={"axes": "TZCYX", "PhysicalSizeX": 0.1, "PhysicalSizeY": 0.2, "PhysicalSizeZ": 0.4})
    announce("ome.ome.tif", many[0, :, 1], (0.1, 0.2, 0.4, "um"), "index=0", "channel=1")
    colours = samples("u1", (5, 7, 9, 3))
    tifffile.imwrite("rgb.tif", colours, photometric="rgb")
    announce("rgb.tif", colours[..., 1], (1, 1, 1), "channel=1")
    apart = samples("u1", (3, 7, 9))
    tifffile.imwrite("planes.tif", apart, photometric="rgb", planarconfig="separate")
    announce("planes.tif", apart[2:], (1, 1, 1), "channel=2")
    os.mkdir("slices")
    volume = samples("u2", (12, 7, 9))
    for z, slice_ in enumerate(volume):
        tifffile.imwrite(f"slices/s{z + 1}.tif", slice_)
    open("slices/notes.txt", "w").write("no slice\n")
    announce("slices", volume, (2, 3, 4), "spacing=2,3,4")


if __name__ == "__main__":
    globals()["make_" + sys.argv[1]]()
