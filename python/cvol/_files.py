"""Files: .cvol files, and dense volumes in other formats."""

from __future__ import annotations

import ctypes as c
import io
import os
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any, BinaryIO, Literal, Optional, Protocol, Union, overload, runtime_checkable

from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _abi
from ._call import ArgumentError, Call, FormatError, out_pointer, path_bytes
from ._dense import DenseStore, DenseVolume
from ._geometry import Geometry, address, make_grid, samples_of
from ._ranges import RangedStore, is_seekable
from ._reader import Reading, is_zarr, read_samples
from ._series import contents
from ._store import Store
from ._volume import Volume

_SIGNATURE = b"\x8bCVL\r\n\x1a\n"
Path = Union[str, "os.PathLike[str]"]


@runtime_checkable
class Readable(Protocol):
    """An object with the bytes of a file: io.BytesIO, an open file, a file of fsspec."""

    def read(self, size: int = -1, /) -> bytes: ...


@runtime_checkable
class Openable(Protocol):
    """An object that opens a file, such as the OpenFile of fsspec."""

    def open(self) -> BinaryIO: ...


Source = Union[Path, Readable, Openable]


@overload
def open(source: Source, *, time: Optional[int] = None, channel: Optional[int] = None,
         compress: Union[Literal[True], Mapping[str, object]] = True, ranges: bool = False) -> Volume: ...  # fmt: skip
@overload
def open(source: Source, *, time: Optional[int] = None, channel: Optional[int] = None,
         compress: Literal[False], ranges: bool = False) -> DenseVolume: ...  # fmt: skip
def open(  # pylint: disable=redefined-builtin
    source: Source,
    *,
    time: Optional[int] = None,
    channel: Optional[int] = None,
    compress: Union[bool, Mapping[str, object]] = True,
    ranges: bool = False,
) -> Union[Volume, DenseVolume]:
    """Opens a .cvol file, or a file of another format that `read` reads (NIfTI, NRRD, TIFF, a folder of DICOM,
    OME-Zarr, ...).

    source: a path. Or an object with read() or open(), such as io.BytesIO or a file of fsspec: it is read at once.
    time, channel: the volume of a series, from 0 (see `contents`); other volumes are not read. `open_colours` opens
        red, green and blue together.
    compress: for other formats. True: compress the samples in memory without loss, when they are first needed; a
        dictionary: with these options of `compress`, such as ``{"ratio": 20}``; False: return a `DenseVolume`, an
        array with all samples. For a .cvol file, False decodes all samples.
    ranges: for objects with seek() that hold a .cvol file, on Linux. True: do not read the object at once, but the
        ranges of bytes that slices and levels need, when they need them. The object must stay open as long as the
        volume is used.

    Slicing a .cvol file reads only the necessary bricks; everything else reads the whole file, once.
    FormatError: the format is unknown (`read` reads raw samples); CorruptError: the file is damaged.
    """
    if isinstance(source, (str, os.PathLike)):
        return _open_path(os.fspath(source), time, channel, compress)
    if isinstance(source, (Readable, Openable)):
        if ranges:
            return _decoded_if(compress is False, Volume(_ranged(source, (time or 0, channel or 0))))
        return _open_object(source, time, channel, compress)
    raise TypeError(f"cannot open a {type(source).__name__}: give a path, or an object with read()")


def _open_path(
    path: str, time: Optional[int], channel: Optional[int], compress: Union[bool, Mapping[str, object]]
) -> Union[Volume, DenseVolume]:
    f, is_cvol = _abi.functions, _abi.functions["file_is_cvol"](path_bytes(path))
    if is_zarr(path) or not is_cvol and f["file_is_volume"](path_bytes(path)):
        reading = Reading(channel=channel, number=time)
        if compress is False:
            return DenseVolume.of(*read_samples(path, reading))
        return Volume(DenseStore(path, reading, {"lossless": True} if compress is True else compress))
    if not is_cvol and os.path.isfile(path) and not path.endswith(".cvol"):
        raise FormatError(f"{path}: is not a .cvol file, and no volume that is known by content or name; raw samples "
                          "need cvol.read(path, shape=(nz, ny, nx), dtype=...)")  # fmt: skip
    volume = Volume(Store.open(path, (time or 0, channel or 0)))
    if channel is None and contents(path).colours:
        warnings.warn(f"{path}: has colours, and this is its first component: cvol.open_colours opens all of them; "
                      "channel=0 opens this one without a warning", stacklevel=3)  # fmt: skip
    return _decoded_if(compress is False, volume)


def _decoded_if(dense: bool, volume: Volume) -> Union[Volume, DenseVolume]:
    if not dense:
        return volume
    with volume:
        return DenseVolume.of(volume.to_numpy(), volume.geometry)


def _name(file: object) -> str:
    return str(getattr(file, "path", None) or getattr(file, "name", None) or "the object")


def _ranged(source: Union[Readable, Openable], place: tuple[int, int]) -> RangedStore:
    file: Any = source if isinstance(source, Readable) else source.open()
    if not is_seekable(file):
        raise TypeError(f"{_name(file)}: ranges=True needs a binary object with seek() and read()")
    file.seek(0)
    start = file.read(len(_SIGNATURE))
    if start != _SIGNATURE:
        raise FormatError(f"{_name(file)}: is not a .cvol file, of which ranges can be read: leave ranges=True out")
    return RangedStore(file, _name(file), place, owned=not isinstance(source, Readable))


def _open_object(source: Union[Readable, Openable], time: Optional[int], channel: Optional[int],
                 compress: Union[bool, Mapping[str, object]]) -> Union[Volume, DenseVolume]:  # fmt: skip
    with ExitStack() as stack:
        file = source if isinstance(source, Readable) else stack.enter_context(source.open())
        data = file.read()
        name = str(getattr(source, "path", None) or _name(file))
    if not isinstance(data, (bytes, bytearray, memoryview)):
        raise TypeError(f"{name}: read() returned {type(data).__name__}, must be bytes: open the file in binary mode")
    data = bytes(data)
    if data[:8] == _SIGNATURE and not time and not channel:
        return _decoded_if(compress is False, Volume(Store.from_bytes(data, name)))
    # Other formats, and series, are read from files. What is read does not need the file.
    with tempfile.TemporaryDirectory(prefix="cvol-") as folder:
        path = os.path.join(folder, os.path.basename(name) or "object")
        with io.open(path, "wb") as copy:
            copy.write(data)
        try:
            volume = _open_path(path, time, channel, compress)
            if isinstance(volume, Volume):
                volume._store.detach()
        except FormatError as error:
            raise type(error)(str(error).replace(path, name)) from None
        return volume


def read(
    path: Path,
    *,
    shape: Optional[tuple[int, int, int]] = None,
    dtype: DTypeLike = None,
    big_endian: bool = False,
    spacing: Optional[tuple[float, float, float]] = None,
    channel: Optional[int] = None,
    index: Optional[int] = None,
    series: Optional[str] = None,
    time: Optional[int] = None,
) -> tuple[NDArray[Any], Geometry]:
    """Reads samples (z, y, x) and geometry of a dense volume: a file, or a folder of slices (``cvol info --build``
    lists the formats).

    shape, dtype, big_endian, spacing: for raw samples, which have no header; spacing also for formats without it.
    channel, time, series: the volume, if a file or a folder has several; index is another name of time.
    Continue with ``compress(samples, geometry=geometry)``.
    """
    if index is not None and time is not None:
        raise ArgumentError("give only one of time and index")
    number = index if time is None else time
    return read_samples(os.fspath(path), Reading(shape, dtype, big_endian, spacing, channel, number, series))


def write(
    path: Path, samples: Union[ArrayLike, Volume], *, geometry: Optional[Geometry] = None,
    spacing: Union[float, Sequence[float], None] = None,
) -> None:  # fmt: skip
    """Writes samples (z, y, x), or those of a Volume with its geometry, as a dense volume. The extension chooses the
    format (`formats()`). The file gets its name only when it is complete."""
    if isinstance(samples, (Volume, DenseVolume)):
        geometry = samples.geometry if geometry is None else geometry
        samples = samples.to_numpy() if isinstance(samples, Volume) else samples
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
