#!/usr/bin/python3
"""Steps of the heat equation on the coefficients of a volume, with the certified bound of the error.

A step convolves with (r, 1 - 2 r, r) along every axis; samples beyond a face repeat those before it. The same steps on
the original samples, in double precision, give the error. Columns: steps so far; milliseconds of a step, of the
compressed volume and of the dense samples (SciPy); kilobytes of the compressed volume as a file, or of its terms in
memory for a transform of the whole; bound and error as a root mean square per sample; standard deviation of the exact
samples.
Needs NumPy and SciPy, and the library of the build in CVOL_LIBRARY.
usage: bench/heat.py VOLUME [--side N] [--steps N] [--rate R]     the middle N^3 samples of the volume
"""
import argparse
import os
import sys
import tempfile
import time

import numpy
from scipy import ndimage

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'python'))
import cvol  # noqa: E402


def diffuse(samples, taps):
    for axis in range(3):
        samples = ndimage.correlate1d(samples, taps, axis=axis, mode='reflect')
    return samples


def size_of(volume, folder):
    if not volume.info.block:
        return volume.info.resident_bytes
    path = os.path.join(folder, 'state.cvol')
    volume.save(path)
    return os.path.getsize(path)


def run(name, volume, dense, taps, shown, folder):
    """Prints a row for each number of steps in `shown`."""
    root = numpy.sqrt(dense.size)
    compressed_s = dense_s = 0.0
    for step in range(1, max(shown) + 1):
        begin = time.perf_counter()
        volume = volume.convolve(taps)
        compressed_s += time.perf_counter() - begin
        begin = time.perf_counter()
        dense = diffuse(dense, taps)
        dense_s += time.perf_counter() - begin
        if step in shown:
            error = numpy.linalg.norm(volume.to_numpy().astype(float) - dense) / root
            print(f'| {name} | {step} | {1000 * compressed_s / step:.1f} | {1000 * dense_s / step:.1f} | '
                  f'{size_of(volume, folder) / 1000:.0f} | {volume.error_bound / root:.3g} | {error:.2g} | '
                  f'{dense.std():.3g} |', flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('volume')
    parser.add_argument('--side', type=int, default=96)
    parser.add_argument('--steps', type=int, default=1000)
    parser.add_argument('--rate', type=float, default=0.1)
    arguments = parser.parse_args()
    taps = [arguments.rate, 1 - 2 * arguments.rate, arguments.rate]
    shown = sorted({max(1, arguments.steps // k) for k in (1000, 100, 10, 1)})
    samples, _ = cvol.read(arguments.volume)
    middle = tuple(slice(max(0, (n - arguments.side) // 2), (n + arguments.side) // 2) for n in samples.shape)
    samples = numpy.ascontiguousarray(samples[middle])
    rho = 1 / 30
    whole = cvol.compress(samples.astype(numpy.float32), transform='dct', block=0, keep=cvol.Keep.rho(rho))
    root = numpy.sqrt(samples.size)
    print('| volume | steps | ms a step | dense ms | kB | bound | error | deviation |')
    print('|---|---:|---:|---:|---:|---:|---:|---:|')
    with tempfile.TemporaryDirectory() as folder:
        for name, volume in (('DCT of the whole, 1/30 of the terms', whole),
                             ('blocks, a file of 1/30', cvol.compress(samples, ratio=30))):
            print(f'| {name} | 0 | | | {size_of(volume, folder) / 1000:.0f} | {volume.error_bound / root:.3g} | '
                  f'{numpy.linalg.norm(volume.scale(1).to_numpy().astype(float) - samples) / root:.2g} | {samples.std():.3g} |')
            run(name, volume, samples.astype(float), taps, shown, folder)


if __name__ == '__main__':
    main()
