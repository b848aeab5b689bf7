"""The algebra by the command, on files: the brain and a smooth mask, both at ratio 30.

Compressed: `cvol add`, `cvol multiply`. Dense: decompress both, compute with numpy, compress the result to a file
of the same size. The reference is computed from the original samples. Both results, and the reference compressed to
that size, are compared with the reference.
"""
import os
import tempfile
import time

from tables import Failed, markdown, run_json, say
from volumes import BENCH, rendered_path

OPERATIONS = ('add', 'multiply')
TOOLS = os.path.join(BENCH, 'algebra')


def timed(command):
    """Returns (seconds, peak resident MB) of a program; raises Failed if it fails."""
    start = time.perf_counter()
    # Not subprocess: wait4 reports the resources of this one child. The measuring process must be small.
    with open(os.devnull, 'w', encoding='ascii') as null:
        child = os.posix_spawnp(command[0], command, os.environ,
                                file_actions=[(os.POSIX_SPAWN_DUP2, null.fileno(), 1)])
        _, status, usage = os.wait4(child, 0)
    seconds = time.perf_counter() - start
    if status:
        raise Failed(f'{os.path.basename(command[0])} {command[1]} failed')
    return seconds, usage.ru_maxrss / 1024


def timed_all(commands):
    """Returns the sum of the seconds and the highest peak."""
    found = [timed(command) for command in commands]
    return sum(seconds for seconds, _ in found), max(peak for _, peak in found)


class Files:
    """The paths of the files of one run."""

    def __init__(self, cvol, folder, data):
        self.cvol, self.folder = cvol, folder
        self.about = run_json([os.path.join(BENCH, 'volumes.py'), rendered_path('brain', data),
                               self('brain.raw')])
        self.dims = 'x'.join(map(str, self.about['dims']))
        timed([os.path.join(TOOLS, 'crop.py'), 'mask', self.dims, self('mask.raw')])
        for name, kind in (('brain', self.about['type']), ('mask', 'float32')):
            self.compress(name + '.raw', name + '.cvol', kind, 30)

    def __call__(self, name):
        return os.path.join(self.folder, name)

    def raw(self, kind):
        spacing = ','.join(f'{s:.9g}' for s in self.about['spacing'])
        return ['--dims', self.dims, '--type', kind, '--spacing', spacing]

    def compressing(self, source, target, kind, ratio):
        return [self.cvol, 'compress', self(source), self(target), '--ratio', f'{ratio:.6g}',
                '--json'] + self.raw(kind)

    def compress(self, *arguments):
        return run_json(self.compressing(*arguments))

    def psnr(self, packed):
        """Returns the errors of a file, compared with the reference."""
        return run_json([self.cvol, 'compare', self('truth.raw'), self(packed), '--json'] +
                        self.raw('float32'))['psnr_db']


def measure_operation(files, operation, rounds):
    operate = os.path.join(TOOLS, 'operate.py')
    kind = files.about['type']
    timed([operate, operation, files('brain.raw'), kind, files('mask.raw'), 'float32',
           files('truth.raw')])
    ours = [files.cvol, operation, files('brain.cvol'), files('mask.cvol'), '-o',
            files('out.cvol')]
    timed(ours)
    size = os.path.getsize(files('out.cvol'))
    samples = os.path.getsize(files('truth.raw')) // 4
    dense = [[files.cvol, 'decompress', files('brain.cvol'), files('a.raw')],
             [files.cvol, 'decompress', files('mask.cvol'), files('b.raw')],
             [operate, operation, files('a.raw'), kind, files('b.raw'), 'float32',
              files('dense.raw')],
             files.compressing('dense.raw', 'dense.cvol', 'float32', 4 * samples / size)]
    turns = [(timed(ours), timed_all(dense)) for _ in range(rounds)]
    direct = files.compress('truth.raw', 'direct.cvol', 'float32', 4 * samples / size)
    quality = {name: files.psnr(name + '.cvol') for name in ('out', 'dense', 'direct')}
    seconds, peaks = [[min(turn[way][i] for turn in turns) for way in (0, 1)] for i in (0, 1)]
    return {'part': 'volumes', 'operation': operation, 'dims': files.dims,
            'file MB': f'{size / 1e6:.3f}', 'ratio': f'{4 * samples / size:.1f}',
            'cvol s': f'{seconds[0]:.3f}',
            'dense s': f'{seconds[1]:.3f}', 'dense/cvol': f'{seconds[1] / seconds[0]:.1f}',
            'cvol peak MB': f'{peaks[0]:.0f}', 'dense peak MB': f'{peaks[1]:.0f}',
            'PSNR dB': f"{quality['out']:.2f}", 'dense PSNR dB': f"{quality['dense']:.2f}",
            'truth compressed dB': f"{quality['direct']:.2f}",
            'direct file MB': f"{direct['file_bytes'] / 1e6:.3f}",
            'less dB': f"{quality['direct'] - quality['out']:.2f}"}


def measure_volumes(arguments, cvol):
    """Returns rows, and lines of the report."""
    rows = []
    with tempfile.TemporaryDirectory(prefix='cvol-bench-') as folder:
        files = Files(cvol, folder, arguments.data)
        for operation in OPERATIONS:
            try:
                rows.append(measure_operation(files, operation, min(arguments.rounds, 3)))
                say(f"{operation}: cvol {rows[-1]['cvol s']} s, dense {rows[-1]['dense s']} s")
            except Failed as problem:
                rows.append({'part': 'volumes', 'operation': operation,
                             'notes': f'failed: {problem}'})
                say(f'{operation}: failed: {problem}')
    columns = ['operation', 'dims', 'cvol s', 'dense s', 'dense/cvol', 'cvol peak MB',
               'dense peak MB', 'file MB', 'PSNR dB', 'dense PSNR dB', 'truth compressed dB',
               'less dB', 'notes']
    return rows, ['## Through the command', '', markdown(columns, rows), '',
                  'The brain and a smooth ball, both at 1/30, all cores. *Dense*: decompress both, '
                  'numpy, compress to the size of the other result; seconds in all, the '
                  'highest peak. *Truth compressed*: the exact result compressed to '
                  'that size; *less*: how far the compressed way stays behind it.', '']
