#!/usr/bin/python3
"""A volume larger than memory. Separate processes make it slab by slab, compress, render and verify it, and read a
box of it; the script records the peak of resident memory of each.

    bench/huge.py [--side 2048] [--folder DIR] [--threads N] [--out bench/results/huge.md]

The volume is synthetic: waves of several lengths, shells, and noise, as uint8. It takes side^3 bytes of disk in the
folder; --keep keeps it there.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import time

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
GIB = 1 << 30


def make(path, side):
    """Writes side^3 samples with only one slice in memory."""
    x = np.arange(side, dtype=np.float32)
    rng = np.random.default_rng(1)
    noise = rng.normal(0, 1.5, side * side + 65536).astype(np.float32)
    waves = []
    for k in range(6):
        kx, ky, kz = rng.normal(0, 0.006 * 2**k, 3)
        phase = rng.uniform(0, 6.28)
        plane = (kx * x)[None, :] + (ky * x)[:, None] + phase
        waves.append((kz, 40 / 1.8**k, np.cos(plane).astype(np.float32),
                      np.sin(plane).astype(np.float32)))
    squares = (x - side / 2)[None, :] ** 2 + (x - side / 2)[:, None] ** 2
    with open(path, "wb") as out:
        for z in range(side):
            sheet = np.full((side, side), 100, np.float32)
            for kz, size, cosine, sine in waves:
                sheet += np.float32(size * np.cos(kz * z)) * cosine
                sheet -= np.float32(size * np.sin(kz * z)) * sine
            radius = squares + np.float32((z - side / 2) ** 2)
            for share, step in ((0.45, 30), (0.3, 35), (0.1, -60)):
                sheet += np.float32(step) * (radius < np.float32((share * side) ** 2))
            sheet += noise[(z * 7919) % 65536:][: side * side].reshape(side, side)
            out.write(np.clip(sheet, 0, 255).astype(np.uint8))


def run(*command):
    """Returns output (JSON), seconds, and the peak of resident memory in bytes."""
    start = time.monotonic()
    # Waiting threads sleep: on a shared machine they would otherwise delay each other.
    child = subprocess.Popen(command, stdout=subprocess.PIPE,
                             env=dict(os.environ, OMP_WAIT_POLICY="passive"))
    text = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    seconds = time.monotonic() - start
    if status:
        sys.exit(f"failed: {' '.join(command)}")
    return json.loads(text), seconds, usage.ru_maxrss * 1024


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--side", type=int, default=2048)
    options.add_argument("--ratio", type=float, default=30)
    options.add_argument("--threads", default=str(os.cpu_count()))
    options.add_argument("--folder", default="/tmp")
    options.add_argument("--cvol", default=os.path.join(ROOT, "build", "cvol"))
    options.add_argument("--out", default=os.path.join(ROOT, "bench", "results", "huge.md"))
    options.add_argument("--keep", action="store_true")
    a = options.parse_args()
    raw, file, part = (os.path.join(a.folder, "huge" + end) for end in (".raw", ".cvol", ".part.raw"))
    threads = ["--threads", a.threads, "--json"]
    samples = a.side**3
    free = shutil.disk_usage(a.folder).free
    if not (os.path.exists(raw) and os.path.getsize(raw) == samples):
        if free < samples * 1.2:
            sys.exit(f"{a.folder}: {free / GIB:.1f} GiB are free, {samples * 1.2 / GIB:.1f} needed")
        make(raw, a.side)
    rows = []

    def row(what, seconds, peak, more):
        rows.append(f"| {what} | {seconds:.4g} s | {peak / (1 << 20):.0f} MiB | {more} |")
        print(rows[-1], flush=True)

    found, seconds, peak = run(a.cvol, "compress", "--stream", raw, file, "--type", "uint8",
                               "--dims", "x".join([str(a.side)] * 3), "--ratio", str(a.ratio), *threads)
    row("compress", seconds, peak, f"1/{found['ratio']:.2f}, {found['psnr_db']:.2f} dB, "
        f"{samples / seconds / 1e6:.1f} Mvoxel/s")
    found, seconds, peak = run(a.cvol, "render", "--level", "3", file, "-o", part + ".png", *threads)
    row("render --level 3", seconds, peak,
        f"loaded in {found['load_ms']:.0f} ms, rendered in {found['render_ms']:.0f} ms")
    _, seconds, peak = run(a.cvol, "verify", file, *threads)
    row("verify", seconds, peak, f"{os.path.getsize(file) / 1e6:.0f} MB")
    begin = a.side // 2 + 5
    box = ",".join([f"{begin}:{begin + 64}"] * 3)
    best = min((run(a.cvol, "decompress", file, part, "--box", box, *threads) for _ in range(5)),
               key=lambda r: r[0]["decode_ms"])
    with open(raw, "rb") as source:
        block = np.memmap(source, np.uint8, "r", shape=(a.side,) * 3)
        inside = slice(begin, begin + 64)
        original = np.array(block[inside, inside, inside], np.float64)
    error = original - np.fromfile(part, np.uint8).reshape(64, 64, 64)
    row("decompress --box of 64^3", best[1], best[2], f"{best[0]['decode_ms']:.1f} ms inside, best of "
        f"5, RMSE {np.sqrt(np.mean(error**2)):.2f}")
    os.makedirs(os.path.dirname(a.out), exist_ok=True)
    with open(a.out, "w") as out:
        out.write(f"# A volume of {a.side}^3 uint8 samples ({samples / GIB:.3g} GiB), "
                  f"{a.threads} threads\n\n"
                  "Made by `bench/huge.py`. Peaks are of resident memory, mapped files included.\n\n"
                  "| what | time | peak | |\n|---|---|---|---|\n" + "\n".join(rows) + "\n")
    for path in [part, part + ".png"] + ([] if a.keep else [raw, file]):
        os.remove(path)


if __name__ == "__main__":
    main()
