#!/usr/bin/env python3
"""Writes volumes with the usual tools of other formats, and for each the same samples as an NRRD.

usage: make_formats.py KIND     in an empty folder; status 77 if the tool is missing

Standard output is the input of tests/helpers/read_list.c: how FILE must be read.
"""
import gzip
import importlib
import os
import shutil
import struct
import subprocess
import sys
import zlib

import numpy as np

SHAPE = (5, 7, 9)  # z, y, x


def samples(kind, shape=SHAPE, seed=1):
    """Random samples over the whole range of an integer type."""
    random = np.random.default_rng(seed)
    kind = np.dtype(kind)
    if kind.kind == "f":
        return random.normal(size=shape).astype(kind)
    info = np.iinfo(kind)
    return random.integers(info.min, info.max, size=shape, dtype=kind.newbyteorder("="), endpoint=True)


def reference(name, volume):
    """Writes an NRRD of these samples."""
    volume = np.ascontiguousarray(volume)
    kind = volume.dtype
    name = name.replace("/", "_").replace(":", "_") + ".ref.nrrd"
    word = {"f4": "float", "f8": "double"}.get(kind.str[1:], kind.newbyteorder("=").name)
    with open(name, "wb") as file:
        sizes = " ".join(str(n) for n in volume.shape[::-1])
        file.write(f"NRRD0004\ntype: {word}\ndimension: 3\nsizes: {sizes}\nencoding: raw\nendian: little\n\n".encode())
        file.write(volume.astype(kind.newbyteorder("<")).tobytes())
    return name


def announce(name, volume, spacing=(1, 1, 1), *options):
    words = ",".join(s if isinstance(s, str) else f"{s:.9g}" for s in spacing)
    print(name, reference("_".join((name, *options)), volume), words, *options)


def need(*modules):
    try:
        return [importlib.import_module(module) for module in modules]
    except ImportError as error:
        print(f"skipped: {error}", file=sys.stderr)
        sys.exit(77)


def wide_volumes():
    """Names, volumes of 64-bit integers, and the samples that cvol makes of them."""
    few, large = samples("i4").astype("i8"), samples("u4").astype("i8")
    exact = few * 2**20
    return [("few", few, few.astype("i4")), ("large", large, large.astype("u4")),
            ("exact", exact, exact.astype("f8")), ("unsigned", large.astype("u8"), large.astype("u4"))]


def write_wide_text_headers(name, volume):
    """NRRD packed by gzip, high byte first; MetaImage packed by zlib."""
    sizes = " ".join(str(n) for n in volume.shape[::-1])
    signed = volume.dtype.kind == "i"
    with open(f"{name}.nrrd", "wb") as file:
        word = "int64" if signed else "unsigned long long"
        file.write(f"NRRD0004\ntype: {word}\ndimension: 3\nsizes: {sizes}\nencoding: gzip\nendian: big\n\n".encode())
        file.write(gzip.compress(volume.astype(volume.dtype.newbyteorder(">")).tobytes()))
    with open(f"{name}.mha", "wb") as file:
        word = "MET_LONG_LONG" if signed else "MET_ULONG_LONG"
        packed = zlib.compress(volume.tobytes())
        file.write(f"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                   f"CompressedData = True\nCompressedDataSize = {len(packed)}\nDimSize = {sizes}\n"
                   f"ElementType = {word}\nElementDataFile = LOCAL\n".encode())
        file.write(packed)


def make_wide():
    """64-bit integers, and complex numbers, whose magnitudes are read."""
    nibabel, h5py = need("nibabel", "h5py")

    with h5py.File("w.h5", "w") as file:
        for name, volume, narrow in wide_volumes():
            np.save(f"{name}.npy", volume)
            np.save(f"{name}_big.npy", np.asfortranarray(volume).astype(volume.dtype.newbyteorder(">")))
            file[name] = volume
            nibabel.save(nibabel.Nifti1Image(volume.T, np.diag((1, 1, 1, 1)), dtype=volume.dtype), f"{name}.nii.gz")
            write_wide_text_headers(name, volume)
            announce(f"{name}.nrrd", narrow)
            announce(f"{name}.mha", narrow)
            announce(f"{name}.npy", narrow)
            announce(f"{name}_big.npy", narrow)
            announce(f"w.h5:/{name}", narrow)
            announce(f"{name}.nii.gz", narrow)
    four = np.stack([wide_volumes()[0][1], wide_volumes()[0][1][::-1]])
    nibabel.save(nibabel.Nifti1Image(four.T, np.diag((1, 1, 1, 1)), dtype="i8"), "four.nii")
    announce("four.nii", four[1].astype("i4"), (1, 1, 1), "index=1")
    turning = (samples("f4") + 1j * samples("f4", seed=2)).astype("c8")
    magnitude = np.sqrt(turning.real.astype("f8") ** 2 + turning.imag.astype("f8") ** 2).astype("f4")
    for name, volume in (("turning", turning), ("turning_big", turning.astype(">c8"))):
        np.save(f"{name}.npy", volume)
        announce(f"{name}.npy", magnitude)
    nibabel.save(nibabel.Nifti1Image(turning.T, np.diag((1, 1, 1, 1))), "turning.nii")
    announce("turning.nii", magnitude)
    np.save("beyond.npy", np.full((2, 2, 2), 2**53 + 1, "i8"))
    np.save("below.npy", np.full((2, 2, 2), -(2**62), "i8"))
    with open("words.nrrd", "w") as file:
        file.write("NRRD0004\ntype: int64\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\n\n-7 2147483647\n")
    announce("words.nrrd", np.array([[[-7, 2**31 - 1]]], "i4"))
    for name, word, values, kind in (("u", "uint64", (0, 2**32 - 1), "u4"), ("d", "int64", (-7, 2**53), "f8")):
        with open(f"words_{name}.nrrd", "w") as file:
            file.write(f"NRRD0004\ntype: {word}\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\n\n"
                       f"{values[0]} {values[1]}\n")
        announce(f"words_{name}.nrrd", np.array([[values]], kind))
    with open("words.mha", "w") as file:
        file.write("ObjectType = Image\nNDims = 3\nBinaryData = False\nDimSize = 2 1 1\nElementType = MET_LONG_LONG\n"
                   "ElementDataFile = LOCAL\n-5000000000 3\n")
    announce("words.mha", np.array([[[-5e9, 3]]]))
    with open("words_bad.nrrd", "w") as file:
        file.write("NRRD0004\ntype: uint64\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\n\n0 -1\n")
    mixed = np.stack([few.astype("i8") for few in (samples("i2"), samples("u4"), samples("i4") * 2.0**20)])
    np.save("mixed.npy", mixed)  # the times alone are int32, uint32 and float64
    announce("mixed.npy", mixed[1].astype("u4"), (1, 1, 1), "index=1")


def make_tiff():
    (tifffile,) = need("tifffile")
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        volume = samples(kind)
        tifffile.imwrite(f"{kind}.tif", volume, photometric="minisblack")
        announce(f"{kind}.tif", volume)
    volume = samples("u2")
    tifffile.imwrite("big.tif", volume, photometric="minisblack", bigtiff=True, byteorder=">")
    announce("big.tif", volume)
    for name, options in {
        "deflate": dict(compression="zlib", predictor=True),
        "rows": dict(rowsperstrip=2),
        "tiles": dict(tile=(16, 16)),
    }.items():
        tifffile.imwrite(f"{name}.tif", volume, photometric="minisblack", **options)
        announce(f"{name}.tif", volume)
    half = samples("f4").astype("f2")
    for name, options in {
        "half": {}, "halfbig": dict(byteorder=">"), "halftiles": dict(tile=(16, 16), compression="zlib"),
    }.items():
        tifffile.imwrite(f"{name}.tif", half, photometric="minisblack", **options)
        announce(f"{name}.tif", half.astype("f4"))
    bits = samples("u1", (5, 9, 19)) > 100
    for name, options in {"bits": {}, "bitrows": dict(rowsperstrip=2)}.items():
        tifffile.imwrite(f"{name}.tif", bits, photometric="minisblack", **options)
        announce(f"{name}.tif", bits.astype("u1"))
    # ImageJ: times, slices, channels, y, x
    many = samples("u2", (2, 5, 3, 7, 9))
    tifffile.imwrite("imagej.tif", many, imagej=True, resolution=(1 / 0.25, 1 / 0.25),
                     metadata={"axes": "TZCYX", "spacing": 1.5, "unit": "um", "finterval": 0.5})
    announce("imagej.tif", many[1, :, 2], (0.25, 0.25, 1.5, "um"), "index=1", "channel=2")
    one = samples("u1")
    tifffile.imwrite("stack.tif", one, imagej=True, resolution=(2, 4), metadata={"axes": "ZYX", "spacing": 3, "unit": "um"})
    announce("stack.tif", one, (0.5, 0.25, 3))
    tifffile.imwrite("ome.ome.tif", many, photometric="minisblack",
                     metadata={"axes": "TZCYX", "PhysicalSizeX": 0.1, "PhysicalSizeY": 0.2, "PhysicalSizeZ": 0.4,
                               "TimeIncrement": 250.0, "TimeIncrementUnit": "ms",
                               "Channel": {"Name": ["DAPI", "a & <b>", "\u03b1-tubulin"], "Color": [65535, 16711935, -1]}})
    announce("ome.ome.tif", many[0, :, 1], (0.1, 0.2, 0.4, "um"), "index=0", "channel=1")
    colours = samples("u1", (5, 7, 9, 3))
    tifffile.imwrite("rgb.tif", colours, photometric="rgb")
    announce("rgb.tif", colours[..., 1], (1, 1, 1), "channel=1")
    tifffile.imwrite("rgb.ome.tif", colours, photometric="rgb", metadata={"axes": "ZYXS", "PhysicalSizeX": 2.0})
    announce("rgb.ome.tif", colours[..., 1], (2, 1, 1, "um"), "channel=1")
    for name, many in (("red", colours), ("green", colours[::-1]), ("alpha", samples("u2", (5, 7, 9, 4))),
                       ("real", samples("f4", (5, 7, 9, 3)))):  # fmt: skip
        tifffile.imwrite(f"{name}.tif", many, photometric="rgb", extrasamples=["unassalpha"] * (many.shape[-1] - 3))
    apart = samples("u1", (3, 7, 9))
    tifffile.imwrite("planes.tif", apart, photometric="rgb", planarconfig="separate")
    announce("planes.tif", apart[2:], (1, 1, 1), "channel=2")
    os.mkdir("slices")
    volume = samples("u2", (12, 7, 9))
    for z, slice_ in enumerate(volume):
        tifffile.imwrite(f"slices/s{z + 1}.tif", slice_)
    open("slices/notes.txt", "w").write("no slice\n")
    announce("slices", volume, (2, 3, 4), "spacing=2,3,4")


# ---- DICOM ---------------------------------------------------------------------------------------

NORMAL = (0.0, 0.6, 0.8)  # normal of the slices below
ROWS = (1.0, 0.0, 0.0, 0.0, 0.8, -0.6)


def dicom_file(path, pixels, z=0.0, series=1, instance=1, syntax=None, **tags):
    """A CT slice at z mm along NORMAL; pixels have axes y, x or frame, y, x."""
    pydicom, uids = importlib.import_module("pydicom"), importlib.import_module("pydicom.uid")
    file = pydicom.dataset.FileDataset(path, {}, preamble=b"\0" * 128)
    file.file_meta = pydicom.dataset.FileMetaDataset()
    file.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
    file.file_meta.MediaStorageSOPInstanceUID = f"1.2.3.{series}.{instance}"
    syntax = syntax or uids.ExplicitVRLittleEndian
    file.file_meta.TransferSyntaxUID = syntax
    file.is_little_endian = syntax != uids.ExplicitVRBigEndian
    file.is_implicit_VR = syntax == uids.ImplicitVRLittleEndian
    file.SOPClassUID = file.file_meta.MediaStorageSOPClassUID
    file.SOPInstanceUID = file.file_meta.MediaStorageSOPInstanceUID
    file.StudyInstanceUID, file.SeriesInstanceUID = "1.2.3", f"1.2.3.{series}"
    file.SeriesNumber, file.InstanceNumber, file.SeriesDescription = series, instance, f"run{series}"
    file.ReferencedImageSequence = pydicom.sequence.Sequence([pydicom.dataset.Dataset()])
    file.ReferencedImageSequence[0].ReferencedSOPInstanceUID = "1.2.3.4"
    file.Rows, file.Columns = pixels.shape[-2:]
    file.SamplesPerPixel, file.PhotometricInterpretation = 1, "MONOCHROME2"
    bits = 8 * pixels.dtype.itemsize
    file.BitsAllocated, file.BitsStored, file.HighBit = bits, bits, bits - 1
    file.PixelRepresentation = int(pixels.dtype.kind == "i")
    file.PixelSpacing, file.SliceThickness = [0.5, 0.25], 9
    file.ImageOrientationPatient = list(ROWS)
    file.ImagePositionPatient = [float(round(z * n + o, 6)) for n, o in zip(NORMAL, (-10, 20, 5))]
    for tag, value in tags.items():
        setattr(file, tag, value)
    little = "<" if file.is_little_endian else ">"
    file.PixelData = pixels.astype(pixels.dtype.newbyteorder(little)).tobytes()
    file["PixelData"].VR = "OB" if bits == 8 else "OW"
    file.save_as(path, write_like_original=False)
    return file


def dicom_folder(name, volume, order=None, **more):
    """Slices 1.5 mm apart; their names do not give their order."""
    os.makedirs(name, exist_ok=True)
    for z, pixels in enumerate(volume):
        dicom_file(f"{name}/{(z * 7) % 11}_{z}.dcm", pixels, 1.5 * z, instance=100 - z, **more)


def make_dicom():
    import shutil
    import subprocess

    pydicom, uids = need("pydicom", "pydicom.uid")
    spacing = (0.25, 0.5, 1.5, "mm")
    volume = samples("i2", (6, 16, 20))
    dicom_folder("series", volume, RescaleSlope=2, RescaleIntercept=-1000)
    open("series/README", "w").write("no slice\n")
    announce("series", volume, spacing)
    announce("series/3_2.dcm", volume, spacing)
    for name, syntax in {"implicit": uids.ImplicitVRLittleEndian, "big": uids.ExplicitVRBigEndian}.items():
        dicom_folder(name, volume, syntax=syntax)
        announce(name, volume, spacing)
    small = samples("u1", (4, 16, 20), 2)
    dicom_folder("two", small, series=1)
    for z in range(4):
        dicom_file(f"two/b{z}.dcm", small[3 - z], -2.0 * z, series=2, instance=z)
    announce("two", small, spacing, "series=1")
    announce("two", small, (0.25, 0.5, 2), "series=run2")
    announce("two/b1.dcm", small, (0.25, 0.5, 2))
    # 12 bits are stored; the higher bits are not part of the samples.
    twelve = (samples("u2", (3, 16, 20), 3) >> 4).astype("u2")
    dicom_folder("twelve", twelve | 0x5000, BitsStored=12, HighBit=11)
    announce("twelve", twelve, spacing)
    signed = twelve.astype("i2") - 2048
    dicom_folder("signed", signed & 0xFFF, BitsStored=12, HighBit=11, PixelRepresentation=1)
    announce("signed", signed, spacing)
    os.mkdir("pet")
    for z in range(3):
        dicom_file(f"pet/{z}.dcm", twelve[z], 1.5 * z, RescaleSlope=z + 0.5, RescaleIntercept=z)
    announce("pet", np.stack([twelve[z] * (z + 0.5) + z for z in range(3)]).astype("f4"), spacing)
    os.mkdir("times")
    for t in range(2):
        for z in range(3):
            dicom_file(f"times/{t}{z}.dcm", volume[t * 3 + z], 1.5 * z, instance=t * 3 + z, AcquisitionNumber=t)
    announce("times", volume[3:6], spacing, "index=1")
    # An enhanced file: each frame has its own position.
    def item(**tags):
        data = pydicom.dataset.Dataset()
        for tag, value in tags.items():
            setattr(data, tag, value)
        return data

    frames = [item(PlanePositionSequence=[item(ImagePositionPatient=[float(1.5 * z * n) for n in NORMAL])]) for z in (2, 0, 1, 3, 5, 4)]
    file = dicom_file("frames.dcm", volume[[2, 0, 1, 3, 5, 4]])
    for tag in ("ImagePositionPatient", "ImageOrientationPatient", "PixelSpacing"):
        delattr(file, tag)
    file.NumberOfFrames = 6
    file.PerFrameFunctionalGroupsSequence = frames
    file.SharedFunctionalGroupsSequence = [item(
        PlaneOrientationSequence=[item(ImageOrientationPatient=list(ROWS))],
        PixelMeasuresSequence=[item(PixelSpacing=[0.5, 0.25], SliceThickness=1.5)])]
    file.save_as("frames.dcm", write_like_original=False)
    announce("frames.dcm", volume, spacing)
    for z in (0, 1, 3):
        os.makedirs("gap", exist_ok=True)
        dicom_file(f"gap/{z}.dcm", small[z], 1.5 * z)
    # Compressed by GDCM's own tool.
    if shutil.which("gdcmconv"):
        for option in ("--rle", "--jpeg", "--jpegls", "--j2k"):
            name = option[2:]
            os.mkdir(name)
            for z in range(3):
                subprocess.run(["gdcmconv", option, f"twelve/{(z * 7) % 11}_{z}.dcm", f"{name}/{z}.dcm"], check=True)
            announce(name, twelve, spacing)
    else:
        print("skipped: gdcmconv", file=sys.stderr)


def make_folders():
    """The inputs of the documents: `slices`, a folder of TIFF files, and `dicom`; a ball with grain."""
    (tifffile, _) = need("tifffile", "pydicom")
    z, y, x = np.mgrid[-1:1:24j, -1:1:40j, -1:1:48j]
    volume = (1000 * np.exp(-3 * (x * x + y * y + z * z)) + 20 * np.sin(9 * x) + 40).astype("u2")
    os.mkdir("slices")
    for number, pixels in enumerate(volume):
        tifffile.imwrite(f"slices/slice-{number + 1}.tif", pixels, photometric="minisblack")
    dicom_folder("dicom", volume.astype("i2"), RescaleSlope=1, RescaleIntercept=-1000)


# ---- NumPy, MRC ----------------------------------------------------------------------------------


def arrays():
    """Arrays of more than three axes: name, array, the volume in it, and the options that select it."""
    five, turned = samples("u2", (2, 3, 4, 5, 6)), samples("f4", (3, 4, 5, 6))
    colours, coloured = samples("u1", (4, 5, 6, 3)), samples("i2", (2, 4, 5, 6, 4))
    return (
        ("five", five, five[1, 2], "index=1", "channel=2"),
        ("colours", colours, colours[..., 1], "channel=1"),
        ("coloured", coloured, coloured[1, ..., 3], "index=1", "channel=3"),
        ("grey", colours[..., :1], colours[..., 0]),
        ("single", turned[None], turned[2], "index=2"),
        ("six", coloured[None], coloured[0, ..., 2], "index=0", "channel=2"),
    )


def make_npy():
    for name, array, volume, *options in arrays():
        np.save(f"{name}.npy", array)
        announce(f"{name}.npy", volume, (1, 1, 1), *options)
        np.save(f"{name}_f.npy", np.asfortranarray(array).astype(array.dtype.newbyteorder(">")))
        announce(f"{name}_f.npy", volume, (1, 1, 1), *options)
    half = samples("f4", (2, 4, 5, 6, 4)).astype("f2")
    np.save("half_coloured.npy", half)
    announce("half_coloured.npy", half[1, ..., 3].astype("f4"), (1, 1, 1), "index=1", "channel=3")
    for kind in ("u1", "i1", "<u2", ">i2", "<u4", ">i4", ">f4", "<f8"):
        volume = samples(kind)
        name = kind.replace("<", "l").replace(">", "b") + ".npy"
        np.save(name, volume.astype(kind))
        announce(name, volume)
    volume = samples("f4", (3, 4, 5, 6))
    np.save("fortran.npy", np.asfortranarray(volume[0]))
    announce("fortran.npy", volume[0], (1, 2, 3), "spacing=1,2,3")
    np.save("four.npy", volume)
    announce("four.npy", volume[1], (1, 1, 1), "index=1")
    np.save("fortran4.npy", np.asfortranarray(volume).astype(">f4"))
    announce("fortran4.npy", volume[2], (1, 1, 1), "index=2")
    np.save("half.npy", volume[0].astype("f2"))
    announce("half.npy", volume[0].astype("f2").astype("f4"))
    np.save("plane.npy", volume[0, 0])
    announce("plane.npy", volume[0, :1])
    for version in ((2, 0), (3, 0)):
        with open(f"v{version[0]}.npy", "wb") as file:
            np.lib.format.write_array(file, volume[0], version=version)
        announce(f"v{version[0]}.npy", volume[0])
    np.save("dates.npy", np.zeros((2, 2, 2), "M8[s]"))
    np.save("bool.npy", volume[0] > 0)
    announce("bool.npy", (volume[0] > 0).astype("u1"))


def make_pictures():
    """Folders of PNG and JPEG files as slices; numbers in names have any length."""
    (image,) = need("PIL.Image")
    volume, wide = samples("u1", (11, 7, 9)), samples("u2", (11, 7, 9))
    colours = samples("u1", (11, 7, 9, 3))
    for folder in ("grey", "wide", "colours", "palette", "bits", "alpha", "jpeg", "jpeg_colours"):
        os.mkdir(folder)
    with open("grey/about.txt", "w") as file:
        file.write("not a slice")
    for z in range(11):
        image.fromarray(volume[z]).save(f"grey/slice{z}.png")
        image.fromarray(wide[z]).save(f"wide/{z:03}.png")
        image.fromarray(colours[z]).save(f"colours/{z:03}.png")
        indexed = image.fromarray(volume[z] % 4, "P")
        indexed.putpalette([0, 0, 0, 40, 40, 40, 90, 90, 90, 255, 255, 255])
        indexed.save(f"palette/{z}.png")
        image.fromarray(volume[z] > 99).save(f"bits/{z}.png")
        image.fromarray(np.stack([volume[z], 255 - volume[z]], axis=2), "LA").save(f"alpha/{z}.png")
        smooth = np.add.outer(np.arange(7), np.arange(9)).astype("u1") * (z + 3)
        image.fromarray(smooth).save(f"jpeg/{z}.JPG", quality=95)
        image.fromarray(np.stack([smooth, smooth, 200 - smooth], axis=2)).save(f"jpeg_colours/{z}.jpg", quality=95)
    announce("grey", volume)
    announce("wide", wide, (0.5, 0.5, 2), "spacing=0.5,0.5,2")
    for c in range(3):
        announce("colours", colours[..., c], (1, 1, 1), f"channel={c}")
    announce("palette", np.array([0, 40, 90, 255], "u1")[volume % 4])
    announce("bits", 255 * (volume > 99).astype("u1"))
    announce("alpha", volume)
    announce("jpeg", np.stack([np.asarray(image.open(f"jpeg/{z}.JPG")) for z in range(11)]))
    for c in range(3):
        slices = [np.asarray(image.open(f"jpeg_colours/{z}.jpg"))[..., c] for z in range(11)]
        announce("jpeg_colours", np.stack(slices), (1, 1, 1), f"channel={c}")


def make_mgh():
    (nibabel,) = need("nibabel")
    affine = np.diag((1.5, 2, 2.5, 1))
    for kind in ("u1", "i2", "i4", "f4"):
        volume = samples(kind)
        image = nibabel.MGHImage(volume.T, affine)
        for ending in ("mgh", "mgz"):
            nibabel.save(image, f"{kind}.{ending}")
            announce(f"{kind}.{ending}", volume, (1.5, 2, 2.5, "mm"))
    four = samples("i2", (3, *SHAPE))
    nibabel.save(nibabel.MGHImage(four.T, affine), "four.mgz")
    for i in range(3):
        announce("four.mgz", four[i], (1.5, 2, 2.5, "mm"), f"index={i}")
    # Oblique: columns run to the left and up, the file states its centre.
    cosine, sine = 0.8, 0.6
    turned = np.array([[-2 * cosine, 0, 3 * sine, 10], [0, 2.5, 0, -20], [2 * sine, 0, 3 * cosine, 30], [0, 0, 0, 1]])
    nibabel.save(nibabel.MGHImage(samples("u1").T, turned), "turned.mgz")


def note_affine(name, affine):
    """Notes the steps of x, y and z in the world, and the origin, for the test of the command."""
    with open("affines.txt", "a") as file:
        print(name, *affine[:3, :3].T.ravel().round(9), *affine[:3, 3].round(9), file=file)


def make_analyze():
    (nibabel,) = need("nibabel")
    affine = np.diag((-1.5, 2, 2.5, 1))
    for kind in ("u1", "i2", "i4", "f4", "f8"):
        volume = samples(kind)
        nibabel.save(nibabel.AnalyzeImage(volume.T, affine), f"{kind}.img")
        for ending in ("hdr", "img"):
            announce(f"{kind}.{ending}", volume, (1.5, 2, 2.5))
    volume = samples("i2")
    with open("i2.hdr", "rb") as file:
        header = file.read()
    words = np.frombuffer(header, "u1").copy()
    for begin, end, width in ((0, 4, 4), (32, 36, 4), (36, 38, 2), (40, 76, 2), (76, 148, 4), (253, 263, 2)):
        words[begin:end] = words[begin:end].reshape(-1, width)[:, ::-1].ravel()
    words.tofile("big.hdr")
    with open("big.img.gz", "wb") as file:
        file.write(gzip.compress(volume.astype(">i2").tobytes()))
    for name in ("big.hdr", "big.img.gz"):
        announce(name, volume, (1.5, 2, 2.5))
    four = samples("i2", (3, *SHAPE))
    nibabel.save(nibabel.AnalyzeImage(four.T, affine), "four.img")
    announce("four.img", four[2], (1.5, 2, 2.5), "index=2")
    spm = nibabel.Spm2AnalyzeImage(volume.T, affine)
    nibabel.save(spm, "spm.img")
    os.remove("spm.mat")  # directions for MATLAB
    with open("spm.hdr", "r+b") as file:
        file.seek(112)
        file.write(np.array([0.5], "<f4").tobytes())
        file.seek(253)
        file.write(np.array([2, 3, 4], "<i2").tobytes())
    announce("spm.img", volume, (1.5, 2, 2.5))
    # SPM's matrices of MATLAB 4, as nibabel writes and reads them.
    turned = np.array([[-1.2, 1.2, 0, 4], [0.9, 1.6, 0, -5], [0, 0, 2.5, 6], [0, 0, 0, 1]])
    nibabel.save(nibabel.Spm99AnalyzeImage(volume.T, turned), "turned.img")
    shutil.copy("turned.hdr", "only_m.hdr")
    shutil.copy("turned.img", "only_m.img")
    matrix = nibabel.Spm99AnalyzeImage.from_filename("turned.img").affine @ np.array(
        [[1, 0, 0, -1], [0, 1, 0, -1], [0, 0, 1, -1], [0, 0, 0, 1]])
    with open("only_m.mat", "wb") as file:  # high byte first, behind another matrix
        file.write(struct.pack(">5i2s2h", 1030, 1, 2, 0, 2, b"a\0", 7, 8))
        file.write(struct.pack(">5i2s", 1000, 4, 4, 0, 2, b"M\0") + (np.diag([-1, 1, 1, 1]) @ matrix).T.astype(">f8").tobytes())
    for name in ("turned.img", "only_m.hdr"):
        announce(name, volume, (1.5, 2, 2.5))
    nibabel.save(nibabel.Nifti1Pair(volume.T, affine), "pair.img")
    announce("pair.img", volume, (1.5, 2, 2.5))
    nibabel.save(nibabel.Nifti2Pair(volume.T, affine), "pair2.img")
    nibabel.save(nibabel.Nifti1Pair(volume.T, affine), "packed.img.gz")
    nibabel.save(nibabel.Nifti2Pair(volume.T, affine), "packed2.hdr.gz")
    for name in ("pair2.hdr", "pair2.img", "packed.hdr.gz", "packed.img.gz", "packed2.img.gz"):
        announce(name, volume, (1.5, 2, 2.5))
    # What nibabel makes of the geometry.
    for name in ("i2.img", "spm.img", "turned.img", "only_m.img"):
        note_affine(name, nibabel.Spm99AnalyzeImage.from_filename(name).affine)


def make_mrc():
    (mrcfile,) = need("mrcfile")
    for kind in ("i1", "i2", "u2", "f4", "f2"):
        volume = samples(kind)
        with mrcfile.new(f"{kind}.mrc", volume) as file:
            file.voxel_size = (1.5, 2, 2.5)
        announce(f"{kind}.mrc", volume.astype("f4") if kind == "f2" else volume, (1.5, 2, 2.5, "A"))
    volume = samples("i2")
    with mrcfile.new("turned.map", volume) as file:
        file.set_extended_header(np.zeros(20, "V16"))
        file.header.mapc, file.header.mapr, file.header.maps = 3, 1, 2  # columns are z, rows x, sections y
        file.header.mx, file.header.my, file.header.mz = 7, 5, 9
        file.header.cella = (7, 10, 27)
        file.header.origin = (-1, -2, -3)
    announce("turned.map", volume.transpose(2, 0, 1), (1, 2, 3, "A"))


# ---- VTK -----------------------------------------------------------------------------------------


def make_vtk():
    # Importing only these modules; the whole of vtk takes seconds to load.
    legacy, xml, model, support = need("vtkmodules.vtkIOLegacy", "vtkmodules.vtkIOXML",
                                       "vtkmodules.vtkCommonDataModel", "vtkmodules.util.numpy_support")

    def image(volume, name="density"):
        data = model.vtkImageData()
        data.SetDimensions(*volume.shape[2::-1])
        data.SetSpacing(0.5, 1.5, 2)
        data.SetOrigin(1, 2, 3)
        flat = volume.reshape((-1,) + volume.shape[3:])
        array = support.numpy_to_vtk(np.ascontiguousarray(flat), deep=True)
        array.SetName(name)
        data.GetPointData().SetScalars(array)
        return data

    spacing = (0.5, 1.5, 2)
    for kind in ("u1", "i1", "i2", "u4", "f4", "f8"):
        volume = samples(kind)
        for ascii in (False, True):
            if ascii and kind == "i1":
                continue
            writer = legacy.vtkStructuredPointsWriter()
            name = f"{kind}{'a' if ascii else ''}.vtk"
            writer.SetFileName(name)
            writer.SetInputData(image(volume))
            writer.SetFileType(1 if ascii else 2)
            writer.Write()
            if not (ascii and kind[0] in "f" or name == "u1a.vtk"):  # six digits only, or colours from 0 to 1
                announce(name, volume, spacing)
    number = 0
    many = samples("i2", (5, 7, 9, 3))
    for mode in ("Ascii", "Binary", "Appended"):
        for encoded in (False, True):
            for zlib in (False, True):
                for wide in (False, True):
                    if mode != "Appended" and encoded or mode == "Ascii" and (zlib or wide):
                        continue
                    number += 1
                    volume = samples("u2", (5, 16, 20), number) % 1000
                    writer = xml.vtkXMLImageDataWriter()
                    name = f"{number}{mode}.vti"
                    writer.SetFileName(name)
                    data = image(volume)
                    more = support.numpy_to_vtk(np.zeros(volume.size), deep=True)
                    more.SetName("other")
                    data.GetPointData().AddArray(more)
                    writer.SetInputData(data)
                    getattr(writer, f"SetDataModeTo{mode}")()
                    writer.SetEncodeAppendedData(encoded)
                    writer.SetCompressorTypeToZLib() if zlib else writer.SetCompressorTypeToNone()
                    writer.SetHeaderTypeToUInt64() if wide else writer.SetHeaderTypeToUInt32()
                    writer.SetBlockSize(1024)
                    if number % 2:
                        writer.SetByteOrderToBigEndian()
                    writer.Write()
                    announce(name, volume, spacing)
    writer = xml.vtkXMLImageDataWriter()
    writer.SetFileName("vectors.vti")
    writer.SetInputData(image(many))
    writer.Write()
    announce("vectors.vti", many[..., 2], spacing, "channel=2")


def make_hdf5():
    (h5py,) = need("h5py")
    with h5py.File("many.h5", "w") as file:
        for kind in ("u1", "i1", "u2", ">i2", "<u4", "i4", "f2", "f4", ">f8"):
            volume = samples(np.dtype(kind).newbyteorder("=")).astype(kind)
            name = f"/group/{kind.strip('<>')}"
            file[name] = volume
            announce(f"many.h5:{name}", volume.astype("f4") if kind == "f2" else volume.astype(np.dtype(kind).newbyteorder("=")))
        file["/words"] = np.full((2, 2, 2), b"words")
        file["/flat"] = np.zeros((4, 3), "u1")
    volume = samples("u2", (20, 30, 40))
    with h5py.File("one.h5", "w", userblock_size=512) as file:
        data = file.create_dataset("data", data=volume, chunks=(8, 16, 16), compression="gzip", shuffle=True)
        data.attrs["element_size_um"] = [3.0, 2.0, 1.0]
        file["line"] = np.zeros(5)
    announce("one.h5", volume, (1, 2, 3, "um"))
    chopped = samples("u1", (2, 161, 190))  # one slice has more chunks than one request reads
    with h5py.File("chopped.h5", "w") as file:
        file.create_dataset("data", data=chopped, chunks=(2, 1, 6))
    announce("chopped.h5", chopped)
    many = samples("f4", (3, 4, 5, 6))
    with h5py.File("four.h5", "w") as file:
        file["a:b"] = many
    with h5py.File("arrays.h5", "w") as file:
        for name, array, volume, *options in arrays():
            file.create_dataset(name, data=array, chunks=tuple(min(4, n) for n in array.shape), compression="gzip")
            announce(f"arrays.h5:/{name}", volume, (1, 1, 1), *options)
        file["seven"] = np.zeros((2, 2, 2, 5, 5, 5, 3), "u1")
    announce("four.h5:/a:b", many[2], (1, 2, 3), "index=2", "spacing=1,2,3")


def minc(h5py, name, volume, dims, real=None, valid=None):
    """An image of MINC 2. dims: name, start, step and direction cosines of each axis; real: image-min and image-max."""
    with h5py.File(name, "w") as file:
        image = file.create_group("minc-2.0/image/0").create_dataset("image", data=volume, chunks=volume.shape)
        image.attrs["dimorder"] = np.bytes_(",".join(d[0] for d in dims))
        if valid:
            image.attrs["valid_range"] = np.array(valid, "f8")
        for dim, start, step, *cosines in dims:
            data = file.require_group("minc-2.0/dimensions").create_dataset(dim, data=0)
            data.attrs["spacing"] = np.bytes_("regular__")
            data.attrs["start"], data.attrs["step"] = float(start), float(step)
            if cosines:
                data.attrs["direction_cosines"] = np.array(cosines, "f8")
        for key, values in zip(("image-min", "image-max"), real or ()):
            data = image.parent.create_dataset(key, data=np.array(values, "f8"))
            data.attrs["dimorder"] = np.bytes_(",".join(d[0] for d in dims[:data.ndim]))


def announce_minc(nibabel, name, volume):
    """The stored samples, which cvol gives a scale, or the values; and the affine by nibabel."""
    image = nibabel.load(name)
    affine = image.affine
    announce(name, volume, (*np.linalg.norm(affine[:3, :3], axis=0)[::-1], "mm"))
    note_affine(name, affine[:, [2, 1, 0, 3]])
    return np.asarray(image.dataobj)


def make_minc():
    h5py, nibabel = need("h5py", "nibabel")
    c, s = np.cos(0.3), np.sin(0.3)
    z, y, x = ("zspace", 30, 3, 0, -s, c), ("yspace", -20, 2, 0, c, s), ("xspace", 10, -1.5)
    volume = samples("i2")
    slices = np.linspace(-5, 90, 5), np.linspace(100, 1000, 5)
    minc(h5py, "slices.mnc", np.clip(volume, -30000, 30000), (z, y, x), slices, (-30000, 30000))
    announce_minc(nibabel, "slices.mnc", np.asarray(nibabel.load("slices.mnc").dataobj).astype("f4"))
    bytes_ = samples("u1")
    minc(h5py, "scalar.mnc", bytes_, (y, x, z), (-10, 500), (0, 255))
    values = announce_minc(nibabel, "scalar.mnc", bytes_)
    assert np.allclose(values, bytes_ * 2.0 - 10), "the scale that the test of the command expects"
    minc(h5py, "same.mnc", bytes_, (x, z, y), (np.zeros(5), np.full(5, 255)))
    announce_minc(nibabel, "same.mnc", bytes_)
    words = samples("u4")
    minc(h5py, "words.mnc", words, (z, y, x), slices)
    announce_minc(nibabel, "words.mnc", np.asarray(nibabel.load("words.mnc").dataobj).astype("f8"))
    real = samples("f4")
    minc(h5py, "float.mnc", real, (z, y, x), slices)
    announce_minc(nibabel, "float.mnc", real)
    with h5py.File("bare.mnc", "w") as file: # neither scale nor dimensions
        image = file.create_dataset("minc-2.0/image/0/image", data=volume)
        image.attrs["dimorder"] = np.bytes_("zspace,yspace,xspace")
    announce("bare.mnc", volume, (1, 1, 1, "mm"))
    four = samples("u2", (3, *SHAPE))
    twice = np.arange(15.0).reshape(3, 5), np.arange(15.0).reshape(3, 5) * 3 + 7
    minc(h5py, "four.mnc", four, (("time", 0, 2.5), z, y, x), twice)
    announce("four.mnc", np.asarray(nibabel.load("four.mnc").dataobj)[2].astype("f4"), (1.5, 2, 3, "mm"), "index=2")
    if not shutil.which("rawtominc"):
        print("skipped: no rawtominc", file=sys.stderr)
        return
    subprocess.run(["rawtominc", "-2", "-clobber", "-short", "-signed", "-range", "-3000", "3000", "-scan_range",
                    "-real_range", "-1", "2", "-xstep", "-1.5", "-ystep", "2", "-zstep", "3", "-xstart", "4",
                    "-ystart", "5", "-zstart", "-6", "-xdircos", "0.8", "0.6", "0", "-ydircos", "-0.6", "0.8", "0",
                    "raw.mnc", "5", "7", "9"], input=(volume // (10 + np.arange(5)[:, None, None])).astype("<i2").tobytes(), check=True)
    announce_minc(nibabel, "raw.mnc", np.asarray(nibabel.load("raw.mnc").dataobj).astype("f4"))


def vdb_values(grid):
    """The values of the box of active voxels, by libopenvdb: z, y, x."""
    begin, end = grid.evalActiveVoxelBoundingBox()
    kind = {"float": "f4", "bool": "?"}[grid.valueTypeName]
    values = np.zeros([b - a + 1 for a, b in zip(begin, end)], kind)
    grid.copyToArray(values, begin)
    return values.T.astype("u1" if kind == "?" else kind)


def make_vdb():
    """Grids of floats and truth values, by libopenvdb; tests/volume/vdb/make_vdb.cpp makes those of other types."""
    try:
        vdb = importlib.import_module("openvdb") # since OpenVDB 11
    except ImportError:
        (vdb,) = need("pyopenvdb")

    random = np.random.default_rng(3)
    grids = {}

    def add(name, grid):
        grid.name = name
        grids[name] = grid
        return grid

    dense = add("dense", vdb.FloatGrid(0.5))
    dense.copyFromArray(samples("f4").T.copy(), ijk=(-3, 4, 100))
    # Voxels in many nodes of the tree; the box has tiles of both kinds, of each size that fits into a test.
    sparse = add("sparse", vdb.FloatGrid(-2))
    sparse.fill((-20, 0, 0), (10, 30, 20), 7.25)
    sparse.fill((-150, -130, 100), (-130, 140, 140), 3, active=False)
    for place in random.integers(-140, 140, size=(300, 3)):
        sparse.getAccessor().setValueOn(tuple(int(i) for i in place), float(random.normal()))
    sphere = add("sphere", vdb.createLevelSetSphere(radius=20, center=(3, -5, 8), voxelSize=0.75))
    half = add("half", dense.deepCopy())
    half.saveFloatAsHalf = True
    thick = add("thick_half", sphere.deepCopy())
    thick.saveFloatAsHalf = True
    truth = add("truth", vdb.BoolGrid(False))
    truth.copyFromArray(samples("u1", (20, 21, 22)).T > 200, ijk=(-9, -9, -9))
    wide = add("background_true", vdb.BoolGrid(True))
    wide.fill((0, 0, 0), (40, 40, 40), False)
    wide.fill((5, 6, 7), (12, 9, 8), True, active=False)
    shared = add("shared", dense.copy()) # the file has its tree once
    shared.transform = vdb.createLinearTransform([[2, 0, 0, 0], [0, 3, 0, 0], [0, 0, 4, 0], [5, 6, 7, 1]])
    vdb.write("all.vdb", grids=list(grids.values()))
    for name, grid in grids.items():
        values = vdb_values(grid)
        if "half" in name:
            values = values.astype("f2").astype("f4")
        size = grid.transform.voxelSize()
        announce(f"all.vdb:{name}", values, size)
        vdb.write(f"{name}.vdb", grids=[grid])
        announce(f"{name}.vdb", values, size)
    dense.name = half.name = "twice"
    vdb.write("twice.vdb", grids=[dense, half, vdb.Vec3SGrid()])
    announce("twice.vdb:twice[0]", vdb_values(dense))
    announce("twice.vdb:twice[1]", vdb_values(half).astype("f2").astype("f4"))
    vdb.write("vectors.vdb", grids=[vdb.Vec3SGrid()])
    vdb.write("empty.vdb", grids=[vdb.FloatGrid()])


def matlab_element(kind, data, end):
    """An element of MATLAB 5; few bytes share the tag."""
    if len(data) <= 4 and kind not in (14, 15):
        return struct.pack(end + "I", len(data) << 16 | kind) + data.ljust(4, b"\0")
    return struct.pack(end + "II", kind, len(data)) + data + (b"" if kind == 15 else bytes(-len(data) % 8))


def matlab_array(name, dims, kind, data, end="<", array_class=6, flags=0, imaginary=b""):
    parts = [(6, struct.pack(end + "II", array_class | flags << 8, 0)), (5, struct.pack(f"{end}{len(dims)}i", *dims)),
             (1, name.encode()), (kind, data)] + ([(kind, imaginary)] if imaginary else [])
    return matlab_element(14, b"".join(matlab_element(*part, end) for part in parts), end)


def matlab_file(name, *elements, end="<"):
    with open(name, "wb") as file:
        file.write(b"MATLAB 5.0 MAT-file, made by hand".ljust(124) + struct.pack(end + "H", 0x100) +
                   (b"IM" if end == "<" else b"MI") + b"".join(elements))


def make_matlab():
    """Arrays of MATLAB 5 by SciPy, and what it does not write by hand; A(x, y, z) is v[z, y, x]."""
    scipy_io, h5py = need("scipy.io", "h5py")
    kinds = ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8")
    for packed in False, True:
        name = "packed" if packed else "plain"
        arrays = {kind: samples(kind, seed=i) for i, kind in enumerate(kinds)}
        many = {key: volume.T for key, volume in arrays.items()}
        many |= {"text": "words", "number": 3.5, "cell": np.array([1, "a"], object), "field": {"a": np.zeros((2, 3, 4))},
                 "plane": samples("i2", (1, 7, 9))[0].T, "few": wide_volumes()[0][1].T, "large": wide_volumes()[3][1].T,
                 "turning": np.ones((3, 4, 5)) * 1j, "nothing": np.zeros((0, 3, 4)), "truth": samples("u1").T > 99}
        scipy_io.savemat(f"all_{name}.mat", many, do_compression=packed)
        for key, volume in arrays.items():
            announce(f"all_{name}.mat:{key}", volume)
        announce(f"all_{name}.mat:plane", samples("i2", (1, 7, 9)))
        announce(f"all_{name}.mat:few", wide_volumes()[0][2])
        announce(f"all_{name}.mat:large", wide_volumes()[3][2])
        announce(f"all_{name}.mat:truth", (samples("u1") > 99).astype("u1"))
        four = samples("i2", (3, 5, 7, 9))
        scipy_io.savemat(f"four_{name}.mat", {"a": four.T, "line": np.arange(5)}, do_compression=packed)
        announce(f"four_{name}.mat", four[1], (1, 1, 1), "index=1")
        announce(f"four_{name}.mat:a", four[2], (2, 3, 4), "index=2", "spacing=2,3,4")
        colours = samples("u1", (5, 7, 9, 3))
        scipy_io.savemat(f"colours_{name}.mat", {"rgb": colours.T}, do_compression=packed)
        announce(f"colours_{name}.mat", colours[..., 1], (1, 1, 1), "channel=1")
    # Doubles that MATLAB stores as bytes; high byte first; names and numbers within their tags.
    few = samples("u1")
    matlab_file("bytes.mat", matlab_array("A_long_name", few.shape[::-1], 2, few.tobytes()))
    announce("bytes.mat", few)
    wide = samples("i2")
    big = matlab_array("v", wide.shape[::-1], 3, wide.astype(">i2").tobytes(), ">", 10)
    matlab_file("big.mat", big, end=">")
    announce("big.mat", wide)
    matlab_file("big_packed.mat", matlab_element(15, zlib.compress(big), ">"), end=">")
    announce("big_packed.mat", wide)
    small = np.array([[[1, 2], [3, 4]]], "u1")
    matlab_file("small.mat", matlab_array("s", (2, 2, 1), 2, small.tobytes()))
    announce("small.mat:s", small)
    # MATLAB 7.3: HDF5 behind 512 bytes, with the axes in reverse.
    with h5py.File("v73.mat", "w", userblock_size=512) as file:
        file["A"] = wide
        file["A"].attrs["MATLAB_class"] = np.bytes_("int16")
    with open("v73.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
    announce("v73.mat", wide)
    announce("v73.mat:/A", wide)
    matlab_file("lies.mat", matlab_array("a", (2, 3, 5), 2, bytes(29)))
    matlab_file("strange.mat", matlab_array("a", (2, 3, 5), 8, bytes(30)))
    matlab_file("huge.mat", matlab_array("a", (2**31 - 1, 2**31 - 1, 2**31 - 1), 9, bytes(64)))


OME = "{http://www.openmicroscopy.org/Schemas/OME/2016-06}"
# Required attributes of elements and the elements within, in order, by the schema of June 2016.
OME_RULES = {
    "OME": ((), ("Image",)),
    "Image": (("ID",), ("Pixels",)),
    "Pixels": (("ID", "DimensionOrder", "Type", "SizeX", "SizeY", "SizeZ", "SizeC", "SizeT"), ("Channel", "TiffData")),
    "Channel": (("ID",), ()),
    "TiffData": ((), ()),
}
OME_VALUES = {
    "Type": r"u?int(8|16|32)|float|double", "DimensionOrder": "XY(ZCT|ZTC|CZT|CTZ|TCZ|TZC)", "BigEndian": "true|false",
    "Size[XYZCT]|SamplesPerPixel": "[1-9][0-9]*", "PhysicalSize[XYZ]|TimeIncrement": r"[0-9.]+(e[-+]?[0-9]+)?",
    "PhysicalSize[XYZ]Unit": "\u00b5m|nm|pm|mm|cm|m|in|\u00c5|reference frame", "TimeIncrementUnit": "s|ms|\u00b5s|ns|min|h|d",
    "IFD|PlaneCount": "[0-9]+", "Color": "-?[0-9]+", "ID": r"(Image:\d+)|(Pixels:\d+)|(Channel:\d+:\d+)",
    "Name|Creator|.*schemaLocation": "(?s).*",
}  # fmt: skip


def check_ome_rules(element, name):
    """The rules of the schema for the elements that cvol writes."""
    import re

    tag = element.tag.removeprefix(OME)
    needed, within = OME_RULES[tag]
    assert set(needed) <= set(element.keys()), f"{name}: {tag} has {element.keys()}"
    for key, value in element.items():
        rules = [rule for names, rule in OME_VALUES.items() if re.fullmatch(names, key)]
        assert len(rules) == 1 and re.fullmatch(rules[0], value), f"{name}: {tag} {key}={value}"
    places = [within.index(child.tag.removeprefix(OME)) for child in element]
    assert places == sorted(places), f"{name}: order of elements in {tag}"
    for child in element:
        check_ome_rules(child, name)
    if tag == "Pixels":
        size = {letter: int(element.get(f"Size{letter}")) for letter in "ZCT"}
        channels = element.findall(f"{OME}Channel")
        assert sum(int(channel.get("SamplesPerPixel")) for channel in channels) == size["C"], name
        planes = sum(int(data.get("PlaneCount")) for data in element.findall(f"{OME}TiffData"))
        assert planes == size["Z"] * size["T"] * len(channels), name


def check_ome(tifffile, name, axes, array, pixels, channels=None):
    """Reads an OME-TIFF with tifffile: samples, axes, and attributes of Pixels and Channel elements."""
    import xml.etree.ElementTree as tree

    with tifffile.TiffFile(name) as file:
        assert file.is_ome and len(file.series) == 1, name
        assert file.series[0].axes == axes, f"{name}: {file.series[0].axes}"
        assert np.array_equal(file.asarray(), array), name
        whole = tree.fromstring(file.ome_metadata)
        check_ome_rules(whole, name)
        element = whole.find(f"{OME}Image/{OME}Pixels")
        assert element.get("Type") == {"float32": "float", "float64": "double"}.get(str(array.dtype), str(array.dtype)), name
        for key, value in pixels.items():
            assert element.get(key) == value, f"{name}: {key} {element.get(key)}"
        if channels:
            assert [(c.get("Name"), c.get("Color")) for c in element.findall(f"{OME}Channel")] == channels, name


def check_written():
    """Reads the files that cvol wrote from in.nrrd with other libraries."""
    import warnings

    warnings.simplefilter("ignore")
    truth = np.fromfile("in.raw", "<i2").reshape(4, 5, 6)
    assert np.array_equal(np.load("out.npy"), truth), "npy"
    try:
        import tifffile

        with tifffile.TiffFile("out.tif") as file:
            assert np.array_equal(file.asarray(), truth), "tif"
            assert abs(file.imagej_metadata["spacing"] - 2.5) < 1e-9, "tif spacing"
            x, y = (file.pages[0].tags[tag].value for tag in (282, 283))
            assert abs(x[1] / x[0] - 0.5) < 1e-9 and abs(y[1] / y[0] - 0.7) < 1e-9, "tif resolution"
        check_ome(tifffile, "one.ome.tif", "ZYX", truth, {"PhysicalSizeX": "0.5", "PhysicalSizeXUnit": "reference frame"})
        if os.path.exists("series.ome.tif"):
            many = tifffile.imread("tiff/ome.ome.tif")
            micron = "\u00b5m"
            pixels = {"PhysicalSizeX": "0.1", "PhysicalSizeY": "0.2", "PhysicalSizeZ": "0.4", "PhysicalSizeXUnit": micron,
                      "PhysicalSizeYUnit": micron, "PhysicalSizeZUnit": micron, "TimeIncrement": "250",
                      "TimeIncrementUnit": "ms"}
            check_ome(tifffile, "series.ome.tif", "TCZYX", many.swapaxes(1, 2), pixels, [
                ("DAPI", "65535"), ("a & <b>", "16711935"), ("\u03b1-tubulin", "-1")])
            # Colours are pages of RGB, with the components one after the other.
            red, alpha, real = (np.moveaxis(tifffile.imread(f"tiff/{name}.tif"), -1, 1) for name in ("red", "alpha", "real"))
            one_time = {"SizeC": "3", "SizeT": "1", "PhysicalSizeXUnit": "reference frame"}
            check_ome(tifffile, "colours.ome.tif", "TZSYX", np.stack([red, red[::-1]]), {"SizeC": "3", "SizeT": "2"})
            check_ome(tifffile, "alpha.ome.tif", "ZSYX", alpha, {"SizeC": "4"})
            check_ome(tifffile, "real.ome.tif", "CZYX", real.swapaxes(0, 1), one_time)
            with tifffile.TiffFile("alpha.ome.tif") as file:
                page = file.pages[0]
                assert page.photometric.name == "RGB" and page.planarconfig.name == "SEPARATE", "alpha.ome.tif"
                assert [value.name for value in page.extrasamples] == ["UNASSALPHA"], "alpha.ome.tif"
            check_ome(tifffile, "channel.ome.tiff", "ZYX", many[1, :, 1], {"TimeIncrement": None})
    except ImportError as error:
        print(f"skipped: {error}")
    try:
        import h5py

        for kind in "uint8 int8 uint16 int16 uint32 int32 float32 float64".split():
            with h5py.File(f"{kind}.h5", "r") as file:
                data, wanted = file["data"], np.load(f"{kind}.npy")
                assert list(file) == ["data"] and not data.attrs, kind
                assert data.dtype == wanted.dtype == kind and data.chunks is None, f"{kind}.h5: {data.dtype}"
                assert np.array_equal(data[:], wanted), f"{kind}.h5"
        with h5py.File("named.h5", "r") as file:
            assert np.array_equal(file["scan/left/ct"][:], h5py.File("bytes.h5", "r")["data"][:]), "named.h5"
            assert [list(file), list(file["scan"]), list(file["scan/left"])] == [["scan"], ["left"], ["ct"]], "named.h5"
            assert np.array_equal(file["scan/left/ct"].attrs["element_size_um"], (2500, 700, 500)), "named.h5 spacing"
        with h5py.File("long.hdf5", "r") as file:
            assert np.array_equal(file["/".join([40 * "name"] * 3 + ["\u00b5"])][:], h5py.File("bytes.h5", "r")["data"][:]), "long"
        with h5py.File("bytes.h5", "r") as file:
            assert np.array_equal(file["data"].attrs["element_size_um"], (2500, 700, 500)), "h5 spacing"
    except ImportError as error:
        print(f"skipped: {error}")
    try:
        import mrcfile

        narrow = np.fromfile("bytes.raw", "u1").reshape(4, 5, 6)
        for name, expected in ("out.mrc", truth), ("bytes.mrc", narrow):
            with mrcfile.open(name) as file:
                assert np.array_equal(file.data, expected) and file.is_volume(), name
        assert mrcfile.validate("bytes.mrc", print_file=open("mrc.txt", "w")), open("mrc.txt").read()
    except ImportError as error:
        print(f"skipped: {error}")
    try:
        import nibabel

        images = [nibabel.load(name) for name in ("bytes.mgz", "bytes.nii")]
        assert np.array_equal(images[0].get_fdata(), images[1].get_fdata()), "mgz"
        microns = np.diag([1e-3, 1e-3, 1e-3, 1]) @ images[1].affine
        assert np.allclose(images[0].affine, microns, atol=1e-5), f"mgz place: {images[0].affine} {microns}"
        assert np.array_equal(nibabel.load("out.mgh").get_fdata().T, truth), "mgh"
    except ImportError as error:
        print(f"skipped: {error}")
    try:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXML import vtkXMLImageDataReader

        reader = vtkXMLImageDataReader()
        reader.SetFileName("out.vti")
        reader.Update()
        data = reader.GetOutput()
        assert np.array_equal(vtk_to_numpy(data.GetPointData().GetScalars()).reshape(4, 5, 6), truth), "vti"
        assert np.allclose(data.GetSpacing(), (0.5, 0.7, 2.5)) and np.allclose(data.GetOrigin(), (1, 2, 3)), "vti place"
        matrix = [data.GetDirectionMatrix().GetElement(i, j) for i in range(3) for j in range(3)]
        assert np.allclose(matrix, (0, 1, 0, -1, 0, 0, 0, 0, 1)), "vti directions"
    except ImportError as error:
        print(f"skipped: {error}")


if __name__ == "__main__":
    if sys.argv[1] == "check":
        check_written()
        sys.exit()
    globals()["make_" + sys.argv[1]]()
