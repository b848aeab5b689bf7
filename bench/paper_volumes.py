"""Volumes of N^3 samples for the paper's table: a resampled CT of a head, and the signal of Marschner and Lobb.

The signal (Marschner and Lobb 1994; f_M = 6, alpha = 1/4 on -1 .. 1) has almost all of its energy just below the
highest frequency of 41 samples per axis; its values 0 .. 1 are stored as 0 .. 255.
"""
import math
import os

from tables import run, run_json
from volumes import rendered_path, transfer_path

LOOKS = ('thin', 'semi', 'opaque')
SIGNAL = 'signal'
# The signal's transfer function: semi-transparent around its middle value.
SIGNAL_POINTS = [[100, 0, 0, 0, 0], [128, 0.9, 0.7, 0.4, 0.05], [170, 0.4, 0.6, 0.9, 0.05],
                 [255, 0.3, 0.5, 1, 0.1]]


def head_is_there(arguments):
    return os.path.exists(rendered_path('cthead_8bit', arguments.data))


def _resample(samples, numpy, axis, count):
    """Returns means of groups of samples, or linear interpolation."""
    have = samples.shape[axis]
    if have % count == 0:
        shape = list(samples.shape)
        shape[axis:axis + 1] = [count, have // count]
        return samples.reshape(shape).mean(axis + 1)
    at = numpy.clip((numpy.arange(count) + 0.5) * have / count - 0.5, 0, have - 1)
    low = numpy.minimum(at.astype(int), have - 2)
    shape = [1, 1, 1]
    shape[axis] = count
    share = (at - low).reshape(shape).astype(numpy.float32)
    return (numpy.take(samples, low, axis) * (1 - share) +
            numpy.take(samples, low + 1, axis) * share)


def _read_head(arguments, numpy, folder):
    head = rendered_path('cthead_8bit', arguments.data)
    packed, raw = os.path.join(folder, 'ct.cvol'), os.path.join(folder, 'ct.raw')
    about = run_json([arguments.cvol, 'info', head, '--json'])
    run([arguments.cvol, 'compress', head, packed, '--lossless'])
    run([arguments.cvol, 'decompress', packed, raw])
    return numpy.fromfile(raw, numpy.uint8).reshape(about['dims'][::-1]).astype(numpy.float32)


def _make_signal(numpy, size):
    x = (numpy.linspace(-1, 1, size, dtype=numpy.float32))
    radius = numpy.hypot(x[:, None], x[None, :])
    rings = 0.25 * (1 + numpy.cos(2 * math.pi * 6 * numpy.cos(math.pi * radius / 2)))
    waves = 1 - numpy.sin(math.pi * x / 2)
    return 255 * (waves[:, None, None] + rings[None]) / (2 * 1.25)


def make_volumes(arguments, folder, sizes):
    """Writes N.raw and signal-N.raw (uint8) for each size, and signal.json, the signal's transfer function."""
    import json

    import numpy  # not above: a child process starts with its parent's peak memory
    head = _read_head(arguments, numpy, folder)
    head = _resample(head, numpy, 0, 256)
    for size in sizes:
        cube = head
        for axis in range(3):
            cube = _resample(cube, numpy, axis, size)
        numpy.rint(cube).astype(numpy.uint8).tofile(os.path.join(folder, f'{size}.raw'))
        numpy.rint(_make_signal(numpy, size)).astype(numpy.uint8).tofile(
            os.path.join(folder, f'signal-{size}.raw'))
    with open(os.path.join(folder, 'signal.json'), 'w', encoding='ascii') as file:
        json.dump({'points': SIGNAL_POINTS}, file)


def volume_of(folder, size, look):
    """Returns the raw file and the transfer function of a look."""
    if look == SIGNAL:
        return os.path.join(folder, f'signal-{size}.raw'), os.path.join(folder, 'signal.json')
    return os.path.join(folder, f'{size}.raw'), transfer_path('cthead_8bit', look)
