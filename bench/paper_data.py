#!/usr/bin/python3
"""Measures splatting on compressed transforms against splatting, on every volume of the data folder.

Pictures of 512 x 512 on one thread, azimuth 15, elevation 20, unlit: by `splat --footprint-plane slices`, and by
`transform` with 1/30 of the terms (tiles of 16, deferred), which draw the same picture. Transfer functions: the
default one of the volume (auto), and those of bench/transfer. Footprints of 5 x 5 and 15 x 15 samples. Measured are
processor times of a picture after the first (paper.py), and the PSNR of one against the other.
Results: paper_data.md, .csv.
"""
import argparse
import os
import sys
import tempfile

from paper import RHO, TILES, Scene, take_turns
from tables import (Failed, add_common_arguments, check_cvol, markdown, provenance, say, unfolded,
                    write_results)
from volumes import RENDERED, all_paths, folder_paths, short_name, transfer_path

FOOTPRINTS = (5, 15)


def looks_of(name):
    """Returns the names of looks and their transfer functions."""
    found = [(look, transfer_path(name, look)) for look in ('thin', 'semi', 'opaque') if name in RENDERED]
    return [('auto', None)] + [(look, path) for look, path in found if os.path.exists(path)]


def name_of(path):
    """Returns the bench's name of a volume, from that of its file."""
    for name, file in RENDERED.items():
        if file and short_name(file) == short_name(path):
            return name
    return 'brain' if short_name(path) == 'ch2better' else short_name(path)


def measure(arguments, folder, path):
    name = name_of(path)
    for look, transfer in looks_of(name):
        for footprint in FOOTPRINTS:
            options = ['--size', '512'] + (['--transfer', transfer] if transfer else [])
            scene = Scene(arguments.cvol, folder, [path], options, footprint)
            truth, report = scene.picture('splat')
            splat_ms = report['render_ms']
            other, report = scene.picture(TILES, RHO)
            own = report['transform']
            splat, transform = take_turns(arguments, scene, TILES, RHO, (splat_ms, own['compose_ms']))
            row = {'volume': name, 'look': look, 'f': footprint, 'splat_ms': round(splat, 1),
                   'transform_ms': round(transform, 1), 'ratio': round(splat / transform, 2),
                   'psnr_db': round(scene.psnr(truth, other), 1), 'bake_ms': round(own['bake_ms'])}
            say(' '.join(f'{key} {value}' for key, value in row.items()))
            yield row


def summary(rows):
    """Ratios: a row for each volume, a column for each look and footprint."""
    for name in dict.fromkeys(row['volume'] for row in rows):
        found = {'volume': name}
        for look in ('auto', 'thin', 'semi', 'opaque'):
            ratios = [f'{row["ratio"]:.1f} ({row["psnr_db"]:.0f} dB)' for row in rows
                      if row['volume'] == name and row['look'] == look]
            found[look] = ', '.join(ratios)
        yield found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--seconds', type=float, default=0.3, help='of pictures of each engine in a turn')
    arguments = parser.parse_args()
    arguments.cvol = check_cvol(arguments.cvol)
    rows = []
    try:
        with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
            for path in all_paths(arguments.data) + folder_paths(arguments.data):
                try:
                    rows += measure(arguments, folder, unfolded(arguments.cvol, path, folder))
                except Failed as problem:
                    say(f'{short_name(path)}: {problem}')
    except Failed as problem:
        sys.exit(f'paper_data.py: {problem}')
    losses = sum(row['ratio'] < 1 for row in rows)
    text = ['# Splatting on compressed transforms against splatting, on every volume', '',
            'Processor time of splat over that of transform (and PSNR), footprints 5 x 5, 15 x 15:', '']
    text += [markdown(['volume', 'auto', 'thin', 'semi', 'opaque'], list(summary(rows))), '']
    text += [f'transform is slower in {losses} of {len(rows)} cases.', '', 'All of it:', '']
    text += [markdown(list(rows[0]), rows), ''] if rows else []
    write_results(arguments.results, 'paper_data', '\n'.join(text + provenance(arguments.cvol)), rows)


if __name__ == '__main__':
    main()
