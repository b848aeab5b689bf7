#!/usr/bin/python3
"""The default picture of any volume: its kind, how much of the picture it fills, its brightness, and its time.

For each volume, compressed to 1/30, at SIZE x SIZE:

  kind        what `--transfer auto` recognises
  height      the share of the picture's height that is not black, and the same of the width
  brightness  mean of the picture over that without light (`--light flat`), where either is not black
  studio/head milliseconds of `cvol bench render` with `--light studio` over those with `--light headlight`; one thread,
              median over the views

The pictures are written to the results folder; with Pillow also one sheet of all.
"""
import argparse
import os
import statistics
import sys

import numpy

from tables import Failed, add_common_arguments, check_cvol, markdown, provenance, run, run_json, say, write_results
from volumes import BENCH, all_paths, folder_paths, raw_options, short_name

WORK = os.path.join(BENCH, 'scratch', 'look')
BLACK = 0.05  # of white


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('files', nargs='*', metavar='FILE', help='volumes; default: those of the data folder')
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--views', type=int, default=6, help='of the times; 0: no times')
    parser.add_argument('--work', default=WORK, metavar='DIR', help='files (default %(default)s)')
    return parser.parse_args()


def sources(arguments):
    """Returns name -> (path, options of the command)."""
    paths = arguments.files or all_paths(arguments.data) + folder_paths(arguments.data)
    return {short_name(path): (path, raw_options(path)) for path in paths}


def read_pfm(path):
    """Returns the channels' largest value for each pixel."""
    with open(path, 'rb') as file:
        kind, size, _ = (file.readline().split() for _ in range(3))
        channels, (width, height) = 3 if kind == [b'PF'] else 1, map(int, size)
        return numpy.fromfile(file, '<f4').reshape(height, width, channels).max(axis=2)


def filled(seen, axis):
    places = numpy.flatnonzero(seen.any(axis=axis))
    return (places[-1] - places[0] + 1) / seen.shape[1 - axis] if len(places) else 0


def milliseconds(cvol, packed, light, arguments):
    return run_json([cvol, 'bench', 'render', packed, '--json', '--threads', '1', '--light', light, '--size',
                     str(arguments.size), '--views', str(arguments.views), '--repeat', '3'])['frame_ms']['median']


def measure(arguments, cvol, name, source):
    packed, picture = (os.path.join(arguments.work, name + ending) for ending in ('.cvol', '.pfm'))
    if not os.path.exists(packed):
        run([cvol, 'compress', source[0], packed, '--force'] + source[1])
    size = ['--size', str(arguments.size)]
    run([cvol, 'render', packed, '-o', os.path.join(arguments.results, f'look_{name}.png')] + size)
    kind = run_json([cvol, 'render', packed, '-o', picture, '--json'] + size).get('kind', '')
    lit = read_pfm(picture)
    run([cvol, 'render', packed, '-o', picture, '--light', 'flat'] + size)
    flat = read_pfm(picture)
    seen = lit > BLACK
    either = seen | (flat > BLACK)
    brightness = numpy.minimum(lit, 1)[either].mean() / numpy.minimum(flat, 1)[either].mean() if either.any() else 0
    row = {'volume': name, 'kind': kind, 'height': f'{filled(seen, 1):.2f}', 'width': f'{filled(seen, 0):.2f}',
           'brightness': f'{brightness:.2f}'}
    if arguments.views:
        times = [milliseconds(cvol, packed, light, arguments) for light in ('studio', 'headlight')]
        row |= {'studio ms': f'{times[0]:.1f}', 'studio/head': f'{times[0] / times[1]:.2f}'}
    say(' | '.join(row.values()))
    return row


def write_sheet(folder, names):
    try:
        from PIL import Image
    except ImportError:
        return
    side, across = 300, 5
    sheet = Image.new('RGB', (side * across, side * -(-len(names) // across)))
    for i, name in enumerate(names):
        picture = Image.open(os.path.join(folder, f'look_{name}.png')).convert('RGB')
        sheet.paste(picture.resize((side, side)), (i % across * side, i // across * side))
    sheet.save(os.path.join(folder, 'look.png'))


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    for folder in (arguments.work, arguments.results):
        os.makedirs(folder, exist_ok=True)
    try:
        rows = [measure(arguments, cvol, name, source) for name, source in sources(arguments).items()]
    except Failed as problem:
        sys.exit(f'look.py: {problem}')
    write_sheet(arguments.results, [row['volume'] for row in rows])
    medians = [f"Median: height {statistics.median(float(row['height']) for row in rows):.2f}, brightness "
               f"{statistics.median(float(row['brightness']) for row in rows):.2f}"]
    if arguments.views:
        medians.append(f"studio/head {statistics.median(float(row['studio/head']) for row in rows):.2f}")
    text = '\n'.join(['# The default picture', '', markdown(list(rows[0]), rows), '', ', '.join(medians) + '.', '']
                     + [line + '  ' for line in provenance(cvol)])
    write_results(arguments.results, 'look', text, rows)


if __name__ == '__main__':
    main()
