#!/usr/bin/env python3
"""Makes stand-ins for the files of readers of the documents: head.nrrd, a CT of a ball with skin and a skull (air
-1000, water 0), and tooth.nrrd, a bright block with a brighter coat. Needs only Python."""
from array import array


def write(name, type_name, values, side, spacing):
    header = (f"NRRD0004\ntype: {type_name}\ndimension: 3\nsizes: {side} {side} {side}\n"
              f"spacings: {spacing} {spacing} {spacing}\nendian: little\nencoding: raw\n\n")
    with open(name, "wb") as file:
        file.write(header.encode() + values.tobytes())


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


main()
