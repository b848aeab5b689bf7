#!/usr/bin/python3
"""Bytes of segmentations, compared with zstd -19, PNG slices, and another build of cvol.

The script makes five segmentations from a seed and the bench's volumes (missing ones are skipped): tissue classes,
cells by a watershed, parcels around random seeds, vessels that branch, and the materials of a tooth. It compresses each
one with --labels yes, decompresses the file and compares all samples. Seconds are those of the whole command.
Needs numpy and scipy; Pillow for PNG.
"""
import argparse
import io
import os
import subprocess
import sys
import tempfile
import time

import numpy
from scipy import ndimage, spatial

from tables import add_common_arguments, check_cvol, markdown, provenance, run, run_json, say, write_results
from volumes import read_volume, rendered_path

SEED = 7


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--other', metavar='CVOL', help='another build of the command, for one more column')
    parser.add_argument('--threads', type=int, default=1, help="cvol's (default 1)")
    return parser.parse_args()


# ---- segmentations ------------------------------------------------------------------------------

def smooth(path, sigma):
    return ndimage.gaussian_filter(read_volume(path, stored=True)[0].astype('float32'), sigma)


def tissue(data, _):
    """Four classes of a brain by thresholds."""
    samples = smooth(rendered_path('brain', data), 1)
    low, high = numpy.percentile(samples[samples > 20], [10, 45])
    return numpy.digitize(samples, [20, low, high]).astype('uint8')


def cells(data, _):
    """The brightest fifth of an embryo, divided by a watershed around maxima."""
    samples = smooth(rendered_path('embryo', data), 2)
    inside = samples > numpy.percentile(samples, 80)
    markers, _ = ndimage.label((ndimage.maximum_filter(samples, 9) == samples) & inside)
    outside = ~ndimage.binary_dilation(inside, iterations=3)
    depth = (255 * (1 - samples / samples.max())).astype('uint8')
    found = ndimage.watershed_ift(depth, numpy.where(inside, markers, 0).astype('int16') - outside.astype('int16'))
    return numpy.where(inside & (found > 0), found, 0).astype('uint16')


def parcels(data, random):
    """The regions of the nearest of 100 places within a brain."""
    samples = read_volume(rendered_path('inia19', data), stored=True)[0]
    inside = ndimage.gaussian_filter((samples > numpy.percentile(samples, 60)).astype('float32'), 1.5) > 0.5
    inside = ndimage.binary_fill_holes(inside)
    places = numpy.argwhere(inside)
    seeds = places[random.choice(len(places), 100, replace=False)]
    labels = numpy.zeros(samples.shape, 'uint16')
    labels[inside] = spatial.cKDTree(seeds).query(places)[1] + 1
    return labels


def vessels(_, random):
    """A tree of tubes."""
    side, reach = 256, 8
    labels = numpy.zeros([side] * 3, 'uint8')
    near = numpy.arange(-reach, reach + 1)
    ball = numpy.stack(numpy.meshgrid(near, near, near, indexing='ij'), -1)
    branches = [(numpy.array([128., 128., 4.]), numpy.array([0., 0., 1.]), 7.)]
    for _ in range(400):
        if not branches:
            break
        place, direction, radius = branches.pop()
        is_whole = True
        for step in range(int(random.integers(30, 90))):
            place = place + direction
            direction = direction + random.normal(0, .12, 3)
            direction /= numpy.linalg.norm(direction)
            if ((place < 9).any() and step > 5) or (place > side - 10).any():
                is_whole = False
                break
            at = numpy.clip(numpy.round(place).astype(int), reach, side - reach - 1)
            within = numpy.linalg.norm(ball - (place - at), axis=-1) <= radius
            labels[tuple(slice(c - reach, c + reach + 1) for c in at)] |= within
        for _ in range(2 if is_whole and radius > 1.2 else 0):
            turned = direction + random.normal(0, .6, 3)
            branches.insert(0, (place.copy(), turned / numpy.linalg.norm(turned), .82 * radius))
    return labels


def tooth(data, _):
    """Three materials and air, by thresholds."""
    samples = smooth(os.path.join(data, 'tooth.nrrd'), .8)
    low, high = samples.min(), numpy.percentile(samples, 99.5)
    return numpy.digitize(samples, low + (high - low) * numpy.array([.3, .55, .8])).astype('uint8')


SEGMENTATIONS = (tissue, cells, parcels, vessels, tooth)


# ---- measuring ----------------------------------------------------------------------------------

def png_bytes(labels):
    """Returns the bytes of all slices as PNG, or None without Pillow."""
    try:
        from PIL import Image
    except ImportError:
        return None
    total = 0
    for plane in labels:
        file = io.BytesIO()
        Image.fromarray(plane).save(file, 'PNG', optimize=True)
        total += file.tell()
    return total


def measure(arguments, cvol, labels, name, folder):
    raw, packed, back = (os.path.join(folder, name + end) for end in ('.raw', '.cvol', '.back.raw'))
    labels.tofile(raw)
    options = ['--dims', 'x'.join(map(str, labels.shape[::-1])), '--type', labels.dtype.name, '--labels', 'yes',
               '--threads', str(arguments.threads)]
    begin = time.monotonic()
    said = run_json([cvol, 'compress', raw, packed, '--json', *options])
    middle = time.monotonic()
    run([cvol, 'decompress', packed, back, '--threads', str(arguments.threads)])
    end = time.monotonic()
    is_same = numpy.array_equal(numpy.fromfile(back, labels.dtype), labels.ravel())
    bytes_of = {'zstd -19': len(subprocess.run(['zstd', '-19', '-q', '-c', raw], stdout=subprocess.PIPE,
                                               check=True).stdout),
                'PNG': png_bytes(labels)}
    if arguments.other:
        bytes_of['other cvol'] = run_json([arguments.other, 'compress', raw, packed, '--json', *options])['file_bytes']
    bytes_of['cvol'] = said['file_bytes']
    row = {'segmentation': name, 'samples': ' x '.join(map(str, labels.shape[::-1])) + ' ' + labels.dtype.name,
           'labels': len(numpy.unique(labels)), 'raw': labels.nbytes}
    for coder, count in bytes_of.items():
        row[coder] = '' if count is None else count
        row[coder + ' %'] = '' if count is None else f'{100 * count / labels.nbytes:.3f}'
    row.update({'compress s': f'{middle - begin:.2f}', 'decompress s': f'{end - middle:.2f}',
                'notes': '' if is_same else 'VIOLATED: samples differ'})
    say(str(row))
    return row


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for make in SEGMENTATIONS:
            try:
                labels = make(arguments.data, numpy.random.default_rng(SEED))
            except FileNotFoundError as missing:
                say(f'{make.__name__}: skipped, {missing.filename} is missing')
                continue
            rows.append(measure(arguments, cvol, labels, make.__name__, folder))
    columns = [column for column in rows[0] if column != 'notes' or any(row['notes'] for row in rows)]
    write_results(arguments.results, 'labels', '\n'.join(['# Segmentations', '', *provenance(cvol), '',
                                                          markdown(columns, rows)]), rows)
    sys.exit(1 if any(row['notes'] for row in rows) else 0)


if __name__ == '__main__':
    main()
