"""Pictures as lists of numbers, and differences of two pictures; uses only Python's standard library."""
import array
import math
import struct
import sys
import zlib


def parse_pfm(data):
    """Returns width, height, channels and the floats of a PFM."""
    kind, size, scale, data = data.split(b"\n", 3)
    width, height = map(int, size.split())
    floats = array.array("f")
    floats.frombytes(data)
    if (float(scale) < 0) != (sys.byteorder == "little"):
        floats.byteswap()
    channels = {b"PF": 3, b"Pf": 1}[kind]
    if len(floats) != width * height * channels:
        raise ValueError("%d floats of %d x %d" % (len(floats), width, height))
    return width, height, channels, floats


def _paeth(a, b, c):
    p = a + b - c
    pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
    return a if pa <= pb and pa <= pc else b if pb <= pc else c


def _unfilter(kind, line, above, step):
    for i in range(len(line)):
        left = line[i - step] if i >= step else 0
        corner = above[i - step] if i >= step else 0
        predicted = (0, left, above[i], (left + above[i]) // 2, _paeth(left, above[i], corner))[kind]
        line[i] = (line[i] + predicted) & 255


def parse_png(data):
    """Returns the same for a PNG, 0 to 1; colours are multiplied by opacity if the PNG has it."""
    at, packed = 8, b""
    while at < len(data):
        size, name = struct.unpack(">I4s", data[at:at + 8])
        if name == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
        if name == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += size + 12
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[colour]
    step = channels * bits // 8
    rows, above, samples = zlib.decompress(packed), bytes(width * step), []
    for y in range(height):
        line = bytearray(rows[y * (width * step + 1) + 1:(y + 1) * (width * step + 1)])
        _unfilter(rows[y * (width * step + 1)], line, above, step)
        above = line
        samples += line if bits == 8 else struct.unpack(">%dH" % (len(line) // 2), line)
    most = 2 ** bits - 1
    floats = array.array("f", [v / most for v in samples])
    if channels in (2, 4):
        for i in range(0, len(floats), channels):
            for k in range(channels - 1):
                floats[i + k] *= floats[i + channels - 1]
    return width, height, channels, floats


def parse(data):
    """Parses the bytes of a PFM or PNG file."""
    return parse_pfm(data) if data.startswith(b"P") else parse_png(data)


def psnr(one, other, spared=0.0):
    """Returns the PSNR of two pictures of one shape, with white = 1, without the share `spared` of pixels that
    differ most. -inf if the shapes differ or a number is not finite."""
    if one[:3] != other[:3]:
        return -math.inf
    channels = one[2]
    squares = [(a - b) * (a - b) for a, b in zip(one[3], other[3])]
    total = sum(squares)
    if not total < math.inf:
        return -math.inf
    if spared:
        pixels = sorted(sum(squares[i:i + channels]) for i in range(0, len(squares), channels))
        total = sum(pixels[:len(pixels) - math.floor(spared * len(pixels))])
    return -10 * math.log10(total / len(one[3])) if total else math.inf


def blurred(picture):
    """Returns means of 3 x 3 pixels, which reduce differences by shifts of half a pixel."""
    width, height, channels, floats = picture
    line = width * channels
    across = array.array("f", floats)
    for y in range(height):
        for i in range(y * line + channels, (y + 1) * line - channels):
            across[i] = (floats[i - channels] + floats[i] + floats[i + channels]) / 3
    out = array.array("f", across)
    for i in range(line, (height - 1) * line):
        out[i] = (across[i - line] + across[i] + across[i + line]) / 3
    return width, height, channels, out


def share_apart(one, other, far):
    """Returns the share of pixels of two maps that are finite in only one of them, or differ by more than `far`."""
    if one[:3] != other[:3]:
        return 1.0
    apart = sum((math.isfinite(a) != math.isfinite(b)) or (math.isfinite(a) and not abs(a - b) <= far)
                for a, b in zip(one[3], other[3]))
    return apart / len(one[3])


def spread(picture):
    """Returns the largest minus the smallest number; 0 for an empty picture."""
    return max(picture[3]) - min(picture[3])
