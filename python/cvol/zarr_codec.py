# mypy: ignore-errors
"""Codec "cvol" of zarr-python 3, for arrays of Zarr format 3 (doc/zarr.md).

>>> import zarr
>>> from cvol.zarr_codec import CvolCodec
>>> a = zarr.create_array("scan.zarr", data=samples, chunks=(64, 64, 64), serializer=CvolCodec(max_error=4),
...                       compressors=None)

An installed package makes the codec known to zarr. Without installation, importing this module does. Arrays of format
2 use `cvol.codecs.Cvol`.
"""

from __future__ import annotations

import asyncio
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import ClassVar, Optional

import numpy as np
from numpy.typing import NDArray

try:
    from zarr.abc.codec import ArrayBytesCodec, ArrayBytesCodecPartialDecodeMixin
    from zarr.registry import register_codec
except ImportError:
    raise ImportError("cvol.zarr_codec needs zarr 3 or later: for older versions use cvol.codecs.Cvol") from None

from . import _chunks
from ._store import Store
from ._volume import Volume


@contextmanager
def _as_file(data: bytes) -> Iterator[str]:
    """A path at which the bytes can be read: in memory on Linux, else a temporary file."""
    if hasattr(os, "memfd_create"):
        descriptor, path = os.memfd_create("cvol-chunk"), None
    else:
        descriptor, path = tempfile.mkstemp(prefix="cvol-chunk-")
    try:
        view = memoryview(data)
        while view:
            view = view[os.write(descriptor, view) :]
        yield path or f"/proc/self/fd/{descriptor}"
    finally:
        os.close(descriptor)
        if path:
            os.unlink(path)


def decode_part(data: bytes, selection: tuple) -> NDArray:
    """The samples of a chunk that an index of NumPy selects. Of a chunk that is a .cvol file, only the bricks of the
    index are decoded; other chunks are decoded as a whole."""
    if data[:8] != _chunks.SIGNATURE:
        return _chunks.decode(data)[selection]
    with _as_file(data) as path, Volume(Store.open(path)) as volume:
        return np.asarray(volume[selection])


@dataclass(frozen=True)
class CvolCodec(ArrayBytesCodecPartialDecodeMixin, ArrayBytesCodec):
    """Compresses each chunk as a volume (z, y, x); of more axes, each combination of the first ones as a volume.

    At most one of
        ratio: raw bytes / compressed bytes, at least.
        psnr: decibels over the value range of the chunk, at least.
        max_error: largest |original - decoded|, at most; 0: lossless.
        lossless: every sample decodes to its original bits; the default.
    effort: "default", "fast" or "max"; see `cvol.compress`.

    An index that touches a part of a chunk decodes only the bricks of the part (64 samples a side by default, see
    `Volume.chunks`). The store delivers the chunk as a whole.
    """

    ratio: Optional[float] = None
    psnr: Optional[float] = None
    max_error: Optional[float] = None
    lossless: bool = False
    effort: str = "default"

    is_fixed_size: ClassVar[bool] = False

    def __post_init__(self) -> None:
        self._target()  # checks the options

    def _target(self) -> dict[str, float]:
        return _chunks.target_of(self.effort, **{name: getattr(self, name) for name in _chunks.TARGETS})

    @classmethod
    def from_dict(cls, data: dict) -> "CvolCodec":
        """The codec of an entry of the list "codecs" in zarr.json."""
        if data.get("name") != "cvol":
            raise ValueError(f"the codec is {data.get('name')!r}, must be 'cvol'")
        options = data.get("configuration") or {}
        wrong = sorted(set(options) - {*_chunks.TARGETS, "effort"})
        if wrong:
            raise ValueError(f"the codec cvol has the options {', '.join(wrong)}: a newer cvol wrote them")
        return cls(**options)

    def to_dict(self) -> dict:
        """The entry of the list "codecs"."""
        effort = {} if self.effort == "default" else {"effort": self.effort}
        return {"name": "cvol", "configuration": {**self._target(), **effort}}

    def validate(self, *, shape: tuple[int, ...], dtype: object, chunk_grid: object) -> None:
        """TypeError: samples that cvol does not compress."""
        native = np.dtype(dtype.to_native_dtype() if hasattr(dtype, "to_native_dtype") else dtype)
        if native.kind not in "biuf" or native.itemsize > 8:
            raise TypeError(f"the array has samples of {native}: cvol compresses bool, integers, and floats of 16, 32 "
                            "or 64 bits")  # fmt: skip

    def compute_encoded_size(self, input_byte_length: int, _chunk_spec: object) -> int:
        """NotImplementedError: the size depends on the samples."""
        raise NotImplementedError

    async def _encode_single(self, chunk_data: object, chunk_spec: object) -> object:
        samples = np.ascontiguousarray(chunk_data.as_numpy_array())
        data = await asyncio.to_thread(_chunks.encode, samples, {**self._target(), "effort": self.effort})
        return chunk_spec.prototype.buffer.from_bytes(data)

    async def _decode_single(self, chunk_data: object, chunk_spec: object) -> object:
        samples = await asyncio.to_thread(_chunks.decode, chunk_data.to_bytes())
        return self._delivered(samples.reshape(chunk_spec.shape), chunk_spec)

    async def _decode_partial_single(self, byte_getter: object, selection: tuple, chunk_spec: object) -> object:
        found = await byte_getter.get(prototype=chunk_spec.prototype)
        if found is None:
            return None
        return self._delivered(await asyncio.to_thread(decode_part, found.to_bytes(), selection), chunk_spec)

    @staticmethod
    def _delivered(samples: NDArray, chunk_spec: object) -> object:
        dtype = chunk_spec.dtype
        native = dtype.to_native_dtype() if hasattr(dtype, "to_native_dtype") else np.dtype(dtype)
        return chunk_spec.prototype.nd_buffer.from_numpy_array(samples.astype(native, copy=False))


register_codec("cvol", CvolCodec)
