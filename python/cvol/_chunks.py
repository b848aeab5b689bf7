"""Chunks of arrays of any number of axes as bytes: one .cvol file, or several behind a header (doc/zarr.md)."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._call import FormatError, TargetError
from ._compress import EFFORTS, PSNR_INSTEAD, compress, missing_value
from ._geometry import TYPES
from ._store import Store
from ._volume import Volume

SIGNATURE, _CHUNK = b"\x8bCVL\r\n\x1a\n", b"\x8bCVK\r\n\x1a\n"
_HEAD = struct.Struct("<8sBBc5s")  # signature, version, number of axes, order in memory, type
_MOST_AXES = 32
TARGETS = ("ratio", "psnr", "max_error", "lossless")


def target_of(effort: str, **targets: Any) -> dict[str, Any]:
    """The only target that is given; lossless if none is. ValueError: several, or a value that no codec accepts."""
    given = {name: v for name, v in targets.items() if v is not None and v is not False} or {"lossless": True}
    if len(given) > 1:
        raise ValueError(f"give only one of {' and '.join(given)}")
    for name, value in given.items():
        if not 0 <= value < math.inf:
            raise ValueError(f"{name} is {value!r}, must be a number from 0")
    if effort not in EFFORTS:
        raise ValueError(f"effort is {effort!r}, must be one of {', '.join(EFFORTS)}")
    return given


def _compressed(samples: NDArray[Any], options: Mapping[str, Any]) -> bytes:
    """One volume as a .cvol file. A target that cannot be met gives way to 35 dB, that to lossless."""
    target: dict[str, Any] = {"lossless": True} if samples.dtype == np.bool_ else dict(options)
    effort = target.pop("effort", "default")
    fill = missing_value(samples)
    attempts: list[dict[str, Any]] = [target, {"psnr": PSNR_INSTEAD}, {"lossless": True}]
    for attempt in attempts:
        try:
            with compress(samples, fill=fill, labels=False, effort=effort, **attempt) as volume:
                return volume.to_bytes()
        except TargetError:
            if "ratio" not in target and "psnr" not in target:
                raise
    raise AssertionError("lossless has no target")


def _as_volumes(chunk: NDArray[Any]) -> NDArray[Any]:
    """(count, z, y, x): the last three axes are those of a volume; missing ones have length 1."""
    shape = (1,) * (3 - chunk.ndim) + chunk.shape
    return chunk.reshape((math.prod(shape[:-3]), *shape[-3:]))


def encode(chunk: NDArray[Any], options: Mapping[str, Any]) -> bytes:
    """The bytes of a chunk (..., z, y, x), of bool, integers or floats. options: of `compress`.

    TypeError: another type; DataError: integers of 64 bits beyond int32 and uint32.
    """
    if chunk.dtype.kind not in "biuf" or chunk.dtype.itemsize > 8:
        raise TypeError(f"the chunk has samples of {chunk.dtype}: cvol compresses bool, integers, and floats of 16, "
                        "32 or 64 bits")  # fmt: skip
    order = b"F" if chunk.flags.f_contiguous and not chunk.flags.c_contiguous else b"C"
    if chunk.ndim == 3 and chunk.size and chunk.dtype in TYPES.values() and order == b"C":
        return _compressed(chunk, options)
    files = [_compressed(volume, options) for volume in _as_volumes(chunk)] if chunk.size else []
    head = _HEAD.pack(_CHUNK, 1, chunk.ndim, order, chunk.dtype.str.encode())
    head += struct.pack(f"<{chunk.ndim + len(files)}Q", *chunk.shape, *map(len, files))
    return b"".join([head, struct.pack("<I", zlib.crc32(head)), *files])


def _samples(data: bytes) -> NDArray[Any]:
    with Volume(Store.from_bytes(data, "the chunk")) as volume:
        return volume.to_numpy()


def _head(data: bytes) -> tuple[np.dtype[Any], str, tuple[int, ...], Iterator[bytes]]:
    """Type, order, shape and files of a chunk with a header. FormatError: the header is wrong."""
    if len(data) < _HEAD.size or data[:8] != _CHUNK:
        raise FormatError("the chunk is not one that cvol made: its signature is wrong")
    _, version, axes, order, kind = _HEAD.unpack_from(data)
    if version != 1:
        raise FormatError(f"the chunk has version {version}, must be 1: a newer cvol made it")
    end = _HEAD.size + 8 * axes
    if order not in (b"C", b"F"):
        raise FormatError(f"the chunk has the order {order!r}, must be C or F")
    if axes > _MOST_AXES or len(data) < end:
        raise FormatError(f"the chunk ends within its shape of {axes} axes")
    shape = struct.unpack_from(f"<{axes}Q", data, _HEAD.size)
    count = math.prod(shape[:-3]) if 0 not in shape else 0
    if count > len(data) // 8 or len(data) < end + 8 * count + 4:
        raise FormatError(f"the chunk ends within the lengths of its {count} volumes")
    lengths = struct.unpack_from(f"<{count}Q", data, end)
    end += 8 * count
    if struct.unpack_from("<I", data, end)[0] != zlib.crc32(data[:end]):
        raise FormatError("the header of the chunk is damaged: its checksum is wrong")
    if end + 4 + sum(lengths) != len(data):
        raise FormatError(f"the chunk has {len(data)} bytes, its header says {end + 4 + sum(lengths)}")
    begins = np.cumsum([end + 4, *lengths], dtype=np.uint64).tolist()
    dtype = np.dtype(kind.rstrip(b"\0").decode())
    return dtype, order.decode(), shape, (data[b : b + n] for b, n in zip(begins, lengths))


def decode(data: bytes) -> NDArray[Any]:
    """The chunk of `encode`. FormatError: not such bytes; CorruptError: they are damaged."""
    if data[:8] == SIGNATURE:
        return _samples(data)
    dtype, order, shape, files = _head(data)
    volumes = []
    for file in files:
        volumes.append(_samples(file))
        if volumes[-1].shape != ((1,) * (3 - len(shape)) + shape)[-3:]:
            raise FormatError(f"a volume of the chunk has shape {volumes[-1].shape}, its header says {shape}")
    if not volumes:
        return np.empty(shape, dtype)
    chunk = np.stack(volumes).astype(dtype, copy=False).reshape(shape)
    return np.asarray(chunk, order=order)  # type: ignore[call-overload,no-any-return]
