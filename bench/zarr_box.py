#!/usr/bin/python3
"""Bytes and time of a box of 64^3 samples from a Zarr array, compressed by cvol, by zfp and by blosc with zstd.

The array is the middle of a scan, --size samples a side, in chunks of 64^3. zfp (numcodecs' ZFPY, on the samples as
float32) compresses it with the largest tolerance, a power of 2, that gives at least --psnr over the whole array; cvol
to at least the PSNR that zfp has then; blosc is lossless. --boxes boxes at random places, the same for all, are read
from files that the operating system has in memory.
Needs zarr, numcodecs, zfpy, and the library of the build in CVOL_LIBRARY.
"""
import argparse
import os
import sys
import tempfile
import time

import numpy
import zarr
from numcodecs import Blosc
from numcodecs.zfpy import ZFPY

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'python'))
import cvol  # noqa: E402
from cvol.codecs import Cvol  # noqa: E402

CHUNK, BOX = 64, 64


class Counting(zarr.DirectoryStore):
    """Counts the bytes of the chunks that are read."""

    bytes_read = 0

    def __getitem__(self, key):
        value = super().__getitem__(key)
        self.bytes_read += len(value)
        return value


def psnr(array, original):
    error = array[:].astype('float32') - original
    return 20 * numpy.log10(numpy.ptp(original) / numpy.sqrt(numpy.mean(error * error)))


def make(folder, name, samples, compressor):
    store = Counting(os.path.join(folder, name))
    begin = time.perf_counter()
    array = zarr.array(samples, chunks=CHUNK, compressor=compressor, store=store, overwrite=True)
    return array, time.perf_counter() - begin


def codecs_of_one_psnr(folder, samples, wanted):
    """cvol and zfp; cvol has at least the PSNR of zfp, and zfp at least the wanted one."""
    floats = samples.astype('float32')
    for exponent in range(int(numpy.log2(numpy.ptp(floats))), -20, -1):
        zfp = ZFPY(tolerance=2.0 ** exponent)
        reached = psnr(make(folder, 'zfp', floats, zfp)[0], floats)
        if reached >= wanted:
            break
    target = reached
    while True:
        own = Cvol(psnr=round(target, 2))
        short = reached - psnr(make(folder, 'cvol', samples, own)[0], floats)
        if short <= 0:
            return own, zfp
        target += short + 0.01


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scan', help='a file that cvol.read reads')
    parser.add_argument('--size', type=int, default=256)
    parser.add_argument('--psnr', type=float, default=45)
    parser.add_argument('--boxes', type=int, default=20)
    options = parser.parse_args()
    scan, _ = cvol.read(options.scan)
    middle = tuple(slice((n - min(n, options.size)) // 2, (n + min(n, options.size)) // 2) for n in scan.shape)
    samples = numpy.ascontiguousarray(scan[middle])
    rng = numpy.random.default_rng(7)
    places = [[int(rng.integers(0, n - BOX + 1)) for n in samples.shape] for _ in range(options.boxes)]
    print(f'{samples.shape} {samples.dtype}, {samples.nbytes} bytes, {options.boxes} boxes of {BOX}^3')
    with tempfile.TemporaryDirectory() as folder:
        floats = samples.astype('float32')
        own, zfp = codecs_of_one_psnr(folder, samples, options.psnr)
        print('| codec | PSNR | bytes stored | of raw | bytes per box | ms per box | s to write |')
        print('|---|---:|---:|---:|---:|---:|---:|')
        for name, codec, values in (('cvol', own, samples), ('zfp', zfp, floats),
                                    ('blosc, zstd', Blosc('zstd', 9, Blosc.BITSHUFFLE), samples)):
            array, seconds = make(folder, name, values, codec)
            array.store.bytes_read = 0
            times = []
            for place in places:
                begin = time.perf_counter()
                array[tuple(slice(p, p + BOX) for p in place)]
                times.append(1000 * (time.perf_counter() - begin))
            with numpy.errstate(divide='ignore'):
                decibels = psnr(array, floats)
            stored = array.nbytes_stored
            print(f'| {name} | {decibels:.2f} | {stored} | {100 * stored / samples.nbytes:.2f} % '
                  f'| {array.store.bytes_read // len(places)} | {numpy.median(times):.1f} | {seconds:.1f} |')


if __name__ == '__main__':
    main()
