#!/usr/bin/python3
"""Convergence of `cvol render --light cinematic`: engine sheet against rays of light through the samples.

For each volume, compressed to 1/30, and each number of directions of light:

  ms       of a picture by engine sheet, with all threads, median of three
  dB       PSNR of the picture against engine ray with REFERENCE directions from every lit place (about 100 places on
           the ray of a pixel, so 4,096 paths per pixel or more), and the same over the foreground

With matplotlib also a plot of both.
"""
import argparse
import os
import statistics
import sys

from tables import Failed, add_common_arguments, check_cvol, markdown, provenance, run, run_json, say, write_results
from volumes import BENCH, all_paths, folder_paths, raw_options, short_name

WORK = os.path.join(BENCH, 'scratch', 'cinematic')
SAMPLES = (2, 4, 8, 16, 32, 64, 256)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('files', nargs='*', metavar='FILE', help='volumes; default: those of the data folder')
    parser.add_argument('--size', type=int, default=256)
    parser.add_argument('--reference', type=int, default=64, help='directions of engine ray')
    parser.add_argument('--work', default=WORK, metavar='DIR', help='files and pictures (default %(default)s)')
    return parser.parse_args()


def rows_of(cvol, name, path, arguments):
    packed, truth, picture = (os.path.join(arguments.work, name + end) for end in ('.cvol', '-ray.png', '-sheet.png'))
    run([cvol, 'compress', path, packed, '--force', '--labels', 'no'] + raw_options(path))
    common = [cvol, 'render', packed, '--size', str(arguments.size), '--light', 'cinematic', '--json', '--samples']
    run(common + [str(arguments.reference), '-o', truth, '--engine', 'ray'])
    for samples in SAMPLES:
        times = [run_json(common + [str(samples), '-o', picture])['render_ms'] for _ in range(3)]
        report = run_json([cvol, 'compare', truth, picture, '--json'])
        yield {'volume': name, 'directions': str(samples), 'ms': f'{statistics.median(times):.0f}',
               'dB': f"{report['psnr_db']:.1f}", 'foreground dB': f"{report['psnr_foreground_db']:.1f}"}


def plot(rows, folder):
    try:
        from matplotlib import pyplot
    except ImportError:
        return
    for name in dict.fromkeys(row['volume'] for row in rows):
        own = [row for row in rows if row['volume'] == name]
        pyplot.semilogx([float(row['ms']) for row in own], [float(row['dB']) for row in own], marker='o', label=name)
    pyplot.xlabel('ms of a picture')
    pyplot.ylabel('PSNR in dB against rays of light')
    pyplot.legend(fontsize=7)
    pyplot.savefig(os.path.join(folder, 'cinematic.png'), dpi=120)


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    os.makedirs(arguments.work, exist_ok=True)
    rows = []
    try:
        for path in arguments.files or all_paths(arguments.data) + folder_paths(arguments.data):
            for row in rows_of(cvol, short_name(path), path, arguments):
                say(' '.join(row.values()))
                rows.append(row)
    except Failed as problem:
        sys.exit(f'cinematic.py: {problem}')
    text = '\n'.join(['# Cinematic light', '', f'{arguments.size} x {arguments.size}.', '',
                      markdown(list(rows[0]), rows), ''] + [line + '  ' for line in provenance(cvol)])
    write_results(arguments.results, 'cinematic', text, rows)
    plot(rows, arguments.results)


if __name__ == '__main__':
    main()
