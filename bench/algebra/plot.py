#!/usr/bin/python3
"""Plots the rows of the theorems (JSON) as two log-log plots. usage: plot.py ROWS.json OUT.png"""
import json
import sys

import matplotlib
matplotlib.use('Agg')
from matplotlib import pyplot  # noqa: E402


def draw(axes, rows, part, key, label):
    chosen = [row for row in rows if row['part'] == part and 'cvol min ms' in row]
    for number, name in enumerate(dict.fromkeys(row['series'] for row in chosen)):
        mine = [row for row in chosen if row['series'] == name]
        x = [row[key] for row in mine]
        axes.plot(x, [float(row['cvol min ms']) for row in mine], 'o-', color=f'C{number}',
                  label=name)
        axes.plot(x, [float(row['FFTW min ms']) for row in mine], ':', color=f'C{number}')
    axes.set(xscale='log', yscale='log', xlabel=label)
    axes.set_xscale('log', base=2)
    axes.grid(alpha=0.3)


def main():
    with open(sys.argv[1], encoding='utf-8') as file:
        rows = json.load(file)
    figure, both = pyplot.subplots(1, 2, figsize=(11, 5), sharey=True)
    draw(both[0], rows, "against n'", "n'", "n', terms kept of an operand")
    draw(both[1], rows, 'against n', 'n', 'n, samples')
    both[0].set_ylabel('ms (lines: compressed; dotted: the classical way)')
    figure.tight_layout(rect=(0, 0.08, 1, 1))
    figure.legend(*both[0].get_legend_handles_labels(), loc='lower center', ncol=6, fontsize='small')
    figure.savefig(sys.argv[2], dpi=120)


if __name__ == '__main__':
    main()
