"""Two NumPy volumes: compress both, slice, compare, multiply by a mask, render, save.

usage: change.py [FOLDER]      writes before.png, change.png and change.cvol there
"""

import sys
from pathlib import Path

import cvol
import numpy as np

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

# Two scans (z, y, x) of a phantom, the second one with a lesion; spacing 2 x 1 x 1 mm.
z, y, x = np.mgrid[-1:1:48j, -1:1:96j, -1:1:96j]
head = np.clip(1.5 - np.hypot(np.hypot(x, y), z) * 1.8, 0, 1) * (1 + 0.2 * np.sin(9 * x) * np.cos(7 * y))
lesion = 0.4 * np.exp(-((x - 0.3) ** 2 + y**2 + (z - 0.1) ** 2) / 0.01)
noise = np.random.default_rng(1).normal(0, 3, (2, *head.shape))
first = np.clip(200 * head + noise[0], 0, 255).astype(np.uint8)
second = np.clip(200 * (head + lesion) + noise[1], 0, 255).astype(np.uint8)

before = cvol.compress(first, ratio=15, spacing=(2, 1, 1), lap=False)
after = cvol.compress(second, ratio=15, spacing=(2, 1, 1), lap=False)
print(before, f"PSNR {before.info.psnr_db:.1f} dB")

# One slice: decodes only its blocks.
plane = after[26]
print("a slice:", plane.shape, plane.dtype, "off by at most", np.abs(plane.astype(int) - second[26]).max())

# Computed on coefficients, with a certified bound of the error.
mask = cvol.compress((np.hypot(x, y) < 0.8).astype(np.float32), ratio=15, spacing=(2, 1, 1), lap=False)
change = (after - before).convolve("gaussian:1") * mask
exact = second.astype(float) - first
print(f"mean change {change.stats().mean:.3f} (of the samples {exact.mean():.3f}),",
      f"RMS error at most {change.rms_error_bound():.2f}")  # fmt: skip

cvol.save_png(folder / "before.png", before.render(azimuth=30, elevation=20, shade=True, size=256))
warm = [[10, 0.3, 0, 0, 0], [40, 1, 0.4, 0, 0.1], [80, 1, 1, 0.6, 0.5]]  # value, red, green, blue, opacity
cvol.save_png(folder / "change.png", change.render(azimuth=30, elevation=20, transfer=warm, size=256))
print("change.cvol:", change.save(folder / "change.cvol"), "bytes of", change.nbytes)
