#!/usr/bin/env python3
"""Prints the largest difference of two PNG files of 8 bits, of 255, or 'sizes differ'. Needs Python alone.

usage: picture_difference.py [--details] A.png B.png

--details: also the mean difference, and the percentage of pixels with a difference above 2.
"""
import struct
import sys
import zlib


def paeth(left, above, corner):
    estimate = left + above - corner
    distances = [(abs(estimate - left), 0, left), (abs(estimate - above), 1, above), (abs(estimate - corner), 2, corner)]
    return min(distances)[2]


def read(path):
    """Returns width, height, channels and the rows' bytes. (PNG, section 9: filters.)"""
    data = open(path, "rb").read()
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        content = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", content)
            if bits != 8 or interlaced or colour not in (0, 2, 6):
                sys.exit(f"{path}: only 8 bits, grey or RGB, without a palette and interlacing")
        elif kind == b"IDAT":
            packed += content
        at += size + 12
    channels = {0: 1, 2: 3, 6: 4}[colour]
    raw, stride, above, rows = zlib.decompress(packed), width * channels, bytes(width * channels), []
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride if kind else 0):
            left = row[i - channels] if i >= channels else 0
            corner = above[i - channels] if i >= channels else 0
            add = {1: left, 2: above[i], 3: (left + above[i]) // 2}.get(kind)
            row[i] = (row[i] + (paeth(left, above[i], corner) if add is None else add)) & 255
        rows.append(bytes(row))
        above = row
    return width, height, channels, b"".join(rows)


def main():
    details = sys.argv[1] == "--details"
    first, second = (read(path) for path in sys.argv[1 + details:])
    if first[:3] != second[:3]:
        sys.exit("sizes differ")
    differences, channels = [abs(a - b) for a, b in zip(first[3], second[3])], first[2]
    largest = max(differences, default=0)
    if not details:
        print(largest)
        return
    above = sum(max(differences[i:i + channels]) > 2 for i in range(0, len(differences), channels))
    print(largest, f"{sum(differences) / len(differences):.3f}", f"{100 * channels * above / len(differences):.3f}")


if __name__ == "__main__":
    main()
