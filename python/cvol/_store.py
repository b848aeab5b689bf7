"""Storage of coefficients: in memory, or in a file that is read in parts.

Any box of samples of a .cvol file of rank 3 in DCT blocks is read and decoded without the rest, in bricks (64^3
samples by default). The bricks of the last box stay in memory, so that neighbouring slices are read once.
"""

from __future__ import annotations

import contextlib
import ctypes as c
import math
import os
import threading
from typing import Any, Optional

from . import _abi
from ._call import ArgumentError, Call, Error, Handle, MissingFileError, out_pointer, path_bytes
from ._geometry import copy_grid

_free = c.CDLL(None).free  # of memory that the library allocated with malloc
_free.argtypes, _free.restype = [c.c_void_p], None

REACH = 2  # samples at a face of a brick that also need the next brick: blocks overlap through filters
Box = tuple[tuple[int, int, int], tuple[int, int, int]]


def output_bytes(path: Any) -> bytes:
    """The path of a .cvol file to write, as bytes. ArgumentError: its ending is that of another format, as of the file
    that the volume was opened from."""
    name = path_bytes(path)
    for ending in _abi.functions["volume_formats"]().split():
        if name.lower().endswith(ending):
            raise ArgumentError(f"{os.fspath(path)}: a .cvol file has no name that ends in {ending.decode()}: give "
                                "another name, or write that format by cvol.write")  # fmt: skip
    return name


def identity(path: str) -> tuple[int, ...]:
    status = os.stat(path)
    return (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)


def _widen(begin: int, end: int, n: int, brick: int) -> tuple[int, int]:
    """The largest range of an axis that needs the same bricks as begin .. end - 1."""
    first, last = max(begin - REACH, 0) // brick, (end - 1 + REACH) // brick
    low = first * brick + REACH if first else 0
    high = (last + 1) * brick - REACH
    return min(low, begin), max(end, high if high + REACH < n else n)


def info_of(pointer: int) -> Any:
    info = _abi.ArrayInfo()
    _abi.functions["array_get_info"](c.byref(info), pointer)
    return info


class Store:
    """The coefficients of one volume. `grid`, `rank`, `transform` and `block` are set at once."""

    def __init__(self, handle: Handle, path: Optional[str] = None, place: tuple[int, int] = (0, 0)) -> None:
        """handle: the whole array, or, of the file `path`, at least the first sample; place: time and channel."""
        self.path = path
        self.place = place
        self._lock = threading.Lock()
        self._closed = False
        self._whole: Optional[Handle] = handle
        self._part: Optional[Handle] = None
        self._part_box: Optional[Box] = None
        self._found: tuple[int, ...] = ()
        self._levels: dict[int, Handle] = {}
        with handle as pointer:
            self.grid = copy_grid(_abi.functions["array_grid"](pointer).contents)
            self.info = info_of(pointer)
            text = _abi.functions["array_attributes"](pointer)
        self.attributes = None if text is None else text.decode()
        self.changed = False  # differs from the file
        self.rank, self.transform, self.block = self.info.rank, self.info.transform, self.info.block

    @classmethod
    def open(cls, path: str, place: tuple[int, int] = (0, 0)) -> "Store":
        zero, one = _abi.Size3(0, 0, 0), _abi.Size3(1, 1, 1)
        part = _abi.FilePart(begin=c.addressof(zero), end=c.addressof(one), time=place[0], channel=place[1])
        out = out_pointer()
        with Call() as call:
            call("array_read_part", c.byref(out), None, path_bytes(path), c.byref(part), path=path)
            self = cls(Handle(out.value or 0, "array_free", "the volume"), path, place)
        self._found = identity(path)
        if self.rank == 3 and self.transform == 1 and self.block:
            self._part, self._part_box = self._whole, ((0, 0, 0), (1, 1, 1))
            self._whole = None
        return self

    @classmethod
    def from_bytes(cls, data: bytes, name: str = "the bytes") -> "Store":
        """Reads the bytes of a .cvol file of one volume. name: for messages."""
        out = out_pointer()
        with Call() as call:
            call("array_read_memory", c.byref(out), c.c_char_p(data), len(data), name.encode())
            return cls(Handle(out.value or 0, "array_free", "the volume"))

    def to_bytes(self) -> bytes:
        """The bytes of a .cvol file."""
        out, size = out_pointer(), c.c_size_t()
        with self.whole() as array, Call() as call:
            call("array_write_memory", array, c.byref(out), c.byref(size))
            try:
                return c.string_at(out.value or 0, size.value)
            finally:
                _free(out)

    def recipe(self) -> tuple[Any, ...]:
        """A function and its arguments, which make this store again, in another process as well: by the place of the
        file, or by its bytes."""
        if self.path is None or self.changed:
            return Store.from_bytes, self.to_bytes(), "the pickled volume"
        return Store.reopen, os.path.abspath(self.path), self.place, self._found[2:]

    @classmethod
    def reopen(cls, path: str, place: tuple[int, int], found: tuple[int, ...]) -> "Store":
        """Opens a file that must have the size and time of change `found`."""
        self = cls.open(path, place)
        self._check_same(found)
        return self

    def _check_same(self, found: tuple[int, ...]) -> None:
        if self._found[2:] != found:
            raise Error(f"{self.path}: was changed after the volume was pickled: open it again")

    def detach(self) -> None:
        """Reads all coefficients; from now on the file is not needed."""
        self.whole()
        self.path = None

    def at_level(self, level: int) -> Handle:
        """The coefficients of a level of a volume in DCT blocks; all of them if it is not in a file, or lossless: a
        lossless file has only coarse coefficients, and their differences from the samples."""
        if self.path is None or self.changed or self.info.psnr_db == math.inf:
            return self.whole()
        with self._lock:
            self._check()
            if level not in self._levels:
                self._levels[level] = self._read(_abi.FilePart(level=level))
            return self._levels[level]

    def _check(self) -> None:
        if self._closed:
            raise ValueError("the volume is closed")

    def _read(self, part: Any) -> Handle:
        """Reads a part of the volume from the file."""
        assert self.path is not None
        part.time, part.channel = self.place
        out = out_pointer()
        self._check_file()
        with Call() as call:
            call("array_read_part", c.byref(out), None, path_bytes(self.path), c.byref(part), path=self.path)
            handle = Handle(out.value or 0, "array_free", "the volume")
        self._check_file()
        return handle

    def _check_file(self) -> None:
        try:
            found = identity(self.path or "")
        except OSError as error:
            raise MissingFileError(f"{self.path}: {error.strerror}") from None
        if found != self._found:
            raise Error(f"{self.path}: was changed after it was opened: open it again")

    def whole(self) -> Handle:
        """All coefficients; the first call reads them from the file."""
        with self._lock:
            self._check()
            if self._whole is None:
                self._whole = self._read(_abi.FilePart())
                with self._whole as pointer:
                    self.info = info_of(pointer)
                self._drop_part()
            return self._whole

    def _drop_part(self) -> None:
        if self._part is not None and self._part is not self._whole:
            self._part.close()
        self._part = self._part_box = None

    def for_box(
        self, begin: tuple[int, int, int], end: tuple[int, int, int]
    ) -> contextlib.AbstractContextManager[int]:
        """Coefficients of (at least) a box of samples [begin, end) (x, y, z), for a ``with`` block."""
        with self._lock:
            self._check()
            if self._whole is not None:
                return self._whole.hold()
            held = self._part_box
            if self._part and held and all(held[0][a] <= begin[a] and end[a] <= held[1][a] for a in range(3)):
                return self._part.hold()
            wide = [_widen(begin[a], end[a], int(self.grid.dims[a]), int(self.info.brick[a])) for a in range(3)]
            first, last = tuple(w[0] for w in wide), tuple(w[1] for w in wide)
            from_, to = _abi.Size3(*first), _abi.Size3(*last)
            part = _abi.FilePart(begin=c.addressof(from_), end=c.addressof(to))
            handle = self._read(part)
            if self._part is not None:
                self._part.close()
            self._part, self._part_box = handle, (first, last)  # type: ignore[assignment]
            return handle.hold()

    def refresh(self) -> None:
        """Call it after the properties of the array in memory changed."""
        with self.whole() as pointer:
            self.info = info_of(pointer)

    @property
    def name(self) -> str:
        """The path, for messages."""
        return self.path or ""

    @property
    def closed(self) -> bool:
        return self._closed

    def close(self) -> None:
        """Frees the memory when running calls of other threads have ended."""
        with self._lock:
            self._closed = True
            for handle in (self._whole, self._part, *self._levels.values()):
                if handle is not None:
                    handle.close()
            self._whole = self._part = None
