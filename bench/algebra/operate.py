#!/usr/bin/python3
"""Adds or multiplies two raw files of samples: OUT.raw = A.raw OP B.raw, as float32.

usage: operate.py add|multiply A.raw TYPE B.raw TYPE OUT.raw
"""
import sys

import numpy


def main():
    operation, path_a, type_a, path_b, type_b, out = sys.argv[1:]
    a = numpy.fromfile(path_a, dtype=numpy.dtype(type_a)).astype(numpy.float32)
    b = numpy.fromfile(path_b, dtype=numpy.dtype(type_b)).astype(numpy.float32)
    (a + b if operation == 'add' else a * b).tofile(out)


if __name__ == '__main__':
    main()
