"""Shared by the bench's scripts: running programs, describing the machine, writing tables.

It imports no large module: on Linux a child process starts with its parent's peak memory, so a measuring process
must stay small.
"""
import csv
import datetime
import json
import os
import platform
import shlex
import subprocess
import sys

from volumes import BENCH

RESULTS = os.path.join(BENCH, 'results')


# ---- running ------------------------------------------------------------------------------------

class Failed(Exception):
    """A program ended with an error; the message is its last line."""


def run(command, notes=None):
    """Returns the standard output of a program; adds its messages on standard error to the list `notes`.

    Raises Failed with its last line if it fails.
    """
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          check=False)
    words = done.stderr.strip().splitlines()
    if done.returncode:
        raise Failed(words[-1] if words else f'status {done.returncode}')
    if notes is not None:
        notes += words
    return done.stdout


def plain_look(options):
    """Returns the options for a picture of the whole volume, without light unless `options` turns one on."""
    return ['--fit', 'box'] + ([] if '--shade' in options else ['--light', 'flat'])


def run_json(command, notes=None):
    return json.loads(run(command, notes))


def unfolded(cvol, path, folder):
    """Returns a volume's file: the path itself, or, for a folder of slices, NAME.nrrd of the same samples in
    `folder`."""
    if not os.path.isdir(path):
        return path
    whole = os.path.join(folder, os.path.basename(path))
    run([cvol, 'compress', path, whole + '.cvol', '--lossless'])
    run([cvol, 'decompress', whole + '.cvol', whole + '.nrrd'])
    os.remove(whole + '.cvol')
    return whole + '.nrrd'


def say(text):
    print(text, file=sys.stderr, flush=True)


# ---- the machine --------------------------------------------------------------------------------

def first_line(command):
    try:
        return run(command).strip().splitlines()[0]
    except (OSError, Failed, IndexError):
        return ''


def machine():
    model = ''
    try:
        for line in run(['lscpu']).splitlines():
            if line.startswith('Model name'):
                model = line.split(':', 1)[1].strip()
    except (OSError, Failed):
        pass
    with open('/proc/meminfo', encoding='ascii') as file:
        memory = int(file.readline().split()[1]) / 1024 ** 2
    return (f'{model or platform.machine()}, {len(os.sched_getaffinity(0))} cores, '
            f'{memory:.0f} GB, {platform.system()} {platform.release()}')


def compiler(cvol):
    """Returns the compiler that the binary names, and the build type of its build folder."""
    named = ''
    try:
        for line in run(['readelf', '-p', '.comment', cvol]).splitlines():
            if ']' in line:
                named = line.split(']', 1)[1].strip()
    except (OSError, Failed):
        pass
    cache = os.path.join(os.path.dirname(os.path.abspath(cvol)), 'CMakeCache.txt')
    build = {}
    if os.path.exists(cache):
        with open(cache, encoding='utf-8') as file:
            for line in file:
                key, _, value = line.strip().partition('=')
                build[key.partition(':')[0]] = value
    kind = build.get('CMAKE_BUILD_TYPE', '')
    flags = ' '.join(filter(None, [build.get('CMAKE_C_FLAGS', ''),
                                   build.get('CMAKE_C_FLAGS_' + kind.upper(), '')]))
    return ', '.join(filter(None, [named or 'compiler unknown', kind, flags]))


def provenance(cvol):
    """Returns lines with machine, programs, date and command of a table."""
    version = first_line(['git', '-C', BENCH, 'describe', '--always', '--dirty'])
    return [f'Machine: {machine()}; load average at the end {os.getloadavg()[0]:.1f}.',
            f'Checkout: {version or "no git"}; cvol built by {compiler(cvol)}.',
            f'Date: {datetime.date.today().isoformat()}.',
            f'Command: `{shlex.join([os.path.relpath(sys.argv[0])] + sys.argv[1:])}`']


# ---- tables -------------------------------------------------------------------------------------

def markdown(columns, rows):
    """Returns a Markdown table; numbers are right-aligned."""
    def is_number(text):
        try:
            float(text.rstrip(' %'))
        except ValueError:
            return False
        return True

    cells = [[str(row.get(column, '')) for column in columns] for row in rows]
    right = [all(is_number(line[i]) for line in cells if line[i]) and any(line[i] for line in cells)
             for i in range(len(columns))]
    lines = ['| ' + ' | '.join(columns) + ' |',
             '|' + '|'.join('---:' if r else '---' for r in right) + '|']
    return '\n'.join(lines + ['| ' + ' | '.join(line) + ' |' for line in cells])


def write_results(folder, name, text, rows):
    """Writes folder/name.md and folder/name.csv, and prints the text."""
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, name + '.md'), 'w', encoding='utf-8') as file:
        file.write(text + '\n')
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with open(os.path.join(folder, name + '.csv'), 'w', encoding='utf-8', newline='') as file:
        writer = csv.DictWriter(file, columns, restval='')
        writer.writeheader()
        writer.writerows(rows)
    print(text)
    say(f'written: {os.path.join(folder, name)}.md and .csv')


def add_common_arguments(parser):
    from volumes import DEFAULT_DATA
    parser.add_argument('cvol', help='the command, as built: build/cvol')
    parser.add_argument('--data', default=DEFAULT_DATA, metavar='DIR',
                        help='folder of volumes; what it lacks is skipped (default %(default)s)')
    parser.add_argument('--results', default=RESULTS, metavar='DIR',
                        help='where tables go (default %(default)s)')


def check_cvol(cvol):
    if not os.access(cvol, os.X_OK):
        sys.exit(f'{cvol}: no such command; build it first (make)')
    return os.path.abspath(cvol)
