#!/usr/bin/python3
"""Writes float32 samples, x fastest, to OUT.raw: SIDE^3 of them, or NXxNYxNZ.

NAME is one of the bench's volumes, cropped about its centre (an axis that is slightly too short repeats its last
samples) and scaled to 0..1; or `mask`, a smooth ball, 1 inside and 0 outside.
"""
import argparse
import os
import sys

import numpy

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from volumes import DEFAULT_DATA, RENDERED, read_volume, rendered_path  # noqa: E402

MOSTLY = 0.9  # the least share of an axis that the volume must have


def smooth_ball(shape):
    """1 inside, 0 outside, with a slope over a tenth of the radius; of the given z y x shape."""
    axes = [numpy.linspace(-1, 1, n, dtype=numpy.float32) for n in shape]
    z, y, x = numpy.meshgrid(*axes, indexing='ij', sparse=True)
    radius = numpy.sqrt(x * x + y * y + z * z)
    return (1 / (1 + numpy.exp((radius - 0.7) / 0.05))).astype(numpy.float32)


def cropped(name, shape, data):
    path = rendered_path(name, data)
    if not os.path.exists(path):
        sys.exit(f'{path}: not there')
    samples = read_volume(path)[0]
    if any(have < MOSTLY * want for have, want in zip(samples.shape, shape)):
        sys.exit(f'{path}: too small')
    begin = [max(have - want, 0) // 2 for have, want in zip(samples.shape, shape)]
    part = samples[tuple(slice(b, b + n) for b, n in zip(begin, shape))].astype(numpy.float32)
    part = numpy.pad(part, [(0, n - have) for have, n in zip(part.shape, shape)], mode='edge')
    return (part - part.min()) / (part.max() - part.min())


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('name', choices=list(RENDERED) + ['mask'], metavar='NAME')
    parser.add_argument('size', metavar='SIDE')
    parser.add_argument('out')
    parser.add_argument('--data', default=DEFAULT_DATA)
    arguments = parser.parse_args()
    sides = [int(n) for n in arguments.size.split('x')]
    shape = tuple(reversed(sides)) if len(sides) == 3 else (sides[0],) * 3
    if arguments.name == 'mask':
        samples = smooth_ball(shape)
    else:
        samples = cropped(arguments.name, shape, arguments.data)
    samples.astype('<f4').tofile(arguments.out)


if __name__ == '__main__':
    main()
