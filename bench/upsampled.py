#!/usr/bin/python3
"""Upsamples a real scan slab by slab, adds noise to every sample, compresses and renders it. Compressing and the
first shaded picture run in separate processes; the script records their peaks of resident memory. Frames run in one
process, `cvol bench render`.

    bench/upsampled.py SCAN [--dims 1024x1024x800] [--noise 8] [--folder DIR] [--threads 2] [--keep]

SCAN: int16 of three axes, such as the head CT `vhf_head.mha`. Interpolation is linear; --noise is the standard
deviation of normal noise. The samples take disk space in the folder.
"""
import argparse
import os
import shutil
import sys

import numpy as np

from huge import GIB, ROOT, run


def places(count, of):
    """Returns, for `count` samples within `of`, the index of the sample below and the weight of the one above."""
    at = np.linspace(0, of - 1, count)
    below = np.minimum(at.astype(int), max(of - 2, 0))
    return below, np.minimum(below + 1, of - 1), (at - below).astype(np.float32)


def between(samples, axis, below, above, weight):
    weight = weight[:, None] if axis == 0 else weight
    return np.take(samples, below, axis) * (1 - weight) + np.take(samples, above, axis) * weight


def make(path, scan, dims, sigma):
    """Writes a MetaImage slice by slice; interpolated slices of the scan are reused."""
    x, y, z = (places(n, scan.shape[2 - a]) for a, n in enumerate(dims))
    rng = np.random.default_rng(1)
    noise = rng.normal(0, sigma, dims[0] * dims[1] + 65536).astype(np.float32)
    made = {}

    def sheet(k):
        if k not in made:
            made[k] = between(between(scan[k].astype(np.float32), 1, *x), 0, *y)
            for old in [old for old in made if old < k - 1]:
                del made[old]
        return made[k]

    spacing = " ".join(f"{(scan.shape[2 - a] - 1) / (n - 1):.9g}" for a, n in enumerate(dims))
    with open(path, "wb") as out:
        out.write(f"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                  f"DimSize = {dims[0]} {dims[1]} {dims[2]}\nElementSpacing = {spacing}\n"
                  f"ElementType = MET_SHORT\nElementDataFile = LOCAL\n".encode())
        for k in range(dims[2]):
            below, above, weight = (p[k] for p in z)
            values = sheet(below) * (1 - weight) + sheet(above) * weight
            values += noise[(k * 7919) % 65536:][: values.size].reshape(values.shape)
            out.write(np.clip(np.rint(values), -32768, 32767).astype("<i2"))


def main():
    options = argparse.ArgumentParser()
    options.add_argument("scan")
    options.add_argument("--dims", default="1024x1024x800")
    options.add_argument("--noise", type=float, default=8)
    options.add_argument("--ratio", default="30")
    options.add_argument("--threads", default="2")
    options.add_argument("--folder", default="/tmp")
    options.add_argument("--cvol", default=os.path.join(ROOT, "build", "cvol"))
    options.add_argument("--keep", action="store_true")
    a = options.parse_args()
    dims = [int(n) for n in a.dims.split("x")]
    scan, large, file, picture = (os.path.join(a.folder, f"upsampled{end}")
                                  for end in (".npy", ".mha", ".cvol", ".png"))
    samples = dims[0] * dims[1] * dims[2]
    if shutil.disk_usage(a.folder).free < 2.5 * samples:
        sys.exit(f"{a.folder}: {2.5 * samples / GIB:.1f} GiB are needed")
    if not os.path.exists(large):
        run(a.cvol, "compress", "--lossless", a.scan, file, "--json")
        run(a.cvol, "decompress", file, scan, "--json")
        make(large, np.load(scan, mmap_mode="r"), dims, a.noise)
        os.remove(scan)
    threads = ["--threads", a.threads, "--json"]

    def say(what, seconds, peak, more):
        load = os.getloadavg()[0]
        print(f"{what}: {seconds:.3g} s, peak {peak / 1e6:.0f} MB, {more}, load {load:.1f}", flush=True)

    found, seconds, peak = run(a.cvol, "compress", large, file, "--ratio", a.ratio, *threads)
    say("compress", seconds, peak, f"1/{found['ratio']:.2f}, {found['psnr_db']:.2f} dB")
    look = ["--shade", "--fit", "box", "--azimuth", "30", "--elevation", "20"]
    for _ in range(3):
        found, seconds, peak = run(a.cvol, "render", file, "-o", picture, *look, *threads)
        say("first shaded picture", seconds, peak,
            f"loaded in {found['load_ms']:.0f} ms (level {found['file_level']} of the file), "
            f"rendered in {found['render_ms']:.0f} ms")
    for more in (["--shade"], []):
        found, seconds, peak = run(a.cvol, "bench", "render", file, "--size", "512", "--views", "6",
                                   "--repeat", "2", *more, *threads)
        say(f"frames {' '.join(more)}", seconds, peak,
            f"a frame {found['frame_ms']['median']:.0f} ms ({found['frame_ms']['min']:.0f}), "
            f"loaded in {found['load_ms']:.0f} ms, {found['cpu_ms']:.0f} ms of processors")
    for path in [picture] + ([] if a.keep else [large, file]):
        os.remove(path)


if __name__ == "__main__":
    main()
