#!/usr/bin/env python3
"""Prints which lines and branches of src/ tests reach, by folder, and lists the lines that none reaches.

usage: coverage_table.py BUILD_FOLDER LIST.txt

Adds up what gcov says of all objects: a kernel is compiled once for each set, and functions in headers once for each
source. (gcovr 5.2 fails where an object has two functions of one name.) Lines that only a failed allocation reaches are
counted apart: tests/failures makes every allocation fail in turn, but its full round takes hours with counters. The
list has such lines too, marked with an m.
"""
import collections
import json
import os
import re
import subprocess
import sys

# A statement that runs when an allocation has failed, or passes on such a failure.
MEMORY = re.compile(r'\b\w*fail_memory\(|\bCVOL_ERROR_MEMORY\b|->failed = 1;')
KEYS = ('lines', 'reached', 'memory', 'branches', 'taken')


def read_counters(folder):
    """{file: {line: [count, [counts of branches]]}} of all objects, for files in src/ but tables."""
    root = os.getcwd() + '/src/'
    names = [os.path.join(top, name) for top, _, all_names in os.walk(os.path.join(folder, 'src'))
             for name in all_names if name.endswith('.gcno')]
    files = collections.defaultdict(dict)
    for k in range(0, len(names), 50):
        done = subprocess.run(['gcov', '--json-format', '--stdout', '--branch-probabilities', *names[k:k + 50]],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True)
        for text in done.stdout.splitlines():
            report = json.loads(text)
            for file in report['files']:
                path = os.path.normpath(os.path.join(report['current_working_directory'], file['file']))
                if path.startswith(root) and not path.endswith('.inc'):
                    add_lines(files['src/' + path[len(root):]], file['lines'])
    return files


def add_lines(lines, more):
    for line in more:
        own = lines.setdefault(line['line_number'], [0, []])
        own[0] += line['count']
        branches = [branch['count'] for branch in line['branches'] if not branch['throw']]
        own[1] += [0] * (len(branches) - len(own[1]))
        for i, count in enumerate(branches):
            own[1][i] += count


def measure(name, lines):
    """Counts of a file, and its unreached lines: (number, text, is for memory)."""
    with open(name, encoding='utf-8') as source:
        texts = source.read().split('\n')
    counts = dict.fromkeys(KEYS, 0)
    missed = []
    for number, (count, branches) in sorted(lines.items()):
        counts['lines'] += 1
        counts['branches'] += len(branches)
        counts['taken'] += sum(taken > 0 for taken in branches)
        if count:
            counts['reached'] += 1
            continue
        is_memory = bool(MEMORY.search(texts[number - 1]))
        counts['memory'] += is_memory
        missed.append((number, texts[number - 1], is_memory))
    return counts, missed


def share(part, of):
    return '%.1f' % (100 * part / of) if of else '-'


def row(name, counts):
    lines = counts['lines']
    print('| %s | %d | %s | %s | %d | %s |' % (
        name, lines, share(counts['reached'], lines), share(counts['reached'] + counts['memory'], lines),
        counts['branches'], share(counts['taken'], counts['branches'])))


def main():
    folders = {}
    with open(sys.argv[2], 'w', encoding='utf-8') as listing:
        for name, lines in sorted(read_counters(sys.argv[1]).items()):
            counts, missed = measure(name, lines)
            sums = folders.setdefault(os.path.dirname(name), dict.fromkeys(KEYS, 0))
            for key in KEYS:
                sums[key] += counts[key]
            for number, text, is_memory in missed:
                listing.write('%s:%d:%s %s\n' % (name, number, 'm' if is_memory else ' ', text))
    print('| folder | lines | reached, % | or without memory, % | branches | reached, % |')
    print('|---|---:|---:|---:|---:|---:|')
    for name, sums in sorted(folders.items()):
        row(name, sums)
    row('all', {key: sum(sums[key] for sums in folders.values()) for key in KEYS})


main()
