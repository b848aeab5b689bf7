"""Writes the small volumes that failures.py reads, without packages beyond Python's own."""
import json
import math
import os
import shutil
import struct
import subprocess
import sys

SMALL = (20, 17, 13)
TWO_BRICKS = (70, 10, 9)  # two bricks of 64 samples


def samples(shape, top=200, seed=1):
    """A ball, waves and a little noise, from 0 to top."""
    nx, ny, nz = shape
    values = []
    for z in range(nz):
        for y in range(ny):
            for x in range(nx):
                r = math.hypot(x / nx - 0.5, y / ny - 0.5, z / nz - 0.5)
                seed = (seed * 1103515245 + 12345) % (1 << 31)
                value = 0.6 * (r < 0.36) + 0.15 * math.sin(x / 3) * math.cos(y / 4 + z / 5) + 0.2
                values.append(int(top * min(max(value + (seed >> 16) / (1 << 15) / 40, 0), 1)))
    return values


def write(name, *parts):
    with open(name, "wb") as file:
        for part in parts:
            file.write(part if isinstance(part, bytes) else part.encode())


def nrrd(name, shape, values, kind="uint8"):
    code = {"uint8": "B", "uint16": "H", "float": "f"}[kind]
    write(name, "NRRD0004\ntype: %s\ndimension: 3\nsizes: %d %d %d\nencoding: raw\nendian: little\n\n" %
          (kind, *shape), struct.pack("<%d%s" % (len(values), code), *values))


def mrc(name, shape, values):
    header = struct.pack("<10i", *shape, 1, 0, 0, 0, *shape) + struct.pack("<6f", *shape, 90, 90, 90)
    header += struct.pack("<3i", 1, 2, 3) + bytes(140 - 12) + b""
    header = header.ljust(208, b"\0") + b"MAP " + b"\x44\x44\0\0"
    write(name, header.ljust(1024, b"\0"), struct.pack("<%dh" % len(values), *values))


def vtk(name, shape, values):
    write(name, "# vtk DataFile Version 3.0\nvolume\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS %d %d %d\n"
          "ORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA %d\nSCALARS s unsigned_char 1\nLOOKUP_TABLE default\n" %
          (*shape, len(values)), bytes(values))


def dicom(folder, shape, values):
    """A series of MR slices, explicit little endian."""
    os.mkdir(folder)

    def element(group, item, kind, value):
        if not isinstance(value, bytes):
            value = value.encode()
        value += (b"\0" if kind in ("UI", "OB", "OW") else b" ") * (len(value) % 2)
        if kind in ("OB", "OW"):
            return struct.pack("<HH2sHI", group, item, kind.encode(), 0, len(value)) + value
        return struct.pack("<HH2sH", group, item, kind.encode(), len(value)) + value

    def word(group, item, value):
        return element(group, item, "US", struct.pack("<H", value))

    nx, ny, nz = shape
    syntax, image = "1.2.840.10008.1.2.1", "1.2.840.10008.5.1.4.1.1.4"
    for z in range(nz):
        uid = "1.2.3.4.%d" % (z + 1)
        meta = element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", image) + element(2, 3, "UI", uid)
        meta += element(2, 0x10, "UI", syntax) + element(2, 0x12, "UI", "1.2.3")
        body = element(8, 0x16, "UI", image) + element(8, 0x18, "UI", uid) + element(8, 0x60, "CS", "MR")
        body += element(0x18, 0x50, "DS", "1") + element(0x20, 0xd, "UI", "1.2.3.8") + element(0x20, 0xe, "UI", "1.2.3.9")
        body += element(0x20, 0x11, "IS", "1") + element(0x20, 0x13, "IS", str(z + 1))
        body += element(0x20, 0x32, "DS", "0\\0\\%d" % z) + element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")
        body += word(0x28, 2, 1) + element(0x28, 4, "CS", "MONOCHROME2") + word(0x28, 0x10, ny) + word(0x28, 0x11, nx)
        body += element(0x28, 0x30, "DS", "1\\1") + word(0x28, 0x100, 16) + word(0x28, 0x101, 16) + word(0x28, 0x102, 15)
        body += word(0x28, 0x103, 0)
        part = values[z * nx * ny:(z + 1) * nx * ny]
        body += element(0x7fe0, 0x10, "OW", struct.pack("<%dH" % len(part), *part))
        write("%s/%02d.dcm" % (folder, z), bytes(128), b"DICM", element(2, 0, "UL", struct.pack("<I", len(meta))), meta, body)


def hdf5(name, shape):
    """Only where some Python has h5py."""
    text = ("import h5py, numpy, sys\nn = [int(x) for x in sys.argv[2:]][::-1]\n"
            "with h5py.File(sys.argv[1], 'w') as f:\n"
            "    f.create_dataset('v', data=numpy.arange(n[0] * n[1] * n[2], dtype='u2').reshape(n), chunks=(4, 8, 8),"
            " compression='gzip')\n")
    for python in (sys.executable, "/usr/bin/python3"):
        if os.path.exists(python) and not subprocess.run([python, "-c", text, name, *map(str, shape)],
                                                         capture_output=True, check=False).returncode:
            return


def make(cvol):
    """Writes all inputs into the current folder."""
    def run(*words):
        subprocess.run([cvol, *words, "--threads", "1"], check=True, capture_output=True, timeout=120)

    small = samples(SMALL)
    nrrd("a.nrrd", SMALL, small)
    nrrd("b.nrrd", SMALL, samples(SMALL, 180, 7))
    nrrd("f.nrrd", SMALL, [v / 7 for v in small], "float")
    nrrd("holes.nrrd", SMALL, [1e35 if v < 60 else v / 7 for v in small], "float")
    nrrd("speck.nrrd", SMALL, [v == 2000 for v in range(len(small))])
    nrrd("two.nrrd", TWO_BRICKS, samples(TWO_BRICKS, 3000), "uint16")
    write("a.raw", bytes(small))
    nrrd("labels.nrrd", SMALL, [(v > 60) + (v > 120) * 2 for v in small])
    mrc("a.mrc", SMALL, small)
    vtk("a.vtk", SMALL, small)
    dicom("dicom", SMALL, small)
    hdf5("a.h5", SMALL)
    write("poses.csv", "0,10,0\n40,20,5\n")
    write("attributes.json", '{"patient": "none", "list": [1, 2, {"a": null}]}\n')
    write("labels.txt", "1 255 0 0 1 1 1 \"Bone\"\n3 0 255 0 1 1 1 \"Skin\"\n")
    write("kernel.json", '{"taps": [1, 2, 1]}\n')
    write("transfer.json", '{"points": [[0, 0, 0, 0, 0], [100, 1, 0.5, 0.2, 0.1], [200, 1, 1, 1, 0.9]]}\n')
    for name, words in (("a", "--psnr 40"), ("b", "--psnr 40"), ("two", "--psnr 45"), ("exact", "--lossless"),
                        ("bound", "--max-error 2"), ("holes", "--psnr 40"), ("speck", "--lossless --labels no"),
                         ("whole", "--transform dct --block 0 --keep 6,300")):
        source = name + ".nrrd" if os.path.exists(name + ".nrrd") else "a.nrrd"
        run("compress", source, name + ".cvol", *words.split())
    run("compress", "labels.nrrd", "labels.cvol", "--labels", "yes", "--label-table", "labels.txt")
    run("compress", "a.nrrd", "b.nrrd", "-o", "series.cvol", "--time-step", "2", "--psnr", "38")
    run("compress", "a.nrrd", "b.nrrd", "-o", "channels.cvol", "--as", "channels", "--psnr", "38")
    run("decompress", "labels.cvol", "labels.zarr")
    with open("labels.zarr/.zattrs", encoding="utf-8") as file:
        attributes = json.load(file)
    attributes["image-label"] = {"colors": [{"label-value": 1, "rgba": [255, 0, 0, 255]}],
                                 "properties": [{"label-value": 1, "name": "Bone"}, {"label-value": 3, "name": "Skin"}]}
    write("labels.zarr/.zattrs", json.dumps(attributes))
    run("bake", "a.cvol", "-o", "baked.cvol", "--axis", "z")
    os.makedirs("alone/web")  # a copy of the command, with a stand-in for the page of cvol export
    shutil.copy(cvol, "alone/cvol")
    version = subprocess.run([cvol, "--version"], check=True, capture_output=True, text=True).stdout.strip()
    write("alone/web/viewer.html", "<meta content=\"%s\"><title><!--cvol:title--></title><!--cvol:caption-->"
          "<!--cvol:volumes-->end" % version)
    for form in ("nii", "nii.gz", "mha", "mhd", "npy", "tif", "vti", "nhdr", "zarr"):
        run("decompress", "a.cvol", "in-%s.%s" % (form.replace(".", ""), form))
    run("render", "a.cvol", "-o", "a.png", "--size", "24")
    run("render", "b.cvol", "-o", "b.png", "--size", "24")
    run("compress", "a.png", "a.cvi", "--psnr", "35")
