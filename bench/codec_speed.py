#!/usr/bin/python3
"""The codec's speed in memory: compressing with efforts default and fast, and decoding with evaluation.

Runs the program codec_speed (built with -DCVOL_BENCH=ON), which links the library: times exclude reading the
original and writing samples. Times are of the processor with one thread and of the clock with two, the best of the
rounds. A rate refers to the volume's voxels, whatever their type.
"""
import argparse
import os

from tables import (Failed, add_common_arguments, check_cvol, markdown, provenance, run_json, say,
                    write_results)
from volumes import all_paths, short_name

VOLUMES = 'ch2better,vhf_head,inia19,embryo'


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--volumes', metavar='A,B', default=VOLUMES,
                        help=f'names without ending (default {VOLUMES})')
    parser.add_argument('--rounds', type=int, default=3, help='(default 3)')
    return parser.parse_args()


def measure(program, path, rounds):
    """Returns a row for each setting, with one thread and with two."""
    one, two = (run_json([program, path, str(threads), str(rounds)]) for threads in (1, 2))
    rows = []
    for name in one:
        if isinstance(one[name], dict):
            a, b = one[name], two[name]
            rows.append({'volume': short_name(path), 'asked': name, 'dB': f"{a['psnr_db']:.2f}",
                         'bits': f"{a['bits']:.4f}",
                         'compress': f"{a['compress']:.1f}", 'by two': f"{b['compress']:.1f}",
                         'decode': f"{a['decode']:.0f}", 'by two threads': f"{b['decode']:.0f}"})
    return rows


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    program = os.path.join(os.path.dirname(os.path.abspath(cvol)), 'bench', 'codec_speed')
    wanted, rows = arguments.volumes.split(','), []
    for path in all_paths(arguments.data):
        if short_name(path) not in wanted:
            continue
        try:
            rows += measure(program, path, arguments.rounds)
            say('\n'.join(map(str, rows[-3:])))
        except (Failed, OSError) as problem:
            say(f'{path}: {problem}')
    text = '\n'.join(['# The codec, in memory', '', *provenance(cvol), '',
                      'Millions of voxels a second, of one thread and of two.', '',
                      markdown(list(rows[0]) if rows else ['volume'], rows)])
    write_results(arguments.results, 'codec_speed', text, rows)


if __name__ == '__main__':
    main()
