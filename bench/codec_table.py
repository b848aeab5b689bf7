#!/usr/bin/python3
"""Compresses every volume at several targets and compares the reports of compress and compare.

The targets are ratios of 10, 30 and 100, a PSNR of 45 dB, and a largest error of 1 % of the range. `cvol compress
--json` reports ratio, PSNR and largest error; `cvol compare` measures the file against the original. Figures that
differ by more than rounding are marked. Seconds are those of the whole command, with reading, searching and
verifying.
"""
import argparse
import math
import os
import tempfile
import time

from tables import (Failed, add_common_arguments, check_cvol, markdown, provenance, run_json, say,
                    write_results)
from volumes import all_paths, raw_options, short_name, unread_names

# Figures have ten digits; sums of floats depend on the order of addition.
AGREE_DB = 0.001
AGREE_RELATIVE = 1e-5


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--volumes', metavar='A,B', help='names without ending (default all)')
    parser.add_argument('--threads', type=int, help='default: all cores')
    return parser.parse_args()


def targets(info):
    """Returns the table's label and the options of each target."""
    error = 0.01 * (info['max'] - info['min'])
    return [('1/10', ['--ratio', '10']), ('1/30', ['--ratio', '30']),
            ('1/100', ['--ratio', '100']), ('45 dB', ['--psnr', '45']),
            ('1 % of range', ['--max-error', repr(error)])]


def disagreements(said, measured, file_bytes):
    """Returns the names of figures in which compress and compare, or the file itself, differ."""
    wrong = []
    if not abs(said['psnr_db'] - measured['psnr_db']) <= AGREE_DB:
        wrong.append(f"PSNR (compare: {measured['psnr_db']:.4f})")
    if not math.isclose(said['max_error'], measured['max_abs_error'], rel_tol=AGREE_RELATIVE):
        wrong.append(f"largest error (compare: {measured['max_abs_error']:g})")
    if said['file_bytes'] != file_bytes:
        wrong.append(f'bytes (file: {file_bytes})')
    return wrong


def misses(said, options):
    """Returns whether the target was missed."""
    kind, value = options[0], float(options[1])
    return ((kind == '--psnr' and said['psnr_db'] < value) or
            (kind == '--max-error' and said['max_error'] > value) or
            (kind == '--ratio' and said['ratio'] < value) or not said['target_met'])


def measure(cvol, path, info, target, options, folder, threads):
    packed = os.path.join(folder, 'packed.cvol')
    known = raw_options(path) + threads
    row = {'volume': short_name(path), 'target': target}
    notes = []
    try:
        start = time.perf_counter()
        said = run_json([cvol, 'compress', path, packed, '--json'] + options + known, notes)
        seconds = time.perf_counter() - start
        measured = run_json([cvol, 'compare', path, packed, '--json'] + known, notes)
    except Failed as problem:
        return row | {'notes': f'failed: {problem}'}
    value_range = info['max'] - info['min']
    if misses(said, options):
        notes.insert(0, '**target not met**')
    wrong = disagreements(said, measured, os.path.getsize(packed))
    if wrong:
        notes.insert(0, '**disagree: ' + ', '.join(wrong) + '**')
    voxels = math.prod(said['dims'])
    return row | {'ratio': f"{said['ratio']:.2f}", 'PSNR dB': f"{said['psnr_db']:.2f}",
                  'max error': f"{said['max_error']:.4g}",
                  'of range': f"{100 * said['max_error'] / value_range:.3g} %",
                  'bits/voxel': f"{said['bits_per_voxel']:.3f}", 'seconds': f'{seconds:.2f}',
                  'Mvoxel/s': f'{voxels / seconds / 1e6:.1f}',
                  'block': said['block'], 'step': f"{said['step']:.5g}",
                  'notes': '; '.join(dict.fromkeys(notes))}


def measure_volume(cvol, path, folder, threads):
    try:
        info = run_json([cvol, 'info', path, '--json'] + raw_options(path))
    except Failed as problem:
        return [{'volume': short_name(path), 'notes': f'failed: {problem}'}]
    dims = 'x'.join(map(str, info['dims']))
    rows = []
    for target, options in targets(info):
        row = measure(cvol, path, info, target, options, folder, threads)
        rows.append(row | {'samples': f"{dims} {info['type']}", 'min': info['min'],
                           'max': info['max']})
        say(f"{row['volume']} {target}: {row.get('ratio')} {row.get('PSNR dB')} dB "
            f"{row.get('seconds')} s {row['notes']}")
    return rows


def describe(cvol, rows, skipped):
    columns = ['volume', 'samples', 'target', 'ratio', 'PSNR dB', 'max error', 'of range',
               'seconds', 'Mvoxel/s', 'notes']
    wrong = sum('disagree' in row['notes'] for row in rows)
    lines = ['# Compression', '', markdown(columns, rows), '',
             f'{len(rows)} rows; in {wrong} compress and compare disagree.', '']
    if skipped:
        lines += [f"Not read by this build: {', '.join(skipped)}.", '']
    return '\n'.join(lines + [line + '  ' for line in provenance(cvol)])


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    threads = ['--threads', str(arguments.threads)] if arguments.threads else []
    paths = all_paths(arguments.data)
    if arguments.volumes:
        paths = [path for path in paths if short_name(path) in arguments.volumes.split(',')]
    rows = []
    with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
        for path in paths:
            rows += measure_volume(cvol, path, folder, threads)
    write_results(arguments.results, 'codec_table',
                  describe(cvol, rows, unread_names(arguments.data)), rows)


if __name__ == '__main__':
    main()
