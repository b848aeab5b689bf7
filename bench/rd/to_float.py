#!/usr/bin/python3
"""Converts a file of raw little-endian samples to float32, in place. usage: to_float.py FILE TYPE"""
import sys

import numpy


def main():
    path, kind = sys.argv[1:]
    if kind != 'float32':
        numpy.fromfile(path, dtype=numpy.dtype(kind).newbyteorder('<')).astype('<f4').tofile(path)


if __name__ == '__main__':
    main()
