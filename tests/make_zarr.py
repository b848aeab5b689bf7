#!/usr/bin/env python3
"""Writes Zarr folders: format 2 by python3-zarr, format 3 by hand, as that package has only format 2.

usage: make_zarr.py            in an empty folder; status 77 if zarr or numcodecs is missing
       make_zarr.py check FOLDER REFERENCE.npy [labels]    a folder that cvol wrote has these samples at its first
                               level, and their means, or every second one, at the others

Standard output is the input of tests/helpers/read_list.c, as that of make_formats.py.
"""
import gzip
import itertools
import json
import os
import struct
import subprocess
import sys
import zlib

from make_formats import announce, need, samples

import numpy as np

zarr, numcodecs = need("zarr", "numcodecs")
MISSING = 2**64 - 1


# ---- format 2 ----------------------------------------------------------------------------------


def make_2():
    packers = {"none": None, "zlib": numcodecs.Zlib(5), "gzip": numcodecs.GZip(5), "zstd": numcodecs.Zstd(3),
               "blosc_lz4": numcodecs.Blosc("lz4", 5, numcodecs.Blosc.SHUFFLE),
               "blosc_zstd": numcodecs.Blosc("zstd", 5, numcodecs.Blosc.BITSHUFFLE),
               "blosc_none": numcodecs.Blosc("blosclz", 0, numcodecs.Blosc.NOSHUFFLE)}  # fmt: skip
    volume = samples("u2")
    for name, packer in packers.items():
        zarr.array(volume, store=f"{name}.zarr", chunks=(2, 3, 4), compressor=packer)
        announce(f"{name}.zarr", volume)
    for kind in ("<i1", "<i2", ">i2", "<u4", ">u4", "<i4", "<f4", ">f4", "<f8", ">f8", "|u1"):
        volume = samples(kind)
        name = f"{'big' if kind[0] == '>' else 'little'}_{kind[1:]}.zarr"
        zarr.array(volume, store=name, chunks=(3, 7, 5), dimension_separator="/")
        announce(name, volume)
    for kind, narrow in (("<i8", "i4"), (">i8", "i4"), ("<u8", "u4")):
        volume = samples(narrow)
        name = f"wide_{ord(kind[0])}{kind[1:]}.zarr"
        a = zarr.open(name, "w", shape=(5, 7, 9), chunks=(2, 3, 4), dtype=kind, fill_value=7)
        volume[4] = a[4] = 7
        a[:4] = volume[:4]
        announce(name, volume)
    for kind in ("<f2", ">f2"):
        half = samples("f4").astype(kind)
        zarr.array(half, store=f"half_{ord(kind[0])}.zarr", chunks=(4, 4, 4))
        announce(f"half_{ord(kind[0])}.zarr", half.astype("f4"))
    bits = samples("u1") > 99
    zarr.array(bits, store="bool.zarr", chunks=(4, 4, 4))
    announce("bool.zarr", bits.astype("u1"))
    volume = samples(">f8")
    zarr.array(volume, store="fortran.zarr", chunks=(2, 3, 4), order="F", compressor=numcodecs.Zstd())
    announce("fortran.zarr", volume)
    zarr.array(volume, store="one_chunk.zarr", chunks=(64, 64, 64))
    announce("one_chunk.zarr", volume)
    zarr.array(volume[0], store="plane.zarr", chunks=(4, 4))
    announce("plane.zarr", volume[:1])
    zarr.array(volume[0, 0], store="line.zarr", chunks=4)
    announce("line.zarr", volume[:1, :1])
    for fill in (7, None):
        a = zarr.open(f"holes_{fill}.zarr", "w", shape=(5, 7, 9), chunks=(2, 3, 4), dtype="<i2", fill_value=fill)
        a[2:4, 3:6, :4] = 5
        announce(f"holes_{fill}.zarr", a[:] if fill else np.where(a[:] == 5, 5, 0).astype("i2"))
    a = zarr.open("nan.zarr", "w", shape=(5, 7, 9), chunks=(2, 3, 4), dtype="<f4", fill_value=np.nan)
    a[:2] = 1
    announce("nan.zarr", a[:])


def make_images():
    series = samples("u2", (2, 3, 5, 7, 9))
    group = zarr.open_group("image.ome.zarr", "w")
    group.create_dataset("0", data=series, chunks=(1, 1, 2, 4, 4), dimension_separator="/")
    group.create_dataset("1", data=series[..., ::2, ::2], chunks=(2, 2, 2, 4, 4), order="F")
    group.create_dataset("labels/cells/0", data=series[:, :1], chunks=(1, 1, 2, 4, 4))
    axes = [{"name": "t", "type": "time", "unit": "second"}, {"name": "c", "type": "channel"},
            *({"name": a, "type": "space", "unit": "micrometer"} for a in "zyx")]  # fmt: skip

    def dataset(path, scale, *translation):
        parts = [{"type": "scale", "scale": [1, 1, *scale]}]
        parts += [{"type": "translation", "translation": [0, 0, *t]} for t in translation]
        return {"path": path, "coordinateTransformations": parts}

    group.attrs["multiscales"] = [{
        "version": "0.4", "axes": axes,
        "datasets": [dataset("0", (2, 0.5, 0.25)), dataset("1", (2, 1, 0.5), (0, 0.25, 0.125))],
        "coordinateTransformations": [{"type": "scale", "scale": [1.5, 1, 1, 1, 1]},
                                      {"type": "translation", "translation": [0, 0, 10, 20, 30]}],
    }]  # fmt: skip
    group.attrs["omero"] = {"channels": [{"label": "DAPI", "color": "0000FF", "active": True},
                                         {"label": "GFP", "color": "00ff00"}]}  # fmt: skip
    labels = group["labels/cells"]
    labels.attrs["multiscales"] = [{"version": "0.4", "axes": axes, "datasets": [dataset("0", (2, 0.5, 0.25))]}]
    labels.attrs["image-label"] = {"version": "0.4", "colors": [{"label-value": 1, "rgba": [255, 0, 0, 255]}]}
    for t, c in itertools.product(range(2), range(3)):
        announce("image.ome.zarr", series[t, c], (0.25, 0.5, 2, "um"), f"index={t}", f"channel={c}")
        announce("image.ome.zarr/1", series[t, c, :, ::2, ::2], (0.5, 1, 2, "um"), f"index={t}", f"channel={c}")
    announce("image.ome.zarr/labels/cells", series[1, 0], (0.25, 0.5, 2, "um"), "index=1")
    zarr.array(series[0], store="four.zarr", chunks=(3, 5, 7, 2))
    announce("four.zarr", series[0, 2], (1, 1, 1), "channel=2")

    # An array deeper than its group, and axes of different units.
    volume = samples("f4")
    group = zarr.open_group("units.ome.zarr", "w")
    group.create_dataset("a/b", data=volume, chunks=(2, 3, 4))
    axes = [{"name": "z", "type": "space", "unit": "millimeter"}, *({"name": a, "unit": "micrometer"} for a in "yx")]
    part = {"type": "scale", "scale": [0.002, 0.5, 0.25]}
    group.attrs["multiscales"] = [{"axes": axes, "datasets": [{"path": "a/b", "coordinateTransformations": [part]}]}]
    announce("units.ome.zarr", volume, (0.25, 0.5, 2, "um"))
    announce("units.ome.zarr/a/b", volume, (0.25, 0.5, 2, "um"))


# ---- format 3 ----------------------------------------------------------------------------------


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return struct.pack("<I", crc ^ 0xFFFFFFFF)


def pack(data, codecs):
    for codec in codecs:
        name = codec["name"]
        data = (gzip.compress(data) if name == "gzip" else numcodecs.Zstd().encode(data) if name == "zstd"
                else numcodecs.Blosc("lz4").encode(data) if name == "blosc" else data + crc32c(data))  # fmt: skip
    return bytes(data)


def encode(chunk, codecs):
    """A chunk by codecs transpose, bytes and others."""
    if codecs[0]["name"] == "transpose":
        chunk, codecs = chunk.transpose(codecs[0]["configuration"]["order"]), codecs[1:]
    endian = codecs[0].get("configuration", {}).get("endian", "little")
    return pack(chunk.astype(chunk.dtype.newbyteorder(">" if endian == "big" else "<")).tobytes(), codecs[1:])


def blocks(volume, sides, fill=0):
    """The chunks of an array, with their places; those at the end are filled up."""
    counts = [-(-n // s) for n, s in zip(volume.shape, sides)]
    full = np.full([c * s for c, s in zip(counts, sides)], fill, volume.dtype)
    full[tuple(slice(n) for n in volume.shape)] = volume
    for place in itertools.product(*map(range, counts)):
        yield place, full[tuple(slice(i * s, (i + 1) * s) for i, s in zip(place, sides))]


def shard(chunk, options):
    body, index = b"", b""
    start = options.get("index_location") == "start"
    parts = list(blocks(chunk, options["chunk_shape"]))
    base = 16 * len(parts) + 4 if start else 0
    for _, part in parts:
        data = encode(part, options["codecs"]) if part.any() else b""
        index += struct.pack("<QQ", base + len(body), len(data)) if data else struct.pack("<QQ", MISSING, MISSING)
        body += data
    index += crc32c(index)
    return index + body if start else body + index


def write_3(folder, volume, sides, codecs, keys=None, names=None, fill=0):
    keys = keys or {"name": "default"}
    os.makedirs(folder)
    metadata = {"zarr_format": 3, "node_type": "array", "shape": volume.shape,
                "data_type": volume.dtype.newbyteorder("=").name,
                "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": sides}}, "chunk_key_encoding": keys,
                "fill_value": fill, "codecs": codecs, "attributes": {}}  # fmt: skip
    if names:
        metadata["dimension_names"] = names
    with open(f"{folder}/zarr.json", "w") as file:
        json.dump(metadata, file)
    between = keys.get("configuration", {}).get("separator", "/" if keys["name"] == "default" else ".")
    for place, chunk in blocks(volume, sides, fill):
        if (chunk == fill).all():
            continue
        name = between.join((["c"] if keys["name"] == "default" else []) + [str(i) for i in place])
        os.makedirs(os.path.dirname(f"{folder}/{name}"), exist_ok=True)
        with open(f"{folder}/{name}", "wb") as file:
            sharded = codecs[0]["name"] == "sharding_indexed"
            file.write(shard(chunk, codecs[0]["configuration"]) if sharded else encode(chunk, codecs))


def make_3():
    little, big = ({"name": "bytes", "configuration": {"endian": e}} for e in ("little", "big"))
    turn = {"name": "transpose", "configuration": {"order": [2, 0, 1]}}
    gz, zs, bl, crc = ({"name": n, "configuration": {}} for n in ("gzip", "zstd", "blosc", "crc32c"))
    for name, kind, codecs in (("plain", "u1", [{"name": "bytes"}]), ("little", "f4", [little, gz]),
                               ("big", "i2", [big, zs, crc]),
                               ("turned", "u4", [turn, little, bl]), ("double", "f8", [big, crc])):  # fmt: skip
        volume = samples(kind)
        write_3(f"v3_{name}.zarr", volume, (2, 3, 4), codecs)
        announce(f"v3_{name}.zarr", volume)
    volume = np.full((5, 7, 9), 2**63 - 1, "i8")
    write_3("v3_beyond.zarr", volume, (2, 3, 4), [big, zs], fill=2**63 - 1)
    volume = samples("u4")
    write_3("v3_filled.zarr", volume.astype("u8"), (2, 3, 4), [big, zs], fill=2**63)
    zarr.array(volume.astype("u8"), store="filled.zarr", chunks=(2, 3, 4), fill_value=2**64 - 1)
    for name in ("v3_filled.zarr", "filled.zarr"):
        announce(name, volume)
    write_3("v3_last.zarr", np.full((5, 7, 9), 2**64 - 1, "u8"), (2, 3, 4), [big, zs], fill=2**64 - 1)
    volume = samples("i4").astype("i8") * 2**21
    write_3("v3_wide.zarr", volume, (2, 3, 4), [big, zs])
    announce("v3_wide.zarr", volume.astype("f8"))
    volume = samples("i2")
    volume[:4, :4, :4] = 0
    for at in ("start", "end"):
        options = {"chunk_shape": (2, 2, 2), "codecs": [little, zs], "index_codecs": [little, crc],
                   "index_location": at}  # fmt: skip
        write_3(f"v3_shards_{at}.zarr", volume, (4, 4, 8), [{"name": "sharding_indexed", "configuration": options}])
        announce(f"v3_shards_{at}.zarr", volume)
    write_3("v3_keys.zarr", volume, (2, 3, 4), [little], {"name": "v2"})
    announce("v3_keys.zarr", volume)
    write_3("v3_dots.zarr", volume, (2, 3, 4), [little], {"name": "default", "configuration": {"separator": "."}})
    announce("v3_dots.zarr", volume)
    write_3("v3_names.zarr", volume.transpose(), (2, 3, 4), [little], names=["x", "y", "z"])
    announce("v3_names.zarr", volume)
    series = samples("u2", (3, 5, 7, 9))
    write_3("v3.ome.zarr/s0", series, (1, 2, 3, 4), [little, zs])
    axes = [{"name": "c", "type": "channel"}, *({"name": a, "type": "space", "unit": "nanometer"} for a in "zyx")]
    parts = [{"type": "scale", "scale": [1, 40, 4, 5]}, {"type": "translation", "translation": [0, 7, 8, 9]}]
    datasets = [{"path": "s0", "coordinateTransformations": parts}]
    ome = {"version": "0.5", "multiscales": [{"axes": axes, "datasets": datasets}],
           "omero": {"channels": [{"label": "α", "color": "FF0000"}] * 3}}  # fmt: skip
    with open("v3.ome.zarr/zarr.json", "w") as file:
        json.dump({"zarr_format": 3, "node_type": "group", "attributes": {"ome": ome}}, file)
    for name in ("v3.ome.zarr", "v3.ome.zarr/s0"):
        announce(name, series[1], (5, 4, 40, "nm"), "channel=1")


# ---- codec cvol --------------------------------------------------------------------------------


def cvol_file(volume):
    """The bytes of a .cvol file, by the command."""
    np.save("part.npy", volume)
    subprocess.run([os.environ["CVOL"], "compress", "part.npy", "part.cvol", "--lossless"], check=True,
                   stdout=subprocess.DEVNULL)  # fmt: skip
    with open("part.cvol", "rb") as file:
        return file.read()


def cvol_chunk(chunk, kind, order):
    """A chunk behind a header (doc/zarr.md)."""
    volumes = chunk.reshape((-1, *((1,) * (3 - chunk.ndim) + chunk.shape)[-3:]))
    files = [cvol_file(volume) for volume in volumes]
    head = struct.pack("<8sBBc5s", b"\x8bCVK\r\n\x1a\n", 1, chunk.ndim, order, kind)
    head += struct.pack(f"<{chunk.ndim + len(files)}Q", *chunk.shape, *map(len, files))
    return b"".join([head, struct.pack("<I", zlib.crc32(head)), *files])


def make_cvol():
    volume = samples("i2")
    for order in "CF":
        folder = f"cvol_{order}.zarr"
        zarr.open(folder, "w", shape=volume.shape, chunks=(3, 4, 9), dtype="<i2", order=order, compressor=None)
        for place, chunk in blocks(volume, (3, 4, 9)):
            with open(f"{folder}/{'.'.join(map(str, place))}", "wb") as file:
                file.write(cvol_file(chunk) if order == "C" else cvol_chunk(chunk, b"<i2", b"F"))
        set_codec(folder)
        announce(folder, volume)
    series = samples("f4", (2, 3, 4, 5, 6)).astype(">f2")
    zarr.open("cvol_5.zarr", "w", shape=series.shape, chunks=(2, 2, 4, 5, 3), dtype=">f2", compressor=None)
    for place, chunk in blocks(series, (2, 2, 4, 5, 3)):
        with open(f"cvol_5.zarr/{'.'.join(map(str, place))}", "wb") as file:
            file.write(cvol_chunk(chunk.astype("<f4"), b">f2", b"C"))
    set_codec("cvol_5.zarr")
    for t, c in itertools.product(range(2), range(3)):
        announce("cvol_5.zarr", series[t, c].astype("f4"), (1, 1, 1), f"index={t}", f"channel={c}")
    write_3("cvol_3.zarr", volume, (5, 7, 9), [{"name": "bytes", "configuration": {"endian": "little"}}])
    with open("cvol_3.zarr/zarr.json") as file:
        metadata = json.load(file)
    metadata["codecs"] = [{"name": "transpose", "configuration": {"order": [2, 1, 0]}},
                          {"name": "cvol", "configuration": {}}]  # fmt: skip
    with open("cvol_3.zarr/zarr.json", "w") as file:
        json.dump(metadata, file)
    with open("cvol_3.zarr/c/0/0/0", "wb") as file:
        file.write(cvol_file(np.ascontiguousarray(volume.transpose())))
    announce("cvol_3.zarr", volume)


def set_codec(folder):
    with open(f"{folder}/.zarray") as file:
        metadata = json.load(file)
    with open(f"{folder}/.zarray", "w") as file:
        json.dump({**metadata, "compressor": {"id": "cvol"}}, file)


# ---- folders that cvol wrote -------------------------------------------------------------------


def means(volume, factor):
    """Means of boxes, rounded for integers; those at the end have fewer samples."""
    out = volume.astype("f8")
    for axis, n in enumerate(volume.shape):
        begins = np.arange(0, n, factor)
        counts = np.diff(np.append(begins, n)).reshape([-1 if a == axis else 1 for a in range(3)])
        out = np.add.reduceat(out, begins, axis) / counts
    return (np.rint(out) if volume.dtype.kind in "iu" else out).astype(volume.dtype)


class Array3:
    """An array of format 3 with codecs bytes and zstd, read as its specification says."""

    def __init__(self, folder):
        with open(f"{folder}/zarr.json") as file:
            m = json.load(file)
        assert (m["zarr_format"], m["node_type"], m["fill_value"]) == (3, "array", 0), "array"
        assert m["chunk_grid"]["name"] == "regular" and [c["name"] for c in m["codecs"]] == ["bytes", "zstd"], "codecs"
        assert m["codecs"][0]["configuration"] == {"endian": "little"}, "byte order"
        assert m["chunk_key_encoding"] == {"name": "default", "configuration": {"separator": "/"}}, "keys"
        assert len(m["dimension_names"]) == len(m["shape"]), "names"
        self.names, self.dtype = m["dimension_names"], np.dtype(m["data_type"])
        self.chunks = m["chunk_grid"]["configuration"]["chunk_shape"]
        counts = [-(-n // s) for n, s in zip(m["shape"], self.chunks)]
        self.samples = np.zeros([c * s for c, s in zip(counts, self.chunks)], self.dtype)
        for place in itertools.product(*map(range, counts)):
            name = "/".join([folder, "c", *map(str, place)])
            if os.path.exists(name):
                with open(name, "rb") as file:
                    data = numcodecs.Zstd().decode(file.read())
                part = tuple(slice(i * s, (i + 1) * s) for i, s in zip(place, self.chunks))
                self.samples[part] = np.frombuffer(data, self.dtype.newbyteorder("<")).reshape(self.chunks)
        self.samples = self.samples[tuple(map(slice, m["shape"]))]

    def __getitem__(self, place):
        return self.samples[place]


class Group3(dict):
    def __init__(self, folder):
        with open(f"{folder}/zarr.json") as file:
            m = json.load(file)
        assert (m["zarr_format"], m["node_type"]) == (3, "group") and list(m["attributes"]) == ["ome"], "group"
        self.attrs = m["attributes"]["ome"]
        assert self.attrs["version"] == "0.5" and "version" not in self.attrs["multiscales"][0], "version"
        for dataset in self.attrs["multiscales"][0]["datasets"]:
            self[dataset["path"]] = array = Array3(f"{folder}/{dataset['path']}")
            assert array.names == [a["name"] for a in self.attrs["multiscales"][0]["axes"]], "names of axes"


def check(folder, wanted, labels):
    group = Group3(folder) if os.path.exists(f"{folder}/zarr.json") else zarr.open(folder, "r")
    scales = group.attrs["multiscales"][0]
    parts = [[t[t["type"]] for t in d["coordinateTransformations"]] for d in scales["datasets"]]
    for k, dataset in enumerate(scales["datasets"]):
        factor, found = 2**k, group[dataset["path"]]
        assert found.dtype == wanted.dtype and max(found.chunks) <= 64, "type or chunks"
        for place in np.ndindex(wanted.shape[:-3]):
            volume = wanted[place]
            level = volume[::factor, ::factor, ::factor] if labels else means(volume, factor)
            assert (found[place] == level).all(), f"other samples at level {k} of {place}"
        scale, translation = (np.array(p)[-3:] for p in parts[k])
        shift = 0 if labels else (factor - 1) / 2
        assert np.allclose(scale, np.array(parts[0][0])[-3:] * factor), "scale"
        assert np.allclose(translation, np.array(parts[0][1])[-3:] + shift * np.array(parts[0][0])[-3:]), "translation"
    assert max(wanted.shape[-3:]) <= 64 or len(parts) > 1, "levels are missing"
    assert labels == ("image-label" in group.attrs), "labels"
    print(len(parts), scales["axes"][-1].get("unit"), *parts[0][0], *parts[0][1])
    for channel in group.attrs.get("omero", {}).get("channels", ()):
        print(channel["label"], channel["color"], channel["window"]["min"], channel["window"]["max"])


if __name__ == "__main__":
    if len(sys.argv) > 1:
        check(sys.argv[2], np.load(sys.argv[3]), sys.argv[4:] == ["labels"])
        sys.exit()
    make_2()
    make_images()
    make_3()
    if "CVOL" in os.environ:
        make_cvol()
