"""Files: .cvol files, and dense volumes in other formats."""

from __future__ import annotations

import ctypes as c
import os
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _abi
from ._call import Call, FormatError, Handle, out_pointer, path_bytes
from ._geometry import TYPES, Geometry, address, copy_grid, grid_geometry, grid_shape, make_grid, samples_of, type_number
from ._store import Store
from ._volume import Volume

Path = Union[str, "os.PathLike[str]"]


def open(path: Path, *, time: int = 0, channel: int = 0) -> Volume:  # pylint: disable=redefined-builtin
    """Opens a .cvol file. Slicing reads only the necessary bricks; everything else reads the whole file, once.

    time, channel: the volume of a series, from 0 (see `contents`); other volumes are not read.
    FormatError: not a .cvol file (`read` reads dense volumes); CorruptError: the file is damaged.
    """
    try:
        return Volume(Store.open(os.fspath(path), (time, channel)))
    except FormatError as error:
        if type(error) is FormatError and _abi.functions["file_is_volume"](path_bytes(path)):
            raise FormatError(f"{error}: cvol.read reads dense volumes, cvol.compress compresses them") from None
        raise


def read(
    path: Path,
    *,
    shape: Optional[tuple[int, int, int]] = None,
    dtype: Any = None,
    big_endian: bool = False,
    spacing: Optional[tuple[float, float, float]] = None,
    channel: Optional[int] = None,
    index: Optional[int] = None,
    series: Optional[str] = None,
) -> tuple[NDArray[Any], Geometry]:
    """Reads samples (z, y, x) and geometry of a dense volume: a file, or a folder of slices (``cvol info --build``
    lists the formats).

    shape, dtype, big_endian, spacing: for raw samples, which have no header; spacing also for formats without it.
    channel, index, series: the volume, if a file or a folder has several.
    Continue with ``compress(samples, geometry=geometry)``.
    """
    o = _abi.defaults("read_options")
    if shape is not None:
        o.dims[:] = [int(n) for n in shape[::-1]]
    if dtype is not None:
        o.type = type_number(dtype)
    if spacing is not None:
        o.spacing[:] = [float(v) for v in spacing[::-1]]
    o.big_endian = big_endian
    if channel is not None:
        o.has_channel, o.channel = 1, channel
    if index is not None:
        o.has_index, o.index = 1, index
    if series is not None:
        o.series = str(series).encode()
    out = out_pointer()
    name = os.fspath(path)
    with Call() as call:
        call("volume_stream_open", c.byref(out), path_bytes(path), c.byref(o), path=name)
        stream = Handle(out.value or 0, "volume_stream_free", "the file")
        with stream as pointer:
            grid = copy_grid(_abi.functions["volume_stream_grid"](pointer).contents)
            call("grid_check", c.byref(grid), path_bytes(path))
            samples = np.empty(grid_shape(grid), TYPES[grid.type])
            call("volume_stream_read", pointer, address(samples), 0, grid.dims[2])
        stream.close()
    return samples, grid_geometry(grid)


def write(
    path: Path, samples: Any, *, geometry: Optional[Geometry] = None, spacing: Optional[Any] = None
) -> None:
    """Writes samples (z, y, x), or those of a Volume with its geometry, as a dense volume. The extension chooses the
    format (`formats()`). The file gets its name only when it is complete."""
    if isinstance(samples, Volume):
        geometry = samples.geometry if geometry is None else geometry
        samples = samples.to_numpy()
    samples = samples_of(samples)
    if samples.ndim != 3:
        raise ValueError(f"the array has {samples.ndim} axes, must have 3")
    grid = make_grid(samples.shape, samples.dtype, geometry, spacing)
    out = out_pointer()
    with Call() as call:
        call("volume_writer_open", c.byref(out), path_bytes(path), c.byref(grid))
        try:
            call("volume_writer_write", out, address(samples), samples.shape[0])
        except BaseException:
            _abi.functions["volume_writer_abandon"](out)
            raise
        call("volume_writer_commit", out)


def formats() -> list[str]:
    """Extensions of dense volumes that this build reads and writes."""
    return _abi.functions["volume_formats"]().decode().split()  # type: ignore[no-any-return]
