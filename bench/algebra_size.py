#!/usr/bin/python3
"""Size, bound and error of the results of operations on .cvol files.

The operands are a scan, compressed by default and at another ratio. Each result is compared with the same operation
on the original samples, in double precision. Columns: bytes of the result; these over the bytes of the larger operand;
the bound that the operands carry to the result, the result's bound and its measured error, each a root mean square per
sample; the bound over the error.
Needs NumPy and SciPy, and the library of the build in CVOL_LIBRARY.
usage: bench/algebra_size.py VOLUME [--ratio R] [--other R]
"""
import argparse
import os
import sys
import tempfile

import numpy
from scipy import ndimage

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'python'))
import cvol  # noqa: E402


def gradient(a, spacing):
    squares = 0.0
    for axis, distance in enumerate(spacing):
        taps = [0.5 / distance, 0, -0.5 / distance]
        squares = squares + ndimage.convolve1d(a, taps, axis=axis, mode='reflect') ** 2
    return numpy.sqrt(squares)


def gaussian(a, sigma):
    radius = int(numpy.ceil(4 * sigma))
    taps = numpy.exp(-0.5 * (numpy.arange(-radius, radius + 1) / sigma) ** 2)
    for axis in range(3):
        a = ndimage.convolve1d(a, taps / taps.sum(), axis=axis, mode='reflect')
    return a


def operations(a, b, x, y):
    """Name, the compressed result, the exact one, and the bound that the operands carry."""
    spacing = a.spacing
    norm = numpy.sqrt(sum(s ** -2.0 for s in spacing))
    largest = numpy.abs(x).max()
    yield 'a + b', a.add(b), lambda: x + y, a.error_bound + b.error_bound
    yield 'a - b', a.add(b, 1, -1), lambda: x - y, a.error_bound + b.error_bound
    yield 'a + a', a.add(a), lambda: x + x, 2 * a.error_bound
    yield 'a b', a.multiply(b), lambda: x * y, largest * (a.error_bound + b.error_bound)
    yield '2 a + 3', a.scale(2, 3), lambda: 2 * x + 3, 2 * a.error_bound
    yield 'gaussian:1.5', a.convolve('gaussian:1.5'), lambda: gaussian(x, 1.5), a.error_bound
    yield 'gaussian:3', a.convolve('gaussian:3'), lambda: gaussian(x, 3), a.error_bound
    yield 'gradient', a.gradient(), lambda: gradient(x, spacing), norm * a.error_bound


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('volume')
    parser.add_argument('--ratio', type=float, default=30)
    parser.add_argument('--other', type=float, default=20)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        operands, sizes = [], []
        samples, geometry = cvol.read(arguments.volume)
        for number, ratio in enumerate((arguments.ratio, arguments.other)):
            path = os.path.join(folder, f'{number}.cvol')
            cvol.compress(samples, geometry=geometry, ratio=ratio).save(path)
            operands.append(cvol.open(path))
            sizes.append(os.path.getsize(path))
        dense = samples.astype(float)
        root = numpy.sqrt(dense.size)
        print(f'a: {sizes[0]} bytes, bound {operands[0].error_bound / root:.3g}; '
              f'b: {sizes[1]} bytes, bound {operands[1].error_bound / root:.3g}')
        print('| operation | bytes | over the operand | carried | bound | error | bound / error |')
        print('|---|---:|---:|---:|---:|---:|---:|')
        for name, result, exact, carried in operations(*operands, dense, dense):
            path = os.path.join(folder, 'result.cvol')
            result.save(path)
            error = numpy.linalg.norm(result.to_numpy().astype(float) - exact()) / root
            size, larger = os.path.getsize(path), max(sizes) if 'b' in name.split() else sizes[0]
            print(f'| {name} | {size} | {size / larger:.2f} | {carried / root:.3g} | '
                  f'{result.error_bound / root:.3g} | {error:.3g} | {result.error_bound / root / error:.1f} |',
                  flush=True)


if __name__ == '__main__':
    main()
