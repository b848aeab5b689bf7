#!/usr/bin/python3
"""Times the algebra of compressed arrays, compared with conventional methods: FFTW, zfp, dense files.

Four parts (--parts):
  `theorems`  time against the number of kept terms and of samples
  `speedup`   products of arrays that keep 1/30 of their terms
  `blocks`    volumes of 256^3 in blocks, compared with FFTW and zfp
  `volumes`   the command on files, compared with decompressing, computing and compressing again
The first three are C programs (build/bench, built with -DCVOL_BENCH=ON) on one thread; the two methods alternate.
Times are minima and medians over the rounds; speed-ups are ratios of minima.
"""
import argparse
import json
import math
import os
import statistics
import sys
import tempfile

from algebra_volumes import measure_volumes
from tables import (Failed, add_common_arguments, check_cvol, markdown, provenance, run, run_json,
                    say, write_results)
from volumes import BENCH

PARTS = ('theorems', 'speedup', 'blocks', 'volumes')
# (name, operation, support, plan): the series of the theorems; DFT, rank 1.
SERIES = [('add', 'add', 'low', 'auto'), ('convolve', 'convolve', 'low', 'auto'),
          ('multiply, grid', 'multiply', 'low', 'grid'),
          ('multiply, sparse, bands', 'multiply', 'bands', 'sparse'),
          ('multiply, sparse, harmonics', 'multiply', 'harmonics', 'sparse'),
          ('multiply, sparse, progression', 'multiply', 'progression', 'sparse')]
# Columns of times; without --other, those of the other build are empty.
TIMES = ['transforms', 'cvol min ms', 'cvol median ms', 'other transforms', 'other min ms',
         'cvol/other', 'FFTW min ms', 'FFTW median ms', 'FFTW/cvol', 'agree', 'notes']
EXPECTED = {'add': (1, 0), 'convolve': (1, 0)}
SAMPLES, TERMS = 22, 12  # binary logarithms of n and n'; the other build runs only there
TERMS_FROM, TERMS_TO, SAMPLES_FROM, SAMPLES_TO = 8, 17, 14, 24
CROPPED = ('brain', 'vhf_head')  # real volumes of at least 256 samples along each axis


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--parts', default=','.join(PARTS), metavar='A,B')
    parser.add_argument('--rounds', type=int, default=9)
    parser.add_argument('--quick', action='store_true', help='fewer sizes')
    parser.add_argument('--other', metavar='CVOL',
                        help='of a build with other transforms (-DCVOL_FFT=fftw), which takes turns')
    parser.add_argument('--side', type=int, default=256, help='of the volumes in blocks')
    return parser.parse_args()


def program(cvol, name):
    path = os.path.join(os.path.dirname(cvol), 'bench', name)
    if not os.access(path, os.X_OK):
        sys.exit(f'{path}: not built; configure with -DCVOL_BENCH=ON')
    return path


def low_of(terms, rank, transform):
    """Returns the side k of the low box that keeps about this many terms."""
    side = terms ** (1 / rank)
    return max(1, round(side if transform == 'dct' else (side + 1) / 2))


# ---- one run of algebra_whole -------------------------------------------------------------------

def time_whole(arguments, cvol, part, series, transform, dims, terms, planner='estimate'):
    name, operation, support, plan = series
    count = low_of(terms, len(dims), transform) if support == 'low' else terms
    row = {'part': part, 'series': name, 'transform': transform, 'dims': 'x'.join(map(str, dims)),
           'support': support, 'planner': planner}
    what = [operation, transform, row['dims'], support, str(count), plan, str(arguments.rounds), planner]
    try:
        found = run_json([program(cvol, 'algebra_whole')] + what)
        other = arguments.other and run_json([program(arguments.other, 'algebra_whole')] + what)
    except Failed as problem:
        say(f"{name} {transform} {row['dims']} {terms}: failed: {problem}")
        return row | {'notes': f'failed: {problem}'}
    ours, theirs = found['cvol_ms'], found['dense_ms']
    row |= {'n': found['samples'], "n'": found['terms'], 'kept': found['terms_out'],
            'plan': found.get('plan', ''), 'transforms': found['fft'],
            'cvol min ms': f'{min(ours):.4g}',
            'cvol median ms': f'{statistics.median(ours):.4g}',
            'FFTW min ms': f'{min(theirs):.4g}',
            'FFTW median ms': f'{statistics.median(theirs):.4g}',
            'FFTW/cvol': f'{min(theirs) / min(ours):.4g}', 'agree': f"{found['agree']:.1e}",
            'notes': 'not verified: an exact plan answered' if found.get('sparse_failed') else ''}
    if other:
        row |= {'other transforms': other['fft'], 'other min ms': f"{min(other['cvol_ms']):.4g}",
                'cvol/other': f"{min(ours) / min(other['cvol_ms']):.3g}"}
    say(f"{name} {transform} {row['dims']} n' {found['terms']}: cvol {row['cvol min ms']} ms, "
        f"FFTW {row['FFTW min ms']} ms {row['notes']}")
    return row


# ---- theorems -----------------------------------------------------------------------------------

def exponent(rows, key, least=0):
    """Slope of log time over log rows[key], least squares."""
    points = [(math.log(row[key]), math.log(float(row['cvol min ms']))) for row in rows
              if 'cvol min ms' in row and row[key] >= least]
    if len(points) < 3:
        return None
    mean_x, mean_y = (statistics.fmean(p[i] for p in points) for i in (0, 1))
    return (sum((x - mean_x) * (y - mean_y) for x, y in points) /
            sum((x - mean_x) ** 2 for x, _ in points))


def measure_theorems(arguments, cvol):
    rows = []
    terms_step, samples_step = (3, 4) if arguments.quick else (1, 2)
    for series in SERIES:
        # Scattered terms would fill a small n.
        samples_from = SAMPLES_FROM if series[2] == 'low' else SAMPLES_FROM + 2
        for log in range(TERMS_FROM, TERMS_TO + 1, terms_step):
            rows.append(time_whole(arguments, cvol, "against n'", series, 'dft', [2 ** SAMPLES],
                                   2 ** log))
        for log in range(samples_from, SAMPLES_TO + 1, samples_step):
            rows.append(time_whole(arguments, cvol, 'against n', series, 'dft', [2 ** log],
                                   2 ** TERMS))
    return rows


def describe_theorems(rows):
    fits = []
    for name, *_ in SERIES:
        mine = [row for row in rows if row['series'] == name]
        terms = [row for row in mine if row['part'] == "against n'"]
        samples = [row for row in mine if row['part'] == 'against n']
        values = [exponent(terms, "n'"), exponent(terms, "n'", 2 ** 12), exponent(samples, 'n')]
        p, q = EXPECTED.get(name, ("1 (n' log n')", 0))
        fits.append({'operation': name} | dict(zip(
            ('p', "p, n' from 2^12", 'q'), ('' if v is None else f'{v:.2f}' for v in values))) |
                    {'expected p': p, 'expected q': q})
    columns = ['series', 'n', "n'", 'plan'] + TIMES
    return ["## Time against terms and samples", '',
            f"Rank 1, DFT; n = 2^{SAMPLES} where n' runs, n' = 2^{TERMS} where n runs. Exponents "
            "of cvol's time: n'^p, n^q.", '',
            markdown(['operation', 'p', "p, n' from 2^12", 'expected p', 'q', 'expected q'], fits),
            '', markdown(columns, rows), '']


# ---- speed-up with 1/30 of the terms ------------------------------------------------------------

def measure_speedup(arguments, cvol):
    rows = []
    for dims in ([2 ** 20], [1024, 1024], [256, 256, 256]):
        for transform in ('dft', 'dht', 'dct'):
            for planner in ('estimate', 'measure'):
                rows.append(time_whole(arguments, cvol, 'speedup',
                                       ('multiply', 'multiply', 'low', 'auto'), transform, dims,
                                       math.prod(dims) // 30, planner))
    for support in ('bands', 'harmonics', 'progression'):
        for plan in ('sparse', 'auto', 'full'):
            rows.append(time_whole(arguments, cvol, 'speedup',
                                   (f'multiply, {plan}', 'multiply', support, plan), 'dft',
                                   [2 ** SAMPLES], 2 ** SAMPLES // 60 // 16 * 16))
    return rows


def describe_speedup(rows):
    columns = ['dims', 'transform', 'support', 'series', 'plan', "n'", 'planner'] + TIMES
    return ['## Products at rho = 1/30', '', markdown(columns, rows), '',
            "Low box: n' = N / 30 terms. Scattered: s = N / 60 terms and their places. The "
            'classical way keeps the same number: of a low box by copying it, of scattered terms '
            'by two passes over the magnitudes. FFTW has no DHT of several axes of this kind: DHT '
            'is compared with its DFT.', '']


# ---- volumes in blocks --------------------------------------------------------------------------

def block_inputs(arguments, folder):
    """Returns the table's label and two files (or None) of each pair of operands."""
    inputs = [('two smooth fields', [])]
    crops = {}
    for name in CROPPED:
        path = os.path.join(folder, name + '.raw')
        try:
            run([os.path.join(BENCH, 'algebra', 'crop.py'), name, str(arguments.side), path,
                 '--data', arguments.data])
            crops[name] = path
        except Failed as problem:
            say(f'{name} skipped: {problem}')
    if crops:
        mask = os.path.join(folder, 'mask.raw')
        run([os.path.join(BENCH, 'algebra', 'crop.py'), 'mask', str(arguments.side), mask])
    inputs += [(f'{name} and a mask', [path, mask]) for name, path in crops.items()]
    if len(crops) == 2:
        inputs.append((' and '.join(crops), list(crops.values())))
    return inputs


def block_rows(label, keep, planner, found):
    base = {'part': 'blocks', 'input': label, 'keep': keep}
    cvol, dense = min(found['multiply_ms']), min(found['dense_ms'])

    def row(what, times, note='', **more):
        return base | {'what': what, 'min ms': f'{min(times):.4g}',
                       'median ms': f'{statistics.median(times):.4g}', 'notes': note} | more
    arrays = [found[key] for key in ('a', 'b', 'product')]
    resident = ('terms ' + ', '.join(str(array['terms']) for array in arrays) + '; resident MB ' +
                ', '.join(f"{array['resident_bytes'] / 1e6:.2f}" for array in arrays))
    rows = [row('cvol multiply', found['multiply_ms'], resident,
                **{'PSNR dB': f"{found['psnr_db']:.2f}"}),
            row(f'FFTW multiply ({planner})', found['dense_ms'], 'whole array, low box of 1/30',
                **{'PSNR dB': f"{found['dense_psnr_db']:.2f}", 'over cvol': f'{dense / cvol:.2f}'})]
    rows += [row('cvol ' + what, found[key]) for what, key in
             (('add', 'add_ms'), ('statistics', 'statistics_ms'), ('inner product', 'inner_ms'),
              ('compare', 'compare_ms'))]
    for zfp in found.get('zfp', []):
        for way, key in (('iterators', 'iterators_ms'), ('indices', 'indices_ms'),
                         ('get, multiply, set', 'whole_ms')):
            rows.append(row(f"zfp, {zfp['rate']:g} bits/value, {way}", zfp[key],
                            **{'PSNR dB': f"{zfp['psnr_db']:.2f}",
                               'over cvol': f'{min(zfp[key]) / cvol:.2f}'}))
    return rows


def measure_blocks(arguments, cvol):
    rows = []
    with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
        for number, (label, files) in enumerate(block_inputs(arguments, folder)):
            for planner, keep in ([('estimate', 'rho'), ('measure', 'rho'), ('measure', 'codec')]
                                  if not number else [('measure', 'rho'), ('measure', 'codec')]):
                try:
                    found = run_json([program(cvol, 'algebra_blocks'), str(arguments.side),
                                      str(arguments.rounds), planner, keep] + files)
                except Failed as problem:
                    rows.append({'part': 'blocks', 'input': label, 'keep': keep,
                                 'notes': f'failed: {problem}'})
                    say(f'blocks, {label}, {keep}: failed: {problem}')
                    continue
                rows += block_rows(label, keep, planner, found)
                say(f"blocks, {label}, {keep}: multiply {min(found['multiply_ms']):.3g} ms, FFTW "
                    f"{min(found['dense_ms']):.3g} ms")
    return rows


def describe_blocks(arguments, rows):
    side = arguments.side
    return [f'## Volumes of {side}^3 in blocks of 16^3, one thread', '',
            markdown(['input', 'keep', 'what', 'min ms', 'median ms', 'over cvol', 'PSNR dB',
                      'notes'], rows), '',
            '`rho`: 1/30 of the terms; `codec`: what a file of 1/30 keeps. *Over cvol*: how many '
            "times as long as cvol's product. zfp's arrays hold at least one bit a value "
            '(ratio 32). `statistics` gives sum, mean, variance and norm; `compare` the inner product, '
            'distance, cosine and their bounds.', '']


# ---- main ---------------------------------------------------------------------------------------

def draw(arguments, rows):
    """Draws the plot in a separate process: this process must stay small."""
    path = os.path.join(arguments.results, 'algebra.png')
    os.makedirs(arguments.results, exist_ok=True)
    with tempfile.NamedTemporaryFile('w', suffix='.json', encoding='utf-8') as file:
        json.dump([row for row in rows if row['part'].startswith('against')], file)
        file.flush()
        try:
            run([os.path.join(BENCH, 'algebra', 'plot.py'), file.name, path])
            return [f'![times]({os.path.basename(path)})', '']
        except Failed as problem:
            say(f'no picture: {problem}')
            return []


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    parts = arguments.parts.split(',')
    unknown = [part for part in parts if part not in PARTS]
    if unknown:
        sys.exit(f"algebra.py: no such part: {', '.join(unknown)}")
    rows, lines = [], ['# Computing on compressed arrays', '']
    for part in parts:
        if part == 'theorems':
            found = measure_theorems(arguments, cvol)
            lines += describe_theorems(found) + draw(arguments, found)
        elif part == 'speedup':
            found = measure_speedup(arguments, cvol)
            lines += describe_speedup(found)
        elif part == 'blocks':
            found = measure_blocks(arguments, cvol)
            lines += describe_blocks(arguments, found)
        else:
            found, text = measure_volumes(arguments, cvol)
            lines += text
        rows += found
    lines += [f'{arguments.rounds} rounds; minima and medians of processor time; cvol in batches of '
              '2 ms or more over three pairs of operands, in turns with the classical way, so that '
              "each finds caches as the other left them. FFTW's plans are made beforehand, its buffers touched.", '']
    write_results(arguments.results, 'algebra',
                  '\n'.join(lines + [line + '  ' for line in provenance(cvol)]), rows)


if __name__ == '__main__':
    main()
