"""Slices from a file on disk: the cost of reading a slice with bricks of 64 samples a side and with smaller ones.

usage: planes.py SCAN [FOLDER]      SCAN: a .cvol file, or a dense volume; writes planes.cvol and planes.png
"""

import math
import sys
from pathlib import Path

import cvol
import numpy as np

if len(sys.argv) < 2:
    sys.exit(__doc__.split("\n\n")[1].strip())
scan = sys.argv[1]
folder = Path(sys.argv[2] if len(sys.argv) > 2 else ".")
REACH = 2  # a sample so close to a face of a brick may need the next brick


def bricks_of(v, axis, k):
    """The number of bricks that slice k across an axis needs, and of all bricks."""
    sides = v.info.bricks
    counts = [-(-n // side) for n, side in zip(v.shape, sides)]
    needed = min(k + REACH, v.shape[axis] - 1) // sides[axis] - max(k - REACH, 0) // sides[axis] + 1
    return needed * math.prod(counts) // counts[axis], math.prod(counts)


# z, y, x. Files of 2 MB and more have such bricks, or flatter ones, by default; smaller files, and files for a PSNR or an
# error, have 64 samples along each axis. At the same ratio, small bricks cost some quality.
shape = (16, 32, 32)
if scan.endswith(".cvol"):
    with cvol.open(scan) as v:
        samples, geometry = v.to_numpy(), v.geometry
else:
    samples, geometry = cvol.read(scan)
usual = cvol.compress(samples, geometry=geometry, bricks=64)
small = cvol.compress(samples, geometry=geometry)
if small.info.bricks == usual.info.bricks:
    small = cvol.compress(samples, geometry=geometry, bricks=shape)
usual.save(folder / "usual.cvol")
small.save(folder / "planes.cvol")
files = [folder / "usual.cvol", folder / "planes.cvol"]
print(f"{small.info.psnr_db:.2f} dB in {files[1].stat().st_size} bytes, in bricks of {usual.info.bricks}",
      f"{usual.info.psnr_db:.2f} dB in {files[0].stat().st_size}")  # fmt: skip

shown = []
for axis, name in enumerate("zyx"):
    shares = []
    for file in files:
        with cvol.open(file) as v:  # reads a header; the slice below its bricks, and nothing else
            k = min(v.shape[axis] // 32 * 16 + 8, v.shape[axis] - 1)  # not near a face of a brick
            plane = v[tuple(k if a == axis else slice(None) for a in range(3))]
            shares.append(bricks_of(v, axis, k))
    (needs, of), (usually, all_) = shares[1], shares[0]
    print(f"{name} = {k}: decodes {needs} of {of} bricks (1/{of / needs:.0f}); in those of 64 {usually} of {all_}")
    shown.append(plane)

low, high = (f(p.min() if f is min else p.max() for p in shown) for f in (min, max))
picture = np.zeros((max(p.shape[0] for p in shown), sum(p.shape[1] for p in shown)), np.uint8)
at = 0
for p in shown:
    picture[: p.shape[0], at : at + p.shape[1]] = 255 * (p.astype(float) - low) / max(high - low, 1e-30)
    at += p.shape[1]
cvol.save_png(folder / "planes.png", np.repeat(picture[..., None], 3, 2))
files[0].unlink()
