#!/usr/bin/env python3
"""Prints which lines and branches tests reach, by folder, from a report of gcovr (--json), and lists the lines that
none reaches.

usage: coverage_table.py REPORT.json LIST.txt

Lines that only a failed allocation reaches are counted apart: tests/failures makes every allocation fail in turn, but
its full round takes hours with counters. The list has such lines too, marked with an m.
"""
import json
import os
import re
import sys

# A statement that runs when an allocation has failed, or passes on such a failure.
MEMORY = re.compile(r'\b\w*fail_memory\(|\bCVOL_ERROR_MEMORY\b|->failed = 1;')
KEYS = ('lines', 'reached', 'memory', 'branches', 'taken')


def measure(file):
    """Counts of a file, and its unreached lines: (number, text, is for memory)."""
    with open(file['file'], encoding='utf-8') as source:
        texts = source.read().split('\n')
    counts = dict.fromkeys(KEYS, 0)
    missed = []
    for line in file['lines']:
        if line.get('gcovr/noncode'):
            continue
        counts['lines'] += 1
        counts['branches'] += len(line['branches'])
        counts['taken'] += sum(branch['count'] > 0 for branch in line['branches'])
        if line['count']:
            counts['reached'] += 1
            continue
        text = texts[line['line_number'] - 1]
        is_memory = bool(MEMORY.search(text))
        counts['memory'] += is_memory
        missed.append((line['line_number'], text, is_memory))
    return counts, missed


def share(part, of):
    return '%.1f' % (100 * part / of) if of else '-'


def row(name, counts):
    lines = counts['lines']
    print('| %s | %d | %s | %s | %d | %s |' % (
        name, lines, share(counts['reached'], lines), share(counts['reached'] + counts['memory'], lines),
        counts['branches'], share(counts['taken'], counts['branches'])))


def main():
    with open(sys.argv[1], encoding='utf-8') as report:
        files = json.load(report)['files']
    folders = {}
    with open(sys.argv[2], 'w', encoding='utf-8') as listing:
        for file in files:
            counts, missed = measure(file)
            sums = folders.setdefault(os.path.dirname(file['file']), dict.fromkeys(KEYS, 0))
            for key in KEYS:
                sums[key] += counts[key]
            for number, text, is_memory in missed:
                listing.write('%s:%d:%s %s\n' % (file['file'], number, 'm' if is_memory else ' ', text))
    print('| folder | lines | reached, % | or without memory, % | branches | reached, % |')
    print('|---|---:|---:|---:|---:|---:|')
    for name, sums in sorted(folders.items()):
        row(name, sums)
    row('all', {key: sum(sums[key] for sums in folders.values()) for key in KEYS})


main()
