#!/usr/bin/env python3
"""Writes the codec's computed tables, and checks all tables.

usage: tables.py [--check] [FOLDER]

FOLDER is src/codec/tables. --check compares the computed tables with the files and writes nothing. Both compare the
CRC-32C of each table's numbers with that in FOLDER/README.md. Exit code 1: a table differs.
"""
import math
import os
import re
import struct
import sys


def logistic(x):
    """2^16 / (1 + exp(x)), rounded. Fails if the value is so close to .5 that another exp() may round
    differently."""
    value = 2 ** 16 / (1 + math.exp(x))
    if abs(value - math.floor(value) - 0.5) < 1e-6:
        sys.exit(f"tables.py: {value} is too near to the middle between two integers")
    return math.floor(value + 0.5)


FORMULAS = {
    "token_probabilities.inc": (
        "P[j] = 2^16 / (1 + exp((127.5 - j) / 12.75)), rounded; written by scripts/tables.py.",
        [logistic((127.5 - j) / 12.75) for j in range(256)]),
    "mask_levels.inc": (
        "2^16 / (1 + exp((i - 64) / 8)), rounded, at least 71 and at most 65465; written by scripts/tables.py.",
        [max(71, min(65465, logistic((i - 64) / 8))) for i in range(129)]),
}
TRAINED = {  # pairs of a number's type and its count
    "token_codes.inc": [("B", 5130 * 15)],
    "mask_network.inc": [("h", 52 * 16), ("i", 1)],
    "neural_magnitudes.inc": [("h", 96 * 80), ("i", 96), ("h", 48 * 96), ("i", 48), ("h", 16 * 48), ("i", 16)],
    "neural_signs.inc": [("h", 96 * 80), ("i", 96), ("h", 48 * 96), ("i", 48), ("h", 16 * 48), ("i", 16)],
    "neural_rows.inc": [("B", 397 * 15)],
}


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def text_of(comment, numbers):
    lines = [f"/* {comment} */"]
    for first in range(0, len(numbers), 12):
        lines.append(", ".join(str(n) for n in numbers[first:first + 12]) + ",")
    return "\n".join(lines) + "\n"


def numbers_in(text):
    return [int(n) for n in re.findall(r"-?\d+", re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL))]


def packed(numbers, layout):
    """Returns the numbers as in memory, little-endian."""
    out, at = b"", 0
    for kind, count in layout:
        out += struct.pack(f"<{count}{kind}", *numbers[at:at + count])
        at += count
    if at != len(numbers):
        raise struct.error(f"{len(numbers)} numbers, not {at}")
    return out


def read(path):
    try:
        with open(path, encoding="ascii") as file:
            return file.read()
    except OSError as error:
        sys.exit(f"tables.py: {error}")


def main():
    arguments = sys.argv[1:]
    check = "--check" in arguments
    arguments = [a for a in arguments if a != "--check"]
    here = os.path.dirname(os.path.abspath(__file__))
    folder = arguments[0] if arguments else os.path.join(here, "..", "src", "codec", "tables")
    stated = dict(re.findall(r"`(\w+\.inc)`.*?`([0-9a-f]{8})`", read(os.path.join(folder, "README.md"))))
    failed = False
    for name, (comment, numbers) in FORMULAS.items():
        path, text = os.path.join(folder, name), text_of(comment, numbers)
        if not check:
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
        elif read(path) != text:
            print(f"{name} is not what its formula gives")
            failed = True
    layouts = {name: [("H", len(numbers))] for name, (_, numbers) in FORMULAS.items()}
    for name, layout in {**TRAINED, **layouts}.items():
        try:
            crc = f"{crc32c(packed(numbers_in(read(os.path.join(folder, name))), layout)):08x}"
        except struct.error as error:
            crc = str(error)
        differs = crc != stated.get(name)
        failed |= differs
        print(f"{name}: {crc}" + (f"; README.md says {stated.get(name)}" if differs else ""))
    sys.exit(failed)


if __name__ == "__main__":
    main()
