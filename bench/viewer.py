#!/usr/bin/python3
"""The viewer's server without a browser: several viewers at once, and the stages of a frame's time.

One viewer turns the volume, then several, each as fast as the server answers, on separate connections. All run on
this machine, so the figures include their work. The status, size and JPEG of every frame are checked. The server's
memory is read once a second.
"""
import argparse
import http.client
import json
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import urllib.parse

from tables import add_common_arguments, check_cvol, markdown, provenance, run, say, write_results
from volumes import rendered_path


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--viewers', type=int, default=8)
    parser.add_argument('--seconds', type=float, default=60)
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--budget-ms', type=float, default=20)
    return parser.parse_args()


class Turning(threading.Thread):
    """A viewer that requests the next frame as soon as it has the last one."""

    def __init__(self, address, name, arguments, seconds):
        super().__init__()
        self.url, self.name, self.arguments = urllib.parse.urlsplit(address), name, arguments
        self.seconds, self.frames, self.failure = seconds, [], None

    def run(self):
        try:
            self.turn()
        except (OSError, http.client.HTTPException, ValueError) as failure:
            self.failure = str(failure)

    def turn(self):
        connection = http.client.HTTPConnection(self.url.hostname, self.url.port, timeout=60)
        begin, number = time.monotonic(), 0
        while time.monotonic() - begin < self.seconds:
            view = {'volume': '0', 'width': self.arguments.size, 'height': self.arguments.size,
                    'camera': {'azimuth': number, 'elevation': 20}}
            asked = time.monotonic()
            connection.request('POST', self.url.path + 'api/1/frame', json.dumps(
                {'view': view, 'quality': 'motion', 'viewer': self.name, 'sequence': number,
                 'budget_ms': self.arguments.budget_ms}))
            answer = connection.getresponse()
            content = answer.read()
            if answer.status != 200 or content[:2] != b'\xff\xd8':
                raise ValueError(f'status {answer.status}: {content[:100]!r}')
            figures = json.loads(answer.headers['Cvol-Frame'])
            figures['whole_ms'] = 1e3 * (time.monotonic() - asked)
            self.frames.append(figures)
            number += 1
        connection.close()


def resident_mb(pid):
    with open(f'/proc/{pid}/status', encoding='ascii') as file:
        for line in file:
            if line.startswith('VmRSS'):
                return int(line.split()[1]) / 1024
    return 0


def turn(viewer, address, count, arguments, seconds):
    threads = [Turning(address, f'v{count}-{i}', arguments, seconds) for i in range(count)]
    memory = []
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        memory.append(resident_mb(viewer.pid))
        time.sleep(1)
    for thread in threads:
        if thread.failure:
            raise SystemExit(f'viewer.py: viewer {thread.name}: {thread.failure}')
    return threads, memory


def share(values, part):
    values = sorted(values)
    return values[min(len(values) - 1, int(part * len(values)))]


def row_of(threads, memory, seconds):
    frames = [frame for thread in threads for frame in thread.frames]
    counts = [len(thread.frames) for thread in threads]
    steady = memory[len(memory) // 5:] or memory

    def times(name):
        return [frame[name] for frame in frames]

    kinds = [frame['quality'] for frame in frames]
    return {'viewers': len(threads), 'seconds': seconds,
            'frames a second each, fewest': round(min(counts) / seconds, 1),
            'most': round(max(counts) / seconds, 1),
            'whole ms, median': round(statistics.median(times('whole_ms')), 1),
            '95 %': round(share(times('whole_ms'), 0.95), 1),
            'longest': round(max(times('whole_ms')), 1),
            'queue ms': round(statistics.median(times('queue_ms')), 1),
            'render ms': round(statistics.median(times('render_ms')), 1),
            'encode ms': round(statistics.median(times('encode_ms')), 2),
            'send ms and client': round(statistics.median(
                frame['whole_ms'] - frame['queue_ms'] - frame['render_ms'] - frame['encode_ms']
                for frame in frames), 2),
            'mostly': max(set(kinds), key=kinds.count),
            'MB after a fifth': round(steady[0]), 'MB at the end': round(steady[-1]),
            'MB at most': round(max(memory))}


def main():
    arguments = parse_arguments()
    arguments.cvol = check_cvol(arguments.cvol)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        brain = os.path.join(folder, 'brain.cvol')
        run([arguments.cvol, 'compress', rendered_path('brain', arguments.data), brain])
        with subprocess.Popen([arguments.cvol, 'view', brain, '--no-browser', '--json'],
                              stdout=subprocess.PIPE) as viewer:
            try:
                address = json.loads(viewer.stdout.readline() + viewer.stdout.readline()
                                     + viewer.stdout.readline())['address']
                time.sleep(2)
                for count, seconds in ((1, min(10, arguments.seconds)),
                                       (arguments.viewers, arguments.seconds)):
                    say(f'{count} viewers, {seconds:g} s')
                    rows.append(row_of(*turn(viewer, address, count, arguments, seconds), seconds))
            finally:
                viewer.terminate()
    text = '\n'.join([f'# The viewer in motion, {arguments.size} x {arguments.size}', '',
                      '\n'.join(line + '  ' for line in provenance(arguments.cvol)), '',
                      markdown(list(rows[0]), rows)])
    write_results(arguments.results, 'viewer', text, rows)


if __name__ == '__main__':
    sys.exit(main())
