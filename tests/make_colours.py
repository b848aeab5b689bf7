#!/usr/bin/env python3
"""Makes colour files for the tests, and checks the colours of pictures; needs only Python.

make_colours.py make FILE R G B [R G B]   a ball of this colour in the dark; with two, its left and right half.
                                          FILE ends in .tif, .nii, .npy, .vti or .vtk; with "rgba" in its name it has alpha,
                                          with "16" in its name of a TIFF it has 16 bits, with "gz" in that of a
                                          NRRD it is packed; if the name has "blue" or "white", that surrounds the ball,
                                          and if it has "behind", a green block is behind it (larger y).
make_colours.py check FILE.pfm R G B [R G B]
                                          fails unless the centre of the ball (or of each half) has this hue: the
                                          picture's colour is on the line from black to the sample's colour, within
                                          6 %, and has 80 to 108 % of its brightness.
make_colours.py lit FILE.pfm R G B [R G B]
                                          the same for pictures with light: 60 to 125 % of its brightness.
make_colours.py height FILE.pfm LEAST     fails unless this share of the rows, at least, shows something.
"""
import gzip
import struct
import sys

SIDE, RADIUS = 32, 13


def ball(colours, alpha, around, has_block):
    """Yields positions, x fastest, each with its bytes."""
    middle = (SIDE - 1) / 2
    for z in range(SIDE):
        for y in range(SIDE):
            for x in range(SIDE):
                inside = (x - middle) ** 2 + (y - middle) ** 2 + (z - middle) ** 2 < RADIUS**2
                colour = colours[0 if x < middle else len(colours) // 2] if inside else around
                if has_block and not inside and y > middle:
                    inside, colour = True, (0, 250, 0)
                yield (*colour, 255 if inside else 0) if alpha else colour


def tiff(name, places, channels):
    wide = "16" in name
    size = 2 if wide else 1
    pixels = b"".join(struct.pack(f"<{channels}H", *(257 * v for v in p)) if wide else bytes(p) for p in places)
    page_bytes, out, links = SIDE * SIDE * channels * size, bytearray(b"II*\0" + struct.pack("<I", 8)), 4
    for page in range(SIDE):
        tags = [(256, 4, 1, SIDE), (257, 4, 1, SIDE), (259, 3, 1, 1), (262, 3, 1, 2), (277, 3, 1, channels),
                (278, 4, 1, SIDE), (279, 4, 1, page_bytes), (284, 3, 1, 1)]
        if channels == 4:
            tags.append((338, 3, 1, 2))
        begin = len(out)
        struct.pack_into("<I", out, links, begin)
        behind = begin + 2 + 12 * (len(tags) + 2) + 4
        tags += [(258, 3, channels, behind), (273, 4, 1, behind + 2 * channels)]
        out += struct.pack("<H", len(tags))
        for tag in sorted(tags):
            out += struct.pack("<HHII", *tag)
        links = len(out)
        out += struct.pack("<I", 0) + struct.pack(f"<{channels}H", *[8 * size] * channels)
        out += pixels[page * page_bytes : (page + 1) * page_bytes]
    return bytes(out)


def nifti(_, places, channels):
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, SIDE, SIDE, SIDE, 1, 1, 1, 1)
    struct.pack_into("<hh", head, 70, 128 if channels == 3 else 2304, 8 * channels)
    struct.pack_into("<8f", head, 76, *[1.0] * 8)
    struct.pack_into("<f", head, 108, 352.0)
    head[344:348] = b"n+1\0"
    return bytes(head) + b"".join(map(bytes, places))


def nrrd(name, places, channels):
    packed = "gz" in name
    kind, encoding = ("RGB", "RGBA")[channels - 3], "gzip" if packed else "raw"
    head = f"""NRRD0004
type: uint8
dimension: 4
sizes: {channels} {SIDE} {SIDE} {SIDE}
kinds: {kind}-color domain domain domain
encoding: {encoding}

"""
    data = b"".join(map(bytes, places))
    return head.encode() + (gzip.compress(data) if packed else data)


def numpy(_, places, channels):
    text = f"{{'descr': '|u1', 'fortran_order': False, 'shape': ({SIDE}, {SIDE}, {SIDE}, {channels}), }}"
    text += " " * (-(len(text) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\0" + struct.pack("<H", len(text)) + text.encode() + b"".join(map(bytes, places))


def vtk(_, places, channels):
    head = f"""# vtk DataFile Version 3.0
colours
BINARY
DATASET STRUCTURED_POINTS
DIMENSIONS {SIDE} {SIDE} {SIDE}
ORIGIN 0 0 0
SPACING 1 1 1
POINT_DATA {SIDE**3}
COLOR_SCALARS rgb {channels}
"""
    return head.encode() + b"".join(map(bytes, places))


def vti(_, places, channels):
    data = b"".join(map(bytes, places))
    extent = f"0 {SIDE - 1} " * 3
    head = f"""<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="{extent}"><PointData Scalars="rgb">
<DataArray type="UInt8" Name="rgb" NumberOfComponents="{channels}" format="appended" offset="0"/>
</PointData></Piece></ImageData><AppendedData encoding="raw">_"""
    return head.encode() + struct.pack("<Q", len(data)) + data + b"</AppendedData></VTKFile>\n"


def make(name, colours):
    channels = 4 if "rgba" in name else 3
    writers = {"tif": tiff, "nii": nifti, "npy": numpy, "nrrd": nrrd, "vtk": vtk, "vti": vti}
    around = (20, 22, 60) if "blue" in name else (246, 247, 240) if "white" in name else (0, 0, 0)
    data = writers[name.rsplit(".", 1)[1]](name, ball(colours, channels == 4, around, "behind" in name), channels)
    with open(name, "wb") as file:
        file.write(data)


def middle_colour(values, width, left, right):
    """The mean of a small window; PFM stores the bottom row first."""
    rows = range(width * 2 // 5, width * 3 // 5)
    places = [3 * (y * width + x) for y in rows for x in range(left, right)]
    return [255 * sum(values[p + k] for p in places) / len(places) for k in range(3)]


def read_pfm(name):
    with open(name, "rb") as file:
        kind, size, scale = file.readline().split(), file.readline().split(), float(file.readline())
        assert kind == [b"PF"] and scale < 0, "not a PFM of colours in little endian"
        width, height = map(int, size)
        return width, height, struct.unpack(f"<{3 * width * height}f", file.read())


def check_height(name, least):
    width, height, values = read_pfm(name)
    rows = sum(max(values[3 * width * y : 3 * width * (y + 1)]) > 0.05 for y in range(height))
    if rows < least * height:
        print(f"{name}: {rows} of {height} rows show something")
    return rows < least * height


def check(name, colours, least=0.8, most=1.08):
    width, _, values = read_pfm(name)
    windows = [(width * 9 // 20, width * 11 // 20)]
    if len(colours) == 2:
        windows = [(width * 8 // 20, width * 9 // 20), (width * 11 // 20, width * 12 // 20)]
    for expected, (left, right) in zip(colours, windows):
        got = middle_colour(values, width, left, right)
        share = sum(g * e for g, e in zip(got, expected)) / sum(e * e for e in expected)
        off = max(abs(g - share * e) for g, e in zip(got, expected)) / max(expected)
        if not (least <= share <= most and off <= 0.06):
            print(f"{name}: {[round(g) for g in got]} is seen where the samples are {expected}")
            return 1
    return 0


def main():
    what, name, *numbers = sys.argv[1:]
    if what == "height":
        return check_height(name, float(numbers[0]))
    values = [int(n) for n in numbers]
    colours = [tuple(values[i : i + 3]) for i in range(0, len(values), 3)]
    if what == "lit":
        return check(name, colours, 0.6, 1.25)
    return make(name, colours) if what == "make" else check(name, colours)


sys.exit(main())
