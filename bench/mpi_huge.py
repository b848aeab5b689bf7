#!/usr/bin/python3
"""A volume of which no process could hold a layer: compressed, verified and drawn by several processes.

    bench/mpi_huge.py [--side 4096] [--ranks 4] [--ratio 1000] [--folder DIR] [--keep] [--out FILE]

The volume is a double helix with rungs, noisy, in empty space, as uint8. Its file is sparse: 64 GiB of 4096^3 samples
take about 8 GiB of disk, and processes read all 64 GiB. It is made by slab. The script prints the time of each command,
and the peak of resident memory of its processes, and leaves the picture next to the table.
"""
import argparse
import json
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time

from mpi_speed import prepare_environment
from tables import RESULTS, machine
from volumes import ROOT

GIB = 1 << 30
TURNS, STRANDS, RUNGS = 2.5, 2, 20


def measure(path, command):
    """Runs a command and writes the peak of its resident memory, in bytes, into a file of its own."""
    status = subprocess.run(command, check=False).returncode
    with open(f'{path}.{os.getpid()}', 'w', encoding='ascii') as out:
        out.write(str(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024))
    sys.exit(status)


def patch(np, noise, side, z, strand):
    """Returns the samples of a strand in a slice, and their first row and column."""
    angle = 2 * math.pi * (TURNS * z / side + strand / STRANDS)
    centre = [side / 2 + 0.36 * side * f(angle) for f in (math.sin, math.cos)]
    radius = 0.032 * side
    first = [int(c - radius) for c in centre]
    across = [np.arange(f, f + int(2 * radius) + 2, dtype=np.float32) - c for f, c in zip(first, centre)]
    distance = np.hypot(across[0][:, None], across[1][None, :]) / radius
    ripples = 12 * np.sin(40 * distance) + 10 * math.sin(600 * z / side)
    grain = noise[z * 31 % 4096:][:distance.size].reshape(distance.shape)
    samples = (150 + ripples + grain) * np.clip((1 - distance) * 12, 0, 1)
    return np.clip(samples, 0, 255).astype(np.uint8), first


def rung(np, side, z):
    """Returns the rows and columns of samples of a rung in a slice."""
    number = round(z / side * RUNGS)
    middle = number * side / RUNGS
    half = 0.007 * side
    if abs(z - middle) >= half:
        return None
    angle = 2 * math.pi * TURNS * middle / side
    width = math.sqrt(half**2 - (z - middle)**2)
    along, across = np.meshgrid(np.arange(-0.35 * side, 0.35 * side, 0.7), np.arange(-width, width, 0.7))
    return [np.rint(side / 2 + along * f + across * g).astype(np.int64)
            for f, g in ((math.sin(angle), math.cos(angle)), (math.cos(angle), -math.sin(angle)))]


def make(path, side):
    """Writes side^3 samples, with one slice in memory."""
    import numpy as np  # not in the processes that are measured
    noise = np.random.default_rng(1).normal(0, 6, side * side // 64 + 4096).astype(np.float32)
    with open(path, 'wb') as out:
        out.truncate(side**3)
    for z in range(side):
        sheet = np.memmap(path, np.uint8, 'r+', z * side * side, (side, side))
        spokes = rung(np, side, z)
        if spokes:
            sheet[spokes[0], spokes[1]] = 90
        for strand in range(STRANDS):
            samples, (y, x) = patch(np, noise, side, z, strand)
            sheet[y:y + samples.shape[0], x:x + samples.shape[1]] = samples


def run(a, folder, *arguments):
    """Returns the JSON of cvol-mpi, seconds, and the peaks of the processes in bytes."""
    peaks = os.path.join(folder, 'peak')
    command = [a.launcher, '-n', str(a.ranks), sys.executable, __file__, '--measure', peaks,
               os.path.join(a.build, 'cvol-mpi'), *arguments, '--threads', '1', '--json']
    start = time.monotonic()
    done = subprocess.run(command, stdout=subprocess.PIPE, check=False, text=True)
    seconds = time.monotonic() - start
    if done.returncode:
        sys.exit(f'failed: {" ".join(command)}')
    found = []
    for name in os.listdir(folder):
        with open(os.path.join(folder, name), encoding='ascii') as text:
            found.append(int(text.read()))
        os.remove(os.path.join(folder, name))
    return json.loads(done.stdout), seconds, found


def main():
    if sys.argv[1:2] == ['--measure']:
        measure(sys.argv[2], sys.argv[3:])
    options = argparse.ArgumentParser()
    options.add_argument('--side', type=int, default=4096)
    options.add_argument('--ranks', type=int, default=4)
    options.add_argument('--ratio', default='1000')
    options.add_argument('--size', default='1024')
    options.add_argument('--folder', default='/tmp')
    options.add_argument('--build', default=os.path.join(ROOT, 'build'))
    options.add_argument('--launcher', default='mpirun')
    options.add_argument('--keep', action='store_true')
    options.add_argument('--out', default=os.path.join(RESULTS, 'mpi_huge.md'))
    a = options.parse_args()
    prepare_environment()
    raw, file = (os.path.join(a.folder, 'helix' + end) for end in ('.raw', '.cvol'))
    picture = os.path.splitext(a.out)[0] + '.png'
    samples = a.side**3
    if not (os.path.exists(raw) and os.path.getsize(raw) == samples):
        if shutil.disk_usage(a.folder).free < samples // 5:
            sys.exit(f'{a.folder}: {samples / 5 / GIB:.1f} GiB are needed')
        make(raw, a.side)
    rows = []

    def row(what, more, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            found, seconds, peaks = run(a, folder, *arguments)
        rows.append(f'| {what} | {seconds:.4g} s | {min(peaks) / (1 << 20):.0f} to '
                    f'{max(peaks) / (1 << 20):.0f} MiB | {more(found, seconds)} |')
        print(rows[-1], flush=True)

    os.makedirs(os.path.dirname(a.out), exist_ok=True)
    row('compress', lambda found, seconds: f"1/{found['ratio']:.1f}, {found['psnr_db']:.2f} dB, "
        f'{samples / seconds / 1e6:.0f} Mvoxel/s', 'compress', raw, file, '--stream', '--type', 'uint8',
        '--dims', 'x'.join([str(a.side)] * 3), '--ratio', a.ratio)
    row('verify', lambda found, seconds: f'{os.path.getsize(file) / 1e6:.0f} MB', 'verify', file)
    row('render', lambda found, seconds: f"{found['stages'][0]['draw_s']:.3g} s of drawing", 'render', file, '-o',
        picture, '--size', a.size)
    with open(a.out, 'w', encoding='utf-8') as out:
        out.write(f'# A volume of {a.side}^3 uint8 samples ({samples / GIB:.3g} GiB), {a.ranks} processes of one '
                  f'thread\n\n{machine()}\n\nMade by `bench/mpi_huge.py`. Peaks are of resident memory.\n\n'
                  '| what | time | peak of a process | |\n|---|---|---|---|\n' + '\n'.join(rows) + '\n')
    for path in [] if a.keep else [raw, file]:
        os.remove(path)


if __name__ == '__main__':
    main()
