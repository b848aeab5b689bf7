#!/usr/bin/python3
"""Writes damaged .cvol files, most of them with correct checksums, for tests/web/test_damaged.mjs.

usage: damaged_files.py FOLDER SEED COUNT FILE.cvol...    COUNT damaged files of each file, and the file itself
"""
import os
import random
import sys

sys.dont_write_bytecode = True
here = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(here, "..", "..", "doc"), os.path.join(here, "..", "..", "fuzz")]
import damage  # noqa: E402  (both are found by the path above)
import decoder_ref as ref  # noqa: E402


def main():
    folder, seed, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    os.makedirs(folder, exist_ok=True)
    for path in sys.argv[4:]:
        with open(path, "rb") as file:
            data = file.read()
        name = os.path.basename(path).removesuffix(".cvol")
        r = random.Random(f"{seed} {name}")
        for i in range(count + 1):
            with open(os.path.join(folder, f"{name}-{i}.cvol"), "wb") as file:
                file.write(damage.damage(ref, r, data) if i else data)


main()
