#!/usr/bin/python3
"""Products of compressed scans: the plan `low` against all samples (`full`), in turns within one run.

Operands keep 1/30 of the numbers: k low and s scattered terms. Slices of 1024 x 1024 are two by two slices of
vhf_head, four by four of cthead_8bit, and one slice of vhf_head enlarged to twice its size, each with a pair of
neighbouring slices as operands; the volume is cthead_8bit, squared. Times are processor time for one thread and wall
clock for all. Errors are L2 norms relative to the norm of the product in double precision: of the decoded operands,
and of the original samples. The last column is 1 if the bound holds for both plans.
Needs NumPy and SciPy, and the library of the build in CVOL_LIBRARY.
usage: bench/algebra_scan.py [--data FOLDER] [--rounds N] [--transforms dct,dft,dht]
"""
import argparse
import os
import statistics
import sys
import time

import numpy
from scipy import ndimage

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'python'))
import cvol  # noqa: E402
from volumes import DEFAULT_DATA, read_volume, rendered_path  # noqa: E402

PLANS = ('full', 'low', 'auto')


def operands(data):
    """Yields (name, a, b)."""
    head = read_volume(rendered_path('vhf_head', data))[0]
    scan = read_volume(rendered_path('cthead_8bit', data))[0].astype(numpy.float32)

    def mosaic(volume, first, apart, side):
        return numpy.block([[volume[first + apart * (side * i + j)] for j in range(side)] for i in range(side)])
    yield ('vhf_head, 2 x 2 slices', mosaic(head, 60, 40, 2), mosaic(head, 63, 40, 2))
    yield ('vhf_head, enlarged', *(ndimage.zoom(head[z].astype(float), 2, order=1) for z in (117, 120)))
    yield ('cthead_8bit, 4 x 4 slices', mosaic(scan, 10, 5, 4), mosaic(scan, 11, 5, 4))
    yield ('cthead_8bit, volume', scan, scan)


def measure(a, b, threads, rounds):
    """Returns milliseconds of each plan, by plan."""
    clock = time.process_time if threads == 1 else time.perf_counter
    times = {plan: [] for plan in PLANS}
    with cvol.options(threads=threads):
        for turn in range(rounds + 1):
            for plan in PLANS:
                begin = clock()
                a.multiply(b, plan=plan).close()
                if turn:
                    times[plan].append(1000 * (clock() - begin))
    return times


def error_of(volume, exact):
    return numpy.linalg.norm(volume.to_numpy().astype(float) - exact) / numpy.linalg.norm(exact)


def row_of(name, samples, transform, rounds):
    samples = [numpy.ascontiguousarray(s, numpy.float32) for s in samples]
    a, b = (cvol.compress(s, transform=transform, block=0, keep=cvol.Keep.rho(1 / 30)) for s in samples)
    decoded = a.to_numpy().astype(float) * b.to_numpy().astype(float)
    exact = samples[0].astype(float) * samples[1].astype(float)
    cells, holds, errors = [name, transform], 1, []
    for threads in (1, 0):
        times = measure(a, b, threads, rounds)
        cells += [f'{min(times[plan]):.1f} ({statistics.median(times[plan]):.1f})' for plan in PLANS]
        cells.append(f"{min(times['full']) / min(times['low']):.1f} "
                     f"({statistics.median(times['full']) / statistics.median(times['low']):.1f})")
    for plan in PLANS[:2]:
        product = a.multiply(b, plan=plan)
        bound = product.error_bound / numpy.linalg.norm(exact)
        error = error_of(product, exact)
        errors.append(f'{error_of(product, decoded):.3f}, {error:.3f}, {bound:.2f}')
        holds &= error <= bound
    return cells + errors + [str(int(holds))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--data', default=DEFAULT_DATA)
    parser.add_argument('--rounds', type=int, default=9)
    parser.add_argument('--transforms', default='dct,dft,dht')
    arguments = parser.parse_args()
    print('Milliseconds: minimum (median); errors: of decoded operands, of originals, bound')
    heads = ['operands', 'transform']
    for threads in ('1 thread', 'all'):
        heads += [f'{plan}, {threads}' for plan in PLANS] + [f'full / low, {threads}']
    heads += ['full: errors', 'low: errors', 'bound holds']
    print('| ' + ' | '.join(heads) + ' |')
    print('|---' * len(heads) + '|')
    for name, *samples in operands(arguments.data):
        for transform in arguments.transforms.split(','):
            print('| ' + ' | '.join(row_of(name, samples, transform, arguments.rounds)) + ' |', flush=True)


if __name__ == '__main__':
    main()
