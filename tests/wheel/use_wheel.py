"""Compresses, reads, renders and writes with the cvol of the path; writes what it made into the working folder.

With SITE, the cvol must lie there, and use no shared library outside it but glibc's.

usage: use_wheel.py NIFTI [SITE]
"""

import ctypes  # noqa: F401 (its libraries are not cvol's)
import json
import re
import shutil
import struct
import sys
from pathlib import Path

import numpy as np

try:
    import PIL.Image
except ImportError:
    PIL = None
try:
    import numcodecs
except ImportError:
    numcodecs = None


def mapped():
    """The shared libraries of the process."""
    return set(re.findall(r"\s(/\S+\.so[.\d]*)$", Path("/proc/self/maps").read_text(), re.M))


def read_pictures():
    """PNG, JPEG, and TIFF with compressions of the libraries in the wheel."""
    if not PIL:
        return
    picture = PIL.Image.fromarray(np.clip(array[20], 0, 255).astype("u1"))
    for ending in ("png", "jpg"):
        Path(ending).mkdir()
        for k in range(3):
            picture.save(f"{ending}/{k}.{ending}")
        print(ending, float(cvol.read(ending)[0].mean()))
    for compression in ("tiff_lzw", "tiff_adobe_deflate", "jpeg", "packbits"):
        picture.save("page.tif", compression=compression)
        print(compression, float(cvol.read("page.tif")[0].mean()))


def read_chunks():
    """Zarr chunks by blosc with each codec that blosc has in the wheel."""
    if not numcodecs:
        return
    for codec in ("blosclz", "lz4", "lz4hc", "zlib", "zstd"):
        print(codec, np.array_equal(cvol.read(write_chunk(codec))[0], array))


def write_chunk(codec):
    """Writes a Zarr array of one chunk; returns its folder."""
    folder = Path(f"{codec}.zarr")
    folder.mkdir()
    blosc = numcodecs.Blosc(cname=codec)
    described = {"zarr_format": 2, "shape": array.shape, "chunks": array.shape, "dtype": "<i2", "order": "C",
                 "fill_value": 0, "filters": None, "compressor": blosc.get_config()}  # fmt: skip
    (folder / ".zarray").write_text(json.dumps(described))
    (folder / "0.0.0").write_bytes(blosc.encode(array))
    return folder


def read_left_out():
    """What the wheel leaves out is refused by a sentence (the build's library may read it)."""
    if len(sys.argv) < 3:
        return
    cvol.write("a.tif", array)
    data = Path("a.tif").read_bytes()
    for scheme, name in ((34661, "JBIG"), (34887, "LERC")):
        at = data.index(struct.pack("<HHIHH", 259, 3, 1, 1, 0))
        Path("left-out.tif").write_bytes(data[: at + 8] + struct.pack("<H", scheme) + data[at + 10 :])
        refuse("left-out.tif", f"{name}) is not in this build")
    if numcodecs:
        refuse(write_chunk("snappy"), "blosc has no Snappy")
    Path("left-out.tif").unlink()
    shutil.rmtree("snappy.zarr", ignore_errors=True)


def refuse(path, words):
    try:
        cvol.read(path)
    except cvol.Error as error:
        assert words in str(error), error
    else:
        raise AssertionError(f"{path} was read")


nifti = sys.argv[1]
before = mapped()
import cvol  # noqa: E402

z, y, x = np.mgrid[-1:1:40j, -1:1:48j, -1:1:56j]
array = (200 * np.exp(-4 * (z * z + y * y + x * x)) + 20 * np.sin(9 * x)).astype("i2")
v = cvol.compress(array, psnr=45, spacing=(2, 1, 0.5))
v.save("array.cvol")
print(v, round(v.info.psnr_db, 2))

head = cvol.open(nifti, compress=False)
box = head[60:120, 40:150:2, 40:140:2]
print(head.shape, head.spacing, box.mean())
head = cvol.compress(box, ratio=20)
head.save("head.cvol")
cvol.save_png("head.png", head.render(size=120, azimuth=30))

for name in ("a.nii.gz", "a.tif", "a.npy", "a.vti"):
    cvol.write(name, array)
    print(name, np.array_equal(cvol.open(name), array))
read_pictures()
read_chunks()
read_left_out()

if len(sys.argv) > 2:
    site = sys.argv[2]
    assert cvol.__file__.startswith(site), cvol.__file__
    others = r"/lib-dynload/|/(libc|libm|libpthread|libdl|librt|ld-linux-x86-64)\.so\.\d$"  # Python's and glibc's
    used = {path for path in mapped() - before if not re.search(others, path)}
    assert len(used) >= 3 and all(path.startswith(site) for path in used), used
