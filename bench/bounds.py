#!/usr/bin/python3
"""Bounds and exactness, checked sample by sample outside of cvol.

Every volume is compressed with --max-error E for E of 1e-1 to 1e-5 of its range, and with --lossless, and
decompressed by the command; numpy compares every sample with the original. Lossless files are compared with zstd
-19 and with zfp's reversible mode (integers of 8 and 16 bits as int32) for the same samples. A volume with a marker
of missing samples is compressed with --fill, and the marked samples must be restored.
"""
import argparse
import ctypes
import ctypes.util
import os
import subprocess
import sys
import tempfile

import numpy

from tables import (Failed, add_common_arguments, check_cvol, markdown, provenance, run, run_json, say,
                    unfolded, write_results)
from volumes import Refused, all_paths, folder_paths, read_volume, short_name

PARTS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
FILLS = {'ocean_v': 1e35}
ZFP_TYPES = {'int32': 1, 'int64': 2, 'float32': 3, 'float64': 4}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common_arguments(parser)
    parser.add_argument('--volumes', metavar='A,B', help='names without ending (default all)')
    parser.add_argument('--threads', type=int, default=1, help="cvol's (default 1)")
    parser.add_argument('--no-lossless', action='store_true', help='bounds alone')
    return parser.parse_args()


def zfp_bytes(samples):
    """Returns the bytes of zfp's reversible mode; None without libzfp."""
    name = ctypes.util.find_library('zfp')
    if not name:
        return None
    zfp = ctypes.CDLL(name)
    kind = samples.dtype.name
    if kind in ('uint8', 'int8', 'uint16', 'int16'):
        kind = 'int32'
    elif kind == 'uint32':
        kind = 'int64'
    data = numpy.ascontiguousarray(samples, kind)
    for function in ('zfp_field_3d', 'zfp_stream_open', 'stream_open'):
        getattr(zfp, function).restype = ctypes.c_void_p
    zfp.zfp_stream_maximum_size.restype = zfp.zfp_compress.restype = ctypes.c_size_t
    nz, ny, nx = (ctypes.c_size_t(n) for n in data.shape)
    field = ctypes.c_void_p(zfp.zfp_field_3d(data.ctypes.data_as(ctypes.c_void_p), ZFP_TYPES[kind], nx, ny,
                                             nz))
    stream = ctypes.c_void_p(zfp.zfp_stream_open(None))
    zfp.zfp_stream_set_reversible(stream)
    size = zfp.zfp_stream_maximum_size(stream, field)
    room = numpy.empty(size, numpy.uint8)
    bits = ctypes.c_void_p(zfp.stream_open(room.ctypes.data_as(ctypes.c_void_p), ctypes.c_size_t(size)))
    zfp.zfp_stream_set_bit_stream(stream, bits)
    zfp.zfp_stream_rewind(stream)
    found = zfp.zfp_compress(stream, field)
    zfp.zfp_field_free(field)
    zfp.zfp_stream_close(stream)
    zfp.stream_close(bits)
    return found or None


def zstd_bytes(path):
    done = subprocess.run(['zstd', '-19', '-q', '-c', path], stdout=subprocess.PIPE, check=True)
    return len(done.stdout)


class Volume:
    def __init__(self, arguments, cvol, path, folder):
        self.cvol, self.threads, self.name = cvol, str(arguments.threads), short_name(path)
        self.samples, self.kind, _ = read_volume(path, stored=True)
        self.raw, self.packed, self.back = (os.path.join(folder, 'volume' + end)
                                            for end in ('.raw', '.cvol', '.back.raw'))
        self.samples.tofile(self.raw)
        self.options = ['--dims', 'x'.join(map(str, self.samples.shape[::-1])), '--type', self.kind]
        self.valued = numpy.isfinite(self.samples)
        if self.name in FILLS:
            self.valued &= self.samples != self.samples.dtype.type(FILLS[self.name])
            self.options += ['--fill', repr(FILLS[self.name])]
        valued = self.samples[self.valued]
        self.range = float(valued.max()) - float(valued.min())

    def round_trip(self, *options):
        """Returns the report of compress, and the decompressed samples."""
        said = run_json([self.cvol, 'compress', self.raw, self.packed, '--json', '--threads', self.threads,
                         *options] + self.options)
        run([self.cvol, 'verify', self.packed])
        run([self.cvol, 'decompress', self.packed, self.back, '--threads', self.threads])
        back = numpy.fromfile(self.back, self.samples.dtype).reshape(self.samples.shape)
        return said, back

    def is_same(self, back, where=...):
        bits = f'u{self.samples.dtype.itemsize}'
        return numpy.array_equal(back.view(bits)[where], self.samples.view(bits)[where])

    def bound(self, part):
        """Returns a row: the bits per sample, and the largest error as a multiple of E."""
        limit = part * self.range
        said, back = self.round_trip('--max-error', repr(limit))
        worst = 0.0
        for ours, theirs, has in zip(back, self.samples, self.valued):
            error = numpy.abs(ours[has].astype(numpy.longdouble) - theirs[has].astype(numpy.longdouble))
            worst = max(worst, float(error.max(initial=0)))
        wrong = []
        if not worst <= limit:
            wrong.append(f'VIOLATED: {worst!r} is more than {limit!r}')
        if not self.is_same(back, ~self.valued):
            wrong.append('VIOLATED: samples without a value changed')
        return {'volume': self.name, 'type': self.kind, 'asked': f'{part:g} of range',
                'bits': f"{8 * said['file_bytes'] / self.samples.size:.4f}",
                'worst / E': f'{worst / limit:.6f}', 'notes': '; '.join(wrong)}

    def lossless(self):
        said, back = self.round_trip('--lossless')
        theirs = [n for n in (zstd_bytes(self.raw), zfp_bytes(self.samples)) if n]
        best = min(theirs)
        notes = [] if self.is_same(back) else ['VIOLATED: bits differ']
        if said['file_bytes'] > 1.1 * best:
            notes.append('VIOLATED: more than 10 % larger')
        return {'volume': self.name, 'type': self.kind, 'asked': 'lossless',
                'bits': f"{8 * said['file_bytes'] / self.samples.size:.4f}",
                'bytes': said['file_bytes'], 'zstd -19': theirs[0],
                'zfp': theirs[1] if len(theirs) > 1 else '', 'cvol / best': f"{said['file_bytes'] / best:.3f}",
                'notes': '; '.join(notes)}


def measure(arguments, cvol, path, folder):
    rows = []
    try:
        volume = Volume(arguments, cvol, path, folder)
    except Refused as problem:
        say(str(problem))
        return rows
    for part in PARTS + (() if arguments.no_lossless else (0,)):
        try:
            rows.append(volume.bound(part) if part else volume.lossless())
        except Failed as problem:
            rows.append({'volume': volume.name, 'asked': part, 'notes': f'VIOLATED: {problem}'})
        say(str(rows[-1]))
    return rows


def main():
    arguments = parse_arguments()
    cvol = check_cvol(arguments.cvol)
    wanted = arguments.volumes.split(',') if arguments.volumes else None
    paths = [p for p in all_paths(arguments.data) + folder_paths(arguments.data)
             if not wanted or short_name(p) in wanted]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for path in sorted((unfolded(cvol, p, folder) for p in paths), key=os.path.getsize):
            rows += measure(arguments, cvol, path, folder)
    bounds = [r for r in rows if r['asked'] != 'lossless']
    exact = [r for r in rows if r['asked'] == 'lossless']
    violated = sum('VIOLATED' in r['notes'] for r in rows)
    text = '\n'.join(['# Bounds of every sample, and exactness', '', *provenance(cvol), '',
                      f'{len(rows)} files, {violated} of them violate what was asked.', '',
                      markdown(['volume', 'type', 'asked', 'bits', 'worst / E', 'notes'], bounds), '',
                      markdown(['volume', 'type', 'bits', 'bytes', 'zstd -19', 'zfp', 'cvol / best',
                                'notes'], exact)])
    write_results(arguments.results, 'bounds', text, rows)
    sys.exit(1 if violated else 0)


if __name__ == '__main__':
    main()
