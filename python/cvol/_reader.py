"""Reading dense volumes of all formats of the library."""

from __future__ import annotations

import ctypes as c
import math
import os
from collections.abc import Sequence
from functools import partial
from typing import Any, Callable, NamedTuple, Optional, TypeVar, Union

import numpy as np
from numpy.typing import DTypeLike, NDArray

from . import _abi
from ._call import ArgumentError, Call, Handle, UnsupportedError, out_pointer, path_bytes
from ._geometry import TYPES, Geometry, address, copy_grid, grid_geometry, grid_shape
from ._geometry import make_grid, samples_of, type_number

_Result = TypeVar("_Result")


def _spacing(spacing: Sequence[float]) -> list[float]:
    """Three numbers in the order of the library, where 0 would mean: as in the file."""
    numbers = [float(v) for v in np.atleast_1d(np.asarray(spacing, float))]
    if len(numbers) != 3 or not all(v > 0 and math.isfinite(v) for v in numbers):
        raise ArgumentError(f"spacing is {spacing!r}, must be three numbers above 0, of z, y and x")
    return numbers[::-1]


class Reading(NamedTuple):
    """What to read of a file; see `read`. number: its `index`."""

    shape: Optional[tuple[int, int, int]] = None
    dtype: DTypeLike = None
    big_endian: bool = False
    spacing: Optional[tuple[float, float, float]] = None
    channel: Optional[int] = None
    number: Optional[int] = None
    series: Optional[str] = None

    def options(self) -> Any:
        """cvol_read_options."""
        o = _abi.defaults("read_options")
        if self.shape is not None:
            o.dims[:] = [int(n) for n in self.shape[::-1]]
        if self.dtype is not None:
            o.type = type_number(self.dtype)
        if self.spacing is not None:
            o.spacing[:] = _spacing(self.spacing)
        o.big_endian = self.big_endian
        if self.channel is not None:
            o.has_channel, o.channel = 1, self.channel
        if self.number is not None:
            o.has_index, o.index = 1, self.number
        if self.series is not None:
            o.series = str(self.series).encode()
        return o


def is_zarr(path: Union[str, bytes]) -> bool:
    """Whether the path is a folder of Zarr."""
    names = ("zarr.json", ".zarray", ".zgroup", ".zattrs")
    return isinstance(path, str) and any(os.path.isfile(os.path.join(path, name)) for name in names)


def _image(path: str, error: Exception) -> Any:
    """An image that the library did not read because of this error: of 64-bit integers, or by codecs that only Python
    has."""
    from .ome_zarr import open_image  # circular import

    try:
        return open_image(path)
    except ImportError:
        raise error from None


def _by_image(path: str, read: Callable[[], _Result], read_image: Callable[[Any], _Result]) -> _Result:
    """What `read` returns, or for a folder of Zarr that the library does not read, what `read_image` does."""
    try:
        return read()
    except UnsupportedError as error:
        if not is_zarr(path):
            raise
        return read_image(_image(path, error))


def _open(call: Call, path: Union[str, bytes], reading: Reading) -> tuple[Handle, Any]:
    """The stream of a file and its grid."""
    out, o = out_pointer(), reading.options()
    name = path if isinstance(path, str) else None
    call("volume_stream_open", c.byref(out), path_bytes(path), c.byref(o), path=name)
    stream = Handle(out.value or 0, "volume_stream_free", "the file")
    with stream as pointer:
        grid = copy_grid(_abi.functions["volume_stream_grid"](pointer).contents)
    call("grid_check", c.byref(grid), path_bytes(path))
    return stream, grid


def count_volumes(path: str) -> tuple[int, int]:
    """Numbers of times and of channels of a file that is not a .cvol file."""
    return _by_image(path, partial(_count_volumes, path), lambda image: (image.count("t"), image.count("c")))


def _count_volumes(path: str) -> tuple[int, int]:
    times, channels, o = c.c_int(), c.c_int(), Reading().options()
    with Call() as call:
        call("file_count_volumes", c.byref(times), c.byref(channels), path_bytes(path), c.byref(o), path=path)
    return times.value, channels.value


def has_colours(path: str) -> bool:
    """Whether the channels of a file that is not a .cvol file are components of colours."""
    return _by_image(path, partial(_has_colours, path), lambda image: False)


def _has_colours(path: str) -> bool:
    with Call() as call:
        stream, _ = _open(call, path, Reading(channel=0, number=0))
        with stream as pointer:
            found = bool(_abi.functions["volume_stream_has_colours"](pointer))
        stream.close()
    return found


def read_grid(path: str, reading: Reading) -> Any:
    """The grid of a file, from its header."""

    def of_image(image: Any) -> Any:
        shape = tuple(image.count(axis) for axis in ("z", "y", "x"))
        native = image.array.dtype.newbyteorder("=") in TYPES.values()
        dtype = image.array.dtype if native else samples_of(read_samples(path, reading)[0]).dtype
        image.check(reading.number, reading.channel)
        return make_grid(shape, dtype, image.geometry())

    return _by_image(path, partial(_read_grid, path, reading), of_image)


def _read_grid(path: str, reading: Reading) -> Any:
    with Call() as call:
        stream, grid = _open(call, path, reading)
        stream.close()
    return grid


def read_samples(path: str, reading: Reading) -> tuple[NDArray[Any], Geometry]:
    """Samples (z, y, x) and geometry of a file."""

    def of_image(image: Any) -> tuple[NDArray[Any], Geometry]:
        samples = samples_of(image.samples(reading.number, reading.channel))
        return samples, grid_geometry(make_grid(samples.shape, samples.dtype, image.geometry()))

    return _by_image(path, partial(_read_samples, path, reading), of_image)


def _read_samples(path: str, reading: Reading) -> tuple[NDArray[Any], Geometry]:
    with Call() as call:
        stream, grid = _open(call, path, reading)
        samples = np.empty(grid_shape(grid), TYPES[grid.type])
        with stream as pointer:
            call("volume_stream_read", pointer, address(samples), 0, grid.dims[2])
        stream.close()
    return samples, grid_geometry(grid)
