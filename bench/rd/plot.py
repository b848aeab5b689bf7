#!/usr/bin/python3
"""Plots PSNR over bits per voxel, one panel per volume. usage: plot.py RD.json OUT.png"""
import json
import math
import sys

import matplotlib
matplotlib.use('Agg')
from matplotlib import pyplot  # noqa: E402


def main():
    with open(sys.argv[1], encoding='utf-8') as file:
        found = json.load(file)
    names = list(found['curves'])
    columns = 4
    lines = math.ceil(len(names) / columns)
    figure, panels = pyplot.subplots(lines, columns, figsize=(4 * columns, 3 * lines),
                                     squeeze=False)
    for panel in panels.flat[len(names):]:
        panel.axis('off')
    for panel, name in zip(panels.flat, names):
        rows = [row for row in found['rows'] if row['volume'] == name
                and row.get('PSNR dB', 'exact') != 'exact']
        panel.plot([float(row['cvol bits']) for row in rows],
                   [float(row['PSNR dB']) for row in rows], 'o-', label='cvol')
        curve = [(bits, psnr) for bits, psnr in found['curves'][name] if bits < 6]
        panel.plot(*zip(*curve), 's:', markersize=3, label='zfp')
        panel.set(title=name, xscale='log')
        panel.grid(alpha=0.3)
    panels[0][0].legend()
    figure.supxlabel('bits a voxel')
    figure.supylabel('PSNR, dB')
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=100)


if __name__ == '__main__':
    main()
