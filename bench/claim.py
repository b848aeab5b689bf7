#!/usr/bin/python3
"""The paper's claim, measured: splatting on compressed transforms against splatting.

The CT of a head (cthead_8bit), resampled to N^3, seen from azimuth 15 and elevation 20, by three
transfer functions (thin, semi, opaque). Engine `splat` against engine `transform`: deferred and
literal, tiles of 16 and global slices.

 * time of a picture on one thread, the least of some after the first (what is made of slices once
   is not counted: column `bake_ms`);
 * PSNR of the picture against `splat --footprint-plane slices`, the same footprint with all terms,
   and against `splat` itself, whose footprint is round in the view.

The paper predicts O(N^3 f) against O(rho N^3 log N): column `predicted` is f^2 / (rho log2 N), which
the ratio of times should be proportional to.
"""
import argparse
import math
import os
import sys
import tempfile

from tables import (add_common_arguments, check_cvol, markdown, provenance, run, run_json, say,
                    write_results)
from volumes import rendered_path, transfer_path

VIEW = ['--azimuth', '15', '--elevation', '20']
LOOKS = ('thin', 'semi', 'opaque')
ENGINES = {
    'tiles deferred': ['--tile', '16'],
    'tiles literal': ['--tile', '16', '--schedule', 'literal'],
    'global deferred': ['--tile', '0'],
    'global literal': ['--spectrum', 'dft', '--schedule', 'literal'],
}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--sizes', default='64,128,256', metavar='N,N')
    parser.add_argument('--footprints', default='5,9,15,31', metavar='F,F')
    parser.add_argument('--rhos', default='0.1,0.03333,0.01', metavar='R,R')
    parser.add_argument('--engines', default=','.join(ENGINES), metavar='A,B')
    parser.add_argument('--repeat', type=int, default=6, help='pictures of splat, of which the '
                        'least time counts; four times as many of tiles, deferred')
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
    """The least time of a picture on one thread, after one that is not counted."""
    return run_json(scene['bench'] + options + ['--repeat', str(repeats)])['frame_ms']['min']


def scene_of(arguments, folder, size, look, footprint):
    volume = [os.path.join(folder, f'{size}.raw'), '--dims', f'{size}x{size}x{size}', '--type',
              'uint8', '--transfer', transfer_path('cthead_8bit', look), '--threads', '1',
              '--footprint-size', str(footprint)]
    return {'render': [arguments.cvol, 'render'] + volume + VIEW + ['--json'],
            'bench': [arguments.cvol, 'bench', 'render'] + volume +
                     ['--views', '1', '--json'], 'folder': folder}


def picture(scene, name, options):
    path = os.path.join(scene['folder'], name + '.png')
    return path, run_json(scene['render'] + ['-o', path] + options)


def psnr(arguments, a, b):
    value = run_json([arguments.cvol, 'compare', a, b, '--json'])['psnr_db']
    return math.inf if value is None else float(value)


def measure(arguments, folder, size, footprint):
    rows = []
    for look in LOOKS:
        scene = scene_of(arguments, folder, size, look, footprint)
        slices, _ = picture(scene, 'slices', ['--engine', 'splat', '--footprint-plane', 'slices'])
        view, _ = picture(scene, 'view', ['--engine', 'splat'])
        splat_ms = picture_ms(scene, ['--engine', 'splat'], arguments.repeat)
        for name in arguments.engines.split(','):
            for rho in arguments.rhos.split(','):
                options = ['--engine', 'transform', '--rho', rho] + ENGINES[name]
                path, told = picture(scene, 'transform', options)
                told = told['transform']
                slow = name != 'tiles deferred'
                took = picture_ms(scene, options, 1 if slow else 4 * arguments.repeat)
                rows.append({
                    'N': size, 'f': footprint, 'rho': rho, 'look': look, 'engine': name,
                    'splat_ms': round(splat_ms, 1), 'ms': round(took, 1),
                    'ratio': round(splat_ms / took, 2),
                    'predicted': round(footprint**2 / (float(rho) * math.log2(size))),
                    'psnr_db': round(psnr(arguments, slices, path), 1),
                    'psnr_view_db': round(psnr(arguments, view, path), 1),
                    'kept': round(told['rho'], 4), 'bound': f'{told["error_bound"]:.3g}',
                    'bake_ms': round(told['bake_ms']), 'step': told['step']})
                say(' '.join(str(v) for v in rows[-1].values()))
    return rows


def plot(rows, path):
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(1, 2, figsize=(10, 4))
    for engine in dict.fromkeys(row['engine'] for row in rows):
        for look, style in zip(LOOKS, ('-', '--', ':')):
            own = [r for r in rows if r['engine'] == engine and r['look'] == look]
            for axis, over, fixed in ((axes[0], 'f', 'N'), (axes[1], 'N', 'f')):
                values = [r[fixed] for r in own]
                at = max(values) if fixed == 'N' else (15 if 15 in values else max(values))
                rho = '0.03333' if any(r['rho'] == '0.03333' for r in own) else own[0]['rho']
                line = sorted((r[over], r['ratio']) for r in own
                              if r[fixed] == at and r['rho'] == rho)
                axis.loglog(*zip(*line), style, marker='.', label=f'{engine}, {look}')
                axis.set_xlabel(f'{"footprint, samples a side" if over == "f" else "N"} '
                                f'({fixed} = {at}, rho = {rho})')
    for axis in axes:
        axis.axhline(1, color='grey', linewidth=0.5)
        axis.set_ylabel('time of splat / time of transform')
    axes[0].legend(fontsize=6)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main():
    arguments = parse_arguments()
    arguments.cvol = check_cvol(arguments.cvol)
    sizes = [int(n) for n in arguments.sizes.split(',')]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        make_volumes(arguments, folder, sizes)
        for size in sizes:
            for footprint in (int(f) for f in arguments.footprints.split(',')):
                rows += measure(arguments, folder, size, footprint)
    text = '\n'.join(['# Splatting on compressed transforms against splatting', '',
                      markdown(list(rows[0]), rows), ''] + provenance(arguments.cvol))
    write_results(arguments.results, 'claim', text, rows)
    plot(rows, os.path.join(arguments.results, 'claim.png'))


if __name__ == '__main__':
    main()
