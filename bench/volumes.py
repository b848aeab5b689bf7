#!/usr/bin/python3
"""The bench's volumes: their paths, and their samples as plain raw files for other programs.

usage: volumes.py VOLUME OUT.raw     writes the samples (little-endian, x fastest) and prints
                                     {"dims", "type", "spacing"}

Reads only simple headers (NRRD attached, raw or gzip; MetaImage with its samples in the same file; NIfTI-1 .nii and
.nii.gz; folders of TIFF slices; raw with dims and type in the name) and refuses others: other programs get exactly
the samples that cvol gets.
"""
import argparse
import gzip
import json
import os
import re
import struct
import sys
import zlib

BENCH = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(BENCH)
DEFAULT_DATA = os.path.join(os.path.dirname(ROOT), 'shared', 'data')

# Volumes with transfer functions in bench/transfer; the brain is the project's sample.
RENDERED = {'brain': None, 'vhf_head': 'vhf_head.mha', 'cthead_8bit': 'cthead_8bit.nrrd',
            'embryo': 'embryo.nrrd', 'fibsem_250': 'fibsem_250.nrrd',
            'mouse_brain': 'mouse_brain_tiff', 'inia19': 'inia19.nii.gz'}
# Volumes of the tables that take long.
USUAL = ('brain', 'vhf_head', 'cthead_8bit', 'embryo')

READABLE = ('.nrrd', '.nii', '.nii.gz', '.mha', '.raw')


class Refused(Exception):
    """This reader does not support a file or a header."""


def rendered_path(name, data):
    if name == 'brain':
        return os.path.join(ROOT, 'samples', 'ch2better.nii.gz')
    return os.path.join(data, RENDERED[name])


def transfer_path(name, look):
    return os.path.join(BENCH, 'transfer', f'{name}_{look}.json')


def all_paths(data):
    """Returns the sample and every file of the data folder that cvol reads alone, sorted by name."""
    paths = [rendered_path('brain', data)]
    if os.path.isdir(data):
        paths += [os.path.join(data, name) for name in sorted(os.listdir(data))
                  if name.endswith(READABLE) and name != os.path.basename(paths[0])]
    return [path for path in paths if os.path.exists(path)]


def folder_paths(data):
    """Returns folders of slices, which cvol reads as volumes."""
    if not os.path.isdir(data):
        return []
    return [os.path.join(data, name) for name in sorted(os.listdir(data))
            if os.path.isdir(os.path.join(data, name))]


def unread_names(data):
    """Returns the other entries of the data folder: formats that are folders, or that cvol does not read."""
    if not os.path.isdir(data):
        return []
    return [name for name in sorted(os.listdir(data))
            if not name.endswith(READABLE) and not name.endswith('.md')]


def short_name(path):
    name = os.path.basename(path)
    for ending in sorted(READABLE, key=len, reverse=True):
        if name.endswith(ending):
            return name[:-len(ending)]
    return name


def raw_options(path):
    """Returns the options of cvol for NAME_NXxNYxNZ_TYPE.raw; nothing for other formats."""
    if not path.endswith('.raw'):
        return []
    dims, kind = raw_name(path)
    return ['--dims', 'x'.join(map(str, dims)), '--type', kind]


def raw_name(path):
    match = re.search(r'_(\d+)x(\d+)x(\d+)_([a-z]+\d+)\.raw$', path)
    if not match:
        raise Refused(f'{path}: the name must end in _NXxNYxNZ_TYPE.raw')
    return [int(n) for n in match.groups()[:3]], match.group(4)


# ---- readers: each returns dims, type, spacing and the bytes, as little-endian samples ----------

NRRD_TYPES = {'uchar': 'uint8', 'unsigned char': 'uint8', 'uint8': 'uint8', 'uint8_t': 'uint8',
              'signed char': 'int8', 'int8': 'int8', 'int8_t': 'int8',
              'short': 'int16', 'int16': 'int16', 'int16_t': 'int16',
              'ushort': 'uint16', 'unsigned short': 'uint16', 'uint16': 'uint16',
              'uint16_t': 'uint16', 'float': 'float32', 'double': 'float64'}


def read_nrrd(path):
    with open(path, 'rb') as file:
        content = file.read()
    head, _, body = content.partition(b'\n\n')
    lines = head.decode('ascii').splitlines()
    if not lines[0].startswith('NRRD'):
        raise Refused(f'{path}: not an NRRD file')
    fields = dict(line.split(': ', 1) for line in lines[1:] if ': ' in line and line[0] != '#')
    kind = NRRD_TYPES.get(fields['type'])
    if fields.get('dimension') != '3' or not kind or 'data file' in fields:
        raise Refused(f'{path}: not a plain three-dimensional NRRD file')
    if kind[-1] != '8' and fields.get('endian', 'little') != 'little':
        raise Refused(f'{path}: big-endian samples')
    if fields['encoding'] in ('gzip', 'gz'):
        body = gzip.decompress(body)
    elif fields['encoding'] != 'raw':
        raise Refused(f'{path}: encoding {fields["encoding"]}')
    if 'spacings' in fields:
        spacing = [float(s) for s in fields['spacings'].split()]
    elif 'space directions' in fields:
        vectors = re.findall(r'\(([^)]*)\)', fields['space directions'])
        spacing = [sum(float(c) ** 2 for c in v.split(',')) ** 0.5 for v in vectors]
    else:
        spacing = [1.0, 1.0, 1.0]
    return [int(n) for n in fields['sizes'].split()], kind, spacing, body


META_TYPES = {'MET_UCHAR': 'uint8', 'MET_CHAR': 'int8', 'MET_SHORT': 'int16',
              'MET_USHORT': 'uint16', 'MET_FLOAT': 'float32', 'MET_DOUBLE': 'float64'}


def read_metaimage(path):
    fields = {}
    with open(path, 'rb') as file:
        while 'ElementDataFile' not in fields:
            line = file.readline()
            if b'=' not in line:
                raise Refused(f'{path}: not a MetaImage header')
            key, value = line.decode('ascii').split('=', 1)
            fields[key.strip()] = value.strip()
        body = file.read()
    kind = META_TYPES.get(fields['ElementType'])
    if fields['NDims'] != '3' or not kind or fields['ElementDataFile'] != 'LOCAL':
        raise Refused(f'{path}: not a plain three-dimensional MetaImage file')
    if fields.get('BinaryDataByteOrderMSB', fields.get('ElementByteOrderMSB', 'False')) == 'True':
        raise Refused(f'{path}: big-endian samples')
    if fields.get('CompressedData', 'False') == 'True':
        body = zlib.decompress(body, wbits=47)  # zlib or gzip
    spacing = fields.get('ElementSpacing', '1 1 1')
    return ([int(n) for n in fields['DimSize'].split()], kind,
            [float(s) for s in spacing.split()], body)


NIFTI_TYPES = {2: 'uint8', 4: 'int16', 16: 'float32', 64: 'float64', 256: 'int8', 512: 'uint16'}


def read_nifti(path, stored=False):
    opener = gzip.open if path.endswith('.gz') else open
    with opener(path, 'rb') as file:
        content = file.read()
    if struct.unpack_from('<i', content)[0] != 348 or content[344:347] != b'n+1':
        raise Refused(f'{path}: not a little-endian single-file NIfTI-1')
    dim = struct.unpack_from('<8h', content, 40)
    kind = NIFTI_TYPES.get(struct.unpack_from('<h', content, 70)[0])
    spacing = struct.unpack_from('<8f', content, 76)[1:4]
    offset, slope, intercept = struct.unpack_from('<3f', content, 108)
    if not kind or any(n > 1 for n in dim[4:dim[0] + 1]):
        raise Refused(f'{path}: not a plain three-dimensional NIfTI-1 file')
    if (slope, intercept) not in ((1, 0), (0, 0)) and not stored:
        raise Refused(f'{path}: its samples are scaled ({slope:g} v + {intercept:g})')
    return list(dim[1:4]), kind, list(spacing), content[int(offset):]


def read_raw(path):
    dims, kind = raw_name(path)
    with open(path, 'rb') as file:
        return dims, kind, [1.0, 1.0, 1.0], file.read()


def read_slices(folder):
    """Reads a folder of TIFF slices, in the order of the numbers in their names."""
    import numpy
    from PIL import Image

    def number(name):
        return [int(n) for n in re.findall(r'\d+', name)]

    names = sorted((n for n in os.listdir(folder) if n.endswith(('.tif', '.tiff'))), key=number)
    if not names:
        raise Refused(f'{folder}: no TIFF slices in it')
    samples = numpy.stack([numpy.asarray(Image.open(os.path.join(folder, n))) for n in names])
    return samples, samples.dtype.name, [1.0, 1.0, 1.0]


def read_volume(path, stored=False):
    """Returns (numpy array in z y x order, type, spacing); stored: NIfTI's numbers before scaling."""
    import numpy
    if os.path.isdir(path):
        return read_slices(path)
    for ending, reader in (('.nrrd', read_nrrd), ('.mha', read_metaimage), ('.nii', read_nifti),
                           ('.nii.gz', read_nifti), ('.raw', read_raw)):
        if path.endswith(ending):
            more = {'stored': True} if stored and reader is read_nifti else {}
            dims, kind, spacing, body = reader(path, **more)
            break
    else:
        raise Refused(f'{path}: no reader for it here')
    of_file = numpy.dtype(kind).newbyteorder('<')
    count = dims[0] * dims[1] * dims[2]
    if len(body) < count * of_file.itemsize:
        raise Refused(f'{path}: its samples stop early')
    samples = numpy.frombuffer(body, dtype=of_file, count=count)
    return samples.reshape(dims[::-1]), kind, spacing


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('volume')
    parser.add_argument('out')
    parser.add_argument('--stored', action='store_true', help='samples before they are scaled')
    arguments = parser.parse_args()
    try:
        samples, kind, spacing = read_volume(arguments.volume, arguments.stored)
    except Refused as problem:
        sys.exit(f'volumes.py: {problem}')
    samples.tofile(arguments.out)
    print(json.dumps({'dims': list(samples.shape[::-1]), 'type': kind, 'spacing': spacing}))


if __name__ == '__main__':
    main()
