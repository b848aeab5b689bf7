#!/usr/bin/python3
"""WebAssembly compared with the kernels of processors: the same requests of the viewer, by one thread.

The viewer's requests are compiled to WebAssembly for pages, and are answered by `cvol view` natively. Each round asks
every program once for each picture, so that changes of the machine's clock concern all of them. Node runs the
WebAssembly. Times are of drawing: without HTTP, and without encoding.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request

from tables import BENCH, add_common_arguments, check_cvol, markdown, provenance, run, say, write_results
from volumes import rendered_path

SETS = ('base', 'avx2', 'avx512')
SIDE = 512
LIGHT = {'on': True, 'direction': [-0.55, 0.65, 0.9], 'ambient': 0.3, 'diffuse': 0.6, 'specular': 0.1, 'shininess': 24,
         'fill': 0.2, 'occlusion': 0.75, 'shadows': 0.6}
# name: mode, quality, more fields of VIEW
PICTURES = {'lit, full quality': ('composite', 'full', {'light': LIGHT}),
            'unlit, full quality': ('composite', 'full', {}),
            'lit, level 2': ('composite', 'level 2', {'light': LIGHT}),
            'surface': ('iso', 'full', {'light': LIGHT}),
            'maximum': ('mip', 'full', {}),
            'X-ray': ('mean', 'full', {})}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('web', help='folder of the WebAssembly, as built by scripts/web.sh')
    parser.add_argument('--rounds', type=int, default=7)
    return parser.parse_args()


def request_of(name, turn):
    mode, quality, more = PICTURES[name]
    view = {'volume': '0', 'width': SIDE, 'height': SIDE, 'mode': mode,
            'camera': {'azimuth': 30 + turn, 'elevation': 20}, **more}
    return {'view': view, 'quality': quality}


class Native:
    """`cvol view` with one thread and one set of kernels."""

    def __init__(self, cvol, path, instructions):
        self.name = instructions
        begin = time.monotonic()
        self.process = subprocess.Popen([cvol, 'view', path, '--no-browser', '--json', '--threads', '1'],
                                        stdout=subprocess.PIPE, env=dict(os.environ, CVOL_CPU=instructions))
        text = b''
        while b'}' not in text:
            text += os.read(self.process.stdout.fileno(), 4096)
        self.address = json.loads(text)['address'] + 'api/1/'
        while self.ask('volumes')[0]['volumes'][0]['state'] != 'ready':
            time.sleep(0.002)
        self.opening_ms = 1e3 * (time.monotonic() - begin)

    def ask(self, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        with urllib.request.urlopen(urllib.request.Request(self.address + path, data), timeout=120) as answer:
            content, frame = answer.read(), answer.headers['Cvol-Frame']
        return (None, json.loads(frame)) if frame else (json.loads(content), None)

    def draw(self, request):
        return self.ask('frame', request)[1]['render_ms']

    def end(self):
        self.process.terminate()
        self.process.wait(60)


class Web:
    """bench/web_native.mjs: an instance of the WebAssembly in Node, which answers a request by line."""
    name = 'WebAssembly'

    def __init__(self, web, path):
        self.process = subprocess.Popen(['node', os.path.join(BENCH, 'web_native.mjs'), web, path], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.opening_ms = json.loads(self.process.stdout.readline())['opening_ms']

    def draw(self, request):
        print(json.dumps(request), file=self.process.stdin, flush=True)
        return json.loads(self.process.stdout.readline())['render_ms']

    def end(self):
        self.process.stdin.close()
        self.process.wait(60)


def measure(programs, name, rounds):
    """Returns the times of each program: the first picture, and those after it has drawn twice."""
    first = [program.draw(request_of(name, 0)) for program in programs]
    for program in programs:
        program.draw(request_of(name, 3))
    times = [[] for _ in programs]
    for k in range(rounds):
        for program, own in zip(programs, times):
            own.append(program.draw(request_of(name, 5 * k)))
    return first, times


def row_of(name, programs, values, others=None):
    row = {'ms, least of each': name}
    for program, value in zip(programs, values):
        row[program.name] = f'{value:.1f}'
    for program, value in zip(programs[1:], values[1:]):
        row[f'WebAssembly / {program.name}'] = f'{values[0] / value:.2f}'
    if others:
        row['/ base, median'] = f'{statistics.median(others[0]) / statistics.median(others[1]):.2f}'
    return row


def main():
    arguments = parse_arguments()
    arguments.cvol = check_cvol(arguments.cvol)
    with tempfile.TemporaryDirectory() as folder:
        brain = os.path.join(folder, 'brain.cvol')
        run([arguments.cvol, 'compress', rendered_path('brain', arguments.data), brain])
        programs = [Web(arguments.web, brain)] + [Native(arguments.cvol, brain, one) for one in SETS]
        rows = [row_of('opening, with the start of the program', programs, [p.opening_ms for p in programs])]
        try:
            for name in PICTURES:
                say(name)
                first, times = measure(programs, name, arguments.rounds)
                if name == next(iter(PICTURES)):
                    rows.append(row_of(f'{name}, the first one', programs, first))
                rows.append(row_of(name, programs, [min(own) for own in times], times))
        finally:
            for program in programs:
                program.end()
    text = '\n'.join([f'# WebAssembly and native kernels, the brain at 1/30, {SIDE} x {SIDE}, one thread', '',
                      '\n'.join(line + '  ' for line in provenance(arguments.cvol)), '',
                      markdown(list(dict.fromkeys(key for row in rows for key in row)), rows)])
    write_results(arguments.results, 'web_native', text, rows)


if __name__ == '__main__':
    sys.exit(main())
