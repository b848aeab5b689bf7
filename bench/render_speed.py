#!/usr/bin/python3
"""Times `cvol bench render` and VTK's CPU ray caster, alternating, on the same views.

Each volume is compressed at ratio 30 into a temporary folder; VTK gets the original samples. For each transfer
function and number of threads both are timed in alternating rounds, so that other load on the machine affects both.
Times are medians over the rounds; the ratio is the median of the ratios of the rounds.
"""
import argparse
import os
import statistics
import sys
import tempfile
import time

from tables import (Failed, add_common_arguments, check_cvol, markdown, plain_look, provenance, run_json, say,
                    write_results)
from timing import child_cpu_s, first_picture_ms, frame_ratios, have_vtk, median_of, time_vtk
from volumes import BENCH, RENDERED, USUAL, rendered_path, transfer_path


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--volumes', default=','.join(USUAL), metavar='A,B',
                        help=f"of {', '.join(RENDERED)} (default %(default)s)")
    parser.add_argument('--looks', default='semi,opaque', metavar='A,B',
                        help='transfer functions, semi-lit, opaque-lit, and also xray and mip '
                        '(default %(default)s)')
    parser.add_argument('--threads', default='1,2', metavar='N,M')
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--ratio', type=float, default=30)
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--views', type=int, default=12)
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--ray-order', choices=['auto', 'image', 'object'], default='auto',
                        help='of cvol (default %(default)s)')
    parser.add_argument('--no-vtk', action='store_true', help='time cvol alone')
    return parser.parse_args()


def look_options(name, look):
    if look in ('xray', 'mip'):
        return ['--mode', look]
    if look.endswith('-lit'):
        return look_options(name, look[:-len('-lit')]) + ['--shade']
    return ['--transfer', transfer_path(name, look)]


def shared_options(arguments, name, look, threads):
    return look_options(name, look) + ['--size', str(arguments.size), '--views',
                                       str(arguments.views), '--repeat', str(arguments.repeat),
                                       '--threads', str(threads)]


def time_cvol(cvol, packed, options, pictures, ray_order):
    """Runs `cvol bench render`; also returns its processor time, with loading divided among the pictures."""
    before = child_cpu_s()
    result = run_json([cvol, 'bench', 'render', packed, '--json', '--ray-order', ray_order] + options)
    result['cpu_ms'] = 1e3 * (child_cpu_s() - before) / (pictures + 1)
    return result


def time_first_picture(cvol, packed, options, rounds):
    """Returns milliseconds of a separate process for a file, the least, and the peak memory."""
    options = [o for i, o in enumerate(options)
               if not {'--views', '--repeat'} & {o, options[i - 1] if i else ''}]
    with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
        command = [cvol, 'render', packed, '-o', os.path.join(folder, 'first.png'), '--azimuth',
                   '15', '--elevation', '20', '--json'] + options + plain_look(options)
        times, peak = [], 0
        for _ in range(rounds):
            start = time.perf_counter()
            report = run_json(command)
            times.append(1e3 * (time.perf_counter() - start))
            peak = max(peak, report.get('peak_rss_mb', 0))
    return min(times), peak


def prepare(arguments, cvol, name, folder, vtk):
    """Returns the volume in the form that each program reads: packed file, raw file, and its header."""
    original = rendered_path(name, arguments.data)
    packed = os.path.join(folder, name + '.cvol')
    run_json([cvol, 'compress', original, packed, '--ratio', str(arguments.ratio), '--json'])
    raw = os.path.join(folder, name + '.raw')
    about = run_json([os.path.join(BENCH, 'volumes.py'), original, raw]) if vtk else None
    return packed, raw, about


def measure(arguments, cvol, prepared, name, look, threads):
    """Returns one row of the table."""
    packed, raw, about = prepared
    options = shared_options(arguments, name, look, threads)
    ours, theirs = [], []
    for _ in range(arguments.rounds):
        ours.append(time_cvol(cvol, packed, options, arguments.views * arguments.repeat,
                              arguments.ray_order))
        if about:
            theirs.append(time_vtk(raw, about, options))
    row = {'volume': name, 'voxels': ours[0]['voxels'], 'look': look, 'threads': threads,
           'cvol median ms': f"{median_of(ours, 'frame_ms', 'median'):.1f}",
           'cvol min ms': f"{median_of(ours, 'frame_ms', 'min'):.1f}",
           'cvol CPU ms': f"{median_of(ours, 'cpu_ms'):.1f}",
           'ns/voxel': f"{median_of(ours, 'ns_per_voxel'):.2f}",
           'cvol load ms': f"{median_of(ours, 'load_ms'):.0f}",
           'cvol peak MB': f"{median_of(ours, 'peak_rss_mb'):.0f}",
           'load average': f'{os.getloadavg()[0]:.1f}'}
    first, peak = time_first_picture(cvol, packed, options, arguments.rounds)
    row['cvol first picture ms'] = f'{first:.0f}'
    if peak:
        row['its peak MB'] = f'{peak:.0f}'
    if theirs:
        ratios = frame_ratios(ours, theirs)
        row.update({'VTK median ms': f"{median_of(theirs, 'frame_ms', 'median'):.1f}",
                    'VTK min ms': f"{median_of(theirs, 'frame_ms', 'min'):.1f}",
                    'VTK CPU ms': f"{median_of(theirs, 'cpu_ms'):.1f}",
                    'VTK/cvol': f'{statistics.median(ratios):.2f}',
                    'VTK/cvol by round': ' '.join(f'{r:.2f}' for r in ratios),
                    'VTK first picture ms': f'{statistics.median(map(first_picture_ms, theirs)):.0f}',
                    'VTK load ms': f"{median_of(theirs, 'load_ms'):.0f}",
                    'VTK first frame ms': f"{median_of(theirs, 'first_frame_ms'):.0f}",
                    'VTK peak MB': f"{median_of(theirs, 'peak_rss_mb'):.0f}",
                    'VTK base MB': f"{median_of(theirs, 'base_rss_mb'):.0f}",
                    'VTK version': theirs[0]['version'], 'VTK package': theirs[0]['package']})
    return row


def measure_all(arguments, cvol, vtk):
    rows, skipped = [], []
    for name in arguments.volumes.split(','):
        if not os.path.exists(rendered_path(name, arguments.data)):
            skipped.append(name)
            continue
        with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
            prepared = prepare(arguments, cvol, name, folder, vtk)
            for look in arguments.looks.split(','):
                for threads in arguments.threads.split(','):
                    rows.append(measure(arguments, cvol, prepared, name, look, int(threads)))
                    say(f"{name} {look} {threads}: cvol {rows[-1]['cvol median ms']} ms, "
                        f"VTK {rows[-1].get('VTK median ms', '-')} ms")
    return rows, skipped


def describe(arguments, cvol, rows, skipped):
    columns = ['volume', 'voxels', 'look', 'threads', 'cvol median ms', 'cvol min ms', 'ns/voxel']
    if any('VTK/cvol' in row for row in rows):
        columns += ['VTK median ms', 'VTK min ms', 'VTK/cvol', 'cvol CPU ms', 'VTK CPU ms',
                    'cvol peak MB', 'VTK peak MB', 'VTK base MB', 'cvol first picture ms',
                    'VTK first picture ms']
    else:
        columns += ['cvol CPU ms', 'cvol peak MB']
    lines = ['# Speed of rendering', '',
             f'{arguments.size} x {arguments.size}, {arguments.views} views, best of '
             f'{arguments.repeat} pictures of each; medians of {arguments.rounds} rounds; cvol '
             f'renders files of 1/{arguments.ratio:g}, VTK the original samples.', '',
             markdown(columns, rows), '']
    peers = {(row['VTK version'], row['VTK package']) for row in rows if 'VTK version' in row}
    lines += [f'VTK {version}, {package or "of no package"}.' for version, package in peers]
    lines += [''] if peers else []
    if skipped:
        lines += [f"Skipped (not in the data folder): {', '.join(skipped)}.", '']
    return '\n'.join(lines + [line + '  ' for line in provenance(cvol)])


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    unknown = [name for name in arguments.volumes.split(',') if name not in RENDERED]
    if unknown:
        sys.exit(f"render_speed.py: no such volume: {', '.join(unknown)}")
    try:
        rows, skipped = measure_all(arguments, cvol, have_vtk(arguments))
    except Failed as problem:
        sys.exit(f'render_speed.py: {problem}')
    write_results(arguments.results, 'render_speed', describe(arguments, cvol, rows, skipped),
                  rows)


if __name__ == '__main__':
    main()
