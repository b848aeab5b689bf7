#!/usr/bin/python3
"""Compares ways to store the components of colours: as they are, in fixed opponent colours, and in the axes of their
covariance (KLT). Every way gets the same mean squared error over all components, that of the components as they are at
1/30, 1/60 and 1/15 of the raw samples; the table has bytes.

    bench/colours.py [--cvol build/cvol] [FILE.tif ...]

FILE: RGB stacks of 8 bits. Without one: the brain of the project, a cube of 128 samples, stained in three ways, with noise
in each component.
"""
import argparse
import json
import os
import subprocess
import tempfile

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# Rows of unit length: brightness, red against blue, green against both.
OPPONENT = np.array([[1, 1, 1], [1, 0, -1], [-1, 2, -1]]) / np.sqrt([[3], [2], [6]])
STAINS = {
    "tissue": [(0, 0, 0), (90, 30, 25), (170, 90, 70), (205, 150, 120), (235, 215, 190), (255, 245, 225)],
    "two dyes": [(0, 0, 0), (200, 40, 60), (120, 30, 140), (60, 50, 190), (90, 120, 220), (180, 210, 240)],
    "spectrum": [(0, 0, 0), (0, 0, 200), (0, 200, 200), (0, 200, 0), (220, 220, 0), (255, 0, 0)],
}


def stained(sigma=4):
    """Yields names and stacks [z, y, x, component] of the brain."""
    with tempfile.TemporaryDirectory() as folder:
        exact, path = os.path.join(folder, "brain.cvol"), os.path.join(folder, "brain.npy")
        for words in (["compress", f"{ROOT}/samples/ch2better.nii.gz", exact, "--lossless"],
                      ["decompress", exact, path]):
            subprocess.run([ARGS.cvol, *words], check=True, capture_output=True)
        brain = np.load(path).astype(np.float32)[94:222, 120:248, 86:214]
    brain = np.clip(brain / np.percentile(brain, 99.8), 0, 1)
    rng = np.random.default_rng(0)
    for name, colours in STAINS.items():
        at = np.linspace(0, 1, len(colours))
        rgb = np.stack([np.interp(brain, at, [c[k] for c in colours]) for k in range(3)], -1)
        yield name, np.clip(rgb + rng.normal(0, sigma, rgb.shape), 0, 255).astype(np.uint8).astype(np.float32)


def compress(samples, folder, *target):
    """Returns bytes and mean squared error."""
    raw, out, back = (os.path.join(folder, name) for name in ("in.npy", "out.cvol", "back.npy"))
    np.save(raw, samples.astype(np.float32))
    text = subprocess.run([ARGS.cvol, "compress", raw, out, "--json", "--force", *target], check=True,
                          capture_output=True, text=True).stdout
    subprocess.run([ARGS.cvol, "decompress", out, back], check=True, capture_output=True)
    error = float(np.mean((np.load(back) - samples) ** 2, dtype=np.float64))
    return json.loads(text)["file_bytes"], error


def reach(samples, error, folder):
    """Bytes of a component at a mean squared error: the PSNR target is met from above, so the rest is interpolated."""
    span = float(samples.max() - samples.min())
    psnr = 20 * np.log10(span) - 10 * np.log10(error)
    points = [compress(samples, folder, "--psnr", f"{psnr + off:.4f}") for off in (-0.4, 0.4)]
    logs = [np.log10(found) for _, found in points]
    return float(np.interp(-np.log10(error), [-logs[0], -logs[1]], [points[0][0], points[1][0]]))


def measure(name, rgb):
    _, axes = np.linalg.eigh(np.cov(rgb.reshape(-1, 3).T))
    ways = {"opponent": OPPONENT, "KLT": axes.T}
    for ratio in (15, 30, 60):
        with tempfile.TemporaryDirectory() as folder:
            own = [compress(rgb[..., k], folder, "--ratio", str(4 * ratio)) for k in range(3)]
            error = np.mean([found for _, found in own])
            # All components get this error: that is the best division for independent ones.
            plain = sum(reach(rgb[..., k], error, folder) for k in range(3))
            row = [f"{sum(reach(c, error, folder) for c in np.moveaxis(rgb @ way.T, -1, 0)) / plain:.2f}"
                   for way in ways.values()]
        print(f"| {name} | 1/{ratio} | {plain:,.0f} | {' | '.join(row)} |", flush=True)


def main():
    global ARGS
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--cvol", default=f"{ROOT}/build/cvol")
    options.add_argument("files", nargs="*")
    ARGS = options.parse_args()
    print("| volume | rate | bytes of the components | opponent colours | KLT |\n|---|---|---:|---:|---:|")
    if not ARGS.files:
        for name, rgb in stained():
            measure(name, rgb)
        return
    import tifffile
    for path in ARGS.files:
        measure(os.path.basename(path), tifffile.imread(path)[..., :3].astype(np.float32))


main()
