#!/usr/bin/python3
"""Rate and distortion: cvol compared with zfp (accuracy mode) on every volume, at six rates each.

cvol compresses to the rates (bits per voxel of the whole file); `cvol compare` measures the file. zfp's curve is
measured on the same samples as float32, at tolerances that are the range times a power of two; its bits at cvol's
PSNR are interpolated (logarithm of bits over dB). Rows with a PSNR outside zfp's curve are not compared.
"""
import argparse
import json
import math
import os
import tempfile
import time

from tables import (Failed, add_common_arguments, check_cvol, markdown, provenance, run, run_json,
                    say, unfolded, write_results)
from volumes import BENCH, all_paths, folder_paths, raw_options, short_name

RATES = tuple(0.03 * (4 / 0.03) ** (k / 5) for k in range(6))  # evenly spaced logarithms
TOLERANCES = 24
EXACT = 999  # stands for an infinite PSNR
BITS = {'uint8': 8, 'int8': 8, 'uint16': 16, 'int16': 16, 'uint32': 32, 'int32': 32,
        'float32': 32, 'float64': 64}
LEFT_OUT = {'ocean_v': 'land is marked with 1e35, and PSNR is over the range'}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--volumes', metavar='A,B', help='names without ending (default all)')
    parser.add_argument('--threads', type=int, default=1, help="cvol's (default 1)")
    return parser.parse_args()


def zfp_curve(tool, dims, path):
    """Returns [(bits per voxel, dB)] in rising order."""
    points = run_json([tool] + [str(n) for n in dims] + [path, str(TOLERANCES)])
    samples = math.prod(dims)
    return [(8 * point['bytes'] / samples, point['psnr_db']) for point in points
            if point['psnr_db'] is not None]


def bits_at(curve, decibels):
    """Returns bits per voxel at a PSNR, interpolated; None outside the curve."""
    for (low_bits, low), (high_bits, high) in zip(curve, curve[1:]):
        if low <= decibels <= high and high > low:
            part = (decibels - low) / (high - low)
            return math.exp((1 - part) * math.log(low_bits) + part * math.log(high_bits))
    return None


def measure_rate(arguments, cvol, path, about, rate, packed):
    ratio = BITS[about['type']] / rate
    begin = time.perf_counter()
    said = run_json([cvol, 'compress', path, packed, '--ratio', f'{ratio:.6g}', '--json',
                     '--threads', str(arguments.threads)] + raw_options(path))
    seconds = time.perf_counter() - begin
    measured = run_json([cvol, 'compare', path, packed, '--json'] + raw_options(path))
    return {'bits': 8 * said['file_bytes'] / math.prod(about['dims']),
            'psnr': measured['psnr_db'], 'seconds': seconds}


def measure_volume(arguments, cvol, tool, path, folder):
    name = short_name(path)
    raw, packed = (os.path.join(folder, 'volume.' + ending) for ending in ('raw', 'cvol'))
    about = run_json([os.path.join(BENCH, 'volumes.py'), path, raw, '--stored'])
    run([os.path.join(BENCH, 'rd', 'to_float.py'), raw, about['type']])
    curve = zfp_curve(tool, about['dims'], raw)
    rows = []
    for rate in RATES:
        if rate > BITS[about['type']] / 1.5:
            continue
        row = {'volume': name, 'dims': 'x'.join(map(str, about['dims'])), 'type': about['type'],
               'rate': round(rate, 4)}
        try:
            found = measure_rate(arguments, cvol, path, about, rate, packed)
        except Failed as problem:
            rows.append(row | {'notes': f'failed: {problem}'})
            say(f'{name} {rate}: failed: {problem}')
            continue
        row |= {'cvol bits': f"{found['bits']:.4f}", 'seconds': f"{found['seconds']:.2f}"}
        if found['psnr'] is None or found['psnr'] >= EXACT:
            rows.append(row | {'PSNR dB': 'exact'})
            continue
        theirs = bits_at(curve, float(found['psnr']))
        row |= {'PSNR dB': f"{found['psnr']:.3f}"}
        if theirs:
            row |= {'zfp bits': f'{theirs:.4f}', 'zfp/cvol': f"{theirs / found['bits']:.3f}"}
        rows.append(row)
        say(f"{name} {rate}: {found['bits']:.4f} bits, {found['psnr']:.2f} dB, zfp "
            f"{theirs or float('nan'):.4f} bits")
    return rows, curve


def geometric_mean(values):
    return math.exp(sum(map(math.log, values)) / len(values)) if values else float('nan')


def summary(rows):
    """Returns zfp's bits divided by cvol's at equal PSNR, per volume and overall."""
    lines = []
    for name in list(dict.fromkeys(row['volume'] for row in rows)) + ['all']:
        factors = [float(row['zfp/cvol']) for row in rows
                   if 'zfp/cvol' in row and name in (row['volume'], 'all')]
        if factors:
            lines.append({'volume': name, 'zfp/cvol': f'{geometric_mean(factors):.3f}',
                          'from': f'{min(factors):.2f}', 'to': f'{max(factors):.2f}',
                          'rates': len(factors)})
    return lines


def draw(arguments, rows, curves):
    """Draws the plot in a separate process: this process must stay small."""
    path = os.path.join(arguments.results, 'rd.png')
    os.makedirs(arguments.results, exist_ok=True)
    with tempfile.NamedTemporaryFile('w', suffix='.json', encoding='utf-8') as file:
        json.dump({'rows': rows, 'curves': curves}, file)
        file.flush()
        try:
            run([os.path.join(BENCH, 'rd', 'plot.py'), file.name, path])
            return [f'![rates]({os.path.basename(path)})', '']
        except Failed as problem:
            say(f'no picture: {problem}')
            return []


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    tool = os.path.join(os.path.dirname(cvol), 'bench', 'zfp_curve')
    if not os.access(tool, os.X_OK):
        raise SystemExit(f'{tool}: not built; configure with -DCVOL_BENCH=ON, with libzfp-dev')
    wanted = arguments.volumes.split(',') if arguments.volumes else None
    rows, curves, left_out = [], {}, []
    with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
        for path in all_paths(arguments.data) + folder_paths(arguments.data):
            name = short_name(path)
            if wanted and name not in wanted:
                continue
            if name in LEFT_OUT:
                left_out.append(f'{name} is left out: {LEFT_OUT[name]}.')
                continue
            try:
                found, curves[name] = measure_volume(arguments, cvol, tool,
                                                      unfolded(cvol, path, folder), folder)
                rows += found
            except Failed as problem:
                left_out.append(f'{name} failed: {problem}.')
                say(left_out[-1])
    columns = ['volume', 'dims', 'type', 'rate', 'cvol bits', 'PSNR dB', 'zfp bits', 'zfp/cvol',
               'seconds', 'notes']
    text = ['# Rate and distortion', '',
            "zfp's bits over cvol's at equal PSNR, geometric means:", '',
            markdown(['volume', 'zfp/cvol', 'from', 'to', 'rates'], summary(rows)), '']
    text += draw(arguments, rows, curves)
    text += [markdown(columns, rows), '', 'Bits a voxel are of whole files. ' + ' '.join(left_out),
             '']
    write_results(arguments.results, 'rd',
                  '\n'.join(text + [line + '  ' for line in provenance(cvol)]), rows)


if __name__ == '__main__':
    main()
