#!/usr/bin/python3
"""The error that sampling adds to pictures: engine sheet compared with the ray caster on the original samples.

For each volume, target, transfer function and light, over views around the volume (foreground PSNR in dB, median and
worst view):

  coding  engine ray at step 0.25 on the file, against engine ray at step 0.25 on the original samples
  CPU     engine sheet on the file with this instruction set, against the same reference

The difference of both is what sampling adds. Three transfer functions are fitted to the values of each volume: `soft`
(opacity up to 0.15), `opaque`, and `thin` (a peak of 0.8 over 4 % of the range). Synthetic volumes (seeds in this
file): shells of 1, 2 and 4 samples, vessels, the Marschner-Lobb signal, and noise. References stay in the scratch
folder until the volume changes.
"""
import argparse
import json
import os
import shutil
import statistics
import sys

import numpy

from tables import (Failed, add_common_arguments, check_cvol, markdown, plain_look, provenance, run, run_json, say,
                    write_results)
from volumes import BENCH, all_paths, folder_paths, raw_options, short_name

WORK = os.path.join(BENCH, 'scratch', 'error')
SIDE = 96
LOOKS = ('soft', 'opaque', 'thin')
MOST = 99  # dB, of equal pictures


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--volumes', default='', metavar='A,B', help='names; default: all, and the synthetic ones')
    parser.add_argument('--targets', default='--ratio 30', metavar='A;B',
                        help='of compress, as in --max-error 1%% (of the range) (default %(default)s)')
    parser.add_argument('--looks', default=','.join(LOOKS), metavar='A,B')
    parser.add_argument('--lights', default='unlit,lit', metavar='A,B')
    parser.add_argument('--cpus', default='avx512', metavar='A,B', help='of base, avx2, avx512 (default %(default)s)')
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--views', type=int, default=12)
    parser.add_argument('--options', default='', help='further options of engine sheet')
    parser.add_argument('--work', default=WORK, metavar='DIR', help='files and pictures (default %(default)s)')
    return parser.parse_args()


# ---- volumes ------------------------------------------------------------------------------------

def shells():
    z, y, x = numpy.meshgrid(*[numpy.linspace(-1, 1, SIDE)] * 3, indexing='ij')
    radius, step = numpy.sqrt(x * x + y * y + z * z), 2 / (SIDE - 1)
    return sum(numpy.exp(-((radius - r) / (w * step / 2)) ** 2) for r, w in ((.3, 1), (.55, 2), (.85, 4)))


def vessels():
    """Tubes with radii of 0.7 to 2.5 samples along random walks."""
    random, out = numpy.random.default_rng(5), numpy.zeros((SIDE,) * 3)
    grid = numpy.meshgrid(*[numpy.arange(13) - 6.0] * 3, indexing='ij')
    for _ in range(14):
        place, way = random.uniform(10, SIDE - 10, 3), random.normal(size=3)
        radius = random.choice([.7, 1, 1.5, 2.5])
        for _ in range(300):
            centre = numpy.rint(place).astype(int)
            if (centre < 6).any() or (centre > SIDE - 7).any():
                break
            box = tuple(slice(c - 6, c + 7) for c in centre)
            square = sum((g + c - p) ** 2 for g, c, p in zip(grid, centre, place))
            out[box] = numpy.maximum(out[box], numpy.exp(-square / radius ** 2))
            way = way / numpy.linalg.norm(way) + random.normal(size=3) * .12
            place = place + .6 * way / numpy.linalg.norm(way)
    return out


def marschner_lobb():
    z, y, x = numpy.meshgrid(*[numpy.linspace(-1, 1, SIDE)] * 3, indexing='ij')
    waves = numpy.cos(12 * numpy.pi * numpy.cos(numpy.pi * numpy.sqrt(x * x + y * y) / 2))
    return (1 - numpy.sin(numpy.pi * z / 2) + .25 * (1 + waves)) / 2.5


def noise():
    return numpy.random.default_rng(9).normal(size=(48, 48, 48))


SYNTHETIC = {'shells': shells, 'vessels': vessels, 'marschner_lobb': marschner_lobb, 'noise': noise}


def sources(arguments):
    """Returns name -> (path, options of the command) of the volumes that exist."""
    out = {short_name(path): (path, raw_options(path)) for path in all_paths(arguments.data)}
    out |= {os.path.basename(path): (path, []) for path in folder_paths(arguments.data)}
    for name, make in SYNTHETIC.items():
        path = os.path.join(arguments.work, name + '.npy')
        if not os.path.exists(path):
            samples = make()
            scaled = 255 * (samples - samples.min()) / numpy.ptp(samples)
            numpy.save(path, scaled.astype(numpy.float32 if name == 'marschner_lobb' else numpy.uint8))
        out[name] = (path, [])
    wanted = [name for name in arguments.volumes.split(',') if name] or list(out)
    unknown = [name for name in wanted if name not in out]
    if unknown:
        sys.exit(f"render_error.py: no such volume: {', '.join(unknown)}; there are {', '.join(out)}")
    return {name: out[name] for name in wanted}


def write_looks(cvol, name, source, work):
    """Writes a transfer function for each look; returns their paths."""
    paths = {look: os.path.join(work, f'{name}_{look}.json') for look in LOOKS}
    if all(os.path.exists(path) for path in paths.values()):
        return paths
    exact, samples = os.path.join(work, 'exact.cvol'), os.path.join(work, 'exact.npy')
    run([cvol, 'compress', source[0], exact, '--lossless'] + source[1])
    run([cvol, 'decompress', exact, samples])
    values = numpy.load(samples).astype(float).ravel()
    values = values[numpy.isfinite(values) & (numpy.abs(values) < 1e30)]
    os.remove(exact)
    os.remove(samples)
    low, span = values.min(), numpy.ptp(values)
    inside = values[values > low + .05 * span]
    a, b, c, d = (float(v) for v in numpy.percentile(inside, (20, 50, 80, 99)))
    b, c, d = max(b, a + 1e-3 * span), max(c, b + 2e-3 * span), max(d, c + 3e-3 * span)
    middle, half = float(numpy.percentile(inside, 60)), .02 * span
    points = {'soft': [[a, .2, .3, .8, 0], [b, .3, .8, .5, .03], [c, .9, .8, .3, .08], [d, 1, .9, .9, .15]],
              'opaque': [[a, .4, .2, .15, 0], [b, .8, .5, .3, .4], [c, .95, .8, .6, .95], [d, 1, 1, .95, 1]],
              'thin': [[middle - half, 1, .6, .2, 0], [middle, 1, .8, .3, .8], [middle + half, .4, .6, 1, 0]]}
    for look, path in paths.items():
        with open(path, 'w', encoding='ascii') as file:
            json.dump({'points': points[look]}, file)
    return paths


# ---- pictures -----------------------------------------------------------------------------------

def render(arguments, cvol, source, transfer, lit, folder, options, cpu=''):
    os.makedirs(folder, exist_ok=True)
    chosen = ['env', 'CVOL_CPU=' + cpu] if cpu else []
    run(chosen + [cvol, 'render', source[0], '-o', os.path.join(folder, 'view-{n}.png'), '--turntable',
         str(arguments.views), '--azimuth', '15', '--elevation', '20', '--size', str(arguments.size), '--transfer',
         transfer] + (['--shade'] if lit else []) + plain_look(['--shade'] if lit else []) + options + source[1])


def reference(arguments, cvol, source, transfer, lit, key):
    folder = os.path.join(arguments.work, 'reference', f'{key}_{arguments.size}_{arguments.views}')
    done = os.path.join(folder, 'done')
    if not os.path.exists(done):
        render(arguments, cvol, source, transfer, lit, folder, ['--engine', 'ray', '--step', '0.25'])
        with open(done, 'w', encoding='ascii'):
            pass
    return folder


def compare(cvol, a, b):
    names = sorted(name for name in os.listdir(a) if name.endswith('.png'))
    reports = [run_json([cvol, 'compare', os.path.join(a, name), os.path.join(b, name), '--json']) for name in names]
    return [MOST if report['psnr_foreground_db'] is None else min(report['psnr_foreground_db'], MOST)
            for report in reports]


def put(row, what, decibels):
    row[f'{what} dB'], row[f'{what} worst'] = f'{statistics.median(decibels):.1f}', f'{min(decibels):.1f}'


def options_of(cvol, name, source, target, work):
    """The options of a target; a share of the range, as in `--max-error 1%`, becomes a number."""
    if not target.endswith('%'):
        return target.split()
    option, share = target[:-1].split()
    exact = os.path.join(work, f'{name}_lossless.cvol')
    if not os.path.exists(exact):
        run([cvol, 'compress', source[0], exact, '--force', '--lossless'] + source[1])
    info = run_json([cvol, 'info', exact, '--json'])
    return [option, repr((info['max'] - info['min']) * float(share) / 100)]


def measure(arguments, cvol, name, source, target):
    tag = target.replace('--', '').replace(' ', '_').replace('%', '_percent')
    packed = os.path.join(arguments.work, f'{name}_{tag}.cvol')
    if not os.path.exists(packed):
        run([cvol, 'compress', source[0], packed, '--force']
            + options_of(cvol, name, source, target, arguments.work) + source[1])
    looks = write_looks(cvol, name, source, arguments.work)
    for look in arguments.looks.split(','):
        for light in arguments.lights.split(','):
            lit, key = light == 'lit', f'{name}_{look}_{light}'
            truth = reference(arguments, cvol, source, looks[look], lit, key)
            coded = reference(arguments, cvol, (packed, []), looks[look], lit, f'{key}_{tag}')
            row = {'volume': name, 'target': target, 'look': look, 'light': light}
            coding = compare(cvol, truth, coded)
            put(row, 'coding', coding)
            for cpu in arguments.cpus.split(','):
                folder = os.path.join(arguments.work, 'pictures')
                shutil.rmtree(folder, ignore_errors=True)
                render(arguments, cvol, (packed, []), looks[look], lit, folder, arguments.options.split(), cpu)
                decibels = compare(cvol, truth, folder)
                put(row, cpu, decibels)
                row[f'{cpu} adds'] = f'{statistics.median(coding) - statistics.median(decibels):.1f}'
            say(' '.join(row.values()))
            yield row


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    os.makedirs(arguments.work, exist_ok=True)
    rows = []
    try:
        for name, source in sources(arguments).items():
            for target in arguments.targets.split(';'):
                rows += measure(arguments, cvol, name, source, target)
    except Failed as problem:
        sys.exit(f'render_error.py: {problem}')
    text = '\n'.join(['# Error of sampling', '',
                      f'{arguments.size} x {arguments.size}, {arguments.views} views, PSNR over the foreground against '
                      'the original samples cast at step 0.25.', '', markdown(list(rows[0]), rows), '']
                     + [line + '  ' for line in provenance(cvol)])
    write_results(arguments.results, 'render_error', text, rows)


if __name__ == '__main__':
    main()
