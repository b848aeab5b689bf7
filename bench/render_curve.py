#!/usr/bin/python3
"""Milliseconds per picture against PSNR: cvol and VTK's CPU ray caster, each also with faster settings.

For each volume and look cvol renders files of ratio 30 and of 70 dB. The first also with samples between slices,
with one sheet for every two slices, in object order, with fewer or more rays, at all levels, and many of these with
the block cache. VTK renders the original samples with one ray per pixel and one sample per voxel, then with rays or
samples twice as far apart, or both, and means of 2^3 and 4^3 samples. Each system is compared with its own
reference, four times as many samples along every ray: PSNR over the foreground, the median view. Times are of one
thread, the best of the rounds; all settings alternate.

"VTK/cvol" of a setting of VTK: its time divided by that of the fastest setting of cvol whose pictures have at least
the same PSNR.
"""
import argparse
import os
import shutil
import statistics
import sys
import tempfile

from render_speed import look_options
from tables import (Failed, add_common_arguments, check_cvol, markdown, plain_look, provenance, run_json, say,
                    write_results)
from timing import have_vtk, time_vtk
from volumes import BENCH, RENDERED, USUAL, rendered_path

OURS = [('1/30', 'r30', []), ('70 dB', 'p70', []), ('step 0.5', 'r30', ['--step', '0.5']),
        ('step 2', 'r30', ['--step', '2']), ('object order', 'r30', ['--ray-order', 'object']),
        ('step 4', 'r30', ['--ray-order', 'object', '--step', '4']),
        ('rays 0.67', 'r30', ['--oversample', '0.67']),
        ('step 4, rays 0.67', 'r30', ['--step', '4', '--oversample', '0.67']),
        ('step 4, rays 0.5', 'r30', ['--step', '4', '--oversample', '0.5'])]


def kept(file, which, options):
    """A setting with the block cache, named after its options."""
    words = {'--ray-order': 'order ', '--level': 'level ', '--oversample': 'rays ', '--step': 'step '}
    name = ', '.join(words[o] + v for o, v in zip(options[::2], options[1::2]))
    return (', '.join(filter(None, (file, name, 'kept'))), which, options + ['--keep-mb', '1000'])


OBJECT_ORDER, LEVEL = ['--ray-order', 'object'], ['--level', '1']
OURS += [kept('1/30', 'r30', []), kept('70 dB', 'p70', [])]
OURS += [kept('', 'r30', OBJECT_ORDER + more)
         for more in ([], ['--oversample', '1.4', '--step', '0.7'], ['--step', '0.7'],
                      ['--oversample', '1.3'], ['--oversample', '0.75'], ['--oversample', '0.6'],
                      ['--oversample', '0.51'], ['--oversample', '0.6', '--step', '2'],
                      ['--oversample', '0.51', '--step', '2'], ['--oversample', '0.51', '--step', '4'],
                      ['--oversample', '0.25', '--step', '4'])]
OURS += [kept('70 dB', 'p70', OBJECT_ORDER + more)
         for more in ([], ['--oversample', '0.85'], ['--oversample', '0.51'])]
OURS += [kept('', 'r30', LEVEL + more)
         for more in ([], ['--oversample', '2'], ['--oversample', '1.5'], ['--oversample', '0.9'],
                      ['--oversample', '0.6'], ['--step', '1'])]
OURS += [kept('70 dB', 'p70', LEVEL + ['--oversample', rays]) for rays in ('2.5', '1.5')]
OURS += [(f'level {level}', 'r30', ['--level', str(level)]) for level in (1, 2, 3)]
THEIRS = [('step 1', []), ('step 2', ['--step', '2']), ('rays 2', ['--image-step', '2']),
          ('rays 2, step 2', ['--image-step', '2', '--step', '2']),
          ('means of 2^3', ['--shrink', '2']), ('means of 4^3', ['--shrink', '4']),
          ('means of 2^3, rays 2', ['--shrink', '2', '--image-step', '2'])]
TRUTH_STEP = '0.25'


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--volumes', default=','.join(USUAL), metavar='A,B',
                        help=f"of {', '.join(RENDERED)} (default %(default)s)")
    parser.add_argument('--looks', default='semi,opaque,semi-lit', metavar='A,B',
                        help='transfer functions, with -lit lit (default %(default)s)')
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--views', type=int, default=3)
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--no-vtk', action='store_true', help='cvol alone')
    return parser.parse_args()


def picture(folder, view):
    return os.path.join(folder, f'view_{view:02d}.png')


def median_psnr(arguments, cvol, truth, folder):
    return statistics.median(
        run_json([cvol, 'compare', picture(truth, view), picture(folder, view),
                  '--json'])['psnr_foreground_db'] for view in range(arguments.views))


def render_views(arguments, cvol, source, folder, options):
    os.makedirs(folder)
    for view in range(arguments.views):
        run_json([cvol, 'render', source, '-o', picture(folder, view), '--size',
                  str(arguments.size), '--azimuth', repr(15 + 360 * view / arguments.views),
                  '--elevation', '20', '--json'] + options + plain_look(options))
    return folder


def measure_ours(arguments, cvol, work, name, look, packed, times):
    options = look_options(name, look)
    truth = render_views(arguments, cvol, rendered_path(name, arguments.data),
                         os.path.join(work, 'truth'),
                         options + ['--engine', 'ray', '--step', TRUTH_STEP])
    rows = []
    for setting, which, ways in OURS:
        folder = render_views(arguments, cvol, packed[which], os.path.join(work, setting.replace('/', '_')),
                              options + ways)
        rows.append({'volume': name, 'look': look, 'system': 'cvol', 'setting': setting,
                     'ms': times['cvol', setting],
                     'dB': median_psnr(arguments, cvol, truth, folder)})
    return rows


def measure_theirs(arguments, cvol, work, name, look, raw, about, times):
    def views(folder, options):
        time_vtk(raw, about, look_options(name, look) + options +
                 ['--size', str(arguments.size), '--views', str(arguments.views), '--repeat', '1',
                  '--threads', '2', '--png', folder])
        return folder
    truth = views(os.path.join(work, 'vtk_truth'), ['--step', TRUTH_STEP])
    return [{'volume': name, 'look': look, 'system': 'VTK', 'setting': setting,
             'ms': times['VTK', setting],
             'dB': median_psnr(arguments, cvol, truth,
                               views(os.path.join(work, 'vtk_' + setting), options))}
            for setting, options in THEIRS]


def time_all(arguments, cvol, name, look, packed, raw, about):
    """Returns {(system, setting): milliseconds}, the best of alternating rounds."""
    shared = look_options(name, look) + ['--size', str(arguments.size), '--views',
                                         str(arguments.views), '--repeat', '3', '--threads', '1']
    times = {}
    for _ in range(arguments.rounds):
        for setting, which, ways in OURS:
            took = run_json([cvol, 'bench', 'render', packed[which], '--json'] + ways + shared)['frame_ms']['median']
            times['cvol', setting] = min(took, times.get(('cvol', setting), took))
        for setting, options in THEIRS if about else []:
            took = time_vtk(raw, about, shared + options)['frame_ms']['median']
            times['VTK', setting] = min(took, times.get(('VTK', setting), took))
    return times


def measure(arguments, cvol, vtk, name):
    source, rows = rendered_path(name, arguments.data), []
    with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
        packed = {}
        for which, options in (('r30', ['--ratio', '30']), ('p70', ['--psnr', '70'])):
            packed[which] = os.path.join(folder, which + '.cvol')
            run_json([cvol, 'compress', source, packed[which], '--json'] + options)
        raw = os.path.join(folder, name + '.raw')
        about = run_json([os.path.join(BENCH, 'volumes.py'), source, raw]) if vtk else None
        for look in arguments.looks.split(','):
            work = os.path.join(folder, 'pictures')
            times = time_all(arguments, cvol, name, look, packed, raw, about)
            ours = measure_ours(arguments, cvol, work, name, look, packed, times)
            theirs = measure_theirs(arguments, cvol, work, name, look, raw, about,
                                    times) if vtk else []
            shutil.rmtree(work)
            for row in theirs:
                as_close = [o['ms'] for o in ours if o['dB'] >= row['dB']]
                row['VTK/cvol'] = row['ms'] / min(as_close) if as_close else None
            rows += ours + theirs
            for row in ours + theirs:
                say(f"{name} {look} {row['system']} {row['setting']}: {row['ms']:.1f} ms, "
                    f"{row['dB']:.1f} dB")
    return rows


def plot(rows, path):
    try:
        import matplotlib
    except ImportError:
        say('no plot: this Python has no matplotlib (Debian: python3-matplotlib)')
        return
    matplotlib.use('Agg')
    from matplotlib import pyplot
    kinds = list(dict.fromkeys((row['volume'], row['look']) for row in rows))
    looks = list(dict.fromkeys(look for _, look in kinds))
    volumes = list(dict.fromkeys(volume for volume, _ in kinds))
    figure, axes = pyplot.subplots(len(volumes), len(looks), squeeze=False,
                                   figsize=(4 * len(looks), 2.8 * len(volumes)))
    for volume, look in kinds:
        axis = axes[volumes.index(volume)][looks.index(look)]
        for system, mark in (('cvol', 'o-'), ('VTK', 's')):
            points = sorted((row['ms'], row['dB'], row['setting']) for row in rows if
                            (row['volume'], row['look'], row['system']) == (volume, look, system))
            points = [p for p in points if p[2] != '70 dB'] if system == 'cvol' else points
            axis.plot([p[0] for p in points], [p[1] for p in points], mark, label=system)
        axis.set(xscale='log', title=f'{volume}, {look}', xlabel='ms a picture', ylabel='dB')
        axis.grid(True, which='both', alpha=0.3)
        axis.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=90)


def least_ratios(rows):
    """Returns the ratios of each volume and look, over VTK's settings."""
    kinds = dict.fromkeys((row['volume'], row['look']) for row in rows if row['system'] == 'VTK')
    result = []
    for kind in kinds:
        theirs = [row for row in rows if row['system'] == 'VTK' and (row['volume'], row['look']) == kind]
        known = sorted((row['VTK/cvol'], row['setting']) for row in theirs if row['VTK/cvol'])
        result.append({'volume': kind[0], 'look': kind[1],
                       'least': f'{known[0][0]:.1f}' if known else '',
                       'where': known[0][1] if known else '',
                       'median': f'{statistics.median(r for r, _ in known):.1f}' if known else '',
                       'none as close': '; '.join(row['setting'] for row in theirs if not row['VTK/cvol'])})
    return result


def describe(arguments, cvol, rows, skipped):
    table = [row | {'ms': f"{row['ms']:.1f}", 'dB': f"{row['dB']:.1f}",
                    'VTK/cvol': f"{row['VTK/cvol']:.1f}" if row.get('VTK/cvol') else
                    'none as close' if row['system'] == 'VTK' else ''} for row in rows]
    least = least_ratios(rows)
    lines = ['# Time against quality of pictures', '',
             f'{arguments.size} x {arguments.size}, one thread, medians of {arguments.views} views, '
             f'best of {arguments.rounds} rounds.', '',
             markdown(['volume', 'look', 'system', 'setting', 'ms', 'dB', 'VTK/cvol'], table), '']
    if least:
        lines += ['Where VTK comes nearest, and where it is closer to its truth than all of ours:', '',
                  markdown(['volume', 'look', 'least', 'where', 'median', 'none as close'], least), '']
    if skipped:
        lines += [f"Skipped (not in the data folder): {', '.join(skipped)}.", '']
    return '\n'.join(lines + [line + '  ' for line in provenance(cvol)])


def main():
    arguments = parse_arguments()
    cvol, vtk = check_cvol(arguments.cvol), have_vtk(arguments)
    names = arguments.volumes.split(',')
    unknown = [name for name in names if name not in RENDERED]
    if unknown:
        sys.exit(f"render_curve.py: no such volume: {', '.join(unknown)}")
    rows, skipped = [], []
    try:
        for name in names:
            if os.path.exists(rendered_path(name, arguments.data)):
                rows += measure(arguments, cvol, vtk, name)
            else:
                skipped.append(name)
    except Failed as problem:
        sys.exit(f'render_curve.py: {problem}')
    write_results(arguments.results, 'render_curve', describe(arguments, cvol, rows, skipped), rows)
    if rows:
        plot(rows, os.path.join(arguments.results, 'render_curve.png'))


if __name__ == '__main__':
    main()
