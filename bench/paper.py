#!/usr/bin/python3
"""Measures the paper's claim: splatting on compressed transforms compared with splatting.

The CT of a head (cthead_8bit), resampled to N^3, with three transfer functions (thin, semi, opaque), and the signal
of Marschner and Lobb; from azimuth 15 and elevation 20, in pictures of 2N x 2N, so that a footprint covers the same
number of pixels at every N. Engines: `splat --footprint-plane slices`, which draws the same picture; `transform`, deferred and literal, in tiles of 16 and of whole slices
(deferred DCT, literal DFT); `sheet`, on a file of ratio 30, with its own footprint (linear, for every f); and
build/bench/separable, the deferred engine without transforms: a splatter with separable footprints, on dense slices.
Measured are:

 * processor time of a picture on one thread, the least of several after a first one, which is not counted (work done
   once per slice is in column `bake_ms`); splat and the other engine alternate. Splat classifies the samples in each
   picture; transform and separable keep classified slices, so their ratio, `of_transforms`, has that on neither side;
 * PSNR of the picture against that of splat, the same footprint with all terms;
 * counted multiply-adds of both, of footprints, tiles and compositing, without the last warp; for whole slices and the
   literal schedule by formula (include/cvol/engines.h).

The paper predicts O(N^3 f^2) against O(rho N^3 log N): column `predicted` is f^2 / (rho log2 N), and the ratio of
times should be proportional to it. Results: paper.md, .csv and .png.

The short form (minutes) has all N to 256 and all f for one transfer function; all three transfer functions with one
of N, f and rho varied; N = 512 once; and the slow engines at small N. --full measures all combinations (hours).
"""
import argparse
import math
import os
import sys
import tempfile
import time

import paper_report
from paper_volumes import LOOKS, SIGNAL, head_is_there, make_volumes, volume_of
from tables import Failed, add_common_arguments, check_cvol, run, run_json, say
from paper_report import F_FIXED, N_FIXED, RHO, TILES

VIEW = ['--azimuth', '15', '--elevation', '20', '--fit', 'box', '--light', 'flat']
SHEET = 'sheet'
ENGINES = {
    TILES: ['--tile', '16'],
    'literal': ['--tile', '16', '--schedule', 'literal'],
    'deferred, whole slices': ['--tile', '0'],
    'literal, whole slices': ['--spectrum', 'dft', '--schedule', 'literal'],
}
RHOS = ('0.1', RHO, '0.01')
# Pictures that take longer than this are timed once.
SLOW_MS = 1500
# The largest time for N = 512.
LARGE, LARGE_GB = 512, 8


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--sizes', default='64,128,256,512', metavar='N,N')
    parser.add_argument('--footprints', default='3,5,9,15,21', metavar='F,F')
    parser.add_argument('--full', action='store_true', help='all of it (hours)')
    parser.add_argument('--seconds', type=float, default=0.3,
                        help='of pictures of each engine in a turn (default %(default)s)')
    return parser.parse_args()


# ---- plan ---------------------------------------------------------------------------------------

def quick_engines(size, footprint, look):
    """Returns pairs of engine and rho for one size, footprint and look."""
    plain = look == 'semi'
    across = footprint == F_FIXED or size == N_FIXED
    if size > N_FIXED:
        return [(TILES, RHO), (SHEET, '')] if plain and footprint == F_FIXED else []
    if look == SIGNAL:
        across = footprint == F_FIXED or size == 128
    found = [(TILES, RHO)] if plain or across else []
    if footprint != F_FIXED:
        return found
    if size == N_FIXED or (look == SIGNAL and size == 128):
        found += [(TILES, rho) for rho in RHOS if rho != RHO]
    if size == 64:
        found += [('literal', rho) for rho in (RHOS if plain else (RHO,))]
    if plain:
        found += [(name, RHO) for name in ENGINES if (name, RHO) not in found]
    if plain or look == SIGNAL:
        found += [(SHEET, '')]
    return found


def cases(arguments, size, footprint, look):
    if arguments.full:
        return [(name, rho) for name in ENGINES for rho in RHOS] + [(SHEET, '')]
    return quick_engines(size, footprint, look)


def has_memory(size):
    with open('/proc/meminfo', encoding='ascii') as file:
        free = {line.split(':')[0]: int(line.split()[1]) for line in file}['MemAvailable']
    return size < LARGE or free / 1024 ** 2 >= LARGE_GB


# ---- one scene ----------------------------------------------------------------------------------

class Scene:
    """A volume, a look and a footprint, as arguments of the command."""

    def __init__(self, cvol, folder, raw, look, footprint):
        self.cvol, self.folder, self.raw = cvol, folder, raw
        self.name = os.path.splitext(os.path.basename(raw[0]))[0]
        self.look = look + ['--threads', '1', '--json']
        self.footprint = ['--footprint-size', str(footprint)]
        self.sheet_adds = ''

    def packed(self):
        """Returns the same for a file of ratio 30, for engine sheet."""
        path = os.path.join(self.folder, self.name + '.cvol')
        if not os.path.exists(path):
            run([self.cvol, 'compress', self.raw[0], path] + self.raw[1:] + ['--ratio', '30', '--fast'])
        return [path]

    def options(self, engine, rho):
        """Returns input and options of one engine."""
        if engine == 'splat':
            return self.raw + ['--engine', 'splat', '--footprint-plane', 'slices'] + self.footprint
        if engine == SHEET:
            return self.packed() + ['--engine', 'sheet']
        return (self.raw + ['--engine', 'transform', '--rho', rho] + ENGINES[engine] +
                self.footprint)

    def picture(self, engine, rho=''):
        path = os.path.join(self.folder, ('splat' if engine == 'splat' else 'other') + '.png')
        report = run_json([self.cvol, 'render'] + self.options(engine, rho) + self.look + VIEW +
                          ['-o', path])
        return path, report

    def cpu_ms(self, engine, rho, repeats):
        """Returns the least processor time of a picture on one thread, after one that is not counted."""
        report = run_json([self.cvol, 'bench', 'render'] + self.options(engine, rho) + self.look +
                          ['--views', '1', '--repeat', str(repeats)])
        self.sheet_adds = report.get('multiply_adds', self.sheet_adds)
        return report['cpu_ms']

    def psnr(self, a, b):
        value = run_json([self.cvol, 'compare', a, b, '--json'])['psnr_db']
        return math.inf if value is None else float(value)


def cube_scene(arguments, folder, size, look, footprint):
    raw, transfer = volume_of(folder, size, look)
    return Scene(arguments.cvol, folder, [raw, '--dims', f'{size}x{size}x{size}', '--type', 'uint8'],
                 ['--transfer', transfer, '--size', str(2 * size)], footprint)


def separable_ms(arguments, scene, size, footprint, took):
    """Returns the least processor time of the separable splatter; None where it was not built."""
    program = os.path.join(os.path.dirname(arguments.cvol), 'bench', 'separable')
    if not os.path.exists(program):
        return None
    repeats = max(1, min(60, int(1e3 * arguments.seconds / took)))
    transfer = scene.look[scene.look.index('--transfer') + 1]
    return run_json([program, scene.raw[0], scene.raw[2], transfer, str(2 * size), str(footprint), str(repeats),
                     os.path.join(scene.folder, 'separable.png')])['cpu_ms']


def take_turns(arguments, scene, engine, rho, took):
    """Returns the least times of splat and of an engine, in two alternating rounds, or in one if a picture is slow.
    took: milliseconds of an earlier picture of each."""
    best = [math.inf, math.inf]
    for _ in range(1 if max(took) > SLOW_MS else 2):
        for i, name in enumerate(('splat', engine)):
            repeats = max(1, min(60, int(1e3 * arguments.seconds / max(took[i], 0.1))))
            best[i] = min(best[i], scene.cpu_ms(name, rho, repeats))
    return best


def measure(arguments, folder, size, footprint, look):
    wanted = cases(arguments, size, footprint, look)
    if not wanted:
        return
    scene = cube_scene(arguments, folder, size, look, footprint)
    truth, report = scene.picture('splat')
    splat_adds, splat_ms = report['splat']['multiply_adds'], report['render_ms']
    separable = separable_ms(arguments, scene, size, footprint, splat_ms)
    for engine, rho in wanted:
        path, report = scene.picture(engine, rho)
        of_slices = report.get('transform')
        took = of_slices['compose_ms'] if of_slices else report['render_ms']
        splat, own = take_turns(arguments, scene, engine, rho, (splat_ms, took))
        row = {'N': size, 'f': footprint, 'rho': rho, 'look': look, 'engine': engine,
               'splat_ms': round(splat, 1), 'ms': round(own, 1), 'ratio': round(splat / own, 2),
               'psnr_db': round(scene.psnr(truth, path), 1), 'splat_multiply_adds': splat_adds}
        if engine == SHEET:
            row['multiply_adds'] = scene.sheet_adds
        if of_slices:
            row |= {'predicted': round(footprint**2 / (float(rho) * math.log2(size))),
                    'multiply_adds': of_slices['multiply_adds'],
                    'kept': round(of_slices['rho'], 4),
                    'bound': '' if of_slices['error_bound'] is None else f'{of_slices["error_bound"]:.3g}',
                    'bake_ms': round(of_slices['bake_ms']), 'step': of_slices['step']}
        if separable and engine == TILES:
            row |= {'separable_ms': round(separable, 1), 'of_transforms': round(separable / own, 2)}
        say(' '.join(f'{key} {value}' for key, value in row.items() if value != ''))
        yield row


def main():
    arguments = parse_arguments()
    arguments.cvol = check_cvol(arguments.cvol)
    start, rows = time.monotonic(), []
    if not head_is_there(arguments):
        say('paper.py: skipped: cthead_8bit is not in the data folder')
        return
    sizes = [int(n) for n in arguments.sizes.split(',')]
    footprints = [int(f) for f in arguments.footprints.split(',')]
    skipped = [size for size in sizes if not has_memory(size)]
    sizes = [size for size in sizes if size not in skipped]
    try:
        with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
            make_volumes(arguments, folder, sizes)
            for size in sizes:
                for footprint in footprints:
                    for look in LOOKS + (SIGNAL,):
                        rows += measure(arguments, folder, size, footprint, look)
    except Failed as problem:
        sys.exit(f'paper.py: {problem}')
    paper_report.write(arguments, rows, skipped, time.monotonic() - start)


if __name__ == '__main__':
    main()
