#!/usr/bin/env python3
"""Makes stand-ins for the files of readers of the documents: head.nrrd, a CT of a ball with skin and a skull (air
-1000, water 0); tooth.nrrd, a bright block with a brighter coat; and, in the space of the sample scan, pet.nii.gz,
two hot spots, and regions.nii.gz, labels 1 and 2, with their names in regions.txt. Needs only Python."""
import gzip
import struct
from array import array


def write(name, type_name, values, side, spacing):
    header = (f"NRRD0004\ntype: {type_name}\ndimension: 3\nsizes: {side} {side} {side}\n"
              f"spacings: {spacing} {spacing} {spacing}\nendian: little\nencoding: raw\n\n")
    with open(name, "wb") as file:
        file.write(header.encode() + values.tobytes())


def write_nifti(name, code, values, side, spacing, corner):
    """code: 2 uint8, 16 float32. The axes are those of the world, in mm."""
    header = bytearray(348)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, side, side, side, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, code, 8 * values.itemsize)
    struct.pack_into("<4f", header, 76, 1, spacing, spacing, spacing)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    header[123] = 2
    struct.pack_into("<2h", header, 252, 0, 1)
    for axis in range(3):
        row = [0.0] * 4
        row[axis], row[3] = spacing, corner[axis]
        struct.pack_into("<4f", header, 280 + 16 * axis, *row)
    header[344:348] = b"n+1\0"
    with gzip.open(name, "wb", compresslevel=1) as file:
        file.write(bytes(header) + bytes(4) + values.tobytes())


def distance(place, middle):
    return sum((a - b) ** 2 for a, b in zip(place, middle)) ** 0.5


def head(r):
    """The sample's value by its distance from the centre, in samples."""
    return 40 if r < 19 else 1600 if r < 23 else 60 if r < 27 else -1000


def main():
    side = 64
    places = range(side)
    middle = (side - 1) / 2
    write("head.nrrd", "int16", array("h", (
        head(((x - middle) ** 2 + (y - middle) ** 2 + (z - middle) ** 2) ** 0.5)
        for z in places for y in places for x in places)), side, 3)
    write("tooth.nrrd", "uint16", array("H", (
        max(0, 900 - 25 * int(abs(max(abs(x - middle), abs(y - middle), abs(z - middle)) - 20)))
        for z in places for y in places for x in places)), side, 0.5)
    side, spacing, corner = 40, 4.5, (-90, -120, -70)
    spots = ((-42, 20, 20, 9), (30, -40, 30, 14))
    world = [tuple(c + spacing * i for c, i in zip(corner, (x, y, z)))
             for z in range(side) for y in range(side) for x in range(side)]
    write_nifti("pet.nii.gz", 16, array("f", (
        sum(10 * 2 ** -((distance(p, s[:3]) / s[3]) ** 2) for s in spots) for p in world)), side, spacing, corner)
    write_nifti("regions.nii.gz", 2, array("B", (
        next((i + 1 for i, s in enumerate(spots) if distance(p, s[:3]) < 1.3 * s[3]), 0) for p in world)),
        side, spacing, corner)
    with open("regions.txt", "w") as file:
        file.write('1 255 80 60 1 1 1 "Left spot"\n2 60 160 255 1 1 1 "Right spot"\n')


main()
