#!/usr/bin/python3
"""Pictures of compressed volumes compared with the reference: the original samples, cast at step 0.25.

For four volumes and two transfer functions, from 12 views, with PSNR over the foreground (pixels of either picture
with a channel above 2):

  sheet 1/30   `cvol render` of a file of ratio 30: coding and sampling errors together
  sheet 70 dB  of a nearly lossless file: the engine's own sampling error
  ray 1/30     cast at step 0.25 from the decoded file: the coding error alone
  VTK          VTK's ray caster at its step of one voxel against VTK at step 0.25 (its own reference,
               because two renderers with equal settings differ by more than their errors)

The references take long; they are kept in the scratch folder until volume or transfer function change. Use --fresh
after a change of the ray engine.
"""
import argparse
import glob
import hashlib
import math
import os
import shutil
import statistics
import sys

from tables import (Failed, add_common_arguments, check_cvol, markdown, plain_look, provenance, run_json, say,
                    write_results)
from volumes import BENCH, RENDERED, USUAL, rendered_path, transfer_path

VTK = os.path.join(BENCH, 'peers', 'vtk_render.py')
WORK = os.path.join(BENCH, 'scratch')
TRUTH_STEP = '0.25'


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--volumes', default=','.join(USUAL), metavar='A,B',
                        help=f"of {', '.join(RENDERED)} (default %(default)s)")
    parser.add_argument('--looks', default='semi,opaque', metavar='A,B')
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--views', type=int, default=12)
    parser.add_argument('--threads', type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument('--difference', action='store_true', help='write the worst view of each '
                        'row to RESULTS/difference: truth, picture, 128 + 8 * difference')
    parser.add_argument('--no-ray', action='store_true', help='leave the rows "ray" out')
    parser.add_argument('--no-vtk', action='store_true', help='leave the rows "VTK" out')
    parser.add_argument('--fresh', action='store_true', help='make the truth anew')
    parser.add_argument('--work', default=WORK, metavar='DIR',
                        help='pictures and packed files (default %(default)s)')
    return parser.parse_args()


# ---- pictures -----------------------------------------------------------------------------------

def azimuth(view, views):
    return 15 + 360 * view / views


def picture_path(folder, view):
    return os.path.join(folder, f'view_{view:02d}.png')


def render_views(arguments, cvol, source, transfer, folder, options):
    """Renders every missing view of a source into a folder."""
    os.makedirs(folder, exist_ok=True)
    for view in range(arguments.views):
        path = picture_path(folder, view)
        if os.path.exists(path):
            continue
        run_json([cvol, 'render', source, '-o', path, '--size', str(arguments.size), '--azimuth',
                  repr(azimuth(view, arguments.views)), '--elevation', '20', '--transfer',
                  transfer, '--threads', str(arguments.threads), '--json'] + options + plain_look(options))
    return folder


def truth_key(arguments, source, transfer):
    """Returns a key that changes when the reference must."""
    with open(transfer, 'rb') as file:
        look = file.read()
    status = os.stat(source)
    text = (f'{os.path.basename(source)} {status.st_size} {int(status.st_mtime)} '
            f'{arguments.size} {arguments.views} {TRUTH_STEP}')
    return hashlib.sha256(text.encode() + look).hexdigest()[:12]


def truth_views(arguments, cvol, name, look, made):
    source, transfer = rendered_path(name, arguments.data), transfer_path(name, look)
    folder = os.path.join(arguments.work, 'truth', f'{name}_{look}_'
                          + truth_key(arguments, source, transfer))
    if arguments.fresh and folder not in made:
        shutil.rmtree(folder, ignore_errors=True)
    made.add(folder)
    return render_views(arguments, cvol, source, transfer, folder,
                        ['--engine', 'ray', '--step', TRUTH_STEP])


def vtk_views(arguments, name, look, step, folder):
    source = rendered_path(name, arguments.data)
    raw = os.path.join(arguments.work, name + '.raw')
    os.makedirs(arguments.work, exist_ok=True)
    about = run_json([os.path.join(BENCH, 'volumes.py'), source, raw])
    run_json([VTK, raw, '--dims', 'x'.join(map(str, about['dims'])), '--type', about['type'],
              '--spacing', ','.join(map(str, about['spacing'])), '--transfer',
              transfer_path(name, look), '--size', str(arguments.size), '--views',
              str(arguments.views), '--repeat', '1', '--threads', str(arguments.threads),
              '--step', step, '--png', folder])
    os.remove(raw)
    return folder


# ---- figures of merit ---------------------------------------------------------------------------

def pooled_psnr(compared):
    """Returns the PSNR of the mean squared error over the foregrounds of all views together."""
    pixels = sum(c['foreground_pixels'] for c in compared)
    error = sum(c['foreground_pixels'] * 255 ** 2 / 10 ** (c['psnr_foreground_db'] / 10)
                for c in compared)
    return 10 * math.log10(255 ** 2 * pixels / error) if error > 0 and pixels else 999.0


def compare_views(arguments, cvol, truth, folder):
    compared = [run_json([cvol, 'compare', picture_path(truth, view), picture_path(folder, view),
                          '--json']) for view in range(arguments.views)]
    psnr = [c['psnr_foreground_db'] for c in compared]
    worst = psnr.index(min(psnr))
    return {'median dB': f'{statistics.median(psnr):.2f}', 'worst dB': f'{min(psnr):.2f}',
            'worst at': f'{azimuth(worst, arguments.views):g}', 'best dB': f'{max(psnr):.2f}',
            'pooled dB': f'{pooled_psnr(compared):.2f}',
            'SSIM': f"{statistics.median(c['ssim'] for c in compared):.4f}",
            'largest': f"{max(c['max_abs_error'] for c in compared):.0f}",
            'every view dB': ' '.join(f'{p:.2f}' for p in psnr)}, worst


def write_difference(truth, folder, view, out):
    import numpy
    from PIL import Image
    a, b = (numpy.asarray(Image.open(picture_path(f, view)).convert('RGB')).astype(int)
            for f in (truth, folder))
    difference = numpy.clip(128 + 8 * (b - a), 0, 255)
    os.makedirs(os.path.dirname(out), exist_ok=True)
    Image.fromarray(numpy.hstack([a, b, difference]).astype('uint8')).save(out)


# ---- rows ---------------------------------------------------------------------------------------

def compress(arguments, cvol, name, what, options):
    """Returns the packed file and the report of compress."""
    os.makedirs(arguments.work, exist_ok=True)
    packed = os.path.join(arguments.work, f'{name}_{what}.cvol')
    return packed, run_json([cvol, 'compress', rendered_path(name, arguments.data), packed,
                             '--json'] + options)


def row_of(arguments, cvol, name, look, what, truth, folder, report=None):
    figures, worst = compare_views(arguments, cvol, truth, folder)
    row = {'volume': name, 'look': look, 'pictures': what}
    if report:
        decibels = report['psnr_db']
        row |= {'ratio': f"{report['ratio']:.1f}", 'volume dB': 'exact' if decibels is None else f'{decibels:.1f}'}
    if arguments.difference:
        label = what.replace('/', '_').replace(' ', '_')
        stem = os.path.join(arguments.results, 'difference', f'{name}_{look}_{label}_view_')
        for old in glob.glob(glob.escape(stem) + '*.png'):
            os.remove(old)
        write_difference(truth, folder, worst, f'{stem}{worst:02d}.png')
    say(f"{name} {look} {what}: median {figures['median dB']}, worst {figures['worst dB']}")
    return row | figures


def measure_look(arguments, cvol, name, look, packed, truth):
    transfer = transfer_path(name, look)
    rows = []
    cases = [('sheet 1/30', 'r30', []), ('sheet 70 dB', 'p70', [])]
    if not arguments.no_ray:
        cases.append(('ray 1/30', 'r30', ['--engine', 'ray', '--step', TRUTH_STEP]))
    for what, which, options in cases:
        folder = os.path.join(arguments.work, 'pictures', f'{name}_{look}_{what[:3]}_{which}')
        shutil.rmtree(folder, ignore_errors=True)
        source, report = packed[which]
        render_views(arguments, cvol, source, transfer, folder, options)
        rows.append(row_of(arguments, cvol, name, look, what, truth, folder, report))
    if not arguments.no_vtk:
        fine, plain = (vtk_views(arguments, name, look, step, os.path.join(
            arguments.work, 'pictures', f'{name}_{look}_vtk_{step}')) for step in (TRUTH_STEP, '1'))
        rows.append(row_of(arguments, cvol, name, look, 'VTK', fine, plain))
    return rows


def measure_all(arguments, cvol):
    rows, skipped, made = [], [], set()
    for name in arguments.volumes.split(','):
        if not os.path.exists(rendered_path(name, arguments.data)):
            skipped.append(name)
            continue
        packed = {'r30': compress(arguments, cvol, name, 'r30', ['--ratio', '30']),
                  'p70': compress(arguments, cvol, name, 'p70', ['--psnr', '70'])}
        for look in arguments.looks.split(','):
            truth = truth_views(arguments, cvol, name, look, made)
            rows += measure_look(arguments, cvol, name, look, packed, truth)
        for path, _ in packed.values():
            os.remove(path)
    return rows, skipped


def describe(arguments, cvol, rows, skipped):
    columns = ['volume', 'look', 'pictures', 'ratio', 'volume dB', 'median dB', 'worst dB',
               'worst at', 'best dB', 'pooled dB', 'SSIM', 'largest']
    lines = ['# Quality of pictures', '',
             f'{arguments.size} x {arguments.size}, {arguments.views} views, PSNR over the '
             f'foreground against the original samples cast at step {TRUTH_STEP} (VTK: against '
             'itself at that step).', '', markdown(columns, rows), '']
    if skipped:
        lines += [f"Skipped (not in the data folder): {', '.join(skipped)}.", '']
    return '\n'.join(lines + [line + '  ' for line in provenance(cvol)])


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    unknown = [name for name in arguments.volumes.split(',') if name not in RENDERED]
    if unknown:
        sys.exit(f"render_quality.py: no such volume: {', '.join(unknown)}")
    try:
        rows, skipped = measure_all(arguments, cvol)
    except Failed as problem:
        sys.exit(f'render_quality.py: {problem}')
    write_results(arguments.results, 'render_quality', describe(arguments, cvol, rows, skipped),
                  rows)


if __name__ == '__main__':
    main()
