#!/usr/bin/python3
"""X-rays by the Fourier slice theorem: time compared with VTK's CPU ray caster, PSNR compared with cast rays.

`cvol bench render --engine fourier`, with all frequencies and with fewer, and VTK in additive mode alternate on the
same twelve views. Pictures from twelve directions on the sphere are compared with `cvol render --engine ray --mode
xray --step 0.25` of the same samples. The last part renders a thousand poses as one batch.
"""
import argparse
import math
import os
import statistics
import sys
import tempfile

from tables import (Failed, add_common_arguments, check_cvol, markdown, provenance, run, run_json,
                    say, write_results)
from timing import child_cpu_s, frame_ratios, have_vtk, median_of, time_vtk
from volumes import BENCH, RENDERED, rendered_path

TRUTH = ['--engine', 'ray', '--mode', 'xray', '--step', '0.25']


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--volumes', default=','.join(RENDERED), metavar='A,B')
    parser.add_argument('--rhos', default='all,1,0.1,0.01', metavar='A,B',
                        help='frequencies kept, over samples (default %(default)s)')
    parser.add_argument('--threads', type=int, default=1, help='of both (default 1)')
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--views', type=int, default=12)
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--poses', type=int, default=1000)
    parser.add_argument('--no-vtk', action='store_true', help='time cvol alone')
    return parser.parse_args()


def rho_options(rho):
    return ['--engine', 'fourier'] + ([] if rho == 'all' else ['--rho', rho])


# ---- quality ------------------------------------------------------------------------------------

def directions(count):
    """Returns directions evenly distributed over the sphere, on a spiral."""
    for i in range(count):
        height = 1 - (2 * i + 1) / count
        yield f'{(222.492 * i) % 360:.3f}', f'{math.degrees(math.asin(height)):.3f}'


def view_options(arguments, azimuth, elevation):
    return ['--fit', 'box', '--azimuth', azimuth, '--elevation', elevation, '--size', str(arguments.size),
            '--threads', str(arguments.threads), '--json']


def compare_pictures(arguments, cvol, path, folder, rhos):
    """Returns, for each rho, the PSNR over all directions and over the foreground, and the memory in use."""
    truth, picture = (os.path.join(folder, name) for name in ('truth.png', 'picture.png'))
    found = {rho: {'psnr': [], 'foreground': []} for rho in rhos}
    for azimuth, elevation in directions(arguments.views):
        view = view_options(arguments, azimuth, elevation)
        run([cvol, 'render', path, '-o', truth] + TRUTH + view)
        for rho in rhos:
            about = run_json([cvol, 'render', path, '-o', picture] + rho_options(rho) + view)
            compared = run_json([cvol, 'compare', truth, picture, '--json'])
            found[rho]['psnr'].append(compared['psnr_db'])
            found[rho]['foreground'].append(compared['psnr_foreground_db'])
            found[rho]['bytes'] = about['fourier']['bytes']
    return found


# ---- speed --------------------------------------------------------------------------------------

def time_cvol(arguments, cvol, path, options):
    """Runs `cvol bench render`; returns its report and the processor time per picture: that of many repeats minus
    that of one, which excludes loading."""
    many, cpu = 5 * arguments.repeat, []
    for repeat in (1, many):
        before = child_cpu_s()
        result = run_json([cvol, 'bench', 'render', path, '--json', '--repeat', str(repeat)] +
                          options)
        cpu.append(child_cpu_s() - before)
    result['cpu_ms'] = 1e3 * (cpu[1] - cpu[0]) / (arguments.views * (many - 1))
    return result


def time_views(arguments, cvol, path, folder, rhos, vtk):
    """Returns milliseconds for each rho and for VTK, by round."""
    shared = ['--mode', 'xray', '--size', str(arguments.size), '--views', str(arguments.views),
              '--threads', str(arguments.threads)]
    raw = os.path.join(folder, 'samples.raw')
    about = run_json([os.path.join(BENCH, 'volumes.py'), path, raw]) if vtk else None
    ours, theirs = {rho: [] for rho in rhos}, []
    for _ in range(arguments.rounds):
        for rho in rhos:
            ours[rho].append(time_cvol(arguments, cvol, path, rho_options(rho) + shared))
        if vtk:
            theirs.append(time_vtk(raw, about, shared + ['--repeat', str(arguments.repeat)]))
    return ours, theirs


def rows_of(arguments, name, ours, theirs, found):
    for rho, results in ours.items():
        quality = found[rho]
        row = {'volume': name, 'voxels': results[0]['voxels'], 'rho': rho,
               'ms': f"{median_of(results, 'frame_ms', 'median'):.2f}",
               'CPU ms': f"{median_of(results, 'cpu_ms'):.2f}", 'MB held': f"{quality['bytes'] / 1e6:.1f}",
               'load ms': f"{median_of(results, 'load_ms'):.0f}",
               'peak MB': f"{median_of(results, 'peak_rss_mb'):.0f}",
               'worst dB': f"{min(quality['psnr']):.1f}",
               'median dB': f"{statistics.median(quality['psnr']):.1f}",
               'foreground dB': f"{min(quality['foreground']):.1f}",
               'threads': arguments.threads}
        if theirs:
            ratios = frame_ratios(results, theirs)
            row |= {'VTK ms': f"{median_of(theirs, 'frame_ms', 'median'):.1f}",
                    'VTK/cvol': f'{statistics.median(ratios):.1f}',
                    'VTK CPU ms': f"{median_of(theirs, 'cpu_ms'):.1f}",
                    'VTK/cvol by round': ' '.join(f'{r:.1f}' for r in ratios),
                    'VTK version': theirs[0]['version']}
        yield row


def time_batch(arguments, cvol, path, folder):
    poses, stack = os.path.join(folder, 'poses.csv'), os.path.join(folder, 'stack.raw')
    with open(poses, 'w', encoding='ascii') as file:
        file.write('azimuth,elevation,roll\n')
        for azimuth, elevation in directions(arguments.poses):
            file.write(f'{azimuth},{elevation},0\n')
    result = run_json([cvol, 'render', path, '--poses', poses, '-o', stack, '--engine', 'fourier',
                       '--size', '256', '--threads', str(arguments.threads), '--json'])
    os.remove(stack)
    return result


# ---- the table ----------------------------------------------------------------------------------

def measure_all(arguments, cvol, vtk):
    rows, batches, skipped = [], [], []
    rhos = arguments.rhos.split(',')
    for name in arguments.volumes.split(','):
        path = rendered_path(name, arguments.data)
        if not os.path.exists(path):
            skipped.append(name)
            continue
        with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
            found = compare_pictures(arguments, cvol, path, folder, rhos)
            ours, theirs = time_views(arguments, cvol, path, folder, rhos, vtk)
            rows += rows_of(arguments, name, ours, theirs, found)
            batch = time_batch(arguments, cvol, path, folder)
            batches.append(f"{name}: {batch['poses']} poses of 256 x 256 in "
                           f"{batch['render_ms'] / 1e3:.1f} s.")
            say(f"{name}: {rows[-len(rhos)]['ms']} ms, worst {rows[-len(rhos)]['worst dB']} dB, "
                f"VTK {rows[-1].get('VTK ms', '-')} ms; {batches[-1]}")
    return rows, batches, skipped


def describe(arguments, cvol, rows, batches, skipped):
    columns = ['volume', 'voxels', 'rho', 'ms', 'CPU ms', 'MB held', 'load ms', 'peak MB',
               'worst dB', 'median dB', 'foreground dB']
    if any('VTK ms' in row for row in rows):
        columns += ['VTK ms', 'VTK/cvol', 'VTK CPU ms']
    lines = ['# X-rays by the Fourier slice theorem', '',
             f'{arguments.size} x {arguments.size}, {arguments.threads} thread(s), '
             f'{arguments.views} views, best of {arguments.repeat} pictures of each; medians of '
             f'{arguments.rounds} rounds. PSNR against rays in steps of 0.25, of '
             f'{arguments.views} directions: worst, median, and worst over the foreground.', '',
             markdown(columns, rows), ''] + [line + '  ' for line in batches] + ['']
    if skipped:
        lines += [f"Skipped (not in the data folder): {', '.join(skipped)}.", '']
    return '\n'.join(lines + [line + '  ' for line in provenance(cvol)])


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    unknown = [name for name in arguments.volumes.split(',') if name not in RENDERED]
    if unknown:
        sys.exit(f"fourier.py: no such volume: {', '.join(unknown)}")
    try:
        rows, batches, skipped = measure_all(arguments, cvol, have_vtk(arguments))
    except Failed as problem:
        sys.exit(f'fourier.py: {problem}')
    write_results(arguments.results, 'fourier', describe(arguments, cvol, rows, batches, skipped),
                  rows)


if __name__ == '__main__':
    main()
