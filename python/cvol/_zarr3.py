"""Arrays of Zarr format 3 in local folders, without the package zarr: metadata, chunks, and the codecs bytes,
transpose, gzip, zstd, blosc, crc32c (not verified), sharding_indexed (reading) and cvol. zstd and blosc need numcodecs.

Reference: https://zarr-specs.readthedocs.io/en/latest/v3/core/ (version 3.1).
"""

from __future__ import annotations

import gzip
import itertools
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, Optional

import numpy as np
from numpy.typing import DTypeLike, NDArray

from . import _chunks
from ._call import FormatError, UnsupportedError
from ._store import Store
from ._volume import Volume

_TYPES = ("bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float16", "float32",
          "float64")  # fmt: skip
_MISSING = 2**64 - 1  # offset and length of a chunk that a shard does not have
_SHUFFLES = ("noshuffle", "shuffle", "bitshuffle")


def _numcodecs(name: str, path: str) -> Any:
    try:
        import numcodecs  # type: ignore[import]
    except ImportError:
        raise ImportError(f"{path}: the codec {name} needs the package numcodecs, which is not installed") from None
    return numcodecs


def codec_metadata(compressor: Any) -> list[dict[str, Any]]:
    """The list of codecs for a compressor of numcodecs (Cvol, GZip, Zstd or Blosc), "cvol" (lossless) or None."""
    if isinstance(compressor, str) and compressor == "cvol":
        return [{"name": "cvol", "configuration": {"lossless": True}}]
    plain: dict[str, Any] = {"name": "bytes", "configuration": {"endian": "little"}}
    if compressor is None:
        return [plain]
    options = dict(compressor.get_config()) if hasattr(compressor, "get_config") else {"id": repr(compressor)}
    name = options.pop("id")
    if name == "cvol":
        return [{"name": "cvol", "configuration": options}]
    if name == "gzip":
        return [plain, {"name": "gzip", "configuration": {"level": options["level"]}}]
    if name == "zstd":
        return [plain, {"name": "zstd", "configuration": {"level": options["level"], "checksum": False}}]
    if name == "blosc" and options["shuffle"] in (0, 1, 2):
        chosen = {key: options[key] for key in ("cname", "clevel", "blocksize")}
        return [plain, {"name": "blosc", "configuration": {**chosen, "shuffle": _SHUFFLES[options["shuffle"]],
                                                           "typesize": 1}}]  # fmt: skip
    raise UnsupportedError(f"the compressor is {name}: OME-Zarr 0.5 is written with cvol, gzip, zstd, blosc or None")


def _parts(codec: Any, path: str) -> tuple[str, dict[str, Any]]:
    """Name and configuration of a codec in metadata."""
    if isinstance(codec, str):
        return codec, {}
    if not isinstance(codec, dict) or not isinstance(codec.get("name"), str):
        raise FormatError(f"{path}: a codec is {codec!r}, must have a name")
    return codec["name"], codec.get("configuration") or {}


def _unpacked(data: bytes, name: str, options: Mapping[str, Any], path: str) -> bytes:
    """Undoes a codec from bytes to bytes."""
    if name == "gzip":
        return gzip.decompress(data)
    if name == "crc32c":
        return data[:-4]
    if name in ("zstd", "blosc"):
        codec = _numcodecs(name, path)
        return bytes((codec.Zstd() if name == "zstd" else codec.Blosc()).decode(data))
    raise UnsupportedError(f"{path}: has the codec {name}, must be one of bytes, transpose, gzip, zstd, blosc, crc32c, "
                           "sharding_indexed, cvol")  # fmt: skip


def _packed(data: bytes, name: str, options: Mapping[str, Any], itemsize: int) -> bytes:
    if name == "gzip":
        return gzip.compress(data, options["level"], mtime=0)
    codec = _numcodecs(name, "the array")
    if name == "zstd":
        return bytes(codec.Zstd(options["level"]).encode(data))
    made = codec.Blosc(options["cname"], options["clevel"], _SHUFFLES.index(options["shuffle"]), options["blocksize"])
    return bytes(made.encode(np.frombuffer(data, f"u{itemsize}")))


class Array:
    """An array of a folder with zarr.json, for reading by integers and slices of step 1. It reads only the chunks, and
    from chunks that are .cvol files only the bricks, that an index needs."""

    def __init__(self, path: str, metadata: Mapping[str, Any]) -> None:
        self.path = path
        self.store = SimpleNamespace(path=path)
        grid, keys = metadata.get("chunk_grid") or {}, metadata.get("chunk_key_encoding") or {}
        kind = metadata.get("data_type")
        if kind not in _TYPES:
            raise UnsupportedError(f"{path}: has samples of {kind!r}, must be one of {', '.join(_TYPES)}")
        if grid.get("name") != "regular" or keys.get("name") not in ("default", "v2"):
            raise UnsupportedError(f"{path}: has chunks of {grid.get('name')!r}, keys of {keys.get('name')!r}, must be "
                                   "a regular grid with default or v2 keys")  # fmt: skip
        shape: Any = metadata.get("shape")
        chunks: Any = grid.get("configuration", {}).get("chunk_shape")
        if not _whole(shape, 0) or not _whole(chunks, 1) or len(shape) != len(chunks):
            raise FormatError(f"{path}: has the shape {shape!r} in chunks of {chunks!r}, must be lists of numbers of "
                              "the same length")  # fmt: skip
        self.shape: tuple[int, ...] = tuple(shape)
        self.chunks: tuple[int, ...] = tuple(chunks)
        self.ndim = len(self.shape)
        self.dtype = np.dtype(kind)
        self._codecs = metadata.get("codecs") or []
        self._fill = _fill(metadata.get("fill_value", 0), self.dtype, path)
        default = keys["name"] == "default"
        self._separator = keys.get("configuration", {}).get("separator", "/" if default else ".")
        self._prefix = "c" if default else ""

    def _chunk_path(self, place: tuple[int, ...]) -> str:
        names = [self._prefix] * bool(self._prefix) + [str(i) for i in place]
        return os.path.join(self.path, self._separator.join(names or ["0"]))

    def __getitem__(self, index: Any) -> NDArray[Any]:
        parts = (*(index if isinstance(index, tuple) else (index,)),)
        parts = (*parts, *[slice(None)] * (self.ndim - len(parts)))
        ranges = [range(*p.indices(n)) if isinstance(p, slice) else range(p, p + 1) for p, n in zip(parts, self.shape)]
        if len(parts) != self.ndim or any(r.step != 1 or not 0 <= r.start for r in ranges):
            raise IndexError(f"the index is {index!r}, must be integers from 0, and slices of step 1")
        if any(len(r) and r.stop > n for r, n in zip(ranges, self.shape)):
            raise IndexError(f"the index is {index!r}, the array has shape {self.shape}")
        out = np.full([len(r) for r in ranges], self._fill, self.dtype)
        for place, source, target in _overlaps(ranges, self.chunks):
            part = self._read(self._chunk_path(place), source)
            if part is not None:
                out[target] = part
        return out.reshape([len(r) for r, p in zip(ranges, parts) if isinstance(p, slice)])

    def _read(self, path: str, box: tuple[slice, ...]) -> Optional[NDArray[Any]]:
        """A box of a chunk; None: there is no such chunk."""
        if not os.path.exists(path):
            return None
        alone = [_parts(codec, self.path)[0] for codec in self._codecs] == ["cvol"]
        if alone and self.ndim == 3 and self.dtype.kind != "b":
            with open(path, "rb") as file:
                single = file.read(8) == _chunks.SIGNATURE
            if single:
                with Volume(Store.open(path)) as volume:
                    if volume.shape != self.chunks or volume.dtype != self.dtype:
                        raise FormatError(
                            f"{path}: is {volume.shape} {volume.dtype}, must be {self.chunks} {self.dtype}"
                        )
                    return np.asarray(volume[box])
        with open(path, "rb") as file:
            data = file.read()
        return self._decode(data, self._codecs, self.chunks, box)

    def _decode(
        self, data: bytes, codecs: Sequence[Any], shape: tuple[int, ...], box: tuple[slice, ...]
    ) -> NDArray[Any]:
        listed = [_parts(codec, self.path) for codec in codecs]
        order = tuple(range(len(shape)))
        while listed and listed[0][0] == "transpose":
            turn: Any = listed.pop(0)[1].get("order")
            if sorted(turn or ()) != list(range(len(shape))):
                raise FormatError(f"{self.path}: a transposition is {turn!r}, must order {len(shape)} axes")
            order = tuple(order[k] for k in turn)
        if not listed:
            raise FormatError(f"{self.path}: has no codec from samples to bytes")
        inner = tuple(shape[k] for k in order)
        back = np.argsort(order)
        (name, options), *packers = listed
        for packer, its in reversed(packers):
            data = _unpacked(data, packer, its, self.path)
        if name == "sharding_indexed":
            chunk = self._unshard(data, options, inner)
        elif name == "cvol":
            chunk = _chunks.decode(data).astype(self.dtype, copy=False)
        elif name == "bytes":
            dtype = self.dtype.newbyteorder(">" if options.get("endian") == "big" else "<")
            if len(data) != math.prod(inner) * dtype.itemsize:
                raise FormatError(f"{self.path}: a chunk has {len(data)} bytes, must have "
                                  f"{math.prod(inner) * dtype.itemsize}")  # fmt: skip
            chunk = np.frombuffer(data, dtype).reshape(inner)
        else:
            _unpacked(b"", name, options, self.path)
            raise FormatError(f"{self.path}: has the codec {name} before its samples are bytes")
        if chunk.shape != inner:
            raise FormatError(f"{self.path}: a chunk has shape {chunk.shape}, must have {inner}")
        return chunk.transpose(back)[box]

    def _unshard(self, data: bytes, options: Mapping[str, Any], shape: tuple[int, ...]) -> NDArray[Any]:
        """All samples of a shard: chunks, and an index of their offsets and lengths at its end (or begin)."""
        sides: Any = options.get("chunk_shape")
        if not _whole(sides, 1) or len(sides) != len(shape) or any(n % c for n, c in zip(shape, sides)):
            raise FormatError(f"{self.path}: shards of {shape} have chunks of {sides!r}, must divide them")
        names = [_parts(codec, self.path)[0] for codec in options.get("index_codecs", [])]
        if names not in (["bytes"], ["bytes", "crc32c"]):
            raise UnsupportedError(f"{self.path}: the index of shards has the codecs {names}, must be bytes and crc32c")
        counts = [n // c for n, c in zip(shape, sides)]
        size = 16 * math.prod(counts) + 4 * (len(names) - 1)
        if len(data) < size:
            raise FormatError(f"{self.path}: a shard has {len(data)} bytes, its index needs {size}")
        index = data[:size] if options.get("index_location") == "start" else data[len(data) - size :]
        rows = np.frombuffer(index, "<u8", 2 * math.prod(counts)).reshape(-1, 2)
        out = np.full(shape, self._fill, self.dtype)
        for place, (offset, length) in zip(itertools.product(*map(range, counts)), rows.tolist()):
            if offset == length == _MISSING:
                continue
            if offset + length > len(data):
                raise FormatError(f"{self.path}: a chunk of a shard ends at byte {offset + length} of {len(data)}")
            box = tuple(slice(i * c, (i + 1) * c) for i, c in zip(place, sides))
            whole = tuple(slice(None) for _ in sides)
            out[box] = self._decode(data[offset : offset + length], options.get("codecs", []), tuple(sides), whole)
        return out


def _whole(values: Any, least: int) -> bool:
    """Whether it is a list of integers from `least`."""
    return isinstance(values, list) and all(type(n) is int and least <= n < 2**40 for n in values)


def _fill(value: Any, dtype: np.dtype[Any], path: str) -> Any:
    names = {"NaN": np.nan, "Infinity": np.inf, "-Infinity": -np.inf}
    try:
        if isinstance(value, str) and value.startswith("0x"):
            return np.frombuffer(bytes.fromhex(value[2:]), dtype.newbyteorder(">")).astype(dtype)[0]
        return np.array(names.get(value, value) if isinstance(value, str) else value, dtype)[()]
    except (ValueError, TypeError, OverflowError):
        raise FormatError(f"{path}: the fill value is {value!r}, must be a number of {dtype}") from None


def _overlaps(
    ranges: Sequence[range], sides: Sequence[int]
) -> Iterator[tuple[tuple[int, ...], tuple[slice, ...], tuple[slice, ...]]]:
    """The chunks that touch a box: their places, and the part of each in the chunk and in the box."""
    axes = []
    for r, side in zip(ranges, sides):
        axis = []
        for i in range(r.start // side, -(-r.stop // side) if len(r) else r.start // side):
            low, high = max(r.start, i * side), min(r.stop, (i + 1) * side)
            axis.append((i, slice(low - i * side, high - i * side), slice(low - r.start, high - r.start)))
        axes.append(axis)
    for parts in itertools.product(*axes):
        yield tuple(p[0] for p in parts), tuple(p[1] for p in parts), tuple(p[2] for p in parts)


class Writer:
    """Writes an array of three axes in a new folder: regular chunks with default keys."""

    def __init__(
        self, path: str, shape: Sequence[int], chunks: Sequence[int], dtype: DTypeLike, codecs: list[dict[str, Any]]
    ) -> None:
        self.path, self.chunks, self.dtype = path, tuple(chunks), np.dtype(dtype)
        self._codecs = json.loads(json.dumps(codecs))
        for codec in self._codecs:
            if codec["name"] == "blosc":
                codec["configuration"]["typesize"] = self.dtype.itemsize
        write_metadata(path, {
            "zarr_format": 3, "node_type": "array", "shape": list(shape), "data_type": self.dtype.name,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(self.chunks)}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": 0, "codecs": self._codecs, "attributes": {}, "dimension_names": ["z", "y", "x"],
        })  # fmt: skip

    def write(self, first: int, samples: NDArray[Any]) -> None:
        """A layer of chunks: all samples of the chunks at place `first` along z. Chunks at the end are filled with
        copies of the last samples, as chunks always have their full shape."""
        ranges = [range(n) for n in samples.shape]
        for place, _, target in _overlaps(ranges, self.chunks):
            part = samples[target]
            chunk = np.pad(part, [(0, c - n) for c, n in zip(self.chunks, part.shape)], mode="edge")
            folder = os.path.join(self.path, "c", str(first), str(place[1]))
            os.makedirs(folder, exist_ok=True)
            with open(os.path.join(folder, str(place[2])), "wb") as file:
                file.write(self._encode(chunk))

    def _encode(self, chunk: NDArray[Any]) -> bytes:
        if self._codecs[0]["name"] == "cvol":
            return _chunks.encode(chunk, self._codecs[0]["configuration"])
        data = chunk.astype(self.dtype.newbyteorder("<"), copy=False).tobytes()
        for codec in self._codecs[1:]:
            data = _packed(data, codec["name"], codec["configuration"], self.dtype.itemsize)
        return data


def read_metadata(path: str) -> Optional[dict[str, Any]]:
    """zarr.json of a folder; None: there is none. FormatError: it is not JSON; UnsupportedError: it
    is of another format."""
    name = os.path.join(path, "zarr.json")
    try:
        with open(name, encoding="utf-8") as file:
            metadata = json.load(file)
    except FileNotFoundError:
        return None
    except ValueError as error:
        raise FormatError(f"{name}: is not JSON: {error}") from None
    if not isinstance(metadata, dict) or metadata.get("zarr_format") != 3:
        raise UnsupportedError(f"{name}: does not state Zarr format 3")
    return metadata


def write_metadata(path: str, metadata: Mapping[str, Any]) -> None:
    """Writes zarr.json into a folder, which is made."""
    os.makedirs(path, exist_ok=True)
    with open(os.path.join(path, "zarr.json"), "w", encoding="utf-8") as file:
        json.dump(metadata, file, indent=1)
