#!/usr/bin/python3
"""The paper's claim, measured: splatting on compressed transforms against splatting.

The CT of a head (cthead_8bit), resampled to N^3, seen from azimuth 15 and elevation 20, by three
transfer functions (thin, semi, opaque), in pictures of 2N x 2N, so that a footprint covers as many
pixels at every N. Engine `splat` against engine `transform`: deferred and literal, tiles of 16 and
global slices.

 * processor time of a picture on one thread, the least of some after the first (what is made of
   slices once is not counted: column `bake_ms`); both engines take turns;
 * PSNR of the picture against `splat --footprint-plane slices`, the same footprint with all terms;
   with --full also against `splat` itself, whose footprint is round in the view.

The paper predicts O(N^3 f) against O(rho N^3 log N): column `predicted` is f^2 / (rho log2 N), which
the ratio of times should be proportional to. Exponents are fitted to the rows of tiles, deferred.
Without --full there is one rho, and the other engines are measured at one size only.
"""
import argparse
import math
import os
import sys
import tempfile
import time

from tables import (Failed, add_common_arguments, check_cvol, markdown, provenance, run, run_json,
                    say, write_results)
from volumes import rendered_path, transfer_path

VIEW = ['--azimuth', '15', '--elevation', '20']
LOOKS = ('thin', 'semi', 'opaque')
TILES = 'tiles deferred'
ENGINES = {
    TILES: ['--tile', '16'],
    'tiles literal': ['--tile', '16', '--schedule', 'literal'],
    'global deferred': ['--tile', '0'],
    'global literal': ['--spectrum', 'dft', '--schedule', 'literal'],
}
RHO = '0.03333'
# Where one thing is varied, the others are these.
N_FIXED, F_FIXED = 256, 15
N_OTHERS = 128


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--sizes', default='64,128,256,384', metavar='N,N')
    parser.add_argument('--footprints', default='5,9,15,31', metavar='F,F')
    parser.add_argument('--rhos', default='0.1,0.03333,0.01', metavar='R,R')
    parser.add_argument('--full', action='store_true',
                        help='all engines and rhos at all sizes (hours)')
    parser.add_argument('--seconds', type=float, default=0.6,
                        help='of pictures of each engine in a turn (default %(default)s)')
    return parser.parse_args()


def resample(samples, numpy, axis, count):
    """Means of whole groups of samples, or straight lines between them."""
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


def make_volumes(arguments, folder, sizes):
    import numpy  # not above: what is measured begins with the memory of what measures
    packed, raw = os.path.join(folder, 'ct.cvol'), os.path.join(folder, 'ct.raw')
    about = run_json([arguments.cvol, 'info', rendered_path('cthead_8bit', arguments.data),
                      '--json'])
    run([arguments.cvol, 'compress', rendered_path('cthead_8bit', arguments.data), packed,
         '--lossless'])
    run([arguments.cvol, 'decompress', packed, raw])
    samples = numpy.fromfile(raw, numpy.uint8).reshape(about['dims'][::-1]).astype(numpy.float32)
    samples = resample(samples, numpy, 0, 256)
    for size in sizes:
        cube = samples
        for axis in range(3):
            cube = resample(cube, numpy, axis, size)
        numpy.rint(cube).astype(numpy.uint8).tofile(os.path.join(folder, f'{size}.raw'))


def picture_ms(scene, options, repeats):
    """The least processor time of a picture on one thread, after one that is not counted."""
    return run_json(scene['bench'] + options + ['--repeat', str(repeats)])['cpu_ms']


def scene_of(arguments, folder, size, look, footprint):
    volume = [os.path.join(folder, f'{size}.raw'), '--dims', f'{size}x{size}x{size}', '--type',
              'uint8', '--transfer', transfer_path('cthead_8bit', look), '--threads', '1',
              '--footprint-size', str(footprint), '--size', str(2 * size)]
    return {'render': [arguments.cvol, 'render'] + volume + VIEW + ['--json'],
            'bench': [arguments.cvol, 'bench', 'render'] + volume +
                     ['--views', '1', '--json'], 'folder': folder}


def picture(scene, name, options):
    path = os.path.join(scene['folder'], name + '.png')
    return path, run_json(scene['render'] + ['-o', path] + options)


def psnr(arguments, a, b):
    value = run_json([arguments.cvol, 'compare', a, b, '--json'])['psnr_db']
    return math.inf if value is None else float(value)


def cases(arguments, size, footprint):
    """Engines and rhos of one size and footprint."""
    rhos = arguments.rhos.split(',')
    if arguments.full:
        return [(name, rho) for name in ENGINES for rho in rhos]
    found = [(TILES, RHO)]
    if footprint == F_FIXED and size == N_FIXED:
        found += [(TILES, rho) for rho in rhos if rho != RHO]
    if footprint == F_FIXED and size == N_OTHERS:
        found += [(name, RHO) for name in ENGINES if name != TILES]
    return found


def repeats_in(seconds, took_ms):
    return max(1, min(60, int(1e3 * seconds / max(took_ms, 0.1))))


def take_turns(arguments, scene, options, splat_ms, ms):
    """The least times of both engines, in two turns; in one where a picture takes long."""
    best = [math.inf, math.inf]
    for _ in range(1 if splat_ms > 1500 or ms > 1500 else 2):
        for i, (engine, took) in enumerate(((['--engine', 'splat'], splat_ms), (options, ms))):
            best[i] = min(best[i], picture_ms(scene, engine, repeats_in(arguments.seconds, took)))
    return best


def measure(arguments, folder, size, footprint, look):
    rows = []
    scene = scene_of(arguments, folder, size, look, footprint)
    slices, told = picture(scene, 'slices', ['--engine', 'splat', '--footprint-plane', 'slices'])
    splat_ms = told['render_ms']
    view = picture(scene, 'view', ['--engine', 'splat'])[0] if arguments.full else None
    for name, rho in cases(arguments, size, footprint):
        options = ['--engine', 'transform', '--rho', rho] + ENGINES[name]
        path, told = picture(scene, 'transform', options)
        told = told['transform']
        splat, took = take_turns(arguments, scene, options, splat_ms, told['compose_ms'])
        row = {'N': size, 'f': footprint, 'rho': rho, 'look': look, 'engine': name,
               'splat_ms': round(splat, 1), 'ms': round(took, 1), 'ratio': round(splat / took, 2),
               'predicted': round(footprint**2 / (float(rho) * math.log2(size))),
               'psnr_db': round(psnr(arguments, slices, path), 1),
               'kept': round(told['rho'], 4), 'bound': f'{told["error_bound"]:.3g}',
               'bake_ms': round(told['bake_ms']), 'step': told['step']}
        if view:
            row['psnr_view_db'] = round(psnr(arguments, view, path), 1)
        say(' '.join(str(v) for v in row.values()))
        rows.append(row)
    return rows


# ---- what it comes to -------------------------------------------------------------------------

def slope(points):
    """Of the straight line nearest to the logarithms of pairs."""
    xs, ys = [[math.log(float(p[i])) for p in points] for i in (0, 1)]
    mean = sum(xs) / len(xs), sum(ys) / len(ys)
    return (sum((x - mean[0]) * (y - mean[1]) for x, y in zip(xs, ys)) /
            sum((x - mean[0]) ** 2 for x in xs))


def line_of(rows, look, over, values):
    """Rows of tiles, deferred, in which only `over` varies."""
    fixed = {'N': N_FIXED, 'f': F_FIXED, 'rho': RHO}
    del fixed[over]
    return sorted(((float(row[over]), [row[v] for v in values]) for row in rows
                   if row['engine'] == TILES and row['look'] == look and
                   all(str(row[key]) == str(value) for key, value in fixed.items())))


def exponents(rows):
    for over in ('N', 'f', 'rho'):
        for look in LOOKS:
            line = line_of(rows, look, over, ('splat_ms', 'ms', 'ratio', 'predicted'))
            if len(line) < 2:
                continue
            fit = [slope([(x, values[i]) for x, values in line]) for i in range(4)]
            yield {'time as a power of': over, 'look': look} | {
                name: f'{value:.2f}' for name, value in
                zip(('splat', 'transform', 'ratio', 'ratio predicted'), fit)}


def summary(rows):
    """Ratios of tiles, deferred: a row for each N, a column for each f, thin / semi / opaque."""
    sizes, footprints = ([*dict.fromkeys(row[key] for row in rows)] for key in ('N', 'f'))
    ratio = {(row['N'], row['f'], row['look']): row['ratio'] for row in rows
             if row['engine'] == TILES and row['rho'] == RHO}
    for size in sizes:
        row = {'N': size}
        for f in footprints:
            found = [ratio.get((size, f, look)) for look in LOOKS]
            row[f'{f} x {f}'] = ' / '.join('-' if r is None else f'{r:.0f}' if r >= 10 else
                                           f'{r:.1f}' for r in found)
        yield row


def plot(rows, path):
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(1, 3, figsize=(11, 3.6))
    names = {'N': f'N (f = {F_FIXED}, rho = 1/30)', 'f': f'f, footprint f x f (N = {N_FIXED})',
             'rho': f'rho (N = {N_FIXED}, f = {F_FIXED})'}
    for axis, over in zip(axes, names):
        for look, colour in zip(LOOKS, ('tab:blue', 'tab:green', 'tab:red')):
            line = line_of(rows, look, over, ('ratio', 'predicted'))
            if not line:
                continue
            xs = [x for x, _ in line]
            axis.loglog(xs, [v[0] for _, v in line], color=colour, marker='.', label=look)
            if look == 'semi':  # the paper's, through the first point
                scale = line[0][1][0] / line[0][1][1]
                axis.loglog(xs, [scale * v[1] for _, v in line], ':', color='grey',
                            label='predicted growth')
            axis.set_xticks(xs, [f'{x:g}' for x in xs])
            axis.minorticks_off()
        axis.set_xlabel(names[over])
        axis.grid(alpha=0.3)
    axes[0].set_ylabel('time of splat / time of transform')
    axes[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=90)


def main():
    arguments = parse_arguments()
    arguments.cvol = check_cvol(arguments.cvol)
    start, rows = time.monotonic(), []
    if not os.path.exists(rendered_path('cthead_8bit', arguments.data)):
        say('claim.py: skipped: cthead_8bit is not in the data folder')
        return
    try:
        with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
            sizes = [int(n) for n in arguments.sizes.split(',')]
            make_volumes(arguments, folder, sizes)
            for size in sizes:
                for footprint in (int(f) for f in arguments.footprints.split(',')):
                    for look in LOOKS:
                        rows += measure(arguments, folder, size, footprint, look)
    except Failed as problem:
        sys.exit(f'claim.py: {problem}')
    short, fits = list(summary(rows)), list(exponents(rows))
    columns = list(dict.fromkeys(key for row in rows for key in row))
    text = '\n'.join(
        ['# Splatting on compressed transforms against splatting', '',
         'Processor time of splat over that of transform (tiles of 16, deferred, rho 1/30), one '
         'thread, thin / semi / opaque:', '', markdown(list(short[0]), short), ''] +
        ([markdown(list(fits[0]), fits), ''] if fits else []) +
        [markdown(columns, rows), '', f'{time.monotonic() - start:.0f} s.  '] +
        provenance(arguments.cvol))
    write_results(arguments.results, 'claim', text, rows)
    plot(rows, os.path.join(arguments.results, 'claim.png'))


if __name__ == '__main__':
    main()
