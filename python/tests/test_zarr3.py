"""Zarr format 3: the codec class with a stand-in of zarr-python 3, which Debian 12 does not have, and OME-Zarr 0.5.

The stand-in has the names of zarr.abc.codec and zarr.registry that the codec uses, and buffers with their methods."""

import asyncio
import importlib
import json
import struct
import sys
import types
from dataclasses import dataclass
from types import SimpleNamespace

import cvol
import numpy as np
import pytest
from conftest import make_array
from cvol import _chunks, ome_zarr

PLACE = cvol.Geometry(spacing=(2, 1, 0.5), origin=(5, 6, 7), unit="um")


@dataclass
class Buffer:
    data: bytes

    @classmethod
    def from_bytes(cls, data):
        return cls(data)

    def to_bytes(self):
        return self.data


@dataclass
class NDBuffer:
    array: np.ndarray

    @classmethod
    def from_numpy_array(cls, array):
        return cls(array)

    def as_numpy_array(self):
        return self.array


class Getter:
    def __init__(self, buffer):
        self.buffer = buffer

    async def get(self, prototype, byte_range=None):
        return self.buffer


def spec(array):
    return SimpleNamespace(shape=array.shape, dtype=SimpleNamespace(to_native_dtype=lambda: array.dtype),
                           prototype=SimpleNamespace(buffer=Buffer, nd_buffer=NDBuffer))  # fmt: skip


@pytest.fixture
def module(monkeypatch):
    """cvol.zarr_codec, with the stand-in. Its base classes do for one chunk what those of zarr do for a batch."""

    class ArrayBytesCodec:
        async def encode(self, pairs):
            return [None if chunk is None else await self._encode_single(chunk, its) for chunk, its in pairs]

        async def decode(self, pairs):
            return [None if chunk is None else await self._decode_single(chunk, its) for chunk, its in pairs]

    class PartialDecode:
        async def decode_partial(self, batch):
            return [await self._decode_partial_single(*three) for three in batch]

    registered = {}
    modules = {
        "zarr": {}, "zarr.abc": {}, "zarr.registry": {"register_codec": registered.__setitem__},
        "zarr.abc.codec": {"ArrayBytesCodec": ArrayBytesCodec, "ArrayBytesCodecPartialDecodeMixin": PartialDecode},
    }  # fmt: skip
    for name, members in modules.items():
        fake = types.ModuleType(name)
        fake.__dict__.update(members)
        monkeypatch.setitem(sys.modules, name, fake)
    monkeypatch.delitem(sys.modules, "cvol.zarr_codec", raising=False)
    module = importlib.import_module("cvol.zarr_codec")
    assert registered == {"cvol": module.CvolCodec}
    yield module
    sys.modules.pop("cvol.zarr_codec", None)


@pytest.mark.parametrize("dtype", ["?", "i2", "u8", "f2", "f8"])
@pytest.mark.parametrize("shape", [(), (7,), (5, 9), (9, 8, 7), (2, 3, 4, 5)])
def test_chunks_come_back(module, dtype, shape):
    chunk = (np.arange(np.prod(shape, dtype=int)) % 90).reshape(shape).astype(dtype)
    codec = module.CvolCodec(effort="fast")
    (data,) = asyncio.run(codec.encode([(NDBuffer(chunk), spec(chunk))]))
    back, nothing = asyncio.run(codec.decode([(data, spec(chunk)), (None, spec(chunk))]))
    assert back.array.dtype == chunk.dtype and np.array_equal(back.array, chunk) and nothing is None
    if len(shape) == 3:
        turned = np.asfortranarray(chunk)
        assert asyncio.run(codec.encode([(NDBuffer(turned), spec(turned))]))[0].data == data.data


def test_parts_of_chunks(module, monkeypatch):
    """An index decodes only its bricks of a chunk that is a file."""
    chunk = make_array((80, 70, 140))
    codec = module.CvolCodec(max_error=9, effort="fast")
    data = asyncio.run(codec.encode([(NDBuffer(chunk), spec(chunk))]))[0]
    whole = _chunks.decode(data.data)
    assert 0 < np.abs(whole.astype(int) - chunk).max() <= 9
    boxes, read = [], cvol._store.Store._read
    monkeypatch.setattr(cvol._store.Store, "_read", lambda self, part: boxes.append(part) or read(self, part))
    for index in ((slice(3, 9), slice(0, 5), slice(70, 75)), (4, slice(None), slice(None, None, 3)),
                  (slice(0, 0), slice(None), 0), (np.array([[1], [70]]), np.array([[5, 6]]), 9)):  # fmt: skip
        (part,) = asyncio.run(codec.decode_partial([(Getter(data), index, spec(chunk))]))
        assert np.array_equal(part.array, whole[index]) and part.array.dtype == chunk.dtype
    assert boxes and all(part.begin for part in boxes)  # never the whole file
    series = np.stack([chunk[:20]] * 2)
    data = asyncio.run(codec.encode([(NDBuffer(series), spec(series))]))[0]
    part, none = asyncio.run(codec.decode_partial([(Getter(data), (1, slice(3, 5)), spec(series)),
                                                   (Getter(None), (0,), spec(series))]))  # fmt: skip
    assert none is None and np.array_equal(part.array, _chunks.decode(data.data)[1, 3:5])


def test_metadata(module):
    make = module.CvolCodec
    assert make().to_dict() == {"name": "cvol", "configuration": {"lossless": True}}
    assert make(psnr=40, effort="fast").to_dict()["configuration"] == {"psnr": 40, "effort": "fast"}
    for codec in (make(), make(ratio=20), make(max_error=0)):
        assert make.from_dict(json.loads(json.dumps(codec.to_dict()))) == make.from_dict(codec.to_dict())
        assert make.from_dict(codec.to_dict()).to_dict() == codec.to_dict()
    for options in ({"ratio": 3, "psnr": 40}, {"psnr": float("nan")}, {"max_error": -1}, {"effort": "none"}):
        with pytest.raises(ValueError):
            make(**options)
    with pytest.raises(ValueError, match="a newer cvol wrote them"):
        make.from_dict({"name": "cvol", "configuration": {"magic": 1}})
    make().validate(shape=(3,), dtype=np.dtype("f4"), chunk_grid=None)
    with pytest.raises(TypeError, match="the array has samples of complex128"):
        make().validate(shape=(3,), dtype=np.dtype("c16"), chunk_grid=None)
    with pytest.raises(NotImplementedError):
        make().compute_encoded_size(8, None)


def test_older_versions_of_zarr(monkeypatch):
    monkeypatch.setitem(sys.modules, "zarr.abc.codec", None)
    monkeypatch.delitem(sys.modules, "cvol.zarr_codec", raising=False)
    with pytest.raises(ImportError, match="needs zarr 3 or later: for older versions use cvol.codecs.Cvol"):
        importlib.import_module("cvol.zarr_codec")


# ---- OME-Zarr 0.5 ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def small():
    return make_array((40, 24, 32))


def compressors():
    numcodecs = pytest.importorskip("numcodecs", reason="numcodecs is not installed: its codecs are not tested")
    from cvol.codecs import Cvol

    return {"cvol": "cvol", "none": None, "gzip": numcodecs.GZip(3), "zstd": numcodecs.Zstd(3),
            "blosc": numcodecs.Blosc("zstd"), "Cvol": Cvol(lossless=True, effort="fast")}  # fmt: skip


@pytest.mark.parametrize("name", ["cvol", "none", "gzip", "zstd", "blosc", "Cvol"])
def test_writing(tmp_path, small, name):
    v = cvol.compress(small, lossless=True, effort="fast", geometry=PLACE)
    path = tmp_path / "mine.ome.zarr"
    ome_zarr.write(path, v, compressor=compressors()[name], chunks=(32, 32, 16), version="0.5",
                   attributes={"omero": {"channels": []}})  # fmt: skip
    ome = json.loads((path / "zarr.json").read_text())["attributes"]["ome"]
    assert ome["version"] == "0.5" and ome["omero"] == {"channels": []} and len(ome["multiscales"][0]["datasets"]) == 3
    assert "version" not in ome["multiscales"][0]
    first = json.loads((path / "0" / "zarr.json").read_text())
    assert first["shape"] == [40, 24, 32] and first["data_type"] == "int16" and (path / "0/c/1/0/1").is_file()
    assert first["dimension_names"] == ["z", "y", "x"]
    back = cvol.open(path)
    assert np.array_equal(back, small) and back.spacing == v.spacing and back.geometry == v.geometry
    for k in (1, 2):
        coarse = cvol.open(path / str(k))
        assert np.array_equal(coarse, v.levels[k]) and np.allclose(coarse.affine, v.levels[k].affine)
    image = ome_zarr.open_image(str(path))
    for box in (np.s_[3:35, 2:9, 10:20], np.s_[39, :, 5:6], np.s_[0:0]):
        assert np.array_equal(image.array[box], small[box])
    for wrong in (np.s_[::2], np.s_[40], -1):
        with pytest.raises(IndexError):
            image.array[wrong]
    with pytest.raises(FileExistsError, match="remove it first"):
        ome_zarr.write(path, v, version="0.5")


def write_array(path, shape, dtype, chunks, codecs, **more):
    path.mkdir(parents=True)
    metadata = {"zarr_format": 3, "node_type": "array", "shape": shape, "data_type": dtype,
                "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunks}},
                "chunk_key_encoding": {"name": "default"}, "fill_value": 7, "codecs": codecs, **more}  # fmt: skip
    (path / "zarr.json").write_text(json.dumps(metadata))


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return struct.pack("<I", crc ^ 0xFFFFFFFF)


def test_arrays_of_other_programs(tmp_path):
    """Shards, transposition, big-endian samples, missing chunks, v2 keys."""
    samples = make_array((8, 12, 10)).astype(">i2")
    inner = [{"name": "transpose", "configuration": {"order": [2, 0, 1]}},
             {"name": "bytes", "configuration": {"endian": "big"}}]  # fmt: skip
    shard = {"name": "sharding_indexed", "configuration": {
        "chunk_shape": [4, 6, 5], "codecs": inner, "index_location": "end",
        "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "crc32c"}]}}  # fmt: skip
    write_array(tmp_path / "shards", [8, 12, 10], "int16", [8, 6, 10], [shard])
    data, rows = b"", []
    for k in range(4):
        z, x = divmod(k, 2)
        if k == 2:  # missing
            rows.append((2**64 - 1, 2**64 - 1))
            continue
        part = samples[z * 4 : z * 4 + 4, :6, x * 5 : x * 5 + 5].transpose(2, 0, 1).tobytes()
        rows.append((len(data), len(part)))
        data += part
    (tmp_path / "shards/c/0/0").mkdir(parents=True)
    index = struct.pack("<8Q", *sum(rows, ()))
    file = tmp_path / "shards/c/0/0/0"
    file.write_bytes(data + index + b"sums")
    with pytest.raises(cvol.CorruptError, match="the check sum of the shard's index is wrong"):
        cvol.read(tmp_path / "shards")
    file.write_bytes(data + index + crc32c(index))
    expected = np.full((8, 12, 10), 7, np.int16)
    expected[:, :6] = samples[:, :6]
    expected[4:, :6, :5] = 7
    assert np.array_equal(cvol.open(tmp_path / "shards"), expected)
    write_array(tmp_path / "v2", [2, 5], "float32", [2, 5], [{"name": "bytes", "configuration": {"endian": "little"}}],
                chunk_key_encoding={"name": "v2"}, fill_value="NaN")  # fmt: skip
    assert np.isnan(cvol.read(tmp_path / "v2")[0]).all()
    (tmp_path / "v2/0.0").write_bytes(np.arange(10, dtype="<f4").tobytes())
    assert np.array_equal(cvol.open(tmp_path / "v2", compress=False)[0], np.arange(10.0).reshape(2, 5))


def test_what_is_wrong(tmp_path, small):
    bytes_ = [{"name": "bytes", "configuration": {"endian": "little"}}]
    cases = [
        ({"data_type": "complex64"}, "has samples of 'complex64'"), ({"shape": [4, 4]}, "lists of numbers"),
        ({"shape": [4, -1, 4]}, "lists of numbers"), ({"codecs": [{"name": "magic"}]}, "has the codec magic"),
        ({"codecs": []}, "no codec from samples"), ({"fill_value": "x"}, "the fill value is 'x'"),
        ({"chunk_grid": {"name": "rectilinear"}}, "must be a regular grid"), ({"codecs": bytes_}, "has 3 bytes"),
        ({"codecs": [{"name": "cvol"}]}, "not one that cvol made"), ({"codecs": [3]}, "must have a name"),
        ({"codecs": [{"name": "transpose", "configuration": {"order": [0, 0, 1]}}, *bytes_]}, "must order 3 axes"),
    ]  # fmt: skip
    for k, (change, text) in enumerate(cases):
        path = tmp_path / str(k)
        write_array(path, [4, 4, 4], "int16", [4, 4, 4], bytes_)
        metadata = json.loads((path / "zarr.json").read_text())
        (path / "zarr.json").write_text(json.dumps({**metadata, **change}))
        (path / "c/0/0").mkdir(parents=True)
        (path / "c/0/0/0").write_bytes(b"abc")
        with pytest.raises(cvol.Error, match=text):
            ome_zarr.open_image(str(path)).samples(None, None)
        with pytest.raises(cvol.Error):
            cvol.open(path).to_numpy()
    v = cvol.compress(small, lossless=True, effort="fast")
    with pytest.raises(ValueError, match="version is '0.3', must be '0.4' or '0.5'"):
        ome_zarr.write(tmp_path / "x", v, version="0.3")
    lzma = SimpleNamespace(get_config=lambda: {"id": "lzma"})
    with pytest.raises(cvol.UnsupportedError, match="the compressor is lzma"):
        ome_zarr.write(tmp_path / "x", v, version="0.5", compressor=lzma)
    assert not (tmp_path / "x").exists()
